//! A thousand instances in one process: a counting allocator verifies that all memory is freed.

use crate::common::{CS2, Importer, ME3, MODELS, Options, Succeeds, filled, reals, shortened};
use crate::counting::live;
use physics::declare::Causality;

/// Number of instances.
const COUNT: usize = shortened(1000, 12);

/// A thousand instances of all kinds at the same time, each with a step, a saved state and a derivative; then all are freed.
fn a_thousand() -> isize {
    let mut alive = Vec::with_capacity(COUNT);
    for k in 0..COUNT {
        let kind = &MODELS[k % MODELS.len()];
        let how = if k % 3 == 0 { ME3 } else { CS2 };
        let instance = Importer::instantiated(kind, how, Options::default()).initialized(&[]);
        if how == CS2 {
            instance.step(0.0, 1e-3).ok();
            let saved = instance.save();
            instance.step(1e-3, 1e-3).ok();
            instance.restore(&saved).ok();
            let first = |role| [reals(instance.declaration, role).next().unwrap().value_reference];
            let (unknown, known) = (first(Causality::Output), first(Causality::Input));
            filled(1, |slope| instance.directional(&unknown, &known, &[1.0], slope));
        }
        alive.push(instance);
    }
    live()
}

#[test]
fn a_thousand_instances_leave_nothing() {
    // Declarations are made once, and stay.
    a_thousand();
    let before = live();
    let most = a_thousand();
    assert_eq!(live(), before);
    assert!(most - before > 1000 * COUNT as isize, "the counter counts: {}", most - before);
}
