//! CSV files whose columns have usual names: they need no load file.

use super::{ANGLE, COLUMNS, SPEED, TIME, TORQUE, converted, text_at};
use delimited::name_and_unit;
use std::path::Path;

/// Names of the columns that [`table_of`] knows, in any case.
const USUAL: [&[&str]; 4] = [
    &["time", "t"],
    &["torque", "tau", "m", "load_torque", "joint_torque"],
    &["speed", "omega", "w", "n", "joint_speed"],
    &["angle", "phi", "theta", "joint_angle"],
];

/// Usual units of the columns, for messages.
const UNITS: [&str; 4] = [
    "s, ms, min or h",
    "N.m, mN.m, N.cm, kgf.cm, ozf.in, lbf.in or lbf.ft",
    "rad/s (speed_rad_per_s), rpm, krpm, rev/s or deg/s",
    "rad, deg or rev",
];

/// Whether a name is a usual one, in any case.
fn is_known(place: usize, name: &str) -> bool {
    USUAL[place].contains(&name.to_lowercase().as_str())
}

/// Whether a header is a usual name: alone, with a unit in brackets, or with one behind an underscore, which is given (`speed_rpm`,
/// `speed_rad_per_s`).
fn usual(place: usize, header: &str) -> Option<Option<String>> {
    if is_known(place, name_and_unit(header).0) {
        return Some(None);
    }
    let unit = behind_underscore(place, header)?;
    // Newton metres in lower case are no nanometres here.
    [unit.clone(), unit.replace("nm", "Nm")].into_iter().find(|u| fits(place, u)).map(Some)
}

/// What follows a usual name and an underscore.
fn behind_underscore(place: usize, header: &str) -> Option<String> {
    let (at, _) = header.match_indices('_').find(|(at, _)| is_known(place, &header[..*at]))?;
    Some(header[at + 1..].replace("_per_", "/"))
}

/// One sentence about a header with a usual name and a unit that does not fit: in brackets, or behind an underscore.
fn misfit(place: usize, header: &str) -> Option<String> {
    let in_brackets = usual(place, header).and(name_and_unit(header).1).map(str::to_owned);
    let unit = in_brackets.or_else(|| behind_underscore(place, header))?;
    let refusal = converted(place, Some(&unit), [Some(1.0); 2]).err()?;
    let (quantity, units) = (COLUMNS[place].0, UNITS[place]);
    let article = if place == ANGLE { "an" } else { "a" };
    Some(format!("the column {header}: {refusal}; the unit of {article} {quantity} is {units}"))
}

/// Whether a column may have this unit.
fn fits(place: usize, unit: &str) -> bool {
    converted(place, Some(unit), [Some(1.0); 2]).is_ok()
}

/// The text of a table `[cycle]` for a CSV file with columns of usual names; speed is preferred to angle.
///
/// # Errors
/// A file that cannot be read, or a column that is not found.
pub(in crate::walk) fn table_of(path: &Path) -> Result<String, String> {
    let (name, text) = text_at(path)?;
    let headers = text.header();
    let find =
        |place: usize| headers.iter().map(String::as_str).find(|header| usual(place, header).is_some());
    let motion = if find(SPEED).is_some() { SPEED } else { ANGLE };
    let quoted = |text: &str| toml::Value::from(text).to_string();
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    // On one line, so that an error in it has that of the header.
    let mut table = format!("cycle = {{ file = {}", quoted(&file));
    for place in [TIME, TORQUE, motion] {
        let places = if place == ANGLE { vec![SPEED, ANGLE] } else { vec![place] };
        let wrong = match find(place) {
            Some(header) if usual(place, header) == Some(None) => misfit(place, header),
            Some(_) => None,
            None => places.iter().find_map(|k| headers.iter().find_map(|header| misfit(*k, header))),
        };
        if let Some(sentence) = wrong {
            return Err(format!("{name}:{}: {sentence}", text.header_line()));
        }
        let header = find(place).ok_or_else(|| {
            let wanted = if place == ANGLE { [USUAL[SPEED], USUAL[ANGLE]].concat() } else { USUAL[place].to_vec() };
            format!(
                "{name} has none of the columns {}; its columns are {}; a load file with the table [cycle] takes columns of any name",
                wanted.join(", "),
                headers.join(", ")
            )
        })?;
        table += &match usual(place, header).flatten() {
            None => format!(", {} = {}", COLUMNS[place].0, quoted(header)),
            Some(unit) => {
                let (name, column, unit) = (COLUMNS[place].0, quoted(header), quoted(&unit));
                format!(", {name} = {{ column = {column}, unit = {unit} }}")
            }
        };
    }
    Ok(table + " }\n")
}
