//! CVODE of SUNDIALS 7 through its C interface: the BDF method with a dense Jacobian by differences, as fmpy uses it.
//!
//! No part of SUNDIALS is compiled or linked. The libraries are loaded at run time: those of the package fmpy in the Python environment of
//! the tests, or those in the folder that the environment variable SUNDIALS names.

use libloading::Library;
use std::ffi::{c_int, c_long, c_void};
use std::path::{Path, PathBuf};
use std::ptr::null_mut;

/// Backward differentiation formulas.
const BDF: c_int = 2;
/// Steps until the solution has passed the output time, where it is interpolated.
const NORMAL: c_int = 1;
/// More steps than any benchmark needs between two output times.
const MOST_STEPS: c_long = 100_000;
/// The libraries, each after those that it needs.
const LIBRARIES: [&str; 5] = ["core", "nvecserial", "sunmatrixdense", "sunlinsoldense", "cvode"];

type Handle = *mut c_void;
type Rates<'a, const N: usize> = dyn FnMut(f64, &[f64; N]) -> [f64; N] + 'a;

type Numbers = unsafe extern "C" fn(Handle) -> *mut f64;

/// What the derivatives need during a call.
struct Call<'a, 'b, const N: usize> {
    rates: &'a mut Rates<'b, N>,
    numbers: Numbers,
}

/// The derivatives in the form of CVODE; `call` is a [`Call`].
unsafe extern "C" fn evaluate<const N: usize>(t: f64, y: Handle, out: Handle, call: Handle) -> c_int {
    // SAFETY: vectors of N numbers, and the value that `advance` has set for the duration of its call.
    unsafe {
        let Call { rates, numbers } = &mut *call.cast::<Call<'_, '_, N>>();
        let y = &*numbers(y).cast::<[f64; N]>();
        numbers(out).cast::<[f64; N]>().write(rates(t, y));
    }
    0
}

/// An integrator of `N` states.
pub struct Cvode<const N: usize> {
    memory: Handle,
    state: Handle,
    numbers: Numbers,
    set_user_data: unsafe extern "C" fn(Handle, Handle) -> c_int,
    restart: unsafe extern "C" fn(Handle, f64, Handle) -> c_int,
    solve: unsafe extern "C" fn(Handle, f64, Handle, *mut f64, c_int) -> c_int,
    _libraries: Vec<Library>,
}

