//! The functions of [`Model`] for the FMI layer and the tools.

use super::{BALANCE, Equations, INDICATORS, INPUTS, OUTPUTS, PARAMETERS, Runtime, Saved};
use crate::groups::Grouped;
use crate::load_table::LoadTable;
use crate::model::{Declaration, Fault, HousingHeat, Model, Slot};
use crate::terms::{Drivers, GenericTerm};
use declare::Group;
use std::any::Any;

impl<M: Equations<N>, const N: usize> Runtime<M, N> {
    /// Groups of variables that are set, not computed, as in a saved state.
    fn set_groups() -> impl Iterator<Item = (usize, usize)> {
        let groups = M::declaration().groups.iter().enumerate();
        groups
            .filter(|&(g, _)| g == INPUTS || g >= PARAMETERS)
            .flat_map(|(g, group)| (0..group.table.len()).map(move |row| (g, row)))
    }

    /// The model with restored numbers; `None` if they are no valid saved state.
    fn restored(&self, saved: &[f64]) -> Option<Self> {
        let mut copy = self.clone();
        let mut rest = saved.iter().copied();
        let mut next = || rest.next();
        for (group, row) in Self::set_groups() {
            let value = next()?;
            let taken = match group {
                INPUTS => copy.inputs.set(row, value),
                _ => copy.parameters.set_value(group - PARAMETERS, row, value),
            };
            taken.then_some(())?;
        }
        let mut slopes = copy.slopes;
        slopes.take_values(&mut next)?;
        copy.put_slopes(slopes);
        copy.time.load(&mut next)?;
        copy.pre.load(&mut next)?;
        copy.own.load(&mut next)?;
        M::restored(&mut copy, &mut next)?;
        copy.follow_modes();
        copy.outdate();
        next().is_none().then_some(copy)
    }
}

