//! Inverse of a sum of Hammerstein branches for references known ahead.

use nalgebra::DMatrix;

use super::linear::right_inverse;
use super::{AxesDrive, DecouplingError, DecouplingOptions, check};
use crate::axes::CoupledHammerstein;
use crate::compensator::Limits;
use crate::dynamics::{InterSample, InverseAim, ResponseMatrix, Sampling, Scheme, SimulationPlan};
use crate::hammerstein::SETTLING_PERIODS;
use crate::hysteresis::{DriveLimits, Hysteresis};
use crate::invert::BANDWIDTH_SHARE;
use crate::start::Start;
use hysteron_rt::Limited;

/// Held drives with which the model follows the `references` \[µm\], one list per axis; before them every
/// actuator rests, virgin, where their first values are held, or is in their periodic steady state.
///
/// # Errors
/// [`DecouplingError`].
pub fn decouple_branches(
    model: &CoupledHammerstein,
    references: &[Vec<f64>],
    sample_rate_hz: f64,
    options: &DecouplingOptions,
) -> Result<AxesDrive, DecouplingError> {
    let (inputs, outputs) = (model.inputs(), model.outputs());
    check(references, &options.limits, (inputs, outputs))?;
    let samples = references.first().map_or(0, Vec::len);
    let bandwidth_hz = options.bandwidth_hz.unwrap_or(BANDWIDTH_SHARE * sample_rate_hz);
    let initial = if options.periodic { Start::PERIODIC } else { Start::ZERO };
    let plan = SimulationPlan::new(samples, sample_rate_hz, Scheme::BandLimited, initial)?;
    let plant = held_paths(model, &plan)?;
    let aim = InverseAim { bandwidth_hz, error: options.error_at_bandwidth };
    let inverse = plan.inverse_matrix(&plant, aim)?.response;
    let gains: Vec<f64> = model.paths.iter().map(|path| path.gain).collect();
    let back = right_inverse(&DMatrix::from_row_slice(outputs, inputs, &gains))?;
    // A virgin actuator at rest has v = u.
    let at_rest = |n: usize| -> f64 {
        references.iter().zip(&model.offsets).enumerate().map(|(m, (r, o))| back[(n, m)] * (r[0] - o)).sum()
    };
    let rest: Vec<f64> = match options.periodic {
        true => options.limits.iter().map(|limit| 0.5 * limit.low + 0.5 * limit.high).collect(),
        false => (0..inputs).map(at_rest).collect(),
    };
    let origin: Vec<f64> = match options.periodic {
        true => model.offsets.clone(),
        false => references.iter().map(|r| r[0]).collect(),
    };
    let moved: Vec<Vec<f64>> =
        references.iter().zip(&origin).map(|(r, o)| r.iter().map(|r| r - o).collect()).collect();
    let wanted = plan.apply_matrix(&inverse, &moved)?;
    let (mut drive, mut strokes) = (Vec::with_capacity(inputs), Vec::with_capacity(inputs));
    let (mut at_range, mut at_slew) = (Vec::new(), Vec::new());
    for (n, ((wanted, actuator), limit)) in
        wanted.iter().zip(&model.actuators).zip(&options.limits).enumerate()
    {
        let Limits { low, high, slew_v_per_s } = *limit;
        if !(low..=high).contains(&rest[n]) {
            return Err(DecouplingError::Begins { actuator: n + 1, rest: rest[n], low, high });
        }
        let level = if options.periodic { 0.0 } else { rest[n] };
        let mut wanted: Vec<f64> = wanted.iter().map(|v| v + level).collect();
        let settling = if options.periodic { SETTLING_PERIODS * samples } else { 0 };
        if options.periodic {
            wanted = wanted.repeat(SETTLING_PERIODS + 1);
        }
        let limits = DriveLimits {
            range: [low, high],
            step: slew_v_per_s / sample_rate_hz,
            interval_s: Some(1.0 / sample_rate_hz),
        };
        let mut followed = Hysteresis::from(actuator.clone()).follow(&wanted, rest[n], None, &limits)?;
        followed.drive.drain(..settling);
        followed.output.drain(..settling);
        followed.limited.drain(..settling);
        at_range.push(followed.count(Limited::Range));
        at_slew.push(followed.count(Limited::Step));
        strokes.push(followed.output.iter().map(|v| v - level).collect());
        drive.push(followed.drive);
    }
    let mut predicted = plan.apply_matrix(&plant, &strokes)?;
    for (y, origin) in predicted.iter_mut().zip(&origin) {
        y.iter_mut().for_each(|y| *y += origin);
    }
    Ok(AxesDrive {
        drive,
        predicted,
        rest: (!options.periodic).then_some(rest),
        level: 0.0,
        at_range,
        at_slew,
        rounds: 1,
        bandwidth_hz,
        rate_error: 0.0,
    })
}

/// Response of every path to held samples, delay included.
fn held_paths(model: &CoupledHammerstein, plan: &SimulationPlan) -> Result<ResponseMatrix, DecouplingError> {
    let sampling = Sampling { delay: InterSample::BandLimited, reconstruction: InterSample::Hold };
    let mut entries = Vec::with_capacity(model.paths.len());
    for path in &model.paths {
        if path.gain == 0.0 {
            entries.push(plan.empty_response(0));
            continue;
        }
        let mut entry = plan.empty_response(0);
        plan.response(&path.pair().to_transfer_function()?, path.delay_s, sampling, &mut entry)?;
        entries.push(entry);
    }
    Ok(ResponseMatrix { rows: model.outputs(), columns: model.inputs(), entries })
}
