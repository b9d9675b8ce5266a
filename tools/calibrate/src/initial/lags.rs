//! The lags of terms at the start of a run: unknowns of eq. (1) beside the temperatures.
//!
//! The response to a temperature is the same at any temperature; a law of a lag may rise and fall, and is constant where its driver begins
//! outside. Its start is therefore first tried at values over the range of the law, each with the temperatures that suit it best, and then
//! improved by Gauss-Newton steps as long as they explain more. A start stays within the range of the law.
//! *Source*: separable least squares, Golub, Pereyra, SIAM J. Numer. Anal. 10 (1973) 413-432.

use super::{Estimate, Shown, Starts, differences};
use crate::CalibrateError;
use crate::overrides::Override;
use crate::simulate::{Bench, Drive};
use physics::model::{Declaration, Slot};
use physics::terms::Lag;

/// e of (1) for a lag, in units of the span of its start. Derivation: the noise of a thermometer, 0.05 K, where nothing in the span is
/// preferred.
pub(super) const RIDGE: f64 = 0.05;
/// Perturbation of a start, relative to its span. Numerical: a law of some points is a line over it.
const WAY: f64 = 0.01;
/// Values that are tried over the span. Numerical: as many as a table has points at first.
const TRIED: usize = 5;
/// Gauss-Newton steps at most. Numerical: a law that is linear in its lag needs one.
const STEPS: usize = 3;

/// What is known of the start of a lag.
#[derive(Clone, Copy)]
pub(super) struct Start {
    lag: Lag,
    /// Range of the law, in the unit of the driver, where it has one.
    range: Option<(f64, f64)>,
}

impl Start {
    /// Those of a change, in the order of [`Override::lags`].
    fn all(change: &Override) -> impl Iterator<Item = Start> + '_ {
        change.lags().map(|(place, lag)| {
            let law = &change.terms[place].law;
            let own = law.ranges().find(|(driver, _)| *driver == lag.driver).map(|(_, range)| range);
            let range =
                own.filter(|(least, most)| !lag.difference && least < most && (most - least).is_finite());
            Start { lag, range }
        })
    }

    /// Span of the unknown, which is relative to a typical change of the driver.
    fn span(&self) -> f64 {
        self.range.map_or(1.0, |(least, most)| (most - least) / self.lag.driver.nominal())
    }

    /// The nearest start within the range of the law; `at` is the initial value of the driver.
    fn within(&self, at: f64, value: f64) -> f64 {
        let size = self.lag.driver.nominal();
        let limited = |(least, most): (f64, f64)| {
            // A driver may itself begin outside.
            let (least, most) = ((least - at) / size, (most - at) / size);
            value.clamp(least.min(0.0), most.max(0.0))
        };
        self.range.map_or(value, limited)
    }

    /// The values that are tried.
    fn tried(&self, at: f64) -> impl Iterator<Item = f64> {
        let size = self.lag.driver.nominal();
        self.range.into_iter().flat_map(move |(least, most)| {
            let point = move |k: usize| least + (most - least) * k as f64 / (TRIED - 1) as f64;
            (0..TRIED).map(move |k| (point(k) - at) / size)
        })
    }
}

/// Penalties e of (1) of the lags.
pub fn ridges(change: &Override) -> Vec<f64> {
    Start::all(change).map(|start| RIDGE / start.span()).collect()
}

/// Perturbations of the lags.
pub(super) fn ways(change: &Override) -> impl Iterator<Item = f64> + '_ {
    Start::all(change).map(|start| WAY * start.span())
}

/// The initial values of the lags of a change, within their limits.
pub fn values(declaration: &Declaration, change: &Override, unknowns: &[f64]) -> Vec<(Slot, f64)> {
    let start = |((place, _), value): ((usize, Lag), &f64)| {
        let entry = declaration.by_name(&format!("initial.term_lag_{}", place + 1))?;
        Some((entry.slot, value.clamp(entry.row.min, entry.row.max)))
    };
    change.lags().zip(unknowns).filter_map(start).collect()
}

/// A start that was tried.
struct Tried {
    at: Vec<f64>,
    shown: Shown,
    /// What it leaves of (1) with the best temperatures.
    left: f64,
}

