use super::*;
use crate::testing;
use physics::terms::{Driver, GenericTerm, Law, Table};

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
