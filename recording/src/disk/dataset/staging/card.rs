//! The card of a data set: `README.md` at its root.
//!
//! Its front matter tells Hugging Face's `datasets` which files belong together. Without it, `load_dataset` reads all
//! Parquet files of the folder as one table and fails.

use std::fmt::Write;

use crate::Category;
use crate::disk::tables::description::describe_tables;
use crate::disk::tables::dictionary::{FRAMES, TABLES};

use crate::disk::dataset::info::Info;

/// The card of a set with objects of further `categories`.
pub(crate) fn card(info: &Info, categories: &[Category]) -> String {
    let mut text = "---\ntags:\n- LeRobot\n- tactile\nconfigs:\n".to_string();
    for table in TABLES {
        let files = match table.path.strip_suffix(".parquet") {
            Some(_) => table.path.to_string(),
            None => format!("{}/*/*.parquet", table.path),
        };
        let default = if table.name == FRAMES.name { "  default: true\n" } else { "" };
        let _ = write!(text, "- config_name: {}\n  data_files: {files}\n{default}", table.name);
    }
    let _ = write!(
        text,
        "---\n\n# Reaches of {} with tactile skin\n\n\
         {} reaches, {} frames at {} Hz, written by underbrush in the LeRobotDataset {} layout.\n\n\
         `data/` holds what a robot could know. Ground truth is in `truth/` and is not among the features of \
         `meta/info.json`, so that no learner reads it by accident. Rows of `truth/taxels` belong to the frames with \
         the same `episode_index` and `frame_index`:\n\n\
         ```python\n\
         import pandas as pd\n\
         frames = pd.read_parquet(\"data\")\n\
         truth = pd.read_parquet(\"truth/taxels\")\n\
         joined = truth.merge(frames, on=[\"episode_index\", \"frame_index\"])\n\
         ```\n\n\
         With `datasets`, `load_dataset(FOLDER)` loads the frames and `load_dataset(FOLDER, \"truth_taxels\")` another \
         table.\n\n",
        info.robot_type, info.total_episodes, info.total_frames, info.fps, info.codebase_version
    );
    text + &describe_tables(&TABLES, categories)
}
