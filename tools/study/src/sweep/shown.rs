//! Units of the numbers in texts and figures of a sweep. Results as data (CSV, JSON) are in SI units.

use physics::declare::Unit;
use units::Conversion;

/// A unit in which the numbers of a quantity are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    unit: String,
    to_si: Conversion,
}

impl Shown {
    /// The SI unit of this name.
    pub fn si(unit: &str) -> Shown {
        Shown { unit: unit.to_owned(), to_si: units::unchanged() }
    }

    /// The unit in which an option gave the numbers, with its conversion to the SI unit.
    pub fn given(unit: &str, to_si: Conversion) -> Shown {
        Shown { unit: unit.to_owned(), to_si }
    }

    /// The display unit of an output with the SI unit of this name; a difference keeps the SI unit.
    pub fn display(unit: &'static str, is_difference: bool) -> Shown {
        let known = Unit::ALL.iter().find(|known| known.name() == unit && !is_difference);
        let display = known.and_then(|known| known.display()).map(|display| display.name);
        let shown =
            display.and_then(|name| Some(Shown::given(name, units::conversion(name, unit, false).ok()?)));
        shown.unwrap_or_else(|| Shown::si(unit))
    }

    /// The number of a value in SI units.
    pub fn of(&self, si: f64) -> f64 {
        self.to_si.back(si)
    }

    /// The unit behind a separator; a pure number has none.
    pub fn unit(&self, separator: &str) -> String {
        if self.unit == "1" { String::new() } else { format!("{separator}{}", self.unit) }
    }
}

#[cfg(test)]
mod tests {
    use crate::steady::Setup;
    use crate::sweep::{Case, ConstantInputs, Goal, Sweep, Vary, sweep};

    fn found(vary: &str, objective: &str) -> Sweep {
        let case = ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, &[]) };
        let vary = Vary::parse(vary).unwrap().resolved(|name, unit| case.conversion(name, unit)).unwrap();
        sweep(&case, &[vary], &Goal::of(objective), |_| {}).unwrap()
    }

    /// Numbers are shown in the unit in which they were given, outputs in their display unit; data are in SI units.
    #[test]
    fn numbers_return_in_their_unit() {
        for (vary, objective, values, axes) in [
            (
                "ambient_temperature=20:40 degC:3",
                "winding_temperature",
                "20 degC, 30 degC, 40 degC",
                ["°C", "°C"],
            ),
            ("ambient_temperature=68:104 degF:2", "winding_margin", "68 degF, 104 degF", ["°F", "K"]),
            ("ambient_temperature=300,310", "winding_temperature", "300 K, 310 K", ["K", "°C"]),
            ("ambient_temperature=20 degC,300 K", "winding_temperature", "293.1 K, 300 K", ["K", "°C"]),
            (
                "imposed_speed=0:3000 rpm:4",
                "shaft_speed",
                "0 rpm, 1000 rpm, 2000 rpm, 3000 rpm",
                ["rpm", "rpm"],
            ),
            ("fan_command=0:1:2", "current", "0, 1", ["fan command", "A"]),
        ] {
            let found = found(vary, objective);
            let shown: Vec<String> =
                found.points.iter().map(|p| p.values[0].with_unit(&found.shown[0])).collect();
            assert_eq!(shown.join(", "), values, "{vary}");
            let figure = found.figure().unwrap().svg();
            for axis in axes {
                let unit = |text: &str| text.ends_with(&format!(" in {axis}")) || text == axis;
                assert!(figure.split(['<', '>']).any(unit), "{vary}: {axis}");
            }
        }
        // A value of 1 is no unit, and a symbol is explained.
        let case = ConstantInputs { setup: Setup::new("AnnulusCooledMotor", None, &[]) };
        let vary = ["motor.R_ref=0.3:0.5:2", "fan_command=0,1"].map(|v| Vary::parse(v).unwrap());
        let goal = Goal {
            objectives: vec!["winding_temperature".into(), "current:max".into()],
            ..Goal::of("winding_temperature")
        };
        let figure = sweep(&case, &vary, &goal, |_| {}).unwrap().figure().unwrap();
        let labels: Vec<&str> = figure.series().map(|(label, _)| label).collect();
        assert_eq!(labels, ["fan command = 0", "fan command = 1"].repeat(2));
        let svg = figure.svg();
        for text in [
            "Terminal resistance at T_ref",
            " (motor.R_ref) in",
            "winding temperature and current over motor.R_ref",
        ] {
            assert!(svg.contains(text), "{text}: {svg}");
        }
        let data = found("ambient_temperature=20:40 degC:3", "winding_temperature").csv();
        assert!(data.contains("2.9314999999999998e2,2.93"), "{data}");
    }
}
