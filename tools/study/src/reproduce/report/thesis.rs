//! Figures and tables of the thesis.

use super::{Content, Page, Texts, page_of};
use crate::numeric::linspace;
use crate::reproduce::significant;
use crate::reproduce::thesis::measured::{FAN_FLOW, MOTOR_DIAMETER, NARROW, T_25, T_REF, WIDE};
use crate::reproduce::thesis::published::{self, Annulus, RE_SWITCH};
use crate::reproduce::thesis::{
    CASES, Case, CaseResult, Thesis, UNCERTAINTY, course, projection, winding_at,
};
use maud::{Markup, html};
use present::page::{Cell, Plate, table};
use present::{typeset, words};
use rayon::prelude::*;

/// Narrowest r* to which the fitted rig may be trusted: its leak was fitted between 0.75 and 0.857.
const FITTED_FROM: f64 = 0.70;

/// The page about the thesis.
pub fn thesis(found: &Thesis) -> Page {
    // Results first, then where the publication differs from them.
    let texts = Texts::read(include_str!("thesis.toml"));
    let mut plates = vec![cases(&texts, found), densities(&texts, found)];
    plates.extend(temperature_over_radius(&texts, found));
    plates.extend(step_response(&texts));
    plates.extend([operating_points(&texts), reynolds(&texts), torque_over_temperature(&texts)]);
    page_of(Content {
        name: "thesis",
        title: "A motor with a fan and an annulus: the thesis recomputed",
        lead: "The thesis heats a maxon EC-4pole 30 (305015) with 10 W at standstill: bare, with a 40 mm fan at three distances, and \
               in annuli of 40 and 35 mm with pushed and pulled air. Its figures, tables and published numbers are recomputed here \
               and compared with the native model.",
        conclusion: &found.conclusion,
        plates,
        tables: tables(found),
        rows: &found.rows,
    })
}

fn torque_over_temperature(texts: &Texts) -> Plate {
    let line = |f: &dyn Fn(f64) -> f64| {
        linspace(293.15, 473.15, 91).into_iter().map(|t| (t, f(t))).collect::<Vec<_>>()
    };
    let specimen = projection::resistance(T_REF, projection::specimen_resistance(), T_25);
    texts.plate("3", |figure| {
        figure
            .line("10 W, eq. (6), 0.386 Ω", line(&|t| projection::torque_at_10_w(t, 0.386)))
            .line("10 W, the specimen's resistance", line(&|t| projection::torque_at_10_w(t, specimen)))
            .dashed("5 A", line(&projection::torque_at_5_a))
            .points("published torques", CASES.iter().map(|c| (c.t_w, c.torque)).collect())
    })
}

fn step_response(texts: &Texts) -> Option<Plate> {
    let course = course(&CASES[0], "winding_resistance", 3.0 * 3600.0, 240).ok()?;
    let minutes: Vec<(f64, f64)> = course.into_iter().map(|(t, r)| (t / 60.0, r)).collect();
    let end = minutes.last()?.1;
    let caption = format!(
        "The model settles at {end:.3} Ω; the thesis gives 0.5 Ω, extrapolated from the first 20 minutes."
    );
    Some(texts.captioned("5", caption, |figure| {
        figure
            .line("native model, fitted to all tests", minutes)
            .points("published steady value", vec![(180.0, CASES[0].resistance)])
            .note(1180.0 / 60.0, "1180 s: end of the record")
    }))
}

fn operating_points(texts: &Texts) -> Plate {
    let litres = |flow: f64| 1e3 * flow;
    let flows = linspace(0.0, FAN_FLOW, 81);
    let fan: Vec<(f64, f64)> = flows.iter().map(|q| (litres(*q), published::fan_pressure(*q))).collect();
    texts.plate("14", |figure| {
        let mut figure = figure.line("fan, linear between its end points", fan);
        let mut points = Vec::new();
        for r_star in [0.5, 0.63, 0.75, 0.857] {
            let annulus = Annulus::new(r_star);
            let line = flows.iter().skip(1).map(|q| (litres(*q), annulus.pressure_drop(*q))).collect();
            figure = figure.line(&format!("r* = {r_star}"), line);
            points.push((litres(annulus.flow()), published::fan_pressure(annulus.flow())));
        }
        figure.points("operating points", points)
    })
}

