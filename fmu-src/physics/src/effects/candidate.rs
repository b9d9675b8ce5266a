//! How close-loop looks for an effect: declared with the effect, read by the crate `calibrate`.

use crate::terms::{Driver, Port};

/// Which time of a driver something follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Follows {
    /// Nothing: it is constant.
    Nothing,
    /// The present value of a driver.
    Driver(Driver),
    /// A first-order lag of a driver: a state that the model lacks.
    Late(Driver),
    /// What was before: it latches, has hysteresis or comes and goes.
    History,
}

impl Follows {
    /// Its name in reports; `None` where it is constant.
    pub fn name(self) -> Option<&'static str> {
        match self {
            Follows::Nothing => None,
            Follows::Driver(driver) | Follows::Late(driver) => Some(driver.name()),
            Follows::History => Some("history"),
        }
    }
}

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

/// A form in which an effect is looked for in measured data.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// Symbols of the parameters that are fitted, the size first.
    pub symbols: &'static [&'static str],
    /// Where it acts, in the words of laws found in data.
    pub port: Port,
    /// What it follows.
    pub follows: Follows,
    /// Settings that stand still: symbol and item.
    pub settings: &'static [(&'static str, &'static str)],
    /// How its size is found.
    pub way: Way,
    /// Whether it may act in some runs only: something on the bench, not in the motor.
    pub may_vary: bool,
    /// The most that one that grows with time may have done by the end of the clock: beyond, it is broken and has not drifted.
    pub most: f64,
}

impl Candidate {
    /// One that follows the present value of a driver.
    pub const fn on(driver: Driver, port: Port, symbols: &'static [&'static str]) -> Candidate {
        Candidate { follows: Follows::Driver(driver), ..Candidate::constant(port, symbols) }
    }

    /// One that is constant.
    pub const fn constant(port: Port, symbols: &'static [&'static str]) -> Candidate {
        let (follows, way) = (Follows::Nothing, Way::Slope);
        Candidate { symbols, port, follows, settings: &[], way, may_vary: false, most: f64::INFINITY }
    }

    /// One that may act in some runs only: something on the bench, not in the motor.
    pub const fn of_the_bench(self) -> Candidate {
        Candidate { may_vary: true, ..self }
    }
}
