//! One entry in libFuzzer: `HYSTERON_FUZZ=csv hysteron-fuzz CORPUS`.
#![no_main]
#![allow(clippy::expect_used, reason = "run by hand")]

use std::sync::LazyLock;

use hysteron_fuzz::Entry;

static ENTRY: LazyLock<&'static Entry> = LazyLock::new(|| {
    let name = std::env::var("HYSTERON_FUZZ").expect("HYSTERON_FUZZ names an entry");
    hysteron_fuzz::entry(&name).expect("HYSTERON_FUZZ names an entry of hysteron_fuzz::ENTRIES")
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| (ENTRY.take)(data));
