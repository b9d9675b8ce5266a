//! The best-scored candidates, each fitted together with the parameters, and what speaks for and against them.
//!
//! delta BIC = chi2 without - chi2 with - ln n,   chi2 the weighted sum of squares of eq. (1) of `refit.rs`       (1)
//!
//! *Source*: Schwarz, Annals of Statistics 6 (1978) 461-464.

use crate::CalibrateError;
use crate::candidate::Candidate;
use crate::experiment::Role;
use crate::refit::{Fitted, Problem, Score};

/// A candidate that was fitted.
#[derive(Clone, Debug)]
pub struct Contender {
    /// The candidate.
    pub candidate: Candidate,
    /// The parameters, and last the candidate's size.
    pub fitted: Vec<Fitted>,
    /// Eq. (1).
    pub delta_bic: f64,
    /// Error over noise on the validation runs, over that of the refit without it; `None` without such runs.
    pub validation: Option<f64>,
}

/// Fits the `most` best of `scores` to the runs that are to be fitted, the one with the greatest delta BIC first.
///
/// # Errors
/// What the model says where it cannot be run.
pub fn compete(
    problem: &Problem,
    refit: &[Fitted],
    scores: &[Score],
    most: usize,
) -> Result<Vec<Contender>, CalibrateError> {
    let (without, rows) = problem.chi_square(Role::Fit, refit)?;
    let before = problem.chi_square(Role::Validate, refit)?;
    let mut contenders = Vec::new();
    for score in scores.iter().take(most) {
        let larger = problem.with(&score.candidate);
        let fitted = larger.fit_from(Role::Fit, refit, score.size)?;
        let (with, _) = larger.chi_square(Role::Fit, &fitted)?;
        let after = larger.chi_square(Role::Validate, &fitted)?;
        let validation = (before.1 > 0).then(|| (after.0 / before.0).sqrt());
        let delta_bic = without - with - (rows as f64).ln();
        contenders.push(Contender { candidate: score.candidate.clone(), fitted, delta_bic, validation });
    }
    contenders.sort_by(|a, b| b.delta_bic.total_cmp(&a.delta_bic));
    Ok(contenders)
}
