//! Running other programs, with progress lines and one sentence when they fail.

use crate::Outcome;
use std::io::{BufRead, BufReader, IsTerminal};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Announces a stage of work.
pub fn stage(what: &str) {
    if std::io::stderr().is_terminal() {
        eprintln!("\x1b[1;32m==>\x1b[0m \x1b[1m{what}\x1b[0m");
    } else {
        eprintln!("==> {what}");
    }
}

/// What a command is called in messages: program and arguments.
fn spelled(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|w| w.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

fn start(command: &mut Command) -> Outcome<Child> {
    let name = spelled(command);
    command.spawn().map_err(|e| format!("`{name}` cannot be started: {e}"))
}

/// Waits for the end of a command.
fn finish(mut child: Child, name: &str) -> Outcome {
    match child.wait() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{name}` failed ({status})")),
        Err(e) => Err(format!("`{name}` was lost: {e}")),
    }
}

/// Whether a program is on the path.
pub fn is_program(name: &str) -> bool {
    Command::new(name).arg("--version").output().is_ok()
}

/// Runs a command with its output on ours.
pub fn run(command: &mut Command) -> Outcome {
    finish(start(command)?, &spelled(command))
}

/// Runs a command silently and returns what it wrote to standard output.
pub fn output(command: &mut Command) -> Outcome<String> {
    let name = spelled(command);
    let done = command.output().map_err(|e| format!("`{name}` cannot be started: {e}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
    if done.status.success() {
        Ok(text(&done.stdout))
    } else {
        Err(format!("`{name}` failed ({}): {}", done.status, text(&done.stderr)))
    }
}

/// Runs a command, shows its standard output as it comes, and returns the lines that `keep` wants, failed or not.
pub fn run_keeping(command: &mut Command, keep: impl Fn(&str) -> bool) -> (Vec<String>, Outcome) {
    let name = spelled(command);
    let mut child = match start(command.stdout(Stdio::piped())) {
        Ok(child) => child,
        Err(sentence) => return (Vec::new(), Err(sentence)),
    };
    let mut kept = Vec::new();
    for line in BufReader::new(child.stdout.take().expect("stdout is piped")).lines() {
        let Ok(line) = line else { break };
        println!("{line}");
        if keep(&line) {
            kept.push(line);
        }
    }
    (kept, finish(child, &name))
}

/// How a command under a time limit ended.
#[derive(Debug, PartialEq, Eq)]
pub enum Ending {
    /// It said yes.
    Success,
    /// It said no.
    Failure,
    /// It was stopped.
    TimeUp,
}

/// Runs a command silently, and stops it when the time is up or when a line of its output has the answer no.
pub fn run_until(command: &mut Command, no: impl Fn(&str) -> bool, limit: Duration) -> Outcome<Ending> {
    let begin = Instant::now();
    let mut child = start(command.stdout(Stdio::piped()).stderr(Stdio::null()))?;
    let (sender, lines) = std::sync::mpsc::channel();
    let output = BufReader::new(child.stdout.take().expect("stdout is piped"));
    // Not joined: it ends with the output, which a grandchild may keep open.
    std::thread::spawn(move || output.lines().map_while(Result::ok).all(|line| sender.send(line).is_ok()));
    let mut stop = |ending| {
        // It may end by itself between the two calls; then there is nothing to stop.
        let _ = child.kill();
        let _ = child.wait();
        Ok(ending)
    };
    loop {
        let left = limit.saturating_sub(begin.elapsed());
        match lines.recv_timeout(left.min(Duration::from_secs(3600))) {
            Ok(line) if no(&line) => return stop(Ending::Failure),
            Ok(_) => {}
            Err(RecvTimeoutError::Timeout) if left.is_zero() => return stop(Ending::TimeUp),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = child.wait().map_err(|e| format!("`{}` was lost: {e}", spelled(command)))?;
    Ok(if status.success() { Ending::Success } else { Ending::Failure })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    fn sh(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn output_is_returned_and_a_failure_names_command_and_reason() {
        assert_eq!(output(&mut sh("echo yes")).unwrap(), "yes");
        let error = output(&mut sh("echo no >&2; exit 3")).unwrap_err();
        assert!(error.contains("exit 3") && error.ends_with("no"), "{error}");
    }

    #[test]
    fn a_missing_program_is_named() {
        let error = run(&mut Command::new("no-such-program")).unwrap_err();
        assert!(error.contains("no-such-program"), "{error}");
    }

    #[test]
    fn kept_lines_survive_a_failure() {
        let (kept, outcome) = run_keeping(&mut sh("echo a; echo b1; echo b2; false"), |l| l.starts_with('b'));
        assert_eq!(kept, ["b1", "b2"]);
        assert!(outcome.is_err());
    }

    #[test]
    fn a_command_that_hangs_is_stopped() {
        let run = |script: &str, limit: u64| {
            run_until(&mut sh(script), |line| line == "no", Duration::from_millis(limit)).unwrap()
        };
        assert_eq!(run("exec sleep 60", 100), Ending::TimeUp);
        assert_eq!(run("echo no; exec sleep 61", 60_000), Ending::Failure);
        assert_eq!(run("exit 1", 60_000), Ending::Failure);
        assert_eq!(run("echo yes", 60_000), Ending::Success);
    }
}
