//! Bad usage: invalid options and folders.

use super::assert_empty;
use crate::support::fixture::fixture;
use crate::support::{scenes, tree, underbrush};

/// Tests that `reach` and `generate` refuse an unknown controller with the names of all controllers, before anything
/// is written.
#[test]
fn unknown_controller() {
    let outputs = tempfile::tempdir().unwrap();
    let (scene, set) = (fixture().trunk_scene(), outputs.path().join("set"));
    let parts = ["clever", "--controller", "cody-2013, ijrr-foliage, blind"];
    underbrush!["reach", scene, "--controller", "clever"].refused(&parts);
    underbrush!["generate", scene, "--reaches", "1", "--out", set, "--controller", "clever"].refused(&parts);
    assert_empty(outputs.path());
}

/// Tests that shards are counted from 1, and that more shards than reaches are refused, also for a shard that would
/// have a reach: it could not be merged with one that has none.
#[test]
fn bad_shard() {
    let outputs = tempfile::tempdir().unwrap();
    let (scene, set) = (fixture().trunk_scene(), outputs.path().join("set"));
    for shard in ["0/2", "3/2", "1/0", "two", "/", "-1/2", "1/2/3"] {
        let shard = format!("--shard={shard}");
        underbrush!["generate", scene, "--reaches", "2", "--out", set, shard].refused(&["I/N with 1 ≤ I ≤ N", "2/8"]);
    }
    for shard in ["1/2", "2/2"] {
        let empty = underbrush!["generate", scene, "--reaches", "1", "--out", set, "--shard", shard];
        empty.refused(&["2 parts", "as many parts as reaches", "fewer parts, or for more reaches"]);
    }
    assert_empty(outputs.path());
}

/// Tests that a data set is written only to a new or an empty folder, and that existing files are not touched.
#[test]
fn folder_that_holds_something() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("thesis.tex"), "all I have").unwrap();
    let before = tree(folder.path());
    let scene = fixture().trunk_scene();
    for resume in [None, Some("--resume")] {
        let mut arguments: Vec<std::ffi::OsString> = vec!["generate".into(), scene.clone().into()];
        arguments.extend(["--reaches", "1", "--out"].map(Into::into));
        arguments.push(folder.path().into());
        arguments.extend(resume.map(Into::into));
        let parts = [&folder.path().display().to_string(), "is not empty and holds no data set", "a new folder"];
        crate::support::call(arguments, "").refused(&parts);
        assert!(before == tree(folder.path()));
    }
    let file = folder.path().join("thesis.tex");
    let set = fixture().dataset();
    for command in [&["reproduce", "--quick"][..], &["benchmark", "reaching", "--controller", "blind", "--quick"]] {
        let mut arguments: Vec<std::ffi::OsString> = command.iter().map(Into::into).collect();
        arguments.extend(["--out".into(), set.clone().into()]);
        crate::support::call(arguments, "").refused(&["is a data set; choose another folder"]);
    }
    let onto_file = underbrush!["generate", scene, "--reaches", "1", "--out", file];
    onto_file.refused(&[&file.display().to_string(), "found a file", "choose an empty or a new folder"]);
    assert!(before == tree(folder.path()));
}

/// Tests that the scenes of a data set must share one controller and have different names, and that errors come before
/// anything is run.
#[test]
fn scenes_that_do_not_go_together() {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let set = outputs.path().join("set");
    let blind = scenes::write(folder.path(), "blind.toml", &format!("controller = \"blind\"\n{}", scenes::FEW_TRUNKS));
    let feeling = scenes::write(folder.path(), "feeling.toml", scenes::FEW_TRUNKS);
    let parts = ["scenes blind and feeling", "different controllers, blind and cody-2013", "--controller"];
    underbrush!["generate", blind, feeling, "--reaches", "1", "--out", set].refused(&parts);
    std::fs::create_dir(folder.path().join("other")).unwrap();
    let namesake = scenes::write(&folder.path().join("other"), "feeling.toml", scenes::FEW_LEAVES);
    let alike = underbrush!["generate", feeling, namesake, "--reaches", "1", "--out", set];
    alike.refused(&["two scenes are called feeling", "rename one file"]);
    assert_empty(outputs.path());
    let chosen = underbrush!["generate", blind, feeling, "--reaches", "1", "--out", set, "--controller", "blind"];
    chosen.success();
}

/// Tests that a scene that is given twice is refused as such, also under another path.
#[test]
fn a_scene_given_twice() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    let (again, set) = (folder.path().join("sub").join("..").join("trunk.toml"), folder.path().join("set"));
    let twice = underbrush!["generate", scene, again, "--reaches", "1", "--out", set];
    twice.refused(&["the scene trunk is given twice", "give it once"]);
}

