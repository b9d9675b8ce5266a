//! Times of a file: seconds, ISO 8601 date and time, or hours, minutes and seconds.

/// Seconds per minute. Definition: unit of time.
const MINUTE: f64 = 60.0;
/// Seconds per hour. Definition: unit of time.
const HOUR: f64 = 60.0 * MINUTE;
/// Seconds per day. Definition: unit of time.
pub const DAY: f64 = 24.0 * HOUR;

/// A time in the format of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stamp {
    /// A number in the unit of its column.
    Number(f64),
    /// Seconds since 1970-01-01, 00:00 UTC (local time where no zone is given).
    Date(f64),
    /// Seconds since midnight or since the start of the logger's clock.
    Clock(f64),
}

impl Stamp {
    /// The time in a cell, with a decimal point; `None` if the cell is not a time.
    pub fn of(cell: &str) -> Option<Stamp> {
        if let Ok(number) = cell.parse::<f64>() {
            return Some(Stamp::Number(number));
        }
        let apart = |c: char| c == 'T' || c == 't' || c == ' ';
        match cell.split_once(apart) {
            Some((date, time)) => Some(Stamp::Date(days(date)? * DAY + zoned(time.trim())?)),
            None => clock(cell).map(Stamp::Clock),
        }
    }
}

/// Days from 1970-01-01 to a date YYYY-MM-DD. *Source*: Richards, Explanatory Supplement to the Astronomical Almanac, 3rd ed.
/// (2013), 15.11.3 (Julian day of a Gregorian date).
fn days(date: &str) -> Option<f64> {
    let parts: Vec<&str> = date.split(['-', '/']).collect();
    let [year, month, day] = parts[..] else { return None };
    let (y, m, d) = (year.parse::<i64>().ok()?, month.parse::<i64>().ok()?, day.parse::<i64>().ok()?);
    let is_leap = y % 4 == 0 && (y % 100 != 0 || y % 400 == 0);
    let long = [31, if is_leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    if year.len() != 4 || !(1..=12).contains(&m) || !(1..=long[m as usize - 1]).contains(&d) {
        return None;
    }
    let late = (m - 14) / 12;
    let julian = (1461 * (y + 4800 + late)) / 4 + (367 * (m - 2 - 12 * late)) / 12
        - (3 * ((y + 4900 + late) / 100)) / 4
        + d
        - 32_075;
    Some((julian - 2_440_588) as f64)
}

/// A time of day with or without a time zone: Z, +02:00, -0130.
fn zoned(text: &str) -> Option<f64> {
    if let Some(time) = text.strip_suffix(['Z', 'z']) {
        return clock(time);
    }
    match text.rfind(['+', '-']) {
        None => clock(text),
        Some(at) => {
            let (time, zone) = text.split_at(at);
            let sign = if zone.starts_with('-') { -1.0 } else { 1.0 };
            let digits: String = zone[1..].chars().filter(|c| *c != ':').collect();
            let is_number = digits.chars().all(|c| c.is_ascii_digit()) && matches!(digits.len(), 2 | 4);
            let of = |part: Option<&str>| part.map_or(Some(0.0), |p| p.parse::<f64>().ok());
            let (hours, minutes) =
                is_number.then(|| (digits.get(..2), digits.get(2..).filter(|m| !m.is_empty())))?;
            Some(clock(time)? - sign * (HOUR * of(hours)? + MINUTE * of(minutes)?))
        }
    }
}

/// Seconds of h:m:s or h:m.
fn clock(text: &str) -> Option<f64> {
    let parts: Vec<&str> = text.split(':').collect();
    let (hours, minutes, seconds) = match parts[..] {
        [h, m] => (h, m, "0"),
        [h, m, s] => (h, m, s),
        _ => return None,
    };
    let (h, m) = (hours.parse::<u32>().ok()?, minutes.parse::<u32>().ok()?);
    let s: f64 = seconds.parse().ok()?;
    (m < 60 && (0.0..61.0).contains(&s)).then(|| HOUR * f64::from(h) + MINUTE * f64::from(m) + s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_every_kind() {
        for (cell, stamp) in [
            ("12.5", Stamp::Number(12.5)),
            ("1970-01-02T00:00:01.5", Stamp::Date(86_401.5)),
            ("2000-03-01 00:00:00Z", Stamp::Date(951_868_800.0)),
            ("2025-11-19T14:30:00+01:00", Stamp::Date(1_763_559_000.0)),
            ("2025/11/19 12:00-0130", Stamp::Date(1_763_559_000.0)),
            ("0:01:02.25", Stamp::Clock(62.25)),
            ("27:00:00", Stamp::Clock(97_200.0)),
        ] {
            assert_eq!(Stamp::of(cell), Some(stamp), "{cell}");
        }
        for cell in
            ["", "noon", "2025-02-30T00:00:00", "2025-13-01 00:00", "1:75:00", "19.11.2025 12:00", "1:2:3:4"]
        {
            assert_eq!(Stamp::of(cell), None, "{cell}");
        }
    }
}
