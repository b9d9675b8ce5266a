//! Times of a file: seconds, date and time, or hours, minutes and seconds.
//!
//! A date is YYYY-MM-DD, or dd.mm.yyyy, or day and month with slashes or hyphens, in the order that the dates of the file show: a field
//! above 12 is the day. A year may have two digits where the order is clear ([`two_digits`]). Two fields of a clock are hours and minutes,
//! or minutes and seconds if one of the file has a fraction.

mod two_digits;

use two_digits::{Dates, Order};

/// Seconds per minute. Definition: unit of time.
const MINUTE: f64 = 60.0;
/// Seconds per hour. Definition: unit of time.
pub const HOUR: f64 = 60.0 * MINUTE;
/// Seconds per day. Definition: unit of time.
pub const DAY: f64 = 24.0 * HOUR;
/// Longest run of a bench, s. Limit: thirty days; times that would last longer are in a shorter unit, or are dates in another order.
pub const LONGEST_RUN: f64 = 30.0 * DAY;

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

/// The parts of a file's times that one cell alone does not show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Notation {
    /// Whether the day comes before the month in dates such as 11/23/2026.
    is_day_first: bool,
    /// Whether two fields of a clock are minutes and seconds.
    has_minutes_first: bool,
    /// The first clock with two fields.
    two_fields: Option<String>,
    /// The order of dates with a year of two digits, and a note on it.
    short: Option<(Order, Option<String>)>,
}

impl Notation {
    /// The notation of the times of a file, with their lines.
    ///
    /// # Errors
    /// Line and sentence if the order of day and month cannot be determined.
    pub fn of(cells: impl Iterator<Item = (u64, String)>) -> Result<Notation, (u64, String)> {
        let mut found = Notation::default();
        let (mut day_first, mut month_first, mut open) = (false, false, None);
        let mut short = Dates::default();
        for (line, cell) in cells {
            short.add(line, &cell);
            let Some((first, second)) = day_and_month(&cell) else {
                if let Some(fraction) = two_fields(&cell) {
                    found.has_minutes_first |= fraction;
                    // An example with a time other than zero is clearer.
                    if found.two_fields.as_ref().is_none_or(|example| !example.contains(is_not_zero)) {
                        found.two_fields = Some(cell);
                    }
                }
                continue;
            };
            (day_first, month_first) = (day_first | (first > MONTHS), month_first | (second > MONTHS));
            if day_first && month_first {
                let message = format!(
                    "time_s = {cell} has day and month in another order than a date before it: write dates as 2026-11-23"
                );
                return Err((line, message));
            }
            if first != second {
                open.get_or_insert((line, cell));
            }
        }
        found.is_day_first = day_first;
        found.short = short.order()?;
        match open.filter(|_| !day_first && !month_first) {
            Some((line, cell)) => Err((
                line,
                format!(
                    "time_s = {cell}: no date of the file shows if day or month is first; write 2026-11-23, or day first 23.11.2026"
                ),
            )),
            None => Ok(found),
        }
    }

    /// How clocks with two fields and dates with a year of two digits are read.
    pub fn notes(&self) -> Vec<String> {
        let clock = self.two_fields.as_ref().filter(|_| !self.has_minutes_first).map(|cell| {
            format!(
                "time_s = {cell} is read as hours and minutes; minutes and seconds need the hours as well, as in 0:{cell}"
            )
        });
        let date = self.short.as_ref().and_then(|(_, note)| note.clone());
        clock.into_iter().chain(date).collect()
    }
}

fn is_not_zero(c: char) -> bool {
    matches!(c, '1'..='9')
}

/// Months of a year. Definition: of the calendar.
const MONTHS: i64 = 12;

/// The first two fields of a date with slashes or hyphens that ends with the year.
fn day_and_month(cell: &str) -> Option<(i64, i64)> {
    let date = cell.split([' ', 'T', 't']).next()?.trim_end_matches([',', '.']);
    let parts: Vec<&str> = date.split(['-', '/']).collect();
    let [first, second, year] = parts[..] else { return None };
    (year.len() == 4).then_some((first.parse().ok()?, second.parse().ok()?))
}

/// Whether a clock with two fields has a fraction; `None` if the cell is none.
fn two_fields(cell: &str) -> Option<bool> {
    let (first, second) = cell.split_once(':')?;
    first.parse::<u32>().ok()?;
    second.replace(',', ".").parse::<f64>().ok()?;
    Some(second.contains([',', '.']))
}

