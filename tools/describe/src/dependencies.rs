//! Which output, derivative and event indicator depends on which input, state and parameter, found by moving each.
//!
//! The structure is asked of the model in every combination of its choices, at points where no effect is
//! neutral: a dependency that is there in any of them is declared. What importers sort their loops by can thus
//! not drift away from the equations.
//!
//! What a model has by itself is looked for at many points and kept ([`known`]); for terms that are data fewer do.

mod known;

use crate::preset::StartValues;
use physics::declare::{Causality, Kind, Unit};
use physics::model::{Declaration, Entry, Model, ModelType, Slot};
use physics::terms::GenericTerm;
use rayon::prelude::*;

/// Where time starts, s; late, so that what drifts has moved far enough to flip a flag.
const START: f64 = 1e5;

/// A variable that the model computes, and what it depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Index of its entry in the declaration.
    pub entry: usize,
    /// Indices of the entries that it depends on, ascending.
    pub on: Vec<usize>,
    /// Whether it depends on time.
    pub on_time: bool,
}

impl Unknown {
    /// With what else it depends on.
    fn and(mut self, other: Unknown) -> Unknown {
        self.on_time |= other.on_time;
        self.on.extend(other.on);
        self.on.sort_unstable();
        self.on.dedup();
        self
    }
}

/// While the model runs, and at its start.
type Both = (Vec<Unknown>, Vec<Unknown>);

/// What depends on what, in the order of the declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependencies {
    /// Outputs on the inputs, states and the time that move them at once while the model runs.
    pub outputs: Vec<Unknown>,
    /// The same of the derivatives of the states.
    pub rates: Vec<Unknown>,
    /// The same of the event indicators.
    pub indicators: Vec<Unknown>,
    /// Outputs, states and derivatives on the inputs and parameters that decide them at the start.
    pub initial: Vec<Unknown>,
}

/// How a point differs from others with the same choices: the size of the inputs, and whether all effects are there.
type Point = (f64, bool);
/// Inputs of their usual size and a thousand times smaller: what saturates at one moves at the other. Then half of the
/// effects, because some put a node in place of a direct way.
const POINTS: [Point; 3] = [(1.0, true), (1e-3, true), (1.0, false)];
/// How often all of them are taken for what is kept: a point of the fan's curve shows where the air meets it.
const TURNS: usize = 4;

/// Something that is moved.
#[derive(Clone, Copy, Debug)]
enum Known {
    Entry(usize),
    /// Place among the states, index of the entry.
    State(usize, usize),
    Time,
}

impl Dependencies {
    /// The structure of a model that carries these terms, with as many elements as its start values say.
    pub fn of(kind: &ModelType, terms: &[GenericTerm], starts: &StartValues) -> Dependencies {
        let declaration = (kind.declaration)();
        let Some(known) = Dependencies::known(declaration, starts) else {
            return Dependencies::found(kind, terms, starts, &POINTS);
        };
        // Of the start values only counts of elements decide what there is.
        let counts = declaration.entries.iter().filter(|entry| declaration.is_dimension(entry));
        let usual = counts.into_iter().all(|entry| starts.of(entry) == entry.row.start);
        match (terms.is_empty(), usual) {
            (true, true) => known,
            (false, true) => known.and(Dependencies::found(kind, terms, starts, &POINTS[..1])),
            (_, false) => known.and(Dependencies::found(kind, terms, starts, &POINTS)),
        }
    }

    /// The structure of a model by itself, looked for at as many points as it takes to be kept.
    pub fn of_all(kind: &ModelType) -> Dependencies {
        Dependencies::found(kind, &[], &StartValues::default(), &[POINTS; TURNS].concat())
    }

    /// With what else there is of the same unknowns.
    fn and(self, other: Dependencies) -> Dependencies {
        let both = |own: Vec<Unknown>, other: Vec<Unknown>| -> Vec<Unknown> {
            own.into_iter().zip(other).map(|(own, other)| own.and(other)).collect()
        };
        Dependencies {
            outputs: both(self.outputs, other.outputs),
            rates: both(self.rates, other.rates),
            indicators: both(self.indicators, other.indicators),
            initial: both(self.initial, other.initial),
        }
    }

