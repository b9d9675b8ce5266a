//! What lines cover, column of pixels by column: for lines that hide each other, and for places that are free for text.

use super::scale::Scale;

/// Lowest and highest covered pixel of each column of a panel; `None` where nothing is.
pub(super) struct Columns {
    left: f64,
    cells: Vec<Option<(f64, f64)>>,
}

impl Columns {
    /// Of an empty panel.
    pub fn over(x: &Scale) -> Columns {
        let wide = (x.pixels.1 - x.pixels.0).max(0.0).ceil() as usize;
        Columns { left: x.pixels.0, cells: vec![None; wide + 1] }
    }

    /// Covers a place from `low` to `high` in the columns that are within `reach` of it.
    pub fn cover(&mut self, px: f64, reach: f64, (low, high): (f64, f64)) {
        let last = self.cells.len() as f64 - 1.0;
        let at = |px: f64| (px - self.left).clamp(0.0, last);
        let (from, to) = (at(px - reach).ceil() as usize, at(px + reach).floor() as usize);
        if px + reach < self.left || px - reach > self.left + last {
            return;
        }
        // A place between two columns belongs to the nearer one.
        let (from, to) =
            if from > to { (at(px.round()) as usize, at(px.round()) as usize) } else { (from, to) };
        for cell in &mut self.cells[from..=to] {
            *cell = Some(cell.map_or((low, high), |(l, h)| (l.min(low), h.max(high))));
        }
    }

    /// Covers a line through places in pixels: where it crosses the middle of each column, and its corners, of which there may be many in a
    /// column.
    pub fn trace(&mut self, line: &[(f64, f64)]) {
        let last = self.cells.len() as f64 - 1.0;
        for pair in line.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if !(a.0 + a.1 + b.0 + b.1).is_finite() {
                continue;
            }
            self.cover(a.0, 0.5, (a.1, a.1));
            self.cover(b.0, 0.5, (b.1, b.1));
            let (a, b) = if a.0 <= b.0 { (a, b) } else { (b, a) };
            let (from, to) = ((a.0 - self.left).ceil().max(0.0), (b.0 - self.left).floor().min(last));
            let mut column = from;
            while column <= to && b.0 > a.0 {
                let y = a.1 + (self.left + column - a.0) / (b.0 - a.0) * (b.1 - a.1);
                self.cover(self.left + column, 0.0, (y, y));
                column += 1.0;
            }
        }
    }

    /// Number of columns that are covered.
    pub fn len(&self) -> usize {
        self.cells.iter().flatten().count()
    }

    /// Number of columns in which two lines cover the same, within `near` pixels across and upwards.
    pub fn shared(&self, other: &Columns, near: f64) -> usize {
        let around = |of: &Columns, k: usize| {
            let cells = of.cells[k.saturating_sub(1)..(k + 2).min(of.cells.len())].iter().flatten();
            cells.fold((f64::MAX, f64::MIN), |(l, h), cell| (l.min(cell.0), h.max(cell.1)))
        };
        let within =
            |(low, high): (f64, f64), (least, most): (f64, f64)| low >= least - near && high <= most + near;
        let both = (0..self.cells.len()).filter(|k| match (self.cells[*k], other.cells[*k]) {
            (Some(one), Some(two)) => within(one, around(other, *k)) && within(two, around(self, *k)),
            _ => false,
        });
        both.count()
    }

    /// Whether something is covered in a box.
    pub fn meets(&self, (left, right): (f64, f64), (low, high): (f64, f64)) -> bool {
        let at = |px: f64| (px - self.left).clamp(0.0, self.cells.len() as f64 - 1.0) as usize;
        self.cells[at(left.floor())..=at(right.ceil())]
            .iter()
            .flatten()
            .any(|cell| cell.0 <= high && cell.1 >= low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(line: &[(f64, f64)]) -> Columns {
        let mut all = Columns::over(&Scale { span: (0.0, 1.0), pixels: (10.0, 110.0), unit: 1.0 });
        all.trace(line);
        all
    }

    #[test]
    fn a_line_covers_what_it_passes() {
        let line = columns(&[(10.0, 0.0), (60.0, 100.0), (60.2, 5.0)]);
        assert_eq!(line.len(), 51);
        // At 35 the line is at 50; the peak is between two columns.
        assert!(line.meets((34.0, 36.0), (49.0, 51.0)) && line.meets((55.0, 65.0), (99.5, 110.0)));
        assert!(!line.meets((10.0, 20.0), (40.0, 60.0)) && !line.meets((70.0, 90.0), (0.0, 100.0)));
        assert_eq!(columns(&[(10.0, 1.0), (20.0, f64::NAN), (30.0, 1.0)]).len(), 0);
    }

    /// Lines with other corners, or moved by a pixel, are the same; lines that cross are not.
    #[test]
    fn lines_share_what_is_within_a_pixel() {
        let straight = columns(&[(10.0, 50.0), (110.0, 50.0)]);
        let cut = columns(&[(10.0, 50.9), (33.3, 50.0), (71.0, 49.1), (110.0, 50.0)]);
        let crossing = columns(&[(10.0, 0.0), (110.0, 100.0)]);
        assert_eq!((straight.shared(&cut, 1.0), straight.len()), (101, 101));
        assert!(straight.shared(&crossing, 1.0) < 5);
        // A steep line that is moved sideways by a pixel.
        let [steep, moved] = [0.0, 1.0].map(|by| columns(&[(10.0 + by, 0.0), (50.0 + by, 1000.0)]));
        assert!(steep.shared(&moved, 1.0) > 35);
    }

    /// Waves with many turns in a column are the same only if they reach as far.
    #[test]
    fn crowded_lines_are_distinguished() {
        let wave = |size: f64, frequency: f64| {
            let line = (0..=100_000).map(|k| 10.0 + f64::from(k) * 0.001);
            columns(&line.map(|px| (px, size * (frequency * px).sin())).collect::<Vec<_>>())
        };
        let (large, small, other) = (wave(50.0, 37.0), wave(20.0, 37.0), wave(50.0, 41.0));
        assert_eq!((large.shared(&small, 1.0), large.shared(&other, 1.0)), (0, 101));
    }
}
