//! Writes Parquet files.

use std::iter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, ZstdLevel};
use parquet::column::writer::{ColumnCloseResult, ColumnWriter, ColumnWriterImpl, get_column_writer};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder, WriterPropertiesPtr};
use parquet::file::writer::{SerializedFileWriter, SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{ColumnDescPtr, ColumnPath, SchemaDescriptor, Type as Schema, TypePtr};
use tempfile::NamedTempFile;

use super::arrow_schema;
use super::column::{Column, Rows, Text, Type, Values};
use crate::disk::files::{self, TemporaryFile};
use crate::disk::footer;
use crate::disk::unfinished::Registered;
use crate::{DiskError, Result};

/// Number of rows that are encoded or decoded together. With 453 taxels their dense columns take about 15 MB.
pub(crate) const ROWS_PER_BATCH: usize = 1024;

/// The column with the episode of a row.
pub(crate) const EPISODE_COLUMN: &str = "episode_index";

/// A page ends at about this many values.
const VALUES_PER_PAGE: usize = 20_000;
/// The size of a page is checked after about this many values, except in plain columns without nulls.
const VALUES_PER_LOOK: usize = 1024;

/// The type of a column in the schema of a file.
fn schema_of(column: &Column) -> Result<TypePtr, ParquetError> {
    let (physical, logical) = column.values.type_of().parquet();
    let lists = column.has_lists();
    let value = Schema::primitive_type_builder(if lists { "item" } else { &column.name }, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()?;
    if !lists {
        return Ok(Arc::new(value));
    }
    let list = Schema::group_type_builder("list").with_repetition(Repetition::REPEATED);
    let list = list.with_fields(vec![Arc::new(value)]).build()?;
    let lists = Schema::group_type_builder(&column.name).with_repetition(Repetition::OPTIONAL);
    let lists = lists.with_logical_type(Some(LogicalType::List)).with_fields(vec![Arc::new(list)]);
    Ok(Arc::new(lists.build()?))
}

/// What the names of columns with poses of moving bodies have in common.
const POSE_COLUMNS: [&str; 3] = ["position_world_", "orientation_world_", "moved_pose"];

/// How the columns are encoded before compression: integers, which mostly count up, as differences; text by dictionary,
/// because it repeats; poses of moving bodies, which change little from row to row, by byte streams. fastparquet cannot
/// read byte streams, but a set of leaves would be 13 % larger without them.
fn encodings(columns: &[Column], described: &[ColumnDescPtr]) -> WriterPropertiesBuilder {
    let mut builder = WriterProperties::builder();
    for (column, described) in columns.iter().zip(described) {
        let path = described.path().clone();
        builder = match column.values.type_of() {
            Type::Int8 | Type::Int16 | Type::Int32 | Type::Int64 => {
                builder.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED)
            }
            Type::Float32 if POSE_COLUMNS.iter().any(|part| column.name.contains(part)) => {
                builder.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT)
            }
            Type::Text => builder.set_column_dictionary_enabled(path, true),
            Type::Uint32 | Type::Uint64 | Type::Float32 | Type::Float64 | Type::Bool => builder,
        };
    }
    builder
}

/// How rows with certain columns are encoded. Several threads may use it at a time.
pub(crate) struct Encoder {
    schema: TypePtr,
    columns: Vec<ColumnDescPtr>,
    properties: WriterPropertiesPtr,
}

/// A row group that is encoded, and belongs to no file yet.
pub(crate) type Group = Vec<(Bytes, ColumnCloseResult)>;

impl Encoder {
    /// For columns like these; `path` is named in errors.
    pub(crate) fn new(path: &Path, columns: &[Column]) -> Result<Self> {
        let fields = columns.iter().map(schema_of).collect::<Result<_, _>>();
        let schema = fields.and_then(|fields| Schema::group_type_builder("schema").with_fields(fields).build());
        let schema = Arc::new(schema.map_err(DiskError::encode(path))?);
        let described = SchemaDescriptor::new(Arc::clone(&schema)).columns().to_vec();
        let properties = encodings(columns, &described)
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            // Forces and angles hardly repeat, except for zeros, which zstd compresses well.
            .set_dictionary_enabled(false)
            .set_write_batch_size(VALUES_PER_PAGE)
            .set_data_page_row_count_limit(VALUES_PER_PAGE)
            // The minimum and maximum of a list column do not help a reader, and take time and space. The minimum and
            // maximum of the episode column let a reader skip all row groups except one.
            .set_statistics_enabled(EnabledStatistics::None)
            .set_column_statistics_enabled(ColumnPath::from(EPISODE_COLUMN), EnabledStatistics::Chunk)
            .build();
        Ok(Encoder { schema, columns: described, properties: Arc::new(properties) })
    }

