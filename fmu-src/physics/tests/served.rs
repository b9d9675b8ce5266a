//! A model exports only what it serves: each parameter and input moves an output in some mode at some operating point.
//!
//! No list says where: enumerations, inputs and parameters are drawn at random until each variable has moved something.

use crate::common::load_table;
use physics::declare::{Causality, Kind, Unit};
use physics::model::{Entry, Model, ModelType, Slot};
use physics::models;
use physics::terms::{Driver, GenericTerm, Lag, Law, Port, Table};

/// Operating points that are tried at most.
const POINTS: u64 = 600;
/// Steps of each run, s: fast states move in the first, temperatures reach their limits in the last.
const STEPS: [f64; 5] = [1e-3, 1e-2, 0.1, 3.0, 60.0];
/// One run in so many is long enough for temperatures to reach their limits.
const LONG: u64 = 8;
/// Differences below this, relative to value and nominal value, are rounding.
const ROUNDING: f64 = 1e-9;

/// Golden ratio of 64 bits: neighbouring points have unrelated seeds.
const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;

/// Multiplicative congruential generator with an xorshift output (PCG).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        f64::from(word.rotate_right((self.0 >> 59) as u32)) / f64::from(u32::MAX)
    }
}

/// A value of the size that the declaration expects: near the start value or, where that is 0, of the nominal value.
fn plausible(entry: &Entry, rng: &mut Rng) -> f64 {
    let (row, share) = (entry.row, rng.next());
    let is_narrow = row.max - row.min <= 10.0 * row.nominal;
    match row.kind {
        Kind::Real if is_narrow && rng.next() < 0.05 => row.min + share * (row.max - row.min),
        Kind::Enumeration(t) => {
            let last = t.items.len() - 1;
            f64::from(t.items[((share * t.items.len() as f64) as usize).min(last)].value)
        }
        Kind::Boolean => share.round(),
        Kind::Integer => row.start,
        Kind::Real if row.start == 0.0 && share < 0.3 => 0.0,
        Kind::Real if row.start == 0.0 => (2.0 * (share - 0.5) * row.nominal).clamp(row.min, row.max),
        Kind::Real => (row.start * (0.7 + 0.6 * share)).clamp(row.min, row.max),
    }
}

/// Other values of a variable within its limits.
fn others(entry: &Entry, now: f64, rng: &mut Rng) -> Vec<f64> {
    let (row, share) = (entry.row, rng.next());
    let all = match row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| f64::from(i.value)).collect(),
        Kind::Boolean => vec![0.0, 1.0],
        Kind::Integer => vec![now + 1.0, now - 1.0],
        // Times are compared with the duration of the run.
        Kind::Real if row.unit == Unit::Second => vec![3.0 * share, row.min, row.max, now * (0.5 + share)],
        Kind::Real => vec![now + share * 0.3 * row.nominal, now * (0.5 + share), row.min, row.max],
    };
    all.into_iter().filter(|value| *value != now && entry.check(*value, false).is_ok()).collect()
}

/// The outputs at the start and after each step, with other inputs in each; a run that ends at a limit of validity stands there.
fn outputs(mut model: Box<dyn Model>, point: u64, moved: &str) -> impl Iterator<Item = Vec<f64>> {
    let declaration = model.declaration();
    let mut rng = Rng(SPREAD.wrapping_mul(!point));
    let shown = |e: &&Entry| e.row.causality == Causality::Output;
    let slots: Vec<_> = declaration.entries.iter().filter(shown).map(|e| e.slot).collect();
    let is_thermal =
        declaration.entries.iter().any(|e| e.slot.group == Slot::STATES && e.row.unit == Unit::Kelvin);
    let count = match is_thermal {
        true if point.is_multiple_of(LONG) => STEPS.len(),
        true => 2,
        false => STEPS.len() - 1,
    };
    let mut steps = STEPS.iter().take(count);
    let mut next = model.start(0.0).is_ok();
    std::iter::from_fn(move || {
        let found = next.then(|| slots.iter().map(|slot| model.get(*slot)).collect());
        next = next
            && steps.next().is_some_and(|h| {
                for entry in declaration.entries.iter().filter(|e| e.is_continuous_input()) {
                    let value = plausible(entry, &mut rng);
                    if entry.name != moved && entry.check(value, true).is_ok() {
                        model.set(entry.slot, value);
                    }
                }
                let time = model.time();
                model.step(time, *h).is_ok() || model.ended()
            });
        found
    })
}

