//! The phi functions of a small matrix: the exact solution of a linear system with polynomial forcing.
//!
//! ```text
//! phi_0(z) = e^z,   phi_k(z) = (phi_{k-1}(z) - 1/(k-1)!) / z                               (1)
//! ```
//! x' = A x + sum_j n_j (t/h)^j,  j = 0, 1, 2, is solved over a step h by
//! ```text
//! x(h)          = x0 + h sum_j j! phi_{j+1} r_j                                            (2)
//! int x dt      = h x0 + h^2 sum_j j! phi_{j+2} r_j                                        (3)
//! int t x dt    = h^2/2 x0 + h^3 sum_j j! (phi_{j+2} - phi_{j+3}) r_j                      (4)
//! int s^2 x dt  = h/3 x0 + h^2 sum_j j! (phi_{j+2} - 2 phi_{j+3} + 2 phi_{j+4}) r_j,   s = t/h   (5)
//! ```
//! with phi_k = phi_k(h A), r_0 = A x0 + n_0, the derivative at the start, and r_j = n_j, j > 0. An equilibrium is preserved to the last
//! bit. A is not inverted, so a singular A (a shaft without friction, an imposed current) needs no special treatment.
//!
//! *Method*: Taylor series of the highest phi at A h / 2^s, the others by (1) backwards, then s doublings
//! ```text
//! phi_k(2z) = 2^-k [ phi_0(z) phi_k(z) + sum_{j=1..k} phi_j(z) / (k-j)! ]                  (6)
//! ```
//! *Source*: Hochbruck, Ostermann: Exponential integrators, Acta Numerica 19 (2010), sections 2.1 and 4.1;
//! (6): Skaflestad, Wright, Applied Numerical Mathematics 59 (2009).

mod pair;

use nalgebra::{SMatrix, SVector};
use pair::pair;
use std::ops::{Add, Mul, Sub};

/// The product of a matrix and a vector, unrolled: several times faster than the general one at these sizes.
#[inline(always)]
pub fn product<const N: usize>(m: &SMatrix<f64, N, N>, x: &SVector<f64, N>) -> SVector<f64, N> {
    let (columns, x) = (&m.data.0, &x.data.0[0]);
    let mut y = columns[0].map(|number| number * x[0]);
    for j in 1..N {
        for i in 0..N {
            y[i] += columns[j][i] * x[j];
        }
    }
    SVector::from(y)
}

/// Number of phi functions: phi_0 ... phi_6, for (5).
const KEPT: usize = 7;
/// Number of phi functions at half the step: phi_0 ... phi_3.
const HALF: usize = 4;
/// Even power at which the Taylor series of phi_6 of a matrix of norm 1 ends, with the next odd one: the remainder
/// is 6! / 22! of the sum, far below the rounding of a double.
const POWER: usize = 14;
/// Norm up to which [`POWER_SMALL`] is sufficient: 1e-3^6 6! / 12!.
const SMALL: f64 = 1e-3;
const POWER_SMALL: usize = 4;
/// 1 / k!
const RECIPROCAL: [f64; KEPT + POWER + 1] = {
    let (mut reciprocal, mut factorial, mut k) = ([1.0; KEPT + POWER + 1], 1.0, 1);
    while k < reciprocal.len() {
        factorial *= k as f64;
        reciprocal[k] = 1.0 / factorial;
        k += 1;
    }
    reciprocal
};
/// 2^-k
const HALVED: [f64; KEPT] = [1.0, 0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015625];

/// The solution for one A and one h. Aligned so that the processor reads two numbers of a matrix as an operand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(16))]
pub struct Phi<const N: usize> {
    a: SMatrix<f64, N, N>,
    h: f64,
    weights: Weights<SMatrix<f64, N, N>>,
}

/// Weights of r_0, r_1, r_2 in the equations, as matrices, or as what stands for a function of A.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights<T> {
    /// Eq. (2) at half the step.
    middle: [T; 3],
    /// Eqs. (2), (3), (4) and (5).
    end: [T; 3],
    integral: [T; 3],
    moment: [T; 3],
    second: [T; 3],
    /// h (2 phi_3 - phi_2): weight of the difference of a parabola to a straight line.
    curvature: T,
    /// h (4 phi_3 - phi_2): weight of the last of the three values of a parabola.
    last: T,
}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Weights<T> {
    #[inline(always)]
    fn of((phi, half): Functions<T>, h: f64) -> Self {
        let (square, cube) = (h * h, h * h * h);
        let first = |k: usize| phi[k] - phi[k + 1];
        let second = |k: usize| phi[k] - phi[k + 1] * 2.0 + phi[k + 2] * 2.0;
        Weights {
            middle: [half[1] * (0.5 * h), half[2] * (0.25 * h), half[3] * (0.25 * h)],
            end: [phi[1] * h, phi[2] * h, phi[3] * (2.0 * h)],
            integral: [phi[2] * square, phi[3] * square, phi[4] * (2.0 * square)],
            moment: [first(2) * cube, first(3) * cube, first(4) * (2.0 * cube)],
            second: [second(2) * square, second(3) * square, second(4) * (2.0 * square)],
            curvature: (phi[3] * 2.0 - phi[2]) * h,
            last: (phi[3] * 4.0 - phi[2]) * h,
        }
    }

    #[inline(never)]
    fn map<U>(self, f: impl Fn(T) -> U) -> Weights<U> {
        Weights {
            middle: self.middle.map(&f),
            end: self.end.map(&f),
            integral: self.integral.map(&f),
            moment: self.moment.map(&f),
            second: self.second.map(&f),
            curvature: f(self.curvature),
            last: f(self.last),
        }
    }
}

