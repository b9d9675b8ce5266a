//! What the air takes from each segment of the housing, by the mode of cooling.
//!
//! The correlations are dear beside a step of a millisecond and change slowly, so their result is kept as plain
//! coefficients ([`Coefficients`]) for one set of [`Conditions`], with their slope over the surface's
//! temperature ([`Tangent`]); between two evaluations the network is linear.
//!
//! segment to room:  q = direct (T - T_a)                                                   (1)
//! passing air:      s = T_t + w (T - T_t),  q_air = take C (s - air),  air' = air + take (s - air)   (2)
//!                   q_segment = w [G (T - s) + take C (s - air)],  q_tube the like with 1 - w
//!
//! (2) is exact for a segment of motor and tube at one temperature each: C the heat capacity of the flow in W/K,
//! G = h A of both walls, w the motor's share of it, take = 1 - exp(-G/C).
//! *Assumes* that tube and motor have the same coefficient; the correlations at the mean surface temperature,
//! air properties at its mean temperature in the gap; ends in still air in every mode.
//! *Source*: (2) Incropera, 7th ed., eq. 8.41; the correlations in `correlations/`.

use super::body::SEGMENTS;
use crate::components::annulus::{FlowDirection, Gap};
use crate::components::conductance::Conductance;
use crate::components::fan::Fan;
use crate::components::housing::StillAir;
use crate::correlations::crossflow;
use crate::effects::Effect;
use crate::media::air::{Air, density};
use crate::models::annulus_cooled_motor::parameters::Parameters;
use crate::models::annulus_cooled_motor::variables::CoolingMode;

/// On what the coefficients depend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Mean temperature of the housing, K.
    pub surface: f64,
    /// Temperature of the tube, K.
    pub tube: f64,
    /// Temperature of the surroundings, K.
    pub ambient: f64,
    /// Pressure of the air, Pa.
    pub pressure: f64,
    /// Command to the fan, 0 to 1.
    pub command: f64,
}

impl Conditions {
    /// Conditions of no evaluation: they differ from all others.
    pub const NONE: Conditions = Conditions {
        surface: f64::NAN,
        tube: f64::NAN,
        ambient: f64::NAN,
        pressure: f64::NAN,
        command: f64::NAN,
    };
}

/// Coefficients of the air, linear in all temperatures.
#[derive(Clone, Copy, Debug)]
pub struct Coefficients {
    /// Conductance from each segment to the room, W/K.
    pub direct: [f64; SEGMENTS],
    /// Conductance of both walls of the gap along each segment, W/K.
    pub films: [f64; SEGMENTS],
    /// The segment's share of it.
    pub share: [f64; SEGMENTS],
    /// How far the passing air comes to the walls' temperature.
    pub take: [f64; SEGMENTS],
    /// Heat capacity of the flow, W/K.
    pub stream: f64,
    /// What the fan's power warms the air by before the gap, K.
    pub inlet_rise: f64,
    /// Radiation from each segment to the tube, W/K.
    pub to_tube: f64,
    /// Conductance from the tube to the room, W/K.
    pub tube_to_room: f64,
    /// Flow over the motor, m3/s.
    pub flow: f64,
    /// Pressure that the fan gives, Pa.
    pub pressure_drop: f64,
    /// Power that the fan gives to the air of the gap, W.
    pub fan_power: f64,
}

impl Coefficients {
    /// No exchange at all.
    pub const NONE: Coefficients = Coefficients {
        direct: [0.0; SEGMENTS],
        films: [0.0; SEGMENTS],
        share: [1.0; SEGMENTS],
        take: [0.0; SEGMENTS],
        stream: 0.0,
        inlet_rise: 0.0,
        to_tube: 0.0,
        tube_to_room: 0.0,
        flow: 0.0,
        pressure_drop: 0.0,
        fan_power: 0.0,
    };

