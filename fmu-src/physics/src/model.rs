//! Interface of every model: a declaration, values by slot, and steps.

use crate::exchange::Exchange;
pub use crate::fault::Fault;
use crate::load_table::LoadTable;
use crate::terms::{Drivers, GenericTerm};
use crate::token::Token;
use declare::{Causality, Elements, Kind, State, Variability, Variable};
use std::collections::BTreeSet;
use std::fmt;
use std::sync::OnceLock;

/// A group of variables within a model.
#[derive(Clone, Copy, Debug)]
pub struct GroupAt {
    /// Prefix of each name, for example `motor.`.
    pub prefix: &'static str,
    /// Offset of each value reference of the table.
    pub base: u32,
    /// The rows.
    pub table: &'static [Variable],
}

/// Position of a variable in a model: group and row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Index of the group in [`Declaration::groups`].
    pub group: u16,
    /// Index of the row in the group's table.
    pub row: u16,
}

impl Slot {
    /// The group of the continuous states; rows in their order.
    pub const STATES: u16 = u16::MAX - 1;
    /// The group of the derivatives of the states.
    pub const RATES: u16 = u16::MAX;
}

/// Position of an entry in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    /// Index, from 1.
    pub index: u32,
    /// Number of elements.
    pub of: Elements,
    /// Whether the whole array is an output.
    pub shown: bool,
}

/// A variable of a model, with its full name and value reference.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Full name, for example `motor.R_ref`.
    pub name: String,
    /// Full value reference, unique in the model and never re-used.
    pub value_reference: u32,
    /// Position of the value.
    pub slot: Slot,
    /// Declaration of the variable.
    pub row: &'static Variable,
    /// Position in an array, if it is an element.
    pub element: Option<Element>,
}

/// Variables of shared components that a model omits, because they would have no effect.
#[derive(Clone, Copy, Debug)]
pub struct Unserved {
    /// Prefix of their names.
    pub start: &'static str,
    /// Why the model omits them, and what to use instead.
    pub reason: &'static str,
}

