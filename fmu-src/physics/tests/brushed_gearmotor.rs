//! The gearmotor: the split against diffsol, the energy balance, the paper's numbers, limits with a known answer.

use crate::common::{turn_on_all_nodes, with_terms};
use crate::gearmotor::{Run, agrees, drive};
use physics::components::chopper::{Decay, ZeroDuty};
use physics::effects::Effects;
use physics::model::{Model, Slot};
use physics::models::brushed_gearmotor::{BrushedGearmotor, Inputs, NODES, Temperatures};
use physics::solver::split::{Fast, System};
use physics::terms::Port;

fn slot(m: &BrushedGearmotor, name: &str) -> Slot {
    m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot
}

fn get(m: &mut BrushedGearmotor, name: &str) -> f64 {
    let slot = slot(m, name);
    m.get(slot)
}

fn set(m: &mut BrushedGearmotor, name: &str, value: f64) {
    let slot = slot(m, name);
    assert!(m.set(slot, value), "{name} = {value}");
}

/// A gearmotor at this duty, started.
fn started(duty: f64) -> BrushedGearmotor {
    let mut m = BrushedGearmotor::default();
    m.inputs.duty = duty;
    m.start(0.0).unwrap();
    m
}

fn run(m: &mut BrushedGearmotor, steps: usize, h: f64) {
    for _ in 0..steps {
        m.step(m.time(), h).unwrap();
    }
}

/// All effects, the drags at sizes for the output shaft.
fn all_effects() -> Effects {
    let mut effects = Effects::examples();
    (effects.coulomb_friction.tau_c, effects.coulomb_friction.w_small) = (0.01, 0.05);
    effects.viscous_friction.k = 2e-3;
    effects.iron_loss.k = 5e-3;
    effects.windage.k = 2e-4;
    effects
}

/// Both duties of the paper, at the lower one fifteen minutes. The explicit reference needs a step for each time constant of the current,
/// so that with fast decay, which differs in the current only, it takes the first minute.
#[test]
fn duty_steps_against_the_reference() {
    let corner =
        |duty: fn(usize) -> Inputs, stop: f64, h: f64| Run { line: f64::INFINITY, corner: duty, stop, h };
    let full: fn(usize) -> Inputs = |_| Inputs { duty: 1.0, ..Inputs::default() };
    let low: fn(usize) -> Inputs = |_| Inputs { duty: 0.3, ..Inputs::default() };
    for (decay, long) in [(Decay::Slow, 900.0), (Decay::Fast, 60.0)] {
        let mut m = BrushedGearmotor::default();
        m.parameters.drive.decay = decay;
        agrees(m.clone(), &corner(full, 2.0, 1e-3), 1e-6, "full duty");
        agrees(m.clone(), &corner(low, 2.0, 1e-3), 1e-6, "low duty");
        agrees(m.clone(), &corner(low, long, 1.0), 1e-6, "warming");
    }
}

/// Everything on ramps, through the border of conduction and through zero.
#[test]
fn a_drive_cycle_against_the_reference() {
    for decay in [Decay::Slow, Decay::Fast] {
        let mut m = BrushedGearmotor::default();
        m.parameters.drive.decay = decay;
        let run = Run { line: 0.05, corner: drive, stop: 1.0, h: 1e-3 };
        agrees(m.clone(), &run, 1e-6, "drive cycle");
        m.parameters.gear.B = 3000.0;
        turn_on_all_nodes(&mut m);
        agrees(m.clone(), &run, 1e-6, "drive cycle with a gear of its own temperature");
        m.parameters.effects = all_effects();
        agrees(m.clone(), &run, 1e-6, "drive cycle with all effects");
        for effects in with_terms(Effects::default(), |port| port.is_fast()) {
            m.parameters.effects = effects;
            // A power of 0.7 of the speed has an infinite slope at standstill.
            agrees(m.clone(), &run, 2e-6, "drive cycle with terms");
        }
    }
}

