//! From solver contacts to taxel forces: a thin elastic layer over the hard link spreads each contact over the taxels
//! under it, and conserves its force.
//!
//! The layer is the elastic foundation (Winkler) of [`crate::contact`]: a sub-point j of a taxel, of area a_j, is
//! pressed by a_j p(h_j) where the object indents it by h_j > 0. The object is its true collision shape, with the
//! gap g_j to the sub-point along the contact's normal (negative where they overlap; the distance if it is beside the
//! object). It is moved by a further depth δ and two tilts t, so h_j = δ + t·x_j − g_j, where x_j is the sub-point's
//! place in the tangent plane of the contact. δ and t are chosen so that the pressures add up to the solver's normal
//! force and to its moment about the tangents. They are at the minimum of a convex energy, which Newton's method
//! finds. δ and t are small, and account for the loss of the layer, for movement within a frame and for
//! taxels that do not cover all of the contact. What the taxels' normals cannot carry (friction, and the sideways rest
//! on a curved skin) is spread as shear in proportion to pressure, so that the vector sum over the taxels is the
//! solver's force. If this takes a taxel out of its friction cone, forces are shifted among the pressed taxels, as
//! little as possible (`sim/src/friction_cone.rs`). This needs cones that together contain the solver's force. It fails if all
//! pressed taxels lie on one side of the contact's normal, as a single taxel or column may; the shear then stays as it
//! is.

use glam::{DMat3, DVec2, DVec3};
use parry3d::shape::Shape;
use underbrush_recording::{Patch, Pose};

use crate::arm::skin::{FACING_COSINE, SurfacePoint, corner_m, reach_m};
use crate::contact::chord::{Chords, End, Faces, View};
use crate::friction_cone::{Carrier, solve_symmetric, within_cones};
use crate::geometry::signed_distance_m;
use crate::{Arm, Surface};
use indent::{Spring, indent};

mod indent;

/// One patch of skin, ready for contacts.
#[derive(Clone, Debug)]
pub struct SkinPatch {
    /// The link that carries it.
    pub link: usize,
    /// Taxel centres, m, link frame.
    pub centers_link: Vec<DVec3>,
    /// Outward unit normals of the taxels, link frame.
    pub normals_link: Vec<DVec3>,
    /// Distance of each taxel's corners from its centre, m.
    pub corners_m: Vec<f64>,
    /// Sub-points sorted by taxel, the same number for each.
    pub sub_points: Vec<SurfacePoint>,
    /// Largest distance of a contact point on this skin from the nearest taxel's centre, m.
    pub reach_m: f64,
    /// The layer's compliance and friction.
    pub surface: Surface,
}

/// A contact between a link and one collision shape of an object, in the frame of the link, as input of the skin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinContact {
    /// Position, m, link frame.
    pub position_link: DVec3,
    /// Direction of the normal force on the link (out of the object, into the link), unit, link frame.
    pub inward_link: DVec3,
    /// Force on the link, normal and friction, N, link frame.
    pub force_link: DVec3,
    /// How far from the position the surfaces touch, m.
    pub radius_m: f64,
}

/// The force of one contact on one taxel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TaxelForce {
    /// The taxel.
    pub taxel: usize,
    /// Force along the taxel's inward normal, N.
    pub normal_force_n: f64,
    /// The rest, in the taxel's tangent plane, N, link frame.
    pub shear_link: DVec3,
    /// The share of the normal force that the taxel feels. The rest is on gaps around it.
    pub felt_share: f64,
}

/// Buffers of [`SkinPatch::spread`]. They are kept from contact to contact, so that a frame allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct SpreadBuffers {
    faces: Faces,
    cells: Vec<Cell>,
    /// What the cells resist.
    springs: Vec<Spring>,
    near: Vec<Spring>,
    /// The pressed taxels, each with the sum of its pressures, N, and the part of it that it feels.
    taxels: Vec<(usize, f64, f64)>,
    carriers: Vec<Carrier>,
    forces: Vec<TaxelForce>,
}

/// One sub-point under a contact.
#[derive(Clone, Copy, Debug)]
struct Cell {
    taxel: usize,
    /// Index of the sub-point in its patch.
    point: usize,
    /// Share of its pressure that its taxel feels.
    felt_share: f64,
    /// Its pressure times its area in the pose found, N.
    pressure_n: f64,
}

/// Taxels are searched for this far beyond the edge of a contact, m. The layer is pressed there too if the object moves
/// on within a frame. Choice: an arm at 1 m/s moves by this much in a frame.
const SEARCH_MARGIN_M: f64 = 0.01;

/// Sub-points along each side of a taxel. Four resolve a contact narrower than a taxel to 2.3 mm; the pressure of a
/// trunk changes by less than a sixth between them.
const POINTS_PER_SIDE: usize = 4;

