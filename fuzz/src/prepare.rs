//! Preparation of a record: steps as JSON, a byte 0, the record as text.

use hysteron_io::{ReadOptions, read_record_bytes};
use hysteron_model::record::Prepare;

pub fn prepare(data: &[u8]) {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let (steps, text) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let Ok(steps) = serde_json::from_slice::<Prepare>(steps) else { return };
    let options = ReadOptions { max_bytes: 1 << 20, max_values: 1 << 12, ..ReadOptions::default() };
    let records: Vec<_> = text
        .split(|byte| *byte == 0)
        .take(3)
        .filter_map(|text| read_record_bytes("a.csv", text, &options).ok())
        .collect();
    if let Ok(prepared) = steps.run(&records) {
        let samples = prepared.record.channels.iter().flat_map(|channel| &channel.samples);
        assert!(samples.into_iter().all(|x| x.is_finite()), "a sample is not finite");
    }
}
