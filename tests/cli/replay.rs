//! `underbrush replay`: what can be tested without a browser.

use underbrush_replay::Source;
use underbrush_report::replayed::known;

use super::touch;
use crate::support::fixture::fixture;
use crate::support::{call, scenes, underbrush};

/// Tests that the chosen reaches of a data set are written with verdicts to one file, each of them once, and that the size of
/// this file is reported.
#[test]
fn reaches_are_written_as_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let written = underbrush![
        "replay",
        fixture().dataset(),
        "--model",
        fixture().model(),
        "--reaches",
        "0,4,0",
        "--out",
        page,
        "--json"
    ]
    .json();
    let text = std::fs::read_to_string(&page).unwrap();
    assert_eq!(written["reaches"], 2);
    assert_eq!(written["bytes"], text.len());
    for (id, count) in [("underbrush-reach-0\"", 1), ("underbrush-reach-1\"", 1), ("underbrush-reach-2\"", 0)] {
        assert_eq!(text.matches(&format!("id=\"{id}>")).count(), count, "{id}");
    }
}

/// Tests that a reach of a data set has the force limit of its scene, which may scale that of the controller, a recording the one that
/// is stated, and a controller to which verdicts are told that of the controller alone.
#[test]
fn the_force_limit_is_that_of_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let scaled = format!("{}\n[robot]\nforce_limit_scale = 2.0\n", scenes::FEW_TRUNKS);
    let scene = scenes::write(folder.path(), "scaled.toml", &scaled);
    let out = folder.path().join("set");
    underbrush!["generate", scene, "--reaches", "1", "--out", out].success();
    let source = Source::open(&[out], known(None), None).unwrap();
    assert_eq!(source.stated_limit_n(0), Some(6.0));
    assert!(String::from_utf8_lossy(&source.pack(0).unwrap()).contains("\"force_limit_n\":6.0"));
    // A recording does not say it, but who shows it may know it.
    let reach = folder.path().join("reach.parquet");
    underbrush!["reach", scene, "--out", reach].success();
    let source = Source::open(&[reach], known(Some(6.0)), None).unwrap();
    assert!(String::from_utf8_lossy(&source.pack(0).unwrap()).contains("\"force_limit_n\":6.0"));
    let of_controllers = known(None).force_limit_n;
    assert_eq!((of_controllers("cody-2013"), of_controllers("cody-2013+truth")), (Some(3.0), Some(3.0)));
    assert_eq!(of_controllers("own"), None);
}

/// Tests that options that do not fit together, missing files, files of another kind, empty folders and numbers outside the
/// list are refused with the reason, and that nothing is written.
#[test]
fn bad_usage_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let set = fixture().dataset();
    underbrush!["replay", "no-such-set", "--out", page].refused(&["no-such-set", "check the path"]);
    underbrush!["replay", fixture().trunk_scene(), "--out", page].refused(&["not Parquet", "check the path"]);
    underbrush!["replay", set, "--reaches", "17", "--out", page].refused(&["no reach 17", "below 6"]);
    underbrush!["replay", set, "--margin", "3", "--out", page].refused(&["--margin", "--model"]);
    underbrush!["replay", set, "--model", fixture().model(), "--patch", "hand", "--out", page]
        .refused(&["hand", "forearm"]);
    underbrush!["replay", set, "--reaches", "0"].refused(&["--out"]);
    underbrush!["replay", set, "--reaches", "0", "--no-open"].refused(&["--reaches", "--no-open"]);
    underbrush!["replay", set, "--reaches", "0", "--port", "0"].refused(&["--reaches", "--port"]);
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    underbrush!["replay", empty, "--out", page]
        .refused(&["no meta/info.json and no recordings", "a folder with recordings"]);
    assert!(!page.exists());
}

