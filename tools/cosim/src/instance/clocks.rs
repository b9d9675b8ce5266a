//! FMI 3 Co-Simulation with event mode: input clocks of the importer tick, and time events are met.
use super::{Instance, Step};
use crate::raw::{RawInstance, names};
use crate::{Error, IntervalVariability, Status};

/// Limit of event iterations at one time.
const MOST_ITERATIONS: usize = 1000;

/// Only FMI 3 has these calls.
const UPDATE: super::Names = names::update_discrete_states;

/// A time-based input clock.
#[derive(Clone, Debug)]
pub(super) struct Clock {
    reference: u32,
    variability: IntervalVariability,
    /// Time from one tick to the next (s); not used by a countdown clock.
    interval: f64,
    /// Where the ticks are counted from (s), and the number of the next one.
    origin: f64,
    count: u64,
    /// Time of the next tick (s).
    next: Option<f64>,
}

/// Event mode of an instance.
#[derive(Clone, Debug, Default)]
pub(super) struct Events {
    /// Event mode is used.
    pub(super) used: bool,
    pub(super) clocks: Vec<Clock>,
    /// The next time event (s).
    pub(super) time_event: Option<f64>,
}

impl Events {
    /// The next time at which event mode is due.
    fn next(&self) -> f64 {
        let ticks = self.clocks.iter().filter_map(|c| c.next);
        ticks.chain(self.time_event).fold(f64::INFINITY, f64::min)
    }
}

impl Instance {
    /// The clocks at the end of initialization, in event mode; their first events are handled.
    pub(super) fn begin_events(&mut self) -> Result<Step, Error> {
        let start = self.start;
        for (reference, variability, interval) in self.declared_clocks.clone() {
            let mut clock =
                Clock { reference, variability, interval: 0.0, origin: start, count: 0, next: None };
            if variability != IntervalVariability::Countdown {
                clock.interval = match interval {
                    Some(interval) => interval,
                    None => self.interval_of(reference)?.unwrap_or(f64::INFINITY),
                };
                let mut shift = 0.0;
                if self.raw.functions().get_shift.is_some()
                    && self.raw.clock_shift(reference, &mut shift) <= Status::Warning
                    && shift.is_finite()
                {
                    clock.origin += shift;
                }
                self.check_interval(clock.interval)?;
                clock.next = Some(clock.origin);
            }
            self.events.clocks.push(clock);
        }
        self.handle_events(start, 0.0)
    }

    /// One communication step, cut at ticks and time events.
    pub(super) fn step_with_events(&mut self, t: f64, h: f64) -> Result<Step, Error> {
        let (end, slack) = (t + h, 1e-9 * h);
        let mut now = t;
        // An event may be due at once: a countdown of nothing.
        while now < end - slack {
            let target = self.events.next().clamp(now, end);
            let target = if target > end - slack { end } else { target };
            let mut wants_event = target <= now;
            if !wants_event {
                let length = if now == t && target == end { h } else { target - now };
                match self.plain_step(now, length)? {
                    (Step::Terminated, _) => return Ok(Step::Terminated),
                    (Step::Done, event) => wants_event = event,
                }
                now = target;
            }
            if wants_event || self.events.next() <= now + slack {
                self.call(names::enter_event, RawInstance::enter_event_mode)?;
                if self.handle_events(now, slack)? == Step::Terminated {
                    return Ok(Step::Terminated);
                }
            }
        }
        Ok(Step::Done)
    }

    /// In event mode at `t`: due clocks tick, discrete states are updated; then step mode.
    fn handle_events(&mut self, t: f64, slack: f64) -> Result<Step, Error> {
        for _ in 0..MOST_ITERATIONS {
            let is_due = |c: &&Clock| c.next.is_some_and(|next| next <= t + slack);
            let due: Vec<u32> = self.events.clocks.iter().filter(is_due).map(|c| c.reference).collect();
            if !due.is_empty() {
                self.call(["", names::set_clock[1]], |raw| raw.tick(&due))?;
            }
            let mut update = Default::default();
            self.call(UPDATE, |raw| {
                let (status, result) = raw.update_discrete_states();
                update = result;
                status
            })?;
            if update.terminate {
                return Ok(Step::Terminated);
            }
            self.events.time_event = update.next.filter(|next| *next > t);
            self.schedule(&due, t)?;
            let again = update.again || self.events.clocks.iter().any(|c| is_due(&c));
            if !again {
                self.call(names::enter_step_mode, RawInstance::enter_step_mode)?;
                return Ok(Step::Done);
            }
        }
        let reason = format!("the event iteration at t = {t} s does not end in {MOST_ITERATIONS} iterations");
        Err(self.misuse(UPDATE, reason))
    }

    /// The next ticks of the clocks that have ticked, and of countdown clocks.
    fn schedule(&mut self, ticked: &[u32], t: f64) -> Result<(), Error> {
        for index in 0..self.events.clocks.len() {
            let Clock { reference, variability, .. } = self.events.clocks[index];
            let has_ticked = ticked.contains(&reference);
            match variability {
                IntervalVariability::Countdown => {
                    let interval = self.interval_of(reference)?;
                    let clock = &mut self.events.clocks[index];
                    match interval {
                        Some(interval) => clock.next = Some(t + interval),
                        None if has_ticked => clock.next = None,
                        None => {}
                    }
                }
                IntervalVariability::Changing if has_ticked => {
                    let interval = self.interval_of(reference)?;
                    if let Some(interval) = interval {
                        self.check_interval(interval)?;
                        self.events.clocks[index].interval = interval;
                    }
                    let clock = &mut self.events.clocks[index];
                    clock.next = Some(t + clock.interval);
                }
                _ if has_ticked => {
                    let clock = &mut self.events.clocks[index];
                    clock.count += 1;
                    // A multiple, not a sum, which would drift.
                    clock.next = Some(clock.origin + clock.count as f64 * clock.interval);
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn interval_of(&mut self, clock: u32) -> Result<Option<f64>, Error> {
        let mut interval = None;
        self.call_optional(
            ["", names::get_interval[1]],
            |f| f.get_interval.is_some(),
            |raw| {
                let (status, read) = raw.clock_interval(clock);
                interval = read;
                status
            },
        )?;
        Ok(interval)
    }

    fn check_interval(&self, interval: f64) -> Result<(), Error> {
        if interval > 0.0 {
            return Ok(());
        }
        Err(self.misuse(
            ["", names::get_interval[1]],
            format!("a clock has the interval {interval} s, which must be positive"),
        ))
    }
}
