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

mod frozen;
mod square;
mod system;

pub use system::{Fast, Segment, System, Work};

use super::phi::{Forcing, Phi, product};
use super::{Cause, MOST_STEPS};
use crate::runtime::Saved;
use frozen::{Frozen, Matrices};
use nalgebra::{SMatrix, SVector, Vector2};
use square::Squares;
use std::ops::AddAssign;

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
/// Absolute tolerance of temperatures, K (times [`TOLERANCE`]).
const THERMAL_FLOOR: f64 = 1.0;
/// Absolute tolerance of heat, as temperature of the smallest node, K (times [`TOLERANCE`]).
const HEAT_FLOOR: f64 = 1.0;
/// Sensitivity of copper and magnets to temperature, 1/K: effect of a temperature error on the fast block.
const SENSITIVITY: f64 = 0.004;
/// Largest number of iterations between the two blocks.
const ROUNDS: usize = 4;
/// A step of at least this fraction of the rest takes the whole rest: the step size aims at half of the tolerance, so
/// the error is still acceptable. A rejected step is reduced by more than this factor.
const WHOLE: f64 = 0.8;
/// Most by which a step is longer than the one before; after a rejected step it is not longer.
const GROWTH: f64 = 4.0001;
/// Step sizes that differ by less than this fraction of the communication step are equal: some units of the last place.
const ROUNDING: f64 = 1e-14;
/// Temperature limit, K: above it the solution has diverged and the step is rejected.
const ABSURD: f64 = 1e5;
/// Smallest step as a fraction of the communication step; below it the step fails.
const LEAST_SHARE: f64 = 1e-9;

/// State between steps. `E` is the number of energies, at least three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize, const E: usize = 3> {
    /// Current, A, and speed, rad/s.
    pub x: Fast,
    /// Shaft angle, rad.
    pub angle: f64,
    /// Node temperatures, K.
    pub temperature: SVector<f64, N>,
    /// Energy input, energy at the shaft, and heat to ambient since the start, J; then, depending on
    /// `E`, the losses in the winding and by friction.
    pub energy: [f64; E],
    /// Integrals over the last call to [`Split::advance`], for states other than the nodes.
    pub integrals: StepIntegrals<N>,
}

impl<const N: usize, const E: usize> Default for State<N, E> {
    fn default() -> Self {
        State {
            x: Fast::zeros(),
            angle: 0.0,
            temperature: SVector::zeros(),
            energy: [0.0; E],
            integrals: StepIntegrals::default(),
        }
    }
}

/// Integrals over one call to [`Split::advance`]; the next call does not depend on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepIntegrals<const N: usize> {
    /// Integrals of current, A.s, and speed, rad.
    pub fast: Fast,
    /// Integrals of the node temperatures over time, K.s.
    pub temperature: SVector<f64, N>,
    /// Heat of the work outside the nodes, J ([`Work::aside`]).
    pub aside: f64,
    /// Heat flow out of the nodes, integrated, J.
    pub outflow: f64,
}

impl<const N: usize> Default for StepIntegrals<N> {
    fn default() -> Self {
        StepIntegrals { fast: Fast::zeros(), temperature: SVector::zeros(), aside: 0.0, outflow: 0.0 }
    }
}

impl<const N: usize> AddAssign for StepIntegrals<N> {
    fn add_assign(&mut self, before: Self) {
        self.fast += before.fast;
        self.temperature += before.temperature;
        self.aside += before.aside;
        self.outflow += before.outflow;
    }
}

impl<const N: usize, const E: usize> State<N, E> {
    /// The state as numbers, for a saved instance.
    pub fn to_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let fast = [self.x[0], self.x[1], self.angle];
        fast.into_iter().chain(self.temperature.iter().copied()).chain(self.energy)
    }
}

crate::saved!(State<const N: usize, const E: usize> { x, angle, temperature, energy });

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
    /// Factor on [`TOLERANCE`].
    ease: f64,
    /// Factor on all tolerances.
    scale: f64,
    /// Rejected steps since the integrator was created.
    pub rejected: u64,
    /// Step size for the next step, s.
    trial: f64,
}

impl<const N: usize> Default for Split<N> {
    /// No frozen blocks: the first step computes both.
    fn default() -> Self {
        let frozen = Frozen::of(Phi::none(), Phi::none());
        Split { frozen, ease: 1.0, scale: 1.0, rejected: 0, trial: f64::INFINITY }
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
        Some(Split { frozen, ease: 1.0, scale: 1.0, rejected: 0, trial })
    }

