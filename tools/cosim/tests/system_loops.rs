//! Algebraic loops, and components with steps of their own, against solutions by hand.
use crate::common::sets;
use crate::parts::*;
use cosim::{Algorithm, SystemOptions, SystemRun, cosimulate};

/// A rotor of 2 kg.m2 that turns against y = a.y, where a and b are in a loop: a.y = g_a b.y + tanh(speed) + 3, b.y = g_b a.y + 1.
const LOOP: &str = r#"
[system]
name = "loop"
connect = ["a.y -> b.u", "b.y -> a.u", "rotor.speed -> a.v", "a.y -> rotor.torque", "b.y -> gain.u"]
[experiment]
stop = 2
step = 0.01
[[component]]
name = "gain"
fmu = "gain.fmu"
[[component]]
name = "a"
fmu = "mixer.fmu"
[component.set]
c = 3.0
g = 2.0
[[component]]
name = "b"
fmu = "mixer.fmu"
[component.set]
g = -1.5
k = 0.0
[[component]]
name = "rotor"
fmu = "rotor.fmu"
[component.set]
J = 2.0
"#;

fn run(text: &str, options: &SystemOptions) -> SystemRun {
    cosimulate(&Folder::new().toml(text).unwrap(), options, &mut |_| ()).unwrap()
}

fn values(run: &SystemRun, name: &str) -> Vec<f64> {
    run.recording.column(name).unwrap().values.clone()
}

/// a.y in closed form of the loop: (1 - g_a g_b) a.y = g_a + tanh(speed) + 3.
fn torque(speed: f64) -> f64 {
    (2.0 + speed.tanh() + 3.0) / (1.0 + 3.0)
}

/// The speed at 2 s, by the classical Runge-Kutta method in steps of 1 ms.
fn monolithic() -> f64 {
    let rate = |w: f64| -torque(w) / 2.0;
    (0..2000).fold(0.0, |w, _| {
        let h = 1e-3;
        let k1 = rate(w);
        let k2 = rate(w + 0.5 * h * k1);
        let k3 = rate(w + 0.5 * h * k2);
        let k4 = rate(w + h * k3);
        w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    })
}

#[test]
fn loops_are_solved_at_each_communication_point() {
    // The gain around the loop is -3: a fixed point without relaxation diverges. With and without directional derivatives.
    let folder = Folder::new();
    folder.fmu("mixer", &xml("mixer").replace(" providesDirectionalDerivative=\"true\"", ""));
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let options = |step: f64| SystemOptions { algorithm, step: Some(step), ..SystemOptions::default() };
        let plain = cosimulate(&folder.toml(LOOP).unwrap(), &options(0.01), &mut |_| ()).unwrap();
        for run in [run(LOOP, &options(0.01)), plain] {
            assert_eq!(run.recording.times.len(), 201);
            let (a, b, speed) = (values(&run, "a.y"), values(&run, "b.y"), values(&run, "rotor.speed"));
            let gain = values(&run, "gain.y");
            for k in 0..a.len() {
                let expected = torque(speed[k]);
                assert!((a[k] - expected).abs() < 1e-10, "{algorithm:?}, row {k}: {} {expected}", a[k]);
                assert!((b[k] - (1.0 - 1.5 * expected)).abs() < 1e-10);
                // What comes after the loop is at the same communication point.
                assert_eq!(gain[k], b[k]);
            }
        }
        let error =
            |step| (values(&run(LOOP, &options(step)), "rotor.speed").last().unwrap() - monolithic()).abs();
        let (coarse, fine) = (error(0.02), error(0.01));
        assert!(fine < 1e-4 && (coarse / fine).log2() > 1.8, "{algorithm:?}: {coarse} {fine}");
    }
    // All outputs are read once after each step: delayed, said so. That is stable for small gains alone.
    let algorithm = Algorithm::JacobiDelayed;
    let sets = sets(&[("b.g", "-0.2")]);
    let delayed = run(LOOP, &SystemOptions { algorithm, sets, stop: Some(0.01), ..SystemOptions::default() });
    let note = delayed.notes.iter().find(|n| n.starts_with("algebraic loop: ")).unwrap();
    assert!(note.ends_with("the values are delayed by one step"), "{note}");
}

