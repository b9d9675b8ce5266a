//! The readings that a start is estimated from.

use super::{PART, Warm};
use crate::experiment::{Experiment, Run};
use crate::overrides::Override;
use crate::simulate::Drive;
use physics::terms::Port;

/// Readings of an output in the rows of eq. (1).
#[derive(Clone, Debug)]
pub struct Column {
    /// The index of the output; `None` for a node without a sensor.
    pub output: Option<usize>,
    /// Factor on readings and responses: noise of a thermometer over the noise of the output, in K over its unit.
    weight: f64,
    /// The readings times the factor; NaN where there is none.
    pub readings: Vec<f64>,
}

impl Column {
    /// Of a node.
    fn of_node(warm: &Warm) -> Column {
        Column { output: warm.output, weight: 1.0, readings: warm.readings.clone() }
    }

    /// Of another output, by its index.
    fn of_output(experiment: &Experiment, run: &Run, output: usize, weight: f64) -> Column {
        let readings = &run.table.columns[experiment.place_of(output)];
        let readings = readings[..rows(readings)].iter().map(|reading| weight * reading).collect();
        Column { output: Some(output), weight, readings }
    }

    /// A value of the output as the readings are.
    pub fn of(&self, value: f64) -> f64 {
        self.weight * value
    }

    /// The part of a response, rows times outputs, that the readings are compared with.
    pub fn of_response(&self, outputs: usize, response: &[f64]) -> Vec<f64> {
        let rows = |output: usize| response.iter().skip(output).step_by(outputs).take(self.readings.len());
        self.output.map_or_else(Vec::new, |output| rows(output).map(|value| self.of(*value)).collect())
    }
}

/// Number of rows of (1) with these readings.
pub fn rows(column: &[f64]) -> usize {
    let read: Vec<usize> = (0..column.len()).filter(|row| column[*row].is_finite()).collect();
    (read.len() / PART).checked_sub(1).map_or(0, |last| read[last] + 1)
}

/// Sum of products over the rows of (1) that have a reading.
pub fn product(columns: &[Column], a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let of_column = |((column, a), b): ((&Column, &Vec<f64>), &Vec<f64>)| -> f64 {
        let rows = column.readings.iter().zip(a.iter().zip(b));
        rows.filter(|(reading, _)| reading.is_finite()).map(|(_, (a, b))| a * b).sum()
    };
    columns.iter().zip(a).zip(b).map(of_column).sum()
}

impl Drive {
    /// The columns of (1): those of the nodes, and all other outputs if a law of a lag acts on a voltage, a current or a torque, which may be all
    /// that it acts on. Otherwise their structure error would be taken for temperatures.
    pub fn columns(&self, change: &Override) -> Vec<Column> {
        let is_shown = |port: Port| port.is_fast() || port == Port::TorqueSensor;
        let is_theirs = change.lags().any(|(place, _)| is_shown(change.terms[place].port));
        let others = self.others.iter().filter(|_| is_theirs).cloned();
        self.warm.iter().map(Column::of_node).chain(others).collect()
    }

    /// With the outputs beside the nodes; `noise` are the standard deviations of the outputs.
    pub fn with_others(mut self, experiment: &Experiment, run: &Run, noise: &[f64]) -> Drive {
        let Some(of_node) = self.warm.iter().find_map(|warm| warm.output).map(|output| noise[output]) else {
            return self;
        };
        let others = experiment.outputs.iter().enumerate().filter(|(_, channel)| !channel.is_temperature());
        let weighed = others.map(|(output, _)| (output, of_node / noise[output]));
        let weighed = weighed.filter(|(_, weight)| weight.is_finite() && *weight > 0.0);
        self.others = weighed.map(|(k, weight)| Column::of_output(experiment, run, k, weight)).collect();
        self
    }
}
