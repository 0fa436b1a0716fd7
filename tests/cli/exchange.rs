//! `underbrush export` and `underbrush import`.

use std::path::Path;
use std::process::Command;

use underbrush_recording::Trial;
use underbrush_recording::disk::read_trials;

use crate::support::fixture::fixture;
use crate::support::{call, tree, underbrush};

/// What an import can know about a trial: reach, taxel, and the time (µs) and force (N) of every sample. Times that are
/// computed from the rate may differ by rounding, so they are rounded to whole microseconds.
type Known = (Option<u64>, Option<u32>, Vec<(i64, f64)>);

/// What an import can know about these trials.
fn known(trials: &[Trial]) -> Vec<Known> {
    let samples = |trial: &Trial| {
        trial.samples.iter().map(|sample| ((sample.time_s * 1e6).round() as i64, sample.force_n)).collect()
    };
    let mut known: Vec<_> = trials.iter().map(|trial| (trial.reach, trial.taxel, samples(trial))).collect();
    known.sort_by(|a, b| a.partial_cmp(b).unwrap());
    known
}

fn mapping(folder: &Path, text: &str) -> std::path::PathBuf {
    let path = folder.join("map.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// Tests that `import --force` does not replace a folder of files that are only named like recordings.
#[test]
fn other_files_named_like_recordings_stay() {
    let folder = tempfile::tempdir().unwrap();
    let map = mapping(folder.path(), "[time]\nfrom = \"time_s\"\n[force]\nfrom = \"force_n\"\n");
    let [log, mine] = ["log.csv", "mine"].map(|name| folder.path().join(name));
    std::fs::write(&log, "time_s,force_n\n0,0\n0.01,1\n0.02,0\n").unwrap();
    std::fs::create_dir(&mine).unwrap();
    std::fs::copy(fixture().table_parquet(), mine.join("reach-of-mine.parquet")).unwrap();
    underbrush!["import", log, "--mapping", map, "--force", "--out", mine]
        .refused(&["holds reach-of-mine.parquet", "no recording of an import"]);
    assert!(mine.join("reach-of-mine.parquet").exists());
}

/// Tests that a CSV log with the forces of a data set, imported with its times and categories, has the trials that
/// `trials` cuts from the set; that a classifier can be trained on these trials and classifies them; and that `replay`
/// writes each reach with verdicts, but refuses a model that needs motion, which was not imported.
#[test]
fn trials_through_csv_are_those_of_the_data_set() {
    let folder = tempfile::tempdir().unwrap();
    let [file, table, model] = ["log.csv", "trials.csv", "model.json"].map(|name| folder.path().join(name));
    let set = underbrush_recording::disk::Dataset::open(fixture().dataset()).unwrap();
    let patch = set.plan().layout.patches.iter().position(|patch| patch.name == "forearm").unwrap();
    let taxels = set.plan().layout.patches[patch].taxels.len();
    let columns: Vec<String> = (0..taxels).map(|taxel| format!("f{taxel}")).collect();
    let mut log = format!("reach,scene,{}\n", columns.join(","));
    for index in 0..set.episodes().len() {
        let reach = set.read_reach(index).unwrap();
        for frame in &reach.frames {
            let mut forces_n = vec![0.0; taxels];
            let readings = frame.taxels.iter().filter(|reading| usize::from(reading.patch) == patch);
            readings.for_each(|reading| forces_n[usize::from(reading.taxel)] = reading.sensed_force_n);
            let forces_n: Vec<String> = forces_n.iter().map(f64::to_string).collect();
            log += &format!("{index},{},{}\n", reach.scene, forces_n.join(","));
        }
    }
    std::fs::write(&file, log).unwrap();
    let map = mapping(
        folder.path(),
        &format!(
            "[time]\nrate_hz = 100\n[force]\nfrom = \"f{{taxel}}\"\ntaxels = {taxels}\n[trial]\ncategory_from = \"scene\"\n\
             reach_from = \"reach\"\n"
        ),
    );
    let imported = underbrush!["import", file, "--mapping", map, "--out", table, "--json"].json();
    let (direct, imported_trials) = (read_trials(fixture().table_csv()).unwrap(), read_trials(&table).unwrap());
    assert_eq!(imported["trials"], direct.len());
    let frames: usize = set.episodes().iter().map(|episode| episode.frames).sum();
    assert_eq!(imported["frames"], frames);
    assert_eq!(known(&direct), known(&imported_trials));
    let categories = imported["categories"].as_object().unwrap();
    assert_eq!(categories.keys().collect::<Vec<_>>(), ["leaf", "trunk"]);
    underbrush!["train", table, "--out", model, "--states", "3"].success();
    let classified = underbrush!["classify", model, table, "--json"].success();
    assert!(classified.contains("\"verdict\""), "{classified}");

    let page = folder.path().join("page.html");
    let written = underbrush!["replay", table, "--model", model, "--out", page, "--json"].json();
    let reaches: std::collections::BTreeSet<_> = imported_trials.iter().map(|trial| trial.reach).collect();
    assert_eq!(written["reaches"], reaches.len());
    let of_motion = folder.path().join("motion.json");
    let options = ["--features", "force,motion", "--states", "3"];
    underbrush!["train", fixture().table_csv(), "--out", of_motion, options[0], options[1], options[2], options[3]]
        .success();
    underbrush!["replay", table, "--model", of_motion, "--out", page, "--force"].refused(&[
        "trials.csv",
        "motion.json with the features force+motion",
        "--features force",
    ]);
}

/// Tests that a channel of a log goes through import, training and evaluation: two categories differ in shear alone, so force
/// does not tell them apart and shear does; and that a live stream, which has no channels, is refused.
#[test]
fn a_channel_of_a_log_is_a_feature() {
    let folder = tempfile::tempdir().unwrap();
    let [file, table, model] = ["log.csv", "trials.csv", "model.json"].map(|name| folder.path().join(name));
    let mut log = "run,what,force,shear\n".to_owned();
    for run in 0..20 {
        let (what, shear) = if run % 2 == 0 { ("leaf", -0.2) } else { ("trunk", 0.2) };
        for frame in 0..30 {
            let force = if frame == 0 { 0.0 } else { 1.0 + 0.1 * f64::from((run / 2 + frame) % 5) };
            log += &format!("{run},{what},{force},{}\n", shear + 0.02 * f64::from(frame % 4));
        }
    }
    std::fs::write(&file, log).unwrap();
    let text = "[time]\nrate_hz = 100\n[force]\nfrom = \"force\"\n[trial]\ncategory_from = \"what\"\nreach_from = \"run\"\n\
                [[channel]]\nname = \"shear_n\"\nfrom = \"shear\"\n";
    let map = mapping(folder.path(), text);
    underbrush!["import", file, "--mapping", map, "--out", table].success();
    let accuracy = |features: &str| {
        let arguments = ["--classifier", "trees", "--features", features];
        let [a, b, c, d] = arguments;
        underbrush!["train", table, "--out", model, a, b, c, d, "--force"].success();
        underbrush!["evaluate", table, "--model", model, "--json"].json()["accuracy"].as_f64().unwrap()
    };
    assert!(accuracy("force") <= 0.5);
    assert_eq!(accuracy("force,column:shear_n"), 1.0);
    underbrush!["classify", model, "-"].refused(&["column:shear_n", "a column of a table of trials"]);
    underbrush!["train", table, "--out", model, "--features", "column:slip", "--force"]
        .refused(&["has no slip, which the feature column:slip needs"]);
}

/// Tests that labelled reaches of a pad, with one of noise alone, become recordings from which a touch model learns both
/// categories and the noise, and that their folder stands for all of them, for classifiers of trials, too. Leaves press one taxel
/// weakly, trunks four of them hard.
#[test]
fn touch_learns_from_a_labelled_log() {
    let folder = tempfile::tempdir().unwrap();
    let [file, taxels, felt, model] =
        ["log.csv", "taxels.csv", "felt", "model.json"].map(|name| folder.path().join(name));
    let places =
        (0..16).map(|taxel| format!("{},{},0,0,0,1,1e-4\n", 0.01 * f64::from(taxel % 4), 0.01 * f64::from(taxel / 4)));
    let header = "x_m,y_m,z_m,normal_x,normal_y,normal_z,area_m2\n".to_owned();
    std::fs::write(&taxels, header + &places.collect::<String>()).unwrap();
    let columns: Vec<String> = (0..16).map(|taxel| format!("f{taxel}")).collect();
    let mut log = format!("run,what,{}\n", columns.join(","));
    for run in 0..24 {
        let (what, pressed, force) =
            [("leaf", vec![5], 0.2), ("trunk", vec![5, 6, 9, 10], 2.0), ("nothing", vec![0], 0.05)][run % 3].clone();
        for frame in 0..60 {
            let own = |taxel| {
                if frame % 30 > 4 && pressed.contains(&taxel) {
                    force + 0.001 * f64::from((frame + taxel) % 7)
                } else {
                    0.0
                }
            };
            let forces: Vec<String> = (0..16).map(|taxel| own(taxel).to_string()).collect();
            log += &format!("{run},{what},{}\n", forces.join(","));
        }
    }
    std::fs::write(&file, log).unwrap();
    let text = "[time]\nrate_hz = 100\n[force]\nfrom = \"f{taxel}\"\ntaxels = 16\n[grid]\nrows = 4\ncolumns = 4\n\
                [trial]\npatch = \"pad\"\ncategory_from = \"what\"\nreach_from = \"run\"\n";
    underbrush!["import", file, "--mapping", mapping(folder.path(), text), "--out", felt].refused(&[
        "skin.taxels",
        "the file of the taxels' places",
        "a table of trials is called .csv",
    ]);
    let map = mapping(folder.path(), &format!("{text}[skin]\ntaxels = \"taxels.csv\"\n"));
    underbrush!["import", file, "--mapping", map, "--out", felt].success();
    underbrush!["import", file, "--mapping", map, "--out", felt].refused(&["felt", "--force"]);
    underbrush!["import", file, "--mapping", map, "--out", taxels, "--force"].refused(&["an input of this command"]);
    let before = tree(&felt);
    let mut within = Command::new(env!("CARGO_BIN_EXE_underbrush"));
    within.arg("import").arg(&file).arg("--mapping").arg(&map).args(["--out", "../felt", "--force"]);
    assert!(within.current_dir(&felt).output().unwrap().status.success(), "from within the folder");
    assert!(tree(&felt) == before);
    underbrush!["import", file, "--mapping", map, "--out", folder.path(), "--force"]
        .refused(&["holds", "another name"]);
    let recordings = || (0..24).map(|run| felt.join(format!("reach-{run:06}.parquet")).into());
    let inspected = underbrush!["inspect", felt.join("reach-000000.parquet"), "--json"].json();
    assert!(["controller", "seed", "goals", "audit"].iter().all(|made_up| inspected[made_up].is_null()), "{inspected}");
    let with = |command: &str, options: &[&std::ffi::OsStr]| {
        let first = [command.into()].into_iter().chain(recordings());
        call(first.chain(options.iter().map(|own| own.into())).collect(), "")
    };
    with("train", &["--classifier".as_ref(), "touch".as_ref(), "--out".as_ref(), model.as_os_str()]).success();
    let found = with("evaluate", &["--model".as_ref(), model.as_os_str(), "--json".as_ref()]).json();
    for truth in found["truths"].as_array().unwrap().iter().filter(|truth| truth["taxel_frames"] != 0) {
        assert!(truth["right"].as_f64().unwrap() > 0.9, "{truth}");
    }
    assert_eq!(found["contacts_at_end"]["accuracy"], 1.0);
    // The folder stands for its recordings.
    let by_folder = folder.path().join("by-folder.json");
    underbrush!["train", felt, "--classifier", "touch", "--out", by_folder].success();
    let files = [&model, &by_folder].map(|file| std::fs::read(file).unwrap());
    assert_eq!(files[0], files[1]);
    assert_eq!(underbrush!["evaluate", felt, "--model", model, "--json"].json(), found);
    let page = folder.path().join("felt.html");
    assert_eq!(underbrush!["replay", felt, "--out", page, "--json"].json()["reaches"], 24);
    let answers = underbrush!["classify", model, felt].success();
    assert_eq!(answers.matches("\"reset\":true").count(), 23);
    // Classifiers of trials see in the folder what they see in a table of its trials.
    let [table, naive] = ["felt.csv", "naive.json"].map(|name| folder.path().join(name));
    underbrush!["trials", felt, "--out", table].success();
    let fit = ["--classifier", "naive-bayes", "--features", "force"];
    underbrush!["train", felt, fit[0], fit[1], fit[2], fit[3], "--out", naive].success();
    let provenance = &underbrush!["inspect", naive, "--json"].json()["provenance"];
    assert_eq!(provenance["data"].as_array().unwrap().len(), 24);
    let seen = |place: &Path| {
        let evaluated = underbrush!["evaluate", place, fit[0], fit[1], fit[2], fit[3], "--json"].json();
        (underbrush!["score", naive, place].success(), underbrush!["classify", naive, place].success(), evaluated)
    };
    assert_eq!(seen(&felt), seen(&table));
    // A reach that is there twice would be in two folds, and one that is damaged is not left out.
    let last = felt.join("reach-000024.parquet");
    std::fs::copy(felt.join("reach-000000.parquet"), &last).unwrap();
    underbrush!["score", naive, felt].refused(&["reach-000024.parquet", "the same data twice"]);
    std::fs::write(&last, "PAR1").unwrap();
    for answer in [
        underbrush!["score", naive, felt],
        underbrush!["evaluate", felt, "--model", model],
        underbrush!["replay", felt, "--out", page, "--force"],
        underbrush!["train", felt, "--classifier", "touch", "--out", by_folder, "--force"],
    ] {
        answer.refused(&["reach-000024.parquet", "a complete Parquet file"]);
    }
    // All of its recordings have another rate, which is said once.
    let slow = folder.path().join("slow");
    let slower = text.replace("rate_hz = 100", "rate_hz = 50");
    let map = mapping(folder.path(), &format!("{slower}[skin]\ntaxels = \"taxels.csv\"\n"));
    underbrush!["import", file, "--mapping", map, "--out", slow].success();
    let warned = underbrush!["replay", slow, "--model", model, "--out", page, "--force"];
    assert_eq!(warned.stderr.matches("frames at 50 Hz").count(), 1, "{}", warned.stderr);
}

/// Tests that an error in the mapping shows its line, and that a log that does not exist is named.
#[test]
fn what_cannot_be_imported_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.csv");
    std::fs::write(&log, "t,f\n0,1\n").unwrap();
    let table = folder.path().join("trials.csv");
    let map = mapping(folder.path(), "[time]\nfrom = \"t\"\n[force]\nfrom = \"force\"\n");
    underbrush!["import", log, "--mapping", map, "--out", table].refused(&[
        "map.toml:4",
        "force.from: found \"force\"",
        "from = \"force\"",
        "log.csv: t, f",
        "change `from`",
    ]);
    underbrush!["import", "nowhere.csv", "--mapping", map, "--out", table].refused(&["nowhere.csv", "no such file"]);
    assert!(!table.exists());
}

/// Tests that `export` names the Python call for each format, and `import` those for HDF5 and MCAP.
#[test]
fn exports_are_left_to_python() {
    let folder = tempfile::tempdir().unwrap();
    let [out, log, bag] = ["out", "log.h5", "log.mcap"].map(|name| folder.path().join(name));
    let export = |format: &str| underbrush!["export", fixture().dataset(), "--to", format, "--out", out];
    export("mcap").refused(&["MCAP", "python -m underbrush.mcap export"]);
    export("hdf5").refused(&["HDF5", "python -m underbrush.hdf5 export"]);
    export("rosbag").refused(&["rosbag", "mcap, ros2, hdf5"]);
    export("ros2").refused(&["ROS 2", "python -m underbrush.ros2 export"]);
    for file in [&log, &bag] {
        std::fs::write(file, "").unwrap();
    }
    let map = mapping(folder.path(), "[time]\nrate_hz = 100\n[force]\nfrom = \"data/force\"\n");
    underbrush!["import", log, "--mapping", map, "--out", folder.path().join("trials.csv")]
        .refused(&["log.h5", "python -m underbrush.hdf5 csv"]);
    underbrush!["import", bag, "--mapping", map, "--out", folder.path().join("trials.csv")]
        .refused(&["log.mcap", "python -m underbrush.mcap csv"]);
    assert!(!out.exists());
}
