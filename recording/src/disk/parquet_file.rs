//! Reads and writes Parquet files.

use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::{KeyValue, RowGroupMetaData};
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::schema::types::ColumnPath;

use super::parquet_input::{ParquetInput, is_text};
use super::whole_file::{self, TemporaryFile};
use super::{DiskError, column_order, seal};
use crate::InputError;

/// Number of rows that are encoded or decoded together. With 453 taxels their dense columns take about 15 MB.
pub(super) const ROWS_PER_BATCH: usize = 1024;

/// Most text that a batch may decode to, bytes.
const TEXT_PER_BATCH_BYTES: i64 = 64 << 20;

/// The column with the episode of a row.
pub(super) const EPISODE_COLUMN: &str = "episode_index";

/// How the columns are encoded before compression: integers, which mostly count up, as differences; text by dictionary,
/// because it repeats; single precision, which is used for poses that change little from row to row, by byte streams.
/// fastparquet cannot read byte streams, but a set of leaves would be 13 % larger without them.
fn encodings(schema: &SchemaRef) -> WriterPropertiesBuilder {
    let mut builder = WriterProperties::builder();
    for field in schema.fields() {
        let (number, path) = match field.data_type() {
            DataType::List(item) | DataType::FixedSizeList(item, _) => {
                let path = vec![field.name().clone(), "list".into(), item.name().clone()];
                (item.data_type(), ColumnPath::new(path))
            }
            plain => (plain, ColumnPath::new(vec![field.name().clone()])),
        };
        builder = match number {
            DataType::Int8 | DataType::Int16 | DataType::Int32 | DataType::Int64 => {
                builder.set_column_encoding(path, Encoding::DELTA_BINARY_PACKED)
            }
            DataType::Float32 => builder.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT),
            DataType::Utf8 => builder.set_column_dictionary_enabled(path, true),
            _ => builder,
        };
    }
    builder
}

/// A Parquet file (zstd) that is being written. It gets its name when it is closed.
pub(super) struct ParquetFile {
    path: PathBuf,
    writer: ArrowWriter<TemporaryFile>,
    /// Whether it will contain its own hash.
    sealed: bool,
}

impl ParquetFile {
    /// Creates a file with key-value metadata. If [`seal::unsealed`] is among them, the file will contain its own hash.
    pub(super) fn create(
        path: &Path,
        schema: SchemaRef,
        key_values: impl IntoIterator<Item = (&'static str, String)>,
    ) -> Result<Self, DiskError> {
        let key_values: Vec<_> = key_values
            .into_iter()
            .map(|(key, value)| KeyValue::new(key.to_string(), value))
            .collect();
        let sealed = key_values.iter().any(|pair| pair.key == seal::SEAL_KEY);
        let properties = encodings(&schema)
            .set_compression(Compression::ZSTD(ZstdLevel::default()))
            // Forces and angles hardly repeat, except for zeros, which zstd compresses well.
            .set_dictionary_enabled(false)
            // The minimum and maximum of a list column do not help a reader, and take time and space. The minimum and
            // maximum of the episode column let a reader skip all row groups except one.
            .set_statistics_enabled(EnabledStatistics::None)
            .set_column_statistics_enabled(ColumnPath::from(EPISODE_COLUMN), EnabledStatistics::Chunk)
            // The caller ends row groups, so that each episode is within one, however long it is.
            .set_max_row_group_row_count(None)
            .set_key_value_metadata(Some(key_values))
            .build();
        let writer = ArrowWriter::try_new(whole_file::begin(path)?, schema, Some(properties))
            .map_err(DiskError::encode(path))?;
        Ok(ParquetFile {
            path: path.to_path_buf(),
            writer,
            sealed,
        })
    }

    /// Appends rows.
    pub(super) fn write(&mut self, batch: &RecordBatch) -> Result<(), DiskError> {
        self.writer.write(batch).map_err(DiskError::encode(&self.path))
    }

    /// Ends the current row group.
    pub(super) fn end_row_group(&mut self) -> Result<(), DiskError> {
        self.writer.flush().map_err(DiskError::encode(&self.path))
    }

    /// Writes the footer and gives the file its name.
    pub(super) fn close(self) -> Result<(), DiskError> {
        let mut temporary = self.writer.into_inner().map_err(DiskError::encode(&self.path))?;
        let file = temporary.as_file_mut();
        column_order::declare_usual(file)
            .and_then(|()| if self.sealed { seal::seal(file) } else { Ok(()) })
            .map_err(DiskError::io(&self.path, "write"))?;
        whole_file::commit(temporary, &self.path)
    }
}

/// Writes a table of one batch.
pub(super) fn write_table(
    path: &Path,
    batch: &RecordBatch,
    key_values: impl IntoIterator<Item = (&'static str, String)>,
) -> Result<(), DiskError> {
    let mut file = ParquetFile::create(path, batch.schema(), key_values)?;
    file.write(batch)?;
    file.close()
}

/// Reads the footer of a Parquet file.
pub(super) fn read_footer(file: &ParquetInput) -> Result<ArrowReaderMetadata, DiskError> {
    let footer = file.decode(|| ArrowReaderMetadata::load(file, ArrowReaderOptions::default()))?;
    file.check_sizes(footer.metadata())?;
    Ok(footer)
}

/// The builder of a reader of a file.
pub(super) type Builder = ParquetRecordBatchReaderBuilder<ParquetInput>;

/// Opens a Parquet file for reading.
pub(super) fn open(path: &Path, options: ArrowReaderOptions) -> Result<(ParquetInput, Builder), DiskError> {
    let file = ParquetInput::open(path)?;
    let builder = file.decode(|| Builder::try_new_with_options(file.clone(), options))?;
    file.check_sizes(builder.metadata())?;
    Ok((file, builder))
}

/// The rows of an open file, batch by batch, up to the first error.
pub(super) struct Batches {
    file: ParquetInput,
    reader: Option<ParquetRecordBatchReader>,
}

impl Batches {
    /// Starts to read.
    pub(super) fn new(file: ParquetInput, builder: Builder) -> Result<Self, DiskError> {
        let groups = builder.metadata().row_groups().iter();
        let texts = groups
            .flat_map(RowGroupMetaData::columns)
            .filter(|column| is_text(column));
        let largest = texts.map(|column| column.uncompressed_size()).max().unwrap_or(0);
        // A dictionary may hold one long text that every row repeats.
        let rows = usize::try_from(TEXT_PER_BATCH_BYTES / largest.max(1)).unwrap_or(1);
        let reader = file.decode(|| builder.with_batch_size(rows.clamp(1, ROWS_PER_BATCH)).build())?;
        Ok(Batches {
            file,
            reader: Some(reader),
        })
    }
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, DiskError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut reader = self.reader.take()?;
        let batch = self.file.decode(|| reader.next().transpose());
        if matches!(batch, Ok(Some(_))) {
            self.reader = Some(reader);
        }
        batch.transpose()
    }
}

/// The value of a metadata key of a Parquet file.
pub(super) fn key_value(path: &Path, builder: &Builder, key: &'static str) -> Result<String, DiskError> {
    let pairs = builder.metadata().file_metadata().key_value_metadata();
    pairs
        .into_iter()
        .flatten()
        .find(|pair| pair.key == key)
        .and_then(|pair| pair.value.clone())
        .ok_or_else(|| {
            let remedy = "give a file written by underbrush; other programs drop its metadata when they rewrite it";
            InputError::new(
                path,
                key,
                "no such key in the Parquet metadata",
                "a file that has it",
                remedy,
            )
            .into()
        })
}
