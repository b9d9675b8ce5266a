//! The listed effects as candidates for additions to a model.

use crate::hypothesis::{Addition, Number, Shape};
use crate::setup::Setup;
use physics::declare::Kind;
use physics::effects::{Candidate, Effects};
use physics::model::Slot;
use std::sync::LazyLock;

pub use physics::effects::Way;

/// A candidate form of an effect; the effect itself declares it (`physics/src/effects`).
#[derive(Clone, Copy, Debug)]
pub struct Listed {
    /// Id of the effect.
    pub id: &'static str,
    candidate: Candidate,
}

impl std::ops::Deref for Listed {
    type Target = Candidate;
    fn deref(&self) -> &Candidate {
        &self.candidate
    }
}

/// Every listed effect with a candidate form.
pub static LISTED: LazyLock<Vec<Listed>> = LazyLock::new(|| {
    let of = |(id, candidates): &(&'static str, &'static [Candidate])| {
        let id = *id;
        candidates.iter().map(move |candidate| Listed { id, candidate: *candidate })
    };
    Effects::CANDIDATES.iter().flat_map(of).collect()
});

/// Whether a parameter belongs to an effect, which a search adds and removes.
pub fn is_of_an_effect(parameter: &str) -> bool {
    parameter.starts_with("effect.")
}

/// Whether a parameter shapes an effect and is not its size: with another value it is another effect, and no value in a wrong unit.
pub fn shapes_an_effect(parameter: &str) -> bool {
    let is_size = |l: &Listed| l.symbols.first().is_some_and(|size| l.parameter(size) == parameter);
    is_of_an_effect(parameter) && !LISTED.iter().any(is_size)
}

impl Listed {
    /// Name of one of its parameters in a model.
    pub fn parameter(&self, symbol: &str) -> String {
        format!("effect.{}.{symbol}", self.id)
    }

    /// The forms from which its size is estimated by linearization: with the preset's shape parameters, and with all combinations of values
    /// around them ([`around`]): a shape far from the true one explains little. None if the model does not have the effect.
    ///
    /// *Source*: Box, Wilson, J. R. Stat. Soc. B 13 (1951) 1-45: two-level factorial design with a centre point.
    pub fn forms(&self, setup: &Setup, active: &[bool]) -> Vec<Addition> {
        let Some(centre) = self.addition(setup, active) else { return Vec::new() };
        let mut corners = vec![centre.clone()];
        for k in 1..centre.numbers.len() {
            let [below, above] = around(&centre.numbers[k]);
            let to = |value: f64| {
                move |mut form: Addition| {
                    form.numbers[k].value = value;
                    form
                }
            };
            let upper: Vec<Addition> = corners.iter().cloned().map(to(above)).collect();
            corners = corners.into_iter().map(to(below)).chain(upper).collect();
        }
        if centre.numbers.len() > 1 {
            corners.insert(0, centre);
        }
        corners
    }

    /// The effect as an addition of size 0 to a model, active in the `active` runs; `None` if the model does not have the effect.
    pub fn addition(&self, setup: &Setup, active: &[bool]) -> Option<Addition> {
        let declaration = setup.bench.declaration();
        let entry = |symbol: &str| declaration.by_name(&self.parameter(symbol));
        let mut slots = Vec::new();
        let mut numbers = Vec::new();
        let clock = setup.drives.iter().flat_map(|d| &d.time).fold(0.0f64, |end, t| end.max(t.abs()));
        let most = self.most / clock;
        for (k, symbol) in self.symbols.iter().enumerate() {
            let found = entry(symbol)?;
            slots.push(found.slot);
            numbers.push(Number {
                symbol: (*symbol).to_string(),
                // The size starts at zero; shape parameters start at the preset's values.
                value: if k == 0 { 0.0 } else { setup.bench.start_of(found.slot) },
                limits: (found.row.min.max(-most), found.row.max.min(most)),
                unit: found.row.unit.name(),
                scale: found.row.nominal,
                sloped: self.way != Way::Step || k == 0,
            });
        }
        let mut with: Vec<(Slot, f64)> = Vec::new();
        for (symbol, item) in self.settings {
            let found = entry(symbol)?;
            let Kind::Enumeration(table) = found.row.kind else { return None };
            let item = table.items.iter().find(|i| i.name == *item)?;
            with.push((found.slot, f64::from(item.value)));
        }
        Some(Addition {
            id: self.id.to_string(),
            port: self.port,
            follows: self.follows,
            shape: Shape::Listed { slots, with, stores: self.way == Way::Store },
            numbers,
            active: active.to_vec(),
        })
    }
}

/// Values on both sides of that of a shape parameter: half way to its limits, by ratio; or 0, if that is a limit: without a dependence.
fn around(number: &Number) -> [f64; 2] {
    let (least, most) = number.limits;
    [least, most].map(|limit| (number.value * limit).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;
    use crate::testing;

    #[test]
    fn a_width_is_a_shape_and_a_torque_is_a_size() {
        for (name, is_shape) in [
            ("effect.coulomb_friction.tau_c", false),
            ("effect.coulomb_friction.w_small", true),
            ("effect.iron_loss.k", false),
            ("effect.iron_loss.w_small", true),
            ("motor.R_ref", false),
        ] {
            assert_eq!(shapes_an_effect(name), is_shape, "{name}");
        }
    }

    #[test]
    fn forms_are_around_the_preset() {
        let experiment = testing::experiment(testing::PRIORS, true);
        let setup = Setup::new(&experiment, &[]).unwrap();
        let of = |id: &str| -> Vec<Vec<f64>> {
            let listed = LISTED.iter().find(|l| l.id == id).unwrap();
            let shape = |form: Addition| form.numbers[1..].iter().map(|n| n.value).collect();
            listed.forms(&setup, &[true]).into_iter().map(shape).collect()
        };
        assert_eq!(of("windage"), [vec![0.0; 0]]);
        let friction = of("lubricant_friction");
        assert_eq!((friction.len(), &friction[0]), (5, &vec![0.667, 0.025]));
        // Without a dependence on the speed, and halfway to the limits by ratio.
        assert_eq!(friction[1], [0.0, (0.025 * 0.005f64).sqrt()]);
        assert_eq!(friction[4], [0.667f64.sqrt(), (0.025 * 0.2f64).sqrt()]);
        let n = |k: usize| of("speed_convection")[k][0];
        assert!(n(1) < n(0) && n(0) < n(2));
    }

    /// Each effect of the motor with a candidate form is found, with the symbols that the candidate names.
    #[test]
    fn the_list_is_that_of_the_motor() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/bench-synthetic/iron-loss");
        let experiment = Experiment::read(&std::path::Path::new(folder).join("experiment.toml")).unwrap();
        let setup = Setup::new(&experiment, &[]).unwrap();
        for listed in LISTED.iter() {
            let addition = listed.addition(&setup, &[true]).unwrap_or_else(|| panic!("{}", listed.id));
            let numbers = &addition.numbers;
            assert!(numbers.iter().all(|n| n.scale > 0.0 && n.limits.0 < n.limits.1), "{}", listed.id);
        }
    }
}
