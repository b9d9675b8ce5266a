//! Figures of the paper.

use super::{Content, Page, page_of};
use crate::reproduce::paper::published::{self, DUTIES, Point};
use crate::reproduce::paper::{Compared, Paper, Parts, Run, Sample};
use crate::reproduce::{Basis, significant};
use maud::{Markup, html};
use present::figure::{Axis, Figure};
use present::page::{Cell, Plate, table};

/// The page about the paper.
pub fn paper(found: &Paper) -> Page {
    let mut plates = found.simulated.as_deref().map(simulated).unwrap_or_default();
    plates.push(temperatures(found));
    plates.push(power(found));
    page_of(Content {
        name: "paper",
        title: "A brushed gearmotor driven by PWM: the paper recomputed",
        lead: "The paper describes a brushed DC gearmotor (37D, 131:1) without load at duties of 20 to 100 % by a state function of \
               current, temperature and torque. Its figures and published numbers are recomputed here, simulated with the native \
               model where a figure is a course over time.",
        conclusion: &found.conclusion,
        absent: found.absent.as_deref(),
        plates,
        tables: compared(&found.compared),
        rows: &found.rows,
    })
}

/// Published and simulated quantities, with the parameters that were fitted to them.
fn compared(all: &[Compared]) -> Markup {
    let headers = ["quantity", "published", "simulated", "unit", "basis", "fitted parameters"];
    let rows = all.iter().map(|c| {
        let basis = if c.used_in_fit { Basis::Fitted } else { Basis::Predicted };
        vec![
            c.quantity.into(),
            Cell::Number(significant(c.published)),
            Cell::Number(significant(c.simulated)),
            c.unit.into(),
            basis.text().into(),
            Cell::Code(c.fitted.join(", ")),
        ]
    });
    html! {
        h2 { "Fitted and predicted quantities" }
        p {
            "The preset bdcm-37d is fitted to some of the published numbers. Agreement with those shows that the fit is \
             consistent; agreement with the others is a prediction."
        }
        (table(&headers, rows.collect()))
    }
}

fn over_time(run: &Run, f: impl Fn(&Sample) -> f64) -> Vec<(f64, f64)> {
    run.course.iter().map(|s| (s.time, f(s))).collect()
}

/// One line a duty.
fn five(runs: &[Run], title: &str, unit: &str, f: impl Fn(&Sample) -> f64) -> Figure {
    runs.iter().fold(Figure::new(title, Axis::new("time in s"), Axis::new(unit)), |figure, run| {
        figure.line(&format!("{} %", run.duty_percent), over_time(run, &f))
    })
}

/// The parts of a quantity at full duty.
fn parts(run: &Run, title: &str, unit: &str, f: impl Fn(&Sample) -> Parts) -> Figure {
    Figure::new(title, Axis::new("time in s"), Axis::new(unit))
        .line("total", over_time(run, |s| f(s).total))
        .line("mechanical", over_time(run, |s| f(s).mechanical))
        .line("electrical", over_time(run, |s| f(s).electrical))
        .line("magnetic", over_time(run, |s| f(s).magnetic))
}

