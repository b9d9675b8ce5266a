//! Random calls: every function of both C interfaces, with arguments that make sense and arguments that do not.
//!
//! Only conditions that C cannot check are always met: handles are valid, arrays have the given length. Nothing may crash, every
//! status is one of the standards', and no call may meet an internal failure, which is how a panic inside is reported.

use motor_fmu::fmi2::*;
use motor_fmu::fmi3::*;
use motor_fmu::instance::IntermediateUpdate;
use motor_fmu::logger::Status;
use physics::declare::Elements;
use physics::model::{Element, ModelType};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

/// Internal failures that the library has reported.
static FAILURES: Mutex<Vec<String>> = Mutex::new(Vec::new());

fn hear(message: *const c_char) {
    let text = unsafe { CStr::from_ptr(message) }.to_string_lossy().into_owned();
    if text.contains("internal failure;") {
        FAILURES.lock().unwrap().push(text);
    }
}

/// FMI 2's logger without its variadic tail: the library passes "%s" and one text.
unsafe extern "C" fn logger2(
    _environment: *mut c_void,
    _instance: *const c_char,
    _status: c_int,
    _category: *const c_char,
    _format: *const c_char,
    message: *const c_char,
) {
    hear(message);
}

unsafe extern "C" fn logger3(
    _environment: *mut c_void,
    _status: c_int,
    _category: *const c_char,
    message: *const c_char,
) {
    hear(message);
}

/// Random numbers, the same for the same seed.
pub struct Source(Pcg64Mcg);

impl Source {
    fn new(seed: u64) -> Source {
        Source(Pcg64Mcg::seed_from_u64(seed))
    }

    fn next(&mut self) -> u64 {
        self.0.next_u64()
    }

    fn below(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// A number as an importer gives it, or as none should.
    fn number(&mut self) -> f64 {
        let share = self.next() as f64 / u64::MAX as f64;
        match self.below(12) {
            0 => self.one(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN_POSITIVE, -0.0]),
            1 => self.one(&[0.0, 1.0, -1.0, 298.15, 101_325.0, 8.0, 64.0]),
            2 => (share - 0.5) * 1e6,
            3 => 250.0 + 200.0 * share,
            4 => (share - 0.5) * 1e-6,
            _ => (share - 0.3) * 30.0,
        }
    }
}

/// What an intermediate update needs.
struct Looker {
    handle: *mut c_void,
    rng: Source,
    references: Vec<u32>,
}

/// An intermediate update with allowed and forbidden calls; sometimes it requests an early return.
unsafe extern "C" fn look(
    environment: *mut c_void,
    time: f64,
    _sets: u8,
    _gets: u8,
    _finished: u8,
    _may_return: u8,
    requested: *mut u8,
    until: *mut f64,
) {
    let looker = unsafe { &mut *environment.cast::<Looker>() };
    let (h, rng) = (looker.handle, &mut looker.rng);
    let (vr, mut value) = (rng.one(&looker.references), rng.number());
    unsafe {
        match rng.below(8) {
            0 | 1 => fmi3SetFloat64(h, &vr, 1, &value, 1),
            2 => fmi3DoStep(h, time, 1e-3, 1, null_mut(), null_mut(), null_mut(), null_mut()),
            3 => fmi3Reset(h),
            4 => fmi3GetOutputDerivatives(h, &vr, 1, &1, &mut value, 1),
            5 => fmi3EnterEventMode(h),
            _ => fmi3GetFloat64(h, &vr, 1, &mut value, 1),
        };
        fmi3FreeInstance(h);
        if rng.below(4) == 0 {
            (*requested, *until) = (1, time + rng.number() * 1e-3);
        }
    }
}

/// One instance under test.
struct TestInstance {
    handle: *mut c_void,
    three: bool,
    references: Vec<u32>,
    /// The parameters that count elements.
    sizes: Vec<u32>,
    /// Lives as long as the instance that calls it.
    _looker: Box<Looker>,
    states: usize,
    /// Where the next step may begin, s.
    time: f64,
    saved: Vec<*mut c_void>,
}

