//! The skin of a data set: `meta/taxels.parquet` with one row per taxel, and links and grids of the patches in its
//! metadata.

use std::path::Path;

use crate::disk::check::check_layout;
use crate::disk::table::{ParquetTable, Row, Want, broken, write_table};
use crate::disk::tables::description::about_entry;
use crate::disk::tables::dictionary::{SkinTaxel, TAXELS};
use crate::{DiskError, Patch, SkinLayout, Taxel};

/// Metadata key of the patches without their taxels, as JSON.
const PATCHES_KEY: &str = "underbrush.patches";

/// Writes the taxel table.
pub(crate) fn write_taxels(path: &Path, layout: &SkinLayout) -> Result<(), DiskError> {
    let row = |patch: &Patch, index: usize, taxel: &Taxel| SkinTaxel {
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
    let mut rows = Vec::new();
    for patch in &layout.patches {
        let taxels = patch.taxels.iter().enumerate();
        rows.extend(taxels.map(|(index, taxel)| row(patch, index, taxel)));
    }
    let bare = |patch: &Patch| Patch { taxels: Vec::new(), ..patch.clone() };
    let patches = serde_json::to_string(&layout.patches.iter().map(bare).collect::<Vec<_>>())
        .map_err(DiskError::io(path, "write"))?;
    let columns = SkinTaxel::write(&rows);
    let about = about_entry(&[&TAXELS], &columns, &[]);
    write_table(path, columns, vec![(PATCHES_KEY, patches), about])
}

/// Reads the skin.
pub(crate) fn read_taxels(path: &Path) -> Result<SkinLayout, DiskError> {
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
