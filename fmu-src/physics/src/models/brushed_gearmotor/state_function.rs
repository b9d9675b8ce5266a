//! The paper's state function V(I, T, tau), corrected and as published.
//!
//! Kirchhoff's law of the paper's eq. (2), its eqs. (3), (4) and (8) unchanged, and its eq. (7) with the speed w
//! instead of the angle, so that both sides are volts (tau w is the power of the back-EMF):
//! ```text
//! V(I, T, tau; w, dI/dt) = R(T) I + L dI/dt + tau w / I,   R(T) = R_0 [1 + alpha (T - T_0)]     (1)
//! P = V I = R I^2 + L I dI/dt + tau w                                                      (2)
//! W = int R I^2 dt + [L I^2 / 2] + int tau dtheta                                          (3)
//! dV/dI = R - tau w / I^2,   dV/dT = alpha R_0 I,   dV/dtau = w / I                        (4)
//! ```
//! each partial derivative with the other two variables, w and dI/dt constant. The derivatives of the inverse functions follow
//! from (4) and the cyclic rule dV/dI dI/dT dT/dV = -1. I(V, T, tau) solves a quadratic, R I^2 - (V - L dI/dt) I + tau w = 0,
//! with two currents for the same voltage and power: a running motor has the smaller one ([`Branch`]).
//!
//! *Limitation*: (1) is an identity. With tau = K I its last term is K w for every I, so an estimate of one of its
//! variables from the others is exact by construction. It validates nothing unless tau and w are measured independently.
//! *Sign*: tau and w at the same shaft, positive if the motor drives. *Range*: I and tau w not both zero.
//! *Source*: the paper in `seeds`, sections 2 and 3; audit rows P02, P03, P14 to P21.
//! *As published*: [`Published`], eqs. (10), (14) to (16) and (21) to (24) verbatim.

/// Parameters of the state function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateFunction {
    /// Resistance at `T_0`, Ohm.
    pub r_0: f64,
    /// Temperature coefficient, 1/K.
    pub alpha: f64,
    /// Reference temperature, K.
    pub t_0: f64,
    /// Inductance, H.
    pub l: f64,
}

/// An operating point of the motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Operating {
    /// Current, A.
    pub current: f64,
    /// Temperature of the winding, K.
    pub temperature: f64,
    /// Torque before friction, N.m.
    pub torque: f64,
    /// Speed of the same shaft, rad/s.
    pub speed: f64,
    /// dI/dt, A/s.
    pub current_rate: f64,
}

/// A quantity split into its electrical, magnetic and mechanical part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// Part of the resistance.
    pub electrical: f64,
    /// Part of the inductance.
    pub magnetic: f64,
    /// Part of the back-EMF.
    pub mechanical: f64,
}

impl Parts {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.electrical + self.magnetic + self.mechanical
    }
}

/// Choice between the two currents for one voltage and mechanical power.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// The smaller: more than half of the power is mechanical, dV/dI < 0 at constant tau w.
    Running,
    /// The larger: more than half of the power becomes heat in the winding; also near standstill.
    Stalling,
}

/// First partial derivatives of V(I, T, tau).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Partials {
    /// dV/dI at constant T and tau, Ohm.
    pub by_current: f64,
    /// dV/dT at constant I and tau, V/K.
    pub by_temperature: f64,
    /// dV/dtau at constant I and T, V/(N.m).
    pub by_torque: f64,
}

/// Contribution of each variable to the change of the voltage between two states, V. The sum equals the change for any
/// size of it: the paper's eq. (21), corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VoltageChange {
    /// By the current, through the resistance and through tau w / I.
    pub by_current: f64,
    /// By the temperature.
    pub by_temperature: f64,
    /// By the torque.
    pub by_torque: f64,
    /// By the speed.
    pub by_speed: f64,
    /// By dI/dt.
    pub magnetic: f64,
}

impl VoltageChange {
    /// The sum, V.
    pub fn total(&self) -> f64 {
        self.by_current + self.by_temperature + self.by_torque + self.by_speed + self.magnetic
    }
}

impl StateFunction {
    /// Resistance at the temperature `t`, K: the paper's eq. (8), Ohm.
    pub fn resistance(&self, t: f64) -> f64 {
        self.r_0 * (1.0 + self.alpha * (t - self.t_0))
    }

