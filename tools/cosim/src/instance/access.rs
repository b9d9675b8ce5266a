//! Reading and setting variables.
use super::{Instance, Names};
use crate::raw::{Number, c_string, value_names};
use crate::value::integer_limits;
use crate::{Error, Kind, Status, Value, Variable};
use std::ffi::{CStr, CString};
use std::fmt::Display;

impl Instance {
    /// Reads `Float64` variables (FMI 2: `Real`).
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length.
    pub fn get_f64(&mut self, vrs: &[u32], values: &mut [f64]) -> Result<(), Error> {
        self.get_number(Kind::Float64, vrs, values)
    }

    /// Sets `Float64` variables (FMI 2: `Real`).
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length.
    pub fn set_f64(&mut self, vrs: &[u32], values: &[f64]) -> Result<(), Error> {
        self.set_number(Kind::Float64, vrs, values)
    }

    /// Reads integers or enumerations, all of the same `kind`. Numbers above `i64::MAX` are cut to it.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length or a kind that is no integer.
    pub fn get_i64(&mut self, kind: Kind, vrs: &[u32], values: &mut [i64]) -> Result<(), Error> {
        self.read(kind, vrs, values, Kind::is_integer, "integer")
    }

    /// Sets integers or enumerations, all of the same `kind`.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] as for [`Self::get_i64`] and for a value that its type cannot hold.
    pub fn set_i64(&mut self, kind: Kind, vrs: &[u32], values: &[i64]) -> Result<(), Error> {
        let (low, high) = self.integer_limits(kind);
        let fits = |v: &i64| (low..=high).contains(&(*v).into());
        self.write(kind, vrs, values, (Kind::is_integer, "integer"), fits)
    }

    /// Reads integers of any type without loss.
    ///
    /// # Errors
    /// As [`Self::get_i64`].
    pub fn get_integers(&mut self, kind: Kind, vrs: &[u32], values: &mut [i128]) -> Result<(), Error> {
        self.read(kind, vrs, values, Kind::is_integer, "integer")
    }

    /// Sets integers of any type without loss.
    ///
    /// # Errors
    /// As [`Self::set_i64`].
    pub fn set_integers(&mut self, kind: Kind, vrs: &[u32], values: &[i128]) -> Result<(), Error> {
        let (low, high) = self.integer_limits(kind);
        self.write(kind, vrs, values, (Kind::is_integer, "integer"), |v| (low..=high).contains(v))
    }

