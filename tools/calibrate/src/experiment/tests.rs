use super::*;

const HEAD: &str = r#"[experiment]
name   = "bench-17"
model  = "AnnulusCooledMotor"
preset = "maxon-305015"
inputs  = ["current_A", "speed_rad_per_s", "ambient_temperature_degC"]
outputs = ["voltage_V", "winding_temperature_degC"]
"#;
const REST: &str = r#"
[set]
cooling_mode = "conductance"
"conductance.G_still" = 0.2
[prior]
"motor.R_ref" = 0.03
[noise]
winding_temperature_degC = 0.1
[[run]]
file = "a.csv"
role = "fit"
[[run]]
file = "a.csv"
role = "test"
window_s = [1.0, 4.0]
start = "measured"
[run.set]
cooling_mode = "bare"
"housing.emissivity" = 0.3
"#;
const RUN: &str = "time_s,current_A,speed_rad_per_s,ambient_temperature_degC,voltage_V,winding_temperature_degC\n\
                   0,1,100,23,3,23\n2,1,100,23,3,24\n4,1,100,23,3,25\n";

fn read(text: &str) -> Result<Experiment, CalibrateError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.csv"), RUN).unwrap();
    Experiment::parse(text, "e.toml".to_string(), folder.path())
}

#[test]
fn an_experiment_in_full() {
    let found = read(&format!("{HEAD}{REST}")).unwrap();
    assert_eq!((found.name.as_str(), found.model.as_str()), ("bench-17", "AnnulusCooledMotor"));
    let value = |name: &str| found.set.iter().find(|(n, _)| n == name).map(|(_, v)| *v);
    assert_eq!(value("drive_mode"), Some(3.0));
    assert_eq!(value("mechanical_mode"), Some(2.0));
    assert_eq!(value("conductance.G_still"), Some(0.2));
    assert_eq!(
        found.priors,
        [Prior { name: "motor.R_ref".to_string(), deviation: Deviation::Relative(0.03) }]
    );
    assert_eq!(found.noise["winding_temperature_degC"], 0.1);
    assert_eq!(found.runs.len(), 2);
    let last = &found.runs[1];
    assert_eq!((last.role, last.window, last.start), (Role::Test, Some((1.0, 4.0)), Start::Measured));
    assert_eq!(last.table.columns[4], [296.15, 297.15, 298.15]);
    // `bare` is the second value of the mode.
    assert_eq!(last.set, [("cooling_mode".to_string(), 2.0), ("housing.emissivity".to_string(), 0.3)]);
    assert!(found.runs[0].set.is_empty());
}

/// A water jacket with a constant flow, and an input that a column drives.
#[test]
fn an_input_without_a_column_may_be_set() {
    let set = |line: &str| read(&format!("{HEAD}{}", REST.replace("[prior]", &format!("{line}\n[prior]"))));
    let found = set("coolant_flow_rate = 1.5e-5").unwrap();
    assert!(found.set.contains(&("coolant_flow_rate".to_string(), 1.5e-5)));
    let refused = set("imposed_speed = 100").unwrap_err().to_string();
    assert!(refused.contains("imposed_speed is driven by the column speed_rad_per_s"), "{refused}");
    let limits = set("coolant_flow_rate = -1").unwrap_err().to_string();
    assert!(limits.contains("coolant_flow_rate"), "{limits}");
}

