//! Interface between a model and the [`Runtime`].

use super::{Halt, Runtime, Saved};
use crate::groups::Grouped;
use crate::load_table::LoadTable;
use crate::model::{Declaration, Fault, HousingHeat};
use crate::terms::{Drivers, GenericTerm};
use declare::{Group, State, Variable};
use std::fmt::Debug;

/// A group of variables that a model can own.
pub trait Table: Group + Copy + Debug + Default + PartialEq + Send + Sync + 'static {}
impl<T: Group + Copy + Debug + Default + PartialEq + Send + Sync + 'static> Table for T {}

/// A group without variables.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NoVariables;

impl Group for NoVariables {
    const TABLE: &'static [Variable] = &[];

    fn get(&self, index: usize) -> f64 {
        panic!("no row {index}")
    }

    fn set(&mut self, index: usize, _: f64) -> bool {
        panic!("no row {index}")
    }

    fn zero() -> Self {
        NoVariables
    }
}

/// The equations of a model with `N` continuous states. The implementing type holds the state between communication points:
/// continuous states, quantities that follow from the parameters, and the integrator. The runtime holds parameters, inputs and time.
pub trait Equations<const N: usize>: Clone + Debug + Saved + Send + Sync + Sized + 'static {
    /// Parameters.
    type Parameters: Grouped + Clone + Debug + Default + Send + Sync + 'static;
    /// Inputs.
    type Inputs: Table;
    /// Outputs.
    type Outputs: Table;
    /// Outputs of the energy balance, which take longer to compute; [`NoVariables`] if there are none.
    type Balance: Table;
    /// Event indicators.
    type Indicators: Table;
    /// Quantities at the present time that outputs and derivatives share; evaluated once for given time, states and inputs.
    type Point: Clone + Debug + Send + Sync + 'static;
    /// Discrete states of Model Exchange, constant between events.
    type Discrete: Copy + Debug + Default + Saved + Send + Sync + 'static;
    /// The continuous states.
    const LIST: &'static [State];
    /// Whether the model has limits of validity.
    const IS_LIMITED: bool = false;

    /// The declaration of the model.
    fn declaration() -> &'static Declaration;
    /// The model before initialization.
    fn new(parameters: &Self::Parameters) -> Self;

    /// Initializes all states at the time of `run`.
    ///
    /// # Errors
    /// Inconsistent parameters; the model is then unchanged.
    fn start(run: &mut Runtime<Self, N>) -> Result<(), Fault>;
    /// Advances from `time` by `h` seconds without an event inside, and calls [`Runtime::arrive`]; unchanged on failure.
    ///
    /// # Errors
    /// Equations without a solution, or a limit of validity.
    fn advance(run: &mut Runtime<Self, N>, time: f64, h: f64) -> Result<(), Halt>;
    /// Quantities that the following functions share.
    fn point(run: &Runtime<Self, N>) -> Self::Point;
    /// The outputs.
    fn outputs(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Outputs;
    /// The output in this row, if it needs no evaluation of the equations.
    #[inline]
    fn output(_run: &Runtime<Self, N>, _row: usize) -> Option<f64> {
        None
    }
    /// The output of the energy balance in this row, if it needs no evaluation of all power flows.
    #[inline]
    fn flow(_run: &Runtime<Self, N>, _row: usize) -> Option<f64> {
        None
    }
    /// The outputs of the energy balance.
    fn balance(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Balance;
    /// The event indicators.
    fn indicators(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Indicators;
    /// Sets a parameter by `set` and updates the quantities that follow from the parameters.
    fn set_parameter(run: &mut Runtime<Self, N>, set: impl FnOnce(&mut Self::Parameters) -> bool) -> bool;
    /// Sets the states that inputs impose.
    #[inline]
    fn follow_inputs(_run: &mut Runtime<Self, N>) {}
    /// Why the model does not take a term, in a few words about the model; `None` if it does.
    fn refusal(_term: &GenericTerm) -> Option<&'static str> {
        Some("it takes no terms")
    }
    /// Sets the generic terms, which the model does not [refuse](Equations::refusal); false, without a change, if it supports fewer.
    fn set_terms(_run: &mut Runtime<Self, N>, _terms: &[GenericTerm]) -> bool {
        false
    }
    /// Sets a load table; false if the model does not use one.
    fn set_load(_run: &mut Runtime<Self, N>, _table: &LoadTable) -> bool {
        false
    }

    /// Value of a state; a constant if it is not in use.
    fn state(run: &Runtime<Self, N>, k: usize) -> f64;
    /// Sets a state that is in use.
    fn put_state(run: &mut Runtime<Self, N>, k: usize, value: f64);
    /// Updates the quantities that follow from states that were set.
    fn follow_states(_run: &mut Runtime<Self, N>) {}
    /// Whether a state is in use in the present modes.
    fn moves(_run: &Runtime<Self, N>, _k: usize) -> bool {
        true
    }
    /// Whether the derivative of another state can depend on this state.
    fn is_coupled(_k: usize) -> bool {
        true
    }
    /// Time derivatives of the states; zero for states that are not in use.
    ///
    /// # Errors
    /// Parameters without valid equations.
    fn rates(run: &Runtime<Self, N>, point: &Self::Point) -> Result<[f64; N], Fault>;
    /// Derivatives of the coupled states, while the others may be NaN, and the outputs.
    fn coupled_rates_and_outputs(run: &Runtime<Self, N>, point: &Self::Point) -> ([f64; N], Self::Outputs) {
        (Self::rates(run, point).unwrap_or([f64::NAN; N]), Self::outputs(run, point))
    }

    /// Next time event after `time`, s; infinite without one.
    fn next_event(_run: &Runtime<Self, N>, _time: f64) -> f64 {
        f64::INFINITY
    }
    /// First event after `time` at which a Co-Simulation step is divided, s; infinite without one.
    #[inline]
    fn next_division(_run: &Runtime<Self, N>, _time: f64) -> f64 {
        f64::INFINITY
    }
    /// Called when a step from `time` has reached the event that divides it; `before` is the model at `time`.
    fn pass_event(_run: &mut Runtime<Self, N>, _before: &Runtime<Self, N>, _time: f64, _event: f64) {}
    /// The discrete states before the first event.
    fn discrete_before(_run: &Runtime<Self, N>) -> Self::Discrete {
        Self::Discrete::default()
    }
    /// The discrete states after an event at the present time; `before` are those before it.
    fn discrete(run: &Runtime<Self, N>, before: &Self::Discrete) -> Self::Discrete;
    /// Called when the importer enters Model Exchange.
    fn enter_model_exchange(_run: &mut Runtime<Self, N>) {}
    /// Called when the importer requests derivatives: values of the present time replace those of a step.
    fn evaluate(_run: &mut Runtime<Self, N>) {}
    /// The importer has completed a step.
    fn accept_step(_run: &mut Runtime<Self, N>) {}

    /// Largest excess over a limit of validity, K.
    fn excess(_run: &Runtime<Self, N>) -> f64 {
        f64::NEG_INFINITY
    }
    /// Reason for the end of a run at a limit of validity at `time`, s.
    fn termination_reason(_run: &Runtime<Self, N>, _time: f64) -> String {
        String::new()
    }
    /// The same without what belongs to that time.
    fn passed_limit(_run: &Runtime<Self, N>) -> String {
        String::new()
    }

    /// Appends values that can only be restored after the parameters.
    fn save_rest(&self, _out: &mut Vec<f64>) {}
    /// Updates the quantities that follow from restored values, and restores the values of [`save_rest`](Equations::save_rest).
    fn restored(_run: &mut Runtime<Self, N>, _next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        Some(())
    }
    /// Sets the factors on the integrator's tolerances for searches: of heat, and of current and speed.
    fn ease(_run: &mut Runtime<Self, N>, _factors: [f64; 2]) {}
    /// Sets the factor between the importer's tolerance and that of the integrator.
    fn scale_tolerances(run: &mut Runtime<Self, N>, factor: f64);
    /// Number of rejected steps.
    fn rejected_steps(run: &Runtime<Self, N>) -> u64;
    /// Heat flow from the housing to ambient.
    fn housing_heat(_run: &Runtime<Self, N>) -> Option<HousingHeat> {
        None
    }
    /// Drivers of the terms.
    fn drivers(run: &Runtime<Self, N>) -> Drivers;
}
