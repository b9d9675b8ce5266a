//! Partial derivatives compared with difference quotients, and declared dependencies.

use super::*;
use std::time::{Duration, Instant};

/// Relative size of a difference's step, and what a derivative may be off.
const STEP: f64 = 1e-5;
const SHARE: f64 = 1e-3;
/// Time limit of the comparison of columns.
const PATIENCE: Duration = Duration::from_secs(3);

/// One scalar that moves: an element of an input or of a state.
#[derive(Clone, Copy)]
struct Known<'a> {
    variable: &'a Variable,
    element: usize,
    /// Its place in the vector of continuous states.
    state: Option<usize>,
}

/// Values of a known's column.
struct Column {
    /// Differences over one and four steps, and one-sided.
    near: Vec<f64>,
    far: Vec<f64>,
    forward: Vec<f64>,
    backward: Vec<f64>,
    /// The unknowns in the middle.
    middle: Vec<f64>,
    step: f64,
}

struct Point<'s, 'a> {
    session: Session<'a>,
    unknowns: &'s [(&'a Entry, &'a Variable)],
    x: Vec<f64>,
    inputs: Vec<(&'a Variable, Vec<f64>)>,
}

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let integrated = subject.interface.kind == InterfaceType::ModelExchange;
    let plain =
        |e: &&Entry| facts.variables[e.variable].is_continuous() && !facts.variables[e.variable].clocked;
    let derivatives = facts.derivatives.iter().filter(|_| integrated);
    let unknowns: Vec<(&Entry, &Variable)> =
        derivatives.chain(&facts.outputs).filter(plain).map(|e| (e, &facts.variables[e.variable])).collect();
    let mut knowns = Vec::new();
    for variable in facts.inputs() {
        knowns.extend((0..variable.size).map(|element| Known { variable, element, state: None }));
    }
    if integrated {
        let mut at = 0;
        for variable in facts.states.iter().map(|i| &facts.variables[*i]) {
            knowns.extend((0..variable.size).map(|e| Known { variable, element: e, state: Some(at + e) }));
            at += variable.size;
        }
    }
    if unknowns.is_empty() || knowns.is_empty() {
        return Ok(());
    }
    let mut session = subject.started(&subject.base()?.settings)?;
    Drive::new(&mut session)?.advance(&mut session, facts.step())?;
    let mut x = vec![0.0; if integrated { facts.state_count() } else { 0 }];
    if !x.is_empty() {
        session.call("GetContinuousStates", |raw| raw.get_states(&mut x))?;
    }
    let mut inputs = Vec::new();
    for v in facts.inputs() {
        inputs.push((v, session.get(v)?));
    }
    let mut point = Point { session, unknowns: &unknowns, x, inputs };
    let started = Instant::now();
    let mut columns = Vec::new();
    for known in &knowns {
        if started.elapsed() > PATIENCE {
            break;
        }
        let Some(column) = point.column(known) else {
            // Rejected on one side: a limit, or a point outside the model's domain.
            point.session.call("Reset", |raw| raw.reset())?;
            point.session.start(&subject.base()?.settings)?;
            continue;
        };
        dependencies(facts, &unknowns, known, &column, seen);
        if subject.interface.provides_directional_derivatives {
            point.directional(known, &column, seen)?;
        }
        columns.push((*known, column));
    }
    if subject.interface.provides_adjoint_derivatives {
        point.adjoint(&columns, seen)?;
    }
    Ok(())
}

