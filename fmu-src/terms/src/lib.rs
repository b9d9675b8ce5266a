//! Reader and writer of `resources/effects.json`: generic terms of an FMU ([`physics::terms`]).
//!
//! ```json
//! {"format": "motor-fmu effects 1",
//!  "terms": [
//!    {"name": "seal", "port": "drag_torque", "coefficient": 1.2e-3, "unit": "N.m",
//!     "drivers": [{"driver": "speed", "reference": 100.0, "offset": 0.0, "exponent": 0.75}]},
//!    {"name": "air flow", "port": "winding_heat",
//!     "table": {"driver": "winding_temperature", "x": [300.0, 350.0, 400.0], "y": [0.0, -0.4, -1.5]}}]}
//! ```
//! A term of two drivers is a grid; a term with a latent state has a lag:
//!
//! ```json
//! {"name": "grease", "port": "drag_torque",
//!  "grid": {"drivers": ["speed", "housing_temperature"], "x": [0.0, 600.0], "y": [300.0, 330.0, 360.0],
//!           "z": [[0.0, 0.0, 0.0], [8e-3, 5e-3, 4e-3]]}},
//! {"name": "magnets", "port": "torque_constant", "coefficient": -0.02,
//!  "drivers": [{"driver": "winding_temperature", "reference": 10.0, "offset": 298.15}],
//!  "lag": {"driver": "winding_temperature", "tau": 400.0}}
//! ```
//! `z` has a row for each `x`; `tau` is in seconds. A lag replaces a driver of the term by its first-order lag; the drivers
//! `copper_loss` and `friction_loss` require a lag. With `"difference": true` it replaces the driver by the lag less the present driver, which
//! describes a mass: 50 J/K behind 0.5 W/K at the housing are
//!
//! ```json
//! {"name": "flange", "port": "housing_heat", "coefficient": 5.0,
//!  "drivers": [{"driver": "housing_temperature", "reference": 10.0}],
//!  "lag": {"driver": "housing_temperature", "tau": 100.0, "difference": true}}
//! ```
//!
//! Optional: the name (default: number of the term), the unit (that of the port), the drivers (none: a constant), the
//! offset (0), the exponent (1) and the range of the driver, beyond which the term is constant (`"range": [0.0, 300.0]`; default: none). `physics/src/effects/generic_term.rs` documents the action of a term at each port.
//!
//! The FMU reads the file when an instance is created; the tools check it before they write it into an archive. Both use
//! this crate, so an FMU accepts the file of its own archive. The other file of the resources is in [`load`].

pub mod load;
mod resources;

pub use resources::of_resources;

use physics::terms::{
    Driver, Factor, GREATEST_EXPONENT, GenericTerm, Grid, Lag, Law, MOST_DRIVERS, MOST_LINES, MOST_POINTS,
    MOST_TERMS, Port, Product, TIME_CONSTANT, Table,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Name of the file in the resources of an archive.
pub const FILE_NAME: &str = "effects.json";
/// Format identifier of the file.
pub const FORMAT: &str = "motor-fmu effects 1";
/// Largest absolute value of a coefficient, a table value or a driver offset.
const GREATEST: f64 = 1e6;
/// Limits of the reference value of a driver.
const REFERENCE: (f64, f64) = (1e-9, 1e9);

/// An error in a file: one sentence with the file name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct TermsError(String);

impl TermsError {
    /// serde_json gives the position at the end of its message; this message starts with it.
    fn of_json(error: &serde_json::Error, file: &str) -> TermsError {
        let sentence = error.to_string();
        let reason = sentence.split(" at line ").next().unwrap_or(&sentence);
        TermsError(format!("{file}:{}: {reason}", error.line()))
    }
}

/// Content of the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TermsFile {
    /// [`FORMAT`].
    pub format: String,
    /// The terms.
    pub terms: Vec<TermText>,
}

