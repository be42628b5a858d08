//! Result without its curves, as an object with units in its keys.

use hysteron_numeric::number::significant;
use serde::de::{Deserializer, Error};
use serde::{Deserialize, Serialize, Serializer};

use crate::control::{Edge, FeedbackKind, Loop, Reach, SineAnswer, Sines};
use crate::record::{Keyed, key_in, range_of};

use super::run::{Adaptation, differ};
use super::{Controller, ControllerRun, Tracking};

/// A [`Tracking`] without its curves. Numbers that are not finite are `None`.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingSummary {
    /// Plant that was driven: `rig`, `model`.
    pub plant: String,
    /// Samples of the reference.
    pub samples: usize,
    /// The controllers' rate \[Hz\].
    pub sample_rate_hz: f64,
    /// Where scoring begins \[s\].
    pub scored_from_s: f64,
    /// Where scoring ends \[s\].
    pub scored_to_s: f64,
    /// Least and largest drive allowed.
    pub range: [f64; 2],
    /// Largest rate of the drive, per second; `None`: no limit.
    pub slew_per_s: Option<f64>,
    /// Sines by which bandwidths were measured; `None` where the reference does not move.
    pub sines: Option<Sines>,
    /// Every controller.
    pub controllers: Vec<ControllerSummary>,
    /// Highest frequency against amplitude where the rate of the drive is limited.
    pub reach: Vec<Reach>,
    /// Symbol of the unit of the drive.
    pub input_unit: String,
    /// Symbol of the unit of the displacement.
    pub output_unit: String,
}

/// A [`ControllerRun`] without its curves, errors in the unit of the output, the drive in that of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerSummary {
    /// Controller.
    pub controller: Controller,
    /// Rms error.
    pub rms: Option<f64>,
    /// Largest error.
    pub max: Option<f64>,
    /// Mean error.
    pub mean: Option<f64>,
    /// Rms error in per cent of the stroke of the reference.
    pub rms_percent_of_stroke: Option<f64>,
    /// Largest error in per cent of the stroke of the reference.
    pub max_percent_of_stroke: Option<f64>,
    /// The stage fails to follow the reference.
    pub runs_away: bool,
    /// Least drive.
    pub drive_low: Option<f64>,
    /// Largest drive.
    pub drive_high: Option<f64>,
    /// Limits, bandwidths, margins and adaptation of the loop.
    pub answer: LoopAnswer,
}

/// Limits, bandwidths, margins and adaptation of a loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoopAnswer {
    /// Samples limited by the range.
    pub samples_at_range: usize,
    /// Samples limited by the slew rate.
    pub samples_at_slew: usize,
    /// Computed bandwidth, −3 dB \[Hz\].
    pub minus_3_db_formula_hz: Option<f64>,
    /// Measured bandwidth, −3 dB \[Hz\]; `None` where it lies beyond the sines.
    pub minus_3_db_played_hz: Option<f64>,
    /// Computed bandwidth, an error of 1 % \[Hz\].
    pub one_percent_error_formula_hz: Option<f64>,
    /// Measured bandwidth, an error of 1 % \[Hz\]; `None` where it lies beyond the sines.
    pub one_percent_error_played_hz: Option<f64>,
    /// Computed and measured bandwidth differ by more than a tenth.
    pub bandwidths_differ: Option<bool>,
    /// Response to each sine.
    pub sines: Vec<SineSummary>,
    /// Law of the feedback; `None` without feedback, as the margins.
    pub law: Option<String>,
    /// Factor by which the gain may change.
    pub gain_margin: Option<f64>,
    /// Phase margin \[degrees\].
    pub phase_margin_deg: Option<f64>,
    /// Least |1 + L|.
    pub modulus_margin: Option<f64>,
    /// Highest frequency at which |L| = 1 \[Hz\].
    pub crossover_hz: Option<f64>,
    /// Adaptive feedforward, if the controller has one.
    pub adaptation: Option<AdaptationSummary>,
}

/// Response to one sine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SineSummary {
    /// Its frequency \[Hz\].
    pub frequency_hz: f64,
    /// Tracking error, rms in per cent of the sine's stroke.
    pub error_percent_of_stroke: Option<f64>,
    /// Displacement over reference.
    pub gain: Option<f64>,
    /// Its phase \[degrees\].
    pub phase_deg: Option<f64>,
    /// Samples limited by range or slew rate.
    pub samples_held_back: usize,
}

/// An [`Adaptation`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AdaptationSummary {
    /// Number of weights.
    pub weights: usize,
    /// Samples from one weight to the next.
    pub stride_samples: usize,
    /// Step size: share of the error removed per step.
    pub step: Option<f64>,
    /// Step size above which the weights oscillate.
    pub step_limit: Option<f64>,
    /// Frequency of this limit \[Hz\].
    pub step_limit_at_hz: Option<f64>,
    /// Limit over step.
    pub step_margin: Option<f64>,
    /// Largest phase difference between stage and model \[degrees\].
    pub phase_error_deg: Option<f64>,
    /// Its frequency \[Hz\].
    pub phase_error_at_hz: Option<f64>,
    /// Margin of the phase error to 90 degrees \[degrees\].
    pub phase_margin_deg: Option<f64>,
    /// Residual rms with the best constant weights, in per cent of the stroke.
    pub best_weights_rms_percent_of_stroke: Option<f64>,
}

