use glam::{DMat3, DVec3};
use nalgebra::{Matrix3, Vector3};
use underbrush_recording::Pose;

use super::super::Arm;
use super::super::wedge::wedges;
use super::altered_cody;
use super::kinematics::{matrix, modified_dh_frames};

/// Mass (kg), centre of mass (m) and inertia Ixx Iyy Izz Ixy Ixz Iyz (kg m²) in the modified-DH frames, as published.
type Published = (f64, [f64; 3], [f64; 6]);
const LINKS: [Published; 5] = [
    (2.0036, [0.008106, -0.002865, -0.009494], [0.004658, 0.003056, 0.003212, -0.000504, 0.000078, -0.000268]),
    (0.6362, [-0.034129, -0.022504, -0.000872], [0.001240, 0.001281, 0.000966, 0.000206, -0.000016, -0.000010]),
    (2.3017, [0.004806, -0.003196, -0.089098], [0.015647, 0.015788, 0.002339, -0.000001, -0.000525, -0.000603]),
    (0.3388, [0.0, 0.035097, 0.005934], [0.000663, 0.000574, 0.000409, 0.0, 0.0, -0.000060]),
    (1.184, [0.000236, -0.001590, -0.128330], [0.005892, 0.005680, 0.000761, 0.000001, -0.000003, -0.000035]),
];

#[test]
fn inertia_is_the_published_one_in_link_frames() {
    // Tests the inertia in the URDF, which was converted from DH frames and includes the skin's shell on the forearm.
    // It is compared in the base frame at the zero posture, so no frame convention is shared with the files.
    let arm = Arm::cody().unwrap();
    let frames = modified_dh_frames(&[0.0; 7]);
    let poses = arm.forward_kinematics(&[0.0; 7]);
    for (index, (mass, center, [xx, yy, zz, xy, xz, yz])) in LINKS.into_iter().enumerate() {
        let rotation = frames[index].fixed_view::<3, 3>(0, 0).into_owned();
        let origin = frames[index].fixed_view::<3, 1>(0, 3).into_owned();
        let mut mass = mass;
        let mut center = rotation * Vector3::from(center) + origin;
        let mut inertia = rotation * Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz) * rotation.transpose();
        if index == 4 {
            let elbow = Vector3::new(0.00635, -0.21668, -0.27795);
            let (skin, radius, length) = (1.468 - 1.184, 0.04604_f64, 16.0 * 0.0108_f64);
            let across = skin * (radius * radius / 2.0 + length * length / 12.0);
            let shell = Matrix3::from_diagonal(&Vector3::new(across, across, skin * radius * radius));
            let shell_center = elbow - Vector3::z() * 0.1752;
            let both = (center * mass + shell_center * skin) / (mass + skin);
            let steiner =
                |mass: f64, r: Vector3<f64>| (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * mass;
            inertia += steiner(mass, center - both) + shell + steiner(skin, shell_center - both);
            (mass, center) = (mass + skin, both);
        }
        let link = &arm.links[index + 1];
        let pose = matrix(&poses[index + 1]);
        let link_center = pose.transform_point(&Vector3::from(link.center_of_mass_link.to_array()).into());
        // The URDF is rounded to micrometres and 1e-6 kg m².
        assert!((link.mass_kg - mass).abs() < 1e-9);
        assert!((link_center.coords - center).amax() < 1e-6, "{}", link.name);
        let stated = Matrix3::from_column_slice(&link.inertia_link.to_cols_array());
        assert!((stated - inertia).amax() < 1e-6, "{}: {stated} against {inertia}", link.name);
    }
}

#[test]
fn forearm_skin_is_a_closed_sleeve_short_of_the_wrist() {
    // Tests the published layout: 16 × 24 taxels of 9 × 9 mm on a cylinder of 46.04 mm, the first row 94.2 mm and the
    // last 256.2 mm from the elbow axis, 14.8° to 15.9° between columns, all round.
    let arm = Arm::cody().unwrap();
    let patch = &arm.skin.layout.patches[0];
    let grid = patch.grid.unwrap();
    assert_eq!((patch.name.as_str(), grid.rows, grid.columns, grid.wraps), ("forearm", 16, 24, true));
    assert_eq!(patch.taxels.len(), 384);
    let link = arm.link_index(&patch.link).unwrap();
    // The link after the forearm roll (joint 4): the skin rotates with it.
    assert_eq!(link, 5);
    let poses = arm.forward_kinematics(&[0.0; 7]);
    let elbow = poses[4].position;
    for (index, taxel) in patch.taxels.iter().enumerate() {
        let from_elbow = poses[link].transform_point(taxel.position_link) - elbow;
        let row = index / 24;
        assert!((-from_elbow.z - (0.0942 + 0.0108 * row as f64)).abs() < 1e-9);
        assert!((from_elbow.truncate().length() - 0.04604).abs() < 1e-12);
        assert!(from_elbow.truncate().normalize().distance(taxel.normal_link.truncate()) < 1e-12);
        assert!((taxel.area_m2 - 81e-6).abs() < 1e-18);
        let next = &patch.taxels[row * 24 + (index + 1) % 24];
        let step = taxel.normal_link.angle_between(next.normal_link).to_degrees();
        assert!((14.79..15.91).contains(&step), "{step}° after taxel {index}");
    }
}

