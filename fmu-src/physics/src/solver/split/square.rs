//! The integral of the square of the current over one step of the fast block, exact for its solution.
//!
//! ```text
//! x' = A x + n,   n = n_0 + n_1 s + n_2 s^2,   s = t / h                                   (1)
//! V = x^T S x,    A^T S + S A = -Q,   Q = diag(1, 0)                                       (2)
//! int i^2 dt = V(0) - V(h) + 2 int x^T S n dt                                              (3)
//! S = -(det Q + r r^T) / (2 tr det),   r = (a_22, -a_12)                                   (4)
//! ```
//! The integral with n follows from those of x, t x and t^2 x with the phi functions. A transient that decays early in a long step
//! needs no special treatment, and the energies of inductance and rotor cancel in (3) as they do in the energy balance, so that rounding
//! is relative to them.
//!
//! If the second row of A is zero (imposed speed, linear over the step) a scalar equation replaces (2):
//! S = -1/(2 a_11) with a_12 w as a part of n. If the block has no Lyapunov function, Simpson's rule replaces (3).
//! *Source*: (2), (3): differentiate V; (4): the solution of the Lyapunov equation for two rows, by insertion.

use super::Fast;
use crate::solver::phi::{Forcing, product};
use nalgebra::Matrix2;

/// Trace and determinant are treated as zero below this fraction of their terms: (4) loses as many digits.
const SINGULAR: f64 = 1e-7;

/// Coefficients of eq. (3) for one A and one h; `None` without a Lyapunov function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Squares(Option<Form>);

#[derive(Clone, Copy, Debug, PartialEq)]
struct Form {
    s: Matrix2<f64>,
    /// 2 S_11 a_12 where the speed is imposed, else 0.
    coupled: f64,
}

impl Squares {
    /// For a block with this matrix.
    pub fn of(a: &Matrix2<f64>) -> Squares {
        Squares(lyapunov(a).map(|s| {
            let coupled = if is_imposed(a) { 2.0 * s[(0, 0)] * a[(0, 1)] } else { 0.0 };
            Form { s, coupled }
        }))
    }

    /// int i^2 dt over a step with these currents and speeds at its start, middle and end, with the integrals of x, t x and s^2 x, with
    /// n_0 and the rest of the forcing. Also the error of the trapezoidal rule if Simpson's rule replaces eq. (3), else 0.
    #[inline(always)]
    pub fn integral(
        &self,
        h: f64,
        x: &[Fast; 3],
        [first, moment, second]: [&Fast; 3],
        (n0, n): (&Fast, &Forcing<2>),
    ) -> (f64, f64) {
        let Some(Form { s, coupled }) = &self.0 else {
            let [start, middle, end] = x.map(|x| x[0] * x[0]);
            let simpson = h / 6.0 * (start + 4.0 * middle + end);
            return (simpson, (simpson - 0.5 * h * (start + end)).abs());
        };
        let moment = moment * (1.0 / h);
        let of = |a: &Fast, b: &Fast| product(s, a).dot(b);
        // 2 int x^T S n dt. S n is known before the integrals, so that few operations follow them.
        let forcing = of(&(n0 * 2.0), first) + (of(&(n.n1 * 2.0), &moment) + of(&(n.n2 * 2.0), second));
        // a_12 w with the speed linear over the step.
        let speed = coupled * (x[0][1] * first[0] + h * n0[1] * moment[0]);
        // V(0) - V(h) from the differences, without rounding error at equilibrium.
        (of(&(x[0] - x[2]), &(x[0] + x[2])) + speed + forcing, 0.0)
    }
}

/// Whether the speed is imposed: linear over the step.
fn is_imposed(a: &Matrix2<f64>) -> bool {
    a[(1, 0)] == 0.0 && a[(1, 1)] == 0.0
}

