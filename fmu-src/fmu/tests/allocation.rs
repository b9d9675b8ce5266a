//! A step allocates no memory: in every model, in every combination of its modes, in both standards and both interfaces.

use crate::common::{CS2, How, Importer, KINDS, MODELS, Options, Succeeds, reals};
use crate::counting::allocations;
use physics::declare::{Causality, Kind};
use physics::model::{Declaration, Entry, ModelType};

/// Steps of a run: some reversals of every input.
const STEPS: u32 = 60;
const STEP: f64 = 1e-3;

/// An instance that is ready to step or to be integrated.
struct Running {
    importer: Importer,
    exchange: bool,
    inputs: Vec<&'static Entry>,
    outputs: Vec<u32>,
    values: Vec<f64>,
    states: Vec<f64>,
    rates: Vec<f64>,
}

impl Running {
    fn new(kind: &ModelType, how: How, choices: &[(&str, f64)]) -> Running {
        let importer = Importer::instantiated(kind, how, Options::default()).started(choices);
        let declaration = importer.declaration;
        let outputs: Vec<u32> = reals(declaration, Causality::Output).map(|e| e.value_reference).collect();
        let states = vec![0.0; importer.number_of_states()];
        Running {
            importer,
            exchange: how.1,
            inputs: reals(declaration, Causality::Input).filter(|e| e.is_continuous_input()).collect(),
            values: vec![0.0; outputs.len()],
            outputs,
            rates: states.clone(),
            states,
        }
    }

    /// Sets inputs, steps (or evaluates the equations, as an integrator does), reads outputs.
    fn run(&mut self, from: u32) {
        for k in from..from + STEPS {
            let t = f64::from(k) * STEP;
            for (n, input) in self.inputs.iter().enumerate() {
                // Every input reverses, at a frequency of its own, around its start value.
                let wave = (f64::from(k) * (0.3 + 0.07 * n as f64)).sin();
                let row = &input.row;
                let value = (row.start + 0.5 * row.nominal * wave).clamp(row.min, row.max);
                self.importer.set_reals(&[input.value_reference], &[value]).ok();
            }
            if self.exchange {
                self.evaluate(t + STEP);
            } else {
                self.importer.step(t, STEP).ok();
            }
            self.importer.get_reals(&self.outputs, &mut self.values).ok();
        }
    }

    fn evaluate(&mut self, t: f64) {
        let fmu = *self.importer;
        fmu.set_time(t).ok();
        fmu.get_states(&mut self.states).ok();
        fmu.set_states(&self.states).ok();
        fmu.get_rates(&mut self.rates).ok();
        fmu.complete().0.ok();
        // Explicit Euler is enough to move every state.
        for (x, rate) in self.states.iter_mut().zip(&self.rates) {
            *x += 1e-2 * STEP * rate;
        }
        fmu.set_states(&self.states).ok();
    }
}

/// Every combination of the choices of a model, effects' own apart.
fn combinations(declaration: &Declaration) -> Vec<Vec<(&str, f64)>> {
    let mut all = vec![Vec::new()];
    for entry in declaration.entries.iter().filter(|e| !e.name.starts_with("effect.") && e.is_settable()) {
        let Kind::Enumeration(of) = entry.row.kind else { continue };
        let with = |item: i32| {
            let choice = (entry.name.as_str(), f64::from(item));
            all.iter().map(move |one: &Vec<_>| [&one[..], &[choice]].concat())
        };
        all = of.items.iter().flat_map(|item| with(item.value)).collect();
    }
    all
}

#[test]
fn a_step_allocates_nothing_in_any_mode() {
    assert!(allocations(|| drop(std::hint::black_box(Box::new(1)))) > 0, "the counter counts");
    let mut cases = 0;
    for kind in MODELS {
        let declaration = (kind.declaration)();
        for choices in combinations(declaration) {
            for how in KINDS {
                let mut running = Running::new(kind, how, &choices);
                // The first steps make what an instance keeps.
                running.run(0);
                let count = allocations(|| running.run(STEPS));
                assert_eq!(
                    count, 0,
                    "{} {choices:?}, FMI 3: {}, Model Exchange: {}",
                    declaration.name, how.0, how.1
                );
                cases += 1;
            }
        }
    }
    // 4 drive modes x 2 couplings x 5 modes of cooling of the annulus motor alone make 160.
    assert!(cases > 500, "{cases}");
}

/// A state that is saved again takes the place of the old one.
#[test]
fn saving_a_state_again_allocates_nothing() {
    for kind in MODELS {
        let mut running = Running::new(kind, CS2, &[]);
        let mut saved = running.importer.save();
        running.run(0);
        let count = allocations(|| running.importer.get_state(&mut saved.state).ok());
        assert_eq!(count, 0, "{}", (kind.declaration)().name);
    }
}