/// The energy balance at every instant and over a run, in both decays, with and without effects, over every kind of step.
#[test]
fn the_books_close() {
    for decay in [Decay::Slow, Decay::Fast] {
        let with_terms = with_terms(Effects::default(), |port| port != Port::FanFlow);
        let with_terms = with_terms.into_iter().map(|effects| (effects, true));
        let others = [(Effects::default(), false), (all_effects(), true)];
        for (effects, all_nodes) in others.into_iter().chain(with_terms) {
            for h in [1e-3, 0.02] {
                let mut m = BrushedGearmotor::default();
                m.parameters.thermal.friction_to_gear = 0.8;
                if all_nodes {
                    turn_on_all_nodes(&mut m);
                }
                m.parameters.drive.decay = decay;
                m.parameters.effects = effects;
                m.start(0.0).unwrap();
                let (mut worst, mut throughput, mut least) = (0.0f64, 0.0f64, 0.0f64);
                for k in 0..(2.0 / h) as usize {
                    let t = k as f64 * h;
                    let mut drive = |name: &str, f: &dyn Fn(f64) -> f64| {
                        set(&mut m, name, f(t));
                        let slot = slot(&m, name);
                        m.set_slope(slot, (f(t + h) - f(t)) / h);
                    };
                    drive("duty", &|t| (7.0 * t).sin());
                    drive("supply_voltage", &|t| 12.0 + 4.0 * (5.0 * t).sin());
                    // Strong enough to drive the motor above its supply, where the bridge rectifies.
                    drive("load_torque", &|t| 12.0 * (3.0 * t).cos());
                    drive("ambient_temperature", &|t| 293.15 + 5.0 * t);
                    m.step(m.time(), h).unwrap();
                    let error = get(&mut m, "power_balance_error");
                    assert!(error.abs() <= 1e-6, "{decay:?} at {} s: {error} W", m.time());
                    worst = worst.max(get(&mut m, "energy_balance_error").abs());
                    throughput = throughput.max(get(&mut m, "energy_supply").abs());
                    least = least.min(get(&mut m, "supply_power"));
                }
                assert!(
                    throughput > 1.0 && least < -1.0,
                    "the bridge gives back: {least} W of {throughput} J"
                );
                assert!(worst <= 1e-6 * throughput, "{decay:?}: {worst} J of {throughput} J");
            }
        }
    }
}

/// The paper's quarter of an hour, with energies as sums of the powers, and every power flow of the energy balance.
#[test]
fn the_works_are_the_integrals_of_the_powers() {
    for duty in [0.3, 1.0] {
        let mut m = started(duty);
        run(&mut m, 20_000, 1e-4); // two seconds of running up are work, too
        let names = ["electrical", "magnetic", "mechanical", "total"];
        let look = |m: &mut BrushedGearmotor, what: &str| names.map(|n| get(m, &format!("{what}_{n}")));
        let (start, mut sums) = (look(&mut m, "work"), [0.0; 4]);
        let mut before = look(&mut m, "power");
        for _ in 0..898 {
            m.step(m.time(), 0.5).unwrap();
            let middle = look(&mut m, "power");
            m.step(m.time(), 0.5).unwrap();
            let after = look(&mut m, "power");
            for k in 0..4 {
                sums[k] += (before[k] + 4.0 * middle[k] + after[k]) / 6.0;
            }
            before = after;
        }
        let end = look(&mut m, "work");
        for k in [0, 2, 3] {
            let gained = end[k] - start[k];
            assert!((gained - sums[k]).abs() <= 1e-6 * gained, "{} {gained} {}", names[k], sums[k]);
        }
        let i = get(&mut m, "current");
        assert!((end[1] - 0.5 * 1.803e-3 * i * i).abs() < 1e-12);
        // What the supply gave stands in the motor's works and in the bridge.
        let given = get(&mut m, "energy_supply");
        assert!(end[3] < given && end[3] > 0.4 * given, "{} of {given} J", end[3]);
    }
}

