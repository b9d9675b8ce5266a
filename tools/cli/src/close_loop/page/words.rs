//! Sentences for a person: the keys of columns, parameters, effects, ports and drivers become words. What has to be typed stays a key.

use super::super::text::plain;
use calibrate::experiment::{Channel, Experiment};
use calibrate::report::column_words;
use describe::{Declaration, Driver, Entry, Port};
use maud::{Markup, html};
use present::check::is_key;
use present::typeset;

/// What the keys of a page are of.
#[derive(Clone, Copy)]
pub struct Words<'a> {
    pub experiment: &'a Experiment,
    pub declaration: &'a Declaration,
}

enum Piece {
    Text(String),
    Code(String),
}

/// Pieces as they stand on the page.
fn markup(pieces: Vec<Piece>) -> Markup {
    // Texts in one, since a number stays with its unit.
    let mut joined: Vec<Piece> = Vec::new();
    for piece in pieces {
        match (joined.last_mut(), piece) {
            (Some(Piece::Text(all)), Piece::Text(text)) => *all += &text,
            (_, piece) => joined.push(piece),
        }
    }
    html! { @for piece in joined { @match piece {
        Piece::Text(text) => { (typeset(&text)) },
        Piece::Code(key) => { code { (key) } },
    } } }
}

/// Units of which those in sentences consist.
const UNITS: [&str; 20] = [
    "A", "degC", "degF", "degR", "g", "h", "J", "K", "kg", "m", "mA", "min", "mV", "N", "Ohm", "Pa", "rad",
    "s", "V", "W",
];

/// Whether a word is a unit.
fn is_unit(word: &str) -> bool {
    word.split(['.', '/', '(', ')'])
        .all(|part| UNITS.contains(&part.trim_end_matches(|c: char| c.is_ascii_digit())))
}

/// The last word of pieces that a space follows.
fn pieces_end(pieces: &[Piece]) -> Option<&str> {
    match pieces {
        [.., Piece::Text(word), Piece::Text(space)] if space == " " => Some(word),
        _ => None,
    }
}

/// A text with spaces in place of the underscores of its keys.
fn without_keys(text: &str) -> String {
    let word = |word: &str| if is_key(word) { plain(word) } else { word.to_owned() };
    text.trim().split(' ').map(word).collect::<Vec<_>>().join(" ")
}

impl Words<'_> {
    /// What a parameter is: the first clause of its description, which is followed by what switches it off. The numbers of a law, which is
    /// no variable, are described by their symbols.
    pub fn meaning(&self, name: &str) -> String {
        if let Some(entry) = self.declaration.by_name(name) {
            return without_keys(entry.row.doc.split(';').next().unwrap_or_default());
        }
        match name.trim_start_matches("effect.").trim_start_matches(LAW) {
            "coefficient" => "Value of the law where each driver is at its reference".to_owned(),
            "exponent" => "Power of the driver".to_owned(),
            "tau" => "Time constant of the lag".to_owned(),
            other if other.starts_with("value at ") => "Value of the law at this point".to_owned(),
            _ => String::new(),
        }
    }

    /// A sentence in words, with keys that have to be typed as code.
    pub fn sentence(&self, text: &str) -> Markup {
        markup(self.pieces(text))
    }

    /// A note as a sentence: with a capital letter, unless it begins with a name, and a full stop.
    pub fn note(&self, text: &str) -> Markup {
        let text = text.trim();
        let stop = if text.ends_with(['.', '!', '?']) { "" } else { "." };
        let first = text.split([' ', ':']).next().unwrap_or_default();
        let is_word = first.chars().all(|c| c.is_alphabetic() || c == '_');
        let mut pieces = self.pieces(text);
        let begin = pieces.iter_mut().find(|piece| !matches!(piece, Piece::Text(text) if text.is_empty()));
        if let (true, Some(Piece::Text(begin))) = (is_word, begin) {
            *begin = super::capital(begin);
        }
        html! { (markup(pieces)) (stop) }
    }

    /// The same as text.
    pub fn text(&self, text: &str) -> String {
        let plain = |piece| match piece {
            Piece::Text(text) => text,
            Piece::Code(key) => without_keys(&key),
        };
        self.pieces(text).into_iter().map(plain).collect()
    }

    fn pieces(&self, text: &str) -> Vec<Piece> {
        let is_of_name = |c: char| c.is_alphanumeric() || "_.-/".contains(c);
        let (mut pieces, mut described): (Vec<Piece>, Vec<&str>) = (Vec::new(), Vec::new());
        let mut rest = text;
        while let Some(from) = rest.find(is_of_name) {
            let is_value = rest[..from].trim_end().ends_with('=');
            pieces.push(Piece::Text(rest[..from].to_owned()));
            let end = rest[from..].find(|c| !is_of_name(c)).map_or(rest.len(), |k| from + k);
            // A point or a dash at the end is one of the sentence.
            let name = match rest[from..end].trim_end_matches(['.', '-', '/']) {
                "" => &rest[from..end],
                name => name,
            };
            rest = &rest[from + name.len()..];
            // Behind a number, or as in "readings in degF".
            let before = pieces_end(&pieces).unwrap_or_default();
            if (before == "in" || before.parse::<f64>().is_ok()) && is_unit(name) {
                pieces.push(Piece::Text(present::words::unit(name)));
                continue;
            }
            let is_first = !described.contains(&name);
            described.push(name);
            pieces.extend(self.of_name(name, is_first, is_value || rest.trim_start().starts_with('=')));
        }
        pieces.push(Piece::Text(rest.to_owned()));
        pieces
    }

    /// A name in a sentence; `is_set` where a value follows it, or where it is the value.
    fn of_name(&self, name: &str, is_first: bool, is_set: bool) -> Vec<Piece> {
        let text = |text: String| vec![Piece::Text(text)];
        let Experiment { inputs, outputs, runs, .. } = self.experiment;
        if name == "time_s" {
            return text("time".to_owned());
        }
        if inputs.iter().chain(outputs).any(|c| c.column == name) || Channel::of(name).is_some() {
            return text(column_words(name).0);
        }
        if runs.iter().any(|run| run.file == name) {
            return text(name.to_owned());
        }
        if name.contains('.') {
            let full = format!("effect.{name}");
            let meaning = [name, &full].into_iter().map(|name| self.meaning(name)).find(|m| !m.is_empty());
            return match meaning {
                Some(meaning) if name.starts_with(LAW) => text(lower(&meaning)),
                Some(meaning) if is_first => vec![
                    Piece::Text(format!("{} (", lower(&meaning))),
                    Piece::Code(name.to_owned()),
                    Piece::Text(")".to_owned()),
                ],
                Some(_) => vec![Piece::Code(name.to_owned())],
                None => text(name.to_owned()),
            };
        }
        let of_effect = format!("effect.{name}.");
        let is_known = || {
            let is_entry = |e: &Entry| e.name == name || e.name.starts_with(&of_effect);
            self.declaration.entries.iter().any(is_entry)
                || Port::ALL.iter().any(|port| port.name() == name)
                || Driver::ALL.iter().any(|driver| driver.name() == name)
        };
        match is_key(name) {
            true if !is_set && is_known() => text(plain(name)),
            true => vec![Piece::Code(name.to_owned())],
            false => text(name.to_owned()),
        }
    }
}

