//! The temperatures among the states of a motor, and the derivatives of their rates.

use physics::model::Model;

/// Temperature difference of derivatives, K.
const DIFFERENCE: f64 = 1e-2;

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
