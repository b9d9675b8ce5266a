//! Dormand and Prince's pair of orders 5 and 4 for small non-stiff systems. Nothing is stored from one communication step to
//! the next, so that a step depends on its initial state only.
//!
//! *Source*: Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19, the pair known as DOPRI5 or ode45.

use super::MOST_STEPS;

/// Nodes of the stages.
const C: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
/// Weights of the previous stages; the last row is the solution of order 5.
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Weights of order 5 minus those of order 4.
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Accepted error of a step, relative to the size of a state.
const TOLERANCE: f64 = 1e-7;
/// Halvings of a communication step before the step fails.
const HALVINGS: u32 = 40;

/// Step failure: the time from the start of the communication step, s, at which it occurred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepFailure {
    /// Time from the start of the step, s.
    pub t: f64,
}

/// A trial step.
#[derive(Clone, Copy, Debug)]
pub struct Tried<P, const N: usize> {
    /// The states after it.
    pub states: [f64; N],
    /// Error of the worst state, relative to the tolerance.
    pub error: f64,
    /// Intermediate results at the end of the step, if already computed.
    pub point: Option<P>,
}

/// Advances `x` by `h` seconds, in as many steps as needed. `one(t, x, first, length)` is a trial step of `length` from `t`;
/// `first` are the intermediate results there, if known. The error may be `allowed` times the tolerance. Returns the number of
/// rejected steps. On failure `x` is unchanged.
///
/// # Errors
/// Non-finite rates, an error above the tolerance at the smallest step, or more than `MOST_STEPS` steps.
pub fn advance<P, const N: usize>(
    one: impl Fn(f64, &[f64; N], Option<&P>, f64) -> Tried<P, N>,
    x: &mut [f64; N],
    first: Option<&P>,
    h: f64,
    allowed: f64,
) -> Result<u64, StepFailure> {
    let tried = one(0.0, x, first, h);
    if tried.error <= allowed {
        *x = tried.states;
        return Ok(0);
    }
    in_parts(one, x, first, h, allowed)
}

/// A communication step that needs several steps.
#[cold]
fn in_parts<P, const N: usize>(
    one: impl Fn(f64, &[f64; N], Option<&P>, f64) -> Tried<P, N>,
    x: &mut [f64; N],
    first: Option<&P>,
    h: f64,
    allowed: f64,
) -> Result<u64, StepFailure> {
    let mut rejected = 1;
    let least = h * 0.5f64.powi(HALVINGS as i32);
    let (mut now, mut t, mut step) = (*x, 0.0, 0.5 * h);
    let mut reached: Option<P> = None;
    for _ in 0..MOST_STEPS {
        if t >= h {
            *x = now;
            return Ok(rejected);
        }
        let last = t + step >= h;
        let length = if last { h - t } else { step };
        let known = if t == 0.0 { first } else { reached.as_ref() };
        let tried = one(t, &now, known, length);
        if tried.error <= allowed {
            (now, reached) = (tried.states, tried.point);
            t = if last { h } else { t + length };
            // Error far below the tolerance: the step can be doubled.
            if tried.error < 0.01 * allowed {
                step *= 2.0;
            }
        } else {
            rejected += 1;
            step = 0.5 * length;
            if step < least {
                return Err(StepFailure { t });
            }
        }
    }
    Err(StepFailure { t })
}

/// Error of the worst state, relative to the tolerance, from the error and size of each state and its values before and after.
#[inline(always)]
pub fn share_of<const N: usize>(
    error: &[f64; N],
    size: &[f64; N],
    before: &[f64; N],
    after: &[f64; N],
) -> f64 {
    let mut worst: f64 = 0.0;
    for n in 0..N {
        let share = error[n].abs() / (TOLERANCE * size[n].max(before[n].abs()).max(after[n].abs()));
        // A rate that is not finite gives an infinite error; `max` would ignore NaN.
        worst = if share.is_finite() { worst.max(share) } else { f64::INFINITY };
    }
    worst
}

