use super::*;
use physics::declare::Unit;

/// A logger that changes its interval, also more than once, leaves no gap; one that stops does, also at both intervals.
#[test]
fn an_interval_that_changes_is_no_gap() {
    let gaps = |steps: &[(usize, f64)]| {
        let mut table = Table { time: vec![0.0], ..Table::default() };
        for (count, step) in steps {
            for _ in 0..*count {
                table.time.push(table.time[table.time.len() - 1] + step);
            }
        }
        table.note_gaps("a.csv");
        (table.gaps().collect::<Vec<_>>(), table.notes)
    };
    for steady in [&[(100, 1.0), (30, 20.0)][..], &[(60, 0.1), (20, 2.0), (60, 0.1), (20, 60.0)], &[(1, 9.0)]]
    {
        assert_eq!(gaps(steady), (vec![], vec![]), "{steady:?}");
    }
    let (rows, notes) = gaps(&[(100, 1.0), (1, 40.0), (50, 1.0), (30, 10.0), (1, 80.0), (30, 10.0)]);
    assert_eq!((rows, notes.len()), (vec![100, 181], 2));
    // Bursts of ten rows.
    let bursts: Vec<(usize, f64)> = (0..12).map(|k| if k % 2 == 0 { (10, 1.0) } else { (1, 50.0) }).collect();
    let (rows, notes) = gaps(&bursts[..11]);
    assert_eq!(rows.len(), 5);
    assert!(notes.len() == 1 && notes[0].contains("5 gaps without rows"), "{notes:?}");
}

fn read(text: &str) -> Result<Table, CalibrateError> {
    let wanted = ["current_A", "winding_temperature_degC"].map(|c| Channel::of(c).unwrap());
    Table::parse(text.as_bytes(), "run.csv", &wanted, 1, &[], &[])
}

const HEADER: &str = "time_s,winding_temperature_degC,current_A\n";

#[test]
fn columns_in_any_order_in_si_units_with_blanks() {
    let table = read(&format!("{HEADER}0,20,1.5\n2,,-2\n4, 21.5 ,\n")).unwrap();
    assert_eq!(table.time, [0.0, 2.0, 4.0]);
    assert_eq!(table.columns[0][..2], [1.5, -2.0]);
    assert!(table.columns[0][2].is_nan() && table.columns[1][1].is_nan());
    assert_eq!(table.columns[1][2], 294.65);
    assert!(table.notes.is_empty());
}

#[test]
fn what_cannot_be_is_named_with_file_and_line() {
    for (text, parts) in [
        ("time_s,current_A\n0,1\n", ["run.csv:1:", "winding_temperature_degC is missing"]),
        (
            "time_s,winding_temperature_degC,current_A\n0,20,1\n2,NaN,1\n",
            ["run.csv:3:", "= NaN is not a finite"],
        ),
        ("time_s,winding_temperature_degC,current_A\n0,20,1\n2,21,n/a\n", ["run.csv:3:", "current_A = n/a"]),
        (
            "time_s,winding_temperature_degC,current_A\n0,20,1\n2,20,1\n1,20,1\n",
            ["run.csv:4:", "does not come after 2 s"],
        ),
        ("time_s,winding_temperature_degC,current_A\n0,20,1\n,20,1\n", ["run.csv:3:", "time_s is blank"]),
        ("time_s,winding_temperature_degC,current_A\n0,20\n", ["run.csv:2:", "does not fit the header"]),
        ("time_s,winding_temperature_degC,current_A\n0,20,1\n", ["run.csv:", "1 rows are no run"]),
    ] {
        let sentence = read(text).unwrap_err().to_string();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{sentence}");
    }
}

#[test]
fn gaps_are_noted() {
    let rows: String = (0..20).map(|k| format!("{k},30,1\n")).collect();
    let table = read(&format!("{HEADER}{rows}100,30,1\n")).unwrap();
    assert!(table.notes.len() == 1 && table.notes[0].contains("from 19 s to 100 s"), "{:?}", table.notes);
}