/// Tests that numbers that make no sense are refused with the name of the option.
#[test]
fn numbers_out_of_range() {
    let fixture = fixture();
    let outputs = tempfile::tempdir().unwrap();
    let (table, model, set) = (fixture.table_csv(), outputs.path().join("model.json"), outputs.path().join("set"));
    underbrush!["train", table, "--out", model, "--states", "0"].refused(&["--states", "from 1 to 1000"]);
    for tolerance in ["nan", "2"] {
        let train = underbrush!["train", table, "--out", model, "--tolerance", tolerance];
        train.refused(&["--tolerance", "a number: 0 to 1"]);
    }
    underbrush!["evaluate", table, "--folds", "1"].refused(&["error: 1 folds", "at least 2"]);
    underbrush!["evaluate", table, "--group", "position", "--decision", "uncertain", "--margin", "nan"]
        .refused(&["error: thresholds of NaN"]);
    underbrush!["evaluate", table, "--folds", "100000"].refused(&["fewer than the 100000 folds", "use fewer folds"]);
    // More threads than any machine has cores, each of which would hold a reach in memory.
    for jobs in ["0", "1025", "65535", "1e3", "-1"] {
        let jobs = format!("--jobs={jobs}");
        underbrush!["evaluate", table, jobs].refused(&["--jobs", "from 1 to 1024", "more threads than cores"]);
    }
    underbrush!["train", table, "--out", model, "--max-samples", "0"]
        .refused(&["--max-samples", "from 1 to 1000000000"]);
    underbrush!["evaluate", table, "--max-samples", "0"].refused(&["--max-samples", "from 1 to"]);
    let [leaf, trunk] = ["--prior=leaf=1e308", "--prior=trunk=1e308"];
    underbrush!["classify", fixture.model(), table, leaf, trunk]
        .refused(&["the prior of leaf is 1e308", "1e-9 to 1e9"]);
    let scene = fixture.trunk_scene();
    for reaches in ["0", "-1", "1.5"] {
        let generate = underbrush!["generate", scene, "--reaches", reaches, "--out", set];
        generate.refused(&["--reaches", "a whole number from 1 to 1000000"]);
    }
    for threshold in ["-1", "nan"] {
        let train = underbrush!["train", fixture.dataset(), "--out", model, "--threshold-n", threshold];
        train.refused(&["threshold_n is", "a finite force from 0 N"]);
    }
    assert_empty(outputs.path());
}

/// Tests that a text that is no number, or none that is allowed, is refused with what is allowed, also with --json.
#[test]
fn texts_that_are_no_numbers() {
    let (scene, allowed) = (fixture().trunk_scene(), "must be a whole number from 0 to 18446744073709551615");
    for number in ["one", "1e3", "-1", "18446744073709551616"] {
        let seed = format!("--seed={number}");
        let answer = underbrush!["reach", scene, seed, "--json"];
        answer.refused(&["--seed", number, allowed]);
        assert!(answer.stdout.contains(allowed), "{}", answer.stdout);
    }
    let threshold = underbrush!["train", fixture().table_csv(), "--out", "m.json", "--threshold-n", "0,03"];
    threshold.refused(&["--threshold-n", "0,03", "must be a force in N"]);
}

/// Tests that an option is refused, not ignored, if the option that it needs is excluded by another.
#[test]
fn options_whose_need_is_excluded() {
    let fixture = fixture();
    let outputs = tempfile::tempdir().unwrap();
    let (table, model, out) = (fixture.table_csv(), fixture.model(), outputs.path().join("out"));
    let train = underbrush!["train", table, "--out", out, "--start", model, "--outlier-prior", "0.2"];
    train.refused(&["--start", "--outlier-prior"]);
    let benchmark = underbrush!["benchmark", "verdicts", "--model", model, "--verdicts", model, "--out", out];
    benchmark.refused(&["--model", "--verdicts"]);
    assert_empty(outputs.path());
}

/// Tests that no command writes its output over its input, under whatever name, but that models may be replaced by what
/// they are trained to.
#[test]
fn outputs_that_are_inputs() {
    let fixture = fixture();
    let folder = tempfile::tempdir().unwrap();
    let named = |name: &str| folder.path().join(name);
    let [table, binary, map, model] = ["t.csv", "t.parquet", "map.toml", "m.json"].map(named);
    std::fs::copy(fixture.table_csv(), &table).unwrap();
    std::fs::copy(fixture.table_parquet(), &binary).unwrap();
    std::fs::copy(fixture.model(), &model).unwrap();
    std::fs::write(&map, "[time]\nfrom = \"time_s\"\n[force]\nfrom = \"force_n\"\n").unwrap();
    std::fs::create_dir(named("sub")).unwrap();
    let again = named("sub").join("..").join("t.csv");
    let before = tree(folder.path());
    for answer in [
        underbrush!["import", table, "--mapping", map, "--out", table],
        underbrush!["train", table, "--out", again],
        underbrush!["replay", binary, "--out", binary],
        underbrush!["replay", table, "--model", model, "--out", model],
        underbrush!["evaluate", table, "--roc", again],
        underbrush!["evaluate", table, "--model", model, "--roc", model],
        underbrush!["trials", binary, "--out", binary],
    ] {
        answer.refused(&["an input of this command", "choose another name"]);
    }
    assert!(before == tree(folder.path()));
    underbrush!["train", table, "--start", model, "--iterations", "1", "--out", model, "--force"].success();
}

