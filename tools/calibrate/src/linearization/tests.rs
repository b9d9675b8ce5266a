use super::*;
use crate::experiment::Experiment;
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

/// The zero of a thermometer may differ in each run: it does not count against the effect.
#[test]
fn a_moved_thermometer_is_not_held_against_an_effect() {
    let moved = |experiment: &mut Experiment| {
        let winding = experiment.inputs.len() + 2;
        experiment.runs[0].table.columns[winding].iter_mut().for_each(|x| *x += testing::NOISE);
    };
    let [exact, moved] =
        [explained(&experiment(Role::Validate, |_| ())), explained(&experiment(Role::Validate, moved))]
            .map(|(_, _, foretold)| foretold.unwrap());
    assert!((moved / exact - 1.0).abs() < 0.02, "{moved} {exact}");
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