/// Everything about a model that does not change at run time.
#[derive(Debug)]
pub struct Declaration {
    /// Name, also the FMI model identifier.
    pub name: &'static str,
    /// Description, one sentence.
    pub description: &'static str,
    /// All groups, in the order of the tables.
    pub groups: Vec<GroupAt>,
    /// All variables, in the order of the groups and of their value references; then each state with its derivative.
    pub entries: Vec<Entry>,
    /// The continuous states, in their order: indices of the entries of state and derivative. States whose number depends on
    /// a parameter come last, so that the states in use are the first ones.
    pub states: Vec<[usize; 2]>,
    /// The event indicators, in their order: indices of their entries.
    pub indicators: Vec<usize>,
    /// The parameters that give the number of elements of a variable: indices of their entries.
    pub dimensions: Vec<usize>,
    /// Hash of the variable table: FMI 2 GUID and FMI 3 instantiation token of an archive without start values, terms and load table.
    pub token: Token,
    by_reference: Vec<Option<u32>>,
    /// Name and value reference of the variables of shared components that the model omits, with the reason.
    unserved: Vec<(String, u32, &'static str)>,
}

impl Declaration {
    /// The declaration from a list of groups and of continuous states, without the omitted variables.
    pub fn new(
        name: &'static str,
        description: &'static str,
        groups: Vec<GroupAt>,
        states: &'static [State],
        without: &[Unserved],
    ) -> Declaration {
        let mut entries: Vec<Entry> = Vec::new();
        let mut unserved = Vec::new();
        for (g, group) in groups.iter().enumerate() {
            let mut rows: Vec<(usize, &'static Variable)> = group.table.iter().enumerate().collect();
            rows.sort_by_key(|(_, row)| row.value_reference);
            for (r, row) in rows {
                let name = format!("{}{}", group.prefix, row.name);
                let value_reference = group.base + row.value_reference;
                if let Some(absent) = without.iter().find(|absent| name.starts_with(absent.start)) {
                    unserved.push((name, value_reference, absent.reason));
                    continue;
                }
                entries.push(Entry {
                    name,
                    value_reference,
                    slot: Slot { group: g as u16, row: r as u16 },
                    row,
                    element: None,
                });
            }
        }
        let local = |entry: &Entry| entry.row.causality == Causality::Local;
        let indicators = (0..entries.len()).filter(|&k| local(&entries[k])).collect();
        let states = enter_states(&mut entries, states);
        let counts = |e: &Entry| match e.element {
            Some(Element { of: Elements::UpTo(_, name), .. }) => Some(name),
            _ => None,
        };
        let counts: BTreeSet<&str> = entries.iter().filter_map(counts).collect();
        let dimensions = (0..entries.len()).filter(|&k| counts.contains(entries[k].name.as_str())).collect();
        let last = entries.iter().map(|e| e.value_reference).max().unwrap_or(0) as usize;
        let mut by_reference = vec![None; last + 1];
        for (k, entry) in entries.iter().enumerate() {
            by_reference[entry.value_reference as usize] = Some(k as u32);
        }
        let token =
            Token::of_table(name, entries.iter().map(|e| (e.value_reference, e.name.as_str(), e.row)));
        Declaration {
            name,
            description,
            groups,
            entries,
            states,
            indicators,
            dimensions,
            token,
            by_reference,
            unserved,
        }
    }

    /// One sentence about a variable of this name that other models have and this one omits.
    pub fn unserved(&self, name: &str) -> Option<String> {
        self.sentence(self.unserved.iter().find(|absent| absent.0 == name)?)
    }

    /// The same for a value reference.
    pub fn unserved_reference(&self, value_reference: u32) -> Option<String> {
        self.sentence(self.unserved.iter().find(|absent| absent.1 == value_reference)?)
    }

    fn sentence(&self, (name, _, reason): &(String, u32, &'static str)) -> Option<String> {
        Some(format!("{} has no variable {name}: {reason}", self.name))
    }

    /// The variable with this value reference.
    #[inline]
    pub fn by_reference(&self, value_reference: u32) -> Option<&Entry> {
        let k = (*self.by_reference.get(value_reference as usize)?)?;
        self.entries.get(k as usize)
    }

    /// Whether a variable is the number of elements of another.
    pub fn is_dimension(&self, entry: &Entry) -> bool {
        self.dimensions.iter().any(|&k| self.entries[k].value_reference == entry.value_reference)
    }

    /// The variable with this name.
    pub fn by_name(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.name == name)
    }
}

/// Appends every state with its derivative to the entries; returns their indices.
fn enter_states(entries: &mut Vec<Entry>, states: &'static [State]) -> Vec<[usize; 2]> {
    let mut places = Vec::new();
    for state in states {
        for k in 0..state.elements.most() {
            let element = match state.elements {
                Elements::One => None,
                of => Some(Element { index: k + 1, of, shown: state.shown }),
            };
            let name = match element {
                None => state.value.name.to_string(),
                Some(element) => format!("{}[{}]", state.value.name, element.index),
            };
            let row = places.len() as u16;
            let entry = |group: u16, name: String, variable: &'static Variable| Entry {
                name,
                value_reference: variable.value_reference + k,
                slot: Slot { group, row },
                row: variable,
                element,
            };
            places.push([entries.len(), entries.len() + 1]);
            let rate = entry(Slot::RATES, format!("der({name})"), &state.rate);
            entries.push(entry(Slot::STATES, name, &state.value));
            entries.push(rate);
        }
    }
    places
}

/// Value reference of the independent variable, time, in every model.
pub const TIME: u32 = 0;

/// Reason for rejecting a value.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// Not a number, or infinite.
    NotFinite,
    /// Below or above the declared limits.
    OutOfRange,
    /// Not an integer where one is required.
    NotWhole,
    /// Not an item of the enumeration, or not a Boolean.
    NoSuchItem,
    /// Computed by the model.
    Computed,
    /// Fixed after initialization.
    Fixed,
}

impl Entry {
    /// Whether an importer may set an input derivative for the variable.
    pub fn is_continuous_input(&self) -> bool {
        self.row.causality == Causality::Input && self.row.variability == Variability::Continuous
    }

    /// Whether an importer may read or set it in intermediate update mode: continuous inputs and outputs.
    pub fn is_intermediate(&self) -> bool {
        let shown = self.element.is_some_and(|element| element.shown) && self.slot.group == Slot::STATES;
        self.row.kind == Kind::Real
            && self.row.variability == Variability::Continuous
            && (shown || matches!(self.row.causality, Causality::Input | Causality::Output))
    }

    /// Whether it is a limit of the range in which the equations hold, where a run ends.
    pub fn is_limit_of_validity(&self) -> bool {
        self.name.starts_with("validity.")
    }

    /// Whether it can be set: an input or a parameter.
    pub fn is_settable(&self) -> bool {
        matches!(self.row.causality, Causality::Input | Causality::Parameter)
    }

