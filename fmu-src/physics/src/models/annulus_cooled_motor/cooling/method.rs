//! A cooling mode as a [`Method`]: the parts that it adds to the motor, the heat paths from the segments of the housing as
//! [`Coefficients`], and its outputs.

use super::repeated::{self, Key};
use super::{Coefficients, Conditions, method};
use crate::components::annulus::Gap;
use crate::components::conductance::Conductance;
use crate::components::housing::StillAir;
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::EnergyBalance;
use std::fmt::Debug;

/// A cooling mode.
pub trait Method: Debug + Sync {
    /// Whether rotor, stator and housing segments are nodes, and end faces and mount transfer heat; else the whole housing is
    /// one node.
    fn has_network(&self) -> bool {
        true
    }
    /// Mass of the parts that the mode adds, kg.
    fn mass(&self, _parameters: &Parameters) -> f64 {
        0.0
    }
    /// Heat capacity of the node of the mode (the tube of an annulus), J/K; 0 without a node. The node is a state, and the coefficients may
    /// depend on its temperature, if and only if this is above 0.
    fn tube_capacity(&self, _parameters: &Parameters) -> f64 {
        0.0
    }
    /// The gap between motor and tube.
    fn gap(&self, _parameters: &Parameters) -> Option<Gap> {
        None
    }
    /// Whether the curvature of the coefficients over the temperatures is at most that of natural convection, so that it need not be
    /// estimated at each evaluation: a quarter to a third of the computing time of the coefficients. A test checks it.
    fn is_smooth(&self) -> bool {
        false
    }
    /// Whether the last heat paths are kept, because they take longer than to compare and to copy them: those of the operating point of a fan.
    fn is_slow(&self) -> bool {
        false
    }
    /// Inconsistency between parameters of the mode, in one sentence.
    fn fault(&self, _parameters: &Parameters) -> Option<String> {
        None
    }
    /// Adds the heat paths of the lateral surface to coefficients without any.
    fn add(&self, site: &Site, c: &mut Coefficients);
    /// Fills the outputs of the mode; those of others remain as [`EnergyBalance::without_flow`].
    fn show(&self, stream: &Stream, out: &mut EnergyBalance) {
        let Stream { at, coefficients: c, outlet, .. } = *stream;
        out.air_outlet_temperature = at.ambient + c.behind * (outlet - at.ambient);
        (out.air_flow_rate, out.air_pressure_drop) = (c.flow, c.pressure_drop);
    }
}

/// The flow along a motor and its conditions, for the outputs.
#[derive(Clone, Copy, Debug)]
pub struct Stream<'a> {
    /// The motor.
    pub parameters: &'a Parameters,
    /// The conditions.
    pub at: &'a Conditions,
    /// The coefficients at these conditions.
    pub coefficients: &'a Coefficients,
    /// Temperature behind the last segment, K.
    pub outlet: f64,
    /// Heat flow from the housing to the flow, W.
    pub heat: f64,
    /// Heat flow from the housing to the node of the mode, W.
    pub to_node: f64,
}

/// Mass of the motor including the parts that its cooling mode adds, kg.
pub fn mass(parameters: &Parameters) -> f64 {
    parameters.motor.mass + method(parameters.choices.cooling_mode).mass(parameters)
}

/// A motor under one set of conditions.
#[derive(Debug)]
pub struct Site<'a> {
    /// The motor.
    pub parameters: &'a Parameters,
    /// The conditions.
    pub at: &'a Conditions,
    /// Fan command after the effects at the port fan_flow.
    pub command: f64,
    /// Coefficients in still air.
    pub still: StillAir,
    /// Number of segments of the housing.
    pub segments: usize,
    /// The gap between motor and tube.
    pub gap: Option<&'a Gap>,
}

