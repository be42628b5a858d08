//! What a hostile or broken file may do: nothing but be refused.
//!
//! Every entry of [`ENTRIES`] takes bytes as a fuzzer makes them, hands them to a part of the library that reads
//! what others wrote, and checks what it must keep to: no panic, no number that is not finite where none is
//! promised, what was written is read back the same. The binary of this crate is such an entry in libFuzzer;
//! `tests/corpus.rs` replays the inputs of `corpus/`.
#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::panic, reason = "a check that fails is found by its panic")]

#[cfg(feature = "app")]
mod app;
#[cfg(feature = "bench")]
mod bench;
#[cfg(feature = "checkpoint")]
mod checkpoint;
#[cfg(feature = "stages")]
mod exported;
mod model;
mod numbers;
mod prepare;
mod readers;
#[cfg(feature = "stages")]
mod runtime;

/// A part of the library that reads what others wrote.
pub struct Entry {
    /// Name, also that of the folder of its inputs.
    pub name: &'static str,
    /// Takes an input; panics where a promise is broken.
    pub take: fn(&[u8]),
}

/// All of them, as far as the features of this crate go.
pub const ENTRIES: &[Entry] = &[
    Entry { name: "csv", take: readers::csv },
    Entry { name: "gcs", take: readers::gcs },
    Entry { name: "hdf5", take: readers::hdf5 },
    Entry { name: "jpk", take: readers::jpk },
    Entry { name: "lvm", take: readers::lvm },
    Entry { name: "mat", take: readers::mat },
    Entry { name: "npy", take: readers::npy },
    Entry { name: "npz", take: readers::npz },
    Entry { name: "tdms", take: readers::tdms },
    Entry { name: "xlsx", take: readers::xlsx },
    Entry { name: "response", take: readers::response },
    Entry { name: "model", take: model::file },
    Entry { name: "model-numbers", take: model::numbers },
    #[cfg(feature = "bench")]
    Entry { name: "truth-and-plan", take: bench::truth_and_plan },
    #[cfg(feature = "bench")]
    Entry { name: "drive", take: bench::drive },
    #[cfg(feature = "checkpoint")]
    Entry { name: "checkpoint", take: checkpoint::searches },
    Entry { name: "prepare", take: prepare::prepare },
    #[cfg(feature = "app")]
    Entry { name: "app", take: app::request },
    #[cfg(feature = "stages")]
    Entry { name: "runtime", take: runtime::steps },
    #[cfg(feature = "stages")]
    Entry { name: "exported-c", take: exported::steps },
];

/// The entry of a name, known when a fuzzer is built.
pub const fn entry(name: &str) -> Option<Entry> {
    let mut k = 0;
    while k < ENTRIES.len() {
        if alike(ENTRIES[k].name.as_bytes(), name.as_bytes()) {
            return Some(Entry { name: ENTRIES[k].name, take: ENTRIES[k].take });
        }
        k += 1;
    }
    None
}

const fn alike(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    k == a.len() && k == b.len()
}
