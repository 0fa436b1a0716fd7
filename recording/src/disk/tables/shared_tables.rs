//! The tables of what all reaches of a data set share: `meta/tasks.parquet` with one sentence for each kind of reach, and
//! `meta/taxels.parquet` with one row per taxel, and links and grids of the patches in its metadata.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::disk::check::check_layout;
use crate::disk::table::{Column, ParquetTable, Row, Text, Want, broken, write_table};
use crate::disk::tables::about_entry;
use crate::disk::tables::dictionary::{SkinTaxel, TAXELS};
use crate::{DiskError, Patch, Result, SkinLayout, Taxel};

/// Metadata key of the patches without their taxels, as JSON.
const PATCHES_KEY: &str = "underbrush.patches";

/// The entry of a column in the pandas metadata.
fn pandas_column(name: &str, pandas: &str, numpy: &str) -> Value {
    json!({"name": name, "field_name": name, "pandas_type": pandas, "numpy_type": numpy, "metadata": null})
}

/// Writes the tasks in the order of their numbers, from 0. LeRobot takes the sentence from the pandas index, so the
/// metadata declare `task` as the index.
pub(crate) fn write_tasks(path: &Path, numbers: &BTreeMap<&str, usize>) -> Result<()> {
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

/// Writes the taxel table.
pub(crate) fn write_taxels(path: &Path, layout: &SkinLayout) -> Result<()> {
    let row = |(patch, (index, taxel)): (&Patch, (usize, &Taxel))| SkinTaxel {
        patch: patch.name.as_str().into(),
        taxel: index as i32,
        row: patch.grid.map(|grid| (index / grid.columns) as i32),
        column: patch.grid.map(|grid| (index % grid.columns) as i32),
        link: patch.link.as_str().into(),
        position_link: taxel.position_link,
        normal_link: taxel.normal_link,
        tangent_link: taxel.tangent_link,
        area_m2: taxel.area_m2,
    };
    let taxels = layout.patches.iter().flat_map(|patch| patch.taxels.iter().enumerate().map(move |own| (patch, own)));
    let bare = |patch: &Patch| Patch { taxels: Vec::new(), ..patch.clone() };
    let patches = serde_json::to_string(&layout.patches.iter().map(bare).collect::<Vec<_>>())
        .map_err(DiskError::io(path, "write"))?;
    let columns = SkinTaxel::write(&taxels.map(row).collect::<Vec<_>>());
    let about = about_entry(&[&TAXELS], &columns, &[]);
    write_table(path, columns, vec![(PATCHES_KEY, patches), about])
}

/// Reads the skin.
pub(crate) fn read_taxels(path: &Path) -> Result<SkinLayout> {
    let table = ParquetTable::open(path)?;
    let patches: Vec<Patch> = serde_json::from_slice(table.key_value(PATCHES_KEY)?.as_bytes())
        .map_err(|error| broken(path, format!("{PATCHES_KEY}: {error}")))?;
    let mut layout = SkinLayout { patches };
    for batch in table.batches(&|_| Want::All) {
        let batch = batch?;
        for row in batch.rows_as::<SkinTaxel>()? {
            let index = layout
                .patch_index(&row.patch)
                .ok_or_else(|| batch.error("patch", &*row.patch, "a patch named in the file's metadata"))?;
            layout.patches[index].taxels.push(Taxel {
                position_link: row.position_link,
                normal_link: row.normal_link,
                tangent_link: row.tangent_link,
                area_m2: row.area_m2,
            });
        }
    }
    check_layout(&layout).map_err(|violation| violation.misread(path))?;
    Ok(layout)
}
