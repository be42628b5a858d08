//! A comparison of structures with the run-time cost of each candidate and with black-box baselines.

use std::time::Duration;

use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{Invertibility, TimedDrive};
use hysteron_model::model_file::{Maker, ModelFile, ModelFileError, SignalUnits};
use hysteron_model::realise::{Cost, RealiseOptions, side_by_side};
use hysteron_model::record::Timing;
use hysteron_numeric::number::significant;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

use crate::baselines::{CrossValidated, Trained};
use crate::fit::{Fit, FitRecords, Task, fit};
use crate::structure::{Candidate, Comparison, Entry, Fold, Standing};
use crate::watch::Watch;
use crate::{CampaignRecord, IdentifyError, Options};

/// Samples of the timed drive, and timing rounds over all candidates.
const SAMPLES: usize = 10_000;
const ROUNDS: usize = 15;

/// A comparison and everything reported about it.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The comparison.
    pub comparison: Comparison,
    /// Black-box models on the same folds.
    pub baselines: Vec<CrossValidated>,
    /// Names of the records.
    pub records: Vec<String>,
    /// Unit of the output, as printed.
    pub unit: String,
    /// Cost of each candidate, in the order of the entries.
    pub costs: Vec<CandidateCost>,
}

/// Cost of a candidate in a controller.
#[derive(Clone, Debug, Default)]
pub struct CandidateCost {
    /// Cost of its realisation; `None` where it was not fitted or cannot be realised.
    pub cost: Option<Cost>,
    /// Why there is none.
    pub why_not: Option<String>,
    /// Invertibility of its hysteresis.
    pub inverse: Option<Invertibility>,
}

impl Compared {
    /// The comparison of a campaign with costs timed by a clock, `now`, and with these baselines.
    pub fn new(
        comparison: Comparison,
        campaign: &[CampaignRecord],
        baselines: Vec<CrossValidated>,
        now: &dyn Fn() -> Duration,
    ) -> Self {
        Self {
            costs: costs(&comparison, campaign, now),
            comparison,
            baselines,
            records: campaign.iter().map(|r| r.data.name.clone()).collect(),
            unit: campaign.first().map_or(String::new(), |r| r.data.y_unit.to_string()),
        }
    }

    /// The preferred structure as the comparison fitted it to all records, thinned where they are
    /// oversampled, without intervals. `None` where there is no ranking.
    ///
    /// # Errors
    /// [`ModelFileError`] for a model that no file can hold.
    pub fn preferred_so_far(
        &self,
        campaign: &[CampaignRecord],
    ) -> Option<(Candidate, Result<hysteron_model::Model, ModelFileError>)> {
        let preferred = &self.comparison.entries[self.comparison.ranking.as_ref()?.preferred];
        let (model, data) = (preferred.model.as_ref()?, &campaign.first()?.data);
        let file = ModelFile::from_model(model, SignalUnits::of(&data.u_unit, &data.y_unit));
        Some((preferred.candidate, file.try_into()))
    }

    /// The preferred structure, identified from all samples; `None` where there is no ranking.
    pub fn identify_preferred(
        &self,
        campaign: &[CampaignRecord],
        watch: &Watch<'_>,
        maker: &Maker,
    ) -> Option<(Candidate, Result<Fit, IdentifyError>)> {
        let preferred = &self.comparison.entries[self.comparison.ranking.as_ref()?.preferred];
        let options = Options { continued: self.comparison.continued, ..Options::default() };
        let options = Options { start: preferred.model.clone(), ..preferred.candidate.options(&options) };
        let (records, task) = (FitRecords::Single(campaign.to_vec()), Task::Hammerstein(Box::new(options)));
        Some((preferred.candidate, fit(&records, &task, watch, None, maker)))
    }

    /// Candidates in the order of the ranking, unranked ones last.
    pub fn order(&self) -> Vec<usize> {
        let comparison = &self.comparison;
        let mut order = comparison.ranking.as_ref().map_or(Vec::new(), |r| r.order.clone());
        order.extend((0..comparison.entries.len()).filter(|&i| self.standing(i).is_none()));
        order
    }

    /// Rank and verdict of a candidate, by its index among the entries.
    pub fn standing(&self, index: usize) -> Option<Standing> {
        self.comparison.ranking.as_ref().and_then(|r| r.standings[index])
    }

