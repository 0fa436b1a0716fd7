//! The engine: one Rapier world, its options and one step.

use rapier3d::prelude::*;

/// Name and version of the engine, for provenance; a test holds the version to that of the lock file.
pub const ENGINE: &str = "rapier3d-f64 0.36.1, enhanced-determinism";

/// Step and solver options of the engine; recorded in the provenance of every data set.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PhysicsOptions {
    /// Length of one engine step, s.
    pub step_s: f64,
    /// Solver substeps in one step.
    pub substeps: usize,
    /// Gravity along −z, m/s².
    pub gravity_m_per_s2: f64,
}

/// Softness of contacts with trunks and foam blocks. The engine scales it with the effective mass m: stiffness
/// m (2π f)², here 1e4 N/m at the arm's 1 kg, which is what the skin's layer (3e7 N/m³) has on the 3–4 cm² of a trunk's
/// contact; critically damped.
const SKIN_ON_FIXED: SpringCoefficients<f64> = SpringCoefficients {
    natural_frequency: 16.0,
    damping_ratio: 1.0,
};

/// Softness of contacts with leaves and rolls: 2e3 N/m at the 5 g that a leaf weighs, so that a leaf's few tenths of a
/// newton press it in by a tenth of a millimetre; critically damped.
const SKIN_ON_BENDABLE: SpringCoefficients<f64> = SpringCoefficients {
    natural_frequency: 100.0,
    damping_ratio: 1.0,
};

/// All state of one Rapier world.
pub struct Physics {
    /// The options it was made with.
    pub options: PhysicsOptions,
    /// Engine parameters derived from the options.
    pub parameters: IntegrationParameters,
    /// Rigid bodies: links, segments, fixed feet.
    pub bodies: RigidBodySet,
    /// Collision shapes.
    pub colliders: ColliderSet,
    /// Multibodies: the arm and every bendable object.
    pub joints: MultibodyJointSet,
    /// Contacts of the last step.
    pub narrow_phase: NarrowPhase,
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    continuous_collision: CCDSolver,
}

/// A copy goes on as the original does, bit for bit: the pipeline holds nothing from one step to the next.
impl Clone for Physics {
    fn clone(&self) -> Self {
        Physics {
            options: self.options,
            parameters: self.parameters,
            bodies: self.bodies.clone(),
            colliders: self.colliders.clone(),
            joints: self.joints.clone(),
            narrow_phase: self.narrow_phase.clone(),
            pipeline: PhysicsPipeline::new(),
            islands: self.islands.clone(),
            broad_phase: self.broad_phase.clone(),
            impulse_joints: self.impulse_joints.clone(),
            soft_bodies: self.soft_bodies.clone(),
            continuous_collision: self.continuous_collision.clone(),
        }
    }
}

impl Physics {
    /// An empty world.
    pub fn new(options: PhysicsOptions) -> Self {
        let parameters = IntegrationParameters {
            dt: options.step_s,
            num_solver_iterations: options.substeps,
            // Recycled contacts may be 5 cm stale: longer than a taxel is wide.
            contact_recycling: false,
            // Clusters would move the impulses away from the contact points that the skin reads.
            contact_clustering: false,
            // Friction acts whenever the contact does; the default is tuned for tall stacks.
            friction_in_bias_pass: true,
            friction_model: FrictionModel::Coulomb,
            // Contacts are soft, as skin over a shell is, instead of rigid with a correction: rigid ones break and come
            // back from step to step while the arm slides, and the force chatters by tens of per cent.
            num_internal_stabilization_iterations: 0,
            static_contact_softness: SKIN_ON_FIXED,
            contact_softness: SKIN_ON_BENDABLE,
            // The fastest preset's hand, 0.5 m/s, comes 5 mm nearer in a frame; more would make contacts of mere neighbours.
            normalized_prediction_distance: 0.005,
            // With one sweep a substep over contacts that push each other the forces lag behind: four bring a trunk's
            // from 5 % off to 1 % at no measurable cost (benches/README.md).
            num_internal_pgs_iterations: 4,
            // Nothing here moves far enough in a step to tunnel: 0.5 m/s × 10 ms is 5 mm.
            max_ccd_substeps: 0,
            ..IntegrationParameters::default()
        };
        Physics {
            options,
            parameters,
            bodies: RigidBodySet::new(),
            colliders: ColliderSet::new(),
            joints: MultibodyJointSet::new(),
            narrow_phase: NarrowPhase::new(),
            pipeline: PhysicsPipeline::new(),
            islands: IslandManager::new(),
            broad_phase: BroadPhaseBvh::new(),
            impulse_joints: ImpulseJointSet::new(),
            soft_bodies: SoftBodySet::new(),
            continuous_collision: CCDSolver::new(),
        }
    }

    /// Advances the world by one step.
    pub fn step(&mut self) {
        let gravity = Vector::new(0.0, 0.0, -self.options.gravity_m_per_s2);
        self.pipeline.step(
            gravity,
            &self.parameters,
            &mut self.islands,
            &mut self.broad_phase,
            &mut self.narrow_phase,
            &mut self.bodies,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft_bodies,
            &mut self.continuous_collision,
            &(),
            &(),
        );
    }

    /// Takes a body with its colliders and joints out of the world.
    pub fn remove_body(&mut self, body: RigidBodyHandle) {
        self.bodies.remove(
            body,
            &mut self.islands,
            &mut self.colliders,
            &mut self.impulse_joints,
            &mut self.joints,
            &mut self.soft_bodies,
            true,
        );
    }
}

/// The points of a manifold that the solver pressed on in the last step.
///
/// The solver takes four points of a manifold at most; the others keep the impulse of the step in which they were last
/// taken, which would be counted again: a blade on the forearm then seems to press with up to twice its force.
pub fn pressed_points(manifold: &ContactManifold) -> impl Iterator<Item = &TrackedContact<ContactData>> {
    let taken = manifold.data.solver_contacts.iter();
    taken
        .filter_map(|contact| manifold.points.get(contact.contact_indices()[0] as usize))
        .filter(|point| point.data.impulse > 0.0)
}

/// Which things collide with which: every collider is in one of these groups.
pub mod groups {
    use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

    const ARM: Group = Group::GROUP_1;
    const FIXED: Group = Group::GROUP_2;
    const BENDABLE: Group = Group::GROUP_3;
    const ROOTED: Group = Group::GROUP_4;

    /// Links of the arm: touch everything but each other.
    pub fn arm() -> InteractionGroups {
        InteractionGroups::new(ARM, FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
    }

    /// Trunks, foam blocks and the table.
    pub fn fixed() -> InteractionGroups {
        InteractionGroups::new(FIXED, ARM | BENDABLE, InteractionTestMode::And)
    }

    /// Moving parts of leaves and rolls.
    pub fn bendable() -> InteractionGroups {
        InteractionGroups::new(BENDABLE, ARM | FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
    }

    /// The lowest part of a leaf or roll, which stands inside the foam that it must not collide with.
    pub fn rooted() -> InteractionGroups {
        InteractionGroups::new(ROOTED, ARM | BENDABLE, InteractionTestMode::And)
    }
}
