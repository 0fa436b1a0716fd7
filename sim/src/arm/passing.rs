//! Which links of an arm pass through each other instead of colliding.

use underbrush_recording::Pose;

use super::Arm;

/// Links with at most this many joints between them pass through each other. Choice: simple shapes overlap where links are
/// joined, also across a short link between them. In random postures the first and the third link of the Panda in
/// docs/arms.md overlap in 27 %, by up to 21 mm, and Cody's forearm and flipper in 17 %, by up to 10 mm.
const JOINTS_BETWEEN: usize = 2;

/// The pairs of links that pass through each other, the one nearer to the base first: those with one or two joints between
/// them, those that overlap in the start posture, and those that the arm has already.
pub(super) fn passing_links(arm: &Arm) -> Vec<[usize; 2]> {
    let poses = arm.forward_kinematics(&arm.start_posture_rad());
    let links = arm.links.len();
    let pairs = (0..links).flat_map(|first| (first + 1..links).map(move |second| [first, second]));
    let passes = |pair: &[usize; 2]| {
        let [first, second] = *pair;
        second - first <= JOINTS_BETWEEN || arm.passing_links.contains(pair) || overlap(arm, &poses, *pair)
    };
    pairs.filter(passes).collect()
}

/// Whether two links overlap when the links are at these poses.
pub(super) fn overlap(arm: &Arm, poses: &[Pose], pair: [usize; 2]) -> bool {
    let [own, other] = pair.map(|link| arm.links[link].placed_shapes(poses[link]));
    let other: Vec<_> = other.collect();
    own.into_iter().any(|own| other.iter().any(|other| own.distance_to(other.shape.as_ref(), &other.pose) <= 0.0))
}
