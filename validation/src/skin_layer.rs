//! Check 10: the skin's elastic layer.

use glam::DVec3;
use rapier3d::prelude::{Pose, SharedShape};
use underbrush_oracles::{foundation, order};
use underbrush_sim::arm::Arm;
use underbrush_sim::skin::{ContactPoint, SkinPatch, SubPoint};

use crate::pressed_arm::FOREARM_RADIUS_M;
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 10.
pub const CHECK: Check = Check {
    number: 10,
    name: "skin-layer",
    summary: "A ball on flat skin and a trunk across the forearm press as Winkler's layer says",
    falsification: "stiffness of the simulated layer 20 % too high",
    compare,
};

const STIFFNESS_N_PER_M3: f64 = 3e7;
const BALL_RADIUS_M: f64 = 0.05;
const TRUNK_RADIUS_M: f64 = 0.015;
const PITCHES_M: [f64; 3] = [0.009, 0.0045, 0.002_25];
const FINEST_PITCH_M: f64 = 0.0015;

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let stiffness = STIFFNESS_N_PER_M3 * simulated.with(1.0, 1.2);
    let mut comparisons = fine_skin("ball on flat skin", &ball_on_flat(stiffness), [BALL_RADIUS_M; 2]);
    let radii = [TRUNK_RADIUS_M, FOREARM_RADIUS_M];
    comparisons.extend(fine_skin("trunk across round skin", &trunk_on_round(stiffness), radii));
    comparisons.extend(forearm(simulated)?);
    Ok(comparisons)
}

/// A case of a shape pressed on skin: pitch, m, and force, N, to depth, m.
type Depth = dyn Fn(f64, f64) -> f64;

fn ball_on_flat(stiffness_n_per_m3: f64) -> Box<Depth> {
    Box::new(move |pitch_m, force_n| {
        let pose = Pose::from_translation(DVec3::Z * BALL_RADIUS_M);
        let ball = SharedShape::ball(BALL_RADIUS_M);
        depth_m(&patch(stiffness_n_per_m3, pitch_m, 1e9), &ball, &pose, pitch_m, force_n)
    })
}

fn trunk_on_round(stiffness_n_per_m3: f64) -> Box<Depth> {
    Box::new(move |pitch_m, force_n| {
        let pose = Pose::from_translation(DVec3::Z * TRUNK_RADIUS_M);
        let trunk = SharedShape::capsule_y(0.3, TRUNK_RADIUS_M);
        let skin = patch(stiffness_n_per_m3, pitch_m, FOREARM_RADIUS_M);
        depth_m(&skin, &trunk, &pose, pitch_m, force_n)
    })
}

/// Force over depth of a shape pressed on skin of fine pitch, and how the error falls with the pitch.
fn fine_skin(name: &str, depth: &Depth, radii_m: [f64; 2]) -> Vec<Comparison> {
    let law = |depth_m: f64| foundation::crossed_cylinders_force_n(STIFFNESS_N_PER_M3, radii_m, depth_m);
    let mut comparisons: Vec<Comparison> = [0.5, 2.0]
        .map(|force_n| {
            Comparison::relative(
                format!("{name}, π k √(R₁R₂) d² of the depth at {force_n} N"),
                "N",
                force_n,
                law(depth(FINEST_PITCH_M, force_n)),
                0.05,
                "5 %: terms of the order d / R, left out by the law, and the mean of pressure over a taxel",
            )
        })
        .into();
    let forces: Vec<(f64, f64)> = [0.5, 1.0, 2.0, 4.0]
        .map(|force_n| (depth(FINEST_PITCH_M, force_n), force_n))
        .into();
    comparisons.push(Comparison::absolute(
        format!("{name}, exponent of force over depth"),
        "",
        2.0,
        order::log_log_slope(&forces),
        0.05,
        "0.05: the same, over a factor of three in depth",
    ));
    let exact = foundation::depth_m(STIFFNESS_N_PER_M3, radii_m, 2.0);
    let miss = |pitch_m: f64| (depth(pitch_m, 2.0) / exact - 1.0).abs();
    for pair in PITCHES_M.windows(2) {
        comparisons.push(Comparison::at_most(
            format!(
                "{name}, error at {} mm pitch over that at {} mm",
                1e3 * pair[1],
                1e3 * pair[0]
            ),
            "",
            1.0,
            miss(pair[1]) / miss(pair[0]),
            1e-9,
            "no more than 1: the error falls with the pitch",
        ));
    }
    comparisons
}

/// Depth to which a shape presses into a patch at its origin, read from its most pressed taxel, m.
fn depth_m(patch: &SkinPatch, shape: &SharedShape, pose: &Pose, pitch_m: f64, force_n: f64) -> f64 {
    let contact = ContactPoint {
        position_link: DVec3::ZERO,
        inward_link: -DVec3::Z,
        force_link: DVec3::Z * -force_n,
    };
    let forces = patch.spread(&[contact], shape.as_ref(), pose);
    let largest = forces.iter().map(|force| force.normal_force_n).fold(0.0, f64::max);
    largest / (pitch_m * pitch_m) / STIFFNESS_N_PER_M3
}

