//! The readings of a unit's text. A text such as `kg.cm`, `min-1` or `Nms` has more than one; the dimension of the quantity decides.

use crate::Dimension;
use crate::table::{ATOMS, GRAVITY, MASS, PREFIXES};

/// Readings that are followed at most, and letters of a name that may be several units.
const MOST: usize = 512;
const LONGEST: usize = 12;
/// Cost of a reading that is not the literal one.
const UNUSUAL: u32 = 1;
/// Cost of `min-1` as a frequency, and of `x/min` as a speed of rotation.
const UNLIKELY: u32 = 3;

/// One meaning of a unit: `SI value = number * factor * 10^tens + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reading {
    pub factor: f64,
    pub tens: i32,
    pub offset: f64,
    pub dimension: Dimension,
    pub cost: u32,
}

impl Reading {
    fn one() -> Reading {
        Reading { factor: 1.0, tens: 0, offset: 0.0, dimension: Dimension::default(), cost: 0 }
    }

    /// The product; a unit with an offset is a difference there.
    fn times(self, other: Reading) -> Reading {
        Reading {
            factor: self.factor * other.factor,
            tens: self.tens + other.tens,
            offset: 0.0,
            dimension: self.dimension.plus(other.dimension, 1),
            cost: self.cost + other.cost,
        }
    }

    /// To a power in halves.
    fn power(self, halves: i8) -> Option<Reading> {
        if halves == 2 {
            return Some(self);
        }
        // An odd power of a root of ten is not a power of ten.
        let (tens, rest) = if halves % 2 == 0 {
            (self.tens * i32::from(halves) / 2, 1.0)
        } else {
            (0, 10f64.powi(self.tens).powf(f64::from(halves) / 2.0))
        };
        let factor = match halves % 2 {
            0 => self.factor.powi(i32::from(halves) / 2),
            _ => self.factor.powf(f64::from(halves) / 2.0),
        };
        let dimension = self.dimension.power(halves)?;
        Some(Reading { factor: factor * rest, tens, offset: 0.0, dimension, cost: self.cost })
    }
}

/// The text with the usual signs in place of typographic ones.
fn normalised(text: &str) -> String {
    let mut plain = String::new();
    for c in text.trim().chars() {
        match c {
            '·' | '⋅' | '•' | '∙' | '*' | '×' | ' ' | '\u{a0}' | '\u{202f}' => plain.push('.'),
            'Ω' | '\u{2126}' => plain.push_str("Ohm"),
            'µ' | 'μ' => plain.push('u'),
            '℃' => plain.push_str("degC"),
            '°' => plain.push_str("deg"),
            '−' | '–' | '⁻' => plain.push('-'),
            '⁰' | '¹' | '²' | '³' | '⁴' | '⁵' | '⁶' | '⁷' | '⁸' | '⁹' => {
                let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹";
                plain.extend(digits.chars().position(|d| d == c).map(|k| (b'0' + k as u8) as char));
            }
            '^' => {}
            c => plain.push(c),
        }
    }
    // A speed of rotation, as `min-1`.
    let plain = plain.replace("1/min", "min-1").replace("per", "/");
    // A root of a unit without prefix, as in N.m/√W.
    ["sqrt(W)", "sqrtW", "√(W)", "√W"].iter().fold(plain, |text, root| text.replace(root, "W0.5"))
}

/// All readings of a text; none for a text that is no unit.
pub(crate) fn readings(text: &str) -> Vec<Reading> {
    let plain = normalised(&text.replace("percent", "%").replace("permille", "‰"));
    let mut parser = Parser { rest: &plain };
    let found = parser.quotient();
    if parser.rest.is_empty() { found.unwrap_or_default() } else { Vec::new() }
}

/// The names in a text, and whether each is a unit of the table, with or without prefix.
pub(crate) fn names(text: &str) -> Vec<(String, bool)> {
    let plain = normalised(text);
    let names = plain.split(|c: char| !(c.is_alphabetic() || c == '%')).filter(|name| !name.is_empty());
    names.map(|name| (name.to_owned(), unit(name).is_some())).collect()
}

struct Parser<'a> {
    rest: &'a str,
}

