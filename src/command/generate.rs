//! `underbrush generate`: runs many reaches and writes a data set.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use serde_json::json;
use underbrush_experiments::audit::{self, Ends, Worst};
use underbrush_experiments::dataset::{Campaign, REACHES, Written, require_same_reaches};
use underbrush_recording::disk::{Dataset, Shard, check_not_input};
use underbrush_report::audit_text;
use underbrush_sim::materials::MaterialFile;
use underbrush_sim::{ControllerKind, Scene};

use super::overwrite::check_outside;
use super::{Overwrite, VerdictArguments};
use crate::{Failure, Shown, input, interrupt, options, output};

/// Options of `underbrush generate`.
#[derive(Args)]
pub struct GenerateOptions {
    /// Scenes: names of those that ship, such as leaf trunk, or scene files
    #[arg(required_unless_present = "from", value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Number of reaches per scene
    #[arg(long, required_unless_present = "from", value_name = "N")]
    #[arg(value_parser = options::whole(REACHES))]
    reaches: Option<u64>,
    /// Seed of the random numbers: the same scenes, seed and version give the same bytes
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = options::whole(0..=u64::MAX))]
    seed: u64,
    /// Folder to write the data set to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Regenerate this data set from what it contains: scenes, arms, seed, controller, reaches and shard. If its
    /// controller had verdicts, give the touch model, too
    #[arg(long, value_name = "DATASET", conflicts_with_all = ["scenes", "reaches", "seed", "controller", "shard", "shared", "randomize", "materials", "allow"])]
    from: Option<PathBuf>,
    /// Controller to use instead of each scene's
    #[arg(long, value_name = "NAME", value_parser = input::controller())]
    controller: Option<ControllerKind>,
    #[command(flatten)]
    verdicts: VerdictArguments,
    /// Draw the constants of the contact model anew for every reach, from the ranges in the file of materials. They are
    /// stored with the objects. Objects and goals stay the same
    #[arg(long, value_name = "WHAT", value_parser = options::named::<String>(&[("materials", "The constants in the file of materials")]))]
    randomize: Option<String>,
    /// File of materials, such as sim/materials.toml. Its values replace those of arm and objects. With --randomize, values
    /// are drawn from its ranges
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// Continue an interrupted data set
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Run only part I of N (counted from 1), into a separate folder or, with --shared, into one for all parts.
    /// `underbrush merge` joins parts in separate folders
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// All parts have the same --out, on a file system that all machines share. The part that finishes last makes the
    /// data set there. To continue a part that was interrupted, run it again
    #[arg(long, requires = "shard", conflicts_with_all = ["resume", "force"])]
    shared: bool,
}

fn shard(text: &str) -> Result<Shard, String> {
    let numbers = options::pair(text, '/').filter(|(index, count)| (1..=*count).contains(index));
    let shard = numbers.map(|(index, count)| Shard { index: index - 1, count });
    shard.ok_or_else(|| "must be I/N with 1 ≤ I ≤ N, such as 2/8".into())
}

/// The campaign that the options describe.
fn described(options: &GenerateOptions) -> Result<Campaign, Failure> {
    let scenes: Result<Vec<Scene>, _> = options.scenes.iter().map(Scene::open).collect();
    let materials = options.materials.as_deref().map(MaterialFile::load).transpose()?;
    let scenes = match (materials, &options.randomize) {
        (None, None) => scenes,
        (file, randomize) => {
            let file = file.map_or_else(MaterialFile::shipped, Ok)?;
            scenes?.iter().map(|scene| scene.with_materials(&file, randomize.is_some())).collect()
        }
    };
    Ok(Campaign {
        controller: options.controller,
        verdicts: options.verdicts.control()?,
        shard: options.shard.filter(|_| !options.shared),
        ..Campaign::new(scenes?, options.reaches.unwrap_or_default(), options.seed)?
    })
}