/// Each error names the line that causes it.
#[test]
fn what_cannot_be_is_named_with_file_and_line() {
    let all = format!("{HEAD}{REST}");
    for (from, to, parts) in [
        ("\"AnnulusCooledMotor\"", "\"SteamEngine\"", ["e.toml:3:", "SteamEngine is no model"]),
        ("\"current_A\",", "\"currant_A\",", ["e.toml:5:", "currant_A is no input"]),
        ("\"voltage_V\",", "\"duty_1\",", ["e.toml:6:", "duty_1 is no output"]),
        ("\"conductance.G_still\" = 0.2", "\"conductance.G_stil\" = 0.2", ["e.toml:10:", "is no parameter"]),
        ("= 0.2", "= -0.2", ["e.toml:10:", "outside its limits"]),
        ("\"conductance\"", "\"steam\"", ["e.toml:9:", "none of conductance, bare"]),
        ("= 0.03", "= 0.0", ["e.toml:12:", "must be above 0"]),
        ("winding_temperature_degC = 0.1", "duty_1 = 0.1", ["e.toml:14:", "no input or output"]),
        ("[1.0, 4.0]", "[4.0, 1.0]", ["e.toml:18:", "is empty"]),
        ("[1.0, 4.0]", "[5.0, 9.0]", ["e.toml:18:", "holds no row of a.csv, which runs from 0 s to 4 s"]),
        ("role = \"fit\"", "role = \"fitt\"", ["e.toml:17:", "fitt"]),
        ("role = \"fit\"", "role = \"validate\"", ["e.toml:", "no run has role"]),
        ("file = \"a.csv\"\nrole = \"fit\"", "file = \"b.csv\"\nrole = \"fit\"", ["b.csv", "cannot be read"]),
        ("= 0.3", "= 1.3", ["e.toml:25:", "outside its limits"]),
        ("\"bare\"", "\"steam\"", ["e.toml:24:", "none of conductance, bare"]),
        ("\"housing.emissivity\"", "\"housing.emission\"", ["e.toml:25:", "is no parameter"]),
        ("\"housing.emissivity\"", "\"motor.R_ref\"", ["e.toml:25:", "motor.R_ref has a prior"]),
        (", \"winding_temperature_degC\"]", ", \"shaft_torque_Nm\"]", ["e.toml:", "is no input or output"]),
        ("preset = ", "present = ", ["e.toml:4:", "present"]),
    ] {
        assert!(all.contains(from), "{from}");
        let sentence = read(&all.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{to}: {sentence}");
        assert!(!sentence.contains('\n'), "{sentence}");
    }
}

/// Errors in a run's file are found when the experiment is read, and the message names that file.
#[test]
fn what_a_file_has_wrong_is_named_when_the_experiment_is_read() {
    for (from, to, parts) in [
        ("2,1,100", "2,NaN,100", ["a.csv:3:", "current_A = NaN is not a finite"]),
        ("2,1,100", "2,one,100", ["a.csv:3:", "current_A = one is not a number"]),
        (",voltage_V,", ",volts,", ["a.csv:1:", "the column voltage_V is missing"]),
        ("4,1,100", "1,1,100", ["a.csv:4:", "does not come after 2 s"]),
    ] {
        assert!(RUN.contains(from), "{from}");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.csv"), RUN.replacen(from, to, 1)).unwrap();
        let path = folder.path().join("EXPERIMENT.toml");
        std::fs::write(&path, format!("{HEAD}{REST}")).unwrap();
        let sentence = Experiment::read(&path).unwrap_err().to_string();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{to}: {sentence}");
        assert!(!sentence.contains('\n'), "{sentence}");
    }
    let sentence = Experiment::read(Path::new("no/such/EXPERIMENT.toml")).unwrap_err().to_string();
    assert!(sentence.contains("no/such/EXPERIMENT.toml cannot be read"), "{sentence}");
}

/// Parameters that are unknown in one run, with relative or absolute standard deviation.
#[test]
fn priors_of_one_run() {
    let of = |text: &str| read(&format!("{HEAD}{REST}[run.prior]\n{text}\n"));
    let stem = "\"effect.winding_sensor_stem_loss.k\" = 0.5";
    let offset = "\"effect.winding_sensor_offset.offset\" = \"1500 mK\"";
    let found = of(&format!("{stem}\n{offset}")).unwrap();
    assert_eq!(found.runs[0].priors, []);
    let deviations: Vec<Deviation> = found.runs[1].priors.iter().map(|p| p.deviation).collect();
    assert_eq!(deviations, [Deviation::Absolute(1.5), Deviation::Relative(0.5)]);
    assert_eq!(Deviation::Relative(0.5).of(0.0, 0.05), 0.025);
    for (text, parts) in [
        (offset.replace("mK", "mV"), "mV"),
        (offset.replace("1500 mK", "wide"), "a relative standard deviation such as 0.1"),
        (stem.replace("0.5", "-0.5"), "must be above 0"),
        (stem.replace("0.5", "\"0 %\""), "must be above 0"),
        (stem.replace("effect.winding_sensor_stem_loss.k", "motor.R_ref"), "one number for all runs"),
        (stem.replace("stem_loss.k", "stem.k"), "is no parameter"),
    ] {
        let sentence = of(&text).unwrap_err().to_string();
        assert!(sentence.starts_with("e.toml:") && sentence.contains(parts), "{text}: {sentence}");
    }
}

#[test]
fn a_warm_start_needs_a_temperature() {
    let all = format!("{HEAD}{REST}")
        .replace(", \"winding_temperature_degC\"]", "]")
        .replace("winding_temperature_degC = 0.1", "");
    let sentence = read(&all).unwrap_err().to_string();
    assert!(
        sentence.contains("e.toml:18:") && sentence.contains("no temperature of the motor"),
        "{sentence}"
    );
}

/// The gearmotor of the paper has its own columns and no modes.
#[test]
fn a_gearmotor_has_an_experiment_too() {
    let text = r#"[experiment]
name = "box"
model = "BrushedGearmotor"
preset = "bdcm-37d"
inputs = ["duty_1", "supply_voltage_V", "ambient_temperature_degC"]
outputs = ["voltage_V", "current_A", "box_temperature_degC"]
[[run]]
file = "b.csv"
role = "fit"
"#;
    let folder = tempfile::tempdir().unwrap();
    let run = "time_s,duty_1,supply_voltage_V,ambient_temperature_degC,voltage_V,current_A,box_temperature_degC\n\
               0,1,12,20,9,0.2,20\n2,1,12,20,9,0.2,20\n";
    std::fs::write(folder.path().join("b.csv"), run).unwrap();
    let parse = |text: &str| Experiment::parse(text, "e.toml".to_string(), folder.path());
    let found = parse(text).unwrap();
    assert!(found.set.is_empty());
    let outputs: Vec<_> = found.outputs.iter().filter_map(|c| c.output).collect();
    assert_eq!(outputs, ["voltage", "current", "box_temperature"]);
    let sentence = parse(&text.replace("\"duty_1\"", "\"voltage_V\"")).unwrap_err().to_string();
    assert!(
        sentence.starts_with(
            "e.toml:5: voltage_V is no input of BrushedGearmotor; there is supply_voltage_V, duty_1,"
        ),
        "{sentence}"
    );
}

const MAPPED: &str = r#"
[columns]
"Zeit"              = { name = "time" }
"I [mA]"            = { name = "current", unit = "mA" }
"n [1/min]"         = { name = "speed", unit = "rpm" }
"Umgebung [°F]"     = { name = "ambient_temperature_degC", unit = "°F" }
"Klemmenspannung/V" = { name = "voltage" }
"T_W [K]"           = { name = "winding_temperature", unit = "K" }
[[run]]
file = "a.csv"
role = "fit"
"#;

fn read_with(rest: &str, rows: &[u8]) -> Result<Experiment, CalibrateError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.csv"), rows).unwrap();
    Experiment::parse(&format!("{HEAD}{rest}"), "e.toml".to_string(), folder.path())
}

