//! Sweeps over a grid of inputs and parameters: one objective at every point, in parallel, and the best point.

use crate::StudyError;
use crate::bench::Bench;
use crate::numeric::linspace;
use crate::steady::{Setup, continuous_torque, steady};
use crate::walk::{Load, Objective};
use physics::declare::Kind;
use physics::model::Entry;
use present::figure::{Axis, Figure};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Points that a sweep may have.
const MAX_POINTS: usize = 1_000_000;

/// A variable and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Vary {
    /// Name of an input or a parameter.
    pub name: String,
    /// Its values.
    pub values: Vec<f64>,
}

impl Vary {
    /// From `name=from:to:n`, both ends included.
    ///
    /// # Errors
    /// One sentence naming what is wrong.
    pub fn parse(text: &str) -> Result<Vary, StudyError> {
        let wrong = |why: &str| StudyError::new(format!("--vary {text}: {why}; expected name=from:to:n"));
        let (name, range) = text.split_once('=').ok_or_else(|| wrong("there is no ="))?;
        let parts: Vec<&str> = range.split(':').collect();
        let [from, to, n] = parts[..] else { return Err(wrong("there are not three numbers behind =")) };
        let number = |text: &str| {
            let value = text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
            value.ok_or_else(|| wrong(&format!("{text} is not a finite number")))
        };
        let (from, to) = (number(from)?, number(to)?);
        let n: usize =
            n.trim().parse().map_err(|_| wrong(&format!("{n} is not a whole number of points")))?;
        if !(1..=MAX_POINTS).contains(&n) {
            return Err(wrong(&format!("{n} points are not within 1 ... {MAX_POINTS}")));
        }
        if name.trim().is_empty() {
            return Err(wrong("there is no name"));
        }
        Ok(Vary { name: name.trim().to_owned(), values: linspace(from, to, n) })
    }
}

/// The objective of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Whether the least value is the best, as of a temperature.
    pub least_is_best: bool,
}

/// A model whose variables can be varied and whose objective can be evaluated.
pub trait Case: Sync {
    /// The objective.
    ///
    /// # Errors
    /// The case has no such objective.
    fn target(&self) -> Result<Target, StudyError>;
    /// The variable of this name.
    ///
    /// # Errors
    /// There is none.
    fn entry(&self, name: &str) -> Result<&'static Entry, StudyError>;
    /// The objective with these values, set last.
    ///
    /// # Errors
    /// A value that is refused, or no steady state.
    fn at(&self, sets: &[(&str, f64)]) -> Result<f64, StudyError>;
    /// Whether a value is taken.
    ///
    /// # Errors
    /// One sentence why not.
    fn takes(&self, name: &str, value: f64) -> Result<(), StudyError>;
    /// Source of the measured data that the case uses, if any.
    ///
    /// # Errors
    /// A case without the source of its data.
    fn source(&self) -> Result<Option<String>, StudyError> {
        Ok(None)
    }
}

/// A motor at constant inputs.
///
/// The objective is `continuous_torque`, N.m; `torque_density`, the same per total mass, N.m/kg;
/// or an output in steady state.
#[derive(Clone, Debug)]
pub struct ConstantInputs {
    /// The motor and its inputs.
    pub setup: Setup,
    /// The objective's name.
    pub objective: String,
}

impl Case for ConstantInputs {
    fn target(&self) -> Result<Target, StudyError> {
        let bench = self.setup.bench()?;
        let output = match self.objective.as_str() {
            "continuous_torque" => "shaft_torque",
            other => other,
        };
        let entry = bench.entry(output)?;
        if !bench.is_output(output) {
            return Err(StudyError::new(format!("--objective {output} is no output of the model")));
        }
        let unit = entry.row.unit.name();
        Ok(Target { name: self.objective.clone(), unit, least_is_best: unit == "K" && !entry.row.relative })
    }

    fn entry(&self, name: &str) -> Result<&'static Entry, StudyError> {
        self.setup.bench()?.entry(name)
    }

    fn at(&self, sets: &[(&str, f64)]) -> Result<f64, StudyError> {
        let mut setup = self.setup.clone();
        setup.sets.extend(sets.iter().map(|(name, value)| ((*name).to_owned(), value.to_string())));
        let mut bench: Bench = setup.bench()?;
        match self.objective.as_str() {
            "continuous_torque" => Ok(continuous_torque(&bench)?.torque),
            "torque_density" => Ok(continuous_torque(&bench)?.torque_density),
            output => {
                steady(&mut bench)?;
                bench.get(output)
            }
        }
    }

    fn takes(&self, name: &str, value: f64) -> Result<(), StudyError> {
        self.setup.bench()?.set(name, value)
    }
}

