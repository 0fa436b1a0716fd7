//! Tests of the layer: conservation, friction cones, and the similarity to a stored frame of the real skin.

use parry3d::shape::{Ball, Capsule, Cuboid};
use proptest::prelude::*;

use super::*;
use crate::object::FRICTION;

/// Friction between Cody's skin and an object: the mean of 0.3 and 0.4.
const MU: f64 = 0.35;

/// The middle taxel of Cody's forearm: row 8 of 16, column 12 of 24.
const TAXEL: usize = 8 * 24 + 12;
/// Half the pitch between columns, the larger one: 46.04 mm on 14.8° to 15.9°.
const HALF_PITCH_M: f64 = 0.0064;

fn forearm() -> SkinPatch {
    let arm = Arm::cody().unwrap();
    let index = arm.skin.layout.patch_index("forearm").unwrap();
    SkinPatch::of_arm(&arm).swap_remove(index)
}

/// A contact `along_m` and `around_rad` off the middle taxel's centre, on the surface of the sleeve, with this force
/// normal to it and a share `slip` of the friction that the cone allows, in the direction `slip_rad`.
fn contact(skin: &SkinPatch, along_m: f64, around_rad: f64, force_n: f64, slip: f64, slip_rad: f64) -> SkinContact {
    let rotation = glam::DQuat::from_rotation_z(around_rad);
    let normal = rotation * skin.normals_link[TAXEL];
    let position_link = rotation * skin.centers_link[TAXEL] + DVec3::Z * along_m;
    let tangent = DVec3::Z * slip_rad.cos() + normal.cross(DVec3::Z) * slip_rad.sin();
    SkinContact {
        radius_m: 0.02,
        position_link,
        inward_link: -normal,
        force_link: (tangent * (slip * MU) - normal) * force_n,
    }
}

/// A pose over the contact, with its z axis towards the skin and its x axis rotated by `angle_rad` from the sleeve's
/// axis.
fn over(contact: &SkinContact, distance_m: f64, angle_rad: f64) -> Pose {
    let down = contact.inward_link;
    let side = down.cross(DVec3::Z).normalize();
    let x = DVec3::Z * angle_rad.cos() + side * angle_rad.sin();
    let axes = glam::DMat3::from_cols(x, down.cross(x), down);
    Pose::new(contact.position_link - down * distance_m, glam::DQuat::from_mat3(&axes))
}

/// A trunk of this radius on the contact, rotated from the sleeve's axis.
fn trunk(contact: &SkinContact, radius_m: f64, angle_rad: f64) -> (Capsule, Pose) {
    let shape = Capsule::new(DVec3::X * -0.2, DVec3::X * 0.2, radius_m);
    (shape, over(contact, radius_m, angle_rad))
}

/// The contact spread over the taxels.
fn spread(skin: &SkinPatch, contact: SkinContact, shape: &dyn Shape, pose: &Pose) -> Vec<TaxelForce> {
    let (hard, mut buffers) = (Surface::hard(FRICTION), SpreadBuffers::default());
    skin.spread(&[contact], shape, pose, &hard, &mut buffers).to_vec()
}

fn force(skin: &SkinPatch, taxel: &TaxelForce) -> DVec3 {
    taxel.shear_link - skin.normals_link[taxel.taxel] * taxel.normal_force_n
}

/// Largest ratio of a taxel's shear to what its cone allows.
fn largest_slip(forces: &[TaxelForce]) -> f64 {
    let slip = |taxel: &TaxelForce| taxel.shear_link.length() / (MU * taxel.normal_force_n);
    forces.iter().map(slip).fold(0.0, f64::max)
}

proptest! {
    /// Tests that, for a trunk in any pose on the sleeve with any friction inside its cone, the force is conserved to
    /// 1e-9, its moment to half a pitch (a taxel measures how much presses on it, not where), and every taxel stays in
    /// its own cone to 1e-6 if there are taxels on both sides of the contact's normal.
    #[test]
    fn a_trunk_is_spread_without_loss(
        along_m in -0.005..0.005f64,
        around_rad in -0.13..0.13f64,
        force_n in 0.05..15.0f64,
        slip in 0.0..0.99f64,
        slip_rad in 0.0..std::f64::consts::TAU,
        radius_m in 0.01..0.02f64,
        angle_rad in 0.0..std::f64::consts::PI,
    ) {
        let skin = forearm();
        let contact = contact(&skin, along_m, around_rad, force_n, slip, slip_rad);
        let (shape, pose) = trunk(&contact, radius_m, angle_rad);
        let forces = spread(&skin, contact, &shape, &pose);
        let sum: DVec3 = forces.iter().map(|taxel| force(&skin, taxel)).sum();
        prop_assert!(sum.distance(contact.force_link) < 1e-9 * force_n);
        let moment: DVec3 = forces.iter().map(|taxel| skin.centers_link[taxel.taxel].cross(force(&skin, taxel))).sum();
        let missed = (moment - contact.position_link.cross(contact.force_link)).length() / contact.force_link.length();
        prop_assert!(missed < HALF_PITCH_M, "{missed} m off");
        // Then the taxels' cones together contain the contact's cone, because they extend beyond it on both sides.
        let side = |taxel: &TaxelForce| skin.normals_link[taxel.taxel].cross(-contact.inward_link).z;
        if forces.iter().any(|taxel| side(taxel) > 0.0) && forces.iter().any(|taxel| side(taxel) < 0.0) {
            let slip = largest_slip(&forces);
            prop_assert!(slip < 1.0 + 1e-6, "{slip} of the cone on {} taxels", forces.len());
        }
    }
}

