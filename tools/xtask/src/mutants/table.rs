//! The mutants of `table.toml`: one way each in which the code is wrong and may look right.

use super::Mutant;
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// By file, and by name: text, replacement, what it breaks.
type Table = BTreeMap<String, BTreeMap<String, [String; 3]>>;

static MUTANTS: LazyLock<Vec<Mutant>> = LazyLock::new(|| {
    let files: Table = toml::from_str(include_str!("table.toml")).expect("a test reads the table");
    let of_file = |(file, mutants): (String, BTreeMap<String, [String; 3]>)| {
        mutants.into_iter().map(move |(name, [text, replacement, breaks])| Mutant {
            name,
            file: file.clone(),
            text,
            replacement,
            breaks,
        })
    };
    files.into_iter().flat_map(of_file).collect()
});

/// All of them.
pub fn all() -> impl Iterator<Item = &'static Mutant> {
    MUTANTS.iter()
}
