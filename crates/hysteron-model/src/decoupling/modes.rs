//! Inverse of scheduled modes for references known ahead.

use super::linear::{LinearAxes, right_inverse};
use super::{AxesDrive, DecouplingError, DecouplingOptions, check, level_of, limited, own_bandwidth};
use crate::axes::{AxesError, ScheduledModes, Streaming};
use crate::compensator::Limits;
use crate::dynamics::{InverseAim, ResponseMatrix, Scheme, SimulationPlan};
use crate::start::Start;
use hysteron_rt::Limited;

/// Most rounds, and the change of the drive, relative to its rms, at which it is settled.
const ROUNDS: usize = 60;
const SETTLED: f64 = 1e-10;
/// Rounds for the voltages at rest.
const REST_ROUNDS: usize = 40;
/// Change after [`ROUNDS`] that is accepted: limits may keep single samples moving.
const ACCEPTED: f64 = 1e-6;
/// Most periods simulated for a steady state.
const PERIODS: usize = 24;

/// Held drives with which the model follows the `references` \[µm\], one list per axis; before them it rests
/// at their first values, or is in their periodic steady state.
///
/// # Errors
/// [`DecouplingError`].
pub fn decouple(
    model: &ScheduledModes,
    references: &[Vec<f64>],
    sample_rate_hz: f64,
    options: &DecouplingOptions,
) -> Result<AxesDrive, DecouplingError> {
    check(references, &options.limits, (model.inputs, model.outputs))?;
    let held = model.held_at(sample_rate_hz)?;
    let bandwidth_hz = options.bandwidth_hz.unwrap_or_else(|| own_bandwidth(model, sample_rate_hz));
    // The level decides on the linear response, and the drive on the level.
    let mut level_v = options.level.unwrap_or(held.model.level.highest);
    let mut attempts = 0;
    loop {
        let task = Task::new(&held.model, references, (sample_rate_hz, bandwidth_hz), options, level_v)?;
        let found = task.solve(options)?;
        let of_drive = level_of(&found.drive);
        let moved = held.model.level.state(of_drive) - held.model.level.state(level_v);
        if options.level.is_some() || moved.abs() < 1e-6 || attempts == LEVEL_ROUNDS {
            return Ok(AxesDrive { rate_error: held.error, ..found });
        }
        level_v = of_drive;
        attempts += 1;
    }
}

/// Rounds for the level.
const LEVEL_ROUNDS: usize = 3;

struct Task<'a> {
    model: &'a ScheduledModes,
    references: &'a [Vec<f64>],
    bandwidth_hz: f64,
    level: f64,
    plan: SimulationPlan,
    plant: ResponseMatrix,
    inverse: ResponseMatrix,
    /// Voltages and outputs about which the drive moves.
    rest: Vec<f64>,
    output_at_rest: Vec<f64>,
    /// At rest; `None` for a periodic motion.
    start: Option<Streaming<'a>>,
}

impl<'a> Task<'a> {
    fn new(
        model: &'a ScheduledModes,
        references: &'a [Vec<f64>],
        (sample_rate_hz, bandwidth_hz): (f64, f64),
        options: &DecouplingOptions,
        level: f64,
    ) -> Result<Self, DecouplingError> {
        let linear = LinearAxes::of(model, model.level.state(level));
        let samples = references.first().map_or(0, Vec::len);
        let initial = if options.periodic { Start::PERIODIC } else { Start::ZERO };
        let plan = SimulationPlan::new(samples, sample_rate_hz, Scheme::BandLimited, initial)?;
        let plant = plan.sampled_matrix(model.outputs, model.inputs, |z| linear.transfer(z));
        let aim = InverseAim { bandwidth_hz, error: options.error_at_bandwidth };
        let inverse = plan.inverse_matrix(&plant, aim)?.response;
        let back = right_inverse(&linear.gain())?;
        let apply = |y: &[f64]| -> Vec<f64> {
            (0..model.inputs).map(|n| (0..y.len()).map(|m| back[(n, m)] * y[m]).sum()).collect()
        };
        let (mut rest, mut start, mut output_at_rest) = (vec![0.0; model.inputs], None, Vec::new());
        if options.periodic {
            output_at_rest = vec![0.0; model.outputs];
        } else {
            let first: Vec<f64> = references.iter().map(|r| r[0]).collect();
            for round in 0..REST_ROUNDS {
                let mut at_rest = Streaming::new(model, &rest, level);
                output_at_rest = vec![0.0; model.outputs];
                at_rest.hold(&rest, &mut output_at_rest);
                let missed: Vec<f64> = first.iter().zip(&output_at_rest).map(|(r, y)| r - y).collect();
                let step = apply(&missed);
                let size = options.limits.iter().fold(0.0_f64, |most, l| most.max(l.high - l.low));
                let change = step.iter().fold(0.0_f64, |most, u| most.max(u.abs())) / size;
                if change < SETTLED {
                    start = Some(at_rest);
                    break;
                }
                if round + 1 == REST_ROUNDS || !change.is_finite() {
                    return Err(DecouplingError::NoRest { rounds: round + 1, change });
                }
                rest.iter_mut().zip(step).for_each(|(u, step)| *u += step);
            }
            for (n, (rest, limit)) in rest.iter().zip(&options.limits).enumerate() {
                let Limits { low, high, .. } = *limit;
                if !(low..=high).contains(rest) {
                    return Err(DecouplingError::Begins { actuator: n + 1, rest: *rest, low, high });
                }
            }
        }
        Ok(Self { model, references, bandwidth_hz, level, plan, plant, inverse, rest, output_at_rest, start })
    }

