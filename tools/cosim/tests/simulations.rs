//! Complete runs compared with the closed-form solution; errors of all options.
use crate::common::*;
use cosim::{FmiVersion, Options, simulate};

/// A step of the input to `u` at t = 0: x = u (1 - exp(-t / tau)).
fn step_response(u: f64, tau: f64, t: f64) -> f64 {
    u * (1.0 - (-t / tau).exp())
}

/// A ramp u = s t: x = s (t - tau + tau exp(-t / tau)).
fn ramp_response(s: f64, tau: f64, t: f64) -> f64 {
    s * (t - tau + tau * (-t / tau).exp())
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs().max(1.0)
}

#[test]
fn step_response_meets_the_closed_form() {
    for version in BOTH {
        for (mode, rate) in [("frozen", 0.0), ("normal", 1.0), ("fast", 2.0), ("3", 2.0)] {
            let options = Options {
                sets: sets(&[("u", "4"), ("tau", "0.5"), ("mode", mode), ("n", "3")]),
                ..Options::default()
            };
            let mut shares = Vec::new();
            let r = simulate(&Fmu::good(version).open().unwrap(), &options, &mut |s| shares.push(s)).unwrap();
            assert_eq!((r.steps, r.times.len(), r.times[100]), (100, 101, 1.0));
            assert!(shares.len() <= 201 && shares.is_sorted() && shares.last() == Some(&1.0));
            let x = r.column("x").unwrap();
            assert_eq!(x.display_unit.as_ref().unwrap().name, "degC");
            for (t, x) in r.times.iter().zip(&x.values) {
                assert!(close(*x, step_response(4.0, 0.5, t * rate)), "{t} {x}");
            }
            let warm = &r.column("warm").unwrap().values;
            assert_eq!(warm[0], 0.0);
            assert_eq!(warm[100], f64::from(u8::from(rate > 0.0)));
            assert_eq!(r.column("twice").unwrap().values[5], 6.0);
        }
    }
}

#[test]
fn negated_and_default_settings() {
    for version in BOTH {
        let options = Options { sets: sets(&[("u", "4"), ("invert", "true")]), ..Options::default() };
        let r = run(version, &options).unwrap();
        assert!(close(*r.column("x").unwrap().values.last().unwrap(), step_response(-4.0, 2.0, 1.0)));
    }
}

#[test]
fn slopes_make_a_ramp_exact_and_held_inputs_do_not() {
    let end = |version, slopes| {
        let options = Options {
            input: Some(table(version, "time,u\n0,0\n1,2\n")),
            input_slopes: slopes,
            step: Some(0.1),
            ..Options::default()
        };
        *run(version, &options).unwrap().column("x").unwrap().values.last().unwrap()
    };
    let exact = ramp_response(2.0, 2.0, 1.0);
    assert!(close(end(FmiVersion::V2, true), exact));
    // Held at the beginning of each step, the input lags by half a step.
    for (version, slopes) in [(FmiVersion::V2, false), (FmiVersion::V3, true), (FmiVersion::V3, false)] {
        let error = exact - end(version, slopes);
        assert!(error > 0.02 && error < 0.06, "{error}");
    }
}

#[test]
fn a_kink_within_a_step_becomes_the_mean_slope() {
    let options = Options {
        input: Some(table(FmiVersion::V2, "time,u\n0,0\n0.5,0\n1,2\n")),
        step: Some(1.0),
        ..Options::default()
    };
    let r = run(FmiVersion::V2, &options).unwrap();
    assert!(close(r.column("x").unwrap().values[1], ramp_response(2.0, 2.0, 1.0)));
}

#[test]
fn jumps_happen_at_their_row() {
    for version in BOTH {
        // 0.7 is a point that 7 * 0.1 misses by a rounding error.
        let options = Options {
            input: Some(table(version, "time,u,n\n0,0,0\n0.7,0,0\n0.7,1,5\n")),
            step: Some(0.1),
            ..Options::default()
        };
        let r = run(version, &options).unwrap();
        let (x, twice) = (&r.column("x").unwrap().values, &r.column("twice").unwrap().values);
        assert_eq!((x[7], twice[7], twice[8]), (0.0, 0.0, 10.0));
        assert!(close(x[10], step_response(1.0, 2.0, 0.3)));
    }
}

/// A step ends at the jump; the rows of the result do not change.
#[test]
fn jumps_between_points_happen_at_their_row() {
    for version in BOTH {
        let options = Options {
            input: Some(table(version, "time,u,n\n0,0,0\n0.7,0,0\n0.7,1,5\n")),
            step: Some(0.25),
            ..Options::default()
        };
        let r = run(version, &options).unwrap();
        let (x, twice) = (&r.column("x").unwrap().values, &r.column("twice").unwrap().values);
        assert!(close(x[4], step_response(1.0, 2.0, 0.3)), "{x:?}");
        assert_eq!((x[2], twice[2], twice[3], r.steps, r.times.len()), (0.0, 0.0, 10.0, 5, 5));
    }
}

#[test]
fn points_do_not_drift_and_the_last_step_may_be_short() {
    for version in BOTH {
        let options = Options { stop: Some(3600.0), step: Some(0.1), ..Options::default() };
        let r = run(version, &options).unwrap();
        assert_eq!((r.steps, r.times[12345], *r.times.last().unwrap()), (36000, 12345.0 * 0.1, 3600.0));
        let options =
            Options { sets: sets(&[("u", "1")]), stop: Some(1.0), step: Some(0.3), ..Options::default() };
        let r = run(version, &options).unwrap();
        assert_eq!((r.steps, *r.times.last().unwrap()), (4, 1.0));
        assert!(close(*r.column("x").unwrap().values.last().unwrap(), step_response(1.0, 2.0, 1.0)));

        let xml = xml(version).replace("canHandleVariableCommunicationStepSize=\"true\"", "");
        let message =
            simulate(&Fmu::described(version, &xml).open().unwrap(), &options, &mut |_| ()).unwrap_err();
        assert_eq!(
            message.to_string(),
            "step size = 0.3 s does not divide the time from 0 s to 1 s, and Lag cannot vary its step"
        );
    }
}

