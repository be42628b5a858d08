//! Simulation and scores of any kind of model.

use super::force_run::force;
use super::verdict::Verdict;
use super::{AxesScore, Body, Model, Remark, RunError, RunScore, Score, SignalRole, Signals, Simulation};
use crate::axes::{AxesRecord, AxesScores, SteadyPeriod, repeats};
use crate::dynamics::Dynamics;
use crate::hammerstein;
use crate::model_file::{ModelFile, OscillatorFile, ValidRange};
use crate::oscillator::Oscillator;
use crate::record::{
    InputOutput, InterSample, MeasurementRun, RunPart, TimeBase, Unit, ends_of, find_periods, range_of,
};
use crate::start::Start;
use crate::validate::{
    OffsetTreatment, ScoreError, Scores, Scoring, choose_start, score, settling_start, unfollowed_start,
};

/// Fewest samples for a score: with two and an estimated offset, any line fits.
const FEWEST_SAMPLES: usize = 3;
/// Variation of a simulation, over its size, that is rounding.
const ROUNDING: f64 = 1e-9;

impl Model {
    /// The model's output for a drive, in free run: no measured output is used. [`Start::AsIdentified`] takes
    /// the start that the model file assumes; a drive of several axes that repeats is in its steady state.
    ///
    /// # Errors
    /// [`RunError`]: other units or channels, no or another sample rate where one is needed, a motion that
    /// cannot be simulated, an output that is not finite.
    pub fn simulate(&self, signals: &Signals, start: Start) -> Result<Simulation, RunError> {
        self.check_start(signals, start)?;
        let mut found = self.simulated(signals, start)?;
        if let (Start::AsIdentified, Start::Settled { period_samples: Some(period_samples), .. }) =
            (start, &found.start)
        {
            found.remarks.push(Remark::TakenAsSettled { period_samples: *period_samples });
        }
        Ok(found)
    }

    fn simulated(&self, signals: &Signals, start: Start) -> Result<Simulation, RunError> {
        let simulation = match (self, signals) {
            (Self::Hammerstein(_) | Self::Oscillator(_) | Self::Force(_), Signals::Single(record)) => {
                let mut run = self.prepared(record)?;
                let start = match start {
                    Start::AsIdentified => self.expected_start(record, &mut run.remarks),
                    Start::PERIODIC => Start::settled(own_period(record).unwrap_or(record.len())),
                    given => given,
                };
                run.remark_range(self, record);
                let y = match self {
                    Self::Hammerstein(body) => body.law.simulate(&record.u, &record.time, &start)?,
                    Self::Oscillator(body) => oscillate(body, record, start)?,
                    Self::Force(body) => force(body, record, start)?,
                    Self::Modes(_) | Self::Branches(_) => return Err(self.takes_others()),
                };
                run.finished(start, y)
            }
            (Self::Modes(_) | Self::Branches(_), Signals::Several(record)) => {
                self.simulate_axes(record, start)?
            }
            _ => return Err(self.takes_others()),
        };
        simulation.finite()
    }

    /// Scores of the model on a record, simulated from its start. [`Start::AsIdentified`]: from the start
    /// that explains the record best, the one that the model file assumes unless another is better by more
    /// than 1 %; a hysteresis memory is estimated.
    ///
    /// # Errors
    /// Those of [`Self::simulate`]; a record that cannot be scored.
    pub fn score(&self, signals: &Signals, start: Start, scoring: &Scoring) -> Result<Score, RunError> {
        self.check_start(signals, start)?;
        self.scored(signals, start, scoring)
    }

