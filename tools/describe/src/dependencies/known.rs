//! The structure of each model by itself, as it is kept in `model-description/<Model>/dependencies.toml`.

use super::{Dependencies, Unknown};
use crate::preset::StartValues;
use physics::declare::Causality;
use physics::model::{Declaration, Entry, Slot};
use std::fmt::Write;
use toml::{Table, Value};

/// The file of each model; `cargo xtask describe` writes it.
macro_rules! kept {
    ($($model:literal),*) => {
        [$(($model, include_str!(concat!("../../../../model-description/", $model, "/dependencies.toml")))),*]
    };
}

const KEPT: [(&str, &str); 4] =
    kept!["AnnulusCooledMotor", "BrushedGearmotor", "GaitLoad", "SeriesElasticActuator"];

/// The clock among the names of variables.
const TIME: &str = "time";

impl Dependencies {
    /// The structure as it is kept, of what there is with these start values; `None` where there is none for this model
    /// or not of its present variables.
    pub(super) fn known(declaration: &Declaration, starts: &StartValues) -> Option<Dependencies> {
        let (_, text) = KEPT.iter().find(|(model, _)| *model == declaration.name)?;
        Dependencies::parse(text, declaration, starts)
    }

    /// The text of the file in which the structure is kept.
    pub fn text(&self, declaration: &Declaration) -> String {
        let name = |k: usize| declaration.entries[k].name.as_str();
        let mut text = "# Which variable depends on which, in any combination of the choices: \
                        written by `cargo xtask describe`.\n"
            .to_string();
        for (list, unknowns) in self.lists() {
            let _ = write!(text, "\n[{list}]\n");
            for unknown in unknowns {
                let on =
                    unknown.on_time.then_some(TIME).into_iter().chain(unknown.on.iter().map(|&k| name(k)));
                let on: Vec<String> = on.map(|known| format!("{known:?}")).collect();
                let _ = writeln!(text, "{:?} = [{}]", name(unknown.entry), on.join(", "));
            }
        }
        text
    }

    fn lists(&self) -> [(&'static str, &[Unknown]); 4] {
        [
            ("outputs", &self.outputs),
            ("rates", &self.rates),
            ("indicators", &self.indicators),
            ("initial", &self.initial),
        ]
    }

    fn parse(text: &str, declaration: &Declaration, starts: &StartValues) -> Option<Dependencies> {
        let kept: Table = text.parse().ok()?;
        let place = |name: &str| declaration.entries.iter().position(|e| e.name == name);
        let shown = |k: usize| starts.shows(declaration, &declaration.entries[k]);
        let unknown = |list: &str, entry: usize| -> Option<Unknown> {
            let mut unknown = Unknown { entry, on: Vec::new(), on_time: false };
            // An element beyond those that are kept is looked at where its count is not the usual one.
            let names = kept.get(list)?.get(&declaration.entries[entry].name).and_then(Value::as_array);
            for name in names.into_iter().flatten() {
                match name.as_str()? {
                    TIME => unknown.on_time = true,
                    name => unknown.on.extend(Some(place(name)?).filter(|k| shown(*k))),
                }
            }
            Some(unknown)
        };
        let all = |list: &str, which: &dyn Fn(&Entry) -> bool| -> Option<Vec<Unknown>> {
            let entries =
                (0..declaration.entries.len()).filter(|k| which(&declaration.entries[*k]) && shown(*k));
            entries.map(|k| unknown(list, k)).collect()
        };
        let is_output = |e: &Entry| e.row.causality == Causality::Output;
        let is_rate = |e: &Entry| e.slot.group == Slot::RATES;
        Some(Dependencies {
            outputs: all("outputs", &is_output)?,
            rates: all("rates", &is_rate)?,
            indicators: (declaration.indicators.iter().map(|k| unknown("indicators", *k)))
                .collect::<Option<_>>()?,
            initial: all("initial", &|e| is_output(e) || is_rate(e) || e.slot.group == Slot::STATES)?,
        })
    }
}
