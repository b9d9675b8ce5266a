//! Heat capacities of the nodes.

use nalgebra::SVector;

/// Heat capacities of the nodes, winding and housing first, with their reciprocals.
#[derive(Clone, Copy, Debug)]
pub struct HeatCapacities<const N: usize> {
    /// J/K.
    pub values: SVector<f64, N>,
    /// K/J.
    pub inverse: SVector<f64, N>,
}

impl<const N: usize> HeatCapacities<N> {
    /// These heat capacities, J/K.
    pub fn new(values: SVector<f64, N>) -> Self {
        HeatCapacities { values, inverse: values.map(|c| 1.0 / c) }
    }

    /// The same with those of winding and housing multiplied by `factor`.
    pub fn scaled(mut self, factor: f64) -> Self {
        for node in 0..2 {
            self.values[node] *= factor;
            self.inverse[node] /= factor;
        }
        self
    }

    /// Heat stored above the temperature `origin`, K, in J.
    pub fn heat(&self, temperature: &SVector<f64, N>, origin: f64) -> f64 {
        self.values.dot(&temperature.add_scalar(-origin))
    }
}
