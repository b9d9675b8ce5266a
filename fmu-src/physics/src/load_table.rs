//! A periodic course of torque and speed that is data, and the data that an archive brings to a model.

use crate::model::Model;
use crate::terms::GenericTerm;

/// Rows that a table may have.
pub const MOST_ROWS: usize = 1_000_000;

/// Rows of torque and speed at any distances in time, linear in between and from the last row to the first of the next period.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadTable {
    /// Ascending from 0, below the period, s.
    pub times: Vec<f64>,
    /// Positive where it acts in the direction of positive speed on the load, N.m.
    pub torques: Vec<f64>,
    /// rad/s.
    pub speeds: Vec<f64>,
    /// s.
    pub period: f64,
    /// Angle of the first row, rad; without it the angle has zero mean over the period.
    pub angle: Option<f64>,
}

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
