//! The content of `modelDescription.xml` in one structure for FMI 2.0 and 3.0. The reader is in `description/parse.rs`.
mod parse;

use std::fmt;

/// The generation of the standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FmiVersion {
    /// FMI 2.0
    V2,
    /// FMI 3.0
    V3,
}

impl fmt::Display for FmiVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if *self == Self::V2 { "2.0" } else { "3.0" })
    }
}

/// Declares an enumeration with the word of the standard for each item and how messages name it.
macro_rules! words {
    ($(#[$meta:meta])* $vis:vis enum $name:ident { $($item:ident $word:literal $text:literal,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)] // the standard's words
        $vis enum $name { $($item,)* }

        impl $name {
            /// The item that a file calls `word`.
            pub(crate) fn of(word: &str) -> Option<Self> {
                match word {
                    $($word => Some(Self::$item),)*
                    _ => None,
                }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$item => $text,)* })
            }
        }
    };
}
pub(crate) use words;

/// The content of `modelDescription.xml`.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelDescription {
    /// Generation of the standard.
    pub fmi_version: FmiVersion,
    /// `modelName`
    pub model_name: String,
    /// FMI 2 `guid`, FMI 3 `instantiationToken`.
    pub token: String,
    /// `description` of the model.
    pub description: Option<String>,
    /// `generationTool`
    pub generation_tool: Option<String>,
    /// The interface types, in the order of the file.
    pub interfaces: Vec<Interface>,
    /// `DefaultExperiment`; empty when absent.
    pub default_experiment: DefaultExperiment,
    /// Names of the log categories.
    pub log_categories: Vec<String>,
    /// Unit definitions.
    pub units: Vec<Unit>,
    /// Enumeration types.
    pub enumerations: Vec<Enumeration>,
    /// All variables, in the order of the file.
    pub variables: Vec<Variable>,
    /// Continuous states: entries of the derivatives in `ModelStructure`. FMI 3 FMUs tell their number at run time.
    pub state_count: usize,
    /// FMI 2: `numberOfEventIndicators`.
    pub indicator_count: usize,
    /// Dependencies of the outputs listed in `ModelStructure`.
    pub output_dependencies: Vec<Dependencies>,
}

/// Declared dependencies of an output at one communication point (direct feedthrough).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dependencies {
    /// Place of the output in [`ModelDescription::variables`].
    pub output: usize,
    /// Places of the variables that it depends on; `None` if the FMU does not declare them.
    pub on: Option<Vec<usize>>,
}

/// Name of the file in the archive.
pub const FILE: &str = "modelDescription.xml";

/// An interface type of the standards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // the standard's words
pub enum InterfaceType {
    #[default]
    CoSimulation,
    ModelExchange,
    ScheduledExecution,
}

impl std::fmt::Display for InterfaceType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::CoSimulation => "Co-Simulation",
            Self::ModelExchange => "Model Exchange",
            Self::ScheduledExecution => "Scheduled Execution",
        })
    }
}

/// One interface with its capability flags; absent flags have the standard's default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Interface {
    /// The interface type.
    pub kind: InterfaceType,
    /// Name of the binary, without extension.
    pub model_identifier: String,
    /// The FMU needs another program to run.
    pub needs_execution_tool: bool,
    /// One instance per process only.
    pub only_once_per_process: bool,
    /// States can be saved and restored.
    pub can_get_and_set_state: bool,
    /// Saved states can be turned into bytes.
    pub can_serialize_state: bool,
    /// Directional derivatives are provided.
    pub provides_directional_derivatives: bool,
    /// FMI 3: adjoint derivatives are provided.
    pub provides_adjoint_derivatives: bool,
    /// Model Exchange: the end of each integrator step is to be reported.
    pub needs_completed_step: bool,
    /// Co-Simulation: the step size may differ from step to step.
    pub can_handle_variable_step: bool,
    /// Co-Simulation, FMI 2: derivatives of inputs are understood.
    pub can_interpolate_inputs: bool,
    /// Co-Simulation, FMI 3: inputs can be set within a step.
    pub provides_intermediate_update: bool,
    /// Co-Simulation: highest order of output derivatives.
    pub max_output_derivative_order: u32,
    /// Co-Simulation, FMI 3: the internal step size (s).
    pub fixed_internal_step_size: Option<f64>,
    /// Co-Simulation, FMI 3: event mode exists.
    pub has_event_mode: bool,
    /// Line of the element in the file.
    pub line: u32,
}

impl Interface {
    /// File and line of the element.
    pub fn place(&self) -> String {
        format!("{}:{}", FILE, self.line)
    }
}

/// Default experiment; times in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DefaultExperiment {
    /// `startTime`
    pub start: Option<f64>,
    /// `stopTime`
    pub stop: Option<f64>,
    /// `tolerance`, relative
    pub tolerance: Option<f64>,
    /// `stepSize`
    pub step: Option<f64>,
}

/// A unit and its display units.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// The name that variables refer to.
    pub name: String,
    /// The unit in SI base units, if the FMU defines it.
    pub base: Option<BaseUnit>,
    /// Display units.
    pub display_units: Vec<DisplayUnit>,
}

