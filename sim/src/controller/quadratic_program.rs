//! A dense, strictly convex quadratic program by the dual active-set method of D. Goldfarb and A. Idnani, "A
//! numerically stable dual method for solving strictly convex quadratic programs", Mathematical Programming 27, 1983.
//!
//! The method starts at the unconstrained minimum and adds violated constraints one at a time, while the multipliers
//! stay non-negative. Each iterate is the exact minimum for its active set. The active normals are stored as a QR
//! factorization, to which a new constraint adds a column. When a constraint is dropped, the factorization is computed
//! again: with the dozen variables of an arm this is cheap and accumulates no error.

use nalgebra::{DMatrix, DVector};

/// Minimize ½ xᵀ G x + aᵀ x subject to C x ≥ b.
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticProgram {
    /// G, n × n, symmetric positive definite.
    pub hessian: DMatrix<f64>,
    /// a, n.
    pub gradient: DVector<f64>,
    /// C, m × n: one constraint per row.
    pub constraints: DMatrix<f64>,
    /// b, m.
    pub bounds: DVector<f64>,
}

/// Why a quadratic program has no solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unsolved {
    /// No point satisfies all constraints.
    Infeasible,
    /// The hessian has no Cholesky factor.
    NotPositiveDefinite,
    /// An entry is not finite, or sizes do not match.
    Malformed,
    /// The maximum number of iterations was reached because of accumulated rounding errors.
    IterationLimit,
}

/// The minimum of a quadratic program.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// x, n.
    pub minimizer: DVector<f64>,
    /// The active constraints, in the order in which they were added.
    pub active: Vec<usize>,
    /// Their multipliers u ≥ 0, with G x + a = Cᵀ u.
    pub multipliers: Vec<f64>,
    /// Number of times a constraint was added or dropped.
    pub iterations: usize,
}

/// A constraint is violated if it is off by more than this, relative to the size of its terms.
const VIOLATION: f64 = 1e-11;
/// A constraint is linearly dependent on the active ones if a smaller share of its normal than this is orthogonal to
/// theirs.
const DEPENDENCE: f64 = 1e-9;

impl QuadraticProgram {
    /// Finds the minimum.
    ///
    /// # Errors
    /// [`Unsolved`].
    pub fn solve(&self) -> Result<Solution, Unsolved> {
        let (variables, count) = (self.gradient.len(), self.bounds.len());
        let fits = self.hessian.shape() == (variables, variables) && self.constraints.shape() == (count, variables);
        let entries =
            [self.hessian.as_slice(), self.gradient.as_slice(), self.constraints.as_slice(), self.bounds.as_slice()];
        if !fits || !entries.into_iter().flatten().all(|entry| entry.is_finite()) {
            return Err(Unsolved::Malformed);
        }
        // With G = L Lᵀ and y = Lᵀ x the program is a search for the point of a polyhedron nearest to −L⁻¹ a: the
        // columns of L⁻¹ Cᵀ are the normals of its faces.
        let singular = Unsolved::NotPositiveDefinite;
        let lower = self.hessian.clone().cholesky().ok_or(singular)?.l();
        let normals = lower.solve_lower_triangular(&self.constraints.transpose()).ok_or(singular)?;
        let point = lower.solve_lower_triangular(&-&self.gradient).ok_or(singular)?;
        let zeros = DMatrix::zeros(variables, variables);
        let basis = Basis { vectors: zeros.clone(), triangle: zeros, size: 0 };
        let (bounds, start_norm) = (&self.bounds, point.norm());
        let (active, multipliers) = (Vec::new(), Vec::new());
        let mut search = Search { normals, bounds, start_norm, point, active, multipliers, basis };
        // In exact arithmetic no active set occurs twice. In practice a constraint is added and dropped a few times.
        let max_iterations = 50 * (variables + count + 1);
        let mut iterations = 0;
        while let Some(violated) = search.most_violated() {
            let mut multiplier = 0.0;
            loop {
                iterations += 1;
                if iterations > max_iterations {
                    return Err(Unsolved::IterationLimit);
                }
                if search.advance(violated, &mut multiplier)? {
                    break;
                }
            }
        }
        let minimizer = lower.transpose().solve_upper_triangular(&search.point).ok_or(singular)?;
        Ok(Solution { minimizer, active: search.active, multipliers: search.multipliers, iterations })
    }
}

/// State of the search in the coordinates y = Lᵀ x.
struct Search<'a> {
    /// Normals of all constraints, one per column.
    normals: DMatrix<f64>,
    bounds: &'a DVector<f64>,
    start_norm: f64,
    point: DVector<f64>,
    active: Vec<usize>,
    multipliers: Vec<f64>,
    /// The normals of the active constraints, in their order.
    basis: Basis,
}

