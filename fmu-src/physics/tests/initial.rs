//! Initial states that are set: a run goes on from the states of another one, a hot motor cools down, and a value outside the
//! limits of validity is refused.

use crate::common::{busy_inputs, cooling_modes, motor, network_modes, turn_on_all_nodes};
use physics::effects::Effects;
use physics::model::{Model, Slot};
use physics::models::annulus_cooled_motor::cooling::method;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, CoolingMode, DriveMode, MechanicalMode};
use physics::models::brushed_gearmotor::BrushedGearmotor;
use physics::terms::{Driver, Factor, GenericTerm, Lag, Law, Port, Product};

fn slot(m: &dyn Model, name: &str) -> Slot {
    m.declaration().by_name(name).unwrap_or_else(|| panic!("no variable {name}")).slot
}

fn get(m: &mut dyn Model, name: &str) -> f64 {
    m.get(slot(m, name))
}

fn set(m: &mut dyn Model, name: &str, value: f64) {
    assert!(m.set(slot(m, name), value), "{name}");
}

/// Names of an initial value and of its state.
type Pair = (&'static str, &'static str);

/// Initial values and the states that they belong to; the housing is one segment, or the core where it has none.
const OF_MOTOR: [Pair; 10] = [
    ("initial.current", "state.current"),
    ("initial.shaft_speed", "state.shaft_speed"),
    ("initial.shaft_angle", "state.shaft_angle"),
    ("initial.winding_temperature", "state.winding_temperature"),
    ("initial.stator_temperature", "state.core_temperature"),
    ("initial.magnet_temperature", "state.rotor_temperature"),
    ("initial.tube_temperature", "state.tube_temperature"),
    ("initial.sensor_temperature", "state.sensor_temperature"),
    ("initial.winding_sensor_temperature", "state.winding_sensor_temperature"),
    ("initial.housing_temperature", "T_housing[1]"),
];

/// Those of the gearmotor, whose names differ in the prefix only.
fn of_gearmotor() -> Vec<Pair> {
    let declaration = BrushedGearmotor::default().declaration();
    let initial = declaration.entries.iter().filter_map(|e| Some((e, e.name.strip_prefix("initial.")?)));
    // Those of lags are relative to their drivers.
    let initial = initial.filter(|(_, own)| !own.starts_with("term_lag"));
    let state =
        |own: &str| declaration.by_name(&format!("state.{own}")).unwrap_or_else(|| panic!("no state.{own}"));
    initial.map(|(entry, own)| (entry.name.as_str(), state(own).name.as_str())).collect()
}

/// A motor with one segment in these modes, away from rest.
fn busy(
    drive: DriveMode,
    mechanical: MechanicalMode,
    cooling: CoolingMode,
    effects: Effects,
) -> AnnulusCooledMotor {
    let mut m = motor(drive, mechanical);
    m.parameters.choices.cooling_mode = cooling;
    m.parameters.choices.air_segments = 1;
    m.parameters.effects = effects;
    m.inputs = busy_inputs();
    m.inputs.voltage = 12.0;
    m.inputs.duty = 0.9;
    m.inputs.current_command = 6.0;
    m.inputs.electrical_power = 40.0;
    m.inputs.imposed_speed = 300.0;
    m.inputs.load_torque = 0.02;
    m.inputs.fan_command = 0.7;
    m.inputs.ambient_temperature = 291.0;
    m
}

/// Every model in modes of all kinds, with the initial values of its states and a name.
fn cases() -> Vec<(Box<dyn Model>, Vec<Pair>, String)> {
    let mut all: Vec<(Box<dyn Model>, Vec<Pair>, String)> = Vec::new();
    for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
        for mechanical in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
            for cooling in cooling_modes() {
                for (effects, name) in
                    [(Effects::default(), "no effect"), (Effects::examples(), "all effects")]
                {
                    let m = busy(drive, mechanical, cooling, effects);
                    let mut pairs = OF_MOTOR.to_vec();
                    if !method(cooling).has_network() && name == "no effect" {
                        pairs.retain(|(initial, _)| {
                            !initial.contains("stator") && !initial.contains("magnet")
                        });
                        pairs.last_mut().unwrap().1 = "state.core_temperature";
                    }
                    all.push((Box::new(m), pairs, format!("{drive:?} {mechanical:?} {cooling:?} {name}")));
                }
            }
        }
    }
    for duty in [0.3, 1.0] {
        let mut m = BrushedGearmotor::default();
        m.inputs.duty = duty;
        m.inputs.load_torque = 0.1;
        m.inputs.ambient_temperature = 285.0;
        m.parameters.gear.B = 3000.0;
        turn_on_all_nodes(&mut m);
        all.push((Box::new(m), of_gearmotor(), format!("gearmotor at duty {duty}")));
    }
    all
}

