//! A motor under a cycle of torque and speed behind a rigid gear: the speed is imposed, the current is what the torque needs.
//!
//! i = (tau + (J + J_load) dw/dt + tau_drag) / k_t, with torque constant and drag of the model at the middle of the step        (1)
//! torque on the motor   tau = tau_out / (ratio eta) where power leaves the motor, tau_out eta / ratio where it comes back      (2)

use super::cycle_file::{Cycle, Drive};
use super::motor_state::{add_slopes, put_temperatures, temperatures};
use super::periodic::Periodic;
use super::walker::period;
use crate::StudyError;
use crate::bench::Bench;
use crate::reproduce::significant;
use physics::model::{Model, Slot};
use std::sync::Arc;

/// Longest step, s, and the numbers of steps of a cycle that are used at least and at most.
const STEP: f64 = 1e-3;
const STEPS: (f64, f64) = (64.0, 20_000.0);
/// Instants of a cycle at which the derivatives are evaluated.
const INSTANTS: u32 = 16;
/// Evaluations of the drag, which may depend on the torque.
const DRAG_EVALUATIONS: usize = 2;
/// Number of states before the temperatures: current and speed are imposed.
const FIRST: usize = 0;

/// What a cycle sets on its motor.
pub(super) const GIVEN: [&str; 4] = ["drive_mode", "mechanical_mode", "imposed_speed", "current_command"];

/// Sets the modes of a motor under a cycle.
pub(super) fn set_modes(motor: &mut Bench) -> Result<(), StudyError> {
    motor.set_text("drive_mode", "current")?;
    motor.set_text("mechanical_mode", "imposed_speed")
}

#[derive(Clone, Copy)]
struct Slots {
    speed: Slot,
    current: Slot,
    torque: Slot,
    k_t: Slot,
    winding: Slot,
    voltage: Slot,
    resistance: Slot,
    energy: Slot,
}

/// A motor with a cycle at its shaft.
pub struct Shaft {
    motor: Box<dyn Model>,
    cycle: Arc<Cycle>,
    drive: Drive,
    inertia: f64,
    slots: Slots,
    steps: u32,
    h: f64,
    done: u64,
}

period!(Shaft);

impl Clone for Shaft {
    fn clone(&self) -> Self {
        Shaft { motor: self.motor.boxed_clone(), cycle: Arc::clone(&self.cycle), ..*self }
    }
}

impl Shaft {
    pub(super) fn start(mut motor: Bench, cycle: Arc<Cycle>, drive: Drive) -> Result<Shaft, StudyError> {
        set_modes(&mut motor)?;
        let slot = |name: &str| Ok::<Slot, StudyError>(motor.entry(name)?.slot);
        let slots = Slots {
            speed: slot("imposed_speed")?,
            current: slot("current_command")?,
            torque: slot("shaft_torque")?,
            k_t: slot("torque_constant")?,
            winding: slot("winding_temperature")?,
            voltage: slot("terminal_voltage")?,
            resistance: slot("winding_resistance")?,
            energy: slot("energy_electrical")?,
        };
        let inertia = motor.get("motor.J")? + drive.inertia / (drive.ratio * drive.ratio);
        let mut motor = motor.into_model();
        motor.set(slots.speed, cycle.speed(0.0) * drive.ratio);
        motor.start(0.0).map_err(|fault| StudyError::new(fault.to_string()))?;
        let steps = (cycle.period() / STEP - 1e-9).ceil().clamp(STEPS.0, STEPS.1);
        let h = cycle.period() / steps;
        Ok(Shaft { motor, cycle, drive, inertia, slots, steps: steps as u32, h, done: 0 })
    }

    pub(super) fn stride_time(&self) -> f64 {
        self.cycle.period()
    }

    pub(super) fn temperatures(&self) -> Vec<f64> {
        temperatures(self.motor.as_ref(), FIRST)
    }

    pub(super) fn put_temperatures(&mut self, values: &[f64]) {
        put_temperatures(self.motor.as_mut(), FIRST, values);
    }

    pub(super) fn stride(&mut self) -> Result<Periodic, StudyError> {
        self.steps_of_a_cycle(|_, _| ())
    }

