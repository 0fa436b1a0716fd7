//! `underbrush arrange`: writes one draw of a scene as a scene file.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use underbrush_report::suite_text::shell_word;
use underbrush_sim::{ReachPlan, Scene};

use crate::options::whole;
use crate::{Failure, Overwrite, output};

/// Options of `underbrush arrange`.
///
/// Every object of the draw becomes a group of its own, with its place, its rotation and its values as numbers, and the
/// goals are listed. Move, change, add or remove objects in the file by hand; `underbrush reach FILE` simulates it. With
/// the same --seed and --index the reach through the unchanged file is that through the scene, byte for byte.
#[derive(Args)]
pub struct ArrangeOptions {
    /// Scene: the name of one that ships, such as mixed, or a scene file
    scene: PathBuf,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Index of the reach: every index is a different draw of the scene
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = whole(0..=u64::MAX))]
    index: u64,
    /// The scene file to write (TOML)
    #[arg(long, value_name = "FILE.toml")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Draws the scene and writes the file.
pub fn run(ArrangeOptions { scene, seed, index, out, overwrite }: ArrangeOptions, json: bool) -> Result<(), Failure> {
    overwrite.ending(&out, &["toml"], "a scene is a TOML file; choose such a name", [&scene])?;
    let plan = ReachPlan::new(Scene::open(&scene)?, None, seed)?;
    let clutter = plan.draw(index)?;
    let remark = format!(
        "# Reach {index} of the scene {} with seed {seed}, object by object. Lengths are in m, angles of `yaw_deg` in degrees.\n",
        plan.scene.name
    );
    output::write_file(&out, (remark + &clutter.arranged(&plan.scene, &out)).as_bytes())?;
    let (objects, goals, file) = (clutter.objects.len(), clutter.goals.len(), out.display().to_string());
    let report = json!({
        "scene": plan.scene.name, "seed": seed, "reach_index": index, "objects": objects, "goals": goals, "file": file,
    });
    output::result(json, &report, || {
        let word = shell_word(&file);
        let (objects, goals) = (output::counted(objects, "object", "objects"), output::counted(goals, "goal", "goals"));
        format!("Wrote {file} with {objects} and {goals}. Next: underbrush reach {word}\n")
    })
}
