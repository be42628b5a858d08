//! Damaged files: cut off, bits flipped, lengths replaced by huge ones, parts taken out or doubled.
#![allow(clippy::unwrap_used, clippy::print_stdout, dead_code)]

pub mod child;

use std::time::{Duration, Instant};

use hysteron_io::{ReadOptions, contents_of_bytes, read_record_bytes};

/// Longest time that reading a damaged file may take.
const LONGEST: Duration = Duration::from_secs(10);
/// Most memory that it may take \[kB\].
const MOST_MEMORY_KB: u64 = 1 << 20;

/// Reads this many damaged copies of the files, repeatable by the seed, and returns how many of them still
/// read.
pub fn survive(name: &str, files: &[&[u8]], copies: usize, seed: u64) -> usize {
    let mut random = Random(seed.max(1));
    let mut read = 0;
    for copy in 0..copies {
        let mut bytes = files[copy % files.len()].to_vec();
        for _ in 0..=random.below(3) {
            random.damage(&mut bytes);
        }
        let start = Instant::now();
        let options = ReadOptions { input: Some("1".to_owned()), ..ReadOptions::default() };
        let _ = contents_of_bytes(name, &bytes, &options);
        let _ = read_record_bytes(name, &bytes, &options);
        read += usize::from(read_record_bytes(name, &bytes, &ReadOptions::default()).is_ok());
        assert!(start.elapsed() < LONGEST, "copy {copy} took {:?}", start.elapsed());
    }
    if let Some(peak) = peak_memory_kb() {
        assert!(peak < MOST_MEMORY_KB, "{peak} kB of memory");
    }
    read
}

/// Most memory that this process has taken so far; `None` where the system does not tell.
pub fn peak_memory_kb() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix(" kB"));
    Some(peak.unwrap().parse().unwrap())
}

/// Processor time of this process, which other work on the machine does not lengthen, to 10 ms; `None` where
/// the system does not tell.
pub fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // User and system time in hundredths of a second are the 14th and 15th field; the 2nd, in brackets, may
    // hold spaces.
    let fields = stat.rsplit_once(')')?.1.split_whitespace();
    let hundredths: u64 = fields.skip(11).take(2).map(|field| field.parse::<u64>().unwrap()).sum();
    Some(Duration::from_millis(10 * hundredths))
}

/// Xorshift.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    pub fn damage(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let at = self.below(bytes.len());
        match self.next() % 6 {
            0 => bytes.truncate(at),
            1 => bytes[at] ^= 1 << (self.next() % 8),
            2 => bytes[at] = self.next() as u8,
            3 => {
                let huge = [0xFF, 0x7F, 0x80, 0x00][self.below(4)];
                let width = [2, 4, 8][self.below(3)];
                bytes[at..].iter_mut().take(width).for_each(|byte| *byte = huge);
            }
            4 => {
                let end = (at + 1 + self.below(64)).min(bytes.len());
                bytes.drain(at..end);
            }
            _ => {
                let end = (at + 1 + self.below(64)).min(bytes.len());
                let part = bytes[at..end].to_vec();
                bytes.splice(at..at, part);
            }
        }
    }
}
