//! Curves for the page, from the decimation that the reports use.

use hysteron_model::record::{InputOutput, TimeBase, Unit, range_of};
use hysteron_report::figure::decimate;

use crate::api::{Axis, Curve};

/// Points of a small loop in the list.
const GLYPH_POINTS: usize = 64;
/// Points a pixel: first, least, greatest and last.
const PER_PIXEL: usize = 4;
/// Widest drawing \[pixels\].
const WIDEST: usize = 4000;
/// Periods of a loop that are drawn where it has more: the way from the start, and where it has settled.
const FIRST: usize = 2;
const LAST: usize = 5;
/// Samples above which a loop without periods is drawn of its beginning and its end only.
const LONG_LOOP: usize = 200_000;

/// A quantity along an axis.
pub(crate) struct Along<'a> {
    pub name: &'a str,
    pub unit: String,
    pub samples: &'a [f64],
}

impl<'a> Along<'a> {
    pub(crate) fn new(name: &'a str, unit: &Unit, samples: &'a [f64]) -> Self {
        Self { name, unit: unit.to_string(), samples }
    }

    fn axis(&self) -> Axis {
        let (low, high) = range_of(self.samples);
        Axis { name: self.name.to_owned(), unit: self.unit.clone(), low, high }
    }
}

/// Samples between two times, by the stamps of the record.
pub(crate) fn between(
    time: &TimeBase,
    samples: usize,
    from: Option<f64>,
    to: Option<f64>,
) -> std::ops::Range<usize> {
    let stamp = |k: usize| time.time_s(k).unwrap_or(k as f64);
    // Stamps never decrease.
    let first_at_least = |limit: f64| {
        let (mut low, mut high) = (0, samples);
        while low < high {
            let middle = low.midpoint(high);
            if stamp(middle) < limit { low = middle + 1 } else { high = middle }
        }
        low
    };
    let first = from.map_or(0, first_at_least).min(samples);
    let end = to.map_or(samples, |to| first_at_least(to.next_up())).min(samples);
    // A neighbour on either side, so that lines reach the edges of the drawing.
    first.saturating_sub(1)..end.saturating_add(1).min(samples).max(first)
}

/// A quantity over time in a part of the record.
pub(crate) fn over_time(
    time: &TimeBase,
    y: &Along<'_>,
    part: std::ops::Range<usize>,
    pixels: usize,
) -> Curve {
    let samples = y.samples.len();
    let points: Vec<(f64, f64)> =
        part.clone().map(|k| (time.time_s(k).unwrap_or(k as f64), y.samples[k])).collect();
    let is_whole = part.len() == samples;
    let pixels = pixels.clamp(16, WIDEST);
    let width = points.first().zip(points.last()).map_or(1.0, |(a, b)| b.0 - a.0);
    let kept = decimate(&points, width / pixels as f64, PER_PIXEL * (pixels + 2));
    let extent = time.extent_s(samples).unwrap_or((0.0, samples.saturating_sub(1) as f64));
    let (name, unit) = match time {
        TimeBase::Unknown => ("sample", ""),
        _ => ("t", "s"),
    };
    let across = Axis { name: name.to_owned(), unit: unit.to_owned(), low: extent.0, high: extent.1 };
    let shown = match (is_whole, kept.len() == points.len()) {
        (true, true) => format!("all {samples} samples"),
        (true, false) => format!("least and greatest of each pixel, {samples} samples"),
        (false, true) => format!("{} of {samples} samples", points.len()),
        (false, false) => format!("least and greatest of each pixel, {} of {samples} samples", points.len()),
    };
    curve(kept, across, y.axis(), points.len(), shown)
}

/// One quantity over another in a part of the record. `periods`: samples of a period, and whole periods.
pub(crate) fn over(
    x: &Along<'_>,
    y: &Along<'_>,
    part: std::ops::Range<usize>,
    pixels: usize,
    periods: Option<(f64, usize)>,
) -> Curve {
    let samples = y.samples.len().min(x.samples.len());
    let (parts, shown) = loop_parts(part, samples, periods);
    let (x_axis, y_axis) = (x.axis(), y.axis());
    let pixels = pixels.clamp(16, WIDEST);
    // Both axes in pixels of a square drawing, as the decimation compares distances.
    let scale = |axis: &Axis| {
        let width = axis.high - axis.low;
        if width > 0.0 { pixels as f64 / width } else { 1.0 }
    };
    let (to_x, to_y) = (scale(&x_axis), scale(&y_axis));
    let mut points = Vec::new();
    let mut drawn = 0;
    for part in parts {
        if !points.is_empty() {
            points.push((f64::NAN, f64::NAN));
        }
        drawn += part.len();
        points.extend(part.map(|k| (x.samples[k] * to_x, y.samples[k] * to_y)));
    }
    let kept = decimate(&points, 0.5, 8 * pixels);
    let kept = kept.into_iter().map(|(a, b)| (a / to_x, b / to_y)).collect();
    curve(kept, x_axis, y_axis, drawn, shown)
}

