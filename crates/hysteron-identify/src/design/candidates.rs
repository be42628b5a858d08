//! Families of waveforms from which a drive is put together: loops, first-order reversals, sines, sweeps,
//! multisines, random reversals and holds, each over the time of one segment.

use std::f64::consts::TAU;

use hysteron_numeric::display::short_to;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::limits::Limits;

/// Cycles of the slowest waveform in a segment.
const SLOWEST: f64 = 2.0;
/// Single frequencies tried over the band.
const SINES: usize = 8;
/// Lines of a multisine, and draws of their phases, of which the one of least crest factor is taken.
const LINES: usize = 12;
const DRAWS: usize = 8;
/// Times at which the largest value of a multisine is sought.
const POINTS: usize = 4096;
/// Share of the range of a slow motion that carries a fast one.
const CARRIER: f64 = 0.6;

/// One segment of a drive.
pub(super) struct Segment {
    /// Description.
    pub(super) words: String,
    /// Target voltage \[V\] at a time \[s\].
    wave: Box<dyn Fn(f64) -> f64 + Send + Sync>,
}

impl Segment {
    /// Targets \[V\] at the samples of `limits`, which may have another sample rate than the segment was made
    /// for.
    pub(super) fn targets(&self, limits: &Limits) -> impl Iterator<Item = f64> {
        let rate_hz = limits.rate_hz;
        (0..limits.samples).map(move |k| (self.wave)(k as f64 / rate_hz))
    }
}

/// The waveforms of `limits.samples` samples, around a resonance \[Hz\] too, where one is known.
pub(super) fn candidates(limits: &Limits, resonance_hz: Option<f64>, seed: u64) -> Vec<Segment> {
    let w = Waves::of(limits);
    let slowest = w.slowest_hz();
    let highest = limits.highest_hz;
    let mut all = Vec::new();
    let log = |share: f64| slowest * (highest / slowest).powf(share);
    let near = resonance_hz.filter(|f| *f < highest).into_iter();
    let sines = (0..SINES).map(|i| log(i as f64 / (SINES - 1) as f64));
    all.extend(sines.chain(near.clone().flat_map(|f| [0.85 * f, f, 1.15 * f])).map(|f| w.sine(f)));
    let middle = log(0.5);
    let bands = [(slowest, highest), (slowest, middle), (middle, highest), (log(0.75), highest)];
    let bands: Vec<(f64, f64)> =
        bands.into_iter().chain(near.map(|f| (0.7 * f, (1.4 * f).min(highest)))).collect();
    all.extend(bands.iter().map(|&(from, to)| w.sweep(from, to)));
    for (index, &(from, to)) in bands.iter().enumerate() {
        all.push(w.multisine(from, to, seed.wrapping_add(index as u64)));
        all.push(w.carried(from, to, seed.wrapping_add((bands.len() + index) as u64)));
    }
    let slow = |loops: &usize| *loops as f64 / w.seconds <= highest;
    all.extend([4, 8, 16].into_iter().filter(slow).map(|loops| w.nested(loops)));
    let reversals = [4, 8].into_iter().filter(slow);
    all.extend(reversals.flat_map(|loops| [w.reversals(loops, true), w.reversals(loops, false)]));
    all.extend([8, 16, 32].map(|turns| w.random_reversals(turns, seed)));
    all.extend([vec![1.0], vec![1.0, 0.0], vec![0.5, 1.0, 0.5, 0.0], staircase()].map(|l| w.holds(l)));
    all
}

fn staircase() -> Vec<f64> {
    vec![0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0]
}

/// Loop and sweep, each over half of the time: three periods of a sine over the range, then a logarithmic
/// sweep up to the highest frequency.
pub(super) fn usual(limits: &Limits) -> Vec<f64> {
    let first = Limits { samples: limits.samples / 2, ..*limits };
    let second = Limits { samples: limits.samples - first.samples, ..*limits };
    let slow = (3.0 * limits.rate_hz / first.samples as f64).min(limits.highest_hz);
    let looped = Waves::of(&first).sine(slow);
    let swept = Waves::of(&second).sweep(slow, limits.highest_hz);
    looped.targets(&first).chain(swept.targets(&second)).collect()
}

/// Random motion of the whole range with components up to the highest frequency, of equal power in equal
/// ratios of frequency.
pub(super) fn random_motion(limits: &Limits, seed: u64) -> Vec<f64> {
    let w = Waves::of(limits);
    w.multisine(w.slowest_hz(), limits.highest_hz, seed).targets(limits).collect()
}

/// Random minor loops: slow moves between random levels.
pub(super) fn minor_loops(limits: &Limits, turns: usize, seed: u64) -> Vec<f64> {
    Waves::of(limits).random_reversals(turns, seed).targets(limits).collect()
}

