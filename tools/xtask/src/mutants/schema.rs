//! All mutants in one program: each expression becomes a choice between itself and its replacement.

use super::Mutant;
use crate::Outcome;
use crate::files::{read, write};
use std::collections::BTreeMap;
use std::path::Path;

/// Names the mutant that applies, counted from 1; 0 or nothing for none.
pub const VARIABLE: &str = "MOTOR_FMU_MUTANT";

/// A module of each crate that has mutants.
const MODULE: &str = r#"//! Which mutant applies.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

static CHOSEN: AtomicUsize = AtomicUsize::new(usize::MAX);

/// Whether this mutant applies.
#[inline]
pub fn is(number: usize) -> bool {
    let chosen = CHOSEN.load(Relaxed);
    (if chosen == usize::MAX { choose() } else { chosen }) == number
}

#[cold]
fn choose() -> usize {
    let chosen = std::env::var("MOTOR_FMU_MUTANT").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    CHOSEN.store(chosen, Relaxed);
    chosen
}
"#;

/// The mutants of each file, with their numbers.
pub fn by_file<'a>(chosen: &[&'a Mutant]) -> BTreeMap<&'a str, Vec<(usize, &'a Mutant)>> {
    let mut files: BTreeMap<&str, Vec<(usize, &Mutant)>> = BTreeMap::new();
    for (k, mutant) in chosen.iter().enumerate() {
        files.entry(&mutant.file).or_default().push((k + 1, mutant));
    }
    files
}

/// Writes the mutants into the sources below `root`.
pub fn apply(root: &Path, chosen: &[&Mutant]) -> Outcome {
    for (file, mutants) in by_file(chosen) {
        let path = root.join(file);
        write(&path, &mutated(&read(&path)?, &mutants)?)?;
        let (package, _) = file.split_once("/src/").ok_or_else(|| format!("{file} is in no crate"))?;
        let source = root.join(package).join("src");
        write(&source.join("mutation.rs"), MODULE)?;
        let library = source.join("lib.rs");
        let text = read(&library)?;
        let line = "#[doc(hidden)]\npub mod mutation;\n";
        if !text.ends_with(line) {
            write(&library, &format!("{text}\n{line}"))?;
        }
        // The tests link the Rust library. Without the C library the one in the target folder stays as it is.
        let manifest = root.join(package).join("Cargo.toml");
        write(&manifest, &read(&manifest)?.replace(r#"["cdylib", "rlib"]"#, r#"["rlib"]"#))?;
    }
    Ok(())
}

/// A source in which each of its mutants can be chosen.
pub fn mutated(source: &str, mutants: &[(usize, &Mutant)]) -> Outcome<String> {
    let mut places = Vec::new();
    for (number, mutant) in mutants {
        let found: Vec<usize> = source.match_indices(&mutant.text).map(|(at, _)| at).collect();
        let [at] = found.as_slice() else {
            return Err(format!(
                "mutant {}: {:?} occurs {} times in {}, not once; bring tools/xtask/src/mutants/table.toml up to date",
                mutant.name,
                mutant.text,
                found.len(),
                mutant.file
            ));
        };
        places.push((*at, *number, *mutant));
    }
    places.sort_by_key(|place| place.0);
    let (mut text, mut done) = (String::new(), 0);
    // Mutants of one and the same text become one choice.
    for same in places.chunk_by(|a, b| a.0 == b.0 && a.2.text == b.2.text) {
        let (at, _, first) = same[0];
        if at < done {
            return Err(format!("mutant {} overlaps another one in {}", first.name, first.file));
        }
        text += &source[done..at];
        text += "(";
        for (_, number, mutant) in same {
            text += &format!("if crate::mutation::is({number}) {{ {} }} else ", mutant.replacement);
        }
        text += &format!("{{ {} }})", first.text);
        done = at + first.text.len();
    }
    Ok(text + &source[done..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mutant(name: &str, text: &str, replacement: &str) -> Mutant {
        let [name, text, replacement] = [name, text, replacement].map(String::from);
        Mutant { name, file: "tools/a/src/a.rs".into(), text, replacement, breaks: "the direction".into() }
    }

    #[test]
    fn an_expression_becomes_a_choice() {
        let (swap, scale) = (mutant("swap", "(a - b)", "(b - a)"), mutant("scale", "c", "2.0 * c"));
        let text = mutated("let q = (a - b) / c;", &[(2, &scale), (1, &swap)]).unwrap();
        let expected = "let q = (if crate::mutation::is(1) { (b - a) } else { (a - b) }) / \
                        (if crate::mutation::is(2) { 2.0 * c } else { c });";
        assert_eq!(text, expected);
    }

    #[test]
    fn a_text_that_is_gone_or_not_alone_or_overlaps_is_an_error() {
        let swap = mutant("swap", "a - b", "b - a");
        for source in ["nothing", "a - b; a - b"] {
            let error = mutated(source, &[(1, &swap)]).unwrap_err();
            assert!(error.contains("swap") && error.contains("a.rs"), "{error}");
        }
        let sum = mutant("sum", "a - b", "a + b");
        let text = mutated("a - b", &[(1, &swap), (2, &sum)]).unwrap();
        assert_eq!(
            text,
            "(if crate::mutation::is(1) { b - a } else if crate::mutation::is(2) { a + b } else { a - b })"
        );
        let inner = mutant("inner", "b", "0.0");
        assert!(mutated("a - b", &[(1, &swap), (2, &inner)]).unwrap_err().contains("overlaps"));
    }
}
