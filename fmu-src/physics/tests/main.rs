//! All integration tests of the models, in one program: physics is linked once.

mod common;
#[path = "common/gearmotor.rs"]
mod gearmotor;
#[path = "common/walker.rs"]
mod walker;

mod accuracy;
mod actuator_and_gait;
mod brushed_gearmotor;
mod cooling_values;
mod effects;
mod energy_balance;
mod fan_at_rest;
mod frozen_jacobian;
mod gear_node;
mod hot_spot;
mod initial;
mod limits;
mod network;
mod reading;
mod rig_effects;
mod sensors;
mod served;
mod short_cuts;
mod states;
mod terms;
mod validity;
mod water_jacket;
mod zero_duty;
