//! Thermal network beside winding and stator: rotor, housing segments along the axis, and the tube around them.
//!
//! ```text
//! C_r dT_r/dt = G_wr (T_w - T_r) + Q_r - sum_i G_rh/n (T_r - T_i)                          (1)
//! C_i dT_i/dt = (T_s - T_i)/(n R_sh) + G_rh/n (T_r - T_i) + Q_h/n + G_x (T_{i-1} - 2 T_i + T_{i+1})
//!               - direct_i (T_i - T_a) - q_air,i - G_tube (T_i - T_t)                      (2)
//! C_t dT_t/dt = sum_i [G_tube (T_i - T_t) - q_air,t,i] - G_out (T_t - T_a)                 (3)
//! ```
//! T_w and T_s are winding and stator, the two nodes of `equations.rs`; q_air follows from `cooling/coefficients.rs`,
//! where the outlet air of one segment is the inlet air of the next. A node that the mode does not use is constant.
//!
//! Over a substep the two nodes use rotor and housing temperatures that are linear in time. The network then receives the
//! heat that left the two nodes, so that energy is conserved. The substep is shortened until the error of the linear
//! temperatures is small enough ([`Network::miss`]). `solver/stabilized.rs` solves the network itself.

mod body;
mod substep;

pub use body::{Body, SEGMENTS};
pub use substep::{Advance, CouplingIntegrals};

use super::cooling::{Coefficients, Conditions, Cooling, Passing, Stream, Tangent};
use super::parameters::Parameters;
use super::variables::{EnergyBalance, Inputs};
use crate::runtime::Saved;
use crate::solver::stabilized::{MOST, Stabilized, States};
use body::FIRST;

const ROTOR: usize = 0;
/// Index of the tube among the temperatures.
pub const TUBE: usize = 1;

/// Largest temperature error of an accepted substep, K.
const TOLERANCE: f64 = 1e-6;

/// Heat flows into the network at one instant. What flows into a segment depends on its temperature: [`Network::heat_of_segment`].
#[derive(Clone, Copy, Debug)]
pub struct Inflow {
    /// Heat flow into the rotor, W.
    rotor: f64,
    /// Stator temperature, K.
    stator: f64,
    /// Friction heat of each segment, W.
    friction: f64,
}

/// Heat flows of the network at one instant, W.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flows {
    /// From the rotor to the housing.
    pub rotor_to_housing: f64,
    /// From the housing to ambient.
    pub housing_to_room: f64,
    /// From the housing to the air or coolant flow.
    pub housing_to_air: f64,
    /// From the housing to the tube, by radiation.
    pub housing_to_tube: f64,
    /// From the tube to the air flow.
    pub tube_to_air: f64,
    /// From the tube to ambient.
    pub tube_to_ambient: f64,
    /// From the fan to the air flow.
    pub fan_to_air: f64,
    /// Enthalpy flow of air or coolant to ambient.
    pub air_to_room: f64,
    /// Outlet temperature of air or coolant, K.
    pub outlet: f64,
}

/// Thermal network of one motor with its temperatures.
#[derive(Clone, Debug)]
pub struct Network {
    /// Heat capacities and conductances.
    pub body: Body,
    cooling: Cooling,
    /// Temperatures of rotor, tube and segments, and the energy given to ambient over the last substep.
    states: States,
    /// Conditions of the last evaluation of the coefficients.
    at: Conditions,
    /// The linearization at these conditions, unless they were evaluated for a reading. It follows from them and is larger than all the rest.
    tangent: Option<Box<Tangent>>,
    /// Present coefficients.
    now: Coefficients,
    /// Heat flow that effects add to the housing (port housing_heat), W.
    from_outside: f64,
    method: Stabilized,
    /// Upper bound of the rates, 1/s.
    fastest: f64,
    /// States at the end of the last substep.
    next: States,
    /// Length of the next substep attempt, s.
    pub substep: f64,
    /// Largest error of an accepted substep, K.
    pub tolerance: f64,
}

impl Network {
    /// The network at a uniform temperature.
    pub fn new(parameters: &Parameters, body: Body, temperature: f64) -> Network {
        Network {
            body,
            cooling: Cooling::new(parameters, body.segments),
            states: [temperature; MOST],
            at: Conditions::NONE,
            tangent: Some(Box::new(Tangent::NONE)),
            now: Coefficients::NONE,
            from_outside: 0.0,
            method: Stabilized::default(),
            fastest: 0.0,
            next: [temperature; MOST],
            substep: 1e-3,
            tolerance: TOLERANCE,
        }
    }

    /// Sets the tolerance of a substep to a multiple of the default.
    pub fn ease(&mut self, factor: f64) {
        self.tolerance = TOLERANCE * factor;
    }

