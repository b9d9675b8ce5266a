//! Which outputs of a run are printed, written and drawn, and in which units.

use crate::Failure;
use crate::pattern::Patterns;
use clap::ValueEnum;
use cosim::{DisplayUnit, ModelDescription, Recording};

/// Options of `simulate` and `cosim`.
#[derive(Clone, Debug, clap::Args)]
pub struct Shown {
    /// Outputs to print, write and draw: names, or patterns with * and ?, separated by commas [default: all]
    #[arg(long, value_name = "NAME,...")]
    outputs: Vec<String>,
    /// Units of numbers in and out. si: the units of the FMU's interface (kelvin, rad/s) everywhere. datasheet: its display units (degC,
    /// rpm) everywhere, also for numbers of --set without unit; the CSV header names them. By default the printed values are in
    /// display units, everything else is in the units of the interface
    #[arg(long, value_enum)]
    units: Option<Units>,
}

/// A choice of units.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Units {
    /// Units of the interface
    Si,
    /// Display units
    Datasheet,
}

impl Shown {
    /// Leaves the chosen outputs, in the order of the choice, in the chosen units.
    pub fn apply(&self, recording: &mut Recording) -> Result<(), Failure> {
        if !self.outputs.is_empty() {
            let names: Vec<&str> = recording.columns.iter().map(|c| c.name.as_str()).collect();
            let chosen = Patterns::new(&self.outputs)
                .choose(&names)
                .map_err(|e| Failure::new(format!("--outputs: {e}")))?;
            recording.columns = chosen.into_iter().map(|k| recording.columns[k].clone()).collect();
        }
        for column in &mut recording.columns {
            match (self.units, column.display_unit.take()) {
                (None, display) => column.display_unit = display,
                (Some(Units::Datasheet), Some(display)) => {
                    column.values.iter_mut().for_each(|value| *value = display.show(*value));
                    column.unit = Some(display.name);
                }
                (Some(_), _) => {}
            }
        }
        Ok(())
    }

    /// The recording with the units in the names of its columns, for a CSV file in display units.
    pub fn named(&self, recording: &Recording) -> Recording {
        let mut named = recording.clone();
        if self.units == Some(Units::Datasheet) {
            for column in &mut named.columns {
                if let Some(unit) = column.unit.as_deref().filter(|unit| *unit != "1") {
                    column.name = format!("{} [{unit}]", column.name);
                }
            }
        }
        named
    }

    /// Settings in the units of the interface: a number may have its own unit; without one it is in the chosen units.
    pub fn sets(
        &self,
        sets: Vec<(String, String)>,
        description: &ModelDescription,
    ) -> Result<Vec<(String, String)>, Failure> {
        let convert = |(name, text): (String, String)| {
            let Some(variable) = description.variable(&name).filter(|v| v.kind.is_float()) else {
                return Ok((name, text));
            };
            let Some((number, unit)) = units::split(&text) else { return Ok((name, text)) };
            let own = variable.unit.as_deref().unwrap_or("1");
            let value = match (unit, description.display_unit(variable)) {
                ("", Some(display)) if self.units == Some(Units::Datasheet) => of_display(&display, number),
                ("", _) => return Ok((name, text)),
                (unit, _) => {
                    let refused = |refusal| {
                        Failure::new(format!("{name} has the unit \"{own}\", not \"{unit}\": {refusal}"))
                    };
                    units::conversion(unit, own, variable.relative).map_err(refused)?.of(number)
                }
            };
            Ok((name, value.to_string()))
        };
        sets.into_iter().map(convert).collect()
    }
}

/// The value in the unit of the interface.
fn of_display(display: &DisplayUnit, shown: f64) -> f64 {
    if display.inverse { display.factor / shown } else { (shown - display.offset) / display.factor }
}

/// Every n-th row of a recording, with the first and the last.
pub fn thin(recording: &mut Recording, every: usize) {
    let rows = recording.times.len();
    let kept: Vec<usize> = (0..rows).filter(|k| k % every == 0 || k + 1 == rows).collect();
    let pick = |values: &[f64]| kept.iter().map(|k| values[*k]).collect();
    recording.times = pick(&recording.times);
    for column in &mut recording.columns {
        column.values = pick(&column.values);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_display_value_goes_back() {
        let celsius = DisplayUnit { name: "degC".to_owned(), factor: 1.0, offset: -273.15, inverse: false };
        let period = DisplayUnit { name: "ms".to_owned(), factor: 1000.0, offset: 0.0, inverse: true };
        for (display, value) in [(&celsius, 298.15), (&period, 50.0)] {
            assert!((of_display(display, display.show(value)) - value).abs() < 1e-12);
        }
    }
}
