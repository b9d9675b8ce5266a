//! A fan at rest, or slow, before an annulus: buoyancy, air at rest, and the way to the forced flow.

use physics::components::housing::Orientation;
use physics::model::Model;
use physics::models::annulus_cooled_motor::cooling::{Coefficients, Conditions, Cooling};
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, Inputs};

/// Segments of the housing.
const N: usize = 8;
const AMBIENT: f64 = 298.15;
const MODES: [CoolingMode; 2] = [CoolingMode::AnnulusPush, CoolingMode::AnnulusPull];
const ORIENTATIONS: [Orientation; 2] = [Orientation::Horizontal, Orientation::Vertical];

fn cooled(mode: CoolingMode, orientation: Orientation) -> AnnulusCooledMotor {
    let mut m = AnnulusCooledMotor::default();
    m.parameters.choices.cooling_mode = mode;
    m.parameters.housing.orientation = orientation;
    m
}

fn coefficients(m: &AnnulusCooledMotor, surface: f64, tube: f64, command: f64) -> Coefficients {
    let inputs = Inputs { fan_command: command, ..Inputs::default() };
    let at = Conditions::of(&inputs, surface, tube, AMBIENT);
    Cooling::new(&m.parameters, N).coefficients(&m.parameters, &at)
}

/// Heat from the covered housing at `surface` to the air and a tube at `tube`, W, and the outlet temperature, K.
fn given(c: &Coefficients, surface: f64, tube: f64) -> (f64, f64) {
    let (mut air, mut heat) = (c.inlet(AMBIENT), 0.0);
    for k in 0..N {
        let wall = tube + c.share[k] * (surface - tube);
        let taken = c.effectiveness[k] * (wall - air);
        heat += c.share[k] * (c.film_conductance[k] * (surface - wall) + c.m_flow_cp * taken);
        air += taken;
    }
    (heat, AMBIENT + c.behind * (air - AMBIENT))
}

fn output(m: &mut AnnulusCooledMotor, name: &str) -> f64 {
    let slot = m.declaration().by_name(name).unwrap().slot;
    m.get(slot)
}

/// Rise of the winding at 10 W, K, and the excess of the air behind the motor.
fn steady(mode: CoolingMode, orientation: Orientation, command: f64) -> (f64, f64) {
    let mut m = cooled(mode, orientation);
    m.parameters.choices.drive_mode = DriveMode::Power;
    (m.inputs.electrical_power, m.inputs.fan_command) = (10.0, command);
    m.start(0.0).unwrap();
    for _ in 0..60 {
        m.step(m.time(), 600.0).unwrap();
    }
    assert!(output(&mut m, "power_balance_error").abs() < 1e-6);
    (output(&mut m, "winding_temperature") - AMBIENT, output(&mut m, "air_outlet_temperature") - AMBIENT)
}

/// An upright gap with its fan at rest, an isothermal motor and an insulated tube, is the channel of Bar-Cohen and Rohsenow,
/// J. Heat Transfer 106 (1984) 116, table 1, one wall isothermal and one adiabatic:
/// Nu = [144/Ra''^2 + 2.873/Ra''^(1/2)]^(-1/2), Nu = q b/(A k (T - T_a)), Ra'' = g beta (T - T_a) b^4/(L nu alpha), within 15 %: from developed flow (tall and narrow) to boundary layers (short and wide).
#[test]
fn an_upright_gap_at_rest_is_a_channel_open_at_both_ends() {
    // A small rise, so that the temperature at which properties are taken does not matter.
    for (gap, length, surface) in [
        (0.003, 0.4, 303.15),
        (0.005, 0.4, 303.15),
        (0.008, 0.4, 303.15),
        (0.008, 0.1, 303.15),
        (0.012, 0.1, 303.15),
        (0.020, 0.1, 303.15),
    ] {
        let mut m = cooled(CoolingMode::AnnulusPull, Orientation::Vertical);
        let p = &mut m.parameters;
        // A large motor: the gap is nearly plane.
        (p.housing.diameter, p.housing.length, p.cooling.annulus.length) = (0.3, length, length);
        p.cooling.annulus.outer_diameter = 0.3 + 2.0 * gap;
        p.cooling.fan.bore = 1.0;
        // The air heats the insulated tube to its own temperature, and the tube takes nothing: all heat comes from the motor.
        let mut tube = AMBIENT;
        let mut heat = 0.0;
        for _ in 0..200 {
            let c = coefficients(&m, surface, tube, 0.0);
            let (from_motor, _) = given(&c, surface, tube);
            let (mut air, mut to_tube) = (AMBIENT, 0.0);
            for k in 0..N {
                let wall = tube + c.share[k] * (surface - tube);
                let taken = c.effectiveness[k] * (wall - air);
                to_tube -= (1.0 - c.share[k]) * (c.film_conductance[k] * (tube - wall) + c.m_flow_cp * taken);
                air += taken;
            }
            heat = from_motor;
            let films: f64 = c.film_conductance[..N].iter().sum();
            tube += 0.5 * to_tube / (0.25 * films + 1e-9);
        }
        let film = physics::media::air::Air::at(0.5 * (surface + AMBIENT), 101_325.0);
        let area = std::f64::consts::PI * 0.3 * length;
        let nu = heat * gap / (area * film.k * (surface - AMBIENT));
        let ra = film.rayleigh(surface - AMBIENT, gap, 9.80665) * gap / length;
        let expected = (144.0 / (ra * ra) + 2.873 / ra.sqrt()).powf(-0.5);
        println!(
            "gap {gap} m, length {length} m: Ra'' {ra:.1}, Nu {nu:.3}, {expected:.3} by Bar-Cohen and Rohsenow"
        );
        assert!((nu / expected - 1.0).abs() < 0.15, "gap {gap} m, length {length} m: {nu} and {expected}");
    }
}

