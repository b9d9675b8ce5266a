//! Memory that parent and child share: in which call of an FMU the child is.
//!
//! One word: a counter of calls (32 bits), the number of the instance (15 bits), whether the call lasts (1 bit), the function (16 bits,
//! of which the uppermost is the standard). Before and after each call it is written once; nothing else is done for a call.
//! Instances that are called at the same time have a word of their own, a lane.
use crate::FmiVersion;
use memmap2::{MmapOptions, MmapRaw};
use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Deref;
use std::path::Path;
use std::ptr;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, Ordering::Relaxed};

/// The file in the temporary folder of the child.
pub(crate) const FILE: &str = "call";
/// Instances that have a number of their own.
pub(crate) const MOST_INSTANCES: usize = (1 << 15) - 1;

/// Words of a page. Beyond so many instances two share a word, and a crash may name the wrong one of them.
const LANES: usize = 128;

const BUSY: u64 = 1 << 16;
const STANDARD_3: u16 = 1 << 15;

/// What the two processes share.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Page {
    words: [AtomicU64; LANES],
    /// Time of the last communication step (s), as bits.
    time: AtomicU64,
}

/// A function of the FMU, or what is done besides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Function(pub(crate) u16);

impl Function {
    /// Before the child has said anything.
    pub(crate) const START: Self = Self(0);
    /// The library is loaded.
    pub(crate) const LOAD: Self = Self(1);
    /// The first number of the functions of the standards.
    pub(crate) const FIRST: u16 = 2;
}

/// A call of an FMU.
pub(crate) struct LastCall {
    pub(crate) lasts: bool,
    pub(crate) function: Function,
    pub(crate) version: FmiVersion,
    /// Number of the instance.
    pub(crate) instance: usize,
}

static OWN: Page = Page { words: [const { AtomicU64::new(0) }; LANES], time: AtomicU64::new(0) };
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
    /// A number that changes with each call.
    pub(crate) fn mark(&self) -> u64 {
        self.words.iter().fold(0, |mark, word| mark.rotate_left(1).wrapping_add(word.load(Relaxed)))
    }

    /// Whether a call lasts.
    pub(crate) fn is_busy(&self) -> bool {
        self.words.iter().any(|word| word.load(Relaxed) & BUSY != 0)
    }

    /// The lane of an instance that is called at the same time as others; lane 0 is for all others.
    pub(crate) fn lane(instance: u16) -> usize {
        1 + usize::from(instance) % (LANES - 1)
    }

    /// A call begins.
    #[inline]
    pub(crate) fn enter(&self, lane: usize, version: FmiVersion, instance: u16, function: Function) {
        let standard = if version == FmiVersion::V3 { STANDARD_3 } else { 0 };
        let word = &self.words[lane];
        let count = (word.load(Relaxed) >> 32).wrapping_add(1);
        let call = u64::from(instance) << 17 | BUSY | u64::from(function.0 | standard);
        word.store(count << 32 | call, Relaxed);
    }

    /// The call has returned.
    #[inline]
    pub(crate) fn leave(&self, lane: usize) {
        let word = &self.words[lane];
        word.store(word.load(Relaxed) & !BUSY, Relaxed);
    }

    /// The time of a communication step.
    #[inline]
    pub(crate) fn at(&self, t: f64) {
        self.time.store(t.to_bits(), Relaxed);
    }

    /// The calls that last, or the last one: whether they last, function and standard, the number of the instance; and the time of the
    /// last step (s).
    pub(crate) fn last(&self) -> (Vec<LastCall>, f64) {
        let call = |word: u64| {
            let (function, instance) = (word as u16, (word >> 17) as usize & MOST_INSTANCES);
            let version = if function & STANDARD_3 == 0 { FmiVersion::V2 } else { FmiVersion::V3 };
            LastCall {
                lasts: word & BUSY != 0,
                function: Function(function & !STANDARD_3),
                version,
                instance,
            }
        };
        let words = || self.words.iter().map(|word| word.load(Relaxed));
        let mut calls: Vec<LastCall> = words().map(call).filter(|call| call.lasts).collect();
        if calls.is_empty() {
            calls.push(call(words().next().unwrap_or(0)));
        }
        (calls, f64::from_bits(self.time.load(Relaxed)))
    }
}

/// Reports the number, the name and the archive of an instance to the parent.
type Announce = fn(u16, &str, &Path);
static ANNOUNCE: OnceLock<Announce> = OnceLock::new();

/// From now on instances are announced.
pub(crate) fn announce_through(announce: Announce) {
    let _ = ANNOUNCE.set(announce);
}

/// Announces an instance, if there is a parent.
pub(crate) fn announce(instance: u16, name: &str, file: &Path) {
    if let Some(announce) = ANNOUNCE.get() {
        announce(instance, name, file);
    }
}

/// A page in a file.
pub(crate) struct SharedPage(MmapRaw);

impl SharedPage {
    /// For the parent: a new file. The child counts as busy until it speaks.
    pub(crate) fn create(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().read(true).write(true).create_new(true).open(path)?;
        file.set_len(size_of::<Page>() as u64)?;
        let page = Self::map(&file)?;
        page.words[0].store(BUSY, Relaxed);
        Ok(page)
    }

    /// For the child: the file becomes its page for as long as it lives.
    pub(crate) fn take(path: &Path) -> io::Result<()> {
        let page = Self::map(&OpenOptions::new().read(true).write(true).open(path)?)?;
        page.leave(0);
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
