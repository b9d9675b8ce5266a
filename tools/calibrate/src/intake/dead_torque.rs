//! A torque sensor that shows nothing but its noise while the measured current varies.
//!
//! With an imposed speed the shaft torque follows the current, tau = k_t i - drag. Where the motor is driven by a voltage, no preset
//! predicts the current, which is the small difference of two voltages, and the model cannot show that the sensor is dead; the measured
//! current can.
//!
//! spread(tau) < c sigma,   k_t spread(i) / f > c sigma                                     (1)
//!
//! sigma is the noise of the torque, f the factor by which k_t may differ from the preset's. A wrong unit of either channel keeps the
//! readings' variation far above their own noise and is none of this check.
//! *Source*: static parity equation, Isermann, Fault-Diagnosis Systems (2006), ch. 10.

use super::response::{CLEAR, DEAD, ENOUGH, spread};
use crate::CalibrateError;
use crate::experiment::Experiment;
use crate::levels::FACTOR;
use crate::noise;
use crate::simulate::Bench;
use physics::declare::Unit;

/// Sets aside the torque in each run in which its sensor is dead, with a note.
pub fn set_aside(experiment: &mut Experiment, preset: &[(u32, f64)]) -> Result<(), CalibrateError> {
    let bench = Bench::new(experiment, preset)?;
    let constant = bench.declaration().by_name("motor.k_t").map(|entry| bench.start_of(entry.slot));
    let is_imposed = experiment.inputs.iter().any(|c| c.input == Some("imposed_speed"));
    let channels: Vec<_> = experiment.inputs.iter().chain(&experiment.outputs).copied().collect();
    let current = channels.iter().position(|c| c.unit == Unit::Ampere);
    let torque = channels.iter().position(|c| c.output == Some("shaft_torque"));
    let (Some(constant), Some(current), Some(torque), true) = (constant, current, torque, is_imposed) else {
        return Ok(());
    };
    for run in &mut experiment.runs {
        let (amperes, read) = (&run.table.columns[current], &run.table.columns[torque]);
        let known: Vec<usize> = (0..read.len()).filter(|k| (read[*k] + amperes[*k]).is_finite()).collect();
        let of = |column: &[f64]| -> Vec<f64> { known.iter().map(|k| column[*k]).collect() };
        let (time, amperes, read) = (of(&run.table.time), of(amperes), of(read));
        let Some(sigma) = noise::of_column(&time, &read).filter(|_| known.len() >= ENOUGH) else { continue };
        let least = CLEAR * sigma;
        if spread(&read) < least && constant * spread(&amperes) / FACTOR > least {
            run.table.columns[torque].fill(f64::NAN);
            let channel = channels[torque].column;
            experiment.notes.push(format!("{}: {channel} {DEAD}; it is set aside in this run", run.file));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{experiment, normal, read, rng};

    /// A motor with the readings of its model and noise, its torque changed.
    fn checked(change: impl Fn(f64, f64) -> f64) -> Experiment {
        let mut own = experiment("\"thermal.C_h\" = 0.1", true);
        read(&mut own, &[150.0], None);
        let torque = own.inputs.len() + 1;
        let mut rng = rng(3);
        for y in &mut own.runs[0].table.columns[torque] {
            *y = change(*y, 1e-3 * normal(&mut rng));
        }
        set_aside(&mut own, &[]).unwrap();
        own
    }

    /// Noise alone is a dead sensor; a wrong unit, a wrong sign and a sensor with a third of its gain show the current.
    #[test]
    fn only_a_sensor_without_a_signal_is_dead() {
        let torque = |own: &Experiment| own.runs[0].table.columns[own.inputs.len() + 1].clone();
        let dead = checked(|_, noise| 0.02 + noise);
        assert!(torque(&dead).iter().all(|y| y.is_nan()));
        assert!(
            dead.notes[0].contains("shaft_torque_Nm") && dead.notes[0].contains("dead"),
            "{:?}",
            dead.notes
        );
        let alive: [fn(f64, f64) -> f64; 4] = [
            |y, noise| y + noise,
            |y, noise| 1e3 * (y + noise),
            |y, noise| noise - y,
            |y, noise| y / 3.0 + noise,
        ];
        for change in alive {
            let own = checked(change);
            assert!(torque(&own).iter().all(|y| y.is_finite()) && own.notes.is_empty(), "{:?}", own.notes);
        }
    }
}
