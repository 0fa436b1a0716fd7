//! The data dictionary: every table of a data set with its columns, their units and codes.
//!
//! One list serves three readers: the metadata of the Parquet files, the data set's card and `docs/data.md`.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use arrow_schema::{Field, FieldRef, Schema, SchemaRef};

use crate::Category;

/// One column of a table, or several whose names differ in `x`, `y`, `z` or in a patch's name.
pub(super) struct Column {
    /// Name; ends in `PATCH` where every patch has such a column, and has `{xyz}` or `{xyzw}` where every axis has one.
    pub(super) name: &'static str,
    /// Type and width, as a reader sees it.
    pub(super) kind: &'static str,
    /// Unit, or nothing.
    pub(super) unit: &'static str,
    /// What it holds.
    pub(super) what: &'static str,
}

/// One table of a data set.
pub(super) struct Table {
    /// Name in the card, for `datasets.load_dataset(FOLDER, NAME)`.
    pub(super) name: &'static str,
    /// Folder or file, relative to the data set.
    pub(super) path: &'static str,
    /// What a row is.
    pub(super) row: &'static str,
    /// Its columns.
    pub(super) columns: &'static [Column],
}

const fn column(name: &'static str, kind: &'static str, unit: &'static str, what: &'static str) -> Column {
    Column { name, kind, unit, what }
}

const EPISODE: Column = column("episode_index", "int64", "", "the reach, from 0");
const FRAME: Column = column("frame_index", "int64", "", "the frame in its reach, from 0");
const PATCH: Column = column("patch", "text", "", "name of the patch of skin");
const TAXEL: Column = column("taxel", "int32", "", "index of the taxel in its patch");
const OBJECT: Column = column("object_index", "int32", "", "the object, a row of `truth/objects`");

/// The frames.
pub(super) const FRAMES: Table = Table {
    name: "frames",
    path: "data",
    row: "a frame; J joints, n taxels in each patch",
    columns: &[
        column("timestamp", "float32", "s", "frame_index / rate, as LeRobot defines it"),
        FRAME,
        EPISODE,
        column("index", "int64", "", "the frame in the whole set, from 0"),
        column("task_index", "int64", "", "the task, a row of `meta/tasks.parquet`"),
        column("time_s", "float64", "s", "time since the start of the reach"),
        column("observation.state", "float64 × J", "rad", "joint angles"),
        column("observation.velocity", "float64 × J", "rad/s", "joint velocities"),
        column(
            "observation.torque",
            "float64 × J",
            "N m",
            "joint torques of springs and dampers, without gravity",
        ),
        column(
            "action",
            "float64 × J",
            "rad",
            "equilibrium angles of the joints' springs",
        ),
        column(
            "observation.tip_pose",
            "float64 × 7",
            "m, 1",
            "pose of the tip in the world frame: x y z, quaternion x y z w",
        ),
        column(
            "goal_position",
            "float64 × 3",
            "m",
            "the goal of the moment, world frame",
        ),
        column("goal_index", "int32", "", "its number in the reach, from 0"),
        column(
            "observation.patch_pose.PATCH",
            "float64 × 7",
            "m, 1",
            "pose of the link under the patch in the world frame: x y z, quaternion x y z w",
        ),
        column(
            "observation.tactile.PATCH",
            "float64 × n",
            "N",
            "normal force that each taxel reports, by taxel index",
        ),
    ],
};

