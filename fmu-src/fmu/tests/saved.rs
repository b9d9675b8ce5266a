//! Saved states, and that both standards compute the same numbers: in every model and interface type.

use crate::common::running::{Running, STEPS, busy};
use crate::common::{CS2, CS3, Importer, KINDS, MODELS, Options, Succeeds, shortened, vr};
use motor_fmu::logger::Status;
use std::ptr::null_mut;

#[test]
fn rollback_is_bitwise_in_memory_and_through_bytes() {
    for (number, kind) in MODELS.iter().enumerate() {
        // In Miri one for each model.
        for how in KINDS.into_iter().skip(shortened(0, number)).take(shortened(KINDS.len(), 1)) {
            let mut one = Running::new(kind, how, &busy(kind));
            one.run(0);
            let saved = one.importer.save();
            let there = one.run(STEPS);
            if one.importer.exchange {
                one.importer.enter_event().ok();
                one.importer.update();
            }
            one.importer.restore(&saved).ok();
            assert_eq!(one.run(STEPS), there, "{how:?}: from memory");
            let bytes = saved.bytes();
            let mut other = Running::of(Importer::instantiated(kind, how, Options::default()));
            other.importer.restore(&other.importer.read(&bytes).unwrap()).ok();
            assert_eq!(other.run(STEPS), there, "{how:?}: from bytes, in another instance");
            let stranger = Importer::instantiated(kind, (how.0, !how.1), Options::default());
            assert_eq!(stranger.restore(&saved), Status::Error, "the other interface");
            assert_eq!(stranger.read(&bytes).err(), Some(Status::Error));
        }
    }
}

/// With event mode, too, as long as there is no event.
#[test]
fn both_standards_give_the_same_bits_in_every_step() {
    for kind in MODELS {
        let mut two = Running::new(kind, CS2, &[]);
        let there = two.run(0);
        for event_mode in [false, true] {
            let options = Options { event_mode, ..Options::default() };
            let three = Importer::instantiated(kind, CS3, options).started(&[]);
            if event_mode {
                three.handle_event();
            }
            assert_eq!(Running::of(three).run(0), there, "event mode: {event_mode}");
        }
    }
}

/// A tunable whole number is set between steps, within its limits, and is a part of the state.
#[test]
fn a_whole_number_is_set_read_and_saved() {
    let (name, reference) = ("motor.pole_pairs", [vr("motor.pole_pairs")]);
    for how in [CS2, CS3] {
        let [motor, other] = [(); 2].map(|()| Importer::motor(how));
        motor.initialize();
        assert_eq!(motor.get_whole(name), 2);
        let saved = motor.save();
        motor.set_whole(&reference, &[11]).ok();
        assert_eq!([0, i64::MAX].map(|n| motor.set_whole(&reference, &[n])), [Status::Discard; 2]);
        assert_eq!(motor.get_whole(name), 11);
        other.take_over(*motor);
        assert_eq!(other.get_whole(name), 11);
        motor.restore(&saved).ok();
        assert_eq!(motor.get_whole(name), 2);
    }
}

#[test]
fn a_handle_is_used_again_and_freed_twice() {
    let motor = Importer::motor(CS2).started(&[]);
    let mut saved = motor.save();
    let first = saved.state;
    motor.get_state(&mut saved.state).ok();
    assert_eq!(saved.state, first);
    // Here, and again at the end.
    motor.free_state(&mut saved.state).ok();
    assert!(saved.state.is_null());
    assert_eq!(motor.set_state(null_mut()), Status::Error);
}

#[test]
fn damaged_bytes_are_refused() {
    let motor = Importer::motor(CS2).started(&[]);
    let saved = motor.save();
    let mut bytes = saved.bytes();
    let size = bytes.len();
    let every = shortened(1, 499);
    assert_eq!(motor.serialize(saved.state, &mut vec![0; size - 1]), Status::Error);
    for n in (0..size).step_by(every) {
        assert_eq!(motor.read(&bytes[..n]).err(), Some(Status::Error), "{n} bytes");
    }
    for n in (0..size).step_by(every) {
        bytes[n] ^= 1 << (n % 8);
        assert_eq!(motor.read(&bytes).err(), Some(Status::Error), "byte {n}");
        bytes[n] ^= 1 << (n % 8);
    }
}

#[test]
fn an_invalid_number_is_refused_with_a_correct_checksum() {
    let motor = Importer::motor(CS2).started(&[]);
    let mut bytes = motor.save().bytes();
    // Magic, checksum, interface, mode, length of the token, token, count; then window and factor on the tolerance.
    let token = u32::from_le_bytes(bytes[14..18].try_into().expect("four bytes")) as usize;
    let tolerance = 18 + token + 4 + 2 * 8;
    assert_eq!(bytes[tolerance..][..8], 1.0f64.to_le_bytes());
    assert!(motor.read(&bytes).is_ok());
    bytes[tolerance + 7] ^= 0x80;
    motor_fmu::saved::seal(&mut bytes);
    assert_eq!(motor.read(&bytes).err(), Some(Status::Error));
}
