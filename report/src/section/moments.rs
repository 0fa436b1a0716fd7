//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14).

use glam::DVec3;
use underbrush_experiments::experiment::moments::{Moment, ReachMoments};
use underbrush_recording::{Patch, Pose, Taxel};
use underbrush_render::{Camera, RenderError, Size, Stage, png};

use crate::category_looks::CategoryLooks;
use crate::drawing::{Mark, escape, slug};
use crate::replayed::known;
use crate::report::Report;
use crate::{replay_links, skin_map};

/// Half as wide as the page on a screen with two pixels for one.
const SIZE: Size = Size { width: 960, height: 720 };
/// What is seen around the taxels in contact, m.
const AROUND_M: f64 = 0.08;

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ReachMoments) {
    if outcome.all().next().is_none() {
        return;
    }
    report.section("moments", "moments of two reaches");
    for (place, moment) in outcome.all().enumerate() {
        add_moment(report, moment, place);
    }
}

/// The address of a moment on the replay page.
pub fn address(moment: &Moment, place: usize) -> String {
    let patch = moment.recording.layout.patches.get(moment.patch);
    let pressed = moment.verdicts.keys().find(|taxel| moment.pressed.contains(taxel));
    let taxel = patch.zip(pressed).map(|(patch, taxel)| (patch.name.as_str(), *taxel));
    replay_links::moment(replay_links::TEST_FILE, place, moment.frame().time_s, taxel)
}

fn add_moment(report: &mut Report, moment: &Moment, place: usize) {
    let Some(patch) = moment.recording.layout.patches.get(moment.patch) else {
        return;
    };
    let Some(grid) = patch.grid else { return };
    let looks = &report.looks;
    let Moment { scene, reach_index, verdicts, pressed, .. } = moment;
    let (time_s, taxels) = (moment.frame().time_s, verdicts.len());
    let Size { width, height } = SIZE;
    let picture = format!(
        "<img src=\"{}\" width=\"{width}\" height=\"{height}\" alt=\"The patch {} with {taxels} taxels in contact\"/>",
        file(moment, place),
        escape(&patch.name)
    );
    let labels = report.results.definition.labels();
    let skin = format!("{}-skin", slug(scene));
    let charts = [picture, skin_map::svg(&skin, (&patch.name, grid), (&labels, looks), verdicts, pressed)];
    let untouched = verdicts.keys().filter(|taxel| !pressed.contains(taxel)).count();
    let marks = marks_in_words(&labels, looks);
    let caption = format!(
        "Scene {scene}, draw {reach_index}, {time_s:.2} s after the start: the moment with the most taxels in contact. The \
         picture shows the forces that they sense, the map of the skin the verdicts. {marks}. Grey marks of the same shapes are \
         untouched taxels (spurious readings, creep, crosstalk): {untouched} of {taxels} here."
    );
    report.page.figure(&caption, &charts);
    report.page.link(&address(moment, place), "Replay this moment in 3-D");
}

/// The file of a moment's picture, beside the page.
fn file(moment: &Moment, place: usize) -> String {
    format!("moment-{place}-{}.png", slug(&moment.scene))
}

/// The pictures of all moments: files beside the page, with their names.
///
/// # Errors
/// If one cannot be drawn.
pub fn pictures(outcome: &ReachMoments) -> Result<Vec<(String, Vec<u8>)>, RenderError> {
    outcome.all().enumerate().map(|(place, moment)| Ok((file(moment, place), close_up(moment)?))).collect()
}

/// The taxels in contact, seen from where their skin faces.
fn close_up(moment: &Moment) -> Result<Vec<u8>, RenderError> {
    let recording = &moment.recording;
    let frame = moment.frame();
    let stage = Stage::of(recording, (known().force_limit_n)(&recording.controller))?;
    let patch = recording.layout.patches.get(moment.patch).zip(frame.patch_pose_world.get(moment.patch));
    let felt = |(patch, pose): (&Patch, &Pose)| -> Vec<(DVec3, DVec3)> {
        let taxels = moment.verdicts.keys().filter_map(|taxel| patch.taxels.get(*taxel));
        let place = |own: &Taxel| (pose.transform_point(own.position_link), pose.transform_vector(own.normal_link));
        taxels.map(place).collect()
    };
    let felt = patch.map(felt).unwrap_or_default();
    let outwards: DVec3 = felt.iter().map(|(_, normal)| *normal).sum();
    // Not from below the table.
    let direction = outwards.normalize_or(DVec3::NEG_Y).with_z(outwards.z.max(0.4));
    let around = felt.iter().flat_map(|(place, _)| [*place - DVec3::splat(AROUND_M), *place + DVec3::splat(AROUND_M)]);
    let seen: Vec<DVec3> = around.collect();
    let camera = if seen.is_empty() { stage.camera(SIZE.aspect()) } else { Camera::around(&seen, direction, SIZE.aspect()) };
    png(&stage.moment(moment.frame_index as u32, frame).rgb(&camera, SIZE)?, SIZE)
}

/// Says in words which mark stands for which verdict.
pub fn marks_in_words(labels: &[&str], looks: &CategoryLooks) -> String {
    let shape = |mark: Mark| match mark {
        Mark::Circle => "circle",
        Mark::Ring => "ring",
        Mark::Square => "square",
        Mark::Triangle => "triangle",
        Mark::Diamond => "diamond",
        Mark::Cross => "cross",
    };
    let article = |word: &str| {
        if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
    };
    let entry = |(place, name): (usize, &str)| {
        let look = looks.look(name);
        let first = match (place, article(look.colour_name)) {
            (0, "a") => "A",
            (0, _) => "An",
            (_, article) => article,
        };
        let verb = if place == 0 { " is" } else { "" };
        let what = match name {
            "uncertain" => name.to_owned(),
            category => format!("{} {category}", article(category)),
        };
        format!("{first} {} {}{verb} {what}", look.colour_name, shape(look.mark))
    };
    let names = labels.iter().copied().chain(["outlier", "uncertain"]);
    names.enumerate().map(entry).collect::<Vec<_>>().join(", ")
}
