//! What the skin feels in one frame: solver contacts → taxel forces → sensed values, with their ground truth.

use std::collections::BTreeMap;

use glam::DVec3;
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::{SkinLayout, TaxelReading};

use crate::sensor::Sensor;
use crate::skin::{ContactPoint, SkinPatch};
use crate::world::World;

/// Two things that press on each other: a patch, or the part of a link without skin, and an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pair {
    /// The patch, `None` for the part of the link without skin.
    pub patch: Option<u16>,
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter.
    pub object: u16,
}

/// The force between one link, with or without skin, and one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkForce {
    /// The link, index in the arm.
    pub link: u16,
    /// The object, index in the clutter.
    pub object: u16,
    /// The patch that feels most of it, `None` where most of it falls on the part without skin.
    pub patch: Option<u16>,
    /// Its magnitude, N.
    pub force_n: f64,
}

/// What arm and skin feel in one frame.
#[derive(Clone, Debug, Default)]
pub struct Touch {
    /// Taxels that feel or report anything, sorted by patch, then taxel.
    pub taxels: Vec<TaxelReading>,
    /// Sum of the solver's contact forces on each patch, N, world frame.
    pub contact_force_world: Vec<DVec3>,
    /// Force between each pair in contact, N, world frame.
    pub pairs: BTreeMap<Pair, DVec3>,
    /// Largest relative difference, over the patches, between the vector sum of the taxel forces and the solver's.
    pub force_residual: f64,
    /// Largest difference, over the patches, between the moment of the taxel forces, each at its taxel's centre, and
    /// that of the solver's contacts, over the sum of the contacts' magnitudes, m.
    pub moment_residual_m: f64,
}

impl Touch {
    /// The largest force between one link and one object, `None` where nothing touches the arm.
    pub fn largest_force(&self) -> Option<LinkForce> {
        // Between the same two bodies, forces on skin and beside it add up.
        let mut bodies: BTreeMap<(u16, u16), (DVec3, Option<u16>, f64)> = BTreeMap::new();
        for (pair, force) in &self.pairs {
            let part_n = force.length();
            let (sum, patch, largest_part_n) = bodies.entry((pair.link, pair.object)).or_default();
            *sum += *force;
            if part_n > *largest_part_n {
                (*patch, *largest_part_n) = (pair.patch, part_n);
            }
        }
        let forces = bodies.into_iter().map(|((link, object), (sum, patch, _))| LinkForce {
            link,
            object,
            patch,
            force_n: sum.length(),
        });
        forces.max_by(|a, b| a.force_n.total_cmp(&b.force_n))
    }
}

/// True force on one taxel, summed over the objects on it.
#[derive(Default)]
struct Load {
    normal_n: f64,
    shear_link: DVec3,
    /// Normal force by object, N; an object of several collision shapes, as a leaf is, has one sum.
    normal_n_by_object: BTreeMap<u16, f64>,
}

impl Load {
    fn add(&mut self, object: u16, normal_n: f64, shear_link: DVec3) {
        self.normal_n += normal_n;
        self.shear_link += shear_link;
        *self.normal_n_by_object.entry(object).or_default() += normal_n;
    }

    /// The object that presses most; of equals the first of the clutter.
    fn object(&self) -> Option<u16> {
        let objects = self.normal_n_by_object.iter().rev();
        objects.max_by(|a, b| a.1.total_cmp(b.1)).map(|(object, _)| *object)
    }
}

/// Contact points between one patch and one collision shape.
struct Group {
    object: u16,
    collider: ColliderHandle,
    points: Vec<ContactPoint>,
}

