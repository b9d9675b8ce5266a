//! Candidates that present driver values cannot explain: latent inputs and laws with memory.

use super::{Scored, choice, is_inside, scored};
use crate::evidence::Gain;
use crate::experiment::Channel;
use crate::hypothesis::hat;
use crate::levels::{LEAD, NEARLY};
use crate::linearization::Linearization;
use crate::outcome::Follows;
use nalgebra::DMatrix;
use physics::terms::{Driver, Port};

/// Knots of a latent input in each run. Numerical: its prior correlates neighbouring knots of a run of 1.5 h by 0.68.
const INSTANTS: usize = 24;
/// Suffix of a latent input's name, after its port.
pub(super) const FREE: &str = " free in time";
/// Correlation time of a latent input, s. Tuned: the heat of a motor stores changes of some minutes.
const MEMORY: f64 = 600.0;
/// Quantiles of a driver's readings at which a threshold is tried. Numerical: resolution of 3 % of the readings.
const THRESHOLDS: usize = 32;
/// Widths of a hysteresis that are tried, K. Numerical: the law is reported, not added; a width wrong by a factor of 1.4 hardly changes
/// the switching times.
const WIDTHS: [f64; 3] = [3.0, 6.0, 12.0];
/// Longest period that is tried as a fraction of the longest run, ratio of successive periods, and their number. Numerical:
/// neighbouring periods differ by 13 %.
const PERIODS: (f64, f64, i32) = (0.8, 0.87, 24);

/// Whether a law with memory (latching or switching by a measured quantity) clearly explains more at a point than all memoryless laws.
pub fn needs_memory(scored: &[Scored]) -> bool {
    // A law over time may describe the same effect, so it does not count as memoryless.
    let present =
        scored.iter().filter(|s| !matches!(s.follows, Follows::History | Follows::Driver(Driver::Time)));
    let present = present.map(Scored::sure).fold(0.0, f64::max);
    best_memory_term(scored).is_some_and(|past| past.sure() > present / NEARLY + LEAD)
}

/// Best law with memory (latching, switching or intermittent); `scored` is sorted by decreasing evidence.
pub fn best_memory_term(scored: &[Scored]) -> Option<&Scored> {
    past(scored).find(|s| !s.is_free())
}

/// Latent input at a port.
pub fn latent_input_at(scored: &[Scored], port: Port) -> Option<&Scored> {
    past(scored).find(|s| s.is_free() && s.port == port)
}

fn past(scored: &[Scored]) -> impl Iterator<Item = &Scored> {
    scored.iter().filter(|s| s.follows == Follows::History && !s.listed)
}

/// Clock time of each row of a run.
fn clock<'a>(point: &'a Linearization, r: usize) -> &'a [f64] {
    &point.setup.drives[point.runs[r]].time
}

/// Latent input at a port.
pub struct LatentInput {
    /// Responses to its values at the knots, one column each.
    pub columns: DMatrix<f64>,
    /// Their prior covariance: values at neighbouring knots are correlated.
    pub kernel: DMatrix<f64>,
    /// Times of the knots, s.
    at: Vec<f64>,
}

/// Latent input at a port, as responses and prior covariance.
pub fn latent_input(point: &Linearization, port: Port) -> Option<LatentInput> {
    let mut instants: Vec<(usize, Vec<f64>)> = Vec::new();
    for r in 0..point.runs.len() {
        let time = clock(point, r);
        let (from, to) = (time[0], time[time.len() - 1]);
        let count = INSTANTS.min(time.len()).max(2);
        instants.push((r, (0..count).map(|k| from + (to - from) * k as f64 / (count - 1) as f64).collect()));
    }
    let places: Vec<(usize, usize)> =
        instants.iter().flat_map(|(r, times)| (0..times.len()).map(move |k| (*r, k))).collect();
    let at: Vec<f64> = places.iter().map(|(r, k)| instants[*r].1[*k]).collect();
    let columns = point.port_columns(port, places.len(), |place, r, row, _| {
        let (own, k) = places[place];
        if own == r { hat(&instants[r].1, k, clock(point, r)[row]) } else { 0.0 }
    })?;
    let kernel = DMatrix::from_fn(at.len(), at.len(), |a, b| (-(at[a] - at[b]).abs() / MEMORY).exp());
    Some(LatentInput { columns, kernel, at })
}

pub(super) fn latent_inputs(point: &Linearization, port: Port, per_number: f64) -> Option<Scored> {
    let free = latent_input(point, port)?;
    let gain = point.evidence.shape(&free.columns, &free.kernel)?;
    let name = format!("{}{FREE}", port.name());
    Some(scored(
        name,
        port,
        Follows::History,
        &gain,
        2.0 * per_number + choice(port, Follows::History),
        &free.at,
    ))
}

