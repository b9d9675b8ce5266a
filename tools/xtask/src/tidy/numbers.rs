//! Numeric constants of the residual tracer: each states why it has its value, and those that were chosen stand in the documentation.

use crate::{Outcome, files, shell, workspace::Workspace};
use regex::Regex;
use std::path::Path;

/// The crate whose constants are checked.
const FOLDER: &str = "tools/calibrate/src";
/// The page with the table of the tuned constants, in the lines that begin with [`ROW`].
const PAGE: &str = "docs/close-the-loop.md";
/// Beginning of a row of the table: a constant with its module.
const ROW: &str = r"(?m)^\| `([a-z_:]+::[A-Z_0-9]+)` \| `([^`]*)` \|";
/// Largest number of tuned constants; it may only fall.
const MOST_TUNED: usize = 14;
/// Largest number of decimals outside constants, apart from those of plain arithmetic; it may only fall.
const MOST_BARE: usize = 25;
/// A constant with its doc comment: comment, name, value.
const CONSTANT: &str =
    r"(?m)((?:^[ \t]*///.*\n)*)^[ \t]*(?:pub(?:\([a-z:]+\))? )?const ([A-Z]\w*):[^=]+=([^;]*);";
/// The last sentence of the comment begins with one of these; `levels.rs` explains them.
const CLASS: &str = r"\b(Definition|Derivation|Limit|Numerical|Source|Tuned):\s";
/// A decimal number.
const DECIMAL: &str = r"(?:^|[^\w.])(\d[\d_]*\.\d+(?:e-?\d+)?|\d+e-?\d+)";
/// Decimals of plain arithmetic.
const PLAIN: [&str; 4] = ["0.0", "0.5", "1.0", "2.0"];

/// Constants of a file: name, value, classes; and the decimals outside them.
struct Numbers {
    constants: Vec<(String, String, Vec<String>)>,
    bare: usize,
}

/// Fails on constants without a class, on more tuned constants or bare decimals than allowed, and on a page with other ones.
pub fn check(workspace: &Workspace) -> Outcome {
    let folder = workspace.root.join(FOLDER);
    let (mut wrong, mut tuned, mut bare) = (Vec::new(), Vec::new(), 0);
    for file in files::rust(&folder)?.iter().filter(|file| !is_test(file)) {
        let module = module(file.strip_prefix(&folder).unwrap_or(file));
        let numbers = numbers(&files::read(file)?);
        bare += numbers.bare;
        for (name, value, classes) in numbers.constants {
            match &classes[..] {
                [class] if class == "Tuned" => tuned.push((format!("{module}::{name}"), value)),
                [_] => {}
                _ => wrong.push(format!(
                    "{module}::{name} needs one of Definition, Derivation, ... in its comment"
                )),
            }
        }
    }
    tuned.sort();
    shell::stage(&format!("tidy: {} tuned constants, {bare} decimals outside constants", tuned.len()));
    if tuned.len() > MOST_TUNED {
        wrong.push(format!("{} tuned constants; the limit is {MOST_TUNED}", tuned.len()));
    }
    if bare > MOST_BARE {
        wrong.push(format!("{bare} decimals outside constants; the limit is {MOST_BARE}"));
    }
    if tuned != listed(&files::read(&workspace.root.join(PAGE))?) {
        let rows: Vec<String> =
            tuned.iter().map(|(name, value)| format!("| `{name}` | `{value}` |")).collect();
        wrong.push(format!("the table in {PAGE} needs these rows:\n{}", rows.join("\n")));
    }
    if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
}

/// The rows of the page, sorted.
fn listed(page: &str) -> Vec<(String, String)> {
    let row = pattern(ROW);
    let mut rows: Vec<_> =
        row.captures_iter(page).map(|row| (row[1].to_string(), row[2].to_string())).collect();
    rows.sort();
    rows
}

fn is_test(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == "tests.rs" || name == "testing.rs")
}

/// `intake::clocks` of `intake/clocks.rs`.
fn module(file: &Path) -> String {
    file.with_extension("").to_string_lossy().replace(['/', '\\'], "::")
}

fn numbers(text: &str) -> Numbers {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let (strings, constant, class) = (pattern(r#""(?:\\.|[^"\\])*""#), pattern(CONSTANT), pattern(CLASS));
    let text = strings.replace_all(text, "");
    let digit = pattern(r"(?:^|[^\w.])\d");
    let of = |found: regex::Captures| {
        let classes = class.captures_iter(&found[1]).map(|class| class[1].to_string()).collect();
        let value = found[3].split_whitespace().collect::<Vec<_>>().join(" ");
        digit.is_match(&value).then(|| (found[2].to_string(), value, classes))
    };
    let constants = constant.captures_iter(&text).filter_map(of).collect();
    let code = constant.replace_all(&text, "");
    let code = code.lines().map(|line| line.split("//").next().unwrap_or_default());
    let decimal = pattern(DECIMAL);
    let of = |line: &str| decimal.captures_iter(line).filter(|found| !PLAIN.contains(&&found[1])).count();
    Numbers { constants, bare: code.map(of).sum() }
}

fn pattern(text: &str) -> Regex {
    Regex::new(text).unwrap_or_else(|e| panic!("{text}: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_found_with_their_classes_and_decimals_without() {
        let text = "/// A step. Numerical: any.\nconst STEP: f64 = 1e-3;\n/// Text.\npub const NAME: &str = \"2.5\";\n\
                    /// Two.\n    const PAIR: (f64,\n f64) = (0.25,\n 3.0);\nconst NONE: f64 = f64::NAN;\n\
                    fn a(x: f64) -> f64 { 2.0 * x + 0.35 } // 0.7\n#[cfg(test)]\nmod tests {\nconst B: f64 = 0.1;\n";
        let found = numbers(text);
        let step = ("STEP".to_string(), "1e-3".to_string(), vec!["Numerical".to_string()]);
        let pair = ("PAIR".to_string(), "(0.25, 3.0)".to_string(), Vec::new());
        assert_eq!((found.constants, found.bare), (vec![step, pair], 1));
    }

    #[test]
    fn rows_are_those_of_the_table() {
        let page = "text `a::B`\n| `x::y::LEAST` | `0.02` | effect |\n| `a::B` | `(1.0, 3)` | other |\n| row | x |\n";
        let rows =
            [("a::B", "(1.0, 3)"), ("x::y::LEAST", "0.02")].map(|(a, b)| (a.to_string(), b.to_string()));
        assert_eq!(listed(page), rows);
        assert_eq!(module(Path::new("intake/clocks.rs")), "intake::clocks");
    }
}