    /// Whether `value` may be set; `running` is true after initialization.
    #[inline]
    pub fn check(&self, value: f64, running: bool) -> Result<(), Refusal> {
        let row = self.row;
        if !self.is_settable() {
            return Err(Refusal::Computed);
        }
        if running && row.variability == Variability::Fixed {
            return Err(Refusal::Fixed);
        }
        match row.kind {
            Kind::Real | Kind::Integer if !value.is_finite() => Err(Refusal::NotFinite),
            Kind::Real | Kind::Integer if value < row.min || value > row.max => Err(Refusal::OutOfRange),
            Kind::Integer if value.fract() != 0.0 => Err(Refusal::NotWhole),
            Kind::Real | Kind::Integer => Ok(()),
            Kind::Boolean if value == 0.0 || value == 1.0 => Ok(()),
            Kind::Enumeration(t) if t.items.iter().any(|i| f64::from(i.value) == value) => Ok(()),
            _ => Err(Refusal::NoSuchItem),
        }
    }

    /// One sentence about a rejected value: name, value, limits, unit.
    pub fn explain(&self, value: f64, refusal: &Refusal) -> String {
        let name = &self.name;
        // A dimensionless value is written without unit.
        let unit = match self.row.unit.name() {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        let (low, high) = (self.row.min, self.row.max);
        let celsius = match self.row.relative {
            true => String::new(),
            false => self.row.unit.celsius_clause(value, [low, high]),
        };
        // Not hundreds of digits.
        let value = if value.abs() < 1e15 { value.to_string() } else { format!("{value:e}") };
        match refusal {
            Refusal::NotFinite => format!(
                "{name} = {value} is not a finite number; it must lie in {} ... {}{unit}.",
                self.row.min, self.row.max
            ),
            Refusal::OutOfRange => {
                format!("{name} = {value}{unit} is outside its limits {low} ... {high}{unit}{celsius}.")
            }
            Refusal::NotWhole => format!(
                "{name} = {value} is not a whole number; it must lie in {} ... {}.",
                self.row.min, self.row.max
            ),
            Refusal::NoSuchItem => {
                let choices = match self.row.kind {
                    Kind::Enumeration(t) => t
                        .items
                        .iter()
                        .map(|i| format!("{} = {}", i.value, i.name))
                        .collect::<Vec<_>>()
                        .join(", "),
                    _ => "0 = false, 1 = true".to_string(),
                };
                format!("{name} = {value} is none of its values: {choices}.")
            }
            Refusal::Computed => format!("{name} is computed by the model and cannot be set to {value}."),
            Refusal::Fixed => format!(
                "{name} is fixed after initialization and cannot be set to {value}{unit} while the model runs."
            ),
        }
    }
}

/// Heat flow from the housing to ambient, with the temperatures of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HousingHeat {
    /// Mean temperature of the housing, K.
    pub housing: f64,
    /// Ambient temperature, K.
    pub ambient: f64,
    /// Heat flow by all paths: convection, radiation, mount, air flow and tube, W.
    pub flow: f64,
}

