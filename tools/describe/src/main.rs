//! Writes the files of `model-description/`; with `--check` lists those that are out of date.

use describe::{Dependencies, generated};
use physics::model::ModelType;
use std::path::Path;
use std::process::ExitCode;

/// The dependencies of a model, with a line of progress: the motors take minutes.
fn announced(kind: &ModelType) -> Dependencies {
    eprintln!("{}: dependencies in all combinations of the modes", (kind.declaration)().name);
    Dependencies::of_all(kind)
}

fn main() -> ExitCode {
    let folder = Path::new("model-description");
    let check = std::env::args().any(|a| a == "--check");
    let outcome = if check {
        generated::stale(folder, announced)
    } else {
        generated::write(folder, announced).map(|()| Vec::new())
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