    fn scored(&self, signals: &Signals, start: Start, scoring: &Scoring) -> Result<Score, RunError> {
        let (simulation, record, scores) = match (self, signals) {
            (Self::Hammerstein(body), Signals::Single(record)) => {
                let simulation = match start {
                    Start::AsIdentified => self.explain_hammerstein(body, record, scoring)?,
                    given => self.simulated(signals, given)?,
                };
                self.scored_single(record, simulation, scoring)?
            }
            (Self::Oscillator(body), Signals::Single(record)) => {
                let simulation = match start {
                    Start::AsIdentified => self.explain_oscillator(body, record, scoring)?,
                    given => self.simulated(signals, given)?,
                };
                self.scored_single(record, simulation, scoring)?
            }
            (Self::Force(body), Signals::Single(record)) => {
                let simulation = match start {
                    Start::AsIdentified => self.explain_force(body, record, scoring)?,
                    given => self.simulated(signals, given)?,
                };
                self.scored_single(record, simulation, scoring)?
            }
            (Self::Modes(_) | Self::Branches(_), Signals::Several(record)) => {
                return self.score_axes(record, start, scoring);
            }
            _ => return Err(self.takes_others()),
        };
        let unit = agreed_unit(SignalRole::Output, &self.units().output, &record.y_unit, &mut Vec::new())?;
        let training = match self {
            Self::Hammerstein(body) => &body.data.scores[..],
            Self::Oscillator(body) => &body.data.scores[..],
            Self::Force(body) => &body.data.scores[..],
            Self::Modes(_) | Self::Branches(_) => &[],
        };
        let y = simulation.outputs.first().map_or(&[][..], Vec::as_slice);
        let verdict = Verdict::of(training, self.valid_range(), record, y, &scores);
        let estimated = matches!(simulation.start, Start::Remembering { .. });
        let without_estimated_start = if start == Start::AsIdentified && estimated {
            let expected = self.expected_start(record, &mut Vec::new());
            self.scored(signals, expected, scoring)?.outputs.into_iter().next().map(Box::new)
        } else {
            None
        };
        Ok(Score { verdict, without_estimated_start, ..Score::of_single(record, unit, scores, simulation) })
    }

    /// Scores of the model on a run of several records. [`Start::AsIdentified`]: from the start that explains
    /// the first record best, as [`Self::score`] finds it; the later ones are not used.
    ///
    /// # Errors
    /// Those of [`Self::score`]; [`RunError::Signals`] for models of several inputs and outputs.
    pub fn score_run(
        &self,
        run: &MeasurementRun,
        start: Start,
        scoring: &Scoring,
    ) -> Result<RunScore, RunError> {
        let (first, signals) = (run.beginning(), Signals::Single(run.data.clone()));
        let chosen = match start {
            // Where the first record begins settled, the run still need not repeat.
            Start::AsIdentified => {
                self.score(&Signals::Single(first.clone()), start, scoring)?.simulation.start
            }
            given => {
                self.check_start(&signals, given)?;
                given
            }
        };
        let whole = self.scored(&signals, chosen, scoring)?;
        let expected = self.expected_start(&first, &mut Vec::new());
        let without = if start == Start::AsIdentified && expected != chosen {
            Some(self.scored(&signals, expected, scoring)?)
        } else {
            None
        };
        let simulated = whole.simulation.outputs.first().map_or(&[][..], Vec::as_slice);
        let offset = whole.outputs.first().map_or(0.0, |scores| scores.offset);
        let fixed = Scoring { skip_s: None, offset: OffsetTreatment::Fixed };
        let part = |(index, part): (usize, &RunPart)| {
            let own: Vec<f64> = simulated[part.samples.clone()].iter().map(|y| y + offset).collect();
            let scoring = if index == 0 { Scoring { skip_s: scoring.skip_s, ..fixed } } else { fixed };
            let scores = score(&part.data, &own, &scoring)?;
            let start = if index == 0 { chosen } else { Start::AsIdentified };
            let simulation = Simulation::of_single(own, start, whole.simulation.input_unit.clone());
            Ok(Score::of_single(&part.data, whole.unit.clone(), scores, simulation))
        };
        let records = run.parts.iter().enumerate().map(part).collect::<Result<_, RunError>>()?;
        Ok(RunScore { records, whole, whole_without_estimated_start: without })
    }

    /// The start that the model file assumes for a record; remarks on it are added to `remarks`.
    pub fn expected_start(&self, record: &InputOutput, remarks: &mut Vec<Remark>) -> Start {
        match self {
            Self::Hammerstein(body) => hammerstein_start(&body.data, record, remarks),
            Self::Oscillator(body) => own_start(&body.data, record).unwrap_or_else(|| {
                remarks.push(Remark::DoesNotRepeat);
                Start::ZERO
            }),
            Self::Force(_) | Self::Modes(_) | Self::Branches(_) => Start::AsIdentified,
        }
    }

    /// The unit of a signal that model and record agree on: the record's, or the model's where the record
    /// gives none (which goes to `remarks`).
    ///
    /// # Errors
    /// [`RunError::Unit`].
    pub fn agreed_unit(
        &self,
        signal: SignalRole,
        found: &Unit,
        remarks: &mut Vec<Remark>,
    ) -> Result<Unit, RunError> {
        let units = self.units();
        let own = match signal {
            SignalRole::Input => &units.input,
            SignalRole::Output | SignalRole::Reference => &units.output,
        };
        agreed_unit(signal, own, found, remarks)
    }

