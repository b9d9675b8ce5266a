//! Conversion between C and Rust: handles, arrays, strings, panics.

use crate::instance::{Instance, Interface, Part, Standard};
use crate::logger::{Delivery, Log, Sink, Status};
use crate::refusal::{Outcome, Refused};
use crate::resources::Location;
use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

/// Runs an operation on the instance of a handle; an error or a panic is reported by message and status. Messages are delivered
/// when no reference to the instance exists any more.
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
    let place = handle.cast::<Instance>();
    // The outcome is converted here so that the success path only returns the status.
    let judged = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: by contract; instances are not shared between threads during a call (FMI 2 section 2.1.1, FMI 3
        // section 2.2.1).
        let instance = unsafe { &mut *place };
        match operation(instance) {
            Ok(()) if !instance.has_warned => (Status::Ok, instance.log.is_waiting()),
            Ok(()) => (instance.warned(), instance.log.is_waiting()),
            Err(refused) => (refuse(instance, &refused), instance.log.is_waiting()),
        }
    }));
    // SAFETY: by contract.
    let (status, is_waiting) = judged.unwrap_or_else(|_| unsafe { (fail(place), true) });
    if is_waiting {
        // SAFETY: by contract; the operation has ended.
        unsafe { deliver(place, name) };
    }
    status
}

/// Queues the reason for a rejected call.
#[cold]
fn refuse(instance: &mut Instance, refused: &Refused) -> Status {
    instance.has_warned = false;
    instance.log.reason(refused.status, &refused.message);
    refused.status
}

/// Enters the error state after a panic.
///
/// # Safety
/// As [`enter`].
#[cold]
unsafe fn fail(place: *mut Instance) -> Status {
    let _ = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: by contract; the operation that panicked has ended.
        let instance = unsafe { &mut *place };
        instance.enter_error_state();
        instance
            .log
            .reason(Status::Error, "internal failure; only a saved state or a reset ends the error state.");
    }));
    Status::Error
}

/// Sends the messages of a call.
///
/// # Safety
/// As [`enter`]; no reference to the instance exists.
#[cold]
unsafe fn deliver(place: *mut Instance, name: &str) {
    // SAFETY: by contract; the reference ends with the closure.
    let delivery = catch_unwind(AssertUnwindSafe(|| unsafe { &mut *place }.log.take(name)));
    if let Ok(delivery) = delivery {
        // SAFETY: the importer's logger is valid as long as the instance.
        unsafe { delivery.send() };
    }
}

/// Error of an array that is NULL.
#[cold]
fn missing(n: usize, what: &str) -> Refused {
    Refused::error(format!("{what} is NULL although its length is {n}."))
}

/// Arguments of an instantiation.
pub struct Instantiation {
    /// The calling C function.
    pub function: &'static str,
    /// The standard.
    pub standard: Standard,
    /// The interface type.
    pub interface: Interface,
    /// Optional features that the importer uses.
    pub part: Part,
    /// Name of the instance.
    pub name: *const c_char,
    /// GUID or instantiation token.
    pub token: *const c_char,
    /// Location of the archive's resources; NULL if there are none.
    pub resources: *const c_char,
    /// Converts this location to a path.
    pub locate: fn(&str) -> Option<PathBuf>,
    /// Destination of messages.
    pub sink: Sink,
    /// Initial value of `loggingOn`.
    pub logging_on: bool,
    /// A requested feature that this FMU does not support: one sentence.
    pub unsupported: Option<String>,
}

/// Creates an instance and returns its handle; on failure returns NULL and logs a message.
///
/// # Safety
/// The texts are NULL or zero-terminated.
pub unsafe fn instantiate(instantiation: Instantiation) -> *mut c_void {
    let Instantiation { function, sink, .. } = instantiation;
    let texts = [instantiation.name, instantiation.token, instantiation.resources];
    let made = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: by contract.
        let [name, token, resources] = texts.map(|pointer| unsafe { text(pointer) });
        let name = name.unwrap_or_default();
        made(instantiation, &name, token.as_deref(), resources.as_deref())
            .map_err(|refused| Delivery::of_failure(sink, &name, &format!("{function}: {}", refused.message)))
    }));
    match made {
        Ok(Ok(instance)) => {
            let place = Box::into_raw(instance);
            // SAFETY: the instance was created above; no reference to it exists.
            unsafe { deliver(place, function) };
            return place.cast();
        }
        // SAFETY: the importer's logger is valid.
        Ok(Err(delivery)) => unsafe { delivery.send() },
        Err(_) => {
            let delivery = catch_unwind(|| Delivery::of_failure(sink, "", "internal failure."));
            // SAFETY: as above.
            let _ = delivery.map(|delivery| unsafe { delivery.send() });
        }
    }
    std::ptr::null_mut()
}

fn made(
    instantiation: Instantiation,
    name: &str,
    token: Option<&str>,
    resources: Option<&str>,
) -> Outcome<Box<Instance>> {
    if name.trim().is_empty() {
        return Err(Refused::error("the instance name is missing."));
    }
    if let Some(sentence) = instantiation.unsupported {
        return Err(Refused::error(sentence));
    }
    let location = Location::new(resources, instantiation.locate);
    let log = Log::new(instantiation.sink, name, instantiation.logging_on);
    let kind = (instantiation.standard, instantiation.interface);
    let mut instance = Instance::new(token, &location, kind, instantiation.part, log)?;
    instance.log_transition("instantiated");
    Ok(Box::new(instance))
}