/// phi_0 ... phi_6 of the whole step, and phi_0 ... phi_3 of half of it.
type Functions<T> = ([T; KEPT], [T; HALF]);

/// The functions of z times 2^doublings, by eqs. (1) and (6); `times` multiplies two functions of z, `plus` adds a number
/// times `one`.
#[inline(always)]
fn functions<T>(
    [one, z]: [T; 2],
    (power, doublings): (usize, i32),
    times: impl Fn(&T, &T) -> T,
    plus: impl Fn(T, f64) -> T,
) -> Functions<T>
where
    T: Copy + Add<Output = T> + Mul<f64, Output = T>,
{
    // Even and odd powers separately, for instruction-level parallelism.
    let square = times(&z, &z);
    let (mut even, mut odd) = (one * RECIPROCAL[KEPT - 1 + power], one * RECIPROCAL[KEPT + power]);
    for k in (0..power).step_by(2).rev() {
        even = plus(times(&square, &even), RECIPROCAL[KEPT - 1 + k]);
        odd = plus(times(&square, &odd), RECIPROCAL[KEPT + k]);
    }
    let mut phi = [one; KEPT];
    phi[KEPT - 1] = even + times(&z, &odd);
    for k in (0..KEPT - 1).rev() {
        phi[k] = plus(times(&z, &phi[k + 1]), RECIPROCAL[k]);
    }
    let mut half = [one; HALF];
    for _ in 0..doublings {
        half.copy_from_slice(&phi[..HALF]);
        let e = phi[0];
        for k in (1..KEPT).rev() {
            // 1 / 1! and 1 / 0! are 1.
            let mut sum = times(&e, &phi[k]) + phi[k];
            if k > 1 {
                sum = sum + phi[k - 1];
            }
            for j in 1..(k - 1).max(1) {
                sum = sum + phi[j] * RECIPROCAL[k - j];
            }
            phi[k] = sum * HALVED[k];
        }
        phi[0] = times(&e, &e);
    }
    (phi, half)
}

/// Number of halvings for a matrix of this norm, and the last power of its series. At least one halving,
/// so that the functions of half the step are available.
fn scaling(size: f64) -> (i32, usize) {
    let (mut doublings, mut left) = (1, 0.5 * size);
    while left > 1.0 && left.is_finite() {
        (doublings, left) = (doublings + 1, 0.5 * left);
    }
    (doublings, if left < SMALL { POWER_SMALL } else { POWER })
}

/// The functions of any matrix.
fn of_any<const N: usize>(z: &SMatrix<f64, N, N>, h: f64) -> Weights<SMatrix<f64, N, N>> {
    let (doublings, power) = scaling(z.abs().column_sum().max());
    let (one, z) = (SMatrix::identity(), z * 0.5f64.powi(doublings));
    let of_z = functions([one, z], (power, doublings), |a, b| a * b, |a, number| a + one * number);
    Weights::of(of_z, h)
}

impl<const N: usize> Phi<N> {
    /// No functions yet: they hold for a step of 0 s, which no step has.
    pub fn none() -> Self {
        let none = SMatrix::zeros();
        let three = [none; 3];
        let (middle, end, integral, moment, second) = (three, three, three, three, three);
        let weights = Weights { middle, end, integral, moment, second, curvature: none, last: none };
        Phi { a: none, h: 0.0, weights }
    }

    /// The functions of `h * a`; `h` in s, `a` in 1/s, both finite.
    pub fn new(a: SMatrix<f64, N, N>, h: f64) -> Self {
        let z = a * h;
        Phi { a, h, weights: pair(&z, h).unwrap_or_else(|| of_any(&z, h)) }
    }

    /// The step for which these functions hold, s.
    pub fn step(&self) -> f64 {
        self.h
    }

    /// The matrix for which these functions hold, 1/s.
    pub fn matrix(&self) -> &SMatrix<f64, N, N> {
        &self.a
    }

