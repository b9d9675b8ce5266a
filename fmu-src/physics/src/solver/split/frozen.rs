//! The frozen Jacobians of both blocks, and when they are updated.

use super::system::{Fast, System};
use super::{FAST_FLOOR, Squares, TOLERANCE, largest};
use crate::solver::phi::Phi;
use nalgebra::{Matrix2, SMatrix, SVector};

/// A frozen Jacobian is updated if its relative error exceeds this value: a larger error reduces the order of the step; in a motor
/// that warms by 15 K/s it would be the dominant error.
const STALE: f64 = 3e-6;
/// Upper limit in a step in which current and speed hardly change. Where they follow slow changes, their derivatives at the end of a step of
/// 100 time constants have 100 times this error.
const STALE_AT_REST: f64 = 3e-5;
/// Upper limit of both with eased tolerances.
const STALE_AT_MOST: f64 = 1e-3;

/// Frozen Jacobians of both blocks, with their phi functions for one step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frozen<const N: usize> {
    pub fast: Phi<2>,
    pub squares: Squares,
    pub thermal: Phi<N>,
}

/// Matrix, 1/s, and step, s, of both blocks, from which all of their phi functions follow.
pub(super) type Matrices<const N: usize> = (Matrix2<f64>, f64, SMatrix<f64, N, N>, f64);

impl<const N: usize> Frozen<N> {
    pub fn of(fast: Phi<2>, thermal: Phi<N>) -> Self {
        Frozen { fast, squares: Squares::of(fast.matrix()), thermal }
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
    pub fn renew<S: System<N>>(
        &mut self,
        system: &S,
        (t, h): (f64, f64),
        (x, slope, temperature): (&Fast, &Fast, &SVector<f64, N>),
        scale: f64,
        backup: &mut Option<Matrices<N>>,
    ) {
        let (a, m) = (system.fast_matrix(t, x, temperature), system.network_matrix(t, temperature));
        let stale = (STALE * scale).min(STALE_AT_MOST);
        let is_fast_fresh = self.fast.step() == h
            && (fresh(self.fast.matrix(), &a, h, stale) || self.suffices(h, (x, slope), (&a, scale)));
        // The remainder of a linear network is exact only with its own matrix.
        let stale = if S::IS_NETWORK_LINEAR { 0.0 } else { stale };
        let is_thermal_fresh = self.thermal.step() == h && fresh(self.thermal.matrix(), &m, h, stale);
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
        }
        if let Some(m) = thermal {
            self.thermal = Phi::new(*m, h);
        }
    }

    /// Whether an outdated Jacobian of the fast block is accurate enough for a step in which current and speed hardly change: its error acts
    /// on their changes only, so that the product of both, relative to the size, has to be below [`TOLERANCE`].
    #[inline]
    fn suffices(&self, h: f64, (x, slope): (&Fast, &Fast), (now, scale): (&Matrix2<f64>, f64)) -> bool {
        let change = self.fast.constant(&Fast::zeros(), slope);
        let change = largest(&change.component_div(&x.abs().sup(&FAST_FLOOR)));
        let stale = (scale * (TOLERANCE / change).min(STALE_AT_REST)).min(STALE_AT_MOST);
        fresh(self.fast.matrix(), now, h, stale)
    }
}

/// Whether a frozen matrix is still accurate: its error times the step changes the solution by less than the fraction
/// `stale` of the matrix's own effect.
#[inline]
fn fresh<const N: usize>(frozen: &SMatrix<f64, N, N>, now: &SMatrix<f64, N, N>, h: f64, stale: f64) -> bool {
    let slack = stale / h;
    // Without branches, two elements at a time.
    frozen.iter().zip(now.iter()).fold(true, |all, (f, n)| all & ((f - n).abs() <= stale * f.abs() + slack))
}
