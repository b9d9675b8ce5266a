use super::*;
use std::fs;
use std::path::Path;

const TEXT: &str = "# Prüfstand\n\nt [s];U [V];\r\n0;1,5;\n\n# Pause\n\"1\"; -2.5 ;;\n";

#[test]
fn thousands_separators_are_seen_in_their_column() {
    let column = |separator: &str, cells: &dyn Fn(u32) -> String| {
        let rows: String = (0..200).map(|k| format!("{k}{separator}{}\n", cells(k))).collect();
        Table::parse(format!("t{separator}n\n{rows}").as_bytes()).unwrap().grouped(1)
    };
    let grouped = |mark: char, n: u32| match n {
        0..1000 => n.to_string(),
        1000..1_000_000 => format!("{}{mark}{:03}", n / 1000, n % 1000),
        _ => format!("{}{mark}{:03}{mark}{:03}", n / 1_000_000, n / 1000 % 1000, n % 1000),
    };
    let values: [fn(u32) -> u32; 3] = [|k| 41 * k, |k| 23 * k, |k| k * k * k];
    for (separator, mark, value) in [(";", ',', 0), (";", '.', 0), (",", '.', 1), ("\t", ',', 2)] {
        let sign = |k: u32| if k.is_multiple_of(3) { "-" } else { "" };
        let signed = |k: u32| format!("{}{}", sign(k), grouped(mark, values[value](k)));
        let fault = column(separator, &signed).unwrap();
        assert!(fault.message.contains("thousands separator") && fault.line > 2, "{}", fault.message);
    }
    // Three decimals always; as many as needed; a small number of them; whole numbers alone; no number below 1000.
    let cells: [&dyn Fn(u32) -> String; 5] = [
        &|k| format!("{},{:03}", k / 50, k * 20 % 1000),
        &|k| format!("{}", f64::from(k) / 8.0).replace('.', ","),
        &|k| if k < 40 { format!("{},{}", k + 1, 100 + k) } else { k.to_string() },
        &|k| (k * 40).to_string(),
        &|k| format!("{},{:03}", 1 + k / 50, k * 20 % 1000),
    ];
    for (k, cells) in cells.iter().enumerate() {
        assert_eq!(column(";", cells), None, "{k}");
    }
}

/// What comes from a pipe has no folder of its own; a name alone is in the present one.
#[test]
fn names_are_relative_to_the_file_or_to_where_its_text_is_piped() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(folder(&own.join("Cargo.toml")), own);
    assert_eq!(
        [folder(Path::new("Cargo.toml")), folder(Path::new("a/missing"))],
        [Path::new(""), Path::new("a")]
    );
    if cfg!(unix) {
        assert_eq!(folder(Path::new("/dev/null")), Path::new(""));
    }
}

/// As the two files of Excel on a German machine, a logger and PowerShell have it.
#[test]
fn encodings_separators_and_decimal_commas() {
    let utf16: Vec<u8> =
        "\u{feff}".encode_utf16().chain(TEXT.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let windows: Vec<u8> = TEXT.chars().map(|c| c as u8).collect();
    for bytes in [TEXT.as_bytes(), format!("\u{feff}{TEXT}").as_bytes(), &utf16, &windows] {
        let table = Table::parse(bytes).unwrap();
        assert_eq!((table.header(), table.header_line()), (&["t [s]", "U [V]"].map(str::to_owned)[..], 3));
        let rows: Vec<(u64, Vec<String>)> = table
            .rows()
            .map(|row| row.unwrap())
            .map(|row| (row.line, row.cells.iter().map(|c| table.pointed(c).into_owned()).collect()))
            .collect();
        let expected = [(4, ["0", "1.5"]), (7, ["1", "-2.5"])];
        assert_eq!(rows, expected.map(|(line, cells)| (line, cells.map(str::to_owned).to_vec())));
    }
    let gehäuse = Table::parse(b"Geh\xe4use [\xb0C],t\n1,2\n").unwrap();
    assert_eq!(gehäuse.header()[0], "Gehäuse [°C]");
    assert_eq!(gehäuse.pointed("1,5"), "1,5");
}

/// A TOML file as editors and shells write it; not a spreadsheet, and not UTF-16 without mark.
#[test]
fn text_of_any_encoding_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sheet.toml");
    let text = "# Prüfstand\nL = \"310 µH\"\n";
    let little: Vec<u8> =
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> =
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_be_bytes).collect();
    let windows: Vec<u8> = text.chars().map(|c| c as u8).collect();
    for bytes in [text.as_bytes(), format!("\u{feff}{text}").as_bytes(), &little, &big, &windows] {
        fs::write(&path, bytes).unwrap();
        assert_eq!(read_text(&path).unwrap(), text);
    }
    for bytes in [&little[2..], b"PK\x03\x04\0\0"] {
        fs::write(&path, bytes).unwrap();
        assert!(read_text(&path).unwrap_err().to_string().contains("not text"));
    }
    assert!(read_text(&folder.path().join("none")).is_err());
}

