//! Model Exchange through the C functions: the life cycle, what a state is, and that what is read depends on what was put alone.

use crate::common::running::busy;
use crate::common::{CS3, Importer, KINDS, LOGGED, ME2, ME3, MODELS, MOTOR, Options, Succeeds, vr};
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::{fmi3GetNumberOfContinuousStates, fmi3GetNumberOfEventIndicators};
use motor_fmu::logger::Status;
use physics::model::ModelType;
use std::ptr::{null, null_mut};

/// What is known of a model: how many states its archive shows, and something in every role.
struct Known {
    states: usize,
    input: &'static str,
    output: &'static str,
    parameter: &'static str,
    state: &'static str,
}

fn known(kind: &ModelType) -> Known {
    let rotor = |states| Known {
        states,
        input: "load_torque",
        output: "shaft_torque",
        parameter: "effect.viscous_friction.k",
        state: "state.shaft_angle",
    };
    match name(kind) {
        "AnnulusCooledMotor" => rotor(26),
        "BrushedGearmotor" => rotor(15),
        "SeriesElasticActuator" => Known {
            states: 8,
            input: "torque_demand",
            output: "joint_torque",
            parameter: "spring.damping",
            state: "state.demand",
        },
        "GaitLoad" => Known {
            states: 2,
            input: "joint_torque",
            output: "tracking_error",
            parameter: "gait.support",
            state: "state.stride",
        },
        other => panic!("what is known of {other}?"),
    }
}

fn name(kind: &ModelType) -> &'static str {
    (kind.declaration)().name
}

fn instantiated(kind: &ModelType) -> Importer {
    Importer::instantiated(kind, ME2, Options::default())
}

fn continuous(kind: &ModelType, start: &[(&str, f64)]) -> Importer {
    instantiated(kind).started(start)
}

/// Everything that can be read, bit for bit.
fn all(me: &Importer) -> Vec<u64> {
    let read = [me.states(), me.rates(), me.indicators()].concat();
    read.into_iter().map(f64::to_bits).chain(me.outputs()).collect()
}

/// States away from where a run starts.
fn elsewhere(x: &[f64], by: f64) -> Vec<f64> {
    x.iter().enumerate().map(|(k, x)| x + by * (1.0 + 0.37 * k as f64)).collect()
}

#[test]
fn the_life_cycle_is_enforced() {
    for kind in MODELS {
        let (me, some) = (instantiated(kind), known(kind));
        let n = some.states;
        let mut x = vec![0.0; n];
        assert_eq!(me.get_rates(&mut x), Status::Error, "not yet");
        assert_eq!(me.enter_event(), Status::Error);
        me.enter(None, 0.0).ok();
        me.get_states(&mut x).ok();
        assert_eq!(me.set_states(&x), Status::Error);
        me.exit_initialization().ok();
        assert_eq!(me.complete().0, Status::Error);
        assert_eq!(me.set_states(&x), Status::Error, "at an event");
        assert_eq!(me.step(0.0, 1e-3), Status::Error);
        me.update();
        me.continue_in_time().ok();
        assert_eq!(me.iterate().0, Status::Error);
        assert_eq!(me.set_states(&x[1..]), Status::Error, "too few");
        assert_eq!(me.get_rates(&mut x[1..]), Status::Error, "too few");
        assert_eq!(unsafe { fmi2GetDerivatives(me.handle, null_mut(), n) }, Status::Error);
        assert_eq!(me.set_states(&vec![f64::NAN; n]), Status::Discard);
        assert_eq!(me.set_time(f64::INFINITY), Status::Discard);
        assert_eq!(me.complete(), (Status::Ok, false, false));
        assert_eq!(me.set(some.input, 0.1), Status::Ok, "a continuous input");
        assert_eq!(me.set(some.parameter, 1e-6), Status::Error, "between events");
        me.enter_event().ok();
        assert_eq!(me.set(some.parameter, 1e-6), Status::Ok, "at an event");
        assert_eq!(me.set(some.state, 1.0), Status::Error, "computed");
        let slopes = unsafe { fmi2SetRealInputDerivatives(me.handle, null(), 0, null(), null()) };
        assert_eq!(slopes, Status::Error);
        me.terminate().ok();
        me.get_rates(&mut x).ok();
        me.reset().ok();
        assert_eq!(me.continue_in_time(), Status::Error);
    }
}