/// Steady and cold: the winding held at 20 degC, as the paper evaluates its equations.
fn cold(duty: f64, change: impl Fn(&mut BrushedGearmotor)) -> BrushedGearmotor {
    let mut m = BrushedGearmotor::default();
    m.inputs.duty = duty;
    m.parameters.motor.alpha = 0.0;
    change(&mut m);
    m.start(0.0).unwrap();
    run(&mut m, 200, 0.1);
    m
}

fn near(found: f64, published: f64, relative: f64) {
    assert!((found - published).abs() <= relative * published, "{found} where {published} is published");
}

/// A consistency check of the fit and no prediction: drive.drop, motor.k_t, gear.tau_c and gear.k of the preset are fitted to these
/// published numbers (study, `reproduce::paper::FITTED`).
#[test]
fn the_preset_reproduces_the_numbers_of_its_fit() {
    let mut m = cold(1.0, |_| ());
    for (name, published) in [
        ("voltage", 9.7876),
        ("current", 0.1800),
        ("voltage_electrical", 1.656),
        ("voltage_mechanical", 8.132),
        ("power_electrical", 0.2981),
        ("power_mechanical", 1.4638),
    ] {
        near(get(&mut m, name), published, 3e-3);
    }
    near(get(&mut m, "shaft_speed") * 30.0 / std::f64::consts::PI, 77.7, 3e-3);
}

/// Published numbers that the preset is not fitted to: the inductive voltage is 0 and not the published 48.67 uV; the works of a
/// quarter of an hour with a warming winding, 1582.7 J in all and 267.79 J thermal; and by the balance of the supply, 12 V, the
/// bridge loses what the motor does not take.
#[test]
fn predictions_at_full_duty() {
    let mut m = cold(1.0, |_| ());
    assert!(get(&mut m, "voltage_magnetic").abs() < 1e-8, "no inductive voltage in steady state");
    let mut m = started(1.0);
    run(&mut m, 900, 1.0);
    near(get(&mut m, "work_total"), 1582.7, 3e-3);
    near(get(&mut m, "work_electrical"), 267.79, 0.06);
    let lost = get(&mut m, "energy_supply") - get(&mut m, "work_total");
    let by_hand = 2.2124 * get(&mut m, "current") * 900.0;
    near(lost, by_hand, 0.02);
}

/// Slope and r2 of the regression line of y over 20, 40, 60, 80, 100 %.
fn regression(y: [f64; 5]) -> (f64, f64) {
    let x = [20.0, 40.0, 60.0, 80.0, 100.0];
    let mean = y.iter().sum::<f64>() / 5.0;
    let sum = |f: &dyn Fn(usize) -> f64| (0..5).map(f).sum::<f64>();
    let (xy, yy) = (sum(&|k| (x[k] - 60.0) * (y[k] - mean)), sum(&|k| (y[k] - mean).powi(2)));
    (xy / 4000.0, xy * xy / (4000.0 * yy))
}

