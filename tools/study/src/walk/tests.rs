//! Cycles from files and mixes: compared with closed forms and with the same load made otherwise.

use super::*;
use describe::Preset;
use std::f64::consts::PI;
use std::path::Path;

fn load(folder: &Path, text: &str, sets: &[(&str, &str)]) -> Result<Load, crate::StudyError> {
    let file = folder.join("load.toml");
    let sets: Vec<_> = sets.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect();
    Load::parse(text, &file.display().to_string(), Some(&Preset::load("maxon-305015").unwrap()), &sets)
}

/// tau = offset + amplitude sin, w = speed cos, over 0.8 s at unequal distances; in units of its own.
fn sine(folder: &Path, name: &str, offset: f64, amplitude: f64, speed: f64) {
    let rows = 400;
    let mut text = "M [mN.m];t_ms;n (rpm);phi\n".to_owned();
    for k in 0..=rows {
        let x = f64::from(k) / f64::from(rows);
        let t = 0.8 * (x + 0.05 * (2.0 * PI * x).sin() / (2.0 * PI));
        let phase = 2.0 * PI * t / 0.8;
        let (torque, n) = (offset + amplitude * phase.sin(), speed * phase.cos());
        let angle = speed * 0.8 / (2.0 * PI) * phase.sin();
        text += &format!("{};{};{};{}\n", torque * 1e3, t * 1e3, n * 30.0 / PI, angle.to_degrees())
            .replace('.', ",");
    }
    std::fs::write(folder.join(name), text).unwrap();
}

const SINE: &str = "[cycle]\nfile = \"sine.csv\"\ntime = { column = \"t_ms\", unit = \"ms\" }\ntorque = \"M\"\nspeed = \"n\"\n";
const BY_ANGLE: &str = "[cycle]\nfile = \"sine.csv\"\ntime = { column = \"t_ms\", unit = \"ms\" }\ntorque = \"M\"\nangle = { column = \"phi\", unit = \"deg\" }\n";