/// In a horizontal gap at rest heat passes to the tube as between concentric cylinders: 2 pi k_eff L/ln(D_o/D_i).
#[test]
fn a_horizontal_gap_at_rest_conducts_and_circulates() {
    for (outer, circulates) in [(0.040, false), (0.080, true)] {
        let mut m = cooled(CoolingMode::AnnulusPush, Orientation::Horizontal);
        m.parameters.cooling.annulus.outer_diameter = outer;
        let (surface, tube) = (400.0, 330.0);
        let c = coefficients(&m, surface, tube, 0.0);
        assert_eq!((c.m_flow_cp, c.flow, c.pressure_drop), (0.0, 0.0, 0.0));
        let (heat, outlet) = given(&c, surface, tube);
        assert_eq!(outlet, AMBIENT, "no flow leaves the gap");
        let k = physics::media::air::conductivity(0.5 * (surface + tube));
        let still = 2.0 * std::f64::consts::PI * k * 0.064 * (surface - tube) / (outer / 0.030f64).ln();
        let ratio = heat / still;
        assert!(if circulates { ratio > 1.3 } else { (ratio - 1.0).abs() < 1e-9 }, "{outer} m: {ratio}");
    }
}

/// Heat, flow and outlet temperature pass without a jump from the fan at rest to full speed, in both orientations and
/// directions, and where the motor is at the ambient temperature.
#[test]
fn from_rest_to_full_flow_nothing_jumps() {
    for mode in MODES {
        for orientation in ORIENTATIONS {
            for (leak, surface) in [(0.0, 350.0), (1.6e-3, 350.0), (0.0, AMBIENT + 1e-6), (0.0, 280.0)] {
                let mut m = cooled(mode, orientation);
                m.parameters.cooling.annulus.leak_area = leak;
                m.parameters.cooling.fan.power = 0.0;
                let tube = AMBIENT + 0.4 * (surface - AMBIENT);
                let at = |command: f64| {
                    let c = coefficients(&m, surface, tube, command);
                    let (heat, outlet) = given(&c, surface, tube);
                    [heat / (surface - AMBIENT), 1e3 * c.flow, (outlet - AMBIENT) / (surface - AMBIENT)]
                };
                let mut before = at(0.0);
                let full = at(1.0);
                let mut command: f64 = 1e-9;
                while command < 1.0 {
                    let now = at(command);
                    for k in 0..3 {
                        let jump = (now[k] - before[k]).abs();
                        let size = full[k].abs().max(before[k].abs());
                        assert!(
                            jump <= 0.1 * size,
                            "{mode:?} {orientation:?} {leak} {surface} {command}: {k} {before:?} {now:?}"
                        );
                    }
                    (before, command) = (now, command * 1.05);
                }
            }
        }
    }
}

/// A failed fan: a horizontal motor in its tube is hotter than without a tube, an upright one is cooled by the chimney. The fan
/// that starts cools from the first turns on.
#[test]
fn a_failed_fan() {
    for mode in MODES {
        let bare = steady(CoolingMode::Bare, Orientation::Horizontal, 0.0).0;
        let (lying, outlet) = steady(mode, Orientation::Horizontal, 0.0);
        let (upright, warm) = steady(mode, Orientation::Vertical, 0.0);
        println!(
            "{mode:?}: bare {bare:.1} K, horizontal {lying:.1} K, outlet {outlet:.1} K, vertical {upright:.1} K, outlet {warm:.1} K"
        );
        assert_eq!(outlet, 0.0, "no flow");
        assert!(lying > bare && lying < bare + 40.0, "horizontal {lying} K, bare {bare} K");
        assert!(upright < lying - 15.0, "vertical {upright} K");
        assert!(warm > 5.0 && warm < upright, "outlet {warm} K");
        let mut before = upright;
        for command in [0.05, 0.2, 1.0] {
            let (now, _) = steady(mode, Orientation::Vertical, command);
            assert!(now < before, "{command}: {now} K after {before} K");
            before = now;
        }
    }
}
