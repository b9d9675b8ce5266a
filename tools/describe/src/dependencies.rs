//! Dependencies of outputs, derivatives and event indicators on inputs, states and parameters, determined by varying each.
//!
//! The model is evaluated in every combination of its modes, at points where no effect is neutral. A dependency that
//! occurs in any of them is declared. The declared dependencies therefore follow the equations.
//!
//! The dependencies of a model without generic terms are determined at many points and stored ([`known`]); those that
//! generic terms or another number of elements add are determined at fewer points and in fewer combinations: they follow from the driver of a term, which depends on
//! drive and shaft, and from what its port acts on, which depends on the cooling.

mod known;
mod laws;
mod probe;

use crate::preset::StartValues;
use physics::declare::{Causality, Kind, Unit, Variability};
use physics::model::{Declaration, Entry, Model, ModelType, Slot};
use physics::resources::Resources;
pub(crate) use probe::Probe;
use rayon::prelude::*;

/// Start time, s; late, so that a drift has become large enough to change a Boolean output.
pub(crate) const START: f64 = 1e5;

/// A computed variable and its dependencies.
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
    /// The union with other dependencies of the same variable.
    fn and(mut self, other: Unknown) -> Unknown {
        self.on_time |= other.on_time;
        self.on.extend(other.on);
        self.on.sort_unstable();
        self.on.dedup();
        self
    }
}

/// Unknowns during the simulation, and at its start.
type Both = (Vec<Unknown>, Vec<Unknown>);

/// All dependencies, in the order of the declaration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependencies {
    /// Direct dependencies of the outputs on inputs, states and time.
    pub outputs: Vec<Unknown>,
    /// Direct dependencies of the state derivatives.
    pub rates: Vec<Unknown>,
    /// Direct dependencies of the event indicators.
    pub indicators: Vec<Unknown>,
    /// Dependencies of outputs, states and derivatives on inputs and parameters at the start.
    pub initial: Vec<Unknown>,
}

/// A point with given modes: factor on the inputs, and whether all effects are active.
type Point = (f64, bool);
/// Inputs of nominal size and a thousand times smaller: a quantity that saturates at one changes at the other. Then half
/// of the effects, because some replace a direct path by a node; parts that are no node by default are none there in half
/// of the combinations. The initial state is that of rest at the ambient temperature
/// at the first point, and another one at the second, there with half of the effects.
const POINTS: [Point; 3] = [(1.0, true), (1e-3, true), (1.0, false)];
/// Repetitions of all points for the stored dependencies, so that each point of the fan curve has an influence once.
const TURNS: usize = 4;

/// A quantity that is varied.
#[derive(Clone, Copy, Debug)]
enum Known {
    Entry(usize),
    /// Place among the states, index of the entry.
    State(usize, usize),
    Time,
}

/// The values of a real variable that is varied.
#[derive(Clone, Copy)]
enum Values {
    /// Two within its limits, and these.
    All,
    /// Two within its limits.
    Within,
    /// One within its limits, and these, where the smoothing of a sign shows.
    OneAndLimits,
}

/// What is evaluated to determine the dependencies.
struct Effort<'a> {
    points: &'a [Point],
    /// Greatest number of combinations of the modes.
    combinations: usize,
    values: Values,
}

impl Effort<'static> {
    const FULL: Effort<'static> = Effort { points: &POINTS, combinations: usize::MAX, values: Values::All };
    /// For generic terms: with all effects and with some, because an effect may replace the node that a driver belongs to; in the
    /// combinations of cooling, drive, shaft and commutation of the motor. A law without a range moves with its driver everywhere, so that
    /// one value within the limits shows it.
    const OF_TERMS: Effort<'static> =
        Effort { points: &[POINTS[0], POINTS[2]], combinations: 144, values: Values::OneAndLimits };
}

impl Dependencies {
    /// The dependencies of a model with these resources; the start values give the number of elements.
    pub fn of(kind: &ModelType, resources: &Resources, starts: &StartValues) -> Dependencies {
        let declaration = (kind.declaration)();
        let resources = laws::without_ranges(resources);
        let Some(known) = Dependencies::known(declaration, starts) else {
            return Dependencies::found(kind, &resources, starts, &Effort::FULL);
        };
        // Only numbers of elements among the start values change the set of variables.
        let counts = declaration.entries.iter().filter(|entry| declaration.is_dimension(entry));
        let usual = counts.into_iter().all(|entry| starts.of(entry) == entry.row.start);
        if resources.is_empty() && usual {
            return known;
        }
        let more = known.and(Dependencies::found(kind, &resources, starts, &Effort::OF_TERMS));
        // The elements that the stored dependencies have not are like those that they have.
        if usual { more } else { more.of_arrays(declaration) }
    }

    /// The dependencies of a model without terms, determined at all points.
    pub fn of_all(kind: &ModelType) -> Dependencies {
        let points = [POINTS; TURNS].concat();
        let effort = Effort { points: &points, ..Effort::FULL };
        // The points of the fan curve act in few of the combinations, and hardly on the derivatives of some segments.
        let found = Dependencies::found(kind, &Resources::default(), &StartValues::default(), &effort);
        found.of_arrays((kind.declaration)())
    }