/// 91.62 mV and 1.04 mA per per cent of duty as published: gear.tau_c, gear.k and drive.pwm_frequency are fitted to them, so
/// that agreement is a consistency check. The published r2 of 0.9922 and 0.9991 are predictions, and not met.
#[test]
fn the_papers_slopes_over_the_duty() {
    let slopes = |change: fn(&mut BrushedGearmotor)| {
        let sweep = |name: &str| [0.2, 0.4, 0.6, 0.8, 1.0].map(|duty| get(&mut cold(duty, change), name));
        (regression(sweep("voltage")), regression(sweep("current")))
    };
    let preset = slopes(|_| ());
    near(preset.0.0, 91.62e-3, 0.01);
    near(preset.1.0, 1.04e-3, 0.01);
    assert!(preset.0.1 > 0.94 && preset.0.1 < 0.96, "r2 {}", preset.0.1);
    // Nothing fitted: all switches open at 976.56 Hz, pins 5 and 6 of the Arduino Uno, two diodes of 0.7 V.
    let fast = slopes(|m| {
        m.parameters.drive.decay = Decay::Fast;
        m.parameters.drive.pwm_frequency = 976.5625;
        m.parameters.drive.freewheel_drop = 1.4;
    });
    near(fast.0.0, 91.62e-3, 0.02);
    near(fast.1.0, 1.04e-3, 0.02);
    // Arduino's usual 490 Hz, and a frequency without discontinuous conduction, both miss.
    let arduino = slopes(|m| m.parameters.drive.pwm_frequency = 490.2);
    assert!(arduino.0.0 < 0.075, "{arduino:?}");
    let ideal = slopes(|m| {
        m.parameters.drive.pwm_frequency = 20e3;
        m.parameters.drive.freewheel_drop = 0.0;
    });
    near(ideal.0.0, 97.9e-3, 2e-3);
}

/// The border between discontinuous and continuous conduction shows in no output.
#[test]
fn no_jump_where_conduction_becomes_continuous() {
    let conducting = |duty: f64| get(&mut cold(duty, |_| ()), "conduction");
    let (mut low, mut high) = (0.3, 1.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if conducting(middle) < 1.0 { low = middle } else { high = middle }
    }
    assert!(low > 0.35 && high < 0.999, "{low}");
    for name in ["voltage", "current", "shaft_speed", "current_rms", "supply_power", "loss_drive"] {
        let at = |duty: f64| get(&mut cold(duty, |_| ()), name);
        let (below, above) = (at(low - 1e-6), at(high + 1e-6));
        assert!((below - above).abs() <= 1e-3 * below.abs(), "{name}: {below} {above}");
    }
}

/// Reverse is the mirror image; open switches let the motor coast.
#[test]
fn reverse_and_coasting() {
    let (mut forward, mut reverse) = (started(0.4), started(-0.4));
    forward.parameters.drive.zero_duty = ZeroDuty::Coast;
    run(&mut forward, 500, 1e-3);
    run(&mut reverse, 500, 1e-3);
    for name in ["voltage", "current", "shaft_speed", "shaft_angle"] {
        assert_eq!(get(&mut forward, name), -get(&mut reverse, name), "{name}");
    }
    assert_eq!(get(&mut forward, "energy_supply"), get(&mut reverse, "energy_supply"));
    set(&mut forward, "duty", 0.0);
    run(&mut forward, 20, 1e-3);
    assert!(get(&mut forward, "current").abs() < 1e-9 && get(&mut forward, "shaft_speed") > 1.0);
    let (v, e) = (get(&mut forward, "voltage"), get(&mut forward, "voltage_mechanical"));
    assert!((v - e).abs() < 1e-7, "the terminals of a coasting motor show its back-EMF: {v} {e}");
}

/// In the end all that the motor takes leaves through the box: T_h = T_a + P/G_ba + P/G_hb, P without the bridge.
#[test]
fn the_thermal_steady_state() {
    let mut m = started(1.0);
    run(&mut m, 400, 60.0);
    let p = get(&mut m, "power_total");
    let (w, h, b) = (
        get(&mut m, "winding_temperature"),
        get(&mut m, "housing_temperature"),
        get(&mut m, "box_temperature"),
    );
    assert!((b - 293.15 - p / 0.15).abs() < 1e-3, "{b}");
    assert!((h - b - p / 0.15).abs() < 1e-3, "{h}");
    assert!((w - h - 5.0 * get(&mut m, "loss_copper")).abs() < 1e-3, "{w}");
    let out = get(&mut m, "heat_to_ambient");
    assert!((out - get(&mut m, "supply_power")).abs() < 1e-4, "no load: all power becomes heat");
}

