//! The list of classifiers. The command line, model files and tests take classifiers only from this list.

use crate::baseline::{echo_state_network, logistic, naive_bayes, nearest_neighbours};
use crate::estimator::ClassifierKind;
use crate::hmm_classifier;

/// All classifiers. To add one, write its file and add its entry here.
pub const CLASSIFIERS: [&ClassifierKind; 6] = [
    &hmm_classifier::KIND,
    &nearest_neighbours::KIND,
    &naive_bayes::KIND,
    &echo_state_network::KIND,
    &logistic::KIND,
    &logistic::TAXEL_KIND,
];

/// The kind of classifier with this name or alias.
pub fn find(name: &str) -> Option<&'static ClassifierKind> {
    CLASSIFIERS.into_iter().find(|kind| kind.names().any(|own| own == name))
}
