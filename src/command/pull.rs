//! `underbrush pull`: copies a data set from S3-like storage.

use std::path::PathBuf;

use clap::Args;
use underbrush_exchange::bucket::Place;

use super::overwrite::Overwrite;
use super::transfer_summary::TransferSummary;
use crate::failure::Failure;
use crate::{interrupt, output, progress};

/// Options of `underbrush pull`.
#[derive(Args)]
pub struct Options {
    /// Where the data set is, such as s3://bucket/my-set; see `underbrush push`
    #[arg(value_name = "ADDRESS")]
    address: String,
    /// Folder to write it to: an empty or new one, or one with an interrupted copy of the same set
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Copies the set.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let Options {
        address,
        out,
        overwrite,
    } = options;
    let place = Place::new(&address)?;
    overwrite.dataset(&out, [])?;
    interrupt::hint("run the same command again to copy what is missing");
    let bar = progress::bar(0, "files");
    let pulled = place.pull(&out, |files| {
        bar.set_length(files as u64);
        bar.inc(1);
    });
    bar.finish_and_clear();
    let (dataset, transfer) = pulled?;
    let summary = TransferSummary::new(dataset.dir(), address, transfer);
    output::result(json, &summary, || summary.text("received from"))
}
