//! The figure of a run.
use crate::common::*;
use cosim::{Column, DisplayUnit, FmiVersion, Kind, Limit, LogMessage, Options, Recording, Status};

#[test]
fn a_run_becomes_an_svg_with_panels_by_unit() {
    let r = run(FmiVersion::V3, &Options { sets: sets(&[("u", "1")]), ..Options::default() }).unwrap();
    let text = r.svg(&[]).unwrap();
    roxmltree::Document::parse(&text).unwrap();
    for expected in ["Lag", "°C", "time in s", "warm", "twice", "y[2]", "Constant: "] {
        assert!(text.contains(expected), "{expected}");
    }
}

#[test]
fn degenerate_recordings_are_drawn_or_refused() {
    let mut r = Recording {
        model_name: "a < b & c".to_owned(),
        times: vec![0.0],
        columns: Vec::new(),
        steps: 0,
        seconds_wall: 0.0,
        ended_early: None,
        messages: Vec::new(),
    };
    assert!(r.svg(&[]).unwrap_err().to_string().ends_with("there are no numeric outputs"));
    let column = |value: f64| Column {
        name: format!("v{value}"),
        kind: Kind::Float64,
        unit: None,
        display_unit: None,
        values: vec![value],
        exact: Vec::new(),
    };
    for value in [0.0, 1e300, -1e-300] {
        r.columns = vec![column(value), column(f64::NAN)];
        let text = r.svg(&[]).unwrap();
        roxmltree::Document::parse(&text).unwrap();
        assert!(text.contains("Without a finite value: vNaN."), "{text}");
    }
    r.columns = vec![column(f64::NAN), column(f64::INFINITY)];
    assert!(r.svg(&[]).unwrap_err().to_string().ends_with("no output has a finite value"));
}

/// Outputs of one unit and of very different size have panels of their own.
#[test]
fn small_outputs_are_not_flat() {
    let column = |name: &str, size: f64| Column {
        name: name.to_owned(),
        kind: Kind::Float64,
        unit: Some("N.m".to_owned()),
        display_unit: None,
        values: vec![0.0, size],
        exact: Vec::new(),
    };
    let mut r = Recording {
        model_name: "M".to_owned(),
        times: vec![0.0, 1.0],
        columns: vec![column("joint", 100.0), column("demand", 90.0), column("motor", 0.3)],
        steps: 1,
        seconds_wall: 0.0,
        ended_early: None,
        messages: Vec::new(),
    };
    let panels = |r: &Recording| r.svg(&[]).unwrap().matches(">torque in N·m<").count();
    assert_eq!(panels(&r), 2);
    r.columns.pop();
    assert_eq!(panels(&r), 1);
}

/// The quantity of an axis is named also in SI units; names of outputs are in the order of English.
#[test]
fn axes_and_lines_are_named_in_words() {
    let column = |name: &str, unit: &str| Column {
        name: name.to_owned(),
        kind: Kind::Float64,
        unit: Some(unit.to_owned()),
        display_unit: None,
        values: vec![300.0, 310.0],
        exact: Vec::new(),
    };
    let r = Recording {
        model_name: "M".to_owned(),
        times: vec![0.0, 1.0],
        columns: vec![
            column("winding_temperature", "K"),
            column("housing_temperature", "K"),
            column("motor.loss_copper", "W"),
            column("slope_a", "K/s"),
            column("slope_b", "K/s"),
        ],
        steps: 1,
        seconds_wall: 0.0,
        ended_early: None,
        messages: Vec::new(),
    };
    let text = r.svg(&[]).unwrap();
    for expected in [">temperature in K<", ">motor: copper loss<", ">value in K/s<"] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
}

/// A limit near the values is a line, one that changes a curve, one far away is named below the panels.
#[test]
fn limits_are_drawn_near_the_values() {
    let column = |name: &str, values: [f64; 3]| Column {
        name: name.to_owned(),
        kind: Kind::Float64,
        unit: Some("V".to_owned()),
        display_unit: None,
        values: values.to_vec(),
        exact: Vec::new(),
    };
    let r = Recording {
        model_name: "M".to_owned(),
        times: vec![0.0, 1.0, 2.0],
        columns: vec![column("u", [0.0, 3.0, 10.0])],
        steps: 2,
        seconds_wall: 0.0,
        ended_early: None,
        messages: Vec::new(),
    };
    let text = |values: [f64; 3]| {
        let of = "u".to_owned();
        r.svg(&[Limit { of, label: "supply".to_owned(), column: column("s", values) }]).unwrap()
    };
    let (near, moving, far) = (text([24.0; 3]), text([24.0, 20.0, 18.0]), text([500.0; 3]));
    assert!(
        near.contains("class=\"z\"") && near.contains(">supply 24 V<") && near.contains(">voltage in V<")
    );
    assert!(!moving.contains("class=\"z\"") && moving.contains("stroke-dasharray"));
    assert!(!far.contains("class=\"z\"") && far.contains("Limits outside the panels: supply 500 V."));
}