    /// x(h/2) - x(0) for a constant forcing, eq. (2) at half the step. `rate` is the derivative at the start, here and below.
    #[inline]
    pub fn half(&self, rate: &SVector<f64, N>) -> SVector<f64, N> {
        product(&self.weights.middle[0], rate)
    }

    /// x(h/2) for a quadratic forcing over the whole step, eq. (2) at half the step.
    #[inline]
    pub fn middle(&self, x: &SVector<f64, N>, rate: &SVector<f64, N>, n: &Forcing<N>) -> SVector<f64, N> {
        x + n.weighted(&self.weights.middle, rate)
    }

    /// x(h) - x(0) for a constant forcing, eq. (2).
    #[inline]
    pub fn constant(&self, rate: &SVector<f64, N>) -> SVector<f64, N> {
        product(&self.weights.end[0], rate)
    }

    /// x(h) for a quadratic forcing, eq. (2).
    #[inline]
    pub fn end(&self, x: &SVector<f64, N>, rate: &SVector<f64, N>, n: &Forcing<N>) -> SVector<f64, N> {
        x + n.weighted(&self.weights.end, rate)
    }

    /// int x dt over the step, eq. (3).
    #[inline]
    pub fn integral(&self, x: &SVector<f64, N>, rate: &SVector<f64, N>, n: &Forcing<N>) -> SVector<f64, N> {
        x * self.h + n.weighted(&self.weights.integral, rate)
    }

    /// int t x dt over the step, with t from the step's start, eq. (4).
    #[inline]
    pub fn moment(&self, x: &SVector<f64, N>, rate: &SVector<f64, N>, n: &Forcing<N>) -> SVector<f64, N> {
        x * (0.5 * self.h * self.h) + n.weighted(&self.weights.moment, rate)
    }

    /// int s^2 x dt over the step, s = t/h, eq. (5).
    #[inline]
    pub fn second(&self, x: &SVector<f64, N>, rate: &SVector<f64, N>, n: &Forcing<N>) -> SVector<f64, N> {
        x * (self.h / 3.0) + n.weighted(&self.weights.second, rate)
    }

    /// Difference between the solutions with linear and with quadratic forcing: the error of the
    /// next lower order.
    #[inline]
    pub fn curvature_error(&self, n: &Forcing<N>) -> SVector<f64, N> {
        product(&self.weights.curvature, &n.n2)
    }

    /// Upper bound of the same for n_2 up to this size.
    #[inline]
    pub fn curvature_bound(&self, most: &SVector<f64, N>) -> SVector<f64, N> {
        product(&self.weights.curvature.abs(), most)
    }

    /// Change of x(h) if the quadratic forcing at the end of the step increases by `late`.
    #[inline]
    pub fn last_stage_error(&self, late: &SVector<f64, N>) -> SVector<f64, N> {
        product(&self.weights.last, late)
    }
}

/// What a forcing n_0 + n_1 s + n_2 s^2 over a step, s = t/h from 0 to 1, adds to its value at the start.
#[derive(Clone, Copy, Debug)]
pub struct Forcing<const N: usize> {
    pub(super) n1: SVector<f64, N>,
    pub(super) n2: SVector<f64, N>,
}

impl<const N: usize> Forcing<N> {
    /// The parabola through 0 at the start and these values at the middle and the end of a step. The integral of the forcing is
    /// Simpson's rule over the three.
    #[inline]
    pub fn through(middle: SVector<f64, N>, end: SVector<f64, N>) -> Self {
        Forcing { n1: middle * 4.0 - end, n2: end * 2.0 - middle * 4.0 }
    }