/// A second instance that starts at `time` in the states of `first`.
fn continued(first: &mut dyn Model, fresh: &dyn Model, pairs: &[(&str, &str)], time: f64) -> Box<dyn Model> {
    let mut second = fresh.boxed_clone();
    for (initial, state) in pairs {
        set(second.as_mut(), initial, get(first, state));
    }
    second.start(time).unwrap();
    second
}

/// The states that change in the present modes, but for the energies, which count from the start of each run: name, value
/// and size.
fn states(m: &mut dyn Model) -> Vec<(String, f64, f64)> {
    let declaration = m.declaration();
    let mut all = Vec::new();
    for [state, rate] in declaration.states.iter().map(|pair| pair.map(|k| &declaration.entries[k])) {
        if state.row.unit != declare::Unit::Joule && m.get(rate.slot) != 0.0 {
            all.push((state.name.clone(), m.get(state.slot), state.row.nominal));
        }
    }
    all
}

fn assert_same(first: &mut dyn Model, second: &mut dyn Model, what: &str) {
    let (one, other) = (states(first), states(second));
    assert!(one.len() >= 2 && one.len() == other.len(), "{what}: {one:?} and {other:?}");
    for ((name, one, nominal), (_, other, _)) in one.into_iter().zip(other) {
        let tolerance = 1e-9 * one.abs().max(nominal);
        assert!((one - other).abs() <= tolerance, "{what}: {name}: {one} and {other}");
    }
}

#[test]
fn a_run_goes_on_from_the_states_of_another() {
    const H: f64 = 1e-3;
    for (mut first, pairs, what) in cases() {
        let fresh = first.boxed_clone();
        first.start(0.0).unwrap();
        for k in 0..200 {
            first.step(f64::from(k) * 0.1, 0.1).unwrap();
        }
        let stop = first.time();
        let mut second = continued(first.as_mut(), fresh.as_ref(), &pairs, stop);
        assert_same(first.as_mut(), second.as_mut(), &what);
        for k in 0..400 {
            for m in [&mut first, &mut second] {
                m.step(stop + f64::from(k) * H, H).unwrap();
            }
        }
        assert_same(first.as_mut(), second.as_mut(), &what);
        // The energies of the second run count from its own start.
        assert!(get(second.as_mut(), "energy_balance_error").abs() < 1e-6, "{what}");
    }
}

/// Lags of a temperature, of a speed and of a heat flow start where those of another run are, which its driver does not tell.
#[test]
fn a_run_goes_on_from_the_lags_of_its_terms() {
    let term = |port: Port, driver: Driver, coefficient: f64, tau: f64, difference: bool| {
        let factor = Factor { driver, offset: 0.0, reference: 1.0, exponent: 1.0, range: Factor::UNLIMITED };
        let law = Law::Product(Product { coefficient, factors: [Some(factor), None, None] });
        GenericTerm { lag: Some(Lag { driver, tau, difference }), ..GenericTerm::new(port, law) }
    };
    let terms = [
        term(Port::HousingHeat, Driver::HousingTemperature, 0.4, 90.0, true),
        term(Port::DragTorque, Driver::Speed, 1e-5, 7.0, false),
        term(Port::WindingHeat, Driver::CopperLoss, 0.1, 30.0, false),
    ];
    let of_motor = |cooling: CoolingMode| -> (Box<dyn Model>, Vec<Pair>, String) {
        let motor = busy(DriveMode::Voltage, MechanicalMode::FreeShaft, cooling, Effects::default());
        let mut pairs = OF_MOTOR.to_vec();
        if !method(cooling).has_network() {
            pairs.last_mut().unwrap().1 = "state.core_temperature";
        }
        (Box::new(motor), pairs, format!("{cooling:?}"))
    };
    let mut gearmotor = BrushedGearmotor::default();
    (gearmotor.inputs.duty, gearmotor.inputs.load_torque) = (0.7, 0.2);
    let of_gearmotor: (Box<dyn Model>, _, _) = (Box::new(gearmotor), of_gearmotor(), "gearmotor".to_string());
    for (mut fresh, pairs, what) in cooling_modes().map(of_motor).chain([of_gearmotor]) {
        assert!(fresh.set_terms(&terms));
        let mut first = fresh.boxed_clone();
        first.start(0.0).unwrap();
        for k in 0..200 {
            first.step(f64::from(k) * 0.1, 0.1).unwrap();
        }
        let (stop, drivers) = (first.time(), first.drivers());
        let mut go_on = |lags: bool| {
            let mut fresh = fresh.boxed_clone();
            for (k, term) in terms.iter().enumerate().filter(|_| lags) {
                let driver = term.lag.unwrap().driver;
                let state = get(first.as_mut(), &format!("state.term_lag[{}]", k + 1));
                let above = state - drivers.of(driver) / driver.nominal();
                set(fresh.as_mut(), &format!("initial.term_lag_{}", k + 1), above);
            }
            let mut second = continued(first.as_mut(), fresh.as_ref(), &pairs, stop);
            for k in 0..100 {
                second.step(stop + f64::from(k) * 0.1, 0.1).unwrap();
            }
            second
        };
        let [mut with, mut without] = [true, false].map(&mut go_on);
        for k in 0..100 {
            first.step(stop + f64::from(k) * 0.1, 0.1).unwrap();
        }
        assert_same(first.as_mut(), with.as_mut(), &what);
        assert!(get(with.as_mut(), "energy_balance_error").abs() < 1e-6, "{what}");
        let housing = |m: &mut dyn Model| get(m, "housing_temperature");
        let apart = housing(first.as_mut()) - housing(without.as_mut());
        assert!(apart.abs() > 1e-3, "{what}: lags that start at their drivers differ by {apart} K only");
    }
}

