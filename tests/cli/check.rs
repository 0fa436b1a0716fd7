//! `underbrush check`.

use std::path::{Path, PathBuf};

use roxmltree::{Document, Node};
use serde_json::Value;

use super::touch;
use crate::support::fixture::fixture;
use crate::support::{Answer, underbrush};

/// A file of the suites that ship.
fn shipped(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("suites").join(name);
    std::fs::read_to_string(path).unwrap()
}

/// Ten reaches of each of the pinned scenes that ship, with one sensitive metric each and no bounds yet.
const SUITE: &str = r#"summary = "A leaf's stiffness and the allowed force"
seed = 1
[[scenes]]
scene = "one-leaf.toml"
reaches = 10
[scenes.bounds]
audit = {}
mean_force_n.leaf = {} # proportional to the leaf's stiffness
[[scenes]]
scene = "one-trunk.toml"
reaches = 10
[scenes.bounds]
mean_force_n.trunk = {} # follows f_max
"#;

/// Writes the suite and its scenes.
fn suite(folder: &Path) -> PathBuf {
    for scene in ["one-leaf.toml", "one-trunk.toml"] {
        std::fs::write(folder.join(scene), shipped(&format!("scenes/{scene}"))).unwrap();
    }
    let file = folder.join("suite.toml");
    std::fs::write(&file, SUITE).unwrap();
    file
}

/// A text with one part replaced. The text must contain the part exactly once.
fn replaced(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from} in {text}");
    text.replace(from, to)
}

/// The names of the broken bounds of a check with `--json`.
fn broken(answer: &Answer) -> Vec<String> {
    let report: Value = serde_json::from_str(&answer.stdout).unwrap();
    let suites = report["suites"].as_array().unwrap().iter();
    let scenes = suites.flat_map(|suite| suite["scenes"].as_array().unwrap());
    let bounds = scenes.flat_map(|scene| scene["bounds"].as_array().unwrap());
    let names: Vec<String> = bounds
        .filter(|bound| bound["verdict"] != "holds")
        .map(|bound| bound["name"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(report["passed"], names.is_empty());
    assert_eq!(answer.status, i32::from(!names.is_empty()), "{}", answer.stderr);
    names
}

/// Tests that suites tell a harmless change from a real one. A blessed suite passes again, also on other draws of the
/// same scenes, which stand for a harmless change of the program. A leaf that is a fifth stiffer or softer breaks the
/// bound on its force, and an allowed force that is a fifth higher or lower breaks the bound on the trunk's force.
/// After the changed scenes are blessed, they pass.
#[test]
fn a_harmless_change_passes_and_a_real_one_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let file = suite(folder.path());
    let [leaf, trunk] = ["one-leaf.toml", "one-trunk.toml"].map(|name| folder.path().join(name));
    let check = || broken(&underbrush!["check", &file, "--json"]);
    let stiffness = |factor: f64| {
        let text = shipped("scenes/one-leaf.toml");
        let changed = format!("flexural_rigidity_n_m2 = {}\n", 0.03 * factor);
        std::fs::write(&leaf, replaced(&text, "flexural_rigidity_n_m2 = 0.03\n", &changed)).unwrap();
    };
    let allowed_force = |factor: f64| {
        let text = shipped("scenes/one-trunk.toml");
        let changed = format!("[robot]\nforce_limit_scale = {factor:?}\n[goals]\n");
        std::fs::write(&trunk, replaced(&text, "[goals]\n", &changed)).unwrap();
    };
    assert!(broken(&underbrush!["check", &file, "--bless", "--json"]).is_empty());
    assert!(check().is_empty());
    assert_eq!(broken(&underbrush!["check", &file, "--seed", "2", "--json"]), [""; 0]);
    stiffness(1.2);
    assert_eq!(check(), ["mean_force_n.leaf"]);
    stiffness(1.0);
    allowed_force(1.2);
    assert_eq!(check(), ["mean_force_n.trunk"]);
    stiffness(0.8);
    allowed_force(0.8);
    assert_eq!(check(), ["mean_force_n.leaf", "mean_force_n.trunk"]);
    assert!(broken(&underbrush!["check", &file, "--bless", "--json"]).is_empty());
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("# proportional to the leaf's stiffness"), "{text}");
}

