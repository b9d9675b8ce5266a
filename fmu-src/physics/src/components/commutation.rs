//! Distribution of the current to the three phases, and the temperature of the hottest phase.
//!
//! The electrical equations are those of an equivalent direct-current motor: i is the current of which R i^2 is
//! the copper loss of all phases, R the resistance between two terminals.
//!
//! block:       two of three phases carry i in turn, a sector of 60 electrical degrees each
//! sinusoidal:  i = sqrt(3)/2 times the amplitude of the phase currents; torque pi/3 k_t i        (1)
//! fraction of the copper loss in phase k at the electrical angle a:
//!              block 1/2 in both active phases;  sinusoidal (2/3) cos^2(a - 2 pi k/3)              (2)
//! heat of phase k: Q_k = s_k [a + b delta_k],   b = R_ref alpha <i^2>                               (3)
//! C_w/3 d(delta_k)/dt = Q_k - sum_j Q_j/3 - G_w delta_k/3                                          (4)
//! resistance in use: R at T_w + sum_k s_k delta_k                                                  (5)
//!
//! delta_k is the temperature of phase k above the winding's mean; a is the loss at the winding's mean temperature: copper loss with
//! ripple, contact voltage drop, electrical_power and terms at the port winding_heat. b accounts for the higher resistance of a hot phase.
//! G_w is the conductance from the winding to its neighbours: 1/R_wh as modified by effects, the rotor, the leads. Rotation averages the
//! fractions; at stall one pair of phases has all of the loss (block), or one phase two thirds of it (sinusoidal).
//! *Assumes* sinusoidal back-EMF, for which a data sheet's k_t (block commutation) is 3/pi of the peak: (1); ideal
//! rotor position; one third of the winding's capacity and conductance in each phase; the input heat_power distributed evenly.
//! *Neglects* torque ripple (block: mean of 14 % from peak to peak) and the current's change within a sector.
//! *Sign*: delta sums to zero. *Range*: any angle, any step size.
//! *Source*: (1) Hendershot, Miller, Design of Brushless Permanent-Magnet Machines (2010), ch. 7; maxon academy,
//! EC motors, on block and sinusoidal commutation; (3) and (4) derived here.

use crate::solver::phi::Phi;
use declare::enumeration;
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::{FRAC_PI_3, PI, TAU};

enumeration! {
    /// Distribution of the current to the phases.
    pub enum Commutation {
        /// Equivalent DC motor: all phases have the same loss.
        EquivalentDc = 1, "equivalent_dc";
        /// Block commutation: six steps, two phases carry the current.
        Block = 2, "block";
        /// Sinusoidal commutation: three sinusoidal currents.
        Sinusoidal = 3, "sinusoidal";
    }
}

/// Phases of the winding.
pub const PHASES: usize = 3;

impl Commutation {
    /// Torque relative to that with the data sheet's k_t at the same copper loss, eq. (1).
    pub fn torque_factor(self) -> f64 {
        match self {
            Commutation::EquivalentDc | Commutation::Block => 1.0,
            Commutation::Sinusoidal => FRAC_PI_3,
        }
    }

    /// Fractions of the copper loss, eq. (2), averaged between two electrical angles, rad.
    pub fn shares(self, from: f64, to: f64) -> [f64; PHASES] {
        std::array::from_fn(|k| {
            let shift = TAU / 3.0 * k as f64;
            let (a, b) = (from - shift, to - shift);
            let even = 1.0 / 3.0;
            match self {
                Commutation::EquivalentDc => even,
                Commutation::Sinusoidal => {
                    // 2/3 cos^2 = 1/3 + cos(2a)/3; its mean from the integral, or its value if the angle is constant.
                    let way = b - a;
                    let wave = if way.abs() < 1e-6 {
                        (2.0 * a).cos()
                    } else {
                        ((2.0 * b).sin() - (2.0 * a).sin()) / (2.0 * way)
                    };
                    even + wave / 3.0
                }
                Commutation::Block => {
                    let way = b - a;
                    if way.abs() < 1e-6 {
                        if conducts(k, from) { 0.5 } else { 0.0 }
                    } else {
                        0.5 * (conducted(b) - conducted(a)) / way
                    }
                }
            }
        })
    }
}

