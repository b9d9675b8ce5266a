//! Plugs that are exchanged in simulated data with noise, and what is none of this.

use super::*;
use crate::intake::check;
use crate::intake::tests::{AMBIENT, CURRENT, HOUSING, WINDING, column, experiment, with_inputs};
use crate::testing::{normal, rng};

const BOTH: (usize, usize) = (WINDING, HOUSING);

/// Exchanges two columns of a run in some rows.
fn exchange(data: &mut Experiment, run: usize, (a, b): (usize, usize), (from, to): (usize, usize)) {
    let columns = &mut data.runs[run].table.columns;
    let [own, other] = [a, b].map(|k| columns[k][from..to].to_vec());
    columns[a][from..to].copy_from_slice(&other);
    columns[b][from..to].copy_from_slice(&own);
}

/// Rows of a run that are blank in both thermometers.
fn blank(data: &Experiment, run: usize) -> Vec<usize> {
    let columns = &data.runs[run].table.columns;
    let is_blank = |row: &usize| [WINDING, HOUSING].iter().all(|k| columns[*k][*row].is_nan());
    (0..columns[WINDING].len()).filter(is_blank).collect()
}

/// The greatest difference of the thermometers, K, in rows that the check sets aside wrongly, or leaves.
fn missed(data: &mut Experiment, run: usize, truth: &Experiment, wrong: &[(usize, usize)]) -> f64 {
    assert_eq!(set_aside(data, &[], &Deadline::default()), None);
    let found = blank(data, run);
    let columns = &truth.runs[run].table.columns;
    let is_wrong =
        |row: &usize| wrong.iter().any(|(from, to)| (*from..*to).contains(row)) != found.contains(row);
    let difference = |row: usize| (columns[WINDING][row] - columns[HOUSING][row]).abs();
    (0..columns[WINDING].len()).filter(is_wrong).map(difference).fold(0.0, f64::max)
}

fn loaded(seed: u64, load: f64) -> Experiment {
    with_inputs(seed, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= load))
}

/// From a row to the end, from the start, in between, several times; at rest (row 280) and under load; with the winding up to 1 K, 4 K and
/// 40 K above the housing.
#[test]
fn exchanged_readings_are_set_aside() {
    let sections: [&[(usize, usize)]; 7] = [
        &[(700, 1200)],
        &[(0, 450)],
        &[(280, 1200)],
        &[(240, 820)],
        &[(400, 700), (900, 1000)],
        &[(520, 545)],
        &[(0, 100), (1000, 1200)],
    ];
    for (seed, load) in [(31, 1.0), (32, 0.5), (33, 3.0)] {
        let truth = loaded(seed, load);
        for rows in sections.iter().filter(|rows| load > 0.9 || rows[0].1 - rows[0].0 > 200) {
            let mut wrong = truth.clone();
            rows.iter().for_each(|rows| exchange(&mut wrong, 0, BOTH, *rows));
            let missed = missed(&mut wrong, 0, &truth, rows);
            assert!(missed < 0.6, "{load} {rows:?}: {missed} K, {:?}", wrong.notes);
            let counts: Vec<usize> = wrong.notes.iter().map(|note| note.matches("from ").count()).collect();
            assert_eq!(counts, [rows.len()], "{:?}", wrong.notes);
        }
    }
}

/// Beside steps of the load at both ends.
#[test]
fn a_section_of_a_few_rows_is_no_exchange() {
    for seed in 66..70 {
        let mut short = loaded(seed, 1.0);
        exchange(&mut short, 0, BOTH, (500, 530));
        assert_eq!(set_aside(&mut short, &[], &Deadline::default()), None);
        let count = blank(&short, 0).len();
        assert!(count == 0 || (NEAR..=31).contains(&count), "{seed}: {count}, {:?}", short.notes);
    }
}

