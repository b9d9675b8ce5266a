//! What a reader of the page chooses: motor, cooling, ambient and load, in the units of the controls.

use describe::Preset;
use serde::Deserialize;
use study::StudyError;
use study::bench::Bench;
use study::numeric::try_root;
use study::steady::Setup;

/// The model of the page: all motors without a gear.
pub const MODEL: &str = study::walk::MOTOR;
/// 0 degC in K.
pub const ZERO_CELSIUS: f64 = 273.15;
/// rad/s of one revolution per minute.
pub const RPM: f64 = std::f64::consts::TAU / 60.0;
/// Relative error of a current that gives a torque or a voltage.
const CURRENT_TOLERANCE: f64 = 1e-12;

/// The choice.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choice {
    /// Name of a built-in preset.
    pub motor: String,
    /// Item of `cooling_mode`; empty: that of the preset.
    pub cooling: String,
    /// Fan speed over full speed.
    pub fan: f64,
    /// Ambient temperature, degC.
    pub ambient: f64,
    /// Supply voltage, V: limit of the operating range.
    pub voltage: f64,
    /// Speed, 1/min.
    pub speed: f64,
    /// Duration, min.
    pub minutes: f64,
    /// The load.
    pub load: Load,
}

/// A load.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Load {
    /// Constant current, A.
    Current(f64),
    /// Constant torque at the shaft, N.m.
    Torque(f64),
    /// A joint of a walking person.
    Gait(Gait),
}

/// A joint of a walking person, with the actuator between motor and joint.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gait {
    /// Item of `gait.activity`.
    pub activity: String,
    /// Item of `gait.joint`.
    pub joint: String,
    /// Body mass, kg.
    pub body_mass: f64,
    /// Fraction of the biological torque.
    pub support: f64,
    /// Ratio of the gear.
    pub ratio: f64,
    /// Stiffness of the series spring, N.m/rad.
    pub stiffness: f64,
}

impl Choice {
    /// The preset of the motor.
    ///
    /// # Errors
    /// No such preset, or one of another model.
    pub fn preset(&self) -> Result<Preset, StudyError> {
        Ok(Preset::load(&self.motor)?)
    }

    /// Cooling and ambient as settings.
    pub fn ambient(&self) -> Vec<(String, String)> {
        let mut sets = vec![
            ("fan_command".to_owned(), self.fan.to_string()),
            ("ambient_temperature".to_owned(), (self.ambient + ZERO_CELSIUS).to_string()),
        ];
        if !self.cooling.is_empty() {
            sets.push(("cooling_mode".to_owned(), self.cooling.clone()));
        }
        sets
    }

    /// The motor at a commanded current and an imposed speed, not started.
    ///
    /// # Errors
    /// One sentence naming preset, variable, value and limits.
    pub fn bench(&self) -> Result<Bench, StudyError> {
        let mut sets = self.ambient();
        for (name, value) in [("drive_mode", "current"), ("mechanical_mode", "imposed_speed")] {
            sets.push((name.to_owned(), value.to_owned()));
        }
        let mut bench = Setup { model: MODEL.to_owned(), preset: Some(self.preset()?), sets }.bench()?;
        bench.set("imposed_speed", self.speed * RPM)?;
        Ok(bench)
    }
}

/// The value of an output while a current flows, in the present state.
fn with_current(bench: &mut Bench, current: f64, output: &str) -> Result<f64, StudyError> {
    bench.set("current_command", current)?;
    bench.get(output)
}

/// The greatest current that the model takes, A.
///
/// # Errors
/// None with the declared names.
pub fn greatest_current(bench: &Bench) -> Result<f64, StudyError> {
    Ok(bench.entry("current_command")?.row.max)
}

/// Sets the current with which an output has a value, in the present state; the output rises with the current. `None` where no current
/// between `least` and the greatest gives it.
fn current_for(
    bench: &mut Bench,
    least: f64,
    mut excess: impl FnMut(&mut Bench, f64) -> Result<f64, StudyError>,
) -> Result<Option<f64>, StudyError> {
    let most = greatest_current(bench)?;
    // Currents of motors spread over decades: the bracket grows from a milliampere.
    let (mut low, mut high) = (least, least + 1e-3);
    while excess(bench, high)? < 0.0 {
        if high >= most {
            return Ok(None);
        }
        (low, high) = (high, (4.0 * high).min(most));
    }
    let found = try_root(|i| excess(bench, i), low, high, CURRENT_TOLERANCE * high)?;
    if let Some(current) = found {
        bench.set("current_command", current)?;
    }
    Ok(found)
}

/// Sets the current with which the shaft torque is `torque` in the present state, and returns it.
///
/// # Errors
/// A torque that no current gives.
pub fn current_for_torque(bench: &mut Bench, torque: f64) -> Result<f64, StudyError> {
    let idle = with_current(bench, 0.0, "shaft_torque")?;
    let found = if torque <= idle {
        // Less than friction alone: the load drives the shaft.
        Some(0.0).filter(|_| torque == idle || torque >= 0.0)
    } else {
        current_for(bench, 0.0, |b, i| Ok(with_current(b, i, "shaft_torque")? - torque))?
    };
    found.ok_or_else(|| {
        let most = greatest_current(bench).unwrap_or(f64::NAN);
        StudyError::new(format!("no current between 0 and {most} A gives the torque {torque} N.m"))
    })
}

/// Sets the current at which the terminal voltage is `voltage` in the present state, and returns it: zero where the back-EMF exceeds it.
///
/// # Errors
/// None with the declared names.
pub fn current_at_voltage(bench: &mut Bench, voltage: f64) -> Result<f64, StudyError> {
    /// Below it power over current is rounding, A.
    const LEAST: f64 = 1e-6;
    let excess = |b: &mut Bench, i: f64| Ok(with_current(b, i, "power_electrical")? / i - voltage);
    let idle = excess(bench, LEAST)?;
    let current = match idle < 0.0 {
        true => current_for(bench, LEAST, excess)?.map_or_else(|| greatest_current(bench), Ok)?,
        false => 0.0,
    };
    bench.set("current_command", current)?;
    Ok(current)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A motor in still air at rest.
    pub fn choice(motor: &str, load: Load) -> Choice {
        let (cooling, motor) = (String::new(), motor.to_owned());
        Choice { motor, cooling, fan: 0.0, ambient: 25.0, voltage: 24.0, speed: 0.0, minutes: 30.0, load }
    }

    /// By the equations of a DC motor with the printed data: torque k_t I, voltage R I + k_t w.
    #[test]
    fn currents_by_hand() {
        let mut choice = choice("maxon-re40-148877", Load::Current(0.0));
        choice.speed = 1000.0;
        let mut bench = choice.bench().unwrap();
        bench.start().unwrap();
        let (k_t, r, friction) = (0.0603, 1.13, 0.0041366);
        let current = current_for_torque(&mut bench, 0.1).unwrap();
        assert!((current / ((0.1 + friction) / k_t) - 1.0).abs() < 1e-6, "{current}");
        let current = current_at_voltage(&mut bench, 24.0).unwrap();
        assert!((current / ((24.0 - k_t * 1000.0 * RPM) / r) - 1.0).abs() < 1e-6, "{current}");
        assert_eq!(current_at_voltage(&mut bench, 1.0).unwrap(), 0.0);
    }
}
