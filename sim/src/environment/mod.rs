//! A reach as an environment for an agent that learns: observation in, action out, reward.
//!
//! An [`Environment`] draws a new reach for every episode. Its observations hold what a robot could know; what it could
//! not know is in [`Stepped`]. [`Environments`] steps many of them at once, with the same numbers.

use underbrush_recording::{Frame, InputError, Outcome};

use crate::reach::{ReachError, ReachPlan, Steering};
use crate::simulation::Simulation;

mod many;
mod observation;
mod options;
#[cfg(test)]
mod tests;

pub use many::Environments;
pub use observation::Part;
pub use options::{ActionKind, EnvironmentOptions, Reward};

/// The result of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stepped {
    /// The reward.
    pub reward: f64,
    /// Whether the episode ended by itself: all goals are reached, or a force exceeded the stop force.
    pub terminated: bool,
    /// Whether it was cut off, because a goal took too long.
    pub truncated: bool,
    /// How the last goal of an episode ended, once it has.
    pub outcome: Option<Outcome>,
    /// Distance of the end effector from its goal, m.
    pub distance_m: f64,
    /// The largest force that a taxel sensed in the step, N.
    pub sensed_force_n: f64,
    /// Ground truth: the largest force between one link and one object in the step, N.
    pub contact_force_n: f64,
    /// Index of the reach among those of the seed.
    pub reach_index: u64,
}

/// One arm that an agent moves.
///
/// ```
/// use underbrush_sim::environment::{Environment, EnvironmentOptions};
/// use underbrush_sim::reach::ReachPlan;
/// use underbrush_sim::scene::Scene;
///
/// let text = "summary = \"A trunk\"\n[[objects.trunk]]\ncount = 1\n";
/// let plan = ReachPlan::new(Scene::parse("trunk.toml", text.into())?, None, 1)?;
/// let mut environment = Environment::new(plan, EnvironmentOptions::default())?;
/// let mut observation = vec![0.0; environment.observation_size()];
/// environment.reset(Some(3), &mut observation)?;
/// let still = vec![0.0; environment.action_size()];
/// let stepped = environment.step(&still, &mut observation)?;
/// assert!(stepped.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Environment {
    plan: ReachPlan,
    options: EnvironmentOptions,
    /// The parts of an observation.
    pub parts: Vec<Part>,
    /// The index of the next reach.
    next: u64,
    episode: Option<Episode>,
}

/// An episode.
struct Episode {
    simulation: Simulation,
    ended: bool,
    steering: Steering,
    reach_index: u64,
    goal: usize,
    /// Time spent on the goal, s.
    time_s: f64,
}

impl Environment {
    /// An environment for the reaches of a plan. [`Environment::reset`] begins its first episode.
    ///
    /// # Errors
    /// If an option is outside its limits, or the scene has fewer goals than an episode.
    pub fn new(plan: ReachPlan, options: EnvironmentOptions) -> Result<Self, InputError> {
        options.check()?;
        let available = plan.scene.file.goals.number();
        if options.goals > available {
            let found = format!("{} goals", options.goals);
            let allowed = format!("1 to {available}, the goals of scene {}", plan.scene.name);
            return Err(InputError::new("the environment", "goals", found, allowed, "ask for fewer goals"));
        }
        Ok(Environment { parts: observation::parts(&plan.arm), plan, options, next: 0, episode: None })
    }

    /// How many numbers an observation has.
    pub fn observation_size(&self) -> usize {
        self.parts.iter().map(Part::size).sum()
    }

    /// How many numbers an action has.
    pub fn action_size(&self) -> usize {
        match self.options.action {
            ActionKind::Equilibrium => self.plan.arm.joints.len(),
            ActionKind::Waypoint => 3,
        }
    }

    /// The simulation of the present episode, or of the one that has ended until it is reset.
    pub fn simulation(&self) -> Option<&Simulation> {
        self.episode.as_ref().map(|episode| &episode.simulation)
    }

    /// The present frame of that simulation, with the goal of the episode.
    pub fn frame(&self) -> Option<Frame> {
        let episode = self.episode.as_ref()?;
        Some(episode.simulation.frame(episode.goal as u16, episode.goal_world()))
    }

    /// Begins the next episode: reach 0 of a seed if one is given, and otherwise the next reach of the present seed.
    /// Writes the first observation into `observation`, which has [`Environment::observation_size`] places.
    ///
    /// # Errors
    /// When the scene is impossible for this draw.
    pub fn reset(&mut self, seed: Option<u64>, observation: &mut [f32]) -> Result<Stepped, InputError> {
        if let Some(seed) = seed {
            (self.plan.seed, self.next) = (seed, 0);
        }
        let reach_index = self.next;
        // Before the draw, so that an impossible draw is not tried again.
        self.next += 1;
        let simulation = self.plan.simulation(reach_index)?;
        let steering = Steering::new(&self.plan);
        let episode = Episode { simulation, ended: false, steering, reach_index, goal: 0, time_s: 0.0 };
        episode.observe(&self.parts, observation);
        let distance_m = episode.distance_m();
        self.episode = Some(episode);
        Ok(Stepped { distance_m, reach_index, ..Stepped::default() })
    }

