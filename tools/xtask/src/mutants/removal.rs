//! `cargo xtask removals`: removes each effect from a copy of the sources, one at a time, and expects the physics to
//! compile.
//!
//! An effect is one file and one line of the list. If anything else names it, taking the line out breaks the build.

use super::copy::Copy;
use crate::files::{read, write};
use crate::{Outcome, shell, workspace::Workspace};
use std::path::Path;

/// The list of effects, from the root of the workspace.
const LIST: &str = "fmu-src/physics/src/effects.rs";

/// Removes every effect in turn; with the closing line for a summary.
pub fn summary(workspace: &Workspace) -> (Vec<String>, Outcome) {
    match try_all(workspace) {
        Ok(tried) => (vec![format!("{tried} effects removed one by one")], Ok(())),
        Err(sentence) => (Vec::new(), Err(sentence)),
    }
}

fn try_all(workspace: &Workspace) -> Outcome<usize> {
    let copy = Copy::of(workspace, "removals")?;
    let path = copy.root().join(LIST);
    let list = read(&path)?;
    let ids = ids(&list);
    if ids.is_empty() {
        return Err(format!(
            "{LIST} lists no effects in the form that tools/xtask/src/mutants/removal.rs reads"
        ));
    }
    let mut needed = Vec::new();
    for (k, id) in ids.iter().enumerate() {
        shell::stage(&format!("removal {} of {}: {id}", k + 1, ids.len()));
        let file = path.with_extension("").join(format!("{id}.rs"));
        let source = read(&file)?;
        write(&path, &without(&list, id))?;
        std::fs::remove_file(&file).map_err(|e| format!("{} cannot be removed: {e}", file.display()))?;
        if compiles(workspace, copy.root()).is_err() {
            needed.push(*id);
        }
        // Written after the build, so that cargo takes what it has built for the copy as out of date.
        write(&file, &source)?;
        write(&path, &list)?;
    }
    if needed.is_empty() {
        Ok(ids.len())
    } else {
        Err(format!("the physics do not compile without {}: something else names it", needed.join(", ")))
    }
}

/// Checks the physics in a folder, in the shared target folder, so that only they are looked at.
fn compiles(workspace: &Workspace, root: &Path) -> Outcome {
    let mut check = workspace.cargo(&["check", "--quiet", "--release", "--package", "physics", "--lib"]);
    shell::run(check.current_dir(root).env("CARGO_TARGET_DIR", &workspace.target))
}

/// The effects listed: lines of the form `id: Type @ "effect.id." 1000 at Port;`.
fn ids(list: &str) -> Vec<&str> {
    let id = |line: &str| -> Option<usize> {
        let (id, rest) = line.trim().split_once(": ")?;
        rest.contains(&format!("@ \"effect.{id}.\"")).then_some(id.len())
    };
    list.lines().filter_map(|line| id(line).map(|n| &line.trim()[..n])).collect()
}

/// The list without an effect: its module, what is taken from it, and its line with what is said of it.
fn without(list: &str, id: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    for line in list.lines() {
        let text = line.trim();
        if text == format!("mod {id};") || text.starts_with(&format!("pub use {id}::")) {
            continue;
        }
        if ids(text) == [id] {
            while kept.last().is_some_and(|line| line.trim().starts_with("///")) {
                kept.pop();
            }
            continue;
        }
        kept.push(line);
    }
    kept.join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "mod a;\nmod b;\n\npub use a::A;\npub use b::{B, C};\n\neffects! {\n    /// Of a.\n    \
                        a: A @ \"effect.a.\" 1000 at X;\n    /// Of b.\n    b: B @ \"effect.b.\" 1010 at Y;\n}\n";

    #[test]
    fn an_effect_goes_with_all_that_names_it() {
        assert_eq!(ids(TEXT), ["a", "b"]);
        let rest =
            "mod a;\n\npub use a::A;\n\neffects! {\n    /// Of a.\n    a: A @ \"effect.a.\" 1000 at X;\n}\n";
        assert_eq!(without(TEXT, "b"), rest);
        assert_eq!(without(TEXT, "c"), TEXT);
    }

    #[test]
    fn the_effects_of_now_are_found() {
        let list = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(LIST)).unwrap();
        let (found, files) = (ids(&list), list.matches("\nmod ").count());
        assert_eq!(
            found.len(),
            files - 4,
            "each module but `candidate`, `ports`, `prelude` and `testing` is an effect: {found:?}"
        );
        assert!(found.contains(&"iron_loss") && found.contains(&"generic_term"));
    }
}
