//! What the model description declares about the running FMU, as owned data.

use crate::validate::finding::{Findings, short};
use crate::validate::model::{self, FmiVersion, Model, Unknown, unsigned, unsigned_list};
use crate::validate::semantics::arrays;
use crate::validate::xml::{Xml, decode};
use cosim::elements::FILE;
use cosim::raw::InterfaceType;
use cosim::xml::{parse_boolean, parse_double, parse_integer};
use cosim::{Archive, Interface, Kind, ModelDescription};
use std::fmt::{Display, Formatter};

/// Largest number of elements of an array that are read.
const LARGEST_ARRAY: usize = 1 << 20;

#[derive(Clone, Debug)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) reference: u32,
    pub(super) kind: Kind,
    pub(super) causality: String,
    pub(super) variability: String,
    pub(super) initial: Option<String>,
    /// Start values as numbers, one for each element; empty without a start value or for a string.
    pub(super) start: Vec<f64>,
    /// The start values of 64-bit integers without rounding.
    pub(super) exact: Vec<i128>,
    /// The start value of a string or of binary data.
    pub(super) text: Option<String>,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    pub(super) nominal: f64,
    /// Name of its unit.
    pub(super) unit: Option<String>,
    /// Number of elements, 1 for a scalar.
    pub(super) size: usize,
    pub(super) clocked: bool,
    /// An event may change this state.
    pub(super) reinit: bool,
    /// `modelDescription.xml:12`
    pub(super) place: String,
}

impl Variable {
    /// Its limits, in words.
    pub(super) fn limits(&self) -> String {
        let limit = |x: Option<f64>| x.map_or("none".to_owned(), |x| x.to_string());
        format!("min {}, max {}", limit(self.min), limit(self.max))
    }
    pub(super) fn is(&self, causality: &str) -> bool {
        self.causality == causality
    }
    pub(super) fn is_continuous(&self) -> bool {
        self.kind == Kind::Float64 && self.variability == "continuous"
    }
    /// Whether an importer may set it before initialisation.
    pub(super) fn is_settable(&self) -> bool {
        self.variability != "constant"
            && !self.is("independent")
            && !self.clocked
            && (self.is("input") || self.initial.as_deref() == Some("exact"))
    }
    /// Whether importers may set it in this client's runs: numbers, not the sizes of arrays.
    pub(super) fn is_free(&self) -> bool {
        self.is_settable()
            && self.kind.is_numeric()
            && !self.is("structuralParameter")
            && self.start.len() == self.size
    }
    /// A value within the limits that differs from the start value; the start value if there is no other.
    pub(super) fn other_value(&self) -> f64 {
        let start = self.start.first().copied().unwrap_or(0.0);
        if !self.kind.is_float() {
            return start;
        }
        let step = if start == 0.0 { 0.5 * self.nominal } else { 0.1 * start.abs() };
        let (low, high) = (self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY));
        if start + step <= high {
            start + step
        } else if high.is_finite() && high - start > 1e-9 * step {
            0.5 * (start + high)
        } else if start - step >= low {
            start - step
        } else if low.is_finite() {
            0.5 * (start + low)
        } else {
            start
        }
    }
}

/// The name in quotes, for messages.
impl Display for Variable {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", short(&self.name))
    }
}

/// An entry of the model structure: a variable, and its dependencies if they are declared.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) variable: usize,
    pub(super) dependencies: Option<Vec<usize>>,
}

/// Whether a variable belongs to what [`Session::observe`](super::session::Session::observe) reads.
pub(super) fn observed(v: &Variable) -> bool {
    v.kind.is_numeric() && !v.clocked
}

/// Observed variables of one kind.
#[derive(Clone, Debug)]
pub(super) struct Group {
    pub(super) kind: Kind,
    pub(super) references: Vec<u32>,
    /// The places of the values in the row of everything that is observed.
    pub(super) places: Vec<usize>,
}

