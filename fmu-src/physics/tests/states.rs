//! States and rates say what steps do, in every mode, and states that were set are those that come back.

use crate::common::{busy_inputs, cooling_modes, motor, turn_on_all_nodes};
use physics::declare::Causality;
use physics::effects::Effects;
use physics::exchange::Exchange;
use physics::model::Model;
use physics::models::annulus_cooled_motor::{AnnulusCooledMotor, DriveMode, MechanicalMode};
use physics::models::brushed_gearmotor::BrushedGearmotor;
use physics::solver::split::Split;

/// A step so short that a difference is a derivative, s.
const SHORT: f64 = 1e-6;

/// Differences over a short step against the mean of the rates at its ends, which is right to second order: the fast
/// states bend within it. Beside 1e-4 of the rate, what rounding leaves of a difference near 400.
fn assert_rates(model: &mut dyn Model, what: &str) {
    let (mut before, mut start, mut after, mut end) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    model.states(&mut before);
    model.rates(&mut start);
    assert_eq!(before.len(), start.len(), "{what}");
    model.step(model.time(), SHORT).unwrap();
    model.states(&mut after);
    model.rates(&mut end);
    for k in 0..before.len() {
        let (difference, rate) = ((after[k] - before[k]) / SHORT, 0.5 * (start[k] + end[k]));
        let tolerance = 1e-4 * rate.abs() + 1e-6;
        assert!((difference - rate).abs() <= tolerance, "{what}: state {k}: {difference} and {rate}");
    }
}

#[test]
fn rates_are_what_steps_do() {
    for drive in [DriveMode::Voltage, DriveMode::Pwm, DriveMode::Current, DriveMode::Power] {
        for coupling in [MechanicalMode::FreeShaft, MechanicalMode::ImposedSpeed] {
            for cooling in cooling_modes() {
                for effects in [Effects::default(), Effects::examples()] {
                    let mut m = motor(drive, coupling);
                    m.parameters.choices.cooling_mode = cooling;
                    m.parameters.choices.air_segments = 3;
                    m.parameters.effects = effects;
                    m.parameters.effects.demagnetisation.time = 1e6;
                    m.inputs = busy_inputs();
                    m.inputs.voltage = 12.0;
                    // Enough for a current of amperes: within I_small of zero it moves within microseconds.
                    m.inputs.duty = 0.95;
                    m.inputs.current_command = 6.0;
                    m.inputs.electrical_power = 40.0;
                    m.inputs.imposed_speed = 300.0;
                    m.inputs.load_torque = 0.02;
                    m.inputs.fan_command = 0.7;
                    m.start(0.0).unwrap();
                    m.step(0.0, 30.0).unwrap();
                    let what = format!("{drive:?} {coupling:?} {cooling:?}");
                    assert_rates(&mut m, &what);
                    let (mut states, mut again) = (Vec::new(), Vec::new());
                    m.states(&mut states);
                    for (k, state) in states.iter_mut().enumerate() {
                        *state += 0.5 + 0.1 * k as f64;
                    }
                    assert!(m.set_states(m.time(), &states) && !m.set_states(0.0, &states[1..]));
                    m.states(&mut again);
                    assert_eq!(states, again, "{what}");
                    assert_rates(&mut m, &what);
                }
            }
        }
    }
}

#[test]
fn rates_of_the_gearmotor() {
    let mut m = BrushedGearmotor::default();
    turn_on_all_nodes(&mut m);
    m.inputs.duty = 1.0;
    m.inputs.supply_voltage = 10.0;
    m.start(0.0).unwrap();
    m.step(0.0, 30.0).unwrap();
    assert_rates(&mut m, "settled");
    let mut states = Vec::new();
    m.states(&mut states);
    let declaration = m.declaration();
    let mut names = declaration.states.iter().map(|[state, _]| &declaration.entries[*state].name);
    states[names.position(|name| name == "state.winding_temperature").unwrap()] += 20.0;
    assert!(m.set_states(m.time(), &states) && !m.set_states(0.0, &[]));
    assert_rates(&mut m, "warmer");
}