/// The values read depend only on the values set, not on earlier calls.
#[test]
fn readings_have_no_history() {
    for kind in MODELS {
        let (one, other) = (continuous(kind, &busy(kind)), continuous(kind, &busy(kind)));
        let x = one.states();
        for (time, by) in [(0.3, 4.0), (7.0, -2.0), (0.1, 0.5)] {
            one.put(time, &elsewhere(&x, by));
            one.rates();
            one.set(known(kind).input, 0.01 * by.abs());
            all(&one);
        }
        for me in [&one, &other] {
            me.set(known(kind).input, 0.04);
            me.put(0.5, &elsewhere(&x, 1.0));
        }
        other.get(known(kind).output);
        assert_eq!(all(&one), all(&other), "{}", name(kind));
        assert_eq!(other.states(), elsewhere(&x, 1.0), "states that were put are those that are read");
    }
}

/// States that an input imposes and states of absent nodes are constant; both keep the value that was set.
#[test]
fn unused_states_are_constant() {
    let start = [
        ("drive_mode", 3.0),
        ("mechanical_mode", 2.0),
        ("current_command", 5.0),
        ("imposed_speed", 100.0),
        ("effect.viscous_friction.k", 1e-6),
    ];
    let me = continuous(MOTOR, &start);
    let entries = &me.declaration.entries;
    let names = me.declaration.states[..25].iter().map(|[k, _]| entries[*k].name.as_str());
    let still: Vec<(usize, &str)> =
        names.enumerate().zip(me.rates()).filter(|(_, rate)| *rate == 0.0).map(|(state, _)| state).collect();
    let first = still[..5].iter().map(|(_, name)| name.trim_start_matches("state.")).collect::<Vec<_>>();
    assert_eq!(
        first,
        ["current", "shaft_speed", "rotor_temperature", "tube_temperature", "sensor_temperature"]
    );
    let mut x = me.states();
    let before = (me.get("current"), me.get("shaft_speed"), me.get("magnet_temperature"));
    // At ambient temperature no heat has left yet.
    for (k, _) in still.iter().filter(|(_, name)| !name.contains("energy")) {
        x[*k] += 3.0;
    }
    me.put(0.0, &x);
    assert_eq!(me.states(), x);
    assert_eq!((me.get("current"), me.get("shaft_speed"), me.get("magnet_temperature")), before);
    assert_eq!(before.0, 5.0);
    // A lag that is switched on at an event makes the sensor temperature a state, and the FMU reports changed values.
    me.enter_event().ok();
    assert!(!me.update().0);
    for (effect, sensor, node) in [
        ("housing_sensor_lag", "sensor_temperature", "core_temperature"),
        ("winding_sensor_lag", "winding_sensor_temperature", "winding_temperature"),
    ] {
        assert_eq!(me.set(&format!("effect.{effect}.tau"), 5.0), Status::Ok);
        assert!(me.update().0, "values changed");
        assert_eq!(me.get(&format!("state.{sensor}")), me.get(&format!("state.{node}")));
    }
}

#[test]
fn events_by_time_and_by_indicator() {
    let start =
        [("voltage", 12.0), ("effect.demagnetisation.fraction", 0.1), ("effect.demagnetisation.time", 2.5)];
    let me = instantiated(MOTOR).initialized(&start);
    assert_eq!(me.update().1, Some(2.5));
    me.continue_in_time().ok();
    let k_t = me.get("torque_constant");
    let mut x = me.states();
    me.put(2.5, &x);
    assert_eq!(me.get("torque_constant"), k_t, "an integrator may look beyond an event");
    me.enter_event().ok();
    assert_eq!(me.update().1, None);
    assert!((me.get("torque_constant") / k_t - 0.9).abs() < 1e-12);
    // The winding passes its limit: the indicator turns its sign, the flag waits for the event.
    me.continue_in_time().ok();
    let limit = me.get("thermal.T_w_max");
    x[3] = limit - 0.5;
    me.put(3.0, &x);
    assert!((me.indicators()[0] + 0.5).abs() < 1e-9);
    x[3] = limit + 0.5;
    me.put(3.1, &x);
    assert!((me.indicators()[0] - 0.5).abs() < 1e-9);
    assert!(!me.is_hot());
    me.enter_event().ok();
    assert!(!me.is_hot());
    me.update();
    assert!(me.is_hot());
}

