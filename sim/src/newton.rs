//! Newton's method for smooth convex functions, with a backtracking line search.

/// Shortest share of a Newton step that is tried: 2⁻¹⁹, about 2·10⁻⁶.
const MAX_HALVINGS: i32 = 19;

/// Minimizes from `start`. A state is a point with the function's value and slope there.
///
/// `step` computes the Newton step from a state and returns `None` to stop there, because the slope has vanished or the
/// curvature is singular. `moved` is the state after a share of that step. The step is halved until `is_lower(moved,
/// state)` accepts it; the search also ends if no share is accepted, or after `max_steps`.
pub(crate) fn minimize<State, Step>(
    start: State,
    max_steps: usize,
    step: impl Fn(&State) -> Option<Step>,
    moved: impl Fn(&State, &Step, f64) -> State,
    is_lower: impl Fn(&State, &State) -> bool,
) -> State {
    let mut state = start;
    for _ in 0..max_steps {
        let Some(step) = step(&state) else { break };
        let mut trials = (0..=MAX_HALVINGS).map(|halvings| moved(&state, &step, 0.5_f64.powi(halvings)));
        let Some(next) = trials.find(|trial| is_lower(trial, &state)) else { break };
        state = next;
    }
    state
}

#[cfg(test)]
mod tests {
    use super::minimize;

    /// Minimizes ln cosh x from a start, by its value, slope tanh x and curvature 1 / cosh² x; counts the points
    /// evaluated.
    fn log_cosh(start: f64) -> (f64, usize) {
        let looked = std::cell::Cell::new(0);
        let found = minimize(
            start,
            50,
            |x: &f64| (x.tanh().abs() > 1e-12).then(|| x.tanh() * x.cosh().powi(2)),
            |x, step, share| {
                looked.set(looked.get() + 1);
                x - share * step
            },
            // Compares |x|, with which ln cosh grows, because ln cosh itself is lost in rounding near the minimum.
            |trial, x| trial.abs() < x.abs(),
        );
        (found, looked.get())
    }

    /// Tests that the line search leads to the minimum from starts at which the undamped method diverges. For ln cosh x
    /// these are |x| > 1.09, where each full step goes farther away.
    #[test]
    fn a_step_that_overshoots_is_shortened() {
        for start in [0.5, 1.0, 2.0, -3.0] {
            let (found, looked) = log_cosh(start);
            assert!(found.abs() < 1e-12, "{found} from {start}");
            // Near the minimum no step is shortened, and convergence is cubic.
            assert!(start.abs() > 1.09 || looked <= 6, "{looked} points from {start}");
        }
    }

    /// Tests when the search ends: at once if the slope is zero, if no share of a step is lower, and at the limit.
    #[test]
    fn the_search_ends() {
        assert_eq!(log_cosh(0.0), (0.0, 0));
        let stays = minimize(1.0, 50, |_| Some(1.0), |x, step, share| x + share * step, |_, _| false);
        assert_eq!(stays, 1.0);
        let three = minimize(0.0, 3, |_| Some(1.0), |x, step, share| x + share * step, |_, _| true);
        assert_eq!(three, 3.0);
    }
}
