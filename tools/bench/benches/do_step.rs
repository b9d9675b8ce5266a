//! What a step costs through the C interface of the built library, beside diffsol's BDF and CVODE on the same equations.
//!
//! The library is loaded as an importer loads it. All figures of one run come from the same machine in the same
//! minute: compare them by their ratio.

mod cvode;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use cvode::Cvode;
use libloading::Library;
use physics::declare::Group;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{
    AnnulusCooledMotor, Constants, CoolingMode, Inputs, STATES, Step,
};
use reference::{Tolerance, integrate};
use std::ffi::{CString, c_char, c_int, c_void};
use std::hint::black_box;
use std::ptr::null;

/// Steps of 1 ms in one measured run.
const STEPS: u32 = 1000;
/// Their length, s.
const H: f64 = 1e-3;
/// Tolerances of the other integrators.
const RELATIVE: f64 = 1e-6;
const ABSOLUTE: f64 = 1e-8;
/// Their states at the start.
const START: [f64; STATES] = [0.0, 0.0, 0.0, 298.15, 298.15, 0.0, 0.0, 0.0];

/// The functions that a master needs.
struct Fmi2 {
    set: unsafe extern "C" fn(*mut c_void, *const u32, usize, *const f64) -> c_int,
    choose: unsafe extern "C" fn(*mut c_void, *const u32, usize, *const c_int) -> c_int,
    get: unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut f64) -> c_int,
    step: unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int,
    reset: unsafe extern "C" fn(*mut c_void) -> c_int,
    setup: unsafe extern "C" fn(*mut c_void, c_int, f64, f64, c_int, f64) -> c_int,
    enter: unsafe extern "C" fn(*mut c_void) -> c_int,
    exit: unsafe extern "C" fn(*mut c_void) -> c_int,
    instance: *mut c_void,
    _library: Library,
}

type Instantiate = unsafe extern "C" fn(
    *const c_char,
    c_int,
    *const c_char,
    *const c_char,
    *const c_void,
    c_int,
    c_int,
) -> *mut c_void;

