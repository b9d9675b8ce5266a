//! Texts as they are printed: what files, the console and programs read stays in ASCII, pages and figures have true minus signs and
//! numbers that stay with their units.

use crate::units::{is_unit, ten_to};

/// The space at which no line is broken.
pub(crate) const NO_BREAK: char = '\u{a0}';

/// The minus sign, which is as wide as a plus and is not broken from its number.
const MINUS: char = '\u{2212}';

/// A text for a page or a figure: minus signs in place of hyphens before numbers, powers of ten in place of `e-7`, and no line break
/// between a number and its unit. Words that are typed as they stand (`--option`, `key=value`) are left alone, and so are words with a
/// hyphen or a date.
pub fn typeset(text: &str) -> String {
    let mut written = String::new();
    let (mut before, mut is_first) = ("", true);
    for word in text.split(' ') {
        if !is_first {
            written.push(if belong_together(before, word) { NO_BREAK } else { ' ' });
        }
        written += &match is_typed(word) || before.starts_with("--") {
            true => word.to_owned(),
            false => with_signs(word),
        };
        (before, is_first) = (word, false);
    }
    written
}

/// Whether a word is one that is typed as it stands: an option, or a value that is assigned to a name.
pub(crate) fn is_typed(word: &str) -> bool {
    let word = word.trim_start_matches(['(', '\'', '"', '`', '“', '‘', '[']);
    let named = word.split_once('=').is_some_and(|(name, _)| name.contains(|c: char| c.is_alphabetic()));
    word.starts_with("--") || named
}

/// The number that a word is, between brackets and punctuation; the parts of the word are what stands before it, itself, and what follows.
fn number_in(word: &str) -> Option<(&str, &str, &str)> {
    let inner = word.trim_start_matches(['(', '[', '±', '~', '≈', '<', '>', '≤', '≥']);
    let head = &word[..word.len() - inner.len()];
    let number = inner.trim_end_matches([',', ';', ':', ')', ']', '.', '?', '!']);
    let is_number = number.contains(|c: char| c.is_ascii_digit())
        && number.chars().all(|c| c.is_ascii_digit() || "+-.eE−".contains(c))
        && number.replace(MINUS, "-").parse::<f64>().is_ok();
    is_number.then(|| (head, number, &inner[number.len()..]))
}

/// Whether no line is broken between two words: a number and its unit, and a sign of comparison and its number.
fn belong_together(before: &str, word: &str) -> bool {
    let closed = |word: &str| number_in(word).is_some_and(|(.., tail)| tail.is_empty());
    let unit = word.trim_end_matches([',', ';', ':', '.', '?', '!']);
    let is_a_unit = || is_unit(unit) || unit.strip_suffix(')').is_some_and(is_unit);
    match before {
        "=" | "±" | "≈" | "<" | ">" | "≤" | "≥" | "×" => number_in(word).is_some(),
        _ => closed(before) && is_a_unit(),
    }
}

/// A word with the signs of its numbers.
fn with_signs(word: &str) -> String {
    if let Some((head, number, tail)) = number_in(word)
        && let Some((digits, power)) = number.split_once(['e', 'E'])
        && let Ok(power) = power.parse::<i32>()
    {
        let digits = digits.replace('-', "\u{2212}");
        return format!("{head}{digits}{NO_BREAK}×{NO_BREAK}{}{tail}", ten_to(power));
    }
    let all: Vec<char> = word.chars().collect();
    let is_sign = |k: usize| {
        let begins = k == 0 || "([±,;:…|<>≤≥~≈=".contains(all[k - 1]);
        let digit = |k: usize| all.get(k).is_some_and(char::is_ascii_digit);
        all[k] == '-' && begins && (digit(k + 1) || all.get(k + 1) == Some(&'.') && digit(k + 2))
    };
    (0..all.len()).map(|k| if is_sign(k) { MINUS } else { all[k] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_signs() {
        for (given, expected) in [
            ("-48", "−48"),
            ("supply −3, limit (-30)", "supply −3, limit (−30)"),
            ("from -0.08 to -.5, +1.8,-1.7", "from −0.08 to −.5, +1.8,−1.7"),
            // No numbers with a sign: a motor, a file, a date, a range.
            ("maxon-re40-148877 run-4.csv 2029-11-28 3-5", "maxon-re40-148877 run-4.csv 2029-11-28 3-5"),
            ("1.53e-66", "1.53\u{a0}×\u{a0}10⁻⁶⁶"),
            ("(-2e5,", "(−2\u{a0}×\u{a0}10⁵,"),
            ("", ""),
            (" two  spaces ", " two  spaces "),
        ] {
            assert_eq!(typeset(given), expected);
        }
    }

    /// Whoever copies a command out of a page must be able to run it.
    #[test]
    fn what_is_typed_is_left_alone() {
        for text in
            ["--set load_torque=-0.5 frees it", "--stop -1", "(voltage=-5)", "--vary x=1e-7:2e-7:3", "'k=-1'"]
        {
            assert_eq!(typeset(text), text);
        }
    }

    #[test]
    fn numbers_stay_with_their_units() {
        for (given, expected) in [
            ("at 100 %", "at 100\u{a0}%"),
            ("power = 0 W.", "power =\u{a0}0\u{a0}W."),
            ("5 N·m, 3 K and (12 1/min)", "5\u{a0}N·m, 3\u{a0}K and (12\u{a0}1/min)"),
            ("7 of 12 runs, 3 4", "7 of 12 runs, 3 4"),
            ("at 5, A and B", "at 5, A and B"),
        ] {
            assert_eq!(typeset(given), expected);
        }
    }
}
