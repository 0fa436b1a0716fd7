use underbrush_recording::Region;

use super::*;

/// Time, s; force, N; motion, m; the region's number of taxels, largest force, N, and sum of forces, N.
type Row = (f64, f64, f64, u32, f64, f64);

fn trial(rows: &[Row]) -> Trial {
    let samples = rows.iter().map(|&(time_s, force_n, motion_m, taxels, largest_force_n, force_sum_n)| Sample {
        time_s,
        force_n,
        motion_m: Some(motion_m),
        region: Some(Region { taxels, largest_force_n, force_sum_n }),
        ..Sample::default()
    });
    Trial { trial: 3, category: None, reach: None, patch: None, taxel: None, samples: samples.collect() }
}

/// Undoes `compress`.
fn expand(value: f64, knee: f64) -> f64 {
    value.signum() * knee * value.abs().exp_m1()
}

#[test]
fn features_are_those_of_the_whole_computed_at_once() {
    // Tests the recursions against sums over the whole trial, for samples at uneven times.
    let rows = [
        (2.00, 0.2, 0.0, 1, 0.2, 0.2),
        (2.01, 0.5, 0.001, 3, 1.0, 1.7),
        (2.03, 0.4, 0.004, 2, 2.0, 2.4),
        (2.04, 0.9, 0.003, 5, 1.5, 4.0),
    ];
    let found = Selection::of(TAXEL_AND_REGION).after(&trial(&rows), &[4]).unwrap().remove(0);
    let of = |name: &str| found[StreamFeatures::NAMES.iter().position(|known| *known == name).unwrap()];
    let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(f).sum::<f64>() / 4.0;
    let time = mean(&|row| row.0);
    let motion = mean(&|row| row.2);
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
    let slope =
        |value: &dyn Fn(&Row) -> f64| mean(&|row| (row.0 - time) * value(row)) / mean(&|row| (row.0 - time).powi(2));
    near(of("samples"), 4f64.ln());
    near(expand(of("mean force"), 0.1), 0.5);
    near(expand(of("largest force"), 0.1), 0.9);
    near(expand(of("first force"), 0.1), 0.2);
    near(expand(of("deviation of force"), 0.1), mean(&|row| (row.1 - 0.5).powi(2)).sqrt());
    near(expand(of("variation of force per second"), 10.0), 0.9 / 0.04);
    near(expand(of("largest step of force"), 0.1), 0.5);
    near(expand(of("slope of force over time"), 0.1), slope(&|row| row.1));
    near(expand(of("slope of region's largest force over time"), 0.1), slope(&|row| row.4));
    let with_motion = mean(&|row| (row.2 - motion) * row.1) / (mean(&|row| (row.2 - motion).powi(2)) + 1e-8);
    near(expand(of("slope of force over motion"), 10.0), with_motion);
    near(expand(of("path per second"), 0.01), 0.005 / 0.04);
    near(expand(of("largest motion"), 1e-4), 0.004);
    near(of("mean region's taxels").exp_m1(), 11.0 / 4.0);
    near(of("largest region's taxels").exp_m1(), 5.0);
    near(expand(of("mean region's force"), 0.1), 8.3 / 4.0);
    near(of("mean share of region's largest force"), (1.0 + 0.5 + 0.2 + 0.6) / 4.0);
}

#[test]
fn nothing_looks_ahead() {
    // Tests that the features after k samples are those of a trial of k samples, and that larger counts mean the whole
    // trial.
    let rows = [(0.00, 0.2, 0.0, 1, 0.2, 0.2), (0.01, 0.5, 0.001, 3, 1.0, 1.7), (0.02, 0.1, 0.002, 4, 3.0, 9.0)];
    for inputs in [FeatureSet::FORCE, FeatureSet::FORCE_AND_MOTION, TAXEL_AND_REGION] {
        let set = Selection::of(inputs);
        let found = set.after(&trial(&rows), &[1, 2, 3, 50]).unwrap();
        for count in 1..=3 {
            assert_eq!(found[count - 1], set.after(&trial(&rows[..count]), &[count]).unwrap()[0]);
            assert_eq!(found[count - 1].len(), set.dimension());
        }
        assert_eq!(found[3], found[2]);
    }
}

/// Tests which stream features each list of inputs gives: force and motion give all features of the taxel, and all
/// inputs give all features.
#[test]
fn inputs_select_stream_features() {
    let names = |inputs| Selection::of(inputs).chosen().map(|index| StreamFeatures::NAMES[index]).collect::<Vec<_>>();
    let all = StreamFeatures::NAMES;
    assert_eq!(names(FeatureSet::FORCE_AND_MOTION), all[..13]);
    assert_eq!(names(TAXEL_AND_REGION), all);
    assert_eq!(names(FeatureSet::FORCE), all[..9]);
    assert_eq!(
        names("area".parse().unwrap()),
        ["samples", "region's taxels", "mean region's taxels", "largest region's taxels"]
    );
}

/// Tests that unselected inputs have no influence: with force alone, motion and region may have any values or be
/// missing.
#[test]
fn inputs_that_are_not_selected_do_not_matter() {
    let rows = [(0.0, 0.2, 0.0, 1, 0.2, 0.2), (0.01, 0.4, 0.01, 3, 2.0, 3.0)];
    let mut bare = trial(&rows);
    let selection = Selection::of(FeatureSet::FORCE);
    let expected = selection.after(&bare, &[1, 2]).unwrap();
    for sample in &mut bare.samples {
        (sample.motion_m, sample.region) = (None, None);
    }
    assert_eq!(selection.after(&bare, &[1, 2]).unwrap(), expected);
}

/// Tests the errors for samples without motion or region, with NaN, and for no samples at all.
#[test]
fn what_is_missing_is_named() {
    let mut bare = trial(&[(0.0, 0.2, 0.0, 1, 0.2, 0.2), (0.01, 0.2, 0.0, 1, 0.2, 0.2)]);
    bare.samples[1].region = None;
    assert!(Selection::of(FeatureSet::FORCE_AND_MOTION).after(&bare, &[2]).is_ok());
    let after = |trial: &Trial| Selection::of(TAXEL_AND_REGION).after(trial, &[2]).unwrap_err();
    let bad = |sample, fault| FeatureError::BadSample { trial: 3, sample, fault };
    assert_eq!(after(&bare), bad(1, SampleFault::Missing(&AREA)));
    bare.samples[1].motion_m = None;
    assert_eq!(after(&bare), bad(1, SampleFault::Missing(&MOTION)));
    let fault = |column| SampleFault::NotFinite { column, value: f64::INFINITY };
    bare.samples[0].time_s = f64::INFINITY;
    assert_eq!(after(&bare), bad(0, fault("time_s")));
    bare.samples[0].force_n = f64::INFINITY;
    assert_eq!(after(&bare), bad(0, fault("force_n")));
    assert_eq!(after(&trial(&[])), FeatureError::Empty(3));
}
