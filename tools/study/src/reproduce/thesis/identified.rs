//! What the eight tests determine of the fitted parameters, in sentences that are computed from the fits.

use super::native::{FITTED, fit_thesis_rig};
use super::{CASES, CaseResult};
use crate::StudyError;
use crate::fit::{Fit, LeftOut};
use crate::reproduce::significant;

/// Correlation beyond which two parameters are determined together only.
const TOGETHER: f64 = 0.7;
/// Standard uncertainty of a measured winding temperature, K (audit, T58: 0.9 to 1.2).
pub const UNCERTAINTY: f64 = 1.2;
/// Other causes of the same temperatures: a fitted parameter, and one that is fitted in its place.
const INSTEAD: [(&str, &str); 4] = [
    ("housing.emissivity", "thermal.G_leads"),
    ("housing.emissivity", "thermal.G_mount"),
    ("annulus.leak_area", "fan.flow_max"),
    ("annulus.leak_area", "thermal.R_sh"),
];

/// A fit with another parameter in place of one of the six.
#[derive(Clone, Debug)]
pub struct Alternative {
    /// The parameter that stays at its declared value.
    fitted: &'static str,
    /// The parameter that is fitted in its place.
    instead: &'static str,
    /// Root mean square of the residuals, K.
    rms: f64,
}

/// Fits with other parameters in place of the leak and the emissivity.
///
/// # Errors
/// A model that does not settle at the start.
pub fn alternatives() -> Result<Vec<Alternative>, StudyError> {
    let alternative = |(fitted, instead)| {
        let parameters = FITTED.map(|name| if name == fitted { instead } else { name });
        Ok(Alternative { fitted, instead, rms: fit_thesis_rig(&parameters)?.fit()?.rms })
    };
    INSTEAD.into_iter().map(alternative).collect()
}

/// One sentence each: what is determined, what only together, what not at all, which other causes explain the tests as well,
/// and the errors of the predictions.
pub fn findings(
    fit: &Fit,
    left_out: &[LeftOut],
    alternatives: &[Alternative],
    cases: &[CaseResult],
) -> Vec<String> {
    let mut all = Vec::new();
    let known: Vec<String> = fit
        .parameters
        .iter()
        .map(|p| {
            let deviation = p.deviation.map_or("unknown".to_owned(), significant);
            format!("{} = {} ± {deviation}", p.name, significant(p.value))
        })
        .collect();
    let (parameters, tests) = (fit.parameters.len(), fit.residuals.len());
    all.push(format!(
        "{parameters} parameters are fitted to {tests} temperatures, {} degrees of freedom: rms residual {:.2} K, {} (one \
         standard deviation).",
        tests.saturating_sub(parameters),
        fit.rms,
        known.join(", ")
    ));
    for (i, row) in fit.correlations.iter().enumerate() {
        for (k, r) in row.iter().enumerate().skip(i + 1).filter(|(_, r)| r.abs() > TOGETHER) {
            let (a, b) = (&fit.parameters[i].name, &fit.parameters[k].name);
            all.push(format!("{a} and {b} are determined together only (correlation {r:.2})."));
        }
    }
    let error = |of: &dyn Fn(&CaseResult) -> Option<f64>| {
        let errors: Vec<f64> = cases.iter().filter_map(|c| Some(of(c)? - c.T_w_measured_K)).collect();
        (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt()
    };
    all.push(format!(
        "Rms error of the winding temperature: {:.1} K fitted to all tests, {:.1} K predicted from the other tests \
         (leave-one-out), {:.1} K predicted untuned.",
        error(&|c| Some(c.T_w_model_K)),
        error(&|c| c.T_w_leave_one_out_K),
        error(&|c| Some(c.T_w_untuned_K))
    ));
    for case in left_out.iter().filter(|c| !c.at_limit.is_empty()) {
        all.push(format!(
            "Without the test {} the others do not determine {}; the prediction error of that test is {:+.1} K.",
            case.case,
            case.at_limit.join(", "),
            case.error
        ));
    }
    let (as_well, worse): (Vec<_>, Vec<_>) = alternatives.iter().partition(|a| a.rms <= UNCERTAINTY);
    let list = |some: &[&Alternative]| {
        let one = |a: &&Alternative| format!("{} in place of {} ({:.2} K)", a.instead, a.fitted, a.rms);
        some.iter().map(one).collect::<Vec<_>>().join(", ")
    };
    if !as_well.is_empty() {
        all.push(format!(
            "These fits also stay within the measurement's uncertainty of {UNCERTAINTY} K, so the winding temperatures do \
             not distinguish the causes: {}.",
            list(&as_well)
        ));
    }
    if !worse.is_empty() {
        all.push(format!(
            "These fits exceed the measurement's uncertainty of {UNCERTAINTY} K: {}.",
            list(&worse)
        ));
    }
    let miss = |which: &dyn Fn(&str) -> bool| {
        let misses = CASES.iter().zip(cases).filter(|(case, _)| which(case.name));
        let misses = misses.map(|(case, c)| format!("{:+.1}", c.T_w_untuned_K - case.t_w));
        misses.collect::<Vec<_>>().join(", ")
    };
    all.push(format!(
        "Errors of the untuned prediction: bare motor {} K (emissivity of cleaned stainless steel, 0.22, Incropera, 7th \
         ed., table A.11), fan alone {} K, annuli {} K.",
        miss(&|name| name == "bare"),
        miss(&|name| name.starts_with("fan")),
        miss(&|name| name.starts_with("annulus"))
    ));
    all
}
