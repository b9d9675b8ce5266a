//! The built-in presets: every file of `examples/presets`, as a table of names and texts.

use std::fmt::Write;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/presets");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&folder)? {
        if let Some(name) = entry?.file_name().to_str().and_then(|name| name.strip_suffix(".toml")) {
            names.push(name.to_owned());
        }
    }
    names.sort();
    let mut table = String::from("&[");
    for name in names {
        let file = folder.join(format!("{name}.toml"));
        writeln!(table, "({name:?}, include_str!({:?})),", file.display().to_string())?;
    }
    std::fs::write(Path::new(&std::env::var("OUT_DIR")?).join("presets.rs"), table + "]")?;
    Ok(())
}
