//! The thesis: a motor with a fan and an annulus (chapters 3 to 7, appendices).

mod identified;
pub mod measured;
mod native;
pub mod projection;
pub mod published;
mod rows;

pub use identified::UNCERTAINTY;
pub use measured::{CASES, Case, T_AMBIENT};
pub use native::{FITTED, course, fit_thesis_rig, winding_at};

use super::{Row, significant};
use crate::StudyError;
use crate::fit::{Fit, LeftOut};
use published::Annulus;
use serde::Serialize;

/// A test: measured, as the thesis computed it, as the model computes it.
#[derive(Clone, Debug, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct CaseResult {
    /// Name.
    pub name: &'static str,
    /// Item of the model's `cooling_mode`.
    pub cooling_mode: &'static str,
    /// The parameter that distinguishes the test from others of its mode, and its value in m.
    pub setting: Option<(&'static str, f64)>,
    /// Power put into the winding, W.
    pub power_W: f64,
    /// Ambient temperature, K.
    pub ambient_K: f64,
    /// Steady winding temperature as measured, K.
    pub T_w_measured_K: f64,
    /// Housing to ambient as measured, K/W.
    pub R_ha_measured: f64,
    /// Winding temperature by the published equations, K; the thesis computed annuli only.
    pub T_w_as_published_K: Option<f64>,
    /// Winding temperature of the native model fitted to all eight tests, K: the agreement is that of a fit.
    pub T_w_model_K: f64,
    /// Winding temperature of the untuned native model, K.
    pub T_w_untuned_K: f64,
    /// Winding temperature of the native model fitted to the other seven tests, K; absent where no fit is made.
    pub T_w_leave_one_out_K: Option<f64>,
    /// Housing to ambient by the calibrated native model's winding temperature, as the measured one is computed, K/W.
    pub R_ha_model: f64,
    /// 5 A times the torque constant at the measured temperature, per total mass, N.m/kg.
    pub torque_density_at_5A: f64,
    /// Continuous torque at stall with the winding at 155 degC, from the measured R_ha, N.m.
    pub torque_at_limit: f64,
    /// The same per total mass, N.m/kg.
    pub torque_density_at_limit: f64,
    /// The same torque from `T_w_model_K`, N.m.
    pub torque_at_limit_model: f64,
    /// The same torque from `T_w_untuned_K`, N.m.
    pub torque_at_limit_untuned: f64,
    /// The same torque from `T_w_leave_one_out_K`, N.m.
    pub torque_at_limit_leave_one_out: Option<f64>,
}

impl CaseResult {
    /// Housing to ambient from a winding temperature, as the thesis computes it, K/W: all heat through R_wh and R_ha,
    /// none through the leads.
    pub fn r_ha(&self, t_w: f64) -> f64 {
        projection::r_ha(t_w, self.ambient_K, self.power_W)
    }
}

/// Results of the published annulus model.
#[derive(Clone, Copy, Debug, Serialize)]
#[allow(non_snake_case)] // the keys of the JSON contract
pub struct Published {
    /// Winding temperature in the 40 mm annulus, K.
    pub T_at_0_75_K: f64,
    /// Winding temperature in the 35 mm annulus, K.
    pub T_at_0_857_K: f64,
    /// Ratio of radii with the greatest Reynolds number.
    pub argmax_Re_r_star: f64,
    /// That Reynolds number.
    pub Re_max: f64,
    /// Reynolds number in the 40 mm annulus.
    pub Re_at_0_75: f64,
    /// Where the curve jumps.
    pub jumps_r_star: Option<(f64, f64)>,
    /// Winding temperatures before and behind each jump, K.
    pub jump_K: Option<[(f64, f64); 2]>,
}

/// Everything about the thesis.
#[derive(Clone, Debug, Serialize)]
pub struct Thesis {
    /// The eight tests.
    pub cases: Vec<CaseResult>,
    /// The published model.
    pub published: Published,
    /// Every published number.
    pub rows: Vec<Row>,
    /// The answer to the thesis's question, computed from the cases.
    pub conclusion: String,
    /// Predictions of the calibrated model for tests that were not used in the calibration.
    pub leave_one_out: Option<Vec<LeftOut>>,
    /// Identifiability of the fitted parameters from the eight tests.
    pub identifiability: Option<Fit>,
    /// The same in sentences: which parameters are determined, which only together, which not at all.
    pub findings: Vec<String>,
}

