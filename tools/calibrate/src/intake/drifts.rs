//! Thermometers that drift in a run: an amplifier that warms up, a thermocouple that degrades, a cold junction that is heated.
//!
//! e = a (t - t0) + r,   |a| (t1 - t0) > e_s,   sum r^2 < (1 - c) sum e^2                                (1)
//!
//! e the deviation of a thermometer from a fit that agrees with the other data, t0 and t1 the ends of the run, e_s the error of a thermometer
//! that works, c = [`NEARLY`]. What a model lacks in the motor follows its temperature, and a wrong zero or a loss along the leads are
//! parts of it: e has to be described worse by b (p - p0) + d, p the prediction, with [`FACTOR`] times the sum of squares.
//!
//! *Source*: drift of a sensor as an additive fault that grows linearly: Isermann, Fault-Diagnosis Systems (2006), ch. 5.

use super::signals::SENSOR_ERROR;
use crate::levels::{FACTOR, NEARLY};

/// The failure in words.
pub(super) const WHY: &str = "drifts away from the model at a constant rate while the other data agree with it, as a degrading \
                              thermocouple or an amplifier that warms up does";

/// Whether a thermometer drifts: times, deviations and predictions of its readings in a run.
pub(super) fn is_drift(time: &[f64], off: &[f64], model: &[f64]) -> bool {
    let (Some(first), Some(last)) = (time.first(), time.last()) else { return false };
    let since: Vec<f64> = time.iter().map(|t| t - first).collect();
    let (rate, left) = remainder(&since, off);
    let is_far = rate.abs() * (last - first) > SENSOR_ERROR && left < (1.0 - NEARLY) * product(off, off);
    is_far && remainder(&centred(model), &centred(off)).1 > FACTOR * left
}

/// Slope over x and sum of squares that it leaves of y.
fn remainder(x: &[f64], y: &[f64]) -> (f64, f64) {
    let slope = product(x, y) / product(x, x).max(f64::MIN_POSITIVE);
    (slope, product(y, y) - slope * product(x, y))
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|x| x - mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{normal, rng};

    /// An hour of heating up and cooling down by 60 K, and what is added to the readings.
    fn drifts(added: impl Fn(f64, f64) -> f64) -> bool {
        let mut rng = rng(11);
        let time: Vec<f64> = (0..1800).map(|k| 500.0 + 2.0 * f64::from(k)).collect();
        let rise = |t: f64| {
            let heated = |t: f64| 60.0 * (1.0 - (-t / 900.0).exp());
            heated(t) - if t > 2000.0 { heated(t - 2000.0) } else { 0.0 }
        };
        let model: Vec<f64> = time.iter().map(|t| 295.0 + rise(t - 500.0)).collect();
        let off: Vec<f64> =
            time.iter().map(|t| added(t - 500.0, rise(t - 500.0)) + 0.2 * normal(&mut rng)).collect();
        is_drift(&time, &off, &model)
    }

    #[test]
    fn only_a_deviation_that_grows_with_time_is_a_drift() {
        for rate in [-9.0, 4.0, 20.0] {
            assert!(drifts(|t, _| rate * t / 3600.0), "{rate} K/h");
        }
        assert!(!drifts(|t, _| 1.5 * t / 3600.0), "within the error of a thermometer");
        assert!(!drifts(|_, rise| 0.2 * rise), "a stem loss or a missing effect");
        assert!(!drifts(|_, _| 6.0), "a zero");
        assert!(!drifts(|t, _| if t < 1800.0 { 0.0 } else { -5.0 }), "a sensor that has moved");
        // A further node that warms up within the hour.
        assert!(!drifts(|t, _| 8.0 * (1.0 - (-t / 1200.0).exp())));
    }
}
