//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14).

use underbrush_classifier::decision::Verdict;
use underbrush_experiments::experiment::moments::{Moment, ReachMoments};
use underbrush_recording::Category;
use underbrush_sim::snapshot::Snapshot;

use crate::category_looks::CategoryLooks;
use crate::drawing::{Mark, slug};
use crate::picture::{self, TaxelMark};
use crate::report::Report;
use crate::{replay_links, skin_map};

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
    let patch = moment.layout.patches.get(moment.patch);
    let pressed = moment.verdicts.keys().find(|taxel| moment.pressed.contains(taxel));
    let taxel = patch.zip(pressed).map(|(patch, taxel)| (patch.name.as_str(), *taxel));
    replay_links::moment(replay_links::TEST_FILE, place, moment.snapshot.frame.time_s, taxel)
}

fn add_moment(report: &mut Report, moment: &Moment, place: usize) {
    let Some(patch) = moment.layout.patches.get(moment.patch) else {
        return;
    };
    let Some(grid) = patch.grid else { return };
    let looks = &report.looks;
    let mark = |(taxel, verdict): (&usize, &Verdict)| TaxelMark {
        place: (moment.patch, *taxel),
        look: skin_map::mark_of(looks, verdict.name(), moment.pressed.contains(taxel)),
    };
    let marks: Vec<TaxelMark> = moment.verdicts.iter().map(mark).collect();
    let description = format!("The patch with {} taxels in contact, marked by verdict.", marks.len());
    let name = slug(&moment.scene);
    let mut charts = picture::close_ups(&name, &moment.snapshot, looks, &moment.layout, &marks, &description);
    let skin = format!("{name}-skin");
    let labels = report.results.definition.labels();
    charts.push(skin_map::svg(&skin, (&patch.name, grid), (&labels, looks), &moment.verdicts, &moment.pressed));
    let untouched = moment.verdicts.keys().filter(|taxel| !moment.pressed.contains(taxel)).count();
    let Moment { scene, reach_index, snapshot, verdicts, .. } = moment;
    let (time_s, taxels) = (snapshot.frame.time_s, verdicts.len());
    let (marks, objects) = (marks_in_words(&labels, looks), objects_in_words(snapshot, looks));
    let caption = format!(
        "Scene {scene}, draw {reach_index}, {time_s:.2} s after the start: the moment with the most taxels in contact. {marks}. \
         Grey marks of the same shapes are untouched taxels (spurious readings, creep, crosstalk): {untouched} of \
         {taxels} here. Taxels on the far side are seen through the arm. {objects}."
    );
    report.page.figure(&caption, &charts);
    report.page.link(&address(moment, place), "Replay this moment in 3-D");
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

/// Says in words which colour the objects of each category in a picture have.
fn objects_in_words(snapshot: &Snapshot, looks: &CategoryLooks) -> String {
    let categories: std::collections::BTreeSet<Category> =
        snapshot.objects.iter().map(|object| object.category).collect();
    let colours = categories.into_iter().map(|category| match category {
        Category::BLOCK => "foam blocks sand-coloured".to_owned(),
        other => format!("{} {}", other.name(), looks.look(other.name()).colour_name),
    });
    format!("Colours of objects: {}", colours.collect::<Vec<_>>().join(", "))
}
