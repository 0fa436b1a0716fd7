//! How contacts become trials: hysteresis, gaps, whole reaches, grids and labels by interval.

use underbrush_recording::Region;

use super::{file, imported, refused, samples, written};

/// Two taxels in one row, ten frames a second. The first trembles about 0.1 N and is interrupted once for 0.3 s.
const LOG: &str = "\
time,f0,f1
0.0,0.12,0
0.1,0.08,0.2
0.2,0.12,0.3
0.3,0,0
0.4,0,0
0.5,0.2,0
0.6,0,0
";

fn mapping(trial: &str) -> String {
    format!("[time]\nfrom = \"time\"\n[force]\nfrom = \"f{{taxel}}\"\ntaxels = 2\n{trial}")
}

/// For each trial its taxel and the times of its samples, s.
fn cut(trial: &str) -> Vec<(Option<u32>, Vec<f64>)> {
    let (_folder, path) = file("log.csv");
    written(&path, LOG);
    let found = imported(&path, &mapping(trial)).unwrap();
    found.trials.iter().map(|own| (own.taxel, samples(own).iter().map(|sample| sample.0).collect())).collect()
}

/// Tests that without hysteresis a trembling force makes several trials, that `release_n` keeps them together, and that
/// `gap_s` bridges interruptions that are no longer.
#[test]
fn hysteresis_and_gaps_keep_a_contact_together() {
    let with = |keys: &str| cut(&format!("[trial]\nthreshold_n = 0.1\n{keys}"));
    let second = (Some(1), vec![0.1, 0.2]);
    let last = (Some(0), vec![0.5]);
    assert_eq!(with(""), [(Some(0), vec![0.0]), second.clone(), (Some(0), vec![0.2]), last.clone()]);
    assert_eq!(with("release_n = 0.05"), [(Some(0), vec![0.0, 0.1, 0.2]), second.clone(), last.clone()]);
    let bridged = (Some(0), vec![0.0, 0.1, 0.2, 0.5]);
    assert_eq!(with("release_n = 0.05\ngap_s = 0.3"), [bridged, second.clone()]);
    assert_eq!(with("release_n = 0.05\ngap_s = 0.2"), [(Some(0), vec![0.0, 0.1, 0.2]), second, last]);
}

/// Tests that `cut = "reach"` makes one trial of all taxels, from the first contact to the last, with the largest force and the
/// region of all taxels in contact.
#[test]
fn a_whole_reach_can_be_one_trial() {
    let (_folder, path) = file("log.csv");
    written(&path, LOG);
    let found = imported(&path, &mapping("[trial]\nthreshold_n = 0.1\nrelease_n = 0.05\ncut = \"reach\"\n")).unwrap();
    assert_eq!(found.trials.len(), 1);
    let trial = &found.trials[0];
    assert_eq!(trial.taxel, None);
    assert_eq!(samples(trial), [(0.0, 0.12), (0.1, 0.2), (0.2, 0.3), (0.3, 0.0), (0.4, 0.0), (0.5, 0.2)]);
    let both = trial.samples[1].region.unwrap();
    assert_eq!((both.taxels, both.largest_force_n), (2, 0.2));
    assert!((both.force_sum_n - 0.28).abs() < 1e-12);
}

/// Tests that neighbours in the grid share a region, and taxels that are none do not.
#[test]
fn neighbours_in_contact_form_a_region() {
    let (_folder, path) = file("log.csv");
    written(&path, "time,f0,f1,f2\n0,1,2,0\n1,1,0,4\n");
    let grid = "[grid]\nrows = 1\ncolumns = 3\n";
    let text = mapping(grid).replace("taxels = 2", "taxels = 3");
    let region =
        |text: &str, trial: usize, sample: usize| imported(&path, text).unwrap().trials[trial].samples[sample].region;
    assert_eq!(region(&text, 0, 0), Some(Region { taxels: 2, largest_force_n: 2.0, force_sum_n: 3.0 }));
    assert_eq!(region(&text, 0, 1), Some(Region { taxels: 1, largest_force_n: 1.0, force_sum_n: 1.0 }));
    // Around a sleeve the last column is a neighbour of the first.
    let wrapped = text.replace("columns = 3", "columns = 3\nwraps = true");
    assert_eq!(region(&wrapped, 0, 1), Some(Region { taxels: 2, largest_force_n: 4.0, force_sum_n: 5.0 }));
    let error = refused(&path, &text.replace("columns = 3", "columns = 4"));
    assert_eq!((error.field.as_str(), error.allowed.as_str()), ("grid.rows", "a grid of 3 taxels"));
}

