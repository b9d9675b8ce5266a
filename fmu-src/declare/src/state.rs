//! Continuous states, each with its derivative.

use crate::{Unit, Variable};

/// Number of states of one declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elements {
    /// A scalar.
    One,
    /// An array of constant size.
    Fixed(u32),
    /// An array whose size is the parameter with this name, with this largest size.
    UpTo(u32, &'static str),
}

impl Elements {
    /// The largest number of elements.
    pub const fn most(self) -> u32 {
        match self {
            Elements::One => 1,
            Elements::Fixed(count) | Elements::UpTo(count, _) => count,
        }
    }
}

/// A continuous state or an array of states, with its derivative.
#[derive(Clone, Copy, Debug)]
pub struct State {
    /// The state; the first element of an array.
    pub value: Variable,
    /// Its derivative; the derivatives of an array have consecutive value references.
    pub rate: Variable,
    /// Number of elements.
    pub elements: Elements,
    /// Whether the array is an output in FMI 3; scalar states and single elements are not.
    pub shown: bool,
}

impl State {
    /// A state with its value reference and that of its derivative.
    pub const fn new(value_reference: u32, rate_reference: u32, unit: Unit) -> State {
        State {
            value: Variable::local(value_reference, unit),
            rate: Variable::local(rate_reference, unit.rate()),
            elements: Elements::One,
            shown: false,
        }
    }

    /// With nominal values of the state and of its derivative; the latter is the derivative at the start for nominal inputs.
    pub const fn nominal(mut self, value: f64, rate: f64) -> State {
        self.value = self.value.nominal(value);
        self.rate = self.rate.nominal(rate);
        self
    }

    /// A temperature difference.
    pub const fn difference(mut self) -> State {
        self.value = self.value.difference();
        self
    }

    /// A state that grows without limit.
    pub const fn unbounded(mut self) -> State {
        self.value = self.value.unbounded();
        self
    }

    /// An array of states.
    pub const fn elements(mut self, elements: Elements) -> State {
        self.elements = elements;
        self
    }

    /// An array of states that is an output in FMI 3.
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

/// Index of a state among all states of a list, or of the first element of an array, by name.
///
/// # Panics
/// If the list has no such state: at compile time in a constant.
pub const fn index_of(list: &[State], name: &str) -> usize {
    let (mut row, mut index) = (0, 0);
    while row < list.len() {
        if is_same(list[row].value.name, name) {
            return index;
        }
        index += list[row].elements.most() as usize;
        row += 1;
    }
    panic!("no state has this name")
}

const fn is_same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}

/// Declares the continuous states of a model; name, unit and description of the derivatives are derived.
///
/// ```
/// use declare::{State, Unit, states};
/// states! {
///     /// The states.
///     pub const STATES = {
///         /// Angle of the shaft
///         "state.angle" = State::new(1, 101, Unit::Radian),
///     }
/// }
/// assert_eq!((STATES[0].value.name, STATES[0].rate.name), ("state.angle", "der(state.angle)"));
/// assert_eq!(STATES[0].rate.unit, Unit::RadianPerSecond);
/// assert_eq!(declare::index_of(STATES, "state.angle"), 0);
/// ```
#[macro_export]
macro_rules! states {
    ($(#[doc = $sdoc:literal])* pub const $list:ident = {
        $($(#[doc = $doc:expr])* $name:literal = $row:expr),* $(,)?
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
