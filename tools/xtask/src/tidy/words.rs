//! Words that must not come back: each line of `words.txt` is a regular expression and its replacement.

use crate::{Outcome, files, workspace::Workspace};
use regex::Regex;
use std::path::{Path, PathBuf};

/// The words.
const TABLE: &str = include_str!("words.txt");
/// Files with text: names of variables and modules count, too.
const EXTENSIONS: [&str; 6] = ["rs", "md", "py", "toml", "xml", "html"];
/// Built files, and texts of others; `physics` and `calibrate` until their text is rewritten (their variables are checked in
/// `model-description`).
const WITHOUT: [&str; 5] = ["target", "dist", "tests/reference", "fmu-src/physics", "tools/calibrate"];
/// What may stand between two words: white space, comment marks, quotes that continue a string.
const BETWEEN: &str = r#"[\s/!#\\*"]+"#;

/// A word and its replacement.
struct Word {
    pattern: Regex,
    replacement: &'static str,
}

/// Fails with every place of a word of the table.
pub fn check(workspace: &Workspace) -> Outcome {
    let words = words(TABLE)?;
    let mut found = Vec::new();
    for file in texts(&workspace.root)? {
        let text = files::read(&file)?;
        let shown = file.strip_prefix(&workspace.root).unwrap_or(&file).display().to_string();
        // The path is checked as well, as line 0.
        found.extend(places(&shown, &words).into_iter().map(|(_, message)| format!("{shown}: {message}")));
        found.extend(places(&text, &words).into_iter().map(|(line, m)| format!("{shown}:{line}: {m}")));
    }
    if found.is_empty() { Ok(()) } else { Err(format!("{} places\n{}", found.len(), found.join("\n"))) }
}

/// The table of a text.
fn words(text: &'static str) -> Outcome<Vec<Word>> {
    let lines = text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    lines
        .map(|(n, line)| {
            let wrong = |reason: &str| format!("words.txt:{}: {reason}", n + 1);
            let (pattern, replacement) = line
                .split_once(" => ")
                .ok_or_else(|| wrong("expected `regular expression => replacement`"))?;
            let pattern = format!(r"(?-u:\b)(?:{})(?-u:\b)", pattern.trim().replace(' ', BETWEEN));
            let pattern = Regex::new(&pattern).map_err(|e| wrong(&e.to_string()))?;
            Ok(Word { pattern, replacement: replacement.trim() })
        })
        .collect()
}

/// The places of the words in a text, in small letters: line and message.
fn places(text: &str, words: &[Word]) -> Vec<(usize, String)> {
    // One byte for one byte: a name is a sequence of words, and places stay.
    let text = text.replace('_', " ").to_ascii_lowercase();
    let mut found = Vec::new();
    for Word { pattern, replacement } in words {
        for place in pattern.find_iter(&text) {
            let line = 1 + text[..place.start()].matches('\n').count();
            let word = place.as_str().split_whitespace().collect::<Vec<_>>().join(" ");
            found.push((line, format!("\"{word}\": write \"{replacement}\"")));
        }
    }
    found.sort();
    found
}

/// All files with text, sorted.
fn texts(root: &Path) -> Outcome<Vec<PathBuf>> {
    let is_left_out = |path: &Path| {
        path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'))
            || WITHOUT.iter().any(|without| path == root.join(without))
    };
    let mut found = files::below(root, &is_left_out)?;
    found.retain(|path| path.extension().is_some_and(|e| EXTENSIONS.iter().any(|known| e == *known)));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_found_over_lines_and_in_names_but_not_inside_of_words() {
        let words = words("# comment\n\nred herrings? => distraction\nfoo => bar\n").unwrap();
        let lines = |text: &str| places(text, &words).into_iter().map(|(line, _)| line).collect::<Vec<_>>();
        assert_eq!(lines("a\n/// one Red\n/// herring\n"), [2]);
        assert_eq!(lines("fn red_herrings() {}\n"), [1]);
        assert_eq!(lines("\"red \\\n   herring\" foo\n\nfoo"), [1, 2, 4]);
        assert_eq!(lines("redherring, food, colored herrings"), [0usize; 0]);
        let message = &places("foo", &words)[0].1;
        assert_eq!(message, "\"foo\": write \"bar\"");
    }

    #[test]
    fn a_line_without_replacement_is_an_error() {
        assert!(words("foo\n").err().unwrap().contains("words.txt:1"));
        assert!(words("\n(foo => bar\n").err().unwrap().contains("words.txt:2"));
    }

    #[test]
    fn the_table_is_valid_and_all_text_is_read() {
        assert!(words(TABLE).unwrap().len() > 30);
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let all = texts(&root).unwrap();
        for file in ["README.md", "tools/xtask/src/tidy.rs", "model-description/GaitLoad/fmi3.xml"] {
            assert!(all.contains(&root.join(file)), "{file}");
        }
        assert!(!all.iter().any(|file| file.starts_with(root.join("fmu-src/physics"))));
    }
}
