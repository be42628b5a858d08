//! NPY and NPZ: what is accepted and what it becomes; what is refused, and that no damage makes it panic.
#![allow(clippy::unwrap_used, clippy::panic)]

mod numpy;

mod damage;

use hysteron_io::{
    FilePart, IoError, Place, ReadOptions, ResponseOptions, read_frequency_response_bytes,
    read_input_output_bytes, read_record_bytes,
};
use hysteron_model::record::{Record, TimeBase};
use hysteron_numeric::Complex64;
use numpy::{doubles, npy, npz, npz_deflated, structured};
use proptest::prelude::*;

const T: [f64; 4] = [0.0, 0.005, 0.01, 0.015];
const U: [f64; 4] = [1.0, -2.0, 3.0, 1e-9];
const Y: [f64; 4] = [0.5, 4.0, -6.25, 2e20];

/// Time, drive and displacement.
fn loop_arrays() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("t_s", npy("<f8", "(4,)", &doubles(&T))),
        ("u_V", npy("<f8", "(4,)", &doubles(&U))),
        ("y_um", npy("<f8", "(4,)", &doubles(&Y))),
    ]
}

fn read(bytes: &[u8]) -> Record {
    read_record_bytes("loop.npz", bytes, &ReadOptions::default()).unwrap()
}

fn refused(bytes: &[u8]) -> IoError {
    read_record_bytes("loop.npz", bytes, &ReadOptions::default()).unwrap_err()
}

fn with(other: &str, array: Vec<u8>) -> Vec<u8> {
    let mut arrays = loop_arrays();
    arrays.retain(|(name, _)| *name != other);
    arrays.push((other, array));
    npz(&arrays)
}

