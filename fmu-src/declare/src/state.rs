//! Continuous states: each a variable, with the variable that is its rate of change.

use crate::{Unit, Variable};

/// How many states one row stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elements {
    /// One, without an index.
    One,
    /// So many, always.
    Fixed(u32),
    /// As many as the parameter of this name says, and no more than the number.
    UpTo(u32, &'static str),
}

impl Elements {
    /// The most that there may be.
    pub const fn most(self) -> u32 {
        match self {
            Elements::One => 1,
            Elements::Fixed(count) | Elements::UpTo(count, _) => count,
        }
    }
}

/// A continuous state, or a row of them, and its derivative with respect to time.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// The state; with several elements, the first of them.
    pub value: Variable,
    /// Its derivative; the value references of several elements follow one another.
    pub rate: Variable,
    /// How many there are.
    pub elements: Elements,
    /// Whether an array of them is an output, where arrays are variables (FMI 3); single elements never are.
    pub shown: bool,
}

impl State {
    /// A state with the value references of itself and of its derivative.
    pub const fn new(value_reference: u32, rate_reference: u32, unit: Unit) -> State {
        State {
            value: Variable::local(value_reference, unit),
            rate: Variable::local(rate_reference, unit.rate()),
            elements: Elements::One,
            shown: false,
        }
    }

    /// With a typical size, which is that of its change in a second, too.
    pub const fn nominal(mut self, nominal: f64) -> State {
        self.value = self.value.nominal(nominal);
        self.rate = self.rate.nominal(nominal);
        self
    }

    /// A difference of temperatures.
    pub const fn difference(mut self) -> State {
        self.value = self.value.difference();
        self
    }

    /// Several states.
    pub const fn elements(mut self, elements: Elements) -> State {
        self.elements = elements;
        self
    }

    /// Several states, which an importer that knows arrays sees as an output.
    pub const fn shown(mut self) -> State {
        self.shown = true;
        self
    }

    /// Used by [`states!`](crate::states): adds names and descriptions.
    #[doc(hidden)]
    pub const fn named(mut self, name: [&'static str; 2], doc: [&'static str; 2]) -> State {
        self.value = self.value.named(name[0], doc[0], crate::Kind::Real);
        self.rate = self.rate.named(name[1], doc[1], crate::Kind::Real);
        self
    }
}

/// Declares the continuous states of a model, a line each; name, unit and description of the derivatives follow.
///
/// ```
/// use declare::{State, Unit, states};
/// states! {
///     /// What is integrated.
///     pub const STATES = {
///         /// Angle of the shaft
///         "state.angle" = State::new(1, 101, Unit::Radian),
///     }
/// }
/// assert_eq!((STATES[0].value.name, STATES[0].rate.name), ("state.angle", "der(state.angle)"));
/// assert_eq!(STATES[0].rate.unit, Unit::RadianPerSecond);
/// ```
#[macro_export]
macro_rules! states {
    ($(#[doc = $sdoc:literal])* pub const $list:ident = {
        $($(#[doc = $doc:literal])* $name:literal = $row:expr),* $(,)?
    }) => {
        $(#[doc = $sdoc])*
        pub const $list: &[$crate::State] = &[$(
            $crate::State::named(
                $row,
                [$name, concat!("der(", $name, ")")],
                [concat!($($doc),*), concat!("Rate of change:", $($doc),*)],
            )
        ),*];
    };
}
