//! Linear operators that the columns pass through.

use super::MisfitError;
use crate::dynamics::delay::delay_in_place;
use crate::dynamics::{Dynamics, Response, Sampling, SimulationPlan};
use crate::hammerstein::Model;
use crate::start::Start;

/// Delay and dynamics of a model on one grid, for many inputs.
pub(super) enum ModelResponse {
    Delay { samples: f64 },
    Linear { plan: Box<SimulationPlan>, response: Box<Response>, periodic: bool },
}

impl ModelResponse {
    pub(super) fn new(model: &Model, rows: usize, rate_hz: f64, periodic: bool) -> Result<Self, MisfitError> {
        let g = match &model.dynamics {
            Dynamics::None => return Ok(Self::Delay { samples: model.delay_s * rate_hz }),
            Dynamics::Arx(_) => return Err(MisfitError::OneRate),
            Dynamics::Integer(_) | Dynamics::Fractional(_)
                if model.scheme.parameters_belong_to_sample_rate() =>
            {
                return Err(MisfitError::OneRate);
            }
            Dynamics::Integer(g) | Dynamics::Fractional(g) => g,
        };
        let initial = if periodic { Start::PERIODIC } else { Start::ZERO };
        let plan = SimulationPlan::new(rows, rate_hz, model.scheme, initial)?;
        let mut response = plan.empty_response(0);
        let sampling = Sampling { reconstruction: model.inter_sample, ..Sampling::of(model.scheme) };
        plan.response(g, model.delay_s, sampling, &mut response)?;
        Ok(Self::Linear { plan: Box::new(plan), response: Box::new(response), periodic })
    }

    /// Response to `v` about its first value.
    pub(super) fn of(&self, mut v: Vec<f64>) -> Result<Vec<f64>, MisfitError> {
        let first = v.first().copied().unwrap_or(0.0);
        v.iter_mut().for_each(|v| *v -= first);
        match self {
            Self::Delay { samples } => delay_in_place(&mut v, *samples, 0.0),
            Self::Linear { plan, response, periodic } => {
                let mut y = vec![0.0; v.len()];
                plan.apply(response, &plan.transform(&v)?, &mut plan.workspace(), &mut y)?;
                let first = y.first().copied().filter(|_| *periodic).unwrap_or(0.0);
                y.iter_mut().for_each(|y| *y -= first);
                v = y;
            }
        }
        Ok(v)
    }
}

/// x/(1 + sT) about its first value, exact for straight lines between samples; `time` T in samples. From rest
/// at the first sample, or after the same record as a cycle before.
pub(super) fn lag(x: &[f64], time: f64, settled: bool) -> Vec<f64> {
    let decay = (-1.0 / time).exp();
    // ∫ over one step of the response to a straight line: weights of its ends.
    let mean = -(-1.0 / time).exp_m1() * time;
    let (of_end, of_begin) = (1.0 - mean, mean - decay);
    let first = x.first().copied().unwrap_or(0.0);
    let pass = |state: f64| -> Vec<f64> {
        let step = |state: &mut f64, pair: &[f64]| {
            *state = decay * *state + of_begin * (pair[0] - first) + of_end * (pair[1] - first);
            Some(*state)
        };
        std::iter::once(state).chain(x.windows(2).scan(state, step)).collect()
    };
    let lagged = pass(0.0);
    match lagged.last() {
        Some(&end) if settled => {
            // The cycle that repeats: its first value is its last.
            let fixed = end / (1.0 - decay.powi(x.len().max(2) as i32 - 1)).max(f64::MIN_POSITIVE);
            pass(fixed)
        }
        _ => lagged,
    }
}

#[cfg(test)]
mod tests {
    use super::lag;

    #[test]
    fn a_lag_answers_a_step_and_a_ramp_as_tables_say() {
        let time = 7.0;
        let ramp: Vec<f64> = (0..60).map(|k| 2.0 + 0.5 * f64::from(k)).collect();
        for (k, y) in lag(&ramp, time, false).iter().enumerate() {
            let t = k as f64;
            let expected = 0.5 * (t - time * (1.0 - (-t / time).exp()));
            assert!((y - expected).abs() < 1e-12, "{k}: {y} {expected}");
        }
    }

    #[test]
    fn a_settled_lag_repeats_its_cycle() {
        let cycle: Vec<f64> = (0..=100).map(|k| (f64::from(k) * 0.062_831_853_071_795_86).sin()).collect();
        let settled = lag(&cycle, 30.0, true);
        assert!((settled[0] - settled[100]).abs() < 1e-12);
        let long: Vec<f64> = (0..=3000).map(|k| (f64::from(k) * 0.062_831_853_071_795_86).sin()).collect();
        let late = lag(&long, 30.0, false);
        assert!((late[2900] - settled[0]).abs() < 1e-9 && (late[2950] - settled[50]).abs() < 1e-9);
    }
}
