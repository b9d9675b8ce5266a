//! Sweeps over a grid of inputs, parameters, items and motors: the quantities at every point, in parallel, the best point, and the points
//! that no other is better than in every objective (Pareto set).

mod case;
mod edges;
mod figure;
mod infeasible;
mod shown;
mod vary;

use crate::StudyError;
use crate::walk::Known;
pub use case::{Case, ConstantInputs, Target, Walking};
use edges::open_edges;
pub use edges::{Edge, edges};
pub use figure::check_figure;
use rayon::prelude::*;
use serde::Serialize;
pub use shown::Shown;
use std::sync::atomic::{AtomicUsize, Ordering};
pub use vary::{Choice, PRESET, Vary};

/// Points that a sweep may have.
const MAX_POINTS: usize = 1_000_000;
/// Most points that follow each other in one thread, where each search begins with what the last two have found, and number of such
/// rows in a smaller sweep.
const ROW: usize = 10;
const ROWS: usize = 16;

/// A limit of a quantity: points beyond it are infeasible.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Constraint {
    /// Name of the quantity.
    pub name: String,
    /// Whether the limit is the greatest value.
    pub at_most: bool,
    /// The limit in SI units.
    pub limit: f64,
    /// The limit as given.
    #[serde(skip)]
    text: String,
}

impl Constraint {
    /// From `name<=value` or `name>=value`; the value may have a unit.
    ///
    /// # Errors
    /// One sentence naming what is wrong.
    pub fn parse(text: &str) -> Result<Constraint, StudyError> {
        let parts =
            text.split_once("<=").map(|p| (p, true)).or_else(|| text.split_once(">=").map(|p| (p, false)));
        let Some(((name, limit), at_most)) = parts.filter(|((name, _), _)| !name.trim().is_empty()) else {
            return Err(StudyError::new(format!("--constraint {text}: expected name<=value or name>=value")));
        };
        Ok(Constraint {
            name: name.trim().to_owned(),
            at_most,
            limit: f64::NAN,
            text: limit.trim().to_owned(),
        })
    }

    /// With its limit in the unit of the quantity.
    fn resolved(mut self, unit: &str) -> Result<Constraint, StudyError> {
        let wrong = |why: String| StudyError::new(format!("--constraint {}: {why}", self.name));
        let (number, given) = units::split(&self.text)
            .ok_or_else(|| wrong(format!("{} is not a number in {unit}", self.text)))?;
        self.limit = match given {
            "" => {
                if unit != "1" {
                    self.text += &format!(" {unit}");
                }
                number
            }
            given => units::conversion(given, unit, false).map_err(|e| wrong(e.to_string()))?.of(number),
        };
        Ok(self)
    }

    fn holds(&self, value: f64) -> bool {
        if self.at_most { value <= self.limit } else { value >= self.limit }
    }

    /// In words.
    pub fn words(&self) -> String {
        format!("{} {} {}", self.name, if self.at_most { "<=" } else { ">=" }, self.text)
    }
}

/// What a sweep is to find.
#[derive(Clone, Debug, Default)]
pub struct Goal {
    /// The objectives, `NAME`, `NAME:min` or `NAME:max`; the first decides which point is the best.
    pub objectives: Vec<String>,
    /// What the points have to keep.
    pub constraints: Vec<Constraint>,
}

impl Goal {
    /// One objective without constraints.
    pub fn of(objective: &str) -> Goal {
        Goal { objectives: vec![objective.to_owned()], constraints: Vec::new() }
    }
}

/// A point of the grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Values of the varied variables, in order.
    pub values: Vec<Choice>,
    /// The first objective, where the point is feasible.
    pub objective: Option<f64>,
    /// All objectives, where the point is feasible.
    pub objectives: Vec<f64>,
    /// Whether the point is in the Pareto set.
    pub pareto: bool,
    /// Why it is infeasible.
    pub failure: Option<String>,
}

