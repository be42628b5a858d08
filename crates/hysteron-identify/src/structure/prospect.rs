//! Parameters that a campaign can determine, judged by its drives alone, and the record to measure next.

use std::borrow::Cow;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::RecordFacts;
use super::super::purpose::Purpose;
use super::content::{Content, brief, near};
use hysteron_model::record::{
    DelayFinding, ExcitationKind, InputOutput, Response, delay_from_phase, excitation_kind, find_delay,
    fit_start_up, fundamental_response, low_frequency_responses,
};

/// Least ratio of highest to lowest frequency for distinguishing dynamics from hysteresis.
pub(super) const FAST_OVER_SLOW: f64 = 3.0;
/// A maximum of the gain above the gain on both sides by this factor is a resonance.
const PROMINENCE: f64 = 1.3;
/// Least duration \[s\] of a record, or of a hold, that determines creep.
const LONG_S: f64 = 10.0;
/// A drive that starts off 0 V by more than this share of its range.
const OFF_ZERO: f64 = 0.02;

/// Judgement whether a campaign determines a property.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Prospect {
    /// Topic, in a word or two.
    pub topic: Cow<'static, str>,
    /// `Some(true)`: yes; `Some(false)`: no; `None`: in part.
    pub determined: Option<bool>,
    /// Why, in plain words.
    pub text: String,
}

/// Statements about what a campaign can determine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Prospects {
    /// Amplitudes and frequencies of each record, in words; not serialised, as the statements contain them.
    #[serde(skip)]
    pub records: Vec<String>,
    /// The statements.
    pub statements: Vec<Prospect>,
    /// The record to measure next; `None` where nothing is missing.
    #[serde(rename = "measure_next")]
    pub next: Option<String>,
    /// What that record is for; prediction where nothing is missing.
    #[serde(rename = "measure_next_for", default)]
    pub next_for: Purpose,
}

/// Predicts before any fit what the records together can determine.
pub fn prospects(records: &[InputOutput]) -> Prospects {
    // Amplitudes, frequencies and phases are those of the uniformly sampled segments; creep and start those
    // of whole records.
    let of_record = |record: &InputOutput| {
        let whole = RecordFacts::new(record.clone());
        let segments = record.in_moving_segments();
        let parts: Vec<RecordFacts> = match &segments[..] {
            [one] if one.time == record.time => vec![whole.clone()],
            _ => segments.into_iter().map(RecordFacts::new).collect(),
        };
        let contents: Vec<Content> = parts.iter().map(Content::of).collect();
        (whole, parts, contents)
    };
    let of_records: Vec<_> = records.par_iter().map(of_record).collect();
    let (mut wholes, mut facts, mut contents, mut described) = (vec![], vec![], vec![], vec![]);
    for (whole, parts, own) in of_records {
        let unit = whole.data.u_unit.to_string();
        let words: Vec<String> = own.iter().map(|content| content.describe(&unit)).collect();
        described.push(words.join("; "));
        wholes.push(whole);
        facts.extend(parts);
        contents.extend(own);
    }
    let statements = vec![
        amplitudes(&facts, &contents),
        frequencies(&facts, &contents),
        resonance(&facts),
        delay(&facts),
        creep(&wholes),
        starts(&wholes),
    ];
    let (next, next_for) = next_record(&wholes, &contents).unzip();
    Prospects { records: described, statements, next, next_for: next_for.unwrap_or_default() }
}

/// The most informative further record, and what it is for.
pub(super) fn next_record(facts: &[RecordFacts], contents: &[Content]) -> Option<(String, Purpose)> {
    let unit = facts.first().map_or_else(String::new, |f| f.data.u_unit.to_string());
    let largest = largest_amplitude(contents);
    let (low, high) = band(contents);
    let from = if low > 0.0 { format!("{} Hz", brief(low)) } else { "a slow loop".to_owned() };
    let full = format!("{} {unit}", brief(largest));
    let full = full.trim_end();
    if high < FAST_OVER_SLOW * low.max(f64::MIN_POSITIVE) || high == 0.0 {
        let loops = if one_amplitude(contents) {
            "; then slow loops of the full, half and a quarter of the amplitude, for β, γ and the polynomial"
        } else {
            ""
        };
        let text = format!(
            "a sweep (or a multisine) from {from} to the highest frequency of use, amplitude {full}: it \
             distinguishes delay and dynamics from loop width{loops}"
        );
        return Some((text, Purpose::Resonance));
    }
    if one_amplitude(contents) {
        let text = format!(
            "slow loops at {from} of the full, half and a quarter of the amplitude ({full}): the shrinking \
             loop determines β, γ, n and the polynomial"
        );
        return Some((text, Purpose::MinorLoops));
    }
    if !shows_creep(facts) {
        let text =
            format!("steps of {full}, each held for {LONG_S} s or longer: these show creep most clearly");
        return Some((text, Purpose::Creep));
    }
    None
}

