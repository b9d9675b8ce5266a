//! Derivatives from the FMU compared with differences of its values.

use super::*;
/// Relative tolerance of a derivative.
const SHARE: f64 = 0.01;
/// The derivative of a fast variable at rest is a difference of large numbers; below this fraction of its largest value
/// it is not compared.
const STIFF: f64 = 1e-3;
/// Parts of the default experiment for the second, coarser comparison.
const PARTS: usize = 200;
/// Parts of a step for a finer comparison, where the FMU takes shorter steps.
const FINER: usize = 32;
/// Steps over which derivatives are averaged, so that oscillations cancel.
const WINDOW: usize = 4;
/// Ratio of the step of a comparison to that of a second one, which a disagreement has to survive: an oscillation within a step, such as that of
/// a commutation, may be at the same phase after each of the one, and then not of the other. The golden ratio is farthest from fractions.
const OTHER: f64 = 0.618_033_988_749_895;
/// Number of shorter steps, each by [`FINER`], with which a disagreement is compared again, and number of steps of each: a variable may jump
/// within the others, as the resistance of the conducting phases does at each commutation, and its derivative does not show that.
const SHORTER: (i32, usize) = (4, 4 * WINDOW);
/// Orders of output derivatives that are tried.
const HIGHEST: i32 = 10;

/// A variable and its derivative from the FMU at equidistant times.
#[derive(Clone, Default)]
struct Series {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Series {
    fn push(&mut self, value: f64, slope: f64) {
        self.values.push(value);
        self.slopes.push(slope);
    }

    /// The first disagreement (number of its first point, mean derivative of the FMU, mean difference quotient), if nearly
    /// all significant windows disagree. An event spoils some of them; a wrong derivative is always wrong.
    /// `least` is the smallest derivative that can be compared, `noise` the error that a step may add to a value.
    fn disagrees(&self, look: &Look, least: f64, noise: impl Fn(f64) -> f64) -> Option<(usize, f64, f64)> {
        let (mut informative, mut example) = (0, None);
        let mut factors: Vec<f64> = Vec::new();
        let steps = WINDOW as f64;
        for k in 0..self.values.len().saturating_sub(WINDOW) {
            let pairs = || self.slopes[k..=k + WINDOW].windows(2).map(|d| (d[0], d[1]));
            let given = pairs().map(|(a, b)| 0.5 * (a + b)).sum::<f64>() / steps;
            let measured = (self.values[k + WINDOW] - self.values[k]) / (look.h * steps);
            // A step may use the derivative at its beginning or at its end.
            let swing = pairs().map(|(a, b)| (b - a).abs()).sum::<f64>() / steps;
            // Error control is that of single steps: each one adds an error of its own.
            let room = 0.6 * swing + least + noise(self.values[k]) / look.h;
            let size = given.abs().max(measured.abs());
            // NaN is always an error.
            if size == 0.0 || room > 0.5 * size || jumps(&self.values[k..=k + WINDOW]) {
                continue;
            }
            informative += 1;
            if given.is_nan() || (given - measured).abs() > SHARE * size + room {
                factors.push(given / measured);
                example.get_or_insert((k, given, measured));
            }
        }
        let wrong = factors.len() >= 3 && 10 * factors.len() >= 8 * informative;
        example.filter(|_| wrong && (!look.is_fine || is_steady(&factors)))
    }