/// Enables or disables the messages of an instance.
///
/// # Safety
/// As [`enter`] and [`array()`]; the categories are NULL or zero-terminated.
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

/// Runs an operation that only Model Exchange has.
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

/// C functions: name, arguments after the handle, operation on the instance. The first argument of the macro is the function
/// that runs the operation: [`enter`] or [`exchange`].
#[macro_export]
#[doc(hidden)]
macro_rules! functions {
    ($run:ident; $(
        $(#[doc = $doc:literal])* fn $name:ident($($argument:ident: $type:ty),*) => $operation:expr;
    )*) => {$(
        $(#[doc = $doc])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(handle: *mut std::ffi::c_void $(, $argument: $type)*) -> $crate::logger::Status {
            // SAFETY: by the crate's documentation.
            unsafe { $crate::boundary::$run(handle, stringify!($name), $operation) }
        }
    )*};
}

/// Frees an instance.
///
/// # Safety
/// As [`enter`]; the handle is invalid afterwards.
pub unsafe fn free_instance(handle: *mut c_void, function: &str) {
    if handle.is_null() {
        return;
    }
    // SAFETY: by contract.
    let status = unsafe {
        enter(handle, function, |i| match i.is_in_intermediate_update() {
            // The step continues after the callback and would use freed memory.
            true => Err(Refused::error("an instance cannot be freed in intermediate update mode.")),
            false => Ok(()),
        })
    };
    if status == Status::Ok {
        // SAFETY: by contract the handle is from `instantiate`.
        let _ = catch_unwind(AssertUnwindSafe(|| drop(unsafe { Box::from_raw(handle.cast::<Instance>()) })));
    }
}

/// The array of `n` elements at `pointer`.
///
/// # Safety
/// `pointer` is NULL or points to `n` readable elements.
#[inline]
pub unsafe fn array<'a, T>(pointer: *const T, n: usize, what: &str) -> Outcome<&'a [T]> {
    match (n, pointer.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(missing(n, what)),
        // SAFETY: by contract.
        _ => Ok(unsafe { std::slice::from_raw_parts(pointer, n) }),
    }
}

/// Memory of the importer that a call writes. No reference to it is created, because it may be uninitialised.
#[derive(Debug)]
pub struct Out<T> {
    pointer: *mut T,
    n: usize,
}

impl<T: Copy> Out<T> {
    /// The `n` elements at `pointer`.
    ///
    /// # Safety
    /// `pointer` is NULL or points to `n` elements that are writable during the call.
    #[inline]
    pub unsafe fn array(pointer: *mut T, n: usize, what: &str) -> Outcome<Out<T>> {
        if pointer.is_null() && n > 0 { Err(missing(n, what)) } else { Ok(Out { pointer, n }) }
    }

    /// The variable at `pointer`.
    ///
    /// # Safety
    /// As [`Out::array`] with one element.
    #[inline]
    pub unsafe fn variable(pointer: *mut T, what: &str) -> Outcome<Out<T>> {
        if pointer.is_null() {
            return Err(Refused::error(format!("{what} is NULL.")));
        }
        Ok(Out { pointer, n: 1 })
    }

    /// Number of elements.
    pub fn count(&self) -> usize {
        self.n
    }

    /// Writes an element.
    ///
    /// # Panics
    /// If there is no such element.
    #[inline]
    pub fn set(&self, k: usize, value: T) {
        assert!(k < self.n, "element {k} of {}", self.n);
        // SAFETY: by the contract of the constructors.
        unsafe { self.pointer.add(k).write(value) }
    }

    /// Writes the first elements.
    ///
    /// # Panics
    /// If there are fewer elements.
    #[inline]
    pub fn fill(&self, values: &[T]) {
        assert!(values.len() <= self.n, "{} of {} elements", values.len(), self.n);
        if !values.is_empty() {
            // SAFETY: by the contract of the constructors; memory of the instance and of the importer do not overlap.
            unsafe { self.pointer.copy_from_nonoverlapping(values.as_ptr(), values.len()) }
        }
    }
}

/// Copies numbers of the instance to the importer's array of `n` elements.
///
/// # Safety
/// As [`Out::array`].
pub unsafe fn copied(
    i: &mut Instance,
    out: *mut f64,
    n: usize,
    numbers: fn(&mut Instance, usize) -> Outcome<&[f64]>,
) -> Outcome {
    // SAFETY: by contract.
    let out = unsafe { Out::array(out, n, "the array") }?;
    out.fill(numbers(i, n)?);
    Ok(())
}

/// Writes `value` to `pointer` unless it is NULL.
///
/// # Safety
/// `pointer` is NULL or points to writable memory.
pub unsafe fn write<T>(pointer: *mut T, value: T) {
    if !pointer.is_null() {
        // SAFETY: by contract.
        unsafe { pointer.write(value) };
    }
}

/// The text at `pointer`; `None` for NULL. Invalid UTF-8 is replaced.
///
/// # Safety
/// `pointer` is NULL or points to a zero-terminated string.
pub unsafe fn text(pointer: *const c_char) -> Option<String> {
    if pointer.is_null() {
        return None;
    }
    // SAFETY: by contract.
    Some(unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}
