//! The production integrator: two exponential blocks, fast (current, speed) and thermal, coupled in each step.
//!
//! Each block is x' = A x + N(t, x): A is the block's Jacobian, kept frozen while it is nearly right, and N is
//! the *whole* remainder, so that a stale A costs accuracy in the error estimate and never in the equations.
//! N is followed by a parabola through three stages (ETD3RK); a linear system with input ramps is exact.
//!
//! ```text
//! N_0 = N(0, x0)     x_a = x(h/2; N_0)     N_a = N(h/2, x_a)     x_b = x(h; 2 N_a - N_0)
//! x1  = x(h; parabola through N_0, N_a, N(h, x_b))                                         (1)
//! ```
//!
//! Heat: the system turns the *integrals* of the fast solution, that of i^2 included, into the heat of the step
//! ([`System::work`]), so a current transient that dies within the step heats the winding by its actual loss. The thermal block then takes a heat flow with that very integral.
//! The blocks are solved in turn until the temperatures at the end of the step stand still.
//!
//! *Error control*: the estimate of a step's error is the sum of
//! - the line error: parabola against line (the error of the order below), in both blocks;
//! - the stage error: the fast block's remainder at x1 against that at x_b, the only estimate that serves a stiff block;
//! - the coupling error: change of the temperatures since the fast block used them;
//! - the heat error: heat in the middle of the step against its parabola, quadratures, and the balance of the step's energies.
//!
//! A step with too large an error is rejected and cut. The communication step is always met, and the next call begins with
//! the step that this one would have continued with.
//! *Source*: Cox, Matthews, J. Comput. Phys. 176 (2002) eq. (23)-(25); Hochbruck, Ostermann, Acta Numerica 19 (2010).

mod square;
mod system;

pub use system::{Fast, Segment, System, Work};

use super::phi::{Forcing, Phi, product};
use crate::runtime::Saved;
use nalgebra::{Matrix2, SMatrix, SVector, Vector2};
use square::Squares;

/// Relative tolerance of one step on the error of temperatures and energies, and on the fast block's last stage where
/// rates bend within a stiff step ([`System::bends_where_stiff`]).
const TOLERANCE: f64 = 1e-7;
/// Relative tolerance of one step on the fast block's last stage elsewhere, an estimate of the method's own order, and on what
/// temperatures that are not yet settled do to it; and on its parabola against the line where rates bend.
const STAGE_TOLERANCE: f64 = 1e-6;
/// Relative tolerance of one step on the fast block's parabola against the line elsewhere: an error of order three beside a
/// step whose own is of order five while the Jacobian is that of its start (tests/limits.rs). With all three, a minute of
/// walking at a millisecond keeps current, speed and angle to 2e-7 of their size; tests/accuracy.rs has the rest.
const LINE_TOLERANCE: f64 = 3e-5;
/// Sizes below which an error no longer counts as relative: 1 A, 10 rad/s.
const FAST_FLOOR: Fast = Vector2::new(1.0, 10.0);
/// A temperature error below this is none, K (times [`TOLERANCE`]).
const THERMAL_FLOOR: f64 = 1.0;
/// Heat that moves the smallest node by less than this is nothing, K (times [`TOLERANCE`]).
const HEAT_FLOOR: f64 = 1.0;
/// How strongly copper and magnets answer to temperature, 1/K: what a temperature error does to the fast block.
const SENSITIVITY: f64 = 0.004;
/// A frozen Jacobian is renewed when it is off by this share: one that is off by more costs the step its order, and a motor
/// that warms by 15 K/s more than all else that it errs.
const STALE: f64 = 3e-6;
/// The same while the tolerance is eased, at most.
const STALE_AT_MOST: f64 = 1e-3;
/// Rounds in which the two blocks may agree.
const ROUNDS: usize = 4;
/// A step that would be this share of what is left takes all of it: as it aims at half of the error that is allowed, that
/// still serves. A step that is refused is cut to less.
const WHOLE: f64 = 0.8;
/// No motor is this hot, K: a solution that comes here has run away, and there is no use in following it.
const ABSURD: f64 = 1e5;
/// A step cut below this share of the caller's step is a failure, not an accuracy.
const LEAST_SHARE: f64 = 1e-9;

