//! Levels of significance, limits of evidence and relative tolerances that several modules share.
//!
//! Every numeric constant of this crate states in its comment why it has its value; `cargo xtask tidy` checks that. The last sentence
//! begins with one of these words:
//!
//! | word | meaning |
//! |---|---|
//! | Definition | unit, physical constant, mathematical identity, format |
//! | Derivation | follows from a calculation that the comment states |
//! | Limit | physical limit |
//! | Numerical | step, tolerance, resolution or limit of effort: a finer value changes results by less than their stated accuracy |
//! | Source | published value |
//! | Tuned | chosen because it worked; `docs/close-the-loop.md` lists these |

/// Two-sided 95 % quantile of the standard normal distribution; its square is that of chi-square with one degree of freedom.
/// Definition: 95 % of the distribution are within these standard deviations.
pub const SURE: f64 = 1.96;

/// Standard deviations, or usual deviations, beyond which a deviation is not noise. Derivation: a normal variable is outside with a
/// probability of 6e-5, less than one reading in a run of ten thousand rows.
pub const CERTAIN: f64 = 4.0;

/// Ratio of two standard deviations below which the smaller one is negligible. Derivation: variances add, so it increases the sum by 1
/// %.
pub const NEGLIGIBLE: f64 = 0.1;

/// Ratio of the mean square of a residual to that of the noise up to which the residual is noise. Derivation: 95 % quantile of
/// chi-square with [`SAMPLES`] degrees of freedom, divided by that number.
pub const AT_NOISE: f64 = 1.35;

/// Reduction of the cost from which an explanation stands out against the errors of linearization and of the noise model. Tuned: with
/// the limit for very strong evidence, 10, these errors would decide.
pub const LEAD: f64 = 30.0;

/// Reduction of the cost from which neither errors of linearization nor structure error can account for an explanation. Tuned: in 39
/// development sets of the blind suite without an effect, terms that are not true of their structure reached 91 (one 214).
pub const DECISIVE: f64 = 100.0;

/// Fraction that counts as nearly all: of the readings, or of what another candidate explains. Tuned: linearised and fitted reductions
/// of the cost differ by some hundredths.
pub const NEARLY: f64 = 0.9;

/// Structure error of a model without the missing effect, as a fraction of an output's size; errors and evidence that differ by less
/// are equal. Tuned: refits of the blind suite without the effect deviate by 1 to 5 %.
pub const STRUCTURE: f64 = 0.02;

/// Independent readings of an output in a run. Tuned: a run comprises some tens of time constants, and the structure error persists
/// over one.
pub const SAMPLES: f64 = 50.0;

/// Standard deviation of a sensor's zero, relative to its noise; of a thermometer's zero in each run. Tuned: smaller zeros are traced to
/// effects at sensors.
pub const CALIBRATED: f64 = 0.5;

/// Factor by which a missing effect, or the difference between a motor and its preset, may change an output, and a missing effect the
/// error of a refit. Tuned: a greater factor lets wrong units pass, a smaller one refuses good data.
pub const FACTOR: f64 = 3.0;

/// Fraction of the size, the range or the variation of a channel, or of its readings, that is too small to judge a sensor by. Tuned:
/// missing effects and errors of the preset leave as much.
pub const SMALL: f64 = 0.1;

/// Relative change of a part of the data (an output, a run, a section of it) that structure error may cause. Tuned: a smaller one
/// refuses real effects and tests columns without need.
pub const PART: f64 = 0.3;
