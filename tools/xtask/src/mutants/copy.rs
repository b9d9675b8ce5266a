//! A copy of the workspace that may be broken.

use crate::{Outcome, files, workspace::Workspace};
use std::path::{Path, PathBuf};

/// Folders that are built, not written. The target folder is left out wherever it is.
const LEFT_OUT: [&str; 3] = [".git", "dist", "target"];

/// A new copy. It stays for inspection; the next one replaces it.
pub struct Copy {
    root: PathBuf,
}

impl Copy {
    /// Copies the workspace into a folder of this name in its target folder.
    pub fn of(workspace: &Workspace, name: &str) -> Outcome<Self> {
        let root = workspace.target.join(name);
        files::remove(&root)?;
        let left_out = |path: &Path| {
            path == workspace.target
                || path.parent() == Some(&workspace.root) && LEFT_OUT.iter().any(|name| path.ends_with(name))
        };
        copy_folder(&workspace.root, &root, &left_out)
            .map_err(|e| format!("the workspace cannot be copied to {}: {e}", root.display()))?;
        let manifest = root.join("Cargo.toml");
        files::write(&manifest, &renamed(&files::read(&manifest)?)?)?;
        Ok(Copy { root })
    }

    /// Its folder.
    pub fn root(&self) -> &Path {
        &self.root
    }
}

/// The manifest of a workspace with another version. In a shared target folder cargo distinguishes crates by name and version,
/// not by their folder: with the same version, the next build of the workspace would take the broken crates as its own.
fn renamed(manifest: &str) -> Outcome<String> {
    let (before, after) = manifest
        .split_once("[workspace.package]\nversion = \"")
        .ok_or("Cargo.toml has no [workspace.package] that begins with a version")?;
    let (version, after) = after.split_once('"').ok_or("the version of [workspace.package] does not end")?;
    Ok(format!("{before}[workspace.package]\nversion = \"{version}-copy\"{after}"))
}

fn copy_folder(from: &Path, to: &Path, left_out: &dyn Fn(&Path) -> bool) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in from.read_dir()? {
        let (path, target) = entry.map(|e| (e.path(), to.join(e.file_name())))?;
        if left_out(&path) {
            continue;
        }
        if path.is_dir() {
            copy_folder(&path, &target, left_out)?;
        } else {
            std::fs::copy(&path, &target)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_has_the_sources_and_not_what_is_left_out() {
        let from = Path::new(env!("CARGO_MANIFEST_DIR"));
        let to = std::env::temp_dir().join(format!("motor-fmu-copy-{}", std::process::id()));
        copy_folder(from, &to, &|path| path.ends_with("Cargo.toml")).unwrap();
        let copied = (to.join("src/mutants/copy.rs").is_file(), to.join("Cargo.toml").exists());
        std::fs::remove_dir_all(&to).unwrap();
        assert_eq!(copied, (true, false));
    }

    /// The copy's crates are others to cargo, its dependencies are the same.
    #[test]
    fn a_copy_has_a_version_of_its_own() {
        let own = crate::files::read(&Workspace::find().unwrap().root.join("Cargo.toml")).unwrap();
        let other = renamed(&own).unwrap();
        let changed: Vec<_> = own.lines().zip(other.lines()).filter(|(a, b)| a != b).collect();
        let version = env!("CARGO_PKG_VERSION");
        let (before, after) = (format!("version = \"{version}\""), format!("version = \"{version}-copy\""));
        assert_eq!(changed, [(before.as_str(), after.as_str())]);
        assert!(renamed("[workspace]\n").unwrap_err().contains("[workspace.package]"));
    }
}
