//! One step of the model-predictive controller with ten taxels in contact, and its quadratic program, compared with
//! Clarabel's interior-point method on the same program. The paper's robot ran at 25 Hz, so a
//! step of `cody-2013` may take 40 ms; `ijrr-foliage` runs at 100 Hz.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::hint::black_box;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use nalgebra::{DMatrix, Matrix3xX};
use underbrush_recording::Pose;
use underbrush_sim::arm::Arm;
use underbrush_sim::controller::quadratic_program::{Outcome, QuadraticProgram};
use underbrush_sim::controller::{ControlStatus, Controller, ControllerInput, ModelPredictive, Preset, TaxelContact};

/// Cody in its start posture, ten taxels of the forearm in contact, moving forward.
struct Situation {
    arm: Arm,
    angle_rad: Vec<f64>,
    end_effector: Pose,
    end_effector_jacobian: Matrix3xX<f64>,
    joint_velocity_rad_per_s: Vec<f64>,
    contacts: Vec<TaxelContact>,
}

impl Situation {
    /// Ten neighbouring taxels around the forearm, from 1.2 N to 3.9 N: some under the force limit of 3 N, some over
    /// it.
    fn new() -> Self {
        let arm = Arm::cody().expect("Cody's files are sound");
        let angle_rad = arm.start_posture_rad();
        let poses = arm.forward_kinematics(&angle_rad);
        let link = arm.link_index("forearm").expect("Cody has a forearm");
        let patch = arm.skin.layout.patch_index("forearm").expect("with skin");
        let forearm = &arm.skin.layout.patches[patch];
        let contacts = (0..10)
            .map(|number| {
                let index = 8 * 24 + number;
                let taxel = &forearm.taxels[index];
                TaxelContact {
                    patch,
                    taxel: index,
                    position_jacobian: arm.position_jacobian(
                        &poses,
                        link,
                        poses[link].transform_point(taxel.position_link),
                    ),
                    inward_normal_world: -poses[link].transform_vector(taxel.normal_link),
                    force_n: 1.2 + 0.3 * number as f64,
                    allowed_force_n: None,
                }
            })
            .collect();
        let end_effector = arm.end_effector_pose(&poses);
        Situation {
            end_effector,
            end_effector_jacobian: arm.position_jacobian(&poses, arm.end_effector_link, end_effector.position),
            joint_velocity_rad_per_s: vec![0.0; angle_rad.len()],
            contacts,
            angle_rad,
            arm,
        }
    }

    fn input(&self) -> ControllerInput<'_> {
        ControllerInput {
            joint_angle_rad: &self.angle_rad,
            joint_velocity_rad_per_s: &self.joint_velocity_rad_per_s,
            equilibrium_angle_rad: &self.angle_rad,
            end_effector_pose_world: self.end_effector,
            end_effector_jacobian: &self.end_effector_jacobian,
            goal_position_world: self.end_effector.position + DVec3::X * 0.3,
            contacts: &self.contacts,
        }
    }
}

/// The program as Clarabel takes it: −C x + s = −b, s ≥ 0.
struct Peer {
    hessian: CscMatrix<f64>,
    gradient: Vec<f64>,
    rows: CscMatrix<f64>,
    bounds: Vec<f64>,
}

fn sparse(matrix: &DMatrix<f64>) -> CscMatrix<f64> {
    let rows: Vec<Vec<f64>> = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    CscMatrix::from(&rows)
}

impl Peer {
    fn new(program: &QuadraticProgram) -> Self {
        Peer {
            hessian: sparse(&program.hessian).to_triu(),
            gradient: program.gradient.as_slice().to_vec(),
            rows: sparse(&-&program.constraints),
            bounds: program.bounds.iter().map(|bound| -bound).collect(),
        }
    }

    /// Setting up is part of the work: the numbers are new in every step.
    fn solve(&self) -> Vec<f64> {
        let cones = [NonnegativeConeT(self.bounds.len())];
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let mut solver = DefaultSolver::new(&self.hessian, &self.gradient, &self.rows, &self.bounds, &cones, settings)
            .expect("the program is well formed");
        solver.solve();
        assert_eq!(solver.solution.status, SolverStatus::Solved);
        solver.solution.x.clone()
    }
}

fn step(criterion: &mut Criterion) {
    let situation = Situation::new();
    let mut group = criterion.benchmark_group("controller");
    for preset in [Preset::cody_2013(), Preset::ijrr_foliage()] {
        let name = preset.name;
        let mut controller = ModelPredictive::new(preset, &situation.arm);
        assert_eq!(controller.control(&situation.input()).status, ControlStatus::Solved);
        group.bench_function(format!("step/{name}"), |bencher| {
            bencher.iter(|| controller.control(black_box(&situation.input())));
        });
        let program = controller.step_program(&situation.input()).expect("the model has a factor");
        let peer = Peer::new(&program);
        let Outcome::Optimal(solution) = program.solve() else { panic!("the program has a minimum") };
        // Both must solve the same problem: the solutions agree to the interior point's tolerance, in rad.
        for (ours, theirs) in solution.minimizer.iter().zip(peer.solve()) {
            assert!((ours - theirs).abs() < 1e-5, "{ours} rad here, {theirs} rad there");
        }
        group.bench_function(format!("quadratic_program/{name}/underbrush"), |bencher| {
            bencher.iter(|| black_box(&program).solve());
        });
        group.bench_function(format!("quadratic_program/{name}/clarabel"), |bencher| {
            bencher.iter(|| black_box(&peer).solve());
        });
    }
}

criterion_group!(benches, step);
criterion_main!(benches);
