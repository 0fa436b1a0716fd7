//! The rule for steps that resolve the motion, θ = ½, against a fine integration of the multibodies' accelerations.

use nalgebra::DVector;
use underbrush_sim::arm::Arm;
use underbrush_sim::object::structure::Spring;
use underbrush_sim::physics::Theta;

use super::peer::Peer;
use super::{INSTANT_S, STIFF_SPRINGS, Subject, bent, displaced, of_arm};
use crate::pressed_arm::OPTIONS;
use crate::{Case, Comparison, Falsification, Fault, Found, Simulated};

/// The arm in steps of two lengths.
pub const IN_STEP: Case = Case { compare, falsifications: &[LATE_FORCES, STIFF_SPRINGS.breaking(&["springs"])] };

const LATE_FORCES: Falsification = Falsification::new("θ of the simulated arm", "1 % too large");

/// How many of the longer steps a motion takes, and how many of the reference are in one of them.
const STEPS: usize = 80;
const FINE: usize = 10;

/// The arm on its springs and dampers, so near to rest that Coriolis forces do not count, and without either at a speed at which the
/// equations of a step are solved twice.
fn compare(simulated: Simulated) -> Found {
    let on_springs = of_arm("arm", Arm::cody()?, simulated)?;
    let mut swinging = of_arm("arm", Arm::cody()?, simulated)?;
    let described = swinging.links.iter_mut().flat_map(|link| &mut link.axes).map(|(_, own)| own);
    for own in swinging.tree.coordinates.iter_mut().chain(described) {
        own.spring = Spring { armature: own.spring.armature, ..Spring::default() };
    }
    let near = bent(&on_springs.tree, 0.01);
    let (still, speeds) = (vec![0.0; near.len()], vec![3.0; near.len()]);
    let slow_s = OPTIONS.step_s / 8.0;
    let slow = ratio(&on_springs, &[near, still.clone()], slow_s, simulated)?;
    let fast = ratio(&swinging, &[still, speeds], OPTIONS.step_s, simulated)?;
    Ok(vec![
        Comparison::of("error of the arm on its springs, steps of 0.625 ms over 0.3125 ms", "", 4.0, slow).absolute(
            0.03,
            "0.03: an eigenvalue s is simulated as s (1 + x / 12 + x² / 80) with x = (s Δt)², so errors fall by 4 + 0.45 x, and \
             θ = ½ is used up to x = 4 at 5 ms, a 64th of which is x here",
        ),
        Comparison::of("error of the swinging arm, steps of 5 ms over 2.5 ms", "", 4.0, fast).absolute(
            0.2,
            "0.2: the term of the next order is ω Δt times as large, 0.1 at the 21 rad/s of all joints together, and changes the \
             ratio by twice that",
        ),
    ])
}

/// The error of steps of `step_s` over that of steps half as long, from these displacements and velocities.
fn ratio(subject: &Subject, start: &[Vec<f64>; 2], step_s: f64, simulated: Simulated) -> Result<f64, Fault> {
    let exact = reference(subject, start, step_s);
    let [whole, half] = [1, 2].map(|parts| {
        let [displacement, velocity] = start;
        let mut own = displaced(&subject.tree, displacement, velocity);
        let step_s = step_s / parts as f64;
        let theta = own.own_theta(step_s);
        if theta != Theta::MIDPOINT {
            return Err(Fault::Run("a step of the arm is not that of the midpoint rule".into()));
        }
        let theta = simulated.with(LATE_FORCES, theta, Theta::of_phase(1.01, Theta::DAMPED));
        let apart = exact.iter().map(|exact| {
            for _ in 0..parts {
                own.begin(step_s, theta);
                own.prepare(0.0);
                own.advance();
            }
            let positions = own.coordinates.iter().map(|own| own.position);
            positions.zip(exact).map(|(own, exact)| (own - exact).powi(2)).sum::<f64>()
        });
        Ok(apart.sum::<f64>().sqrt())
    });
    Ok(whole? / half?)
}

/// Positions after each step of `step_s`, by the classical Runge-Kutta method.
fn reference(subject: &Subject, [displacement, velocity]: &[Vec<f64>; 2], step_s: f64) -> Vec<Vec<f64>> {
    let (joints, fine_s) = (velocity.len(), step_s / FINE as f64);
    let mut peer = Peer::new(&subject.links, INSTANT_S);
    peer.set(displacement, velocity);
    // Positions, and velocities after them.
    let mut state = DVector::from_vec(peer.positions().chain(velocity.iter().copied()).collect());
    let mut slope = |state: DVector<f64>| {
        let (positions, velocity) = state.as_slice().split_at(joints);
        let displacement: Vec<f64> = positions.iter().zip(peer.positions()).map(|(to, from)| to - from).collect();
        peer.set(&displacement, velocity);
        peer.step();
        DVector::from_vec([velocity, &peer.accelerations()].concat())
    };
    let step = |_| {
        for _ in 0..FINE {
            let first = slope(state.clone());
            let second = slope(&state + 0.5 * fine_s * &first);
            let third = slope(&state + 0.5 * fine_s * &second);
            let fourth = slope(&state + fine_s * &third);
            state += (first + 2.0 * (second + third) + fourth) * (fine_s / 6.0);
        }
        state.as_slice()[..joints].to_vec()
    };
    (0..STEPS).map(step).collect()
}