#[test]
fn faults_have_lines() {
    let fault = |text: &[u8]| match Table::parse(text) {
        Err(fault) => fault.to_string(),
        Ok(table) => table.rows().find_map(Result::err).map_or(String::new(), |f| f.to_string()),
    };
    assert_eq!(fault(b""), "line 1: the file is empty");
    assert_eq!(fault(b"# only a comment\n\n"), "line 1: the file is empty");
    assert!(fault(b"PK\x03\x04\0\0").contains("not text"));
    let fits = "the row does not fit the header: it has";
    assert_eq!(fault(b"a;b\n1;2\n\n1\n"), format!("line 4: {fits} 1 cells, the header has 2"));
    assert!(
        fault(b"a,b\n1,5,2,5\n").ends_with("(a file with decimal commas needs semicolons between columns)")
    );
    assert_eq!(fault(b"a,b\n1,2\n"), "");
}

#[test]
fn units_stand_in_brackets() {
    for (header, parts) in [
        ("n [rpm]", ("n", Some("rpm"))),
        ("M(mN.m)", ("M", Some("mN.m"))),
        (" w[1] [1/min] ", ("w[1]", Some("1/min"))),
        ("T (top) [°C]", ("T (top)", Some("°C"))),
        ("speed", ("speed", None)),
        ("x []", ("x []", None)),
    ] {
        assert_eq!(name_and_unit(header), parts);
    }
}

/// Rows with their lines, and the header's line; the columns `t` and `U` are wanted.
fn found(text: &str) -> (Table, Vec<(u64, Vec<String>)>) {
    let table =
        Table::with_names(text.as_bytes(), &[vec!["t", "time"], vec!["U"], vec!["I", "current"]]).unwrap();
    let rows = table.rows().map(|row| row.unwrap());
    let rows = rows
        .map(|row| (row.line, row.cells.iter().map(|c| table.pointed(c).into_owned()).collect()))
        .collect();
    (table, rows)
}

/// Lines of a logger before the header, a directive for a spreadsheet, a header behind a comment sign.
#[test]
fn a_header_is_found_by_its_names() {
    for (text, line, has_remark) in [
        ("Device\tXY-3\r\nStart\t1.2.2026\r\n\r\nt\tU\tI\r\n0\t1,5\t2\r\n", 4, true),
        ("sep=,\nt,U,I\n0,1.5,2\n", 2, true),
        ("# logger\n# t; U; I\n0;1,5;2\n", 2, false),
        ("%t,U,I\n0,1.5,2\n", 1, false),
        ("// remark\n// time;U;current\n0;1.5;2\n", 2, true),
        ("Channels: t; U; I\nrecorded with U=5\nt;U;I\n0;1,5;2\n", 3, true),
        // Names before the header that are fewer than those of the header.
        ("Kanal;t;U\n\nt;U;I\n0;1,5;2\n", 1, false),
        ("x;U;I;t\n0;1,5;2;0\n", 1, false),
        // Without the first column, the line with most names.
        ("a\nclock;U;I\n0;1,5;2\n", 2, true),
    ] {
        let table = Table::with_names(text.as_bytes(), &[vec!["t", "time"], vec!["U"], vec!["I", "current"]])
            .unwrap();
        assert_eq!((table.header_line(), !table.remarks().is_empty()), (line, has_remark), "{text}");
    }
    let (table, rows) =
        found("Device\tXY-3\r\nStart\t1.2.2026\r\n\r\nt\tU\tI\r\n0\t1,5\t\u{2212}2\r\n\r\n2\t1\t0\r\n");
    assert_eq!(table.header(), ["t", "U", "I"]);
    assert_eq!(table.remarks()[0].message, "the header is in line 4; the lines before it are skipped");
    let expected = [(5, ["0", "1.5", "-2"]), (7, ["2", "1", "0"])];
    assert_eq!(rows, expected.map(|(line, cells)| (line, cells.map(str::to_owned).to_vec())));
    // Names that are not found: the line above the numbers, not the preamble.
    let none =
        Table::with_names(b"Unit 3\nzeit;spannung\n[s];[V]\n0;1,5\n", &[vec!["t"], vec!["U"]]).unwrap();
    assert_eq!(none.header_line(), 3);
    assert_eq!(Table::with_names(b"# U\n", &[vec!["t"], vec!["U"]]).unwrap_err(), empty());
}