impl Search<'_> {
    /// The inactive constraint that the point violates most, measured as a distance.
    fn most_violated(&self) -> Option<usize> {
        let mut worst = None;
        let mut deepest = 0.0;
        let all = self.normals.column_iter().enumerate();
        for (index, normal) in all.filter(|(index, _)| !self.active.contains(index)) {
            let length = normal.norm();
            let value = normal.dot(&self.point) - self.bounds[index];
            // Near the origin the point is small, but its rounding error is that of the starting point.
            let scale = length * self.point.norm().max(self.start_norm) + self.bounds[index].abs();
            // A violated constraint without a normal, 0 ≥ b, has no distance and counts as the worst.
            let depth = if length > 0.0 { -value / length } else { f64::INFINITY };
            if -value > VIOLATION * scale && depth > deepest {
                (worst, deepest) = (Some(index), depth);
            }
        }
        worst
    }

    /// One step of the dual method towards a violated constraint, whose multiplier so far is `multiplier`
    /// (Goldfarb and Idnani, section 3, step 2). Returns whether the constraint is active now. If not, an active one had to be
    /// dropped. Fails if neither is possible.
    fn advance(&mut self, violated: usize, multiplier: &mut f64) -> Result<bool, Unsolved> {
        let normal = self.normals.column(violated).into_owned();
        // z is the part of the normal orthogonal to the active normals; r expresses the rest as their combination.
        let (direction, along) = self.basis.split(&normal);
        let combination = self.basis.combination(&along).ok_or(Unsolved::Infeasible)?;
        let independent = self.active.len() < self.point.len() && direction.norm() > DEPENDENCE * normal.norm();
        // The longest step that keeps the multipliers of the active constraints from turning negative.
        let mut dual_step = f64::INFINITY;
        let mut dropped = None;
        let noise = 1e-12 * combination.amax();
        for (index, share) in combination.iter().enumerate() {
            if *share > noise && self.multipliers[index] / share < dual_step {
                (dropped, dual_step) = (Some(index), self.multipliers[index] / share);
            }
        }
        let gap = self.bounds[violated] - normal.dot(&self.point);
        let full_step = if independent { gap.max(0.0) / direction.norm_squared() } else { f64::INFINITY };
        let step = dual_step.min(full_step);
        if !step.is_finite() {
            return Err(Unsolved::Infeasible);
        }
        for (value, share) in self.multipliers.iter_mut().zip(&combination) {
            *value = (*value - step * share).max(0.0);
        }
        *multiplier += step;
        if independent {
            self.point.axpy(step, &direction, 1.0);
        }
        match dropped {
            Some(index) if dual_step < full_step => {
                self.active.remove(index);
                self.multipliers.remove(index);
                self.basis.size = 0;
                for index in &self.active {
                    let (direction, along) = self.basis.split(&self.normals.column(*index).into_owned());
                    self.basis.push(&direction, &along);
                }
                Ok(false)
            }
            _ => {
                self.active.push(violated);
                self.multipliers.push(*multiplier);
                self.basis.push(&direction, &along);
                Ok(true)
            }
        }
    }
}

/// A set of independent vectors N = Q R, with orthonormal columns of Q and an upper triangle R.
struct Basis {
    vectors: DMatrix<f64>,
    triangle: DMatrix<f64>,
    size: usize,
}

impl Basis {
    /// The part of `vector` orthogonal to the set, and the coordinates of the rest in Q.
    fn split(&self, vector: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let vectors = self.vectors.columns(0, self.size);
        let mut outside = vector.clone();
        let mut along = DVector::zeros(self.size);
        // A second pass removes the rounding error of the first.
        for _ in 0..2 {
            let part = vectors.tr_mul(&outside);
            outside -= vectors * &part;
            along += part;
        }
        (outside, along)
    }

    /// R⁻¹ `along`: the coordinates in N of the vector whose coordinates in Q are `along`.
    fn combination(&self, along: &DVector<f64>) -> Option<DVector<f64>> {
        self.triangle.view((0, 0), (self.size, self.size)).solve_upper_triangular(along)
    }

    /// Adds a vector that was split into `outside`, which is not zero, and `along`.
    fn push(&mut self, outside: &DVector<f64>, along: &DVector<f64>) {
        let length = outside.norm();
        self.vectors.set_column(self.size, &(outside / length));
        self.triangle.view_mut((0, self.size), (self.size, 1)).copy_from(along);
        self.triangle[(self.size, self.size)] = length;
        self.size += 1;
    }
}
