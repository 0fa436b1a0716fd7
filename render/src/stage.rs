//! The bodies of a reach, made into triangles once, and placed for each moment.

use std::ops::Range;

use glam::DVec3;
use underbrush_recording::{
    Body, BodyOwner, BodyShape, Frame, MappedObstacle, ObjectRecord, Pose, Recording, SkinLayout, TrackPoint, distinct,
};
use underbrush_sim::blade::Blade;
use underbrush_sim::body_log::{BodyLog, link_bodies};
use underbrush_sim::scene::SceneCamera;
use underbrush_sim::{Arm, Simulation};

use crate::camera::bounds;
use crate::mesh::Mesh;
use crate::scene::{Kind, Scene, Surface};
use crate::{Camera, RenderError, colour, marks};

/// The label of the table; that of the background is 0.
const TABLE: u16 = 1;
/// From where everything is seen: an arm that reaches along x reaches to the right, and the lamp is to the left. Choice.
const DIRECTION: DVec3 = DVec3::new(0.2, -1.2, 0.8);
/// Thickness of the table, m.
const TABLE_M: f64 = 0.03;
/// Width of the table around everything that is seen, m.
const MARGIN_M: f64 = 0.15;
/// The colours of forces end here if nobody knows yet how large they will be, N. Choice: most contacts stay below.
const LIVE_N: f64 = 5.0;
/// The camera sees a body at about this many of its poses.
const POSES: usize = 8;

/// A link or an object: its bodies, which follow one another.
struct Part {
    bodies: Range<usize>,
    surface: Surface,
}

/// What of a reach stays the same while it moves.
pub struct Stage<'a> {
    bodies: &'a [Body],
    meshes: Vec<Mesh>,
    parts: Vec<Part>,
    layout: &'a SkinLayout,
    map: &'a [MappedObstacle],
    /// What the numbers of [`Scene::depth_and_labels`] mean: 0 is the background, 1 the table; then follow links and
    /// objects with their numbers and categories, in the order of the recording's bodies.
    pub labels: Vec<String>,
    /// Points of everything that the camera should see, m, world frame.
    seen: Vec<DVec3>,
    table: Option<(Mesh, Pose)>,
    /// The force at the end of the colour scale, N.
    full_scale_n: f64,
    /// The controller's limit, N, infinite without one.
    force_limit_n: f64,
    has_arrows: bool,
}

impl<'a> Stage<'a> {
    /// The stage of a recording. The colours of forces end, as on the replay page, at the largest force that a taxel
    /// senses in it, but not below the controller's limit, N.
    ///
    /// # Errors
    /// As [`Stage::new`], and if the recording has no frames.
    pub fn of(recording: &'a Recording, force_limit_n: Option<f64>) -> Result<Self, RenderError> {
        if recording.frames.is_empty() {
            return Err(RenderError::NoBodies);
        }
        let readings = recording.frames.iter().flat_map(|frame| &frame.taxels);
        let largest_n = readings.map(|reading| reading.sensed_force_n).fold(force_limit_n.unwrap_or(1.0), f64::max);
        let goals: Vec<DVec3> = recording.goals.iter().map(|goal| goal.position_world).collect();
        let mut stage = Stage::new(&recording.bodies, &recording.objects, &recording.layout, largest_n, &goals)?;
        for (body, mesh) in stage.bodies.iter().zip(&stage.meshes) {
            // Some of its poses, and the last one.
            let poses = body.track.iter().rev().step_by(body.track.len() / POSES + 1).map(TrackPoint::pose);
            stage.seen.extend(poses.flat_map(|pose| placed(mesh, pose)));
        }
        stage.map = &recording.map;
        stage.force_limit_n = force_limit_n.unwrap_or(f64::INFINITY);
        stage.set_table(&recording.objects);
        Ok(stage)
    }

    /// With an arrow for each contact that the frames list, as on the replay page: red where a taxel senses more than the
    /// controller's limit. It is for readers; what a camera sees has none.
    #[must_use]
    pub fn with_arrows(self) -> Self {
        Stage { has_arrows: true, ..self }
    }

