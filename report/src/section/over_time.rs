//! Online verdicts over time in a general reach (Figs. 8 to 10).

use underbrush_classifier::evaluate::StreamFrame;
use underbrush_classifier::feature::FeatureSet;
use underbrush_experiments::experiment::over_time::{AccuracyOverTime, seconds_per_100_taxels};
use underbrush_experiments::frame_verdicts::Classified;

use crate::style::{CORRECT, FIRST, REFERENCE, UNCERTAIN, UNTOUCHED, WRONG};
use crate::{Axis, Dash, Layer, Report, Rows, Shape, Style, Table, chart, counted, fitting, in_words, replayed};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &AccuracyOverTime) {
    if report.results.definition.file.general.is_none() {
        return;
    }
    report.section("over_time", "online verdicts over time");
    let Some(reach) = outcome.online.shown() else {
        report.page.paragraph("No general reach was found in which the patch touches every category.");
        return;
    };
    let labels = report.results.definition.labels();
    let both = if labels.len() == 2 { "both " } else { "" };
    let (every, draw) = (in_words(&labels), reach.reach_index);
    let (found, drawn) = (outcome.online.general.len(), outcome.online.general_drawn);
    let recipe = report.results.definition.main_recipe();
    let (states, seen) = (counted(recipe.states, "state", "states"), seen(&recipe.features));
    let margin_nats = report.results.definition.file.thresholds.uncertain_below_nats;
    let untouched = reach.stream.tally_of(None).total();
    let all = untouched + reach.stream.total().total();
    report.page.paragraph(&format!(
        "This is the first reach in mixed clutter in which the patch touches {both}{every}: draw {draw}. {found} of {drawn} \
         draws {}. The models have {states} and see {seen}; a taxel is uncertain below a margin of {margin_nats} nats. The truth of a \
         taxel is the object that presses most on it. In {untouched} of {all} taxel frames nothing presses (spurious readings, \
         crosstalk and creep); these have no truth and are counted separately.",
        fitting(found, "does so", "do so")
    ));
    let timing = &report.results.timing;
    if let Some(seconds) = timing.figure_8_seconds_per_100_taxels {
        let median = timing.figure_8_median_seconds_per_100_taxels.unwrap_or(f64::NAN);
        let published = timing.figure_8_paper_seconds_per_100_taxels;
        let published = published.map_or(String::new(), |paper| format!(" The paper's mean is {paper} s."));
        let (mean_us, median_us) = (1e6 * seconds, 1e6 * median);
        report.page.paragraph(&format!(
            "A new sample for 100 taxels takes {mean_us:.1} µs on average over the reach, and {median_us:.1} µs in the median \
             frame.{published} Wall times are the only results here that differ from run to run."
        ));
    }
    let used = &outcome.figure_9;
    if let (Some(mean), Some(all)) = (used.mean_samples_used, used.mean_over_reaches) {
        let published =
            used.paper.map_or(String::new(), |paper| format!(" ({:+.1} compared with the paper)", mean - paper));
        report.page.paragraph(&format!(
            "Samples used is the number of samples since contact at which a taxel's present verdict was made, or 0 while it is \
             uncertain, averaged over the taxels in contact. The mean over this reach is {mean:.1}{published}; the mean of {} \
             is {all:.1}.",
            counted(used.reaches, "reach", "reaches")
        ));
        let published = used.paper.map_or(String::new(), |paper| format!(", paper {paper}"));
        report.terminal += &format!("samples used for a verdict: {mean:.1}{published}\n");
    }
    if let Some(shares) = &outcome.figure_10 {
        report.page.paragraph(&format!(
            "Over the whole reach {:.1} % of the taxel frames with truth are correct, {:.1} % misclassified and {:.1} % \
             uncertain.",
            shares.correct_percent, shares.misclassified_percent, shares.uncertain_percent
        ));
    }
    let charts = [computation_time(report, reach), samples_used(outcome, reach)];
    report.page.figure("Computation time and samples used.", &charts);
    report.page.figure(
        "Taxels in contact by verdict. The last chart shows untouched taxels (spurious readings, creep, crosstalk); \
         they have no truth and are not in the other charts.",
        &verdicts(reach),
    );
    report.page.link(&replayed::reach(replayed::TEST_FILE, 0), "Replay this reach in 3-D");
    report.numbers(times_table(reach));
    report.numbers(frames_table(reach));
}

/// `force alone`, or the features.
fn seen(features: &FeatureSet) -> String {
    match features.names().as_slice() {
        [one] => format!("{one} alone"),
        all => all.join(", "),
    }
}

fn computation_time(report: &Report, reach: &Classified) -> String {
    let timing = &report.results.timing;
    let points = seconds_per_100_taxels(reach).map(|(frame, seconds)| (frame.time_s, seconds.unwrap_or(f64::NAN)));
    let told = |mean: f64| format!("Mean {mean:.2e} s for a new sample of 100 taxels in contact.");
    let description = timing.figure_8_seconds_per_100_taxels.map_or("No taxel is in contact.".to_owned(), told);
    let here = Shape::Line(points.collect());
    let paper = timing.figure_8_paper_seconds_per_100_taxels;
    let paper = paper.map(|paper_s| (paper_s, format!(" The paper's mean is {paper_s} s."), " s"));
    let y = Axis::logarithmic("time per 100 taxels / s");
    beside_paper(("figure-8", "Computation time per 100 taxels"), description, here, paper, y, reach)
}

