//! The model file of an identified oscillator.

use std::collections::BTreeMap;

use hysteron_model::Start;
use hysteron_model::model_file::{
    Maker, OscillatorFile, Provenance, RecordEntry, RecordRole, ScoreEntry, ScoreRole, SignalUnits,
    ValidRange,
};

use super::{Identification, Options};

impl Identification {
    /// Model file: parameters with standard errors, range of validity, provenance with these `options`,
    /// scores.
    pub fn model_file(&self, options: &Options, maker: &Maker) -> OscillatorFile {
        let first = self.records.first();
        let signals =
            first.map_or_else(SignalUnits::default, |r| SignalUnits::of(&r.data.u_unit, &r.data.y_unit));
        let rate = first.and_then(|r| r.data.sample_rate_hz()).unwrap_or(1.0);
        let mut file = OscillatorFile::new(&self.oscillator, signals.clone(), self.inter_sample, rate);
        for (quantity, estimate) in file.parameters.all_mut().into_iter().zip(&self.estimates) {
            quantity.std_error = estimate.std_error;
        }
        file.offset.value = self.offset;
        if first.is_some_and(|r| r.period_samples.is_some()) {
            file.set_start(Start::PERIODIC);
        }
        let forces = self.records.iter().flat_map(|r| &r.data.u);
        let slopes = self.records.iter().flat_map(|r| {
            let rate = r.data.sample_rate_hz().unwrap_or(0.0);
            r.data.u.windows(2).map(move |w| (w[1] - w[0]).abs() * rate)
        });
        let range = ValidRange::of_inputs(forces, &signals.input, Some(self.excited_hz));
        file.valid_range = Some(range.with_rate(slopes.fold(0.0, f64::max)));
        let records = self.records.iter().map(|r| RecordEntry::of(&r.data, RecordRole::Both)).collect();
        file.provenance = Some(Provenance::new(maker, records, self.named(options), None));
        let score = |r: &super::RecordFit| {
            ScoreEntry::new(&r.data.name, ScoreRole::Training, r.data.y_unit.symbol(), &r.scores)
        };
        file.scores = self.records.iter().map(score).collect();
        file
    }

    /// Options in force by name.
    fn named(&self, options: &Options) -> BTreeMap<String, String> {
        let mut named = BTreeMap::from([
            ("structure".to_owned(), "oscillator".to_owned()),
            ("initial".to_owned(), options.initial.name().to_owned()),
            ("inter-sample".to_owned(), self.inter_sample.name().to_owned()),
        ]);
        named.extend(options.fixed.iter().map(|(name, value)| (format!("fix {name}"), value.to_string())));
        named
    }
}
