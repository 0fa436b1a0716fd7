//! The report: one page of HTML, and a CSV file of every number in it.

use std::path::Path;

use underbrush_classifier::report::{Page, Table};

use super::campaign::{AUTHORS, MODERN};
use super::online::Online;
use super::results::Results;
use super::snapshot::Moment;
use super::thresholds::Thresholds;
use super::{data, figures, skin_map, tables, words};
use crate::failure::Failure;
use crate::output;
use crate::picture::{self, TaxelMark};

mod beyond;

/// Page and tables under way.
struct Report<'a> {
    results: &'a Results,
    online: &'a Online,
    thresholds: &'a Thresholds,
    page: Page,
    tables: Vec<Table>,
}

/// Writes `index.html` and the folder `csv` beside it.
pub fn write(
    folder: &Path,
    results: &Results,
    online: &Online,
    thresholds: &Thresholds,
    [general, outlier]: &[Option<Moment>; 2],
) -> Result<(), Failure> {
    let mut report = Report {
        results,
        online,
        thresholds,
        page: Page::new("Leaf or trunk? A tactile paper run again in simulation"),
        tables: Vec::new(),
    };
    report.what_was_run();
    report.training_data();
    report.table_1();
    report.campaigns();
    report.confusion();
    report.example_trials();
    report.over_time();
    report.engineered();
    let published = "taxels that touch leaves are marked with green dots while the robot reaches.";
    report.moment("Fig. 12: a moment of a reach", published, general.as_ref());
    report.truncation();
    let published = "a foam roll stands in the foliage.";
    report.moment("Fig. 14: the foam roll in the foliage", published, outlier.as_ref());
    report.outliers();
    report.classifiers();
    report.splits();
    report.ablation();
    for table in &report.tables {
        let path = folder.join("csv").join(format!("{}.csv", table.name));
        output::write_file(&path, table.csv().as_bytes())?;
    }
    output::write_file(&folder.join("index.html"), report.page.html().as_bytes())
}

