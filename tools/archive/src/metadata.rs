//! Metadata of an archive for data management: what its values are made of, where it is valid, and how large its errors are.
//!
//! *Format*: SRMD (Simulation Resource Meta Data) of the SSP Traceability specification, a layered standard of SSP, whose section on packaging
//! gives the place in an FMU. The keywords of a classification are those of its author; these begin with `motor-fmu`.

use crate::native::Native;
use describe::xml::{self, element};
use describe::{Entry, Kind, Preset};

/// The file in the archive.
pub const FILE: &str = "extra/org.ssp-standard.ssp-traceability.srmd/resourceMetaData.srmd";
/// Version of the format.
const VERSION: &str = "1.0.0";
const NAMESPACES: [(&str, &str); 2] = [
    ("xmlns:srmd", "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"),
    ("xmlns:stc", "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"),
];

/// Keywords with their values.
struct Classification {
    kind: &'static str,
    /// Keyword and value.
    entries: Vec<(String, String)>,
}

impl Classification {
    fn new(kind: &'static str, entries: Vec<(String, String)>) -> Classification {
        Classification { kind, entries }
    }
}

/// What an archive was made of.
#[derive(Clone, Copy, Debug, Default)]
pub struct MadeOf<'a> {
    /// Start values.
    pub preset: Option<&'a Preset>,
    /// Number of terms that are data.
    pub terms: Option<usize>,
    /// File and columns of the load table.
    pub load: Option<&'a str>,
}

/// The document.
pub fn document(native: &Native<'_>, made_of: MadeOf<'_>) -> String {
    let declaration = (native.kind.declaration)();
    let all = [
        Classification::new("motor-fmu.model", model(native, made_of)),
        Classification::new("motor-fmu.start-values", start_values(native, made_of)),
        Classification::new("motor-fmu.validity", limits(native)),
        Classification::new(
            "motor-fmu.calibration",
            made_of.preset.map(Preset::calibration).unwrap_or_default(),
        ),
    ];
    let mut root: xml::Attributes = NAMESPACES.map(|(name, value)| (name, value.to_owned())).to_vec();
    root.extend([
        ("version", VERSION.to_owned()),
        ("name", declaration.name.to_owned()),
        ("description", declaration.description.to_owned()),
        ("author", describe::AUTHOR.to_owned()),
        ("license", describe::LICENSE.to_owned()),
        ("generationTool", describe::TOOL.to_owned()),
    ]);
    xml::document("srmd:SimulationResourceMetaData", &root, |xml| {
        all.iter().filter(|one| !one.entries.is_empty()).try_for_each(|one| {
            element(xml, "stc:Classification", &vec![("type", one.kind.to_owned())], |xml| {
                one.entries.iter().try_for_each(|(keyword, value)| {
                    xml::text(xml, "stc:ClassificationEntry", &vec![("keyword", keyword.clone())], value)
                })
            })
        })
    })
}

fn model(native: &Native<'_>, made_of: MadeOf<'_>) -> Vec<(String, String)> {
    let declaration = (native.kind.declaration)();
    let token = describe::token(declaration, native.starts, native.resources);
    let mut entries = vec![("model", declaration.name.to_owned()), ("token", token.to_string())];
    match made_of.preset {
        Some(preset) => entries
            .extend([("preset", preset.name.clone()), ("preset description", preset.description.clone())]),
        None => entries.push(("preset", "none: default start values".to_owned())),
    }
    entries.extend(made_of.terms.map(|terms| ("terms from data", terms.to_string())));
    entries.extend(made_of.load.map(|source| ("load table", source.to_owned())));
    entries.into_iter().map(|(keyword, value)| (keyword.to_owned(), value)).collect()
}