    /// Only a Hammerstein model can start from an input other than the first sample's, and every input repeats
    /// with a period that is given.
    fn check_start(&self, signals: &Signals, start: Start) -> Result<(), RunError> {
        let inputs = match signals {
            Signals::Single(record) => std::slice::from_ref(&record.u),
            Signals::Several(record) => &record.u[..],
        };
        match (self, start) {
            (_, Start::Settled { period_samples: Some(period_samples), .. })
                if !inputs.iter().all(|u| repeats(u, period_samples)) =>
            {
                Err(RunError::NotRepeating { period_samples })
            }
            (Self::Hammerstein(_), _) | (_, Start::AsIdentified | Start::Settled { .. }) => Ok(()),
            (Self::Oscillator(_), Start::Rest { voltage_v: 0.0 }) => Ok(()),
            (_, Start::Rest { .. } | Start::Remembering { .. }) => {
                Err(RunError::RestVoltage { kind: self.kind() })
            }
        }
    }

    pub(super) fn takes_others(&self) -> RunError {
        let expected = match self {
            Self::Hammerstein(_) | Self::Oscillator(_) | Self::Force(_) => "one input and one output",
            Self::Modes(_) | Self::Branches(_) => "several named inputs and outputs",
        };
        RunError::Signals { kind: self.kind(), expected }
    }

    /// Checks the units of one input and one output.
    pub(super) fn prepared(&self, record: &InputOutput) -> Result<Prepared, RunError> {
        let mut remarks = Vec::new();
        let units = self.units();
        let input_unit = agreed_unit(SignalRole::Input, &units.input, &record.u_unit, &mut remarks)?;
        if !record.y.is_empty() {
            agreed_unit(SignalRole::Output, &units.output, &record.y_unit, &mut remarks)?;
        }
        Ok(Prepared { input_unit, remarks })
    }

    fn explain_hammerstein(
        &self,
        body: &Body<ModelFile, hammerstein::Model>,
        record: &InputOutput,
        scoring: &Scoring,
    ) -> Result<Simulation, RunError> {
        let mut run = self.prepared(record)?;
        let expected = hammerstein_start(&body.data, record, &mut run.remarks);
        run.remark_range(self, record);
        let range_v = body.data.valid_range.as_ref().map(|range| (range.input.low, range.input.high));
        let (chosen, y) =
            choose_start(&body.law, record, expected, range_v, scoring).map_err(|e| match e {
                ScoreError::Simulation(e) => RunError::from(e),
                e => e.into(),
            })?;
        if chosen != expected {
            run.remarks.push(Remark::StartChosen { chosen, expected });
        }
        Ok(run.finished(chosen, y))
    }

    /// From rest, or settled on its period or on the whole record.
    fn explain_oscillator(
        &self,
        body: &Body<OscillatorFile, Oscillator>,
        record: &InputOutput,
        scoring: &Scoring,
    ) -> Result<Simulation, RunError> {
        let mut run = self.prepared(record)?;
        run.remark_range(self, record);
        let expected = own_start(&body.data, record).unwrap_or(Start::ZERO);
        run.explained(record, scoring, (expected, Start::ZERO), |start| oscillate(body, record, start))
    }

