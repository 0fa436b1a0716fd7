//! Tests of depth, segmentation and colour against rays.

use glam::{DQuat, Vec3};
use underbrush_recording::ContactPoint;

use super::*;
use crate::{RenderError, Stage, colour};

/// Distance along a ray to a ball, in lengths of the ray.
fn hit_ball(eye: DVec3, ray: DVec3, center: DVec3, radius: f64) -> Option<f64> {
    let (unit, from) = (ray.normalize(), center - eye);
    let along = from.dot(unit);
    let half = radius * radius - (from.length_squared() - along * along);
    (half > 0.0).then(|| (along - half.sqrt()) / ray.length())
}

/// Distance along a ray to a box at this pose, by its slabs.
fn hit_box(eye: DVec3, ray: DVec3, size_m: DVec3, pose: &Pose) -> Option<f64> {
    let (eye, ray) = (pose.inverse_transform_point(eye), pose.inverse_transform_vector(ray));
    let (one, other) = ((-size_m / 2.0 - eye) / ray, (size_m / 2.0 - eye) / ray);
    let (enter, leave) = (one.min(other).max_element(), one.max(other).min_element());
    (enter < leave).then_some(enter)
}

/// Tests the depth of a ball at every pixel against the rays' intersections with the ball and with one within its mesh.
#[test]
fn depth_of_a_ball_is_that_of_rays() {
    let (center, radius) = (DVec3::new(0.1, 0.2, 0.1), 0.3);
    let bodies = [ball(radius, center)];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
    let camera = camera(DVec3::new(0.2, 0.1, 0.05));
    let depth = stage.moment(0, &frame()).depth_and_labels(&camera, size()).unwrap().0;
    // The middle of a face of 90°/11 by 90°/11 lies 1 - cos(5.8°) = 0.52 % of the radius below the ball.
    let mut compared = 0;
    for (ray, depth) in rays(&camera, size()).into_iter().zip(&depth) {
        let hit = |share: f64| hit_ball(camera.eye_world, ray, center, share * radius);
        match (hit(1.0), hit(0.994)) {
            (None, _) => assert!(depth.is_infinite()),
            (Some(near), Some(far)) => {
                assert!((near - 1e-5..far).contains(&f64::from(*depth)), "{depth}, not {near} to {far}");
                compared += 1;
            }
            (Some(_), None) => {}
        }
    }
    assert!(compared > 5000, "{compared}");
}

/// Tests the depth of a turned box at every pixel against the ray's intersection with its slabs.
#[test]
fn depth_of_a_box_is_that_of_rays() {
    let pose = Pose::new(DVec3::new(0.1, 0.1, 0.2), DQuat::from_scaled_axis(DVec3::new(0.4, -0.3, 0.9)));
    let size_m = DVec3::new(0.3, 0.4, 0.2);
    let bodies = [link(BodyShape::Box { size_m }, pose)];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
    let camera = camera(DVec3::new(0.0, 0.1, 0.1));
    let depth = stage.moment(0, &frame()).depth_and_labels(&camera, size()).unwrap().0;
    let truth: Vec<Option<f64>> =
        rays(&camera, size()).into_iter().map(|ray| hit_box(camera.eye_world, ray, size_m, &pose)).collect();
    let wrong = truth.iter().zip(&depth).filter(|(truth, depth)| match truth {
        // Single precision.
        Some(truth) => (f64::from(**depth) - truth).abs() > 1e-5,
        None => depth.is_finite(),
    });
    // A pixel whose middle is on the outline but for rounding may go either way.
    assert!(wrong.count() <= 2);
    assert!(truth.iter().flatten().count() > 2000);
}

/// Tests that a table that reaches behind the camera is cut off before it, and has the depth of a plane.
#[test]
fn what_is_behind_the_camera_is_cut_off() {
    let size_m = DVec3::new(40.0, 40.0, 0.1);
    let bodies = [link(BodyShape::Box { size_m }, Pose::from_position(DVec3::Z * -0.05))];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
    let camera = Camera { eye_world: DVec3::Z * 0.3, ..camera(DVec3::new(1.0, 0.3, 0.1)) };
    let depth = stage.moment(0, &frame()).depth_and_labels(&camera, size()).unwrap().0;
    for (ray, depth) in rays(&camera, size()).into_iter().zip(depth) {
        let truth = -0.3 / ray.z;
        if (0.0..15.0).contains(&truth) {
            assert!((f64::from(depth) / truth - 1.0).abs() < 1e-4, "{depth}, not {truth}");
        }
    }
}