/// Which fits are made: each costs seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fits {
    /// None.
    None,
    /// The fit of the rig, and that without each test.
    Rig,
    /// Also fits with other causes in place of fitted parameters.
    Alternatives,
}

/// Recomputes the thesis.
///
/// # Errors
/// A native model that does not settle.
pub fn thesis(fits: Fits) -> Result<Thesis, StudyError> {
    let (leave_one_out, identifiability) = match fits {
        Fits::None => (None, None),
        Fits::Rig | Fits::Alternatives => {
            let problem = fit_thesis_rig(&FITTED)?;
            let fit = problem.fit()?;
            (Some(problem.leave_one_out(&fit)?), Some(fit))
        }
    };
    let alternatives = if fits == Fits::Alternatives { identified::alternatives()? } else { Vec::new() };
    let left_out = |name: &str| leave_one_out.iter().flatten().find(|l| l.case == name).map(|l| l.predicted);
    let case = |case: &Case| result(case, left_out(case.name));
    let cases = CASES.iter().map(case).collect::<Result<Vec<_>, _>>()?;
    let findings = match (&identifiability, &leave_one_out) {
        (Some(fit), Some(left_out)) => identified::findings(fit, left_out, &alternatives, &cases),
        _ => Vec::new(),
    };
    Ok(Thesis {
        findings,
        published: published_summary(),
        rows: rows::rows(&cases),
        conclusion: conclusion(&cases),
        leave_one_out,
        identifiability,
        cases,
    })
}

fn result(case: &Case, left_out: Option<f64>) -> Result<CaseResult, StudyError> {
    let torque_at_limit = projection::torque_at_limit(case.r_ha);
    let (fitted, untuned) = (native::winding(case, true)?, native::winding(case, false)?);
    let r_ha = |t_w: f64| projection::r_ha(t_w, case.ambient(), measured::POWER);
    let torque = |t_w: f64| projection::torque_at_limit(r_ha(t_w));
    Ok(CaseResult {
        name: case.name,
        cooling_mode: case.cooling_mode,
        setting: case.setting,
        power_W: measured::POWER,
        ambient_K: case.ambient(),
        T_w_measured_K: case.t_w,
        R_ha_measured: case.r_ha,
        T_w_as_published_K: case.r_star().map(|r| Annulus::new(r).winding_temperature()),
        T_w_model_K: fitted,
        T_w_untuned_K: untuned,
        T_w_leave_one_out_K: left_out,
        R_ha_model: r_ha(fitted),
        torque_density_at_5A: projection::torque_at_5_a(case.t_w) / case.mass,
        torque_at_limit,
        torque_density_at_limit: torque_at_limit / case.mass,
        torque_at_limit_model: torque(fitted),
        torque_at_limit_untuned: torque(untuned),
        torque_at_limit_leave_one_out: left_out.map(torque),
    })
}

fn published_summary() -> Published {
    let (argmax, re_max) = published::summit();
    let jumps = published::jumps(published::RE_SWITCH);
    let both = |r: f64| {
        let annulus = Annulus::new(r);
        (
            annulus.winding_temperature_by(published::LAMINAR),
            annulus.winding_temperature_by(published::TURBULENT),
        )
    };
    Published {
        T_at_0_75_K: Annulus::new(measured::WIDE).winding_temperature(),
        T_at_0_857_K: Annulus::new(measured::NARROW).winding_temperature(),
        argmax_Re_r_star: argmax,
        Re_max: re_max,
        Re_at_0_75: Annulus::new(measured::WIDE).reynolds(),
        jumps_r_star: jumps,
        // Into the turbulent branch at the first jump, out of it at the second.
        jump_K: jumps.map(|(left, right)| [both(left), (both(right).1, both(right).0)]),
    }
}

