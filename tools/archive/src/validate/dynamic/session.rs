//! A running instance. Each failed call is a fault with function, time and the FMU's messages.

use cosim::raw::{Experiment, InterfaceType, RawInstance};
use cosim::{Kind, Log, Status};

use super::facts::{Facts, Variable, observed};
use super::held::Held;
use super::report::Fault;
use crate::validate::finding::short;
use crate::validate::rules;
use cosim::Interface;
use cosim::xml::shortened;

/// Limit of event iterations.
const MOST_ITERATIONS: usize = 1000;

/// Values that differ from the start values.
pub(super) type Settings<'a> = Vec<(&'a Variable, Vec<f64>)>;

/// Length up to which a message of the FMU is repeated, in characters.
const LONGEST_MESSAGE: usize = 300;

/// The last messages of the FMU, without the name of the function that many FMUs put first.
pub(super) fn words(log: &Log) -> String {
    let messages = log.messages();
    let texts = messages.iter().rev().take(2).map(|m| {
        let text = m.text.trim();
        text.split_once(": ")
            .filter(|(call, _)| call.starts_with("fmi") && !call.contains(' '))
            .map_or(text, |(_, rest)| rest)
    });
    let text = texts.collect::<Vec<_>>().join("; ");
    if text.is_empty() {
        text
    } else {
        format!(": {}", shortened(text.trim_end_matches('.'), LONGEST_MESSAGE))
    }
}

pub(super) struct Session<'a> {
    pub(super) raw: Held,
    pub(super) facts: &'a Facts,
    pub(super) interface: &'a Interface,
    /// FMI 3 Co-Simulation: event mode is used.
    pub(super) event_mode: bool,
    /// The time reached, s.
    pub(super) now: f64,
    /// The next time event, s.
    pub(super) next: Option<f64>,
}

impl<'a> Session<'a> {
    /// A fault unless the status is OK or Warning; `function` is without the prefix of its standard.
    pub(super) fn ok(&self, function: &str, status: Status) -> Result<(), Fault> {
        if status <= Status::Warning {
            return Ok(());
        }
        let (function, words) = (self.facts.function(function), words(self.raw.log()));
        Fault::new(
            &self.interface.place(),
            rules::call_failed(function, status, self.interface.kind, self.now, words),
        )
    }

    /// Calls one function of the FMU; [`Session::ok`] judges its status.
    pub(super) fn call(
        &mut self,
        function: &str,
        call: impl FnOnce(&mut RawInstance) -> Status,
    ) -> Result<(), Fault> {
        let status = call(&mut self.raw);
        self.ok(function, status)
    }

    /// From instantiated (or reset) to ready to step.
    pub(super) fn start(&mut self, settings: &Settings) -> Result<(), Fault> {
        self.setup(None)?;
        self.initialise(None, settings)
    }

    /// From instantiated (or reset) to where parameters are set.
    pub(super) fn setup(&mut self, stop: Option<f64>) -> Result<(), Fault> {
        self.now = self.facts.start;
        let experiment = self.experiment(stop);
        self.call("SetupExperiment", |raw| raw.setup_experiment(&experiment))
    }

    /// Sets parameters and start values, then, in initialisation mode, inputs; through event mode where that follows.
    pub(super) fn initialise(&mut self, stop: Option<f64>, settings: &Settings) -> Result<(), Fault> {
        self.set_some(settings, false)?;
        self.enter(stop)?;
        self.set_some(settings, true)?;
        self.leave()
    }

    /// Sets the inputs, or all other variables.
    pub(super) fn set_some(&mut self, settings: &Settings, inputs: bool) -> Result<(), Fault> {
        let some = settings.iter().filter(|(v, _)| v.is("input") == inputs);
        some.into_iter().try_for_each(|(variable, values)| self.set(variable, values))
    }

    /// Enters initialisation mode.
    pub(super) fn enter(&mut self, stop: Option<f64>) -> Result<(), Fault> {
        let experiment = self.experiment(stop);
        self.call("EnterInitializationMode", |raw| raw.enter_initialization_mode(&experiment))
    }

    /// Leaves initialisation mode, and the event mode that follows it.
    pub(super) fn leave(&mut self) -> Result<(), Fault> {
        self.call("ExitInitializationMode", |raw| raw.exit_initialization())?;
        if self.interface.kind == InterfaceType::ModelExchange {
            self.iterate_events()?;
            self.call("EnterContinuousTimeMode", |raw| raw.enter_continuous_time_mode())?;
        } else if self.event_mode {
            self.iterate_events()?;
            self.call("EnterStepMode", |raw| raw.enter_step_mode())?;
        }
        Ok(())
    }

