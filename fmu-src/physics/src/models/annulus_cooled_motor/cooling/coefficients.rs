//! Heat transfer from each segment of the housing to air or coolant, as coefficients for one set of conditions.
//!
//! segment to ambient:  q = G_a (T - T_a)                                                   (1)
//! wall:                s = T_t + w (T - T_t)
//! flow:                q_flow = eps C (s - T_f),   T_f' = T_f + eps (s - T_f)               (2)
//!                      q_segment = w [G (T - s) + q_flow],   q_tube the same with 1 - w
//!
//! (2) is exact for a segment of motor and tube at one temperature each: C = m_flow c_p in W/K, G = h A of both walls, w the motor's
//! fraction of it, effectiveness eps = 1 - exp(-G/C). Without a tube w = 1.
//! *Assumes* that tube and motor have the same coefficient; the correlations at the mean surface temperature,
//! air properties at its mean temperature in the gap.
//! *Source*: (2) Incropera, 7th ed., eq. 8.41; the correlations in `correlations/`.

use super::Conditions;
use crate::components::housing::SEGMENTS;

/// Coefficients of the air and the coolant, linear in all temperatures.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    /// Conductance from each segment to ambient, W/K.
    pub ambient_conductance: [f64; SEGMENTS],
    /// Conductance of both walls of the gap along each segment, W/K.
    pub film_conductance: [f64; SEGMENTS],
    /// The segment's fraction of the film conductance.
    pub share: [f64; SEGMENTS],
    /// Effectiveness: temperature change of the flow divided by its inlet temperature difference to the walls.
    pub effectiveness: [f64; SEGMENTS],
    /// Heat capacity rate of the flow, W/K.
    pub m_flow_cp: f64,
    /// Temperature rise of the air before the gap by the fan power, K.
    pub inlet_rise: f64,
    /// Conductance from each segment to the node of the mode, W/K; radiation to a tube.
    pub to_tube: f64,
    /// Conductance from the node to ambient, W/K.
    pub tube_to_ambient: f64,
    /// Fan power that heats the air of the gap, W.
    pub fan_power: f64,
    /// Inlet temperature of a coolant, K; `None` for ambient air.
    pub coolant_inlet: Option<f64>,
    /// Volume flow rate over the motor, m3/s. Outputs are read at the conditions of an evaluation: this and what follows are not linearized.
    pub flow: f64,
    /// Ratio of the air's excess temperature behind the motor to that at the outlet of the last segment: 1, but smaller near
    /// zero flow, where the air behind the motor has ambient temperature.
    pub behind: f64,
    /// Pressure rise of the fan, Pa.
    pub pressure_drop: f64,
    /// Further outputs of a mode, for its [`show`](super::Method::show).
    pub of_mode: [f64; 2],
}

/// Heat flows of one segment and its length of tube to the air, W, and the air temperature behind them, K.
pub struct Passing {
    /// From the segment.
    pub segment: f64,
    /// From the tube.
    pub tube: f64,
    /// Temperature of the air behind the segment.
    pub air: f64,
}

impl Coefficients {
    /// No heat transfer.
    pub const NONE: Coefficients = Coefficients {
        ambient_conductance: [0.0; SEGMENTS],
        film_conductance: [0.0; SEGMENTS],
        share: [1.0; SEGMENTS],
        effectiveness: [0.0; SEGMENTS],
        m_flow_cp: 0.0,
        inlet_rise: 0.0,
        to_tube: 0.0,
        tube_to_ambient: 0.0,
        flow: 0.0,
        behind: 1.0,
        pressure_drop: 0.0,
        fan_power: 0.0,
        coolant_inlet: None,
        of_mode: [0.0; 2],
    };

    /// Inlet temperature of the flow, K.
    #[inline]
    pub fn inlet(&self, ambient: f64) -> f64 {
        self.coolant_inlet.unwrap_or(ambient + self.inlet_rise)
    }

    /// Heat flows of a segment and its length of tube into the flow, eq. (2); temperatures of segment, tube and flow in K.
    #[inline]
    pub fn passing(&self, k: usize, t: f64, tube: f64, air: f64) -> Passing {
        let (share, films) = (self.share[k], self.film_conductance[k]);
        let wall = tube + share * (t - tube);
        let taken = self.effectiveness[k] * (wall - air);
        let carried = self.m_flow_cp * taken;
        Passing {
            segment: share * (films * (t - wall) + carried),
            tube: (1.0 - share) * (films * (tube - wall) + carried),
            air: air + taken,
        }
    }

    /// Heat flows out of the housing and out of the tube, all segments at the mean temperature, W.
    pub(super) fn heats(&self, at: &Conditions, n: usize) -> [f64; 2] {
        let (t, tube, ambient) = (at.surface, at.tube, at.ambient);
        let mut air = self.inlet(ambient);
        let [mut from_housing, mut from_tube] = [0.0, self.tube_to_ambient * (tube - ambient)];
        for k in 0..n {
            let p = self.passing(k, t, tube, air);
            let radiated = self.to_tube * (t - tube);
            from_housing += self.ambient_conductance[k] * (t - ambient) + radiated + p.segment;
            from_tube += p.tube - radiated;
            air = p.air;
        }
        [from_housing, from_tube]
    }

    /// Takes the values of `base` plus `z` times `slope` for the first `n` segments.
    #[inline]
    pub(super) fn take(&mut self, base: &Coefficients, slope: &Coefficients, z: f64, n: usize) {
        // Not a copy and a sum: copies of a few numbers are calls that take longer than the sums.
        for k in 0..n.min(SEGMENTS) {
            self.ambient_conductance[k] = base.ambient_conductance[k] + z * slope.ambient_conductance[k];
            self.film_conductance[k] = base.film_conductance[k] + z * slope.film_conductance[k];
            self.share[k] = base.share[k] + z * slope.share[k];
            self.effectiveness[k] = base.effectiveness[k] + z * slope.effectiveness[k];
        }
        (self.flow, self.behind) = (base.flow, base.behind);
        (self.pressure_drop, self.of_mode) = (base.pressure_drop, base.of_mode);
        self.coolant_inlet = base.coolant_inlet;
        self.m_flow_cp = base.m_flow_cp;
        self.to_tube = base.to_tube;
        self.tube_to_ambient = base.tube_to_ambient;
        self.fan_power = base.fan_power;
        self.change_flow(slope, z);
    }

    /// Adds `z` times `slope` for the first `n` segments.
    #[inline]
    pub(super) fn change(&mut self, slope: &Coefficients, z: f64, n: usize) {
        for k in 0..n.min(SEGMENTS) {
            self.ambient_conductance[k] += z * slope.ambient_conductance[k];
            self.film_conductance[k] += z * slope.film_conductance[k];
            self.share[k] += z * slope.share[k];
            self.effectiveness[k] += z * slope.effectiveness[k];
        }
        self.change_flow(slope, z);
    }

    /// The same for what all segments have in common.
    #[inline]
    fn change_flow(&mut self, slope: &Coefficients, z: f64) {
        self.m_flow_cp += z * slope.m_flow_cp;
        self.to_tube += z * slope.to_tube;
        self.tube_to_ambient += z * slope.tube_to_ambient;
        self.fan_power += z * slope.fan_power;
        // The rise is computed from the fan power and the heat capacity rate, so that energy is conserved.
        self.inlet_rise = if self.m_flow_cp > 0.0 { self.fan_power / self.m_flow_cp } else { 0.0 };
    }
}
