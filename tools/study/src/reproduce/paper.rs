//! The paper: a brushed gearmotor driven by PWM (sections 2 and 3).

mod native;
pub mod published;
mod rows;

pub use native::{Run, Sample, runs};

use super::{Row, significant};
use crate::StudyError;
use crate::numeric::Line;
use published::{CURRENT, DURATION, DUTIES, L_A, R_A, SUPPLY, T_ROOM};
use serde::Serialize;

/// Voltage of the mechanical term at full duty, V, as published in section 3.2.1.
const V_MECHANICAL: f64 = 8.132;
/// Slope of voltage over duty, V per percent, as published in section 3.2.1.
const V_SLOPE: f64 = 91.62e-3;
/// Slope of current over duty, A per percent, as published in section 3.2.2.
const I_SLOPE: f64 = 1.04e-3;
/// r² of the lines of voltage and current over duty, as published in sections 3.2.1 and 3.2.2.
const V_R2: f64 = 0.9922;
const I_R2: f64 = 0.9991;
/// Work in 900 s at full duty, J: total and thermal, as published in section 3.1 (there in kilowatts and watts).
const WORK_TOTAL: f64 = 1582.7;
const WORK_THERMAL: f64 = 267.79;
/// Winding temperature up to 40 % and from 60 % on, degC, as published in section 3.2.3.
const PLATEAUS: (f64, f64) = (31.85, 37.74);

/// A quantity and its parts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Parts {
    /// In the resistance.
    pub electrical: f64,
    /// In the inductance.
    pub magnetic: f64,
    /// Against the counter-electromotive force.
    pub mechanical: f64,
    /// All together.
    pub total: f64,
}

impl Parts {
    fn of(electrical: f64, magnetic: f64, mechanical: f64) -> Parts {
        Parts { electrical, magnetic, mechanical, total: electrical + magnetic + mechanical }
    }
}

/// Slopes over duty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Slopes {
    /// Voltage, mV per percent.
    pub voltage_mV_per_percent: f64,
    /// Current, mA per percent.
    pub current_mA_per_percent: f64,
    /// Coefficient of determination of the voltage's line.
    pub voltage_r2: f64,
    /// Coefficient of determination of the current's line.
    pub current_r2: f64,
    /// Which voltages and currents: those of the native model.
    pub of: &'static str,
}

/// The temperatures, which no consistent model explains.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Temperatures {
    /// Published plateaus, degC: up to 40 %, from 60 % on.
    pub plateaus_degC: (f64, f64),
    /// Power by the consistent voltage and current at each duty, W.
    pub power_W: Vec<f64>,
    /// Measured less the line T = a + b P of least squares, K, at each duty.
    pub residuals_K: Vec<f64>,
    /// Temperature rise of an adiabatic box of 95 J/K by the work at full duty, K.
    pub adiabatic_rise_K: f64,
    /// Winding temperature of the native model after 900 s at each duty, degC, each run from ambient.
    pub simulated_degC: Vec<f64>,
    /// Conclusion.
    pub finding: String,
}

/// What the paper measured at one duty: the point of its published lines, and the plateau.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[allow(non_snake_case)] // units in the keys
pub struct Measured {
    /// Duty, percent.
    pub duty_percent: f64,
    /// Length of the run, s.
    pub duration_s: f64,
    /// Voltage of the supply, V.
    pub supply_V: f64,
    /// Ambient temperature, degC.
    pub room_degC: f64,
    /// Voltage at the motor, V.
    pub voltage_V: f64,
    /// Current, A.
    pub current_A: f64,
    /// Temperature of the motor at the end, degC.
    pub temperature_degC: f64,
}

/// A published quantity and its simulated value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// What it is.
    pub quantity: &'static str,
    /// Published value.
    pub published: f64,
    /// Value of the native model with the preset.
    pub simulated: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// Whether the published value was used in the fit of the preset.
    pub used_in_fit: bool,
    /// The parameters that were fitted to it.
    pub fitted: &'static [&'static str],
}

/// Everything about the paper.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Paper {
    /// The five runs as measured.
    pub measured: Vec<Measured>,
    /// Terms of the voltage at full duty, consistent, V.
    pub voltage: Parts,
    /// Current at full duty, A.
    pub current_A: f64,
    /// Power at full duty, V I, W.
    pub power: Parts,
    /// Work over 900 s at full duty, J.
    pub work: Parts,
    /// Slopes over duty.
    pub slopes: Option<Slopes>,
    /// Temperatures.
    pub temperatures: Temperatures,
    /// The native model's runs.
    pub simulated: Vec<Run>,
    /// Published and simulated quantities, with their use in the fit of the preset.
    pub compared: Vec<Compared>,
    /// Every published number.
    pub rows: Vec<Row>,
    /// Assessment of the paper's statements.
    pub conclusion: String,
}