/// One step of Dormand and Prince: `point(t, x)` are the intermediate results `t` seconds into the communication step, `rates` the
/// derivatives from them; the error of each state is relative to `size` or to the state itself, whichever is larger.
pub fn dormand_prince<P, const N: usize>(
    point: impl Fn(f64, &[f64; N]) -> P,
    rates: impl Fn(&P) -> [f64; N],
    t: f64,
    x: &[f64; N],
    first: Option<&P>,
    h: f64,
    size: &[f64; N],
) -> Tried<P, N> {
    let mut k = [[0.0; N]; 7];
    k[0] = first.map_or_else(|| rates(&point(t, x)), &rates);
    let (mut next, mut last) = (*x, None);
    for stage in 1..7 {
        for n in 0..N {
            let sum: f64 = (0..stage).map(|s| A[stage][s] * k[s][n]).sum();
            next[n] = x[n] + h * sum;
        }
        let at = point(t + C[stage] * h, &next);
        k[stage] = rates(&at);
        last = Some(at);
    }
    let error = std::array::from_fn(|n| h * (0..7).map(|s| E[s] * k[s][n]).sum::<f64>());
    Tried { states: next, error: share_of(&error, size, x, &next), point: last }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Advances by Dormand and Prince's steps only.
    fn run<const N: usize>(
        rates: impl Fn(f64, &[f64; N]) -> [f64; N],
        x: &mut [f64; N],
        h: f64,
    ) -> Result<(), StepFailure> {
        let one = |t: f64, x: &[f64; N], first: Option<&[f64; N]>, h: f64| {
            dormand_prince(&rates, |rates| *rates, t, x, first, h, &[1.0; N])
        };
        advance(one, x, None, h, 1.0).map(|_| ())
    }

    /// x' = -50 x + 50 sin(t): a transient and a forced motion, with a closed solution.
    #[test]
    fn follows_a_known_solution() {
        let exact = |t: f64| {
            let (a, d) = (50.0f64, 50.0f64 * 50.0 + 1.0);
            (1.0 + a / d) * (-a * t).exp() + a * (a * t.sin() - t.cos()) / d
        };
        let mut x = [1.0];
        for k in 0..20 {
            let start = f64::from(k) * 0.01;
            run(|t, x: &[f64; 1]| [50.0 * ((start + t).sin() - x[0])], &mut x, 0.01).unwrap();
        }
        assert!((x[0] - exact(0.2)).abs() < 2e-7, "{} {}", x[0], exact(0.2));
    }

    #[test]
    fn the_order_is_five() {
        let run = |n: u32| {
            let mut x = [1.0];
            let h = 1.0 / f64::from(n);
            for _ in 0..n {
                let rates = |_: f64, x: &[f64; 1]| [-x[0]];
                x = dormand_prince(rates, |rates| *rates, 0.0, &x, None, h, &[1.0]).states;
            }
            (x[0] - (-1.0f64).exp()).abs()
        };
        let order = (run(4) / run(8)).log2();
        assert!((order - 5.0).abs() < 0.4, "{order}");
    }

    #[test]
    fn years_at_once_are_refused_and_nothing_changes() {
        let mut x = [1.0];
        let step_failure = run(|t, _: &[f64; 1]| [t.sin()], &mut x, 1e9).unwrap_err();
        assert!(step_failure.t > 1e3 && step_failure.t < 1e9 && x == [1.0]);
    }

    #[test]
    fn what_is_no_number_is_refused_and_nothing_changes() {
        let mut x = [1.0];
        let step_failure = run(|t, _: &[f64; 1]| [if t > 0.3 { f64::NAN } else { 1.0 }], &mut x, 1.0);
        assert!((step_failure.unwrap_err().t - 0.3).abs() < 1e-3);
        assert_eq!(x, [1.0]);
    }
}