/// S of eq. (4), or of the scalar equation.
fn lyapunov(a: &Matrix2<f64>) -> Option<Matrix2<f64>> {
    if is_imposed(a) {
        return (a[(0, 0)] < 0.0).then(|| Matrix2::new(-0.5 / a[(0, 0)], 0.0, 0.0, 0.0));
    }
    let (direct, cross) = (a[(0, 0)] * a[(1, 1)], a[(0, 1)] * a[(1, 0)]);
    let (trace, determinant) = (a[(0, 0)] + a[(1, 1)], direct - cross);
    let is_regular = trace.abs() > SINGULAR * (a[(0, 0)].abs() + a[(1, 1)].abs())
        && determinant.abs() > SINGULAR * (direct.abs() + cross.abs());
    let (p, q) = (a[(1, 1)], -a[(0, 1)]);
    let over = -0.5 / (trace * determinant);
    is_regular.then(|| Matrix2::new(over * (determinant + p * p), over * p * q, over * p * q, over * q * q))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::phi::Phi;
    use nalgebra::{matrix, vector};

    /// By Gauss's rule with three points on intervals that grow from the fastest time constant on, limited by the period of an oscillation.
    fn by_quadrature(a: &Matrix2<f64>, h: f64, x0: &Fast, n: [Fast; 3]) -> f64 {
        let forcing = |s: f64| n[0] + n[1] * s + n[2] * (s * s);
        let at = |t: f64| {
            // The same forcing over the shorter step.
            let s = t / h;
            let part = Forcing::through(forcing(0.5 * s) - n[0], forcing(s) - n[0]);
            Phi::new(*a, t).end(x0, &(a * x0 + n[0]), &part)[0].powi(2)
        };
        let (half_trace, determinant) = (0.5 * a.trace(), a.determinant());
        let swing = (determinant - half_trace * half_trace).max(0.0).sqrt();
        let (mut from, mut sum) = (0.0, 0.0);
        let mut width = (0.01 / a.norm()).min(0.01 * h);
        while from < h {
            let to = (from + width).min(h);
            let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
            let (node, inner, outer) = (0.6f64.sqrt(), 8.0 / 9.0, 5.0 / 9.0);
            sum +=
                half * (inner * at(middle) + outer * (at(middle - node * half) + at(middle + node * half)));
            from = to;
            width = (1.02 * width).min(0.2 / swing);
        }
        sum
    }

    fn by_form(a: &Matrix2<f64>, h: f64, x0: &Fast, n: [Fast; 3]) -> (f64, f64) {
        let phi = Phi::new(*a, h);
        let forcing = Forcing::through(n[1] * 0.5 + n[2] * 0.25, n[1] + n[2]);
        let rate = a * x0 + n[0];
        let x = [*x0, phi.middle(x0, &rate, &forcing), phi.end(x0, &rate, &forcing)];
        let [first, moment] = [phi.integral(x0, &rate, &forcing), phi.moment(x0, &rate, &forcing)];
        let second = phi.second(x0, &rate, &forcing);
        Squares::of(a).integral(h, &x, [&first, &moment, &second], (&n[0], &forcing))
    }

    /// Two real eigenvalues far apart, close together, a complex pair, a shaft without friction, an imposed speed; steps from much
    /// shorter to much longer than the time constants.
    #[test]
    fn the_square_is_that_of_the_solution() {
        let blocks = [
            matrix![-5900.0, -420.0; 8300.0, -3.0],
            matrix![-5900.0, -420.0; 8300.0, 0.0],
            matrix![-200.0, -4000.0; 9000.0, -1.0],
            matrix![-300.0, 0.0; 0.0, -0.2],
            matrix![-5900.0, -420.0; 0.0, 0.0],
        ];
        for a in blocks {
            for h in [1e-5, 1e-3, 0.05, 2.0] {
                let imposed = a[(1, 0)] == 0.0 && a[(1, 1)] == 0.0;
                let line = if imposed { 0.0 } else { 1.0 };
                let (x0, n) = (
                    vector![3.0, 20.0],
                    [vector![4e4, -50.0], vector![3e3, 200.0 * line], vector![-2e3, 70.0 * line]],
                );
                let (exact, (square, quadrature_error)) =
                    (by_quadrature(&a, h, &x0, n), by_form(&a, h, &x0, n));
                assert!(
                    (square / exact - 1.0).abs() < 1e-8 && quadrature_error == 0.0,
                    "{a} {h}: {square} {exact}"
                );
            }
        }
    }

    /// Friction that decreases with speed as fast as the armature brakes: no Lyapunov function, so Simpson's rule and its error estimate.
    #[test]
    fn a_block_without_a_lyapunov_function_takes_simpsons_rule() {
        let a = matrix![-5900.0, -420.0; 8300.0, 420.0 * 8300.0 / 5900.0];
        let (h, x0, n) =
            (1e-5, vector![3.0, 20.0], [vector![4e4, -50.0], vector![0.0, 0.0], vector![0.0, 0.0]]);
        let (exact, (square, quadrature_error)) = (by_quadrature(&a, h, &x0, n), by_form(&a, h, &x0, n));
        assert!(
            quadrature_error > 0.0
                && (square - exact).abs() < quadrature_error
                && (square / exact - 1.0).abs() < 1e-6
        );
    }
}
