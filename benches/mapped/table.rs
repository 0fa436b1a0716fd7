//! Means by scene and controller, and paired differences, with intervals.

use std::collections::BTreeMap;

use super::{CONTROLLERS, SUMS};

/// A quantity is a quotient of two sums over reaches; without a divisor it is a mean over reaches.
const QUANTITIES: [(&str, &str, Option<&str>, f64); 8] = [
    ("goals, %", "reached", Some("goals"), 100.0),
    ("of goals with a way, %", "reached", Some("have_way"), 100.0),
    ("in 10 s, %", "reached_10s", Some("goals"), 100.0),
    ("s a goal", "seconds", Some("goals"), 1.0),
    ("peak on trunks, N", "trunk_peak_n", None, 1.0),
    ("impulse on trunks, N s", "trunk_impulse_n_s", None, 1.0),
    ("peak on leaves, N", "leaf_peak_n", None, 1.0),
    ("safety stops", "safety_stops", None, 1.0),
];

/// Differences that are printed: the first controller minus the second.
const PAIRS: [(&str, &str); 9] = [
    ("blind 3 N", "cody-2013"),
    ("blind 3 N", "cody-2013; 3 retries"),
    ("blind 3 N", "cody-2013; path rule of 10 s; 3 retries"),
    ("truth", "blind 3 N"),
    ("truth", "blind 6 N"),
    ("model", "blind 3 N"),
    ("model", "blind 6 N"),
    ("swapped", "blind 3 N"),
    ("known", "truth"),
];

const RESAMPLES: usize = 2000;

/// The rows of one reach of a scene, by controller.
type Reach = BTreeMap<String, Vec<f64>>;

/// Prints the tables of a file of rows: one for each scene, and one for all scenes together.
pub fn print(text: &str) {
    let mut scenes: BTreeMap<String, BTreeMap<u64, Reach>> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with("scene,")) {
        let cells: Vec<&str> = line.split(',').collect();
        let [scene, index, controller, sums @ ..] = &cells[..] else { panic!("{line}") };
        let sums: Vec<f64> = sums.iter().map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(sums.len(), SUMS.len(), "{line}");
        let of_scene = scenes.entry((*scene).to_owned()).or_default();
        of_scene.entry(index.parse().unwrap()).or_default().insert((*controller).to_owned(), sums);
    }
    // Reaches that all controllers have run.
    let most = scenes.values().flat_map(BTreeMap::values).map(BTreeMap::len).max().unwrap_or_default();
    let mut all: Vec<&Reach> = Vec::new();
    for (scene, reaches) in &scenes {
        let reaches: Vec<&Reach> = reaches.values().filter(|reach| reach.len() == most).collect();
        one(scene, &reaches);
        all.extend(reaches);
    }
    one("all scenes", &all);
}

fn one(title: &str, reaches: &[&Reach]) {
    let Some(first) = reaches.first() else { return };
    let way = 100.0 * reaches.iter().filter_map(|reach| reach.values().next()).map(|sums| sums[1]).sum::<f64>()
        / reaches.iter().filter_map(|reach| reach.values().next()).map(|sums| sums[0]).sum::<f64>();
    println!("\n### {title}: {} reaches; {way:.1} % of the goals have a way\n", reaches.len());
    let names: Vec<&str> = QUANTITIES.iter().map(|(name, ..)| *name).collect();
    println!("| controller | {} |\n|---{}|", names.join(" | "), "|---".repeat(names.len()));
    for controller in CONTROLLERS.map(|name| name.replace(',', ";")).iter().filter(|name| first.contains_key(*name)) {
        let cell = |(_, sum, divisor, scale): &(&str, &str, Option<&str>, f64)| {
            let of = |reaches: &[&Reach]| scale * quotient(reaches, controller, sum, *divisor);
            let [low, high] = interval(reaches, &of);
            match *sum {
                "reached" | "seconds" | "trunk_peak_n" => format!("{:.1} ({low:.1} to {high:.1})", of(reaches)),
                _ => format!("{:.1}", of(reaches)),
            }
        };
        let cells: Vec<String> = QUANTITIES.iter().map(cell).collect();
        println!("| {controller} | {} |", cells.join(" | "));
    }
    println!("\n| difference | goals, points | s a goal | peak on trunks, N |\n|---|---|---|---|");
    for (own, other) in PAIRS {
        if !first.contains_key(own) || !first.contains_key(other) {
            continue;
        }
        let cell = |(sum, divisor, scale): (&str, Option<&str>, f64)| {
            let of = |reaches: &[&Reach]| {
                scale * (quotient(reaches, own, sum, divisor) - quotient(reaches, other, sum, divisor))
            };
            let [low, high] = interval(reaches, &of);
            format!("{:+.1} ({low:+.1} to {high:+.1})", of(reaches))
        };
        let quantities =
            [("reached", Some("goals"), 100.0), ("seconds", Some("goals"), 1.0), ("trunk_peak_n", None, 1.0)];
        println!("| {own} − {other} | {} |", quantities.map(cell).join(" | "));
    }
}

fn quotient(reaches: &[&Reach], controller: &str, sum: &str, divisor: Option<&str>) -> f64 {
    let total = |name: &str| -> f64 {
        let column = SUMS.iter().position(|other| *other == name).unwrap();
        reaches.iter().map(|reach| reach[controller][column]).sum()
    };
    total(sum) / divisor.map_or(reaches.len() as f64, total)
}

/// The 95 % interval by resampling whole reaches.
fn interval(reaches: &[&Reach], of: &dyn Fn(&[&Reach]) -> f64) -> [f64; 2] {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut draw = || {
        // xorshift64: good enough to draw reaches.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        reaches[(state % reaches.len() as u64) as usize]
    };
    let mut values: Vec<f64> =
        (0..RESAMPLES).map(|_| of(&(0..reaches.len()).map(|_| draw()).collect::<Vec<_>>())).collect();
    values.sort_by(f64::total_cmp);
    [0.025, 0.975].map(|share| values[(share * RESAMPLES as f64) as usize])
}
