//! The equations of the gearmotor, at its output shaft.
//!
//! winding           L dI/dt = V - e - R(T_w) I,   e = K(T_h) w + V_drop(I)                 (1)
//! bridge            V - e = components/chopper.rs (6), in continuous conduction d V_on - (1 - d) V_off - e (2)
//! shaft             J ratio^2 dw/dt = K(T_h) I - tau_drag - tau_load,   K = k_t ratio      (3)
//! copper heat       Q_w = R(T_w) <i^2> + V_drop(I) I,   <i^2> = I^2 + ripple               (4)
//! friction heat     Q_h = tau_drag w                                                       (5)
//! temperatures      components/enclosure.rs (1) to (3)
//!
//! I is the mean over a switching cycle. By (1) it converges with the time constant L/R to the mean of the periodic cycle at
//! the present speed. This is exact in continuous conduction. In discontinuous conduction the true mean settles within the
//! single cycle in which the winding current decays to zero, at most a few L/R. The ripple is that of the periodic cycle. The
//! supply power follows from the motor power (components/chopper.rs), so the energy balance also holds during transients.
//!
//! *Effects* act as in the other models, with these differences: drags act at the output shaft; voltage drops are those at the
//! mean current over the whole cycle; heat from winding or housing to "ambient" (radiation, forced convection, conductance of
//! a term) goes to the box, whose temperature is also the environment of the winding and housing sensors; heat of a term in
//! winding or housing is taken from ambient. `parameters.rs` lists the unsupported ports; their effects are no variables of
//! this model.
//!
//! Over one step every input is linear in time. `solver/split.rs` solves the equations; the crate `reference` solves
//! [`Step::rates`] as the reference.

mod driven;
mod outputs;
mod system;

use super::nodes::{GEAR, Losses, NODES, Network, Path, Temperatures, account};
use super::parameters::Parameters;
use super::variables::Inputs;
use crate::components::chopper::{Bridge, Cycle};
use crate::components::validity::Limits;
use crate::effects::{Acts, EffectPort, Number, PerNode};
use crate::ledger::{Account, Ledger};
use crate::line::Line;
use crate::solver::split::{Fast, HeatCapacities, System};
use crate::terms::MOST_TERMS;
use driven::Followed;
use nalgebra::SVector;
use system::Instant;

/// Number of integrated energies: from the supply, to the load, to ambient, losses in the winding, friction losses.
pub const ENERGIES: usize = 5;
/// State of the integrator.
pub type State = crate::solver::split::State<NODES, ENERGIES>;
/// Stored energies, J: total, magnetic, kinetic.
pub type Stored = SVector<f64, 3>;
/// Number of states of [`Step::rates`]: current, speed, angle, temperatures, energies.
pub const STATES: usize = 3 + NODES + ENERGIES;
/// Number of states of the model: with the lags of terms.
pub const ALL: usize = STATES + MOST_TERMS;

/// Constants of the parameters.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// 1/L, 1/H.
    inverse_l: f64,
    /// Moment of inertia at the output shaft, kg.m2.
    inertia: f64,
    /// Heat capacities of the nodes.
    pub(super) capacity: HeatCapacities<NODES>,
    /// Conductances of the effects from winding and housing to the box, W/K.
    to_box: PerNode,
    /// Ports at which effects act.
    acts: Acts,
    /// Whether any effect gets the present drivers within a step.
    driven: bool,
    /// Limits of validity.
    limits: Limits,
}

impl Constants {
    /// The constants of a gearmotor.
    pub fn of(parameters: &Parameters) -> Constants {
        let (motor, effects) = (&parameters.motor, &parameters.effects);
        let acts = Acts::of(effects);
        let to_box = parameters.effects.ambient_conductance(0.0);
        let capacity =
            Network { thermal: &parameters.thermal, effects: &parameters.effects, to_box }.capacity();
        Constants {
            inverse_l: 1.0 / motor.L,
            inertia: motor.J * parameters.gear.ratio.powi(2),
            capacity: HeatCapacities::new(capacity),
            to_box,
            acts,
            driven: EffectPort::ALL.iter().any(|port| port.is_driven() && acts.at(*port)),
            limits: parameters.limits(),
        }
    }

    /// The same with the heat capacities of winding and housing multiplied by `factor`.
    pub(super) fn with_capacity(self, factor: f64) -> Constants {
        Constants { capacity: self.capacity.scaled(factor), ..self }
    }

