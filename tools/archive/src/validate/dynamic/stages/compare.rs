//! Comparison of the trajectories of Model Exchange and Co-Simulation.
//!
//! The integration of Co-Simulation may be coarse: explicit Euler at the declared step is common and not a fault. A finding is a
//! difference that neither decreases with the communication step nor has the shape of the error of Euler's method.

use super::*;
/// Tolerance relative to the range of a variable; a loose tolerance of the default experiment may excuse more.
const TOLERATED: f64 = 0.005;
/// Tolerance relative to the nominal value, and to the largest range in the same unit.
const SMALLEST: f64 = 1e-6;
/// Allowed remainder of a difference after subtraction of the error of Euler's method.
const LIKENESS: f64 = 0.15;
/// Parts of the default experiment for the second, coarser comparison.
const PARTS: usize = 50;

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let Some(interface) = facts.interface(InterfaceType::CoSimulation).filter(|i| !i.needs_execution_tool)
    else {
        return Ok(());
    };
    let Ok(binary) = RawBinary::load(subject.archive, &interface.model_identifier) else { return Ok(()) };
    let (place, base, pool) = (subject.place.clone(), Default::default(), Default::default());
    let other = Subject { interface, binary, place, base, pool, ..*subject };
    let watched = facts
        .select(|v| v.is_continuous() && v.size == 1 && !v.clocked && !v.is("input") && !v.is("independent"));
    let h = facts.step().max(interface.fixed_internal_step_size.unwrap_or(0.0));
    let mut looks = vec![(h, steps(facts))];
    let slow = facts.stop.map_or(0.0, |stop| (stop - facts.start) / PARTS as f64);
    if slow > 3.0 * h && interface.can_handle_variable_step {
        looks.push(((slow / h).floor() * h, PARTS));
    }
    let settings = &subject.base()?.settings;
    for (h, n) in looks {
        if let Some((v, t, a, b)) = differs(subject, &other, &Course { settings, watched: &watched, h, n })? {
            seen.add(&v.place, rules::exchange_differs(v, a, t, b));
            return Ok(());
        }
    }
    Ok(())
}

/// Settings, watched variables, step and number of rows of a comparison.
struct Course<'s, 'a> {
    settings: &'s Settings<'a>,
    watched: &'s [&'a Variable],
    h: f64,
    n: usize,
}

type Place<'a> = (&'a Variable, f64, f64, f64);

fn differs<'a>(
    subject: &Subject<'a>,
    other: &Subject<'a>,
    course: &Course<'_, 'a>,
) -> Result<Option<Place<'a>>, Fault> {
    let Course { settings, watched, h, n } = *course;
    let reference = integrate(subject, course)?;
    // A Co-Simulation FMU that rejects these values is checked by another stage.
    let stepped = |parts: usize| -> Result<Rows, Fault> {
        let rows = runs::stepped(&mut other.started(settings)?, watched, h, n * parts, parts)?;
        Ok(rows.into_iter().step_by(parts).collect())
    };
    let Ok(coarse) = stepped(1) else { return Ok(None) };
    let rows = reference.len().min(coarse.len());
    let sizes: Vec<(f64, f64)> = (0..watched.len())
        .map(|i| {
            let column = || reference[..rows].iter().map(|r| r[i]);
            let (low, high) =
                (column().fold(f64::INFINITY, f64::min), column().fold(f64::NEG_INFINITY, f64::max));
            (high - low, high.abs().max(low.abs()))
        })
        .collect();
    let of_unit = largest_of_unit(watched.iter().copied().zip(sizes.iter().map(|(range, _)| *range)));
    let scale: Vec<f64> = watched
        .iter()
        .zip(&sizes)
        .map(|(v, (range, size))| {
            // Differences below 1e-6 of the nominal value are ignored, and of what varies most in its unit: it may be the balance of others.
            let least = v.nominal.max(of_unit(v));
            // A nearly constant variable is compared relative to its magnitude.
            range.max(1e-4 * size).max(SMALLEST / TOLERATED * least)
        })
        .collect();
    let error = |rows_of: &Rows, i: usize| {
        reference.iter().zip(rows_of).map(|(a, b)| (a[i] - b[i]).abs() / scale[i]).fold(0.0, f64::max)
    };
    let tolerated = TOLERATED.max(solver_error(subject.facts));
    let suspects: Vec<usize> = (0..watched.len()).filter(|i| error(&coarse, *i) > tolerated).collect();
    if suspects.is_empty() {
        return Ok(None);
    }
    let is_free =
        other.interface.can_handle_variable_step && other.interface.fixed_internal_step_size.is_none();
    let fine = is_free.then(|| stepped(4).ok()).flatten();
    let euler = euler(subject, course)?;
    for i in suspects {
        let first = error(&coarse, i);
        let converges = fine.as_ref().is_some_and(|f| error(f, i) < (0.6 * first).max(tolerated));
        let is_coarse = is_like_euler(&reference, &coarse, &euler, i);
        if !converges && !is_coarse {
            let worst = (0..rows).max_by(|a, b| {
                let e = |k: usize| (reference[k][i] - coarse[k][i]).abs();
                e(*a).total_cmp(&e(*b))
            });
            let k = worst.unwrap_or(0);
            let t = subject.facts.start + h * k as f64;
            return Ok(Some((watched[i], t, reference[k][i], coarse[k][i])));
        }
    }
    Ok(None)
}