impl<'a> Point<'_, 'a> {
    fn references(&self) -> (Vec<u32>, usize) {
        let references = self.unknowns.iter().map(|(_, v)| v.reference).collect();
        (references, self.unknowns.iter().map(|(_, v)| v.size).sum())
    }

    /// All unknowns with one known changed by `by`.
    fn values(&mut self, known: &Known<'a>, by: f64) -> Option<Vec<f64>> {
        match known.state {
            Some(index) => {
                let mut x = self.x.clone();
                x[index] += by;
                let now = self.session.now;
                Solver::rates(&mut self.session, now, &x).ok()?;
            }
            None => {
                let (variable, values) =
                    self.inputs.iter().find(|(v, _)| std::ptr::eq(*v, known.variable))?;
                let mut values = values.clone();
                values[known.element] += by;
                self.session.set(variable, &values).ok()?;
            }
        }
        let (references, size) = self.references();
        let mut out = vec![0.0; size];
        let status = self.session.raw.get(Kind::Float64, &references, &mut out);
        (status <= Status::Warning && out.iter().all(|x| x.is_finite())).then_some(out)
    }

    fn column(&mut self, known: &Known<'a>) -> Option<Column> {
        let at = match known.state {
            Some(index) => self.x[index],
            None => self.inputs.iter().find(|(v, _)| std::ptr::eq(*v, known.variable))?.1[known.element],
        };
        let step = STEP * at.abs().max(known.variable.nominal);
        let [plus, minus] = [self.values(known, step)?, self.values(known, -step)?];
        let [plus4, minus4] = [self.values(known, 4.0 * step)?, self.values(known, -4.0 * step)?];
        // Last, so that the original point is restored.
        let middle = self.values(known, 0.0)?;
        let quotient = |a: &[f64], b: &[f64], h: f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| (a - b) / h).collect()
        };
        Some(Column {
            near: quotient(&plus, &minus, 2.0 * step),
            far: quotient(&plus4, &minus4, 8.0 * step),
            forward: quotient(&plus, &middle, step),
            backward: quotient(&middle, &minus, step),
            middle,
            step,
        })
    }

    fn directional(&mut self, known: &Known<'a>, column: &Column, seen: &mut Seen) -> Result<(), Fault> {
        let (references, size) = self.references();
        let mut seed = vec![0.0; known.variable.size];
        seed[known.element] = 1.0;
        let mut out = vec![0.0; size];
        self.session
            .call("GetDirectionalDerivative", |raw| {
                raw.directional_derivative(&references, &[known.variable.reference], &seed, &mut out)
            })
            .map_err(|f| f.about(known.variable, &[]))?;
        let still = self.x.is_empty() && column.near.iter().all(|d| *d == 0.0);
        for (i, given) in out.iter().enumerate() {
            // A Co-Simulation FMU that updates its outputs only in the next step gives nothing to compare with.
            if !still {
                self.judge(&rules::DIRECTIONAL, "directional", i, *given, known, column, seen);
            }
        }
        Ok(())
    }

    fn adjoint(&mut self, columns: &[(Known<'a>, Column)], seen: &mut Seen) -> Result<(), Fault> {
        let (references, size) = self.references();
        let is_still = columns.iter().all(|(_, c)| c.near.iter().all(|d| *d == 0.0));
        for row in 0..size {
            let mut seed = vec![0.0; size];
            seed[row] = 1.0;
            for (known, column) in columns {
                let mut out = vec![0.0; known.variable.size];
                self.session
                    .call("GetAdjointDerivative", |raw| {
                        raw.adjoint_derivative(&references, &[known.variable.reference], &seed, &mut out)
                    })
                    .map_err(|f| f.about(known.variable, &[]))?;
                if !is_still {
                    self.judge(&rules::ADJOINT, "adjoint", row, out[known.element], known, column, seen);
                }
            }
        }
        Ok(())
    }

    /// Reports a derivative of the unknown at place `i` over `known` that the differences contradict.
    #[allow(clippy::too_many_arguments)]
    fn judge(
        &self,
        rule: &'static Rule,
        word: &str,
        i: usize,
        given: f64,
        known: &Known<'a>,
        column: &Column,
        seen: &mut Seen,
    ) {
        let (v, over) = (name_at(self.unknowns, i), known.variable);
        if !is_same(v, over) && !column.allows(i, given, v.nominal) {
            let near = column.near[i];
            let message =
                format!("The {word} derivative of {v} over {over} is {given}, but differences give {near}");
            seen.add(&v.place, rule.says(message));
        }
    }
}

impl Column {
    /// Whether a derivative agrees with the difference quotients within their uncertainty.
    fn allows(&self, i: usize, given: f64, nominal: f64) -> bool {
        let near = self.near[i];
        let bend = (self.forward[i] - self.backward[i]).abs();
        // A value near zero may be the rounding error of cancelling terms of nominal size.
        let noise = 1e-10 * self.middle[i].abs().max(1e-3 * nominal) / self.step;
        let room = SHARE * given.abs().max(near.abs()) + 3.0 * (near - self.far[i]).abs() + bend + noise;
        (given - near).abs() <= room
    }

    /// Whether the change of the unknown is significant.
    fn moves(&self, i: usize, nominal: f64) -> bool {
        let (near, far) = (self.near[i], self.far[i]);
        let moved = 8.0 * self.step * far.abs();
        moved > 1e-7 * self.middle[i].abs().max(1e-3 * nominal) && (near - far).abs() < 0.2 * far.abs()
    }
}

/// The variable behind a place in the values of all unknowns.
fn name_at<'a>(unknowns: &[(&Entry, &'a Variable)], mut i: usize) -> &'a Variable {
    for (_, v) in unknowns {
        if i < v.size {
            return v;
        }
        i -= v.size;
    }
    unreachable!("the values are those of the unknowns")
}

/// An unknown without a declared dependency on a known must not change with it.
fn dependencies(
    facts: &Facts,
    unknowns: &[(&Entry, &Variable)],
    known: &Known,
    column: &Column,
    seen: &mut Seen,
) {
    let mut at = 0;
    for (entry, unknown) in unknowns {
        let elements = at..at + unknown.size;
        at += unknown.size;
        let Some(list) = &entry.dependencies else { continue };
        // The dependency of an output that is a state on itself is trivial.
        if is_same(unknown, known.variable)
            || list.iter().any(|d| is_same(&facts.variables[*d], known.variable))
        {
            continue;
        }
        if let Some(i) = elements.into_iter().find(|i| column.moves(*i, unknown.nominal)) {
            seen.add(
                &unknown.place,
                rules::dependency_undeclared(unknown, short(&known.variable.name), column.near[i]),
            );
        }
    }
}

/// The same variable, or an alias of it.
fn is_same(a: &Variable, b: &Variable) -> bool {
    a.reference == b.reference && a.kind == b.kind
}