    /// The structure as it shows at these points with every combination of the choices.
    fn found(
        kind: &ModelType,
        terms: &[GenericTerm],
        starts: &StartValues,
        points: &[Point],
    ) -> Dependencies {
        let declaration = (kind.declaration)();
        let of_kind = |which: &dyn Fn(&Entry) -> bool| -> Vec<usize> {
            indices(declaration, |e| which(e) && starts.shows(declaration, e))
        };
        let outputs = of_kind(&|e| e.row.causality == Causality::Output);
        let states = of_kind(&|e| e.slot.group == Slot::STATES);
        let rates = of_kind(&|e| e.slot.group == Slot::RATES);
        let inputs = of_kind(&|e| e.row.causality == Causality::Input);
        let settable = of_kind(&Entry::is_settable);
        let choices = of_kind(&|e| matches!(e.row.kind, Kind::Enumeration(_)));

        let mut at_start = [&outputs[..], &states, &rates].concat();
        at_start.sort_unstable();
        let at_once = [&outputs[..], &rates, &declaration.indicators].concat();
        let decide: Vec<Known> = settable.iter().map(|&k| Known::Entry(k)).chain([Known::Time]).collect();
        let move_at_once: Vec<Known> = inputs
            .iter()
            .map(|&k| Known::Entry(k))
            .chain(states.iter().enumerate().map(|(n, &k)| Known::State(n, k)))
            .chain([Known::Time])
            .collect();
        let nothing = |entry: &usize| Unknown { entry: *entry, on: Vec::new(), on_time: false };
        let none =
            || -> Both { (at_once.iter().map(nothing).collect(), at_start.iter().map(nothing).collect()) };
        let combinations = combinations(declaration, &choices);
        let points = combinations.par_iter().enumerate().flat_map_iter(|(k, combination)| {
            let points = points.iter().enumerate();
            points.map(move |(turn, point)| (combination, *point, Probe::new(k, turn)))
        });
        let look = |(combination, (scale, effects), mut probe): (&Vec<(usize, f64)>, Point, Probe)| -> Both {
            let (mut running, mut initial) = none();
            let mut model = (kind.new)();
            model.set_terms(terms);
            model.hand_over();
            // The time of an event stays where it is, so that what the event changes can be seen at the start.
            let absent = if effects { Vec::new() } else { probe.half_of(&effects_of(declaration)) };
            let there = |entry: &Entry| !absent.iter().any(|prefix| entry.name.starts_with(prefix));
            for &k in settable.iter().filter(|&&k| declaration.entries[k].row.unit != Unit::Second) {
                let entry = &declaration.entries[k];
                let share = if entry.row.causality == Causality::Input && entry.row.start == 0.0 {
                    scale
                } else {
                    1.0
                };
                if there(entry) {
                    model.set(entry.slot, share * probe.generic(entry, starts));
                }
            }
            for &(k, value) in combination {
                model.set(declaration.entries[k].slot, value);
            }
            if effects {
                let point = || model.boxed_clone();
                let note = Note { declaration, unknowns: &at_start, starts };
                note.add(&mut initial, &decide, &mut probe, point, |m, time| m.start(time).is_ok(), START);
            }
            // A point away from rest, at which each input moves by itself.
            let mut moving = model.boxed_clone();
            for &k in settable.iter().filter(|&&k| declaration.entries[k].row.unit == Unit::Second) {
                let entry = &declaration.entries[k];
                if there(entry) {
                    moving.set(entry.slot, probe.generic(entry, starts));
                }
            }
            if moving.start(START).is_ok() && probe.push(moving.as_mut(), states.len()) {
                let point = || moving.boxed_clone();
                let settle = |m: &mut Box<dyn Model>, time: f64| {
                    m.write_time(time);
                    m.update();
                    true
                };
                let note = Note { declaration, unknowns: &at_once, starts };
                note.add(&mut running, &move_at_once, &mut probe, point, settle, START);
            }
            (running, initial)
        };
        let (mut running, initial) = points.map(look).reduce(none, |all, one| {
            let both = |all: Vec<Unknown>, one: Vec<Unknown>| -> Vec<Unknown> {
                all.into_iter().zip(one).map(|(all, one)| all.and(one)).collect()
            };
            (both(all.0, one.0), both(all.1, one.1))
        });
        let indicators = running.split_off(outputs.len() + rates.len());
        let rates = running.split_off(outputs.len());
        Dependencies { outputs: running, rates, indicators, initial }
    }
}

fn indices(declaration: &Declaration, which: impl Fn(&Entry) -> bool) -> Vec<usize> {
    declaration.entries.iter().enumerate().filter(|(_, e)| which(e)).map(|(k, _)| k).collect()
}

/// The prefixes of the groups that are effects.
fn effects_of(declaration: &Declaration) -> Vec<&'static str> {
    declaration
        .groups
        .iter()
        .map(|group| group.prefix)
        .filter(|prefix| prefix.starts_with("effect."))
        .collect()
}

/// Combinations that are all tried.
const FEW: usize = 64;

/// Every combination of the items of the model's choices. Where they are many, the choices of effects, which do not
/// act on one another, take turns: each of their items meets many of the combinations.
fn combinations(declaration: &Declaration, choices: &[usize]) -> Vec<Vec<(usize, f64)>> {
    let entries = &declaration.entries;
    let items = |k: usize| match entries[k].row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| (k, f64::from(i.value))).collect(),
        _ => Vec::new(),
    };
    let count: usize = choices.iter().map(|&k| items(k).len()).product();
    let (whole, own): (Vec<usize>, Vec<usize>) =
        choices.iter().partition(|&&k| count <= FEW || !entries[k].name.starts_with("effect."));
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

/// What is looked at while something is moved.
struct Note<'a> {
    declaration: &'static Declaration,
    /// Entries of what may move with it.
    unknowns: &'a [usize],
    starts: &'a StartValues,
}

