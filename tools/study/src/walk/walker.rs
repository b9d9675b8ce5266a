//! What moves the motor over a period: an actuator under a gait, a cycle at its shaft, or a mix of both with rest.

use super::mix::Mix;
use super::shaft::Shaft;
use super::stride::{Coupled, Periodic};
use crate::StudyError;
use physics::model::Model;

/// Temperature difference of derivatives, K.
const DIFFERENCE: f64 = 1e-2;

/// A motor with what moves it, simulated period by period.
#[derive(Clone)]
pub enum Walker {
    /// Motor, actuator and gait.
    Coupled(Box<Coupled>),
    /// The motor under a cycle of torque and speed.
    Shaft(Box<Shaft>),
    /// A mix of the others.
    Mix(Box<Mix>),
}

/// Calls the method of what is inside.
macro_rules! inside {
    ($walker:expr, $inner:ident => $call:expr) => {
        match $walker {
            Walker::Coupled($inner) => $call,
            Walker::Shaft($inner) => $call,
            Walker::Mix($inner) => $call,
        }
    };
}

impl Walker {
    /// Time of a period, s.
    pub fn stride_time(&self) -> f64 {
        inside!(self, w => w.stride_time())
    }

    /// Simulates a period.
    ///
    /// # Errors
    /// Equations that have no solution.
    pub fn stride(&mut self) -> Result<Periodic, StudyError> {
        inside!(self, w => w.stride())
    }

    /// The temperatures that the motor's heat depends on, K.
    pub fn temperatures(&self) -> Vec<f64> {
        inside!(self, w => w.temperatures())
    }

    /// Sets them; current and motion stay.
    pub fn put_temperatures(&mut self, temperatures: &[f64]) {
        inside!(self, w => w.put_temperatures(temperatures));
    }

    /// Simulates a period and finds the mean derivatives of the temperatures' rates with respect to the temperatures, 1/s, a row for
    /// each rate.
    ///
    /// # Errors
    /// Equations that have no solution.
    pub fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
        inside!(self, w => w.stride_with_slopes())
    }
}

/// The states of a motor from the given one on: its temperatures.
pub(super) fn temperatures(motor: &dyn Model, first: usize) -> Vec<f64> {
    let mut states = Vec::new();
    motor.states(&mut states);
    states.split_off(first)
}

/// Sets them.
pub(super) fn put_temperatures(motor: &mut dyn Model, first: usize, temperatures: &[f64]) {
    let mut states = Vec::new();
    motor.states(&mut states);
    states[first..].copy_from_slice(temperatures);
    let time = motor.time();
    motor.set_states(time, &states);
}

/// Adds the present derivatives of the rates times `share`, by differences on a copy of the motor.
pub(super) fn add_slopes(motor: &dyn Model, first: usize, slopes: &mut [Vec<f64>], share: f64) {
    let mut motor = motor.boxed_clone();
    let time = motor.time();
    let (mut start, mut rates) = (Vec::new(), Vec::new());
    motor.states(&mut start);
    for column in 0..slopes.len() {
        for sign in [1.0, -1.0] {
            let mut moved = start.clone();
            moved[first + column] += sign * DIFFERENCE;
            motor.set_states(time, &moved);
            rates.clear();
            motor.rates(&mut rates);
            for (row, rate) in rates[first..].iter().enumerate() {
                slopes[row][column] += share * sign * rate / (2.0 * DIFFERENCE);
            }
        }
    }
}
