//! The smallest master: `simulate FILE.fmu STOP STEP OUTPUT.csv [NAME=VALUE]...`.
//!
//! `cargo xtask cross` builds it for each platform and runs it there, to see what the library of that platform computes.

use cosim::{Archive, Options, simulate};
use std::path::Path;
use std::process::ExitCode;

fn run(arguments: &[String]) -> Result<(), String> {
    let [file, stop, step, output, sets @ ..] = arguments else {
        return Err("usage: simulate FILE.fmu STOP STEP OUTPUT.csv [NAME=VALUE]...".into());
    };
    let number = |text: &str| text.parse::<f64>().map_err(|e| format!("{text:?} is no number: {e}"));
    let set = |text: &String| match text.split_once('=') {
        Some((name, value)) => Ok((name.to_owned(), value.to_owned())),
        None => Err(format!("{text:?} is not NAME=VALUE")),
    };
    let options = Options {
        stop: Some(number(stop)?),
        step: Some(number(step)?),
        sets: sets.iter().map(set).collect::<Result<_, _>>()?,
        ..Options::default()
    };
    let archive = Archive::open(Path::new(file)).map_err(|e| e.to_string())?;
    let recording = simulate(&archive, &options, &mut |_| ()).map_err(|e| e.to_string())?;
    recording.write_csv(Path::new(output)).map_err(|e| e.to_string())
}

fn main() -> ExitCode {
    match run(&std::env::args().skip(1).collect::<Vec<_>>()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("{sentence}");
            ExitCode::FAILURE
        }
    }
}