/// What the integrator carries from step to step. `E` is how many energies are counted, at least three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<const N: usize, const E: usize = 3> {
    /// Current, A, and speed, rad/s.
    pub x: Fast,
    /// Shaft angle, rad.
    pub angle: f64,
    /// Node temperatures, K.
    pub temperature: SVector<f64, N>,
    /// Energy taken in, delivered at the shaft, and given to ambient since the start, J; then, as far as
    /// `E` reaches, the losses in the winding and by friction.
    pub energy: [f64; E],
    /// Integrals over the last call to [`Split::advance`], for states beside the nodes.
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

/// Integrals over one call to [`Split::advance`]; no part of what the next one depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepIntegrals<const N: usize> {
    /// Integrals of the node temperatures over time, K.s.
    pub temperature: SVector<f64, N>,
    /// Heat of the work that no node took, J ([`Work::aside`]).
    pub aside: f64,
    /// Heat that left the nodes, J.
    pub outflow: f64,
}

impl<const N: usize> Default for StepIntegrals<N> {
    fn default() -> Self {
        StepIntegrals { temperature: SVector::zeros(), aside: 0.0, outflow: 0.0 }
    }
}

impl<const N: usize, const E: usize> State<N, E> {
    /// The state as numbers, for a saved instance.
    pub fn to_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let fast = [self.x[0], self.x[1], self.angle];
        fast.into_iter().chain(self.temperature.iter().copied()).chain(self.energy)
    }

    /// The state of as many numbers, `None` where they run out.
    pub fn from_numbers(next: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        let x = Fast::new(next()?, next()?);
        let angle = next()?;
        let mut temperature = SVector::<f64, N>::zeros();
        for node in temperature.iter_mut() {
            *node = next()?;
        }
        let mut energy = [0.0; E];
        for joules in &mut energy {
            *joules = next()?;
        }
        Some(State { x, angle, temperature, energy, integrals: StepIntegrals::default() })
    }
}

impl<const N: usize, const E: usize> Saved for State<N, E> {
    fn save(&self, out: &mut Vec<f64>) {
        out.extend(self.to_numbers());
    }

    fn load(&mut self, next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        *self = Self::from_numbers(next)?;
        Some(())
    }
}

/// Why a step could not be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepFailure {
    /// Where in the caller's step, s.
    pub t: f64,
    /// The step that was still too long, s.
    pub h: f64,
}

/// Matrix, 1/s, and step, s, of the fast block and of the thermal one, from which all of their phi functions follow.
type Frozen<const N: usize> = (Matrix2<f64>, f64, SMatrix<f64, N, N>, f64);

/// The integrator: frozen Jacobians with their phi functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split<const N: usize> {
    fast: Phi<2>,
    squares: Squares,
    thermal: Phi<N>,
    /// The tolerance over [`TOLERANCE`].
    ease: f64,
    /// Factor on all tolerances.
    scale: f64,
    /// Steps that were rejected since the integrator was made.
    pub rejected: u64,
    /// The step that the last call would have gone on with, s.
    trial: f64,
}

impl<const N: usize> Default for Split<N> {
    /// Frozen for no step at all: the first step renews both blocks.
    fn default() -> Self {
        let (fast, thermal) = (Phi::new(Matrix2::zeros(), 0.0), Phi::new(SMatrix::zeros(), 0.0));
        let squares = Squares::of(&fast);
        Split { fast, squares, thermal, ease: 1.0, scale: 1.0, rejected: 0, trial: f64::INFINITY }
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
    /// What a saved instance must hold beside its state so that it goes on bit for bit: matrix and step of both
    /// frozen blocks, from which the phi functions follow, and the step to begin with.
    pub fn to_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let (fast, thermal) = (&self.fast, &self.thermal);
        let fast = fast.matrix().iter().copied().chain([fast.step()]);
        fast.chain(thermal.matrix().iter().copied()).chain([thermal.step(), self.trial])
    }

