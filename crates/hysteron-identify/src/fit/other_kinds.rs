//! Kinds of models beside the one that was asked for: the kind that records call for by their quantities, and
//! the one that describes them better than hysteresis followed by linear dynamics does; and a dead band of
//! the drive, with which that would describe them.

use hysteron_model::model_file::Kind;
use hysteron_model::record::{DeadBand, InputOutput, Quantity};
use hysteron_model::{Advice, Finding, FindingKind};
use hysteron_numeric::display::short;

use super::dead_band;
use crate::{CampaignRecord, Event, Identification, IdentifyError, Options, Watch, force, oscillator};

/// Share of every record \[%\] from which a model is taken as it is: other kinds are not tried.
const GOOD_PERCENT: f64 = 90.0;
/// Share of every record \[%\] from which no dead band of the drive is looked for.
const NEAR_PERCENT: f64 = 98.0;
/// Share of the error that another kind, or a dead band, may leave where it is named beside the model.
const BETTER: f64 = 0.5;
/// Share of the error that another kind may leave where the model is not handed out.
const MUCH_BETTER: f64 = 0.25;

/// Samples of all records together on which other kinds are tried: the first ones of each.
const MOST: usize = 200_000;

/// The kind of model for records of these quantities: a force where every record has a displacement as its
/// input and a force as its output, else a Hammerstein model.
pub fn usual_kind<'a>(records: impl IntoIterator<Item = &'a InputOutput>) -> Kind {
    let mut records = records.into_iter().peekable();
    let of_force = |record: &InputOutput| {
        matches!(record.u_unit.base().0, Quantity::Length | Quantity::Angle) && record.y_unit.is_force()
    };
    if records.peek().is_some() && records.all(of_force) { Kind::Force } else { Kind::Hammerstein }
}

/// Another kind that describes records, and how much of the worst of them it explains.
struct Other {
    kind: Kind,
    fit_percent: f64,
}

/// What there is to say where a model leaves much of the records and a model of another kind does not.
///
/// # Errors
/// [`IdentifyError::OtherKind`] where the other kind leaves less than a quarter of the error, unless `options`
/// demand nothing of the fit.
pub(super) fn weigh(
    found: &Identification,
    records: &[CampaignRecord],
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Option<Finding>, IdentifyError> {
    let worst = found.records.iter().min_by(|a, b| a.fit_percent().total_cmp(&b.fit_percent()));
    let Some(worst) = worst.filter(|_| !found.cancelled) else { return Ok(None) };
    let Some(other) = better(worst.fit_percent(), records, watch) else {
        return with_dead_band(&worst.data, worst.fit_percent(), options, watch);
    };
    let left = |percent: f64| 100.0 - percent;
    if options.least_fit_percent > 0.0 && left(other.fit_percent) <= MUCH_BETTER * left(worst.fit_percent()) {
        return Err(refused(worst.data.name.clone(), worst.fit_percent(), &other));
    }
    let text = format!(
        "A model of the kind {} leaves {:.1} % of the worst described record, where hysteresis followed by \
         linear dynamics leaves {:.1} %.",
        other.kind,
        left(other.fit_percent),
        left(worst.fit_percent())
    );
    let finding = Finding::new(FindingKind::Advice, "kind of model", text);
    Ok(Some(finding.with_advice(Advice::OtherKind { kind: other.kind })))
}

/// The error of a model that was refused, or, where a model of another kind describes the records, the name of
/// that kind.
pub(super) fn instead(error: IdentifyError, records: &[CampaignRecord], watch: &Watch<'_>) -> IdentifyError {
    match error {
        IdentifyError::ModelClass { ref record, fit_percent, .. } => {
            match better(fit_percent, records, watch) {
                Some(other) => refused(record.clone(), fit_percent, &other),
                None => records
                    .iter()
                    .find(|one| one.data.name == *record)
                    .and_then(|one| dead(&one.data, fit_percent, watch))
                    .map_or(error, |found| found.refused()),
            }
        }
        other => other,
    }
}

fn refused(record: String, fit_percent: f64, other: &Other) -> IdentifyError {
    IdentifyError::OtherKind { record, fit_percent, kind: other.kind, other_percent: other.fit_percent }
}

/// A dead band that describes a record.
struct Dead<'a> {
    record: &'a InputOutput,
    fit_percent: f64,
    found: dead_band::Found,
}

