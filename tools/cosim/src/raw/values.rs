//! Reading and setting variables. Numbers of all C types are converted to and from the type that the caller has.
use super::RawInstance;
use super::accessor::Text;
use super::functions::{Functions, value_id};
use crate::log::text_of;
use crate::{FmiVersion, Kind, Status};
use std::ffi::{CStr, c_int};
use std::ptr;

/// A number of a C type.
pub(crate) trait Cell: Copy + Default {
    fn from_f64(value: f64) -> Self;
    fn from_i128(value: i128) -> Self;
    fn f64(self) -> f64;
    fn i128(self) -> i128;
}

macro_rules! cells {
    ($($float:ty)*; $($integer:ty)*) => {
        $(impl Cell for $float {
            fn from_f64(value: f64) -> Self { value as Self }
            fn from_i128(value: i128) -> Self { value as Self }
            fn f64(self) -> f64 { self.into() }
            fn i128(self) -> i128 { self as i128 }
        })*
        $(impl Cell for $integer {
            fn from_f64(value: f64) -> Self { value.round() as Self }
            fn from_i128(value: i128) -> Self { value as Self }
            fn f64(self) -> f64 { self as f64 }
            fn i128(self) -> i128 { self.into() }
        })*
    };
}
cells!(f64 f32; i8 u8 i16 u16 i32 u32 i64 u64);

/// A number as the caller has it.
pub(crate) trait Number: Copy {
    fn of<C: Cell>(value: C) -> Self;
    fn to<C: Cell>(self) -> C;
    fn is_true(self) -> bool;
}

impl Number for f64 {
    fn of<C: Cell>(value: C) -> Self {
        value.f64()
    }
    fn to<C: Cell>(self) -> C {
        C::from_f64(self)
    }
    fn is_true(self) -> bool {
        self != 0.0
    }
}

/// Cut to the range of `i64`.
impl Number for i64 {
    fn of<C: Cell>(value: C) -> Self {
        value.i128().clamp(i64::MIN.into(), i64::MAX.into()) as i64
    }
    fn to<C: Cell>(self) -> C {
        C::from_i128(self.into())
    }
    fn is_true(self) -> bool {
        self != 0
    }
}

/// Holds every integer type.
impl Number for i128 {
    fn of<C: Cell>(value: C) -> Self {
        value.i128()
    }
    fn to<C: Cell>(self) -> C {
        C::from_i128(self)
    }
    fn is_true(self) -> bool {
        self != 0
    }
}

impl Number for bool {
    fn of<C: Cell>(value: C) -> Self {
        value.i128() != 0
    }
    fn to<C: Cell>(self) -> C {
        C::from_i128(self.into())
    }
    fn is_true(self) -> bool {
        self
    }
}

/// Values that are converted at once; a stack buffer of that many keeps the hot calls free of allocation.
const CHUNK: usize = 64;

/// Reads `C` values with `call` and converts them. One value for each reference goes in chunks over the stack;
/// arrays need a buffer, as their boundaries are not known here.
fn convert_get<C: Copy + Default, U>(
    vrs: &[u32],
    values: &mut [U],
    mut call: impl FnMut(&[u32], &mut [C]) -> Option<c_int>,
    to: impl Fn(C) -> U,
) -> Option<c_int> {
    let mut read = |v: &[u32], out: &mut [U], buffer: &mut [C]| {
        let status = call(v, buffer)?;
        if status <= 1 {
            out.iter_mut().zip(buffer).for_each(|(o, x)| *o = to(*x));
        }
        Some(status)
    };
    if vrs.len() != values.len() {
        return read(vrs, values, &mut vec![C::default(); values.len()]);
    }
    let mut worst = 0;
    for (v, out) in vrs.chunks(CHUNK).zip(values.chunks_mut(CHUNK)) {
        let mut buffer = [C::default(); CHUNK];
        worst = worst.max(read(v, out, &mut buffer[..v.len()])?);
        if worst > 1 {
            break;
        }
    }
    Some(worst)
}

/// Converts values to `C` and sets them with `call`; the mirror of [`convert_get`].
fn convert_set<C: Copy + Default, U: Copy>(
    vrs: &[u32],
    values: &[U],
    mut call: impl FnMut(&[u32], &[C]) -> Option<c_int>,
    from: impl Fn(U) -> C,
) -> Option<c_int> {
    if vrs.len() != values.len() {
        return call(vrs, &values.iter().map(|v| from(*v)).collect::<Vec<C>>());
    }
    let mut worst = 0;
    for (v, x) in vrs.chunks(CHUNK).zip(values.chunks(CHUNK)) {
        let mut buffer = [C::default(); CHUNK];
        buffer.iter_mut().zip(x).for_each(|(b, x)| *b = from(*x));
        worst = worst.max(call(v, &buffer[..v.len()])?);
        if worst > 1 {
            break;
        }
    }
    Some(worst)
}

