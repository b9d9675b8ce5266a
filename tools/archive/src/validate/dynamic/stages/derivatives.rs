//! Slopes that the FMU tells, against differences of the values that it gives.

use crate::validate::dynamic::facts::{Facts, Variable};
use crate::validate::dynamic::probe::{Fault, Seen};
use crate::validate::dynamic::runs::{Drive, Rows, difference, steps};
use crate::validate::dynamic::session::{Session, Subject};
use crate::validate::finding::short;
use crate::validate::rules;

/// What a slope may be off, as a share of itself.
const SHARE: f64 = 0.01;
/// Parts of the default experiment for the second, slower look.
const PARTS: f64 = 200.0;

/// Steps over which slopes are summed up: enough to see that they swing, where they do.
const WINDOW: usize = 4;

/// A variable and its slope, as told, at equidistant times.
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

    /// The first disagreement (number of its first point, mean slope told, mean slope seen), if nearly all windows that
    /// say anything disagree. An event spoils some of them; a wrong slope is wrong always.
    fn disagrees(&self, h: f64, noise: impl Fn(f64) -> f64) -> Option<(usize, f64, f64)> {
        let (mut informative, mut wrong, mut example) = (0, 0, None);
        for k in 0..self.values.len().saturating_sub(WINDOW) {
            let slopes = &self.slopes[k..=k + WINDOW];
            let pairs = || slopes.windows(2).map(|d| (d[0], d[1]));
            let steps = WINDOW as f64;
            let told = pairs().map(|(a, b)| 0.5 * (a + b)).sum::<f64>() / steps;
            let seen = (self.values[k + WINDOW] - self.values[k]) / (h * steps);
            // A step may have been made with the slope at its beginning or at its end.
            let swing = pairs().map(|(a, b)| (b - a).abs()).sum::<f64>() / steps;
            let room = 0.6 * swing + noise(self.values[k]) / (h * steps);
            let size = told.abs().max(seen.abs());
            if !(size > 0.0 && room.is_finite()) || room > 0.5 * size {
                continue;
            }
            informative += 1;
            if (told - seen).abs() > SHARE * size + room {
                wrong += 1;
                example.get_or_insert((k, told, seen));
            }
        }
        example.filter(|_| wrong >= 3 && 10 * wrong >= 8 * informative)
    }
}

/// The step sizes at which to look: that of the experiment, and one that shows slow variables move.
fn looks(facts: &Facts, subject: &Subject) -> Vec<(f64, usize)> {
    let h = facts.step().max(subject.interface.internal_step.unwrap_or(0.0));
    let mut looks = vec![(h, steps(facts))];
    let slow = facts.stop.map_or(0.0, |stop| (stop - facts.start) / PARTS);
    if slow > 3.0 * h {
        // Multiples of the step, as not every FMU takes others.
        looks.push(((slow / h).floor() * h, PARTS as usize));
    }
    looks
}

/// What the values of a variable are uncertain by.
fn noise(facts: &Facts, v: &Variable, value: f64) -> f64 {
    2.0 * facts.tolerance.unwrap_or(1e-6).min(1e-4) * value.abs().max(1e-3 * v.nominal)
}

/// `derivative=` names the variable whose slope this is.
pub(super) fn declared(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let is_plain = |v: &Variable| v.is_continuous() && v.size == 1 && !v.clocked;
    let pairs: Vec<(&Variable, &Variable)> = facts
        .slopes
        .iter()
        .map(|(x, dx)| (&facts.variables[*x], &facts.variables[*dx]))
        .filter(|(x, dx)| is_plain(x) && is_plain(dx))
        .collect();
    if pairs.is_empty() {
        return Ok(());
    }
    let (values, slopes): (Vec<_>, Vec<_>) = pairs.iter().copied().unzip();
    for (h, n) in looks(facts, subject) {
        let mut session = subject.started(&subject.base()?.settings)?;
        let mut drive = Drive::new(&mut session)?;
        let mut series = vec![Series::default(); pairs.len()];
        for k in 0..=n {
            if k > 0 && !drive.advance(&mut session, h)? {
                break;
            }
            let (x, d) = (session.get_all(&values)?, session.get_all(&slopes)?);
            series.iter_mut().zip(x.iter().zip(&d)).for_each(|(s, (x, d))| s.push(*x, *d));
        }
        for ((value, slope), series) in pairs.iter().zip(series) {
            if let Some((k, told, is)) = series.disagrees(h, |x| noise(facts, value, x)) {
                let message = format!(
                    "Variable \"{}\" is declared to be the derivative of \"{}\", but from t = {} s on it is {told} while \"{}\" changes by {is} per second",
                    short(&slope.name),
                    short(&value.name),
                    facts.start + h * k as f64,
                    short(&value.name)
                );
                seen.add(&rules::DERIVATIVE_VALUE, &slope.place, message);
            }
        }
    }
    Ok(())
}

/// The derivatives of outputs that Co-Simulation gives.
pub(super) fn of_outputs(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let outputs = facts.select(|v| v.is("output") && v.is_continuous() && v.size == 1 && !v.clocked);
    let references: Vec<u32> = outputs.iter().map(|v| v.reference).collect();
    if outputs.is_empty() {
        return Ok(());
    }
    for (h, n) in looks(facts, subject) {
        let mut session = subject.started(&subject.base()?.settings)?;
        let mut series = vec![Series::default(); outputs.len()];
        for _ in 0..n {
            if !session.step(h)? {
                break;
            }
            let values = session.get_all(&outputs)?;
            let mut told = vec![0.0; outputs.len()];
            let status = session.raw.get_output_derivatives(&references, &mut told);
            session.ok("GetOutputDerivatives", status)?;
            series.iter_mut().zip(values.iter().zip(&told)).for_each(|(s, (x, d))| s.push(*x, *d));
        }
        for (v, series) in outputs.iter().zip(series) {
            if let Some((k, told, is)) = series.disagrees(h, |x| noise(facts, v, x)) {
                let message = format!(
                    "The derivative of output \"{}\" is told to be {told} from t = {} s on, but it changes by {is} per second",
                    short(&v.name),
                    facts.start + h * (k + 1) as f64
                );
                seen.add(&rules::OUTPUT_DERIVATIVE, &v.place, message);
            }
        }
    }
    Ok(())
}

/// A slope of an input that matters has an effect.
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
            let status = session.raw.set_input_derivatives(&[v.reference], &[slope]);
            session.ok("SetRealInputDerivatives", status).map_err(|f| f.about(v, &[slope]))?;
            session.step(h)?;
            Ok(vec![session.observe()?])
        };
        let (held, moved) = (run(low, 0.0)?, run(0.5 * (low + high), 0.0)?);
        let steady = &subject.base()?.steady;
        // The input itself differs, of course; something else has to.
        let others: Vec<bool> = steady.iter().enumerate().map(|(i, s)| *s && held[0][i] != low).collect();
        let Some(effect) = difference(facts, &others, &held, &moved) else { continue };
        if effect.relative < 1e-6 {
            continue;
        }
        let sloped = run(low, (high - low) / h)?;
        if difference(facts, &others, &held, &sloped).is_none() {
            let message = format!(
                "A slope of input \"{}\" has no effect although canInterpolateInputs is true (the input itself moves \"{}\")",
                short(&v.name),
                effect.name
            );
            seen.add(&rules::INPUT_DERIVATIVE, &v.place, message);
        }
    }
    Ok(())
}