impl SkinPatch {
    /// The patches of an arm's skin, in the layout's order.
    pub fn of_arm(arm: &Arm) -> Vec<SkinPatch> {
        let ready = |(patch, Patch { taxels, .. }): (usize, &Patch)| {
            let link = arm.skin.surfaces[patch].link;
            let points = (0..taxels.len()).flat_map(|taxel| arm.skin.surface_points(patch, taxel, POINTS_PER_SIDE));
            SkinPatch {
                link,
                centers_link: taxels.iter().map(|taxel| taxel.position_link).collect(),
                normals_link: taxels.iter().map(|taxel| taxel.normal_link).collect(),
                corners_m: taxels.iter().map(corner_m).collect(),
                sub_points: points.collect(),
                reach_m: reach_m(taxels),
                surface: arm.surface(link),
            }
        };
        arm.skin.layout.patches.iter().enumerate().map(ready).collect()
    }

    /// Whether a contact presses on this skin and not on the bare shell beside it. High friction may pull it away from all taxels.
    pub fn covers(&self, contact: &SkinContact) -> bool {
        let reach = self.reach_m * self.reach_m;
        let mut taxels = self.centers_link.iter().zip(&self.normals_link);
        taxels.any(|(center, normal)| {
            is_pressed(*normal, contact.inward_link, contact.force_link)
                && center.distance_squared(contact.position_link) <= reach
        })
    }

