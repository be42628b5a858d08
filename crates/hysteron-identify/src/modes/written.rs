//! The model file of identified modes.

use std::collections::BTreeMap;

use hysteron_model::axes::AxesRecord;
use hysteron_model::model_file::{
    InfluenceEntry, Maker, ModesFile, ModesScoreEntry, Provenance, RecordEntry, SignalUnits, ValidRange,
};

use super::{ModesIdentification, ModesRecordFit, Options};

impl ModesIdentification {
    /// Model file: parameters, influence matrices, range of validity, provenance with these `records` and
    /// `options`, scores.
    pub fn model_file(&self, records: &[AxesRecord], options: &Options, maker: &Maker) -> ModesFile {
        let first = records.first();
        let units = first.map_or_else(SignalUnits::default, |r| SignalUnits::of(&r.u_unit, &r.y_unit));
        let (inputs, outputs) =
            first.map_or_else(Default::default, |r| (r.inputs.clone(), r.outputs.clone()));
        let quantities = self.quantities.iter().map(|q| q.entry(&inputs, &outputs, &units)).collect();
        let mut file = ModesFile::new(&self.model, units.clone(), inputs, outputs);
        file.quantities = quantities;
        file.influence = self.influence.iter().map(|i| InfluenceEntry::new(i.level, &i.matrix)).collect();
        let inputs = records.iter().flat_map(|r| r.u.iter().flatten());
        file.valid_range = Some(ValidRange::of_inputs(inputs, &units.input, Some(self.excited_hz)));
        let records = records.iter().map(RecordEntry::of_axes).collect();
        file.provenance = Some(Provenance::new(maker, records, named(options), None));
        let score = |r: &ModesRecordFit| ModesScoreEntry {
            record: r.record.clone(),
            level: r.level,
            rmse: r.rmse,
            output_rmse: r.output_rmse.clone(),
            fit_percent: r.fit_percent,
        };
        file.scores = self.records.iter().map(score).collect();
        file
    }
}

/// Options in force by name.
fn named(options: &Options) -> BTreeMap<String, String> {
    BTreeMap::from([
        ("structure".to_owned(), "modes".to_owned()),
        ("modes".to_owned(), options.modes.map_or_else(|| "auto".to_owned(), |n| n.to_string())),
        ("steps".to_owned(), options.steps.to_string()),
        ("plays".to_owned(), options.plays.to_string()),
        ("hysteresis".to_owned(), options.hysteresis.to_string()),
        ("iterations".to_owned(), options.iterations.to_string()),
        ("exponent".to_owned(), options.exponent.map_or_else(|| "auto".to_owned(), |p| p.to_string())),
    ])
}
