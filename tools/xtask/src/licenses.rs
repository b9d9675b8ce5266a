//! `cargo xtask licenses`: the list of third-party crates in the FMU library with their licences, for the archives.

use crate::{Outcome, files, shell, workspace::Workspace};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The crate whose dependencies are meant.
const LIBRARY: &str = "fmu";
/// Where the text is kept; the archives include it.
const FILE: &str = "tools/archive/assets/third-party.txt";
/// Licences that need no text of their own where the choice is ours, best first.
const PREFERRED: [&str; 4] = ["MIT", "Apache-2.0", "Zlib", "Unicode-3.0"];

/// Writes the file.
pub fn write(workspace: &Workspace) -> Outcome {
    files::write(&workspace.root.join(FILE), &text(workspace)?)
}

/// Compares the file with `cargo metadata`.
pub fn check(workspace: &Workspace) -> Outcome {
    if files::read(&workspace.root.join(FILE))? == text(workspace)? {
        Ok(())
    } else {
        Err(format!("{FILE} is not what is compiled in; run `cargo xtask licenses`"))
    }
}

fn text(workspace: &Workspace) -> Outcome<String> {
    let metadata = shell::output(&mut workspace.cargo(&["metadata", "--format-version", "1", "--locked"]))?;
    let metadata: Value =
        serde_json::from_str(&metadata).map_err(|e| format!("`cargo metadata` wrote no JSON: {e}"))?;
    let mut command =
        workspace.cargo(&["tree", "--locked", "--package", LIBRARY, "--edges", "normal,no-proc-macro"]);
    command.args(["--prefix", "none", "--target", "all", "--format", "{p}"]);
    let compiled = compiled(&shell::output(&mut command)?);
    let packages = metadata["packages"].as_array().ok_or("`cargo metadata` lists no packages")?;
    let mut crates = String::new();
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (name, version) in &compiled {
        let package = packages
            .iter()
            .find(|p| p["name"] == name.as_str() && p["version"] == version.as_str())
            .ok_or_else(|| format!("`cargo metadata` does not know {name} {version}"))?;
        let license = package["license"].as_str().unwrap_or("see its text below");
        crates += &format!("{name} {version}: {license}\n");
        let folder = Path::new(package["manifest_path"].as_str().unwrap_or_default()).parent();
        for license in folder.map(license_texts).transpose()?.unwrap_or_default() {
            texts.entry(license).or_default().insert(name.clone());
        }
    }
    let mut text = format!(
        "The library of this FMU is compiled from motor-fmu itself (license.txt), Rust's standard library\n\
         (MIT OR Apache-2.0) and the crates below.\n\n{crates}"
    );
    for (license, names) in texts {
        let names: Vec<String> = names.into_iter().collect();
        text += &format!("\n{0}\n{1}\n{0}\n\n{license}\n", "-".repeat(72), names.join(", "));
    }
    Ok(text)
}

/// Names and versions of others' crates in the lines of `cargo tree`; ours have a path behind them.
fn compiled(tree: &str) -> BTreeSet<(String, String)> {
    let read = |line: &str| {
        let mut words = line.split_whitespace();
        let (name, version) = (words.next()?, words.next()?.strip_prefix('v')?);
        let ours = words.next().is_some_and(|w| w.starts_with('(') && w != "(*)");
        (!ours).then(|| (name.to_string(), version.to_string()))
    };
    tree.lines().filter_map(read).collect()
}

/// The licence texts that a crate brings, the preferred one alone where it brings several.
fn license_texts(folder: &Path) -> Outcome<Vec<String>> {
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut found = files::entries(folder)?;
    found.retain(|p| {
        p.is_file() && ["license", "licence", "copying"].iter().any(|start| name(p).starts_with(start))
    });
    let preferred = PREFERRED.iter().find_map(|license| {
        let short = license.split('-').next().unwrap_or_default().to_lowercase();
        found.iter().find(|file| name(file).contains(&short))
    });
    let chosen = preferred.map_or(&found[..], std::slice::from_ref);
    let read = |file: &PathBuf| {
        let text = files::read(file)?;
        Ok(text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n").trim().to_string())
    };
    chosen.iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn our_own_crates_are_left_out_and_others_counted_once() {
        let tree = "fmu v0.1.0 (/w/fmu)\nserde v1.0.2\nserde v1.0.2 (*)\nphysics v0.1.0 (/w/physics) (*)\nsyn v2.0.1 (proc-macro)\n";
        let found: Vec<_> = compiled(tree).into_iter().map(|c| c.0).collect();
        assert_eq!(found, ["serde"]);
    }
}
