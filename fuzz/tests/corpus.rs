//! Every input of the corpus, those that once broke a promise among them, taken again.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::Path;

#[test]
fn every_input_of_the_corpus_is_taken() {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    for entry in hysteron_fuzz::ENTRIES {
        let folder = corpus.join(entry.name);
        let mut taken = 0;
        for input in std::fs::read_dir(&folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display())) {
            let path = input.unwrap().path();
            // Shown where the input breaks a promise.
            println!("{}", path.display());
            (entry.take)(&std::fs::read(&path).unwrap());
            taken += 1;
        }
        assert!(taken > 0, "{} has no input", folder.display());
    }
}
