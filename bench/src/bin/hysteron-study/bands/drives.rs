//! Training campaigns, and records of other kinds on which bands are scored.

use hysteron_rig::excitation::{Lines, Phases, Tone, Waveform};

use super::device::{Device, RATE_HZ};
use super::draw::Draw;
use crate::Outcome;
use crate::campaign::{drive, nested_loops, random_reference, slow_loop, sweep};
use crate::device::HIGH_V;
use hysteron_identify::CampaignRecord;

/// A training campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Campaign {
    LoopAndSweep,
    NestedLoopsAndSweep,
    Multisine,
    Random,
}

impl Campaign {
    pub const ALL: [Self; 4] = [Self::LoopAndSweep, Self::NestedLoopsAndSweep, Self::Multisine, Self::Random];

    pub fn in_words(self) -> &'static str {
        match self {
            Self::LoopAndSweep => "loop + sweep",
            Self::NestedLoopsAndSweep => "nested loops + sweep",
            Self::Multisine => "multisine",
            Self::Random => "random",
        }
    }

    pub fn records(self, device: &Device) -> Outcome<Vec<CampaignRecord>> {
        let drives = match self {
            Self::LoopAndSweep => vec![slow_loop(RATE_HZ)?, sweep(RATE_HZ, 1.0, 100.0, 2.0)?],
            Self::NestedLoopsAndSweep => vec![nested_loops(RATE_HZ, 1.5)?, sweep(RATE_HZ, 1.0, 100.0, 2.0)?],
            Self::Multisine => {
                let (lines, phases) = (Lines::default(), Phases::default());
                let of = |period_s, high_hz| Waveform::Multisine {
                    low_hz: 0.5,
                    high_hz,
                    period_s,
                    periods: 2,
                    lines,
                    phases,
                };
                vec![drive(RATE_HZ, of(2.0, 60.0))?]
            }
            Self::Random => vec![random_reference(RATE_HZ, 4.0, 11)?],
        };
        let answer = |(stream, excitation): (usize, &hysteron_rig::excitation::Excitation)| {
            device.answer(self.in_words(), &excitation.samples_v, stream as u64 + 10 * self as u64)
        };
        drives.iter().enumerate().map(answer).collect()
    }
}

/// A kind of scored record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Sines,
    Random,
    Raster,
    MinorLoops,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Sines, Self::Random, Self::Raster, Self::MinorLoops];

    pub fn in_words(self) -> &'static str {
        match self {
            Self::Sines => "sines",
            Self::Random => "random",
            Self::Raster => "raster",
            Self::MinorLoops => "minor loops",
        }
    }

    pub fn record(self, device: &Device, seed: u64) -> Outcome<CampaignRecord> {
        let drive_v = match self {
            Self::Sines => {
                let tone = |frequency_hz, amplitude| Tone { frequency_hz, amplitude, phase_deg: 0.0 };
                let tones = vec![tone(1.7, 1.0), tone(7.3, 0.4), tone(41.0, 0.15)];
                drive(RATE_HZ, Waveform::Sines { tones, duration_s: 3.0 })?.samples_v
            }
            Self::Random => random_reference(RATE_HZ, 3.0, 1000 + seed)?.samples_v,
            Self::Raster => {
                let raster = Waveform::Raster {
                    line_hz: 9.0,
                    lines: 27,
                    return_fraction: 0.3,
                    turnaround_fraction: 0.05,
                };
                let samples = drive(RATE_HZ, raster)?.samples_v;
                samples.iter().map(|u| 0.7 * u).collect()
            }
            Self::MinorLoops => minor_loops(seed),
        };
        device.answer(self.in_words(), &drive_v, 100 + self as u64)
    }
}

/// Up to a bias, three small loops about it at 3 Hz, on to the next of four.
fn minor_loops(seed: u64) -> Vec<f64> {
    let mut draw = Draw::new(seed ^ 0x1007);
    let smooth = |x: f64| 0.5 * (1.0 - (std::f64::consts::PI * x).cos());
    let mut samples = vec![0.0];
    for _ in 0..4 {
        let amplitude = draw.between(0.04, 0.2);
        let bias = draw.between(amplitude, 1.0 - amplitude);
        let from = samples.last().copied().unwrap_or(0.0) / HIGH_V;
        let moving = (0.2 * RATE_HZ) as usize;
        samples
            .extend((1..=moving).map(|k| HIGH_V * (from + (bias - from) * smooth(k as f64 / moving as f64))));
        let looping = RATE_HZ as usize;
        samples.extend((1..=looping).map(|k| {
            let angle = std::f64::consts::TAU * 3.0 * k as f64 / RATE_HZ;
            HIGH_V * (bias + amplitude * angle.sin())
        }));
    }
    samples
}