/// Whether phase `k` of six-step commutation conducts: 120 of each 180 degrees, centred where its current peaks.
/// The sector is computed once for all phases, so that exactly two conduct at any angle, despite rounding.
fn conducts(k: usize, angle: f64) -> bool {
    let sector = (angle / FRAC_PI_3).floor().rem_euclid(3.0);
    // Each phase lags the previous one by two sectors, and begins to conduct one sector before its peak.
    (sector + 1.0 + k as f64).rem_euclid(3.0) < 2.0
}

/// Angle over which a phase has conducted since its angle was 0.
fn conducted(angle: f64) -> f64 {
    let a = angle + FRAC_PI_3;
    let turns = (a / PI).floor();
    turns * 2.0 * FRAC_PI_3 + (a - turns * PI).min(2.0 * FRAC_PI_3)
}

/// Temperature of each phase above the winding's mean, K.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phases {
    /// One value per phase; their sum is 0.
    pub above: [f64; PHASES],
}

crate::saved!(Phases { above });

/// Heat and cooling of the phases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseLoad {
    /// Loss of all phases at the winding's mean temperature, a of eq. (3), W.
    pub heat: f64,
    /// Derivative of the loss with respect to a phase's own temperature, b of eq. (3), W/K.
    pub per_kelvin: f64,
    /// Heat capacity of the winding, J/K.
    pub capacity: f64,
    /// Conductance from the winding to its neighbours, G_w of eq. (4), W/K.
    pub conductance: f64,
}

impl PhaseLoad {
    /// Mean of the two loads.
    pub fn middle(&self, to: &PhaseLoad) -> PhaseLoad {
        PhaseLoad {
            heat: 0.5 * (self.heat + to.heat),
            per_kelvin: 0.5 * (self.per_kelvin + to.per_kelvin),
            capacity: 0.5 * (self.capacity + to.capacity),
            conductance: 0.5 * (self.conductance + to.conductance),
        }
    }
}

impl Phases {
    /// State after `h` seconds of a load with these fractions, eq. (4): exact for a constant load. The sum of all three stays 0, so
    /// only two are solved.
    pub fn after(&self, h: f64, load: &PhaseLoad, shares: &[f64; PHASES]) -> Phases {
        let [s0, s1, s2] = *shares;
        let (b, g) = (load.per_kelvin, load.conductance);
        let matrix =
            Matrix2::new(b * (2.0 * s0 + s2) - g, -b * (s1 - s2), -b * (s0 - s2), b * (2.0 * s1 + s2) - g)
                / load.capacity;
        let forcing = Vector2::new(3.0 * s0 - 1.0, 3.0 * s1 - 1.0) * (load.heat / load.capacity);
        let above = Vector2::new(self.above[0], self.above[1]);
        let end = above + Phi::new(matrix, h).constant(&(matrix * above + forcing));
        Phases { above: [end[0], end[1], -end[0] - end[1]] }
    }

    /// The rates of eq. (4), K/s, with the arguments of [`after`](Phases::after).
    pub fn rates(&self, load: &PhaseLoad, shares: &[f64; PHASES]) -> [f64; PHASES] {
        let heat: [f64; PHASES] =
            std::array::from_fn(|k| shares[k] * (load.heat + load.per_kelvin * self.above[k]));
        let all: f64 = heat.iter().sum();
        std::array::from_fn(|k| (3.0 * heat[k] - all - load.conductance * self.above[k]) / load.capacity)
    }

    /// Temperature of the hottest phase above the winding's mean, K.
    pub fn hottest(&self) -> f64 {
        self.above.iter().fold(0.0, |m, d| m.max(*d))
    }

