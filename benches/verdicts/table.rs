//! Means, and paired differences with intervals.

use std::collections::BTreeMap;

use super::{CONTROLLERS, SUMS};

/// A quantity is a quotient of two sums over reaches; without a divisor it is a mean over reaches.
const QUANTITIES: [(&str, &str, Option<&str>); 11] = [
    ("share of goals reached", "reached", Some("goals")),
    ("time for each goal reached, s", "seconds", Some("reached")),
    ("time of a goal that was reached, s", "seconds_reached", Some("reached")),
    ("largest force on a trunk, N", "trunk_peak_n", None),
    ("largest force of a taxel on a trunk, N", "trunk_peak_taxel_n", None),
    ("the same on the forearm, N", "trunk_peak_taxel_forearm_n", None),
    ("mean force on a trunk, N", "trunk_newton_frames", Some("trunk_frames")),
    ("mean force of a forearm taxel on a trunk, N", "trunk_forearm_taxel_newtons", Some("trunk_forearm_taxels")),
    ("largest force of a taxel on a leaf, N", "leaf_peak_taxel_n", None),
    ("mean force of a taxel on a leaf, N", "leaf_taxel_newtons", Some("leaf_taxels")),
    ("steps without a solution", "infeasible_steps", None),
];

const RESAMPLES: usize = 4000;

/// The rows of one reach, in the order of the controllers.
type Rows = [Vec<f64>; CONTROLLERS.len()];

/// Prints the table of a file of rows.
pub fn print(text: &str) {
    let mut reaches: BTreeMap<u64, BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with("reach,")) {
        let mut cells = line.split(',');
        let (index, controller) = (cells.next().unwrap(), cells.next().unwrap());
        let sums: Vec<f64> = cells.map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(sums.len(), SUMS.len(), "{line}");
        let of_reach = reaches.entry(index.parse().unwrap()).or_default();
        assert!(of_reach.insert(controller, sums).is_none(), "twice: {line}");
    }
    let reaches: Vec<Rows> =
        reaches.values().map(|of_reach| CONTROLLERS.map(|controller| of_reach[controller].clone())).collect();
    println!("{} reaches\n", reaches.len());
    println!(
        "| | {} | {} |",
        CONTROLLERS.join(" | "),
        CONTROLLERS[1..].iter().map(|name| format!("{name} − without")).collect::<Vec<_>>().join(" | ")
    );
    println!("|---{}", "|---".repeat(2 * CONTROLLERS.len() - 1) + "|");
    for (name, sum, divisor) in QUANTITIES {
        let all: Vec<&Rows> = reaches.iter().collect();
        let own = |controller: usize| format!("{:.3}", quotient(&all, controller, sum, divisor));
        let values: Vec<String> = (0..CONTROLLERS.len()).map(own).collect();
        let differences: Vec<String> =
            (1..CONTROLLERS.len()).map(|controller| difference(&all, controller, sum, divisor)).collect();
        println!("| {name} | {} | {} |", values.join(" | "), differences.join(" | "));
    }
}

fn quotient(reaches: &[&Rows], controller: usize, sum: &str, divisor: Option<&str>) -> f64 {
    let total = |name: &str| -> f64 {
        let column = SUMS.iter().position(|other| *other == name).unwrap();
        reaches.iter().map(|rows| rows[controller][column]).sum()
    };
    total(sum) / divisor.map_or(reaches.len() as f64, total)
}

/// The difference from the first controller, its standard error, and its 95 % interval, by resampling reaches.
fn difference(reaches: &[&Rows], controller: usize, sum: &str, divisor: Option<&str>) -> String {
    let of = |reaches: &[&Rows]| quotient(reaches, controller, sum, divisor) - quotient(reaches, 0, sum, divisor);
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
    let mean = values.iter().sum::<f64>() / RESAMPLES as f64;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (RESAMPLES - 1) as f64;
    let [low, high] = [0.025, 0.975].map(|share| values[(share * RESAMPLES as f64) as usize]);
    format!("{:+.3} ± {:.3} ({low:+.3} to {high:+.3})", of(reaches), variance.sqrt())
}
