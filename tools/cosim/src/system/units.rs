//! Conversion of units between connectors.
use crate::{BaseUnit, ModelDescription, Unit, Variable};

/// `y = factor * x + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    pub(crate) factor: f64,
    pub(crate) offset: f64,
}

impl Affine {
    pub(crate) const IDENTITY: Self = Self { factor: 1.0, offset: 0.0 };

    /// The identity gives every bit back, and so does a pure factor what the factor gives.
    pub(crate) fn of(self, x: f64) -> f64 {
        if self == Self::IDENTITY { x } else { self.factor * x + self.offset }
    }

    /// First this, then `next`.
    pub(crate) fn then(self, next: Self) -> Self {
        Self { factor: next.factor * self.factor, offset: next.factor * self.offset + next.offset }
    }
}

/// The unit of a variable, with its definition if the FMU has one.
pub(crate) fn unit_of(description: &ModelDescription, variable: &Variable) -> Option<Unit> {
    let name = variable.unit.as_ref()?;
    let defined = description.units.iter().find(|u| u.name == *name).cloned();
    Some(defined.unwrap_or_else(|| Unit { name: name.clone(), base: None, display_units: Vec::new() }))
}

/// The conversion of values from one unit to another; of differences, without offset, if `relative`.
///
/// Without a unit on one side the value is not converted. `None` if the dimensions of the units differ or a unit is undefined.
pub(crate) fn conversion(from: Option<&Unit>, to: Option<&Unit>, relative: bool) -> Option<Affine> {
    let (Some(from), Some(to)) = (from, to) else { return Some(Affine::IDENTITY) };
    let (Some(a), Some(b)) = (from.base, to.base) else {
        return (from.name == to.name).then_some(Affine::IDENTITY);
    };
    if a.exponents != b.exponents {
        return None;
    }
    if a.factor == b.factor && (relative || a.offset == b.offset) {
        return Some(Affine::IDENTITY);
    }
    let offset = if relative { 0.0 } else { (a.offset - b.offset) / b.factor };
    Some(Affine { factor: a.factor / b.factor, offset })
}

/// What the product of values in these units is to be multiplied by for watts; `None` if it is no power.
pub(crate) fn watts(a: Option<&Unit>, b: Option<&Unit>) -> Option<f64> {
    const WATT: [i32; 7] = [1, 2, -3, 0, 0, 0, 0];
    let (a, b): (BaseUnit, BaseUnit) = (a?.base?, b?.base?);
    // An angle has no dimension here: torque times speed is a power.
    let is_power = WATT.iter().zip(a.exponents.iter().zip(b.exponents)).all(|(w, (x, y))| *w == x + y);
    (is_power && a.offset == 0.0 && b.offset == 0.0).then_some(a.factor * b.factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> Unit {
        let base = Some(BaseUnit { exponents, factor, offset });
        Unit { name: name.to_owned(), base, display_units: Vec::new() }
    }

    fn kelvin() -> Unit {
        unit("K", [0, 0, 0, 0, 1, 0, 0, 0], 1.0, 0.0)
    }

    #[test]
    fn temperatures_convert_and_differences_do_without_offset() {
        let celsius = unit("degC", [0, 0, 0, 0, 1, 0, 0, 0], 1.0, 273.15);
        let fahrenheit = unit("degF", [0, 0, 0, 0, 1, 0, 0, 0], 5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let to = |a: &Unit, b: &Unit, relative, x| conversion(Some(a), Some(b), relative).unwrap().of(x);
        assert_eq!(to(&celsius, &kelvin(), false, 25.0), 298.15);
        assert!((to(&kelvin(), &fahrenheit, false, 373.15) - 212.0).abs() < 1e-10);
        assert_eq!(to(&celsius, &kelvin(), true, 25.0), 25.0);
        assert!((to(&kelvin(), &fahrenheit, true, 100.0) - 180.0).abs() < 1e-10);
    }

    #[test]
    fn what_is_another_quantity_or_unknown_does_not_convert() {
        let rpm = unit("rpm", [0, 0, -1, 0, 0, 0, 0, 1], std::f64::consts::TAU / 60.0, 0.0);
        let hertz = unit("Hz", [0, 0, -1, 0, 0, 0, 0, 0], 1.0, 0.0);
        let unknown = |name: &str| Unit { name: name.to_owned(), base: None, display_units: Vec::new() };
        assert_eq!(conversion(Some(&rpm), Some(&hertz), false), None);
        assert_eq!(conversion(Some(&unknown("a")), Some(&unknown("b")), false), None);
        assert_eq!(conversion(Some(&unknown("a")), Some(&unknown("a")), false), Some(Affine::IDENTITY));
        assert_eq!(conversion(Some(&rpm), None, false), Some(Affine::IDENTITY));
    }

    #[test]
    fn torque_times_speed_is_a_power_and_torque_times_angle_is_none() {
        let torque = unit("N.mm", [1, 2, -2, 0, 0, 0, 0, 0], 1e-3, 0.0);
        let speed = unit("rad/s", [0, 0, -1, 0, 0, 0, 0, 1], 1.0, 0.0);
        let angle = unit("rad", [0, 0, 0, 0, 0, 0, 0, 1], 1.0, 0.0);
        assert_eq!(watts(Some(&torque), Some(&speed)), Some(1e-3));
        assert_eq!(watts(Some(&torque), Some(&angle)), None);
        assert_eq!(watts(Some(&torque), None), None);
    }

    #[test]
    fn conversions_follow_each_other() {
        let twice = Affine { factor: 2.0, offset: 1.0 };
        let less = Affine { factor: 0.5, offset: -3.0 };
        assert_eq!(twice.then(less).of(4.0), less.of(twice.of(4.0)));
    }
}