/// The published curve in its branches, interrupted at the jumps.
fn published_curve(from: f64, to: f64) -> Vec<(f64, f64)> {
    let mut curve: Vec<(f64, f64)> = Vec::new();
    let mut turbulent = None;
    for r in linspace(from, to, 321) {
        let annulus = Annulus::new(r);
        let now = annulus.reynolds() >= RE_SWITCH;
        if turbulent.is_some_and(|before| before != now) {
            curve.push((r, f64::NAN));
        }
        turbulent = Some(now);
        curve.push((r, annulus.winding_temperature()));
    }
    curve
}

fn native_curve(from: f64, to: f64, calibrated: bool) -> Vec<(f64, f64)> {
    let at = |r: f64| Some((r, winding_at(MOTOR_DIAMETER / r, calibrated)?));
    let all = linspace(from, to, 36).into_par_iter().map(at);
    all.collect::<Option<Vec<_>>>().unwrap_or_default()
}

fn temperature_over_radius(texts: &Texts, found: &Thesis) -> Vec<Plate> {
    let measured = |mode: &str| {
        let of_mode = |c: &&Case| c.cooling_mode == mode;
        CASES.iter().filter(of_mode).filter_map(|c| Some((c.r_star()?, c.t_w))).collect::<Vec<_>>()
    };
    let bars = vec![UNCERTAINTY; 2];
    let jumps = published::jumps(RE_SWITCH);
    let caption = jumps.map_or(String::new(), |(a, b)| {
        format!("The published curve jumps at r* = {a:.2} and {b:.2}, where Re passes {RE_SWITCH:.0}; its optimum follows from Re alone. Error bars: ±{UNCERTAINTY} K.")
    });
    let plate = |name: &'static str, (from, to): (f64, f64), caption: String| {
        texts.captioned(name, caption, |figure| {
            let mut figure = figure.line("as published", published_curve(from, to));
            let untuned = native_curve(from.max(0.4), to, false);
            let fitted = native_curve(from.max(FITTED_FROM), to.min(0.90), true);
            if !untuned.is_empty() {
                figure = figure.line("native model, untuned", untuned);
            }
            if !fitted.is_empty() {
                figure = figure.line("native model, fitted to all tests", fitted);
            }
            figure
                .points_with_bars("measured, pushed", measured("annulus_push"), bars.clone())
                .points_with_bars("measured, pulled", measured("annulus_pull"), bars.clone())
        })
    };
    vec![plate("15", (0.2, 0.95), caption), plate("17", (0.70, 0.90), untuned_errors(found))]
}

/// The errors of the untuned prediction in the annuli, in sentences.
fn untuned_errors(found: &Thesis) -> String {
    let annuli = found.cases.iter().filter(|c| c.T_w_as_published_K.is_some());
    let errors: Vec<f64> = annuli.map(|c| c.T_w_untuned_K - c.T_w_measured_K).collect();
    let (least, most) = errors.iter().fold((f64::MAX, f64::MIN), |(l, m), e| (l.min(*e), m.max(*e)));
    if errors.is_empty() {
        return String::new();
    }
    let verdict = if most < -UNCERTAINTY {
        "The annuli received less air than the untuned model assumes, or lost heat on a path that it overestimates."
    } else if least > UNCERTAINTY {
        "The untuned model cools less than the rig did."
    } else {
        "The errors have both signs or are within the uncertainty of the measurement."
    };
    format!("Errors of the untuned prediction in the tested annuli: {least:+.1} to {most:+.1} K. {verdict}")
}

fn reynolds(texts: &Texts) -> Plate {
    let line = linspace(published::R_STAR.0, published::R_STAR.1, 201).into_iter();
    let (r_star, re) = published::summit();
    texts.plate("18", |figure| {
        figure
            .line("as published", line.map(|r| (r, Annulus::new(r).reynolds())).collect())
            .limit(RE_SWITCH, "laminar to turbulent")
            .points("tested annuli", [WIDE, NARROW].map(|r| (r, Annulus::new(r).reynolds())).to_vec())
            .note(r_star, &format!("r* = {r_star:.3}, Re = {re:.0}"))
    })
}

