//! Names of variables and units as people write them.

use crate::typeset::is_typed;
use crate::units::raised;

/// Quantities that stand first in names, and are last in words: `loss_copper` is the copper loss.
const QUANTITIES: [&str; 5] = ["energy", "loss", "power", "voltage", "work"];
/// Words that keep their place behind a quantity.
const ATTRIBUTES: [&str; 7] = ["balance", "command", "demand", "density", "error", "limit", "sensor"];
/// Statistics that stand last in names, and are first in words.
const STATISTICS: [(&str, &str); 4] = [("rms", "rms"), ("peak", "peak"), ("mean", "mean"), ("end", "final")];

/// Whether a part of a name is a word, and no symbol such as `R` or `tau1`.
pub fn is_word(part: &str) -> bool {
    part.len() > 1 && part.bytes().all(|b| b.is_ascii_lowercase())
}

/// A name of a variable in words, behind those of its component.
pub fn words(name: &str) -> String {
    let (component, own) = name.rsplit_once('.').unwrap_or(("", name));
    let mut parts: Vec<&str> = own.split('_').filter(|part| !part.is_empty()).collect();
    let are_two = parts.len() == 2;
    if let [quantity, kind, ..] = parts[..]
        && QUANTITIES.contains(&quantity)
        && !ATTRIBUTES.contains(&kind)
    {
        // An adjective goes before its noun, and so does a single noun; of several nouns the quantity is the head.
        match kind.ends_with("al") || kind.ends_with("ic") || are_two {
            true => parts.swap(0, 1),
            false => parts.insert(1, "of"),
        }
    }
    if let [.., last] = parts[..]
        && parts.len() > 1
        && let Some((_, first)) = STATISTICS.iter().find(|(end, _)| *end == last)
    {
        parts.pop();
        parts.insert(0, first);
    }
    format!("{} {}", component.replace(['_', '.'], " "), parts.join(" ")).trim_start().to_owned()
}

/// Symbols that programs write in letters.
const LETTERS: [(&str, &str); 5] =
    [("degC", "°C"), ("degF", "°F"), ("degR", "°R"), ("Ohm", "Ω"), ("ohm", "Ω")];

/// A text with the symbols of units in place of the letters that programs write; ohmic is no unit.
fn symbols(text: &str) -> String {
    let mut written = String::new();
    let mut rest = text;
    while let Some(begin) = rest.find(|c: char| c.is_alphabetic()) {
        let end = rest[begin..].find(|c: char| !c.is_alphabetic()).map_or(rest.len(), |k| begin + k);
        let word = &rest[begin..end];
        let known = LETTERS.iter().find_map(|(letters, symbol)| {
            let prefix = word.strip_suffix(letters)?;
            // Resistances have prefixes.
            let is_prefix = prefix.is_empty() || *symbol == "Ω" && ["m", "k", "M", "µ"].contains(&prefix);
            is_prefix.then(|| format!("{prefix}{symbol}"))
        });
        written += &rest[..begin];
        written += known.as_deref().unwrap_or(word);
        rest = &rest[end..];
    }
    written + rest
}

/// A unit, or a text with units, in the usual notation: `N.m` is N·m, `W/K4` is W/K⁴, `s0.5` is s^0.5, `degC` is °C. A pure
/// number has none.
pub fn unit(text: &str) -> String {
    if text == "1" {
        return String::new();
    }
    let all: Vec<char> = symbols(text).chars().collect();
    let is = |k: usize, of: fn(&char) -> bool| all.get(k).is_some_and(of);
    let is_digit = |k: usize| is(k, char::is_ascii_digit);
    let (mut written, mut k) = (String::new(), 0);
    while k < all.len() {
        // Digits after a letter are its exponent, and a point within them is a decimal point. H2O has no exponent.
        let is_part = |e: &usize| is_digit(*e) || (all[*e] == '.' && is_digit(*e + 1));
        let end = (k..all.len()).find(|e| !is_part(e)).unwrap_or(all.len());
        let is_exponent =
            k > 0 && is_digit(k) && all[k - 1].is_alphabetic() && !is(end, |c| c.is_alphabetic());
        match all[k] {
            _ if is_exponent && all[k..end].contains(&'.') => {
                written.push('^');
                written.extend(&all[k..end]);
            }
            _ if is_exponent => written.extend(all[k..end].iter().copied().map(raised)),
            _ if is_digit(k) => written.extend(&all[k..end]),
            '.' if k > 0 && is(k + 1, |d| d.is_alphabetic() || *d == '(') => written.push('·'),
            other => written.push(other),
        }
        k = if is_digit(k) { end } else { k + 1 };
    }
    written
}

