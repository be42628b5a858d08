//! Content of a record's drive: amplitudes, frequencies, and their variation along the record.

use super::super::RecordFacts;
use hysteron_model::record::{ExcitationKind, excitation_kind, turning_points};

/// Amplitudes, middles or frequencies that differ by less than this share are the same.
pub(super) const SAME: f64 = 0.05;
/// Swings below this share of the range are noise rather than loops.
const SMALLEST_SWING: f64 = 0.1;

/// The drive of one record.
#[derive(Clone, Debug, PartialEq)]
pub struct Content {
    /// Half of the smallest and of the largest swing (of those above a tenth of the range) \[input unit\].
    pub amplitude: (f64, f64),
    /// Middle of the range \[input unit\].
    pub middle: f64,
    /// Lowest and highest frequency \[Hz\]; 0 where the drive has none (a few ramps, steps).
    pub frequency_hz: (f64, f64),
    /// Parts of the record (of its period, where it repeats) differ in amplitude or frequency.
    pub varied: bool,
}

impl Content {
    pub(in super::super) fn of(facts: &RecordFacts) -> Self {
        let u = &facts.data.u;
        let (low, high) = facts.ends;
        let turns = turning_points(u, SMALLEST_SWING * (high - low));
        let swings = turns.windows(2).map(|w| 0.5 * (w[1].value - w[0].value).abs());
        let (mut smallest, mut largest) = (f64::INFINITY, 0f64);
        for swing in swings {
            (smallest, largest) = (smallest.min(swing), largest.max(swing));
        }
        if largest == 0.0 {
            (smallest, largest) = (0.5 * (high - low), 0.5 * (high - low));
        }
        let rate = facts.data.sample_rate_hz().unwrap_or(0.0);
        let kind = excitation_kind(u);
        let (from, to) = kind.span().unwrap_or_default();
        let varied = match kind {
            ExcitationKind::Constant => false,
            ExcitationKind::Wave { turning_levels, .. } => turning_levels > 2,
            ExcitationKind::Ramps { .. } => turns.len() > 2 && !near(smallest, largest),
            _ => true,
        };
        Self {
            amplitude: (smallest, largest),
            middle: 0.5 * (low + high),
            frequency_hz: (from * rate, to * rate),
            varied,
        }
    }

    /// In words, e.g. `5 V, 1 to 100 Hz`.
    pub fn describe(&self, unit: &str) -> String {
        let span = |(a, b): (f64, f64)| {
            if near(a, b) { brief(b) } else { format!("{} to {}", brief(a), brief(b)) }
        };
        let amplitude = format!("{} {unit}", span(self.amplitude));
        if self.frequency_hz.1 > 0.0 {
            format!("{}, {} Hz", amplitude.trim_end(), span(self.frequency_hz))
        } else {
            amplitude.trim_end().to_owned()
        }
    }
}

/// True if two values agree to 5 %.
pub(super) fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.abs().max(b.abs())
}

/// A number to three digits, without trailing zeros.
pub(super) fn brief(x: f64) -> String {
    format!("{x:.2e}").parse::<f64>().map_or_else(|_| x.to_string(), |x| x.to_string())
}

/// True if the second record adds no information to the first: an equal steady wave, or an equal drive sample
/// by sample.
pub(super) fn same(a: (&RecordFacts, &Content), b: (&RecordFacts, &Content)) -> bool {
    let ((fa, ca), (fb, cb)) = (a, b);
    let alike = near(ca.amplitude.0, cb.amplitude.0)
        && near(ca.amplitude.1, cb.amplitude.1)
        && (ca.middle - cb.middle).abs() <= SAME * ca.amplitude.1
        && near(ca.frequency_hz.0, cb.frequency_hz.0)
        && near(ca.frequency_hz.1, cb.frequency_hz.1)
        && ca.varied == cb.varied;
    if !alike || !ca.varied {
        return alike;
    }
    let (ua, ub) = (&fa.data.u, &fb.data.u);
    fa.data.sample_rate_hz() == fb.data.sample_rate_hz()
        && near(ua.len() as f64, ub.len() as f64)
        && ua.iter().zip(ub).all(|(x, y)| (x - y).abs() <= SAME * ca.amplitude.1)
}