fn largest_amplitude(contents: &[Content]) -> f64 {
    contents.iter().map(|c| c.amplitude.1).fold(0.0, f64::max)
}

pub(super) fn one_amplitude(contents: &[Content]) -> bool {
    let largest = largest_amplitude(contents);
    contents.iter().all(|c| near(c.amplitude.0, largest))
}

/// Lowest and highest frequency of all records; (0, 0) where none has any.
pub(super) fn band(contents: &[Content]) -> (f64, f64) {
    let moving = contents.iter().filter(|c| c.frequency_hz.1 > 0.0);
    let low = moving.clone().map(|c| c.frequency_hz.0).fold(f64::INFINITY, f64::min);
    let high = moving.map(|c| c.frequency_hz.1).fold(0.0, f64::max);
    if high > 0.0 { (low, high) } else { (0.0, 0.0) }
}

fn amplitudes(facts: &[RecordFacts], contents: &[Content]) -> Prospect {
    let largest = largest_amplitude(contents);
    let smallest = contents.iter().map(|c| c.amplitude.0).fold(f64::INFINITY, f64::min);
    let unit = facts.first().map_or_else(String::new, |f| f.data.u_unit.to_string());
    let (determined, text) = if !one_amplitude(contents) {
        let text = format!("loops of {} to {} {unit} amplitude", brief(smallest), brief(largest));
        (Some(true), text)
    } else if facts.iter().any(starts_at_rest) {
        let text = "one amplitude: β and γ are distinguished only by the virgin curve, n and the polynomial \
                    only by the shape of one loop";
        (None, text.to_owned())
    } else {
        let text = "one amplitude and no start from rest: β and γ cannot be distinguished, and minor loops \
                    are extrapolated";
        (Some(false), text.to_owned())
    };
    Prospect { topic: "β, γ, n, polynomial".into(), determined, text }
}

fn frequencies(facts: &[RecordFacts], contents: &[Content]) -> Prospect {
    let (low, high) = band(contents);
    let (determined, text) = if high == 0.0 {
        let timed = facts.iter().any(|f| f.duration_s() > 0.0);
        let text =
            if timed { "no drive oscillates: ramps, steps or one loop" } else { "the records have no time" };
        (Some(false), text.to_owned())
    } else if high >= FAST_OVER_SLOW * low {
        (Some(true), format!("{} to {} Hz", brief(low), brief(high)))
    } else {
        let text = format!("{} Hz only: dynamics and hysteresis cannot be distinguished", brief(high));
        (Some(false), text)
    };
    Prospect { topic: "dynamics".into(), determined, text }
}

/// Gain and phase over frequency, from sweeps and multisines, and from the fundamentals of single-frequency
/// records.
fn responses(facts: &[RecordFacts]) -> Vec<Response> {
    let mut all: Vec<Response> = Vec::new();
    for f in facts {
        match excitation_kind(&f.data.u) {
            ExcitationKind::Wave { frequency, .. } => {
                all.extend(fundamental_response(&f.data, frequency, f.periods.as_ref()));
            }
            ExcitationKind::Sweep { .. } | ExcitationKind::Broadband { .. } => {
                all.extend(low_frequency_responses(&f.data, f.periods.as_ref(), f64::INFINITY));
            }
            _ => {}
        }
    }
    all.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    all
}

fn resonance(facts: &[RecordFacts]) -> Prospect {
    const TOPIC: &str = "resonance";
    let points = responses(facts);
    let (low, high) = (points.first(), points.last());
    if let (Some(low), Some(high)) = (low, high)
        && high.frequency_hz < FAST_OVER_SLOW * low.frequency_hz
    {
        let text = format!("{} Hz only: a resonance cannot be detected", brief(high.frequency_hz));
        return Prospect { topic: TOPIC.into(), determined: Some(false), text };
    }
    let lowest = |part: &[Response]| part.iter().map(|p| p.gain).fold(f64::INFINITY, f64::min);
    let peak = points.iter().enumerate().max_by(|a, b| a.1.gain.total_cmp(&b.1.gain));
    let Some((at, top)) = peak else {
        let text = "no record of several frequencies: a resonance cannot be detected".to_owned();
        return Prospect { topic: TOPIC.into(), determined: Some(false), text };
    };
    let (before, after) = (lowest(&points[..at]), lowest(&points[at + 1..]));
    let (determined, text) = if top.gain > PROMINENCE * before && top.gain > PROMINENCE * after {
        (Some(true), format!("in the band, near {} Hz", brief(top.frequency_hz)))
    } else {
        let high = points.last().map_or(0.0, |p| p.frequency_hz);
        let flank = points.last().map_or(1.0, |p| p.gain) / points.first().map_or(1.0, |p| p.gain);
        let text = format!(
            "none up to {} Hz (gain there {} of that at the lowest frequency): of a mode above at most the \
             flank is visible",
            brief(high),
            brief(flank)
        );
        (None, text)
    };
    Prospect { topic: TOPIC.into(), determined, text }
}

