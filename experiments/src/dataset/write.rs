//! Writes the reaches of a campaign to a folder: all of them, or one part into a folder that several processes share.

use std::path::Path;
use std::sync::Once;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use underbrush_recording::Fault;
use underbrush_recording::disk::{Dataset, DatasetWriter, DiskError, Shard, make_room};
use underbrush_sim::campaign::Job;
use underbrush_sim::reach::ReachPlan;

use super::{Campaign, each_reach, say_doubts};
use crate::progress::Progress;

/// The result of a request for a data set.
pub enum Written {
    /// It was made, or finished, by this call.
    New(Dataset),
    /// It was already finished.
    Before(Dataset),
}

impl Written {
    /// The data set.
    pub fn dataset(self) -> Dataset {
        match self {
            Written::New(dataset) | Written::Before(dataset) => dataset,
        }
    }
}

/// Time between attempts to enter a shared folder while another process assembles the set. Choice: short beside a
/// reach.
const WAIT: Duration = Duration::from_secs(1);
/// Draws that take longer than this are announced.
const QUIET: Duration = Duration::from_secs(1);

impl Campaign {
    /// Runs the campaign and writes it to the folder `out`; with `resume`, runs only the reaches that are missing
    /// there.
    pub fn write(&self, out: &Path, resume: bool, progress: &dyn Progress) -> Result<Written, Fault> {
        self.overwrite(out, resume, false, progress)
    }

    /// As [`Campaign::write`]. With `force`, the set that is there is removed before anything is written, but not before the
    /// campaign has been found possible.
    pub fn overwrite(&self, out: &Path, resume: bool, force: bool, progress: &dyn Progress) -> Result<Written, Fault> {
        let plans = self.plans()?;
        let jobs = self.jobs();
        let plan = self.plan(&plans, &jobs)?;
        prepare(&plans, &jobs, progress)?;
        make_room(out, force)?;
        let writer = match DatasetWriter::create(out, plan, resume) {
            // With `resume`, this means that the set has the same plan.
            Err(DiskError::Finished { .. }) if resume => return Ok(Written::Before(Dataset::open(out)?)),
            writer => writer?,
        };
        stage(&plans, &jobs, &writer, &writer.missing()?, jobs.len(), progress)?;
        Ok(Written::New(writer.finish()?))
    }

    /// Runs the missing reaches of one part of the campaign, in a folder that all parts share. The part that finishes
    /// last makes the data set of the whole campaign there; `None` means that other parts have not finished yet.
    /// [`Campaign::shard`] must not be given.
    pub fn write_shared(&self, out: &Path, part: Shard, progress: &dyn Progress) -> Result<Option<Written>, Fault> {
        let plans = self.plans()?;
        let jobs = self.jobs();
        let own = jobs.iter().enumerate().filter(|(position, _)| part.holds(*position as u64));
        let own: Vec<Job> = own.map(|(_, job)| *job).collect();
        if own.is_empty() {
            return Err(Fault::Usage(format!("part {part} has no reach; ask for at least one reach in each part")));
        }
        prepare(&plans, &own, progress)?;
        let plan = self.plan(&plans, &jobs)?;
        let mut waits = false;
        let writer = loop {
            match DatasetWriter::share(out, plan.clone()) {
                Err(DiskError::Finished { .. }) => return Ok(Some(Written::Before(Dataset::open(out)?))),
                Err(DiskError::InUse(dir)) => {
                    if !waits {
                        let dir = dir.display();
                        progress.remark(&format!("{dir}: waiting for another process, which assembles the data set"));
                    }
                    waits = true;
                    progress.check_stopped()?;
                    std::thread::sleep(WAIT);
                }
                writer => break writer?,
            }
        };
        stage(&plans, &jobs, &writer, &writer.missing_of(part)?, own.len(), progress)?;
        Ok(writer.finish_if_last()?.map(Written::New))
    }
}

/// Warns about doubtful skins, and draws all reaches once to refuse an impossible draw before anything is written. A
/// set that failed halfway could not be resumed, because correcting the scene changes the plan. A draw takes about a
/// hundredth of the time of its reach. The user can end the draws.
fn prepare(plans: &[ReachPlan], jobs: &[Job], progress: &dyn Progress) -> Result<(), Fault> {
    say_doubts(plans.iter().map(|plan| &plan.arm), progress);
    let (begun, said) = (Instant::now(), Once::new());
    jobs.par_iter().try_for_each(|job| {
        progress.check_stopped()?;
        if begun.elapsed() > QUIET {
            said.call_once(|| progress.stage(&format!("Drawing all {} reaches before the first begins", jobs.len())));
        }
        plans[job.plan].draw(job.reach_index).map(drop).map_err(Fault::from)
    })
}

/// Runs and stages the missing reaches; `total` counts the finished ones, too.
fn stage(
    plans: &[ReachPlan],
    jobs: &[Job],
    writer: &DatasetWriter,
    missing: &[usize],
    total: usize,
    progress: &dyn Progress,
) -> Result<(), Fault> {
    let to_run: Vec<Job> = missing.iter().map(|position| jobs[*position]).collect();
    let stage = |place: usize, recording| Ok(writer.stage(missing[place], &recording)?);
    each_reach(plans, &to_run, total - missing.len(), progress, stage).map(drop)
}
