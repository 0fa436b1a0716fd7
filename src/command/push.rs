//! `underbrush push`: copies a data set to S3-like storage.

use std::path::PathBuf;

use clap::Args;
use underbrush_exchange::bucket::Place;
use underbrush_recording::disk::Dataset;

use super::transfer_summary::TransferSummary;
use crate::failure::Failure;
use crate::{interrupt, output, progress};

/// Options of `underbrush push`.
#[derive(Args)]
pub struct Options {
    /// Data set: a whole one, or a part that `generate --shard` made
    #[arg(value_name = "DATASET")]
    dataset: PathBuf,
    /// Where to copy it, such as s3://bucket/my-set. AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_REGION and
    /// AWS_ENDPOINT_URL say how to get there
    #[arg(value_name = "ADDRESS")]
    address: String,
}

/// Copies the set.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let Options { dataset, address } = options;
    let dataset = Dataset::open(dataset)?;
    let place = Place::new(&address)?;
    interrupt::hint("run the same command again to copy what is missing");
    let bar = progress::bar(dataset.files().len() as u64, "files");
    let transfer = place.push(&dataset, || bar.inc(1));
    bar.finish_and_clear();
    let summary = TransferSummary::new(dataset.dir(), address, transfer?);
    output::result(json, &summary, || summary.text("sent to"))
}
