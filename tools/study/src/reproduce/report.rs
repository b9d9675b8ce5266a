//! The pages: one file each, complete in itself, for light and dark.

mod paper;
mod thesis;

pub use paper::paper;
pub use thesis::thesis;

use super::{Printed, Row, Verdict, significant};
use crate::figure::escaped;
use crate::page::{Plate, begun, plates, table};
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

const SCRIPT: &str = "
const choice=document.getElementById('verdict');
choice.onchange=()=>{for(const r of document.querySelectorAll('#rows tbody tr'))\
r.hidden=choice.value!==''&&r.dataset.verdict!==choice.value};
";

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
    let mut html = begun(content.title);
    let _ = write!(html, "<p>{}</p>", escaped(content.conclusion));
    if let Some(reason) = content.absent {
        let _ = write!(html, "<p class=\"soft\">Without the native model: {}.</p>", escaped(reason));
    }
    let mut figures = Vec::new();
    html.push_str("<h2>Figures</h2>");
    html.push_str(&plates(&content.plates));
    for plate in content.plates {
        figures.push((format!("{}-{}", content.name, plate.name), plate.svg));
    }
    html.push_str(&content.tables);
    html.push_str(&all_rows(content.rows));
    let _ = write!(html, "<script>{SCRIPT}</script></body></html>");
    Page { name: content.name, html, figures }
}

/// The table of rows with its filter.
fn all_rows(rows: &[Row]) -> String {
    let mut html = String::from(
        "<h2>Every published number</h2><p><label>Verdict <select id=\"verdict\"><option value=\"\">all",
    );
    let _ = write!(html, " ({})</option>", rows.len());
    for verdict in Verdict::ALL {
        let count = rows.iter().filter(|r| r.verdict == verdict).count();
        if count > 0 {
            let words = verdict.text();
            let _ = write!(html, "<option value=\"{words}\">{words} ({count})</option>");
        }
    }
    html.push_str("</select></label></p><div class=\"wide\">");
    let headers = [
        "id",
        "where",
        "quantity",
        "#published",
        "#recomputed",
        "#corrected",
        "#leave-one-out",
        "#untuned",
        "#measured",
        "unit",
        "verdict",
        "why",
    ];
    let body = rows.iter().map(|row| {
        let number = |v: Option<f64>| format!("#{}", v.map_or(String::new(), significant));
        let basis = |row: &Row| {
            let basis = row.basis.map_or(String::new(), |basis| format!(" ({})", basis.text()));
            format!("#{}{basis}", row.corrected.map_or(String::new(), significant))
        };
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
            basis(row),
            number(row.leave_one_out),
            number(row.untuned),
            number(row.measured),
            row.unit.to_owned(),
            row.verdict.text().to_owned(),
            row.note.clone(),
        ];
        (row.verdict.text(), cells)
    });
    html.push_str(&table("rows", &headers, body));
    html.push_str("</div>");
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
