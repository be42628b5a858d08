//! The model file of an identified force.

use std::collections::BTreeMap;

use hysteron_model::model_file::{
    ForceFile, Maker, Provenance, RecordEntry, RecordRole, ScoreEntry, ScoreRole, SignalUnits, ValidRange,
};

use super::{Identification, Options};

impl Identification {
    /// Model file: numbers with standard errors, range of validity, provenance with these `options`, scores.
    pub fn model_file(&self, options: &Options, maker: &Maker) -> ForceFile {
        let first = self.records.first();
        let signals =
            first.map_or_else(SignalUnits::default, |r| SignalUnits::of(&r.data.u_unit, &r.data.y_unit));
        let rate = first.and_then(|r| r.data.sample_rate_hz());
        let mut file = ForceFile::new(&self.model, signals.clone(), rate);
        for estimate in &self.estimates {
            if let Some(quantity) = file.quantity_mut(&estimate.name) {
                quantity.std_error = estimate.std_error;
            }
        }
        let displacements = self.records.iter().flat_map(|r| &r.data.u);
        let range = ValidRange::of_inputs(displacements, &signals.input, Some(self.excited_hz));
        file.valid_range = Some(range.with_rate(self.fastest_rate));
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
            ("structure".to_owned(), "force".to_owned()),
            ("hysteresis".to_owned(), self.model.hysteresis.form().name().to_owned()),
            ("degree".to_owned(), options.degree.to_string()),
        ]);
        named.extend(options.fixed.iter().map(|(name, value)| (format!("fix {name}"), value.to_string())));
        named
    }
}