#[test]
fn a_nonlinear_loop_is_solved_also_where_newton_overshoots() {
    // a.y = 20 tanh(b.y) + 3 and b.y = -a.y + 1: one solution, by bisection.
    let text = LOOP
        .replace("\"b.y -> a.u\", \"rotor.speed -> a.v\"", "\"b.y -> a.v\", \"rotor.speed -> a.u\"")
        .replace("g = 2.0", "g = 0.1\nk = 20.0")
        .replace("g = -1.5", "g = -1.0");
    let (mut low, mut high) = (-50.0_f64, 50.0_f64);
    for _ in 0..200 {
        let y = 0.5 * (low + high);
        let is_low = 20.0 * (1.0 - y).tanh() + 3.0 > y;
        (low, high) = if is_low { (y, high) } else { (low, y) };
    }
    for tolerance in [None, Some(1e-4)] {
        let run = run(&text, &SystemOptions { tolerance, ..SystemOptions::default() });
        let a = values(&run, "a.y");
        assert!((a[0] - low).abs() < 1e-10, "{} {low}", a[0]);
        let speed = values(&run, "rotor.speed");
        for (y, w) in a.iter().zip(&speed) {
            let residual = 20.0 * (1.0 - y).tanh() + 3.0 + 0.1 * w - y;
            assert!(residual.abs() < 1e-9, "{residual}");
        }
    }
}

#[test]
fn loops_without_a_solution_are_refused() {
    let folder = Folder::new();
    // A gain of 1 around the loop: 2 * 0.5.
    let singular = LOOP.replace("g = -1.5", "g = 0.5");
    let sentence = folder.sentence(folder.toml(&singular), &SystemOptions::default());
    let end = ": no unique solution at t = 0 s, as the gain around the loop is 1";
    assert!(
        sentence.starts_with("s.toml, line 4: algebraic loop: ") && sentence.ends_with(end),
        "{sentence}"
    );
    assert!(sentence.contains("b.y -> a.u -> a.y -> b.u -> b.y"), "{sentence}");
}

#[test]
fn a_component_may_step_more_often_than_the_system() {
    // The rotor refuses steps above 5 ms; the system steps by 20 ms. Torques go on along their derivatives.
    let own = PAIR.replace("fmu = \"rotor.fmu\"", "fmu = \"rotor.fmu\"\nstep = 0.005");
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let options = SystemOptions {
            algorithm,
            step: Some(0.02),
            sets: sets(&[("rotor.longest", "0.00501")]),
            ..SystemOptions::default()
        };
        let run = run(&own, &options);
        assert_eq!(run.recording.steps, 300);
        // The parts are exact for lines: as with one step, up to rounding.
        let whole = SystemOptions { sets: Vec::new(), ..options.clone() };
        let expected = error_at_end(&self::run(PAIR, &whole));
        let found = error_at_end(&run);
        assert!((found - expected).abs() < 1e-9, "{algorithm:?}: {found} {expected}");
    }
    let folder = Folder::new();
    for (step, expected) in [
        ("0.003", "its step 0.003 s does not divide the communication step 0.01 s"),
        ("0.02", "its step 0.02 s does not divide the communication step 0.01 s"),
        ("0", "its step 0 s must be finite and above 0 s"),
        ("nan", "its step NaN s must be finite and above 0 s"),
        ("1e-12", "its step 0.000000000001 s is too small for a span of 6 s"),
    ] {
        let text = own.replace("step = 0.005", &format!("step = {step}"));
        let sentence = folder.sentence(folder.toml(&text), &SystemOptions::default());
        assert_eq!(sentence, format!("s.toml, line 14: component rotor: {expected}"));
    }
    // A variable step: at most the step of the component, for each part.
    let sets = sets(&[("rotor.longest", "0.00501")]);
    let variable = run(&own, &SystemOptions { tolerance: Some(1e-4), sets, ..SystemOptions::default() });
    assert_eq!(variable.rejected, 0);
}
