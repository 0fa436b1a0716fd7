//! The skin file: patches of taxels on links, either arranged on a cylinder or listed one by one.

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::limits::{MAX_PATCHES, MAX_TAXELS, short};
use underbrush_recording::{Grid, InputError, PLAIN, Patch, SkinLayout, Taxel, is_plain, math, parse_toml};

use super::skin::{PatchSurface, Skin, Technology};
use super::source::{Source, listed};
use super::urdf::Chain;
use super::{limits, skin_fit};
use crate::range::Within;

/// The tactile skin of an arm: patches of taxels on its links.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SkinFile {
    /// Stiffness of the skin's soft layer at small indentations: pressure per indentation, which is elastic modulus over thickness. More
    /// than 3e8 changes nothing: no surface of a simulation is stiffer.
    #[schemars(transform = Within(limits::SKIN_N_PER_M3))]
    stiffness_n_per_m3: f64,
    /// Thickness of the soft layer; the pressure grows faster as the layer is pressed flat. Without it the pressure stays
    /// proportional to the indentation.
    #[schemars(transform = Within(limits::LAYER_M))]
    thickness_m: Option<f64>,
    /// Loss time τ of the layer: under an indentation h its pressure is p(h) + τ dp/dt.
    #[serde(default = "default_loss_time_s")]
    #[schemars(transform = Within(limits::LOSS_TIME_S))]
    loss_time_s: f64,
    /// The patches. The command line uses the first one if no other is named.
    #[serde(default)]
    patch: Vec<PatchTable>,
}

/// Loss time of soft rubber and foam rubber, s: their loss factor is 0.05 to 0.3 at the frequencies of touch, about 10
/// to 20 Hz, which is a loss time of 1 to 2 ms.
fn default_loss_time_s() -> f64 {
    0.002
}

/// A patch of taxels on one link, laid out either on a cylinder or point by point.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("oneOf" = [{ "required": ["cylinder"] }, { "required": ["points"] }]))]
struct PatchTable {
    /// Name of the patch, unique on the arm; part of column names in data sets.
    #[schemars(length(min = 1))]
    name: String,
    /// The link of the URDF that carries it; all positions of the patch are in this link's frame.
    link: String,
    /// Sensing technology; the scene file's `[sensor]` section holds the properties of each.
    #[serde(default)]
    technology: Technology,
    /// Taxels in rows and columns on a cylinder. Either this or `points`.
    cylinder: Option<CylinderTable>,
    /// Taxels listed one by one. Either this or `cylinder`.
    points: Option<PointsTable>,
}

/// Square taxels in rows and columns on a cylinder. Taxel index = row · columns + column.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct CylinderTable {
    /// Point on the cylinder's axis at the middle of row 0.
    #[schemars(transform = Within(limits::PLACE_M))]
    row_0_m: [f64; 3],
    /// Direction of the axis, from row 0 to the next rows; need not be of unit length.
    #[schemars(transform = Within(limits::DIRECTION_ENTRY))]
    axis: [f64; 3],
    /// Direction of column angle 0, across the axis; angles are right-handed about the axis.
    #[schemars(transform = Within(limits::DIRECTION_ENTRY))]
    zero_angle: [f64; 3],
    /// Radius of the cylinder, to the taxels' surface.
    #[schemars(transform = Within(limits::RADIUS_M))]
    radius_m: f64,
    /// Number of rows. All patches of an arm together have at most 65536 taxels.
    #[schemars(range(min = 1, max = MAX_TAXELS))]
    rows: usize,
    /// Distance from one row to the next.
    #[schemars(transform = Within(limits::TAXEL_SIZE_M))]
    row_pitch_m: f64,
    /// Side of a taxel, at most `row_pitch_m`.
    #[schemars(transform = Within(limits::TAXEL_SIZE_M))]
    taxel_size_m: f64,
    /// The share of the pressure on the gaps between taxels that the cover passes on to them: 1, all of it, as a stiff cover
    /// does; 0, gaps are dead.
    #[serde(default = "all")]
    #[schemars(transform = Within(limits::SHARE))]
    gap_share: f64,
    /// Whether the last column is a neighbour of the first, as on a closed sleeve.
    wraps: bool,
    /// Angle of each column, ascending, so far apart that taxels do not overlap.
    #[schemars(transform = Within(limits::ANGLE_DEG), length(min = 1))]
    column_angles_deg: Vec<f64>,
}

