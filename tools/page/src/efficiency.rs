//! Efficiency over torque and speed: shaft power over electrical power of the motor, all nodes at the ambient temperature.

use crate::Answer;
use crate::choice::{Choice, RPM, current_for_torque};
use crate::level_lines::level_line;
use crate::range::{cold, no_load_speed, torque_at_voltage};
use present::figure::{Axis, Figure};
use present::number;
use serde::Serialize;
use study::StudyError;
use study::numeric::linspace;

/// Points in each direction.
const POINTS: usize = 41;
/// The levels that are drawn.
const LEVELS: [f64; 6] = [0.5, 0.6, 0.7, 0.8, 0.85, 0.9];

/// The map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Map {
    /// Torques, N.m.
    pub torque: Vec<f64>,
    /// Speeds, rad/s.
    pub speed: Vec<f64>,
    /// Efficiency by speed and torque; absent above the supply voltage.
    pub efficiency: Vec<Vec<Option<f64>>>,
}

/// Computes the map up to half of the stall torque, where the power is greatest.
///
/// # Errors
/// One sentence: a value outside its limits, a voltage that does not turn the motor.
pub fn map(choice: &Choice) -> Result<Map, StudyError> {
    let mut bench = cold(choice)?;
    let fastest = no_load_speed(&mut bench, choice.voltage)?;
    let most = 0.5 * torque_at_voltage(&mut bench, choice.voltage, 0.0)?;
    let torque = linspace(most / (POINTS - 1) as f64, most, POINTS - 1);
    let speed = linspace(fastest / (POINTS - 1) as f64, fastest, POINTS - 1);
    let mut efficiency = Vec::new();
    for w in &speed {
        let limit = torque_at_voltage(&mut bench, choice.voltage, *w)?;
        let mut row = Vec::new();
        for tau in &torque {
            row.push(if *tau > limit {
                None
            } else {
                current_for_torque(&mut bench, *tau)?;
                Some(tau * w / bench.get("power_electrical")?)
            });
        }
        efficiency.push(row);
    }
    Ok(Map { torque, speed, efficiency })
}

/// Figure, sentences and values.
pub fn answer(choice: &Choice) -> Result<Answer, StudyError> {
    let found = map(choice)?;
    let rpm: Vec<f64> = found.speed.iter().map(|w| w / RPM).collect();
    let z: Vec<Vec<f64>> =
        found.efficiency.iter().map(|row| row.iter().map(|e| e.unwrap_or(f64::NAN)).collect()).collect();
    let mut figure =
        Figure::new("Efficiency of the cold motor", Axis::new("torque in N·m"), Axis::new("speed in 1/min"));
    for level in LEVELS {
        let line = level_line(&found.torque, &rpm, &z, level);
        if !line.is_empty() {
            figure = figure.line(&format!("{} %", number(100.0 * level)), line);
        }
    }
    let cells = z
        .iter()
        .zip(&rpm)
        .flat_map(|(row, n)| row.iter().zip(&found.torque).map(move |(e, tau)| (*e, *tau, *n)));
    let best = cells.filter(|c| c.0.is_finite()).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    let text = format!(
        "Best efficiency of the grid: {} % at {} N·m and {} 1/min. Shaft power over electrical power of the motor at the ambient temperature, up to {} V and half of the stall torque.",
        number(100.0 * best.0),
        number(best.1),
        number(best.2),
        number(choice.voltage)
    );
    Ok(Answer::new(&figure, text, &found))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::choice::{Load, tests::choice};

    /// By hand: (tau w)/(R I^2 + k_t I w), I = (tau + friction)/k_t; the best is about (1 - sqrt(I_0/I_stall))^2.
    #[test]
    fn efficiency_by_hand() {
        let mut choice = choice("maxon-re40-148877", Load::Torque(0.1));
        choice.voltage = 48.0;
        let found = map(&choice).unwrap();
        let (k_t, r, friction) = (0.0603, 1.13, 0.0041366);
        let (j, i) = (30, 5);
        let (w, tau) = (found.speed[j], found.torque[i]);
        let current = (tau + friction) / k_t;
        let by_hand = tau * w / (r * current * current + k_t * current * w);
        assert!((found.efficiency[j][i].unwrap() / by_hand - 1.0).abs() < 1e-6, "{by_hand}");
        let best = found.efficiency.iter().flatten().flatten().fold(0.0, |a: f64, b| a.max(*b));
        let known = (1.0 - (friction / k_t / (48.0 / r)).sqrt()).powi(2);
        assert!((best - known).abs() < 0.01, "{best} and {known}");
    }
}
