//! MAT files: the numbers that SciPy reads, what is refused, what is written, and that no damage makes the
//! reader panic.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;
mod oracle;

use hysteron_io::{
    IoError, ReadOptions, ResponseOptions, contents_of_bytes, read_frequency_response_bytes,
    read_input_output_bytes, read_record, read_record_bytes, write_mat,
};
use hysteron_model::record::{Channel, Record, TimeBase};
use std::io::Write;
use std::process::Command;

/// An element: type, length, bytes, and zeros up to a multiple of eight.
fn element(kind: u32, data: &[u8], big_endian: bool) -> Vec<u8> {
    let word = |word: u32| if big_endian { word.to_be_bytes() } else { word.to_le_bytes() };
    let mut bytes = [word(kind), word(data.len() as u32)].concat();
    bytes.extend(data);
    if kind != 15 {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
    }
    bytes
}

/// A column of doubles that is stored in bytes, as MATLAB does where they fit.
fn narrow(name: &str, values: &[u8], class: u32, big_endian: bool) -> Vec<u8> {
    let word = |word: u32| if big_endian { word.to_be_bytes() } else { word.to_le_bytes() };
    let parts = [
        element(6, &[word(class), word(0)].concat(), big_endian),
        element(5, &[word(values.len() as u32), word(1)].concat(), big_endian),
        element(1, name.as_bytes(), big_endian),
        element(2, values, big_endian),
    ];
    element(14, &parts.concat(), big_endian)
}

fn file(variables: &[Vec<u8>], big_endian: bool) -> Vec<u8> {
    let mut bytes = vec![b' '; 124];
    bytes.extend(if big_endian { [1, 0, b'M', b'I'] } else { [0, 1, b'I', b'M'] });
    bytes.extend(variables.concat());
    bytes
}

fn run(big_endian: bool) -> Vec<u8> {
    let columns = [("t_s", [0, 1, 2, 3]), ("u_V", [0, 5, 200, 3]), ("y_um", [7, 9, 0, 1])];
    file(&columns.map(|(name, values)| narrow(name, &values, 6, big_endian)), big_endian)
}

