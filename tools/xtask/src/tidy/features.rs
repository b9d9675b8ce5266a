//! Features of the packages that xtask shares with the workspace: `cargo xtask test` builds xtask first, then the workspace, and a package whose
//! features differ is compiled twice, with all that depend on it.

use crate::{Outcome, shell, test, workspace::Workspace};
use std::collections::BTreeSet;

/// Compares both with `cargo tree`.
pub fn check(workspace: &Workspace) -> Outcome {
    let own = packages(workspace, &["--package", "xtask"], "normal,build")?;
    let all = packages(workspace, &test::MEMBERS, "normal,build,dev")?;
    let twice: Vec<&str> = own.difference(&all).map(String::as_str).collect();
    if twice.is_empty() {
        return Ok(());
    }
    Err(format!("compiled twice, add the features that the workspace has to xtask: {}", twice.join(", ")))
}

/// Each package with its features.
fn packages(workspace: &Workspace, which: &[&str], edges: &str) -> Outcome<BTreeSet<String>> {
    let mut command =
        workspace.cargo(&["tree", "--prefix", "none", "--format", "{p} [{f}]", "--edges", edges]);
    Ok(lines(&shell::output(command.args(which))?))
}

/// The lines without the marks of repetition.
fn lines(tree: &str) -> BTreeSet<String> {
    tree.lines()
        .map(|line| line.trim_end_matches(" (*)").to_string())
        .filter(|line| !line.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_repeated_package_is_one() {
        let tree = "xtask v0.1.0 []\nsyn v2.0.1 [full]\nsyn v2.0.1 [full] (*)\n\nsyn v2.0.1 [parsing]\n";
        assert_eq!(lines(tree).len(), 3);
    }
}
