//! Whether the values of a datasheet agree.
//!
//! The printed values z_i are measurements of functions g_i of the motor's constants x ([`Quantity::of`]). In logarithms,
//!
//! minimise  sum ((ln z_i - ln g_i(x)) / s_i)^2  (+ a weak prior on x)                    (1)
//!
//! with the deviation s_i of the quantity and of its rounding. A value whose removal leaves it determined by the others is redundant; it contradicts them if
//! it differs from what they give by more than [`LIMIT`] standard deviations. All relations are checked at once, also those over several
//! quantities that are not printed. If there is a contradiction, the values are named whose removal resolves it.

use super::quantities::{COLD, Motor, Quantity};
use super::{Datasheet, Value};
use least_squares::{Options, Problem, minimise};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Standard deviations from which values contradict each other.
const LIMIT: f64 = 3.0;
/// Standard deviation of the prior of a constant, in logarithms: a factor of 150 either way.
const PRIOR: f64 = 5.0;
/// A value is redundant if the others determine it to this relative standard deviation.
const DETERMINED: f64 = 0.3;
/// Wrong values that are looked for.
const MOST_WRONG: usize = 3;
/// Values whose removal resolves a contradiction equally well, as a fraction of what is left.
const EQUALLY: f64 = 0.02;
/// Range of a constant about that of a typical motor, in logarithms.
const RANGE: f64 = 30.0;
/// Difference of a logarithm for slopes.
const DIFFERENCE: f64 = 1e-6;

/// A value that the others contradict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contradiction {
    /// Key of the quantity.
    pub quantity: &'static str,
    /// Its name.
    pub words: &'static str,
    /// The printed value, in the datasheet's unit.
    pub printed: f64,
    /// What the other values give.
    pub expected: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// How the others determine it.
    pub formula: &'static str,
    /// Printed over expected; of a temperature, of the rises over the reference temperature.
    pub ratio: f64,
    /// What a ratio of this size often means.
    pub hint: Option<&'static str>,
}

/// Factors that mistakes of unit or definition make, and their names.
const FACTORS: [(f64, &str); 7] = [
    (1000.0, "a factor of 1000: a prefix"),
    (100.0, "a factor of 100: a prefix or per cent"),
    (10.0, "a factor of 10: a decimal point or a prefix"),
    (9.549_296_585, "a factor of 9.549: rpm and rad/s"),
    (2.0, "a factor of 2: phase and phase-to-phase, or poles and pole pairs"),
    (1.732_050_808, "a factor of the square root of 3: phase and phase-to-phase"),
    (std::f64::consts::SQRT_2, "a factor of the square root of 2: rms and peak"),
];

/// A printed value that follows from the constants.
struct Term {
    quantity: &'static Quantity,
    of: fn(&Motor, f64) -> f64,
    /// ln z.
    printed: f64,
    /// s of (1): that of the quantity, and rounding.
    deviation: f64,
}

/// Relative standard deviation of rounding to the digits that are shown; trailing zeros do not count, two digits always do.
fn rounding(number: f64) -> f64 {
    let text = format!("{number:e}");
    let digits =
        text.split('e').next().map_or(0, |mantissa| mantissa.chars().filter(char::is_ascii_digit).count());
    let leading = 10f64.powf(number.abs().log10().floor());
    let last = leading * 10f64.powi(1 - digits.max(2) as i32);
    last / (12f64.sqrt() * number.abs())
}

/// The problem (1).
struct Fit<'a> {
    terms: Vec<&'a Term>,
    rise: f64,
}

impl Fit<'_> {
    /// ln g of each term, then the constants.
    fn predicted(&self, x: &DVector<f64>) -> Vec<f64> {
        let motor = Motor::from_logarithms(x.as_slice());
        self.terms.iter().map(|t| (t.of)(&motor, self.rise).ln()).collect()
    }
}