    /// `self + z slope` on the first `n` segments.
    #[inline]
    fn along(&self, slope: &Coefficients, z: f64, n: usize, out: &mut Coefficients) {
        for k in 0..n {
            out.direct[k] = self.direct[k] + z * slope.direct[k];
            out.films[k] = self.films[k] + z * slope.films[k];
            out.share[k] = self.share[k] + z * slope.share[k];
            out.take[k] = self.take[k] + z * slope.take[k];
        }
        out.stream = self.stream + z * slope.stream;
        out.to_tube = self.to_tube + z * slope.to_tube;
        out.tube_to_room = self.tube_to_room + z * slope.tube_to_room;
        out.flow = self.flow + z * slope.flow;
        out.pressure_drop = self.pressure_drop + z * slope.pressure_drop;
        out.fan_power = self.fan_power + z * slope.fan_power;
        // The rise follows from what it is made of, so that the fan's watts stay the fan's watts.
        out.inlet_rise = if out.stream > 0.0 { out.fan_power / out.stream } else { 0.0 };
    }
}

/// Coefficients for one set of conditions, with their slopes.
#[derive(Clone, Copy, Debug)]
pub struct Tangent {
    /// Where they hold.
    pub at: Conditions,
    base: Coefficients,
    /// Over the housing's temperature, per kelvin.
    slope: Coefficients,
    /// Over the fan's command, for all of it; found when the command first moves.
    by_command: Option<Coefficients>,
}

/// Rise of the surface over which a slope is taken, K: 1, so that a difference is a slope.
const RISE: f64 = 1.0;
/// How far temperatures may move before the coefficients are evaluated anew, K. The error of a tangent is of
/// second order: at 40 K above ambient natural convection errs by 4e-6 of itself over this way.
const NEAR: f64 = 0.25;
/// How far the command may move, and over which way its slope is taken, both as a share of it. A flow that grows
/// with a power of the command is off by 1e-4 of itself at the end of this way.
const NEAR_COMMAND: f64 = 0.02;
const BACK: f64 = 0.01;
/// [`NEAR`] where the surface is at ambient and natural convection bends most, K, and what each kelvin above adds.
const NEAR_AT_REST: (f64, f64) = (0.02, 0.02);

impl Tangent {
    /// Coefficients that hold nowhere yet.
    pub const NONE: Tangent = Tangent {
        at: Conditions::NONE,
        base: Coefficients::NONE,
        slope: Coefficients::NONE,
        by_command: None,
    };

    /// The tangent at these conditions.
    pub fn new(cooling: &Cooling, parameters: &Parameters, at: Conditions) -> Tangent {
        let n = cooling.segments;
        let base = cooling.coefficients(parameters, &at);
        let warmer = Conditions { surface: at.surface + RISE, ..at };
        let mut slope = Coefficients::NONE;
        cooling.coefficients(parameters, &warmer).along(&base, -1.0, n, &mut slope);
        Tangent { at, base, slope, by_command: None }
    }

    /// Whether the tangent still serves at `now`.
    #[inline]
    pub fn serves(&self, now: &Conditions) -> bool {
        let at = &self.at;
        (at.command - now.command).abs() <= NEAR_COMMAND * at.command
            && at.pressure == now.pressure
            && self.beyond(now).abs()
                <= NEAR.min(NEAR_AT_REST.0 + NEAR_AT_REST.1 * (at.surface - at.ambient).abs())
            && (at.ambient - now.ambient).abs() <= NEAR
            && (at.tube - now.tube).abs() <= NEAR
    }

    /// How much further the surface is above ambient than where the tangent was taken, K.
    #[inline]
    fn beyond(&self, now: &Conditions) -> f64 {
        (now.surface - now.ambient) - (self.at.surface - self.at.ambient)
    }

    /// The coefficients at `now`, on the segments in use.
    #[inline]
    pub fn coefficients(
        &mut self,
        cooling: &Cooling,
        parameters: &Parameters,
        now: &Conditions,
        out: &mut Coefficients,
    ) {
        let n = cooling.segments;
        self.base.along(&self.slope, self.beyond(now), n, out);
        if now.command != self.at.command {
            // It follows from where the tangent was taken alone, so that it is the same whenever it is found.
            let (base, at) = (&self.base, self.at);
            let by_command = self.by_command.get_or_insert_with(|| {
                let slower = Conditions { command: at.command * (1.0 - BACK), ..at };
                let mut slope = Coefficients::NONE;
                base.along(&cooling.coefficients(parameters, &slower), -1.0, n, &mut slope);
                slope
            });
            let share = (now.command / self.at.command - 1.0) / BACK;
            let kept = *out;
            kept.along(by_command, share, n, out);
        }
    }
}

