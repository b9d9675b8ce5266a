//! Model Exchange through the C functions: the life cycle, what a state is, and that what is read depends on what was put alone.

use crate::common::exchanged::{Exchanged, Named, count, some};
use crate::common::vr;
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::{
    fmi3EnterContinuousTimeMode, fmi3EnterInitializationMode, fmi3ExitInitializationMode, fmi3FreeInstance,
    fmi3GetContinuousStateDerivatives, fmi3GetContinuousStates, fmi3GetEventIndicators, fmi3GetFloat64,
    fmi3GetNumberOfContinuousStates, fmi3GetNumberOfEventIndicators, fmi3InstantiateCoSimulation,
    fmi3InstantiateModelExchange, fmi3SetContinuousStates, fmi3SetFloat64, fmi3SetTime,
    fmi3UpdateDiscreteStates,
};
use motor_fmu::logger::Status;
use physics::model::ModelType;
use std::ffi::CString;
use std::ptr::{null, null_mut};

fn models() -> impl Iterator<Item = &'static ModelType> {
    physics::models::ALL.iter()
}

fn motor() -> &'static ModelType {
    &physics::models::ALL[0]
}

/// Values that move a model of any kind.
fn busy(kind: &ModelType) -> Vec<(&'static str, f64)> {
    match kind.name() {
        "AnnulusCooledMotor" => vec![
            ("voltage", 20.0),
            ("load_torque", 0.03),
            ("fan_command", 0.7),
            ("cooling_mode", 4.0),
            ("commutation", 3.0),
            ("effect.housing_sensor_lag.tau", 7.0),
            ("effect.coulomb_friction.tau_c", 0.01),
        ],
        "BrushedGearmotor" => vec![("duty", 0.6), ("load_torque", 0.2), ("effect.contact_drop.V_b", 0.3)],
        "SeriesElasticActuator" => vec![
            ("torque_demand", 20.0),
            ("motor_speed", 30.0),
            ("motor_current", 2.0),
            ("joint_speed", 0.2),
            ("transmission.coupling", 2.0),
        ],
        _ => vec![("joint_torque", 20.0), ("gait.variation", 0.03)],
    }
}

/// States away from where a run starts.
fn elsewhere(x: &[f64], by: f64) -> Vec<f64> {
    x.iter().enumerate().map(|(k, x)| x + by * (1.0 + 0.37 * k as f64)).collect()
}

