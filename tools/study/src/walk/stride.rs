//! Motor, actuator and gait coupled natively, as a master couples their FMUs: Jacobi steps of 1 ms, inputs extrapolated
//! linearly from their last two values.

use super::motor_state::{add_slopes, put_temperatures, temperatures};
use super::periodic::Periodic;
use super::walker::period;
use crate::StudyError;
use crate::bench::Bench;
use physics::model::{Model, Slot};

/// Longest step, s.
const STEP: f64 = 1e-3;
/// Instants of a stride at which the derivatives are evaluated.
const INSTANTS: u32 = 16;
/// From the motor to the actuator, after the motor has its inputs.
const POWER: (usize, &str, &str) = (MOTOR, "power_electrical", "motor_power");
/// From the actuator to the motor.
const LOAD: (usize, &str, &str) = (ACTUATOR, "load_torque", "load_torque");
/// From the gait, and from the motor, to the actuator.
const TO_ACTUATOR: [(usize, &str, &str); 6] = [
    (GAIT, "joint_angle", "joint_angle"),
    (GAIT, "joint_speed", "joint_speed"),
    (GAIT, "torque_demand", "torque_demand"),
    (MOTOR, "shaft_angle", "motor_angle"),
    (MOTOR, "shaft_speed", "motor_speed"),
    (MOTOR, "current", "motor_current"),
];
const MOTOR: usize = 0;
const ACTUATOR: usize = 1;
const GAIT: usize = 2;
/// Drive modes that follow an actuator, with its output and the motor's input.
const DRIVES: [(f64, &str, &str); 2] =
    [(1.0, "voltage", "voltage"), (3.0, "current_command", "current_command")];

/// Whether an input of one of the models follows the others.
pub(super) fn is_given(place: usize, name: &str, motor: &Bench) -> bool {
    let mode = motor.clone().get("drive_mode").unwrap_or_default();
    match place {
        MOTOR => name == LOAD.2 || DRIVES.iter().any(|drive| drive.0 == mode && drive.2 == name),
        ACTUATOR => TO_ACTUATOR.iter().chain([&POWER]).any(|link| link.2 == name),
        _ => false,
    }
}

/// An output that an input follows.
#[derive(Clone, Copy, Debug)]
struct Link {
    from: (usize, Slot),
    to: (usize, Slot),
    last: Option<f64>,
}

/// Slots that are read at every step.
#[derive(Clone, Copy, Debug)]
struct Read {
    winding: Slot,
    current: Slot,
    joint_torque: Slot,
    torque_error: Slot,
    /// Energies since the start, J: of the motor's terminals, at the joint, from the supply.
    energy: [(usize, Slot); 3],
}

/// Whether the step is one of the [`INSTANTS`] that are spread over a stride of so many steps.
fn is_looked_at(step: u32, steps: u32) -> bool {
    step * INSTANTS % steps < INSTANTS
}

/// The three coupled models.
pub struct Coupled {
    models: [Box<dyn Model>; 3],
    links: Vec<Link>,
    read: Read,
    /// Steps a stride, and their length, s.
    steps: u32,
    h: f64,
    done: u64,
    /// Number of states of the motor before its temperatures.
    first_temperature: usize,
}

period!(Coupled);

impl Clone for Coupled {
    fn clone(&self) -> Self {
        let models = std::array::from_fn(|k| self.models[k].boxed_clone());
        Coupled { models, links: self.links.clone(), ..*self }
    }
}

impl Coupled {
    /// Starts the three models, the actuator with the gait's demand.
    pub(super) fn start(motor: Bench, actuator: Bench, gait: Bench) -> Result<Coupled, StudyError> {
        let slot = |bench: &Bench, name: &str| Ok::<Slot, StudyError>(bench.entry(name)?.slot);
        let benches = [&motor, &actuator, &gait];
        let mode = motor.clone().get("drive_mode")?;
        let drive = DRIVES.iter().find(|d| d.0 == mode).ok_or_else(|| {
            StudyError::new("drive_mode must be voltage or current: these follow the actuator")
        })?;
        if gait.clone().get("gait.variation")? != 0.0 {
            return Err(StudyError::new(
                "gait.variation must be 0: varying strides have no periodic steady state",
            ));
        }
        let to_motor = [(ACTUATOR, drive.1, drive.2), LOAD];
        let link = |to: usize, &(from, output, input): &(usize, &str, &str)| {
            Ok(Link {
                from: (from, slot(benches[from], output)?),
                to: (to, slot(benches[to], input)?),
                last: None,
            })
        };
        let links: Vec<Link> = (TO_ACTUATOR.iter().map(|l| link(ACTUATOR, l)))
            .chain(to_motor.iter().map(|l| link(MOTOR, l)))
            // Last: the motor's power follows from its inputs.
            .chain(std::iter::once(link(ACTUATOR, &POWER)))
            .collect::<Result<_, StudyError>>()?;
        let read = Read {
            winding: slot(&motor, "winding_temperature")?,
            current: slot(&motor, "current")?,
            joint_torque: slot(&actuator, "joint_torque")?,
            torque_error: slot(&actuator, "torque_error")?,
            energy: [
                (MOTOR, slot(&motor, "energy_electrical")?),
                (ACTUATOR, slot(&actuator, "energy_joint")?),
                (ACTUATOR, slot(&actuator, "energy_supply")?),
            ],
        };
        let rate = slot(&gait, "der(state.stride)")?;
        let models = [motor, actuator, gait].map(Bench::into_model);
        let first_temperature = if drive.1 == "voltage" { 2 } else { 1 };
        let mut walker = Coupled { models, links, read, steps: 1, h: STEP, done: 0, first_temperature };
        for k in [GAIT, MOTOR, ACTUATOR] {
            walker.models[k].start(0.0).map_err(|fault| StudyError::new(fault.to_string()))?;
            walker.pass(k);
        }
        let stride = 1.0 / walker.models[GAIT].get(rate);
        walker.steps = (stride / STEP - 1e-9).ceil() as u32;
        walker.h = stride / f64::from(walker.steps);
        Ok(walker)
    }

