//! The effects of the list, as things that a model may lack.

use crate::hypothesis::{Addition, Number, Shape};
use crate::outcome::Follows;
use crate::setup::Setup;
use physics::declare::Kind;
use physics::model::Slot;
use physics::terms::{Driver, Port};

/// How the size of an effect is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Along a slope at zero.
    Slope,
    /// A step at a time that is tried: size and time.
    Step,
    /// By simulations at a few sizes: the effect brings a store of its own.
    Store,
}

/// An effect of the list.
#[derive(Clone, Copy, Debug)]
pub struct Listed {
    /// Its id.
    pub id: &'static str,
    /// Symbols of its numbers, the size first.
    pub symbols: &'static [&'static str],
    /// Where it acts.
    pub port: Port,
    /// What it follows.
    pub follows: Follows,
    /// Settings that stand still: symbol and item.
    settings: &'static [(&'static str, &'static str)],
    /// How its size is found.
    pub way: Way,
    /// Whether it may act in some runs only: something on the bench, not in the motor.
    pub may_vary: bool,
    /// The most that one that grows with time may have done by the end of the clock: beyond, it is broken and has not drifted.
    most: f64,
}

use Driver::{Current, FanCommand, HousingTemperature, LoadTorque, Speed, Time, WindingTemperature};
use Follows::{History, Nothing};
use Port::{
    AmbientSensor, DragTorque, FanFlow, HeatCapacity, HousingAmbientConductance, HousingSensor,
    TerminalVoltage, TorqueConstant, WindingHeat, WindingHousingResistance, WindingSensor,
};

const fn on(driver: Driver) -> Follows {
    Follows::Driver(driver)
}

const fn listed(id: &'static str, symbols: &'static [&'static str], port: Port, follows: Follows) -> Listed {
    Listed {
        id,
        symbols,
        port,
        follows,
        settings: &[],
        way: Way::Slope,
        may_vary: false,
        most: f64::INFINITY,
    }
}

const fn of_the_bench(listed: Listed) -> Listed {
    Listed { may_vary: true, ..listed }
}

/// Every effect that is looked for by name.
pub const LISTED: &[Listed] = &[
    listed("coulomb_friction", &["tau_c"], DragTorque, on(Speed)),
    listed("iron_loss", &["k"], DragTorque, on(Speed)),
    listed("viscous_friction", &["k"], DragTorque, on(Speed)),
    listed("windage", &["k"], DragTorque, on(Speed)),
    listed("load_dependent_friction", &["mu"], DragTorque, on(LoadTorque)),
    listed("contact_drop", &["V_b"], TerminalVoltage, on(Current)),
    listed("housing_radiation", &["k"], HousingAmbientConductance, on(HousingTemperature)),
    Listed {
        settings: &[("node", "housing"), ("driver", "constant")],
        ..of_the_bench(listed("forced_convection", &["G"], HousingAmbientConductance, Nothing))
    },
    Listed {
        settings: &[("node", "winding"), ("driver", "constant")],
        ..of_the_bench(listed("forced_convection", &["G"], WindingHeat, Nothing))
    },
    Listed {
        settings: &[("node", "winding"), ("driver", "fan_command")],
        ..listed("forced_convection", &["G"], WindingHeat, on(FanCommand))
    },
    listed("fan_back_pressure", &["k"], FanFlow, on(FanCommand)),
    listed("interface_temperature", &["beta"], WindingHousingResistance, on(WindingTemperature)),
    Listed { way: Way::Store, ..listed("stator_node", &["C_s", "R_sh"], HeatCapacity, Nothing) },
    Listed { way: Way::Step, ..listed("demagnetisation", &["fraction", "time"], TorqueConstant, on(Time)) },
    Listed { most: 5.0, ..listed("ambient_drift", &["rate"], AmbientSensor, on(Time)) },
    Listed { way: Way::Store, ..listed("housing_sensor_lag", &["tau"], HousingSensor, History) },
    of_the_bench(listed("winding_sensor_offset", &["offset"], WindingSensor, Nothing)),
    of_the_bench(listed("housing_sensor_offset", &["offset"], HousingSensor, Nothing)),
    of_the_bench(listed("winding_sensor_stem_loss", &["k"], WindingSensor, on(WindingTemperature))),
    of_the_bench(listed("housing_sensor_stem_loss", &["k"], HousingSensor, on(HousingTemperature))),
    of_the_bench(listed("drive_loss", &["share"], WindingHeat, Nothing)),
];

impl Listed {
    /// The effect as an addition of size 0 to a model, acting in `active` runs; `None` where the model has no such effect.
    pub fn addition(&self, setup: &Setup, active: &[bool]) -> Option<Addition> {
        let declaration = setup.bench.declaration();
        let entry = |symbol: &str| declaration.by_name(&format!("effect.{}.{symbol}", self.id));
        let mut slots = Vec::new();
        let mut numbers = Vec::new();
        let clock = setup.drives.iter().flat_map(|d| &d.time).fold(0.0f64, |end, t| end.max(t.abs()));
        let most = self.most / clock;
        for (k, symbol) in self.symbols.iter().enumerate() {
            let found = entry(symbol)?;
            slots.push(found.slot);
            numbers.push(Number {
                symbol: (*symbol).to_string(),
                value: 0.0,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::Experiment;

    /// Every line names an effect of the motor, with the symbols that it has.
    #[test]
    fn the_list_is_that_of_the_motor() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/reference/bench-synthetic/iron-loss");
        let experiment = Experiment::read(&std::path::Path::new(folder).join("experiment.toml")).unwrap();
        let setup = Setup::new(&experiment, &[]).unwrap();
        for listed in LISTED {
            let addition = listed.addition(&setup, &[true]).unwrap_or_else(|| panic!("{}", listed.id));
            let numbers = &addition.numbers;
            assert!(numbers.iter().all(|n| n.scale > 0.0 && n.limits.0 < n.limits.1), "{}", listed.id);
        }
    }
}
