//! Recordings with any numbers, for property tests.

use glam::{DQuat, DVec3};
use proptest::prelude::*;
use proptest::sample::Index;

use crate::{
    Audit, Body, BodyOwner, BodyPart, BodyShape, Category, Contact, Frame, GoalRecord, Grid, MappedObstacle,
    ObjectRecord, ObstacleKind, Outcome, Patch, Pose, Recording, SafetyStop, SkinLayout, Taxel, TaxelReading,
};

/// Any finite number, including −0, subnormals and the largest.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => any::<f64>().prop_filter("finite", |value| value.is_finite()),
        2 => -20.0..20.0f64,
        1 => prop::sample::select(vec![0.0, -0.0, f64::MIN_POSITIVE / 8.0, f64::MAX, -f64::MAX, 0.1]),
    ]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

fn pose() -> impl Strategy<Value = Pose> {
    (vector(), [number(), number(), number(), number()])
        .prop_map(|(position, [x, y, z, w])| Pose { position, orientation: DQuat::from_xyzw(x, y, z, w) })
}

fn taxel() -> impl Strategy<Value = Taxel> {
    (vector(), vector(), vector(), number()).prop_map(|(position_link, normal_link, tangent_link, area_m2)| Taxel {
        position_link,
        normal_link,
        tangent_link,
        area_m2,
    })
}

fn patch() -> impl Strategy<Value = Patch> {
    let parts = (1..4usize, 1..4usize, prop::option::of(prop::bool::ANY), "[ -.0-~]{0,6}");
    parts.prop_flat_map(|(rows, columns, wraps, link)| {
        let grid = wraps.map(|wraps| Grid { rows, columns, wraps });
        prop::collection::vec(taxel(), rows * columns).prop_map(move |taxels| Patch {
            name: String::new(),
            link: link.clone(),
            grid,
            taxels,
        })
    })
}

fn object() -> impl Strategy<Value = ObjectRecord> {
    let parameters = prop::collection::btree_map("[a-z_]{1,12}", number(), 0..4);
    ("[a-z_]{1,9}", prop::sample::select(Category::BUILT_IN.to_vec()), vector(), parameters).prop_map(
        |(kind, category, position_world, parameters)| ObjectRecord { kind, category, position_world, parameters },
    )
}

fn goal() -> impl Strategy<Value = GoalRecord> {
    let reason = prop::option::of("[a-z: ]{1,9}");
    (vector(), number(), number(), prop::sample::select(Outcome::ALL.to_vec()), reason).prop_map(
        |(position_world, start_time_s, end_time_s, outcome, reason)| GoalRecord {
            position_world,
            start_time_s,
            end_time_s,
            outcome,
            safety_stop: None,
            given_up: reason.filter(|_| outcome == Outcome::Stuck),
        },
    )
}

/// A place where something presses on the arm: link, patch and object from any indices.
fn place(layout: &SkinLayout, objects: usize, patch: Option<Index>, object: Index) -> (String, Option<u16>, u16) {
    let patches = layout.patches.len();
    let patch = patch.filter(|_| patches > 0).map(|patch| patch.index(patches));
    let link = patch.map_or("bare link".to_string(), |patch| layout.patches[patch].link.clone());
    (link, patch.map(|patch| patch as u16), object.index(objects) as u16)
}

/// Forces and object of a taxel, and whether it is listed at all.
type RawReading = ([f64; 4], Option<Index>, bool);

fn frame(joints: usize, layout: SkinLayout, objects: usize) -> impl Strategy<Value = Frame> {
    let joint = || prop::collection::vec(number(), joints);
    let patches = layout.patches.len();
    let readings = layout.taxel_count();
    let reading = ([number(), number(), number(), number()], prop::option::of(any::<Index>()), any::<bool>());
    (
        (number(), joint(), joint(), joint(), joint()),
        (pose(), vector(), any::<u16>()),
        prop::collection::vec(pose(), patches),
        prop::collection::vec(vector(), patches),
        prop::collection::vec(reading, readings),
    )
        .prop_map(
            move |(state, (end_effector_pose_world, goal_position_world, goal_index), poses, forces, raw)| Frame {
                time_s: state.0,
                joint_angle_rad: state.1,
                joint_velocity_rad_per_s: state.2,
                equilibrium_angle_rad: state.3,
                joint_torque_nm: state.4,
                end_effector_pose_world,
                goal_position_world,
                goal_index,
                patch_pose_world: poses,
                contact_force_world: forces,
                taxels: readings_of(&layout, &raw, objects),
                contact_points: Vec::new(),
            },
        )
}

