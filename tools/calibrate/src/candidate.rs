//! What a model may lack: the effects of its list, and terms at a port that follow a driver.

use physics::declare::Kind;
use physics::model::{Declaration, Slot};
use physics::terms::{Driver, Factor, GenericTerm, Law, Port, Product};

/// How a number changes a model.
#[derive(Clone, Debug)]
pub enum How {
    /// It is the value of a parameter, beside others that stand still.
    Parameter {
        /// The parameter.
        slot: Slot,
        /// What stands still.
        with: Vec<(Slot, f64)>,
    },
    /// It is the coefficient of a term.
    Term(Box<GenericTerm>),
}

/// A change of a model.
#[derive(Clone, Debug, Default)]
pub struct Change {
    /// Values of parameters.
    pub values: Vec<(Slot, f64)>,
    /// Terms.
    pub terms: Vec<GenericTerm>,
}

impl How {
    /// Adds itself with its number to a change.
    pub fn apply(&self, number: f64, change: &mut Change) {
        match self {
            How::Parameter { slot, with } => {
                change.values.extend(with);
                change.values.push((*slot, number));
            }
            How::Term(term) => {
                let mut term = **term;
                if let Law::Product(product) = &mut term.law {
                    product.coefficient = number;
                }
                change.terms.push(term);
            }
        }
    }
}

/// Something that the model may lack.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Id of the effect; of a term, port, driver and exponent.
    pub name: String,
    /// Where it acts.
    pub port: Port,
    /// What it depends on; none where it is constant.
    pub driver: Option<Driver>,
    /// Whether it stands in the list of effects.
    pub listed: bool,
    /// How its size changes the model.
    pub how: How,
    /// A size that a bench would see.
    pub size: f64,
    /// What its size may be.
    pub limits: (f64, f64),
}

