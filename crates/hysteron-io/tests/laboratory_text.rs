//! LVM files and GCS arrays: the numbers that other programs read, what is refused, and that no damage makes
//! the readers panic.
#![allow(clippy::unwrap_used)]

mod damage;
mod oracle;

use hysteron_io::{ReadOptions, read_record_bytes};
use hysteron_model::record::{Record, TimeBase, Unit};

const LVM: &str = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\nMulti_Headings\tYes\n\
                   X_Columns\tOne\n***End_of_Header***\t\n\t\nChannels\t2\nSamples\t3\t3\n\
                   Y_Unit_Label\tVolts\tµm\nX_Dimension\tTime\tTime\nX0\t1,0E+0\t1,0E+0\n\
                   Delta_X\t0,001\t0,001\n***End_of_Header***\t\nX_Value\tdrive\tsensor\tComment\n\
                   1,000\t1,5\t-2\tbegun\n1,001\t2,5\t-3\n1,002\t3,5\t-4\n";
const GCS: &str = "# TYPE = 1 \n# SEPARATOR = 32 \n# DIM = 2 \n# SAMPLE_TIME = 0.0001 \n# NDATA = 3 \n\
                   # NAME0 = target_um\n# NAME1 = Current Position of axis1 \n# END_HEADER \n\
                   0.5 1.5 \n1.0 2.5 \n-2.0 3e-2 \n";

fn read(name: &str, text: &str) -> Record {
    read_record_bytes(name, text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn refusal(name: &str, text: &str) -> String {
    read_record_bytes(name, text.as_bytes(), &ReadOptions::default()).unwrap_err().to_string()
}

fn uniform(record: &Record) -> (f64, f64) {
    let TimeBase::Uniform { start_s, sample_rate_hz, .. } = record.time else {
        unreachable!("{:?}", record.time)
    };
    (start_s, sample_rate_hz)
}

#[test]
fn the_values_of_lvm_files_are_those_that_lvm_read_reads() {
    let Some((_folder, cases)) = oracle::written_by("lvm.py") else { return };
    assert!(cases.len() >= 48, "{} files", cases.len());
    assert!(oracle::compare(&cases) > 100);
}

#[test]
fn the_values_of_gcs_arrays_are_those_of_the_text() {
    let Some((_folder, cases)) = oracle::written_by("gcs.py") else { return };
    assert!(cases.len() >= 48, "{} files", cases.len());
    assert!(oracle::compare(&cases) > 100);
}

#[test]
fn an_lvm_file_gives_units_rate_and_start() {
    let record = read("run.lvm", LVM);
    assert_eq!(uniform(&record), (1.0, 1000.0));
    assert_eq!(record.channel("drive").unwrap().samples, [1.5, 2.5, 3.5]);
    assert_eq!(record.channel("drive").unwrap().unit, Unit::new("V"));
    assert_eq!(record.channel("sensor").unwrap().unit, Unit::new("um"));
}

#[test]
fn an_lvm_file_whose_x_is_not_of_its_step_keeps_it_as_time() {
    let record = read("run.lvm", &LVM.replace("1,002", "1,009"));
    assert_eq!(record.time, TimeBase::NonUniform { times_s: vec![1.0, 1.001, 1.009] });
}

#[test]
fn segments_that_do_not_follow_on_one_another_are_listed_for_a_choice() {
    let twice = format!("{LVM}\t\n{}", &LVM[LVM.find("Channels").unwrap()..]);
    let message = refusal("run.lvm", &twice);
    assert!(message.contains("segment 1/drive") && message.contains("segment 2/drive"), "{message}");
    let options = ReadOptions {
        input: Some("segment 2/drive".to_owned()),
        output: Some("segment 2/sensor".to_owned()),
        ..ReadOptions::default()
    };
    assert_eq!(
        read_record_bytes("run.lvm", twice.as_bytes(), &options).unwrap().channels[1].samples.len(),
        3
    );
}

#[test]
fn text_and_gaps_in_an_lvm_file_are_refused_with_their_line() {
    assert!(refusal("run.lvm", &LVM.replace("2,5", "2,x")).contains("line 17, column 2"));
    assert!(refusal("run.lvm", &LVM.replace("1,001\t2,5", "1,001\t")).contains("line 17, column 2"));
}

#[test]
fn a_gcs_array_gives_names_and_rate() {
    for name in ["recorder.dat", "recorder"] {
        let record = read(name, GCS);
        assert_eq!(uniform(&record), (0.0, 10_000.0));
        assert_eq!(record.channel("target_um").unwrap().samples, [0.5, 1.0, -2.0]);
        assert_eq!(record.channel("Current Position of axis1").unwrap().samples, [1.5, 2.5, 3e-2]);
    }
}

#[test]
fn a_gcs_array_that_is_cut_off_is_refused() {
    let message = refusal("recorder.dat", GCS.split("-2.0").next().unwrap());
    assert!(message.contains("2 of the 3 samples"), "{message}");
    let message = refusal("recorder.dat", &GCS.replace("DIM = 2", "DIM = 99999999"));
    assert!(message.contains("99999999 columns"), "{message}");
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    assert!(damage::survive("run.lvm", &[LVM.as_bytes()], 1000, 18) > 10);
    assert!(damage::survive("recorder.dat", &[GCS.as_bytes()], 1000, 19) > 10);
}
