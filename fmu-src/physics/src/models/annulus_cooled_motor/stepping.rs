//! A communication step.
//!
//! Without a network it is one call to the integrator. With a network it is divided into substeps: in the equations of winding
//! and stator, rotor and housing temperatures are linear in time; the network then receives their heat. A substep with too
//! large an error is rejected and shortened. For communication steps of milliseconds one substep is enough.

use super::cooling::Conditions;
use super::equations::{ALL, NODES, PLAIN, PLAIN_ALONE, PLAIN_STILL, Step, ThermalCoupling};
use super::motor::AnnulusCooledMotor;
use super::network::{CouplingIntegrals, Network};
use super::parameters::Parameters;
use crate::components::commutation::{Commutation, PHASES, Phases};
use crate::components::conductance::Conductance;
use crate::components::validity::Extremes;
use crate::effects::PerNode;
use crate::line::Line;
use crate::model::Fault;
use crate::runtime::Halt;
use crate::solver::split::{State, StepFailure};
use crate::solver::stabilized::States;
use crate::solver::{Cause, MOST_STEPS, no_solution};
use declare::Group;

/// A step fails if a rejected substep would have to be shorter than this fraction of it.
const LEAST_SHARE: f64 = 1e-9;
/// Largest change of the ambient temperature within a substep, K; the cooling has its midpoint value.
const MOVE: f64 = 0.25;

/// The motor before a step that may be undone. The network is apart, so that it is copied without an allocation.
pub struct Checkpoint {
    motor: AnnulusCooledMotor,
    network: Option<Network>,
}

impl AnnulusCooledMotor {
    /// The present state, for [`Self::return_to`].
    pub(super) fn checkpoint(&mut self) -> Checkpoint {
        let network = self.own.network.take();
        let kept = Checkpoint { motor: self.clone(), network: network.as_deref().map(Network::bare) };
        self.own.network = network;
        kept
    }

    /// Undoes what happened since. A step neither creates nor removes a network.
    pub(super) fn return_to(&mut self, before: Checkpoint) {
        let mut network = self.own.network.take();
        *self = before.motor;
        if let (Some(network), Some(before)) = (&mut network, before.network) {
            network.return_to(&self.parameters, before);
        }
        self.own.network = network;
    }

    /// A step with the drivers already set.
    #[inline]
    pub(super) fn take_substeps(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        if self.own.network.is_some() {
            self.advance_in_pieces(time, h)
        } else if self.own.constants.are_plain(&self.slopes) {
            if self.is_sloping() || self.own.constants.drift() != 0.0 {
                self.advance_two_nodes::<PLAIN_ALONE>(time, h)
            } else {
                self.advance_two_nodes::<PLAIN_STILL>(time, h)
            }
        } else {
            self.advance_two_nodes::<ALL>(time, h)
        }
    }

    fn advance_two_nodes<const FORM: u8>(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        self.follow_cooling();
        let excess = self.mean_excess(h);
        let inputs = [&self.inputs, &self.slopes];
        let mut step = Step::<FORM>::of(&self.parameters, &self.own.constants, inputs, self.own.fan.1, time);
        step.excess = excess;
        if FORM == ALL {
            step.lags = self.own.terms.lags_after(time);
        }
        let (before, sensed) = (self.own.state, self.sensed());
        let next = &mut self.own.state;
        if let Err(failure) = self.own.split.advance(&step, next, h) {
            *next = before;
            return Err(self.no_solution(time, &failure).into());
        }
        let phases = self.own.phases.over(&step, [&before, next], h, &self.parameters);
        let [winding, core] = [next.temperature[0], next.temperature[1]];
        let extremes =
            Extremes { winding: winding + phases.hottest(), magnets: core, lowest: winding.min(core) };
        if self.own.constants.limits().are_passed(&extremes) {
            *next = before;
            return Err(Halt::Limit);
        }
        self.own.phases = phases;
        self.follow_sensors(sensed, h);
        self.arrive(time + h, h);
        Ok(())
    }

    fn no_solution(&self, time: f64, failure: &StepFailure) -> Fault {
        let state = &self.own.state;
        no_solution("motor", time, failure, [state.x[0], state.x[1], state.temperature[0]])
    }

    fn advance_in_pieces(&mut self, time: f64, h: f64) -> Result<(), Halt> {
        let longest = h.min(self.longest_piece());
        let mut trial = self.own.network.as_ref().map_or(h, |n| n.substep).min(longest);
        if trial >= h {
            // The common case needs no copy: a rejected substep changes nothing.
            match self.substep(time, h)? {
                Ok(()) => return Ok(()),
                Err(shorter) => trial = shorter,
            }
        }
        let before = self.checkpoint();
        let (mut done, mut tried) = (0.0, 0);
        while done < h {
            let rest = h - done;
            let substep = if trial >= rest * (1.0 - 1e-9) { rest } else { trial.min(0.5 * rest) };
            tried += 1;
            match self.substep(time + done, substep) {
                Ok(Ok(())) => {
                    done += substep;
                    trial = self.own.network.as_ref().map_or(h, |n| n.substep).min(longest);
                    if substep == rest {
                        break;
                    }
                }
                Ok(Err(shorter)) if shorter < LEAST_SHARE * h || tried >= MOST_STEPS => {
                    let cause = if tried >= MOST_STEPS { Cause::Steps } else { Cause::Inaccurate };
                    let fault = self.no_solution(time, &StepFailure { t: done, h: shorter, cause });
                    self.return_to(before);
                    return Err(fault.into());
                }
                Ok(Err(shorter)) => trial = shorter,
                Err(halt) => {
                    self.return_to(before);
                    return Err(halt);
                }
            }
        }
        self.time = time + h;
        Ok(())
    }