/// Lines before the header in its columns, the nearest first; a line with more cells is no row of it.
#[test]
fn lines_above_the_header_have_its_columns() {
    let above = |text: &str| -> Vec<(u64, Vec<String>)> {
        let rows = found(text).0.above().into_iter();
        rows.map(|row| (row.line, row.cells.iter().map(str::to_owned).collect())).collect()
    };
    let cells = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
    assert_eq!(
        above("Rig 3\na;b;c;d\n\n# s; V ;;\nt;U;I\n0;1,5;2\n"),
        [(4, cells(["s", "V", ""])), (1, cells(["Rig 3", "", ""]))]
    );
    assert_eq!(above("s,\"V\",A\n// t,U,I\n0,1.5,2\n"), [(1, cells(["s", "V", "A"]))]);
    assert_eq!(above("t;U;I\n0;1,5;2\n"), []);
}

/// A file that was continued after a restart, with and without the lines before its header; the numbers of the lines remain.
#[test]
fn a_repeated_header_is_skipped() {
    let (table, rows) = found("t;U;I\n0;1;2\n\nt;U;I;\n1;1;2\n");
    assert_eq!((table.repeated(), rows.iter().map(|r| r.0).collect::<Vec<_>>()), (&[4][..], vec![2, 5]));
    let (table, rows) =
        found("Logger 7\r\nDate;3 May;;\r\nt;U;I\r\n0;1;2\r\nLogger 7\r\nDate;4 May;;\r\nt;U;I\r\n1;1;2\r\n");
    assert_eq!((table.repeated(), rows.iter().map(|r| r.0).collect::<Vec<_>>()), (&[7][..], vec![4, 8]));
    // The rows before a header that is repeated without the lines before it stay.
    let (_, rows) = found("Logger 7\nDate;3 May;;\nt;U;I\n0;1;2\n1;1;2\nt;U;I\n2;1;2\n");
    assert_eq!(rows.iter().map(|r| r.0).collect::<Vec<_>>(), [4, 5, 7]);
}

/// What a logger leaves whose supply failed; other NUL bytes are refused in their line.
#[test]
fn nul_bytes_at_the_end_are_skipped() {
    for (tail, rows, words) in [
        ("\0\0\0", 2, "of the file are skipped"),
        ("2;1;\0\0\n", 2, "incomplete row before them are skipped"),
        ("\0\r\n\0", 2, "NUL"),
    ] {
        let (table, read) = found(&format!("t;U;I\n0;1;2\n1;1;2\n{tail}"));
        let remark = &table.remarks()[0];
        assert_eq!((read.len(), remark.line), (rows, 4));
        assert!(remark.message.contains(words), "{}", remark.message);
    }
    let names = [vec!["t"], vec!["U"]];
    let fault = |text: &[u8]| Table::with_names(text, &names).unwrap_err();
    assert_eq!(fault(b"t;U\n0;1\n\0\0\n2;1\n").line, 3);
    assert!(fault(b"t;U\n0;1\n\0\0\n2;1\n").message.contains("NUL bytes"));
    for text in [&b"PK\x03\x04\0\0"[..], b"PK\x03\x04\n\0\0", b"t\0;\0U\0\n\0"] {
        assert!(fault(text).message.contains("not text"));
    }
    assert_eq!(Table::parse(b"t;U\n0;1\n\0\0").unwrap_err().line, 3);
}

/// Decimal commas in quotation marks, if the numbers leave no doubt.
#[test]
fn quoted_decimal_commas() {
    let read = |text: &str| Table::parse(text.as_bytes()).unwrap().pointed("1,5").into_owned();
    assert_eq!(read("t,U\n\"0,0\",\"1,25\"\n2,\"7,432\"\n"), "1.5");
    // Thousands separators as possible; decimal points beside them; no quotation marks.
    for text in ["t,U\n0,\"1,432\"\n", "t,U\n0.5,\"1,25\"\n", "t,U\n1,\"1,432.5\"\n", "t,U\n1,2\n"] {
        assert_eq!(read(text), "1,5", "{text}");
    }
    let table = Table::parse(b"t,U\n0,\"1,432\"\n").unwrap();
    assert!(table.notation("1,432").unwrap().contains("thousands separator"));
    assert!(table.notation("1,5").unwrap().contains("decimal comma"));
    assert_eq!(table.notation("OL"), None);
}

/// Ends of lines of old Macs.
#[test]
fn lines_may_end_with_a_carriage_return() {
    let (table, rows) = found("device\rt;U;I\r0;1;2\r1;1;2\r");
    assert_eq!((table.header_line(), rows.len(), rows[1].0), (2, 2, 4));
}