/// A term in the file: a coefficient with drivers, or a table.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TermText {
    /// Name for reports.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub name: String,
    /// Name of a [`Port`].
    pub port: String,
    /// Value of the term with every driver at its reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficient: Option<f64>,
    /// Unit of the coefficient or of the values of the table; must be that of the port.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Drivers of the coefficient.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drivers: Vec<DriverText>,
    /// Table instead of a coefficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<TableText>,
    /// Table of two drivers instead of a coefficient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<GridText>,
    /// Lag of one of the drivers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag: Option<LagText>,
}

/// A driver in the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DriverText {
    /// Name of a [`Driver`].
    pub driver: String,
    /// Divisor of the driver.
    pub reference: f64,
    /// Subtracted from the driver before the division.
    #[serde(default)]
    pub offset: f64,
    /// Exponent.
    #[serde(default = "one")]
    pub exponent: f64,
    /// Least and greatest value of the driver (magnitude of a speed, current or torque); the term is constant beyond them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

fn one() -> f64 {
    1.0
}

/// A table in the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct TableText {
    /// Name of a [`Driver`].
    pub driver: String,
    /// Values of the driver, ascending.
    pub x: Vec<f64>,
    /// Values of the term.
    pub y: Vec<f64>,
}

/// A table of two drivers in the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GridText {
    /// Names of two [`Driver`]s.
    pub drivers: [String; 2],
    /// Values of the first driver, ascending.
    pub x: Vec<f64>,
    /// Values of the second driver, ascending.
    pub y: Vec<f64>,
    /// Values of the term: a row for each x, a number for each y.
    pub z: Vec<Vec<f64>>,
}

/// A lag in the file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct LagText {
    /// Name of a [`Driver`] of the term.
    pub driver: String,
    /// Time constant, s.
    pub tau: f64,
    /// Whether the law has the lagged less the present driver.
    #[serde(default, skip_serializing_if = "is_false")]
    pub difference: bool,
}

fn is_false(flag: &bool) -> bool {
    !*flag
}

impl TermsFile {
    /// A file with these terms.
    pub fn new(terms: Vec<TermText>) -> TermsFile {
        TermsFile { format: FORMAT.to_string(), terms }
    }

    /// Parses the text of a file; errors contain the name `file`.
    pub fn parse(text: &str, file: &str) -> Result<TermsFile, TermsError> {
        let found: TermsFile =
            serde_json::from_str(text).map_err(|error| TermsError::of_json(&error, file))?;
        found.terms().map_err(|TermsError(sentence)| TermsError(format!("{file}: {sentence}")))?;
        Ok(found)
    }

    /// Reads the file at a path.
    pub fn load(path: &Path) -> Result<TermsFile, TermsError> {
        let text = std::fs::read_to_string(path)
            .map_err(|error| TermsError(format!("{} cannot be read: {error}", path.display())))?;
        TermsFile::parse(&text, &path.display().to_string())
    }

    /// The terms, checked.
    pub fn terms(&self) -> Result<Vec<GenericTerm>, TermsError> {
        if self.format != FORMAT {
            return Err(TermsError(format!("the format is \"{}\", not \"{FORMAT}\"", self.format)));
        }
        if self.terms.len() > MOST_TERMS {
            let n = self.terms.len();
            return Err(TermsError(format!("the file has {n} terms; the limit is {MOST_TERMS}")));
        }
        let term = |(k, text): (usize, &TermText)| {
            let name = if text.name.is_empty() { format!("{}", k + 1) } else { format!("\"{}\"", text.name) };
            text.term().map_err(|sentence| TermsError(format!("term {name}: {sentence}")))
        };
        self.terms.iter().enumerate().map(term).collect()
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).unwrap_or_default();
        text.push('\n');
        text
    }
}

