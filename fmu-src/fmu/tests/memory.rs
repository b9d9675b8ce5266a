//! A thousand instances in one process: a counting allocator verifies that all memory is freed.

use crate::counting::live;
use motor_fmu::fmi2::*;
use motor_fmu::fmi3::{
    fmi3EnterInitializationMode, fmi3ExitInitializationMode, fmi3FreeInstance, fmi3InstantiateModelExchange,
};
use motor_fmu::logger::Status;
use physics::declare::{Causality, Kind};
use std::ffi::CString;
use std::ptr::{null, null_mut};

/// A thousand instances of all kinds at the same time, each with a step, a saved state and a derivative; then all are freed.
fn a_thousand() -> isize {
    let mut alive = Vec::with_capacity(1000);
    for k in 0..1000usize {
        let declaration = (physics::models::ALL[k % physics::models::ALL.len()].declaration)();
        let token = CString::new(declaration.token.clone()).unwrap();
        let three = k % 3 == 0;
        unsafe {
            if three {
                let c = fmi3InstantiateModelExchange(
                    c"x".as_ptr(),
                    token.as_ptr(),
                    null(),
                    0,
                    0,
                    null_mut(),
                    None,
                );
                assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), Status::Ok);
                assert_eq!(fmi3ExitInitializationMode(c), Status::Ok);
                alive.push((c, three));
                continue;
            }
            let c = fmi2Instantiate(c"x".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 0);
            assert_eq!(fmi2EnterInitializationMode(c), Status::Ok);
            assert_eq!(fmi2ExitInitializationMode(c), Status::Ok);
            assert_eq!(fmi2DoStep(c, 0.0, 1e-3, 1), Status::Ok);
            let mut state = null_mut();
            assert_eq!(fmi2GetFMUstate(c, &mut state), Status::Ok);
            assert_eq!(fmi2DoStep(c, 1e-3, 1e-3, 1), Status::Ok);
            assert_eq!(fmi2SetFMUstate(c, state), Status::Ok);
            assert_eq!(fmi2FreeFMUstate(c, &mut state), Status::Ok);
            let first = |role| {
                let real = |e: &&physics::model::Entry| e.row.causality == role && e.row.kind == Kind::Real;
                declaration.entries.iter().find(real).unwrap().value_reference
            };
            let (unknown, known) = (first(Causality::Output), first(Causality::Input));
            let mut slope = f64::NAN;
            assert_eq!(fmi2GetDirectionalDerivative(c, &unknown, 1, &known, 1, &1.0, &mut slope), Status::Ok);
            alive.push((c, three));
        }
    }
    let most = live();
    for (c, three) in alive {
        unsafe { if three { fmi3FreeInstance(c) } else { fmi2FreeInstance(c) } }
    }
    most
}

#[test]
fn a_thousand_instances_leave_nothing() {
    // Declarations are made once, and stay.
    a_thousand();
    let before = live();
    let most = a_thousand();
    assert_eq!(live(), before);
    assert!(most - before > 1000 * 1000, "the counter counts: {}", most - before);
}