    /// The stored dependencies, and those of all points without repetition: the same unless the equations have changed.
    pub fn sampled(kind: &ModelType) -> Dependencies {
        let starts = StartValues::default();
        match Dependencies::known((kind.declaration)(), &starts) {
            Some(known) => {
                known.and(Dependencies::found(kind, &Resources::default(), &starts, &Effort::FULL))
            }
            None => Dependencies::of_all(kind),
        }
    }

    /// The union with other dependencies of the same unknowns.
    fn and(self, other: Dependencies) -> Dependencies {
        Dependencies {
            outputs: union(self.outputs, other.outputs),
            rates: union(self.rates, other.rates),
            indicators: union(self.indicators, other.indicators),
            initial: union(self.initial, other.initial),
        }
    }

    /// The same where each element of an array has what any element of it depends on among the variables that are no elements: all have the
    /// same equation.
    fn of_arrays(mut self, declaration: &Declaration) -> Dependencies {
        let entry = |k: usize| &declaration.entries[k];
        for list in [&mut self.outputs, &mut self.rates, &mut self.initial] {
            let all = list.clone();
            for own in list.iter_mut().filter(|own| entry(own.entry).element.is_some()) {
                let row = entry(own.entry).row;
                let array = all.iter().filter(|other| std::ptr::eq(row, entry(other.entry).row)).cloned();
                *own = array.fold(own.clone(), |sum, other| {
                    let on = other.on.into_iter().filter(|k| entry(*k).element.is_none()).collect();
                    sum.and(Unknown { on, ..other })
                });
            }
        }
        self
    }

    /// The dependencies determined with this effort.
    fn found(kind: &ModelType, resources: &Resources, starts: &StartValues, effort: &Effort) -> Dependencies {
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
        let combinations = combinations(declaration, &choices, effort.combinations);
        let points = combinations.par_iter().enumerate().flat_map_iter(|(k, combination)| {
            let points = effort.points.iter().enumerate();
            points.map(move |(turn, point)| (k, combination, *point, turn, Probe::new(k, turn)))
        });
        type Place<'a> = (usize, &'a Vec<(usize, f64)>, Point, usize, Probe);
        let look = |(place, combination, (scale, effects), turn, mut probe): Place| -> Both {
            // Repetitions of a point find nothing new at the limits.
            let values = if turn < POINTS.len() { effort.values } else { Values::Within };
            let (mut running, mut initial) = none();
            let mut model = (kind.new)();
            resources.give(model.as_mut());
            model.enter_model_exchange();
            // The time of an event keeps its value, so that its consequences are visible at the start.
            let absent = if effects { Vec::new() } else { probe.half_of(&effects_of(declaration)) };
            let there = |entry: &Entry| !absent.iter().any(|prefix| entry.name.starts_with(prefix));
            let (of_start, rest): (Vec<usize>, Vec<usize>) =
                settable.iter().partition(|&&k| is_initial_value(&declaration.entries[k]));
            for &k in rest.iter().filter(|&&k| declaration.entries[k].row.unit != Unit::Second) {
                let entry = &declaration.entries[k];
                let factor = if entry.row.causality == Causality::Input && entry.row.start == 0.0 {
                    scale
                } else {
                    1.0
                };
                if there(entry) {
                    let value = factor * probe.generic(entry, starts);
                    if effects || place % 2 == 1 || !is_off(entry) {
                        model.set(entry.slot, value);
                    }
                }
            }
            for &(k, value) in combination {
                model.set(declaration.entries[k].slot, value);
            }
            if effects {
                let mut start = model.boxed_clone();
                if scale != 1.0 {
                    for &k in &of_start {
                        let entry = &declaration.entries[k];
                        // Temperatures have limits of validity.
                        let factor = if entry.row.unit == Unit::Kelvin { 1.0 } else { scale };
                        start.set(entry.slot, factor * probe.generic(entry, starts));
                    }
                    // An effect may decide which node an initial value belongs to.
                    let off = probe.half_of(&effects_of(declaration));
                    for entry in rest.iter().map(|&k| &declaration.entries[k]) {
                        let is_off = place % 2 == 0 && is_off(entry);
                        if is_off || off.iter().any(|prefix| entry.name.starts_with(prefix)) {
                            start.set(entry.slot, starts.of(entry));
                        }
                    }
                }
                let point = || start.boxed_clone();
                let note = Note { declaration, unknowns: &at_start, starts, values };
                note.add(&mut initial, &decide, &mut probe, point, |m, time| m.start(time).is_ok(), START);
            }
            // A point away from rest, at which each input is varied alone.
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
                let note = Note { declaration, unknowns: &at_once, starts, values };
                note.add(&mut running, &move_at_once, &mut probe, point, settle, START);
            }
            (running, initial)
        };
        let (mut running, initial) =
            points.map(look).reduce(none, |all, one| (union(all.0, one.0), union(all.1, one.1)));
        let indicators = running.split_off(outputs.len() + rates.len());
        let rates = running.split_off(outputs.len());
        Dependencies { outputs: running, rates, indicators, initial }
    }
}