/// Nobody has measured how much a cover passes on. Choice: the default loses no force.
fn all() -> f64 {
    1.0
}

/// Taxels listed one by one.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PointsTable {
    /// Smallest and largest area of taxels that give none: their area is the square of the distance to the nearest
    /// taxel that faces the same way, within these two.
    #[schemars(transform = Within(limits::TAXEL_AREA_M2))]
    derived_area_limits_m2: Option<[f64; 2]>,
    /// The taxels, in the order of their indices.
    #[schemars(length(min = 1))]
    taxels: Vec<TaxelTable>,
}

/// A single taxel.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TaxelTable {
    /// Centre of the taxel, on the link's collision shapes.
    #[schemars(transform = Within(limits::PLACE_M))]
    position_m: [f64; 3],
    /// Outward normal; need not be of unit length.
    #[schemars(transform = Within(limits::DIRECTION_ENTRY))]
    normal: [f64; 3],
    /// Area; needed unless the patch has `derived_area_limits_m2`.
    #[schemars(transform = Within(limits::TAXEL_AREA_M2))]
    area_m2: Option<f64>,
}

/// Reads the layout of a skin file without the arm that wears it. Positions are in the frames of the links that the
/// file names.
pub(super) fn read_layout(source: &Source) -> Result<SkinLayout, InputError> {
    let mut layout = SkinLayout::default();
    for (number, table) in read_file(source)?.patch.iter().enumerate() {
        layout.patches.push(read_patch(source, &format!("patch[{number}]"), table, &layout)?);
    }
    Ok(layout)
}

fn read_file(source: &Source) -> Result<SkinFile, InputError> {
    let allowed = "the keys of a skin file, such as that of `cody`, which ships with underbrush";
    let file: SkinFile = parse_toml(&source.path, &source.text, "TOML", allowed)?;
    source.check("stiffness_n_per_m3", file.stiffness_n_per_m3, limits::SKIN_N_PER_M3)?;
    if let Some(thickness_m) = file.thickness_m {
        source.check("thickness_m", thickness_m, limits::LAYER_M)?;
    }
    source.check("loss_time_s", file.loss_time_s, limits::LOSS_TIME_S)?;
    if file.patch.len() > MAX_PATCHES {
        let found = format!("{} patches", file.patch.len());
        return Err(source.fault_at("patch", found, format!("at most {MAX_PATCHES} patches")));
    }
    Ok(file)
}

/// Reads the patch at `place` of the file, in the frame of the link that the file names. The patch's name must differ from
/// those of `earlier` patches.
fn read_patch(source: &Source, place: &str, table: &PatchTable, earlier: &SkinLayout) -> Result<Patch, InputError> {
    let wrong_name = |allowed| Err(source.fault_at(&format!("{place}.name"), format!("{:?}", table.name), allowed));
    // Columns are named after patches, and LeRobot reads a "/" in a name as part of a path.
    if table.name.is_empty() || table.name.contains('/') || earlier.patch_index(&table.name).is_some() {
        return wrong_name("a unique name without \"/\"");
    }
    if !is_plain(&table.name) {
        return wrong_name(PLAIN);
    }
    let taxels = match (&table.cylinder, &table.points) {
        (Some(cylinder), None) => cylinder_taxels(source, &format!("{place}.cylinder"), cylinder)?,
        (None, Some(points)) => point_taxels(source, &format!("{place}.points"), points)?,
        _ => {
            let allowed = "either [patch.cylinder] or [patch.points]";
            return Err(source.fault_at(place, format!("both or none in {:?}", table.name), allowed));
        }
    };
    let count = earlier.taxel_count() + taxels.len();
    if !(1..=MAX_TAXELS).contains(&count) {
        let allowed = format!("1 to {MAX_TAXELS} taxels on all patches together");
        return Err(source.fault_at(place, format!("{count} taxels"), allowed));
    }
    let grid = |own: &CylinderTable| Grid { rows: own.rows, columns: own.column_angles_deg.len(), wraps: own.wraps };
    Ok(Patch { name: table.name.clone(), link: table.link.clone(), grid: table.cylinder.as_ref().map(grid), taxels })
}

