//! Co-Simulation: convergence with the communication step, and the end at the stop time.

use super::*;
use std::collections::HashMap;

/// Differences below this fraction of a variable's range are attributed to the solver.
const TOLERATED: f64 = 0.05;
/// Differences below this fraction of the nominal value are ignored.
const SMALLEST: f64 = 1e-7;

/// End values with steps of h, h/2 and h/4: a difference that does not decrease is not a discretisation error.
pub(super) fn size(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let base = subject.base()?;
    let watched = facts.select(|v| v.is_continuous() && v.size == 1 && !v.clocked && !v.is("input"));
    let coarse = facts.step().max(subject.interface.fixed_internal_step_size.unwrap_or(0.0));
    let end = steps(facts);
    let mut movement = vec![0.0_f64; watched.len()];
    let mut run = |parts: usize| -> Result<Option<Vec<f64>>, Fault> {
        let mut session = subject.started(&base.settings)?;
        let mut rows = runs::stepped(&mut session, &watched, coarse, end * parts, parts)?;
        for (i, m) in movement.iter_mut().enumerate() {
            *m = rows.iter().map(|row| (row[i] - rows[0][i]).abs()).fold(*m, f64::max);
        }
        Ok(rows.pop().filter(|_| rows.len() == end * parts))
    };
    let (Some(one), Some(two)) = (run(1)?, run(2)?) else { return Ok(()) };
    // A fixed internal step cannot be cut in four.
    let four = if subject.interface.fixed_internal_step_size.is_none() { run(4)? } else { None };
    let mut steady_of: HashMap<*const Variable, bool> = HashMap::new();
    let mut at = 0;
    for v in facts.variables.iter().filter(|v| observed(v)) {
        steady_of.insert(v, base.steady[at]);
        at += v.size;
    }
    for (i, v) in watched.iter().enumerate() {
        let first = (one[i] - two[i]).abs();
        let second = four.as_ref().map_or(first, |f| (two[i] - f[i]).abs());
        let steady = steady_of.get(&std::ptr::from_ref(*v)).copied().unwrap_or(false);
        // Rounding errors of balances and remainders do not converge either.
        let matters = first.min(second) > (TOLERATED * movement[i]).max(SMALLEST * v.nominal);
        if steady && matters && second > 0.75 * first {
            seen.add(
                &v.place,
                rules::step_size(v, one[i], facts.start + coarse * end as f64, coarse, two[i]),
            );
            return Ok(());
        }
    }
    Ok(())
}

/// A step that begins after the stop time of the experiment is an error.
pub(super) fn stop_time(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let h = subject.facts.step();
    let stop = subject.facts.start + 2.0 * h;
    let mut session = subject.instance("probe")?;
    session.setup(Some(stop))?;
    session.initialise(Some(stop), &Vec::new())?;
    for _ in 0..2 {
        if !session.step(h)? {
            return Ok(());
        }
    }
    let mut now = stop;
    for _ in 0..3 {
        if session.raw.do_step(now, h, false).status > Status::Warning {
            return Ok(());
        }
        now += h;
    }
    let (function, status) = (subject.facts.function("DoStep"), Status::Error);
    seen.add(&subject.interface.place(), rules::stop_time(function, now, stop, status));
    Ok(())
}
