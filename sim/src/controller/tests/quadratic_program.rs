use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::super::quadratic_program::{QuadraticProgram, Solution, Unsolved};

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
        Ok(solution) => solution,
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

/// The same program with bounds that a point fulfils.
fn fulfilled_by(point: &DVector<f64>, program: QuadraticProgram) -> QuadraticProgram {
    let reached = &program.constraints * point.rows(0, program.gradient.len());
    QuadraticProgram { bounds: program.bounds.zip_map(&reached, f64::min), ..program }
}

/// The same program with one constraint more, which contradicts the sum of the others with these weights: no point can be
/// on the right side of both, by Farkas' lemma.
fn contradicted(weights: &DVector<f64>, program: QuadraticProgram) -> QuadraticProgram {
    let count = program.bounds.len();
    let weights = weights.rows(0, count);
    let row = -(weights.transpose() * &program.constraints);
    let bound = 0.5 - weights.dot(&program.bounds);
    let mut constraints = program.constraints.insert_row(count, 0.0);
    constraints.row_mut(count).copy_from(&row);
    QuadraticProgram { constraints, bounds: program.bounds.insert_row(count, bound), ..program }
}

fn vector(size: usize, range: std::ops::Range<f64>) -> impl Strategy<Value = DVector<f64>> {
    prop::collection::vec(range, size).prop_map(DVector::from_vec)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn feasible_programs_are_solved(program in programs(), point in vector(8, -2.0..2.0)) {
        // Tests status and minimum without another solver: a program that a known point fulfils has a minimum, and only the
        // minimum of a strictly convex program meets the optimality conditions.
        let program = fulfilled_by(&point, program);
        match program.solve() {
            Ok(solution) => {
                prop_assert!(residual(&program, &solution) < 1e-7, "residual {:e}", residual(&program, &solution));
            }
            other => prop_assert!(false, "{other:?}"),
        }
    }

    #[test]
    fn contradictions_are_infeasible(program in programs(), weights in vector(46, 0.0..1.0)) {
        // Tests the other status: some weighted sum of the constraints says 0 ≥ 0.5.
        prop_assert_eq!(contradicted(&weights, program).solve(), Err(Unsolved::Infeasible));
    }

    #[test]
    fn minima_of_any_program_meet_the_optimality_conditions(program in programs()) {
        // Tests programs of which nobody knows whether they have a minimum.
        match program.solve() {
            Ok(solution) => {
                prop_assert!(residual(&program, &solution) < 1e-7, "residual {:e}", residual(&program, &solution));
            }
            Err(Unsolved::Infeasible) => {}
            other => prop_assert!(false, "{other:?}"),
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
        assert_eq!(program.solve(), Err(Unsolved::Infeasible), "{program:?}");
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
    assert_eq!(program(indefinite, &[0.0, 0.0], &[], &[]).solve(), Err(Unsolved::NotPositiveDefinite));
    assert_eq!(program(DMatrix::zeros(2, 2), &[0.0, 0.0], &[], &[]).solve(), Err(Unsolved::NotPositiveDefinite));
    let identity = DMatrix::identity(2, 2);
    assert_eq!(program(identity.clone(), &[f64::NAN, 0.0], &[], &[]).solve(), Err(Unsolved::Malformed));
    assert_eq!(
        program(identity.clone(), &[0.0, 0.0], &[&[1.0, f64::INFINITY]], &[0.0]).solve(),
        Err(Unsolved::Malformed)
    );
    assert_eq!(program(identity, &[0.0, 0.0], &[&[1.0, 0.0]], &[0.0, 1.0]).solve(), Err(Unsolved::Malformed));
}