/// Reads the skin file of an arm with this chain.
pub(super) fn read_skin(source: &Source, chain: &Chain) -> Result<Skin, InputError> {
    let file = read_file(source)?;
    let mut skin = Skin {
        layout: SkinLayout::default(),
        surfaces: Vec::new(),
        stiffness_n_per_m3: file.stiffness_n_per_m3,
        thickness_m: file.thickness_m,
        loss_time_s: file.loss_time_s,
    };
    for (number, table) in file.patch.iter().enumerate() {
        let place = format!("patch[{number}]");
        let (link, pose) = chain.frame(source, &format!("{place}.link"), &table.link)?;
        let mut patch = read_patch(source, &place, table, &skin.layout)?;
        patch.link.clone_from(&chain.links[link].name);
        for taxel in &mut patch.taxels {
            taxel.position_link = pose.transform_point(taxel.position_link);
            taxel.normal_link = pose.orientation * taxel.normal_link;
            taxel.tangent_link = pose.orientation * taxel.tangent_link;
        }
        skin_fit::check(source, &place, &patch, &chain.links[link])?;
        skin.layout.patches.push(patch);
        let cylinder = table.cylinder.as_ref();
        skin.surfaces.push(PatchSurface {
            link,
            radius_m: cylinder.map(|cylinder| cylinder.radius_m),
            technology: table.technology,
            gap_share: cylinder.map_or(1.0, |cylinder| cylinder.gap_share),
        });
    }
    Ok(skin)
}

fn cylinder_taxels(source: &Source, place: &str, table: &CylinderTable) -> Result<Vec<Taxel>, InputError> {
    let key = |key: &str| format!("{place}.{key}");
    let fault = |own: &str, found: String, allowed: &str| Err(source.fault_at(&key(own), found, allowed));
    source.check_each(&key("row_0_m"), &table.row_0_m, limits::PLACE_M)?;
    let row_0 = DVec3::from_array(table.row_0_m);
    let axis = source.direction(&key("axis"), table.axis)?;
    let zero = source.direction(&key("zero_angle"), table.zero_angle)?;
    // If it is closer to the axis than this, the direction across the axis would be mostly rounding error.
    let across = zero.reject_from_normalized(axis);
    let Some(zero) = across.try_normalize().filter(|_| across.length() > 1e-3) else {
        return fault("zero_angle", listed(&table.zero_angle), "a direction across the axis");
    };
    source.check(&key("radius_m"), table.radius_m, limits::RADIUS_M)?;
    source.check(&key("row_pitch_m"), table.row_pitch_m, limits::TAXEL_SIZE_M)?;
    source.check(&key("taxel_size_m"), table.taxel_size_m, limits::TAXEL_SIZE_M)?;
    source.check(&key("gap_share"), table.gap_share, limits::SHARE)?;
    let angles = &table.column_angles_deg;
    let columns = angles.len();
    if !(1..=MAX_TAXELS / columns.max(1)).contains(&table.rows) {
        let allowed = format!("at least 1, and at most {MAX_TAXELS} taxels on all patches together");
        return fault("rows", format!("{} rows of {columns} taxels", table.rows), &allowed);
    }
    source.check_each(&key("column_angles_deg"), angles, limits::ANGLE_DEG)?;
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else {
        return fault("column_angles_deg", "none".into(), "at least one angle");
    };
    let mut steps = angles.windows(2).map(|pair| pair[1] - pair[0]).chain([first + 360.0 - last]);
    let min_step_deg = (table.taxel_size_m / table.radius_m).to_degrees();
    if table.taxel_size_m > table.row_pitch_m || !steps.all(|step| step >= min_step_deg) {
        let allowed = format!(
            "taxels that do not overlap: at most the row pitch, and rising column angles at least {min_step_deg:.2} deg apart"
        );
        return fault("taxel_size_m", short(table.taxel_size_m), &allowed);
    }
    let quarter = axis.cross(zero);
    let taxel = |row: usize, angle_deg: f64| {
        let (sin, cos) = math::sin_cos(angle_deg.to_radians());
        let normal = zero * cos + quarter * sin;
        Taxel {
            position_link: row_0 + axis * (row as f64 * table.row_pitch_m) + normal * table.radius_m,
            normal_link: normal,
            tangent_link: axis,
            area_m2: table.taxel_size_m * table.taxel_size_m,
        }
    };
    Ok((0..table.rows).flat_map(|row| angles.iter().map(move |angle| taxel(row, *angle))).collect())
}

