use underbrush_recording::{Region, Sample, Trial};

use super::*;

fn trial(samples: &[(f64, Option<f64>)]) -> Trial {
    let samples = samples
        .iter()
        .enumerate()
        .map(|(k, &(force_n, motion_m))| Sample { time_s: k as f64 * 0.01, force_n, motion_m, ..Sample::default() })
        .collect();
    Trial { trial: 7, category: None, reach: None, patch: None, taxel: None, samples }
}

/// Tests that names, columns and text give the same list in the same order, and that lists joined by `+` are read and
/// written.
#[test]
fn names_columns_and_text_agree() {
    let every = FeatureSet::from_names(&FEATURES.map(|feature| feature.name)).unwrap();
    let swapped = FeatureSet::from_names(&["motion_m", "force_n"]).unwrap();
    for set in [FeatureSet::FORCE, FeatureSet::FORCE_AND_MOTION, every, swapped] {
        assert_eq!(FeatureSet::from_names(&set.names()), Ok(set));
        assert_eq!(FeatureSet::from_names(&set.columns()), Ok(set));
        assert_eq!(set.to_string().parse(), Ok(set));
        assert_eq!(set.names().join(",").parse(), Ok(set));
        let json = serde_json::to_string(&set).unwrap();
        assert_eq!(serde_json::from_str::<FeatureSet>(&json).unwrap(), set);
    }
    assert_ne!(swapped, FeatureSet::FORCE_AND_MOTION);
    assert_eq!("force+motion".parse(), Ok(FeatureSet::FORCE_AND_MOTION));
    assert_eq!(FeatureSet::FORCE_AND_MOTION.to_string(), "force+motion");
}

/// Tests the errors for invalid lists, including a list longer than [`FEATURES`].
#[test]
fn bad_lists_are_refused() {
    let unknown = FeatureError::Unknown("warmth".into());
    assert_eq!("force,warmth".parse::<FeatureSet>(), Err(unknown.clone()));
    assert!(unknown.to_string().contains("force, motion, area"), "{unknown}");
    let twice = [FEATURES.map(|feature| feature.name), FEATURES.map(|feature| feature.name)].concat();
    assert_eq!(FeatureSet::from_names(&twice), Err(FeatureError::Repeated("force")));
    assert_eq!(FeatureSet::from_names::<&str>(&[]), Err(FeatureError::NoFeatures));
    // A model of such a channel could be fitted but not saved.
    for found in ["column:a+b", "column:a,b"] {
        assert_eq!(FeatureSet::from_names(&[found]), Err(FeatureError::Unknown(found.into())));
    }
}

/// Tests that no two features share a name or a column, that columns with a unit end in it, and that each reads its own
/// value of a sample.
#[test]
fn every_feature_reads_its_own_column() {
    let region = Region { taxels: 3, largest_force_n: 4.0, force_sum_n: 5.0 };
    let sample = Sample { time_s: 0.0, force_n: 1.0, motion_m: Some(2.0), region: Some(region), ..Sample::default() };
    let expected = [
        ("force_n", 1.0),
        ("motion_m", 2.0),
        ("region_taxels", 3.0),
        ("region_largest_force_n", 4.0),
        ("region_force_sum_n", 5.0),
    ];
    let found: Vec<_> = FEATURES.iter().map(|feature| (feature.column, feature.read(&sample).unwrap())).collect();
    assert_eq!(found, expected);
    for feature in FEATURES {
        assert_eq!(Feature::find(feature.name), Some(feature));
        assert_eq!(Feature::find(feature.column), Some(feature));
        let unit = feature.limits.unit.to_lowercase();
        assert!(feature.column.ends_with(&unit), "{} in {unit}", feature.column);
        let bare = Sample { motion_m: None, region: None, ..sample.clone() };
        assert_eq!(feature.read(&bare).is_some(), feature.name == "force");
        assert!(feature.limits.hold(feature.read(&sample).unwrap()));
    }
}

/// Tests the row-major order (force, motion) and that truncation keeps the first samples.
#[test]
fn observations_interleave_and_truncate() {
    let trial = trial(&[(1.0, Some(0.1)), (2.0, Some(0.2)), (3.0, Some(0.3))]);
    let all = FeatureSet::FORCE_AND_MOTION.observations(&trial, None).unwrap();
    assert_eq!(all, Observations::new(2, vec![1.0, 0.1, 2.0, 0.2, 3.0, 0.3]).unwrap());
    let two = FeatureSet::FORCE.observations(&trial, Some(2)).unwrap();
    assert_eq!(two, Observations::new(1, vec![1.0, 2.0]).unwrap());
}

