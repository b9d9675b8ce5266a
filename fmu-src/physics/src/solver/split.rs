//! The default integrator: two exponential blocks, fast (current, speed) and thermal, coupled in each step.
//!
//! Each block is x' = A x + N(t, x): A is the block's Jacobian, frozen while it is accurate enough, and N is the *whole* remainder, so
//! that an outdated A affects only the error estimate, not the equations. N is approximated by a parabola through three stages (ETD3RK);
//! a linear system with linear inputs is solved exactly.
//!
//! ```text
//! N_0 = N(0, x0)     x_a = x(h/2; N_0)     N_a = N(h/2, x_a)     x_b = x(h; 2 N_a - N_0)
//! x1  = x(h; parabola through N_0, N_a, N(h, x_b))                                         (1)
//! ```
//!
//! Heat: the system computes the heat of the step from the *integrals* of the fast solution, including that of i^2
//! ([`System::work`]), so a current transient that decays within the step heats the winding by its actual loss. The heat flow of the
//! thermal block has exactly this integral. The blocks are solved in turn until the temperatures at the end of the step converge.
//!
//! *Error control*: the estimate of a step's error is the sum of
//! - the line error: parabola compared with straight line (error of the next lower order), in both blocks;
//! - the stage error: the fast block's remainder at x1 compared with that at x_b, the only valid estimate for a stiff block;
//! - the coupling error: change of the temperatures since the fast block used them;
//! - the heat error: heat in the middle of the step compared with its parabola, quadrature, and the step's energy balance residual.
//!
//! A step with too large an error is rejected and repeated with a smaller step size. The last step ends at the communication point;
//! the next communication step starts with the next step size of this one.
//! *Source*: Cox, Matthews, J. Comput. Phys. 176 (2002) eq. (23)-(25); Hochbruck, Ostermann, Acta Numerica 19 (2010).

mod capacity;
mod frozen;
mod square;
mod state;
mod step;
mod system;

pub use capacity::HeatCapacities;
pub use state::{State, StepIntegrals, middle_of};
pub use system::{Fast, Segment, System, Work};

use super::phi::Phi;
use super::{Cause, MOST_STEPS};
use crate::runtime::Saved;
use frozen::{Frozen, Matrices};
use nalgebra::{SMatrix, Vector2};
use square::Squares;

/// Relative tolerance of one step on the error of temperatures and energies, and on the stage error where
/// rates are nonlinear within a stiff step ([`System::bends_where_stiff`]).
const TOLERANCE: f64 = 1e-7;
/// Relative tolerance of one step on the stage error elsewhere, an estimate of the method's own order, on the effect of the coupling
/// error on the fast block, and on its line error where rates are nonlinear within a stiff step.
const STAGE_TOLERANCE: f64 = 1e-6;
/// Relative tolerance of one step on the fast block's line error elsewhere: an estimate of order three for a step of order five, as
/// long as the Jacobian is that of the step's start (tests/limits.rs). With all three tolerances, a minute of walking at a
/// communication step of 1 ms keeps current, speed and angle to 2e-7 of their size; more in tests/accuracy.rs.
const LINE_TOLERANCE: f64 = 3e-5;
/// Sizes below which the error is absolute: 1 A, 10 rad/s.
const FAST_FLOOR: Fast = Vector2::new(1.0, 10.0);
/// A step of at least this fraction of the rest takes the whole rest: the step size aims at half of the tolerance, so
/// the error is still acceptable. A rejected step is reduced by more than this factor.
const WHOLE: f64 = 0.8;
/// Most by which a step is longer than the one before; after a rejected step it is not longer.
const GROWTH: f64 = 4.0001;
/// Step sizes that differ by less than this fraction of the communication step are equal: some units of the last place.
const ROUNDING: f64 = 1e-14;
/// Smallest step as a fraction of the communication step; below it the step fails.
const LEAST_SHARE: f64 = 1e-9;

/// Step failure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepFailure {
    /// Time from the start of the communication step, s.
    pub t: f64,
    /// Step size at the failure, s.
    pub h: f64,
    /// Its cause.
    pub cause: Cause,
}

/// The integrator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split<const N: usize> {
    frozen: Frozen<N>,
    /// Factors on [`TOLERANCE`]: of heat, and of stage and line error.
    ease: [f64; 2],
    /// Factor on all tolerances.
    scale: f64,
    /// Reciprocals of the tolerances, without and with [`System::bends_where_stiff`]: of heat, stage and line error.
    per_tolerance: [[f64; 3]; 2],
    /// Rejected steps since the integrator was created.
    pub rejected: u64,
    /// Step size for the next step, s.
    trial: f64,
}

impl<const N: usize> Default for Split<N> {
    /// No frozen blocks: the first step computes both.
    fn default() -> Self {
        Self::with(Frozen::of(Phi::none(), Phi::none()), f64::INFINITY)
    }
}

impl<const N: usize> Saved for Split<N> {
    fn save(&self, out: &mut Vec<f64>) {
        out.extend(self.to_numbers());
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        *self = Self::from_numbers(next)?;
        Some(())
    }
}

