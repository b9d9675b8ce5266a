//! Logging in both standards and both interface types: categories, reasons, events, rejected steps, silence.

use crate::common::{
    CS2, CS3, Importer, KINDS, LOGGED, Look, ME3, MODELS, MOTOR, Message, Options, Succeeds, shortened, vr,
};
use crate::counting::allocations;
use motor_fmu::logger::{ALL, CATEGORIES, Category, Status, c_string, escaped};

const SILENT: Options = Options { logging: false, ..LOGGED };
const EVENTS: Options = Options { event_mode: true, early_return: true, ..LOGGED };

/// A motor that heats beyond the limit of its winding: an event in every mode.
const HOT: [(&str, f64); 4] = [
    ("drive_mode", 3.0),
    ("mechanical_mode", 2.0),
    ("current_command", 40.0),
    ("thermal.T_w_max", if cfg!(miri) { 303.15 } else { 428.15 }),
];
/// Time after which it is hot, s.
const HOT_AFTER: f64 = if cfg!(miri) { 0.1 } else { 4.0 };

#[test]
fn with_logging_off_nothing_is_sent() {
    for kind in MODELS {
        for how in KINDS {
            let one = Importer::instantiated(kind, how, SILENT).started(&[]);
            one.set_all(&[]).ok();
            assert_eq!(one.step(0.0, -1.0), Status::Error);
            assert_eq!(one.exit_initialization(), Status::Error);
            one.terminate().ok();
            one.reset().ok();
            assert_eq!(one.heard(), []);
        }
    }
}

/// Every status other than OK has a message with this status in its category, and every message has a declared category.
#[test]
fn every_status_has_its_reason() {
    for how in KINDS {
        let one = Importer::instantiated(MOTOR, how, LOGGED).started(&[]);
        one.heard();
        let calls: [fn(&Importer) -> Status; 5] = [
            |one| one.set("load_torque", f64::NAN),
            |one| one.set("current", 1.0),
            |one| one.set("fan_command", 3.0),
            |one| one.exit_initialization(),
            |one| one.step(0.0, -1.0),
        ];
        for call in calls {
            let status = call(&one);
            assert_ne!(status, Status::Ok);
            let heard = one.heard();
            let category = CATEGORIES[3 - status as usize].0;
            assert_eq!(heard.len(), 1, "{heard:?}");
            assert_eq!((heard[0].status, heard[0].category.as_str()), (status as i32, category));
        }
    }
}

/// The states of the life cycle, in their order.
#[test]
fn changes_of_the_state_are_events() {
    for (how, words) in [
        (
            CS2,
            &["instantiated", "start time", "in initialization mode", "in step mode", "terminated", "reset"]
                [..],
        ),
        (
            ME3,
            &[
                "instantiated",
                "start time",
                "in initialization mode",
                "in event mode",
                "event",
                "in continuous-time",
            ],
        ),
    ] {
        let one = Importer::instantiated(MOTOR, how, LOGGED).started(&[]);
        one.terminate().ok();
        one.reset().ok();
        let heard = one.heard();
        assert!(heard.iter().all(|m| (m.status, m.category.as_str()) == (0, "logEvents")), "{heard:?}");
        let mut rest = heard.iter();
        for word in words {
            assert!(rest.any(|m| m.text.contains(word)), "{word} in {heard:?}");
        }
    }
}

#[test]
fn events_and_rejected_steps_are_logged() {
    for (how, options) in [(CS2, LOGGED), (CS3, LOGGED), (CS3, EVENTS)] {
        let one = Importer::instantiated(MOTOR, how, options).started(&HOT);
        if options.event_mode {
            one.handle_event();
        }
        one.heard();
        one.step(0.0, HOT_AFTER).ok();
        let heard = one.heard();
        let has = |category: &str, words: &str| {
            heard.iter().any(|m| m.status == 0 && m.category == category && m.text.contains(words))
        };
        assert!(has("logEvents", "over_temperature becomes true"), "{heard:?}");
        assert!(has("logRejectedSteps", "rejected"), "{heard:?}");
    }
    let strength = [("effect.demagnetisation.fraction", 0.1), ("effect.demagnetisation.time", 0.5)];
    let one = Importer::instantiated(MOTOR, CS2, LOGGED).started(&strength);
    one.step(0.0, 1.0).ok();
    assert!(one.heard().iter().any(|m| m.text.contains("time event at 0.5 s")));
}

