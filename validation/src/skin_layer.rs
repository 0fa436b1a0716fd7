//! Check 10: the skin's elastic layer.

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};
use parry3d::shape::SharedShape;
use underbrush_oracles::foundation;
use underbrush_oracles::numeric::{bisected, log_log_slope};
use underbrush_recording::Pose;
use underbrush_sim::arm::skin::SurfacePoint;
use underbrush_sim::object::FRICTION;
use underbrush_sim::skin::{SkinContact, SkinPatch, SpreadBuffers};
use underbrush_sim::{Arm, Surface};

use crate::contact_law::layer;
use crate::pressed_arm::FOREARM_RADIUS_M;
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 10.
pub const CHECK: Check = Check {
    name: "skin-layer",
    summary: "A ball on flat skin and a trunk across the forearm are pressed in as deep as Winkler's foundation predicts",
    cases: &[
        Case { compare: ball_on_flat, falsifications: &[STIFF_LAYER, BOXED_SHAPE, ONE_POINT] },
        Case { compare: hardened, falsifications: &[STIFF_LIGHTLY, THICK_LAYER] },
        Case { compare: trunk_on_round, falsifications: &[STIFF_LAYER, BOXED_SHAPE] },
        Case { compare: forearm, falsifications: &[TURNED_TRUNK] },
    ],
};

const STIFF_LAYER: Falsification =
    Falsification::new("stiffness of the simulated layer", "20 % too high").breaking(&["at the depth under"]);
const STIFF_LIGHTLY: Falsification = STIFF_LAYER.breaking(&["under 2 N"]);
const THICK_LAYER: Falsification =
    Falsification::new("thickness of the simulated layer", "twice as large").breaking(&["under 20 N", "under 40 N"]);
const BOXED_SHAPE: Falsification =
    Falsification::new("shape pressed on the simulated skin", "its bounding box").breaking(&["exponent"]);
const ONE_POINT: Falsification =
    Falsification::new("points on each simulated taxel", "one instead of nine").breaking(&["order in the pitch"]);
const TURNED_TRUNK: Falsification =
    Falsification::new("axis of the simulated trunk", "along the forearm instead of across");

const STIFFNESS_N_PER_M3: f64 = 3e7;
const BALL_RADIUS_M: f64 = 0.05;
const THICKNESS_M: f64 = 3e-3;
const TRUNK_RADIUS_M: f64 = 0.015;
const PITCHES_M: [f64; 3] = [0.009, 0.0045, 0.002_25];
const FINEST_PITCH_M: f64 = 0.0015;

/// A shape pressed on a patch of skin of some pitch.
struct Pressed {
    /// The shape, which touches the skin at its origin and lies over it.
    shape: SharedShape,
    /// Height of the shape's middle over the skin, m.
    height_m: f64,
    /// Radius to which the skin is bent, m.
    skin_radius_m: f64,
    /// Thickness of the layer, m, if it hardens.
    thickness_m: Option<f64>,
    simulated: Simulated,
}

fn ball_on_flat(simulated: Simulated) -> Found {
    let shape = boxed(SharedShape::ball(BALL_RADIUS_M), simulated);
    let pressed = Pressed { shape, height_m: BALL_RADIUS_M, skin_radius_m: 1e9, thickness_m: None, simulated };
    Ok(fine_skin("ball on flat skin", &pressed, |depth_m| foundation::cap_volume_m3(BALL_RADIUS_M, depth_m)))
}

fn trunk_on_round(simulated: Simulated) -> Found {
    let shape = boxed(SharedShape::capsule_y(0.3, TRUNK_RADIUS_M), simulated);
    let (height_m, skin_radius_m) = (TRUNK_RADIUS_M, FOREARM_RADIUS_M);
    let pressed = Pressed { shape, height_m, skin_radius_m, thickness_m: None, simulated };
    Ok(fine_skin("trunk across round skin", &pressed, |depth_m| {
        foundation::crossed_volume_m3([TRUNK_RADIUS_M, FOREARM_RADIUS_M], depth_m)
    }))
}