/// Reads the skin of the world as it stands.
pub fn feel(world: &World, layout: &SkinLayout, patches: &[SkinPatch], sensor: &mut Sensor) -> Touch {
    let mut touch = Touch {
        contact_force_world: vec![DVec3::ZERO; patches.len()],
        ..Touch::default()
    };
    let mut wrenches = vec![Wrench::default(); patches.len()];
    let mut groups: BTreeMap<(usize, (u32, u32)), Group> = BTreeMap::new();
    for contact in world.contacts() {
        let object = contact.object as u16;
        let pose = world.link_pose(contact.link);
        let point = contact.in_link_frame(&pose);
        let patch = patches
            .iter()
            .position(|patch| patch.link == contact.link && patch.covers(&point));
        let pair = Pair {
            patch: patch.map(|patch| patch as u16),
            link: contact.link as u16,
            object,
        };
        *touch.pairs.entry(pair).or_default() += contact.force_world;
        if let Some(patch) = patch {
            touch.contact_force_world[patch] += contact.force_world;
            wrenches[patch].add(point.position_link, point.force_link);
            let group = groups
                .entry((patch, contact.collider.into_raw_parts()))
                .or_insert_with(|| Group {
                    object,
                    collider: contact.collider,
                    points: Vec::new(),
                });
            group.points.push(point);
        }
    }
    let mut loads: BTreeMap<(usize, usize), Load> = BTreeMap::new();
    for ((patch, _), group) in &groups {
        let skin = &patches[*patch];
        let shape = &world.physics.colliders[group.collider];
        let compliance = world.surface_compliance_m3_per_n(usize::from(group.object));
        let shape_pose = world.link_pose(skin.link).inverse() * *shape.position();
        for force in skin.spread_under(&group.points, shape.shape(), &shape_pose, compliance) {
            let load = loads.entry((*patch, force.taxel)).or_default();
            load.add(group.object, force.normal_force_n, force.shear_link);
        }
    }
    for ((patch, taxel), load) in &loads {
        sensor.press(*patch, *taxel, load.normal_n);
    }
    sensor.sample();
    let [force, moment] = residuals(patches, &loads, &wrenches);
    (touch.force_residual, touch.moment_residual_m) = (force, moment);
    for (patch, described) in layout.patches.iter().enumerate() {
        for (taxel, place) in described.taxels.iter().enumerate() {
            let load = loads.get(&(patch, taxel));
            let true_normal_force_n = load.map_or(0.0, |load| load.normal_n);
            let sensed_force_n = sensor.reading_n(patch, taxel);
            let shear = load.map_or(DVec3::ZERO, |load| load.shear_link);
            if load.is_none() && sensed_force_n == 0.0 {
                continue;
            }
            touch.taxels.push(TaxelReading {
                patch: patch as u16,
                taxel: taxel as u16,
                true_normal_force_n,
                true_shear_force_n: [
                    shear.dot(place.tangent_link),
                    shear.dot(place.normal_link.cross(place.tangent_link)),
                ],
                sensed_force_n,
                object: load.and_then(Load::object),
            });
        }
    }
    touch
}

/// A patch's forces, summed up in its link's frame.
#[derive(Clone, Copy, Default)]
struct Wrench {
    force: DVec3,
    moment: DVec3,
    magnitude: f64,
}

impl Wrench {
    fn add(&mut self, position: DVec3, force: DVec3) {
        self.force += force;
        self.moment += position.cross(force);
        self.magnitude += force.length();
    }
}

