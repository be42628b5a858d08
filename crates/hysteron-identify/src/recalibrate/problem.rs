//! The least-squares problem of a recalibration: gain, delay and memories searched, offsets projected out.

use super::RecordFacts;
use hysteron_model::Start;
use hysteron_model::hammerstein::Model;
use hysteron_model::record::range_of;
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, Range, root_mean_square};

/// Gains searched.
const GAINS: (f64, f64) = (0.05, 20.0);
/// Tolerance of a bound, as a share of the range.
const EDGE: f64 = 1e-6;

/// Indices of the unknowns in the search vector.
#[derive(Clone, Debug)]
pub(super) struct Names {
    pub(super) delay: Option<usize>,
    /// Memory of each record, in the scale of the old model.
    pub(super) memories: Vec<Option<usize>>,
}

impl Names {
    pub(super) const GAIN: usize = 0;
}

/// y − offset − g · model(u, delay). A recalibration takes some dozens of these evaluations, each a whole
/// simulation of the model (which, unlike the searches of an identification, allocates).
pub(super) struct GainAndDelay<'a> {
    pub(super) names: Names,
    model: &'a Model,
    records: Vec<Signals<'a>>,
    bounds: Bounds,
    /// Delay where it is not searched \[s\].
    pub(super) held_delay_s: f64,
    residuals: usize,
}

struct Signals<'a> {
    facts: &'a RecordFacts,
    scored: Vec<usize>,
    start: Start,
}

impl<'a> GainAndDelay<'a> {
    /// `longest_s`: the delay is searched up to this, else held.
    pub(super) fn new(
        model: &'a Model,
        facts: &'a [RecordFacts],
        starts: &[Start],
        longest_s: Option<f64>,
        held_delay_s: f64,
    ) -> Self {
        let mut ranges = vec![Range::linear("gain", GAINS.0, GAINS.1)];
        let delay = longest_s.map(|longest| {
            ranges.push(Range::linear("delay", 0.0, longest));
            ranges.len() - 1
        });
        let records: Vec<Signals<'a>> = facts
            .iter()
            .zip(starts)
            .map(|(facts, &start)| Signals { facts, scored: facts.scored(0), start })
            .collect();
        let memories = records
            .iter()
            .enumerate()
            .map(|(index, record)| {
                let Start::Remembering { memory, .. } = record.start else { return None };
                let (low, high) = range_of(&record.facts.data.u);
                let (low, high) = model.hysteresis.memory_range(low, high)?;
                // Away from the bounds.
                let reach = 0.5 * (high - low).max(2.0 * memory.value().abs());
                let middle = 0.5 * (low + high);
                ranges.push(Range::linear(&format!("memory_{}", index + 1), middle - reach, middle + reach));
                Some(ranges.len() - 1)
            })
            .collect();
        let residuals = records.iter().map(|r| r.scored.len()).sum();
        let (names, bounds) = (Names { delay, memories }, Bounds { ranges });
        Self { names, model, records, bounds, held_delay_s, residuals }
    }

    /// Search vector of the old model.
    pub(super) fn start(&self) -> Vec<f64> {
        let mut x = vec![1.0; self.bounds.dimension()];
        if let Some(at) = self.names.delay {
            x[at] = self.model.delay_s;
        }
        for (record, at) in self.records.iter().zip(&self.names.memories) {
            if let (Start::Remembering { memory, .. }, Some(at)) = (record.start, at) {
                x[*at] = memory.value();
            }
        }
        x
    }

    /// True if the delay is at a bound.
    pub(super) fn is_edge_of_delay(&self, delay_s: f64) -> bool {
        self.names.delay.is_some_and(|at| {
            let Range { low, high, .. } = self.bounds.ranges[at];
            (delay_s - low).min(high - delay_s) <= EDGE * (high - low)
        })
    }
}

impl Problem for GainAndDelay<'_> {
    type Workspace = Vec<f64>;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; self.residuals]
    }

    fn cost(&self, x: &[f64], ws: &mut Vec<f64>) -> f64 {
        let mut out = std::mem::take(ws);
        let done = self.residuals(x, ws, &mut out);
        *ws = out;
        if done { root_mean_square(ws) } else { f64::INFINITY }
    }
}

impl LeastSquaresProblem for GainAndDelay<'_> {
    fn residual_count(&self) -> usize {
        self.residuals
    }

    fn residuals(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
        let delay_s = self.names.delay.map_or(self.held_delay_s, |at| x[at]);
        let model = Model { delay_s, offset: 0.0, ..self.model.clone() };
        let mut rest = out;
        for (record, memory) in self.records.iter().zip(&self.names.memories) {
            let data = &record.facts.data;
            let start = match (record.start, memory) {
                (Start::Remembering { voltage_v, memory }, Some(at)) => {
                    Start::Remembering { voltage_v, memory: memory.with_value(x[*at]) }
                }
                (start, _) => start,
            };
            let Ok(simulated) = model.simulate(&data.u, &data.time, &start) else { return false };
            let (own, others) = rest.split_at_mut(record.scored.len());
            for (r, &k) in own.iter_mut().zip(&record.scored) {
                *r = data.y[k] - x[Names::GAIN] * simulated[k];
            }
            let offset = own.iter().sum::<f64>() / own.len() as f64;
            own.iter_mut().for_each(|r| *r -= offset);
            rest = others;
        }
        true
    }
}
