//! Where commands write: one rule for all of them, checked before the work.

use std::path::{Path, PathBuf};

use clap::Args;
use underbrush_recording::InputError;
use underbrush_recording::disk::{
    Dataset, check_free, check_not_input, check_outside_sets, check_writable, is_folder, is_there,
};

use crate::{Failure, output};

/// The option of all commands that write files.
#[derive(Args, Clone, Copy)]
pub struct Overwrite {
    /// Overwrite an output that exists already
    #[arg(long)]
    pub force: bool,
}

impl Overwrite {
    /// How to continue a command that can be resumed.
    pub fn again(self) -> &'static str {
        if self.force { "the same command with --resume in place of --force" } else { "the same command with --resume" }
    }

    /// Demands that the result can be written to this file: it is not one of the inputs, nor within a data set, nothing is
    /// there or it may be overwritten, and the parent folders are there or are created, and take a file.
    pub fn file<'a>(self, path: &Path, inputs: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), Failure> {
        check_outside_sets(path)?;
        // Only then does a name with `..` lead to where it will lead, which may be an input.
        output::create_parents(path)?;
        check_not_input(path, inputs)?;
        let is_named_as_folder = path.to_string_lossy().ends_with(std::path::is_separator);
        if is_named_as_folder || std::fs::metadata(path).is_ok_and(|there| !there.is_file()) {
            let text = "is a folder or not a regular file; give the name of a file to write";
            return Err(Failure::usage(text).about(path));
        }
        check_free(path, self.force)?;
        Ok(check_writable(path)?)
    }

    /// As [`Overwrite::file`], for a file whose name must have one of these endings, in small letters or capitals.
    pub fn ending<'a>(
        self,
        path: &Path,
        endings: &[&str],
        remedy: &str,
        inputs: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Result<(), Failure> {
        let own = path.extension().unwrap_or_default().to_string_lossy();
        if !endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)) {
            let allowed = format!("a name that ends in .{}", endings.join(" or ."));
            return Err(InputError::new(path, "file name", format!("extension {own:?}"), allowed, remedy).into());
        }
        self.file(path, inputs)
    }
}

/// Demands that a folder for results, which are many files and folders, is neither a file nor a data set.
pub fn check_results_folder(folder: &Path) -> Result<(), Failure> {
    let is_data_set = Dataset::open(folder).is_ok();
    if !is_data_set && (is_folder(folder)? || !is_there(folder)?) {
        return Ok(());
    }
    let what = if is_data_set { "a data set" } else { "a file" };
    Err(Failure::usage(format!("--out {}: is {what}; choose another folder", folder.display())))
}

/// Demands that a folder to write is neither one of the inputs nor within one.
pub fn check_outside<'a>(folder: &Path, inputs: impl IntoIterator<Item = &'a PathBuf> + Clone) -> Result<(), Failure> {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
    // What is there of it: `..` may lead out of an input.
    let there = whole.ancestors().find_map(|around| std::fs::canonicalize(around).ok()).unwrap_or_default();
    Ok(there.ancestors().try_for_each(|around| check_not_input(around, inputs.clone()))?)
}
