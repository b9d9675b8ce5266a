//! A page: one file, complete in itself, for light and dark.

use crate::figure::{Drawing, escaped};
use std::fmt::Write;

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
.lead{font-size:1.2rem;line-height:1.45;max-width:62ch}
details{margin:.8rem 0}summary{cursor:pointer;font-weight:600}li{max-width:76ch}
";

/// A figure with its name and what to see.
pub struct Plate {
    /// Name without spaces.
    pub name: &'static str,
    /// The figure.
    pub svg: String,
    /// What to see.
    pub caption: String,
}

impl Plate {
    /// A figure with its name and what to see.
    pub fn new(name: &'static str, figure: impl Drawing, caption: impl Into<String>) -> Plate {
        Plate { name, svg: figure.svg(), caption: caption.into() }
    }
}

/// The beginning of a page, with its title as the first heading.
pub fn begun(title: &str) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width\"><title>{title}</title><style>{STYLE}</style></head><body><h1>{title}</h1>",
        title = escaped(title)
    )
}

/// Figures side by side where there is room.
pub fn plates(plates: &[Plate]) -> String {
    let mut html = String::from("<div class=\"figures\">");
    for plate in plates {
        let (svg, caption) = (&plate.svg, escaped(&plate.caption));
        let _ = write!(html, "<figure>{svg}<figcaption>{caption}</figcaption></figure>");
    }
    html + "</div>"
}

/// A table; cells that begin with # are numbers. Each row carries a word to filter by.
pub fn table<'a>(id: &str, headers: &[&str], rows: impl Iterator<Item = (&'a str, Vec<String>)>) -> String {
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
