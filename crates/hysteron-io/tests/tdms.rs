//! TDMS files: the numbers that npTDMS reads, what is refused, and that no damage makes the reader panic.
#![allow(clippy::unwrap_used)]

mod damage;
mod oracle;

use hysteron_io::{IoError, ReadOptions, contents_of_bytes, read_input_output_bytes, read_record_bytes};
use hysteron_model::record::TimeBase;

const INCREMENTAL: &[u8] = include_bytes!("data/incremental.tdms");
const SCALED: &[u8] = include_bytes!("data/scaled_big_endian.tdms");
const WRITTEN: &[u8] = include_bytes!("data/timestamps.tdms");
const INTERLEAVED: &[u8] = include_bytes!("data/interleaved_cut_off.tdms");

#[test]
fn the_values_are_those_that_nptdms_reads() {
    let Some((_folder, cases)) = oracle::written_by("tdms.py") else { return };
    assert!(cases.len() >= 100, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 2 * cases.len());
}

#[test]
fn columns_that_are_named_with_their_units_need_no_choice() {
    let outcome = read_input_output_bytes("run.tdms", INTERLEAVED, &ReadOptions::default()).unwrap();
    assert_eq!(outcome.data.u.len(), outcome.data.y.len());
    let record = read_record_bytes("run", WRITTEN, &ReadOptions::default()).unwrap();
    let TimeBase::Uniform { sample_rate_hz, .. } = record.time else { unreachable!("{:?}", record.time) };
    assert!((sample_rate_hz / 8000.0 - 1.0).abs() < 1e-9, "{sample_rate_hz}");
}

#[test]
fn raw_data_of_a_daqmx_device_are_refused_by_name() {
    let mut bytes = b"TDSm".to_vec();
    let path = "/'rig'/'u_V'";
    let mut meta = 1u32.to_le_bytes().to_vec();
    meta.extend((path.len() as u32).to_le_bytes());
    meta.extend(path.as_bytes());
    for number in [0x1269u32, 0xFFFF_FFFF, 1, 2, 0, 1, 3, 0, 0, 0, 0, 1, 2, 0] {
        meta.extend(number.to_le_bytes());
    }
    bytes.extend(0x8Eu32.to_le_bytes());
    bytes.extend(4713u32.to_le_bytes());
    bytes.extend((meta.len() as u64 + 4).to_le_bytes());
    bytes.extend((meta.len() as u64).to_le_bytes());
    bytes.extend(meta);
    bytes.extend([1, 0, 2, 0]);
    let listed = contents_of_bytes("run.tdms", &bytes, &ReadOptions::default()).unwrap();
    assert!(listed[0].kind.contains("DAQmx"), "{listed:?}");
    let options = ReadOptions { input: Some("u_V".to_owned()), ..ReadOptions::default() };
    let refusal = read_record_bytes("run.tdms", &bytes, &options).unwrap_err();
    assert!(matches!(refusal, IoError::ArrayType { .. }), "{refusal}");
    assert!(refusal.to_string().contains("DAQmx"), "{refusal}");
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    let read = damage::survive("run.tdms", &[INCREMENTAL, SCALED, WRITTEN, INTERLEAVED], 1000, 18);
    assert!((100..900).contains(&read), "{read} of 1000 copies read");
}
