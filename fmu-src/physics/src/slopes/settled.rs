//! Rates of settled states: of those whose time constant is far below the step that has led to the present point.
//!
//! f(x) of a fast state, for example of the current with L/R = 0.1 ms after a step of 1 s, is the difference of large terms: the
//! integrator's error of the state, within its tolerance, divided by the time constant. Such a state follows the others:
//!
//! J_SS r_S = -(J_SR f_R + df_S/dt)                                                                        (1)
//!
//! with the settled states S, the rest R and f_S constant in time. The next term of the expansion in the time constant tau is
//! tau dr_S/dt, at most (tau / h) r_S if a step resolves the slow motion. Eq. (1) replaces f where that is less than what the
//! tolerance permits, and where f agrees with it within the tolerance.
//! *Source*: Kokotovic, Khalil, O'Reilly, Singular Perturbation Methods in Control (1986), section 1.2.

use super::{Move, Slopes, Unknown};
use crate::model::Slot;
use nalgebra::{DMatrix, DVector};

/// Steps of more time constants than this settle a state: the start value has decayed below the rounding error, and the term that (1)
/// neglects is at most the reciprocal of it.
const SETTLED: f64 = 100.0;

/// A state at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Reached {
    /// Its value.
    pub at: f64,
    /// Its nominal size, positive.
    pub size: f64,
    /// Its derivative f(x).
    pub rate: f64,
}

impl Slopes<'_> {
    /// The rates of all `states` after a step of `h` seconds with this relative tolerance.
    pub fn settled(&mut self, states: &[Reached], h: f64, tolerance: f64) -> Vec<f64> {
        let mut rates: Vec<f64> = states.iter().map(|state| state.rate).collect();
        let unknowns: Vec<Unknown> = (0..states.len()).map(|k| rate_of(k, states[k].size)).collect();
        let columns: Vec<Option<Vec<f64>>> =
            (0..states.len()).map(|k| self.column(k, states, &unknowns, h)).collect();
        let fast: Vec<usize> = (0..states.len()).filter(|&k| columns[k].is_some()).collect();
        if fast.is_empty() {
            return rates;
        }
        let mut moves = vec![Move::of_time(self.base.time(), 1.0)];
        let slow = states.iter().enumerate().filter(|(k, _)| columns[*k].is_none());
        moves.extend(slow.map(|(k, state)| Move::of_state(k, state.at, state.rate, state.size)));
        let asked: Vec<Unknown> = fast.iter().map(|&k| unknowns[k]).collect();
        let forcing =
            DVector::from_iterator(fast.len(), self.along(&moves, &asked).iter().map(|slope| -slope.value));
        let entries = columns.iter().flatten().flat_map(|column| fast.iter().map(|&k| column[k]));
        let jacobian = DMatrix::from_iterator(fast.len(), fast.len(), entries);
        let decay: Vec<f64> = (0..fast.len()).map(|n| -jacobian[(n, n)]).collect();
        let Some(followed) = jacobian.lu().solve(&forcing) else { return rates };
        for ((&k, &r), &decay) in fast.iter().zip(&followed).zip(&decay) {
            let permitted = tolerance * states[k].size.max(states[k].at.abs()) * decay;
            if (r - rates[k]).abs() <= permitted && r.abs() / (decay * h) <= permitted {
                rates[k] = r;
            }
        }
        rates
    }

    /// Derivatives of all rates by state `k`, if a step of `h` seconds is far above its time constant.
    fn column(&mut self, k: usize, states: &[Reached], unknowns: &[Unknown], h: f64) -> Option<Vec<f64>> {
        let state = &states[k];
        let way = f64::EPSILON.sqrt() * state.size.max(state.at.abs());
        let step = [Move::of_state(k, state.at, 1.0, state.size)];
        let (ahead, behind) = (self.at(&step, unknowns, way), self.at(&step, unknowns, -way));
        let column: Vec<f64> = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * way)).collect();
        (-column[k] * h > SETTLED).then_some(column)
    }
}

fn rate_of(k: usize, size: f64) -> Unknown {
    Unknown { slot: Slot { group: Slot::RATES, row: k as u16 }, size }
}