/// Values of a driver at the rows of each run; for a temperature the readings, where there are any. A switch responds to the motor's true
/// state, not to the prediction of a model without the switch.
fn stood(point: &Linearization, driver: Driver) -> Vec<Vec<f64>> {
    let experiment = point.setup.experiment;
    let sensor = Channel::reading(driver).filter(|c| c.is_temperature());
    let output = sensor.and_then(|s| experiment.outputs.iter().position(|c| c.column == s.column));
    let runs = point.runs.iter().zip(&point.slopes.tangents);
    runs.map(|(run, tangent)| {
        let own = || tangent.drivers.iter().map(|d| d.of(driver));
        let Some(output) = output else { return own().collect() };
        let measured = experiment.readings(*run, output);
        measured.iter().zip(own()).map(|(m, own)| if m.is_finite() { *m } else { own }).collect()
    })
    .collect()
}

/// Laws with memory: latching, switching with hysteresis, intermittent.
pub(super) fn histories(point: &Linearization, port: Port, per_number: f64) -> Vec<Scored> {
    let mut all = Vec::new();
    let mut best = |name: &str, numbers: f64, tried: Vec<(f64, Gain)>| {
        if let Some((at, gain)) = tried.into_iter().max_by(|a, b| a.1.whitened.total_cmp(&b.1.whitened)) {
            let name = format!("{} {name} {at:.4}", port.name());
            let cost = numbers * per_number + choice(port, Follows::History);
            let mut found = scored(name, port, Follows::History, &gain, cost, &[at]);
            found.shape.truncate(1);
            all.push(found);
        }
    };
    for driver in [Driver::WindingTemperature, Driver::HousingTemperature, Driver::Current, Driver::Speed] {
        let stood = stood(point, driver);
        let mut values: Vec<f64> = stood.iter().flatten().copied().collect();
        values.sort_by(f64::total_cmp);
        let thresholds: Vec<f64> =
            (1..THRESHOLDS).map(|k| values[(values.len() - 1) * k / THRESHOLDS]).collect();
        let switched = |up: f64, down: f64| -> Vec<Vec<f64>> {
            let states = stood.iter().map(|run| {
                let mut on = false;
                let mut state = |x: &f64| {
                    on = *x > if on { down } else { up };
                    f64::from(u8::from(on))
                };
                run.iter().map(&mut state).collect()
            });
            states.collect()
        };
        // Gains of switched inputs, one for each pair of switching values, with the upper one.
        let gains = |tried: Vec<(f64, f64)>| -> Vec<(f64, Gain)> {
            let states: Vec<_> = tried.iter().map(|(up, down)| (*up, switched(*up, *down))).collect();
            let moves = |(_, states): &(f64, Vec<Vec<f64>>)| {
                states.iter().any(|run| run.iter().any(|on| *on != states[0][0]))
            };
            let states: Vec<_> = states.into_iter().filter(moves).collect();
            let columns = point.port_columns(port, states.len(), |k, r, row, _| states[k].1[r][row]);
            let gains = columns.map_or_else(Vec::new, |columns| point.evidence.gains(&columns, 1));
            states.iter().zip(gains).filter_map(|((x, _), gain)| Some((*x, gain?))).collect()
        };
        let latched = thresholds.iter().map(|x| (*x, f64::NEG_INFINITY)).collect();
        best(&format!("latched by {} above", driver.name()), 3.0, gains(latched));
        if is_inside(driver) {
            let tried = thresholds.iter().flat_map(|x| WIDTHS.iter().map(move |w| (*x, *x - w))).collect();
            best(&format!("switched by {} with hysteresis above", driver.name()), 4.0, gains(tried));
        }
    }
    let longest = point.runs.iter().enumerate().map(|(r, _)| clock(point, r)).map(|t| t[t.len() - 1] - t[0]);
    let longest = longest.fold(0.0, f64::max);
    let periods: Vec<f64> = (0..PERIODS.2).map(|k| PERIODS.0 * longest * PERIODS.1.powi(k)).collect();
    let waves = point.port_columns(port, 3 * periods.len(), |k, r, row, _| {
        let angle = std::f64::consts::TAU / periods[k / 3] * clock(point, r)[row];
        [1.0, angle.sin(), angle.cos()][k % 3]
    });
    let gains = waves.map_or_else(Vec::new, |waves| point.evidence.gains(&waves, 3));
    let periodic = periods.into_iter().zip(gains).filter_map(|(period, gain)| Some((period, gain?)));
    best("with a period of", 4.0, periodic.collect());
    all
}
