//! Process groups and signals.
use std::ffi::c_int;
use std::io;
use std::sync::Once;
use std::sync::atomic::{AtomicI32, Ordering};

/// The group of the child that runs.
static GROUP: AtomicI32 = AtomicI32::new(0);

/// Signals that end a process and that a process may be sent by another one.
const SIGNALS: [c_int; 6] =
    [libc::SIGHUP, libc::SIGINT, libc::SIGQUIT, libc::SIGTERM, libc::SIGUSR1, libc::SIGUSR2];

/// From now on signals from the group of this child do not end this process; all others do what they did.
pub(super) fn guard(child: u32) {
    static INSTALLED: Once = Once::new();
    GROUP.store(child.try_into().unwrap_or(0), Ordering::Relaxed);
    INSTALLED.call_once(|| {
        for signal in SIGNALS {
            // SAFETY: the structures are valid, and the handler calls async-signal-safe functions only.
            unsafe {
                let mut old: libc::sigaction = std::mem::zeroed();
                if libc::sigaction(signal, std::ptr::null(), &mut old) != 0
                    || old.sa_sigaction != libc::SIG_DFL
                {
                    continue;
                }
                let mut new: libc::sigaction = std::mem::zeroed();
                new.sa_sigaction = on_signal as *const () as usize;
                new.sa_flags = libc::SA_SIGINFO | libc::SA_RESTART;
                libc::sigaction(signal, &new, std::ptr::null_mut());
            }
        }
    });
}

/// A signal of the child's group is passed over; any other ends this process as without a handler. The child then removes the
/// temporary folder.
extern "C" fn on_signal(signal: c_int, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
    // SAFETY: the system passes a valid `info`; the functions are async-signal-safe.
    unsafe {
        let sender = (*info).si_pid();
        let group = GROUP.load(Ordering::Relaxed);
        if sender > 0 && group > 0 && (sender == group || libc::getpgid(sender) == group) {
            return;
        }
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}

/// Ends all processes of a child's group.
pub(super) fn end_group(child: u32) {
    if let Ok(group) = i32::try_from(child) {
        // SAFETY: a system call without pointers; the group is that of a child that has not been waited for.
        unsafe { libc::killpg(group, libc::SIGKILL) };
    }
}

/// Ends this process and its group.
pub(super) fn end_own_group() {
    // SAFETY: a system call without pointers; 0 is the own group, which the parent has made for this process.
    unsafe { libc::kill(0, libc::SIGKILL) };
}

/// Lets standard input and output lead nowhere.
pub(super) fn silence() -> io::Result<()> {
    use std::os::fd::AsRawFd;
    let nowhere = std::fs::File::options().read(true).write(true).open("/dev/null")?;
    for standard in [0, 1] {
        // SAFETY: both numbers are open files.
        if unsafe { libc::dup2(nowhere.as_raw_fd(), standard) } < 0 {
            return Err(io::Error::last_os_error());
        }
    }
    Ok(())
}

/// Ends this process at once, without exit functions.
pub(super) fn exit_now() -> ! {
    // SAFETY: it does not return.
    unsafe { libc::_exit(0) }
}
