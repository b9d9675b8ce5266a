//! Pages as HTML: one file each, complete in itself, for wide and narrow windows, light and dark, and paper.

use crate::figure::Drawing;
use crate::{DARK, LIGHT, Palette};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Rows of a table with more columns than this become blocks of lines in a narrow window.
const COLUMNS_OF_A_NARROW_WINDOW: usize = 4;

const STYLE: &str = "\
body{font:16px/1.55 system-ui,'Segoe UI',Helvetica,Arial,sans-serif;color:var(--ink);background:var(--paper);\
max-width:1320px;margin:2rem auto;padding:0 1rem;overflow-wrap:anywhere}\
h1{font-size:1.7rem;line-height:1.25;margin:0 0 .4rem}h2{font-size:1.25rem;margin:2.4rem 0 .6rem}\
h3{font-size:1.05rem;margin:1.6rem 0 .4rem}p,li{max-width:76ch}a{color:var(--link)}\
.soft,figcaption{color:var(--soft)}.lead{font-size:1.15rem;line-height:1.45;max-width:66ch}\
.figures{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,460px),1fr));gap:1.6rem}\
figure{margin:0;max-width:640px}figure svg{display:block;width:100%;height:auto}figure.picture{max-width:960px}\
.picture div{overflow-x:auto}.picture svg{min-width:620px}@media (prefers-color-scheme:dark){.picture svg{filter:invert(.93) hue-rotate(180deg)}}\
figcaption{font-size:.9rem;max-width:70ch}\
code,pre{font-family:ui-monospace,Consolas,monospace;font-size:.9em}\
pre{background:var(--raised);padding:.8rem;overflow-x:auto;overflow-wrap:normal}\
.wide{overflow-x:auto;margin:.6rem 0}table{border-collapse:collapse;font-size:.88rem;font-variant-numeric:tabular-nums;overflow-wrap:normal}\
th,td{padding:.32rem .6rem;border-bottom:1px solid var(--grid);text-align:left;vertical-align:top}\
th{background:var(--raised);vertical-align:bottom}td.n,th.n{text-align:right}td.n{white-space:nowrap}td.w{min-width:26ch}\
select{font:inherit;color:inherit;background:var(--raised);border:1px solid var(--grid);padding:.15rem .4rem;max-width:100%}\
details{margin:.6rem 0}summary{cursor:pointer;font-weight:600}[hidden]{display:none!important}\
@media (max-width:600px){body{margin:1rem auto}td:last-child{overflow-wrap:anywhere}\
.cards thead{display:none}.cards,.cards tbody,.cards tr,.cards td{display:block}\
.cards tr{border-bottom:1px solid var(--grid);padding:.5rem 0}\
.cards td,.cards td.n{border:0;padding:.1rem 0;text-align:left;white-space:normal;overflow-wrap:anywhere}.cards td.w{min-width:0}\
.cards td:empty{display:none}.cards td:first-child{font-weight:600}\
.cards td:not(:first-child)::before{content:attr(data-label) ': ';color:var(--soft)}}\
@media print{body{max-width:none;margin:0}.wide{overflow:visible}figure,tr{break-inside:avoid}\
details::details-content{content-visibility:visible;display:block}}";

/// The colours as custom properties.
fn scheme(p: &Palette) -> String {
    let Palette { ink, soft, grid, paper, raised, .. } = p;
    let link = p.series[0];
    format!("--ink:{ink};--soft:{soft};--grid:{grid};--paper:{paper};--raised:{raised};--link:{link}")
}

/// A page with its title as first heading.
pub fn page(title: &str, body: Markup) -> String {
    let (light, dark) = (scheme(&LIGHT), scheme(&DARK));
    let colours = format!(
        ":root{{color-scheme:light dark;{light}}}@media (prefers-color-scheme:dark){{:root{{{dark}}}}}"
    );
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(colours)) (PreEscaped(STYLE)) }
            }
            body { h1 { (title) } (body) }
        }
    };
    page.into_string() + "\n"
}

/// A figure with its name and caption.
pub struct Plate {
    /// Name without spaces.
    pub name: &'static str,
    /// The figure.
    pub svg: String,
    /// What to see.
    pub caption: String,
}