fn simulated(runs: &[Run]) -> Vec<Plate> {
    let Some(full) = runs.last() else { return Vec::new() };
    vec![
        Plate::new(
            "4a",
            parts(full, "Figure 4a: power at 100 %", "power in W", |s| s.power),
            "The mechanical part is friction: the shaft had no load.",
        ),
        Plate::new(
            "4b",
            five(runs, "Figure 4b: power", "power in W", |s| s.power.total),
            "Voltage and current rise linearly with the duty, their product as a parabola.",
        ),
        Plate::new(
            "5a",
            parts(full, "Figure 5a: work at 100 %", "work in J", |s| s.work),
            "The unit is J; the paper writes W and kW.",
        ),
        Plate::new(
            "5b",
            five(runs, "Figure 5b: work", "work in J", |s| s.work.total),
            "Up to 900 s, as recorded.",
        ),
        Plate::new(
            "6a",
            five(runs, "Figure 6a: voltage", "voltage in V", |s| s.voltage.total),
            "At the motor's terminals, after the bridge.",
        ),
        Plate::new(
            "6b",
            five(runs, "Figure 6b: current", "current in A", |s| s.current),
            "From 5 s on, after the rotor has started.",
        ),
        Plate::new(
            "6c",
            five(runs, "Figure 6c: winding temperature", "temperature in °C", |s| s.temperature),
            "Each run starts at 20 °C; the paper does not give its initial temperatures.",
        ),
        Plate::new(
            "6d",
            five(runs, "Figure 6d: torque at the output shaft", "torque in N·m", |s| s.torque),
            "The paper's unit, µN·m per percent, is wrong by a factor of 1000.",
        ),
        Plate::new(
            "7",
            accuracy(full),
            "The paper compares eq. (14) with data from which its torque was computed. Compared with an independent model, the electrical term is wrong by the omitted constant as soon as the winding warms.",
        ),
        Plate::new(
            "8",
            parts(full, "Figure 8: voltage at 100 %", "voltage in V", |s| s.voltage),
            "In steady state the voltage across the inductance is zero.",
        ),
        Plate::new(
            "9",
            five(&runs[runs.len() - 1..], "Figure 9: current at 100 %", "current in A", |s| s.current),
            "The contributions in the paper's figure are not currents.",
        ),
        Plate::new(
            "11",
            five(
                &runs[runs.len() - 1..],
                "Figure 11: winding temperature at 100 %",
                "temperature in °C",
                |s| s.temperature,
            ),
            "The temperature still rises after 900 s; there is no plateau.",
        ),
        Plate::new(
            "12",
            five(&runs[runs.len() - 1..], "Figure 12: torque at 100 %", "torque in N·m", |s| s.torque),
            "Friction at the output shaft.",
        ),
    ]
}

/// Eq. (14) with the temperature of the run, over the run's own voltage.
fn accuracy(run: &Run) -> Figure {
    let ratio = |s: &Sample, right: bool| {
        let p = Point {
            v: s.voltage.total,
            i: s.current,
            t: s.temperature,
            torque: s.torque,
            theta: 0.0,
            q: s.current * s.time,
        };
        let resistance = if right { published::right_resistance(p.t) } else { published::resistance(p.t) };
        100.0 * (resistance * p.i + s.voltage.mechanical) / s.voltage.total
    };
    let later = |right: bool| run.course.iter().map(|s| (s.time, ratio(s, right))).collect::<Vec<_>>();
    Figure::new(
        "Figure 7: voltage by the state function over voltage, 100 %",
        Axis::new("time in s"),
        Axis::new("ratio in %"),
    )
    .line("as published, R = α R₀ T", later(false))
    .line("R = R₀ [1 + α (T − 20 °C)]", later(true))
}

fn temperatures(found: &Paper) -> Plate {
    let t = &found.temperatures;
    let (low, high) = t.plateaus_degC;
    let printed = DUTIES.iter().map(|d| (*d, if *d <= 40.0 { low } else { high })).collect::<Vec<_>>();
    let line = printed.iter().zip(&t.residuals_K).map(|((d, t), r)| (*d, t - r)).collect::<Vec<_>>();
    let mut figure = Figure::new(
        "Figure 10: winding temperature over duty",
        Axis::new("duty in %"),
        Axis::new("temperature in °C"),
    )
    .points("published", printed)
    .points("best line in power", line);
    if let Some(simulated) = &t.simulated_degC {
        figure = figure.points(
            "simulated, 900 s from 20 °C",
            DUTIES.iter().copied().zip(simulated.iter().copied()).collect(),
        );
    }
    Plate::new("10", figure, t.finding.clone())
}

fn power(found: &Paper) -> Plate {
    let points: Vec<(f64, f64)> =
        DUTIES.iter().copied().zip(found.temperatures.power_W.iter().copied()).collect();
    let line = crate::numeric::Line::through(&points);
    let straight = DUTIES.iter().filter_map(|d| Some((*d, line?.at(*d)))).collect();
    let figure = Figure::new("Power over duty", Axis::new("duty in %"), Axis::new("power in W"))
        .points("V I of the published lines", points)
        .dashed("least-squares line", straight);
    Plate::new(
        "power",
        figure,
        "The paper calls the power first-order in the duty; its own voltage and current give a parabola.",
    )
}
