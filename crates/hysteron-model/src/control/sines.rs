//! Bandwidth of a loop on a plant, measured with sines.

use std::f64::consts::{SQRT_2, TAU};

use super::play::play_metered;
use super::{ControlError, Loop, Plant, TrackingScore};
use hysteron_numeric::{Complex64, Meter};

/// Sines per decade.
const PER_DECADE: f64 = 4.0;
/// Bisections of a step between two sines that contains a bandwidth.
const HALVINGS: usize = 3;
/// Ratio to a computed bandwidth at which another sine is played.
const BEYOND: f64 = 1.05;
/// Least number of samples before the evaluation (at least one period), and in it (at least two periods).
const SETTLED: usize = 3000;
const COUNTED: f64 = 2000.0;
/// Samples after the evaluation, beyond the preview: the reference ends with a jerk.
const AFTER: usize = 64;
/// Longest period played, in samples: a loop stores three of them.
const LONGEST_PERIOD: f64 = 1e6;

/// Largest relative rounding of a frequency to whole periods.
const ROUNDING: f64 = 1e-2;

/// The sines to play.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sines {
    /// Their middle \[µm\].
    pub level: f64,
    /// Half of their stroke \[µm\].
    pub amplitude: f64,
    /// Lowest and highest frequency \[Hz\].
    pub range_hz: [f64; 2],
}

impl Sines {
    /// The lowest frequency that is played at this sample rate \[Hz\]: a period of a million samples.
    pub fn lowest_hz(sample_rate_hz: f64) -> f64 {
        sample_rate_hz / LONGEST_PERIOD
    }
}

/// Response to one sine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SineAnswer {
    /// Its frequency \[Hz\].
    pub frequency_hz: f64,
    /// Tracking error, harmonics and noise included, its mean removed: rms in per cent of stroke.
    pub error_percent: f64,
    /// Complex response of the displacement to it; 1 is ideal.
    pub followed: Complex64,
    /// Samples limited by range or slew rate.
    pub held_back: usize,
}

/// Length of one sine, in samples.
struct SineTiming {
    /// Whole periods that are evaluated, and their samples.
    periods: f64,
    counted: f64,
    /// Samples before them.
    settled: usize,
    /// Samples to their end.
    end: usize,
}

/// Where a bandwidth lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Edge {
    /// Below the lowest sine.
    Below(f64),
    /// At this frequency \[Hz\].
    At(f64),
    /// Above the highest sine.
    Above(f64),
}

impl Edge {
    /// The frequency \[Hz\], where it was found.
    pub fn found(self) -> Option<f64> {
        if let Self::At(f) = self { Some(f) } else { None }
    }
}

/// Response of a loop on a plant to sines, with the measured bandwidths.
#[derive(Clone, Debug, PartialEq)]
pub struct Followed {
    /// Response to each sine, at rising frequencies.
    pub answers: Vec<SineAnswer>,
    /// Lowest frequency with a gain below 1/√2.
    pub minus_3_db: Edge,
    /// Where the error is above 1 % of the stroke, rms.
    pub one_percent: Edge,
}

impl Loop {
    /// Plays one sine of whole periods; the response is the coherent one, Σ y e^(−jωt)/Σ r e^(−jωt).
    ///
    /// # Errors
    /// Those of [`super::play`]; [`ControlError::Sine`] below [`Sines::lowest_hz`].
    pub fn sine(
        &self,
        sines: &Sines,
        frequency_hz: f64,
        plant: Plant<'_>,
        virgin_v: Option<f64>,
    ) -> Result<SineAnswer, ControlError> {
        self.sine_metered(sines, frequency_hz, plant, virgin_v, &Meter::silent())
    }

    fn sine_metered(
        &self,
        sines: &Sines,
        frequency_hz: f64,
        plant: Plant<'_>,
        virgin_v: Option<f64>,
        meter: &Meter<'_>,
    ) -> Result<SineAnswer, ControlError> {
        let lowest_hz = Sines::lowest_hz(self.settings.sample_rate_hz);
        if frequency_hz.is_nan() || frequency_hz < lowest_hz {
            return Err(ControlError::Sine { frequency_hz, lowest_hz });
        }
        let SineTiming { periods, counted, settled, end } = self.timing(frequency_hz);
        let step = TAU * periods / counted;
        let preview = self.inverse.as_ref().map_or(0, |inverse| inverse.preview);
        let reference: Vec<f64> = (0..end + preview + AFTER)
            .map(|k| {
                let grown = (2.0 * k as f64 / settled as f64).min(1.0);
                let size = sines.amplitude * grown * grown * (3.0 - 2.0 * grown);
                sines.level + size * (step * k as f64).sin()
            })
            .collect();
        let played = play_metered(self, &reference, plant, virgin_v, meter)?;
        let share = |x: &[f64]| -> Complex64 {
            x[settled..end]
                .iter()
                .enumerate()
                .map(|(k, x)| *x * Complex64::from_polar(1.0, -step * k as f64))
                .sum()
        };
        Ok(SineAnswer {
            frequency_hz: step / TAU * self.settings.sample_rate_hz,
            error_percent: TrackingScore::of(&played.displacement[..end], &reference[..end], settled)
                .rms_percent,
            followed: share(&played.displacement) / share(&reference),
            held_back: played.at_range + played.at_slew,
        })
    }

