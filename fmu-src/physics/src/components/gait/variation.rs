//! Stride-to-stride variation: random numbers determined by seed, quantity and stride, smoothly interpolated.
//!
//! A hash instead of a library's generator: strides are evaluated in any order, and the results must not depend on a library version.
//! *Source* of the hash: the finaliser of SplitMix64, Steele, Lea, Flood, OOPSLA 2014.

/// Quantities that vary from stride to stride.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Stride time.
    Time = 1,
    /// Range of the angle.
    Angle = 2,
    /// Torque.
    Torque = 3,
}

/// Number of uniform variates; their sum is nearly normal.
const SUMMANDS: u64 = 12;

fn hash(mut x: u64) -> u64 {
    x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A random number of mean 0 and standard deviation 1, a function of seed, quantity and stride only.
fn number(seed: i32, quantity: Quantity, stride: i64) -> f64 {
    let start = hash(seed as u64 ^ (quantity as u64) << 40) ^ stride as u64;
    let uniform = |k: u64| (hash(start ^ k << 56) >> 11) as f64 / (1u64 << 53) as f64;
    let sum: f64 = (0..SUMMANDS).map(uniform).sum();
    (sum - 0.5 * SUMMANDS as f64).clamp(-3.0, 3.0)
}

/// The number at the coordinate `stride`, and its derivative. At the middle of a stride it is the stride's own number.
pub fn of(seed: i32, quantity: Quantity, stride: f64) -> (f64, f64) {
    let from = (stride - 0.5).floor();
    let (way, slope) = super::ramp(stride - 0.5 - from);
    let k = from as i64;
    let (a, b) = (number(seed, quantity, k), number(seed, quantity, k + 1));
    (a + (b - a) * way, (b - a) * slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_deviation_are_those_of_a_normal_number() {
        let all: Vec<f64> = (0..20_000).map(|k| number(7, Quantity::Time, k)).collect();
        let mean = all.iter().sum::<f64>() / 2e4;
        let deviation = (all.iter().map(|z| z * z).sum::<f64>() / 2e4).sqrt();
        assert!(mean.abs() < 0.02 && (deviation - 1.0).abs() < 0.02, "{mean} {deviation}");
        // Adjacent strides, quantities and seeds are uncorrelated.
        let product =
            |other: &dyn Fn(i64) -> f64| (0..20_000).map(|k| all[k as usize] * other(k)).sum::<f64>() / 2e4;
        assert!(product(&|k| number(7, Quantity::Time, k + 1)).abs() < 0.03);
        assert!(product(&|k| number(7, Quantity::Torque, k)).abs() < 0.03);
        assert!(product(&|k| number(8, Quantity::Time, k)).abs() < 0.03);
    }

    #[test]
    fn a_stride_has_its_number_in_its_middle_and_the_way_is_smooth() {
        for stride in [0.5, 3.5, 17.5] {
            let expected = number(1, Quantity::Angle, (stride - 0.5) as i64);
            assert_eq!(of(1, Quantity::Angle, stride), (expected, 0.0));
        }
        for k in 0..4000 {
            let s = 0.31 + f64::from(k) * 1e-3;
            let (low, high) = (of(1, Quantity::Angle, s - 1e-6).0, of(1, Quantity::Angle, s + 1e-6).0);
            assert!(((high - low) / 2e-6 - of(1, Quantity::Angle, s).1).abs() < 1e-4);
        }
    }
}
