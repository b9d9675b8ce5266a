//! Variables that are read or set in one call.
use super::units::Affine;
use crate::{Error, Instance, Kind, Variable};

/// The values of all connections, and the instances that they belong to.
pub(crate) struct Signals<'a> {
    pub(crate) instances: &'a mut [Instance],
    /// Connected outputs, ...
    pub(crate) outputs: &'a mut [f64],
    /// ... those of integers without rounding, ...
    pub(crate) integers: &'a mut [i128],
    /// ... and connected inputs, in the units of the inputs.
    pub(crate) inputs: &'a mut [f64],
    /// For each input its source and conversion.
    pub(crate) sources: &'a [(usize, Affine)],
}

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
    /// The values of integers.
    integers: Vec<i128>,
}

impl Batch {
    /// The batch of a component and kind, which is made if it is not there.
    pub(crate) fn of(batches: &mut Vec<Self>, component: usize, kind: Kind) -> &mut Self {
        let same = batches.iter().position(|b| b.component == component && b.kind == kind);
        let index = same.unwrap_or_else(|| {
            let (vrs, slots, values, integers) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            batches.push(Self { component, kind, vrs, slots, values, integers });
            batches.len() - 1
        });
        &mut batches[index]
    }

    /// Adds a value of the variable that was added last; an array has several.
    pub(crate) fn push(&mut self, slot: usize) {
        self.slots.push(slot);
        self.values.push(0.0);
        self.integers.push(0);
    }

    /// Adds a variable to the batch of its component and kind.
    pub(crate) fn add(batches: &mut Vec<Self>, component: usize, variable: &Variable, slot: usize) {
        let batch = Self::of(batches, component, variable.kind);
        batch.vrs.push(variable.value_reference);
        batch.push(slot);
    }

    /// Whether values go without rounding; enumerations are small.
    fn is_integer(&self) -> bool {
        self.kind.is_integer() && self.kind != Kind::Enumeration
    }

    /// Reads the variables into the outputs.
    pub(crate) fn read(&mut self, signals: &mut Signals) -> Result<(), Error> {
        let instance = &mut signals.instances[self.component];
        if self.is_integer() {
            instance.get_integers(self.kind, &self.vrs, &mut self.integers)?;
            for ((value, integer), slot) in self.values.iter_mut().zip(&self.integers).zip(&self.slots) {
                *value = *integer as f64;
                signals.integers[*slot] = *integer;
            }
        } else {
            instance.get_number(self.kind, &self.vrs, &mut self.values)?;
        }
        for (value, slot) in self.values.iter().zip(&self.slots) {
            signals.outputs[*slot] = *value;
        }
        Ok(())
    }

    /// Sets the variables from the inputs; integers from their sources.
    pub(crate) fn set(&mut self, signals: &mut Signals) -> Result<(), Error> {
        self.take(signals.inputs);
        self.enter_model_exchange(signals)
    }

    fn enter_model_exchange(&mut self, signals: &mut Signals) -> Result<(), Error> {
        let instance = &mut signals.instances[self.component];
        if !self.is_integer() {
            return instance.set_number(self.kind, &self.vrs, &self.values);
        }
        for (integer, slot) in self.integers.iter_mut().zip(&self.slots) {
            *integer = signals.integers[signals.sources[*slot].0];
        }
        instance.set_integers(self.kind, &self.vrs, &self.integers)
    }

    /// Brings the inputs up to date from the outputs, by each input's source and conversion, and sets the variables.
    pub(crate) fn pass(&mut self, signals: &mut Signals) -> Result<(), Error> {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            let (source, convert) = signals.sources[*slot];
            *value = convert.of(signals.outputs[source]);
            signals.inputs[*slot] = *value;
        }
        self.enter_model_exchange(signals)
    }

    /// Sets the variables, reals, to where they are `after` seconds (s) from the inputs on, with their derivatives.
    pub(crate) fn set_line(
        &mut self,
        signals: &mut Signals,
        derivatives: &[f64],
        after: f64,
    ) -> Result<(), Error> {
        for (value, slot) in self.values.iter_mut().zip(&self.slots) {
            *value = signals.inputs[*slot] + after * derivatives[*slot];
        }
        signals.instances[self.component].set_number(self.kind, &self.vrs, &self.values)?;
        self.set_derivatives(signals.instances, derivatives)
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