/// A ball on flat skin that hardens, so hard that the skin under it is pressed by two thirds of its thickness.
fn hardened(simulated: Simulated) -> Found {
    let layer = layer(STIFFNESS_N_PER_M3, THICKNESS_M);
    let shape = SharedShape::ball(BALL_RADIUS_M);
    let thickness_m = Some(THICKNESS_M * simulated.with(THICK_LAYER, 1.0, 2.0));
    let pressed = Pressed { shape, height_m: BALL_RADIUS_M, skin_radius_m: 1e9, thickness_m, simulated };
    let compare = |force_n: f64| {
        let depth_m = layer.depth_m(pressed.pressure_pa(FINEST_PITCH_M, force_n));
        let name = format!("ball on skin that hardens, 2π R ∫ p dh at the depth under {force_n} N");
        Comparison::of(name, "N", force_n, layer.force_n([BALL_RADIUS_M, BALL_RADIUS_M], depth_m))
            .relative(0.05, "5 %: a taxel averages the pressure over its area; d / R for the ball")
    };
    Ok([2.0, 20.0, 40.0].map(compare).into())
}

fn boxed(shape: SharedShape, simulated: Simulated) -> SharedShape {
    let half = shape.compute_local_aabb().half_extents();
    simulated.with(BOXED_SHAPE, shape, SharedShape::cuboid(half.x, half.y, half.z))
}

/// Force over depth of a shape pressed on skin of fine pitch, and how the error falls with the pitch.
fn fine_skin(name: &str, pressed: &Pressed, overlap_m3: impl Fn(f64) -> f64) -> Vec<Comparison> {
    let law = |depth_m: f64| STIFFNESS_N_PER_M3 * overlap_m3(depth_m);
    let [light, heavy] = [0.5, 2.0].map(|force_n| {
        let quantity = format!("{name}, k times the overlap's volume at the depth under {force_n} N");
        Comparison::of(quantity, "N", force_n, law(pressed.depth_m(FINEST_PITCH_M, force_n)))
            .relative(0.05, "5 %: a taxel averages the pressure over its area")
    });
    let forces = [0.5, 1.0, 2.0, 4.0].map(|force_n| (pressed.depth_m(FINEST_PITCH_M, force_n), force_n));
    let quantity = format!("{name}, exponent of force over depth");
    let exponent = Comparison::of(quantity, "", 2.0, log_log_slope(&forces))
        .absolute(0.05, "0.05: the same, over a factor of three in depth");
    let exact = bisected([0.0, 0.01], 60, |depth_m| law(depth_m) < 2.0);
    let misses = PITCHES_M.map(|pitch_m| (pitch_m, (pressed.depth_m(pitch_m, 2.0) / exact - 1.0).abs()));
    let quantity = format!("{name}, order in the pitch of the depth's error");
    let reason = "0.2: fit of a straight line on a log-log scale; the mean pressure over a taxel of side p is too low by \
                  k p² / 24 (1/R₁ + 1/R₂)";
    let order = Comparison::of(quantity, "", 2.0, log_log_slope(&misses)).absolute(0.2, reason);
    vec![light, heavy, exponent, order]
}

impl Pressed {
    /// Depth to which the shape presses into a linear patch at its origin, m.
    fn depth_m(&self, pitch_m: f64, force_n: f64) -> f64 {
        self.pressure_pa(pitch_m, force_n) / STIFFNESS_N_PER_M3
    }

