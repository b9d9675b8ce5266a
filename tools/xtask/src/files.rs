//! Files and folders, with errors in sentences.

use crate::Outcome;
use std::path::{Path, PathBuf};

/// The text of a file.
pub fn read(file: &Path) -> Outcome<String> {
    std::fs::read_to_string(file).map_err(|e| format!("{} cannot be read: {e}", file.display()))
}

/// Writes a file.
pub fn write(file: &Path, text: &str) -> Outcome {
    std::fs::write(file, text).map_err(|e| format!("{} cannot be written: {e}", file.display()))
}

/// Writes a page. A file of another title is no earlier result: it is overwritten only with `force`.
pub fn write_page(file: &Path, html: &str, force: bool) -> Outcome {
    let title = |text: &str| Some(text.split_once("<title>")?.1.split_once("</title>")?.0.to_owned());
    let earlier = std::fs::read(file).map(|bytes| title(&String::from_utf8_lossy(&bytes)));
    if !force && earlier.is_ok_and(|earlier| earlier.is_none() || earlier != title(html)) {
        return Err(format!("{} exists and is no earlier result; --force overwrites it", file.display()));
    }
    write(file, html)
}

/// What a folder holds, sorted.
pub fn entries(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let entries = folder.read_dir().map_err(|e| format!("{} cannot be read: {e}", folder.display()))?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}

/// All files below a folder but for those in paths that are left out, sorted.
pub fn below(folder: &Path, is_left_out: &dyn Fn(&Path) -> bool) -> Outcome<Vec<PathBuf>> {
    let mut found = Vec::new();
    for path in entries(folder)?.into_iter().filter(|path| !is_left_out(path)) {
        if path.is_dir() {
            found.extend(below(&path, is_left_out)?);
        } else {
            found.push(path);
        }
    }
    Ok(found)
}

/// All Rust files below a folder.
pub fn rust(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let mut files = below(folder, &|_| false)?;
    files.retain(|path| path.extension().is_some_and(|e| e == "rs"));
    Ok(files)
}

/// Copies a file, into a folder that is made where it is missing.
pub fn copy(from: &Path, to: &Path) -> Outcome {
    let folder = to.parent().ok_or_else(|| format!("{} has no folder", to.display()))?;
    std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::copy(from, to).map(drop))
        .map_err(|e| format!("{} cannot be copied to {}: {e}", from.display(), to.display()))
}

/// Removes a folder, where it is there, with all that it holds.
pub fn remove(folder: &Path) -> Outcome {
    if !folder.exists() {
        return Ok(());
    }
    std::fs::remove_dir_all(folder).map_err(|e| format!("{} cannot be removed: {e}", folder.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_earlier_pages_are_overwritten() {
        let file = std::env::temp_dir().join(format!("motor-fmu-page-{}.html", std::process::id()));
        let page = |title: &str| format!("<!DOCTYPE html><title>{title}</title>");
        assert_eq!(write_page(&file, &page("walk"), false), Ok(()));
        assert_eq!(write_page(&file, &page("walk"), false), Ok(()));
        assert!(write_page(&file, &page("other"), false).unwrap_err().contains("--force"));
        assert_eq!(read(&file), Ok(page("walk")));
        assert_eq!(write_page(&file, &page("other"), true), Ok(()));
        write(&file, "notes").unwrap();
        assert!(write_page(&file, "notes", false).is_err());
        std::fs::remove_file(&file).unwrap();
    }
}
