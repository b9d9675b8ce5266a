//! FMI 3 Co-Simulation where the importer takes part: events, early return, looks into steps.

use crate::common::{CS3, Fmu, Importer, Look, MOTOR, Options, Succeeds, vr};
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::cell::RefCell;
use std::ptr::null_mut;
use std::rc::Rc;

/// An FMI 3 instance with event mode or early return.
fn three(event_mode: bool, early_return: bool) -> Importer {
    let options = Options { event_mode, early_return, ..Options::default() };
    Importer::instantiated(MOTOR, CS3, options)
}

/// A motor that passes the limit of its winding after some seconds at stall.
const HEATING: &[(&str, f64)] =
    &[("mechanical_mode", 2.0), ("drive_mode", 3.0), ("current_command", 20.0), ("thermal.T_w_max", 303.15)];

/// When the winding passes its limit, by plain steps of a tenth of a millisecond.
fn when_hot() -> f64 {
    let plain = three(false, false).started(HEATING);
    let mut k = 0;
    while !plain.is_hot() {
        plain.ended(f64::from(k) * 1e-4, 1e-4);
        k += 1;
    }
    f64::from(k) * 1e-4
}

#[test]
fn a_step_ends_at_an_event_where_it_may() {
    let hot = when_hot();
    assert!(hot > 0.3, "{hot}");
    let motor = three(true, true).started(HEATING);
    assert_eq!(motor.handle_event(), None);
    let (event, early, at) = motor.ended(0.0, 20.0);
    assert!(event && early);
    assert!(at <= hot + 1e-9 && at > hot - 1.2e-4 - 20.0 * 1e-6, "{at} and {hot}");
    // Past the limit by no more than the tolerance of the event time; the flag changes when the importer handles the event.
    let margin = motor.get("winding_margin");
    assert!(margin < 0.0 && margin > -1e-3, "{margin}");
    assert!(!motor.is_hot());
    // An importer that ignores the event continues, and the next step reports the event again.
    let (again, early, there) = motor.ended(at, 1e-3);
    assert!(again && !early && (there - at - 1e-3).abs() < 1e-12);
    motor.handle_event();
    assert!(motor.is_hot());
    let (event, early, end) = motor.ended(there, 20.0 - there);
    assert_eq!((event, early, end), (false, false, 20.0));
    // A step without event mode gives the same result.
    let plain = three(false, false).started(HEATING);
    assert_eq!(plain.ended(0.0, 20.0), (false, false, 20.0));
    assert!(plain.is_hot());
    for name in ["winding_temperature", "housing_temperature", "energy_electrical"] {
        let (ours, theirs) = (motor.get(name), plain.get(name));
        assert!((ours - theirs).abs() <= 1e-6 * theirs.abs(), "{name}: {ours} and {theirs}");
    }
}

#[test]
fn without_early_return_an_event_is_reported_at_the_end() {
    let motor = three(true, false).started(HEATING);
    motor.handle_event();
    let plain = three(false, false).started(HEATING);
    assert_eq!(motor.ended(0.0, 20.0), (true, false, 20.0));
    plain.ended(0.0, 20.0);
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
    let motor = three(true, true).started(fades);
    assert_eq!(motor.handle_event(), Some(0.35));
    let strong = motor.get("torque_constant");
    let (event, early, at) = motor.ended(0.0, 1.0);
    assert!(event && early && (at - 0.35).abs() < 1e-15, "{at}");
    assert_eq!(motor.handle_event(), None);
    assert!((motor.get("torque_constant") / strong - 0.9).abs() < 1e-3);
    assert_eq!(motor.ended(at, 1.0 - at), (false, false, 1.0));
    let late = three(true, false).started(fades);
    late.handle_event();
    assert_eq!(late.ended(0.0, 1.0), (true, false, 1.0));
    let plain = three(false, false).started(fades);
    assert_eq!(plain.ended(0.0, 1.0), (false, false, 1.0));
    assert_eq!(late.get("shaft_speed").to_bits(), plain.get("shaft_speed").to_bits());
    assert!((motor.get("shaft_speed") / plain.get("shaft_speed") - 1.0).abs() < 1e-9);
}

#[test]
fn event_mode_is_for_those_who_asked_for_it() {
    let plain = three(false, true).started(&[]);
    assert_eq!(plain.enter_event(), Status::Error);
    assert_eq!(plain.iterate().0, Status::Error);
    assert_eq!(unsafe { fmi3EnterStepMode(plain.handle) }, Status::Error);
    let motor = three(true, false).started(&[]);
    // None of what a step reports must be asked for.
    let step =
        || unsafe { fmi3DoStep(motor.handle, 0.0, 1e-3, 1, null_mut(), null_mut(), null_mut(), null_mut()) };
    assert_eq!(step(), Status::Error, "the first event is not over");
    assert_eq!(motor.continue_in_time(), Status::Error, "that is Model Exchange");
    unsafe { fmi3EnterStepMode(motor.handle) }.ok();
    step().ok();
}

