//! Load table: periodic torque and speed as data.

/// Largest number of rows.
pub const MOST_ROWS: usize = 1_000_000;

/// Rows of torque and speed at any times, linearly interpolated, also from the last row to the first of the next period.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadTable {
    /// Times, ascending from 0, below the period, s.
    pub times: Vec<f64>,
    /// Torques, positive in the direction of positive speed on the load, N.m.
    pub torques: Vec<f64>,
    /// Speeds, rad/s.
    pub speeds: Vec<f64>,
    /// Period, s.
    pub period: f64,
    /// Angle of the first row, rad; `None`: the angle has zero mean over the period.
    pub angle: Option<f64>,
}
