//! The stages of the run, each a set of checks that share instances. After one that ends the process, the
//! next child process continues with the others.

use super::facts::{Entry, Facts, Variable, observed};
use super::report::{Fault, Seen};
use super::runs::{self, Drive, ROUNDING, Rows, difference, solver_error, steps};
use super::session::{Session, Settings, column, words};
use super::solver::{Reached, Solver, indicators};
use super::subject::{Subject, fresh};
use crate::validate::finding::{Findings, short};
use crate::validate::model::FmiVersion;
use crate::validate::rules::{self, Rule};
use cosim::raw::InterfaceType::{self, CoSimulation, ModelExchange, ScheduledExecution};
use cosim::raw::{Experiment, RawBinary, RawState};
use cosim::{Kind, Log, Status};
use setting::others;
use std::collections::HashMap;

mod compare;
mod derivatives;
mod exchange;
mod jacobian;
mod life;
mod misuse;
mod reference;
mod repeat;
mod setting;
mod state;
mod steps;

pub(super) struct Stage {
    /// What it does, as a phrase.
    pub(super) what: &'static str,
    /// The other stages are skipped if this one fails.
    pub(super) is_basis: bool,
    /// It makes invalid calls.
    pub(super) is_misuse: bool,
    pub(super) applies: fn(&Subject) -> bool,
    pub(super) run: fn(&Subject, &mut Seen) -> Result<(), Fault>,
}

const fn stage(
    what: &'static str,
    applies: fn(&Subject) -> bool,
    run: fn(&Subject, &mut Seen) -> Result<(), Fault>,
) -> Stage {
    Stage { what, is_basis: false, is_misuse: false, applies, run }
}

/// Several instances may exist in this process.
fn is_repeatable(s: &Subject) -> bool {
    !s.interface.only_once_per_process
}

fn moves(s: &Subject) -> bool {
    s.interface.kind != ScheduledExecution
}

fn steps_itself(s: &Subject) -> bool {
    s.interface.kind == CoSimulation
}

fn is_integrated(s: &Subject) -> bool {
    s.interface.kind == ModelExchange
}

/// In the order in which they run.
pub(super) static ALL: &[Stage] = &[
    Stage { is_basis: true, ..stage("one life from instantiation to the end", |_| true, life::run) },
    stage("start values after instantiation", |_| true, setting::start_values),
    stage(
        "event mode in Co-Simulation",
        |s| steps_itself(s) && s.interface.has_event_mode && is_repeatable(s),
        life::with_events,
    ),
    stage("a second run, and runs after a reset", moves, repeat::reset),
    stage("saved states", |s| moves(s) && s.interface.can_get_and_set_state, state::run),
    stage("values in another order", moves, setting::order),
    stage("tunable parameters during the run", setting::can_tune, setting::tunable),
    stage("two instances at a time", |s| moves(s) && is_repeatable(s), repeat::instances),
    stage("many instances, many steps", |s| moves(s) && is_repeatable(s), repeat::memory),
    stage("steps of another size", |s| steps_itself(s) && s.interface.can_handle_variable_step, steps::size),
    stage("steps past the stop time", steps_itself, steps::stop_time),
    stage("declared derivatives against differences", moves, derivatives::declared),
    stage(
        "derivatives of outputs",
        |s| steps_itself(s) && s.interface.max_output_derivative_order > 0,
        derivatives::of_outputs,
    ),
    stage(
        "derivatives of inputs",
        |s| steps_itself(s) && s.interface.can_interpolate_inputs,
        derivatives::of_inputs,
    ),
    stage("states, derivatives and event indicators", is_integrated, exchange::run),
    stage("partial derivatives and dependencies", moves, jacobian::run),
    stage("Model Exchange against Co-Simulation", |s| is_integrated(s) && is_repeatable(s), compare::run),
    stage(
        "reference results that the FMU carries",
        |s| steps_itself(s) && reference::is_there(s),
        reference::run,
    ),
    stage("freeing an instance that is NULL", |_| true, life::free_nothing),
    Stage { is_misuse: true, ..stage("a wrong guid or token", is_repeatable, misuse::token) },
    Stage { is_misuse: true, ..stage("NaN and values outside the limits", moves, misuse::values) },
    Stage { is_misuse: true, ..stage("value references that do not exist", moves, misuse::references) },
];

/// The largest number of the variables of the same unit; 0 for a variable without unit.
fn largest_of_unit<'a>(numbers: impl Iterator<Item = (&'a Variable, f64)>) -> impl Fn(&Variable) -> f64 {
    let mut largest: HashMap<&str, f64> = HashMap::new();
    for (v, number) in numbers {
        if let Some(unit) = &v.unit {
            let place = largest.entry(unit).or_default();
            *place = place.max(number);
        }
    }
    move |v| v.unit.as_deref().and_then(|unit| largest.get(unit)).copied().unwrap_or_default()
}
