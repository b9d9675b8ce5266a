//! Runs that leave the range in which a law was found.

use crate::comparison::digits;
use crate::experiment::{CELSIUS, Role};
use crate::fit::Slopes;
use crate::hypothesis::Hypothesis;
use crate::levels::STRUCTURE;
use crate::report::role_words;
use crate::setup::Setup;
use physics::declare::Unit;
use physics::terms::{Driver, Drivers, GenericTerm, Law};

/// For each run and each driver of a law that leaves the law's range: what it reaches, the range, and how long, in a sentence.
pub fn notes(
    setup: &Setup,
    hypothesis: &Hypothesis,
    role: Role,
    runs: &[usize],
    slopes: &Slopes,
) -> Vec<String> {
    let mut notes = Vec::new();
    for (run, tangent) in runs.iter().zip(&slopes.tangents) {
        let term = |a: usize| hypothesis.place(a, *run).zip(hypothesis.additions[a].term());
        for (place, term) in (0..hypothesis.additions.len()).filter_map(term) {
            for (driver, range) in term.law.ranges() {
                let values = values(&term, place, driver, &tangent.drivers);
                let Some((reached, percent)) = beyond(&values, range) else { continue };
                notes.push(format!(
                    "{} ({}): {}{} reaches {} in {} % of the run; the law on {} was found from {} to {} and is constant outside",
                    setup.experiment.runs[*run].file,
                    role_words(role),
                    driver.name().replace('_', " "),
                    if term.lag.is_some_and(|lag| lag.driver == driver) { ", with its lag," } else { "" },
                    shown(driver, reached),
                    percent,
                    term.port.name().replace('_', " "),
                    shown(driver, range.0),
                    shown(driver, range.1)
                ));
            }
        }
    }
    notes
}

/// A driver of a term along a run, as the term takes it: with its lag, which is in this place, or as a magnitude.
pub fn values(term: &GenericTerm, place: usize, driver: Driver, drivers: &[Drivers]) -> Vec<f64> {
    let lag = term.lag.filter(|lag| lag.driver == driver);
    let of = |d: &Drivers| lag.map_or(d.of(driver), |lag| lag.seen(d.lagged[place], d.of(driver)));
    let all: Vec<f64> = drivers.iter().map(of).collect();
    let is_magnitude = matches!(term.law, Law::Product(_)) && !driver.has_sides();
    if is_magnitude { all.iter().map(|x| x.abs()).collect() } else { all }
}

/// The value farthest outside a range, and the percentage of rows outside; `None` if none is outside by more than structure error.
fn beyond(values: &[f64], (least, most): (f64, f64)) -> Option<(f64, usize)> {
    let excess = |x: f64| (least - x).max(x - most);
    let far = values.iter().copied().max_by(|a, b| excess(*a).total_cmp(&excess(*b)))?;
    let outside = values.iter().filter(|x| excess(**x) > 0.0).count();
    (excess(far) > STRUCTURE * (most - least)).then(|| (far, 100 * outside / values.len()))
}

/// A value of a driver with its unit, temperatures in degC.
fn shown(driver: Driver, value: f64) -> String {
    match driver.unit() {
        Unit::Kelvin => format!("{} degC", digits(value - CELSIUS)),
        Unit::One => digits(value),
        unit => format!("{} {}", digits(value), unit.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use physics::terms::{Factor, Lag, Port, Product, Table};

    fn at(speed: f64) -> Drivers {
        Drivers { speed, ..Drivers::default() }
    }

    /// 2 of 8 rows are outside, or 1; an excess within structure error is none.
    #[test]
    fn the_farthest_value_and_the_fraction_outside() {
        let values = [0.0, 2.0, 4.0, 5.8, 3.0, 3.9, -2.0, 1.0];
        assert_eq!(beyond(&values, (0.0, 4.0)), Some((-2.0, 25)));
        assert_eq!(beyond(&values, (-2.0, 4.0)), Some((5.8, 12)));
        assert_eq!(beyond(&values, (-2.0, 5.7)), None);
        assert_eq!(beyond(&values, (-2.0, 5.0)), Some((5.8, 12)));
    }

    /// A power of a speed takes its magnitude, a table the speed itself, and a lag the lagged speed.
    #[test]
    fn values_are_those_that_the_term_takes() {
        let factor =
            Factor { driver: Driver::Speed, offset: 0.0, reference: 1.0, exponent: 1.0, range: (0.0, 9.0) };
        let power = Law::Product(Product { coefficient: 1.0, factors: [Some(factor), None, None] });
        let table = Law::Table(Table::new(Driver::Speed, &[0.0, 9.0], &[0.0, 1.0]).unwrap());
        let lagged = |z: f64| Drivers { lagged: [0.0, z, 0.0], ..at(-8.0) };
        let drivers = [at(0.0), at(-8.0), lagged(-3.0)];
        let of = |law: Law, lag: Option<Lag>| {
            values(&GenericTerm { port: Port::DragTorque, law, lag }, 1, Driver::Speed, &drivers)
        };
        assert_eq!(of(power, None), [0.0, 8.0, 8.0]);
        assert_eq!(of(table, None), [0.0, -8.0, -8.0]);
        let lag = Lag { driver: Driver::Speed, tau: 10.0, difference: false };
        assert_eq!(of(table, Some(lag)), [0.0, 0.0, -3.0]);
        assert_eq!(of(table, Some(Lag { difference: true, ..lag })), [0.0, 8.0, 5.0]);
    }

    #[test]
    fn values_have_the_units_of_columns() {
        assert_eq!(shown(Driver::HousingTemperature, 300.65), "27.5 degC");
        assert_eq!(shown(Driver::Current, 5.8), "5.80 A");
        assert_eq!(shown(Driver::FanCommand, 0.0), "0");
    }
}