    /// Encodes a row group. Its rows come in batches; only what is encoded is kept in memory. `path` is named in errors.
    pub(crate) fn encode(&self, path: &Path, batches: &mut dyn Iterator<Item = Vec<Column>>) -> Result<Group> {
        let encode = || DiskError::encode(path);
        let mut chunks: Vec<_> = self.columns.iter().map(|_| TrackedWrite::new(Vec::new())).collect();
        let pages = chunks.iter_mut().map(|chunk| Box::new(SerializedPageWriter::new(chunk)));
        let columns = self.columns.iter().cloned();
        let mut writers: Vec<_> = columns
            .zip(pages)
            .map(|(column, pages)| get_column_writer(column, Arc::clone(&self.properties), pages))
            .collect();
        for batch in batches {
            for (writer, column) in writers.iter_mut().zip(&batch) {
                put(writer, column).map_err(encode())?;
            }
        }
        let closed = writers.into_iter().map(ColumnWriter::close).collect::<Result<Vec<_>, _>>();
        let closed = closed.map_err(encode())?;
        let bytes = chunks.into_iter().map(|chunk| Ok(Bytes::from(chunk.into_inner()?)));
        let bytes = bytes.collect::<Result<Vec<_>, ParquetError>>().map_err(encode())?;
        Ok(bytes.into_iter().zip(closed).collect())
    }
}

/// A Parquet file (zstd) that is being written. It gets its name when it is closed.
pub(crate) struct ParquetFile {
    path: PathBuf,
    encoder: Encoder,
    writer: SerializedFileWriter<NamedTempFile>,
    /// Kept until the file has its name, or is removed.
    registered: Registered,
    /// Whether it will contain its own hash.
    sealed: bool,
}