impl Parser<'_> {
    fn eat(&mut self, sign: char) -> bool {
        let found = self.rest.strip_prefix(sign);
        self.rest = found.unwrap_or(self.rest);
        found.is_some()
    }

    /// Factors joined by `.`, `-` and `/`. `W/m2.K` is read to the letter, and as `W/(m2.K)`.
    fn quotient(&mut self) -> Option<Vec<Reading>> {
        let mut letter = self.factor()?;
        let mut below: Option<Vec<Reading>> = None;
        loop {
            if self.eat('/') {
                let next = inverse(&self.factor()?);
                letter = product(&letter, &next);
                below = Some(match below {
                    Some(below) => product(&below, &next),
                    None => letter.clone(),
                });
            } else if self.eat('.') || self.eat('-') || self.rest.starts_with(char::is_alphabetic) {
                let next = self.factor()?;
                letter = product(&letter, &next);
                below = below.map(|below| product(&below, &inverse(&next)));
            } else {
                break;
            }
        }
        let other = below.unwrap_or_default();
        letter.extend(other.into_iter().map(|r| Reading { cost: r.cost + UNUSUAL, ..r }));
        Some(letter)
    }

    /// A group in brackets or a unit, with its power.
    fn factor(&mut self) -> Option<Vec<Reading>> {
        if self.eat('(') {
            let group = self.quotient()?;
            let halves = if self.eat(')') { self.halves()? } else { return None };
            return group.iter().map(|r| r.power(halves)).collect();
        }
        if let Some(rest) =
            self.rest.strip_prefix('1').filter(|rest| !rest.starts_with(|c: char| c.is_ascii_digit()))
        {
            self.rest = rest;
            return Some(vec![Reading::one()]);
        }
        // Units of water columns have a digit inside.
        let column = ["mmH2O", "inH2O"].into_iter().find(|name| self.rest.starts_with(name));
        let letters = self
            .rest
            .find(|c: char| !(c.is_alphabetic() || matches!(c, '%' | '‰')))
            .unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(column.map_or(letters, str::len));
        self.rest = rest;
        let halves = self.halves()?;
        let found: Vec<Reading> = named(name, halves).into_iter().take(MOST).collect();
        (!found.is_empty()).then_some(found)
    }

    /// An exponent in halves: `2`, `-1`, `0.5`; 1 where there is none.
    fn halves(&mut self) -> Option<i8> {
        let sign = self.rest.starts_with('-') && self.rest[1..].starts_with(|c: char| c.is_ascii_digit());
        let digits = &self.rest[usize::from(sign)..];
        let whole = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
        if whole == 0 {
            return Some(2);
        }
        let mut halves = 2 * digits[..whole].parse::<i8>().ok().filter(|n| *n <= 9)?;
        let mut rest = &digits[whole..];
        if let Some(after) = rest.strip_prefix(".5") {
            (halves, rest) = (halves + 1, after);
        }
        self.rest = rest;
        Some(if sign { -halves } else { halves })
    }
}

fn product(a: &[Reading], b: &[Reading]) -> Vec<Reading> {
    a.iter().flat_map(|a| b.iter().map(|b| a.times(*b))).take(MOST).collect()
}

fn inverse(readings: &[Reading]) -> Vec<Reading> {
    readings.iter().filter_map(|r| r.power(-2)).collect()
}

/// The readings of a name with its power: a unit, or units written without a sign between them, of which the last has the power.
fn named(name: &str, halves: i8) -> Vec<Reading> {
    if let Some(unit) = unit(name) {
        let mut found: Vec<Reading> = unit.power(halves).into_iter().collect();
        if unit.dimension == MASS {
            let weight = Reading { factor: unit.factor * GRAVITY, cost: UNUSUAL, ..unit };
            let acceleration = Dimension([0, 2, -4, 0, 0, 0]);
            let weight = Reading { dimension: unit.dimension.plus(acceleration, 1), ..weight };
            found.extend(weight.power(halves));
        }
        if name == "min" {
            // `min-1` is rather turns a minute, `l/min` rather a minute.
            let turn = Reading {
                factor: std::f64::consts::TAU,
                dimension: Dimension([0, 0, 0, 0, 0, 2]),
                ..Reading::one()
            };
            let (turns, costs) = match halves {
                -2 => (Some(turn), [UNLIKELY, 0]),
                2 => (turn.power(-2), [0, UNLIKELY]),
                _ => (None, [0, 0]),
            };
            let minutes = found.remove(0);
            found.push(Reading { cost: costs[0], ..minutes });
            found.extend(turns.map(|turns| Reading { cost: costs[1], ..minutes.times(turns) }));
        }
        return found;
    }
    parts(name, halves)
}

/// The readings of a name as several units. What follows the first may be a unit or several: the end of `Nms` is ms, or m and s.
fn parts(name: &str, halves: i8) -> Vec<Reading> {
    let mut found = Vec::new();
    if name.len() > LONGEST {
        return found;
    }
    for (at, _) in name.char_indices().skip(1) {
        let (first, rest) = name.split_at(at);
        if unit(first).is_some() {
            let mut ends = named(rest, halves);
            if unit(rest).is_some() {
                ends.extend(parts(rest, halves));
            }
            found.extend(product(&named(first, 2), &ends));
        }
    }
    found
}

/// A unit of the table, with or without prefix.
fn unit(name: &str) -> Option<Reading> {
    let read = |tens: i32, name: &str, prefixed: bool| {
        let atom = ATOMS.iter().find(|a| a.names.contains(&name) && (a.prefixed || !prefixed))?;
        Some(Reading {
            factor: atom.factor,
            tens: atom.tens + tens,
            offset: if prefixed { 0.0 } else { atom.offset },
            dimension: atom.dimension,
            cost: 0,
        })
    };
    read(0, name, false)
        .or_else(|| PREFIXES.iter().find_map(|(prefix, tens)| read(*tens, name.strip_prefix(prefix)?, true)))
}