    /// Spreads the contacts between this patch and one collision shape with the surface `object` over the taxels.
    /// `shape_pose` is the shape's pose in the link frame. The forces returned add up to those of the contacts. The
    /// contents of `buffers` do not matter.
    pub fn spread<'a>(
        &self,
        contacts: &[SkinContact],
        shape: &dyn Shape,
        shape_pose: &Pose,
        object: &Surface,
        buffers: &'a mut SpreadBuffers,
    ) -> &'a [TaxelForce] {
        buffers.forces.clear();
        let interface = self.surface.with(object);
        let total: DVec3 = contacts.iter().map(|contact| contact.force_link).sum();
        let load = |contact: &SkinContact| contact.force_link.dot(contact.inward_link).max(0.0);
        let normal_sum: DVec3 = contacts.iter().map(|contact| contact.inward_link * load(contact)).sum();
        let inward = normal_sum.normalize_or_zero();
        let weight: f64 = contacts.iter().map(load).sum();
        if weight <= 0.0 || inward == DVec3::ZERO {
            return &buffers.forces;
        }
        let center = contacts.iter().map(|contact| contact.position_link * load(contact)).sum::<DVec3>() / weight;
        let (across, along) = inward.any_orthonormal_pair();
        let view = View::new(shape_pose, center, [across, along, inward]);
        let SpreadBuffers { faces, cells, springs, near, taxels, .. } = &mut *buffers;
        let chords = Chords::new(shape, &view, faces);
        cells.clear();
        springs.clear();
        for (number, point) in self.nearby(contacts) {
            if !is_pressed(point.normal_link, inward, total) {
                continue;
            }
            let offset = point.position_link - center;
            let place = DVec2::new(offset.dot(across), offset.dot(along));
            // Beside the shape, the gap is the distance from it, because its edge drags the layer along.
            let surface_m = chords.and_then(|chords| chords.end_m(place, End::Leaves));
            let gap = surface_m.map_or_else(
                || signed_distance_m(shape, shape_pose, point.position_link),
                |surface_m| offset.dot(inward) - surface_m,
            );
            let stiffness = interface.stiffness_n_per_m3 * point.area_m2;
            springs.push(Spring { gap, place, stiffness, share: -point.normal_link.dot(inward) });
            cells.push(Cell { taxel: point.taxel, point: number, felt_share: point.felt_share, pressure_n: 0.0 });
        }
        taxels.clear();
        if let Some(pose) = indent(springs, near, &interface.layer, normal_sum.length()) {
            for (cell, spring) in cells.iter_mut().zip(springs) {
                let pressure = spring.stiffness * interface.layer.pressed(spring.depth(&pose)).0;
                cell.pressure_n = pressure;
                match taxels.last_mut() {
                    Some((taxel, sum, felt)) if *taxel == cell.taxel => {
                        *sum += pressure;
                        *felt += cell.felt_share * pressure;
                    }
                    _ => taxels.push((cell.taxel, pressure, cell.felt_share * pressure)),
                }
            }
        }
        taxels.retain(|(_, force, _)| *force > 0.0);
        if taxels.is_empty() {
            // No sub-point is indented, because the shape is too thin to sample or touches two faces of an edge. The
            // nearby taxel that faces the force most takes all of it, and feels what its nearest sub-point does.
            taxels.extend(self.facing_taxel(contacts, total).map(|(taxel, felt_share)| (taxel, 1.0, felt_share)));
        }
        self.balance(total, interface.friction, buffers);
        &buffers.forces
    }

    /// How the taxels feel the last forces that [`SkinPatch::spread`] wrote into these buffers: sub-points and the normal force
    /// on each, N. A taxel's force is divided among its sub-points in proportion to their pressures.
    pub fn felt_points<'a>(&'a self, buffers: &'a SpreadBuffers) -> impl Iterator<Item = (usize, f64)> + 'a {
        buffers.forces.iter().flat_map(move |force| {
            let cells = buffers.cells.iter().filter(|cell| cell.taxel == force.taxel && cell.pressure_n > 0.0);
            let pressed: f64 = cells.clone().map(|cell| cell.pressure_n).sum();
            // A contact between the sub-points is narrower than one, and any one of the taxel stands for it.
            let narrow = (pressed == 0.0)
                .then(|| (force.taxel * self.points_per_taxel(), force.normal_force_n * force.felt_share));
            let share = force.normal_force_n / pressed;
            cells.map(move |cell| (cell.point, share * cell.felt_share * cell.pressure_n)).chain(narrow)
        })
    }

    /// Scales the normal forces of the taxels and adds shear so that the vector sum is `total`.
    fn balance(&self, total: DVec3, friction: f64, buffers: &mut SpreadBuffers) {
        let SpreadBuffers { taxels, carriers, forces, .. } = buffers;
        let normal = |taxel: usize| self.normals_link[taxel];
        let pressed: DVec3 = taxels.iter().map(|(taxel, force, _)| -normal(*taxel) * *force).sum();
        let direction = pressed.normalize_or_zero();
        let scale = (total.dot(direction) / pressed.length()).max(0.0);
        let rest = total - pressed * scale;
        let tangent_plane = |taxel: usize, vector: DVec3| vector - normal(taxel) * normal(taxel).dot(vector);
        let mut carried = DMat3::ZERO;
        for (taxel, force, _) in taxels.iter() {
            for (column, axis) in DVec3::AXES.into_iter().enumerate() {
                *carried.col_mut(column) += tangent_plane(*taxel, axis) * *force;
            }
        }
        let shear = solve_symmetric(carried, rest);
        carriers.clear();
        carriers.extend(taxels.iter().map(|(taxel, force, _)| Carrier {
            inward: -normal(*taxel),
            weight_n: *force,
            force: tangent_plane(*taxel, shear) * *force - normal(*taxel) * (force * scale),
        }));
        // If that is impossible, the forces stay as they are.
        within_cones(carriers, friction, total);
        let carried = taxels.iter().zip(carriers).filter(|(_, carrier)| carrier.force != DVec3::ZERO);
        forces.extend(carried.map(|((taxel, pressed, felt), carrier)| {
            let normal_n = carrier.force.dot(carrier.inward);
            let shear_link = carrier.force - carrier.inward * normal_n;
            // Under high friction a taxel may carry shear alone. Rounding must not make it pull.
            let normal_force_n = if normal_n > 0.0 { normal_n } else { 0.0 };
            TaxelForce { taxel: *taxel, normal_force_n, shear_link, felt_share: felt / pressed }
        }));
    }

    /// The sub-points of the taxels near these contacts, with their indices.
    fn nearby<'a>(&'a self, contacts: &'a [SkinContact]) -> impl Iterator<Item = (usize, &'a SurfacePoint)> {
        let count = self.points_per_taxel();
        let taxels = self.sub_points.chunks_exact(count).zip(&self.centers_link).zip(&self.corners_m).enumerate();
        let near = taxels.filter(|(_, ((_, center), corner_m))| {
            contacts.iter().any(|contact| {
                let limit_m = contact.radius_m + **corner_m + SEARCH_MARGIN_M;
                center.distance_squared(contact.position_link) < limit_m * limit_m
            })
        });
        near.flat_map(move |(taxel, ((points, _), _))| (taxel * count..).zip(points))
    }

    /// All taxels have the same number of sub-points.
    fn points_per_taxel(&self) -> usize {
        (self.sub_points.len() / self.centers_link.len().max(1)).max(1)
    }

    /// Returns the taxel within reach of a contact that faces the force most. Among taxels with the same normal, as on a
    /// flat pad, it is the one nearest to a contact. The second number is what it feels of a force on its nearest sub-point.
    fn facing_taxel(&self, contacts: &[SkinContact], force_link: DVec3) -> Option<(usize, f64)> {
        let squared_distance = |position: DVec3| {
            let distances = contacts.iter().map(|contact| contact.position_link.distance_squared(position));
            distances.fold(f64::INFINITY, f64::min)
        };
        let nearest = |points: &[SurfacePoint]| {
            let distances = points.iter().map(|point| (squared_distance(point.position_link), point.felt_share));
            distances.fold((f64::INFINITY, 1.0), |least, other| if other.0 < least.0 { other } else { least })
        };
        let taxels = self.sub_points.chunks_exact(self.points_per_taxel()).enumerate();
        taxels
            .filter(|(taxel, _)| squared_distance(self.centers_link[*taxel]) <= self.reach_m * self.reach_m)
            .map(|(taxel, points)| (taxel, -self.normals_link[taxel].dot(force_link), nearest(points)))
            .max_by(|(_, a, near), (_, b, far)| a.total_cmp(b).then(far.0.total_cmp(&near.0)))
            .map(|(taxel, _, (_, felt_share))| (taxel, felt_share))
    }
}

/// Whether a contact with the inward normal `inward` presses on a place with this outward normal. With its friction, the force must
/// not pull there.
fn is_pressed(normal_link: DVec3, inward: DVec3, force_link: DVec3) -> bool {
    -normal_link.dot(inward) > FACING_COSINE && normal_link.dot(force_link) < 0.0
}

#[cfg(test)]
mod tests;
