//! Colours and marks of charts, and how each category looks in charts and pictures, whatever categories there are.
//! Colour-blind readers can tell the colours apart, and every layer also has its own mark, dash or hatching.

use std::collections::BTreeSet;

use underbrush_experiments::Experiment;
use underbrush_recording::{Category, distinct};

use crate::drawing::{Dash, Mark, Style};

/// Leaves.
pub const LEAF: &str = "#1b8a4b";
/// Trunks.
pub const TRUNK: &str = "#6b4423";
/// Outliers.
pub const OUTLIER: &str = "#c8102e";
/// Taxels without a verdict.
pub const UNCERTAIN: &str = "#1f5fbf";
/// Untouched taxels that read a force.
pub const UNTOUCHED: &str = "#8a939c";
/// Correct verdicts.
pub const CORRECT: &str = "#009e73";
/// Wrong verdicts.
pub const WRONG: &str = "#d55e00";
/// Text and reference lines.
pub const INK: &str = "#222222";
/// The first of several series: the first recipe, the fewest states.
pub const FIRST: Style = Style::marked("#0072b2", Dash::Solid, Mark::Circle);
/// Levels and diagonals to compare with.
pub const REFERENCE: Style = Style::line(INK, Dash::Dotted);
/// Published figures.
pub const PUBLISHED: Style = Style::marked(INK, Dash::Dotted, Mark::Diamond);
/// The majority baseline: a line without marks.
pub const MAJORITY: Style = Style::line("#7a828a", Dash::Dashed);

/// The majority baseline of single points.
pub const MAJORITY_MARK: Style = Style::marked("#7a828a", Dash::Dotted, Mark::Cross);

/// Series of a chart, in order.
const SERIES: [Style; 7] = [
    FIRST,
    Style::marked("#56b4e9", Dash::Dashed, Mark::Circle),
    Style::marked(TRUNK, Dash::Dashed, Mark::Square),
    Style::marked(OUTLIER, Dash::Dashed, Mark::Cross),
    Style::marked(WRONG, Dash::Solid, Mark::Diamond),
    Style::marked(UNCERTAIN, Dash::Dashed, Mark::Ring),
    Style::marked(CORRECT, Dash::Solid, Mark::Triangle),
];

/// Two series beside each other, in the two most different styles.
const PAIRED: [Style; 2] = [FIRST, Style::marked(WRONG, Dash::Dashed, Mark::Square)];

/// The style of a series by its position; styles repeat if there are more series.
pub fn series(place: usize) -> Style {
    SERIES[place % SERIES.len()]
}

/// The style of a series by its position, for charts with few series.
pub fn paired(place: usize) -> Style {
    PAIRED.get(place).copied().unwrap_or_else(|| series(place + 1))
}

/// Offset of the points of one of several series from their positions on an axis of names, so that the series do not
/// cover each other.
pub fn aside(place: usize, of: usize) -> f64 {
    let centred = place as f64 - (of.max(1) - 1) as f64 / 2.0;
    0.14 * centred
}

/// The look of a category.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// CSS colour.
    pub colour: &'static str,
    /// Mark of a taxel.
    pub mark: Mark,
    /// Dash of lines and areas.
    pub dash: Dash,
}

impl Look {
    const fn new(colour: &'static str, mark: Mark, dash: Dash) -> Self {
        Look { colour, mark, dash }
    }

    /// A line of this colour and dash.
    pub fn line(self) -> Style {
        Style::line(self.colour, self.dash)
    }
}

/// The paper's categories and its verdict `uncertain`, in the paper's colours.
const PAPER: [(&str, Look); 4] = [
    ("leaf", Look::new(LEAF, Mark::Triangle, Dash::Solid)),
    ("trunk", Look::new(TRUNK, Mark::Square, Dash::Dashed)),
    ("outlier", Look::new(OUTLIER, Mark::Cross, Dash::Solid)),
    ("uncertain", Look::new(UNCERTAIN, Mark::Ring, Dash::Solid)),
];

/// Colours, marks and dashes of further categories. The numbers of these have no common factor, so the first 30
/// categories differ in at least one of them.
const COLOURS: [&str; 5] = ["#8c4fb3", "#b58900", "#0b7285", "#cc79a7", "#000000"];
const MARKS: [Mark; 2] = [Mark::Diamond, Mark::Circle];
const DASHES: [Dash; 3] = [Dash::Dotted, Dash::Dashed, Dash::Solid];

/// The look of each category of an experiment or a picture.
///
/// ```
/// use underbrush_report::CategoryLooks;
///
/// let looks = CategoryLooks::of(["leaf", "reed", "vine"]);
/// assert_eq!(looks.look("leaf").colour, "#1b8a4b");
/// assert_ne!(looks.look("reed"), looks.look("vine"));
/// ```
#[derive(Clone, Debug, Default)]
pub struct CategoryLooks {
    /// Names of the categories that are not the paper's. The position of a name decides its look.
    further: Vec<String>,
}

impl CategoryLooks {
    /// The looks of some categories, by name. The order of the names decides the look of further ones.
    pub fn of<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let is_known = |name: &str| name == Category::BLOCK.name() || PAPER.iter().any(|(own, _)| *own == name);
        let further = distinct(names.into_iter().filter(|name| !is_known(name)));
        CategoryLooks { further: further.into_iter().map(str::to_owned).collect() }
    }

    /// The looks of an experiment's labels and of all objects in its scenes.
    pub fn of_experiment(experiment: &Experiment) -> Self {
        let groups = experiment.scenes.values().flat_map(|scene| scene.file.objects.groups());
        let objects: BTreeSet<Category> = groups.map(|(_, _, group)| group.category).collect();
        let mut names = experiment.labels();
        names.extend(objects.iter().map(|category| category.name()));
        Self::of(names)
    }

    /// The look of a category or of the verdict `uncertain`.
    pub fn look(&self, name: &str) -> Look {
        if let Some((_, look)) = PAPER.iter().find(|(own, _)| *own == name) {
            return *look;
        }
        let place = self.further.iter().position(|own| own == name).unwrap_or(self.further.len());
        Look::new(COLOURS[place % COLOURS.len()], MARKS[place % MARKS.len()], DASHES[place % DASHES.len()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that no two categories look alike, whether they are the paper's or further ones, and that naming one twice
    /// changes nothing.
    #[test]
    fn every_category_looks_different() {
        let further: Vec<String> = (0..12).map(|number| format!("category {number}")).collect();
        let names = ["trunk", "leaf"].into_iter().chain(further.iter().map(String::as_str));
        let names: Vec<&str> = names.chain(["outlier", "uncertain"]).collect();
        let looks = CategoryLooks::of(names.iter().chain(&names).copied());
        for (place, name) in names.iter().enumerate() {
            for other in &names[place + 1..] {
                assert_ne!(looks.look(name), looks.look(other), "{name}, {other}");
            }
        }
        // A category that was not announced looks unlike all that were.
        let reed = CategoryLooks::of(["cane"]).look("reed");
        assert_ne!(reed, CategoryLooks::of(["cane"]).look("cane"));
        for paper in ["leaf", "trunk", "outlier", "uncertain"] {
            assert_ne!(reed.colour, CategoryLooks::default().look(paper).colour);
        }
    }
}
