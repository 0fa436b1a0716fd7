#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use underbrush_recording::Outcome;

use super::{ActionKind, Environment, EnvironmentOptions, Environments, Reward};
use crate::{ReachPlan, Scene};

/// A scene with leaves in front of a goal that a hand can reach.
fn plan(seed: u64) -> ReachPlan {
    let text =
        "summary = \"Leaves\"\n[goals]\ncount = 2\n[[objects.foam_block]]\ncount = 4\n[[objects.leaf]]\ncount = 6\n";
    ReachPlan::new(Scene::parse("leaves.toml", text.into()).unwrap(), None, seed).unwrap()
}

fn options(action: ActionKind) -> EnvironmentOptions {
    EnvironmentOptions { action, time_limit_s: 2.0, ..EnvironmentOptions::default() }
}

#[test]
fn many_give_the_numbers_of_one() {
    // Tests that environments that step at once give, bit for bit, what each gives alone, with and without helping
    // threads. This also holds across the end of an episode: the next step begins another one, ignores the action and
    // has a reward of 0.
    let steps = 60;
    let action = |step: usize, joint: usize| ((step * 7 + joint * 3) as f64 * 0.37).sin();
    let mut many = Environments::new(&plan(5), &options(ActionKind::Equilibrium), 3).unwrap();
    let size = many.observation_size();
    let mut observations = vec![0.0; 3 * size];
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    many.reset(&[None; 3], |_| true, &mut observations).unwrap();
    let mut alone: Vec<Environment> =
        (0..3).map(|index| Environment::new(plan(5 + index), options(ActionKind::Equilibrium)).unwrap()).collect();
    let mut own = vec![0.0; size];
    for environment in &mut alone {
        environment.reset(None, &mut own).unwrap();
    }
    let mut ends = 0;
    for step in 0..steps {
        let row: Vec<f64> = (0..7).map(|joint| action(step, joint)).collect();
        let helpers = (step % 2 == 0).then_some(&pool);
        let stepped = many.step(helpers, &row.repeat(3), &mut observations).unwrap();
        for (index, environment) in alone.iter_mut().enumerate() {
            let expected = match environment.step(&row, &mut own).unwrap() {
                Some(expected) => expected,
                None => {
                    ends += 1;
                    let begun = environment.reset(None, &mut own).unwrap();
                    assert_eq!((begun.reward, begun.reach_index), (0.0, 1));
                    begun
                }
            };
            assert_eq!(stepped[index], expected, "step {step}, environment {index}");
            assert_eq!(observations[index * size..][..size], own, "step {step}, environment {index}");
        }
    }
    assert_eq!(ends, 3, "every environment ends its first episode once");
}

#[test]
fn rewards_follow_their_definition() {
    // Tests the reward of every step against its definition, computed from what the step reports. A step is one frame,
    // so that its largest force is that of the frame.
    let reward = Reward { free_force_n: 0.02, force_per_n_s: 2.0, ..Reward::default() };
    let own = EnvironmentOptions { reward, frames_per_step: 1, ..options(ActionKind::Waypoint) };
    let mut environment = Environment::new(plan(1), own.clone()).unwrap();
    let mut row = vec![0.0; environment.observation_size()];
    let mut pressed = 0;
    for seed in 0..4 {
        let mut before_m = environment.reset(Some(seed), &mut row).unwrap().distance_m;
        let mut last = None;
        while let Some(stepped) = environment.step(&towards(&environment, &row), &mut row).unwrap() {
            let progress = reward.progress_per_m * (before_m - stepped.distance_m) - reward.time_per_s * own.step_s();
            let bonus = match stepped.outcome {
                Some(Outcome::Reached) => reward.reached,
                Some(Outcome::Aborted) => -reward.aborted,
                _ => 0.0,
            };
            let force = reward.force_per_n_s * (stepped.sensed_force_n - reward.free_force_n).max(0.0) * own.step_s();
            pressed += usize::from(force > 0.0);
            assert!((stepped.reward - progress - bonus + force).abs() < 1e-12, "{stepped:?}");
            assert_eq!(stepped.terminated || stepped.truncated, stepped.outcome.is_some());
            before_m = stepped.distance_m;
            last = Some(stepped);
        }
        // The episode lasts until its limit at most, and the hand comes closer when it is told to.
        assert!(last.unwrap().distance_m < 0.3, "{last:?}");
    }
    assert!(pressed > 10, "forces cost something in {pressed} steps");
}

