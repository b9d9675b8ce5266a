//! The mutants: one way each in which the code is wrong and may look right.

mod annulus;
mod c_interface;
mod master;
mod others;
mod validator;

use super::Mutant;

/// All of them, by part of the product.
const PARTS: [&[Mutant]; 5] =
    [annulus::MUTANTS, others::MUTANTS, c_interface::MUTANTS, master::MUTANTS, validator::MUTANTS];

/// All of them.
pub fn all() -> impl Iterator<Item = &'static Mutant> {
    PARTS.into_iter().flatten()
}