proptest! {
    /// Tests that under friction of up to 2 no taxel pulls and no force is lost, wherever the contact's normal points: either the
    /// contact is on the skin and all of its force is on the taxels, or it is not.
    #[test]
    fn nothing_pulls_under_high_friction(
        lean_rad in -1.5..1.5f64,
        along_m in -0.1..0.1f64,
        slip in 0.0..2.0f64,
        slip_rad in 0.0..std::f64::consts::TAU,
    ) {
        let skin = forearm();
        let plain = contact(&skin, along_m, 0.0, 1.0, 0.0, 0.0);
        let normal = glam::DQuat::from_axis_angle(plain.inward_link.cross(DVec3::Z), lean_rad) * -plain.inward_link;
        let tangent = glam::DQuat::from_axis_angle(normal, slip_rad) * normal.any_orthonormal_vector();
        let contact = SkinContact { inward_link: -normal, force_link: tangent * slip - normal, ..plain };
        prop_assume!(skin.covers(&contact));
        let forces = spread(&skin, contact, &Ball::new(0.02), &Pose::from_position(contact.position_link + normal * 0.02));
        let sum: DVec3 = forces.iter().map(|taxel| force(&skin, taxel)).sum();
        prop_assert!(sum.distance(contact.force_link) < 1e-9, "{sum} of {}", contact.force_link);
        prop_assert!(forces.iter().all(|taxel| taxel.normal_force_n >= 0.0), "{forces:?}");
    }
}

/// Tests the similarity to a stored frame of the real skin, one broad contact of 8.99 N on 4 × 2 taxels of 0.56 to 1.53
/// N: for a trunk of 4 cm across the forearm with the same force, the number of pressed taxels and the largest force
/// agree within a factor of two. (The frame does not say what touched the skin.)
#[test]
fn a_broad_contact_looks_like_the_real_one() {
    let skin = forearm();
    let contact = contact(&skin, 0.0054, 0.13, 8.99, 0.0, 0.0);
    let (shape, pose) = trunk(&contact, 0.02, std::f64::consts::FRAC_PI_2);
    let forces = spread(&skin, contact, &shape, &pose);
    // Weaker forces are among the spurious readings of that frame (up to 0.10 N).
    let lit: Vec<f64> = forces.iter().map(|taxel| taxel.normal_force_n).filter(|force| *force > 0.10).collect();
    let strongest = lit.iter().copied().fold(0.0, f64::max);
    assert!((4..=16).contains(&lit.len()), "{} taxels: {lit:?}", lit.len());
    assert!((1.53 / 2.0..=1.53 * 2.0).contains(&strongest), "{strongest} N: {lit:?}");
}

/// Tests that objects look different on the skin: the edge of a leaf presses a line one taxel wide, its face and a
/// trunk a wider patch, and a trunk under more force a larger patch.
#[test]
fn edge_and_round_differ() {
    let skin = forearm();
    let rows_and_columns = |forces: &[TaxelForce]| {
        let count = |of: fn(usize) -> usize| {
            let lit = forces.iter().filter(|taxel| taxel.normal_force_n > 0.03);
            let places: std::collections::BTreeSet<usize> = lit.map(|taxel| of(taxel.taxel)).collect();
            places.len()
        };
        [count(|taxel| taxel / 24), count(|taxel| taxel % 24)]
    };
    let press = |force_n: f64| contact(&skin, 0.0, 0.0, force_n, 0.0, 0.0);
    let at = press(1.0);
    // A blade 1 mm thick and 4 cm broad, its edge across the sleeve.
    let blade = Cuboid::new(DVec3::new(0.1, 0.0005, 0.02));
    let edge = spread(&skin, at, &blade, &over(&at, 0.02, std::f64::consts::FRAC_PI_2));
    let round = |force_n: f64| {
        let at = press(force_n);
        let (shape, pose) = trunk(&at, 0.02, std::f64::consts::FRAC_PI_2);
        rows_and_columns(&spread(&skin, at, &shape, &pose))
    };
    let [rows, columns] = rows_and_columns(&edge);
    assert!(rows == 1 && columns >= 3, "edge {rows} × {columns}");
    let [rows, columns] = round(9.0);
    assert!(rows >= 2 && columns >= 2, "trunk {rows} × {columns}");
    assert!(round(1.0).iter().product::<usize>() < rows * columns);
}