const SHORT: [&str; 8] = ["bare", "fan 5", "fan 15", "fan 30", "40 push", "35 push", "40 pull", "35 pull"];

fn cases(texts: &Texts, found: &Thesis) -> Plate {
    let of = |f: &dyn Fn(&CaseResult) -> Option<f64>, shift: f64| {
        let point = |(k, c)| Some((k as f64 + shift, f(c)?));
        found.cases.iter().enumerate().filter_map(point).collect::<Vec<_>>()
    };
    let bars = vec![UNCERTAINTY; found.cases.len()];
    let left_out = found.leave_one_out.as_ref().map_or(String::new(), |all| {
        let errors: Vec<String> = all.iter().map(|l| format!("{} {:+.1} K", l.case, l.error)).collect();
        format!("Leave-one-out prediction errors: {}. Error bars: ±{UNCERTAINTY} K.", errors.join(", "))
    });
    texts.captioned("cases", left_out, |figure| {
        figure
            .points_with_bars("measured", of(&|c| Some(c.T_w_measured_K), 0.0), bars)
            .points("fitted to all tests", of(&|c| Some(c.T_w_model_K), 0.12))
            .points("leave-one-out", of(&|c| c.T_w_leave_one_out_K, 0.22))
            .points("untuned", of(&|c| Some(c.T_w_untuned_K), 0.32))
            .points("as published", of(&|c| c.T_w_as_published_K, -0.12))
            .categories(&SHORT)
    })
}

fn densities(texts: &Texts, found: &Thesis) -> Plate {
    let of = |f: &dyn Fn(&CaseResult) -> f64| {
        found.cases.iter().enumerate().map(|(k, c)| (k as f64, f(c))).collect::<Vec<_>>()
    };
    let published = CASES.iter().enumerate().map(|(k, c)| (k as f64 + 0.12, c.density));
    texts.plate("density", |figure| {
        figure
            .points("at 5 A", of(&|c| c.torque_density_at_5A))
            .points("continuous, at a winding of 155 °C", of(&|c| c.torque_density_at_limit))
            .points("as published", published.collect())
            .categories(&SHORT)
    })
}

/// Tables 1 to 3 with the model's predictions.
fn tables(found: &Thesis) -> Markup {
    let headers = [
        "case",
        "place",
        "R in Ω",
        "T_w in K, measured",
        "fitted to all tests (error)",
        "leave-one-out (error)",
        "untuned (error)",
        "as published (error)",
        "R_ha in K/W",
        "R_ha, fitted",
        "torque in N·m",
        "mass in kg",
        "density in N·m/kg",
        "density at 5 A",
        "torque at 155 °C",
    ];
    let number = |v: f64| Cell::Number(significant(v));
    let with =
        |digits: usize, v: Option<f64>| Cell::Number(v.map_or("–".to_owned(), |v| format!("{v:.digits$}")));
    let rows = CASES.iter().zip(&found.cases).map(|(case, result)| {
        let off = |t: f64| format!("{t:.1} ({:+.1})", t - case.t_w);
        let with_error = |t: Option<f64>| Cell::Number(t.map_or("–".to_owned(), off));
        vec![
            case.name.into(),
            case.location.into(),
            number(case.resistance),
            with(1, Some(case.t_w)),
            with_error(Some(result.T_w_model_K)),
            with_error(result.T_w_leave_one_out_K),
            with_error(Some(result.T_w_untuned_K)),
            with_error(result.T_w_as_published_K),
            with(2, Some(case.r_ha)),
            with(2, Some(result.R_ha_model)),
            number(case.torque),
            number(case.mass),
            number(case.density),
            number(result.torque_density_at_5A),
            number(result.torque_at_limit),
        ]
    });
    html! {
        h2 { "Tables 1 to 3" }
        (table(&headers, rows.collect()))
        @if !found.findings.is_empty() {
            h2 { "Identifiability of the fitted parameters" }
            ul { @for sentence in &found.findings { li { (typeset(&words::sentence(sentence))) } } }
        }
    }
}