/// A waypoint in the direction of the goal.
fn towards(environment: &Environment, row: &[f32]) -> Vec<f64> {
    let place = |name: &str| {
        let part = environment.parts.iter().find(|part| part.name == name).unwrap();
        row[part.first..part.first + 3].to_vec()
    };
    let (hand, goal) = (place("end_effector_position_world"), place("goal_position_world"));
    hand.iter().zip(goal).map(|(hand, goal)| f64::from(goal - hand) * 10.0).collect()
}

#[test]
fn observations_hold_what_the_skin_senses() {
    // Tests that an observation's tactile images are the sensed forces of the simulation, taxel by taxel, and that its
    // parts fill the row without gaps.
    let mut environment = Environment::new(plan(2), options(ActionKind::Waypoint)).unwrap();
    let mut row = vec![f32::NAN; environment.observation_size()];
    environment.reset(Some(2), &mut row).unwrap();
    let mut felt = 0;
    for _ in 0..40 {
        let action = towards(&environment, &row);
        row.fill(f32::NAN);
        if environment.step(&action, &mut row).unwrap().is_none() {
            break;
        }
        assert!(row.iter().all(|number| number.is_finite()));
        let Some(simulation) = environment.simulation() else {
            break;
        };
        let patches = simulation.arm().skin.layout.patches.len();
        let tactile = &environment.parts[environment.parts.len() - patches..];
        for reading in &simulation.report().tactile.taxels {
            let part = &tactile[usize::from(reading.patch)];
            let [low, high] = part.range;
            let expected = (reading.sensed_force_n as f32).clamp(low, high);
            assert_eq!(row[part.first + usize::from(reading.taxel)], expected);
            felt += usize::from(expected > 0.0);
        }
    }
    assert!(felt > 0, "nothing was felt");
}

#[test]
fn bad_options_are_named() {
    // Tests that an option outside its limits is refused by name, and that an episode has no more goals than the scene.
    let refused = |options: EnvironmentOptions| Environment::new(plan(0), options).err().unwrap().field;
    let base = EnvironmentOptions::default;
    assert_eq!(refused(EnvironmentOptions { goals: 3, ..base() }), "goals");
    assert_eq!(refused(EnvironmentOptions { frames_per_step: 0, ..base() }), "frames_per_step");
    assert_eq!(refused(EnvironmentOptions { time_limit_s: f64::NAN, ..base() }), "time_limit_s");
    let reward = Reward { force_per_n_s: -1.0, ..Reward::default() };
    assert_eq!(refused(EnvironmentOptions { reward, ..base() }), "force_per_n_s");
}

#[test]
fn an_impossible_draw_is_not_tried_again() {
    // Tests that after a draw without room for all trunks, the next reset draws the next reach.
    let text = "summary = \"Tight\"\n[goals]\ncount = 1\nx_m = 0.6\ny_m = { uniform = [-0.4, 0.0] }\nz_m = -0.2\n\
                [[objects.trunk]]\ncount = 6\ndiameter_m = 0.1\n\
                place = { x_m = { uniform = [0.35, 0.5] }, y_m = { uniform = [-0.6, -0.25] } }\n";
    let plan = ReachPlan::new(Scene::parse("tight.toml", text.into()).unwrap(), None, 0).unwrap();
    let mut environment = Environment::new(plan.clone(), options(ActionKind::Waypoint)).unwrap();
    let mut row = vec![0.0; environment.observation_size()];
    let possible: Vec<bool> = (0..12).map(|index| plan.draw(index).is_ok()).collect();
    assert!(possible.contains(&true) && possible.contains(&false), "{possible:?}");
    let reset: Vec<bool> = (0..12).map(|_| environment.reset(None, &mut row).is_ok()).collect();
    assert_eq!(reset, possible);
}
