//! Tests of files.

use underbrush_recording::Recording;
use underbrush_sim::{Observed, ReachPlan, ReachSoFar, Scene};

use super::*;
use crate::scene::png;
use crate::{Film, Stage};

/// A short reach past a trunk.
pub fn reach() -> Recording {
    let text = "summary = \"A trunk and leaves\"\n[[objects.foam_block]]\ncount = 2\n[[objects.leaf]]\ncount = 2\n\
                [[objects.trunk]]\ncount = 1\n";
    let plan = ReachPlan::new(Scene::parse("trunk.toml", text.into()).unwrap(), None, 1).unwrap();
    let mut recording = plan.run(0, &mut |_| {}).unwrap();
    recording.frames.truncate(150);
    recording
}

/// Tests that a film has the frames that its speed asks for, that each picture of the decoded file is near the drawn one, and
/// that its bytes do not depend on the number of threads.
#[test]
fn films_are_the_same_for_any_number_of_threads() {
    let recording = reach();
    let stage = Stage::of(&recording, Some(3.0)).unwrap();
    let size = Size { width: 96, height: 64 };
    let camera = stage.camera(size.aspect());
    let film = Film { size, delay: 5, speed: 2.0 };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| film.draw(&recording, &stage, |_| Ok(camera), |_| {}).unwrap())
    };
    let bytes = with(1);
    assert!(bytes == with(3), "threads change the film");
    let frames = film.frames(&recording);
    assert_eq!(frames, (0..15).map(|picture| 10 * picture).collect::<Vec<_>>());
    let mut decoder = gif::DecodeOptions::new();
    decoder.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = decoder.read_info(bytes.as_slice()).unwrap();
    let mut screen = vec![0_u8; 3 * (size.width * size.height)];
    for number in &frames {
        let frame = decoder.read_next_frame().unwrap().unwrap();
        assert_eq!(frame.delay, 5);
        for (own, new) in screen.chunks_mut(3).zip(frame.buffer.chunks(4)) {
            if new[3] > 0 {
                own.copy_from_slice(&new[..3]);
            }
        }
        let drawn = stage.moment(*number as u32, &recording.frames[*number]).rgb(&camera, size).unwrap();
        let off = screen.iter().zip(&drawn).map(|(own, drawn)| f64::from(own.abs_diff(*drawn)));
        // Six bits a channel alone are off by 1 on average.
        let mean = off.sum::<f64>() / drawn.len() as f64;
        assert!(mean < 3.0, "frame {number}: {mean} of 255");
    }
    assert!(decoder.read_next_frame().unwrap().is_none());
}

/// Tests that a running simulation is drawn as its recording is, from a place that stays while the arm moves.
#[test]
fn a_simulation_is_drawn_like_its_recording() {
    let text = "summary = \"A trunk\"\n[[objects.trunk]]\ncount = 1\n";
    let plan = ReachPlan::new(Scene::parse("trunk.toml", text.into()).unwrap(), None, 1).unwrap();
    let mut simulation = plan.simulation(0).unwrap();
    let mut so_far = ReachSoFar::new(&plan, 0);
    let mut angles = plan.arm.start_posture_rad();
    let size = Size { width: 120, height: 90 };
    let goal = simulation.clutter().goals[0];
    let (_, first, _) = Stage::now(&simulation, &simulation.frame(0, goal), None, size.aspect(), false).unwrap();
    for _ in 0..60 {
        so_far.observe(Observed { simulation: &simulation, frame: &simulation.frame(0, goal), map: &[] });
        angles.iter_mut().for_each(|angle| *angle += 0.004);
        simulation.step(&angles);
    }
    let frame = simulation.frame(0, goal);
    so_far.observe(Observed { simulation: &simulation, frame: &frame, map: &[] });
    let recording = so_far.recording().unwrap();
    let (now, camera, labels) = Stage::now(&simulation, &frame, None, size.aspect(), false).unwrap();
    assert_eq!(camera, first);
    let stage = Stage::of(&recording, None).unwrap();
    assert_eq!(labels, stage.labels);
    let (depth, seen) = now.depth_and_labels(&camera, size).unwrap();
    let (recorded_depth, recorded) = stage.moment(60, &frame).depth_and_labels(&camera, size).unwrap();
    let bodies = (0..seen.len()).filter(|pixel| seen[*pixel] > 1 || recorded[*pixel] > 1);
    let bodies: Vec<usize> = bodies.collect();
    assert!(bodies.len() > 500, "{}", bodies.len());
    assert!(bodies.iter().all(|pixel| seen[*pixel] == recorded[*pixel] && depth[*pixel] == recorded_depth[*pixel]));
    let (start, _) = stage.moment(0, &recording.frames[0]).depth_and_labels(&camera, size).unwrap();
    assert!(bodies.iter().any(|pixel| (start[*pixel] - depth[*pixel]).abs() > 0.05), "the arm has not moved");
}

/// Tests that a PNG holds the very bytes of its picture.
#[test]
fn png_keeps_every_byte() {
    let size = Size { width: 64, height: 65 };
    let rgb: Vec<u8> = (0..3 * (size.width * size.height)).map(|byte| (byte * byte % 251) as u8).collect();
    let bytes = png(&rgb, size).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut read = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut read).unwrap();
    assert_eq!((info.width, info.height), (64, 65));
    assert_eq!(read, rgb);
}

/// Tests that a picture of every kind of shape is the same, byte for byte, on every machine.
#[test]
fn pictures_are_the_same_everywhere() {
    let at = |x: f64, y: f64| Pose::new(DVec3::new(x, y, 0.1), glam::DQuat::from_xyzw(0.1, -0.3, 0.5, 0.8).normalize());
    let (post, object) = post(DVec3::new(0.5, 0.1, -0.1));
    let bodies = [
        ball(0.1, DVec3::new(0.2, 0.2, 0.2)),
        link(BodyShape::Box { size_m: DVec3::new(0.1, 0.2, 0.3) }, at(0.0, 0.0)),
        link(BodyShape::Capsule { radius_m: 0.05, length_m: 0.2 }, at(0.1, -0.2)),
        link(BodyShape::Capsule { radius_m: 0.005, length_m: 0.3 }, at(0.3, -0.1)),
        link(
            BodyShape::Hull { points_m: vec![DVec3::ZERO, DVec3::X * 0.2, DVec3::Y * 0.2, DVec3::Z * 0.2] },
            at(0.4, 0.3),
        ),
        post,
    ];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[object], &layout, 3.0, &[]).unwrap();
    let size = Size { width: 160, height: 120 };
    let rgb = stage.moment(0, &frame()).rgb(&stage.camera(size.aspect()), size).unwrap();
    let sum =
        rgb.iter().fold(0xcbf2_9ce4_8422_2325_u64, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
    assert_eq!(format!("{sum:016x}"), "aa3cca1af48db0b1");
}
