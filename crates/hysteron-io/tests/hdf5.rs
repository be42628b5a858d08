//! HDF5 files, MAT files of version 7.3 among them: the numbers that h5py reads, and that no damage makes the
//! reader panic.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;
mod oracle;

use hysteron_io::{ReadOptions, contents_of_bytes, read_input_output_bytes, read_record_bytes};

const RUN: &[u8] = include_bytes!("data/run.h5");
const PACKED: &[u8] = include_bytes!("data/packed.h5");
const LINKED: &[u8] = include_bytes!("data/linked.h5");
const LADDER: &[u8] = include_bytes!("data/ladder.h5");
const UNWRITTEN: &[u8] = include_bytes!("data/unwritten.h5");
const DEEP: &[u8] = include_bytes!("data/deep.h5");
const CELLS: &[u8] = include_bytes!("data/cells_7.3.mat");
const MATLAB: &[u8] = include_bytes!("data/matlab_7.3.mat");

#[test]
fn the_values_are_those_that_h5py_reads() {
    let Some((_folder, cases)) = oracle::written_by("hdf5.py") else { return };
    assert!(cases.len() >= 100, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 2 * cases.len());
    eprintln!("{} files", cases.len());
}

#[test]
fn cells_and_arrays_of_structures_of_matlab_are_read_as_mat73_reads_them() {
    let Some((_folder, cases)) = oracle::written_by("matlab73.py") else { return };
    assert!(cases.len() >= 100, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 3 * cases.len());
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
fn references_that_lead_back_to_their_cells_end() {
    let held = contents_of_bytes("cells.mat", CELLS, &ReadOptions::default()).unwrap();
    let mut kinds: Vec<(&str, &str)> =
        held.iter().map(|own| (own.path.as_str(), own.kind.as_str())).collect();
    let expected = [
        ("c{1}", "numbers"),
        ("c{2}.again{1}", "a reference to an enclosing group or cell array"),
        ("c{2}.u", "numbers"),
        ("c{3}", "a reference to nothing"),
        ("c{4}", "an empty array"),
        ("f", "function"),
        ("none", "structure without fields"),
        ("s", "sparse matrix"),
        ("when", "object of class datetime"),
    ];
    kinds.sort_unstable();
    assert_eq!(kinds, expected);
    assert_eq!(held.iter().find(|own| own.path == "c{4}").unwrap().shape, [0, 3]);
}

#[test]
fn a_dataset_that_is_linked_to_twice_is_one_column() {
    let held = contents_of_bytes("linked.h5", LINKED, &ReadOptions::default()).unwrap();
    let paths: Vec<&str> = held.iter().map(|content| content.path.as_str()).collect();
    assert_eq!(paths, ["data/t_s", "data/u_V", "data/y_um", "entry/t_s", "entry/u_V", "entry/y_um"]);
    let by_path =
        |input: Option<&str>| ReadOptions { input: input.map(str::to_owned), ..ReadOptions::default() };
    for input in [None, Some("data/u_V"), Some("entry/u_V")] {
        let record = read_record_bytes("linked.h5", LINKED, &by_path(input)).unwrap();
        let mut names: Vec<&str> = record.channels.iter().map(|channel| channel.name.as_str()).collect();
        names.sort_unstable();
        assert_eq!(names, ["u", "y"], "{input:?}");
    }
}

#[test]
fn groups_that_are_linked_to_within_themselves_end() {
    // Two groups of each group, to a depth of 18: more than 2¹⁷ paths.
    let refusal = read_record_bytes("ladder.h5", LADDER, &ReadOptions::default()).unwrap_err().to_string();
    assert!(refusal.contains("more than 65536 groups"), "{refusal}");
}

#[test]
fn a_group_that_is_too_deep_is_listed_and_named_where_something_in_it_is_asked_for() {
    let held = contents_of_bytes("deep.h5", DEEP, &ReadOptions::default()).unwrap();
    let deep = held.iter().find(|content| content.kind.contains("deeper than the 32 levels")).unwrap();
    assert!(deep.path.starts_with("g0/g1/") && deep.path.ends_with("/g32"), "{deep:?}");
    assert_eq!(read_record_bytes("deep.h5", DEEP, &ReadOptions::default()).unwrap().channels.len(), 2);
    let inside = (0..40).map(|level| format!("g{level}/")).collect::<String>() + "w_V";
    for asked in [inside.as_str(), "g32"] {
        let options = ReadOptions { input: Some(asked.into()), ..ReadOptions::default() };
        let refusal = read_record_bytes("deep.h5", DEEP, &options).unwrap_err().to_string();
        assert!(
            refusal.contains("array `g0/g1/") && refusal.contains("deeper than the 32 levels"),
            "{refusal}"
        );
    }
}

#[test]
fn a_dataset_that_was_never_written_is_refused_with_what_to_raise() {
    // 2²⁸ doubles in two kilobytes.
    let refusal =
        read_record_bytes("unwritten.h5", UNWRITTEN, &ReadOptions::default()).unwrap_err().to_string();
    assert!(refusal.contains("stopped in array `u_V`") && refusal.contains("`max_bytes`"), "{refusal}");
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let read = damage::survive("run.h5", &[RUN, PACKED, MATLAB, LINKED, CELLS], 1000, 3);
    assert!((50..950).contains(&read), "{read} of 1000 copies read");
}
