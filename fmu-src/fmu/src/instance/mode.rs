//! What instances and their calls are told apart by.

use physics::declare::Kind;
use physics::model::Entry;

/// Which standard an importer speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standard {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// Who integrates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Interface {
    /// The instance, from one communication point to the next.
    CoSimulation = 0,
    /// The importer.
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

/// Where an instance is in its life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Made, not yet initializing.
    Instantiated = 0,
    /// Between entering and exiting initialization.
    Initialization = 1,
    /// Ready to step.
    Step = 2,
    /// Terminated.
    Terminated = 3,
    /// An internal failure left it in doubt.
    Broken = 4,
    /// At an event.
    Event = 5,
    /// Between events of Model Exchange.
    Continuous = 6,
    /// Before initialization, where sizes of arrays are chosen.
    Configuration = 7,
    /// In the middle of a step, while the importer looks in.
    Intermediate = 8,
}

impl Mode {
    /// The mode of this number.
    pub fn from_number(number: u8) -> Option<Mode> {
        LIVING.iter().copied().find(|m| *m as u8 == number)
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Mode::Instantiated => "instantiated",
            Mode::Initialization => "in initialization mode",
            Mode::Step => "in step mode",
            Mode::Terminated => "terminated",
            Mode::Broken => "broken by an internal failure",
            Mode::Event => "in event mode",
            Mode::Continuous => "in continuous-time mode",
            Mode::Configuration => "in configuration mode",
            Mode::Intermediate => "in the middle of a step",
        }
    }
}

/// Every mode in which an instance can be saved: not after a failure, nor in the middle of a step.
pub(super) const LIVING: &[Mode] = &[
    Mode::Instantiated,
    Mode::Initialization,
    Mode::Step,
    Mode::Terminated,
    Mode::Event,
    Mode::Continuous,
    Mode::Configuration,
];

/// Which of the interface's types a call speaks of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// FMI 2 Real, FMI 3 Float64.
    Real,
    /// FMI 2 Integer, FMI 3 Int64: whole numbers and enumerations.
    Integer,
    /// FMI 3 UInt64: sizes of arrays.
    Size,
    /// Boolean.
    Boolean,
    /// A type that no variable has, with its name.
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
