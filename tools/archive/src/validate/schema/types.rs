//! The simple types of XML Schema that the FMI files use.

use cosim::xml::{parse_boolean, parse_double, parse_integer};
use regex::Regex;
use std::sync::LazyLock;

pub(crate) enum Type {
    /// xs:string and xs:normalizedString: any text is valid (white space is replaced, not refused).
    Text,
    Double,
    /// xs:float; the same written forms as xs:double.
    Float,
    /// An integer type with its name in XML Schema and its limits.
    Integer(&'static str, i128, i128),
    Boolean,
    DateTime,
    HexBinary,
    /// xs:nonNegativeInteger: without an upper limit.
    NonNegative,
    /// One of these words.
    Words(Vec<&'static str>),
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
            Type::NonNegative => NON_NEGATIVE.is_match(value),
            Type::List(item) => value.split_ascii_whitespace().all(|part| item.accepts(part)),
            Type::Version3 => VERSION3.is_match(text),
        }
    }
}

fn pattern(text: &str) -> Regex {
    Regex::new(text).expect("the tests use every pattern")
}

static NON_NEGATIVE: LazyLock<Regex> = LazyLock::new(|| pattern(r"^(?:\+?[0-9]+|-0+)$"));
static VERSION3: LazyLock<Regex> = LazyLock::new(|| pattern(r"(?s)^3(?:\.(?:0|[1-9][0-9]*)){1,2}(?:-.+)?$"));
/// The written form of a date with time; how many days its month has is not part of it.
static DATE_TIME: LazyLock<Regex> = LazyLock::new(|| {
    pattern(
        r"(?x)^-?(?:[1-9][0-9]*)?(?<year>[0-9]{4})-(?<month>0[1-9]|1[0-2])-(?<day>0[1-9]|[12][0-9]|3[01])
        T(?:(?:[01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9](?:\.[0-9]+)?|24:00:00(?:\.0+)?)
        (?:Z|[+-](?:(?:0[0-9]|1[0-3]):[0-5][0-9]|14:00))?$",
    )
});

fn is_date_time(text: &str) -> bool {
    let Some(parts) = DATE_TIME.captures(text) else { return false };
    let number = |name: &str| parts[name].parse::<u32>().unwrap_or_default();
    let year = number("year");
    let longest = match number("month") {
        2 if year % 4 == 0 && (year % 100 != 0 || year % 400 == 0) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    };
    number("day") <= longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::semantics::names::is_structured;
    use std::collections::BTreeMap;

    #[derive(serde::Deserialize)]
    struct Forms {
        good: Vec<String>,
        bad: Vec<String>,
    }

    #[test]
    fn written_forms_follow_the_standards() {
        let all: BTreeMap<&str, Forms> = toml::from_str(include_str!("forms.toml")).unwrap();
        for (name, Forms { good, bad }) in all {
            let accepts = |text: &str| match name {
                "structured" => is_structured(text),
                name => Type::parse(name).accepts(text),
            };
            good.iter().for_each(|text| assert!(accepts(text), "{name} accepts {text:?}"));
            bad.iter().for_each(|text| assert!(!accepts(text), "{name} refuses {text:?}"));
        }
    }
}
