//! What objects look like on the forearm's skin, and how a foam roll pushes back. These are data for pictures, not
//! checks.

use glam::DVec3;
use underbrush_recording::Grid;
use underbrush_sim::arm::Arm;
use underbrush_sim::object::Object;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::object::trunk::Trunk;

use crate::Fault;
use crate::pressed_arm::{Beside, LEAF, OPTIONS, PressedArm, ROLL};

/// The forearm's skin pressed on one object.
#[derive(Clone, Debug)]
pub struct Portrait {
    /// Name of the object that presses.
    pub name: &'static str,
    /// Rows and columns of the skin.
    pub grid: Grid,
    /// True normal force on each taxel, N; index = row · columns + column.
    pub force_n: Vec<f64>,
    /// The object's section in the plane of the forearm's axis and the push.
    pub section: Section,
    /// How deep the object is in the skin, m.
    pub depth_m: f64,
}

/// The section of an object.
#[derive(Clone, Copy, Debug)]
pub enum Section {
    /// A disc.
    Disc {
        /// Radius, m.
        radius_m: f64,
    },
    /// A rectangle.
    Bar {
        /// Length along the skin, m.
        along_m: f64,
        /// Length away from it, m.
        away_m: f64,
    },
}

/// Force with which the springs would push the forearm on each object if nothing moved, N.
const PUSH_N: f64 = 6.0;

fn leaf() -> Box<dyn Object> {
    Box::new(Leaf {
        height_m: 0.35,
        width_m: 0.04,
        flexural_rigidity_n_m2: 0.04,
        loss_factor: 0.1,
        root_stiffness_nm_per_rad: None,
        ..LEAF
    })
}

/// The skin under the edge and the flat of a leaf, a trunk and a foam roll that are pressed with the same equilibrium
/// angles over three seconds, each in the frame with the largest force.
///
/// # Errors
/// When the arm's files are bad or nothing is touched.
pub fn portraits() -> Result<Vec<Portrait>, Fault> {
    let trunk = Box::new(Trunk { diameter_m: 0.03, height_m: 0.6 });
    let bar = |along_m, away_m| Section::Bar { along_m, away_m };
    let [thickness_m, width_m] = leaf().half_sizes_m().map(|half| 2.0 * half);
    let disc = |radius_m| Section::Disc { radius_m };
    // A leaf rotated by a right angle has its edge to the skin.
    let quarter = std::f64::consts::FRAC_PI_2;
    Ok(vec![
        portrait("leaf, edge", leaf(), 0.021, quarter, bar(thickness_m, width_m))?,
        portrait("leaf, flat", leaf(), 0.005, 0.0, bar(width_m, thickness_m))?,
        portrait("trunk", trunk, 0.017, 0.0, disc(0.015))?,
        portrait("foam roll", Box::new(ROLL), 0.061, 0.0, disc(0.06))?,
    ])
}

/// The portrait of one object. `gap_m` is from the forearm's surface to the object's middle.
fn portrait(
    name: &'static str,
    object: Box<dyn Object>,
    gap_m: f64,
    rotation_rad: f64,
    section: Section,
) -> Result<Portrait, Fault> {
    let arm = Arm::cody()?;
    let beside = Beside { rotation_rad, ..Beside::facing(object, gap_m, 0.2) };
    let mut pressed = PressedArm::new(arm.clone(), arm, beside, OPTIONS)?;
    let layout = &pressed.arm.skin.layout;
    let index = layout.patch_index("forearm");
    let grid = index.and_then(|index| layout.patches[index].grid);
    let grid = grid.ok_or_else(|| Fault::Run("the forearm has no grid of taxels".into()))?;
    let push = pressed.pressing_rad(PUSH_N);
    let (mut best, mut depth_m) = (vec![0.0; grid.rows * grid.columns], 0.0);
    for frame in 1..=300 {
        // Slowly, because the picture shows how the object presses, not an impact.
        let share = f64::from(frame) / 300.0;
        pressed.hold_part_way(&push, share);
        let mut force_n = vec![0.0; best.len()];
        for reading in pressed.forearm_taxels()? {
            force_n[usize::from(reading.taxel)] = reading.true_normal_force_n;
        }
        if force_n.iter().sum::<f64>() > best.iter().sum() {
            best = force_n;
            let depths = pressed.report().contacts.iter().map(|contact| contact.penetration_m);
            depth_m = depths.fold(0.0, f64::max);
        }
    }
    if best.iter().all(|force| *force == 0.0) {
        return Err(Fault::Run(format!("the forearm does not touch the {name}")));
    }
    Ok(Portrait { name, grid, force_n: best, section, depth_m })
}

/// A foam roll that the forearm pushes for five seconds and releases for five seconds, as (way of the forearm since
/// first contact, m; force, N) in each frame with contact.
///
/// # Errors
/// When the arm's files are bad or nothing is touched.
pub fn roll_loop() -> Result<Vec<(f64, f64)>, Fault> {
    let arm = Arm::cody()?;
    let mut pressed = PressedArm::new(arm.clone(), arm, Beside::facing(Box::new(ROLL), 0.061, 0.2), OPTIONS)?;
    let (push, half) = (pressed.pressing_rad(12.0), 500);
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut first = None;
    for frame in 0..2 * half {
        let share = 1.0 - (f64::from(frame - half) / f64::from(half)).abs();
        pressed.hold_part_way(&push, share);
        let force_n = -pressed.contact_force_world().dot(pressed.across_world);
        let forearm = &pressed.report().link_pose_world[pressed.forearm];
        let place = forearm.transform_point(DVec3::new(0.0, 0.0, 0.10));
        let way = place.dot(pressed.across_world);
        if force_n > 0.0 {
            let from = *first.get_or_insert(way);
            points.push((way - from, force_n));
        }
    }
    if points.is_empty() {
        return Err(Fault::Run("the forearm does not touch the foam roll".into()));
    }
    Ok(points)
}
