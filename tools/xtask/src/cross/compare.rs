//! The same run on a platform as on this one: the archive for all platforms, and the smallest master, built for it.

use super::{RUN, SETTINGS, TOLERANCE, Target, built};
use crate::{Outcome, product, shell, workspace::Workspace};
use std::path::Path;
use std::process::Command;

/// A table of numbers.
type Rows = Vec<Vec<f64>>;

/// Archives with the everyday library of this machine, for the numbers to compare with.
pub fn pack_here(workspace: &Workspace, target: &Path) -> Outcome {
    let mut command = product::motor_fmu(workspace);
    shell::output(command.args(["build", "--out"]).arg(target.join("here"))).map(drop)
}

/// Runs every model of both standards, and compares with `motor-fmu simulate` here.
pub fn run(workspace: &Workspace, one: &Target, runner: &[String], target: &Path, dist: &Path) -> Outcome {
    let program = built(one, target).join("examples").join(format!("simulate{}", one.program));
    for (model, settings) in SETTINGS {
        for standard in ["fmi2", "fmi3"] {
            let file = |root: &Path| root.join(standard).join(format!("{model}.fmu"));
            let here = target.join("here.csv");
            let mut native = product::motor_fmu(workspace);
            native.arg("simulate").arg(file(&target.join("here")));
            native.args(["--stop", RUN[0], "--step", RUN[1], "--output"]).arg(&here);
            native.args(settings.iter().flat_map(|s| ["--set", s]));
            shell::output(&mut native)?;
            let there = target.join("there.csv");
            let mut foreign = match runner.split_first() {
                None => Command::new(&program),
                Some((first, rest)) => {
                    let mut command = Command::new(first);
                    command.args(rest).arg(&program);
                    command
                }
            };
            // wine keeps what it takes for a user's folder apart from the user's.
            foreign.env("WINEPREFIX", target.join("wine")).env("WINEDEBUG", "-all");
            foreign.arg(file(dist)).args(RUN).arg(&there).args(settings);
            shell::output(&mut foreign)?;
            let difference = difference(&read(&here)?, &read(&there)?)?;
            println!("{model}, {standard}, {}: differs by {difference:.1e}", one.platform);
            if difference > TOLERANCE {
                return Err(format!(
                    "{model}, {standard}: {} differs from this machine by {difference:.1e}, the limit is {TOLERANCE:.0e}",
                    one.platform
                ));
            }
        }
    }
    Ok(())
}

/// A library of Windows that Rust's standard library takes random bytes from, and that wine 8 has not.
const PRNG: &str = "\
unsigned char __stdcall SystemFunction036(void *, unsigned long);
__declspec(dllexport) int __stdcall ProcessPrng(void *to, unsigned long long bytes) {
    return SystemFunction036(to, (unsigned long)bytes);
}
";

/// Puts that library beside the programs for wine, where Windows' own is not looked for first.
pub fn help_wine(one: &Target, target: &Path) -> Outcome {
    let Some(compiler) = one.linker else { return Ok(()) };
    let folder = built(one, target).join("examples");
    let source = folder.join("bcryptprimitives.c");
    std::fs::write(&source, PRNG).map_err(|e| format!("{} cannot be written: {e}", source.display()))?;
    let mut command = Command::new(compiler);
    command.arg("-shared").arg("-o").arg(folder.join("bcryptprimitives.dll")).arg(&source).arg("-ladvapi32");
    shell::output(&mut command).map(drop)
}

fn read(file: &Path) -> Outcome<Rows> {
    let text =
        std::fs::read_to_string(file).map_err(|e| format!("{} cannot be read: {e}", file.display()))?;
    let number = |cell: &str| cell.trim().parse().map_err(|e| format!("{}: {cell:?}: {e}", file.display()));
    text.lines().skip(1).map(|line| line.split(',').map(number).collect()).collect()
}

/// The largest difference, each column relative to its largest value.
fn difference(here: &Rows, there: &Rows) -> Outcome<f64> {
    let same_shape = here.len() == there.len() && here.iter().zip(there).all(|(a, b)| a.len() == b.len());
    if !same_shape || here.is_empty() {
        return Err(format!("the tables have {} and {} rows, or other columns", here.len(), there.len()));
    }
    let mut worst = 0.0f64;
    for column in 0..here[0].len() {
        let size = here.iter().map(|row| row[column].abs()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
        // What is nothing but rounding (the errors of the books) has no size of its own.
        let size = if size < 1e-9 { 1.0 } else { size };
        for (a, b) in here.iter().zip(there) {
            let difference = (a[column] - b[column]).abs() / size;
            worst = if difference.is_nan() { f64::INFINITY } else { worst.max(difference) };
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_compared_by_their_own_size_and_shapes_must_agree() {
        let here = vec![vec![0.0, 1000.0], vec![1.0, 2000.0]];
        assert_eq!(difference(&here, &here), Ok(0.0));
        assert_eq!(difference(&here, &vec![vec![0.0, 1000.0], vec![1.0, 2002.0]]), Ok(1e-3));
        assert_eq!(difference(&here, &vec![vec![0.0, 1000.0], vec![f64::NAN, 2000.0]]), Ok(f64::INFINITY));
        assert!(difference(&here, &here[..1].to_vec()).is_err());
    }
}
