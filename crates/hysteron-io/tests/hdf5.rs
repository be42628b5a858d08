//! HDF5 files, MAT files of version 7.3 among them: the numbers that h5py reads, and that no damage makes the reader panic.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;
mod oracle;

use hysteron_io::{ReadOptions, contents_of_bytes, read_input_output_bytes, read_record_bytes};

const RUN: &[u8] = include_bytes!("data/run.h5");
const PACKED: &[u8] = include_bytes!("data/packed.h5");
const MATLAB: &[u8] = include_bytes!("data/matlab_7.3.mat");

#[test]
fn the_values_are_those_that_h5py_reads() {
    let Some((_folder, cases)) = oracle::written_by("hdf5.py") else { return };
    assert!(cases.len() >= 100, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 2 * cases.len());
    eprintln!("{} files", cases.len());
}

#[test]
fn columns_that_are_named_with_their_units_need_no_choice() {
    for bytes in [RUN, PACKED] {
        let data = read_input_output_bytes("run", bytes, &ReadOptions::default()).unwrap().data;
        assert_eq!((data.u.len(), data.y.len()), (50, 50));
        assert_eq!(data.sample_rate_hz(), Some(100.0));
    }
}

#[test]
fn fields_of_a_structure_of_matlab_are_named_with_dots() {
    let held = contents_of_bytes("run.mat", MATLAB, &ReadOptions::default()).unwrap();
    let paths: Vec<&str> = held.iter().map(|content| content.path.as_str()).collect();
    assert_eq!(paths, ["rec.t_s", "rec.u_V", "rec.y_um", "rec.note"]);
    assert_eq!(held[3].kind, "text");
    let options =
        ReadOptions { input: Some("rec.u_V".into()), output: Some("y".into()), ..ReadOptions::default() };
    let record = read_record_bytes("run.mat", MATLAB, &options).unwrap();
    assert_eq!(record.len(), 50);
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let read = damage::survive("run.h5", &[RUN, PACKED, MATLAB], 1000, 3);
    assert!((50..950).contains(&read), "{read} of 1000 copies read");
}
