//! What each feature is worth to the networks.

use rand::{SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::contact_history::REGION_FEATURES;
use super::example::TaxelExample;
use super::network::{Network, Row, softmax};
use super::networks::{category_network, touched_network};
use super::taxel::TAXEL_FEATURES;
use super::training_rows::{FOLDS, TouchExamples};
use underbrush_recording::math;

/// What a feature is worth: how much worse the probabilities on held-out reaches are if its values are shuffled among
/// the rows (Breiman 2001). A feature that others can replace is worth little by this measure, even if it is
/// informative by itself.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeatureWorth {
    /// The network: `touched` (nothing against a touch) or `category`.
    pub network: &'static str,
    /// The feature.
    pub feature: &'static str,
    /// How much the mean negative log-probability of the true class rises, nats.
    pub log_loss_rise_nats: f64,
    /// How much the balanced accuracy falls, which is the mean over the true classes of the share of rows that get the
    /// right class.
    pub balanced_accuracy_fall: f64,
}

impl TouchExamples {
    /// What each feature is worth, the most valuable first within each network. Every reach is judged by networks that
    /// were fitted to other reaches. Empty if a known category touches the skin in fewer reaches than there are folds.
    pub fn feature_worth(&self) -> Vec<FeatureWorth> {
        let categories = self.categories();
        let folds = self.folds();
        if !self.fill(&folds) {
            return Vec::new();
        }
        let mut taxels = Shuffled::new(&TAXEL_FEATURES, 2);
        let mut regions = Shuffled::new(&REGION_FEATURES, categories.len());
        for fold in 0..FOLDS {
            let (own, others) = (self.of_fold(&folds, fold, true), self.of_fold(&folds, fold, false));
            let rows = own.iter().flat_map(|reach| &reach.taxels).filter(|row| row.is_regular).map(TaxelExample::row);
            taxels.add(&touched_network(&others), &rows.collect::<Vec<_>>());
            let rows = own.iter().flat_map(|reach| &reach.regions).filter(|row| row.is_regular);
            let rows = rows.map(|row| row.row(&categories));
            regions.add(&category_network(&others, &categories), &rows.collect::<Vec<_>>());
        }
        let mut worth = taxels.worth("touched");
        worth.extend(regions.worth("category"));
        worth
    }
}

/// Losses of the unchanged rows, and of the rows with each feature shuffled.
struct Shuffled<const INPUTS: usize> {
    names: &'static [&'static str; INPUTS],
    plain: Losses,
    shuffled: Vec<Losses>,
}

impl<const INPUTS: usize> Shuffled<INPUTS> {
    fn new(names: &'static [&'static str; INPUTS], classes: usize) -> Self {
        let none = Losses { log_loss: 0.0, right: vec![0.0; classes], total: vec![0.0; classes] };
        Shuffled { names, plain: none.clone(), shuffled: vec![none; INPUTS] }
    }

    fn add(&mut self, network: &Network, rows: &[Row<INPUTS>]) {
        for row in rows {
            self.plain.add(network, &row.features, row);
        }
        for (feature, losses) in self.shuffled.iter_mut().enumerate() {
            let mut values: Vec<f64> = rows.iter().map(|row| row.features[feature]).collect();
            values.shuffle(&mut ChaCha8Rng::seed_from_u64(0));
            for (row, value) in rows.iter().zip(values) {
                let mut features = row.features;
                features[feature] = value;
                losses.add(network, &features, row);
            }
        }
    }

    fn worth(&self, network: &'static str) -> Vec<FeatureWorth> {
        let of = |(feature, losses): (&&'static str, &Losses)| FeatureWorth {
            network,
            feature,
            log_loss_rise_nats: losses.mean_log_loss() - self.plain.mean_log_loss(),
            balanced_accuracy_fall: self.plain.balanced_accuracy() - losses.balanced_accuracy(),
        };
        let mut worth: Vec<FeatureWorth> = self.names.iter().zip(&self.shuffled).map(of).collect();
        worth.sort_by(|a, b| b.log_loss_rise_nats.total_cmp(&a.log_loss_rise_nats));
        worth
    }
}

/// Sums over rows, weighted.
#[derive(Clone)]
struct Losses {
    log_loss: f64,
    /// Right rows and all rows of each class.
    right: Vec<f64>,
    total: Vec<f64>,
}

impl Losses {
    fn add<const INPUTS: usize>(&mut self, network: &Network, features: &[f64; INPUTS], row: &Row<INPUTS>) {
        let mut scores = vec![0.0; self.total.len()];
        network.scores(features, &mut scores);
        let own = scores[row.class];
        let is_right = scores.iter().all(|other| *other <= own);
        softmax(&mut scores);
        self.log_loss -= row.weight * math::ln(scores[row.class].max(f64::MIN_POSITIVE));
        self.right[row.class] += if is_right { row.weight } else { 0.0 };
        self.total[row.class] += row.weight;
    }

    fn mean_log_loss(&self) -> f64 {
        self.log_loss / self.total.iter().sum::<f64>().max(f64::MIN_POSITIVE)
    }

    fn balanced_accuracy(&self) -> f64 {
        let shares = self.right.iter().zip(&self.total).filter(|(_, total)| **total > 0.0);
        let shares: Vec<f64> = shares.map(|(right, total)| right / total).collect();
        shares.iter().sum::<f64>() / (shares.len() as f64).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that shuffling the feature that decides brings the accuracy down to chance, and that an uninformative
    /// feature is worth nothing.
    #[test]
    fn the_feature_that_decides_is_worth_the_accuracy() {
        const ROWS: usize = 4000;
        let row = |index: usize| Row {
            features: [if index.is_multiple_of(2) { -1.0 } else { 1.0 }, (index % 7) as f64, 3.0],
            class: index % 2,
            weight: 1.0,
        };
        let rows: Vec<Row<3>> = (0..ROWS).map(row).collect();
        let mut shuffled = Shuffled::new(&["sign", "noise", "constant"], 2);
        shuffled.add(&Network::fit(&rows, 2), &rows);
        let worth = shuffled.worth("test");
        assert_eq!(worth[0].feature, "sign");
        // Half of the rows get the other sign; the share has a standard deviation of 0.5 / √4000.
        let deviation = 0.5 / (ROWS as f64).sqrt();
        assert!((worth[0].balanced_accuracy_fall - 0.5).abs() < 5.0 * deviation, "{worth:?}");
        assert!(worth[0].log_loss_rise_nats > std::f64::consts::LN_2, "{worth:?}");
        for other in &worth[1..] {
            assert!(other.log_loss_rise_nats.abs() < 0.01, "{worth:?}");
            assert_eq!(other.balanced_accuracy_fall, 0.0);
        }
    }
}
