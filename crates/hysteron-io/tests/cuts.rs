//! Parts of files: cut by time, values and texts; renamed; columns left out; written and read again.
#![allow(clippy::unwrap_used, clippy::panic)]

use hysteron_io::{
    IoError, ReadOptions, read_input_output_bytes, read_part, read_record_bytes, write_record,
};
use hysteron_model::record::{Channel, Cut, Record, RecordError, TimeBase};

const SEGMENTS: &str = "t_s,u_V,y_um,mode,segment\n\
    0,0,10,rest,0\n0.1,1,NaN,rest,0\n0.2,2,12,ramp,1\n\
    0.3,3,13,ramp,1\n0.4,,14,ramp,1\n0.5,5,15,hold,2\n0.6,6,16,hold,2\n";

fn cut(conditions: &[&str]) -> Cut {
    Cut { conditions: conditions.iter().map(|text| text.parse().unwrap()).collect(), ..Cut::default() }
}

fn read(text: &str, cut: Cut, leave_out: &[&str]) -> Result<Record, IoError> {
    let leave_out = leave_out.iter().map(|&name| name.to_owned()).collect();
    read_record_bytes("r.csv", text.as_bytes(), &ReadOptions { cut, leave_out, ..ReadOptions::default() })
}

fn refused(text: &str, cut: Cut, leave_out: &[&str]) -> String {
    read(text, cut, leave_out).unwrap_err().to_string()
}

#[test]
fn a_text_is_asked_of_a_column_of_texts_which_then_is_no_channel() {
    let record = read(SEGMENTS, cut(&["mode=hold"]), &[]).unwrap();
    let names: Vec<&str> = record.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["u", "y", "segment"]);
    assert_eq!(record.channels[0].samples, [5.0, 6.0]);
    assert_eq!(record.time.time_s(0), Some(0.5));
    let text = refused(SEGMENTS, cut(&["mode=pause"]), &[]);
    assert!(text.contains("0 of 7 samples") && text.contains("`rest`, `ramp`, `hold` in `mode`"), "{text}");
    let text = refused(SEGMENTS, cut(&["mode=hold", "mode=ramp"]), &[]);
    assert!(text.contains("0 of 7 samples"), "{text}");
    // A column of numbers in which one asks for a text.
    let text = refused("t_s,u_V,segment\n0,1,2\n1,2,3\n", cut(&["segment=ramp"]), &[]);
    assert!(text.contains("`2`, `3` in `segment`"), "{text}");
}

#[test]
fn what_is_not_kept_may_be_missing_and_what_is_kept_is_named_with_its_line() {
    let record = read(SEGMENTS, cut(&["segment=2"]), &["mode"]).unwrap();
    assert_eq!((record.len(), record.channels.len()), (2, 3));
    let by_time = Cut { from_s: Some(0.2), to_s: Some(0.3), ..Cut::default() };
    assert_eq!(read(SEGMENTS, by_time, &["mode"]).unwrap().channels[1].samples, [12.0, 13.0]);
    let text = refused(SEGMENTS, cut(&["segment=0"]), &["mode"]);
    assert!(text.contains("line 3, column 3 (`y_um`)"), "{text}");
    // Behind a cut by texts, lines are still those of the file.
    let text = refused(SEGMENTS, cut(&["mode=ramp"]), &[]);
    assert!(text.contains("line 6, column 2 (`u_V`)"), "{text}");
    // Without a cut, nothing may be missing.
    assert!(refused(SEGMENTS, Cut::default(), &["mode"]).contains("line 3, column 3"));
    assert!(refused(SEGMENTS, Cut::default(), &[]).contains("found `rest`, expected a number"));
}

