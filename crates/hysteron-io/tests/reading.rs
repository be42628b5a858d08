//! What is accepted, and what it becomes.
#![allow(clippy::unwrap_used, clippy::panic)]

use hysteron_io::{ReadOptions, read_input_output_bytes, read_record_bytes, write_csv_to};
use hysteron_model::record::{Record, TimeBase};

fn read(text: &str) -> Record {
    read_with(text, &ReadOptions::default())
}

fn read_with(text: &str, options: &ReadOptions) -> Record {
    read_record_bytes("bench.csv", text.as_bytes(), options).unwrap()
}

fn rate(record: &Record) -> f64 {
    match record.time {
        TimeBase::Uniform { sample_rate_hz, .. } => sample_rate_hz,
        ref other => panic!("not uniform: {other:?}"),
    }
}

/// Other formats have channels that are called by a number; their names are written in quotes.
#[test]
fn names_that_are_numbers_are_names_in_quotes() {
    let record = read("\"1\",\"2\"\n0,1\n0.5,3\n");
    assert_eq!(record.channel("2").unwrap().samples, [1.0, 3.0]);
    let mut text = Vec::new();
    write_csv_to(&mut text, &record).unwrap();
    assert_eq!(read(std::str::from_utf8(&text).unwrap()).channels, record.channels);
    for no_names in ["1,2\n0,1\n0.5,3\n", "\"1\",\"2\"\n\"0\",\"1\"\n", "\"1\",\"2\"\n"] {
        let refused = read_record_bytes("bench.csv", no_names.as_bytes(), &ReadOptions::default());
        assert!(refused.unwrap_err().to_string().contains("column names should be"), "{no_names}");
    }
}

#[test]
fn the_ordinary_file() {
    let record = read("t_s,u_V,y_um\n0,1,-2.5\n0.005,1.5,3e-3\n0.01,.5,+4.\n");
    assert_eq!(record.name, "bench.csv");
    assert_eq!(rate(&record), 200.0);
    assert_eq!(record.channel("u").unwrap().samples, [1.0, 1.5, 0.5]);
    assert_eq!(record.channel("y_um").unwrap().samples, [-2.5, 3e-3, 4.0]);
    assert_eq!(record.valid, None);
}

#[test]
fn the_hash_is_that_of_the_files_bytes() {
    let record = read("u,y\n1,2\n3,4\n");
    // printf 'u,y\n1,2\n3,4\n' | sha256sum
    assert_eq!(
        record.source.unwrap().sha256,
        "335f9b65ceaf34e751c6d8a3b3eb66e9d8f2da22e96c1ca7ee8722c1b3c9b296"
    );
}

#[test]
fn every_dialect_reads_as_the_same_numbers() {
    let plain = read("t_s,u_V,y_um\n0,1.5,2\n1,2.5,3\n2,3.5,4.25\n");
    for text in [
        "\u{feff}t_s,u_V,y_um\r\n0,1.5,2\r\n1,2.5,3\r\n2,3.5,4.25\r\n",
        "t_s;u_V;y_um\n0;1,5;2\n1;2,5;3\n2;3,5;4,25",
        "t_s\tu_V\ty_um\n0\t1.5\t2\n1\t2.5\t3\n2\t3.5\t4.25\n",
        "t_s\tu_V\ty_um\n0\t1,5\t2\n1\t2,5\t3\n2\t3,5\t4,25\n",
        "\"t_s\",\"u_V\",\"y_um\"\n\"0\",\"1.5\",2\n1,2.5,3\n2,3.5,4.25\n",
        "\"t_s\",\"u_V\",\"y_um\"\n0,\"1,5\",2\n1,\"2,5\",3\n2,\"3,5\",\"4,25\"\n",
        "# logger 7\n%x\nt_s, u_V, y_um\n\n0, 1.5, 2\n# pause\n1, 2.5, 3\n % end\n2, 3.5, 4.25\n\n",
        "# t_s,u_V,y_um\n0,1.5,2\n1,2.5,3\n2,3.5,4.25\n",
        "sep=;\nt_s;u_V;y_um\n0;1.5;2\n1;2.5;3\n2;3.5;4.25\n",
        "t_s,u_V,y_um,\n0,1.5,2,\n1,2.5,3,\n2,3.5,4.25,\n",
        "t_s,u_V,y_um\n0,1.5,2,\n1,2.5,3,\n2,3.5,4.25,\n",
        "t_ms,u [V],y (µm)\n0,1.5,2\n1000,2.5,3\n2000,3.5,4.25\n",
        "time,u_V,y_um\n0,1.5,2\n1,2.5,3\n2,3.5,4.25\n",
    ] {
        let record = read(text);
        assert_eq!((&record.channels[1..], &record.time), (&plain.channels[1..], &plain.time), "{text}");
        assert_eq!(record.channels[0].samples, plain.channels[0].samples, "{text}");
    }
}

