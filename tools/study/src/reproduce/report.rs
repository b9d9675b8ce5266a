//! The pages: one file each, complete in itself, for light and dark.

mod paper;
mod thesis;

pub use paper::paper;
pub use thesis::thesis;

use super::{Printed, Row, Verdict, significant};
use crate::figure::{Figure, escaped};
use std::fmt::Write;

/// A page and its figures.
pub struct Page {
    /// Name of the page's file, without ending.
    pub name: &'static str,
    /// The page, complete in itself.
    pub html: String,
    /// Figures as files of their own: name without ending, SVG.
    pub figures: Vec<(String, String)>,
}

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#24292f;--soft:#57606a;--line:#d8dee4;--paper:#fff;--mark:#f6f8fa}
@media (prefers-color-scheme:dark){:root{--ink:#e6edf3;--soft:#9aa4af;--line:#30363d;--paper:#0d1117;--mark:#161b22}}
body{font:16px/1.55 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;color:var(--ink);background:var(--paper);\
max-width:1380px;margin:2rem auto;padding:0 1.2rem}
h1{font-size:1.7rem;line-height:1.25;margin:0 0 .4rem}h2{font-size:1.2rem;margin:2.4rem 0 .6rem}
p{max-width:76ch}.soft{color:var(--soft)}
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,520px),1fr));gap:1.6rem}
figure{margin:0}figure svg{width:100%;height:auto}figcaption{color:var(--soft);font-size:.9rem;max-width:70ch}
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.88rem;font-variant-numeric:tabular-nums}
th,td{padding:.32rem .7rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{position:sticky;top:0;background:var(--mark)}td.n,th.n{text-align:right;white-space:nowrap}
td.w{min-width:26ch}select{font:inherit;padding:.15rem .4rem}
";

const SCRIPT: &str = "
const choice=document.getElementById('verdict');
choice.onchange=()=>{for(const r of document.querySelectorAll('#rows tbody tr'))\
r.hidden=choice.value!==''&&r.dataset.verdict!==choice.value};
";

/// A figure with its name, its place in the publication and what to see.
struct Plate {
    name: &'static str,
    figure: Figure,
    caption: String,
}

impl Plate {
    fn new(name: &'static str, figure: Figure, caption: impl Into<String>) -> Plate {
        Plate { name, figure, caption: caption.into() }
    }
}

/// Everything that a page says.
struct Content<'a> {
    name: &'static str,
    title: &'static str,
    conclusion: &'a str,
    absent: Option<&'a str>,
    plates: Vec<Plate>,
    tables: String,
    rows: &'a [Row],
}

fn page(content: Content) -> Page {
    let mut html = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title}</title><style>{STYLE}</style></head><body><h1>{title}</h1>\
         <p>{}</p>",
        escaped(content.conclusion),
        title = escaped(content.title)
    );
    if let Some(reason) = content.absent {
        let _ = write!(html, "<p class=\"soft\">Without the native model: {}.</p>", escaped(reason));
    }
    let mut figures = Vec::new();
    html.push_str("<h2>Figures</h2><div class=\"figures\">");
    for plate in content.plates {
        let svg = plate.figure.svg();
        let _ = write!(html, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(&plate.caption));
        figures.push((format!("{}-{}", content.name, plate.name), svg));
    }
    html.push_str("</div>");
    html.push_str(&content.tables);
    html.push_str(&all_rows(content.rows));
    let _ = write!(html, "<script>{SCRIPT}</script></body></html>");
    Page { name: content.name, html, figures }
}

/// The table of rows with its filter.
fn all_rows(rows: &[Row]) -> String {
    let mut html = String::from(
        "<h2>Every printed number</h2><p><label>Verdict <select id=\"verdict\"><option value=\"\">all",
    );
    let _ = write!(html, " ({})</option>", rows.len());
    for verdict in Verdict::ALL {
        let count = rows.iter().filter(|r| r.verdict == verdict).count();
        if count > 0 {
            let words = verdict.words();
            let _ = write!(html, "<option value=\"{words}\">{words} ({count})</option>");
        }
    }
    html.push_str("</select></label></p><div class=\"wide\">");
    let headers = [
        "id",
        "where",
        "quantity",
        "#printed",
        "#as published",
        "#corrected",
        "#measured",
        "unit",
        "verdict",
        "why",
    ];
    let body = rows.iter().map(|row| {
        let number = |v: Option<f64>| format!("#{}", v.map_or(String::new(), significant));
        let printed = match &row.printed {
            Printed::Number(value) => format!("#{}", significant(*value)),
            Printed::Text(text) => (*text).to_owned(),
        };
        let cells = vec![
            row.id.to_owned(),
            row.location.to_owned(),
            row.quantity.clone(),
            printed,
            number(row.as_published),
            number(row.corrected),
            number(row.measured),
            row.unit.to_owned(),
            row.verdict.words().to_owned(),
            row.note.clone(),
        ];
        (row.verdict.words(), cells)
    });
    html.push_str(&table("rows", &headers, body));
    html.push_str("</div>");
    html
}

/// A table; cells that begin with # are numbers. Each row carries a word to filter by.
fn table<'a>(id: &str, headers: &[&str], rows: impl Iterator<Item = (&'a str, Vec<String>)>) -> String {
    let mut html = format!("<table id=\"{id}\"><thead><tr>");
    let cell = |tag: &str, text: &str| match text.strip_prefix('#') {
        Some(number) => format!("<{tag} class=\"n\">{}</{tag}>", escaped(number)),
        None if text.len() > 60 => format!("<{tag} class=\"w\">{}</{tag}>", escaped(text)),
        None => format!("<{tag}>{}</{tag}>", escaped(text)),
    };
    html.extend(headers.iter().map(|h| cell("th", h)));
    html.push_str("</tr></thead><tbody>");
    for (word, cells) in rows {
        let _ = write!(html, "<tr data-verdict=\"{word}\">");
        html.extend(cells.iter().map(|c| cell("td", c)));
        html.push_str("</tr>");
    }
    html.push_str("</tbody></table>");
    html
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page needs nothing from outside and holds every row.
    #[test]
    fn pages_are_complete_in_themselves() {
        for page in [
            thesis(&crate::reproduce::thesis::thesis(false).unwrap()),
            paper(&crate::reproduce::paper::paper().unwrap()),
        ] {
            for outside in ["src=", "href=", "@import", "url("] {
                assert!(!page.html.contains(outside), "{}: {outside}", page.name);
            }
            assert!(!page.html.contains("NaN"), "{}", page.name);
            assert!(page.html.matches("<tr data-verdict").count() > 35 && !page.figures.is_empty());
        }
    }
}
