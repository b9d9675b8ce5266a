//! The FMU under test, and the run that others are compared with.

use std::cell::OnceCell;
use std::rc::Rc;

use cosim::raw::{InterfaceType, RawBinary, RawInstance, RawSetup};
use cosim::{Archive, Kind, Log, Status};

use super::facts::Facts;
use super::held::{Held, Pool};
use super::report::Fault;
use super::runs::{Rows, from_here, same};
use super::session::{Session, Settings, words};
use crate::validate::rules;
use cosim::Interface;

/// What all stages share: the FMU and its declarations.
pub(super) struct Subject<'a> {
    pub(super) archive: &'a Archive,
    pub(super) facts: &'a Facts,
    pub(super) interface: &'a Interface,
    pub(super) binary: RawBinary,
    /// The archive's name of the library.
    pub(super) place: String,
    pub(super) base: BaseCell<'a>,
    /// The only instance of this process, while nobody uses it.
    pub(super) pool: Pool,
}

impl<'a> Subject<'a> {
    /// The base run, with which other runs are compared.
    pub(super) fn base(&self) -> Result<&Base<'a>, Fault> {
        if self.base.get().is_none() {
            let _ = self.base.set(Base::new(self)?);
        }
        Ok(self.base.get().expect("it has just been set"))
    }

    /// A new instance, or `None` if the FMU refuses.
    pub(super) fn try_instance(&self, name: &str, token: &str, log: &Log) -> Option<RawInstance> {
        // The only instance of a process is used again.
        if let Some(mut raw) = self.pool.take()
            && raw.reset() <= Status::Warning
        {
            return Some(raw);
        }
        let event_mode = self.event_mode();
        let setup = RawSetup { interface: self.interface.kind, token, name, event_mode, intermediate: &[] };
        self.binary.instantiate(&setup, log)
    }

    pub(super) fn instance(&self, name: &str) -> Result<Session<'a>, Fault> {
        let log = Log::new();
        match self.try_instance(name, &self.facts.token, &log) {
            Some(raw) => Ok(self.session(raw)),
            None => Fault::new(&self.place, rules::refused_instance(self.interface.kind, words(&log))),
        }
    }

    /// A new instance of FMI 3 Co-Simulation with event mode.
    pub(super) fn with_event_mode(&self) -> Result<Session<'a>, Fault> {
        let token = &self.facts.token;
        let interface = InterfaceType::CoSimulation;
        let setup = RawSetup { interface, token, name: "probe", event_mode: true, intermediate: &[] };
        match self.binary.instantiate(&setup, &Log::new()) {
            Some(raw) => Ok(Session { event_mode: true, ..self.session(raw) }),
            None => Fault::new(&self.interface.place(), rules::refused_with_event_mode()),
        }
    }

    /// Whether the FMU has clocks and so must use event mode in Co-Simulation.
    fn event_mode(&self) -> bool {
        let has_clocks = || self.facts.variables.iter().any(|v| v.kind == Kind::Clock);
        self.interface.kind == InterfaceType::CoSimulation && self.interface.has_event_mode && has_clocks()
    }

    /// The session of a new instance.
    pub(super) fn session(&self, raw: RawInstance) -> Session<'a> {
        let Subject { facts, interface, .. } = *self;
        let event_mode = self.event_mode();
        let pool = interface.only_once_per_process.then(|| Rc::clone(&self.pool));
        let raw = Held::new(raw, pool);
        Session { raw, facts, interface, event_mode, now: facts.start, next: None }
    }

    /// A new instance with these settings, initialised and ready to step.
    pub(super) fn started(&self, settings: &Settings) -> Result<Session<'a>, Fault> {
        let mut session = self.instance("probe")?;
        session.start(settings)?;
        Ok(session)
    }
}

/// A fresh instance's run.
pub(super) fn fresh(subject: &Subject, settings: &Settings) -> Result<Rows, Fault> {
    let mut session = subject.started(settings)?;
    from_here(&mut session)
}

/// The base run: inputs away from their start values if the FMU takes that, so that something
/// happens.
pub(super) struct Base<'a> {
    pub(super) settings: Settings<'a>,
    pub(super) rows: Rows,
    /// For each column whether a second instance reproduces it.
    pub(super) steady: Vec<bool>,
}

/// Made once for a subject.
pub(super) type BaseCell<'a> = OnceCell<Base<'a>>;

impl<'a> Base<'a> {
    /// Two runs, and two more without inputs if those fail.
    pub(super) fn new(subject: &Subject<'a>) -> Result<Base<'a>, Fault> {
        let moved: Settings =
            subject.facts.inputs().into_iter().map(|v| (v, vec![v.other_value(); v.size])).collect();
        if !moved.is_empty()
            && let Ok(base) = Self::with(subject, moved)
            && base.rows.iter().flatten().all(|x| x.is_finite())
        {
            return Ok(base);
        }
        Self::with(subject, Vec::new())
    }

    fn with(subject: &Subject<'a>, settings: Settings<'a>) -> Result<Base<'a>, Fault> {
        let rows = fresh(subject, &settings)?;
        let again = fresh(subject, &settings)?;
        let mut steady = vec![true; rows.first().map_or(0, Vec::len)];
        for (a, b) in rows.iter().zip(&again) {
            for (is_steady, (x, y)) in steady.iter_mut().zip(a.iter().zip(b)) {
                *is_steady &= same(*x, *y);
            }
        }
        Ok(Base { settings, rows, steady })
    }
}
