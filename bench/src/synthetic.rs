//! Records of any length to time the joint fit on, made by the model it fits.

use std::error::Error;
use std::f64::consts::TAU;

use hysteron_identify::{CampaignRecord, Choice, DynamicsChoice, JointObjective, Options, RecordRole};
use hysteron_model::Start;
use hysteron_model::dynamics::{Creep, DynamicForm, Dynamics, Modes, Scheme};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis};
use hysteron_model::record::{InputOutput, InterSample, TimeBase};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// Sample rate of the records \[Hz\].
const SAMPLE_RATE_HZ: f64 = 10_000.0;
/// Half width of the noise, which is uniform \[µm\].
const NOISE_UM: f64 = 0.01;
const NATURAL_FREQUENCY_HZ: f64 = 318.0;
const DAMPING: f64 = 0.65;
const ORDERS: [f64; 2] = [2.0384, 1.0523];
pub const BETA: f64 = 0.35;
pub const GAMMA: f64 = 0.08;
const DELAY_S: f64 = 1.2e-4;

/// 0 to 10 V, faster from 20 to 80 Hz; each record begins a little faster than the one before.
pub fn drive(samples: usize, record: usize) -> Vec<f64> {
    let begin = 20.0 + record as f64;
    let phase = |t: f64, whole: f64| TAU * (begin + 30.0 * t / whole) * t;
    let whole = samples as f64 / SAMPLE_RATE_HZ;
    (0..samples).map(|k| 5.0 - 5.0 * phase(k as f64 / SAMPLE_RATE_HZ, whole).cos()).collect()
}

/// The problem on `records` records of `samples` samples each, and a point near its minimum.
pub fn objective(
    samples: usize,
    records: usize,
) -> Result<(JointObjective, Vec<f64>), Box<dyn Error + Send + Sync>> {
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let [order2, order1] = ORDERS;
    let model = Model {
        hysteresis: Hysteresis::from(BoucWen::new(vec![3.2, -0.02], 1.1, BETA, GAMMA, 1.0)?),
        dynamics: Dynamics::Fractional(form.transfer_function(&[
            NATURAL_FREQUENCY_HZ,
            DAMPING,
            order2,
            order1,
        ])?),
        offset: 0.0,
        delay_s: DELAY_S,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut campaign = Vec::new();
    for record in 0..records {
        let u = drive(samples, record);
        let mut y = model.simulate(&u, Some(SAMPLE_RATE_HZ), &Start::Rest { voltage_v: u[0] })?;
        for y in &mut y {
            *y += NOISE_UM * ((rng.next_u64() >> 11) as f64 / (1u64 << 52) as f64 - 1.0);
        }
        let data = InputOutput::new(&format!("record {record}"), TimeBase::uniform(SAMPLE_RATE_HZ), u, y)?;
        campaign.push(CampaignRecord { data, role: Some(RecordRole::Dynamic) });
    }
    let options =
        Options { dynamics: DynamicsChoice::Fractional, degree: Choice::Given(2), ..Options::default() };
    let objective = JointObjective::new(&campaign, &options, false)?;
    // A little off the truth, as a fit on its way.
    let mut x = vec![1.1 * BETA, 0.9 * GAMMA, 1.02 * NATURAL_FREQUENCY_HZ, DAMPING, order2, order1, DELAY_S];
    x.resize(x.len() + records, 0.1);
    Ok((objective, x))
}

/// Moves `x` by a rounding error or so, to a point where nothing has been worked out yet: a fit keeps what
/// the hysteresis puts out while only the dynamics change, which must not shorten what is timed.
pub fn move_on(x: &mut [f64]) {
    x[0] *= 1.0 + 1e-12;
}