    fn solve(&self, options: &DecouplingOptions) -> Result<AxesDrive, DecouplingError> {
        let about = |lists: &[Vec<f64>], rest: &[f64]| -> Vec<Vec<f64>> {
            lists.iter().zip(rest).map(|(list, rest)| list.iter().map(|x| x - rest).collect()).collect()
        };
        let mut target = about(self.references, &self.output_at_rest);
        let (mut rounds, mut change) = (0, f64::INFINITY);
        let mut drive: Option<Vec<Vec<f64>>> = None;
        let mut counts;
        loop {
            let wanted = self.plan.apply_matrix(&self.inverse, &target)?;
            let (next, limits) = self.limit(&wanted, options);
            counts = limits;
            let size = next.iter().flatten().map(|u| u * u).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            if let Some(last) = &drive {
                let moved = next.iter().flatten().zip(last.iter().flatten());
                change = moved.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt() / size;
            }
            rounds += 1;
            let predicted = self.simulate(&next)?;
            let done =
                change <= SETTLED || self.model.feedback.is_none() && counts.0.iter().sum::<usize>() == 0;
            if done || (rounds == ROUNDS && change <= ACCEPTED) {
                return Ok(AxesDrive {
                    drive: next,
                    predicted,
                    rest: self.start.is_some().then(|| self.rest.clone()),
                    level: self.level,
                    at_range: counts.0,
                    at_slew: counts.1,
                    rounds,
                    bandwidth_hz: self.bandwidth_hz,
                    rate_error: 0.0,
                });
            }
            if rounds == ROUNDS || change.is_nan() {
                return Err(DecouplingError::NotConverging {
                    rounds,
                    change,
                    bandwidth_hz: self.bandwidth_hz,
                });
            }
            // d = y − P u: what the linear response does not explain.
            let linear = self.plan.apply_matrix(&self.plant, &about(&next, &self.rest))?;
            let lists = self.references.iter().zip(&predicted).zip(&linear);
            target = lists
                .map(|((r, y), linear)| {
                    r.iter().zip(y).zip(linear).map(|((r, y), linear)| r - y + linear).collect()
                })
                .collect();
            drive = Some(next);
        }
    }

    /// Wanted drives about rest, limited; samples at the range and at the slew rate of every actuator.
    #[allow(clippy::type_complexity)]
    fn limit(
        &self,
        wanted: &[Vec<f64>],
        options: &DecouplingOptions,
    ) -> (Vec<Vec<f64>>, (Vec<usize>, Vec<usize>)) {
        let (mut at_range, mut at_slew) = (vec![0; wanted.len()], vec![0; wanted.len()]);
        let mut drive = Vec::with_capacity(wanted.len());
        for (n, ((wanted, limits), rest)) in wanted.iter().zip(&options.limits).zip(&self.rest).enumerate() {
            // A periodic drive comes from its own last sample.
            let mut last =
                if self.start.is_some() { *rest } else { wanted.last().map_or(*rest, |u| rest + u) };
            let one = |u: &f64| {
                let (voltage, by) = limited(rest + u, last, limits, self.model.sample_rate_hz);
                at_range[n] += usize::from(by == Limited::Range);
                at_slew[n] += usize::from(by == Limited::Step);
                last = voltage;
                voltage
            };
            drive.push(wanted.iter().map(one).collect());
        }
        (drive, (at_range, at_slew))
    }

    fn simulate(&self, drive: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, DecouplingError> {
        let samples = drive.first().map_or(0, Vec::len);
        let mut outputs = vec![vec![0.0; samples]; self.model.outputs];
        let mut u = vec![0.0; drive.len()];
        let mut y = vec![0.0; self.model.outputs];
        let mut period = |stream: &mut Streaming<'_>| {
            for k in 0..samples {
                u.iter_mut().zip(drive).for_each(|(u, drive)| *u = drive[k]);
                stream.hold(&u, &mut y);
                outputs.iter_mut().zip(&y).for_each(|(list, y)| list[k] = *y);
            }
            outputs.clone()
        };
        let found = match &self.start {
            Some(start) => period(&mut start.clone()),
            None => {
                let means: Vec<f64> =
                    drive.iter().map(|u| u.iter().sum::<f64>() / samples.max(1) as f64).collect();
                let mut stream = Streaming::new(self.model, &means, self.level);
                let settling = self.model.settling_steps(self.model.level.state(self.level), 20.0);
                let periods = settling.div_ceil(samples * self.model.steps).clamp(2, PERIODS);
                (0..periods).for_each(|_| drop(period(&mut stream)));
                period(&mut stream)
            }
        };
        if found.iter().flatten().all(|y| y.is_finite()) {
            Ok(found)
        } else {
            Err(AxesError::RunsAway.into())
        }
    }
}
