//! Files of records and of frequency responses.

use std::io::{Cursor, Write};

use hysteron_io::{
    ReadOptions, ResponseOptions, contents_of_bytes, read_frequency_response_bytes, read_input_output_bytes,
    read_record_bytes, write_csv_to,
};
use hysteron_model::record::{Record, TimeBase, inspect};
use zip::CompressionMethod;
use zip::write::SimpleFileOptions;

/// Samples of a record that are inspected too; more only take their time.
const INSPECTED: usize = 300;

fn options() -> ReadOptions {
    // What a file of some kilobytes may ask for.
    ReadOptions { max_bytes: 1 << 22, max_values: 1 << 18, ..ReadOptions::default() }
}

fn read(name: &str, data: &[u8]) {
    // Most inputs are refused, by code that all three ways of reading share: these take turns at the other two.
    let turn = data.iter().fold(0_u8, |sum, byte| sum.wrapping_mul(31).wrapping_add(*byte)) % 4;
    let Ok(record) = read_record_bytes(name, data, &options()) else {
        match turn {
            0 => drop(contents_of_bytes(name, data, &options())),
            // What is no record is no input and output either, for the same reason or another.
            1 => assert!(read_input_output_bytes(name, data, &options()).is_err()),
            _ => {}
        }
        return;
    };
    let _ = contents_of_bytes(name, data, &options());
    for channel in &record.channels {
        assert_eq!(channel.samples.len(), record.len(), "{}", channel.name);
        assert!(channel.samples.iter().all(|x| x.is_finite()), "{} is not finite", channel.name);
    }
    if let TimeBase::Uniform { start_s, sample_rate_hz, .. } = record.time {
        assert!(start_s.is_finite() && sample_rate_hz.is_finite() && sample_rate_hz > 0.0);
    }
    if record.len() <= INSPECTED && record.channels.len() <= 8 {
        if let Ok(found) = read_input_output_bytes(name, data, &options()) {
            assert_eq!(found.data.u.len(), found.data.y.len());
            let _ = inspect(&found.data);
        }
        read_back(&record);
    }
}

/// What the program writes, it reads.
fn read_back(record: &Record) {
    let mut text = Vec::new();
    write_csv_to(&mut text, record).expect("memory takes any text");
    let again = match read_record_bytes("again.csv", &text, &options()) {
        Ok(again) => again,
        Err(e) => panic!("what was written is refused: {e}\n{}", String::from_utf8_lossy(&text)),
    };
    let samples = |record: &Record| -> Vec<Vec<f64>> {
        record.channels.iter().map(|channel| channel.samples.clone()).collect()
    };
    assert_eq!(samples(&again), samples(record), "{}", String::from_utf8_lossy(&text));
}

pub fn csv(data: &[u8]) {
    read("a.csv", data);
}

pub fn gcs(data: &[u8]) {
    read("a.gcs", data);
}

pub fn hdf5(data: &[u8]) {
    read("a.h5", data);
}

pub fn lvm(data: &[u8]) {
    read("a.lvm", data);
}

pub fn mat(data: &[u8]) {
    read("a.mat", data);
}

pub fn npy(data: &[u8]) {
    read("a.npy", data);
}

pub fn tdms(data: &[u8]) {
    read("a.tdms", data);
}

/// As they are, or, after a first byte 0, as the members of an archive that is whole: a fuzzer does not find
/// checksums.
pub fn npz(data: &[u8]) {
    match data.split_first() {
        Some((0, rest)) => read("a.npz", &archive(&["u_V.npy", "y_um.npy"], rest)),
        _ => read("a.npz", data),
    }
}

pub fn jpk(data: &[u8]) {
    let names = [
        "header.properties",
        "shared-data/header.properties",
        "segments/0/segment-header.properties",
        "segments/0/channels/height.dat",
        "segments/0/channels/vDeflection.dat",
    ];
    match data.split_first() {
        Some((0, rest)) => read("a.jpk-force", &archive(&names, rest)),
        _ => read("a.jpk-force", data),
    }
}

pub fn xlsx(data: &[u8]) {
    let names = [
        "xl/worksheets/sheet1.xml",
        "xl/sharedStrings.xml",
        "xl/workbook.xml",
        "xl/_rels/workbook.xml.rels",
        "[Content_Types].xml",
    ];
    match data.split_first() {
        Some((0, rest)) => read("a.xlsx", &archive(&names, rest)),
        _ => read("a.xlsx", data),
    }
}

/// An archive of members that are divided by the byte 255 thrice.
fn archive(names: &[&str], data: &[u8]) -> Vec<u8> {
    let mut rest = data;
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for name in names {
        let end = rest.windows(3).position(|three| three == [255; 3]);
        let (member, left) = end.map_or((rest, &rest[rest.len()..]), |end| (&rest[..end], &rest[end + 3..]));
        // Compression takes longer than all else.
        let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        archive.start_file(*name, stored).expect("a name");
        archive.write_all(member).expect("memory takes any bytes");
        rest = left;
    }
    archive.finish().expect("an archive in memory").into_inner()
}

pub fn response(data: &[u8]) {
    let options = ResponseOptions::default();
    if let Ok(found) = read_frequency_response_bytes("a.csv", data, &options) {
        assert!(found.frequency_hz.iter().all(|f| f.is_finite() && *f > 0.0));
    }
}
