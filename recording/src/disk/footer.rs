//! What is changed in the footer of a Parquet file after it was written: the order of numbers that it declares, and the
//! checksum inside it.
//!
//! A data set has a list of checksums, but a single file stands alone. Parquet's page checksums do not cover the
//! footer, and the library does not write them. Therefore the key-value metadata contain the BLAKE3 hash of the whole
//! file, computed with zeros in place of its own 64 digits, so that it covers every bit.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::Path;

use super::files::open_input;
use super::{DiskError, Result};
use crate::InputError;

/// Metadata key of the hash.
pub(super) const SEAL_KEY: &str = "underbrush.blake3";
/// Hexadecimal digits of a hash.
const DIGITS: usize = 64;

/// The last field of the footer is a list with an entry of three bytes for each column: the number of the order, and the
/// ends of two structures. A byte that ends the footer follows.
const ENTRY: usize = 3;
const USUAL: [u8; ENTRY] = [0x1c, 0, 0];
const OF_FLOATS: [u8; ENTRY] = [0x2c, 0, 0];
/// The length of the footer and four letters at the end of the file.
const TAIL: usize = 8;

/// The metadata entry of a file that is to be sealed: zeros in place of the hash.
pub(super) fn unsealed() -> (&'static str, String) {
    (SEAL_KEY, "0".repeat(DIGITS))
}

/// The position of the digits: after the last occurrence of the key as Parquet's footer encodes it, followed by one
/// byte each for type and length of the value.
fn place(bytes: &[u8]) -> Option<Range<usize>> {
    let entry = [SEAL_KEY.as_bytes(), &[0x18, DIGITS as u8]].concat();
    let start = bytes.windows(entry.len()).rposition(|window| window == entry)? + entry.len();
    (start + DIGITS <= bytes.len()).then_some(start..start + DIGITS)
}

fn hash(bytes: &[u8], digits: &Range<usize>) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&bytes[..digits.start]);
    hasher.update(&[b'0'; DIGITS]);
    hasher.update(&bytes[digits.end..]);
    hasher.finalize().to_hex().to_string()
}

/// Declares the usual order of numbers in the footer of a whole file, for readers of some years.
///
/// Since version 60 the library declares an order of floating-point columns that Parquet got in 2026, and has no option
/// to leave it out. Older readers, such as polars 1.35, cannot read any file with it. The order matters only for the
/// smallest and largest values in the footer, and the files here have none of floating-point columns.
pub(super) fn declare_usual_order(file: &mut File) -> io::Result<()> {
    let broken = || io::Error::other("the footer is not as the library writes it");
    file.seek(SeekFrom::End(-(TAIL as i64)))?;
    let mut length = [0; 4];
    file.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length) as usize;
    let start = file.seek(SeekFrom::End(-((TAIL + length) as i64)))?;
    let mut footer = vec![0; length];
    file.read_exact(&mut footer)?;
    let (_, orders) = footer.split_last_mut().ok_or_else(broken)?;
    let mut columns = 0;
    for entry in orders.rchunks_exact_mut(ENTRY) {
        if entry == OF_FLOATS {
            entry.copy_from_slice(&USUAL);
        } else if entry != USUAL {
            break;
        }
        columns += 1;
    }
    if columns == 0 {
        return Err(broken());
    }
    file.seek(SeekFrom::Start(start))?;
    file.write_all(&footer)
}

/// Writes the hash into a file that was written with [`unsealed`] among its metadata.
pub(super) fn seal(file: &mut File) -> io::Result<()> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    let digits = place(&bytes).ok_or_else(|| io::Error::other("the footer has no place for the checksum"))?;
    let hash = hash(&bytes, &digits);
    file.seek(SeekFrom::Start(digits.start as u64))?;
    file.write_all(hash.as_bytes())
}

/// Checks the hash inside a file, if there is one. Returns whether there is.
pub(super) fn check_if_sealed(path: &Path) -> Result<bool> {
    let mut bytes = Vec::new();
    open_input(path)?.read_to_end(&mut bytes).map_err(DiskError::io(path, "read"))?;
    let Some(digits) = place(&bytes) else { return Ok(false) };
    let found = hash(&bytes, &digits);
    let stored = &bytes[digits];
    if stored == found.as_bytes() {
        return Ok(true);
    }
    let stored = String::from_utf8_lossy(stored).into_owned();
    let remedy = "copy the file again, or make it again";
    Err(InputError::new(path, "checksum", found, stored, remedy).into())
}

/// Checks the hash inside a file. A file without one is refused.
pub(super) fn check_seal(path: &Path) -> Result<()> {
    if check_if_sealed(path)? {
        return Ok(());
    }
    let remedy = "copy the file again; other programs drop the checksum when they rewrite the file";
    Err(InputError::new(path, SEAL_KEY, "no checksum", "a file with its own checksum", remedy).into())
}
