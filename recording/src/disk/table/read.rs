//! Reads Parquet files.

use std::iter;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, ParquetMetaDataReader};
use parquet::file::serialized_reader::SerializedPageReader;
use parquet::schema::types::ColumnDescriptor;

use super::parquet_input::{ParquetInput, is_text};
use super::plain_pages::{self, Float};
use super::{Batch, Column, ROWS_PER_BATCH, Rows, Text, Type, Value, Values, broken};
use crate::{DiskError, InputError, Result};

/// Metadata key of the descriptions, units and codes of the columns.
pub(crate) const COLUMNS_KEY: &str = "underbrush.columns";

/// Most text that is decoded at once, bytes.
const TEXT_PER_BATCH_BYTES: i64 = 64 << 20;

/// An open file and its footer.
#[derive(Clone)]
pub(crate) struct ParquetTable {
    /// The file.
    pub(crate) file: ParquetInput,
    /// Its footer.
    pub(crate) footer: Arc<ParquetMetaData>,
}

/// What to read of a column.
#[derive(Clone, Copy)]
pub(crate) enum Want {
    /// Nothing.
    Nothing,
    /// One value in each row, or lists of any length.
    All,
    /// This many values in each row.
    Fixed(usize),
}

/// Reads the footer of a file.
pub(crate) fn read_footer(file: &ParquetInput) -> Result<Arc<ParquetMetaData>> {
    let footer = file.decode(|| ParquetMetaDataReader::new().parse_and_finish(file)).or_else(|error| {
        // A file of another kind has no footer either.
        file.check_kind()?;
        Err(error)
    })?;
    file.check_sizes(&footer)?;
    Ok(Arc::new(footer))
}

