//! Parquet files as this crate writes and reads them.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_schema::{DataType, SchemaRef};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder,
};
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::schema::types::ColumnPath;

use super::input_file::open_input;
use super::whole_file::{self, TemporaryFile};
use super::{DiskError, seal};
use crate::InputError;

/// Rows that are encoded or decoded together: 453 taxels make about 15 MB of dense columns of them.
pub(super) const ROWS_PER_BATCH: usize = 1024;

/// The column that says which episode a row belongs to.
pub(super) const EPISODE_COLUMN: &str = "episode_index";

/// How the columns of a schema are encoded before they are compressed: whole numbers, which are mostly counted up, as
/// differences; text by dictionary, as it repeats; numbers in single precision, which are poses that change little from
/// row to row, byte by byte.
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

/// A Parquet file (zstd) in the making; it appears under its name when closed.
pub(super) struct ParquetFile {
    path: PathBuf,
    writer: ArrowWriter<TemporaryFile>,
    /// Whether it gets a hash of itself.
    sealed: bool,
}

impl ParquetFile {
    /// Opens it with key-value metadata; with [`seal::unsealed`] among them it gets a hash of itself.
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
            // Columns are forces and angles that hardly repeat but for zeros, which zstd takes care of.
            .set_dictionary_enabled(false)
            // Least and largest value of a column of lists help no reader, and take time and room in the footer. Those of
            // the episode let a reader skip all row groups but the one that it wants.
            .set_statistics_enabled(EnabledStatistics::None)
            .set_column_statistics_enabled(ColumnPath::from(EPISODE_COLUMN), EnabledStatistics::Chunk)
            // Row groups end where the caller ends them, so that one holds one episode however long.
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

    /// Ends the row group.
    pub(super) fn end_row_group(&mut self) -> Result<(), DiskError> {
        self.writer.flush().map_err(DiskError::encode(&self.path))
    }

    /// Writes the footer and gives the file its name.
    pub(super) fn close(self) -> Result<(), DiskError> {
        let mut temporary = self.writer.into_inner().map_err(DiskError::encode(&self.path))?;
        if self.sealed {
            seal::seal(temporary.as_file_mut()).map_err(DiskError::io(&self.path, "write"))?;
        }
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

/// The error for bytes that are no whole Parquet file.
pub(super) fn broken(path: &Path, cause: impl ToString) -> DiskError {
    InputError::new(
        path,
        "Parquet",
        cause.to_string(),
        "a whole Parquet file, uncompressed or compressed with zstd or snappy",
        "copy the file again, or write it again with zstd or snappy",
    )
    .into()
}

/// Runs a step of the Parquet decoder. Some damaged files (a negative offset in the footer) make it panic instead of
/// returning an error, and input must never end the program.
fn decode<T, E: ToString>(path: &Path, step: impl FnOnce() -> Result<T, E>) -> Result<T, DiskError> {
    match catch_unwind(AssertUnwindSafe(step)) {
        Ok(result) => result.map_err(|error| broken(path, error)),
        Err(_) => Err(broken(path, "damaged bytes that cannot be decoded")),
    }
}

/// Reads the footer of a Parquet file.
pub(super) fn read_footer(path: &Path, file: &File) -> Result<ArrowReaderMetadata, DiskError> {
    decode(path, || ArrowReaderMetadata::load(file, ArrowReaderOptions::default()))
}

/// Opens a Parquet file for reading.
pub(super) fn open(
    path: &Path,
    options: ArrowReaderOptions,
) -> Result<ParquetRecordBatchReaderBuilder<File>, DiskError> {
    let file = open_input(path)?;
    decode(path, || {
        ParquetRecordBatchReaderBuilder::try_new_with_options(file, options)
    })
}

/// The rows of an opened file, batch by batch, up to the first error.
pub(super) struct Batches {
    path: PathBuf,
    reader: Option<ParquetRecordBatchReader>,
}

impl Batches {
    /// Begins to read.
    pub(super) fn new(path: &Path, builder: ParquetRecordBatchReaderBuilder<File>) -> Result<Self, DiskError> {
        let reader = decode(path, || builder.with_batch_size(ROWS_PER_BATCH).build())?;
        Ok(Batches {
            path: path.to_path_buf(),
            reader: Some(reader),
        })
    }
}

impl Iterator for Batches {
    type Item = Result<RecordBatch, DiskError>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut reader = self.reader.take()?;
        let batch = decode(&self.path, || reader.next().transpose());
        if matches!(batch, Ok(Some(_))) {
            self.reader = Some(reader);
        }
        batch.transpose()
    }
}

/// The value of a metadata key of a Parquet file.
pub(super) fn key_value(
    path: &Path,
    builder: &ParquetRecordBatchReaderBuilder<File>,
    key: &'static str,
) -> Result<String, DiskError> {
    let pairs = builder.metadata().file_metadata().key_value_metadata();
    pairs
        .into_iter()
        .flatten()
        .find(|pair| pair.key == key)
        .and_then(|pair| pair.value.clone())
        .ok_or_else(|| {
            let remedy = "give a file written by underbrush; other programs drop the metadata when they rewrite it";
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
