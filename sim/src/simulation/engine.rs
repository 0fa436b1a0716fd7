//! One world of the Rapier engine and its step.

use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};

use crate::physics::PhysicsOptions;

/// Softness of contacts with trunks and foam blocks, critically damped. The engine scales the stiffness with the effective
/// mass m, as m (2π f)². At the arm's 1 kg this is 1e4 N/m: the stiffness of the skin's layer (3e7 N/m³) over the 3–4 cm²
/// on which a trunk touches it.
const SKIN_ON_FIXED: SpringCoefficients<f64> = SpringCoefficients {
    natural_frequency: 16.0,
    damping_ratio: 1.0,
};

/// Softness of contacts with leaves and rolls, critically damped: 2e3 N/m at the 5 g that a leaf weighs. The few tenths of
/// a newton that a leaf exerts then indent the skin by a tenth of a millimetre.
const SKIN_ON_BENDABLE: SpringCoefficients<f64> = SpringCoefficients {
    natural_frequency: 100.0,
    damping_ratio: 1.0,
};

/// A Rapier world: bodies, shapes, joints and contacts.
#[derive(Serialize, Deserialize)]
pub struct Engine {
    /// The options it was created with.
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
    #[serde(skip, default = "PhysicsPipeline::new")]
    pipeline: PhysicsPipeline,
    islands: IslandManager,
    broad_phase: BroadPhaseBvh,
    impulse_joints: ImpulseJointSet,
    soft_bodies: SoftBodySet,
    continuous_collision: CCDSolver,
}

/// A copy continues exactly as the original does: the pipeline holds nothing from one step to the next.
impl Clone for Engine {
    fn clone(&self) -> Self {
        Engine {
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

impl Engine {
    /// An empty world.
    pub fn new(options: PhysicsOptions) -> Self {
        let parameters = IntegrationParameters {
            dt: options.step_s,
            num_solver_iterations: options.substeps,
            // A recycled contact may be 5 cm away from the true one, several times the width of a taxel.
            contact_recycling: false,
            // Clustering moves impulses away from the contact points that the skin reads.
            contact_clustering: false,
            // Friction acts whenever the contact does; the default is tuned for tall stacks.
            friction_in_bias_pass: true,
            friction_model: FrictionModel::Coulomb,
            // Contacts are soft, like skin over a shell. Rigid contacts with a position correction break and return from
            // step to step while the arm slides, and the force then chatters by tens of per cent.
            num_internal_stabilization_iterations: 0,
            static_contact_softness: SKIN_ON_FIXED,
            contact_softness: SKIN_ON_BENDABLE,
            // The hand moves 5 mm in a frame at 0.5 m/s, the speed of the fastest preset. A larger distance would create
            // contacts between mere neighbours.
            normalized_prediction_distance: 0.005,
            // With a single sweep per substep, contacts that push each other lag behind. Four sweeps reduce the error of a
            // trunk's force from 5 % to 1 % at no measurable cost (benches/README.md).
            num_internal_pgs_iterations: 4,
            // Nothing here moves far enough in a step to tunnel: 0.5 m/s for 10 ms is 5 mm.
            max_ccd_substeps: 0,
            ..IntegrationParameters::default()
        };
        Engine {
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

    /// Removes a body with its colliders and joints.
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

/// The points of a manifold on which the solver pressed in the last step.
///
/// The solver uses at most four points of a manifold. The others keep the impulse of the step in which they were last used.
/// If they were counted too, a blade on the forearm would seem to press with up to twice its force.
pub fn pressed_points(manifold: &ContactManifold) -> impl Iterator<Item = &TrackedContact<ContactData>> {
    let taken = manifold.data.solver_contacts.iter();
    taken
        .filter_map(|contact| manifold.points.get(contact.contact_indices()[0] as usize))
        .filter(|point| point.data.impulse > 0.0)
}

/// The collision groups; every collider is in one of them.
pub mod groups {
    use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

    const ARM: Group = Group::GROUP_1;
    const FIXED: Group = Group::GROUP_2;
    const BENDABLE: Group = Group::GROUP_3;
    const ROOTED: Group = Group::GROUP_4;

    /// Links of the arm: they collide with everything but each other.
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

    /// The lowest part of a leaf or roll. It stands inside foam, with which it must not collide.
    pub fn rooted() -> InteractionGroups {
        InteractionGroups::new(ROOTED, ARM | BENDABLE, InteractionTestMode::And)
    }
}
