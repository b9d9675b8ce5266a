//! FMI 3.0 getters and setters. Variables have the types Float64, Int64 (integers and enumerations), UInt64 (array sizes) and Boolean;
//! calls for other types return an error. The elements of an array are consecutive.

use super::Boolean;
use crate::boundary::{Out, array};
use crate::functions;
use crate::instance::Type;
use std::ffi::c_char;

/// Getter and setter of one type.
macro_rules! values {
    ($($get:ident, $set:ident, $value:ty, $of:expr, $from:expr, $to:expr;)*) => {
        functions! {
            enter;
            $(/// Reads values.
            fn $get(vr: *const u32, n: usize, value: *mut $value, n_values: usize) => |i| {
                let (vr, value) = (array(vr, n, "valueReferences")?, Out::array(value, n_values, "values")?);
                i.get(vr, $of, n_values, |k, number| value.set(k, $from(number)))
            };
            /// Sets values, all or none.
            fn $set(vr: *const u32, n: usize, value: *const $value, n_values: usize) => |i| {
                let (vr, value) = (array(vr, n, "valueReferences")?, array(value, n_values, "values")?);
                i.set(vr, $of, n_values, |k| $to(value[k]))
            };)*
        }
    };
}

/// A type without variables: the values are neither written nor read.
fn none<T>(_: T) -> f64 {
    f64::NAN
}

values! {
    fmi3GetFloat64, fmi3SetFloat64, f64, Type::Real, |x| x, |x| x;
    fmi3GetInt64, fmi3SetInt64, i64, Type::Integer, |x| x as i64, |x| x as f64;
    fmi3GetBoolean, fmi3SetBoolean, Boolean, Type::Boolean, |x| u8::from(x != 0.0), |x| f64::from(u8::from(x != 0));
    fmi3GetFloat32, fmi3SetFloat32, f32, Type::Absent("Float32"), |_| 0.0, none;
    fmi3GetInt8, fmi3SetInt8, i8, Type::Absent("Int8"), |_| 0, none;
    fmi3GetUInt8, fmi3SetUInt8, u8, Type::Absent("UInt8"), |_| 0, none;
    fmi3GetInt16, fmi3SetInt16, i16, Type::Absent("Int16"), |_| 0, none;
    fmi3GetUInt16, fmi3SetUInt16, u16, Type::Absent("UInt16"), |_| 0, none;
    fmi3GetInt32, fmi3SetInt32, i32, Type::Absent("Int32"), |_| 0, none;
    fmi3GetUInt32, fmi3SetUInt32, u32, Type::Absent("UInt32"), |_| 0, none;
    fmi3GetUInt64, fmi3SetUInt64, u64, Type::Size, |x| x as u64, |x| x as f64;
    fmi3GetString, fmi3SetString, *const c_char, Type::Absent("String"), |_| c"".as_ptr(), none;
}

functions! {
    enter;
    /// Reads binary values.
    fn fmi3GetBinary(vr: *const u32, n: usize, _sizes: *mut usize, _values: *mut *const u8, n_values: usize) =>
        |i| i.get(array(vr, n, "valueReferences")?, Type::Absent("Binary"), n_values, |_, _| {});
    /// Sets binary values.
    fn fmi3SetBinary(
        vr: *const u32, n: usize, _sizes: *const usize, _values: *const *const u8, n_values: usize
    ) => |i| i.set(array(vr, n, "valueReferences")?, Type::Absent("Binary"), n_values, none);
    /// Reads clocks.
    fn fmi3GetClock(vr: *const u32, n: usize, _values: *mut Boolean) =>
        |i| i.get(array(vr, n, "valueReferences")?, Type::Absent("Clock"), n, |_, _| {});
    /// Sets clocks.
    fn fmi3SetClock(vr: *const u32, n: usize, _values: *const Boolean) =>
        |i| i.set(array(vr, n, "valueReferences")?, Type::Absent("Clock"), n, none);
}