/// Tests that a touch model's verdicts are written into the page, that its own options change them, and that options
/// which one of the two kinds of model would ignore are refused.
#[test]
fn touch_models_judge_too() {
    let folder = tempfile::tempdir().unwrap();
    let set = fixture().dataset();
    let page = |name: &str| folder.path().join(name);
    let (first, second, refused) = (page("first.html"), page("second.html"), page("refused.html"));
    let touch = touch::model();
    underbrush!["replay", set, "--reaches", "0", "--model", touch, "--out", first].success();
    underbrush!["replay", set, "--reaches", "0", "--model", touch, "--unknown-share", "1", "--out", second].success();
    let [first, second] = [first, second].map(|page| std::fs::read_to_string(page).unwrap());
    assert!(first != second, "the option changed no verdict");
    for (model, option, value, said) in [
        (touch.clone(), "--margin", "3", "--margin"),
        (touch.clone(), "--patch", "flipper", "patch flipper: this touch model judges all patches"),
        (fixture().model(), "--nothing-above", "0.5", "--nothing-above"),
    ] {
        underbrush!["replay", set, "--model", model, option, value, "--out", refused].refused(&[said]);
    }
    underbrush!["replay", set, "--unknown-share", "0.5", "--out", refused].refused(&["--unknown-share", "--model"]);
    assert!(!refused.exists());
}

/// Tests that a picture of one moment and a film have the sizes that were asked for, that another moment is another picture, that
/// the report says how many pictures there are, and that cameras see no arrows.
#[test]
fn reaches_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let set = fixture().dataset();
    let file = |name: &str| folder.path().join(name);
    let (still, later, film) = (file("still.png"), file("later.png"), file("film.gif"));
    let written = underbrush!["replay", set, "--reaches", "0", "--still", still, "--size", "160x90", "--json"].json();
    let bytes = std::fs::read(&still).unwrap();
    assert_eq!((&written["pictures"], &written["bytes"]), (&1.into(), &bytes.len().into()));
    // The first chunk of a PNG has width and height after its name.
    assert_eq!(bytes[1..4], *b"PNG");
    assert_eq!((bytes[16..20].to_vec(), bytes[20..24].to_vec()), (vec![0, 0, 0, 160], vec![0, 0, 0, 90]));
    underbrush!["replay", set, "--reaches", "0", "--still", later, "--size", "160x90", "--time", "0.5"].success();
    assert!(std::fs::read(&later).unwrap() != bytes);
    let eye = ["--eye", "-0.5,1.5,0.6", "--target", "0.4,0,-0.2", "--force"];
    underbrush![
        "replay",
        set,
        "--reaches",
        "0",
        "--still",
        later,
        "--size",
        "160x90",
        eye[0],
        eye[1],
        eye[2],
        eye[3],
        eye[4]
    ]
    .success();
    assert!(std::fs::read(&later).unwrap() != bytes);
    let down = ["--eye", "0.4,0,3", "--target", "0.4,0,0"];
    underbrush!["replay", set, "--reaches", "0", "--still", later, down[0], down[1], down[2], down[3], "--force"]
        .success();
    // The camera of a scene file has a size of its own.
    let text = std::fs::read_to_string(fixture().trunk_scene()).unwrap();
    let camera =
        "\n[[cameras]]\nname = \"hand\"\nlink = \"forearm\"\neye_m = [0, 0.14, 0.22]\ntarget_m = [0, 0.02, -0.2]\n";
    let front =
        "[[cameras]]\nname = \"front\"\neye_m = [0.9, -1.5, 0.7]\ntarget_m = [0.55, 0, -0.15]\nvertical_fov_deg = 32\n";
    let filmed = scenes::write(folder.path(), "filmed.toml", &(text + camera + "size_px = [80, 64]\n" + front));
    let own = file("own");
    underbrush!["generate", filmed, "--reaches", "1", "--out", own].success();
    underbrush!["replay", own, "--still", later, "--camera", "hand", "--force"].success();
    assert_eq!(std::fs::read(&later).unwrap()[16..24], [0, 0, 0, 80, 0, 0, 0, 64]);
    underbrush!["replay", own, "--still", later, "--camera", "eye", "--force"].refused(&["filmed (hand, front)"]);
    // From the same place, a camera sees no arrows of forces, and a still has them.
    let from = |place: &str, time: &str| {
        let options = format!("{place} --size 320x200 --force{time}");
        let arguments = ["replay", own.to_str().unwrap(), "--still", later.to_str().unwrap()];
        call(arguments.into_iter().chain(options.split(' ')).map(Into::into).collect(), "").success();
        std::fs::read(&later).unwrap()
    };
    let (camera, still) = ("--camera front", "--eye 0.9,-1.5,0.7 --target 0.55,0,-0.15");
    assert!(from(camera, " --time 0") == from(still, " --time 0"));
    assert!(from(camera, "") != from(still, ""));
    let recording = file("reach.parquet");
    let reach = underbrush!["reach", fixture().trunk_scene(), "--out", recording, "--json"].json();
    let film_of = |options: &str| {
        let arguments = ["replay", recording.to_str().unwrap(), "--video", film.to_str().unwrap(), "--force", "--json"];
        call(arguments.into_iter().chain(options.split(' ')).map(Into::into).collect(), "").json()
    };
    // Without --fps there are 25 pictures per second.
    for options in ["--size 64x65 --fps 10 --speed 8", "--size 64x65 --speed 20"] {
        let written = film_of(options);
        assert_eq!(std::fs::read(&film).unwrap()[..10], *b"GIF89a\x40\0\x41\0");
        let (seconds, pictures) = (reach["simulated_s"].as_f64().unwrap(), written["pictures"].as_f64().unwrap());
        // One for every 0.8 s, and one at the start.
        assert!((pictures - seconds / 0.8).abs() <= 1.0, "{options}: {pictures} pictures of {seconds} s");
    }
}

