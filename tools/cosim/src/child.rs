//! FMUs in a child process: a crash, an end of the process or a call that does not return becomes an [`Ending`] with the name of
//! the call.
//!
//! The parent ([`supervise`]) owns the temporary folder of the child. It gets lines over a pipe that no code of an FMU sees, each
//! with a number that only the two processes know, and reads from shared memory in which call the child is ([`crate::page`]).
//! The child (`inside.rs`) is a process group of its own. When its parent is gone, it removes the folder and ends.
mod inside;
#[cfg(unix)]
mod signals;

pub(crate) use inside::standard_input;
pub use inside::{Channel, enter};

use crate::number;
use crate::page::{self, Function, LastCall, Page, SharedPage};
use crate::raw::function_name;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// How a child process ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// It said that it has done everything.
    Done,
    /// It ended without that.
    Died {
        /// How: "segmentation fault (signal 11)".
        cause: String,
        /// In which call of the FMU.
        call: Call,
    },
    /// A call did not return.
    Hung(Call),
}

/// The call of an FMU in which, or after which, a process ended.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Call {
    /// "in fmi2DoStep of motor at t = 0.02 s", "after fmi2DoStep of motor ..."
    pub text: String,
    /// The archive of the instance, where it is known.
    pub file: String,
}

impl Call {
    /// The last call; `instances` have name and file.
    fn last(page: &Page, instances: &[(String, String)]) -> Self {
        let (calls, time) = page.last();
        let (mut texts, mut last) = (Vec::new(), String::new());
        for LastCall { lasts, function, version, instance } in calls {
            let (name, file) = instances.get(instance).cloned().unwrap_or_default();
            let function = match function {
                Function::START => return Self { text: "before the first call of an FMU".to_owned(), file },
                Function::LOAD => "loading the library",
                Function(number) => function_name(number - Function::FIRST, version),
            };
            let mut text = format!("{} {function}", if lasts { "in" } else { "after" });
            if !name.is_empty() {
                text += &format!(" of {name}");
            }
            if function.ends_with("DoStep") {
                text += &format!(" at t = {} s", number(time));
            }
            texts.push(text);
            last = file;
        }
        // Calls of several threads lasted: one of them is the cause.
        Self { file: if texts.len() == 1 { last } else { String::new() }, text: texts.join(" or ") }
    }
}

/// A program to run as child.
pub struct Work<'a> {
    /// The program; it calls [`enter`] before anything else.
    pub program: &'a Path,
    /// Its arguments.
    pub arguments: &'a [OsString],
    /// How long one call of an FMU may take.
    pub patience: Duration,
    /// Whether the child's standard error is this process's.
    pub shows_errors: bool,
    /// What a child that reads the standard input finds there: its own is the pipe from this process.
    pub standard_input: Option<&'a [u8]>,
}

/// The name of the file with [`Work::standard_input`] in the folder of the child.
const STANDARD_INPUT: &str = "standard-input";

/// How often the shared memory is read.
const TICK: Duration = Duration::from_millis(50);
/// How long a child may take from its last word to its end, and its last words to arrive after that.
const GRACE: Duration = Duration::from_secs(2);

/// A line of the child.
enum Line {
    /// An instance: its number, its name and its archive.
    Instance(usize, String, String),
    Text(String),
    End,
}

/// Runs a child process to its end. `receive` gets each text that it sends.
///
/// # Errors
/// The process cannot be started.
pub fn supervise(work: &Work, receive: &mut dyn FnMut(&str)) -> io::Result<Ending> {
    let folder = crate::archive::temporary_folder().map_err(io::Error::other)?;
    let page = SharedPage::create(&folder.path().join(page::FILE))?;
    if let Some(bytes) = work.standard_input {
        std::fs::write(folder.path().join(STANDARD_INPUT), bytes)?;
    }
    let mut command = Command::new(work.program);
    command.args(work.arguments).stdin(Stdio::piped()).stdout(Stdio::piped());
    if !work.shows_errors {
        command.stderr(Stdio::null());
    }
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn()?;
    #[cfg(unix)]
    signals::guard(child.id());
    let nonce = nonce();
    // The pipe stays open as long as this process lives: the child notices its end.
    let mut lifeline = child.stdin.take();
    if let Some(pipe) = &mut lifeline {
        // A child that is gone already is noticed below.
        let _ = pipe.write_all(format!("{nonce}\n{}\n", folder.path().display()).as_bytes());
    }
    let lines = listen(&mut child, &nonce);
    let ending = follow(&mut child, &lines, &page, work.patience, receive);
    end(&mut child);
    ending
}