impl Problem for Fit<'_> {
    type Point = DVector<f64>;
    type Slopes = DMatrix<f64>;
    type Error = std::convert::Infallible;

    fn evaluate(&self, x: &DVector<f64>) -> Result<DVector<f64>, Self::Error> {
        let typical = Motor::TYPICAL.logarithms();
        let misfit =
            self.predicted(x).into_iter().zip(&self.terms).map(|(p, t)| (p - t.printed) / t.deviation);
        let prior = x.iter().zip(typical).map(|(x, t)| (x - t) / PRIOR);
        Ok(DVector::from_vec(misfit.chain(prior).collect()))
    }

    fn cost(&self, point: &DVector<f64>) -> f64 {
        point.norm_squared()
    }

    fn linearise(&self, x: &DVector<f64>, _: &DVector<f64>) -> Result<DMatrix<f64>, Self::Error> {
        let columns: Vec<DVector<f64>> = (0..x.len())
            .map(|k| {
                let moved = |by: f64| {
                    let mut x = x.clone();
                    x[k] += by;
                    self.evaluate(&x)
                };
                Ok((moved(DIFFERENCE)? - moved(-DIFFERENCE)?) / (2.0 * DIFFERENCE))
            })
            .collect::<Result<_, Self::Error>>()?;
        Ok(DMatrix::from_columns(&columns))
    }

    fn information(&self, slopes: &DMatrix<f64>) -> DMatrix<f64> {
        slopes.transpose() * slopes
    }

    fn gradient(&self, _: &DVector<f64>, point: &DVector<f64>, slopes: &DMatrix<f64>) -> DVector<f64> {
        slopes.transpose() * point
    }
}

/// The constants that fit the terms, and their covariance.
fn fitted(terms: Vec<&Term>, rise: f64) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let fit = Fit { terms, rise };
    let start = DVector::from_row_slice(&Motor::TYPICAL.logarithms());
    let limits: Vec<(f64, f64)> = start.iter().map(|x| (x - RANGE, x + RANGE)).collect();
    let Ok(found) = minimise(&fit, start, &limits, &Options::default());
    let Ok(slopes) = fit.linearise(&found.x, &found.point);
    Some((found.x, fit.information(&slopes).try_inverse()?))
}

/// What the terms other than `k` give for it: its logarithm and the standard deviation of the difference; `None` if they do not
/// determine it.
fn by_the_others(terms: &[&Term], k: usize, rise: f64) -> Option<(f64, f64)> {
    let others: Vec<&Term> = terms.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| *t).collect();
    let (x, covariance) = fitted(others, rise)?;
    let this = Fit { terms: vec![terms[k]], rise };
    let slope = DVector::from_iterator(
        x.len(),
        (0..x.len()).map(|i| {
            let mut moved = x.clone();
            moved[i] += DIFFERENCE;
            (this.predicted(&moved)[0] - this.predicted(&x)[0]) / DIFFERENCE
        }),
    );
    let variance = slope.dot(&(&covariance * &slope));
    (variance < DETERMINED * DETERMINED)
        .then(|| (this.predicted(&x)[0], (variance + terms[k].deviation.powi(2)).sqrt()))
}

/// The places of the terms that the others contradict, with what they give, the worst first.
fn contradicted(terms: &[&Term], rise: f64) -> Vec<(usize, f64, f64)> {
    let mut found: Vec<(usize, f64, f64)> = (0..terms.len())
        .filter_map(|k| {
            let (expected, deviation) = by_the_others(terms, k, rise)?;
            let off = (terms[k].printed - expected).abs() / deviation;
            (off > LIMIT).then_some((k, expected, off))
        })
        .collect();
    found.sort_by(|a, b| b.2.total_cmp(&a.2));
    found
}