impl Stamp {
    /// The time in a cell, with a decimal point; `None` if the cell is not a time.
    pub fn of(cell: &str, notation: &Notation) -> Option<Stamp> {
        if let Ok(number) = cell.parse::<f64>() {
            return Some(Stamp::Number(number));
        }
        if let Some(seconds) = spelled(cell) {
            return Some(Stamp::Clock(seconds));
        }
        let (cell, half) = half_of_day(cell);
        let apart = |c: char| c == 'T' || c == 't' || c == ' ';
        let time = |text: &str| clock(text, half, notation);
        match cell.split_once(apart) {
            Some((date, rest)) => Some(Stamp::Date(days(date, notation)? * DAY + zoned(rest.trim(), &time)?)),
            None => time(cell).map(Stamp::Clock),
        }
    }
}

/// Half of the day of a 12-hour clock.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Half {
    Am,
    Pm,
}

/// A time without AM or PM, and which of the two it had.
fn half_of_day(cell: &str) -> (&str, Option<Half>) {
    let names = [("a.m.", Half::Am), ("p.m.", Half::Pm), ("am", Half::Am), ("pm", Half::Pm)];
    let found = names.into_iter().find_map(|(name, half)| {
        let (time, end) = cell.split_at_checked(cell.len().checked_sub(name.len())?)?;
        end.eq_ignore_ascii_case(name).then_some((time.trim_end(), Some(half)))
    });
    found.unwrap_or((cell, None))
}

/// Days from 1970-01-01 to a date.
fn days(date: &str, notation: &Notation) -> Option<f64> {
    let date = date.trim_end_matches([',', '.']);
    let mark = ['.', '-', '/'].into_iter().find(|mark| date.contains(*mark))?;
    let parts: Vec<&str> = date.split(mark).collect();
    let [first, second, third] = parts[..] else { return None };
    let (year, month, day_of_month) = match (first.len(), third.len()) {
        (4, _) => (first, second, third),
        (_, 4) if mark == '.' || notation.is_day_first => (third, second, first),
        (_, 4) => (third, first, second),
        _ => return notation.short.as_ref()?.0.days(date),
    };
    day(year.parse().ok()?, month.parse().ok()?, day_of_month.parse().ok()?)
}

