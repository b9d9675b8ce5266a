//! Runs that are compared with each other.

use cosim::raw::InterfaceType;

use super::facts::{Facts, Variable, observed};
use super::report::{Fault, Seen};
use super::session::{Session, column};
use super::solver::{Reached, Solver};
use crate::validate::rules::Rule;

/// Steps of one run.
const STEPS: usize = 10;
/// Relative error of an integrated Model Exchange run whose equal is made by the same steps.
const TOLERANCE: f64 = 1e-6;

/// Values of everything, after initialisation and after each step.
pub(super) type Rows = Vec<Vec<f64>>;

/// Integration by the instance's own steps or by the solver.
pub(super) struct Drive(Option<Solver>);

impl Drive {
    /// For a session that is ready to step.
    pub(super) fn new(session: &mut Session) -> Result<Drive, Fault> {
        let solver = match session.interface.kind {
            InterfaceType::ModelExchange => Some(Solver::new(session, TOLERANCE)?),
            _ => None,
        };
        Ok(Drive(solver))
    }

    /// Advances by `h`; `false` at the end of the run.
    pub(super) fn advance(&mut self, session: &mut Session, h: f64) -> Result<bool, Fault> {
        match &mut self.0 {
            None => session.step(h),
            Some(solver) => {
                let end = session.now + h;
                Ok(solver.advance(session, end, true)? != Reached::Exhausted)
            }
        }
    }

    /// The rows of the next steps, without the present one.
    pub(super) fn rows(&mut self, session: &mut Session, h: f64, steps: usize) -> Result<Rows, Fault> {
        let mut rows = Vec::new();
        for _ in 0..steps {
            if !self.advance(session, h)? {
                break;
            }
            rows.push(session.observe()?);
        }
        Ok(rows)
    }
}

/// How long runs are.
pub(super) fn steps(facts: &Facts) -> usize {
    let fitting =
        facts.stop.map_or(STEPS as f64, |stop| ((stop - facts.start) / facts.step() * (1.0 + 1e-9)).floor());
    (fitting.max(1.0) as usize).min(STEPS)
}

/// The run of a session that is ready to step.
pub(super) fn from_here(session: &mut Session) -> Result<Rows, Fault> {
    let facts = session.facts;
    let mut drive = Drive::new(session)?;
    let mut rows = vec![session.observe()?];
    rows.extend(drive.rows(session, facts.step(), steps(facts))?);
    Ok(rows)
}

/// Values of `watched` at the start of a Co-Simulation and after each of `n` steps that are `parts` to an `h`, until the
/// FMU requests the end.
pub(super) fn stepped(
    session: &mut Session,
    watched: &[&Variable],
    h: f64,
    n: usize,
    parts: usize,
) -> Result<Rows, Fault> {
    let mut rows = vec![session.get_all(watched)?];
    // Times are multiples, not sums: sums would differ in the last bits.
    let start = session.facts.start;
    let time = |k: usize| start + h * k as f64 / parts as f64;
    for k in 0..n {
        session.now = time(k);
        if !session.step(time(k + 1) - time(k))? {
            break;
        }
        rows.push(session.get_all(watched)?);
    }
    Ok(rows)
}

/// Relative differences below this are rounding.
pub(super) const ROUNDING: f64 = 1e-9;

/// The relative difference that a solver may cause that starts again: a few tolerances of the default experiment.
pub(super) fn solver_error(facts: &Facts) -> f64 {
    10.0 * facts.tolerance.unwrap_or(1e-4).min(1e-2)
}

pub(super) fn same(a: f64, b: f64) -> bool {
    a == b || a.is_nan() && b.is_nan()
}

/// The largest relative difference of two runs.
pub(super) struct Difference<'a> {
    pub(super) name: String,
    pub(super) variable: &'a Variable,
    /// Steps since the runs' first row.
    pub(super) row: usize,
    pub(super) first: f64,
    pub(super) second: f64,
    pub(super) relative: f64,
}

impl Difference<'_> {
    /// The row in words.
    pub(super) fn when(&self) -> String {
        match self.row {
            0 => "after initialisation".to_owned(),
            1 => "after 1 step".to_owned(),
            n => format!("after {n} steps"),
        }
    }
}

impl Seen<'_> {
    /// Reports where two runs differ, and whether they do; `is` puts both values into words.
    pub(super) fn differ(
        &mut self,
        rule: &'static Rule,
        difference: Option<Difference>,
        is: impl Fn(f64, f64) -> String,
    ) -> bool {
        let Some(d) = difference.filter(|d| d.relative > ROUNDING) else { return false };
        let message = format!("Variable \"{}\" {} ({})", d.name, is(d.first, d.second), d.when());
        self.add(&d.variable.place, rule.says(message));
        true
    }
}

/// What differences of a variable are related to at least: its nominal value.
fn floor(v: &Variable) -> f64 {
    if v.kind.is_float() { v.nominal } else { 0.0 }
}

/// Where two runs differ most, among the steady columns. Differences of floating point numbers are relative to the values,
/// at least to the nominal one.
pub(super) fn difference<'a>(
    facts: &'a Facts,
    steady: &[bool],
    a: &Rows,
    b: &Rows,
) -> Option<Difference<'a>> {
    let floors: Vec<f64> =
        facts.variables.iter().filter(|v| observed(v)).flat_map(|v| vec![floor(v); v.size]).collect();
    let mut worst: Option<(f64, usize, usize)> = None;
    for (row, (x, y)) in a.iter().zip(b).enumerate() {
        for index in 0..x.len().min(y.len()) {
            if !steady.get(index).copied().unwrap_or(true) || same(x[index], y[index]) {
                continue;
            }
            let size = a.iter().chain(b).map(|r| r[index].abs()).fold(floors[index], f64::max);
            let relative = (x[index] - y[index]).abs() / size;
            let relative = if relative.is_finite() { relative } else { f64::INFINITY };
            if worst.is_none_or(|w| relative > w.0) {
                worst = Some((relative, row, index));
            }
        }
    }
    if a.len() != b.len() && worst.is_none() {
        worst = Some((f64::INFINITY, a.len().min(b.len()).saturating_sub(1), 0));
    }
    let (relative, row, index) = worst?;
    let (name, variable) = column(facts, index);
    Some(Difference { name, variable, row, first: a[row][index], second: b[row][index], relative })
}