/// The cooling of one motor: what follows from its parameters alone.
#[derive(Clone, Copy, Debug)]
pub struct Cooling {
    /// Segments of the housing.
    pub segments: usize,
    gap: Option<Gap>,
}

impl Cooling {
    /// The cooling of a motor with a housing of `segments` segments.
    pub fn new(parameters: &Parameters, segments: usize) -> Cooling {
        let p = parameters;
        let gap = |draught| Gap::new(&p.annulus, &p.housing, p.fan.opening(), draught);
        let gap = match p.choices.cooling_mode {
            CoolingMode::AnnulusPush => Some(gap(FlowDirection::Push)),
            CoolingMode::AnnulusPull => Some(gap(FlowDirection::Pull)),
            CoolingMode::Conductance | CoolingMode::Bare | CoolingMode::FanCrossflow => None,
        };
        Cooling { segments, gap }
    }

    /// The coefficients at one set of conditions.
    pub fn coefficients(&self, parameters: &Parameters, at: &Conditions) -> Coefficients {
        let p = parameters;
        let n = self.segments as f64;
        let command = p.effects.fan_flow(at.command);
        let still = p.housing.still_air(at.surface, at.ambient, at.pressure);
        let mut c = Coefficients::NONE;
        let everywhere = self.by_effects(p, at, command) + p.thermal.G_mount;
        let (lateral, end) = (p.housing.lateral_area() / n, p.housing.end_area());
        let free = lateral * (still.lateral + still.radiation);
        match p.choices.cooling_mode {
            CoolingMode::Conductance => {
                c.direct[..self.segments]
                    .fill((p.conductance.at(command) + everywhere - p.thermal.G_mount) / n);
                return c;
            }
            CoolingMode::Bare => c.direct[..self.segments].fill(free),
            CoolingMode::FanCrossflow => self.in_jet(p, at, command, &still, &mut c),
            CoolingMode::AnnulusPush | CoolingMode::AnnulusPull => {
                if let Some(gap) = &self.gap {
                    self.in_gap(p, gap, at, command, free, &mut c);
                }
            }
        }
        for direct in &mut c.direct[..self.segments] {
            *direct += everywhere / n;
        }
        let ends = end * (still.end + still.radiation);
        c.direct[0] += ends;
        c.direct[self.segments - 1] += ends;
        c
    }

    /// Conductance that effects add to the housing, W/K.
    fn by_effects(&self, p: &Parameters, at: &Conditions, command: f64) -> f64 {
        let rise = at.surface - at.ambient;
        let effects = &p.effects;
        let curved = if rise.abs() > 1e-3 {
            effects.housing_to_ambient(at.surface, at.ambient) / rise
        } else {
            effects.housing_to_ambient_slope(at.surface, at.ambient)
        };
        effects.ambient_conductance(Conductance::share(command)).housing + curved
    }

    /// A jet across the motor's middle, still air beyond its edge.
    fn in_jet(&self, p: &Parameters, at: &Conditions, command: f64, still: &StillAir, c: &mut Coefficients) {
        let (housing, fan) = (&p.housing, &p.fan);
        let film = Air::at(0.5 * (at.surface + at.ambient), at.pressure);
        let (jet, flow) = (fan.jet(), fan.flow_max * command.max(0.0));
        let d = housing.diameter;
        let re = film.reynolds(jet.speed(flow, fan.distance), d);
        let forced = (crossflow::cylinder(re, film.pr) - crossflow::NU_AT_REST) * fan.turbulence_factor;
        let mixing = crossflow::Mixing::HorizontalCylinder;
        let blown = crossflow::mixed(forced, still.lateral * d / film.k, mixing) * film.k / d;
        let covered = jet.covered_length(housing.length, fan.distance);
        let (from, to) = (0.5 * (housing.length - covered), 0.5 * (housing.length + covered));
        for (k, share) in self.covered(housing.length, from, to) {
            let convection = share * blown + (1.0 - share) * still.lateral;
            c.direct[k] = housing.lateral_area() / self.segments as f64 * (convection + still.radiation);
        }
        c.flow = flow;
    }

