use maud::html;
use present::figure::*;
use present::page::*;
fn main() {
    let t: Vec<f64> = (0..200).map(|k| k as f64 * 18.0).collect();
    let course =
        |a: f64, tau: f64| t.iter().map(|t| (*t, 25.0 + a * (1.0 - (-t / tau).exp()))).collect::<Vec<_>>();
    let noise = |s: f64| {
        t.iter()
            .enumerate()
            .map(|(k, t)| (*t, s * (((k * 7919) % 101) as f64 / 50.0 - 1.0)))
            .collect::<Vec<_>>()
    };
    let a = Figure::new(
        "Winding temperature at 0.126 N·m and standstill",
        Axis::new("time in s"),
        Axis::new("winding temperature in °C"),
    )
    .line("still air", course(120.0, 900.0))
    .line("fan", course(60.0, 500.0))
    .line("fan and annulus", course(50.0, 400.0))
    .limit(155.0, "limit 155 °C")
    .note(1180.0, "1180 s: the data were recorded up to here");
    let b = Figure::new(
        "Figure 15: winding temperature over r*, 10 W",
        Axis::new("r* = r_mot/r_o"),
        Axis::new("winding temperature in K").from_to(320.0, 400.0),
    )
    .line("as published", (20..95).map(|k| (k as f64 / 100.0, 400.0 - k as f64 * 0.6)).collect())
    .points_with_bars("measured, pushed", vec![(0.75, 340.0), (0.857, 350.0)], vec![1.2; 2])
    .points_with_bars("measured, pulled", vec![(0.75, 343.0), (0.857, 356.0)], vec![1.2; 2]);
    let c = Figure::new(
        "winding temperature, without the preset",
        Axis::new("time in s"),
        Axis::new("measured − model in K"),
    )
    .thin()
    .colour(4)
    .band("noise, 95 %", vec![(0.0, 0.0), (3582.0, 0.0)], vec![0.2; 2])
    .colour(1)
    .line("refit", noise(0.6))
    .line("after", noise(0.2))
    .note(2000.0, "window ends");
    let short = ["bare", "fan 5", "fan 15", "fan 30", "40 push", "35 push", "40 pull", "35 pull"];
    let d = Figure::new(
        "Winding temperature at 10 W, all tests",
        Axis::new("distance or diameter in mm, direction of flow"),
        Axis::new("winding temperature in K"),
    )
    .points_with_bars("measured", (0..8).map(|k| (k as f64, 400.0 - 6.0 * k as f64)).collect(), vec![1.2; 8])
    .points(
        "native model, rig as fitted",
        (0..8).map(|k| (k as f64 + 0.12, 401.0 - 6.0 * k as f64)).collect(),
    )
    .categories(&short);
    let e = Rows::new(
        "Unconstrained input at each port",
        "fraction of the residual beyond noise in %",
        &[],
        ["drag torque, speed", "winding housing resistance, winding temperature", "torque constant, time"]
            .iter()
            .zip([93.0, 41.0, 7.0])
            .map(|(n, v)| Row { name: n.to_string(), marks: vec![(0, Mark::Bar(v, format!("{v:.0} %")))] })
            .collect(),
    );
    let f = Rows::new(
        "Change of the parameters",
        "change from the preset in %",
        &["after", "refit", "prior"],
        ["motor.R_ref", "conductance.G_still", "thermal.C_w"]
            .iter()
            .enumerate()
            .map(|(k, n)| {
                let k = k as f64;
                Row {
                    name: n.to_string(),
                    marks: vec![
                        (2, Mark::Span(-10.0, 10.0)),
                        (1, Mark::Point(8.0 * k, (8.0 * k - 3.0, 8.0 * k + 3.0))),
                        (0, Mark::Point(k, (k - 1.0, k + 1.0))),
                    ],
                }
            })
            .collect(),
    );
    let mut p = Figure::stacked("AnnulusCooledMotor", Axis::new("time in s"));
    for (u, s) in [("°C", 100.0), ("A", 3.0), ("m³/s", 3e-3), ("W", 2e6), ("N·m", 1e-154)] {
        p = p
            .panel(Axis::new(u))
            .line("winding_temperature", course(s, 300.0))
            .line("housing_temperature_with_a_long_name", noise(s));
    }
    let p = p.remark("Constant: torque_constant = 0.0276 N·m/A, over_temperature = false, loss_iron = 0 W, energy_balance_error = 0 J.");
    std::fs::write("/tmp/ex/panels.svg", p.svg()).unwrap();
    let body = html! { p.lead { "The motor lacks iron loss, k = 9.5e-5 N.m.s^0.5 (9.1e-5 to 9.9e-5)." } h2 { "Errors (RMSE)" }
    (table(&["runs", "output", "before", "refit", "after", "noise", "after / noise"], vec![vec!["test".into(), "winding temperature in K".into(), Cell::number(75.04), Cell::number(59.6), Cell::number(1.456), Cell::number(0.1), Cell::number(14.56)]; 3]))
    h2 { "Figures" } (plates(&[Plate::new("a", a, "A caption that is long enough to be wrapped in the column below the figure, twice at least."), Plate::new("b", b, "Error bars: ±1.2 K."), Plate::new("c", c, "c"), Plate::new("d", d, "d"), Plate::new("e", e, "e"), Plate::new("f", f, "f")]))
    h2 { "One figure" } (plates(&[Plate::new("p", p, "panels")]))
    h2 { "Four columns" } (table(&["symbol", "meaning", "value", "unit"], vec![vec![Cell::Code("motor.R_ref".into()), "Resistance of the winding at the reference temperature".into(), Cell::number(0.386), "Ohm".into()]; 2])) };
    std::fs::write("/tmp/ex/page.html", page("bench-17: calibration report", body)).unwrap();
}
