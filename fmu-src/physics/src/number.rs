//! Numbers that carry a derivative, and a sign that is smooth at zero: what effects and components are written with.

use num_dual::DualNum;

/// A number, or a number with its derivative: what a port is computed with, so that no slope is written by hand.
pub trait Number: DualNum<Primitive = f64> + Copy {}
impl<D: DualNum<Primitive = f64> + Copy> Number for D {}

/// The sign of `x` with a smooth passage through zero of width `small`: tanh(x / small), saturated where a double
/// no longer sees the difference (and where a dual number's tanh would overflow).
#[inline]
pub(crate) fn smooth_sign<D: Number>(x: D, small: f64) -> D {
    const SATURATED: f64 = 20.0;
    if x.re().abs() > SATURATED * small {
        return D::from(x.re().signum());
    }
    // tanh by one exponential: as near as rounding of 1 lets it be, odd to the last bit, and 0 where x is.
    let turned = 1.0 - 2.0 / ((2.0 * x.re().abs() / small).exp() + 1.0);
    let sign = turned.copysign(x.re());
    // The derivative follows from the value; `x` less its own value is the derivative's part of `x` alone.
    (x - D::from(x.re())) * ((1.0 - sign * sign) / small) + sign
}
