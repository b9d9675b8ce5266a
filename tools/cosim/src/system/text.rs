//! A system in TOML.
use super::structure::{self, Component, Connection, End, Leg, Place, Setting, Shared, Structure};
use super::units::Affine;
use crate::Error;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::{Spanned, Value};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    system: Head,
    #[serde(default)]
    experiment: Experiment,
    #[serde(default)]
    component: Vec<Entry>,
    #[serde(default)]
    parameter: Vec<Parameter>,
}

/// One value for variables of several components.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Parameter {
    name: Spanned<String>,
    value: Value,
    set: Vec<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    name: Spanned<String>,
    #[serde(default)]
    connect: Vec<Spanned<String>>,
    /// Values for the system's own inputs.
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Experiment {
    start: Option<Spanned<Time>>,
    stop: Option<Spanned<Time>>,
    step: Option<Spanned<Time>>,
}

/// A time in s, or a text with its unit.
#[derive(Deserialize)]
#[serde(try_from = "Value")]
struct Time(f64);

impl TryFrom<Value> for Time {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::Integer(number) => Ok(Self(number as f64)),
            Value::Float(number) => Ok(Self(number)),
            Value::String(text) => {
                units::number(&text, "s").map(Self).map_err(|why| format!("{text:?}: {why}"))
            }
            other => Err(format!("{other} is not a time: expected a number in s or a text with a unit")),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Spanned<String>,
    fmu: String,
    step: Option<Spanned<Time>>,
    #[serde(default)]
    set: BTreeMap<Spanned<String>, Value>,
}

/// Turns places in the text into lines.
struct Lines<'a> {
    file: Arc<str>,
    text: &'a str,
}

impl Lines<'_> {
    fn place(&self, offset: usize) -> Place {
        let before = &self.text.as_bytes()[..offset.min(self.text.len())];
        Place { file: self.file.clone(), line: 1 + before.iter().filter(|b| **b == b'\n').count() as u32 }
    }

    fn time(&self, time: Option<Spanned<Time>>) -> Option<structure::Time> {
        time.map(|time| structure::Time { place: self.of(&time), seconds: time.into_inner().0 })
    }

    fn of<T>(&self, item: &Spanned<T>) -> Place {
        self.place(item.span().start)
    }

    /// A value as text.
    fn text(place: &Place, name: &str, value: Value) -> Result<String, Error> {
        match value {
            Value::String(text) => Ok(text),
            Value::Integer(number) => Ok(number.to_string()),
            Value::Float(number) => Ok(number.to_string()),
            Value::Boolean(flag) => Ok(flag.to_string()),
            _ => Err(place.fault(format!("{name} is not a number, text or Boolean"))),
        }
    }

    /// The parameters of the system, and the settings that they are.
    fn parameters(&self, parameters: Vec<Parameter>) -> Result<(Vec<Shared>, Vec<Setting>), Error> {
        let (mut shared, mut settings) = (Vec::<Shared>::new(), Vec::new());
        for Parameter { name, value, set } in parameters {
            let place = self.of(&name);
            let name = name.into_inner();
            if shared.iter().any(|known| known.name == name) {
                return Err(place.fault(format!("there are two parameters {name}")));
            }
            if set.is_empty() {
                return Err(
                    place.fault(format!("parameter {name}: the list `set` names no component.variable"))
                );
            }
            let text = Self::text(&place, &name, value)?;
            settings.extend(set.iter().map(|target| Setting {
                name: target.get_ref().clone(),
                text: text.clone(),
                unit: None,
                linear: Affine::IDENTITY,
                place: self.of(target),
            }));
            let targets = set.into_iter().map(|target| (target.into_inner(), Affine::IDENTITY)).collect();
            shared.push(Shared { name, text, unit: None, targets });
        }
        Ok((shared, settings))
    }

    fn settings(&self, table: BTreeMap<Spanned<String>, Value>) -> Result<Vec<Setting>, Error> {
        let mut settings: Vec<Setting> = Vec::new();
        for (name, value) in table {
            let place = self.of(&name);
            let text = Self::text(&place, name.get_ref(), value)?;
            settings.push(Setting {
                name: name.into_inner(),
                text,
                unit: None,
                linear: Affine::IDENTITY,
                place,
            });
        }
        settings.sort_by_key(|s| s.place.line);
        Ok(settings)
    }
}

/// Reads a system from TOML; FMUs are named relative to the file.
pub(crate) fn read(path: &Path) -> Result<Structure, Error> {
    let text = delimited::read_text(path).map_err(Error::io("read", path))?;
    parse(&text, &path.display().to_string(), delimited::folder(path))
}