    pub(super) fn stride_with_slopes(&mut self) -> Result<(Periodic, Vec<Vec<f64>>), StudyError> {
        let n = self.temperatures().len();
        let mut slopes = vec![vec![0.0; n]; n];
        let stride = self.steps_of_a_cycle(|shaft, step| {
            if step * INSTANTS % shaft.steps < INSTANTS {
                add_slopes(shaft.motor.as_ref(), FIRST, &mut slopes, 1.0 / f64::from(INSTANTS));
            }
        })?;
        Ok((stride, slopes))
    }

    fn steps_of_a_cycle(&mut self, mut look: impl FnMut(&Shaft, u32)) -> Result<Periodic, StudyError> {
        let Drive { ratio, efficiency, scale, supply, .. } = self.drive;
        let mut s = Periodic { winding_temperature: f64::NEG_INFINITY, ..Periodic::default() };
        let before = self.motor.get(self.slots.energy);
        let mut voltage_peak = 0.0f64;
        for step in 0..self.steps {
            let t = f64::from(step) * self.h;
            let ends = [t, t + self.h].map(|t| self.cycle.speed(t) * ratio);
            let acceleration = (ends[1] - ends[0]) / self.h;
            let speed = 0.5 * (ends[0] + ends[1]);
            let out = scale * self.cycle.torque(t + 0.5 * self.h);
            let power = out * speed / ratio;
            let through = if power >= 0.0 { 1.0 / efficiency } else { efficiency };
            let wanted = out / ratio * through + self.inertia * acceleration;
            let motor = &mut self.motor;
            motor.set(self.slots.speed, speed);
            let mut current = motor.get(self.slots.current);
            for _ in 0..DRAG_EVALUATIONS {
                motor.set(self.slots.current, current);
                let k_t = motor.get(self.slots.k_t);
                let drag = k_t * current - motor.get(self.slots.torque);
                current = (wanted + drag) / k_t;
            }
            if !motor.set(self.slots.current, current) {
                return Err(StudyError::new(format!(
                    "the cycle needs {current:.1} A, which the motor does not take"
                )));
            }
            let voltage = motor.get(self.slots.voltage).abs();
            voltage_peak = voltage_peak.max(voltage);
            // The torque that the missing voltage would give.
            let missing = (voltage - supply).max(0.0) / motor.get(self.slots.resistance);
            s.torque_error_rms += (missing * motor.get(self.slots.k_t) * ratio).powi(2);
            motor.set(self.slots.speed, ends[0]);
            motor.set_slope(self.slots.speed, acceleration);
            look(self, step);
            let time = self.done as f64 * self.h;
            let motor = &mut self.motor;
            motor.step(time, self.h).map_err(|fault| {
                let sentence = StudyError::of_step(&**motor, &fault).to_string();
                let peak = self.cycle.table(scale / ratio).torques.into_iter().fold(0.0, |p: f64, t| p.max(t.abs()));
                let current = significant(peak / motor.get(self.slots.k_t));
                let gear = match ratio {
                    1.0 => "no ratio is given".to_owned(),
                    ratio => format!("the ratio is {}", significant(ratio)),
                };
                let cause = format!(
                    "{}; the peak torque of the cycle is {} N.m at the motor ({gear}), for which it needs {current} A",
                    sentence.trim_end_matches('.'),
                    significant(peak)
                );
                if motor.ended() { StudyError::Unsettled(cause) } else { StudyError::new(cause) }
            })?;
            self.done += 1;
            let winding = motor.get(self.slots.winding);
            s.winding_temperature = s.winding_temperature.max(winding);
            s.winding_temperature_mean += winding;
            s.current_rms += current * current;
            s.current_peak = s.current_peak.max(current.abs());
            s.joint_torque_peak = s.joint_torque_peak.max(out.abs());
            s.power_joint += power;
        }
        let n = f64::from(self.steps);
        s.winding_temperature_mean /= n;
        s.current_rms = (s.current_rms / n).sqrt();
        s.torque_error_rms = (s.torque_error_rms / n).sqrt();
        s.power_joint /= n;
        s.power_electrical = (self.motor.get(self.slots.energy) - before) / self.cycle.period();
        s.power_supply = s.power_electrical;
        s.voltage_peak = Some(voltage_peak);
        Ok(s)
    }
}
