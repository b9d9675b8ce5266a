//! Pages as HTML: one file each, complete in itself, for wide and narrow windows, light and dark, and paper.

use crate::figure::Drawing;
use crate::{DARK, LIGHT, Palette, typeset};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Rows of a table with more columns than this become blocks of lines in a narrow window.
const COLUMNS_OF_A_NARROW_WINDOW: usize = 4;

/// The rules; a page has them in one line.
const STYLE: &str = include_str!("page.css");

/// The colours as custom properties.
fn scheme(p: &Palette) -> String {
    let Palette { ink, soft, grid, paper, raised, .. } = p;
    let link = p.series[0];
    format!("--ink:{ink};--soft:{soft};--grid:{grid};--paper:{paper};--raised:{raised};--link:{link}")
}

/// A page with its title as first heading.
pub fn page(title: &str, body: Markup) -> String {
    document(title, html! { h1 { (typeset(title)) } (body) })
}

/// A page of one figure in the middle; the title is in the figure.
pub fn page_of_figure(title: &str, svg: &str) -> String {
    document(title, html! { figure.alone { (PreEscaped(svg)) } })
}

fn document(title: &str, body: Markup) -> String {
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
                style { (PreEscaped(colours)) (PreEscaped(STYLE.replace('\n', ""))) }
            }
            body { (body) }
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
        html! { figure { (PreEscaped(&self.svg)) figcaption { (typeset(&self.caption)) } } }
    }
}

/// An SVG for light paper from elsewhere with its caption. Its prologue is left out.
pub fn picture(svg: &str, caption: &str) -> Option<Markup> {
    let svg = &svg[svg.find("<svg")?..];
    Some(html! { figure.picture { (PreEscaped(svg)) figcaption { (typeset(caption)) } } })
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
    /// A unit of FMI; it stays in one line where there is room, and is broken between its factors where there is none.
    Unit(&'static str),
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
    let headers: Vec<String> = headers.iter().map(|header| typeset(header)).collect();
    let cards = (headers.len() > COLUMNS_OF_A_NARROW_WINDOW).then_some("cards");
    html! {
        div.wide tabindex="0" { table id=[id] class=[cards] {
            thead { tr { @for (k, header) in headers.iter().enumerate() { th class=[is_number(k).then_some("n")] { (header) } } } }
            tbody { @for (word, cells) in &rows {
                tr data-filter=[(!word.is_empty()).then_some(word)] {
                    @for (cell, header) in cells.iter().zip(&headers) {
                        @match cell {
                            Cell::Text(text) => td class=[(text.chars().count() > 60).then_some("w")] data-label=(header) { (typeset(text)) },
                            // Several numbers in a cell may stand below each other.
                            Cell::Number(text) => td.n.m[text.contains(", ")] data-label=(header) { (typeset(text)) },
                            Cell::Unit(name) => td.u data-label=(header) { (breakable(&crate::words::unit(name))) },
                            Cell::Code(text) => td data-label=(header) { @if !text.is_empty() { code { (text) } } },
                        }
                    }
                }
            } }
        } }
    }
}

/// A unit that is longer than this is broken between its factors in a narrow column.
const LONG_UNIT: usize = 6;

/// A unit that may be broken behind its dots and bars.
fn breakable(unit: &str) -> Markup {
    let factors: Vec<&str> = match unit.chars().count() > LONG_UNIT {
        true => unit.split_inclusive(['·', '/']).collect(),
        false => vec![unit],
    };
    // The tests read pages as XML, in which every element ends.
    html! { @for (k, factor) in factors.iter().enumerate() { @if k > 0 { (PreEscaped("<wbr/>")) } (factor) } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check;
    use crate::figure::{Axis, Figure};

    /// A unit that is wider than its column would make the table scroll.
    #[test]
    fn long_units_may_be_broken_between_their_factors() {
        let unit = |name: &'static str| table(&["unit"], vec![vec![Cell::Unit(name)]]).into_string();
        assert!(
            unit("N.m.s0.5/rad0.5").contains(">N·<wbr/>m·<wbr/>s^0.5/<wbr/>rad^0.5<"),
            "{}",
            unit("N.m.s0.5/rad0.5")
        );
        assert!(unit("N.m/A").contains(">N·m/A<") && unit("1").contains("data-label=\"unit\"></td>"));
    }

    /// What is printed has minus signs and numbers that stay with their units; what is code can be copied.
    #[test]
    fn texts_of_pages_are_typeset() {
        let cells = vec!["at -5 K".into(), Cell::number(-0.25), Cell::Code("--set k=-1".into())];
        let all = html! {
            (table(&["place", "value", "command"], vec![cells]))
            (picture("<svg></svg>", "Mean of -3 °C").unwrap())
        };
        let all = all.into_string();
        for text in [">at −5\u{a0}K<", ">−0.25<", ">--set k=-1<", ">Mean of −3\u{a0}°C<"] {
            assert!(all.contains(text), "{text}: {all}");
        }
    }

    #[test]
    fn a_page_of_all_parts_has_no_fault_and_escapes_what_it_is_given() {
        let figure = Figure::new("Power", Axis::new("time in s"), Axis::new("power in W"));
        let body = html! {
            (plates(&[Plate::new("power", figure.line("a & b", vec![(0.0, 1.0)]), "The <power>.")]))
            (table(&["name", "value"], vec![vec![Cell::Code("motor.R_ref".into()), Cell::number(0.386)], vec![
                "\"quoted\"".into(),
                Cell::Number("15 min, 45 %".to_owned()),
            ]]))
            // Five columns, so blocks in a narrow window; there and in a row a unit is not broken.
            (table(&["limit", "of", "size", "unit", "reason"], vec![vec![Cell::number(1.0), "a".into(), "b".into(), Cell::Unit("W/K4"), "c".into()]]))
            (picture("<?xml version=\"1.0\"?><svg aria-label=\"walk\"></svg>", "A walk").unwrap())
        };
        let page = page("A & B < C", body);
        assert_eq!(check::faults(&page), Vec::<String>::new());
        for text in [
            "<h1>A &amp; B &lt; C</h1>",
            "The &lt;power&gt;.",
            "a &amp; b",
            "&quot;quoted&quot;",
            "<td class=\"u\" data-label=\"unit\">W/K⁴</td>",
        ] {
            assert!(page.contains(text), "{text}: {page}");
        }
        assert!(STYLE.contains("@media (min-width:601px){td.u{white-space:nowrap}}"));
        assert!(
            STYLE.contains(".cards td.n:first-child::before"),
            "a number as the head of a block has its label"
        );
        // Several numbers in a cell may stand below each other.
        assert!(page.contains("<td class=\"n m\" data-label=\"value\">15\u{a0}min, 45\u{a0}%<"), "{page}");
        assert!(!page.contains("<?xml") && picture("png", "").is_none());
    }
}
