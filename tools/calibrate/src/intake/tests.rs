//! Faults introduced into data simulated with noise.

use super::*;
use crate::testing::{self, normal, rng};
use std::cell::Cell;

const PRIORS: &str = "\"motor.R_ref\" = 0.05\n\"motor.k_t\" = 0.05\n\"thermal.R_wh\" = 0.2\n\"thermal.C_w\" = 0.2\n\
                      \"conductance.G_still\" = 0.2\n\"thermal.C_h\" = 0.2\n\"conductance.G_forced\" = 0.2";
/// Noise of inputs and outputs, SI units.
const SIGMA: [f64; 8] = [0.004, 0.3, 0.0, 0.02, 0.02, 6e-4, 0.1, 0.1];
pub(crate) const CURRENT: usize = 0;
pub(crate) const SPEED: usize = 1;
pub(crate) const FAN: usize = 2;
pub(crate) const AMBIENT: usize = 3;
pub(crate) const VOLTAGE: usize = 4;
pub(crate) const TORQUE: usize = 5;
pub(crate) const WINDING: usize = 6;
pub(crate) const HOUSING: usize = 7;

/// One run of 1200 rows of 3 s with steps of current, speed and fan; the readings are those of a specimen that differs from the preset.
pub(super) fn experiment(seed: u64) -> Experiment {
    with_inputs(seed, |_| ())
}

/// The same with modified inputs.
pub(crate) fn with_inputs(seed: u64, change: impl Fn(&mut [Vec<f64>])) -> Experiment {
    let mut experiment = testing::experiment(PRIORS, true);
    experiment.noise.clear();
    let rows = 1200;
    let table = &mut experiment.runs[0].table;
    table.time = (0..rows).map(|k| 3.0 * k as f64).collect();
    let of = |values: &[f64], every: usize| (0..rows).map(|k| values[k / every % values.len()]).collect();
    table.columns = vec![
        of(&[0.0, 4.0, 1.5, 6.0, 3.0], 55),
        of(&[100.0, 400.0, 250.0], 70),
        of(&[0.0, 0.0, 1.0], 130),
        vec![296.15; rows],
    ];
    change(&mut table.columns);
    table.columns.resize(8, vec![f64::NAN; rows]);
    let setup = Setup::new(&experiment, &[]).unwrap();
    let shares = [1.02, 0.98, 1.1, 0.9, 1.1, 0.95, 0.9];
    let truth: Vec<f64> = setup.declared.iter().zip(shares).map(|(d, share)| share * d.prior).collect();
    testing::read(&mut experiment, &truth, None);
    let mut rng = rng(seed);
    for (column, sigma) in experiment.runs[0].table.columns.iter_mut().zip(SIGMA) {
        column.iter_mut().for_each(|x| *x += sigma * normal(&mut rng));
    }
    experiment
}

pub(super) fn column(experiment: &mut Experiment, k: usize) -> &mut Vec<f64> {
    &mut experiment.runs[0].table.columns[k]
}

/// Delays a column by so many seconds.
fn late(experiment: &mut Experiment, k: usize, seconds: f64) {
    let table = &mut experiment.runs[0].table;
    let (time, old) = (table.time.clone(), table.columns[k].clone());
    let at = |t: f64| {
        let place = ((t - seconds - time[0]) / 3.0).clamp(0.0, (time.len() - 1) as f64);
        let (row, share) = (place as usize, place.fract());
        old[row] + share * (old[(row + 1).min(old.len() - 1)] - old[row])
    };
    table.columns[k] = time.iter().map(|t| at(*t)).collect();
}

#[test]
fn good_data_are_used_as_they_are() {
    for seed in [1, 2] {
        let mut good = experiment(seed);
        let readings = good.runs[0].table.columns.clone();
        assert_eq!(check(&mut good, &[], &Deadline::default()), Ok(true));
        assert_eq!(good.runs[0].table.columns, readings, "{:?}", good.notes);
    }
}

/// What an input does between two rows is not measured: one that acts half an interval early or late is no fault of a clock.
#[test]
fn a_shift_within_a_row_is_no_offset_of_a_clock() {
    for seconds in [-1.4, 1.4] {
        let mut within = experiment(21);
        (VOLTAGE..=HOUSING).for_each(|k| late(&mut within, k, seconds));
        assert_eq!(unusable(&mut within), None, "{seconds}: {:?}", within.notes);
        let mut beyond = experiment(21);
        (VOLTAGE..=HOUSING).for_each(|k| late(&mut beyond, k, 10.0 * seconds));
        assert!(unusable(&mut beyond).is_some(), "{seconds}");
    }
}

