use super::*;
use describe::Preset;
use describe::preset::MOTOR;

fn sheet(values: &[(&str, &str)]) -> Datasheet {
    let mut sheet = Datasheet { name: "x".into(), ..Datasheet::default() };
    for (key, text) in values {
        sheet.put(Value::parse(by_key(key).unwrap(), text).unwrap());
    }
    sheet
}

/// maxon RE 40 148877, from its product page.
const RE40: &[(&str, &str)] = &[
    ("nominal_voltage", "48"),
    ("no_load_speed", "7590"),
    ("no_load_current", "68.6"),
    ("nominal_speed", "7000"),
    ("nominal_torque", "187"),
    ("nominal_current", "3.17"),
    ("stall_torque", "2560"),
    ("stall_current", "42.4"),
    ("terminal_resistance", "1.13"),
    ("terminal_inductance", "0.33"),
    ("torque_constant", "60.3"),
    ("speed_constant", "158"),
    ("speed_torque_gradient", "2.97"),
    ("mechanical_time_constant", "4.28"),
    ("rotor_inertia", "137"),
    ("max_efficiency", "92"),
    ("resistance_housing_ambient", "4.65"),
    ("resistance_winding_housing", "1.93"),
    ("winding_time_constant", "41.5"),
    ("motor_time_constant", "809"),
    ("max_winding_temperature", "155"),
    ("pole_pairs", "1"),
    ("mass", "480"),
    ("diameter", "40"),
    ("length", "71"),
];

fn with(changes: &[(&str, &str)]) -> Datasheet {
    let mut sheet = sheet(RE40);
    for (key, text) in changes {
        sheet.put(Value::parse(by_key(key).unwrap(), text).unwrap());
    }
    sheet
}

#[test]
fn a_datasheet_gives_the_values_of_the_library() {
    let draft = Draft::new(&sheet(RE40)).unwrap();
    let library = Preset::load("maxon-re40-148877").unwrap();
    let declaration = (describe::models::by_name(MOTOR).unwrap().declaration)();
    let mut compared = 0;
    for (reference, expected) in library.starts.entries() {
        let entry = declaration.by_reference(reference).unwrap();
        let given = draft.values.iter().find(|v| v.name == entry.name).unwrap();
        assert!((given.value / expected - 1.0).abs() < 1e-4, "{given:?}, library {expected}");
        compared += 1;
    }
    assert!(compared > 15);
    // The text is a preset with the same values, and says where each is from.
    let text = draft.toml();
    let preset = Preset::parse(&text, "x.toml").unwrap_or_else(|e| panic!("{e}\n{text}"));
    for given in draft.values.iter().filter(|v| v.certainty != Certainty::Default) {
        let got = preset.starts.of(declaration.by_name(&given.name).unwrap());
        assert!((got / given.value - 1.0).abs() < 1e-12, "{given:?} {got}");
    }
    for words in [
        "datasheet: rotor inertia 137 g.cm2",
        "derived: winding time constant / R_wh = 21.50 J/K",
        "#   fan.flow_max = ",
    ] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    // All parameters of the model are listed, once.
    let parameters = declaration.entries.iter().filter(|e| e.row.causality == describe::Causality::Parameter);
    assert_eq!(draft.values.len(), parameters.count());
}

#[test]
fn a_consistent_datasheet_has_no_contradiction() {
    assert_eq!(contradictions(&sheet(RE40)), Vec::<Vec<Contradiction>>::new());
    assert_eq!(implausible(&sheet(RE40)), []);
    // Without the values in between the relations over several of them still hold.
    let few =
        ["nominal_voltage", "no_load_speed", "stall_torque", "mechanical_time_constant", "rotor_inertia"];
    let few: Vec<_> = RE40.iter().copied().filter(|(key, _)| few.contains(key)).collect();
    assert_eq!(contradictions(&sheet(&few)), Vec::<Vec<Contradiction>>::new());
}

