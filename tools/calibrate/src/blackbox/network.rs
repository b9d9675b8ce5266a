//! Network of two thermal nodes with all parameters free.
//!
//! C_1 T_1' = q_1 - (T_1 - T_2) / R
//! C_2 T_2' = q_2 + (T_1 - T_2) / R - (g_0 + sum_k g_k |u_k|) (T_2 - T_a)                             (1)
//! q_1 = sum_k a_k u_k^2 [1 + alpha (T_1 - T_0)] + b_k |u_k|,   q_2 = sum_k c_k u_k^2 + d_k |u_k|         (2)
//!
//! u are the inputs divided by their largest magnitude. The temperature factor in (2) applies to currents only; alpha is that of copper.
//! A sensor between the nodes indicates w T_1 + (1 - w) T_2. All parameters are positive and are estimated as logarithms.
//! Time steps use the trapezoidal rule, which is stable for any row spacing.

use super::{Candidate, Series};
use crate::CalibrateError;
use crate::deadline::Deadline;
use crate::experiment::{Experiment, Role};
use crate::parallel;
use least_squares::{Options, Problem, minimise};
use nalgebra::{DMatrix, DVector};
use physics::declare::Unit;

/// Temperature coefficient of copper, 1/K, at [`T_0`]. Source: IEC 60028, 0.00393 / K at 20 degC; a black box needs no third digit.
const ALPHA: f64 = 0.0039;
/// Temperature of [`ALPHA`], K. Definition: 25 degC.
const T_0: f64 = 298.15;
/// Residual of a logarithm that deviates from its start by 1, in units of the error. Numerical: regularizes what the data do not
/// determine.
const HELD: f64 = 1e-3;
/// Largest deviation of a logarithm from its start. Numerical: a factor of 8000.
const FAR: f64 = 9.0;
/// Starts of the fit: time constants of the second node, s, and ratios of the heat capacities. Numerical: starts of a fit.
const STARTS: [(f64, f64); 4] = [(300.0, 0.05), (1000.0, 0.05), (3000.0, 0.05), (1000.0, 0.3)];
/// Start of the resistance between the nodes, K/W, and of the conductances g_k, W/K, with g_0 = 1 W/K. Numerical: starts of a fit.
const LINKS: (f64, f64) = (0.2, 0.1);
/// Least size of a temperature rise, K. Numerical: avoids a division by zero.
const LEAST_RISE: f64 = 0.1;
/// Options of the fit. Numerical: a step that reduces the squares by less than 1e-4 of their sum is the last.
const OPTIONS: Options = Options {
    damping: 1e-2,
    linearisations: 25,
    chords: 2,
    relative_decrease: 1e-4,
    decrease: 0.0,
    step: 1e-6,
    gradient: 1e-6,
    curved: false,
    rival: f64::INFINITY,
};
/// Options of the fit from each start; the fit continues from the best one. Numerical: five iterations separate the starts.
const FIRST: Options = Options { linearisations: 5, ..OPTIONS };

/// The network that best fits all measured temperatures of the motor, for each output; `None` for outputs that are no temperatures.
pub fn candidates(experiment: &Experiment, all: &[Series], deadline: &Deadline) -> Vec<Option<Candidate>> {
    let outputs: Vec<usize> = (0..experiment.outputs.len())
        .filter(|k| experiment.outputs[*k].node().is_some())
        .filter(|k| all.iter().any(|s| s.role == Role::Fit && s.outputs[*k].iter().any(|y| y.is_finite())))
        .collect();
    let mut found: Vec<Option<Candidate>> = experiment.outputs.iter().map(|_| None).collect();
    let Some(fit) = Fit::new(experiment, all, outputs, deadline) else { return found };
    let run = |x: DVector<f64>, start: DVector<f64>, options: &Options| {
        let limits: Vec<(f64, f64)> = start.iter().map(|v| (v - FAR, v + FAR)).collect();
        let held = Held { fit: &fit, start };
        let found = minimise(&held, x, &limits, options).ok()?;
        Some((held.cost(&found.point), found.x))
    };
    let begun = parallel::flat_map(&STARTS, |start| {
        let start = fit.start(*start);
        Some((run(start.clone(), start.clone(), &FIRST)?, start))
    });
    let Some(((_, x), start)) = begun.into_iter().min_by(|a, b| a.0.0.total_cmp(&b.0.0)) else {
        return found;
    };
    let Some((_, x)) = run(x, start, &OPTIONS) else { return found };
    let predicted: Vec<Vec<Vec<f64>>> = all.iter().map(|run| fit.simulated(run, &x)).collect();
    for (n, output) in fit.outputs.iter().enumerate() {
        found[*output] = Some(Candidate {
            kind: "two-node RC network with free parameters".to_string(),
            predicted: predicted.iter().map(|columns| columns[n].clone()).collect(),
            parameters: x.len(),
        });
    }
    found
}