impl Dead<'_> {
    /// To four digits, as a flag takes it.
    fn threshold(&self) -> String {
        let four = format!("{:.3e}", self.found.band.threshold());
        four.parse::<f64>().map_or(four, |threshold| threshold.to_string())
    }

    fn is_excess(&self) -> bool {
        matches!(self.found.band, DeadBand::Excess(_))
    }

    /// How a drive counts.
    fn counts(&self) -> &'static str {
        if self.is_excess() { "counts as 0 and a larger one by what exceeds that" } else { "counts as 0" }
    }

    fn refused(&self) -> IdentifyError {
        IdentifyError::DeadBand {
            record: self.record.name.clone(),
            fit_percent: self.fit_percent,
            threshold: self.threshold(),
            unit: self.record.u_unit.to_string(),
            counts: self.counts(),
            excess: self.is_excess(),
            other_percent: 100.0 - self.found.left_percent,
        }
    }

    fn finding(&self) -> Finding {
        let text = format!(
            "Record '{}' looks as if a drive below {} moved nothing: where it {}, a linear regression \
             leaves {} % of it, on the drive as it is {} %, and this model {} %.",
            self.record.name,
            format!("{} {}", self.threshold(), self.record.u_unit).trim_end(),
            self.counts(),
            short(self.found.left_percent),
            short(self.found.without_percent),
            short(100.0 - self.fit_percent),
        );
        let advice = Advice::DeadBand { threshold: self.threshold(), excess: self.is_excess() };
        Finding::new(FindingKind::Advice, "dead band", text).with_advice(advice)
    }
}

/// A dead band that leaves less than half of the error of a fit that explains `fit_percent` of a record, and
/// of a regression without it.
fn dead<'a>(record: &'a InputOutput, fit_percent: f64, watch: &Watch<'_>) -> Option<Dead<'a>> {
    if fit_percent >= NEAR_PERCENT {
        return None;
    }
    let found = dead_band::best(record, watch.stop())?;
    let enough = BETTER * found.without_percent.min(100.0 - fit_percent);
    (found.left_percent <= enough).then_some(Dead { record, fit_percent, found })
}

/// What there is to say of a dead band of the drive.
///
/// # Errors
/// [`IdentifyError::DeadBand`] where it leaves less than a quarter of the error of a poor model, unless
/// `options` demand nothing of the fit.
fn with_dead_band(
    record: &InputOutput,
    fit_percent: f64,
    options: &Options,
    watch: &Watch<'_>,
) -> Result<Option<Finding>, IdentifyError> {
    let Some(found) = dead(record, fit_percent, watch) else { return Ok(None) };
    let is_poor = fit_percent < GOOD_PERCENT && options.least_fit_percent > 0.0;
    if is_poor && found.found.left_percent <= MUCH_BETTER * (100.0 - fit_percent) {
        return Err(found.refused());
    }
    Ok(Some(found.finding()))
}

/// The kind with the smallest error among those that leave less than half of the error of a fit that explains
/// `fit_percent` of the worst record.
fn better(fit_percent: f64, records: &[CampaignRecord], watch: &Watch<'_>) -> Option<Other> {
    if fit_percent >= GOOD_PERCENT || watch.stop().is_requested() {
        return None;
    }
    if watch.tell(Event::new("other kinds of model", 1.0, None)).is_break() {
        return None;
    }
    let share = (MOST as f64 / records.iter().map(|record| record.data.len()).sum::<usize>() as f64).min(1.0);
    let first = |record: &CampaignRecord| {
        let data = &record.data;
        data.first_samples((share * data.len() as f64).ceil() as usize)
    };
    let records: Vec<InputOutput> = records.iter().map(first).collect();
    let quiet = Watch::silent().stopped_by(watch.stop());
    let found = [Kind::Oscillator, Kind::Force].map(|kind| Other {
        kind,
        fit_percent: explained(kind, &records, &quiet).unwrap_or(f64::NEG_INFINITY),
    });
    found
        .into_iter()
        .max_by(|a, b| a.fit_percent.total_cmp(&b.fit_percent))
        .filter(|other| 100.0 - other.fit_percent <= BETTER * (100.0 - fit_percent))
}

/// Share of the worst record that a model of a kind explains \[%\]; `None` for records that are none of its.
fn explained(kind: Kind, records: &[InputOutput], watch: &Watch<'_>) -> Option<f64> {
    let all: Vec<f64> = match kind {
        Kind::Oscillator => {
            let options = oscillator::Options { least_fit_percent: f64::NEG_INFINITY, ..Default::default() };
            let found = oscillator::identify(records, &options, watch, None).ok()?;
            found.records.iter().map(|fit| fit.scores.fit_percent).collect::<Option<_>>()?
        }
        Kind::Force if usual_kind(records) == Kind::Force => {
            let options = force::Options { least_fit_percent: f64::NEG_INFINITY, ..Default::default() };
            let found = force::identify(records, &options, watch, None).ok()?;
            found.records.iter().map(|fit| fit.scores.fit_percent).collect::<Option<_>>()?
        }
        _ => return None,
    };
    all.into_iter().min_by(f64::total_cmp)
}