impl ParquetFile {
    /// Creates a file for columns like these with key-value metadata. If [`footer::unsealed`] is among them, the file
    /// will contain its own hash.
    pub(crate) fn create(path: &Path, columns: &[Column], key_values: Vec<(&'static str, String)>) -> Result<Self> {
        let key_values = key_values.into_iter().chain(arrow_schema::entry(columns));
        let key_values: Vec<_> = key_values.map(|(key, value)| KeyValue::new(key.to_string(), value)).collect();
        let sealed = key_values.iter().any(|pair| pair.key == footer::SEAL_KEY);
        let encoder = Encoder::new(path, columns)?;
        let properties = WriterProperties::clone(&encoder.properties).into_builder();
        let properties = Arc::new(properties.set_key_value_metadata(Some(key_values)).build());
        let TemporaryFile { file, registered } = files::begin(path)?;
        let writer = SerializedFileWriter::new(file, Arc::clone(&encoder.schema), properties);
        let writer = writer.map_err(DiskError::encode(path))?;
        Ok(ParquetFile { path: path.to_path_buf(), encoder, writer, registered, sealed })
    }

    /// Writes a row group, unless it has no rows. Its rows come in batches; only what is encoded is kept in memory.
    pub(crate) fn write_group(&mut self, batches: &mut dyn Iterator<Item = Vec<Column>>) -> Result<()> {
        let group = self.encoder.encode(&self.path, batches)?;
        self.append(group)
    }

    /// Appends a row group that an encoder for columns like those of the file has encoded, unless it has no rows.
    pub(crate) fn append(&mut self, group: Group) -> Result<()> {
        if group.iter().all(|(_, closed)| closed.rows_written == 0) {
            return Ok(());
        }
        let append = || -> Result<(), ParquetError> {
            let mut row_group = self.writer.next_row_group()?;
            for (bytes, closed) in group {
                row_group.append_column(&bytes, closed)?;
            }
            row_group.close().map(drop)
        };
        append().map_err(DiskError::encode(&self.path))
    }

    /// Writes the footer and gives the file its name.
    pub(crate) fn close(self) -> Result<()> {
        let mut file = self.writer.into_inner().map_err(DiskError::encode(&self.path))?;
        footer::declare_usual_order(file.as_file_mut())
            .and_then(|()| if self.sealed { footer::seal(file.as_file_mut()) } else { Ok(()) })
            .map_err(DiskError::io(&self.path, "write"))?;
        files::commit(TemporaryFile { file, registered: self.registered }, &self.path)
    }
}

/// Writes a table of one batch.
pub(crate) fn write_table(path: &Path, columns: Vec<Column>, key_values: Vec<(&'static str, String)>) -> Result<()> {
    let mut file = ParquetFile::create(path, &columns, key_values)?;
    file.write_group(&mut iter::once(columns))?;
    file.close()
}

/// Appends values to a column of a row group.
fn put(writer: &mut ColumnWriter, column: &Column) -> Result<(), ParquetError> {
    use ColumnWriter as To;
    let rows = &column.rows;
    match (writer, &column.values) {
        (To::Int32ColumnWriter(to), Values::Int8(values)) => put_typed(to, values, rows, |value| i32::from(*value)),
        (To::Int32ColumnWriter(to), Values::Int16(values)) => put_typed(to, values, rows, |value| i32::from(*value)),
        (To::Int32ColumnWriter(to), Values::Int32(values)) => put_typed(to, values, rows, |value| *value),
        (To::Int32ColumnWriter(to), Values::Uint32(values)) => put_typed(to, values, rows, |value| *value as i32),
        (To::Int64ColumnWriter(to), Values::Int64(values)) => put_typed(to, values, rows, |value| *value),
        (To::Int64ColumnWriter(to), Values::Uint64(values)) => put_typed(to, values, rows, |value| *value as i64),
        (To::FloatColumnWriter(to), Values::Float32(values)) => put_typed(to, values, rows, |value| *value),
        (To::DoubleColumnWriter(to), Values::Float64(values)) => put_typed(to, values, rows, |value| *value),
        (To::BoolColumnWriter(to), Values::Bool(values)) => put_typed(to, values, rows, |value| *value),
        (To::ByteArrayColumnWriter(to), Values::Text(values)) => {
            let mut last: Option<(&Text, ByteArray)> = None;
            put_typed(to, values, rows, |value| match &last {
                Some((text, bytes)) if Text::ptr_eq(text, value) => bytes.clone(),
                _ => last.insert((value, ByteArray::from(value.as_bytes().to_vec()))).1.clone(),
            })
        }
        _ => Err(ParquetError::General(format!("a column {} of another type", column.name))),
    }
}

/// Appends values of one type. A definition level says whether a value is there: 1 if it is, in a plain column; in a
/// column of lists 0 for no list, 1 for an empty list, and 3 for a value. A repetition level is 0 where a row begins.
fn put_typed<'a, T: DataType, V>(
    writer: &mut ColumnWriterImpl<T>,
    values: &'a [V],
    rows: &Rows,
    mut convert: impl FnMut(&'a V) -> T::T,
) -> Result<(), ParquetError> {
    match rows {
        Rows::Fixed(1) => {
            for values in values.chunks(VALUES_PER_PAGE) {
                let converted: Vec<_> = values.iter().map(&mut convert).collect();
                writer.write_batch(&converted, Some(&vec![1; values.len()]), None)?;
            }
        }
        Rows::Fixed(width) => {
            let step = VALUES_PER_LOOK.div_ceil(*width) * width;
            let definition = vec![3; step];
            let repetition: Vec<i16> = (0..step).map(|place| i16::from(place % width > 0)).collect();
            for values in values.chunks(step) {
                let converted: Vec<_> = values.iter().map(&mut convert).collect();
                let (definition, repetition) = (&definition[..values.len()], &repetition[..values.len()]);
                writer.write_batch(&converted, Some(definition), Some(repetition))?;
            }
        }
        Rows::Optional(present) => {
            let mixed = present.contains(&true) && present.contains(&false);
            let step = if mixed { VALUES_PER_LOOK } else { VALUES_PER_PAGE };
            for (values, present) in values.chunks(step).zip(present.chunks(step)) {
                let there = values.iter().zip(present).filter(|(_, present)| **present);
                let converted: Vec<_> = there.map(|(value, _)| convert(value)).collect();
                let definition: Vec<i16> = present.iter().map(|present| i16::from(*present)).collect();
                writer.write_batch(&converted, Some(&definition), None)?;
            }
        }
        Rows::Lists { ends, present } => {
            let (mut definition, mut repetition, mut converted) = (Vec::new(), Vec::new(), Vec::new());
            let mut start = 0;
            for (row, (&end, &present)) in ends.iter().zip(present).enumerate() {
                let list = &values[start..end];
                start = end;
                converted.extend(list.iter().map(&mut convert));
                if list.is_empty() {
                    definition.push(i16::from(present));
                    repetition.push(0);
                } else {
                    definition.resize(definition.len() + list.len(), 3);
                    repetition.push(0);
                    repetition.resize(definition.len(), 1);
                }
                if definition.len() >= VALUES_PER_LOOK || row + 1 == ends.len() {
                    writer.write_batch(&converted, Some(&definition), Some(&repetition))?;
                    definition.clear();
                    repetition.clear();
                    converted.clear();
                }
            }
        }
    }
    Ok(())
}
