//! The recording of a run: rows at a multiple of the communication step, all numeric outputs of all components.
use super::connections::Connections;
use super::master::Master;
use super::parts::Parts;
use super::settings::owner;
use crate::simulate::Recorder;
use crate::{Column, Error, Kind, Value, Variable};

/// Default limit of the number of rows.
pub(crate) const ROWS: usize = 100_000;

/// Collects rows. At the limit every second row is removed and the output interval is doubled.
pub(crate) struct Record {
    recorders: Vec<Recorder>,
    times: Vec<f64>,
    pub(crate) every: usize,
    points: usize,
    /// Rows after which `every` doubles; `None` if it is not to change.
    room: Option<usize>,
}

impl Record {
    /// For `points` communication points, if that is known, with further variables of the components in `records`.
    pub(crate) fn new(
        parts: Parts,
        connections: &Connections,
        points: Option<usize>,
        every: Option<usize>,
        records: &[String],
    ) -> Result<Self, Error> {
        let chosen = every.unwrap_or_else(|| points.map_or(1, |n| round_up(n.div_ceil(ROWS))));
        // One more for the start, one for an end between rows.
        let rows = points.map_or(ROWS, |n| n / chosen) + 2;
        let mut recorders = Vec::new();
        for (index, sets) in connections.sets.iter().enumerate() {
            let description = parts.description(index);
            let sets: Vec<(&Variable, Value)> =
                sets.iter().map(|(v, value)| (&description.variables[*v], value.clone())).collect();
            let records: Vec<String> = (records.iter())
                .filter_map(|name| owner(parts.structure, name).filter(|(component, _)| *component == index))
                .map(|(_, variable)| variable.to_owned())
                .collect();
            recorders.push(Recorder::new(description, &sets, &records, rows)?);
        }
        Ok(Self {
            recorders,
            times: Vec::with_capacity(rows),
            every: chosen,
            points: 0,
            room: (points.is_none() && every.is_none()).then_some(ROWS),
        })
    }

    /// Called at each communication point; records a row at the output interval and at the `last` point.
    pub(crate) fn point(&mut self, master: &mut Master, t: f64, last: bool) -> Result<(), Error> {
        if self.points.is_multiple_of(self.every) || last {
            if self.room.is_some_and(|room| self.times.len() >= room) {
                self.thin();
            }
            self.times.push(t);
            for (recorder, instance) in self.recorders.iter_mut().zip(&mut master.instances) {
                recorder.record(instance, t)?;
            }
        }
        self.points += 1;
        Ok(())
    }

    fn thin(&mut self) {
        every_second(&mut self.times);
        for recorder in &mut self.recorders {
            every_second(&mut recorder.times);
            for column in &mut recorder.columns {
                every_second(&mut column.values);
                every_second(&mut column.exact);
            }
        }
        self.every *= 2;
    }

    /// Times and columns: `component.output`, then the outputs of the system.
    pub(crate) fn columns(self, parts: Parts, connections: &Connections) -> (Vec<f64>, Vec<Column>) {
        let mut columns = Vec::new();
        for (recorder, component) in self.recorders.into_iter().zip(&parts.structure.components) {
            columns.extend(
                recorder
                    .columns
                    .into_iter()
                    .map(|c| Column { name: format!("{}.{}", component.name, c.name), ..c }),
            );
        }
        for system_output in &connections.system_outputs {
            let source = parts.name(system_output.port);
            let Some(column) = columns.iter().find(|c| c.name == source) else { continue };
            let same_unit = column.unit.as_ref() == system_output.unit.as_ref().map(|u| &u.name);
            let values = column.values.iter().map(|x| system_output.convert.of(*x)).collect();
            let exact = if column.kind.is_integer() { column.exact.clone() } else { Vec::new() };
            columns.push(Column {
                name: system_output.name.clone(),
                kind: if column.kind.is_float() { Kind::Float64 } else { column.kind },
                unit: system_output.unit.as_ref().map(|u| u.name.clone()),
                display_unit: column.display_unit.clone().filter(|_| same_unit),
                values,
                exact,
            });
        }
        (self.times, columns)
    }
}

fn every_second<T>(values: &mut Vec<T>) {
    let mut place = 0;
    values.retain(|_| {
        place += 1;
        place % 2 == 1
    });
}

/// The next of 1, 2, 5, 10, 20, ...
fn round_up(n: usize) -> usize {
    let mut decade = 1;
    loop {
        for digit in [1, 2, 5] {
            if digit * decade >= n {
                return digit * decade;
            }
        }
        decade *= 10;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_round_numbers() {
        let found: Vec<usize> = [1, 2, 3, 5, 6, 11, 36, 51].map(round_up).to_vec();
        assert_eq!(found, [1, 2, 5, 5, 10, 20, 50, 100]);
    }

    #[test]
    fn thinning_keeps_the_first() {
        let mut values = vec![0.0, 1.0, 2.0, 3.0, 4.0];
        every_second(&mut values);
        assert_eq!(values, [0.0, 2.0, 4.0]);
    }
}
