//! The kinds of waveform and their parameters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::Check;
use super::multisine::{Lines, Phases};
use super::slow::Tone;
use super::sweep::SweepLaw;
use super::{Shape, multisine, paths, random, slow, sweep, whole_samples};
use crate::RigError;

/// The waveform between lead-in and lead-out. Amplitudes are fractions of the range `high_v − low_v`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Waveform {
    /// u = low + range·(1 − cos 2πft)/2: starts at `low_v` with zero slope.
    Sine {
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Number of periods, not necessarily whole.
        periods: f64,
    },
    /// Sum of sines, shifted and scaled to fill the range.
    Sines {
        /// The sines.
        tones: Vec<Tone>,
        /// Duration \[s\].
        duration_s: f64,
    },
    /// Slow loops of different amplitude, each starting and ending at `low_v`: u = low + a·range·(1 − cos
    /// 2πft)/2.
    NestedLoops {
        /// Frequency of every loop \[Hz\].
        frequency_hz: f64,
        /// Amplitudes in the order played, each above 0 and at most 1.
        amplitudes: Vec<f64>,
        /// Periods of each amplitude.
        periods_each: u32,
    },
    /// First-order reversal curves: up to `high_v`, then down to a reversal voltage and back up, for
    /// reversals that go in equal steps from near `high_v` to `low_v`, at last down to `low_v` (Mayergoyz
    /// 1986, doi:10.1103/PhysRevLett.56.1518).
    ReversalCurves {
        /// Number of curves.
        curves: u32,
        /// Duration of a ramp over the whole range \[s\].
        ramp_s: f64,
    },
    /// Equal steps up to `high_v` and down again, each held: shows creep.
    Staircase {
        /// Steps from `low_v` to `high_v`.
        steps: u32,
        /// Time each of the 2·steps + 1 levels is held \[s\].
        hold_s: f64,
        /// Raised-cosine transition between levels \[s\]; 0: a jump.
        transition_s: f64,
    },
    /// Triangle from `low_v`.
    Triangle {
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Number of periods, not necessarily whole.
        periods: f64,
    },
    /// Fast axis of a raster scan: constant speed up, constant speed back, parabolic turnarounds, from
    /// `low_v`.
    Raster {
        /// Line rate \[Hz\].
        line_hz: f64,
        /// Number of lines.
        lines: u32,
        /// Fraction of a line spent on the return, between 0 and 1; ½ is a triangle.
        return_fraction: f64,
        /// Fraction of a line spent in each turnaround, at most the shorter of forward and return.
        turnaround_fraction: f64,
    },
    /// Preconditioning (demagnetising): a sine about mid-range whose amplitude decays from half the range, u
    /// = mid − range/2·ratio^(ft)·cos 2πft. Wipes out the memory; ends at mid-range.
    Decaying {
        /// Frequency \[Hz\].
        frequency_hz: f64,
        /// Cycles.
        cycles: f64,
        /// Ratio of the amplitudes of successive cycles, between 0 and 1.
        ratio: f64,
    },
    /// u = low + range·(1 − cos φ(t))/2 with instantaneous frequency φ'/2π going from `start_hz` to `end_hz`.
    Sweep {
        /// Frequency law.
        #[serde(default)]
        law: SweepLaw,
        /// Frequency at the start \[Hz\].
        start_hz: f64,
        /// Frequency at the end \[Hz\].
        end_hz: f64,
        /// Duration \[s\].
        duration_s: f64,
    },
    /// Equal amplitudes at multiples of 1/period and none elsewhere (except the mean), shifted and scaled to
    /// fill the range.
    Multisine {
        /// Lowest frequency \[Hz\].
        low_hz: f64,
        /// Highest frequency \[Hz\].
        high_hz: f64,
        /// Period \[s\], a whole number of samples; its inverse is the frequency resolution.
        period_s: f64,
        /// Number of periods played.
        periods: u32,
        /// Which multiples are excited.
        #[serde(default)]
        lines: Lines,
        /// Choice of the phases.
        #[serde(default)]
        phases: Phases,
    },
    /// Gaussian noise with a flat spectrum between two frequencies and none outside, moved and scaled to fill
    /// the range.
    Random {
        /// Lowest frequency \[Hz\].
        low_hz: f64,
        /// Highest frequency \[Hz\].
        high_hz: f64,
        /// Duration \[s\].
        duration_s: f64,
    },
}

