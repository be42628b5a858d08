//! Every file that is no record is refused with a message that says where, what was found and what to do.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use hysteron_io::{IoError, ReadOptions, read_input_output_bytes, read_record_bytes};

/// The message, and the advice for a front end to word.
fn refused_with(bytes: &[u8], options: &ReadOptions) -> String {
    match read_record_bytes("bench.csv", bytes, options) {
        Ok(record) => panic!("accepted: {record:?}"),
        Err(err) => format!("{err} [{:?}]", err.advice()),
    }
}

/// Reads the text, which must be refused with a message that has all the parts.
fn refused(text: &str, parts: &[&str]) {
    let message = refused_with(text.as_bytes(), &ReadOptions::default());
    for part in parts.iter().chain(&["bench.csv"]) {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

#[test]
fn an_empty_file() {
    refused("", &["empty", "t_s,u_V,y_um"]);
    refused("\n\n# only a comment\n", &["no data, only comments"]);
    refused("\u{feff}", &["empty"]);
}

#[test]
fn a_header_without_samples() {
    refused("t_s,u_V,y_um\n", &["line 1", "no samples"]);
    refused("# made by x\nt_s,u_V,y_um\n\n", &["line 2", "no samples"]);
}

#[test]
fn one_sample() {
    refused("t_s,u_V,y_um\n0,1,2\n", &["one sample", "line 2", "at least 2"]);
}

#[test]
fn a_truncated_last_line() {
    refused(
        "t_s,u_V,y_um\n0,1,2\n1,2,3\n2,3",
        &["line 4", "cut off after 2 of 3 fields", "Delete that line"],
    );
    refused("t_s,u_V,y_um\n0,1,2\n1,2,3\n2,3,", &["line 4", "cut off after 2 of 3 fields"]);
    refused(
        "t_s,u_V,y_um\n0,1,2\n1,2,3\n2,3,4e-",
        &["line 4, column 3", "`4e-`", "the file ends in this line"],
    );
}

#[test]
fn nan_and_infinity() {
    for bad in ["NaN", "nan", "inf", "-Inf", "1e999"] {
        refused(
            &format!("t_s,u_V,y_um\n0,1,2\n1,2,{bad}\n2,3,4\n"),
            &["line 3, column 3 (`y_um`)", bad, "not a finite number"],
        );
    }
}

#[test]
fn text_in_a_number_column() {
    refused(
        "t_s,u_V,y_um\n0,1,2\n1,2,overload\n",
        &["line 3, column 3 (`y_um`)", "found `overload`", "expected a number"],
    );
    refused("t_s,u_V,y_um\ns,V,mm\n0,1,2\n", &["line 2, column 1 (`t_s`)", "second header line"]);
    refused("t_s,u_V,y_um\n0,1,2\n#NUM!,2,3\n", &["line 3, column 1 (`t_s`)", "#NUM!", "spreadsheet"]);
    refused("t_s;u_V\n0;1\n1;1.234,5\n", &["line 3, column 2 (`u_V`)", "1.234,5", "thousands separators"]);
    refused("t_s,u_V,y_um\n0,1,2\n1,,3\n", &["line 3, column 2 (`u_V`)", "empty"]);
}

#[test]
fn long_garbage_is_quoted_only_in_part() {
    let long = "x".repeat(5000);
    let message = refused_with(format!("t_s,u_V\n0,1\n1,{long}\n").as_bytes(), &ReadOptions::default());
    assert!(message.contains("xxx…`") && message.len() < 300, "{message}");
}

#[test]
fn decimal_commas_in_a_comma_separated_file() {
    refused(
        "t_s,u_V,y_um\n0,1,5,2,5\n1,2,5,3,5\n",
        &["line 2", "5 fields where the header has 3", "decimal commas", "semicolons"],
    );
    // A cell too many beside decimal points is no decimal comma.
    refused(
        "t_s,u_V,y_um\n0,1.5,2.5\n1,2,3,4\n",
        &["line 3: 4 fields where the header (line 1) has 3", "remove the surplus"],
    );
}

#[test]
fn two_decimal_marks_in_one_file() {
    refused(
        "t_s;u_V\n0,5;1,5\n1.5;2\n",
        &["line 3, column 1 (`t_s`)", "`1.5`", "decimal comma of line 2", "thousands"],
    );
    refused("t_s;u_V\n0.5;1\n1;2,5\n", &["line 3, column 2 (`u_V`)", "`2,5`", "decimal point of line 2"]);
}

#[test]
fn a_missing_header() {
    refused("0,1,2\n1,2,3\n", &["line 1", "3 number(s)", "`t_s,u_V,y_um`", "add a header line"]);
    refused("0;1,5\n1;2,5\n", &["line 1", "2 number(s)", "`u_V;y_um`"]);
    refused("# logger\n0.0,1\n1,2\n", &["line 2", "`u_V,y_um`"]);
}

#[test]
fn ragged_rows() {
    refused(
        "t_s,u_V,y_um\n0,1,2\n1,2\n2,3,4\n",
        &["line 3", "2 fields where the header (line 1) has 3", "complete or delete"],
    );
    refused("t_s,u_V\n0,1\n1,2,3,4,5\n", &["line 3", "5 fields", "has 2", "surplus"]);
    refused("t_s,u_V\n0;1\n1;2\n", &["line 2", "1 fields", "another delimiter"]);
}

#[test]
fn duplicate_and_unnamed_columns() {
    refused("t_s,u_V,u_V\n0,1,2\n1,2,3\n", &["line 1", "columns 2 and 3", "`u_V`", "rename"]);
    refused("t_s,,u_V\n0,1,2\n1,2,3\n", &["line 1, column 2", "no column name"]);
}

#[test]
fn time_that_runs_backwards_or_stands_still() {
    refused(
        "t_ms,u_V\n0,1\n1000,2\n# reset\n500,3\n",
        &["line 5, column 1 (`t_ms`)", "0.5 s after 1 s", "clock was reset"],
    );
    refused("t_s,u_V\n3,1\n3,2\n3,3\n", &["3 time stamps are 3 s", "sample rate"]);
    refused("time,t,u_V\n0,0,1\n1,1,2\n", &["line 1", "`time`, `t`", "role: Time"]);
}

#[test]
fn wrong_units() {
    let default = ReadOptions::default();
    let message = read_input_output_bytes("bench.csv", b"t_s,u_V,y_ms\n0,1,2\n1,2,3\n", &default)
        .unwrap_err()
        .to_string();
    for part in ["bench.csv", "`y_ms`", "in ms", "expected a length"] {
        assert!(message.contains(part), "{message}");
    }
    let options = ReadOptions { time: Some("u".to_string()), ..ReadOptions::default() };
    let message = refused_with(b"t_s,u_V,y_um\n0,1,2\n1,2,3\n", &options);
    assert!(message.contains("`u_V` cannot be the time") && message.contains("in V"), "{message}");
    let swapped = read_input_output_bytes("bench.csv", b"t_s,u_um,y_V\n0,1,2\n1,2,3\n", &default).unwrap();
    assert!(swapped.notes[0].text.contains("swapped"), "{:?}", swapped.notes);
}

#[test]
fn a_sample_rate_that_is_impossible_or_contradicts_the_time_column() {
    let at = |rate| ReadOptions { sample_rate_hz: Some(rate), ..ReadOptions::default() };
    let message = refused_with(b"u_V,y_um\n1,2\n2,3\n", &at(0.0));
    assert!(message.contains("bench.csv") && message.contains("0 Hz"), "{message}");
    let message = refused_with(b"t_s,u_V\n0,1\n0.01,2\n0.02,3\n", &at(1000.0));
    assert!(message.contains("1000 Hz") && message.contains("100 Hz"), "{message}");
}

#[test]
fn columns_that_are_not_there() {
    let text = b"t_s,u1_V,u2_V,y_um\n0,1,2,3\n1,2,3,4\n";
    for (options, parts) in [
        (
            ReadOptions { input: Some("v".into()), ..ReadOptions::default() },
            ["no column `v`", "role: Input", "`u1_V`, `u2_V`"],
        ),
        (
            ReadOptions { output: Some("9".into()), ..ReadOptions::default() },
            ["no column `9`", "role: Output", "`y_um`"],
        ),
        (
            ReadOptions { time: Some("clock".into()), ..ReadOptions::default() },
            ["no column `clock`", "role: Time", "`t_s`"],
        ),
    ] {
        let message = refused_with(text, &options);
        for part in parts {
            assert!(message.contains(part), "{message}");
        }
    }
    let message = refused_with(
        b"t_s,u_V,u_mV\n0,1,2\n1,2,3\n",
        &ReadOptions { input: Some("u".into()), ..ReadOptions::default() },
    );
    assert!(message.contains("`u_V`, `u_mV`") && message.contains("its unit"), "{message}");
}

#[test]
fn mask_values_other_than_zero_and_one() {
    refused("t_s,u_V,valid\n0,1,1\n1,2,2\n", &["line 3, column 3 (`valid`)", "`2`", "expected 0"]);
}

#[test]
fn files_that_are_no_records_in_time() {
    refused("f_Hz,G_re,G_im\n1,2,3\n2,3,4\n", &["line 1", "`f_Hz`", "frequency response"]);
    refused("t_s,valid\n0,1\n1,1\n", &["line 1", "no channel besides `t_s`, `valid`"]);
    refused("u_V|y_um\n1|2\n2|3\n", &["line 2, column 1", "`1|2`"]);
    let message =
        read_input_output_bytes("fringe.csv", b"t_s,photodiode_V\n0,1\n1,2\n", &ReadOptions::default())
            .unwrap_err()
            .to_string();
    assert!(
        message.contains("fringe.csv")
            && message.contains("only one channel")
            && message.contains("photodiode"),
        "{message}"
    );
}

#[test]
fn bytes_that_are_not_text() {
    let default = ReadOptions::default();
    let message = refused_with(b"t_s,u_V,y_\xB5m\n0,1,2\n1,2,3\n", &default);
    assert!(
        message.contains("line 1, column 3") && message.contains("0xB5") && message.contains("UTF-8"),
        "{message}"
    );
    let message = refused_with(b"t_s,u_V\n0,1\n1,\xFF\n", &default);
    assert!(message.contains("line 3, column 2") && message.contains("0xFF"), "{message}");
    let message = refused_with(b"\xFF\xFEt\0_\0s\0\n\0", &default);
    assert!(message.contains("UTF-16"), "{message}");
    let message = refused_with(b"t_s,u\rV\n0,1\n1,2\n", &default);
    assert!(message.contains("carriage return"), "{message}");
}

#[test]
fn quotes_that_are_not_closed() {
    refused("t_s,\"u_V\n0,1\n", &["line 1, column 2", "not closed"]);
    refused("t_s,u_V\n0,1\n\"1,2\n", &["line 3, column 1", "not closed"]);
}

#[test]
fn huge_files_lines_and_tables_stop_at_a_limit() {
    let mut text = String::from("t_s,u_V\n");
    for k in 0..10_000 {
        text.push_str(&format!("{k},1\n"));
    }
    let message = refused_with(text.as_bytes(), &ReadOptions { max_bytes: 1000, ..ReadOptions::default() });
    assert!(message.contains("larger than 1000 bytes") && message.contains("line "), "{message}");
    let exact = ReadOptions { max_bytes: text.len() as u64, ..ReadOptions::default() };
    assert!(read_record_bytes("bench.csv", text.as_bytes(), &exact).is_ok());
    let message = refused_with(text.as_bytes(), &ReadOptions { max_values: 100, ..ReadOptions::default() });
    assert!(message.contains("line 52") && message.contains("more than 100 numbers"), "{message}");
    let message = refused_with(&vec![b'x'; 1 << 20], &ReadOptions::default());
    assert!(message.contains("line 1: longer than 262144 bytes"), "{message}");
    let wide = (0..2000).map(|k| format!("c{k}")).collect::<Vec<_>>().join(",");
    let message = refused_with(format!("{wide}\n").as_bytes(), &ReadOptions::default());
    assert!(message.contains("2000 columns"), "{message}");
}

/// A source without end must not fill the memory: reading stops at the byte limit.
#[test]
fn an_endless_file_is_refused_at_the_limit() {
    let options = ReadOptions { max_bytes: 1 << 20, ..ReadOptions::default() };
    let endless = std::path::Path::new("/dev/zero");
    if !endless.exists() {
        println!("skipped: no /dev/zero here");
        return;
    }
    let err = hysteron_io::read_record(endless, &options).unwrap_err();
    assert!(matches!(err, IoError::LineTooLong { .. }), "{err}");
}

#[test]
fn a_missing_file_and_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().join("no.csv"), folder.path().to_path_buf()] {
        let err = hysteron_io::read_record(&path, &ReadOptions::default()).unwrap_err();
        assert!(matches!(err, IoError::Open { .. }), "{err}");
        assert!(err.to_string().contains(&path.display().to_string()), "{err}");
    }
}
