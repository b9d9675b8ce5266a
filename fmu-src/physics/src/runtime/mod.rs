//! The runtime of all models.
//!
//! A model consists of variables, components and [`Equations`]. The [`Runtime`] provides everything else: inputs and their derivatives,
//! time, values by slot, cached outputs, steps with events and limits of validity (this file), the functions of
//! [`Model`](crate::model::Model) (`model.rs`), Model Exchange with the discrete states (`exchange.rs`), saved states (`saved.rs`), and, for
//! models at whose ports terms from data act, their drivers and lags (`driven.rs`).

mod driven;
mod equations;
mod exchange;
mod halt;
mod model;
mod saved;

pub use driven::{Driven, TermStates};
pub use equations::{Equations, NoVariables, Table};
pub use exchange::PreValues;
pub use halt::Halt;
pub use saved::Saved;

use crate::effects::IMMINENT;
use crate::groups::Grouped;
use crate::model::{Declaration, Fault, GroupAt, ModelType, Unserved};
use declare::Group;
use exchange::Followed;
use halt::approach;

/// A model: its parameters, inputs and states with the equations `M`, which have `N` continuous states.
#[derive(Clone, Debug)]
pub struct Runtime<M: Equations<N>, const N: usize> {
    /// Parameters. After a direct change, initialize the model again.
    pub parameters: M::Parameters,
    /// Inputs. After a direct change, call [`set_states`](crate::model::Model::set_states).
    pub inputs: M::Inputs,
    /// Derivatives of the inputs over the next step, per second.
    pub(crate) slopes: M::Inputs,
    /// Whether any of them was set to a value other than zero.
    is_sloping: bool,
    pub(crate) time: f64,
    /// State between communication points.
    pub(crate) own: M,
    /// Values that are constant between events, in Model Exchange.
    pub(crate) pre: Option<PreValues<M::Discrete, N>>,
    /// Coupled states in use.
    followed: Followed<N>,
    outputs: M::Outputs,
    balance: M::Balance,
    indicators: M::Indicators,
    /// Shared quantities at the present time, if cached.
    point: Option<M::Point>,
    /// Whether cached outputs and energy balance belong to the present time.
    has_outputs: bool,
    has_balance: bool,
    /// Whether the last step ended at a limit of validity.
    ended: bool,
}

/// Indices of the groups of variables before the parameters.
const INPUTS: usize = 0;
const OUTPUTS: usize = 1;
const BALANCE: usize = 2;
const INDICATORS: usize = 3;
const PARAMETERS: usize = 4;

impl<M: Equations<N>, const N: usize> Default for Runtime<M, N> {
    fn default() -> Self {
        let parameters = M::Parameters::default();
        Runtime {
            own: M::new(&parameters),
            parameters,
            inputs: M::Inputs::default(),
            slopes: M::Inputs::zero(),
            is_sloping: false,
            time: 0.0,
            pre: None,
            followed: Followed::default(),
            outputs: M::Outputs::default(),
            balance: M::Balance::default(),
            indicators: M::Indicators::default(),
            point: None,
            has_outputs: false,
            has_balance: false,
            ended: false,
        }
    }
}

impl<M: Equations<N>, const N: usize> Runtime<M, N> {
    /// Entry in the list of models.
    pub const TYPE: ModelType = ModelType { declaration: M::declaration, new: || Box::new(Self::default()) };

    /// Declaration of a model with this name and description.
    pub fn declare(name: &'static str, description: &'static str, unserved: &[Unserved]) -> Declaration {
        let own = |prefix, table| GroupAt { prefix, base: 0, table };
        let mut groups = vec![
            own("", M::Inputs::TABLE),
            own("", M::Outputs::TABLE),
            own("", M::Balance::TABLE),
            own("event.", M::Indicators::TABLE),
        ];
        groups.extend(M::Parameters::groups());
        Declaration::new(name, description, groups, M::LIST, unserved)
    }

    /// Whether an input has a nonzero derivative.
    #[inline]
    pub(crate) fn is_sloping(&self) -> bool {
        self.is_sloping
    }

    pub(crate) fn put_slopes(&mut self, slopes: M::Inputs) {
        (self.slopes, self.is_sloping) = (slopes, slopes != M::Inputs::zero());
    }

    /// Makes the inputs constant over the next step.
    #[inline]
    pub(crate) fn clear_slopes(&mut self) {
        if self.is_sloping {
            (self.slopes, self.is_sloping) = (M::Inputs::zero(), false);
        }
    }

    /// Invalidates the cache after a change of a state, an input or a parameter.
    #[inline]
    pub(crate) fn outdate(&mut self) {
        (self.point, self.has_outputs, self.has_balance) = (None, false, false);
    }

    /// Shared quantities at the present time, if cached.
    #[inline]
    pub(crate) fn known_point(&self) -> Option<&M::Point> {
        self.point.as_ref()
    }

    /// Result of `look` with the shared quantities at the present time.
    #[inline]
    fn look<T>(&mut self, look: impl FnOnce(&Self, &M::Point) -> T) -> T {
        if self.point.is_none() {
            self.point = Some(M::point(self));
        }
        match &self.point {
            Some(point) => look(self, point),
            None => unreachable!("it was evaluated"),
        }
    }

    /// Derivatives of all states.
    fn all_rates(&mut self) -> Result<[f64; N], Fault> {
        self.look(M::rates)
    }

    /// A state as the importer reads it.
    fn shown_state(&self, k: usize) -> f64 {
        let still = self.pre.as_ref().and_then(|pre| pre.still[k]);
        still.unwrap_or_else(|| M::state(self, k))
    }

    /// Sets inputs and time to those at `time`, the end of a step of `h` seconds.
    #[inline]
    pub(crate) fn arrive(&mut self, time: f64, h: f64) {
        if self.is_sloping() {
            self.inputs = self.inputs.after(h, &self.slopes);
            M::follow_inputs(self);
        }
        self.time = time;
        self.outdate();
    }

    /// A step, divided at the events inside it.
    #[inline]
    fn step_over_events(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let end = time + h;
        let event = M::next_division(self, time);
        if event < end - IMMINENT {
            return self.step_over_event(time, event, end);
        }
        M::advance(self, time, h)?;
        self.clear_slopes();
        Ok(())
    }

    /// Both parts of a step, before and after the event, or neither. Not inlined, because the copy of the model needs much stack.
    #[inline(never)]
    fn step_over_event(&mut self, time: f64, event: f64, end: f64) -> Result<(), Halt> {
        let (before, slopes) = (self.clone(), self.slopes);
        let outcome = M::advance(self, time, event - time).and_then(|()| {
            self.put_slopes(slopes);
            M::pass_event(self, &before, time, event);
            self.step_over_events(event, end - event)
        });
        match outcome {
            Ok(()) => self.time = end,
            Err(_) => *self = before,
        }
        outcome
    }

    /// A step; at a limit of validity it ends at the last time within the limit.
    #[inline]
    fn step_to_limit(&mut self, time: f64, h: f64) -> Result<(), Fault> {
        self.ended = false;
        let halt = match self.step_over_events(time, h) {
            Ok(()) => return Ok(()),
            Err(Halt::Fault(fault)) if !M::IS_LIMITED => return Err(fault),
            Err(halt) => halt,
        };
        // A failed step changes nothing.
        let slopes = self.slopes;
        let at = approach(self, (time, h), halt, |run, at, h| {
            run.put_slopes(slopes);
            run.step_over_events(at, h)
        })?;
        self.clear_slopes();
        self.ended = true;
        Err(Fault(M::termination_reason(self, at)))
    }
}
