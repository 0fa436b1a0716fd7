//! `underbrush inspect`: checks a file or folder and shows what it contains.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};
use underbrush_experiments::inspection;
use underbrush_experiments::torque_balance::{TorqueBalance, torque_balance};
use underbrush_report::drawing::Rows;
use underbrush_sim::arm::Arm;
use underbrush_sim::audit::exceeds;

use super::{Overwrite, picture};
use crate::options::whole;
use crate::{Failure, output};

/// Lists that are shown as tables: the key, and those of the columns.
const LISTS: &[(&str, &str)] = &[
    (
        "chain",
        "joint moves limits_deg controller_limits_deg start_deg stiffness_nm_per_rad damping_nm_s_per_rad torque_limit_nm \
         mass_kg shapes",
    ),
    ("patches", "name link taxels grid pitch_mm"),
    ("recordings", "recording scene frames objects contacts goals doubtful"),
];

/// Options of `underbrush inspect`.
#[derive(Args)]
#[command(mut_arg("force", |own| own.requires("still")))]
pub struct InspectOptions {
    /// Scene (.toml) or its name, arm (.toml), data set (folder), recording or trials (.parquet), folder of recordings, trials
    /// (.csv) or model (.json)
    path: PathBuf,
    /// For a scene: seed of the draw that is tried [default: 0]
    #[arg(long, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: Option<u64>,
    /// For a data set: also check that the joint torques and the stored contacts explain the motion of the arm
    #[arg(long)]
    audit: bool,
    /// For an arm: draw it in its start posture, with its taxels, to this file (PNG)
    #[arg(long, value_name = "FILE.png")]
    still: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Checks the file or folder and prints what it contains.
pub fn run(options: InspectOptions, json: bool) -> Result<(), Failure> {
    let mut found = inspection::inspect(&options.path, options.seed.unwrap_or(0))?;
    // Each option is for what has this key.
    let of_kind = [
        (options.seed.is_some(), "goals_with_a_way", "--seed is for scenes"),
        (options.audit, "dataset", "--audit is for data sets"),
        (
            options.still.is_some(),
            "chain",
            "--still is for arms; `underbrush replay --still` draws reaches, `reach --picture` scenes",
        ),
    ];
    if let Some((.., refusal)) = of_kind.iter().find(|(given, key, _)| *given && found.get(key).is_none()) {
        return Err(Failure::usage(format!("{}: {refusal}", options.path.display())));
    }
    let mut passed = None;
    if options.audit {
        let balance = torque_balance(&options.path)?;
        passed = unexplained(&balance);
        found["torque_balance"] = json!(balance);
    }
    if let Some(still) = &options.still {
        let path = &options.path;
        options.overwrite.ending(still, &["png"], "choose such a name", [path])?;
        picture::write_arm(&Arm::load(path)?, still)?;
    }
    output::result(json, &found, || text(&found, 0))?;
    passed.map_or(Ok(()), |complaint| Err(Failure::run(complaint).about(&options.path)))
}

/// The scenes in which torques and contacts do not explain the motion, if there are any.
fn unexplained(balance: &BTreeMap<String, TorqueBalance>) -> Option<String> {
    let scene = |(scene, own): (&String, &TorqueBalance)| {
        let TorqueBalance { residual_share, bound, .. } = *own;
        let bound = bound.filter(|bound| exceeds(residual_share, *bound))?;
        Some(format!("in {scene} {residual_share:.4} of the impulses is missing, more than {bound}"))
    };
    let scenes: Vec<String> = balance.iter().filter_map(scene).collect();
    let complaint = "torques and contacts do not explain the motion of the arm";
    (!scenes.is_empty()).then(|| format!("{complaint}: {}", scenes.join("; ")))
}

/// Nested keys and values, one per line.
fn text(value: &Value, depth: usize) -> String {
    let pad = "  ".repeat(depth);
    match value {
        Value::Object(map) => map
            .iter()
            .map(|(key, value)| match value {
                Value::Object(inner) if !inner.is_empty() => format!("{pad}{key}:\n{}", text(value, depth + 1)),
                Value::String(plain) => format!("{pad}{key}: {plain}\n"),
                Value::Array(list) if list.iter().all(Value::is_object) && !list.is_empty() => {
                    let entries = || list.iter().map(|entry| format!("{pad}  {entry}\n")).collect::<String>();
                    let columns = LISTS.iter().find(|(name, _)| name == key).map(|(_, columns)| columns.split(' '));
                    let text = columns.map_or_else(entries, |keys| table(list, keys));
                    format!("{pad}{key}:\n{text}")
                }
                other => format!("{pad}{key}: {other}\n"),
            })
            .collect(),
        other => format!("{pad}{other}\n"),
    }
}

/// One line for each of these, under the keys.
fn table(list: &[Value], keys: impl Iterator<Item = &'static str>) -> String {
    let cell = |value: &Value| match value {
        Value::Null => "none".into(),
        Value::Object(_) => format!("{} x {}", value["rows"], value["columns"]),
        Value::String(plain) => plain.clone(),
        Value::Array(ends) if ends.iter().all(Value::is_null) => "none".into(),
        Value::Array(ends) => ends.iter().map(Value::to_string).collect::<Vec<_>>().join(" to "),
        other => other.to_string(),
    };
    let column = |rows: Rows<_>, key: &'static str| rows.column(key, |own: &Value| cell(&own[key]));
    keys.fold(Rows::of(list), column).text()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the scenes whose torques do not balance are named, and no others.
    #[test]
    fn torques_that_do_not_balance_are_named() {
        let share = |residual_share| TorqueBalance { residual_share, bound: Some(0.02), ..TorqueBalance::default() };
        let mut balance = BTreeMap::from([("leaf".to_owned(), share(0.01))]);
        assert_eq!(unexplained(&balance), None);
        balance.insert("trunk".into(), share(0.3));
        let text = unexplained(&balance).unwrap();
        assert!(text.contains("in trunk 0.3000") && !text.contains("leaf"), "{text}");
    }
}