fn deflated(data: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn the_values_are_those_that_scipy_reads() {
    let Some((_folder, cases)) = oracle::written_by("mat.py") else { return };
    assert!(cases.len() >= 70, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 2 * cases.len());
    eprintln!("{} files", cases.len());
}

#[test]
fn narrow_doubles_of_either_byte_order_need_no_choice() {
    for big_endian in [false, true] {
        let data =
            read_input_output_bytes("run.mat", &run(big_endian), &ReadOptions::default()).unwrap().data;
        assert_eq!((data.u, data.y), (vec![0.0, 5.0, 200.0, 3.0], vec![7.0, 9.0, 0.0, 1.0]));
        assert_eq!(data.time.samples_of(1.0), Some(1));
    }
}

#[test]
fn what_is_no_array_of_numbers_is_listed_and_refused_by_name() {
    let function = narrow("f", &[], 16, false);
    let sparse = narrow("s", &[1], 5, false);
    let bytes = [run(false), function, sparse].concat();
    let held = contents_of_bytes("run.mat", &bytes, &ReadOptions::default()).unwrap();
    let kind = |path: &str| held.iter().find(|content| content.path == path).unwrap().kind.clone();
    assert_eq!(
        (kind("f"), kind("s"), kind("u_V")),
        ("function".into(), "sparse matrix".into(), "numbers".into())
    );
    assert_eq!(read_record_bytes("run.mat", &bytes, &ReadOptions::default()).unwrap().channels.len(), 2);
    let options = ReadOptions { input: Some("s".into()), ..ReadOptions::default() };
    let refusal = read_record_bytes("run.mat", &bytes, &options).unwrap_err().to_string();
    assert!(refusal.contains("`s`") && refusal.contains("sparse matrix"), "{refusal}");
}

#[test]
fn a_text_is_no_column_whatever_its_length() {
    let word = |word: u32| word.to_le_bytes();
    let parts = [
        element(6, &[word(4), word(0)].concat(), false),
        element(5, &[word(1), word(4)].concat(), false),
        element(1, b"note", false),
        element(16, b"loop", false),
    ];
    let note = element(14, &parts.concat(), false);
    let record = read_record_bytes("run.mat", &[run(false), note].concat(), &ReadOptions::default()).unwrap();
    assert_eq!((record.len(), record.channels.len()), (4, 2));
}

#[test]
fn a_variable_that_unpacks_to_more_than_allowed_is_refused() {
    let zeros = vec![0; 4_000_000];
    let packed = element(15, &deflated(&narrow("u_V", &zeros, 6, false)), false);
    let bytes = file(&[packed], false);
    assert!(bytes.len() < 10_000);
    let options = ReadOptions { max_bytes: 1_000_000, ..ReadOptions::default() };
    let refusal = read_record_bytes("run.mat", &bytes, &options).unwrap_err();
    assert!(matches!(refusal, IoError::TooLarge { .. }), "{refusal}");
    let options = ReadOptions { sample_rate_hz: Some(1.0), ..ReadOptions::default() };
    assert_eq!(read_record_bytes("run.mat", &bytes, &options).unwrap().len(), 4_000_000);
}

/// A structure of one element.
fn structure(name: &str, fields: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let word = |word: u32| word.to_le_bytes();
    let names: Vec<u8> = fields.iter().flat_map(|(name, _)| padded(name)).collect();
    let parts = [
        element(6, &[word(2), word(0)].concat(), false),
        element(5, &[word(1), word(1)].concat(), false),
        element(1, name.as_bytes(), false),
        element(5, &word(8), false),
        element(1, &names, false),
        fields.iter().flat_map(|(_, field)| field.clone()).collect(),
    ];
    element(14, &parts.concat(), false)
}

/// A name of a field, with zeros up to eight bytes.
fn padded(name: &str) -> [u8; 8] {
    let mut bytes = [0; 8];
    bytes[..name.len()].copy_from_slice(name.as_bytes());
    bytes
}

#[test]
fn a_small_file_of_a_huge_array_is_refused_with_what_to_raise() {
    let packed = |variable: Vec<u8>| file(&[element(15, &deflated(&variable), false)], false);
    let zeros = packed(narrow("u_V", &vec![0; 300 << 20], 9, false));
    let many = packed(narrow("u_V", &vec![0; 100 << 20], 9, false));
    for bytes in [zeros, many] {
        assert!(bytes.len() < 1 << 20);
        let refusal = read_record_bytes("run.mat", &bytes, &ReadOptions::default()).unwrap_err();
        assert!(matches!(refusal, IoError::TooLarge { limit_bytes: 0x1000_0000, .. }), "{refusal}");
        assert!(refusal.to_string().contains("raise the limit (`max_bytes`)"), "{refusal}");
    }
    let word = |word: u32| word.to_le_bytes();
    let head = |class| element(6, &[word(class), word(0)].concat(), false);
    let name = element(1, b"s", false);
    let long = vec![0; 8 << 20];
    let one = element(5, &[word(1), word(1)].concat(), false);
    let fields = [head(2), one.clone(), name.clone(), element(5, &word(1), false), element(1, &long, false)];
    let dimensions = [head(6), element(5, &long, false), name];
    let path = [head(6), one, element(1, &vec![b'u'; 8 << 20], false), element(9, &[0; 8], false)];
    for (parts, problem) in [
        (fields.concat(), "`s` has more than 65536 fields"),
        (dimensions.concat(), "more than 32 dimensions"),
        (path.concat(), "a path of more than 1024 bytes"),
    ] {
        let bytes = packed(element(14, &parts, false));
        let refusal = read_record_bytes("run.mat", &bytes, &ReadOptions::default()).unwrap_err().to_string();
        assert!(refusal.contains(problem), "{refusal}");
    }
}

/// Variables that hold as many numbers as said.
fn variables(of: &[(&str, u8)]) -> Vec<u8> {
    let counted = |&(name, count): &(&str, u8)| narrow(name, &(1..=count).collect::<Vec<u8>>(), 6, false);
    file(&of.iter().map(counted).collect::<Vec<_>>(), false)
}

#[test]
fn arrays_of_other_lengths_do_not_stand_in_the_way_of_a_record_that_is_named() {
    let read = |of: &[(&str, u8)]| {
        let outcome = read_input_output_bytes("run.mat", &variables(of), &ReadOptions::default());
        outcome.map(|outcome| (outcome.data.input, outcome.data.output, outcome.data.u.len()))
    };
    let run = Ok(("u".to_owned(), "y".to_owned(), 6));
    let clear: [&[(&str, u8)]; 5] = [
        &[("t_s", 6), ("u_V", 6), ("y_um", 6), ("noise", 9), ("spectrum", 3)],
        &[("f_Hz", 4), ("re", 4), ("im", 4), ("t_s", 6), ("u_V", 6), ("y_um", 6)],
        &[("raw_u_V", 9), ("t_s", 6), ("u_V", 6), ("y_um", 6), ("time_s", 9)],
        &[("t_s", 6), ("u_V", 6), ("y_um", 6), ("force_N", 6), ("u_ref", 2), ("fs", 1)],
        &[("u", 6), ("y", 6), ("window", 3)],
    ];
    for of in clear {
        assert_eq!(read(of).map_err(|e| e.to_string()), run, "{of:?}");
    }
    let unclear: [&[(&str, u8)]; 5] = [
        // Two records, none, an input alone, a time that only others have.
        &[("t_s", 6), ("u_V", 6), ("y_um", 6), ("u2_V", 9), ("y2_um", 9), ("time", 9)],
        &[("a", 6), ("b", 6), ("c", 9)],
        &[("t_s", 6), ("u_V", 6), ("y_um", 9)],
        &[("t_s", 5), ("u_V", 6), ("y_um", 6)],
        // Two inputs in the record.
        &[("t_s", 6), ("u1_V", 6), ("u2_V", 6), ("y_um", 6), ("window", 3)],
    ];
    for of in unclear {
        let refusal = read(of).unwrap_err();
        assert!(matches!(refusal, IoError::ChooseArrays { .. }), "{of:?}: {refusal}");
        let text = refusal.to_string();
        assert!(of.iter().all(|(name, _)| text.contains(&format!("`{name}` ("))), "{text}");
    }
}

#[test]
fn a_file_of_a_structure_without_fields_says_what_it_holds() {
    let options = ReadOptions::default();
    for length in [8u32, 0] {
        let mut bytes = file(&[structure("s", &[])], false);
        let at = bytes.len() - 16;
        bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
        let held = contents_of_bytes("run.mat", &bytes, &options).unwrap();
        assert_eq!((held[0].path.as_str(), held[0].kind.as_str()), ("s", "structure without fields"));
        let refusal = read_record_bytes("run.mat", &bytes, &options).unwrap_err().to_string();
        assert!(refusal.contains("the file holds `s` (1×1, structure without fields)"), "{refusal}");
    }
}

#[test]
fn of_frequency_responses_in_several_structures_one_must_be_chosen() {
    let response = |re: u8| {
        let column = |values: &[u8]| narrow("", values, 6, false);
        [("f_Hz", column(&[1, 2])), ("re", column(&[re, re])), ("im", column(&[0, 0]))]
    };
    let bytes = file(&[structure("a", &response(3)), structure("b", &response(5))], false);
    let read = |response: Option<&str>, over: Option<&str>| {
        let own = |name: &str| name.to_owned();
        let options = ResponseOptions { response: response.map(own), over: over.map(own), max_bytes: None };
        read_frequency_response_bytes("run.mat", &bytes, &options).map_err(|e| e.to_string())
    };
    let refusal = read(None, None).unwrap_err();
    assert!(refusal.contains("2 responses; the responses are `a`, `b`"), "{refusal}");
    assert_eq!(read(Some("b"), None).unwrap().values[0].re, 5.0);
    let refusal = read(Some("b"), Some("a")).unwrap_err();
    assert!(refusal.contains("`a` has frequencies of its own"), "{refusal}");
}

#[test]
fn a_record_reads_back_to_the_same_numbers_here_and_in_scipy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mat");
    let samples = |k: f64| (0..50).map(|i| (k * f64::from(i)).sin()).collect::<Vec<_>>();
    let channels = vec![Channel::new("u", "V", samples(0.1)), Channel::new("y", "um", samples(0.3))];
    let valid = Some((0..50).map(|k| k != 7).collect());
    let record = Record { valid, ..Record::new("run", TimeBase::uniform(250.0), channels).unwrap() };
    write_mat(&path, &record).unwrap();
    let again = read_record(&path, &ReadOptions::default()).unwrap();
    assert_eq!((&again.channels, &again.valid), (&record.channels, &record.valid));
    assert!(
        matches!(again.time, TimeBase::Uniform { start_s: 0.0, sample_rate_hz: 250.0, .. }),
        "{:?}",
        again.time
    );
    let script = "import sys, scipy.io as s; m = s.loadmat(sys.argv[1]); print(m['u_V'].ravel().tolist(), \
                  m['valid'].dtype, m['t_s'].shape)";
    let python = std::env::var("HYSTERON_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    match Command::new(python).args(["-c", script]).arg(&path).output() {
        Ok(told) if told.status.success() => {
            let expected = format!("{:?} uint8 (50, 1)\n", record.channels[0].samples);
            let bool_expected = expected.replace("uint8", "bool");
            let told = String::from_utf8_lossy(&told.stdout).replace("-0.0,", "0.0,");
            assert!(told == expected || told == bool_expected, "{told}");
        }
        _ => eprintln!("skipped: scipy is not installed"),
    }
    let spaced =
        Record::new("run", TimeBase::Unknown, vec![Channel::new("u out", "V", vec![0.0, 1.0])]).unwrap();
    let refusal = write_mat(&path, &spaced).unwrap_err().to_string();
    assert!(refusal.contains("no name of a variable"), "{refusal}");
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let packed = file(&[element(15, &deflated(&narrow("u_V", &[1, 2, 3, 4, 5], 6, false)), false)], false);
    let nested = include_bytes!("data/nested.mat");
    let old = include_bytes!("data/version_4.mat");
    let read = damage::survive("run.mat", &[&run(false), &run(true), &packed, nested, old], 1000, 5);
    assert!((50..950).contains(&read), "{read} of 1000 copies read");
}