#[test]
fn flipper_skin_has_its_69_taxels_on_the_flipper() {
    // Tests count, area bounds and frame of the flipper's taxels: the tip taxel faces along the flipper at the tip, and
    // every taxel is at most about 6 mm away from the surface of the collision shapes.
    let arm = Arm::cody().unwrap();
    let patch = &arm.skin.layout.patches[1];
    assert_eq!((patch.name.as_str(), patch.link.as_str(), patch.taxels.len()), ("flipper", "flipper", 69));
    let tip = patch.taxels[24];
    assert!(tip.position_link.distance(arm.end_effector_pose_link.position) < 1e-12);
    assert!(tip.normal_link.distance(DVec3::NEG_Z) < 1e-12);
    let link = &arm.links[arm.skin.surfaces[1].link];
    for taxel in &patch.taxels {
        assert!((1e-4..=15e-4).contains(&taxel.area_m2));
        let distance = |collider: &super::super::LinkCollider| {
            let solid = collider.placed(&Pose::IDENTITY);
            solid.shape.distance_to_local_point(solid.pose.inverse().transform_point(taxel.position_link), false)
        };
        let nearest =
            link.colliders.iter().map(distance).fold(f64::INFINITY, |a, b| if b.abs() < a.abs() { b } else { a });
        assert!(nearest.abs() < 0.0065, "taxel at {} is {nearest} m off", taxel.position_link);
    }
}

#[test]
fn tangents_are_unit_and_across_the_normal() {
    // Tests the frames in which shear is given.
    let arm = Arm::cody().unwrap();
    for taxel in arm.skin.layout.patches.iter().flat_map(|patch| &patch.taxels) {
        let frame =
            DMat3::from_cols(taxel.tangent_link, taxel.normal_link.cross(taxel.tangent_link), taxel.normal_link);
        assert!((frame * frame.transpose()).abs_diff_eq(DMat3::IDENTITY, 1e-9));
    }
}

#[test]
fn surface_points_tile_their_taxel() {
    // Tests the pieces of a taxel: together they have its area and its middle; on the cylinder they lie on the surface
    // and their normals point from the axis.
    let arm = Arm::cody().unwrap();
    for (patch, surface) in arm.skin.surfaces.iter().enumerate() {
        let first = &arm.skin.layout.patches[patch].taxels[0];
        for (index, taxel) in arm.skin.layout.patches[patch].taxels.iter().enumerate() {
            let points = arm.skin.surface_points(patch, index, 3);
            assert_eq!(points.len(), 9);
            let area: f64 = points.iter().map(|point| point.area_m2).sum();
            assert!((area - taxel.area_m2).abs() < 1e-15);
            assert!(points[4].position_link.distance(taxel.position_link) < 1e-12);
            let spacing = taxel.area_m2.sqrt() / 3.0;
            assert!((points[4].position_link.distance(points[1].position_link) - spacing).abs() < 1e-12);
            assert!((points[1].position_link - points[4].position_link).dot(taxel.tangent_link) < 0.0);
            if let Some(radius_m) = surface.radius_m {
                let axis_point_link = first.position_link - first.normal_link * radius_m;
                for point in points {
                    let from_axis = (point.position_link - axis_point_link).reject_from_normalized(first.tangent_link);
                    assert!((from_axis.length() - radius_m).abs() < 1e-12);
                    assert!((from_axis / radius_m).distance(point.normal_link) < 1e-12);
                }
            } else {
                assert!(points.iter().all(|point| point.normal_link == taxel.normal_link));
            }
        }
    }
    assert!(arm.skin.surface_points(0, 384, 3).is_empty());
}

/// Tests that the boot closes the cleft at the wrist, and that with a smaller one the cleft between forearm and flipper is found:
/// its opening is at most twice the angle of friction, its force the wrist's torque at its lever, and its place between the gap
/// and the rims.
#[test]
fn an_open_wrist_is_a_wedge() {
    assert_eq!(wedges(&Arm::cody().unwrap()), []);
    let open = altered_cody("cody.urdf", "<sphere radius=\"0.0475\"/>", "<sphere radius=\"0.005\"/>").unwrap();
    let found = wedges(&open);
    let [wedge] = &found[..] else { panic!("{found:?}") };
    assert_eq!(
        (&wedge.links, &wedge.joint),
        (&["forearm".to_owned(), "flipper".to_owned()], &"wrist_pitch".to_owned())
    );
    let wrist = open.joints.iter().find(|joint| joint.name == "wrist_pitch").unwrap();
    assert!((wedge.force_n * wedge.lever_m - wrist.torque_limit_nm).abs() < 1e-9, "{wedge:?}");
    assert!(wedge.opening_deg <= 2.0 * 0.3_f64.atan().to_degrees(), "{wedge:?}");
    // No nearer to the axis than the gap is, and no farther than the rims.
    assert!((0.0115..0.0475).contains(&wedge.lever_m), "{wedge:?}");
}
