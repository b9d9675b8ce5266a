//! Saved states: going back, freeing, and bytes.

use super::*;
use cosim::raw::RawState;

pub(super) fn run(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let base = subject.base()?;
    let (h, n) = (subject.facts.step(), steps(subject.facts));
    let (before, after) = (n / 3, n - n / 3);
    let names = match subject.facts.version {
        FmiVersion::V2 => {
            ["GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializeFMUstate", "DeSerializeFMUstate"]
        }
        FmiVersion::V3 => {
            ["GetFMUState", "SetFMUState", "FreeFMUState", "SerializeFMUState", "DeserializeFMUState"]
        }
    };
    let mut session = subject.started(&base.settings)?;
    Drive::new(&mut session)?.rows(&mut session, h, before)?;
    let (now, next) = (session.now, session.next);
    let mut state = RawState::NONE;
    session.call(names[0], |raw| raw.save(&mut state))?;
    let onwards = |session: &mut Session| -> Result<Rows, Fault> {
        let mut rows = vec![session.observe()?];
        rows.extend(Drive::new(session)?.rows(session, h, after)?);
        Ok(rows)
    };
    let first = onwards(&mut session)?;
    // Inputs belong to the state, so they are moved before it is set again.
    for v in subject.facts.inputs() {
        let start = v.start.clone();
        session.set(v, &start)?;
    }
    let back = |session: &mut Session, state: &_| -> Result<Rows, Fault> {
        session.call(names[1], |raw| raw.restore(state))?;
        (session.now, session.next) = (now, next);
        onwards(session)
    };
    let second = back(&mut session, &state)?;
    compare(subject, &first, &second, &rules::ROLLBACK, "after going back to the saved state", seen)?;

    if subject.interface.can_serialize_state {
        let mut size = 0;
        session.call(names[3], |raw| raw.state_size(&state, &mut size))?;
        let mut bytes = vec![0; size];
        session.call(names[3], |raw| raw.serialize(&state, &mut bytes))?;
        let copy = from_bytes(&mut session, &bytes, names[4])?;
        let third = back(&mut session, &copy)?;
        compare(subject, &first, &third, &rules::SERIALIZE, "from the state's bytes", seen)?;
        free(&mut session, copy, names[2], seen)?;
        if !subject.interface.only_once_per_process {
            let mut other = subject.started(&Vec::new())?;
            let copy = from_bytes(&mut other, &bytes, names[4])?;
            let fourth = back(&mut other, &copy)?;
            compare(
                subject,
                &first,
                &fourth,
                &rules::SERIALIZE,
                "from the state's bytes in a new instance",
                seen,
            )?;
            free(&mut other, copy, names[2], seen)?;
        }
    }
    // A state that is passed to the get function is overwritten.
    session.call(names[0], |raw| raw.save(&mut state))?;
    free(&mut session, state, names[2], seen)
}

fn from_bytes(session: &mut Session, bytes: &[u8], name: &str) -> Result<RawState, Fault> {
    let mut state = RawState::NONE;
    session.call(name, |raw| raw.deserialize(bytes, &mut state))?;
    Ok(state)
}

fn free(session: &mut Session, mut state: RawState, name: &str, seen: &mut Seen) -> Result<(), Fault> {
    session.call(name, |raw| raw.free_state(&mut state))?;
    if !state.is_none() {
        seen.add(&session.interface.place(), rules::state_pointer(name));
    }
    Ok(())
}

fn compare(
    subject: &Subject,
    a: &Rows,
    b: &Rows,
    rule: &'static Rule,
    words: &str,
    seen: &mut Seen,
) -> Result<(), Fault> {
    let Some(d) = difference(subject.facts, &subject.base()?.steady, a, b) else { return Ok(()) };
    let rule = if d.relative <= solver_error(subject.facts) { &rules::ROLLBACK_INEXACT } else { rule };
    let when = if d.row == 0 { "at once".to_owned() } else { d.when() };
    let message = format!("Variable \"{}\" is {} and then {} {words} ({when})", d.name, d.first, d.second);
    seen.add(&d.variable.place, rule.says(message));
    Ok(())
}
