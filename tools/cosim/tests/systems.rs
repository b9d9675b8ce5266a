//! Systems of FMUs: orders of accuracy against the closed form, the energy balance, bitwise equal results.
use crate::parts::*;
use cosim::{Algorithm, SystemOptions, SystemRun, cosimulate};

fn options(algorithm: Algorithm, held_inputs: bool, step: f64) -> SystemOptions {
    SystemOptions { algorithm, held_inputs, step: Some(step), ..SystemOptions::default() }
}

fn pair(options: &SystemOptions) -> SystemRun {
    cosimulate(&Folder::new().toml(PAIR).unwrap(), options, &mut |_| ()).unwrap()
}

/// The exponent of the step with which an error falls, from steps that halve.
fn slope(errors: &[f64]) -> f64 {
    let halvings = (errors.len() - 1) as f64;
    (errors[0] / errors[errors.len() - 1]).log2() / halvings
}

const STEPS: [f64; 4] = [0.02, 0.01, 0.005, 0.0025];

#[test]
fn held_inputs_are_of_first_order_and_slopes_of_second() {
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel, Algorithm::JacobiDelayed] {
        for (held, expected) in [(true, 1.0), (false, 2.0)] {
            let errors = STEPS.map(|h| error_at_end(&pair(&options(algorithm, held, h))));
            let order = slope(&errors);
            assert!((order - expected).abs() < 0.2, "{algorithm:?}, held {held}: order {order}, {errors:?}");
        }
    }
}

#[test]
fn the_energy_error_falls_as_the_solution_s_does() {
    for (held, expected) in [(true, 1.0), (false, 2.0)] {
        let bonds = STEPS.map(|h| pair(&options(Algorithm::Jacobi, held, h)).bonds);
        for bond in &bonds {
            assert_eq!(bond.len(), 1);
            assert_eq!(bond[0].forth, "rotor.speed -> spring.speed");
            assert_eq!(bond[0].back, "spring.torque -> rotor.torque");
        }
        let order = slope(&bonds.clone().map(|b| b[0].gross_residual));
        assert!((order - expected).abs() < 0.2, "held {held}: order {order}");
        // What left the rotor: its kinetic energy then and now.
        let energy = 0.5 * 2.0 * (1.0 - exact(6.0)[0].powi(2));
        let bond = &bonds[3][0];
        assert!((bond.energy - energy).abs() < 0.02, "{} {energy}", bond.energy);
        assert!(bond.throughput > energy && bond.gross_residual >= bond.residual.abs());
    }
}

#[test]
fn what_the_coupling_makes_is_what_the_masses_have_too_much() {
    let run = pair(&options(Algorithm::Jacobi, true, 0.02));
    let last = |name: &str| *run.recording.column(name).unwrap().values.last().unwrap();
    let kinetic = 0.5 * 2.0 * last("rotor.speed").powi(2) + 0.5 * 0.5 * last("spring.far_speed").powi(2);
    let stored = kinetic + 0.5 * last("spring.torque").powi(2) / 3.0;
    let made = stored - 0.5 * 2.0;
    // The rotor gives too little, or the spring gets too much: the rotor's side less the spring's is what vanished.
    assert!(made > 0.01, "held inputs make energy: {made}");
    assert!((made + run.bonds[0].residual).abs() < 0.02 * made, "{made} {}", run.bonds[0].residual);
}

#[test]
fn gauss_and_seidel_step_sources_first_and_differ_from_jacobi() {
    let seidel = pair(&options(Algorithm::GaussSeidel, true, 0.01));
    assert_eq!(seidel.order, ["rotor", "spring"]);
    let jacobi = pair(&options(Algorithm::Jacobi, true, 0.01));
    // Seen by the later one at the end of its step and by the earlier at the beginning, the errors nearly cancel.
    assert!(error_at_end(&seidel) < 0.2 * error_at_end(&jacobi));
    // A slope to where the other one arrived is better than one from where it has been.
    let sloped = |algorithm| error_at_end(&pair(&options(algorithm, false, 0.01)));
    assert!(sloped(Algorithm::GaussSeidel) < 0.5 * sloped(Algorithm::Jacobi));
    // The file lists them from the end to the source.
    let seidel = cosimulate(
        &Folder::new().toml(CHAIN).unwrap(),
        &options(Algorithm::GaussSeidel, true, 0.01),
        &mut |_| (),
    );
    assert_eq!(seidel.unwrap().order, ["rotor", "a", "b", "c"]);
}

