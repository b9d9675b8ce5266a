//! The law of a term in `report.json`, with the keys of effects.json.

use super::unit;
use physics::terms::{Driver, GenericTerm, Law};
use serde::Serialize;

/// Law of a term: value = coefficient * product of ((driver - offset) / reference)^exponent, a table, or a grid over two drivers;
/// with a lag, the driver is replaced by its first-order lag.
#[derive(Debug, Default, Serialize)]
pub(super) struct LawText {
    unit: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    coefficient: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    drivers: Vec<FactorText>,
    #[serde(skip_serializing_if = "Option::is_none")]
    table: Option<TableText>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<GridText>,
    #[serde(skip_serializing_if = "Option::is_none")]
    lag: Option<LagText>,
}

#[derive(Debug, Serialize)]
struct GridText {
    drivers: [&'static str; 2],
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<Vec<f64>>,
}

#[derive(Debug, Serialize)]
struct LagText {
    driver: &'static str,
    tau: f64,
}

#[derive(Debug, Serialize)]
struct FactorText {
    driver: &'static str,
    offset: f64,
    reference: f64,
    exponent: f64,
}

#[derive(Debug, Serialize)]
struct TableText {
    driver: &'static str,
    x: Vec<f64>,
    y: Vec<f64>,
}

pub(super) fn law(term: &GenericTerm) -> LawText {
    let lag = term.lag.map(|lag| LagText { driver: lag.driver.name(), tau: lag.tau });
    let text = LawText { unit: unit(term.port), lag, ..LawText::default() };
    match &term.law {
        Law::Product(product) => LawText {
            coefficient: Some(product.coefficient),
            drivers: product
                .factors
                .iter()
                .flatten()
                .map(|f| FactorText {
                    driver: f.driver.name(),
                    offset: f.offset,
                    reference: f.reference,
                    exponent: f.exponent,
                })
                .collect(),
            ..text
        },
        Law::Table(table) => {
            let (x, y) = table.points();
            let table = TableText { driver: table.driver.name(), x: x.to_vec(), y: y.to_vec() };
            LawText { table: Some(table), ..text }
        }
        Law::Grid(grid) => {
            let drivers = grid.drivers.map(Driver::name);
            let [x, y] = [0, 1].map(|k| grid.points(k).to_vec());
            let z = grid.values().map(<[f64]>::to_vec).collect();
            LawText { grid: Some(GridText { drivers, x, y, z }), ..text }
        }
    }
}