/// Before the symbol of a number of a law.
const LAW: &str = "generic_term.";

/// A description within a sentence.
fn lower(text: &str) -> String {
    let mut letters = text.chars();
    match (letters.next(), letters.next()) {
        (Some(first), Some(second)) if second.is_lowercase() => {
            first.to_lowercase().chain(std::iter::once(second)).chain(letters).collect()
        }
        _ => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::close_loop::sample;

    /// A note is a sentence; the name of a file stays as it is.
    #[test]
    fn notes_are_sentences() {
        let experiment = sample::experiment();
        let declaration = (describe::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
        let words = Words { experiment: &experiment, declaration };
        for (note, text) in [
            ("run-1.csv: voltage_V has a spike at 3 s", "run-1.csv: voltage has a spike at 3 s."),
            ("the fit runs disagree.", "The fit runs disagree."),
            ("iron_loss acts in some runs only", "Iron loss acts in some runs only."),
        ] {
            assert_eq!(words.note(note).into_string(), typeset(text));
        }
        let begin = words.note("thermal.C_w = 5 J/K is at its limit").into_string();
        assert!(
            begin.starts_with("heat capacity of the winding (<code>") && begin.ends_with("limit."),
            "{begin}"
        );
    }

    /// Each kind of key in the sentences of a report; a parameter is described once and keeps its key, which a user types.
    #[test]
    fn keys_become_words() {
        let experiment = sample::experiment();
        let declaration = (describe::models::by_name("AnnulusCooledMotor").unwrap().declaration)();
        let words = Words { experiment: &experiment, declaration };
        for (sentence, text) in [
            (
                "run-1.csv: housing_temperature_degC reads -40 degC.",
                "run-1.csv: housing temperature reads -40 °C.",
            ),
            (
                "winding_sensor_stem_loss acts in some runs only",
                "winding sensor stem loss acts in some runs only",
            ),
            ("drag_torque ~ speed^0.75", "drag torque ~ speed^0.75"),
            ("ambient_pressure has no effect", "ambient pressure has no effect"),
            ("generic_term.exponent = 5.00", "power of the driver = 5.00"),
            ("a gap - of 3 s", "a gap - of 3 s"),
            ("a constant in V.s/rad, readings in degF", "a constant in V·s/rad, readings in °F"),
            ("in run-2.csv, in e.g. a box", "in run-2.csv, in e.g. a box"),
        ] {
            assert_eq!(words.text(sentence), text);
            assert_eq!(words.sentence(sentence).into_string(), typeset(text));
        }
        let sentence = words
            .sentence("thermal.C_w = 5 J/K is at its limit: add thermal.C_w to [prior]")
            .into_string()
            .replace('\u{a0}', " ");
        assert_eq!(
            sentence,
            "heat capacity of the winding (<code>thermal.C_w</code>) = 5 J/K is at its limit: add <code>thermal.C_w</code> to [prior]"
        );
        let set = words.sentence("set drive_mode=pwm, or mechanical_mode = imposed_speed").into_string();
        for key in
            ["<code>drive_mode</code>=pwm", "<code>mechanical_mode</code> = <code>imposed_speed</code>"]
        {
            assert!(set.contains(key), "{set}");
        }
    }
}