    /// Longest substep over which the cooling inputs may be constant at their midpoint values, s.
    fn longest_piece(&self) -> f64 {
        let inputs = Conditions::longest_substep(&self.inputs, &self.slopes);
        inputs.min(MOVE / self.slopes.ambient_temperature.abs())
    }

    /// One substep. `Ok(Err(h))` if it must be shortened to `h` seconds; the state is then unchanged.
    fn substep(&mut self, time: f64, h: f64) -> Result<Result<(), f64>, Halt> {
        match self.own.constants.are_plain(&self.slopes) {
            true => self.substep_of::<PLAIN>(time, h),
            false => self.substep_of::<ALL>(time, h),
        }
    }

    /// The same with the plain equations or all of them.
    fn substep_of<const FORM: u8>(&mut self, time: f64, h: f64) -> Result<Result<(), f64>, Halt> {
        let (ambient, sensed) = (self.ambient(time), self.sensed());
        let still = !self.is_sloping();
        let middle = if still { self.inputs } else { self.inputs.after(0.5 * h, &self.slopes) };
        let (excess, lags) = (self.mean_excess(h), self.own.terms.lags_after(time));
        let Some(network) = &mut self.own.network else { return Ok(Ok(())) };
        let at_middle = ambient.at(0.5 * h);
        network.refresh(&self.parameters, &middle, at_middle, [0.0; 2]);

        // Friction heat in the network at the start of the substep.
        let (state, split) = (self.own.state, &mut self.own.split);
        let (t_w, t_core) = (state.temperature[0], state.temperature[1]);
        let (p, constants) = (&self.parameters, &self.own.constants);
        let fan_conductance = fan_conductance(p, middle.fan_command);
        let start = coupling(network, fan_conductance, ambient, None);
        let none = PerNode::default();
        let mut step = Step::<FORM>::of(p, constants, [&self.inputs, &self.slopes], none, time);
        step.excess = excess;
        step.lags = lags;
        step.couple(start);
        let friction = step.drag_beyond(&state.x, &state.temperature);
        let inflow = network.inflow(t_w, t_core, friction);
        let mut rates = network.rates_now(ambient.start, &inflow);
        let ahead = network.ahead(&rates, h);
        if ahead.iter().any(|change| change.abs() > 1e-4) {
            network.refresh(p, &middle, at_middle, ahead);
            network.put_rates(ambient.start, &inflow, &mut rates);
        }

        step.couple(coupling(network, fan_conductance, ambient, Some(&rates)));
        let mut next = state;
        if let Err(failure) = split.advance(&step, &mut next, h) {
            return Err(self.no_solution(time, &failure).into());
        }
        let integrals = next.integrals;
        let coupling_integrals = CouplingIntegrals {
            winding: integrals.temperature[0],
            stator: integrals.temperature[1],
            friction: integrals.aside,
        };
        let advance = network.advance(h, (&rates, &inflow), &coupling_integrals, ambient);
        if advance.error > 1.0 || advance.error.is_nan() {
            split.rejected += 1;
            let shrink = 0.8 / advance.error.cbrt();
            return Ok(Err(h * if shrink.is_finite() { shrink.clamp(0.1, 0.7) } else { 0.1 }));
        }
        let phases = self.own.phases.over(&step, [&state, &next], h, p);
        let (winding, magnets) = (next.temperature[0], network.rotor_ahead());
        let extremes =
            Extremes { winding: winding + phases.hottest(), magnets, lowest: winding.min(magnets) };
        if constants.limits().are_passed(&extremes) {
            return Err(Halt::Limit);
        }
        network.accept();
        network.substep = if advance.error < 0.008 {
            // A short communication step says nothing against a long substep.
            network.substep.max(4.0 * h)
        } else {
            h * (0.8 / advance.error.cbrt()).min(4.0)
        };
        next.energy[2] += advance.to_ambient - advance.left;
        (self.own.state, self.own.phases) = (next, phases);
        self.follow_sensors(sensed, h);
        self.arrive(time + h, h);
        Ok(Ok(()))
    }

    /// Electrical angle of a state, rad.
    pub(super) fn electrical_angle(&self, state: &State<NODES>) -> f64 {
        state.angle * f64::from(self.parameters.motor.pole_pairs)
    }

    /// Temperature of the conducting phases above the mean winding temperature, K.
    #[inline]
    pub(super) fn excess(&self) -> f64 {
        let commutation = self.parameters.choices.commutation;
        if commutation == Commutation::EquivalentDc {
            return 0.0;
        }
        self.own.phases.in_use(&self.shares_now())
    }