/// While one load lasts there is no other evidence than that each channel continues the other one.
#[test]
fn an_exchange_at_a_constant_load_is_seen_where_it_begins() {
    let constant = |columns: &mut [Vec<f64>]| {
        columns[CURRENT].fill(4.0);
        columns[1].fill(250.0);
        columns[2].fill(0.0);
    };
    let truth = with_inputs(34, constant);
    let sections: [&[(usize, usize)]; 2] = [&[(600, 1200)], &[(300, 500), (700, 900)]];
    for rows in sections {
        let mut wrong = truth.clone();
        rows.iter().for_each(|rows| exchange(&mut wrong, 0, BOTH, *rows));
        assert_eq!(missed(&mut wrong, 0, &truth, rows), 0.0, "{rows:?} {:?}", wrong.notes);
    }
}

/// Rows at the exchange that are blank, out of range, at zero or anywhere; spikes elsewhere.
#[test]
fn wrong_rows_at_the_exchange_do_not_hide_it() {
    let truth = loaded(35, 3.0);
    for reading in [f64::NAN, 1643.15, 273.15, 330.0] {
        for count in [1, 4] {
            let mut wrong = truth.clone();
            exchange(&mut wrong, 0, BOTH, (520, 1200));
            for k in [WINDING, HOUSING] {
                column(&mut wrong, k)[520..520 + count].fill(reading);
                [100, 350].iter().for_each(|row| column(&mut wrong, k)[*row] += 50.0);
            }
            column(&mut wrong, WINDING)[860..910].fill(1643.15);
            let missed = missed(&mut wrong, 0, &truth, &[(520, 1200)]);
            assert!(missed < 1.0, "{reading} {count}: {missed} K, {:?}", wrong.notes);
            assert!(!wrong.notes.is_empty(), "{reading} {count}");
        }
    }
}

/// At rest, where both are equal: the changes of the load tell. One of the two has another zero, or both follow an air that
/// warms and cools.
#[test]
fn an_exchange_at_rest_is_seen_by_the_changes_of_the_load() {
    for (seed, zero, wave) in [(61, 2.4, 0.0), (62, -2.4, 0.0), (63, 0.0, 3.0), (64, 0.0, -3.0)] {
        for rows in [(310, 1200), (0, 315), (310, 860)] {
            let mut truth = loaded(seed, 0.6);
            for row in 0..1200 {
                let air = wave * (row as f64 / 60.0).sin();
                [WINDING, HOUSING].iter().for_each(|k| column(&mut truth, *k)[row] += air);
            }
            let mut wrong = truth.clone();
            exchange(&mut wrong, 0, BOTH, rows);
            column(&mut wrong, WINDING).iter_mut().for_each(|x| *x += zero);
            let missed = missed(&mut wrong, 0, &truth, &[rows]);
            assert!(missed < 0.5, "{seed} {rows:?}: {missed} K, {:?}", wrong.notes);
        }
    }
}

/// In two runs, with the notes of each, and the rest is used.
#[test]
fn each_run_is_judged_alone() {
    let mut truth = loaded(36, 1.0);
    let mut second = loaded(37, 0.8).runs.remove(0);
    second.file = "second.csv".to_string();
    truth.runs.push(second);
    let mut wrong = truth.clone();
    exchange(&mut wrong, 0, BOTH, (760, 1200));
    exchange(&mut wrong, 1, BOTH, (300, 900));
    assert_eq!(check(&mut wrong, &[], &Deadline::default()), Ok(true));
    let notes: Vec<&String> = wrong.notes.iter().filter(|n| n.contains("seem to be exchanged")).collect();
    assert!(
        notes.len() == 2 && notes[0].contains("to the end") && notes[1].starts_with("second.csv"),
        "{notes:?}"
    );
    let counts = [0, 1].map(|run| blank(&wrong, run).len());
    assert!(counts[0].abs_diff(440) < 60 && counts[1].abs_diff(600) < 60, "{counts:?} {:?}", wrong.notes);
}

/// A run in which all rows are exchanged contradicts the model, and none of it is right.
#[test]
fn a_whole_run_is_left_to_the_check_of_the_columns() {
    for (seed, load) in [(38, 0.5), (39, 1.0), (40, 3.0)] {
        let mut whole = loaded(seed, load);
        exchange(&mut whole, 0, BOTH, (0, 1200));
        assert!(is_left(&mut whole), "{seed}: {:?}", whole.notes);
    }
}