/// A unit in SI base units: `base value = factor * value + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseUnit {
    /// Exponents of [`BaseUnit::NAMES`].
    pub exponents: [i32; 8],
    /// Factor, 1 when absent.
    pub factor: f64,
    /// Offset, 0 when absent.
    pub offset: f64,
}

impl BaseUnit {
    /// The base units that exponents belong to; the radian counts as one, so that rpm and Hz stay apart.
    pub const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
}

/// `shown = factor * value + offset`, or with `inverse` `shown = factor / value`.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Name of the display unit.
    pub name: String,
    /// Factor, 1 when absent.
    pub factor: f64,
    /// Offset, 0 when absent.
    pub offset: f64,
    /// FMI 3 `inverse`
    pub inverse: bool,
}

impl DisplayUnit {
    /// `value` (in the unit this belongs to) in the display unit.
    pub fn show(&self, value: f64) -> f64 {
        if self.inverse { self.factor / value } else { self.factor * value + self.offset }
    }
}

/// An enumeration type.
#[derive(Clone, Debug, PartialEq)]
pub struct Enumeration {
    /// Type name, as `declaredType` refers to it.
    pub name: String,
    /// Its items, in the order of the file.
    pub items: Vec<EnumerationItem>,
}

/// One item of an enumeration.
#[derive(Clone, Debug, PartialEq)]
pub struct EnumerationItem {
    /// Name of the item.
    pub name: String,
    /// Its number.
    pub value: i64,
}

/// The type of a variable. FMI 2 `Real` is `Float64`, FMI 2 `Integer` is `Int32`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs)] // the names are sufficient
pub enum Kind {
    Float64,
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    String,
    Binary,
    Enumeration,
    Clock,
}

impl Kind {
    /// All kinds, in the order of their declaration.
    pub(crate) const ALL: [Self; 15] = [
        Self::Float64,
        Self::Float32,
        Self::Int8,
        Self::UInt8,
        Self::Int16,
        Self::UInt16,
        Self::Int32,
        Self::UInt32,
        Self::Int64,
        Self::UInt64,
        Self::Boolean,
        Self::String,
        Self::Binary,
        Self::Enumeration,
        Self::Clock,
    ];

    /// The type behind the name of an element; FMI 2 `Real` and `Integer` are `Float64` and `Int32`.
    pub fn of(version: FmiVersion, element: &str) -> Option<Self> {
        Some(match (version, element) {
            (FmiVersion::V2, "Real") | (FmiVersion::V3, "Float64") => Self::Float64,
            (FmiVersion::V2, "Integer") | (FmiVersion::V3, "Int32") => Self::Int32,
            (_, "Boolean") => Self::Boolean,
            (_, "String") => Self::String,
            (_, "Enumeration") => Self::Enumeration,
            (FmiVersion::V2, _) => return None,
            (_, "Float32") => Self::Float32,
            (_, "Int8") => Self::Int8,
            (_, "UInt8") => Self::UInt8,
            (_, "Int16") => Self::Int16,
            (_, "UInt16") => Self::UInt16,
            (_, "UInt32") => Self::UInt32,
            (_, "Int64") => Self::Int64,
            (_, "UInt64") => Self::UInt64,
            (_, "Binary") => Self::Binary,
            (_, "Clock") => Self::Clock,
            _ => return None,
        })
    }

    /// Any integer type, enumerations included.
    pub fn is_integer(self) -> bool {
        self.is_numeric() && !self.is_float() && self != Self::Boolean
    }

    /// `Float64` or `Float32`.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Float64 | Self::Float32)
    }

    /// Whether a value can be written as a number: floats, integers, enumerations, Booleans.
    pub fn is_numeric(self) -> bool {
        !matches!(self, Self::String | Self::Binary | Self::Clock)
    }
}

words! {
    /// `causality`
    pub enum Causality {
        Parameter "parameter" "parameter",
        CalculatedParameter "calculatedParameter" "calculated parameter",
        StructuralParameter "structuralParameter" "structural parameter",
        Input "input" "input",
        Output "output" "output",
        Local "local" "local variable",
        Independent "independent" "independent variable",
    }
}

words! {
    /// `variability`
    pub enum Variability {
        Constant "constant" "constant",
        Fixed "fixed" "fixed",
        Tunable "tunable" "tunable",
        Discrete "discrete" "discrete",
        Continuous "continuous" "continuous",
    }
}

words! {
    /// `initial`
    pub enum Initial {
        Exact "exact" "exact",
        Approx "approx" "approx",
        Calculated "calculated" "calculated",
    }
}

words! {
    /// `intervalVariability` of a clock (FMI 3)
    pub enum IntervalVariability {
        Constant "constant" "constant",
        Fixed "fixed" "fixed",
        Calculated "calculated" "calculated",
        Tunable "tunable" "tunable",
        Changing "changing" "changing",
        Countdown "countdown" "countdown",
        Triggered "triggered" "triggered",
    }
}