    fn scored_single<'r>(
        &self,
        record: &'r InputOutput,
        mut simulation: Simulation,
        scoring: &Scoring,
    ) -> Result<(Simulation, &'r InputOutput, Scores), RunError> {
        let (samples, remark) = match self {
            _ if scoring.skip_s.is_some() => (0, None),
            Self::Hammerstein(body) if body.law.dynamics == Dynamics::None => {
                let samples = unfollowed_start(record, &simulation.start);
                (samples, Some(Remark::LeftOut { samples }))
            }
            Self::Oscillator(_) => {
                let samples = settling_start(record, &simulation.start);
                (samples, Some(Remark::Settling { samples }))
            }
            _ => (0, None),
        };
        let masked = record.without_first(samples);
        simulation.remarks.extend(remark.filter(|_| samples > 0));
        let y = simulation.outputs.first().map_or(&[][..], Vec::as_slice);
        check_meaningful(&masked, y)?;
        let scores = score(&masked, y, scoring)?;
        Ok((simulation, record, scores))
    }

    fn simulate_axes(&self, record: &AxesRecord, start: Start) -> Result<Simulation, RunError> {
        let units = self.units();
        let mut remarks = Vec::new();
        let pairs = [
            (SignalRole::Input, &units.input, &record.u_unit),
            (SignalRole::Output, &units.output, &record.y_unit),
        ];
        let measured = usize::from(!record.y.is_empty());
        for (signal, own, found) in pairs.into_iter().take(1 + measured) {
            agreed_unit(signal, own, found, &mut Vec::new())?;
        }
        let (period, settled_given) = match start {
            Start::Settled { period_samples: Some(period_samples), .. } => {
                let whole = record.len() / period_samples.max(1);
                (Some(SteadyPeriod::mean(record, period_samples, 0, whole.max(1))?), true)
            }
            _ => (SteadyPeriod::find(record, false).ok(), false),
        };
        if let Some((range, input)) = self.valid_range().zip(ends_of(&record.u)) {
            remarks.extend(extrapolates(range, input));
        }
        let rate = record.sample_rate_hz;
        let mut settled = period.as_ref().map(SteadyPeriod::samples);
        let outputs = match self {
            Self::Modes(body) => {
                match &period {
                    Some(SteadyPeriod { level, .. }) => remarks.extend(self.beyond_levels(*level)),
                    None => remarks.push(Remark::DoesNotRepeat),
                }
                body.law.simulate(&record.u, rate, InterSample::BandLimited, settled)?
            }
            Self::Branches(body) => {
                // A drive whose outputs still settle began at rest.
                settled =
                    settled.filter(|_| settled_given || period.as_ref().is_some_and(|p| p.settling == 0));
                body.law.simulate(&record.u, rate, settled)?
            }
            Self::Hammerstein(_) | Self::Oscillator(_) | Self::Force(_) => {
                return Err(self.takes_others());
            }
        };
        let start = settled.map_or(Start::AsIdentified, Start::settled);
        Ok(Simulation { outputs, start, input_unit: record.u_unit.clone(), period, remarks })
    }

    fn score_axes(&self, record: &AxesRecord, start: Start, scoring: &Scoring) -> Result<Score, RunError> {
        let mut simulation = self.simulate_axes(record, start)?;
        let settling = match (&simulation.start, &simulation.period) {
            (Start::Settled { .. }, Some(period)) if scoring.skip_s.is_none() => {
                period.settling * period.samples()
            }
            _ => 0,
        };
        if settling > 0 {
            simulation.remarks.push(Remark::Settling { samples: settling });
        }
        let settled = record.without_first(settling);
        let scores = AxesScores::new(&settled, &simulation.outputs, scoring, simulation.period.as_ref())?;
        Ok(Score {
            record: record.label(),
            unit: record.y_unit.clone(),
            rmse: scores.rmse,
            max_abs_error: scores.max_abs_error,
            fit_percent: scores.fit_percent,
            outputs: scores.outputs,
            axes: Some(AxesScore {
                outputs: record.outputs.clone(),
                level: simulation.period.as_ref().map(|period| period.level),
                mean_period_rmse: scores.mean_period_rmse,
            }),
            band: None,
            correction: None,
            without_estimated_start: None,
            verdict: None,
            simulation,
        })
    }
}

/// A run whose units agree.
pub(super) struct Prepared {
    input_unit: Unit,
    remarks: Vec<Remark>,
}

impl Prepared {
    pub(super) fn remark_range(&mut self, model: &Model, record: &InputOutput) {
        let Some(range) = model.valid_range() else { return };
        if let Some((fastest_hz, identified_hz)) = range.exceeded_by(&record.u, &record.time) {
            self.remarks.push(Remark::Fast { signal: SignalRole::Input, fastest_hz, identified_hz });
        }
        self.remarks.extend(extrapolates(range, range_of(&record.u)));
    }

    /// Simulated from the start that explains the record best: the one expected, from rest, or settled on the
    /// whole record.
    pub(super) fn explained(
        mut self,
        record: &InputOutput,
        scoring: &Scoring,
        (expected, rest): (Start, Start),
        simulate: impl Fn(Start) -> Result<Vec<f64>, RunError>,
    ) -> Result<Simulation, RunError> {
        let whole = Start::settled(record.len());
        let others = [rest, whole].into_iter().filter(|start| *start != expected);
        let mut best: Option<(f64, Start, Vec<f64>)> = None;
        let mut failure = None;
        for start in std::iter::once(expected).chain(others) {
            let y = match simulate(start) {
                Ok(y) => y,
                // A start that cannot be simulated is discarded.
                Err(e) => {
                    failure.get_or_insert(e);
                    continue;
                }
            };
            let rmse = score(record, &y, scoring)?.rmse;
            if best.as_ref().is_none_or(|(least, ..)| rmse < *least) {
                best = Some((rmse, start, y));
            }
        }
        let (_, chosen, y) = best.ok_or_else(|| failure.unwrap_or(RunError::NoSampleRate))?;
        if chosen != expected {
            self.remarks.push(Remark::StartChosen { chosen, expected });
        }
        Ok(self.finished(chosen, y))
    }
    fn finished(self, start: Start, y: Vec<f64>) -> Simulation {
        let Self { input_unit, remarks } = self;
        Simulation { remarks, ..Simulation::of_single(y, start, input_unit) }
    }
}