impl ParquetTable {
    /// Opens a file and reads its footer.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = ParquetInput::open(path)?;
        let footer = read_footer(&file)?;
        Ok(ParquetTable { file, footer })
    }

    /// The value of a metadata key.
    pub(crate) fn key_value(&self, key: &'static str) -> Result<String> {
        self.find_key(key).map(str::to_owned).ok_or_else(|| {
            let remedy = "give a file written by underbrush; other programs drop its metadata when they rewrite it";
            let found = "no such key in the Parquet metadata";
            InputError::new(&self.file.path, key, found, "a file that has it", remedy).into()
        })
    }

    fn find_key(&self, key: &str) -> Option<&str> {
        let pairs = self.footer.file_metadata().key_value_metadata()?;
        pairs.iter().find(|pair| pair.key == key)?.value.as_deref()
    }

    /// Number of rows in a row group.
    pub(crate) fn rows_of(&self, group: usize) -> usize {
        usize::try_from(self.footer.row_group(group).num_rows()).unwrap_or(0)
    }

    /// The columns with one number in each row.
    pub(crate) fn number_columns(&self) -> Vec<String> {
        let columns = self.footer.file_metadata().schema_descr().columns().iter();
        let has_numbers = |column: &&Arc<ColumnDescriptor>| {
            let is_number = type_of(column).is_some_and(|kind| !matches!(kind, Type::Bool | Type::Text));
            is_number && column.max_rep_level() == 0 && column.path().parts().len() == 1
        };
        columns.filter(has_numbers).map(|column| column.name().to_owned()).collect()
    }

    /// All rows in batches with the columns that `want` names.
    pub(crate) fn batches(&self, want: &dyn Fn(&str) -> Want) -> impl Iterator<Item = Result<Batch>> {
        let mut groups = 0..self.footer.num_row_groups();
        // Of the current row group: the columns, the rows that are left, and how many are decoded at once.
        let (mut columns, mut left, mut at_once) = (Vec::new(), 0, 0);
        let mut read = move || -> Result<Option<Batch>> {
            while left == 0 {
                let Some(group) = groups.next() else { return Ok(None) };
                columns = self.open_columns(group, want)?;
                (left, at_once) = (self.rows_of(group), self.rows_at_once(group));
            }
            let rows = left.min(at_once);
            let columns = columns.iter_mut().map(|column| column.next(rows)).collect::<Result<_, _>>()?;
            left -= rows;
            Ok(Some(self.batch_of(rows, columns)))
        };
        iter::from_fn(move || read().transpose())
    }

    /// The columns of a row group that `want` names, from the first row on.
    fn open_columns(&self, group: usize, want: &dyn Fn(&str) -> Want) -> Result<Vec<ColumnValues>> {
        let chunks = self.footer.row_group(group).columns().iter().enumerate();
        let wanted = chunks.filter_map(|(place, chunk)| {
            let want = want(chunk.column_path().parts().first()?);
            (!matches!(want, Want::Nothing)).then(|| ColumnValues::open(self, group, place, want))
        });
        wanted.collect()
    }

    /// Some rows of a row group at once, with the columns that `want` names.
    pub(crate) fn batch(&self, group: usize, rows: Range<usize>, want: &dyn Fn(&str) -> Want) -> Result<Batch> {
        let whole = rows == (0..self.rows_of(group));
        let mut columns = Vec::new();
        for mut values in self.open_columns(group, want)? {
            let name = &values.source.name;
            let plain = match (values.want, values.kind) {
                (Want::Fixed(width), Some(Type::Float64)) if whole => self.plain::<f64>(group, name, width)?,
                (Want::Fixed(width), Some(Type::Float32)) if whole => self.plain::<f32>(group, name, width)?,
                _ => None,
            };
            columns.push(match plain {
                Some(column) => column,
                None => {
                    // The rows before are decoded in vain.
                    values.next(rows.start)?;
                    values.next(rows.len())?
                }
            });
        }
        Ok(self.batch_of(rows.len(), columns))
    }

    fn batch_of(&self, rows: usize, columns: Vec<Column>) -> Batch {
        let about = self.find_key(COLUMNS_KEY).unwrap_or_default().into();
        Batch { path: self.file.path.as_path().into(), rows, columns, about }
    }

    /// Number of rows of a row group that may be decoded at once.
    fn rows_at_once(&self, group: usize) -> usize {
        let texts = self.footer.row_group(group).columns().iter().filter(|column| is_text(column));
        let largest = texts.map(|column| column.uncompressed_size()).max().unwrap_or(0);
        // A dictionary may hold one long text that every row repeats.
        let rows = usize::try_from(TEXT_PER_BATCH_BYTES / largest.max(1)).unwrap_or(1);
        rows.clamp(1, ROWS_PER_BATCH)
    }

    /// A column of numbers of this type, if they are stored plainly.
    fn plain<F: Float>(&self, group: usize, name: &str, width: usize) -> Result<Option<Column>> {
        let (count, group) = (width * self.rows_of(group), self.footer.row_group(group));
        // A footer may promise more rows than the file can have.
        if count > plain_pages::most_numbers::<F>(group, name) {
            return Ok(None);
        }
        let mut numbers = vec![F::default(); count];
        let done = plain_pages::read(&self.file, group, name, |number| number, &mut numbers)?;
        Ok(done.then(|| Column::fixed(name, width, numbers)))
    }
}

/// The type of the values of a column; `None` if it is not one that columns here have.
fn type_of(column: &ColumnDescriptor) -> Option<Type> {
    use ConvertedType as Converted;
    let logical = column.logical_type_ref();
    let bits = match (logical, column.converted_type()) {
        (Some(LogicalType::Integer(integer)), _) => Some((integer.bit_width, integer.is_signed)),
        (Some(_), _) => None,
        (None, Converted::INT_8) => Some((8, true)),
        (None, Converted::INT_16) => Some((16, true)),
        (None, Converted::UINT_8 | Converted::UINT_16 | Converted::UINT_32) => Some((32, false)),
        (None, Converted::UINT_64) => Some((64, false)),
        (None, Converted::NONE | Converted::INT_32 | Converted::INT_64) => Some((64, true)),
        (None, _) => None,
    };
    match (column.physical_type(), bits) {
        (Physical::INT32, Some((8, true))) => Some(Type::Int8),
        (Physical::INT32, Some((16, true))) => Some(Type::Int16),
        (Physical::INT32, Some((_, true))) => Some(Type::Int32),
        (Physical::INT32, Some((_, false))) => Some(Type::Uint32),
        (Physical::INT64, Some((_, true))) => Some(Type::Int64),
        (Physical::INT64, Some((_, false))) => Some(Type::Uint64),
        (Physical::FLOAT, _) if logical.is_none() => Some(Type::Float32),
        (Physical::DOUBLE, _) if logical.is_none() => Some(Type::Float64),
        (Physical::BOOLEAN, _) if logical.is_none() => Some(Type::Bool),
        (Physical::BYTE_ARRAY, _) => {
            let text = match logical {
                Some(logical) => matches!(logical, LogicalType::String | LogicalType::Enum | LogicalType::Json),
                None => matches!(column.converted_type(), Converted::UTF8 | Converted::ENUM | Converted::JSON),
            };
            text.then_some(Type::Text)
        }
        _ => None,
    }
}

