//! A black-box FMI client: open, check, step or integrate, and record any FMU, FMI 2.0 or 3.0, Co-Simulation or Model Exchange.
//!
//! The crate does not depend on the models of this project: it uses only the content of the archive and the C functions of the
//! standard.
//!
//! | step | item |
//! |---|---|
//! | unpack the archive, safely | [`Archive`] |
//! | read `modelDescription.xml` | [`ModelDescription`], [`Variable`] |
//! | read its elements with their lines, valid or not | [`elements`], [`xml`] |
//! | turn text into a checked value | [`ModelDescription::parse_value`], [`Value`] |
//! | call the binary | [`Instance`], [`State`], [`Log`] |
//! | time tables for the inputs | [`InputTable`] |
//! | call any function, valid or not, to test an FMU | [`raw`] |
//! | FMUs in a child process that may crash or hang | [`child`] |
//! | systems of FMUs: SSP and TOML, the master | [`System`], [`cosimulate`], [`SystemRun`] |
//! | a solver of ordinary differential equations for Model Exchange | [`ode`] |
//! | the whole run | [`simulate`](fn@simulate), [`Options`], [`Recording`] |
//!
//! Every failure is an [`Error`]: one sentence that names the variable, value, limits, file and line.
//!
//! ```no_run
//! let archive = cosim::Archive::open("motor.fmu".as_ref())?;
//! let options = cosim::Options { stop: Some(10.0), ..Default::default() };
//! let recording = cosim::simulate(&archive, &options, &mut |_| ())?;
//! recording.write_csv("motor.csv".as_ref())?;
//! # Ok::<(), cosim::Error>(())
//! ```

mod archive;
pub mod child;
mod description;
mod drive;
pub mod elements;
mod error;
mod grid;
mod input;
mod instance;
mod integrator;
mod log;
pub mod ode;
mod page;
mod plot;
mod quantity;
pub mod raw;
mod recording;
mod simulate;
mod system;
mod value;
pub mod xml;

pub use archive::Archive;
pub use description::{
    BaseUnit, Causality, ClockTicks, DefaultExperiment, Dependencies, Dimension, DisplayUnit, Enumeration,
    EnumerationItem, FmiVersion, Initial, Interface, InterfaceType, IntervalVariability, Kind,
    ModelDescription, Unit, Variability, Variable,
};
pub use error::{Error, number};
pub use input::{InputTable, is_standard_input};
pub use instance::{Instance, State, Step};
pub use log::{Log, LogMessage, Status};
pub use plot::Limit;
pub use raw::Experiment;
pub use recording::{Column, Recording};
pub use simulate::{Options, simulate};
pub use system::{Algorithm, PowerBond, SspForm, System, SystemOptions, SystemRun, cosimulate};
pub use value::Value;

#[cfg(test)]
mod tests {
    /// The table of `tests/data/faults.toml` with this name: a text, and its error.
    pub(crate) fn faults(name: &str) -> Vec<[String; 2]> {
        let all: toml::Table = toml::from_str(include_str!("../tests/data/faults.toml")).unwrap();
        all[name].clone().try_into().unwrap()
    }
}
