//! Everything that the motor's future depends on, as numbers.

use super::held::Held;
use super::motor::AnnulusCooledMotor;
use crate::components::commutation::Phases;
use crate::groups;
use crate::model::Model;
use crate::solver::split::{Split, State};
use declare::Group;

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

impl AnnulusCooledMotor {
    pub(super) fn push_saved(&self, out: &mut Vec<f64>) {
        groups::save(self, &self.declaration().groups, out);
        out.extend(self.slopes.values());
        out.extend([self.time, self.t_sensor, self.t_start, self.capacity_factor]);
        out.extend(self.term_lags);
        out.extend([self.stored_at_start, flag(self.outputs_are_stale), flag(self.books_are_stale)]);
        out.extend(self.state.to_numbers());
        out.extend(self.split.to_numbers());
        out.extend(self.phases.above);
        out.push(flag(self.held.is_some()));
        if let Some(held) = self.held {
            out.extend(held.to_numbers());
        }
        if let Some(network) = &self.network {
            out.extend(network.to_numbers());
        }
    }

    /// The motor of what [`push_saved`](Self::push_saved) gave; `None` where the numbers do not fit.
    pub(super) fn with_saved(&self, saved: &[f64]) -> Option<AnnulusCooledMotor> {
        let mut copy = self.clone();
        let mut rest = saved.iter().copied();
        let mut next = || rest.next();
        groups::restore(&mut copy, &self.declaration().groups, &mut next)?;
        copy.slopes.take_values(&mut next)?;
        copy.time = next()?;
        copy.t_sensor = next()?;
        copy.t_start = next()?;
        copy.capacity_factor = next()?;
        for reached in &mut copy.term_lags {
            *reached = next()?;
        }
        copy.stored_at_start = next()?;
        copy.outputs_are_stale = next()? != 0.0;
        copy.books_are_stale = next()? != 0.0;
        copy.state = State::from_numbers(&mut next)?;
        copy.split = Split::from_numbers(&mut next)?;
        copy.phases = Phases { above: [next()?, next()?, next()?] };
        copy.held = if next()? != 0.0 { Some(Held::from_numbers(&mut next)?) } else { None };
        copy.network = None;
        copy.follow_parameters();
        if let Some(network) = &mut copy.network {
            network.take_numbers(&copy.parameters, &mut next)?;
        }
        next().is_none().then_some(copy)
    }
}
