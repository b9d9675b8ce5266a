//! Checks that need the FMU to run.
//!
//! They run in a child process ([`run`] starts it, [`mod@probe`] is what it does), so that an FMU that crashes or hangs is a
//! finding and not the end of the validator. The child reports each stage before it begins; after a crash the next child
//! continues behind that stage.

use super::finding::{Finding, Findings};
use super::rules;
use cosim::FmiVersion;
use cosim::child::{Ending, Work, supervise};
use std::collections::HashSet;
use std::ffi::OsString;
use std::path::Path;
use std::time::Duration;

mod facts;
mod held;
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

/// Runs the dynamic checks of an FMU of this standard through `program probe FILE STAGE`, a child of
/// [`cosim::child`] that sends the events of [`mod@probe`] as JSON. A call may take `patience`.
pub fn run(program: &Path, file: &Path, version: FmiVersion, patience: Duration) -> Vec<Finding> {
    let mut out = Findings::new();
    out.version = version;
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
    let (mut stage, mut doing) = (from, "loading the library".to_owned());
    let mut next = None;
    let arguments: [OsString; 3] = ["probe".into(), file.into(), from.to_string().into()];
    let work = Work { program, arguments: &arguments, patience, shows_errors: false, standard_input: None };
    let ending = supervise(&work, &mut |text| match serde_json::from_str(text) {
        Ok(Event::Begin(number, words)) => (stage, doing) = (number, words),
        Ok(Event::Seen(o)) => {
            // A later child may find again what an earlier one has reported.
            if reported.insert((o.code.clone(), o.place.clone())) {
                let rule = rules::ALL.iter().find(|r| r.code == o.code);
                out.add(o.place, rule.copied().unwrap_or(&rules::LIFE_CYCLE).says(o.message));
            }
        }
        Ok(Event::Next(number)) => next = Some(number),
        Err(_) => {}
    })?;
    let of_all = stage % stages::ALL.len();
    let is_misuse = stages::ALL[of_all].is_misuse;
    let breach = match ending {
        Ending::Done => return Ok(next),
        Ending::Hung(call) => {
            let rule = if is_misuse { &rules::HANG_ON_MISUSE } else { &rules::HANG };
            let seconds = patience.as_secs_f64();
            let call = call.text;
            rule.says(format!("A call did not return within {seconds} s: {call} (stage \"{doing}\")"))
        }
        Ending::Died { cause, call } => {
            let rule = if is_misuse { &rules::CRASH_ON_MISUSE } else { &rules::CRASH };
            let call = call.text;
            rule.says(format!("The FMU ended the process that ran it, {call}: {cause} (stage \"{doing}\")"))
        }
    };
    out.add("binaries", breach);
    // Without a basis the other stages of the same interface type would crash in the same way.
    let rest = if stages::ALL[of_all].is_basis { stages::ALL.len() - of_all } else { 1 };
    Ok(Some(stage + rest))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::process::Command;

    /// Findings with a program that replaces the validator's child process. Another process writes it: a child that another test starts
    /// meanwhile would inherit the open file, and a file that is open for writing cannot be run.
    fn codes(script: &str) -> Vec<&'static str> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("child");
        let text = format!("#!/bin/sh\nread n\n{script}\n");
        let write = r#"printf %s "$1" > "$0" && chmod 755 "$0""#;
        assert!(Command::new("sh").args(["-c", write]).arg(&path).arg(text).status().unwrap().success());
        run(&path, Path::new("x.fmu"), FmiVersion::V2, Duration::from_secs(1))
            .iter()
            .map(|f| f.code)
            .collect()
    }

    const END: &str = r#"echo "${n}e""#;

    #[test]
    fn a_crash_is_a_finding_and_the_next_child_goes_on() {
        assert_eq!(codes(&format!("[ $3 = 0 ] && kill -SEGV $$; {END}")), ["crash"]);
        assert_eq!(codes(&format!("[ $3 = 0 ] && exit 3; {END}")), ["crash"]);
        assert_eq!(codes("kill -SEGV $$"), ["crash"; MOST_CHILDREN]);
    }

    /// As on a busy machine, where the process has ended before its last line is read.
    #[test]
    fn a_last_line_that_arrives_late_is_no_crash() {
        assert_eq!(codes(&format!("( sleep 0.3; {END} ) &")), [""; 0]);
    }

    #[test]
    fn a_crash_on_misuse_has_its_own_code() {
        let last = stages::ALL.len() - 1;
        assert!(stages::ALL[last].is_misuse);
        let begin = format!(r#"echo "$n"'t{{"begin":[{last},"x"]}}'"#);
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
        let alive = r#"for i in 1 2 3 4 5; do echo "${n}tx"; sleep 0.4; done"#;
        assert!(codes(&format!("{alive}; {END}")).is_empty());
    }

    #[test]
    fn findings_are_reported_once_and_other_output_is_ignored() {
        let seen = r#"{"seen":{"code":"reset","place":"a","message":"x"}}"#;
        let seen = format!(r#"echo "$n"'t{seen}'"#);
        assert_eq!(codes(&format!("{seen}; echo 'hello'; {seen}; {END}")), ["reset"]);
        assert!(codes(END).is_empty());
        // What an FMU prints ends nothing, whatever it prints.
        let printed = r#"echo '"end"'; echo e; echo "$n"; echo "x${n}e""#;
        assert_eq!(codes(&format!("{printed}; [ $3 = 0 ] && kill -SEGV $$; {END}")), ["crash"]);
    }
}
