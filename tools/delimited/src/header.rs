//! The line of the header, by the names that it has to have.

use csv::{ReaderBuilder, Trim};

/// Where a header begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    /// Byte of its first cell.
    pub start: usize,
    /// Number of its line, from 1.
    pub line: u64,
    pub separator: u8,
}

/// Separators of columns; of those that a header has, the first counts.
const SEPARATORS: [u8; 3] = *b";\t,";
/// Lines in which the header is searched.
const MOST_LINES: usize = 1000;

/// The cells of one line.
pub(crate) fn cells(line: &str, separator: u8) -> Vec<String> {
    let mut reader = ReaderBuilder::new();
    reader.has_headers(false).flexible(true).trim(Trim::All).delimiter(separator);
    let record = reader.from_reader(line.as_bytes()).into_records().flatten().next();
    let mut cells: Vec<String> = record.map_or(Vec::new(), |r| r.iter().map(str::to_owned).collect());
    while cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// A line without the comment sign before it.
pub(crate) fn uncommented(line: &str) -> &str {
    let text = line.trim_start_matches(' ');
    let bare = text.strip_prefix("//").unwrap_or(text).trim_start_matches(['#', '%', '!']);
    if bare.len() == text.len() { line } else { bare.trim_start_matches(' ') }
}

/// Numbered lines with their first byte, without their ends.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (u64, usize, &str)> {
    let mut start = 0;
    (1..).zip(text.split_inclusive('\n')).map(move |(number, line)| {
        let begin = start;
        start += line.len();
        (number, begin, line.trim_end_matches(['\r', '\n']))
    })
}

/// The header by position: the first line that is neither blank nor a comment.
pub(crate) fn first(text: &str) -> Option<Place> {
    let (line, start, head) =
        lines(text).find(|(_, _, line)| !line.trim().is_empty() && !line.starts_with('#'))?;
    Some(Place { start, line, separator: usual_separator(head) })
}

fn usual_separator(head: &str) -> u8 {
    *SEPARATORS.iter().find(|mark| head.as_bytes().contains(mark)).unwrap_or(&b',')
}

/// The header by its names. `names` has the possible names of each wanted column, first those of the column without which a row is
/// nothing (the time). The first line counts if it has this column and another one.
pub(crate) fn find(text: &str, names: &[Vec<&str>]) -> Option<Place> {
    let by_position = first(text);
    let matches = |line: &str, separator: u8| {
        let cells = cells(line, separator);
        let has = |group: &Vec<&str>| group.iter().any(|name| cells.iter().any(|cell| cell == name));
        (names.first().is_some_and(has), names.iter().filter(|group| has(group)).count())
    };
    let enough = names.len().min(2);
    if let Some(place) = by_position {
        let line = text[place.start..].lines().next().unwrap_or_default();
        if matches(line, place.separator) >= (true, enough) {
            return by_position;
        }
    }
    let mut best: Option<((bool, usize), Place)> = None;
    for (line, begin, whole) in lines(text).take(MOST_LINES) {
        if !names.iter().flatten().any(|name| whole.contains(name)) {
            continue;
        }
        let bare = uncommented(whole);
        let start = begin + whole.len() - bare.len();
        for separator in SEPARATORS.into_iter().filter(|mark| bare.as_bytes().contains(mark)) {
            let found = matches(bare, separator);
            if found.1 >= enough && best.is_none_or(|(most, _)| found > most) {
                best = Some((found, Place { start, line, separator }));
            }
        }
        if best.is_some_and(|(found, _)| found == (true, names.len())) {
            break;
        }
    }
    best.map(|(_, place)| place).or_else(|| above_numbers(text).or(by_position))
}

/// The line with names above the first row of numbers, for a message about names that are not found.
fn above_numbers(text: &str) -> Option<Place> {
    let is_number = |cell: &String| cell.replace(',', ".").parse::<f64>().is_ok_and(f64::is_finite);
    let rows = || lines(text).take(MOST_LINES);
    let (row, separator, count) = rows().find_map(|(row, _, line)| {
        let separator = usual_separator(line);
        let cells = cells(line, separator);
        (cells.len() > 1 && 2 * cells.iter().filter(|c| is_number(c)).count() > cells.len()).then_some((
            row,
            separator,
            cells.len(),
        ))
    })?;
    let mut found = None;
    for (line, begin, whole) in rows().take_while(|(line, ..)| *line < row) {
        let bare = uncommented(whole);
        let mut names = cells(bare, separator);
        let fits = names.len() >= count && !names.iter().any(|c| c.is_empty() || is_number(c));
        names.sort_unstable();
        names.dedup();
        if fits && names.len() >= count {
            found = Some(Place { start: begin + whole.len() - bare.len(), line, separator });
        }
    }
    found
}

/// Empties the lines of a text below `place` that repeat the header, and the lines before them that repeat what was before the first
/// header (a file that was continued after a restart of the logger). The result has the numbers of the repeated lines.
pub(crate) fn remove_repeated(text: &mut String, place: Place) -> Vec<u64> {
    let bare = |line: &str| uncommented(line).trim_matches([' ', place.separator as char]).to_owned();
    let head = text[place.start..].lines().next().map(bare).unwrap_or_default();
    let all: Vec<&str> = lines(text).map(|(.., line)| line).collect();
    let repeated: Vec<usize> = (place.line as usize..all.len())
        .filter(|k| all[*k].contains(&head) && bare(all[*k]) == head)
        .collect();
    if repeated.is_empty() {
        return Vec::new();
    }
    let wanted = cells(&head, place.separator).len();
    let lead = |k: usize| cells(all[k], place.separator).into_iter().next().unwrap_or_default();
    let mut emptied = repeated.clone();
    for line in &repeated {
        for back in 1..place.line as usize {
            let (k, counterpart) = (line - back, place.line as usize - 1 - back);
            let is_preamble = cells(all[k], place.separator).len() < wanted || lead(k) == lead(counterpart);
            if k < place.line as usize || !is_preamble {
                break;
            }
            emptied.push(k);
        }
    }
    let kept = text.split_inclusive('\n').enumerate();
    *text = kept.map(|(k, line)| if emptied.contains(&k) { "\n" } else { line }).collect();
    repeated.into_iter().map(|k| k as u64 + 1).collect()
}
