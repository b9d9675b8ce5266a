//! Means and peaks over a period.

use serde::Serialize;

/// Means and peaks over one stride.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Periodic {
    /// Greatest temperature of the winding within the stride, K.
    pub winding_temperature: f64,
    /// Mean temperature of the winding, K.
    pub winding_temperature_mean: f64,
    /// Rms current, A.
    pub current_rms: f64,
    /// Peak current, A.
    pub current_peak: f64,
    /// Peak torque at the joint, N.m.
    pub joint_torque_peak: f64,
    /// Rms error of the torque, N.m.
    pub torque_error_rms: f64,
    /// Mean electrical power of the motor, W.
    pub power_electrical: f64,
    /// Mean mechanical power at the joint, W.
    pub power_joint: f64,
    /// Mean power from the supply, W.
    pub power_supply: f64,
    /// Peak voltage at the terminals, V, where the current follows the load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub voltage_peak: Option<f64>,
    /// Strides that were computed to find it.
    pub strides_walked: u32,
}

impl Periodic {
    /// Adds another with its weight: peaks are the greatest, the rest is summed until [`finished`](Periodic::finished).
    pub(super) fn add(&mut self, other: &Periodic, weight: f64) {
        self.winding_temperature = self.winding_temperature.max(other.winding_temperature);
        self.winding_temperature_mean += weight * other.winding_temperature_mean;
        self.current_rms += weight * other.current_rms.powi(2);
        self.current_peak = self.current_peak.max(other.current_peak);
        self.joint_torque_peak = self.joint_torque_peak.max(other.joint_torque_peak);
        self.torque_error_rms += weight * other.torque_error_rms.powi(2);
        self.power_electrical += weight * other.power_electrical;
        self.power_joint += weight * other.power_joint;
        self.power_supply += weight * other.power_supply;
        self.voltage_peak = match (self.voltage_peak, other.voltage_peak) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (a, b) => a.or(b),
        };
    }

    /// Roots of the mean squares.
    pub(super) fn finished(self) -> Periodic {
        let (current_rms, torque_error_rms) = (self.current_rms.sqrt(), self.torque_error_rms.sqrt());
        Periodic { current_rms, torque_error_rms, ..self }
    }
}
