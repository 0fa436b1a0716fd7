use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::super::quadratic_program::{Outcome, QuadraticProgram, Solution};

fn program(hessian: DMatrix<f64>, gradient: &[f64], rows: &[&[f64]], bounds: &[f64]) -> QuadraticProgram {
    let entries: Vec<f64> = rows.concat();
    QuadraticProgram {
        hessian,
        gradient: DVector::from_column_slice(gradient),
        constraints: DMatrix::from_row_slice(rows.len(), gradient.len(), &entries),
        bounds: DVector::from_column_slice(bounds),
    }
}

fn optimum(program: &QuadraticProgram) -> Solution {
    match program.solve() {
        Outcome::Optimal(solution) => solution,
        other => panic!("{other:?} of {program:?}"),
    }
}

/// The largest violation of the optimality conditions: stationarity, feasibility, complementarity, signs.
fn residual(program: &QuadraticProgram, solution: &Solution) -> f64 {
    let mut multipliers = DVector::zeros(program.bounds.len());
    for (index, value) in solution.active.iter().zip(&solution.multipliers) {
        multipliers[*index] += value;
    }
    let slack = &program.constraints * &solution.minimizer - &program.bounds;
    let pull = program.constraints.transpose() * &multipliers;
    let stationarity = (&program.hessian * &solution.minimizer + &program.gradient - &pull).amax();
    let scale = 1.0 + program.gradient.amax() + pull.amax() + (&program.hessian * &solution.minimizer).amax();
    let feasibility = slack.iter().fold(0.0_f64, |worst, value| worst.max(-value));
    let complementarity = slack.component_mul(&multipliers).amax() / (1.0 + multipliers.amax());
    let sign = multipliers.iter().fold(0.0_f64, |worst, value| worst.max(-value));
    (stationarity / scale).max(feasibility).max(complementarity).max(sign)
}

enum Peer {
    Optimal(Vec<f64>),
    Infeasible,
    Undecided,
}

/// The same program through Clarabel's interior-point method.
fn peer(program: &QuadraticProgram) -> Peer {
    let rows: Vec<Vec<f64>> =
        program.constraints.row_iter().map(|row| row.iter().map(|entry| -entry).collect()).collect();
    let hessian: Vec<Vec<f64>> = program.hessian.row_iter().map(|row| row.iter().copied().collect()).collect();
    let sparse = |rows: &[Vec<f64>]| {
        let (rows_count, columns) = (rows.len(), program.gradient.len());
        let mut entries = (Vec::new(), Vec::new(), Vec::new());
        for (i, row) in rows.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                entries.0.push(i);
                entries.1.push(j);
                entries.2.push(*entry);
            }
        }
        CscMatrix::new_from_triplets(rows_count, columns, entries.0, entries.1, entries.2)
    };
    let bounds: Vec<f64> = program.bounds.iter().map(|bound| -bound).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-11,
        tol_gap_rel: 1e-11,
        tol_feas: 1e-11,
        ..DefaultSettings::default()
    };
    let cones = [NonnegativeConeT(rows.len())];
    let upper = sparse(&hessian).to_triu();
    let mut solver =
        DefaultSolver::new(&upper, program.gradient.as_slice(), &sparse(&rows), &bounds, &cones, settings).unwrap();
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved => Peer::Optimal(solver.solution.x.clone()),
        SolverStatus::PrimalInfeasible => Peer::Infeasible,
        _ => Peer::Undecided,
    }
}