fn groups(variables: &[Variable]) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    let mut at = 0;
    for v in variables.iter().filter(|v| observed(v)) {
        let group = match groups.iter().position(|g| g.kind == v.kind) {
            Some(index) => &mut groups[index],
            None => {
                groups.push(Group { kind: v.kind, references: Vec::new(), places: Vec::new() });
                groups.last_mut().expect("it has just been pushed")
            }
        };
        group.references.push(v.reference);
        group.places.extend(at..at + v.size);
        at += v.size;
    }
    groups
}

#[derive(Clone, Debug)]
pub(super) struct Facts {
    pub(super) version: FmiVersion,
    pub(super) token: String,
    pub(super) categories: Vec<String>,
    pub(super) interfaces: Vec<Interface>,
    pub(super) variables: Vec<Variable>,
    /// What [`Session::observe`](super::session::Session::observe) reads in one call each.
    pub(super) groups: Vec<Group>,
    pub(super) outputs: Vec<Entry>,
    pub(super) derivatives: Vec<Entry>,
    /// The state of each entry of `derivatives`.
    pub(super) states: Vec<usize>,
    /// Pairs of a continuous variable and its declared derivative, states or not.
    pub(super) slopes: Vec<(usize, usize)>,
    pub(super) indicators: usize,
    pub(super) start: f64,
    pub(super) stop: Option<f64>,
    pub(super) step: Option<f64>,
    pub(super) tolerance: Option<f64>,
}

impl Facts {
    /// Reads `modelDescription.xml` of an archive, which the static checks have found sound.
    pub(super) fn read(archive: &Archive) -> Option<Facts> {
        let bytes = std::fs::read(archive.dir().join(FILE)).ok()?;
        let text = decode(FILE, &bytes, &mut Findings::new())?;
        let xml = Xml::parse(FILE, &text, &mut Findings::new())?;
        let description = archive.description();
        Some(Facts::of(&Model::read(xml.file(), description.fmi_version), description))
    }

    fn of(model: &Model, description: &ModelDescription) -> Facts {
        let experiment = description.default_experiment;
        let finite = |value: Option<f64>| value.filter(|v| v.is_finite());
        let positive = |value: Option<f64>| finite(value).filter(|v| *v > 0.0);
        let interface = |i: &Interface| Interface {
            fixed_internal_step_size: positive(i.fixed_internal_step_size),
            ..i.clone()
        };
        let derivatives: Vec<&Unknown> = model
            .structure
            .derivatives
            .iter()
            .filter(|u| u.variable.is_some_and(|i| model.state_of(&model.variables[i]).is_some()))
            .collect();
        let states: Vec<usize> = derivatives
            .iter()
            .filter_map(|u| model.state_of(&model.variables[u.variable.unwrap_or_default()]))
            .collect();
        let variables: Vec<Variable> = model.variables.iter().map(|v| read_variable(model, v)).collect();
        let slopes = model.variables.iter().enumerate().filter_map(|(i, v)| Some((model.state_of(v)?, i)));
        let size = |u: &Unknown| u.variable.map_or(1, |i| variables[i].size);
        let indicators = match model.version {
            FmiVersion::V2 => unsigned(model.root, "numberOfEventIndicators").unwrap_or(0) as usize,
            FmiVersion::V3 => model.structure.event_indicators.iter().map(size).sum(),
        };
        Facts {
            version: model.version,
            token: description.token.clone(),
            categories: description.log_categories.clone(),
            interfaces: description.interfaces.iter().map(interface).collect(),
            outputs: model.structure.outputs.iter().filter_map(|u| read_entry(model, u)).collect(),
            derivatives: derivatives.into_iter().filter_map(|u| read_entry(model, u)).collect(),
            states,
            slopes: slopes.collect(),
            indicators,
            start: finite(experiment.start).unwrap_or(0.0),
            stop: finite(experiment.stop),
            step: positive(experiment.step),
            tolerance: positive(experiment.tolerance),
            groups: groups(&variables),
            variables,
        }
    }

    /// The interface of a type.
    pub(super) fn interface(&self, kind: InterfaceType) -> Option<&Interface> {
        self.interfaces.iter().find(|i| i.kind == kind)
    }

