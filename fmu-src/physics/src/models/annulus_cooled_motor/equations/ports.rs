//! The effects as a step sees them: it passes by the ports where nothing acts.

use super::{Constants, Temperatures};
use crate::effects::{Effect, Effects, Port};

impl Constants {
    /// With every heat capacity times `factor`.
    pub fn with_capacity(mut self, factor: f64) -> Constants {
        self.capacity *= factor;
        self.inverse_capacity /= factor;
        self
    }

    /// The heat in the nodes above the temperature `origin`, K, in J.
    pub fn heat(&self, temperature: &Temperatures, origin: f64) -> f64 {
        self.capacity.dot(&temperature.add_scalar(-origin))
    }
}

/// The ports inside a step at which any effect acts.
#[derive(Clone, Copy, Debug)]
pub struct Acts {
    drag_torque: bool,
    load_drag: bool,
    /// Volts between terminals and winding.
    pub terminal_voltage: bool,
    winding_resistance: bool,
    winding_housing_resistance: bool,
    /// Heat from the housing that follows no conductance.
    pub housing_to_ambient: bool,
    housing_heat: bool,
}

impl Acts {
    /// Where these effects act.
    pub fn of(effects: &Effects) -> Acts {
        Acts {
            drag_torque: effects.acts_at(Port::DragTorque),
            load_drag: effects.acts_at(Port::LoadDrag),
            terminal_voltage: effects.acts_at(Port::TerminalVoltage),
            winding_resistance: effects.acts_at(Port::WindingResistance),
            winding_housing_resistance: effects.acts_at(Port::WindingHousingResistance),
            housing_to_ambient: effects.acts_at(Port::HousingToAmbient),
            housing_heat: effects.acts_at(Port::Any),
        }
    }
}

/// The effects with what is known of where they act. Each method is the port of the same name in
/// [`Effect`], or its slope.
#[derive(Clone, Copy, Debug)]
pub struct Ports<'a> {
    /// The effects.
    pub effects: &'a Effects,
    /// Where they act.
    pub acts: &'a Acts,
}

macro_rules! ports {
    ($($(#[doc = $doc:literal])* $port:ident if $acts:ident ($($argument:ident),*) else $neutral:literal;)*) => {$(
        $(#[doc = $doc])*
        #[inline]
        pub fn $port(&self, $($argument: f64),*) -> f64 {
            if self.acts.$acts { self.effects.$port($($argument),*) } else { $neutral }
        }
    )*};
}

impl Ports<'_> {
    ports! {
        /// N.m.
        drag_torque if drag_torque (w) else 0.0;
        /// N.m.s/rad.
        drag_torque_slope if drag_torque (w) else 0.0;
        /// A share.
        load_drag if load_drag (w, tau) else 0.0;
        /// s/rad.
        load_drag_slope if load_drag (w, tau) else 0.0;
        /// V.
        terminal_voltage if terminal_voltage (i) else 0.0;
        /// Ohm.
        terminal_voltage_slope if terminal_voltage (i) else 0.0;
        /// A factor.
        winding_resistance if winding_resistance () else 1.0;
        /// A factor.
        winding_housing_resistance if winding_housing_resistance (t_w) else 1.0;
        /// 1/K.
        winding_housing_resistance_slope if winding_housing_resistance (t_w) else 0.0;
        /// W.
        housing_to_ambient if housing_to_ambient (t_h, t_a) else 0.0;
        /// W.
        housing_heat if housing_heat (t_h) else 0.0;
        /// W/K.
        housing_heat_slope if housing_heat (t_h) else 0.0;
        /// W/K.
        housing_to_ambient_slope if housing_to_ambient (t_h, t_a) else 0.0;
    }

    /// The reciprocal of the factor on the resistance from winding to housing.
    #[inline]
    pub fn winding_housing_conductance(&self, t_w: f64) -> f64 {
        if self.acts.winding_housing_resistance { 1.0 / self.winding_housing_resistance(t_w) } else { 1.0 }
    }
}