fn parse(text: &str, file: &str, folder: &Path) -> Result<Structure, Error> {
    let lines = Lines { file: file.into(), text };
    let document: Document = toml::from_str(text).map_err(|e| {
        lines.place(e.span().map_or(0, |s| s.start)).fault(e.message().trim_end().replace('\n', ", "))
    })?;
    let mut components = Vec::new();
    for entry in document.component {
        let place = lines.of(&entry.name);
        components.push(Component {
            name: entry.name.into_inner(),
            step: lines.time(entry.step),
            path: folder.join(&entry.fmu),
            source: entry.fmu,
            connectors: None,
            settings: lines.settings(entry.set)?,
            place,
        });
    }
    // A name with a dot is ambiguous with component.variable.
    if let Some(bad) = components.iter().find(|c| c.name.is_empty() || c.name.contains('.')) {
        return Err(bad.place.fault(format!("component {:?}: a name is not empty and has no dot", bad.name)));
    }
    let mut connections = Vec::new();
    for text in document.system.connect {
        let place = lines.of(&text);
        let ends: Vec<&str> = text.get_ref().split("->").map(str::trim).collect();
        let [start, end] = ends[..] else {
            let form = "\"component.output -> component.input\"";
            return Err(place.fault(format!("{:?} is not a connection; expected: {form}", text.get_ref())));
        };
        connections.push(Connection {
            start: self::end(start),
            end: self::end(end),
            legs: vec![Leg::PLAIN],
            place,
        });
    }
    let (shared, mut settings) = lines.parameters(document.parameter)?;
    settings.extend(lines.settings(document.system.set)?);
    Ok(Structure {
        name: document.system.name.into_inner(),
        start: lines.time(document.experiment.start),
        stop: lines.time(document.experiment.stop),
        step: lines.time(document.experiment.step),
        components,
        connectors: None,
        settings,
        shared,
        connections,
        files: None,
    })
}

/// `component.variable`, where the variable may have dots; without a dot it is a connector of the system.
fn end(text: &str) -> End {
    match text.split_once('.') {
        Some((component, connector)) => {
            End { component: Some(component.to_owned()), connector: connector.to_owned() }
        }
        None => End { component: None, connector: text.to_owned() },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_arrives_with_its_line() {
        let text = r#"
[system]
name = "pair"
connect = [
  "a.y -> b.port.u",
  "b.y -> result",
]
[system.set]
room = 300.0
[experiment]
stop = 2.5
[[component]]
name = "a"
fmu = "fmus/a.fmu"
[component.set]
mode = "fast"
n = 3
"quoted.name" = 0.5
on = true
[[component]]
name = "b"
fmu = "b.fmu"
[[parameter]]
name = "level"
value = 2
set = ["a.k", "b.port.k"]
"#;
        let s = parse(text, "s.toml", Path::new("dir")).unwrap();
        let stop = structure::Time { seconds: 2.5, place: Place { file: "s.toml".into(), line: 11 } };
        assert_eq!((s.name.as_str(), s.start, s.stop, s.step), ("pair", None, Some(stop), None));
        assert_eq!(s.components[0].path, Path::new("dir/fmus/a.fmu"));
        let settings: Vec<_> =
            s.components[0].settings.iter().map(|s| (&*s.name, &*s.text, s.place.line)).collect();
        let expected = [("mode", "fast", 16), ("n", "3", 17), ("quoted.name", "0.5", 18), ("on", "true", 19)];
        assert_eq!(settings, expected);
        let settings: Vec<_> = s.settings.iter().map(|s| (&*s.name, &*s.text, s.place.line)).collect();
        assert_eq!(settings, [("a.k", "2", 26), ("b.port.k", "2", 26), ("room", "300", 9)]);
        assert_eq!((s.shared[0].name.as_str(), s.shared[0].targets.len()), ("level", 2));
        assert_eq!(s.connections[0].to_string(), "connection a.y -> b.port.u");
        assert_eq!((s.connections[0].end.connector.as_str(), s.connections[0].place.line), ("port.u", 5));
        assert_eq!(s.connections[1].end, End { component: None, connector: "result".to_owned() });
    }

    #[test]
    fn faults_name_file_and_line() {
        for [text, expected] in crate::tests::faults("system") {
            assert_eq!(parse(&text, "s.toml", Path::new("")).unwrap_err().to_string(), expected);
        }
    }
}