/// Three reaches of the fixture's trunks with a model, two bounds that hold and one that cannot.
fn small(folder: &Path) -> PathBuf {
    std::fs::copy(fixture().trunk_scene(), folder.join("trunks & posts.toml")).unwrap();
    std::fs::copy(fixture().model(), folder.join("model.json")).unwrap();
    let file = folder.join("small.toml");
    let text = "summary = \"Small\"\nseed = 1\n[model]\nfile = \"model.json\"\n[[scenes]]\nscene = \"trunks & posts.toml\"\n\
                reaches = 3\n[scenes.bounds]\naudit = { at_most = 1 }\npeak_force_n.trunk = { at_most = 0.001 }\n\
                right.trunk = { at_least = 0 }\n";
    std::fs::write(&file, text).unwrap();
    file
}

/// Tests that no file is blessed if another one cannot be, because no reach touches its post.
#[test]
fn files_are_blessed_together() {
    let folder = tempfile::tempdir().unwrap();
    let [file, other] = [small(folder.path()), folder.path().join("other.toml")];
    let scene = folder.path().join("trunks & posts.toml");
    let post = "[[objects.trunk]]\ncount = 1\ncategory = \"post\"\n\
                place = { x_m = { uniform = [0.4, 0.6] }, y_m = { uniform = [0.6, 0.7] } }\n";
    std::fs::write(&scene, std::fs::read_to_string(&scene).unwrap() + post).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&other, format!("{text}peak_force_n.post = {{}}\n")).unwrap();
    underbrush!["check", file, other, "--bless"].refused(&["in 0 of 3 reaches", "nothing was written"]);
    assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
}

/// Tests that the file's own limit of the audit stays with `--bless`.
#[test]
fn a_limit_of_the_file_is_not_blessed() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    let text = "summary = \"No error at all\"\n[[scenes]]\nscene = \"trunks & posts.toml\"\nreaches = 2\n[scenes.bounds]\n\
                audit = { at_most = 0 }\n";
    std::fs::write(&file, text).unwrap();
    let answer = underbrush!["check", &file, "--bless"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    assert!(answer.stderr.contains("1 bound does not hold"), "{}", answer.stderr);
}

/// Tests that metrics without a bound count as bounds that do not hold.
#[test]
fn metrics_without_a_bound_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    let text = replaced(&std::fs::read_to_string(&file).unwrap(), "audit = { at_most = 1 }", "audit = {}");
    std::fs::write(&file, &text).unwrap();
    let both = underbrush!["check", &file].stderr;
    assert!(both.contains("2 bounds do not hold; if the change"), "{both}");
    std::fs::write(&file, replaced(&text, "trunk = { at_most = 0.001 }", "trunk = {}")).unwrap();
    let open = underbrush!["check", &file].stderr;
    assert!(open.contains("2 bounds do not hold"), "{open}");
}

/// Tests that a suite can have a touch model, and that its verdict `nothing` has metrics of its own.
#[test]
fn touch_models_judge_suites() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    std::fs::copy(touch::model(), folder.path().join("model.json")).unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let bounds = "wrong.trunk = { at_most = 1 }\nuncertain.trunk = { at_most = 1 }\ncalled_nothing.trunk = { at_most = 1 }\n\
                  spurious_called_nothing = { at_least = 0 }\n";
    std::fs::write(&file, text + bounds).unwrap();
    let answer = underbrush!["check", &file, "--json"];
    assert_eq!(broken(&answer), ["peak_force_n.trunk"]);
    let report: Value = serde_json::from_str(&answer.stdout).unwrap();
    let bounds = report["suites"][0]["scenes"][0]["bounds"].as_array().unwrap();
    let found = |name: &str| {
        let bound = bounds.iter().find(|bound| bound["name"] == name);
        bound.and_then(|bound| bound["found"].as_f64()).unwrap()
    };
    let [right, wrong, uncertain] = ["right", "wrong", "uncertain"].map(|name| found(&format!("{name}.trunk")));
    assert!((right + wrong + uncertain - 1.0).abs() < 1e-12, "{right} {wrong} {uncertain}");
    let nothing = found("called_nothing.trunk");
    assert!((0.0..=wrong).contains(&nothing), "{nothing} of {wrong}");
    assert!((0.0..=1.0).contains(&found("spurious_called_nothing")));
}