/// Tests that a patch of one taxel works: contacts over its middle and near its corner are on it, and it takes the
/// whole force of both; a contact beside it is on the bare link.
#[test]
fn a_lone_taxel_feels_the_whole_force() {
    let mut arm = Arm::cody().unwrap();
    let index = arm.skin.layout.patch_index("forearm").unwrap();
    let patch = &mut arm.skin.layout.patches[index];
    patch.taxels = vec![patch.taxels[TAXEL]];
    patch.grid = None;
    let whole = forearm();
    let skin = SkinPatch::of_arm(&arm).swap_remove(index);
    // The taxel is a square of 9 mm: its corners are 6.4 mm from the centre.
    for (along_m, around_rad) in [(0.0, 0.0), (0.004, 0.08), (-0.004, -0.08)] {
        let contact = contact(&whole, along_m, around_rad, 2.0, 0.3, 1.0);
        assert!(skin.covers(&contact), "{along_m} m, {around_rad} rad");
        let (shape, pose) = trunk(&contact, 0.015, 1.0);
        let forces = spread(&skin, contact, &shape, &pose);
        assert_eq!(forces.len(), 1);
        let missed = TaxelForce { taxel: TAXEL, ..forces[0] };
        let missed = force(&whole, &missed).distance(contact.force_link);
        assert!(missed < 1e-9, "{missed} N");
    }
    assert!(!skin.covers(&contact(&whole, 0.008, 0.0, 2.0, 0.0, 0.0)));
}

/// Tests that the force of a small contact goes to the taxel on which it lies, however coarse the skin is: a ball with
/// a radius of 5 mm that presses with 1 mN on a square of 1 to 20 cm, anywhere within its outermost sub-points, is felt
/// by that taxel alone, whether the square beside it is as large or has a width of 1 cm.
#[test]
fn a_coarse_taxel_keeps_its_force() {
    let mut arm = Arm::cody().unwrap();
    let index = arm.skin.layout.patch_index("flipper").unwrap();
    for side_m in [0.01, 0.03, 0.05, 0.2] {
        let first =
            underbrush_recording::Taxel { area_m2: side_m * side_m, ..arm.skin.layout.patches[index].taxels[0] };
        let across = first.normal_link.cross(first.tangent_link);
        for (second_m, direction) in [(side_m, 1.0), (side_m, -1.0), (0.01, 1.0), (0.01, -1.0)] {
            let second = underbrush_recording::Taxel {
                area_m2: second_m * second_m,
                position_link: first.position_link + across * (direction * f64::midpoint(side_m, second_m)),
                ..first
            };
            arm.skin.layout.patches[index].taxels = vec![first, second];
            let skin = SkinPatch::of_arm(&arm).swap_remove(index);
            let places = [-1.0, -0.6, 0.0, 0.3, 1.0].map(|share| share * side_m * 3.0 / 8.0);
            for (x, y) in places.into_iter().flat_map(|x| places.map(|y| (x, y))) {
                let contact = SkinContact {
                    position_link: first.position_link + first.tangent_link * x + across * y,
                    inward_link: -first.normal_link,
                    force_link: first.normal_link * -0.001,
                    radius_m: 0.001,
                };
                let ball = Ball::new(0.005);
                let pose = Pose::new(contact.position_link + first.normal_link * 0.005, glam::DQuat::IDENTITY);
                let forces = spread(&skin, contact, &ball, &pose);
                let taxels: Vec<usize> = forces.iter().map(|force| force.taxel).collect();
                assert_eq!(taxels, [0], "{side_m} m wide, {x} m, {y} m");
            }
        }
    }
}

/// The forearm with a cover that passes this share of the pressure on gaps on to the taxels.
fn forearm_with_gaps(gap_share: f64) -> SkinPatch {
    let mut arm = Arm::cody().unwrap();
    let index = arm.skin.layout.patch_index("forearm").unwrap();
    arm.skin.surfaces[index].gap_share = gap_share;
    SkinPatch::of_arm(&arm).swap_remove(index)
}

