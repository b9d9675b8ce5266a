//! Which output depends on which input and parameter, found by moving each of them.
//!
//! The structure is asked of the model in every combination of its choices, at points where no effect is
//! neutral: a dependency that is there in any of them is declared. What importers sort their loops by can thus
//! not drift away from the equations.

use physics::declare::{Causality, Kind, Unit};
use physics::model::{Declaration, Entry, Model, ModelType};
use physics::terms::GenericTerm;

/// Where time starts, s; late, so that what drifts has moved far enough to flip a flag.
const START: f64 = 1e5;

/// For each output, in the order of the declaration, the entries (by index) that it depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependencies {
    /// Index of the output's entry, indices of the inputs that move it at once while the model runs.
    pub running: Vec<(usize, Vec<usize>)>,
    /// Index of the output's entry, indices of the inputs and parameters that decide it at the start.
    pub initial: Vec<(usize, Vec<usize>)>,
}

impl Dependencies {
    /// The structure of a model that carries these terms.
    pub fn of(kind: &ModelType, terms: &[GenericTerm]) -> Dependencies {
        let declaration = (kind.declaration)();
        let outputs = indices(declaration, |e| e.row.causality == Causality::Output);
        let inputs = indices(declaration, |e| e.row.causality == Causality::Input);
        let knowns = indices(declaration, |e| e.row.causality != Causality::Output);
        let choices = indices(declaration, |e| matches!(e.row.kind, Kind::Enumeration(_)));
        let mut running: Vec<(usize, Vec<usize>)> = outputs.iter().map(|&o| (o, Vec::new())).collect();
        let mut initial = running.clone();
        let mut probe = Probe::default();
        // Inputs of their usual size and a thousand times smaller: what saturates at one moves at the other.
        let points =
            combinations(declaration, &choices).into_iter().flat_map(|c| [(c.clone(), 1.0), (c, 1e-3)]);
        for (combination, scale) in points {
            let mut model = (kind.new)();
            model.set_terms(terms);
            // The time of an event stays where it is, so that what the event changes can be seen at the start.
            for &k in knowns.iter().filter(|&&k| declaration.entries[k].row.unit != Unit::Second) {
                let entry = &declaration.entries[k];
                let share = if entry.row.causality == Causality::Input && entry.row.start == 0.0 {
                    scale
                } else {
                    1.0
                };
                model.set(entry.slot, share * probe.generic(entry));
            }
            for &(k, value) in &combination {
                model.set(declaration.entries[k].slot, value);
            }
            let point = || model.boxed_clone();
            note(&mut initial, &knowns, &outputs, declaration, &mut probe, point, |m| m.start(START).is_ok());
            // A point away from rest, at which each input moves by itself.
            let mut moving = model.boxed_clone();
            let reached = moving.start(START).is_ok()
                && (0..3).all(|k| moving.step(START + f64::from(k) * 1e-3, 1e-3).is_ok());
            if reached {
                note(
                    &mut running,
                    &inputs,
                    &outputs,
                    declaration,
                    &mut probe,
                    || moving.boxed_clone(),
                    |_| true,
                );
            }
        }
        for list in [&mut running, &mut initial] {
            list.iter_mut().for_each(|(_, on)| on.sort_unstable());
        }
        Dependencies { running, initial }
    }
}

fn indices(declaration: &Declaration, which: impl Fn(&Entry) -> bool) -> Vec<usize> {
    declaration.entries.iter().enumerate().filter(|(_, e)| which(e)).map(|(k, _)| k).collect()
}

/// Every combination of the items of those choices that concern the whole model. Choices of one component or
/// effect, which do not act on one another, take turns: each of their items meets many of the combinations.
fn combinations(declaration: &Declaration, choices: &[usize]) -> Vec<Vec<(usize, f64)>> {
    let entries = &declaration.entries;
    let (whole, own): (Vec<usize>, Vec<usize>) =
        choices.iter().partition(|&&k| !entries[k].name.contains('.'));
    let items = |k: usize| match entries[k].row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| (k, f64::from(i.value))).collect(),
        _ => Vec::new(),
    };
    let mut all = whole.iter().fold(vec![Vec::new()], |all: Vec<Vec<(usize, f64)>>, &k| {
        let with = |one: &Vec<(usize, f64)>, item| [one.as_slice(), &[item]].concat();
        all.iter().flat_map(|one| items(k).into_iter().map(move |item| with(one, item))).collect()
    });
    for (turn, &k) in own.iter().enumerate() {
        let items = items(k);
        for (n, one) in all.iter_mut().enumerate() {
            // Different strides, so that two such choices do not keep step with each other.
            one.push(items[(n / (turn + 1) + turn) % items.len()]);
        }
    }
    all
}

/// Adds to `found` every output that a move of one of `knowns` moves.
fn note(
    found: &mut [(usize, Vec<usize>)],
    knowns: &[usize],
    outputs: &[usize],
    declaration: &Declaration,
    probe: &mut Probe,
    point: impl Fn() -> Box<dyn Model>,
    settle: impl Fn(&mut Box<dyn Model>) -> bool,
) {
    let read = |mut model: Box<dyn Model>| -> Option<Vec<u64>> {
        let settled = settle(&mut model);
        // A zero that turns its sign has not moved.
        let mut bits = |o: &usize| (model.get(declaration.entries[*o].slot) + 0.0).to_bits();
        settled.then(|| outputs.iter().map(&mut bits).collect())
    };
    let Some(before) = read(point()) else { return };
    for &k in knowns {
        let entry = &declaration.entries[k];
        let moves: Vec<f64> = match entry.row.kind {
            Kind::Enumeration(t) => t.items.iter().map(|i| f64::from(i.value)).collect(),
            Kind::Boolean => vec![0.0, 1.0],
            Kind::Integer => vec![entry.row.start - 1.0, entry.row.start + 1.0, entry.row.min, entry.row.max],
            Kind::Real => vec![probe.generic(entry), probe.generic(entry), entry.row.min, entry.row.max],
        };
        for value in moves {
            if entry.check(value, false).is_err() {
                continue;
            }
            let mut model = point();
            model.set(entry.slot, value);
            let Some(after) = read(model) else { continue };
            for (n, (_, on)) in found.iter_mut().enumerate() {
                if before[n] != after[n] && !on.contains(&k) {
                    on.push(k);
                }
            }
        }
    }
}

/// Numbers without pattern, the same at every run.
#[derive(Default)]
struct Probe(u64);

impl Probe {
    /// A share in (0, 1): the golden-ratio sequence.
    fn share(&mut self) -> f64 {
        self.0 += 1;
        (self.0 as f64 * 0.618_033_988_749_895).fract().clamp(0.05, 0.95)
    }

    /// A value within the limits, of the variable's typical size, and not its start.
    fn generic(&mut self, entry: &Entry) -> f64 {
        let row = entry.row;
        match row.kind {
            Kind::Real => {
                let base = if row.start == 0.0 { row.nominal } else { row.start };
                let value = base * (0.7 + 0.6 * self.share());
                if (row.min..=row.max).contains(&value) {
                    value
                } else {
                    row.min + (row.max - row.min) * self.share()
                }
            }
            _ => row.start,
        }
    }
}