#[test]
fn the_variable_step_meets_its_tolerance() {
    for held in [true, false] {
        let mut work = Vec::new();
        for tolerance in [1e-3, 1e-4, 1e-5, 1e-6] {
            let options =
                SystemOptions { tolerance: Some(tolerance), ..options(Algorithm::Jacobi, held, 0.01) };
            let run = pair(&options);
            let steps = run.recording.steps as f64;
            // The tolerance is that of a step: their errors add up over the run.
            let error = error_at_end(&run);
            assert!(error < tolerance * steps, "held {held}, {tolerance}: {error} after {steps} steps");
            assert_eq!(*run.recording.times.last().unwrap(), 6.0);
            work.push(steps);
        }
        // The first step would make 600: where the tolerance allows, steps grow.
        assert!(work[0] < 200.0, "{work:?}");
        // With a local error of order p + 1, one digit costs 10^(1 / (p + 1)) times as many steps.
        let growth = (work[3] / work[1]).powf(0.5).log10();
        let expected = if held { 0.5 } else { 1.0 / 3.0 };
        assert!((growth - expected).abs() < 0.06, "held {held}: {growth}, {work:?}");
    }
    let wide = SystemOptions { tolerance: Some(1e-6), ..options(Algorithm::Jacobi, false, 1.0) };
    assert!(pair(&wide).rejected > 0, "a first step of 1 s is far too long");
}

#[test]
fn a_step_that_is_refused_is_made_shorter_where_that_is_possible() {
    let sets = vec![("rotor.longest".to_owned(), "0.015".to_owned())];
    let variable =
        SystemOptions { tolerance: Some(1e-2), sets: sets.clone(), ..options(Algorithm::Jacobi, false, 1.0) };
    let run = pair(&variable);
    assert!(run.rejected > 0 && run.recording.steps >= 200);
    // Rejected steps do not count in the energy balance; the accepted steps are at most as long as the longest step of the rotor.
    let halves = pair(&options(Algorithm::Jacobi, false, 0.0075));
    assert!(run.bonds[0].gross_residual < 1.1 * halves.bonds[0].gross_residual);
    assert!((run.bonds[0].throughput / halves.bonds[0].throughput - 1.0).abs() < 1e-3);
    let folder = Folder::new();
    let fixed = SystemOptions { sets, ..options(Algorithm::Jacobi, false, 0.02) };
    assert_eq!(
        folder.sentence(folder.toml(PAIR), &fixed),
        "fmi2DoStep of rotor returned Discard at t = 0 s: the step is too long for me"
    );
}

#[test]
fn a_component_may_end_the_run() {
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let sets = vec![("rotor.until".to_owned(), "0.5".to_owned())];
        let run = pair(&SystemOptions { sets, ..options(algorithm, false, 0.01) });
        assert_eq!((run.ended_by.as_deref(), run.recording.steps), (Some("rotor"), 50));
        assert_eq!(run.recording.ended_early, Some(0.5));
    }
}

fn bits(run: &SystemRun) -> Vec<u64> {
    run.recording.columns.iter().flat_map(|c| c.values.iter().map(|x| x.to_bits())).collect()
}

