//! The page of results: one file that opens without a network.

use crate::Outcome;
use serde_json::{Map, Value};

const HEAD: &str = r#"<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>motor-fmu: a powered ankle walks</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; color: #222 }
svg { width: 100%; height: auto }
table { border-collapse: collapse; margin-top: 1rem }
th, td { padding: .2rem .8rem; border-bottom: 1px solid #ddd; text-align: right }
th:first-child, td:first-child { text-align: left }
td { font-variant-numeric: tabular-nums }
</style>
<h1>A powered ankle walks</h1>
<p>The FMU <code>AnnulusCooledMotor</code> (maxon EC-4pole 30) drives an ankle through a transmission and a series
spring. Angle and torque are those of level walking. The run is made by <code>examples/02_walking.py</code>.</p>
<p>Where the models come from: <a href="thesis.html">the thesis</a> and <a href="paper.html">the paper</a>, every number printed,
recomputed and put right. What a fan and an annulus buy: <code>docs/what-cooling-buys.md</code>.</p>
"#;

const STUDY: &str = r#"<h2>What cooling buys under gait</h2>
<p>The same motor as the thesis measured it, 75 kg, all of a healthy ankle's torque: minutes until the winding reaches 155 °C, and the share
of the torque that can be given for ever. Below, the torque that can be walked for ever over the mass, with transmission ratio and
spring swept. Made by <code>examples/08_walking_study.py</code>, told in <code>docs/walking-study.md</code>. The system of motor, actuator and
gait is <a href="actuator-gait.ssp">one file</a> that any SSP tool opens.</p>
"#;

const BENCH: &str = r#"<h2>A measured motor: what did the fan do?</h2>
<p>Logs of a motor on a bench, heated near standstill. The model is calibrated by runs in still air; in one run a fan was on, and its
first 60 % tell what the fan did. The table is of the rest of that run, which nothing was fitted to: the error (RMSE) of the model as
still air left it, of its parameters fitted once more, and of the repaired model. <a href="bench.html">The report</a>, with
figures; made by <code>examples/04_close_the_loop_bench.py</code>, told in <code>docs/close-the-loop-bench.md</code>.</p>
"#;

/// The page of its sections.
pub fn html(walk: &str, study: &str, bench: &str) -> String {
    format!("{HEAD}{walk}\n{STUDY}{study}\n{BENCH}{bench}\n</html>\n")
}

/// What the study under gait gave: a table of activities and arrangements, and its figure.
pub fn study(results: &str, figure: &str) -> Outcome<String> {
    let results: Value =
        serde_json::from_str(results).map_err(|e| format!("the results of the study are no JSON: {e}"))?;
    let arrangements = results["activities"].as_object().ok_or("the study has no activities")?;
    let mut rows = String::from("<table>\n<tr><th>");
    arrangements.keys().for_each(|name| rows += &format!("<th>{}", escaped(name)));
    let activities = arrangements.values().next().and_then(Value::as_object).into_iter().flatten();
    for (activity, _) in activities {
        rows += &format!("\n<tr><td>{}", escaped(activity));
        for answers in arrangements.values() {
            let answer = &answers[activity];
            let share = answer["support_for_ever"].as_f64().ok_or("the study has no share of the torque")?;
            let minutes = answer["minutes_to_limit"].as_f64();
            let minutes = minutes.map_or_else(|| "for ever".into(), |m| format!("{m:.0} min"));
            rows += &format!("<td>{minutes}, {:.0} %", 100.0 * share);
        }
    }
    Ok(format!("{rows}\n</table>\n{}", inside_a_page(figure)?))
}

/// An SVG without its prologue, as pages hold it.
fn inside_a_page(figure: &str) -> Outcome<&str> {
    Ok(figure.find("<svg").map(|at| &figure[at..]).ok_or("the figure is no SVG")?)
}

/// What the walk gave: the example's results, `{case: {quantity_unit: number}}`, and its figure.
pub fn walk(results: &str, figure: &str) -> Outcome<String> {
    let results: Map<String, Value> = serde_json::from_str(results)
        .map_err(|e| format!("the results of the walk are no JSON object: {e}"))?;
    Ok(format!("{}\n{}", inside_a_page(figure)?, table(&results)?))
}

/// What closing the loop came to: the errors over the test run, by channel.
pub fn bench(report: &str) -> Outcome<String> {
    let report: Value =
        serde_json::from_str(report).map_err(|e| format!("the bench's report is no JSON: {e}"))?;
    let errors =
        report["error"]["test"].as_object().ok_or("the bench's report has no errors of a test run")?;
    let stages = ["before", "refit", "after"];
    let mut rows = String::from("<table>\n<tr><th>");
    stages.iter().for_each(|stage| rows += &format!("<th>{stage}"));
    for (channel, error) in errors {
        rows += &format!("\n<tr><td>{}", escaped(&channel.replace('_', " ").replace(" degC", ", K")));
        stages.iter().for_each(|stage| rows += &format!("<td>{}", cell(&error[*stage])));
    }
    let effects = report["effects"].as_array().into_iter().flatten();
    let found: Vec<String> = effects
        .map(|e| {
            let names = std::iter::once(&e["id"]).chain(e["alternatives"].as_array().into_iter().flatten());
            let names: Vec<String> = names.map(|id| id.as_str().unwrap_or("?").replace('_', " ")).collect();
            names.join(" or ")
        })
        .collect();
    let verdict = report["verdict"].as_str().unwrap_or("?");
    Ok(format!("{rows}\n</table>\n<p>Verdict: {}; {}.</p>", escaped(verdict), escaped(&found.join(", "))))
}

fn table(results: &Map<String, Value>) -> Outcome<String> {
    let cases: Vec<&Map<String, Value>> = results.values().filter_map(Value::as_object).collect();
    let first = cases.first().ok_or("the results of the walk name no case")?;
    let mut rows = String::from("<table>\n<tr><th>");
    results.keys().for_each(|name| rows += &format!("<th>{}", escaped(name)));
    for key in first.keys() {
        rows += &format!("\n<tr><td>{}", escaped(&key.replace('_', " ")));
        for case in &cases {
            rows += &format!("<td>{}", cell(case.get(key).unwrap_or(&Value::Null)));
        }
    }
    Ok(rows + "\n</table>")
}

/// What a reader sees of a value: a dash where there is none.
fn cell(value: &Value) -> String {
    match value {
        Value::Bool(yes) => if *yes { "yes" } else { "no" }.into(),
        _ => value.as_f64().map_or_else(|| "–".into(), number),
    }
}

/// Four significant digits.
fn number(x: f64) -> String {
    let magnitude = if x == 0.0 { 3 } else { x.abs().log10().floor().clamp(-6.0, 3.0) as i32 };
    format!("{x:.*}", (3 - magnitude) as usize)
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figure_and_numbers_are_in_the_page() {
        let results = r#"{"still air": {"current_rms_A": 9.23456, "limit_min": null}, "fan": {"current_rms_A": 812.3}}"#;
        let page = walk(results, "<?xml version=\"1.0\"?>\n<svg id=\"f\"></svg>").unwrap();
        assert!(page.contains("<svg id=\"f\">") && !page.contains("<?xml"));
        assert!(page.contains("<tr><td>current rms A<td>9.235<td>812.3"), "{page}");
        assert!(page.contains("<tr><td>limit min<td>–<td>–"), "{page}");
    }

    #[test]
    fn the_bench_is_told_by_its_test_run() {
        let report = r#"{"verdict": "class", "effects": [{"id": "drive_loss", "alternatives": ["leads"]}, {"id": "forced_convection"}],
            "error": {"fit": {}, "test": {"winding_temperature_degC": {"before": 75.04, "refit": 59.6, "after": 1.456}}}}"#;
        let told = bench(report).unwrap();
        assert!(told.contains("<tr><td>winding temperature, K<td>75.04<td>59.60<td>1.456"), "{told}");
        assert!(told.contains("Verdict: class; drive loss or leads, forced convection."), "{told}");
        let page = html("<svg id=\"w\"/>", "<p>study</p>", &told);
        assert!(
            page.starts_with("<!doctype")
                && page.ends_with("</html>\n")
                && page.contains("href=\"bench.html\"")
        );
        assert!(page.contains("<svg id=\"w\"/>") && page.contains("<p>study</p>") && page.contains(&told));
        assert!(bench("{}").unwrap_err().contains("no errors") && bench("").unwrap_err().contains("no JSON"));
    }

    #[test]
    fn the_study_is_a_table_with_its_figure() {
        let cell = |minutes: &str, share: f64| {
            format!(r#"{{"walking": {{"minutes_to_limit": {minutes}, "support_for_ever": {share}}}}}"#)
        };
        let results =
            format!(r#"{{"activities": {{"bare": {}, "fan": {}}}}}"#, cell("15.1", 0.45), cell("null", 1.04));
        let told = study(&results, "<?xml?><svg id=\"s\"/>").unwrap();
        assert!(told.contains("<tr><td>walking<td>15 min, 45 %<td>for ever, 104 %"), "{told}");
        assert!(told.contains("<svg id=\"s\"/>") && !told.contains("<?xml"));
        assert!(study("{}", "<svg/>").unwrap_err().contains("no activities"));
    }

    #[test]
    fn numbers_have_four_digits() {
        for (x, text) in [(0.0, "0"), (12345.6, "12346"), (0.012345, "0.01235"), (-9.87654, "-9.877")] {
            assert_eq!(number(x), text);
        }
        assert_eq!([cell(&Value::Null), cell(&true.into()), cell(&2.0.into())], ["–", "yes", "2.000"]);
    }

    #[test]
    fn results_that_are_none_are_an_error() {
        assert!(walk("[]", "<svg/>").unwrap_err().contains("JSON"));
        assert!(walk("{}", "<svg/>").unwrap_err().contains("no case"));
        assert!(walk("{\"a\": {}}", "png").unwrap_err().contains("SVG"));
    }
}
