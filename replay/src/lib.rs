//! Replays reaches in the browser.
//!
//! A [`Source`] lists the reaches of data sets and recordings and packs one of them at a time, with its contact trials and
//! the verdicts of a model, into the bytes that the page reads ([`pack`]). The same bytes are served over HTTP by [`Server`]
//! and embedded in the file that [`single_file`] makes. [`Live`] passes a reach to the server while it is simulated.
//!
//! The page is built from `page/` by Vite. Its built form is a single HTML file, which is checked in, so that building this
//! crate needs no Node.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod contact_trials;
mod container;
mod context;
mod http;
mod judging;
mod live;
pub mod pack;
mod page;
mod response;
mod running_reach;
mod server;
mod source;
mod trial_spans;
mod trial_table;
mod verdicts;

pub use context::ReplayContext;
pub use judging::{Judging, VerdictLog, unjudged};
pub use live::{Live, PartialReach};
pub use page::{page_that_fits, single_file};
pub use server::Server;
pub use source::{Held, Source, Summary};
pub use underbrush_classifier::online_model::OnlineModel as JudgingModel;
pub use verdicts::Verdicts;

#[cfg(test)]
mod tests;