/// Outliers next to steps of the current, next to each other, of both signs, in the first and the last row, small and large.
#[test]
fn wild_readings_are_set_aside_wherever_they_stand() {
    for (k, size) in [(VOLTAGE, 0.4), (TORQUE, 0.02), (WINDING, 3.0), (HOUSING, 3.0)] {
        let mut spiked = experiment(3);
        let rows = [0, 54, 56, 110, 300, 301, 304, 308, 700, 703, 900, 1100, 1199];
        for (n, row) in rows.into_iter().enumerate() {
            let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
            column(&mut spiked, k)[row] += sign * size * [1.0, 2.0, 8.0][n % 3];
        }
        assert_eq!(check(&mut spiked, &[], &Deadline::default()), Ok(true));
        let blank: Vec<usize> = (0..1200).filter(|row| column(&mut spiked, k)[*row].is_nan()).collect();
        let left: Vec<usize> = rows.into_iter().filter(|row| !blank.contains(row)).collect();
        assert!(left.is_empty() && blank.len() < 30, "{k}: left {left:?} of {} blank", blank.len());
        assert!(spiked.notes.iter().any(|n| n.contains("set aside")), "{:?}", spiked.notes);
    }
}

/// A row in which the logger recorded zeros in all columns.
#[test]
fn a_row_that_the_logger_lost_is_set_aside() {
    let mut lost = experiment(4);
    for row in [333, 801] {
        for k in 0..8 {
            column(&mut lost, k)[row] = if k == AMBIENT || k >= WINDING { 273.15 } else { 0.0 };
        }
    }
    assert_eq!(check(&mut lost, &[], &Deadline::default()), Ok(true));
    for k in [CURRENT, AMBIENT, VOLTAGE, WINDING, HOUSING] {
        assert!(column(&mut lost, k)[333].is_nan(), "{k}: {:?}", lost.notes);
    }
}

