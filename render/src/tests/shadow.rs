//! Tests of shadows.

use super::*;
use crate::Stage;

/// Tests that the table is dark exactly where the line to the lamp meets a ball, but for the width of two points of the map.
#[test]
fn the_shadow_of_a_ball_is_where_the_lamp_is_hidden() {
    let lamp = DVec3::new(-0.2242, -0.5231, 0.8222);
    let (center, radius) = (DVec3::new(0.1, -0.1, 0.15), 0.1);
    // The post is behind the camera, and its shadow, too.
    let (post, object) = post(DVec3::new(-1.2, 0.3, -0.1));
    let bodies = [ball(radius, center), post];
    let layout = SkinLayout::default();
    let stage = Stage::new(&bodies, &[object], &layout, 1.0, &[]).unwrap();
    let camera = Camera { eye_world: DVec3::new(0.0, 0.2, 1.5), ..camera(DVec3::new(0.1, 0.1, 0.0)) };
    let size = Size { width: 400, height: 320 };
    let moment = stage.moment(0, &frame());
    let (rgb, labels) = (moment.rgb(&camera, size).unwrap(), moment.depth_and_labels(&camera, size).unwrap().1);
    let (mut dark, mut bright) = (0, 0);
    for (pixel, ray) in rays(&camera, size).into_iter().enumerate() {
        let neighbours = [pixel, pixel.saturating_sub(1), pixel + 1, pixel.saturating_sub(400), pixel + 400];
        if !neighbours.iter().all(|place| labels.get(*place) == Some(&1)) {
            continue;
        }
        let place = camera.eye_world + ray * ((-0.1 - camera.eye_world.z) / ray.z);
        let off = (center - place).reject_from_normalized(lamp).length();
        let red = rgb[3 * pixel];
        // Lines of the table are a little darker than the rest.
        if off < radius - 0.015 {
            assert!(red < 180, "{place}: {red} in the shadow");
            dark += 1;
        } else if off > radius + 0.01 {
            assert!(red > 200, "{place}: {red} in the light");
            bright += 1;
        }
    }
    assert!(dark > 500 && bright > 5000, "{dark} dark, {bright} bright");
}
