//! Closing the loop: from bench data to the effect that the model lacks.
//!
//! So far: [`experiment`] reads what was measured and refuses what cannot be right, [`noise`] says how much of it is
//! noise, [`simulate`] runs the model as the bench ran, and [`refit`] gives the naive answer, other
//! parameters, and scores each [`candidate`] by what it would explain of the rest;
//! [`compete`] fits the best of them. [`outcome`] is what all of it comes to, [`report`] the file that says so.

pub mod candidate;
pub mod catalogue;
pub mod close_loop;
pub mod compete;
pub mod evidence;
pub mod experiment;
pub mod fit;
pub mod hypothesis;
pub mod noise;
pub mod outcome;
pub mod point;
pub mod refit;
pub mod report;
pub mod rounds;
pub mod search;
pub mod separate;
pub mod setup;
pub mod simulate;
pub mod tangent;
mod telling;

/// Why an experiment cannot be used: one sentence with file and, where there is one, line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CalibrateError(pub String);
