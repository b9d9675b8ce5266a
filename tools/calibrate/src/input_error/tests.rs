//! Errors of instruments with known sizes, and effects that are none.

use super::*;
use crate::hypothesis::Hypothesis;
use crate::testing::{self, PRIORS};

/// What is said of readings with the preset's parameters and an effect, an input as its wrong instrument shows it.
fn said(
    drive: (&str, f64, f64),
    outputs: &[&str],
    effect: Option<(&str, f64)>,
    (input, shown): (usize, &dyn Fn(f64, f64) -> f64),
) -> Option<Unusable> {
    let mut experiment = testing::driven_by(drive, outputs, PRIORS, true);
    testing::read_of(&mut experiment, |setup| {
        let additions = effect.map(|(id, size)| testing::addition(setup, id, size)).into_iter().collect();
        setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
    });
    let table = &mut experiment.runs[0].table;
    table.columns[input].iter_mut().zip(&table.time).for_each(|(x, t)| *x = shown(*t, *x));
    let setup = Setup::new(&experiment, &[]).unwrap();
    let fitted = setup.fit(setup.preset(), &[0]).unwrap();
    let point = Linearization::new(&setup, fitted, &[0]).unwrap();
    let all = crate::search::search(&point)[0].sure();
    explains(&point, &places(&[0]), Explained { all, listed: all, laws: 0 }).unwrap()
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
        (CURRENT, &testing::OUTPUTS[..], 0, 0.02),
        (CURRENT, &testing::OUTPUTS[..], 1, 15.0),
        (CURRENT, &testing::OUTPUTS[..], 1, -9.0),
        (CURRENT, &testing::OUTPUTS[..3], 0, 0.5),
    ] {
        let why = said(drive, outputs, None, (input, &|_, x| x + zero))
            .unwrap_or_else(|| panic!("{} {zero}", drive.0));
        let amount = number_after(&why.reason, " if ");
        assert!((amount / zero - 1.0).abs() < 0.05, "{}", why.reason);
    }
}

/// A constant reading that errs by most of itself is not believed; one that varies says nothing of its zero.
#[test]
fn a_zero_of_half_of_a_steady_reading_is_none() {
    for (wild, zero, expected) in
        [(false, 0.5, true), (false, 3.0, false), (false, -3.0, false), (true, 3.0, true)]
    {
        let experiment = testing::experiment(PRIORS, wild);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let (form, sizes, runs) = (Form::Zero, vec![zero], vec![0]);
        let wrong = Wrong { input: 0, runs, form, sizes, price: 0.0, sure: 0.0, left: 0.0, rest: 0.0 };
        assert_eq!(wrong.is_plausible(&setup), expected, "{wild} {zero}");
    }
}

/// A shunt, a current clamp or a tachometer of another gain, by a factor of no unit.
#[test]
fn a_gain_is_found_with_its_size() {
    for (input, gain) in [(0, 1.17), (0, 0.83), (0, 1.5), (1, 1.12), (1, 0.8)] {
        let why = said(CURRENT, &testing::OUTPUTS, None, (input, &|_, x| gain * x))
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
            let additions = effect.map(|(id, size)| testing::addition(setup, id, size)).into_iter().collect();
            setup.change(&Hypothesis { additions, ..setup.preset() }, 0)
        });
        experiment.runs[1].table.columns[input].iter_mut().for_each(|x| *x = gain * *x + zero);
        let setup = Setup::new(&experiment, &[]).unwrap();
        // The search has found the effect in the fit run.
        let additions = effect.map(|(id, size)| testing::addition(&setup, id, size)).into_iter().collect();
        let own = setup.fit(Hypothesis { additions, ..setup.preset() }, &[0]).unwrap();
        let both = setup.judged(own.hypothesis, &[0, 1]).unwrap();
        let point = Linearization::judged(&setup, both, &[0, 1]).unwrap();
        let said = explains(&point, &places(&[1]), Explained::default()).unwrap();
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

/// Another value of a parameter in one run explains what weaker magnets there do, and nothing in runs of one motor.
#[test]
fn a_parameter_of_one_run_explains_another_motor() {
    for share in [1.0, 0.92] {
        let mut experiment = testing::driven_by(CURRENT, &testing::OUTPUTS, PRIORS, true);
        let second = experiment.runs[0].clone();
        experiment.runs.push(second);
        experiment.runs[1].file = "second.csv".to_string();
        let preset = {
            let setup = Setup::new(&experiment, &[]).unwrap();
            setup
                .declared
                .iter()
                .map(|own| (own.name == "motor.k_t", setup.bench.start_of(own.slot)))
                .collect()
        };
        let of = |preset: &Vec<(bool, f64)>, share: f64| -> Vec<f64> {
            preset.iter().map(|(is_k_t, value)| if *is_k_t { share * value } else { *value }).collect()
        };
        let mut other = experiment.clone();
        testing::read(&mut experiment, &of(&preset, 1.0), None);
        testing::read(&mut other, &of(&preset, share), None);
        experiment.runs[1].table = other.runs[1].table.clone();
        let setup = Setup::new(&experiment, &[]).unwrap();
        let fitted = setup.fit(setup.preset(), &[0, 1]).unwrap();
        let point = Linearization::new(&setup, fitted, &[0, 1]).unwrap();
        let sure = of_a_parameter(&point, &[1]);
        assert!(if share == 1.0 { sure < LEAST } else { sure > 10.0 * DECISIVE }, "{share}: {sure}");
        assert_eq!(explains(&point, &places(&[0, 1]), Explained::default()).unwrap(), None);
    }
}

