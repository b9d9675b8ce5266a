use super::*;
use crate::testing;

/// The test run of 300 rows as a logger that is so many times as fast records it: each row repeated at a part of its interval.
fn fast(times: usize) -> Experiment {
    let mut experiment = testing::experiment(testing::PRIORS, false);
    let table = &mut experiment.runs[0].table;
    let slow = table.time.clone();
    let part = |k: usize| slow[k / times] + 5.0 * (k % times) as f64 / times as f64;
    table.time = (0..times * slow.len()).map(part).collect();
    let repeated = |column: &Vec<f64>| (0..times * slow.len()).map(|k| column[k / times]).collect();
    table.columns = table.columns.iter().map(repeated).collect();
    table.logged = table.time.len();
    experiment
}

const CURRENT: usize = 0;

fn note(means: &Experiment) -> &str {
    means.notes.last().unwrap()
}

#[test]
fn few_rows_stay_as_they_are() {
    assert!(fast(40).of_means().is_none());
    let mut experiment = fast(41);
    let winding = experiment.place_of(2);
    experiment.runs[0].table.columns[winding].fill(300.0);
    // The intake has put in 50 rows at steps.
    experiment.runs[0].table.logged -= 50;
    let means = experiment.of_means().unwrap();
    assert!(note(&means).contains("12250 rows") && note(&means).contains("2 rows each"), "{}", note(&means));
    assert_eq!(means.runs[0].table.time.len(), 6150);
}

/// Steps of a load stay steps, and the rows beside them have no outputs; the mean square of the load is kept.
#[test]
fn a_step_stays_a_step() {
    let mut experiment = fast(100);
    let winding = experiment.place_of(2);
    let table = &mut experiment.runs[0].table;
    for (k, t) in table.time.clone().into_iter().enumerate() {
        table.columns[CURRENT][k] = if k % 1503 < 1463 { 6.0 } else { 0.0 };
        table.columns[winding][k] = 300.0 + 0.01 * t;
    }
    let heat = |experiment: &Experiment| -> f64 {
        let table = &experiment.runs[0].table;
        let current = &table.columns[CURRENT];
        let of = |k: usize| {
            let (a, b, h) = (current[k], current[k + 1], table.time[k + 1] - table.time[k]);
            h * (a * a + a * b + b * b) / 3.0
        };
        (0..current.len() - 1).map(of).sum()
    };
    let means = experiment.of_means().unwrap();
    let own = &means.runs[0].table;
    assert!((heat(&means) / heat(&experiment) - 1.0).abs() < 2e-4, "{}", heat(&means) / heat(&experiment));
    let steps = own.columns[CURRENT].windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert_eq!(steps, 38);
    assert!(own.columns[CURRENT].iter().all(|i| *i == 6.0 || *i == 0.0));
    // The rows beside steps do not shorten the blocks.
    assert!(note(&means).contains("over 5 rows"), "{}", note(&means));
    let stepped = (1..own.time.len()).filter(|k| own.columns[CURRENT][*k] != own.columns[CURRENT][k - 1]);
    assert!(stepped.flat_map(|k| [k - 1, k]).all(|k| own.columns[winding][k].is_nan()));
    // A reading is at the time of the rows that it is the mean of.
    let readings = own.time.iter().zip(&own.columns[winding]).skip(1).filter(|(_, y)| y.is_finite());
    assert!(readings.clone().all(|(t, y)| (y - 300.0 - 0.01 * t).abs() < 1e-9));
    assert!(readings.count() > 5900);
    // Without pieces the steps would be ramps over a block.
    let whole = |run: &Run| {
        Some(Division {
            length: 5,
            pieces: std::iter::once(0..run.table.time.len()).collect(),
            loss: STRUCTURE,
        })
    };
    let (ramps, _) = experiment.with_means(&[], whole);
    assert!((heat(&ramps) / heat(&experiment) - 1.0).abs() > 5e-4);
}

