//! A run under changing inputs, in every standard and interface type.

use super::{How, Importer, Options, Succeeds, reals, shortened};
use physics::declare::Causality;
use physics::model::{Entry, ModelType};
use std::hash::{DefaultHasher, Hasher};

/// Values that move a model of any kind.
pub fn busy(kind: &ModelType) -> Vec<(&'static str, f64)> {
    match (kind.declaration)().name {
        "AnnulusCooledMotor" => vec![
            ("voltage", 20.0),
            ("load_torque", 0.03),
            ("fan_command", 0.7),
            // Miri takes minutes for the operating point of the fan; tests/arrays.rs saves states of its network.
            ("cooling_mode", shortened(4, 1) as f64),
            ("commutation", 3.0),
            ("effect.housing_sensor_lag.tau", 7.0),
            ("effect.winding_sensor_lag.tau", 3.0),
            ("effect.coulomb_friction.tau_c", 0.01),
        ],
        "BrushedGearmotor" => vec![("duty", 0.6), ("load_torque", 0.2), ("effect.contact_drop.V_b", 0.3)],
        "SeriesElasticActuator" => vec![
            ("torque_demand", 20.0),
            ("motor_speed", 30.0),
            ("motor_current", 2.0),
            ("joint_speed", 0.2),
            ("transmission.coupling", 2.0),
        ],
        _ => vec![("joint_torque", 20.0), ("gait.variation", 0.03)],
    }
}

/// Steps of a run: some reversals of every input.
pub const STEPS: u32 = shortened(60, 1) as u32;
const STEP: f64 = 1e-3;

/// An instance that is ready to step or to be integrated.
pub struct Running {
    pub importer: Importer,
    inputs: Vec<&'static Entry>,
    outputs: Vec<u32>,
    values: Vec<f64>,
    states: Vec<f64>,
    rates: Vec<f64>,
    indicators: Vec<f64>,
}

impl Running {
    pub fn new(kind: &ModelType, how: How, start: &[(&str, f64)]) -> Running {
        Running::of(Importer::instantiated(kind, how, Options::default()).started(start))
    }

    /// An instance that has started.
    pub fn of(importer: Importer) -> Running {
        let declaration = importer.declaration;
        let outputs: Vec<u32> = reals(declaration, Causality::Output).map(|e| e.value_reference).collect();
        let states = vec![0.0; importer.number_of_states()];
        Running {
            inputs: reals(declaration, Causality::Input).filter(|e| e.is_continuous_input()).collect(),
            values: vec![0.0; outputs.len()],
            outputs,
            rates: states.clone(),
            indicators: vec![0.0; declaration.indicators.len()],
            states,
            importer,
        }
    }

    /// Sets inputs, steps (or evaluates the equations, as an integrator does), reads outputs. A hash of all that was read.
    pub fn run(&mut self, from: u32) -> u64 {
        let mut hasher = DefaultHasher::new();
        for k in from..from + STEPS {
            let t = f64::from(k) * STEP;
            for (n, input) in self.inputs.iter().enumerate() {
                // Every input reverses, at a frequency of its own, around its start value.
                let wave = (f64::from(k) * (0.3 + 0.07 * n as f64)).sin();
                let row = &input.row;
                let value = (row.start + 0.5 * row.nominal * wave).clamp(row.min, row.max);
                self.importer.set_reals(&[input.value_reference], &[value]).ok();
            }
            if self.importer.exchange {
                self.evaluate(t + STEP);
            } else {
                self.importer.step(t, STEP).ok();
            }
            self.importer.get_reals(&self.outputs, &mut self.values).ok();
            for value in self.values.iter().chain(&self.rates).chain(&self.indicators) {
                hasher.write_u64(value.to_bits());
            }
        }
        hasher.finish()
    }

    fn evaluate(&mut self, t: f64) {
        let fmu = *self.importer;
        fmu.set_time(t).ok();
        fmu.get_states(&mut self.states).ok();
        fmu.set_states(&self.states).ok();
        fmu.get_rates(&mut self.rates).ok();
        fmu.get_indicators(&mut self.indicators).ok();
        fmu.complete().0.ok();
        // Explicit Euler is enough to move every state.
        for (x, rate) in self.states.iter_mut().zip(&self.rates) {
            *x += 1e-2 * STEP * rate;
        }
        fmu.set_states(&self.states).ok();
    }
}