/// The delay is estimated, and the channel is set aside; a sensor lag is left to the search for effects.
#[test]
fn a_channel_with_a_clock_of_its_own_is_set_aside() {
    for (k, seconds) in
        [(WINDING, 24.0), (WINDING, -60.0), (VOLTAGE, 33.0), (HOUSING, 80.0), (TORQUE, 73.0), (TORQUE, -41.0)]
    {
        let mut shifted = experiment(5);
        late(&mut shifted, k, seconds);
        let outcome = check(&mut shifted, &[], &Deadline::default());
        assert_eq!(outcome, Ok(true), "{k} {seconds}");
        assert!(column(&mut shifted, k).iter().all(|x| x.is_nan()), "{k} {seconds}: {:?}", shifted.notes);
        let note = shifted.notes.iter().find(|n| n.contains("set aside")).unwrap();
        let stated: f64 = note.split(" is ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!((stated - seconds.abs()).abs() < 4.0, "{seconds}: {note}");
        assert!(note.contains(if seconds > 0.0 { " late" } else { " early" }), "{note}");
    }
    let mut lagging = experiment(5);
    let (mut at, table) = (column(&mut lagging, HOUSING)[0], lagging.runs[0].table.clone());
    for (row, x) in table.columns[HOUSING].iter().enumerate() {
        at += (x - at) * (1.0 - (-3.0f64 / 40.0).exp());
        column(&mut lagging, HOUSING)[row] = at;
    }
    assert_eq!(check(&mut lagging, &[], &Deadline::default()), Ok(true));
    assert!(column(&mut lagging, HOUSING).iter().all(|x| x.is_finite()), "{:?}", lagging.notes);
}

#[test]
fn an_input_with_a_clock_of_its_own_is_unusable() {
    for seconds in [30.0, -45.0] {
        let mut shifted = experiment(6);
        late(&mut shifted, CURRENT, seconds);
        let Err(Refusal::Unusable(why)) = check(&mut shifted, &[], &Deadline::default()) else {
            panic!("{:?}", shifted.notes)
        };
        assert_eq!(why.channel, "current_A", "{why:?}");
    }
}

/// The motor responds to its fan with a first-order lag, or by another number of rows late or early in each half of the run.
#[test]
fn a_delayed_response_is_no_clock() {
    const FAN: usize = 2;
    let lagging = |fan: &mut [f64]| {
        let mut at = fan[0];
        for x in fan {
            at += (*x - at) * (1.0 - (-3.0f64 / 120.0).exp());
            *x = at;
        }
    };
    let late = |fan: &mut [f64]| {
        fan[..600].rotate_right(20);
        fan[600..].rotate_right(40);
    };
    let early = |fan: &mut [f64]| {
        fan[..600].rotate_left(20);
        fan[600..].rotate_left(40);
    };
    let cases: [fn(&mut [f64]); 3] = [lagging, late, early];
    for (case, respond) in ["lagging", "late", "early"].into_iter().zip(cases) {
        let command = Cell::new(Vec::new());
        let mut good = with_inputs(7, |columns| {
            command.set(columns[FAN].clone());
            respond(&mut columns[FAN]);
        });
        *column(&mut good, FAN) = command.take();
        assert_eq!(check(&mut good, &[], &Deadline::default()), Ok(true), "{case}");
        assert!(good.notes.iter().all(|n| !n.contains("against the response")), "{case}: {:?}", good.notes);
    }
}

/// A fault: name, change of the data, and the column that is set aside.
struct Case(&'static str, fn(&mut Vec<Vec<f64>>), &'static str);

const CASES: [Case; 3] = [
    Case("ambient drops out", |c| c[AMBIENT][300..340].fill(212.0), "ambient_temperature_degC"),
    Case("winding shorted in a part", |c| c[WINDING][500..900].fill(273.15), "winding_temperature_degC"),
    Case(
        "torque sensor dead",
        |c| {
            c[TORQUE]
                .iter_mut()
                .enumerate()
                .for_each(|(k, x)| *x = 6e-4 * ((k * 7919 % 101) as f64 / 50.0 - 1.0))
        },
        "shaft_torque_Nm",
    ),
];

/// No faulty reading reaches the search; units, signs and exchanged columns: `tests/python/test_close_loop_intake.py`.
#[test]
fn sensors_that_do_not_work_are_set_aside() {
    for Case(what, make, channel) in CASES {
        let mut wrong = experiment(7);
        // A measured ambient temperature has noise.
        let mut rng = rng(8);
        column(&mut wrong, AMBIENT).iter_mut().for_each(|x| *x += 0.02 * normal(&mut rng));
        make(&mut wrong.runs[0].table.columns);
        assert!(sensors(&mut wrong, &[], &Deadline::default()).is_ok(), "{what}");
        let is_noted = |n: &String| n.contains(channel) && n.contains("set aside");
        assert!(wrong.notes.iter().any(is_noted), "{what}: {:?}", wrong.notes);
    }
}

/// Wherever the deadline passes, good data stay as they are, and wrong ones are unusable or were not checked to the end.
#[test]
fn what_the_deadline_cuts_off_leads_to_no_conclusion() {
    let (good, mut wrong) = (experiment(1), experiment(1));
    column(&mut wrong, TORQUE).iter_mut().for_each(|x| *x = -*x);
    let (mut cut, mut found) = (0, 0);
    for times in (0..20).map(|k| 1.7f64.powi(k) as usize) {
        let mut data = good.clone();
        let outcome = check(&mut data, &[], &Deadline::asked(times));
        assert!(
            outcome.is_ok() && data.runs[0].table.columns == good.runs[0].table.columns,
            "{times}: {outcome:?}"
        );
        cut += usize::from(outcome == Ok(false));
        match check(&mut wrong.clone(), &[], &Deadline::asked(times)) {
            Err(Refusal::Unusable(_)) => found += 1,
            outcome => assert_eq!(outcome, Ok(false), "{times}"),
        }
    }
    assert!(cut > 0 && found > 0, "{cut} {found}");
}

pub(super) fn unusable(experiment: &mut Experiment) -> Option<String> {
    match check(experiment, &[], &Deadline::default()) {
        Err(Refusal::Unusable(why)) => Some(why.channel),
        other => {
            assert_eq!(other, Ok(true));
            None
        }
    }
}

/// A sensor that is moved reads another fraction of the rise, or an offset, afterwards. The section that agrees with the other data is kept,
/// and the run of the sensor is set aside where that is the shorter one.
#[test]
fn readings_of_a_sensor_that_has_moved_are_set_aside() {
    for (k, from, share, offset) in [
        (HOUSING, 700, 0.6, 0.0),
        (HOUSING, 400, 1.0, -9.0),
        (WINDING, 800, 0.7, 0.0),
        (WINDING, 300, 1.0, 12.0),
        (HOUSING, 750, 1.0, 1.7),
        (WINDING, 420, 1.0, -1.9),
        (WINDING, 430, 1.0, -1.9),
        (WINDING, 477, 1.0, 1.6),
    ] {
        let mut moved = experiment(10);
        column(&mut moved, k)[from..].iter_mut().for_each(|x| *x = 296.15 + share * (*x - 296.15) + offset);
        assert_eq!(unusable(&mut moved), None);
        let blank = |k: usize, rows: std::ops::Range<usize>| {
            moved.runs[0].table.columns[k][rows].iter().filter(|x| x.is_nan()).count()
        };
        let (before, after) = (blank(k, 0..from), blank(k, from..1200));
        assert!(before < 20 && after == 1200 - from, "{k} from {from}: {before} {after} {:?}", moved.notes);
        assert_eq!(blank(WINDING + HOUSING - k, 0..1200), 0, "{:?}", moved.notes);
    }
}

/// A law of a thermometer over the speed steps with it, and is no sensor that has moved.
#[test]
fn a_law_of_a_thermometer_over_the_speed_is_no_step() {
    for (seed, k, size) in [(41, WINDING, 1.6), (42, HOUSING, -2.2), (43, WINDING, -4.0)] {
        let mut law = experiment(seed);
        let speed = column(&mut law, SPEED).clone();
        column(&mut law, k).iter_mut().zip(speed).for_each(|(x, w)| *x += size * f64::from(w > 200.0));
        assert_eq!(unusable(&mut law), None);
        let blank = column(&mut law, k).iter().filter(|x| x.is_nan()).count();
        assert!(blank < 20, "{k} {size}: {blank} {:?}", law.notes);
    }
}

/// A speed that was not measured is detected; a locked shaft is not reported, even with a faulty voltage.
#[test]
fn an_input_that_was_not_measured_is_unusable() {
    let mut unmeasured = experiment(11);
    column(&mut unmeasured, SPEED).fill(0.0);
    assert_eq!(unusable(&mut unmeasured).as_deref(), Some("speed_rad_per_s"));
    let mut locked = with_inputs(12, |columns| columns[SPEED].fill(0.0));
    column(&mut locked, SPEED).fill(0.0);
    column(&mut locked, VOLTAGE).iter_mut().for_each(|v| *v += 0.7 * (*v / 0.2).tanh());
    assert_ne!(unusable(&mut locked).as_deref(), Some("speed_rad_per_s"));
}

/// An ambient sensor on or next to the motor is detected; one in an ambient that warms up is used.
#[test]
fn an_ambient_sensor_that_the_motor_heats_is_unusable() {
    for share in [0.9, 1.0] {
        let mut heated = experiment(13);
        let housing = column(&mut heated, HOUSING).clone();
        let of = |(x, housing): (&mut f64, f64)| *x += share * (housing - *x);
        column(&mut heated, AMBIENT).iter_mut().zip(housing).for_each(of);
        assert_eq!(unusable(&mut heated).as_deref(), Some("ambient_temperature_degC"), "{share}");
    }
    let mut warming = with_inputs(14, |columns| {
        columns[AMBIENT].iter_mut().enumerate().for_each(|(k, x)| *x += 0.004 * k as f64);
    });
    assert_eq!(unusable(&mut warming), None, "{:?}", warming.notes);
}

/// A load that alternates from row to row heats the motor by its mean square, which means over rows do not have.
#[test]
fn an_alternating_load_is_no_wrong_unit() {
    let gait = |columns: &mut [Vec<f64>]| {
        columns[CURRENT].iter_mut().enumerate().for_each(|(k, i)| *i *= [0.2, 0.2, 0.2, 2.4, -1.4][k % 5]);
    };
    let mut alternating = with_inputs(17, gait);
    assert_eq!(unusable(&mut alternating), None, "{:?}", alternating.notes);
    let square = |x: &Experiment| x.runs[0].table.columns[CURRENT].iter().map(|i| i * i).sum::<f64>();
    let rows = |x: &Experiment| x.runs[0].table.time.len();
    let (constant, thin) = (experiment(17), consistency::thinned(&alternating, 100));
    assert!(square(&thin) / rows(&thin) as f64 > 0.98 * square(&alternating) / rows(&alternating) as f64);
    assert!(rows(&consistency::thinned(&constant, 100)) < rows(&thin));
}

/// No-load currents of a voltage drive are the small difference of two voltages: an error of 3 % in the torque constant changes the
/// prediction by amperes. The priors include this, and the readings are used; without priors the sensor would be reported as dead.
#[test]
fn a_small_current_is_no_dead_sensor() {
    let outputs = ["current_A", "shaft_torque_Nm", "winding_temperature_degC", "housing_temperature_degC"];
    let mut run = testing::driven_by(("voltage_V", 1.0, 190.0), &outputs, PRIORS, true);
    run.noise.clear();
    let start =
        |name: &str| Setup::new(&run, &[]).unwrap().declared.iter().find(|d| d.name == name).unwrap().prior;
    let (r, k_t) = (start("motor.R_ref"), 1.03 * start("motor.k_t"));
    let mut rng = rng(15);
    let rows = 1200;
    let table = &mut run.runs[0].table;
    table.time = (0..rows).map(|k| 3.0 * k as f64).collect();
    let speed: Vec<f64> = (0..rows).map(|k| [100.0, 800.0, 400.0][k / 70 % 3]).collect();
    let current: Vec<f64> =
        (0..rows).map(|k| if k < 300 { 4.0 } else { 0.0 } + 0.02 * normal(&mut rng)).collect();
    let voltage = speed.iter().zip(&current).map(|(w, i)| k_t * w + r * i).collect();
    table.columns = vec![voltage, speed, vec![0.0; rows], vec![296.15; rows], current];
    table.columns.resize(8, vec![f64::NAN; rows]);
    let preset = predicted(&run, &[], &[0], &Deadline::default());
    let blank = |doubts: Vec<Vec<Vec<f64>>>| {
        let mut run = run.clone();
        let fitted = vec![preset.clone(); 4];
        response::set_aside(&mut run, &preset, (&fitted, &[false; 4]), || doubts);
        run.runs[0].table.columns[4].iter().filter(|x| x.is_nan()).count()
    };
    assert_eq!(blank(deviations(&run, &[], &preset, &Deadline::default())), 0);
    assert!(blank(vec![vec![vec![0.0; rows]; 4]]) > 100);
}

pub(super) fn reason(experiment: &mut Experiment) -> String {
    match check(experiment, &[], &Deadline::default()) {
        Err(Refusal::Unusable(why)) => format!("{}: {}", why.channel, why.reason),
        other => format!("{other:?}, {:?}", experiment.notes),
    }
}

/// Of several factors that agree with the model the fit distinguishes the right one; those that it cannot distinguish are all named, first
/// the one with a reason.
#[test]
fn a_factor_is_named_as_the_unit_that_it_is() {
    let all = [
        (SPEED, 30.0 / std::f64::consts::PI, "speed_rad_per_s", "readings in rpm"),
        (TORQUE, 9.549_3, "shaft_torque_Nm", "readings times 0.1047 (the factor 9.549"),
        (TORQUE, 1e3, "shaft_torque_Nm", "readings in mN.m"),
        (VOLTAGE, 1e3, "voltage_V", "readings in mV"),
    ];
    for (k, factor, channel, words) in all {
        let mut wrong = experiment(16);
        column(&mut wrong, k).iter_mut().for_each(|x| *x *= factor);
        let reason = reason(&mut wrong);
        assert!(reason.starts_with(channel) && reason.contains(words), "{reason}");
    }
}

/// A value in [set] that is wrong contradicts the data as a wrong unit does: it is named too, with the value that agrees.
#[test]
fn a_wrong_value_of_a_parameter_is_named() {
    for (name, factor, truth) in
        [("thermal.C_h", 0.4, 0.9), ("conductance.G_still", 2.0, 1.1), ("motor.k_t", 1.5, 0.98)]
    {
        let mut wrong = experiment(17);
        let setup = Setup::new(&wrong, &[]).unwrap();
        let own = setup.declared.iter().find(|d| d.name == name).unwrap().prior;
        wrong.priors.retain(|p| p.name != name);
        wrong.set.push((name.to_string(), factor * own));
        let reason = reason(&mut wrong);
        let words = format!("; {name} = ");
        let value = reason.split(&words).nth(1).and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        let value = value.unwrap_or_else(|| panic!("{name}: {reason}"));
        assert!((value / own / truth - 1.0).abs() < 0.3, "{reason}");
        assert!(reason.contains("would explain the data as well"), "{reason}");
    }
}

/// A thermometer that comes off while the motor is 5 K warm reads less than 10 K wrong; heat that the model lacks moves both thermometers.
#[test]
fn a_thermometer_that_comes_off_is_set_aside() {
    for k in [WINDING, HOUSING] {
        let mut off = with_inputs(18, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= 0.45));
        let housing = column(&mut off, HOUSING).clone();
        let (mut rng, from) = (rng(19), 780);
        let first = column(&mut off, k)[from];
        for (n, x) in column(&mut off, k).iter_mut().enumerate().skip(from) {
            let air = 296.15 + 0.05 * (housing[n] - 296.15);
            *x = air + (first - air) * (-3.0 * (n - from) as f64 / 22.0).exp() + 0.1 * normal(&mut rng);
        }
        assert_eq!(unusable(&mut off), None);
        let blank = |rows: std::ops::Range<usize>| {
            off.runs[0].table.columns[k][rows].iter().filter(|x| x.is_nan()).count()
        };
        assert!(blank(790..1200) > 400 && blank(0..760) < 20, "{k}: {:?}", off.notes);
    }
    let mut heated = with_inputs(18, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= 0.45));
    for k in [WINDING, HOUSING] {
        for (n, x) in column(&mut heated, k).iter_mut().enumerate().skip(780) {
            *x += 6.0 * (1.0 - (-3.0 * (n - 780) as f64 / 150.0).exp());
        }
    }
    assert_eq!(unusable(&mut heated), None);
    let there =
        |of: &Experiment, k: usize| of.runs[0].table.columns[k].iter().filter(|x| x.is_finite()).count();
    assert!(there(&heated, WINDING) == 1200 && there(&heated, HOUSING) == 1200, "{:?}", heated.notes);
    // A sensor in the air flow of the rotor reads another temperature at each speed.
    let mut blown = with_inputs(20, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= 0.45));
    let speed = column(&mut blown, SPEED).clone();
    let mut at = 0.0;
    for (x, speed) in column(&mut blown, HOUSING).iter_mut().zip(speed) {
        at += (5.0 * (speed - 100.0) / 300.0 - at) * 0.2;
        *x -= at;
    }
    assert_eq!(unusable(&mut blown), None);
    assert_eq!(there(&blown, HOUSING), 1200, "{:?}", blown.notes);
}