/// A finished sweep.
#[derive(Clone, Debug, Serialize)]
pub struct Sweep {
    /// Names of the varied variables.
    pub varied: Vec<String>,
    /// Their units.
    pub units: Vec<&'static str>,
    /// The units in which their values are shown.
    #[serde(skip)]
    pub shown: Vec<Shown>,
    /// What they are, for the axis of a figure.
    #[serde(skip)]
    pub meanings: Vec<Option<&'static str>>,
    /// Name of the first objective.
    pub objective: String,
    /// Its unit.
    pub objective_unit: &'static str,
    /// All objectives.
    pub objectives: Vec<Target>,
    /// What the points have to keep.
    pub constraints: Vec<Constraint>,
    /// All points; the last variable runs fastest.
    pub points: Vec<Point>,
    /// The best point.
    pub best: Option<Point>,
    /// The variables whose best value is at an end of the range.
    pub best_at_edge: Vec<Edge>,
    /// Number of infeasible points; each names its reason.
    pub infeasible: usize,
    /// Source of the measured data, for a load.
    pub source: Option<String>,
}

/// Runs the sweep; `progress` is called with the number of finished points, from several threads.
///
/// # Errors
/// No grid, a variable or a value that the model does not take, or no feasible point.
pub fn sweep(
    case: &dyn Case,
    vary: &[Vary],
    goal: &Goal,
    progress: impl Fn(usize) + Sync,
) -> Result<Sweep, StudyError> {
    let of = |option: &str, text: &str, target: Result<Target, StudyError>| {
        target.map_err(|e| StudyError::new(format!("--{option} {text}: {e}")))
    };
    let objective = |text: &String| of("objective", text, Target::objective(case, text));
    let objectives = goal.objectives.iter().map(objective).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = objectives.first().cloned() else {
        return Err(StudyError::new("a sweep has an objective"));
    };
    let mut targets = objectives.clone();
    let mut constraints = Vec::new();
    for constraint in &goal.constraints {
        let target = of("constraint", &constraint.name, case.target(&constraint.name))?;
        constraints.push(constraint.clone().resolved(target.unit)?);
        targets.push(target);
    }
    let count = count(vary);
    if vary.is_empty() || count > MAX_POINTS {
        return Err(StudyError::new(format!("--vary makes {count} points; 1 ... {MAX_POINTS} are possible")));
    }
    check(case, vary)?;
    let done = AtomicUsize::new(0);
    let at = |k: usize, known: &mut Known| {
        let values = grid_point(vary, k);
        let sets: Vec<(&str, &Choice)> =
            vary.iter().zip(&values).map(|(v, value)| (v.name.as_str(), value)).collect();
        let found = case
            .at(&sets, &targets, known)
            .and_then(|found| feasible(found, objectives.len(), &constraints, &targets));
        progress(done.fetch_add(1, Ordering::Relaxed) + 1);
        let failure = found.as_ref().err().map(ToString::to_string);
        let found = found.unwrap_or_default();
        Point { values, objective: found.first().copied(), objectives: found, pareto: false, failure }
    };
    let length = (count / ROWS).clamp(1, ROW);
    let row = |r: usize| {
        let (mut known, at) = (Known::default(), &at);
        (r * length..count.min((r + 1) * length)).map(move |k| at(k, &mut known))
    };
    let mut points: Vec<Point> = (0..count.div_ceil(length)).into_par_iter().flat_map_iter(row).collect();
    mark_pareto(&mut points, &objectives);
    let better = |a: &f64, b: &f64| if first.least_is_best { b.total_cmp(a) } else { a.total_cmp(b) };
    let best = points
        .iter()
        .filter_map(|p| p.objective.map(|o| (o, p)))
        .max_by(|a, b| better(&a.0, &b.0))
        .map(|(_, p)| p.clone());
    if best.is_none() {
        let why = points.first().and_then(|p| p.failure.clone()).unwrap_or_default();
        return Err(StudyError::new(format!("no point of the sweep has a result: {why}")));
    }
    let units = vary.iter().map(|v| case.unit(&v.name)).collect::<Result<Vec<_>, _>>()?;
    let shown = |(v, unit): (&Vary, &&str)| v.shown.clone().unwrap_or_else(|| Shown::si(unit));
    Ok(Sweep {
        varied: vary.iter().map(|v| v.name.clone()).collect(),
        shown: vary.iter().zip(&units).map(shown).collect(),
        units,
        meanings: vary.iter().map(|v| case.meaning(&v.name)).collect(),
        objective: first.name,
        objective_unit: first.unit,
        objectives,
        constraints,
        best_at_edge: best.as_ref().map_or(Vec::new(), |point| open_edges(case, vary, point, &points)),
        infeasible: points.iter().filter(|p| p.objective.is_none()).count(),
        source: case.source()?,
        points,
        best,
    })
}

