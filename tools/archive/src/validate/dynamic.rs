//! Checks that need the FMU to run.
//!
//! They run in a child process ([`run`] starts it, [`probe`] is what it does), so that an FMU that crashes or hangs is a
//! finding and not the end of the validator. The child reports each stage before it begins; after a crash the next child
//! continues behind that stage.

use super::finding::{Finding, Findings};
use super::rules;
use cosim::{Archive, FmiVersion};
use std::collections::HashSet;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

mod facts;
mod probe;
mod report;
mod runs;
mod session;
mod solver;
mod stages;
mod subject;

pub use probe::probe;
pub use report::{Event, Observation};

/// Child processes that may crash before the validator gives up on an FMU.
const MOST_CHILDREN: usize = 6;

/// Runs the dynamic checks of an FMU through `program probe FILE STAGE`, which must print the events of [`probe`],
/// one JSON text a line. A call may take `patience`.
pub fn run(program: &Path, file: &Path, patience: Duration) -> Vec<Finding> {
    let mut out = Findings::new();
    out.version = version_of(file);
    let mut reported = HashSet::new();
    let mut from = 0;
    for _ in 0..MOST_CHILDREN {
        match follow(program, file, from, patience, &mut reported, &mut out) {
            Ok(None) => break,
            Ok(Some(next)) => from = next,
            Err(error) => {
                out.add("binaries", rules::not_run(program.display(), error));
                break;
            }
        }
    }
    out.into_list()
}

/// Follows one child to its end; then the stage at which the next one should begin, if any.
fn follow(
    program: &Path,
    file: &Path,
    from: usize,
    patience: Duration,
    reported: &mut HashSet<(String, String)>,
    out: &mut Findings,
) -> std::io::Result<Option<usize>> {
    let mut child = Command::new(program)
        .arg("probe")
        .arg(file)
        .arg(from.to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()?;
    let events = listen(&mut child);
    let (mut stage, mut doing) = (from, "loading the library".to_owned());
    let hung = loop {
        match events.recv_timeout(patience) {
            Ok(Event::Begin(number, words)) => (stage, doing) = (number, words),
            Ok(Event::Seen(o)) => {
                // A later child may find again what an earlier one has reported.
                if reported.insert((o.code.clone(), o.place.clone())) {
                    let rule = rules::ALL.iter().find(|r| r.code == o.code);
                    out.add(o.place, rule.copied().unwrap_or(&rules::LIFE_CYCLE).says(o.message));
                }
            }
            Ok(Event::Alive) => {}
            Ok(Event::End) => {
                let _ = child.wait();
                return Ok(None);
            }
            Err(RecvTimeoutError::Disconnected) => break false,
            Err(RecvTimeoutError::Timeout) => break true,
        }
    };
    if hung {
        let _ = child.kill();
    }
    let status = child.wait()?;
    let of_all = stage % stages::ALL.len();
    let is_misuse = stages::ALL[of_all].is_misuse;
    if hung {
        let message =
            format!("A call did not return within {} s (stage \"{doing}\")", patience.as_secs_f64());
        let rule = if is_misuse { &rules::HANG_ON_MISUSE } else { &rules::HANG };
        out.add("binaries", rule.says(message));
    } else {
        let message = format!("The FMU ended the process that ran it: {} (stage \"{doing}\")", cause(status));
        let rule = if is_misuse { &rules::CRASH_ON_MISUSE } else { &rules::CRASH };
        out.add("binaries", rule.says(message));
    }
    // Without a basis the other stages of the same interface type would crash in the same way.
    let rest = if stages::ALL[of_all].is_basis { stages::ALL.len() - of_all } else { 1 };
    Ok(Some(stage + rest))
}

/// The child's lines; what the FMU itself prints is passed over.
fn listen(child: &mut Child) -> Receiver<Event> {
    let (sender, receiver) = channel();
    if let Some(pipe) = child.stdout.take() {
        thread::spawn(move || {
            for line in BufReader::new(pipe).split(b'\n').map_while(Result::ok) {
                if let Ok(event) = serde_json::from_slice(&line)
                    && sender.send(event).is_err()
                {
                    break;
                }
            }
        });
    }
    receiver
}

fn cause(status: ExitStatus) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        let names = [(4, "illegal instruction"), (6, "abort"), (7, "bus error"), (8, "arithmetic exception")];
        if let Some(signal) = status.signal() {
            let name =
                names.iter().find(|(n, _)| *n == signal).map_or("segmentation fault", |(_, name)| name);
            return if signal == 11 || names.iter().any(|(n, _)| *n == signal) {
                format!("{name} (signal {signal})")
            } else {
                format!("signal {signal}")
            };
        }
    }
    status.to_string()
}

/// The version whose sections findings cite.
fn version_of(file: &Path) -> FmiVersion {
    Archive::open(file).map_or(FmiVersion::V3, |archive| archive.description().fmi_version)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// Findings with a program that replaces the validator's child process.
    fn codes(script: &str) -> Vec<&'static str> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("child");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        run(&path, Path::new("x.fmu"), Duration::from_secs(1)).iter().map(|f| f.code).collect()
    }

    const END: &str = r#"echo '"end"'"#;

    #[test]
    fn a_crash_is_a_finding_and_the_next_child_goes_on() {
        assert_eq!(codes(&format!("[ $3 = 0 ] && kill -SEGV $$; {END}")), ["crash"]);
        assert_eq!(codes(&format!("[ $3 = 0 ] && exit 3; {END}")), ["crash"]);
        assert_eq!(codes("kill -SEGV $$"), ["crash"; MOST_CHILDREN]);
    }

    #[test]
    fn a_crash_on_misuse_has_its_own_code() {
        let last = stages::ALL.len() - 1;
        assert!(stages::ALL[last].is_misuse);
        let begin = format!(r#"echo '{{"begin":[{last},"x"]}}'"#);
        assert_eq!(
            codes(&format!("[ $3 = 0 ] && {{ {begin}; kill -SEGV $$; }}; {END}")),
            ["crash-on-misuse"]
        );
        assert_eq!(codes(&format!("[ $3 = 0 ] && {{ {begin}; exec sleep 30; }}; {END}")), ["hang-on-misuse"]);
    }

    #[test]
    fn a_hang_is_a_finding() {
        assert_eq!(codes(&format!("[ $3 = 0 ] && exec sleep 30; {END}")), ["hang"]);
    }

    #[test]
    fn a_slow_child_that_shows_life_is_not_hung() {
        let alive = r#"for i in 1 2 3 4 5; do echo '"alive"'; sleep 0.4; done"#;
        assert!(codes(&format!("{alive}; {END}")).is_empty());
    }

    #[test]
    fn findings_are_reported_once_and_other_output_is_ignored() {
        let seen = r#"{"seen":{"code":"reset","place":"a","message":"x"}}"#;
        assert_eq!(codes(&format!("echo '{seen}'; echo 'hello'; echo '{seen}'; {END}")), ["reset"]);
        assert!(codes(END).is_empty());
    }
}
