//! The Rapier world of one clutter and one arm: stepping, contacts out, and leaving out of the solver what rests
//! untouched.

use glam::DVec3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::partitioning::{Bvh, BvhBuildStrategy};
use rapier3d::parry::query::distance;
use rapier3d::prelude::Pose as EnginePose;
use rapier3d::prelude::*;
use underbrush_recording::{FRAME_PERIOD_S, Pose};

use crate::arm::Arm;
use crate::arm::engine::{self, ArmHandles};
use crate::audit::Auditor;
use crate::clutter::{Clutter, PlacedObject};
use crate::geometry::{from_parry, parry_pose};
use crate::physics::{Physics, PhysicsOptions, groups, pressed_points};
use crate::simulation::mechanism::Mechanism;
use crate::skin::ContactPoint;
use crate::touch::Touch;

/// A resting object is put into the solver when a link of the arm comes this near to it, m: the centimetre at which the
/// engine makes contacts, and one frame at 1 m/s, twice the fastest preset's hand speed.
const WAKE_NEAR_ARM_M: f64 = 0.02;
/// The same for parts of other objects that move, m.
const WAKE_NEAR_OBJECTS_M: f64 = 0.01;
/// An object at rest is taken out when everything that moves is farther than those distances and this, m.
const SLEEP_MARGIN_M: f64 = 0.01;

/// One contact point between arm and clutter in one step of the last frame, as the solver left it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverContact {
    /// The link, index in the arm.
    pub link: usize,
    /// The object, index in the clutter.
    pub object: usize,
    /// The object's collision shape.
    pub collider: ColliderHandle,
    /// Position on the link's surface, m, link frame.
    pub position_link: DVec3,
    /// Direction of the normal force on the link, unit, world frame.
    pub inward_world: DVec3,
    /// Its share of the mean force on the link over the frame: impulse, normal and friction, over 10 ms; N, world frame.
    pub force_world: DVec3,
    /// How deep the shapes were in each other when the step began, m; negative while they were still apart.
    pub penetration_m: f64,
}

impl SolverContact {
    /// The contact as the link's skin takes it; `pose` is the link's in the world frame.
    pub fn in_link_frame(&self, pose: &Pose) -> ContactPoint {
        ContactPoint {
            position_link: self.position_link,
            inward_link: pose.inverse_transform_vector(self.inward_world),
            force_link: pose.inverse_transform_vector(self.force_world),
        }
    }
}

/// The engine with one arm and one clutter. A copy goes on as the original does, bit for bit.
#[derive(Clone)]
pub struct World {
    /// The engine.
    pub physics: Physics,
    /// The arm's bodies.
    pub arm: ArmHandles,
    /// Watches every step.
    pub auditor: Auditor,
    contacts: Vec<SolverContact>,
    compliance_m3_per_n: Vec<f64>,
    mechanisms: Vec<Option<Mechanism>>,
    /// The objects at rest.
    outlines: Vec<(Cuboid, EnginePose)>,
    /// Boxes around the outlines: finds what is near without a look at all.
    standing: Bvh,
    dormancy: bool,
}

impl World {
    /// Builds the world: the arm in `posture_rad`, its equilibrium angles there, and the clutter at rest.
    pub fn new(arm: &Arm, posture_rad: &[f64], clutter: &Clutter, options: PhysicsOptions, dormancy: bool) -> Self {
        let mut physics = Physics::new(options);
        let handles = engine::insert_arm(arm, posture_rad, &mut physics, groups::arm());
        let outlines = clutter.objects.iter().map(PlacedObject::outline);
        let outlines: Vec<(Cuboid, EnginePose)> =
            outlines.map(|(outline, pose)| (outline, parry_pose(&pose))).collect();
        let boxes: Vec<Aabb> = outlines.iter().map(|(outline, pose)| outline.aabb(pose)).collect();
        let objects = clutter.objects.iter();
        let mut world = World {
            auditor: Auditor::new(arm, &handles, &physics),
            physics,
            arm: handles,
            contacts: Vec::new(),
            compliance_m3_per_n: objects
                .map(|placed| placed.object.surface_compliance_m3_per_n())
                .collect(),
            mechanisms: (0..clutter.objects.len()).map(|_| None).collect(),
            standing: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            outlines,
            dormancy,
        };
        for index in 0..clutter.objects.len() {
            world.insert(clutter, index);
        }
        if dormancy {
            world.rest_and_wake(clutter);
        }
        world
    }

