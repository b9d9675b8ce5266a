//! Figures of the paper.

use super::{Content, Page, Texts, page_of};
use crate::reproduce::paper::published::{self, DUTIES, Point};
use crate::reproduce::paper::{Compared, Paper, Parts, Run, Sample};
use crate::reproduce::{Basis, significant};
use maud::{Markup, html};
use present::figure::Figure;
use present::page::{Cell, Plate, table};

/// The page about the paper.
pub fn paper(found: &Paper) -> Page {
    let texts = Texts::read(include_str!("paper.toml"));
    let mut plates = simulated(&texts, &found.simulated);
    plates.extend([temperatures(&texts, found), power(&texts, found)]);
    page_of(Content {
        name: "paper",
        title: "A brushed gearmotor driven by PWM: the paper recomputed",
        lead: "The paper describes a brushed DC gearmotor (37D, 131:1) without load at duties of 20 to 100 % by a state function of \
               current, temperature and torque. Its figures and published numbers are recomputed here, simulated with the native \
               model where a figure is a course over time.",
        conclusion: &found.conclusion,
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

fn simulated(texts: &Texts, runs: &[Run]) -> Vec<Plate> {
    let Some(full) = runs.last() else { return Vec::new() };
    // The parts of a quantity at full duty.
    let parts = |name, f: fn(&Sample) -> Parts| {
        texts.plate(name, |figure| {
            figure
                .line("total", over_time(full, |s| f(s).total))
                .line("mechanical", over_time(full, |s| f(s).mechanical))
                .line("electrical", over_time(full, |s| f(s).electrical))
                .line("magnetic", over_time(full, |s| f(s).magnetic))
        })
    };
    // One line a duty.
    let lines = |name, runs: &[Run], f: fn(&Sample) -> f64| {
        texts.plate(name, |figure| {
            runs.iter().fold(figure, |figure, run| {
                figure.line(&format!("{} %", run.duty_percent), over_time(run, f))
            })
        })
    };
    let last = std::slice::from_ref(full);
    vec![
        parts("4a", |s| s.power),
        lines("4b", runs, |s| s.power.total),
        parts("5a", |s| s.work),
        lines("5b", runs, |s| s.work.total),
        lines("6a", runs, |s| s.voltage.total),
        lines("6b", runs, |s| s.current_A),
        lines("6c", runs, |s| s.temperature),
        lines("6d", runs, |s| s.torque),
        texts.plate("7", |figure| accuracy(full, figure)),
        parts("8", |s| s.voltage),
        lines("9", last, |s| s.current_A),
        lines("11", last, |s| s.temperature),
        lines("12", last, |s| s.torque),
    ]
}

/// Eq. (14) with the temperature of the run, over the run's own voltage.
fn accuracy(run: &Run, figure: Figure) -> Figure {
    let ratio = |s: &Sample, right: bool| {
        let p =
            Point { i: s.current_A, t: s.temperature, torque: s.torque, theta: 0.0, q: s.current_A * s.time };
        let resistance = if right { published::right_resistance(p.t) } else { published::resistance(p.t) };
        100.0 * (resistance * p.i + s.voltage.mechanical) / s.voltage.total
    };
    let later = |right: bool| run.course.iter().map(|s| (s.time, ratio(s, right))).collect::<Vec<_>>();
    figure.line("as published, R = α R₀ T", later(false)).line("R = R₀ [1 + α (T − 20 °C)]", later(true))
}

fn temperatures(texts: &Texts, found: &Paper) -> Plate {
    let t = &found.temperatures;
    let printed: Vec<_> = found.measured.iter().map(|m| (m.duty_percent, m.temperature_degC)).collect();
    let line = printed.iter().zip(&t.residuals_K).map(|((d, t), r)| (*d, t - r)).collect::<Vec<_>>();
    let simulated = DUTIES.iter().copied().zip(t.simulated_degC.iter().copied()).collect();
    texts.plate("10", |figure| {
        figure
            .points("published", printed)
            .points("best line in power", line)
            .points("simulated, 900 s from 20 °C", simulated)
    })
}

fn power(texts: &Texts, found: &Paper) -> Plate {
    let points: Vec<(f64, f64)> =
        DUTIES.iter().copied().zip(found.temperatures.power_W.iter().copied()).collect();
    let line = crate::numeric::Line::through(&points);
    let straight = DUTIES.iter().filter_map(|d| Some((*d, line?.at(*d)))).collect();
    texts.plate("power", |figure| {
        figure.points("V I of the published lines", points).dashed("least-squares line", straight)
    })
}