/// Both motors thrown to and fro, so that steps are cut.
fn thrown() -> [(Box<dyn Model>, &'static str, [f64; 2]); 2] {
    let motor = motor(DriveMode::Voltage, MechanicalMode::FreeShaft);
    let mut gearmotor = BrushedGearmotor::default();
    turn_on_all_nodes(&mut gearmotor);
    gearmotor.inputs.supply_voltage = 12.0;
    [(Box::new(motor), "voltage", [40.0, -40.0]), (Box::new(gearmotor), "duty", [1.0, 0.3])]
}

/// A model that takes the numbers of another goes on as that one does, to the bit, the step that served included.
#[test]
fn a_saved_motor_goes_on_with_the_step_that_served() {
    for (mut model, input, values) in thrown() {
        let slot = model.declaration().by_name(input).unwrap().slot;
        let go = |model: &mut dyn Model, from: u32, to: u32| {
            for k in from..to {
                model.set(slot, values[k as usize % 2]);
                model.step(f64::from(k) * 0.02, 0.02).unwrap();
            }
            let mut numbers = Vec::new();
            model.save(&mut numbers);
            numbers
        };
        let bits = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect::<Vec<u64>>();
        let mut other = model.boxed_clone();
        model.start(0.0).unwrap();
        let saved = go(&mut *model, 0, 5);
        assert!(other.restore(&saved));
        assert_eq!(bits(go(&mut *model, 5, 9)), bits(go(&mut *other, 5, 9)), "{input}");
    }
}

/// All outputs of a motor in Model Exchange, to the bit, in every cooling mode: before and after it is restored, and whether or not the
/// cooling was evaluated for the derivatives just before.
#[test]
fn a_restored_motor_shows_the_same_outputs() {
    let outputs = |m: &mut AnnulusCooledMotor| -> Vec<u64> {
        let entries = m.declaration().entries.iter().filter(|e| e.row.causality == Causality::Output);
        entries.map(|e| m.get(e.slot).to_bits()).collect()
    };
    for cooling in cooling_modes() {
        let mut m = motor(DriveMode::Current, MechanicalMode::ImposedSpeed);
        m.parameters.choices.cooling_mode = cooling;
        m.parameters.initial.housing_temperature = 340.0;
        m.inputs = busy_inputs();
        (m.inputs.current_command, m.inputs.imposed_speed, m.inputs.fan_command) = (6.0, 300.0, 0.7);
        m.start(0.0).unwrap();
        m.enter_model_exchange();
        let shown = outputs(&mut m);
        m.derivatives(&mut []).unwrap();
        assert_eq!(outputs(&mut m), shown, "{cooling:?}: after the derivatives");
        m.update();
        assert_eq!(outputs(&mut m), shown, "{cooling:?}: after an event");
        let (mut saved, mut other) = (Vec::new(), AnnulusCooledMotor::default());
        m.save(&mut saved);
        other.parameters = m.parameters;
        other.inputs = m.inputs;
        assert!(other.restore(&saved));
        assert_eq!(outputs(&mut other), shown, "{cooling:?}: restored");
    }
}

/// The integrator's numbers: frozen for no step, and with the whole step to begin with; no other step than one that time can
/// take is among them.
#[test]
fn an_integrator_takes_no_step_that_is_none() {
    let numbers: Vec<f64> = Split::<2>::default().to_numbers().collect();
    let taken = |numbers: &[f64]| {
        let mut left = numbers.iter().copied();
        Split::<2>::from_numbers(&mut || left.next())
    };
    assert_eq!(taken(&numbers), Some(Split::default()));
    let [rest @ .., trial] = numbers.as_slice() else { panic!("it has numbers") };
    assert_eq!(*trial, f64::INFINITY);
    for none in [0.0, -1e-3, f64::NAN] {
        assert_eq!(taken(&[rest, &[none]].concat()), None, "{none}");
    }
    assert_eq!(taken(rest), None);
}
