//! What the preparation of records did.

use hysteron_model::record::{PreparedSummary, Step};
use hysteron_numeric::display::short;

/// Steps done and the record that came of them, a line each; `file`: where it was written.
pub fn lines(prepared: &PreparedSummary, file: &str) -> Vec<String> {
    let mut lines: Vec<String> = prepared.steps.iter().map(step).collect();
    let resampled = prepared.steps.iter().any(|step| matches!(step, Step::Resampled { .. }));
    if !prepared.gaps.is_empty() && !resampled {
        lines.push(format!("{} (longer than three of their neighbours' periods)", gaps(prepared.gaps.len())));
    }
    let time = match (prepared.start_s, prepared.end_s) {
        (Some(start), Some(end)) => format!(", {} to {} s", short(start), short(end)),
        _ => ", without time".to_owned(),
    };
    let rate = match prepared.sample_rate_hz {
        Some(rate) => format!(" at {} Hz", short(rate)),
        None if prepared.start_s.is_some() => ", not uniform".to_owned(),
        None => String::new(),
    };
    let columns: Vec<String> = prepared
        .columns
        .iter()
        .map(|c| {
            let unit = if c.unit.is_empty() { String::new() } else { format!(" {}", c.unit) };
            format!("{} {} to {}{unit}", c.name, short(c.low), short(c.high))
        })
        .collect();
    let masked = match prepared.masked_samples {
        0 => String::new(),
        masked => format!("; {masked} not valid"),
    };
    lines.push(format!(
        "wrote {} samples to {file}{time}{rate}: {}{masked}",
        prepared.samples,
        columns.join(", ")
    ));
    lines
}

fn step(step: &Step) -> String {
    match step {
        Step::Joined { records } => format!("joined {records} records"),
        Step::Scaled { scale } => format!("scaled {scale}"),
        Step::MeanRemoved { channel, mean } => format!("removed the mean of {channel}, {}", short(*mean)),
        Step::Detrended { channel, mean, per_s } => {
            format!("removed the trend of {channel}, mean {}, {} per s", short(*mean), short(*per_s))
        }
        Step::Resampled { from_hz, to_hz, gaps: count, samples_in_gaps } => {
            let from =
                from_hz.map_or("stamps that are not uniform".to_owned(), |hz| format!("{} Hz", short(hz)));
            let masked = match count {
                0 => String::new(),
                count => format!("; {}, {samples_in_gaps} samples in them marked not valid", gaps(*count)),
            };
            format!("resampled from {from} to {} Hz{masked}", short(*to_hz))
        }
    }
}

fn gaps(count: usize) -> String {
    if count == 1 { "1 gap".to_owned() } else { format!("{count} gaps") }
}
