//! The tasks of a data set (`meta/tasks.parquet`): one sentence for each kind of reach.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

use arrow_array::{Int64Array, RecordBatch, StringArray};
use serde_json::{Value, json};

use crate::disk::DiskError;
use crate::disk::parquet_file::write_table;
use crate::disk::table::TableBuilder;

/// The tasks in the order of their first episodes, with their indices.
pub(super) fn number_tasks<'a>(tasks: impl IntoIterator<Item = &'a str>) -> BTreeMap<&'a str, i64> {
    let mut numbers = BTreeMap::new();
    for task in tasks {
        let next = numbers.len() as i64;
        numbers.entry(task).or_insert(next);
    }
    numbers
}

/// The entry of a column in the pandas metadata.
fn pandas_column(name: &str, pandas: &str, numpy: &str) -> Value {
    json!({"name": name, "field_name": name, "pandas_type": pandas, "numpy_type": numpy, "metadata": null})
}

/// Writes the tasks. LeRobot takes the sentence from the pandas index, so the Arrow schema declares `task` as the
/// index.
pub(super) fn write_tasks(path: &Path, numbers: &BTreeMap<&str, i64>) -> Result<(), DiskError> {
    let mut tasks: Vec<_> = numbers.iter().map(|(task, number)| (*number, *task)).collect();
    tasks.sort_unstable();
    let batch = TableBuilder::undescribed()
        .column(
            "task_index",
            Int64Array::from_iter_values(tasks.iter().map(|(number, _)| *number)),
        )
        .column(
            "task",
            StringArray::from_iter_values(tasks.iter().map(|(_, task)| *task)),
        )
        .build(path)?;
    let pandas = json!({
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [pandas_column("task_index", "int64", "int64"), pandas_column("task", "unicode", "object")],
        "creator": {"library": "underbrush", "version": env!("CARGO_PKG_VERSION")},
        "pandas_version": "2.0.0",
    });
    let metadata = HashMap::from([("pandas".to_string(), pandas.to_string())]);
    let schema = Arc::new(batch.schema().as_ref().clone().with_metadata(metadata));
    let batch = RecordBatch::try_new(schema, batch.columns().to_vec())
        .map_err(|error| DiskError::encode(path)(error.into()))?;
    write_table(path, &batch, [])
}
