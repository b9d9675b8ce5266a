//! The effects: one line each. An effect acts at a port of the model, keeps the books, and is off by default.

mod coulomb_friction;
mod viscous_friction;

pub use coulomb_friction::CoulombFriction;
pub use viscous_friction::ViscousFriction;

use num_dual::{Dual64, DualNum};

/// What an effect may do, port by port. A port that an effect does not touch stays neutral.
pub trait Effect {
    /// A torque against the motion at speed `w`, rad/s: N.m, of the sign of `w`. Its power heats the housing.
    #[inline]
    fn drag_torque<D: DualNum<Primitive = f64> + Copy>(&self, _w: D) -> D {
        D::from(0.0)
    }
}

/// The sign of `x` with a smooth passage through zero of width `small`: tanh(x / small), saturated where a double
/// no longer sees the difference (and where a dual number's tanh would overflow).
#[inline]
fn smooth_sign<D: DualNum<Primitive = f64> + Copy>(x: D, small: f64) -> D {
    const SATURATED: f64 = 20.0;
    if x.re().abs() > SATURATED * small { D::from(x.re().signum()) } else { (x / small).tanh() }
}

macro_rules! effects {
    ($($(#[doc = $doc:literal])* $id:ident : $type:ident @ $prefix:literal $base:literal;)*) => {
        /// All effects of a model with their parameters.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Effects { $($(#[doc = $doc])* pub $id: $type),* }

        $crate::groups! { Effects { $($prefix @ $base => $id: $type),* } }

        impl Effects {
            /// The sum of all drag torques at speed `w`, rad/s: N.m, of the sign of `w`.
            #[inline]
            pub fn drag_torque(&self, w: f64) -> f64 {
                0.0 $(+ self.$id.drag_torque(w))*
            }

            /// The same with its derivative with respect to `w`, N.m.s/rad.
            #[inline]
            pub fn drag_torque_slope(&self, w: f64) -> f64 {
                let w = Dual64::from(w).derivative();
                (Dual64::from(0.0) $(+ self.$id.drag_torque(w))*).eps
            }
        }
    };
}

effects! {
    /// Dry friction of bearings and seals.
    coulomb_friction: CoulombFriction @ "effect.coulomb_friction." 1000;
    /// Friction of lubricant, and eddy currents, which follow the same law.
    viscous_friction: ViscousFriction @ "effect.viscous_friction." 1010;
}