/// `$body` with `$accessor` for the numeric kind; FMI 2 has `double` and `int` alone. `None` for other kinds.
macro_rules! with_accessor {
    ($functions:expr, $version:expr, $kind:expr, $accessor:ident => $body:expr) => {{
        let f: &Functions = $functions;
        macro_rules! with {
            ($field:ident) => {{
                let $accessor = &f.$field;
                $body
            }};
        }
        match ($version, $kind) {
            (_, Kind::String | Kind::Binary | Kind::Clock | Kind::Boolean) => None,
            (_, Kind::Float64) | (FmiVersion::V2, Kind::Float32) => with!(float64),
            (_, Kind::Int32) | (FmiVersion::V2, _) => with!(int32),
            (_, Kind::Float32) => with!(float32),
            (_, Kind::Int8) => with!(int8),
            (_, Kind::UInt8) => with!(uint8),
            (_, Kind::Int16) => with!(int16),
            (_, Kind::UInt16) => with!(uint16),
            (_, Kind::UInt32) => with!(uint32),
            (_, Kind::Int64 | Kind::Enumeration) => with!(int64),
            (_, Kind::UInt64) => with!(uint64),
        }
    }};
}

impl RawInstance {
    /// Reads `Float64` variables (FMI 2: `Real`) without any conversion.
    #[inline]
    pub(crate) fn get_f64(&mut self, vrs: &[u32], values: &mut [f64]) -> Status {
        self.status(value_id(false, Kind::Float64), |f, h| f.float64.get(h, vrs, values))
    }

    /// Sets `Float64` variables (FMI 2: `Real`) without any conversion.
    #[inline]
    pub(crate) fn set_f64(&mut self, vrs: &[u32], values: &[f64]) -> Status {
        self.status(value_id(true, Kind::Float64), |f, h| f.float64.set(h, vrs, values))
    }

    /// Reads variables of one numeric kind; for FMI 3 arrays the values of all elements follow each other.
    pub fn get(&mut self, kind: Kind, vrs: &[u32], values: &mut [f64]) -> Status {
        if kind == Kind::Float64 { self.get_f64(vrs, values) } else { self.get_as(kind, vrs, values) }
    }

    /// Sets variables of one numeric kind; numbers are rounded for integers and cut to what the type can hold.
    pub fn set(&mut self, kind: Kind, vrs: &[u32], values: &[f64]) -> Status {
        if kind == Kind::Float64 { self.set_f64(vrs, values) } else { self.set_as(kind, vrs, values) }
    }

    /// Reads integers of any type without loss.
    pub fn get_integers(&mut self, kind: Kind, vrs: &[u32], values: &mut [i128]) -> Status {
        self.get_as(kind, vrs, values)
    }

    /// Reads variables of one numeric kind.
    pub(crate) fn get_as<U: Number>(&mut self, kind: Kind, vrs: &[u32], values: &mut [U]) -> Status {
        let version = self.version();
        self.status(value_id(false, kind), |f, h| {
            // A Boolean may be any byte or number but 0.
            let boolean = |is_true: bool| U::of(u8::from(is_true));
            match (version, kind) {
                (FmiVersion::V2, Kind::Boolean) => {
                    convert_get(vrs, values, |v, x| f.boolean2.get(h, v, x), |c| boolean(c != 0))
                }
                (FmiVersion::V3, Kind::Boolean) => {
                    convert_get(vrs, values, |v, x| f.boolean3.get(h, v, x), |c| boolean(c != 0))
                }
                _ => with_accessor!(f, version, kind, a => convert_get(vrs, values, |v, x| a.get(h, v, x), U::of)),
            }
        })
    }

    /// Sets variables of one numeric kind.
    pub(crate) fn set_as<U: Number>(&mut self, kind: Kind, vrs: &[u32], values: &[U]) -> Status {
        let version = self.version();
        self.status(value_id(true, kind), |f, h| match (version, kind) {
            (FmiVersion::V2, Kind::Boolean) => {
                convert_set(vrs, values, |v, x| f.boolean2.set(h, v, x), |u| u.is_true().into())
            }
            (FmiVersion::V3, Kind::Boolean) => {
                convert_set(vrs, values, |v, x| f.boolean3.set(h, v, x), |u| u.is_true().into())
            }
            _ => {
                with_accessor!(f, version, kind, a => convert_set(vrs, values, |v, x| a.set(h, v, x), U::to))
            }
        })
    }