/// The settable variables of a model that move no output at any of the points.
fn without_effect(kind: &ModelType) -> Vec<&'static str> {
    let declaration = (kind.declaration)();
    let nominal = |e: &&Entry| e.row.causality == Causality::Output;
    let nominals: Vec<f64> =
        declaration.entries.iter().filter(nominal).map(|e| e.row.nominal.abs()).collect();
    let mut rest: Vec<&'static Entry> = declaration.entries.iter().filter(|e| e.is_settable()).collect();
    let differ = |a: &[f64], b: &[f64]| {
        let pairs = a.iter().zip(b).zip(&nominals);
        pairs.into_iter().any(|((a, b), n)| (a - b).abs() > ROUNDING * a.abs().max(b.abs()).max(*n))
    };
    // Lags, so that their starts move outputs.
    let lag = Some(Lag { driver: Driver::Speed, tau: 10.0, difference: false });
    let table = |port| {
        let law = Table::new(Driver::Speed, &[0.0, 1000.0], &[0.01, 0.02])?;
        Some(GenericTerm { lag, ..GenericTerm::new(port, Law::Table(law)) })
    };
    let ports = [Port::DragTorque, Port::WindingHeat, Port::HousingHeat];
    let terms: Vec<GenericTerm> = ports.into_iter().filter_map(table).collect();
    for point in 0..POINTS {
        if rest.is_empty() {
            break;
        }
        let mut rng = Rng(SPREAD.wrapping_mul(point + 1));
        let mut model = (kind.new)();
        model.set_load(&load_table());
        model.set_terms(&terms);
        for entry in declaration.entries.iter().filter(|e| e.is_settable()) {
            let value = plausible(entry, &mut rng);
            if entry.check(value, false).is_ok() {
                model.set(entry.slot, value);
            }
        }
        let before: Vec<Vec<f64>> = outputs(model.boxed_clone(), point, "").collect();
        if before.is_empty() {
            continue;
        }
        rest.retain(|entry| {
            let now = model.get(entry.slot);
            !others(entry, now, &mut rng).into_iter().any(|value| {
                let mut moved = model.boxed_clone();
                moved.set(entry.slot, value);
                let mut after = outputs(moved, point, &entry.name).peekable();
                // A start that is refused, as at an ambient temperature below the limit of validity, is an effect.
                after.peek().is_none() || after.zip(&before).any(|(after, before)| differ(&after, before))
            })
        });
    }
    rest.into_iter().map(|entry| entry.name.as_str()).collect()
}

#[test]
fn every_parameter_and_input_of_every_model_moves_an_output() {
    for kind in models::ALL {
        let found = without_effect(kind);
        assert!(found.is_empty(), "{} has variables without effect: {found:?}", (kind.declaration)().name);
    }
}

/// A variable that another model has is refused with the reason and with what to use instead.
#[test]
fn what_a_model_does_not_serve_is_named() {
    let of = |model: &str| (models::by_name(model).unwrap().declaration)();
    let (gearmotor, motor) = (of("BrushedGearmotor"), of("AnnulusCooledMotor"));
    for (name, instead) in [
        ("effect.pwm_ripple.f", "drive.pwm_frequency"),
        ("effect.bridge_drop.V_0", "drive.drop"),
        ("effect.stator_node.C_s", "thermal.C_w"),
        ("effect.forced_convection.driver", "effect.forced_convection.G"),
    ] {
        let entry = motor.by_name(name).unwrap();
        let sentence = gearmotor.unserved(name).unwrap();
        assert!(sentence.contains(name) && sentence.contains(instead), "{sentence}");
        assert_eq!(gearmotor.unserved_reference(entry.value_reference), Some(sentence));
        assert!(gearmotor.by_name(name).is_none() && gearmotor.by_reference(entry.value_reference).is_none());
        assert!(gearmotor.by_name(instead).is_some(), "{instead}");
        assert_eq!(motor.unserved(name), None);
    }
    assert_eq!(gearmotor.unserved("motor.R_ref"), None);
}