fn readings_of(layout: &SkinLayout, raw: &[RawReading], objects: usize) -> Vec<TaxelReading> {
    let places = layout.patches.iter().enumerate();
    let places = places.flat_map(|(patch, part)| (0..part.taxels.len()).map(move |taxel| (patch, taxel)));
    let readings = places.zip(raw).filter(|(_, (.., listed))| *listed).map(|((patch, taxel), (forces, object, _))| {
        let object = object.filter(|_| objects > 0).map(|object| object.index(objects) as u16);
        let [true_normal_force_n, first_shear, second_shear, sensed_force_n] = *forces;
        let sensed_force_n = f64::from(sensed_force_n.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32);
        TaxelReading {
            patch: patch as u16,
            taxel: taxel as u16,
            true_normal_force_n,
            true_shear_force_n: [first_shear, second_shear],
            sensed_force_n,
            object,
        }
    });
    let speaks = |reading: &TaxelReading| {
        let shear = reading.true_shear_force_n;
        reading.object.is_some()
            || [reading.true_normal_force_n, shear[0], shear[1], reading.sensed_force_n].iter().any(|&n| n != 0.0)
    };
    readings.filter(speaks).collect()
}

fn audit() -> impl Strategy<Value = Audit> {
    let counts = prop::collection::vec(any::<u32>(), Audit::COUNTS.len());
    (counts, prop::collection::vec(number(), Audit::FIELDS.len())).prop_map(|(counts, figures)| {
        let mut audit = Audit::default();
        for (field, count) in Audit::COUNTS.iter().zip(counts) {
            (field.set)(&mut audit, count);
        }
        for (field, figure) in Audit::FIELDS.iter().zip(figures) {
            (field.set)(&mut audit, figure);
        }
        audit
    })
}

/// Makes times, orientations and forces physical: times at the frame rate, unit quaternions, forces that push.
fn physical(mut recording: Recording) -> Recording {
    let normalize = |pose: &mut Pose| {
        let unit = pose.orientation.normalize();
        let is_unit = (unit.length() - 1.0).abs() < 1e-9;
        pose.orientation = if is_unit { unit } else { DQuat::IDENTITY };
    };
    for goal in &mut recording.goals {
        let times = [goal.start_time_s, goal.end_time_s];
        [goal.start_time_s, goal.end_time_s] = [times[0].min(times[1]), times[0].max(times[1])];
    }
    for contact in &mut recording.contacts {
        contact.peak_force_n = contact.peak_force_n.abs();
        contact.mean_force_n = contact.mean_force_n.abs();
    }
    for (index, frame) in recording.frames.iter_mut().enumerate() {
        frame.time_s = (index as f64 + 0.25) / recording.rate_hz;
        normalize(&mut frame.end_effector_pose_world);
        frame.patch_pose_world.iter_mut().for_each(normalize);
        for reading in &mut frame.taxels {
            reading.true_normal_force_n = reading.true_normal_force_n.abs();
            reading.sensed_force_n = reading.sensed_force_n.abs();
        }
    }
    recording
}

fn unit_pose() -> impl Strategy<Value = Pose> {
    ([-2.0..2.0f64, -2.0..2.0, -2.0..2.0], [-3.0..3.0f64, -1.5..1.5, -3.0..3.0]).prop_map(|(position, [a, b, c])| {
        Pose { position: DVec3::from_array(position), orientation: DQuat::from_euler(glam::EulerRot::ZYX, a, b, c) }
    })
}

fn shape() -> impl Strategy<Value = BodyShape> {
    prop_oneof![
        number().prop_map(|radius_m| BodyShape::Sphere { radius_m }),
        (number(), number()).prop_map(|(radius_m, length_m)| BodyShape::Cylinder { radius_m, length_m }),
        (number(), number()).prop_map(|(radius_m, length_m)| BodyShape::Capsule { radius_m, length_m }),
        vector().prop_map(|size_m| BodyShape::Box { size_m }),
        prop::collection::vec(vector(), 0..5).prop_map(|points_m| BodyShape::Hull { points_m }),
    ]
}

