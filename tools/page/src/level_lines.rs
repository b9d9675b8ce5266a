//! Level lines of a quantity on a rectangular grid (marching squares, Lorensen and Cline 1987 in two dimensions).

/// A point of the plane.
pub type Point = (f64, f64);

/// Pieces of the line on which `z` has the value `level`, one after the other, with a point of NaN between them. `z[j][i]` belongs to
/// `(x[i], y[j])`; cells with a corner that is no number are left out.
pub fn level_line(x: &[f64], y: &[f64], z: &[Vec<f64>], level: f64) -> Vec<Point> {
    let mut points = Vec::new();
    for j in 1..y.len() {
        for i in 1..x.len() {
            let corner = |a: usize, b: usize| ((x[a], y[b]), z[b][a] - level);
            let corners = [corner(i - 1, j - 1), corner(i, j - 1), corner(i, j), corner(i - 1, j)];
            if corners.iter().any(|c| !c.1.is_finite()) {
                continue;
            }
            let edges = (0..4).map(|k| (corners[k], corners[(k + 1) % 4]));
            let crossed: Vec<Point> =
                edges.filter(|(a, b)| (a.1 < 0.0) != (b.1 < 0.0)).map(|(a, b)| between(a, b)).collect();
            // A saddle has four crossings: two pieces.
            for piece in crossed.chunks_exact(2) {
                points.extend([piece[0], piece[1], (f64::NAN, f64::NAN)]);
            }
        }
    }
    points
}

/// The place of zero between two corners with values of different sign.
fn between((a, za): (Point, f64), (b, zb): (Point, f64)) -> Point {
    let share = za / (za - zb);
    (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of radius 0.7, closed; and a hole of what is no number.
    #[test]
    fn a_circle() {
        let x: Vec<f64> = (0..=80).map(|k| f64::from(k) / 40.0 - 1.0).collect();
        let grid = |f: &dyn Fn(f64, f64) -> f64| -> Vec<Vec<f64>> {
            x.iter().map(|b| x.iter().map(|a| f(*a, *b)).collect()).collect()
        };
        let line = level_line(&x, &x, &grid(&|a, b| a.hypot(b)), 0.7);
        let pieces: Vec<&[Point]> = line.chunks(3).collect();
        assert!(pieces.len() > 100, "{}", pieces.len());
        let length: f64 = pieces.iter().map(|p| (p[0].0 - p[1].0).hypot(p[0].1 - p[1].1)).sum();
        assert!((length / (std::f64::consts::TAU * 0.7) - 1.0).abs() < 1e-3, "{length}");
        assert!(pieces.iter().flat_map(|p| &p[..2]).all(|p| (p.0.hypot(p.1) - 0.7).abs() < 1e-3));
        let half = level_line(&x, &x, &grid(&|a, b| if a < 0.0 { f64::NAN } else { a.hypot(b) }), 0.7);
        assert!(half.len() < line.len() && half.iter().all(|p| p.0.is_nan() || p.0 >= 0.0));
    }
}