#[test]
fn runs_repeat_to_the_bit_from_toml_and_from_the_archive_made_of_it() {
    let folder = Folder::new();
    let system = folder.toml(PAIR).unwrap();
    let (one, two) = (folder.path("one.ssp"), folder.path("two.ssp"));
    system.write_ssp(&one, cosim::SspForm::default()).unwrap();
    let packed = cosim::System::open(&one).unwrap();
    packed.write_ssp(&two, cosim::SspForm::default()).unwrap();
    assert_eq!(std::fs::read(&one).unwrap(), std::fs::read(&two).unwrap());
    for tolerance in [None, Some(1e-4)] {
        for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
            let options = SystemOptions { algorithm, tolerance, ..SystemOptions::default() };
            let run = |s| cosimulate(s, &options, &mut |_| ()).unwrap();
            let (a, b, c) = (run(&system), run(&system), run(&packed));
            assert_eq!(a.recording.times, b.recording.times);
            assert_eq!(bits(&a), bits(&b));
            assert_eq!(bits(&a), bits(&c));
            assert_eq!(a.bonds, c.bonds);
            assert_eq!(a.recording.steps, if tolerance.is_some() { a.recording.steps } else { 600 });
        }
    }
}

const CHAIN: &str = include_str!("data/chain.toml");

#[test]
fn what_passes_through_arrives_in_the_same_communication_point() {
    let folder = Folder::new();
    let system = folder.toml(CHAIN).unwrap();
    let run = |algorithm| {
        let held_inputs = algorithm == Algorithm::JacobiDelayed;
        let options = SystemOptions { algorithm, held_inputs, step: Some(0.25), ..SystemOptions::default() };
        cosimulate(&system, &options, &mut |_| ()).unwrap()
    };
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        let r = run(algorithm);
        let values = |name: &str| r.recording.column(name).unwrap().values.clone();
        assert_eq!(values("rotor.speed"), [4.0, 3.75, 3.5, 3.25, 3.0]);
        assert_eq!(values("c.y"), [20.0, 18.75, 17.5, 16.25, 15.0]);
        assert_eq!(values("result"), values("c.y"));
        assert_eq!((values("b.twice")[0], values("b.some")[0], values("c.some")[0]), (12.0, 1.0, 0.0));
    }
    // Read once after each step: a step late for each component that is passed, and c is read for the record alone, when
    // its input has been set.
    let late = run(Algorithm::JacobiDelayed);
    assert_eq!(late.recording.column("c.y").unwrap().values, [20.0, 20.0, 20.0, 18.75, 17.5]);
}

#[test]
fn long_runs_keep_a_round_share_of_the_points() {
    let run = |step: f64, every| {
        pair(&SystemOptions { stop: Some(300.0), every, ..options(Algorithm::Jacobi, false, step) })
    };
    let thinned = run(0.001, None);
    assert_eq!((thinned.every, thinned.recording.times.len(), thinned.recording.steps), (5, 60_001, 300_000));
    assert_eq!(thinned.recording.times[1], 0.005);
    let full = run(0.01, None);
    assert_eq!((full.every, full.recording.times.len()), (1, 30_001));
    let asked = run(0.01, Some(7));
    // 30000 is no multiple of 7: the end is kept all the same.
    assert_eq!((asked.recording.times.len(), *asked.recording.times.last().unwrap()), (4287, 300.0));
}

/// The same system in other units: every digit is the same where the conversion is exact.
#[test]
fn times_and_values_of_a_file_may_have_units() {
    let text = PAIR.replace("w = 1.0", "w = \"1000 mrad/s\"");
    assert_ne!(text, PAIR);
    let plain = pair(&SystemOptions { stop: Some(0.5), step: Some(0.01), ..SystemOptions::default() });
    let times = "[experiment]\nstop = \"500 ms\"\nstep = \"0.01 s\"\n";
    let head = text.split("[experiment]").next().unwrap();
    let rest = text.find("[[component]]").map(|at| &text[at..]).unwrap();
    let text = format!("{}{times}{rest}", head.split("[[component]]").next().unwrap());
    let run =
        cosimulate(&Folder::new().toml(&text).unwrap(), &SystemOptions::default(), &mut |_| ()).unwrap();
    assert_eq!(run.recording.times, plain.recording.times);
    let speed = |run: &SystemRun| run.recording.column("rotor.speed").unwrap().values.clone();
    assert_eq!(speed(&run), speed(&plain));
}
