//! Messages of a child process to its parent (see `supervised.rs`).
use cosim::child::Channel;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::sync::OnceLock;

/// The time limit of a call of an FMU (s); a step of a large model may take minutes.
pub const PATIENCE: &str = "300";

/// A message of the child process.
#[derive(Debug, Serialize, Deserialize)]
pub enum Event {
    /// Text for standard output.
    Say(String),
    /// Text for standard error.
    Complain(String),
    /// The fraction of the simulation that is done.
    Progress(f64),
    /// The exit code at the end.
    Code(u8),
    /// Why the command could not run.
    Failed(String),
}

static PARENT: OnceLock<Channel> = OnceLock::new();

/// From now on this process is a child.
pub fn set(channel: Channel) {
    let _ = PARENT.set(channel);
}

/// Sends a message; `false` without a parent.
pub fn send(event: Event) -> bool {
    let Some(parent) = PARENT.get() else { return false };
    parent.send(&serde_json::to_string(&event).unwrap_or_default());
    true
}

/// Lets the parent print to standard output; `false` without a parent.
pub fn say(text: &str) -> bool {
    send(Event::Say(text.to_owned()))
}

/// Lets the parent print lines to standard error; without a parent, this process does.
pub fn complain(text: &str) {
    if !send(Event::Complain(format!("{text}\n"))) {
        // `eprintln!` would panic where nobody reads.
        let _ = writeln!(std::io::stderr(), "{text}");
    }
}

/// Reports the fraction that is done.
pub fn progress(share: f64) {
    send(Event::Progress(share));
}
