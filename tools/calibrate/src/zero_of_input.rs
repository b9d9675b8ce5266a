//! Zero offset of an input's sensor, as an explanation of what effects were found for.
//!
//! y = y(u - c),   c constant in all runs or in one                                                    (1)
//!
//! A current probe that reads 0.35 A at no current moves torque, voltage and temperatures together; effects of a motor describe each of
//! them by itself: an offset of the torque sensor, a voltage over the current. (1) has one number. If it explains as much as all that
//! was found, the reading is wrong and nothing can be said of the motor.
//! *Source*: parity equations of sensor faults, Isermann, Fault-Diagnosis Systems (2006), ch. 10; c is fitted with the declared parameters.

use crate::CalibrateError;
use crate::comparison::converted;
use crate::experiment::{Channel, Role};
use crate::levels::{DECISIVE, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Unusable;
use crate::setup::Setup;
use crate::simulate::Drive;
use physics::declare::Unit;
use std::sync::Arc;

/// Gauss-Newton steps for c. Numerical: the model is nearly linear in it.
const STEPS: usize = 2;

/// An offset c in SI units, of an input in these runs.
struct Zero {
    input: usize,
    runs: Vec<usize>,
    offset: f64,
    /// Price of the number and of the choice.
    price: f64,
    /// Decrease of the cost less the price.
    sure: f64,
}

/// The zero of an input's sensor that explains the residual of a fit, if it explains more than `found` (an effect, or all that was found,
/// decreases the cost by so much), and more than structure error can.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn explains(point: &Linearization, found: f64) -> Result<Option<Unusable>, CalibrateError> {
    let least = found.max(DECISIVE);
    let Some(zero) = likely(point).into_iter().max_by(|a, b| a.sure.total_cmp(&b.sure)) else {
        return Ok(None);
    };
    // A first fit far from the truth shows a part of it only.
    if zero.sure <= least * HALF {
        return Ok(None);
    }
    let zero = fitted(point, zero)?;
    let (setup, channel) = (point.setup, point.setup.experiment.inputs[zero.input]);
    let size = size(setup, &zero);
    if zero.sure <= least || zero.offset.abs() <= STRUCTURE * size {
        return Ok(None);
    }
    Ok(Some(sentence(setup, channel, &zero)))
}

/// Part of the asked evidence that is enough to first order for a fit. Numerical: a limit of effort.
const HALF: f64 = 0.5;

fn sentence(setup: &Setup, channel: &Channel, zero: &Zero) -> Unusable {
    let experiment = setup.experiment;
    let place = match zero.runs[..] {
        [one] if experiment.runs.len() > 1 => experiment.runs[one].file.clone(),
        _ => "every run".to_string(),
    };
    let amount = converted(zero.offset);
    let unit = channel.unit.name();
    Unusable {
        channel: channel.column.to_string(),
        reason: format!(
            "{} in {place} agrees with the other channels if {amount} {unit} is subtracted: the zero of its sensor is off",
            channel.column
        ),
        suggestion: format!("check the zero of {}, and subtract what it reads at rest", channel.column),
    }
}

/// Inputs whose sensor may have a zero of its own: a temperature has an effect of the list, a command has no sensor.
fn has_zero(channel: &Channel) -> bool {
    !channel.is_temperature() && channel.unit != Unit::One
}

/// To first order, each input in all runs and in each one.
fn likely(point: &Linearization) -> Vec<Zero> {
    let experiment = point.setup.experiment;
    let inputs: Vec<usize> =
        (0..experiment.inputs.len()).filter(|k| has_zero(experiment.inputs[*k])).collect();
    let runs = point.runs.len();
    let places: Vec<Vec<usize>> = if runs > 1 {
        std::iter::once(point.runs.clone()).chain(point.runs.iter().map(|r| vec![*r])).collect()
    } else {
        vec![point.runs.clone()]
    };
    let price = point.per_number() + 2.0 * ((inputs.len() * places.len()) as f64).ln();
    let of = |input: &usize, runs: &Vec<usize>| {
        let gain = point.evidence.gain(&point.input_column(*input, runs)?)?;
        // The model wants another input by this; the reading is off by the opposite.
        let (offset, sure) = (-gain.size[0], gain.raw.min(gain.whitened) - price);
        Some(Zero { input: *input, runs: runs.clone(), offset, price, sure })
    };
    inputs.iter().flat_map(|input| places.iter().filter_map(move |runs| of(input, runs))).collect()
}

