//! Life cycle of an instance: version, instantiation, initialisation, steps, termination.

use super::*;
/// Tolerance by which a value may exceed its limits, relative to the limits, as the standard allows.
const PRECISION: f64 = 1e-6;

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    versions(subject, seen);
    let mut session = subject.instance("probe")?;
    session.raw.enable_reasons(&subject.facts.categories);
    session.start(&Vec::new())?;
    outputs(&mut session, "after initialisation", seen)?;
    if subject.interface.kind == InterfaceType::ScheduledExecution {
        for clock in subject.facts.select(|v| v.kind == Kind::Clock && v.is("input")) {
            let now = session.now;
            session
                .call("ActivateModelPartition", |raw| raw.activate_partition(clock.reference, now))
                .map_err(|f| f.about(clock, &[]))?;
        }
    } else {
        let mut drive = Drive::new(&mut session)?;
        for _ in 0..runs::steps(subject.facts) {
            if !drive.advance(&mut session, subject.facts.step())? {
                break;
            }
        }
        outputs(&mut session, "after a few steps", seen)?;
    }
    session.call("Terminate", |raw| raw.terminate())?;
    if session.raw.log().has_foreign_environment() {
        let call = subject.facts.pick("the logger", "logMessage");
        seen.add(&subject.interface.place(), rules::logger_environment(call));
    }
    drop(session);
    // With another debug setting another instance is needed.
    if subject.interface.only_once_per_process { Ok(()) } else { categories(subject, seen) }
}

/// NULL is a legal argument of the function that frees, and has no effect.
pub(super) fn free_nothing(subject: &Subject, _: &mut Seen) -> Result<(), Fault> {
    subject.binary.free_null();
    Ok(())
}

fn versions(subject: &Subject, seen: &mut Seen) {
    let (function, wanted) = (subject.facts.function("GetVersion"), subject.facts.pick("2.0", "3.0"));
    let version = subject.binary.version().unwrap_or_default();
    // FMI 3 has maintenance releases such as 3.0.2 in its version string.
    if subject.facts.version == FmiVersion::V2 && version.starts_with("2.") && version != wanted {
        seen.add(&subject.place, rules::version_release(function, short(&version), wanted));
    } else if !(version == wanted || subject.facts.version == FmiVersion::V3 && version.starts_with("3.")) {
        seen.add(&subject.place, rules::version_string(function, short(&version), wanted));
    }
    if let Some(types) = subject.binary.types_platform().filter(|t| t != "default") {
        seen.add(&subject.place, rules::types_platform(short(&types)));
    }
}

/// Outputs are finite, and variables are within the limits of the model description.
fn outputs(session: &mut Session, when: &str, seen: &mut Seen) -> Result<(), Fault> {
    let facts = session.facts;
    for v in facts.select(|v| v.kind.is_numeric() && !v.clocked) {
        let values = session.get(v)?;
        if v.is("output")
            && v.kind.is_float()
            && let Some(value) = values.iter().find(|x| !x.is_finite())
        {
            seen.add(&v.place, rules::output_not_finite(v, value, when));
        } else if let Some(value) = values.iter().find(|x| is_outside(v, **x)) {
            seen.add(&v.place, rules::value_outside(v, value, when, v.limits()));
        }
    }
    Ok(())
}

fn is_outside(v: &Variable, x: f64) -> bool {
    let room = PRECISION * v.nominal.max(x.abs());
    v.min.is_some_and(|m| x < m - room) || v.max.is_some_and(|m| x > m + room)
}

/// With debug logging on, every message has a declared category.
fn categories(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let log = Log::with_debug();
    let Some(mut raw) = subject.try_instance("probe", &subject.facts.token, &log) else {
        return Fault::new(&subject.interface.place(), rules::refused_with_logging());
    };
    let Facts { start, tolerance, .. } = *subject.facts;
    let started = raw.enter_initialization(&Experiment { start, stop: None, tolerance }) <= Status::Warning
        && raw.exit_initialization() <= Status::Warning;
    if started && subject.interface.kind == InterfaceType::CoSimulation {
        raw.do_step(subject.facts.start, subject.facts.step(), false);
    }
    let declared = &subject.facts.categories;
    let messages = log.messages();
    if let Some(m) = messages.iter().find(|m| !m.category.is_empty() && !declared.contains(&m.category)) {
        seen.add(
            &subject.interface.place(),
            rules::log_category_undeclared(short(&m.category), short(m.text.trim())),
        );
    }
    Ok(())
}

/// FMI 3 Co-Simulation with event mode.
pub(super) fn with_events(subject: &Subject, _: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let mut session = subject.with_event_mode()?;
    session.start(&Vec::new())?;
    for k in 1..=runs::steps(facts) {
        let end = session.now + facts.step();
        let h = session.next.filter(|t| *t > session.now).map_or(end, |t| t.min(end)) - session.now;
        let step = session.raw.do_step(session.now, h, false);
        session.ok("DoStep", step.status)?;
        session.now += h;
        if step.terminated {
            break;
        }
        // An importer may have events of its own.
        if k % 3 == 0 || step.event || session.next.is_some_and(|t| session.now >= t) {
            session.call("EnterEventMode", |raw| raw.enter_event_mode())?;
            session.iterate_events()?;
            session.call("EnterStepMode", |raw| raw.enter_step_mode())?;
        }
    }
    session.call("Terminate", |raw| raw.terminate())
}
