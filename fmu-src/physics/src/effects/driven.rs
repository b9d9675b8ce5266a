//! What effects at the ports of current and speed add to the Jacobian of a model's equations.

use super::Ports;
use crate::terms::{Driver, Drivers};
use nalgebra::Vector2;

/// Derivatives with respect to current and speed by the drivers alone.
#[derive(Clone, Copy, Debug)]
pub struct DrivenSlopes {
    /// Of the factor on the winding's resistance, 1/A and s/rad.
    pub resistance: Vector2<f64>,
    /// Of the voltage between terminals and winding, V/A and V.s/rad.
    pub voltage: Vector2<f64>,
    /// Of the factor on the torque constant, 1/A and s/rad.
    pub torque_constant: Vector2<f64>,
    /// Of the drag torque, N.m/A and N.m.s/rad.
    pub drag: Vector2<f64>,
}

impl Ports<'_> {
    /// The derivatives at these drivers; the load torque follows the current by `load_per_ampere`, N.m/A. Without them, an integrator would
    /// follow the changes in explicit steps, as short as L/R.
    #[inline(never)]
    pub fn driven_slopes(&self, drivers: &Drivers, load_per_ampere: f64) -> DrivenSlopes {
        let by_both = |of: &dyn Fn(f64, Driver) -> f64| {
            let by = |driver: Driver| of(drivers.of(driver), driver);
            let through_load =
                if load_per_ampere == 0.0 { 0.0 } else { load_per_ampere * by(Driver::LoadTorque) };
            Vector2::new(by(Driver::Current) + through_load, by(Driver::Speed))
        };
        DrivenSlopes {
            resistance: by_both(&|x, by| self.winding_resistance_slope(x, by, drivers)),
            voltage: by_both(&|x, by| {
                self.driven_voltage_slope(x, by, drivers) + self.series_voltage_slope(x, by, drivers)
            }),
            torque_constant: by_both(&|x, by| self.driven_torque_constant_slope(x, by, drivers)),
            drag: by_both(&|x, by| self.driven_drag_slope(x, by, drivers)),
        }
    }
}
