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
    (of_fit, with.explains(&before).0, with.delta_validation(&before))
}

#[test]
fn a_validation_run_with_the_effect_confirms_it() {
    let (of_fit, of_all, of_validation) = explained(&experiment(Role::Validate, |_| ()));
    let of_validation = of_validation.unwrap();
    assert!(of_fit > NEAR && of_validation > NEAR, "{of_fit} {of_validation}");
    assert!((of_all - of_fit - of_validation).abs() < 1e-6 * of_all, "{of_all} {of_fit} {of_validation}");
}

/// The zero of a thermometer may differ in each run: a validation run with a moved thermometer lowers -2 ln p of an offset in all runs by
/// less than a tenth of the decrease of chi square.
#[test]
fn a_moved_thermometer_hardly_confirms_an_offset() {
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
    let of_validation = with.delta_validation(&without).unwrap();
    assert!(fall > 200.0 && of_validation < 0.1 * fall, "{fall} {of_validation}");
}

#[test]
fn a_validation_run_without_the_effect_refutes_it() {
    let without = |experiment: &mut Experiment| {
        let preset = Setup::new(experiment, &[]).unwrap().preset().declared;
        testing::read(experiment, &preset, None);
    };
    let (of_fit, of_all, of_validation) = explained(&experiment(Role::Validate, without));
    assert!(
        of_fit > NEAR && of_validation.unwrap() < -NEAR && of_all < of_fit,
        "{of_fit} {of_all} {of_validation:?}"
    );
}

/// Test data have no influence on a choice.
#[test]
fn without_validation_runs_the_fit_runs_decide() {
    let (of_fit, of_all, of_validation) = explained(&experiment(Role::Test, |_| ()));
    assert!(of_validation.is_none() && of_all == of_fit);
}