struct Waves {
    limits: Limits,
    seconds: f64,
}

impl Waves {
    fn of(limits: &Limits) -> Self {
        Self { limits: *limits, seconds: limits.samples as f64 / limits.rate_hz }
    }

    fn slowest_hz(&self) -> f64 {
        (SLOWEST / self.seconds).min(0.5 * self.limits.highest_hz)
    }

    /// A waveform of time \[s\] about the middle of the range.
    fn about_middle(&self, words: String, of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Segment {
        let middle = self.limits.middle();
        Segment { words, wave: Box::new(move |t| middle + of(t)) }
    }

    /// A waveform between 0 and 1 over the range, of the share of the segment.
    fn over_range(&self, words: String, of: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Segment {
        let (low, span, seconds) = (self.limits.low, self.limits.high - self.limits.low, self.seconds);
        Segment { words, wave: Box::new(move |t| low + span * of((t / seconds).min(1.0 - 1e-12))) }
    }

    fn sine(&self, frequency_hz: f64) -> Segment {
        let most = (self.limits.highest_hz * self.seconds * (1.0 + 1e-9)).floor();
        let cycles = (frequency_hz * self.seconds).round().min(most).max(1.0);
        let frequency_hz = cycles / self.seconds;
        let amplitude = self.limits.amplitude(frequency_hz);
        let words = format!("sine, {} Hz, amplitude {}", brief(frequency_hz), brief(amplitude));
        self.about_middle(words, move |t| -amplitude * (TAU * frequency_hz * t).cos())
    }

    /// Logarithmic sweep, its amplitude falling where the slew rate asks for it.
    fn sweep(&self, from_hz: f64, to_hz: f64) -> Segment {
        let growth = (to_hz / from_hz).ln() / self.seconds;
        let words = format!("sweep, {} to {} Hz", brief(from_hz), brief(to_hz));
        let limits = self.limits;
        self.about_middle(words, move |t| {
            let at_hz = from_hz * (growth * t).exp();
            let phase = if growth.abs() > 1e-12 { (at_hz - from_hz) / growth } else { from_hz * t };
            -limits.amplitude(at_hz) * (TAU * phase).cos()
        })
    }

    /// Lines (frequency, amplitude, phase) in equal ratios, of amplitudes that fall as 1/√f, with their
    /// largest value and slope.
    fn lines(&self, from_hz: f64, to_hz: f64, seed: u64) -> Lines {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let frequency = |i: usize| {
            let f = from_hz * (to_hz / from_hz).powf(i as f64 / (LINES - 1) as f64);
            (f * self.seconds).round().max(1.0) / self.seconds
        };
        let mut frequencies: Vec<f64> = (0..LINES).map(frequency).collect();
        frequencies.dedup();
        let peak = |of: &dyn Fn(f64) -> f64| {
            let at = |k: usize| of(k as f64 / POINTS as f64 * self.seconds).abs();
            (0..POINTS).map(at).fold(f64::MIN_POSITIVE, f64::max)
        };
        let draws = (0..DRAWS).map(|_| {
            let lines: Vec<[f64; 3]> =
                frequencies.iter().map(|&f| [f, f.powf(-0.5), TAU * uniform()]).collect();
            (peak(&|t| sum(&lines, t)), lines)
        });
        let (peak_value, lines) = draws.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
        let slope = peak(&|t| slope(&lines, t));
        Lines { lines, peak: peak_value, slope }
    }

    fn multisine(&self, from_hz: f64, to_hz: f64, seed: u64) -> Segment {
        let Lines { lines, peak, slope } = self.lines(from_hz, to_hz, seed);
        let scale = (self.limits.half() / peak).min(0.99 * self.limits.slew / slope);
        let words = format!(
            "multisine, {} line{} from {} to {} Hz, amplitude {}",
            lines.len(),
            if lines.len() == 1 { "" } else { "s" },
            brief(from_hz),
            brief(to_hz),
            brief(scale * peak)
        );
        self.about_middle(words, move |t| scale * sum(&lines, t))
    }

    /// A slow loop with a multisine on top.
    fn carried(&self, from_hz: f64, to_hz: f64, seed: u64) -> Segment {
        let slow_hz = 1.0 / self.seconds;
        let carrier = (CARRIER * self.limits.half()).min(0.5 * self.limits.amplitude(slow_hz));
        let Lines { lines, peak, slope } = self.lines(from_hz, to_hz, seed);
        let left = 0.99 * self.limits.slew - TAU * slow_hz * carrier;
        let scale = ((self.limits.half() - carrier) / peak).min(left / slope);
        let words = format!(
            "slow loop, amplitude {}, with a multisine from {} to {} Hz, amplitude {}",
            brief(carrier),
            brief(from_hz),
            brief(to_hz),
            brief(scale * peak)
        );
        self.about_middle(words, move |t| -carrier * (TAU * slow_hz * t).cos() + scale * sum(&lines, t))
    }

    /// Loops about the middle of four amplitudes, full to a quarter.
    fn nested(&self, loops: usize) -> Segment {
        let frequency_hz = loops as f64 / self.seconds;
        let amplitude = self.limits.amplitude(frequency_hz);
        let words = format!("nested loops, {loops} at {} Hz", brief(frequency_hz));
        let seconds = self.seconds;
        self.about_middle(words, move |t| {
            let share = 1.0 - 0.25 * ((4.0 * t / seconds) as usize).min(3) as f64;
            -share * amplitude * (TAU * frequency_hz * t).cos()
        })
    }

    /// First-order reversal curves: from one end of the range to equidistant levels and back.
    fn reversals(&self, loops: usize, from_high: bool) -> Segment {
        let words =
            format!("{loops} first-order reversals from the {} end", if from_high { "high" } else { "low" });
        self.over_range(words, move |share| {
            let at = share * loops as f64;
            let depth = (at.floor() + 1.0) / loops as f64;
            let way = depth * (1.0 - (2.0 * at.fract() - 1.0).abs());
            if from_high { 1.0 - way } else { way }
        })
    }

    fn random_reversals(&self, turns: usize, seed: u64) -> Segment {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed ^ turns as u64);
        let mut uniform = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let levels: Vec<f64> = (0..=turns).map(|_| uniform()).collect();
        self.over_range(format!("{turns} moves between random levels"), move |share| {
            let at = share * turns as f64;
            let from = (at as usize).min(turns - 1);
            levels[from] + (levels[from + 1] - levels[from]) * (at - from as f64)
        })
    }

    /// Levels held one after the other.
    fn holds(&self, levels: Vec<f64>) -> Segment {
        let seconds = self.seconds / levels.len() as f64;
        let words = match levels.len() {
            1 => format!("a level held for {} s", brief(seconds)),
            count => format!("{count} levels held for {} s each", brief(seconds)),
        };
        self.over_range(words, move |share| {
            levels[((share * levels.len() as f64) as usize).min(levels.len() - 1)]
        })
    }
}

/// Lines of a multisine with their largest value and slope.
struct Lines {
    lines: Vec<[f64; 3]>,
    peak: f64,
    slope: f64,
}

fn slope(lines: &[[f64; 3]], time_s: f64) -> f64 {
    lines.iter().map(|[f, amplitude, phase]| amplitude * TAU * f * (TAU * f * time_s + phase).sin()).sum()
}

fn sum(lines: &[[f64; 3]], time_s: f64) -> f64 {
    lines.iter().map(|[f, amplitude, phase]| amplitude * (TAU * f * time_s + phase).cos()).sum()
}

fn brief(x: f64) -> String {
    short_to(x, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> Limits {
        Limits::new([0.0, 10.0], 2000.0, 2000.0, 2.0, 200.0).unwrap()
    }

    #[test]
    fn waveforms_stay_within_the_range() {
        let limits = limits();
        for segment in candidates(&limits, Some(120.0), 7) {
            let ends = segment.targets(&limits).fold((f64::MAX, f64::MIN), |e, u| (e.0.min(u), e.1.max(u)));
            // The peak of a multisine is sought on a grid.
            assert!(ends.0 >= -0.05 && ends.1 <= 10.05, "{} {ends:?}", segment.words);
        }
    }

    #[test]
    fn first_order_reversals_return_to_the_end_they_come_from() {
        let limits = Limits { samples: 400, ..limits() };
        let w = Waves::of(&limits);
        let from_high = w.reversals(4, true).targets(&limits).collect::<Vec<_>>();
        // Four reversals: each begins at the high end; the deepest reaches the low end in its middle.
        for begin in [0, 100, 200, 300] {
            assert!((from_high[begin] - 10.0).abs() < 1e-9, "{begin} {}", from_high[begin]);
        }
        for (middle, level) in [(50, 7.5), (150, 5.0), (250, 2.5), (350, 0.0)] {
            assert!((from_high[middle] - level).abs() < 1e-9, "{middle} {}", from_high[middle]);
        }
    }

    #[test]
    fn the_usual_drive_is_a_loop_then_a_sweep_over_the_whole_time() {
        let limits = limits();
        let usual = usual(&limits);
        assert_eq!(usual.len(), limits.samples);
        let turns = |part: &[f64]| part.windows(3).filter(|w| (w[1] - w[0]) * (w[2] - w[1]) < 0.0).count();
        assert!(turns(&usual[..2000]) <= 6 && turns(&usual[2000..]) > 50);
    }
}
