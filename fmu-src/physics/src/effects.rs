//! The effects: one line each. An effect acts at a port of the model, keeps the books, and is off by default.
//!
//! A port is a method of [`Effect`] and a line of [`Effects`] that adds up (or multiplies) what all effects say
//! there. The model's equations know ports alone, and enter what comes out of them in the ledger with both ends.

mod ambient_drift;
mod bridge_drop;
mod contact_drop;
mod coulomb_friction;
mod dead_time;
mod demagnetisation;
mod drive_loss;
mod fan_back_pressure;
mod forced_convection;
mod generic_term;
mod housing_radiation;
mod housing_sensor_lag;
mod housing_sensor_offset;
mod housing_sensor_stem_loss;
mod interface_temperature;
mod iron_loss;
mod load_dependent_friction;
mod ports;
mod pwm_ripple;
mod stator_node;
mod viscous_friction;
mod windage;
mod winding_sensor_offset;
mod winding_sensor_stem_loss;

pub use ambient_drift::AmbientDrift;
pub use bridge_drop::BridgeDrop;
pub use contact_drop::ContactDrop;
pub use coulomb_friction::CoulombFriction;
pub use dead_time::DeadTime;
pub use demagnetisation::Demagnetisation;
pub use drive_loss::DriveLoss;
pub use fan_back_pressure::FanBackPressure;
pub use forced_convection::{ConvectionDriver, CooledNode, ForcedConvection};
pub use generic_term::GenericTerms;
pub use housing_radiation::HousingRadiation;
pub use housing_sensor_lag::HousingSensorLag;
pub use housing_sensor_offset::HousingSensorOffset;
pub use housing_sensor_stem_loss::HousingSensorStemLoss;
pub use interface_temperature::InterfaceTemperature;
pub use iron_loss::IronLoss;
pub use load_dependent_friction::LoadDependentFriction;
pub use pwm_ripple::PwmRipple;
pub use stator_node::StatorNode;
pub use viscous_friction::ViscousFriction;
pub use windage::Windage;
pub use winding_sensor_offset::WindingSensorOffset;
pub use winding_sensor_stem_loss::WindingSensorStemLoss;

use crate::model::Unserved;
pub use crate::number::Number;
use crate::terms::{Driver, Drivers, GenericTerm, Lag, MOST_TERMS};
use num_dual::Dual64;
pub use ports::{Effect, IMMINENT, PerNode, Port};

/// The derivative of a port with respect to its argument, at `x`.
#[inline]
fn slope(x: f64, port: impl Fn(Dual64) -> Dual64) -> f64 {
    port(Dual64::from(x).derivative()).eps
}

