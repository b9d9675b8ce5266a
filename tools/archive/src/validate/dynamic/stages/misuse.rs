//! Invalid calls: a wrong token, NaN, values outside their limits, unknown value references.

use super::*;
/// A token of no FMU.
const FOREIGN: &str = "{00000000-0000-4000-8000-000000000000}";

pub(super) fn token(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    if subject.facts.token == FOREIGN {
        return Ok(());
    }
    if subject.try_instance("probe", FOREIGN, &Log::new()).is_some() {
        let word = subject.facts.pick("GUID", "instantiation token");
        seen.add(&subject.interface.place(), rules::token_unchecked(word, FOREIGN));
    }
    Ok(())
}

/// NaN, infinity and values outside min and max, into each kind of variable that has them, one instance each.
pub(super) fn values(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let float = |v: &&Variable| v.kind.is_float() && v.is_free();
    let first = |causality: &str| facts.variables.iter().filter(float).find(|v| v.is(causality));
    let targets: Vec<&Variable> = [first("input"), first("parameter")].into_iter().flatten().collect();
    for v in targets {
        for bad in [f64::NAN, f64::INFINITY] {
            if accepts(subject, v, bad)? {
                seen.add(&v.place, rules::nan_accepted(v, bad));
                break;
            }
        }
    }
    let limited = facts.variables.iter().filter(|v| v.kind.is_numeric() && v.is_free());
    for v in limited.take(200) {
        let beyond = |limit: f64, sign: f64| {
            limit + sign * if v.kind.is_float() { v.nominal.max(limit.abs()) } else { 1.0 }
        };
        let bad = v.max.map(|m| beyond(m, 1.0)).or_else(|| v.min.map(|m| beyond(m, -1.0)));
        // Unsigned types cannot hold what is below zero.
        let Some(bad) = bad.filter(|b| b.is_finite() && (v.kind.is_float() || (0.0..=1e6).contains(b)))
        else {
            continue;
        };
        if accepts(subject, v, bad)? {
            seen.add(&v.place, rules::range_unchecked(v, bad, v.limits()));
            break;
        }
    }
    Ok(())
}

/// Whether a value is accepted with status OK, including the following step.
fn accepts(subject: &Subject, v: &Variable, bad: f64) -> Result<bool, Fault> {
    let mut session = subject.instance("probe")?;
    let set = |session: &mut Session| session.raw.set(v.kind, &[v.reference], &vec![bad; v.size]);
    session.setup(None)?;
    let before = if v.is("input") { Status::Ok } else { set(&mut session) };
    if before > Status::Ok
        || session.enter(None).is_err()
        || v.is("input") && set(&mut session) > Status::Ok
        || session.leave().is_err()
    {
        return Ok(false);
    }
    match subject.interface.kind {
        InterfaceType::CoSimulation => {
            Ok(session.raw.do_step(session.now, subject.facts.step(), false).status == Status::Ok)
        }
        _ => Ok(session.raw.get_derivatives(&mut vec![0.0; subject.facts.state_count()]) == Status::Ok),
    }
}

/// Access to unknown value references, and setting of constants, must return Error.
pub(super) fn references(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let mut session = subject.started(&Vec::new())?;
    let highest = facts.variables.iter().map(|v| v.reference).max().unwrap_or(0);
    // Far outside the limits, and just outside.
    for reference in [u32::MAX - 1, highest.saturating_add(1000)] {
        let mut value = [0.0];
        if session.raw.get(Kind::Float64, &[reference], &mut value) <= Status::Warning {
            seen.add(&subject.interface.place(), rules::reference_unchecked(reference, value[0]));
            break;
        }
        drop(session);
        session = subject.started(&Vec::new())?;
    }
    drop(session);
    let constant = facts
        .variables
        .iter()
        .find(|v| v.variability == "constant" && v.kind.is_numeric() && v.start.len() == v.size);
    if let Some(v) = constant {
        let mut session = subject.instance("probe")?;
        let other: Vec<f64> = v.start.iter().map(|x| x + 1.0).collect();
        if session.raw.set(v.kind, &[v.reference], &other) <= Status::Warning {
            seen.add(&v.place, rules::constant_settable(v));
        }
    }
    Ok(())
}