fn follow(
    child: &mut Child,
    lines: &Receiver<Line>,
    page: &Page,
    patience: Duration,
    receive: &mut dyn FnMut(&str),
) -> io::Result<Ending> {
    let mut instances: Vec<(String, String)> = Vec::new();
    let (mut word, mut since) = (page.mark(), Instant::now());
    loop {
        match lines.recv_timeout(TICK.min(patience)) {
            Ok(Line::End) => return Ok(Ending::Done),
            Ok(Line::Text(text)) => {
                receive(&text);
                since = Instant::now();
            }
            Ok(Line::Instance(number, name, file)) => {
                instances.resize(instances.len().max(number + 1), Default::default());
                instances[number] = (name, file);
            }
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) if child.try_wait()?.is_some() => {
                // A process that the FMU has started may hold the pipe open. What was sent still counts, and on a busy machine it takes
                // its time to arrive; without such a process the wait ends with the last line.
                while let Ok(line) = lines.recv_timeout(GRACE) {
                    match line {
                        Line::End => return Ok(Ending::Done),
                        Line::Text(text) => receive(&text),
                        Line::Instance(..) => {}
                    }
                }
                break;
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        let now = page.mark();
        if now != word {
            (word, since) = (now, Instant::now());
        } else if page.is_busy() && since.elapsed() >= patience {
            return Ok(Ending::Hung(Call::last(page, &instances)));
        }
    }
    let started = Instant::now();
    let status = loop {
        match child.try_wait()? {
            Some(status) => break Some(status),
            None if started.elapsed() > GRACE => break None,
            None => thread::sleep(TICK / 10),
        }
    };
    let cause = status.map_or("it closed the connection to its parent".to_owned(), cause);
    Ok(Ending::Died { cause, call: Call::last(page, &instances) })
}

/// Ends what is left of the child and of the processes that it has started.
fn end(child: &mut Child) {
    #[cfg(unix)]
    signals::end_group(child.id());
    let _ = child.kill();
    let _ = child.wait();
}

/// The child's lines that begin with the number; what an FMU prints does not.
fn listen(child: &mut Child, nonce: &str) -> Receiver<Line> {
    let (sender, receiver) = channel();
    let nonce = nonce.to_owned();
    if let Some(pipe) = child.stdout.take() {
        thread::spawn(move || {
            for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
                let line = String::from_utf8_lossy(&line).into_owned();
                let Some(line) = line.strip_prefix(&nonce).and_then(read) else { continue };
                let is_end = matches!(line, Line::End);
                if sender.send(line).is_err() || is_end {
                    break;
                }
            }
        });
    }
    receiver
}

/// A line after the number: a letter for its kind, then its content.
fn read(line: &str) -> Option<Line> {
    let content = line.get(1..)?;
    Some(match line.get(..1)? {
        "t" => Line::Text(content.to_owned()),
        "e" => Line::End,
        "i" => {
            let mut parts = content.splitn(3, '\t');
            let number = parts.next()?.parse().ok().filter(|n| *n <= page::MOST_INSTANCES)?;
            Line::Instance(number, parts.next()?.to_owned(), parts.next()?.to_owned())
        }
        _ => return None,
    })
}

/// A number that an FMU cannot guess.
fn nonce() -> String {
    use std::hash::{BuildHasher, Hasher, RandomState};
    let number = || RandomState::new().build_hasher().finish();
    format!("{:016x}{:016x}", number(), number())
}

/// How a process ended, in words.
fn cause(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        let names = [
            (4, "illegal instruction"),
            (6, "abort"),
            (7, "bus error"),
            (8, "arithmetic exception"),
            (11, "segmentation fault"),
            (15, "termination"),
        ];
        if let Some(signal) = status.signal() {
            let name = names.iter().find(|(n, _)| *n == signal);
            return name.map_or(format!("signal {signal}"), |(_, name)| format!("{name} (signal {signal})"));
        }
    }
    status.to_string()
}
