//! Sections on trials cut from the training reaches, and on models tested on them.

use super::Report;
use crate::{figures, tables, words};
use underbrush_experiments::campaign::{AUTHORS, MODERN};

impl Report<'_> {
    pub(super) fn training_data(&mut self) {
        let reaches = &self.results.reaches;
        self.page.section("Training data");
        self.page.published(
            "10 reaches in a leaf-only and 25 in a trunk-only environment gave 288 and 324 trials by component, 496 and \
             582 by taxel.",
        );
        self.page.paragraph(&format!(
            "{} reaches, {:.0} s of simulated time; {}; {}.",
            reaches.count,
            reaches.simulated_s,
            reaches.ends.goals,
            reaches.ends.touched_text()
        ));
        self.page.paragraph(&words::trials(self.results));
        self.page
            .paragraph(&words::untouched(&self.results.measurement.trials_per_reach));
        self.table(tables::trials_per_reach(self.results));
    }

    pub(super) fn table_1(&mut self) {
        self.page.section("Table I: cross-validation");
        self.page.published(
            "taxels are told apart better than components, force alone at least as well as force and motion, and with 10 \
             or 20 hidden states better than with 5; the best is 81.4 %.",
        );
        self.page.paragraph(
            "Two folds by position, equal priors; the model with the higher score wins. The authors' recipe scores by the \
             Viterbi path on unscaled features, the modern one by the forward likelihood on z-scores. Intervals are 95 % by \
             resampling whole reaches, since the trials of one reach depend on each other.",
        );
        self.page.paragraph(&words::choices(&words::all_seeds(self.results)));
        self.page.paragraph(&words::baselines(self.results));
        for recipe in [AUTHORS, MODERN] {
            self.page
                .paragraph(&words::table_1(&self.results.measurement.table_1, recipe));
        }
        let charts = figures::table_1(self.results);
        self.page.figure(
            "Table I with the paper's figures and the majority baseline; whiskers are the 95 % intervals by reach.",
            &charts,
        );
        for recipe in [AUTHORS, MODERN] {
            // On the page by recipe, in the file all together.
            self.page.table(&tables::table_1(self.results, recipe));
        }
        self.tables.push(tables::table_1_all(self.results));
        self.table(tables::table_1_by_touch(self.results));
        self.page.paragraph("The paper's orderings:");
        self.page.list(&words::orderings(&self.results.orderings));
        self.numbers(tables::orderings(
            "orderings",
            "The paper's orderings",
            &self.results.orderings,
        ));
    }

    pub(super) fn campaigns(&mut self) {
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
            "Table I as the mean of all campaigns, with the paper's figures and the majority baseline.",
            &charts,
        );
        let caption = "The paper's orderings on the mean campaign";
        self.page.paragraph(&format!("{caption}:"));
        self.page.list(&words::orderings(&campaigns.orderings));
        self.numbers(tables::orderings("campaign_orderings", caption, &campaigns.orderings));
        for recipe in [AUTHORS, MODERN] {
            if let Some(table) = tables::campaigns(self.results, recipe) {
                self.page.table(&table);
            }
        }
        self.tables.extend(tables::campaigns_all(self.results));
        if let Some(table) = tables::campaigns_by_touch(self.results) {
            self.table(table);
        }
        if let Some(table) = tables::campaign_trials(self.results) {
            self.table(table);
        }
    }

    pub(super) fn confusion(&mut self) {
        self.page.section("Figs. 6 and 7: confusion of taxels, 20 states");
        self.page
            .published("the matrices are shown as figures for force alone and for force and motion.");
        let captions = [
            ("figure_6", "Fig. 6: force", &self.results.figure_6),
            ("figure_7", "Fig. 7: force and motion", &self.results.figure_7),
        ];
        for (name, caption, matrix) in captions {
            let figures = matrix.accuracy().map_or(String::new(), |own| {
                format!(
                    ": accuracy {:.1} %, balanced {:.1} %, majority baseline {:.1} %",
                    100.0 * own.accuracy,
                    100.0 * own.balanced_accuracy.unwrap_or(f64::NAN),
                    100.0 * own.majority_baseline
                )
            });
            self.table(tables::confusion(
                name,
                &format!("{caption}, trials, the authors' recipe{figures}"),
                matrix,
            ));
        }
    }

    pub(super) fn example_trials(&mut self) {
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
        self.page.paragraph(&words::figure_5(&self.results.figure_5_medians));
        self.page.figure(&caption, &figures::figure_5(self.results));
        self.numbers(tables::figure_5(self.results));
    }

    pub(super) fn truncation(&mut self) {
        self.page.section("Fig. 13: truncated trials");
        self.page
            .published("truncating trials to 200, 150, 100 and 50 samples has no significant effect.");
        self.page.paragraph(&words::truncation(self.results));
        let caption = "Fig. 13: taxels, force, the authors' recipe; whiskers are the 95 % intervals by reach.";
        self.page.figure(caption, &[figures::figure_13(self.results)]);
        self.table(tables::figure_13(self.results));
        self.table(tables::figure_13_by_touch(self.results));
    }
}
