//! Columns of a fit and their derivatives beside the FFTs they need.

use hysteron_model::Start;
use std::hint::black_box;

use hysteron_model::dynamics::{Creep, DynamicForm, Linearised, Modes, Sampling, Scheme, SimulationPlan};
use hysteron_numeric::fft::RealFft;
use serde::Deserialize;

use crate::answer::{Answer, ColumnTimes};
use crate::error::BenchError;
use crate::fractional::SAMPLE_RATE_HZ;
use crate::stopwatch::time;

/// Which columns to work out.
#[derive(Debug, Deserialize)]
pub struct Request {
    /// Samples of the record.
    samples: usize,
    /// Turns.
    repetitions: usize,
    /// Name of the scheme.
    scheme: String,
}

/// Parameters of the fractional form, and a delay that is no whole number of samples.
const PARAMETERS: [f64; 4] = [318.0, 0.65, 2.0384, 1.0523];
const DELAY_S: f64 = 2.3e-4;

impl Request {
    /// Takes turns on one FFT pair, one column, an objective of three columns and its derivatives, three
    /// values with them.
    pub fn run(self) -> Result<Answer, BenchError> {
        let scheme = Scheme::ALL.into_iter().find(|s| s.name() == self.scheme).ok_or(BenchError::Scheme)?;
        let plan = SimulationPlan::new(self.samples, SAMPLE_RATE_HZ, scheme, Start::ZERO)?;
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        let sampling = Sampling::of(scheme);
        let signal: Vec<f64> = (0..self.samples).map(|k| 1.0 - (k as f64 * 1e-3).cos()).collect();
        let kept = plan.transform(&signal)?;
        let mut fresh = plan.empty_spectrum();
        let mut workspace = plan.workspace();
        let mut response = plan.empty_response(PARAMETERS.len());
        let mut linearised = Linearised::new();
        form.linearise(&PARAMETERS, &mut linearised)?;
        let mut tf = linearised.transfer_function.clone();
        let mut output = vec![0.0; self.samples];
        let fft = RealFft::new(plan.transform_length());
        let (mut real, mut bins) = (fft.forward.make_input_vec(), fft.forward.make_output_vec());
        let longest = fft.forward.get_scratch_len().max(fft.inverse.get_scratch_len());
        let mut scratch = vec![Default::default(); longest];
        let mut answer = ColumnTimes::starting(plan.transform_length());
        for _ in 0..self.repetitions {
            let ffts = time::<BenchError>(1, || {
                fft.transform_with(&mut scratch, black_box(&mut real), &mut bins);
                fft.invert_with(&mut scratch, black_box(&mut bins), &mut real);
                Ok(())
            })?;
            let column = time::<BenchError>(1, || {
                form.write_to(black_box(&PARAMETERS), &mut tf)?;
                plan.transform_into(&signal, &mut workspace, &mut fresh)?;
                plan.response(&tf, DELAY_S, sampling, &mut response)?;
                Ok(plan.apply(&response, &fresh, &mut workspace, &mut output)?)
            })?;
            let objective = time::<BenchError>(1, || {
                form.write_to(black_box(&PARAMETERS), &mut tf)?;
                plan.transform_into(&signal, &mut workspace, &mut fresh)?;
                plan.response(&tf, DELAY_S, sampling, &mut response)?;
                for input in [&fresh, &kept, &kept] {
                    plan.apply(&response, input, &mut workspace, &mut output)?;
                }
                Ok(())
            })?;
            let jacobian = time::<BenchError>(1, || {
                form.linearise(black_box(&PARAMETERS), &mut linearised)?;
                plan.transform_into(&signal, &mut workspace, &mut fresh)?;
                plan.response_with_tangents(&linearised, DELAY_S, sampling, &mut response)?;
                for input in [&fresh, &kept, &kept] {
                    plan.apply(&response, input, &mut workspace, &mut output)?;
                }
                for which in 0..response.tangents() {
                    plan.apply_tangent(&response, which, &fresh, &mut workspace, &mut output)?;
                }
                Ok(())
            })?;
            let g = time::<BenchError>(1, || Ok(plan.response(&tf, DELAY_S, sampling, &mut response)?))?;
            let tangents = time::<BenchError>(1, || {
                Ok(plan.response_with_tangents(&linearised, DELAY_S, sampling, &mut response)?)
            })?;
            for (least, timing) in [
                (&mut answer.fft_pair_s, &ffts),
                (&mut answer.response_s, &g),
                (&mut answer.response_with_tangents_s, &tangents),
                (&mut answer.column_s, &column),
                (&mut answer.objective_s, &objective),
                (&mut answer.jacobian_s, &jacobian),
            ] {
                *least = timing.seconds.iter().copied().fold(*least, f64::min);
                answer.allocations += timing.allocations;
            }
        }
        Ok(Answer::Columns(answer))
    }
}