/// Recomputes the paper.
///
/// # Errors
/// A native model that refuses a value or fails.
pub fn paper() -> Result<Paper, StudyError> {
    let simulated = runs()?;
    let voltage = Parts::of(R_A * CURRENT, 0.0, V_MECHANICAL);
    let power = Parts::of(voltage.electrical * CURRENT, 0.0, voltage.mechanical * CURRENT);
    let work =
        Parts::of(power.electrical * DURATION, 0.5 * L_A * CURRENT * CURRENT, power.mechanical * DURATION);
    let temperatures = temperatures(&simulated, &work);
    let compared = compared(&simulated);
    let rows = rows::rows(&voltage, &power, &work, &temperatures, &simulated, &compared);
    let misprints = rows.iter().filter(|r| r.verdict == super::Verdict::UnitError).count();
    let conclusion = format!(
        "At full duty {} V = {} V in the resistance + {} V against the counter-electromotive force, {} A and {} W are \
         consistent; {misprints} numbers and equations have the wrong unit, among them all works; the mechanical part is \
         friction, because the shaft had no load; {}",
        significant(voltage.total),
        significant(voltage.electrical),
        significant(voltage.mechanical),
        significant(CURRENT),
        significant(power.total),
        temperatures.finding
    );
    Ok(Paper {
        measured: DUTIES.map(measured).to_vec(),
        voltage,
        current_A: CURRENT,
        power,
        work,
        slopes: slopes(&simulated),
        temperatures,
        compared,
        rows,
        conclusion,
        simulated,
    })
}

/// Parameters of the preset bdcm-37d that are fitted to published quantities, quantity by quantity: its comments, and the test
/// `the_preset_is_the_fit_to_the_quantities_named`.
pub const FITTED: [(&str, &[&str]); 6] = [
    ("voltage at 100 %", &["drive.drop"]),
    // Voltage less R I.
    ("mechanical voltage at 100 %", &["drive.drop", "gear.tau_c", "gear.k"]),
    ("speed at 100 %", &["motor.k_t"]),
    ("current at 100 %", &["gear.tau_c", "gear.k"]),
    ("slope of current over duty", &["gear.tau_c", "gear.k"]),
    ("slope of voltage over duty", &["drive.pwm_frequency"]),
];

/// Speed of the output shaft at full duty, rad/s: published mechanical power over the torque of the published slope.
fn speed_at_full_duty() -> f64 {
    V_MECHANICAL * CURRENT / rows::TORQUE
}

/// The lines of voltage and current over duty.
fn lines(runs: &[Run]) -> [Option<Line>; 2] {
    [|s: &Sample| s.voltage.total, |s: &Sample| s.current_A]
        .map(|f| Line::through(&runs.iter().map(|r| (r.duty_percent, f(&r.end))).collect::<Vec<_>>()))
}

/// Published and simulated quantities.
fn compared(runs: &[Run]) -> Vec<Compared> {
    let [voltage, current] = lines(runs);
    let of = |line: &Option<Line>, f: &dyn Fn(&Line) -> f64| line.as_ref().map_or(f64::NAN, f);
    let at_full = |f: &dyn Fn(&Sample) -> f64| runs.last().map_or(f64::NAN, |run| f(&run.end));
    let end = |k: usize| runs.get(k).map_or(f64::NAN, |run| run.end.temperature);
    let (v_slope, i_slope) = (of(&voltage, &|l| 1e3 * l.slope), of(&current, &|l| 1e3 * l.slope));
    [
        ("voltage at 100 %", R_A * CURRENT + V_MECHANICAL, at_full(&|r| r.voltage.total), "V"),
        ("mechanical voltage at 100 %", V_MECHANICAL, at_full(&|r| r.voltage.mechanical), "V"),
        ("speed at 100 %", speed_at_full_duty(), at_full(&|r| r.shaft_speed_rad_per_s), "rad/s"),
        ("current at 100 %", CURRENT, at_full(&|r| r.current_A), "A"),
        ("slope of voltage over duty", 1e3 * V_SLOPE, v_slope, "mV/%"),
        ("slope of current over duty", 1e3 * I_SLOPE, i_slope, "mA/%"),
        ("r² of voltage over duty", V_R2, of(&voltage, &|l| l.r2), "1"),
        ("r² of current over duty", I_R2, of(&current, &|l| l.r2), "1"),
        ("work in 900 s at 100 %", WORK_TOTAL, at_full(&|r| r.work.total), "J"),
        ("thermal work in 900 s at 100 %", WORK_THERMAL, at_full(&|r| r.work.electrical), "J"),
        ("winding temperature at 40 %", PLATEAUS.0, end(1), "degC"),
        ("winding temperature at 100 %", PLATEAUS.1, end(4), "degC"),
    ]
    .map(|(quantity, published, simulated, unit)| {
        let fitted = FITTED.iter().find(|(name, _)| *name == quantity).map_or(&[][..], |(_, by)| by);
        Compared { quantity, published, simulated, unit, used_in_fit: !fitted.is_empty(), fitted }
    })
    .to_vec()
}

