//! A periodic course of torque and speed that is data.

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
