//! Instances in threads: eight threads with eight instances each give the results of one instance alone.

use crate::common::{Importer, KINDS, MODELS, Options, Succeeds, reals, shortened};
use physics::declare::Causality;
use std::sync::Barrier;

const THREADS: usize = 8;

/// All outputs after a run with reversing inputs, bit for bit: of instance `k` of a thread.
fn runs(instances: usize) -> Vec<Vec<u64>> {
    let made: Vec<_> = (0..instances)
        .map(|k| {
            let (kind, how) = (&MODELS[k % MODELS.len()], KINDS[k / MODELS.len() % 2 * 2]);
            Importer::instantiated(kind, how, Options::default()).started(&[])
        })
        .collect();
    for step in 0..shortened(100, 1) {
        let t = step as f64 * 1e-3;
        for (k, one) in made.iter().enumerate() {
            for (n, input) in reals(one.declaration, Causality::Input).enumerate() {
                let row = input.row;
                let wave = (step as f64 * (0.3 + 0.07 * (n + k) as f64)).sin();
                let value = (row.start + 0.5 * row.nominal * wave).clamp(row.min, row.max);
                one.set_reals(&[input.value_reference], &[value]).ok();
            }
            one.step(t, 1e-3).ok();
        }
    }
    made.iter().map(Importer::outputs).collect()
}

#[test]
fn eight_threads_with_eight_instances_each_equal_one_alone() {
    let alone = runs(8);
    let (start, work) = (Barrier::new(THREADS), &runs);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..THREADS)
            .map(|_| {
                scope.spawn(|| {
                    start.wait();
                    work(8)
                })
            })
            .collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), alone);
        }
    });
}
