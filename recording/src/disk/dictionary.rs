//! The data dictionary: every table of a data set with its columns, their units and codes.
//!
//! The metadata of the Parquet files, the card of a data set and `docs/data.md` are made from this list.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use arrow_schema::{Field, FieldRef, Schema, SchemaRef};

use crate::Category;

/// One column of a table, or several whose names differ only in `x`, `y`, `z` or in the name of a patch.
pub(super) struct Column {
    /// Name. `PATCH` at its end stands for the name of each patch, `{xyz}` or `{xyzw}` for each axis.
    pub(super) name: &'static str,
    /// Type and width, as a reader of the file sees them.
    pub(super) kind: &'static str,
    /// Unit, or empty.
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

/// The columns of a table, one a line: shared ones by name, then name, type, unit and description of the others.
macro_rules! columns {
    ([$($shared:ident),*] $($name:literal, $kind:literal, $unit:literal, $what:literal;)*) => {
        &[$($shared,)* $(column($name, $kind, $unit, $what),)*]
    };
}

const EPISODE: Column = column("episode_index", "int64", "", "index of the reach, from 0");
const FRAME: Column = column("frame_index", "int64", "", "index of the frame in its reach, from 0");
const PATCH: Column = column("patch", "text", "", "name of the patch of skin");
const TAXEL: Column = column("taxel", "int32", "", "index of the taxel in its patch");

/// The frames.
pub(super) const FRAMES: Table = Table {
    name: "frames",
    path: "data",
    row: "a frame; J joints, n taxels in each patch",
    columns: columns! { []
        "timestamp", "float32", "s", "frame_index / rate, as LeRobot defines it";
        "frame_index", "int64", "", "index of the frame in its reach, from 0";
        "episode_index", "int64", "", "index of the reach, from 0";
        "index", "int64", "", "index of the frame in the whole set, from 0";
        "task_index", "int64", "", "index of the task, a row of `meta/tasks.parquet`";
        "time_s", "float64", "s", "time since the start of the reach";
        "observation.state", "float64 × J", "rad", "joint angles";
        "observation.velocity", "float64 × J", "rad/s", "joint velocities";
        "observation.torque", "float64 × J", "N m", "joint torques of springs and dampers, without gravity";
        "action", "float64 × J", "rad", "equilibrium angles of the joint springs";
        "observation.tip_pose", "float64 × 7", "m, 1", "pose of the end effector in the world frame: \
            x y z, quaternion x y z w";
        "goal_position", "float64 × 3", "m", "current goal of the end effector, world frame";
        "goal_index", "int32", "", "index of the current goal in the reach, from 0";
        "observation.patch_pose.PATCH", "float64 × 7", "m, 1", "pose of the link under the patch in the world frame: \
            x y z, quaternion x y z w";
        "observation.tactile.PATCH", "float64 × n", "N", "normal force that each taxel reports, by taxel index";
    },
};

/// The columns that a single recording has in addition to those of [`FRAMES`].
pub(super) const RECORDING_TRUTH: Table = Table {
    name: "recording",
    path: "the file of a single recording",
    row: "a frame; the columns of `data` come first, then these",
    columns: columns! { []
        "truth.normal_force.PATCH", "float64 × n", "N", "true normal force on each taxel, before the sensor";
        "truth.shear_force.PATCH", "float64 × 2n", "N", "true shear force along tangent and normal × tangent, taxel by \
            taxel";
        "truth.object.PATCH", "int16 × n", "", "index of the object that presses each taxel; −1 for none";
        "truth.category.PATCH", "int8 × n", "", "category of that object";
        "truth.contact_force.PATCH", "float64 × 3", "N", "sum of the solver's contact forces on the patch, world frame";
        "truth.moved_body", "list of int32", "", "indices of the bodies whose pose differs from the previous frame";
        "truth.moved_pose", "list of float32", "m, 1", "their poses, seven numbers each: x y z and quaternion x y z w, \
            world frame, in steps of 1/8192";
    },
};

/// Ground truth of each taxel.
pub(super) const TRUTH_TAXELS: Table = Table {
    name: "truth_taxels",
    path: "truth/taxels",
    row: "a taxel in contact, in one frame; taxels without contact have no row",
    columns: columns! { [EPISODE, FRAME, PATCH, TAXEL]
        "normal_force_n", "float64", "N", "true force along the inward normal, before the sensor";
        "shear_force_tangent_n", "float64", "N", "true force along the taxel's tangent";
        "shear_force_binormal_n", "float64", "N", "true force along normal × tangent";
        "object_index", "int32", "", "the object that presses hardest, a row of `truth/objects`; −1 for none";
        "category_code", "int8", "", "category of that object";
    },
};

/// Ground truth of each patch.
pub(super) const TRUTH_PATCHES: Table = Table {
    name: "truth_patches",
    path: "truth/patches",
    row: "a patch in contact, in one frame",
    columns: columns! { [EPISODE, FRAME, PATCH]
        "contact_force_world_{xyz}_n", "float64", "N", "sum of the solver's contact forces on the patch, world frame";
    },
};

/// Bodies and their shapes.
pub(super) const TRUTH_BODIES: Table = Table {
    name: "truth_bodies",
    path: "truth/bodies",
    row: "a collision shape of a rigid body (a link, or a part of an object that moves as one piece)",
    columns: columns! { [EPISODE]
        "body_index", "int32", "", "index of the body in its reach, from 0: links from the base on, then objects";
        "link", "text", "", "name of the link; null for a body of an object";
        "object_index", "int32", "", "the object, a row of `truth/objects`; null for a link";
        "category", "text", "", "category of the object; null for a link";
        "shape", "text", "", "`sphere`, `cylinder`, `capsule`, `box` or `hull`; null for a body without a shape";
        "size_{xyz}_m", "float64", "m", "full edge lengths of a box; otherwise null";
        "radius_m", "float64", "m", "radius of a sphere, cylinder or capsule; otherwise null";
        "length_m", "float64", "m", "length along z of a cylinder, or of a capsule without its caps; otherwise null";
        "points_m", "list of float64", "m", "corners of a convex hull, x y z of each in turn; otherwise null";
        "position_body_{xyz}_m", "float64", "m", "centre of the shape in the body's frame";
        "orientation_body_{xyzw}", "float64", "1", "rotation from the shape's frame to the body's, quaternion";
        "rest_position_world_{xyz}_m", "float64", "m", "origin of the body before the reach begins, world frame";
        "rest_orientation_world_{xyzw}", "float64", "1", "rotation from the body's frame to the world then, quaternion";
    },
};

/// Poses over time.
pub(super) const TRUTH_POSES: Table = Table {
    name: "truth_poses",
    path: "truth/poses",
    row: "a body in a frame where its pose differs from the previous frame; the pose holds until the body's next row. \
          Before its first row a body has the pose of `truth/bodies`",
    columns: columns! { [EPISODE]
        "body_index", "int32", "", "the body, as in `truth/bodies`";
        "frame_index", "int64", "", "index of the frame in its reach, from 0";
        "position_world_{xyz}_m", "float32", "m", "origin of the body, world frame, in steps of 1/8192 m (0.12 mm)";
        "orientation_world_{xyzw}", "float32", "1", "rotation from the body's frame to the world, quaternion, in \
            steps of 1/8192; normalize it before use";
    },
};

/// Objects.
pub(super) const TRUTH_OBJECTS: Table = Table {
    name: "truth_objects",
    path: "truth/objects",
    row: "an object in the clutter of a reach",
    columns: columns! { [EPISODE]
        "object_index", "int32", "", "index of the object in its reach, from 0";
        "kind", "text", "", "kind of the object in the scene file";
        "category", "text", "", "`leaf`, `trunk`, `block`, `outlier`, or the name of a category that the set adds";
        "position_world_{xyz}_m", "float64", "m", "foot of the object, world frame";
        "parameters", "text", "", "parameters drawn for the object, as a JSON object with SI units in the names";
    },
};

/// Goals.
pub(super) const TRUTH_GOALS: Table = Table {
    name: "truth_goals",
    path: "truth/goals",
    row: "a goal of a reach",
    columns: columns! { [EPISODE]
        "goal_index", "int32", "", "index of the goal in its reach, from 0";
        "position_world_{xyz}_m", "float64", "m", "position of the goal, world frame";
        "start_time_s", "float64", "s", "time at which the arm started towards it";
        "end_time_s", "float64", "s", "time at which it was reached or given up";
        "outcome", "text", "", "`reached`, `stuck`, `timed_out` or `aborted`";
        "stop_object_index", "int32", "", "object whose force ended the goal, a row of `truth/objects`; otherwise null";
        "stop_link", "text", "", "name of the link that this object pressed; otherwise null";
        "stop_patch", "text", "", "name of the patch that took most of the force; null if there is no skin there";
        "stop_force_n", "float64", "N", "that force; null if no force ended the goal";
    },
};

/// Contacts.
pub(super) const TRUTH_CONTACTS: Table = Table {
    name: "truth_contacts",
    path: "truth/contacts",
    row: "a contact of an object with a patch or a bare link, from its first frame to its last",
    columns: columns! { [EPISODE]
        "link", "text", "", "name of the link";
        "patch", "text", "", "name of the patch; null for a part of the link without skin";
        "object_index", "int32", "", "the object, a row of `truth/objects`";
        "category", "text", "", "category of the object";
        "first_frame", "int64", "", "first frame in contact";
        "last_frame", "int64", "", "last frame in contact";
        "peak_force_n", "float64", "N", "largest contact force in any frame";
        "mean_force_n", "float64", "N", "mean contact force over the frames";
    },
};

/// Taxels.
pub(super) const TAXELS: Table = Table {
    name: "taxels",
    path: "meta/taxels.parquet",
    row: "a taxel",
    columns: columns! { [PATCH, TAXEL]
        "row", "int32", "", "row in the patch's grid; null without a grid";
        "column", "int32", "", "column in the patch's grid; null without a grid";
        "link", "text", "", "name of the link that carries it";
        "position_link_{xyz}_m", "float64", "m", "centre, link frame";
        "normal_link_{xyz}", "float64", "1", "outward unit normal, link frame";
        "tangent_link_{xyz}", "float64", "1", "first tangent, link frame; the second is normal × tangent";
        "area_m2", "float64", "m²", "sensitive area";
    },
};

/// All tables that are described here. LeRobot's own tables in `meta/` are not among them.
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

/// Key of the metadata entry that holds the names of a column's codes.
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
    /// The metadata of a column's field: `description`, and `unit` and `codes` (a JSON object) if it has any. `None` if
    /// the table has no such column.
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
