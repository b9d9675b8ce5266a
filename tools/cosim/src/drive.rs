//! Sets the inputs of an input table: of one FMU, or of the components of a system.
use crate::input::InputColumn;
use crate::integrator::Inputs;
use crate::system::Batch;
use crate::{Error, InputTable, Instance};
use std::slice::from_mut;

/// Feeds an input table to instances.
pub(crate) struct Drive<'a> {
    table: &'a InputTable,
    groups: Vec<Batch>,
    /// The continuous reals of components that take input derivatives.
    slopes: Vec<Batch>,
    slack: f64,
}

impl<'a> Drive<'a> {
    /// `takes_slope` says whether a column takes input derivatives.
    pub(crate) fn new(table: &'a InputTable, takes_slope: &dyn Fn(&InputColumn) -> bool, slack: f64) -> Self {
        let (mut groups, mut slopes) = (Vec::new(), Vec::new());
        for (index, column) in table.columns().iter().enumerate() {
            let add = |groups: &mut Vec<Batch>| {
                let group = Batch::of(groups, column.component, column.kind);
                group.vrs.push(column.value_reference);
                group.push(index);
            };
            add(&mut groups);
            if takes_slope(column) {
                add(&mut slopes);
            }
        }
        Self { table, groups, slopes, slack }
    }

    /// Sets all inputs at a communication point.
    pub(crate) fn set_values(&mut self, instances: &mut [Instance], t: f64) -> Result<(), Error> {
        (0..self.groups.len()).try_for_each(|place| self.set_group(instances, place, t, false))
    }

    /// The next row of the table after `t`.
    pub(crate) fn next_row(&self, t: f64) -> Option<f64> {
        self.table.next_row(t)
    }

    fn set_group(
        &mut self,
        instances: &mut [Instance],
        place: usize,
        t: f64,
        before: bool,
    ) -> Result<(), Error> {
        let group = &mut self.groups[place];
        for (value, column) in group.values.iter_mut().zip(&group.slots) {
            *value = if before {
                self.table.before(*column, t, self.slack)
            } else {
                self.table.after(*column, t, self.slack)
            };
        }
        instances[group.component].set_number(group.kind, &group.vrs, &group.values)
    }

    /// Sets the inputs of one component for a step of its own, with their derivatives.
    pub(crate) fn set_component(
        &mut self,
        instances: &mut [Instance],
        component: usize,
        t: f64,
        h: f64,
    ) -> Result<(), Error> {
        for place in 0..self.groups.len() {
            if self.groups[place].component == component {
                self.set_group(instances, place, t, false)?;
            }
        }
        for place in 0..self.slopes.len() {
            if self.slopes[place].component == component {
                self.set_slope(instances, place, t, h)?;
            }
        }
        Ok(())
    }

    /// The mean derivatives over the step: the inputs meet the table at both ends of the step.
    pub(crate) fn set_slopes(&mut self, instances: &mut [Instance], t: f64, h: f64) -> Result<(), Error> {
        (0..self.slopes.len()).try_for_each(|place| self.set_slope(instances, place, t, h))
    }

    fn set_slope(&mut self, instances: &mut [Instance], place: usize, t: f64, h: f64) -> Result<(), Error> {
        let group = &mut self.slopes[place];
        for (slope, column) in group.values.iter_mut().zip(&group.slots) {
            let (from, to) =
                (self.table.after(*column, t, self.slack), self.table.before(*column, t + h, self.slack));
            *slope = (to - from) / h;
        }
        instances[group.component].set_input_derivatives(&group.vrs, &group.values)
    }
}

impl Inputs for Drive<'_> {
    fn set_continuous(&mut self, instance: &mut Instance, from: f64, t: f64) -> Result<(), Error> {
        for place in 0..self.groups.len() {
            // Kinds are the same for all of a group; floats that are not continuous are few and constant here.
            if self.groups[place].kind.is_float() {
                self.set_group(from_mut(instance), place, t, t > from)?;
            }
        }
        Ok(())
    }

    fn set_all(&mut self, instance: &mut Instance, t: f64) -> Result<(), Error> {
        self.set_values(from_mut(instance), t)
    }

    fn next_break(&self, t: f64) -> Option<f64> {
        self.next_row(t)
    }

    fn jumps(&self, t: f64) -> bool {
        self.table.jumps(t, self.slack)
    }
}