/// Bodies that were observed for some frames; bodies of objects only if there are objects.
fn bodies(objects: usize, frames: usize) -> impl Strategy<Value = Vec<Body>> {
    let part = (shape(), unit_pose()).prop_map(|(shape, pose_body)| BodyPart { shape, pose_body });
    let parts = prop::collection::vec(part, 0..3);
    let poses = prop::collection::vec(prop::option::of(unit_pose()), frames);
    let body = (prop::option::of(any::<Index>()), parts, unit_pose(), poses);
    let body = body.prop_map(move |(object, parts, rest_pose_world, poses)| {
        let object = object.filter(|_| objects > 0);
        let mut body = Body {
            owner: object
                .map_or(BodyOwner::Link("a link".into()), |object| BodyOwner::Object(object.index(objects) as u16)),
            parts,
            rest_pose_world,
            track: Vec::new(),
        };
        for (frame, pose) in poses.iter().enumerate() {
            if let Some(pose) = pose {
                body.observe(frame as u32, pose);
            }
        }
        body
    });
    prop::collection::vec(body, 0..4)
}

/// Any valid recording.
pub(super) fn any_recording() -> impl Strategy<Value = Recording> {
    any_numbers().prop_map(physical)
}

/// An obstacle on a map.
fn obstacle() -> impl Strategy<Value = MappedObstacle> {
    let kind = prop::sample::select(ObstacleKind::ALL.to_vec());
    (kind, [number(), number(), number(), number(), number()], any::<[u32; 2]>()).prop_map(|(kind, numbers, [a, b])| {
        let [x, y, z, radius_m, deviation_m] = numbers;
        let (first_frame, last_frame) = (a.min(b), a.max(b));
        MappedObstacle { kind, top_world: DVec3::new(x, y, z), radius_m, deviation_m, first_frame, last_frame }
    })
}

/// A recording with any numbers.
fn any_numbers() -> impl Strategy<Value = Recording> {
    let parts = (
        prop::collection::vec(patch(), 0..3),
        1..4usize,
        prop::collection::vec(object(), 0..4),
        prop::collection::vec((goal(), prop::option::of((any::<Index>(), number()))), 0..3),
        0..6usize,
        prop::collection::vec(obstacle(), 0..3),
    );
    parts.prop_flat_map(|(patches, joints, objects, goals, frames, map)| {
        let mut layout = SkinLayout { patches };
        for (index, patch) in layout.patches.iter_mut().enumerate() {
            patch.name = format!("patch.{index}");
        }
        let bodies = bodies(objects.len(), frames);
        let frames = prop::collection::vec(frame(joints, layout.clone(), objects.len()), frames);
        let contact = (prop::option::of(any::<Index>()), any::<[Index; 3]>(), number(), number());
        let contacts = prop::collection::vec(contact, 0..4);
        ((frames, bodies), contacts, any::<(u64, u64)>(), 1e-3..1e4f64, audit(), "\\PC{0,8}").prop_map(
            move |((frames, bodies), contacts, (seed, reach_index), rate_hz, audit, scene)| {
                let possible = !objects.is_empty() && !frames.is_empty();
                let contacts = contacts.into_iter().filter(|_| possible).map(|(patch, [object, a, b], peak, mean)| {
                    let (a, b) = (a.index(frames.len()) as u32, b.index(frames.len()) as u32);
                    let (link, patch, object) = place(&layout, objects.len(), patch, object);
                    Contact {
                        link,
                        patch,
                        object,
                        first_frame: a.min(b),
                        last_frame: a.max(b),
                        peak_force_n: peak,
                        mean_force_n: mean,
                    }
                });
                let goals = goals.iter().map(|(goal, stop)| {
                    let stop = stop.filter(|_| goal.outcome == Outcome::Aborted && !objects.is_empty());
                    let safety_stop = stop.map(|(index, force_n)| {
                        let (link, patch, object) = place(&layout, objects.len(), Some(index), index);
                        SafetyStop { object: Some(object).filter(|_| force_n < 100.0), link, patch, force_n }
                    });
                    GoalRecord { safety_stop, ..goal.clone() }
                });
                Recording {
                    scene,
                    controller: "cody-2013".into(),
                    seed,
                    reach_index,
                    rate_hz,
                    joint_names: (0..joints).map(|joint| format!("joint {joint}")).collect(),
                    contacts: contacts.collect(),
                    layout: layout.clone(),
                    objects: objects.clone(),
                    bodies,
                    goals: goals.collect(),
                    map: map.clone(),
                    frames,
                    audit,
                }
            },
        )
    })
}