/// rms current of the sines by hand: torque and inertia in quadrature, no friction, cold magnets.
#[test]
fn a_cycle_has_the_rms_current_of_its_sines() {
    let folder = tempfile::tempdir().unwrap();
    sine(folder.path(), "sine.csv", 0.02, 0.05, 300.0);
    let cold = [("effect.coulomb_friction.tau_c", "0"), ("motor.alpha_mag", "0")];
    for text in [SINE, BY_ANGLE] {
        for (more, ratio, efficiency) in
            [("", 1.0, 1.0), ("ratio = 3\nefficiency = 0.8\ninertia = \"40 g.cm2\"\n", 3.0, 0.8)]
        {
            let found = periodic(&load(folder.path(), &format!("{text}{more}"), &cold).unwrap()).unwrap();
            // By quadrature over the cycle.
            let inertia = 33.3e-7 + if ratio > 1.0 { 40e-7 / (ratio * ratio) } else { 0.0 };
            let n = 20_000;
            let mean = |of: &dyn Fn(f64) -> f64| {
                (0..n).map(|k| of(2.0 * PI * (f64::from(k) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n)
            };
            let current = |p: f64| {
                let (torque, w) = (0.02 + 0.05 * p.sin(), 300.0 * p.cos());
                let through = if torque * w >= 0.0 { 1.0 / efficiency } else { efficiency };
                let acceleration = -300.0 * ratio * p.sin() * 2.0 * PI / 0.8;
                (torque / ratio * through + inertia * acceleration) / 0.0276
            };
            let rms = mean(&|p| current(p).powi(2)).sqrt();
            assert!((found.current_rms / rms - 1.0).abs() < 2e-3, "{more} {found:?} instead of {rms}");
            assert!((found.joint_torque_peak / 0.07 - 1.0).abs() < 1e-3, "{found:?}");
            // The mean of torque times speed; the offset gives none.
            assert!(found.power_joint.abs() < 1e-2, "{found:?}");
        }
    }
}

/// Constant torque and speed: the steady state of `steady`.
#[test]
fn a_constant_cycle_is_the_steady_state() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flat.csv"), "t,M,n\n0,0.06,200\n0.1,0.06,200\n0.5,0.06,200\n")
        .unwrap();
    let text =
        "[cycle]\nfile = \"flat.csv\"\ntime = \"t\"\ntorque = \"M\"\nspeed = \"n\"\nsupply = \"48 V\"\n";
    let load = load(folder.path(), text, &[("fan_command", "0.7")]).unwrap();
    let found = periodic(&load).unwrap();
    let current = found.current_rms.to_string();
    let sets = [("current_command", current.as_str()), ("imposed_speed", "200"), ("fan_command", "0.7")];
    let setup = crate::steady::Setup::new(MOTOR, Some(Preset::load("maxon-305015").unwrap()), &sets);
    let still = crate::steady::steady(&mut setup.bench().unwrap()).unwrap();
    let of = |name: &str| still.get(name).unwrap();
    assert!((of("winding_temperature") - found.winding_temperature).abs() < 0.02, "{found:?}");
    assert!((of("shaft_torque") - 0.06).abs() < 1e-5, "{}", of("shaft_torque"));
    assert!((of("power_electrical") / found.power_electrical - 1.0).abs() < 1e-3, "{found:?}");
    assert!(
        (of("terminal_voltage") / found.voltage_peak.unwrap() - 1.0).abs() < 1e-3
            && found.torque_error_rms == 0.0
    );
    // More torque until the winding is at its limit, where `steady` has its continuous torque.
    let continuous = continuous_support(&load, &|_| ()).unwrap();
    let limit = crate::steady::continuous_torque(&setup.bench().unwrap()).unwrap();
    assert!((continuous.at.joint_torque_peak / limit.torque - 1.0).abs() < 1e-3, "{continuous:?} {limit:?}");
    let mut slow = load.clone();
    slow.set_text("cycle.supply", "5 V").unwrap();
    assert!(periodic(&slow).unwrap().torque_error_rms > 0.01);
}

/// A mix with phases much shorter than the winding's time constant has the winding of the mean heat; with long ones the peak is higher.
#[test]
fn a_mix_has_the_mean_heat() {
    let folder = tempfile::tempdir().unwrap();
    sine(folder.path(), "sine.csv", 0.02, 0.05, 300.0);
    let mix = |period: &str| {
        let text = format!(
            "{SINE}[mix]\nperiod = \"{period}\"\nphase = [{{ fraction = \"60 %\" }}, {{ fraction = 0.4, rest = true }}]\n"
        );
        load(folder.path(), &text, SETS).unwrap()
    };
    const SETS: &[(&str, &str)] = &[("motor.alpha_mag", "0"), ("thermal.C_h", "15")];
    let full = load(folder.path(), SINE, SETS).unwrap();
    let (quick, slow, always) =
        (periodic(&mix("4 s")).unwrap(), periodic(&mix("5 min")).unwrap(), periodic(&full).unwrap());
    println!("{quick:?}\n{slow:?}\n{always:?}");
    assert!((quick.power_electrical / (0.6 * always.power_electrical) - 1.0).abs() < 0.05, "{quick:?}");
    assert!((quick.current_rms / (0.6f64.sqrt() * always.current_rms) - 1.0).abs() < 1e-3);
    assert!(
        quick.winding_temperature < slow.winding_temperature - 2.0
            && slow.winding_temperature < always.winding_temperature - 1.0
    );
    // The periodic steady state is where the way there ends.
    let walked = walk(&mix("1 min"), 0.5, &|_| ()).unwrap();
    let last = walked
        .envelope
        .points
        .iter()
        .filter(|p| p.time > 0.45 * 3600.0)
        .map(|p| p.winding_temperature)
        .fold(0.0, f64::max);
    let forever = walked.forever.unwrap();
    assert!((forever.winding_temperature - last).abs() < 0.3, "{forever:?} {last}");
    // Twice the torque for a fraction of the time: more continuous factor than without rest.
    let (with, without) =
        (continuous_support(&mix("1 min"), &|_| ()).unwrap(), continuous_support(&full, &|_| ()).unwrap());
    assert!(with.support > 1.2 * without.support, "{with:?} {without:?}");
    // The same with the cycle in a file of its own.
    std::fs::write(folder.path().join("own.toml"), SINE).unwrap();
    let text = "[mix]\nperiod = 60\nphase = [{ fraction = 0.6, load = \"own.toml\" }, { fraction = 0.4, rest = true }]\n";
    let named = continuous_support(&load(folder.path(), text, SETS).unwrap(), &|_| ()).unwrap();
    assert!(named.support > 2.0 && (named.support / with.support - 1.0).abs() < 1e-3, "{named:?} {with:?}");
}

/// A mix of gaits: the values of the phases reach them, the others reach all.
#[test]
fn a_mix_of_gaits_has_its_activities() {
    let folder = tempfile::tempdir().unwrap();
    let text = "[motor]\ndrive_mode = \"current\"\n[actuator]\n\"transmission.ratio\" = 250\n[mix]\nperiod = 60\n\
                phase = [{ fraction = 0.6, \"gait.activity\" = \"walk\" }, { fraction = 0.1, \"gait.activity\" = \"stairs_up\" }, { fraction = 0.3, rest = true }]\n";
    let mut mixed = load(folder.path(), text, &[("gait.support", "0.4"), ("fan_command", "1")]).unwrap();
    let source = mixed.source().unwrap();
    assert!(
        source.contains("60 %: ")
            && source.contains("Grimmer")
            && source.contains("Boehme")
            && source.contains("30 %: rest"),
        "{source}"
    );
    let found = periodic(&mixed).unwrap();
    mixed.set_text("gait.support", "0.5").unwrap();
    assert!(periodic(&mixed).unwrap().current_rms > 1.1 * found.current_rms);
    let error = mixed.set_text("gait.activity", "walk").unwrap_err().to_string();
    assert!(error.contains("every phase"), "{error}");
}

/// A phase is no mix: neither its own file nor one that names this file again.
#[test]
fn a_mix_that_contains_itself_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mix = |of: &str| {
        format!("[mix]\nphase = [{{ fraction = 0.7, load = \"{of}\" }}, {{ fraction = 0.3, rest = true }}]\n")
    };
    for (file, of) in [("own.toml", "own.toml"), ("first.toml", "second.toml"), ("second.toml", "first.toml")]
    {
        std::fs::write(folder.path().join(file), mix(of)).unwrap();
    }
    for file in ["own.toml", "first.toml"] {
        let error = Load::read(&folder.path().join(file), None, &[]).err().unwrap().to_string();
        assert!(error.contains("has a [mix] and cannot be a phase of one"), "{error}");
    }
}

