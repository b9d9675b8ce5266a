//! Decimal marks and thousands separators of the numbers of a table.

/// Fewest numbers with a mark that decide. A program that omits trailing zeros writes three decimals in nine of ten numbers with at most
/// three: all of 44 have them with a probability of 1 %.
pub(crate) const MANY: usize = 44;

/// What a cell says of its column's mark.
pub(crate) enum Grouping {
    None,
    /// A whole number from 1 to 999.
    Whole,
    Thousands,
}

/// `None` for a number that has another decimal mark than a thousands separator.
pub(crate) fn grouping(cell: &str) -> Option<Grouping> {
    let digits = cell.trim_start_matches(['-', '+']);
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let has_letters = digits.contains(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E'));
    if !digits.starts_with(|first: char| first.is_ascii_digit()) || digits == "0" || has_letters {
        // Blank, not a number in any notation such as a unit (1/min), or zero.
        return Some(Grouping::None);
    }
    let mut groups = digits.split([',', '.']);
    groups.next().filter(|lead| is_number(lead) && lead.len() <= 3 && !lead.starts_with('0'))?;
    if !digits.contains([',', '.']) {
        return Some(Grouping::Whole);
    }
    groups.all(|group| group.len() == 3 && is_number(group)).then_some(Grouping::Thousands)
}

/// The decimal mark of a number, as far as the number alone shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A decimal comma: it is the only mark, and the digits behind it are no group of thousands.
    Comma,
    /// A decimal point, or marks of both kinds.
    Point,
    /// No mark, one comma before three digits, or no number.
    Unknown,
}

/// The mark of a cell.
pub(crate) fn mark(cell: &str) -> Mark {
    let digits = cell.trim_start_matches(['-', '+', '\u{2212}']);
    let is_number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | '-' | '+' | 'e' | 'E');
    if !digits.starts_with(|c: char| c.is_ascii_digit()) || !digits.chars().all(is_number) {
        return Mark::Unknown;
    }
    match digits.split_once(',') {
        _ if digits.contains('.') => Mark::Point,
        Some((whole, rest)) if !rest.contains(',') => {
            let decimals = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
            if decimals == 3 && !whole.starts_with('0') { Mark::Unknown } else { Mark::Comma }
        }
        _ => Mark::Unknown,
    }
}

/// Characters that separate thousands: comma, point, apostrophes and spaces.
const SEPARATORS: [char; 7] = [',', '.', '\'', '\u{2019}', ' ', '\u{a0}', '\u{202f}'];

/// Whether a text is a number with thousands separators: `1.432,41`, `1,432`, `12 000`.
pub(crate) fn has_thousands(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['-', '+', '\u{2212}']);
    let is_digits = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    let Some(separator) = digits.chars().find(|c| SEPARATORS.contains(c)) else { return false };
    // The decimal mark is another one than the separator.
    let end =
        digits.rfind([',', '.']).filter(|at| !digits[*at..].starts_with(separator)).unwrap_or(digits.len());
    let decimals = digits.get(end + 1..).unwrap_or("0");
    let mut groups = digits[..end].split(separator);
    let lead = groups.next().unwrap_or_default();
    let rest: Vec<&str> = groups.collect();
    is_digits(lead)
        && lead.len() <= 3
        && !rest.is_empty()
        && rest.iter().all(|group| group.len() == 3 && is_digits(group))
        && (decimals.is_empty() || is_digits(decimals))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_of_numbers() {
        for cell in ["1,5", "-0,125", "22,7100", "1,25e3", "\u{2212}4,0"] {
            assert_eq!(mark(cell), Mark::Comma, "{cell}");
        }
        for cell in ["1.5", "1,432.5"] {
            assert_eq!(mark(cell), Mark::Point, "{cell}");
        }
        for cell in ["1,432", "12", "", "a,5", "1,432,000", "2026-01-02 10:00:00,5"] {
            assert_eq!(mark(cell), Mark::Unknown, "{cell}");
        }
    }

    #[test]
    fn thousands_of_every_notation() {
        for cell in ["1.432,41", "-1,432.4", "1,432", "12 000", "1'000'000.5", "3\u{202f}141,59", "1.000.000"]
        {
            assert!(has_thousands(cell), "{cell}");
        }
        for cell in ["1432,41", "14.32,5", "1.43", "", "OL", "1 A", "1.432.1", "12:30", "1,432 A"] {
            assert!(!has_thousands(cell), "{cell}");
        }
    }
}
