//! The hot spot at stall against three phases that are written out here and integrated by Runge and Kutta's method.

use crate::common::motor;
use physics::components::commutation::Commutation;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::terms::{GenericTerm, Law, Port, Product};

fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap().slot;
    m.get(slot)
}

/// What the reference adds to the declared motor.
#[derive(Clone, Copy, Default)]
struct Losses {
    /// Contact voltage, V.
    contacts: f64,
    /// Relative change of R_wh per kelvin of the winding above 298.15 K.
    beta: f64,
    /// Conductance from winding to ambient, W/K.
    winding_to_ambient: f64,
    /// Relative change of the winding's resistance.
    resistance: f64,
    /// Heat beside that of the current, W, shared as the copper loss.
    heat: f64,
}

/// Temperatures of the three phases and the housing after `seconds` of the current `i`, A, at stall with block commutation:
/// phase 0 carries none of it. The declared values of the motor, typed once more.
fn reference(i: f64, seconds: f64, losses: Losses) -> [f64; 4] {
    const AMBIENT: f64 = 298.15;
    let rates = |t: &[f64; 4]| {
        let mean = (t[0] + t[1] + t[2]) / 3.0;
        let r_wh = 0.21 * (1.0 + losses.beta * (mean - 298.15));
        let resistance = |t: f64| 0.386 * (1.0 + 0.0039 * (t - 298.15)) * (1.0 + losses.resistance);
        let shared = losses.contacts * i + losses.heat;
        let mut out = [0.0; 4];
        for k in 0..3 {
            // Two phases in series: each is half of the resistance between the terminals.
            let own = if k == 0 { 0.0 } else { 0.5 * (resistance(t[k]) * i * i + shared) };
            let lost = losses.winding_to_ambient * (t[k] - AMBIENT) / 3.0;
            let across = (t[k] - t[3]) / (3.0 * r_wh);
            out[k] = (own - across - lost) / (10.05 / 3.0);
            out[3] += across;
        }
        out[3] = (out[3] - 0.1351 * (t[3] - AMBIENT)) / 149.4;
        out
    };
    let along = |t: &[f64; 4], r: &[f64; 4], h: f64| std::array::from_fn::<f64, 4, _>(|k| t[k] + h * r[k]);
    let (mut t, n) = ([AMBIENT; 4], 4000);
    let h = seconds / f64::from(n);
    for _ in 0..n {
        let a = rates(&t);
        let b = rates(&along(&t, &a, 0.5 * h));
        let c = rates(&along(&t, &b, 0.5 * h));
        let d = rates(&along(&t, &c, h));
        t = std::array::from_fn(|k| t[k] + h / 6.0 * (a[k] + 2.0 * b[k] + 2.0 * c[k] + d[k]));
    }
    t
}

fn stalled(i: f64, losses: Losses) -> AnnulusCooledMotor {
    let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
    m.parameters.choices.commutation = Commutation::Block;
    let effects = &mut m.parameters.effects;
    effects.contact_drop.V_b = losses.contacts;
    effects.interface_temperature.beta = losses.beta;
    effects.forced_convection.G = losses.winding_to_ambient;
    effects.forced_convection.node = physics::effects::CooledNode::Winding;
    let term =
        |port, coefficient| GenericTerm::new(port, Law::Product(Product { coefficient, factors: [None; 3] }));
    let terms = [term(Port::WindingResistance, losses.resistance), term(Port::WindingHeat, losses.heat)];
    let acting: Vec<GenericTerm> = terms
        .into_iter()
        .zip([losses.resistance, losses.heat])
        .filter(|(_, c)| *c != 0.0)
        .map(|(t, _)| t)
        .collect();
    if !acting.is_empty() {
        assert!(m.set_terms(&acting));
    }
    m.inputs.current_command = i;
    m.start(0.0).unwrap();
    m
}

/// How far the hot spot is above the mean winding, over what the reference says, less 1.
fn off(i: f64, seconds: f64, h: f64, losses: Losses) -> f64 {
    let mut m = stalled(i, losses);
    for k in 0..(seconds / h).round() as usize {
        m.step(k as f64 * h, h).unwrap();
    }
    let hottest = output(&mut m, "winding_hot_spot_temperature");
    let excess = hottest - m.state().temperature[0];
    let t = reference(i, seconds, losses);
    let mean = (t[0] + t[1] + t[2]) / 3.0;
    assert!((m.state().temperature[0] - mean).abs() < 2e-4 * (mean - 298.15), "{i} A: mean {mean}");
    excess / (t[1] - mean) - 1.0
}

#[test]
fn a_phase_s_own_losses() {
    for i in [2.0, 5.0, 10.0, 20.0] {
        for seconds in [0.5, 2.0, 20.0] {
            let off = off(i, seconds, 1e-3, Losses::default());
            assert!(off.abs() < 1e-5, "{i} A, {seconds} s: {off}");
        }
    }
}

#[test]
fn contacts_terms_and_the_resistance_that_acts() {
    let none = Losses::default();
    for losses in [
        Losses { contacts: 0.8, ..none },
        Losses { beta: 0.004, ..none },
        Losses { winding_to_ambient: 0.5, ..none },
        Losses { resistance: 0.15, ..none },
        Losses { heat: 12.0, ..none },
        Losses { contacts: 0.8, beta: -0.002, winding_to_ambient: 0.3, resistance: -0.1, heat: 5.0 },
    ] {
        for i in [5.0, 20.0] {
            let off = off(i, 10.0, 1e-3, losses);
            assert!(off.abs() < 2e-5, "{i} A: {off}");
        }
    }
}

/// Steps of the size of the winding's time constant: the excess that acts on the resistance is that of the step's middle.
#[test]
fn long_steps_are_of_second_order() {
    let at = |h: f64| off(20.0, 8.0, h, Losses::default()).abs();
    let (coarse, fine) = (at(0.5), at(0.25));
    assert!(coarse < 2e-3 && fine < 0.35 * coarse, "{coarse} {fine}");
}

/// The ripple of a chopped current heats the phases that carry it.
#[test]
fn ripple_heats_the_phases_that_carry_it() {
    let hot = |f: f64| {
        let mut m = motor(DriveMode::Pwm, MechanicalMode::ImposedSpeed);
        m.parameters.choices.commutation = Commutation::Block;
        m.parameters.effects.pwm_ripple.f = f;
        (m.inputs.voltage, m.inputs.duty) = (48.0, 0.05);
        m.start(0.0).unwrap();
        for k in 0..2000 {
            m.step(f64::from(k) * 1e-3, 1e-3).unwrap();
        }
        let copper = output(&mut m, "loss_copper");
        ((output(&mut m, "winding_hot_spot_temperature") - m.state().temperature[0]) / copper, copper)
    };
    let ((smooth, less), (rippled, more)) = (hot(0.0), hot(4000.0));
    assert!(more > 1.1 * less, "{less} W and {more} W");
    assert!((rippled / smooth - 1.0).abs() < 0.01, "{rippled} and {smooth} K/W");
}
