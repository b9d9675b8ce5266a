//! A stabilised explicit method for networks of many slow nodes: Runge-Kutta-Chebyshev, second order.
//!
//! ```text
//! Y_0 = y,  Y_1 = y + m~_1 h F(y),
//! Y_j = (1 - m_j - n_j) y + m_j Y_{j-1} + n_j Y_{j-2} + m~_j h F(t + c_{j-1} h, Y_{j-1}) + g~_j h F(y)   (1)
//! ```
//! with coefficients from Chebyshev polynomials. With s stages it is stable on the negative real axis down to -2/3 (s^2 - 1): the work
//! grows with the square root of the stiffness, and a step needs s evaluations of a sparse network instead of a full matrix. A conserved
//! linear combination of the states (energy) is conserved by (1) to rounding.
//! *Error*: 4/5 (y_0 - y_1) + 2/5 h (F_0 + F_1), the difference to a third-order quadrature.
//! *Source*: Sommeijer, Shampine, Verwer, J. Comput. Appl. Math. 88 (1998) 315-326, eqs. (2.1) to (2.5), (2.8).

/// Largest number of states of a system.
pub const MOST: usize = 68;
/// States, the first of which are in use.
pub type States = [f64; MOST];

/// Damping of the stability region.
const DAMPING: f64 = 2.0 / 13.0;
/// Largest number of stages of one step.
const MOST_STAGES: usize = 50;

/// The method with a number of stages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stabilized {
    stages: usize,
    w0: f64,
    w1: f64,
}

impl Default for Stabilized {
    fn default() -> Self {
        Stabilized::new(2)
    }
}

/// Chebyshev polynomial T_s with T_s' and T_s'' at `w0`.
fn chebyshev(s: usize, w0: f64) -> [f64; 3] {
    let (mut before, mut now) = ([1.0, 0.0, 0.0], [w0, 1.0, 0.0]);
    for _ in 1..s {
        let next = [
            2.0 * w0 * now[0] - before[0],
            2.0 * (now[0] + w0 * now[1]) - before[1],
            2.0 * (2.0 * now[1] + w0 * now[2]) - before[2],
        ];
        (before, now) = (now, next);
    }
    now
}

impl Stabilized {
    /// The method with `stages` stages, 2 to 50.
    pub fn new(stages: usize) -> Self {
        let stages = stages.clamp(2, MOST_STAGES);
        let w0 = 1.0 + DAMPING / (stages * stages) as f64;
        let [_, d1, d2] = chebyshev(stages, w0);
        Stabilized { stages, w0, w1: d1 / d2 }
    }

    /// The method with the fewest stages that is stable for `z` = h times the largest rate, or the one with the most stages.
    pub fn for_stiffness(z: f64) -> Self {
        let stages = (z / 0.65 + 1.0).max(0.0).sqrt().ceil();
        Self::new(stages.min(MOST_STAGES as f64) as usize)
    }

    /// The largest h times rate for which the method is stable.
    pub fn stiffness(&self) -> f64 {
        let s = self.stages as f64;
        0.65 * (s * s - 1.0)
    }

    /// Stages of a step.
    pub fn stages(&self) -> usize {
        self.stages
    }

    /// One step of length `h` of the first `n` states from `y` with the rates `f0` there; `rates(t, y, out)` with
    /// t from the step's start. Returns the states at the end.
    #[inline]
    pub fn step<const M: usize>(
        &self,
        n: usize,
        y: &[f64; M],
        f0: &[f64; M],
        h: f64,
        mut rates: impl FnMut(f64, &[f64; M], &mut [f64; M]),
    ) -> [f64; M] {
        let (w0, w1) = (self.w0, self.w1);
        let n = n.min(M);
        // b_0 = b_1 = b_2 = T_2''/(T_2')^2 with T_2'' = 4, T_2' = 4 w0.
        let b2 = 4.0 / (16.0 * w0 * w0);
        let (mut b_before, mut b_last) = (b2, b2);
        // Chebyshev polynomials and their derivatives at w0, for j - 2 and j - 1.
        let (mut t_before, mut t_last) = ([1.0, 0.0, 0.0], [w0, 1.0, 0.0]);
        let (mut c_before, mut c_last) = (0.0, b2 * w1);
        let (mut before, mut last) = (*y, *y);
        let first = b2 * w1 * h;
        for k in 0..n {
            last[k] = y[k] + first * f0[k];
        }
        let mut f = [0.0; M];
        for _ in 2..=self.stages {
            let t = [
                2.0 * w0 * t_last[0] - t_before[0],
                2.0 * (t_last[0] + w0 * t_last[1]) - t_before[1],
                2.0 * (2.0 * t_last[1] + w0 * t_last[2]) - t_before[2],
            ];
            let b = t[2] / (t[1] * t[1]);
            let mu = 2.0 * b * w0 / b_last;
            let nu = -b / b_before;
            let mu_tilde = 2.0 * b * w1 / b_last * h;
            let a_last = 1.0 - b_last * t_last[0];
            let gamma = -a_last * mu_tilde;
            rates(c_last * h, &last, &mut f);
            for k in 0..n {
                let next =
                    (1.0 - mu - nu) * y[k] + mu * last[k] + nu * before[k] + mu_tilde * f[k] + gamma * f0[k];
                before[k] = last[k];
                last[k] = next;
            }
            // The time of a stage follows the same recurrence as a state whose rate is 1.
            let c = mu * c_last + nu * c_before + (mu_tilde + gamma) / h;
            (c_before, c_last) = (c_last, c);
            (t_before, t_last) = (t_last, t);
            (b_before, b_last) = (b_last, b);
        }
        last
    }
}

