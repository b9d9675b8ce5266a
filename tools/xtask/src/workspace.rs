//! The workspace as cargo describes it: folders, packages and their dependencies.

use crate::{Outcome, files, shell};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A crate of the workspace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Package {
    /// Its name.
    pub name: String,
    /// Crates of the workspace that it needs in the product (normal dependencies).
    pub needs: Vec<String>,
    /// Crates of the workspace that only its tests and benches need.
    pub needs_in_tests: Vec<String>,
    /// Its benches have a target.
    pub has_benches: bool,
}

/// The workspace.
#[derive(Debug)]
pub struct Workspace {
    /// The folder of the repository.
    pub root: PathBuf,
    /// The folder that cargo builds in.
    pub target: PathBuf,
    /// All crates of the workspace.
    pub packages: Vec<Package>,
}

impl Workspace {
    /// Asks cargo.
    pub fn find() -> Outcome<Self> {
        let mut command = cargo();
        command.args(["metadata", "--format-version", "1", "--no-deps"]);
        let text = shell::output(command.current_dir(here()))?;
        let metadata: Value =
            serde_json::from_str(&text).map_err(|e| format!("`cargo metadata` wrote no JSON: {e}"))?;
        Self::from_metadata(&metadata).ok_or_else(|| "`cargo metadata` has an unknown form".into())
    }

    fn from_metadata(metadata: &Value) -> Option<Self> {
        let packages = metadata["packages"].as_array()?;
        let ours: Vec<&str> = packages.iter().filter_map(|p| p["name"].as_str()).collect();
        let read = |package: &Value| -> Option<Package> {
            let dependencies = package["dependencies"].as_array()?;
            let of = |kinds: &[Option<&str>]| -> Vec<String> {
                let wanted = dependencies.iter().filter(|d| kinds.contains(&d["kind"].as_str()));
                let names = wanted.filter_map(|d| d["name"].as_str()).filter(|n| ours.contains(n));
                names.map(String::from).collect()
            };
            let targets = package["targets"].as_array()?;
            let is_bench = |t: &Value| t["kind"].as_array().is_some_and(|k| k.iter().any(|k| k == "bench"));
            Some(Package {
                name: package["name"].as_str()?.into(),
                // A normal dependency has no kind; what a build script needs is part of the product, too.
                needs: of(&[None, Some("build")]),
                needs_in_tests: of(&[Some("dev")]),
                has_benches: targets.iter().any(is_bench),
            })
        };
        Some(Workspace {
            root: metadata["workspace_root"].as_str()?.into(),
            target: metadata["target_directory"].as_str()?.into(),
            packages: packages.iter().map(read).collect::<Option<_>>()?,
        })
    }

    /// A cargo command in the root of the workspace.
    pub fn cargo(&self, arguments: &[&str]) -> Command {
        let mut command = cargo();
        command.args(arguments).current_dir(&self.root);
        command
    }

    /// A program of the workspace, built in the release profile.
    pub fn program(&self, name: &str) -> PathBuf {
        self.target.join("release").join(format!("{name}{}", std::env::consts::EXE_SUFFIX))
    }

    /// All Rust files of the crates.
    pub fn sources(&self) -> Outcome<Vec<PathBuf>> {
        let folders = ["fmu-src", "tools"].map(|folder| files::rust(&self.root.join(folder)));
        Ok(folders.into_iter().collect::<Outcome<Vec<_>>>()?.concat())
    }

    /// The folder of built archives.
    pub fn dist(&self) -> PathBuf {
        self.root.join("dist")
    }
}

/// The cargo that runs us, else the one on the path.
fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// The crate's own folder, so that the command works from anywhere in the workspace.
fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_dependencies_are_distinguished_and_third_party_crates_left_out() {
        let metadata = serde_json::json!({
            "workspace_root": "/w", "target_directory": "/t",
            "packages": [
                {"name": "a", "targets": [{"kind": ["bench"]}], "dependencies": [
                    {"name": "b", "kind": null}, {"name": "c", "kind": "dev"}, {"name": "serde", "kind": null}]},
                {"name": "b", "targets": [{"kind": ["lib"]}], "dependencies": [{"name": "c", "kind": "build"}]},
                {"name": "c", "targets": [], "dependencies": []},
            ],
        });
        let workspace = Workspace::from_metadata(&metadata).unwrap();
        let a = &workspace.packages[0];
        assert_eq!((a.needs.as_slice(), a.needs_in_tests.as_slice()), (&["b".into()][..], &["c".into()][..]));
        assert!(a.has_benches && !workspace.packages[1].has_benches);
        assert_eq!(workspace.packages[1].needs, ["c"]);
    }

    #[test]
    fn this_workspace_has_this_crate() {
        let workspace = Workspace::find().unwrap();
        assert!(workspace.packages.iter().any(|p| p.name == env!("CARGO_PKG_NAME")));
        assert!(workspace.root.join("Cargo.toml").is_file());
    }
}
