//! An instance: its state machine and the checks of each call.

mod cache;
mod exchange;
mod mode;
mod report;
mod saturation;
mod saving;
mod slopes;
mod stepping;
mod values;

pub use mode::{Interface, Mode, Standard, Type};
pub use stepping::{Ended, IntermediateUpdate, IntermediateUpdates, Part, StepInParts, View};

use crate::contents;
use crate::logger::{CATEGORIES, Category, Log, Status, c_string};
use crate::refusal::{Outcome, Refused};
use crate::resources::Location;
use cache::Cache;
use physics::model::{Fault, Model, ModelType, Slot};
use physics::resources::Resources;
use report::Report;
use saturation::Saturation;
use saving::SavedStates;
use std::ffi::{CStr, CString};

/// Relative tolerance if the importer defines none: that of `DefaultExperiment` in the model description.
pub const DEFAULT_TOLERANCE: f64 = physics::model::TOLERANCE;
/// Range of tolerances; values outside are limited to it.
pub const TOLERANCES: [f64; 2] = [1e-9, 1e-2];

/// One instance of the model that is selected by the token.
pub struct Instance {
    kind: &'static ModelType,
    model: Box<dyn Model>,
    /// A copy of the model for the evaluation of derivatives, created at the first request.
    scratch: Option<Box<dyn Model>>,
    /// Resources of the archive.
    resources: Resources,
    /// Fingerprints of the resources, for serialized states.
    equations: [u64; 2],
    standard: Standard,
    interface: Interface,
    /// Optional features that the importer uses.
    part: Part,
    /// Discrete outputs and their values since the last event; empty without event mode.
    discrete: Vec<Slot>,
    discrete_pre: Vec<f64>,
    /// The model at the start of the present step or part of a step, for rollback.
    step_start: Option<Box<dyn Model>>,
    /// The model at the start of a step with intermediate updates.
    update_start: Option<Box<dyn Model>>,
    /// The model at the start of the last part of that step.
    part_start: Option<Box<dyn Model>>,
    /// Number of elements of arrays whose size is a structural parameter; in FMI 2 that of the archive.
    elements: u32,
    mode: Mode,
    /// Start and stop time, s; the stop time is infinite if undefined.
    window: (f64, f64),
    /// Whether values were set in initialization mode since the last initialization of the model.
    unsettled: bool,
    /// Cached lists of value references: read, set, and set with derivatives.
    read: Cache,
    written: Cache,
    sloped: Cache,
    saturation: Saturation,
    /// Whether the present call returns Warning if it succeeds.
    pub has_warned: bool,
    /// Ratio of the importer's tolerance to [`DEFAULT_TOLERANCE`].
    tolerance: f64,
    /// Length of the last step of the model, s; 0 before the first.
    last_step: f64,
    /// Output buffer: states, derivatives, event indicators.
    buffer: Vec<f64>,
    report: Report,
    /// Freed with the instance if the importer has not freed them.
    saved_states: SavedStates,
    /// Reason for the end of the run at a limit of validity.
    ended: Option<CString>,
    /// Log messages.
    pub log: Log,
}

