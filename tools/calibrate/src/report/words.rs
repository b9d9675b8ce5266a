//! Keys and counts as words of a sentence.

use crate::experiment::Role;

/// An id as words: `iron_loss` is iron loss.
pub fn words(id: &str) -> String {
    id.replace('_', " ")
}

/// A count with its noun: 1 reading, 3 readings.
pub fn count_of(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// Readable name of a column without its unit, and the unit of a difference in it.
pub fn column_words(column: &str) -> (String, &'static str) {
    // An end that contains another one comes first.
    for (end, unit) in [
        ("rad_per_s", "rad/s"),
        ("m3_per_s", "m³/s"),
        ("Nm_per_A", "N·m/A"),
        ("Nm_per_kg", "N·m/kg"),
        ("degC", "K"),
        ("Nm", "N·m"),
        ("Pa", "Pa"),
        ("Ohm", "Ω"),
        ("rad", "rad"),
        ("J", "J"),
        ("V", "V"),
        ("A", "A"),
        ("W", "W"),
        ("1", ""),
    ] {
        if let Some(name) = column.strip_suffix(end).and_then(|name| name.strip_suffix('_')) {
            return (words(name), unit);
        }
    }
    (words(column), "")
}

/// Name of a role in experiments and reports.
pub fn role_name(role: Role) -> &'static str {
    match role {
        Role::Fit => "fit",
        Role::Validate => "validate",
        Role::Test => "test",
    }
}

/// A role in a sentence.
pub fn role_words(role: Role) -> &'static str {
    match role {
        Role::Validate => "validation",
        Role::Fit | Role::Test => role_name(role),
    }
}

#[cfg(test)]
mod tests {
    use super::{column_words, count_of};
    use crate::experiment::CHANNELS;

    #[test]
    fn counts_agree_with_their_nouns() {
        assert_eq!([0, 1, 2].map(|n| count_of(n, "reading")), ["0 readings", "1 reading", "2 readings"]);
    }

    /// No column keeps its unit as a word of its name.
    #[test]
    fn columns_are_words_with_a_unit() {
        for channel in CHANNELS.iter() {
            let (name, unit) = column_words(channel.column);
            assert_eq!(name, channel.quantity().replace('_', " "), "{} {unit}", channel.column);
        }
    }
}