    /// Applies changed parameters. The number of segments must not have changed.
    pub fn follow(&mut self, parameters: &Parameters, body: Body) {
        self.body = body;
        self.cooling = Cooling::new(parameters, body.segments);
        self.forget();
    }

    /// A copy without the linearization, for a reading or to [`return_to`](Self::return_to). It needs no memory.
    pub fn bare(&self) -> Network {
        Network { tangent: None, ..*self }
    }

    /// Becomes this copy; the linearization is evaluated again if it is a later one.
    pub fn return_to(&mut self, parameters: &Parameters, before: Network) {
        let tangent = self.tangent.take();
        let is_later = tangent.as_ref().is_none_or(|tangent| tangent.at != before.at);
        *self = Network { tangent, ..before };
        if self.at.surface.is_nan() {
            self.forget();
        } else if is_later {
            let (now, fastest) = (self.now, self.fastest);
            self.renew(parameters, self.at);
            (self.now, self.fastest) = (now, fastest);
        }
    }

    /// Sets the temperatures of rotor, housing and tube, K.
    pub fn put_temperatures(&mut self, rotor: f64, housing: f64, tube: f64) {
        (self.states[ROTOR], self.states[TUBE]) = (rotor, tube);
        self.states[FIRST..FIRST + self.body.segments].fill(housing);
        self.forget();
    }

    fn housing(&self) -> &[f64] {
        &self.states[FIRST..FIRST + self.body.segments]
    }

    /// Mean temperature of the housing, K.
    pub fn housing_temperature(&self) -> f64 {
        mean(self.housing())
    }

    /// Temperature of the rotor with its magnets, K; without a rotor node that of the housing.
    pub fn rotor_temperature(&self) -> f64 {
        if self.body.has(ROTOR) { self.states[ROTOR] } else { self.housing_temperature() }
    }

    /// Rotor temperature at the end of the last substep, before it is accepted, K.
    pub fn rotor_ahead(&self) -> f64 {
        let next = &self.next;
        if self.body.has(ROTOR) { next[ROTOR] } else { mean(&next[FIRST..FIRST + self.body.segments]) }
    }

    /// Temperatures, K: rotor, tube, segments from [`FIRST`] on.
    pub fn temperatures(&self) -> &States {
        &self.states
    }

    /// Mutable access to [`temperatures`](Self::temperatures).
    pub fn temperatures_mut(&mut self) -> &mut States {
        &mut self.states
    }

    /// Heat stored in the network above the temperature `origin`, K, in J.
    pub fn stored(&self, origin: f64) -> f64 {
        let [rotor, tube, segment] = self.body.capacity;
        let housing: f64 = self.housing().iter().map(|t| t - origin).sum();
        rotor * (self.states[ROTOR] - origin) + tube * (self.states[TUBE] - origin) + segment * housing
    }

    /// Appends the temperatures and the other variables that the next step depends on.
    pub fn save(&self, out: &mut Vec<f64>) {
        out.extend(&self.states[..FIRST + self.body.segments]);
        self.at.save(out);
        out.push(self.substep);
    }

    /// Restores the numbers of [`save`](Self::save); `None` if there are too few.
    pub fn take_numbers(
        &mut self,
        parameters: &Parameters,
        next: &mut impl FnMut() -> Option<f64>,
    ) -> Option<()> {
        for state in &mut self.states[..FIRST + self.body.segments] {
            *state = next()?;
        }
        let mut at = Conditions::NONE;
        at.load(next)?;
        self.substep = next()?;
        if at.surface.is_nan() {
            self.forget();
        } else {
            self.renew(parameters, at);
        }
        Some(())
    }

    /// Evaluates the coefficients at these conditions, and the quantities that depend only on them.
    fn renew(&mut self, parameters: &Parameters, at: Conditions) {
        let tangent = self.tangent.get_or_insert_with(|| Box::new(Tangent::NONE));
        tangent.evaluate(&self.cooling, parameters, at);
        tangent.coefficients(&self.cooling, parameters, &at, &mut self.now);
        self.at = at;
        self.fastest = self.bound();
    }

    fn conditions(&self, inputs: &Inputs, ambient: f64, [housing, tube]: [f64; 2]) -> Conditions {
        Conditions::of(inputs, self.housing_temperature() + housing, self.states[TUBE] + tube, ambient)
    }

    /// Updates the coefficients to the inputs, with housing and tube `ahead` kelvin above their present temperatures.
    pub fn refresh(&mut self, parameters: &Parameters, inputs: &Inputs, ambient: f64, ahead: [f64; 2]) {
        let at = self.conditions(inputs, ambient, ahead);
        self.from_outside = parameters.effects.housing_heat(at.surface);
        match &mut self.tangent {
            Some(tangent) if tangent.serves(&at) => {
                tangent.coefficients(&self.cooling, parameters, &at, &mut self.now);
            }
            _ => self.renew(parameters, at),
        }
    }

