//! A step allocates nothing: an allocator that counts sees set, step and get go by.

use crate::common::{Motor2, vr};
use crate::counting::allocations;
use motor_fmu::fmi2::*;
use motor_fmu::logger::Status;

#[test]
fn a_step_allocates_nothing() {
    assert!(allocations(|| drop(std::hint::black_box(Box::new(1)))) > 0, "the counter counts");
    let motor = Motor2::initialized("allocation");
    let (input, output) = (vr("voltage"), [vr("current"), vr("winding_temperature")]);
    let mut state = std::ptr::null_mut();
    unsafe { assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok) };
    let run = || {
        // Reversing, so that steps are cut and Jacobians renewed on the way.
        for k in 0..2000u32 {
            let t = f64::from(k) * 1e-3;
            let mut values = [0.0; 2];
            unsafe {
                assert_eq!(fmi2SetReal(motor.0, &input, 1, &(24.0 * (20.0 * t).sin())), Status::Ok);
                assert_eq!(fmi2DoStep(motor.0, t, 1e-3, 0), Status::Ok);
                assert_eq!(fmi2GetReal(motor.0, output.as_ptr(), 2, values.as_mut_ptr()), Status::Ok);
            }
            if k % 100 == 0 {
                unsafe { assert_eq!(fmi2GetFMUstate(motor.0, &mut state), Status::Ok) };
            }
        }
    };
    assert_eq!(allocations(run), 0);
    unsafe { assert_eq!(fmi2FreeFMUstate(motor.0, &mut state), Status::Ok) };
}