    /// The thermal network.
    #[inline]
    pub(super) fn nodes<'a>(&self, parameters: &'a Parameters) -> Network<'a> {
        Network { thermal: &parameters.thermal, effects: &parameters.effects, to_box: self.to_box }
    }

    /// Limits of validity.
    #[inline]
    pub(super) fn limits(&self) -> &Limits {
        &self.limits
    }
}

/// The equations over one step with linear inputs. Times are seconds from the start of the step.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    model: &'a Parameters,
    constants: &'a Constants,
    duty: Line,
    /// Sign of the duty over the whole step; 0 with open switches.
    direction: f64,
    supply: Line,
    load: Line,
    /// True ambient temperature without the effect of terms, K.
    ambient: Line,
    /// What terms add to it, K.
    warmer: f64,
    /// Factor on the torque constant by demagnetisation, 1 without.
    strength: f64,
    /// Time of the start of the step, s.
    time: f64,
    /// State of each term's lag, in the unit of its driver.
    pub(super) lags: [Line; MOST_TERMS],
}

/// Evaluation of the equations at one instant.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The switching cycle.
    pub cycle: Cycle<f64>,
    /// Resistance, Ohm, and torque constant at the output shaft, N.m/A.
    pub constants: [f64; 2],
    /// Mean voltages, V: across resistance and contacts, across the inductance, back-EMF.
    pub voltages: [f64; 3],
    /// Powers into winding, magnetic field and air gap, W.
    pub powers: [f64; 3],
    /// Power from the supply, W.
    pub supply_power: f64,
    /// Power loss of the bridge, W.
    pub loss_drive: f64,
    /// Drag torque, N.m.
    pub drag: f64,
    /// Derivatives of current and speed.
    pub fast: Fast,
    /// Derivatives of the temperatures, K/s.
    pub warming: Temperatures,
    /// Heat flow to ambient, W: along the paths, and from losses that heat no node.
    pub to_ambient: f64,
    /// The energy balance.
    pub ledger: Ledger,
}

impl<'a> Step<'a> {
    /// The equations of a gearmotor with inputs that are linear from `time` on. They hold until the next event of the
    /// effects, and until the duty changes its sign ([`Step::turns`]).
    #[inline]
    pub fn new(
        model: &'a Parameters,
        constants: &'a Constants,
        inputs: &Inputs,
        slopes: &Inputs,
        time: f64,
    ) -> Self {
        let (u, s) = (inputs, slopes);
        let sign = |x: f64| if x == 0.0 { 0.0 } else { x.signum() };
        let drift = model.effects.ambient_sensor();
        Step {
            model,
            constants,
            duty: Line { start: u.duty, slope: s.duty },
            direction: if u.duty == 0.0 { sign(s.duty) } else { sign(u.duty) },
            supply: Line { start: u.supply_voltage, slope: s.supply_voltage },
            load: Line { start: u.load_torque, slope: s.load_torque },
            ambient: Line {
                start: u.ambient_temperature + drift * time,
                slope: s.ambient_temperature + drift,
            },
            warmer: model.effects.ambient_offset(),
            strength: model.effects.torque_constant(time),
            time,
            lags: [Line::default(); MOST_TERMS],
        }
    }

    /// The same equations with this bridge direction and the magnetisation since the last event at `since`, s.
    pub fn with_events(mut self, direction: f64, since: f64) -> Self {
        (self.direction, self.strength) = (direction, self.model.effects.torque_constant(since));
        self
    }

    /// Seconds from the start of a step until a linear duty passes through zero; infinite if it does not.
    pub fn turns(duty: f64, slope: f64) -> f64 {
        if duty * slope < 0.0 { -duty / slope } else { f64::INFINITY }
    }

