//! Whether exponents, factor and offset of a unit are those of its name.

use super::*;
use ::units::{Meaning, meanings, names};

/// Names that also stand for something else than a unit of the crate `units`: degree Celsius, acceleration of gravity, tonne, pressure,
/// radius, voltage, diameter, gauss, grain.
const AMBIGUOUS: [&str; 14] = ["C", "mC", "uC", "g", "mg", "ug", "T", "MT", "p", "r", "U", "d", "Gs", "gr"];
/// The same, but in a product with others: height, minutes and seconds of arc, fluid ounce, acidity, not applicable.
const AMBIGUOUS_ALONE: [&str; 6] = ["h", "min", "sec", "oz", "pH", "N/A"];
/// Units of several sizes.
const SEVERAL_SIZES: [&str; 3] = ["hp", "gr", "oz"];
/// Longest joined name that is read as a product: `kWh`, `mNms`.
const LONGEST_JOINED: usize = 4;
/// Rounding of an offset, K.
const OFFSET: f64 = 0.01;

/// A base unit as it is declared: SI value = factor * value + offset.
#[derive(Clone, Copy)]
pub(super) struct Declared {
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    exponents: [i128; 8],
    factor: f64,
    offset: f64,
}

impl Declared {
    pub(super) fn of(base: Node) -> Self {
        let exponent = |name: &str| base.attribute(name).and_then(parse_integer).unwrap_or(0);
        let number = |name, default| double(base, name).unwrap_or(default);
        let exponents = cosim::BaseUnit::NAMES.map(exponent);
        Declared { exponents, factor: number("factor", 1.0), offset: number("offset", 0.0) }
    }

    /// What a name says if it has one meaning.
    pub(super) fn named(name: &str) -> Option<Self> {
        let known = Known::of(name);
        let [only] = known.meanings[..] else { return None };
        known.is_sure.then(|| Declared {
            exponents: exponents(&only),
            factor: only.factor,
            offset: only.offset,
        })
    }

    /// The factors by which a turn that counts as 1 or as 2 pi may differ, if the exponents are those of a meaning. The radian may be left
    /// out, and a turn may be counted where the name has none.
    fn turns(&self, meaning: &Meaning, name: &str) -> Option<Vec<f64>> {
        let wanted = exponents(meaning);
        let (rad, own) = (wanted[7], self.exponents[7]);
        let is_alike =
            self.exponents[..7] == wanted[..7] && (own == rad || own == 0 || rad == 0 && own.abs() == 1);
        let power = i32::try_from(own - rad).ok().filter(|_| is_alike)?;
        let mut turns = vec![1.0, TAU.powi(power)];
        if name.contains("Hz") {
            turns.extend([TAU, 1.0 / TAU]);
        }
        if name.contains('%') {
            turns.extend([100.0, 0.01]);
        }
        Some(turns)
    }
}

const TAU: f64 = std::f64::consts::TAU;

fn exponents(meaning: &Meaning) -> [i128; 8] {
    let [kg, m, s, a, k, rad] = meaning.exponents.map(i128::from);
    [kg, m, s, a, k, 0, 0, rad]
}

/// What a name may mean.
struct Known {
    meanings: Vec<Meaning>,
    /// Whether there is no other meaning.
    is_sure: bool,
    /// Whether the size of each unit is known.
    has_size: bool,
}

impl Known {
    fn of(name: &str) -> Known {
        let parts = names(name);
        let is_literal = parts.iter().all(|(_, is_unit)| *is_unit);
        let is_one_of = |list: &[&str]| parts.iter().any(|(part, _)| list.contains(&part.as_str()));
        let is_joined = |(part, is_unit): &(String, bool)| *is_unit || part.len() <= LONGEST_JOINED;
        let mut all = if parts.iter().all(is_joined) { meanings(name) } else { Vec::new() };
        // `W/mK` is per metre and kelvin.
        for (part, _) in parts.iter().filter(|_| parts.len() > 1) {
            let rest = part.strip_prefix('m').unwrap_or_default();
            if names(rest).iter().any(|(_, is_unit)| *is_unit) {
                all.extend(meanings(&name.replacen(part, &format!("m.{rest}"), 1)));
            }
        }
        Known {
            meanings: all,
            is_sure: is_literal && !is_one_of(&AMBIGUOUS) && !AMBIGUOUS_ALONE.contains(&name),
            has_size: !is_one_of(&SEVERAL_SIZES),
        }
    }
}