/// The largest differences between taxels and solver over the patches: of force, relative; of moment, m.
fn residuals(patches: &[SkinPatch], loads: &BTreeMap<(usize, usize), Load>, solver: &[Wrench]) -> [f64; 2] {
    let mut felt = vec![Wrench::default(); patches.len()];
    for ((patch, taxel), load) in loads {
        let skin = &patches[*patch];
        let force = load.shear_link - skin.normals_link[*taxel] * load.normal_n;
        felt[*patch].add(skin.centers_link[*taxel], force);
    }
    let pairs = felt.iter().zip(solver);
    pairs.fold([0.0, 0.0], |[force, moment], (felt, solver)| {
        // Under a micronewton there is no contact to speak of.
        let missing = (felt.force - solver.force).length() / solver.force.length().max(1e-6);
        let turned = (felt.moment - solver.moment).length() / solver.magnitude.max(1e-6);
        [force.max(missing), moment.max(turned)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm::Arm;
    use crate::clutter::{Clutter, Standing};
    use crate::object::{Object, leaf::Leaf, trunk::Trunk};
    use crate::physics::PhysicsOptions;
    use crate::sensor::SensorOptions;
    use nalgebra::DVector;

    /// The arm pressed for `seconds` against one object at the left of its forearm by equilibrium angles that would
    /// press with `force_n` (N) if nothing moved.
    fn press(object: Box<dyn Object>, gap_m: f64, force_n: f64, seconds: f64) -> (Arm, World, Vec<f64>, Touch) {
        let arm = Arm::cody().unwrap();
        let posture = arm.start_posture_rad();
        let poses = arm.forward_kinematics(&posture);
        let forearm = arm.link_index("forearm").unwrap();
        let place = poses[forearm].transform_point(DVec3::new(0.0, 0.0, 0.10));
        let foot_world = (place + DVec3::Y * (0.04604 + gap_m)).with_z(place.z - 0.3);
        let objects = vec![Standing {
            object,
            foot_world,
            yaw_rad: std::f64::consts::FRAC_PI_2,
        }];
        let clutter = Clutter {
            objects,
            goals: Vec::new(),
        };
        let options = PhysicsOptions {
            step_s: 0.005,
            substeps: 4,
            gravity_m_per_s2: 9.81,
        };
        let mut world = World::new(&arm, &posture, &clutter, options, false);
        let jacobian = arm.position_jacobian(&poses, forearm, place);
        let torque = jacobian.transpose() * nalgebra::Vector3::new(0.0, force_n, 0.0);
        let equilibrium: Vec<f64> = (0..posture.len())
            .map(|joint| posture[joint] + torque[joint] / arm.joints[joint].stiffness_nm_per_rad)
            .collect();
        for _ in 0..(seconds / crate::world::FRAME_PERIOD_S) as usize {
            world.advance_frame(&arm, &equilibrium, &clutter);
            world.audit_frame(&arm, &Touch::default());
        }
        let options = SensorOptions {
            perfect: true,
            ..SensorOptions::default()
        };
        let mut sensor = Sensor::new(&options, &arm.skin, 0, "test", 0);
        let touch = feel(&world, &arm.skin.layout, &SkinPatch::of_arm(&arm), &mut sensor);
        (arm, world, equilibrium, touch)
    }

    fn largest_force_n(touch: &Touch) -> f64 {
        touch.largest_force().map_or(0.0, |force| force.force_n)
    }

    fn trunk() -> Box<dyn Object> {
        Box::new(Trunk {
            diameter_m: 0.03,
            height_m: 0.6,
        })
    }

    /// Pins that a taxel's object is the one that presses most in sum: two pieces of a leaf outdo a trunk that presses harder
    /// than either, and of equals the first is named.
    #[test]
    fn a_taxel_names_the_object_that_presses_most_in_sum() {
        let mut load = Load::default();
        assert_eq!(load.object(), None);
        let (leaf, trunk) = (7, 2);
        load.add(leaf, 0.3, DVec3::X);
        load.add(trunk, 0.4, DVec3::ZERO);
        assert_eq!(load.object(), Some(trunk));
        load.add(leaf, 0.3, DVec3::Y);
        assert_eq!(load.object(), Some(leaf));
        assert!((load.normal_n - 1.0).abs() < 1e-15 && load.shear_link == DVec3::new(1.0, 1.0, 0.0));
        load.add(trunk, 0.2, DVec3::ZERO);
        assert_eq!(load.object(), Some(trunk));
    }

    /// Pins the force that a stop force is held against: that between one link and one object, skin and bare parts together;
    /// forces of other links or other objects are not added, and the patch named is the one that feels most of it.
    #[test]
    fn forces_add_up_by_link_and_object() {
        let pair = |patch, link, object| Pair { patch, link, object };
        let touch = |pairs: &[(Pair, DVec3)]| Touch {
            pairs: pairs.iter().copied().collect(),
            ..Touch::default()
        };
        assert_eq!(Touch::default().largest_force(), None);
        let found = touch(&[
            (pair(Some(0), 3, 5), DVec3::X * 60.0),
            (pair(None, 3, 5), DVec3::X * 50.0),
            (pair(Some(1), 4, 5), DVec3::X * 90.0),
            (pair(None, 3, 6), DVec3::X * 100.0),
        ]);
        let expected = LinkForce {
            link: 3,
            object: 5,
            patch: Some(0),
            force_n: 110.0,
        };
        assert_eq!(found.largest_force(), Some(expected));
        let bare = touch(&[
            (pair(Some(0), 3, 5), DVec3::X * 3.0),
            (pair(None, 3, 5), DVec3::Y * 4.0),
        ]);
        let expected = LinkForce {
            patch: None,
            force_n: 5.0,
            ..expected
        };
        assert_eq!(bare.largest_force(), Some(expected));
    }

    /// Pins that contact forces balance the joints' springs, K (φ − q) = −Σ Jᵀ f, to 1e-3 once the arm is at rest, and
    /// that taxels add up to them to 1e-9.
    #[test]
    fn springs_balance_contact_forces() {
        for force in [2.0, 9.0] {
            let (arm, world, equilibrium, touch) = press(trunk(), 0.017, force, 8.0);
            let angle = world.arm.joint_angle_rad(&world.physics);
            let poses = arm.forward_kinematics(&angle);
            let spring: Vec<f64> = (0..angle.len())
                .map(|joint| arm.joints[joint].stiffness_nm_per_rad * (equilibrium[joint] - angle[joint]))
                .collect();
            let spring = DVector::from_vec(spring);
            let mut contact = DVector::zeros(angle.len());
            for at in world.contacts() {
                let force = nalgebra::Vector3::from(at.force_world.to_array());
                let position = poses[at.link].transform_point(at.position_link);
                contact += arm.position_jacobian(&poses, at.link, position).transpose() * force;
            }
            assert!(contact.norm() > 0.1 * force, "no contact: {contact}");
            let residual = (&spring + &contact).norm() / spring.norm();
            assert!(
                residual < 1e-3,
                "relative residual {residual} at {force} N: {spring} {contact}"
            );
            let audit = world.auditor.audit();
            // The weaker push turns the joints with 0.3 Nm: too little for the audit to count.
            assert!(
                (audit.rest_frames > 0) == (force > 5.0) && audit.largest_static_residual < 0.05,
                "{audit:?}"
            );
            assert!(
                touch.force_residual < 1e-9,
                "taxels miss the solver's force by {}",
                touch.force_residual
            );
        }
    }

    /// Pins that a trunk lights a patch of taxels of the size of a stored frame of the real skin (nine newtons on
    /// 4 × 2 taxels of 0.6–1.5 N), and that more force lights no fewer.
    #[test]
    fn a_broad_contact_lights_a_patch() {
        let lit = |force: f64| {
            let (.., touch) = press(trunk(), 0.017, force, 8.0);
            touch
                .taxels
                .iter()
                .filter(|taxel| taxel.true_normal_force_n > 0.02)
                .count()
        };
        let (few, many) = (lit(3.0), lit(12.0));
        assert!(
            (2..=12).contains(&few) && few <= many && many <= 24,
            "{few} taxels at 3 N, {many} at 12 N"
        );
    }

    /// Pins that an arm that starts 5 mm deep in a trunk is pushed out: the contact's 1e4 N/m give some 50 N at first, not
    /// a throw, and after two seconds the arm rests against the trunk on its springs.
    #[test]
    fn an_arm_that_starts_in_contact_is_pushed_out() {
        // Too low for the upper arm, which cannot give way there.
        let trunk = Trunk {
            diameter_m: 0.03,
            height_m: 0.34,
        };
        let (_, world, _, touch) = press(Box::new(trunk), 0.010, 0.0, 2.0);
        let audit = world.auditor.audit();
        assert!(audit.largest_frame_force_jump_n < 100.0, "{audit:?}");
        let force = largest_force_n(&touch);
        // 5 mm against the arm's 0.1–0.5 kN/m.
        assert!((0.1..10.0).contains(&force), "{force} N");
    }

    /// Pins that a leaf gives way where a trunk does not: the same push, a tenth of the force.
    #[test]
    fn a_leaf_pushes_back_less_than_a_trunk() {
        let leaf = Leaf {
            height_m: 0.4,
            width_m: 0.03,
            flexural_rigidity_n_m2: 0.02,
            mass_per_area_kg_per_m2: 0.8,
            loss_factor: 0.1,
            root_stiffness_nm_per_rad: Some(2.0),
            segments: 8,
        };
        let (.., soft) = press(Box::new(leaf), 0.005, 6.0, 4.0);
        let (.., hard) = press(trunk(), 0.017, 6.0, 4.0);
        assert!(largest_force_n(&soft) > 0.01, "the leaf was not touched");
        assert!(
            largest_force_n(&soft) < 0.3 * largest_force_n(&hard),
            "{} N, {} N",
            largest_force_n(&soft),
            largest_force_n(&hard)
        );
    }
}