    /// The thermal network.
    #[inline]
    fn nodes(&self) -> Network<'a> {
        self.constants.nodes(self.model)
    }

    #[inline]
    fn bridge(&self, t: f64) -> Bridge {
        Bridge::new(&self.model.drive, self.duty.at(t), self.direction, self.supply.at(t))
    }

    /// The switching cycle at the back-EMF `e`, V, including the voltage drop between terminals and winding, and the resistance `r`, Ohm.
    #[inline]
    fn cycle<D: Number>(&self, t: f64, e: D, r: f64) -> Cycle<D> {
        self.bridge(t).cycle(e, r, self.model.motor.L)
    }

    /// The heat paths, `t` seconds after the start of the step.
    #[inline(always)]
    fn paths(&self, t: f64, temperature: &Temperatures) -> impl IntoIterator<Item = Path> + use<> {
        self.nodes().paths(self.ambient.at(t) + self.warmer, temperature)
    }

    /// Drag torque at the output shaft without that of terms, N.m.
    #[inline]
    fn drag(&self, t: f64, w: f64, temperature: &Temperatures) -> f64 {
        let (gear, effects, load) = (&self.model.gear, &self.model.effects, self.load.at(t));
        let own = gear.drag(w, self.nodes().temperature(GEAR, temperature)) + effects.drag_torque(w);
        own + (gear.load_drag(w, load) + effects.load_drag(w, load)) * load
    }

    /// Stored energy, J: magnetic, kinetic, and heat above the temperature `origin`, K.
    pub fn stored(&self, state: &State, origin: f64) -> f64 {
        let (i, w) = (state.x[0], state.x[1]);
        self.magnetic(i) + self.kinetic(w) + self.constants.capacity.heat(&state.temperature, origin)
    }

    fn magnetic(&self, i: f64) -> f64 {
        0.5 * self.model.motor.L * i * i
    }

    fn kinetic(&self, w: f64) -> f64 {
        0.5 * self.constants.inertia * w * w
    }

    /// Evaluates the equations at one instant.
    pub fn point(&self, t: f64, x: &Fast, temperature: &Temperatures) -> Point {
        use Account::*;
        let (i, w) = (x[0], x[1]);
        let Instant { followed: Followed { r, k, lost, .. }, cycle, drag, .. } =
            self.instant(t, x, temperature);
        let fast = self.fast_rates(t, x, temperature);
        let voltages = [r * i + lost, self.model.motor.L * fast[0], k * w];
        let powers = [voltages[0] * i + r * cycle.ripple, voltages[1] * i, voltages[2] * i];
        // The bridge depends only on the terminals: mean voltage, mean current, and ripple loss.
        let taken = (k * w + lost + cycle.drive) * i + r * cycle.ripple;
        let bridge = self.bridge(t);
        let supply = bridge.supply_power(&cycle);
        let loss_drive = bridge.loss(&cycle, taken, i);
        let enter = |ledger: &mut Ledger, from, losses: Losses| {
            let (nodes, rest) = self.nodes().heats(&losses);
            ledger.transfer(from, Ambient, rest);
            nodes.iter().enumerate().for_each(|(node, heat)| ledger.transfer(from, Node(node), *heat));
            rest
        };
        let mut ledger = Ledger::default();
        let electrical = Losses { winding: powers[0], bridge: loss_drive, friction: 0.0 };
        let mut to_ambient = enter(&mut ledger, Terminals, electrical);
        ledger.transfer(Terminals, Magnetic, powers[1]);
        ledger.transfer(Terminals, AirGap, powers[2]);
        to_ambient += enter(&mut ledger, AirGap, Losses { friction: drag * w, ..Losses::default() });
        ledger.transfer(AirGap, Shaft, self.load.at(t) * w);
        ledger.transfer(AirGap, Kinetic, self.constants.inertia * w * fast[1]);
        for path in self.paths(t, temperature) {
            ledger.transfer(Node(path.from), account(path.to), path.flow);
            to_ambient += if path.to.is_none() { path.flow } else { 0.0 };
        }

        Point {
            cycle,
            constants: [r, k],
            voltages,
            powers,
            supply_power: supply.per_watt * taken + supply.per_ampere * i,
            loss_drive,
            drag,
            fast,
            warming: self.network_rates(t, temperature)
                + self.heat_rates(t, x, temperature).component_mul(&self.capacity().inverse),
            to_ambient,
            ledger,
        }
    }

    /// Derivatives of all states, for an integrator without operator splitting.
    ///
    /// `y` holds current, A, speed, rad/s, angle, rad, the temperatures of the nodes, K, and the
    /// energies from the supply, to the load, to ambient, and the losses in winding and housing, J.
    pub fn rates(&self, t: f64, y: &[f64; STATES]) -> [f64; STATES] {
        let x = Fast::new(y[0], y[1]);
        let p = self.point(t, &x, &Temperatures::from_column_slice(&y[3..3 + NODES]));
        let energies = [p.supply_power, self.load.at(t) * y[1], p.to_ambient, p.powers[0], p.drag * y[1]];
        let all = p.fast.iter().copied().chain([y[1]]).chain(p.warming.iter().copied()).chain(energies);
        let mut rates = [0.0; STATES];
        rates.iter_mut().zip(all).for_each(|(rate, value)| *rate = value);
        rates
    }
}