/// Tests that a label of the reach counts before one of all reaches, whichever comes first, and that none is called unused.
#[test]
fn a_label_of_the_reach_counts_before_a_general_one() {
    let (_folder, path) = file("log.csv");
    written(&path, "t,f\n0.5,1\n1.5,1\n");
    let label = |more: &str, category: &str| format!("[[label]]\nfrom_s = 0\n{more}\ncategory = \"{category}\"\n");
    let (all, own) = (label("to_s = 2", "leaf"), label("to_s = 1\nreach = 0", "trunk"));
    for labels in [format!("{all}{own}"), format!("{own}{all}")] {
        let found = imported(&path, &format!("[time]\nfrom = \"t\"\n[force]\nfrom = \"f\"\n{labels}")).unwrap();
        let categories: Vec<_> = found.trials.iter().map(|own| own.category.as_deref()).collect();
        assert_eq!(categories, [Some("trunk"), Some("leaf")]);
        assert!(!found.warnings.iter().any(|text| text.contains("no frame is within")), "{:?}", found.warnings);
    }
}

/// Tests that labels by interval end contacts where they change, and that what no label covers has the category of all.
#[test]
fn labels_hold_from_one_time_to_another() {
    let (_folder, path) = file("log.csv");
    written(&path, "time,f0,f1\n0,1,0\n1,1,0\n2,1,0\n3,1,0\n");
    let label = |from: f64, to: f64, category: &str| {
        format!("[[label]]\nfrom_s = {from:?}\nto_s = {to:?}\ncategory = \"{category}\"\n")
    };
    let text =
        mapping(&format!("[trial]\ncategory = \"table\"\n{}{}", label(0.0, 1.0, "leaf"), label(1.0, 3.0, "trunk")));
    let found = imported(&path, &text).unwrap();
    let categories: Vec<_> =
        found.trials.iter().map(|own| (own.category.as_deref().unwrap(), own.samples.len())).collect();
    assert_eq!(categories, [("leaf", 1), ("trunk", 2), ("table", 1)]);
    let unused = imported(&path, &mapping(&(label(0.0, 1.0, "leaf") + &label(100.0, 300.0, "trunk")))).unwrap();
    let warning = &unused.warnings[0];
    assert!(warning.contains("of trunk, 100 to 300 s") && warning.contains(":10)"), "{warning}");
    let error = refused(&path, &mapping(&label(0.0, 1.0, "uncertain")));
    assert_eq!((error.field.as_str(), error.line), ("label[0].category", Some(9)));
    let error = refused(&path, &mapping(&format!("[trial]\ncategory = \"{}\"", "long".repeat(500))));
    assert!(error.allowed.contains("at most 1000 bytes"), "{error}");
    let error = refused(&path, &mapping(&(label(0.0, 1.0, "leaf") + &label(2.0, 1.0, "leaf"))));
    assert_eq!((error.field.as_str(), error.found.as_str(), error.line), ("label[1].to_s", "2 to 1", Some(12)));
    let error = refused(&path, &mapping(&(label(0.0, 2.0, "leaf") + &label(1.0, 3.0, "trunk"))));
    assert_eq!((error.field.as_str(), error.found.as_str()), ("label[1].from_s", "1 to 3, which overlaps 0 to 2"));
}

/// Tests that trials of single samples are pointed out, and others are not.
#[test]
fn trials_of_single_samples_are_suspicious() {
    let (_folder, path) = file("log.csv");
    written(&path, LOG);
    let warnings = |trial: &str| imported(&path, &mapping(trial)).unwrap().warnings;
    assert!(warnings("[trial]\nthreshold_n = 0.1\n")[0].starts_with("3 of 4 trials have a single"));
    assert!(warnings("[trial]\nthreshold_n = 0.1\nrelease_n = 0.05\ngap_s = 0.5\n").is_empty());
}