/// The objectives of a point that keeps the constraints.
fn feasible(
    found: Vec<f64>,
    objectives: usize,
    constraints: &[Constraint],
    targets: &[Target],
) -> Result<Vec<f64>, StudyError> {
    for ((constraint, value), target) in
        constraints.iter().zip(&found[objectives..]).zip(&targets[objectives..])
    {
        if !constraint.holds(*value) {
            let shown = target.shown();
            return Err(StudyError::new(format!(
                "{} = {}{} does not keep {}",
                constraint.name,
                present::number(shown.of(*value)),
                shown.unit(" "),
                constraint.words()
            )));
        }
    }
    Ok(found[..objectives].to_vec())
}

/// Marks the feasible points that no other is at least as good as in all objectives and better in one.
fn mark_pareto(points: &mut [Point], objectives: &[Target]) {
    let cost = |p: &Point| -> Vec<f64> {
        p.objectives.iter().zip(objectives).map(|(o, t)| if t.least_is_best { *o } else { -o }).collect()
    };
    let costs: Vec<Vec<f64>> = points.iter().map(cost).collect();
    let dominates = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a <= b) && a.iter().zip(b).any(|(a, b)| a < b)
    };
    for k in 0..points.len() {
        points[k].pareto =
            points[k].objective.is_some() && !costs.iter().any(|other| dominates(other, &costs[k]));
    }
}

/// Every word and both ends of every range are valid values, checked before anything runs.
fn check(case: &dyn Case, vary: &[Vary]) -> Result<(), StudyError> {
    for (k, v) in vary.iter().enumerate() {
        if vary[..k].iter().any(|other| other.name == v.name) {
            return Err(StudyError::new(format!("--vary names {} twice", v.name)));
        }
        case.unit(&v.name)?;
        let ends = [v.values.first(), v.values.last()].into_iter().flatten();
        for value in v.values.iter().filter(|value| value.number().is_none()).chain(ends) {
            case.takes(&v.name, value).map_err(|e| StudyError::new(format!("--vary {}: {e}", v.name)))?;
        }
    }
    Ok(())
}

/// Number of points.
pub fn count(vary: &[Vary]) -> usize {
    vary.iter().map(|v| v.values.len()).fold(1, usize::saturating_mul)
}

