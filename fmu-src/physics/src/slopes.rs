//! Directional derivatives of a model's unknowns with respect to its knowns.
//!
//! D(h) = [f(h) - f(-h)] / 2h,   D_j(h) = D_{j-1}(h) + [D_{j-1}(h) - D_{j-1}(4h)] / (16^j - 1)      (1)
//!
//! Differences of the model equations, extrapolated to h = 0 (Richardson), with h from a hundredth of the variables'
//! size ([`WAY`]) downwards by factors of 4 until two extrapolations agree to [`ENOUGH`]; for each unknown the pair with the best
//! agreement is used (Ridders). At a limit the differences are one-sided, with 4^j instead of 16^j.
//! *Assumes* a smooth function near the point; where no two extrapolations agree, [`Slope::error`] is large.
//! *Accuracy*: for smooth equations 1e-9 of the derivative, plus the rounding error of the unknown
//! and of its terms, eps |f| / h.
//! *Why no dual numbers*: friction and other ports have them, for the integrator's Jacobians; correlations, operating points
//! of fans and the network do not. Differences are independent of the implementation of an effect.
//! *Source*: Ridders, Adv. Eng. Software 4 (1982) 75-76; Wynn, Math. Tables Aids Comput. 10 (1956) 91-96.

mod settled;

use crate::model::{Model, Slot};
pub use settled::Reached;

/// Largest increment, relative to a variable's size.
pub const WAY: f64 = 1e-2;
/// Ratio of each increment to the next.
const SHRINK: f64 = 4.0;
/// Largest number of increments: the last is 4e-8 of the first.
const LEVELS: usize = 13;
/// Relative agreement of two extrapolations at which the search ends.
const ENOUGH: f64 = 1e-11;
/// Relative agreement after which worse agreement is due to rounding, not to a feature of the function smaller than the increment.
const SETTLED: f64 = 1e-8;
/// A variable is at a limit if the distance is below this fraction of the largest increment.
const AT_LIMIT: f64 = 1e-3;

/// No limits.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// A known, with respect to which the derivative is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Known {
    /// An input or a parameter.
    Variable(Slot),
    /// A continuous state, by its index.
    State(usize),
    /// Time.
    Time,
}

/// A known with its direction.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// The known.
    pub known: Known,
    /// Its present value.
    pub at: f64,
    /// Its component of the direction (seed).
    pub seed: f64,
    /// Its nominal size, positive.
    pub size: f64,
    /// Its limits.
    pub limits: (f64, f64),
}

impl Move {
    /// Of a state, which has no limits.
    pub fn of_state(k: usize, at: f64, seed: f64, size: f64) -> Move {
        Move { known: Known::State(k), at, seed, size, limits: FREE }
    }

    /// Of the time, s.
    pub fn of_time(at: f64, seed: f64) -> Move {
        Move { known: Known::Time, at, seed, size: 1.0, limits: FREE }
    }
}

/// An unknown.
#[derive(Clone, Copy, Debug)]
pub struct Unknown {
    /// Its slot.
    pub slot: Slot,
    /// Its nominal size, positive: an unknown may be a small difference of terms of this size, with their rounding error.
    pub size: f64,
}

/// A derivative, and the difference of its last two estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The derivative.
    pub value: f64,
    /// Its error estimate.
    pub error: f64,
}

/// Directional derivatives of a model.
pub struct Slopes<'a> {
    /// The model, which is not changed.
    pub base: &'a dyn Model,
    /// Another instance of the same model, which is changed.
    pub scratch: &'a mut dyn Model,
    /// Whether every point is one that a step has reached: the energy balance then excludes the heat that a change of
    /// the heat capacities stores.
    pub reached: bool,
    /// Start time, s, if the knowns act through the initialization instead of the present state.
    pub restart: Option<f64>,
}

