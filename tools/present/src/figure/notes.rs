//! Notes at places on the x axis: a line across the panels, and the text in a strip above the first one, where no curve is.

use super::layout::{LINE, PAD, text, width, wrap};
use maud::{Markup, html};

/// Between a line and its text, and between two texts.
const GAP: f64 = 5.0;

/// A note with its place in the strip.
struct Placed {
    px: f64,
    lines: Vec<String>,
    /// Ends of the text, and whether it ends at its line.
    ends: (f64, f64),
    is_left: bool,
    /// The lowest line of the strip that it takes, counted from the panel.
    row: usize,
}

/// The strip above a panel.
pub(super) struct Strip {
    notes: Vec<Placed>,
}

/// Puts notes, each with its place in pixels, into as few lines as they need.
pub(super) fn strip(notes: &[(f64, &str)], right: f64) -> Strip {
    let mut notes = notes.to_vec();
    // From the right: the line of a note passes at the left of the texts that are below it.
    notes.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut placed: Vec<Placed> = Vec::new();
    for (px, note) in notes {
        let rooms = (right - px - GAP, px - PAD - GAP);
        let whole = width(note);
        let is_left = whole > rooms.0 && (whole <= rooms.1 || rooms.1 > rooms.0);
        let lines = wrap(note, if is_left { rooms.1 } else { rooms.0 });
        let wide = lines.iter().map(|line| width(line)).fold(0.0, f64::max);
        let ends = if is_left { (px - GAP - wide, px - GAP) } else { (px + GAP, px + GAP + wide) };
        let rows = |of: &Placed| of.row..of.row + of.lines.len();
        let is_free = |row: usize| {
            placed.iter().all(|other| {
                let apart = ends.1 + 2.0 * GAP < other.ends.0 || other.ends.1 + 2.0 * GAP < ends.0;
                let beside = row >= rows(other).end || row + lines.len() <= other.row;
                let crosses = |line: f64, text: (f64, f64)| line > text.0 - 2.0 && line < text.1 + 2.0;
                // The line of the upper one goes down through the text of the lower one.
                let crossed = match row > other.row {
                    true => crosses(px, other.ends),
                    false => crosses(other.px, ends),
                };
                (apart || beside) && !crossed
            })
        };
        let most = placed.iter().map(|p| rows(p).end).max().unwrap_or(0);
        let row = (0..=most).find(|row| is_free(*row)).unwrap_or(most);
        placed.push(Placed { px, lines, ends, is_left, row });
    }
    Strip { notes: placed }
}

impl Strip {
    /// Height of the strip.
    pub fn height(&self) -> f64 {
        LINE * self.notes.iter().map(|p| p.row + p.lines.len()).max().unwrap_or(0) as f64
    }

    /// Texts, and lines from them to the bottom of a panel of this height, whose top is at 0.
    pub fn draw(&self, height: f64) -> Markup {
        html! {
            @for note in &self.notes {
                @let top = -LINE * (note.row + note.lines.len()) as f64;
                path.n d=(format_args!("M{:.1} {:.1}V{height:.1}", note.px, top + 2.0)) {}
            }
            @for note in &self.notes {
                @let top = -LINE * (note.row + note.lines.len()) as f64;
                @for (k, line) in note.lines.iter().enumerate() {
                    @let (at, class) = if note.is_left { (note.ends.1, "e o") } else { (note.ends.0, "o") };
                    (text(at, top + LINE * (k as f64 + 1.0) - 5.0, class, line))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Texts do not lie over each other and stay in the figure, and the strip is as low as they allow.
    #[test]
    fn notes_have_their_own_places() {
        let end = "1180 s: end of the record";
        for (notes, rows) in [
            (vec![(100.0, "window begins"), (300.0, "window ends")], 1),
            (vec![(100.0, "window begins"), (110.0, "window ends")], 2),
            (vec![(470.0, end)], 1),
            (vec![(80.0, end), (90.0, end), (100.0, end)], 3),
            (vec![], 0),
            (
                vec![(
                    250.0,
                    "a note that is longer than the figure is wide and does not fit into one of its lines at all",
                )],
                3,
            ),
        ] {
            let strip = strip(&notes, 488.0);
            assert!((strip.height() - LINE * f64::from(rows)).abs() < 1e-9, "{notes:?}: {}", strip.height());
            for (k, a) in strip.notes.iter().enumerate() {
                assert!(a.ends.0 >= PAD - 1.0 && a.ends.1 <= 489.0, "{:?}", a.ends);
                for b in &strip.notes[..k] {
                    let apart = a.ends.1 < b.ends.0 || b.ends.1 < a.ends.0;
                    assert!(apart || a.row + a.lines.len() <= b.row || b.row + b.lines.len() <= a.row);
                }
            }
        }
    }
}