/// The union of the dependencies of the same unknowns.
fn union(own: Vec<Unknown>, other: Vec<Unknown>) -> Vec<Unknown> {
    own.into_iter().zip(other).map(|(own, other)| own.and(other)).collect()
}

fn indices(declaration: &Declaration, which: impl Fn(&Entry) -> bool) -> Vec<usize> {
    declaration.entries.iter().enumerate().filter(|(_, e)| which(e)).map(|(k, _)| k).collect()
}

/// Whether a parameter is a start value of a state: of the real parameters these alone are fixed.
fn is_initial_value(entry: &Entry) -> bool {
    entry.row.kind == Kind::Real && entry.row.variability == Variability::Fixed
}

/// Whether it is the heat capacity of a part that is no node by default.
fn is_off(entry: &Entry) -> bool {
    entry.row.unit == Unit::JoulePerKelvin && entry.row.start == 0.0
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

/// Largest number of combinations that are all evaluated.
const FEW: usize = 64;
/// Every combination of the items of the model's enumerations. If there are too many, the enumerations of effects, which do
/// not interact, alternate: each of their items occurs in many combinations. So do the last of the others if there are more than `most`.
fn combinations(declaration: &Declaration, choices: &[usize], most: usize) -> Vec<Vec<(usize, f64)>> {
    let entries = &declaration.entries;
    let items = |k: usize| match entries[k].row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| (k, f64::from(i.value))).collect(),
        _ => Vec::new(),
    };
    let count: usize = choices.iter().map(|&k| items(k).len()).product();
    let (whole, mut own): (Vec<usize>, Vec<usize>) =
        choices.iter().partition(|&&k| count <= FEW || !entries[k].name.starts_with("effect."));
    let mut product = 1;
    let (whole, further): (Vec<usize>, Vec<usize>) = whole.into_iter().partition(|&k| {
        product *= items(k).len();
        product <= most
    });
    own.extend(further);
    let mut all = whole.iter().fold(vec![Vec::new()], |all: Vec<Vec<(usize, f64)>>, &k| {
        let with = |one: &Vec<(usize, f64)>, item| [one.as_slice(), &[item]].concat();
        all.iter().flat_map(|one| items(k).into_iter().map(move |item| with(one, item))).collect()
    });
    for (turn, &k) in own.iter().enumerate() {
        let items = items(k);
        for (n, one) in all.iter_mut().enumerate() {
            // Different periods, so that two such enumerations are not correlated.
            one.push(items[(n / (turn + 1) + turn) % items.len()]);
        }
    }
    all
}

/// The quantities that are observed while another one is varied.
struct Note<'a> {
    declaration: &'static Declaration,
    /// Entries that may change.
    unknowns: &'a [usize],
    starts: &'a StartValues,
    values: Values,
}

impl Note<'_> {
    /// Adds to `found` every unknown that changes with one of `knowns`; `settle` evaluates the model at a time.
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
            for value in self.moves(known, probe, &point) {
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

    /// The unknowns as bit patterns.
    fn read(&self, model: &mut dyn Model) -> Option<Vec<u64>> {
        let mut rates = vec![0.0; self.declaration.states.len()];
        model.derivatives(&mut rates).ok()?;
        let value = |&k: &usize| {
            let slot = self.declaration.entries[k].slot;
            // A zero that changes its sign has not changed.
            let value = if slot.group == Slot::RATES { rates[slot.row as usize] } else { model.get(slot) };
            (value + 0.0).to_bits()
        };
        Some(self.unknowns.iter().map(value).collect())
    }

    /// The values of a varied quantity.
    fn moves(&self, known: Known, probe: &mut Probe, point: impl Fn() -> Box<dyn Model>) -> Vec<f64> {
        let entry = match known {
            Known::Entry(k) | Known::State(_, k) => &self.declaration.entries[k],
            Known::Time => return vec![START + probe.fraction(), START + 1e3 * probe.fraction()],
        };
        let row = entry.row;
        if let Known::State(..) = known {
            let (value, way) = (point().get(entry.slot), 0.01 * row.nominal);
            // The last value is far enough to pass a limit, also for a temperature difference.
            let far = if row.relative { 300.0 } else { 60.0 * way };
            return vec![value + way * probe.fraction(), value - way * probe.fraction(), value + far];
        }
        match row.kind {
            Kind::Enumeration(t) => t.items.iter().map(|i| f64::from(i.value)).collect(),
            Kind::Boolean => vec![0.0, 1.0],
            Kind::Integer => vec![row.start - 1.0, row.start + 1.0, row.min, row.max],
            Kind::Real => {
                let [one, other] = [(); 2].map(|()| probe.generic(entry, self.starts));
                match self.values {
                    Values::All => vec![one, other, row.min, row.max],
                    Values::Within => vec![one, other],
                    Values::OneAndLimits => vec![one, row.min, row.max],
                }
            }
        }
    }
}
