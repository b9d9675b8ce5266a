//! Zero offset and gain of an input's instrument, as an explanation of what effects were found for.
//!
//! y = y(u + c),   y = y(u (1 + c)),   c constant in all runs or in one                                (1)
//!
//! A current probe that reads 0.35 A at no current, or a shunt whose value is wrong by 15 %, moves torque, voltage and temperatures
//! together; effects of a motor describe each of them by itself: an offset of the torque sensor, a torque or a voltage over the current.
//! (1) has one number. If it explains as much as all that was found, the reading is wrong and nothing can be said of the motor.
//! *Source*: parity equations of additive and multiplicative sensor faults, Isermann, Fault-Diagnosis Systems (2006), ch. 10; c is fitted
//! with the declared parameters.

use crate::CalibrateError;
use crate::comparison::{converted, digits};
use crate::experiment::{Channel, Role};
use crate::levels::{DECISIVE, STRUCTURE};
use crate::linearization::Linearization;
use crate::outcome::Unusable;
use crate::setup::Setup;
use crate::simulate::Drive;
use physics::declare::Unit;
use std::sync::Arc;

/// Gauss-Newton steps for c. Numerical: two for a zero, in which the model is nearly linear; a gain of 1.5 is known to 1 % after four.
const STEPS: usize = 4;

/// Part of the asked evidence that is enough to first order for a fit. Numerical: a limit of effort.
const HALF: f64 = 0.5;

/// What is wrong with an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    /// Its zero: c is in SI units.
    Zero,
    /// Its gain: c is a fraction.
    Gain,
}

impl Fault {
    /// Derivative of the input by c at this reading.
    fn slope(self, reading: f64) -> f64 {
        match self {
            Fault::Zero => 1.0,
            Fault::Gain => reading,
        }
    }

    /// The true input of a reading.
    fn corrected(self, reading: f64, c: f64) -> f64 {
        match self {
            Fault::Zero => reading + c,
            Fault::Gain => reading * (1.0 + c),
        }
    }

    /// Both corrections after each other.
    fn together(self, c: f64, further: f64) -> f64 {
        match self {
            Fault::Zero => c + further,
            Fault::Gain => (1.0 + c) * (1.0 + further) - 1.0,
        }
    }
}

/// An instrument of an input that is wrong in these runs.
struct Wrong {
    input: usize,
    runs: Vec<usize>,
    fault: Fault,
    /// c of (1).
    correction: f64,
    /// Price of the number and of the choice.
    price: f64,
    /// Decrease of the cost less the price.
    sure: f64,
}

/// The instrument of an input that explains the residual of a fit, in all or one of its runs or in the validation runs, if it explains more
/// than `found` (an effect, or all that was found, decreases the cost by so much), and more than structure error can.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn explains(
    point: &Linearization,
    places: &[Vec<usize>],
    found: f64,
) -> Result<Option<Unusable>, CalibrateError> {
    let least = found.max(DECISIVE);
    // A first fit far from the truth shows a part of it only.
    let likely = likely(point, places).into_iter().filter(|wrong| wrong.sure > least * HALF);
    let Some(wrong) = likely.max_by(|a, b| a.sure.total_cmp(&b.sure)) else { return Ok(None) };
    let wrong = fitted(point, wrong)?;
    let is_seen = wrong.correction.abs() > STRUCTURE * size(point.setup, &wrong);
    Ok((wrong.sure > least && is_seen).then(|| sentence(point.setup, &wrong)))
}

/// All these runs, and each of them.
pub fn places(runs: &[usize]) -> Vec<Vec<usize>> {
    let single = runs.iter().map(|run| vec![*run]).filter(|_| runs.len() > 1);
    std::iter::once(runs.to_vec()).chain(single).filter(|place| !place.is_empty()).collect()
}

fn sentence(setup: &Setup, wrong: &Wrong) -> Unusable {
    let (experiment, channel) = (setup.experiment, setup.experiment.inputs[wrong.input]);
    let is_everywhere = wrong.runs.len() == experiment.runs.len();
    let files: Vec<&str> = wrong.runs.iter().map(|run| experiment.runs[*run].file.as_str()).collect();
    let (place, also) = if is_everywhere {
        ("every run".to_string(), "")
    } else {
        (files.join(", "), "; what disagrees with the other runs may also be of another motor")
    };
    let (column, unit) = (channel.column, channel.unit.name());
    let (change, suggestion) = match wrong.fault {
        Fault::Zero => (
            format!(
                "if {} {unit} is subtracted: the zero of its sensor is off",
                converted(-wrong.correction)
            ),
            format!("check the zero of {column}, and subtract what it reads at rest{also}"),
        ),
        Fault::Gain => (
            format!(
                "if it is multiplied by {}: the gain of its instrument is off, or the column is of another quantity",
                digits(1.0 + wrong.correction)
            ),
            format!(
                "compare {column} with a second instrument (value of the shunt, scaling of the amplifier, amplitude or root mean square, \
                 poles of the motor); [columns] states the unit of a column{also}"
            ),
        ),
    };
    Unusable::new(column, format!("{column} in {place} agrees with the other channels {change}"), suggestion)
}