    fn experiment(&self, stop: Option<f64>) -> Experiment {
        Experiment { start: self.facts.start, stop, tolerance: self.facts.tolerance }
    }

    /// The event iteration, in event mode; whether states have changed.
    pub(super) fn iterate_events(&mut self) -> Result<bool, Fault> {
        let mut changed = false;
        for _ in 0..MOST_ITERATIONS {
            let (status, update) = self.raw.update_discrete_states();
            self.ok(self.facts.pick("NewDiscreteStates", "UpdateDiscreteStates"), status)?;
            changed |= update.values_changed;
            self.next = update.next;
            if let Some(next) = update.next.filter(|t| t.is_nan() || *t < self.now) {
                return Fault::new(&self.interface.place(), rules::time_event_in_the_past(next, self.now));
            }
            if !update.again || update.terminate {
                return Ok(changed);
            }
        }
        Fault::new(&self.interface.place(), rules::event_iteration_diverges(self.now, MOST_ITERATIONS))
    }

    /// One communication step of Co-Simulation; `false` if the FMU requests the end.
    pub(super) fn step(&mut self, h: f64) -> Result<bool, Fault> {
        let step = self.raw.do_step(self.now, h, false);
        self.ok("DoStep", step.status)?;
        if step.early {
            return Fault::new(&self.interface.place(), rules::early_return(self.now));
        }
        self.now += h;
        if step.event && self.event_mode && !step.terminated {
            self.call("EnterEventMode", |raw| raw.enter_event_mode())?;
            self.iterate_events()?;
            self.call("EnterStepMode", |raw| raw.enter_step_mode())?;
        }
        Ok(!step.terminated)
    }

    /// Sets all elements of a variable.
    pub(super) fn set(&mut self, variable: &Variable, values: &[f64]) -> Result<(), Fault> {
        self.call("Set", |raw| raw.set(variable.kind, &[variable.reference], values))
            .map_err(|f| f.about(variable, values))
    }

    /// Reads all elements of a variable.
    pub(super) fn get(&mut self, variable: &Variable) -> Result<Vec<f64>, Fault> {
        let mut values = vec![0.0; variable.size];
        self.call("Get", |raw| raw.get(variable.kind, &[variable.reference], &mut values))
            .map_err(|f| f.about(variable, &[]))?;
        Ok(values)
    }

    /// Reads a string, or binary data in hexadecimal digits.
    pub(super) fn text(&mut self, variable: &Variable) -> Result<String, Fault> {
        let references = &[variable.reference];
        let read = match variable.kind {
            Kind::Binary => self
                .raw
                .get_binaries(references)
                .map(|all| all.concat().iter().map(|byte| format!("{byte:02x}")).collect()),
            _ => self.raw.get_strings(references).map(|all| all.concat()),
        };
        read.or_else(|status| self.ok("Get", status).map(|()| String::new()))
            .map_err(|f| f.about(variable, &[]))
    }

    /// Reads scalar floating point variables in one call.
    pub(super) fn get_all(&mut self, variables: &[&Variable]) -> Result<Vec<f64>, Fault> {
        let references: Vec<u32> = variables.iter().map(|v| v.reference).collect();
        let mut values = vec![0.0; references.len()];
        if !references.is_empty() {
            self.call("Get", |raw| raw.get(Kind::Float64, &references, &mut values))?;
        }
        Ok(values)
    }

    /// Everything that has a number, in the order of [`observed`].
    pub(super) fn observe(&mut self) -> Result<Vec<f64>, Fault> {
        let facts = self.facts;
        let mut row = vec![0.0; facts.groups.iter().map(|g| g.places.len()).sum()];
        for group in &facts.groups {
            let mut values = vec![0.0; group.places.len()];
            if self.raw.get(group.kind, &group.references, &mut values) > Status::Warning {
                // One by one, so that the fault names the variable.
                let of_kind = facts.variables.iter().filter(|v| observed(v) && v.kind == group.kind);
                values = of_kind.map(|v| self.get(v)).collect::<Result<Vec<_>, _>>()?.concat();
            }
            group.places.iter().zip(values).for_each(|(place, value)| row[*place] = value);
        }
        Ok(row)
    }
}

/// The name of a column of [`Session::observe`], and the variable.
pub(super) fn column(facts: &Facts, mut index: usize) -> (String, &Variable) {
    for v in facts.variables.iter().filter(|v| observed(v)) {
        if index < v.size {
            let name = if v.size > 1 { format!("{}[{}]", v.name, index + 1) } else { v.name.clone() };
            return (short(&name), v);
        }
        index -= v.size;
    }
    unreachable!("a column belongs to a variable")
}