impl Site<'_> {
    /// Conductance of one segment in still air, W/K.
    pub fn free(&self) -> f64 {
        let lateral = self.parameters.housing.lateral_area() / self.segments as f64;
        lateral * (self.still.lateral + self.still.radiation)
    }

    /// Each segment with the fraction of its length between two axial positions.
    pub fn covered(&self, from: f64, to: f64) -> impl Iterator<Item = (usize, f64)> + use<> {
        let n = self.segments;
        let dx = self.parameters.housing.length / n as f64;
        (0..n).map(move |k| {
            let x = dx * k as f64;
            (k, ((to.min(x + dx) - from.max(x)) / dx).clamp(0.0, 1.0))
        })
    }

    /// Everything that the heat paths of a slow method depend on.
    fn key(&self) -> Key {
        let (p, at) = (self.parameters, *self.at);
        let (mode, housing, parts) = (p.choices.cooling_mode, p.housing, p.cooling);
        Key { at, command: self.command, segments: self.segments, mode, housing, parts }
    }

    /// The heat paths that a method adds here.
    fn coefficients(&self, method: &dyn Method) -> Coefficients {
        let mut c = Coefficients::NONE;
        method.add(self, &mut c);
        c
    }

    /// Conductance that effects add to the housing, W/K.
    fn by_effects(&self) -> f64 {
        let (at, effects) = (self.at, &self.parameters.effects);
        let rise = at.surface - at.ambient;
        let curved = if rise.abs() > 1e-3 {
            effects.housing_to_ambient(at.surface, at.ambient) / rise
        } else {
            effects.housing_to_ambient_slope(at.surface, at.ambient)
        };
        effects.ambient_conductance(Conductance::share(self.command)).housing + curved
    }
}

/// The cooling of one motor, from its parameters alone.
#[derive(Clone, Copy, Debug)]
pub struct Cooling {
    /// Number of segments of the housing.
    pub segments: usize,
    method: &'static dyn Method,
    gap: Option<Gap>,
    has_node: bool,
}

impl Cooling {
    /// The cooling of a motor with a housing of `segments` segments.
    pub fn new(parameters: &Parameters, segments: usize) -> Cooling {
        Cooling::of(method(parameters.choices.cooling_mode), parameters, segments)
    }

    /// The same by this method.
    pub(super) fn of(method: &'static dyn Method, parameters: &Parameters, segments: usize) -> Cooling {
        let has_node = method.tube_capacity(parameters) > 0.0;
        Cooling { segments, method, gap: method.gap(parameters), has_node }
    }

    /// Whether the mode has a node of its own, on whose temperature the coefficients may depend.
    pub fn has_node(&self) -> bool {
        self.has_node
    }

    /// See [`Method::is_smooth`].
    pub fn is_smooth(&self) -> bool {
        self.method.is_smooth()
    }

    /// Outputs of the mode; see [`Method::show`].
    pub fn show(&self, stream: &Stream, out: &mut EnergyBalance) {
        self.method.show(stream, out);
    }

    /// The coefficients at one set of conditions: those of the method, of effects, and of end faces and mount.
    pub fn coefficients(&self, parameters: &Parameters, at: &Conditions) -> Coefficients {
        let p = parameters;
        let site = Site {
            parameters,
            at,
            command: p.effects.fan_flow(at.fan_command),
            still: p.housing.still_air(at.surface, at.ambient, at.ambient_pressure),
            segments: self.segments,
            gap: self.gap.as_ref(),
        };
        let mut c = if self.method.is_slow() {
            repeated::or(site.key(), || site.coefficients(self.method))
        } else {
            site.coefficients(self.method)
        };
        let has_network = self.method.has_network();
        let everywhere = site.by_effects() + if has_network { p.thermal.G_mount } else { 0.0 };
        for direct in &mut c.ambient_conductance[..self.segments] {
            *direct += everywhere / self.segments as f64;
        }
        if has_network {
            let ends = p.housing.end_area() * (site.still.end + site.still.radiation);
            c.ambient_conductance[0] += ends;
            c.ambient_conductance[self.segments - 1] += ends;
        }
        c
    }
}
