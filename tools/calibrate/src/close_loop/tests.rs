use super::*;
use crate::deadline::Deadline;
use crate::hypothesis::Addition;
use crate::selection::compete;
use crate::testing;
use physics::terms::{Driver, Drivers, Factor, GenericTerm, Lag, Law, Product, Table};

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

/// The law that is found at the drag among the candidates that are selected, before and after it is refined.
fn drag_found(term: GenericTerm, is_tried: impl Fn(&Scored) -> bool) -> [Addition; 2] {
    let experiment = testing::with_term(term);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let mut search = Search::new(&setup, setup.refit(&[0]).unwrap(), &[0]).unwrap();
    let tried: Vec<Scored> = search.scored[0].iter().filter(|s| is_tried(s)).cloned().collect();
    let round = compete(&search.first, &setup.preset(), &tried, &Known::default());
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
    let x: Vec<f64> = (0..=24).map(|k| 25.0 * f64::from(k)).collect();
    let table = Table::new(Driver::Speed, &x, &x.iter().map(|x| drag(*x)).collect::<Vec<f64>>()).unwrap();
    let term = GenericTerm::new(Port::DragTorque, Law::Table(table));
    let found = drag_found(term, |s| s.name == "drag_torque over speed");
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

/// A law of the speed beyond that of the fit run: with a test run it is finally estimated from the faster validation run too, and so predicts
/// the test run; without one the validation run alone judges it, and it ends where the fit run does.
#[test]
fn a_law_is_finally_estimated_from_all_runs_but_those_that_test_it() {
    let x: Vec<f64> = (0..=20).map(|k| 30.0 * f64::from(k)).collect();
    let change: Vec<f64> = x.iter().map(|x| -0.05 * (1.0 - (-(x / 250.0).powi(2)).exp())).collect();
    let table = Law::Table(Table::new(Driver::Speed, &x, &change).unwrap());
    let term = GenericTerm::new(Port::TorqueConstant, table);
    let of = |last: Role| {
        let mut experiment =
            testing::driven_by(("current_A", 1.0, 190.0), &testing::OUTPUTS, testing::PRIORS, true);
        for (file, role, factor) in [("faster.csv", Role::Validate, 1.0), ("last.csv", last, 0.95)] {
            let mut run = experiment.runs[0].clone();
            (run.file, run.role) = (file.to_string(), role);
            run.table.columns[1].iter_mut().for_each(|speed| *speed *= factor);
            experiment.runs.push(run);
        }
        experiment.runs[0].table.columns[1].iter_mut().for_each(|speed| *speed *= 0.6);
        let preset = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &preset, Some(term));
        let found = run(&experiment, &[], Options::default(), &|_, _| ()).unwrap();
        let law = found.effects.iter().find(|e| e.port == Port::TorqueConstant).unwrap().term.unwrap();
        let (_, range) = law.law.ranges().next().unwrap();
        let torque = |e: &&crate::outcome::ChannelError| e.role == last && e.column == "shaft_torque_Nm";
        let error = found.errors.iter().find(torque).unwrap().after;
        let is_said = found.notes.iter().any(|note| note.contains("fit and validation runs together"));
        (range.1, error, is_said)
    };
    let [(far, small, is_joint), (near, large, is_of_all)] = [Role::Test, Role::Validate].map(of);
    assert!(is_joint && !is_of_all && near < 301.0 && far > 495.0, "{near} {far}");
    assert!(small < 0.5 * large, "{small} {large}");
}

/// A drag in proportion to a lag of the speed is a linear system, which has no range; one that grows with its square has that of the data.
#[test]
fn a_term_in_proportion_to_a_lag_has_no_range() {
    for exponent in [1.0, 2.0] {
        let factor = Factor {
            driver: Driver::Speed,
            offset: 0.0,
            reference: 300.0,
            exponent,
            range: Factor::UNLIMITED,
        };
        let law = Law::Product(Product { coefficient: -4e-3, factors: [Some(factor), None, None] });
        let lag = Lag { driver: Driver::Speed, tau: 250.0, difference: false };
        let is_power = |s: &Scored| s.name.starts_with("drag_torque ~ lag of speed");
        let [before, after] =
            drag_found(GenericTerm { port: Port::DragTorque, law, lag: Some(lag) }, is_power);
        let end = |own: &Addition| own.term().unwrap().law.ranges().map(|(_, (_, end))| end).next().unwrap();
        assert!(
            end(&before).is_finite() && end(&after).is_infinite() == (exponent == 1.0),
            "{before:?} {after:?}"
        );
        let term = after.term().unwrap();
        assert!((term.lag.unwrap().tau / 250.0 - 1.0).abs() < 0.02, "{term:?}");
    }
}