    /// The preferred structure and the reason, in plain words.
    pub fn verdict(&self) -> Vec<String> {
        let comparison = &self.comparison;
        let mut lines = Vec::new();
        if let Some(ranking) = &comparison.ranking {
            let name = |i: usize| comparison.entries[i].candidate.to_string();
            let (best, preferred) = (ranking.best, ranking.preferred);
            let error = |i: usize| self.standing(i).map_or(f64::NAN, |s| s.mean);
            let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
            let floor = significant(error(preferred) / comparison.noise_floor, 2);
            lines.push(if best == preferred {
                format!(
                    "Preferred: {}. It has the smallest held-out error, {}{unit}, {floor} times the noise \
                     floor, and no simpler structure is within one standard error of it.",
                    name(best),
                    significant(error(best), 3)
                )
            } else {
                format!(
                    "Preferred: {} ({} parameters, held-out error {}{unit}, {floor} times the noise floor). \
                     {} is smallest ({}{unit}, {} parameters), but not by more than one standard error of \
                     the difference.",
                    name(preferred),
                    comparison.entries[preferred].parameters,
                    significant(error(preferred), 3),
                    name(best),
                    significant(error(best), 3),
                    comparison.entries[best].parameters
                )
            });
            let as_good: Vec<String> = ranking
                .order
                .iter()
                .filter(|&&i| i != preferred && self.standing(i).is_some_and(|s| s.as_good_as_best))
                .map(|&i| name(i))
                .collect();
            if !as_good.is_empty() {
                lines.push(format!("These records do not distinguish it from: {}.", as_good.join(", ")));
            }
        }
        lines.extend(comparison.notes.iter().cloned());
        for entry in &comparison.entries {
            lines.extend(entry.failures.iter().map(|why| format!("{} is unranked: {why}.", entry.candidate)));
        }
        let hopeless = comparison.entries.iter().filter(|entry| entry.is_hopeless);
        let hopeless: Vec<String> = hopeless.map(|entry| entry.candidate.to_string()).collect();
        if !hopeless.is_empty() {
            lines.push(format!(
                "Not cross-validated, since already with all records in their fit their error is more than 1.2 \
                 times the smallest held-out error: {}.",
                hopeless.join(", ")
            ));
        }
        for (entry, cost) in comparison.entries.iter().zip(&self.costs) {
            if let Some(why) = &cost.why_not {
                lines.push(format!("{} was not timed sample by sample: {why}.", entry.candidate));
            }
        }
        if comparison.out_of_time {
            lines.push(
                "The time given was over: candidates that were not finished by then are missing.".to_owned(),
            );
        }
        if comparison.interrupted {
            lines.push("Interrupted: the candidates that were not finished are missing.".to_owned());
        }
        lines
    }

    /// Explanation of the columns of the table.
    pub fn about(&self) -> String {
        let comparison = &self.comparison;
        format!(
            "Held-out error: mean over {} folds of the RMSE of a simulation of the held-out data, offset \
             estimated, ± standard error over the folds. Above the best: mean ± standard error of the paired \
             differences. Noise floor {} {}. AIC and BIC are above their lowest, over {:.0} independent \
             samples (of {}) that the residuals are worth. ns per sample: of the realisation to 1e-5 of the \
             range (double precision, this machine, interleaved runs along one drive; small differences are \
             chance). Inverse: of the hysteresis block.",
            comparison.folds.len(),
            significant(comparison.noise_floor, 3),
            self.unit,
            comparison.independent_samples,
            comparison.samples
        )
    }

    /// Conclusions of the comparison with baselines, and the conditions it was made under.
    pub fn verdict_of_baselines(&self) -> Vec<String> {
        let comparison = &self.comparison;
        let best = comparison.ranking.as_ref().and_then(|r| self.standing(r.best)).map(|s| s.mean);
        let errors = self.baselines.iter().filter_map(|b| Some((b.error()?.0, b.kind.name())));
        let least = errors.min_by(|a, b| a.0.total_cmp(&b.0));
        let mut lines = Vec::new();
        if let (Some(best), Some((error, name))) = (best, least) {
            let ratio = significant(error / best, 3);
            lines.push(if error < best {
                format!(
                    "{name} has {ratio} times the error of the best structure: the structures compared miss \
                     an effect in these records."
                )
            } else {
                format!("The best baseline, {name}, has {ratio} times the error of the best structure.")
            });
        }
        for entry in &self.baselines {
            lines.extend(entry.failures.iter().map(|why| format!("{}: {why}.", entry.kind.name())));
        }
        lines.push(
            "Baselines are black-box NARX models trained on the same records, all choices made on what they \
             are trained on, simulated (not one step ahead) on the same held-out data. They hold for their \
             lag interval and have no inverse and no intervals."
                .to_owned(),
        );
        lines
    }
}

