//! A step of a system must not allocate.
mod common;
mod parts;
use cosim::{Algorithm, SystemOptions, cosimulate};
use parts::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    /// Per thread, as the test harness has threads of its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: all work is the system allocator's.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn ten_times_the_steps_take_no_more_allocations() {
    let folder = Folder::new();
    let system = folder.toml(PAIR).unwrap();
    for algorithm in [Algorithm::Jacobi, Algorithm::GaussSeidel] {
        for tolerance in [None, Some(1e-6)] {
            let count = |stop: f64| {
                let options =
                    SystemOptions { algorithm, tolerance, stop: Some(stop), ..SystemOptions::default() };
                let before = ALLOCATIONS.get();
                let run = cosimulate(&system, &options, &mut |_| ()).unwrap();
                assert!(run.recording.steps as f64 > 50.0 * stop, "{}", run.recording.steps);
                ALLOCATIONS.get() - before
            };
            // The first run fills what the C library keeps.
            count(1.0);
            assert_eq!(count(10.0), count(100.0), "{algorithm:?}, tolerance {tolerance:?}");
        }
    }
}
