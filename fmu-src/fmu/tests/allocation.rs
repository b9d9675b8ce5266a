//! A step allocates no memory: in every model, in every combination of its modes, in both standards and both interfaces.

use crate::common::running::{Running, STEPS};
use crate::common::{CS2, KINDS, MODELS, Succeeds, shortened};
use crate::counting::allocations;
use physics::components::gait::Activity;
use physics::declare::Kind;
use physics::model::Declaration;

/// The activity that needs data of an archive, which these instances do not have.
const TABLE: (&str, i32) = ("gait.activity", Activity::Table as i32);

/// Every combination of the choices of a model, effects' own apart.
fn combinations(declaration: &Declaration) -> Vec<Vec<(&str, f64)>> {
    let mut all = vec![Vec::new()];
    for entry in declaration.entries.iter().filter(|e| !e.name.starts_with("effect.") && e.is_settable()) {
        let Kind::Enumeration(of) = entry.row.kind else { continue };
        let with = |item: i32| {
            let choice = (entry.name.as_str(), f64::from(item));
            all.iter().map(move |one: &Vec<_>| [&one[..], &[choice]].concat())
        };
        let startable = of.items.iter().filter(|item| (entry.name.as_str(), item.value) != TABLE);
        all = startable.flat_map(|item| with(item.value)).collect();
    }
    all
}

#[test]
fn a_step_allocates_nothing_in_any_mode() {
    assert!(allocations(|| drop(std::hint::black_box(Box::new(1)))) > 0, "the counter counts");
    let mut cases = 0;
    for kind in MODELS {
        let declaration = (kind.declaration)();
        for choices in combinations(declaration).into_iter().step_by(shortened(1, 300)) {
            for how in KINDS {
                let mut running = Running::new(kind, how, &choices);
                // The first steps make what an instance keeps.
                running.run(0);
                let count = allocations(|| running.run(STEPS));
                assert_eq!(
                    count, 0,
                    "{} {choices:?}, FMI 3: {}, Model Exchange: {}",
                    declaration.name, how.0, how.1
                );
                cases += 1;
            }
        }
    }
    // 4 drive modes x 2 couplings x 5 modes of cooling of the annulus motor alone make 160.
    assert!(cases > shortened(500, 10), "{cases}");
}

/// A state that is saved again takes the place of the old one.
#[test]
fn saving_a_state_again_allocates_nothing() {
    for kind in MODELS {
        let mut running = Running::new(kind, CS2, &[]);
        let mut saved = running.importer.save();
        running.run(0);
        let count = allocations(|| running.importer.get_state(&mut saved.state).ok());
        assert_eq!(count, 0, "{}", (kind.declaration)().name);
    }
}