/// Every printed value that others determine, wrong by 12 % and by a mistaken unit, is named with what the others give.
#[test]
fn each_wrong_value_is_named_with_its_size() {
    for (key, text) in RE40 {
        let quantity = by_key(key).unwrap();
        let printed: f64 = text.parse().unwrap();
        let redundant = quantity.of.is_some()
            && ![
                "terminal_inductance",
                "winding_time_constant",
                "motor_time_constant",
                // Only the winding's limit depends on them, whose relation is known to 8 %.
                "resistance_housing_ambient",
                "resistance_winding_housing",
                "max_winding_temperature",
            ]
            .contains(key);
        if !redundant {
            continue;
        }
        // An efficiency does not exceed 1, and depends little on what it follows from.
        let factors: &[f64] = match *key {
            "max_efficiency" => &[0.8],
            "nominal_torque" => &[1.25, 9.549],
            "no_load_current" => &[1.9],
            _ => &[1.12, 9.549, 1000.0, 1e-3],
        };
        for factor in factors {
            let found = contradictions(&with(&[(key, &(printed * factor).to_string())]));
            assert_eq!(found.len(), 1, "{key} x {factor}: {found:?}");
            let named = found[0].iter().find(|c| c.quantity == *key);
            let named = named.unwrap_or_else(|| panic!("{key} x {factor} is not in {found:?}"));
            assert!((named.expected / printed - 1.0).abs() < 0.1, "{key} x {factor}: {named:?}");
            assert!((named.ratio / factor - 1.0).abs() < 0.1, "{key} x {factor}: {named:?}");
        }
    }
    let found = contradictions(&with(&[("torque_constant", "60300")]));
    assert!(found[0][0].hint.unwrap().contains("1000"), "{found:?}");
}

/// Two values that only contradict each other: either may be wrong, and both are named.
#[test]
fn two_values_alone_are_both_named() {
    let found = contradictions(&sheet(&[
        ("torque_constant", "30.5"),
        ("speed_constant", "135"),
        ("terminal_resistance", "1"),
    ]));
    assert_eq!(found.len(), 1);
    let names: Vec<&str> = found[0].iter().map(|c| c.quantity).collect();
    assert_eq!(names, ["torque_constant", "speed_constant"]);
    assert!(
        (found[0][1].expected - 313.1).abs() < 0.1 && (found[0][1].ratio - 0.431).abs() < 1e-3,
        "{found:?}"
    );
}

/// Two wrong values in one datasheet are both found.
#[test]
fn two_wrong_values_are_found() {
    let found = contradictions(&with(&[("stall_torque", "3000"), ("mechanical_time_constant", "6")]));
    assert_eq!(found.len(), 2, "{found:?}");
    for (key, factor) in [("stall_torque", 3000.0 / 2560.0), ("mechanical_time_constant", 6.0 / 4.28)] {
        let named = found.iter().flatten().find(|c| c.quantity == key);
        assert!(
            (named.unwrap_or_else(|| panic!("{found:?}")).ratio / factor - 1.0).abs() < 0.02,
            "{found:?}"
        );
    }
}

/// Thermal values that no motor has: time constants, mass and dimensions of another motor.
#[test]
fn what_no_motor_has_is_named() {
    for (change, words) in [
        (("motor_time_constant", "8090"), "specific heat"),
        (("mass", "4.8"), "specific heat"),
        (("winding_time_constant", "415"), "heat capacity of the winding"),
        (("length", "7.1"), "mean density"),
        (("rotor_inertia", "13700"), "rotor inertia"),
        (("no_load_current", "5000"), "no-load current"),
        (("max_winding_temperature", "428.15"), "maximum winding temperature"),
    ] {
        let found = implausible(&with(&[change]));
        assert!(found.iter().any(|i| i.words.starts_with(words)), "{change:?}: {found:?}");
    }
}

