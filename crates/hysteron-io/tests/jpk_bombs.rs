//! Archives of JPK made to fill the memory or to take long: each is read or refused within 1 GiB and 10 s.
#![allow(clippy::unwrap_used)]

mod damage;

use std::io::{Cursor, Write};

use damage::child::{Bomb, each_within_limits, read_given};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

#[test]
#[ignore = "reads the file that the other tests give it, in a process of its own"]
fn reads_the_file_given() {
    read_given();
}

/// How a channel of floats is described.
const FLOATS: &str = "lcd-info.0.type=float-data\nlcd-info.0.unit.unit=V\n";
/// A segment of such a channel.
const SEGMENT: &str = "force-segment-header.duration=1.0\nchannel.height.lcd-info.*=0\n";

/// An archive that is put together by hand: entries that are deflated once may stand in it many times.
#[derive(Default)]
struct Archive {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    entries: u64,
}

/// Contents of an entry: where they stand, how they are packed, and how long they are said to be.
#[derive(Clone, Copy)]
struct Stored {
    start: u32,
    packed: u32,
    size: u32,
    crc: u32,
}

impl Archive {
    /// Local header and deflated contents.
    fn store(&mut self, contents: &[u8]) -> Stored {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        zip.start_file("x", options).unwrap();
        zip.write_all(contents).unwrap();
        let one = zip.finish().unwrap().into_inner();
        let directory = one.windows(4).rposition(|bytes| bytes == b"PK\x01\x02").unwrap();
        let word =
            |at: usize| u32::from_le_bytes(one[directory + at..directory + at + 4].try_into().unwrap());
        let stored =
            Stored { start: self.bytes.len() as u32, packed: word(20), size: word(24), crc: word(16) };
        self.bytes.extend(&one[..directory]);
        stored
    }

    /// An entry of the directory.
    fn list(&mut self, name: &str, stored: Stored) {
        let Stored { start, packed, size, crc } = stored;
        self.directory.extend(b"PK\x01\x02");
        self.directory.extend([20u16, 20, 0, 8, 0, 0].map(u16::to_le_bytes).concat());
        self.directory.extend([crc, packed, size].map(u32::to_le_bytes).concat());
        self.directory.extend([name.len() as u16, 0, 0, 0, 0, 0, 0].map(u16::to_le_bytes).concat());
        self.directory.extend(start.to_le_bytes());
        self.directory.extend(name.as_bytes());
        self.entries += 1;
    }

    fn add(&mut self, name: &str, contents: &[u8]) {
        let stored = self.store(contents);
        self.list(name, stored);
    }

    /// The file, with a directory of 64 bits.
    fn finish(self) -> Vec<u8> {
        let Archive { mut bytes, directory, entries } = self;
        let (start, length) = (bytes.len() as u64, directory.len() as u64);
        bytes.extend(directory);
        let end = bytes.len() as u64;
        bytes.extend(b"PK\x06\x06");
        bytes.extend(44u64.to_le_bytes());
        bytes.extend([45u16, 45].map(u16::to_le_bytes).concat());
        bytes.extend([0u32; 2].map(u32::to_le_bytes).concat());
        bytes.extend([entries, entries, length, start].map(u64::to_le_bytes).concat());
        bytes.extend(b"PK\x06\x07");
        bytes.extend(0u32.to_le_bytes());
        bytes.extend(end.to_le_bytes());
        bytes.extend(1u32.to_le_bytes());
        bytes.extend(b"PK\x05\x06");
        bytes.extend([0u16, 0, u16::MAX, u16::MAX].map(u16::to_le_bytes).concat());
        bytes.extend([u32::MAX; 2].map(u32::to_le_bytes).concat());
        bytes.extend([0, 0]);
        bytes
    }

    /// An archive with a general and a shared list of properties.
    fn of(shared: &str) -> Self {
        let mut archive = Archive::default();
        archive.add("header.properties", b"jpk-data-file=spm-forcefile\n");
        archive.add("shared-data/header.properties", shared.as_bytes());
        archive
    }
}

/// Entries that unpack to very much.
fn deflated() -> Vec<Bomb> {
    let zeros = |mb: usize| vec![0; mb << 20];
    vec![
        (
            "properties of 300 MB",
            Box::new(move || {
                let mut archive = Archive::default();
                archive.add("header.properties", &zeros(300));
                archive.finish()
            }),
            Some("`header.properties` has more than"),
        ),
        (
            "an array of 300 MB",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                archive.add("segments/0/segment-header.properties", SEGMENT.as_bytes());
                archive.add("segments/0/channels/height.dat", &zeros(300));
                archive.finish()
            }),
            Some("max_bytes"),
        ),
        (
            "an array that is said to be 4 GB",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                archive.add("segments/0/segment-header.properties", SEGMENT.as_bytes());
                let stored = archive.store(&zeros(1));
                archive.list("segments/0/channels/height.dat", Stored { size: u32::MAX - 1, ..stored });
                archive.finish()
            }),
            Some("cannot have the 4294967294 bytes"),
        ),
        (
            "an array that is said to be short",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                archive.add("segments/0/segment-header.properties", SEGMENT.as_bytes());
                let stored = archive.store(&zeros(300));
                archive.list("segments/0/channels/height.dat", Stored { size: 400, ..stored });
                archive.finish()
            }),
            Some("height"),
        ),
        (
            "one array under 2000 names",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                let header = archive.store(SEGMENT.as_bytes());
                let array = archive.store(&zeros(16));
                for segment in 0..2000 {
                    archive.list(&format!("segments/{segment}/segment-header.properties"), header);
                    archive.list(&format!("segments/{segment}/channels/height.dat"), array);
                }
                archive.finish()
            }),
            Some("numbers to keep"),
        ),
        (
            "properties of 4 MB under 2000 names",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                let lines: String = (0..200_000).map(|k| format!("channel.{k}.x=1\n")).collect();
                let header = archive.store(lines.as_bytes());
                let array = archive.store(&[0; 400]);
                for segment in 0..2000 {
                    archive.list(&format!("segments/{segment}/segment-header.properties"), header);
                    archive.list(&format!("segments/{segment}/channels/height.dat"), array);
                }
                archive.finish()
            }),
            Some("more than 33554432 bytes"),
        ),
    ]
}