    /// Distribution of the copper loss over the phases now; constant between events within one sector of block commutation.
    fn shares_now(&self) -> [f64; PHASES] {
        let commutation = self.parameters.choices.commutation;
        let angle = match &self.pre {
            Some(pre) if commutation == Commutation::Block => pre.discrete.angle(),
            _ => self.electrical_angle(&self.own.state),
        };
        commutation.shares(angle, angle)
    }

    /// Derivatives of the phase temperatures relative to the mean winding temperature with these equations, K/s.
    pub(super) fn phase_rates(&self, step: &Step) -> [f64; PHASES] {
        self.own.phases.rates(&step.phase_load(0.0, &self.own.state), &self.shares_now())
    }

    /// Temperature of the conducting phases above the mean winding temperature at the midpoint of the next `h` seconds, K. With
    /// this value over the whole step, the resistance is of second order in the step.
    #[inline]
    fn mean_excess(&self, h: f64) -> f64 {
        match self.parameters.choices.commutation {
            Commutation::EquivalentDc => 0.0,
            commutation => self.mean_excess_of_phases(commutation, h),
        }
    }

    /// The same with three phases.
    #[inline(never)]
    fn mean_excess_of_phases(&self, commutation: Commutation, h: f64) -> f64 {
        let load = self.equations().phase_load(0.0, &self.own.state);
        let (a, way) = (
            self.electrical_angle(&self.own.state),
            h * self.own.state.x[1] * f64::from(self.parameters.motor.pole_pairs),
        );
        let middle = self.own.phases.after(0.5 * h, &load, &commutation.shares(a, a + 0.5 * way));
        middle.in_use(&commutation.shares(a, a + way))
    }

    /// True ambient temperature over a substep that starts at `time`, K.
    pub(super) fn ambient(&self, time: f64) -> Line {
        self.ambient_of(&self.parameters, time)
    }

    /// The same with other parameters.
    #[inline]
    pub(super) fn ambient_of(&self, parameters: &Parameters, time: f64) -> Line {
        let drift = self.own.constants.drift();
        Line {
            start: self.inputs.ambient_temperature + drift * time + parameters.effects.ambient_offset(),
            slope: self.slopes.ambient_temperature + drift,
        }
    }

    /// Updates the coefficients of the network to the present inputs. Not inlined in steps without a network.
    #[inline(never)]
    pub(super) fn bring_network_to_inputs(&mut self) {
        let ambient = self.ambient(self.time).start;
        let Some(network) = &mut self.own.network else { return };
        if self.pre.is_some() {
            network.evaluate(&self.parameters, &self.inputs, ambient);
        } else {
            network.refresh(&self.parameters, &self.inputs, ambient, [0.0; 2]);
        }
    }

    /// Thermal coupling of winding and core to a network at the present time.
    pub(super) fn coupling(&self, parameters: &Parameters, network: &Network) -> ThermalCoupling {
        let fan_conductance = fan_conductance(parameters, self.inputs.fan_command);
        coupling(network, fan_conductance, self.ambient_of(parameters, self.time), None)
    }
}

impl Phases {
    /// The phases after the first `h` seconds of a step between two states.
    #[inline]
    fn over<const FORM: u8>(
        &self,
        step: &Step<FORM>,
        [from, to]: [&State<NODES>; 2],
        h: f64,
        parameters: &Parameters,
    ) -> Phases {
        let commutation = parameters.choices.commutation;
        if commutation == Commutation::EquivalentDc {
            return *self;
        }
        let load = step.phase_load(0.0, from).middle(&step.phase_load(h, to));
        let pairs = f64::from(parameters.motor.pole_pairs);
        self.after(h, &load, &commutation.shares(from.angle * pairs, to.angle * pairs))
    }
}

/// Conductances to ambient that effects add, W/K.
fn fan_conductance(parameters: &Parameters, command: f64) -> PerNode {
    let effects = &parameters.effects;
    effects.ambient_conductance(Conductance::share(effects.fan_flow(command)))
}

/// Thermal coupling of winding and core to a network.
fn coupling(
    network: &Network,
    fan_conductance: PerNode,
    ambient: Line,
    rates: Option<&States>,
) -> ThermalCoupling {
    let body = &network.body;
    let line = |start: f64, rate: fn(&Network, &States) -> f64| Line {
        start,
        slope: rates.map_or(0.0, |rates| rate(network, rates)),
    };
    let rotor = line(network.rotor_temperature(), Network::rotor_rate);
    let core = line(network.housing_temperature(), Network::housing_rate);
    let (to_rotor, to_ambient) = (body.winding_to_rotor, body.leads + fan_conductance.winding);
    let sum = to_rotor + to_ambient;
    let share = if sum > 0.0 { to_rotor / sum } else { 0.0 };
    let mix = |a: f64, b: f64| share * a + (1.0 - share) * b;
    ThermalCoupling {
        conductance: PerNode { winding: sum, housing: body.from_stator * body.segments as f64 },
        winding: Line { start: mix(rotor.start, ambient.start), slope: mix(rotor.slope, ambient.slope) },
        core,
        rotor,
    }
}
