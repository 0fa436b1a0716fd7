//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14).

use underbrush_experiments::experiment::moments::{Moment, ReachMoments};
use underbrush_recording::Recording;
use underbrush_render::{RenderError, Size};

use crate::{CategoryLooks, Mark, Report, escape, joined, replay_links, replayed, skin_map, slug};

/// As wide as half the page on a screen with two pixels for one.
const SIZE: Size = Size { width: 960, height: 640 };

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ReachMoments) {
    if outcome.all().next().is_none() {
        return;
    }
    report.section("moments", "moments of reaches");
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
    let Some(patch) = moment.recording.layout.patches.get(moment.patch) else { return };
    let Some(grid) = patch.grid else { return };
    let looks = &report.looks;
    let Moment { verdicts, pressed, .. } = moment;
    let Recording { scene, reach_index, .. } = &moment.recording;
    let (time_s, taxels) = (moment.frame().time_s, verdicts.len());
    let labels = report.results.definition.labels();
    let skin = format!("moment-{place}-skin");
    let charts = [image(moment, place), skin_map::svg(&skin, (&patch.name, grid), (&labels, looks), verdicts, pressed)];
    let untouched = verdicts.keys().filter(|taxel| !pressed.contains(taxel)).count();
    let marks = marks_in_words(&labels, looks);
    let caption = format!(
        "Scene {scene}, draw {reach_index}, {time_s:.2} s after the start: the moment with the most taxels in contact. The \
         picture shows sensed forces as colours of the skin and the forces of contacts as arrows, and the map of the skin \
         shows the verdicts. {marks}. Grey marks of the same shapes are untouched taxels (spurious readings, creep, crosstalk): {untouched} of {taxels} here."
    );
    report.page.figure(&caption, &charts);
    report.page.link(&address(moment, place), "Replay this moment in 3-D");
}

/// A moment's picture on the page.
pub fn image(moment: &Moment, place: usize) -> String {
    let Size { width, height } = SIZE;
    let (file, scene) = (file(moment, place), escape(&moment.recording.scene));
    format!(
        "<img src=\"{file}\" width=\"{width}\" height=\"{height}\" alt=\"The arm among the clutter of scene {scene}\"/>"
    )
}

/// The file of a moment's picture, beside the page.
fn file(moment: &Moment, place: usize) -> String {
    format!("moment-{place}-{}.png", slug(&moment.recording.scene))
}

/// The pictures of all moments: files beside the page, with their names.
///
/// # Errors
/// If one cannot be drawn.
pub fn pictures(outcome: &ReachMoments) -> Result<Vec<(String, Vec<u8>)>, RenderError> {
    let drawn = |(place, moment): (usize, &Moment)| {
        let recording = &moment.recording;
        let stage = replayed::stage(recording)?.with_arrows();
        let scene = stage.moment(moment.frame_index as u32, moment.frame());
        Ok((file(moment, place), scene.png(&stage.camera(SIZE.aspect()), SIZE)?))
    };
    outcome.all().enumerate().map(drawn).collect()
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
    joined(names.enumerate().map(entry), ", ")
}
