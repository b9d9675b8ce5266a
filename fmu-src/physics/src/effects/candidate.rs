//! Forms in which `close-loop` searches for an effect: declared with the effect, read by the crate `calibrate`.

use crate::terms::{Driver, Lag, Port};

/// Time dependence of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Follows {
    /// Constant.
    Nothing,
    /// The present value of a driver.
    Driver(Driver),
    /// The present values of two drivers.
    Both(Driver, Driver),
    /// A first-order lag of a driver: an additional state.
    Late(Driver),
    /// A first-order lag of a driver less the driver: a mass attached to the node of this temperature.
    Mass(Driver),
    /// Past values: a latch, hysteresis or an intermittent effect.
    History,
}

impl Follows {
    /// Its drivers.
    pub fn drivers(self) -> impl Iterator<Item = Driver> {
        let all = match self {
            Follows::Driver(driver) | Follows::Late(driver) | Follows::Mass(driver) => [Some(driver), None],
            Follows::Both(first, second) => [Some(first), Some(second)],
            Follows::Nothing | Follows::History => [None; 2],
        };
        all.into_iter().flatten()
    }

    /// The lag with this time constant, if there is one.
    pub fn lag(self, tau: f64) -> Option<Lag> {
        match self {
            Follows::Late(driver) => Some(Lag { driver, tau, difference: false }),
            Follows::Mass(driver) => Some(Lag { driver, tau, difference: true }),
            _ => None,
        }
    }

    /// Its name in reports; `None` if it is constant.
    pub fn name(self) -> Option<String> {
        match self {
            Follows::Nothing => None,
            Follows::History => Some("history".to_string()),
            _ => Some(self.drivers().map(Driver::name).collect::<Vec<_>>().join(" and ")),
        }
    }
}

/// Method for estimating the size of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Linear estimate from the derivative at zero.
    Slope,
    /// A step at a trial time: size and time.
    Step,
    /// Simulations at a few sizes: the effect adds its own energy storage.
    Store,
}

/// A candidate form of an effect for measured data.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Symbols of the fitted parameters, the size first.
    pub symbols: &'static [&'static str],
    /// Port at which it acts, as in laws found in data.
    pub port: Port,
    /// Its time dependence.
    pub follows: Follows,
    /// Fixed settings: symbol and item.
    pub settings: &'static [(&'static str, &'static str)],
    /// Method for estimating its size.
    pub way: Way,
    /// Whether it may act in some runs only: an effect of the bench, not of the motor.
    pub may_vary: bool,
    /// Largest plausible effect at the end of the data, for one that grows with time: above it is a defect, not a drift.
    pub most: f64,
}

impl Candidate {
    /// An effect that follows the present value of a driver.
    pub const fn on(driver: Driver, port: Port, symbols: &'static [&'static str]) -> Candidate {
        Candidate { follows: Follows::Driver(driver), ..Candidate::constant(port, symbols) }
    }

    /// A constant effect.
    pub const fn constant(port: Port, symbols: &'static [&'static str]) -> Candidate {
        let (follows, way) = (Follows::Nothing, Way::Slope);
        Candidate { symbols, port, follows, settings: &[], way, may_vary: false, most: f64::INFINITY }
    }

    /// An effect that may act in some runs only: of the bench, not of the motor.
    pub const fn of_the_bench(self) -> Candidate {
        Candidate { may_vary: true, ..self }
    }
}
