//! The frozen Jacobians of both blocks, and when they are updated.

use super::system::{Fast, System};
use super::{FAST_FLOOR, Squares, TOLERANCE, largest};
use crate::solver::phi::{Phi, product};
use nalgebra::{Matrix2, SMatrix, SVector};

/// The frozen Jacobian of a nonlinear network is updated if its relative error exceeds this value.
const STALE: f64 = 3e-6;
/// Upper limit for the fast block. Where current and speed follow slow changes, their derivatives at the end of a step of 100 time constants
/// have 100 times this error.
const STALE_FAST: f64 = 3e-5;
/// Upper limit of both with eased tolerances.
const STALE_AT_MOST: f64 = 1e-3;

/// Frozen Jacobians of both blocks, with their phi functions for one step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frozen<const N: usize> {
    pub fast: Phi<2>,
    pub squares: Squares,
    pub thermal: Phi<N>,
    /// Reciprocals of |a| + 1/h for the elements of both Jacobians, s.
    per_size: (Matrix2<f64>, SMatrix<f64, N, N>),
}

/// Matrix, 1/s, and step, s, of both blocks, from which all of their phi functions follow.
pub(super) type Matrices<const N: usize> = (Matrix2<f64>, f64, SMatrix<f64, N, N>, f64);

impl<const N: usize> Frozen<N> {
    pub fn of(fast: Phi<2>, thermal: Phi<N>) -> Self {
        Frozen {
            fast,
            squares: Squares::of(fast.matrix()),
            thermal,
            per_size: (per_size(&fast), per_size(&thermal)),
        }
    }

    /// The blocks with these matrices.
    #[cold]
    pub fn with((a, fast, m, thermal): Matrices<N>) -> Self {
        Self::of(Phi::new(a, fast), Phi::new(m, thermal))
    }

    fn matrices(&self) -> Matrices<N> {
        let Frozen { fast, thermal, .. } = self;
        (*fast.matrix(), fast.step(), *thermal.matrix(), thermal.step())
    }

    /// Updates the blocks if they are outdated for a step of length `h` from `t`; `scale` is the factor on the tolerances, and `backup`
    /// keeps the matrices before the first update.
    #[inline(always)]
    pub fn renew<S: System<N>>(
        &mut self,
        system: &S,
        (t, h): (f64, f64),
        (x, slope, temperature, instant): (&Fast, &Fast, &SVector<f64, N>, &S::Instant),
        scale: f64,
        backup: &mut Option<Matrices<N>>,
    ) {
        let a = system.fast_matrix_at(t, x, temperature, instant);
        let m = system.network_matrix(t, temperature);
        let is_fast_fresh =
            self.fast.step() == h && self.suffices(&(a - self.fast.matrix()), (x, slope), scale);
        let is_thermal_fresh = self.thermal.step() == h
            && if S::IS_NETWORK_LINEAR {
                // The remainder of a linear network is exact only with its own matrix.
                *self.thermal.matrix() == m
            } else {
                let error = relative_error(&(m - self.thermal.matrix()), &self.per_size.1);
                error <= (scale * STALE).min(STALE_AT_MOST)
            };
        if !(is_fast_fresh && is_thermal_fresh) {
            backup.get_or_insert_with(|| self.matrices());
            self.update((!is_fast_fresh).then_some(&a), (!is_thermal_fresh).then_some(&m), h);
        }
    }

    /// New matrices. Not inlined: most steps have fresh ones.
    #[inline(never)]
    fn update(&mut self, fast: Option<&Matrix2<f64>>, thermal: Option<&SMatrix<f64, N, N>>, h: f64) {
        if let Some(a) = fast {
            self.fast = Phi::new(*a, h);
            self.squares = Squares::of(a);
            self.per_size.0 = per_size(&self.fast);
        }
        if let Some(m) = thermal {
            self.thermal = Phi::new(*m, h);
            self.per_size.1 = per_size(&self.thermal);
        }
    }

    /// Whether the Jacobian of the fast block, outdated by this matrix, is accurate enough for a step that begins with this derivative: what
    /// it leaves in the remainder follows the change of current and speed, and its line error, without any cancellation between the stages,
    /// has to be below [`TOLERANCE`].
    #[inline(always)]
    fn suffices(&self, outdated: &Matrix2<f64>, (x, slope): (&Fast, &Fast), scale: f64) -> bool {
        let error = relative_error(outdated, &self.per_size.0);
        let left = |change: Fast| product(outdated, &change).abs();
        let bend = left(self.fast.half(slope)) * 4.0 + left(self.fast.constant(slope)) * 2.0;
        let (line_error, size) = (self.fast.curvature_bound(&bend), x.abs().sup(&FAST_FLOOR));
        let is_small = |k: usize| line_error[k] <= scale * TOLERANCE * size[k];
        error <= (scale * STALE_FAST).min(STALE_AT_MOST) && is_small(0) && is_small(1)
    }
}

/// Reciprocals of |a| + 1/h for the elements of a Jacobian, s.
fn per_size<const N: usize>(phi: &Phi<N>) -> SMatrix<f64, N, N> {
    phi.matrix().map(|a| 1.0 / (a.abs() + 1.0 / phi.step()))
}

/// Relative error of a frozen matrix that differs by `outdated` from its present value: the largest error of an element divided by |a| + 1/h.
/// Times the step it changes the solution by less than this fraction of the matrix's own effect.
#[inline(always)]
fn relative_error<const N: usize>(outdated: &SMatrix<f64, N, N>, per_size: &SMatrix<f64, N, N>) -> f64 {
    largest(&outdated.component_mul(per_size))
}