struct Fit<'a> {
    all: &'a [Series],
    outputs: Vec<usize>,
    /// Position of each sensor: first node, second node, or between them (index of the weight).
    places: Vec<Place>,
    /// Standard deviation of each output over the fit runs.
    sizes: Vec<f64>,
    /// Which inputs are currents.
    is_current: Vec<bool>,
    deadline: &'a Deadline,
}

#[derive(Clone, Copy)]
enum Place {
    First,
    Second,
    Between(usize),
}

/// Outputs of the two nodes.
const WINDING: &str = "winding_temperature";
const HOUSING: &str = "housing_temperature";
/// Number of common parameters C_1, C_2, R, g_0, which precede those of each input. Definition: of (1).
const COMMON: usize = 4;
/// Number of parameters a, b, c, d, g of each input. Definition: of (1) and (2).
const OWN: usize = 5;

impl<'a> Fit<'a> {
    fn new(
        experiment: &Experiment,
        all: &'a [Series],
        outputs: Vec<usize>,
        deadline: &'a Deadline,
    ) -> Option<Fit<'a>> {
        let used: Vec<bool> = experiment
            .inputs
            .iter()
            .filter(|c| !c.is_temperature() && c.unit != Unit::Pascal)
            .map(|c| c.unit == Unit::Ampere)
            .collect();
        let mut weights = 0;
        let node = |k: &usize| experiment.outputs[*k].node();
        let has_winding = outputs.iter().any(|k| node(k) == Some(WINDING));
        let has_housing = outputs.iter().any(|k| node(k) == Some(HOUSING));
        let places = outputs.iter().map(|k| match node(k) {
            Some(WINDING) => Place::First,
            Some(HOUSING) => Place::Second,
            _ if !has_winding && !has_housing && outputs.len() == 1 => Place::Second,
            _ => {
                weights += 1;
                Place::Between(COMMON + OWN * used.len() + weights - 1)
            }
        });
        let places: Vec<Place> = places.collect();
        let sizes = outputs.iter().map(|k| {
            let fit = || all.iter().filter(|s| s.role == Role::Fit);
            let rise = || {
                fit()
                    .flat_map(|s| s.outputs[*k].iter().zip(&s.ambient).map(|(y, a)| y - a))
                    .filter(|x| x.is_finite())
            };
            (rise().map(|x| x * x).sum::<f64>() / rise().count() as f64).sqrt().max(LEAST_RISE)
        });
        let sizes = sizes.collect();
        (!outputs.is_empty()).then_some(Fit { all, outputs, places, sizes, is_current: used, deadline })
    }

    /// Initial logarithms: losses scaled to the measured mean temperature rise.
    fn start(&self, (tau, ratio): (f64, f64)) -> DVector<f64> {
        let inputs = self.is_current.len();
        let weights = self.places.iter().filter(|p| matches!(p, Place::Between(_))).count();
        let rise = self.sizes.iter().fold(0.0, |a: f64, b| a.max(*b));
        let heat = (rise / (4.0 * inputs.max(1) as f64)).ln();
        let mut x = DVector::from_element(COMMON + OWN * inputs + weights, 0.0);
        // A common scale of the powers is not identifiable: g_0 starts at 1 W/K.
        (x[0], x[1], x[2]) = ((ratio * tau).ln(), tau.ln(), LINKS.0.ln());
        for k in 0..inputs {
            for j in 0..4 {
                x[COMMON + OWN * k + j] = heat - if j == 0 { 0.0 } else { 2.0 };
            }
            x[COMMON + OWN * k + 4] = LINKS.1.ln();
        }
        x
    }

    /// The outputs of a run at its rows.
    fn simulated(&self, run: &Series, x: &DVector<f64>) -> Vec<Vec<f64>> {
        let e: Vec<f64> = x.iter().map(|v| v.exp()).collect();
        // A logistic weight between 0 and 1.
        let weight = |k: usize| e[k] / (1.0 + e[k]);
        let indicated = |place: &Place, t: [f64; 2]| match place {
            Place::First => t[0],
            Place::Second => t[1],
            Place::Between(k) => weight(*k) * t[0] + (1.0 - weight(*k)) * t[1],
        };
        let rows = run.time.len();
        let mut shown = vec![Vec::with_capacity(rows); self.outputs.len()];
        let mut t = self.first(run);
        // Right-hand side of (1) as A T + b, by row.
        let system = |row: usize| {
            let (mut q1, mut slope, mut q2, mut g) = (0.0, 0.0, 0.0, e[3]);
            for (k, input) in run.inputs.iter().enumerate() {
                let (u, at) = (input[row].abs(), COMMON + OWN * k);
                q1 += e[at] * u * u + e[at + 1] * u;
                q2 += e[at + 2] * u * u + e[at + 3] * u;
                g += e[at + 4] * u;
                if self.is_current[k] {
                    slope += e[at] * u * u * ALPHA;
                    q1 -= e[at] * u * u * ALPHA * T_0;
                }
            }
            let (c1, c2, link) = (e[0], e[1], 1.0 / e[2]);
            let a = [[(slope - link) / c1, link / c1], [link / c2, -(link + g) / c2]];
            (a, [q1 / c1, (q2 + g * run.ambient[row]) / c2])
        };
        let mut here = system(0);
        for row in 0..rows {
            for (column, place) in shown.iter_mut().zip(&self.places) {
                column.push(indicated(place, t));
            }
            if row + 1 == rows {
                break;
            }
            let next = system(row + 1);
            let half = 0.5 * (run.time[row + 1] - run.time[row]);
            let right: [f64; 2] = std::array::from_fn(|j| {
                t[j] + half * (here.0[j][0] * t[0] + here.0[j][1] * t[1] + here.1[j] + next.1[j])
            });
            let m: [[f64; 2]; 2] = std::array::from_fn(|j| {
                std::array::from_fn(|k| f64::from(u8::from(j == k)) - half * next.0[j][k])
            });
            let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
            t = [
                (right[0] * m[1][1] - m[0][1] * right[1]) / determinant,
                (m[0][0] * right[1] - m[1][0] * right[0]) / determinant,
            ];
            here = next;
        }
        shown
    }

    /// Temperatures of both nodes at the start of a run.
    fn first(&self, run: &Series) -> [f64; 2] {
        let mut t = [run.ambient[0]; 2];
        if run.is_warm {
            let reading = |n: usize| run.outputs[self.outputs[n]].iter().copied().find(|y| y.is_finite());
            let known: Vec<(Place, f64)> =
                self.places.iter().enumerate().filter_map(|(n, p)| Some((*p, reading(n)?))).collect();
            let any = known.first().map(|(_, y)| *y);
            let of =
                |wanted: fn(&Place) -> bool| known.iter().find(|(p, _)| wanted(p)).map(|(_, y)| *y).or(any);
            t[0] = of(|p| matches!(p, Place::First)).unwrap_or(t[0]);
            t[1] = of(|p| matches!(p, Place::Second)).unwrap_or(t[1]);
        }
        t
    }

    /// Residuals over the evaluated rows of the fit runs, divided by the output's deviation and the root of its number of readings.
    fn residuals(&self, x: &DVector<f64>) -> Vec<f64> {
        let mut all = Vec::new();
        let mut counts = vec![0usize; self.outputs.len()];
        let fit: Vec<&Series> = self.all.iter().filter(|s| s.role == Role::Fit).collect();
        for (n, output) in self.outputs.iter().enumerate() {
            let there = |s: &&Series| {
                s.outputs[*output].iter().zip(&s.counts).filter(|(y, c)| **c && y.is_finite()).count()
            };
            counts[n] = fit.iter().map(there).sum();
        }
        for run in fit {
            for (n, shown) in self.simulated(run, x).iter().enumerate() {
                let scale = self.sizes[n] * (counts[n] as f64).sqrt();
                let rows = run.outputs[self.outputs[n]].iter().zip(shown).zip(&run.counts);
                all.extend(
                    rows.filter(|((y, _), c)| **c && y.is_finite()).map(|((y, p), _)| (y - p) / scale),
                );
            }
        }
        all
    }
}