/// The motors of the library: the datasheets that contradict themselves are those whose deviations its test records.
#[test]
fn the_library_agrees_with_itself_where_its_test_says_so() {
    let printed: toml::Table =
        include_str!("../../../../tests/python/preset_datasheets.toml").parse().unwrap();
    let declaration = (describe::models::by_name(MOTOR).unwrap().declaration)();
    let mut checked = 0;
    for preset in Preset::built_in().unwrap() {
        let Some(toml::Value::Table(print)) = printed.get(&preset.name) else { continue };
        if preset.model != MOTOR || print.contains_key("no_datasheet") {
            continue;
        }
        let mut sheet = Datasheet::default();
        for (key, variable) in [
            ("terminal_resistance", "motor.R_ref"),
            ("torque_constant", "motor.k_t"),
            ("rotor_inertia", "motor.J"),
            ("resistance_winding_housing", "thermal.R_wh"),
            ("mass", "motor.mass"),
        ] {
            let entry = declaration.by_name(variable).unwrap();
            if preset.starts.names(entry) {
                let text = format!("{} {}", preset.starts.of(entry), entry.row.unit.name());
                sheet.put(Value::parse(by_key(key).unwrap(), &text).unwrap());
            }
        }
        for (key, unit, quantity) in [
            ("nominal_voltage_V", "V", "nominal_voltage"),
            ("no_load_speed_rpm", "rpm", "no_load_speed"),
            ("no_load_current_mA", "mA", "no_load_current"),
            ("speed_constant_rpm_per_V", "rpm/V", "speed_constant"),
            ("mechanical_time_constant_ms", "ms", "mechanical_time_constant"),
            ("stall_torque_mNm", "mN.m", "stall_torque"),
        ] {
            if let Some(value) = print.get(key) {
                sheet.put(Value::parse(by_key(quantity).unwrap(), &format!("{value} {unit}")).unwrap());
            }
        }
        let deviations = print.get("deviation").and_then(toml::Value::as_table);
        let known = |name: &str| deviations.is_some_and(|d| d.contains_key(name));
        let expected = known("stall_torque") || known("mechanical_time_constant");
        let found = contradictions(&sheet);
        println!("{}: {found:?}", preset.name);
        assert_eq!(!found.is_empty(), expected, "{}: {found:?}", preset.name);
        checked += 1;
    }
    assert!(checked >= 14, "{checked}");
}

#[test]
fn too_few_values_and_wrong_texts_are_one_sentence() {
    let error = Draft::new(&sheet(&[("terminal_resistance", "1"), ("nominal_voltage", "24")]))
        .unwrap_err()
        .to_string();
    assert!(error.contains("motor.k_t") && error.contains("speed_constant"), "{error}");
    for (key, text, words) in [
        ("torque_constant", "60 mH", "not a unit of the same quantity"),
        ("torque_constant", "much", "not a number"),
        ("torque_constant", "0", "positive"),
        ("pole_pairs", "1.5", "whole"),
        ("no_load_speed", "-5 rpm", "positive"),
    ] {
        let error = Value::parse(by_key(key).unwrap(), text).unwrap_err();
        assert!(error.contains(words) && error.contains(key), "{error}");
    }
    let comma = Value::parse(by_key("torque_constant").unwrap(), "60,3 mNm/A").unwrap();
    assert_eq!(comma.si, 0.0603);
    let text = "name = \"x\"\n[datasheet]\ntorque_constnt = 3\nmass = \"3 m\"\nmax_winding_temperature = \"428 K\"\n";
    let error = Datasheet::parse(text, "d.toml").unwrap_err().to_string();
    assert_eq!(error.lines().count(), 2, "{error}");
    assert!(
        error.starts_with("d.toml:3: torque_constnt") && error.contains("did you mean torque_constant?"),
        "{error}"
    );
    assert!(error.contains("d.toml:4: mass"), "{error}");
}

/// FAULHABER 1331 T 012 SR as its datasheet prints it, in its terms: brushed, 12 V.
const FAULHABER_1331: &str = "
name = \"x\"
[datasheet]
nominal_voltage = 12
terminal_resistance = 13.7
efficiency = 80
no_load_speed = 9900
no_load_current = \"0.0105 A\"
stall_torque = 9.90
friction_torque = 0.12
speed_constant = 835
back_emf_constant = \"1.20 mV/rpm\"
torque_constant = 11.4
current_constant = 0.087
slope_of_n_m_curve = 1000
rotor_inductance = \"310 µH\"
mechanical_time_constant = 7
rotor_inertia = 0.67
angular_acceleration = 150
rth1 = 6
rth2 = 25
tau_w1 = 5
tau_w2 = 190
max_rotor_temperature = 125
weight = 19
";