impl TermText {
    /// A term as text.
    pub fn of(name: &str, term: &GenericTerm) -> TermText {
        let text = TermText {
            name: name.to_string(),
            port: term.port.name().to_string(),
            unit: Some(term.port.unit().name().to_string()),
            lag: term.lag.map(|Lag { driver, tau, difference }| LagText {
                driver: driver.name().to_string(),
                tau,
                difference,
            }),
            ..TermText::default()
        };
        match &term.law {
            Law::Product(product) => TermText {
                coefficient: Some(product.coefficient),
                drivers: product
                    .factors
                    .iter()
                    .flatten()
                    .map(|factor| DriverText {
                        driver: factor.driver.name().to_string(),
                        reference: factor.reference,
                        offset: factor.offset,
                        exponent: factor.exponent,
                        range: (factor.range != Factor::UNLIMITED)
                            .then_some([factor.range.0, factor.range.1]),
                    })
                    .collect(),
                ..text
            },
            Law::Table(table) => {
                let (x, y) = table.points();
                let driver = table.driver.name().to_string();
                TermText { table: Some(TableText { driver, x: x.to_vec(), y: y.to_vec() }), ..text }
            }
            Law::Grid(grid) => {
                let [x, y] = [grid.points(0).to_vec(), grid.points(1).to_vec()];
                let drivers = grid.drivers.map(|driver| driver.name().to_string());
                let z = grid.values().map(<[f64]>::to_vec).collect();
                TermText { grid: Some(GridText { drivers, x, y, z }), ..text }
            }
        }
    }

    fn term(&self) -> Result<GenericTerm, String> {
        let port = named("port", &self.port, Port::by_name, Port::ALL.iter().map(|p| p.name()))?;
        let unit = port.unit().name();
        if let Some(given) = self.unit.as_ref().filter(|given| *given != unit) {
            return Err(format!("unit = \"{given}\"; the unit of port {} is \"{unit}\"", port.name()));
        }
        if !self.drivers.is_empty() && self.coefficient.is_none() {
            return Err("drivers belong to a coefficient; a table or a grid has its own".to_string());
        }
        let law = match (self.coefficient, &self.table, &self.grid) {
            (Some(coefficient), None, None) => Law::Product(self.product(coefficient)?),
            (None, Some(table), None) => Law::Table(table.table()?),
            (None, None, Some(grid)) => Law::Grid(grid.grid()?),
            _ => return Err("expected either a coefficient, a table or a grid".to_string()),
        };
        let lag = self.lag.as_ref().map(|lag| lag.lag(&law)).transpose()?;
        if let Some(heat) = law.drivers().find(|d| d.is_heat() && lag.is_none_or(|lag| lag.driver != *d)) {
            return Err(format!("driver {0} needs a lag: lag.driver = \"{0}\"", heat.name()));
        }
        Ok(GenericTerm { port, law, lag })
    }

    fn product(&self, coefficient: f64) -> Result<Product, String> {
        within("coefficient", coefficient, -GREATEST, GREATEST)?;
        let n = self.drivers.len();
        if n > MOST_DRIVERS {
            return Err(format!("drivers has {n} entries; the limit is {MOST_DRIVERS}"));
        }
        let mut factors = [None; MOST_DRIVERS];
        for (place, text) in factors.iter_mut().zip(&self.drivers) {
            within("reference", text.reference, REFERENCE.0, REFERENCE.1)?;
            within("offset", text.offset, -GREATEST, GREATEST)?;
            within("exponent", text.exponent, -GREATEST_EXPONENT, GREATEST_EXPONENT)?;
            let driver = driver(&text.driver)?;
            let range = match text.range {
                None => Factor::UNLIMITED,
                Some([least, most]) if least < most => (least, most),
                Some([least, most]) => {
                    return Err(format!(
                        "range = [{least}, {most}] is not a least and a larger greatest value"
                    ));
                }
            };
            let (reference, offset, exponent) = (text.reference, text.offset, text.exponent);
            *place = Some(Factor { driver, offset, reference, exponent, range });
        }
        Ok(Product { coefficient, factors })
    }
}

