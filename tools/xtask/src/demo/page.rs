//! The page of results: one file that opens without a network.

use crate::Outcome;
use maud::{Markup, html};
use present::number;
use present::page::{Cell, page, picture, table};
use present::words::words;
use serde_json::{Map, Value};

/// Units at the end of a key, and how people write them.
const UNITS: [(&str, &str); 14] = [
    ("percent_of_peak", "% of the peak"),
    ("Wh_per_hour", "W·h per hour"),
    ("rad_per_s", "rad/s"),
    ("percent", "%"),
    ("degC", "°C"),
    ("min", "min"),
    ("Nm", "N·m"),
    ("kg", "kg"),
    ("W", "W"),
    ("A", "A"),
    ("V", "V"),
    ("J", "J"),
    ("K", "K"),
    ("1", "1"),
];

/// The page of its sections.
pub fn html(walk: Markup, study: Markup, bench: Markup) -> String {
    let body = html! {
        p.lead {
            "The FMU " code { "AnnulusCooledMotor" } " (maxon EC-4pole 30) drives an ankle through a transmission and a series spring \
             in level walking: in still air and with a fan."
        }
        (walk)
        p.soft { "Made by " code { "examples/02_walking.py" } "." }
        h2 { "Continuous torque under gait" }
        p {
            "The motor of the thesis, 75 kg, in several activities and cooling arrangements: minutes until the winding reaches \
             155 °C, and the continuous fraction of the healthy ankle's torque. The figure shows the continuous torque over the mass, \
             with transmission ratio and spring swept."
        }
        (study)
        p.soft {
            "Made by " code { "examples/08_walking_study.py" } ", described in " code { "docs/walking-study.md" } ". Motor, actuator and \
             gait are one system: " a href="actuator-gait.ssp" { "actuator-gait.ssp" } "."
        }
        h2 { "Calibration with bench data" }
        p {
            "A motor on a bench, heated near standstill. The model is calibrated by runs in still air; in one run a fan was on. The \
             effect of the fan is identified from the first 60 % of that run. The table is of the rest: RMSE of the model calibrated in \
             still air, of the refit, and of the extended model."
        }
        (bench)
        p.soft {
            a href="bench.html" { "Calibration report" } ". Made by " code { "examples/04_close_the_loop_bench.py" } ", described in "
            code { "docs/close-the-loop-bench.md" } "."
        }
        h2 { "Published systems" }
        p {
            "Every number of the " a href="thesis.html" { "thesis" } " and of the " a href="paper.html" { "paper" }
            ": published, recomputed, corrected. Effect of fan and annulus: " code { "docs/what-cooling-buys.md" } "."
        }
    };
    page("A powered ankle in walking", body)
}

fn json(text: &str, of: &str) -> Outcome<Value> {
    serde_json::from_str(text).map_err(|e| format!("the results of the {of} are not JSON: {e}"))
}

fn drawn(svg: &str, caption: &str) -> Outcome<Markup> {
    picture(svg, caption).ok_or_else(|| "the figure is not SVG".into())
}

/// A key such as `current_rms_A` in words with its unit.
fn label(key: &str) -> String {
    let unit = UNITS.iter().find_map(|(end, unit)| Some((key.strip_suffix(end)?.strip_suffix('_')?, unit)));
    match unit {
        Some(("battery", unit)) => format!("battery energy in {unit}"),
        Some((name, unit)) => format!("{} in {unit}", words(name)),
        None => words(key),
    }
}

/// The study under gait: a table of activities and arrangements, and its figure.
pub fn study(results: &str, figure: &str) -> Outcome<Markup> {
    let results = json(results, "study")?;
    let arrangements = results["activities"].as_object().ok_or("the study has no activities")?;
    let mut headers = vec!["activity"];
    headers.extend(arrangements.keys().map(String::as_str));
    let mut rows = Vec::new();
    for (activity, _) in arrangements.values().next().and_then(Value::as_object).into_iter().flatten() {
        let mut cells: Vec<Cell> = vec![label(activity).into()];
        for answers in arrangements.values() {
            let answer = &answers[activity];
            let fraction =
                answer["continuous_support"].as_f64().ok_or("the study has no fraction of the torque")?;
            let minutes = answer["minutes_to_limit"].as_f64();
            let minutes = minutes.map_or_else(|| "continuous".into(), |m| format!("{m:.0}\u{a0}min"));
            cells.push(Cell::Number(format!("{minutes}, {:.0}\u{a0}%", 100.0 * fraction)));
        }
        rows.push(cells);
    }
    let caption = "Continuous torque at the joint over the mass of motor and cooling.";
    Ok(html! { (table(&headers, rows)) (drawn(figure, caption)?) })
}

/// The walk: the example's results, `{case: {quantity_unit: number}}`, and its figure.
pub fn walk(results: &str, figure: &str) -> Outcome<Markup> {
    let results: Map<String, Value> = serde_json::from_value(json(results, "walk")?)
        .map_err(|e| format!("the results of the walk are not a JSON object: {e}"))?;
    let cases: Vec<&Map<String, Value>> = results.values().filter_map(Value::as_object).collect();
    let first = cases.first().ok_or("the results of the walk name no case")?;
    let mut headers = vec!["quantity"];
    headers.extend(results.keys().map(String::as_str));
    let row = |key: &String| {
        let values = cases.iter().map(|case| cell(case.get(key).unwrap_or(&Value::Null)));
        std::iter::once(label(key).into()).chain(values).collect()
    };
    let caption = "One stride, and the temperatures of the whole walk.";
    Ok(html! { (drawn(figure, caption)?) (table(&headers, first.keys().map(row).collect())) })
}

