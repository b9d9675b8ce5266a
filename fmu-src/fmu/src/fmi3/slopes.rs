//! FMI 3.0: directional and adjoint derivatives, and time derivatives of outputs.

use crate::boundary::{Out, array};
use crate::functions;

/// Products of the Jacobian with a seed, computed by one method of the instance each.
macro_rules! products {
    ($($(#[doc = $doc:literal])* $name:ident => $method:ident;)*) => {
        functions! {
            enter;
            $($(#[doc = $doc])* fn $name(
                unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize, seed: *const f64,
                n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
            ) => |i| {
                let unknowns = array(unknowns, n_unknowns, "unknowns")?;
                let knowns = array(knowns, n_knowns, "knowns")?;
                let seed = array(seed, n_seed, "seed")?;
                let out = Out::array(sensitivity, n_sensitivity, "sensitivity")?;
                out.fill(&i.$method(unknowns, knowns, seed, n_sensitivity)?);
                Ok(())
            };)*
        }
    };
}

products! {
    /// Directional derivatives of the unknowns for the seeds of the knowns.
    fmi3GetDirectionalDerivative => directional;
    /// Adjoint derivatives: for each known the sum of seed times derivative over the unknowns.
    fmi3GetAdjointDerivative => adjoint;
}

functions! {
    enter;
    /// First derivatives of outputs with respect to time.
    fn fmi3GetOutputDerivatives(
        vr: *const u32, n: usize, orders: *const i32, values: *mut f64, n_values: usize
    ) => |i| {
        let (vr, orders) = (array(vr, n, "valueReferences")?, array(orders, n, "orders")?);
        let out = Out::array(values, n_values, "values")?;
        out.fill(&i.output_derivatives(vr, orders, n_values)?);
        Ok(())
    };
}