/// A cycle of four rows is not averaged; longer ones in blocks that keep their mean square.
#[test]
fn a_load_that_alternates_keeps_its_mean_square() {
    for (cycle, is_kept) in [(4.0, true), (100.0, false), (400.0, false)] {
        let mut experiment = fast(100);
        let current = &mut experiment.runs[0].table.columns[CURRENT];
        let turn = |k: usize| 4.0 * (std::f64::consts::TAU * k as f64 / cycle).sin();
        current.iter_mut().enumerate().for_each(|(k, i)| *i = turn(k));
        let means = experiment.of_means();
        assert_eq!(means.is_none(), is_kept, "{cycle}");
        let Some(means) = means else { continue };
        let of = |experiment: &Experiment| square(&experiment.runs[0].table.columns[CURRENT]);
        assert!(of(&means) > (1.0 - NEGLIGIBLE * STRUCTURE) * of(&experiment));
    }
}

/// Blocks end at gaps and at the window; a run with few rows keeps them; a blank is no reading.
#[test]
fn blocks_cross_neither_gaps_nor_windows() {
    let mut experiment = fast(100);
    let [winding, housing] = [2, 3].map(|output| experiment.place_of(output));
    let mut slow = testing::experiment(testing::PRIORS, false).runs.remove(0);
    slow.file = "slow.csv".to_string();
    let table = &mut experiment.runs[0].table;
    table.time.iter_mut().skip(12_001).for_each(|t| *t += 1000.0);
    for k in 0..table.time.len() {
        table.columns[winding][k] = if k <= 12_000 { 300.0 } else { 320.0 };
        table.columns[housing][k] = if k % 20 == 0 { 310.0 } else { f64::NAN };
    }
    let ends = (table.time[3003], table.time[20_004]);
    experiment.runs[0].window = Some(ends);
    experiment.runs.push(slow);
    let means = experiment.of_means().unwrap();
    assert!(note(&means).contains("1 to "), "{}", note(&means));
    let (own, before) = (&means.runs[0].table, &experiment.runs[0].table);
    assert_eq!(means.runs[1].table.time, experiment.runs[1].table.time);
    assert!(own.columns[winding].iter().all(|y| y.is_nan() || *y == 300.0 || *y == 320.0));
    assert!(own.time.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(!own.time.iter().any(|t| (before.time[12_000] + 1.0..before.time[12_001]).contains(t)));
    let inside = |run: &Run| {
        let times = run.table.time.iter().filter(|t| (ends.0..=ends.1).contains(*t));
        times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(*t), b.max(*t)))
    };
    let (first, last) = inside(&means.runs[0]);
    assert!(first - ends.0 < 0.4 && ends.1 - last < 0.4, "{first} {last}");
    let housing = &own.columns[housing];
    assert!(housing.iter().all(|y| y.is_nan() || *y == 310.0));
    assert!(housing.iter().filter(|y| y.is_finite()).count() >= 1490);
}

/// A stated noise is that of a reading; a thermometer without dither has its quantization error in the means as well.
#[test]
fn noise_of_means() {
    let mut experiment = fast(100);
    let [winding, housing] = [2, 3].map(|output| experiment.place_of(output));
    let mut rng = testing::rng(4);
    let table = &mut experiment.runs[0].table;
    for (k, t) in table.time.clone().into_iter().enumerate() {
        let slow = 300.0 + 20.0 * (t / 400.0).sin();
        table.columns[winding][k] = ((slow + 0.3 * testing::normal(&mut rng)) / 0.1).round() * 0.1;
        table.columns[housing][k] = (slow / 0.1).round() * 0.1;
    }
    let of = |name: &str, means: &Experiment| means.noise[name];
    let means = experiment.of_means().unwrap();
    let own = testing::NOISE / 5f64.sqrt();
    assert!((of("winding_temperature_degC", &means) / own - 1.0).abs() < 1e-9);
    let stepped = own.hypot(0.1 / 12f64.sqrt());
    assert!((of("housing_temperature_degC", &means) / stepped - 1.0).abs() < 1e-6);
    experiment.noise.clear();
    let means = experiment.of_means().unwrap();
    assert!(!means.noise.contains_key("winding_temperature_degC"));
    assert!((of("housing_temperature_degC", &means) * 12f64.sqrt() / 0.1 - 1.0).abs() < 1e-6);
}

/// A block in which a load changes its sign by more than its noise has no readings of outputs; one at rest has.
#[test]
fn means_over_a_reversal_have_no_readings() {
    assert!(turns(&[-3.0, f64::NAN, 2.0], 1.0));
    assert!(!turns(&[-3.0, 0.5, 0.2], 1.0) && !turns(&[2.0, 3.0], 1.0) && !turns(&[f64::NAN], 0.0));
}