macro_rules! effects {
    ($($(#[doc = $doc:literal])* $id:ident : $type:ident @ $prefix:literal $base:literal at $port:ident;)*) => {
        /// All effects of a model with their parameters.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Effects { $($(#[doc = $doc])* pub $id: $type),* }

        $crate::groups! { Effects { $($prefix @ $base => $id: $type),* } }

        impl Effects {
            /// The variables of the effects at ports that a model does not serve: `reason` says why not, and what to use instead.
            pub fn unserved(reason: impl Fn(Port) -> Option<&'static str>) -> Vec<Unserved> {
                let effects = [$(($prefix, Port::$port)),*];
                let unserved = |(start, port)| reason(port).map(|reason| Unserved { start, reason });
                effects.into_iter().filter_map(unserved).collect()
            }

            /// Whether any effect at `port` is on, so that steps can pass by the ports where nothing acts.
            pub fn acts_at(&self, port: Port) -> bool {
                false $(|| (matches!(Port::$port, p if p == port || p == Port::Any) && self.$id.is_on()))*
            }
        }

        impl Effect for Effects {
            fn is_on(&self) -> bool {
                false $(|| self.$id.is_on())*
            }

            fn take_terms(&mut self, terms: &[GenericTerm]) -> bool {
                false $(| self.$id.take_terms(terms))*
            }

            #[inline]
            fn tell(&mut self, drivers: &Drivers) -> bool {
                false $(| self.$id.tell(drivers))*
            }

            fn holds(&self, driver: Driver) -> bool {
                false $(|| self.$id.holds(driver))*
            }

            #[inline]
            fn lag(&self, k: usize) -> Option<Lag> {
                None $(.or_else(|| self.$id.lag(k)))*
            }

            #[inline]
            fn winding_resistance(&self) -> f64 {
                1.0 $(* self.$id.winding_resistance())*
            }

            #[inline]
            fn winding_heat(&self) -> f64 {
                0.0 $(+ self.$id.winding_heat())*
            }

            #[inline]
            fn heat_capacity(&self) -> f64 {
                1.0 $(* self.$id.heat_capacity())*
            }

            #[inline]
            fn ambient_offset(&self) -> f64 {
                0.0 $(+ self.$id.ambient_offset())*
            }

            #[inline]
            fn drag_torque<D: Number>(&self, w: D) -> D {
                D::from(0.0) $(+ self.$id.drag_torque(w))*
            }

            #[inline]
            fn load_drag<D: Number>(&self, w: D, tau: f64) -> D {
                D::from(0.0) $(+ self.$id.load_drag(w, tau))*
            }

            #[inline]
            fn terminal_voltage<D: Number>(&self, i: D) -> D {
                D::from(0.0) $(+ self.$id.terminal_voltage(i))*
            }

            #[inline]
            fn bridge_voltage<D: Number>(&self, i: D) -> D {
                D::from(0.0) $(+ self.$id.bridge_voltage(i))*
            }

            #[inline]
            fn missed_voltage<D: Number>(&self, i: D, supply: f64) -> D {
                D::from(0.0) $(+ self.$id.missed_voltage(i, supply))*
            }

            #[inline]
            fn ripple_square(&self, duty: f64, supply: f64, inductance: f64) -> f64 {
                0.0 $(+ self.$id.ripple_square(duty, supply, inductance))*
            }

            #[inline]
            fn torque_constant(&self, time: f64) -> f64 {
                1.0 $(* self.$id.torque_constant(time))*
            }

            #[inline]
            fn next_event(&self, time: f64) -> f64 {
                f64::INFINITY $(.min(self.$id.next_event(time)))*
            }

            #[inline]
            fn winding_housing_resistance<D: Number>(&self, t_w: D) -> D {
                D::from(1.0) $(* self.$id.winding_housing_resistance(t_w))*
            }

            #[inline]
            fn ambient_conductance(&self, flow: f64) -> PerNode {
                PerNode::default() $(+ self.$id.ambient_conductance(flow))*
            }

            #[inline]
            fn housing_to_ambient<D: Number>(&self, t_h: D, t_a: f64) -> D {
                D::from(0.0) $(+ self.$id.housing_to_ambient(t_h, t_a))*
            }

            #[inline]
            fn housing_heat<D: Number>(&self, t_h: D) -> D {
                D::from(0.0) $(+ self.$id.housing_heat(t_h))*
            }

            #[inline]
            fn stator(&self) -> (f64, f64) {
                let both = (0.0, 0.0);
                $(let (r, c) = self.$id.stator(); let both = (both.0 + r, both.1 + c);)*
                both
            }

            #[inline]
            fn fan_flow(&self, n: f64) -> f64 {
                $(let n = self.$id.fan_flow(n);)*
                n
            }

            #[inline]
            fn ambient_sensor(&self) -> f64 {
                0.0 $(+ self.$id.ambient_sensor())*
            }

            #[inline]
            fn housing_sensor_lag(&self) -> f64 {
                0.0 $(+ self.$id.housing_sensor_lag())*
            }

            #[inline]
            fn winding_sensor(&self, t: f64, t_a: f64) -> f64 {
                $(let t = self.$id.winding_sensor(t, t_a);)*
                t
            }

            #[inline]
            fn housing_sensor(&self, t: f64, t_a: f64) -> f64 {
                $(let t = self.$id.housing_sensor(t, t_a);)*
                t
            }

            #[inline]
            fn iron_drag(&self, w: f64) -> f64 {
                0.0 $(+ self.$id.iron_drag(w))*
            }

            #[inline]
            fn drive_loss(&self) -> f64 {
                0.0 $(+ self.$id.drive_loss())*
            }
        }
    };
}

effects! {
    /// Dry friction of bearings and seals.
    coulomb_friction: CoulombFriction @ "effect.coulomb_friction." 1000 at DragTorque;
    /// Friction of lubricant, and eddy currents, which follow the same law.
    viscous_friction: ViscousFriction @ "effect.viscous_friction." 1010 at DragTorque;
    /// Hysteresis and eddy currents in the stator's iron.
    iron_loss: IronLoss @ "effect.iron_loss." 1020 at DragTorque;
    /// Drag of the air on the rotor.
    windage: Windage @ "effect.windage." 1030 at DragTorque;
    /// Friction of gear and bearings under load.
    load_dependent_friction: LoadDependentFriction @ "effect.load_dependent_friction." 1040 at LoadDrag;
    /// Voltage lost in brushes or semiconductors.
    contact_drop: ContactDrop @ "effect.contact_drop." 1050 at TerminalVoltage;
    /// Radiation from the housing to the room.
    housing_radiation: HousingRadiation @ "effect.housing_radiation." 1060 at HousingToAmbient;
    /// A resistance between winding and housing that depends on temperature.
    interface_temperature: InterfaceTemperature @ "effect.interface_temperature." 1070 at WindingHousingResistance;
    /// A draught on the housing, or air through the winding.
    forced_convection: ForcedConvection @ "effect.forced_convection." 1080 at AmbientConductance;
    /// A fan that works against a pressure.
    fan_back_pressure: FanBackPressure @ "effect.fan_back_pressure." 1090 at FanFlow;
    /// Magnets that have lost some of their strength.
    demagnetisation: Demagnetisation @ "effect.demagnetisation." 1100 at TorqueConstant;
    /// A sensor of the ambient temperature that drifts.
    ambient_drift: AmbientDrift @ "effect.ambient_drift." 1110 at AmbientSensor;
    /// Power lost in the drive.
    drive_loss: DriveLoss @ "effect.drive_loss." 1120 at DriveLoss;
    /// A stator with a temperature of its own.
    stator_node: StatorNode @ "effect.stator_node." 1180 at Stator;
    /// Copper loss of the ripple of a chopped current.
    pwm_ripple: PwmRipple @ "effect.pwm_ripple." 1200 at Ripple;
    /// Voltage lost in the drive's bridge.
    bridge_drop: BridgeDrop @ "effect.bridge_drop." 1210 at Bridge;
    /// Dead time of the drive's bridge.
    dead_time: DeadTime @ "effect.dead_time." 1220 at Bridge;
    // A reading passes these in their order: what is lost along the stem is a share of the true rise.
    /// A sensor of the housing that follows late.
    housing_sensor_lag: HousingSensorLag @ "effect.housing_sensor_lag." 1130 at HousingSensorLag;
    /// A sensor of the winding that the air cools.
    winding_sensor_stem_loss: WindingSensorStemLoss @ "effect.winding_sensor_stem_loss." 1140 at WindingSensor;
    /// A sensor of the housing that the air cools.
    housing_sensor_stem_loss: HousingSensorStemLoss @ "effect.housing_sensor_stem_loss." 1150 at HousingSensor;
    /// A sensor of the winding that shows a constant too much.
    winding_sensor_offset: WindingSensorOffset @ "effect.winding_sensor_offset." 1160 at WindingSensor;
    /// A sensor of the housing that shows a constant too much.
    housing_sensor_offset: HousingSensorOffset @ "effect.housing_sensor_offset." 1170 at HousingSensor;
    /// Terms found in data that are in no list.
    generic_term: GenericTerms @ "effect.generic_term." 1190 at Any;
}

/// Slopes of the ports with respect to their first argument, for Jacobians.
impl Effects {
    /// Whether a term that is data has a lag, whose state the model integrates.
    #[inline]
    pub fn has_lags(&self) -> bool {
        (0..MOST_TERMS).any(|k| self.lag(k).is_some())
    }

    /// Slope of [`drag_torque`](Effect::drag_torque), N.m.s/rad.
    #[inline]
    pub fn drag_torque_slope(&self, w: f64) -> f64 {
        slope(w, |w| self.drag_torque(w))
    }

    /// Slope of [`load_drag`](Effect::load_drag) with the speed, s/rad.
    #[inline]
    pub fn load_drag_slope(&self, w: f64, tau: f64) -> f64 {
        slope(w, |w| self.load_drag(w, tau))
    }

    /// Slope of [`winding_housing_resistance`](Effect::winding_housing_resistance), 1/K.
    #[inline]
    pub fn winding_housing_resistance_slope(&self, t_w: f64) -> f64 {
        slope(t_w, |t_w| self.winding_housing_resistance(t_w))
    }

    /// Slope of [`housing_to_ambient`](Effect::housing_to_ambient) with the housing's temperature, W/K.
    #[inline]
    pub fn housing_to_ambient_slope(&self, t_h: f64, t_a: f64) -> f64 {
        slope(t_h, |t_h| self.housing_to_ambient(t_h, t_a))
    }

    /// Slope of [`bridge_voltage`](Effect::bridge_voltage) and [`missed_voltage`](Effect::missed_voltage), Ohm.
    #[inline]
    pub fn drive_voltage_slope(&self, i: f64, supply: f64) -> f64 {
        slope(i, |i| self.bridge_voltage(i) + self.missed_voltage(i, supply))
    }

    /// Slope of [`housing_heat`](Effect::housing_heat), W/K.
    #[inline]
    pub fn housing_heat_slope(&self, t_h: f64) -> f64 {
        slope(t_h, |t_h| self.housing_heat(t_h))
    }

    /// Slope of [`terminal_voltage`](Effect::terminal_voltage), Ohm.
    #[inline]
    pub fn terminal_voltage_slope(&self, i: f64) -> f64 {
        slope(i, |i| self.terminal_voltage(i))
    }
}

/// What the effects' own tests share.
#[cfg(test)]
mod testing {
    use super::*;

    /// Asserts that the slope of a port is its difference quotient within `tolerance`.
    pub fn slope_is_derivative(port: impl Fn(Dual64) -> Dual64, at: &[f64], by: f64, tolerance: f64) {
        for &x in at {
            let exact = slope(x, &port);
            let value = |x: f64| port(Dual64::from(x)).re;
            let difference = (value(x + by) - value(x - by)) / (2.0 * by);
            assert!((exact - difference).abs() <= tolerance, "at {x}: {exact} and {difference}");
        }
    }
}
