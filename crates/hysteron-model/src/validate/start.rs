//! Start of a record, estimated from the record itself.

use super::memory::best_memory;
use super::{ScoreError, Scoring, rmse};
use crate::hammerstein::Model;
use crate::record::{GAP_PERIODS, InputOutput, Periods, TimeBase, find_periods, range_of, shortest_swing};
use crate::start::Start;

/// Ends that differ by less than this share of the range close a loop.
const CLOSED: f64 = 0.03;

/// Share of its range that a drive covers in a cycle, and largest distance of its end from its beginning.
const CYCLE: f64 = 0.7;
const BACK: f64 = 0.06;

/// Possible starts of a record: at rest at its first sample, at rest at zero (drive off), settled on its own
/// period where it repeats from the beginning or is one closed loop.
pub fn possible_starts(record: &InputOutput, range_v: Option<(f64, f64)>) -> Vec<Start> {
    let mut starts = Vec::new();
    if let Some(&first) = record.u.first() {
        starts.push(Start::Rest { voltage_v: first });
        // Uneven stamps are those of a logger that ran before: nothing jumped from 0 V to the first sample.
        if first != 0.0 && !matches!(record.time, TimeBase::NonUniform { .. }) {
            starts.push(Start::ZERO);
        }
    }
    if let Some(cycle) = first_cycle(record) {
        starts.push(Start::Settled { period_samples: Some(cycle), virgin_at_v: wider(record, range_v) });
    } else if let Some(period_samples) = settled_period(record, find_periods(record).ok()) {
        starts.push(Start::settled(period_samples));
    }
    starts
}

/// End of the range over which a device was driven before, where the record stays within it: that memory acts
/// as an offset until the record reaches as far. The end farther from where it begins.
fn wider(record: &InputOutput, range_v: Option<(f64, f64)>) -> Option<f64> {
    let ((low, high), first) = (range_v?, *record.u.first()?);
    let own = range_of(&record.u);
    let farther = if high - first > first - low { high } else { low };
    (farther > own.1 || farther < own.0).then_some(farther)
}

/// Samples of the first cycle of a drive on uneven stamps: those until it returns to where it began, after
/// most of its range. `None` where it does not come back.
pub fn first_cycle(record: &InputOutput) -> Option<usize> {
    let TimeBase::NonUniform { times_s } = &record.time else { return None };
    let end = cycle(&record.u)?;
    // Before a pause the drive need not return completely: the cycle ends there, pause included.
    let step = |k: usize| Some(times_s.get(k + 1)? - times_s.get(k)?);
    let paused = step(end).zip(end.checked_sub(1).and_then(step)).is_none_or(|(a, b)| a > GAP_PERIODS * b);
    Some(if paused { (end + 1).min(times_s.len()) } else { end })
}

/// Sample at which a drive is back where it began, as near as it comes.
fn cycle(u: &[f64]) -> Option<usize> {
    let (low, high) = range_of(u);
    let (range, first) = (high - low, *u.first()?);
    let (mut least, mut greatest) = (first, first);
    let back = u.iter().position(|x| {
        (least, greatest) = (least.min(*x), greatest.max(*x));
        greatest - least >= CYCLE * range && (x - first).abs() <= BACK * range
    })?;
    let nearer = u[back..].windows(2).take_while(|two| (two[1] - first).abs() < (two[0] - first).abs());
    Some(back + nearer.count())
}

/// Samples of the period that a record may be settled on: where the drive repeats from the first sample on
/// (`periods`, if they were found), or the whole record, where it is one closed loop.
pub fn settled_period(record: &InputOutput, periods: Option<Periods>) -> Option<usize> {
    match periods {
        Some(p) => (p.start == 0 && p.count >= 2).then(|| p.period_samples.round() as usize),
        None => (closes(&record.u) && closes(&record.y)).then_some(record.u.len()),
    }
}

/// Samples at the start of a record that a model without dynamics cannot follow, because the drive jumps
/// there from its rest: a quarter of the drive's shortest period, 0 without a jump of more than 2 % of its
/// range.
pub fn unfollowed_start(record: &InputOutput, start: &Start) -> usize {
    const JUMP: f64 = 0.02;
    let Start::Rest { voltage_v } = *start else { return 0 };
    let (low, high) = range_of(&record.u);
    let jump = record.u.first().map_or(0.0, |first| (first - voltage_v).abs());
    if jump > JUMP * (high - low) { settling_samples(&record.u, shortest_swing(&record.u)) } else { 0 }
}

/// Samples at the start of a record in which a device has not yet settled to the steady state that a
/// simulation assumes: 0 for any other start.
pub fn settling_start(record: &InputOutput, start: &Start) -> usize {
    match start {
        Start::Settled { .. } => {
            find_periods(record).map_or(0, |periods| match periods.settling_before_mean(&record.y) {
                0 => 0,
                settling => periods.first_sample(settling),
            })
        }
        _ => 0,
    }
}

/// A quarter of the shortest period of the drive, at most a quarter of the record.
#[doc(hidden)]
pub fn settling_samples(u: &[f64], shortest_swing: usize) -> usize {
    (shortest_swing / 2).min(u.len() / 4)
}

