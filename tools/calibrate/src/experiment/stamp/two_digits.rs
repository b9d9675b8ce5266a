//! Dates with a year of two digits: the order of their numbers, where the dates of the file show it.
//!
//! With slashes or hyphens, day, month and year have any of three orders; an order is possible if all dates of the file exist in it. Of
//! several, one counts in which no date is before the previous one and the file lasts no longer than [`LONGEST_RUN`]. With points the day is
//! first unless the dates show that the year is.

use super::{DAY, LONGEST_RUN, day};

/// The order of the numbers of a date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    Day,
    Month,
    Year,
}

/// The first year of two digits that is of the last century. Source: POSIX.1-2017, `strptime`, `%y`.
const LAST_CENTURY: i64 = 69;

/// The dates of a file and the cells in which they were first.
#[derive(Clone, Debug, Default)]
pub struct Dates(Vec<(u64, String)>);

impl Dates {
    /// Adds the date of a cell, if its year has two digits.
    pub fn add(&mut self, line: u64, cell: &str) {
        let date = |cell: &str| parts(cell).map(|(mark, parts)| (mark, parts.map(str::to_owned)));
        let new = date(cell);
        if new.is_some() && self.0.last().and_then(|(_, last)| date(last)) != new {
            self.0.push((line, cell.to_owned()));
        }
    }

    /// The order of the dates, and a note if it is the usual one; `None` without dates, or if no order has them all.
    ///
    /// # Errors
    /// Line and sentence if there are several orders.
    pub fn order(&self) -> Result<Option<Decided>, (u64, String)> {
        let Some((line, first)) = self.0.first() else { return Ok(None) };
        let has_points = parts(first).is_some_and(|(mark, _)| mark == '.');
        let days =
            |order: Order| -> Option<Vec<f64>> { self.0.iter().map(|(_, cell)| order.days(cell)).collect() };
        let possible =
            [Order::Day, Order::Month, Order::Year].into_iter().filter(|o| !has_points || *o != Order::Month);
        let possible: Vec<(Order, Vec<f64>)> =
            possible.filter_map(|order| Some((order, days(order)?))).collect();
        let is_run = |days: &[f64]| days.is_sorted() && days[days.len() - 1] - days[0] <= LONGEST_RUN / DAY;
        let runs: Vec<Order> =
            possible.iter().filter(|(_, days)| is_run(days)).map(|(order, _)| *order).collect();
        match (&possible[..], &runs[..]) {
            ([], _) => Ok(None),
            ([(order, _)], _) | (_, [order]) => Ok(Some((*order, None))),
            _ if has_points => {
                let note = format!(
                    "time_s = {first} is read as day, month and year; another order is written as 2026-11-23"
                );
                Ok(Some((Order::Day, Some(note))))
            }
            _ => Err((
                *line,
                format!(
                    "time_s = {first}: no date of the file shows which of the numbers are day, month and year; write 2026-11-23, or day, \
                     month and year with points"
                ),
            )),
        }
    }
}

/// An order, and a note if it is the usual one of several.
type Decided = (Order, Option<String>);

impl Order {
    /// Days from 1970-01-01 to the date of a cell.
    pub fn days(self, cell: &str) -> Option<f64> {
        let (_, [first, second, third]) = parts(cell)?;
        let (year, month, date) = match self {
            Order::Day => (third, second, first),
            Order::Month => (third, first, second),
            Order::Year => (first, second, third),
        };
        let number = |text: &str| text.parse::<i64>().ok();
        let short = number(year).filter(|_| year.len() == 2)?;
        let century = if short < LAST_CENTURY { 2000 } else { 1900 };
        day(century + short, number(month)?, number(date)?)
    }
}

/// The mark between the numbers of a date without a year of four digits, and the numbers.
fn parts(cell: &str) -> Option<(char, [&str; 3])> {
    let date = cell.split([' ', 'T', 't']).next()?.trim_end_matches([',', '.']);
    let mark = ['.', '-', '/'].into_iter().find(|mark| date.contains(*mark))?;
    let parts: Vec<&str> = date.split(mark).collect();
    let is_number = |part: &&str| matches!(part.len(), 1 | 2) && part.bytes().all(|c| c.is_ascii_digit());
    let three: [&str; 3] = parts.try_into().ok()?;
    three.iter().all(is_number).then_some((mark, three))
}
