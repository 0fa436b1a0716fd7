//! Online verdicts in reaches that touch one category alone (Fig. 11).

use underbrush_experiments::experiment::engineered::{Engineered, EngineeredReaches};
use underbrush_experiments::frame_verdicts::Shares;

use crate::drawing::fit_on_axis;
use crate::style::{CORRECT, UNCERTAIN, WRONG};
use crate::{Axis, Dash, Layer, Report, Rows, Shape, Style, Table, chart, replayed};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &EngineeredReaches) {
    let reaches = &outcome.figure_11;
    if reaches.is_empty() {
        return;
    }
    report.section("engineered", &format!("{} engineered reaches", reaches.len()));
    let found: Vec<&Shares> = reaches.iter().filter_map(|reach| reach.shares.as_ref()).collect();
    let drawn: u64 = reaches.iter().map(|reach| reach.drawn).sum();
    let mostly_correct = found.iter().filter(|own| own.correct_percent > own.misclassified_percent).count();
    let (found, all) = (found.len(), reaches.len());
    report.page.paragraph(&format!(
        "Each scene is drawn until, by ground truth, the patch touches its category and nothing else, and feels it. {found} of \
         {all} scenes gave such a reach, in {drawn} draws. In {mostly_correct} of them more taxels are correct than \
         misclassified. The truth of every taxel is the category of the scene, even if nothing presses on it, as in the paper; \
         the table gives the share of such taxels as untouched."
    ));
    let caption = "Verdicts on all taxels in contact, over all frames of a reach.";
    report.page.figure(caption, &[shares_chart(reaches, names(reaches))]);
    let found = reaches.iter().filter(|reach| reach.reach_index.is_some());
    let link =
        |(place, reach): (usize, &Engineered)| (replayed::reach(replayed::ENGINEERED_FILE, place), reach.scene.clone());
    report.page.links("Replay these reaches in 3-D", found.enumerate().map(link));
    report.printed(table(outcome), 10);
}

/// The numbers of the reaches with their categories, or alone if these do not fit under the bars.
fn names(reaches: &[Engineered]) -> Vec<String> {
    let full: Vec<String> = (1..).zip(reaches).map(|(number, reach)| format!("{number} {}", reach.category)).collect();
    if fit_on_axis(&full) { full } else { (1..=reaches.len()).map(|number| number.to_string()).collect() }
}

fn shares_chart(reaches: &[Engineered], names: Vec<String>) -> String {
    let mut description = String::from("Per cent correct, misclassified and uncertain.");
    let mut heights = [const { Vec::new() }; 3];
    let percents = |own: &Shares| [own.correct_percent, own.misclassified_percent, own.uncertain_percent];
    for (name, reach) in names.iter().zip(reaches) {
        let shares = reach.shares.as_ref().map(percents);
        description += &match shares {
            Some([correct, wrong, uncertain]) => format!(" {name}: {correct:.0}, {wrong:.0}, {uncertain:.0}."),
            None => format!(" {name}: no such reach was drawn."),
        };
        for (own, share) in heights.iter_mut().zip(shares.unwrap_or([f64::NAN; 3])) {
            own.push(share);
        }
    }
    let [correct, wrong, uncertain] = heights;
    let layers = vec![
        Layer::new("correct", Style::line(CORRECT, Dash::Solid), Shape::Bars(correct)),
        Layer::new("misclassified", Style::line(WRONG, Dash::Dashed), Shape::Bars(wrong)),
        Layer::new("uncertain", Style::line(UNCERTAIN, Dash::Dotted), Shape::Bars(uncertain)),
    ];
    let x = Axis::names("reach, by its row in the table", names);
    let y = Axis::spanning("taxels in contact / %", 0.0, 100.0);
    chart("figure-11", "Verdicts in engineered reaches", description, (x, y), layers)
}

fn table(outcome: &EngineeredReaches) -> Table {
    let shares = |reach: &Engineered, of: fn(&Shares) -> f64| reach.shares.as_ref().map(of);
    Rows::of(outcome.figure_11.iter().enumerate())
        .column("reach", |(place, _)| place + 1)
        .column("scene", |(_, reach)| reach.scene.as_str())
        .column("category", |(_, reach)| reach.category)
        .column("draw", |(_, reach)| reach.reach_index.map(|index| index as usize))
        .number("correct / %", 1, |(_, reach)| shares(reach, |own| own.correct_percent))
        .number("misclassified / %", 1, |(_, reach)| shares(reach, |own| own.misclassified_percent))
        .number("uncertain / %", 1, |(_, reach)| shares(reach, |own| own.uncertain_percent))
        .column("taxel frames", |(_, reach)| reach.shares.as_ref().map(|shares| shares.taxel_frames))
        .number("untouched / %", 1, |(_, reach)| reach.untouched_percent)
        .number("samples used", 1, |(_, reach)| reach.mean_samples_used)
        .table("figure_11", "Verdicts on the taxels in contact, over all frames of each engineered reach")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(categories: &[&'static str]) -> Vec<String> {
        let reach = |&category: &&'static str| Engineered {
            scene: "any".into(),
            category,
            reach_index: None,
            drawn: 1,
            shares: None,
            untouched_percent: None,
            mean_samples_used: None,
        };
        names(&categories.iter().map(reach).collect::<Vec<_>>())
    }

    /// Tests that reaches are named with their category if there is room, and with their numbers alone if there is none.
    #[test]
    fn reaches_are_named_with_their_category_if_there_is_room() {
        assert_eq!(named(&["leaf", "trunk"]), ["1 leaf", "2 trunk"]);
        assert_eq!(named(&["branch_thick", "branch_thin", "leaf", "branch_thick", "b"]), ["1", "2", "3", "4", "5"]);
    }
}