/// Root mean square of the input in these runs.
fn size(setup: &Setup, zero: &Zero) -> f64 {
    let all = zero.runs.iter().flat_map(|run| &setup.drives[*run].inputs()[zero.input]);
    let (sum, count) = all.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The offset fitted with the declared parameters, with its evidence by that fit.
fn fitted(point: &Linearization, mut zero: Zero) -> Result<Zero, CalibrateError> {
    let fitted_runs = zero.runs.clone();
    if fitted_runs == point.runs {
        // A zero of all fit runs is also that of the others.
        let others = [Role::Validate, Role::Test].iter().flat_map(|role| point.setup.runs(*role));
        zero.runs.extend(others);
    }
    let mut offset = zero.offset;
    zero.sure = f64::NEG_INFINITY;
    for _ in 0..STEPS {
        let setup = moved(point.setup, zero.input, &zero.runs, -offset);
        let fitted = setup.fit(point.fitted.hypothesis.clone(), &point.runs)?;
        let own = Linearization::judged(&setup, fitted, &point.runs)?;
        let (white, raw) = own.explains(point);
        let sure = white.min(raw) - zero.price;
        if sure <= zero.sure {
            break;
        }
        (zero.offset, zero.sure) = (offset, sure);
        let gain = own.input_column(zero.input, &fitted_runs).and_then(|column| own.evidence.gain(&column));
        offset -= gain.map_or(0.0, |gain| gain.size[0]);
    }
    Ok(zero)
}

/// The setup with a constant added to an input in some runs.
fn moved<'a>(setup: &Setup<'a>, input: usize, runs: &[usize], way: f64) -> Setup<'a> {
    let of = |drives: &Arc<Vec<Drive>>| {
        let all = drives.iter().enumerate();
        let moved =
            all.map(|(r, d)| if runs.contains(&r) { d.with_input_moved(input, way) } else { d.clone() });
        Arc::new(moved.collect::<Vec<_>>())
    };
    let (drives, smooth, driven) = (of(&setup.drives), of(&setup.smooth), of(&setup.driven));
    Setup { drives, smooth, driven, ..setup.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypothesis::Hypothesis;
    use crate::testing::{self, PRIORS};

    /// What is said of readings with the preset's parameters and an effect, the input `moved` by a constant afterwards.
    fn said(
        drive: (&str, f64, f64),
        outputs: &[&str],
        effect: Option<(&str, f64)>,
        moved: (usize, f64),
    ) -> Option<Unusable> {
        let mut experiment = testing::driven_by(drive, outputs, PRIORS, true);
        testing::read_of(&mut experiment, |setup| {
            let additions = effect.map(|(id, size)| testing::addition(setup, id, size)).into_iter().collect();
            setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
        });
        experiment.runs[0].table.columns[moved.0].iter_mut().for_each(|x| *x += moved.1);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let fitted = setup.fit(setup.preset(), &[0]).unwrap();
        let point = Linearization::new(&setup, fitted, &[0]).unwrap();
        explains(&point, crate::search::search(&point)[0].sure()).unwrap()
    }

    const CURRENT: (&str, f64, f64) = ("current_A", 1.0, 190.0);
    /// Zeros of a current probe and of a tachometer are found with their size. That of a voltmeter is a voltage in series, and no other.
    #[test]
    fn a_zero_is_found_with_its_size() {
        for (drive, outputs, input, zero) in [
            (CURRENT, &testing::OUTPUTS[..], 0, 0.3),
            (CURRENT, &testing::OUTPUTS[..], 0, -0.2),
            (CURRENT, &testing::OUTPUTS[..], 1, 15.0),
            (CURRENT, &testing::OUTPUTS[..], 1, -9.0),
            (CURRENT, &testing::OUTPUTS[..3], 0, 0.5),
        ] {
            let why =
                said(drive, outputs, None, (input, zero)).unwrap_or_else(|| panic!("{} {zero}", drive.0));
            let amount: f64 =
                why.reason.split(" if ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            assert!((amount / zero - 1.0).abs() < 0.05, "{}", why.reason);
        }
    }

    /// A small zero, an effect, and an effect that moves the same output are none.
    #[test]
    fn an_effect_is_no_zero() {
        for (effect, zero) in [
            (None, 0.0),
            (None, 0.02),
            (Some(("torque_sensor_offset", 0.01)), 0.0),
            (Some(("contact_drop", 0.3)), 0.0),
            (Some(("viscous_friction", 2e-5)), 0.0),
        ] {
            assert_eq!(said(CURRENT, &testing::OUTPUTS, effect, (0, zero)), None, "{effect:?}");
        }
    }
}
