//! Which calls are allowed in which state: one table for all functions, against the state machines of FMI 2.0.5 (sections 3.2.3 and
//! 4.2.4) and FMI 3.0.2 (sections 2.3, 3.2 and 4.2). A call that is not allowed returns Error and changes nothing.
//!
//! Two calls are allowed beyond FMI 2.0.5, because importers make them: fmi2SetTime in event mode (FMI 2.0 of 2014), and reading start
//! values before initialization in FMI 3.0.

use crate::common::{CS2, CS3, How, Importer, ME2, ME3, MOTOR, Options, Succeeds, vr};
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::*;
use motor_fmu::logger::Status;
use std::ptr::null_mut;

/// An interface: standard, interface type, whether event mode is used.
const INTERFACES: [(How, bool); 5] = [(CS2, false), (ME2, false), (CS3, false), (CS3, true), (ME3, false)];

/// States by letter: instantiated, initialization, step, event, continuous-time, terminated, error.
const STATES: &str = "INSVCTX";

/// States that an interface has.
fn states((_, exchange): How, events: bool) -> &'static str {
    match (exchange, events) {
        (true, _) => "INVCTX",
        (false, true) => "INVSTX",
        (false, false) => "INSTX",
    }
}

fn at(how: How, event_mode: bool, state: char) -> Importer {
    let one = Importer::instantiated(MOTOR, how, Options { event_mode, ..Options::default() });
    if state == 'I' {
        return one;
    }
    one.enter(None, 0.0).ok();
    if state == 'N' {
        return one;
    }
    one.exit_initialization().ok();
    let in_event = how.1 || event_mode;
    if in_event && state != 'V' {
        one.iterate();
        match how.1 {
            true => one.continue_in_time().ok(),
            false => unsafe { fmi3EnterStepMode(one.handle) }.ok(),
        }
    }
    match state {
        'T' => one.terminate().ok(),
        'X' => {
            // A panic without its message on the standard error.
            let panic = |_: &mut _| std::panic::resume_unwind(Box::new(()));
            let status = unsafe { motor_fmu::boundary::enter(one.handle, "test", panic) };
            assert_eq!(status, Status::Error);
        }
        _ => {}
    }
    one
}

/// A call with the states in which each interface of [`INTERFACES`] allows it.
type Row = (&'static str, fn(&Importer) -> Status, [&'static str; 5]);

const NONE: [&str; 5] = [""; 5];
const ALL: [&str; 5] = [STATES; 5];

fn state_of(one: &Importer) -> Status {
    one.try_save().err().unwrap_or(Status::Ok)
}

#[rustfmt::skip]
const TABLE: &[Row] = &[
    ("set input", |one| one.set("load_torque", 0.01), ["INS", "INVC", "INS", "INVS", "INVC"]),
    ("set tunable", |one| one.set("motor.R_ref", 0.4), ["INS", "INV", "INS", "INV", "INV"]),
    ("set fixed", |one| one.set("drive_mode", 2.0), ["IN"; 5]),
    ("set output", |one| one.set("current", 1.0), NONE),
    ("get output", |one| one.get_reals(&[vr("current")], &mut [0.0]), ["NSTX", "NVCTX", "NSTX", "NVSTX", "NVCTX"]),
    ("enter initialization", |one| one.enter(None, 0.0), ["I"; 5]),
    ("exit initialization", |one| one.exit_initialization(), ["N"; 5]),
    ("terminate", |one| one.terminate(), ["S", "VC", "S", "VS", "VC"]),
    ("reset", |one| one.reset(), ALL),
    ("get state", state_of, ALL),
    ("directional", |one| one.directional(&[vr("shaft_torque")], &[vr("load_torque")], &[1.0], &mut [0.0]),
        ["NSTX", "NVCTX", "NSTX", "NVSTX", "NVCTX"]),
    ("output derivatives", |one| one.get_slopes(&[vr("current")], &[1], &mut [0.0]), ["STX", "", "STX", "STX", ""]),
    ("logging", |one| one.set_logging(true, &[]), ALL),
    ("step", |one| one.step(0.0, 1e-3), ["S", "", "S", "S", ""]),
    ("enter event mode", |one| one.enter_event(), ["", "VC", "", "S", "C"]),
    ("event iteration", |one| one.iterate().0, ["", "V", "", "V", "V"]),
    ("enter continuous-time mode", |one| one.continue_in_time(), ["", "V", "", "", "V"]),
    ("completed integrator step", |one| one.complete().0, ["", "C", "", "", "C"]),
    ("set time", |one| one.set_time(0.0), ["", "VC", "", "", "C"]),
    ("set states", |one| one.set_states(&vec![300.0; one.number_of_states()]), ["", "C", "", "", "C"]),
    ("get states", |one| one.get_states(&mut vec![0.0; one.number_of_states()]), ["", "NVCTX", "", "", "NVCTX"]),
    ("derivatives", |one| one.get_rates(&mut vec![0.0; one.number_of_states()]), ["", "NVCTX", "", "", "NVCTX"]),
    ("event indicators", |one| one.get_indicators(&mut vec![0.0; one.declaration.indicators.len()]),
        ["", "NVCTX", "", "", "NVCTX"]),
];