impl TestInstance {
    fn new(rng: &mut Source, kind: Option<&'static ModelType>) -> TestInstance {
        let kind = kind.unwrap_or_else(|| &physics::models::ALL[rng.below(physics::models::ALL.len())]);
        let declaration = (kind.declaration)();
        let references: Vec<u32> =
            declaration.entries.iter().map(|e| e.value_reference).chain([0, 99, u32::MAX]).collect();
        let seen: Vec<u32> =
            declaration.entries.iter().filter(|e| e.is_intermediate()).map(|e| e.value_reference).collect();
        let mut looker = Box::new(Looker {
            handle: null_mut(),
            rng: Source::new(rng.next()),
            references: references.clone(),
        });
        let (events, early, looks) = (rng.below(2) as u8, rng.below(2) as u8, rng.below(3) == 0);
        let token = CString::new(declaration.token.clone()).unwrap();
        let (three, exchange) = (rng.below(2) == 1, rng.below(2) == 1);
        let on = rng.below(2) as u8;
        let handle = unsafe {
            if !three {
                let logger = std::mem::transmute::<*const c_void, motor_fmu::logger::Logger2>(
                    logger2 as *const c_void,
                );
                let functions = CallbackFunctions {
                    logger: Some(logger),
                    allocate_memory: None,
                    free_memory: None,
                    step_finished: None,
                    environment: null_mut(),
                };
                fmi2Instantiate(
                    c"test".as_ptr(),
                    c_int::from(!exchange),
                    token.as_ptr(),
                    null(),
                    &functions,
                    0,
                    c_int::from(on),
                )
            } else if exchange {
                fmi3InstantiateModelExchange(
                    c"test".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    on,
                    null_mut(),
                    Some(logger3),
                )
            } else {
                fmi3InstantiateCoSimulation(
                    c"test".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    on,
                    events,
                    early,
                    seen.as_ptr(),
                    if looks { seen.len() } else { 0 },
                    (&raw mut *looker).cast(),
                    Some(logger3),
                    looks.then_some(look as IntermediateUpdate),
                )
            }
        };
        assert!(!handle.is_null());
        looker.handle = handle;
        let sizes = declaration.dimensions.iter().map(|&k| declaration.entries[k].value_reference).collect();
        let shown = |[k, _]: &&[usize; 2]| match declaration.entries[*k].element {
            Some(Element { index, of: Elements::UpTo(_, parameter), .. }) => {
                f64::from(index) <= declaration.by_name(parameter).unwrap().row.start
            }
            _ => true,
        };
        let states = declaration.states.iter().filter(shown).count();
        TestInstance {
            handle,
            three,
            references,
            sizes,
            _looker: looker,
            states,
            time: 0.0,
            saved: Vec::new(),
        }
    }

