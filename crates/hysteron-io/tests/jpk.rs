//! JPK force archives: the numbers that afmformats reads, and that no damage makes the reader panic.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

mod damage;
mod oracle;

use std::io::{Cursor, Write};

use hysteron_io::{ReadOptions, contents_of_bytes, read_record_bytes};
use hysteron_model::record::{Record, TimeBase};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Properties shared by the segments: heights in volts, scaled to a nominal and a calibrated height.
const SHARED: &str = "lcd-info.0.encoder.type=signedshort\n\
    lcd-info.0.encoder.scaling.style=offsetmultiplier\n\
    lcd-info.0.encoder.scaling.offset=1.0\nlcd-info.0.encoder.scaling.multiplier=0.5\n\
    lcd-info.0.encoder.scaling.unit.unit=V\nlcd-info.0.conversion-set.conversions.list=nominal calibrated\n\
    lcd-info.0.conversion-set.conversions.default=calibrated\n\
    lcd-info.0.conversion-set.conversions.base=volts\n\
    lcd-info.0.conversion-set.conversion.nominal.base-calibration-slot=volts\n\
    lcd-info.0.conversion-set.conversion.nominal.scaling.offset=0.0\n\
    lcd-info.0.conversion-set.conversion.nominal.scaling.multiplier=2.0\n\
    lcd-info.0.conversion-set.conversion.nominal.scaling.unit.unit=m\n\
    lcd-info.0.conversion-set.conversion.calibrated.base-calibration-slot=nominal\n\
    lcd-info.0.conversion-set.conversion.calibrated.scaling.offset=-1.0\n\
    lcd-info.0.conversion-set.conversion.calibrated.scaling.multiplier=3.0\n\
    lcd-info.0.conversion-set.conversion.calibrated.scaling.unit.unit=m\nlcd-info.1.type=float-data\n\
    lcd-info.1.unit.unit=V\n";

/// An archive of one curve with two segments of three and two samples, the second as long as given.
fn archive(second_duration_s: f64) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let mut add = |name: &str, bytes: &[u8]| {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        zip.start_file(name, options).unwrap();
        zip.write_all(bytes).unwrap();
    };
    add("header.properties", b"jpk-data-file=spm-forcefile\nfile-format-version=2.0\n");
    add("shared-data/header.properties", SHARED.as_bytes());
    for (segment, heights, duration_s) in [(0, &[0i16, 2, -4][..], 3.0), (1, &[6, 8][..], second_duration_s)]
    {
        let header = format!(
            "force-segment-header.duration={duration_s}\nchannel.height.lcd-info.*=0\n\
             channel.vDeflection.lcd-info.*=1\n"
        );
        add(&format!("segments/{segment}/segment-header.properties"), header.as_bytes());
        let raw: Vec<u8> = heights.iter().flat_map(|height| height.to_be_bytes()).collect();
        add(&format!("segments/{segment}/channels/height.dat"), &raw);
        let raw: Vec<u8> = heights.iter().flat_map(|&height| f32::from(height).to_be_bytes()).collect();
        add(&format!("segments/{segment}/channels/vDeflection.dat"), &raw);
    }
    zip.finish().unwrap().into_inner()
}

fn read(bytes: &[u8], input: &str, output: &str) -> Record {
    let (input, output) = (Some(input.to_owned()), Some(output.to_owned()));
    read_record_bytes("curve.jpk-force", bytes, &ReadOptions { input, output, ..ReadOptions::default() })
        .unwrap()
}

#[test]
fn the_values_are_those_that_afmformats_reads() {
    let Some((_folder, cases)) = oracle::written_by("jpk.py") else { return };
    assert!(cases.len() >= 200, "{} files", cases.len());
    assert!(oracle::compare(&cases) >= 5 * cases.len());
    eprintln!("{} files", cases.len());
}

#[test]
fn a_curve_is_read_over_its_segments_in_each_of_its_units() {
    let bytes = archive(2.0);
    let record = read(&bytes, "height:volts", "height");
    assert_eq!(record.channels[0].samples, [1.0, 2.0, -1.0, 4.0, 5.0]);
    assert_eq!(record.channels[0].unit.symbol(), "V");
    assert_eq!(record.channels[1].samples, [5.0, 11.0, -7.0, 23.0, 29.0]);
    assert_eq!(record.time, TimeBase::uniform(1.0));
    let record = read(&bytes, "segments/1/vDeflection", "segments/1/height");
    assert_eq!(record.channels[1].samples, [6.0, 8.0]);
}

#[test]
fn segments_of_different_rates_have_a_time_column() {
    let record = read(&archive(4.0), "vDeflection", "height");
    assert_eq!(record.time, TimeBase::NonUniform { times_s: vec![0.0, 1.0, 2.0, 3.0, 5.0] });
}

#[test]
fn the_channels_are_listed_with_their_units() {
    let listed = contents_of_bytes("curve.jpk-force", &archive(2.0), &ReadOptions::default()).unwrap();
    let paths: Vec<&str> = listed.iter().map(|content| content.path.as_str()).collect();
    for path in ["height", "height:nominal", "segments/0/height:volts", "segments/1/vDeflection"] {
        assert!(paths.contains(&path), "no {path} in {paths:?}");
    }
}

#[test]
fn a_damaged_file_is_read_or_refused() {
    damage::survive("curve.jpk-force", &[&archive(2.0), &archive(4.0)], 1000, 20);
}
