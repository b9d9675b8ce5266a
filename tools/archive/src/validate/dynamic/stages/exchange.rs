//! Model Exchange: the vectors of states, derivatives, nominals and event indicators.

use super::*;
/// Equal up to the tolerance of an iterative solver in the FMU.
const CLOSE: f64 = 1e-6;

fn close(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= CLOSE * a.abs().max(b.abs())
}

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let mut session = subject.started(&subject.base()?.settings)?;
    let n = facts.state_count();
    if facts.version == FmiVersion::V3 {
        let numbers = session.raw.numbers();
        let numbers = numbers.or_else(|s| session.ok("GetNumberOfContinuousStates", s).map(|()| (0, 0)))?;
        if numbers != (n, facts.indicators) {
            return Fault::new(
                &subject.interface.place(),
                rules::states_number(numbers.0, numbers.1, n, facts.indicators),
            );
        }
    }
    let mut x = vec![0.0; n];
    if n > 0 {
        session.call("GetContinuousStates", |raw| raw.get_states(&mut x))?;
        nominals(&mut session, n, seen)?;
        // Away from the start, where the values are not all zero.
        let moved: Vec<f64> = x.iter().map(|x| x + 1e-3 * x.abs().max(1e-3)).collect();
        vectors(&mut session, &moved, seen)?;
        memory(&mut session, &x, &moved, seen)?;
    }
    drop(session);
    jumps(subject, seen)?;
    reinit(subject, seen)
}

/// Events of a run that are watched.
const EVENTS: usize = 20;

/// States that change at events have the attribute reinit.
fn reinit(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    if facts.state_count() == 0 || facts.states.iter().all(|i| facts.variables[*i].reinit) {
        return Ok(());
    }
    let mut session = subject.started(&subject.base()?.settings)?;
    let mut solver = Solver::new(&mut session, 1e-6)?;
    let end = facts.stop.unwrap_or(facts.start + 100.0 * facts.step());
    for _ in 0..EVENTS {
        if solver.advance(&mut session, end, false)? != Reached::Event {
            return Ok(());
        }
        let (t, before) = (session.now, solver.x.clone());
        solver.handle_event(&mut session)?;
        let mut at = 0;
        for v in facts.states.iter().map(|i| &facts.variables[*i]) {
            let changed = (at..at + v.size).find(|i| !close(before[*i], solver.x[*i]));
            at += v.size;
            if let Some(i) = changed.filter(|_| !v.reinit) {
                seen.add(&v.place, rules::reinit_undeclared(v, before[i], solver.x[i], t));
            }
        }
    }
    Ok(())
}

fn nominals(session: &mut Session, n: usize, seen: &mut Seen) -> Result<(), Fault> {
    let mut nominals = vec![0.0; n];
    session.call("GetNominalsOfContinuousStates", |raw| raw.get_nominals(&mut nominals))?;
    if let Some(i) = nominals.iter().position(|x| !(*x > 0.0 && x.is_finite())) {
        seen.add(&session.interface.place(), rules::nominal_value(i + 1, n, nominals[i]));
    }
    Ok(())
}

/// Vectors and variables have the same values, in the order of the model structure.
fn vectors(session: &mut Session, x: &[f64], seen: &mut Seen) -> Result<(), Fault> {
    let facts = session.facts;
    let t = session.now;
    let rates = Solver::rates(session, t, x)?;
    let mut back = vec![0.0; x.len()];
    session.call("GetContinuousStates", |raw| raw.get_states(&mut back))?;
    if let Some(i) = x.iter().zip(&back).position(|(a, b)| !close(*a, *b)) {
        seen.add(&session.interface.place(), rules::states_kept(i + 1, x[i], back[i]));
    }
    let derivatives: Vec<usize> = facts.derivatives.iter().map(|e| e.variable).collect();
    for (list, vector, what) in [(&facts.states, &back, "state"), (&derivatives, &rates, "derivative")] {
        let mut at = 0;
        for v in list.iter().map(|i| &facts.variables[*i]) {
            let values = session.get(v)?;
            let wanted = &vector[at..at + v.size];
            at += v.size;
            if let Some((a, b)) = values.iter().zip(wanted).find(|(a, b)| !close(**a, **b)) {
                seen.add(&v.place, rules::states_order(v, a, what, b));
                return Ok(());
            }
        }
    }
    Ok(())
}

/// Derivatives are a function of time and states: the same arguments give the same values.
fn memory(session: &mut Session, x: &[f64], moved: &[f64], seen: &mut Seen) -> Result<(), Fault> {
    let t = session.now;
    let first = Solver::rates(session, t, x)?;
    let later = t + session.facts.step();
    Solver::rates(session, later, moved)?;
    let second = Solver::rates(session, t, x)?;
    if let Some(i) = first.iter().zip(&second).position(|(a, b)| !close(*a, *b)) {
        let v = session.facts.derivatives.get(i).map(|e| &session.facts.variables[e.variable]);
        let place = v.map_or_else(|| session.interface.place(), |v| v.place.clone());
        seen.add(&place, rules::evaluation_memory(i + 1, first.len(), first[i], second[i]));
    }
    Ok(())
}

/// An event indicator passes continuously through zero when it changes its sign.
fn jumps(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    if facts.indicators == 0 {
        return Ok(());
    }
    let mut session = subject.started(&subject.base()?.settings)?;
    let mut solver = Solver::new(&mut session, 1e-6)?;
    let end = facts.stop.unwrap_or(facts.start + 100.0 * facts.step());
    for _ in 0..20_000 {
        let (t, x) = (session.now, solver.x.clone());
        let before = indicators(&mut session, facts.indicators)?;
        if t >= end || session.next.is_some_and(|next| t >= next) {
            return Ok(());
        }
        let target = session.next.map_or(end, |next| next.min(end));
        if solver.one_step(&mut session, target)?.is_none() {
            return Ok(());
        }
        let (t1, x1) = (session.now, solver.x.clone());
        let after = indicators(&mut session, facts.indicators)?;
        let crossing = (0..facts.indicators).find(|i| (before[*i] > 0.0) != (after[*i] > 0.0));
        let Some(i) = crossing else { continue };
        // Between the two ends of the step the indicator is evaluated on linearly interpolated states.
        let (mut low, mut high) = ((0.0, before[i]), (1.0, after[i]));
        for _ in 0..50 {
            let middle = 0.5 * (low.0 + high.0);
            let state: Vec<f64> = x.iter().zip(&x1).map(|(a, b)| a + middle * (b - a)).collect();
            Solver::rates(&mut session, t + middle * (t1 - t), &state)?;
            let z = indicators(&mut session, facts.indicators)?[i];
            if (z > 0.0) == (low.1 > 0.0) { low = (middle, z) } else { high = (middle, z) }
        }
        let jump = (high.1 - low.1).abs();
        if jump > 1e-3 * (before[i] - after[i]).abs() {
            seen.add(
                &subject.interface.place(),
                rules::indicator_jumps(i + 1, facts.indicators, low.1, high.1, t + low.0 * (t1 - t)),
            );
        }
        return Ok(());
    }
    Ok(())
}
