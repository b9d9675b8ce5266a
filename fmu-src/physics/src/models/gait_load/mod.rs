//! Joint of a walking person as a load: angle, speed and demanded torque over the stride, from measured gait data.
//!
//! `components/gait.rs` has the equations and their data; this file declares inputs, outputs and states.

mod variables;

pub use variables::{Indicators, Inputs, LIST, Outputs};

use crate::components::gait::{Activity, Cycle, Gait, Motion, NO_TABLE, floor};
use crate::explicit::{Explicit, Law, Line, Now};
use crate::groups;
use crate::load_table::LoadTable;
use crate::model::{Declaration, Declared, Fault};
use crate::runtime::{NoVariables, Runtime};
use crate::solver::explicit::Tried;
use declare::State;
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of states.
pub const STATES: usize = LIST.len();
/// The load as a model.
pub type GaitLoad = Runtime<Explicit<Walker, STATES, 0>, STATES>;
/// Inputs and states at one instant.
pub type At<'a> = Now<'a, Inputs, STATES, 0>;

/// Indices of the stride coordinate and of the demanded energy among the states.
const STRIDE: usize = 0;
const ENERGY: usize = 1;

groups! {
    /// The walking person.
    #[derive(Clone, Debug, Default, PartialEq)]
    pub struct Walker {
        /// Body, activity, joint.
        gait: Gait = "gait." @ 100,
    } and {
        /// Cycle of the activity `table`, if set.
        table: Option<Arc<Cycle>>
    }
}

impl Law<STATES, 0> for Walker {
    type Inputs = Inputs;
    type Outputs = Outputs;
    type Balance = NoVariables;
    type Indicators = Indicators;
    type Point = Motion;
    const LIST: &'static [State] = LIST;

    fn declaration() -> &'static Declaration {
        static DECLARED: Declared = Declared::new();
        DECLARED.get_or_init(|| {
            GaitLoad::declare(
                "GaitLoad",
                "Joint of a person who walks or climbs stairs: angle, speed and torque over the stride from measured \
                 gait of adults or children or from a load table, with variation between strides, start and stop",
                &[],
            )
        })
    }

    fn start(&self, _time: f64, _inputs: &Inputs) -> Result<([f64; STATES], [f64; 0]), Fault> {
        let gait = &self.gait;
        if gait.activity == Activity::Table && self.table.is_none() {
            return Err(Fault(NO_TABLE.to_owned()));
        }
        if gait.stop_time < gait.start_time + gait.ramp_time {
            return Err(Fault(format!(
                "gait.stop_time = {} s is before the end of the start ramp, gait.start_time + gait.ramp_time = {} s.",
                gait.stop_time,
                gait.start_time + gait.ramp_time
            )));
        }
        Ok(([gait.initial_phase, 0.0], []))
    }

    fn point(&self, now: &At<'_>) -> Motion {
        self.gait.at(self.table.as_deref(), now.time, now.states[STRIDE])
    }

    fn rates(motion: &Motion) -> [f64; STATES] {
        let mut rates = [0.0; STATES];
        rates[STRIDE] = motion.stride_rate;
        rates[ENERGY] = motion.torque * motion.speed;
        rates
    }

    fn outputs(&self, now: &At<'_>, motion: &Motion) -> Outputs {
        let stride = now.states[STRIDE];
        let whole = floor(stride);
        Outputs {
            joint_angle: motion.angle,
            joint_speed: motion.speed,
            torque_demand: motion.torque,
            gait_phase: stride - whole,
            tracking_error: now.inputs.joint_torque - motion.torque,
            power_demand: motion.torque * motion.speed,
            energy_demand: now.states[ENERGY],
            strides: whole,
        }
    }

    fn balance(&self, _: &At<'_>, _: &Motion) -> NoVariables {
        NoVariables
    }

    fn indicators(&self, now: &At<'_>, _: &Motion) -> Indicators {
        Indicators { heel_strike: (PI * now.states[STRIDE]).sin() }
    }

    /// Identical strides have closed-form integrals of stride and work.
    #[inline]
    fn one(
        &self,
        line: &Line<'_, Inputs, 0>,
        t: f64,
        x: &[f64; STATES],
        first: Option<&Motion>,
        h: f64,
    ) -> Tried<Motion, STATES> {
        let Some((strides, work)) = self.gait.on(self.table.as_deref(), line.time + t, x[STRIDE], h) else {
            return self.general(line, t, x, first, h);
        };
        let mut states = *x;
        states[STRIDE] += strides;
        states[ENERGY] += work;
        Tried { states, error: 0.0, point: None }
    }

    fn set_load(&mut self, table: &LoadTable) -> bool {
        self.table = Some(Arc::new(Cycle::of(table)));
        true
    }

    fn next_event(&self, time: f64) -> f64 {
        self.gait.next_event(time)
    }
}
