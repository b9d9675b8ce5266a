//! Start values, and values set in one order or another.

use super::*;
use std::collections::HashMap;

/// The variables of the binary have the start values of the description.
pub(super) fn start_values(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let mut session = subject.instance("probe")?;
    let facts = subject.facts;
    session.setup(None)?;
    session.enter(None)?;
    let exact = |v: &Variable| {
        !v.clocked && (v.is("input") || v.initial.as_deref() == Some("exact") || v.variability == "constant")
    };
    for v in facts.select(exact) {
        if let Some(wanted) = &v.text {
            let text = session.text(v)?;
            let same =
                if v.kind == Kind::Binary { text.eq_ignore_ascii_case(wanted) } else { text == *wanted };
            if !same {
                seen.add(&v.place, rules::start_text_differs(v, short(&text), short(wanted)));
            }
        } else if !v.exact.is_empty() && v.exact.len() == v.size {
            let mut values = vec![0_i128; v.size];
            session.call("Get", |raw| raw.get_integers(v.kind, &[v.reference], &mut values))?;
            if let Some((value, start)) = values.iter().zip(&v.exact).find(|(x, start)| x != start) {
                seen.add(&v.place, rules::start_differs(v, value, start));
            }
        } else if v.kind.is_numeric() && v.start.len() == v.size {
            let values = session.get(v)?;
            let differs = |(x, start): &(&f64, &f64)| !is_start(v, **x, **start);
            if let Some((value, start)) = values.iter().zip(&v.start).find(differs) {
                seen.add(&v.place, rules::start_differs(v, value, start));
            }
        }
    }
    Ok(())
}

/// Whether a value is that of the start attribute: its decimal text may have been rounded to a neighbour.
fn is_start(v: &Variable, value: f64, start: f64) -> bool {
    let neighbours = match v.kind {
        Kind::Float64 => 4.0 * f64::EPSILON,
        Kind::Float32 => 4.0 * f64::from(f32::EPSILON),
        _ => 0.0,
    };
    value == start || (value - start).abs() <= neighbours * start.abs()
}

/// In which way values are set.
#[derive(Clone, Copy, PartialEq)]
enum Order {
    Forwards,
    Backwards,
    /// Scalars of one kind in one call.
    Together,
}

pub(super) fn order(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let base = subject.base()?;
    let free = facts.select(Variable::is_free);
    // Every variable at its own start value, set or not.
    let own: Settings = free.iter().map(|v| (*v, v.start.clone())).collect();
    let untouched = fresh(subject, &Vec::new())?;
    if let Ok((set, _)) = run_in(subject, &own, Order::Forwards)
        && let Some(d) = difference(facts, &base.steady, &untouched, &set).filter(|d| d.relative > ROUNDING)
    {
        seen.add(&d.variable.place, rules::set_start(&d.name, d.first, d.second, d.when()));
    }
    // Other values, in three orders.
    let others = others(subject, &free);
    let Ok((forwards, lost)) = run_in(subject, &others, Order::Forwards) else { return Ok(()) };
    if let Some((v, set, kept)) = lost {
        seen.add(&v.place, rules::set_lost(v, set, kept));
    }
    for (order, words) in [(Order::Backwards, "in reverse order"), (Order::Together, "all in one call")] {
        let (rows, _) = run_in(subject, &others, order)?;
        if seen.differ(&rules::SET_ORDER, difference(facts, &base.steady, &forwards, &rows), |a, b| {
            format!("is {a} when values are set one by one and {b} when they are set {words}")
        }) {
            break;
        }
    }
    reading(subject, &base.settings, seen)
}

/// Whether there is a state in which tunable parameters may be set during the run: between steps in FMI 2, in event mode else.
pub(super) fn can_tune(subject: &Subject) -> bool {
    let interface = subject.interface;
    interface.kind == ModelExchange
        || interface.kind == CoSimulation
            && (subject.facts.version == FmiVersion::V2 || interface.has_event_mode && is_repeatable(subject))
}