/// An input cannot be set aside.
#[test]
fn an_ambient_temperature_that_is_exchanged_is_unusable() {
    for (k, rows) in [(WINDING, (500, 1200)), (WINDING, (0, 600)), (HOUSING, (200, 800)), (HOUSING, (0, 700))]
    {
        let mut wrong = loaded(39, 2.0);
        let mut rng = rng(40);
        column(&mut wrong, AMBIENT).iter_mut().for_each(|x| *x += 0.02 * normal(&mut rng));
        exchange(&mut wrong, 0, (k, AMBIENT), rows);
        let why = set_aside(&mut wrong, &[], &Deadline::default()).expect("exchanged");
        assert_eq!(why.channel, "ambient_temperature_degC");
        let from = if rows.0 == 0 { "the start".to_string() } else { format!("{} s", 3 * rows.0) };
        assert!(why.reason.contains(&format!("seem to be exchanged from {from} to")), "{}", why.reason);
    }
}

/// Whether the check leaves data as they are.
fn is_left(data: &mut Experiment) -> bool {
    let before = data.runs[0].table.columns.clone();
    let unusable = set_aside(data, &[], &Deadline::default());
    let is_same = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
    unusable.is_none() && data.runs[0].table.columns.iter().zip(&before).all(is_same)
}

/// Good data; steps of the load; a housing that becomes warmer than the winding while the motor cools, and another zero of one of the two.
#[test]
fn good_thermometers_are_left() {
    for seed in 41..45 {
        assert!(is_left(&mut experiment(seed)), "{seed}");
        assert!(is_left(&mut loaded(seed, 0.2)), "{seed}");
        let mut steps = with_inputs(seed, |columns| {
            columns[CURRENT]
                .iter_mut()
                .enumerate()
                .for_each(|(k, i)| *i = 12.0 * f64::from(k / 200 % 2 == 0));
        });
        assert!(is_left(&mut steps), "{seed}");
        for (k, size) in [(WINDING, -2.5), (HOUSING, 2.5), (WINDING, 2.5)] {
            let mut zero = loaded(seed, 1.0);
            column(&mut zero, k).iter_mut().for_each(|x| *x += size);
            assert!(is_left(&mut zero), "{seed} {size}: {:?}", zero.notes);
        }
        // Air that moves about a thermometer: its noise lasts for a minute.
        let mut windy = loaded(seed, 0.4);
        let (mut rng, mut at) = (rng(seed), 0.0);
        for x in column(&mut windy, HOUSING) {
            at += 0.3 * normal(&mut rng) - 0.1 * at;
            *x += at;
        }
        assert!(is_left(&mut windy), "{seed}: {:?}", windy.notes);
        let mut crossing = loaded(seed, 2.0);
        let mut at = 0.0;
        let current = column(&mut crossing, CURRENT).clone();
        for (row, x) in column(&mut crossing, HOUSING).iter_mut().enumerate().skip(1) {
            at += (if current[row] < 1.0 { 3.0 } else { 0.0 } - at) / 20.0;
            *x += at;
        }
        assert!(is_left(&mut crossing), "{seed}: {:?}", crossing.notes);
    }
}

