//! One entry in libFuzzer, named when it is built: its code alone is linked, so that an execution does not clear and
//! read the counters of all others.
#![no_main]

use hysteron_fuzz::Entry;

const ENTRY: Entry = match hysteron_fuzz::entry(env!("HYSTERON_FUZZ")) {
    Some(entry) => entry,
    None => panic!("HYSTERON_FUZZ names an entry of hysteron_fuzz::ENTRIES"),
};

/// Parallel loops on the thread of the fuzzer: handing the few samples of an input to another takes longer than they
/// do.
fn on_this_thread() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    if let Err(e) = pool.build_global() {
        panic!("{e}");
    }
}

libfuzzer_sys::fuzz_target!(init: on_this_thread(), |data: &[u8]| (ENTRY.take)(data));
