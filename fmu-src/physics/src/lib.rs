//! The models: equations, correlations and the fast integrator.
//!
//! No FMI, no file access, no clock, no threads; no allocation while a model runs. Entry points:
//! [`models::ALL`], the list of models, and `fmu-src/README.md`, the map from equation to file.

pub mod components;
pub mod correlations;
pub mod effects;
pub mod exchange;
pub mod explicit;
mod fault;
pub mod groups;
pub mod ledger;
pub mod line;
pub mod load_table;
pub mod media;
pub mod model;
pub mod models;
mod number;
mod ports;
pub mod resources;
pub mod root;
pub mod runtime;
pub mod slopes;
pub mod solver;
pub mod start_values;
pub mod terms;
pub mod token;

pub use declare;