    /// Reads scalar strings.
    pub fn get_strings(&mut self, vrs: &[u32]) -> Result<Vec<String>, Status> {
        let mut texts: Vec<Text> = vec![ptr::null(); vrs.len()];
        let status = self.status(value_id(false, Kind::String), |f, h| f.string.get(h, vrs, &mut texts));
        if status > Status::Warning {
            return Err(status);
        }
        // SAFETY: each is NULL or a C string that the FMU keeps until the next call.
        Ok(texts.into_iter().map(|text| unsafe { text_of(text) }).collect())
    }

    /// Reads binary variables.
    pub fn get_binaries(&mut self, vrs: &[u32]) -> Result<Vec<Vec<u8>>, Status> {
        let mut sizes = vec![0_usize; vrs.len()];
        let mut data: Vec<*const u8> = vec![ptr::null(); vrs.len()];
        let (v, n) = (vrs.as_ptr(), vrs.len());
        let (sizes_at, data_at) = (sizes.as_mut_ptr(), data.as_mut_ptr());
        // SAFETY: the function belongs to the loaded library, the handle is alive, all lists have `n` entries.
        let status = self.status(value_id(false, Kind::Binary), |f, h| {
            // SAFETY: see above.
            f.get_binary.map(|f| unsafe { f(h, v, n, sizes_at, data_at, n) })
        });
        if status > Status::Warning {
            return Err(status);
        }
        // SAFETY: the FMU promises that many bytes behind each pointer until the next call.
        let copy = |(data, size): (&*const u8, &usize)| unsafe {
            if data.is_null() { Vec::new() } else { std::slice::from_raw_parts(*data, *size).to_vec() }
        };
        Ok(data.iter().zip(&sizes).map(copy).collect())
    }

    /// Sets binary variables.
    pub fn set_binaries(&mut self, vrs: &[u32], values: &[&[u8]]) -> Status {
        let sizes: Vec<usize> = values.iter().map(|v| v.len()).collect();
        let data: Vec<*const u8> = values.iter().map(|v| v.as_ptr()).collect();
        let (v, n, m) = (vrs.as_ptr(), vrs.len(), values.len());
        let (sizes, data) = (sizes.as_ptr(), data.as_ptr());
        // SAFETY: as in `get_binaries`; the data outlive the call.
        self.status(value_id(true, Kind::Binary), |f, h| {
            // SAFETY: see above.
            f.set_binary.map(|f| unsafe { f(h, v, n, sizes, data, m) })
        })
    }

    /// Sets strings.
    pub fn set_strings(&mut self, vrs: &[u32], values: &[&CStr]) -> Status {
        let texts: Vec<Text> = values.iter().map(|v| v.as_ptr()).collect();
        self.status(value_id(true, Kind::String), |f, h| f.string.set(h, vrs, &texts))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_cover_everything_once_and_stop_at_an_error() {
        let vrs: Vec<u32> = (0..150).collect();
        let mut values = vec![0i64; 150];
        let call = |v: &[u32], x: &mut [i32]| {
            v.iter().zip(x).for_each(|(v, x)| *x = *v as i32 * 2);
            Some(0)
        };
        assert_eq!(convert_get(&vrs, &mut values, call, i64::from), Some(0));
        assert!(values.iter().enumerate().all(|(i, v)| *v == 2 * i as i64));
        let mut calls = 0;
        let refuse = |_: &[u32], _: &[i32]| {
            calls += 1;
            Some(3)
        };
        assert_eq!(convert_set(&vrs, &values, refuse, |x| x as i32), Some(3));
        assert_eq!(calls, 1);
    }

    #[test]
    fn numbers_are_rounded_and_cut() {
        assert_eq!(Number::to::<i8>(2.5), 3);
        assert_eq!(Number::to::<u8>(-1.0), 0);
        assert_eq!(<i64 as Number>::of(u64::MAX), i64::MAX);
        assert_eq!(<i128 as Number>::of(u64::MAX), u64::MAX.into());
        assert_eq!(Number::to::<i64>(-9_007_199_254_740_993_i128), -9_007_199_254_740_993);
        assert!(<bool as Number>::of(2u8) && (-1_i64).is_true() && !0.0.is_true());
    }
}