    /// Advances by one frame of 10 ms with the arm's equilibrium angles at `equilibrium_rad`.
    pub fn advance_frame(&mut self, arm: &Arm, equilibrium_rad: &[f64], clutter: &Clutter) {
        self.contacts.clear();
        let steps = (FRAME_PERIOD_S / self.physics.options.step_s).round() as usize;
        for _ in 0..steps {
            self.arm.set_equilibrium(arm, equilibrium_rad, &mut self.physics);
            for mechanism in self.mechanisms.iter_mut().flatten() {
                mechanism.relax(&mut self.physics);
            }
            self.physics.step();
            let earlier = self.contacts.len();
            self.gather_contacts();
            let contacts = &self.contacts[earlier..];
            self.auditor.observe_step(arm, &self.arm, &self.physics, contacts);
        }
        if self.dormancy {
            self.rest_and_wake(clutter);
        }
    }

    /// The contacts between arm and clutter in the last frame, step by step; their forces add up to the mean force over
    /// the frame.
    ///
    /// The mean, because a taxel's electronics integrate over their period: a link that meets a rigid trunk is stopped
    /// within one substep, and a force sampled then would be a matter of luck.
    pub fn contacts(&self) -> &[SolverContact] {
        &self.contacts
    }

    fn gather_contacts(&mut self) {
        for (collider, link) in &self.arm.colliders {
            let mut pairs: Vec<&ContactPair> = self.physics.narrow_phase.contact_pairs_with(*collider).collect();
            pairs.sort_by_key(|pair| (pair.collider1.into_raw_parts(), pair.collider2.into_raw_parts()));
            for pair in pairs {
                let arm_is_first = pair.collider1 == *collider;
                let other = if arm_is_first { pair.collider2 } else { pair.collider1 };
                let Some(object) = object_of(&self.physics.colliders[other]) else {
                    continue;
                };
                for manifold in pair.manifolds() {
                    // The normal points from the first shape to the second; the first is pushed against it.
                    let sign = if arm_is_first { -1.0 } else { 1.0 };
                    for point in pressed_points(manifold) {
                        let on_shape = if arm_is_first { point.local_p1 } else { point.local_p2 };
                        let shape = &self.physics.colliders[*collider];
                        let on_link = shape
                            .position_wrt_parent()
                            .map_or(on_shape, |pose| pose.transform_point(on_shape));
                        let inward_world = manifold.data.normal * sign;
                        let impulse = inward_world * point.data.impulse
                            - friction_impulse_on_first(&point.data, -manifold.data.normal) * sign;
                        self.contacts.push(SolverContact {
                            link: *link,
                            object,
                            collider: other,
                            position_link: on_link,
                            inward_world,
                            force_world: impulse / FRAME_PERIOD_S,
                            penetration_m: -point.dist,
                        });
                    }
                }
            }
        }
    }

    /// Lets the auditor see a frame that is about to be recorded.
    pub fn audit_frame(&mut self, arm: &Arm, touch: &Touch) {
        self.auditor.observe_frame(arm, &self.contacts, touch);
    }

    /// How far an object's surface gives way under pressure, m³/N.
    pub fn surface_compliance_m3_per_n(&self, object: usize) -> f64 {
        self.compliance_m3_per_n[object]
    }

    /// Pose of a link in the world frame.
    pub fn link_pose(&self, link: usize) -> Pose {
        from_parry(self.physics.bodies[self.arm.links[link]].position())
    }

    /// Number of objects that are in the solver now.
    pub fn active_objects(&self) -> usize {
        self.mechanisms.iter().flatten().count()
    }

    /// The collision shapes of an object, `None` while it is left out of the solver.
    pub fn colliders_of(&self, object: usize) -> Option<&[ColliderHandle]> {
        self.mechanisms.get(object)?.as_ref().map(Mechanism::colliders)
    }

    fn insert(&mut self, clutter: &Clutter, index: usize) {
        let placed = &clutter.objects[index];
        let structure = placed.object.structure();
        let mechanism = Mechanism::build(&structure, &mut self.physics, placed.foot_world, placed.yaw_rad);
        for collider in mechanism.colliders() {
            self.physics.colliders[*collider].user_data = index as u128 + 1;
        }
        self.mechanisms[index] = Some(mechanism);
    }

