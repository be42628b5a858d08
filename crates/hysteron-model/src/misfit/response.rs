//! Linear operators that the columns pass through.

use super::MisfitError;
use super::steps::Steps;
use crate::dynamics::delay::delay_in_place;
use crate::dynamics::{
    Dynamics, Response, Sampling, SimulationPlan, StampedPlan, StampedResponse, StampedWorkspace,
};
use crate::hammerstein::Model;
use crate::record::InterSample;
use crate::start::Start;

/// Delay and dynamics of a model at the times of some rows, for many inputs.
pub(super) enum ModelResponse {
    Delay { samples: f64 },
    DelayOnStamps { times_s: Vec<f64>, delay_s: f64 },
    Linear { plan: Box<SimulationPlan>, response: Box<Response>, periodic: bool },
    LinearOnStamps { plan: Box<StampedPlan>, response: Box<StampedResponse> },
}

impl ModelResponse {
    pub(super) fn new(
        model: &Model,
        rows: usize,
        steps: &Steps,
        periodic: bool,
    ) -> Result<Self, MisfitError> {
        let delay_s = model.delay_s;
        let g = match &model.dynamics {
            Dynamics::None => {
                return Ok(match steps {
                    Steps::Even(step_s) => Self::Delay { samples: delay_s / step_s },
                    Steps::Uneven(times_s) => Self::DelayOnStamps { times_s: times_s.clone(), delay_s },
                });
            }
            Dynamics::Arx(_) => return Err(MisfitError::OneRate),
            Dynamics::Integer(_) | Dynamics::Fractional(_)
                if model.scheme.parameters_belong_to_sample_rate() =>
            {
                return Err(MisfitError::OneRate);
            }
            Dynamics::Integer(g) | Dynamics::Fractional(g) => g,
        };
        let step_s = match steps {
            Steps::Even(step_s) => *step_s,
            Steps::Uneven(times_s) => {
                let held = model.inter_sample == InterSample::Hold;
                let plan = StampedPlan::new(times_s.clone(), times_s.clone(), held)?;
                let mut response = plan.empty_response();
                plan.response(g, None, delay_s, &mut response)?;
                return Ok(Self::LinearOnStamps { plan: Box::new(plan), response: Box::new(response) });
            }
        };
        let initial = if periodic { Start::PERIODIC } else { Start::ZERO };
        let plan = SimulationPlan::new(rows, 1.0 / step_s, model.scheme, initial)?;
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
            Self::DelayOnStamps { times_s, delay_s } => v = delayed(times_s, *delay_s, &v),
            Self::LinearOnStamps { plan, response } => {
                let mut y = vec![0.0; v.len()];
                plan.apply(response, &v, &mut StampedWorkspace::default(), &mut y)?;
                v = y;
            }
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

/// `v` at each time less the delay, straight between rows, 0 before.
fn delayed(times_s: &[f64], delay_s: f64, v: &[f64]) -> Vec<f64> {
    let mut after = 0;
    let at = |time_s: &f64| {
        let wanted = time_s - delay_s;
        while times_s.get(after).is_some_and(|time| *time <= wanted) {
            after += 1;
        }
        let Some(before) = after.checked_sub(1) else { return 0.0 };
        match times_s.get(after) {
            Some(to) => {
                v[before] + (v[after] - v[before]) * (wanted - times_s[before]) / (to - times_s[before])
            }
            None => v[before],
        }
    };
    times_s.iter().map(at).collect()
}

/// x/(1 + sT) about its first value, exact for straight lines between samples; `step(k)`: time from the sample
/// before to sample k over T. From rest at the first sample, or after the same record as a cycle before.
pub(super) fn lag(x: &[f64], step: impl Fn(usize) -> f64, settled: bool) -> Vec<f64> {
    let first = x.first().copied().unwrap_or(0.0);
    // What a step makes of the state before, and the factor on it.
    let (mut of_step, mut factors) = (f64::NAN, (0.0, 0.0, 0.0));
    let mut factors_of = |k: usize| {
        let h = step(k);
        if h != of_step {
            // ∫ over one step of the response to a straight line: weights of its ends.
            let decay = (-h).exp();
            let mean = if h > 0.0 { -(-h).exp_m1() / h } else { 1.0 };
            (of_step, factors) = (h, (decay, mean - decay, 1.0 - mean));
        }
        factors
    };
    // The states, and what is left of the first one at the end.
    let mut pass = |state: f64| -> (Vec<f64>, f64) {
        let mut left = 1.0;
        let next = |state: &mut f64, (k, pair): (usize, &[f64])| {
            let (decay, of_begin, of_end) = factors_of(k + 1);
            *state = decay * *state + of_begin * (pair[0] - first) + of_end * (pair[1] - first);
            left *= decay;
            Some(*state)
        };
        let states = std::iter::once(state).chain(x.windows(2).enumerate().scan(state, next)).collect();
        (states, left)
    };
    let (lagged, left) = pass(0.0);
    match lagged.last() {
        Some(&end) if settled => {
            // The cycle that repeats: its first value is its last.
            let fixed = end / (1.0 - left).max(f64::MIN_POSITIVE);
            pass(fixed).0
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
        for (k, y) in lag(&ramp, |_| 1.0 / time, false).iter().enumerate() {
            let t = k as f64;
            let expected = 0.5 * (t - time * (1.0 - (-t / time).exp()));
            assert!((y - expected).abs() < 1e-12, "{k}: {y} {expected}");
        }
    }

    #[test]
    fn a_settled_lag_repeats_its_cycle() {
        let cycle: Vec<f64> = (0..=100).map(|k| (f64::from(k) * 0.062_831_853_071_795_86).sin()).collect();
        let settled = lag(&cycle, |_| 1.0 / 30.0, true);
        assert!((settled[0] - settled[100]).abs() < 1e-12);
        let long: Vec<f64> = (0..=3000).map(|k| (f64::from(k) * 0.062_831_853_071_795_86).sin()).collect();
        let late = lag(&long, |_| 1.0 / 30.0, false);
        assert!((late[2900] - settled[0]).abs() < 1e-9 && (late[2950] - settled[50]).abs() < 1e-9);
    }
}