    /// Takes a step and writes the next observation. `None` without an episode: before the first one, and after the end
    /// of one until it is reset.
    ///
    /// # Errors
    /// When the scene's controller, which follows waypoints, answers wrongly.
    ///
    /// # Panics
    /// If `action` does not have [`Environment::action_size`] numbers, or `observation` too few places.
    pub fn step(&mut self, action: &[f64], observation: &mut [f32]) -> Result<Option<Stepped>, ReachError> {
        assert_eq!(action.len(), self.action_size(), "numbers of an action");
        let Some(episode) = self.episode.as_mut().filter(|episode| !episode.ended) else { return Ok(None) };
        let stepped = episode.step(&self.plan, &self.options, action)?;
        episode.observe(&self.parts, observation);
        episode.ended = stepped.terminated || stepped.truncated;
        Ok(Some(stepped))
    }
}

impl Episode {
    fn goal_world(&self) -> glam::DVec3 {
        self.simulation.clutter().goals.get(self.goal).copied().unwrap_or_default()
    }

    fn distance_m(&self) -> f64 {
        self.simulation.report().end_effector_pose_world.position.distance(self.goal_world())
    }

    fn observe(&self, parts: &[Part], row: &mut [f32]) {
        observation::write(parts, &self.simulation, &self.steering.equilibrium_rad, self.goal_world(), row);
    }

    fn step(&mut self, plan: &ReachPlan, options: &EnvironmentOptions, action: &[f64]) -> Result<Stepped, ReachError> {
        let reward = &options.reward;
        let before_m = self.distance_m();
        let start_rad = self.steering.equilibrium_rad.clone();
        let here = self.simulation.report().end_effector_pose_world.position;
        let cut = |number: f64| number.clamp(-1.0, 1.0);
        let mut found = Stepped { reach_index: self.reach_index, ..Stepped::default() };
        let step_s = options.step_s();
        let frame_s = step_s / f64::from(options.frames_per_step);
        let mut aborted = false;
        for frame in 1..=options.frames_per_step {
            match options.action {
                ActionKind::Equilibrium => {
                    // The change is spread evenly over the frames.
                    let share = f64::from(frame) / f64::from(options.frames_per_step);
                    let joints = plan.arm.joints.iter().zip(&start_rad).zip(action);
                    for (angle, ((joint, start), number)) in self.steering.equilibrium_rad.iter_mut().zip(joints) {
                        let [low, high] = joint.controller_limits_rad;
                        let wanted = start + share * cut(*number) * options.largest_change_rad;
                        *angle = wanted.max(low.min(*start)).min(high.max(*start));
                    }
                }
                ActionKind::Waypoint => {
                    let offset = glam::DVec3::new(cut(action[0]), cut(action[1]), cut(action[2]));
                    let target = here + offset * options.largest_waypoint_m;
                    let frame = self.simulation.frame(self.goal as u16, self.goal_world());
                    self.steering.control(&self.simulation, &frame, target)?;
                }
            }
            let tactile = &self.simulation.step(&self.steering.equilibrium_rad).tactile;
            let sensed_n = tactile.taxels.iter().map(|taxel| taxel.sensed_force_n).fold(0.0, f64::max);
            let contact_n = tactile.largest_force().map_or(0.0, |force| force.force_n);
            found.reward -= reward.force_per_n_s * (sensed_n - reward.free_force_n).max(0.0) * frame_s;
            found.sensed_force_n = found.sensed_force_n.max(sensed_n);
            found.contact_force_n = found.contact_force_n.max(contact_n);
            aborted |= contact_n > plan.rules.stop_force_n;
        }
        self.time_s += step_s;
        found.distance_m = self.distance_m();
        found.reward += reward.progress_per_m * (before_m - found.distance_m) - reward.time_per_s * step_s;
        if aborted {
            found.reward -= reward.aborted;
            (found.terminated, found.outcome) = (true, Some(Outcome::Aborted));
        } else if found.distance_m < plan.rules.reached_distance_m {
            found.reward += reward.reached;
            if self.goal + 1 == self.simulation.clutter().goals.len().min(options.goals as usize) {
                (found.terminated, found.outcome) = (true, Some(Outcome::Reached));
            } else {
                (self.goal, self.time_s) = (self.goal + 1, 0.0);
            }
        } else if self.time_s >= options.time_limit_s - frame_s / 2.0 {
            (found.truncated, found.outcome) = (true, Some(Outcome::TimedOut));
        }
        Ok(found)
    }
}