/// Tests that the pixels of a ball far from the middle of the picture are as many as its ellipse has, and that labels name
/// table, link and object.
#[test]
fn a_ball_covers_its_ellipse() {
    let (center, radius) = (DVec3::new(0.3, 0.05, 0.2), 0.12);
    let (post, object) = post(DVec3::new(0.6, -0.4, -0.2));
    let bodies = [ball(radius, center), post];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[object], &layout, 1.0, &[]).unwrap();
    let camera = camera(DVec3::new(0.2, -0.3, 0.0));
    let size = Size { width: 1000, height: 800 };
    let labels = stage.moment(0, &frame()).depth_and_labels(&camera, size).unwrap().1;
    assert_eq!(stage.labels, ["background", "table", "link arm", "object 0 trunk"]);
    let count = |label: u16| labels.iter().filter(|own| **own == label).count();
    let from = center - camera.eye_world;
    let z = from.dot((camera.target_world - camera.eye_world).normalize());
    let focal = 400.0 / 20.0_f64.to_radians().tan();
    // The outline of a ball is a cone, and a plane cuts an ellipse of this area out of it.
    let (d, r) = (from.length_squared(), radius * radius);
    let area = std::f64::consts::PI * focal * focal * r * ((d - r) / (z * z - r).powi(3)).sqrt();
    let share = count(2) as f64 / area;
    // A polygon of 28 corners in a circle has 99.2 % of its area; that of a ball seen askew a little less.
    assert!((0.98..=1.0).contains(&share), "{share}");
    assert!(count(0) > 1000 && count(1) > 1000 && count(3) > 1000);
    assert_eq!(labels.len(), count(0) + count(1) + count(2) + count(3));
}

/// Tests that a taxel has the colour of its force, that one without force and the goal have theirs, and that these marks are in
/// no other picture.
#[test]
fn taxels_have_the_colours_of_their_forces() {
    let size_m = DVec3::new(0.4, 0.4, 0.1);
    let bodies = [link(BodyShape::Box { size_m }, Pose::IDENTITY)];
    let taxel = |x: f64| Taxel {
        position_link: DVec3::new(x, 0.0, 0.05),
        normal_link: DVec3::Z,
        tangent_link: DVec3::X,
        area_m2: 0.0025,
    };
    let taxels = vec![taxel(-0.1), taxel(0.0), taxel(0.1)];
    let layout = SkinLayout { patches: vec![Patch { name: "skin".into(), link: "arm".into(), grid: None, taxels }] };
    let stage = Stage::new(&bodies, &[], &layout, 4.0, &[]).unwrap();
    let reading = |taxel: u16, sensed_force_n: f64| TaxelReading { taxel, sensed_force_n, ..TaxelReading::default() };
    let goal_position_world = DVec3::new(0.0, 0.15, 0.07);
    let frame = Frame { taxels: vec![reading(0, 1.0), reading(2, 4.0)], goal_position_world, ..Frame::blank(1) };
    let camera = Camera { eye_world: DVec3::Z, up_world: DVec3::Y, ..camera(DVec3::ZERO) };
    let moment = stage.moment(0, &frame);
    let rgb = moment.rgb(&camera, size()).unwrap();
    let seen = |x: f64, y: f64, z: f64| {
        let scale = 80.0 / 20.0_f64.to_radians().tan() / (1.0 - z);
        let (column, row) = ((100.0 + x * scale) as usize, (80.0 - y * scale) as usize);
        row * 200 + column
    };
    let pixel = |place: usize| [rgb[3 * place], rgb[3 * place + 1], rgb[3 * place + 2]];
    // The root of a quarter is half: between the third and the fourth colour of six.
    assert_eq!(pixel(seen(-0.1, 0.0, 0.05)), [0xe8, 0x6f, 0x3b]);
    assert_eq!(pixel(seen(0.0, 0.0, 0.05)), [0xb9, 0xc2, 0xca]);
    assert_eq!(pixel(seen(0.1, 0.0, 0.05)), [0x4a, 0x0d, 0x4f]);
    assert_eq!(pixel(seen(0.0, 0.15, 0.08)), [0x1f, 0x5f, 0xbf]);
    let labels = moment.depth_and_labels(&camera, size()).unwrap().1;
    let depth = moment.depth_and_labels(&camera, size()).unwrap().0;
    for place in [seen(0.1, 0.0, 0.05), seen(0.0, 0.15, 0.08)] {
        assert_eq!(labels[place], 2);
        assert!((depth[place] - 0.95).abs() < 1e-5);
    }
}