    /// One call; the outcome's status.
    fn call(&mut self, rng: &mut Source) -> Status {
        let h = self.handle;
        let n = rng.below(4);
        let vr: Vec<u32> = (0..n).map(|_| rng.one(&self.references)).collect();
        let mut values: Vec<f64> = (0..n).map(|_| rng.number()).collect();
        let mut whole: Vec<i64> = values.iter().map(|v| *v as i64).collect();
        let count = if rng.below(9) == 0 { rng.below(30) } else { self.states };
        let mut x: Vec<f64> = (0..count).map(|_| rng.number()).collect();
        let (mut a, mut b, mut size) = (0, 0, 0usize);
        let orders = vec![1; n];
        let three = self.three;
        let slot = rng.below(self.saved.len().max(1));
        unsafe {
            match rng.below(30) {
                0 if three => fmi3EnterInitializationMode(h, 0, 0.0, 0.0, 0, 0.0),
                0 => {
                    fmi2SetupExperiment(h, 0, 0.0, 0.0, 0, 0.0);
                    fmi2EnterInitializationMode(h)
                }
                1 if three => fmi3ExitInitializationMode(h),
                1 => fmi2ExitInitializationMode(h),
                2 | 3 if three => fmi3GetFloat64(h, vr.as_ptr(), n, values.as_mut_ptr(), n),
                2 | 3 => fmi2GetReal(h, vr.as_ptr(), n, values.as_mut_ptr()),
                4 | 5 if three => fmi3SetFloat64(h, vr.as_ptr(), n, values.as_ptr(), n),
                4 | 5 => fmi2SetReal(h, vr.as_ptr(), n, values.as_ptr()),
                6 if three => fmi3SetInt64(h, vr.as_ptr(), n, whole.as_ptr(), n),
                6 => {
                    let whole: Vec<c_int> = whole.iter().map(|v| *v as c_int).collect();
                    fmi2SetInteger(h, vr.as_ptr(), n, whole.as_ptr())
                }
                7 if three => fmi3GetInt64(h, vr.as_ptr(), n, whole.as_mut_ptr(), n),
                7 => fmi2GetInteger(h, vr.as_ptr(), n, orders.clone().as_mut_ptr()),
                26 if three => fmi3EnterStepMode(h),
                27 if three && rng.below(4) > 0 => self.configure(rng),
                28 if three => {
                    let mut all = vec![0.0; rng.below(80)];
                    fmi3GetFloat64(h, vr.as_ptr(), n, all.as_mut_ptr(), all.len())
                }
                8..=10 => {
                    let step = rng.one(&[1e-6, 1e-3, 1e-3, 1e-2, 0.3, 5.0, 0.0, -1.0, f64::NAN]);
                    let at = if rng.below(9) == 0 { rng.number() } else { self.time };
                    let mut last = at + step;
                    let status = if three {
                        fmi3DoStep(h, at, step, 1, &mut a, &mut b, null_mut(), &mut last)
                    } else {
                        fmi2DoStep(h, at, step, 1)
                    };
                    if status == Status::Ok {
                        self.time = last;
                    }
                    status
                }
                11 if three => {
                    let (mut c, mut d, mut e, mut t) = (0, 0, 0, 0.0);
                    fmi3UpdateDiscreteStates(h, &mut a, &mut b, &mut c, &mut d, &mut e, &mut t)
                }
                11 => {
                    let mut info = EventInfo {
                        new_discrete_states_needed: 0,
                        terminate_simulation: 0,
                        nominals_changed: 0,
                        values_changed: 0,
                        next_event_time_defined: 0,
                        next_event_time: 0.0,
                    };
                    fmi2NewDiscreteStates(h, &mut info)
                }
                12 if three => fmi3EnterContinuousTimeMode(h),
                12 => fmi2EnterContinuousTimeMode(h),
                13 if three => fmi3SetContinuousStates(h, x.as_ptr(), count),
                13 => fmi2SetContinuousStates(h, x.as_ptr(), count),
                14 if three => fmi3GetContinuousStateDerivatives(h, x.as_mut_ptr(), count),
                14 => fmi2GetDerivatives(h, x.as_mut_ptr(), count),
                15 if three => fmi3GetEventIndicators(h, x.as_mut_ptr(), count.min(2)),
                15 => fmi2GetEventIndicators(h, x.as_mut_ptr(), count.min(2)),
                16 if three => fmi3SetTime(h, rng.number()),
                16 => fmi2SetTime(h, rng.number()),
                17 if three => fmi3CompletedIntegratorStep(h, 1, &mut a, &mut b),
                17 => fmi2CompletedIntegratorStep(h, 1, &mut c_int::from(a), &mut c_int::from(b)),
                18 if three => fmi3EnterEventMode(h),
                18 => fmi2EnterEventMode(h),
                19 => {
                    let known = [rng.one(&self.references)];
                    let seed = [rng.number()];
                    if three {
                        fmi3GetDirectionalDerivative(
                            h,
                            vr.as_ptr(),
                            n,
                            known.as_ptr(),
                            1,
                            seed.as_ptr(),
                            1,
                            values.as_mut_ptr(),
                            n,
                        )
                    } else {
                        fmi2GetDirectionalDerivative(
                            h,
                            vr.as_ptr(),
                            n,
                            known.as_ptr(),
                            1,
                            seed.as_ptr(),
                            values.as_mut_ptr(),
                        )
                    }
                }
                20 => {
                    let mut state = null_mut();
                    let status =
                        if three { fmi3GetFMUState(h, &mut state) } else { fmi2GetFMUstate(h, &mut state) };
                    if !state.is_null() {
                        self.saved.push(state);
                    }
                    status
                }
                21 => {
                    let state = self.saved.get(slot).copied().unwrap_or(null_mut());
                    let status = if three { fmi3SetFMUState(h, state) } else { fmi2SetFMUstate(h, state) };
                    let mut now = 0.0;
                    if fmi2GetReal(h, &0, 1, &mut now) == Status::Ok {
                        self.time = now;
                    }
                    status
                }
                22 => self.through_bytes(rng, slot, &mut size),
                23 if three => {
                    fmi3GetOutputDerivatives(h, vr.as_ptr(), n, orders.as_ptr(), values.as_mut_ptr(), n)
                }
                23 => fmi2GetRealOutputDerivatives(h, vr.as_ptr(), n, orders.as_ptr(), values.as_mut_ptr()),
                24 if three => fmi3GetAdjointDerivative(
                    h,
                    vr.as_ptr(),
                    n,
                    vr.as_ptr(),
                    n,
                    values.clone().as_ptr(),
                    n,
                    values.as_mut_ptr(),
                    n,
                ),
                24 => fmi2SetRealInputDerivatives(h, vr.as_ptr(), n, orders.as_ptr(), values.as_ptr()),
                25 if rng.below(20) == 0 => {
                    self.time = 0.0;
                    if three { fmi3Reset(h) } else { fmi2Reset(h) }
                }
                25 => {
                    if three {
                        fmi3GetFloat64(h, null(), n, null_mut(), n)
                    } else {
                        fmi2SetReal(h, null(), n, null())
                    }
                }
                _ if rng.below(20) == 0 => {
                    if three {
                        fmi3Terminate(h)
                    } else {
                        fmi2Terminate(h)
                    }
                }
                _ => {
                    if three {
                        fmi3GetContinuousStates(h, x.as_mut_ptr(), count)
                    } else {
                        fmi2GetContinuousStates(h, x.as_mut_ptr(), count)
                    }
                }
            }
        }
    }

