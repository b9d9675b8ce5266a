//! `motor-fmu reproduce`: the numbers of the two published systems.

use crate::Failure;
use ::study::reproduce::{Printed, Row, report, significant};
use ::study::reproduce::{paper::paper, thesis::thesis};
use clap::ValueEnum;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A published system.
#[derive(Clone, Copy, ValueEnum)]
pub enum Which {
    /// Thesis: EC-4pole motor with fan and annulus
    Thesis,
    /// Paper: brushed gearmotor driven by PWM
    Paper,
}

/// Recompute every number of a published system: as printed, as published, put right, measured.
#[derive(clap::Args)]
pub struct Args {
    /// Which one
    which: Which,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
    /// Write a page with the figures, and the figures as SVG, into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (json, rows, conclusion, page) = match args.which {
        Which::Thesis => {
            let found = thesis(args.json || args.out.is_some())?;
            let page = report::thesis(&found);
            (serde_json::to_value(&found)?, found.rows, found.conclusion, page)
        }
        Which::Paper => {
            let found = paper()?;
            let page = report::paper(&found);
            (serde_json::to_value(&found)?, found.rows, found.conclusion, page)
        }
    };
    if let Some(folder) = &args.out {
        write(folder, &page)?;
    }
    crate::say(&if args.json { machine(&json)? } else { table(&rows, &conclusion) });
    Ok(ExitCode::SUCCESS)
}

fn machine(json: &Value) -> Result<String, Failure> {
    Ok(format!("{}\n", serde_json::to_string_pretty(json)?))
}

/// The page and its figures; the folder is made where it is missing.
fn write(folder: &Path, page: &report::Page) -> Result<(), Failure> {
    let failed = |path: &Path, error: std::io::Error| {
        Failure::new(format!("{} cannot be written: {error}", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|e| failed(folder, e))?;
    let put = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).map_err(|e| failed(&path, e))
    };
    for (name, svg) in &page.figures {
        put(&format!("{name}.svg"), svg)?;
    }
    put(&format!("{}.html", page.name), &page.html)
}

fn table(rows: &[Row], conclusion: &str) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), significant);
    let mut text = format!(
        "{:14} {:44} {:>12} {:>12} {:>12}  {:8} {}\n",
        "id", "quantity", "printed", "as published", "corrected", "unit", "verdict"
    );
    for row in rows {
        let printed = match &row.printed {
            Printed::Number(value) => significant(*value),
            Printed::Text(_) => "-".to_owned(),
        };
        text += &format!(
            "{:14} {:44} {:>12} {:>12} {:>12}  {:8} {}\n",
            row.id,
            shortened(&row.quantity, 44),
            printed,
            number(row.as_published),
            number(row.corrected),
            row.unit,
            row.verdict.words()
        );
    }
    format!("{text}\n{conclusion}\n")
}

fn shortened(text: &str, length: usize) -> String {
    if text.chars().count() <= length {
        return text.to_owned();
    }
    text.chars().take(length - 1).chain(['…']).collect()
}