/// A chart over the time of a reach, with the published mean, what the description says of it, and its unit.
fn beside_paper(
    (name, title): (&str, &str),
    mut description: String,
    here: Shape,
    paper: Option<(f64, String, &str)>,
    y: Axis,
    reach: &Classified,
) -> String {
    let mut layers = vec![Layer::new("here", Style::line(FIRST.colour, Dash::Solid), here)];
    if let Some((mean, told, unit)) = paper {
        description += &told;
        let ends = [reach.stream.frames.first(), reach.stream.frames.last()].into_iter().flatten();
        let points = ends.map(|frame| (frame.time_s, mean)).collect();
        layers.push(Layer::new(format!("paper's mean, {mean}{unit}"), REFERENCE, Shape::Line(points)));
    }
    chart(name, title, description, (Axis::from_zero("time / s"), y), layers)
}

fn samples_used(outcome: &AccuracyOverTime, reach: &Classified) -> String {
    let points = reach.stream.frames.iter().map(|frame| {
        let used = if frame.in_contact > 0 { frame.mean_samples_used } else { f64::NAN };
        (frame.time_s, used)
    });
    let told = |mean: f64| format!("Mean over the taxels in contact. The mean over the reach is {mean:.1}.");
    let description = outcome.figure_9.mean_samples_used.map_or("No taxel is in contact.".to_owned(), told);
    let here = Shape::Steps(points.collect());
    let paper = outcome.figure_9.paper.map(|paper| (paper, format!(" In the paper it is {paper}."), ""));
    let y = Axis::from_zero("samples");
    beside_paper(("figure-9", "Samples used for a verdict"), description, here, paper, y, reach)
}

/// Correct, misclassified, uncertain and untouched taxels over time, all on one scale.
fn verdicts(reach: &Classified) -> Vec<String> {
    type Of = fn(&StreamFrame) -> usize;
    let kinds: [(&str, &str, Of); 4] = [
        ("correct", CORRECT, |frame| frame.tally.right),
        ("misclassified", WRONG, |frame| frame.tally.wrong),
        ("uncertain", UNCERTAIN, |frame| frame.tally.uncertain),
        ("untouched", UNTOUCHED, StreamFrame::without_truth),
    ];
    let frames = &reach.stream.frames;
    let highest = kinds.iter().flat_map(|kind| frames.iter().map(kind.2));
    let highest = highest.max().unwrap_or(1).max(1);
    let of_kind = |(name, colour, of): (&str, &'static str, Of)| {
        let points: Vec<(f64, f64)> = frames.iter().map(|frame| (frame.time_s, of(frame) as f64)).collect();
        let max = points.iter().map(|point| point.1).fold(0.0, f64::max);
        let mean = points.iter().map(|point| point.1).sum::<f64>() / points.len().max(1) as f64;
        let axes = (Axis::from_zero("time / s"), Axis::spanning("taxels", 0.0, highest as f64));
        let layers = vec![Layer::new("", Style::line(colour, Dash::Solid), Shape::Steps(points))];
        let description = format!("Over the reach {mean:.1} taxels on average, at most {max}.");
        chart(format!("figure-10-{name}"), format!("Taxels {name}"), description, axes, layers)
    };
    kinds.map(of_kind).to_vec()
}

/// Computation time frame by frame. Only this table and the table of stages contain wall times, which differ from run
/// to run.
fn times_table(reach: &Classified) -> Table {
    Rows::of(seconds_per_100_taxels(reach))
        .number("time_s", 2, |(frame, _)| frame.time_s)
        .column("taxels_in_contact", |(frame, _)| frame.in_contact)
        .number("seconds_per_100_taxels", 9, |(_, seconds)| seconds)
        .table("figure_8_times", "Computation time")
}

/// Samples used and verdicts, frame by frame.
fn frames_table(reach: &Classified) -> Table {
    Rows::of(&reach.stream.frames)
        .number("time_s", 2, |frame| frame.time_s)
        .column("taxels_in_contact", |frame| frame.in_contact)
        .number("mean_samples_used", 2, |frame| frame.mean_samples_used)
        .number("mean_samples_since_contact", 2, |frame| frame.mean_samples_since_contact)
        .column("correct", |frame| frame.tally.right)
        .column("misclassified", |frame| frame.tally.wrong)
        .column("uncertain", |frame| frame.tally.uncertain)
        .column("without_truth", |frame| frame.without_truth())
        .table("figures_9_10", "Samples used and verdicts")
}

#[cfg(test)]
mod tests {
    use std::rc::Rc;

    use underbrush_classifier::evaluate::Stream;
    use underbrush_experiments::experiment::over_time::SamplesUsed;
    use underbrush_experiments::frame_verdicts::Online;

    use super::*;

    /// Tests that a chart of a reach in which the skin feels nothing says so. Its mean was "NaN".
    #[test]
    fn a_reach_that_feels_nothing_has_no_mean() {
        let online = Online {
            engineered: Vec::new(),
            general: Vec::new(),
            general_drawn: 1,
            outlier: Vec::new(),
            outlier_by_chosen: None,
            outlier_drawn: 0,
        };
        let figure_9 = SamplesUsed { mean_samples_used: None, mean_over_reaches: None, reaches: 0, paper: None };
        let outcome = AccuracyOverTime { figure_9, figure_10: None, online: Rc::new(online) };
        let svg = samples_used(&outcome, &Classified { reach_index: 0, stream: Stream::default() });
        assert!(svg.contains("No taxel is in contact.") && !svg.contains("NaN"), "{svg}");
    }
}