/// A tunable parameter takes its own value during the run.
pub(super) fn tunable(subject: &Subject, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let all = facts.select(|v| v.is_free() && v.is("parameter") && v.variability == "tunable");
    if all.is_empty() {
        return Ok(());
    }
    let with_events = subject.interface.kind == CoSimulation && facts.version == FmiVersion::V3;
    let mut session = if with_events { subject.with_event_mode()? } else { subject.instance("probe")? };
    session.raw.enable_reasons(&facts.categories);
    session.start(&Vec::new())?;
    let mut drive = Drive::new(&mut session)?;
    drive.advance(&mut session, facts.step())?;
    if subject.interface.kind == ModelExchange || with_events {
        session.call("EnterEventMode", |raw| raw.enter_event_mode())?;
    }
    for v in all {
        let (present, other) = (session.get(v)?, vec![v.other_value(); v.size]);
        // A value within its own limits may be impossible beside the others, which an FMU says by Discard.
        for (values, most) in [(present, Status::Warning), (other, Status::Discard)] {
            let status = session.raw.set(v.kind, &[v.reference], &values);
            if status > most {
                let words = words(session.raw.log());
                seen.add(&v.place, rules::tunable_refused(v, values[0], status, session.now, words));
                return Ok(());
            }
        }
    }
    Ok(())
}

/// All free variables at other values than their start values, as far as the FMU accepts them.
pub(super) fn others<'a>(subject: &Subject<'a>, free: &[&'a Variable]) -> Settings<'a> {
    let moved = |test: &dyn Fn(&Variable) -> bool| -> Settings<'a> {
        free.iter()
            .filter(|v| v.kind.is_float() && test(v))
            .map(|v| (*v, vec![v.other_value(); v.size]))
            .collect()
    };
    let all = moved(&|_| true);
    if run_in(subject, &all, Order::Forwards).is_ok() {
        return all;
    }
    let tunable = moved(&|v| v.is("input"));
    if run_in(subject, &tunable, Order::Forwards).is_ok() { tunable } else { Vec::new() }
}

type Lost<'a> = Option<(&'a Variable, f64, f64)>;

/// A fresh run with values set in some order, and the first one that was not kept.
fn run_in<'a>(
    subject: &Subject<'a>,
    settings: &Settings<'a>,
    order: Order,
) -> Result<(Rows, Lost<'a>), Fault> {
    let mut session = subject.instance("probe")?;
    // Before SetupExperiment, where other runs set after it: no call may lose a parameter.
    let mut in_order = settings.clone();
    if order == Order::Backwards {
        in_order.reverse();
    }
    let set = |session: &mut Session, inputs| match order {
        Order::Together => together(session, settings, inputs),
        _ => session.set_some(&in_order, inputs),
    };
    set(&mut session, false)?;
    session.setup(None)?;
    session.enter(None)?;
    set(&mut session, true)?;
    session.leave()?;
    let rows = runs::from_here(&mut session)?;
    let mut lost = None;
    let set_to: HashMap<*const Variable, &Vec<f64>> =
        settings.iter().map(|(v, x)| (std::ptr::from_ref(*v), x)).collect();
    let mut at = 0;
    for v in subject.facts.variables.iter().filter(|v| observed(v)) {
        let of_v = &rows[0][at..at + v.size];
        at += v.size;
        if let Some(set) = set_to.get(&std::ptr::from_ref(v))
            && (v.is("input") || v.is("parameter"))
            && let Some((a, b)) = set.iter().zip(of_v).find(|(a, b)| (*a - *b).abs() > 1e-6 * a.abs())
            && lost.is_none()
        {
            lost = Some((v, *a, *b));
        }
    }
    Ok((rows, lost))
}

fn together(session: &mut Session, settings: &Settings, inputs: bool) -> Result<(), Fault> {
    let some = || settings.iter().filter(|(v, _)| v.is("input") == inputs);
    let mut kinds: Vec<_> = some().map(|(v, _)| v.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        let of_kind = || some().filter(|(v, _)| v.kind == kind);
        let references: Vec<u32> = of_kind().map(|(v, _)| v.reference).collect();
        let values: Vec<f64> = of_kind().flat_map(|(_, x)| x.iter().copied()).collect();
        session.call("Set", |raw| raw.set(kind, &references, &values))?;
    }
    Ok(())
}

/// Reading changes no value, independent of the order of reading.
fn reading(subject: &Subject, settings: &Settings, seen: &mut Seen) -> Result<(), Fault> {
    let facts = subject.facts;
    let mut session = subject.started(settings)?;
    let mut drive = Drive::new(&mut session)?;
    drive.advance(&mut session, facts.step())?;
    let scalars = facts.select(|v| observed(v) && v.size == 1);
    let mut backwards = Vec::new();
    for v in scalars.iter().rev() {
        backwards.push(session.get(v)?[0]);
    }
    for (v, first) in scalars.iter().zip(backwards.iter().rev()) {
        let second = session.get(v)?[0];
        let close = (second - first).abs() <= ROUNDING * first.abs().max(v.nominal);
        if !close && !runs::same(second, *first) {
            seen.add(&v.place, rules::get_changes(v, first, second));
            break;
        }
    }
    Ok(())
}