    /// Evaluates the coefficients at the present temperatures by the full equations, independent of the history.
    pub fn evaluate(&mut self, parameters: &Parameters, inputs: &Inputs, ambient: f64) {
        let at = self.conditions(inputs, ambient, [0.0; 2]);
        self.from_outside = parameters.effects.housing_heat(at.surface);
        if self.at != at {
            self.forget();
            self.now = self.cooling.coefficients(parameters, &at);
            self.at = at;
        }
    }

    /// Whether the coefficients are those of the full equations at the present temperatures, provided that only
    /// [`evaluate`](Self::evaluate) sets them.
    pub fn is_evaluated_at(&self, inputs: &Inputs, ambient: f64) -> bool {
        self.at == self.conditions(inputs, ambient, [0.0; 2])
    }

    /// Invalidates the coefficients, so that the next [`refresh`](Network::refresh) evaluates them.
    pub fn forget(&mut self) {
        self.at = Conditions::NONE;
        if let Some(tangent) = &mut self.tangent {
            tangent.at = Conditions::NONE;
        }
    }

    /// Present coefficients.
    pub fn coefficients(&self) -> &Coefficients {
        &self.now
    }

    /// Heat flows into the network at one instant; winding and stator temperatures in K, `friction` in W.
    pub fn inflow(&self, winding: f64, stator: f64, friction: f64) -> Inflow {
        let body = &self.body;
        let of_rotor = friction * body.friction_to_rotor;
        Inflow {
            rotor: body.winding_to_rotor * (winding - self.states[ROTOR]) + of_rotor,
            stator,
            friction: self.friction_of_segment(friction),
        }
    }

    /// The part of `friction` that heats each segment, in its unit.
    fn friction_of_segment(&self, friction: f64) -> f64 {
        friction * (1.0 - self.body.friction_to_rotor) / self.body.segments as f64
    }

    /// Heat flow into a segment at its present temperature, W.
    #[inline(always)]
    fn heat_of_segment(&self, inflow: &Inflow, k: usize) -> f64 {
        self.body.from_stator * (inflow.stator - self.states[FIRST + k]) + inflow.friction
    }

    /// Derivatives of all states, eqs. (1) to (3), K/s, and the heat flow to ambient, W, with these heat flows into the rotor and the
    /// segments, W.
    fn rates(
        &self,
        ambient: f64,
        (into_rotor, into_segment): (f64, impl Fn(usize) -> f64),
        y: &[f64],
        out: &mut [f64],
    ) {
        let (body, c) = (&self.body, &self.now);
        let n = body.segments.min(SEGMENTS);
        let (y, out) = (&y[..=FIRST + n], &mut out[..=FIRST + n]);
        let (rotor, tube) = (y[ROTOR], y[TUBE]);
        let [per_rotor, per_tube, per_joule] = body.per_joule;
        let inlet = c.inlet(ambient);
        let mut air = inlet;
        let from_outside = self.from_outside / n as f64;
        let (mut from_rotor, mut to_tube) = (0.0, 0.0);
        let mut leaving = -self.from_outside;
        let mut before = y[FIRST];
        for k in 0..n {
            let t = y[FIRST + k];
            let after = if k + 1 < n { y[FIRST + k + 1] } else { t };
            let from = body.from_rotor * (rotor - t);
            let direct = c.ambient_conductance[k] * (t - ambient);
            let radiated = c.to_tube * (t - tube);
            let along = body.axial * (before - 2.0 * t + after);
            let Passing { segment, tube: from_tube, air: next } = c.passing(k, t, tube, air);
            air = next;
            from_rotor += from;
            to_tube += radiated - from_tube;
            leaving += direct;
            let gain = into_segment(k) + from_outside + from + along;
            out[FIRST + k] = (gain - direct - radiated - segment) * per_joule;
            before = t;
        }
        let outside = c.tube_to_ambient * (tube - ambient);
        out[ROTOR] = (into_rotor - from_rotor) * per_rotor;
        out[TUBE] = (to_tube - outside) * per_tube;
        out[FIRST + n] = leaving + outside + c.m_flow_cp * (air - inlet);
    }

    /// Derivatives at the present temperatures, K/s.
    pub fn rates_now(&self, ambient: f64, inflow: &Inflow) -> States {
        let mut out = [0.0; MOST];
        self.put_rates(ambient, inflow, &mut out);
        out
    }

