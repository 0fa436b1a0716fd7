//! Trials as Parquet, as written by this program, pandas, Polars or DuckDB.

use std::path::Path;

use arrow_array::builder::{BooleanBuilder, Float64Builder, StringBuilder, UInt32Builder, UInt64Builder};
use arrow_array::cast::AsArray;
use arrow_array::types::{
    ArrowPrimitiveType, Float32Type, Float64Type, Int8Type, Int16Type, Int32Type, Int64Type, UInt8Type, UInt16Type,
    UInt32Type, UInt64Type,
};
use arrow_array::{Array, ArrayRef, RecordBatch};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ArrowReaderOptions;

use super::cell::{Cell, Cells};
use super::collect::Collector;
use super::{COLUMNS, TOUCHED, place_columns};
use crate::disk::parquet_file::{Batches, ParquetFile, ROWS_PER_BATCH, open};
use crate::disk::table::TableBuilder;
use crate::disk::{DiskError, seal};
use crate::{InputError, Trial};

/// Reads a table.
pub(super) fn read(path: &Path) -> Result<Vec<Trial>, DiskError> {
    // Without the Arrow schema in the metadata, large strings, string views, categories and the like are all read as
    // plain strings.
    let (file, builder) = open(path, ArrowReaderOptions::default().with_skip_arrow_metadata(true))?;
    // Tables of other programs do not contain a hash.
    seal::check_if_sealed(path)?;
    let names: Vec<String> = builder
        .schema()
        .fields()
        .iter()
        .map(|field| field.name().clone())
        .collect();
    let known = place_columns(path, &names)?.into_iter().flatten();
    let mask = ProjectionMask::roots(builder.parquet_schema(), known);
    let mut collector = Collector::default();
    let mut line = 0;
    for batch in Batches::new(file, builder.with_projection(mask))? {
        let batch = batch?;
        let mut columns = Vec::with_capacity(COLUMNS.len());
        for name in COLUMNS {
            columns.push(match batch.column_by_name(name) {
                Some(array) => cells(path, name, array)?,
                None => vec![Cell::Missing; batch.num_rows()],
            });
        }
        for row in 0..batch.num_rows() {
            line += 1;
            let cells = row_of(&columns, row);
            collector.push(path, Cells { path, line, cells }.row()?)?;
        }
    }
    Ok(collector.finish())
}

fn row_of<'a>(columns: &[Vec<Cell<'a>>], row: usize) -> [Cell<'a>; COLUMNS.len()] {
    std::array::from_fn(|column| columns[column][row])
}

/// The cells of a column of any suitable type.
fn cells<'a>(path: &Path, name: &str, array: &'a ArrayRef) -> Result<Vec<Cell<'a>>, DiskError> {
    fn of<'a, T: ArrowPrimitiveType>(array: &ArrayRef, cell: fn(T::Native) -> Cell<'a>) -> Option<Vec<Cell<'a>>> {
        Some(
            array
                .as_primitive_opt::<T>()?
                .iter()
                .map(|value| value.map_or(Cell::Missing, cell))
                .collect(),
        )
    }
    let text = |array: &'a ArrayRef| -> Option<Vec<Cell<'a>>> {
        let cell = |text: Option<&'a str>| text.filter(|text| !text.is_empty()).map_or(Cell::Missing, Cell::Text);
        Some(array.as_string_opt::<i32>()?.iter().map(cell).collect())
    };
    let flags = || -> Option<Vec<Cell<'a>>> {
        let flags = array.as_boolean_opt().filter(|_| name == TOUCHED)?;
        Some(
            flags
                .iter()
                .map(|flag| flag.map_or(Cell::Missing, Cell::Flag))
                .collect(),
        )
    };
    // pandas gives a column without values the type "null".
    let nothing = (array.logical_null_count() == array.len()).then(|| vec![Cell::Missing; array.len()]);
    nothing
        .or_else(|| of::<Float64Type>(array, Cell::Number))
        .or_else(|| of::<Float32Type>(array, |number| Cell::Number(number.into())))
        .or_else(|| of::<Int64Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<Int32Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<Int16Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<Int8Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<UInt64Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<UInt32Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<UInt16Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| of::<UInt8Type>(array, |number| Cell::Whole(number.into())))
        .or_else(|| text(array))
        .or_else(flags)
        .ok_or_else(|| {
            let remedy = "cast the column before writing the table";
            let found = format!("a column of {}", array.data_type());
            InputError::new(
                path,
                name,
                found,
                "a column of integers, floating-point numbers or text",
                remedy,
            )
            .into()
        })
}

/// Builders of the columns.
#[derive(Default)]
struct Columns {
    trial: UInt64Builder,
    category: StringBuilder,
    reach: UInt64Builder,
    patch: StringBuilder,
    taxel: UInt32Builder,
    time_s: Float64Builder,
    force_n: Float64Builder,
    motion_m: Float64Builder,
    region_taxels: UInt32Builder,
    region_largest_force_n: Float64Builder,
    region_force_sum_n: Float64Builder,
    touched: BooleanBuilder,
    rows: usize,
}

impl Columns {
    fn push(&mut self, trial: &Trial) {
        for sample in &trial.samples {
            self.trial.append_value(trial.trial);
            self.category.append_option(trial.category.as_deref());
            self.reach.append_option(trial.reach);
            self.patch.append_option(trial.patch.as_deref());
            self.taxel.append_option(trial.taxel);
            self.time_s.append_value(sample.time_s);
            self.force_n.append_value(sample.force_n);
            self.motion_m.append_option(sample.motion_m);
            let region = sample.region;
            self.region_taxels.append_option(region.map(|region| region.taxels));
            self.region_largest_force_n
                .append_option(region.map(|region| region.largest_force_n));
            self.region_force_sum_n
                .append_option(region.map(|region| region.force_sum_n));
            self.touched.append_option(sample.touched);
        }
        self.rows += trial.samples.len();
    }

    /// Takes the rows so far.
    fn take(&mut self, path: &Path) -> Result<RecordBatch, DiskError> {
        self.rows = 0;
        let [
            trial,
            category,
            reach,
            patch,
            taxel,
            time_s,
            force_n,
            motion_m,
            region_taxels,
            largest,
            sum,
            touched,
        ] = COLUMNS;
        TableBuilder::undescribed()
            .column(trial, self.trial.finish())
            .column(category, self.category.finish())
            .column(reach, self.reach.finish())
            .column(patch, self.patch.finish())
            .column(taxel, self.taxel.finish())
            .column(time_s, self.time_s.finish())
            .column(force_n, self.force_n.finish())
            .column(motion_m, self.motion_m.finish())
            .column(region_taxels, self.region_taxels.finish())
            .column(largest, self.region_largest_force_n.finish())
            .column(sum, self.region_force_sum_n.finish())
            .column(touched, self.touched.finish())
            .build(path)
    }
}

/// All trials as one batch.
pub(super) fn batch(trials: &[Trial]) -> Result<RecordBatch, DiskError> {
    let mut columns = Columns::default();
    trials.iter().for_each(|trial| columns.push(trial));
    columns.take(Path::new("the trials"))
}

/// Writes a table.
pub(super) fn write(path: &Path, trials: impl Iterator<Item = Result<Trial, DiskError>>) -> Result<(), DiskError> {
    let mut columns = Columns::default();
    let mut file = ParquetFile::create(path, columns.take(path)?.schema(), [seal::unsealed()])?;
    for trial in trials {
        columns.push(&trial?);
        if columns.rows >= ROWS_PER_BATCH {
            file.write(&columns.take(path)?)?;
        }
    }
    file.write(&columns.take(path)?)?;
    file.close()
}