    /// Another number of elements, if this is the time for it.
    fn configure(&mut self, rng: &mut Source) -> Status {
        let h = self.handle;
        let (size, count) = (rng.one(&[&self.sizes[..], &[99]].concat()), rng.below(70) as u64);
        unsafe {
            let status = fmi3EnterConfigurationMode(h);
            fmi3SetUInt64(h, &size, 1, &count, 1);
            fmi3ExitConfigurationMode(h);
            let mut states = 0;
            if fmi3GetNumberOfContinuousStates(h, &mut states) == Status::Ok && states > 0 {
                self.states = states;
            }
            status
        }
    }

    /// A saved state through its bytes, some of them spoilt now and then.
    fn through_bytes(&mut self, rng: &mut Source, slot: usize, size: &mut usize) -> Status {
        let (h, state) = (self.handle, self.saved.get(slot).copied().unwrap_or(null_mut()));
        unsafe {
            if fmi2SerializedFMUstateSize(h, state, size) != Status::Ok {
                return Status::Error;
            }
            let mut bytes = vec![0u8; *size];
            assert_eq!(fmi2SerializeFMUstate(h, state, bytes.as_mut_ptr(), *size), Status::Ok);
            if rng.below(2) == 0 {
                let k = rng.below(bytes.len());
                bytes[k] ^= 1 << rng.below(8);
            }
            let keep = if rng.below(4) == 0 { rng.below(*size + 1) } else { *size };
            let mut made = null_mut();
            let status = fmi2DeSerializeFMUstate(h, bytes.as_ptr(), keep, &mut made);
            if !made.is_null() {
                self.saved.push(made);
            }
            status
        }
    }
}

impl Drop for TestInstance {
    fn drop(&mut self) {
        unsafe {
            for state in &mut self.saved {
                fmi2FreeFMUstate(self.handle, state);
            }
            if self.three { fmi3FreeInstance(self.handle) } else { fmi2FreeInstance(self.handle) }
        }
    }
}

/// Calls of one instance.
const CALLS: u64 = 400;

/// Calls functions of `instances` instances, of one model or of all; how many calls there were, and how many succeeded.
///
/// # Panics
/// On an internal failure, with the seed that leads there.
pub fn run(instances: u64, seed: u64, kind: Option<&'static ModelType>) -> (u64, u64) {
    let (mut calls, mut done) = (0, 0);
    for seed in seed..seed + instances {
        let mut rng = Source::new(seed);
        let mut instance = TestInstance::new(&mut rng, kind);
        for _ in 0..CALLS {
            calls += 1;
            let status = instance.call(&mut rng);
            assert_ne!(status, Status::Fatal, "seed {seed}");
            done += u64::from(status == Status::Ok);
            if instance.saved.len() > 8 {
                let mut oldest = instance.saved.remove(0);
                unsafe { fmi2FreeFMUstate(instance.handle, &mut oldest) };
            }
        }
        let failures = FAILURES.lock().unwrap();
        assert!(failures.is_empty(), "seed {seed}: {failures:?}");
    }
    (calls, done)
}
