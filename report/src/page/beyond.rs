//! Sections on what the paper has not.

use super::Report;
use crate::{figures, tables, words};
use underbrush_experiments::data;

impl Report<'_> {
    pub(super) fn classifiers(&mut self) {
        self.page.section("Other classifiers, and how fast they decide");
        self.page.published(
            "the best of Table I is 81.4 %, taxels by force with 20 states, two folds by position; the authors' earlier \
             method was nearest neighbours on principal components of a fixed window.",
        );
        self.page.paragraph(
            "All classifiers here are tested on whole reaches that they were not trained on, which is stricter. Seven are \
             compared on the same folds. The hidden Markov models with force and motion and logistic regression without \
             region see the same of a contact: force and motion of one taxel. The last also sees the contact region around \
             the taxel.",
        );
        self.page.paragraph(&words::classifiers(self.results));
        self.table(tables::classifiers(self.results));
        self.table(tables::classifiers_by_touch(self.results));
        let campaigns = [
            tables::campaign_classifiers(self.results),
            tables::campaign_classifiers_by_touch(self.results),
        ];
        campaigns.into_iter().flatten().for_each(|table| self.table(table));
        self.page.paragraph(
            "The charts ask for a verdict after a number of samples since contact; a contact that ended before keeps its last \
             verdict. The first chart is of the trials of Table I, which last 20 samples or more. Its points before 20 are \
             therefore of contacts that are known to go on, which nobody knows at that moment. The second is of all contacts, \
             also the shorter ones. In both, the classifiers learned from the longer trials of the other reaches.",
        );
        self.page.paragraph(&words::speeds(self.results));
        let charts = figures::by_samples(self.results);
        if !charts.is_empty() {
            self.page
                .figure("Accuracy on all trials against samples since contact.", &charts);
        }
        self.numbers(tables::by_samples(self.results));
    }

    pub(super) fn splits(&mut self) {
        self.page.section("Other arms and speeds");
        self.page.published(
            "all reaches are of one arm at one speed; whether what was learned holds for others is an open question of the \
             follow-up study (arXiv 1409.4972).",
        );
        self.page.paragraph(
            "The training scenes with the arm half or twice as stiff, and with the hand half or twice as fast; goals and \
             clutter are the same at every setting. Learned from one half of the reaches at one setting, tested on the other \
             half at each setting, and the other way round: no clutter is met in learning and in testing.",
        );
        self.page.list(&words::splits(self.results));
        for classifier in self.results.split_classifiers() {
            self.page.table(&tables::splits_of(self.results, classifier));
        }
        // The tables above link to it.
        self.tables.push(tables::splits(self.results));
    }

    pub(super) fn ablation(&mut self) {
        self.page.section("What each part of reality is worth");
        self.page.paragraph(&words::ablation(self.results));
        if self.results.ablation.is_empty() {
            return;
        }
        let changes: Vec<String> = data::CHANGES
            .iter()
            .map(|(name, what, _)| format!("{name}: {what}"))
            .collect();
        self.page.list(&changes);
        self.table(tables::ablation(self.results));
    }
}
