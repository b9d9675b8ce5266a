//! GUID (FMI 2) and instantiation token (FMI 3) of an archive.
//!
//! A token has 128 bits: the hash of the variable table, in which the last 64 bits are combined (exclusive or) with a fingerprint of the
//! archive's contents. Start values have 32 bits of it, terms 16 and the load table 16; the bits of an empty content are zero, those of any
//! other content are not. So the first 64 bits select the model, and archives with different contents have different tokens. Importers that
//! cache FMUs by their token need this. The token of an archive without contents is the hash of the variable table.

use crate::load_table::LoadTable;
use crate::terms::{GenericTerm, Law};
use declare::{Kind, Variable};
use std::fmt;

/// A token: hash of the variable table, combined with the fingerprint of the contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token {
    model: u64,
    rest: u64,
}

impl Token {
    /// The token of an archive without contents: two hashes of everything that must be equal in a library and its model description,
    /// except for the start values.
    pub(crate) fn of_table<'a>(
        model: &str,
        variables: impl Iterator<Item = (u32, &'a str, &'static Variable)>,
    ) -> Token {
        let mut text = String::from(model);
        for (value_reference, name, r) in variables {
            text.push_str(&format!(
                "|{} {} {:?} {:?} {} {} {} {}",
                value_reference,
                name,
                r.causality,
                r.variability,
                r.unit.name(),
                r.min,
                r.max,
                match r.kind {
                    Kind::Real => "real".to_string(),
                    Kind::Integer => "integer".to_string(),
                    Kind::Boolean => "boolean".to_string(),
                    Kind::Enumeration(t) =>
                        t.items.iter().map(|i| format!("{}={},", i.name, i.value)).collect(),
                }
            ));
        }
        let hash = |offset: u64| Hash(offset).with_bytes(text.as_bytes()).0;
        Token { model: hash(Hash::OFFSET), rest: hash(0x6c62_272e_07bb_0142) }
    }

    /// The token of an archive with these contents, of the model with this token.
    #[must_use]
    pub fn with(self, contents: Contents) -> Token {
        Token { rest: self.rest ^ contents.bits(), ..self }
    }

    /// The token in this text, which must be in the format of [`Display`](fmt::Display).
    pub fn parse(text: &str) -> Option<Token> {
        let digits: String = text.chars().filter(char::is_ascii_hexdigit).collect();
        let half = |digits: Option<&str>| u64::from_str_radix(digits?, 16).ok();
        let token = Token { model: half(digits.get(..16))?, rest: half(digits.get(16..))? };
        (token.to_string() == text).then_some(token)
    }

    /// Whether both are tokens of the same model, whatever their contents.
    pub fn is_model(self, other: Token) -> bool {
        self.model == other.model
    }

    /// The contents of the archive with this token, of the model with the token `table`.
    pub fn contents(self, table: Token) -> Contents {
        let bits = self.rest ^ table.rest;
        Contents { starts: (bits >> 32) as u32, terms: (bits >> 16) as u16, load: bits as u16 }
    }
}

impl fmt::Display for Token {
    /// The format of a GUID, which FMI 2 importers expect.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Token { model: a, rest: b } = self;
        write!(
            f,
            "{{{:08x}-{:04x}-{:04x}-{:04x}-{:012x}}}",
            a >> 32,
            (a >> 16) & 0xffff,
            a & 0xffff,
            b >> 48,
            b & 0xffff_ffff_ffff
        )
    }
}

/// Fingerprint of the contents of an archive: each number is zero if the content is empty, and only then.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// Start values in the library ([`start_values`](crate::start_values)).
    pub starts: u32,
    /// Terms.
    pub terms: u16,
    /// Load table.
    pub load: u16,
}

impl Contents {
    /// The fingerprint of these start values (value reference, value), terms and load table.
    pub(crate) fn of(
        starts: impl IntoIterator<Item = (u32, f64)>,
        terms: &[GenericTerm],
        load: Option<&LoadTable>,
    ) -> Contents {
        let folded = |hash: u64| (hash >> 32) as u32 ^ hash as u32;
        let short = |hash: u64| (folded(hash) >> 16) as u16 ^ folded(hash) as u16;
        // Zero is reserved for no content.
        Contents {
            starts: of_starts(starts).map_or(0, |hash| folded(hash).max(1)),
            terms: of_terms(terms).map_or(0, |hash| short(hash).max(1)),
            load: load.map_or(0, |table| short(of_load(table)).max(1)),
        }
    }

