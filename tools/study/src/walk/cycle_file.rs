//! A periodic load from a CSV file: torque and speed or angle over time, with the file's own column names and units.
//!
//! ```toml
//! [cycle]
//! file = "ankle.csv"                                # beside this file
//! time   = "t [ms]"                                 # a unit in brackets in the header counts
//! torque = { column = "M", unit = "N.mm" }
//! speed  = { column = "n", unit = "rpm" }           # or angle = ...
//! ratio = 50                                        # rigid gear between motor and cycle, 1 if not given
//! efficiency = 0.8
//! inertia = "20 g.cm2"                              # of the load, at the cycle
//! scale = 1.0                                       # factor on the torque
//! supply = "48 V"                                   # voltage of the drive
//! period = "1.2 s"                                  # from the first to the last row, if not given; also for times in %
//! body_mass = "75 kg"                               # for a torque per body mass, as in N.m/kg
//! ```
//!
//! [`usual::table_of`] writes this table for a CSV file whose columns have usual names.

pub(super) mod usual;

use delimited::{Row, name_and_unit};
use describe::preset::{Source, nearest};
use physics::load_table::{LoadTable, MOST_ROWS};
use std::path::Path;
use toml::Spanned;
use toml::de::DeValue;
use units::{Conversion, conversion, split, unchanged};

/// Gear, load and supply of a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Speed of the motor over that of the cycle.
    pub ratio: f64,
    /// Efficiency of the gear.
    pub efficiency: f64,
    /// Moment of inertia of the load at the cycle, kg.m2; part of the torque of the file if 0.
    pub inertia: f64,
    /// Factor on the torque.
    pub scale: f64,
    /// Voltage of the drive, V.
    pub supply: f64,
}

impl Default for Drive {
    fn default() -> Drive {
        Drive { ratio: 1.0, efficiency: 1.0, inertia: 0.0, scale: 1.0, supply: f64::INFINITY }
    }
}

/// A value of a [`Drive`]: name, unit, limits, and where it is.
pub struct Setting {
    /// Its name, as in `--set cycle.ratio=50`.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    limits: (f64, f64),
    of: fn(&mut Drive) -> &mut f64,
}

/// The values of a [`Drive`].
pub const SETTINGS: [Setting; 5] = [
    Setting { name: "cycle.ratio", unit: "1", limits: (1e-3, 1e5), of: |d| &mut d.ratio },
    Setting { name: "cycle.efficiency", unit: "1", limits: (0.05, 1.0), of: |d| &mut d.efficiency },
    Setting { name: "cycle.inertia", unit: "kg.m2", limits: (0.0, 1e6), of: |d| &mut d.inertia },
    Setting { name: SCALE, unit: "1", limits: (0.0, 1e3), of: |d| &mut d.scale },
    Setting { name: "cycle.supply", unit: "V", limits: (1e-3, 1e4), of: |d| &mut d.supply },
];
/// Name of the factor on the torque.
pub const SCALE: &str = "cycle.scale";

impl Setting {
    /// The setting of a name.
    pub fn named(name: &str) -> Option<&'static Setting> {
        static ALL: [Setting; 5] = SETTINGS;
        ALL.iter().find(|s| s.name == name)
    }

    /// The least and the greatest value.
    pub fn limits(&self) -> (f64, f64) {
        self.limits
    }

    /// The value.
    pub fn get(&self, drive: &Drive) -> f64 {
        *(self.of)(&mut drive.clone())
    }

    /// Sets it from text: a number in SI units or with its unit.
    ///
    /// # Errors
    /// One sentence with name, value, unit or limits.
    pub fn set(&self, drive: &mut Drive, text: &str) -> Result<(), String> {
        let Setting { name, unit, limits: (low, high), .. } = *self;
        let (number, given) =
            split(text).ok_or_else(|| format!("{name} = {text} is not a number{}", in_unit(unit)))?;
        let value = match given {
            "" => number,
            given => describe::preset::conversion(name, given, unit, false)?.of(number),
        };
        if !(low..=high).contains(&value) {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            return Err(format!("{name} = {value}{unit} is outside its limits {low} ... {high}{unit}"));
        }
        *(self.of)(drive) = value;
        Ok(())
    }
}

/// A periodic course of torque and speed, at equal or unequal distances in time.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Ascending from 0, s.
    times: Vec<f64>,
    /// N.m.
    torques: Vec<f64>,
    /// rad/s.
    speeds: Vec<f64>,
    period: f64,
    /// Of the first row, rad, where the file has angles.
    angle: Option<f64>,
    /// File and columns.
    pub source: String,
}