#[test]
fn the_life_cycle_is_enforced() {
    for kind in models() {
        let me = Exchanged::instantiated(kind);
        let (mut n, mut enter, mut terminate) = (vec![0.0; count(kind)], 9, 9);
        unsafe {
            assert_eq!(fmi2GetDerivatives(me.c, n.as_mut_ptr(), n.len()), Status::Error, "not yet");
            assert_eq!(fmi2EnterEventMode(me.c), Status::Error);
            assert_eq!(fmi2SetupExperiment(me.c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi2EnterInitializationMode(me.c), Status::Ok);
            assert_eq!(fmi2GetContinuousStates(me.c, n.as_mut_ptr(), n.len()), Status::Ok);
            assert_eq!(fmi2SetContinuousStates(me.c, n.as_ptr(), n.len()), Status::Error);
            assert_eq!(fmi2ExitInitializationMode(me.c), Status::Ok);
            assert_eq!(fmi2CompletedIntegratorStep(me.c, 1, &mut enter, &mut terminate), Status::Error);
            assert_eq!(fmi2SetContinuousStates(me.c, n.as_ptr(), n.len()), Status::Error, "at an event");
            assert_eq!(fmi2DoStep(me.c, 0.0, 1e-3, 1), Status::Error);
            me.update();
            assert_eq!(fmi2EnterContinuousTimeMode(me.c), Status::Ok);
            assert_eq!(fmi2NewDiscreteStates(me.c, null_mut()), Status::Error);
            assert_eq!(fmi2SetContinuousStates(me.c, n.as_ptr(), n.len() - 1), Status::Error, "too few");
            assert_eq!(fmi2GetDerivatives(me.c, n.as_mut_ptr(), n.len() - 1), Status::Error, "too few");
            assert_eq!(fmi2GetDerivatives(me.c, null_mut(), n.len()), Status::Error);
            let not_a_number = vec![f64::NAN; n.len()];
            assert_eq!(fmi2SetContinuousStates(me.c, not_a_number.as_ptr(), n.len()), Status::Discard);
            assert_eq!(fmi2SetTime(me.c, f64::INFINITY), Status::Discard);
            assert_eq!(fmi2CompletedIntegratorStep(me.c, 1, &mut enter, &mut terminate), Status::Ok);
            assert_eq!((enter, terminate), (0, 0));
            assert_eq!(me.set(some(kind).input, 0.1), Status::Ok, "a continuous input");
            assert_eq!(me.set(some(kind).parameter, 1e-6), Status::Error, "between events");
            assert_eq!(fmi2EnterEventMode(me.c), Status::Ok);
            assert_eq!(me.set(some(kind).parameter, 1e-6), Status::Ok, "at an event");
            assert_eq!(me.set(some(kind).state, 1.0), Status::Error, "computed");
            assert_eq!(fmi2SetRealInputDerivatives(me.c, null(), 0, null(), null()), Status::Error);
            assert_eq!(fmi2Terminate(me.c), Status::Ok);
            assert_eq!(fmi2GetDerivatives(me.c, n.as_mut_ptr(), n.len()), Status::Ok);
            assert_eq!(fmi2Reset(me.c), Status::Ok);
            assert_eq!(fmi2EnterContinuousTimeMode(me.c), Status::Error);
        }
    }
}

/// The values read depend only on the values set, not on earlier calls.
#[test]
fn readings_have_no_history() {
    for kind in models() {
        let (one, other) =
            (Exchanged::continuous(kind, &busy(kind)), Exchanged::continuous(kind, &busy(kind)));
        let x = one.states();
        for (time, by) in [(0.3, 4.0), (7.0, -2.0), (0.1, 0.5)] {
            one.put(time, &elsewhere(&x, by));
            one.rates();
            one.set(some(kind).input, 0.01 * by.abs());
            one.all();
        }
        for me in [&one, &other] {
            me.set(some(kind).input, 0.04);
            me.put(0.5, &elsewhere(&x, 1.0));
        }
        other.get(some(kind).output);
        assert_eq!(one.all(), other.all(), "{}", kind.name());
        assert_eq!(other.states(), elsewhere(&x, 1.0), "states that were put are those that are read");
    }
}

#[test]
fn rollback_is_bitwise_in_memory_and_through_bytes() {
    for kind in models() {
        let me = Exchanged::continuous(kind, &busy(kind));
        let x = me.states();
        me.put(0.2, &elsewhere(&x, 2.0));
        let before = me.all();
        unsafe {
            let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
            assert_eq!(fmi2GetFMUstate(me.c, &mut state), Status::Ok);
            assert_eq!(fmi2SerializedFMUstateSize(me.c, state, &mut size), Status::Ok);
            let mut bytes = vec![0; size];
            assert_eq!(fmi2SerializeFMUstate(me.c, state, bytes.as_mut_ptr(), size), Status::Ok);
            let away = || {
                me.put(0.9, &elsewhere(&x, -1.0));
                me.set(some(kind).input, 0.2);
                assert_eq!(fmi2EnterEventMode(me.c), Status::Ok);
                me.update();
                assert_ne!(me.all(), before);
            };
            away();
            assert_eq!(fmi2SetFMUstate(me.c, state), Status::Ok);
            assert_eq!(me.all(), before);
            away();
            assert_eq!(fmi2DeSerializeFMUstate(me.c, bytes.as_ptr(), size, &mut copy), Status::Ok);
            assert_eq!(fmi2SetFMUstate(me.c, copy), Status::Ok);
            assert_eq!(me.all(), before);
            me.put(0.25, &elsewhere(&x, 2.0));
            let on = me.all();
            // A new instance continues from the serialized state as this one does.
            let fresh = Exchanged::instantiated(kind);
            assert_eq!(fmi2SetFMUstate(fresh.c, copy), Status::Ok);
            fresh.put(0.25, &elsewhere(&x, 2.0));
            assert_eq!(fresh.all(), on);
            // Who steps by himself does not take it.
            let token = CString::new(kind.declared().token.clone()).unwrap();
            let stepping = fmi2Instantiate(c"cs".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 0);
            assert_eq!(fmi2SetFMUstate(stepping, state), Status::Error);
            let mut none = null_mut();
            assert_eq!(fmi2DeSerializeFMUstate(stepping, bytes.as_ptr(), size, &mut none), Status::Error);
            assert_eq!(fmi2GetDerivatives(stepping, null_mut(), 0), Status::Error, "the other interface");
            fmi2FreeInstance(stepping);
            assert_eq!(fmi2FreeFMUstate(me.c, &mut state), Status::Ok);
            assert_eq!(fmi2FreeFMUstate(me.c, &mut copy), Status::Ok);
        }
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
    let me = Exchanged::continuous(motor(), &start);
    let names: Vec<&str> = motor().declared().states[..22]
        .iter()
        .map(|[k, _]| motor().declared().entries[*k].name.as_str())
        .collect();
    let still: Vec<usize> = names
        .iter()
        .zip(me.rates())
        .enumerate()
        .filter(|(_, (_, rate))| *rate == 0.0)
        .map(|(k, _)| k)
        .collect();
    let still_names: Vec<&str> = still.iter().map(|&k| names[k]).collect();
    assert_eq!(
        still_names[..5],
        [
            "state.current",
            "state.shaft_speed",
            "state.rotor_temperature",
            "state.tube_temperature",
            "state.sensor_temperature"
        ]
    );
    let mut x = me.states();
    let before = (me.get("current"), me.get("shaft_speed"), me.get("magnet_temperature"));
    for &k in &still {
        if names[k].contains("energy") {
            continue; // at ambient temperature no heat has left yet
        }
        x[k] += 3.0;
    }
    me.put(0.0, &x);
    assert_eq!(me.states(), x);
    assert_eq!((me.get("current"), me.get("shaft_speed"), me.get("magnet_temperature")), before);
    assert_eq!(before.0, 5.0);
    // A lag that is switched on at an event makes the sensor temperature a state, and the FMU reports changed values.
    assert_eq!(unsafe { fmi2EnterEventMode(me.c) }, Status::Ok);
    assert_eq!(me.update().values_changed, 0);
    assert_eq!(me.set("effect.housing_sensor_lag.tau", 5.0), Status::Ok);
    assert_eq!(me.update().values_changed, 1);
    assert_eq!(me.get("state.sensor_temperature"), me.get("state.core_temperature"));
}

#[test]
fn events_by_time_and_by_indicator() {
    let start =
        [("voltage", 12.0), ("effect.demagnetisation.fraction", 0.1), ("effect.demagnetisation.time", 2.5)];
    let me = Exchanged::at_event(motor(), &start);
    let info = me.update();
    assert_eq!((info.next_event_time_defined, info.next_event_time), (1, 2.5));
    unsafe { assert_eq!(fmi2EnterContinuousTimeMode(me.c), Status::Ok) };
    let k_t = me.get("torque_constant");
    let mut x = me.states();
    me.put(2.5, &x);
    assert_eq!(me.get("torque_constant"), k_t, "an integrator may look beyond an event");
    unsafe { assert_eq!(fmi2EnterEventMode(me.c), Status::Ok) };
    assert_eq!(me.update().next_event_time_defined, 0);
    assert!((me.get("torque_constant") / k_t - 0.9).abs() < 1e-12);
    // The winding passes its limit: the indicator turns its sign, the flag waits for the event.
    unsafe { assert_eq!(fmi2EnterContinuousTimeMode(me.c), Status::Ok) };
    let limit = me.get("thermal.T_w_max");
    let over = |me: &Exchanged| {
        let mut flag = 9;
        assert_eq!(unsafe { fmi2GetBoolean(me.c, &vr("over_temperature"), 1, &mut flag) }, Status::Ok);
        flag
    };
    x[3] = limit - 0.5;
    me.put(3.0, &x);
    assert!((me.indicators()[0] + 0.5).abs() < 1e-9);
    x[3] = limit + 0.5;
    me.put(3.1, &x);
    assert!((me.indicators()[0] - 0.5).abs() < 1e-9);
    assert_eq!(over(&me), 0);
    unsafe { assert_eq!(fmi2EnterEventMode(me.c), Status::Ok) };
    assert_eq!(over(&me), 0);
    me.update();
    assert_eq!(over(&me), 1);
}

/// The bridge keeps its direction past zero until the event; leaving zero, it goes where the duty goes.
#[test]
fn a_duty_past_zero_waits_for_its_event() {
    let gearmotor = &physics::models::ALL[1];
    let me = Exchanged::continuous(gearmotor, &[("duty", 0.3)]);
    let mut x = me.states();
    x[1] = 2.0;
    me.put(0.0, &x);
    me.set("duty", 0.0);
    let at_zero = me.rates();
    me.set("duty", -1e-9);
    assert_eq!(me.rates(), at_zero, "both freewheel");
    assert!(me.indicators()[1] < 0.0);
    unsafe { assert_eq!(fmi2EnterEventMode(me.c), Status::Ok) };
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

#[test]
fn more_segments_than_are_shown_are_for_co_simulation() {
    let me = Exchanged::instantiated(motor());
    unsafe {
        assert_eq!(me.set("air_segments", 9.0), Status::Ok);
        assert_eq!(fmi2SetupExperiment(me.c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
        assert_eq!(fmi2EnterInitializationMode(me.c), Status::Ok);
        let mut value = 0.0;
        assert_eq!(fmi2GetReal(me.c, &vr("T_housing[8]"), 1, &mut value), Status::Ok);
        assert_eq!(fmi2GetReal(me.c, &vr("T_housing[9]"), 1, &mut value), Status::Error);
        assert_eq!(fmi2ExitInitializationMode(me.c), Status::Error);
    }
}

/// Both standards integrate the same numbers.
#[test]
fn both_standards_give_the_same_bits() {
    for kind in models() {
        let two = Exchanged::continuous(kind, &[(some(kind).input, 0.04)]);
        let token = CString::new(kind.declared().token.clone()).unwrap();
        unsafe {
            let three =
                fmi3InstantiateModelExchange(c"me".as_ptr(), token.as_ptr(), null(), 0, 0, null_mut(), None);
            assert!(!three.is_null());
            let load = two.reference(some(kind).input);
            assert_eq!(fmi3SetFloat64(three, &load, 1, &0.04, 1), Status::Ok);
            assert_eq!(fmi3EnterInitializationMode(three, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
            assert_eq!(fmi3ExitInitializationMode(three), Status::Ok);
            let (mut a, mut b, mut c, mut d, mut e, mut t) = (9, 9, 9, 9, 9, f64::NAN);
            assert_eq!(
                fmi3UpdateDiscreteStates(three, &mut a, &mut b, &mut c, &mut d, &mut e, &mut t),
                Status::Ok
            );
            // Whoever walks stops some day.
            let next = if kind.name() == "GaitLoad" { (1, 1e9) } else { (0, 0.0) };
            assert_eq!((a, b, c, d, (e, t)), (0, 0, 0, 0, next));
            assert_eq!(fmi3EnterContinuousTimeMode(three), Status::Ok);
            let (mut n, mut nz) = (0, 0);
            assert_eq!(fmi3GetNumberOfContinuousStates(three, &mut n), Status::Ok);
            assert_eq!(fmi3GetNumberOfEventIndicators(three, &mut nz), Status::Ok);
            assert_eq!((n, nz), (count(kind), two.indicators().len()));
            let x = elsewhere(&two.states(), 3.0);
            two.put(0.7, &x);
            assert_eq!(fmi3SetTime(three, 0.7), Status::Ok);
            assert_eq!(fmi3SetContinuousStates(three, x.as_ptr(), n), Status::Ok);
            let (mut states, mut rates, mut z) = (vec![0.0; n], vec![0.0; n], vec![0.0; nz]);
            assert_eq!(fmi3GetContinuousStates(three, states.as_mut_ptr(), n), Status::Ok);
            assert_eq!(fmi3GetContinuousStateDerivatives(three, rates.as_mut_ptr(), n), Status::Ok);
            assert_eq!(fmi3GetEventIndicators(three, z.as_mut_ptr(), nz), Status::Ok);
            assert_eq!((states, rates, z), (two.states(), two.rates(), two.indicators()));
            let mut rate = 0.0;
            assert_eq!(
                fmi3GetFloat64(three, &two.reference(&format!("der({})", some(kind).state)), 1, &mut rate, 1),
                Status::Ok
            );
            let declaration = kind.declared();
            let named = |[k, _]: &[usize; 2]| declaration.entries[*k].name == some(kind).state;
            assert_eq!(rate, two.rates()[declaration.states.iter().position(named).unwrap()]);
            fmi3FreeInstance(three);
            // Functions of the one are not for the other.
            let cs = fmi3InstantiateCoSimulation(
                c"cs".as_ptr(),
                token.as_ptr(),
                null(),
                0,
                0,
                0,
                0,
                null(),
                0,
                null_mut(),
                None,
                None,
            );
            assert_eq!(fmi3SetTime(cs, 1.0), Status::Error);
            assert_eq!((fmi3GetNumberOfContinuousStates(cs, &mut n), n), (Status::Ok, 0), "none of its own");
            fmi3FreeInstance(cs);
        }
    }
}