/// Costs and inverses in the order of the entries.
fn costs(
    comparison: &Comparison,
    campaign: &[CampaignRecord],
    now: &dyn Fn() -> Duration,
) -> Vec<CandidateCost> {
    let models: Vec<Option<&Model>> = comparison.entries.iter().map(|e| e.model.as_ref()).collect();
    let fitted: Vec<&Model> = models.iter().copied().flatten().collect();
    let rate = |record: &CampaignRecord| record.data.sample_rate_hz();
    // The fastest record is timed: the one that a controller at its rate would see.
    let record = campaign.iter().max_by(|a, b| rate(a).unwrap_or(0.0).total_cmp(&rate(b).unwrap_or(0.0)));
    let Some(record) = record else { return vec![CandidateCost::default(); models.len()] };
    let sample_rate_hz = rate(record).unwrap_or(1.0);
    let drive = record.data.u.get(..SAMPLES).unwrap_or(&record.data.u);
    // Unbounded creep is realised down to 1/(100 T), T the duration of the longest record.
    let seconds = campaign.iter().filter_map(|r| Some(r.data.u.len() as f64 / rate(r)?)).fold(0.0, f64::max);
    let lowest_frequency_hz = (seconds > 0.0).then(|| 0.01 / seconds);
    let options = RealiseOptions { lowest_frequency_hz, ..RealiseOptions::default() };
    let mut costs = side_by_side(&fitted, sample_rate_hz, &options, drive, ROUNDS, now).into_iter();
    let drives: Vec<TimedDrive<'_>> =
        campaign.iter().map(|r| (r.data.u.as_slice(), Timing::from(&r.data.time))).collect();
    models
        .into_iter()
        .map(|model| {
            let Some(model) = model else { return CandidateCost::default() };
            let (cost, why_not) = match costs.next() {
                Some(Ok(cost)) => (Some(cost), None),
                Some(Err(error)) => (None, Some(error.to_string())),
                None => (None, None),
            };
            CandidateCost { cost, why_not, inverse: model.hysteresis.invertibility(&drives).ok() }
        })
        .collect()
}

/// A comparison in numbers, for JSON. Errors are in the unit of the output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparisonSummary {
    /// Names of the records.
    pub records: Vec<String>,
    /// Unit of the output.
    pub output_unit: String,
    /// Preferred candidate: the one with the fewest parameters that is as good as the best.
    pub preferred: Option<String>,
    /// Candidate with the smallest held-out error.
    pub best: Option<String>,
    /// Noise floor of the records.
    pub noise_floor: f64,
    /// Samples that were scored.
    pub samples: usize,
    /// Effective number of independent samples.
    pub independent_samples: f64,
    /// Folds of the cross-validation.
    pub folds: Vec<FoldSummary>,
    /// Candidates in the order of the ranking.
    pub candidates: Vec<CandidateSummary>,
    /// Black-box models on the same folds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub baselines: Vec<BaselineSummary>,
    /// The verdict in sentences.
    pub notes: Vec<String>,
    /// The comparison was stopped.
    pub interrupted: bool,
    /// The time given was over before the comparison was complete.
    #[serde(default)]
    pub out_of_time: bool,
}

/// A cross-validation fold: held-out samples that are scored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoldSummary {
    /// Its name.
    pub left_out: String,
    /// Amplitudes and frequencies in it.
    pub content: String,
    /// It consists of whole records.
    pub whole_records: bool,
}

/// A candidate of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CandidateSummary {
    /// Its name.
    pub name: String,
    /// Number of estimated parameters.
    pub parameters: usize,
    /// Rms error on what was left out.
    pub error: Option<f64>,
    /// Standard error of it.
    pub error_std_error: Option<f64>,
    /// Error above that of the best candidate.
    pub above_best: Option<f64>,
    /// Standard error of it.
    pub above_best_std_error: Option<f64>,
    /// Within one standard error of the best.
    pub as_good_as_best: Option<bool>,
    /// Rms error on what it was trained on.
    pub training_rmse: Option<f64>,
    /// Akaike's information criterion.
    pub aic: Option<f64>,
    /// Bayesian information criterion.
    pub bic: Option<f64>,
    /// Nanoseconds a sample on the machine that compared.
    pub nanoseconds_per_sample: Option<f64>,
    /// Linear states of its realisation.
    pub states: Option<usize>,
    /// Why it has none.
    pub not_realised_because: Option<String>,
    /// Invertibility of its hysteresis.
    pub invertible: Option<String>,
    /// Rms error of each fold.
    pub fold_errors: Vec<Option<f64>>,
    /// Fits that failed, with the reason.
    pub failures: Vec<String>,
    /// Its folds were omitted: already with all records in its fit, its error was more than 1.2 times the
    /// smallest held-out error.
    #[serde(default)]
    pub hopeless: bool,
}

