//! Force and motion of one typical trial of each category (Fig. 5).

use underbrush_experiments::experiment::example_trials::{Example, ExampleTrials, Typical};
use underbrush_recording::{FRAME_PERIOD_S, Sample};

use crate::{Axis, CategoryLooks, Layer, Report, Rows, Shape, Table, chart, joined, replayed};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ExampleTrials) {
    if outcome.figure_5.is_empty() {
        return;
    }
    report.section("example_trials", "force and motion of a trial");
    let part = |Example { category, peak_force_n, motion_m, samples, .. }: &Example| {
        let (motion_cm, lasts_s) = (100.0 * motion_m, *samples as f64 * FRAME_PERIOD_S);
        format!("{category}: peak {peak_force_n:.2} N, motion up to {motion_cm:.1} cm in {lasts_s:.2} s")
    };
    let caption = format!(
        "One taxel trial of each category: among those of a second or more, if there are any, the one with the median peak \
         force. {}.",
        joined(outcome.figure_5.iter().map(part), "; ")
    );
    let medians = &outcome.figure_5_medians;
    let against_paper = report.published().and_then(|_| against_paper(medians));
    report.page.paragraph(&against_paper.unwrap_or_else(|| typical(medians)));
    report.page.figure(&caption, &charts(outcome, &report.looks));
    let links = outcome.figure_5.iter().enumerate().map(|(place, own)| (address(own, place), own.category.clone()));
    report.page.links("Replay these trials in 3-D", links);
    report.numbers(table(outcome));
}

/// The address of the beginning of a trial on the replay page.
fn address(example: &Example, place: usize) -> String {
    let time_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
    let patch = example.data.patch.as_deref();
    let taxel = patch.zip(example.taxel).map(|(patch, taxel)| (patch, taxel as usize));
    replayed::moment(replayed::TRAINING_FILE, place, time_s, taxel)
}

/// The medians of each category.
fn typical(medians: &[Typical]) -> String {
    let part = |Typical { category, trials, force_after_100_ms_n: early_n, peak_force_n, motion_m }: &Typical| {
        let (motion_cm, is_short) = (100.0 * motion_m, early_n.is_nan());
        let early = if is_short { "none lasts 0.1 s".to_owned() } else { format!("force {early_n:.2} N after 0.1 s") };
        format!("{category}, {trials} trials: {early}, peak {peak_force_n:.2} N, motion {motion_cm:.1} cm")
    };
    let parts = joined(medians.iter().map(part), "; ");
    format!("Medians over the trials in which something touched the taxel. {parts}.")
}

/// Compares the paper's statements with the medians over all touched trials; `None` without leaves or trunks.
pub fn against_paper(medians: &[Typical]) -> Option<String> {
    let of = |category: &str| medians.iter().find(|own| own.category == category);
    let (leaf, trunk) = (of("leaf")?, of("trunk")?);
    let is_larger = |what: &str, of: fn(&Typical) -> f64, holds: bool| {
        let larger = if of(trunk) > of(leaf) { "larger" } else { "not larger" };
        let agreement = if holds { "as in the paper" } else { "unlike in the paper" };
        format!("{what} is {larger} on trunks, {agreement}")
    };
    let force = |what: &str, of: fn(&Typical) -> f64| {
        let (trunk_n, leaf_n) = (of(trunk), of(leaf));
        format!("{} ({trunk_n:.2} N, leaves {leaf_n:.2} N)", is_larger(what, of, trunk_n > leaf_n))
    };
    let early = match [leaf, trunk].iter().any(|own| own.force_after_100_ms_n.is_nan()) {
        true => "too few of them last 0.1 s to compare the force then".to_owned(),
        false => force("the force 0.1 s after contact", |own| own.force_after_100_ms_n),
    };
    let peak = force("the peak force", |own| own.peak_force_n);
    let motion = is_larger("the motion", |own| own.motion_m, trunk.motion_m < leaf.motion_m);
    let [trunk_cm, leaf_cm] = [trunk, leaf].map(|own| 100.0 * own.motion_m);
    Some(format!(
        "Medians over all trials in which something touched the taxel, {} on trunks and {} on leaves: {early}; {peak}; {motion} \
         ({trunk_cm:.1} cm, leaves {leaf_cm:.1} cm).",
        trunk.trials, leaf.trials
    ))
}

/// Force and motion over time, one chart each.
pub fn charts(outcome: &ExampleTrials, looks: &CategoryLooks) -> Vec<String> {
    let of = |what: &str, label: &str, unit: &str, value: fn(&Sample) -> Option<f64>| {
        let mut description = format!("{what} over time since contact.");
        let mut layers = Vec::new();
        for example in &outcome.figure_5 {
            let start_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
            let samples = example.data.samples.iter();
            let points: Vec<(f64, f64)> =
                samples.filter_map(|sample| Some((sample.time_s - start_s, value(sample)?))).collect();
            let max = points.iter().map(|point| point.1).fold(0.0, f64::max);
            let lasts_s = points.last().map_or(0.0, |point| point.0);
            description += &format!(" {}: up to {max:.3} {unit} in {lasts_s:.2} s.", example.category);
            let style = looks.look(&example.category).line();
            layers.push(Layer::new(example.category.as_str(), style, Shape::Line(points)));
        }
        let axes = (Axis::from_zero("time since contact / s"), Axis::from_zero(label));
        chart(format!("figure-5-{what}"), format!("{what} of a taxel"), description, axes, layers)
    };
    vec![
        of("Force", "force / N", "N", |sample| Some(sample.force_n)),
        of("Motion", "motion / m", "m", |sample| sample.motion_m),
    ]
}

/// All examples, sample by sample.
fn table(outcome: &ExampleTrials) -> Table {
    let samples = outcome.figure_5.iter().flat_map(|example| {
        let start_s = example.data.samples.first().map_or(0.0, |sample| sample.time_s);
        example.data.samples.iter().map(move |sample| (example, sample, sample.time_s - start_s))
    });
    Rows::of(samples)
        .column("category", |(example, ..)| example.category.as_str())
        .column("trial", |(example, ..)| example.trial as usize)
        .number("time_since_contact_s", 2, |(.., since_s)| since_s)
        .number("force_n", 3, |(_, sample, _)| sample.force_n)
        .number("motion_m", 4, |(_, sample, _)| sample.motion_m)
        .table("figure_5", "Example trials")
}
