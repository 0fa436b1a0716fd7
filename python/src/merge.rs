//! Joining the parts of a divided data set.

use std::path::PathBuf;

use pyo3::prelude::*;
use underbrush_recording::disk::{Dataset, DiskError, Shards};

use crate::dataset::PyDataset;
use crate::failure::Failure;
use crate::generate::make_room;
use crate::pool::guarded;

/// Join all parts that ``generate(..., shard=(I, N))`` has made into the set that one call without ``shard`` makes,
/// byte for byte.
///
/// Parameters
/// ----------
/// parts : list of paths
///     The folders of all parts, in any order.
/// out : path
///     The folder to write.
/// resume : bool
///     Continue an interrupted merge. If the set is finished already, open it.
/// force : bool
///     Remove the data set that is in ``out`` first.
///
/// Returns
/// -------
/// Dataset
///
/// Raises
/// ------
/// InputError
///     If a folder holds no finished part or a damaged one, if parts are missing, given twice or from different
///     campaigns, or if ``out`` holds anything (with ``resume``, anything but this merge). The message names it.
#[pyfunction]
#[pyo3(signature = (parts, out, *, resume = false, force = false))]
pub fn merge(
    py: Python<'_>,
    parts: Vec<PathBuf>,
    out: PathBuf,
    resume: bool,
    force: bool,
) -> Result<PyDataset, Failure> {
    make_room(&out, &parts, resume, force)?;
    let merge = || match Shards::open(parts)?.merge(&out, resume, || ()) {
        // With `resume`, this means that the set has the same plan.
        Err(DiskError::Finished { .. }) if resume => Ok(Dataset::open(&out)?),
        merged => Ok(merged?),
    };
    Ok(PyDataset::new(py.detach(|| guarded(merge))?))
}