#[test]
fn an_integration_by_an_importer_goes_on_as_well() {
    const H: f64 = 2e-5;
    for (mut first, pairs, what) in cases() {
        first.enter_model_exchange();
        let fresh = first.boxed_clone();
        first.start(0.0).unwrap();
        let count = first.declaration().states.len();
        // Explicit Euler steps: the same steps of the same equations.
        let go = |m: &mut dyn Model, from: u32, to: u32| {
            let (mut x, mut rates) = (vec![0.0; count], vec![0.0; count]);
            for k in from..to {
                m.read_states(&mut x);
                m.derivatives(&mut rates).unwrap();
                for (x, rate) in x.iter_mut().zip(&rates) {
                    *x += H * rate;
                }
                m.write_time(f64::from(k + 1) * H);
                m.write_states(&x);
                m.accept_step();
            }
        };
        go(first.as_mut(), 0, 500);
        let mut second = continued(first.as_mut(), fresh.as_ref(), &pairs, 500.0 * H);
        first.update();
        assert_same(first.as_mut(), second.as_mut(), &what);
        go(first.as_mut(), 500, 1000);
        go(second.as_mut(), 500, 1000);
        assert_same(first.as_mut(), second.as_mut(), &what);
    }
}

/// Each node alone starts at its value, all others at the ambient temperature.
#[test]
fn a_node_without_a_value_starts_at_the_ambient_temperature() {
    let nodes = || OF_MOTOR.iter().filter(|(of, _)| of.ends_with("temperature") && !of.contains("sensor"));
    for (mode, (hot, _)) in network_modes().flat_map(|mode| nodes().map(move |pair| (mode, pair))) {
        let mut m = busy(DriveMode::Power, MechanicalMode::ImposedSpeed, mode, Effects::default());
        if *hot == "initial.tube_temperature" && method(mode).tube_capacity(&m.parameters) == 0.0 {
            continue;
        }
        set(&mut m, hot, 333.0);
        m.start(0.0).unwrap();
        for (initial, state) in OF_MOTOR.iter().filter(|(name, _)| name.ends_with("temperature")) {
            let follows = *initial == "initial.sensor_temperature" && *hot == "initial.housing_temperature";
            let expected = if initial == hot || follows { 333.0 } else { 291.0 };
            if *initial != "initial.sensor_temperature" {
                assert_eq!(get(&mut m, state), expected, "{mode:?} {hot}: {state}");
            }
        }
        let housing = if hot.contains("housing") { 333.0 } else { 291.0 };
        assert_eq!(get(&mut m, "housing_temperature"), housing, "{mode:?} {hot}");
    }
}

