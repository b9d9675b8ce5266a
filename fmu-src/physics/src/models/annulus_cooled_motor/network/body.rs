//! Heat capacities and conductances of the network.

pub use crate::components::housing::SEGMENTS;
use crate::effects::Stator;
use crate::models::annulus_cooled_motor::cooling::method;
use crate::models::annulus_cooled_motor::parameters::Parameters;

/// Index of the first segment among the temperatures, after rotor and tube.
pub(super) const FIRST: usize = 2;

/// Heat capacities and conductances of the network, from the parameters alone.
#[derive(Clone, Copy, Debug)]
pub struct Body {
    /// Number of segments of the housing.
    pub segments: usize,
    /// Heat capacities of rotor, tube and one segment, J/K; 0 for an absent node.
    pub capacity: [f64; 3],
    /// Their reciprocals, K/J; 0 for an absent node, whose temperature is then constant.
    pub per_joule: [f64; 3],
    /// Heat capacity of the stator, the node next to the winding, J/K.
    pub stator: f64,
    /// Conductance from stator to one segment, W/K.
    pub from_stator: f64,
    /// Conductance from winding to rotor, W/K.
    pub winding_to_rotor: f64,
    /// Conductance from rotor to one segment, W/K.
    pub from_rotor: f64,
    /// Axial conductance between neighbouring segments, W/K.
    pub axial: f64,
    /// Conductance from the winding along its leads to ambient, W/K.
    pub leads: f64,
    /// Fraction of the friction heat that goes to the rotor.
    pub friction_to_rotor: f64,
    /// Whether iron loss heats the stator; otherwise it is part of the friction heat.
    pub iron_in_stator: bool,
}

impl Body {
    /// The network for these parameters; `None` for the model with two nodes.
    pub fn of(parameters: &Parameters) -> Option<Body> {
        let thermal = &parameters.thermal;
        let Stator { resistance, capacity } = parameters.effects.stator();
        let method = method(parameters.choices.cooling_mode);
        if !method.has_network() {
            // Winding and stator, with the housing as the single segment.
            return (capacity > 0.0).then(|| Body {
                segments: 1,
                capacity: [0.0, 0.0, thermal.C_h],
                per_joule: [0.0, 0.0, 1.0 / thermal.C_h],
                stator: capacity,
                from_stator: 1.0 / resistance,
                winding_to_rotor: 0.0,
                from_rotor: 0.0,
                axial: 0.0,
                leads: 0.0,
                friction_to_rotor: 0.0,
                iron_in_stator: false,
            });
        }
        let n = f64::from(parameters.choices.air_segments.clamp(1, SEGMENTS as i32));
        let rest = thermal.C_h - thermal.C_r;
        let tube = method.tube_capacity(parameters);
        let capacity_of_nodes = [thermal.C_r, tube, rest * (1.0 - thermal.stator_share) / n];
        Some(Body {
            segments: n as usize,
            capacity: capacity_of_nodes,
            per_joule: capacity_of_nodes.map(|c| if c > 0.0 { 1.0 / c } else { 0.0 }),
            stator: rest * thermal.stator_share + capacity,
            from_stator: 1.0 / (n * (thermal.R_sh + resistance)),
            winding_to_rotor: thermal.G_wr,
            from_rotor: thermal.G_rh / n,
            axial: parameters.housing.axial_conductance(n as usize),
            leads: thermal.G_leads,
            friction_to_rotor: thermal.friction_to_rotor,
            iron_in_stator: true,
        })
    }

    /// Inconsistency between parameters, in one sentence.
    pub fn fault(parameters: &Parameters) -> Option<String> {
        let (p, method) = (parameters, method(parameters.choices.cooling_mode));
        if !method.has_network() {
            return None;
        }
        if p.thermal.C_r >= p.thermal.C_h {
            return Some(format!(
                "thermal.C_r = {} J/K is a part of thermal.C_h = {} J/K and must be below it.",
                p.thermal.C_r, p.thermal.C_h
            ));
        }
        method.fault(p)
    }

    /// Number of states in use: temperatures and the energy given to ambient.
    pub(super) fn states(&self) -> usize {
        FIRST + self.segments + 1
    }

    /// Whether the temperature at this index is a state: rotor, tube, then the segments.
    pub fn holds(&self, place: usize) -> bool {
        if place < FIRST { self.has(place) } else { place < FIRST + self.segments }
    }

    /// Whether a node exists.
    pub(super) fn has(&self, node: usize) -> bool {
        self.capacity[node] > 0.0
    }
}