impl<M: Equations<N>, const N: usize> Model for Runtime<M, N> {
    fn declaration(&self) -> &'static Declaration {
        M::declaration()
    }

    #[inline]
    fn get(&mut self, slot: Slot) -> f64 {
        let row = slot.row as usize;
        match slot.group as usize {
            INPUTS => self.inputs.get(row),
            OUTPUTS => {
                if !self.has_outputs {
                    if let Some(value) = M::output(self, row) {
                        return value;
                    }
                    (self.outputs, self.has_outputs) = (self.look(M::outputs), true);
                }
                self.outputs.get(row)
            }
            BALANCE => {
                if !self.has_balance {
                    if let Some(value) = M::flow(self, row) {
                        return value;
                    }
                    (self.balance, self.has_balance) = (self.look(M::balance), true);
                }
                self.balance.get(row)
            }
            INDICATORS => {
                self.indicators = self.look(M::indicators);
                self.indicators.get(row)
            }
            _ if slot.group == Slot::STATES => self.shown_state(row),
            _ if slot.group == Slot::RATES => self.all_rates().map_or(f64::NAN, |all| all[row]),
            group => self.parameters.value(group - PARAMETERS, row),
        }
    }

    #[inline]
    fn set(&mut self, slot: Slot, value: f64) -> bool {
        let (group, row) = (slot.group as usize, slot.row as usize);
        let taken = match group {
            INPUTS => self.inputs.set(row, value),
            OUTPUTS | BALANCE | INDICATORS => return false,
            _ => {
                let set = |p: &mut M::Parameters| p.set_value(group - PARAMETERS, row, value);
                let taken = M::set_parameter(self, set);
                self.follow_modes();
                taken
            }
        };
        M::follow_inputs(self);
        self.outdate();
        taken
    }

    fn set_all(&mut self, values: &[(Slot, f64)]) -> bool {
        let of = |is_parameter: bool| {
            values.iter().filter(move |(slot, _)| (slot.group as usize >= PARAMETERS) == is_parameter)
        };
        let taken = of(false).fold(true, |taken, (slot, value)| self.set(*slot, *value) && taken);
        let taken = M::set_parameter(self, |parameters| {
            of(true).fold(taken, |taken, (slot, value)| {
                parameters.set_value(slot.group as usize - PARAMETERS, slot.row as usize, *value) && taken
            })
        });
        self.follow_modes();
        M::follow_inputs(self);
        self.outdate();
        taken
    }

    fn set_slope(&mut self, slot: Slot, slope: f64) {
        debug_assert_eq!(slot.group as usize, INPUTS);
        self.slopes.set(slot.row as usize, slope);
        self.is_sloping |= slope != 0.0;
        self.has_outputs = false;
        self.has_balance = false;
    }

    fn slope(&self, slot: Slot) -> f64 {
        self.slopes.get(slot.row as usize)
    }

    fn refusal(&self, term: &GenericTerm) -> Option<&'static str> {
        M::refusal(term)
    }

    fn set_terms(&mut self, terms: &[GenericTerm]) -> bool {
        let taken = terms.iter().all(|term| M::refusal(term).is_none()) && M::set_terms(self, terms);
        self.follow_modes();
        self.outdate();
        taken
    }

    fn set_load(&mut self, table: &LoadTable) -> bool {
        self.outdate();
        M::set_load(self, table)
    }

    fn start(&mut self, time: f64) -> Result<(), Fault> {
        let before = std::mem::replace(&mut self.time, time);
        M::start(self).inspect_err(|_| self.time = before)?;
        self.follow_modes();
        self.outdate();
        self.hold_start();
        Ok(())
    }

    fn start_with(&mut self, values: &[(Slot, f64)], time: f64) -> Result<(), Fault> {
        for (slot, value) in values {
            match (slot.group as usize).checked_sub(PARAMETERS) {
                Some(group) => self.parameters.set_value(group, slot.row as usize, *value),
                None => self.set(*slot, *value),
            };
        }
        self.start(time)
    }

    #[inline]
    fn step(&mut self, time: f64, h: f64) -> Result<(), Fault> {
        self.step_to_limit(time, h)
    }

    fn ended(&self) -> bool {
        self.ended
    }

    fn passed_limit(&self) -> Option<String> {
        self.ended.then(|| M::passed_limit(self))
    }

    fn time(&self) -> f64 {
        self.time
    }

    fn states(&self, out: &mut Vec<f64>) {
        out.extend(self.followed.iter().map(|k| M::state(self, k)));
    }

    fn set_states(&mut self, time: f64, states: &[f64]) -> bool {
        let fits = states.len() == self.followed.count();
        if fits {
            for (k, value) in self.followed.iter().zip(states) {
                M::put_state(self, k, *value);
            }
            self.time = time;
            M::follow_states(self);
            self.outdate();
        }
        fits
    }

    fn rates(&mut self, out: &mut Vec<f64>) {
        // Outputs share most of the evaluation and are usually read next.
        let all;
        (all, self.outputs) = self.look(M::coupled_rates_and_outputs);
        self.has_outputs = true;
        out.extend(self.followed.iter().map(|k| all[k]));
    }

    fn ease(&mut self, factors: [f64; 2]) {
        M::ease(self, factors);
    }

    fn scale_tolerances(&mut self, factor: f64) {
        M::scale_tolerances(self, factor);
    }

    fn rejected_steps(&self) -> u64 {
        M::rejected_steps(self)
    }

    fn housing_heat(&mut self) -> Option<HousingHeat> {
        M::housing_heat(self)
    }

    fn drivers(&self) -> Drivers {
        M::drivers(self)
    }

    fn save(&self, out: &mut Vec<f64>) {
        out.extend(Self::set_groups().map(|(group, row)| match group {
            INPUTS => self.inputs.get(row),
            _ => self.parameters.value(group - PARAMETERS, row),
        }));
        out.extend(self.slopes.values());
        self.time.save(out);
        self.pre.save(out);
        self.own.save(out);
        self.own.save_rest(out);
    }

    fn restore(&mut self, saved: &[f64]) -> bool {
        let restored = self.restored(saved);
        let complete = restored.is_some();
        if let Some(restored) = restored {
            *self = restored;
        }
        complete
    }

    fn boxed_clone(&self) -> Box<dyn Model> {
        Box::new(self.clone())
    }

    fn copy_from(&mut self, other: &dyn Model) -> bool {
        let other = other.as_any().downcast_ref::<Self>();
        if let Some(other) = other {
            self.clone_from(other);
        }
        other.is_some()
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}
