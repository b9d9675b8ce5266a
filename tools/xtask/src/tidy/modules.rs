//! Test programs that name their modules by hand: a file that is not named would never run.

use super::lengths::rust_files;
use crate::{Outcome, workspace::Workspace};
use std::path::Path;

/// Finds files beside `tests/main.rs` that it does not name.
pub fn check(workspace: &Workspace) -> Outcome {
    let mut forgotten = Vec::new();
    for main in ["fmu-src", "tools"]
        .iter()
        .map(|folder| rust_files(&workspace.root.join(folder)))
        .collect::<Outcome<Vec<_>>>()?
        .concat()
        .iter()
        .filter(|file| file.ends_with("tests/main.rs"))
    {
        let text =
            std::fs::read_to_string(main).map_err(|e| format!("{} cannot be read: {e}", main.display()))?;
        let folder = main.parent().unwrap_or(Path::new("."));
        for file in rust_files(folder)?.iter().filter(|file| file.parent() == Some(folder)) {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            if stem != "main" && !names(&text, &stem) {
                forgotten.push(format!("{} is no module of {}", file.display(), main.display()));
            }
        }
    }
    if forgotten.is_empty() { Ok(()) } else { Err(forgotten.join("; ")) }
}

fn names(main: &str, module: &str) -> bool {
    main.lines().any(|line| line.trim() == format!("mod {module};"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_module_is_named_by_a_line_of_its_own() {
        assert!(names("mod common;\nmod balance;\n", "balance"));
        assert!(!names("mod balances;\n// mod balance;\n", "balance"));
    }
}