/// A stride of level walking, sampled to a file in units of its own and carried by the same actuator, is that walk.
#[test]
fn a_cycle_at_the_joint_is_the_gait_that_it_was_sampled_from() {
    let folder = tempfile::tempdir().unwrap();
    let rows = 1140;
    for (file, motion) in [("by_speed.csv", "n [rpm]"), ("by_angle.csv", "phi [deg]")] {
        let mut text = format!("t [ms];{motion};M [N.m]\n");
        for k in 0..=rows {
            let mut gait = crate::bench::Bench::new("GaitLoad", None).unwrap();
            gait.set("gait.initial_phase", f64::from(k % rows) / f64::from(rows)).unwrap();
            gait.start().unwrap();
            let mut of = |name: &str| gait.get(name).unwrap();
            let motion = if file == "by_speed.csv" {
                of("joint_speed") * 30.0 / PI
            } else {
                of("joint_angle").to_degrees()
            };
            text += &format!("{k};{motion};{}\n", of("torque_demand"));
        }
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    let actuator = "[motor]\ndrive_mode = \"current\"\n[actuator]\n\"transmission.ratio\" = 250\n\"spring.stiffness\" = 250\n";
    let sets = [("fan_command", "1"), ("gait.support", "0.4")];
    let walk = load(folder.path(), actuator, &sets).unwrap();
    let walked = periodic(&walk).unwrap();
    for (file, motion) in [("by_speed.csv", "speed = \"n\""), ("by_angle.csv", "angle = \"phi\"")] {
        let cycle = format!("[cycle]\nfile = \"{file}\"\ntime = \"t\"\ntorque = \"M\"\n{motion}\n");
        let of_file = load(folder.path(), &format!("{cycle}{actuator}"), &sets).unwrap();
        let found = periodic(&of_file).unwrap();
        println!("{walked:?}\n{found:?}");
        assert!((found.current_rms / walked.current_rms - 1.0).abs() < 2e-3, "{found:?} {walked:?}");
        assert!((found.winding_temperature - walked.winding_temperature).abs() < 0.2, "{found:?} {walked:?}");
        assert!((found.power_joint / walked.power_joint - 1.0).abs() < 2e-3);
        assert_eq!((of_file.words().period, of_file.words().factor[0]), ("cycle", "factor"));
        assert!(of_file.source().unwrap().contains(file));
        // A factor of 0.4 in the file in place of the support.
        let half = load(folder.path(), &format!("{cycle}scale = 0.4\n{actuator}"), &sets[..1]).unwrap();
        assert!((periodic(&half).unwrap().current_rms / found.current_rms - 1.0).abs() < 1e-9);
    }
    for (more, sets, words) in [
        ("ratio = 3\n", &[][..], &["cycle.ratio has no effect", "transmission.ratio"][..]),
        ("", &[("gait.activity", "walk")], &["gait.activity has no effect", "[cycle]"]),
        ("[gait]\n\"gait.body_mass\" = 80\n", &[], &["gait.body_mass has no effect"]),
    ] {
        let text = format!(
            "[cycle]\nfile = \"by_speed.csv\"\ntime = \"t\"\ntorque = \"M\"\nspeed = \"n\"\n{more}{actuator}"
        );
        let error = load(folder.path(), &text, sets).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(words.iter().all(|w| error.contains(w)), "{words:?} in {error}");
    }
}

/// A CSV file with columns of usual names needs no load file.
#[test]
fn usual_columns_are_recognised() {
    let folder = tempfile::tempdir().unwrap();
    let preset = Preset::load("maxon-305015").unwrap();
    let read = |text: &str| {
        let file = folder.path().join("own \"cycle\".CSV");
        std::fs::write(&file, text).unwrap();
        Load::read(&file, Some(&preset), &[]).map(|load| load.table().unwrap().0).map_err(|e| e.to_string())
    };
    let table = read("Time [ms],M (mN.m),n [rpm],phi\n0,5,60,0\n10,6,90,1\n20,5,60,2\n").unwrap();
    assert!(
        (table.period - 0.02).abs() < 1e-15
            && (table.torques[1] - 6e-3).abs() < 1e-15
            && table.angle.is_none()
    );
    assert!((table.speeds[1] - 3.0 * PI).abs() < 1e-12);
    let table = read("time_s;torque_Nm;theta [deg]\n0;5;180\n0,5;6;180\n1;5;180\n").unwrap();
    assert_eq!((table.angle, table.speeds[0], table.torques[1]), (Some(PI), 0.0, 6.0));
    let table = read("t_ms,joint_torque_mN.m,speed_rpm\n0,5,60\n10,6,90\n20,5,60\n").unwrap();
    assert!((table.period - 0.02).abs() < 1e-15 && (table.torques[1] - 6e-3).abs() < 1e-15);
    assert!((table.speeds[1] - 3.0 * PI).abs() < 1e-12);
    for (text, words) in [
        ("t,M [Nm/kg],n\n0,1,1\n", &[".CSV:1: torque", "a torque per body mass", "body_mass"][..]),
        ("t,M,n\n0,1,1\n1,1,1\n0.5,1,1\n", &[".CSV:4: time 0.5 s does not follow"]),
        ("t_%,M,n\n0,1,1\n", &["time", "a fraction of the period", "the key period"]),
        ("t,force,n\n0,1,1\n", &["none of the columns torque, tau", "t, force, n", "[cycle]"][..]),
        ("t,M,pressure\n0,1,1\n", &["speed, omega", "angle, phi"]),
        (
            "# bench\nt,M,speed_Hz\n0,1,1\n",
            &[
                ".CSV:2: the column speed_Hz: \"Hz\" is not a unit of the same quantity as \"rad/s\"",
                "rpm, krpm",
            ],
        ),
        (
            "t,torque_foo,n\n0,1,1\n",
            &["the column torque_foo: \"foo\" is not a known unit", "a torque is N.m, mN.m"],
        ),
        ("t,M,n [V]\n0,1,1\n", &[".CSV:1: the column n [V]: \"V\" is not", "a speed is rad/s"]),
        ("t,M,phi_s\n0,1,1\n", &["the column phi_s: \"s\"", "an angle is rad, deg"]),
        ("", &["is empty"]),
    ] {
        let error = read(text).unwrap_err();
        assert!(words.iter().all(|w| error.contains(w)), "{words:?} in {error}");
    }
}

/// As gait data are published: torque per body mass over the percentage of the stride.
#[test]
fn a_cycle_may_be_normalised() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("n.csv"), "stride,M,n\n0,0.1,10\n50,-0.2,30\n100,0.1,10\n").unwrap();
    let text = "[cycle]\nfile = \"n.csv\"\ntime = { column = \"stride\", unit = \"%\" }\n\
                torque = { column = \"M\", unit = \"mNm/kg\" }\nspeed = \"n\"\n";
    let both = format!("{text}period = \"1200 ms\"\nbody_mass = \"80 kg\"\n");
    let table = load(folder.path(), &both, &[]).unwrap().table().unwrap().0;
    assert_eq!((table.times[1], table.period), (0.6, 1.2));
    assert!((table.torques[1] + 0.016).abs() < 1e-15, "{}", table.torques[1]);
    let plain = both.replace("unit = \"mNm/kg\"", "unit = \"mNm\"");
    for (text, words) in [
        (text.to_owned(), ["\"%\" is a fraction of the period", "the key period"]),
        (format!("{text}period = 1\n"), ["\"mNm/kg\" is a torque per body mass", "the key body_mass"]),
        (format!("{both}scale = 2\n").replace("80 kg", "-80 kg"), ["body_mass = -80 kg", "not above 0 kg"]),
        (plain, ["body_mass has no effect", "N.m/kg"]),
    ] {
        let error = load(folder.path(), &text, &[]).map(|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{words:?} in {error}");
    }
}

