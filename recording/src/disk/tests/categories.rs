//! Data sets and recordings with categories that are not built in.

use super::dataset::{make, plan, recordings};
use super::dictionary::columns;
use crate::disk::{Dataset, DatasetPlan, DatasetWriter, read_recording, write_recording};
use crate::{Category, DiskError, Recording};

const REED: Category = Category::new("reed", 4).unwrap();

/// The recordings of the test set, in which every trunk is a reed.
fn with_reeds() -> Vec<Recording> {
    let mut recordings = recordings();
    let objects = recordings.iter_mut().flat_map(|recording| &mut recording.objects);
    for object in objects.filter(|object| object.category == Category::TRUNK) {
        object.category = REED;
    }
    recordings
}

fn plan_with(categories: &[Category]) -> DatasetPlan {
    DatasetPlan { categories: categories.to_vec(), ..plan() }
}

/// Tests that a set with a further category is read back as it was, by a reader that knows the category from the set
/// alone, and that the lists of codes name its code.
#[test]
fn a_further_category_is_written_and_read() {
    let folder = tempfile::tempdir().unwrap();
    let writer = DatasetWriter::create(folder.path(), plan_with(&[REED]), false).unwrap();
    for (position, recording) in with_reeds().iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    writer.finish().unwrap();
    let set = Dataset::open(folder.path()).unwrap();
    assert_eq!(set.plan(), &plan_with(&[REED]));
    for (index, expected) in with_reeds().iter().enumerate() {
        assert_eq!(&set.read_reach(index).unwrap(), expected);
    }
    let columns = columns(&folder.path().join("truth/taxels/chunk-000/file-000.parquet"));
    let (_, about) = columns.iter().find(|(name, _)| name == "category_code").unwrap();
    assert_eq!(about["codes"]["4"], "reed");
    let card = std::fs::read_to_string(folder.path().join("README.md")).unwrap();
    assert!(card.contains("3 outlier, 4 reed."), "{card}");
}

/// Tests that a set of built-in categories names no others, and neither does its plan.
#[test]
fn without_further_categories_nothing_is_written_of_them() {
    let folder = tempfile::tempdir().unwrap();
    assert!(make(folder.path()).plan().categories.is_empty());
    let provenance = std::fs::read_to_string(folder.path().join("meta/provenance.json")).unwrap();
    assert!(!provenance.contains("categories"), "{provenance}");
}

/// Tests that the file of a single recording carries a further category with its code.
#[test]
fn a_recording_carries_a_further_category() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reach.parquet");
    let recording = &with_reeds()[0];
    assert_eq!(recording.further_categories(), [REED]);
    write_recording(&path, recording).unwrap();
    assert_eq!(&read_recording(&path).unwrap(), recording);
    let columns = columns(&path);
    let mut codes = columns.iter().filter(|(name, _)| name.starts_with("truth.category."));
    assert!(codes.all(|(_, about)| about["codes"]["4"] == "reed"));
}

/// Tests that a category that the plan does not name is refused before anything is written, with its name and code.
#[test]
fn an_unplanned_category_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let writer = DatasetWriter::create(folder.path(), plan(), false).unwrap();
    let error = writer.stage(0, &with_reeds()[0]).unwrap_err();
    assert!(matches!(error, DiskError::Unwritable { .. }), "{error:?}");
    let text = error.to_string();
    assert!(text.contains("categories") && text.contains("reed with code 4"), "{text}");
}

/// Tests that two categories of one name or of one code are refused, in a plan and in a recording.
#[test]
fn categories_that_clash_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let same_name = Category::new("reed", 5).unwrap();
    let same_code = Category::new("cane", 4).unwrap();
    for other in [same_name, same_code, Category::LEAF] {
        let error = DatasetWriter::create(folder.path().join("set"), plan_with(&[REED, other]), false).unwrap_err();
        assert!(matches!(error, DiskError::Unwritable { .. }), "{error:?}");
    }
    let mut recording = with_reeds().remove(0);
    for object in recording.objects.iter_mut().filter(|object| object.category != REED) {
        object.category = same_code;
    }
    let error = write_recording(&folder.path().join("reach.parquet"), &recording).unwrap_err();
    assert!(error.to_string().contains("\"cane\" with code 4") || error.to_string().contains("\"reed\" with code 4"));
}
