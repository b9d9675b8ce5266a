//! Data in the resources of an FMU archive.

use crate::load_table::LoadTable;
use crate::model::Model;
use crate::terms::GenericTerm;

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

    /// Passes them to a model that has not started; false if it rejects any of them.
    pub fn give(&self, model: &mut dyn Model) -> bool {
        let terms = self.terms.is_empty() || model.set_terms(&self.terms);
        let load = self.load.as_ref().is_none_or(|table| model.set_load(table));
        terms && load
    }
}
