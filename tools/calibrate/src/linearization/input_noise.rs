//! Noise that an input passes on to the outputs of a model, compared with the first model that is evaluated.
//!
//! sigma_y^2 = sigma_s^2 + J^2 sigma_u^2                                                                (1)
//!
//! sigma_s is the noise of a sensor, sigma_u that of an input, J the change of the output within a row by the input's reading. A voltage of
//! 15 mV noise at 0.4 ohm moves the current of the model by 40 mA. A model with an addition that makes J smaller (a resistance that
//! grows where the current is near 0) leaves a smaller residual, and explains nothing: both variables have errors. With J of the own model
//! in (1) the sum of squares in units of sigma_y does not fall.
//! *Source*: Orear, Am. J. Phys. 50 (1982) 912-916 (effective variance).

use crate::fit::Slopes;
use crate::levels::NEGLIGIBLE;
use crate::setup::Setup;
use std::sync::Arc;

/// Ratio of sigma_y of the first model to that of this one for each block of these runs; 1 where this one passes on more. The probes of the
/// inputs are among the last `further` ones, after `before_inputs` others.
pub(super) fn weights(
    setup: &Setup,
    runs: &[usize],
    slopes: &Slopes,
    further: usize,
    before_inputs: usize,
) -> Vec<f64> {
    let (m, inputs) = (setup.outputs(), setup.experiment.inputs.len());
    let mut weights = Vec::new();
    for (r, run) in runs.iter().enumerate() {
        let probes = &slopes.further(r, further)[before_inputs..before_inputs + inputs];
        let heard = probes.iter().zip(&setup.noise).filter_map(|(d, sigma)| Some((d.as_ref()?, *sigma)));
        let own = Arc::new(slopes.tangents[r].direct_variance(&heard.collect::<Vec<_>>()));
        let first = setup.first.direct_variance(*run, &own);
        weights.extend(setup.blocks[*run].iter().map(|block| {
            let fall =
                |row: &u32| first[*row as usize * m + block.output] - own[*row as usize * m + block.output];
            let mean = block.rows.iter().map(fall).sum::<f64>() / block.rows.len() as f64;
            let left: f64 = 1.0 - mean / setup.sigma(block.output).powi(2);
            left.clamp(NEGLIGIBLE * NEGLIGIBLE, 1.0).sqrt().recip()
        }));
    }
    weights
}