    /// Whether nearly all difference quotients are the derivative, whatever the errors of the values may be.
    fn agrees(&self, look: &Look) -> bool {
        let pairs = self.values.windows(2).zip(self.slopes.windows(2));
        let all = pairs.map(|(x, d)| ((x[1] - x[0]) / look.h, 0.5 * (d[0] + d[1])));
        let all: Vec<bool> = all
            .filter(|(measured, given)| *measured != 0.0 && given.is_finite())
            .map(|(measured, given)| (measured - given).abs() <= SHARE * given.abs())
            .collect();
        all.len() >= 3 && 10 * all.iter().filter(|agrees| **agrees).count() >= 8 * all.len()
    }
}

/// Whether nearly the whole change is that of one step, as of a counter: a derivative does not show it.
fn jumps(values: &[f64]) -> bool {
    let changes = || values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    changes().fold(0.0, f64::max) > 0.95 * changes().sum::<f64>()
}

/// Whether a derivative is wrong by nearly the same factor at all points. Piecewise constant values, as those of a fixed internal
/// step that is sampled more finely, have no such factor.
fn is_steady(factors: &[f64]) -> bool {
    let low = factors.iter().copied().fold(f64::INFINITY, f64::min);
    let high = factors.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    high - low < 0.5 * (low - 1.0).abs().min((high - 1.0).abs())
}

/// Steps of a run during which derivatives and values are compared.
struct Look {
    h: f64,
    n: usize,
    is_fine: bool,
}

/// Step sizes of the comparison: that of the experiment, a longer one for slow variables, and a fine one for small faults.
fn looks(subject: &Subject) -> Vec<Look> {
    let facts = subject.facts;
    let h = facts.step().max(subject.interface.fixed_internal_step_size.unwrap_or(0.0));
    let mut looks = vec![Look { h, n: steps(facts), is_fine: false }];
    let slow = facts.stop.map_or(0.0, |stop| (stop - facts.start) / PARTS as f64);
    if slow > 3.0 * h {
        // Multiples of the step: some FMUs accept no others.
        looks.push(Look { h: (slow / h).floor() * h, n: PARTS, is_fine: false });
    }
    if has_any_step(subject) {
        looks.push(Look { h: h / FINER as f64, n: FINER, is_fine: true });
    }
    looks
}

/// Whether the length of a step is free.
fn has_any_step(subject: &Subject) -> bool {
    let is_free =
        subject.interface.can_handle_variable_step && subject.interface.fixed_internal_step_size.is_none();
    is_free || subject.interface.kind == InterfaceType::ModelExchange
}

/// A session at the beginning of a comparison. A fine one begins where variables change.
fn begin<'a>(subject: &Subject<'a>, look: &Look) -> Result<(Session<'a>, Drive), Fault> {
    let mut session = subject.started(&subject.base()?.settings)?;
    let mut drive = Drive::new(&mut session)?;
    for _ in 0..if look.is_fine { 3 } else { 0 } {
        drive.advance(&mut session, look.h * FINER as f64)?;
    }
    Ok((session, drive))
}

/// Relative uncertainty of values.
fn uncertainty(facts: &Facts) -> f64 {
    2.0 * facts.tolerance.unwrap_or(1e-6).min(1e-4)
}

/// What a step may add to the error of a value: an integrator answers for its tolerance of the value, and of the nominal value.
fn noise(facts: &Facts, v: &Variable, value: f64) -> f64 {
    uncertainty(facts) * value.abs().max(v.nominal)
}

/// `derivative=` names the variable whose derivative this is.
pub(super) fn declared(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let is_plain = |v: &Variable| v.is_continuous() && v.size == 1 && !v.clocked;
    let pairs: Vec<(&Variable, &Variable)> = facts
        .slopes
        .iter()
        .map(|(x, dx)| (&facts.variables[*x], &facts.variables[*dx]))
        .filter(|(x, dx)| is_plain(x) && is_plain(dx) && !x.reinit)
        .collect();
    if pairs.is_empty() {
        return Ok(());
    }
    let (values, slopes): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
    let read = |session: &mut Session| session.get_all(&slopes);
    follow(subject, &values, true, read, |i, t, given, measured| {
        let (value, slope) = pairs[i];
        seen.add(&slope.place, rules::derivative_value(slope, value, t, given, measured));
    })
}

/// The derivatives of outputs that Co-Simulation gives.
pub(super) fn of_outputs(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let outputs = subject.facts.select(|v| v.is("output") && v.is_continuous() && v.size == 1 && !v.clocked);
    let references: Vec<u32> = outputs.iter().map(|v| v.reference).collect();
    if outputs.is_empty() {
        return Ok(());
    }
    let read = |session: &mut Session| {
        let mut given = vec![0.0; references.len()];
        let name = session.facts.pick("GetRealOutputDerivatives", "GetOutputDerivatives");
        session.call(name, |raw| raw.get_output_derivatives(&references, 1, &mut given))?;
        Ok(given)
    };
    follow(subject, &outputs, false, read, |i, t, given, measured| {
        let v = outputs[i];
        seen.add(&v.place, rules::output_derivative(v, given, t, measured));
    })?;
    // Higher orders are given, too, as far as they are declared.
    let (mut session, mut drive) = begin(subject, &looks(subject)[0])?;
    drive.advance(&mut session, subject.facts.step())?;
    let declared = subject.interface.max_output_derivative_order;
    for order in 2..=i32::try_from(declared).unwrap_or(i32::MAX).min(HIGHEST) {
        let mut given = vec![f64::NAN; references.len()];
        let status = session.raw.get_output_derivatives(&references, order, &mut given);
        if status > Status::Warning || given.iter().any(|d| !d.is_finite()) {
            let what = words(session.raw.log());
            let breach = rules::output_derivative_order(declared, order, status, what);
            seen.add(&subject.interface.place(), breach);
            break;
        }
    }
    Ok(())
}

