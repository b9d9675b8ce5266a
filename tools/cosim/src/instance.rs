//! One instance of an FMU, the same for FMI 2.0 and 3.0: the raw calls with checks before and errors after.
use crate::error::because;
use crate::raw::{Experiment, Functions, InterfaceType, RawBinary, RawInstance, RawSetup, RawState, names};
use crate::{Archive, Causality, Error, FmiVersion, IntervalVariability, Log, Status};
use clocks::Events;
use std::sync::atomic::{AtomicU64, Ordering};

mod access;
mod clocks;
mod exchange;
mod state;
pub use state::State;

/// The names of one function in both standards, for messages.
type Names = [&'static str; 2];

/// How a communication step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// At `t + h`.
    Done,
    /// The FMU requests the end of the simulation.
    Terminated,
}

/// A Co-Simulation instance of an FMU.
///
/// Warnings go to the [`Log`]; Discard, Error and Fatal become [`Error::Call`] with the FMU's own words. After
/// Fatal the binary is never called again, not even to free the instance. Lists of value references go with lists
/// of values of the same length; for FMI 3 arrays the values of all elements follow each other.
/// Get, set and step do not allocate for scalars, apart from strings.
pub struct Instance {
    name: String,
    raw: RawInstance,
    /// Distinguishes the states of this instance from those of other instances.
    id: u64,
    /// States of the FMU by slot; none where freed.
    states: Vec<RawState>,
    /// Slots of `states` that no [`State`] refers to.
    free_slots: Vec<usize>,
    /// Event mode at the time of each saved state.
    saved_events: Vec<Events>,
    /// A state was saved, so a rollback is possible.
    saved: bool,
    /// FMI 3 event mode.
    events: Events,
    /// Input clocks that tick by time, with the intervals that the description gives.
    declared_clocks: Vec<(u32, IntervalVariability, Option<f64>)>,
    /// Start time (s).
    start: f64,
    /// FMI 3: inputs were named that may have derivatives.
    has_intermediate: bool,
}

// SAFETY: as for `RawInstance`; saved states are used with this instance alone.
unsafe impl Send for Instance {}

impl std::fmt::Debug for Instance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let dead = self.raw.is_dead();
        f.debug_struct("Instance").field("name", &self.name).field("dead", &dead).finish_non_exhaustive()
    }
}

impl Instance {
    /// Loads the binary and instantiates it for Co-Simulation; messages of the FMU go to `log`.
    ///
    /// # Errors
    /// No Co-Simulation interface, no binary for this platform, a binary that cannot be loaded or lacks functions,
    /// an FMU that refuses.
    pub fn instantiate(archive: &Archive, name: &str, log: Log) -> Result<Self, Error> {
        Self::instantiate_as(archive, name, log, InterfaceType::CoSimulation, &[])
    }

    /// As [`Self::instantiate`], for [`Self::set_input_derivatives`] of these inputs (value references).
    ///
    /// # Errors
    /// As there.
    pub fn instantiate_with_lines(
        archive: &Archive,
        name: &str,
        log: Log,
        inputs: &[u32],
    ) -> Result<Self, Error> {
        Self::instantiate_as(archive, name, log, InterfaceType::CoSimulation, inputs)
    }

