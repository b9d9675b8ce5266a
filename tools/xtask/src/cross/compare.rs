//! The same run on a platform as on this one: the archive for all platforms, and the smallest master, built for it.

use super::{RUN, SETTINGS, TOLERANCE, Target, built};
use crate::{Outcome, files, product, shell, workspace::Workspace};
use std::path::Path;
use std::process::Command;

/// A table of numbers with the names of its columns.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// Endings of the names of balance residuals: differences of powers or energies, which are rounding errors.
const MISSED: &str = "_balance_error";

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
            native.args(["--stop", RUN[0], "--step", RUN[1], "--force", "--output"]).arg(&here);
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
            let (worst, column) = difference(&read(&here)?, &read(&there)?)?;
            println!("{model}, {standard}, {}: differs by {worst:.1e} at most ({column})", one.platform);
            if worst > TOLERANCE || worst.is_nan() {
                return Err(format!(
                    "{model}, {standard}: {column} on {} differs from this machine by {worst:.1e}, the limit is {TOLERANCE:.0e}",
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
    files::write(&source, PRNG)?;
    let mut command = Command::new(compiler);
    command.arg("-shared").arg("-o").arg(folder.join("bcryptprimitives.dll")).arg(&source).arg("-ladvapi32");
    shell::output(&mut command).map(drop)
}

fn read(file: &Path) -> Outcome<Table> {
    let text = files::read(file)?;
    let number = |cell: &str| cell.trim().parse().map_err(|e| format!("{}: {cell:?}: {e}", file.display()));
    let mut lines = text.lines();
    let names = lines.next().unwrap_or_default().split(',').map(str::to_string).collect();
    let rows = lines.map(|line| line.split(',').map(number).collect()).collect::<Outcome<_>>()?;
    Ok(Table { names, rows })
}

/// The largest difference and its column. It is relative to the column's largest value, or to one unit where that is
/// more: a small flow of heat is a conductance times a difference of two temperatures, and as sure as these. What
/// a balance residual is compared with the largest value of the run.
fn difference(here: &Table, there: &Table) -> Outcome<(f64, String)> {
    let lengths = |t: &Table| t.rows.iter().map(Vec::len).collect::<Vec<_>>();
    if here.names != there.names || lengths(here) != lengths(there) || here.rows.is_empty() {
        return Err(format!(
            "the tables have {} and {} rows, or other columns",
            here.rows.len(),
            there.rows.len()
        ));
    }
    let size = |column: usize| here.rows.iter().map(|row| row[column].abs()).fold(1.0, f64::max);
    let largest = (0..here.names.len()).map(size).fold(1.0, f64::max);
    let mut worst = (0.0, "nothing".to_string());
    for (column, name) in here.names.iter().enumerate() {
        let size = if name.ends_with(MISSED) { largest } else { size(column) };
        for (a, b) in here.rows.iter().zip(&there.rows) {
            let found = (a[column] - b[column]).abs() / size;
            if found > worst.0 || found.is_nan() {
                worst = (found, name.clone());
            }
            if found.is_nan() {
                return Ok(worst);
            }
        }
    }
    Ok(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(rows: &[[f64; 3]]) -> Table {
        let names = ["speed", "heat", "power_balance_error"].map(String::from).to_vec();
        Table { names, rows: rows.iter().map(|r| r.to_vec()).collect() }
    }

    #[test]
    fn columns_are_compared_by_their_size_and_shapes_must_agree() {
        let here = table(&[[0.0, 0.01, 0.0], [2000.0, 0.02, 1e-12]]);
        let found = |rows: &[[f64; 3]]| difference(&here, &table(rows)).unwrap();
        assert_eq!(found(&[[0.0, 0.01, 0.0], [2000.0, 0.02, 1e-12]]).0, 0.0);
        assert_eq!(found(&[[0.0, 0.01, 0.0], [2002.0, 0.02, 1e-12]]), (1e-3, "speed".into()));
        assert!((found(&[[0.0, 0.01, 0.0], [2000.0, 0.03, 1e-12]]).0 - 0.01).abs() < 1e-15);
        assert_eq!(found(&[[0.0, 0.01, 2e-9], [2000.0, 0.02, 1e-12]]), (1e-12, "power_balance_error".into()));
        assert!(found(&[[0.0, f64::NAN, 0.0], [2000.0, 0.02, 1e-12]]).0.is_nan());
        assert!(difference(&here, &table(&[[0.0, 0.01, 0.0]])).is_err());
    }
}
