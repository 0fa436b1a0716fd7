//! `underbrush merge`: joins the parts of a divided campaign into one data set.

use std::path::PathBuf;

use clap::Args;
use underbrush_recording::disk::{Shards, make_room};

use super::generate::Summary;
use super::overwrite::check_outside;
use crate::{Failure, Overwrite, interrupt, output, progress};

/// Options of `underbrush merge`.
#[derive(Args)]
pub struct MergeOptions {
    /// Folders of all parts, in any order, each made by `underbrush generate --shard I/N` with otherwise the same
    /// options
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Folder to write the data set to. It gets the bytes that `generate` without --shard would have written
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Continue an interrupted merge
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Joins the parts.
pub fn run(options: MergeOptions, json: bool) -> Result<(), Failure> {
    let MergeOptions { parts, out, resume, overwrite } = options;
    let shards = Shards::open(&parts)?;
    check_outside(&out, &parts)?;
    make_room(&out, overwrite.force)?;
    interrupt::kept("what is complete is", &out, overwrite.again());
    let bar = progress::bar(shards.plan.episodes.len() as u64, "reaches");
    let summary = Summary::of(&shards.merge(&out, resume, move || bar.inc(1))?, None);
    output::result(json, &summary, || summary.text())
}
