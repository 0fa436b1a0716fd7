//! How each category looks in charts and pictures: its own colour, mark and dash, whatever categories there are.

use std::collections::BTreeSet;

use underbrush_experiments::definition::Experiment;
use underbrush_recording::{Category, distinct};

use crate::drawing::{Dash, Mark, Style};
use crate::style::{LEAF, OUTLIER, TRUNK, UNCERTAIN};

/// The look of a category.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// CSS colour.
    pub colour: &'static str,
    /// Name of the colour.
    pub colour_name: &'static str,
    /// Mark of a taxel.
    pub mark: Mark,
    /// Dash of lines and areas.
    pub dash: Dash,
}

impl Look {
    const fn new((colour, colour_name): (&'static str, &'static str), mark: Mark, dash: Dash) -> Self {
        Look { colour, colour_name, mark, dash }
    }

    /// A line of this colour and dash.
    pub fn line(self) -> Style {
        Style::line(self.colour, self.dash)
    }
}

/// The paper's categories and its verdict `uncertain`, in the paper's colours.
const PAPER: [(&str, Look); 4] = [
    ("leaf", Look::new((LEAF, "green"), Mark::Triangle, Dash::Solid)),
    ("trunk", Look::new((TRUNK, "brown"), Mark::Square, Dash::Dashed)),
    ("outlier", Look::new((OUTLIER, "red"), Mark::Cross, Dash::Solid)),
    ("uncertain", Look::new((UNCERTAIN, "blue"), Mark::Ring, Dash::Solid)),
];

/// Colours, marks and dashes of further categories. The numbers of these have no common factor, so the first 30
/// categories differ in at least one of them.
const COLOURS: [(&str, &str); 5] =
    [("#8c4fb3", "purple"), ("#b58900", "ochre"), ("#0b7285", "teal"), ("#cc79a7", "pink"), ("#000000", "black")];
const MARKS: [Mark; 2] = [Mark::Diamond, Mark::Circle];
const DASHES: [Dash; 3] = [Dash::Dotted, Dash::Dashed, Dash::Solid];

/// The look of each category of an experiment or a picture.
///
/// ```
/// use underbrush_report::category_looks::CategoryLooks;
///
/// let looks = CategoryLooks::of(["leaf", "reed", "vine"]);
/// assert_eq!(looks.look("leaf").colour_name, "green");
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
