//! The skin of a data set: `meta/taxels.parquet` with one row per taxel, and links and grids of the patches in its
//! metadata.

use std::path::Path;

use arrow_array::types::Float64Type;
use arrow_array::{Float64Array, Int32Array, StringArray};
use parquet::arrow::arrow_reader::ArrowReaderOptions;

use crate::disk::DiskError;
use crate::disk::check::check_layout;
use crate::disk::dictionary::TAXELS;
use crate::disk::parquet_file::{Batches, key_value, open, write_table};
use crate::disk::parquet_input::broken;
use crate::disk::table::{Columns, TableBuilder};
use crate::{Patch, SkinLayout, Taxel};

/// Metadata key of the patches without their taxels, as JSON.
const PATCHES_KEY: &str = "underbrush.patches";

/// Writes the taxel table.
pub(super) fn write_taxels(path: &Path, layout: &SkinLayout) -> Result<(), DiskError> {
    let rows: Vec<(&Patch, usize, &Taxel)> = layout
        .patches
        .iter()
        .flat_map(|patch| {
            patch
                .taxels
                .iter()
                .enumerate()
                .map(move |(index, taxel)| (patch, index, taxel))
        })
        .collect();
    let place = |pick: fn(usize, usize) -> usize| -> Int32Array {
        rows.iter()
            .map(|(patch, index, _)| patch.grid.map(|grid| pick(*index, grid.columns) as i32))
            .collect()
    };
    let taxels = || rows.iter().map(|(.., taxel)| *taxel);
    let batch = TableBuilder::new(&TAXELS)
        .column(
            "patch",
            StringArray::from_iter_values(rows.iter().map(|(patch, ..)| &patch.name)),
        )
        .column(
            "taxel",
            Int32Array::from_iter_values(rows.iter().map(|(_, index, _)| *index as i32)),
        )
        .column("row", place(|index, columns| index / columns))
        .column("column", place(|index, columns| index % columns))
        .column(
            "link",
            StringArray::from_iter_values(rows.iter().map(|(patch, ..)| &patch.link)),
        )
        .vectors("position_link", "_m", taxels().map(|taxel| taxel.position_link))
        .vectors("normal_link", "", taxels().map(|taxel| taxel.normal_link))
        .vectors("tangent_link", "", taxels().map(|taxel| taxel.tangent_link))
        .column(
            "area_m2",
            Float64Array::from_iter_values(taxels().map(|taxel| taxel.area_m2)),
        )
        .build(path)?;
    let bare = |patch: &Patch| Patch {
        taxels: Vec::new(),
        ..patch.clone()
    };
    let patches = serde_json::to_string(&layout.patches.iter().map(bare).collect::<Vec<_>>())
        .map_err(|error| DiskError::io(path, "write")(error.into()))?;
    write_table(path, &batch, [(PATCHES_KEY, patches)])
}

/// Reads the skin.
pub(super) fn read_taxels(path: &Path) -> Result<SkinLayout, DiskError> {
    let (file, builder) = open(path, ArrowReaderOptions::default())?;
    let patches: Vec<Patch> = serde_json::from_str(&key_value(path, &builder, PATCHES_KEY)?)
        .map_err(|error| broken(path, format!("{PATCHES_KEY}: {error}")))?;
    let mut layout = SkinLayout { patches };
    for batch in Batches::new(file, builder)? {
        let batch = batch?;
        let columns = Columns { path, batch: &batch };
        let patch = columns.text("patch")?;
        let area = columns.numbers::<Float64Type>("area_m2")?;
        let position = columns.vectors("position_link", "_m")?;
        let (normal, tangent) = (
            columns.vectors("normal_link", "")?,
            columns.vectors("tangent_link", "")?,
        );
        for row in 0..batch.num_rows() {
            let name = patch.value(row);
            let index = layout
                .patch_index(name)
                .ok_or_else(|| columns.error("patch", name, "a patch named in the file's metadata"))?;
            layout.patches[index].taxels.push(Taxel {
                position_link: position[row],
                normal_link: normal[row],
                tangent_link: tangent[row],
                area_m2: area[row],
            });
        }
    }
    check_layout(&layout).map_err(|violation| violation.misread(path))?;
    Ok(layout)
}
