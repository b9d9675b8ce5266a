//! The equations in the form of the integrator: derivatives, their Jacobian, and the energies of a step.

use super::{CORE, NODES, Step, Temperatures, WINDING};
use crate::effects::EffectPort;
use crate::line::Line;
use crate::solver::phi::product;
use crate::solver::split::{Fast, HeatCapacities, Segment, System, Work};
use nalgebra::{Matrix2, SMatrix};

/// Quantities at one instant of a step that several integrals use.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Torque constant, N.m/A.
    pub(super) k: f64,
    /// Drag torque, N.m.
    pub(super) drag: f64,
    /// Resistance, Ohm.
    pub(super) r: f64,
    /// Voltage drop between terminals and winding, V.
    pub(super) lost: f64,
}

impl<const FORM: u8> System<NODES> for Step<'_, FORM> {
    type Instant = Instant;

    #[inline(always)]
    fn instant(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Instant {
        let drivers = self.drivers(t, x, temperature);
        let k = self.torque_constant(t, temperature, &drivers);
        Instant {
            k,
            drag: self.drag(t, x, temperature, k, &drivers),
            r: self.resistance(temperature[WINDING], &drivers),
            lost: self.lost_voltage(x[0], &drivers),
        }
    }

    #[inline(always)]
    fn fast_rates_at(&self, t: f64, x: &Fast, _: &Temperatures, instant: &Instant) -> Fast {
        let (i, w) = (x[0], x[1]);
        let k = instant.k;
        let lost = if Self::PLAIN { 0.0 } else { instant.lost + self.bridge(i) + self.missed(t, i) };
        // One of the two summands is zero: 1/L or the derivative of the imposed current; 1/J or that of the imposed speed.
        let di = (self.source(t, k * w) - instant.r * i - lost - k * w) * self.constants.inverse_l;
        let dw = (k * i - instant.drag - Self::at(&self.load, t)) * self.constants.inverse_j;
        let free = Fast::new(di, dw);
        if Self::STILL { free } else { free + Fast::new(self.current.slope, self.speed.slope) }
    }

    #[inline(always)]
    fn fast_matrix_at(
        &self,
        t: f64,
        x: &Fast,
        temperature: &Temperatures,
        instant: &Instant,
    ) -> Matrix2<f64> {
        let effects = self.ports();
        let lost = effects.terminal_voltage_slope(x[0]) + self.drive_slope(t, x[0]);
        let (r, k) = (instant.r + lost, instant.k);
        let slope = if self.is_free() {
            let load = self.load.at(t);
            effects.drag_torque_slope(x[1])
                + effects.warm_drag_slope(x[1], self.magnets(t, temperature))
                + effects.load_drag_slope(x[1], load) * load
        } else {
            0.0
        };
        let (l, j) = (self.constants.inverse_l, self.constants.inverse_j);
        // With open switches the terminal voltage depends on the back-EMF.
        let followed = if self.coasts() { self.chopper.open_voltage(t, k * x[1]).1 } else { 0.0 };
        let matrix = Matrix2::new(-r * l, -k * l * (1.0 - followed), k * j, -slope * j);
        if !self.is_driven() {
            return matrix;
        }
        let drivers = self.drivers(t, x, temperature);
        let [volts, torque] = self.driven_slopes(t, x, temperature, &drivers, 1.0 - followed);
        matrix + Matrix2::new(-volts[0] * l, -volts[1] * l, torque[0] * j, torque[1] * j)
    }

    #[inline(always)]
    fn network(&self, t: f64, temperature: &Temperatures) -> (Temperatures, f64) {
        let conducts = self.constants.across * self.ports().winding_housing_conductance(temperature[WINDING]);
        let across = conducts * (temperature[WINDING] - temperature[CORE]);
        let leaving = self.leaving(t, temperature);
        let gain = Temperatures::new(-across - leaving.winding, across - leaving.housing);
        (gain.component_mul(&self.constants.capacity.inverse), leaving.winding + leaving.housing)
    }

    const IS_NETWORK_LINEAR: bool = Self::PLAIN;

    #[inline(always)]
    fn network_remainder(
        &self,
        t: f64,
        temperature: &Temperatures,
        matrix: &SMatrix<f64, NODES, NODES>,
        share: &Temperatures,
    ) -> (Temperatures, f64) {
        if !Self::PLAIN {
            let (rates, outflow) = self.network(t, temperature);
            return (rates - product(matrix, temperature), outflow - share.dot(temperature));
        }
        let conductance = self.conductance_at(t);
        let entering = Temperatures::new(
            conductance.winding * Self::at(&self.coupling.winding, t),
            conductance.housing * Self::at(&self.coupling.core, t),
        );
        (entering.component_mul(&self.constants.capacity.inverse), -entering.sum())
    }

    #[inline(always)]
    fn network_matrix(&self, t: f64, temperature: &Temperatures) -> SMatrix<f64, NODES, NODES> {
        let conductance = self.conductance_at(t);
        let across = self.constants.across;
        if Self::PLAIN {
            return self.network_matrix_of([across; 2], conductance.winding, conductance.housing);
        }
        let effects = self.ports();
        let (t_w, t_h) = (temperature[WINDING], temperature[CORE]);
        // Derivatives of the heat flow from winding to housing: `hot` with respect to T_w, `cold` with respect to -T_h.
        let share = effects.winding_housing_conductance(t_w);
        let cold = across * share;
        let hot = cold - cold * (t_w - t_h) * effects.winding_housing_resistance_slope(t_w) * share;
        let t_a = self.ambient.at(t);
        let from_housing = conductance.housing
            + effects.housing_to_ambient_slope(t_h, t_a)
            + self.model.conductance.G_still * effects.still_air_slope(t_h - t_a)
            - effects.housing_heat_slope(t_h);
        self.network_matrix_of([hot, cold], conductance.winding, from_housing)
    }

    #[inline]
    fn capacity(&self) -> &HeatCapacities<NODES> {
        &self.constants.capacity
    }

    #[inline(always)]
    fn heat_rates_at(&self, t: f64, x: &Fast, _: &Temperatures, instant: &Instant) -> Temperatures {
        let (i, w) = (x[0], x[1]);
        let lost = if Self::PLAIN { 0.0 } else { instant.lost };
        let copper = (instant.r * i + lost) * i + self.ripple_loss(t, instant.r);
        let core = self.drag_in_core(w, instant.drag * w) + Self::at(&self.stator, t);
        Temperatures::new(copper + self.heat_at(t, w), core)
    }

    /// Energies of one step, each from its own equation and the integrals of the fast solution, so that the balance residual
    /// is the error of the step.
    #[inline(always)]
    fn work(&self, segment: &Segment<NODES>, instants: &[Instant; 3]) -> Work<NODES> {
        let effects = self.ports();
        let (t, h) = (segment.t, segment.h);
        let [x0, xm, x1] = segment.x;
        let at = [t, t + 0.5 * h, t + h];
        let simpson = |f0: f64, fm: f64, f1: f64| segment.simpson([f0, fm, f1]);
        let line = |l: &Line, k: usize| {
            if Self::STILL { l.start * segment.integral[k] } else { segment.against_line(l, k) }
        };
        let against = |f: [f64; 3], k: usize| segment.against(f, k);
        let k_t = |n: usize| instants[n].k;

        let (friction, mut quadrature_error) = against(instants.map(|instant| instant.drag), 1);
        let mut in_core = friction;
        if self.has_network() {
            let iron =
                |n: usize| if self.constants.iron_in_core { self.iron_drag(segment.x[n][1]) } else { 0.0 };
            let error_of_iron;
            (in_core, error_of_iron) = against([iron(0), iron(1), iron(2)], 1);
            quadrature_error += error_of_iron;
        }
        let (air_gap, mechanical) = if self.is_free() {
            let load = line(&self.load, 1);
            (self.kinetic(x1[1]) - self.kinetic(x0[1]) + load + friction, load)
        } else {
            let air_gap = if self.is_voltage_driven() && self.is_driven() {
                // A term may change the torque constant as fast as the current.
                let (air_gap, error) = against([0, 1, 2].map(|n| k_t(n) * segment.x[n][1]), 0);
                quadrature_error += error;
                air_gap
            } else if self.is_voltage_driven() {
                // The magnet temperature changes by microkelvins over a step; the midpoint value is accurate enough.
                k_t(1) * line(&self.speed, 0)
            } else {
                simpson(k_t(0) * x0[0] * x0[1], k_t(1) * xm[0] * xm[1], k_t(2) * x1[0] * x1[1])
            };
            (air_gap, air_gap - friction)
        };
        let mut load = 0.0;
        if effects.acts.at(EffectPort::PowerModeLoad) {
            let error_of_load;
            (load, error_of_load) = against([x0, xm, x1].map(|x| self.power_mode_torque(x[1])), 1);
            quadrature_error += error_of_load;
        }
        let stator = h * Self::at(&self.stator, t + 0.5 * h);
        let mut heat = h * Self::at(&self.heat, t + 0.5 * h) - load;
        if self.loses() {
            let ripple = [0, 1, 2].map(|n| self.ripple_loss(at[n], instants[n].r));
            let over_step = simpson(ripple[0], ripple[1], ripple[2]);
            heat += over_step;
            quadrature_error += (over_step - 0.5 * h * (ripple[0] + ripple[2])).abs();
        }
        let mut drive = h * Self::at(&self.drive, t + 0.5 * h);
        // R i^2: the end value of R times the integral of i^2, plus Simpson's rule for the deviation of R from its end value.
        let r = |n: usize| instants[n].r;
        let heating = |n: usize| (r(n) - r(2)) * segment.x[n][0] * segment.x[n][0];
        let mut drop = 0.0;
        if effects.acts.at(EffectPort::TerminalVoltage) {
            let error_of_drop;
            (drop, error_of_drop) = against(instants.map(|instant| instant.lost), 0);
            quadrature_error += error_of_drop;
        }
        let (copper, electrical) = if self.is_voltage_driven() {
            let copper = r(2) * segment.square + (simpson(heating(0), heating(1), 0.0) + drop);
            quadrature_error += r(2) * segment.error_of_square;
            let mut supplied = line(&self.voltage, 0);
            if self.coasts() {
                let open = [0, 1, 2].map(|n| self.source(at[n], k_t(n) * segment.x[n][1]));
                let error_of_open;
                (supplied, error_of_open) = against(open, 0);
                quadrature_error += error_of_open;
            } else if !Self::PLAIN && self.voltage_bend != 0.0 {
                let (bend, error_of_bend) = against(at.map(|t| self.voltage_bend * (t * t)), 0);
                supplied += bend;
                quadrature_error += error_of_bend;
            }
            if self.loses() {
                let (bridge, error_of_bridge) = against([x0, xm, x1].map(|x| self.bridge(x[0])), 0);
                let (missed, error_of_missed) =
                    against([0, 1, 2].map(|n| self.missed(at[n], segment.x[n][0])), 0);
                quadrature_error += error_of_bridge + error_of_missed;
                drive += bridge;
                supplied = supplied - missed - bridge;
            }
            // Residual of the energy balance of the step.
            quadrature_error +=
                (supplied - copper - air_gap - self.magnetic(x1[0]) + self.magnetic(x0[0])).abs();
            (copper, supplied)
        } else {
            let copper = simpson(r(0) * x0[0] * x0[0], r(1) * xm[0] * xm[0], r(2) * x1[0] * x1[0]) + drop;
            (copper, copper + air_gap)
        };
        Work {
            heat: Temperatures::new(copper + heat, in_core + stator),
            losses: [copper + heat, friction],
            aside: friction - in_core,
            electrical: electrical + heat + load + stator + drive,
            mechanical: mechanical + load,
            ambient: drive,
            quadrature_error,
        }
    }

    #[inline]
    fn bends_where_stiff(&self) -> bool {
        // The contact voltage drop changes sign within milliamperes, which the current crosses in microseconds.
        self.ports().acts.at(EffectPort::TerminalVoltage) || self.loses() || self.coasts()
    }
}

impl<const FORM: u8> Step<'_, FORM> {
    /// The Jacobian of the network, 1/s, with these derivatives of the heat flows, W/K: from winding to core with respect to T_w and to -T_h,
    /// and from either node to its environment.
    #[inline(always)]
    fn network_matrix_of(
        &self,
        [hot, cold]: [f64; 2],
        from_winding: f64,
        from_core: f64,
    ) -> SMatrix<f64, NODES, NODES> {
        let per_joule = self.constants.capacity.inverse;
        Matrix2::new(
            (-hot - from_winding) * per_joule[WINDING],
            cold * per_joule[WINDING],
            hot * per_joule[CORE],
            (-cold - from_core) * per_joule[CORE],
        )
    }
}