impl<const N: usize> Cvode<N> {
    /// The integrator at time 0 and the state `start`.
    ///
    /// # Errors
    /// One sentence: the libraries are not there, or a call fails.
    pub fn new(start: &[f64; N], relative: f64, absolute: f64) -> Result<Self, String> {
        let folder = folder()?;
        let mut libraries = Vec::new();
        for name in LIBRARIES {
            let path = file(&folder, name).ok_or(format!("{} has no sundials_{name}", folder.display()))?;
            // SAFETY: the libraries of SUNDIALS, which have no side effects at loading.
            libraries.push(unsafe { Library::new(&path) }.map_err(|e| format!("{}: {e}", path.display()))?);
        }
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the signatures are those of SUNDIALS 7.
                unsafe {
                    let found = libraries.iter().find_map(|l| l.get($name).ok().map(|s| *s));
                    found.ok_or(concat!($name, " is in none of the libraries of SUNDIALS"))?
                }
            };
        }
        type Evaluate = unsafe extern "C" fn(f64, Handle, Handle, Handle) -> c_int;
        let context: unsafe extern "C" fn(c_int, *mut Handle) -> c_int = symbol!("SUNContext_Create");
        let vector: unsafe extern "C" fn(i64, Handle) -> Handle = symbol!("N_VNew_Serial");
        let numbers: Numbers = symbol!("N_VGetArrayPointer");
        let matrix: unsafe extern "C" fn(i64, i64, Handle) -> Handle = symbol!("SUNDenseMatrix");
        let linear: unsafe extern "C" fn(Handle, Handle, Handle) -> Handle = symbol!("SUNLinSol_Dense");
        let create: unsafe extern "C" fn(c_int, Handle) -> Handle = symbol!("CVodeCreate");
        let initialise: unsafe extern "C" fn(Handle, Evaluate, f64, Handle) -> c_int = symbol!("CVodeInit");
        let tolerances: unsafe extern "C" fn(Handle, f64, f64) -> c_int = symbol!("CVodeSStolerances");
        let attach: unsafe extern "C" fn(Handle, Handle, Handle) -> c_int = symbol!("CVodeSetLinearSolver");
        let limit: unsafe extern "C" fn(Handle, c_long) -> c_int = symbol!("CVodeSetMaxNumSteps");
        let (set_user_data, restart, solve) =
            (symbol!("CVodeSetUserData"), symbol!("CVodeReInit"), symbol!("CVode"));
        let mut one: Handle = null_mut();
        // SAFETY: arguments as the manual of CVODE 7 requires; all objects live until the end of the process.
        unsafe {
            check("SUNContext_Create", context(0, &mut one))?;
            let state = vector(N as i64, one);
            numbers(state).cast::<[f64; N]>().write(*start);
            let memory = create(BDF, one);
            check("CVodeInit", initialise(memory, evaluate::<N>, 0.0, state))?;
            check("CVodeSStolerances", tolerances(memory, relative, absolute))?;
            let jacobian = matrix(N as i64, N as i64, one);
            check("CVodeSetLinearSolver", attach(memory, linear(state, jacobian, one), jacobian))?;
            check("CVodeSetMaxNumSteps", limit(memory, MOST_STEPS))?;
            Ok(Cvode { memory, state, numbers, set_user_data, restart, solve, _libraries: libraries })
        }
    }

    /// Sets time and state and forgets the past, as after a discontinuity of an input.
    ///
    /// # Errors
    /// A failed call.
    pub fn restart(&mut self, time: f64, state: &[f64; N]) -> Result<(), String> {
        // SAFETY: the vector has N numbers.
        unsafe {
            (self.numbers)(self.state).cast::<[f64; N]>().write(*state);
            check("CVodeReInit", (self.restart)(self.memory, time, self.state))
        }
    }

    /// The state at `until`, s, from the present time on, with these derivatives.
    ///
    /// # Errors
    /// A failed call.
    pub fn advance(&mut self, until: f64, rates: &mut Rates<'_, N>) -> Result<[f64; N], String> {
        let (mut call, mut reached) = (Call { rates, numbers: self.numbers }, 0.0);
        // SAFETY: `call` lives as long as the call that uses it.
        unsafe {
            (self.set_user_data)(self.memory, (&raw mut call).cast());
            check("CVode", (self.solve)(self.memory, until, self.state, &mut reached, NORMAL))?;
            Ok(*(self.numbers)(self.state).cast::<[f64; N]>())
        }
    }
}

fn check(call: &str, flag: c_int) -> Result<(), String> {
    if flag >= 0 { Ok(()) } else { Err(format!("{call} returns {flag}")) }
}

/// The library of this name, with or without the prefix of the platform.
fn file(folder: &Path, name: &str) -> Option<PathBuf> {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let names = ["", DLL_PREFIX].map(|prefix| folder.join(format!("{prefix}sundials_{name}{DLL_SUFFIX}")));
    names.into_iter().find(|path| path.is_file())
}

/// The folder of the libraries.
fn folder() -> Result<PathBuf, String> {
    if let Some(folder) = std::env::var_os("SUNDIALS") {
        return Ok(folder.into());
    }
    // target/release/deps/do_step-...: the environment of the tests is in target/venv.
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let lib = program.ancestors().nth(3).unwrap_or(Path::new("target")).join("venv/lib");
    let platform = format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS);
    let within = |python: PathBuf| python.join("site-packages/fmpy/sundials").join(&platform);
    let pythons = lib.read_dir().into_iter().flatten().flatten().map(|entry| within(entry.path()));
    let mut found = pythons.filter(|folder| folder.is_dir());
    found.next().ok_or(format!(
        "no libraries of SUNDIALS 7: {} has no fmpy (cargo xtask test installs it), and the environment variable SUNDIALS names no folder",
        lib.display()
    ))
}