/// Tests that an output that cannot be written is refused before the work, and so before what is wrong with the trials
/// is found, and that missing folders around an output are made.
#[test]
fn outputs_that_cannot_be_written() {
    let fixture = fixture();
    let outputs = tempfile::tempdir().unwrap();
    let named = |name: &str| outputs.path().join(name);
    let (set, scene, taken) = (fixture.dataset(), fixture.trunk_scene(), named("taken.parquet"));
    let recordings = tempfile::tempdir().unwrap();
    let recording = recordings.path().join("reach.parquet");
    underbrush!["reach", scene, "--out", recording].success();
    std::fs::create_dir(&taken).unwrap();
    for answer in [
        underbrush!["train", set, "--threshold-n", "1000", "--out", taken],
        underbrush!["trials", set, "--threshold-n", "1000", "--out", taken],
        underbrush!["evaluate", set, "--threshold-n", "1000", "--roc", taken],
        underbrush!["replay", set, "--out", taken],
        underbrush!["reach", scene, "--out", taken],
    ] {
        answer.refused(&["taken.parquet: is a folder", "give the name of a file"]);
    }
    let text = underbrush!["trials", set, "--threshold-n", "1000", "--out", named("t.txt")];
    text.refused(&["extension \"txt\"", "ends in .csv or .parquet"]);
    std::fs::remove_dir(&taken).unwrap();
    assert_empty(outputs.path());
    let recording = named("new").join("folder").join("reach.parquet");
    underbrush!["reach", scene, "--out", recording].success();
    assert!(recording.exists());
}

/// Tests that a threshold above every force is reported as leaving no trials, not as missing categories, and that
/// advice about a table of trials has only what applies to tables.
#[test]
fn nothing_to_fit() {
    let fixture = fixture();
    let outputs = tempfile::tempdir().unwrap();
    let (set, out) = (fixture.dataset(), outputs.path().join("out.csv"));
    let parts = ["dataset: no contact on the first patch above 1000 N", "lower --threshold-n"];
    underbrush!["train", set, "--out", out, "--threshold-n", "1000"].refused(&parts);
    underbrush!["evaluate", set, "--threshold-n", "1000"].refused(&parts);
    underbrush!["trials", set, "--out", out, "--threshold-n", "1000"].refused(&parts);
    for table in [fixture.table_csv(), fixture.table_parquet()] {
        let short = underbrush!["evaluate", table, "--min-samples", "99999"];
        short.refused(&["no trial in this table has 99999 samples or more", "lower --min-samples"]);
        assert!(!short.stderr.contains("--threshold-n"), "{}", short.stderr);
    }
    assert_empty(outputs.path());
}

/// Tests that an unknown patch, table format or file type is refused with the known ones, and that a prior of an
/// unknown category or two of one category are refused.
#[test]
fn unknown_names() {
    let fixture = fixture();
    let outputs = tempfile::tempdir().unwrap();
    let [text, table] = ["trials.txt", "trials.csv"].map(|name| outputs.path().join(name));
    let patch = underbrush!["trials", fixture.dataset(), "--out", table, "--patch", "elbow"];
    let set = fixture.dataset().display().to_string();
    patch.refused(&[&set, "no patch named \"elbow\"", "forearm", "flipper"]);
    let online = underbrush!["classify", fixture.model(), fixture.dataset(), "--online", "--patch", "elbow"];
    online.refused(&[&set, "no patch named \"elbow\"", "forearm", "flipper"]);
    underbrush!["trials", fixture.dataset(), "--out", text].refused(&["extension \"txt\"", "ends in .csv or .parquet"]);
    assert_empty(outputs.path());
    std::fs::write(&text, "a text").unwrap();
    underbrush!["inspect", text].refused(&["trials.txt", "neither a folder nor a .toml"]);
    underbrush!["train", text, "--out", table].refused(&["trials.txt", "extension \"txt\""]);
    let prior = underbrush!["classify", fixture.model(), fixture.table_csv(), "--prior", "moss=0.5"];
    prior.refused(&["moss"]);
}
