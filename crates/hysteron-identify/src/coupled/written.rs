//! The model file of identified branches.

use std::collections::BTreeMap;

use hysteron_model::axes::AxesRecord;
use hysteron_model::model_file::{CoupledFile, Maker, Provenance, RecordEntry, SignalUnits, ValidRange};

use super::CoupledIdentification;

impl CoupledIdentification {
    /// Model file: parameters with standard errors, range of validity, provenance with these `records`.
    pub fn model_file(&self, records: &[AxesRecord], maker: &Maker) -> CoupledFile {
        let first = records.first();
        let units = first.map_or_else(SignalUnits::default, |r| SignalUnits::of(&r.u_unit, &r.y_unit));
        let names = first.map_or_else(Default::default, |r| (r.inputs.clone(), r.outputs.clone()));
        let mut file = CoupledFile::new(&self.model, self.errors.as_ref(), units.clone(), names);
        let inputs = records.iter().flat_map(|r| r.u.iter().flatten());
        file.valid_range = Some(ValidRange::of_inputs(inputs, &units.input, None));
        let options = BTreeMap::from([("structure".to_owned(), "hammerstein".to_owned())]);
        let records = records.iter().map(RecordEntry::of_axes).collect();
        file.provenance = Some(Provenance::new(maker, records, options, None));
        file
    }
}
