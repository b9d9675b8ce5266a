//! From C to Rust and back: handles, arrays, strings, panics.

use crate::instance::Instance;
use crate::logger::Status;
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Why a call is not done.
#[derive(Debug)]
pub struct Refused {
    /// What the importer gets to see.
    pub status: Status,
    /// One sentence for its log.
    pub message: String,
}

impl Refused {
    /// A call that is not allowed.
    pub fn error(message: impl Into<String>) -> Refused {
        Refused { status: Status::Error, message: message.into() }
    }

    /// A value that is not taken.
    pub fn discard(message: impl Into<String>) -> Refused {
        Refused { status: Status::Discard, message: message.into() }
    }
}

/// What an operation gives.
pub type Outcome<T = ()> = Result<T, Refused>;

/// Runs an operation on the instance behind a handle; refusals and panics become a log line and a status.
///
/// # Safety
/// `handle` is NULL or a live instance of this library.
#[inline]
pub unsafe fn enter(
    handle: *mut c_void,
    name: &str,
    operation: impl FnOnce(&mut Instance) -> Outcome,
) -> Status {
    if handle.is_null() {
        return Status::Error;
    }
    // SAFETY: by contract; instances are not shared between threads during a call (FMI 2 section 2.1.1, FMI 3
    // section 2.2.1).
    let instance = unsafe { &mut *handle.cast::<Instance>() };
    let outcome = catch_unwind(AssertUnwindSafe(|| operation(instance)));
    match outcome {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(refused)) => {
            instance.log.tell(refused.status, &format!("{name}: {}", refused.message));
            refused.status
        }
        Err(_) => {
            instance.break_down();
            instance
                .log
                .tell(Status::Error, &format!("{name}: internal failure; only reset and free remain."));
            Status::Error
        }
    }
}

/// Makes an instance and hands it to the importer; NULL where that fails.
pub fn hand_out(make: impl FnOnce() -> Option<Instance>) -> *mut c_void {
    match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Some(instance)) => Box::into_raw(Box::new(instance)).cast(),
        _ => std::ptr::null_mut(),
    }
}

/// Takes an instance back and drops it.
///
/// # Safety
/// As [`enter`]; the handle is dead afterwards.
pub unsafe fn take_back(handle: *mut c_void) {
    if !handle.is_null() {
        // SAFETY: by contract the handle came from `hand_out`.
        let instance = unsafe { Box::from_raw(handle.cast::<Instance>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(instance)));
    }
}

/// The array of `n` elements at `pointer`.
///
/// # Safety
/// `pointer` is NULL or leads to `n` readable elements.
#[inline]
pub unsafe fn array<'a, T>(pointer: *const T, n: usize, what: &str) -> Outcome<&'a [T]> {
    match (n, pointer.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(Refused::error(format!("{what} is NULL though {n} elements are announced."))),
        // SAFETY: by contract.
        _ => Ok(unsafe { std::slice::from_raw_parts(pointer, n) }),
    }
}

/// The array of `n` elements at `pointer`, to be written.
///
/// # Safety
/// `pointer` is NULL or leads to `n` writable elements.
#[inline]
pub unsafe fn array_mut<'a, T>(pointer: *mut T, n: usize, what: &str) -> Outcome<&'a mut [T]> {
    match (n, pointer.is_null()) {
        (0, _) => Ok(&mut []),
        (_, true) => Err(Refused::error(format!("{what} is NULL though {n} elements are announced."))),
        // SAFETY: by contract.
        _ => Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) }),
    }
}

/// The place behind `pointer`.
///
/// # Safety
/// `pointer` is NULL or leads to a writable place.
#[inline]
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Outcome<&'a mut T> {
    // SAFETY: by contract.
    unsafe { pointer.as_mut() }.ok_or_else(|| Refused::error(format!("{what} is NULL.")))
}

/// Writes `value` where the importer gave a place for it.
///
/// # Safety
/// `pointer` is NULL or leads to a writable place.
pub unsafe fn write<T>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: by contract.
        unsafe { pointer.write(value) };
    }
}

/// The text at `pointer`; `None` for NULL. Bytes that are no UTF-8 are replaced.
///
/// # Safety
/// `pointer` is NULL or leads to a string that ends in zero.
pub unsafe fn text(pointer: *const c_char) -> Option<String> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: by contract.
    Some(unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}