impl Report<'_> {
    /// Shows a table and keeps it for its CSV file.
    fn table(&mut self, table: Table) {
        self.page.table(&table);
        self.tables.push(table);
    }

    /// Keeps a table that is too long to be shown.
    fn numbers(&mut self, table: Table) {
        self.page.numbers(&table);
        self.tables.push(table);
    }

    fn what_was_run(&mut self) {
        let Results {
            program,
            seed,
            quick,
            timing,
            ..
        } = self.results;
        self.page.section("What was run");
        self.page.paragraph(
            "Bhattacharjee, Kapusta, Rehg and Kemp (2013) let a compliant arm with tactile skin reach through artificial \
             foliage and told leaves from trunks by hidden Markov models. Here the robot is simulated; all else follows \
             the paper. Each section gives the paper's result, ours, and the difference.",
        );
        let size = if *quick {
            ", a third of the paper's reaches (--quick)"
        } else {
            ""
        };
        self.page.list(&[
            format!("program: underbrush {program}"),
            format!("seed: {seed}{size}"),
            format!(
                "machine: {}, {} cores, {} threads used; {:.0} s in all",
                timing.processor, timing.cores, timing.threads, timing.wall_s
            ),
        ]);
        self.table(tables::stages(self.results));
    }

    fn training_data(&mut self) {
        let reaches = &self.results.reaches;
        let outcomes: Vec<String> = reaches
            .outcomes
            .iter()
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        self.page.section("Training data");
        self.page.published(
            "10 reaches in a leaf-only and 25 in a trunk-only environment gave 288 and 324 trials by component, 496 and \
             582 by taxel.",
        );
        self.page.paragraph(&format!(
            "{} reaches, {:.0} s of simulated time; {} touched something. Outcomes: {}.",
            reaches.count,
            reaches.simulated_s,
            reaches.touched,
            outcomes.join(", ")
        ));
        self.page.paragraph(&words::trials(self.results));
        self.table(tables::trials_per_reach(self.results));
    }

    fn table_1(&mut self) {
        self.page.section("Table I: cross-validation");
        self.page.published(
            "taxels are told apart better than components, force alone at least as well as force and motion, and with 10 \
             or 20 hidden states better than with 5; the best is 81.4 %.",
        );
        self.page.paragraph(
            "Two folds by position, equal priors, the better model wins. The authors' recipe scores by the Viterbi path on \
             unscaled features, the modern one by the forward likelihood on z-scores. Intervals are 95 % by resampling \
             whole reaches, since the trials of one reach depend on each other.",
        );
        for recipe in [AUTHORS, MODERN] {
            self.page.paragraph(&words::table_1(self.results, recipe));
        }
        let charts = figures::table_1(self.results);
        self.page.figure(
            "Table I with the paper's figures; whiskers are the 95 % intervals by reach.",
            &charts,
        );
        for recipe in [AUTHORS, MODERN] {
            // On the page by recipe, in the file all together.
            self.page.table(&tables::table_1(self.results, recipe));
        }
        self.tables.push(tables::table_1_all(self.results));
        self.page.paragraph("The paper's orderings:");
        self.page.list(&words::orderings(&self.results.orderings));
        self.numbers(tables::orderings(
            "orderings",
            "The paper's orderings",
            &self.results.orderings,
        ));
    }

    fn campaigns(&mut self) {
        let Some(campaigns) = &self.results.campaigns else {
            return;
        };
        self.page.section("Table I over many campaigns");
        self.page.paragraph(&format!(
            "Means of {} independent campaigns, each with clutter, goals and noise of its own; whiskers are one standard \
             deviation over campaigns.",
            campaigns.seeds.len()
        ));
        for recipe in [AUTHORS, MODERN] {
            if let Some(text) = words::campaigns(self.results, recipe) {
                self.page.paragraph(&text);
            }
        }
        let charts = figures::campaigns(self.results);
        self.page.figure(
            "Table I as the mean of all campaigns, with the paper's figures.",
            &charts,
        );
        let caption = "The paper's orderings on the mean campaign";
        let orderings = tables::orderings("campaign_orderings", caption, &campaigns.orderings);
        self.page.list(&words::orderings(&campaigns.orderings));
        let tables = [
            tables::campaigns(self.results),
            Some(orderings),
            tables::campaign_trials(self.results),
        ];
        tables.into_iter().flatten().for_each(|table| self.table(table));
    }

    fn confusion(&mut self) {
        self.page.section("Figs. 6 and 7: confusion of taxels, 20 states");
        self.page
            .published("the matrices are shown as figures for force alone and for force and motion.");
        let captions = [
            ("figure_6", "Fig. 6: force", &self.results.figure_6),
            ("figure_7", "Fig. 7: force and motion", &self.results.figure_7),
        ];
        for (name, caption, matrix) in captions {
            self.table(tables::confusion(
                name,
                &format!("{caption}, trials, the authors' recipe"),
                matrix,
            ));
        }
    }

    fn example_trials(&mut self) {
        self.page.section("Fig. 5: force and motion of a trial");
        self.page.published(
            "on a trunk the force rises faster and higher, and the motion is larger on a leaf, which the arm can bend.",
        );
        let parts: Vec<String> = self
            .results
            .figure_5
            .iter()
            .map(|example| {
                format!(
                    "{}: peak {:.2} N, motion up to {:.1} cm in {:.2} s",
                    example.category,
                    example.peak_force_n,
                    100.0 * example.farthest_motion_m,
                    example.samples as f64 / 100.0
                )
            })
            .collect();
        let caption = format!(
            "One taxel trial of each category: among those of a second or more the one with the median peak force. {}.",
            parts.join("; ")
        );
        self.page.figure(&caption, &figures::figure_5(self.results));
        self.numbers(tables::figure_5(self.results));
    }

    fn over_time(&mut self) {
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

    fn engineered(&mut self) {
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

    fn moment(&mut self, section: &str, published: &str, moment: Option<&Moment>) {
        let Some(moment) = moment else { return };
        let Some(grid) = moment.layout.patches.get(moment.patch).and_then(|patch| patch.grid) else {
            return;
        };
        self.page.section(section);
        self.page.published(published);
        let mark = |(taxel, verdict): (&usize, &underbrush_classifier::decision::Verdict)| TaxelMark {
            place: (moment.patch, *taxel),
            look: skin_map::mark_of(verdict),
        };
        let marks: Vec<TaxelMark> = moment.verdicts.iter().map(mark).collect();
        let description = format!("Forearm with {} taxels in contact, marked by verdict.", marks.len());
        let mut charts = picture::close_ups(&moment.snapshot, &moment.layout, &marks, &description);
        charts.push(skin_map::svg(grid, &moment.verdicts));
        let caption = format!(
            "Scene {}, draw {}, {:.2} s after the start: the moment with most taxels in contact. Green triangle leaf, brown \
             square trunk, red cross outlier, blue ring uncertain; taxels on the far side are seen through the arm. Leaves \
             are green, trunks brown, foam blocks sand-coloured, a foam roll is red.",
            moment.scene, moment.reach_index, moment.snapshot.frame.time_s
        );
        self.page.figure(&caption, &charts);
    }

    fn truncation(&mut self) {
        self.page.section("Fig. 13: truncated trials");
        self.page
            .published("truncating trials to 200, 150, 100 and 50 samples has no significant effect.");
        self.page.paragraph(&words::truncation(self.results));
        let caption = "Fig. 13: taxels, force, the authors' recipe; whiskers are the 95 % intervals by reach.";
        self.page.figure(caption, &[figures::figure_13(self.results)]);
        self.table(tables::figure_13(self.results));
    }

    fn outliers(&mut self) {
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
            let caption = "Fig. 15: taxels by verdict over time; shaded where the forearm truly touches the roll, a leaf or \
                           a trunk.";
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
