//! Tests of cameras.

use super::*;
use crate::{RenderError, Stage};

/// Tests that the standard camera has everything in the picture, and that it is no farther away than that needs.
#[test]
fn the_standard_camera_sees_everything() {
    let shapes = [DVec3::new(1.5, 0.2, 0.3), DVec3::new(0.1, 0.1, 2.0), DVec3::splat(0.4)];
    for (size_m, [width, height]) in shapes.into_iter().zip([[320, 240], [1280, 300], [64, 640]]) {
        let bodies = [link(BodyShape::Box { size_m }, Pose::from_position(DVec3::new(3.0, -1.0, 0.5)))];
        let layout = SkinLayout::default();
        let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
        let size = Size { width, height };
        let labels = stage.moment(0, &frame()).depth_and_labels(&stage.camera(size.aspect()), size).unwrap().1;
        let seen = |place: &usize| labels[*place] == 2;
        let places = || (0..labels.len()).filter(seen);
        let columns =
            (places().map(|place| place % width).min().unwrap(), places().map(|place| place % width).max().unwrap());
        let rows = (places().min().unwrap() / width, places().max().unwrap() / width);
        assert!(columns.0 > 0 && columns.1 + 1 < width && rows.0 > 0 && rows.1 + 1 < height, "{columns:?} {rows:?}");
        let filled = [(columns.1 - columns.0) as f64 / width as f64, (rows.1 - rows.0) as f64 / height as f64];
        assert!(filled[0].max(filled[1]) > 0.9, "{filled:?}");
        // It is in the middle.
        assert!((columns.0 as f64 - (width - columns.1) as f64).abs() < 0.06 * width as f64 + 2.0, "{columns:?}");
        assert!((rows.0 as f64 - (height - rows.1) as f64).abs() < 0.06 * height as f64 + 2.0, "{rows:?}");
    }
}

/// Tests that sizes and cameras that give no picture are refused with what is allowed.
#[test]
fn impossible_cameras_are_refused() {
    for (width, height) in [(63, 240), (320, 1281), (0, 0)] {
        let error = Size { width, height }.check().unwrap_err();
        assert!(error.to_string().contains("64 to 1280"), "{error}");
    }
    let bodies = [ball(0.1, DVec3::ZERO)];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[], &layout, 1.0, &[]).unwrap();
    let moment = stage.moment(0, &frame());
    let good = camera(DVec3::ZERO);
    assert!(moment.rgb(&good, size()).is_ok());
    for bad in [
        Camera { target_world: good.eye_world, ..good },
        Camera { up_world: good.eye_world, ..good },
        Camera { up_world: DVec3::ZERO, ..good },
        Camera { eye_world: DVec3::NAN, ..good },
        Camera { target_world: DVec3::X * f64::INFINITY, ..good },
        Camera { vertical_fov_deg: 0.0, ..good },
        Camera { vertical_fov_deg: f64::NAN, ..good },
    ] {
        assert!(matches!(moment.rgb(&bad, size()), Err(RenderError::Camera(_))), "{bad:?}");
    }
}
