//! Reading and setting variables, numbers of all types as `f64`.
use super::RawInstance;
use super::functions::{Api, Functions3, Get, Handle, Set};
use crate::fmi2::c_string;
use crate::instance::{convert_get, convert_set};
use crate::log::text_of;
use crate::{Kind, Status};
use std::ffi::{CString, c_char, c_int};
use std::ptr;

/// Reads C values of type `T`.
fn read<T: Copy + Default>(
    function: Option<Get<T>>,
    handle: Handle,
    vrs: &[u32],
    values: &mut [f64],
    to: impl Fn(T) -> f64,
) -> Option<c_int> {
    let f = function?;
    // SAFETY: the function belongs to the loaded library, the handle is alive, and lengths go with their pointers.
    let call = |v: &[u32], x: &mut [T]| unsafe { f(handle, v.as_ptr(), v.len(), x.as_mut_ptr(), x.len()) };
    Some(convert_get(vrs, values, call, to))
}

/// Sets C values of type `T`.
fn write<T: Copy + Default>(
    function: Option<Set<T>>,
    handle: Handle,
    vrs: &[u32],
    values: &[f64],
    from: impl Fn(f64) -> T,
) -> Option<c_int> {
    let f = function?;
    // SAFETY: as in `read`.
    let call = |v: &[u32], x: &[T]| unsafe { f(handle, v.as_ptr(), v.len(), x.as_ptr(), x.len()) };
    Some(convert_set(vrs, values, call, from))
}

fn get3(f: &Functions3, h: Handle, kind: Kind, vrs: &[u32], x: &mut [f64]) -> Option<c_int> {
    match kind {
        Kind::Float64 => read(f.get_f64, h, vrs, x, |v: f64| v),
        Kind::Float32 => read(f.get_f32, h, vrs, x, f64::from),
        Kind::Int8 => read(f.get_i8, h, vrs, x, f64::from),
        Kind::UInt8 => read(f.get_u8, h, vrs, x, f64::from),
        Kind::Int16 => read(f.get_i16, h, vrs, x, f64::from),
        Kind::UInt16 => read(f.get_u16, h, vrs, x, f64::from),
        Kind::Int32 => read(f.get_i32, h, vrs, x, f64::from),
        Kind::UInt32 => read(f.get_u32, h, vrs, x, f64::from),
        Kind::Int64 | Kind::Enumeration => read(f.get_i64, h, vrs, x, |v| v as f64),
        Kind::UInt64 => read(f.get_u64, h, vrs, x, |v| v as f64),
        Kind::Boolean => read(f.get_bool, h, vrs, x, |v| f64::from(u8::from(v != 0))),
        Kind::String | Kind::Binary | Kind::Clock => None,
    }
}

fn set3(f: &Functions3, h: Handle, kind: Kind, vrs: &[u32], x: &[f64]) -> Option<c_int> {
    match kind {
        Kind::Float64 => write(f.set_f64, h, vrs, x, |v| v),
        Kind::Float32 => write(f.set_f32, h, vrs, x, |v| v as f32),
        Kind::Int8 => write(f.set_i8, h, vrs, x, |v| v as i8),
        Kind::UInt8 => write(f.set_u8, h, vrs, x, |v| v as u8),
        Kind::Int16 => write(f.set_i16, h, vrs, x, |v| v as i16),
        Kind::UInt16 => write(f.set_u16, h, vrs, x, |v| v as u16),
        Kind::Int32 => write(f.set_i32, h, vrs, x, |v| v as i32),
        Kind::UInt32 => write(f.set_u32, h, vrs, x, |v| v as u32),
        Kind::Int64 | Kind::Enumeration => write(f.set_i64, h, vrs, x, |v| v as i64),
        Kind::UInt64 => write(f.set_u64, h, vrs, x, |v| v as u64),
        Kind::Boolean => write(f.set_bool, h, vrs, x, |v| u8::from(v != 0.0)),
        Kind::String | Kind::Binary | Kind::Clock => None,
    }
}

impl RawInstance {
    /// Reads variables of one numeric kind; for FMI 3 arrays the values of all elements follow each other.
    pub fn get(&mut self, kind: Kind, vrs: &[u32], values: &mut [f64]) -> Status {
        self.status(|api, _, h| match api {
            // One value for each reference: FMI 2 has no arrays.
            Api::Two(_) if vrs.len() != values.len() => None,
            Api::Two(f) => match kind {
                Kind::Float64 | Kind::Float32 => {
                    let f = f.get_real?;
                    // SAFETY: as in `read`.
                    Some(unsafe { f(h, vrs.as_ptr(), vrs.len(), values.as_mut_ptr()) })
                }
                Kind::String | Kind::Binary | Kind::Clock => None,
                kind => {
                    let f = if kind == Kind::Boolean { f.get_boolean? } else { f.get_integer? };
                    // SAFETY: as in `read`.
                    let call =
                        |v: &[u32], x: &mut [c_int]| unsafe { f(h, v.as_ptr(), v.len(), x.as_mut_ptr()) };
                    Some(convert_get(vrs, values, call, f64::from))
                }
            },
            Api::Three(f) => get3(f, h, kind, vrs, values),
        })
    }

    /// Sets variables of one numeric kind; what a type cannot hold is cut to what it can.
    pub fn set(&mut self, kind: Kind, vrs: &[u32], values: &[f64]) -> Status {
        self.status(|api, _, h| match api {
            Api::Two(_) if vrs.len() != values.len() => None,
            Api::Two(f) => match kind {
                Kind::Float64 | Kind::Float32 => {
                    let f = f.set_real?;
                    // SAFETY: as in `read`.
                    Some(unsafe { f(h, vrs.as_ptr(), vrs.len(), values.as_ptr()) })
                }
                Kind::String | Kind::Binary | Kind::Clock => None,
                kind => {
                    let f = if kind == Kind::Boolean { f.set_boolean? } else { f.set_integer? };
                    // SAFETY: as in `read`.
                    let call = |v: &[u32], x: &[c_int]| unsafe { f(h, v.as_ptr(), v.len(), x.as_ptr()) };
                    Some(convert_set(vrs, values, call, |v| v as c_int))
                }
            },
            Api::Three(f) => set3(f, h, kind, vrs, values),
        })
    }

    /// Reads one scalar string.
    pub fn get_string(&mut self, vr: u32) -> Result<String, Status> {
        let mut text: *const c_char = ptr::null();
        let status = self.status(|api, _, h| match api {
            // SAFETY: as in `read`.
            Api::Two(f) => f.get_string.map(|f| unsafe { f(h, &vr, 1, &mut text) }),
            // SAFETY: as in `read`.
            Api::Three(f) => f.get_string.map(|f| unsafe { f(h, &vr, 1, &mut text, 1) }),
        });
        // SAFETY: NULL or a C string that the FMU keeps until the next call.
        if status <= Status::Warning { Ok(unsafe { text_of(text) }) } else { Err(status) }
    }

    /// Sets one scalar string.
    pub fn set_string(&mut self, vr: u32, value: &str) -> Status {
        let text: CString = c_string(value);
        let pointer = text.as_ptr();
        self.status(|api, _, h| match api {
            // SAFETY: as in `read`.
            Api::Two(f) => f.set_string.map(|f| unsafe { f(h, &vr, 1, &pointer) }),
            // SAFETY: as in `read`.
            Api::Three(f) => f.set_string.map(|f| unsafe { f(h, &vr, 1, &pointer, 1) }),
        })
    }
}