/// What the file of a single recording holds beside the columns of [`FRAMES`].
pub(super) const RECORDING_TRUTH: Table = Table {
    name: "recording",
    path: "the file of a single recording",
    row: "a frame, as in `data`; these columns follow",
    columns: &[
        column(
            "truth.normal_force.PATCH",
            "float64 × n",
            "N",
            "true normal force on each taxel, before the sensor",
        ),
        column(
            "truth.shear_force.PATCH",
            "float64 × 2n",
            "N",
            "true shear force along tangent and normal × tangent, taxel by taxel",
        ),
        column(
            "truth.object.PATCH",
            "int16 × n",
            "",
            "the object on each taxel, by number; −1 for none",
        ),
        column("truth.category.PATCH", "int8 × n", "", "category of that object"),
        column(
            "truth.contact_force.PATCH",
            "float64 × 3",
            "N",
            "sum of the solver's contact forces on the patch, world frame",
        ),
        column(
            "truth.moved_body",
            "list of int32",
            "",
            "the bodies that are not where they were in the frame before",
        ),
        column(
            "truth.moved_pose",
            "list of float32",
            "m, 1",
            "where they are, seven numbers each: x y z and quaternion x y z w, world frame, in steps of 1/8192",
        ),
    ],
};

/// Per-taxel ground truth.
pub(super) const TRUTH_TAXELS: Table = Table {
    name: "truth_taxels",
    path: "truth/taxels",
    row: "a taxel that is truly touched, in a frame; taxels that are not touched have no row",
    columns: &[
        EPISODE,
        FRAME,
        PATCH,
        TAXEL,
        column(
            "normal_force_n",
            "float64",
            "N",
            "true force along the inward normal, before the sensor",
        ),
        column(
            "shear_force_tangent_n",
            "float64",
            "N",
            "true force along the taxel's tangent",
        ),
        column(
            "shear_force_binormal_n",
            "float64",
            "N",
            "true force along normal × tangent",
        ),
        column(
            "object_index",
            "int32",
            "",
            "the object that presses most, a row of `truth/objects`; −1 for none",
        ),
        column("category_code", "int8", "", "category of that object"),
    ],
};

/// Per-patch ground truth.
pub(super) const TRUTH_PATCHES: Table = Table {
    name: "truth_patches",
    path: "truth/patches",
    row: "a patch that is truly touched, in a frame",
    columns: &[
        EPISODE,
        FRAME,
        PATCH,
        column(
            "contact_force_world_{xyz}_n",
            "float64",
            "N",
            "sum of the solver's contact forces on the patch, world frame",
        ),
    ],
};

/// Bodies and their shapes.
pub(super) const TRUTH_BODIES: Table = Table {
    name: "truth_bodies",
    path: "truth/bodies",
    row: "a collision shape of a rigid body (a link, or a part of an object that moves as one piece)",
    columns: &[
        EPISODE,
        column(
            "body_index",
            "int32",
            "",
            "the body in its reach, from 0: links from the base on, then objects",
        ),
        column("link", "text", "", "name of the link; null for a body of an object"),
        column(
            "object_index",
            "int32",
            "",
            "the object, a row of `truth/objects`; null for a link",
        ),
        column("category", "text", "", "category of the object; null for a link"),
        column(
            "shape",
            "text",
            "",
            "`sphere`, `cylinder`, `capsule`, `box` or `hull`; null for a body without a shape",
        ),
        column("size_{xyz}_m", "float64", "m", "full edge lengths of a box; else null"),
        column(
            "radius_m",
            "float64",
            "m",
            "radius of a sphere, cylinder or capsule; else null",
        ),
        column(
            "length_m",
            "float64",
            "m",
            "length along z of a cylinder, or of a capsule without its round ends; else null",
        ),
        column(
            "points_m",
            "list of float64",
            "m",
            "corners of a convex hull, x y z after each other; else null",
        ),
        column(
            "position_body_{xyz}_m",
            "float64",
            "m",
            "centre of the shape in the body's frame",
        ),
        column(
            "orientation_body_{xyzw}",
            "float64",
            "1",
            "rotation from the shape's to the body's frame, quaternion",
        ),
        column(
            "rest_position_world_{xyz}_m",
            "float64",
            "m",
            "origin of the body before the reach begins, world frame",
        ),
        column(
            "rest_orientation_world_{xyzw}",
            "float64",
            "1",
            "its rotation to the world frame then, quaternion",
        ),
    ],
};