/// A motor in an actuator on a walking joint.
#[derive(Clone)]
pub struct Walking {
    /// Motor, actuator and gait.
    pub load: Load,
    /// The objective.
    pub objective: Objective,
    /// Longest duration of the walk, h.
    pub hours: f64,
}

impl Case for Walking {
    fn target(&self) -> Result<Target, StudyError> {
        let Objective { name, unit, least_is_best, .. } = self.objective;
        Ok(Target { name: name.to_owned(), unit, least_is_best })
    }

    fn entry(&self, name: &str) -> Result<&'static Entry, StudyError> {
        self.load.owner(name)?.entry(name)
    }

    fn at(&self, sets: &[(&str, f64)]) -> Result<f64, StudyError> {
        let mut load = self.load.clone();
        for (name, value) in sets {
            load.set_text(name, &value.to_string())?;
        }
        self.objective.of(&load, self.hours)
    }

    fn takes(&self, name: &str, value: f64) -> Result<(), StudyError> {
        self.load.clone().set_text(name, &value.to_string())
    }

    fn source(&self) -> Result<Option<String>, StudyError> {
        self.load.source().map(Some)
    }
}

/// A point of the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Values of the varied variables, in order.
    pub values: Vec<f64>,
    /// The objective, where the model settles.
    pub objective: Option<f64>,
    /// Why it has none.
    pub failure: Option<String>,
}

/// A variable whose best value is the first or the last of its range: the optimum may lie outside.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// The variable.
    pub name: String,
    /// Its value at the best point.
    pub value: f64,
    /// Whether that is the lower or the upper end of the range.
    pub end: &'static str,
}

/// A finished sweep.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// Names of the varied variables.
    pub varied: Vec<String>,
    /// Their units.
    pub units: Vec<&'static str>,
    /// Name of the objective.
    pub objective: String,
    /// Its unit.
    pub objective_unit: &'static str,
    /// All points; the last variable runs fastest.
    pub points: Vec<Point>,
    /// The best point.
    pub best: Option<Point>,
    /// The variables whose best value is at an end of the range.
    pub best_at_edge: Vec<Edge>,
    /// Number of points without a result; each names its reason.
    pub infeasible: usize,
    /// Source of the measured data, for a gait.
    pub source: Option<String>,
}

/// Runs the sweep; `progress` is called with the number of finished points, from several threads.
///
/// # Errors
/// No grid, a variable or a value that the model does not take, or no point with a result.
pub fn sweep(case: &dyn Case, vary: &[Vary], progress: impl Fn(usize) + Sync) -> Result<Sweep, StudyError> {
    let target = case.target()?;
    let count = vary.iter().map(|v| v.values.len()).fold(1usize, usize::saturating_mul);
    if vary.is_empty() || count > MAX_POINTS {
        return Err(StudyError::new(format!("--vary makes {count} points; 1 ... {MAX_POINTS} are possible")));
    }
    check(case, vary)?;
    let done = AtomicUsize::new(0);
    let points: Vec<Point> = (0..count)
        .into_par_iter()
        .map(|k| {
            let values = grid_point(vary, k);
            let sets: Vec<(&str, f64)> =
                vary.iter().zip(&values).map(|(v, value)| (v.name.as_str(), *value)).collect();
            let found = case.at(&sets);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1);
            let failure = found.as_ref().err().map(ToString::to_string);
            Point { values, objective: found.ok(), failure }
        })
        .collect();
    let better = |a: &f64, b: &f64| if target.least_is_best { b.total_cmp(a) } else { a.total_cmp(b) };
    let best = points
        .iter()
        .filter_map(|p| p.objective.map(|o| (o, p)))
        .max_by(|a, b| better(&a.0, &b.0))
        .map(|(_, p)| p.clone());
    if best.is_none() {
        let why = points.first().and_then(|p| p.failure.clone()).unwrap_or_default();
        return Err(StudyError::new(format!("no point of the sweep has a result: {why}")));
    }
    Ok(Sweep {
        varied: vary.iter().map(|v| v.name.clone()).collect(),
        units: vary
            .iter()
            .map(|v| case.entry(&v.name).map(|e| e.row.unit.name()))
            .collect::<Result<_, _>>()?,
        objective: target.name,
        objective_unit: target.unit,
        best_at_edge: best.as_ref().map_or(Vec::new(), |point| edges(vary, &point.values)),
        infeasible: points.iter().filter(|p| p.objective.is_none()).count(),
        source: case.source()?,
        points,
        best,
    })
}