    /// The tolerances: [`TOLERANCE`] times `ease`, and those of stage and line error, at least as large; all times `scale`.
    fn tolerances(&self, bends: bool) -> [f64; 3] {
        let tolerance = TOLERANCE * self.ease;
        let [stage, line] =
            if bends { [TOLERANCE, STAGE_TOLERANCE] } else { [STAGE_TOLERANCE, LINE_TOLERANCE] };
        [tolerance, tolerance.max(stage), tolerance.max(line)].map(|tolerance| tolerance * self.scale)
    }

    /// Multiplies the tolerance by this factor; not part of the saved state.
    pub fn ease(&mut self, factor: f64) {
        self.ease = factor;
    }

    /// Multiplies all tolerances, including that of the frozen Jacobians, by a factor on their defaults; not part of the saved state.
    pub fn scale_tolerances(&mut self, factor: f64) {
        self.scale = factor;
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

    /// One step of length `h` from `t`: its error in units of the tolerance; an error above `most` leaves the state unchanged. Like
    /// [`iterate`](Self::iterate) not inlined: the loop around it hardly ever repeats, but the compiler would keep in memory all that is
    /// constant in it.
    #[inline(never)]
    fn step<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &mut State<N, E>,
        (t, h): (f64, f64),
        most: f64,
        backup: &mut Option<Matrices<N>>,
    ) -> f64 {
        let scale = self.ease * self.scale;
        let start = system.instant(t, &state.x, &state.temperature);
        let slope0 = system.fast_rates_at(t, &state.x, &state.temperature, &start);
        self.frozen.renew(system, (t, h), (&state.x, &slope0, &state.temperature), scale, backup);
        let mut guess = None;
        let mut left = ROUNDS;
        loop {
            left -= 1;
            match self.iterate(system, state, (t, h), (&start, &slope0), (guess, left > 0), most) {
                Ok(error) => return error,
                Err(better) => guess = Some(better),
            }
        }
    }