/// Tests which trial, sample, feature and column an error names, and the remedy.
#[test]
fn bad_trials_are_named() {
    let missing = trial(&[(1.0, Some(0.0)), (2.0, None)]);
    let error = FeatureSet::FORCE_AND_MOTION.observations(&missing, None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "trial 7, sample 1 (from 0) has no motion_m, which the feature motion needs; give every row a number in the column motion_m, or choose \
         features without motion"
    );
    assert!(FeatureSet::FORCE.observations(&missing, None).is_ok());
    let error = "force,area".parse::<FeatureSet>().unwrap().observations(&missing, None).unwrap_err();
    assert_eq!(
        error.to_string(),
        "trial 7, sample 0 (from 0) has no region_taxels, which the feature area needs; fill the columns region_taxels, \
         region_largest_force_n, region_force_sum_n (underbrush trials writes them for a patch whose taxels form a grid), or \
         choose features without area"
    );
    let nan = trial(&[(1.0, Some(0.0)), (2.0, Some(f64::NAN))]);
    let error = FeatureSet::FORCE_AND_MOTION.observations(&nan, None).unwrap_err();
    assert!(error.to_string().contains("trial 7, sample 1 (from 0) has motion_m = NaN"), "{error}");
    assert!(FeatureSet::FORCE_AND_MOTION.observations(&nan, Some(1)).is_ok());
    assert_eq!(FeatureSet::FORCE.observations(&trial(&[]), None), Err(FeatureError::Empty(7)));
    assert!(Observations::new(2, vec![1.0, 2.0, 3.0]).is_err());
    assert!(Observations::new(1, vec![f64::INFINITY]).is_err());
}

#[test]
fn scaling_gives_zero_mean_and_unit_deviation() {
    // Tests z-scoring by hand-computed figures: values 1, 2, 3, 6 have mean 3 and variance (4+1+0+9)/4.
    let parts = [Observations::new(1, vec![1.0, 2.0]).unwrap(), Observations::new(1, vec![3.0, 6.0]).unwrap()];
    let scaling = Scaling::fit(&["force_n"], parts.iter()).unwrap();
    assert_eq!(scaling.mean, [3.0]);
    assert!((scaling.standard_deviation[0] - 3.5f64.sqrt()).abs() < 1e-15);
    let mut last = parts[1].clone();
    scaling.apply_all(&mut last);
    assert!((last.sample(1)[0] - 3.0 / 3.5f64.sqrt()).abs() < 1e-15);
    let constant = [Observations::new(1, vec![0.1; 7]).unwrap()];
    assert_eq!(Scaling::fit(&["force_n"], constant.iter()), Err(FeatureError::Constant("force_n".into())));
}

/// Tests how channels are named: as features and in files `column:NAME`, a known column by its feature, and nothing without a
/// name.
#[test]
fn any_column_can_be_a_feature() {
    let set: FeatureSet = "force,column:shear x [N]".parse().unwrap();
    assert_eq!(
        (set.to_string().as_str(), set.columns()),
        ("force+column:shear x [N]", vec!["force_n", "column:shear x [N]"])
    );
    assert_eq!(FeatureSet::from_names(&set.columns()), Ok(set));
    let channels = [("shear x [N]", -2.0)].into_iter().collect();
    let mut values = [0.0; 2];
    set.read(&Sample { force_n: 1.0, channels, ..Sample::default() }, &mut values).unwrap();
    assert_eq!(values, [1.0, -2.0]);
    assert_eq!("column:force_n".parse(), Ok(FeatureSet::FORCE));
    assert!("column:".parse::<FeatureSet>().is_err());
    // What a trial is, and the truth, are no channels.
    let error = "column:touched".parse::<FeatureSet>().unwrap_err().to_string();
    assert!(error.contains("except trial, category") && error.contains("touched"), "{error}");
    let many: Vec<String> = (0..25).map(|index| format!("column:c{index}")).collect();
    assert_eq!(FeatureSet::from_names(&many), Err(FeatureError::TooMany(24)));
}
