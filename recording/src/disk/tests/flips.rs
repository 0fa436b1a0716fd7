//! A single flipped bit anywhere in a file, as from a failing disk or a bad copy, is never read without an error.

use std::fs;

use super::dataset::{contents, make};
use super::reach;
use crate::DiskError;
use crate::disk::{Dataset, read_recording, write_recording};

/// Flips bits of `whole` one at a time, spread evenly over its bytes and over the eight positions in a byte.
fn each_flip(whole: &[u8], flips: usize, mut examine: impl FnMut(usize, &[u8])) {
    for flip in 0..flips {
        // In the middle of each of `flips` equal parts, so that header, tables and footer are all covered.
        let place = (2 * flip + 1) * whole.len() / (2 * flips);
        let mut flipped = whole.to_vec();
        flipped[place] ^= 1 << (flip % 8);
        examine(place, &flipped);
    }
}

/// Opens a set and reads all of it, without calling `verify`.
fn read_all(dir: &std::path::Path) -> Result<(), DiskError> {
    let set = Dataset::open(dir)?;
    (0..set.episodes().len()).try_for_each(|index| set.read_reach(index).map(drop))
}

/// Tests that opening and reading a data set detects a flipped bit in any file: at least five bits in every file, more
/// than sixty in all.
#[test]
fn no_flipped_bit_of_a_data_set_is_read() {
    let folder = tempfile::tempdir().unwrap();
    make(folder.path());
    read_all(folder.path()).unwrap();
    let mut flips = 0;
    for (name, whole) in contents(folder.path()) {
        let path = folder.path().join(&name);
        each_flip(&whole, 5, |place, flipped| {
            fs::write(&path, flipped).unwrap();
            assert!(read_all(folder.path()).is_err(), "byte {place} of {}", name.display());
            flips += 1;
        });
        fs::write(&path, whole).unwrap();
    }
    assert!(flips >= 60, "{flips} flips");
    read_all(folder.path()).unwrap();
}

/// Tests that a flipped bit in a recording is detected wherever it is: at 400 places from the first byte to the last,
/// and in every bit of the end of the footer.
#[test]
fn no_flipped_bit_of_a_recording_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reach.parquet");
    write_recording(&path, &reach(0, 60)).unwrap();
    let whole = fs::read(&path).unwrap();
    let refused = |place: usize, flipped: &[u8]| {
        fs::write(&path, flipped).unwrap();
        assert!(read_recording(&path).is_err(), "byte {place} of {}", whole.len());
    };
    each_flip(&whole, 400, refused);
    let end = whole.len() - 20;
    for bit in 0..8 * 20 {
        let mut flipped = whole.clone();
        flipped[end + bit / 8] ^= 1 << (bit % 8);
        refused(end + bit / 8, &flipped);
    }
    fs::write(&path, &whole).unwrap();
    read_recording(&path).unwrap();
}
