//! What the eight tests can say about the fitted parameters, in sentences.

use super::{CASES, CaseResult};
use crate::fit::{Fit, LeftOut};
use crate::reproduce::significant;

/// Correlation beyond which two parameters are known together only.
const TOGETHER: f64 = 0.7;

/// One sentence each: what is known, what only together, what not at all, and what the model misses unfitted.
pub fn findings(fit: &Fit, left_out: &[LeftOut], cases: &[CaseResult]) -> Vec<String> {
    let mut all = Vec::new();
    let known: Vec<String> = fit
        .parameters
        .iter()
        .map(|p| {
            let deviation = p.deviation.map_or("unknown".to_owned(), significant);
            format!("{} = {} ± {deviation}", p.name, significant(p.value))
        })
        .collect();
    all.push(format!(
        "Six parameters fitted to eight temperatures leave two degrees of freedom: rms {:.2} K, {} (one standard \
         deviation).",
        fit.rms,
        known.join(", ")
    ));
    for (i, row) in fit.correlations.iter().enumerate() {
        for (k, r) in row.iter().enumerate().skip(i + 1).filter(|(_, r)| r.abs() > TOGETHER) {
            let (a, b) = (&fit.parameters[i].name, &fit.parameters[k].name);
            all.push(format!(
                "{a} and {b} are known together rather than each by itself (correlation {r:.2})."
            ));
        }
    }
    for case in left_out.iter().filter(|c| !c.at_limit.is_empty()) {
        all.push(format!(
            "Without the test {} nothing says {}, and that test is missed by {:+.1} K.",
            case.case,
            case.at_limit.join(", "),
            case.error
        ));
    }
    all.push(
        "Temperature of the winding alone cannot tell an emissivity from the conduction of leads and mount, nor a leak \
         from a slower fan, a blocked gap or a poor contact of stator and housing: each would fit about as well. A \
         thermometer on the housing and one in the outlet would decide."
            .to_owned(),
    );
    let miss = |which: &dyn Fn(&str) -> bool| {
        let misses = CASES.iter().zip(cases).filter(|(case, _)| which(case.name));
        let misses = misses.filter_map(|(case, c)| Some(format!("{:+.1}", c.T_w_untuned_K? - case.t_w)));
        misses.collect::<Vec<_>>().join(", ")
    };
    all.push(format!(
        "With nothing fitted the model misses the bare motor by {} K (emissivity of cleaned stainless steel, 0.22, \
         Incropera, 7th ed., table A.11), the fan alone by {} K and the annuli by {} K.",
        miss(&|name| name == "bare"),
        miss(&|name| name.starts_with("fan")),
        miss(&|name| name.starts_with("annulus"))
    ));
    all
}
