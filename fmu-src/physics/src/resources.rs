//! The data that an archive brings to a model.

use crate::load_table::LoadTable;
use crate::model::Model;
use crate::terms::GenericTerm;

/// The data in the resources of an archive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resources {
    /// Terms.
    pub terms: Vec<GenericTerm>,
    /// Load table.
    pub load: Option<LoadTable>,
}

impl Resources {
    /// Resources with terms alone.
    pub fn of_terms(terms: &[GenericTerm]) -> Resources {
        Resources { terms: terms.to_vec(), load: None }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.terms.is_empty() && self.load.is_none()
    }

    /// Gives them to a model that has not started; false where it does not take all of them.
    pub fn give(&self, model: &mut dyn Model) -> bool {
        let terms = self.terms.is_empty() || model.set_terms(&self.terms);
        let load = self.load.as_ref().is_none_or(|table| model.set_load(table));
        terms && load
    }
}
