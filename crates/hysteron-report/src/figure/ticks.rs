//! Tick positions and their labels: steps of 1, 2 or 5 times a power of ten, decades on a logarithmic axis.

use hysteron_numeric::number::{fixed, superscript};

use super::Scale;

/// Marks of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ticks {
    /// Labelled positions, ascending, in the axis' unit.
    pub major: Vec<f64>,
    /// Text of each labelled position.
    pub labels: Vec<String>,
    /// Unlabelled positions between (logarithmic axes).
    pub minor: Vec<f64>,
    /// The labels are values divided by `10^exponent`; the axis title has to say so when it is not 0.
    pub exponent: i32,
}

/// Ranges narrower than this cannot be divided by powers of ten that a double holds.
pub(crate) const SMALLEST_SPAN: f64 = 1e-280;

/// Ticks of an axis from `low` to `high` with at most `limit` labelled positions (`limit` is taken between 2
/// and 10), or one more where else there would be one alone, from which no scale can be read. An empty set
/// when the limits are not finite, not ordered, closer than 1e-280, or (on a logarithmic axis) not positive.
pub fn ticks(scale: Scale, low: f64, high: f64, limit: usize) -> Ticks {
    let limit = limit.clamp(2, 10);
    let span = high - low;
    if !(low.is_finite() && high.is_finite() && span.is_finite() && span >= SMALLEST_SPAN) {
        return Ticks::default();
    }
    match scale {
        Scale::Linear => linear(low, high, limit),
        Scale::Log if low > 0.0 => logarithmic(low, high, limit),
        Scale::Log => Ticks::default(),
    }
}

/// Smallest step m·10^e, m ∈ {1, 2, 5}, that is at least `raw`; returned as (m, e).
fn step_at_least(raw: f64) -> (f64, i32) {
    let decade = raw.log10().floor() as i32;
    for (mantissa, e) in [(1.0, decade), (2.0, decade), (5.0, decade), (1.0, decade + 1)] {
        if scaled(mantissa, e) >= raw * (1.0 - 1e-12) {
            return (mantissa, e);
        }
    }
    (2.0, decade + 1)
}

/// mantissa · 10^exponent, rounded once.
fn scaled(mantissa: f64, exponent: i32) -> f64 {
    if exponent < 0 { mantissa / 10f64.powi(-exponent) } else { mantissa * 10f64.powi(exponent) }
}

/// Multiples of the 1-2-5 step inside `low..=high`.
fn linear(low: f64, high: f64, limit: usize) -> Ticks {
    // The finest step that gives few enough ticks; such a step always gives at least one.
    let mut step = step_at_least(0.4 * (high - low) / limit as f64);
    let size = |(mantissa, e): (f64, i32)| scaled(mantissa, e);
    let ends = |step| ((low / size(step) - 1e-9).ceil(), (high / size(step) + 1e-9).floor());
    let count = |step| {
        let (first, last) = ends(step);
        last - first + 1.0
    };
    let coarser = |step| step_at_least(1.01 * size(step));
    let most = |step| if count(coarser(step)) < 2.0 { limit + 1 } else { limit };
    while count(step) > most(step) as f64 {
        step = coarser(step);
    }
    let (first, last) = ends(step);
    let (mantissa, e) = step;
    let count = (last - first + 1.0).clamp(0.0, limit as f64 + 1.0) as usize;
    let major: Vec<f64> = (0..count).map(|i| scaled((first + i as f64) * mantissa, e) + 0.0).collect();
    let exponent = common_exponent(low.abs().max(high.abs()));
    let decimals = (exponent - e).clamp(0, 12) as usize;
    let labels = major.iter().map(|value| fixed(value / 10f64.powi(exponent), decimals)).collect();
    Ticks { major, labels, minor: Vec::new(), exponent }
}

/// Power of ten, a multiple of 3, taken out of labels that would be too long: 0 for 0.01 ≤ |v| < 100 000.
fn common_exponent(largest: f64) -> i32 {
    if largest == 0.0 || (0.01..1e5).contains(&largest) {
        return 0;
    }
    3 * (largest.log10() / 3.0).floor() as i32
}

/// Decades (every k-th when there are many), with 2 and 5 between them when there are few; on less than
/// most of a decade the linear rule applies.
fn logarithmic(low: f64, high: f64, limit: usize) -> Ticks {
    let (first, last) = (low.log10() - 1e-9, high.log10() + 1e-9);
    let (d0, d1) = (first.floor() as i32, last.ceil() as i32);
    let inside = |value: f64| value.log10() >= first && value.log10() <= last;
    let pick = |mantissas: &[f64]| -> Vec<f64> {
        (d0..=d1)
            .flat_map(|d| mantissas.iter().map(move |m| scaled(*m, d)))
            .filter(|value| inside(*value))
            .collect()
    };
    let fine = pick(&[1.0, 2.0, 5.0]);
    if fine.len() < 3 {
        return linear(low, high, limit);
    }
    let decades = pick(&[1.0]);
    let minor = if decades.len() <= 10 {
        pick(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0])
    } else {
        decades.clone()
    };
    let major = if fine.len() <= limit && decades.len() < 4 {
        fine
    } else {
        let every = decades.len().div_ceil(limit).max(1) as i32;
        let kept: Vec<f64> = (d0..=d1)
            .filter(|d| d.rem_euclid(every) == 0)
            .map(|d| scaled(1.0, d))
            .filter(|v| inside(*v))
            .collect();
        if kept.len() < 2 { fine.into_iter().take(limit).collect() } else { kept }
    };
    let minor = minor.into_iter().filter(|value| !major.contains(value)).collect();
    let plain = low >= 0.99e-3 && high <= 1.01e5;
    let labels =
        major.iter().map(|value| if plain { plain_label(*value) } else { power_label(*value) }).collect();
    Ticks { major, labels, minor, exponent: 0 }
}

