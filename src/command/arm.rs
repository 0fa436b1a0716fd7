//! `underbrush arm`: makes the files of a user's own arm.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde_json::json;
use underbrush_recording::InputError;
use underbrush_recording::disk::is_there;
use underbrush_report::suite_text::shell_word;
use underbrush_sim::arm::cover::{NewPatch, cover};
use underbrush_sim::arm::new::{NewArm, new_files};

use crate::{Failure, Overwrite, options, output};

/// Options of `underbrush arm`.
///
/// Three commands bring your own arm among trunks:
///
///   underbrush arm new robot.urdf --tip hand --out robot.toml
///   underbrush arm skin robot.toml --link forearm --pitch-mm 10 --patch forearm --prune
///   underbrush reach robot.trunks.toml
///
/// `underbrush inspect robot.toml --still robot.png` lists joints, links and patches, and draws them.
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct ArmOptions {
    #[command(subcommand)]
    command: ArmCommand,
}

#[derive(Subcommand)]
enum ArmCommand {
    /// Write an arm file, a skin file without patches and a scene with trunks, from a URDF
    New(NewOptions),
    /// Add a patch of taxels to the skin file of an arm
    Skin(SkinOptions),
}

/// Options of `underbrush arm new`.
///
/// The arm is the chain of turning joints from --base to --tip. All other joints, such as those of fingers, are held. Meshes
/// (STL, OBJ, DAE) become convex hulls in the arm file. Stiffness, damping, limits and start posture follow rules that the file
/// states; change what you know better. For an arm in robot.toml the skin is in robot.skin.toml, and the scene in
/// robot.trunks.toml. A skin file that is there already is kept.
#[derive(Args)]
struct NewOptions {
    /// The URDF, without xacro: `xacro robot.urdf.xacro > robot.urdf` expands one
    urdf: PathBuf,
    /// Link that the controller moves to goals: the hand or a frame on it
    #[arg(long, value_name = "LINK")]
    tip: String,
    /// Fixed link, whose frame is that of the world [default: the root of the URDF]
    #[arg(long, value_name = "LINK")]
    base: Option<String>,
    /// Where the meshes of package://NAME/ are [default: the folder NAME around the URDF]
    #[arg(long, value_name = "NAME=FOLDER", value_parser = package)]
    package: Vec<(String, PathBuf)>,
    /// Maximum number of convex hulls for each mesh: more hulls fit a bent link better but cost time in every step
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = options::whole(1..=16_u32))]
    hulls: u32,
    /// The arm file to write
    #[arg(long, value_name = "FILE.toml")]
    out: PathBuf,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Options of `underbrush arm skin`.
///
/// A link whose only collision shape is a cylinder or capsule gets rows and columns of taxels round its side. Any other link
/// gets taxels all over its shapes, listed one by one. Taxels inside of other shapes of the arm cannot be touched. They are
/// an error, which lists all of them, unless --prune leaves them out.
#[derive(Args)]
struct SkinOptions {
    /// The arm file
    arm: PathBuf,
    /// Link to cover, with all that is fixed to it
    #[arg(long, value_name = "LINK")]
    link: String,
    /// Distance between neighbouring taxels, mm
    #[arg(long, value_name = "MM", value_parser = options::number(|_: &f64| true, "must be a length in mm"))]
    pitch_mm: f64,
    /// Name of the patch
    #[arg(long, value_name = "NAME")]
    patch: String,
    /// Leave out taxels that nothing can touch; in a grid, leave out every row that has such taxels
    #[arg(long)]
    prune: bool,
    /// Replace the patch of this name
    #[arg(long)]
    force: bool,
}

fn package(text: &str) -> Result<(String, PathBuf), String> {
    options::pair(text, '=').ok_or_else(|| "must be NAME=FOLDER, such as panda_description=robots/panda".into())
}

/// Makes the files.
pub fn run(options: ArmOptions, json: bool) -> Result<(), Failure> {
    match options.command {
        ArmCommand::New(options) => new(options, json),
        ArmCommand::Skin(options) => skin(options, json),
    }
}