/// When a clock ticks (FMI 3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockTicks {
    /// `intervalVariability`
    pub variability: IntervalVariability,
    /// The interval that the description gives (s).
    pub interval: Option<f64>,
}

/// One dimension of an array (FMI 3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A fixed size.
    Size(u64),
    /// The value of the structural parameter with this value reference.
    Reference(u32),
}

/// A variable. `unit`, `display_unit`, `min` and `max` are taken from the declared type where the variable
/// itself has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Unique name.
    pub name: String,
    /// The handle for get and set; unique within a kind only.
    pub value_reference: u32,
    /// Type.
    pub kind: Kind,
    /// Role. `Local` when absent.
    pub causality: Causality,
    /// When it may change; the standard's default when absent.
    pub variability: Variability,
    /// As written in the file; `None` when absent.
    pub initial: Option<Initial>,
    /// Start value as text, as in the file; items of an array are separated by blanks.
    pub start: Option<String>,
    /// Unit of the value.
    pub unit: Option<String>,
    /// Display unit.
    pub display_unit: Option<String>,
    /// A difference (of temperatures, say): the offset of a display unit does not apply.
    pub relative: bool,
    /// Name of the declared type.
    pub declared_type: Option<String>,
    /// Lower limit.
    pub min: Option<f64>,
    /// Upper limit.
    pub max: Option<f64>,
    /// Meaning.
    pub description: Option<String>,
    /// FMI 3: can be used in intermediate update mode.
    pub intermediate_update: bool,
    /// Line in the file.
    pub line: u32,
    /// Dimensions; empty for a scalar.
    pub dimensions: Vec<Dimension>,
    /// Of a clock: when it ticks.
    pub clock: Option<ClockTicks>,
}

impl ModelDescription {
    /// The interface of a type, if there is one.
    pub fn interface(&self, kind: InterfaceType) -> Option<&Interface> {
        self.interfaces.iter().find(|i| i.kind == kind)
    }

    /// The Co-Simulation interface, if there is one.
    pub fn co_simulation(&self) -> Option<&Interface> {
        self.interface(InterfaceType::CoSimulation)
    }

    /// The variable called `name`.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|v| v.name == name)
    }

    /// The outputs, in the order of the file.
    pub fn outputs(&self) -> impl Iterator<Item = &Variable> {
        self.variables.iter().filter(|v| v.causality == Causality::Output)
    }

    /// The inputs on which the variable at place `output` depends directly; `None` if the FMU does not declare them, and then
    /// it may depend on all inputs.
    pub fn feedthrough(&self, output: usize) -> Option<Vec<usize>> {
        let on = self.output_dependencies.iter().find(|d| d.output == output)?.on.as_ref()?;
        Some(on.iter().copied().filter(|i| self.variables[*i].causality == Causality::Input).collect())
    }

    /// Whether a continuous input takes a derivative in a step of Co-Simulation: FMI 2 with a call, FMI 3 in intermediate update mode.
    pub fn takes_input_derivative(&self, variable: &Variable) -> bool {
        let Some(interface) = self.co_simulation() else { return false };
        let allowed = match self.fmi_version {
            FmiVersion::V2 => interface.can_interpolate_inputs,
            FmiVersion::V3 => interface.provides_intermediate_update && variable.intermediate_update,
        };
        allowed
            && variable.kind == Kind::Float64
            && variable.causality == Causality::Input
            && variable.variability == Variability::Continuous
            && variable.dimensions.is_empty()
    }

    /// The enumeration type of a variable.
    pub fn enumeration(&self, variable: &Variable) -> Option<&Enumeration> {
        let name = variable.declared_type.as_deref()?;
        if variable.kind == Kind::Enumeration {
            self.enumerations.iter().find(|e| e.name == name)
        } else {
            None
        }
    }

    /// Display unit of a variable, if it has one that is defined. Relative quantities take no display unit with an offset.
    pub fn display_unit(&self, variable: &Variable) -> Option<DisplayUnit> {
        let (unit, wanted) = (variable.unit.as_deref()?, variable.display_unit.as_deref()?);
        let unit = self.units.iter().find(|u| u.name == unit)?;
        let display = unit.display_units.iter().find(|d| d.name == wanted)?;
        (!variable.relative || display.offset == 0.0).then(|| display.clone())
    }

    /// Number of elements of a variable, 1 for a scalar. Sizes given by structural parameters are those of
    /// the start values, unless `size_of` gives another value.
    pub fn element_count(&self, variable: &Variable, size_of: &dyn Fn(u32) -> Option<u64>) -> u64 {
        let size = |dimension: &Dimension| match *dimension {
            Dimension::Size(n) => n,
            Dimension::Reference(reference) => size_of(reference).unwrap_or_else(|| {
                let sizes = |v: &&Variable| {
                    v.value_reference == reference && v.causality == Causality::StructuralParameter
                };
                let start = self.variables.iter().find(sizes).and_then(|v| v.start.as_deref());
                start.and_then(|s| s.trim().parse().ok()).unwrap_or(0)
            }),
        };
        variable.dimensions.iter().map(size).fold(1, u64::saturating_mul)
    }
}