impl Cycle {
    /// No torque at standstill.
    pub fn rest(period: f64) -> Cycle {
        let (times, torques, speeds) = (vec![0.0], vec![0.0], vec![0.0]);
        Cycle { times, torques, speeds, period, angle: None, source: "rest".to_owned() }
    }

    /// Its rows, with a factor on the torque.
    pub fn table(&self, scale: f64) -> LoadTable {
        LoadTable {
            times: self.times.clone(),
            torques: self.torques.iter().map(|torque| scale * torque).collect(),
            speeds: self.speeds.clone(),
            period: self.period,
            angle: self.angle,
        }
    }

    /// Its period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Torque at a time, N.m.
    pub fn torque(&self, t: f64) -> f64 {
        self.at(&self.torques, t)
    }

    /// Speed at a time, rad/s.
    pub fn speed(&self, t: f64) -> f64 {
        self.at(&self.speeds, t)
    }

    /// Linear between the rows, and from the last row to the first of the next period.
    fn at(&self, values: &[f64], t: f64) -> f64 {
        let t = t.rem_euclid(self.period);
        let next = self.times.partition_point(|time| *time <= t);
        let last = next.max(1) - 1;
        let (t1, v1) = match self.times.get(next) {
            Some(time) => (*time, values[next]),
            None => (self.period, values[0]),
        };
        let (t0, v0) = (self.times[last], values[last]);
        if t1 > t0 { v0 + (v1 - v0) * (t - t0) / (t1 - t0) } else { v0 }
    }
}

/// A column of the file: its header, and its unit where the load file gives one.
#[derive(Default)]
struct Column {
    header: String,
    unit: Option<String>,
    /// Offset of its key in the load file.
    at: usize,
}

/// What the table `[cycle]` says.
#[derive(Default)]
struct Table {
    file: Option<String>,
    /// Offset of the key of the file, or of the first key.
    at: usize,
    columns: [Option<Column>; 4],
    period: Option<f64>,
    /// With the offset of its key.
    body_mass: Option<(f64, usize)>,
    drive: Drive,
}

/// The four columns: name, SI unit.
const COLUMNS: [(&str, &str); 4] = [("time", "s"), ("torque", "N.m"), ("speed", "rad/s"), ("angle", "rad")];
const TIME: usize = 0;
const TORQUE: usize = 1;
const SPEED: usize = 2;
const ANGLE: usize = 3;

/// The cycle and its drive of a table `[cycle]` in a load file in `folder`; errors go to `source`.
pub(super) fn read(
    value: &Spanned<DeValue<'_>>,
    folder: &Path,
    source: &mut Source<'_>,
) -> Option<(Cycle, Drive)> {
    let DeValue::Table(values) = value.get_ref() else {
        source.error(value.span().start, "[cycle] must be a table".to_owned());
        return None;
    };
    let mut table = Table::default();
    let mut good = true;
    for (key, value) in values {
        let at = value.span().start.max(key.span().start);
        if key.get_ref() == "file" || table.at == 0 {
            table.at = at;
        }
        if let Err(sentence) = entry(&mut table, key.get_ref(), value.get_ref(), at) {
            source.error(at, sentence);
            good = false;
        }
    }
    if !good {
        return None;
    }
    let drive = table.drive;
    match load(table, folder) {
        Ok(cycle) => Some((cycle, drive)),
        Err((at, sentence)) => {
            source.error(at, sentence);
            None
        }
    }
}

fn text_of(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Float(text) => Some(text.as_str().replace('_', "")),
        DeValue::Integer(text) => {
            i64::from_str_radix(text.as_str(), text.radix()).ok().map(|n| n.to_string())
        }
        _ => None,
    }
}

/// ` in N.m`; nothing for a number without unit.
fn in_unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" in {unit}") }
}

/// A number above 0 in a unit, from a text that may have another one.
fn positive(key: &str, text: &str, unit: &str) -> Result<f64, String> {
    let number = units::number(text, unit).map_err(|why| format!("{key} = {text}: {why}"))?;
    if number > 0.0 { Ok(number) } else { Err(format!("{key} = {text} is not above 0 {unit}")) }
}

