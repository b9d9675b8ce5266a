//! The simple types of XML Schema that the FMI files use.

use cosim::xml::{parse_boolean, parse_double, parse_integer};

/// A simple type.
pub(crate) enum Type {
    /// xs:string and xs:normalizedString: any text is valid (white space is replaced, not refused).
    Text,
    /// xs:double.
    Double,
    /// xs:float; the same written forms as xs:double.
    Float,
    /// An integer type with its name in XML Schema and its limits.
    Integer(&'static str, i128, i128),
    /// xs:boolean.
    Boolean,
    /// xs:dateTime.
    DateTime,
    /// xs:hexBinary.
    HexBinary,
    /// xs:nonNegativeInteger: without an upper limit.
    NonNegative,
    /// One of these words.
    Words(Vec<&'static str>),
    /// A white-space separated list.
    List(Box<Type>),
    /// `3.0`, `3.1.2`, `3.0-beta.1`.
    Version3,
}

impl Type {
    /// The type that the tables write as `text`: `'a|b'` for words, `...*` for a list.
    pub(super) fn parse(text: &'static str) -> Type {
        if let Some(item) = text.strip_suffix('*') {
            return Type::List(Box::new(Type::parse(item)));
        }
        if let Some(words) = text.strip_prefix('\'').and_then(|t| t.strip_suffix('\'')) {
            return Type::Words(words.split('|').collect());
        }
        match text {
            "text" => Type::Text,
            "double" => Type::Double,
            "float" => Type::Float,
            "boolean" => Type::Boolean,
            "dateTime" => Type::DateTime,
            "hexBinary" => Type::HexBinary,
            "nonNegative" => Type::NonNegative,
            "version3" => Type::Version3,
            "byte" => Type::Integer(text, i8::MIN.into(), i8::MAX.into()),
            "unsignedByte" => Type::Integer(text, 0, u8::MAX.into()),
            "short" => Type::Integer(text, i16::MIN.into(), i16::MAX.into()),
            "unsignedShort" => Type::Integer(text, 0, u16::MAX.into()),
            "int" => Type::Integer(text, i32::MIN.into(), i32::MAX.into()),
            "unsignedInt" => Type::Integer(text, 0, u32::MAX.into()),
            "long" => Type::Integer(text, i64::MIN.into(), i64::MAX.into()),
            "unsignedLong" => Type::Integer(text, 0, u64::MAX.into()),
            _ => panic!("the table has no type {text}"),
        }
    }

    /// What a value of this type is, for a message.
    pub(crate) fn describe(&self) -> String {
        match self {
            Type::Text => "a text".into(),
            Type::Double => "an xs:double".into(),
            Type::Float => "an xs:float".into(),
            Type::Integer(name, low, high) => format!("an xs:{name} ({low} to {high})"),
            Type::Boolean => "an xs:boolean (true, false, 1 or 0)".into(),
            Type::DateTime => "an xs:dateTime such as 2026-01-31T12:00:00Z".into(),
            Type::HexBinary => "an xs:hexBinary (pairs of hexadecimal digits)".into(),
            Type::NonNegative => "an xs:nonNegativeInteger".into(),
            Type::Words(words) => format!("one of {}", words.join(", ")),
            Type::List(item) => format!("a list, each item {}", item.describe()),
            Type::Version3 => "a version such as 3.0".into(),
        }
    }

    /// Whether `text` is a valid written form.
    pub(crate) fn accepts(&self, text: &str) -> bool {
        // All but text and words collapse white space.
        let value = text.trim_matches([' ', '\t', '\n', '\r']);
        match self {
            Type::Text => true,
            Type::Words(words) => words.contains(&text),
            Type::Double | Type::Float => parse_double(value).is_some(),
            Type::Integer(_, low, high) => parse_integer(value).is_some_and(|v| (*low..=*high).contains(&v)),
            Type::Boolean => parse_boolean(value).is_some(),
            Type::DateTime => is_date_time(value),
            Type::HexBinary => value.len().is_multiple_of(2) && value.bytes().all(|b| b.is_ascii_hexdigit()),
            Type::NonNegative => {
                let digits = value.strip_prefix('+').unwrap_or(value);
                let zero =
                    value.strip_prefix('-').is_some_and(|d| !d.is_empty() && d.bytes().all(|b| b == b'0'));
                zero || !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
            }
            Type::List(item) => value.split_ascii_whitespace().all(|part| item.accepts(part)),
            Type::Version3 => is_version3(text),
        }
    }
}

fn is_version3(text: &str) -> bool {
    let number =
        |s: &str| s == "0" || !s.starts_with('0') && !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    let (numbers, label) = text.split_once('-').map_or((text, None), |(n, l)| (n, Some(l)));
    let parts: Vec<_> = numbers.split('.').collect();
    label != Some("")
        && (2..=3).contains(&parts.len())
        && parts[0] == "3"
        && parts[1..].iter().all(|p| number(p))
}

fn is_date_time(text: &str) -> bool {
    let text = text.strip_prefix('-').unwrap_or(text);
    let Some((date, time)) = text.split_once('T') else { return false };
    let parts: Vec<_> = date.split('-').collect();
    let [year, month, day] = parts[..] else { return false };
    let fixed = |s: &str, low: u32, high: u32| {
        s.len() == 2
            && s.bytes().all(|b| b.is_ascii_digit())
            && s.parse().is_ok_and(|v: u32| (low..=high).contains(&v))
    };
    let year_ok = year.len() >= 4
        && year.bytes().all(|b| b.is_ascii_digit())
        && (year.len() == 4 || !year.starts_with('0'));
    let leap = year
        .get(year.len().saturating_sub(4)..)
        .and_then(|y| y.parse::<u32>().ok())
        .is_some_and(|y| y % 4 == 0 && (y % 100 != 0 || y % 400 == 0));
    let longest = match month {
        "02" if leap => 29,
        "02" => 28,
        "04" | "06" | "09" | "11" => 30,
        _ => 31,
    };
    let (clock, zone) = match time.find(['Z', '+', '-']) {
        Some(i) => time.split_at(i),
        None => (time, ""),
    };
    let zone_ok = zone.is_empty()
        || zone == "Z"
        || zone[1..]
            .split_once(':')
            .is_some_and(|(h, m)| fixed(h, 0, 14) && fixed(m, 0, 59) && (h != "14" || m == "00"));
    let (whole, fraction) = clock.split_once('.').map_or((clock, "0"), |(w, f)| (w, f));
    let hms: Vec<_> = whole.split(':').collect();
    let [h, m, s] = hms[..] else { return false };
    let midnight = h == "24" && m == "00" && s == "00" && fraction.bytes().all(|b| b == b'0');
    let clock_ok = midnight || fixed(h, 0, 23) && fixed(m, 0, 59) && fixed(s, 0, 59);
    let fraction_ok = !fraction.is_empty() && fraction.bytes().all(|b| b.is_ascii_digit());
    year_ok && fixed(month, 1, 12) && fixed(day, 1, longest) && clock_ok && fraction_ok && zone_ok
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_forms_follow_xml_schema() {
        for good in ["1", "-1.5e-3", ".5", "5.", "INF", "-INF", "NaN", " 1 "] {
            assert!(Type::Double.accepts(good), "{good}");
        }
        for bad in ["", "inf", "+INF", "nan", "infinity", "1,5", "0x10", "1e", "--1", "1_000"] {
            assert!(!Type::Double.accepts(bad), "{bad}");
        }
        let (int, list) = (Type::parse("int"), Type::parse("unsignedInt*"));
        assert!(int.accepts("+0000000000000000000000000000000000000000000000000007"));
        assert!(int.accepts("-2147483648") && !int.accepts("2147483648") && !int.accepts("1.0"));
        assert!(Type::Boolean.accepts("1") && !Type::Boolean.accepts("True"));
        assert!(
            Type::HexBinary.accepts("") && Type::HexBinary.accepts("0aF1") && !Type::HexBinary.accepts("abc")
        );
        assert!(list.accepts("") && list.accepts("1 2\n3") && !list.accepts("-1"));
        for good in ["3.0", "3.1", "3.0.2", "3.0-beta.1"] {
            assert!(Type::Version3.accepts(good), "{good}");
        }
        for bad in ["3", "2.0", "3.00", "3.0.1.2", "3.0-", " 3.0"] {
            assert!(!Type::Version3.accepts(bad), "{bad}");
        }
    }

    #[test]
    fn dates_follow_xml_schema() {
        for good in [
            "2026-02-28T12:00:00Z",
            "2024-02-29T00:00:00",
            "2026-01-01T24:00:00Z",
            "2026-01-01T01:02:03.5+14:00",
        ] {
            assert!(Type::DateTime.accepts(good), "{good}");
        }
        for bad in [
            "2026-02-29T12:00:00Z",
            "2026-13-01T00:00:00Z",
            "2026-01-01 00:00:00Z",
            "2026-01-01",
            "2026-01-01T25:00:00Z",
            "2026-01-01T00:00Z",
            "2026-01-01T00:00:00+1",
            "é",
        ] {
            assert!(!Type::DateTime.accepts(bad), "{bad}");
        }
    }
}
