//! Classifiers to hold the hidden Markov models against, behind the same trait ([`crate::estimator::Estimator`]).
//!
//! | name | after | sees |
//! |---|---|---|
//! | [`NearestNeighbours`] | the authors' earlier method \[1\]: k nearest neighbours on principal components | a fixed first window of force, contact area and motion |
//! | [`NaiveBayes`] | Liu et al. \[4\]: naive Bayes, updated online | [`crate::stream_feature`] of the taxel alone |
//! | [`EchoStateNetwork`] | Soh et al. \[3\]: an online recursive kernel method | force and motion of the taxel, sample by sample |
//! | [`Logistic`] | no paper; chosen by accuracy on held-out reaches | [`crate::stream_feature`] of taxel and contact region |
//!
//! Numbers in brackets are the paper's references. Of \[4\] the paper says only that naive Bayes classified shape and pose
//! while a finger explored; the features are ours.

mod echo_state_network;
mod logistic;
mod naive_bayes;
mod nearest_neighbours;
mod table;

pub use echo_state_network::EchoStateNetwork;
pub use logistic::Logistic;
pub use naive_bayes::NaiveBayes;
pub use nearest_neighbours::NearestNeighbours;

#[cfg(test)]
mod tests;