/// The unit that a model (`own`, a header symbol) and a record agree on: the record's, or the model's where
/// the record gives none.
fn agreed_unit(
    signal: SignalRole,
    own: &str,
    found: &Unit,
    remarks: &mut Vec<Remark>,
) -> Result<Unit, RunError> {
    let own = Unit::new(own);
    if found.symbol().is_empty() {
        if !own.symbol().is_empty() {
            remarks.push(Remark::UnitAssumed { signal, unit: own.clone() });
        }
        return Ok(own);
    }
    if own.symbol().is_empty() || own == *found {
        return Ok(found.clone());
    }
    Err(RunError::Unit { signal, model: own, record: found.clone() })
}

/// That inputs leave the range identified.
pub(super) fn extrapolates(range: &ValidRange, input: (f64, f64)) -> Option<Remark> {
    let identified = (range.input.low, range.input.high);
    let unit = Unit::new(&range.input.unit);
    range.is_left_by(input).then_some(Remark::Extrapolates { input, identified, unit })
}

/// The period of a repeating drive, which also takes the place of the output.
fn period_of_drive(u: &[f64], time: &TimeBase) -> Option<crate::record::Periods> {
    let data = InputOutput::new("drive", time.clone(), u.to_vec(), u.to_vec()).ok()?;
    find_periods(&data).ok()
}

/// Samples of the period of a record's drive.
fn own_period(record: &InputOutput) -> Option<usize> {
    period_of_drive(&record.u, &record.time).map(|periods| periods.period_samples.round() as usize)
}

/// The start that a Hammerstein model's file assumes.
fn hammerstein_start(file: &ModelFile, record: &InputOutput, remarks: &mut Vec<Remark>) -> Start {
    let first = Start::Rest { voltage_v: record.u.first().copied().unwrap_or(0.0) };
    match file.start() {
        Start::AsIdentified => first,
        Start::PERIODIC => own_period(record).map_or_else(
            || {
                remarks.push(Remark::DoesNotRepeat);
                first
            },
            Start::settled,
        ),
        given => given,
    }
}

/// The start that an oscillator's file assumes: for a settled one the drive's own period; `None` where it has
/// none.
fn own_start(file: &OscillatorFile, record: &InputOutput) -> Option<Start> {
    if file.start() != Start::PERIODIC {
        return Some(Start::ZERO);
    }
    let periods = period_of_drive(&record.u, &record.time).filter(|p| p.start == 0 && p.count >= 2)?;
    Some(Start::settled(periods.period_samples.round() as usize))
}

/// Displacement of an oscillator, its sensor's offset added.
fn oscillate(
    body: &Body<OscillatorFile, Oscillator>,
    record: &InputOutput,
    start: Start,
) -> Result<Vec<f64>, RunError> {
    let rate = record.sample_rate_hz().ok_or(RunError::NoSampleRate)?;
    let mut y = body.law.simulate_record(&record.u, rate, body.data.inter_sample, start)?;
    y.iter_mut().for_each(|y| *y += body.data.offset.value);
    Ok(y)
}

/// Refuses a meaningless score: of one or two samples, a constant output, or a constant drive (unless the
/// model, started elsewhere, still moves towards it).
fn check_meaningful(record: &InputOutput, simulated: &[f64]) -> Result<(), RunError> {
    let valid = |k: usize| record.is_valid(k);
    let range = |x: &[f64]| {
        let scored = x.iter().enumerate().filter(|(k, _)| valid(*k)).map(|(_, x)| *x);
        scored.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let samples = (0..record.len()).filter(|&k| valid(k)).count();
    if samples < FEWEST_SAMPLES {
        return Err(RunError::TooFewSamples { samples, total: record.len(), need: FEWEST_SAMPLES });
    }
    let ((u_low, u_high), (y_low, y_high)) = (range(&record.u), range(&record.y));
    if y_low == y_high {
        return Err(RunError::ConstantOutput { name: record.output.clone(), value: y_low });
    }
    let (low, high) = range(simulated);
    if u_low == u_high && high - low <= ROUNDING * low.abs().max(high.abs()) {
        return Err(RunError::ConstantInput { name: record.input.clone(), value: u_low });
    }
    Ok(())
}