/// Compares values with the derivatives that `read` gives, for each step size; from the start, or from the end of the first
/// step on. `report` gets each disagreement: number of the variable, time, mean derivative, mean difference quotient.
fn follow(
    subject: &Subject,
    variables: &[&Variable],
    from_start: bool,
    read: impl Fn(&mut Session) -> Result<Vec<f64>, Fault>,
    mut report: impl FnMut(usize, f64, f64, f64),
) -> Result<(), Fault> {
    let mut largest = vec![0.0_f64; variables.len()];
    for look in looks(subject) {
        let (mut found, _) = at_steps(subject, variables, from_start, &read, (&look, &mut largest))?;
        if !found.is_empty() && has_any_step(subject) {
            let mut other = Look { h: OTHER * look.h, ..look };
            let (again, agree) = at_steps(subject, variables, from_start, &read, (&other, &mut largest))?;
            // A small fault shows in fine steps of one length only.
            let is_again = |i: &usize| again.iter().any(|(other, ..)| other == i);
            found.retain(|(i, ..)| is_again(i) || look.is_fine && !agree.contains(i));
            for _ in 0..SHORTER.0 {
                other = Look { h: other.h / FINER as f64, n: SHORTER.1, is_fine: true };
                let (_, agree) = at_steps(subject, variables, from_start, &read, (&other, &mut largest))?;
                found.retain(|(i, ..)| !agree.contains(i));
            }
        }
        found.into_iter().for_each(|(i, t, given, measured)| report(i, t, given, measured));
    }
    Ok(())
}

/// A disagreement, as [`follow`] reports it.
type Disagreement = (usize, f64, f64, f64);

/// The disagreements with steps of one length, and the variables that agree whatever their errors; `largest` is the greatest derivative seen
/// of each variable.
fn at_steps(
    subject: &Subject,
    variables: &[&Variable],
    from_start: bool,
    read: &impl Fn(&mut Session) -> Result<Vec<f64>, Fault>,
    (look, largest): (&Look, &mut [f64]),
) -> Result<(Vec<Disagreement>, Vec<usize>), Fault> {
    let (mut session, mut drive) = begin(subject, look)?;
    let start = session.now;
    let mut series = vec![Series::default(); variables.len()];
    let mut before = session.get_all(variables)?;
    for k in 0..=look.n {
        if k > 0 && !drive.advance(&mut session, look.h)? {
            break;
        }
        let now = session.get_all(variables)?;
        // The first step counts, too: a fast variable may settle in it.
        let change = before.iter().zip(&now).map(|(a, b)| (b - a).abs() / look.h);
        largest.iter_mut().zip(change).for_each(|(l, change)| *l = l.max(change));
        before = now;
        if k > 0 || from_start {
            let d = read(&mut session)?;
            series.iter_mut().zip(before.iter().zip(&d)).for_each(|(s, (x, d))| s.push(*x, *d));
            largest.iter_mut().zip(&d).for_each(|(l, d)| *l = l.max(d.abs()));
        }
    }
    // A variable may be the balance of others of its unit, whose errors are its own.
    let of_unit = largest_of_unit(variables.iter().copied().zip(largest.iter().copied()));
    let agree = (0..series.len()).filter(|i| series[*i].agrees(look)).collect();
    let of = |(i, (v, series)): (usize, (&&Variable, Series))| {
        let noise = |x| noise(subject.facts, v, x);
        let least = STIFF * largest[i] + uncertainty(subject.facts) * of_unit(v);
        let (k, given, measured) = series.disagrees(look, least, noise)?;
        let points = k + usize::from(!from_start);
        Some((i, start + look.h * points as f64, given, measured))
    };
    Ok((variables.iter().zip(series).enumerate().filter_map(of).collect(), agree))
}

/// An input derivative has an effect where the input has one.
pub(super) fn of_inputs(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let h = facts.step();
    for v in facts.inputs().into_iter().filter(|v| v.size == 1) {
        let (low, high) = (v.start[0], v.other_value());
        if low == high {
            continue;
        }
        let run = |value: f64, slope: f64| -> Result<Rows, Fault> {
            let mut session: Session = subject.started(&subject.base()?.settings)?;
            session.set(v, &[value])?;
            session
                .call("SetRealInputDerivatives", |raw| raw.set_input_derivatives(&[v.reference], &[slope]))
                .map_err(|f| f.about(v, &[slope]))?;
            session.step(h)?;
            Ok(vec![session.observe()?])
        };
        let (held, moved) = (run(low, 0.0)?, run(0.5 * (low + high), 0.0)?);
        let steady = &subject.base()?.steady;
        // The input itself differs; another variable must differ, too.
        let others: Vec<bool> = steady.iter().enumerate().map(|(i, s)| *s && held[0][i] != low).collect();
        let Some(effect) = difference(facts, &others, &held, &moved) else { continue };
        if effect.relative < 1e-6 {
            continue;
        }
        let sloped = run(low, (high - low) / h)?;
        if difference(facts, &others, &held, &sloped).is_none() {
            seen.add(&v.place, rules::input_derivative(v, effect.name));
        }
    }
    Ok(())
}
