//! The skin file: patches of taxels that name links, either laid on a cylinder or listed one by one.

use glam::DVec3;
use rapier3d::prelude::Pose;
use serde::Deserialize;
use toml::Spanned;
use underbrush_recording::{Grid, InputError, Patch, SkinLayout, Taxel};

use super::file::known_links;
use super::skin::{PatchSurface, Skin, SurfaceForm, Technology};
use super::source::Source;
use super::urdf::Chain;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SkinFile {
    stiffness_n_per_m3: f64,
    #[serde(default)]
    patch: Vec<Spanned<PatchTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PatchTable {
    name: String,
    link: String,
    #[serde(default)]
    technology: Technology,
    cylinder: Option<Spanned<CylinderTable>>,
    points: Option<Spanned<PointsTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CylinderTable {
    row_0_m: [f64; 3],
    axis: [f64; 3],
    zero_angle: [f64; 3],
    radius_m: f64,
    rows: usize,
    row_pitch_m: f64,
    taxel_size_m: f64,
    wraps: bool,
    column_angles_deg: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PointsTable {
    derived_area_limits_m2: Option<[f64; 2]>,
    taxels: Vec<Spanned<TaxelTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TaxelTable {
    position_m: [f64; 3],
    normal: [f64; 3],
    area_m2: Option<f64>,
}

/// Reads the skin file of an arm with this chain.
pub(super) fn read_skin(source: &Source, chain: &Chain) -> Result<Skin, InputError> {
    let file: SkinFile = source.toml("compare with the skin file of `cody`, which ships with underbrush")?;
    if !positive(file.stiffness_n_per_m3) {
        return Err(source.fault_after(0, "stiffness_n_per_m3", file.stiffness_n_per_m3, "a positive number"));
    }
    let mut skin = Skin {
        layout: SkinLayout { patches: Vec::new() },
        surfaces: Vec::new(),
        stiffness_n_per_m3: file.stiffness_n_per_m3,
    };
    for table in &file.patch {
        let start = table.span().start;
        let table = table.get_ref();
        if table.name.is_empty() || skin.layout.patch_index(&table.name).is_some() {
            return Err(source.fault_after(start, "patch.name", format!("{:?}", table.name), "a unique name"));
        }
        let Some((link, pose)) = chain.frames.get(&table.link).copied() else {
            return Err(source.fault_after(start, "patch.link", &table.link, known_links(chain)));
        };
        let (form, grid, mut taxels) = match (&table.cylinder, &table.points) {
            (Some(cylinder), None) => cylinder_taxels(source, cylinder, &pose)?,
            (None, Some(points)) => (SurfaceForm::Points, None, point_taxels(source, points)?),
            _ => {
                let allowed = "either [patch.cylinder] or [patch.points]";
                return Err(source.fault_after(start, "patch", format!("both or none in {:?}", table.name), allowed));
            }
        };
        for taxel in &mut taxels {
            taxel.position_link = pose.transform_point(taxel.position_link);
            taxel.normal_link = pose.rotation * taxel.normal_link;
            taxel.tangent_link = pose.rotation * taxel.tangent_link;
        }
        let link_name = chain.links[link].name.clone();
        skin.layout.patches.push(Patch {
            name: table.name.clone(),
            link: link_name,
            grid,
            taxels,
        });
        skin.surfaces.push(PatchSurface {
            link,
            form,
            technology: table.technology,
        });
    }
    Ok(skin)
}

/// The taxels of a cylinder in the frame that the file names; the form in that of the link, where it has `pose`.
fn cylinder_taxels(
    source: &Source,
    table: &Spanned<CylinderTable>,
    pose: &Pose,
) -> Result<(SurfaceForm, Option<Grid>, Vec<Taxel>), InputError> {
    let start = table.span().start;
    let table = table.get_ref();
    let fault = |key: &str, found: String, allowed: &str| {
        Err(source.fault_after(start, &format!("patch.cylinder.{key}"), found, allowed))
    };
    let row_0 = DVec3::from_array(table.row_0_m);
    if !row_0.is_finite() {
        return fault("row_0_m", format!("{:?}", table.row_0_m), "three finite numbers");
    }
    let Some(axis) = DVec3::from_array(table.axis).try_normalize() else {
        return fault(
            "axis",
            format!("{:?}", table.axis),
            "three finite numbers, not all zero",
        );
    };
    let Some(zero) = DVec3::from_array(table.zero_angle)
        .reject_from_normalized(axis)
        .try_normalize()
    else {
        return fault(
            "zero_angle",
            format!("{:?}", table.zero_angle),
            "a direction across the axis",
        );
    };
    for (key, value) in [
        ("radius_m", table.radius_m),
        ("row_pitch_m", table.row_pitch_m),
        ("taxel_size_m", table.taxel_size_m),
    ] {
        if !positive(value) {
            return fault(key, value.to_string(), "a positive number");
        }
    }
    if !(1..=10_000).contains(&table.rows) {
        return fault("rows", table.rows.to_string(), "1 to 10000");
    }
    let angles = &table.column_angles_deg;
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else {
        return fault("column_angles_deg", "none".into(), "at least one angle");
    };
    let mut steps = angles
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .chain([first + 360.0 - last]);
    let least_step_deg = (table.taxel_size_m / table.radius_m).to_degrees();
    if table.taxel_size_m > table.row_pitch_m || !steps.all(|step| step >= least_step_deg) {
        let allowed = format!(
            "taxels that do not overlap: at most the row pitch, and rising column angles at least {least_step_deg:.2} deg apart"
        );
        return fault("taxel_size_m", table.taxel_size_m.to_string(), &allowed);
    }
    let quarter = axis.cross(zero);
    let taxel = |row: usize, angle_deg: f64| {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        let normal = zero * cos + quarter * sin;
        Taxel {
            position_link: row_0 + axis * (row as f64 * table.row_pitch_m) + normal * table.radius_m,
            normal_link: normal,
            tangent_link: axis,
            area_m2: table.taxel_size_m * table.taxel_size_m,
        }
    };
    let taxels = (0..table.rows)
        .flat_map(|row| angles.iter().map(move |angle| taxel(row, *angle)))
        .collect();
    let form = SurfaceForm::Cylinder {
        axis_point_link: pose.transform_point(row_0),
        axis_link: pose.rotation * axis,
        radius_m: table.radius_m,
    };
    Ok((
        form,
        Some(Grid {
            rows: table.rows,
            columns: angles.len(),
            wraps: table.wraps,
        }),
        taxels,
    ))
}

fn point_taxels(source: &Source, table: &Spanned<PointsTable>) -> Result<Vec<Taxel>, InputError> {
    let start = table.span().start;
    let table = table.get_ref();
    let limits = table.derived_area_limits_m2;
    if let Some([least, most]) = limits
        && !(positive(least) && most.is_finite() && least <= most)
    {
        let found = format!("{:?}", [least, most]);
        return Err(source.fault_after(
            start,
            "derived_area_limits_m2",
            found,
            "two positive areas, the smaller first",
        ));
    }
    let mut taxels = Vec::with_capacity(table.taxels.len());
    for (number, entry) in table.taxels.iter().enumerate() {
        let fault = |key: &str, found: String, allowed: &str| {
            Err(source.fault_after(
                entry.span().start,
                &format!("patch.points.taxels[{number}].{key}"),
                found,
                allowed,
            ))
        };
        let given = entry.get_ref();
        let position_link = DVec3::from_array(given.position_m);
        if !position_link.is_finite() {
            return fault("position_m", format!("{:?}", given.position_m), "three finite numbers");
        }
        let Some(normal_link) = DVec3::from_array(given.normal).try_normalize() else {
            return fault(
                "normal",
                format!("{:?}", given.normal),
                "three finite numbers, not all zero",
            );
        };
        let area_m2 = match (given.area_m2, limits) {
            (Some(area), _) if positive(area) => area,
            (Some(area), _) => return fault("area_m2", area.to_string(), "a positive number"),
            (None, Some([least, most])) => derived_area(&table.taxels, number, normal_link).clamp(least, most),
            (None, None) => {
                return fault(
                    "area_m2",
                    "none".into(),
                    "an area, or derived_area_limits_m2 for the whole patch",
                );
            }
        };
        // Along the link's z axis, or its x axis where z is the normal.
        let along = DVec3::Z.reject_from_normalized(normal_link);
        let along = if along.length() > 1e-6 { along } else { DVec3::X };
        let tangent_link = along.reject_from_normalized(normal_link).normalize();
        taxels.push(Taxel {
            position_link,
            normal_link,
            tangent_link,
            area_m2,
        });
    }
    Ok(taxels)
}

/// The square of the distance to the nearest taxel that faces the same way (within 90°); infinite for a lone one.
fn derived_area(taxels: &[Spanned<TaxelTable>], number: usize, normal: DVec3) -> f64 {
    let position = |taxel: &Spanned<TaxelTable>| DVec3::from_array(taxel.get_ref().position_m);
    let neighbours = taxels
        .iter()
        .enumerate()
        .filter(|(other, taxel)| *other != number && DVec3::from_array(taxel.get_ref().normal).dot(normal) > 0.0);
    neighbours
        .map(|(_, taxel)| position(taxel).distance_squared(position(&taxels[number])))
        .fold(f64::INFINITY, f64::min)
}

fn positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}