/// A small zero or gain, an effect, and an effect that moves the same output are none.
#[test]
fn an_effect_is_no_error_of_an_instrument() {
    for (effect, zero, gain) in [
        (None, 0.0, 1.0),
        (None, 0.005, 1.0),
        (None, 0.0, 1.01),
        (Some(("torque_sensor_offset", 0.01)), 0.0, 1.0),
        (Some(("contact_drop", 0.3)), 0.0, 1.0),
        (Some(("viscous_friction", 2e-5)), 0.0, 1.0),
        (Some(("coulomb_friction", 0.02)), 0.0, 1.0),
        (Some(("iron_loss", 3e-4)), 0.0, 1.0),
        (Some(("winding_sensor_offset", 4.0)), 0.0, 1.0),
    ] {
        let shown = |_: f64, x: f64| gain * x + zero;
        assert_eq!(said(CURRENT, &testing::OUTPUTS, effect, (0, &shown)), None, "{effect:?} {zero} {gain}");
    }
}

/// Instruments that are wrong by a function of their reading: near the end of the range, with a dead band, with lost counts, with another
/// gain in a range, with a wrong table.
#[test]
fn a_curve_is_found() {
    let forms: [(usize, &dyn Fn(f64) -> f64); 5] = [
        (0, &|i| 6.0 * (i / 6.0).tanh()),
        (0, &|i| i - 0.02 * i * i),
        (0, &|i| if i > 3.0 { i - 0.08 * (i - 3.0) } else { i + 0.1 }),
        (1, &|w| if w > 380.0 { 380.0 + 0.6 * (w - 380.0) } else { w }),
        (1, &|w| w + 12.0 * (w / 70.0).sin()),
    ];
    let friction = Some(("viscous_friction", 2e-5));
    let beside = [None; 5].into_iter().zip(forms).chain([(friction, forms[0])]);
    for (k, (effect, (input, shown))) in beside.enumerate() {
        let why = said(CURRENT, &testing::OUTPUTS, effect, (input, &|_, x| shown(x)));
        let why = why.unwrap_or_else(|| panic!("{k} {effect:?}"));
        assert!(why.reason.contains("not linear"), "{k} {effect:?}: {}", why.reason);
        assert_eq!(why.channel, ["current_A", "speed_rad_per_s"][input]);
    }
}

/// A zero and a gain that drift as the instrument warms up, or evenly; with the sizes at the end.
#[test]
fn a_drift_is_found() {
    let warm = |t: f64, tau: f64| 1.0 - (-t / tau).exp();
    for (input, zero, gain, tau, words) in [
        (0, 0.25, 0.0, 300.0, "zero of its sensor drifts"),
        (0, -0.3, 0.0, 1e5, "zero of its sensor drifts"),
        (0, 0.0, -0.12, 400.0, "gain of its instrument drifts"),
        (1, 0.0, 0.1, 600.0, "gain of its instrument drifts"),
    ] {
        let at_end = warm(1495.0, tau);
        let share = |t: f64| warm(t, tau) / at_end;
        let shown = |t: f64, x: f64| (x + zero * share(t)) * (1.0 + gain * share(t));
        let why = said(CURRENT, &testing::OUTPUTS, None, (input, &shown));
        let why = why.unwrap_or_else(|| panic!("{input} {zero} {gain} {tau}"));
        assert!(why.reason.contains(words), "{}", why.reason);
        let last = why.reason.split(" after 1495 s").next().unwrap().rsplit([',', '(']).next().unwrap();
        let last: f64 = last.trim().trim_end_matches(" A").parse().unwrap();
        let expected = if gain == 0.0 { -zero } else { 1.0 / (1.0 + gain) };
        assert!((last / expected - 1.0).abs() < 0.1, "{last} for {expected}: {}", why.reason);
    }
}

/// An ambient temperature that was typed in while the room moved; one that the room had.
#[test]
fn a_temperature_that_nobody_recorded_is_found() {
    for swing in [0.0, 3.0] {
        let mut experiment = testing::driven_by(CURRENT, &testing::OUTPUTS, PRIORS, true);
        let table = &mut experiment.runs[0].table;
        let typed = table.columns[3].clone();
        let room = typed.iter().zip(&table.time).map(|(x, t)| x + swing * (t / 400.0).sin());
        table.columns[3] = room.collect();
        testing::read_of(&mut experiment, |setup| setup.change(&setup.preset(), 0));
        experiment.runs[0].table.columns[3] = typed;
        let setup = Setup::new(&experiment, &[]).unwrap();
        let fitted = setup.fit(setup.preset(), &[0]).unwrap();
        let point = Linearization::new(&setup, fitted, &[0]).unwrap();
        let why = explains(&point, &places(&[0]), Explained::default()).unwrap();
        assert_eq!(why.is_some(), swing > 0.0, "{why:?}");
        assert!(
            why.is_none_or(|why| why.channel == "ambient_temperature_degC" && why.reason.contains("written"))
        );
    }
}

/// What depends on a driver by a law, or is another effect of the list, is no curve of an instrument.
#[test]
fn a_law_of_the_motor_is_no_curve() {
    for effect in
        [("contact_drop", 0.4), ("windage", 2e-8), ("iron_loss", 3e-4), ("torque_sensor_offset", 0.02)]
    {
        let why = said(CURRENT, &testing::OUTPUTS, Some(effect), (0, &|_, x| x));
        assert_eq!(why, None, "{effect:?}");
    }
}