/// Ends of names of files, which are no variables.
const FILES: [&str; 9] = ["csv", "toml", "json", "html", "svg", "png", "fmu", "txt", "md"];

/// A sentence with its names of variables in words and its units in the usual notation, behind numbers and behind "in". An option, its
/// value and an assignment (`--set load_torque=1`) stay as they are typed.
pub fn sentence(text: &str) -> String {
    let is_file = |name: &str| name.rsplit_once('.').is_some_and(|(_, end)| FILES.contains(&end));
    let is_degree = |name: &str| ["degC", "degF", "degR"].contains(&name);
    let (mut after_option, mut after_number, mut after_in) = (false, false, false);
    let is_unit = |part: &str| crate::units::is_unit(&unit(part.trim_matches([',', ';', ':', '.'])));
    let parts = text.split(' ').map(|part| {
        let name = part.trim_matches(|c: char| !c.is_ascii_alphanumeric());
        let is_name = name.contains('_') && name.split(['_', '.']).all(is_word) && !is_file(name);
        let written = match is_typed(part) || after_option {
            true => part.to_owned(),
            false if is_name => part.replace(name, &words(name)),
            // "in the" is no unit, "in degF" and "in V.s/rad" are.
            false if after_number || after_in && is_unit(part) || is_degree(name) => unit(part),
            false => part.to_owned(),
        };
        after_option =
            part.trim_start_matches(['(', '\'', '"', '`']).starts_with("--") && !part.contains('=');
        let number = part.trim_start_matches(['(', '±', '-', '−']);
        (after_number, after_in) = (number.parse::<f64>().is_ok(), part == "in");
        written
    });
    parts.collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_in_the_order_of_english() {
        for (name, expected) in [
            ("power_electrical", "electrical power"),
            ("loss_copper", "copper loss"),
            ("energy_heat_to_ambient", "energy of heat to ambient"),
            ("energy_electrical_drawn", "electrical energy drawn"),
            ("energy_balance_error", "energy balance error"),
            ("power_demand", "power demand"),
            ("voltage", "voltage"),
            ("voltage_peak", "peak voltage"),
            ("joint_torque_error_rms", "rms joint torque error"),
            ("winding_temperature_end", "final winding temperature"),
            ("torque_constant", "torque constant"),
            ("transmission.ratio", "transmission ratio"),
            ("effect.coulomb_friction.tau_c", "effect coulomb friction tau c"),
        ] {
            assert_eq!(words(name), expected);
        }
    }

    #[test]
    fn sentences_have_no_keys() {
        for (given, expected) in [
            ("loss_copper = 3 W/m2 (270.0 degC);", "copper loss = 3 W/m² (270.0 °C);"),
            ("validity.winding_temperature, walk.toml", "validity winding temperature, walk.toml"),
            // What is typed stays as it is typed.
            (
                "--set load_torque=... leaves load_torque free (or imposed_speed=0)",
                "--set load_torque=... leaves load torque free (or imposed_speed=0)",
            ),
            ("--vary fan_command gives fan_command,", "--vary fan_command gives fan command,"),
            (
                "'--outputs joint_torque', the file walk_cycle.csv",
                "'--outputs joint_torque', the file walk_cycle.csv",
            ),
            (
                "readings in degF, constant in V.s/rad, in the end, in e.g. this (as of degF)",
                "readings in °F, constant in V·s/rad, in the end, in e.g. this (as of °F)",
            ),
            ("thermal.T_w_max of maxon-re40-148877", "thermal.T_w_max of maxon-re40-148877"),
        ] {
            assert_eq!(sentence(given), expected);
        }
    }

    #[test]
    fn units_have_dots_and_exponents() {
        for (given, expected) in [
            ("N.m", "N·m"),
            ("degC", "°C"),
            ("W/(m2.K)", "W/(m²·K)"),
            ("m3/s", "m³/s"),
            ("W/K4", "W/K⁴"),
            ("N.m.s0.5/rad0.5", "N·m·s^0.5/rad^0.5"),
            ("N.m.s^0.5", "N·m·s^0.5"),
            ("1/K", "1/K"),
            ("1", ""),
            ("mmH2O", "mmH2O"),
            ("1/min", "1/min"),
            ("0.1 N.m at 12.5 degC.", "0.1 N·m at 12.5 °C."),
            ("Ohm", "Ω"),
            ("ohm.m, mOhm, kohm", "Ω·m, mΩ, kΩ"),
            ("degF", "°F"),
            ("80 degR", "80 °R"),
            ("ohmic Ohmmeter", "ohmic Ohmmeter"),
            ("rpm", "rpm"),
            ("deg/s", "deg/s"),
        ] {
            assert_eq!(unit(given), expected);
        }
    }
}