impl<const N: usize> Split<N> {
    /// Saved data of the integrator for a bit-identical continuation: matrix and step size of both
    /// frozen blocks, which determine the phi functions, and the next step size.
    pub fn to_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let Frozen { fast, thermal, .. } = &self.frozen;
        let fast = fast.matrix().iter().copied().chain([fast.step()]);
        fast.chain(thermal.matrix().iter().copied()).chain([thermal.step(), self.trial])
    }

    /// The integrator from these numbers, `None` if there are too few or the step size is invalid.
    pub fn from_numbers(next: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        fn block<const M: usize>(next: &mut impl FnMut() -> Option<f64>) -> Option<Phi<M>> {
            let mut matrix = SMatrix::<f64, M, M>::zeros();
            for number in matrix.iter_mut() {
                *number = next()?;
            }
            Some(Phi::new(matrix, next()?))
        }
        let frozen = Frozen::of(block(next)?, block(next)?);
        let trial = next().filter(|step| *step > 0.0)?;
        Some(Self::with(frozen, trial))
    }

    /// An integrator with the default tolerances.
    fn with(frozen: Frozen<N>, trial: f64) -> Self {
        let split =
            Split { frozen, ease: [1.0; 2], scale: 1.0, per_tolerance: [[0.0; 3]; 2], rejected: 0, trial };
        split.with_tolerances()
    }

    /// The same with the tolerances: [`TOLERANCE`] times `ease`, where it is larger than the tolerance of stage or line error; all times
    /// `scale`.
    fn with_tolerances(mut self) -> Self {
        let [heat, fast] = self.ease.map(|ease| TOLERANCE * ease);
        let limits = [[STAGE_TOLERANCE, LINE_TOLERANCE], [TOLERANCE, STAGE_TOLERANCE]];
        self.per_tolerance = limits.map(|[stage, line]| {
            [heat, fast.max(stage), fast.max(line)].map(|tolerance| 1.0 / (tolerance * self.scale))
        });
        self
    }

    /// Multiplies the tolerances of heat, and of current and speed, by these factors; not part of the saved state.
    pub fn ease(&mut self, factors: [f64; 2]) {
        *self = Split { ease: factors, ..*self }.with_tolerances();
    }

    /// Multiplies all tolerances, including that of the frozen Jacobians, by a factor on their defaults; not part of the saved state.
    pub fn scale_tolerances(&mut self, factor: f64) {
        *self = Split { scale: factor, ..*self }.with_tolerances();
    }

    /// Advances `state` by `h` seconds, in as many steps as the error control needs; on failure the integrator is unchanged and
    /// `state` is undefined.
    pub fn advance<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &mut State<N, E>,
        h: f64,
    ) -> Result<(), StepFailure> {
        state.integrals = StepIntegrals::default();
        let (mut backup, mut whole, mut trial) = (None, None, self.trial);
        if trial >= WHOLE * h {
            let error = self.step(system, state, (0.0, h), 1.0, &mut backup);
            if error <= 1.0 {
                self.trial = f64::INFINITY;
                return Ok(());
            }
            self.rejected += 1;
            trial = h * shrink(error);
            whole = Some(self.frozen);
        }
        match self.advance_in_parts(system, state, (h, trial), &mut backup) {
            Ok(next) => {
                self.trial = next;
                if let Some(whole) = whole.filter(|_| next >= WHOLE * h) {
                    // The next communication step probably has this size again.
                    self.frozen = whole;
                }
                Ok(())
            }
            Err(failure) => {
                if let Some(backup) = backup {
                    self.frozen = Frozen::with(backup);
                }
                Err(failure)
            }
        }
    }

    /// [`advance`](Self::advance) from a step size `trial` below `h`; returns the next step size. Equal steps take the rest of `h`, so that
    /// one evaluation of the phi functions serves them all.
    #[inline(never)]
    fn advance_in_parts<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &mut State<N, E>,
        (h, mut trial): (f64, f64),
        backup: &mut Option<Matrices<N>>,
    ) -> Result<f64, StepFailure> {
        let (mut done, mut try_h) = (0.0, h);
        let mut growth = GROWTH;
        for _ in 0..MOST_STEPS {
            let rest = h - done;
            let is_last = trial >= WHOLE * rest;
            try_h = if is_last { rest } else { rest / (rest / trial).ceil() };
            // Equal steps differ by rounding.
            let known = self.frozen.fast.step();
            if (try_h - known).abs() <= ROUNDING * h {
                try_h = known;
            }
            let error = self.step(system, state, (done, try_h), 1.0, backup);
            if error <= 1.0 {
                // Third-order error: the next step size follows from the cube root of the error.
                trial = try_h * (0.8 / error.cbrt()).clamp(0.3, growth);
                growth = GROWTH;
                if is_last {
                    return Ok(trial);
                }
                done += try_h;
            } else if try_h > LEAST_SHARE * h {
                self.rejected += 1;
                growth = 1.0;
                trial = try_h * shrink(error);
            } else {
                let cause = if error.is_finite() { Cause::Inaccurate } else { Cause::NotFinite };
                return Err(StepFailure { t: done, h: try_h, cause });
            }
        }
        Err(StepFailure { t: done, h: try_h, cause: Cause::Steps })
    }

    /// One step without error control, to study the order of the method.
    pub fn single_step<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &State<N, E>,
        h: f64,
    ) -> State<N, E> {
        let mut next = *state;
        self.step(system, &mut next, (0.0, h), f64::INFINITY, &mut None);
        next
    }
}

/// Factor on the length of a step that was rejected with this error. It aims lower than after an accepted step: far above the tolerance the
/// error increases less than with the cube of the length, so that a cube root shortens the step too little.
fn shrink(error: f64) -> f64 {
    if error.is_finite() { (0.7 / error.cbrt()).clamp(0.1, 0.7) } else { 0.1 }
}

/// The largest absolute value. NaN is not detected: it appears in the new state as well.
#[inline(always)]
fn largest<const R: usize, const C: usize>(values: &SMatrix<f64, R, C>) -> f64 {
    values.iter().fold(0.0, |most, value| if most > value.abs() { most } else { value.abs() })
}