/// A driven load takes its torque through the gear's efficiency: K I = tau_c + k w + load/efficiency.
#[test]
fn a_load_costs_more_than_itself() {
    let mut m = cold(1.0, |m| m.inputs.load_torque = 0.2);
    let (w, i, k) = (get(&mut m, "shaft_speed"), get(&mut m, "current"), get(&mut m, "torque_constant"));
    assert!((k * i - (0.0769 + 0.01267 * w + 0.2 / 0.73)).abs() < 1e-6);
    near(get(&mut m, "shaft_power"), 0.2 * w, 1e-12);
}

/// Taken back, the motor goes the same way again, to the bit; saved as numbers, too.
#[test]
fn a_rollback_is_exact() {
    let mut m = BrushedGearmotor::default();
    m.inputs.duty = 0.7;
    m.parameters.effects = all_effects();
    m.start(0.0).unwrap();
    run(&mut m, 30, 1e-3);
    let mut saved = Vec::new();
    m.save(&mut saved);
    let mut bits = || {
        for k in 0..40 {
            set(&mut m, "duty", 0.5 - 0.03 * f64::from(k));
            let slot = slot(&m, "duty");
            m.set_slope(slot, -30.0);
            m.step(m.time(), 1e-3).unwrap();
        }
        let bits: Vec<u64> = m.state().to_numbers().chain([m.time()]).map(f64::to_bits).collect();
        assert!(m.restore(&saved));
        bits
    };
    assert_eq!(bits(), bits());
}

/// The matrices that the integrator freezes, with every effect on and both kinds of conduction, against differences.
#[test]
fn the_matrices_are_the_derivatives() {
    let with_terms = with_terms(all_effects(), |port| port.is_fast());
    let cases = with_terms.into_iter().chain([all_effects()]);
    for (duty, effects) in cases.flat_map(|effects| [(0.4, effects), (1.0, effects)]) {
        let mut m = BrushedGearmotor::default();
        m.parameters.effects = effects;
        m.parameters.gear.B = 3000.0;
        turn_on_all_nodes(&mut m);
        (m.inputs.duty, m.inputs.load_torque) = (duty, 0.05);
        m.start(0.0).unwrap();
        let step = m.step_equations();
        let temperature = Temperatures::from_fn(|k, _| [390.0, 340.0, 300.0, 360.0][k % 4]);
        let x = Fast::new(0.03, 0.6);
        for k in 0..2 {
            let mut by = Fast::zeros();
            by[k] = 1e-5;
            let rates = |x: Fast| step.fast_rates(0.0, &x, &temperature);
            let found = step.fast_matrix(0.0, &x, &temperature).column(k) * 2e-5;
            let wanted = rates(x + by) - rates(x - by);
            assert!((found - wanted).norm() <= 1e-6 * wanted.norm(), "{found} {wanted}");
        }
        for k in 0..NODES {
            let mut by = Temperatures::zeros();
            by[k] = 1e-2;
            let rates = |t: Temperatures| step.network_rates(0.0, &t);
            let found = step.network_matrix(0.0, &temperature).column(k) * 2e-2;
            let wanted = rates(temperature + by) - rates(temperature - by);
            assert!((found - wanted).norm() <= 1e-6 * wanted.norm(), "{found} {wanted}");
        }
    }
}

/// A parameter tuned on the way puts no energy into the energy balance.
#[test]
fn tuning_a_parameter_keeps_the_books() {
    let mut m = started(0.8);
    run(&mut m, 100, 0.1);
    for (name, value) in [("thermal.C_h", 170.0), ("motor.J", 8e-6), ("motor.L", 4e-3)] {
        set(&mut m, name, value);
        run(&mut m, 100, 0.1);
    }
    let error = get(&mut m, "energy_balance_error");
    assert!(error.abs() < 1e-6 * get(&mut m, "energy_supply"), "{error} J");
}