/// A thermometer that lets go slowly in a run whose rise is small beside that of the other run.
#[test]
fn a_thermometer_that_lets_go_slowly_is_set_aside() {
    let two = || {
        let mut both = experiment(21);
        let mut faint =
            with_inputs(22, |columns| columns[CURRENT].iter_mut().for_each(|i| *i *= 0.3)).runs.remove(0);
        faint.file = "faint.csv".to_string();
        both.runs.push(faint);
        both
    };
    let blank = |of: &Experiment, run: usize, k: usize| {
        of.runs[run].table.columns[k].iter().filter(|x| x.is_nan()).count()
    };
    let mut good = two();
    assert_eq!(unusable(&mut good), None);
    assert_eq!([0, 1].map(|run| blank(&good, run, HOUSING)), [0, 0], "{:?}", good.notes);
    for (k, tau) in [(WINDING, 240.0), (HOUSING, 240.0)] {
        let mut off = two();
        let (mut rng, from) = (rng(23), 300);
        let column = &mut off.runs[1].table.columns[k];
        let first = column[from];
        for (n, x) in column.iter_mut().enumerate().skip(from) {
            *x = 296.15 + (first - 296.15) * (-3.0 * (n - from) as f64 / tau).exp() + 0.1 * normal(&mut rng);
        }
        assert_eq!(unusable(&mut off), None);
        assert!(blank(&off, 1, k) > 700 && blank(&off, 0, k) == 0, "{k}: {:?}", off.notes);
    }
}