/// The values of a column in a row group, from the first row on.
struct ColumnValues {
    source: Source,
    want: Want,
    kind: Option<Type>,
    reader: ColumnReader,
}

impl ColumnValues {
    /// Opens a column by its place among the columns of the file.
    fn open(table: &ParquetTable, group: usize, place: usize, want: Want) -> Result<Self> {
        let metadata = table.footer.row_group(group);
        let chunk = metadata.column(place);
        let column = chunk.column_descr_ptr();
        let name = column.path().parts().first().cloned().unwrap_or_default();
        let nested = match column.max_rep_level() {
            0 => column.path().parts().len() > 1,
            1 => column.path().parts().len() != 3 || column.max_def_level() != 3,
            _ => true,
        };
        if nested {
            return Err(unknown(&table.file.path, &name, "a column of groups"));
        }
        let file = table.file.clone();
        let rows = table.rows_of(group);
        let reader = file.decode(|| -> Result<_, ParquetError> {
            let pages = SerializedPageReader::new(Arc::new(file.clone()), chunk, rows, None)?;
            Ok(get_column_reader(Arc::clone(&column), Box::new(pages)))
        })?;
        let source = Source { file, name, level: column.max_def_level() };
        Ok(ColumnValues { source, want, kind: type_of(&column), reader })
    }

    /// The next rows.
    fn next(&mut self, rows: usize) -> Result<Column> {
        use ColumnReader as From;
        let ColumnValues { source, want, kind, reader } = self;
        // Names repeat from row to row, so rows share a text with the row before if it is the same.
        let mut shared = Text::default();
        let (values, rows) = match (reader, *kind) {
            (From::Int32ColumnReader(from), Some(Type::Int8)) => {
                source.read(from, rows, |value| i8::try_from(value).ok())
            }
            (From::Int32ColumnReader(from), Some(Type::Int16)) => {
                source.read(from, rows, |value| i16::try_from(value).ok())
            }
            (From::Int32ColumnReader(from), Some(Type::Int32)) => source.read(from, rows, Some),
            (From::Int32ColumnReader(from), Some(Type::Uint32)) => source.read(from, rows, |value| Some(value as u32)),
            (From::Int64ColumnReader(from), Some(Type::Int64)) => source.read(from, rows, Some),
            (From::Int64ColumnReader(from), Some(Type::Uint64)) => source.read(from, rows, |value| Some(value as u64)),
            (From::FloatColumnReader(from), Some(_)) => source.read(from, rows, Some),
            (From::DoubleColumnReader(from), Some(_)) => source.read(from, rows, Some),
            (From::BoolColumnReader(from), Some(_)) => source.read(from, rows, Some),
            (From::ByteArrayColumnReader(from), Some(_)) => source.read(from, rows, |bytes| {
                let text = std::str::from_utf8(bytes.data()).ok()?;
                if *shared != *text {
                    shared = text.into();
                }
                Some(Text::clone(&shared))
            }),
            // A column of another type may have no values, as that of pandas without any.
            (From::BoolColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::Int32ColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::Int64ColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::Int96ColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::FloatColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::DoubleColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::ByteArrayColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
            (From::FixedLenByteArrayColumnReader(from), _) => source.read(from, rows, |_| None::<f64>),
        }?;
        let rows = match (rows, *want) {
            // Lists that all have this length become rows of this width.
            (Rows::Lists { ends, present }, Want::Fixed(width @ 2..))
                if present.iter().all(|present| *present)
                    && ends.iter().enumerate().all(|(row, end)| *end == (row + 1) * width) =>
            {
                Rows::Fixed(width)
            }
            (rows, _) => rows,
        };
        Ok(Column { name: source.name.clone(), values, rows })
    }
}

/// The column that values are read from.
struct Source {
    file: ParquetInput,
    name: String,
    /// Its largest definition level: 1 in a plain column, 3 in a column of lists.
    level: i16,
}

/// Two levels for each value or gap. The definition level says whether the value is there. The repetition level is 0 where
/// a row begins.
type Levels = [Vec<i16>; 2];

impl Source {
    /// The next rows, each with its values. It is an error if `convert` does not accept a value. Of the three steps only one
    /// depends on both types, and on `convert`, so that little is compiled for each pair of them.
    fn read<D: DataType, V: Value>(
        &self,
        from: &mut ColumnReaderImpl<D>,
        rows: usize,
        convert: impl FnMut(D::T) -> Option<V>,
    ) -> Result<(Values, Rows)> {
        let (values, levels) = self.stored(from, rows)?;
        let values: Option<Vec<V>> = values.into_iter().map(convert).collect();
        let spread = values.ok_or("values of another type").and_then(|values| spread(values, levels, self.level, rows));
        spread.map_err(|found| unknown(&self.file.path, &self.name, found))
    }