    /// The pressure on the taxel with the largest force, Pa.
    fn pressure_pa(&self, pitch_m: f64, force_n: f64) -> f64 {
        let pose = Pose::from_position(DVec3::Z * self.height_m);
        let stiffness = STIFFNESS_N_PER_M3 * self.simulated.with(STIFF_LAYER, 1.0, 1.2);
        let points = self.simulated.with(ONE_POINT, 3, 1);
        let mut patch = patch(stiffness, pitch_m, self.skin_radius_m, points);
        patch.surface.thickness_m = self.thickness_m;
        largest_force_n(&patch, [DVec3::ZERO, DVec3::Z], force_n, &self.shape, &pose) / (pitch_m * pitch_m)
    }
}

/// The largest force on a taxel, N, of a patch on which a hard shape presses with `force_n` at a place, against the outward
/// normal there.
fn largest_force_n(
    patch: &SkinPatch,
    [position_link, outward]: [DVec3; 2],
    force_n: f64,
    shape: &SharedShape,
    pose: &Pose,
) -> f64 {
    let force_link = outward * -force_n;
    let contact = SkinContact { position_link, inward_link: -outward, force_link, radius_m: 0.02 };
    let (hard, mut buffers) = (Surface::hard(FRICTION), SpreadBuffers::default());
    let forces = patch.spread(&[contact], shape.as_ref(), pose, &hard, &mut buffers);
    forces.iter().map(|force| force.normal_force_n).fold(0.0, f64::max)
}

/// A square of skin, 6 cm wide, bent about x with the given radius, one taxel in its middle at the origin, with
/// `points` by `points` points on each taxel.
fn patch(stiffness_n_per_m3: f64, pitch_m: f64, radius_m: f64, points: u32) -> SkinPatch {
    let half = (0.03 / pitch_m).ceil() as i32;
    let places = (-half..=half).flat_map(|i| (-half..=half).map(move |j| [f64::from(i), f64::from(j)]));
    let places: Vec<[f64; 2]> = places.map(|place| place.map(|index| index * pitch_m)).collect();
    // Position and normal of the skin at `x` along its axis and at `arc` around it.
    let surface = move |x: f64, arc: f64| {
        let (sin, cos) = (arc / radius_m).sin_cos();
        let drop = 2.0 * radius_m * (arc / radius_m / 2.0).sin().powi(2);
        (DVec3::new(x, radius_m * sin, -drop), DVec3::new(0.0, sin, cos))
    };
    let side_m = pitch_m / f64::from(points);
    let offset = move |index: u32| (f64::from(index) + 0.5) * side_m - pitch_m / 2.0;
    let points = places.iter().enumerate().flat_map(|(taxel, [x, arc])| {
        let offsets = (0..points).flat_map(move |i| (0..points).map(move |j| (offset(i), offset(j))));
        offsets.map(move |(along, across)| {
            let (position_link, normal_link) = surface(x + along, arc + across);
            SurfacePoint { taxel, position_link, normal_link, area_m2: side_m * side_m, felt_share: 1.0 }
        })
    });
    SkinPatch {
        link: 0,
        sub_points: points.collect(),
        centers_link: places.iter().map(|[x, arc]| surface(*x, *arc).0).collect(),
        normals_link: places.iter().map(|[x, arc]| surface(*x, *arc).1).collect(),
        corners_m: vec![pitch_m * std::f64::consts::FRAC_1_SQRT_2; places.len()],
        reach_m: pitch_m,
        surface: Surface { compliance_m3_per_n: 1.0 / stiffness_n_per_m3, ..Surface::hard(FRICTION) },
    }
}

