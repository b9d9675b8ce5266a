//! `motor-fmu reproduce`: the numbers of the two published systems.

use crate::Failure;
use crate::existing::{Force, title};
use crate::progress::Progress;
use ::study::reproduce::paper::{Compared, paper};
use ::study::reproduce::thesis::{CaseResult, Fits, thesis};
use ::study::reproduce::{Basis, Printed, Row, report, significant};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// A publication.
#[derive(Clone, Copy, ValueEnum)]
pub enum Which {
    /// Thesis: EC-4pole motor with fan and annulus
    Thesis,
    /// Paper: brushed gearmotor driven by PWM
    Paper,
}

/// Recompute every number of a publication: published, recomputed by the published equations, corrected, measured.
///
/// Where the corrected value comes from a fitted model, the table marks it: "fitted" if the published value was used in the fit,
/// "predicted" if it was not.
///
/// Verdicts: holds = follows from what is published; "holds, see note" = follows, with the restriction in the note; inconsistent = does not
/// follow; editorial error = a text, equation or reference is misprinted, missing or in the wrong place; unit, sign or physics error = the
/// unit, the sign or the physics is wrong; not a validation = the two compared values are not independent of each other; remark = neither
/// right nor wrong. The notes are in the output of --json and in the page of --out.
#[derive(clap::Args)]
pub struct Args {
    /// Publication
    which: Which,
    /// Print everything as JSON
    #[arg(long)]
    json: bool,
    /// Write a page with the figures, and the figures as SVG, into this folder; for the thesis also with fits of other causes
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if let Some(folder) = &args.out {
        // Before the computation: a page of any title may be an earlier result.
        let name = match args.which {
            Which::Thesis => "thesis",
            Which::Paper => "paper",
        };
        args.force.check_titled(&folder.join(format!("{name}.html")), EARLIER, |_| true)?;
        crate::make_folder(folder)?;
    }
    let bar = Progress::new("recomputing the publication");
    let (json, rows, conclusion, page) = match args.which {
        Which::Thesis => {
            let fits = if args.out.is_some() { Fits::Alternatives } else { Fits::Rig };
            let found = thesis(fits)?;
            let page = report::thesis(&found);
            let conclusion = format!("{}\n{}\n", cases(&found.cases), found.conclusion);
            (serde_json::to_value(&found)?, found.rows, conclusion, page)
        }
        Which::Paper => {
            let found = paper()?;
            let page = report::paper(&found);
            let conclusion = format!("{}\n{}\n", compared(&found.compared), found.conclusion);
            (serde_json::to_value(&found)?, found.rows, conclusion, page)
        }
    };
    bar.finish();
    if let Some(folder) = &args.out {
        write(folder, &page, args.force)?;
    }
    if args.json {
        crate::say_json(&json)?;
    } else {
        crate::say(&table(&rows, &conclusion));
    }
    Ok(ExitCode::SUCCESS)
}

/// What an earlier result is called in an error message.
const EARLIER: &str = "an earlier result of reproduce";

/// The page and its figures.
fn write(folder: &Path, page: &report::Page, force: Force) -> Result<(), Failure> {
    let figures = page.figures.iter().map(|(name, svg)| (format!("{name}.svg"), svg));
    let files: Vec<_> = figures.chain([(format!("{}.html", page.name), &page.html)]).collect();
    for (name, text) in &files {
        let own = title(text.as_bytes());
        let is_own = |title: &str| own.as_deref() == Some(title);
        force.check_titled(&folder.join(name), EARLIER, is_own)?;
    }
    files.iter().try_for_each(|(name, text)| crate::write(&folder.join(name), text))
}

fn table(rows: &[Row], conclusion: &str) -> String {
    let number = |value: Option<f64>| value.map_or("-".to_owned(), significant);
    let mut text = format!(
        "{:14} {:44} {:>12} {:>12} {:>12} {:9}  {:8} {}\n",
        "id", "quantity", "published", "recomputed", "corrected", "", "unit", "verdict"
    );
    for row in rows {
        let printed = match &row.printed {
            Printed::Number(value) => significant(*value),
            Printed::Text(_) => "-".to_owned(),
        };
        text += &format!(
            "{:14} {:44} {printed:>12} {:>12} {:>12} {:9}  {:8} {}\n",
            row.id,
            shortened(&row.quantity, 44),
            number(row.as_published),
            number(row.corrected),
            row.basis.map_or("", Basis::text),
            row.unit,
            row.verdict.text()
        );
    }
    format!("{text}\n{conclusion}")
}

/// Winding temperatures of the thesis's tests: measured, and with errors those of the fit and of both predictions.
fn cases(cases: &[CaseResult]) -> String {
    let mut text = format!(
        "{:16} {:>10} {:>18} {:>18} {:>18}\n",
        "T_w in K", "measured", "fitted", "leave-one-out", "untuned"
    );
    for case in cases {
        let with_error = |value: Option<f64>| {
            value.map_or("-".to_owned(), |t| format!("{t:.1} ({:+.1})", t - case.T_w_measured_K))
        };
        text += &format!(
            "{:16} {:>10.1} {:>18} {:>18} {:>18}\n",
            case.name,
            case.T_w_measured_K,
            with_error(Some(case.T_w_model_K)),
            with_error(case.T_w_leave_one_out_K),
            with_error(Some(case.T_w_untuned_K))
        );
    }
    text
}

/// Published and simulated quantities of the paper.
fn compared(all: &[Compared]) -> String {
    let mut text =
        format!("{:34} {:>12} {:>12} {:6} {}\n", "quantity", "published", "simulated", "unit", "basis");
    for c in all {
        let basis = if c.used_in_fit {
            format!("{}: {}", Basis::Fitted.text(), c.fitted.join(", "))
        } else {
            Basis::Predicted.text().to_owned()
        };
        let (published, simulated) = (significant(c.published), significant(c.simulated));
        text += &format!("{:34} {published:>12} {simulated:>12} {:6} {basis}\n", c.quantity, c.unit);
    }
    text
}

fn shortened(text: &str, length: usize) -> String {
    if text.chars().count() <= length {
        return text.to_owned();
    }
    text.chars().take(length - 1).chain(['…']).collect()
}
