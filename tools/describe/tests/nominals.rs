//! Nominal values of derivatives against the derivatives that nominal inputs cause.

use describe::{Resources, StartValues, models, usage};
use physics::declare::Causality;

/// Steps of each input at its nominal value, and their length (s): the first steps show the fast states.
const STEPS: u32 = 200;
const STEP: f64 = 1e-3;
/// How far a nominal value may be outside of the range between the root mean square and the largest value of such a run.
const FACTOR: f64 = 30.0;

/// One after the other the inputs go to their nominal values, as in the reference results of an archive.
#[test]
fn nominal_derivatives_are_those_of_nominal_inputs() {
    for kind in models::ALL {
        let declaration = (kind.declaration)();
        let mut model = usage::with_starts(kind, &StartValues::default(), &Resources::default());
        model.start(0.0).unwrap();
        let mut rates = vec![0.0; declaration.states.len()];
        let mut seen = vec![(0.0_f64, 0.0_f64); rates.len()];
        let mut k = 0;
        for input in declaration.entries.iter().filter(|e| e.row.causality == Causality::Input) {
            assert!(model.set(input.slot, input.row.nominal.clamp(input.row.min, input.row.max)));
            for _ in 0..STEPS {
                model.derivatives(&mut rates).unwrap();
                seen.iter_mut()
                    .zip(&rates)
                    .for_each(|(s, rate)| *s = (s.0.max(rate.abs()), s.1 + rate * rate));
                model.step(f64::from(k) * STEP, STEP).unwrap();
                k += 1;
            }
        }
        let mut faults = Vec::new();
        for ([state, rate], (largest, squares)) in declaration.states.iter().zip(&seen) {
            let nominal = declaration.entries[*rate].row.nominal;
            let mean = (squares / f64::from(k)).sqrt();
            if *largest > 0.0 && !(mean / FACTOR..=FACTOR * largest).contains(&nominal) {
                let name = &declaration.entries[*state].name;
                faults.push(format!("{name} changes by {mean} to {largest} per second, nominal {nominal}"));
            }
        }
        assert!(faults.is_empty(), "{}: {}", declaration.name, faults.join(", "));
        assert!(seen.iter().filter(|(largest, _)| *largest > 0.0).count() > 1, "{}", declaration.name);
    }
}