/// Runs the campaign.
pub fn run(options: GenerateOptions, json: bool) -> Result<(), Failure> {
    let start = Instant::now();
    let source = options.from.as_ref().map(Dataset::open).transpose()?;
    let campaign = match &source {
        Some(source) => Campaign::of(source, options.verdicts.control()?)?,
        None => described(&options)?,
    };
    let out = &options.out;
    check_outside(out, &options.from)?;
    check_not_input(out, options.scenes.iter().chain(&options.verdicts.model()))?;
    let again = if options.shared { "the same command again" } else { options.overwrite.again() };
    interrupt::kept("finished reaches are", out, again);
    let written = match options.shard.filter(|_| options.shared) {
        Some(part) => match campaign.write_shared(out, part, &Shown)? {
            Some(written) => written,
            None => {
                let out = out.display().to_string();
                let summary = json!({ "dataset": out, "part": part.to_string(), "finished": false });
                return output::result(json, &summary, || {
                    format!("part {part} is done; the part that finishes last makes the data set in {out}")
                });
            }
        },
        None => campaign.overwrite(out, options.resume, options.overwrite.force, &Shown)?,
    };
    let wall_s = matches!(written, Written::New(_)).then(|| start.elapsed().as_secs_f64());
    if wall_s.is_none() {
        output::remark(format!("{}: the data set is finished; there is nothing to do", out.display()));
    }
    let dataset = written.dataset();
    if let Some(source) = &source {
        require_same_reaches(&dataset, source)?;
    }
    audit::warnings(dataset.episodes(), &dataset.plan().layout).into_iter().for_each(output::remark);
    // Other runs may have simulated a part.
    let mut summary = Summary::of(&dataset, wall_s.filter(|_| !options.resume && !options.shared));
    if wall_s.is_some() {
        summary.goals_with_a_way = Some(campaign.goals_with_a_way()?);
    }
    output::result(json, &summary, || summary.text())
}

/// What is printed about a data set that was made.
#[derive(Serialize)]
pub(super) struct Summary {
    dataset: String,
    reaches: usize,
    frames: usize,
    simulated_s: f64,
    /// Wall time for making the set, s; `None` if another run made it or a part of it.
    wall_s: Option<f64>,
    /// Goals that have a way, all goals, and reaches, of a sample of the reaches; `None` for a set that was not simulated just now.
    goals_with_a_way: Option<[usize; 3]>,
    #[serde(flatten)]
    ends: Ends,
    /// The worst residuals of the audit, each with its reach.
    audit: BTreeMap<&'static str, Worst>,
    /// The counts of the audit, summed over the reaches.
    audit_counts: BTreeMap<&'static str, u64>,
}

impl Summary {
    /// Sums up a data set that took `wall_s` to simulate.
    pub(super) fn of(dataset: &Dataset, wall_s: Option<f64>) -> Self {
        let episodes = dataset.episodes();
        let frames: usize = episodes.iter().map(|episode| episode.frames).sum();
        Summary {
            dataset: dataset.dir().display().to_string(),
            reaches: episodes.len(),
            frames,
            simulated_s: frames as f64 * underbrush_recording::FRAME_PERIOD_S,
            wall_s,
            goals_with_a_way: None,
            ends: Ends::of(episodes),
            audit: audit::worst(episodes, &dataset.plan().layout),
            audit_counts: audit::counts(episodes),
        }
    }

    /// Readable text.
    pub(super) fn text(&self) -> String {
        let pace = self.wall_s.map_or(String::new(), |wall_s| {
            format!(" in {wall_s:.0} s ({:.0} times real time)", self.simulated_s / wall_s.max(1e-9))
        });
        let ways = self.goals_with_a_way.map_or(String::new(), |[ways, goals, looked_at]| {
            let of = if looked_at < self.reaches { format!(" of {looked_at} reaches") } else { String::new() };
            format!("{ways} of {goals} goals{of} have a way round all fixed obstacles\n")
        });
        let (reaches, simulated_s) = (output::counted(self.reaches, "reach", "reaches"), self.simulated_s);
        let (ends, audit, dataset) = (self.ends.text(), audit_text(&self.audit), &self.dataset);
        format!("{reaches}, {simulated_s:.0} s of simulated time{pace}\n{ends}\n{ways}{audit}\ndata set in {dataset}")
    }
}
