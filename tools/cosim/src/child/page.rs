//! Memory that parent and child share: in which call of an FMU the child is.
//!
//! One word: a counter of calls (32 bits), the number of the instance (15 bits), whether the call lasts (1 bit), the function (16 bits,
//! of which the uppermost is the standard). Before and after each call it is written once; nothing else is done for a call.
use crate::raw::function_name;
use crate::{FmiVersion, number};
use memmap2::{MmapOptions, MmapRaw};
use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Deref;
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, Ordering::Relaxed};

/// The file in the temporary folder of the child.
pub(super) const FILE: &str = "call";
/// Instances that have a number of their own.
pub(super) const MOST_INSTANCES: usize = (1 << 15) - 1;

const BUSY: u64 = 1 << 16;
const STANDARD_3: u16 = 1 << 15;

/// What the two processes share.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Page {
    word: AtomicU64,
    /// Time of the last communication step (s), as bits.
    time: AtomicU64,
}

/// A function of the FMU, or what is done besides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Function(pub(crate) u16);

impl Function {
    /// Before the child has said anything.
    const START: Self = Self(0);
    /// The library is loaded.
    pub(crate) const LOAD: Self = Self(1);
    /// The first number of the functions of the standards.
    pub(crate) const FIRST: u16 = 2;
}

static OWN: Page = Page { word: AtomicU64::new(0), time: AtomicU64::new(0) };
static CURRENT: AtomicPtr<Page> = AtomicPtr::new(ptr::from_ref(&OWN).cast_mut());
static INSTANCES: AtomicU32 = AtomicU32::new(0);

/// The page of this process: shared if it is a supervised child.
pub(crate) fn current() -> &'static Page {
    // SAFETY: it points to a static, or to a mapping that is never undone.
    unsafe { &*CURRENT.load(Relaxed) }
}

/// The next number of an instance; 0 is for those beyond the highest.
pub(crate) fn next_instance() -> u16 {
    u16::try_from(INSTANCES.fetch_add(1, Relaxed) + 1)
        .ok()
        .filter(|n| usize::from(*n) <= MOST_INSTANCES)
        .unwrap_or(0)
}

impl Page {
    pub(super) fn word(&self) -> u64 {
        self.word.load(Relaxed)
    }

    /// A call begins.
    #[inline]
    pub(crate) fn enter(&self, version: FmiVersion, instance: u16, function: Function) {
        let standard = if version == FmiVersion::V3 { STANDARD_3 } else { 0 };
        let count = (self.word.load(Relaxed) >> 32).wrapping_add(1);
        let call = u64::from(instance) << 17 | BUSY | u64::from(function.0 | standard);
        self.word.store(count << 32 | call, Relaxed);
    }

    /// The call has returned.
    #[inline]
    pub(crate) fn leave(&self) {
        self.word.store(self.word.load(Relaxed) & !BUSY, Relaxed);
    }

    /// The time of a communication step.
    #[inline]
    pub(crate) fn at(&self, t: f64) {
        self.time.store(t.to_bits(), Relaxed);
    }

    /// The last call in words; `instances` have name and file.
    pub(super) fn call(&self, instances: &[(String, String)]) -> super::Call {
        let word = self.word();
        let (function, instance) = (word as u16, (word >> 17) as usize & MOST_INSTANCES);
        let version = if function & STANDARD_3 == 0 { FmiVersion::V2 } else { FmiVersion::V3 };
        let (name, file) = instances.get(instance).cloned().unwrap_or_default();
        let function = match Function(function & !STANDARD_3) {
            Function::START => {
                return super::Call { text: "before the first call of an FMU".to_owned(), file };
            }
            Function::LOAD => "loading the library",
            Function(number) => function_name(number - Function::FIRST, version),
        };
        let mut text = format!("{} {function}", if is_busy(word) { "in" } else { "after" });
        if !name.is_empty() {
            text += &format!(" of {name}");
        }
        if function.ends_with("DoStep") {
            text += &format!(" at t = {} s", number(f64::from_bits(self.time.load(Relaxed))));
        }
        super::Call { text, file }
    }
}

/// Whether a call lasts.
pub(super) fn is_busy(word: u64) -> bool {
    word & BUSY != 0
}

/// A page in a file.
pub(super) struct SharedPage(MmapRaw);

impl SharedPage {
    /// For the parent: a new file. The child counts as busy until it speaks.
    pub(super) fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(path)?;
        file.set_len(size_of::<Page>() as u64)?;
        let page = Self::map(&file)?;
        page.word.store(BUSY, Relaxed);
        Ok(page)
    }

    /// For the child: the file becomes its page for as long as it lives.
    pub(super) fn take(path: &Path) -> io::Result<()> {
        let page = Self::map(&OpenOptions::new().read(true).write(true).open(path)?)?;
        page.leave();
        CURRENT.store(page.0.as_mut_ptr().cast(), Relaxed);
        std::mem::forget(page);
        Ok(())
    }

    fn map(file: &File) -> io::Result<Self> {
        Ok(Self(MmapOptions::new().len(size_of::<Page>()).map_raw(file)?))
    }
}

impl Deref for SharedPage {
    type Target = Page;

    fn deref(&self) -> &Page {
        // SAFETY: the mapping has the size of a page, begins at a multiple of a memory page, and holds atomics alone.
        unsafe { &*self.0.as_ptr().cast() }
    }
}
