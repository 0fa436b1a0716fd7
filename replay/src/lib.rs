//! Replays reaches in the browser.
//!
//! A [`Source`] lists the reaches of data sets and recordings and packs one of them at a time, with its contact trials and
//! the verdicts of a model, into the bytes that the page reads ([`pack`]). The same bytes are served over HTTP by [`Server`]
//! and embedded in the file that [`single_file`] makes. [`Live`] passes a reach to the server while it is simulated.
//!
//! The page is built from `page/` by Vite. Its built form is a single HTML file, which is checked in, so that building this
//! crate needs no Node.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod container;
mod http;
mod judging;
mod live;
pub mod pack;
mod page;
mod server;
mod source;
mod trial_spans;
mod trial_table;
mod verdicts;

pub use judging::{Judging, VerdictLog, unjudged};
pub use live::{Live, PartialReach};
pub use page::{page_that_fits, single_file};
pub use server::Server;
pub use source::{Held, Source, Summary};
pub use underbrush_classifier::any_model::OnlineModel as JudgingModel;
pub use verdicts::Verdicts;

use underbrush_recording::{Audit, SkinLayout};

/// Facts that the caller knows and the recordings do not hold.
#[derive(Clone, Copy)]
pub struct ReplayContext {
    /// The force limit of a taxel, N, by the controller's name.
    pub force_limit_n: fn(&str) -> Option<f64>,
    /// The force limit of a taxel, N, where it is known for sure: a scene may scale that of its controller.
    pub stated_limit_n: Option<f64>,
    /// The bounds of the audit that a reach with this skin exceeds, each as a sentence.
    pub audit_warnings: fn(&Audit, &SkinLayout) -> Vec<String>,
}

#[cfg(test)]
mod tests;