/// What may be wrong with an instrument: a temperature has an effect of the list, a command has no sensor, and a gain of the power is the
/// loss of a drive.
fn faults(channel: &Channel) -> &'static [Fault] {
    match channel.unit {
        Unit::One => &[],
        _ if channel.is_temperature() => &[],
        Unit::Watt => &[Fault::Zero],
        _ => &[Fault::Zero, Fault::Gain],
    }
}

/// To first order, each fault of each input in each place.
fn likely(point: &Linearization, places: &[Vec<usize>]) -> Vec<Wrong> {
    let inputs = point.setup.experiment.inputs.iter().enumerate();
    let all: Vec<(usize, Fault)> =
        inputs.flat_map(|(k, channel)| faults(channel).iter().map(move |fault| (k, *fault))).collect();
    let price = point.per_number() + 2.0 * ((all.len() * places.len()) as f64).ln();
    let of = |(input, fault): (usize, Fault), runs: &Vec<usize>| {
        let gain = point.evidence.gain(&point.input_column(input, runs, |x| fault.slope(x))?)?;
        let sure = gain.raw.min(gain.whitened) - price;
        Some(Wrong { input, runs: runs.clone(), fault, correction: gain.size[0], price, sure })
    };
    all.iter().flat_map(|one| places.iter().filter_map(move |runs| of(*one, runs))).collect()
}