/// True if a signal ends where it began, to 3 % of its range.
fn closes(x: &[f64]) -> bool {
    let (low, high) = range_of(x);
    match (x.first(), x.last()) {
        (Some(first), Some(last)) => (last - first).abs() <= CLOSED * (high - low),
        _ => false,
    }
}

/// The start among `preferred` and [`possible_starts`] from which `model` explains the record best (smallest
/// RMSE), and the simulation from it. A record's initial state is unknown like its sensor's zero: this is its
/// estimate, one of at most four, the preferred one unless another is better by more than 1 %. Where the
/// device rested at u(0) with a memory of earlier motion that explains the record better than all of them by
/// more than 1 %, that start is taken, with the estimated memory z ([`Start::Remembering`]). `range_v`:
/// smallest and largest voltage of the records that the model comes from.
///
/// # Errors
/// [`ScoreError`] where the model cannot be simulated from the preferred start, or the record cannot be
/// scored.
pub fn choose_start(
    model: &Model,
    record: &InputOutput,
    preferred: Start,
    range_v: Option<(f64, f64)>,
    scoring: &Scoring,
) -> Result<(Start, Vec<f64>), ScoreError> {
    const BETTER: f64 = 0.99;
    let simulated = model.simulate(&record.u, &record.time, &preferred)?;
    let mut best = (rmse(record, &simulated, scoring)?.rmse, preferred, simulated);
    let given = best.0;
    for start in possible_starts(record, range_v).into_iter().filter(|s| *s != preferred) {
        // A start that cannot be simulated is discarded.
        let Ok(simulated) = model.simulate(&record.u, &record.time, &start) else { continue };
        let own = rmse(record, &simulated, scoring)?.rmse;
        if own < best.0.min(BETTER * given) {
            best = (own, start, simulated);
        }
    }
    if let Some((own, start, simulated)) = best_memory(model, record, scoring)?
        && own < BETTER * best.0
    {
        return Ok((start, simulated));
    }
    Ok((best.1, best.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dynamics::{Dynamics, Scheme};
    use crate::hysteresis::{ArticleOperator, Hysteresis};
    use crate::model::RunError;
    use crate::model_file::{ModelFile, SignalUnits};
    use crate::record::{InterSample, MeasurementRun, TimeBase};
    use crate::start::Memory;
    use crate::validate::score;
    use std::f64::consts::TAU;

    fn model() -> Model {
        Model {
            hysteresis: Hysteresis::from(ArticleOperator::new(vec![3.0], 1.0, 0.4, 0.1, 1.0).unwrap()),
            dynamics: Dynamics::None,
            offset: 0.0,
            delay_s: 0.0,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        }
    }

    #[test]
    fn a_cycle_ends_where_the_drive_is_back() {
        let u: Vec<f64> = (0..250).map(|k| 3.0 + 2.0 * (TAU * f64::from(k) / 100.0).sin()).collect();
        assert_eq!(cycle(&u), Some(100));
        assert_eq!(cycle(&u[..90]), None);
        assert_eq!(cycle(&[]), None);
        // A pause after 98 samples, of which the drive makes nothing: the first cycle ends with it.
        let times_s = (0..250).map(|k| if k < 98 { 0.01 * f64::from(k) } else { 0.5 + 0.01 * f64::from(k) });
        let record = |u: Vec<f64>, times_s: Vec<f64>| {
            InputOutput::new("r", TimeBase::NonUniform { times_s }, u.clone(), u).unwrap()
        };
        let mut paused = u.clone();
        paused.drain(98..100);
        assert_eq!(first_cycle(&record(paused, times_s.take(248).collect())), Some(98));
        let mut uneven: Vec<f64> = (0..250).map(|k| 0.01 * f64::from(k)).collect();
        uneven[0] = -0.003;
        assert_eq!(first_cycle(&record(u.clone(), uneven)), Some(100));
        assert_eq!(
            first_cycle(&InputOutput::new("r", TimeBase::uniform(100.0), u.clone(), u).unwrap()),
            None
        );
    }

    #[test]
    fn finds_the_start_that_made_the_record() {
        let u: Vec<f64> = (0..500).map(|k| 3.0 + 2.0 * (TAU * f64::from(k) / 100.0).sin()).collect();
        for truth in [Start::Rest { voltage_v: 0.0 }, Start::Rest { voltage_v: 3.0 }, Start::settled(100)] {
            let y = model().simulate(&u, None, &truth).unwrap();
            let record = InputOutput::new("run", TimeBase::uniform(100.0), u.clone(), y.clone()).unwrap();
            let preferred = Start::Rest { voltage_v: 3.0 };
            let (start, simulated) =
                choose_start(&model(), &record, preferred, None, &Scoring::default()).unwrap();
            assert_eq!(start, truth);
            assert_eq!(simulated, y);
        }
    }

    /// A large loop that dies down in smaller ones, cut open in the middle of a small one.
    fn nested() -> (Vec<f64>, usize) {
        let amplitude = |k: u32| 2.5 * (-f64::from(k) / 400.0).exp();
        ((0..1200).map(|k| 3.0 + amplitude(k) * (TAU * f64::from(k) / 150.0).sin()).collect(), 487)
    }

    #[test]
    fn a_record_cut_out_of_a_nested_loop_scores_at_its_noise() {
        for n in [1.0, 1.6] {
            let hysteresis = Hysteresis::from(ArticleOperator::new(vec![3.0], 1.0, 0.2, 0.05, n).unwrap());
            let model = Model { hysteresis, ..model() };
            let (u, cut) = nested();
            let y = model.simulate(&u, None, &Start::Rest { voltage_v: 0.0 }).unwrap();
            // Equally spread over ±0.005 √3: standard deviation 0.005.
            let noise = |k: usize| 0.005 * 3.0_f64.sqrt() * (2.0 * ((k * 7919) % 1009) as f64 / 1008.0 - 1.0);
            let y: Vec<f64> = y[cut..].iter().enumerate().map(|(k, y)| y + 40.0 + noise(k)).collect();
            let samples = y.len();
            let own = hysteron_numeric::root_mean_square(&(0..samples).map(noise).collect::<Vec<_>>());
            let record = InputOutput::new("cut", TimeBase::uniform(1000.0), u[cut..].to_vec(), y).unwrap();
            let preferred = Start::Rest { voltage_v: 0.0 };
            let scoring = Scoring::default();
            let (start, simulated) = choose_start(&model, &record, preferred, None, &scoring).unwrap();
            let found = score(&record, &simulated, &scoring).unwrap();
            assert!(matches!(start, Start::Remembering { .. }), "{n}: {start:?}");
            assert!((found.rmse / own - 1.0).abs() < 0.01, "{n}: {} against {own}", found.rmse);
            assert_eq!(found.skipped_samples, 0);
            // Not so from any other start.
            for other in possible_starts(&record, None) {
                let simulated = model.simulate(&record.u, None, &other).unwrap();
                assert!(score(&record, &simulated, &scoring).unwrap().rmse > 2.0 * own, "{n}: {other:?}");
            }
        }
    }

    #[test]
    fn the_memory_is_estimated() {
        let u: Vec<f64> = (0..500).map(|k| 3.0 + 2.0 * (TAU * f64::from(k) / 125.0).sin()).collect();
        let truth = Start::Remembering { voltage_v: 3.0, memory: Memory::Displacement(-0.83) };
        let y = model().simulate(&u, None, &truth).unwrap();
        let record = InputOutput::new("run", TimeBase::uniform(100.0), u, y).unwrap();
        let preferred = Start::Rest { voltage_v: 3.0 };
        match choose_start(&model(), &record, preferred, None, &Scoring::default()).unwrap().0 {
            Start::Remembering { voltage_v, memory: Memory::Displacement(z) } => {
                assert_eq!(voltage_v, 3.0);
                assert!((z + 0.83).abs() < 1e-4, "{z}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn the_preferred_start_stands_where_no_other_is_better() {
        let u: Vec<f64> = (0..300).map(|k| 1.0 + 0.05 * f64::from(k)).collect();
        let preferred = Start::Rest { voltage_v: -0.5 };
        let y = model().simulate(&u, None, &preferred).unwrap();
        let record = InputOutput::new("run", TimeBase::uniform(100.0), u, y).unwrap();
        assert_eq!(
            choose_start(&model(), &record, preferred, None, &Scoring::default()).unwrap().0,
            preferred
        );
    }

    #[test]
    fn a_run_that_begins_settled_need_not_repeat() {
        const SAMPLES: usize = 200;
        let law = model();
        let part = |start_s: f64, volts: &dyn Fn(usize) -> f64| {
            let base = TimeBase::Uniform { start_s, sample_rate_hz: 100.0, jitter_samples: 0.0 };
            let u: Vec<f64> = (0..SAMPLES).map(volts).collect();
            InputOutput::new("part", base, u.clone(), u).unwrap()
        };
        let cycle = part(0.0, &|k| 5.0 - 5.0 * (TAU * k as f64 / SAMPLES as f64).cos());
        let mut run = MeasurementRun::of(&[cycle, part(2.0, &|k| 0.1 * k as f64)]).unwrap().remove(0);
        let settled = Start::settled(run.beginning().len());
        run.data.y = law.simulate(&run.data.u, &run.data.time, &settled).unwrap();
        for part in &mut run.parts {
            part.data.y = run.data.y[part.samples.clone()].to_vec();
        }
        let model = crate::Model::try_from(ModelFile::from_model(&law, SignalUnits::default())).unwrap();
        let found = model.score_run(&run, Start::AsIdentified, &Scoring::default()).unwrap();
        assert_eq!(found.whole.simulation.start, settled);
        assert!(found.whole.outputs[0].rmse < 1e-9, "{}", found.whole.outputs[0].rmse);
        let given = model.score_run(&run, settled, &Scoring::default());
        assert!(matches!(given, Err(RunError::NotRepeating { .. })), "{given:?}");
    }
}