impl Waveform {
    /// Kind as written in a specification.
    pub fn kind(&self) -> &'static str {
        match self {
            Waveform::Sine { .. } => "sine",
            Waveform::Sines { .. } => "sines",
            Waveform::NestedLoops { .. } => "nested_loops",
            Waveform::ReversalCurves { .. } => "reversal_curves",
            Waveform::Staircase { .. } => "staircase",
            Waveform::Triangle { .. } => "triangle",
            Waveform::Raster { .. } => "raster",
            Waveform::Decaying { .. } => "decaying",
            Waveform::Sweep { .. } => "sweep",
            Waveform::Multisine { .. } => "multisine",
            Waveform::Random { .. } => "random",
        }
    }

    /// Duration of the waveform proper \[s\].
    pub fn duration_s(&self) -> f64 {
        match self {
            Waveform::Sine { frequency_hz, periods } | Waveform::Triangle { frequency_hz, periods } => {
                periods / frequency_hz
            }
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                amplitudes.len() as f64 * f64::from(*periods_each) / frequency_hz
            }
            // Up once, every curve down and up, down at last.
            Waveform::ReversalCurves { curves, ramp_s } => ramp_s * (3.0 + f64::from(*curves)),
            Waveform::Staircase { steps, hold_s, transition_s } => {
                hold_s * (2.0 * f64::from(*steps) + 1.0) + transition_s * 2.0 * f64::from(*steps)
            }
            Waveform::Raster { line_hz, lines, .. } => f64::from(*lines) / line_hz,
            Waveform::Decaying { frequency_hz, cycles, .. } => cycles / frequency_hz,
            Waveform::Multisine { period_s, periods, .. } => period_s * f64::from(*periods),
            Waveform::Sines { duration_s, .. }
            | Waveform::Sweep { duration_s, .. }
            | Waveform::Random { duration_s, .. } => *duration_s,
        }
    }

    /// One line with the numbers and units.
    pub(super) fn describe(&self) -> String {
        match self {
            Waveform::Sine { frequency_hz, periods } => format!("sine {frequency_hz} Hz, {periods} periods"),
            Waveform::Sines { tones, duration_s } => {
                let list: Vec<String> = tones.iter().map(|t| t.frequency_hz.to_string()).collect();
                format!("sum of sines at {} Hz, {duration_s} s", list.join(", "))
            }
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                format!(
                    "loops at {frequency_hz} Hz, {periods_each} periods each of amplitudes {amplitudes:?}"
                )
            }
            Waveform::ReversalCurves { curves, ramp_s } => {
                format!("{curves} first-order reversal curves, {ramp_s} s for a full ramp")
            }
            Waveform::Staircase { steps, hold_s, transition_s } => {
                format!(
                    "staircase of {steps} steps up and down, held {hold_s} s, transitions {transition_s} s"
                )
            }
            Waveform::Triangle { frequency_hz, periods } => {
                format!("triangle {frequency_hz} Hz, {periods} periods")
            }
            Waveform::Raster { line_hz, lines, return_fraction, turnaround_fraction } => format!(
                "raster of {lines} lines at {line_hz} Hz, return {return_fraction} and turnarounds \
                 {turnaround_fraction} of a line"
            ),
            Waveform::Decaying { frequency_hz, cycles, ratio } => {
                format!("decaying sine {frequency_hz} Hz, {cycles} cycles, ratio {ratio} a cycle")
            }
            Waveform::Sweep { law, start_hz, end_hz, duration_s } => {
                let law = match law {
                    SweepLaw::Linear => "linear",
                    SweepLaw::Logarithmic => "logarithmic",
                };
                format!("{law} sweep {start_hz} Hz to {end_hz} Hz in {duration_s} s")
            }
            Waveform::Multisine { low_hz, high_hz, period_s, periods, lines, phases } => {
                let lines = match lines {
                    Lines::Full => "all lines".to_owned(),
                    Lines::Odd => "odd lines".to_owned(),
                    Lines::OddWithDetection { group } => format!("odd lines but one of every {group}"),
                };
                let phases = match phases {
                    Phases::Random => "random phases",
                    Phases::Schroeder => "Schroeder phases",
                    Phases::Optimised => "phases of optimised crest factor",
                };
                format!(
                    "multisine {low_hz} Hz to {high_hz} Hz, {lines}, {phases}, {periods} periods of \
                     {period_s} s"
                )
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                format!("Gaussian noise {low_hz} Hz to {high_hz} Hz, {duration_s} s")
            }
        }
    }

    pub(super) fn validate(&self, check: &Check, fs: f64) -> Result<(), RigError> {
        match self {
            Waveform::Sine { frequency_hz, periods } | Waveform::Triangle { frequency_hz, periods } => {
                check.below_nyquist("frequency_hz", *frequency_hz, fs)?;
                check.positive("periods", *periods)
            }
            Waveform::Sines { tones, duration_s } => {
                check.not_empty("tones", tones)?;
                for tone in tones {
                    check.below_nyquist("tones.frequency_hz", tone.frequency_hz, fs)?;
                    check.positive("tones.amplitude", tone.amplitude)?;
                    check.finite("tones.phase_deg", tone.phase_deg)?;
                }
                check.positive("duration_s", *duration_s)
            }
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                check.below_nyquist("frequency_hz", *frequency_hz, fs)?;
                check.parts("amplitudes", amplitudes)?;
                check.at_least("periods_each", f64::from(*periods_each), 1.0)
            }
            Waveform::ReversalCurves { curves, ramp_s } => {
                check.at_least("curves", f64::from(*curves), 1.0)?;
                // The shortest curve must hold a sample on either side of its reversal.
                check.at_least("ramp_s", *ramp_s, f64::from(*curves) / fs)
            }
            Waveform::Staircase { steps, hold_s, transition_s } => {
                check.at_least("steps", f64::from(*steps), 1.0)?;
                check.at_least("hold_s", *hold_s, 1.0 / fs)?;
                check.not_negative("transition_s", *transition_s)
            }
            Waveform::Raster { line_hz, lines, return_fraction, turnaround_fraction } => {
                check.below_nyquist("line_hz", *line_hz, fs)?;
                check.at_least("lines", f64::from(*lines), 1.0)?;
                check.between("return_fraction", *return_fraction, 0.0, 1.0)?;
                let most = return_fraction.min(1.0 - return_fraction);
                if !(0.0..=most).contains(turnaround_fraction) {
                    let expected = format!("from 0 to {most}, the shorter of the two ways");
                    return Err(check.wrong("turnaround_fraction", *turnaround_fraction, expected));
                }
                Ok(())
            }
            Waveform::Decaying { frequency_hz, cycles, ratio } => {
                check.below_nyquist("frequency_hz", *frequency_hz, fs)?;
                check.positive("cycles", *cycles)?;
                check.between("ratio", *ratio, 0.0, 1.0)
            }
            Waveform::Sweep { start_hz, end_hz, duration_s, .. } => {
                check.below_nyquist("start_hz", *start_hz, fs)?;
                check.below_nyquist("end_hz", *end_hz, fs)?;
                check.positive("duration_s", *duration_s)
            }
            Waveform::Multisine { low_hz, high_hz, period_s, periods, lines, .. } => {
                check.positive("period_s", *period_s)?;
                check.band(*low_hz, *high_hz, fs)?;
                if whole_samples(period_s * fs).is_none() {
                    let expected = format!("a whole number of samples at {fs} Hz");
                    return Err(check.wrong("period_s", *period_s, expected));
                }
                check.at_least("periods", f64::from(*periods), 1.0)?;
                let mut least = 2.0;
                if let Lines::OddWithDetection { group } = lines {
                    check.at_least("lines.group", f64::from(*group), 2.0)?;
                    least = 2.0 * f64::from(*group);
                }
                check.lines_in_band("period_s", (*low_hz, *high_hz), *period_s, least)
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                check.positive("duration_s", *duration_s)?;
                check.band(*low_hz, *high_hz, fs)?;
                check.lines_in_band("duration_s", (*low_hz, *high_hz), *duration_s, 1.0)
            }
        }
    }

    pub(super) fn shape(&self, fs: f64, seed: u64) -> Shape {
        match self {
            Waveform::Sine { frequency_hz, periods } => slow::sine(*frequency_hz, *periods, fs),
            Waveform::Sines { tones, duration_s } => slow::sines(tones, *duration_s, fs),
            Waveform::NestedLoops { frequency_hz, amplitudes, periods_each } => {
                slow::nested_loops(*frequency_hz, amplitudes, *periods_each, fs)
            }
            Waveform::ReversalCurves { curves, ramp_s } => paths::reversal_curves(*curves, *ramp_s, fs),
            Waveform::Staircase { steps, hold_s, transition_s } => {
                paths::staircase(*steps, *hold_s, *transition_s, fs)
            }
            Waveform::Triangle { frequency_hz, periods } => {
                paths::raster(*frequency_hz, *periods, 0.5, 0.0, fs)
            }
            Waveform::Raster { line_hz, lines, return_fraction, turnaround_fraction } => {
                paths::raster(*line_hz, f64::from(*lines), *return_fraction, *turnaround_fraction, fs)
            }
            Waveform::Decaying { frequency_hz, cycles, ratio } => {
                slow::decaying(*frequency_hz, *cycles, *ratio, fs)
            }
            Waveform::Sweep { law, start_hz, end_hz, duration_s } => {
                sweep::sweep(*law, *start_hz, *end_hz, *duration_s, fs)
            }
            Waveform::Multisine { low_hz, high_hz, period_s, periods, lines, phases } => {
                let request = multisine::Request {
                    first_line: (low_hz * period_s - 1e-9).ceil().max(1.0) as usize,
                    last_line: (high_hz * period_s + 1e-9).floor() as usize,
                    period_samples: (period_s * fs).round() as usize,
                    periods: *periods as usize,
                    lines: *lines,
                    phases: *phases,
                };
                multisine::multisine(&request, fs, seed)
            }
            Waveform::Random { low_hz, high_hz, duration_s } => {
                random::band_limited(*low_hz, *high_hz, *duration_s, fs, seed)
            }
        }
    }
}