/// The rows of a file as a logger writes it, in the columns time, current (an input) and winding temperature.
fn logged(text: &str) -> Result<Table, String> {
    let wanted = ["current_A", "winding_temperature_degC"].map(|c| Channel::of(c).unwrap());
    let column = |header: &str, column: &'static str, si, unit: &str, is_stated| Column {
        header: header.to_owned(),
        column,
        unit: super::super::units::by_name(si, unit).unwrap(),
        unit_name: unit.to_owned(),
        is_stated,
    };
    let mapped = [
        column("t", "time_s", Unit::Second, "s", false),
        column("I", "current_A", Unit::Ampere, "mA", true),
        column("Tw", "winding_temperature_degC", Unit::Kelvin, "degC", false),
    ];
    Table::parse(text.as_bytes(), "log.txt", &wanted, 1, &mapped, &[]).map_err(|e| e.to_string())
}

/// Lines before the header, a row of units with and without brackets, a restart of the logger.
#[test]
fn files_of_loggers_are_read_with_notes() {
    let rows = "0;1500;300\n250;1600;301\n";
    for units in ["ms;mA;K", "[ms];[mA];[K]", "(ms);-;(K)", "ms;;K"] {
        let table =
            logged(&format!("Device: 4\n\nt;I;Tw\n{units}\n{rows}t;I;Tw\n{units}\n500;1600;301\n")).unwrap();
        assert_eq!((&table.time[..], table.columns[0][0]), (&[0.0, 0.25, 0.5][..], 1.5), "{units}");
        assert_eq!(table.columns[1], [300.0, 301.0, 301.0]);
        let parts = [
            "log.txt: the header is in line 3",
            "line 7 repeats the header and is skipped",
            "line 4 is a row of units and is skipped; it gives time_s in ms, winding_temperature_degC in K",
        ];
        assert!(
            table.notes.len() == 3 && parts.iter().all(|p| table.notes.concat().contains(p)),
            "{:?}",
            table.notes
        );
    }
    let table = logged(&format!("t;I;Tw\n{rows}")).unwrap();
    assert_eq!((table.time[1], table.columns[1][0], table.notes), (250.0, 573.15, vec![]));
}

/// A row of units above the header, also behind a label and other lines; a title with words that are units is none.
#[test]
fn units_above_the_header() {
    let rows = "0;1500;300\n250;1600;301\n";
    for before in ["ms;mA;K\n", "Rig\n[ms];;[K]\n", "# (ms);(mA);(K)\n", "A;K;mA\nms;mA;K\nRun 7;;\n"] {
        let table = logged(&format!("{before}t;I;Tw\n{rows}")).unwrap();
        assert_eq!((table.time[1], table.columns[0][0], table.columns[1][0]), (0.25, 1.5, 300.0), "{before}");
        let line = if before.contains('\n') && !before.starts_with(['m', '#']) { 2 } else { 1 };
        let note = format!(
            "log.txt: line {line} is a row of units and is skipped; it gives time_s in ms, winding_temperature_degC in K"
        );
        assert!(table.notes.contains(&note), "{:?}", table.notes);
    }
    let labelled = logged(&format!("Y_Unit_Label;mA;K\nX0;0;0\nt;I;Tw\n{rows}")).unwrap();
    assert_eq!((labelled.time[1], labelled.columns[1][0]), (250.0, 300.0));
    for before in ["K;;\n", "V;A;m\n", "SN;A7;K20\n", "1;mA;K\n", "ms;Strom;T\n", "s;mA;K;V\n"] {
        let table = logged(&format!("{before}t;I;Tw\n{rows}")).unwrap();
        assert_eq!((table.time[1], table.columns[1][0]), (250.0, 573.15), "{before}: {:?}", table.notes);
    }
    for (text, parts) in [
        ("s;A;K\nt;I;Tw\n0;1;20\n1;1;20\n", ["log.txt:1:", "A for current_A", "states mA"]),
        ("rpm;mA;K\nt;I;Tw\n0;1;20\n1;1;20\n", ["log.txt:1:", "rpm for time_s", "no unit of it"]),
        ("ms;mA;K\nt;I;Tw\ns;mA;K\n0;1;20\n1;1;20\n", ["log.txt:3:", "s for time_s", "states ms"]),
        ("s;mA;K\nt;I;Tw\nms;mA;K\n0;1;20\n1;1;20\n", ["log.txt:3:", "ms for time_s", "states s"]),
    ] {
        let sentence = logged(text).unwrap_err();
        assert!(parts.iter().all(|part| sentence.contains(part)), "{sentence}");
    }
}

