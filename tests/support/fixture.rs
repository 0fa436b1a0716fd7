//! A small data set with its trials and a model, made once by the program for all tests that only read them.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use underbrush_recording::Trial;
use underbrush_recording::disk::read_trials;

use super::{scenes, table, underbrush};

/// Files that tests read but do not change.
pub struct Fixture {
    folder: PathBuf,
}

static FIXTURE: LazyLock<Fixture> = LazyLock::new(|| {
    // Statics are not dropped at the end of a test process, so the next run clears the folder.
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fixture");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    let fixture = Fixture { folder };
    let leaf = scenes::write(&fixture.folder, "leaf.toml", scenes::LEAVES_AT_FOREARM);
    let trunk = scenes::write(&fixture.folder, "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    underbrush!["generate", leaf, trunk, "--reaches", "3", "--seed", "1", "--out", fixture.dataset()].success();
    for table in [fixture.table_csv(), fixture.table_parquet()] {
        underbrush!["trials", fixture.dataset(), "--out", table].success();
    }
    let trials = read_trials(fixture.table_csv()).unwrap();
    for category in ["leaf", "trunk"] {
        let count = trials.iter().filter(|trial| trial.category.as_deref() == Some(category)).count();
        assert!(count >= 4, "{count} {category} trials are too few for the tests: draw the scenes of the fixture anew");
    }
    underbrush!["train", fixture.table_csv(), "--out", fixture.model(), "--states", "3"].success();
    fixture
});

/// The fixture.
pub fn fixture() -> &'static Fixture {
    &FIXTURE
}

impl Fixture {
    fn file(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// A scene of leaves that touch the forearm.
    pub fn leaf_scene(&self) -> PathBuf {
        self.file("leaf.toml")
    }

    /// A scene of trunks that touch the forearm.
    pub fn trunk_scene(&self) -> PathBuf {
        self.file("trunk.toml")
    }

    /// A data set of three reaches of each scene, seed 1.
    pub fn dataset(&self) -> PathBuf {
        self.file("dataset")
    }

    /// Its trials.
    pub fn table_csv(&self) -> PathBuf {
        self.file("trials.csv")
    }

    /// Its trials.
    pub fn table_parquet(&self) -> PathBuf {
        self.file("trials.parquet")
    }

    /// A model of three states trained on them.
    pub fn model(&self) -> PathBuf {
        self.file("model.json")
    }
}

/// Writes the recording of the first reach of `scene` with trials on the forearm, and returns these trials.
pub fn recording_with_trials(scene: &Path, recording: &Path) -> Vec<Trial> {
    let table = recording.with_extension("csv");
    for index in 0..20 {
        let index = index.to_string();
        underbrush!["reach", scene, "--seed", "1", "--index", index, "--out", recording, "--force"].success();
        if underbrush!["trials", recording, "--out", table].status == 0 {
            return read_trials(&table).unwrap();
        }
    }
    panic!("twenty reaches of {} leave the forearm untouched: draw the scene anew", scene.display());
}

/// The fixture's trials without their reaches, in a file in `folder`: one category is touched in a single reach, which is
/// too few to split by.
pub fn table_without_reaches(folder: &Path) -> PathBuf {
    let rows = table::rows(&std::fs::read_to_string(fixture().table_csv()).unwrap());
    let columns = ["trial", "category", "time_s", "force_n"];
    let mut lines = vec![columns.join(",")];
    lines.extend(rows.iter().map(|row| columns.map(|column| row[column].as_str()).join(",")));
    let path = folder.join("without-reaches.csv");
    std::fs::write(&path, lines.join("\n")).unwrap();
    path
}