fn new(options: NewOptions, json: bool) -> Result<(), Failure> {
    let NewOptions { urdf, tip, base, package, hulls, out, overwrite } = options;
    overwrite.ending(&out, &["toml"], "an arm is a TOML file; choose such a name", [&urdf])?;
    if out.file_name().is_some_and(|name| name.to_str().is_none()) {
        let allowed = "a name in UTF-8, because the files of an arm name each other";
        return Err(InputError::new(&out, "file name", "other bytes", allowed, "choose such a name").into());
    }
    let files = new_files(&NewArm {
        urdf: urdf.clone(),
        out: out.clone(),
        tip_link: tip,
        base_link: base,
        packages: package.into_iter().collect(),
        hulls_per_mesh: hulls as usize,
    })?;
    let (skin, scene) = (&files.skin.0, &files.scene.0);
    overwrite.file(scene, [&urdf])?;
    let keeps_skin = is_there(skin)?;
    if !keeps_skin {
        output::write_file(skin, files.skin.1.as_bytes())?;
    }
    output::write_file(&out, files.arm_file.as_bytes())?;
    output::write_file(scene, files.scene.1.as_bytes())?;
    for (link, share) in &files.raised {
        let (urdf, out, percent) = (urdf.display(), out.display(), 100.0 * share);
        output::remark(format!(
            "warning: the inertia of {link} in {urdf} is that of no body: a principal moment is {percent:.1} % above the sum of the \
             other two. {out} has the nearest possible inertia, in [[inertia]]; correct it if you know the true one"
        ));
    }
    if !files.start_found {
        output::remark(format!(
            "warning: no posture was found with the tip in front of the base, where the goals of {} are, so the arm starts in the middle \
             of its limits. The frame of the base should have x forward and z up; choose another --base, or change the posture in \
             {} and the places in the scene",
            scene.display(),
            out.display()
        ));
    }
    let links: Vec<&str> = files.arm.links.iter().map(|link| link.name.as_str()).collect();
    let outside_mm = files.outside_hulls_m * 1000.0;
    let [out, skin, scene] = [&out, skin, scene].map(|path| path.display().to_string());
    let report = json!({
        "arm": out, "skin": skin, "scene": scene, "joints": files.arm.joints.len(), "links": links, "held_joints": files.held,
        "raised_inertia": files.raised.iter().map(|(link, _)| link).collect::<Vec<_>>(),
        "hulls": files.hulls, "outside_hulls_mm": outside_mm,
    });
    output::result(json, &report, || {
        let held = if files.held.is_empty() { String::new() } else { format!("; held: {}", files.held.join(", ")) };
        let (joints, links) = (output::counted(files.arm.joints.len(), "joint", "joints"), links.join(", "));
        let word = shell_word(&out);
        let hulls = match files.hulls {
            0 => "no hulls of meshes".to_owned(),
            count => {
                let hulls = output::counted(count, "hull", "hulls");
                format!("{hulls}; meshes extend at most {outside_mm:.1} mm beyond them")
            }
        };
        let wrote = match keeps_skin {
            true => format!("{out} and {scene}; kept {skin}"),
            false => format!("{out}, {skin} and {scene}"),
        };
        format!(
            "Wrote {wrote}.\n{joints}{held}\nlinks: {links}\n\
             {hulls}\n\
             Next: underbrush arm skin {word} --link LINK --pitch-mm 10 --patch NAME\n"
        )
    })
}

fn skin(options: SkinOptions, json: bool) -> Result<(), Failure> {
    let SkinOptions { arm, link, pitch_mm, patch, prune, force } = options;
    let new = NewPatch { name: patch, link, pitch_m: pitch_mm / 1000.0, prune, replace: force };
    let covered = cover(&arm, &new)?;
    output::write_file(&covered.path, covered.text.as_bytes())?;
    let layout = &covered.arm.skin.layout;
    let made = layout.patch_index(&new.name).map(|index| &layout.patches[index]);
    let (taxels, grid) = made.map_or((0, None), |made| (made.taxels.len(), made.grid));
    let shape = grid.map(|grid| [grid.rows, grid.columns]);
    let doubts = covered.arm.skin_doubts();
    let path = covered.path.display().to_string();
    let report = json!({
        "skin": path, "patch": new.name, "taxels": taxels, "rows_and_columns": shape, "left_out": covered.left_out,
        "doubtful": doubts,
    });
    output::result(json, &report, || {
        let grid = shape.map_or(String::new(), |[rows, columns]| format!(" in {rows} rows of {columns}"));
        let unit = if shape.is_some() { "rows" } else { "taxels" };
        let left_out =
            if covered.left_out == 0 { String::new() } else { format!("; {} {unit} left out", covered.left_out) };
        let doubts: String = doubts.iter().map(|doubt| format!("doubtful: {doubt}\n")).collect();
        let taxels = output::counted(taxels, "taxel", "taxels");
        format!("Patch {} in {path}: {taxels}{grid}{left_out}\n{doubts}", new.name)
    })
}