    /// Plays sines from the lowest to the highest frequency, four per decade, more around a bandwidth.
    ///
    /// # Errors
    /// Those of [`Self::sine`].
    pub fn sines(
        &self,
        sines: &Sines,
        plant: Plant<'_>,
        virgin_v: Option<f64>,
    ) -> Result<Followed, ControlError> {
        self.sines_metered(sines, plant, virgin_v, &Meter::silent())
    }

    /// [`Self::sines`], whose samples `meter` counts.
    ///
    /// # Errors
    /// Those of [`Self::sines`]; [`ControlError::Stopped`].
    pub(crate) fn sines_metered(
        &self,
        sines: &Sines,
        plant: Plant<'_>,
        virgin_v: Option<f64>,
        meter: &Meter<'_>,
    ) -> Result<Followed, ControlError> {
        let [low, high] = sines.range_hz;
        let frequencies = self.frequencies(sines);
        let mut answers: Vec<SineAnswer> = Vec::with_capacity(frequencies.len() + 2 * HALVINGS);
        for frequency_hz in frequencies {
            answers.push(self.sine_metered(sines, frequency_hz, plant, virgin_v, meter)?);
        }
        let lost = |a: &SineAnswer| SQRT_2.recip() / a.followed.norm();
        let left = |a: &SineAnswer| a.error_percent;
        for measure in [&lost as &dyn Fn(&SineAnswer) -> f64, &left] {
            for _ in 0..HALVINGS {
                let Some(above @ 1..) = answers.iter().position(|a| measure(a) > 1.0) else { break };
                let between = (answers[above - 1].frequency_hz * answers[above].frequency_hz).sqrt();
                let answer = self.sine_metered(sines, between, plant, virgin_v, meter)?;
                answers.insert(above, answer);
            }
        }
        let edge = |measure: &dyn Fn(&SineAnswer) -> f64| match answers.iter().position(|a| measure(a) > 1.0)
        {
            None => Edge::Above(high),
            Some(0) => Edge::Below(low),
            Some(above) => {
                let (a, b) = (&answers[above - 1], &answers[above]);
                let share = -measure(a).ln() / (measure(b) / measure(a)).ln();
                Edge::At(a.frequency_hz * (b.frequency_hz / a.frequency_hz).powf(share.clamp(0.0, 1.0)))
            }
        };
        Ok(Followed { minus_3_db: edge(&lost), one_percent: edge(&left), answers })
    }

    /// Samples that [`Self::sines`] plays, without those that it adds around a bandwidth.
    pub(crate) fn samples_of(&self, sines: &Sines) -> usize {
        self.frequencies(sines).into_iter().map(|frequency_hz| self.timing(frequency_hz).end).sum()
    }

    /// The frequencies from the lowest to the highest \[Hz\].
    fn frequencies(&self, sines: &Sines) -> Vec<f64> {
        let [low, high] = sines.range_hz;
        let steps = (PER_DECADE * (high / low).log10()).ceil().max(1.0) as usize;
        let mut frequencies: Vec<f64> =
            (0..=steps).map(|k| low * (high / low).powf(k as f64 / steps as f64)).collect();
        // So that a dip predicted by the model is not skipped.
        let own = [self.bandwidth.minus_3_db_hz, self.bandwidth.one_percent_hz].map(|f| BEYOND * f);
        frequencies.extend(own.into_iter().filter(|f| (low..=high).contains(f)));
        frequencies.sort_by(f64::total_cmp);
        frequencies
    }

    fn timing(&self, frequency_hz: f64) -> SineTiming {
        let period = self.settings.sample_rate_hz / frequency_hz;
        let periods = (COUNTED / period).ceil().max(2.0);
        let counted = (periods * period).round();
        let settled = SETTLED.max(period.ceil() as usize);
        SineTiming { periods, counted, settled, end: settled + counted as usize }
    }

    /// This loop without adaptation: its weights stay 0.
    #[must_use]
    pub fn without_adaptation(&self) -> Self {
        Self { adaptive: None, ..self.clone() }
    }

    /// Largest phase difference of the correction path between plant and model \[degrees\], and its frequency
    /// \[Hz\], from sines under the inverse alone: under the same law, measured over expected response is
    /// plant over model.
    pub fn phase_error(&self, alone: &[SineAnswer]) -> Option<(f64, f64)> {
        let (inverse, adaptive) = (self.inverse.as_ref()?, self.adaptive.as_ref()?);
        let errors = alone
            .iter()
            .filter(|a| a.frequency_hz <= (1.0 + ROUNDING) * adaptive.adaptive.highest_hz)
            .map(|a| {
                let f = a.frequency_hz;
                let plant = a.followed / inverse.tracking(f) * inverse.correction(f);
                ((plant / adaptive.response(f)).arg().abs().to_degrees(), f)
            });
        errors.max_by(|a, b| a.0.total_cmp(&b.0))
    }
}