#[test]
fn start_time_and_defaults_without_an_experiment() {
    for version in BOTH {
        let xml =
            xml(version).replace(r#"<DefaultExperiment startTime="0" stopTime="1" stepSize="0.01"/>"#, "");
        let archive = Fmu::described(version, &xml).open().unwrap();
        let r = simulate(&archive, &Options::default(), &mut |_| ()).unwrap();
        assert_eq!((r.steps, r.times[0], *r.times.last().unwrap()), (500, 0.0, 1.0));
        let options = Options { start: Some(-2.0), stop: Some(2.0), ..Options::default() };
        let r = simulate(&archive, &options, &mut |_| ()).unwrap();
        assert_eq!((r.times[0], r.times[1], *r.times.last().unwrap()), (-2.0, -2.0 + 4.0 / 500.0, 2.0));
    }
}

#[test]
fn arrays_follow_their_structural_parameter() {
    let options = Options { sets: sets(&[("u", "1"), ("size", "3")]), ..Options::default() };
    let r = run(FmiVersion::V3, &options).unwrap();
    let names: Vec<&str> = r.columns.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["x", "warm", "twice", "y[1]", "y[2]", "y[3]", "single"]);
    let last = |name: &str| *r.column(name).unwrap().values.last().unwrap();
    assert_eq!(last("y[3]"), 3.0 * last("x"));
    assert_eq!(last("single"), f64::from(last("x") as f32));
}

#[test]
fn bad_settings_get_one_sentence() {
    for version in BOTH {
        for [name, text, expected] in faults().setting {
            let options = Options { sets: vec![(name, text)], ..Options::default() };
            assert_eq!(run(version, &options).unwrap_err().to_string(), expected);
        }
        let options = Options { sets: sets(&[("tau", "1"), ("tau", "2")]), ..Options::default() };
        let message = run(version, &options).unwrap_err().to_string();
        assert_eq!(message, "setting tau = 2 is refused because tau is set twice");
        let options = Options {
            sets: sets(&[("u", "1")]),
            input: Some(table(version, "time,u\n0,0\n")),
            ..Options::default()
        };
        let message = run(version, &options).unwrap_err().to_string();
        assert_eq!(message, "setting u = 1 is refused because u is also a column of the input table");
    }
    let options = Options { sets: sets(&[("n", "200")]), ..Options::default() };
    let message = run(FmiVersion::V3, &options).unwrap_err().to_string();
    assert_eq!(message, "n = \"200\" is not a whole number from -128 to 127");
}

#[test]
fn bad_times_get_one_sentence() {
    for (start, stop, step, expected) in [
        (0.0, -1.0, 0.1, "stop time = -1 s must be finite and above the start time 0 s"),
        (0.0, 0.0, 0.1, "stop time = 0 s must be finite and above the start time 0 s"),
        (0.0, f64::NAN, 0.1, "stop time = NaN s must be finite and above the start time 0 s"),
        (f64::INFINITY, 1.0, 0.1, "start time = inf s must be finite"),
        (0.0, 1.0, 0.0, "step size = 0 s must be finite and above 0 s"),
        (0.0, 1.0, -0.1, "step size = -0.1 s must be finite and above 0 s"),
        (0.0, 1.0, f64::NAN, "step size = NaN s must be finite and above 0 s"),
        (0.0, 1.0, 1e-12, "step size = 0.000000000001 s is too small for a span of 1 s"),
        (1e16, 2e16, 1.0, "step size = 1 s is too small for a span of 10000000000000000 s"),
    ] {
        let options =
            Options { start: Some(start), stop: Some(stop), step: Some(step), ..Options::default() };
        assert_eq!(run(FmiVersion::V2, &options).unwrap_err().to_string(), expected);
    }
}

#[test]
fn faults_during_a_run() {
    for version in BOTH {
        let with =
            |fault: &str| run(version, &Options { sets: sets(&[("fault", fault)]), ..Options::default() });
        assert_eq!(with("1").unwrap().messages.len(), 100);
        for fault in ["2", "3", "4"] {
            assert!(with(fault).unwrap_err().to_string().contains(" at t = 0 s: "));
        }
        let ended = with("5").unwrap();
        assert_eq!((ended.ended_early, ended.times.len()), (Some(0.0), 1));
    }
}

#[test]
fn csv_gives_every_bit_back() {
    for version in BOTH {
        let r = run(version, &Options { sets: sets(&[("u", "1")]), ..Options::default() }).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out.csv");
        r.write_csv(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("time,x,warm,twice"));
        assert_eq!(text.lines().count(), 102);
        for (row, line) in text.lines().skip(1).enumerate() {
            let cells: Vec<f64> = line.split(',').map(|c| c.parse().unwrap()).collect();
            assert_eq!(cells[0].to_bits(), r.times[row].to_bits());
            for (cell, column) in cells[1..].iter().zip(&r.columns) {
                assert_eq!(cell.to_bits(), column.values[row].to_bits());
            }
        }
        let message = r.write_csv(&dir.path().join("no/out.csv")).unwrap_err().to_string();
        assert!(message.starts_with("cannot write "), "{message}");
    }
}