#[test]
fn milliseconds_and_microseconds_become_seconds() {
    assert_eq!(rate(&read("t_ms,u\n0,1\n0.1,2\n0.2,3\n")), 10_000.0);
    assert_eq!(rate(&read("time_us,u\n0,1\n100,2\n200,3\n")), 10_000.0);
}

#[test]
fn a_valid_column_is_the_mask() {
    let record = read("t_s,u_V,valid\n0,1,1\n1,2,0\n2,3,1\n");
    assert_eq!(record.valid, Some(vec![true, false, true]));
    assert_eq!(record.channels.len(), 1);
}

#[test]
fn without_a_time_column_the_rate_is_unknown_unless_given() {
    assert_eq!(read("u,y\n1,2\n3,4\n").time, TimeBase::Unknown);
    let options = ReadOptions { sample_rate_hz: Some(1000.0), ..ReadOptions::default() };
    assert_eq!(read_with("u,y\n1,2\n3,4\n", &options).time, TimeBase::uniform(1000.0));
}

#[test]
fn columns_are_chosen_by_name_by_header_and_by_number() {
    let text = "clock_ms,a_V,b_V,x_nm,z_nm\n0,1,2,3000,5\n1,2,3,4000,6\n2,3,4,5000,7\n";
    for (time, input, output) in
        [("clock", "b", "x"), ("clock_ms", "b_V", "x_nm"), ("1", "3", "4"), ("1", "B_v", "4")]
    {
        let options = ReadOptions {
            time: Some(time.to_string()),
            input: Some(input.to_string()),
            output: Some(output.to_string()),
            ..ReadOptions::default()
        };
        let outcome = read_input_output_bytes("bench.csv", text.as_bytes(), &options).unwrap();
        assert_eq!((outcome.data.input.as_str(), outcome.data.output.as_str()), ("b", "x"));
        assert_eq!(outcome.data.u, [2.0, 3.0, 4.0]);
        assert_eq!(outcome.data.y, [3.0, 4.0, 5.0]);
        assert_eq!(outcome.data.sample_rate_hz(), Some(1000.0));
        assert!(outcome.notes.is_empty(), "{:?}", outcome.notes);
    }
}

#[test]
fn columns_that_are_not_chosen_may_hold_text() {
    let text = "t_s,u_V,y_um,comment\n0,1,2,start\n1,2,3,\n";
    let options =
        ReadOptions { input: Some("u".to_string()), output: Some("y".to_string()), ..ReadOptions::default() };
    assert_eq!(read_with(text, &options).channels.len(), 2);
}

#[test]
fn a_command_is_preferred_to_its_measurement_and_the_notes_say_so() {
    let text = b"t_s,u_cmd_V,u_meas_V,y_um\n0,1,2,3\n1,2,3,4\n2,3,4,5\n";
    let outcome = read_input_output_bytes("bench.csv", text, &ReadOptions::default()).unwrap();
    assert_eq!(outcome.data.input, "u_cmd");
    assert!(outcome.notes[0].text.contains("u_meas"), "{:?}", outcome.notes);
}