/// The fit with its logarithms regularized towards their start.
struct Held<'a> {
    fit: &'a Fit<'a>,
    start: DVector<f64>,
}

impl Held<'_> {
    fn all(&self, x: &DVector<f64>) -> DVector<f64> {
        let mut all = self.fit.residuals(x);
        all.extend(x.iter().zip(&self.start).map(|(x, s)| HELD * (x - s)));
        DVector::from_vec(all)
    }
}

impl Problem for Held<'_> {
    type Point = DVector<f64>;
    type Slopes = DMatrix<f64>;
    type Error = CalibrateError;

    fn evaluate(&self, x: &DVector<f64>) -> Result<DVector<f64>, CalibrateError> {
        let all = self.all(x);
        if all.iter().all(|r| r.is_finite()) {
            Ok(all)
        } else {
            Err(CalibrateError("the network has no finite temperatures".to_string()))
        }
    }

    fn cost(&self, point: &DVector<f64>) -> f64 {
        point.norm_squared()
    }

    fn linearise(&self, x: &DVector<f64>, point: &DVector<f64>) -> Result<DMatrix<f64>, CalibrateError> {
        /// Change of a logarithm for its sensitivity. Numerical: half of the digits remain in the difference.
        const WAY: f64 = 1e-4;
        let columns = parallel::indices(x.len(), |k| {
            let mut aside = x.clone();
            aside[k] += WAY;
            (self.all(&aside) - point) / WAY
        });
        Ok(DMatrix::from_columns(&columns))
    }

    fn information(&self, slopes: &DMatrix<f64>) -> DMatrix<f64> {
        slopes.tr_mul(slopes)
    }

    fn gradient(&self, _: &DVector<f64>, point: &DVector<f64>, slopes: &DMatrix<f64>) -> DVector<f64> {
        slopes.tr_mul(point)
    }

    fn stop(&self) -> bool {
        self.fit.deadline.is_near()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blackbox::black_boxes;
    use crate::outcome::BlackBox;
    use crate::setup::Setup;
    use crate::testing;

    /// The network reproduces a run of a two-node motor to some hundredths of a kelvin, at constant and at varying ambient
    /// temperature.
    #[test]
    fn two_nodes_follow_two_nodes() {
        let mut experiment = testing::experiment("\"thermal.C_w\" = 0.1", true);
        let truth = Setup::new(&experiment, &[]).unwrap().preset().declared;
        testing::read(&mut experiment, &truth, None);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let boxes = black_boxes(&setup, &Deadline::default());
        assert_eq!(boxes.len(), 4, "{boxes:?}");
        let of = |column: &str| -> &BlackBox { boxes.iter().find(|b| b.column == column).unwrap() };
        for column in ["winding_temperature_degC", "housing_temperature_degC"] {
            let all = super::super::series(&setup);
            let found = candidates(&experiment, &all, &Deadline::default());
            let output = experiment.outputs.iter().position(|c| c.column == column).unwrap();
            let network = found[output].as_ref().unwrap();
            let (error, _) = super::super::rmse(&all, output, network, Role::Fit).unwrap();
            assert!(error < 0.15, "{column}: {error}");
            assert!(of(column).errors.iter().all(|(_, e)| *e <= 0.15), "{:?}", of(column));
        }
        // A voltage is a function of current, speed and temperature, so a static model has a small error.
        assert!(of("voltage_V").errors[0].1 < 0.3, "{:?}", of("voltage_V"));
    }
}