/// A square of skin, 6 cm wide, bent about x with the given radius, one taxel in its middle at the origin.
fn patch(stiffness_n_per_m3: f64, pitch_m: f64, radius_m: f64) -> SkinPatch {
    let half = (0.03 / pitch_m).ceil() as i32;
    let places = (-half..=half).flat_map(|i| (-half..=half).map(move |j| [f64::from(i), f64::from(j)]));
    let places: Vec<[f64; 2]> = places.map(|place| place.map(|index| index * pitch_m)).collect();
    // Along x, and around the axis by an arc.
    let surface = move |x: f64, arc: f64| {
        let (sin, cos) = (arc / radius_m).sin_cos();
        let drop = 2.0 * radius_m * (arc / radius_m / 2.0).sin().powi(2);
        (DVec3::new(x, radius_m * sin, -drop), DVec3::new(0.0, sin, cos))
    };
    let thirds = [-1.0, 0.0, 1.0].map(|share| share * pitch_m / 3.0);
    let points = places.iter().enumerate().flat_map(|(taxel, [x, arc])| {
        let offsets = thirds
            .into_iter()
            .flat_map(move |along| thirds.map(|across| (along, across)));
        offsets.map(move |(along, across)| {
            let (position_link, normal_link) = surface(x + along, arc + across);
            SubPoint {
                taxel,
                position_link,
                normal_link,
                area_m2: pitch_m * pitch_m / 9.0,
            }
        })
    });
    SkinPatch {
        friction: 0.35,
        link: 0,
        sub_points: points.collect(),
        centers_link: places.iter().map(|[x, arc]| surface(*x, *arc).0).collect(),
        normals_link: places.iter().map(|[x, arc]| surface(*x, *arc).1).collect(),
        reach_m: pitch_m,
        stiffness_n_per_m3,
    }
}

/// A trunk across the forearm's real skin: the most pressed taxel's force beside the integral of Winkler's pressure over it.
fn forearm(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut arm = Arm::cody()?;
    let stiffness = arm.skin.stiffness_n_per_m3;
    arm.skin.stiffness_n_per_m3 *= simulated.with(1.0, 1.2);
    let link = arm.link_index("forearm");
    let index = arm.skin.surfaces.iter().position(|surface| Some(surface.link) == link);
    let Some(index) = index else {
        return Err(CheckError::Case("no skin on the forearm".into()));
    };
    let patch = &SkinPatch::of_arm(&arm)[index];
    let taxels = &arm.skin.layout.patches[index].taxels;
    let middle = &taxels[taxels.len() / 2];
    let (along, outward) = (middle.tangent_link, middle.normal_link);
    let around = outward.cross(along);
    let mut comparisons = Vec::new();
    for force_n in [2.0, 9.0] {
        // A third of the way to the next taxel both ways, so that nothing is symmetric.
        let touched = middle.position_link + along * 0.003;
        let contact = ContactPoint {
            position_link: touched,
            inward_link: -outward,
            force_link: outward * -force_n,
        };
        let trunk = SharedShape::capsule_y(0.3, TRUNK_RADIUS_M);
        let turn = glam::DQuat::from_rotation_arc(DVec3::Y, around);
        let pose = Pose::from_parts(touched + outward * TRUNK_RADIUS_M, turn);
        let found = patch.spread(&[contact], trunk.as_ref(), &pose);
        let place = |position: DVec3, normal: DVec3| {
            let turn = normal.dot(around).atan2(normal.dot(outward));
            [(position - touched).dot(along), turn * FOREARM_RADIUS_M]
        };
        let places: Vec<[f64; 2]> = taxels
            .iter()
            .map(|taxel| place(taxel.position_link, taxel.normal_link))
            .collect();
        let side_m = middle.area_m2.sqrt();
        let radii_m = [TRUNK_RADIUS_M, FOREARM_RADIUS_M];
        let expected = taxel_forces_n(stiffness, radii_m, &places, side_m, force_n);
        comparisons.push(Comparison::relative(
            format!("trunk across the forearm at {force_n} N, largest taxel"),
            "N",
            expected.into_iter().fold(0.0, f64::max),
            found.iter().map(|force| force.normal_force_n).fold(0.0, f64::max),
            0.05,
            "5 %: nine points a taxel, and terms of the order d / R, left out by the law",
        ));
    }
    Ok(comparisons)
}

/// Winkler's pressure integrated over each square taxel, N, at the depth where all together carry `force_n`.
fn taxel_forces_n(stiffness: f64, radii_m: [f64; 2], places: &[[f64; 2]], side_m: f64, force_n: f64) -> Vec<f64> {
    const FINE: i32 = 15;
    let spacing = side_m / f64::from(FINE);
    let offset = |index: i32| (f64::from(index) + 0.5) * spacing - side_m / 2.0;
    let at_depth = |depth_m: f64| -> Vec<f64> {
        let force = |place: &[f64; 2]| -> f64 {
            (0..FINE)
                .flat_map(|i| (0..FINE).map(move |j| (i, j)))
                .map(|(i, j)| [place[0] + offset(i), place[1] + offset(j)])
                .map(|fine| foundation::pressure_pa(stiffness, radii_m, depth_m, fine) * spacing * spacing)
                .sum()
        };
        places.iter().map(force).collect()
    };
    let (mut low, mut high) = (0.0, 0.02);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if at_depth(middle).iter().sum::<f64>() < force_n {
            low = middle;
        } else {
            high = middle;
        }
    }
    at_depth(0.5 * (low + high))
}
