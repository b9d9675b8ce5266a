//! A mix of loads with rest: in each period of the mix the phases follow each other, each for its fraction of the period.

use super::cycle::{Pace, follow};
use super::envelope::Envelope;
use super::periodic::Periodic;
use super::walker::{Walker, period};
use crate::StudyError;

/// A load and the part of the period that it takes.
#[derive(Clone)]
struct Phase {
    walker: Walker,
    fraction: f64,
    pace: Pace,
}

/// The phases of a mix, which share the temperatures of one motor.
#[derive(Clone)]
pub struct Mix {
    phases: Vec<Phase>,
    period: f64,
    temperatures: Vec<f64>,
}

period!(
    Mix,
    fn own_envelope(
        &mut self,
        duration: f64,
        limit: f64,
        done: &(dyn Fn(f64) + Sync),
    ) -> Option<Result<Envelope, StudyError>> {
        Some(self.envelope(duration, limit, done))
    },
    // The phases settle by themselves.
    fn settling(&self) -> u32 {
        0
    }
);

impl Mix {
    pub(super) fn start(walkers: Vec<(f64, Walker)>, period: f64) -> Result<Mix, StudyError> {
        let phases: Vec<Phase> = walkers
            .into_iter()
            .map(|(fraction, walker)| Phase { walker, fraction, pace: Pace::default() })
            .collect();
        let Some(first) = phases.first() else { return Err(StudyError::new("a mix has at least one phase")) };
        let temperatures = first.walker.temperatures();
        for phase in &phases {
            let (least, stride) = (phase.fraction * period, phase.walker.stride_time());
            if stride > least * (1.0 + 1e-9) {
                return Err(StudyError::new(format!(
                    "a phase of the mix takes {least:.3} s of the period of {period} s, less than one cycle of its load, {stride:.3} s"
                )));
            }
        }
        Ok(Mix { phases, period, temperatures })
    }

    pub(super) fn stride_time(&self) -> f64 {
        self.period
    }

    pub(super) fn temperatures(&self) -> Vec<f64> {
        self.temperatures.clone()
    }

    pub(super) fn put_temperatures(&mut self, temperatures: &[f64]) {
        self.temperatures = temperatures.to_vec();
    }

    pub(super) fn stride(&mut self) -> Result<Periodic, StudyError> {
        self.phases(|_, _| Ok(()))
    }

    pub(super) fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
        let n = self.temperatures.len();
        let mut slopes = vec![vec![0.0; n]; n];
        let stride = self.phases(|walker, fraction| {
            let (_, of_phase) = walker.clone().stride_with_slopes()?;
            for (row, other) in slopes.iter_mut().zip(of_phase) {
                row.iter_mut().zip(other).for_each(|(slope, other)| *slope += fraction * other);
            }
            Ok(())
        })?;
        Ok((stride, slopes))
    }

    fn phases(
        &mut self,
        mut look: impl FnMut(&Walker, f64) -> Result<(), StudyError>,
    ) -> Result<Periodic, StudyError> {
        let mut whole = Periodic { winding_temperature: f64::NEG_INFINITY, ..Periodic::default() };
        let mut known = true;
        for phase in &mut self.phases {
            phase.walker.put_temperatures(&self.temperatures);
            let found = follow(
                &mut phase.walker,
                phase.fraction * self.period,
                f64::INFINITY,
                &mut phase.pace,
                &|_| (),
            )?;
            whole.add(&found.mean, phase.fraction);
            known &= found.mean.voltage_peak.is_some();
            look(&phase.walker, phase.fraction)?;
            self.temperatures = phase.walker.temperatures();
        }
        // A peak of some phases alone is none of the mix.
        whole.voltage_peak = whole.voltage_peak.filter(|_| known);
        Ok(whole.finished())
    }

    /// The winding for `duration`, or until it reaches `limit`.
    pub(super) fn envelope(
        &mut self,
        duration: f64,
        limit: f64,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Envelope, StudyError> {
        let mut found = Envelope::default();
        let mut time = 0.0;
        while time < duration {
            for phase in &mut self.phases {
                done(time / duration);
                phase.walker.put_temperatures(&self.temperatures);
                let part =
                    follow(&mut phase.walker, phase.fraction * self.period, limit, &mut phase.pace, &|_| ())?;
                self.temperatures = phase.walker.temperatures();
                found.append(part, time);
                if found.time_to_limit.is_some() {
                    return Ok(found);
                }
                time += phase.fraction * self.period;
                if time >= duration {
                    break;
                }
            }
        }
        Ok(found)
    }
}