/// The same values in the terms of makers other than maxon, with each of the new ones wrong in turn.
#[test]
fn the_terms_of_other_makers_are_read_and_checked() {
    let sheet = Datasheet::parse(FAULHABER_1331, "sheet.toml").unwrap();
    assert_eq!(contradictions(&sheet), Vec::<Vec<Contradiction>>::new());
    assert_eq!(implausible(&sheet), []);
    let draft = Draft::new(&sheet).unwrap();
    let get = |name: &str| draft.values.iter().find(|v| v.name == name).unwrap();
    for (name, value) in [
        ("motor.L", 310e-6),
        ("thermal.C_w", 5.0 / 6.0),
        ("thermal.C_h", 190.0 / 25.0 - 5.0 / 6.0),
        ("conductance.G_still", 0.04),
        ("thermal.T_w_max", 398.15),
        ("motor.mass", 0.019),
    ] {
        assert!((get(name).value / value - 1.0).abs() < 1e-12, "{:?}", get(name));
        assert!(matches!(get(name).certainty, Certainty::Datasheet | Certainty::Derived));
    }
    for (key, text, factor) in [
        ("back_emf_constant", "2.4 mV/rpm", 2.0),
        ("current_constant", "87", 1000.0),
        ("friction_torque", "0.36", 3.0),
        ("angular_acceleration", "300", 2.0),
    ] {
        let mut wrong = sheet.clone();
        wrong.put(Value::parse(by_key(key).unwrap(), text).unwrap());
        let found = contradictions(&wrong);
        let named = found.iter().flatten().find(|c| c.quantity == key);
        let named = named.unwrap_or_else(|| panic!("{key}: {found:?}"));
        assert!((named.ratio / factor - 1.0).abs() < 0.1, "{named:?}");
    }
    let twice =
        Datasheet::parse(&format!("{FAULHABER_1331}mass = 19\n"), "sheet.toml").unwrap_err().to_string();
    assert!(twice.contains("mass is given twice") && !twice.contains('\n'), "{twice}");
}

/// A frameless motor with what such datasheets print: each value of the model follows from a relation of its own.
#[test]
fn a_frameless_motor_follows_from_its_constants() {
    let sheet = sheet(&[
        ("back_emf_constant", "7.39 V/krpm"),
        ("motor_constant", "0.0862 N.m/√W"),
        ("electrical_time_constant", "1.1"),
        ("poles", "12"),
        ("rotor_inertia", "0.37 kg.cm2"),
        ("resistance_winding_ambient", "1.75"),
        ("motor_time_constant", "15 min"),
        ("static_friction_torque", "12"),
        ("dynamic_friction", "0.003"),
        ("weight", "0.6 kg"),
    ]);
    let draft = Draft::new(&sheet).unwrap();
    let get = |name: &str| draft.values.iter().find(|v| v.name == name).unwrap();
    let k_t = 7.39e-3 * 30.0 / std::f64::consts::PI;
    let r = (k_t / 0.0862).powi(2);
    for (name, value, certainty) in [
        ("motor.k_t", k_t, Certainty::Datasheet),
        ("motor.R_ref", r, Certainty::Derived),
        ("motor.L", 1.1e-3 * r, Certainty::Derived),
        ("motor.pole_pairs", 6.0, Certainty::Derived),
        ("effect.coulomb_friction.tau_c", 0.012, Certainty::Derived),
        ("effect.viscous_friction.k", 3e-6 * 30.0 / std::f64::consts::PI, Certainty::Derived),
        ("thermal.R_wh", 0.24 * 1.75, Certainty::Estimate),
        ("conductance.G_still", 1.0 / (0.76 * 1.75), Certainty::Estimate),
        ("thermal.C_w", 0.09 * 900.0 / (0.76 * 1.75), Certainty::Estimate),
        ("thermal.C_h", 0.91 * 900.0 / (0.76 * 1.75), Certainty::Estimate),
    ] {
        assert!((get(name).value / value - 1.0).abs() < 1e-9, "{:?} instead of {value}", get(name));
        assert_eq!(get(name).certainty, certainty, "{name}");
    }
    // Without time constant the mass gives the heat capacity.
    let mut light = sheet.clone();
    light.values.retain(|v| v.quantity.key != "motor_time_constant");
    let draft = Draft::new(&light).unwrap();
    let c: f64 = draft
        .values
        .iter()
        .filter(|v| ["thermal.C_w", "thermal.C_h"].contains(&v.name.as_str()))
        .map(|v| v.value)
        .sum();
    assert!((c - 460.0 * 0.6).abs() < 1e-9, "{c}");
}

