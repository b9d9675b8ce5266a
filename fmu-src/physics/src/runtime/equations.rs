//! What a model gives to the [`Runtime`].

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

/// The equations of a model with `N` continuous states. The type itself holds what the model carries from one communication point to
/// the next beside parameters, inputs and time, which the runtime owns: continuous states, quantities that follow from the parameters,
/// the integrator.
pub trait Equations<const N: usize>: Clone + Debug + Saved + Send + Sync + Sized + 'static {
    /// Parameters.
    type Parameters: Grouped + Clone + Debug + Default + Send + Sync + 'static;
    /// Inputs.
    type Inputs: Table;
    /// Outputs.
    type Outputs: Table;
    /// Outputs of the energy balance, which take longer to compute; [`NoVariables`] without them.
    type Balance: Table;
    /// Event indicators.
    type Indicators: Table;
    /// Quantities at the present time that outputs and derivatives share; evaluated once for a time, its states and inputs.
    type Point: Clone + Debug + Send + Sync + 'static;
    /// Discrete states of Model Exchange, constant between events.
    type Discrete: Copy + Debug + Default + Saved + Send + Sync + 'static;
    /// The continuous states.
    const LIST: &'static [State];
    /// Whether the equations end at limits of validity.
    const IS_LIMITED: bool = false;

    /// The declaration of the model.
    fn declaration() -> &'static Declaration;
    /// Before initialization.
    fn new(parameters: &Self::Parameters) -> Self;

    /// Initializes all states at the time of `run`.
    ///
    /// # Errors
    /// Parameters that contradict each other; nothing has changed then.
    fn start(run: &mut Runtime<Self, N>) -> Result<(), Fault>;
    /// Advances from `time` by `h` seconds, without an event in between, and calls [`Runtime::arrive`]; on failure nothing changes.
    ///
    /// # Errors
    /// Equations without a solution, or a limit of validity.
    fn advance(run: &mut Runtime<Self, N>, time: f64, h: f64) -> Result<(), Halt>;
    /// Quantities that the functions below share.
    fn point(run: &Runtime<Self, N>) -> Self::Point;
    /// The outputs.
    fn outputs(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Outputs;
    /// The output in this row, where it needs no equations.
    #[inline]
    fn output(_run: &Runtime<Self, N>, _row: usize) -> Option<f64> {
        None
    }
    /// The outputs of the energy balance.
    fn balance(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Balance;
    /// The event indicators.
    fn indicators(run: &Runtime<Self, N>, point: &Self::Point) -> Self::Indicators;
    /// Sets a parameter by `set` and renews what follows from the parameters.
    fn set_parameter(run: &mut Runtime<Self, N>, set: impl FnOnce(&mut Self::Parameters) -> bool) -> bool;
    /// States that inputs impose follow them.
    #[inline]
    fn follow_inputs(_run: &mut Runtime<Self, N>) {}
    /// Takes terms that are data; false, without a change, where the model has none or not as many.
    fn set_terms(_run: &mut Runtime<Self, N>, _terms: &[GenericTerm]) -> bool {
        false
    }
    /// Takes a load table; false where the model has no use for one.
    fn set_load(_run: &mut Runtime<Self, N>, _table: &LoadTable) -> bool {
        false
    }

    /// A state; a constant where it does not move.
    fn state(run: &Runtime<Self, N>, k: usize) -> f64;
    /// Sets a state that moves.
    fn put_state(run: &mut Runtime<Self, N>, k: usize, value: f64);
    /// What follows from states that were set.
    fn follow_states(_run: &mut Runtime<Self, N>) {}
    /// Whether a state moves in the present modes.
    fn moves(_run: &Runtime<Self, N>, _k: usize) -> bool {
        true
    }
    /// Whether the derivative of another state can depend on a state.
    fn is_coupled(_k: usize) -> bool {
        true
    }
    /// Derivatives of the states with respect to time, zero for those that do not move.
    ///
    /// # Errors
    /// Parameters for which there are none.
    fn rates(run: &Runtime<Self, N>, point: &Self::Point) -> Result<[f64; N], Fault>;
    /// Derivatives of the coupled states; the others may be missing.
    fn coupled_rates(run: &Runtime<Self, N>, point: &Self::Point) -> [f64; N] {
        Self::rates(run, point).unwrap_or([f64::NAN; N])
    }

    /// The first event after `time` that is known by its time, s; infinite without one.
    fn next_event(_run: &Runtime<Self, N>, _time: f64) -> f64 {
        f64::INFINITY
    }
    /// The first event after `time` at which a step of Co-Simulation is divided, s; infinite without one.
    #[inline]
    fn next_division(_run: &Runtime<Self, N>, _time: f64) -> f64 {
        f64::INFINITY
    }
    /// A step from `time` with the model as it was `before` has reached the event at which it is divided.
    fn pass_event(_run: &mut Runtime<Self, N>, _before: &Runtime<Self, N>, _time: f64, _event: f64) {}
    /// The discrete states after an event at the present time, and before it.
    fn discrete(run: &Runtime<Self, N>, before: &Self::Discrete) -> Self::Discrete;
    /// The importer has taken over the integration.
    fn enter_model_exchange(_run: &mut Runtime<Self, N>) {}
    /// The importer asks for derivatives: what belongs to the present values replaces what belongs to a step.
    fn evaluate(_run: &mut Runtime<Self, N>) {}
    /// The importer has completed a step.
    fn accept_step(_run: &mut Runtime<Self, N>) {}

    /// The largest excess over a limit of validity, K.
    fn excess(_run: &Runtime<Self, N>) -> f64 {
        f64::NEG_INFINITY
    }
    /// Reason of the end of a run at a limit of validity at `time`, s.
    fn termination_reason(_run: &Runtime<Self, N>, _time: f64) -> String {
        String::new()
    }

    /// Appends what can only be restored with the parameters.
    fn save_rest(&self, _out: &mut Vec<f64>) {}
    /// Renews what follows from restored values, and takes back what [`save_rest`](Equations::save_rest) has appended.
    fn restored(_run: &mut Runtime<Self, N>, _next: &mut impl FnMut() -> Option<f64>) -> Option<()> {
        Some(())
    }
    /// Factor on the tolerances of the integrator that searches use.
    fn ease(_run: &mut Runtime<Self, N>, _factor: f64) {}
    /// Factor of the importer's tolerance on that of the integrator.
    fn scale_tolerances(run: &mut Runtime<Self, N>, factor: f64);
    /// Steps that the integrator has rejected.
    fn rejected_steps(run: &Runtime<Self, N>) -> u64;
    /// Heat flow from the housing to ambient.
    fn housing_heat(_run: &Runtime<Self, N>) -> Option<HousingHeat> {
        None
    }
    /// What terms may follow.
    fn drivers(run: &Runtime<Self, N>) -> Drivers;
}
