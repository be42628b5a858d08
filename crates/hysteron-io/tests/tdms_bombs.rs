//! TDMS files made to fill the memory or to take long: each is read or refused within 1 GiB and 10 s.
#![allow(clippy::unwrap_used)]

mod damage;

use damage::child::{Bomb, each_within_limits, read_given};

#[test]
#[ignore = "reads the file that the other tests give it, in a process of its own"]
fn reads_the_file_given() {
    read_given();
}

/// A segment: its contents by the bits of the table, metadata and raw data, and the lengths of both that it
/// tells.
fn segment(flags: u32, metadata: &[u8], raw: &[u8]) -> Vec<u8> {
    let mut bytes = b"TDSm".to_vec();
    bytes.extend([flags, 4713].map(u32::to_le_bytes).concat());
    let lengths = [(metadata.len() + raw.len()) as u64, metadata.len() as u64];
    bytes.extend(lengths.map(u64::to_le_bytes).concat());
    bytes.extend(metadata);
    bytes.extend(raw);
    bytes
}

/// Metadata, a new list of objects, raw data.
const NEW: u32 = 0b1110;
const METADATA: u32 = 0b10;
const RAW: u32 = 0b1000;
const INTERLEAVED: u32 = 0b10_0000;

fn text(text: &[u8]) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text].concat()
}

/// An object with values of a type in each chunk and properties.
fn object(path: &str, index: &[u32], properties: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = text(path.as_bytes());
    bytes.extend(index.iter().flat_map(|word| word.to_le_bytes()));
    bytes.extend((properties.len() as u32).to_le_bytes());
    bytes.extend(properties.concat());
    bytes
}

/// Index of a channel of this type and number of values in a chunk.
fn values(data_type: u32, count: u64) -> [u32; 5] {
    [20, data_type, 1, count as u32, (count >> 32) as u32]
}

const NO_DATA: [u32; 1] = [u32::MAX];
const DOUBLE: u32 = 10;
const BYTE: u32 = 5;
const TEXT: u32 = 0x20;

fn objects(of: &[Vec<u8>]) -> Vec<u8> {
    [&(of.len() as u32).to_le_bytes()[..], &of.concat()].concat()
}

fn channel(number: usize) -> String {
    format!("/'g'/'c{number}_V'")
}

/// Lengths and numbers far beyond the file.
fn huge_numbers() -> Vec<Bomb> {
    let doubles =
        |count| segment(NEW, &objects(&[object(&channel(0), &values(DOUBLE, count), &[])]), &[0; 64]);
    // One object, and what follows its path.
    let behind = |path: &[u8], bytes: &[u8]| segment(NEW, &[&[1, 0, 0, 0], path, bytes].concat(), &[0; 64]);
    let long: &'static [u8] = &[0xFF; 4];
    let name = || text(channel(0).as_bytes());
    vec![
        ("values beyond counting", Box::new(move || doubles(u64::MAX)), Some("values in a chunk")),
        ("values of 2^63 bytes", Box::new(move || doubles(1 << 60)), None),
        ("a path of 4 GiB", Box::new(move || behind(long, &[])), Some("it ends at byte")),
        (
            "a property of 4 GiB",
            Box::new(move || behind(&name(), &[long, &[1, 0, 0, 0], long].concat())),
            Some("it ends at byte"),
        ),
        ("2^32 properties", Box::new(move || behind(&name(), &[0xFF; 8])), Some("it ends at byte")),
        (
            "2^32 scalers",
            Box::new(move || behind(&name(), &[&0x1269u32.to_le_bytes()[..], &[0; 16], long].concat())),
            Some("it ends at byte"),
        ),
        ("2^32 objects", Box::new(move || segment(NEW, long, &[0; 64])), Some("it ends at byte")),
        (
            "texts of 2^64 bytes",
            Box::new(|| {
                let index = [&values(TEXT, u64::MAX)[..], &[u32::MAX; 2]].concat();
                segment(NEW, &objects(&[object(&channel(0), &index, &[])]), &[0; 64])
            }),
            None,
        ),
    ]
}

