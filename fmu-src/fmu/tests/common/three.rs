//! An importer of FMI 3 Co-Simulation that may take part in steps, in a few lines.

use super::{token, vr};
use motor_fmu::fmi3::*;
use motor_fmu::instance::IntermediateUpdate;
use motor_fmu::logger::Status;
use std::ffi::c_void;
use std::ptr::{null, null_mut};

/// How a step ended: event, early, time reached.
pub type Ended = (bool, bool, f64);

/// An FMI 3 instance.
pub struct Three(pub *mut c_void);

impl Three {
    /// An instance with event mode, early return and these intermediate variables.
    pub fn with(events: bool, early: bool, look: Option<(IntermediateUpdate, *mut c_void, &[u32])>) -> Three {
        let (callback, environment, references) = match look {
            Some((callback, environment, references)) => (Some(callback), environment, references),
            None => (None, null_mut(), &[][..]),
        };
        Three(unsafe {
            fmi3InstantiateCoSimulation(
                c"three".as_ptr(),
                token().as_ptr(),
                null(),
                0,
                0,
                u8::from(events),
                u8::from(early),
                references.as_ptr(),
                references.len(),
                environment,
                None,
                callback,
            )
        })
    }

    /// One for Model Exchange.
    pub fn exchanged() -> Three {
        Three(unsafe {
            fmi3InstantiateModelExchange(c"three".as_ptr(), token().as_ptr(), null(), 0, 0, null_mut(), None)
        })
    }

    /// With these start values, ready to step or at the first event.
    pub fn started(self, start: &[(&str, f64)]) -> Three {
        for (name, value) in start {
            assert_eq!(self.set(name, *value), Status::Ok, "{name}");
        }
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.0, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi3ExitInitializationMode(self.0), Status::Ok);
        }
        self
    }

    /// Sets the number of segments in configuration mode.
    pub fn segments(self, count: u64) -> Three {
        unsafe {
            assert_eq!(fmi3EnterConfigurationMode(self.0), Status::Ok);
            assert_eq!(fmi3SetUInt64(self.0, &vr("air_segments"), 1, &count, 1), Status::Ok);
            assert_eq!(fmi3ExitConfigurationMode(self.0), Status::Ok);
        }
        self
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        unsafe {
            match name.ends_with("_mode") {
                true => fmi3SetInt64(self.0, &vr(name), 1, &(value as i64), 1),
                false => fmi3SetFloat64(self.0, &vr(name), 1, &value, 1),
            }
        }
    }

    pub fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        assert_eq!(unsafe { fmi3GetFloat64(self.0, &vr(name), 1, &mut value, 1) }, Status::Ok, "{name}");
        value
    }

    pub fn is_hot(&self) -> bool {
        let mut flag = 9;
        assert_eq!(unsafe { fmi3GetBoolean(self.0, &vr("over_temperature"), 1, &mut flag, 1) }, Status::Ok);
        flag == 1
    }

    /// The temperatures of the housing's segments.
    pub fn housing(&self, count: usize) -> Vec<f64> {
        let mut all = vec![f64::NAN; count];
        assert_eq!(
            unsafe { fmi3GetFloat64(self.0, &vr("T_housing[1]"), 1, all.as_mut_ptr(), count) },
            Status::Ok
        );
        all
    }

    pub fn step(&self, at: f64, h: f64) -> Ended {
        let (mut event, mut terminate, mut early, mut last) = (9, 9, 9, f64::NAN);
        let status =
            unsafe { fmi3DoStep(self.0, at, h, 1, &mut event, &mut terminate, &mut early, &mut last) };
        assert_eq!((status, terminate), (Status::Ok, 0));
        (event == 1, early == 1, last)
    }

    /// Handles an event; the time of the next, where it is known.
    pub fn handle_event(&self) -> Option<f64> {
        let (mut a, mut b, mut c, mut d, mut defined, mut next) = (9, 9, 9, 9, 9, f64::NAN);
        unsafe {
            fmi3EnterEventMode(self.0);
            let status =
                fmi3UpdateDiscreteStates(self.0, &mut a, &mut b, &mut c, &mut d, &mut defined, &mut next);
            assert_eq!((status, a, b, c, d), (Status::Ok, 0, 0, 0, 0));
            assert_eq!(fmi3EnterStepMode(self.0), Status::Ok);
        }
        (defined == 1).then_some(next)
    }
}

impl Drop for Three {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.0) }
    }
}
