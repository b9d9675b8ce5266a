//! Closed-loop calibration: from bench data to the effect that the model lacks.
//!
//! In the order of the data flow:
//!
//! | module | function |
//! |---|---|
//! | [`experiment`] | reads the measured data and rejects invalid files |
//! | [`intake`] | sets aside failed sensors and rejects data that contradict the model |
//! | [`noise`] | estimates the noise of each channel |
//! | [`simulate`], [`overrides`], [`initial`] | native model over a run, parameter overrides, initial states |
//! | `levels` | significance levels, limits of evidence, relative tolerances: why each number has its value |
//! | [`hypothesis`], [`catalogue`] | candidate model: parameters, listed effects, unlisted terms |
//! | `parallel` | parallel evaluation |
//! | [`setup`] | prepared experiment; residuals by row and by block |
//! | `acting` | whether an effect limited to some runs acts in unfitted ones |
//! | `means` | means over rows, where a fast logger has more rows than a search needs |
//! | [`fit`] | parameter estimation of a hypothesis with bounds and priors |
//! | `disagreement` | runs that disagree by more than the sensor noise |
//! | `input_noise` | effect of input noise on the outputs |
//! | [`tangent`] | model linearised along a run: response to a small perturbation at any port |
//! | [`evidence`] | evidence for a column, jointly with all parameters and drifting sensors |
//! | [`linearization`] | fitted model with its linearization and evidence: the base point of a search |
//! | [`search`] | scores effects, laws over drivers, latent inputs, and laws with memory |
//! | [`selection`] | stepwise selection: the best candidates are fitted, compared, and pass acceptance tests |
//! | `input_error` | zero and gain of an input's instrument, as an explanation of what was found |
//! | `one_gain` | the one gain or offset that makes a run agree with the others |
//! | [`close_loop`] | the complete procedure and the verdict |
//! | `blackbox`, `comparison` | black-box models of the same inputs, and where they predict better than the repaired model |
//! | `beyond` | unfitted runs that leave the range of a law |
//! | [`separate`] | run or reading that would distinguish two models |
//! | `prediction` | prediction intervals |
//! | `strain` | sentences on estimates that their priors hardly permit |
//! | `estimates`, [`outcome`], [`report`] | confidence intervals, errors and texts: as data, and as `report.json` |

mod acting;
mod algebra;
mod beyond;
mod blackbox;
pub mod catalogue;
pub mod close_loop;
mod comparison;
pub mod deadline;
mod disagreement;
mod estimates;
pub mod evidence;
pub mod experiment;
pub mod fit;
pub mod hypothesis;
pub mod initial;
mod input_error;
mod input_noise;
mod instruments;
pub mod intake;
mod levels;
pub mod linearization;
mod means;
pub mod noise;
mod numbers;
mod one_gain;
pub mod outcome;
pub mod overrides;
mod parallel;
mod prediction;
pub mod report;
pub mod search;
pub mod selection;
pub mod separate;
pub mod setup;
pub mod simulate;
mod smoothing;
mod strain;
pub mod tangent;
#[cfg(test)]
mod testing;
mod undeclared;

/// Reason why an experiment is rejected: one sentence with file and, if applicable, line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrateError(pub String);