    /// Time of a stride, s.
    pub fn stride_time(&self) -> f64 {
        f64::from(self.steps) * self.h
    }

    /// Copies the outputs of `from` to the connected inputs.
    fn pass(&mut self, from: usize) {
        for link in self.links.iter().filter(|l| l.from.0 == from) {
            let value = self.models[from].get(link.from.1);
            self.models[link.to.0].set(link.to.1, value);
        }
    }

    /// Copies every output to its input, with its slope.
    fn exchange(&mut self) {
        for link in &mut self.links {
            let value = self.models[link.from.0].get(link.from.1);
            self.models[link.to.0].set(link.to.1, value);
            if let Some(last) = link.last {
                self.models[link.to.0].set_slope(link.to.1, (value - last) / self.h);
            }
            link.last = Some(value);
        }
    }

    /// After the motor's step: its power at the end of the step is known and does not affect the step.
    fn interpolate_power(&mut self) {
        if let Some(Link { from, to, last: Some(last) }) = self.links.last().copied() {
            let slope = (self.models[from.0].get(from.1) - last) / self.h;
            self.models[to.0].set_slope(to.1, slope);
        }
    }

    /// Walks a stride.
    ///
    /// # Errors
    /// Equations that have no solution.
    pub fn stride(&mut self) -> Result<Periodic, StudyError> {
        self.steps_of_a_stride(|_, _| ())
    }

    fn steps_of_a_stride(&mut self, mut look: impl FnMut(&Coupled, u32)) -> Result<Periodic, StudyError> {
        let mut s = Periodic { winding_temperature: f64::NEG_INFINITY, ..Periodic::default() };
        let before = self.energies();
        for step in 0..self.steps {
            look(self, step);
            self.exchange();
            let t = self.done as f64 * self.h;
            for k in [MOTOR, ACTUATOR, GAIT] {
                if k == ACTUATOR {
                    self.interpolate_power();
                }
                let model = &mut self.models[k];
                model.step(t, self.h).map_err(|fault| StudyError::of_step(&**model, &fault))?;
            }
            self.done += 1;
            let [motor, actuator, _] = &mut self.models;
            let (winding, current) = (motor.get(self.read.winding), motor.get(self.read.current));
            s.winding_temperature = s.winding_temperature.max(winding);
            s.winding_temperature_mean += winding;
            s.current_rms += current * current;
            s.current_peak = s.current_peak.max(current.abs());
            s.joint_torque_peak = s.joint_torque_peak.max(actuator.get(self.read.joint_torque).abs());
            s.torque_error_rms += actuator.get(self.read.torque_error).powi(2);
        }
        let n = f64::from(self.steps);
        s.winding_temperature_mean /= n;
        s.current_rms = (s.current_rms / n).sqrt();
        s.torque_error_rms = (s.torque_error_rms / n).sqrt();
        let (after, time) = (self.energies(), self.stride_time());
        [s.power_electrical, s.power_joint, s.power_supply] =
            std::array::from_fn(|k| (after[k] - before[k]) / time);
        Ok(s)
    }

    /// Energies since the start, J.
    fn energies(&mut self) -> [f64; 3] {
        self.read.energy.map(|(model, slot)| self.models[model].get(slot))
    }

    /// The temperatures that the motor's heat depends on, K.
    pub(super) fn temperatures(&self) -> Vec<f64> {
        temperatures(self.models[MOTOR].as_ref(), self.first_temperature)
    }

    /// Sets them; current and motion stay.
    pub(super) fn put_temperatures(&mut self, values: &[f64]) {
        put_temperatures(self.models[MOTOR].as_mut(), self.first_temperature, values);
    }

    /// Walks a stride and evaluates at several instants the derivatives of the temperatures' rates with respect to the
    /// temperatures: their means, 1/s, a row for each rate.
    ///
    /// # Errors
    /// Equations that have no solution.
    pub fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
        let n = self.temperatures().len();
        let mut slopes = vec![vec![0.0; n]; n];
        let stride = self.steps_of_a_stride(|walker, step| {
            if is_looked_at(step, walker.steps) {
                let share = 1.0 / f64::from(INSTANTS);
                add_slopes(walker.models[MOTOR].as_ref(), walker.first_temperature, &mut slopes, share);
            }
        })?;
        Ok((stride, slopes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The shares of a mean add up to one, whatever the stride: as many looks as there are instants, as far apart as may be.
    #[test]
    fn a_stride_is_looked_at_as_often_as_its_mean_counts() {
        for steps in [810u32, 970, 1110, 1120, 1123, 1124, 1380, 1580] {
            let looks: Vec<u32> = (0..steps).filter(|&step| is_looked_at(step, steps)).collect();
            assert_eq!(looks.len() as u32, INSTANTS, "{steps}");
            let ends = looks.iter().skip(1).chain(std::iter::once(&steps));
            let apart = looks.iter().zip(ends).map(|(a, b)| b - a);
            assert!(apart.into_iter().all(|d| d.abs_diff(steps / INSTANTS) <= 1), "{steps} {looks:?}");
        }
    }
}
