//! A model that may be: the declared parameters with their values, and what was added.

use crate::candidate::Change;
use crate::outcome::Follows;
use physics::model::Slot;
use physics::terms::{Driver, Drivers, Factor, GenericTerm, Law, Port, Product, Table};

/// A number of an addition.
#[derive(Clone, Debug)]
pub struct Number {
    /// Its symbol.
    pub symbol: String,
    /// Its value.
    pub value: f64,
    /// What it may be.
    pub limits: (f64, f64),
    /// Its unit.
    pub unit: &'static str,
    /// A change of it that would be seen.
    pub scale: f64,
    /// Whether it is found along slopes; else by trying.
    pub sloped: bool,
}

/// How an addition changes the model.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Parameters of an effect of the list, one for each number, beside others that stand still.
    Listed {
        /// One for each number.
        slots: Vec<Slot>,
        /// What stands still.
        with: Vec<(Slot, f64)>,
    },
    /// A term: coefficient, and exponent where there is a second number, over a driver.
    Power {
        /// The driver with its zero and its usual size; its exponent where that is no number.
        factor: Factor,
    },
    /// A term: a table over a driver, a number at each point.
    Table {
        /// The driver.
        driver: Driver,
        /// The points.
        knots: Vec<f64>,
    },
}

/// What was added to a model.
#[derive(Clone, Debug)]
pub struct Addition {
    /// Id of an effect of the list; `generic_term`.
    pub id: String,
    /// Where it acts.
    pub port: Port,
    /// What it follows.
    pub follows: Follows,
    /// How it changes the model.
    pub shape: Shape,
    /// Its numbers.
    pub numbers: Vec<Number>,
    /// Whether it acts, run by run.
    pub active: Vec<bool>,
}

impl Addition {
    /// Whether it stands in the list of effects.
    pub fn is_listed(&self) -> bool {
        matches!(self.shape, Shape::Listed { .. })
    }

    /// The law as data, where it is in no list.
    pub fn term(&self) -> Option<GenericTerm> {
        let law = match &self.shape {
            Shape::Listed { .. } => return None,
            Shape::Power { factor } => {
                let mut factor = *factor;
                if let Some(exponent) = self.numbers.get(1) {
                    factor.exponent = exponent.value;
                }
                let coefficient = self.numbers[0].value;
                let factors = [(factor.exponent != 0.0).then_some(factor), None, None];
                Law::Product(Product { coefficient, factors })
            }
            Shape::Table { driver, knots } => {
                let values: Vec<f64> = self.numbers.iter().map(|n| n.value).collect();
                Law::Table(Table::new(*driver, knots, &values)?)
            }
        };
        Some(GenericTerm { port: self.port, law })
    }

    /// Adds itself to a change.
    pub fn apply(&self, change: &mut Change) {
        if let Shape::Listed { slots, with } = &self.shape {
            change.values.extend(with);
            change.values.extend(slots.iter().zip(&self.numbers).map(|(slot, number)| (*slot, number.value)));
        } else {
            change.terms.extend(self.term());
        }
    }

    /// What a term's value grows by with each of its numbers, in that order, where the drivers stand.
    pub fn slope(&self, number: usize, drivers: &Drivers) -> f64 {
        match &self.shape {
            Shape::Listed { .. } => 1.0,
            Shape::Power { factor } => {
                let x = drivers.of(factor.driver);
                let base = ((x - factor.offset) / factor.reference).abs();
                let exponent = self.numbers.get(1).map_or(factor.exponent, |n| n.value);
                let power = power(factor, x, exponent);
                if number == 0 {
                    power
                } else if base > 0.0 {
                    self.numbers[0].value * power * base.ln()
                } else {
                    0.0
                }
            }
            Shape::Table { driver, knots } => hat(knots, number, drivers.of(*driver)),
        }
    }
}

/// The power of a driver at `x`, as terms take it.
pub fn power(factor: &Factor, x: f64, exponent: f64) -> f64 {
    Factor { exponent, ..*factor }.of(x)
}

/// The share that point `k` of a table has at `x`: 1 there, 0 at its neighbours, held beyond the ends.
pub fn hat(knots: &[f64], k: usize, x: f64) -> f64 {
    let last = knots.len() - 1;
    let x = x.clamp(knots[0], knots[last]);
    if k > 0 && x < knots[k] {
        ((x - knots[k - 1]) / (knots[k] - knots[k - 1])).max(0.0)
    } else if k < last && x > knots[k] {
        ((knots[k + 1] - x) / (knots[k + 1] - knots[k])).max(0.0)
    } else {
        1.0
    }
}

/// A model that may be.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// The declared parameters, in the order of the experiment's priors.
    pub declared: Vec<f64>,
    /// What was added.
    pub additions: Vec<Addition>,
}

impl Hypothesis {
    /// Every number that slopes find: the declared ones, then those of the additions.
    pub fn numbers(&self) -> Vec<f64> {
        let added = self.additions.iter().flat_map(|a| a.numbers.iter().filter(|n| n.sloped));
        self.declared.iter().copied().chain(added.map(|n| n.value)).collect()
    }

    /// Takes other values for [`numbers`](Hypothesis::numbers).
    pub fn take(&mut self, numbers: &[f64]) {
        let places = self.additions.iter_mut().flat_map(|a| a.numbers.iter_mut().filter(|n| n.sloped));
        let all = self.declared.iter_mut().chain(places.map(|n| &mut n.value));
        all.zip(numbers).for_each(|(place, value)| *place = *value);
    }
}
