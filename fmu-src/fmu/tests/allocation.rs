//! A step allocates no memory: in every model, in every combination of its modes, in both standards and both interfaces.

use crate::counting::allocations;
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use physics::declare::{Causality, Elements, Kind, Variability};
use physics::model::{Declaration, Element, Entry, ModelType};
use std::ffi::{CString, c_int, c_void};
use std::ptr::{null, null_mut};

/// Steps of a run: some reversals of every input.
const STEPS: u32 = 60;
const STEP: f64 = 1e-3;

/// Standard and interface.
const KINDS: [(bool, bool); 4] = [(false, false), (false, true), (true, false), (true, true)];

/// An instance that is ready to step or to be integrated.
struct Running {
    handle: *mut c_void,
    three: bool,
    exchange: bool,
    inputs: Vec<&'static Entry>,
    outputs: Vec<u32>,
    states: Vec<f64>,
    values: Vec<f64>,
}

fn ok(status: Status) {
    assert_eq!(status, Status::Ok);
}

impl Running {
    fn new(kind: &ModelType, (three, exchange): (bool, bool), choices: &[(u32, i32)]) -> Running {
        let declaration: &'static Declaration = (kind.declaration)();
        let token = CString::new(declaration.token.clone()).unwrap();
        let handle = unsafe {
            match (three, exchange) {
                (false, _) => fmi2Instantiate(
                    c"a".as_ptr(),
                    c_int::from(!exchange),
                    token.as_ptr(),
                    null(),
                    null(),
                    0,
                    0,
                ),
                (true, true) => fmi3InstantiateModelExchange(
                    c"a".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    0,
                    null_mut(),
                    None,
                ),
                (true, false) => fmi3InstantiateCoSimulation(
                    c"a".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    0,
                    0,
                    0,
                    null(),
                    0,
                    null_mut(),
                    None,
                    None,
                ),
            }
        };
        assert!(!handle.is_null());
        let real = |role: Causality| {
            let wanted = move |e: &&'static Entry| e.row.causality == role && e.row.kind == Kind::Real;
            declaration.entries.iter().filter(wanted)
        };
        let moves = |e: &&'static Entry| e.row.variability == Variability::Continuous;
        let outputs: Vec<u32> = real(Causality::Output).map(|e| e.value_reference).collect();
        let running = Running {
            handle,
            three,
            exchange,
            inputs: real(Causality::Input).filter(moves).collect(),
            values: vec![0.0; outputs.len()],
            outputs,
            states: vec![0.0; states(declaration)],
        };
        unsafe {
            for (reference, value) in choices {
                ok(match three {
                    true => fmi3SetInt64(handle, reference, 1, &i64::from(*value), 1),
                    false => fmi2SetInteger(handle, reference, 1, value),
                });
            }
            if three {
                ok(fmi3EnterInitializationMode(handle, 0, 0.0, 0.0, 0, 0.0));
                ok(fmi3ExitInitializationMode(handle));
            } else {
                ok(fmi2SetupExperiment(handle, 0, 0.0, 0.0, 0, 0.0));
                ok(fmi2EnterInitializationMode(handle));
                ok(fmi2ExitInitializationMode(handle));
            }
        }
        if exchange {
            running.to_continuous_time();
        }
        running
    }

    fn to_continuous_time(&self) {
        let h = self.handle;
        unsafe {
            if self.three {
                let (mut a, mut b, mut c, mut d, mut e, mut t) = (0, 0, 0, 0, 0, 0.0);
                ok(fmi3UpdateDiscreteStates(h, &mut a, &mut b, &mut c, &mut d, &mut e, &mut t));
                ok(fmi3EnterContinuousTimeMode(h));
            } else {
                let mut info = EventInfo {
                    new_discrete_states_needed: 0,
                    terminate_simulation: 0,
                    nominals_changed: 0,
                    values_changed: 0,
                    next_event_time_defined: 0,
                    next_event_time: 0.0,
                };
                ok(fmi2NewDiscreteStates(h, &mut info));
                ok(fmi2EnterContinuousTimeMode(h));
            }
        }
    }