    /// As [`Self::instantiate`], for an interface type. FMI 3: the inputs in `intermediate` (value references) may have derivatives.
    pub(crate) fn instantiate_as(
        archive: &Archive,
        name: &str,
        log: Log,
        kind: InterfaceType,
        intermediate: &[u32],
    ) -> Result<Self, Error> {
        let description = archive.description();
        let Some(interface) = description.interface(kind) else {
            if kind != InterfaceType::CoSimulation {
                return Err(archive.unsupported(format!("has no interface for {kind}")));
            }
            let has = |kind| description.interface(kind).is_some();
            let what = if has(InterfaceType::ModelExchange) {
                "is for Model Exchange only"
            } else if has(InterfaceType::ScheduledExecution) {
                "is for Scheduled Execution only, which this program does not support"
            } else {
                "has no interface"
            };
            return Err(archive.unsupported(format!("cannot be stepped: it {what}")));
        };
        let binary = RawBinary::load(archive, &interface.model_identifier)?;
        if let Some(symbol) = binary.missing(kind) {
            let name = format!("the binary of {}", archive.path().display());
            return Err(Error::unsupported(name, format!("does not export {symbol}")));
        }
        let token = &description.token;
        // FMI 3 requires event mode for FMUs with clocks.
        let event_mode = kind == InterfaceType::CoSimulation
            && interface.has_event_mode
            && description.variables.iter().any(|v| v.clock.is_some());
        let setup = RawSetup { interface: kind, token, name, event_mode, intermediate };
        let mark = log.mark();
        let Some(mut raw) = binary.instantiate(&setup, &log) else {
            let words = because(&log.since(mark));
            return Err(archive.unsupported(format!("refused to be instantiated as {name}{words}")));
        };
        if !log.debug() {
            raw.enable_reasons(&description.log_categories);
        }
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Ok(Self {
            name: name.to_owned(),
            raw,
            id: NEXT.fetch_add(1, Ordering::Relaxed),
            states: Vec::new(),
            free_slots: Vec::new(),
            saved_events: Vec::new(),
            saved: false,
            events: Events { used: event_mode, ..Events::default() },
            declared_clocks: description
                .variables
                .iter()
                .filter(|v| v.causality == Causality::Input)
                .filter_map(|v| Some((v.value_reference, v.clock?.variability, v.clock?.interval)))
                .filter(|(_, variability, _)| *variability != IntervalVariability::Triggered)
                .collect(),
            start: 0.0,
            has_intermediate: !intermediate.is_empty(),
        })
    }

    /// The name given at instantiation.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The sink of the FMU's messages.
    pub fn log(&self) -> &Log {
        self.raw.log()
    }

    /// FMI 3: enters configuration mode, in which structural parameters can be set.
    ///
    /// # Errors
    /// [`Error::Call`]; [`Error::Unsupported`] for FMI 2.
    pub fn enter_configuration_mode(&mut self) -> Result<(), Error> {
        let names = ["configuration mode", names::enter_configuration[1]];
        self.call_optional(names, |f| f.enter_configuration.is_some(), RawInstance::enter_configuration)
    }

    /// FMI 3: leaves configuration mode.
    ///
    /// # Errors
    /// As [`Self::enter_configuration_mode`].
    pub fn exit_configuration_mode(&mut self) -> Result<(), Error> {
        let names = ["configuration mode", names::exit_configuration[1]];
        self.call_optional(names, |f| f.exit_configuration.is_some(), RawInstance::exit_configuration)
    }

    /// FMI 2: `fmi2SetupExperiment`; FMI 3 has no such call. Parameters are set after it: some FMUs reset them here.
    ///
    /// # Errors
    /// [`Error::Call`], as for all calls below.
    pub fn setup_experiment(&mut self, experiment: &Experiment) -> Result<(), Error> {
        self.call(names::setup, |raw| raw.setup_experiment(experiment))
    }

    /// Enters initialization mode, in FMI 2 after [`Self::setup_experiment`].
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn enter_initialization(&mut self, experiment: &Experiment) -> Result<(), Error> {
        self.start = experiment.start;
        let names = [names::enter_initialization2[0], names::enter_initialization3[1]];
        self.call(names, |raw| raw.enter_initialization_mode(experiment))
    }

