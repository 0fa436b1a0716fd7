//! HDF5 files.

use std::path::Path;

use hdf5_pure::{Datatype, DatatypeByteOrder, File, FloatingPointLayout, make_f64_type};
use underbrush_recording::Trial;

use super::{by_taxel, damage, expected, imported, refused};
use crate::example::{file, reach};
use crate::{ExchangeError, write_hdf5};

/// Tests that reaches written as HDF5 come back as trials with the same forces, one reach for each demonstration in the
/// order of their numbers, and with the categories of an attribute.
#[test]
fn trials_come_back_from_hdf5() {
    let (_folder, path) = file("reaches.h5");
    let reaches: Vec<_> = (0..12).map(|index| reach(&format!("scene {index}"), index, 1100)).collect();
    write_hdf5::<ExchangeError>(&path, |writer| reaches.iter().try_for_each(|reach| writer.push(reach))).unwrap();
    let mapping =
        "[time]\nrate_hz = 100\n[force]\nfrom = \"data/*/obs/tactile_sleeve\"\n[trial]\ncategory_from = \"scene\"\n";
    let found = imported(&path, mapping).unwrap();
    assert_eq!((found.reaches, found.frames), (12, 13_200));
    for (index, recording) in reaches.iter().enumerate() {
        let of_reach: Vec<Trial> =
            found.trials.iter().filter(|trial| trial.reach == Some(index as u64)).cloned().collect();
        assert!(of_reach.iter().all(|trial| trial.category.as_deref() == Some(recording.scene.as_str())));
        assert!(of_reach.len() > 10, "{} trials", of_reach.len());
        assert_eq!(by_taxel(&of_reach), expected(recording, 0, 0.03), "reach {index}");
    }
    let one = "[time]\nrate_hz = 100\n[force]\nfrom = \"data/demo_3/obs/tactile_tip\"\n";
    assert_eq!(by_taxel(&imported(&path, one).unwrap().trials), expected(&reaches[3], 1, 0.03));
}

/// Writes 50 frames of two taxels as `forces`, and their times as `t`, each with this type and these bytes for a 1.
fn hdf5_of(path: &Path, forces: (Datatype, &[u8]), times: (Datatype, &[u8])) {
    let file = File::create(path).unwrap();
    let tables = [("forces", forces, vec![50u64, 2]), ("t", times, vec![50])];
    for (name, (datatype, one), shape) in tables {
        let count: u64 = shape.iter().product();
        let dataset = file.root().create_dataset(name, |dataset| {
            dataset.with_raw_data(datatype, one.repeat(count as usize), count).with_shape(&shape);
        });
        dataset.unwrap();
    }
    file.commit().unwrap();
    file.close().unwrap();
}

/// Tests that forces and times of a type that the reader of HDF5 cannot convert are refused. They used to be taken for
/// no frames, and for times that follow from a rate of 1 Hz.
#[test]
fn half_precision_in_hdf5_is_refused() {
    let (_folder, path) = file("log.h5");
    let half = || {
        let layout = FloatingPointLayout {
            bit_offset: 0,
            bit_precision: 16,
            exponent_location: 10,
            exponent_size: 5,
            mantissa_location: 0,
            mantissa_size: 10,
            exponent_bias: 15,
        };
        let datatype = Datatype::FloatingPoint { size: 2, byte_order: DatatypeByteOrder::LittleEndian, layout };
        let one: &[u8] = &[0x00, 0x3c];
        (datatype, one)
    };
    let one = 1f64.to_le_bytes();
    let double = || (make_f64_type(), &one[..]);
    let times = "[time]\nfrom = \"t\"\n[force]\nfrom = \"forces\"\n";
    let rate = "[time]\nrate_hz = 100\n[force]\nfrom = \"forces\"\n";
    hdf5_of(&path, half(), double());
    for mapping in [times, rate] {
        let error = refused(&path, mapping);
        assert_eq!((error.line, error.field.as_str()), (Some(4), "force.from"), "{error}");
        assert!(error.found.contains("unsupported type"), "{error}");
    }
    hdf5_of(&path, double(), half());
    let error = refused(&path, times);
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.from"), "{error}");
    assert!(error.allowed.contains("float64"), "{error}");
    assert_eq!(imported(&path, rate).unwrap().frames, 50);
}

/// Tests that an error about a row of an HDF5 file names the group of its reach.
#[test]
fn an_error_in_hdf5_names_the_reach() {
    let (_folder, path) = file("reaches.h5");
    let mut reaches = [reach("leaf", 0, 60), reach("leaf", 1, 60)];
    let reading = reaches[1]
        .frames
        .iter_mut()
        .flat_map(|frame| &mut frame.taxels)
        .find(|reading| reading.patch == 0 && reading.taxel == 4);
    reading.unwrap().sensed_force_n = -5.0;
    write_hdf5::<ExchangeError>(&path, |writer| reaches.iter().try_for_each(|reach| writer.push(reach))).unwrap();
    let error = refused(&path, "[time]\nrate_hz = 100\n[force]\nfrom = \"data/*/obs/tactile_sleeve\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(1), "data/demo_1, force of taxel 4"));
}

/// Tests that the error about something missing in an HDF5 file gives the line of the mapping, and that damaged files do
/// not end the program.
#[test]
fn what_is_missing_or_damaged_is_named() {
    let (_folder, path) = file("reaches.h5");
    write_hdf5::<ExchangeError>(&path, |writer| writer.push(&reach("leaf", 0, 60))).unwrap();
    let mapping = |from: &str| format!("[time]\nrate_hz = 100\n[force]\nfrom = \"{from}\"\n");
    for (from, found) in [
        ("data/*/obs/skin", "\"data/demo_0/obs/skin\", which is no dataset"),
        ("reaches/*/skin", "no group \"reaches\""),
        ("data/demo_0/obs", "no dataset"),
    ] {
        let error = refused(&path, &mapping(from));
        assert_eq!((error.line, error.field.as_str()), (Some(4), "force.from"), "{error}");
        assert!(error.found.contains(found), "{error}");
    }
    let error = refused(&path, "[time]\nfrom = \"data/*/obs/eef_pos\"\n[force]\nfrom = \"data/*/obs/tactile_tip\"\n");
    assert_eq!((error.line, error.field.as_str()), (Some(2), "time.from"));
    let category = format!("{}[trial]\ncategory_from = \"label\"\n", mapping("data/*/obs/tactile_tip"));
    let error = refused(&path, &category);
    assert_eq!((error.line, error.field.as_str()), (Some(6), "trial.category_from"));
    assert!(error.allowed.contains("outcome"), "{error}");
    damage(&path, &mapping("data/*/obs/tactile_tip"));
}

/// Tests that an HDF5 file of 1.4 kB that declares 2^40 frames is refused, with the limit, before any is read.
#[test]
fn declared_frames_that_the_file_cannot_hold_are_refused() {
    let (_folder, path) = file("log.h5");
    std::fs::write(&path, include_bytes!("declared-frames.h5")).unwrap();
    let error = refused(&path, "[time]\nrate_hz = 100\n[force]\nfrom = \"force\"\n");
    assert_eq!(error.field, "force");
    assert!(error.allowed.starts_with("at most 1100 bytes for each byte of the file"), "{error}");
}