    /// Bodies with the objects and the skin that belong to them. The colours of forces end at `full_scale_n`, N. Table and
    /// camera are chosen for the poses at rest and for `places_world`, m, such as the goals, so that they are the same in every
    /// frame of a running simulation.
    ///
    /// # Errors
    /// [`RenderError::NoBodies`] if no body has a shape.
    pub fn new(
        bodies: &'a [Body],
        objects: &[ObjectRecord],
        layout: &'a SkinLayout,
        full_scale_n: f64,
        places_world: &[DVec3],
    ) -> Result<Self, RenderError> {
        let is_table = |object: u16| objects.get(usize::from(object)).is_some_and(|object| object.kind == "table");
        // The table is drawn under whatever is seen, whether it is an object or not, so that its own shape is left out.
        let mesh = |body: &Body| match body.owner {
            BodyOwner::Object(object) if is_table(object) => Mesh::default(),
            _ => Mesh::of_parts(&body.parts),
        };
        let meshes: Vec<Mesh> = bodies.iter().map(mesh).collect();
        if meshes.iter().all(|mesh| mesh.triangles.is_empty()) {
            return Err(RenderError::NoBodies);
        }
        let categories = objects.iter().map(|object| object.category.name());
        let further = distinct(categories.filter(|name| !colour::is_known(name)));
        let mut labels = vec!["background".to_owned(), "table".to_owned()];
        let mut parts: Vec<Part> = Vec::new();
        for own in bodies.chunk_by(|one, next| one.owner == next.owner) {
            let first = parts.last().map_or(0, |last| last.bodies.end);
            let label = labels.len() as u16;
            let (name, colour) = match &own[0].owner {
                BodyOwner::Link(name) => (format!("link {name}"), colour::linear(colour::ARM)),
                BodyOwner::Object(object) => {
                    let category = objects.get(usize::from(*object)).map_or("", |object| object.category.name());
                    // Neighbours differ a little in lightness.
                    let lighter = 1.0 + 0.12 * (f32::from(*object % 3) - 1.0);
                    (format!("object {object} {category}"), colour::of_category(category, &further) * lighter)
                }
            };
            labels.push(name);
            let surface = Surface { kind: Kind::Solid, colour, label };
            parts.push(Part { bodies: first..first + own.len(), surface });
        }
        let at_rest = bodies.iter().zip(&meshes).flat_map(|(body, mesh)| placed(mesh, body.rest_pose_world));
        let seen = at_rest.chain(places_world.iter().copied()).collect();
        let mut stage = Stage {
            bodies,
            meshes,
            parts,
            layout,
            map: &[],
            labels,
            seen,
            table: None,
            full_scale_n,
            force_limit_n: f64::INFINITY,
            has_arrows: false,
        };
        stage.set_table(objects);
        Ok(stage)
    }

    /// A running simulation as it is now: everything in it, the camera of a scene or else one that sees everything and stays where
    /// it is while the simulation runs, and the labels. The colours of forces end at 5 N. `has_arrows` as [`Stage::with_arrows`].
    ///
    /// # Errors
    /// [`RenderError::NoBodies`] and [`RenderError::Link`].
    pub fn now(
        simulation: &Simulation,
        frame: &Frame,
        camera: Option<&SceneCamera>,
        aspect: f64,
        has_arrows: bool,
    ) -> Result<(Scene, Camera, Vec<String>), RenderError> {
        let (bodies, clutter) = (BodyLog::now(simulation).bodies, simulation.clutter());
        let layout = &simulation.arm().skin.layout;
        let stage = Stage::new(&bodies, &clutter.records(), layout, LIVE_N, &clutter.goals)?;
        let stage = Stage { has_arrows, ..stage };
        let camera = camera.map_or_else(|| Ok(stage.camera(aspect)), |camera| stage.scene_camera(camera, u32::MAX))?;
        Ok((stage.moment(u32::MAX, frame), camera, stage.labels))
    }

    /// An arm alone in its start posture, with its taxels and a mark at its end effector.
    ///
    /// # Errors
    /// [`RenderError::NoBodies`].
    pub fn arm(arm: &Arm, aspect: f64) -> Result<(Scene, Camera), RenderError> {
        let poses = arm.forward_kinematics(&arm.start_posture_rad());
        let bodies = link_bodies(arm, &poses);
        let (layout, surfaces) = (&arm.skin.layout, &arm.skin.surfaces);
        let frame = Frame {
            patch_pose_world: surfaces.iter().map(|surface| poses[surface.link]).collect(),
            goal_position_world: arm.end_effector_pose(&poses).position,
            ..Frame::blank(surfaces.len())
        };
        let stage = Stage::new(&bodies, &[], layout, LIVE_N, &[frame.goal_position_world])?;
        Ok((stage.moment(0, &frame), stage.camera(aspect)))
    }

