//! A step of a system must not allocate.
use crate::counting::allocations;
use crate::parts::*;
use cosim::{Algorithm, SystemOptions, cosimulate};

#[test]
fn ten_times_the_steps_take_no_more_allocations() {
    let folder = Folder::new();
    let system = folder.toml(PAIR).unwrap();
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        for tolerance in [None, Some(1e-6)] {
            let count = |stop: f64| {
                let options =
                    SystemOptions { algorithm, tolerance, stop: Some(stop), ..SystemOptions::default() };
                let before = allocations();
                let run = cosimulate(&system, &options, &mut |_| ()).unwrap();
                assert!(run.recording.steps as f64 > 50.0 * stop, "{}", run.recording.steps);
                allocations() - before
            };
            // The first run fills what the C library keeps.
            count(1.0);
            assert_eq!(count(10.0), count(100.0), "{algorithm:?}, tolerance {tolerance:?}");
        }
    }
}