impl Bench {
    /// The estimate of temperatures, with that of the lags.
    pub(super) fn with_lags(
        &self,
        drive: &Drive,
        change: &Override,
        nodes: Estimate,
    ) -> Result<Estimate, CalibrateError> {
        let first = drive.warm.len();
        let columns = &nodes.starts.columns;
        let starts: Vec<Start> = Start::all(change).collect();
        let ridges = ridges(change);
        let drivers = self.begin_at(drive, change, &nodes.at)?.model.drivers();
        let initial = |start: &Start| drivers.of(start.lag.driver);
        let left = |at: &[f64], shown: &Shown| {
            let penalty = at[first..].iter().zip(&ridges).map(|(value, e)| (value * e).powi(2));
            nodes.starts.left(&differences(&nodes.readings, shown, 1.0)) + penalty.sum::<f64>()
        };
        let attempt = |best: &mut Tried, at: Vec<f64>| -> Result<bool, CalibrateError> {
            let Some(shown) = self.shown_at(drive, change, columns, &at)? else { return Ok(false) };
            let left = left(&at, &shown);
            let is_better = left < best.left;
            if is_better {
                *best = Tried { at, shown, left };
            }
            Ok(is_better)
        };
        let mut best =
            Tried { at: nodes.at.clone(), shown: nodes.shown.clone(), left: left(&nodes.at, &nodes.shown) };
        for (k, start) in starts.iter().enumerate() {
            for value in start.tried(initial(start)) {
                let mut at = best.at.clone();
                at[first + k] = value;
                attempt(&mut best, at)?;
            }
        }
        let mut joint = None;
        for _ in 0..STEPS {
            let mut responses = nodes.starts.responses.clone();
            for (k, way) in (first..).zip(ways(change)) {
                let Some(response) =
                    self.start_response(drive, change, columns, (&best.at, &best.shown), (k, way))?
                else {
                    return Ok(nodes);
                };
                responses.push(response);
            }
            let Some(equations) = Starts::new(columns, responses, &ridges) else {
                return Ok(nodes);
            };
            let step = equations.explaining(&differences(&nodes.readings, &best.shown, 1.0));
            joint = Some(equations);
            let mut at = best.at.clone();
            for (k, start) in starts.iter().enumerate() {
                at[first + k] = start.within(initial(start), at[first + k] + step[first + k]);
            }
            let is_near =
                |(k, start): (usize, &Start)| (at[first + k] - best.at[first + k]).abs() < WAY * start.span();
            let is_last = starts.iter().enumerate().all(is_near);
            if !attempt(&mut best, at)? || is_last {
                break;
            }
        }
        let step = nodes.starts.explaining(&differences(&nodes.readings, &best.shown, 1.0));
        let starts = joint.unwrap_or(nodes.starts);
        Ok(Estimate { at: best.at, step, shown: best.shown, starts, readings: nodes.readings })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Experiment, Start as Begin};
    use crate::setup::Setup;
    use crate::testing::{NOISE, with_warm_term};
    use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product, Table};

    fn term(port: Port, driver: Driver, law: Law, tau: f64, difference: bool) -> GenericTerm {
        GenericTerm { lag: Some(Lag { driver, tau, difference }), ..GenericTerm::new(port, law) }
    }

    fn line(driver: Driver, coefficient: f64) -> Law {
        let factor = Factor { driver, offset: 0.0, reference: 1.0, exponent: 1.0, range: Factor::UNLIMITED };
        Law::Product(Product { coefficient, factors: [Some(factor), None, None] })
    }

    fn found(experiment: &Experiment, term: GenericTerm) -> (Vec<f64>, f64) {
        let setup = Setup::new(experiment, &[]).unwrap();
        let change = Override { values: Vec::new(), terms: vec![term] };
        let drive = &setup.drives[0];
        let unknowns = setup.bench.started(drive, &change).unwrap().unknowns;
        let shown = setup.bench.run(drive, &change).unwrap();
        let column = &experiment.runs[0].table.columns[experiment.place_of(3)];
        let worst = shown[3].iter().zip(column).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (unknowns, worst)
    }

    /// A mass that is hotter or colder than the housing, a heat that follows an earlier current, and one that follows an earlier loss.
    #[test]
    fn the_start_of_a_lag_shows_in_the_first_readings() {
        let mass = line(Driver::HousingTemperature, 0.6);
        let heat = line(Driver::CopperLoss, 0.2);
        for (term, above) in [
            (term(Port::HousingHeat, Driver::HousingTemperature, mass, 400.0, true), 0.2),
            (term(Port::HousingHeat, Driver::HousingTemperature, mass, 400.0, true), -0.1),
            (term(Port::HousingHeat, Driver::Current, line(Driver::Current, 0.5), 300.0, false), 2.5),
            (term(Port::WindingHeat, Driver::CopperLoss, heat, 200.0, false), 1.5),
            // Voltage and torque alone show these.
            (term(Port::TorqueConstant, Driver::Speed, line(Driver::Speed, 2e-4), 400.0, false), 2.0),
            (term(Port::TerminalVoltage, Driver::Speed, line(Driver::Speed, 1e-3), 900.0, false), -1.5),
        ] {
            let experiment = with_warm_term("", term, above, NOISE);
            let (unknowns, worst) = found(&experiment, term);
            assert!((unknowns[2] / above - 1.0).abs() < 0.05, "{unknowns:?} for {above}");
            assert!(worst < 0.1, "{worst} K for {above}");
        }
    }

    /// A law that rises and falls: a step from the driver's value would go the wrong way, and end beyond its range.
    #[test]
    fn a_law_that_rises_and_falls_is_searched_over_its_range() {
        let table = Table::new(Driver::Current, &[0.0, 2.0, 4.0, 6.0, 8.0], &[0.0, 2.0, -1.0, 1.0, 5.0]);
        let term = term(Port::HousingHeat, Driver::Current, Law::Table(table.unwrap()), 500.0, false);
        let experiment = with_warm_term("", term, 5.0, 0.01);
        let (unknowns, worst) = found(&experiment, term);
        assert!((unknowns[2] - 5.0).abs() < 0.2 && worst < 0.3, "{unknowns:?}, {worst} K");
        // The driver begins at 3 A; no start is beyond the law, however large the readings.
        let mut hot = experiment.clone();
        let column = hot.place_of(3);
        hot.runs[0].table.columns[column].iter_mut().enumerate().for_each(|(row, t)| *t += 0.5 * row as f64);
        let (unknowns, _) = found(&hot, term);
        assert!(unknowns[2] <= 5.0 + 1e-9, "{unknowns:?}");
    }

    /// The speed begins beyond the law, where it is constant, and the lag within it.
    #[test]
    fn a_driver_that_begins_beyond_the_law_does_not_hold_its_lag_there() {
        let Law::Product(Product { coefficient, factors: [Some(factor), ..] }) = line(Driver::Speed, 5e-3)
        else {
            panic!("a line is a product")
        };
        let factors = [Some(Factor { range: (0.0, 250.0), ..factor }), None, None];
        let law = Law::Product(Product { coefficient, factors });
        let term = term(Port::HousingHeat, Driver::Speed, law, 300.0, false);
        // 300 rad/s at the start, 80 rad/s before.
        let (unknowns, worst) = found(&with_warm_term("", term, -2.2, NOISE), term);
        assert!((unknowns[2] + 2.2).abs() < 0.05 && worst < 0.1, "{unknowns:?}, {worst} K");
    }

    /// A start that is given is no unknown.
    #[test]
    fn a_start_that_is_set_stays() {
        let term = term(Port::HousingHeat, Driver::Current, line(Driver::Current, 0.5), 300.0, false);
        let mut experiment = with_warm_term("", term, 2.5, NOISE);
        experiment.runs[0].set.push(("initial.term_lag_1".to_string(), 0.7));
        let setup = Setup::new(&experiment, &[]).unwrap();
        let change = Override { values: Vec::new(), terms: vec![term] };
        let mut model = setup.bench.begin(&setup.drives[0], &change).unwrap();
        let state = setup.bench.declaration().by_name("state.term_lag[1]").unwrap().slot;
        assert!((model.get(state) - 3.0 - 0.7).abs() < 1e-9, "{}", model.get(state));
    }

    /// A run from ambient temperature starts with its drivers: a motor at rest.
    #[test]
    fn a_cold_run_has_no_unknown() {
        let mass = line(Driver::HousingTemperature, 0.6);
        let term = term(Port::HousingHeat, Driver::HousingTemperature, mass, 400.0, true);
        let mut experiment = with_warm_term("", term, 0.2, NOISE);
        experiment.runs[0].start = Begin::Ambient;
        assert!(found(&experiment, term).0.is_empty());
    }
}
