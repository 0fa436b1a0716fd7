//! Blades of leaves and plants, for pictures: bodies that join end to end.

use glam::DVec3;
use underbrush_recording::{BodyPart, BodyShape, Pose};

/// A thin blade that bends at hinges: rigid pieces, each of which begins at the end of the one before it.
#[derive(Clone, Debug)]
pub struct Blade {
    /// Width, m.
    pub width_m: f64,
    /// The pieces, from the foot to the tip.
    pub pieces: Vec<BladePiece>,
}

/// Pieces that are this close end to end are of one blade, m. Stored poses are rounded by up to 0.3 mm at the end of a piece.
const JOINED_M: f64 = 1e-3;
/// Width at the tip, relative to the width of the blade. Choice.
const TIP: f64 = 0.55;

/// The foot, a hinge or the tip of a blade, as a point of the smooth curve through them.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// Place, m, world frame.
    pub position_world: DVec3,
    /// Direction of the curve: at a hinge the mean of the directions of the two pieces that meet there.
    pub tangent_world: DVec3,
    /// From the middle of the blade to its edge, m.
    pub half_world: DVec3,
}

impl Blade {
    /// Adds a body to the blade that ends where it begins, or begins a blade with it; false if it is no piece of a blade.
    pub fn join(blades: &mut Vec<Blade>, parts: &[BodyPart], pose_world: &Pose) -> bool {
        let Some(size_m) = blade_piece(parts) else { return false };
        let piece = BladePiece { pose_world: *pose_world, length_m: size_m.z };
        match blades.last_mut().filter(|blade| blade.ends_at(pose_world.position)) {
            Some(blade) => blade.pieces.push(piece),
            None => blades.push(Blade { width_m: size_m.y, pieces: vec![piece] }),
        }
        true
    }

    /// Whether its last piece ends at this place, m, world frame.
    fn ends_at(&self, place_world: DVec3) -> bool {
        let end = self.pieces.last().map(|piece| piece.pose_world.transform_point(DVec3::Z * piece.length_m));
        end.is_some_and(|end| end.distance(place_world) < JOINED_M)
    }

    /// Foot, hinges and tip. Pictures draw a cubic between each two, along which the rigid pieces lie.
    pub fn knots(&self) -> Vec<Knot> {
        let pieces = &self.pieces;
        let mean = |index: usize, axis: DVec3| {
            let turned = |piece: usize| pieces[piece].pose_world.orientation * axis;
            (turned(index.saturating_sub(1)) + turned(index.min(pieces.len() - 1))).normalize_or_zero()
        };
        let knot = |index: usize| {
            let at_tip = index == pieces.len();
            let piece = &pieces[index.min(pieces.len() - 1)];
            let length_m = if at_tip { piece.length_m } else { 0.0 };
            let width = if at_tip { TIP } else { 1.0 };
            Knot {
                position_world: piece.pose_world.transform_point(DVec3::Z * length_m),
                tangent_world: mean(index, DVec3::Z),
                half_world: mean(index, DVec3::Y) * (width * self.width_m / 2.0),
            }
        };
        (0..=pieces.len()).map(knot).collect()
    }
}

/// A piece of a blade.
#[derive(Clone, Copy, Debug)]
pub struct BladePiece {
    /// Its pose in the world frame: the origin at its lower hinge, z towards the tip, y across the blade.
    pub pose_world: Pose,
    /// Length, m.
    pub length_m: f64,
}

/// The size of a piece of a blade: one thin box that begins at its hinge and stands along z.
fn blade_piece(parts: &[BodyPart]) -> Option<DVec3> {
    let [part] = parts else { return None };
    let BodyShape::Box { size_m } = part.shape else { return None };
    let at_hinge = part.pose_body.position.abs_diff_eq(DVec3::Z * size_m.z / 2.0, 1e-9);
    (size_m.x < 0.2 * size_m.y && at_hinge).then_some(size_m)
}