/// Error of a step from `y0` with rates `f0` to `y1` with rates `f1`, for one state.
#[inline]
pub fn error(y0: f64, f0: f64, y1: f64, f1: f64, h: f64) -> f64 {
    0.8 * (y0 - y1) + 0.4 * h * (f0 + f1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(stages: usize, steps: usize, rate: f64) -> f64 {
        // y' = rate (cos t - y): smooth, with adjustable stiffness.
        let method = Stabilized::new(stages);
        let h = 1.0 / steps as f64;
        let mut y = [0.0; MOST];
        y[0] = 1.0;
        for k in 0..steps {
            let t0 = k as f64 * h;
            let f = |t: f64, y: &States, out: &mut States| out[0] = rate * ((t0 + t).cos() - y[0]);
            let mut f0 = [0.0; MOST];
            f(0.0, &y, &mut f0);
            y = method.step(1, &y, &f0, h, f);
        }
        y[0]
    }

    fn exact(rate: f64) -> f64 {
        // y = a cos t + b sin t + c e^(-rate t), y(0) = 1
        let a = rate * rate / (1.0 + rate * rate);
        let b = rate / (1.0 + rate * rate);
        a * 1f64.cos() + b * 1f64.sin() + (1.0 - a) * (-rate).exp()
    }

    /// Error as a function of the step: order 2 within 0.2 for any number of stages.
    #[test]
    fn second_order() {
        for stages in [2, 3, 5, 12] {
            let e = |steps| (run(stages, steps, 3.0) - exact(3.0)).abs();
            let order = (e(40) / e(160)).log2() / 2.0;
            assert!((order - 2.0).abs() < 0.2, "{stages} stages: order {order}");
        }
    }

    /// Stable up to the limit used by for_stiffness.
    #[test]
    fn stable_for_the_stiffness_it_was_chosen_for() {
        for z in [1.0, 1.9, 10.0, 300.0, 1600.0] {
            let method = Stabilized::for_stiffness(z);
            assert!(z <= method.stiffness() && (method.stages() as f64) < 3.0 + (z / 0.6f64).sqrt());
            let y = run(method.stages(), 10, 10.0 * z);
            assert!((y - exact(10.0 * z)).abs() < 0.05, "{z}: {y}");
        }
    }

    /// A chain with a conserved sum: conserved to rounding.
    #[test]
    fn a_linear_sum_is_kept() {
        let method = Stabilized::new(4);
        let mut y = [0.0; MOST];
        y[..3].copy_from_slice(&[1.0, 5.0, -2.0]);
        let rates = |_t: f64, y: &States, out: &mut States| {
            let (a, b) = (3.0 * (y[0] - y[1]), 7.0 * (y[1] - y[2]));
            out[..3].copy_from_slice(&[-a, a - b, b]);
        };
        for _ in 0..100 {
            let mut f0 = [0.0; MOST];
            rates(0.0, &y, &mut f0);
            y = method.step(3, &y, &f0, 0.3, rates);
        }
        assert!((y[0] + y[1] + y[2] - 4.0).abs() < 1e-13 && (y[0] - y[2]).abs() < 0.1, "{:?}", &y[..3]);
    }

    #[test]
    fn the_estimate_is_of_the_size_of_the_error() {
        let (h, rate) = (0.1, 2.0);
        let mut y = [0.0; MOST];
        y[0] = 1.0;
        let f = |_t: f64, y: &States, out: &mut States| out[0] = -rate * y[0];
        let (mut f0, mut f1) = ([0.0; MOST], [0.0; MOST]);
        f(0.0, &y, &mut f0);
        let y1 = Stabilized::new(2).step(1, &y, &f0, h, f);
        f(h, &y1, &mut f1);
        let estimate = error(y[0], f0[0], y1[0], f1[0], h).abs();
        let truth = (y1[0] - (-rate * h).exp()).abs();
        assert!(estimate > 0.1 * truth && estimate < 10.0 * truth, "{estimate} {truth}");
    }
}