fn finite(value: f64) -> Option<f64> {
    Some(value).filter(|value| value.is_finite())
}

impl Tracking {
    /// Everything but the curves.
    pub fn summary(&self) -> TrackingSummary {
        TrackingSummary {
            plant: self.plant.name.to_owned(),
            samples: self.reference.len(),
            sample_rate_hz: self.sample_rate_hz,
            scored_from_s: self.scored.start as f64 / self.sample_rate_hz,
            scored_to_s: self.scored.end as f64 / self.sample_rate_hz,
            range: self.settings.range_v,
            slew_per_s: finite(self.settings.slew_v_per_s),
            sines: self.sines,
            controllers: self.runs.iter().map(ControllerSummary::of).collect(),
            reach: self.reach.clone(),
            input_unit: self.input.symbol().to_owned(),
            output_unit: self.output.symbol().to_owned(),
        }
    }
}

impl ControllerSummary {
    fn of(run: &ControllerRun) -> Self {
        let (drive_low, drive_high) = range_of(&run.played.drive);
        Self {
            controller: run.controller,
            rms: finite(run.score.rms),
            max: finite(run.score.max),
            mean: finite(run.score.mean),
            rms_percent_of_stroke: finite(run.score.rms_percent),
            max_percent_of_stroke: finite(run.score.max_percent),
            runs_away: run.runs_away(),
            drive_low: finite(drive_low),
            drive_high: finite(drive_high),
            answer: LoopAnswer::of(run),
        }
    }

    fn told(&self, input: &str, output: &str) -> Keyed {
        Keyed::default()
            .with("controller", self.controller)
            .in_unit("rms", output, self.rms)
            .in_unit("max", output, self.max)
            .in_unit("mean", output, self.mean)
            .with("rms_percent_of_stroke", self.rms_percent_of_stroke)
            .with("max_percent_of_stroke", self.max_percent_of_stroke)
            .with("runs_away", self.runs_away)
            .in_unit("drive_low", input, self.drive_low)
            .in_unit("drive_high", input, self.drive_high)
            .with_all(&self.answer)
    }

    fn read<E: Error>(keyed: &Keyed, input: &str, output: &str) -> Result<Self, E> {
        Ok(Self {
            controller: keyed.get("controller")?,
            rms: keyed.get_in_unit("rms", output)?,
            max: keyed.get_in_unit("max", output)?,
            mean: keyed.get_in_unit("mean", output)?,
            rms_percent_of_stroke: keyed.get("rms_percent_of_stroke")?,
            max_percent_of_stroke: keyed.get("max_percent_of_stroke")?,
            runs_away: keyed.get("runs_away")?,
            drive_low: keyed.get_in_unit("drive_low", input)?,
            drive_high: keyed.get_in_unit("drive_high", input)?,
            answer: keyed.get_all()?,
        })
    }
}

impl LoopAnswer {
    fn of(run: &ControllerRun) -> Self {
        let (margins, both) = (run.made.margins(), run.bandwidths());
        let found = |i: usize| both.and_then(|both| Edge::found(both[i].1)).and_then(finite);
        let answers = run.followed.iter().flat_map(|followed| &followed.answers);
        Self {
            samples_at_range: run.played.at_range,
            samples_at_slew: run.played.at_slew,
            minus_3_db_formula_hz: finite(run.made.bandwidth.minus_3_db_hz),
            minus_3_db_played_hz: found(0),
            one_percent_error_formula_hz: finite(run.made.bandwidth.one_percent_hz),
            one_percent_error_played_hz: found(1),
            bandwidths_differ: both.map(|both| both.iter().any(|(formula, edge)| differ(*formula, *edge))),
            sines: answers.map(SineSummary::of).collect(),
            law: margins.map(|_| law(&run.made)),
            gain_margin: margins.and_then(|m| finite(m.gain)),
            phase_margin_deg: margins.and_then(|m| finite(m.phase_deg)),
            modulus_margin: margins.and_then(|m| finite(m.modulus)),
            crossover_hz: margins.and_then(|m| finite(m.crossover_hz)),
            adaptation: run.adaptation.as_ref().map(AdaptationSummary::of),
        }
    }
}

impl SineSummary {
    fn of(answer: &SineAnswer) -> Self {
        Self {
            frequency_hz: answer.frequency_hz,
            error_percent_of_stroke: finite(answer.error_percent),
            gain: finite(answer.followed.norm()),
            phase_deg: finite(answer.followed.arg().to_degrees()),
            samples_held_back: answer.held_back,
        }
    }
}