fn point_taxels(source: &Source, place: &str, table: &PointsTable) -> Result<Vec<Taxel>, InputError> {
    let derived = table.derived_area_limits_m2;
    if let Some([min, max]) = derived {
        let field = format!("{place}.derived_area_limits_m2");
        source.check_each(&field, &[min, max], limits::TAXEL_AREA_M2)?;
        if min > max {
            return Err(source.fault_at(&field, listed(&[min, max]), "two areas, the smaller first"));
        }
    }
    if table.taxels.len() > MAX_TAXELS {
        let found = format!("{} taxels", table.taxels.len());
        let allowed = format!("at most {MAX_TAXELS} taxels on all patches together");
        return Err(source.fault_at(&format!("{place}.taxels"), found, allowed));
    }
    let mut taxels = Vec::with_capacity(table.taxels.len());
    for (number, given) in table.taxels.iter().enumerate() {
        let key = |key: &str| format!("{place}.taxels[{number}].{key}");
        source.check_each(&key("position_m"), &given.position_m, limits::PLACE_M)?;
        let position_link = DVec3::from_array(given.position_m);
        let normal_link = source.direction(&key("normal"), given.normal)?;
        let area_m2 = match (given.area_m2, derived) {
            (Some(area), _) => {
                source.check(&key("area_m2"), area, limits::TAXEL_AREA_M2)?;
                area
            }
            (None, Some([min, max])) => derived_area(&table.taxels, number, normal_link).clamp(min, max),
            (None, None) => {
                let allowed = "an area, or derived_area_limits_m2 for the whole patch";
                return Err(source.fault_at(&key("area_m2"), "none", allowed));
            }
        };
        // The tangent follows the link's z axis, or its x axis if z is the normal.
        let along = DVec3::Z.reject_from_normalized(normal_link);
        let along = if along.length() > 1e-6 { along } else { DVec3::X };
        let tangent_link = along.reject_from_normalized(normal_link).normalize();
        taxels.push(Taxel { position_link, normal_link, tangent_link, area_m2 });
    }
    Ok(taxels)
}

/// The square of the distance to the nearest taxel that faces the same way (within 90°); infinite if there is none.
fn derived_area(taxels: &[TaxelTable], number: usize, normal: DVec3) -> f64 {
    let position = |taxel: &TaxelTable| DVec3::from_array(taxel.position_m);
    let others = taxels.iter().enumerate().filter(|(other, _)| *other != number).map(|(_, taxel)| taxel);
    let neighbours = others.filter(|taxel| DVec3::from_array(taxel.normal).dot(normal) > 0.0);
    neighbours.map(|taxel| position(taxel).distance_squared(position(&taxels[number]))).fold(f64::INFINITY, f64::min)
}