/// Tests that a contact of 2 N has an arrow of 8 cm and its head, whose tip is where it acts, that the arrow is red where a taxel
/// senses more than the limit, and that neither a stage without arrows nor depth or segmentation has it.
#[test]
fn contacts_have_arrows() {
    let mut recording = super::film::reach();
    recording.frames.truncate(1);
    let (layout, bodies) = (&mut recording.layout, &mut recording.bodies);
    (layout.patches, *bodies) = (Vec::new(), vec![ball(0.01, DVec3::new(0.0, 0.2, 0.0))]);
    recording.objects.clear();
    let point = ContactPoint {
        link: 0,
        patch: Some(0),
        object: Some(0),
        body: 0,
        position_world: Vec3::new(0.05, 0.0, 0.0),
        normal_world: Vec3::X,
        force_world: Vec3::X * 2.0,
        moment_world: Vec3::ZERO,
        slip_world: Vec3::ZERO,
        depth_m: 0.0,
        area_m2: 0.0,
    };
    let reading = TaxelReading { sensed_force_n: 1.5, object: Some(0), ..TaxelReading::default() };
    let pressed = Frame { contact_points: vec![point], taxels: vec![reading], ..frame() };
    let weak = Frame { contact_points: vec![ContactPoint { force_world: Vec3::X * 0.01, ..point }], ..frame() };
    let camera = Camera { eye_world: DVec3::Z * 0.3, up_world: DVec3::Y, ..camera(DVec3::ZERO) };
    // x of the pixels of this colour in the middle row, m. A pixel is 1.4 mm wide.
    let scale = 80.0 / 20.0_f64.to_radians().tan() / 0.3;
    let row = |stage: &Stage, frame: &Frame, colour: &str| {
        let rgb = stage.moment(0, frame).rgb(&camera, size()).unwrap();
        let is_own = |column: &usize| rgb[3 * (80 * 200 + column)..][..3] == colour::shown(colour::linear(colour));
        (0..200).filter(is_own).map(|column| (column as f64 + 0.5 - 100.0) / scale).collect::<Vec<f64>>()
    };
    let with = |limit_n| Stage::of(&recording, limit_n).unwrap().with_arrows();
    let plain = row(&with(None), &pressed, colour::ARROW);
    // From 0.05 m back by 2 N of 0.04 m each and a head of 0.016 m. The head is thinner than this pixel in its last 3.2 mm.
    for (found, place, least) in [(plain[0], -0.046, -0.0015), (plain[plain.len() - 1], 0.05, -0.005)] {
        assert!((least..0.0015).contains(&(found - place)), "{found}, not {place}");
    }
    assert!(plain.len() > 60);
    assert_eq!(row(&with(Some(1.6)), &pressed, colour::ARROW), plain);
    assert_eq!(row(&with(Some(1.4)), &pressed, colour::OVER), plain);
    let without = Stage::of(&recording, None).unwrap();
    for (stage, frame) in [(&without, &pressed), (&with(None), &weak)] {
        assert!(row(stage, frame, colour::ARROW).is_empty());
    }
    let (depth, labels) = with(None).moment(0, &pressed).depth_and_labels(&camera, size()).unwrap();
    assert!(depth[80 * 200 + 100].is_infinite() && labels[80 * 200 + 100] == 0);
}