/// Numbers with their unit, a typographic minus, and text of an open sensor.
#[test]
fn cells_with_units_and_text() {
    let table =
        logged("t;I;Tw\n0 s;-2,5 mA;20,5 °C\n1;\u{2212}4 mA;-OL\n2;1;#DIV/0!\n3;1;25 degC\n").unwrap();
    assert_eq!(table.columns[0][..2], [-0.0025, -0.004]);
    assert_eq!((table.columns[1][0], table.columns[1][3]), (293.65, 298.15));
    assert!(table.columns[1][1].is_nan() && table.columns[1][2].is_nan());
    let note = "log.txt: 2 rows have text in place of winding_temperature_degC, the first -OL in line 3; these readings are taken as blank";
    assert_eq!(table.notes, [note]);
}

#[test]
fn errors_in_files_of_loggers_have_cause_and_remedy() {
    for (text, parts) in [
        ("t;I;Tw\ns;A;K\n0;1;20\n1;1;20\n", ["log.txt:2:", "A for current_A", "states mA"]),
        (
            "t;I;Tw\ns;mA;V\n0;1;20\n1;1;20\n",
            ["log.txt:2:", "V for winding_temperature_degC", "no unit of it"],
        ),
        ("t;I;Tw\nsec.;mA;quux\n0;1;20\n1;1;20\n", ["log.txt:2:", "for time_s", "stated in [columns]"]),
        ("t;I;Tw\n0;1 A;20\n1;1;20\n", ["log.txt:2:", "current_A = 1 A is in A", "of the column is mA"]),
        (
            "t;I;Tw\n0;1.432,41;20\n1;1;20\n",
            ["log.txt:2:", "1.432,41 has a thousands separator", "write numbers without"],
        ),
        ("t;I;Tw\n0;OPEN;20\n1;1;20\n", ["log.txt:2:", "current_A = OPEN", "is not a number"]),
        (
            "t;I;Tw\n0;1;OPEN\n1;1;OPEN\n",
            ["log.txt:2:", "winding_temperature_degC = OPEN", "is not a number"],
        ),
        (
            "a\nx;I;Tw\n0;1;20\n1;1;20\n",
            ["log.txt:2:", "time_s (t) is missing; there is x, I, Tw", "every row needs a time"],
        ),
        ("t;I;Tw;Tw\n0;1;20;20\n1;1;20;20\n", ["log.txt:1:", "2 columns have the header Tw", "its own name"]),
        (
            "t;I;Tw\n0;1;20\n4;1;20\nt;I;Tw\n1;1;20\n",
            ["log.txt:5:", "1 s does not come after 4 s", "repeated in line 4"],
        ),
        (
            "t;I;Tw\n2027-01-05 10:00:07;1;20\n2027-01-05 10:00:07;2;20\n",
            ["log.txt:3:", "2027-01-05 10:00:07 does not come after 2027-01-05 10:00:07", "resolution"],
        ),
        (
            "t;I;Tw\n12:59:50;1;20\n12:59:55;2;20\n1:00:00;2;20\n",
            ["log.txt:4:", "1:00:00 does not come", "12-hour clock"],
        ),
        (
            "t;I;Tw\n28.10.2029 02:59:00;1;20\n28.10.2029 02:59:30;1;20\n28.10.2029 02:00:00;1;20\n",
            ["log.txt:4:", "28.10.2029 02:00:00 does not come", "daylight saving time"],
        ),
        ("t;I;Tw\n7:10:00;1;20\n7:10:01;1;20\n7:02:00;1;20\n", ["log.txt:4:", "7:02:00", "was set back"]),
        ("t;I;Tw\n0;1;20\n\0\n2;1;20\n", ["log.txt:3:", "NUL bytes", "delete them"]),
    ] {
        let sentence = logged(text).unwrap_err();
        assert!(parts.iter().all(|part| sentence.contains(part)) && !sentence.contains('\n'), "{sentence}");
        assert!(!sentence.contains("not_measured = [\"time_s\"]"), "{sentence}");
    }
}