    /// The step (s) that importers would take: declared, or a 500th of the experiment.
    pub(super) fn step(&self) -> f64 {
        let span = self.stop.map_or(1.0, |stop| stop - self.start);
        self.step.unwrap_or(if span > 0.0 && span.is_finite() { span / 500.0 } else { 1e-3 })
    }

    /// The name of a function with the prefix of its standard.
    pub(super) fn function(&self, name: &str) -> String {
        format!("{}{name}", self.pick("fmi2", "fmi3"))
    }

    /// One of two words, by the standard.
    pub(super) fn pick<'a>(&self, two: &'a str, three: &'a str) -> &'a str {
        if self.version == FmiVersion::V2 { two } else { three }
    }

    pub(super) fn state_count(&self) -> usize {
        self.states.iter().map(|i| self.variables[*i].size).sum()
    }

    /// Variables that pass a test.
    pub(super) fn select(&self, test: impl Fn(&Variable) -> bool) -> Vec<&Variable> {
        self.variables.iter().filter(|v| test(v)).collect()
    }

    /// Continuous inputs that can be moved.
    pub(super) fn inputs(&self) -> Vec<&Variable> {
        self.select(|v| v.is("input") && v.is_continuous() && v.is_free())
    }
}

fn read_entry(model: &Model, unknown: &Unknown) -> Option<Entry> {
    let dependencies = unknown
        .node
        .attribute("dependencies")
        .map(|text| unsigned_list(text).into_iter().filter_map(|r| model.resolve(r)).collect());
    Some(Entry { variable: unknown.variable?, dependencies })
}

fn read_variable(model: &Model, v: &model::Variable) -> Variable {
    let kind = v.kind;
    let size = arrays::size(model, v).and_then(|n| usize::try_from(n).ok()).unwrap_or(1).min(LARGEST_ARRAY);
    let number = |text: &str| match kind {
        Kind::Boolean => parse_boolean(text).map(|b| f64::from(u8::from(b))),
        Kind::Float64 => parse_double(text),
        // Start values are decimal; the FMU holds the nearest number of its type.
        Kind::Float32 => parse_double(text).map(|x| f64::from(x as f32)),
        _ => parse_integer(text).map(|i| i as f64),
    };
    let written = v.typed.attribute("start").filter(|_| kind.is_numeric()).unwrap_or_default();
    let mut start: Vec<f64> = written.split_ascii_whitespace().filter_map(number).collect();
    // One value applies to all elements.
    if let [all] = start[..] {
        start = vec![all; size];
    }
    let is_long = matches!(kind, Kind::Int64 | Kind::UInt64);
    let mut exact: Vec<i128> =
        written.split_ascii_whitespace().filter(|_| is_long).filter_map(parse_integer).collect();
    if let [all] = exact[..] {
        exact = vec![all; size];
    }
    let limit = |name: &str| {
        let text = model.attribute(v, name)?;
        if kind.is_float() { parse_double(text) } else { parse_integer(text).map(|i| i as f64) }
    };
    let text = match model.version {
        FmiVersion::V2 => v.typed.attribute("start"),
        FmiVersion::V3 => model::children(v.typed, "Start").next().and_then(|s| s.attribute("value")),
    };
    Variable {
        name: v.name.to_owned(),
        reference: v.reference.unwrap_or_default(),
        kind,
        causality: v.causality.to_owned(),
        variability: v.variability.to_owned(),
        initial: v.initial.map(str::to_owned),
        start,
        exact,
        text: text.filter(|_| matches!(kind, Kind::String | Kind::Binary)).map(str::to_owned),
        min: limit("min"),
        max: limit("max"),
        nominal: limit("nominal").filter(|n| *n > 0.0 && n.is_finite()).unwrap_or(1.0),
        unit: model.attribute(v, "unit").map(str::to_owned),
        size,
        clocked: v.clocked,
        reinit: model.attribute(v, "reinit").and_then(parse_boolean).unwrap_or(false),
        place: model.place(v.typed),
    }
}
