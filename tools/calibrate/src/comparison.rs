//! Comparison of the repaired model with the plain refit and a black box: channels where it is not the best, with the likely reason.

use crate::experiment::Role;
use crate::levels::{AT_NOISE, STRUCTURE};
use crate::outcome::{BlackBox, ChannelError, Verdict};
use crate::report::column_words;

/// Channels in which the refit or the black box predicts the test runs better than the repaired model, in sentences. A search that the time
/// budget ended (`is_cut`) says nothing about the effects.
pub fn notes(errors: &[ChannelError], boxes: &[BlackBox], verdict: Verdict, is_cut: bool) -> Vec<String> {
    let of = |role: Role, column: &str| errors.iter().find(|e| e.role == role && e.column == column);
    let mut notes = Vec::new();
    for test in errors.iter().filter(|e| e.role == Role::Test) {
        let (name, unit) = column_words(test.column);
        let with_unit = |x: f64| with_unit(x, unit);
        if test.after <= AT_NOISE * test.floor {
            continue;
        }
        if test.after > (1.0 + STRUCTURE) * test.refit {
            let validated = of(Role::Validate, test.column).is_some_and(|v| v.after < v.refit);
            let reason = if validated {
                "the validation error of this channel falls, so the test runs contain conditions that neither fit nor validation runs have"
            } else {
                "the law was accepted for other channels, and this one has no part in it"
            };
            notes.push(format!(
                "{name}: the error of the repaired model on the test runs, {}, is above that of the refit, {}; {reason}",
                with_unit(test.after),
                with_unit(test.refit)
            ));
        }
        let Some((other, error)) = boxes.iter().find(|b| b.column == test.column).zip(test.blackbox) else {
            continue;
        };
        if test.after <= (1.0 + STRUCTURE) * error {
            continue;
        }
        let fit = of(Role::Fit, test.column).and_then(|f| Some((f.after, f.blackbox?)));
        let reason = match fit {
            Some((own, box_of_it)) if own > (1.0 + STRUCTURE) * box_of_it => format!(
                "it also follows the fit runs better ({} against {}), so the physical model lacks a path, a node or a dependence that free \
                 parameters can replace{}",
                with_unit(box_of_it),
                with_unit(own),
                if verdict == Verdict::Nothing && !is_cut { "; none of the listed effects is that one" } else { "" }
            ),
            Some(_) => "the physical model follows the fit runs at least as well, so the difference comes from conditions that the fit runs \
                        do not contain or from differences between the runs"
                .to_string(),
            None => "the fit runs have no reading of it".to_string(),
        };
        notes.push(format!(
            "{name}: a black box ({}) predicts the test runs better than the {} model, {} against {}; {reason}",
            other.kind,
            if matches!(verdict, Verdict::Nothing | Verdict::Fitted) { "fitted" } else { "repaired" },
            with_unit(error),
            with_unit(test.after)
        ));
    }
    notes
}

/// A number without the rounding error of a conversion between units.
pub fn converted(x: f64) -> f64 {
    /// Digits after the decimal point. Definition: more than any sensor has.
    const PLACES: f64 = 1e6;
    (x * PLACES).round() / PLACES
}

/// A number rounded to three significant digits.
pub fn digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_string();
    }
    let places = (2.0 - x.abs().log10().floor()).max(0.0) as usize;
    match x.abs() {
        size if !size.is_finite() => "no number".to_string(),
        size if size < 1e-4 => format!("{x:.2e}"),
        _ => format!("{x:.places$}"),
    }
}

/// Two different values with their unit, with as many digits, three or more, as show the difference.
pub fn apart(values: [f64; 2], unit: &str) -> [String; 2] {
    let differ = |places: &usize| {
        let [a, b] = values.map(|x| format!("{x:.*e}", places));
        a != b
    };
    let places: Option<usize> = (2..=7).find(differ);
    match places {
        None | Some(2) => values.map(|x| with_unit(x, unit)),
        Some(places) => values.map(|x| {
            let decimals = (places as f64 - x.abs().log10().floor()).max(0.0) as usize;
            with_unit_of(format!("{x:.decimals$}"), unit)
        }),
    }
}

fn with_unit_of(number: String, unit: &str) -> String {
    if matches!(unit, "" | "1") { number } else { format!("{number} {unit}") }
}

/// A number with three significant digits and its unit; a pure number (`1` of a parameter, blank of a column) has none.
pub fn with_unit(x: f64, unit: &str) -> String {
    with_unit_of(digits(x), unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Prediction;

    #[test]
    fn two_values_look_different() {
        assert_eq!(apart([0.03, 0.0293], "m"), ["0.0300 m", "0.0293 m"]);
        assert_eq!(apart([0.03, 0.030_012], "m"), ["0.03000 m", "0.03001 m"]);
        assert_eq!(apart([298.15, 298.3], "K"), ["298.1 K", "298.3 K"]);
        assert_eq!(apart([0.2, 0.200_04], "1"), ["0.20000", "0.20004"]);
    }

    fn error(role: Role, refit: f64, after: f64, blackbox: f64) -> ChannelError {
        let column = "winding_temperature_degC";
        let prediction = Prediction { half_width: 0.2, inside: 0.95 };
        ChannelError {
            role,
            column,
            before: 9.0,
            refit,
            after,
            floor: 0.1,
            instruments: 0.05,
            blackbox: Some(blackbox),
            prediction,
        }
    }

    #[test]
    fn numbers_have_three_digits() {
        let cases = [(0.0, "0"), (4.9977, "5.00"), (14675.3, "14675"), (1e-12, "1.00e-12")];
        cases.into_iter().for_each(|(x, text)| assert_eq!(digits(x), text));
        assert_eq!(["1", "", "s"].map(|unit| with_unit(0.25, unit)), ["0.250", "0.250", "0.250 s"]);
    }

    #[test]
    fn a_repair_that_is_not_the_best_is_named_with_its_reason() {
        let boxes = [BlackBox {
            column: "winding_temperature_degC",
            kind: "ARX of order 1".to_string(),
            errors: Vec::new(),
        }];
        let of = |errors: &[ChannelError]| notes(errors, &boxes, Verdict::Named, false).join("\n");
        let better = [error(Role::Fit, 2.0, 0.5, 1.0), error(Role::Test, 2.0, 0.5, 1.0)];
        assert_eq!(of(&better), "");
        let lacks = of(&[error(Role::Fit, 2.0, 1.5, 0.5), error(Role::Test, 2.0, 1.5, 0.75)]);
        assert!(lacks.contains("0.750 K against 1.50 K") && lacks.contains("lacks a path"), "{lacks}");
        let overfits = of(&[error(Role::Fit, 2.0, 0.5, 1.0), error(Role::Test, 2.0, 7.3, 8.0)]);
        assert!(
            overfits.contains("above that of the refit, 2.00 K") && !overfits.contains("black box"),
            "{overfits}"
        );
        let range = of(&[error(Role::Fit, 2.0, 0.5, 1.0), error(Role::Test, 4.0, 3.0, 1.0)]);
        assert!(range.contains("conditions that the fit runs do not contain"), "{range}");
        // At the noise floor no improvement is possible.
        assert_eq!(of(&[error(Role::Fit, 2.0, 0.1, 0.1), error(Role::Test, 0.12, 0.13, 0.1)]), "");
    }
}