impl Plate {
    /// A figure with its name and caption.
    pub fn new(name: &'static str, figure: impl Drawing, caption: impl Into<String>) -> Plate {
        Plate { name, svg: figure.svg(), caption: caption.into() }
    }

    /// The figure with its caption.
    pub fn markup(&self) -> Markup {
        html! { figure { (PreEscaped(&self.svg)) figcaption { (self.caption) } } }
    }
}

/// An SVG for light paper from elsewhere with its caption. Its prologue is left out; it scrolls in a narrow window.
pub fn picture(svg: &str, caption: &str) -> Option<Markup> {
    let svg = &svg[svg.find("<svg")?..];
    Some(html! { figure.picture { div tabindex="0" { (PreEscaped(svg)) } figcaption { (caption) } } })
}

/// Figures side by side where there is room.
pub fn plates(plates: &[Plate]) -> Markup {
    html! { div.figures { @for plate in plates { (plate.markup()) } } }
}

/// A cell of a table.
#[derive(Clone, Debug)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number, at the right.
    Number(String),
    /// A name of a variable or file as it is written.
    Code(String),
}

impl Cell {
    /// A number with four digits.
    pub fn number(value: f64) -> Cell {
        Cell::Number(crate::number(value))
    }

    /// A number with four digits, or nothing.
    pub fn maybe(value: Option<f64>) -> Cell {
        Cell::Number(value.map_or(String::new(), crate::number))
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Cell {
        Cell::Text(text.into())
    }
}

/// A table, which scrolls where it is too wide, or becomes blocks of lines.
pub fn table(headers: &[&str], rows: Vec<Vec<Cell>>) -> Markup {
    labelled_table("", headers, rows.into_iter().map(|cells| ("", cells)).collect())
}

/// A table with an identity; each row carries a word to filter by.
pub fn labelled_table(id: &str, headers: &[&str], rows: Vec<(&str, Vec<Cell>)>) -> Markup {
    let is_number = |k: usize| rows.iter().any(|(_, cells)| matches!(cells.get(k), Some(Cell::Number(_))));
    let id = (!id.is_empty()).then_some(id);
    let cards = (headers.len() > COLUMNS_OF_A_NARROW_WINDOW).then_some("cards");
    html! {
        div.wide tabindex="0" { table id=[id] class=[cards] {
            thead { tr { @for (k, header) in headers.iter().enumerate() { th class=[is_number(k).then_some("n")] { (header) } } } }
            tbody { @for (word, cells) in &rows {
                tr data-filter=[(!word.is_empty()).then_some(word)] {
                    @for (cell, header) in cells.iter().zip(headers) {
                        @match cell {
                            Cell::Text(text) => td class=[(text.chars().count() > 60).then_some("w")] data-label=(header) { (text) },
                            Cell::Number(text) => td.n data-label=(header) { (text) },
                            Cell::Code(text) => td data-label=(header) { @if !text.is_empty() { code { (text) } } },
                        }
                    }
                }
            } }
        } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check;
    use crate::figure::{Axis, Figure};

    #[test]
    fn a_page_of_all_parts_has_no_fault_and_escapes_what_it_is_given() {
        let figure = Figure::new("Power", Axis::new("time in s"), Axis::new("power in W"));
        let body = html! {
            (plates(&[Plate::new("power", figure.line("a & b", vec![(0.0, 1.0)]), "The <power>.")]))
            (table(&["name", "value"], vec![vec![Cell::Code("motor.R_ref".into()), Cell::number(0.386)], vec![
                "\"quoted\"".into(),
                Cell::maybe(None),
            ]]))
            (picture("<?xml version=\"1.0\"?><svg aria-label=\"walk\"></svg>", "A walk").unwrap())
        };
        let page = page("A & B < C", body);
        assert_eq!(check::faults(&page), Vec::<String>::new());
        for text in ["<h1>A &amp; B &lt; C</h1>", "The &lt;power&gt;.", "a &amp; b", "&quot;quoted&quot;"] {
            assert!(page.contains(text), "{text}: {page}");
        }
        assert!(!page.contains("<?xml") && picture("png", "").is_none());
    }
}