/// Interface of a model to the FMI layer and the tools.
///
/// Values are numbers in SI units; integers are whole numbers, Booleans 0 or 1, enumerations their FMI value. The caller checks
/// values by [`Entry::check`] before it sets them.
pub trait Model: Exchange + Send + Sync {
    /// The declaration of the model.
    fn declaration(&self) -> &'static Declaration;
    /// The value of a slot; outputs at the present time.
    fn get(&mut self, slot: Slot) -> f64;
    /// Sets a parameter or an input; false if the value is invalid for its type.
    fn set(&mut self, slot: Slot, value: f64) -> bool;
    /// Sets several parameters and inputs, and then once what follows from them; false if a value is invalid for its type.
    fn set_all(&mut self, values: &[(Slot, f64)]) -> bool {
        values.iter().fold(true, |taken, (slot, value)| self.set(*slot, *value) && taken)
    }
    /// Sets the input derivative of a continuous input for the next step, per second. It is valid for that step only; afterwards
    /// the input keeps its extrapolated value.
    fn set_slope(&mut self, slot: Slot, slope: f64);
    /// The input derivative that [`set_slope`](Model::set_slope) has set for the next step, per second.
    fn slope(&self, slot: Slot) -> f64;
    /// Why the model does not take a term that is data, in a few words about the model; `None` if it does.
    fn refusal(&self, _term: &GenericTerm) -> Option<&'static str> {
        Some("it takes no terms")
    }
    /// Replaces the terms that are data (`terms.rs`), before the start; returns false and changes nothing
    /// if the model [refuses](Model::refusal) any or accepts fewer.
    fn set_terms(&mut self, _terms: &[GenericTerm]) -> bool {
        false
    }
    /// Sets a load table (`load_table.rs`), before the start; false if the model does not use one.
    fn set_load(&mut self, _table: &LoadTable) -> bool {
        false
    }
    /// Ends initialization at `time`: checks the consistency of the parameters, sets all states.
    fn start(&mut self, time: f64) -> Result<(), Fault>;
    /// Sets several parameters and inputs, and starts; what follows from them is evaluated at the start only.
    ///
    /// # Errors
    /// As [`start`](Model::start).
    fn start_with(&mut self, values: &[(Slot, f64)], time: f64) -> Result<(), Fault> {
        self.set_all(values);
        self.start(time)
    }
    /// Advances from `time`, the caller's time, by `h` > 0 seconds; on failure nothing changes, unless the model has
    /// [`ended`](Model::ended).
    fn step(&mut self, time: f64, h: f64) -> Result<(), Fault>;
    /// Whether the last step failed at a limit of validity: the model then is at the last time within the limit, and the run is
    /// over.
    fn ended(&self) -> bool {
        false
    }
    /// This limit with its cause, without what belongs to the instant; `None` unless the model has [`ended`](Model::ended).
    fn passed_limit(&self) -> Option<String> {
        None
    }
    /// The present time of the model, s.
    fn time(&self) -> f64;
    /// The continuous states that the rates depend on; their order depends on the model's modes and effects.
    fn states(&self, out: &mut Vec<f64>);
    /// Sets the time and the values of [`states`](Model::states); returns false and changes nothing if their number
    /// differs.
    fn set_states(&mut self, time: f64, states: &[f64]) -> bool;
    /// Derivatives of [`states`](Model::states) at the present states and inputs, per second; independent of input
    /// derivatives.
    fn rates(&mut self, out: &mut Vec<f64>);
    /// Multiplies the error tolerances of the steps by these factors, that of heat, and that of current and speed, until the next start:
    /// for searches that repeat a run many times and use the result only.
    fn ease(&mut self, factors: [f64; 2]);
    /// Multiplies the tolerances of the integrator by a factor on their defaults, until the next start.
    fn scale_tolerances(&mut self, factor: f64);
    /// Number of steps rejected by the error control; only differences over a step are meaningful.
    fn rejected_steps(&self) -> u64;
    /// Heat flow from the housing to ambient at the present time, with the true instead of the indicated temperatures;
    /// `None` if the housing is not in contact with ambient.
    fn housing_heat(&mut self) -> Option<HousingHeat> {
        None
    }
    /// Drivers of terms at the present time.
    fn drivers(&self) -> Drivers;
    /// The complete state of the instance, as numbers.
    fn save(&self, out: &mut Vec<f64>);
    /// Restores the state from [`save`](Model::save); false if the length differs.
    fn restore(&mut self, saved: &[f64]) -> bool;
    /// An independent copy.
    fn boxed_clone(&self) -> Box<dyn Model>;
    /// Copies another instance of the same model into this one, without allocation; false if it is another
    /// model.
    fn copy_from(&mut self, other: &dyn Model) -> bool;
    /// Used by [`copy_from`](Model::copy_from).
    fn as_any(&self) -> &dyn std::any::Any;
}

/// A kind of model: its declaration and its constructor.
pub struct ModelType {
    /// The declaration, created at the first call.
    pub declaration: fn() -> &'static Declaration,
    /// A new instance with its start values.
    pub new: fn() -> Box<dyn Model>,
}

impl fmt::Debug for ModelType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ModelType").field("name", &(self.declaration)().name).finish()
    }
}

/// A declaration that is created once.
pub type Declared = OnceLock<Declaration>;

/// Relative tolerance that corresponds to the default accuracy of the integrators.
pub const TOLERANCE: f64 = 1e-6;

/// Log categories of every FMU: name and description; the last one includes all.
/// The names of FMI 2.0.5 section 2.2.4, and one additional category.
pub const LOG_CATEGORIES: &[(&str, &str)] = &[
    ("logStatusError", "Reason of each call that returns Error"),
    ("logStatusDiscard", "Reason of each call that returns Discard"),
    (
        "logStatusWarning",
        "Reason of each call that returns Warning, and of the end of a run at a limit of validity",
    ),
    ("logEvents", "Changes of the state of the instance, time events, changes of discrete outputs"),
    ("logRejectedSteps", "Communication steps in which the integrator rejected steps because of their error"),
    ("logAll", "All messages"),
];
