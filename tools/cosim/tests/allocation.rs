//! Set, step and get must not allocate.
mod common;
use common::*;
use cosim::{FmiVersion, Instance, Kind, Log};
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
fn hot_calls_do_not_allocate() {
    for version in BOTH {
        let archive = Fmu::good(version).open().unwrap();
        let d = archive.description();
        let (n, twice) = (d.variable("n").unwrap().kind, d.variable("twice").unwrap().kind);
        let mut instance = Instance::instantiate(&archive, "lag", Log::new()).unwrap();
        instance.enter_initialization(0.0, None, None).unwrap();
        instance.exit_initialization().unwrap();
        let before = ALLOCATIONS.get();
        let (mut x, mut i, mut b) = ([0.0], [0], [false]);
        for k in 0..100 {
            instance.set_f64(&[1], &[1.0]).unwrap();
            if version == FmiVersion::V2 {
                instance.set_input_derivatives(&[1], &[1.0]).unwrap();
            }
            instance.set_i64(n, &[7], &[3]).unwrap();
            instance.do_step(f64::from(k) * 0.5, 0.5).unwrap();
            instance.get_f64(&[5], &mut x).unwrap();
            instance.get_i64(twice, &[8], &mut i).unwrap();
            instance.get_bool(&[6], &mut b).unwrap();
            instance.get_number(Kind::Boolean, &[6], &mut x).unwrap();
        }
        assert_eq!(ALLOCATIONS.get(), before);
        assert_eq!((i, b), ([6], [true]));
    }
}
