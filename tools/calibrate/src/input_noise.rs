//! Propagation of input noise to the outputs of a model, and inputs whose noise causes autocorrelated output noise.

use crate::CalibrateError;
use crate::fit::{Fitted, Slopes};
use crate::hypothesis::Hypothesis;
use crate::levels::NEGLIGIBLE;
use crate::setup::Setup;
use crate::tangent::Probe;
use std::sync::Arc;

impl Setup<'_> {
    /// Adds the noise that inputs cause within a row to the noise of each output, finds the inputs whose noise is autocorrelated at an
    /// output, and stores the drivers along the runs.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn include_input_noise(&mut self, fitted: &Fitted, runs: &[usize]) -> Result<(), CalibrateError> {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        let slopes = self.input_sensitivities(&fitted.hypothesis, runs)?;
        let slow = |input: &usize| {
            let (direct, whole) = self.variances(&slopes, |k| k == *input);
            (0..m).any(|k| whole[k] - direct[k] > (NEGLIGIBLE * self.sigma(k)).powi(2))
        };
        let remembered = (0..inputs).filter(slow).collect();
        let (direct, _) = self.variances(&slopes, |_| true);
        self.remembered = remembered;
        self.reached = Arc::new(slopes.tangents.into_iter().flat_map(|t| t.drivers).collect());
        for (own, direct) in self.noise[inputs..].iter_mut().zip(direct) {
            *own = (*own * *own + direct).sqrt();
        }
        Ok(())
    }

    /// Mean variance of each output due to white input noise over linearised runs
    /// ([`input_sensitivities`](Setup::input_sensitivities)): within a row, and in total.
    pub fn input_noise(&self, slopes: &Slopes) -> (Vec<f64>, Vec<f64>) {
        self.variances(slopes, |_| true)
    }

    /// A hypothesis linearised along runs, with the sensitivity to each input.
    ///
    /// # Errors
    /// The model's error if it cannot be simulated.
    pub fn input_sensitivities(
        &self,
        hypothesis: &Hypothesis,
        runs: &[usize],
    ) -> Result<Slopes, CalibrateError> {
        let probes: Vec<Probe> = (0..self.experiment.inputs.len()).map(Probe::Input).collect();
        Slopes::new(self, hypothesis, runs, &probes)
    }

    /// These variances for the inputs that `heard` selects.
    fn variances(&self, slopes: &Slopes, heard: impl Fn(usize) -> bool) -> (Vec<f64>, Vec<f64>) {
        let (m, inputs) = (self.outputs(), self.experiment.inputs.len());
        let (mut direct, mut whole, mut rows) = (vec![0.0; m], vec![0.0; m], 0.0);
        for (r, tangent) in slopes.tangents.iter().enumerate() {
            let known = slopes.further(r, inputs).iter().zip(&self.noise).enumerate();
            let noises: Vec<_> = known
                .filter(|(k, _)| heard(*k))
                .filter_map(|(_, (d, sigma))| Some((d.as_ref()?, *sigma)))
                .collect();
            let (at_once, all) = tangent.variance(&noises);
            for (k, (a, b)) in at_once.iter().zip(&all).enumerate() {
                direct[k % m] += a;
                whole[k % m] += b;
            }
            rows += (at_once.len() / m) as f64;
        }
        let mean = |sums: Vec<f64>| sums.into_iter().map(|s| s / rows).collect();
        (mean(direct), mean(whole))
    }
}
