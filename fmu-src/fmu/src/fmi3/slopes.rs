//! FMI 3.0: directional and adjoint derivatives, and those of outputs with respect to time.

use super::InstanceHandle;
use crate::boundary::{array, array_mut, enter};
use crate::logger::Status;

/// Directional derivatives of the unknowns for the seeds of the knowns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetDirectionalDerivative(
    instance: InstanceHandle,
    unknowns: *const u32,
    n_unknowns: usize,
    knowns: *const u32,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    sensitivity: *mut f64,
    n_sensitivity: usize,
) -> Status {
    // SAFETY: as the crate's documentation says; so for every block below.
    unsafe {
        enter(instance, "fmi3GetDirectionalDerivative", |i| {
            let (unknowns, knowns) =
                (array(unknowns, n_unknowns, "unknowns")?, array(knowns, n_knowns, "knowns")?);
            let (seed, out) =
                (array(seed, n_seed, "seed")?, array_mut(sensitivity, n_sensitivity, "sensitivity")?);
            i.directional(unknowns, knowns, seed, out)
        })
    }
}

/// Adjoint derivatives: for each known the sum of seed times derivative over the unknowns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetAdjointDerivative(
    instance: InstanceHandle,
    unknowns: *const u32,
    n_unknowns: usize,
    knowns: *const u32,
    n_knowns: usize,
    seed: *const f64,
    n_seed: usize,
    sensitivity: *mut f64,
    n_sensitivity: usize,
) -> Status {
    unsafe {
        enter(instance, "fmi3GetAdjointDerivative", |i| {
            let (unknowns, knowns) =
                (array(unknowns, n_unknowns, "unknowns")?, array(knowns, n_knowns, "knowns")?);
            let (seed, out) =
                (array(seed, n_seed, "seed")?, array_mut(sensitivity, n_sensitivity, "sensitivity")?);
            i.adjoint(unknowns, knowns, seed, out)
        })
    }
}

/// First derivatives of outputs with respect to time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetOutputDerivatives(
    instance: InstanceHandle,
    vr: *const u32,
    n: usize,
    orders: *const i32,
    values: *mut f64,
    n_values: usize,
) -> Status {
    unsafe {
        enter(instance, "fmi3GetOutputDerivatives", |i| {
            let (vr, orders) = (array(vr, n, "valueReferences")?, array(orders, n, "orders")?);
            i.output_derivatives(vr, orders, array_mut(values, n_values, "values")?)
        })
    }
}