#[test]
fn a_condition_may_ask_for_a_column_that_is_neither_input_nor_output() {
    let options = ReadOptions {
        input: Some("u".into()),
        output: Some("y".into()),
        cut: cut(&["5=2"]),
        ..ReadOptions::default()
    };
    let outcome = read_input_output_bytes("r.csv", SEGMENTS.as_bytes(), &options).unwrap();
    assert_eq!((outcome.data.u, outcome.data.y), (vec![5.0, 6.0], vec![15.0, 16.0]));
    let error = read(SEGMENTS, cut(&["speed=2"]), &["mode"]).unwrap_err();
    assert!(matches!(error, IoError::NoSuchColumn { .. }), "{error}");
    assert!(error.to_string().contains("`u_V`, `y_um`, `mode`, `segment`"), "{error}");
}

#[test]
fn turns_are_those_of_the_chosen_input() {
    let text = "t_s,u1_V,u2_V,y_um\n0,0,5,0\n1,1,5,1\n2,2,4,2\n3,1,3,1\n4,0,4,0\n5,1,5,1\n";
    let turns = Cut { turns: Some("1:2".parse().unwrap()), ..Cut::default() };
    let of = |input: &str| {
        let options = ReadOptions { input: Some(input.into()), cut: turns.clone(), ..ReadOptions::default() };
        read_record_bytes("r.csv", text.as_bytes(), &options).map(|r| r.time.time_s(0).unwrap())
    };
    assert_eq!(of("u1").unwrap(), 2.0);
    assert!(of("u2").unwrap_err().to_string().contains("`u2` turns 1 times"));
    assert!(refused(text, turns, &[]).contains("`u1` (V), `u2` (V)"));
}

#[test]
fn a_record_is_written_in_the_format_of_its_name_and_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let times = vec![0.0, 0.1, 0.2, 0.7];
    let channels = vec![
        Channel::new("u", "V", vec![0.1, 1e-9, -0.0, 1e20]),
        Channel::new("speed [x]", "counts", vec![1.0, 2.0, 3.0, 4.0]),
    ];
    let time = TimeBase::from_times("r", times).unwrap();
    let record =
        Record { valid: Some(vec![true, false, true, true]), ..Record::new("r", time, channels).unwrap() };
    for name in ["out.csv", "out.npz", "out.NPZ"] {
        let path = folder.path().join(name);
        write_record(&path, &record).unwrap();
        let back = read_part(&path, &ReadOptions::default()).unwrap();
        assert_eq!((&back.record.channels, &back.record.time), (&record.channels, &record.time), "{name}");
        assert_eq!((&back.record.valid, back.file_samples), (&record.valid, 4), "{name}");
    }
    let read_bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read_bytes("out.npz"), read_bytes("out.NPZ"));
    // The columns of an archive are numbers, whatever is asked of them.
    let options = ReadOptions { cut: cut(&["u=ramp"]), ..ReadOptions::default() };
    let text = read_part(&folder.path().join("out.npz"), &options).unwrap_err().to_string();
    assert!(text.contains("array `u_V`") && text.contains("`ramp`"), "{text}");
    let part = ReadOptions { cut: Cut { to_s: Some(0.1), ..Cut::default() }, ..ReadOptions::default() };
    let part = read_part(&folder.path().join("out.npz"), &part).unwrap();
    assert_eq!((part.record.len(), part.file_samples), (2, 4));

    // Text under the name of a format that is not written would not be read back.
    let error = write_record(&folder.path().join("out.H5"), &record).unwrap_err();
    assert!(error.to_string().ends_with("no .h5 is written; use .csv, .npz or .mat"), "{error}");
    assert!(!folder.path().join("out.H5").exists());
    let odd = vec![Channel::new("u", "V\u{1b}[31m", vec![0.0; 4])];
    let error = write_record(&folder.path().join("odd.csv"), &Record { channels: odd, ..record.clone() });
    assert!(error.unwrap_err().to_string().contains("the unit of channel `u` has control characters"));

    let twice = Record { channels: vec![Channel::new("t", "s", vec![0.0; 4])], ..record };
    let path = folder.path().join("twice.csv");
    let error = write_record(&path, &twice).unwrap_err();
    assert!(
        matches!(&error, IoError::Record { source, .. }
            if matches!(**source, RecordError::DuplicateChannel { .. })),
        "{error}"
    );
    assert!(!path.exists());
}