impl Instance {
    /// An instance of the model with this token and the resources of its archive at this location.
    pub fn new(
        token: Option<&str>,
        location: &Location,
        (standard, interface): (Standard, Interface),
        part: Part,
        log: Log,
    ) -> Outcome<Instance> {
        let (kind, contents) = contents::selected(token)?;
        let resources = location.folder.as_deref().map_or(Ok(Resources::default()), terms::of_resources);
        let resources = resources.map_err(|error| Refused::error(format!("{error}.")))?;
        contents::check(kind, contents, &resources, location, standard)?;
        let Some(mut model) = crate::new_model(kind, &resources) else {
            let load =
                resources.load.as_ref().map(|_| format!("the load table of {}", terms::load::FILE_NAME));
            let terms = (!resources.terms.is_empty()).then(|| format!("the terms of {}", terms::FILE_NAME));
            let name = (kind.declaration)().name;
            let data: Vec<String> = terms.into_iter().chain(load).collect();
            let fresh = (kind.new)();
            let why = resources.terms.iter().find_map(|term| fresh.refusal(term));
            let why = why.map_or(String::new(), |why| format!(": {why}"));
            return Err(Refused::error(format!("{name} does not accept {}{why}.", data.join(" and "))));
        };
        if interface == Interface::ModelExchange {
            model.enter_model_exchange();
        }
        let declaration = (kind.declaration)();
        part.check(declaration)?;
        let discrete = if part.event_mode { part.discrete(declaration) } else { Vec::new() };
        Ok(Instance {
            kind,
            standard,
            interface,
            part,
            discrete_pre: vec![0.0; discrete.len()],
            discrete,
            step_start: None,
            update_start: None,
            part_start: None,
            scratch: None,
            elements: counted(model.as_mut()),
            model,
            equations: resources.equations(),
            resources,
            mode: Mode::Instantiated,
            window: (0.0, f64::INFINITY),
            unsettled: true,
            read: Cache::EMPTY,
            written: Cache::EMPTY,
            sloped: Cache::EMPTY,
            saturation: Saturation::new(declaration),
            has_warned: false,
            tolerance: 1.0,
            last_step: 0.0,
            buffer: vec![0.0; declaration.states.len().max(declaration.indicators.len())],
            report: Report::new(declaration),
            saved_states: SavedStates::default(),
            ended: None,
            log,
        })
    }

    /// Status of a successful call: Ok, or Warning if the call has caused one.
    pub fn warned(&mut self) -> Status {
        self.has_warned = false;
        Status::Warning
    }

    #[inline]
    fn require(&self, allowed: &[Mode]) -> Outcome {
        if allowed.contains(&self.mode) { Ok(()) } else { Err(self.not_now()) }
    }

    #[cold]
    fn not_now(&self) -> Refused {
        Refused::error(format!("not allowed while the instance is {}.", self.mode.words()))
    }

    /// Whether a call has caused an internal failure.
    pub fn has_failed(&self) -> bool {
        self.mode == Mode::Error
    }

    /// Enters the error state after a panic; only a saved state or a reset ends it.
    pub fn enter_error_state(&mut self) {
        self.mode = Mode::Error;
    }

    /// Enables or disables log categories, all of them if none is named; rejects an unknown category.
    pub fn set_logging(&mut self, on: bool, categories: &[Option<String>]) -> Outcome {
        let place = |category: &Option<String>| {
            let category = category.as_deref().unwrap_or("NULL");
            CATEGORIES.iter().position(|(name, _)| *name == category).ok_or_else(|| {
                let known: Vec<&str> = CATEGORIES.iter().map(|(name, _)| *name).collect();
                Refused::error(format!("the log category {category} is none of {}.", known.join(", ")))
            })
        };
        let places = categories.iter().map(place).collect::<Outcome<Vec<usize>>>()?;
        self.log.enable(on, &places);
        Ok(())
    }