impl LagText {
    fn lag(&self, law: &Law) -> Result<Lag, String> {
        let driver = driver(&self.driver)?;
        within("lag.tau", self.tau, TIME_CONSTANT.0, TIME_CONSTANT.1)?;
        if law.drivers().all(|d| d != driver) {
            let drivers: Vec<&str> = law.drivers().map(Driver::name).collect();
            let all = if drivers.is_empty() { "none".to_string() } else { drivers.join(", ") };
            return Err(format!("lag.driver = \"{}\" is not a driver of the law: {all}", self.driver));
        }
        if driver.is_heat() && self.difference {
            return Err(format!(
                "lag.difference needs the present {}, which is known only with a lag",
                self.driver
            ));
        }
        Ok(Lag { driver, tau: self.tau, difference: self.difference })
    }
}

impl GridText {
    fn grid(&self) -> Result<Grid, String> {
        let drivers = [driver(&self.drivers[0])?, driver(&self.drivers[1])?];
        if drivers[0] == drivers[1] {
            return Err(format!("the grid has the driver {} twice", drivers[0].name()));
        }
        for (name, line) in [("x", &self.x), ("y", &self.y)] {
            if !(2..=MOST_LINES).contains(&line.len()) {
                let n = line.len();
                return Err(format!("grid.{name} has {n} points; the limits are 2 ... {MOST_LINES}"));
            }
            ascending(&format!("grid.{name}"), line)?;
        }
        let (rows, columns) = (self.x.len(), self.y.len());
        if let Some(k) = (0..self.z.len().max(rows)).find(|k| self.z.get(*k).map(Vec::len) != Some(columns)) {
            let sentence = format!("grid.z needs {rows} rows of {columns} values; row {k} is different");
            return Err(sentence);
        }
        for (k, row) in self.z.iter().enumerate() {
            for (n, z) in row.iter().enumerate() {
                within(&format!("grid.z[{k}][{n}]"), *z, -GREATEST, GREATEST)?;
            }
        }
        Grid::new(drivers, [&self.x, &self.y], &self.z)
            .ok_or_else(|| "the grid has a value that is not finite".to_string())
    }
}

/// Error if a list is not strictly ascending.
fn ascending(name: &str, list: &[f64]) -> Result<(), String> {
    let ascends = |pair: &[f64]| pair[0].partial_cmp(&pair[1]) == Some(std::cmp::Ordering::Less);
    match list.windows(2).position(|pair| !ascends(pair)) {
        None => Ok(()),
        Some(k) => {
            let (before, after) = (list[k], list[k + 1]);
            Err(format!("{name}[{}] = {after} is not larger than {name}[{k}] = {before}", k + 1))
        }
    }
}

impl TableText {
    fn table(&self) -> Result<Table, String> {
        let driver = driver(&self.driver)?;
        let (nx, ny) = (self.x.len(), self.y.len());
        if nx != ny {
            return Err(format!("the table has {nx} values of x and {ny} of y"));
        }
        if !(2..=MOST_POINTS).contains(&nx) {
            return Err(format!("the table has {nx} points; the limits are 2 ... {MOST_POINTS}"));
        }
        for (k, y) in self.y.iter().enumerate() {
            within(&format!("table.y[{k}]"), *y, -GREATEST, GREATEST)?;
        }
        ascending("table.x", &self.x)?;
        Table::new(driver, &self.x, &self.y)
            .ok_or_else(|| "the table has a value that is not finite".to_string())
    }
}

fn driver(name: &str) -> Result<Driver, String> {
    named("driver", name, Driver::by_name, Driver::ALL.iter().map(|d| d.name()))
}

/// The item with this name, or an error with the valid names.
fn named<T>(
    field: &str,
    name: &str,
    by_name: impl Fn(&str) -> Option<T>,
    all: impl Iterator<Item = &'static str>,
) -> Result<T, String> {
    by_name(name)
        .ok_or_else(|| format!("{field} = \"{name}\" is not one of {}", all.collect::<Vec<_>>().join(", ")))
}

fn within(field: &str, value: f64, min: f64, max: f64) -> Result<(), String> {
    if (min..=max).contains(&value) {
        Ok(())
    } else {
        Err(format!("{field} = {value} is outside its limits {min} ... {max}"))
    }
}

#[cfg(test)]
mod tests;
