//! A Parquet file that is being read. It remembers the error of the operating system if reading fails.
//!
//! On some paths the decoder turns such errors into text, or takes the length of the file to be 0. A failing disk would
//! then look like a damaged file, which is bad input that nobody tries to read again.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use bytes::Bytes;
use parquet::basic::Type;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};
use parquet::file::reader::{ChunkReader, Length};

use crate::disk::files::open_input;
use crate::{DiskError, InputError, Result, limits};

/// The file. Clones share it.
#[derive(Clone)]
pub(crate) struct ParquetInput {
    pub(crate) path: PathBuf,
    file: Arc<File>,
    bytes: u64,
    /// The first error of the operating system.
    failed: Arc<OnceLock<io::Error>>,
}

/// Reads the file from some position on.
pub(crate) struct Reader {
    file: File,
    failed: Arc<OnceLock<io::Error>>,
}

/// An error with the same meaning, because errors cannot be cloned.
fn copy(error: &io::Error) -> io::Error {
    error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error)
}

impl ParquetInput {
    /// Opens a file.
    pub(crate) fn open(path: &Path) -> Result<Self> {
        let file = open_input(path)?;
        let bytes = file.metadata().map_err(DiskError::io(path, "read"))?.len();
        Ok(ParquetInput { path: path.to_path_buf(), file: Arc::new(file), bytes, failed: Arc::default() })
    }

    /// Runs a step of the decoder on this file. Some damaged files (with a negative offset in the footer, for example) make the
    /// decoder panic instead of returning an error, and bad input must never end the program.
    pub(crate) fn decode<T, E: ToString>(&self, step: impl FnOnce() -> Result<T, E>) -> Result<T> {
        let result = catch_unwind(AssertUnwindSafe(step));
        if let (false, Some(error)) = (matches!(result, Ok(Ok(_))), self.failed.get()) {
            return Err(DiskError::io(&self.path, "read")(copy(error)));
        }
        match result {
            Ok(result) => result.map_err(|error| broken(&self.path, error)),
            Err(_) => Err(broken(&self.path, "damaged bytes that cannot be decoded")),
        }
    }

    /// Refuses a file of another kind. A file that ends within its first four bytes was cut short.
    pub(crate) fn check_kind(&self) -> Result<()> {
        let start = self.decode(|| self.get_bytes(0, self.bytes.min(4) as usize))?;
        // Encrypted files begin with PARE.
        if [b"PAR1", b"PARE"].iter().any(|letters| letters.starts_with(&start)) {
            return Ok(());
        }
        let allowed = "a Parquet file, such as a recording or a table of trials";
        let remedy = "check the path; copy the file again if it was one";
        Err(InputError::new(&self.path, "file", "bytes that are not Parquet", allowed, remedy).into())
    }

    /// Checks what the footer says about the size of the content, before anything is decoded.
    pub(crate) fn check_sizes(&self, footer: &ParquetMetaData) -> Result<()> {
        let size = |number: i64| u64::try_from(number).unwrap_or(u64::MAX);
        let groups = footer.row_groups();
        let rows = groups.iter().map(|group| size(group.num_rows()));
        let rows = rows.fold(0, u64::saturating_add).max(size(footer.file_metadata().num_rows()));
        limits::TABLE_ROWS.check(&self.path, "rows", rows)?;
        if rows > limits::ROWS_OF_ANY_FILE {
            limits::ROWS_PER_BYTE.check(&self.path, "rows", rows.div_ceil(self.bytes.max(1)))?;
        }
        for group in groups {
            let mut bytes: u64 = 0;
            for column in group.columns() {
                let own = size(column.uncompressed_size());
                if is_text(column) {
                    let name = column.column_path().string();
                    limits::TEXT_COLUMN_BYTES.check(&self.path, &name, own)?;
                }
                // Doubles are the widest numbers; repeated ones take less in the file.
                bytes = bytes.saturating_add(own.max(size(column.num_values()).saturating_mul(8)));
            }
            if bytes > limits::EXPANDED_BYTES {
                limits::EXPANSION.check(&self.path, "row group", bytes.div_ceil(self.bytes.max(1)))?;
            }
        }
        Ok(())
    }

    fn reader(&self, start: u64) -> io::Result<Reader> {
        let positioned = self.file.try_clone().and_then(|mut file| file.seek(SeekFrom::Start(start)).map(|_| file));
        let file = positioned.map_err(|error| remembered(&self.failed, error))?;
        Ok(Reader { file, failed: Arc::clone(&self.failed) })
    }
}

/// Whether a column holds text.
pub(crate) fn is_text(column: &ColumnChunkMetaData) -> bool {
    matches!(column.column_type(), Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY)
}

/// Stores the first error.
fn remembered(failed: &OnceLock<io::Error>, error: io::Error) -> io::Error {
    // An interrupted call is repeated by the caller.
    if error.kind() != io::ErrorKind::Interrupted {
        failed.get_or_init(|| copy(&error));
    }
    error
}

impl Read for Reader {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        self.file.read(to).map_err(|error| remembered(&self.failed, error))
    }
}

impl Length for ParquetInput {
    fn len(&self) -> u64 {
        self.bytes
    }
}

impl ChunkReader for ParquetInput {
    type T = BufReader<Reader>;

    fn get_read(&self, start: u64) -> Result<Self::T, ParquetError> {
        Ok(BufReader::new(self.reader(start)?))
    }

    fn get_bytes(&self, start: u64, length: usize) -> Result<Bytes, ParquetError> {
        // A damaged footer may ask for more bytes than there is memory.
        if start.saturating_add(length as u64) > self.bytes {
            let found = format!("{length} bytes at {start} of a file of {} bytes", self.bytes);
            return Err(ParquetError::EOF(found));
        }
        let mut bytes = vec![0; length];
        self.reader(start)?.read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}

/// The error for a file that is not a complete Parquet file.
pub(crate) fn broken(path: &Path, cause: impl ToString) -> DiskError {
    let allowed = "a complete Parquet file, uncompressed or compressed with zstd or snappy";
    let remedy = "copy the file again, or write it again with zstd or snappy";
    InputError::new(path, "Parquet", cause.to_string(), allowed, remedy).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a step that fails after an error of the operating system returns that error, whatever the decoder
    /// says, and that a step that fails without such an error reports a damaged file.
    #[test]
    fn a_failing_disk_is_no_damaged_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file.parquet");
        std::fs::write(&path, b"12345678").unwrap();
        let input = ParquetInput::open(&path).unwrap();
        let damaged = input.decode(|| Err::<(), _>("no footer"));
        assert!(matches!(damaged, Err(DiskError::Input(_))));
        // A file that is open for writing only cannot be read: the kernel says EBADF.
        let unreadable = ParquetInput { file: Arc::new(File::options().write(true).open(&path).unwrap()), ..input };
        let failed = unreadable.decode(|| unreadable.get_bytes(0, 8).map_err(|_| "words of the decoder"));
        let Err(DiskError::Io { path: named, source, .. }) = failed else {
            panic!("{failed:?}");
        };
        assert_eq!((named, source.raw_os_error()), (path, Some(9)));
    }
}