/// Categories are enabled and disabled one by one; `logAll` is all of them; an unknown one is refused without effect.
#[test]
fn categories_are_honoured() {
    for how in KINDS {
        let one = Importer::instantiated(MOTOR, how, SILENT);
        let heard = |call: &dyn Fn()| -> Vec<String> {
            one.heard();
            call();
            one.heard().into_iter().map(|Message { category, .. }| category).collect()
        };
        let all = || {
            assert_eq!(one.set("load_torque", f64::NAN), Status::Discard);
            assert_eq!(one.step(0.0, -1.0), Status::Error);
            one.reset().ok();
        };
        assert!(heard(&all).is_empty());
        one.set_logging(true, &[c"logEvents"]).ok();
        assert_eq!(heard(&all), ["logEvents"; 2]);
        one.set_logging(true, &[c"logStatusError"]).ok();
        assert_eq!(heard(&all), ["logStatusError", "logEvents", "logEvents"]);
        one.set_logging(false, &[c"logEvents"]).ok();
        assert_eq!(heard(&all), ["logStatusError"]);
        let everything = ["logStatusDiscard", "logStatusError", "logEvents", "logEvents"];
        one.set_logging(true, &[c"logAll"]).ok();
        assert_eq!(heard(&all), everything);
        one.heard();
        assert_eq!(one.set_logging(false, &[c"logEvents", c"logNothing"]), Status::Error);
        assert!(one.heard()[0].text.contains("logNothing"));
        assert_eq!(heard(&all), everything, "a refused call changes nothing");
        one.set_logging(false, &[]).ok();
        assert!(heard(&all).is_empty());
        one.set_logging(true, &[]).ok();
        assert_eq!(heard(&all), everything);
    }
}

/// Why no instance is made is logged although logging is off, because nothing could enable it.
#[test]
fn a_failed_instantiation_says_why() {
    let seen = [vr("drive_mode")];
    let look = Some((&seen[..], Box::new(|_, _, _, _| None) as Look));
    let Err(messages) = Importer::tried(MOTOR, CS3, SILENT, look) else { panic!("made") };
    assert!(messages.len() == 1 && messages[0].category == "logStatusError", "{messages:?}");
}

/// Logging changes no result, bit for bit, and without it a step allocates no memory, saturation of an input included.
#[test]
fn logging_changes_no_result_and_costs_nothing_when_off() {
    for how in [CS2, CS3] {
        let modes = [("cooling_mode", 4.0), ("commutation", 2.0), ("drive_mode", 2.0), ("voltage", 40.0)];
        let (on, off) =
            (Importer::instantiated(MOTOR, how, LOGGED), Importer::instantiated(MOTOR, how, SILENT));
        let (on, off) = (on.started(&modes), off.started(&modes));
        let duty = [vr("duty")];
        let mut used = [0; 2];
        for k in 0..shortened(200, 2) {
            let t = k as f64 * 0.02;
            for (one, used) in [&on, &off].into_iter().zip(&mut used) {
                let values = [1.3 * (shortened(3, 60) as f64 * t).sin()];
                *used += allocations(|| {
                    assert!(one.set_reals(&duty, &values) <= Status::Warning);
                    one.step(t, 0.02).ok();
                });
            }
        }
        assert!(on.outputs() == off.outputs() && on.heard().len() > 2 && off.heard().is_empty());
        assert!(used[0] > 0 && used[1] == 0, "{used:?}");
    }
}

#[test]
fn categories_have_their_places_and_the_last_one_stands_for_all() {
    for (category, name) in [
        (Category::Error, "logStatusError"),
        (Category::Discard, "logStatusDiscard"),
        (Category::Warning, "logStatusWarning"),
        (Category::Events, "logEvents"),
        (Category::Steps, "logRejectedSteps"),
    ] {
        assert_eq!(category.name(), name);
    }
    assert_eq!(CATEGORIES.last().map(|(name, _)| *name), Some("logAll"));
    assert_eq!(ALL.count_ones() as usize, CATEGORIES.len() - 1);
}

#[test]
fn a_zero_and_a_hash_do_not_reach_the_importer() {
    assert_eq!(c_string("a\0b").as_c_str(), c"a b");
    assert_eq!(escaped("segment #3"), "segment ##3");
}