/// 0.05, 20, 10 000.
fn plain_label(value: f64) -> String {
    let decimals = (-(value.log10() + 1e-9).floor()).max(0.0) as usize;
    fixed(value, decimals)
}

/// 10⁻⁴, 2×10⁻⁴.
fn power_label(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor() as i32;
    let mantissa = (value / 10f64.powi(exponent)).round() as i64;
    let power = format!("10{}", superscript(exponent));
    if mantissa == 1 { power } else { format!("{mantissa}×{power}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_axes_get_the_ticks_a_person_would_draw() {
        let t = ticks(Scale::Linear, 0.0, 1.0, 6);
        assert_eq!(t.labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let t = ticks(Scale::Linear, -123.0, -70.0, 7);
        assert_eq!(t.labels, ["−120", "−110", "−100", "−90", "−80", "−70"]);
        let t = ticks(Scale::Log, 1.0, 1e4, 10);
        assert_eq!(t.labels, ["1", "10", "100", "1000", "10\u{2009}000"]);
        let t = ticks(Scale::Log, 1e-6, 1e-2, 10);
        assert_eq!(t.labels, ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²"]);
        let t = ticks(Scale::Log, 0.01, 0.5, 10);
        assert_eq!(t.labels, ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"]);
        let t = ticks(Scale::Linear, -4.4, 4.4, 4);
        assert_eq!(t.labels, ["−4", "−2", "0", "2", "4"], "0 alone is no scale");
        let t = ticks(Scale::Linear, 0.0, 4e-5, 5);
        assert_eq!(
            (t.exponent, t.labels.as_slice()),
            (-6, ["0", "10", "20", "30", "40"].map(String::from).as_slice())
        );
    }

    #[test]
    fn axes_that_cannot_be_drawn_have_no_ticks() {
        for (low, high) in
            [(0.0, 0.0), (1.0, 0.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-f64::MAX, f64::MAX)]
        {
            assert_eq!(ticks(Scale::Linear, low, high, 5), Ticks::default());
        }
        assert_eq!(ticks(Scale::Log, 0.0, 1.0, 5), Ticks::default());
    }

    fn is_one_two_five(step: f64) -> bool {
        let mantissa = step / 10f64.powf((step.log10() + 1e-6).floor());
        [1.0, 2.0, 5.0].iter().any(|m| (mantissa / m - 1.0).abs() < 1e-6)
    }

    proptest! {
        #[test]
        fn linear_ticks_cover_the_range_in_equal_1_2_5_steps(
            low in -1e6f64..1e6, magnitude in -6f64..9.0, limit in 2usize..=10,
        ) {
            let high = low + 10f64.powf(magnitude).max(1e-7 * low.abs());
            let t = ticks(Scale::Linear, low, high, limit);
            let slack = 1e-6 * (high - low);
            prop_assert!(t.major.len() <= limit + 1 && !t.major.is_empty());
            prop_assert!(limit < 4 || t.major.len() > 1, "one of {limit}");
            prop_assert_eq!(t.major.len(), t.labels.len());
            prop_assert!(t.major.iter().all(|v| *v >= low - slack && *v <= high + slack));
            if let [first, second, ..] = t.major[..] {
                let step = second - first;
                prop_assert!(is_one_two_five(step), "step {step}");
                prop_assert!(t.major.windows(2).all(|w| ((w[1] - w[0]) / step - 1.0).abs() < 1e-4));
                prop_assert!(first - low < step * 1.001 && high - t.major[t.major.len() - 1] < step * 1.001);
            }
        }

        #[test]
        fn labels_read_back_as_their_ticks(low in -1e4f64..1e4, magnitude in -3f64..7.0) {
            let high = low + 10f64.powf(magnitude);
            let t = ticks(Scale::Linear, low, high, 8);
            for (value, label) in t.major.iter().zip(&t.labels) {
                let text = label.replace('−', "-").replace('\u{2009}', "");
                let read: f64 = text.parse().unwrap();
                prop_assert!(
                    (read * 10f64.powi(t.exponent) - value).abs() <= 1e-6 * (high - low),
                    "{label} for {value}"
                );
            }
        }

        #[test]
        fn logarithmic_ticks_stay_inside_and_are_few(
            low in -12f64..6.0,
            span in 0.05f64..15.0,
            limit in 3usize..=10,
        ) {
            let (low, high) = (10f64.powf(low), 10f64.powf(low + span));
            let t = ticks(Scale::Log, low, high, limit);
            // Below a decade the linear rule applies: one more than the limit, where the coarser step leaves one.
            let most = if span < 1.0 { limit + 1 } else { limit };
            prop_assert!(!t.major.is_empty() && t.major.len() <= most, "{} ticks", t.major.len());
            prop_assert!(
                t.major.iter().chain(&t.minor).all(|v| *v >= low * 0.999_999 && *v <= high * 1.000_001)
            );
            prop_assert!(t.major.windows(2).all(|w| w[1] > w[0]));
            if span >= 1.0 {
                prop_assert!(t.major.len() >= 2, "a decade or more needs two labels");
            }
        }
    }
}
