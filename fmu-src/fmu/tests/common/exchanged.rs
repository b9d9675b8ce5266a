//! An importer that integrates, in a few lines.

use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;
use physics::model::{Declaration, ModelType};
use std::ffi::CString;
use std::ptr::null;

/// States of a model as its archive shows them.
pub fn count(kind: &ModelType) -> usize {
    match kind.name() {
        "AnnulusCooledMotor" => 22,
        "BrushedGearmotor" => 11,
        "SeriesElasticActuator" => 8,
        "GaitLoad" => 2,
        other => panic!("how many states has {other}?"),
    }
}

/// Something of a model in every role: an input, an output, a tunable parameter, a state.
pub struct Some {
    pub input: &'static str,
    pub output: &'static str,
    pub parameter: &'static str,
    pub state: &'static str,
}

/// Something of a model.
pub fn some(kind: &ModelType) -> Some {
    match kind.name() {
        "SeriesElasticActuator" => Some {
            input: "torque_demand",
            output: "joint_torque",
            parameter: "spring.damping",
            state: "state.demand",
        },
        "GaitLoad" => Some {
            input: "joint_torque",
            output: "tracking_error",
            parameter: "gait.support",
            state: "state.stride",
        },
        _ => Some {
            input: "load_torque",
            output: "shaft_torque",
            parameter: "effect.viscous_friction.k",
            state: "state.shaft_angle",
        },
    }
}

pub trait Named {
    fn name(&self) -> &'static str;
    fn declared(&self) -> &'static Declaration;
}

impl Named for ModelType {
    fn name(&self) -> &'static str {
        self.declared().name
    }
    fn declared(&self) -> &'static Declaration {
        (self.declaration)()
    }
}

/// An FMI 2 instance for Model Exchange.
pub struct Exchanged {
    pub c: Component,
    pub kind: &'static ModelType,
}

impl Exchanged {
    pub fn instantiated(kind: &'static ModelType) -> Exchanged {
        let token = CString::new(kind.declared().token.clone()).unwrap();
        let c = unsafe { fmi2Instantiate(c"me".as_ptr(), 0, token.as_ptr(), null(), null(), 0, 0) };
        assert!(!c.is_null());
        Exchanged { c, kind }
    }

    /// In event mode, with these start values.
    pub fn at_event(kind: &'static ModelType, start: &[(&str, f64)]) -> Exchanged {
        let me = Exchanged::instantiated(kind);
        for (name, value) in start {
            assert_eq!(me.set(name, *value), Status::Ok, "{name}");
        }
        unsafe {
            assert_eq!(fmi2SetupExperiment(me.c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(me.c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(me.c), Status::Ok);
        }
        me
    }

    pub fn continuous(kind: &'static ModelType, start: &[(&str, f64)]) -> Exchanged {
        let me = Exchanged::at_event(kind, start);
        me.update();
        assert_eq!(unsafe { fmi2EnterContinuousTimeMode(me.c) }, Status::Ok);
        me
    }

    pub fn update(&self) -> EventInfo {
        let mut info = EventInfo {
            new_discrete_states_needed: 9,
            terminate_simulation: 9,
            nominals_changed: 9,
            values_changed: 9,
            next_event_time_defined: 9,
            next_event_time: f64::NAN,
        };
        assert_eq!(unsafe { fmi2NewDiscreteStates(self.c, &mut info) }, Status::Ok);
        assert_eq!(
            (info.new_discrete_states_needed, info.terminate_simulation, info.nominals_changed),
            (0, 0, 0)
        );
        info
    }

    pub fn reference(&self, name: &str) -> u32 {
        self.kind.declared().by_name(name).unwrap_or_else(|| panic!("no {name}")).value_reference
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        let whole = self.kind.declared().by_name(name).unwrap().row.kind != physics::declare::Kind::Real;
        let reference = self.reference(name);
        unsafe {
            if whole {
                fmi2SetInteger(self.c, &reference, 1, &(value as i32))
            } else {
                fmi2SetReal(self.c, &reference, 1, &value)
            }
        }
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(
            unsafe { fmi2GetReal(self.c, &self.reference(name), 1, &mut value) },
            Status::Ok,
            "{name}"
        );
        value
    }

    pub fn states(&self) -> Vec<f64> {
        let mut x = vec![f64::NAN; count(self.kind)];
        assert_eq!(unsafe { fmi2GetContinuousStates(self.c, x.as_mut_ptr(), x.len()) }, Status::Ok);
        x
    }

    pub fn put(&self, time: f64, x: &[f64]) {
        unsafe {
            assert_eq!(fmi2SetTime(self.c, time), Status::Ok);
            assert_eq!(fmi2SetContinuousStates(self.c, x.as_ptr(), x.len()), Status::Ok);
        }
    }

    pub fn rates(&self) -> Vec<f64> {
        let mut rates = vec![f64::NAN; count(self.kind)];
        assert_eq!(unsafe { fmi2GetDerivatives(self.c, rates.as_mut_ptr(), rates.len()) }, Status::Ok);
        rates
    }

    pub fn indicators(&self) -> Vec<f64> {
        let mut z = vec![f64::NAN; self.kind.declared().indicators.len()];
        assert_eq!(unsafe { fmi2GetEventIndicators(self.c, z.as_mut_ptr(), z.len()) }, Status::Ok);
        z
    }

    /// Everything that can be read, bit for bit.
    pub fn all(&self) -> Vec<u64> {
        let mut all = [self.states(), self.rates(), self.indicators()].concat();
        let outputs = self.kind.declared().entries.iter().filter(|e| {
            e.row.causality == physics::declare::Causality::Output
                && e.row.kind == physics::declare::Kind::Real
        });
        all.extend(outputs.map(|e| self.get(&e.name)));
        all.iter().map(|value| value.to_bits()).collect()
    }
}

impl Drop for Exchanged {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.c) }
    }
}