/// Whether the difference from the reference has the shape of the error of a first-order method (explicit or implicit Euler with
/// any step).
fn is_like_euler(reference: &Rows, coarse: &Rows, euler: &Rows, i: usize) -> bool {
    let n = reference.len().min(coarse.len()).min(euler.len());
    let pairs: Vec<(f64, f64)> =
        (0..n).map(|k| (coarse[k][i] - reference[k][i], euler[k][i] - reference[k][i])).collect();
    let (both, alone): (f64, f64) = pairs.iter().fold((0.0, 0.0), |s, (a, b)| (s.0 + a * b, s.1 + b * b));
    let factor = both / alone;
    let left = pairs.iter().map(|(a, b)| (a - factor * b).abs()).fold(0.0, f64::max);
    let all = pairs.iter().map(|(a, _)| a.abs()).fold(0.0, f64::max);
    factor.is_finite() && factor.abs() < 2.0 && left < LIKENESS * all
}

/// Rows at multiples of `h` up to the first event.
fn integrate(subject: &Subject, course: &Course) -> Result<Rows, Fault> {
    let Course { settings, watched, h, n } = *course;
    let mut session = subject.started(settings)?;
    let mut solver = Solver::new(&mut session, 1e-8)?;
    let mut rows = vec![session.get_all(watched)?];
    for k in 1..=n {
        let end = subject.facts.start + h * k as f64;
        if solver.advance(&mut session, end, false)? != Reached::End {
            break;
        }
        rows.push(session.get_all(watched)?);
    }
    Ok(rows)
}

/// Rows of explicit Euler at the step that Co-Simulation can be expected to use.
fn euler(subject: &Subject, course: &Course) -> Result<Rows, Fault> {
    let Course { settings, watched, h, n } = *course;
    let facts = subject.facts;
    let internal = facts
        .interface(InterfaceType::CoSimulation)
        .and_then(|i| i.fixed_internal_step_size)
        .unwrap_or(facts.step())
        .min(h);
    let parts = (h / internal).round().clamp(1.0, 10_000.0) as usize;
    let mut session = subject.started(settings)?;
    let mut x = Solver::new(&mut session, 1e-6)?.x;
    let mut rows = vec![session.get_all(watched)?];
    for k in 1..=n * parts {
        let (t, dt) = (session.now, h / parts as f64);
        let Ok(rates) = Solver::rates(&mut session, t, &x) else { break };
        x.iter_mut().zip(&rates).for_each(|(x, d)| *x += dt * d);
        if Solver::rates(&mut session, facts.start + dt * k as f64, &x).is_err() {
            break;
        }
        if k % parts == 0 {
            rows.push(session.get_all(watched)?);
        }
    }
    Ok(rows)
}