/// Programs of 1 to 8 variables and up to 40 constraints, some of them doubled, opposed or nearly parallel; entries
/// are small whole numbers half of the time, so that vertices are often degenerate.
fn programs() -> impl Strategy<Value = QuadraticProgram> {
    (1usize..=8, 0usize..=40, any::<bool>()).prop_flat_map(|(variables, count, whole)| {
        let entries = move |size: usize| {
            prop::collection::vec(-3.0..3.0f64, size).prop_map(move |values| {
                values.into_iter().map(|v| if whole { v.round() } else { v }).collect::<Vec<f64>>()
            })
        };
        let copies = prop::collection::vec((0usize..40, prop_oneof![Just(1.0), Just(-1.0), Just(2.0)]), 0..6);
        (entries(variables * variables), entries(variables), entries(count * variables), entries(count), copies)
            .prop_map(move |(square, gradient, rows, bounds, copies)| {
                let square = DMatrix::from_row_slice(variables, variables, &square);
                let hessian = &square * square.transpose() + DMatrix::identity(variables, variables) * 0.1;
                let mut rows: Vec<Vec<f64>> = rows.chunks(variables).map(<[f64]>::to_vec).collect();
                let mut bounds: Vec<f64> = bounds.iter().map(|bound| bound - 2.0).collect();
                for (from, factor) in copies {
                    if let (Some(row), Some(bound)) = (rows.get(from).cloned(), bounds.get(from).copied()) {
                        rows.push(row.iter().map(|entry| entry * factor).collect());
                        bounds.push(bound * factor);
                    }
                }
                let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
                program(hessian, &gradient, &rows, &bounds)
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]
    #[test]
    fn agrees_with_an_interior_point_solver(program in programs()) {
        // Tests status and minimum against an independent method, and the optimality conditions directly.
        match (program.solve(), peer(&program)) {
            (Outcome::Optimal(solution), other) => {
                prop_assert!(residual(&program, &solution) < 1e-7, "residual {:e}", residual(&program, &solution));
                if let Peer::Optimal(minimizer) = other {
                    let difference = (&solution.minimizer - DVector::from_vec(minimizer)).amax();
                    prop_assert!(difference < 1e-4 * (1.0 + solution.minimizer.amax()), "minimizers differ by {difference:e}");
                } else {
                    prop_assert!(matches!(other, Peer::Undecided), "Clarabel finds it infeasible");
                }
            }
            (Outcome::Infeasible, other) => prop_assert!(!matches!(other, Peer::Optimal(_)), "Clarabel solves it"),
            (other, _) => prop_assert!(false, "{other:?}"),
        }
    }
}

#[test]
fn example_by_hand() {
    // Tests a program solved by hand: nearest point to (3, 4) with x + y ≤ 4, x ≤ 1 is (1, 3).
    let solution =
        optimum(&program(DMatrix::identity(2, 2), &[-3.0, -4.0], &[&[-1.0, -1.0], &[-1.0, 0.0]], &[-4.0, -1.0]));
    assert!((solution.minimizer[0] - 1.0).abs() < 1e-12 && (solution.minimizer[1] - 3.0).abs() < 1e-12);
    let mut active = solution.active;
    active.sort_unstable();
    assert_eq!(active, [0, 1]);
}

#[test]
fn without_constraints_it_is_the_newton_step() {
    // Tests the unconstrained minimum −G⁻¹ a.
    let hessian = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 3.0]);
    let solution = optimum(&program(hessian, &[1.0, 2.0], &[], &[]));
    assert!((solution.minimizer[0] + 1.0 / 11.0).abs() < 1e-15 && (solution.minimizer[1] + 7.0 / 11.0).abs() < 1e-15);
    assert_eq!(solution.iterations, 0);
}

#[test]
fn empty_boxes_are_infeasible() {
    // Tests that contradictions are detected: x ≥ 1 with x ≤ 0, one hidden among other constraints, and 0 ≥ 1.
    let identity = DMatrix::identity(2, 2);
    let empty: [(&[&[f64]], &[f64]); 3] = [
        (&[&[1.0, 0.0], &[-1.0, 0.0]], &[1.0, 0.0]),
        (&[&[1.0, 1.0], &[0.0, -1.0], &[-1.0, 0.0], &[0.0, 1.0]], &[2.0 + 1e-6, -1.0, -1.0, 0.0]),
        (&[&[0.0, 0.0]], &[1.0]),
    ];
    for (rows, bounds) in empty {
        let program = program(identity.clone(), &[0.3, -0.2], rows, bounds);
        assert_eq!(program.solve(), Outcome::Infeasible, "{program:?}");
    }
}

#[test]
fn degenerate_vertices_end() {
    // Tests termination and optimality if many constraints, doubled and redundant, meet at the minimum.
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for step in 0..60 {
        let angle = f64::from(step % 30) * std::f64::consts::PI / 30.0;
        rows.push(vec![angle.cos(), angle.sin(), 1.0]);
        rows.push(vec![2.0 * angle.cos(), 2.0 * angle.sin(), 2.0]);
    }
    let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
    let program = program(DMatrix::identity(3, 3), &[0.0, 0.0, 5.0], &rows, &vec![0.0; rows.len()]);
    let solution = optimum(&program);
    assert!(residual(&program, &solution) < 1e-10);
}

#[test]
fn bad_programs_are_told_apart() {
    // Tests the outcomes without a solution: an indefinite or singular Hessian, NaN, wrong sizes.
    let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
    assert_eq!(program(indefinite, &[0.0, 0.0], &[], &[]).solve(), Outcome::NotPositiveDefinite);
    assert_eq!(program(DMatrix::zeros(2, 2), &[0.0, 0.0], &[], &[]).solve(), Outcome::NotPositiveDefinite);
    let identity = DMatrix::identity(2, 2);
    assert_eq!(program(identity.clone(), &[f64::NAN, 0.0], &[], &[]).solve(), Outcome::Malformed);
    assert_eq!(program(identity.clone(), &[0.0, 0.0], &[&[1.0, f64::INFINITY]], &[0.0]).solve(), Outcome::Malformed);
    assert_eq!(program(identity, &[0.0, 0.0], &[&[1.0, 0.0]], &[0.0, 1.0]).solve(), Outcome::Malformed);
}
