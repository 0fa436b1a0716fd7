//! Online verdicts in reaches that touch one category alone (Fig. 11).

use underbrush_experiments::experiment::engineered::{Engineered, EngineeredReaches};
use underbrush_experiments::frame_verdicts::Shares;
use underbrush_recording::distinct;

use crate::drawing::fit_on_axis;
use crate::style::{CORRECT, UNCERTAIN, WRONG};
use crate::{Axis, Dash, Layer, Report, Rows, Shape, Style, Table, chart, joined, replayed};

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
    let (names, letters) = names(reaches);
    let caption = format!("Verdicts on all taxels in contact, over all frames of a reach{letters}.");
    report.page.figure(&caption, &[shares_chart(reaches, names)]);
    let found = reaches.iter().filter(|reach| reach.reach_index.is_some());
    let link =
        |(place, reach): (usize, &Engineered)| (replayed::reach(replayed::ENGINEERED_FILE, place), reach.scene.clone());
    report.page.links("Replay these reaches in 3-D", found.enumerate().map(link));
    report.printed(table(outcome), 10);
}

/// The names of the reaches: their numbers with their categories, or, if these do not fit under the bars, with letters for
/// the categories, and what the letters mean, for the caption.
fn names(reaches: &[Engineered]) -> (Vec<String>, String) {
    let numbered = |name: &dyn Fn(&Engineered) -> String| -> Vec<String> {
        reaches.iter().enumerate().map(|(place, reach)| format!("{}{}", place + 1, name(reach))).collect()
    };
    let full = numbered(&|reach| format!(" {}", reach.category));
    if fit_on_axis(&full) {
        return (full, String::new());
    }
    let categories = distinct(reaches.iter().map(|reach| reach.category));
    let letters = letters(&categories);
    let of =
        |category: &str| categories.iter().position(|own| *own == category).map_or("", |place| letters[place].as_str());
    let meanings = categories.iter().zip(&letters).map(|(category, letters)| format!("{letters} {category} only"));
    (numbered(&|reach| of(reach.category).to_owned()), format!("; {}", joined(meanings, ", ")))
}

/// The initial of each category, or two letters of its name if an earlier category has that initial.
fn letters(categories: &[&str]) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for category in categories {
        let initial: String = category.chars().take(1).flat_map(char::to_uppercase).collect();
        let pairs = category.chars().skip(1).filter(|letter| *letter != '_').map(|letter| format!("{initial}{letter}"));
        let mut candidates = std::iter::once(initial.clone()).chain(pairs);
        // The name itself begins with a small letter, so it is none of the others.
        let own = candidates.find(|own| !taken.contains(own)).unwrap_or_else(|| (*category).to_owned());
        taken.push(own);
    }
    taken
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
    let x = Axis::names("reach and what it touches", names);
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

    fn named(categories: &[&'static str]) -> (Vec<String>, String) {
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

    /// Tests that reaches are named with their category if there is room, and that two categories with the same initial have
    /// different letters. They looked alike.
    #[test]
    fn categories_with_one_initial_have_different_names() {
        assert_eq!(named(&["leaf", "trunk"]), (vec!["1 leaf".to_owned(), "2 trunk".to_owned()], String::new()));
        let (names, letters) = named(&["branch_thick", "branch_thin", "leaf", "branch_thick", "b", "bramble"]);
        assert_eq!(names, ["1B", "2Br", "3L", "4B", "5b", "6Ba"]);
        assert_eq!(letters, "; B branch_thick only, Br branch_thin only, L leaf only, b b only, Ba bramble only");
    }
}