/// The terms of a datasheet, the rise of the winding's limit, and the reference temperature.
fn terms(sheet: &Datasheet) -> (Vec<Term>, f64, f64) {
    let reference = sheet.get("reference_temperature").unwrap_or(COLD);
    let rise = sheet.get("max_winding_temperature").map_or(1.0, |t| t - reference);
    let terms = sheet
        .values
        .iter()
        .filter_map(|v| {
            let of = v.quantity.of?;
            let printed = if v.quantity.key == "max_winding_temperature" { rise } else { v.si };
            let deviation = v.quantity.deviation.hypot(rounding(v.given.0));
            (printed > 0.0).then(|| Term { quantity: v.quantity, of, printed: printed.ln(), deviation })
        })
        .collect();
    (terms, rise, reference)
}

/// Whether any printed value follows from the others, or a quantity with limits follows from several of them.
pub fn is_comparable(sheet: &Datasheet) -> bool {
    let sheet = sheet.with_static_friction();
    let (terms, rise, _) = terms(&sheet);
    let terms: Vec<&Term> = terms.iter().collect();
    checks(&sheet).iter().any(|check| check.1.is_some())
        || (0..terms.len()).any(|k| by_the_others(&terms, k, rise).is_some())
}

/// The contradictions of a datasheet. Each inner list has the values of which one is wrong: removing any of them resolves the
/// contradiction.
pub fn contradictions(sheet: &Datasheet) -> Vec<Vec<Contradiction>> {
    let (terms, rise, reference) = terms(&sheet.with_static_friction());
    let mut left: Vec<&Term> = terms.iter().collect();
    let mut found = Vec::new();
    while found.len() < MOST_WRONG {
        let wrong = contradicted(&left, rise);
        if wrong.is_empty() {
            break;
        }
        let without = |k: usize| {
            let others: Vec<&Term> =
                left.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, t)| *t).collect();
            contradicted(&others, rise)
        };
        let counts: Vec<(usize, f64, f64)> = wrong
            .iter()
            .map(|&(k, expected, _)| (k, expected, without(k).iter().map(|w| w.2).sum::<f64>()))
            .collect();
        let least = counts.iter().map(|c| c.2).fold(f64::INFINITY, f64::min);
        let mut suspects: Vec<&(usize, f64, f64)> =
            counts.iter().filter(|c| c.2 <= least + EQUALLY * (1.0 + least)).collect();
        suspects.sort_by_key(|c| c.0);
        found.push(
            suspects.iter().map(|&&(k, expected, _)| contradiction(left[k], expected, reference)).collect(),
        );
        let remove = suspects[0].0;
        left.remove(remove);
    }
    found
}

fn contradiction(term: &Term, expected: f64, reference: f64) -> Contradiction {
    let Quantity { key, words, unit, formula, .. } = *term.quantity;
    let offset = if key == "max_winding_temperature" { reference } else { 0.0 };
    let shown = |logarithm: f64| Value::shown(term.quantity, logarithm.exp() + offset);
    let ratio = (term.printed - expected).exp();
    let size = ratio.ln().abs();
    let near = |f: &&(f64, &'static str)| (size - f.0.ln()).abs() < 0.02;
    let hint = FACTORS.iter().find(near).map(|f| f.1);
    Contradiction {
        quantity: key,
        words,
        printed: shown(term.printed),
        expected: shown(expected),
        unit,
        formula,
        ratio,
        hint,
    }
}

/// A value that follows from several printed ones and lies outside what motors have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Implausible {
    /// What it is, and from which values.
    pub words: &'static str,
    /// Its value.
    pub value: f64,
    /// Its limits.
    pub limits: (f64, f64),
    /// Its unit.
    pub unit: &'static str,
}

/// A quantity in words, from which values it follows, its value, limits and unit.
type Check = (&'static str, Option<f64>, (f64, f64), &'static str);

/// What is outside the limits that all motors keep.
pub fn implausible(sheet: &Datasheet) -> Vec<Implausible> {
    let outside =
        checks(&sheet.with_static_friction()).into_iter().filter_map(|(words, value, limits, unit)| {
            let value = value?;
            (value < limits.0 || value > limits.1).then_some(Implausible { words, value, limits, unit })
        });
    outside.collect()
}

