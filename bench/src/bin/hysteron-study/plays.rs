//! Are plays right where they were not trained? Stacks drawn at random outside the model class, virgin and
//! exercised, each identified from a loop and a sweep of one amplitude and scored on a random drive. A
//! density of plays, which is what `--hysteresis prandtl-ishlinskii` fits, against single plays at equal
//! distances.

use hysteron_identify::{CampaignRecord, Demands, FamilyChoice, Options, Watch, identify};
use hysteron_model::Start;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_model::record::ChannelChoice;
use hysteron_model::validate::{Scoring, choose_start, score};
use hysteron_rig::excitation::Excitation;
use hysteron_rig::{Creep, Mode, Plant, Play, PlayStack, Sensor, Truth, measure};
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::Outcome;
use crate::campaign::{random_reference, slow_loop, sweep};
use crate::device::HIGH_V;
use crate::table;

const RATE_HZ: f64 = 10_000.0;
/// Standard deviation of the noise \[µm\].
pub const NOISE_UM: f64 = 0.004;
/// Plays that are fitted.
const PLAYS: usize = 12;
/// Seconds at rest between the exercise and the record.
const PAUSE_S: f64 = 1.0;

/// A device, and the voltage to which it was exercised before every record.
pub struct Bench {
    pub truth: Truth,
    pub exercise_v: Option<f64>,
}

struct Draw(Xoshiro256PlusPlus);

impl Draw {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }
}

impl Bench {
    pub fn at_random(number: usize) -> Self {
        let mut draw = Draw(Xoshiro256PlusPlus::seed_from_u64(number as u64));
        let count = [10, 16, 24, 40][number / 2 % 4];
        let (span, bend) = (draw.between(0.4, 0.95) * HIGH_V, draw.between(0.0, 0.65));
        let plays = (0..count).map(|play| {
            let x = (f64::from(play) + 0.5) / f64::from(count);
            let half_width = span * x * (1.0 - bend + bend * x);
            Play {
                rising_v: half_width * draw.between(0.95, 1.05),
                falling_v: half_width * draw.between(0.95, 1.05),
                weight_um_per_v: 1.6 / f64::from(count) * (1.6 - 1.2 * x) * draw.between(0.5, 1.5),
            }
        });
        let plays = plays.collect();
        let frequency_hz = draw.between(250.0, 900.0);
        let second_hz = frequency_hz * draw.between(1.8, 3.0);
        let stack = PlayStack {
            amplifier_corner_hz: Some(draw.between(800.0, 3000.0)),
            linear_um_per_v: draw.between(1.4, 1.9),
            plays,
            quadratic_per_um: draw.between(-0.002, 0.004),
            cubic_per_um2: draw.between(-6e-5, 6e-5),
            modes: vec![
                Mode { frequency_hz, damping: draw.between(0.02, 0.15), share: 0.93 },
                Mode { frequency_hz: second_hz, damping: 0.03, share: 0.07 },
            ],
            creep: Some(Creep { strength: draw.between(0.0, 0.06), order: 0.15, corner_hz: 0.001 }),
            delay_s: draw.between(1e-4, 6e-4),
        };
        let sensor = Sensor { noise_um: NOISE_UM, adc: None, ..Sensor::default() };
        let truth = Truth { plant: Plant::PlayStack(stack), sensor, ..Truth::default() };
        let exercise_v = (number % 2 == 1).then(|| draw.between(0.3, 1.0) * HIGH_V);
        Self { truth, exercise_v }
    }

    /// The records of a loop and a sweep of one amplitude, and that of a random drive.
    pub fn records(
        &self,
        rate_hz: f64,
        sweep_s: f64,
        seed: u64,
    ) -> Outcome<(Vec<CampaignRecord>, CampaignRecord)> {
        let drives = [slow_loop(rate_hz)?, sweep(rate_hz, 1.0, 100.0, sweep_s)?];
        let fitted =
            drives.iter().enumerate().map(|(stream, drive)| self.record(drive, rate_hz, (seed, stream)));
        let fitted = fitted.collect::<Outcome<Vec<_>>>()?;
        let unseen = self.record(&random_reference(rate_hz, 4.0, seed)?, rate_hz, (seed, drives.len()))?;
        Ok((fitted, unseen))
    }