/// Root mean square of the input in these runs, in the unit of c.
fn size(setup: &Setup, wrong: &Wrong) -> f64 {
    if wrong.fault == Fault::Gain {
        return 1.0;
    }
    let all = wrong.runs.iter().flat_map(|run| &setup.drives[*run].inputs()[wrong.input]);
    let (sum, count) = all.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The correction fitted with the declared parameters, with its evidence by that fit.
fn fitted(point: &Linearization, mut wrong: Wrong) -> Result<Wrong, CalibrateError> {
    let fitted_runs = wrong.runs.clone();
    if fitted_runs == point.runs {
        // What is wrong in all fit runs is so in the others.
        let others = [Role::Validate, Role::Test].iter().flat_map(|role| point.setup.runs(*role));
        wrong.runs.extend(others);
    }
    let mut correction = wrong.correction;
    wrong.sure = f64::NEG_INFINITY;
    for _ in 0..STEPS {
        let setup = corrected(point.setup, &wrong, correction);
        let fitted = setup.fit(point.fitted.hypothesis.clone(), &point.runs)?;
        let own = Linearization::judged(&setup, fitted, &point.runs)?;
        let (white, raw) = own.explains(point);
        let sure = white.min(raw) - wrong.price;
        if sure <= wrong.sure {
            break;
        }
        (wrong.correction, wrong.sure) = (correction, sure);
        let column = own.input_column(wrong.input, &fitted_runs, |x| wrong.fault.slope(x));
        let Some(gain) = column.and_then(|column| own.evidence.gain(&column)) else { break };
        correction = wrong.fault.together(correction, gain.size[0]);
    }
    Ok(wrong)
}

/// The setup with a corrected input.
fn corrected<'a>(setup: &Setup<'a>, wrong: &Wrong, c: f64) -> Setup<'a> {
    let of = |drives: &Arc<Vec<Drive>>| {
        let all = drives.iter().enumerate().map(|(r, drive)| match wrong.runs.contains(&r) {
            true => drive.with_input(wrong.input, |reading| wrong.fault.corrected(reading, c)),
            false => drive.clone(),
        });
        Arc::new(all.collect::<Vec<_>>())
    };
    let (drives, smooth, driven) = (of(&setup.drives), of(&setup.smooth), of(&setup.driven));
    Setup { drives, smooth, driven, ..setup.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypothesis::Hypothesis;
    use crate::testing::{self, PRIORS};

    /// What is said of readings with the preset's parameters and an effect, an input as its wrong instrument shows it.
    fn said(
        drive: (&str, f64, f64),
        outputs: &[&str],
        effect: Option<(&str, f64)>,
        (input, shown): (usize, &dyn Fn(f64) -> f64),
    ) -> Option<Unusable> {
        let mut experiment = testing::driven_by(drive, outputs, PRIORS, true);
        testing::read_of(&mut experiment, |setup| {
            let additions = effect.map(|(id, size)| testing::addition(setup, id, size)).into_iter().collect();
            setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
        });
        experiment.runs[0].table.columns[input].iter_mut().for_each(|x| *x = shown(*x));
        let setup = Setup::new(&experiment, &[]).unwrap();
        let fitted = setup.fit(setup.preset(), &[0]).unwrap();
        let point = Linearization::new(&setup, fitted, &[0]).unwrap();
        explains(&point, &places(&[0]), crate::search::search(&point)[0].sure()).unwrap()
    }

    const CURRENT: (&str, f64, f64) = ("current_A", 1.0, 190.0);

    fn number_after(text: &str, words: &str) -> f64 {
        text.split(words).nth(1).unwrap().split([' ', ':']).next().unwrap().parse().unwrap()
    }

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
            let why = said(drive, outputs, None, (input, &|x| x + zero))
                .unwrap_or_else(|| panic!("{} {zero}", drive.0));
            let amount = number_after(&why.reason, " if ");
            assert!((amount / zero - 1.0).abs() < 0.05, "{}", why.reason);
        }
    }

    /// A shunt, a current clamp or a tachometer of another gain, by a factor of no unit.
    #[test]
    fn a_gain_is_found_with_its_size() {
        for (input, gain) in [(0, 1.17), (0, 0.83), (0, 1.5), (1, 1.12), (1, 0.8)] {
            let why = said(CURRENT, &testing::OUTPUTS, None, (input, &|x| gain * x))
                .unwrap_or_else(|| panic!("{input} {gain}"));
            let factor = number_after(&why.reason, " by ");
            assert!((factor * gain - 1.0).abs() < 0.05, "{gain}: {}", why.reason);
        }
    }

    /// In the validation run alone, with and without an effect in all runs.
    #[test]
    fn an_error_in_a_validation_run_is_found_there() {
        for (effect, input, gain, zero) in [
            (None, 0, 1.0, 0.25),
            (None, 1, 0.85, 0.0),
            (Some(("viscous_friction", 2e-5)), 0, 1.2, 0.0),
            (Some(("viscous_friction", 2e-5)), 0, 1.0, 0.0),
            (None, 0, 1.0, 0.0),
        ] {
            let mut experiment = testing::driven_by(CURRENT, &testing::OUTPUTS, PRIORS, true);
            let mut second = experiment.runs[0].clone();
            (second.file, second.role) = ("second.csv".to_string(), Role::Validate);
            for column in &mut second.table.columns[..2] {
                column.reverse();
            }
            experiment.runs.push(second);
            testing::read_of(&mut experiment, |setup| {
                let additions =
                    effect.map(|(id, size)| testing::addition(setup, id, size)).into_iter().collect();
                setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
            });
            experiment.runs[1].table.columns[input].iter_mut().for_each(|x| *x = gain * *x + zero);
            let setup = Setup::new(&experiment, &[]).unwrap();
            // The search has found the effect in the fit run.
            let additions =
                effect.map(|(id, size)| testing::addition(&setup, id, size)).into_iter().collect();
            let own = setup.fit(Hypothesis { additions, ..setup.preset() }, &[0]).unwrap();
            let both = setup.judged(own.hypothesis, &[0, 1]).unwrap();
            let point = Linearization::judged(&setup, both, &[0, 1]).unwrap();
            let said = explains(&point, &places(&[1]), 0.0).unwrap();
            let expected = gain != 1.0 || zero != 0.0;
            assert_eq!(said.is_some(), expected, "{effect:?} {input} {gain} {zero}: {said:?}");
            let words = if gain == 1.0 { (" if ", zero) } else { (" by ", 1.0 / gain) };
            if let Some(why) = said {
                assert!(why.reason.contains("in second.csv"), "{}", why.reason);
                let shown = number_after(&why.reason, words.0);
                assert!((shown / words.1 - 1.0).abs() < 0.05, "{}", why.reason);
            }
        }
    }

    /// A small zero or gain, an effect, and an effect that moves the same output are none.
    #[test]
    fn an_effect_is_no_error_of_an_instrument() {
        for (effect, zero, gain) in [
            (None, 0.0, 1.0),
            (None, 0.02, 1.0),
            (None, 0.0, 1.01),
            (Some(("torque_sensor_offset", 0.01)), 0.0, 1.0),
            (Some(("contact_drop", 0.3)), 0.0, 1.0),
            (Some(("viscous_friction", 2e-5)), 0.0, 1.0),
            (Some(("coulomb_friction", 0.02)), 0.0, 1.0),
            (Some(("iron_loss", 3e-4)), 0.0, 1.0),
            (Some(("winding_sensor_offset", 4.0)), 0.0, 1.0),
        ] {
            let shown = |x: f64| gain * x + zero;
            assert_eq!(
                said(CURRENT, &testing::OUTPUTS, effect, (0, &shown)),
                None,
                "{effect:?} {zero} {gain}"
            );
        }
    }
}