/// A file as written by a logger: own headers and units, semicolons, decimal commas, dates, a repeated row, not UTF-8.
#[test]
fn a_foreign_file_is_read_through_its_columns() {
    let rows = "# a logger's own remark\nZeit;I [mA];n [1/min];Umgebung [°F];Klemmenspannung/V;T_W [K]\n\
                2025-11-19T23:59:59,5;1500;955,5;68;3,25;293,15\n\
                2025-11-20T00:00:01;1500;955,5;68;;293,65\n2025-11-20T00:00:01;1500;955,5;68;;293,65\n\
                2025-11-20T00:00:03;-1.5e3;0;68;3;294,15\n";
    let latin: Vec<u8> = rows.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    for bytes in [rows.as_bytes(), &latin] {
        let found = read_with(MAPPED, bytes).unwrap();
        let table = &found.runs[0].table;
        assert_eq!(table.time, [86_399.5, 86_401.0, 86_403.0]);
        let near = |column: usize, row: usize, value: f64| {
            assert!((table.columns[column][row] - value).abs() < 1e-4, "{column} {row}: {:?}", table.columns);
        };
        near(0, 0, 1.5);
        near(0, 2, -1.5);
        near(1, 0, 100.059_73);
        near(2, 0, 293.15);
        near(3, 0, 3.25);
        near(4, 1, 293.65);
        assert!(table.columns[3][1].is_nan());
        let notes: Vec<&String> = found.notes.iter().filter(|n| n.contains("set aside")).collect();
        assert!(notes.len() == 1 && notes[0].contains("1 rows repeat"), "{:?}", found.notes);
    }
}