    fn bits(self) -> u64 {
        u64::from(self.starts) << 32 | u64::from(self.terms) << 16 | u64::from(self.load)
    }
}

/// Fingerprints of terms and load table, which with the model determine the equations; zero if there are none.
pub(crate) fn of_equations(terms: &[GenericTerm], load: Option<&LoadTable>) -> [u64; 2] {
    [of_terms(terms).unwrap_or(0), load.map_or(0, of_load)]
}

/// The FNV-1a hash.
#[derive(Clone, Copy)]
struct Hash(u64);

impl Hash {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const NEW: Hash = Hash(Hash::OFFSET);

    fn with_bytes(self, bytes: &[u8]) -> Hash {
        Hash(
            bytes
                .iter()
                .fold(self.0, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)),
        )
    }

    fn with(self, number: f64) -> Hash {
        self.with_bytes(&number.to_le_bytes())
    }

    /// With the numbers and, because several lists may follow each other, their count.
    fn with_all(self, numbers: &[f64]) -> Hash {
        numbers.iter().fold(self.with_count(numbers.len()), |hash, number| hash.with(*number))
    }

    fn with_count(self, count: usize) -> Hash {
        self.with_bytes(&(count as u64).to_le_bytes())
    }

    /// Names are not numbered, so that a new driver or port changes no fingerprint.
    fn with_name(self, name: &str) -> Hash {
        self.with_count(name.len()).with_bytes(name.as_bytes())
    }
}

fn of_starts(starts: impl IntoIterator<Item = (u32, f64)>) -> Option<u64> {
    starts
        .into_iter()
        .fold(None, |hash: Option<Hash>, (value_reference, value)| {
            Some(hash.unwrap_or(Hash::NEW).with_bytes(&value_reference.to_le_bytes()).with(value))
        })
        .map(|hash| hash.0)
}

fn of_terms(terms: &[GenericTerm]) -> Option<u64> {
    (!terms.is_empty()).then(|| terms.iter().fold(Hash::NEW.with_count(terms.len()), with_term).0)
}

fn with_term(hash: Hash, term: &GenericTerm) -> Hash {
    let hash = hash.with_name(term.port.name());
    let hash = match &term.law {
        Law::Product(product) => {
            let hash = hash.with_name("product").with(product.coefficient);
            let factors = product.factors.iter().flatten();
            let hash = hash.with_count(factors.clone().count());
            factors.fold(hash, |hash, factor| {
                let (low, high) = factor.range;
                hash.with_name(factor.driver.name()).with_all(&[
                    factor.offset,
                    factor.reference,
                    factor.exponent,
                    low,
                    high,
                ])
            })
        }
        Law::Table(table) => {
            let (x, y) = table.points();
            hash.with_name("table").with_name(table.driver.name()).with_all(x).with_all(y)
        }
        Law::Grid(grid) => {
            let drivers = grid.drivers.iter();
            let hash = drivers.fold(hash.with_name("grid"), |hash, driver| hash.with_name(driver.name()));
            let hash = hash.with_all(grid.points(0)).with_all(grid.points(1));
            grid.values().fold(hash, Hash::with_all)
        }
    };
    match term.lag {
        None => hash.with_name(""),
        Some(lag) => hash.with_name(lag.driver.name()).with(lag.tau).with_name(if lag.difference {
            "difference"
        } else {
            "lag"
        }),
    }
}

fn of_load(table: &LoadTable) -> u64 {
    let lists = [&table.times, &table.torques, &table.speeds];
    let hash = lists.iter().fold(Hash::NEW, |hash, list| hash.with_all(list));
    // No angle is another table than the angle zero.
    hash.with(table.period).with_all(table.angle.as_slice()).0
}

#[cfg(test)]
mod tests;
