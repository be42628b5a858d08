//! Arrays and archives as numpy writes them.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An array of one type, in little-endian order by default.
pub fn npy(dtype: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    structured(&format!("'{dtype}'"), shape, data)
}

/// An array with any type description.
pub fn structured(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    with_header(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}"), data)
}

/// An array with any header.
pub fn with_header(header: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{header}{}\n", " ".repeat(63 - (header.len() + 10) % 64));
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

pub fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

/// `numpy.savez`.
pub fn npz<B: AsRef<[u8]>>(arrays: &[(&str, B)]) -> Vec<u8> {
    archive(arrays, CompressionMethod::Stored)
}

/// `numpy.savez_compressed`.
pub fn npz_deflated<B: AsRef<[u8]>>(arrays: &[(&str, B)]) -> Vec<u8> {
    archive(arrays, CompressionMethod::Deflated)
}

fn archive<B: AsRef<[u8]>>(arrays: &[(&str, B)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, array) in arrays {
        let options = SimpleFileOptions::default().compression_method(method).large_file(true);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(array.as_ref()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}