/// Tests that channels follow the taxels, one for each or one for all, that a cell without a number is a gap, that a column
/// without any is warned of, and which names are refused.
#[test]
fn channels_follow_the_taxels() {
    let (_folder, path) = file("log.csv");
    written(&path, "time,f0,f1,s0,s1,heat\n0,1,2,0.1,-0.2,30\n1,1,1,,0.4,31\n");
    let channel = |name: &str, from: &str| format!("[[channel]]\nname = \"{name}\"\nfrom = \"{from}\"\n");
    let text = mapping(&(channel("shear", "s{taxel}") + &channel("temperature", "heat")));
    let found = imported(&path, &text).unwrap();
    let channels = |trial: usize, sample: usize| -> Vec<(String, f64)> {
        let channels = found.trials[trial].samples[sample].channels.iter();
        channels.map(|(name, number)| (name.to_string(), number)).collect()
    };
    let temperature = |kelvin: f64| ("temperature".to_owned(), kelvin);
    assert_eq!(channels(0, 0), [("shear".to_owned(), 0.1), temperature(30.0)]);
    assert_eq!(channels(0, 1), [temperature(31.0)]);
    assert_eq!(channels(1, 0), [("shear".to_owned(), -0.2), temperature(30.0)]);
    assert!(found.warnings.is_empty(), "{:?}", found.warnings);
    written(&path, "time,f0,f1,heat\n0,1,2,warm\n1,1,1,hot\n");
    let of_text = imported(&path, &mapping(&channel("temperature", "heat"))).unwrap();
    assert!(of_text.warnings[0].contains("channel temperature has no number"));
    for (bad, field) in [
        (channel("force_n", "heat"), "channel[0].name"),
        (channel("shear+heat", "heat"), "channel[0].name"),
        (channel(" heat", "heat"), "channel[0].name"),
        (channel("shear", "heat") + &channel("shear", "heat"), "channel[1].name"),
        (channel("shear", "x{taxel}"), "channel[0].from"),
    ] {
        assert_eq!(refused(&path, &mapping(&bad)).field, field);
    }
}

/// Tests that all that is suspicious is said at once: two labels without a frame, trials of single samples and a channel of text.
#[test]
fn everything_suspicious_is_said() {
    let (_folder, path) = file("log.csv");
    written(&path, "t,f,what\n0,1,soft\n1,0,soft\n2,1,soft\n3,0,soft\n");
    let label =
        |from_s: u32| format!("[[label]]\nfrom_s = {from_s}\nto_s = 60\nreach = {from_s}\ncategory = \"leaf\"\n");
    let channel = "[[channel]]\nname = \"what\"\nfrom = \"what\"\n";
    let text = format!("[time]\nfrom = \"t\"\n[force]\nfrom = \"f\"\n{}{}{channel}", label(50), label(51));
    let warnings = imported(&path, &text).unwrap().warnings;
    let expected =
        ["leaf, 50 to 60 s", "leaf, 51 to 60 s", "2 of 2 trials have a single sample", "channel what has no number"];
    assert_eq!(warnings.len(), expected.len(), "{warnings:?}");
    for (warning, expected) in warnings.iter().zip(expected) {
        assert!(warning.contains(expected), "{warning}");
    }
}

/// Tests that where times begin does not decide which interruptions end a contact: at 100 Hz, four frames without contact are a gap
/// of 0.05 s, in seconds and in nanoseconds since 1970 too.
#[test]
fn gaps_do_not_depend_on_where_times_begin() {
    let (_folder, path) = file("log.csv");
    for (unit, begin, step) in [("s", 0.0, 0.01), ("s", 1_764_480_000.0, 0.01), ("ns", 1_764_480_000e9, 1e7)] {
        let row = |frame: u32| format!("{},{}\n", begin + f64::from(frame) * step, u32::from(frame % 10 < 6));
        written(&path, &format!("t,f\n{}", (0..500).map(row).collect::<String>()));
        let trials = |gap_s: f64| {
            let text =
                format!("[time]\nfrom = \"t\"\nunit = \"{unit}\"\n[force]\nfrom = \"f\"\n[trial]\ngap_s = {gap_s}\n");
            imported(&path, &text).unwrap().trials.len()
        };
        assert_eq!([0.05, 0.049].map(trials), [1, 50], "{unit}");
    }
}