/// Inputs that impose a current or a speed do so from the start on.
#[test]
fn imposed_quantities_are_no_states() {
    let mut m =
        busy(DriveMode::Current, MechanicalMode::ImposedSpeed, CoolingMode::Conductance, Effects::default());
    for name in ["initial.current", "initial.shaft_speed"] {
        set(&mut m, name, 77.0);
    }
    set(&mut m, "initial.shaft_angle", 5.0);
    m.start(0.0).unwrap();
    assert_eq!(["current", "shaft_speed", "shaft_angle"].map(|name| get(&mut m, name)), [6.0, 300.0, 5.0]);
}

#[test]
fn a_hot_motor_cools_down_to_the_ambient_temperature() {
    for cooling in cooling_modes() {
        let mut m = motor(DriveMode::Power, MechanicalMode::ImposedSpeed);
        m.parameters.choices.cooling_mode = cooling;
        m.inputs = busy_inputs();
        m.inputs.coolant_inlet_temperature = 295.0;
        m.inputs.ambient_temperature = 295.0;
        for name in ["winding", "stator", "magnet", "housing"] {
            set(&mut m, &format!("initial.{name}_temperature"), 400.0);
        }
        m.start(0.0).unwrap();
        let mut before = get(&mut m, "winding_temperature");
        assert_eq!(before, 400.0);
        for k in 0..1000 {
            m.step(f64::from(k) * 30.0, 30.0).unwrap();
            let now = get(&mut m, "winding_temperature");
            assert!(now <= before + 1e-6 && now > 295.0 - 1e-6, "{cooling:?}: {now} K after {before} K");
            before = now;
        }
        // A fan that pushes warms the air by some tenths of a kelvin.
        assert!(before - 295.0 < 0.5, "{cooling:?}: {before} K");
        // All heat above this has left, and no other.
        let left = get(&mut m, "energy_heat_to_ambient");
        let [c_w, c_h] = [m.parameters.thermal.C_w, m.parameters.thermal.C_h];
        let stored = (c_w + c_h) * (400.0 - 295.0);
        assert!((left / stored - 1.0).abs() < 5e-3, "{cooling:?}: {left} J of {stored} J");
        assert!(get(&mut m, "energy_balance_error").abs() < 1e-6, "{cooling:?}");
    }
}

/// Energies of an initial speed and current are energies at the start and not from the terminals.
#[test]
fn a_flywheel_runs_down_within_its_energy_balance() {
    let mut m = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    m.parameters.effects.viscous_friction.k = 1e-6;
    set(&mut m, "initial.shaft_speed", 500.0);
    set(&mut m, "initial.current", 2.0);
    m.start(0.0).unwrap();
    assert_eq!(["current", "shaft_speed"].map(|name| get(&mut m, name)), [2.0, 500.0]);
    assert_eq!(get(&mut m, "energy_balance_error"), 0.0);
    for k in 0..2000 {
        m.step(f64::from(k) * 1e-3, 1e-3).unwrap();
        assert!(get(&mut m, "energy_balance_error").abs() < 1e-6);
    }
    assert!(get(&mut m, "shaft_speed").abs() < 1.0, "short-circuited, it brakes");
    let mut g = BrushedGearmotor::default();
    set(&mut g, "initial.shaft_speed", 5.0);
    g.start(0.0).unwrap();
    for k in 0..2000 {
        g.step(f64::from(k) * 1e-3, 1e-3).unwrap();
        assert!(get(&mut g, "energy_balance_error").abs() < 1e-6);
    }
    // Published works count from the start as well: what the friction took is what the rotor had.
    assert!(get(&mut g, "shaft_speed") < 5.0);
}

#[test]
fn a_value_outside_the_limits_of_validity_is_refused() {
    let mut motor = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    let mut gearmotor = BrushedGearmotor::default();
    let both: [(&mut dyn Model, &[Pair]); 2] = [(&mut motor, &OF_MOTOR), (&mut gearmotor, &of_gearmotor())];
    for (m, pairs) in both {
        for (name, _) in pairs.iter().filter(|(name, _)| name.ends_with("temperature")) {
            for value in [99.0, 900.0, 0.5] {
                set(m, name, value);
                let sentence = m.start(0.0).unwrap_err().0;
                assert!(sentence.starts_with(&format!("{name} = {value} K")), "{sentence}");
                assert_eq!(sentence.lines().count(), 1, "{sentence}");
            }
            let entry = m.declaration().by_name(name).unwrap();
            assert!(entry.check(-1.0, false).is_err() && entry.check(f64::NAN, false).is_err());
            assert!(entry.check(330.0, true).is_err(), "fixed after initialization");
            set(m, name, 330.0);
            m.start(0.0).unwrap();
        }
    }
}
