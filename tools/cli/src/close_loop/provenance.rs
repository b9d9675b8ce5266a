//! What a report was made of: program, data and date.

use crate::Failure;
use calibrate::experiment::Experiment;
use calibrate::report::Provenance;
use sha2::{Digest, Sha256};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// Program and date, with the hash of an experiment's file and of the files of its runs, each once, in their order.
pub fn of(file: &Path, experiment: &Experiment) -> Result<Provenance, Failure> {
    let folder = delimited::folder(file);
    let mut paths = vec![file.to_path_buf()];
    for path in experiment.runs.iter().map(|run| folder.join(&run.file)) {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    let mut hash = Sha256::new();
    for path in &paths {
        let bytes = std::fs::read(path)
            .map_err(|e| Failure::new(format!("{} cannot be read: {e}", path.display())))?;
        hash.update(bytes);
    }
    let digits = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
    // A build or a test that has to be repeatable says which date it is (reproducible-builds.org).
    let stated = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|text| text.parse().ok());
    let now = || SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    Ok(Provenance {
        program: format!("motor-fmu {}", env!("CARGO_PKG_VERSION")),
        data_sha256: digits,
        date: date(stated.unwrap_or_else(now)),
    })
}

/// Seconds since 1970 as a date and time of ISO 8601. *Source*: days to civil dates by eras of 400 years that begin in March.
fn date(seconds: u64) -> String {
    const ERA: u64 = 146_097;
    let (days, rest) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (era, day) = (days / ERA, days % ERA);
    let year = (day - day / 1460 + day / 36_524 - day / (ERA - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = 400 * era + year + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", rest / 3600, rest / 60 % 60, rest % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_of_leap_years_and_their_ends() {
        for (seconds, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_735_689_599, "2024-12-31T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(date(seconds), text);
        }
    }

    /// The hash is that of the files behind each other, and changes with a reading.
    #[test]
    fn the_hash_is_that_of_experiment_and_runs() {
        let folder = tempfile::tempdir().unwrap();
        let run =
            "time_s,current_A,ambient_temperature_degC,winding_temperature_degC\n0,1,20,20\n9,1,20,21\n";
        let text = "[experiment]\nname = \"a\"\nmodel = \"AnnulusCooledMotor\"\npreset = \"maxon-305015\"\n\
                    inputs = [\"current_A\", \"ambient_temperature_degC\"]\noutputs = [\"winding_temperature_degC\"]\n\
                    [[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n[[run]]\nfile = \"a.csv\"\nrole = \"test\"\n";
        let file = folder.path().join("e.toml");
        let hash = |run: &str| {
            std::fs::write(folder.path().join("a.csv"), run).unwrap();
            std::fs::write(&file, text).unwrap();
            of(&file, &Experiment::read(&file).unwrap()).unwrap().data_sha256
        };
        let found = hash(run);
        let whole = Sha256::digest(format!("{text}{run}"));
        assert_eq!(found, whole.iter().map(|b| format!("{b:02x}")).collect::<String>());
        assert_ne!(found, hash(&run.replace("21", "22")));
    }
}