/// The bridge keeps its direction past zero until the event; leaving zero, it goes where the duty goes.
#[test]
fn a_duty_past_zero_waits_for_its_event() {
    let gearmotor = &MODELS[1];
    let me = continuous(gearmotor, &[("duty", 0.3)]);
    let mut x = me.states();
    x[1] = 2.0;
    me.put(0.0, &x);
    me.set("duty", 0.0);
    let at_zero = me.rates();
    me.set("duty", -1e-9);
    assert_eq!(me.rates(), at_zero, "both freewheel");
    assert!(me.indicators()[1] < 0.0);
    me.enter_event().ok();
    me.update();
    assert_ne!(me.rates(), at_zero, "the bridge has turned");
    me.set("duty", 0.0);
    me.update();
    let open = me.rates();
    me.set("duty", 0.2);
    let left = me.rates();
    me.update();
    assert_eq!(me.rates(), left);
    assert_ne!(open, left);
}

/// A turning motor at duty 0, with the bridge of `drive.zero_duty` (1 brake, 2 coast): every standard and interface type, both
/// motors. Braked, the current opposes the motion; open, it stays zero.
#[test]
fn duty_zero_brakes_or_coasts() {
    let motors: [(usize, &[(&str, f64)]); 2] = [(0, &[("voltage", 24.0)]), (1, &[("supply_voltage", 12.0)])];
    for (number, inputs) in motors {
        for how in KINDS {
            for zero_duty in [1.0, 2.0] {
                let one = Importer::instantiated(&MODELS[number], how, LOGGED);
                if number == 0 {
                    one.set("drive_mode", 2.0).ok();
                }
                one.set("drive.zero_duty", zero_duty).ok();
                one.set("initial.shaft_speed", 8.0).ok();
                let one = one.started(inputs);
                let current = if one.exchange {
                    // What the current is after a millisecond at this derivative.
                    1e-3 * one.rates()[0]
                } else {
                    one.step(0.0, 1e-3).ok();
                    one.get("current")
                };
                let brakes = zero_duty == 1.0;
                assert_eq!(
                    current < -1e-3,
                    brakes,
                    "{how:?} {} {zero_duty}: {current} A",
                    one.declaration.name
                );
                assert!(brakes || current == 0.0, "{current} A");
                // A duty that leaves zero drives the motor, in Model Exchange before any event.
                one.set("duty", 1.0).ok();
                if one.exchange {
                    assert!(one.rates()[0] > 0.0);
                    one.set("duty", 0.0).ok();
                    assert_eq!(1e-3 * one.rates()[0], current);
                }
            }
        }
    }
}

#[test]
fn more_segments_than_are_shown_are_for_co_simulation() {
    let me = instantiated(MOTOR);
    me.set("air_segments", 9.0).ok();
    me.enter(None, 0.0).ok();
    me.get("T_housing[8]");
    assert_eq!(me.get_reals(&[vr("T_housing[9]")], &mut [0.0]), Status::Error);
    assert_eq!(me.exit_initialization(), Status::Error);
}

/// Both standards integrate the same numbers.
#[test]
fn both_standards_give_the_same_bits() {
    for kind in MODELS {
        let some = known(kind);
        let start = [(some.input, 0.04)];
        let two = continuous(kind, &start);
        let three = Importer::instantiated(kind, ME3, Options::default()).initialized(&start);
        // Whoever walks stops some day.
        assert_eq!(three.update(), (false, (name(kind) == "GaitLoad").then_some(1e9)));
        three.continue_in_time().ok();
        let (mut n, mut nz) = (0, 0);
        unsafe {
            fmi3GetNumberOfContinuousStates(three.handle, &mut n).ok();
            fmi3GetNumberOfEventIndicators(three.handle, &mut nz).ok();
        }
        assert_eq!((n, nz), (some.states, two.indicators().len()));
        let x = elsewhere(&two.states(), 3.0);
        for me in [&two, &three] {
            me.put(0.7, &x);
        }
        assert_eq!(all(&three), all(&two));
        let named = |[k, _]: &[usize; 2]| two.declaration.entries[*k].name == some.state;
        let at = two.declaration.states.iter().position(named).unwrap();
        assert_eq!(three.get(&format!("der({})", some.state)), two.rates()[at]);
        // Functions of the one are not for the other.
        let cs = Importer::instantiated(kind, CS3, Options::default());
        assert_eq!(cs.set_time(1.0), Status::Error);
        unsafe { fmi3GetNumberOfContinuousStates(cs.handle, &mut n) }.ok();
        assert_eq!(n, 0, "none of its own");
    }
}
