//! The columns of a file in which the requested channels are, and their units.

use crate::experiment::channel::{CHANNELS, Channel};
use crate::experiment::columns::{Column, TIME, other_unit};
use crate::experiment::units::{self, FileUnit};
use physics::declare::Unit;

/// A column of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Its place in a row.
    pub place: usize,
    /// The column of the contract.
    pub column: &'static str,
    /// The SI unit of the quantity.
    pub si: Unit,
    /// Its unit in the file.
    pub unit: FileUnit,
    /// The name of this unit.
    pub unit_name: String,
    /// Whether the experiment or the header states the unit.
    pub is_stated: bool,
}

impl Source {
    /// The SI value of a reading.
    pub fn value(&self, reading: f64) -> f64 {
        self.unit.factor * reading + self.unit.offset
    }
}

/// For each requested column, first the time, the names that it may have in a file.
pub fn names<'a>(wanted: &[&'static Channel], mapped: &'a [Column], blank: &[&str]) -> Vec<Vec<&'a str>> {
    let channels = wanted.iter().map(|c| c.column).filter(|column| !blank.contains(column));
    let of = |column: &'static str| {
        let headers = mapped.iter().filter(|c| c.column == column).map(|c| c.header.as_str());
        headers.chain([column]).collect()
    };
    std::iter::once(TIME).chain(channels).map(of).collect()
}

/// The time of a file.
pub fn time(header: &[String], mapped: &[Column]) -> Result<Source, String> {
    let own = FileUnit { factor: 1.0, offset: 0.0 };
    let advice = "[columns] can map another header to it: every row needs a time";
    find(header, (TIME, Unit::Second, own), mapped, advice)
}

/// The requested channels of a file; `None` for those of `blank`.
pub fn channels(
    header: &[String],
    wanted: &[&'static Channel],
    mapped: &[Column],
    blank: &[&str],
) -> Result<Vec<Option<Source>>, String> {
    let one = |channel: &&'static Channel| {
        let column = channel.column;
        let own = FileUnit { factor: 1.0, offset: channel.offset };
        let mut advice = "[columns] can map another header to it".to_owned();
        if channel.output.is_some() {
            advice += &format!(
                "; not_measured = [\"{column}\"] in [[run]] states that this run did not measure an output"
            );
        }
        match (blank.contains(&column), find(header, (column, channel.unit, own), mapped, &advice)) {
            (false, found) => found.map(Some),
            (true, Err(_)) => Ok(None),
            (true, Ok(_)) => Err(format!("not_measured names {column}, and the file has this column")),
        }
    };
    wanted.iter().map(one).collect()
}

/// A column of the contract in a file; otherwise a one-sentence error.
fn find(
    header: &[String],
    (column, si, own): (&'static str, Unit, FileUnit),
    mapped: &[Column],
    advice: &str,
) -> Result<Source, String> {
    let at = |name: &str| header.iter().position(|h| h == name);
    let of_column = || mapped.iter().filter(|c| c.column == column);
    let there: Vec<(usize, &Column)> = of_column().filter_map(|c| Some((at(&c.header)?, c))).collect();
    let source = match there[..] {
        [(_, a), (_, b), ..] => return Err(format!("{} and {} both record {column}", a.header, b.header)),
        [(place, found)] => {
            let (unit, unit_name, is_stated) = (found.unit, found.unit_name.clone(), found.is_stated);
            Source { place, column, si, unit, unit_name, is_stated }
        }
        [] => {
            let place = at(column).ok_or_else(|| {
                let names: Vec<&str> = of_column().map(|c| c.header.as_str()).collect();
                let or = if names.is_empty() { String::new() } else { format!(" ({})", names.join(", ")) };
                let channel = || CHANNELS.iter().filter(|c| c.column == column);
                match header.iter().find_map(|name| other_unit(name, channel())) {
                    Some(sentence) => format!("the column {column}{or} is missing; {sentence}"),
                    None => {
                        format!(
                            "the column {column}{or} is missing; there is {}. {advice}",
                            header.join(", ")
                        )
                    }
                }
            })?;
            // The name of the column states its unit.
            let unit_name = units::names(si).first().copied().unwrap_or(si.name()).to_owned();
            Source { place, column, si, unit: own, unit_name, is_stated: true }
        }
    };
    let name = &header[source.place];
    match header.iter().filter(|h| *h == name).count() {
        1 => Ok(source),
        count => Err(format!("{count} columns have the header {name}: give each column its own name")),
    }
}
