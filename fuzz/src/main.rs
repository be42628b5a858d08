//! One entry in libFuzzer, named when it is built: its code alone is linked, so that an execution does not clear and
//! read the counters of all others.
#![no_main]

use hysteron_fuzz::Entry;

const ENTRY: Entry = match hysteron_fuzz::entry(env!("HYSTERON_FUZZ")) {
    Some(entry) => entry,
    None => panic!("HYSTERON_FUZZ names an entry of hysteron_fuzz::ENTRIES"),
};

libfuzzer_sys::fuzz_target!(|data: &[u8]| (ENTRY.take)(data));