    /// The same in `out`, without a copy.
    pub fn put_rates(&self, ambient: f64, inflow: &Inflow, out: &mut States) {
        self.rates(ambient, (inflow.rotor, |k| self.heat_of_segment(inflow, k)), &self.states, out);
    }

    /// Mean of [`rates_now`](Self::rates_now) over the segments.
    pub fn housing_rate(&self, rates: &States) -> f64 {
        mean(&rates[FIRST..FIRST + self.body.segments])
    }

    /// Changes of housing and tube over half a substep of `h` seconds at these derivatives, K.
    pub fn ahead(&self, rates: &States, h: f64) -> [f64; 2] {
        [self.housing_rate(rates), rates[TUBE]].map(|rate| 0.5 * h * rate)
    }

    /// Derivative of the rotor temperature in [`rates_now`](Self::rates_now), K/s; without a rotor node that of the housing.
    pub fn rotor_rate(&self, rates: &States) -> f64 {
        if self.body.has(ROTOR) { rates[ROTOR] } else { self.housing_rate(rates) }
    }

    /// Heat stored per time at these derivatives, W: rotor, tube, housing.
    pub fn stored_rates(&self, rates: &States) -> [f64; 3] {
        let [rotor, tube, segment] = self.body.capacity;
        [
            rotor * rates[ROTOR],
            tube * rates[TUBE],
            segment * self.body.segments as f64 * self.housing_rate(rates),
        ]
    }

    /// Heat flow to ambient from the result of [`rates_now`](Self::rates_now), without the fan power, W.
    pub fn to_ambient(&self, rates: &States) -> f64 {
        rates[FIRST + self.body.segments]
    }

    /// Upper bound of the network's eigenvalues, 1/s (Gershgorin).
    fn bound(&self) -> f64 {
        let (body, c) = (&self.body, &self.now);
        let n = body.segments;
        let mut most = 0.0f64;
        for k in 0..n {
            let flows = c.ambient_conductance[k] + c.film_conductance[k] + c.to_tube + body.from_rotor;
            most = most.max(flows);
        }
        let segment = (2.0 * most + 4.0 * body.axial) / body.capacity[2];
        let of =
            |conductance: f64, capacity: f64| if capacity > 0.0 { 2.0 * conductance / capacity } else { 0.0 };
        let tube: f64 =
            c.film_conductance[..n].iter().sum::<f64>() + n as f64 * c.to_tube + c.tube_to_ambient;
        let rotor = n as f64 * body.from_rotor + body.winding_to_rotor;
        segment.max(of(tube, body.capacity[TUBE])).max(of(rotor, body.capacity[ROTOR]))
    }

    /// Heat flow from the housing to ambient, to the air and to the tube, W.
    pub fn housing_heat(&self, ambient: f64) -> f64 {
        let flows = self.flows(ambient);
        // Heat that effects add to the housing leaves by the same paths.
        flows.housing_to_room + self.from_outside + flows.housing_to_air + flows.housing_to_tube
    }

    /// The outputs of the cooling at the present temperatures with these flows; the others are 0.
    pub fn show(
        &self,
        parameters: &Parameters,
        inputs: &Inputs,
        ambient: f64,
        flows: &Flows,
    ) -> EnergyBalance {
        let at = &self.conditions(inputs, ambient, [0.0; 2]);
        let (outlet, heat, to_node) = (flows.outlet, flows.housing_to_air, flows.housing_to_tube);
        let mut out = EnergyBalance::without_flow(inputs, ambient);
        self.cooling
            .show(&Stream { parameters, at, coefficients: &self.now, outlet, heat, to_node }, &mut out);
        out
    }

    /// Heat flows at the present temperatures, for the energy balance and the outputs.
    pub fn flows(&self, ambient: f64) -> Flows {
        let (body, c, y) = (&self.body, &self.now, &self.states);
        let (rotor, tube) = (y[ROTOR], y[TUBE]);
        let mut flows = Flows {
            tube_to_ambient: c.tube_to_ambient * (tube - ambient),
            fan_to_air: c.inlet_rise * c.m_flow_cp,
            housing_to_room: -self.from_outside,
            ..Flows::default()
        };
        let inlet = c.inlet(ambient);
        let mut air = inlet;
        for (k, &t) in self.housing().iter().enumerate() {
            flows.rotor_to_housing += body.from_rotor * (rotor - t);
            flows.housing_to_room += c.ambient_conductance[k] * (t - ambient);
            flows.housing_to_tube += c.to_tube * (t - tube);
            let p = c.passing(k, t, tube, air);
            flows.housing_to_air += p.segment;
            flows.tube_to_air += p.tube;
            air = p.air;
        }
        flows.air_to_room = c.m_flow_cp * (air - inlet) + flows.fan_to_air;
        flows.outlet = air;
        flows
    }
}

#[inline]
fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