fn delay(facts: &[RecordFacts]) -> Prospect {
    const TOPIC: &str = "delay";
    let milliseconds = |s: f64| brief(1e3 * s);
    let words = |delay_s: f64, error_s: f64, lag: f64| {
        format!(
            "{} ± {} ms, including lags that grow with frequency; loop width adds a constant {}°",
            milliseconds(delay_s),
            short_error(1e3 * error_s),
            brief(lag.to_degrees())
        )
    };
    let mut bound = None;
    for f in facts {
        let found = find_delay(&f.data, &excitation_kind(&f.data.u), f.periods.as_ref());
        match found {
            Some(DelayFinding::FromPhase { delay_s, std_error_s, constant_lag_rad, .. }) => {
                let text = words(delay_s, std_error_s, constant_lag_rad);
                return Prospect { topic: TOPIC.into(), determined: Some(true), text };
            }
            Some(DelayFinding::FromStartUp(s)) => {
                bound.get_or_insert((s.delay_range_s.1, "from a start from rest"));
            }
            Some(DelayFinding::Inseparable { at_most_s, .. }) if at_most_s > 0.0 => {
                bound = Some(
                    bound.map_or((at_most_s, ""), |b| if b.0 < at_most_s { b } else { (at_most_s, "") }),
                );
            }
            _ => {}
        }
    }
    // Single-frequency records: the same phase regression over their fundamentals.
    if let Some(DelayFinding::FromPhase { delay_s, std_error_s, constant_lag_rad, .. }) =
        delay_from_phase(&responses(facts))
    {
        let text = words(delay_s, std_error_s, constant_lag_rad);
        return Prospect { topic: TOPIC.into(), determined: Some(true), text };
    }
    match bound {
        Some((most, "")) => Prospect {
            topic: TOPIC.into(),
            determined: Some(false),
            text: format!("cannot be distinguished from loop width: at most {} ms", milliseconds(most)),
        },
        Some((most, how)) => Prospect {
            topic: TOPIC.into(),
            determined: None,
            text: format!("{how} alone: at most {} ms", milliseconds(most)),
        },
        None => Prospect {
            topic: TOPIC.into(),
            determined: Some(false),
            text: "not determined by the records".into(),
        },
    }
}

/// An error to two digits.
fn short_error(error: f64) -> f64 {
    format!("{error:.1e}").parse().unwrap_or(error)
}

fn shows_creep(facts: &[RecordFacts]) -> bool {
    facts.iter().any(|f| {
        let steps =
            matches!(excitation_kind(&f.data.u), ExcitationKind::Steps { .. }) && f.duration_s() >= LONG_S;
        steps || f.data.longest_hold_s() >= LONG_S
    })
}

fn creep(facts: &[RecordFacts]) -> Prospect {
    let longest = facts.iter().map(RecordFacts::duration_s).fold(0.0, f64::max);
    let (determined, text) = if shows_creep(facts) {
        (Some(true), format!("held levels, records of up to {} s", brief(longest)))
    } else if longest >= LONG_S {
        let text = format!(
            "up to the {} s of the longest record, but no constant level separates it from the loop",
            brief(longest)
        );
        (None, text)
    } else if longest == 0.0 {
        (Some(false), "the records have no time".to_owned())
    } else {
        (Some(false), format!("the longest record has {} s, and no level is held", brief(longest)))
    };
    Prospect { topic: "creep".into(), determined, text }
}

/// True if the drive starts at 0 V, or steps from rest.
fn starts_at_rest(facts: &RecordFacts) -> bool {
    let data = &facts.data;
    let near_zero = data.u.first().is_some_and(|first| first.abs() <= OFF_ZERO * facts.range_v());
    near_zero || fit_start_up(data, facts.periods.as_ref()).is_some()
}

fn starts(facts: &[RecordFacts]) -> Prospect {
    let from_zero = facts.iter().filter(|f| starts_at_rest(f)).count();
    let (determined, text) = match from_zero {
        n if n == facts.len() => (Some(true), "every record starts from rest".to_owned()),
        0 => (
            Some(false),
            "no record starts from rest: the initial hysteresis memory of each record is a further unknown"
                .to_owned(),
        ),
        n => (
            None,
            format!(
                "{n} of {} records start from rest; the others begin with an unknown memory",
                facts.len()
            ),
        ),
    };
    Prospect { topic: "start and offset".into(), determined, text }
}