/// Functions of one standard alone.
#[rustfmt::skip]
const ONLY_2: &[Row] = &[
    ("setup", |one| unsafe { fmi2SetupExperiment(one.handle, 0, 0.0, 0.0, 0, 0.0) }, ["I", "I", "", "", ""]),
    ("input derivatives", |one| unsafe { fmi2SetRealInputDerivatives(one.handle, &vr("voltage"), 1, &1, &0.0) },
        ["INS", "", "", "", ""]),
    ("nominals", |one| {
        let mut x = vec![0.0; one.number_of_states()];
        unsafe { fmi2GetNominalsOfContinuousStates(one.handle, x.as_mut_ptr(), x.len()) }
    }, ["", "INVCTX", "", "", ""]),
    ("last successful time", |one| unsafe { fmi2GetRealStatus(one.handle, 2, &mut 0.0) }, ["ST", "", "", "", ""]),
    ("terminated", |one| unsafe { fmi2GetBooleanStatus(one.handle, 3, &mut 0) }, ["ST", "", "", "", ""]),
    ("pending", |one| unsafe { fmi2GetStatus(one.handle, 0, &mut Status::Ok) }, ["ST", "", "", "", ""]),
    ("cancel", |one| unsafe { fmi2CancelStep(one.handle) }, NONE),
];
#[rustfmt::skip]
const ONLY_3: &[Row] = &[
    ("configuration", |one| unsafe { fmi3EnterConfigurationMode(one.handle) }, ["", "", "I", "I", "I"]),
    ("end of configuration", |one| unsafe { fmi3ExitConfigurationMode(one.handle) }, NONE),
    ("enter step mode", |one| unsafe { fmi3EnterStepMode(one.handle) }, ["", "", "", "V", ""]),
    ("discrete states", |one| unsafe { fmi3EvaluateDiscreteStates(one.handle) }, ["", "", "", "V", "V"]),
    ("nominals", |one| {
        let mut x = vec![0.0; one.number_of_states()];
        unsafe { fmi3GetNominalsOfContinuousStates(one.handle, x.as_mut_ptr(), x.len()) }
    }, ["", "", "", "", "NVCTX"]),
    ("clock", |one| unsafe { fmi3GetClock(one.handle, &1, 1, null_mut()) }, NONE),
];

#[test]
fn calls_are_allowed_where_the_standards_allow_them() {
    for (k, (how, events)) in INTERFACES.into_iter().enumerate() {
        let own = if how.0 { ONLY_3 } else { ONLY_2 };
        for (name, call, allowed) in TABLE.iter().chain(own) {
            let mut was_refused = false;
            for state in states(how, events).chars() {
                let expected = allowed[k].contains(state);
                // In Miri one state that refuses the call has to do.
                if cfg!(miri) && was_refused && !expected {
                    continue;
                }
                was_refused |= !expected;
                let one = at(how, events, state);
                let status = call(&one);
                let place = format!("{name} in state {state} of {how:?}, event mode {events}: {status:?}");
                assert_eq!(status != Status::Error, expected, "{place}");
                if !expected && state != 'X' {
                    // The refused call has not left the state.
                    assert_eq!(one.terminate() == Status::Ok, "SVC".contains(state), "{place}");
                }
            }
        }
    }
}

/// A saved state is restored in every state, and ends the error state.
#[test]
fn a_saved_state_is_restored_in_every_state() {
    for (how, events) in INTERFACES {
        for state in states(how, events).chars() {
            let other = at(how, events, state);
            other.take_over(*at(how, events, 'N'));
            other.exit_initialization().ok();
        }
    }
}

/// A pointer that is no saved state, that of another instance, and one that was freed are refused.
#[test]
fn a_handle_that_is_no_saved_state_is_refused() {
    for how in [CS2, ME2, CS3, ME3] {
        let one = at(how, false, 'N');
        let mut foreign = vec![0x5a_u8; 4096];
        let (mut aligned, mut number) = (foreign.as_mut_ptr().cast(), 7);
        assert_eq!(one.set_state(aligned), Status::Error);
        assert_eq!(one.get_state(&mut aligned), Status::Error);
        assert_eq!(one.free_state(&mut aligned), Status::Error);
        assert_eq!(one.state_size(aligned, &mut number), Status::Error);
        assert_eq!((aligned, number), (foreign.as_mut_ptr().cast(), 7));
        assert_eq!(one.serialize(unsafe { aligned.byte_add(1) }, &mut [0; 8]), Status::Error, "not aligned");
        assert_eq!(one.set_state(null_mut()), Status::Error);
        let saved = one.save();
        assert_eq!(at(how, false, 'N').set_state(saved.state), Status::Error);
        one.set_state(saved.state).ok();
        let (mut first, freed) = (saved.state, saved.state);
        std::mem::forget(saved);
        one.free_state(&mut first).ok();
        assert!(first.is_null());
        assert_eq!(one.set_state(freed), Status::Error);
    }
}

/// The logger may call functions of the instance: no reference to it is alive then.
#[test]
fn results_go_to_memory_that_was_never_written() {
    use std::mem::MaybeUninit;
    let one = at(ME2, false, 'C');
    let n = one.number_of_states();
    let mut x = Vec::<MaybeUninit<f64>>::with_capacity(n);
    unsafe {
        fmi2GetContinuousStates(one.handle, x.as_mut_ptr().cast(), n).ok();
        x.set_len(n);
        assert!(x.iter().all(|x| x.assume_init().is_finite()));
        let mut info = MaybeUninit::<EventInfo>::uninit();
        one.enter_event().ok();
        fmi2NewDiscreteStates(one.handle, info.as_mut_ptr()).ok();
        assert_eq!(info.assume_init().new_discrete_states_needed, 0);
    }
}
