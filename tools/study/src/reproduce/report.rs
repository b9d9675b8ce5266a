//! The pages: one file each, complete in itself, for light and dark.

mod paper;
mod thesis;

pub use paper::paper;
pub use thesis::thesis;

use super::{Printed, Row, Verdict, significant};
use maud::{Markup, PreEscaped, html};
use present::figure::{Axis, Figure};
use present::page::{Cell, Plate, labelled_table, page, plates};
use present::typeset;
use present::words::{sentence, unit};
use serde::Deserialize;
use std::collections::BTreeMap;

/// A page and its figures.
pub struct Page {
    /// Name of the page's file, without ending.
    pub name: &'static str,
    /// The page, complete in itself.
    pub html: String,
    /// Figures as files of their own: name without ending, SVG.
    pub figures: Vec<(String, String)>,
}

const SCRIPT: &str = "
const choice=document.getElementById('verdict');
choice.onchange=()=>{for(const r of document.querySelectorAll('#rows tbody tr'))
r.hidden=choice.value===''?false:r.dataset.filter!==choice.value};
";

/// The content of a page.
struct Content<'a> {
    name: &'static str,
    title: &'static str,
    /// What was published, and what this page is.
    lead: &'static str,
    conclusion: &'a str,
    plates: Vec<Plate>,
    tables: Markup,
    rows: &'a [Row],
}

fn page_of(content: Content) -> Page {
    let body = html! {
        p.lead { (content.lead) }
        h2 { "Conclusion" }
        p { (typeset(&sentence(content.conclusion))) }
        h2 { "Figures" }
        (plates(&content.plates))
        (content.tables)
        (all_rows(content.rows))
        script { (PreEscaped(SCRIPT)) }
    };
    let figures =
        content.plates.into_iter().map(|p| (format!("{}-{}", content.name, p.name), p.svg)).collect();
    Page { name: content.name, html: page(content.title, body), figures }
}

/// What is written at a figure.
#[derive(Deserialize)]
struct Text {
    title: String,
    /// Label of the x axis; the time where absent.
    #[serde(default = "time")]
    x: String,
    y: String,
    x_range: Option<(f64, f64)>,
    y_range: Option<(f64, f64)>,
    /// Absent where it has computed numbers.
    #[serde(default)]
    caption: String,
}

fn time() -> String {
    "time in s".to_owned()
}

/// The texts of the figures of a page, by name.
struct Texts(BTreeMap<String, Text>);

impl Texts {
    fn read(text: &str) -> Texts {
        Texts(toml::from_str(text).expect("the tests read the texts"))
    }

    fn plate(&self, name: &'static str, draw: impl FnOnce(Figure) -> Figure) -> Plate {
        self.captioned(name, self.0[name].caption.as_str(), draw)
    }

    fn captioned(
        &self,
        name: &'static str,
        caption: impl Into<String>,
        draw: impl FnOnce(Figure) -> Figure,
    ) -> Plate {
        let text = &self.0[name];
        let axis = |label: &str, range: Option<(f64, f64)>| {
            range.iter().fold(Axis::new(label), |axis, range| axis.from_to(range.0, range.1))
        };
        let empty = Figure::new(&text.title, axis(&text.x, text.x_range), axis(&text.y, text.y_range));
        Plate::new(name, draw(empty), caption)
    }
}

/// The table of rows with its filter.
fn all_rows(rows: &[Row]) -> Markup {
    let headers = [
        "id",
        "place",
        "quantity",
        "published",
        "recomputed",
        "corrected",
        "measured",
        "unit",
        "verdict",
        "note",
    ];
    let body = rows.iter().map(|row| {
        let number = |v: Option<f64>| Cell::Number(v.map_or(String::new(), significant));
        // Number and model of it stay in a line.
        let of =
            |value: f64, of: &str| format!("{}\u{a0}({})", significant(value), of.replace('-', "\u{2011}"));
        let corrected = row.corrected.map(|v| row.basis.map_or(significant(v), |basis| of(v, basis.text())));
        let others = [(row.leave_one_out, "leave-one-out"), (row.untuned, "untuned")];
        let others = others.into_iter().filter_map(|(value, name)| Some(of(value?, name)));
        let corrected = Cell::Number(corrected.into_iter().chain(others).collect::<Vec<_>>().join(", "));
        let published = match &row.printed {
            Printed::Number(value) => number(Some(*value)),
            Printed::Text(text) => sentence(text).into(),
        };
        let cells = vec![
            row.id.as_str().into(),
            row.location.as_str().into(),
            row.quantity.as_str().into(),
            published,
            number(row.as_published),
            corrected,
            number(row.measured),
            unit(&row.unit).into(),
            row.verdict.text().into(),
            sentence(&row.note).into(),
        ];
        (row.verdict.text(), cells)
    });
    let counts =
        Verdict::ALL.map(|(v, text)| (text, rows.iter().filter(|r| r.verdict == v).count())).into_iter();
    html! {
        h2 { "Published numbers" }
        p {
            "Published: value in the publication. Recomputed: by the published equations and inputs. Corrected: by the right equations and the \
             inputs that were used; \"fitted\" where a model's parameters were fitted to the published value, \"predicted\" where \
             they were not."
            @if rows.iter().any(|row| row.leave_one_out.or(row.untuned).is_some()) {
                " Leave-one-out: the model fitted to the other tests. Untuned: the model with default start values."
            }
        }
        p { label { "Verdict " select id="verdict" {
            option value="" { "all (" (rows.len()) ")" }
            @for (words, count) in counts.filter(|(_, count)| *count > 0) {
                option value=(words) { (words) " (" (count) ")" }
            }
        } } }
        (labelled_table("rows", &headers, body.collect()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page follows the rules of pages and holds every row.
    #[test]
    fn pages_are_complete_in_themselves() {
        let of_thesis = crate::reproduce::thesis::thesis(crate::reproduce::thesis::Fits::None).unwrap();
        let of_paper = crate::reproduce::paper::paper().unwrap();
        for row in of_thesis.rows.iter().chain(&of_paper.rows) {
            let is_whole = row.printed != Printed::default() && !row.location.is_empty();
            assert!(is_whole && !row.note.contains(['{', '}']), "{row:?}");
            // The quantity is that of the unit.
            for (unit, quantity) in [("rpm", "speed"), ("N.m", "torque"), ("V", "voltage")] {
                assert!(
                    row.unit != unit || row.quantity.contains(quantity) || row.quantity.contains("supply"),
                    "{row:?}"
                );
            }
        }
        for page in [thesis(&of_thesis), paper(&of_paper)] {
            for caption in page.html.split("<figcaption>").skip(1) {
                assert!(!caption.starts_with(char::is_lowercase), "{}: {}", page.name, &caption[..60]);
            }
            assert_eq!(present::check::faults(&page.html), Vec::<String>::new(), "{}", page.name);
            assert!(page.html.matches("<tr data-filter").count() > 35 && !page.figures.is_empty());
            // No column of a table is empty, nor is anything explained that the page has not.
            for table in page.html.split("<table").skip(1).filter_map(|t| t.split("</table>").next()) {
                let headers =
                    table.split("<th").skip(2).filter_map(|th| th.split_once('>')?.1.split('<').next());
                for header in headers {
                    let label = format!("data-label=\"{header}\">");
                    assert!(
                        table.split(&label).skip(1).any(|cell| !cell.starts_with("</td>")),
                        "{}: {header}",
                        page.name
                    );
                }
            }
            assert_eq!(page.html.contains("Untuned"), page.html.contains("(untuned)"), "{}", page.name);
        }
    }
}
