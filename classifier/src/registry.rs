//! The list of classifiers. The command line, model files and tests take classifiers only from this list.

#[cfg(test)]
use crate::baseline::tests::nearest_mean;
use crate::baseline::{echo_state_network, logistic, mini_rocket, naive_bayes, nearest_neighbours, trees};
use crate::{ClassifierKind, hmm_classifier};

/// All classifiers. To add one, write its file and add its entry here.
pub const CLASSIFIERS: [&ClassifierKind; 9 + cfg!(test) as usize] = [
    &hmm_classifier::KIND,
    &nearest_neighbours::KIND,
    &naive_bayes::KIND,
    &naive_bayes::PEAK_KIND,
    &echo_state_network::KIND,
    &logistic::KIND,
    &logistic::TAXEL_KIND,
    &trees::KIND,
    &mini_rocket::KIND,
    #[cfg(test)]
    &nearest_mean::KIND,
];

/// The largest force alone: the baseline that a classifier of contacts must beat.
pub const PEAK_FORCE: &ClassifierKind = &naive_bayes::PEAK_KIND;

/// The kind of classifier with this name or alias.
///
/// ```
/// use underbrush_classifier::registry;
///
/// let kind = registry::find("naive-bayes").expect("it is in the list");
/// assert!(kind.names().any(|name| name == "naive-bayes") && !kind.summary.is_empty());
/// assert!(registry::find("horoscope").is_none());
/// ```
pub fn find(name: &str) -> Option<&'static ClassifierKind> {
    CLASSIFIERS.into_iter().find(|kind| kind.names().any(|own| own == name))
}