    /// The integrator of as many numbers, `None` where they run out or the step is none.
    pub fn from_numbers(next: &mut impl FnMut() -> Option<f64>) -> Option<Self> {
        fn block<const M: usize>(next: &mut impl FnMut() -> Option<f64>) -> Option<Phi<M>> {
            let mut matrix = SMatrix::<f64, M, M>::zeros();
            for number in matrix.iter_mut() {
                *number = next()?;
            }
            Some(Phi::new(matrix, next()?))
        }
        let (fast, thermal) = (block(next)?, block(next)?);
        let trial = next().filter(|step| *step > 0.0)?;
        let squares = Squares::of(&fast);
        Some(Split { fast, squares, thermal, ease: 1.0, scale: 1.0, rejected: 0, trial })
    }

    /// [`TOLERANCE`], [`STAGE_TOLERANCE`] and [`LINE_TOLERANCE`] as they are eased: one, where that is wider than all.
    fn tolerances(&self, bends: bool) -> [f64; 3] {
        let tolerance = TOLERANCE * self.ease;
        let [stage, line] =
            if bends { [TOLERANCE, STAGE_TOLERANCE] } else { [STAGE_TOLERANCE, LINE_TOLERANCE] };
        [tolerance, tolerance.max(stage), tolerance.max(line)].map(|tolerance| tolerance * self.scale)
    }

    fn stale(&self) -> f64 {
        (STALE * self.ease * self.scale).min(STALE_AT_MOST)
    }

    /// Lets the steps err by this factor more than they do by default; it is no part of what is saved.
    pub fn ease(&mut self, factor: f64) {
        self.ease = factor;
    }

    /// Multiplies all tolerances, the renewal of the Jacobians included, by a factor on their defaults; it is no part of what is saved.
    pub fn scale_tolerances(&mut self, factor: f64) {
        self.scale = factor;
    }