fn says(bytes: &[u8], parts: &[&str]) {
    let message = refused(bytes).to_string();
    for part in parts.iter().chain(&["loop.np"]) {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

fn array(name: &str) -> Place {
    Place { file: "loop.npz".into(), part: FilePart::Array(name.into()) }
}

fn element(name: &str, index: usize) -> Place {
    Place { file: "loop.npz".into(), part: FilePart::Element { array: name.into(), index } }
}

#[test]
fn an_npz_file_reads_as_the_same_record_as_the_csv_file() {
    let csv = "t_s,u_V,y_um\n0,1,0.5\n0.005,-2,4\n0.01,3,-6.25\n0.015,1e-9,2e20\n";
    let csv = read_record_bytes("loop.csv", csv.as_bytes(), &ReadOptions::default()).unwrap();
    for bytes in [npz(&loop_arrays()), npz_deflated(&loop_arrays())] {
        // Told by its first bytes, whatever its extension.
        for name in ["loop.npz", "loop.dat", "loop"] {
            let record = read_record_bytes(name, &bytes, &ReadOptions::default()).unwrap();
            assert_eq!((&record.time, &record.channels), (&csv.time, &csv.channels));
            assert_eq!(record.name, name);
            assert_eq!(record.source.unwrap().sha256, hysteron_io::sha256(&bytes));
        }
    }
    let outcome = read_input_output_bytes("loop.npz", &npz(&loop_arrays()), &ReadOptions::default()).unwrap();
    assert_eq!((outcome.data.u, outcome.data.y), (U.to_vec(), Y.to_vec()));
}

#[test]
fn a_file_that_numpy_wrote_reads_to_its_numbers() {
    let record = read(include_bytes!("data/numpy_savez.npz"));
    assert_eq!(record.time, TimeBase::uniform(1000.0));
    assert_eq!(record.channel("u_V").unwrap().samples, [0.0, 1.5, -2.5, 3.25, 4.0]);
    assert_eq!(record.channel("y_um").unwrap().samples, [-1.0, 0.0, 1.0, 2.0, 3.0]);
    assert_eq!(record.valid, Some(vec![true, true, false, true, true]));
    let packed = read(include_bytes!("data/numpy_savez_compressed.npz"));
    assert_eq!((&packed.channels, &packed.valid), (&record.channels, &record.valid));
    let fields = include_bytes!("data/numpy_structured.npy");
    let fields = read_record_bytes("x.npy", fields, &ReadOptions::default()).unwrap();
    assert_eq!(fields.time, TimeBase::uniform(1000.0));
    assert_eq!((&fields.channels, &fields.valid), (&record.channels, &record.valid));
}

#[test]
fn every_type_of_number_is_read_in_either_byte_order() {
    let values = [0i8, 1, 7, 100];
    let expected = values.map(f64::from);
    macro_rules! stored {
        ($($number:ty => $letters:literal),*) => {[$(
            (format!("<{}", $letters), values.map(|v| (v as $number).to_le_bytes().to_vec()).concat()),
            (format!(">{}", $letters), values.map(|v| (v as $number).to_be_bytes().to_vec()).concat()),
            (format!("|{}", $letters), values.map(|v| (v as $number).to_le_bytes().to_vec()).concat()),
        )*]};
    }
    for (dtype, data) in stored!(f64 => "f8", f32 => "f4", i8 => "i1", i16 => "i2", i32 => "i4", i64 => "i8",
        u8 => "u1", u16 => "u2", u32 => "u4", u64 => "u8")
    {
        let record = read(&with("u_V", npy(&dtype, "(4,)", &data)));
        assert_eq!(record.channel("u_V").unwrap().samples, expected, "{dtype}");
    }
    let negative = [-1i16, i16::MIN, i16::MAX, -300];
    let record = read(&with("u_V", npy(">i2", "(4,)", &negative.map(i16::to_be_bytes).concat())));
    assert_eq!(record.channel("u_V").unwrap().samples, negative.map(f64::from));
    let record = read(&with("valid", npy("|b1", "(4,)", &[1, 0, 1, 1])));
    assert_eq!(record.valid, Some(vec![true, false, true, true]));
}

#[test]
fn rows_and_columns_of_either_order_are_read_as_lists() {
    for shape in ["(4, 1)", "(1, 4)", "(4, 1), 'fortran_order': True", "(1, 1, 4)"] {
        let record = read(&with("y_um", npy("<f8", shape, &doubles(&Y))));
        assert_eq!(record.channel("y").unwrap().samples, Y, "{shape}");
    }
}

#[test]
fn a_number_gives_the_sample_rate_where_there_is_no_time() {
    for (name, value, shape) in [
        ("fs", 200.0, "()"),
        ("Fs", 200.0, "(1,)"),
        ("fs_kHz", 0.2, "(1, 1)"),
        ("sample_rate_hz", 200.0, "()"),
        ("dt", 0.005, "()"),
        ("dt_ms", 5.0, "()"),
    ] {
        let mut arrays = loop_arrays();
        arrays[0] = (name, npy("<f8", shape, &doubles(&[value])));
        arrays.push(("remark", npy("<U3", "()", &[0; 12])));
        let record = read(&npz(&arrays));
        assert_eq!(record.time, TimeBase::uniform(200.0), "{name}");
        let options = ReadOptions { sample_rate_hz: Some(50.0), ..ReadOptions::default() };
        let record = read_record_bytes("loop.npz", &npz(&arrays), &options).unwrap();
        assert_eq!(record.time, TimeBase::uniform(50.0), "{name}");
    }
    let beside_time = |rate| read_record_bytes("loop.npz", &with("fs", rate), &ReadOptions::default());
    assert!(beside_time(npy("<f8", "()", &doubles(&[200.0]))).is_ok());
    let contradiction = beside_time(npy("<f8", "()", &doubles(&[1000.0]))).unwrap_err();
    assert!(matches!(&contradiction, IoError::RateContradictsTime { place, .. } if *place == array("fs")));
    assert!(contradiction.to_string().contains("1000 Hz"), "{contradiction}");
    for nonsense in [0.0, -1.0, f64::NAN] {
        let found = beside_time(npy("<f8", "()", &doubles(&[nonsense]))).unwrap_err();
        assert!(matches!(&found, IoError::BadRate { place, .. } if *place == array("fs")), "{found}");
    }
}

#[test]
fn the_fields_of_a_structured_array_are_columns() {
    let rows: Vec<u8> = (0..4)
        .flat_map(|k| {
            let mut row = doubles(&[T[k]]);
            row.extend((U[k] as f32).to_be_bytes());
            row.extend([0; 4]);
            row.extend(doubles(&[Y[k]]));
            row
        })
        .collect();
    let fields = "[('t_s', '<f8'), ('u_V', '>f4'), ('', '|V4'), (('displacement', 'y_um'), '<f8')]";
    for shape in ["(4,)", "(4, 1)", "(1, 4)"] {
        let bytes = structured(fields, shape, &rows);
        let record = read_record_bytes("loop.npy", &bytes, &ReadOptions::default()).unwrap();
        assert!(matches!(record.time, TimeBase::Uniform { sample_rate_hz: 200.0, .. }));
        assert_eq!(record.channel("u_V").unwrap().samples, U.map(|u| f64::from(u as f32)));
        assert_eq!(record.channel("y_um").unwrap().samples, Y);
    }
}

#[test]
fn only_the_chosen_columns_must_be_readable() {
    let mut arrays = loop_arrays();
    arrays.push(("labels", npy("<U2", "(4,)", &[0; 32])));
    arrays.push(("calibration", npy("<f8", "(2, 2)", &doubles(&U))));
    arrays.push(("gains", npy("<f8", "(2,)", &doubles(&[1.0, 2.0]))));
    // A text as long as the record is no channel, and is refused where nothing is chosen.
    says(&npz(&arrays), &["array `labels`", "<U2"]);
    let labels = arrays.remove(3);
    assert_eq!(labels.0, "labels");
    let outcome = read_input_output_bytes("loop.npz", &npz(&arrays), &ReadOptions::default()).unwrap();
    assert_eq!((outcome.data.u.len(), outcome.data.y.len()), (4, 4));
    // What could be a channel but is of another length is not left out without a word.
    let [note] = outcome.notes.as_slice() else { panic!("{:?}", outcome.notes) };
    assert!(note.text.contains("arrays of 4 samples") && note.text.contains("`gains` (2)"), "{note:?}");
    arrays.push(labels);
    let labels = ReadOptions { input: Some("labels".into()), ..ReadOptions::default() };
    let message = read_record_bytes("loop.npz", &npz(&arrays), &labels).unwrap_err().to_string();
    assert!(message.contains("array `labels`") && message.contains("<U2"), "{message}");
    let chosen = ReadOptions { input: Some("u".into()), output: Some("y".into()), ..ReadOptions::default() };
    let record = read_record_bytes("loop.npz", &npz(&arrays), &chosen).unwrap();
    assert_eq!(record.channels.len(), 2);
    let absent = ReadOptions { input: Some("v".into()), ..ReadOptions::default() };
    let message = read_record_bytes("loop.npz", &npz(&arrays), &absent).unwrap_err().to_string();
    assert!(message.contains("no column `v` to be the input") && message.contains("`u_V`"), "{message}");
}

#[test]
fn values_that_no_record_may_hold_are_named_by_array_and_index() {
    let wrong = refused(&with("y_um", npy("<f8", "(4,)", &doubles(&[0.0, 1.0, f64::NAN, 2.0]))));
    assert!(matches!(&wrong, IoError::NotFinite { place, .. } if *place == element("y_um", 2)), "{wrong}");
    assert!(wrong.to_string().contains("`loop.npz`, array `y_um`, index 2"), "{wrong}");
    let wrong = refused(&with("valid", npy("|u1", "(4,)", &[1, 0, 3, 1])));
    assert!(matches!(&wrong, IoError::BadMask { place, .. } if *place == element("valid", 2)), "{wrong}");
    let wrong = refused(&with("t_s", npy("<f8", "(4,)", &doubles(&[0.0, 1.0, 2.0, 1.5]))));
    assert!(matches!(&wrong,
        IoError::TimeDecreases { place, before: 2.0, after: 1.5 } if *place == element("t_s", 3)));
    let none = ["t_s", "u_V"].map(|name| (name, npy("<f8", "(0,)", &[])));
    assert!(matches!(refused(&npz(&none)), IoError::NoSamples { .. }));
    let one = ["t_s", "u_V"].map(|name| (name, npy("<f8", "(1,)", &doubles(&[0.0]))));
    assert!(matches!(refused(&npz(&one)), IoError::OneSample { .. }));
}

#[test]
fn arrays_without_names_are_refused_with_what_to_write() {
    for shape in ["(4, 1)", "(4,)", "(2, 2)", "()"] {
        let bytes = npy("<f8", shape, &doubles(&Y));
        says(&bytes, &["without column names", "numpy.savez", "t_s=t, u_V=u, y_um=y", shape]);
    }
}

#[test]
fn files_that_are_something_else_say_so() {
    says(b"t_s,u_V\n0,1\n1,2\n", &["no sound NPZ file", "not a zip archive"]);
    says(b"PK\x05\x06 and then nothing", &["no sound NPZ file"]);
    says(&npz::<Vec<u8>>(&[]), &["it holds no arrays (`NAME.npy`)"]);
    says(&with("u_V", b"not an array".to_vec()), &["array `u_V`", "does not begin"]);
    says(&with("u_V", b"\x93NUMPY\x09\x00\x02\x00{}".to_vec()), &["array `u_V`", "version 9"]);
    says(&with("u_V", npy("<f8", "4", &[])), &["array `u_V`", "`shape`"]);
    says(&with("u_V", npy("<c16", "(4,)", &[0; 64])), &["array `u_V`", "type <c16", "astype"]);
    says(&with("u_V", npy("|O", "(4,)", &[0; 64])), &["array `u_V`", "type |O"]);
    let nested = format!("{}{}", "[".repeat(10_000), "]".repeat(10_000));
    says(&structured(&nested, "(4,)", &[]), &["no Python dictionary"]);
}

#[test]
fn promises_that_the_file_does_not_keep_are_refused() {
    let all = |shape| npz(&["t_s", "u_V", "y_um"].map(|name| (name, npy("<f8", shape, &doubles(&U)))));
    says(&all("(1000,)"), &["array `t_s`", "ends after 4 of the 1000 values"]);
    says(&all("(3,)"), &["array `t_s`", "goes on behind the 3 values"]);
    let fields = structured("[('u_V', '<f8')]", "(100,)", &doubles(&U));
    says(&fields, &["ends after 4 of the 100 values"]);
    // More than the limits: refused before anything is allocated.
    for shape in ["(1000000000000,)", "(4294967296, 1)"] {
        let error = refused(&all(shape));
        assert!(matches!(&error, IoError::TooManyValues { place, .. } if *place == array("t_s")), "{error}");
    }
    let too_many = npz(&["t_s", "u_V"].map(|name| (name, npy("|u1", "(1000000000,)", &[1]))));
    assert!(matches!(refused(&too_many), IoError::TooManyValues { .. }));
    says(&with("u_V", npy("<f8", "(4294967296, 4294967296, 4294967296)", &[])), &["array `u_V`", "`shape`"]);
    // A damaged byte within an array.
    let mut damaged = npz(&loop_arrays());
    let at = damaged.windows(8).position(|bytes| bytes == 3.0f64.to_le_bytes()).unwrap();
    damaged[at] ^= 1;
    says(&damaged, &["array `u_V`", "hecksum"]);
}

#[test]
fn an_archive_that_swells_stops_at_the_limit() {
    let zeros = npy("<f8", "(1000000,)", &vec![0; 8_000_000]);
    let bytes = npz_deflated(&[("u_V", zeros.clone()), ("y_um", zeros)]);
    assert!(bytes.len() < 100_000);
    let options = |max_bytes, max_values| ReadOptions { max_bytes, max_values, ..ReadOptions::default() };
    let read = |options| read_record_bytes("loop.npz", &bytes, &options);
    assert!(read(options(16_000_000, 2_000_000)).is_ok());
    let error = read(options(15_999_999, 2_000_000)).unwrap_err();
    assert!(matches!(&error, IoError::TooLarge { place, .. } if *place == array("y_um")), "{error}");
    let error = read(options(16_000_000, 1_999_999)).unwrap_err();
    assert!(matches!(&error, IoError::TooManyValues { place, .. } if *place == array("y_um")), "{error}");
    let error = read(options(bytes.len() as u64 - 1, 2_000_000)).unwrap_err();
    assert!(matches!(&error, IoError::TooLarge { .. }), "{error}");
}

#[test]
fn a_frequency_response_is_read_from_arrays_too() {
    let arrays = [
        ("f_Hz", npy("<f4", "(2,)", &[10f32, 1.0].map(f32::to_le_bytes).concat())),
        ("re_um_per_V", npy("<f8", "(2,)", &doubles(&[-0.5, 0.0]))),
        ("im_um_per_V", npy("<f8", "(2,)", &doubles(&[0.0, 2.0]))),
    ];
    assert!(matches!(refused(&npz(&arrays)), IoError::FrequencyResponse { .. }));
    let response =
        read_frequency_response_bytes("frf.npz", &npz(&arrays), &ResponseOptions::default()).unwrap();
    assert_eq!(response.frequency_hz, [1.0, 10.0]);
    assert_eq!(response.values, [Complex64::new(0.0, 2.0), Complex64::new(-0.5, 0.0)]);
    assert_eq!(response.unit, "um_per_V");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damaged_files_never_panic_and_what_is_accepted_is_sound(
        which in 0usize..4,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut arrays = loop_arrays();
        arrays.push(("fs", npy("<f8", "()", &doubles(&[200.0]))));
        let rows: Vec<f64> = (0..4).flat_map(|k| [T[k], U[k], Y[k]]).collect();
        let fields = "[('t_s', '<f8'), ('u_V', '<f8'), ('y_um', '<f8')]";
        let mut bytes = match which {
            0 => npz(&arrays),
            1 => npz_deflated(&arrays),
            2 => structured(fields, "(4,)", &doubles(&rows)),
            // The header alone, where most of the parsing is.
            _ => with("u_V", npy("<f8", "(4,)", &doubles(&U))).into_iter().take(400).collect(),
        };
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        for (at, value) in changes {
            if !bytes.is_empty() {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
        }
        match read_record_bytes("loop.npz", &bytes, &ReadOptions::default()) {
            Ok(record) => prop_assert_eq!(record.check(), Ok(())),
            Err(err) => {
                let message = err.to_string();
                prop_assert!(message.contains("loop.npz") && message.len() < 2000, "{}", message);
            }
        }
    }

    #[test]
    fn damaged_headers_never_panic(
        header in "[{(\\[]{0,3}('[a-z_VU]{0,6}'[:,] ?('[<>|=]?[fiubcVUSO]?[0-9]{0,12}'|\\([0-9, \
                   L]{0,24}\\)|[\\[\\]{}()',\\\\x]{0,6}|True|None)[,}\\])]{0,2} ?){0,6}",
        descr in "'[<>|=]?[fiubcVUSO][0-9]{0,6}'|\\[(\\('[a-zV_]{0,5}', '<[fiVUSO][0-9]{0,12}'(, ?\\([0-9, \
                  ]{0,12}\\))?\\),?){0,4}\\]",
        shape in "\\([0-9]{0,20},? ?[0-9]{0,20}\\)",
    ) {
        for array in [numpy::with_header(&header, &[0; 64]), structured(&descr, &shape, &[0; 64])] {
            for bytes in [with("u_V", array.clone()), array] {
                if let Ok(record) = read_record_bytes("loop.npz", &bytes, &ReadOptions::default()) {
                    prop_assert_eq!(record.check(), Ok(()));
                }
            }
        }
    }
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let archives =
        [&include_bytes!("data/loop.npz")[..], &include_bytes!("data/numpy_savez_compressed.npz")[..]];
    damage::survive("run.npz", &archives, 1000, 7);
    damage::survive("run.npy", &[include_bytes!("data/numpy_structured.npy")], 1000, 11);
}