    /// Puts a table under the objects, wide enough for everything that is seen.
    fn set_table(&mut self, objects: &[ObjectRecord]) {
        let height = objects.iter().map(|object| object.position_world.z).reduce(f64::min);
        self.table = height.map(|top| {
            let (low, high) = bounds(self.seen.iter().copied());
            let size_m = (high - low + DVec3::splat(2.0 * MARGIN_M)).with_z(TABLE_M);
            let center = ((low + high) / 2.0).with_z(top - 0.5 * TABLE_M);
            (Mesh::of(&BodyShape::Box { size_m }), Pose::from_position(center))
        });
    }

    /// A camera that sees everything, for a picture with this ratio of width to height.
    pub fn camera(&self, aspect: f64) -> Camera {
        Camera::around(&self.seen, DIRECTION, aspect)
    }

    /// A camera of a scene, as it is in the frame with this number.
    ///
    /// # Errors
    /// [`RenderError::Link`] if no link of this name carries it.
    pub fn scene_camera(&self, camera: &SceneCamera, number: u32) -> Result<Camera, RenderError> {
        let pose = match &camera.link {
            None => Pose::IDENTITY,
            Some(link) => {
                let mut links = Vec::new();
                let carrier = self.bodies.iter().find(|body| {
                    let BodyOwner::Link(name) = &body.owner else { return false };
                    links.push(name.as_str());
                    name == link
                });
                let missing = || RenderError::Link { link: link.clone(), links: links.join(", ") };
                carrier.ok_or_else(missing)?.pose_world(number)
            }
        };
        let [eye_world, target_world] = [camera.eye_m, camera.target_m].map(|place| pose.transform_point(place));
        let up_world = pose.orientation * camera.up;
        Ok(Camera { eye_world, target_world, up_world, vertical_fov_deg: camera.vertical_fov_deg })
    }

    /// Everything as it is in the frame with this number, with the skin as this frame says.
    pub fn moment(&self, number: u32, frame: &Frame) -> Scene {
        let mut scene = Scene::default();
        if let Some((mesh, pose)) = &self.table {
            let surface = Surface { kind: Kind::Table, colour: colour::linear(colour::TABLE), label: TABLE };
            scene.add(mesh, pose, surface);
        }
        for part in &self.parts {
            let mut blades = Vec::new();
            for index in part.bodies.clone() {
                let body = &self.bodies[index];
                let pose = body.pose_world(number);
                let is_link = matches!(body.owner, BodyOwner::Link(_));
                if is_link || !Blade::join(&mut blades, &body.parts, &pose) {
                    scene.add(&self.meshes[index], &pose, part.surface);
                }
            }
            for blade in &blades {
                let thin = Surface { kind: Kind::Thin, ..part.surface };
                scene.add(&Mesh::ribbon(blade), &Pose::IDENTITY, thin);
            }
        }
        marks::add_skin(self.layout, self.full_scale_n, frame, &mut scene);
        marks::add_goal(frame, &mut scene);
        let ground_m = self.table.as_ref().map(|(_, pose)| pose.position.z + 0.5 * TABLE_M);
        marks::add_map(self.map, ground_m, number, &mut scene);
        if self.has_arrows {
            marks::add_arrows(frame, self.force_limit_n, &mut scene);
        }
        scene
    }
}

/// The number of the first of the frames in which the most taxels read a force.
pub fn fullest(recording: &Recording) -> usize {
    let felt = recording.frames.iter().map(|frame| frame.taxels.len()).enumerate();
    felt.rev().max_by_key(|(_, taxels)| *taxels).map_or(0, |(number, _)| number)
}

/// The points of a mesh at this pose.
fn placed(mesh: &Mesh, pose: Pose) -> impl Iterator<Item = DVec3> {
    mesh.vertices.iter().map(move |(place, _)| pose.transform_point(*place))
}