#[test]
fn bad_cycles_are_named_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    sine(folder.path(), "sine.csv", 0.02, 0.05, 300.0);
    std::fs::write(folder.path().join("bad.csv"), "t,M,n\n0,1,2\n1,x,2\n").unwrap();
    std::fs::write(folder.path().join("back.csv"), "t,M,n\n0,1,2\n1,1,2\n0.5,1,2\n").unwrap();
    let flat =
        |file: &str| format!("[cycle]\nfile = \"{file}\"\ntime = \"t\"\ntorque = \"M\"\nspeed = \"n\"\n");
    for (text, words) in [
        (flat("none.csv"), &["none.csv", "cannot be read"][..]),
        (flat("bad.csv"), &["bad.csv:3", "\"x\"", "column M"]),
        (flat("back.csv"), &["load.toml:2", "back.csv:4", "time 0.5 s does not follow 1 s"]),
        (
            flat("back.csv").replace("\"t\"", "{ column = \"t\", unit = \"ms\" }"),
            &["time 0.5 ms does not follow 1 ms"],
        ),
        (
            flat("back.csv").replace("\"M\"", "{ column = \"M\", unit = \"V\" }"),
            &["load.toml:4: torque: \"V\""],
        ),
        (flat("bad.csv").replace("\"M\"", "\"torque\""), &["no column torque", "t, M, n"]),
        (SINE.replace("unit = \"ms\"", "unit = \"mm\""), &["time", "\"mm\""]),
        (SINE.replace("torque = \"M\"\n", ""), &["torque", "missing"]),
        (format!("{SINE}rato = 3\n"), &["load.toml:6", "rato", "did you mean ratio?"]),
        (format!("{SINE}efficiency = 2\n"), &["cycle.efficiency = 2", "1"]),
        (format!("{SINE}period = \"0.5 s\"\n"), &["0.5 s", "shorter"]),
        (format!("{SINE}[gait]\n\"gait.support\" = 1\n"), &["[cycle]", "no effect"]),
        (
            format!("{SINE}[mix]\nphase = [{{ fraction = 0.5 }}, {{ fraction = 0.4, rest = true }}]\n"),
            &["add up to 0.9"],
        ),
        ("[mix]\nphase = []\n".to_owned(), &["it has no phase"]),
    ] {
        let error = load(folder.path(), &text, &[]).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(
            words.iter().all(|w| error.contains(w)) && !error.contains('\n'),
            "{words:?} in {error}\n{text}"
        );
    }
}

/// A torque for which a gear was forgotten: the sentence has the torque and the current that it needs.
#[test]
fn a_cycle_that_needs_too_much_current_says_which() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("big.csv"), "t,M,n\n0,40,2\n1,46,2\n2,40,2\n").unwrap();
    let text = "[cycle]\nfile = \"big.csv\"\ntime = \"t\"\ntorque = \"M\"\nspeed = \"n\"\n";
    let error = walk(&load(folder.path(), text, &[]).unwrap(), 0.1, &|_| ()).unwrap_err().to_string();
    assert!(error.contains("is 46.00 N.m at the motor (no ratio is given), for which it needs"), "{error}");
    let fast = load(folder.path(), text, &[("cycle.supply", "0.01"), ("cycle.scale", "1e-3")]).unwrap();
    let notes = fast.speed_notes().unwrap();
    assert!(notes.len() == 1 && notes[0].contains("at cycle.supply = 0.01000 V"), "{notes:?}");
}
