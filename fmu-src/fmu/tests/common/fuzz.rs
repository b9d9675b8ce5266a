//! Calls without order: every function of both C interfaces, with arguments that make sense and arguments that do not.
//!
//! Only what C cannot check is kept honest: handles are alive, arrays are as long as their lengths say. Nothing may crash, every
//! status is one of the standards', and no call may meet an internal failure, which is what a panic inside is told as.

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
use std::time::{Duration, Instant};

/// What the library has said of internal failures.
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
pub struct Dice(Pcg64Mcg);

impl Dice {
    fn new(seed: u64) -> Dice {
        Dice(Pcg64Mcg::seed_from_u64(seed))
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

/// What a look into a step needs.
struct Looker {
    handle: *mut c_void,
    dice: Dice,
    references: Vec<u32>,
}

/// Looks into a step with calls that are fitting and calls that are not, and now and then ends it.
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
    let (h, dice) = (looker.handle, &mut looker.dice);
    let (vr, mut value) = (dice.one(&looker.references), dice.number());
    unsafe {
        match dice.below(8) {
            0 | 1 => fmi3SetFloat64(h, &vr, 1, &value, 1),
            2 => fmi3DoStep(h, time, 1e-3, 1, null_mut(), null_mut(), null_mut(), null_mut()),
            3 => fmi3Reset(h),
            4 => fmi3GetOutputDerivatives(h, &vr, 1, &1, &mut value, 1),
            5 => fmi3EnterEventMode(h),
            _ => fmi3GetFloat64(h, &vr, 1, &mut value, 1),
        };
        fmi3FreeInstance(h);
        if dice.below(4) == 0 {
            (*requested, *until) = (1, time + dice.number() * 1e-3);
        }
    }
}

/// One instance in the hands of the dice.
struct Toy {
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

impl Toy {
    fn new(dice: &mut Dice, kind: Option<&'static ModelType>) -> Toy {
        let kind = kind.unwrap_or_else(|| &physics::models::ALL[dice.below(physics::models::ALL.len())]);
        let declaration = (kind.declaration)();
        let references: Vec<u32> =
            declaration.entries.iter().map(|e| e.value_reference).chain([0, 99, u32::MAX]).collect();
        let seen: Vec<u32> =
            declaration.entries.iter().filter(|e| e.is_intermediate()).map(|e| e.value_reference).collect();
        let mut looker = Box::new(Looker {
            handle: null_mut(),
            dice: Dice::new(dice.next()),
            references: references.clone(),
        });
        let (events, early, looks) = (dice.below(2) as u8, dice.below(2) as u8, dice.below(3) == 0);
        let token = CString::new(declaration.token.clone()).unwrap();
        let (three, exchange) = (dice.below(2) == 1, dice.below(2) == 1);
        let on = dice.below(2) as u8;
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
                    c"toy".as_ptr(),
                    c_int::from(!exchange),
                    token.as_ptr(),
                    null(),
                    &functions,
                    0,
                    c_int::from(on),
                )
            } else if exchange {
                fmi3InstantiateModelExchange(
                    c"toy".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    on,
                    null_mut(),
                    Some(logger3),
                )
            } else {
                fmi3InstantiateCoSimulation(
                    c"toy".as_ptr(),
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
        Toy { handle, three, references, sizes, _looker: looker, states, time: 0.0, saved: Vec::new() }
    }

    /// One call; the outcome's status.
    fn play(&mut self, dice: &mut Dice) -> Status {
        let h = self.handle;
        let n = dice.below(4);
        let vr: Vec<u32> = (0..n).map(|_| dice.one(&self.references)).collect();
        let mut values: Vec<f64> = (0..n).map(|_| dice.number()).collect();
        let mut whole: Vec<i64> = values.iter().map(|v| *v as i64).collect();
        let count = if dice.below(9) == 0 { dice.below(30) } else { self.states };
        let mut x: Vec<f64> = (0..count).map(|_| dice.number()).collect();
        let (mut a, mut b, mut size) = (0, 0, 0usize);
        let orders = vec![1; n];
        let three = self.three;
        let slot = dice.below(self.saved.len().max(1));
        unsafe {
            match dice.below(30) {
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
                27 if three && dice.below(4) > 0 => self.configure(dice),
                28 if three => {
                    let mut all = vec![0.0; dice.below(80)];
                    fmi3GetFloat64(h, vr.as_ptr(), n, all.as_mut_ptr(), all.len())
                }
                8..=10 => {
                    let step = dice.one(&[1e-6, 1e-3, 1e-3, 1e-2, 0.3, 5.0, 0.0, -1.0, f64::NAN]);
                    let at = if dice.below(9) == 0 { dice.number() } else { self.time };
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
                16 if three => fmi3SetTime(h, dice.number()),
                16 => fmi2SetTime(h, dice.number()),
                17 if three => fmi3CompletedIntegratorStep(h, 1, &mut a, &mut b),
                17 => fmi2CompletedIntegratorStep(h, 1, &mut c_int::from(a), &mut c_int::from(b)),
                18 if three => fmi3EnterEventMode(h),
                18 => fmi2EnterEventMode(h),
                19 => {
                    let known = [dice.one(&self.references)];
                    let seed = [dice.number()];
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
                22 => self.through_bytes(dice, slot, &mut size),
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
                25 if dice.below(20) == 0 => {
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
                _ if dice.below(20) == 0 => {
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
    fn configure(&mut self, dice: &mut Dice) -> Status {
        let h = self.handle;
        let (size, count) = (dice.one(&[&self.sizes[..], &[99]].concat()), dice.below(70) as u64);
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
    fn through_bytes(&mut self, dice: &mut Dice, slot: usize, size: &mut usize) -> Status {
        let (h, state) = (self.handle, self.saved.get(slot).copied().unwrap_or(null_mut()));
        unsafe {
            if fmi2SerializedFMUstateSize(h, state, size) != Status::Ok {
                return Status::Error;
            }
            let mut bytes = vec![0u8; *size];
            assert_eq!(fmi2SerializeFMUstate(h, state, bytes.as_mut_ptr(), *size), Status::Ok);
            if dice.below(2) == 0 {
                let k = dice.below(bytes.len());
                bytes[k] ^= 1 << dice.below(8);
            }
            let keep = if dice.below(4) == 0 { dice.below(*size + 1) } else { *size };
            let mut made = null_mut();
            let status = fmi2DeSerializeFMUstate(h, bytes.as_ptr(), keep, &mut made);
            if !made.is_null() {
                self.saved.push(made);
            }
            status
        }
    }
}

impl Drop for Toy {
    fn drop(&mut self) {
        unsafe {
            for state in &mut self.saved {
                fmi2FreeFMUstate(self.handle, state);
            }
            if self.three { fmi3FreeInstance(self.handle) } else { fmi2FreeInstance(self.handle) }
        }
    }
}

/// Plays for so long, with one model or with all; how many calls there were, and how many of them were done.
///
/// # Panics
/// On an internal failure, with the seed that led there.
pub fn play(seconds: f64, seed: u64, kind: Option<&'static ModelType>) -> (u64, u64) {
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let (mut calls, mut done, mut round) = (0, 0, seed);
    while Instant::now() < end {
        let mut dice = Dice::new(round);
        let mut toy = Toy::new(&mut dice, kind);
        for _ in 0..400 {
            calls += 1;
            let status = toy.play(&mut dice);
            assert_ne!(status, Status::Fatal, "seed {round}");
            done += u64::from(status == Status::Ok);
            if toy.saved.len() > 8 {
                let mut oldest = toy.saved.remove(0);
                unsafe { fmi2FreeFMUstate(toy.handle, &mut oldest) };
            }
        }
        let failures = FAILURES.lock().unwrap();
        assert!(failures.is_empty(), "seed {round}: {failures:?}");
        round += 1;
    }
    (calls, done)
}
