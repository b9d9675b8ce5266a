use super::*;
use crate::experiment::Experiment;
use crate::hypothesis::Hypothesis;
use crate::search::search;
use crate::selection::NEAR;
use crate::testing;
use physics::terms::{GenericTerm, Law, Table};

/// A motor with a drag that saturates with the speed in its fit run, and a further run in another role.
fn experiment(role: Role, further: impl Fn(&mut Experiment)) -> Experiment {
    let table = Table::new(Driver::Speed, &[0.0, 200.0, 500.0], &[0.0, 0.008, 0.009]).unwrap();
    let mut experiment = testing::with_term(GenericTerm::new(Port::DragTorque, Law::Table(table)));
    let fitted = experiment.runs[0].clone();
    further(&mut experiment);
    let other = crate::experiment::Run { role, file: "other.csv".to_string(), ..experiment.runs[0].clone() };
    experiment.runs = vec![fitted, other];
    experiment
}

/// Decrease of -2 ln p by the best law over the fit run alone, over all runs, and the part of the further run.
fn explained(experiment: &Experiment) -> (f64, f64, Option<f64>) {
    let setup = Setup::new(experiment, &[]).unwrap();
    let before = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
    let mut hypothesis = before.fitted.hypothesis.clone();
    hypothesis.additions.extend(search(&before).into_iter().find_map(|s| s.addition));
    assert_eq!(hypothesis.additions[0].port, Port::DragTorque);
    let with = Linearization::judged(&setup, setup.fit(hypothesis, &[0]).unwrap(), &[0]).unwrap();
    let of_fit = before.evidence.cost().0 - with.evidence.cost().0;
    (of_fit, with.explains(&before).0, with.foretells(&before))
}

#[test]
fn a_validation_run_with_the_effect_foretells_it() {
    let (of_fit, of_all, foretold) = explained(&experiment(Role::Validate, |_| ()));
    let foretold = foretold.unwrap();
    assert!(of_fit > NEAR && foretold > NEAR, "{of_fit} {foretold}");
    assert!((of_all - of_fit - foretold).abs() < 1e-6 * of_all, "{of_all} {of_fit} {foretold}");
}

/// The zero of a thermometer may differ in each run: a validation run with a moved thermometer speaks for an offset in all runs with less than a
/// tenth of the weight of its readings.
#[test]
fn a_moved_thermometer_hardly_foretells_an_offset() {
    let experiment = experiment(Role::Validate, |experiment| {
        let winding = experiment.inputs.len() + 2;
        experiment.runs[0].table.columns[winding].iter_mut().for_each(|x| *x += testing::NOISE);
    });
    let setup = Setup::new(&experiment, &[]).unwrap();
    let before = Linearization::new(&setup, setup.fit(setup.preset(), &[0]).unwrap(), &[0]).unwrap();
    let mut hypothesis = before.fitted.hypothesis.clone();
    hypothesis.additions.extend(search(&before).into_iter().find_map(|s| s.addition));
    let fitted = setup.fit(hypothesis, &[0]).unwrap();
    let mut hypothesis = fitted.hypothesis.clone();
    let offset = testing::addition(&setup, "winding_sensor_offset", testing::NOISE);
    hypothesis.additions.push(Addition { active: vec![true; 2], ..offset });
    let error = |hypothesis: &Hypothesis| setup.chi_square(&[1], &setup.show(hypothesis, &[1]).unwrap()).0;
    let fall = error(&fitted.hypothesis) - error(&hypothesis);
    let without = Linearization::judged(&setup, fitted, &[0]).unwrap();
    let with = Linearization::judged(&setup, setup.judged(hypothesis, &[0]).unwrap(), &[0]).unwrap();
    let foretold = with.foretells(&without).unwrap();
    assert!(fall > 200.0 && foretold < 0.1 * fall, "{fall} {foretold}");
}

#[test]
fn a_validation_run_without_the_effect_refutes_it() {
    let without = |experiment: &mut Experiment| {
        let preset = Setup::new(experiment, &[]).unwrap().preset().declared;
        testing::read(experiment, &preset, None);
    };
    let (of_fit, of_all, foretold) = explained(&experiment(Role::Validate, without));
    assert!(of_fit > NEAR && foretold.unwrap() < -NEAR && of_all < of_fit, "{of_fit} {of_all} {foretold:?}");
}

/// Test data have no influence on a choice.
#[test]
fn without_validation_runs_the_fit_runs_decide() {
    let (of_fit, of_all, foretold) = explained(&experiment(Role::Test, |_| ()));
    assert!(foretold.is_none() && of_all == of_fit);
}