    /// Reads binary variables.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn get_binary(&mut self, vrs: &[u32]) -> Result<Vec<Vec<u8>>, Error> {
        let mut read = Vec::new();
        self.call(names(Verb::Get, Kind::Binary), |raw| match raw.get_binaries(vrs) {
            Ok(bytes) => {
                read = bytes;
                Status::Ok
            }
            Err(status) => status,
        })?;
        Ok(read)
    }

    /// Reads Booleans.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length.
    pub fn get_bool(&mut self, vrs: &[u32], values: &mut [bool]) -> Result<(), Error> {
        self.read(Kind::Boolean, vrs, values, Kind::is_numeric, "numeric")
    }

    /// Sets Booleans.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length.
    pub fn set_bool(&mut self, vrs: &[u32], values: &[bool]) -> Result<(), Error> {
        self.write(Kind::Boolean, vrs, values, (Kind::is_numeric, "numeric"), |_| true)
    }

    /// Reads scalar strings.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub fn get_string(&mut self, vrs: &[u32]) -> Result<Vec<String>, Error> {
        let mut texts = Vec::new();
        self.call(names(Verb::Get, Kind::String), |raw| match raw.get_strings(vrs) {
            Ok(read) => {
                texts = read;
                Status::Ok
            }
            Err(status) => status,
        })?;
        Ok(texts)
    }

    /// Sets strings. A NUL ends a string early.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length.
    pub fn set_string(&mut self, vrs: &[u32], values: &[&str]) -> Result<(), Error> {
        let names = names(Verb::Set, Kind::String);
        if !self.fits(names, vrs.len(), values.len())? {
            return Ok(());
        }
        let owned: Vec<CString> = values.iter().map(|v| c_string(v)).collect();
        let texts: Vec<&CStr> = owned.iter().map(CString::as_c_str).collect();
        self.call(names, |raw| raw.set_strings(vrs, &texts))
    }

    /// Reads variables of one numeric `kind` as numbers: integers and enumerations as such (exact to 2^53),
    /// Booleans as 0 and 1.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for lists of different length or a kind that is no number.
    pub fn get_number(&mut self, kind: Kind, vrs: &[u32], values: &mut [f64]) -> Result<(), Error> {
        if kind == Kind::Float64 && vrs.len() == values.len() && !vrs.is_empty() {
            return self.call(GET_REAL, |raw| raw.get_f64(vrs, values));
        }
        self.read(kind, vrs, values, Kind::is_numeric, "numeric")
    }

    /// Sets variables of one numeric `kind` from numbers: rounded for integers, different from 0 is true.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] as for [`Self::get_number`] and for a value that its type cannot hold.
    pub fn set_number(&mut self, kind: Kind, vrs: &[u32], values: &[f64]) -> Result<(), Error> {
        if kind == Kind::Float64 && vrs.len() == values.len() && !vrs.is_empty() {
            return self.call(SET_REAL, |raw| raw.set_f64(vrs, values));
        }
        let (low, high) = self.integer_limits(kind);
        let fits = |v: &f64| v.is_finite() && v.round() >= low as f64 && v.round() <= high as f64;
        let any = !kind.is_integer();
        self.write(kind, vrs, values, (Kind::is_numeric, "numeric"), |v| any || fits(v))
    }

    /// Reads values of a kind that must pass `is_kind`, called `word` in messages.
    fn read<U: Number>(
        &mut self,
        kind: Kind,
        vrs: &[u32],
        values: &mut [U],
        is_kind: fn(Kind) -> bool,
        word: &str,
    ) -> Result<(), Error> {
        let names = names(Verb::Get, kind);
        if !self.fits(names, vrs.len(), values.len())? {
            return Ok(());
        }
        if !is_kind(kind) {
            return Err(self.misuse(names, format!("{kind:?} is no {word} type")));
        }
        self.call(names, |raw| raw.get_as(kind, vrs, values))
    }

    /// Sets values that must be `allowed`; the rest as in [`Self::read`].
    fn write<U: Number + Display>(
        &mut self,
        kind: Kind,
        vrs: &[u32],
        values: &[U],
        (is_kind, word): (fn(Kind) -> bool, &str),
        allowed: impl Fn(&U) -> bool,
    ) -> Result<(), Error> {
        let names = names(Verb::Set, kind);
        if !self.fits(names, vrs.len(), values.len())? {
            return Ok(());
        }
        if !is_kind(kind) {
            return Err(self.misuse(names, format!("{kind:?} is no {word} type")));
        }
        if let Some(value) = values.iter().find(|v| !allowed(v)) {
            let (low, high) = self.integer_limits(kind);
            return Err(self.misuse(names, format!("{value} is not in {low} ... {high}")));
        }
        self.call(names, |raw| raw.set_as(kind, vrs, values))
    }

    /// Sets one scalar variable.
    ///
    /// # Errors
    /// [`Error::Call`], [`Error::Misuse`] for a value of another type.
    pub fn set_value(&mut self, variable: &Variable, value: &Value) -> Result<(), Error> {
        let vr = &[variable.value_reference];
        match (value, variable.kind) {
            (Value::Real(x), kind) if kind.is_float() => self.set_number(kind, vr, &[*x]),
            (Value::Integer(x), kind) => {
                let (low, high) = self.integer_limits(kind);
                let fits = |v: &i128| (low..=high).contains(v);
                self.write(kind, vr, &[*x], (Kind::is_integer, "integer"), fits)
            }
            (Value::Binary(x), Kind::Binary) => {
                self.call(names(Verb::Set, Kind::Binary), |raw| raw.set_binaries(vr, &[x]))
            }
            (Value::Boolean(x), Kind::Boolean) => self.set_bool(vr, &[*x]),
            (Value::String(x), Kind::String) => self.set_string(vr, &[x]),
            _ => Err(self.misuse(
                names(Verb::Set, variable.kind),
                format!("{} is a {:?} and cannot take {value:?}", variable.name, variable.kind),
            )),
        }
    }

    /// Whether there is anything to do; an error if the lists cannot belong together. For FMI 3 there may be more
    /// values than references, as arrays have several.
    #[inline]
    pub(super) fn fits(&self, names: Names, vrs: usize, values: usize) -> Result<bool, Error> {
        let good = if self.is_fmi2() { vrs == values } else { vrs <= values && (vrs > 0 || values == 0) };
        if good {
            Ok(vrs > 0)
        } else {
            Err(self.misuse(names, format!("{values} values for {vrs} variables")))
        }
    }

    /// FMI 2 has C `int` alone.
    fn integer_limits(&self, kind: Kind) -> (i128, i128) {
        integer_limits(if self.is_fmi2() { Kind::Int32 } else { kind })
    }
}

/// What is done with variables.
#[derive(Clone, Copy)]
enum Verb {
    Get,
    Set,
}

/// Functions that masters call at every step.
const GET_REAL: [&str; 2] = names(Verb::Get, Kind::Float64);
const SET_REAL: [&str; 2] = names(Verb::Set, Kind::Float64);

/// The names of the get or set function of a kind, for messages.
const fn names(verb: Verb, kind: Kind) -> Names {
    value_names(matches!(verb, Verb::Set), kind)
}