/// The fractions of the estimates are the medians of the presets with a datasheet.
#[test]
fn the_estimates_are_medians_of_the_library() {
    let declaration = (describe::models::by_name(MOTOR).unwrap().declaration)();
    let mut found: [Vec<f64>; 3] = Default::default();
    for preset in Preset::built_in().unwrap() {
        if preset.model != MOTOR || ["thesis-rig", "bench-bldc-stall"].contains(&preset.name.as_str()) {
            continue;
        }
        let get = |name: &str| preset.starts.of(declaration.by_name(name).unwrap());
        let (inner, outer) = (get("thermal.R_wh"), 1.0 / get("conductance.G_still"));
        let (winding, housing) = (get("thermal.C_w"), get("thermal.C_h"));
        let all = winding + housing;
        for (list, value) in
            found.iter_mut().zip([inner / (inner + outer), winding / all, all / get("motor.mass")])
        {
            list.push(value);
        }
    }
    let expected = super::ways::OF_LIBRARY;
    for (list, expected) in found.iter_mut().zip([expected.0, expected.1, expected.2]) {
        list.sort_by(f64::total_cmp);
        let median = 0.5 * (list[list.len() / 2] + list[(list.len() - 1) / 2]);
        assert!((median / expected - 1.0).abs() < 0.05, "median {median}, {expected} used");
    }
}

/// No name stands for two quantities, and each name is a flag.
#[test]
fn names_are_unique() {
    let mut names: Vec<&str> =
        QUANTITIES.iter().flat_map(|q| std::iter::once(q.key).chain(q.aliases.iter().copied())).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}

/// Pittman prints a friction torque and a viscous damping: both are used, under either name of the first.
#[test]
fn a_friction_torque_beside_a_dynamic_one_is_the_static_one() {
    let motor = [("torque_constant", "60"), ("terminal_resistance", "1")];
    let damping = ("dynamic_friction", "0.0135 oz-in/krpm");
    let draft = |more: &[(&str, &str)]| Draft::new(&sheet(&[&motor[..], more].concat())).unwrap();
    let of = |draft: &Draft, name: &str| draft.values.iter().find(|v| v.name == name).unwrap().value;
    for key in ["friction_torque", "static_friction_torque"] {
        let both = draft(&[(key, "1.8 oz-in"), damping]);
        assert!((of(&both, "effect.coulomb_friction.tau_c") / 0.012_711 - 1.0).abs() < 1e-3, "{key}");
        // 0.0135 oz-in = 9.533e-5 N.m per 1000 rpm = 104.72 rad/s.
        assert!((of(&both, "effect.viscous_friction.k") / 9.103e-7 - 1.0).abs() < 1e-3, "{key}");
        assert!(both.not_used.is_empty());
    }
    // The no-load loss less its viscous part.
    let rest = draft(&[("no_load_current", "100"), ("no_load_speed", "1000"), ("dynamic_friction", "0.001")]);
    assert!((of(&rest, "effect.coulomb_friction.tau_c") - 5e-3).abs() < 1e-9);
    assert_eq!(draft(&[damping]).not_used, ["friction torque, dynamic 0.0135 oz-in/krpm"]);
}

/// Relations that catch a factor of 1000, and two names of one quantity.
#[test]
fn a_wrong_prefix_is_implausible() {
    for (changes, words) in [
        (&[("poles", "4"), ("pole_pairs", "3")][..], "number of poles / number of pole pairs"),
        (&[("no_load_current", "0.0686")], "no-load current / stall current"),
        (&[("torque_constant", "0.0603")], "no-load speed: nominal voltage / torque constant"),
        (&[("torque_constant", "0.0603")], "motor constant squared / mass"),
        (&[("torque_constant", "0.0603")], "mechanical time constant"),
    ] {
        let found = implausible(&with(changes));
        assert!(found.iter().any(|i| i.words.contains(words)), "{words}: {found:?}");
    }
    let few = sheet(&[("torque_constant", "60"), ("terminal_resistance", "1")]);
    assert!(!is_comparable(&few) && is_comparable(&sheet(RE40)));
    for (text, good) in [("120", false), ("0.85", false), ("85", true), ("100", true)] {
        let parsed = Value::parse(by_key("max_efficiency").unwrap(), text);
        assert_eq!(parsed.is_ok(), good, "{text}");
    }
    assert!(Value::parse(by_key("max_efficiency").unwrap(), "120").unwrap_err().contains("1 ... 100 %"));
}
