//! Files that exist: an earlier result of the same command is overwritten, any other file is refused without `--force`.
//!
//! An earlier result is recognized by its content: the columns of a table, the title of a figure or page, model and tool of an FMU, the
//! name in a report. An empty file may always be written to.

use crate::Failure;
use cosim::Archive;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// How much of a file is read to recognize it, bytes.
const HEAD: u64 = 1 << 20;
/// The tool that all archives of this program name.
const TOOL: &str = "motor-fmu";

/// The option of all commands that write files.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct Force {
    /// Overwrite existing files of any content; without it only earlier results of the same command are overwritten
    #[arg(long)]
    force: bool,
}

impl Force {
    /// Refuses to overwrite a file for which `is_earlier` does not hold; `what` names what the file would have to be.
    pub fn check(
        self,
        path: &Path,
        what: &str,
        is_earlier: impl FnOnce(&Path) -> bool,
    ) -> Result<(), Failure> {
        let is_empty = || path.metadata().is_ok_and(|data| data.len() == 0);
        if self.force || !path.is_file() || is_empty() || is_earlier(path) {
            return Ok(());
        }
        Err(Failure::new(format!("{} exists and is not {what}; --force overwrites it", path.display())))
    }

    /// A table of a run: the time and columns that `is_column` knows by their names without unit.
    pub fn check_table(
        self,
        path: &Path,
        what: &str,
        is_column: impl Fn(&str) -> bool,
    ) -> Result<(), Failure> {
        self.check(path, what, |path| {
            let columns = header(path);
            let mut names = columns.iter().map(String::as_str);
            names.next() == Some("time")
                && names.all(|c| {
                    is_column(c.strip_suffix(']').and_then(|c| c.rsplit_once(" [")).map_or(c, |c| c.0))
                })
        })
    }

    /// A figure or page of this program with a title.
    pub fn check_titled(
        self,
        path: &Path,
        what: &str,
        is_title: impl Fn(&str) -> bool,
    ) -> Result<(), Failure> {
        self.check(path, what, |path| title(&head(path)).is_some_and(|title| is_title(&title)))
    }

    /// The archive of a model.
    pub fn check_fmu(self, path: &Path, model: &str) -> Result<(), Failure> {
        self.check(path, &format!("an FMU of {model} written by {TOOL}"), |path| {
            Archive::open(path).is_ok_and(|archive| {
                let description = archive.description();
                let tool = description.generation_tool.as_deref().unwrap_or_default();
                description.model_name == model && tool.split_whitespace().next() == Some(TOOL)
            })
        })
    }
}

/// Whether a path means the standard output. The process of an FMU has another one, so that its parent has to print.
pub fn is_stdout(path: &Path) -> bool {
    ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"].iter().any(|name| path == Path::new(name))
}

/// Refuses a table on the standard output beside another result there, and two results in one file, by the options that name them.
pub fn check_apart(output: Option<&Path>, plot: Option<&Path>, json: bool) -> Result<(), Failure> {
    let Some(output) = output else { return Ok(()) };
    if is_stdout(output) && json {
        let output = output.display();
        return Err(Failure::new(format!(
            "--output {output} and --json both write to the standard output; name a file for one of them"
        )));
    }
    let file = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        path.canonicalize().ok().or_else(|| Some(folder.canonicalize().ok()?.join(path.file_name()?)))
    };
    match plot.filter(|plot| file(plot).is_some() && file(plot) == file(output)) {
        Some(plot) => Err(Failure::new(format!(
            "--output and --plot both name {}: the figure would replace the table",
            plot.display()
        ))),
        None => Ok(()),
    }
}

