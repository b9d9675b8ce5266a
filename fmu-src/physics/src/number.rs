//! Number types with a derivative, and a sign function that is smooth at zero: used in effects and components.

use num_dual::DualNum;

/// A number, or a number with its derivative: argument of a port, for automatic differentiation.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// Smooth sign of `x`, tanh(x / small); saturated where the difference to 1 is below double precision
/// (and where a dual number's tanh would overflow).
#[inline]
pub(crate) fn smooth_sign<D: Number>(x: D, small: f64) -> D {
    const SATURATED: f64 = 20.0;
    if x.re().abs() > SATURATED * small {
        return D::from(x.re().signum());
    }
    // tanh by one exponential: accurate to the rounding of 1, odd to the last bit, exactly 0 at x = 0.
    let turned = 1.0 - 2.0 / ((2.0 * x.re().abs() / small).exp() + 1.0);
    let sign = turned.copysign(x.re());
    // The derivative follows from the value; `x` minus its own value is the derivative part of `x`.
    (x - D::from(x.re())) * ((1.0 - sign * sign) / small) + sign
}
