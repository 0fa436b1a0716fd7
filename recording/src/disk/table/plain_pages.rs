//! Reads a column of floating-point numbers straight from the pages of a Parquet file.
//!
//! For every number, a list column stores two levels, which say whether the number is there and whether a row begins
//! with it. Decoding them takes several times as long as decompressing the numbers. In the columns that this program
//! writes, every number is there and every row is equally wide, so the levels can be skipped.

use std::sync::Arc;

use parquet::basic::Encoding;
use parquet::column::page::Page;
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, RowGroupMetaData};
use parquet::file::serialized_reader::SerializedPageReader;

use super::Value;
use super::parquet_input::ParquetInput;
use crate::Result;

/// The chunk of a column in a row group, if it has numbers of this type.
fn chunk_of<'a, F: Float>(group: &'a RowGroupMetaData, column: &str) -> Option<&'a ColumnChunkMetaData> {
    let is_it = |chunk: &&ColumnChunkMetaData| chunk.column_path().parts().first().is_some_and(|name| name == column);
    group.columns().iter().find(is_it).filter(|chunk| chunk.column_type() == F::TYPE.parquet().0)
}

/// A floating-point number of a file.
pub(crate) trait Float: Value + Into<f64> + Copy {
    /// The numbers in the bytes of a page; `None` if some bytes are left.
    fn in_bytes(bytes: &[u8]) -> Option<impl ExactSizeIterator<Item = Self>>;
}

macro_rules! float {
    ($number:ty, $bytes:literal) => {
        impl Float for $number {
            fn in_bytes(bytes: &[u8]) -> Option<impl ExactSizeIterator<Item = Self>> {
                let (numbers, rest) = bytes.as_chunks::<$bytes>();
                let numbers = numbers.iter().map(|number| <$number>::from_le_bytes(*number));
                rest.is_empty().then_some(numbers)
            }
        }
    };
}
float!(f32, 4);
float!(f64, 8);

/// The largest number of values of a column of this type, according to its size in the footer; zero for other types.
pub(crate) fn most_numbers<F: Float>(group: &RowGroupMetaData, column: &str) -> usize {
    let bytes = chunk_of::<F>(group, column).map_or(0, |chunk| usize::try_from(chunk.uncompressed_size()).unwrap_or(0));
    bytes / size_of::<F>()
}

/// Writes the numbers of a column in a row group into `to`, in their order. Returns `false` if there are more or fewer
/// numbers than `to` has places, or if they are not stored as plain numbers without nulls. The column reader then has to
/// read them, and the content of `to` is unspecified.
///
/// # Errors
/// [`crate::DiskError::Input`] for damaged files.
pub(crate) fn read<F: Float, N>(
    file: &ParquetInput,
    group: &RowGroupMetaData,
    column: &str,
    convert: impl Fn(F) -> N,
    to: &mut [N],
) -> Result<bool> {
    let (Some(chunk), Ok(rows)) = (chunk_of::<F>(group, column), usize::try_from(group.num_rows())) else {
        return Ok(false);
    };
    file.decode(|| -> Result<bool, ParquetError> {
        let mut left = to;
        for page in SerializedPageReader::new(Arc::new(file.clone()), chunk, rows, None)? {
            let page = page?;
            let Some(numbers) = numbers_of::<F>(&page, chunk) else { return Ok(false) };
            let Some((own, rest)) = left.split_at_mut_checked(numbers.len()) else { return Ok(false) };
            for (place, number) in own.iter_mut().zip(numbers) {
                *place = convert(number);
            }
            left = rest;
        }
        Ok(left.is_empty())
    })
}

/// The numbers of a page; `None` unless it holds plain numbers without nulls.
fn numbers_of<F: Float>(page: &Page, chunk: &ColumnChunkMetaData) -> Option<impl ExactSizeIterator<Item = F>> {
    let Page::DataPage {
        buf,
        num_values,
        encoding: Encoding::PLAIN,
        def_level_encoding: Encoding::RLE,
        rep_level_encoding: Encoding::RLE,
        ..
    } = page
    else {
        return None;
    };
    let column = chunk.column_descr();
    let mut bytes: &[u8] = buf;
    for largest_level in [column.max_rep_level(), column.max_def_level()] {
        if largest_level > 0 {
            let (length, rest) = bytes.split_first_chunk::<4>()?;
            bytes = rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)?;
        }
    }
    // The page's count includes missing numbers, which have no bytes.
    let count = usize::try_from(*num_values).ok()?;
    F::in_bytes(bytes).filter(|numbers| numbers.len() == count)
}
