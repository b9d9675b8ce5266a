//! The get and set functions of one C type in both standards.
use std::ffi::{c_char, c_int, c_void};

/// An instance of the FMU.
pub(crate) type Handle = *mut c_void;
pub(crate) type Text = *const c_char;
type Get2<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T) -> c_int;
type Set2<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T) -> c_int;
type Get3<T> = unsafe extern "C" fn(Handle, *const u32, usize, *mut T, usize) -> c_int;
type Set3<T> = unsafe extern "C" fn(Handle, *const u32, usize, *const T, usize) -> c_int;

/// The get and set functions of one C type. FMI 2 has as many values as references.
pub(super) enum Accessor<T> {
    Fmi2 { get: Option<Get2<T>>, set: Option<Set2<T>> },
    Fmi3 { get: Option<Get3<T>>, set: Option<Set3<T>> },
}

impl<T> Accessor<T> {
    /// Whether there is a get function, and a set function.
    pub(super) fn has(&self) -> (bool, bool) {
        match self {
            Self::Fmi2 { get, set } => (get.is_some(), set.is_some()),
            Self::Fmi3 { get, set } => (get.is_some(), set.is_some()),
        }
    }

    /// Reads values; `None` without the function, or where FMI 2 would read past the end.
    #[inline]
    pub(super) fn get(&self, h: Handle, vrs: &[u32], values: &mut [T]) -> Option<c_int> {
        let (v, n, x, m) = (vrs.as_ptr(), vrs.len(), values.as_mut_ptr(), values.len());
        // SAFETY: the function belongs to the loaded library, the handle is alive, and lengths go with their pointers.
        unsafe {
            match self {
                Self::Fmi2 { get, .. } if n == m => get.map(|get| get(h, v, n, x)),
                Self::Fmi2 { .. } => None,
                Self::Fmi3 { get, .. } => get.map(|get| get(h, v, n, x, m)),
            }
        }
    }

    /// Sets values; `None` as for [`Self::get`].
    #[inline]
    pub(super) fn set(&self, h: Handle, vrs: &[u32], values: &[T]) -> Option<c_int> {
        let (v, n, x, m) = (vrs.as_ptr(), vrs.len(), values.as_ptr(), values.len());
        // SAFETY: as in `get`.
        unsafe {
            match self {
                Self::Fmi2 { set, .. } if n == m => set.map(|set| set(h, v, n, x)),
                Self::Fmi2 { .. } => None,
                Self::Fmi3 { set, .. } => set.map(|set| set(h, v, n, x, m)),
            }
        }
    }
}