    /// The next rows as Parquet stores them: without the missing values, with the levels that say which are missing and where
    /// rows begin.
    fn stored<D: DataType>(&self, from: &mut ColumnReaderImpl<D>, rows: usize) -> Result<(Vec<D::T>, Levels)> {
        let (mut values, mut definition, mut repetition) = (Vec::new(), Vec::new(), Vec::new());
        let step = || from.read_records(rows, Some(&mut definition), Some(&mut repetition), &mut values);
        let (found, ..) = self.file.decode(step)?;
        if found != rows {
            return Err(broken(&self.file.path, format!("{found} of {rows} rows in the column {}", self.name)));
        }
        Ok((values, [definition, repetition]))
    }
}

/// The values row by row. `level` is the definition level of a present value.
fn spread<V: Value>(
    values: Vec<V>,
    [definition, repetition]: Levels,
    level: i16,
    rows: usize,
) -> Result<(Values, Rows), &'static str> {
    // Columns without missing values may have no levels.
    if level == 0 || (level == 1 && values.len() == definition.len()) {
        return Ok((V::all(values), Rows::Fixed(1)));
    }
    if level == 1 {
        let mut there = values.into_iter();
        let value = |found: &i16| if *found == 1 { there.next() } else { None };
        let spread: Vec<Option<V>> = definition.iter().map(value).collect();
        let present = spread.iter().map(Option::is_some).collect();
        let values = spread.into_iter().map(Option::unwrap_or_default).collect();
        return Ok((V::all(values), Rows::Optional(present)));
    }
    let (mut ends, mut present) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
    let mut end = 0;
    for (definition, repetition) in definition.iter().zip(&repetition) {
        if *repetition == 0 {
            ends.push(end);
            present.push(*definition > 0);
        }
        match definition {
            3 => end += 1,
            2 => return Err("lists with nulls"),
            _ => {}
        }
        if let Some(last) = ends.last_mut() {
            *last = end;
        }
    }
    Ok((V::all(values), Rows::Lists { ends, present }))
}

/// The error for a column of a type that is not supported.
pub(crate) fn unknown(path: &Path, name: &str, found: &str) -> DiskError {
    let remedy = "cast the column before writing the table";
    let allowed = "a column of integers, floating-point numbers or text";
    InputError::new(path, name, found, allowed, remedy).into()
}
