//! The equations in the form of the integrator.

use super::Step;
use super::driven::Followed;
use crate::components::chopper::Cycle;
use crate::models::brushed_gearmotor::nodes::{GEAR, Losses, NODES, Path, Temperatures};
use crate::solver::split::{Fast, HeatCapacities, Segment, System, Work};
use nalgebra::{Matrix2, SMatrix};
use num_dual::Dual64;

/// Relative way of the difference quotient over the resistance: the Jacobian has an error of its square.
const WAY: f64 = 1e-5;
/// Start, midpoint and end of a step.
const INSTANTS: [usize; 3] = [0, 1, 2];

/// Quantities at one instant of a step that several integrals use.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// What follows the drivers of terms.
    pub(super) followed: Followed,
    /// Voltage that opposes the bridge: back-EMF and voltage drop between terminals and winding, V.
    e: f64,
    /// The switching cycle.
    pub(super) cycle: Cycle<f64>,
    /// Drag torque, N.m.
    pub(super) drag: f64,
}

impl System<NODES> for Step<'_> {
    type Instant = Instant;

    #[inline]
    fn instant(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Instant {
        let followed = self.followed(t, x, temperature);
        let e = followed.k * x[1] + followed.lost;
        let drag = self.drag(t, x[1], temperature) + followed.drag;
        Instant { followed, e, cycle: self.cycle(t, e, followed.r), drag }
    }

    #[inline]
    fn fast_rates_at(&self, t: f64, x: &Fast, _: &Temperatures, instant: &Instant) -> Fast {
        let (i, Followed { r, k, .. }) = (x[0], instant.followed);
        let torque = k * i - instant.drag - self.load.at(t);
        Fast::new((instant.cycle.drive - r * i) * self.constants.inverse_l, torque / self.constants.inertia)
    }

    #[inline]
    fn fast_matrix_at(
        &self,
        t: f64,
        x: &Fast,
        temperature: &Temperatures,
        instant: &Instant,
    ) -> Matrix2<f64> {
        let (gear, effects) = (&self.model.gear, &self.model.effects);
        let (i, w, Followed { r, k, .. }) = (x[0], x[1], instant.followed);
        let per_volt = self.cycle(t, Dual64::from(instant.e).derivative(), r).drive.eps;
        let load = self.load.at(t);
        let at = Dual64::from(w).derivative();
        let drag = gear.drag(at, self.nodes().temperature(GEAR, temperature)).eps
            + effects.drag_torque_slope(w)
            + (gear.load_drag(at, load).eps + effects.load_drag_slope(w, load)) * load;
        let (l, j) = (self.constants.inverse_l, 1.0 / self.constants.inertia);
        let by_current = per_volt * effects.terminal_voltage_slope(i) - r;
        let matrix = Matrix2::new(by_current * l, per_volt * k * l, k * j, -drag * j);
        if !self.constants.driven {
            return matrix;
        }
        let [resistance, opposing, torque] = self.driven_slopes(t, x, temperature);
        let drive = |r: f64| self.cycle(t, instant.e, r).drive;
        let per_ohm = (drive(r * (1.0 + WAY)) - drive(r * (1.0 - WAY))) / (2.0 * WAY * r);
        let volts = opposing * per_volt + resistance * (per_ohm - i);
        matrix + Matrix2::new(volts[0] * l, volts[1] * l, torque[0] * j, torque[1] * j)
    }

    #[inline]
    fn network(&self, t: f64, temperature: &Temperatures) -> (Temperatures, f64) {
        let (mut gain, mut to_ambient) = (Temperatures::zeros(), 0.0);
        for path in self.paths(t, temperature) {
            gain[path.from] -= path.flow;
            match path.to {
                Some(node) => gain[node] += path.flow,
                None => to_ambient += path.flow,
            }
        }
        (gain.component_mul(&self.constants.capacity.inverse), to_ambient)
    }

    #[inline]
    fn network_matrix(&self, t: f64, temperature: &Temperatures) -> SMatrix<f64, NODES, NODES> {
        let mut gain = SMatrix::<f64, NODES, NODES>::zeros();
        for Path { from, to, slopes: [grows, falls], .. } in self.paths(t, temperature) {
            gain[(from, from)] -= grows;
            if let Some(node) = to {
                gain[(node, from)] += grows;
                gain[(from, node)] += falls;
                gain[(node, node)] -= falls;
            }
        }
        for (mut row, c) in gain.row_iter_mut().zip(self.constants.capacity.inverse.iter()) {
            row *= *c;
        }
        gain
    }

    #[inline]
    fn capacity(&self) -> &HeatCapacities<NODES> {
        &self.constants.capacity
    }

    #[inline]
    fn heat_rates_at(&self, t: f64, x: &Fast, _: &Temperatures, instant: &Instant) -> Temperatures {
        let (i, w) = (x[0], x[1]);
        let Instant { followed: Followed { r, lost, .. }, cycle, .. } = instant;
        let taken = (instant.e + cycle.drive) * i + r * cycle.ripple;
        let losses = Losses {
            winding: r * (i * i + cycle.ripple) + lost * i,
            friction: instant.drag * w,
            bridge: self.bridge(t).loss(cycle, taken, i),
        };
        self.nodes().heats(&losses).0
    }

    /// Energies of one step, each from its own equation and the integrals of the fast solution, so that the balance residual
    /// is the error of the step.
    #[inline]
    fn work(&self, segment: &Segment<NODES>, instants: &[Instant; 3]) -> Work<NODES> {
        let (t, h) = (segment.t, segment.h);
        let at = [t, t + 0.5 * h, t + h];
        let simpson = |f| segment.simpson(f);
        let against = |f, k| segment.against(f, k);
        let volts = instants.map(|instant| instant.e + instant.cycle.drive);
        let r = instants.map(|instant| instant.followed.r);
        let ripples = INSTANTS.map(|n| r[n] * instants[n].cycle.ripple);
        let ripple = simpson(ripples);
        let supply = INSTANTS.map(|n| self.bridge(at[n]).supply_power(&instants[n].cycle));

        let (friction, error_of_friction) = against(instants.map(|instant| instant.drag), 1);
        let load = segment.against_line(&self.load, 1);
        let (terminals, error_of_terminals) = against(volts, 0);
        // R i^2: the end value of R times the integral of i^2, plus Simpson's rule for the deviation of R from its end value.
        let (drop, error_of_drop) = against(instants.map(|instant| instant.followed.lost), 0);
        let heating = INSTANTS.map(|n| (r[n] - r[2]) * segment.x[n][0] * segment.x[n][0]);
        let copper = r[2] * segment.square + simpson(heating) + drop;
        let error_of_copper = error_of_drop + r[2] * segment.error_of_square;
        let through = INSTANTS.map(|n| supply[n].per_watt * volts[n] + supply[n].per_ampere);
        let (steady, error_of_supply) = against(through, 0);
        let rippling = INSTANTS.map(|n| supply[n].per_watt * ripples[n]);
        let electrical = steady + simpson(rippling);
        let error_of_ripple = (ripple - 0.5 * h * (ripples[0] + ripples[2])).abs();
        let bridge = electrical - terminals - ripple;
        let (heat, ambient) = self.nodes().heats(&Losses { winding: copper + ripple, friction, bridge });
        // Residual of the energy balance of the step.
        let [before, after] = [segment.x[0], segment.x[2]].map(|x| self.kinetic(x[1]) + self.magnetic(x[0]));
        let missing = terminals - copper - friction - load - (after - before);
        Work {
            heat,
            losses: [copper + ripple, friction],
            electrical,
            mechanical: load,
            ambient,
            aside: 0.0,
            quadrature_error: error_of_friction
                + error_of_terminals
                + error_of_copper
                + error_of_supply
                + error_of_ripple
                + missing.abs(),
        }
    }

    #[inline]
    fn bends_where_stiff(&self) -> bool {
        // In discontinuous conduction the switching cycle is nonlinear in speed and current.
        true
    }
}