/// Very many entries, curves, segments, channels, conversions.
fn many() -> Vec<Bomb> {
    let channels = |shared: String, count: usize, name: fn(usize) -> String| {
        let mut archive = Archive::of(&shared);
        let array = archive.store(&[0; 400]);
        (0..count).for_each(|k| archive.list(&name(k), array));
        archive.finish()
    };
    let conversions = |count: usize| {
        let mut shared = "lcd-info.0.encoder.type=signedshort\nlcd-info.0.encoder.scaling.offset=0\n\
            lcd-info.0.encoder.scaling.multiplier=1\nlcd-info.0.conversion-set.conversions.base=s\n"
            .to_owned();
        let names: Vec<String> = (0..count).map(|k| format!("s{k}")).collect();
        shared += &format!("lcd-info.0.conversion-set.conversions.list={}\n", names.join(" "));
        for (k, name) in names.iter().enumerate() {
            let key = format!("lcd-info.0.conversion-set.conversion.{name}");
            let base = if k == 0 { "s".to_owned() } else { format!("s{}", k - 1) };
            shared += &format!("{key}.base-calibration-slot={base}\n{key}.scaling.offset=0\n");
            shared += &format!("{key}.scaling.multiplier=2\n{key}.scaling.unit.unit=m\n");
        }
        shared + "channel.height.lcd-info.*=0\n"
    };
    vec![
        (
            "300 000 channels",
            Box::new(move || {
                channels(FLOATS.to_owned(), 300_000, |k| format!("segments/0/channels/{k}.dat"))
            }),
            None,
        ),
        (
            "300 000 segments",
            Box::new(move || {
                channels(FLOATS.to_owned(), 300_000, |k| format!("segments/{k}/channels/height.dat"))
            }),
            None,
        ),
        (
            "300 000 segments of nine units",
            Box::new(move || {
                channels(conversions(8), 300_000, |k| format!("segments/{k}/channels/height.dat"))
            }),
            None,
        ),
        (
            "four thousand segments of 32 channels of nine units",
            Box::new(move || {
                let shared: String = (0..32).map(|k| format!("channel.{k}.lcd-info.*=0\n")).collect();
                channels(conversions(8) + &shared, 4096 * 32, |k| {
                    format!("segments/{}/channels/{}.dat", k / 32, k % 32)
                })
            }),
            None,
        ),
        (
            "sixty thousand curves of two segments of nine units",
            Box::new(move || {
                channels(conversions(8), 120_000, |k| {
                    format!("index/{}/segments/{}/channels/height.dat", k / 2, k % 2)
                })
            }),
            None,
        ),
        (
            "300 000 curves of nine units",
            Box::new(move || {
                channels(conversions(8), 300_000, |k| format!("index/{k}/segments/0/channels/height.dat"))
            }),
            None,
        ),
        (
            "conversions that lead to one another",
            Box::new(move || {
                let shared = conversions(8).replace("slot=s\n", "slot=s7\n");
                channels(shared, 1000, |k| format!("segments/{k}/channels/height.dat"))
            }),
            None,
        ),
        (
            "four thousand conversions",
            Box::new(move || {
                channels(conversions(4000), 1000, |k| format!("segments/{k}/channels/height.dat"))
            }),
            None,
        ),
        (
            "names of 60 kB",
            Box::new(move || {
                channels(FLOATS.to_owned(), 1000, |k| {
                    format!("segments/{k}/channels/{}.dat", "a".repeat(60_000))
                })
            }),
            None,
        ),
    ]
}

/// Archives within one another, and entries that overlap.
fn nested() -> Vec<Bomb> {
    let inner = || {
        let mut archive = Archive::of(FLOATS);
        archive.add("segments/0/channels/height.dat", &vec![0; 64 << 20]);
        archive.finish()
    };
    vec![
        (
            "an archive within an archive",
            Box::new(move || {
                let mut archive = Archive::of(FLOATS);
                archive.add("segments/0/segment-header.properties", SEGMENT.as_bytes());
                archive.add("segments/0/channels/height.dat", &inner());
                archive.finish()
            }),
            None,
        ),
        (
            "an entry that holds the directory",
            Box::new(|| {
                let mut archive = Archive::of(FLOATS);
                archive.add("segments/0/segment-header.properties", SEGMENT.as_bytes());
                let stored = archive.store(&[0; 400]);
                let whole = Stored { packed: 1 << 30, size: 1 << 30, ..stored };
                archive.list("segments/0/channels/height.dat", whole);
                archive.finish()
            }),
            None,
        ),
        (
            "2^60 entries that are not there",
            Box::new(|| {
                let mut archive = Archive::of(FLOATS);
                archive.entries = 1 << 60;
                archive.finish()
            }),
            None,
        ),
    ]
}

#[test]
fn each_is_read_or_refused_within_1_gib_and_10_s() {
    each_within_limits("bomb.jpk-force", [deflated(), many(), nested()].into_iter().flatten());
}