/// The variables that are at an end of their range.
fn edges(vary: &[Vary], at: &[f64]) -> Vec<Edge> {
    let edge = |(v, &value): (&Vary, &f64)| {
        let (least, most) =
            v.values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), x| (l.min(*x), m.max(*x)));
        let end = match value {
            _ if least == most => return None,
            value if value == least => "lower",
            value if value == most => "upper",
            _ => return None,
        };
        Some(Edge { name: v.name.clone(), value, end })
    };
    vary.iter().zip(at).filter_map(edge).collect()
}

/// Both ends of every range are valid values, checked before anything runs.
fn check(case: &dyn Case, vary: &[Vary]) -> Result<(), StudyError> {
    for (k, v) in vary.iter().enumerate() {
        if vary[..k].iter().any(|other| other.name == v.name) {
            return Err(StudyError::new(format!("--vary names {} twice", v.name)));
        }
        if matches!(case.entry(&v.name)?.row.kind, Kind::Enumeration(_) | Kind::Boolean) {
            return Err(StudyError::new(format!("--vary {}: it is a choice and no number", v.name)));
        }
        for value in [v.values.first(), v.values.last()].into_iter().flatten() {
            case.takes(&v.name, *value).map_err(|e| StudyError::new(format!("--vary {}: {e}", v.name)))?;
        }
    }
    Ok(())
}

/// The values of point `k`; the last variable runs fastest.
fn grid_point(vary: &[Vary], k: usize) -> Vec<f64> {
    let mut rest = k;
    let mut values: Vec<f64> = vary
        .iter()
        .rev()
        .map(|v| {
            let value = v.values[rest % v.values.len()];
            rest /= v.values.len();
            value
        })
        .collect();
    values.reverse();
    values
}

impl Sweep {
    /// Header and rows, 17 digits; an objective that there is not is blank.
    pub fn csv(&self) -> String {
        let mut text = format!("{},{}\n", self.varied.join(","), self.objective);
        for point in &self.points {
            for value in &point.values {
                text += &format!("{value:.16e},");
            }
            text += &point.objective.map_or(String::new(), |o| format!("{o:.16e}"));
            text.push('\n');
        }
        text
    }

    /// The figure: the objective over the first variable, a line for each value of the second.
    ///
    /// # Errors
    /// More than two variables, or more lines than are distinguishable.
    pub fn figure(&self) -> Result<Figure, StudyError> {
        const MAX_LINES: usize = 8;
        let axis = |name: &str, of: &str| Axis::new(&format!("{}{}", words(name), unit(" in ", of)));
        let source = self.source.as_ref().map_or(String::new(), |source| format!(". {source}"));
        let mut figure = Figure::new(
            &format!("{} over {}{source}", words(&self.objective), words(&self.varied.join(" and "))),
            axis(&self.varied[0], self.units[0]),
            axis(&self.objective, self.objective_unit),
        );
        type Points = Vec<(f64, f64)>;
        let mut lines: Vec<(Option<f64>, Points)> = Vec::new();
        if self.varied.len() > 2 {
            return Err(StudyError::new(
                "--plot takes one or two varied variables; --output takes any number",
            ));
        }
        for point in &self.points {
            let key = point.values.get(1).copied();
            let place = (point.values[0], point.objective.unwrap_or(f64::NAN));
            match lines.iter_mut().find(|(k, _)| *k == key) {
                Some((_, line)) => line.push(place),
                None => lines.push((key, vec![place])),
            }
        }
        if lines.len() > MAX_LINES {
            return Err(StudyError::new(format!(
                "--plot draws a line for each of the {} values of {}; {MAX_LINES} are possible",
                lines.len(),
                self.varied[1]
            )));
        }
        for (key, line) in lines {
            let label = key.map_or(String::new(), |k| {
                format!("{} = {}{}", words(&self.varied[1]), present::number(k), unit(" ", self.units[1]))
            });
            figure = figure.line(&label, line);
        }
        Ok(figure)
    }
}

