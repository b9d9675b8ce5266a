//! Writes the files of `model-description/`; with `--check` lists those that are out of date.

use describe::{Dependencies, generated};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let folder = Path::new("model-description");
    let check = std::env::args().any(|a| a == "--check");
    let outcome = if check {
        generated::stale(folder, Dependencies::of_all)
    } else {
        generated::write(folder).map(|()| Vec::new())
    };
    match outcome {
        Ok(stale) if stale.is_empty() => ExitCode::SUCCESS,
        Ok(stale) => {
            for path in stale {
                eprintln!(
                    "{} is out of date: run `cargo xtask describe` and commit the changes",
                    path.display()
                );
            }
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