/// Rounded factors are equal.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-3 * b.abs()
}

/// Ten digits of a computed number.
fn rounded(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}

/// Exponents, factor and offset of a unit are those of its name, if the name is a known one. The offset has no meaning if all quantities of
/// the unit are differences.
pub(super) fn check_meaning(
    model: &Model,
    base: Node,
    name: &str,
    is_of_differences: bool,
    out: &mut Findings,
) {
    let (declared, known) = (Declared::of(base), Known::of(name));
    let alike: Vec<(&Meaning, Vec<f64>)> =
        known.meanings.iter().filter_map(|m| Some((m, declared.turns(m, name)?))).collect();
    if let Some((wanted, _)) = alike.first() {
        // A number without dimension need not be converted.
        let is_plain = declared.exponents == [0; 8] && declared.factor == 1.0;
        let agrees = |(meaning, turns): &(&Meaning, Vec<f64>)| {
            let has_factor =
                is_plain || turns.iter().any(|turn| close(declared.factor, turn * meaning.factor));
            let without = is_of_differences && declared.offset == 0.0;
            has_factor && (without || (declared.offset - meaning.offset).abs() <= OFFSET)
        };
        if known.has_size && !alike.iter().any(agrees) {
            let what = format!("The unit \"{}\"", short(name));
            let written = (declared.factor, declared.offset);
            contradiction(model, base, &what, written, (wanted.factor, wanted.offset), out);
        }
    } else if let Some(wanted) = known.meanings.first().filter(|_| known.is_sure) {
        let (is, named) = (product(&declared.exponents), product(&exponents(wanted)));
        out.add(model.place(base), rules::unit_exponents(short(name), is, named));
    }
}

/// Unit -> SI -> display unit: each value is (SI value - offset) / factor.
pub(super) fn check_display(
    model: &Model,
    display: Node,
    name: &str,
    base: Declared,
    is_of_differences: bool,
    out: &mut Findings,
) {
    let display_name = display.attribute("name").unwrap_or_default();
    let known = Known::of(display_name);
    let (factor, offset) =
        (double(display, "factor").unwrap_or(1.0), double(display, "offset").unwrap_or(0.0));
    let alike: Vec<(&Meaning, Vec<f64>)> =
        known.meanings.iter().filter_map(|m| Some((m, base.turns(m, display_name)?))).collect();
    let offset_of = |meaning: &Meaning| (base.offset - meaning.offset) / meaning.factor;
    let agrees = |(meaning, turns): &(&Meaning, Vec<f64>)| {
        let without = is_of_differences && offset == 0.0;
        turns.iter().any(|turn| close(factor, base.factor / (turn * meaning.factor)))
            && (without || (offset - offset_of(meaning)).abs() <= OFFSET / meaning.factor.abs().min(1.0))
    };
    let Some((first, turns)) = alike.first().filter(|_| known.has_size && !alike.iter().any(agrees)) else {
        return;
    };
    let what = format!("The display unit \"{}\" of \"{}\"", short(display_name), short(name));
    // Where a turn may count as 1 or as 2 pi, the number that is nearer to what is written.
    let far = |turn: &&f64| (factor * **turn * first.factor / base.factor).abs().ln().abs();
    let turn = turns.iter().min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(&1.0);
    let wanted = (base.factor / (turn * first.factor), offset_of(first));
    contradiction(model, display, &what, (factor, offset), wanted, out);
}

/// `kg.m2.s-2`.
fn product(exponents: &[i128; 8]) -> String {
    let named = cosim::BaseUnit::NAMES.iter().zip(exponents).filter(|(_, exponent)| **exponent != 0);
    let all: Vec<String> = named
        .map(|(name, exponent)| if *exponent == 1 { (*name).to_owned() } else { format!("{name}{exponent}") })
        .collect();
    if all.is_empty() { "1".to_owned() } else { all.join(".") }
}

/// Factor and offset as written are not those of the name.
fn contradiction(
    model: &Model,
    node: Node,
    what: &str,
    (factor, offset): (f64, f64),
    (wanted_factor, wanted_offset): (f64, f64),
    out: &mut Findings,
) {
    // What is no number has been reported.
    if factor != 0.0 && factor.is_finite() && offset.is_finite() {
        let wanted = (rounded(wanted_factor), rounded(wanted_offset));
        out.add(model.place(node), rules::unit_contradiction(what, factor, offset, wanted.0, wanted.1));
    }
}