/// An effect of the list: id, symbol of its size, port, driver, and the settings that stand still.
type Listed = (&'static str, &'static str, Port, Option<Driver>, &'static [(&'static str, &'static str)]);

use Driver::{Current, FanCommand, HousingTemperature, LoadTorque, Speed, Time, WindingTemperature};
use Port::{
    AmbientSensor, DragTorque, FanFlow, HousingAmbientConductance, HousingSensor, TerminalVoltage,
    TorqueConstant, WindingHeat, WindingHousingResistance, WindingSensor,
};

const LISTED: &[Listed] = &[
    ("iron_loss", "k", DragTorque, Some(Speed), &[]),
    ("viscous_friction", "k", DragTorque, Some(Speed), &[]),
    ("windage", "k", DragTorque, Some(Speed), &[]),
    ("load_dependent_friction", "mu", DragTorque, Some(LoadTorque), &[]),
    ("contact_drop", "V_b", TerminalVoltage, Some(Current), &[]),
    ("housing_radiation", "k", HousingAmbientConductance, Some(HousingTemperature), &[]),
    (
        "forced_convection",
        "G",
        HousingAmbientConductance,
        None,
        &[("node", "housing"), ("driver", "constant")],
    ),
    ("forced_convection", "G", WindingHeat, None, &[("node", "winding"), ("driver", "constant")]),
    (
        "forced_convection",
        "G",
        WindingHeat,
        Some(FanCommand),
        &[("node", "winding"), ("driver", "fan_command")],
    ),
    ("fan_back_pressure", "k", FanFlow, Some(FanCommand), &[]),
    ("interface_temperature", "beta", WindingHousingResistance, Some(WindingTemperature), &[]),
    ("ambient_drift", "rate", AmbientSensor, Some(Time), &[]),
    ("winding_sensor_offset", "offset", WindingSensor, None, &[]),
    ("housing_sensor_offset", "offset", HousingSensor, None, &[]),
    ("winding_sensor_stem_loss", "k", WindingSensor, Some(WindingTemperature), &[]),
    ("housing_sensor_stem_loss", "k", HousingSensor, Some(HousingTemperature), &[]),
    ("housing_sensor_lag", "tau", HousingSensor, Some(Time), &[]),
];

/// Terms to try: port, driver, exponents, the driver's usual size and zero.
const TERMS: &[(Port, Driver, &[f64], f64, f64)] = &[
    (DragTorque, Speed, &[0.25, 0.75, 1.25, 1.5, 3.0], 500.0, 0.0),
    (DragTorque, WindingTemperature, &[1.0], 50.0, 298.15),
    (TerminalVoltage, Current, &[0.5, 2.0], 5.0, 0.0),
    (TerminalVoltage, Speed, &[1.0, 2.0], 500.0, 0.0),
    (Port::WindingResistance, Current, &[1.0, 2.0], 5.0, 0.0),
    (Port::WindingResistance, Speed, &[1.0, 2.0], 500.0, 0.0),
    (TorqueConstant, Current, &[1.0, 2.0], 5.0, 0.0),
    (TorqueConstant, HousingTemperature, &[1.0, 2.0], 50.0, 298.15),
    (WindingHeat, Speed, &[1.0, 1.5, 2.0], 500.0, 0.0),
    (Port::HousingHeat, FanCommand, &[1.0], 1.0, 0.0),
    (WindingHousingResistance, HousingTemperature, &[1.0], 50.0, 298.15),
    (HousingAmbientConductance, HousingTemperature, &[0.25, 0.5, 1.0], 50.0, 298.15),
    (HousingAmbientConductance, Speed, &[0.5, 0.8, 1.0], 500.0, 0.0),
    (HousingAmbientConductance, FanCommand, &[0.5, 1.0, 2.0], 1.0, 0.0),
    (HousingAmbientConductance, Driver::AmbientTemperature, &[1.0], 10.0, 293.15),
];

/// Everything that a model may lack, listed effects first.
pub fn all(declaration: &Declaration) -> Vec<Candidate> {
    let listed = LISTED.iter().filter_map(|(id, symbol, port, driver, settings)| {
        let entry = declaration.by_name(&format!("effect.{id}.{symbol}"))?;
        let setting = |(name, item): &(&str, &str)| {
            let entry = declaration.by_name(&format!("effect.{id}.{name}"))?;
            let Kind::Enumeration(table) = entry.row.kind else { return None };
            let item = table.items.iter().find(|i| i.name == *item)?;
            Some((entry.slot, f64::from(item.value)))
        };
        Some(Candidate {
            name: (*id).to_string(),
            port: *port,
            driver: *driver,
            listed: true,
            how: How::Parameter { slot: entry.slot, with: settings.iter().filter_map(setting).collect() },
            size: entry.row.nominal,
            limits: (entry.row.min, entry.row.max),
        })
    });
    let terms = TERMS.iter().flat_map(|(port, driver, exponents, reference, offset)| {
        exponents.iter().map(|exponent| {
            let factor =
                Factor { driver: *driver, offset: *offset, reference: *reference, exponent: *exponent };
            let law = Law::Product(Product { coefficient: 0.0, factors: [Some(factor), None, None] });
            Candidate {
                name: format!("{} ~ {}^{exponent}", port.name(), driver.name()),
                port: *port,
                driver: Some(*driver),
                listed: false,
                how: How::Term(Box::new(GenericTerm { port: *port, law })),
                size: match port {
                    DragTorque => 1e-3,
                    _ => 0.05,
                },
                limits: (f64::NEG_INFINITY, f64::INFINITY),
            }
        })
    });
    listed.chain(terms).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every line names an effect of the motor; nothing is lost on the way.
    #[test]
    fn the_list_is_that_of_the_motor() {
        let declaration = (physics::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
        let found = all(declaration);
        assert_eq!(found.iter().filter(|c| c.listed).count(), LISTED.len());
        for candidate in found.iter().filter(|c| c.listed) {
            let How::Parameter { with, .. } = &candidate.how else { panic!("{}", candidate.name) };
            assert_eq!(with.is_empty(), candidate.name != "forced_convection");
        }
        assert!(found.iter().all(|c| c.size > 0.0));
    }
}