/// The name of a variable in words.
fn words(name: &str) -> String {
    name.replace(['_', '.'], " ")
}

/// A unit after a separator; a pure number has none.
fn unit(separator: &str, unit: &str) -> String {
    if unit == "1" { String::new() } else { format!("{separator}{}", unit.replace('.', "·")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constant(sets: &[(&str, &str)], objective: &str) -> ConstantInputs {
        ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, sets), objective: objective.into() }
    }

    fn vary(texts: &[&str]) -> Vec<Vary> {
        texts.iter().map(|t| Vary::parse(t).unwrap()).collect()
    }

    /// The grid runs in order, the winding is coldest with most fan and least ambient: by hand at each point.
    #[test]
    fn a_grid_of_two() {
        let grid = vary(&["ambient_temperature=290:300:2", "fan_command=0:1:3"]);
        let case = constant(&[("electrical_power", "10")], "winding_temperature");
        let found = sweep(&case, &grid, |_| {}).unwrap();
        assert_eq!(found.points.len(), 6);
        assert_eq!(found.points[1].values, [290.0, 0.5]);
        for point in &found.points {
            let g = 0.1351 + 0.113 * f64::powf(point.values[1], 0.8);
            let by_hand = point.values[0] + 10.0 * (0.21 + 1.0 / g);
            assert!((point.objective.unwrap() - by_hand).abs() < 1e-3, "{point:?} instead of {by_hand}");
        }
        assert_eq!(found.best.as_ref().unwrap().values, [290.0, 1.0]);
        let edge = |name: &str, value, end| Edge { name: name.into(), value, end };
        let edges = [edge("ambient_temperature", 290.0, "lower"), edge("fan_command", 1.0, "upper")];
        assert_eq!(found.best_at_edge, edges);
        assert_eq!(found.csv().lines().count(), 7);
        let figure = found.figure().unwrap().svg();
        assert!(figure.contains("fan command") && !figure.contains("fan_command"));
    }

    #[test]
    fn an_infeasible_point_has_its_reason_and_the_sweep_goes_on() {
        let fixed = constant(&[("drive_mode", "current")], "winding_temperature");
        let found = sweep(&fixed, &vary(&["current_command=1:20:2"]), |_| {}).unwrap();
        assert!(found.points[1].objective.is_none() && found.points[1].failure.is_some());
        assert_eq!((found.infeasible, found.best_at_edge.len()), (1, 1));
        // An optimum between the ends is at no edge, nor is a range of one value.
        let inside = sweep(&constant(&[], "power_electrical"), &vary(&["voltage=1:1:1"]), |_| {}).unwrap();
        assert!(inside.best_at_edge.is_empty());
        assert_eq!(found.best.as_ref().unwrap().values, [1.0]);
        assert!(found.csv().ends_with(",\n"));
    }

    #[test]
    fn bad_input_is_one_sentence() {
        for (text, word) in [
            ("x", "no ="),
            ("x=1:2", "three numbers"),
            ("x=1:b:3", "b is not"),
            ("x=1:2:0", "0 points"),
            ("x=1:2:2.5", "2.5"),
            ("=1:2:3", "no name"),
        ] {
            let error = Vary::parse(text).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("--vary"), "{error}");
        }
        let refused = |grid: &[&str], objective: &str| {
            sweep(&constant(&[], objective), &vary(grid), |_| {}).unwrap_err().to_string()
        };
        assert!(
            refused(&["fan_command=0:2:3"], "current")
                .contains("fan_command = 2 is outside its limits 0 ... 1")
        );
        assert!(refused(&["fan_comand=0:1:3"], "current").contains("did you mean fan_command?"));
        assert!(refused(&["fan_command=0:1:3"], "fan_command").contains("no output"));
        assert!(refused(&["drive_mode=1:2:2"], "current").contains("choice"));
        assert!(refused(&["fan_command=0:1:2", "fan_command=0:1:2"], "current").contains("twice"));
        assert!(refused(&[], "current").contains("--vary"));
    }
}