/// A trunk across the forearm's real skin: the largest taxel force, compared with the integral of Winkler's pressure
/// over that taxel.
fn forearm(simulated: Simulated) -> Found {
    let arm = Arm::cody()?;
    let stiffness = arm.skin.stiffness_n_per_m3;
    let link = arm.link_index("forearm");
    let index = arm.skin.surfaces.iter().position(|surface| Some(surface.link) == link);
    let Some(index) = index else { return Err(Fault::Run("no skin on the forearm".into())) };
    let mut patch = SkinPatch::of_arm(&arm).swap_remove(index);
    // The integral over each taxel is that of a linear layer.
    patch.surface.thickness_m = None;
    let taxels = &arm.skin.layout.patches[index].taxels;
    let middle = &taxels[taxels.len() / 2];
    let (along, outward) = (middle.tangent_link, middle.normal_link);
    let around = outward.cross(along);
    let compare = |force_n: f64| -> Result<Comparison, Fault> {
        // A third of the way to the next taxel along the forearm, so that nothing is symmetric.
        let touched = middle.position_link + along * 0.003;
        let trunk = SharedShape::capsule_y(0.3, TRUNK_RADIUS_M);
        let rotation = glam::DQuat::from_rotation_arc(DVec3::Y, simulated.with(TURNED_TRUNK, around, along));
        let pose = Pose::new(touched + outward * TRUNK_RADIUS_M, rotation);
        let place = |position: DVec3, normal: DVec3| {
            let angle_rad = normal.dot(around).atan2(normal.dot(outward));
            [(position - touched).dot(along), angle_rad * FOREARM_RADIUS_M]
        };
        let places: Vec<[f64; 2]> = taxels.iter().map(|taxel| place(taxel.position_link, taxel.normal_link)).collect();
        let side_m = middle.area_m2.sqrt();
        let radii_m = [TRUNK_RADIUS_M, FOREARM_RADIUS_M];
        let expected = taxel_forces_n(stiffness, radii_m, &places, side_m, force_n);
        let quantity = format!("trunk across the forearm at {force_n} N, largest taxel");
        let found_n = largest_force_n(&patch, [touched, outward], force_n, &trunk, &pose);
        Ok(Comparison::of(quantity, "N", expected.into_iter().fold(0.0, f64::max), found_n)
            .relative(0.05, "5 %: sixteen points per taxel, and terms of order d / R, which the law neglects"))
    };
    [2.0, 9.0].into_iter().map(compare).collect()
}

/// Winkler's pressure integrated over each square taxel, N, under a trunk with such a depth and tilt that the taxels
/// carry `force_n` and no moment about the contact. The gaps between the taxels carry nothing.
fn taxel_forces_n(stiffness: f64, radii_m: [f64; 2], places: &[[f64; 2]], side_m: f64, force_n: f64) -> Vec<f64> {
    const FINE: i32 = 15;
    let spacing = side_m / f64::from(FINE);
    let offset = |index: i32| (f64::from(index) + 0.5) * spacing - side_m / 2.0;
    let modulus = stiffness * spacing * spacing;
    // For each fine square of a taxel: (1, x, y), and its pressure at a pose (depth, tilts).
    let fine = |place: &[f64; 2]| {
        let [x, y] = *place;
        (0..FINE)
            .flat_map(|i| (0..FINE).map(move |j| (i, j)))
            .map(move |(i, j)| Vector3::new(1.0, x + offset(i), y + offset(j)))
    };
    let overlap = |square: &Vector3<f64>, pose: &Vector3<f64>| {
        let gap = square[1].powi(2) / (2.0 * radii_m[0]) + square[2].powi(2) / (2.0 * radii_m[1]);
        (square.dot(pose) - gap).max(0.0)
    };
    let mut pose = Vector3::new(foundation::depth_m(stiffness, radii_m, force_n), 0.0, 0.0);
    for _ in 0..50 {
        let (mut missing, mut slope) = (Vector3::new(-force_n, 0.0, 0.0), Matrix3::zeros());
        for square in places.iter().flat_map(fine) {
            let pressed = overlap(&square, &pose);
            if pressed > 0.0 {
                missing += square * (modulus * pressed);
                slope += square * square.transpose() * modulus;
            }
        }
        let Some(step) = slope.lu().solve(&missing) else { break };
        pose -= step;
    }
    let force = |place: &[f64; 2]| fine(place).map(|square| modulus * overlap(&square, &pose)).sum();
    places.iter().map(force).collect()
}