impl AdaptationSummary {
    fn of(own: &Adaptation) -> Self {
        let filter = &own.filter;
        Self {
            weights: filter.adaptive.weights,
            stride_samples: filter.stride,
            step: finite(filter.rate),
            step_limit: finite(filter.limit),
            step_limit_at_hz: finite(filter.limit_at_hz),
            step_margin: finite(filter.limit / filter.rate),
            phase_error_deg: own.phase_error.and_then(|(degrees, _)| finite(degrees)),
            phase_error_at_hz: own.phase_error.and_then(|(_, at_hz)| finite(at_hz)),
            phase_margin_deg: own.phase_error.and_then(|(degrees, _)| finite(90.0 - degrees)),
            best_weights_rms_percent_of_stroke: finite(own.best_percent),
        }
    }
}

impl Serialize for Tracking {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}

impl Serialize for TrackingSummary {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (input, output) = (self.input_unit.as_str(), self.output_unit.as_str());
        let controllers: Vec<Keyed> = self.controllers.iter().map(|one| one.told(input, output)).collect();
        Keyed::default()
            .with("simulated", true)
            .with("plant", &self.plant)
            .with("samples", self.samples)
            .with("sample_rate_hz", self.sample_rate_hz)
            .with("scored_from_s", self.scored_from_s)
            .with("scored_to_s", self.scored_to_s)
            .in_unit("range", input, self.range)
            .with(key_in("slew", input) + "_per_s", self.slew_per_s)
            .with("sines", self.sines.as_ref().map(|sines| sines_told(sines, output)))
            .with("controllers", controllers)
            .with("reach", self.reach.iter().map(|r| reach_told(r, input, output)).collect::<Vec<_>>())
            .serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for TrackingSummary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let keyed = Keyed::deserialize(deserializer)?;
        let controllers: Vec<Keyed> = keyed.get("controllers")?;
        let missing = |key: &str| D::Error::custom(format_args!("{key} is missing"));
        let input = keyed.unit_of("range").ok_or_else(|| missing("range"))?;
        let output = controllers.first().and_then(|row| row.unit_of("rms")).ok_or_else(|| missing("rms"))?;
        let rows = controllers.iter().map(|row| ControllerSummary::read(row, input, output));
        let reach = keyed.get::<Vec<Keyed>, D::Error>("reach")?;
        let sines = keyed.get::<Option<Keyed>, D::Error>("sines")?;
        Ok(Self {
            plant: keyed.get("plant")?,
            samples: keyed.get("samples")?,
            sample_rate_hz: keyed.get("sample_rate_hz")?,
            scored_from_s: keyed.get("scored_from_s")?,
            scored_to_s: keyed.get("scored_to_s")?,
            range: keyed.get_in_unit("range", input)?,
            slew_per_s: keyed.get(&(key_in("slew", input) + "_per_s"))?,
            sines: sines.map(|sines| sines_read(&sines, output)).transpose()?,
            controllers: rows.collect::<Result<_, _>>()?,
            reach: reach.iter().map(|r| reach_read(r, input, output)).collect::<Result<_, _>>()?,
            input_unit: input.to_owned(),
            output_unit: output.to_owned(),
        })
    }
}

fn sines_told(sines: &Sines, output: &str) -> Keyed {
    Keyed::default()
        .in_unit("level", output, sines.level)
        .in_unit("amplitude", output, sines.amplitude)
        .with("lowest_hz", sines.range_hz[0])
        .with("highest_hz", sines.range_hz[1])
}

fn sines_read<E: Error>(keyed: &Keyed, output: &str) -> Result<Sines, E> {
    Ok(Sines {
        level: keyed.get_in_unit("level", output)?,
        amplitude: keyed.get_in_unit("amplitude", output)?,
        range_hz: [keyed.get("lowest_hz")?, keyed.get("highest_hz")?],
    })
}

fn reach_told(reach: &Reach, input: &str, output: &str) -> Keyed {
    Keyed::default()
        .in_unit("amplitude", output, reach.amplitude)
        .in_unit("drive_amplitude", input, reach.amplitude_v)
        .with("highest_hz", reach.highest_hz)
}

fn reach_read<E: Error>(keyed: &Keyed, input: &str, output: &str) -> Result<Reach, E> {
    Ok(Reach {
        amplitude: keyed.get_in_unit("amplitude", output)?,
        amplitude_v: keyed.get_in_unit("drive_amplitude", input)?,
        highest_hz: keyed.get("highest_hz")?,
    })
}

/// The law as a formula, s in rad/s.
pub fn law(made: &Loop) -> String {
    if let Some((gain, _)) = made.observer {
        return format!("observer, gain {}", significant(gain, 3));
    }
    let Some(tuned) = &made.feedback else { return "–".to_owned() };
    let (k, i) = (significant(tuned.law.proportional, 3), significant(tuned.law.integral_per_s, 3));
    match tuned.law.kind {
        FeedbackKind::Integral => format!("{i}/s"),
        FeedbackKind::Pi { corner_hz } => format!("{k} (1 + 2π {}/s)", significant(corner_hz, 3)),
        FeedbackKind::FractionalPi { corner_hz, order } => {
            format!("{k} (1 + (2π {}/s)^{order})", significant(corner_hz, 3))
        }
        FeedbackKind::NotchIntegral { notch } => format!(
            "{i}/s, notch at {} Hz, damping {} over {}",
            significant(notch.frequency_hz, 4),
            significant(notch.zeros, 2),
            significant(notch.poles, 2)
        ),
    }
}
