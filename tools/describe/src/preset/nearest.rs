//! The known names that an unknown one may mean.

/// Cost of an edit, in units of a letter that the name lacks.
const EDIT: usize = 10;
/// Names that are listed.
const MOST: usize = 3;

/// The question for the most similar of the known names; empty if there is none that differs in at most one letter of four.
///
/// A part of a known name, from the beginning of one of its words, may be meant: `maxon-re25` is two presets, `mass` is `motor.mass`.
/// Where the unknown name is such a part of several, up to three are named, the shortest first.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let scored = known.map(|candidate| (cost(name, candidate), candidate));
    let mut scored: Vec<(usize, &str)> = scored.filter_map(|(cost, name)| Some((cost?, name))).collect();
    scored.sort_by_key(|(cost, _)| *cost);
    let Some(best) = scored.first() else { return String::new() };
    // A name without a typing error is a part of all of these.
    let is_part = |text: &str| text.to_lowercase().contains(&name.to_lowercase());
    let several = if !name.is_empty() && is_part(best.1) { MOST } else { 1 };
    let names: Vec<&str> = scored
        .iter()
        .enumerate()
        .filter(|(k, s)| *k == 0 || is_part(s.1))
        .map(|(_, s)| s.1)
        .take(several)
        .collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("; did you mean {} or {last}?", rest.join(", ")),
        _ => format!("; did you mean {}?", best.1),
    }
}

/// Edits from the name to a part of the candidate that begins with a word, and the letters of the candidate outside that part; `None` for
/// another name.
fn cost(name: &str, candidate: &str) -> Option<usize> {
    let (name, letters) = (name.to_lowercase(), candidate.to_lowercase());
    let (name, letters): (Vec<char>, Vec<char>) = (name.chars().collect(), letters.chars().collect());
    let starts = (0..letters.len()).filter(|k| *k == 0 || !letters[k - 1].is_alphanumeric());
    let parts = starts.map(|start| (start, to_prefixes(&name, &letters[start..])));
    let costs = parts.flat_map(|(start, edits)| {
        let left = letters.len() - start;
        edits.into_iter().enumerate().map(move |(k, edits)| (edits, EDIT * edits + start + left - k))
    });
    costs.filter(|(edits, _)| 4 * edits <= name.len()).map(|(_, cost)| cost).min()
}

/// Edits from the name to each prefix of the letters: the last row of the matrix of edit distances.
fn to_prefixes(name: &[char], letters: &[char]) -> Vec<usize> {
    let mut row: Vec<usize> = (0..=letters.len()).collect();
    for (k, c) in name.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = k + 1;
        for (j, l) in letters.iter().enumerate() {
            let change = diagonal + usize::from(c != l);
            diagonal = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_and_typing_errors_are_recognized() {
        let known = [
            "duty",
            "maxon-305015",
            "maxon-re25-118743",
            "maxon-re25-118752",
            "maxon-re40-148877",
            "motor.mass",
            "gait.body_mass",
            "load_torque",
            "motor.R_ref",
        ];
        for (name, meant) in [
            ("maxon-re25", "maxon-re25-118743 or maxon-re25-118752"),
            ("maxon-re26", "maxon-re25-118743"),
            ("Maxon-RE40", "maxon-re40-148877"),
            ("mass", "motor.mass or gait.body_mass"),
            ("load", "load_torque"),
            ("dutty", "duty"),
            ("motor.R_reff", "motor.R_ref"),
            ("gait.bodymass", "gait.body_mass"),
            ("R_ref", "motor.R_ref"),
        ] {
            assert_eq!(nearest(name, known.into_iter()), format!("; did you mean {meant}?"), "{name}");
        }
        for other in ["x", "foo", "preset", "nonsense"] {
            assert_eq!(nearest(other, known.into_iter()), "", "{other}");
        }
        assert_eq!(nearest("x", std::iter::empty()), "");
    }
}