    /// Takes out every object that rests with nothing moving near it, and inserts every absent one that something
    /// moving has come near to.
    fn rest_and_wake(&mut self, clutter: &Clutter) {
        let movers: Vec<Mover> = self.movers().collect();
        self.retire(&movers);
        self.wake(clutter, &movers);
    }

    fn wake(&mut self, clutter: &Clutter, movers: &[Mover]) {
        let mut near: Vec<usize> = Vec::new();
        for mover in movers {
            for index in self.standing.intersect_aabb(&mover.bounds) {
                let index = index as usize;
                if self.mechanisms[index].is_none() && !near.contains(&index) && self.is_near(mover, index, 0.0) {
                    near.push(index);
                }
            }
        }
        // In the order of the clutter, whatever the tree's.
        near.sort_unstable();
        for index in near {
            self.insert(clutter, index);
        }
    }

    fn retire(&mut self, movers: &[Mover]) {
        for index in 0..self.mechanisms.len() {
            let resting = self.mechanisms[index]
                .as_ref()
                .is_some_and(|mechanism| mechanism.is_movable() && mechanism.is_at_rest(&self.physics));
            if resting
                && !movers.iter().any(|mover| self.is_near(mover, index, SLEEP_MARGIN_M))
                && let Some(mechanism) = self.mechanisms[index].take()
            {
                mechanism.remove(&mut self.physics);
            }
        }
    }

    /// The arm's collision shapes and those of every object that is not at rest.
    fn movers(&self) -> impl Iterator<Item = Mover> {
        let mover = |collider: ColliderHandle, distance_m: f64| Mover {
            collider,
            bounds: self.physics.colliders[collider].compute_aabb().loosened(distance_m),
            distance_m,
        };
        let arm = self.arm.colliders.iter();
        let objects = self
            .mechanisms
            .iter()
            .flatten()
            .filter(|mechanism| mechanism.is_movable() && !mechanism.is_at_rest(&self.physics))
            .flat_map(|mechanism| mechanism.colliders());
        arm.map(move |(collider, _)| mover(*collider, WAKE_NEAR_ARM_M))
            .chain(objects.map(move |collider| mover(*collider, WAKE_NEAR_OBJECTS_M)))
    }

    /// Whether a mover is nearer to an object at rest than its waking distance and a margin.
    fn is_near(&self, mover: &Mover, index: usize, margin_m: f64) -> bool {
        let (outline, pose) = &self.outlines[index];
        let collider = &self.physics.colliders[mover.collider];
        mover.bounds.loosened(margin_m).intersects(&outline.aabb(pose))
            // A pair that the engine cannot measure counts as near.
            && distance(collider.position(), collider.shape(), pose, outline)
                .map_or(true, |found| found.distance < mover.distance_m + margin_m)
    }
}

/// A collision shape that may touch what rests.
struct Mover {
    collider: ColliderHandle,
    /// The box within which it wakes.
    bounds: Aabb,
    /// How near it must come to wake, m.
    distance_m: f64,
}

/// The object that a collision shape belongs to: its mark is the object's index plus one, the arm's shapes have none.
fn object_of(collider: &Collider) -> Option<usize> {
    collider.user_data.checked_sub(1).map(|index| index as usize)
}

/// Friction impulse on the first body over a whole step, N s, world frame.
///
/// The engine gives it as two numbers along tangents t₁ and t₂ = d × t₁ that it does not tell (d is the direction in
/// which the contact pushes the first body), but for the last substep both as two numbers (a, b) and as the vector
/// w = a t₁ + b t₂. So t₁ = (a w − b d × w) / (a² + b²). Where the last substep had no friction the tangents are not to
/// be had, and the friction of the earlier substeps, a contact just breaking, is left out.
fn friction_impulse_on_first(data: &ContactData, direction: DVec3) -> DVec3 {
    let [a, b] = [data.warmstart_tangent_impulse.x, data.warmstart_tangent_impulse.y];
    let squared = a * a + b * b;
    if squared == 0.0 {
        return DVec3::ZERO;
    }
    let vector = data.warmstart_tangent_world;
    let first = (vector * a - direction.cross(vector) * b) / squared;
    first * data.tangent_impulse.x + direction.cross(first) * data.tangent_impulse.y
}
