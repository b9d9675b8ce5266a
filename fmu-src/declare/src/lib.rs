//! How a variable is declared: the vocabulary of every table in the project.
//!
//! A component states each of its variables once, in a [`variables!`] block. The block becomes a plain struct
//! for the physics, and a table ([`Group::TABLE`]) for everyone else: the C interface, both model
//! descriptions, the parameter list, `--set`, presets and the tests over the whole table.
//!
//! This crate depends on nothing and decides nothing.

mod enumeration;
mod state;
mod unit;
mod variable;
mod variables;

pub use enumeration::{Enumeration, Item};
pub use state::{Elements, State};
pub use unit::{BaseUnits, Display, Unit};
pub use variable::{Causality, Group, Kind, Scalar, Scale, Variability, Variable};
