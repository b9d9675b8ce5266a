//! Which parameters and inputs have no effect in the modes that a model is set to.
//!
//! The model decides, not a list: each variable takes other values at several operating points, and the outputs and the
//! derivatives of the states are compared. A variable without effect is tried again with each other item of each
//! enumeration; the enumeration that makes it effective is named.

use crate::dependencies::{Probe, START};
use crate::preset::{Preset, StartValues};
use physics::declare::{Causality, Kind, Unit};
use physics::model::{Declaration, Entry, Model, ModelType, Slot};
use physics::models;
use physics::resources::Resources;

/// What the effect is asked of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// Outputs and derivatives.
    Transient,
    /// The steady state: what only scales a derivative, such as a heat capacity, has no effect.
    Steady,
}

/// A parameter or input without effect in the selected modes.
#[derive(Clone, Debug)]
pub struct Unused {
    /// The parameter or input.
    pub entry: &'static Entry,
    /// The enumeration whose selected item is the reason; absent where no single enumeration is.
    pub mode: Option<Mode>,
}

/// An enumeration with the item that is selected and those with which the variable has an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode {
    /// Name of the enumeration.
    pub choice: &'static str,
    /// The selected item.
    pub selected: &'static str,
    /// The items with which the variable has an effect.
    pub effective: Vec<&'static str>,
}

/// Sizes of the inputs at the operating points, relative to their nominal values; with 0 the commands alone (unit 1) are 0, where some
/// parameters act, such as the bridge at duty 0.
const SCALES: [f64; 4] = [1.0, 1e-3, 1.0, 0.0];
/// Differences below this are rounding, relative to the value and to its nominal.
const ROUNDING: f64 = 1e-9;
/// Ratios of derivatives that agree within this are equal.
const SAME_RATIO: f64 = 1e-6;