fn entry(table: &mut Table, key: &str, value: &DeValue<'_>, at: usize) -> Result<(), String> {
    let place = COLUMNS.iter().position(|(name, _)| *name == key);
    if let Some(place) = place {
        let mut column = Column { at, ..Column::default() };
        match value {
            DeValue::String(header) => column.header = header.to_string(),
            DeValue::Table(parts) => {
                for (part, value) in parts {
                    let text = text_of(value.get_ref())
                        .ok_or_else(|| format!("{key}.{} must be a string", part.get_ref()))?;
                    match part.get_ref().as_ref() {
                        "column" => column.header = text,
                        "unit" => column.unit = Some(text),
                        other => {
                            return Err(format!(
                                "{key} has the unknown key {other}; the keys are column and unit"
                            ));
                        }
                    }
                }
            }
            _ => {
                return Err(format!(
                    "{key} must be the name of a column, or {{ column = \"...\", unit = \"...\" }}"
                ));
            }
        }
        table.columns[place] = Some(column);
        return Ok(());
    }
    let text = text_of(value).ok_or_else(|| format!("{key} must be a string or a number"))?;
    match key {
        "file" => table.file = Some(text),
        "period" => table.period = Some(positive(key, &text, "s")?),
        "body_mass" => table.body_mass = Some((positive(key, &text, "kg")?, at)),
        key => match Setting::named(&format!("cycle.{key}")) {
            Some(setting) => setting.set(&mut table.drive, &text)?,
            None => {
                let known = SETTINGS.iter().map(|s| &s.name["cycle.".len()..]);
                let known = COLUMNS.iter().map(|c| c.0).chain(known).chain(["file", "period", "body_mass"]);
                return Err(format!("{key} is not a key of [cycle]{}", nearest(key, known)));
            }
        },
    }
    Ok(())
}

/// The conversion of a column to SI units, and what its numbers are relative to: a time in % to the period, a torque in N.m/kg to the body mass.
fn converted(
    kind: usize,
    unit: Option<&str>,
    [period, body_mass]: [Option<f64>; 2],
) -> Result<(Conversion, Option<f64>), String> {
    let Some(unit) = unit else { return Ok((unchanged(), None)) };
    let refusal = match conversion(unit, COLUMNS[kind].1, false) {
        Ok(conversion) => return Ok((conversion, None)),
        Err(refusal) => refusal.to_string(),
    };
    let (relative, to, what, key) = match kind {
        TIME => ("1", period, "a fraction of the period", "period"),
        TORQUE => ("N.m/kg", body_mass, "a torque per body mass", "body_mass"),
        _ => return Err(refusal),
    };
    let conversion = conversion(unit, relative, false).map_err(|_| refusal)?;
    let to = to.ok_or_else(|| format!("\"{unit}\" is {what}: the key {key} of [cycle] is missing"))?;
    Ok((conversion, Some(to)))
}