/// Tests that a category that comes twice takes no second colour from those after it: the last post looks the same whether the
/// third one, which is behind the camera, is of the first or of the second category.
#[test]
fn a_category_takes_one_colour() {
    let layout = SkinLayout::default();
    let picture = |third: &'static str| {
        let posts = [("reed", 0.2), ("cane", 0.1), (third, -9.0), ("willow", 0.0)].into_iter().enumerate();
        let (bodies, objects): (Vec<_>, Vec<_>) = posts
            .map(|(index, (name, x))| {
                let (body, object) = post(DVec3::X * x);
                let category = Category::new(name, 100).unwrap();
                (Body { owner: BodyOwner::Object(index as u16), ..body }, ObjectRecord { category, ..object })
            })
            .unzip();
        let stage = Stage::new(&bodies, &objects, &layout, 1.0, &[]).unwrap();
        stage.moment(0, &frame()).rgb(&camera(DVec3::ZERO), size()).unwrap()
    };
    assert!(picture("reed") == picture("cane"));
}

/// Tests that a flat surface has the light of the formula, also with shadows: none of it is in its own.
#[test]
fn no_surface_is_in_its_own_shadow() {
    let size_m = DVec3::new(0.5, 0.5, 0.1);
    for turn in [DVec3::ZERO, DVec3::X * 0.5, DVec3::Y * 1.1, DVec3::new(0.9, -0.4, 0.3)] {
        let pose = Pose::from_orientation(DQuat::from_scaled_axis(turn));
        let bodies = [link(BodyShape::Box { size_m }, pose)];
        let layout = SkinLayout::default();
        let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
        // Seen along the normal of its upper side.
        let eye_world = pose.transform_point(DVec3::Z * 2.0);
        let camera = Camera { eye_world, up_world: pose.transform_vector(DVec3::Y), ..camera(DVec3::ZERO) };
        let rgb = stage.moment(0, &frame()).rgb(&camera, size()).unwrap();
        let [around, direct] = colour::light_on(pose.transform_vector(DVec3::Z).as_vec3(), false);
        let expected = colour::shown(colour::linear(colour::ARM) * (around + direct));
        for row in 55..105 {
            for column in 75..125 {
                let place = 3 * (row * 200 + column);
                assert_eq!(rgb[place..place + 3], expected, "turn {turn}, pixel {column}, {row}");
            }
        }
    }
}

/// Tests that bodies without shapes, as of a table of trials, and a recording without frames give an error that says so.
#[test]
fn nothing_to_draw_is_an_error() {
    let layout = SkinLayout::default();
    assert!(matches!(Stage::new(&[], &[], &layout, 1.0, &[]), Err(RenderError::NoBodies)));
    let mut recording = super::film::reach();
    assert!(Stage::of(&recording, None).is_ok());
    recording.frames.clear();
    assert!(matches!(Stage::of(&recording, None), Err(RenderError::NoBodies)));
}

/// Tests that Cody alone shows every link but those inside others, and hundreds of pixels of the taxels' plates.
#[test]
fn an_arm_alone_is_seen_with_its_skin() {
    let arm = underbrush_sim::arm::Arm::cody().unwrap();
    let size = Size { width: 640, height: 360 };
    let (scene, camera) = Stage::arm(&arm, size.aspect()).unwrap();
    let rgb = scene.rgb(&camera, size).unwrap();
    let plate = colour::shown(colour::linear(colour::PLATE));
    let plates = rgb.chunks_exact(3).filter(|pixel| **pixel == plate).count();
    assert!(plates > 500, "{plates}");
    let (_, labels) = scene.depth_and_labels(&camera, size).unwrap();
    let seen: std::collections::BTreeSet<u16> = labels.into_iter().filter(|label| *label > 0).collect();
    // Labels begin with the background and the table.
    let shapes = arm.links.iter().enumerate().filter(|(_, link)| !link.colliders.is_empty());
    let expected: std::collections::BTreeSet<u16> = shapes.map(|(link, _)| link as u16 + 2).collect();
    assert!(seen.is_subset(&expected) && seen.len() >= 4, "{seen:?} of {expected:?}");
}