impl Note<'_> {
    /// Adds to `found` every unknown that a move of one of `knowns` moves; `settle` brings the model to a time.
    fn add(
        &self,
        found: &mut [Unknown],
        knowns: &[Known],
        probe: &mut Probe,
        point: impl Fn() -> Box<dyn Model>,
        settle: impl Fn(&mut Box<dyn Model>, f64) -> bool,
        time: f64,
    ) {
        let read = |mut model: Box<dyn Model>, time: f64| {
            if settle(&mut model, time) { self.read(model.as_mut()) } else { None }
        };
        let Some(before) = read(point(), time) else { return };
        for &known in knowns {
            for value in self.moves(known, probe, point().as_mut()) {
                let mut model = point();
                let mut at = time;
                match known {
                    Known::Entry(k) => {
                        let entry = &self.declaration.entries[k];
                        if entry.check(value, false).is_err() {
                            continue;
                        }
                        model.set(entry.slot, value);
                    }
                    Known::State(n, _) => {
                        let mut states = vec![0.0; n + 1];
                        model.read_states(&mut states);
                        states[n] = value;
                        model.write_states(&states);
                    }
                    Known::Time => at = value,
                }
                let Some(after) = read(model, at) else { continue };
                for (unknown, _) in
                    found.iter_mut().zip(before.iter().zip(&after)).filter(|(_, (b, a))| a != b)
                {
                    match known {
                        Known::Entry(k) | Known::State(_, k) if !unknown.on.contains(&k) => {
                            unknown.on.push(k)
                        }
                        Known::Entry(_) | Known::State(..) => {}
                        Known::Time => unknown.on_time = true,
                    }
                }
            }
        }
    }

    /// The unknowns, bit by bit.
    fn read(&self, model: &mut dyn Model) -> Option<Vec<u64>> {
        let mut rates = vec![0.0; self.declaration.states.len()];
        model.derivatives(&mut rates).ok()?;
        let value = |&k: &usize| {
            let slot = self.declaration.entries[k].slot;
            // A zero that turns its sign has not moved.
            let value = if slot.group == Slot::RATES { rates[slot.row as usize] } else { model.get(slot) };
            (value + 0.0).to_bits()
        };
        Some(self.unknowns.iter().map(value).collect())
    }

    /// Values that a known takes in turn.
    fn moves(&self, known: Known, probe: &mut Probe, model: &mut dyn Model) -> Vec<f64> {
        let entry = match known {
            Known::Entry(k) | Known::State(_, k) => &self.declaration.entries[k],
            Known::Time => return vec![START + probe.share(), START + 1e3 * probe.share()],
        };
        if let Known::State(..) = known {
            let (value, way) = (model.get(entry.slot), 0.01 * entry.row.nominal);
            // The last so far that a limit is passed, also by a difference of temperatures.
            let far = if entry.row.relative { 300.0 } else { 60.0 * way };
            return vec![value + way * probe.share(), value - way * probe.share(), value + far];
        }
        match entry.row.kind {
            Kind::Enumeration(t) => t.items.iter().map(|i| f64::from(i.value)).collect(),
            Kind::Boolean => vec![0.0, 1.0],
            Kind::Integer => vec![entry.row.start - 1.0, entry.row.start + 1.0, entry.row.min, entry.row.max],
            Kind::Real => {
                let (one, other) = (probe.generic(entry, self.starts), probe.generic(entry, self.starts));
                vec![one, other, entry.row.min, entry.row.max]
            }
        }
    }
}

/// Numbers without pattern, the same at every run.
struct Probe(u64);

impl Probe {
    /// Those of one point of one combination, whichever is looked at first.
    fn new(combination: usize, point: usize) -> Probe {
        Probe((combination as u64) << 40 | (point as u64) << 32)
    }

    /// A share in (0, 1): a counter whose bits are mixed (Steele, Lea, Flood 2014, SplitMix64), so that no two uses keep step.
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) as f64 / u64::MAX as f64).clamp(0.05, 0.95)
    }

    /// About half of these.
    fn half_of(&mut self, all: &[&'static str]) -> Vec<&'static str> {
        all.iter().copied().filter(|_| self.share() < 0.5).collect()
    }

    /// Moves every state of a model that has started, by a share of its typical size; false where it has no rates there.
    fn push(&mut self, model: &mut dyn Model, count: usize) -> bool {
        let declaration = model.declaration();
        let mut states = vec![0.0; count];
        model.read_states(&mut states);
        for (state, [entry, _]) in states.iter_mut().zip(&declaration.states) {
            *state += 0.1 * self.share() * declaration.entries[*entry].row.nominal;
        }
        model.write_states(&states);
        model.update();
        model.derivatives(&mut states).is_ok()
    }

    /// A value within the limits, of the variable's typical size, and not its start; counts and choices at their start.
    fn generic(&mut self, entry: &Entry, starts: &StartValues) -> f64 {
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
            _ => starts.of(entry),
        }
    }
}
