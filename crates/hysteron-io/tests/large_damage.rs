//! Damaged files of 200 MB: each is read or refused within 1 GiB and 10 s.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;

use std::fs::File;
use std::io::{Cursor, Seek, SeekFrom, Write};
use std::path::Path;

use damage::Random;
use damage::child::{read_apart, read_given};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

const BYTES: usize = 200_000_000;
/// Damaged copies of each file.
const COPIES: usize = 2;
/// Bytes at both ends of a file that are damaged; what is between them is all numbers.
const ENDS: usize = 4096;

#[test]
#[ignore = "reads the file that the other tests give it, in a process of its own"]
fn reads_the_file_given() {
    read_given();
}

/// Reads damaged copies of a file: parts of its ends and of its middle are made anew, or it is cut off.
fn survive(path: &Path, bytes: &[u8], seed: u64) {
    std::fs::write(path, bytes).unwrap();
    let mut random = Random(seed);
    for copy in 0..=COPIES {
        let mut file = File::options().write(true).open(path).unwrap();
        // The first one is sound.
        if copy > 0 {
            for start in [0, bytes.len() / 2, bytes.len() - ENDS] {
                let mut part = bytes[start..start + ENDS].to_vec();
                random.damage(&mut part);
                part.resize(ENDS, 0);
                file.seek(SeekFrom::Start(start as u64)).unwrap();
                file.write_all(&part).unwrap();
            }
            if copy == COPIES {
                file.set_len(bytes.len() as u64 / 3).unwrap();
            }
        }
        drop(file);
        let read = read_apart(path, "reads_the_file_given");
        eprintln!("copy {copy}: {} MB of memory, {:?}; {:?}", read.peak_kb / 1000, read.took, read.refusals);
        assert!(copy > 0 || read.refusals[2].is_empty(), "{}", read.refusals[2]);
    }
}

#[test]
fn of_tdms() {
    let folder = tempfile::tempdir().unwrap();
    let samples = BYTES / 3 / 8;
    let mut metadata = 3u32.to_le_bytes().to_vec();
    for name in ["t_s", "u_V", "y_um"] {
        let path = format!("/'run'/'{name}'");
        metadata.extend((path.len() as u32).to_le_bytes());
        metadata.extend(path.as_bytes());
        metadata.extend([20u32, 10, 1, 1000, 0, 0].map(u32::to_le_bytes).concat());
    }
    let mut bytes = b"TDSm".to_vec();
    bytes.extend([0b1110u32, 4713].map(u32::to_le_bytes).concat());
    let lengths = [(metadata.len() + samples / 1000 * 24_000) as u64, metadata.len() as u64];
    bytes.extend(lengths.map(u64::to_le_bytes).concat());
    bytes.extend(metadata);
    for chunk in 0..samples / 1000 {
        for channel in 0..3 {
            let values = (0..1000).map(|k| (1000 * chunk + k) as f64 * if channel == 0 { 1e-3 } else { 0.5 });
            bytes.extend(values.flat_map(f64::to_le_bytes));
        }
    }
    survive(&folder.path().join("large.tdms"), &bytes, 18);
}

#[test]
fn of_jpk() {
    let folder = tempfile::tempdir().unwrap();
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let mut add = |name: &str, bytes: &[u8]| {
        zip.start_file(name, options).unwrap();
        zip.write_all(bytes).unwrap();
    };
    add("header.properties", b"jpk-data-file=spm-forcefile\n");
    add("shared-data/header.properties", b"lcd-info.0.type=float-data\nlcd-info.0.unit.unit=V\n");
    let header = b"force-segment-header.duration=1.0\nchannel.height.lcd-info.*=0\n";
    for curve in 0..10 {
        add(&format!("index/{curve}/segments/0/segment-header.properties"), header);
        let values: Vec<u8> = (0..BYTES / 10 / 4 - curve).flat_map(|k| (k as f32).to_be_bytes()).collect();
        add(&format!("index/{curve}/segments/0/channels/height.dat"), &values);
    }
    survive(&folder.path().join("large.jpk-force-map"), &zip.finish().unwrap().into_inner(), 20);
}