impl Fmi2 {
    fn load() -> Fmi2 {
        let name = format!("{}motor_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let program = std::env::current_exe().expect("a running program has a path");
        let path = program.parent().and_then(|p| p.parent()).expect("target/release/deps").join(name);
        // SAFETY: our own library, with the signatures of FMI 2.
        unsafe {
            let library = Library::new(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            macro_rules! symbol {
                ($name:literal) => {
                    *library.get($name).expect($name)
                };
            }
            let instantiate: Instantiate = symbol!("fmi2Instantiate");
            let declaration = AnnulusCooledMotor::default().declaration();
            let token = CString::new(declaration.token.to_string()).expect("no zero inside");
            let instance = instantiate(c"bench".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 0);
            assert!(!instance.is_null(), "{} is of another build", path.display());
            Fmi2 {
                set: symbol!("fmi2SetReal"),
                choose: symbol!("fmi2SetInteger"),
                get: symbol!("fmi2GetReal"),
                step: symbol!("fmi2DoStep"),
                reset: symbol!("fmi2Reset"),
                setup: symbol!("fmi2SetupExperiment"),
                enter: symbol!("fmi2EnterInitializationMode"),
                exit: symbol!("fmi2ExitInitializationMode"),
                instance,
                _library: library,
            }
        }
    }

    fn begin(&self, parameters: &[(&str, f64)]) {
        self.begin_cooled_by(CoolingMode::Conductance, parameters);
    }

    fn begin_cooled_by(&self, cooling: CoolingMode, parameters: &[(&str, f64)]) {
        unsafe {
            (self.reset)(self.instance);
            let mode = reference("cooling_mode");
            assert_eq!((self.choose)(self.instance, &mode, 1, &(cooling as c_int)), 0);
            for (name, value) in parameters {
                assert_eq!((self.set)(self.instance, &reference(name), 1, value), 0);
            }
            (self.setup)(self.instance, 0, 0.0, 0.0, 0, 0.0);
            (self.enter)(self.instance);
            assert_eq!((self.exit)(self.instance), 0);
        }
    }
}

fn reference(name: &str) -> u32 {
    let declaration = AnnulusCooledMotor::default().declaration();
    declaration.by_name(name).unwrap_or_else(|| panic!("no variable {name}")).value_reference
}

/// Volts that change at every step: walking pace, with or without reversals.
fn volts(reversing: bool) -> Vec<f64> {
    let at = |k| (if reversing { 0.0 } else { 12.0 }) + 8.0 * (f64::from(k) * 1e-3 * 6.3).sin();
    (0..STEPS).map(at).collect()
}

/// The equations of a communication step with these inputs and their derivatives.
fn equations<'a>(
    motor: &'a AnnulusCooledMotor,
    constants: &'a Constants,
    [inputs, slopes]: [&'a Inputs; 2],
) -> Step<'a> {
    let conductance = motor.parameters.to_ambient(inputs.fan_command);
    Step::new(&motor.parameters, constants, inputs, slopes, conductance, 0.0)
}

fn steps(criterion: &mut Criterion) {
    let fmu = Fmi2::load();
    let voltage = reference("voltage");
    let outputs = ["current", "shaft_angle", "shaft_speed", "winding_temperature"].map(reference);
    let mut group = criterion.benchmark_group("1000 steps of 1 ms");
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    for (name, tau_c, reversing) in [
        ("running", 0.0, false),
        ("running with dry friction", 0.00983, false),
        ("reversing with dry friction", 0.00983, true),
    ] {
        for (what, read) in [("set, step", false), ("set, step, get 4", true)] {
            group.bench_function(format!("{name}: {what}"), |b| {
                fmu.begin(&[("effect.coulomb_friction.tau_c", tau_c)]);
                let volts = volts(reversing);
                let mut at = 0.0;
                b.iter(|| {
                    for volts in &volts {
                        let mut values = [0.0; 4];
                        unsafe {
                            (fmu.set)(fmu.instance, &voltage, 1, volts);
                            let status = (fmu.step)(fmu.instance, at, 1e-3, 1);
                            debug_assert_eq!(status, 0);
                            if read {
                                (fmu.get)(fmu.instance, outputs.as_ptr(), 4, values.as_mut_ptr());
                            }
                        }
                        at += 1e-3;
                        black_box(values);
                    }
                });
            });
        }
    }
    let volts = volts(false);
    let motor = AnnulusCooledMotor::default();
    let constants = Constants::of(&motor.parameters);
    let held = Inputs::zero();
    group.bench_function("diffsol BDF, rtol 1e-6, restarted at every step", |b| {
        let tolerance = Tolerance { relative: RELATIVE, absolute: ABSOLUTE };
        b.iter(|| {
            let mut y = START;
            for &voltage in &volts {
                let inputs = Inputs { voltage, ..Inputs::default() };
                let step = equations(&motor, &constants, [&inputs, &held]);
                y = integrate(|t, y| step.rates(t, y), &y, &[H], tolerance).expect("a smooth step")[0];
            }
            black_box(y)
        });
    });
    match Cvode::new(&START, RELATIVE, ABSOLUTE) {
        Err(why) => eprintln!("CVODE is not measured: {why}"),
        Ok(mut cvode) => {
            group.bench_function("CVODE BDF, rtol 1e-6, restarted at every step", |b| {
                b.iter(|| {
                    let mut y = START;
                    for &voltage in &volts {
                        let inputs = Inputs { voltage, ..Inputs::default() };
                        let step = equations(&motor, &constants, [&inputs, &held]);
                        cvode.restart(0.0, &y).expect("a state");
                        y = cvode.advance(H, &mut |t, y| step.rates(t, y)).expect("a smooth step");
                    }
                    black_box(y)
                });
            });
            // Its best case: the voltage has no jumps, and the solution goes on over the communication points.
            group.bench_function("CVODE BDF, rtol 1e-6, linear voltage, no restart", |b| {
                b.iter(|| {
                    cvode.restart(0.0, &START).expect("a state");
                    for (k, pair) in volts.windows(2).enumerate() {
                        let inputs = Inputs { voltage: pair[0], ..Inputs::default() };
                        let slopes = Inputs { voltage: (pair[1] - pair[0]) / H, ..held };
                        let step = equations(&motor, &constants, [&inputs, &slopes]);
                        let at = H * k as f64;
                        let y = cvode.advance(at + H, &mut |t, y| step.rates(t - at, y));
                        black_box(y.expect("a smooth step"));
                    }
                });
            });
        }
    }
    group.finish();
}

fn hour(criterion: &mut Criterion) {
    let fmu = Fmi2::load();
    let load = reference("load_torque");
    let mut group = criterion.benchmark_group("one hour");
    group.sample_size(20).throughput(Throughput::Elements(360_000));
    group.bench_function("3600 s at 10 ms, load changing", |b| {
        b.iter(|| {
            fmu.begin(&[("voltage", 24.0)]);
            for k in 0..360_000u32 {
                unsafe {
                    (fmu.set)(fmu.instance, &load, 1, &(0.05 + 0.01 * f64::from(k % 100) / 100.0));
                    (fmu.step)(fmu.instance, f64::from(k) * 0.01, 0.01, 1);
                }
            }
        });
    });
    group.finish();
}

fn hour_in_an_annulus(criterion: &mut Criterion) {
    let fmu = Fmi2::load();
    let load = reference("load_torque");
    let outputs = ["current", "shaft_speed", "winding_temperature"].map(reference);
    let mut group = criterion.benchmark_group("one hour in an annulus");
    group.sample_size(10).throughput(Throughput::Elements(3_600_000));
    group.bench_function("3600 s at 1 ms, load changing, get 3", |b| {
        b.iter(|| {
            fmu.begin_cooled_by(CoolingMode::AnnulusPush, &[("voltage", 24.0), ("fan_command", 1.0)]);
            for k in 0..3_600_000u32 {
                let mut values = [0.0; 3];
                unsafe {
                    (fmu.set)(fmu.instance, &load, 1, &(0.05 + 0.01 * f64::from(k % 1000) / 1000.0));
                    (fmu.step)(fmu.instance, f64::from(k) * 1e-3, 1e-3, 1);
                    (fmu.get)(fmu.instance, outputs.as_ptr(), 3, values.as_mut_ptr());
                }
                black_box(values);
            }
        });
    });
    group.finish();
}

criterion_group!(benches, steps, hour, hour_in_an_annulus);
criterion_main!(benches);