/// Days from 1970-01-01 to a date, if there is this date. *Source*: Richards, Explanatory Supplement to the Astronomical Almanac, 3rd ed.
/// (2013), 15.11.3 (Julian day of a Gregorian date).
fn day(y: i64, m: i64, d: i64) -> Option<f64> {
    let is_leap = y % 4 == 0 && (y % 100 != 0 || y % 400 == 0);
    let long = [31, if is_leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
    if !(1..=MONTHS).contains(&m) || !(1..=long[m as usize - 1]).contains(&d) {
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
fn zoned(text: &str, clock: &dyn Fn(&str) -> Option<f64>) -> Option<f64> {
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
            Some(clock(time.trim_end())? - sign * (HOUR * of(hours)? + MINUTE * of(minutes)?))
        }
    }
}

/// Names of the units of a spelled time, seconds of each, and how many of it the next greater one has. Definition: of the units.
const SPELLED: [(&[&str], f64, f64); 4] = [
    (&["d"], DAY, f64::INFINITY),
    (&["h", "hr"], HOUR, 24.0),
    (&["m", "min"], MINUTE, 60.0),
    (&["s", "sec"], 1.0, 60.0),
];

/// Seconds of two or more numbers with their units, the greatest first: 0h12m34.5s, 1 h 02 min, PT1H2M3S (ISO 8601). One number alone is a
/// reading with a unit.
fn spelled(cell: &str) -> Option<f64> {
    let text = cell.trim().to_ascii_lowercase().replace(',', ".");
    let bare = text.strip_prefix('p').map(|period| period.replacen('t', "", 1));
    let mut rest = bare.as_deref().unwrap_or(&text);
    let (mut units, mut seconds, mut count) = (SPELLED.iter(), 0.0, 0);
    while !rest.is_empty() {
        let (number, behind) = rest.split_at(rest.find(|c: char| !c.is_ascii_digit() && c != '.')?);
        let behind = behind.trim_start();
        let end = behind.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(behind.len());
        let (name, behind) = behind.split_at(end);
        let (_, size, most) = units.find(|(names, ..)| names.contains(&name))?;
        let value: f64 = number.parse().ok()?;
        rest = behind.trim_start();
        if count > 0 && value >= *most || value.fract() != 0.0 && !rest.is_empty() {
            return None;
        }
        (seconds, count) = (seconds + size * value, count + 1);
    }
    (count > 1).then_some(seconds)
}

/// Seconds of h:m:s, h:m:s with three or six decimals behind another colon, h:m or m:s.
fn clock(text: &str, half: Option<Half>, notation: &Notation) -> Option<f64> {
    let text = text.replace(',', ".");
    let parts: Vec<&str> = text.split(':').collect();
    let joined;
    let (hours, minutes, seconds) = match parts[..] {
        [m, s] if notation.has_minutes_first => return minutes_and_seconds(m, s),
        [m, s] if half.is_none() && s.contains('.') => return minutes_and_seconds(m, s),
        [h, m] => (h, m, "0"),
        [h, m, s] => (h, m, s),
        [h, m, s, decimals] if matches!(decimals.len(), 3 | 6) && !s.contains('.') => {
            joined = format!("{s}.{decimals}");
            (h, m, joined.as_str())
        }
        _ => return None,
    };
    let (h, m) = (hours.parse::<u32>().ok()?, minutes.parse::<u32>().ok()?);
    let h = match half {
        None => h,
        Some(_) if !(1..=12).contains(&h) => return None,
        Some(Half::Am) => h % 12,
        Some(Half::Pm) => h % 12 + 12,
    };
    let s: f64 = seconds.parse().ok()?;
    (m < 60 && (0.0..61.0).contains(&s)).then(|| HOUR * f64::from(h) + MINUTE * f64::from(m) + s)
}

fn minutes_and_seconds(minutes: &str, seconds: &str) -> Option<f64> {
    let (m, s) = (minutes.parse::<u32>().ok()?, seconds.parse::<f64>().ok()?);
    (0.0..61.0).contains(&s).then(|| MINUTE * f64::from(m) + s)
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
            assert_eq!(Stamp::of(cell, &Notation::default()), Some(stamp), "{cell}");
        }
        for cell in [
            "",
            "noon",
            "2025-02-30T00:00:00",
            "2025-13-01 00:00",
            "1:75:00",
            "1:2:3:4",
            "13:00 PM",
            "3.4.25 12:00",
        ] {
            assert_eq!(Stamp::of(cell, &Notation::default()), None, "{cell}");
        }
    }

    /// The stamps of a file's times, or the sentence.
    fn stamps(cells: &[&str]) -> Result<Vec<Option<Stamp>>, (u64, String)> {
        let notation = Notation::of((2..).zip(cells.iter().map(|cell| (*cell).to_owned())))?;
        Ok(cells.iter().map(|cell| Stamp::of(cell, &notation)).collect())
    }

    /// Dates of one instant in every order that a file may have.
    #[test]
    fn dates_with_day_or_month_first() {
        let instant = Some(Stamp::Date(1_803_549_602.25));
        for cell in [
            "25.02.2027 10:00:02.25",
            "25.2.2027 10:00:02,25",
            "25/02/2027 10:00:02.25",
            "25-02-2027 10:00:02.25",
            "2/25/2027 10:00:02:250",
            "02/25/2027, 10:00:02:250000 AM",
            "2027.02.25 10:00:02.25",
            "25.02.2027 10:00:02.25 a.m.",
        ] {
            assert_eq!(stamps(&[cell]).unwrap()[0], instant, "{cell}");
        }
        // One date decides for the others; a date whose day is its month needs no order.
        for (cells, days) in [
            (["03/04/2027 0:00", "13/04/2027 0:00"], 10.0),
            (["04/03/2027 0:00", "04/13/2027 0:00"], 10.0),
            (["05/05/2027 0:00", "05/05/2027 12:00"], 0.5),
        ] {
            let found = stamps(&cells).unwrap();
            let [Some(Stamp::Date(first)), Some(Stamp::Date(last))] = found[..] else { panic!("{found:?}") };
            assert_eq!(last - first, days * DAY, "{cells:?}");
        }
        let (line, sentence) = stamps(&["04/04/2027 0:00", "04/05/2027 0:00"]).unwrap_err();
        assert!(
            line == 3 && sentence.contains("time_s = 04/05/2027 0:00: no date of the file shows"),
            "{sentence}"
        );
        let (line, sentence) = stamps(&["13/04/2027 0:00", "04/14/2027 0:00"]).unwrap_err();
        assert!(line == 3 && sentence.contains("another order"), "{sentence}");
    }

    #[test]
    fn clocks_with_two_fields_and_with_am_or_pm() {
        let seconds = |cells: &[&str]| -> Vec<f64> {
            let found = stamps(cells).unwrap();
            let of = |stamp: &Option<Stamp>| match stamp {
                Some(Stamp::Clock(seconds)) => *seconds,
                other => panic!("{other:?}"),
            };
            found.iter().map(of).collect()
        };
        assert_eq!(
            seconds(&["12:00:01 AM", "1:00:00 am", "12:00 PM", "01:00:00PM"]),
            [1.0, 3600.0, 43_200.0, 46_800.0]
        );
        assert_eq!(seconds(&["0:07", "0:08"]), [420.0, 480.0]);
        // A fraction anywhere in the file: minutes and seconds.
        assert_eq!(seconds(&["0:07", "0:07.5", "75:00"]), [7.0, 7.5, 4500.0]);
        let note = |cells: &[&str]| {
            Notation::of((2..).zip(cells.iter().map(|cell| (*cell).to_owned()))).unwrap().notes().pop()
        };
        assert!(
            note(&["0:00", "0:07", "0:08"])
                .unwrap()
                .starts_with("time_s = 0:07 is read as hours and minutes")
        );
        assert_eq!((note(&["0:07.5"]), note(&["0:00:07"]), note(&["2027-02-25 10:00"])), (None, None, None));
    }
    /// Numbers with units in any notation; not one number alone, not in another order, not beyond the next unit.
    #[test]
    fn times_with_the_names_of_their_units() {
        for (cell, seconds) in [
            ("2h07m09s", 7629.0),
            ("2h07m", 7620.0),
            ("75m30,5s", 4530.5),
            ("0 h 3 min 4.25 sec", 184.25),
            ("1d2h", 93_600.0),
            ("PT2H7M9S", 7629.0),
            ("P1DT2H", 93_600.0),
        ] {
            assert_eq!(Stamp::of(cell, &Notation::default()), Some(Stamp::Clock(seconds)), "{cell}");
        }
        for cell in
            ["7m", "9s", "7m2h", "2h07m60s", "2h60m", "2.5h07m", "2h7", "2h7x", "hm", "2h2h", "-1h02m", "PT"]
        {
            assert_eq!(Stamp::of(cell, &Notation::default()), None, "{cell}");
        }
    }

    #[test]
    fn years_of_two_digits() {
        let days = |cells: &[&str]| -> Vec<f64> {
            let of = |stamp: Option<Stamp>| match stamp {
                Some(Stamp::Date(seconds)) => seconds / DAY,
                other => panic!("{other:?} of {cells:?}"),
            };
            stamps(cells).unwrap().into_iter().map(of).collect()
        };
        let day = |y: i64, m: i64, d: i64| super::day(y, m, d).unwrap();
        // One order has all dates, or lets the file last no more than days.
        for (cells, expected) in [
            (&["02/28/27 0:00"][..], day(2027, 2, 28)),
            (&["31.12.98 0:00"], day(1998, 12, 31)),
            (&["98-12-31 0:00"], day(1998, 12, 31)),
            (&["27-2-3 0:00"], day(2027, 2, 3)),
            (&["07.02.27 0:00", "08.02.27 0:00"], day(2027, 2, 7)),
            (&["07/02/09 0:00", "08/02/09 0:00"], day(2009, 2, 7)),
            (&["07/02/09 0:00", "07/04/09 0:00"], day(2009, 7, 2)),
            (&["07-02-09 0:00", "07-02-10 0:00"], day(2007, 2, 9)),
            (&["27.02.09 23:00", "27.02.10 1:00"], day(2027, 2, 9)),
        ] {
            assert_eq!(days(cells)[0].floor(), expected, "{cells:?}");
        }
        // With points, the usual order and a note; the time within a file does not depend on it.
        assert_eq!(days(&["07.02.09 12:00"]), [day(2009, 2, 7) + 0.5]);
        let notes = |cell: &str| Notation::of(std::iter::once((2, cell.to_owned()))).unwrap().notes();
        assert!(
            notes("07.02.09 12:00")[0].starts_with("time_s = 07.02.09 12:00 is read as day, month and year")
        );
        assert!(notes("31.12.98 0:00").is_empty());
        for (cells, part) in [
            (&["23/11/26 10:00"][..], "time_s = 23/11/26 10:00: no date of the file shows which"),
            (&["07-02-09 0:00"], "write 2026-11-23, or day, month and year with points"),
        ] {
            let (line, sentence) = stamps(cells).unwrap_err();
            assert!(line == 2 && sentence.contains(part), "{sentence}");
        }
        for cells in [&["31.02.31 0:00"][..], &["13/04/27 0:00", "04/14/27 0:00"], &["7.2.9 0:00"]] {
            assert_eq!(stamps(cells).unwrap()[0], None, "{cells:?}");
        }
    }
}
