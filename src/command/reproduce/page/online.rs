//! Sections on verdicts while the arm moves.

use underbrush_classifier::decision::Verdict;

use super::super::snapshot::Moment;
use super::super::{data, figures, skin_map, tables, words};
use super::Report;
use crate::picture::{self, TaxelMark};

impl Report<'_> {
    pub(super) fn over_time(&mut self) {
        self.page.section("Figs. 8 to 10: online verdicts over time");
        self.page.published(
            "0.83 s of computation per 100 taxels in contact; 11.9 samples used on average, 0 where uncertain; more taxels \
             correct than misclassified, few uncertain.",
        );
        let Some(reach) = self.online.shown() else {
            self.page
                .paragraph("No general reach was found in which the forearm touches leaf and trunk.");
            return;
        };
        self.page.paragraph(&format!(
            "The first general reach in mixed clutter in which the forearm touches both leaf and trunk (draw {}; {} of {} \
             drawn did), models with 10 states and force alone, uncertain below a lead of {} nats. The truth of a taxel is the object that \
             presses most on it; {} of {} taxel frames have none (strays, crosstalk and creep) and are not judged.",
            reach.reach_index,
            self.online.mixed.len(),
            self.online.mixed_drawn,
            data::UNCERTAIN_BELOW_NATS,
            reach.stream.total().unknown,
            reach.stream.total().unknown + reach.stream.total().judged()
        ));
        if let Some(seconds) = self.results.timing.figure_8_seconds_per_100_taxels {
            let median = self
                .results
                .timing
                .figure_8_median_seconds_per_100_taxels
                .unwrap_or(f64::NAN);
            self.page.paragraph(&format!(
                "A new sample for 100 taxels takes {:.1} µs with both models on average over the reach, {:.1} µs in the median \
                 frame; the paper's mean is {} s on a laptop of 2011. Wall times are the one result here that differs from \
                 run to run.",
                1e6 * seconds,
                1e6 * median,
                self.results.timing.figure_8_paper_seconds_per_100_taxels
            ));
        }
        let used = &self.results.figure_9;
        if let (Some(mean), Some(all)) = (used.mean_samples_used, used.mean_over_reaches) {
            self.page.paragraph(&format!(
                "Samples used are counted as the number of samples since contact at which a taxel's present verdict was \
                 made, 0 while it is uncertain, averaged over the taxels in contact. The mean over this reach is {mean:.1} \
                 ({:+.1} against the paper), the mean of {} reaches {all:.1}.",
                mean - used.paper,
                used.reaches
            ));
        }
        if let Some(shares) = &self.results.figure_10 {
            self.page.paragraph(&format!(
                "Over the whole reach {:.1} % of the judged taxels in contact are correct, {:.1} % misclassified, {:.1} % \
                 uncertain.",
                shares.correct_percent, shares.misclassified_percent, shares.uncertain_percent
            ));
        }
        let charts = [
            figures::figure_8(reach, self.results),
            figures::figure_9(reach, self.results),
        ];
        self.page.figure("Figs. 8 and 9.", &charts);
        self.page
            .figure("Fig. 10: taxels in contact by verdict.", &figures::figure_10(reach));
        self.numbers(tables::figure_8_times(self.online));
        self.numbers(tables::figures_9_and_10(self.online));
    }

    pub(super) fn engineered(&mut self) {
        self.page.section("Fig. 11: ten engineered reaches");
        self.page.published(
            "five reaches touch only leaves and five only trunks; misclassified taxels are few, at the price of uncertain \
             ones.",
        );
        let reaches = &self.results.figure_11;
        let found: Vec<_> = reaches.iter().filter_map(|reach| reach.shares.as_ref()).collect();
        let drawn: u64 = reaches.iter().map(|reach| reach.drawn).sum();
        self.page.paragraph(&format!(
            "Each scene is drawn until the forearm touches its category and nothing else, by ground truth, and feels it: \
             {} of {} scenes gave such a reach in {drawn} draws. In {} of them more taxels are correct than misclassified.",
            found.len(),
            reaches.len(),
            found.iter().filter(|shares| shares.correct_percent > shares.misclassified_percent).count()
        ));
        let caption = "Fig. 11: verdicts on all taxels in contact, over all frames of a reach.";
        self.page.figure(caption, &[figures::figure_11(self.results)]);
        self.table(tables::figure_11(self.results));
    }

    pub(super) fn moment(&mut self, section: &str, published: &str, moment: Option<&Moment>) {
        let Some(moment) = moment else { return };
        let Some(grid) = moment.layout.patches.get(moment.patch).and_then(|patch| patch.grid) else {
            return;
        };
        self.page.section(section);
        self.page.published(published);
        let mark = |(taxel, verdict): (&usize, &Verdict)| TaxelMark {
            place: (moment.patch, *taxel),
            look: skin_map::mark_of(verdict),
        };
        let marks: Vec<TaxelMark> = moment.verdicts.iter().map(mark).collect();
        let description = format!("Forearm with {} taxels in contact, marked by verdict.", marks.len());
        let mut charts = picture::close_ups(&moment.scene, &moment.snapshot, &moment.layout, &marks, &description);
        charts.push(skin_map::svg(&format!("{}-skin", moment.scene), grid, &moment.verdicts));
        let caption = format!(
            "Scene {}, draw {}, {:.2} s after the start: the moment with most taxels in contact. Green triangle leaf, brown \
             square trunk, red cross outlier, blue ring uncertain; taxels on the far side are seen through the arm. Leaves \
             are green, trunks brown, foam blocks sand-coloured, a foam roll is red.",
            moment.scene, moment.reach_index, moment.snapshot.frame.time_s
        );
        self.page.figure(&caption, &charts);
    }

    pub(super) fn outliers(&mut self) {
        self.page.section("Fig. 15: an outlier");
        self.page.published(
            "a foam roll is found to be an outlier in both of its phases of contact, with some taxels uncertain and few \
             misclassified; a lead over 80 is a category, 15 to 80 an outlier, under 15 uncertain. No outlier is trained.",
        );
        let outliers = &self.results.figure_15;
        self.page.paragraph(&format!(
            "{} of {} reaches drawn meet the roll first and then leaf or trunk, by ground truth.",
            outliers.reaches, outliers.drawn
        ));
        let charts = figures::figure_15(self.online);
        if !charts.is_empty() {
            let caption = "Fig. 15: taxels by verdict over time, means of half a second, one upon the other; the strips under \
                           them show when the forearm truly touches the roll, a trunk or a leaf.";
            self.page.figure(caption, &charts);
        }
        self.numbers(tables::figure_15(self.online));
        self.page.paragraph(&words::thresholds(self.thresholds));
        self.table(tables::detection(self.results));
        let caption = "What any threshold on the lead would do: leaves found against trunks mistaken, on training trials held \
                       out by reach; the roll found by its small lead against leaves and trunks mistaken, on the outlier \
                       reaches.";
        let charts = figures::roc(self.thresholds);
        if !charts.is_empty() {
            self.page.figure(caption, &charts);
            self.numbers(tables::roc(self.thresholds));
        }
    }
}
