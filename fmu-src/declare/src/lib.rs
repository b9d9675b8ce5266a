//! Declaration of variables.
//!
//! A component declares each variable once, in a [`variables!`] block. The block generates a struct for the physics and
//! a table ([`Group::TABLE`]) for the C interface, both model descriptions, the parameter list, `--set`, presets and
//! the tests over the whole table.
//!
//! This crate has no dependencies and no logic.

mod enumeration;
mod state;
mod unit;
mod variable;
mod variables;

pub use enumeration::{Enumeration, Item};
pub use state::{Elements, State, index_of};
pub use unit::{BaseUnits, Display, Unit};
pub use variable::{Causality, Group, Kind, Named, Scalar, Scale, Variability, Variable};