impl Slopes<'_> {
    /// The derivatives of `unknowns` along `moves`.
    pub fn along(&mut self, moves: &[Move], unknowns: &[Unknown]) -> Vec<Slope> {
        self.from(moves, unknowns, None)
    }

    /// The one-sided derivative, forward or backward: for a point where the derivative is discontinuous.
    pub fn one_sided(&mut self, moves: &[Move], unknowns: &[Unknown], is_ahead: bool) -> Vec<Slope> {
        self.from(moves, unknowns, Some(is_ahead))
    }

    fn from(&mut self, moves: &[Move], unknowns: &[Unknown], side: Option<bool>) -> Vec<Slope> {
        let moving: Vec<Move> = moves.iter().copied().filter(|m| m.seed != 0.0).collect();
        let none = Slope { value: 0.0, error: 0.0 };
        if moving.is_empty() || unknowns.is_empty() {
            return vec![none; unknowns.len()];
        }
        let longest = |room: &dyn Fn(&Move) -> f64| moving.iter().map(room).fold(f64::INFINITY, f64::min);
        let whole = longest(&|m| WAY * m.size.max(m.at.abs()) / m.seed.abs());
        let ahead = longest(&|m| (if m.seed > 0.0 { m.limits.1 } else { m.limits.0 } - m.at) / m.seed);
        let behind = longest(&|m| (m.at - if m.seed > 0.0 { m.limits.0 } else { m.limits.1 }) / m.seed);
        let both = ahead.min(behind);
        if both > AT_LIMIT * whole && side.is_none() {
            return self.extrapolate(&moving, unknowns, whole.min(both), None);
        }
        let sided = if side.unwrap_or(ahead >= behind) { ahead } else { -behind };
        let start = self.at(&moving, unknowns, 0.0);
        self.extrapolate(&moving, unknowns, sided.signum() * whole.min(sided.abs()), Some(start))
    }

    /// Eq. (1) from the increment `h` on; one-sided if `start`, the value at h = 0, is given.
    fn extrapolate(
        &mut self,
        moves: &[Move],
        unknowns: &[Unknown],
        mut h: f64,
        start: Option<Vec<f64>>,
    ) -> Vec<Slope> {
        let order = if start.is_some() { SHRINK } else { SHRINK * SHRINK };
        let mut best = vec![Slope { value: f64::NAN, error: f64::INFINITY }; unknowns.len()];
        // For each unknown the last row of the table, until rounding dominates.
        let mut lines: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); unknowns.len()];
        // Its differences, with the rounding error of each.
        let mut differences: Vec<Vec<[f64; 2]>> = vec![Vec::with_capacity(LEVELS); unknowns.len()];
        for _ in 0..LEVELS {
            let to = self.at(moves, unknowns, h);
            let (from, way) = match &start {
                Some(start) => (start.clone(), h),
                None => (self.at(moves, unknowns, -h), 2.0 * h),
            };
            for (n, place) in lines.iter_mut().enumerate() {
                let Some(line) = place else { continue };
                let rounding = f64::EPSILON * to[n].abs().max(unknowns[n].size) / way.abs();
                let difference = (to[n] - from[n]) / way;
                differences[n].push([difference, rounding]);
                let (next, found) = next_line(line, difference, order, rounding);
                let known = best[n].error <= SETTLED * best[n].value.abs();
                if found.error < best[n].error {
                    best[n] = found;
                }
                let worse = known && found.error > 2.0 * best[n].error;
                let enough = best[n].error <= ENOUGH * best[n].value.abs();
                *place = (!worse && !enough).then_some(next);
            }
            if lines.iter().all(Option::is_none) {
                break;
            }
            h /= SHRINK;
        }
        for (best, differences) in best.iter_mut().zip(&differences) {
            if best.error > SETTLED * best.value.abs() {
                let limit = limit_of(differences);
                if limit.error < best.error {
                    *best = limit;
                }
            }
        }
        best
    }

    /// The unknowns at `s` units along the direction; NaN if the model cannot be evaluated there.
    fn at(&mut self, moves: &[Move], unknowns: &[Unknown], s: f64) -> Vec<f64> {
        self.scratch.copy_from(self.base);
        let count = self.scratch.declaration().states.len();
        let mut all = vec![0.0; count];
        if moves.iter().any(|m| matches!(m.known, Known::State(_))) {
            self.scratch.read_states(&mut all);
            for m in moves {
                if let Known::State(k) = m.known {
                    all[k] = m.at + s * m.seed;
                }
            }
            self.scratch.write_states(&all);
        }
        for m in moves {
            let value = m.at + s * m.seed;
            match m.known {
                Known::Variable(slot) => {
                    self.scratch.set(slot, value);
                }
                Known::Time => self.scratch.write_time(value),
                Known::State(_) => {}
            }
        }
        if self.reached {
            self.scratch.accept_step();
        }
        let there = self.restart.is_none_or(|time| self.scratch.start(time).is_ok());
        let rates = unknowns.iter().any(|u| u.slot.group == Slot::RATES);
        if !there || (rates && self.scratch.derivatives(&mut all).is_err()) {
            return vec![f64::NAN; unknowns.len()];
        }
        let value = |unknown: &Unknown| match unknown.slot.group {
            Slot::RATES => all[unknown.slot.row as usize],
            _ => self.scratch.get(unknown.slot),
        };
        unknowns.iter().map(value).collect()
    }
}