    /// The derivative at the start and the coefficients, each times its matrix.
    #[inline(always)]
    pub(super) fn weighted(
        &self,
        matrices: &[SMatrix<f64, N, N>; 3],
        rate: &SVector<f64, N>,
    ) -> SVector<f64, N> {
        product(&matrices[0], rate) + product(&matrices[1], &self.n1) + product(&matrices[2], &self.n2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2, matrix, vector};
    use proptest::prelude::*;

    /// A scalar system whose phi functions have closed forms: x' = -x + 1 + s + s^2 over h = 2.
    #[test]
    fn scalar_with_quadratic_forcing_has_its_closed_form() {
        let h = 2.0f64;
        let phi = Phi::<1>::new(matrix![-1.0], h);
        let n = Forcing { n1: vector![1.0], n2: vector![1.0] };
        // x = a + b t + c t^2 + d e^-t with s = t/2: c = 1/4, b = 1/2 - 2c = 0, a = 1 - b = 1.
        let exact = |t: f64| 1.0 + 0.25 * t * t + 2.0 * (-t).exp();
        let x0 = vector![exact(0.0)];
        let rate = vector![1.0] - x0;
        assert!((phi.middle(&x0, &rate, &n)[0] - exact(0.5 * h)).abs() < 1e-14);
        assert!((phi.end(&x0, &rate, &n)[0] - exact(h)).abs() < 1e-14);
        let integral = h + h.powi(3) / 12.0 + 2.0 * (1.0 - (-h).exp());
        assert!((phi.integral(&x0, &rate, &n)[0] - integral).abs() < 1e-14);
        let moment = h * h / 2.0 + h.powi(4) / 16.0 + 2.0 * (1.0 - (1.0 + h) * (-h).exp());
        assert!((phi.moment(&x0, &rate, &n)[0] - moment).abs() < 1e-14);
    }

    #[test]
    fn a_singular_matrix_is_no_special_case() {
        let phi = Phi::<2>::new(Matrix2::zeros(), 0.5);
        let n = Forcing::through(vector![0.0, 1.0], vector![0.0, 2.0]);
        let x = phi.end(&vector![0.0, 0.0], &vector![1.0, 0.0], &n);
        assert!((x - vector![0.5, 0.5]).norm() < 1e-15, "{x}");
    }

    #[test]
    fn a_stiff_step_lands_on_the_steady_state() {
        // The slowest rate times the step is 560: the initial state has no influence.
        let a = matrix![-5900.0, -420.0; 8300.0, 0.0];
        let phi = Phi::new(a, 1.0);
        let (x0, n) = (vector![1.0, 2.0], vector![3.0e5, -100.0]);
        let x = x0 + phi.constant(&(a * x0 + n));
        let steady = -a.try_inverse().unwrap() * n;
        assert!((x - steady).norm() < 1e-9 * steady.norm(), "{x} {steady}");
    }

    /// Eigenvalues apart, equal, and one of them much larger than the other, on both sides of [`pair::FAR`]; then complex ones. Compared with
    /// the closed form x_s + e^{A h} (x0 - x_s), within the rounding of A x0 and of the doublings.
    #[test]
    fn a_matrix_of_two_rows_has_its_closed_form_near_and_far() {
        let turn = matrix![0.8, -0.6; 0.6, 0.8];
        let (x0, n) = (vector![1.0, 2.0], vector![3.0, -1.0]);
        let holds = |[a, inverse, decay]: [Matrix2<f64>; 3], size: f64, near: bool| {
            let steady = -inverse * n;
            let exact = steady + decay * (x0 - steady);
            let error = (x0 + Phi::new(a, 1.0).constant(&(a * x0 + n)) - exact).norm() / exact.norm();
            assert!(error < 1e-15 * (2.0 + 0.3 * size), "{a} {error:e}");
            assert_eq!(pair(&a, 1.0).is_some(), near, "{a}");
        };
        for (fast, slow) in
            [(-3.0, -0.5), (-2.0, -2.0), (-900.0, -0.5), (-9e3, -0.5), (-3e4, -0.5), (-1e6, -1e-2)]
        {
            let of = |fast: f64, slow: f64| turn * matrix![fast, 0.0; 0.0, slow] * turn.transpose();
            let matrices = [of(fast, slow), of(1.0 / fast, 1.0 / slow), of(fast.exp(), slow.exp())];
            holds(matrices, -fast, fast > -pair::FAR);
        }
        for (decay, swing) in [(0.0, 0.3), (-0.5, 2.0), (-3.0, 40.0)] {
            let of = |real: f64, imaginary: f64| matrix![real, -imaginary; imaginary, real];
            let (e, square) = (f64::exp(decay), decay * decay + swing * swing);
            let inverse = of(decay / square, -swing / square);
            holds([of(decay, swing), inverse, of(e * swing.cos(), e * swing.sin())], swing, true);
        }
    }

    proptest! {
        /// Two half steps equal one whole step, a property that the doublings must preserve.
        #[test]
        fn two_halves_make_a_whole(rates in prop::array::uniform4(-3e3f64..3e3), h in 1e-6f64..2e-3,
                                   x0 in prop::array::uniform2(-10f64..10.0), n in prop::array::uniform2(-1e3f64..1e3)) {
            let a = Matrix2::new(rates[0], rates[1], rates[2], rates[3]);
            let (x0, n) = (Vector2::from(x0), Vector2::from(n));
            let rate = a * x0 + n;
            let whole = x0 + Phi::new(a, h).constant(&rate);
            let part = Phi::new(a, 0.5 * h);
            let half = x0 + part.constant(&rate);
            let halves = half + part.constant(&(a * half + n));
            let scale = whole.norm() + x0.norm() + 1.0;
            prop_assert!((whole - halves).norm() <= 1e-10 * scale, "{whole} {halves}");
            prop_assert!((x0 + Phi::new(a, h).half(&rate) - half).norm() <= 1e-12 * scale);
        }
    }
}