/// Poses over time.
pub(super) const TRUTH_POSES: Table = Table {
    name: "truth_poses",
    path: "truth/poses",
    row: "a body in a frame in which its pose differs from that of the frame before; it stays there until its next row, \
          and before its first row it stands as `truth/bodies` says",
    columns: &[
        EPISODE,
        column("body_index", "int32", "", "the body, as in `truth/bodies`"),
        FRAME,
        column(
            "position_world_{xyz}_m",
            "float32",
            "m",
            "origin of the body, world frame, in steps of 1/8192 m (0.12 mm)",
        ),
        column(
            "orientation_world_{xyzw}",
            "float32",
            "1",
            "rotation from the body's to the world frame, quaternion, in steps of 1/8192; normalize it before use",
        ),
    ],
};

/// Objects.
pub(super) const TRUTH_OBJECTS: Table = Table {
    name: "truth_objects",
    path: "truth/objects",
    row: "an object of the clutter of a reach",
    columns: &[
        EPISODE,
        column("object_index", "int32", "", "the object in its reach, from 0"),
        column("kind", "text", "", "its kind in the scene file"),
        column("category", "text", "", "`leaf`, `trunk`, `block` or `outlier`"),
        column("position_world_{xyz}_m", "float64", "m", "its foot, world frame"),
        column(
            "parameters",
            "text",
            "",
            "its drawn parameters as a JSON object, with SI units in the names",
        ),
    ],
};

/// Goals.
pub(super) const TRUTH_GOALS: Table = Table {
    name: "truth_goals",
    path: "truth/goals",
    row: "a goal of a reach",
    columns: &[
        EPISODE,
        column("goal_index", "int32", "", "the goal in its reach, from 0"),
        column("position_world_{xyz}_m", "float64", "m", "the goal, world frame"),
        column("start_time_s", "float64", "s", "when the arm set out for it"),
        column("end_time_s", "float64", "s", "when it was reached or given up"),
        column("outcome", "text", "", "`reached`, `stuck`, `timed_out` or `aborted`"),
        column(
            "stop_object_index",
            "int32",
            "",
            "the object whose force ended it, a row of `truth/objects`; else null",
        ),
        column(
            "stop_link",
            "text",
            "",
            "the link on which that object pressed; else null",
        ),
        column(
            "stop_patch",
            "text",
            "",
            "the patch on which most of the force fell; null without skin there",
        ),
        column(
            "stop_force_n",
            "float64",
            "N",
            "that force; null where no force ended the goal",
        ),
    ],
};

/// Contacts.
pub(super) const TRUTH_CONTACTS: Table = Table {
    name: "truth_contacts",
    path: "truth/contacts",
    row: "a contact between a patch or a bare link and an object, from its first frame to its last",
    columns: &[
        EPISODE,
        column("link", "text", "", "name of the link"),
        column(
            "patch",
            "text",
            "",
            "name of the patch; null for a part of the link without skin",
        ),
        OBJECT,
        column("category", "text", "", "category of the object"),
        column("first_frame", "int64", "", "first frame in contact"),
        column("last_frame", "int64", "", "last frame in contact"),
        column("peak_force_n", "float64", "N", "largest contact force of a frame"),
        column(
            "mean_force_n",
            "float64",
            "N",
            "mean of the contact force over the frames",
        ),
    ],
};

/// Taxels.
pub(super) const TAXELS: Table = Table {
    name: "taxels",
    path: "meta/taxels.parquet",
    row: "a taxel",
    columns: &[
        PATCH,
        TAXEL,
        column("row", "int32", "", "row in the patch's grid; null without a grid"),
        column("column", "int32", "", "column in the patch's grid; null without a grid"),
        column("link", "text", "", "the link that carries it"),
        column("position_link_{xyz}_m", "float64", "m", "its centre, link frame"),
        column(
            "normal_link_{xyz}",
            "float64",
            "1",
            "its outward unit normal, link frame",
        ),
        column(
            "tangent_link_{xyz}",
            "float64",
            "1",
            "its first tangent, link frame; the second is normal × tangent",
        ),
        column("area_m2", "float64", "m²", "its sensitive area"),
    ],
};