    /// Leaves initialization mode, and the event mode that follows it if the FMU has clocks: the FMU is ready to step.
    ///
    /// # Errors
    /// [`Error::Call`]; [`Error::Misuse`] for a clock without a positive interval.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        self.call(names::exit_initialization, RawInstance::exit_initialization)?;
        if self.events.used && self.begin_events()? == Step::Terminated {
            return Err(
                self.misuse(names::exit_initialization, "the FMU requests the end at once".to_owned())
            );
        }
        Ok(())
    }

    /// The derivatives (per s) of real inputs over the next step, from their present values on: see
    /// [`ModelDescription::takes_input_derivative`](crate::ModelDescription::takes_input_derivative). In FMI 3 the FMU sets them in
    /// intermediate update mode; they must be named at instantiation.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length, [`Error::Unsupported`] for an FMU without them.
    pub fn set_input_derivatives(&mut self, vrs: &[u32], slopes: &[f64]) -> Result<(), Error> {
        let names = [names::set_input_derivatives[0], "fmi3GetFloat64"];
        if !self.fits(names, vrs.len(), slopes.len())? {
            return Ok(());
        }
        if !self.is_fmi2() {
            if !self.has_intermediate {
                return Err(Error::unsupported(&self.name, "does not provide derivatives of inputs"));
            }
            return self.call(names, |raw| raw.set_lines(vrs, slopes));
        }
        let has = |f: &Functions| f.set_input_derivatives.is_some();
        self.call_optional(names, has, |raw| raw.set_input_derivatives(vrs, slopes))
    }

    /// The derivatives of outputs over one real variable; `false` if the FMU provides none here.
    pub(crate) fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        known: u32,
        out: &mut [f64],
    ) -> Result<bool, Error> {
        let names = [names::directional2[0], names::directional3[1]];
        match self.call(names, |raw| raw.directional_derivative(unknowns, &[known], &[1.0], out)) {
            Ok(()) => Ok(out.iter().all(|slope| slope.is_finite())),
            Err(Error::Call { status: Status::Discard, .. }) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// From now on it may step at the same time as other instances.
    pub(crate) fn take_lane(&mut self) {
        self.raw.take_lane();
    }

    /// One communication step from `t` to `t + h` (s).
    ///
    /// # Errors
    /// [`Error::Call`] with the time.
    pub fn do_step(&mut self, t: f64, h: f64) -> Result<Step, Error> {
        if self.events.used {
            return self.step_with_events(t, h);
        }
        Ok(self.plain_step(t, h)?.0)
    }

    /// One call of the step function; then whether the FMU requests event mode.
    #[inline]
    fn plain_step(&mut self, t: f64, h: f64) -> Result<(Step, bool), Error> {
        let no_rollback = !self.saved;
        let (mut terminated, mut early, mut event) = (false, false, false);
        let names = [names::do_step2[0], names::do_step3[1]];
        self.call_at(names, Some(t), |raw| {
            let step = raw.do_step(t, h, no_rollback);
            (terminated, early, event) = (step.terminated, step.early, step.event);
            step.status
        })?;
        if terminated {
            return Ok((Step::Terminated, false));
        }
        if early {
            return Err(
                self.misuse(names, format!("it returned early from t = {t} s, which was not allowed"))
            );
        }
        Ok((Step::Done, event))
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn terminate(&mut self) -> Result<(), Error> {
        self.call(names::terminate, RawInstance::terminate)
    }

    /// Back to the state after instantiation.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn reset(&mut self) -> Result<(), Error> {
        self.call(names::reset, RawInstance::reset)
    }

    #[inline]
    fn call(&mut self, names: Names, f: impl FnOnce(&mut RawInstance) -> Status) -> Result<(), Error> {
        self.call_at(names, None, f)
    }

    /// Evaluates the FMU's status; all calls except free use this function.
    #[inline]
    fn call_at(
        &mut self,
        names: Names,
        time: Option<f64>,
        f: impl FnOnce(&mut RawInstance) -> Status,
    ) -> Result<(), Error> {
        if self.raw.is_dead() {
            return Err(Error::Dead { instance: self.name.clone(), function: self.pick(names) });
        }
        let mark = self.raw.log().mark();
        let status = f(&mut self.raw);
        if status <= Status::Warning { Ok(()) } else { Err(self.failed(names, time, status, mark)) }
    }

    #[cold]
    fn failed(&self, names: Names, time: Option<f64>, status: Status, mark: u64) -> Error {
        Error::Call {
            instance: self.name.clone(),
            function: self.pick(names),
            status,
            time,
            messages: self.raw.log().since(mark),
        }
    }

    /// As `call`, for a function that the FMU may lack.
    #[inline]
    fn call_optional(
        &mut self,
        names: Names,
        has: impl Fn(&Functions) -> bool,
        f: impl FnOnce(&mut RawInstance) -> Status,
    ) -> Result<(), Error> {
        if !self.raw.is_dead() && !has(self.raw.functions()) {
            return Err(Error::unsupported(&self.name, format!("does not provide {}", self.pick(names))));
        }
        self.call(names, f)
    }

    fn is_fmi2(&self) -> bool {
        self.raw.version() == FmiVersion::V2
    }

    fn pick(&self, names: Names) -> &'static str {
        names[usize::from(!self.is_fmi2())]
    }

    fn misuse(&self, names: Names, reason: String) -> Error {
        Error::Misuse { instance: self.name.clone(), function: self.pick(names), reason }
    }
}
