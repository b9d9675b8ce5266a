//! The page inside the archive: what the model is, what it can do, how to start, and what its variables mean.
//! One file that opens without a network.

mod chart;
mod figures;

use crate::native::Native;
use crate::{reference, terminals};
use describe::{DEFAULT_STEP, DEFAULT_STOP, Preset, VERSION, markdown};

const STYLE: &str = "\
body { font: 15px/1.5 sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem; color: #222; background: #fff }
h2 { margin-top: 2.5rem }
table { border-collapse: collapse }
td, th { border: 1px solid #ccc; padding: .2rem .5rem; text-align: left; vertical-align: top }
td:first-child { font-family: monospace }
pre { background: #f4f4f4; padding: .8rem; overflow-x: auto }
figure { margin: 1.5rem 0; max-width: 46rem }
svg { width: 100%; font: 12px sans-serif }
svg .title { font-size: 14px; font-weight: bold }
svg .grid { stroke: #ddd; fill: none }
figcaption { color: #555 }
";

/// documentation/index.html.
pub fn page(native: &Native<'_>, preset: Option<&Preset>) -> String {
    let declaration = (native.kind.declaration)();
    let name = declaration.name;
    let mut body = format!("<h1>{name}</h1>\n<p>{}.</p>\n", escape(declaration.description));
    if let Some(preset) = preset {
        body +=
            &format!("<p>Start values: {} ({}).</p>\n", escape(&preset.name), escape(&preset.description));
    }
    body += "<h2>What it does</h2>\n";
    for figure in figures::of(native) {
        let (svg, caption) = (figure.chart.svg(), escape(&figure.caption));
        body += &format!("<figure>\n{svg}<figcaption>{caption}</figcaption>\n</figure>\n");
    }
    body += &format!(
        "<h2>How to start</h2>\n<p>In Python, with fmpy:</p>\n<pre>{}</pre>\n",
        escape(&start(native))
    );
    body += &in_the_archive(native);
    for section in markdown::sections(native.kind, native.starts) {
        body += &format!("<h2>{}</h2>\n<table>\n<tr>", section.title);
        body += &markdown::COLUMNS.iter().map(|c| format!("<th>{c}</th>")).collect::<String>();
        body += "</tr>\n";
        for row in &section.rows {
            body += "<tr>";
            body += &row.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect::<String>();
            body += "</tr>\n";
        }
        body += "</table>\n";
    }
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{name} {VERSION}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n{body}</body>\n</html>\n"
    )
}

/// A script that runs the model with what drives it and its load at their nominal values.
fn start(native: &Native<'_>) -> String {
    let declaration = (native.kind.declaration)();
    let name = declaration.name;
    let own = figures::own(native);
    let nominal = |name: &&str| native.entry(name).map(|e| (name.to_string(), e.row));
    let drive: Vec<String> = (own.drive.iter().filter_map(nominal))
        .map(|(name, row)| format!("\"{name}\": {}", row.nominal.clamp(row.min, row.max)))
        .collect();
    format!(
        "from fmpy import plot_result, simulate_fmu\n\n\
         result = simulate_fmu(\n    \"{name}.fmu\",\n    stop_time={DEFAULT_STOP},\n    step_size={DEFAULT_STEP},\n    \
         output_interval={DEFAULT_STEP},\n    start_values={{{}}},\n    \
         output=[{}],\n)\nplot_result(result)\n",
        drive.join(", "),
        own.shown.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
    )
}

/// What else lies in the archive, and which variables belong together.
fn in_the_archive(native: &Native<'_>) -> String {
    let declaration = (native.kind.declaration)();
    let [inputs, results] = reference::file_names(declaration.name);
    let mut text = format!(
        "<h2>Reference results</h2>\n<p>{0}/{inputs} holds inputs, {0}/{results} what the native model answers at \
         communication steps of {DEFAULT_STEP} s. An importer that holds inputs over a step reads the same numbers.</p>\n",
        reference::FOLDER
    );
    let terminals = terminals::of(declaration);
    if !terminals.is_empty() {
        text +=
            "<h2>Terminals</h2>\n<table>\n<tr><th>terminal</th><th>what it is</th><th>variables</th></tr>\n";
        for terminal in terminals {
            let members: Vec<String> =
                terminal.members.iter().map(|(variable, kind)| format!("{variable} ({kind})")).collect();
            text += &format!(
                "<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                terminal.name,
                terminal.what,
                members.join(", ")
            );
        }
        text += "</table>\n";
    }
    text
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