/// What follows from several values and has limits that all motors keep.
///
/// Specific heats: copper 385, steel 460, magnets 450, aluminium 900 J/(kg.K); open motors whose stator alone is printed have less.
/// Densities: steel 7850, copper 8960 kg/m3; motors with air gaps and plastics from 1000 on. A rotor is within the motor. A no-load current
/// below 1e-4 of the stall current would be a maximum efficiency above 98 %. The limits of k_t are those of motors from 3 mm to 1 m of
/// diameter, with margin; a factor of 1000 in k_t is a factor of a million in two of them.
fn checks(sheet: &Datasheet) -> Vec<Check> {
    let get = |key: &str| sheet.get(key);
    let ratio = |a: Option<f64>, b: Option<f64>| Some(a? / b?);
    let (mass, diameter) = (get("mass"), get("diameter"));
    let c_w = ratio(get("winding_time_constant"), get("resistance_winding_housing"));
    let c = ratio(get("motor_time_constant"), get("resistance_housing_ambient"));
    let volume = diameter.zip(get("length")).map(|(d, l)| std::f64::consts::FRAC_PI_4 * d * d * l);
    let most_inertia = mass.zip(diameter).map(|(m, d)| m * d * d / 8.0);
    let (k_t, r, u) = (get("torque_constant"), get("terminal_resistance"), get("nominal_voltage"));
    let k_m2 = k_t.zip(r).map(|(k, r)| k * k / r);
    vec![
        (
            "specific heat of the motor: motor time constant / (thermal resistance housing-ambient x mass)",
            ratio(c, mass),
            (150.0, 1000.0),
            "J/(kg.K)",
        ),
        (
            "heat capacity of the winding / that of the motor: (winding time constant / R_wh) / (motor time constant / R_ha)",
            ratio(c_w, c),
            (0.0, 0.7),
            "1",
        ),
        ("mean density: mass / (pi/4 diameter^2 length)", ratio(mass, volume), (1000.0, 9000.0), "kg/m3"),
        (
            "rotor inertia / that of a solid cylinder of the motor's mass and diameter",
            ratio(get("rotor_inertia"), most_inertia),
            (1e-5, 1.0),
            "1",
        ),
        (
            "no-load current / nominal current",
            ratio(get("no_load_current"), get("nominal_current")),
            (0.0, 1.0),
            "1",
        ),
        (
            "no-load current / stall current: I_0 R / U; maximum efficiency (1 - sqrt(I_0 R / U))^2",
            ratio(get("no_load_current").zip(r).map(|(i, r)| i * r), u),
            (1e-4, 0.5),
            "1",
        ),
        ("no-load speed: nominal voltage / torque constant", ratio(u, k_t), (1.0, 2e4), "rad/s"),
        ("motor constant squared / mass: k_t^2 / (R x mass)", ratio(k_m2, mass), (1e-6, 1e2), "N2.m2/(W.kg)"),
        (
            "mechanical time constant: rotor inertia x R / k_t^2",
            ratio(get("rotor_inertia"), k_m2),
            (1e-5, 10.0),
            "s",
        ),
        ("number of poles / number of pole pairs", ratio(get("poles"), get("pole_pairs")), (2.0, 2.0), "1"),
        (
            "(static friction torque + dynamic friction x no-load speed) / (k_t x no-load current)",
            get("static_friction_torque")
                .zip(get("dynamic_friction").zip(get("no_load_speed")))
                .zip(get("torque_constant").zip(get("no_load_current")))
                .map(|((c, (b, w)), (k, i))| (c + b * w) / (k * i)),
            (0.7, 1.4),
            "1",
        ),
        ("maximum winding temperature", get("max_winding_temperature"), (333.15, 523.15), "K"),
    ]
}
