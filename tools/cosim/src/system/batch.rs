//! Variables that are read or set in one call.
use super::units::Affine;
use crate::{Error, Instance, Kind, Variable};

/// Variables of one component and kind that are read or set in one call.
#[derive(Debug)]
pub(crate) struct Batch {
    /// 0 for a single FMU.
    pub(crate) component: usize,
    pub(crate) kind: Kind,
    pub(crate) vrs: Vec<u32>,
    /// Where each value belongs: among the connected outputs or inputs, or a column of a table or recording.
    pub(crate) slots: Vec<usize>,
    pub(crate) values: Vec<f64>,
}

impl Batch {
    /// The batch of a component and kind, which is made if it is not there.
    pub(crate) fn of(batches: &mut Vec<Self>, component: usize, kind: Kind) -> &mut Self {
        let same = batches.iter().position(|b| b.component == component && b.kind == kind);
        let index = same.unwrap_or_else(|| {
            batches.push(Self { component, kind, vrs: Vec::new(), slots: Vec::new(), values: Vec::new() });
            batches.len() - 1
        });
        &mut batches[index]
    }

    /// Adds a value of the variable that was added last; an array has several.
    pub(crate) fn push(&mut self, slot: usize) {
        self.slots.push(slot);
        self.values.push(0.0);
    }

    /// Adds a variable to the batch of its component and kind.
    pub(crate) fn add(batches: &mut Vec<Self>, component: usize, variable: &Variable, slot: usize) {
        let batch = Self::of(batches, component, variable.kind);
        batch.vrs.push(variable.value_reference);
        batch.push(slot);
    }

    /// Reads the variables into `outputs`.
    pub(crate) fn read(&mut self, instances: &mut [Instance], outputs: &mut [f64]) -> Result<(), Error> {
        instances[self.component].get_number(self.kind, &self.vrs, &mut self.values)?;
        for (value, slot) in self.values.iter().zip(&self.slots) {
            outputs[*slot] = *value;
        }
        Ok(())
    }

    /// Sets the variables from `inputs`.
    pub(crate) fn set(&mut self, instances: &mut [Instance], inputs: &[f64]) -> Result<(), Error> {
        self.take(inputs);
        instances[self.component].set_number(self.kind, &self.vrs, &self.values)
    }

    /// Brings `inputs` up to date from `outputs`, by each input's source and conversion, and sets the variables.
    pub(crate) fn pass(
        &mut self,
        instances: &mut [Instance],
        sources: &[(usize, Affine)],
        outputs: &[f64],
        inputs: &mut [f64],
    ) -> Result<(), Error> {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            let (source, convert) = sources[*slot];
            *value = convert.of(outputs[source]);
            inputs[*slot] = *value;
        }
        instances[self.component].set_number(self.kind, &self.vrs, &self.values)
    }

    /// Sets the derivatives of the variables.
    pub(crate) fn set_derivatives(
        &mut self,
        instances: &mut [Instance],
        derivatives: &[f64],
    ) -> Result<(), Error> {
        self.take(derivatives);
        instances[self.component].set_input_derivatives(&self.vrs, &self.values)
    }

    fn take(&mut self, numbers: &[f64]) {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            *value = numbers[*slot];
        }
    }
}