    /// Sets the relative tolerance; `None` is the default.
    ///
    /// The integrators' tolerances are multiplied by the ratio to [`DEFAULT_TOLERANCE`], for which they are designed. Below
    /// [`TOLERANCES`] rounding errors dominate; above, the stages of a step become inconsistent.
    pub fn set_tolerance(&mut self, tolerance: Option<f64>) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        let tolerance = tolerance.unwrap_or(DEFAULT_TOLERANCE);
        if !(tolerance > 0.0 && tolerance.is_finite()) {
            return Err(Refused::error(format!("the tolerance {tolerance} is not positive and finite.")));
        }
        self.tolerance = tolerance.clamp(TOLERANCES[0], TOLERANCES[1]) / DEFAULT_TOLERANCE;
        Ok(())
    }

    /// Sets start and stop time; `None` without a stop time.
    pub fn set_window(&mut self, start: f64, stop: Option<f64>) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        if !start.is_finite() {
            return Err(Refused::error(format!("the start time {start} s is not finite.")));
        }
        if let Some(stop) = stop
            && (stop.is_nan() || stop < start)
        {
            return Err(Refused::error(format!(
                "the stop time {stop} s is not after the start time {start} s."
            )));
        }
        self.window = (start, stop.unwrap_or(f64::INFINITY));
        Ok(())
    }

    /// Instantiated -> initialization.
    pub fn enter_initialization(&mut self) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        self.unsettled = true;
        let ((start, stop), tolerance) = (self.window, self.tolerance * DEFAULT_TOLERANCE);
        let text =
            || format!("start time {start} s, stop time {stop} s, relative tolerance {tolerance:.1e}.");
        self.log.note(Category::Events, text);
        self.go(Mode::Initialization);
        Ok(())
    }

    /// Initialization -> step.
    pub fn exit_initialization(&mut self) -> Outcome {
        self.require(&[Mode::Initialization])?;
        self.settle()?;
        let mode = match self.interface {
            Interface::CoSimulation if self.part.event_mode => Mode::Event,
            Interface::CoSimulation => Mode::Step,
            Interface::ModelExchange => {
                let counted = counted(self.model.as_mut());
                if counted > self.elements {
                    return Err(Refused::error(format!(
                        "this archive has {} segments of the housing as states, but {counted} are requested; \
                         in Co-Simulation there may be more of them than are shown.",
                        self.elements
                    )));
                }
                Mode::Event
            }
        };
        self.hold();
        self.go(mode);
        self.observe();
        Ok(())
    }

    /// Instantiated -> configuration.
    pub fn enter_configuration(&mut self) -> Outcome {
        self.require(&[Mode::Instantiated])?;
        let declaration = self.model.declaration();
        if declaration.dimensions.is_empty() {
            return Err(Refused::error(format!("{} has no structural parameter.", declaration.name)));
        }
        self.go(Mode::Configuration);
        Ok(())
    }

    /// Configuration -> instantiated, with the new array sizes.
    pub fn exit_configuration(&mut self) -> Outcome {
        self.require(&[Mode::Configuration])?;
        self.count();
        self.go(Mode::Instantiated);
        Ok(())
    }

    /// In FMI 3 the structural parameter determines the array size; in FMI 2 the list of variables is fixed.
    fn count(&mut self) {
        if self.standard == Standard::Three {
            self.elements = counted(self.model.as_mut());
        }
    }

    /// Running -> terminated.
    pub fn terminate(&mut self) -> Outcome {
        self.require(&[Mode::Step, Mode::Event, Mode::Continuous])?;
        self.go(Mode::Terminated);
        Ok(())
    }

    /// Any -> instantiated, with start values, time and integrator reset.
    pub fn reset(&mut self) -> Outcome {
        if self.mode == Mode::Intermediate {
            return self.require(&[]);
        }
        self.model = crate::new_model(self.kind, &self.resources)
            .ok_or_else(|| Refused::error("the model no longer accepts its resources."))?;
        if self.interface == Interface::ModelExchange {
            self.model.enter_model_exchange();
        }
        self.count();
        self.window = (0.0, f64::INFINITY);
        self.tolerance = 1.0;
        self.last_step = 0.0;
        self.unsettled = true;
        self.log_transition("reset");
        self.go(Mode::Instantiated);
        self.ended = None;
        self.saturation.reset();
        Ok(())
    }

    /// In initialization mode, initializes the model again with the values that were set.
    #[inline]
    fn settle(&mut self) -> Outcome {
        if self.mode == Mode::Initialization && self.unsettled {
            self.model.start(self.window.0).map_err(|fault| Refused::error(fault.0))?;
            self.model.scale_tolerances(self.tolerance);
            self.unsettled = false;
        }
        Ok(())
    }

    /// Computes a step of `h` seconds from the communication point `at`, s.
    #[inline]
    pub fn step(&mut self, at: f64, h: f64) -> Outcome {
        self.require_step(at, h)?;
        let before = if self.log.is_on() { self.model.rejected_steps() } else { 0 };
        self.advance(at, h)?;
        self.saturation.sloped = false;
        if self.log.is_on() {
            self.report_step(at, h, before);
        }
        Ok(())
    }

    #[inline]
    fn advance(&mut self, at: f64, h: f64) -> Outcome {
        if self.saturation.sloped { self.advance_to_limits(at, h) } else { self.take_step(at, h) }
    }

    #[inline]
    fn take_step(&mut self, at: f64, h: f64) -> Outcome {
        match self.model.step(at, h) {
            Ok(()) => {
                self.last_step = h;
                Ok(())
            }
            Err(fault) => Err(self.halted(fault)),
        }
    }

    /// The error of a step that failed or ended early.
    #[cold]
    fn halted(&mut self, fault: Fault) -> Refused {
        self.ended = self.model.ended().then(|| c_string(&fault.0));
        Refused::discard(fault.0)
    }

    /// Reason for the end of the run; `None` while it continues.
    pub fn end(&self) -> Option<&CStr> {
        self.ended.as_deref()
    }

    /// Whether the run is over: after a Co-Simulation step, or at the states that the importer has set.
    pub fn is_over(&mut self) -> bool {
        if self.interface == Interface::ModelExchange {
            let sentence = self.model.termination_reason();
            if let (Some(sentence), None) = (&sentence, &self.ended) {
                self.log.note(Category::Warning, || sentence.clone());
            }
            self.ended = sentence.map(|s| c_string(&s));
        }
        self.ended.is_some()
    }

    /// Result of a step in FMI 3: the end of a run is a flag, not an error status; its reason is logged.
    pub fn unless_over(&mut self, outcome: Outcome) -> Outcome {
        match outcome {
            Err(refused) if self.ended.is_some() => {
                self.log.note(Category::Warning, || refused.message);
                Ok(())
            }
            outcome => outcome,
        }
    }

    /// Whether early return is allowed.
    pub fn may_return_early(&self) -> bool {
        self.part.early_return
    }

    #[inline]
    fn require_step(&self, at: f64, h: f64) -> Outcome {
        let now = self.model.time();
        // A deviation up to a thousandth of a step is rounding error of the importer's time; a larger one is an error.
        let rounding = (1e-3 * h).max(8.0 * f64::EPSILON * now.abs());
        let fits = (at - now).abs() <= rounding && at + h <= self.window.1 + rounding;
        if self.mode == Mode::Step && h > 0.0 && h.is_finite() && fits {
            return Ok(());
        }
        Err(self.no_step(at, h, rounding))
    }

    /// Why a step cannot be computed.
    #[cold]
    fn no_step(&self, at: f64, h: f64, rounding: f64) -> Refused {
        let now = self.model.time();
        if self.mode != Mode::Step {
            self.not_now()
        } else if !(h > 0.0 && h.is_finite()) {
            Refused::error(format!("the communication step size {h} s is not positive and finite."))
        } else if at.is_nan() || (at - now).abs() > rounding {
            Refused::error(format!(
                "the communication point {at} s differs from the time of the instance, {now} s."
            ))
        } else {
            Refused::error(format!(
                "the step from {at} s by {h} s exceeds the stop time {} s.",
                self.window.1
            ))
        }
    }

    /// Rejects a status function of FMI 2.0 outside a Co-Simulation run.
    pub fn require_stepping(&self) -> Outcome {
        self.require_interface(Interface::CoSimulation)?;
        self.require(&[Mode::Step, Mode::Terminated])
    }

    /// Present time, s.
    pub fn time(&self) -> f64 {
        self.model.time()
    }

    /// Whether the importer is in its intermediate update callback.
    pub fn is_in_intermediate_update(&self) -> bool {
        self.mode == Mode::Intermediate
    }

    /// Rejects a call of the other interface type.
    pub fn require_interface(&self, interface: Interface) -> Outcome {
        if self.interface == interface {
            return Ok(());
        }
        Err(Refused::error(format!(
            "this is a function of {} and the instance is one of {}.",
            interface.words(),
            self.interface.words()
        )))
    }

    /// Rejects a call that is allowed in event mode only.
    pub fn require_event(&self) -> Outcome {
        self.require(&[Mode::Event])
    }
}

/// Array size from the structural parameter; 0 if the model has no arrays.
fn counted(model: &mut dyn Model) -> u32 {
    let declaration = model.declaration();
    // Integers within their limits are exact as f64.
    declaration.dimensions.first().map_or(0, |&k| model.get(declaration.entries[k].slot) as u32)
}
