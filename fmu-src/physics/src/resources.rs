//! Data in the resources of an FMU archive.

use crate::load_table::LoadTable;
use crate::model::Model;
use crate::terms::GenericTerm;
use crate::token::{Contents, of_equations};

/// Data in the resources of an archive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resources {
    /// Terms.
    pub terms: Vec<GenericTerm>,
    /// Load table.
    pub load: Option<LoadTable>,
}

impl Resources {
    /// Resources with terms only.
    pub fn of_terms(terms: &[GenericTerm]) -> Resources {
        Resources { terms: terms.to_vec(), load: None }
    }

    /// Whether there are no data.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty() && self.load.is_none()
    }

    /// Fingerprint of the contents of an archive with these resources and start values (value reference, value).
    pub fn contents(&self, starts: impl IntoIterator<Item = (u32, f64)>) -> Contents {
        Contents::of(starts, &self.terms, self.load.as_ref())
    }

    /// Fingerprints of terms and load table, which with the model determine the equations; zero if there are none.
    pub fn equations(&self) -> [u64; 2] {
        of_equations(&self.terms, self.load.as_ref())
    }

    /// Passes them to a model that has not started; false if it rejects any of them.
    pub fn give(&self, model: &mut dyn Model) -> bool {
        let terms = self.terms.is_empty() || model.set_terms(&self.terms);
        let load = self.load.as_ref().is_none_or(|table| model.set_load(table));
        terms && load
    }
}