    /// The record of a drive, after the exercise.
    fn record(
        &self,
        drive: &Excitation,
        rate_hz: f64,
        (seed, stream): (u64, usize),
    ) -> Outcome<CampaignRecord> {
        let first = drive.samples_v.first().copied().unwrap_or(0.0);
        let mut samples = Vec::new();
        if let Some(exercise_v) = self.exercise_v {
            let swing = |k: usize| 0.5 * (1.0 - (std::f64::consts::TAU * k as f64 / rate_hz).cos());
            samples.extend((0..rate_hz as usize).map(|k| first + (exercise_v - first) * swing(k)));
            samples.extend((0..(PAUSE_S * rate_hz) as usize).map(|_| first));
        }
        let before = samples.len();
        samples.extend_from_slice(&drive.samples_v);
        let drive = Excitation::of_samples(drive.name.clone(), drive.description.clone(), samples, rate_hz);
        let mut record = measure(&self.truth, &drive, seed, stream)?.record;
        record.channels.iter_mut().for_each(|channel| drop(channel.samples.drain(..before)));
        Ok(CampaignRecord { data: record.input_output(&ChannelChoice::default())?, role: None })
    }
}

/// RMSE on a record that the fit has not seen, its offset and memory estimated from it \[µm\].
pub fn error_on(unseen: &CampaignRecord, fitted: &[CampaignRecord], options: &Options) -> Outcome<f64> {
    let found = identify(fitted, options, &Watch::silent(), None)?;
    let data = &unseen.data;
    let start = match found.records.first().map(|record| record.start) {
        Some(Start::Remembering { memory, .. }) => Start::Remembering { voltage_v: data.u[0], memory },
        _ => Start::Rest { voltage_v: data.u[0] },
    };
    let (_, simulated) = choose_start(&found.model, data, start, None, &Scoring::default())?;
    Ok(score(data, &simulated, &Scoring::default())?.rmse)
}

pub fn study(benches: usize) -> Outcome<()> {
    let density =
        Options { hysteresis: FamilyChoice::Given(HysteresisForm::plays(PLAYS)), ..Options::default() };
    // A demand on a threshold, here where it is anyway, takes single plays.
    let fixed = vec![("threshold_1".to_owned(), 0.5 * HIGH_V / (PLAYS + 1) as f64)];
    let single = Options { demands: Demands { fixed, ..Demands::default() }, ..density.clone() };
    let (mut rows, mut ratios) = (Vec::new(), Vec::new());
    for number in 0..benches {
        let bench = Bench::at_random(number);
        let (fitted, unseen) = bench.records(RATE_HZ, 10.0, number as u64)?;
        let [of_single, of_density] =
            [error_on(&unseen, &fitted, &single)?, error_on(&unseen, &fitted, &density)?];
        ratios.push(of_density / of_single);
        let Plant::PlayStack(stack) = &bench.truth.plant else { return Err("a bench is a stack".into()) };
        rows.push(vec![
            stack.plays.len().to_string(),
            bench.exercise_v.map_or("virgin".into(), |v| format!("exercised to {v:.1} V")),
            format!("{:.1}", 1e3 * of_single),
            format!("{:.1}", 1e3 * of_density),
            format!("{:.2}", of_density / of_single),
        ]);
    }
    let worst = ratios.iter().copied().fold(0.0, f64::max);
    rows.push(vec![
        "median, worst ratio".into(),
        String::new(),
        String::new(),
        String::new(),
        format!("{:.2}, {worst:.2}", table::median(&ratios)),
    ]);
    let header = ["plays of the device", "before", "single plays [nm]", "density [nm]", "ratio"];
    table::print(&header, &rows)
}
