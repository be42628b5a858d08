//! The file of an oscillator read for use with records.

use std::path::{Path, PathBuf};

use hysteron_model::model_file::{OscillatorFile, StartKind, StoredModel};
use hysteron_model::oscillator::{Oscillator, OscillatorError, RecordStart};
use hysteron_model::record::{InputOutput, Unit, find_periods};
use hysteron_model::validate::{Scoring, score};

use crate::console;
use crate::failure::Failure;
use crate::model::{Signal, agreed_unit, cannot_read, remark_extrapolation};
use crate::start::{Drive, StartFlags};

/// An oscillator's file and the oscillator in it.
pub struct LoadedOscillator {
    path: PathBuf,
    pub file: OscillatorFile,
    oscillator: Oscillator,
}

impl LoadedOscillator {
    /// The oscillator in the model file at `path`; `None` where it holds another kind of model.
    ///
    /// # Errors
    /// If it cannot be read or is not sound.
    pub fn recognise(path: &Path) -> Result<Option<Self>, Failure> {
        let stored =
            hysteron_io::read_model_file(path, StoredModel::from_slice).map_err(|e| cannot_read(path, e))?;
        let StoredModel::Oscillator(file) = stored else { return Ok(None) };
        let oscillator = file.to_oscillator().map_err(|e| cannot_read(path, e))?;
        Ok(Some(Self { path: path.to_owned(), file: *file, oscillator }))
    }

    /// The unit that model and record agree on.
    ///
    /// # Errors
    /// If they disagree.
    pub fn agreed_unit(&self, record: &Path, signal: Signal, found: &Unit) -> Result<Unit, Failure> {
        agreed_unit((&self.path, &self.file.units), record, signal, found)
    }

    /// Displacement for the drive of the record at `path`, from the start the flags give, else the file's.
    ///
    /// # Errors
    /// If the drive has no sample rate or the motion cannot be simulated.
    pub fn simulate(&self, path: &Path, drive: &Drive, start: &StartFlags) -> Result<Vec<f64>, Failure> {
        let start = match start.of_oscillator(path, drive)? {
            Some(start) => start,
            None => self.own_start(drive).unwrap_or_else(|| {
                console::note(&format!(
                    "{}: the model was identified on settled periodic records; this drive does not repeat and is taken to start \
                     at rest (--settled says otherwise)",
                    path.display()
                ));
                RecordStart::Rest
            }),
        };
        remark_extrapolation(self.file.valid_range.as_ref(), path, drive.u);
        self.run(path, drive, start)
    }

    /// Displacement for the record, from the start the flags give, else from the one that explains it best: rest, or settled on its
    /// period or on the whole record.
    ///
    /// # Errors
    /// As [`Self::simulate`], and if the record cannot be scored.
    pub fn simulate_record(
        &self,
        path: &Path,
        record: &InputOutput,
        flags: &StartFlags,
        scoring: &Scoring,
    ) -> Result<Vec<f64>, Failure> {
        let drive = Drive { u: &record.u, time: &record.time };
        if flags.are_given() {
            return self.simulate(path, &drive, flags);
        }
        remark_extrapolation(self.file.valid_range.as_ref(), path, drive.u);
        let own = self.own_start(&drive).unwrap_or(RecordStart::Rest);
        let whole = RecordStart::Settled { period_samples: record.len() };
        let mut starts = vec![own];
        starts.extend([RecordStart::Rest, whole].into_iter().filter(|start| *start != own));
        let mut best: Option<(f64, RecordStart, Vec<f64>)> = None;
        let mut failure = None;
        for start in starts {
            let simulated = match self.run(path, &drive, start) {
                Ok(simulated) => simulated,
                // A start that cannot be simulated is not the one.
                Err(e) => {
                    failure.get_or_insert(e);
                    continue;
                }
            };
            let rmse = score(record, &simulated, scoring)
                .map_err(|e| Failure::new(format!("cannot score {}", path.display())).because(e))?
                .rmse;
            if best.as_ref().is_none_or(|(least, ..)| rmse < *least) {
                best = Some((rmse, start, simulated));
            }
        }
        let Some((_, chosen, simulated)) = best else {
            return Err(
                failure.unwrap_or_else(|| Failure::new(format!("cannot simulate {}", path.display())))
            );
        };
        if chosen != own {
            console::note(&format!(
                "{}: simulated {}, which explains it better than {} (--settled says otherwise)",
                path.display(),
                in_words(chosen),
                in_words(own)
            ));
        }
        Ok(simulated)
    }

    fn run(&self, path: &Path, drive: &Drive, start: RecordStart) -> Result<Vec<f64>, Failure> {
        let failure =
            || Failure::new(format!("cannot simulate {} on {}", self.path.display(), path.display()));
        let Some(rate) = drive.sample_rate_hz() else {
            return Err(failure()
                .because("the record has no uniform sample rate: the motion of a mass cannot be followed")
                .hint(
                    "give the sample rate with --sample-rate HZ, or resample the record to a uniform time",
                ));
        };
        let rule = self.file.inter_sample.into();
        let mut y = self.oscillator.simulate_record(drive.u, rate, rule, start).map_err(|e| {
            let failure = failure().because(&e);
            match e {
                OscillatorError::NotSettled { .. } => {
                    failure.hint("leave --settled out: the record starts from rest")
                }
                _ => failure,
            }
        })?;
        y.iter_mut().for_each(|y| *y += self.file.offset.value);
        Ok(y)
    }

    /// The start the file assumes: for a settled one the drive's own period; `None` where it has none.
    fn own_start(&self, drive: &Drive) -> Option<RecordStart> {
        if self.file.start == StartKind::Rest {
            return Some(RecordStart::Rest);
        }
        // Only the drive counts for its period: it stands in for the output.
        let data = InputOutput::new("drive", drive.time.clone(), drive.u.to_vec(), drive.u.to_vec()).ok()?;
        let periods = find_periods(&data).ok().filter(|p| p.start == 0 && p.count >= 2)?;
        Some(RecordStart::Settled { period_samples: periods.period_samples.round() as usize })
    }
}

fn in_words(start: RecordStart) -> String {
    match start {
        RecordStart::Rest => "from rest".to_owned(),
        RecordStart::Settled { period_samples } => format!("settled on a period of {period_samples} samples"),
    }
}
