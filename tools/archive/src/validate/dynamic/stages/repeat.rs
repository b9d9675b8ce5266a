//! Repetition of a run: in a second instance, after a reset, together with another instance, a thousand times.

use super::*;
use std::time::{Duration, Instant};

/// Instances made in each of up to four rounds, and bytes that each may leave behind.
const ROUND: usize = 400;
const LEAK: f64 = 128.0;
/// Bytes that a step, or a state saved and freed, may leave behind.
const STEP_LEAK: f64 = 24.0;
const STEP_ROUND: usize = 10_000;
/// Time limit of the repetitions.
const PATIENCE: Duration = Duration::from_millis(1500);

pub(super) fn reset(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let base = subject.base()?;
    if let Some(index) = base.steady.iter().position(|steady| !steady) {
        let (name, variable) = column(facts, index);
        seen.add(&variable.place, rules::not_deterministic(name));
    }
    // A run with other values, which a reset must clear.
    let free = facts.select(Variable::is_free);
    let mut session = subject.started(&others(subject, &free))?;
    runs::from_here(&mut session)?;
    session.call("Terminate", |raw| raw.terminate())?;
    after_reset(&mut session, subject, "after the end of a run", seen)?;
    after_reset(&mut session, subject, "in the middle of a run", seen)
}

fn after_reset(session: &mut Session, subject: &Subject, place: &str, seen: &mut Seen) -> Result<(), Fault> {
    let base = subject.base()?;
    session.call("Reset", |raw| raw.reset())?;
    session.start(&base.settings)?;
    let rows = runs::from_here(session)?;
    let difference = difference(subject.facts, &base.steady, &base.rows, &rows);
    seen.differ(&rules::RESET, difference, |a, b| {
        format!("is {a} in a new instance and {b} in the same run after a reset {place}")
    });
    Ok(())
}

/// Two instances with different values run at the same time.
pub(super) fn instances(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let base = subject.base()?;
    let free = facts.select(Variable::is_free);
    let mut other = subject.instance("second")?;
    let mut one = subject.instance("first")?;
    other.start(&others(subject, &free))?;
    one.start(&base.settings)?;
    let (mut drive, mut other_drive) = (Drive::new(&mut one)?, Drive::new(&mut other)?);
    let mut rows: Rows = vec![one.observe()?];
    for step in 0..runs::steps(facts) {
        if step < 3 {
            for v in facts.inputs() {
                let values = v.start.clone();
                other.set(v, &values)?;
            }
            other_drive.advance(&mut other, facts.step())?;
        } else if step == 3 {
            other.call("Reset", |raw| raw.reset())?;
        }
        let row = drive.rows(&mut one, facts.step(), 1)?;
        if row.is_empty() {
            break;
        }
        rows.extend(row);
    }
    drop(other);
    seen.differ(&rules::INSTANCES, difference(facts, &base.steady, &base.rows, &rows), |a, b| {
        format!("is {a} in a single instance and {b} while a second instance with other values runs")
    });
    Ok(())
}

/// Bytes of this process in memory that no file holds, on Linux. Counted page by page: the counters in `statm` are late by up to 32 pages
/// for each processor, as much as a small leak, and files come and go.
fn anonymous() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/smaps_rollup").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("Anonymous:"))?;
    let kibibytes: f64 = line.split_ascii_whitespace().next()?.parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// The least growth per repetition in bytes over three rounds that all grow by more than `most`. `None` after the first round that does
/// not, where memory cannot be measured, or when time ran out.
fn growth(
    round: usize,
    most: f64,
    mut piece: impl FnMut() -> Result<bool, Fault>,
) -> Result<Option<f64>, Fault> {
    let started = Instant::now();
    let mut least = f64::INFINITY;
    // The first round fills caches and pools.
    for n in 0..4 {
        let Some(before) = anonymous() else { return Ok(None) };
        for _ in 0..round {
            if !piece()? || started.elapsed() > PATIENCE {
                return Ok(None);
            }
        }
        let Some(after) = anonymous() else { return Ok(None) };
        if n > 0 {
            least = least.min((after - before) / round as f64);
            if least <= most {
                return Ok(None);
            }
        }
    }
    Ok(Some(least))
}

pub(super) fn memory(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let round =
        |n: usize, cost: Duration| n.min((PATIENCE.as_secs_f64() / 5.0 / cost.as_secs_f64()) as usize);
    let once = Instant::now();
    drop(subject.started(&Vec::new())?);
    let round_of_instances = round(ROUND, once.elapsed());
    // Smaller values are within the noise of the allocator.
    if round_of_instances >= 40
        && let Some(bytes) = growth(round_of_instances, LEAK, || subject.started(&Vec::new()).map(|_| true))?
    {
        seen.add(&subject.interface.place(), rules::leak_of_instance(bytes, 4 * round_of_instances));
    }
    let mut session = subject.started(&Vec::new())?;
    if subject.interface.can_get_and_set_state {
        let piece = || {
            let mut state = RawState::NONE;
            session.call("GetFMUState", |raw| raw.save(&mut state))?;
            session.call("FreeFMUState", |raw| raw.free_state(&mut state))?;
            Ok(true)
        };
        if let Some(bytes) = growth(STEP_ROUND / 5, LEAK, piece)? {
            seen.add(&subject.interface.place(), rules::leak_of_state(bytes));
        }
    }
    if subject.interface.kind == InterfaceType::CoSimulation {
        let h = subject.facts.step();
        let end = subject.facts.stop.unwrap_or(f64::INFINITY);
        let piece = || {
            if session.now + h > end {
                // A leak also occurs in a second run.
                session.call("Reset", |raw| raw.reset())?;
                session.start(&Vec::new())?;
            }
            session.step(h)
        };
        if let Some(bytes) = growth(STEP_ROUND, STEP_LEAK, piece)? {
            seen.add(&subject.interface.place(), rules::leak_of_step(bytes));
        }
    }
    Ok(())
}