/// A saved event is an event again, also through bytes; what discrete outputs show is saved with it.
#[test]
fn an_event_is_saved_and_restored() {
    let motor = three(true, true).started(HEATING);
    motor.handle_event();
    let (_, _, at) = motor.ended(0.0, 20.0);
    let saved = motor.save();
    let fresh = three(true, true);
    fresh.take_over(*motor);
    motor.handle_event();
    assert!(motor.is_hot());
    motor.restore(&saved).ok();
    assert!(!motor.is_hot(), "the event is still to come");
    assert!(!fresh.is_hot());
    assert_eq!(fresh.ended(at, 1e-3), motor.ended(at, 1e-3));
    // One without event mode takes it, and shows what is.
    let plain = three(false, false);
    plain.restore(&saved).ok();
    assert!(plain.is_hot());
}

/// What a look into a step has seen.
#[derive(Default)]
struct Seen {
    /// Time, speed, whether inputs may be set, whether the step may end.
    looks: Vec<(f64, f64, bool, bool)>,
    refused: usize,
}

/// Reads the speed, sets the load, tries what is refused, and requests the end of the step.
fn looker(load: Option<f64>, until: Option<f64>, seen: Rc<RefCell<Seen>>) -> Look {
    Box::new(move |fmu: Fmu, time, sets, may_return| {
        let mut speed = [f64::NAN];
        fmu.get_reals(&[vr("shaft_speed")], &mut speed).ok();
        if let Some(load) = load {
            fmu.set_reals(&[vr("load_torque")], &[load]).ok();
        }
        // What was not named, what is no matter of the middle of a step, and what would take the instance away.
        let refused = [
            fmu.get_reals(&[vr("current")], &mut [0.0]),
            fmu.set_reals(&[vr("motor.L")], &[1e-3]),
            fmu.step(time, 1e-3),
            fmu.get_state(&mut null_mut()),
            fmu.reset(),
            fmu.terminate(),
        ];
        fmu.free();
        let mut seen = seen.borrow_mut();
        seen.refused += refused.iter().filter(|status| **status == Status::Error).count();
        seen.looks.push((time, speed[0], sets, may_return));
        until
    })
}

/// A motor on the way that is looked at; the importer names the speed and the load.
fn looked_at(early_return: bool, load: Option<f64>, until: Option<f64>) -> (Importer, Rc<RefCell<Seen>>) {
    let seen = Rc::default();
    let look = looker(load, until, Rc::clone(&seen));
    let named = [vr("shaft_speed"), vr("load_torque")];
    let options = Options { early_return, ..Options::default() };
    let motor = Importer::tried(MOTOR, CS3, options, Some((&named, look))).expect("an instance");
    (motor.started(&[("voltage", 12.0)]), seen)
}

#[test]
fn an_importer_looks_into_steps() {
    let (motor, seen) = looked_at(false, None, Some(0.0));
    assert_eq!(motor.ended(0.0, 0.04), (false, false, 0.04), "no early return where it is not allowed");
    let Seen { looks, refused } = seen.take();
    assert_eq!(looks.iter().map(|s| s.0).collect::<Vec<_>>(), [0.01, 0.02, 0.03, 0.04]);
    assert!(looks.iter().all(|s| s.2 && !s.3));
    assert_eq!(refused, 4 * 6);
    // What was seen is what steps to there lead to.
    let plain = three(false, false).started(&[("voltage", 12.0)]);
    for (k, (time, speed, ..)) in looks.iter().enumerate() {
        let from = 0.01 * k as f64;
        plain.ended(from, time - from);
        assert!((plain.get("shaft_speed") / speed - 1.0).abs() < 1e-12, "{time}");
    }
    assert_eq!(motor.get("shaft_speed"), looks[3].1);
}

#[test]
fn an_importer_sets_inputs_in_the_middle_of_a_step() {
    let (motor, _) = looked_at(false, Some(0.05), None);
    motor.ended(0.0, 0.04);
    let plain = three(false, false).started(&[("voltage", 12.0)]);
    plain.ended(0.0, 0.01);
    plain.set("load_torque", 0.05);
    for k in 1..4 {
        plain.ended(0.01 * f64::from(k), 0.01);
    }
    let (ours, theirs) = (motor.get("shaft_speed"), plain.get("shaft_speed"));
    assert!((ours / theirs - 1.0).abs() < 1e-12, "{ours} and {theirs}");
}

#[test]
fn an_importer_ends_a_step() {
    for (until, end, count) in [(0.0, 0.01, 1), (0.01, 0.01, 1), (0.024, 0.024, 3), (0.037, 0.037, 4)] {
        let (motor, seen) = looked_at(true, None, Some(until));
        let (event, early, at) = motor.ended(0.0, 0.04);
        assert!(!event && early && (at - end).abs() < 1e-15, "{at} for {until}");
        let looks = seen.take().looks;
        assert_eq!(looks.len(), count);
        assert!(!looks[count - 1].3 || count == 1, "at its end it cannot end earlier");
        // The run continues from this point.
        let (_, _, on) = motor.ended(at, 1e-3);
        assert!(on <= at + 1e-3);
    }
    let (motor, seen) = looked_at(true, None, None);
    assert_eq!(motor.ended(0.0, 0.04), (false, false, 0.04));
    assert_eq!(seen.take().looks.iter().map(|s| s.3).collect::<Vec<_>>(), [true, true, true, false]);
}

#[test]
fn looks_at_what_cannot_be_seen_are_refused() {
    for name in ["over_temperature", "motor.L", "state.current", "time"] {
        let named = [vr("current"), vr(name)];
        let look_at = Some((&named[..], looker(None, None, Rc::default())));
        assert!(Importer::tried(MOTOR, CS3, Options::default(), look_at).is_err(), "{name}");
    }
}