    /// Sets inputs, steps (or evaluates the equations, as an integrator does), reads outputs.
    fn run(&mut self, from: u32) {
        for k in from..from + STEPS {
            let t = f64::from(k) * STEP;
            for n in 0..self.inputs.len() {
                let row = &self.inputs[n].row;
                // Every input reverses, at a frequency of its own, around its start value.
                let wave = (f64::from(k) * (0.3 + 0.07 * n as f64)).sin();
                let value = (row.start + 0.5 * row.nominal * wave).clamp(row.min, row.max);
                let reference = self.inputs[n].value_reference;
                ok(unsafe {
                    match self.three {
                        true => fmi3SetFloat64(self.handle, &reference, 1, &value, 1),
                        false => fmi2SetReal(self.handle, &reference, 1, &value),
                    }
                });
            }
            match self.exchange {
                true => self.evaluate(t + STEP),
                false => self.step(t),
            }
            let (references, count) = (self.outputs.as_ptr(), self.outputs.len());
            let values = self.values.as_mut_ptr();
            ok(unsafe {
                match self.three {
                    true => fmi3GetFloat64(self.handle, references, count, values, count),
                    false => fmi2GetReal(self.handle, references, count, values),
                }
            });
        }
    }

    fn step(&self, t: f64) {
        let (mut a, mut b, mut c, mut last) = (0, 0, 0, 0.0);
        ok(unsafe {
            match self.three {
                true => fmi3DoStep(self.handle, t, STEP, 1, &mut a, &mut b, &mut c, &mut last),
                false => fmi2DoStep(self.handle, t, STEP, 1),
            }
        });
    }

    fn evaluate(&mut self, t: f64) {
        let (h, n, x) = (self.handle, self.states.len(), self.states.as_mut_ptr());
        let mut rates = [0.0; 128];
        let mut flags = (0u8, 0u8);
        let mut whole: (c_int, c_int) = (0, 0);
        unsafe {
            if self.three {
                ok(fmi3SetTime(h, t));
                ok(fmi3GetContinuousStates(h, x, n));
                ok(fmi3SetContinuousStates(h, x, n));
                ok(fmi3GetContinuousStateDerivatives(h, rates.as_mut_ptr(), n));
                ok(fmi3CompletedIntegratorStep(h, 1, &mut flags.0, &mut flags.1));
            } else {
                ok(fmi2SetTime(h, t));
                ok(fmi2GetContinuousStates(h, x, n));
                ok(fmi2SetContinuousStates(h, x, n));
                ok(fmi2GetDerivatives(h, rates.as_mut_ptr(), n));
                ok(fmi2CompletedIntegratorStep(h, 1, &mut whole.0, &mut whole.1));
            }
        }
        // Explicit Euler is enough to move every state.
        for (x, rate) in self.states.iter_mut().zip(rates) {
            *x += 1e-2 * STEP * rate;
        }
        ok(unsafe {
            match self.three {
                true => fmi3SetContinuousStates(h, self.states.as_ptr(), n),
                false => fmi2SetContinuousStates(h, self.states.as_ptr(), n),
            }
        });
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        unsafe { if self.three { fmi3FreeInstance(self.handle) } else { fmi2FreeInstance(self.handle) } }
    }
}

/// States of the model with the number of elements that it starts with.
fn states(declaration: &Declaration) -> usize {
    let shown = |[k, _]: &&[usize; 2]| match declaration.entries[*k].element {
        Some(Element { index, of: Elements::UpTo(_, parameter), .. }) => {
            f64::from(index) <= declaration.by_name(parameter).unwrap().row.start
        }
        _ => true,
    };
    declaration.states.iter().filter(shown).count()
}

/// Every combination of the choices of a model, effects' own apart.
fn combinations(declaration: &Declaration) -> Vec<Vec<(u32, i32)>> {
    let mut all = vec![Vec::new()];
    for entry in declaration.entries.iter().filter(|e| !e.name.starts_with("effect.") && e.is_settable()) {
        let Kind::Enumeration(of) = entry.row.kind else { continue };
        let with = |item: i32| {
            all.iter().map(move |one: &Vec<_>| [&one[..], &[(entry.value_reference, item)]].concat())
        };
        all = of.items.iter().flat_map(|item| with(item.value)).collect();
    }
    all
}

#[test]
fn a_step_allocates_nothing_in_any_mode() {
    assert!(allocations(|| drop(std::hint::black_box(Box::new(1)))) > 0, "the counter counts");
    let mut cases = 0;
    for kind in physics::models::ALL {
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
    for kind in physics::models::ALL {
        let mut running = Running::new(kind, (false, false), &[]);
        let mut state = null_mut();
        unsafe { ok(fmi2GetFMUstate(running.handle, &mut state)) };
        running.run(0);
        let count = allocations(|| unsafe { ok(fmi2GetFMUstate(running.handle, &mut state)) });
        assert_eq!(count, 0, "{}", (kind.declaration)().name);
        unsafe { ok(fmi2FreeFMUstate(running.handle, &mut state)) };
    }
}