/// The calibration: the errors over the test run, by channel.
pub fn bench(report: &str) -> Outcome<Markup> {
    let report = json(report, "bench")?;
    let errors =
        report["error"]["test"].as_object().ok_or("the bench's report has no errors of a test run")?;
    let stages = ["before", "refit", "after"];
    let rows = errors.iter().map(|(channel, error)| {
        // An error of a temperature is a difference.
        let name = label(channel).replace("in °C", "in K");
        std::iter::once(name.into()).chain(stages.iter().map(|stage| cell(&error[*stage]))).collect()
    });
    let effects = report["effects"].as_array().into_iter().flatten();
    let found: Vec<String> = effects
        .map(|e| {
            let names = std::iter::once(&e["id"]).chain(e["alternatives"].as_array().into_iter().flatten());
            let names: Vec<String> = names.map(|id| label(id.as_str().unwrap_or("?"))).collect();
            if names.len() > 1 { format!("one of {}", names.join(" or ")) } else { names.join("") }
        })
        .collect();
    let sentence = match (report["verdict"].as_str(), found.is_empty()) {
        (_, true) => "No missing effect was found.".to_owned(),
        (Some("class"), _) => {
            format!("The model lacks {}; the data do not distinguish the alternatives.", found.join(" and "))
        }
        _ => format!("The model lacks {}.", found.join(" and ")),
    };
    let headers = ["RMSE of", stages[0], stages[1], stages[2]];
    Ok(html! {
        (table(&headers, rows.collect()))
        p { (sentence) }
    })
}

/// A value for people: a dash where there is none.
fn cell(value: &Value) -> Cell {
    Cell::Number(match value {
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.into(),
        _ => value.as_f64().map_or_else(|| "–".into(), number),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIGURE: &str = "<?xml version=\"1.0\"?>\n<svg aria-label=\"f\"></svg>";
    const WALK: &str =
        r#"{"still air": {"current_rms_A": 9.23456, "limit_min": null}, "fan": {"current_rms_A": 812.3}}"#;
    const BENCH: &str = r#"{"verdict": "class", "effects": [{"id": "drive_loss", "alternatives": ["leads"]}, {"id": "forced_convection"}],
        "error": {"fit": {}, "test": {"winding_temperature_degC": {"before": 75.04, "refit": 59.6, "after": 1.456}}}}"#;

    fn studied() -> String {
        let cell = |minutes: &str, fraction: f64| {
            format!(r#"{{"walking": {{"minutes_to_limit": {minutes}, "continuous_support": {fraction}}}}}"#)
        };
        format!(r#"{{"activities": {{"bare": {}, "fan": {}}}}}"#, cell("15.1", 0.45), cell("null", 1.04))
    }

    /// The cells of the tables of a section, by row.
    fn cells(section: &Markup) -> Vec<String> {
        let text = section.clone().into_string();
        let rows = text.split("<tr>").skip(2).map(|row| {
            let cells = row.split("<td").skip(1).filter_map(|c| c.split_once('>')?.1.split_once("</td>"));
            cells.map(|(cell, _)| cell).collect::<Vec<_>>().join(" | ")
        });
        rows.collect()
    }

    #[test]
    fn the_page_follows_the_rules_of_pages() {
        let page =
            html(walk(WALK, FIGURE).unwrap(), study(&studied(), FIGURE).unwrap(), bench(BENCH).unwrap());
        assert_eq!(present::check::faults(&page), Vec::<String>::new());
        assert!(page.contains("href=\"bench.html\"") && !page.contains("<?xml"));
    }

    #[test]
    fn keys_become_labels_with_units() {
        for (key, words) in [
            ("motor_speed_peak_rad_per_s", "peak motor speed in rad/s"),
            ("energy_balance_error_percent", "energy balance error in %"),
            ("energy_electrical_drawn_J", "electrical energy drawn in J"),
            ("joint_torque_error_rms_percent_of_peak", "rms joint torque error in % of the peak"),
            ("battery_Wh_per_hour", "battery energy in W·h per hour"),
            ("strides", "strides"),
            ("iron_loss", "iron loss"),
        ] {
            assert_eq!(label(key), words);
        }
    }

    #[test]
    fn tables_hold_the_results() {
        assert_eq!(
            cells(&walk(WALK, FIGURE).unwrap()),
            ["rms current in A | 9.235 | 812.3", "limit in min | – | –"]
        );
        assert_eq!(cells(&bench(BENCH).unwrap()), ["winding temperature in K | 75.04 | 59.6 | 1.456"]);
        let text = bench(BENCH).unwrap().into_string();
        assert!(
            text.contains("The model lacks one of drive loss or leads and forced convection; the data"),
            "{text}"
        );
        assert_eq!(
            cells(&study(&studied(), FIGURE).unwrap()),
            ["walking | 15\u{a0}min, 45\u{a0}% | continuous, 104\u{a0}%"]
        );
    }

    #[test]
    fn unreadable_results_are_an_error() {
        let said = |result: Outcome<Markup>| result.unwrap_err();
        assert!(said(walk("[]", FIGURE)).contains("JSON") && said(walk("{}", FIGURE)).contains("no case"));
        assert!(said(walk("{\"a\": {}}", "png")).contains("SVG"));
        assert!(said(study("{}", FIGURE)).contains("no activities"));
        assert!(said(bench("{}")).contains("no errors") && said(bench("")).contains("not JSON"));
    }
}
