//! FMI 3 Co-Simulation where the importer takes part: events, early return, looks into steps.

use crate::common::{CS2, CS3, Fmu, Importer, Look, MOTOR, Options, Succeeds, shortened, vr};
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

/// End of a step in which it does so, s.
const END: f64 = if cfg!(miri) { 0.6 } else { 20.0 };
/// Step of [`when_hot`], s.
const FINE: f64 = if cfg!(miri) { 0.02 } else { 1e-4 };

/// When the winding passes its limit, by plain short steps.
fn when_hot() -> f64 {
    let plain = three(false, false).started(HEATING);
    let mut k = 0;
    while !plain.is_hot() {
        plain.ended(f64::from(k) * FINE, FINE);
        k += 1;
    }
    f64::from(k) * FINE
}

#[test]
fn a_step_ends_at_an_event_where_it_may() {
    let hot = when_hot();
    assert!(hot > 0.3, "{hot}");
    let motor = three(true, true).started(HEATING);
    assert_eq!(motor.handle_event(), None);
    let (event, early, at) = motor.ended(0.0, END);
    assert!(event && early);
    assert!(at <= hot + 1e-9 && at > hot - 1.2 * FINE - END * 1e-6, "{at} and {hot}");
    // Past the limit by no more than the tolerance of the event time; the flag changes when the importer handles the event.
    let margin = motor.get("winding_margin");
    assert!(margin < 0.0 && margin > -1e-3, "{margin}");
    assert!(!motor.is_hot());
    // An importer that ignores the event continues, and the next step reports the event again.
    let (again, early, there) = motor.ended(at, 1e-3);
    assert!(again && !early && (there - at - 1e-3).abs() < 1e-12);
    motor.handle_event();
    assert!(motor.is_hot());
    let (event, early, end) = motor.ended(there, END - there);
    assert_eq!((event, early, end), (false, false, END));
    // A step without event mode gives the same result.
    let plain = three(false, false).started(HEATING);
    assert_eq!(plain.ended(0.0, END), (false, false, END));
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
    assert_eq!(motor.ended(0.0, END), (true, false, END));
    plain.ended(0.0, END);
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
    let (_, _, at) = motor.ended(0.0, END);
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
    plain.restore(&plain.read(&saved.bytes()).unwrap()).ok();
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

/// Sets the load along a line from 0 at the start, N.m/s.
fn loader(slope: f64) -> Look {
    Box::new(move |fmu: Fmu, time, sets, _| {
        assert!(sets);
        fmu.set_reals(&[vr("load_torque")], &[slope * time]).ok();
        None
    })
}

/// A motor whose load the importer moves in intermediate update mode.
fn loaded(look: Look, options: Options) -> Importer {
    let named = [vr("shaft_speed"), vr("load_torque")];
    let motor = Importer::tried(MOTOR, CS3, options, Some((&named, look))).expect("an instance");
    motor.started(&[("voltage", 12.0)])
}

/// The speed after steps of length `h` to 40 ms, with the input derivatives of FMI 2.
fn sloped(h: f64, slope: f64) -> f64 {
    let plain = Importer::instantiated(MOTOR, CS2, Options::default()).started(&[("voltage", 12.0)]);
    for k in 0..(0.04 / h).round() as u32 {
        plain.set_slopes(&[vr("load_torque")], &[1], &[slope]).ok();
        plain.step(h * f64::from(k), h).ok();
    }
    plain.get("shaft_speed")
}

/// Inputs that are set after each part are lines over it: the result is that of input derivatives in FMI 2.
#[test]
fn inputs_that_an_importer_sets_within_a_step_are_lines() {
    for event_mode in [false, true] {
        let motor = loaded(loader(2.0), Options { event_mode, ..Options::default() });
        if event_mode {
            motor.handle_event();
        }
        assert_eq!(motor.ended(0.0, 0.04), (false, false, 0.04));
        let (ours, theirs) = (motor.get("shaft_speed"), sloped(0.01, 2.0));
        assert!((ours / theirs - 1.0).abs() < 1e-12, "{ours} and {theirs}");
        assert_eq!(motor.get("load_torque"), 2.0 * 0.04);
        // Held in each part, the load would be too low on average.
        let held = three(false, false).started(&[("voltage", 12.0)]);
        for k in 0..4 {
            held.set("load_torque", 0.02 * f64::from(k));
            held.ended(0.01 * f64::from(k), 0.01);
        }
        assert!((held.get("shaft_speed") / theirs - 1.0).abs() > 1e-3);
    }
}

/// An importer that names inputs alone gets one part: the bits of a step with input derivatives in FMI 2.
#[test]
fn a_step_with_inputs_alone_is_one_part() {
    let look: Look = Box::new(|fmu: Fmu, time, _, _| {
        assert_eq!(time, 0.04);
        fmu.set_reals(&[vr("load_torque")], &[2.0 * time]).ok();
        None
    });
    let named = [vr("load_torque")];
    let motor = Importer::tried(MOTOR, CS3, Options::default(), Some((&named, look))).expect("an instance");
    let motor = motor.started(&[("voltage", 12.0)]);
    assert_eq!(motor.ended(0.0, 0.04), (false, false, 0.04));
    assert_eq!(motor.get("shaft_speed"), sloped(0.04, 2.0));
}

/// The load is t^2, which lines follow with second order of the part.
#[test]
fn a_curved_input_converges_with_second_order() {
    let speed = |steps: u32| {
        let look: Look = Box::new(|fmu: Fmu, time, _, _| {
            fmu.set_reals(&[vr("load_torque")], &[50.0 * time * time]).ok();
            None
        });
        let motor = loaded(look, Options::default());
        let h = 0.04 / f64::from(steps);
        for k in 0..steps {
            motor.ended(h * f64::from(k), h);
        }
        motor.get("shaft_speed")
    };
    let exact = speed(shortened(128, 16) as u32);
    let counts: &[u32] = if cfg!(miri) { &[2, 4] } else { &[4, 8, 16] };
    let errors: Vec<f64> = counts.iter().map(|steps| (speed(*steps) - exact).abs()).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.2, "order {order}, {errors:?}");
    }
}

/// A part that ends the run at a limit of validity stays ended.
#[test]
fn a_line_over_the_limit_of_validity_ends_the_run() {
    let named = [vr("current_command")];
    let look: Look = Box::new(|fmu: Fmu, time, _, _| {
        let _ = fmu.set_reals(&[vr("current_command")], &[200.0 * time]);
        None
    });
    let motor = Importer::tried(MOTOR, CS3, Options::default(), Some((&named, look))).expect("an instance");
    let motor = motor.started(&[("mechanical_mode", 2.0), ("drive_mode", 3.0)]);
    let mut at = 0.0;
    for _ in 0..1000 {
        let (mut terminate, mut reached) = (0, at);
        let terminated: *mut u8 = &mut terminate;
        unsafe { fmi3DoStep(motor.handle, at, 0.1, 1, null_mut(), terminated, null_mut(), &mut reached) }
            .ok();
        if terminate != 0 {
            assert!(reached >= at && reached <= at + 0.1, "{at} {reached}");
            assert!(motor.get("winding_temperature") <= 543.15 + 1e-6);
            return;
        }
        at = reached;
    }
    panic!("the run did not end");
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