    /// One iteration between the blocks over a step, from guessed temperatures in the middle and at the end of the step; `Err` with
    /// better ones if they differ from the solution and `continues` allows.
    #[inline(never)]
    fn iterate<S: System<N>, const E: usize>(
        &self,
        system: &S,
        state: &mut State<N, E>,
        (t, h): (f64, f64),
        (start, slope0): (&S::Instant, &Fast),
        (guess, continues): (Option<[SVector<f64, N>; 2]>, bool),
        most: f64,
    ) -> Result<f64, [SVector<f64, N>; 2]> {
        let (x0, temp0) = (state.x, state.temperature);
        let Frozen { fast, squares, thermal } = &self.frozen;
        let (a, m) = (fast.matrix(), thermal.matrix());
        let (capacity, per_joule) = (system.capacity(), system.inverse_capacity());

        let [tolerance, stage_tolerance, line_tolerance] = self.tolerances(system.bends_where_stiff());
        let (middle, until) = (t + 0.5 * h, t + h);
        let slope0 = *slope0;
        let (network0, _) = system.network(t, &temp0);
        let heat0 = system.heat_rates_at(t, &x0, &temp0, start);
        let rate0 = network0 + heat0.component_mul(per_joule);
        let xa = fast.half(&x0, &slope0);
        let mut tempm = temp0 + rate0 * (0.5 * h);
        let mut stage = system.instant(middle, &xa, &tempm);
        // Initial guess: temperatures at the end from the heat of the first stage, by which most of a fast transient has decayed.
        let rate = network0 + system.heat_rates_at(middle, &xa, &tempm, &stage).component_mul(per_joule);
        let mut temp1 = temp0 + rate * h;
        if let Some(guess) = guess {
            [tempm, temp1] = guess;
            stage = system.instant(middle, &xa, &tempm);
        }
        // What N adds to N_0 at the stages.
        let na = system.fast_rates_at(middle, &xa, &tempm, &stage) - slope0 - product(a, &(xa - x0));
        let xb = fast.constant(&x0, &(slope0 + na * 2.0));
        let slopeb = system.fast_rates(until, &xb, &temp1);
        let nb = slopeb - slope0 - product(a, &(xb - x0));
        let forcing = Forcing::through(na, nb);
        let (x1, xm) = (fast.end(&x0, &slope0, &forcing), fast.middle(&x0, &slope0, &forcing));
        let x = [x0, xm, x1];
        let (integral, moment) = (fast.integral(&x0, &slope0, &forcing), fast.moment(&x0, &slope0, &forcing));
        let (second, n0) = (fast.second(&x0, &slope0, &forcing), slope0 - product(a, &x0));
        let (square, error_of_square) =
            squares.integral(h, &x, [&integral, &moment, &second], (&n0, &forcing));
        let segment = Segment {
            t,
            h,
            x,
            square,
            error_of_square,
            integral,
            moment,
            temperature: [temp0, tempm, temp1],
        };
        let instants = [*start, system.instant(middle, &xm, &tempm), system.instant(until, &x1, &temp1)];
        let work = system.work(&segment, &instants);

        // Heat flow with exactly the integral of the step: Simpson's rule solved for the middle value.
        let heat1 = system.heat_rates_at(until, &x1, &temp1, &instants[2]);
        let heatm = (work.heat * (6.0 / h) - heat0 - heat1) * 0.25;
        let share = -m.tr_mul(capacity);
        let beyond = |t: f64, temperature: &SVector<f64, N>, heat: SVector<f64, N>| {
            let (rates, outflow) = system.network_remainder(t, temperature, m, &share);
            (rates + heat.component_mul(per_joule), outflow)
        };
        let (warming0, outflow0) = beyond(t, &temp0, heat0);
        let (warmingm, outflowm) = beyond(middle, &tempm, heatm);
        let (warming1, outflow1) = beyond(until, &temp1, heat1);
        let warming = Forcing::through(warmingm - warming0, warming1 - warming0);
        let (half, end) = (thermal.middle(&temp0, &rate0, &warming), thermal.end(&temp0, &rate0, &warming));
        let coupling_error = largest(&(end - temp1)).max(largest(&(half - tempm)));
        let settled = SENSITIVITY * coupling_error <= 0.3 * stage_tolerance;
        if continues && !settled {
            return Err([half, end]);
        }

        let size = x0.abs().sup(&x1.abs()).sup(&FAST_FLOOR);
        let line_error = largest(&fast.curvature_error(&forcing).component_div(&size));
        // In a stiff block the end state depends only on the remainder at the end, which is equal for parabola and line;
        // the error estimate is the difference of the remainders at the end and at the last stage.
        let stage_error =
            system.fast_rates_at(until, &x1, &temp1, &instants[2]) - slopeb - product(a, &(x1 - xb));
        let stage_error = fast.last_stage_error(&stage_error);
        let stage_error = largest(&stage_error.component_div(&size));
        // The integral of the heat is exact; its shape within the step only matters as far as the node relaxes over the step.
        let thermal_error = largest(&product(m, &thermal.curvature_error(&warming))) * h / THERMAL_FLOOR;
        // The heat of a transient that decays early is not a parabola, and is released before the middle.
        let shape_error = system.heat_rates_at(middle, &xm, &tempm, &instants[1]) - heatm;
        let shape_error = largest(&shape_error.component_mul(per_joule)) * h;
        let heat_error = work.quadrature_error * largest(per_joule) / HEAT_FLOOR;
        let of_heat = thermal_error + heat_error + SENSITIVITY * shape_error;
        let error = line_error / line_tolerance
            + (stage_error + SENSITIVITY * coupling_error) / stage_tolerance
            + of_heat / tolerance;
        // Heat to ambient: the linear part of the frozen network from the exact integral, the rest by Simpson's rule.
        let over_time = thermal.integral(&temp0, &rate0, &warming);
        let outflow = share.dot(&over_time) + h / 6.0 * (outflow0 + 4.0 * outflowm + outflow1);
        let gained = [work.electrical, work.mechanical, outflow + work.ambient];
        let angle = state.angle + segment.integral[1];
        let finite = x1.sum() + end.sum() + angle;
        let sane = finite.is_finite() && largest(&end) < ABSURD && !error.is_nan();
        let error = if sane { error } else { f64::INFINITY };
        if error <= most {
            (state.x, state.angle, state.temperature) = (x1, angle, end);
            for (sum, gain) in state.energy.iter_mut().zip(gained.iter().chain(&work.losses)) {
                *sum += gain;
            }
            state.integrals +=
                StepIntegrals { fast: segment.integral, temperature: over_time, aside: work.aside, outflow };
        }
        Ok(error)
    }
}

/// Factor on the length of a step that was rejected with this error. It aims lower than after an accepted step: far above the tolerance the
/// error increases less than with the cube of the length, so that a cube root shortens the step too little.
fn shrink(error: f64) -> f64 {
    if error.is_finite() { (0.7 / error.cbrt()).clamp(0.1, 0.7) } else { 0.1 }
}

/// The largest absolute value. NaN is not detected: it appears in the new state as well.
#[inline(always)]
fn largest<const N: usize>(values: &SVector<f64, N>) -> f64 {
    values.iter().fold(0.0, |most, value| if most > value.abs() { most } else { value.abs() })
}
