//! One leaf that a forearm pushes aside at a constant speed until the blade slides off: this project's side of
//! `benches/peers/slide.py`.

use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use underbrush_recording::{BodyPart, BodyShape, Pose};
use underbrush_sim::arm::Arm;
use underbrush_sim::contact::surface::Surface;
use underbrush_sim::object::Listed;
use underbrush_sim::object::blade::{SHEET_TORSION_OVER_BENDING, root_stiffness_nm_per_rad};
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::scene::PhysicsSection;
use underbrush_sim::simulation::test_rig::{FreeBody, Rig};

/// The middle of the ranges that scene files have by default, in wet foam; `segments` is the number of bending hinges.
fn leaf(segments: u32) -> Leaf {
    Leaf {
        height_m: 0.325,
        width_m: 0.035,
        flexural_rigidity_n_m2: 0.0275,
        torsion_over_bending: SHEET_TORSION_OVER_BENDING,
        mass_per_area_kg_per_m2: 0.75,
        loss_factor: 0.15,
        yield_moment_nm: None,
        grip: None,
        root_stiffness_nm_per_rad: Some(root_stiffness_nm_per_rad(5.5e4, 0.04)),
        segments,
    }
}

/// Height of the forearm's middle over the foam, m.
const HEIGHT_M: f64 = 0.2;
/// Gap between the forearm's surface and the middle of the leaf at the start, m. It is large enough that a rotated leaf
/// is not touched at the start either.
const GAP_M: f64 = 0.02;
/// Distance that the forearm moves, m. The blade slips off before its end.
const WAY_M: f64 = 0.45;
/// Mass of the forearm, kg. Choice: a leaf slows it by less than 1e-5 of its speed.
const MASS_KG: f64 = 1e6;

/// How a leaf and a forearm meet.
pub struct Case {
    /// Number of the leaf's bending hinges.
    pub segments: u32,
    /// Rotation of the leaf about the vertical from where it faces the forearm, rad.
    pub rotation_rad: f64,
    /// Slope of the forearm's axis, rad; at zero the axis lies along y.
    pub slope_rad: f64,
    /// Speed of the forearm, m/s, along x.
    pub speed_m_per_s: f64,
    /// Whether the forearm has its skin; otherwise it is ten times as hard.
    pub has_skin: bool,
}

/// Moves Cody's forearm past the leaf in steps of `step_s`. Returns the bodies and joints at the start, and the force
/// on the forearm in each step. That force is derived from the change of the forearm's momentum, so it does not depend
/// on what the contact solver reports.
pub fn slide(case: &Case, step_s: f64) -> Value {
    let options = PhysicsOptions { step_s, ..PhysicsSection::default().options() };
    let arm = Arm::cody().expect("Cody's files are sound");
    let link = arm.link_index("forearm").expect("Cody has a forearm");
    let shape = arm.links[link].colliders[0].shape.clone();
    let BodyShape::Cylinder { radius_m, .. } = shape else {
        panic!("Cody's forearm is a cylinder");
    };
    let mut rig = Rig::new(options);
    let leaf = leaf(case.segments);
    rig.add_object_at(&leaf, DVec3::ZERO, case.rotation_rad);
    let axis = DVec3::new(0.0, case.slope_rad.cos(), case.slope_rad.sin());
    let start = DVec3::new(-radius_m - GAP_M, 0.0, HEIGHT_M);
    let velocity = DVec3::X * case.speed_m_per_s;
    let forearm = rig.add_free(&FreeBody {
        part: BodyPart { shape, pose_body: Pose::IDENTITY },
        mass_kg: MASS_KG,
        surface: if case.has_skin { arm.surface(link) } else { Surface::hard(arm.friction) },
        pose_world: Pose { position: start, orientation: DQuat::from_rotation_arc(DVec3::Z, axis) },
        velocity_world: velocity,
        may_rotate: false,
    });
    let forearm = forearm.expect("a forearm has a volume");
    let mut setup = crate::bodies_and_joints(&mut rig);
    let weight = DVec3::Z * (MASS_KG * options.gravity_m_per_s2);
    let mut before = velocity;
    let mut forces = Vec::new();
    for _ in 0..(WAY_M / case.speed_m_per_s / step_s).round() as usize {
        rig.push(forearm, weight, rig.center_of_mass_world(forearm), DVec3::ZERO);
        rig.step();
        let after = rig.velocity_world(forearm);
        forces.push(((after - before) * (MASS_KG / step_s)).to_array());
        before = after;
    }
    setup["leaf"] = json!(leaf.parameters());
    setup["start_m"] = json!(start.to_array());
    setup["speed_m_per_s"] = json!(case.speed_m_per_s);
    setup["force_world_n"] = json!(forces);
    setup
}
