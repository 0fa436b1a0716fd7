//! Tests of pictures against closed forms.

use glam::DVec3;
use underbrush_recording::{
    Body, BodyOwner, BodyPart, BodyShape, Category, Frame, ObjectRecord, Patch, Pose, SkinLayout, Taxel, TaxelReading,
};

use crate::{Camera, Size};

mod camera;
mod colour;
mod film;
mod mesh;
mod picture;
mod raster;
mod shadow;

fn body(owner: BodyOwner, shape: BodyShape, pose: Pose) -> Body {
    let parts = vec![BodyPart { shape, pose_body: Pose::IDENTITY }];
    Body { owner, parts, rest_pose_world: pose, track: Vec::new() }
}

fn link(shape: BodyShape, pose: Pose) -> Body {
    body(BodyOwner::Link("arm".into()), shape, pose)
}

fn ball(radius_m: f64, center: DVec3) -> Body {
    link(BodyShape::Sphere { radius_m }, Pose::from_position(center))
}

/// A post with its foot here, so that there is a table.
fn post(foot: DVec3) -> (Body, ObjectRecord) {
    let shape = BodyShape::Cylinder { radius_m: 0.02, length_m: 0.2 };
    let object = ObjectRecord {
        kind: "trunk".into(),
        category: Category::TRUNK,
        position_world: foot,
        parameters: Default::default(),
    };
    (body(BodyOwner::Object(0), shape, Pose::from_position(foot + DVec3::Z * 0.1)), object)
}

/// A camera at (-1, -0.6, 0.5) that looks at a point.
fn camera(target_world: DVec3) -> Camera {
    let eye_world = DVec3::new(-1.0, -0.6, 0.5);
    Camera { eye_world, target_world, up_world: DVec3::Z, vertical_fov_deg: 40.0 }
}

fn size() -> Size {
    Size { width: 200, height: 160 }
}

/// A frame of an arm without skin whose goal is far behind the camera.
fn frame() -> Frame {
    Frame { goal_position_world: DVec3::new(-9.0, 0.0, 0.0), ..Frame::blank(0) }
}

/// The direction from the eye through the middle of each pixel; its length is 1 along the line of sight. Computed apart from
/// the renderer.
fn rays(camera: &Camera, size: Size) -> Vec<DVec3> {
    let forward = (camera.target_world - camera.eye_world).normalize();
    let right = forward.cross(camera.up_world).normalize();
    let up = right.cross(forward);
    let tangent = (0.5 * camera.vertical_fov_deg.to_radians()).tan();
    let at = |pixel: usize| {
        let x = (2.0 * ((pixel % size.width) as f64 + 0.5) / size.width as f64 - 1.0) * tangent * size.aspect();
        let y = (1.0 - 2.0 * ((pixel / size.width) as f64 + 0.5) / size.height as f64) * tangent;
        forward + right * x + up * y
    };
    (0..(size.width * size.height)).map(at).collect()
}
