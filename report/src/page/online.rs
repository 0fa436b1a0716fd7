//! Sections on verdicts while the arm moves.

use crate::drawing::slug;
use underbrush_classifier::decision::Verdict;

use super::Report;
use crate::picture::{self, TaxelMark};
use crate::{figures, skin_map, tables, words};
use underbrush_experiments::data;
use underbrush_experiments::snapshot::Moment;

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
        let total = reach.stream.total();
        self.page.paragraph(&format!(
            "This is the first reach in mixed clutter in which the forearm touches both leaf and trunk: draw {}. {} of {} \
             drawn did. The models have 10 states and see force alone; a taxel is uncertain below a margin of {} nats. The truth \
             of a taxel is the object that presses most on it. In {} of {} taxel frames nothing presses (strays, crosstalk \
             and creep): these have no truth and are counted apart.",
            reach.reach_index,
            self.online.mixed.len(),
            self.online.mixed_drawn,
            data::UNCERTAIN_BELOW_NATS,
            total.unknown,
            total.unknown + total.judged()
        ));
        if let Some(seconds) = self.results.timing.figure_8_seconds_per_100_taxels {
            let median = self
                .results
                .timing
                .figure_8_median_seconds_per_100_taxels
                .unwrap_or(f64::NAN);
            self.page.paragraph(&format!(
                "With both models a new sample for 100 taxels takes {:.1} µs on average over the reach and {:.1} µs in the \
                 median frame. The paper's mean is {} s on a laptop of 2011. Wall times are the only results here that differ \
                 from run to run.",
                1e6 * seconds,
                1e6 * median,
                self.results.timing.figure_8_paper_seconds_per_100_taxels
            ));
        }
        let used = &self.results.figure_9;
        if let (Some(mean), Some(all)) = (used.mean_samples_used, used.mean_over_reaches) {
            self.page.paragraph(&format!(
                "Samples used is the number of samples since contact at which a taxel's present verdict was made, 0 while it is \
                 uncertain, averaged over the taxels in contact. The mean over this reach is {mean:.1} ({:+.1} against the \
                 paper); the mean of {} reaches is {all:.1}.",
                mean - used.paper,
                used.reaches
            ));
        }
        if let Some(shares) = &self.results.figure_10 {
            self.page.paragraph(&format!(
                "Over the whole reach {:.1} % of the judged taxel frames are correct, {:.1} % misclassified and {:.1} % \
                 uncertain.",
                shares.correct_percent, shares.misclassified_percent, shares.uncertain_percent
            ));
        }
        let charts = [
            figures::figure_8(reach, self.results),
            figures::figure_9(reach, self.results),
        ];
        self.page.figure("Figs. 8 and 9.", &charts);
        self.page.figure(
            "Fig. 10: taxels in contact by verdict. The last chart shows those that nothing presses on (strays, creep, \
                 crosstalk); they have no truth and are in none of the others.",
            &figures::figure_10(reach),
        );
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
            "Each scene is drawn until, by ground truth, the forearm touches its category and nothing else, and feels it. {} \
             of {} scenes gave such a reach, in {drawn} draws. In {} of them more taxels are correct than misclassified. As \
             in the paper the truth of every taxel is the category of the scene, also of those that nothing presses on; \
             the table gives their share as untouched.",
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
            look: skin_map::mark_of(verdict, moment.pressed.contains(taxel)),
        };
        let marks: Vec<TaxelMark> = moment.verdicts.iter().map(mark).collect();
        let description = format!("Forearm with {} taxels in contact, marked by verdict.", marks.len());
        let name = slug(&moment.scene);
        let mut charts = picture::close_ups(&name, &moment.snapshot, &moment.layout, &marks, &description);
        let skin = format!("{name}-skin");
        charts.push(skin_map::svg(&skin, grid, &moment.verdicts, &moment.pressed));
        let untouched = moment.verdicts.keys().filter(|taxel| !moment.pressed.contains(taxel));
        let caption = format!(
            "Scene {}, draw {}, {:.2} s after the start: the moment with most taxels in contact. Green triangle leaf, brown \
             square trunk, red cross outlier, blue ring uncertain. Grey marks of the same shapes are taxels that nothing \
             presses on (strays, creep, crosstalk): {} of {} here. Taxels on the far side are seen through the arm. Leaves \
             are green, trunks brown, foam blocks sand-coloured, a foam roll is red.",
            moment.scene,
            moment.reach_index,
            moment.snapshot.frame.time_s,
            untouched.count(),
            moment.verdicts.len()
        );
        self.page.figure(&caption, &charts);
    }

    pub(super) fn outliers(&mut self) {
        self.page.section("Fig. 15: an outlier");
        self.page.published(
            "a foam roll is found to be an outlier in both of its phases of contact, with some taxels uncertain and few \
             misclassified; a margin over 80 is a category, 15 to 80 an outlier, under 15 uncertain. No outlier is trained.",
        );
        let outliers = &self.results.figure_15;
        self.page.paragraph(&format!(
            "{} of {} reaches drawn meet the roll first and then leaf or trunk, by ground truth.",
            outliers.reaches, outliers.drawn
        ));
        let charts = figures::figure_15(self.online);
        if !charts.is_empty() {
            let caption = "Fig. 15: taxels by verdict over time, means of half a second, stacked. The dotted line shows how \
                           many of them nothing presses on (strays, creep, crosstalk). The strips below show when the forearm \
                           truly touches the roll, a trunk or a leaf.";
            self.page.figure(caption, &charts);
        }
        self.numbers(tables::figure_15(self.online));
        self.page.paragraph(&words::thresholds(self.thresholds));
        if let Some(text) = words::chosen_rule_online(&self.results.figure_15.detection) {
            self.page.paragraph(&text);
        }
        self.table(tables::detection(self.results));
        let charts = figures::roc(self.thresholds);
        if !charts.is_empty() {
            if let Some(area) = self.results.roc.outlier_area {
                self.page.paragraph(&words::roc(area));
            }
            let caption = "What every threshold would do. Left: leaves found against trunks mistaken for leaves as the least \
                           margin of a leaf falls, on training trials held out by reach. Right: the roll found against leaves and \
                           trunks mistaken for it as the greatest margin of an outlier rises, on the outlier reaches.";
            self.page.figure(caption, &charts);
            self.numbers(tables::roc(self.thresholds));
        }
    }
}