    /// Air through the gap around the motor; segment 1 lies where it enters.
    fn in_gap(
        &self,
        p: &Parameters,
        gap: &Gap,
        at: &Conditions,
        command: f64,
        free: f64,
        c: &mut Coefficients,
    ) {
        let (housing, annulus, fan) = (&p.housing, &p.annulus, &p.fan);
        let draught = match p.choices.cooling_mode {
            CoolingMode::AnnulusPull => FlowDirection::Pull,
            _ => FlowDirection::Push,
        };
        let factor = annulus.factor(draught);
        let (n, rho) = (self.segments, density(at.ambient, at.pressure));
        let (inner, outer) = (housing.lateral_area() * gap.length / housing.length, gap.wall_area);
        // The air's properties hold at its mean temperature, which follows from the flow: twice is enough.
        let (mut mean, mut air) =
            (at.ambient + 0.2 * (at.surface - at.ambient), Air::at(at.ambient, at.pressure));
        let mut mass_flow = 0.0;
        for _ in 0..2 {
            air = Air::at(mean, at.pressure);
            let system = |q: f64| {
                let drop = gap.pressure(rho * q, &air);
                (drop, gap.leak(drop, rho))
            };
            let table = fan.table();
            let flow = table
                .curve()
                .map_or(0.0, |curve| curve.operating_flow_with_leak(command, rho / fan.density_ref, system));
            (c.flow, mass_flow) = (flow, rho * flow);
            c.stream = mass_flow * air.c_p;
            let nu = gap.heated.mean(gap.reynolds(mass_flow, &air), air.pr, gap.length / gap.d_h);
            let g = factor * nu * air.k / gap.d_h * inner;
            let ntu = g / c.stream.max(1e-12);
            mean = at.ambient + (at.surface - at.ambient) * (1.0 - (1.0 - (-ntu).exp()) / ntu);
        }
        c.pressure_drop = gap.pressure(mass_flow, &air);
        if draught == FlowDirection::Push && c.stream > 0.0 {
            c.fan_power = self.warming(fan, command, rho, c, gap);
            c.inlet_rise = c.fan_power / c.stream;
        }
        let re = gap.reynolds(mass_flow, &air);
        let dx = housing.length / n as f64;
        for (k, share) in self.covered(housing.length, 0.0, gap.length) {
            c.direct[k] = (1.0 - share) * free;
            if share <= 0.0 {
                continue;
            }
            let (from, to) = (dx * k as f64, dx * (k as f64 + share));
            let h = factor * gap.heated.between(re, air.pr, from / gap.d_h, to / gap.d_h) * air.k / gap.d_h;
            let part = (to - from) / gap.length;
            c.films[k] = h * (inner + outer) * part;
            c.share[k] = inner / (inner + outer);
            c.take[k] = -(-c.films[k] / c.stream.max(1e-12)).exp_m1();
        }
        // Long concentric cylinders, Incropera, 7th ed., eq. 13.20.
        let resistance =
            1.0 / housing.emissivity.max(1e-9) + inner / outer * (1.0 / annulus.emissivity.max(1e-9) - 1.0);
        let black = crate::correlations::radiation::coefficient(1.0, at.surface, at.tube);
        c.to_tube = black / resistance * inner / n as f64;
        c.tube_to_room = annulus.U_outside * outer;
    }

    /// Power of the fan that warms the air of the gap, W: the gap's share of the fan's flow carries its share.
    fn warming(&self, fan: &Fan, command: f64, rho: f64, c: &Coefficients, gap: &Gap) -> f64 {
        let through = c.flow / (c.flow + gap.leak(c.pressure_drop, rho)).max(1e-12);
        fan.power_at(command.clamp(0.0, 1.0), rho) * through
    }

    /// Each segment with the share of its length between two places.
    fn covered(&self, length: f64, from: f64, to: f64) -> impl Iterator<Item = (usize, f64)> {
        let n = self.segments;
        let dx = length / n as f64;
        (0..n).map(move |k| {
            let x = dx * k as f64;
            (k, ((to.min(x + dx) - from.max(x)) / dx).clamp(0.0, 1.0))
        })
    }
}
