//! The page inside the archive: what the model is and what its variables mean.

use describe::{ModelType, Preset, StartValues, VERSION, markdown};

/// documentation/index.html.
pub fn page(kind: &ModelType, starts: &StartValues, preset: Option<&Preset>) -> String {
    let declaration = (kind.declaration)();
    let mut body = format!("<h1>{}</h1>\n<p>{}.</p>\n", declaration.name, escape(declaration.description));
    if let Some(preset) = preset {
        body +=
            &format!("<p>Start values: {} ({}).</p>\n", escape(&preset.name), escape(&preset.description));
    }
    for section in markdown::sections(kind, starts) {
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
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<title>{} {VERSION}</title>\n<style>\n\
         body {{ font: 15px/1.5 sans-serif; max-width: 72rem; margin: 2rem auto; padding: 0 1rem }}\n\
         table {{ border-collapse: collapse }}\n\
         td, th {{ border: 1px solid #ccc; padding: .2rem .5rem; text-align: left; vertical-align: top }}\n\
         td:first-child {{ font-family: monospace }}\n</style>\n</head>\n<body>\n{body}</body>\n</html>\n",
        declaration.name
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