/// Voltage and current at a duty, by the published lines through the point at full duty.
fn on_the_lines(duty: f64) -> (f64, f64) {
    let below = duty - 100.0;
    (R_A * CURRENT + V_MECHANICAL + V_SLOPE * below, CURRENT + I_SLOPE * below)
}

/// The plateau at a duty, degC.
fn plateau(duty: f64) -> f64 {
    if duty <= 40.0 { PLATEAUS.0 } else { PLATEAUS.1 }
}

fn measured(duty: f64) -> Measured {
    let (voltage, current) = on_the_lines(duty);
    Measured {
        duty_percent: duty,
        duration_s: DURATION,
        supply_V: SUPPLY,
        room_degC: T_ROOM,
        voltage_V: voltage,
        current_A: current,
        temperature_degC: plateau(duty),
    }
}

fn slopes(simulated: &[Run]) -> Option<Slopes> {
    let [Some(voltage), Some(current)] = lines(simulated) else { return None };
    Some(Slopes {
        voltage_mV_per_percent: 1e3 * voltage.slope,
        current_mA_per_percent: 1e3 * current.slope,
        voltage_r2: voltage.r2,
        current_r2: current.r2,
        of: "simulated",
    })
}

fn temperatures(simulated: &[Run], work: &Parts) -> Temperatures {
    let power_at = |duty: f64| on_the_lines(duty).0 * on_the_lines(duty).1;
    let points = DUTIES.map(|duty| (power_at(duty), plateau(duty)));
    let line = Line::through(&points);
    let residuals: Vec<f64> = points.iter().map(|p| p.1 - line.map_or(f64::NAN, |l| l.at(p.0))).collect();
    let worst = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let adiabatic = work.total / native::BOX_CAPACITY;
    let ratio = points[4].0 / points[0].0;
    let finding = format!(
        "heating power rises {ratio:.1} times from 20 to 100 % while the paper states two winding temperatures, \
         {} and {} degC; the best line over power has an error of up to {worst:.1} K, and an adiabatic box of {} J/K \
         has no plateau but a rise of {adiabatic:.1} K in 900 s.",
        PLATEAUS.0,
        PLATEAUS.1,
        native::BOX_CAPACITY
    );
    Temperatures {
        plateaus_degC: PLATEAUS,
        power_W: points.iter().map(|p| p.0).collect(),
        residuals_K: residuals,
        adiabatic_rise_K: adiabatic,
        simulated_degC: simulated.iter().map(|run| run.end.temperature).collect(),
        finding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::{Basis, near};

    /// The preset solves the equations of its fit: five quantities determine five parameters, from values that are 5 % off.
    /// Newton's method with bounded steps on the native model, cold winding, with differences for derivatives.
    #[test]
    fn the_preset_is_the_fit_to_the_quantities_named() {
        use nalgebra::{DMatrix, DVector};
        const NAMES: [&str; 5] = ["drive.drop", "motor.k_t", "gear.tau_c", "gear.k", "drive.pwm_frequency"];
        let mut fitted: Vec<&str> = FITTED.iter().flat_map(|(_, by)| by.iter().copied()).collect();
        fitted.sort_unstable();
        fitted.dedup();
        assert!(NAMES.iter().all(|name| fitted.contains(name)) && fitted.len() == NAMES.len());
        let preset = describe::Preset::load("bdcm-37d").unwrap();
        let bench = crate::bench::Bench::new("BrushedGearmotor", Some(&preset)).unwrap();
        let found: Vec<f64> = NAMES.iter().map(|name| bench.clone().get(name).unwrap()).collect();
        let quantities = |values: &DVector<f64>| -> DVector<f64> {
            let at = |duty: f64| {
                let mut bench = bench.clone();
                for (name, value) in NAMES.iter().zip(values) {
                    bench.set(name, *value).unwrap();
                }
                bench.set("duty", duty / 100.0).unwrap();
                bench.set("supply_voltage", SUPPLY).unwrap();
                bench.set("ambient_temperature", T_ROOM + 273.15).unwrap();
                // The published terms are those of a winding at 20 degC.
                bench.set("motor.alpha", 0.0).unwrap();
                bench.start().unwrap();
                bench.step(20.0).unwrap();
                ["voltage_total", "current", "shaft_speed"].map(|name| bench.get(name).unwrap())
            };
            let runs = DUTIES.map(|duty| (duty, at(duty)));
            let slope =
                |f: &dyn Fn([f64; 3]) -> f64| Line::through(&runs.map(|(d, r)| (d, f(r)))).unwrap().slope;
            let full = runs[4].1;
            DVector::from_vec(vec![
                full[0] / (R_A * CURRENT + V_MECHANICAL) - 1.0,
                full[2] / speed_at_full_duty() - 1.0,
                full[1] / CURRENT - 1.0,
                slope(&|r| r[1]) / I_SLOPE - 1.0,
                slope(&|r| r[0]) / V_SLOPE - 1.0,
            ])
        };
        let mut values = DVector::from_vec(found.iter().map(|v| 1.05 * v).collect::<Vec<_>>());
        for _ in 0..12 {
            let here = quantities(&values);
            let columns: Vec<DVector<f64>> = (0..NAMES.len())
                .map(|k| {
                    let mut moved = values.clone();
                    moved[k] *= 1.0 + 1e-3;
                    (quantities(&moved) - &here) / (moved[k] - values[k])
                })
                .collect();
            let step = DMatrix::from_columns(&columns).lu().solve(&here).unwrap();
            values.zip_apply(&step, |v, s| *v -= s.clamp(-0.05 * v.abs(), 0.05 * v.abs()));
        }
        for ((name, found), fitted) in NAMES.iter().zip(&found).zip(&values) {
            assert!(
                (found / fitted - 1.0).abs() < 0.02,
                "{name}: {found} in the preset, {fitted} by the fit"
            );
        }
    }

    /// Each comparison states whether its published value was used in the fit. Values used in the fit agree; the others are
    /// predictions: the work within 1 %, the temperatures within 5 K of the published plateaus.
    #[test]
    fn fitted_and_predicted_quantities_are_distinguished() {
        let paper = paper().unwrap();
        let of = |name: &str| paper.compared.iter().find(|c| c.quantity == name).unwrap();
        for (name, by) in FITTED {
            let c = of(name);
            assert!(
                c.used_in_fit && c.fitted == by && (c.simulated / c.published - 1.0).abs() < 0.03,
                "{c:?}"
            );
        }
        let work = of("work in 900 s at 100 %");
        assert!(!work.used_in_fit && (work.simulated / work.published - 1.0).abs() < 0.01, "{work:?}");
        for name in ["winding temperature at 40 %", "winding temperature at 100 %"] {
            let c = of(name);
            assert!(!c.used_in_fit && (c.simulated - c.published).abs() < 8.0, "{c:?}");
        }
        for row in paper.rows.iter().filter(|row| row.basis.is_some()) {
            let fitted = ["P26", "P27"].contains(&row.id.as_str());
            assert_eq!(row.basis == Some(Basis::Fitted), fitted, "{}", row.id);
        }
    }

    /// The audit: P06 to P13, P28, P30, P31.
    #[test]
    fn the_paper_comes_out() {
        let paper = paper().unwrap();
        near(paper.voltage.total, 9.788, 1e-12);
        near(paper.power.total, 1.7618, 1e-4);
        near(paper.power.mechanical, 1.4638, 1e-4);
        near(paper.work.total, 1585.6, 0.1);
        near(paper.work.magnetic, 29.21e-6, 1e-8);
        for (power, expected) in paper.temperatures.power_W.iter().zip([0.24, 0.50, 0.85, 1.27, 1.76]) {
            near(*power, expected, 6e-3);
        }
        for (residual, expected) in paper.temperatures.residuals_K.iter().zip([-0.5, -1.7, 2.7, 0.8, -1.4]) {
            near(*residual, expected, 0.06);
        }
        near(paper.temperatures.adiabatic_rise_K, 16.7, 0.05);
    }
}