/// A winding's thermometer that reads the air, scatters, or jumps below the housing by as much as it was above it; one that moves, and is put
/// back.
#[test]
fn one_thermometer_that_fails_is_no_exchange() {
    for seed in 51..54 {
        let fail = |load: f64, of: &dyn Fn(usize, f64, f64, f64) -> f64| {
            let mut data = loaded(seed, load);
            let housing = column(&mut data, HOUSING).clone();
            let mut rng = rng(seed);
            for (row, x) in column(&mut data, WINDING).iter_mut().enumerate() {
                *x = of(row, *x, housing[row], normal(&mut rng));
            }
            is_left(&mut data)
        };
        for load in [0.7, 2.0] {
            assert!(fail(load, &|row, x, _, n| if row < 600 { x } else { 296.15 + 0.1 * n }));
            assert!(fail(load, &|row, x, _, n| if row % 300 < 250 { x } else { x - 9.0 * n.abs() }));
            assert!(fail(load, &|row, x, h, _| if row < 700 { x } else { 2.0 * h - x }));
            assert!(fail(load, &|row, x, _, _| if (400..800).contains(&row) { x - 8.0 } else { x }));
            assert!(fail(load, &|row, x, h, _| if row < 500 { x } else { h - 0.5 * (x - 296.15) }));
            // A housing's thermometer that the current heats in a part of the run.
            for share in [2.0, 6.0] {
                let mut heated = loaded(seed, load);
                let winding = column(&mut heated, WINDING).clone();
                let rows = column(&mut heated, HOUSING).iter_mut().zip(winding).skip(600);
                rows.for_each(|(x, winding)| *x += share * (winding - *x));
                assert!(is_left(&mut heated), "{seed} {load} {share}: {:?}", heated.notes);
            }
        }
    }
}

/// At rest the winding reads half a kelvin less than the housing, and more within a few rows as a load begins.
#[test]
fn a_load_that_begins_is_no_exchange() {
    for seed in 81..101 {
        let mut data = with_inputs(seed, |columns| {
            columns[CURRENT].iter_mut().enumerate().for_each(|(k, i)| *i = 2.5 * f64::from(k / 200 % 2 == 1));
        });
        for (k, before, after) in [(WINDING, -0.3, 0.0), (HOUSING, 0.3, -0.25)] {
            for (row, x) in column(&mut data, k).iter_mut().enumerate().filter(|(row, _)| row % 400 > 150) {
                let part = ((row % 400) as f64 - 200.0).clamp(0.0, 4.0) / 4.0;
                *x += before + part * (after - before);
            }
        }
        assert!(is_left(&mut data), "{seed}: {:?}", data.notes);
    }
}

/// Two thermometers in moving air whose noise lasts for a minute follow no prediction.
#[test]
fn noise_that_lasts_is_no_evidence() {
    let mut rng = rng(65);
    let (mut count, mut shown) = (0.0, 0.0);
    for seed in 70..80 {
        let mut data = loaded(seed, 1.0);
        let model = data.runs[0].table.columns.clone();
        for k in [WINDING, HOUSING] {
            let mut at = 0.0;
            for x in column(&mut data, k) {
                at += 0.3 * normal(&mut rng) - 0.1 * at;
                *x = 300.0 + at;
            }
        }
        let course = Course::of(&data, 0, BOTH, (&model[WINDING], &model[HOUSING])).expect("readings");
        for from in (0..1200).step_by(150) {
            count += 1.0;
            let section = Section { from, to: from + 150, is_exchanged: true };
            shown += f64::from(course.shows(&section, 1.0).is_some());
        }
    }
    assert!(shown < 0.02 * count, "{shown} of {count}");
}

/// What happens in a gap is not seen from its ends; a few missing rows are no gap.
#[test]
fn a_gap_is_no_exchange() {
    for (missing, is_seen) in [(0, true), (4, true), (12, false), (100, false)] {
        let mut data = loaded(55, 2.0);
        exchange(&mut data, 0, BOTH, (520, 1200));
        data.runs[0].table.time[520..].iter_mut().for_each(|t| *t += 3.0 * f64::from(missing));
        let columns = &data.runs[0].table.columns;
        let course = Course::of(&data, 0, BOTH, (&columns[WINDING], &columns[HOUSING])).expect("readings");
        assert_eq!(course.joints[500..540].iter().any(|joint| joint.is_seen), is_seen, "{missing}");
    }
    for (from, to) in [(500, 560), (270, 300), (600, 900)] {
        let mut gap = loaded(55, 2.0);
        let table = &mut gap.runs[0].table;
        table.time.drain(from..to);
        table.columns.iter_mut().for_each(|column| drop(column.drain(from..to)));
        assert!(is_left(&mut gap), "{from} {to}: {:?}", gap.notes);
    }
}
