//! Waveforms on the command line.

use clap::{Args, Subcommand, ValueEnum};
use hysteron_rig::excitation::{Lines, Phases, SweepLaw, Tone, Waveform};

use super::Drive;
use crate::numbers::{count, not_negative, number, positive};

/// The waveforms.
#[derive(Subcommand)]
pub enum Wave {
    /// Sine from the lowest voltage, with zero slope at the start
    Sine(Periodic),
    /// Triangle from the lowest voltage
    Triangle(Periodic),
    /// Sum of sines that fills the range
    Sines(Sines),
    /// Slow loops of different amplitude: the quasi-static record of a campaign
    NestedLoops(NestedLoops),
    /// First-order reversal curves
    ReversalCurves(ReversalCurves),
    /// Steps up and down, each held: shows creep
    Staircase(Staircase),
    /// Fast axis of a raster scan with smooth turnarounds
    Raster(Raster),
    /// Sine of decaying amplitude, which demagnetises the actuator (wipes out its hysteresis memory)
    Decaying(Decaying),
    /// Sine whose frequency runs from one to another
    Sweep(Sweep),
    /// Multisine of low crest factor: frequency response with its nonlinear distortion
    Multisine(Multisine),
    /// Noise between two frequencies
    Random(Random),
}

/// A periodic waveform.
#[derive(Args)]
pub struct Periodic {
    /// Frequency in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    frequency: f64,
    /// Number of periods
    #[arg(long, value_name = "N", default_value_t = 3.0, value_parser = positive, allow_hyphen_values = true)]
    periods: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct Sines {
    /// One sine as HZ:AMPLITUDE or HZ:AMPLITUDE:DEGREES, amplitudes relative to each other; may be repeated
    #[arg(
        long = "tone", value_name = "TONE", required = true, value_parser = tone, allow_hyphen_values = true,
    )]
    tones: Vec<Tone>,
    /// Duration in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    duration: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct NestedLoops {
    /// Frequency of every loop in Hz
    #[arg(
        long, value_name = "HZ", default_value_t = 1.0, value_parser = positive, allow_hyphen_values = true,
    )]
    frequency: f64,
    /// Amplitudes in the order played, as fractions of the range
    #[arg(
        long, value_name = "LIST", value_delimiter = ',', default_value = "1,0.8,0.6,0.4,0.2",
        value_parser = number, allow_hyphen_values = true,
    )]
    amplitudes: Vec<f64>,
    /// Periods of each amplitude
    #[arg(
        long, value_name = "N", default_value_t = 2, value_parser = count::<u32>, allow_hyphen_values = true,
    )]
    periods_each: u32,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct ReversalCurves {
    /// Number of curves
    #[arg(
        long, value_name = "N", default_value_t = 10, value_parser = count::<u32>, allow_hyphen_values = true,
    )]
    curves: u32,
    /// Duration of a ramp over the whole range, in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    ramp: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct Staircase {
    /// Steps from the lowest to the highest voltage
    #[arg(
        long, value_name = "N", default_value_t = 5, value_parser = count::<u32>, allow_hyphen_values = true,
    )]
    steps: u32,
    /// Hold time of each level, in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    hold: f64,
    /// Duration of the smooth transition between levels, in s; 0: a jump
    #[arg(
        long, value_name = "SECONDS", default_value_t = 0.0, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    transition: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct Raster {
    /// Lines per second
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    line_rate: f64,
    /// Number of lines
    #[arg(long, value_name = "N", value_parser = count::<u32>, allow_hyphen_values = true)]
    lines: u32,
    /// Fraction of a line spent on the return; 0.5 is a triangle
    #[arg(
        long, value_name = "PART", default_value_t = 0.2, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    return_fraction: f64,
    /// Fraction of a line spent in each turnaround
    #[arg(
        long, value_name = "PART", default_value_t = 0.05, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    turnaround_fraction: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct Decaying {
    /// Frequency in Hz
    #[arg(
        long, value_name = "HZ", default_value_t = 1.0, value_parser = positive, allow_hyphen_values = true,
    )]
    frequency: f64,
    /// Number of cycles
    #[arg(
        long, value_name = "N", default_value_t = 30.0, value_parser = positive, allow_hyphen_values = true,
    )]
    cycles: f64,
    /// Ratio of the amplitudes of successive cycles
    #[arg(
        long, value_name = "RATIO", default_value_t = 0.85, value_parser = positive,
        allow_hyphen_values = true,
    )]
    ratio: f64,
    #[command(flatten)]
    drive: Drive,
}

#[derive(Args)]
pub struct Sweep {
    /// Frequency at the start in Hz
    #[arg(long, value_name = "HZ", value_parser = not_negative, allow_hyphen_values = true)]
    from: f64,
    /// Frequency at the end in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    to: f64,
    /// Duration in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    duration: f64,
    /// Frequency law
    #[arg(long, value_enum, default_value_t = Law::Logarithmic)]
    law: Law,
    #[command(flatten)]
    drive: Drive,
}

/// Frequency law of a sweep.
#[derive(Clone, Copy, ValueEnum)]
enum Law {
    /// Linear: equal time for equal differences of frequency
    Linear,
    /// Logarithmic: equal time for every octave
    Logarithmic,
}