/// Panels hold what changes; constant outputs are listed with their value. A motor's worth of long lines stays a small file.
#[test]
fn a_motor_sized_figure() {
    let times: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 0.18).collect();
    let shapes: [fn(f64) -> f64; 4] = [
        |t| 1.0 - (-t / 600.0).exp(),
        |t| (t / 60.0).sin(),
        |t| (-t / 900.0).exp(),
        |t| (t * 7.0).sin() * 0.2 + 1.0,
    ];
    let names = "current=A shaft_angle=rad shaft_speed=rad/s shaft_torque=N.m winding_temperature=degC \
        stator_temperature=degC magnet_temperature=degC housing_temperature=degC \
        air_outlet_temperature=degC air_flow_rate=m3/s air_pressure_drop=Pa winding_resistance=Ohm \
        torque_constant=N.m/A power_electrical=W power_mechanical=W loss_copper=W loss_iron=W \
        loss_friction=W loss_drive=W heat_to_ambient=W power_balance_error=W winding_margin=K \
        over_temperature= torque_density=N.m/kg";
    let names: Vec<(&str, &str)> = names.split(' ').filter_map(|name| name.split_once('=')).collect();
    let columns = names.iter().enumerate().map(|(i, (name, unit))| {
        let scale = match *unit {
            "N.m/A" => 0.0,
            "m3/s" => 3e-3,
            "Pa" => 60.0,
            "degC" => 20.0 + 9.0 * i as f64,
            "W" => 10.0 + i as f64,
            _ => 1.0,
        };
        let offset = if *unit == "degC" { 298.15 } else { 0.0 };
        let celsius = DisplayUnit { name: "degC".to_owned(), factor: 1.0, offset: -273.15, inverse: false };
        let boolean = unit.is_empty();
        Column {
            name: (*name).to_owned(),
            kind: if boolean { Kind::Boolean } else { Kind::Float64 },
            unit: Some((*unit).to_owned()),
            display_unit: (*unit == "degC").then_some(celsius),
            values: times
                .iter()
                .map(|t| {
                    let y = shapes[i % 4](*t) * scale + offset;
                    if boolean { f64::from(u8::from(*t > 2000.0)) } else { y }
                })
                .collect(),
            exact: Vec::new(),
        }
    });
    let r = Recording {
        model_name: "AnnulusCooledMotor".to_owned(),
        columns: columns.collect(),
        steps: times.len() - 1,
        times,
        seconds_wall: 0.0,
        ended_early: None,
        messages: Vec::new(),
    };
    let text = r.svg(&[]).unwrap();
    assert!(text.len() < 1_000_000, "{} bytes", text.len());
    assert!(text.contains("Constant: torque constant = 0 N·m/A.") && !text.contains("N·m/A<"));
    assert!(text.contains(">temperature in °C<") && text.contains("torque_density"));
}

/// A figure says why it ends before the stop time, and which outputs have no panel; names are words where they consist of words.
#[test]
fn an_early_end_is_in_the_figure() {
    let column = |name: &str, unit: String| Column {
        name: name.to_owned(),
        kind: Kind::Float64,
        unit: Some(unit),
        display_unit: None,
        values: vec![0.0, 1.0],
        exact: Vec::new(),
    };
    let mut columns = vec![column("motor.shaft_torque", "N.m".into()), column("x_1", "V".into())];
    columns.extend((0..9).map(|k| column("u", format!("unit{k}"))));
    let flag = column("motor.over_temperature", String::new());
    columns.push(Column { kind: Kind::Boolean, values: vec![0.0, 0.0], ..flag });
    let reason = "the hottest phase reaches its limit of validity";
    let mut r = Recording {
        model_name: "M".to_owned(),
        times: vec![0.0, 950.0],
        columns,
        steps: 1,
        seconds_wall: 0.0,
        ended_early: Some(950.0),
        messages: vec![LogMessage {
            status: Status::Discard,
            category: String::new(),
            text: format!("{reason}."),
        }],
    };
    // Lines of the remark are joined again.
    let text = |r: &Recording| {
        r.svg(&[])
            .unwrap()
            .replace("</text>", " ")
            .split('<')
            .map(|part| part.rsplit('>').next().unwrap().to_owned())
            .collect::<String>()
    };
    let text_of = text(&r);
    for expected in [
        "motor: shaft torque",
        "Constant: motor: over temperature = false.",
        "x_1",
        &format!("The FMU ended the run in the step from 950 s, before the stop time: {reason}."),
        "at most 10 panels (--outputs chooses): u.",
    ] {
        assert!(text_of.contains(expected), "{expected}: {text_of}");
    }
    r.ended_early = None;
    assert!(!text(&r).contains("ended"));
}