/// All tables whose columns are listed; LeRobot's own tables in `meta/` are not among them.
pub(super) const TABLES: [&Table; 9] = [
    &FRAMES,
    &TRUTH_TAXELS,
    &TRUTH_PATCHES,
    &TRUTH_OBJECTS,
    &TRUTH_CONTACTS,
    &TRUTH_GOALS,
    &TRUTH_BODIES,
    &TRUTH_POSES,
    &TAXELS,
];

/// Key of the metadata that hold the names of a column's codes.
const CODES: &str = "codes";

/// The codes of the built-in categories and of `further` ones with their names; −1 is none.
pub(super) fn category_codes(further: &[Category]) -> BTreeMap<i8, String> {
    let categories = Category::BUILT_IN.iter().chain(further);
    let codes = categories.map(|category| (category.code(), category.name().to_owned()));
    codes.chain([(-1, "none".to_owned())]).collect()
}

/// The names of a column's codes as a JSON object.
fn codes_json(further: &[Category]) -> String {
    let codes = category_codes(further);
    let codes: Vec<_> = codes
        .iter()
        .map(|(code, name)| format!("\"{code}\": \"{name}\""))
        .collect();
    format!("{{{}}}", codes.join(", "))
}

/// A schema whose columns of category codes name `further` categories too.
pub(super) fn with_further_categories(schema: SchemaRef, further: &[Category]) -> SchemaRef {
    if further.is_empty() {
        return schema;
    }
    let field = |field: &FieldRef| {
        let mut metadata = field.metadata().clone();
        if metadata.contains_key(CODES) {
            metadata.insert(CODES.to_string(), codes_json(further));
        }
        field.as_ref().clone().with_metadata(metadata)
    };
    let fields: Vec<Field> = schema.fields().iter().map(field).collect();
    Arc::new(Schema::new_with_metadata(fields, schema.metadata().clone()))
}

/// A table with its columns in Markdown.
pub(super) fn describe(table: &Table) -> String {
    let Table {
        name,
        path,
        row,
        columns,
    } = table;
    let mut text =
        format!("\n## {name} (`{path}`)\n\nOne row is {row}.\n\n| column | type | unit | what |\n|---|---|---|---|\n");
    for Column { name, kind, unit, what } in *columns {
        text += &format!("| `{name}` | {kind} | {unit} | {what} |\n");
    }
    text
}

impl Column {
    /// Whether the entry describes a column of a file.
    pub(super) fn covers(&self, name: &str) -> bool {
        if let Some(prefix) = self.name.strip_suffix("PATCH") {
            return name.starts_with(prefix);
        }
        for axes in ["{xyz}", "{xyzw}"] {
            if let Some((before, after)) = self.name.split_once(axes) {
                let axis = name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
                return axis.is_some_and(|axis| axis.len() == 1 && axes.contains(axis));
            }
        }
        self.name == name
    }
}

impl Table {
    /// What is known of a column, as metadata of its field: `description`, and where there are any, `unit` and `codes`
    /// (a JSON object); `None` for a column that the table does not have.
    pub(super) fn metadata(&self, name: &str) -> Option<HashMap<String, String>> {
        let column = self.columns.iter().find(|column| column.covers(name))?;
        let mut metadata = HashMap::from([("description".to_string(), column.what.to_string())]);
        if !column.unit.is_empty() {
            metadata.insert("unit".to_string(), column.unit.to_string());
        }
        if column.what.contains("category") && column.kind.starts_with("int8") {
            metadata.insert(CODES.to_string(), codes_json(&[]));
        }
        Some(metadata)
    }
}
