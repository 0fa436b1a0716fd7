use std::path::PathBuf;

use super::table_one_paper::TABLE_ONE_PAPER;
use underbrush_classifier::trial::TrialOptions;
use underbrush_recording::InputError;

use crate::{Experiment, Unit, training};

/// Tests that the file that ships is the paper's experiment: its Table I, its numbers of trials and reaches, and its
/// trial options; and that both lists of classifiers have the baseline.
#[test]
fn the_file_that_ships_is_the_papers() {
    let paper = Experiment::paper().unwrap();
    let published = paper.published().unwrap();
    for (by, features, states, percent) in TABLE_ONE_PAPER {
        let found = published.accuracy_percent(by, features, states);
        assert_eq!(found, Some(percent));
    }
    assert_eq!(published.accuracy.len(), TABLE_ONE_PAPER.len());
    assert_eq!(published.trials_per_reach(Unit::Component, "leaf"), Some(28.8));
    assert_eq!(published.trials_per_reach(Unit::Taxel, "trunk"), Some(23.28));
    assert_eq!(training::reaches(&paper), [10, 25]);
    assert_eq!(training::reaches(&paper.clone().made_small()), [4, 8]);
    assert_eq!(paper.trial_options(), TrialOptions::paper());
    assert_eq!(paper.labels(), ["leaf", "trunk"]);
    assert_eq!(paper.file.engineered.len(), 10);
    for entries in [&paper.file.classifiers, &paper.file.setting_classifiers] {
        assert!(entries.iter().any(|own| own.method.name == "peak-force"), "no baseline in {entries:?}");
    }
}

const SMALL: &str = r#"title = "Small"
states = [5]

[[training]]
scene = "one.toml"
label = "leaf"
reaches = 4

[[training]]
scene = "other.toml"
label = "trunk"
reaches = 4
"#;