/// Objects and properties, very many or very long.
fn objects_and_properties() -> Vec<Bomb> {
    let of_path = |path: &str| segment(NEW, &objects(&[object(path, &NO_DATA, &[])]), &[]);
    let with_properties = |name: &str, value: &[u8], count: u32| {
        let property = |k: u32| [&text(format!("{name}{k}").as_bytes())[..], value].concat();
        let all: Vec<_> = (0..count).map(property).collect();
        segment(NEW, &objects(&[object("/", &NO_DATA, &all)]), &[])
    };
    vec![
        (
            "a million objects",
            Box::new(|| {
                let all: Vec<_> = (0..1_000_000).map(|k| object(&channel(k), &NO_DATA, &[])).collect();
                segment(NEW, &objects(&all), &[])
            }),
            Some("more than 4096 objects"),
        ),
        (
            "a path of 200 components",
            Box::new(move || of_path(&"/'a'".repeat(200))),
            Some("no path of an object"),
        ),
        (
            "a path of two million components",
            Box::new(move || of_path(&"/'a'".repeat(2_000_000))),
            Some("a path of more than 1024 bytes"),
        ),
        (
            "two million properties",
            Box::new(move || with_properties("", &[BYTE as u8, 0, 0, 0, 7], 2_000_000)),
            Some("it holds no channels"),
        ),
        (
            "a million scales",
            Box::new(move || with_properties("NI_", &[TEXT as u8, 0, 0, 0, 0, 0, 0, 0], 1_000_000)),
            Some("more than 262144 properties"),
        ),
        (
            "scales with long texts",
            Box::new(move || {
                let value = [&TEXT.to_le_bytes()[..], &text(&[b'a'; 100_000])].concat();
                with_properties("NI_", &value, 800)
            }),
            Some("it holds no channels"),
        ),
    ]
}

/// Segments, very many of them.
fn segments() -> Vec<Bomb> {
    let list = |channels: usize, per_chunk: u64| {
        let all: Vec<_> = (0..channels).map(|k| object(&channel(k), &values(BYTE, per_chunk), &[])).collect();
        segment(NEW, &objects(&all), &vec![0; 3 * channels])
    };
    let one = |number: usize, count: u64| objects(&[object(&channel(number), &values(BYTE, count), &[])]);
    let tail =
        move |channels: usize, flags: u32, metadata: &'static [u8], raw: &'static [u8], count: usize| {
            let own = segment(flags, metadata, raw);
            Box::new(move || [list(channels, 3), own.repeat(count)].concat()) as Box<dyn Fn() -> Vec<u8>>
        };
    let defragment = Some("defragment the file");
    vec![
        ("a million segments of a byte", tail(1, RAW, &[], &[1], 1_000_000), None),
        ("a million of them, of 4000 channels", tail(4000, RAW, &[], &[1], 1_000_000), defragment),
        ("a million of them, of 20 channels", tail(20, RAW, &[], &[1], 1_000_000), None),
        ("200 000 interleaved", tail(4000, RAW | INTERLEAVED, &[], &[1; 64], 200_000), defragment),
        ("a million without data", tail(4000, RAW, &[], &[], 1_000_000), None),
        (
            "700 000 whose metadata change nothing",
            tail(4000, METADATA | RAW, &[0; 4], &[1], 700_000),
            defragment,
        ),
        (
            "30 000 segments of 4000 channels, of one length or two",
            Box::new(move || {
                let two = [segment(RAW, &[], &[1; 5000]), segment(RAW, &[], &[1; 7000])].concat();
                [list(4000, 3), two.repeat(2500), segment(RAW, &[], &[1]).repeat(25_000)].concat()
            }),
            None,
        ),
        (
            "five hundred layouts of 4000 channels",
            Box::new(move || {
                let change = |k: u64| segment(METADATA | RAW, &one(0, 3 + k % 2), &[0; 3]);
                [list(4000, 3), (0..500).flat_map(change).collect()].concat()
            }),
            None,
        ),
        (
            "as many rests as segments",
            Box::new(move || {
                let one = |k: usize| segment(RAW, &[], &vec![1; 1 + k % 11_999]);
                [list(4000, 3), (0..3000).flat_map(one).collect()].concat()
            }),
            defragment,
        ),
        (
            "layouts in turn",
            Box::new(move || {
                let two = [segment(NEW, &one(0, 3), &[0; 3]), segment(NEW, &one(1, 3), &[0; 3])].concat();
                [list(4000, 3), two.repeat(400_000)].concat()
            }),
            None,
        ),
        (
            "a long list that changes",
            Box::new(move || {
                let change = |k: u64| segment(METADATA | RAW, &one(0, 3 + k % 2), &[0; 3]);
                [list(4000, 3), (0..300_000).flat_map(change).collect()].concat()
            }),
            defragment,
        ),
        ("ten million chunks", Box::new(move || segment(NEW, &one(0, 1), &vec![1; 10_000_000])), None),
    ]
}

#[test]
fn each_is_read_or_refused_within_1_gib_and_10_s() {
    each_within_limits(
        "bomb.tdms",
        [huge_numbers(), objects_and_properties(), segments()].into_iter().flatten(),
    );
}
