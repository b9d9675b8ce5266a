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
        Ok(Copy { root })
    }

    /// Its folder.
    pub fn root(&self) -> &Path {
        &self.root
    }
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
}