#[derive(Args)]
pub struct Multisine {
    /// Lowest frequency in Hz
    #[arg(long, value_name = "HZ", value_parser = not_negative, allow_hyphen_values = true)]
    from: f64,
    /// Highest frequency in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    to: f64,
    /// Length of a period in s; its inverse is the frequency resolution
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    period: f64,
    /// Number of periods
    #[arg(
        long, value_name = "N", default_value_t = 4, value_parser = count::<u32>, allow_hyphen_values = true,
    )]
    periods: u32,
    /// Which multiples of 1/period are excited
    #[arg(long, value_enum, default_value_t = LineChoice::Full)]
    lines: LineChoice,
    /// Size of a group of consecutive odd lines of which one is a detection line, with --lines
    /// odd-with-detection
    #[arg(
        long, value_name = "N", default_value_t = 4, value_parser = count::<u32>, allow_hyphen_values = true,
    )]
    detection_group: u32,
    /// Choice of the phases
    #[arg(long, value_enum, default_value_t = PhaseChoice::Optimised)]
    phases: PhaseChoice,
    #[command(flatten)]
    drive: Drive,
}

/// Which lines of a multisine are excited.
#[derive(Clone, Copy, ValueEnum)]
enum LineChoice {
    /// All
    Full,
    /// Odd lines: even-order distortion appears at the even lines
    Odd,
    /// Odd lines but one of every group: odd-order distortion appears at the lines left out
    OddWithDetection,
}

/// Choice of the phases of a multisine.
#[derive(Clone, Copy, ValueEnum)]
enum PhaseChoice {
    /// Independent, uniformly distributed
    Random,
    /// Schroeder's formula
    Schroeder,
    /// Low crest factor by iterated clipping
    Optimised,
}

#[derive(Args)]
pub struct Random {
    /// Lowest frequency in Hz
    #[arg(
        long, value_name = "HZ", default_value_t = 0.0, value_parser = not_negative,
        allow_hyphen_values = true,
    )]
    from: f64,
    /// Highest frequency in Hz
    #[arg(long, value_name = "HZ", value_parser = positive, allow_hyphen_values = true)]
    to: f64,
    /// Duration in s
    #[arg(long, value_name = "SECONDS", value_parser = positive, allow_hyphen_values = true)]
    duration: f64,
    #[command(flatten)]
    drive: Drive,
}

impl Wave {
    /// The library's waveform, and the drive it fills.
    pub fn waveform(&self) -> (Waveform, &Drive) {
        match self {
            Wave::Sine(w) => (Waveform::Sine { frequency_hz: w.frequency, periods: w.periods }, &w.drive),
            Wave::Triangle(w) => {
                (Waveform::Triangle { frequency_hz: w.frequency, periods: w.periods }, &w.drive)
            }
            Wave::Sines(w) => (Waveform::Sines { tones: w.tones.clone(), duration_s: w.duration }, &w.drive),
            Wave::NestedLoops(w) => {
                let amplitudes = w.amplitudes.clone();
                let periods_each = w.periods_each;
                (Waveform::NestedLoops { frequency_hz: w.frequency, amplitudes, periods_each }, &w.drive)
            }
            Wave::ReversalCurves(w) => {
                (Waveform::ReversalCurves { curves: w.curves, ramp_s: w.ramp }, &w.drive)
            }
            Wave::Staircase(w) => {
                (Waveform::Staircase { steps: w.steps, hold_s: w.hold, transition_s: w.transition }, &w.drive)
            }
            Wave::Raster(w) => {
                let raster = Waveform::Raster {
                    line_hz: w.line_rate,
                    lines: w.lines,
                    return_fraction: w.return_fraction,
                    turnaround_fraction: w.turnaround_fraction,
                };
                (raster, &w.drive)
            }
            Wave::Decaying(w) => {
                (Waveform::Decaying { frequency_hz: w.frequency, cycles: w.cycles, ratio: w.ratio }, &w.drive)
            }
            Wave::Sweep(w) => {
                let law = match w.law {
                    Law::Linear => SweepLaw::Linear,
                    Law::Logarithmic => SweepLaw::Logarithmic,
                };
                (Waveform::Sweep { law, start_hz: w.from, end_hz: w.to, duration_s: w.duration }, &w.drive)
            }
            Wave::Multisine(w) => (w.waveform(), &w.drive),
            Wave::Random(w) => {
                (Waveform::Random { low_hz: w.from, high_hz: w.to, duration_s: w.duration }, &w.drive)
            }
        }
    }
}

impl Multisine {
    fn waveform(&self) -> Waveform {
        Waveform::Multisine {
            low_hz: self.from,
            high_hz: self.to,
            period_s: self.period,
            periods: self.periods,
            lines: match self.lines {
                LineChoice::Full => Lines::Full,
                LineChoice::Odd => Lines::Odd,
                LineChoice::OddWithDetection => Lines::OddWithDetection { group: self.detection_group },
            },
            phases: match self.phases {
                PhaseChoice::Random => Phases::Random,
                PhaseChoice::Schroeder => Phases::Schroeder,
                PhaseChoice::Optimised => Phases::Optimised,
            },
        }
    }
}

/// Parses `HZ:AMPLITUDE` or `HZ:AMPLITUDE:DEGREES`.
fn tone(text: &str) -> Result<Tone, String> {
    let numbers = text.split(':').map(str::parse::<f64>).collect::<Result<Vec<_>, _>>().ok();
    match numbers.as_deref() {
        Some(&[frequency_hz, amplitude]) => Ok(Tone { frequency_hz, amplitude, phase_deg: 0.0 }),
        Some(&[frequency_hz, amplitude, phase_deg]) => Ok(Tone { frequency_hz, amplitude, phase_deg }),
        _ => Err("expected HZ:AMPLITUDE or HZ:AMPLITUDE:DEGREES".into()),
    }
}
