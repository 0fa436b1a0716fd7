//! Declares the usual order of numbers in the footer of a Parquet file, for readers of some years.
//!
//! Since version 60 the library declares an order of floating-point columns that Parquet got in 2026, and has no option
//! to leave it out. Older readers, such as polars 1.35, cannot read any file with it. The order matters only for the
//! smallest and largest values in the footer, and the files here have none of floating-point columns.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};

/// The last field of the footer is a list with an entry of three bytes for each column: the number of the order, and the
/// ends of two structures. A byte that ends the footer follows.
const ENTRY: usize = 3;
const USUAL: [u8; ENTRY] = [0x1c, 0, 0];
const OF_FLOATS: [u8; ENTRY] = [0x2c, 0, 0];
/// The length of the footer and four letters at the end of the file.
const TAIL: usize = 8;

/// Changes the footer of a whole file.
pub(super) fn declare_usual(file: &mut File) -> io::Result<()> {
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