    /// Advances `state` by `h` seconds, in as many steps as the error asks for; on failure nothing changes.
    pub fn advance<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &mut State<N, E>,
        h: f64,
    ) -> Result<(), StepFailure> {
        let (mut now, mut done, mut trial) = (*state, 0.0, self.trial.min(h));
        now.integrals = StepIntegrals::default();
        let mut backup = None;
        loop {
            let rest = h - done;
            let try_h = if trial >= rest * WHOLE { rest } else { trial.min(0.5 * rest) };
            let (next, error) = self.step(system, &now, done, try_h, &mut backup);
            if error <= 1.0 {
                now = next;
                if try_h == h {
                    self.trial = f64::INFINITY;
                    break;
                }
                // Third order: the next step may grow by the cube root of what is to spare.
                trial = try_h * (0.8 / error.cbrt()).clamp(0.3, 4.0);
                if try_h == rest {
                    self.trial = trial;
                    break;
                }
                done += try_h;
            } else if try_h > LEAST_SHARE * h {
                self.rejected += 1;
                trial = try_h * if error.is_finite() { (0.8 / error.cbrt()).clamp(0.1, 0.7) } else { 0.1 };
            } else {
                if let Some((a, fast, m, thermal)) = backup {
                    (self.fast, self.thermal) = (Phi::new(a, fast), Phi::new(m, thermal));
                    self.squares = Squares::of(&self.fast);
                }
                return Err(StepFailure { t: done, h: try_h });
            }
        }
        *state = now;
        Ok(())
    }

    /// One step without error control, for studies of the method's order.
    pub fn single_step<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &State<N, E>,
        h: f64,
    ) -> State<N, E> {
        self.step(system, state, 0.0, h, &mut None).0
    }

    /// Renews the frozen blocks where they no longer serve; the first renewal keeps what they were frozen for.
    fn renew(&mut self, a: Matrix2<f64>, m: SMatrix<f64, N, N>, h: f64, backup: &mut Option<Frozen<N>>) {
        let stale = self.stale();
        let fast = self.fast.step() == h && fresh(self.fast.matrix(), &a, h, stale);
        let thermal = self.thermal.step() == h && fresh(self.thermal.matrix(), &m, h, stale);
        if !(fast && thermal) {
            backup.get_or_insert((
                *self.fast.matrix(),
                self.fast.step(),
                *self.thermal.matrix(),
                self.thermal.step(),
            ));
        }
        if !fast {
            self.fast = Phi::new(a, h);
            self.squares = Squares::of(&self.fast);
        }
        if !thermal {
            self.thermal = Phi::new(m, h);
        }
    }

    /// One step of length `h` from `t`: the new state and the error in units of the tolerance.
    fn step<const E: usize>(
        &mut self,
        system: &impl System<N>,
        state: &State<N, E>,
        t: f64,
        h: f64,
        backup: &mut Option<Frozen<N>>,
    ) -> (State<N, E>, f64) {
        let (x0, temp0) = (state.x, state.temperature);
        self.renew(system.fast_matrix(t, &x0, &temp0), system.network_matrix(t, &temp0), h, backup);
        let (fast, thermal) = (&self.fast, &self.thermal);
        let (a, m) = (fast.matrix(), thermal.matrix());
        let (capacity, per_joule) = (system.capacity(), system.inverse_capacity());

        let [tolerance, stage_tolerance, line_tolerance] = self.tolerances(system.bends_where_stiff());
        let (middle, until) = (t + 0.5 * h, t + h);
        let start = system.instant(t, &x0, &temp0);
        let slope0 = system.fast_rates_at(t, &x0, &temp0, &start);
        let n0 = slope0 - product(a, &x0);
        let (network0, outflow0) = system.network(t, &temp0);
        let heat0 = system.heat_rates_at(t, &x0, &temp0, &start);
        let rate0 = network0 + heat0.component_mul(per_joule);
        let xa = fast.half(&x0, &n0);
        let mut tempm = temp0 + rate0 * (0.5 * h);
        let mut stage = system.instant(middle, &xa, &tempm);
        // To begin with, the temperatures end where the first stage's heat leads, which has most of a transient behind it.
        let rate = network0 + system.heat_rates_at(middle, &xa, &tempm, &stage).component_mul(per_joule);
        let mut temp1 = temp0 + rate * h;
        let mut round = 0;
        loop {
            let na = system.fast_rates_at(middle, &xa, &tempm, &stage) - product(a, &xa);
            let xb = fast.constant(&x0, &(na * 2.0 - n0));
            let nb = system.fast_rates(until, &xb, &temp1) - product(a, &xb);
            let forcing = Forcing::through(n0, na, nb);
            let x1 = fast.end(&x0, &slope0, &forcing);
            let xm = fast.middle(&x0, &forcing);
            let x = [x0, xm, x1];
            let (integral, moment) = (fast.integral(&x0, &forcing), fast.moment(&x0, &forcing));
            let (square, error_of_square) = self.squares.integral(h, &x, &forcing, [&integral, &moment]);
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
            let instants = [start, system.instant(middle, &xm, &tempm), system.instant(until, &x1, &temp1)];
            let work = system.work(&segment, &instants);

            // A heat flow with the step's own integral: Simpson's rule solved for the middle.
            let heat1 = system.heat_rates_at(until, &x1, &temp1, &instants[2]);
            let heatm = (work.heat * (6.0 / h) - heat0 - heat1) * 0.25;
            let flow =
                |network: SVector<f64, N>, heat: SVector<f64, N>| network + heat.component_mul(per_joule);
            let (networkm, outflowm) = system.network(middle, &tempm);
            let (network1, outflow1) = system.network(until, &temp1);
            let warming = Forcing::through(
                flow(network0 - product(m, &temp0), heat0),
                flow(networkm - product(m, &tempm), heatm),
                flow(network1 - product(m, &temp1), heat1),
            );
            let (half, end) = (thermal.middle(&temp0, &warming), thermal.end(&temp0, &rate0, &warming));
            let coupling_error = (end - temp1).amax().max((half - tempm).amax());
            let settled = SENSITIVITY * coupling_error <= 0.3 * stage_tolerance;
            round += 1;
            if !settled && round < ROUNDS {
                (tempm, temp1) = (half, end);
                stage = system.instant(middle, &xa, &tempm);
                continue;
            }

            let size = x0.abs().sup(&x1.abs()).sup(&FAST_FLOOR);
            let line_error = fast.curvature_error(&forcing).component_div(&size).amax();
            // Where the block is stiff, its end is the remainder's end value over A, and the parabola and the line
            // agree on that; the estimate is the difference of the remainders at the end and at the last stage.
            let stage_error = system.fast_rates_at(until, &x1, &temp1, &instants[2]) - product(a, &x1) - nb;
            let stage_error = fast.last_stage_error(&stage_error);
            let stage_error = stage_error.component_div(&size).amax();
            // The heat's integral is exact, so its shape within the step counts by the relaxation over the step.
            let thermal_error = product(m, &thermal.curvature_error(&warming)).amax() * h / THERMAL_FLOOR;
            // A transient that dies early has not the parabola's shape, and its heat comes before the middle.
            let shape_error = system.heat_rates_at(middle, &xm, &tempm, &instants[1]) - heatm;
            let shape_error = (shape_error.component_mul(per_joule) * h).amax();
            let heat_error = work.quadrature_error * per_joule.amax() / HEAT_FLOOR;
            let of_heat = thermal_error + heat_error + SENSITIVITY * shape_error;
            let error = line_error / line_tolerance
                + (stage_error + SENSITIVITY * coupling_error) / stage_tolerance
                + of_heat / tolerance;
            // Heat to ambient: the frozen network's share from the exact integral, the rest by Simpson.
            let share = -m.tr_mul(capacity);
            let over_time = thermal.integral(&temp0, &warming);
            let outflow = share.dot(&over_time)
                + h / 6.0
                    * (outflow0 + 4.0 * outflowm + outflow1 - share.dot(&(temp0 + tempm * 4.0 + temp1)));
            let gained = [work.electrical, work.mechanical, outflow + work.ambient];
            let mut energy = state.energy;
            for (sum, gain) in energy.iter_mut().zip(gained.iter().chain(&work.losses)) {
                *sum += gain;
            }
            let integrals = StepIntegrals {
                temperature: state.integrals.temperature + over_time,
                aside: state.integrals.aside + work.aside,
                outflow: state.integrals.outflow + outflow,
            };
            let angle = state.angle + segment.integral[1];
            let next = State { x: x1, angle, temperature: end, energy, integrals };
            let finite = next.x.sum() + next.temperature.sum() + next.angle;
            let sane = finite.is_finite() && next.temperature.amax() < ABSURD && !error.is_nan();
            return (next, if sane { error } else { f64::INFINITY });
        }
    }
}

/// Whether a frozen matrix still serves: what it is off by, times the step, moves the solution by less than the share
/// `stale` of what the matrix itself does.
#[inline]
fn fresh<const N: usize>(frozen: &SMatrix<f64, N, N>, now: &SMatrix<f64, N, N>, h: f64, stale: f64) -> bool {
    let slack = stale / h;
    frozen.iter().zip(now.iter()).all(|(f, n)| (f - n).abs() <= stale * f.abs() + slack)
}