fn written(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let scene = "summary = \"One trunk\"\n[[objects.trunk]]\ncount = 1\n";
    std::fs::write(folder.path().join("one.toml"), scene).unwrap();
    std::fs::write(folder.path().join("other.toml"), scene).unwrap();
    let path = folder.path().join("small.toml");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn error(text: &str) -> InputError {
    let (_folder, path) = written(text);
    Experiment::load(&path).unwrap_err()
}

/// Tests that a quick run has a third of the reaches of a training scene, rounded up, and at least two where there are as
/// many.
#[test]
fn a_quick_run_has_two_reaches_of_each_scene() {
    let (_folder, path) = written(SMALL);
    let experiment = Experiment::load(&path).unwrap();
    for (reaches, quick) in [(1, 1), (2, 2), (4, 2), (7, 3), (30, 10)] {
        let mut own = experiment.clone();
        own.file.training[0].reaches = reaches;
        assert_eq!(own.made_small().file.training[0].reaches, quick, "{reaches}");
    }
}

/// Tests what quick runs leave out of the paper's experiment: they have the hash of the whole one, and of its parts one recipe,
/// one reach of each test scene, and nothing of unknown objects, controllers, settings and ablation.
#[test]
fn a_quick_run_leaves_out_what_needs_more_reaches() {
    let whole = Experiment::paper().unwrap();
    let small = whole.clone().made_small();
    assert_eq!((&small.hash, &small.name), (&whole.hash, &whole.name));
    let (whole, small) = (&whole.file, &small.file);
    assert_eq!(small.recipes, whole.recipes[..1]);
    assert!(small.engineered.iter().all(|own| own.max_draws == 1) && small.engineered.len() == whole.engineered.len());
    for own in [&small.general, &small.outlier] {
        let own = own.as_ref().unwrap();
        assert_eq!((own.reaches, own.max_draws), (1, 2));
    }
    let verdicts = small.verdicts.as_ref().unwrap();
    assert!(verdicts.reaches == 4 && verdicts.auxiliary.is_empty());
    assert!(whole.second_outlier.is_some() && small.second_outlier.is_none());
    assert!(whole.controllers.is_some() && small.controllers.is_none());
    assert!(!whole.settings.is_empty() && small.settings.is_empty());
    assert!(!whole.ablation.is_empty() && small.ablation.is_empty());
}

/// Tests that each fault of an experiment file is named with its line, its field, what was found and what is allowed.
#[test]
fn faults_name_line_and_field() {
    let (_folder, path) = written(SMALL);
    Experiment::load(&path).unwrap();
    for (was, is, line, field, allowed) in [
        ("states = [5]", "sates = [5]", 2, "sates", "underbrush schema experiment"),
        ("states = [5]", "states = [0]", 2, "states", "from 1"),
        ("label = \"trunk\"", "label = \"leaf\"", 6, "training.label", "two different labels"),
        ("label = \"trunk\"", "label = \"outlier\"", 11, "training.label", "verdicts"),
        ("label = \"trunk\"", "label = \"block\"", 11, "training.label", "nothing is trained"),
        ("label = \"trunk\"", "label = \"a\\nb\"", 0, "training.label", "control characters"),
        ("label = \"trunk\"\nreaches = 4", "label = \"trunk\"\nreaches = 1", 12, "training.reaches", "two folds"),
        ("states = [5]", "states = [30]", 0, "trials.min_samples", "largest of `states`"),
        (
            "label = \"trunk\"\nreaches = 4\n",
            "label = \"trunk\"\nreaches = 4\n[[settings]]\nname = \"soft\"\nrobot = { stiffness_scale = 0.5 }\n",
            14,
            "settings.name",
            "[[setting_classifiers]]",
        ),
    ] {
        let text = SMALL.replace(was, is);
        assert_ne!(text, SMALL);
        let error = error(&text);
        assert!(error.field.contains(field), "{error}");
        assert!(error.allowed.contains(allowed), "{error}");
        assert_eq!(error.line.unwrap_or(0), line, "{error}");
    }
    let bad_classifier = format!("{SMALL}\n[[classifiers]]\nname = \"x\"\nmethod = \"hmm\"\nfeatures = [\"region\"]\n");
    let error = error(&bad_classifier);
    assert!(error.field.contains("features") && error.to_string().contains("force"), "{error}");
    let error = self::error(&bad_classifier.replace("region", "column:speed"));
    assert!(error.field.contains("features") && error.to_string().contains("column:speed is of tables"), "{error}");
}

/// Tests that numbers outside their ranges and a patch that no arm has are refused when the file is read, with the
/// line, the field, what was found and what is allowed.
#[test]
fn numbers_and_patch_are_checked_when_the_file_is_read() {
    for (section, line, field, found, allowed) in [
        (
            "[[settings]]\nname = \"soft\"\nrobot = {stiffness_scale=-1.0}",
            15,
            "settings.robot.stiffness_scale",
            "-1",
            "0.1 to 10",
        ),
        (
            "[[settings]]\nname = \"fast\"\n[settings.robot]\nhand_speed_scale = 1e9",
            16,
            "settings.robot.hand_speed_scale",
            "1e9",
            "0.1 to 10",
        ),
        ("[thresholds]\nuncertain_below_nats = -3", 14, "thresholds.uncertain_below_nats", "-3", "from 0"),
        ("[thresholds]\nuncertain_below_nats = nan", 14, "thresholds.uncertain_below_nats", "NaN", "finite"),
        ("[thresholds]\nfalse_positive_rate = 7.0", 14, "thresholds.false_positive_rate", "7", "over 0 and under 1"),
        ("[thresholds]\noutlier_prior = 0.5", 14, "thresholds.outlier_prior", "0.5", "under 0.5"),
        (
            "[[classifiers]]\nname = \"models\"\nmethod = \"hmm\"\nstates = 1001",
            16,
            "classifiers.states",
            "1001",
            "from 1 to 1000",
        ),
        (
            "[[setting_classifiers]]\nname = \"peak\"\nmethod = \"peak-force\"\nfeatures = [\"motion\"]",
            16,
            "setting_classifiers[0].features",
            "motion",
            "such as force",
        ),
        ("[[settings]]\nname = \"nominal\"\nrobot = {}", 14, "settings.name", "nominal", "scenes' own setting"),
        ("[general]\nscene = \"one.toml\"\nreaches = 0", 15, "general.reaches", "0", "1 to 1000000"),
        (
            "[second_outlier]\nscene = \"one.toml\"\nreaches = 5\nmax_draws = 4",
            16,
            "second_outlier.max_draws",
            "4",
            "5 to 1000000: as many draws",
        ),
        (
            "[[engineered]]\nscene = \"one.toml\"\nlabel = \"leaf\"\nmax_draws = 0",
            16,
            "engineered.max_draws",
            "0",
            "1 to 1000000",
        ),
        ("[[chosen_on]]\nfirst = 5\nlast = 1\nwhat = \"all\"", 14, "chosen_on.first", "5", "at most `last`, 1"),
        (
            "[[published.trials]]\nby = \"taxel\"\nlabel = \"leaf\"\ntrials = 9\nreaches = 0",
            17,
            "published.trials.reaches",
            "0",
            "a finite number over 0",
        ),
        ("[published]\nbest_accuracy_percent = nan", 14, "published.best_accuracy_percent", "NaN", "0 to 100"),
        ("[published]\nsamples_used = -3.0", 14, "published.samples_used", "-3", "a finite number over 0"),
        (
            "[published.sections.tabel_one]\nstatement = \"Taxels are told apart.\"",
            13,
            "published.sections.tabel_one",
            "tabel_one",
            "training_data, table_one,",
        ),
        ("[trials]\npatch = \"nosuch\"", 14, "trials.patch", "nosuch", "forearm, flipper"),
        // The reaches of this scene are trained on.
        ("[general]\nscene = \"one.toml\"\nreaches = 1", 14, "general.scene", "one.toml", "a `stream` of its own"),
        (
            "[[classifiers]]\nname = \"a\\nb\"\nmethod = \"naive-bayes\"",
            14,
            "classifiers.name",
            "\"a\\nb\"",
            "control characters",
        ),
        ("[[classifiers]]\nname = \"\"\nmethod = \"naive-bayes\"", 14, "classifiers.name", "\"\"", "not empty"),
        ("[controllers]\nscene = \"one.toml\"\nreaches = 0", 15, "controllers.reaches", "0", "1 to 1000000"),
        ("[verdicts]\nscene = \"one.toml\"\nreaches = 1000001", 15, "verdicts.reaches", "1000001", "1 to 1000000"),
        (
            "[verdicts]\nscene = \"one.toml\"\nreaches = 1\nquick_reaches = 0",
            16,
            "verdicts.quick_reaches",
            "0",
            "1 to 1000000",
        ),
    ] {
        let error = error(&format!("{SMALL}{section}\n"));
        assert_eq!((error.line, error.field.as_str()), (Some(line), field), "{error}");
        assert_eq!(error.found, found, "{error}");
        assert!(error.allowed.contains(allowed), "{error}");
    }
    let error = error(&SMALL.replace("[5]", "[5, 1001]"));
    assert_eq!((error.line, error.found.as_str()), (Some(2), "1001"), "{error}");
    for section in [
        "[thresholds]\nuncertain_below_nats = 0\nfalse_positive_rate = 0.99\noutlier_prior = 0",
        "[trials]\npatch = \"flipper\"",
    ] {
        let (_folder, path) = written(&format!("{SMALL}{section}\n"));
        Experiment::load(&path).unwrap();
    }
}

/// Tests that values and names by which results are found are refused if they are given twice.
#[test]
fn nothing_that_names_a_result_is_given_twice() {
    let entry = |table: &str| format!("[[{table}]]\nname = \"same\"\nmethod = \"naive-bayes\"\n");
    let setting = "[[settings]]\nname = \"same\"\nrobot = { stiffness_scale = 2.0 }\n";
    for (text, line, field, found) in [
        (SMALL.replace("[5]", "[3, 5, 3]"), 2, "states", "3 twice"),
        (SMALL.replace("other.toml", "one.toml"), 5, "training.scene", "one.toml twice"),
        (SMALL.replace("[5]", "[5]\ntruncations = [5, 5]"), 3, "truncations", "5 twice"),
        (SMALL.replace("[5]", "[5]\nablation = [\"no_creep\", \"no_creep\"]"), 3, "ablation", "no_creep twice"),
        (SMALL.replace("[5]", "[5]\nrecipes = [\"modern\", \"modern\"]"), 3, "recipes", "modern twice"),
        (format!("{SMALL}{}", entry("classifiers").repeat(2)), 14, "classifiers.name", "same twice"),
        (format!("{SMALL}{}", entry("setting_classifiers").repeat(2)), 14, "setting_classifiers.name", "same twice"),
        (format!("{SMALL}{}{}", setting.repeat(2), entry("setting_classifiers")), 14, "settings.name", "same twice"),
    ] {
        let error = error(&text);
        assert_eq!((error.line, error.field.as_str()), (Some(line), field), "{error}");
        assert_eq!(error.found, found, "{error}");
    }
    // The same name in two lists does not matter.
    let both = format!("{SMALL}{}{}{setting}", entry("classifiers"), entry("setting_classifiers"));
    let (_folder, path) = written(&both);
    Experiment::load(&path).unwrap();
}

/// Tests that a scene that does not exist is an error that names the scene file, and that a missing arm is one that names the
/// arm's file and the scene.
#[test]
fn faults_of_scenes_name_the_scene() {
    let missing = error(&SMALL.replace("other.toml", "nowhere.toml"));
    assert!(missing.file.ends_with("nowhere.toml"), "{missing}");
    let (folder, path) = written(SMALL);
    let scene = "summary = \"One trunk\"\narm = \"none.toml\"\n[[objects.trunk]]\ncount = 1\n";
    std::fs::write(folder.path().join("other.toml"), scene).unwrap();
    let missing = Experiment::load(&path).unwrap_err();
    assert!(missing.file.ends_with("none.toml"), "{missing}");
    let scene = folder.path().join("other.toml");
    assert!(missing.to_string().contains(&scene.display().to_string()), "{missing}");
}

/// Tests that an experiment takes the name of a scene that ships.
#[test]
fn scenes_that_ship_have_names() {
    let (_folder, path) = written(&SMALL.replace("one.toml", "leaf"));
    assert_eq!(Experiment::load(&path).unwrap().scenes["leaf"].name, "leaf");
}

/// Tests that labels without an object of that name are refused if verdicts are compared with objects, and allowed
/// otherwise.
#[test]
fn labels_are_categories_where_reaches_are_judged_by_objects() {
    let bamboo = SMALL.replace("\"trunk\"", "\"bamboo\"");
    let (_folder, path) = written(&bamboo);
    Experiment::load(&path).unwrap();
    let judged = format!("{bamboo}\n[general]\nscene = \"other.toml\"\nreaches = 1\n");
    let by_contact = bamboo.replace("[5]", "[5]\nablation = [\"labels_by_contact\"]");
    for text in [judged, by_contact] {
        let error = error(&text);
        assert!(error.found.contains("bamboo") && error.allowed.contains("the category of an object"), "{error}");
    }
}

/// Tests that an experiment whose arm has no skin is refused when it is read.
#[test]
fn an_arm_without_skin_is_refused() {
    let (folder, path) = written(SMALL);
    let cody = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../sim/arms/cody");
    for name in ["cody.toml", "cody.urdf", "cody.skin.toml"] {
        let text = std::fs::read_to_string(cody.join(name)).unwrap();
        let text = if name == "cody.skin.toml" { text.split("[[patch]]").next().unwrap() } else { &text };
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    std::fs::write(&path, format!("arm = \"cody.toml\"\n{SMALL}")).unwrap();
    let error = Experiment::load(&path).unwrap_err();
    assert_eq!((error.field.as_str(), error.found.as_str()), ("trials.patch", "no patch"), "{error}");
}

/// Tests that the hash of an experiment follows its file and the scenes that it names.
#[test]
fn the_hash_follows_file_and_scenes() {
    let (folder, path) = written(SMALL);
    let hash = || Experiment::load(&path).unwrap().hash;
    let first = hash();
    assert_eq!(hash(), first);
    let scene = "summary = \"Two trunks\"\n[[objects.trunk]]\ncount = 2\n";
    std::fs::write(folder.path().join("one.toml"), scene).unwrap();
    let second = hash();
    assert_ne!(second, first);
    std::fs::write(&path, SMALL.replace("[5]", "[6]")).unwrap();
    assert_ne!(hash(), second);
}
