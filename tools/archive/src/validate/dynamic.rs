//! Checks that need the FMU to run: it loads, goes through its life cycle, gives numbers, and resets.
//!
//! They run in a child process ([`run`] starts it, [`probe`] is what it does), so that an FMU that crashes or
//! hangs is a finding and not the end of the validator.

use super::finding::{Finding, Findings};
use super::model::Version;
use super::rules::{self, Rule};
use cosim::{Archive, Error, FmiVersion, Instance, Kind, Log, Step};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// How long an FMU may take for its few steps.
const PATIENCE: Duration = Duration::from_secs(60);
/// Steps of one run.
const STEPS: u32 = 10;

/// What the child tells the parent.
#[derive(Debug, Serialize, Deserialize)]
pub struct Observation {
    code: String,
    message: String,
}

/// Runs the dynamic checks of an FMU through `program probe FILE`, which must print what [`probe`] gives as JSON.
pub fn run(program: &Path, file: &Path) -> Vec<Finding> {
    run_within(program, file, version_of(file), PATIENCE)
}

fn run_within(program: &Path, file: &Path, version: Version, patience: Duration) -> Vec<Finding> {
    let mut out = Findings::new();
    out.version = version;
    let child = Command::new(program)
        .arg("probe")
        .arg(file)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) => {
            out.add(
                &rules::NOT_RUN,
                "binaries",
                format!("The FMU was not run: {} {error}", program.display()),
            );
            return out.into_list();
        }
    };
    // Read beside waiting: a full pipe would make a healthy child look hung.
    let pipe = child.stdout.take();
    let reader = thread::spawn(move || {
        let mut text = String::new();
        let _ = pipe.map(|mut p| p.read_to_string(&mut text));
        text
    });
    let started = Instant::now();
    let ended = loop {
        match child.try_wait() {
            Ok(Some(status)) => break Some(status),
            Ok(None) if started.elapsed() < patience => thread::sleep(Duration::from_millis(2)),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                break None;
            }
        }
    };
    let text = reader.join().unwrap_or_default();
    match ended {
        None => out.add(
            &rules::HANG,
            "binaries",
            format!("A call did not return within {} s", patience.as_secs()),
        ),
        Some(status) => match serde_json::from_str::<Vec<Observation>>(&text) {
            Ok(observations) if status.success() => {
                for o in observations {
                    let rule =
                        rules::ALL.iter().find(|r| r.code == o.code).copied().unwrap_or(&rules::LIFE_CYCLE);
                    out.add(rule, "binaries", o.message);
                }
            }
            _ => out.add(
                &rules::CRASH,
                "binaries",
                format!("The FMU ended the process that ran it ({status})"),
            ),
        },
    }
    out.into_list()
}

/// Loads and runs the FMU in this process.
pub fn probe(file: &Path) -> Vec<Observation> {
    let mut seen = Vec::new();
    if let Err((rule, message)) = observe(file, &mut seen) {
        seen.push(Observation { code: rule.code.to_string(), message });
    }
    seen
}

type Fault = (&'static Rule, String);

fn observe(file: &Path, seen: &mut Vec<Observation>) -> Result<(), Fault> {
    let because =
        |rule: &'static Rule| move |error: Error| (rule, error.to_string().trim_end_matches('.').to_string());
    // What cannot be opened or has no such interface is the static checks' business.
    let archive = Archive::open(file).map_err(because(&rules::NOT_RUN))?;
    if archive.description().co_simulation.is_none() {
        return Err((&rules::NOT_RUN, "The FMU was not run: it has no Co-Simulation interface".to_string()));
    }
    archive.binary_path().map_err(because(&rules::NOT_RUN))?;
    let log = Log::new();
    let mut instance = Instance::instantiate(&archive, "probe", log).map_err(because(&rules::INSTANTIATE))?;
    let first = one_run(&archive, &mut instance).map_err(because(&rules::LIFE_CYCLE))?;
    for (name, value) in &first {
        if !value.is_finite() {
            let message = format!("Output \"{name}\" is {value} with all variables at their start values");
            seen.push(Observation { code: rules::OUTPUT_NOT_FINITE.code.to_string(), message });
        }
    }
    instance.reset().map_err(because(&rules::LIFE_CYCLE))?;
    let second = one_run(&archive, &mut instance).map_err(because(&rules::LIFE_CYCLE))?;
    for ((name, a), (_, b)) in first.iter().zip(&second) {
        if a.to_bits() != b.to_bits() && !(a.is_nan() && b.is_nan()) {
            let message =
                format!("Output \"{name}\" is {a} in the first run and {b} in the same run after a reset");
            return Err((&rules::RESET, message));
        }
    }
    Ok(())
}

/// Initialization, some steps, the outputs, termination.
fn one_run(archive: &Archive, instance: &mut Instance) -> Result<Vec<(String, f64)>, Error> {
    let description = archive.description();
    let experiment = &description.default_experiment;
    let start = experiment.start.unwrap_or(0.0);
    let span = experiment.stop.map_or(1.0, |stop| stop - start);
    let h = experiment.step.filter(|h| *h > 0.0).unwrap_or(if span > 0.0 { span / 500.0 } else { 1e-3 });
    instance.enter_initialization(start, None, None)?;
    instance.exit_initialization()?;
    for k in 0..STEPS {
        if let Step::Terminated = instance.do_step(start + f64::from(k) * h, h)? {
            break;
        }
    }
    let mut values = Vec::new();
    let scalars = description.outputs().filter(|v| v.kind == Kind::Float64 && v.dimensions.is_empty());
    for variable in scalars {
        let mut value = [0.0];
        instance.get_f64(&[variable.value_reference], &mut value)?;
        values.push((variable.name.clone(), value[0]));
    }
    instance.terminate()?;
    Ok(values)
}

/// The version whose sections findings cite.
fn version_of(file: &Path) -> Version {
    match Archive::open(file) {
        Ok(archive) if archive.description().fmi_version == FmiVersion::V2 => Version::Fmi2,
        _ => Version::Fmi3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// A program that stands for the validator's child.
    fn child(script: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("child");
        std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        (folder, path)
    }

    fn codes(script: &str) -> Vec<&'static str> {
        let (_folder, program) = child(script);
        let patience = Duration::from_secs(1);
        run_within(&program, Path::new("x.fmu"), Version::Fmi2, patience).iter().map(|f| f.code).collect()
    }

    #[test]
    fn a_crash_is_a_finding() {
        assert_eq!(codes("kill -SEGV $$"), ["crash"]);
        assert_eq!(codes("exit 3"), ["crash"]);
    }

    #[test]
    fn a_hang_is_a_finding() {
        assert_eq!(codes("exec sleep 30"), ["hang"]);
    }

    #[test]
    fn what_the_child_saw_is_told() {
        assert_eq!(codes(r#"echo '[{"code":"reset","message":"x"}]'"#), ["reset"]);
        assert!(codes("echo '[]'").is_empty());
    }
}
