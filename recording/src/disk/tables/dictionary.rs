//! The data dictionary: every table of a data set with its columns, their units and codes.
//!
//! The columns of the Parquet files and their descriptions, the card of a data set and `docs/data.md` are made from this
//! list. The table of frames is in `frames.rs`, and what a recording adds to it in `truth_columns.rs`.

use glam::{DQuat, DVec3};

use crate::disk::table::{Described, Text, Width, row};
use crate::disk::tables::frames::FRAME_COLUMNS;
use crate::disk::tables::truth_columns::TRUTH_COLUMNS;

/// One table.
#[derive(Clone, Copy)]
pub(crate) struct Table {
    /// Name in the card, for `datasets.load_dataset(FOLDER, NAME)`.
    pub(crate) name: &'static str,
    /// Folder or file, relative to the data set.
    pub(crate) path: &'static str,
    /// What a row is.
    pub(crate) row: &'static str,
    /// Its columns.
    pub(crate) columns: fn() -> Vec<Described>,
}

/// Declares a table and the type of its rows: the columns of `after` come first, then those of the fields.
macro_rules! table {
    ($(#[$doc:meta])* $table:ident: $row:ident $(after $first:ident)?, $name:literal, $path:literal, $what:literal;
     $($fields:tt)*) => {
        $crate::disk::table::row::row! { $row { $($fields)* } }

        $(#[$doc])*
        pub(crate) const $table: $crate::disk::tables::dictionary::Table = $crate::disk::tables::dictionary::Table {
            name: $name,
            path: $path,
            row: $what,
            columns: || {
                use $crate::disk::table::row::Row;
                [$($first::COLUMNS,)? $row::COLUMNS].concat()
            },
        };
    };
}
pub(crate) use table;

/// The frames.
pub(crate) const FRAMES: Table = Table {
    name: "frames",
    path: "data",
    row: "a frame; J joints, n taxels in each patch",
    columns: || FRAME_COLUMNS.iter().map(|column| column.described).collect(),
};

/// The columns that a single recording has in addition to those of [`FRAMES`].
pub(crate) const RECORDING_TRUTH: Table = Table {
    name: "recording",
    path: "the file of a single recording",
    row: "a frame; the columns of `data` come first, then these",
    columns: || TRUTH_COLUMNS.iter().map(|column| column.described).collect(),
};

const FRAME: &str = "index of the frame in its reach, from 0";
const PATCH: &str = "name of the patch of skin";
const TAXEL: &str = "index of the taxel in its patch";

row! {
    /// What every row of a table of reaches begins with.
    OfReach {
        episode_index: i64, "", "index of the reach, from 0";
    }
}

table! {
    /// Ground truth of each taxel.
    TRUTH_TAXELS: TruthTaxel after OfReach, "truth_taxels", "truth/taxels",
        "a taxel in contact, in one frame; taxels without contact have no row";
    frame_index: i64, "", FRAME;
    patch: Text, "", PATCH;
    taxel: i32, "", TAXEL;
    normal_force_n: f64, "N", "true force along the inward normal, before the sensor";
    shear_force_tangent_n: f64, "N", "true force along the taxel's tangent";
    shear_force_binormal_n: f64, "N", "true force along normal × tangent";
    object_index: i32, "", "the object that presses hardest, a row of `truth/objects`; −1 for none";
    category_code: i8, "", "category of that object";
}

table! {
    /// Ground truth of each patch.
    TRUTH_PATCHES: TruthPatch after OfReach, "truth_patches", "truth/patches", "a patch in contact, in one frame";
    frame_index: i64, "", FRAME;
    patch: Text, "", PATCH;
    contact_force_world: DVec3 = "contact_force_world_{xyz}_n", "N", "sum of the solver's contact forces on the \
        patch, world frame";
}

table! {
    /// Bodies and their shapes.
    TRUTH_BODIES: TruthBody after OfReach, "truth_bodies", "truth/bodies",
        "a collision shape of a rigid body (a link, or a part of an object that moves as one piece)";
    body_index: i32, "", "index of the body in its reach, from 0: links from the base on, then objects";
    link: Option<Text>, "", "name of the link; null for a body of an object";
    object_index: Option<i32>, "", "the object, a row of `truth/objects`; null for a link";
    category: Option<Text>, "", "category of the object; null for a link";
    shape: Option<Text>, "", "`sphere`, `cylinder`, `capsule`, `box` or `hull`; null for a body without a shape";
    size: Option<DVec3> = "size_{xyz}_m", "m", "full edge lengths of a box; otherwise null";
    radius_m: Option<f64>, "m", "radius of a sphere, cylinder or capsule; otherwise null";
    length_m: Option<f64>, "m", "length along z of a cylinder, or of a capsule without its caps; otherwise null";
    points_m: Option<Vec<f64>>, "m", "corners of a convex hull, x y z of each in turn; otherwise null";
    position_body: DVec3 = "position_body_{xyz}_m", "m", "centre of the shape in the body's frame";
    orientation_body: DQuat = "orientation_body_{xyzw}", "1", "rotation from the shape's frame to the body's, \
        quaternion";
    rest_position_world: DVec3 = "rest_position_world_{xyz}_m", "m", "origin of the body before the reach \
        begins, world frame";
    rest_orientation_world: DQuat = "rest_orientation_world_{xyzw}", "1", "rotation from the body's frame to the \
        world then, quaternion";
}

table! {
    /// Poses over time.
    TRUTH_POSES: TruthPose after OfReach, "truth_poses", "truth/poses",
        "a body in a frame where its pose differs from the previous frame; the pose holds until the body's next row. Before \
         its first row a body has the pose of `truth/bodies`";
    body_index: i32, "", "the body, as in `truth/bodies`";
    frame_index: i64, "", FRAME;
    position_world: [f32; 3] = "position_world_{xyz}_m", "m", "origin of the body, world frame, in steps of \
        1/8192 m (0.12 mm)";
    orientation_world: [f32; 4] = "orientation_world_{xyzw}", "1", "rotation from the body's frame to the world, \
        quaternion, in steps of 1/8192; normalize it before use";
}

table! {
    /// Objects.
    TRUTH_OBJECTS: TruthObject after OfReach, "truth_objects", "truth/objects", "an object in the clutter of a reach";
    object_index: i32, "", "index of the object in its reach, from 0";
    kind: Text, "", "kind of the object in the scene file";
    category: Text, "", "`leaf`, `trunk`, `block`, `outlier`, or the name of a category that the set adds";
    position_world: DVec3 = "position_world_{xyz}_m", "m", "foot of the object, world frame";
    parameters: Text, "", "parameters drawn for the object, or that follow from them, as a JSON object with SI units in the names";
}

table! {
    /// Goals.
    TRUTH_GOALS: TruthGoal after OfReach, "truth_goals", "truth/goals", "a goal of a reach that was tried";
    goal_index: i32, "", "index of the goal in its reach, from 0";
    position_world: DVec3 = "position_world_{xyz}_m", "m", "position of the goal, world frame";
    start_time_s: f64, "s", "time at which the arm started towards it";
    end_time_s: f64, "s", "time at which it was reached or given up";
    outcome: Text, "", "`reached`, `stuck`, `timed_out` or `aborted`";
    stop_object_index: Option<i32>, "", "object whose force ended the goal, a row of `truth/objects`; null for \
        the arm itself, and if no force ended it";
    stop_link: Option<Text>, "", "name of the link that was pressed; null if no force ended the goal";
    stop_patch: Option<Text>, "", "name of the patch that took most of the force; null if there is no skin there";
    stop_force_n: Option<f64>, "N", "that force; null if no force ended the goal";
}

table! {
    /// Contacts.
    TRUTH_CONTACTS: TruthContact after OfReach, "truth_contacts", "truth/contacts",
        "a contact of an object with a patch or a bare link, from its first frame to its last";
    link: Text, "", "name of the link";
    patch: Option<Text>, "", "name of the patch; null for a part of the link without skin";
    object_index: i32, "", "the object, a row of `truth/objects`";
    category: Text, "", "category of the object";
    first_frame: i64, "", "first frame in contact";
    last_frame: i64, "", "last frame in contact";
    peak_force_n: f64, "N", "largest contact force in any frame";
    mean_force_n: f64, "N", "mean contact force over the frames";
}

table! {
    /// Contacts as the solver found them.
    TRUTH_CONTACT_POINTS: TruthContactPoint after OfReach, "truth_contact_points", "truth/contact_points",
        "a contact of a patch or a bare link with a body of an object or another link, in one frame; no rows if the scene says \
         `recording.contact_points = false`";
    frame_index: i64, "", FRAME;
    link: Text, "", "name of the link";
    patch: Option<Text>, "", "name of the patch; null for a part of the link without skin";
    object_index: i32, "", "the object, a row of `truth/objects`; −1 for the arm itself";
    body_index: i32, "", "the body of the object, or the other link, as in `truth/bodies`";
    position_world: [f32; 3] = "position_world_{xyz}_m", "m", "centre of the force, on the link at the end of the frame, world \
        frame";
    normal_world: [f32; 3] = "normal_world_{xyz}", "1", "direction of the normal forces on the link, world frame";
    force_world: [f32; 3] = "force_world_{xyz}_n", "N", "mean force on the link over the frame, world frame; \
        joint torques are Σ Jᵀ f";
    moment_world: [f32; 3] = "moment_world_{xyz}_nm", "N m", "mean moment on the link about the position, \
        world frame: friction of a patch that turns";
    slip_world: [f32; 3] = "slip_world_{xyz}_m_per_s", "m/s", "mean velocity of the link's surface against the other, world frame";
    depth_m: f32, "m", "largest overlap of the undeformed shapes: how far skin and object together give way";
    area_m2: f32, "m²", "largest area that presses";
}

table! {
    /// What the controller believes, which is not the truth.
    MAP: MapRow after OfReach, "map", "controller/map",
        "an obstacle on the controller's map; no rows if the controller has none";
    kind: Text, "", "`fixed`, `doubtful` (it stopped the arm) or `yielding` (it gives way and stopped the arm)";
    top_world: DVec3 = "top_world_{xyz}_m", "m", "upper end of its upright axis, world frame; it stands on the ground";
    radius_m: f64, "m", "radius";
    deviation_m: f64, "m", "standard deviation of its place in the direction in which it is known worst";
    first_frame: i64, "", "first frame in which it stood on the map like this";
    last_frame: i64, "", "last frame in which it did";
}

table! {
    /// Taxels.
    TAXELS: SkinTaxel, "taxels", "meta/taxels.parquet", "a taxel";
    patch: Text, "", PATCH;
    taxel: i32, "", TAXEL;
    row: Option<i32>, "", "row in the patch's grid; null without a grid";
    column: Option<i32>, "", "column in the patch's grid; null without a grid";
    link: Text, "", "name of the link that carries it";
    position_link: DVec3 = "position_link_{xyz}_m", "m", "centre, link frame";
    normal_link: DVec3 = "normal_link_{xyz}", "1", "outward unit normal, link frame";
    tangent_link: DVec3 = "tangent_link_{xyz}", "1", "first tangent, link frame; the second is normal × tangent";
    area_m2: f64, "m²", "sensitive area";
}

/// Whether a column of frames has numbers for each joint or for each taxel. Its rows are then lists, even if there is only
/// one joint or taxel.
pub fn is_of_joints_or_taxels(name: &str) -> bool {
    let mut columns = FRAME_COLUMNS.iter().chain(TRUTH_COLUMNS).map(|column| &column.described);
    columns.any(|own| own.covers(name) && matches!(own.width, Width::Joints | Width::Taxels(_)))
}
