//! FMI 3 Co-Simulation where the importer takes part: events, early return, looks into steps.

use crate::common::three::Three;
use crate::common::{Motor2, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ffi::c_void;
use std::ptr::null_mut;

/// A motor that passes the limit of its winding after some seconds at stall.
const HEATING: &[(&str, f64)] =
    &[("mechanical_mode", 2.0), ("drive_mode", 3.0), ("current_command", 20.0), ("thermal.T_w_max", 303.15)];

/// When the winding passes its limit, by plain steps of a tenth of a millisecond.
fn when_hot() -> f64 {
    let plain = Three::with(false, false, None).started(HEATING);
    let mut k = 0;
    while !plain.is_hot() {
        plain.step(f64::from(k) * 1e-4, 1e-4);
        k += 1;
    }
    f64::from(k) * 1e-4
}

#[test]
fn a_step_ends_at_an_event_where_it_may() {
    let hot = when_hot();
    assert!(hot > 0.3, "{hot}");
    let motor = Three::with(true, true, None).started(HEATING);
    assert_eq!(motor.handle_event(), None);
    let (event, early, at) = motor.step(0.0, 20.0);
    assert!(event && early);
    assert!(at <= hot + 1e-9 && at > hot - 1.2e-4 - 20.0 * 1e-6, "{at} and {hot}");
    // Past the limit by no more than the tolerance of the event time; the flag changes when the importer handles the event.
    let margin = motor.get("winding_margin");
    assert!(margin < 0.0 && margin > -1e-3, "{margin}");
    assert!(!motor.is_hot());
    // An importer that ignores the event continues, and the next step reports the event again.
    let (again, early, there) = motor.step(at, 1e-3);
    assert!(again && !early && (there - at - 1e-3).abs() < 1e-12);
    motor.handle_event();
    assert!(motor.is_hot());
    let (event, early, end) = motor.step(there, 20.0 - there);
    assert_eq!((event, early, end), (false, false, 20.0));
    // A step without event mode gives the same result.
    let plain = Three::with(false, false, None).started(HEATING);
    assert_eq!(plain.step(0.0, 20.0), (false, false, 20.0));
    assert!(plain.is_hot());
    for name in ["winding_temperature", "housing_temperature", "energy_electrical"] {
        let (ours, theirs) = (motor.get(name), plain.get(name));
        assert!((ours - theirs).abs() <= 1e-6 * theirs.abs(), "{name}: {ours} and {theirs}");
    }
}

#[test]
fn without_early_return_an_event_is_reported_at_the_end() {
    let motor = Three::with(true, false, None).started(HEATING);
    motor.handle_event();
    let plain = Three::with(false, false, None).started(HEATING);
    assert_eq!(motor.step(0.0, 20.0), (true, false, 20.0));
    plain.step(0.0, 20.0);
    assert_eq!(motor.get("winding_temperature").to_bits(), plain.get("winding_temperature").to_bits());
    assert_eq!((motor.is_hot(), plain.is_hot()), (false, true));
    motor.handle_event();
    assert!(motor.is_hot());
}

/// Magnets that lose strength at 0.35 s: known before, and found to rounding.
#[test]
fn events_by_time_are_announced_and_stop_a_step() {
    let fades =
        &[("voltage", 12.0), ("effect.demagnetisation.fraction", 0.1), ("effect.demagnetisation.time", 0.35)];
    let motor = Three::with(true, true, None).started(fades);
    assert_eq!(motor.handle_event(), Some(0.35));
    let strong = motor.get("torque_constant");
    let (event, early, at) = motor.step(0.0, 1.0);
    assert!(event && early && (at - 0.35).abs() < 1e-15, "{at}");
    assert_eq!(motor.handle_event(), None);
    assert!((motor.get("torque_constant") / strong - 0.9).abs() < 1e-3);
    assert_eq!(motor.step(at, 1.0 - at), (false, false, 1.0));
    let late = Three::with(true, false, None).started(fades);
    assert_eq!(late.step_after_event(1.0), (true, false, 1.0));
    let plain = Three::with(false, false, None).started(fades);
    assert_eq!(plain.step(0.0, 1.0), (false, false, 1.0));
    assert_eq!(late.get("shaft_speed").to_bits(), plain.get("shaft_speed").to_bits());
    assert!((motor.get("shaft_speed") / plain.get("shaft_speed") - 1.0).abs() < 1e-9);
}

trait AfterEvent {
    fn step_after_event(&self, h: f64) -> crate::common::three::Ended;
}

impl AfterEvent for Three {
    fn step_after_event(&self, h: f64) -> crate::common::three::Ended {
        self.handle_event();
        self.step(0.0, h)
    }
}

/// Who has event mode and meets no event reads what everybody reads.
#[test]
fn where_nothing_happens_event_mode_changes_no_bit() {
    let (two, three) = (Motor2::initialized("two"), Three::with(true, true, None).started(&[]));
    three.handle_event();
    for k in 0..300 {
        let t = f64::from(k) * 1e-3;
        let volts = 15.0 * (9.0 * t).sin();
        assert_eq!((two.set("voltage", volts), three.set("voltage", volts)), (Status::Ok, Status::Ok));
        assert_eq!(two.step(t, 1e-3), Status::Ok);
        assert_eq!(three.step(t, 1e-3), (false, false, t + 1e-3));
        for name in ["current", "shaft_speed", "winding_temperature", "energy_electrical"] {
            assert_eq!(two.get(name).to_bits(), three.get(name).to_bits(), "{name} at {t} s");
        }
    }
}

#[test]
fn event_mode_is_for_those_who_asked_for_it() {
    let plain = Three::with(false, true, None).started(&[]);
    let (mut a, mut t) = ([9; 5], 0.0);
    let [b, c, d, e, f] = &mut a;
    unsafe {
        assert_eq!(fmi3EnterEventMode(plain.0), Status::Error);
        assert_eq!(fmi3UpdateDiscreteStates(plain.0, b, c, d, e, f, &mut t), Status::Error);
        assert_eq!(fmi3EnterStepMode(plain.0), Status::Error);
        let motor = Three::with(true, false, None).started(&[]);
        let mut last = 7.0;
        let step =
            |last: &mut f64| fmi3DoStep(motor.0, 0.0, 1e-3, 1, null_mut(), null_mut(), null_mut(), last);
        assert_eq!(step(&mut last), Status::Error, "the first event is not over");
        assert_eq!(fmi3EnterContinuousTimeMode(motor.0), Status::Error, "that is Model Exchange");
        assert_eq!(fmi3EnterStepMode(motor.0), Status::Ok);
        assert_eq!(step(&mut last), Status::Ok);
    }
}

/// A saved event is an event again, also through bytes; what discrete outputs show is saved with it.
#[test]
fn an_event_is_saved_and_restored() {
    let motor = Three::with(true, true, None).started(HEATING);
    motor.handle_event();
    let (_, _, at) = motor.step(0.0, 20.0);
    unsafe {
        let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
        assert_eq!(fmi3GetFMUState(motor.0, &mut state), Status::Ok);
        assert_eq!(fmi3SerializedFMUStateSize(motor.0, state, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size];
        assert_eq!(fmi3SerializeFMUState(motor.0, state, bytes.as_mut_ptr(), size), Status::Ok);
        motor.handle_event();
        assert!(motor.is_hot());
        assert_eq!(fmi3SetFMUState(motor.0, state), Status::Ok);
        assert!(!motor.is_hot(), "the event is still to come");
        let fresh = Three::with(true, true, None);
        assert_eq!(fmi3DeserializeFMUState(fresh.0, bytes.as_ptr(), size, &mut copy), Status::Ok);
        assert_eq!(fmi3SetFMUState(fresh.0, copy), Status::Ok);
        assert!(!fresh.is_hot());
        assert_eq!(fresh.step(at, 1e-3), motor.step(at, 1e-3));
        // One without event mode takes it, and shows what is.
        let plain = Three::with(false, false, None);
        assert_eq!(fmi3SetFMUState(plain.0, state), Status::Ok);
        assert!(plain.is_hot());
        for (of, state) in [(&motor, &mut state), (&fresh, &mut copy)] {
            assert_eq!(fmi3FreeFMUState(of.0, state), Status::Ok);
        }
    }
}

/// Actions of the callback, and the values that it reads.
struct Looker {
    motor: *mut c_void,
    /// Set in the middle of the step.
    load: Option<f64>,
    /// Requested end of the step.
    until: Option<f64>,
    /// Time, speed, whether inputs may be set, whether the step may end.
    seen: Vec<(f64, f64, bool, bool)>,
    refused: usize,
}

unsafe extern "C" fn look(
    environment: *mut c_void,
    time: f64,
    sets: u8,
    gets: u8,
    done: u8,
    may_return: u8,
    requested: *mut u8,
    until: *mut f64,
) {
    unsafe {
        let looker = &mut *environment.cast::<Looker>();
        assert_eq!((gets, done), (1, 1));
        let mut speed = f64::NAN;
        assert_eq!(fmi3GetFloat64(looker.motor, &vr("shaft_speed"), 1, &mut speed, 1), Status::Ok);
        looker.seen.push((time, speed, sets == 1, may_return == 1));
        if let Some(load) = looker.load {
            assert_eq!(fmi3SetFloat64(looker.motor, &vr("load_torque"), 1, &load, 1), Status::Ok);
        }
        // What was not named, what is no matter of the middle of a step, and what would take the instance away.
        let mut other = 0.0;
        let mut state = null_mut();
        for status in [
            fmi3GetFloat64(looker.motor, &vr("current"), 1, &mut other, 1),
            fmi3SetFloat64(looker.motor, &vr("motor.L"), 1, &1e-3, 1),
            fmi3DoStep(looker.motor, time, 1e-3, 1, null_mut(), null_mut(), null_mut(), null_mut()),
            fmi3GetFMUState(looker.motor, &mut state),
            fmi3Reset(looker.motor),
            fmi3Terminate(looker.motor),
        ] {
            looker.refused += usize::from(status == Status::Error);
        }
        fmi3FreeInstance(looker.motor);
        if let Some(end) = looker.until {
            *requested = 1;
            *until = end;
        }
    }
}

/// A motor on the way, with its looker; it names the speed and the load.
fn looked_at(early: bool, load: Option<f64>, until: Option<f64>) -> (Three, Box<Looker>) {
    let mut looker = Box::new(Looker { motor: null_mut(), load, until, seen: Vec::new(), refused: 0 });
    let environment = (&raw mut *looker).cast::<c_void>();
    let named = [vr("shaft_speed"), vr("load_torque")];
    let motor = Three::with(false, early, Some((look, environment, &named))).started(&[("voltage", 12.0)]);
    looker.motor = motor.0;
    (motor, looker)
}

#[test]
fn an_importer_looks_into_steps() {
    let (motor, looker) = looked_at(false, None, Some(0.0));
    assert_eq!(motor.step(0.0, 0.04), (false, false, 0.04), "no early return where it is not allowed");
    let times: Vec<f64> = looker.seen.iter().map(|s| s.0).collect();
    assert_eq!(times, [0.01, 0.02, 0.03, 0.04]);
    assert!(looker.seen.iter().all(|s| s.2 && !s.3));
    assert_eq!(looker.refused, 4 * 6);
    // What was seen is what steps to there lead to.
    let plain = Three::with(false, false, None).started(&[("voltage", 12.0)]);
    for (k, (time, speed, ..)) in looker.seen.iter().enumerate() {
        let from = 0.01 * k as f64;
        plain.step(from, time - from);
        assert!((plain.get("shaft_speed") / speed - 1.0).abs() < 1e-12, "{time}");
    }
    assert_eq!(motor.get("shaft_speed"), looker.seen[3].1);
}

#[test]
fn an_importer_sets_inputs_in_the_middle_of_a_step() {
    let (motor, _looker) = looked_at(false, Some(0.05), None);
    motor.step(0.0, 0.04);
    let plain = Three::with(false, false, None).started(&[("voltage", 12.0)]);
    plain.step(0.0, 0.01);
    plain.set("load_torque", 0.05);
    for k in 1..4 {
        plain.step(0.01 * f64::from(k), 0.01);
    }
    let (ours, theirs) = (motor.get("shaft_speed"), plain.get("shaft_speed"));
    assert!((ours / theirs - 1.0).abs() < 1e-12, "{ours} and {theirs}");
}

#[test]
fn an_importer_ends_a_step() {
    for (until, end, looks) in [(0.0, 0.01, 1), (0.01, 0.01, 1), (0.024, 0.024, 3), (0.037, 0.037, 4)] {
        let (motor, looker) = looked_at(true, None, Some(until));
        let (event, early, at) = motor.step(0.0, 0.04);
        assert!(!event && early && (at - end).abs() < 1e-15, "{at} for {until}");
        assert_eq!(looker.seen.len(), looks);
        assert!(!looker.seen[looks - 1].3 || looks == 1, "at its end it cannot end earlier");
        // The run continues from this point.
        let (_, _, on) = motor.step(at, 1e-3);
        assert!(on <= at + 1e-3);
    }
    let (motor, looker) = looked_at(true, None, None);
    assert_eq!(motor.step(0.0, 0.04), (false, false, 0.04));
    assert_eq!(looker.seen.iter().map(|s| s.3).collect::<Vec<_>>(), [true, true, true, false]);
}

#[test]
fn looks_at_what_cannot_be_seen_are_refused() {
    for name in ["over_temperature", "motor.L", "state.current", "time"] {
        let named = [vr("current"), vr(name)];
        assert!(Three::with(false, false, Some((look, null_mut(), &named))).0.is_null(), "{name}");
    }
}
