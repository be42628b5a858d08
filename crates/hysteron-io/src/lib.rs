//! File formats of measured records: file to `Record` and back.
#![forbid(unsafe_code)]