impl CandidateSummary {
    /// A candidate with its rank and its cost, where they are known.
    pub(crate) fn new(entry: &Entry, standing: Option<Standing>, costs: Option<&CandidateCost>) -> Self {
        Self {
            name: entry.candidate.to_string(),
            parameters: entry.parameters,
            error: standing.map(|s| s.mean),
            error_std_error: standing.map(|s| s.std_error),
            above_best: standing.map(|s| s.difference),
            above_best_std_error: standing.map(|s| s.difference_std_error),
            as_good_as_best: standing.map(|s| s.as_good_as_best),
            training_rmse: entry.training_rmse,
            aic: entry.aic,
            bic: entry.bic,
            nanoseconds_per_sample: costs.and_then(|c| c.cost).map(|c| c.nanoseconds),
            states: costs.and_then(|c| c.cost).map(|c| c.states),
            not_realised_because: costs.and_then(|c| c.why_not.clone()),
            invertible: costs.and_then(|c| c.inverse).map(|found| found.word().to_owned()),
            fold_errors: entry.fold_rmse.clone(),
            failures: entry.failures.clone(),
            hopeless: entry.is_hopeless,
        }
    }
}

/// A black-box model of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaselineSummary {
    /// Its name.
    pub name: String,
    /// Number of parameters.
    pub parameters: Option<usize>,
    /// Time between two lags \[s\].
    pub lag_interval_s: Option<f64>,
    /// Lags of the output.
    pub output_lags: Option<usize>,
    /// Lags of the input.
    pub input_lags: Option<usize>,
    /// Rms error on what was left out.
    pub error: Option<f64>,
    /// Standard error of it.
    pub error_std_error: Option<f64>,
    /// Rms error on what it was trained on.
    pub training_rmse: Option<f64>,
    /// Rms error of each fold.
    pub fold_errors: Vec<Option<f64>>,
    /// Fits that failed, with the reason.
    pub failures: Vec<String>,
    /// Time that it took \[s\].
    pub seconds: Option<f64>,
}

impl BaselineSummary {
    fn new(entry: &CrossValidated) -> Self {
        let model = entry.model.as_ref();
        let lags = model.map(|m| m.regressors.lags);
        Self {
            name: entry.kind.name().to_owned(),
            parameters: model.map(Trained::parameters),
            lag_interval_s: model.map(|m| m.units.interval_s),
            output_lags: lags.map(|l| l.output),
            input_lags: lags.map(|l| l.input),
            error: entry.error().map(|e| e.0),
            error_std_error: entry.error().map(|e| e.1),
            training_rmse: entry.training_rmse,
            fold_errors: entry.fold_rmse.clone(),
            failures: entry.failures.clone(),
            seconds: entry.seconds,
        }
    }
}

impl Serialize for Compared {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.summary().serialize(serializer)
    }
}

impl Compared {
    /// The comparison in numbers.
    pub fn summary(&self) -> ComparisonSummary {
        let comparison = &self.comparison;
        let name = |i: usize| comparison.entries[i].candidate.to_string();
        let candidate =
            |i: usize| CandidateSummary::new(&comparison.entries[i], self.standing(i), self.costs.get(i));
        let fold = |f: &Fold| FoldSummary {
            left_out: f.label.clone(),
            content: f.content.clone(),
            whole_records: f.whole,
        };
        ComparisonSummary {
            records: self.records.clone(),
            output_unit: self.unit.clone(),
            preferred: comparison.ranking.as_ref().map(|r| name(r.preferred)),
            best: comparison.ranking.as_ref().map(|r| name(r.best)),
            noise_floor: comparison.noise_floor,
            samples: comparison.samples,
            independent_samples: comparison.independent_samples,
            folds: comparison.folds.iter().map(fold).collect(),
            candidates: self.order().into_iter().map(candidate).collect(),
            baselines: self.baselines.iter().map(BaselineSummary::new).collect(),
            notes: self.verdict(),
            interrupted: comparison.interrupted,
            out_of_time: comparison.out_of_time,
        }
    }
}
