//! The Rust that compiles for a platform: the one at hand where it has the platform's standard library or can fetch it,
//! else one that is named, which may also compile the standard library from its sources.

use crate::{Outcome, shell, workspace::Workspace};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A compiler for a platform.
pub struct Compiler {
    /// Its root where it is not the one at hand.
    root: Option<PathBuf>,
    /// It compiles the standard library as well.
    from_sources: bool,
}

impl Compiler {
    /// For a target; `other` is the root of another Rust (the folder above `bin`).
    pub fn find(workspace: &Workspace, triple: &str, other: Option<&Path>) -> Outcome<Compiler> {
        let own = Compiler { root: None, from_sources: false };
        if own.has(workspace, triple)? {
            return Ok(own);
        }
        // Quietly: without a network, or without rustup, another way may be left.
        let added = shell::output(Command::new("rustup").args(["target", "add", triple]));
        if added.is_ok() && own.has(workspace, triple)? {
            return Ok(own);
        }
        let Some(root) = other else {
            return Err(format!(
                "this Rust has no standard library for {triple} and `rustup target add {triple}` could not fetch it; \
                 `--toolchain DIR` takes another Rust that has it, or that has its sources"
            ));
        };
        let mut named = Compiler { root: Some(root.to_path_buf()), from_sources: false };
        if named.has(workspace, triple)? {
            return Ok(named);
        }
        let sources = named.sysroot(workspace)?.join("lib/rustlib/src/rust/library");
        if sources.join("Cargo.toml").is_file() {
            named.from_sources = true;
            return Ok(named);
        }
        Err(format!(
            "{} has neither a standard library for {triple} nor {}",
            root.display(),
            sources.display()
        ))
    }

    /// A cargo of this compiler.
    pub fn command(&self, workspace: &Workspace) -> Command {
        let Some(root) = &self.root else { return workspace.cargo(&[]) };
        let mut command = Command::new(root.join("bin/cargo"));
        command.current_dir(&workspace.root);
        self.enter(&mut command, root);
        command
    }

    /// Flags that every build needs.
    pub fn flags(&self) -> &[&str] {
        if self.from_sources { &["-Zbuild-std=std,panic_unwind"] } else { &[] }
    }

    /// Makes cargo find the subcommand and the linker that lie beside a Python.
    pub fn find_zig(&self, command: &mut Command, python: &Path) -> Outcome {
        let folder = python.parent().ok_or("the Python of the venv has no folder")?;
        let path = std::env::var_os("PATH").unwrap_or_default();
        let own = self.root.iter().map(|root| root.join("bin"));
        let all = own.chain([folder.to_path_buf()]).chain(std::env::split_paths(&path));
        let joined = std::env::join_paths(all).map_err(|e| format!("PATH cannot be extended: {e}"))?;
        command.env("PATH", joined).env("CARGO_ZIGBUILD_PYTHON_PATH", python);
        Ok(())
    }

    fn enter(&self, command: &mut Command, root: &Path) {
        command.env("RUSTC", root.join("bin/rustc")).env("CARGO", root.join("bin/cargo"));
        // rustup's choice of a toolchain must not reach into this one.
        command.env_remove("RUSTUP_TOOLCHAIN");
        let mut libraries = vec![root.join("lib")];
        libraries.extend(root.join("lib").read_dir().into_iter().flatten().flatten().map(|e| e.path()));
        libraries.retain(|folder| folder.is_dir());
        if let Ok(joined) = std::env::join_paths(libraries) {
            command.env("LD_LIBRARY_PATH", joined);
        }
        if self.from_sources {
            // What cargo calls unstable about the standard library's sources is the way they are named.
            command.env("RUSTC_BOOTSTRAP", "1");
        }
    }

    fn sysroot(&self, workspace: &Workspace) -> Outcome<PathBuf> {
        let mut command = match &self.root {
            None => Command::new("rustc"),
            Some(root) => {
                let mut command = Command::new(root.join("bin/rustc"));
                self.enter(&mut command, root);
                command
            }
        };
        shell::output(command.args(["--print", "sysroot"]).current_dir(&workspace.root)).map(PathBuf::from)
    }

    fn has(&self, workspace: &Workspace, triple: &str) -> Outcome<bool> {
        Ok(self.sysroot(workspace)?.join("lib/rustlib").join(triple).join("lib").is_dir())
    }
}