/// The values that differ from the declared ones, each with its source.
fn start_values(native: &Native<'_>, made_of: MadeOf<'_>) -> Vec<(String, String)> {
    let entries = (native.kind.declaration)().entries.iter();
    let given = entries.filter(|entry| native.starts.names(entry));
    let entry = |entry: &Entry| {
        let source = made_of.preset.and_then(|preset| preset.source_of(&entry.name));
        let source = source.map(|source| format!("; {source}")).unwrap_or_default();
        (entry.name.clone(), value(native, entry) + &source)
    };
    given.map(entry).collect()
}

/// The limits of the range in which the equations hold, and the rated one.
fn limits(native: &Native<'_>) -> Vec<(String, String)> {
    let entries = (native.kind.declaration)().entries.iter();
    let own = entries.filter(|entry| entry.is_limit_of_validity() || entry.name == "thermal.T_w_max");
    own.map(|entry| (entry.name.clone(), format!("{}; {}", value(native, entry), entry.row.doc.trim())))
        .collect()
}

/// A start value with its unit, of an enumeration its item.
fn value(native: &Native<'_>, entry: &Entry) -> String {
    let number = native.starts.of(entry);
    match (entry.row.kind, entry.row.unit.name()) {
        (Kind::Enumeration(t), _) => {
            let item = t.items.iter().find(|item| f64::from(item.value) == number);
            item.map_or_else(|| number.to_string(), |item| item.name.to_owned())
        }
        (_, "1") => number.to_string(),
        (_, unit) => format!("{number} {unit}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use describe::{Resources, StartValues, models};

    /// The entries of a document by classification and keyword.
    fn entries(text: &str) -> Vec<(String, String, String)> {
        let document = roxmltree::Document::parse(text).unwrap();
        let common = NAMESPACES[1].1;
        let of = |node: roxmltree::Node| {
            let kind = node.parent().and_then(|p| p.attribute("type")).unwrap_or_default();
            let keyword = node.attribute("keyword").unwrap_or_default();
            (kind.to_owned(), keyword.to_owned(), node.text().unwrap_or_default().to_owned())
        };
        document.descendants().filter(|n| n.has_tag_name((common, "ClassificationEntry"))).map(of).collect()
    }

    #[test]
    fn a_document_has_preset_sources_limits_and_calibration() {
        let mut preset = Preset::load("maxon-re40-148877").unwrap();
        preset.file += "\n#: a & b: < 0.1 K: all\n# no: calibration\n";
        let made_of = MadeOf { preset: Some(&preset), ..MadeOf::default() };
        let kind = models::by_name(&preset.model).unwrap();
        let native = Native { kind, starts: &preset.starts, resources: &Resources::default() };
        let found = entries(&document(&native, made_of));
        let get = |kind: &str, keyword: &str| {
            let one = found.iter().find(|(k, w, _)| k == kind && w == keyword);
            one.map(|(_, _, value)| value.as_str()).unwrap_or_else(|| panic!("{kind} {keyword}: {found:?}"))
        };
        assert_eq!(get("motor-fmu.model", "preset"), "maxon-re40-148877");
        assert_eq!(get("motor-fmu.calibration", "a & b"), "< 0.1 K: all");
        // Value, unit and source of the datasheet.
        let resistance = get("motor-fmu.start-values", "motor.R_ref");
        assert!(resistance.contains(" Ohm; ") && resistance.len() > 12, "{resistance}");
        assert!(get("motor-fmu.validity", "validity.winding_temperature").starts_with("543.15 K; "));
        let starts = preset.starts.entries().len();
        assert_eq!(found.iter().filter(|(kind, ..)| kind == "motor-fmu.start-values").count(), starts);
    }

    #[test]
    fn every_model_has_one() {
        for kind in models::ALL {
            let (starts, resources) = (StartValues::default(), Resources::default());
            let native = Native { kind, starts: &starts, resources: &resources };
            let found = entries(&document(&native, MadeOf::default()));
            assert!(found.iter().any(|(_, keyword, _)| keyword == "token"));
        }
    }
}
