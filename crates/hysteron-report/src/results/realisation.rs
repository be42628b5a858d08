//! A realisation: its sections, and how exact it is.

use hysteron_model::model::CheckedRealisation;

use super::Listing;
use crate::number::significant;

/// Taps and sections x ← x + g (w − x) with output c·x.
pub fn sections(found: &CheckedRealisation) -> Listing {
    let linear = &found.realisation.dynamics;
    let rate = found.realisation.sample_rate_hz;
    let number = |x: f64| significant(x, 6);
    let mut sections = Listing::new(["section", "decay rate [rad/s]", "g", "c"]);
    for (j, tap) in linear.taps.iter().enumerate() {
        sections.push([
            format!("tap, {} samples ago", linear.delay_samples + j),
            "-".into(),
            "-".into(),
            number(*tap),
        ]);
    }
    for section in &linear.sections {
        let complex = |re: f64, im: f64| {
            if section.is_pair() {
                format!("{} {} {}i", number(re), if im < 0.0 { "−" } else { "+" }, number(im.abs()))
            } else {
                number(re)
            }
        };
        sections.push([
            if section.is_pair() { "pole pair" } else { "real pole" }.to_owned(),
            significant(section.rate(rate), 4),
            complex(section.gain.re, section.gain.im),
            complex(section.weight.re, section.weight.im),
        ]);
    }
    sections
}

/// Size, exactness and cost.
pub fn facts(found: &CheckedRealisation) -> Listing {
    let (linear, check) = (&found.realisation.dynamics, &found.verification);
    let band = if linear.band_hz.0 > 0.0 {
        format!("{} Hz to {} Hz", significant(linear.band_hz.0, 3), significant(linear.band_hz.1, 4))
    } else {
        format!("rest to {} Hz", significant(linear.band_hz.1, 4))
    };
    let mut facts = Listing::new(["", ""]);
    for (what, value) in [
        ("states", linear.states().to_string()),
        ("taps", linear.taps.len().to_string()),
        ("delay", format!("{} samples, plus that of the taps", linear.delay_samples)),
        ("static gain", significant(linear.rest_gain, 6)),
        ("requested accuracy [fraction of range]", significant(found.accuracy, 2)),
        ("largest error of the response", format!("{}, {band}", significant(linear.frequency_error, 2))),
        (
            "against the batch simulation",
            format!(
                "{} largest, {} rms: sweep {} to {} Hz, {} to {} {}",
                significant(check.largest, 2),
                significant(check.rms, 2),
                significant(found.sweep.frequencies_hz.0, 3),
                significant(found.sweep.frequencies_hz.1, 3),
                significant(found.sweep.voltages.0, 4),
                significant(found.sweep.voltages.1, 4),
                found.units.0
            ),
        ),
        ("amplification of rounding (weights over gain)", significant(linear.amplification(), 3)),
        (
            "time per sample, double precision, this machine",
            format!("{} ns", significant(found.nanoseconds, 3)),
        ),
    ] {
        facts.push([what.to_owned(), value]);
    }
    facts
}