/// Tests that taxels and gaps cover the sleeve, 2 π R times 16 pitches of 10.8 mm, and that what is felt of it is 384 squares
/// of 9 mm and the share of the rest.
#[test]
fn taxels_and_gaps_cover_the_sleeve() {
    for gap_share in [0.0, 0.5] {
        let skin = forearm_with_gaps(gap_share);
        let sleeve_m2 = std::f64::consts::TAU * 0.04604 * 16.0 * 0.0108;
        let taxels_m2 = 384.0 * 0.009 * 0.009;
        let area_m2: f64 = skin.sub_points.iter().map(|point| point.area_m2).sum();
        let felt_m2: f64 = skin.sub_points.iter().map(|point| point.area_m2 * point.felt_share).sum();
        assert!((area_m2 / sleeve_m2 - 1.0).abs() < 1e-12, "{area_m2} {sleeve_m2}");
        let expected_m2 = taxels_m2 + gap_share * (sleeve_m2 - taxels_m2);
        assert!((felt_m2 / expected_m2 - 1.0).abs() < 1e-12, "{felt_m2} {expected_m2}");
    }
    assert!(forearm().sub_points.iter().all(|point| point.felt_share == 1.0));
}

/// Tests a plate of 1 mm along the sleeve, pressed on it over six rows with 1 N. Between two columns only the share of the gap is
/// felt. On a column 9 mm of each 10.8 are felt and the share of the rest, but for the ends of the plate, where a row may be
/// pressed in part: at most one piece of 1/4 of 9 mm at each of two ends, of 65 mm. No force is lost for the arm.
#[test]
fn a_plate_between_two_columns_is_felt_through_the_gap() {
    for gap_share in [0.0, 0.3, 1.0] {
        let skin = forearm_with_gaps(gap_share);
        // Half of 14.8 or of 15.2 degrees.
        let between_deg = 7.5_f64;
        for (around_rad, expected, tolerance) in
            [(between_deg.to_radians(), gap_share, 1e-9), (0.0, (9.0 + 1.8 * gap_share) / 10.8, 2.0 * 2.25 / 65.0)]
        {
            let contact = SkinContact { radius_m: 0.04, ..contact(&skin, 0.0, around_rad, 1.0, 0.0, 0.0) };
            let plate = Cuboid::new(DVec3::new(0.0324, 0.0005, 0.02));
            let forces = spread(&skin, contact, &plate, &over(&contact, 0.02, 0.0));
            let total: DVec3 = forces.iter().map(|taxel| force(&skin, taxel)).sum();
            assert!((total - contact.force_link).length() < 1e-9, "{total}");
            let all: f64 = forces.iter().map(|taxel| taxel.normal_force_n).sum();
            let felt: f64 = forces.iter().map(|taxel| taxel.normal_force_n * taxel.felt_share).sum();
            assert!((felt / all - expected).abs() <= tolerance, "{gap_share} at {around_rad}: {}", felt / all);
        }
    }
}

/// Tests that what the sub-points feel adds up to what each taxel feels, under a trunk on a skin with gaps and under a wire.
#[test]
fn sub_points_add_up_to_their_taxels() {
    for (radius_m, gap_share) in [(0.02, 0.3), (0.0001, 1.0)] {
        let skin = forearm_with_gaps(gap_share);
        let contact = contact(&skin, 0.0054, 0.13, 2.0, 0.2, 0.0);
        let (shape, pose) = trunk(&contact, radius_m, 0.0);
        let (hard, mut buffers) = (Surface::hard(FRICTION), SpreadBuffers::default());
        let forces = skin.spread(&[contact], &shape, &pose, &hard, &mut buffers).to_vec();
        assert!(!forces.is_empty());
        for force in forces {
            let points = skin.felt_points(&buffers).filter(|(point, _)| skin.sub_points[*point].taxel == force.taxel);
            let felt_n: f64 = points.map(|(_, felt_n)| felt_n).sum();
            assert!((felt_n - force.normal_force_n * force.felt_share).abs() < 1e-12, "{felt_n}, {force:?}");
        }
    }
}

/// Tests that a contact whose normal runs along the sleeve, so that no sub-point faces it, presses one sub-point of its taxel with
/// all of the normal force.
#[test]
fn a_contact_that_no_sub_point_faces_presses_one() {
    let skin = forearm();
    let above = contact(&skin, 0.0, 0.0, 0.3, 0.0, 0.0);
    let along = DVec3::Z;
    let contact = SkinContact { inward_link: along, force_link: above.force_link + along, ..above };
    let (hard, mut buffers) = (Surface::hard(FRICTION), SpreadBuffers::default());
    let pose = Pose::new(contact.position_link - along * 0.01, glam::DQuat::IDENTITY);
    let forces = skin.spread(&[contact], &Ball::new(0.01), &pose, &hard, &mut buffers).to_vec();
    let points: Vec<(usize, f64)> = skin.felt_points(&buffers).collect();
    let [(point, felt_n)] = points[..] else { panic!("{forces:?} {points:?}") };
    assert_eq!((skin.sub_points[point].taxel, felt_n), (forces[0].taxel, forces[0].normal_force_n));
}