    /// The voltage and its parts, eq. (1), V.
    pub fn voltage(&self, s: &Operating) -> Parts {
        Parts {
            electrical: self.resistance(s.temperature) * s.current,
            magnetic: self.l * s.current_rate,
            mechanical: s.torque * s.speed / s.current,
        }
    }

    /// The power and its parts, eq. (2), W.
    pub fn power(&self, s: &Operating) -> Parts {
        Parts {
            electrical: self.resistance(s.temperature) * s.current * s.current,
            magnetic: self.l * s.current * s.current_rate,
            mechanical: s.torque * s.speed,
        }
    }

    /// Work over `time` seconds in a steady state that starts at rest: eq. (3), J.
    pub fn steady_work(&self, s: &Operating, time: f64) -> Parts {
        let power = self.power(s);
        Parts {
            electrical: power.electrical * time,
            magnetic: 0.5 * self.l * s.current * s.current,
            mechanical: power.mechanical * time,
        }
    }

    /// Current at the voltage `v`, V, with temperature, torque, speed and dI/dt of `s`, A; `None` if no current solves the
    /// equation. The current of `s` is not used.
    pub fn current(&self, v: f64, s: &Operating, branch: Branch) -> Option<f64> {
        let (r, power) = (self.resistance(s.temperature), s.torque * s.speed);
        let driving = v - self.l * s.current_rate;
        let root = (driving * driving - 4.0 * r * power).sqrt();
        // The larger root has no cancellation; the smaller follows from the product of both.
        let larger = (driving + root.copysign(driving)) / (2.0 * r);
        let current = match branch {
            Branch::Stalling => larger,
            Branch::Running => power / (r * larger),
        };
        current.is_finite().then_some(current)
    }

    /// The branch of a state.
    pub fn branch(&self, s: &Operating) -> Branch {
        if self.partials(s).by_current < 0.0 { Branch::Running } else { Branch::Stalling }
    }

    /// Temperature at the voltage `v`, V, with the other variables of `s`, K.
    pub fn temperature(&self, v: f64, s: &Operating) -> f64 {
        let parts = self.voltage(s);
        let r = (v - parts.magnetic - parts.mechanical) / s.current;
        self.t_0 + (r / self.r_0 - 1.0) / self.alpha
    }

    /// Torque at the voltage `v`, V, with the other variables of `s`, N.m.
    pub fn torque(&self, v: f64, s: &Operating) -> f64 {
        let parts = self.voltage(s);
        (v - parts.electrical - parts.magnetic) * s.current / s.speed
    }

    /// The paper's eq. (22), corrected: change of the current from `a` to the state with the voltage `v` and the other
    /// variables of `b`, A. The branch is that of `a`.
    pub fn current_change(&self, a: &Operating, v: f64, b: &Operating) -> Option<f64> {
        Some(self.current(v, b, self.branch(a))? - a.current)
    }

    /// The paper's eq. (23), corrected: like [`current_change`](Self::current_change), for the temperature, K.
    pub fn temperature_change(&self, a: &Operating, v: f64, b: &Operating) -> f64 {
        self.temperature(v, b) - a.temperature
    }

    /// The paper's eq. (24), corrected: like [`current_change`](Self::current_change), for the torque, N.m.
    pub fn torque_change(&self, a: &Operating, v: f64, b: &Operating) -> f64 {
        self.torque(v, b) - a.torque
    }

    /// First partial derivatives, eq. (4).
    pub fn partials(&self, s: &Operating) -> Partials {
        let per_ampere = s.speed / s.current;
        Partials {
            by_current: self.resistance(s.temperature) - s.torque * per_ampere / s.current,
            by_temperature: self.alpha * self.r_0 * s.current,
            by_torque: per_ampere,
        }
    }

    /// Change of the voltage from `a` to `b` by variable: differences times means, which is exact for products.
    pub fn change(&self, a: &Operating, b: &Operating) -> VoltageChange {
        let mean = |x: f64, y: f64| 0.5 * (x + y);
        let current = b.current - a.current;
        let power = mean(a.torque * a.speed, b.torque * b.speed);
        let per_ampere = mean(1.0 / a.current, 1.0 / b.current);
        let r = mean(self.resistance(a.temperature), self.resistance(b.temperature));
        VoltageChange {
            by_current: (r - power / (a.current * b.current)) * current,
            by_temperature: self.alpha
                * self.r_0
                * mean(a.current, b.current)
                * (b.temperature - a.temperature),
            by_torque: per_ampere * mean(a.speed, b.speed) * (b.torque - a.torque),
            by_speed: per_ampere * mean(a.torque, b.torque) * (b.speed - a.speed),
            magnetic: self.l * (b.current_rate - a.current_rate),
        }
    }
}

