//! The tasks of a data set (`meta/tasks.parquet`): one sentence for each kind of reach.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::DiskError;
use crate::disk::table::{Column, Text, write_table};

/// The entry of a column in the pandas metadata.
fn pandas_column(name: &str, pandas: &str, numpy: &str) -> Value {
    json!({"name": name, "field_name": name, "pandas_type": pandas, "numpy_type": numpy, "metadata": null})
}

/// Writes the tasks in the order of their numbers, from 0. LeRobot takes the sentence from the pandas index, so the metadata declare `task` as the
/// index.
pub(crate) fn write_tasks(path: &Path, numbers: &BTreeMap<&str, usize>) -> Result<(), DiskError> {
    let mut tasks: Vec<_> = numbers.iter().collect();
    tasks.sort_unstable_by_key(|(_, number)| **number);
    let columns = vec![
        Column::of("task_index", 0..tasks.len() as i64),
        Column::of("task", tasks.iter().map(|(task, _)| Text::from(**task))),
    ];
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [pandas_column("task_index", "int64", "int64"), pandas_column("task", "unicode", "object")],
        "creator": {"library": "underbrush", "version": env!("CARGO_PKG_VERSION")},
        "pandas_version": "2.0.0",
    });
    write_table(path, columns, vec![("pandas", pandas.to_string())])
}