    /// Temperature of the conducting phases above the winding's mean, eq. (5), K.
    pub fn in_use(&self, shares: &[f64; PHASES]) -> f64 {
        self.above.iter().zip(shares).map(|(d, s)| d * s).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODES: [Commutation; 3] = [Commutation::EquivalentDc, Commutation::Block, Commutation::Sinusoidal];

    /// The fractions sum to 1 at any angle and over any rotation, and are equal over whole turns.
    #[test]
    fn all_of_the_loss_is_somewhere() {
        for mode in MODES {
            for k in 0..200 {
                let a = 0.1 * f64::from(k) - 7.0;
                for way in [0.0, 1e-7, 0.3, -2.0, 400.0] {
                    let sum: f64 = mode.shares(a, a + way).iter().sum();
                    assert!((sum - 1.0).abs() < 1e-9, "{mode:?} {a} {way}: {sum}");
                }
                for share in mode.shares(a, a + TAU) {
                    assert!((share - 1.0 / 3.0).abs() < 1e-12, "{mode:?}");
                }
            }
        }
    }

    /// At stall: block, two phases with half each; sinusoidal, the phase at its peak with two thirds.
    #[test]
    fn one_pair_carries_all_at_stall() {
        let mut block = Commutation::Block.shares(0.2, 0.2);
        block.sort_by(f64::total_cmp);
        assert_eq!(block, [0.0, 0.5, 0.5]);
        assert_eq!(Commutation::Block.shares(0.0, 0.0).iter().sum::<f64>(), 1.0);
        for k in 0..600 {
            // The instantaneous value agrees with the mean over a short rotation from the same angle.
            let a = 0.0313 * f64::from(k) - 9.0;
            let (now, soon) = (Commutation::Block.shares(a, a), Commutation::Block.shares(a, a + 1e-4));
            let sector = (a / FRAC_PI_3).floor() == ((a + 1e-4) / FRAC_PI_3).floor();
            assert!(!sector || now.iter().zip(soon).all(|(x, y)| (x - y).abs() < 1e-9), "{a}");
        }
        assert!((Commutation::Sinusoidal.shares(0.0, 0.0)[0] - 2.0 / 3.0).abs() < 1e-15);
    }

    /// The mean over a rotation equals the average of many points.
    #[test]
    fn the_mean_is_the_mean() {
        for mode in MODES {
            let (a, b) = (0.4, 5.1);
            let points = 100_000;
            let mean = (0..points)
                .map(|k| {
                    let x = a + (b - a) * (f64::from(k) + 0.5) / f64::from(points);
                    mode.shares(x, x)[1]
                })
                .sum::<f64>()
                / f64::from(points);
            assert!((mean - mode.shares(a, b)[1]).abs() < 1e-4, "{mode:?}");
        }
    }

    /// 10 W held at stall through 0.21 K/W: a pair is 0.5 x 0.21 x 10 = 1.05 K above the mean, the third
    /// phase 2.1 K below.
    #[test]
    fn the_hot_spot_settles_by_hand() {
        let shares = Commutation::Block.shares(0.2, 0.2);
        let load = PhaseLoad { heat: 10.0, per_kelvin: 0.0, capacity: 10.05, conductance: 1.0 / 0.21 };
        let phases = Phases::default().after(1e3, &load, &shares);
        assert!((phases.hottest() - 1.05).abs() < 1e-9);
        assert!(phases.above.iter().sum::<f64>().abs() < 1e-12);
        assert!((phases.in_use(&shares) - 1.05).abs() < 1e-9);
        let halves = Phases::default().after(1.0, &load, &shares);
        let twice = halves.after(1.0, &load, &shares);
        let once = Phases::default().after(2.0, &load, &shares);
        assert!((twice.hottest() - once.hottest()).abs() < 1e-12);
    }

    /// A pair whose loss grows by b with its own temperature reaches the steady state (a + b d)/2 - (a + b d)/3 = G d/3:
    /// d = a/2 / (G - b/2).
    #[test]
    fn a_hot_phase_resists_more_by_hand() {
        let shares = Commutation::Block.shares(0.2, 0.2);
        let load = PhaseLoad { heat: 154.4, per_kelvin: 0.6, capacity: 10.05, conductance: 1.0 / 0.21 };
        let settled = 0.5 * 154.4 / (1.0 / 0.21 - 0.3);
        let phases = Phases::default().after(1e3, &load, &shares);
        assert!((phases.hottest() / settled - 1.0).abs() < 1e-12, "{phases:?} {settled}");
        assert!(phases.rates(&load, &shares).iter().all(|rate| rate.abs() < 1e-11));
        // The rates are the time derivative of the solution, for any fractions.
        for shares in [[0.5, 0.5, 0.0], [0.1, 0.3, 0.6], [0.0, 0.5, 0.5]] {
            let phases = Phases { above: [3.0, -1.0, -2.0] };
            let (rates, h) = (phases.rates(&load, &shares), 1e-5);
            let (ahead, back) = (phases.after(h, &load, &shares), phases.after(-h, &load, &shares));
            for (k, rate) in rates.iter().enumerate() {
                let slope = (ahead.above[k] - back.above[k]) / (2.0 * h);
                assert!((rate - slope).abs() < 1e-7 * rate.abs().max(1.0), "{shares:?} {k}: {rate} {slope}");
            }
        }
    }
}