/// The next row of the table of eq. (1), which begins with `difference`, and the best of its entries.
fn next_line(line: &[f64], difference: f64, order: f64, rounding: f64) -> (Vec<f64>, Slope) {
    let mut best = Slope { value: f64::NAN, error: f64::INFINITY };
    let mut next = vec![difference];
    let mut factor = 1.0;
    for (j, before) in line.iter().enumerate() {
        factor *= order;
        let value = next[j] + (next[j] - before) / (factor - 1.0);
        let error = (value - next[j]).abs().max((value - before).abs()) + rounding;
        if error < best.error {
            best = Slope { value, error };
        }
        next.push(value);
    }
    (next, best)
}

/// The limit of differences by Wynn's epsilon algorithm: of each even column the entry that agrees best with the one above.
/// Only as long as the differences converge: the algorithm would return a limit for a divergent sequence (infinite derivative), too.
fn limit_of(differences: &[[f64; 2]]) -> Slope {
    let far = |k: usize| (differences[k][0] - differences[k - 1][0]).abs();
    let count = (2..differences.len()).find(|&k| far(k) >= far(k - 1)).unwrap_or(differences.len());
    let differences = &differences[..count];
    let mut best = Slope { value: f64::NAN, error: f64::INFINITY };
    let mut before = vec![0.0; differences.len() + 1];
    let mut column: Vec<f64> = differences.iter().map(|[difference, _]| *difference).collect();
    for k in 0.. {
        if k % 2 == 0 {
            for (n, pair) in column.windows(2).enumerate() {
                // An entry of column k depends on k + 1 differences; the last one has the largest rounding error.
                let rounding = differences[n + 1 + k][1] * (1 + k) as f64;
                let error = (pair[1] - pair[0]).abs() + rounding;
                if error < best.error {
                    best = Slope { value: pair[1], error };
                }
            }
        }
        if column.len() < 2 {
            return best;
        }
        let next =
            column.windows(2).zip(&before[1..]).map(|(pair, old)| old + 1.0 / (pair[1] - pair[0])).collect();
        before = std::mem::replace(&mut column, next);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::Exchange;
    use crate::models::annulus_cooled_motor::AnnulusCooledMotor;

    fn slot(model: &dyn Model, name: &str) -> Slot {
        model.declaration().by_name(name).unwrap().slot
    }

    fn unknown(model: &dyn Model, name: &str) -> Unknown {
        Unknown { slot: slot(model, name), size: 1.0 }
    }

    /// By hand: d(di/dt)/dv = 1/L; d(di/dt)/di = -R/L; d(R)/dT = R_ref alpha.
    #[test]
    fn slopes_by_hand() {
        let mut motor = AnnulusCooledMotor::default();
        motor.enter_model_exchange();
        motor.start(0.0).unwrap();
        let motor_parameters = motor.parameters.motor;
        let mut scratch = motor.clone();
        let unknowns = [unknown(&motor, "der(state.current)"), unknown(&motor, "winding_resistance")];
        let voltage = slot(&motor, "voltage");
        let one = |known, at, size, limits| [Move { known, at, seed: 1.0, size, limits }];
        let mut slopes = Slopes { base: &motor, scratch: &mut scratch, reached: false, restart: None };
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} and {b}");
        let inverse_l = 1.0 / motor_parameters.L;
        // In the middle, at a lower limit, and at an upper limit.
        for limits in [(-1e4, 1e4), (0.0, 1e4), (-1e4, 0.0)] {
            let by_voltage = slopes.along(&one(Known::Variable(voltage), 0.0, 48.0, limits), &unknowns);
            close(by_voltage[0].value, inverse_l);
            assert_eq!(by_voltage[1].value, 0.0);
        }
        let by_current = slopes.along(&one(Known::State(0), 0.0, 5.0, free), &unknowns);
        close(by_current[0].value, -motor_parameters.resistance(298.15) * inverse_l);
        let by_winding = slopes.along(&one(Known::State(3), 298.15, 300.0, free), &unknowns);
        close(by_winding[1].value, motor_parameters.R_ref * motor_parameters.alpha);
        let nothing = slopes.along(&[], &unknowns);
        assert_eq!(nothing[0].value, 0.0);
    }

    /// By hand for laws with a transition width of 1 rad/s while the nominal speed is in the thousands: dry friction tanh(w/w_small) and
    /// iron loss w / (w^2 + w_small^2)^(1/4), far below and far above the transition.
    #[test]
    fn slopes_where_friction_turns_round() {
        let mut motor = AnnulusCooledMotor::default();
        let (tau_c, k, w_small) = (0.01, 1e-4, 0.7);
        for (name, value) in [
            ("effect.coulomb_friction.tau_c", tau_c),
            ("effect.coulomb_friction.w_small", w_small),
            ("effect.iron_loss.k", k),
            ("effect.iron_loss.w_small", w_small),
        ] {
            motor.set(slot(&motor, name), value);
        }
        motor.enter_model_exchange();
        motor.start(0.0).unwrap();
        let unknowns = [unknown(&motor, "der(state.shaft_speed)")];
        let mut scratch = motor.clone();
        for w in [0.0, 1e-6, 1e-3, 0.1, 0.7, 2.0, 9.0, 50.0, 800.0f64] {
            for w in [w, -w] {
                motor.write_states(&[0.0, w]);
                let mut slopes =
                    Slopes { base: &motor, scratch: &mut scratch, reached: false, restart: None };
                let moves = [Move::of_state(1, w, 1.0, 1000.0)];
                let found = slopes.along(&moves, &unknowns)[0];
                let dry = tau_c / w_small / (w / w_small).cosh().powi(2);
                let square = w * w + w_small * w_small;
                let iron = k * (0.5 * w * w + w_small * w_small) / square.powf(1.25);
                let exact = -(dry + iron) / motor.parameters.motor.J;
                assert!((found.value - exact).abs() <= 1e-8 * exact.abs(), "{w}: {found:?} and {exact}");
                assert!(found.error <= 1e-6 * exact.abs(), "{w}: {found:?}");
            }
        }
    }

    /// 2 - 3 h^(1/4) + h^(1/2) + h^2 converges slowly to 2: after twelve terms the error is still a tenth.
    #[test]
    fn broken_powers_go_to_their_limit() {
        let at = |k: i32| SHRINK.powi(-k);
        let difference = |h: f64| [2.0 - 3.0 * h.powf(0.25) + h.sqrt() + h * h, 1e-15 / h];
        let found = limit_of(&(0..13).map(|k| difference(0.1 * at(k))).collect::<Vec<_>>());
        assert!((found.value - 2.0).abs() < 1e-6 && found.error < 1e-5, "{found:?}");
        let noise = [[0.3, 1e-9], [-0.2, 1e-9], [0.9, 1e-9], [-0.7, 1e-9]];
        assert!(limit_of(&noise).error > 0.1);
        let growing: Vec<[f64; 2]> = (0..13).map(|k| [1.0 + at(k).powf(-0.2), 1e-15]).collect();
        assert!(limit_of(&growing).error > 0.1);
    }

    /// n^0.8 has an infinite derivative at 0: the error estimate indicates it.
    #[test]
    fn what_has_no_slope_is_told() {
        let mut motor = AnnulusCooledMotor::default();
        motor.enter_model_exchange();
        motor.start(0.0).unwrap();
        let mut scratch = motor.clone();
        let unknowns = [unknown(&motor, "der(state.core_temperature)")];
        let fan = slot(&motor, "fan_command");
        let mut warm = [0.0; 22];
        motor.read_states(&mut warm);
        warm[4] = 330.0;
        motor.write_states(&warm);
        let mut slopes = Slopes { base: &motor, scratch: &mut scratch, reached: false, restart: None };
        let along = |at, slopes: &mut Slopes<'_>| {
            let moves = [Move { known: Known::Variable(fan), at, seed: 1.0, size: 1.0, limits: (0.0, 1.0) }];
            slopes.along(&moves, &unknowns)[0]
        };
        let at_rest = along(0.0, &mut slopes);
        assert!(at_rest.error > 1e-2 * at_rest.value.abs(), "{at_rest:?}");
    }
}
