//! The cooling modes: one list, one file each. A mode is a [`Method`]; `docs/extending.md` describes how to add one.

mod annulus;
mod bare;
mod coefficients;
mod conductance;
mod fan_crossflow;
mod method;
mod repeated;
mod tangent;
#[cfg(test)]
mod tests;
mod water_jacket;

pub use coefficients::{Coefficients, Passing};
pub use method::{Cooling, Method, Site, Stream, mass};
pub use tangent::Tangent;

use super::variables::Inputs;
use crate::components;
use crate::components::annulus::FlowDirection;
use declare::enumeration;

/// Declares the modes, and the inputs that they depend on. A line of the modes is
///
/// ```text
/// Item = number, "name": Method [, field: Part = "prefix." @ base];
/// ```
///
/// with the method, and the parameters of the part that the mode adds to the motor. A line of the inputs has two changes as functions of
/// the value: the first is the largest for which the coefficients are linearized, the second the largest over a substep, over which the
/// inputs of the cooling are constant.
macro_rules! cooling {
    (modes { $($(#[doc = $doc:literal])* $mode:ident = $value:literal, $name:literal: $method:expr
        $(, $field:ident: $part:ty = $prefix:literal @ $base:literal)?;)* }
    inputs { $($input:ident: $near:expr, $over:expr;)* }) => {
        enumeration! {
            /// Path of the heat from the housing to ambient.
            pub enum CoolingMode { $($(#[doc = $doc])* $mode = $value, $name;)* }
        }

        crate::groups! {
            /// Parts that cooling modes add to the motor.
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            pub struct Parts {
                $($(#[doc = concat!("Part of [`", stringify!($mode), "`](CoolingMode::", stringify!($mode), ").")]
                $field: $part = $prefix @ $base,)?)*
            }
        }

        /// The method of a mode.
        pub fn method(mode: CoolingMode) -> &'static dyn Method {
            match mode { $(CoolingMode::$mode => &$method),* }
        }

        /// Conditions that determine the coefficients: temperatures, and inputs of the motor.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Conditions {
            /// Mean temperature of the housing, K.
            pub surface: f64,
            /// Temperature of the tube, K.
            pub tube: f64,
            /// Ambient temperature, K.
            pub ambient: f64,
            $(#[doc = concat!("[`", stringify!($input), "`](Inputs::", stringify!($input), ").")] pub $input: f64,)*
        }

        /// Number of inputs that the coefficients depend on.
        pub const INPUTS: usize = [$(stringify!($input)),*].len();

        crate::saved!(Conditions { surface, tube, ambient, $($input),* });

        impl Conditions {
            /// Conditions before the first evaluation: unequal to all others.
            pub const NONE: Conditions =
                Conditions { surface: f64::NAN, tube: f64::NAN, ambient: f64::NAN, $($input: f64::NAN),* };

            /// The conditions of these inputs, with the temperatures of housing (`surface`), tube and true ambient, K.
            pub fn of(inputs: &Inputs, surface: f64, tube: f64, ambient: f64) -> Conditions {
                Conditions { surface, tube, ambient, $($input: inputs.$input),* }
            }

            /// The inputs, in the order of their list.
            #[inline]
            pub fn inputs(&self) -> [f64; INPUTS] {
                [$(self.$input),*]
            }

            /// The largest change of each input for which the coefficients are linearized.
            #[inline]
            pub fn near(&self) -> [f64; INPUTS] {
                [$(change($near, self.$input)),*]
            }

            /// The conditions with another value of the `k`-th input.
            pub fn with_input(mut self, k: usize, value: f64) -> Conditions {
                let inputs: [&mut f64; INPUTS] = [$(&mut self.$input),*];
                *inputs[k] = value;
                self
            }

            /// The conditions with their names.
            #[cfg(test)]
            pub fn named(&mut self) -> Vec<(&'static str, &mut f64)> {
                vec![
                    ("surface", &mut self.surface),
                    ("tube", &mut self.tube),
                    ("ambient", &mut self.ambient),
                    $((stringify!($input), &mut self.$input)),*
                ]
            }

            /// Longest substep over which the inputs may be constant, s.
            pub fn longest_substep(inputs: &Inputs, slopes: &Inputs) -> f64 {
                f64::INFINITY $(.min(change($over, inputs.$input) / slopes.$input.abs()))*
            }
        }
    };
}

/// A change as a function of the magnitude of the value: a measured flow that stops is negative at times.
#[inline(always)]
fn change(of: impl Fn(f64) -> f64, value: f64) -> f64 {
    of(value.abs())
}

cooling! {
    modes {
        /// Ambient conductance that the fan increases; the only nodes are winding and housing.
        Conductance = 1, "conductance": conductance::GivenConductance;
        /// Natural convection and radiation in still air.
        Bare = 2, "bare": bare::Bare;
        /// Fan in crossflow.
        FanCrossflow = 3, "fan_crossflow": fan_crossflow::FanCrossflow, fan: components::fan::Fan = "fan." @ 500;
        /// Annulus: a fan pushes air through a tube around the motor.
        AnnulusPush = 4, "annulus_push": annulus::Annulus(FlowDirection::Push),
            annulus: components::annulus::Annulus = "annulus." @ 600;
        /// Annulus: a fan pulls air through a tube around the motor.
        AnnulusPull = 5, "annulus_pull": annulus::Annulus(FlowDirection::Pull);
        /// Water jacket: water flows through channels along the housing.
        WaterJacket = 6, "water_jacket": water_jacket::WaterJacket, jacket: components::jacket::Jacket = "jacket." @ 670;
    }
    inputs {
        // Pa; flows and conductances are powers of the density, at most its first, so that the linearization has an error of 3e-6.
        ambient_pressure: |p| 0.005 * p, |_| 500.0;
        // For a flow that is a power of the command, the linearization has an error of 1e-4.
        fan_command: |n| 0.02 * n, |_| 0.02;
        // K; the properties of water change by 2 % per kelvin.
        coolant_inlet_temperature: |_| 0.25, |_| 0.25;
        // m3/s; in the transition to turbulence the linearization has an error of 7e-5.
        coolant_flow_rate: |q| 0.01 * q, |q| 0.02 * q + 1e-8;
    }
}