/// A column given by its quantity takes the unit in the brackets of its header; other text in brackets is a remark.
#[test]
fn units_of_headers_count() {
    let rows = RUN.replacen("current_A", "I [mA]", 1).replacen("speed_rad_per_s", "n (Sensor 2)", 1);
    let runs = "[columns]\n\"I [mA]\" = \"current\"\n\"n (Sensor 2)\" = \"speed\"\n[[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n";
    let own = read_with("[[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n", RUN.as_bytes()).unwrap();
    let found = read_with(runs, rows.as_bytes()).unwrap();
    let columns = |e: &Experiment| e.runs[0].table.columns.clone();
    let milli: Vec<f64> = columns(&own)[0].iter().map(|i| i * 1e-3).collect();
    assert_eq!((&columns(&found)[0], &columns(&found)[1]), (&milli, &columns(&own)[1]));
    assert!(found.headers.contains(&("current_A", "I [mA]".to_owned())));
    let sentence = |runs: String| read_with(&runs, rows.as_bytes()).unwrap_err().to_string();
    let refused = sentence(runs.replacen("\"current\"", "\"voltage\"", 1));
    assert!(refused.contains("mA is no unit of voltage"), "{refused}");
    let refused = sentence(runs.replacen("\"current\"", "3", 1));
    assert!(refused.contains("a column is \"quantity\" or {") && !refused.contains("struct"), "{refused}");
}

/// A clock without dates wraps at midnight; a column may keep its contract name next to mapped columns.
#[test]
fn clocks_and_names_of_the_contract() {
    let rows =
        RUN.replace("\n0,", "\n23:59:58,").replace("\n2,", "\n00:00:00.5,").replace("\n4,", "\n0:00:02,");
    let found = read_with("[[run]]\nfile = \"a.csv\"\nrole = \"fit\"\n", rows.as_bytes()).unwrap();
    assert_eq!(found.runs[0].table.time, [86_398.0, 86_400.5, 86_402.0]);
    // Quantity names without unit in the lists of inputs and outputs.
    let short = format!("{HEAD}{REST}")
        .replace("\"speed_rad_per_s\"", "\"speed\"")
        .replace("\"voltage_V\"", "\"voltage\"");
    assert_eq!(
        (read(&short).unwrap().inputs[1].column, read(&short).unwrap().outputs[0].column),
        ("speed_rad_per_s", "voltage_V")
    );
}