/// Which samples of a loop are drawn, and in words: whole periods, not every n-th sample.
fn loop_parts(
    part: std::ops::Range<usize>,
    samples: usize,
    periods: Option<(f64, usize)>,
) -> (Vec<std::ops::Range<usize>>, String) {
    let part = part.start.min(samples)..part.end.min(samples);
    let is_whole = part.len() == samples;
    if let Some((period, count)) = periods.filter(|(_, count)| is_whole && *count > FIRST + LAST) {
        let of = |periods: usize| ((periods as f64 * period).round() as usize + 1).min(samples);
        let text = format!("the first {FIRST} and the last {LAST} of {count} periods");
        return (vec![0..of(FIRST), samples - of(LAST)..samples], text);
    }
    if part.len() <= LONG_LOOP {
        let text = match is_whole {
            true => format!("all {samples} samples"),
            false => format!("{} of {samples} samples", part.len()),
        };
        return (vec![part], text);
    }
    let half = LONG_LOOP / 2;
    let text = format!("the first and the last {half} of {} samples", part.len());
    (vec![part.start..part.start + half, part.end - half..part.end], text)
}

fn curve(points: Vec<(f64, f64)>, across: Axis, up: Axis, samples: usize, shown: String) -> Curve {
    let mut drawn = Curve { across, up, samples, shown, ..Curve::default() };
    let mut broken = false;
    for (x, y) in points {
        if !(x.is_finite() && y.is_finite()) {
            broken = true;
            continue;
        }
        if broken && !drawn.x.is_empty() {
            drawn.breaks.push(drawn.x.len());
        }
        broken = false;
        drawn.x.push(x);
        drawn.y.push(y);
    }
    drawn
}

/// Small loop for the list, each coordinate between 0 and 1.
pub(crate) fn glyph(data: &InputOutput, period: Option<usize>) -> Vec<[f64; 2]> {
    let samples = data.len();
    // The last period where the record repeats, else its beginning: a thumbnail, not a measurement.
    let length = period.unwrap_or(samples).clamp(1, samples.max(1));
    let part = samples.saturating_sub(length)..samples;
    let (u, y) = (range_of(&data.u), range_of(&data.y));
    let unit = |x: f64, (low, high): (f64, f64)| if high > low { (x - low) / (high - low) } else { 0.5 };
    let step = part.len().div_ceil(GLYPH_POINTS).max(1);
    part.step_by(step).map(|k| [unit(data.u[k], u), unit(data.y[k], y)]).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::*;

    #[test]
    fn a_loop_of_many_periods_shows_the_first_and_the_last_and_does_not_join_them() {
        let wave = |phase: f64| -> Vec<f64> {
            (0..1000).map(|k| (std::f64::consts::TAU * f64::from(k) / 100.0 + phase).sin()).collect()
        };
        let (u, mut y) = (wave(0.0), wave(0.3));
        // What settles between them is not drawn.
        y[350] = 9.0;
        let (u, y) = (Along::new("u", &Unit::new("V"), &u), Along::new("y", &Unit::new("um"), &y));
        let drawn = over(&u, &y, 0..1000, 500, Some((100.0, 10)));
        assert_eq!(drawn.shown, "the first 2 and the last 5 of 10 periods");
        assert_eq!((drawn.samples, drawn.up.unit.as_str()), (702, "µm"));
        assert!(drawn.y.iter().all(|y| *y < 1.1) && !drawn.breaks.is_empty(), "{:?}", drawn.breaks);
        let all = over(&u, &y, 0..1000, 500, None);
        assert!(all.shown == "all 1000 samples" && all.y.contains(&9.0));
    }

    #[test]
    fn a_part_is_taken_by_the_stamps_with_a_neighbour_on_either_side() {
        let stamps = TimeBase::NonUniform { times_s: vec![0.0, 1.0, 1.0, 2.0, 5.0, 9.0] };
        assert_eq!(between(&stamps, 6, Some(1.0), Some(2.0)), 0..5);
        assert_eq!(between(&stamps, 6, None, None), 0..6);
        assert_eq!(between(&stamps, 6, Some(3.0), Some(4.0)), 3..5);
        assert_eq!(between(&stamps, 6, Some(20.0), None), 5..6);
        assert_eq!(between(&TimeBase::Unknown, 6, Some(2.0), Some(3.0)), 1..5);
        assert!(between(&stamps, 0, Some(1.0), Some(2.0)).is_empty());
    }

    #[test]
    fn a_curve_over_time_says_what_it_shows() {
        let y: Vec<f64> = (0..10_000).map(|k| f64::from(k % 7)).collect();
        let along = Along::new("y", &Unit::new("um"), &y);
        let time = TimeBase::uniform(1000.0);
        let all = over_time(&time, &along, 0..10_000, 100);
        assert_eq!(all.shown, "least and greatest of each pixel, 10000 samples");
        assert!(all.x.len() <= 408 && all.across.high == 9.999, "{}", all.x.len());
        let few = over_time(&time, &along, 100..150, 100);
        assert_eq!((few.shown.as_str(), few.x.len()), ("50 of 10000 samples", 50));
    }
}
