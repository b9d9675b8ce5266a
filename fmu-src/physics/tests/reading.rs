//! Reading never writes: an instance whose variables are read in any order between its steps takes the same steps as one that
//! nobody reads, bit for bit, in every model and mode.

use crate::common::load_table;
use declare::{Causality, Kind};
use physics::effects::Effects;
use physics::model::{Model, Slot};
use physics::models;
use physics::models::annulus_cooled_motor::AnnulusCooledMotor;
use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product};

/// SplitMix64 (Steele, Lea, Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn fraction(&mut self) -> f64 {
        self.next() as f64 / u64::MAX as f64
    }
}

/// Every item of the enumerations of a model, each with all others at their start values, and the combinations of the first
/// three, which are the modes of the motor.
fn modes(fresh: &dyn Model) -> Vec<Vec<(Slot, f64)>> {
    let entries = &fresh.declaration().entries;
    let items = |k: usize| match entries[k].row.kind {
        Kind::Enumeration(t) => t.items.iter().map(|i| (entries[k].slot, f64::from(i.value))).collect(),
        _ => Vec::new(),
    };
    let choices: Vec<usize> = (0..entries.len()).filter(|&k| !items(k).is_empty()).collect();
    let mut all = vec![Vec::new()];
    for &k in choices.iter().take(3) {
        all = all
            .iter()
            .flat_map(|one: &Vec<_>| items(k).into_iter().map(move |i| [&one[..], &[i]].concat()))
            .collect();
    }
    all.extend(choices.iter().skip(3).flat_map(|&k| items(k)).map(|item| vec![item]));
    all
}

fn state(m: &dyn Model) -> Vec<u64> {
    let mut x = vec![0.0; m.declaration().states.len()];
    m.read_states(&mut x);
    x.iter().map(|x| x.to_bits()).collect()
}

/// Reads some variables, in any order, some of them twice, and all that tools ask for.
fn read(m: &mut dyn Model, random: &mut Random) {
    let entries = &m.declaration().entries;
    for _ in 0..random.next() % 40 {
        let value = m.get(entries[(random.next() % entries.len() as u64) as usize].slot);
        assert!(!value.is_infinite());
    }
    let mut out = Vec::new();
    match random.next() % 4 {
        0 => m.rates(&mut out),
        1 => drop(m.housing_heat()),
        2 => {
            out.resize(m.declaration().states.len(), 0.0);
            m.derivatives(&mut out).unwrap();
        }
        _ => drop((m.drivers(), m.next_event())),
    }
}

/// Steps of several lengths with inputs that jump and run along slopes, beside a copy that is read.
fn assert_unmoved(mut plain: Box<dyn Model>, what: &str, seed: u64) {
    let inputs: Vec<_> = plain.declaration().entries.iter().filter(|e| e.is_continuous_input()).collect();
    let mut random = Random(seed);
    plain.start(0.0).unwrap();
    let mut seen = plain.boxed_clone();
    for k in 0..60usize {
        for entry in &inputs {
            let row = entry.row;
            let base = if row.start == 0.0 { row.nominal } else { row.start };
            let wide = if row.start == 0.0 { 0.6 } else { 0.01 };
            let value = base * (1.0 - wide * random.fraction()).clamp(row.min / base, row.max / base);
            let slope = 0.05 * base * (random.fraction() - 0.5);
            let moves = k.is_multiple_of(5) || random.next().is_multiple_of(6);
            for m in [&mut plain, &mut seen] {
                if moves {
                    m.set(entry.slot, value);
                }
                if k.is_multiple_of(3) && entry.row.start != 0.0 {
                    m.set_slope(entry.slot, slope);
                }
            }
            // Between the inputs as well, which come one by one.
            if random.next().is_multiple_of(4) {
                read(seen.as_mut(), &mut random);
            }
        }
        let h = [1e-3, 1e-2, 0.2][k % 3];
        let t = plain.time();
        let ends = [&mut plain, &mut seen].map(|m| m.step(t, h).is_err());
        assert_eq!(ends[0], ends[1], "{what}");
        assert_eq!(state(plain.as_ref()), state(seen.as_ref()), "{what}: step {k}");
        if ends[0] {
            break;
        }
    }
}

#[test]
fn reading_changes_no_bit_in_any_model_and_mode() {
    let mut cases = 0;
    for kind in models::ALL {
        let mut fresh = (kind.new)();
        fresh.set_load(&load_table());
        for (seed, mode) in modes(fresh.as_ref()).into_iter().enumerate() {
            let mut model = fresh.boxed_clone();
            for &(slot, value) in &mode {
                assert!(model.set(slot, value));
            }
            assert_unmoved(model, &format!("{} {mode:?}", (kind.declaration)().name), seed as u64);
            cases += 1;
        }
    }
    assert!(cases > 60, "{cases}");
}

/// The same with every effect on, and with terms that follow the states, hold values over a step and change heat capacities.
#[test]
fn reading_changes_no_bit_with_effects_and_terms() {
    let fresh = AnnulusCooledMotor::default();
    let term = |port: Port, driver: Driver, coefficient: f64, offset: f64| {
        let factor = Factor { driver, offset, reference: 50.0, exponent: 1.0, range: Factor::UNLIMITED };
        GenericTerm::new(port, Law::Product(Product { coefficient, factors: [Some(factor), None, None] }))
    };
    for (seed, mode) in modes(&fresh).into_iter().enumerate() {
        let mut model = fresh.clone();
        model.parameters.effects = Effects::examples();
        for &(slot, value) in &mode {
            assert!(model.set(slot, value));
        }
        assert!(model.set_terms(&[
            term(Port::HeatCapacity, Driver::WindingTemperature, 0.1, 250.0),
            term(Port::HousingHeat, Driver::HousingTemperature, 0.2, 290.0),
        ]));
        assert_unmoved(Box::new(model), &format!("{mode:?}"), seed as u64);
    }
}

/// An output has the same bits whether it is read alone, which for some of them needs no equations, or after all others.
#[test]
fn an_output_read_alone_is_the_output() {
    for kind in models::ALL {
        let mut model = (kind.new)();
        model.set_load(&load_table());
        let entries = &model.declaration().entries;
        for (k, entry) in entries.iter().enumerate() {
            let row = entry.row;
            // Every sensor indicates something else than the truth, and every input acts.
            let is_small = entry.name.starts_with("effect.") && row.kind == Kind::Real && row.start == 0.0;
            if is_small || row.causality == Causality::Input && row.start == 0.0 {
                model
                    .set(entry.slot, (0.01 * (1.0 + k as f64 / 100.0) * row.nominal).clamp(row.min, row.max));
            }
        }
        model.start(0.0).unwrap();
        (0..20).for_each(|k| model.step(0.01 * f64::from(k), 0.01).unwrap());
        let mut all = model.boxed_clone();
        let outputs: Vec<_> = entries.iter().filter(|e| e.row.causality == Causality::Output).collect();
        for entry in outputs.iter().rev() {
            all.get(entry.slot);
        }
        for entry in outputs {
            let alone = model.boxed_clone().get(entry.slot);
            assert_eq!(alone.to_bits(), all.get(entry.slot).to_bits(), "{}", entry.name);
        }
    }
}