/// The functions as published, verbatim with their errors. Temperatures in degrees Celsius, angle theta and charge q since
/// the start. Only for the reproduction of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Published {
    /// Resistance "measured at 20 degC", Ohm; in fact 9.2 Ohm / (0.004 * 20).
    pub r_0: f64,
    /// Temperature coefficient, 1/degC.
    pub alpha: f64,
    /// Inductance, H.
    pub l: f64,
}

/// A state in the paper's variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedState {
    /// V, V.
    pub voltage: f64,
    /// I_a, A.
    pub current: f64,
    /// T, degC.
    pub temperature: f64,
    /// T_m, N.m.
    pub torque: f64,
    /// q, C.
    pub charge: f64,
    /// theta, rad.
    pub angle: f64,
}

impl Published {
    /// Values of the paper.
    pub const PAPER: Published = Published { r_0: 115.0, alpha: 0.004, l: 1.803e-3 };

    /// Eq. (10): zero at 0 degC.
    pub fn resistance(&self, t: f64) -> f64 {
        self.alpha * self.r_0 * t
    }

    /// Eq. (14).
    pub fn voltage(&self, s: &PublishedState) -> Parts {
        Parts {
            electrical: self.resistance(s.temperature) * s.current,
            magnetic: self.l * s.current * s.current / (2.0 * s.charge),
            mechanical: s.torque * s.angle / s.charge,
        }
    }

    /// Eq. (15): its last term is work, not power. `current_rate` is dI/dt, A/s.
    pub fn power(&self, s: &PublishedState, current_rate: f64) -> Parts {
        Parts {
            electrical: self.resistance(s.temperature) * s.current * s.current,
            magnetic: s.current * self.l * current_rate,
            mechanical: s.torque * s.angle,
        }
    }

    /// Eq. (16).
    pub fn work(&self, s: &PublishedState) -> Parts {
        Parts {
            electrical: self.resistance(s.temperature) * s.current * s.charge,
            magnetic: 0.5 * self.l * s.current * s.current,
            mechanical: s.torque * s.angle,
        }
    }

    /// Eq. (21), from `a` to `b`; factors that are not differences are those of `a`. Its third term is in Ohm times kelvin.
    pub fn voltage_change(&self, a: &PublishedState, b: &PublishedState) -> f64 {
        let r = self.resistance(a.temperature);
        self.l / (2.0 * a.charge) * (b.current.powi(2) - a.current.powi(2))
            + r * (b.current - a.current)
            + r * (b.temperature - a.temperature)
            + a.angle / a.charge * (b.torque - a.torque)
    }

    /// Eq. (22): the factor q is missing in alpha R_0 T in all three terms.
    pub fn current_change(&self, a: &PublishedState, b: &PublishedState) -> f64 {
        let sum = |t: f64| a.current * self.l + self.resistance(t);
        let (at_a, at_b) = (sum(a.temperature), sum(b.temperature));
        a.charge / at_a * (b.voltage - a.voltage)
            - a.current * (at_b / at_a).ln()
            - a.angle / at_a * (b.torque - a.torque)
    }

    /// Eq. (23).
    pub fn temperature_change(&self, a: &PublishedState, b: &PublishedState) -> f64 {
        let per_ampere = self.alpha * self.r_0;
        (b.voltage - a.voltage) / (per_ampere * a.current)
            - self.l / (per_ampere * a.charge) * (b.current - a.current)
            - a.temperature * (b.current / a.current).ln()
            - a.angle / (per_ampere * a.current * a.charge) * (b.torque - a.torque)
    }

    /// Eq. (24).
    pub fn torque_change(&self, a: &PublishedState, b: &PublishedState) -> f64 {
        let per_volt = a.charge / a.angle;
        per_volt * (b.voltage - a.voltage)
            - self.l / (2.0 * a.angle) * (b.current.powi(2) - a.current.powi(2))
            - self.resistance(a.temperature) * per_volt * (b.current - a.current)
            - self.alpha * self.r_0 * a.current * per_volt * (b.temperature - a.temperature)
    }
}

#[cfg(test)]
#[path = "state_function_tests.rs"]
mod tests;
