//! Standards, interface types, modes and types of the C interface.

use physics::declare::Kind;
use physics::model::Entry;

/// The standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// The interface type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Interface {
    /// The instance integrates between communication points.
    CoSimulation = 0,
    /// The importer integrates.
    ModelExchange = 1,
}

impl Interface {
    pub(super) fn words(self) -> &'static str {
        match self {
            Interface::CoSimulation => "Co-Simulation",
            Interface::ModelExchange => "Model Exchange",
        }
    }
}

/// Mode of the state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Instantiated, before initialization.
    Instantiated = 0,
    /// Between entering and exiting initialization.
    Initialization = 1,
    /// Step mode.
    Step = 2,
    /// Terminated.
    Terminated = 3,
    /// Error state after an internal failure: a restored state or a reset ends it; values can be read for debugging.
    Error = 4,
    /// Event mode.
    Event = 5,
    /// Continuous-time mode.
    Continuous = 6,
    /// Configuration mode: before initialization, array sizes can be set.
    Configuration = 7,
    /// Intermediate update mode, during a step.
    Intermediate = 8,
}

impl Mode {
    /// The mode with this number.
    pub fn from_number(number: u8) -> Option<Mode> {
        LIVING.iter().copied().find(|m| *m as u8 == number)
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Mode::Instantiated => "instantiated",
            Mode::Initialization => "in initialization mode",
            Mode::Step => "in step mode",
            Mode::Terminated => "terminated",
            Mode::Error => "in error state after an internal failure",
            Mode::Event => "in event mode",
            Mode::Continuous => "in continuous-time mode",
            Mode::Configuration => "in configuration mode",
            Mode::Intermediate => "in intermediate update mode",
        }
    }
}

/// All modes in which an instance can be saved and restored; a restored state ends the error state.
pub(super) const LIVING: &[Mode] = &[
    Mode::Instantiated,
    Mode::Initialization,
    Mode::Step,
    Mode::Terminated,
    Mode::Error,
    Mode::Event,
    Mode::Continuous,
    Mode::Configuration,
];

/// Type of the variables in a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// FMI 2 Real, FMI 3 Float64.
    Real,
    /// FMI 2 Integer, FMI 3 Int64: integers and enumerations.
    Integer,
    /// FMI 3 UInt64: array sizes.
    Size,
    /// Boolean.
    Boolean,
    /// A type without variables, with its name.
    Absent(&'static str),
}

impl Type {
    pub(super) fn of(entry: &Entry) -> Type {
        match entry.row.kind {
            Kind::Real => Type::Real,
            Kind::Boolean => Type::Boolean,
            Kind::Integer | Kind::Enumeration(_) => Type::Integer,
        }
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Type::Real => "Real (Float64)",
            Type::Integer => "Integer (Int64)",
            Type::Size => "UInt64",
            Type::Boolean => "Boolean",
            Type::Absent(name) => name,
        }
    }
}
