//! The models, one folder each.

pub mod annulus_cooled_motor;
pub mod brushed_gearmotor;
pub mod gait_load;
pub mod series_elastic_actuator;

use crate::model::ModelType;
use crate::token::Token;
use annulus_cooled_motor::AnnulusCooledMotor;
use brushed_gearmotor::BrushedGearmotor;
use gait_load::GaitLoad;
use series_elastic_actuator::SeriesElasticActuator;

/// All models of the project. A static: a constant would compile all of physics again in each crate that mentions it.
pub static ALL: &[ModelType] =
    &[AnnulusCooledMotor::TYPE, BrushedGearmotor::TYPE, SeriesElasticActuator::TYPE, GaitLoad::TYPE];

/// The model of this name.
pub fn by_name(name: &str) -> Option<&'static ModelType> {
    ALL.iter().find(|m| (m.declaration)().name == name)
}

/// The model of the archive with this FMI 2 GUID or FMI 3 instantiation token, whatever its start values, terms and load table.
pub fn by_token(token: &str) -> Option<&'static ModelType> {
    let token = Token::parse(token)?;
    ALL.iter().find(|m| (m.declaration)().token.is_model(token))
}