/// The values of point `k`; the last variable runs fastest.
fn grid_point(vary: &[Vary], k: usize) -> Vec<Choice> {
    let mut rest = k;
    let mut values: Vec<Choice> = vary
        .iter()
        .rev()
        .map(|v| {
            let value = v.values[rest % v.values.len()].clone();
            rest /= v.values.len();
            value
        })
        .collect();
    values.reverse();
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::steady::Setup;

    fn constant(sets: &[(&str, &str)]) -> ConstantInputs {
        ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, sets) }
    }

    fn run(case: &ConstantInputs, objective: &str, grid: &[Vary]) -> Result<Sweep, StudyError> {
        sweep(case, grid, &Goal::of(objective), |_| {})
    }

    fn numbers(values: &[f64]) -> Vec<Choice> {
        values.iter().copied().map(Choice::Number).collect()
    }

    fn vary(texts: &[&str]) -> Vec<Vary> {
        texts.iter().map(|t| Vary::parse(t).unwrap()).collect()
    }

    /// The grid runs in order, the winding is coldest with most fan and least ambient: by hand at each point.
    #[test]
    fn a_grid_of_two() {
        let grid = vary(&["ambient_temperature=290:300:2", "fan_command=0:1:3"]);
        let case = constant(&[("electrical_power", "10")]);
        let found = run(&case, "winding_temperature", &grid).unwrap();
        assert_eq!(found.points.len(), 6);
        assert_eq!(found.points[1].values, numbers(&[290.0, 0.5]));
        for point in &found.points {
            let at = |k: usize| point.values[k].number().unwrap();
            let g = 0.1351 + 0.113 * f64::powf(at(1), 0.8);
            let by_hand = at(0) + 10.0 * (0.21 + 1.0 / g);
            assert!((point.objective.unwrap() - by_hand).abs() < 1e-3, "{point:?} instead of {by_hand}");
        }
        assert_eq!(found.best.as_ref().unwrap().values, numbers(&[290.0, 1.0]));
        let edge = |name: &str, value, end| Edge { name: name.into(), value, end };
        // A command of 1 is its limit: nothing lies behind.
        assert_eq!(found.best_at_edge, [edge("ambient_temperature", 290.0, "lower")]);
        // All points are equally good.
        let flat = run(&case, "power_electrical", &vary(&["ambient_temperature=290:300:2"])).unwrap();
        assert!(flat.best_at_edge.is_empty(), "{flat:?}");
        assert_eq!(found.csv().lines().count(), 7);
        let figure = found.figure().unwrap().svg();
        assert!(figure.contains("fan command") && !figure.contains("fan_command"));
    }

    #[test]
    fn an_infeasible_point_has_its_reason_and_the_sweep_goes_on() {
        let fixed = constant(&[("drive_mode", "current")]);
        let found = run(&fixed, "winding_temperature", &vary(&["current_command=1:20:2"])).unwrap();
        assert!(found.points[1].objective.is_none() && found.points[1].failure.is_some());
        assert_eq!((found.infeasible, found.best_at_edge.len()), (1, 1));
        // An optimum between the ends is at no edge, nor is a range of one value.
        let inside = run(&constant(&[]), "power_electrical", &vary(&["voltage=1:1:1"])).unwrap();
        assert!(inside.best_at_edge.is_empty());
        assert_eq!(found.best.as_ref().unwrap().values, numbers(&[1.0]));
        assert!(found.csv().ends_with(",\n"));
    }

    #[test]
    fn bad_input_is_one_sentence() {
        for (text, word) in [
            ("x", "no ="),
            ("x=1:2", "three numbers"),
            ("x=1,,2", "missing"),
            ("x=", "missing"),
            ("x=1:b:3", "b is not"),
            ("x=1:2:0", "0 points"),
            ("x=1:2:2.5", "2.5"),
            ("=1:2:3", "no name"),
        ] {
            let error = Vary::parse(text).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("--vary"), "{error}");
        }
        let refused = |grid: &[&str], objective: &str| {
            run(&constant(&[]), objective, &vary(grid)).unwrap_err().to_string()
        };
        assert!(
            refused(&["fan_command=0:2:3"], "current")
                .contains("fan_command = 2 is outside its limits 0 ... 1")
        );
        assert!(refused(&["fan_comand=0:1:3"], "current").contains("did you mean fan_command?"));
        assert!(
            refused(&["fan_command=0:1:3"], "fan_command")
                .contains("--objective fan_command: it is no output")
        );
        assert!(
            refused(&["fan_command=0:1:3"], "Continuous_torque").contains("did you mean continuous_torque?")
        );
        assert!(refused(&["fan_command=0:1:3"], "continuous_support").contains("only with --load"));
        assert!(!refused(&["fan_command=0:1:3"], "").contains("did you mean"));
        let goal = Goal {
            objectives: vec!["current".into()],
            constraints: vec![Constraint::parse("fan_command<=0.5").unwrap()],
        };
        let error =
            sweep(&constant(&[]), &vary(&["fan_command=0:1:3"]), &goal, |_| {}).unwrap_err().to_string();
        assert!(error.starts_with("--constraint fan_command: it is no output"), "{error}");
        assert!(refused(&["cooling_mode=bare,steam"], "current").contains("steam"));
        assert!(refused(&["fan_command=0:1:2", "fan_command=0:1:2"], "current").contains("twice"));
        assert!(refused(&[], "current").contains("--vary"));
    }

    /// Items, presets and units as values; each point is the same as with these values alone.
    #[test]
    fn modes_and_motors_are_varied() {
        let grid = vary(&[
            "preset=maxon-305015,maxon-re40-148877",
            "cooling_mode=conductance,bare,annulus_push",
            "imposed_speed=0,3000 rpm",
        ]);
        // One steady state a point; the continuous torque needs a search.
        let always = [("fan_command", "1"), ("air_segments", "1"), ("current_command", "1")];
        let case = constant(&always);
        let found = run(&case, "winding_temperature", &grid).unwrap();
        assert_eq!(found.points.len(), 2 * 3 * 2);
        for point in &found.points {
            let [preset, mode, speed] = [0, 1, 2].map(|k| point.values[k].text());
            let chosen = [("cooling_mode", mode.as_str()), ("imposed_speed", speed.as_str())];
            let sets = [&always[..], &chosen].concat();
            let setup = Setup::new("AnnulusCooledMotor", describe::Preset::load(&preset).ok(), &sets);
            let alone = crate::steady::steady(&mut setup.bench().unwrap()).ok();
            assert_eq!(point.objective, alone.and_then(|s| s.get("winding_temperature")), "{point:?}");
            // The annulus of 40 mm does not pass the RE 40.
            let misfit = preset.ends_with("148877") && mode == "annulus_push";
            assert_eq!(point.failure.is_some(), misfit, "{point:?}");
        }
        assert!(found.csv().contains("maxon-re40-148877,bare,3000 rpm,"));
        for figure in [found.figure().unwrap().svg(), {
            let two = run(&case, "winding_temperature", &grid[..2]).unwrap();
            two.figure().unwrap().svg()
        }] {
            assert!(figure.contains("maxon-re40-148877") && figure.contains("bare"));
            assert!(!figure.contains("rpm rad/s"));
        }
        check_figure(&grid).unwrap();
        let many = vary(&["fan_command=0:1:3", "imposed_speed=0:100:9"]);
        assert!(check_figure(&many).unwrap_err().to_string().contains("9, at most 8"));
        let unknown =
            run(&case, "continuous_torque", &vary(&["preset=maxon-305016"])).unwrap_err().to_string();
        assert!(unknown.contains("did you mean maxon-305015?"), "{unknown}");
    }

    /// More torque needs more power: with both objectives every fan command is in the Pareto set, unless a constraint forbids it.
    #[test]
    fn the_pareto_set_has_what_nothing_beats() {
        let case = constant(&[("current_command", "5")]);
        let grid = vary(&["current_command=1:5:5", "fan_command=0:1:2"]);
        let goal = Goal {
            objectives: vec!["shaft_torque".into(), "winding_temperature".into()],
            constraints: vec![Constraint::parse("winding_temperature <= 70 degC").unwrap()],
        };
        let found = sweep(&case, &grid, &goal, |_| {}).unwrap();
        assert!((found.constraints[0].limit - 343.15).abs() < 1e-9);
        for point in &found.points {
            let temperature = {
                let sets = grid.iter().zip(&point.values).map(|(v, c)| (v.name.clone(), c.text())).collect();
                let mut bench = Setup { sets, ..case.setup.clone() }.bench().unwrap();
                crate::steady::steady(&mut bench).unwrap().get("winding_temperature").unwrap()
            };
            assert_eq!(point.failure.is_none(), temperature <= 343.15, "{point:?} {temperature}");
            let beaten = found.points.iter().any(|o| {
                !o.objectives.is_empty()
                    && !point.objectives.is_empty()
                    && o.objectives[0] >= point.objectives[0]
                    && o.objectives[1] <= point.objectives[1]
                    && o != point
            });
            assert_eq!(point.pareto, point.failure.is_none() && !beaten, "{point:?}");
        }
        assert!(found.infeasible > 0 && found.points.iter().filter(|p| p.pareto).count() > 2, "{found:?}");
        for (text, words) in [
            ("winding_temperature < 3", "<="),
            ("winding_temperature<=3 V", "not a unit"),
            ("winding_temperature<=x", "not a number"),
        ] {
            let goal = Constraint::parse(text)
                .map(|c| Goal { objectives: vec!["shaft_torque".into()], constraints: vec![c] });
            let error = goal.and_then(|goal| sweep(&case, &grid, &goal, |_| {})).unwrap_err().to_string();
            assert!(error.contains(words) && error.contains("--constraint"), "{error}");
        }
    }
}
