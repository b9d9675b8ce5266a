//! From C to Rust and back: handles, arrays, strings, panics.

use crate::instance::{Instance, Interface, Part, Standard};
use crate::logger::{Log, Sink, Status};
use crate::refusal::{Outcome, Refused};
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

/// Runs an operation on the instance of a handle; an error or a panic becomes a log message and a status.
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
    // The outcome is converted here, so that the success path only returns the status.
    let judged = catch_unwind(AssertUnwindSafe(|| match operation(&mut *instance) {
        Ok(()) if !instance.has_remarks() => Status::Ok,
        Ok(()) => remark(instance, name),
        Err(refused) => refuse(instance, name, &refused),
    }));
    judged.unwrap_or_else(|_| fail(instance, name))
}

/// Logs why a call was refused.
#[cold]
fn refuse(instance: &Instance, name: &str, refused: &Refused) -> Status {
    instance.log.send(refused.status, &format!("{name}: {}", refused.message));
    refused.status
}

/// Logs what a call that succeeded has to report.
#[cold]
fn remark(instance: &mut Instance, name: &str) -> Status {
    for message in instance.take_remarks() {
        instance.log.send(Status::Warning, &format!("{name}: {message}"));
    }
    Status::Warning
}

/// After a panic.
#[cold]
fn fail(instance: &mut Instance, name: &str) -> Status {
    instance.enter_error_state();
    instance.log.send(Status::Error, &format!("{name}: internal failure; only reset and free remain."));
    Status::Error
}

/// A missing array.
#[cold]
fn missing(n: usize, what: &str) -> Refused {
    Refused::error(format!("{what} is NULL although its length is {n}."))
}

/// Arguments of an instantiation.
pub struct Instantiation {
    /// The constructor that it calls.
    pub function: &'static str,
    /// The standard.
    pub standard: Standard,
    /// The interface type.
    pub interface: Interface,
    /// Optional features that it uses.
    pub part: Part,
    /// Name of the instance.
    pub name: *const c_char,
    /// GUID or instantiation token.
    pub token: *const c_char,
    /// Where the archive's resources are; NULL where there are none.
    pub resources: *const c_char,
    /// Reads that text.
    pub locate: fn(&str) -> Option<PathBuf>,
    /// Where messages are to go.
    pub sink: Sink,
    /// Whether events are logged too.
    pub logging_on: bool,
    /// A requested feature that this FMU does not have: one sentence.
    pub unsupported: Option<String>,
}

/// Creates an instance and returns its handle; on failure NULL and a log message.
///
/// # Safety
/// The texts are NULL or end in zero.
pub unsafe fn instantiate(instantiation: Instantiation) -> *mut c_void {
    // SAFETY: by contract.
    let (name, token, resources) = unsafe {
        (
            text(instantiation.name).unwrap_or_default(),
            text(instantiation.token),
            text(instantiation.resources),
        )
    };
    let made = catch_unwind(AssertUnwindSafe(|| {
        if name.is_empty() {
            return Err(Refused::error("the instance name is missing."));
        }
        if let Some(sentence) = instantiation.unsupported {
            return Err(Refused::error(sentence));
        }
        let resources = resources.as_deref().and_then(instantiation.locate);
        let log = Log::new(instantiation.sink, &name, instantiation.logging_on);
        let kind = (instantiation.standard, instantiation.interface);
        Instance::new(token.as_deref(), resources.as_deref(), kind, instantiation.part, log)
    }));
    let refused = match made {
        Ok(Ok(instance)) => return Box::into_raw(Box::new(instance)).cast(),
        Ok(Err(refused)) => refused,
        Err(_) => Refused::error("internal failure."),
    };
    Log::new(instantiation.sink, &name, false)
        .send(refused.status, &format!("{}: {}", instantiation.function, refused.message));
    std::ptr::null_mut()
}

/// Turns the messages of an instance on or off.
///
/// # Safety
/// As [`enter`] and [`array`]; the categories are NULL or end in zero.
pub unsafe fn set_logging(
    handle: *mut c_void,
    function: &str,
    on: bool,
    n: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: by contract.
    unsafe {
        enter(handle, function, |i| {
            let names: Vec<Option<String>> =
                array(categories, n, "categories")?.iter().map(|&name| text(name)).collect();
            i.set_logging(on, &names)
        })
    }
}

/// Runs an operation of Model Exchange.
///
/// # Safety
/// As [`enter`].
pub unsafe fn exchange(
    handle: *mut c_void,
    name: &str,
    operation: impl FnOnce(&mut Instance) -> Outcome,
) -> Status {
    // SAFETY: by contract.
    unsafe {
        enter(handle, name, |i| {
            i.require_interface(Interface::ModelExchange)?;
            operation(i)
        })
    }
}

/// C functions: name, arguments after the handle, operation on the instance. First [`enter`] or [`exchange`], which runs it.
#[macro_export]
#[doc(hidden)]
macro_rules! functions {
    ($run:ident; $(
        $(#[doc = $doc:literal])* fn $name:ident($($argument:ident: $type:ty),*) => $operation:expr;
    )*) => {$(
        $(#[doc = $doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(handle: *mut std::ffi::c_void $(, $argument: $type)*) -> $crate::logger::Status {
            // SAFETY: as the crate's documentation says.
            unsafe { $crate::boundary::$run(handle, stringify!($name), $operation) }
        }
    )*};
}

/// Frees an instance.
///
/// # Safety
/// As [`enter`]; the handle is invalid afterwards.
pub unsafe fn free_instance(handle: *mut c_void) {
    if !handle.is_null() {
        // SAFETY: by contract the handle came from `instantiate`.
        let instance = unsafe { &*handle.cast::<Instance>() };
        if instance.is_in_intermediate_update() {
            // The step continues after the callback, in memory that would be freed.
            instance.log.send(Status::Error, "an instance cannot be freed in intermediate update mode.");
            return;
        }
        // SAFETY: as above.
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
        (_, true) => Err(missing(n, what)),
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
        (_, true) => Err(missing(n, what)),
        // SAFETY: by contract.
        _ => Ok(unsafe { std::slice::from_raw_parts_mut(pointer, n) }),
    }
}

/// The variable at `pointer`.
///
/// # Safety
/// `pointer` is NULL or leads to a writable place.
#[inline]
pub unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Outcome<&'a mut T> {
    // SAFETY: by contract.
    unsafe { pointer.as_mut() }.ok_or_else(|| Refused::error(format!("{what} is NULL.")))
}

/// Writes `value` to `pointer` unless it is NULL.
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
