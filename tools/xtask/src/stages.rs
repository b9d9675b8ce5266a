//! A run of several stages: each is timed, a failed one does not stop the others, and a table closes the run.

use crate::{Outcome, shell};
use std::fmt::Write;
use std::time::{Duration, Instant};

/// How one stage ended.
struct Row {
    name: String,
    time: Duration,
    /// Lines of the stage's own program that sum it up, such as `test result: ok. 12 passed`.
    closing: Vec<String>,
    /// The sentence of the failure.
    failure: Option<String>,
}

/// The stages that have run.
#[derive(Default)]
pub struct Stages {
    rows: Vec<Row>,
}

impl Stages {
    /// Runs a stage that gives closing lines; whether it succeeded.
    pub fn keeping(&mut self, name: &str, run: impl FnOnce() -> (Vec<String>, Outcome)) -> bool {
        shell::stage(name);
        let begin = Instant::now();
        let (closing, outcome) = run();
        let failure = outcome.err();
        if let Some(sentence) = &failure {
            eprintln!("{name}: {sentence}");
        }
        let succeeded = failure.is_none();
        self.rows.push(Row { name: name.into(), time: begin.elapsed(), closing, failure });
        succeeded
    }

    /// Runs a stage; whether it succeeded.
    pub fn run(&mut self, name: &str, run: impl FnOnce() -> Outcome) -> bool {
        self.keeping(name, || (Vec::new(), run()))
    }

    /// Prints the closing lines and the table; an error when a stage failed.
    pub fn finish(self) -> Outcome {
        shell::stage("summary");
        print!("{}", self.table());
        match self.rows.iter().filter(|row| row.failure.is_some()).count() {
            0 => Ok(()),
            1 => Err("1 stage failed".into()),
            n => Err(format!("{n} stages failed")),
        }
    }

    fn table(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            for line in &row.closing {
                writeln!(text, "{}: {line}", row.name).expect("a String takes all");
            }
        }
        let width = self.rows.iter().map(|row| row.name.len()).max().unwrap_or(0).max("stage".len());
        writeln!(text, "{:<width$}  {:>8}  result", "stage", "time").expect("a String takes all");
        let mut line = |name: &str, time: Duration, result: &str| {
            writeln!(text, "{name:<width$}  {:>6.0} s  {result}", time.as_secs_f64())
                .expect("a String takes all");
        };
        for row in &self.rows {
            match &row.failure {
                None => line(&row.name, row.time, "ok"),
                Some(sentence) => line(&row.name, row.time, &format!("FAILED: {sentence}")),
            }
        }
        line("all", self.rows.iter().map(|row| row.time).sum(), "");
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_stage_is_counted_and_the_next_one_runs() {
        let mut stages = Stages::default();
        assert!(!stages.keeping("a", || (vec!["1 failed".into()], Err("no".into()))));
        assert!(stages.run("b", || Ok(())));
        let table = stages.table();
        assert!(table.starts_with("a: 1 failed\nstage "), "{table}");
        assert!(
            table.contains("FAILED: no") && table.lines().any(|l| l.starts_with("b ") && l.ends_with("ok"))
        );
        assert_eq!(stages.finish().unwrap_err(), "1 stage failed");
    }
}
