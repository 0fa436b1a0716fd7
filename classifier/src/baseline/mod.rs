//! Classifiers to compare the hidden Markov models with. They implement the same trait
//! ([`crate::estimator::Estimator`]).
//!
//! | name | based on | sees |
//! |---|---|---|
//! | [`NearestNeighbours`] | the authors' earlier method \[1\]: k nearest neighbours on principal components | force, contact area and motion in a fixed window from first contact |
//! | [`NaiveBayes`] | Liu et al. \[4\]: naive Bayes, updated online | stream features ([`crate::stream_feature`]) of the taxel |
//! | [`EchoStateNetwork`] | Soh et al. \[3\]: an online recursive kernel method | force and motion of the taxel, sample by sample |
//! | [`Logistic`] | no paper; chosen by its accuracy on held-out reaches | stream features of taxel and contact region |
//! | [`MiniRocket`] | no paper on contact; Dempster, Schmidt, Webb, "MiniRocket: a very fast (almost) deterministic transform for time series classification" (2021) | the course of taxel and contact region |
//! | [`Trees`] | no paper; Friedman, "Greedy function approximation: a gradient boosting machine" (2001) | stream features of taxel and contact region |
//!
//! Numbers in brackets refer to the paper's list of references. About \[4\] the paper says only that naive Bayes
//! classified shape and pose while a finger explored. The features are ours.

mod convolution;
pub(crate) mod echo_state_network;
mod fitted;
pub(crate) mod logistic;
pub(crate) mod mini_rocket;
pub(crate) mod naive_bayes;
pub(crate) mod nearest_neighbours;
mod ridge;
mod table;
pub(crate) mod trees;

pub use echo_state_network::EchoStateNetwork;
pub use logistic::Logistic;
pub use mini_rocket::MiniRocket;
pub use naive_bayes::NaiveBayes;
pub use nearest_neighbours::NearestNeighbours;
pub use trees::Trees;

#[cfg(test)]
pub(crate) mod tests;
