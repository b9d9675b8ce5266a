use super::*;
use crate::deadline::Deadline;
use crate::hypothesis::Addition;
use crate::selection::compete;
use crate::testing;
use physics::terms::{Driver, Drivers, GenericTerm, Law, Table};

/// Readings of a motor with a drag that saturates with the speed.
fn experiment() -> Experiment {
    let table = Table::new(Driver::Speed, &[0.0, 200.0, 500.0], &[0.0, 0.008, 0.009]).unwrap();
    testing::with_term(GenericTerm::new(Port::DragTorque, Law::Table(table)))
}

/// Wherever the deadline passes, in a fit, in a linearisation or in a search, there is an outcome.
#[test]
fn a_deadline_is_no_error() {
    let experiment = experiment();
    let mut cut = 0;
    for times in (0..18).map(|k| 1.6f64.powi(k) as usize).chain([usize::MAX]) {
        let setup = Setup::new(&experiment, &[]).unwrap().until(Deadline::asked(times));
        let outcome = closed(&setup, Options::default(), Instant::now(), &|_, _| ());
        assert!(outcome.is_ok(), "asked for {times} times: {:?}", outcome.err());
        cut += usize::from(outcome.is_ok_and(|outcome| outcome.is_cut));
    }
    assert_eq!(cut, 18);
}

/// The law that is found at the drag, before and after it is refined.
fn drag_found(of: impl Fn(f64) -> f64) -> [Addition; 2] {
    let x: Vec<f64> = (0..=24).map(|k| 25.0 * f64::from(k)).collect();
    let table = Table::new(Driver::Speed, &x, &x.iter().map(|x| of(*x)).collect::<Vec<f64>>()).unwrap();
    let experiment = testing::with_term(GenericTerm::new(Port::DragTorque, Law::Table(table)));
    let setup = Setup::new(&experiment, &[]).unwrap();
    let mut search = Search::new(&setup, setup.refit(&[0]).unwrap(), &[0]).unwrap();
    let table = search.scored[0].iter().find(|s| s.name == "drag_torque over speed").unwrap();
    let round = compete(&search.first, &setup.preset(), std::slice::from_ref(table), &Known::default());
    search.rounds.push(round);
    let found = |search: &Search| search.point().fitted.hypothesis.additions[0].clone();
    let before = found(&search);
    search.refine().unwrap();
    [before, found(&search)]
}

/// More than a period between seven points: the refined function follows it.
#[test]
fn a_function_is_refined_between_its_points() {
    let drag = |speed: f64| 5e-3 + 2e-3 * (speed / 45.0).sin();
    let found = drag_found(drag);
    let worst = |law: &Addition| {
        let term = law.term().unwrap();
        let off = |speed: f64| term.value(&Drivers { speed, ..Drivers::default() }) - drag(speed);
        let level = off(300.0);
        (12..=46).map(|k| (off(10.0 * f64::from(k)) - level).abs()).fold(0.0, f64::max)
    };
    let ([few, many], [before, after]) = (found.each_ref().map(Addition::sizes), found.each_ref().map(worst));
    assert!(few < many && before > 2e-4 && after < 0.5 * before, "{few} {many}: {before} {after}");
}

/// In data that were not checked nothing is looked for; the declared parameters are fitted.
#[test]
fn unchecked_data_are_fitted_only() {
    let experiment = experiment();
    let closed =
        |extent| run(&experiment, &[], Options { extent, ..Options::default() }, &|_, _| ()).unwrap();
    let [found, unchecked, fitted] = [Extent::Search, Extent::Unchecked, Extent::Fit].map(closed);
    assert!(!found.effects.is_empty() && !found.is_cut);
    assert!(unchecked.effects.is_empty() && unchecked.is_cut && unchecked.verdict == Verdict::Nothing);
    assert!(fitted.effects.is_empty() && !fitted.is_cut && fitted.verdict == Verdict::Fitted);
    let values = |outcome: &Outcome| outcome.parameters.iter().map(|p| p.value).collect::<Vec<f64>>();
    assert_eq!(values(&unchecked), values(&fitted));
}