/// Refuses a file that cannot be written, before the work for it: a folder, or a file in a folder that does not exist.
pub fn check_place(path: &Path) -> Result<(), Failure> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder.filter(|folder| !folder.is_dir()) {
        _ if path.is_dir() => Err(Failure::new(format!("{} is a folder, not a file", path.display()))),
        Some(folder) => Err(Failure::new(format!(
            "{} cannot be written: the folder {} does not exist",
            path.display(),
            folder.display()
        ))),
        None if path == Path::new("-") => Err(Failure::new(
            "- is no name of a file; only --output of simulate and cosim writes to the standard output",
        )),
        None => Ok(()),
    }
}

/// As [`check_place`], for a command whose standard output has a summary that the file would mix with.
pub fn check_file(path: &Path) -> Result<(), Failure> {
    if is_stdout(path) {
        return Err(Failure::new(format!(
            "--output {} is the standard output, to which the summary goes: name a file",
            path.display()
        )));
    }
    check_place(path)
}

/// The beginning of a file.
pub fn head(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    // What cannot be read is not recognized.
    let _ = File::open(path).and_then(|file| file.take(HEAD).read_to_end(&mut bytes));
    bytes
}

/// Names of the columns of a CSV file.
pub fn header(path: &Path) -> Vec<String> {
    delimited::Table::parse(&head(path)).map_or(Vec::new(), |table| table.header().to_vec())
}

/// The title of a figure or a page of this program.
pub fn title(bytes: &[u8]) -> Option<String> {
    if bytes.starts_with(b"\x89PNG") {
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().ok()?;
        let title = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == "Title")?;
        return title.get_text().ok();
    }
    let text = String::from_utf8_lossy(bytes);
    let (begin, end) = match text.as_ref() {
        svg if svg.starts_with("<svg class=\"f\"") => ("aria-label=\"", "\""),
        html if html.starts_with("<!DOCTYPE html>") => ("<title>", "</title>"),
        _ => return None,
    };
    let after = text.split_once(begin)?.1;
    let escaped = after.split_once(end)?.0;
    Some(escaped.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use maud::html;
    use present::figure::{Axis, Figure};

    const TITLE: &str = "a < b & \"c\"";

    fn refusal(checked: Result<(), Failure>) -> Option<String> {
        checked.err().map(|Failure(sentence)| sentence)
    }

    #[test]
    fn figures_and_pages_are_recognized_by_their_titles() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        let figure = Figure::new(TITLE, Axis::new("x"), Axis::new("y")).line("l", vec![(0.0, 1.0)]);
        for (text, found) in [
            (figure.svg(), Some(TITLE)),
            (present::page::page(TITLE, html! { p { "text" } }), Some(TITLE)),
            (format!("<svg aria-label=\"{TITLE}\"></svg>"), None),
            ("time,current\n".to_owned(), None),
        ] {
            std::fs::write(&path, &text).unwrap();
            assert_eq!(title(&head(&path)).as_deref(), found, "{text}");
            let check = |force| Force { force }.check_titled(&path, "a figure", |title| title == TITLE);
            assert_eq!(refusal(check(false)).is_none(), found.is_some());
            assert!(check(true).is_ok());
        }
    }

    #[test]
    fn a_table_of_other_columns_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("o.csv");
        let outputs = ["current", "winding_temperature", "T[1,2]"];
        let checked = || Force::default().check_table(&path, "a result of M", |c| outputs.contains(&c));
        assert!(checked().is_ok());
        for (text, good) in [
            ("", true),
            ("time,current\n0,1\n", true),
            ("time,winding_temperature [degC],\"T[1,2]\"\n", true),
            ("time,current,voltage\n0,1,2\n", false),
            ("time_s,current\n", false),
            ("my notes\n", false),
        ] {
            std::fs::write(&path, text).unwrap();
            assert_eq!(refusal(checked()).is_none(), good, "{text}");
        }
        let sentence = refusal(checked()).unwrap();
        assert!(sentence.contains("o.csv exists and is not a result of M; --force"), "{sentence}");
        assert!(refusal(Force::default().check(folder.path(), "a file", |_| false)).is_none());
    }
}
