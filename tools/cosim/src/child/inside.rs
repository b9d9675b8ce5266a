//! The side of the child.
use crate::Error;
use crate::page::{FILE, SharedPage, announce_through};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The connection to the parent; there is one for each process.
#[derive(Clone, Copy, Debug)]
pub struct Channel(());

struct Pipe {
    to_parent: Mutex<File>,
    nonce: String,
    folder: PathBuf,
}

static PIPE: OnceLock<Pipe> = OnceLock::new();

/// Makes this process the child of [`supervise`](super::supervise). Standard input and output are the pipes of the parent; both are
/// taken away before any code of an FMU runs.
///
/// # Errors
/// [`Error::Io`] if this process is no such child.
pub fn enter() -> Result<Channel, Error> {
    take_pipes().map(|()| Channel(())).map_err(Error::io("join the parent process of", Path::new("this one")))
}

fn take_pipes() -> io::Result<()> {
    let (mut from_parent, to_parent) = pipes()?;
    let nonce = line(&mut from_parent)?;
    let folder = PathBuf::from(line(&mut from_parent)?);
    SharedPage::take(&folder.join(FILE))?;
    // Once for each process; a second time would be a mistake that leaves files elsewhere and harms nobody.
    let _ = tempfile::env::override_temp_dir(&folder);
    announce_through(announce);
    let _ = PIPE.set(Pipe { to_parent: Mutex::new(to_parent), nonce, folder: folder.clone() });
    std::thread::spawn(move || {
        // Nothing comes any more: this returns at the end of the parent.
        let _ = io::copy(&mut from_parent, &mut io::sink());
        let _ = std::fs::remove_dir_all(&folder);
        #[cfg(unix)]
        super::signals::end_own_group();
        std::process::abort();
    });
    Ok(())
}

/// A line of the parent, byte for byte, so that nothing after it is taken.
fn line(pipe: &mut File) -> io::Result<String> {
    let mut bytes = Vec::new();
    let mut byte = [0];
    loop {
        pipe.read_exact(&mut byte)?;
        if byte[0] == b'\n' {
            return String::from_utf8(bytes).map_err(io::Error::other);
        }
        bytes.push(byte[0]);
    }
}

/// Standard input and output as files that no other process inherits; the standard ones lead nowhere afterwards.
#[cfg(unix)]
fn pipes() -> io::Result<(File, File)> {
    use std::os::fd::AsFd;
    let from_parent = File::from(io::stdin().as_fd().try_clone_to_owned()?);
    let to_parent = File::from(io::stdout().as_fd().try_clone_to_owned()?);
    super::signals::silence()?;
    Ok((from_parent, to_parent))
}

/// As on Unix, but the standard handles stay: lines of an FMU lack the number.
#[cfg(windows)]
fn pipes() -> io::Result<(File, File)> {
    use std::os::windows::io::AsHandle;
    let from_parent = File::from(io::stdin().as_handle().try_clone_to_owned()?);
    let to_parent = File::from(io::stdout().as_handle().try_clone_to_owned()?);
    Ok((from_parent, to_parent))
}

/// What the standard input holds: in a child, what its parent has read there.
pub(crate) fn standard_input() -> io::Result<Vec<u8>> {
    match PIPE.get() {
        Some(pipe) => std::fs::read(pipe.folder.join(super::STANDARD_INPUT)),
        None => {
            let mut bytes = Vec::new();
            io::stdin().read_to_end(&mut bytes).map(|_| bytes)
        }
    }
}

/// Reports the name and the archive of an instance to the parent.
fn announce(instance: u16, name: &str, file: &Path) {
    let clean = |text: &str| text.replace(['\t', '\n', '\r'], " ");
    send('i', &format!("{instance}\t{}\t{}", clean(name), clean(&file.to_string_lossy())));
}

fn send(kind: char, text: &str) {
    let Some(pipe) = PIPE.get() else { return };
    let line = format!("{}{kind}{text}\n", pipe.nonce);
    let mut to_parent = pipe.to_parent.lock().unwrap_or_else(PoisonError::into_inner);
    // Without a parent there is nobody to tell; the thread that watches it ends this process.
    let _ = to_parent.write_all(line.as_bytes());
}

impl Channel {
    /// Sends a text of one line.
    pub fn send(self, text: &str) {
        send('t', &text.replace('\n', " "));
    }

    /// The work is done: ends this process, without the exit functions of FMUs.
    pub fn end(self) -> ! {
        send('e', "");
        #[cfg(unix)]
        super::signals::exit_now();
        #[cfg(not(unix))]
        std::process::exit(0)
    }
}
