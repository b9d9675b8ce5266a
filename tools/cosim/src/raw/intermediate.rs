//! FMI 3: continuous inputs that follow lines within a step, set in intermediate update mode.
use super::accessor::Handle;
use super::functions::Functions;
use super::{RawInstance, RawStep};
use crate::Status;
use std::cell::Cell;
use std::ffi::{c_int, c_void};
use std::ptr;

/// `fmi3IntermediateUpdateCallback`; Booleans are bytes.
type Callback = unsafe extern "C" fn(*mut c_void, f64, u8, u8, u8, u8, *mut u8, *mut f64);

/// The callback as instantiation takes it.
pub(super) const CALLBACK: *const c_void = {
    const TYPED: Callback = update;
    TYPED as *const c_void
};

/// Lines of inputs over the next step.
#[derive(Debug, Default)]
pub(super) struct Lines {
    references: Vec<u32>,
    /// Values at the start of the step, derivatives (per s).
    from: Vec<f64>,
    slopes: Vec<f64>,
    /// Values at a point.
    values: Vec<f64>,
}

impl Lines {
    fn clear(&mut self) {
        self.references.clear();
        self.from.clear();
        self.slopes.clear();
    }
}

/// What the callback needs while a step lasts.
struct Active<'a> {
    functions: &'a Functions,
    handle: Handle,
    lines: Lines,
    start: f64,
    worst: Status,
}

thread_local! {
    /// The step that lasts in this thread. The environment pointer of the FMU is not followed.
    static ACTIVE: Cell<*mut c_void> = const { Cell::new(ptr::null_mut()) };
}

/// Sets the inputs to where they are at `time` (s); no early return.
unsafe extern "C" fn update(
    _environment: *mut c_void,
    time: f64,
    set_requested: u8,
    _get_allowed: u8,
    _step_finished: u8,
    _can_return_early: u8,
    early_requested: *mut u8,
    _early_time: *mut f64,
) {
    if !early_requested.is_null() {
        // SAFETY: a pointer to a Boolean, by the standard.
        unsafe { *early_requested = 0 };
    }
    let active = ACTIVE.try_with(Cell::get).unwrap_or(ptr::null_mut()).cast::<Active>();
    if active.is_null() || set_requested == 0 || !time.is_finite() {
        return;
    }
    // SAFETY: set by `do_step_along` of this thread, which waits for the step to return and uses nothing of it meanwhile.
    let Active { functions, handle, lines, start, worst } = unsafe { &mut *active };
    let Lines { references, from, slopes, values } = lines;
    values.clear();
    values.extend(from.iter().zip(&*slopes).map(|(from, slope)| from + slope * (time - *start)));
    let status: Option<c_int> = functions.float64.set(*handle, references, values);
    *worst = (*worst).max(status.map_or(Status::Error, Status::from_c));
}

impl RawInstance {
    /// FMI 3: derivatives (per s) of inputs over the next step, which were named at instantiation, from their present values on.
    pub(crate) fn set_lines(&mut self, references: &[u32], slopes: &[f64]) -> Status {
        let first = self.lines.from.len();
        self.lines.references.extend_from_slice(references);
        self.lines.slopes.extend_from_slice(slopes);
        self.lines.from.resize(first + references.len(), 0.0);
        let mut lines = std::mem::take(&mut self.lines);
        let status = self.get_f64(references, &mut lines.from[first..]);
        self.lines = lines;
        status
    }

    /// As `do_step`, with the lines that are set; they hold for this step alone.
    pub(super) fn do_step_along(&mut self, t: f64, step: impl FnOnce(&mut Self) -> RawStep) -> RawStep {
        if self.lines.references.is_empty() {
            return step(self);
        }
        let loaded = std::sync::Arc::clone(&self.loaded);
        let mut active = Active {
            functions: &loaded.functions,
            handle: self.handle,
            lines: std::mem::take(&mut self.lines),
            start: t,
            worst: Status::Ok,
        };
        ACTIVE.with(|cell| cell.set(ptr::from_mut(&mut active).cast()));
        let mut result = step(self);
        ACTIVE.with(|cell| cell.set(ptr::null_mut()));
        active.lines.clear();
        self.lines = active.lines;
        result.status = result.status.max(active.worst);
        result
    }
}
