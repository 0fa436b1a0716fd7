//! The bytes of one reach as the page reads them: a JSON header, followed by arrays of numbers.
//!
//! ```text
//! 0   8  "ubreplay"
//! 8   4  version of the format
//! 12  4  CRC-32 of all bytes from 16 on
//! 16  4  number of bytes in all
//! 20  4  number of bytes of the header
//! 24     the header: {"reach": …, "sections": [{"name", "type", "offset", "count"}, …]}, padded with spaces
//! …      the sections; each begins at a multiple of 8 bytes, counted from the end of the header
//! ```
//!
//! All numbers are little-endian. The page can take each section as a typed array without copying it.

use serde::Serialize;
use underbrush_recording::SkinLayout;

/// The first bytes.
const MAGIC: &[u8; 8] = b"ubreplay";
/// The version of the format. A page and the program that serves it are built together, so only a single file that was
/// edited by hand can hold another.
const VERSION: u32 = 2;
const HEAD_BYTES: usize = 24;
/// Sections begin at multiples of this, because the page cannot view a typed array at any other place.
const ALIGNMENT: usize = 8;
/// Largest number of bytes: the sizes are stored in 32 bits, and not every browser can hold larger arrays.
pub const MAX_BYTES: usize = 1 << 30;

#[derive(Serialize)]
struct Section {
    name: &'static str,
    #[serde(rename = "type")]
    kind: &'static str,
    offset: usize,
    count: usize,
}

/// Named arrays that follow the header.
#[derive(Default)]
pub struct Sections {
    index: Vec<Section>,
    bytes: Vec<u8>,
}

/// A type of number that a section can hold.
pub trait Number: Copy {
    /// Its name in the header.
    const NAME: &'static str;
    /// Appends its bytes.
    fn append(self, bytes: &mut Vec<u8>);
}

macro_rules! numbers {
    ($($number:ty),*) => {
        $(impl Number for $number {
            const NAME: &'static str = stringify!($number);
            fn append(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        })*
    };
}
numbers!(u8, u16, i16, u32, f32, f64);

impl Sections {
    /// Adds an array.
    pub fn add<T: Number>(&mut self, name: &'static str, numbers: impl IntoIterator<Item = T>) {
        self.bytes.resize(self.bytes.len().next_multiple_of(ALIGNMENT), 0);
        let offset = self.bytes.len();
        numbers.into_iter().for_each(|number| number.append(&mut self.bytes));
        let count = (self.bytes.len() - offset) / size_of::<T>();
        self.index.push(Section { name, kind: T::NAME, offset, count });
    }

    /// Adds an array of numbers that are stored in single precision.
    pub fn add_single(&mut self, name: &'static str, numbers: impl IntoIterator<Item = f64>) {
        self.add(name, numbers.into_iter().map(|number| number as f32));
    }

    /// All bytes, with this description of the reach in the header. `Err` is their number if there are more than
    /// [`MAX_BYTES`].
    pub fn finish(self, reach: &impl Serialize) -> Result<Vec<u8>, usize> {
        #[derive(Serialize)]
        struct Header<'a, T> {
            reach: &'a T,
            sections: &'a [Section],
        }
        // Plain data with text keys can always be written.
        let mut header = serde_json::to_vec(&Header { reach, sections: &self.index }).unwrap_or_default();
        header.resize(header.len().next_multiple_of(ALIGNMENT), b' ');
        let total = HEAD_BYTES + header.len() + self.bytes.len();
        if total > MAX_BYTES {
            return Err(total);
        }
        let [total, header_bytes] = [total, header.len()].map(|size| (size as u32).to_le_bytes());
        let rest = [&total, &header_bytes, header.as_slice(), &self.bytes].concat();
        // It may be large, and the last step copies once more.
        drop(self.bytes);
        let (version, checksum) = (VERSION.to_le_bytes(), crc32fast::hash(&rest).to_le_bytes());
        Ok([MAGIC, version.as_slice(), &checksum, &rest].concat())
    }
}

/// The number of the first taxel of each patch.
pub fn first_taxels(layout: &SkinLayout) -> Vec<u32> {
    let patches = &layout.patches;
    starts(patches.iter().map(|patch| patch.taxels.len())).take(patches.len()).collect()
}

/// The first row of each of some groups of rows, then the number of all rows.
pub fn starts(counts: impl Iterator<Item = usize>) -> impl Iterator<Item = u32> {
    let ends = counts.scan(0, |end, count| {
        *end += count as u32;
        Some(*end)
    });
    std::iter::once(0).chain(ends)
}