/// The variables among `candidates` that have no effect on the model with the values set on it, which has not started.
pub fn unused(model: &dyn Model, candidates: &[&'static Entry], scope: Scope) -> Vec<Unused> {
    let points = Points::of(model, scope);
    // Limits of validity end a run in every mode, and have no effect before.
    let ineffective =
        candidates.iter().filter(|entry| !entry.is_limit_of_validity() && !points.moved_by(entry));
    let found: Vec<&'static Entry> = ineffective.copied().collect();
    let mut other_modes = None;
    found
        .into_iter()
        .map(|entry| {
            let modes = other_modes.get_or_insert_with(|| modes(model, scope));
            Unused { entry, mode: reason(entry, modes) }
        })
        .collect()
}

/// The variables among `candidates` that have an effect at the inputs that are set on the model, which has not started.
pub fn effective(model: &dyn Model, candidates: &[&'static Entry], scope: Scope) -> Vec<&'static Entry> {
    let point = |turn| Some((model.boxed_clone(), read(model, turn, scope)?));
    let points = Points { scope, at: (0..2).filter_map(point).collect() };
    candidates.iter().copied().filter(|entry| points.moved_by(entry)).collect()
}

/// A model with these start values and resources, which has not started.
pub fn with_starts(kind: &ModelType, starts: &StartValues, resources: &Resources) -> Box<dyn Model> {
    let (mut model, declaration) = ((kind.new)(), (kind.declaration)());
    for (reference, value) in starts.entries() {
        if let Some(entry) = declaration.by_reference(reference) {
            model.set(entry.slot, value);
        }
    }
    resources.give(model.as_mut());
    model
}

/// The inputs that have no effect in the modes of these start values.
pub fn inputs(kind: &ModelType, starts: &StartValues, resources: &Resources) -> Vec<Unused> {
    let entries = &(kind.declaration)().entries;
    let inputs: Vec<&'static Entry> =
        entries.iter().filter(|e| e.row.causality == Causality::Input).collect();
    unused(with_starts(kind, starts, resources).as_ref(), &inputs, Scope::Transient)
}

/// The values of a preset that have no effect in a mode that the preset itself selects.
pub fn preset_values(preset: &Preset) -> Vec<Unused> {
    let Some(kind) = models::by_name(&preset.model) else { return Vec::new() };
    let declaration = (kind.declaration)();
    let given: Vec<&'static Entry> =
        preset.starts.entries().into_iter().filter_map(|(r, _)| declaration.by_reference(r)).collect();
    let found =
        unused(with_starts(kind, &preset.starts, &Resources::default()).as_ref(), &given, Scope::Transient);
    let selects = |mode: &Mode| given.iter().any(|e| e.name == mode.choice);
    found.into_iter().filter(|u| u.mode.as_ref().is_some_and(selects)).collect()
}

/// The model with one enumeration at another item.
struct OtherMode {
    choice: &'static str,
    selected: &'static str,
    item: &'static str,
    points: Points,
}

fn modes(model: &dyn Model, scope: Scope) -> Vec<OtherMode> {
    let declaration = model.declaration();
    let settable = declaration.entries.iter().filter(|e| e.is_settable());
    let mut all = Vec::new();
    for choice in settable {
        let Kind::Enumeration(table) = choice.row.kind else { continue };
        let now = model.boxed_clone().get(choice.slot);
        let Some(selected) = table.items.iter().find(|i| f64::from(i.value) == now) else { continue };
        for item in table.items.iter().filter(|i| i.value != selected.value) {
            let mut other = model.boxed_clone();
            if other.set(choice.slot, f64::from(item.value)) {
                let points = Points::of(other.as_ref(), scope);
                all.push(OtherMode {
                    choice: &choice.name,
                    selected: selected.name,
                    item: item.name,
                    points,
                });
            }
        }
    }
    all
}

/// The first enumeration that makes the variable effective by another item.
fn reason(entry: &Entry, modes: &[OtherMode]) -> Option<Mode> {
    let effective = |m: &&OtherMode| m.choice != entry.name && m.points.moved_by(entry);
    let first = modes.iter().find(effective)?;
    let of_choice = modes.iter().filter(|m| m.choice == first.choice).filter(effective);
    Some(Mode {
        choice: first.choice,
        selected: first.selected,
        effective: of_choice.map(|m| m.item).collect(),
    })
}

/// The model at several operating points, with what it computes there.
struct Points {
    scope: Scope,
    at: Vec<(Box<dyn Model>, [Reading; 2])>,
}

/// Outputs and derivatives at one state.
#[derive(Clone)]
struct Reading {
    outputs: Vec<(f64, f64)>,
    rates: Vec<f64>,
}

impl Points {
    fn of(model: &dyn Model, scope: Scope) -> Points {
        let inputs = model.declaration().entries.iter().filter(|e| e.row.causality == Causality::Input);
        let inputs: Vec<&Entry> = inputs.collect();
        let point = |(turn, scale): (usize, &f64)| {
            let (mut model, mut probe) = (model.boxed_clone(), Probe::new(0, turn));
            model.enter_model_exchange();
            for entry in &inputs {
                let share = match (*scale, entry.row.start, entry.row.unit) {
                    (0.0, _, Unit::One) => 0.0,
                    (0.0, ..) => 1.0,
                    (scale, 0.0, _) => scale,
                    _ => 1.0,
                };
                let value = share * probe.generic(entry, &StartValues::default());
                if entry.check(value, false).is_ok() {
                    model.set(entry.slot, value);
                }
            }
            let readings = read(model.as_ref(), turn, scope)?;
            Some((model, readings))
        };
        Points { scope, at: SCALES.iter().enumerate().filter_map(point).collect() }
    }

    fn moved_by(&self, entry: &Entry) -> bool {
        let moved = |(turn, (model, before)): (usize, &(Box<dyn Model>, [Reading; 2]))| {
            other_values(entry, model.boxed_clone().get(entry.slot), turn).into_iter().any(|value| {
                let mut model = model.boxed_clone();
                model.set(entry.slot, value);
                read(model.as_ref(), turn, self.scope).is_some_and(|after| differ(before, &after, self.scope))
            })
        };
        // Elements that a dimension counts change their number, which no comparison of values covers.
        self.at.iter().enumerate().any(moved)
            || self.at.first().is_some_and(|(model, _)| model.declaration().is_dimension(entry))
    }
}

/// Valid values other than the present one.
fn other_values(entry: &Entry, now: f64, turn: usize) -> Vec<f64> {
    let (row, mut probe) = (entry.row, Probe::new(1, turn));
    let all = match row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| f64::from(i.value)).collect(),
        Kind::Boolean => vec![0.0, 1.0],
        Kind::Integer => vec![now - 1.0, now + 1.0],
        Kind::Real => {
            vec![
                now + 0.1 * probe.fraction() * row.nominal,
                probe.generic(entry, &StartValues::default()),
                row.min,
                row.max,
            ]
        }
    };
    all.into_iter().filter(|value| *value != now && entry.check(*value, false).is_ok()).collect()
}

/// The model at two states after its start; `None` where it cannot start or has no derivatives there.
fn read(model: &dyn Model, turn: usize, scope: Scope) -> Option<[Reading; 2]> {
    let mut model = model.boxed_clone();
    model.start(START).ok()?;
    let mut one = || {
        let count = model.declaration().states.len();
        // The same changes of the states at every call, so that readings can be compared.
        Probe::new(2, turn).push(model.as_mut(), count).then_some(())?;
        let mut rates = vec![0.0; count];
        model.derivatives(&mut rates).ok()?;
        Some(Reading { outputs: outputs(model.as_mut(), scope), rates })
    };
    Some([one()?, one()?])
}

/// Values and nominals of the outputs that count.
fn outputs(model: &mut dyn Model, scope: Scope) -> Vec<(f64, f64)> {
    let declaration: &'static Declaration = model.declaration();
    let counts = |e: &&Entry| {
        e.row.causality == Causality::Output && !(scope == Scope::Steady && is_integral(e))
            || e.slot.group == Slot::STATES && scope == Scope::Transient
    };
    declaration.entries.iter().filter(counts).map(|e| (model.get(e.slot), e.row.nominal)).collect()
}

/// Whether a variable is an integral over time, which a steady state does not bound: an energy or an angle.
pub fn is_integral(entry: &Entry) -> bool {
    matches!(entry.row.unit, Unit::Joule | Unit::Radian)
}

fn differ(before: &[Reading; 2], after: &[Reading; 2], scope: Scope) -> bool {
    // A value that is not a number differs from every other.
    let same = |a: f64, b: f64, floor: f64| (a - b).abs() <= ROUNDING * a.abs().max(b.abs()).max(floor);
    let differs = |a: f64, b: f64, floor: f64| !same(a, b, floor);
    let outputs = before
        .iter()
        .zip(after)
        .any(|(b, a)| b.outputs.iter().zip(&a.outputs).any(|(b, a)| differs(b.0, a.0, b.1.abs())));
    let rates = (0..before[0].rates.len()).any(|k| {
        let of = |readings: &[Reading; 2]| [readings[0].rates[k], readings[1].rates[k]];
        let (b, a) = (of(before), of(after));
        let moved = (0..2).any(|n| differs(b[n], a[n], 0.0) && (b[n] - a[n]).abs() > f64::MIN_POSITIVE);
        // b_1 a_2 = b_2 a_1: both derivatives are scaled by one factor, their zeros stay.
        let (left, right) = (b[0] * a[1], b[1] * a[0]);
        let scaled = (left - right).abs() <= SAME_RATIO * left.abs().max(right.abs());
        moved && !(scope == Scope::Steady && scaled)
    });
    outputs || rates
}

/// One sentence about variables without effect, `source` saying in words where a value is from; `None` where there is none.
pub fn sentence(found: &[Unused], source: impl Fn(&Entry) -> String) -> Option<String> {
    let mut groups: Vec<(Option<&Mode>, String, Vec<&str>)> = Vec::new();
    for one in found {
        let (mode, from) = (one.mode.as_ref(), source(one.entry));
        match groups.iter_mut().find(|(m, s, _)| *m == mode && *s == from) {
            Some((_, _, names)) => names.push(&one.entry.name),
            None => groups.push((mode, from, vec![&one.entry.name])),
        }
    }
    let clause = |(mode, from, names): &(Option<&Mode>, String, Vec<&str>)| {
        let verb = if names.len() == 1 { "has" } else { "have" };
        let from = if from.is_empty() { String::new() } else { format!(" ({from})") };
        let why = match mode {
            Some(m) => {
                let (choice, selected) = (m.choice, m.selected);
                format!("with {choice} = {selected}, only with {choice} = {}", listed(&m.effective, "or"))
            }
            None => "in the selected modes".to_owned(),
        };
        format!("{}{from} {verb} no effect {why}", listed(names, "and"))
    };
    (!groups.is_empty()).then(|| groups.iter().map(clause).collect::<Vec<_>>().join("; "))
}

/// Settings that make the variables effective, as `name=item`: one for each enumeration that is a reason.
pub fn other_modes(found: &[Unused]) -> String {
    let mut settings: Vec<String> = Vec::new();
    for mode in found.iter().filter_map(|u| u.mode.as_ref()) {
        let start = format!("{}=", mode.choice);
        if settings.iter().all(|s| !s.starts_with(&start)) {
            settings.push(start + mode.effective.first().copied().unwrap_or_default());
        }
    }
    settings.join(", ")
}

fn listed(names: &[&str], last: &str) -> String {
    match names {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [all @ .., end] => format!("{} {last} {end}", all.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Preset, models};

    fn motor(preset: &str, modes: &[(&str, f64)]) -> Box<dyn Model> {
        let preset = Preset::load(preset).unwrap();
        let kind = models::by_name(&preset.model).unwrap();
        let (mut model, declaration) =
            (with_starts(kind, &preset.starts, &Resources::default()), (kind.declaration)());
        for (name, value) in modes {
            assert!(model.set(declaration.by_name(name).unwrap().slot, *value));
        }
        model
    }

    fn names(model: &dyn Model, candidates: &[&str], scope: Scope) -> Vec<String> {
        let entry = |name: &&str| model.declaration().by_name(name).unwrap();
        let candidates: Vec<&'static Entry> = candidates.iter().map(entry).collect();
        unused(model, &candidates, scope).into_iter().map(|u| u.entry.name.clone()).collect()
    }

    const BARE: (&str, f64) = ("cooling_mode", 2.0);
    const CURRENT: (&str, f64) = ("drive_mode", 3.0);
    const IMPOSED: (&str, f64) = ("mechanical_mode", 2.0);

    #[test]
    fn each_mode_has_its_own_variables() {
        let motor_in = |modes: &[(&str, f64)]| motor("maxon-305015", modes);
        let all = [
            "voltage",
            "duty",
            "current_command",
            "load_torque",
            "imposed_speed",
            "fan_command",
            "motor.L",
            "motor.J",
        ];
        let of = |modes: &[(&str, f64)]| names(motor_in(modes).as_ref(), &all, Scope::Transient);
        assert_eq!(of(&[]), ["duty", "current_command", "imposed_speed"]);
        assert_eq!(of(&[CURRENT, IMPOSED]), ["voltage", "duty", "load_torque", "motor.L", "motor.J"]);
        assert_eq!(of(&[BARE]), ["duty", "current_command", "imposed_speed", "fan_command"]);
    }

    #[test]
    fn the_cooling_mode_that_uses_a_resistance_is_named() {
        let model = motor("maxon-305015", &[BARE]);
        let entry = model.declaration().by_name("conductance.G_still").unwrap();
        let found = unused(model.as_ref(), &[entry], Scope::Steady);
        let text = sentence(&found, |_| "preset maxon-305015".to_owned()).unwrap();
        assert_eq!(
            text,
            "conductance.G_still (preset maxon-305015) has no effect with cooling_mode = bare, only with cooling_mode = conductance"
        );
        let used = motor("maxon-305015", &[]);
        assert!(unused(used.as_ref(), &[entry], Scope::Steady).is_empty());
    }

    #[test]
    fn a_limit_that_ends_a_run_is_not_without_effect() {
        let limits =
            ["validity.winding_temperature", "validity.magnet_temperature", "validity.lowest_temperature"];
        for scope in [Scope::Transient, Scope::Steady] {
            assert!(names(motor("maxon-305015", &[CURRENT]).as_ref(), &limits, scope).is_empty());
        }
    }

    /// Capacities, inductance and inertia decide how fast a steady state is reached, and not where it lies.
    #[test]
    fn what_scales_a_derivative_does_not_move_a_steady_state() {
        let scales = ["thermal.C_w", "thermal.C_h", "motor.L", "motor.J"];
        let moves = ["thermal.R_wh", "motor.R_ref", "conductance.G_still", "effect.coulomb_friction.tau_c"];
        let model = motor("maxon-305015", &[]);
        assert_eq!(names(model.as_ref(), &[&scales[..], &moves].concat(), Scope::Steady), scales);
        assert!(names(model.as_ref(), &scales, Scope::Transient).is_empty());
        let rig = motor("thesis-rig", &[]);
        assert_eq!(
            names(rig.as_ref(), &["thermal.C_h", "thermal.C_r", "thermal.G_leads"], Scope::Steady),
            ["thermal.C_h", "thermal.C_r"]
        );
    }

    /// The preset of the rig selects one of four cooling modes and has the values of all.
    #[test]
    fn a_preset_is_asked_for_values_that_its_own_modes_do_not_use() {
        let of = |name: &str| {
            let found = preset_values(&Preset::load(name).unwrap());
            found.into_iter().map(|u| u.entry.name.clone()).collect::<Vec<_>>()
        };
        assert_eq!(of("maxon-305015"), Vec::<String>::new());
        assert_eq!(of("thesis-rig"), ["fan.turbulence_factor", "fan.decay", "annulus.factor_pull"]);
    }

    /// The bridge at duty 0: a duty may be 0 at any time.
    #[test]
    fn what_acts_at_an_input_of_zero_has_an_effect() {
        const PWM: (&str, f64) = ("drive_mode", 2.0);
        let gearmotor = with_starts(
            models::by_name("BrushedGearmotor").unwrap(),
            &StartValues::default(),
            &Resources::default(),
        );
        for model in [motor("maxon-305015", &[PWM]), gearmotor] {
            for scope in [Scope::Transient, Scope::Steady] {
                assert!(names(model.as_ref(), &["drive.zero_duty"], scope).is_empty());
            }
        }
        let current = motor("maxon-305015", &[CURRENT]);
        assert_eq!(names(current.as_ref(), &["drive.zero_duty"], Scope::Transient), ["drive.zero_duty"]);
    }

    #[test]
    fn every_model_can_be_asked() {
        for kind in models::ALL {
            let (model, declaration) = ((kind.new)(), (kind.declaration)());
            let settable: Vec<&'static Entry> =
                declaration.entries.iter().filter(|e| e.is_settable()).collect();
            let found = unused(model.as_ref(), &settable, Scope::Transient);
            assert!(
                found.len() < settable.len() && found.iter().all(|u| u.entry.is_settable()),
                "{}",
                declaration.name
            );
        }
    }
}