/// The elements of an XML document with their attributes.
fn elements(document: &str) -> Vec<(String, Vec<(String, String)>)> {
    let parsed = Document::parse(document).unwrap();
    let element = |node: Node| {
        let attributes = node.attributes().map(|own| (own.name().to_owned(), own.value().to_owned()));
        (node.tag_name().name().to_owned(), attributes.collect())
    };
    parsed.descendants().filter(Node::is_element).map(element).collect()
}

/// Tests that a broken bound gives exit status 1 and names the reach to look at, and that the command shown for this
/// reach runs and gives the reported value.
#[test]
fn a_broken_bound_names_a_reach() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    let answer = underbrush!["check", &file];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    for part in ["1 bound does not hold", "--bless"] {
        assert!(answer.stderr.contains(part), "{}", answer.stderr);
    }
    assert!(answer.stdout.contains("small: 2 of 3 bounds hold"), "{}", answer.stdout);
    let shown = answer.stdout.lines().find(|line| line.contains("underbrush reach")).unwrap();
    // The path has a space and needs quotes.
    let (path, options) = shown.trim().strip_prefix("underbrush reach '").unwrap().split_once("' ").unwrap();
    let mut arguments = vec!["reach".into(), path.into(), "--json".into()];
    let picture = folder.path().join("reach.png");
    arguments.extend(options.split(' ').map(|option| match option {
        "reach.png" => picture.clone().into(),
        option => std::ffi::OsString::from(option),
    }));
    let reach = crate::support::call(arguments, "").json();
    assert!(picture.exists());
    let found = answer.stdout.split("where it is ").nth(1).unwrap().split(':').next().unwrap();
    let (found, peak): (f64, f64) = (found.parse().unwrap(), reach["peak_contact_force_n"].as_f64().unwrap());
    // The text has four digits.
    assert!((found / peak - 1.0).abs() < 1e-3, "{found} {peak}");
}

/// Tests the files of `--out`: JUnit XML with a test for each bound and one failure, JSON with the values of all
/// reaches, and the same bytes from one thread and from two.
#[test]
fn results_are_written_for_ci() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path());
    let [one, two] = ["one", "two"].map(|name| folder.path().join(name));
    assert_eq!(underbrush!["check", &file, "--out", &one, "--jobs", "1"].status, 1);
    assert_eq!(underbrush!["check", &file, "--out", &two, "--jobs", "2"].status, 1);
    crate::support::assert_same_trees(&one, &two);
    let document = std::fs::read_to_string(one.join("junit.xml")).unwrap();
    let found = elements(&document);
    let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
    let expected = ["testsuites", "testsuite", "testcase", "testcase", "failure", "testcase"];
    assert_eq!(names, expected);
    let value = |place: usize, key: &str| {
        let attributes: &Vec<(String, String)> = &found[place].1;
        attributes.iter().find(|own| own.0 == key).unwrap().1.clone()
    };
    assert_eq!([value(0, "tests"), value(0, "failures")], ["3", "1"]);
    assert_eq!([value(1, "tests"), value(1, "failures")], ["3", "1"]);
    assert_eq!(value(3, "classname"), "small.trunks & posts");
    assert_eq!(value(3, "name"), "peak_force_n.trunk");
    assert!(value(4, "message").contains("more than at_most = 0.001"), "{document}");
    let results: Value = serde_json::from_str(&std::fs::read_to_string(one.join("results.json")).unwrap()).unwrap();
    let bounds = results["suites"][0]["scenes"][0]["bounds"].as_array().unwrap();
    assert_eq!(bounds[0]["values"].as_array().unwrap().len(), 3);
    assert_eq!(bounds[1]["verdict"], "too_large");
    assert!(bounds[2]["found"].is_number(), "{}", bounds[2]);
}
