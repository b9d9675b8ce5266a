//! Closing the loop: from bench data to the effect that the model lacks.
//!
//! In the order that the data goes:
//!
//! | module | does |
//! |---|---|
//! | [`experiment`] | reads what was measured, and refuses what cannot be right |
//! | [`intake`] | sets aside sensors that do not work, and refuses data that contradict the model |
//! | [`noise`] | says how much of a channel is noise |
//! | [`simulate`], [`change`], [`initial`] | the native model over a run, with what a trial changes of it and where it starts |
//! | [`hypothesis`], [`catalogue`] | a model that may be: parameters, effects of the list, terms of no list |
//! | [`setup`] | all of it ready to be asked; residuals row by row and in blocks |
//! | [`fit`] | the numbers of a hypothesis: bounded, with priors |
//! | `disagreement` | runs that disagree by more than the noise of the sensors |
//! | `hearing` | what the noise of the inputs does to it |
//! | [`tangent`] | the model linearised along a run: what any small force at any port would do |
//! | [`evidence`] | what a column would explain beside all parameters and drifting sensors |
//! | [`point`] | a fitted model with both: where one looks from |
//! | [`search`] | scores effects, shapes over drivers, forces free in time, and what knows its past |
//! | [`rounds`] | the best are fitted, compete, and pass a gate |
//! | [`close_loop`] | the whole way, and the verdict |
//! | `blackbox`, `comparison` | models without physics from the same inputs, and where the repair is not the best |
//! | [`separate`] | the run or reading that would tell two models apart |
//! | `prediction` | prediction intervals |
//! | `telling`, [`outcome`], [`report`] | intervals, errors, words: as data, and as `report.json` |

mod blackbox;
pub mod catalogue;
pub mod close_loop;
mod comparison;
mod deadline;
mod disagreement;
mod estimates;
pub mod evidence;
pub mod experiment;
pub mod fit;
pub mod hypothesis;
pub mod initial;
mod input_noise;
pub mod intake;
pub mod linearization;
pub mod noise;
pub mod outcome;
pub mod overrides;
mod prediction;
pub mod report;
pub mod search;
pub mod selection;
pub mod separate;
pub mod setup;
pub mod simulate;
pub mod tangent;
#[cfg(test)]
mod testing;

/// Why an experiment cannot be used: one sentence with file and, where there is one, line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrateError(pub String);
