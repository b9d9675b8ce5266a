//! In which of the runs that are not fitted an effect acts that is limited to some runs.

use crate::CalibrateError;
use crate::experiment::Role;
use crate::hypothesis::Hypothesis;
use crate::setup::{Setup, Shown};

/// The hypothesis in which an effect limited to some runs acts in those of these runs that are predicted better with it.
///
/// # Errors
/// The message of the model if it cannot be run.
pub fn acting(setup: &Setup, hypothesis: &Hypothesis, runs: &[usize]) -> Result<Hypothesis, CalibrateError> {
    let mut hypothesis = hypothesis.clone();
    for a in 0..hypothesis.additions.len() {
        if setup.runs(Role::Fit).iter().all(|r| hypothesis.additions[a].active[*r]) {
            continue;
        }
        for run in runs {
            let on = if let Some(same) = setup.fitted_with(*run) {
                hypothesis.additions[a].active[same]
            } else {
                let mut error = |on: bool| -> Result<f64, CalibrateError> {
                    hypothesis.additions[a].active[*run] = on;
                    let shown: Vec<Shown> = setup.show(&hypothesis, &[*run])?;
                    Ok(setup.chi_square(&[*run], &shown).0)
                };
                error(true)? < error(false)?
            };
            hypothesis.additions[a].active[*run] = on;
        }
    }
    Ok(hypothesis)
}