/// The cycle of a table; an error has the offset of what is wrong.
fn load(table: Table, folder: &Path) -> Result<Cycle, (usize, String)> {
    let here = |sentence: String| (table.at, sentence);
    let file = table.file.ok_or_else(|| here("the key file of [cycle] is missing".to_owned()))?;
    let (name, text) = text_at(&folder.join(&file)).map_err(here)?;
    let (columns, period, body_mass) = (table.columns, table.period, table.body_mass);
    if let (Some(_), Some(angle)) = (&columns[SPEED], &columns[ANGLE]) {
        return Err((angle.at, "[cycle] has speed and angle: one of them is enough".to_owned()));
    }
    for (place, other) in [(TIME, TIME), (TORQUE, TORQUE), (SPEED, ANGLE)] {
        if columns[place].is_none() && columns[other].is_none() {
            let names = if place == other { COLUMNS[place].0 } else { "speed or angle" };
            return Err(here(format!("the key {names} of [cycle] is missing")));
        }
    }
    let headers = text.header();
    let relative_to = [period, body_mass.map(|(mass, _)| mass)];
    let mut read: Vec<(usize, usize, Conversion, &str, Option<f64>)> = Vec::new();
    for (kind, column) in columns.iter().enumerate() {
        let Some(Column { header, unit, at }) = column else { continue };
        let place = headers
            .iter()
            .position(|h| h == header)
            .or_else(|| headers.iter().position(|h| name_and_unit(h).0 == header));
        let place = place.ok_or_else(|| {
            (*at, format!("{name} has no column {header}; its columns are {}", headers.join(", ")))
        })?;
        if headers.iter().filter(|h| **h == headers[place]).count() > 1 {
            return Err((
                *at,
                format!("{name} has several columns {}: give each column its own name", headers[place]),
            ));
        }
        let si = COLUMNS[kind].1;
        let unit = unit.as_deref().or_else(|| name_and_unit(&headers[place]).1);
        let (conversion, factor) = converted(kind, unit, relative_to)
            .map_err(|sentence| (*at, format!("{}: {sentence}", COLUMNS[kind].0)))?;
        read.push((kind, place, conversion, unit.unwrap_or(si), factor));
    }
    if let Some((_, at)) = body_mass.filter(|_| !read.iter().any(|r| r.0 == TORQUE && r.4.is_some())) {
        let why = "body_mass has no effect: the torque is not one per body mass, as in N.m/kg";
        return Err((at, why.to_owned()));
    }
    if let Some(f) = read.iter().find_map(|(_, place, ..)| text.grouped(*place)) {
        return Err(here(format!("{name}:{}: {}", f.line, f.message)));
    }
    let mut values: [Vec<f64>; 4] = Default::default();
    for row in text.rows() {
        let Row { line, cells } = row.map_err(|f| here(format!("{name}:{}: {}", f.line, f.message)))?;
        for (kind, place, conversion, _, factor) in &read {
            let (header, cell) = (&headers[*place], &cells[*place]);
            let number = text.pointed(cell).parse().ok().filter(|v: &f64| v.is_finite());
            let number = number.ok_or_else(|| {
                here(format!("{name}:{line}: \"{cell}\" in column {header} is not a number"))
            })?;
            values[*kind].push(conversion.of(number) * factor.unwrap_or(1.0));
        }
        let times = &values[TIME];
        if let [.., before, now] = times[..]
            && now <= before
        {
            let [now, before] = [now, before].map(|t| present::number(read[0].2.back(t)));
            let unit = read[0].3;
            return Err(here(format!("{name}:{line}: time {now} {unit} does not follow {before} {unit}")));
        }
        if times.len() > MOST_ROWS {
            return Err(here(format!("{name} has more than {MOST_ROWS} rows")));
        }
    }
    let source = format!(
        "{file}, columns {}",
        read.iter().map(|r| headers[r.1].as_str()).collect::<Vec<_>>().join(", ")
    );
    cycle(values, period, source).map_err(|sentence| here(format!("{name}: {sentence}")))
}

/// Name and contents of a file.
fn text_at(path: &Path) -> Result<(String, delimited::Table), String> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|e| format!("the cycle {name} cannot be read ({e})"))?;
    let text = delimited::Table::parse(&bytes).map_err(|f| format!("{name}:{}: {}", f.line, f.message))?;
    Ok((name, text))
}

fn cycle(values: [Vec<f64>; 4], period: Option<f64>, source: String) -> Result<Cycle, String> {
    let [mut times, mut torques, mut speeds, angles] = values;
    let (first, rows) = (times.first().copied().unwrap_or(0.0), times.len());
    if rows < 3 {
        return Err(format!("a cycle has at least 3 rows, not {rows}"));
    }
    for time in &mut times {
        *time -= first;
    }
    let span = times[rows - 1];
    let period = period.unwrap_or(span);
    if period < span * (1.0 - 1e-9) {
        return Err(format!(
            "the period of {period} s is shorter than the {span} s from the first to the last row"
        ));
    }
    // The last row is the first of the next period where there is no time between them.
    let closed = period <= span * (1.0 + 1e-9);
    if !angles.is_empty() {
        let count = if closed { rows - 1 } else { rows };
        let turn = if closed { angles[rows - 1] - angles[0] } else { 0.0 };
        let at = |k: isize| {
            let (around, k) = (k.div_euclid(count as isize) as f64, k.rem_euclid(count as isize) as usize);
            (times[k] + around * period, angles[k] + around * turn)
        };
        speeds = (0..count as isize)
            .map(|k| {
                let ((t0, a0), (t1, a1), (t2, a2)) = (at(k - 1), at(k), at(k + 1));
                // Second order also with unequal distances.
                let (before, after) = ((a1 - a0) / (t1 - t0), (a2 - a1) / (t2 - t1));
                (before * (t2 - t1) + after * (t1 - t0)) / (t2 - t0)
            })
            .collect();
    }
    if closed {
        for values in [&mut times, &mut torques, &mut speeds] {
            values.truncate(rows - 1);
        }
    }
    let angle = angles.first().copied();
    Ok(Cycle { times, torques, speeds, period, angle, source })
}
