//! Starts of the lags.

use super::MOST_TERMS;
use declare::{Unit, Variable, variables};

variables! {
    /// What the lagged driver of each term exceeds its driver by at the start, divided by a typical value of the driver.
    pub struct LagStarts {
        /// Initial lagged driver of term 1 of resources/effects.json less its driver, divided by a typical value of the driver as
        /// state.term_lag[1] is; without effect if the term has no lag
        term_lag_1: f64 = Variable::fixed(16, 0.0, Unit::One, -1e6, 1e6),
        /// Initial lagged driver of term 2 of resources/effects.json less its driver, as initial.term_lag_1
        term_lag_2: f64 = Variable::fixed(17, 0.0, Unit::One, -1e6, 1e6),
        /// Initial lagged driver of term 3 of resources/effects.json less its driver, as initial.term_lag_1
        term_lag_3: f64 = Variable::fixed(18, 0.0, Unit::One, -1e6, 1e6),
    }
}

impl LagStarts {
    /// The values, by term.
    pub fn of_terms(&self) -> [f64; MOST_TERMS] {
        [self.term_lag_1, self.term_lag_2, self.term_lag_3]
    }
}
