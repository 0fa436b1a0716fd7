use std::collections::{BTreeMap, BTreeSet};

use underbrush_classifier::decision::Verdict;
use underbrush_recording::Grid;
use underbrush_sim::scene::Scene;

use super::elements;
use crate::CategoryLooks;
use crate::section::moments::skin_map;
use crate::style::{LEAF, UNTOUCHED};

const GRID: Grid = Grid { rows: 4, columns: 3, wraps: true };

fn leaf_on(taxels: &[usize]) -> BTreeMap<usize, Verdict> {
    let leaf = || Verdict::Category("leaf".into());
    taxels.iter().map(|taxel| (*taxel, leaf())).collect()
}

/// The skin of a patch with the paper's categories.
fn drawn(name: &str, grid: Grid, verdicts: &BTreeMap<usize, Verdict>, pressed: &BTreeSet<usize>) -> String {
    let labels = (&["leaf", "trunk"][..], &CategoryLooks::default());
    skin_map(name, ("forearm", grid), labels, verdicts, pressed)
}

/// The y coordinate, px downwards, of the text that is exactly `label`, and those of all marks in document order.
fn heights(svg: &str, label: &str) -> (f64, Vec<f64>) {
    let elements = elements(svg);
    let attribute = |own: &super::Element, name: &str| {
        let found = own.1.iter().find(|(own, _)| own == name);
        found.map(|(_, value)| value.clone())
    };
    let text = elements.iter().find(|own| own.0 == "text" && own.2 == label).unwrap();
    let transform = attribute(text, "transform").unwrap();
    let inside = transform.strip_prefix("translate(").unwrap();
    let y = inside.split_once(')').unwrap().0.split_once(' ').unwrap().1;
    // Marks of leaves are triangles; the first in the document is the legend's.
    let marks = elements.iter().filter(|own| own.0 == "path").filter_map(|own| {
        let data = attribute(own, "d")?;
        let y = data.strip_prefix('M')?.split_once(' ')?.1;
        let end = y.find(|character: char| !character.is_ascii_digit() && character != '.')?;
        y[..end].parse().ok()
    });
    (y.parse().unwrap(), marks.collect())
}

/// Tests that the taxels nearest to the hand are drawn nearest to the word "hand": on Cody's forearm this is the row
/// farthest along the arm, by the positions in the skin file and not by row numbers.
#[test]
fn the_hand_is_where_the_picture_says() {
    let scene = Scene::parse("any.toml", super::scenes::LEAVES_AT_FOREARM.into()).unwrap();
    let plan = underbrush_sim::reach::ReachPlan::new(scene, None, 0).unwrap();
    let layout = &plan.arm.skin.layout;
    let patch = &layout.patches[layout.patch_index("forearm").unwrap()];
    let grid = patch.grid.unwrap();
    // The forearm's frame has its z axis from the wrist to the elbow.
    let along = |taxel: &usize| -patch.taxels[*taxel].position_link.z;
    let column = (0..grid.rows).map(|row| row * grid.columns);
    let to_hand = column.clone().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
    let to_elbow = column.min_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
    let place = |taxel: usize| {
        let svg = drawn("any", grid, &leaf_on(&[taxel]), &BTreeSet::from([taxel]));
        let ((hand, marks), (elbow, _)) = (heights(&svg, "hand"), heights(&svg, "elbow"));
        let mark = *marks.last().unwrap();
        ((mark - hand).abs(), (mark - elbow).abs())
    };
    let (hand, elbow) = place(to_hand);
    assert!(hand < elbow, "{hand} {elbow}");
    let (hand, elbow) = place(to_elbow);
    assert!(hand > elbow, "{hand} {elbow}");
}

/// Tests that an untouched taxel is drawn grey and counted in the description, and that a name with
/// special characters of XML gives a document that can be read.
#[test]
fn spurious_readings_are_marked() {
    let svg = drawn("a <\"scene\"> & more", GRID, &leaf_on(&[0, 5]), &BTreeSet::from([5]));
    let elements = elements(&svg);
    let fills = |colour: &str| {
        let marks = elements.iter().filter(|own| own.0 == "path");
        let own = marks.filter(|own| own.1.iter().any(|(name, value)| name == "fill" && value == colour));
        own.count()
    };
    // One mark of each colour on the skin, and one in the legend.
    assert_eq!((fills(LEAF), fills(UNTOUCHED)), (2, 2));
    let description = elements.iter().find(|own| own.0 == "desc").unwrap();
    assert!(description.2.ends_with("nothing presses on 1 of them"), "{}", description.2);
}
