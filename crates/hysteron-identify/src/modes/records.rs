//! Preparation of the records for the fit.

use nalgebra::{DMatrix, DMatrixView};

use super::Options;
use crate::IdentifyError;
use crate::alike::same;
use hysteron_model::axes::{AxesRecord, SteadyPeriod};
use hysteron_model::hysteresis::RecordEnds;
use hysteron_model::record::{InterSample, Unit};

/// Least variance of any combination of the inputs of a record, as a share of that of its level, that counts as
/// driven independently.
const INDEPENDENT: f64 = 0.5;

/// Multiplications of the products of the derivatives of all records that take long, about a second.
const LONG: f64 = 2e10;

/// Levels that differ by less than this share are one.
const ONE_LEVEL: f64 = 0.05;

/// One period of a record.
#[derive(Clone, Debug)]
pub(super) struct RecordPeriod {
    pub period: SteadyPeriod,
    /// Inputs at every step, interleaved.
    pub fine: Vec<f64>,
    /// Number of its level, from the lowest.
    pub level: usize,
    /// Weight of a squared error.
    pub weight: f64,
}

/// rms error that, equal in all these records, has this cost.
pub(super) fn error_of(cost: f64, pieces: &[&RecordPeriod]) -> Option<f64> {
    let weight: f64 = pieces.iter().map(|p| p.weight * p.period.y.len() as f64).sum();
    Some((cost / weight).sqrt()).filter(|error| error.is_finite())
}

/// Groups of records of which one stands for all in the products of the derivatives: those of a level, if the
/// products of all take long and each of them drives all inputs independently; else every record is a group of
/// its own. A search with the products of all needs fewer iterations where the errors that remain are small.
pub(super) struct Alike {
    groups: Vec<Vec<usize>>,
    records: usize,
}

impl Alike {
    /// For a search over so many parameters.
    pub(super) fn new(pieces: &[&RecordPeriod], parameters: usize) -> Self {
        let numbers: usize = pieces.iter().map(|piece| piece.period.y.len()).sum();
        let take_long = numbers as f64 * (parameters as f64).powi(2) > LONG;
        let levels = pieces.iter().map(|piece| piece.level).max().map_or(0, |most| most + 1);
        let mut groups = Vec::new();
        for level in 0..levels {
            let of_level: Vec<usize> = (0..pieces.len()).filter(|&k| pieces[k].level == level).collect();
            if of_level.is_empty() {
                continue;
            }
            let moments: Vec<DMatrix<f64>> = of_level.iter().map(|&k| input_moments(pieces[k])).collect();
            let mean = moments.iter().sum::<DMatrix<f64>>() / moments.len() as f64;
            let least = |moments: &DMatrix<f64>| moments.symmetric_eigenvalues().min();
            if take_long && moments.iter().all(|of_record| least(of_record) >= INDEPENDENT * least(&mean)) {
                groups.push(of_level);
            } else {
                groups.extend(of_level.into_iter().map(|k| vec![k]));
            }
        }
        Self { groups, records: pieces.len() }
    }

    /// For how many records each stands at this iteration: the records of a group take turns.
    pub(super) fn shares(&self, iteration: usize) -> Vec<f64> {
        let mut shares = vec![0.0; self.records];
        for group in &self.groups {
            shares[group[iteration % group.len()]] = group.len() as f64;
        }
        shares
    }
}

/// Mean products of the inputs of a record.
fn input_moments(piece: &RecordPeriod) -> DMatrix<f64> {
    let inputs = piece.period.inputs;
    let u = DMatrixView::from_slice(&piece.period.u, inputs, piece.period.samples());
    u * u.transpose() / piece.period.samples().max(1) as f64
}

/// All records.
#[derive(Clone, Debug)]
pub(super) struct Campaign {
    pub pieces: Vec<RecordPeriod>,
    /// Mean rms of each level, ascending \[V\].
    pub levels: Vec<f64>,
    /// Unit of the inputs.
    pub unit: Unit,
    pub inputs: usize,
    pub outputs: usize,
    pub rate: f64,
}

impl Campaign {
    pub(super) fn new(records: &[AxesRecord], options: &Options) -> Result<Self, IdentifyError> {
        let first = records.first().ok_or(IdentifyError::NoRecords)?;
        same(first, records)?;
        let mut pieces = Vec::with_capacity(records.len());
        for record in records {
            let period = SteadyPeriod::find(record, options.whole_records)?;
            let (n, steps) = (period.inputs, options.steps);
            let mut channels = Vec::with_capacity(n);
            for i in 0..n {
                let u: Vec<f64> = period.u.iter().skip(i).step_by(n).copied().collect();
                let fine = InterSample::BandLimited.upsample(&u, steps, RecordEnds::Periodic);
                channels.push(fine.map_err(hysteron_model::axes::AxesError::from)?);
            }
            let fine = (0..period.samples() * steps)
                .flat_map(|k| channels.iter().map(move |channel| channel[k]))
                .collect();
            pieces.push(RecordPeriod { period, fine, level: 0, weight: 0.0 });
        }
        let mut campaign = Self {
            unit: first.u_unit.clone(),
            pieces,
            levels: Vec::new(),
            inputs: first.u.len(),
            outputs: first.y.len(),
            rate: first.sample_rate_hz,
        };
        campaign.sort_levels();
        campaign.weigh();
        Ok(campaign)
    }

    /// Records of the highest level.
    pub(super) fn top(&self) -> Vec<&RecordPeriod> {
        self.of_level(self.levels.len().saturating_sub(1))
    }

    pub(super) fn of_level(&self, level: usize) -> Vec<&RecordPeriod> {
        self.pieces.iter().filter(|p| p.level == level).collect()
    }

    fn sort_levels(&mut self) {
        let mut all: Vec<f64> = self.pieces.iter().map(|p| p.period.level).collect();
        all.sort_by(f64::total_cmp);
        let mut groups: Vec<Vec<f64>> = Vec::new();
        for level in all {
            match groups.last_mut() {
                Some(group) if level <= (1.0 + ONE_LEVEL) * group[0] => group.push(level),
                _ => groups.push(vec![level]),
            }
        }
        self.levels = groups.iter().map(|g| g.iter().sum::<f64>() / g.len() as f64).collect();
        for piece in &mut self.pieces {
            let place = groups.iter().position(|g| g.contains(&piece.period.level));
            piece.level = place.unwrap_or(0);
        }
    }

    /// Weights each level by its mean square error over its rms output.
    fn weigh(&mut self) {
        let count = self.levels.len();
        let mut records = vec![0.0; count];
        let mut power = vec![0.0; count];
        for piece in &self.pieces {
            records[piece.level] += 1.0;
            power[piece.level] += piece.period.output_rms().powi(2);
        }
        let rms: Vec<f64> = power.iter().zip(&records).map(|(p, n): (&f64, &f64)| (p / n).sqrt()).collect();
        for piece in &mut self.pieces {
            let numbers = piece.period.y.len() as f64 * records[piece.level];
            piece.weight = 1.0 / (numbers * rms[piece.level].max(f64::MIN_POSITIVE));
        }
    }
}