/// Effect of cooling, from the thesis's own measurements.
fn conclusion(cases: &[CaseResult]) -> String {
    let (bare, cooled) = match cases.split_first() {
        Some((bare, cooled)) if !cooled.is_empty() => (bare, cooled),
        _ => return String::new(),
    };
    let best = |f: &dyn Fn(&CaseResult) -> f64| {
        let order = |a: &&CaseResult, b: &&CaseResult| f(a).total_cmp(&f(b));
        cooled.iter().max_by(order).map_or((bare.name, f(bare)), |c| (c.name, f(c)))
    };
    let range = |f: &dyn Fn(&CaseResult) -> f64| {
        cooled
            .iter()
            .map(|c| 100.0 * (f(c) / f(bare) - 1.0))
            .fold((f64::MAX, f64::MIN), |(l, h), p| (l.min(p), h.max(p)))
    };
    let densities = |annulus: bool| {
        let of_kind = cooled.iter().filter(move |c| c.T_w_as_published_K.is_some() == annulus);
        of_kind.map(|c| c.torque_density_at_limit)
    };
    let worst_fan = densities(false).fold(f64::MAX, f64::min);
    let best_annulus = densities(true).fold(f64::MIN, f64::max);
    let fan_alone =
        if worst_fan > best_annulus { ", and the fan alone is better than every tested annulus" } else { "" };
    let (at_5_a, density_at_5_a) = best(&|c| c.torque_density_at_5A);
    let (at_limit, torque) = best(&|c| c.torque_at_limit);
    let (least_torque, most_torque) = range(&|c| c.torque_at_limit);
    let (least, most) = range(&|c| c.torque_density_at_limit);
    format!(
        "At the same 5 A the best arrangement is {at_5_a} with {} N.m/kg against {} bare ({:+.1} %), so at constant current the benefit of cooling does not \
         show; at a winding of 155 degC the continuous stall torque rises from {} N.m \
         bare to {} N.m ({at_limit}), over all arrangements by {least_torque:.0} to {most_torque:.0} % and its density \
         by {least:.0} to {most:.0} %: cooling does improve the motor{fan_alone}.",
        significant(density_at_5_a),
        significant(bare.torque_density_at_5A),
        100.0 * (density_at_5_a / bare.torque_density_at_5A - 1.0),
        significant(bare.torque_at_limit),
        significant(torque),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The audit's numbers: T26, T41, T50; the conclusion names what they say.
    #[test]
    fn the_thesis_comes_out() {
        let thesis = thesis(Fits::None).unwrap();
        let bare = &thesis.cases[0];
        assert_eq!((bare.name, bare.T_w_as_published_K), ("bare", None));
        assert!((bare.torque_density_at_5A - 0.394).abs() < 1e-3);
        assert!((thesis.published.T_at_0_75_K - 343.1).abs() < 1.0);
        assert!((thesis.published.argmax_Re_r_star - 0.626).abs() < 0.01);
        for words in ["fan-5mm", "0.4141", "0.3937", "+5.2 %", "the fan alone is better"] {
            assert!(thesis.conclusion.contains(words), "{words} in {}", thesis.conclusion);
        }
        // The fitted rig is within 0.5 K of every test; the untuned model is not (audit: up to 21 K).
        for case in &thesis.cases {
            let miss = |t: f64| (t - case.T_w_measured_K).abs();
            assert!(miss(case.T_w_model_K) < 0.5, "{case:?}");
            assert!((case.R_ha_model - case.R_ha_measured).abs() < 0.06, "{case:?}");
            assert!(miss(case.T_w_untuned_K) < 22.0, "{case:?}");
            assert!(case.T_w_leave_one_out_K.is_none(), "no fit was asked for");
        }
        let json = serde_json::to_value(&thesis).unwrap();
        for key in ["cases", "published", "rows", "conclusion", "leave_one_out", "identifiability"] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert!(json["cases"][4]["torque_at_limit"].as_f64().is_some_and(|t| (t - 0.173).abs() < 1e-3));
    }
}