/// Two thermocouples on the housing; one run declares that it has only the second.
#[test]
fn several_sensors_on_a_node_and_channels_that_a_file_lacks() {
    let outputs = "\"winding_temperature_degC\", \"housing_temperature_degC\", \"housing_temperature_2\"]";
    let rest = "[columns]\n\"T3\" = { name = \"housing_temperature_2\", unit = \"K\" }\n\
                [[run]]\nfile = \"a.csv\"\nrole = \"fit\"\nnot_measured = [\"housing_temperature\"]\n";
    let text = format!("{}{rest}", HEAD.replace("\"winding_temperature_degC\"]", outputs));
    let rows = "time_s,current_A,speed_rad_per_s,ambient_temperature_degC,voltage_V,winding_temperature_degC,T3\n\
                0,1,100,20,3,20,293\n2,1,100,20,3,21,294\n";
    let folder = tempfile::tempdir().unwrap();
    let parse = |text: &str, rows: &str| {
        std::fs::write(folder.path().join("a.csv"), rows).unwrap();
        Experiment::parse(text, "e.toml".to_string(), folder.path())
    };
    let found = parse(&text, rows).unwrap();
    let columns: Vec<&str> = found.outputs.iter().map(|c| c.column).collect();
    let place = |column: &str| columns.iter().position(|c| *c == column).unwrap();
    let of = |column: &str| &found.runs[0].table.columns[found.inputs.len() + place(column)];
    assert!(of("housing_temperature_degC").iter().all(|x| x.is_nan()));
    assert_eq!(of("housing_temperature_2_degC")[..], [293.0, 294.0]);
    let whole = rows
        .replace(",T3", ",T3,housing_temperature_degC")
        .replace("293\n", "293,20\n")
        .replace("294\n", "294,21\n");
    for (text, rows, parts) in [
        (
            text.replace("not_measured", "#"),
            rows,
            ["a.csv:1:", "not_measured = [\"housing_temperature_degC\"]"],
        ),
        (
            text.replace("[\"housing_temperature\"]\n", "[\"housing\"]\n"),
            rows,
            ["e.toml:", "housing, which is no output"],
        ),
        (text.clone(), whole.as_str(), ["a.csv:1:", "the file has this column"]),
        (
            text.replace("housing_temperature_2\"]", "housing_temperature_1\"]"),
            rows,
            ["e.toml:", "is no output"],
        ),
    ] {
        let sentence = parse(&text, rows).unwrap_err().to_string();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{sentence}");
    }
}

#[test]
fn columns_that_cannot_be_are_named_with_line() {
    for (from, to, parts) in [
        ("\"current\"", "\"curent\"", ["e.toml:10:", "curent is no quantity"]),
        ("unit = \"rpm\"", "unit = \"N.m\"", ["e.toml:11:", "N.m is no unit of speed; there is rad/s, rpm"]),
        ("{ name = \"time\" }", "{ nome = \"time\" }", ["e.toml:9:", "nome"]),
        ("\"n [1/min]\" ", "\"n (1/min)\" ", ["a.csv:1:", "speed_rad_per_s (n (1/min)) is missing"]),
        ("\"T_W [K]\" ", "\"Klemmenspannung\" ", ["a.csv:1:", "winding_temperature_degC (Klemmenspannung)"]),
    ] {
        let rows =
            "Zeit;I [mA];n [1/min];Umgebung [°F];Klemmenspannung/V;T_W [K]\n0;1;2;68;3;293\n1;1;2;68;3;293\n";
        assert!(MAPPED.contains(from), "{from}");
        let sentence = read_with(&MAPPED.replace(from, to), rows.as_bytes()).unwrap_err().to_string();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{sentence}");
    }
    let twice = MAPPED.replace("\"T_W [K]\" ", "\"I2\" = { name = \"current\" }\n\"T_W [K]\" ");
    let rows = "Zeit;I [mA];I2;n [1/min];Umgebung [°F];Klemmenspannung/V;T_W [K]\n0;1;1;2;68;3;293\n1;1;1;2;68;3;293\n";
    let sentence = read_with(&twice, rows.as_bytes()).unwrap_err().to_string();
    assert!(sentence.contains("I [mA] and I2 both record current_A"), "{sentence}");
    let without = HEAD.replace(", \"ambient_temperature_degC\"", "");
    let sentence = read(&format!("{without}{REST}")).unwrap_err().to_string();
    assert!(sentence.starts_with("e.toml:5: ambient_temperature_degC is not among the inputs"), "{sentence}");
    let outputs = HEAD.lines().find(|line| line.starts_with("outputs")).unwrap();
    let sentence = read(&format!("{}{REST}", HEAD.replace(outputs, "outputs = []"))).unwrap_err().to_string();
    assert!(sentence.starts_with("e.toml:6: outputs is empty"), "{sentence}");
}