/// Tests that pictures of more than one reach, of nothing, with another ending, and with numbers outside their limits are
/// refused with what is allowed, and that nothing is written.
#[test]
fn bad_pictures_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (png, gif) = (folder.path().join("a.png"), folder.path().join("a.gif"));
    let set = fixture().dataset();
    underbrush!["replay", set, "--still", png].refused(&["one of 6", "--reaches N"]);
    underbrush!["replay", set, "--reaches", "0,1", "--video", gif].refused(&["one reach", "--reaches N"]);
    underbrush!["replay", set, "--reaches", "9", "--still", png].refused(&["no reach 9"]);
    underbrush!["replay", fixture().table_csv(), "--reaches", "0", "--still", png].refused(&[
        "nothing to draw",
        "on the page",
        "--out",
    ]);
    underbrush!["replay", set, "--reaches", "0", "--still", gif].refused(&["a.gif", ".png"]);
    let mp4 = folder.path().join("a.mp4");
    underbrush!["replay", set, "--reaches", "0", "--video", mp4].refused(&["a.mp4", ".gif", "underbrush.video"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--time", "1e3"].refused(&["--time 1000", "0 to"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--size", "63x90"].refused(&["64 to 1280"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--size", "big"].refused(&["640x360"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--camera", "hand"]
        .refused(&["--camera hand", "has no cameras; use --eye"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--eye", "1,2"].refused(&["1,2", "0.5,-1,0.3"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--eye", "0,0,1", "--target", "0,0,1"].refused(&[
        "eye [0, 0, 1]",
        "1 mm apart",
        "move the camera",
    ]);
    underbrush!["replay", set, "--reaches", "0", "--video", gif, "--fps", "51"].refused(&["51", "--fps", "1 to 50"]);
    underbrush!["replay", set, "--reaches", "0", "--video", gif, "--speed", "nan"].refused(&["--speed", "0.1 to 100"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--fps", "5"].refused(&["--fps", "--still"]);
    underbrush!["replay", set, "--fps", "5"].refused(&["--video"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--patch", "hand"].refused(&["--patch", "--still"]);
    underbrush!["replay", set, "--out", png, "--time", "1"].refused(&["--out", "--time"]);
    underbrush!["replay", set, "--reaches", "0", "--still", png, "--video", gif].refused(&["--still", "--video"]);
    underbrush!["replay", set, "--size", "64x64"].refused(&["<--still <FILE.png>|--video <FILE.gif>>"]);
    underbrush!["inspect", set, "--still", png].refused(&["--still is for arms", "`reach --picture` scenes"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Tests that trials which the page shows in parts are counted in a warning, and that the page is written.
#[test]
fn trials_with_weak_samples_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let [table, page] = ["log.csv", "page.html"].map(|name| folder.path().join(name));
    let forces_n = [(0, [0.4, 0.4, 0.4]), (1, [0.4, 0.02, 0.4])];
    let rows = forces_n.iter().flat_map(|(trial, forces_n)| {
        let time_s = move |sample: usize| f64::from(*trial) + 0.01 * sample as f64;
        forces_n.iter().enumerate().map(move |(sample, own_n)| format!("{trial},leaf,0,{},{own_n}\n", time_s(sample)))
    });
    std::fs::write(&table, format!("trial,category,taxel,time_s,force_n\n{}", rows.collect::<String>())).unwrap();
    let written = underbrush!["replay", table, "--out", page];
    assert!(written.stderr.contains("1 of 2 trials have forces of 0.03 N or less"), "{}", written.stderr);
    assert!(page.exists());
}
