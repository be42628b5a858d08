//! Eq. 13, Table 3 and Figures 8–11: the article's models, identified from the loop and the sweep, scored on
//! held-out sines.

use super::measurements::Measurements;
use super::printed::TransferFunction13;
use super::progress::{Stage, Stages};
use super::static_block::{StaticStudy, article_options, rmse};
use super::{ArticleError, Plan};
use hysteron_identify::{
    CampaignRecord, Choice, Demands, DynamicsChoice, Event, Identification, IdentifyError, Method, Options,
    RecordRole, Searches, Watch,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::record::InputOutput;
use hysteron_model::validate::{OffsetTreatment, Scoring, score};
use serde::{Deserialize, Serialize};

/// A model of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ModelKind {
    /// Bouc–Wen with a linear input function, no dynamics; DE-ABC.
    Classic,
    /// Integer-order Hammerstein, orders 2, 1, 0; DE-ABC.
    Integer,
    /// ARX Hammerstein; linear least squares, orders by simulated error.
    Arx,
    /// Fractional Hammerstein, Eq. 13; DE-ABC.
    Fractional,
    /// Not in the article: the improved (quadratic) Bouc–Wen without dynamics; DE-ABC.
    ImprovedStatic,
    /// Not in the article: as `Integer`, by least squares.
    IntegerLeastSquares,
    /// Not in the article: as `Fractional`, by least squares.
    FractionalLeastSquares,
    /// Not in the article: this program's default, with degree, delay and offsets from the data.
    Default,
}

impl ModelKind {
    /// All of them, the article's four first.
    pub const ALL: [Self; 8] = [
        Self::Classic,
        Self::Integer,
        Self::Arx,
        Self::Fractional,
        Self::ImprovedStatic,
        Self::IntegerLeastSquares,
        Self::FractionalLeastSquares,
        Self::Default,
    ];

    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Classic => "classic Bouc–Wen",
            Self::Integer => "integer order",
            Self::Arx => "ARX",
            Self::Fractional => "fractional order",
            Self::ImprovedStatic => "improved Bouc–Wen, no dynamics",
            Self::IntegerLeastSquares => "integer order, least squares",
            Self::FractionalLeastSquares => "fractional order, least squares",
            Self::Default => "hysteron identify, no option",
        }
    }

    /// True for a model of the article.
    pub fn is_the_articles(self) -> bool {
        matches!(self, Self::Classic | Self::Integer | Self::Arx | Self::Fractional)
    }

    fn options(self, plan: &Plan) -> Options {
        let article = article_options(plan);
        let by_least_squares = Options { algorithm: None, ..article.clone() };
        match self {
            Self::Classic => Options { degree: Choice::Given(1), dynamics: DynamicsChoice::None, ..article },
            Self::ImprovedStatic => Options { dynamics: DynamicsChoice::None, ..article },
            Self::Integer => Options { dynamics: DynamicsChoice::Integer, ..article },
            Self::Arx => Options { dynamics: DynamicsChoice::Arx, ..article },
            Self::Fractional => article,
            Self::IntegerLeastSquares => Options { dynamics: DynamicsChoice::Integer, ..by_least_squares },
            Self::FractionalLeastSquares => by_least_squares,
            Self::Default => Options {
                method: Method::Joint,
                degree: Choice::Auto,
                delay_s: Choice::Auto,
                demands: Demands::default(),
                ..by_least_squares
            },
        }
    }

    /// Share of a DE-ABC stage done when this model begins; least squares runs last.
    fn stage(self) -> (Stage, f64, f64) {
        match self {
            Self::ImprovedStatic => (Stage::Colony, 0.0, 0.03),
            Self::Classic => (Stage::Colony, 0.03, 0.03),
            Self::Fractional => (Stage::Colony, 0.06, 0.47),
            Self::Integer => (Stage::Colony, 0.53, 0.47),
            Self::Arx => (Stage::LeastSquares, 0.0, 0.1),
            Self::IntegerLeastSquares => (Stage::LeastSquares, 0.1, 0.2),
            Self::FractionalLeastSquares => (Stage::LeastSquares, 0.3, 0.3),
            Self::Default => (Stage::LeastSquares, 0.6, 0.4),
        }
    }
}

/// A transfer function in the form of Eq. 13, b / (s^α₂ + c₁ s^α₁ + c₀).
pub type Eq13 = TransferFunction13;

/// An identified model and its errors.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelFit {
    /// Which model.
    pub kind: ModelKind,
    /// Its dynamics in the form of Eq. 13, where it has that form.
    pub eq13: Option<Eq13>,
    /// Polynomial degree of the static block.
    pub degree: usize,
    /// Delay \[s\].
    pub delay_s: f64,
    /// Parameters that ended at a bound of their search box: the optimum lies outside it.
    pub at_bounds: Vec<String>,
    /// Evaluations of all its searches.
    pub evaluations: usize,
    /// RMSE on the records it was identified from \[µm\]: name and value.
    pub fitted_rmse_um: Vec<(String, f64)>,
    /// Errors on the sines, in the order of Table 3.
    pub scores: Vec<SineScore>,
}

/// Errors of a model on one sine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SineScore {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Largest |error| \[µm\].
    pub max_um: f64,
    /// RMSE \[µm\].
    pub rmse_um: f64,
    /// RMSE, % of stroke.
    pub rmse_percent: f64,
    /// RMSE with the mean error removed (a sensor offset estimated for this record) \[µm\].
    pub rmse_own_offset_um: f64,
}

/// The last two periods of a sine: Figures 8–11.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SineCurves {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// Time from the record's start \[s\].
    pub time_s: Vec<f64>,
    /// Drive \[V\].
    pub u_v: Vec<f64>,
    /// Measured displacement \[µm\].
    pub measured_um: Vec<f64>,
    /// Simulated displacement of each model \[µm\].
    pub simulated_um: Vec<(ModelKind, Vec<f64>)>,
}

/// Eq. 13, Table 3 and Figures 8–11.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelStudy {
    /// The models in the order of [`ModelKind::ALL`].
    pub models: Vec<ModelFit>,
    /// Curves at each frequency of Table 3.
    pub curves: Vec<SineCurves>,
}

impl ModelStudy {
    /// A model.
    pub fn model(&self, kind: ModelKind) -> Option<&ModelFit> {
        self.models.iter().find(|m| m.kind == kind)
    }

    /// Errors of a model at a frequency.
    pub fn score(&self, kind: ModelKind, frequency_hz: f64) -> Option<&SineScore> {
        self.model(kind)?.scores.iter().find(|s| s.frequency_hz == frequency_hz)
    }
}

/// Identifies every model and scores it.
pub(super) fn identify(
    plan: &Plan,
    bench: &Measurements,
    stages: &Stages<'_, '_>,
) -> Result<(StaticStudy, ModelStudy), ArticleError> {
    let loop_only = [campaign_record(&bench.loop_1hz, RecordRole::QuasiStatic)];
    let both = [loop_only[0].clone(), campaign_record(&bench.sweep, RecordRole::Dynamic)];
    let run = |kind: ModelKind, resume: Option<Searches>| -> Result<Identification, ArticleError> {
        let (stage, from, width) = kind.stage();
        let told = |event: &Event<'_>| stages.at(stage, from + width * event.fraction, kind.name());
        let watch = Watch::new(told).stopped_by(stages.stop());
        let options = kind.options(plan);
        let records: &[CampaignRecord] =
            if options.dynamics == DynamicsChoice::None { &loop_only } else { &both };
        let found = hysteron_identify::identify(records, &options, &watch, resume);
        if watch.is_stopped() {
            return Err(ArticleError::Stopped);
        }
        found.map_err(|source: IdentifyError| ArticleError::Identify {
            model: kind.name().into(),
            source: source.into(),
        })
    };
    // Step 1 is the same for every model of the article but the classic one: it is searched once.
    let improved = run(ModelKind::ImprovedStatic, None)?;
    let step1 = Some(improved.resume.clone());
    let classic = run(ModelKind::Classic, None)?;
    let fractional = run(ModelKind::Fractional, step1.clone())?;
    let integer = run(ModelKind::Integer, step1.clone())?;
    let arx = run(ModelKind::Arx, step1)?;
    let integer_ls = run(ModelKind::IntegerLeastSquares, None)?;
    let fractional_ls = run(ModelKind::FractionalLeastSquares, None)?;
    let default = run(ModelKind::Default, None)?;
    let static_block = StaticStudy::of(&improved).ok_or(ArticleError::Stopped)?;
    let found = [classic, integer, arx, fractional, improved, integer_ls, fractional_ls, default];

    let mut curves: Vec<SineCurves> =
        bench.table3().map(|(f, record)| SineCurves::measured(*f, record)).collect();
    let mut models = Vec::new();
    for (kind, found) in ModelKind::ALL.into_iter().zip(&found) {
        models.push(ModelFit::of(kind, found, bench, &mut curves)?);
    }
    Ok((static_block, ModelStudy { models, curves }))
}

fn campaign_record(data: &InputOutput, role: RecordRole) -> CampaignRecord {
    CampaignRecord { data: data.clone(), role: Some(role) }
}

impl ModelFit {
    fn of(
        kind: ModelKind,
        found: &Identification,
        bench: &Measurements,
        curves: &mut [SineCurves],
    ) -> Result<Self, ArticleError> {
        let Model { hysteresis, dynamics, delay_s, .. } = &found.model;
        let mut scores = Vec::new();
        for ((frequency_hz, record), curves) in bench.table3().zip(curves) {
            let first = record.u.first().copied().unwrap_or(0.0);
            // Every record of the bench has the same initial state: the memory estimated for the first
            // applies to all.
            let start = match found.records.first().map(|fit| fit.start) {
                Some(start @ Start::Remembering { voltage_v, .. }) if voltage_v == first => start,
                _ => Start::Rest { voltage_v: first },
            };
            let simulated = found.model.simulate_at_own_rate(&record.u, record.sample_rate_hz(), &start)?;
            let scored_with = |offset| score(record, &simulated, &Scoring { skip_s: None, offset });
            let scored = scored_with(OffsetTreatment::Fixed)?;
            scores.push(SineScore {
                frequency_hz: *frequency_hz,
                max_um: scored.max_abs_error,
                rmse_um: scored.rmse,
                rmse_percent: scored.rmse_percent_of_stroke.unwrap_or(f64::NAN),
                rmse_own_offset_um: scored_with(OffsetTreatment::Estimated)?.rmse,
            });
            let from = simulated.len() - curves.time_s.len();
            curves.simulated_um.push((kind, simulated[from..].to_vec()));
        }
        Ok(Self {
            kind,
            eq13: match dynamics {
                Dynamics::Fractional(g) | Dynamics::Integer(g) => eq13(g),
                Dynamics::None | Dynamics::Arx(_) => None,
            },
            degree: hysteresis.polynomial().len(),
            delay_s: *delay_s,
            at_bounds: at_bounds(found),
            evaluations: found.searches.iter().map(|s| s.outcome.evaluations).sum(),
            fitted_rmse_um: found
                .records
                .iter()
                .map(|r| (r.data.name.clone(), rmse(&r.data.y, &r.simulated)))
                .collect(),
            scores,
        })
    }
}

/// Fraction of a range within which a parameter counts as at its bound.
const AT_END: f64 = 1e-3;

fn at_bounds(found: &Identification) -> Vec<String> {
    let mut names = Vec::new();
    for (search, bounds) in found.searches.iter().zip(&found.bounds) {
        for (range, &x) in bounds.ranges.iter().zip(&search.outcome.best) {
            let place = range.to_unit(x);
            if place.min(1.0 - place) < AT_END {
                names.push(range.name.clone());
            }
        }
    }
    names
}

/// The numbers of a transfer function of the form of Eq. 13.
pub(super) fn eq13(g: &TransferFunction) -> Option<Eq13> {
    let ([b], [c0, c1, c2]) = (g.numerator.as_slice(), g.denominator.as_slice()) else { return None };
    let scale = c2.coefficient;
    Some(Eq13 {
        b: b.coefficient / scale,
        alpha2: c2.order,
        c1: c1.coefficient / scale,
        alpha1: c1.order,
        c0: c0.coefficient / scale,
    })
}

/// Periods of a sine that are kept for the figures.
const PERIODS_SHOWN: f64 = 2.0;

impl SineCurves {
    fn measured(frequency_hz: f64, record: &InputOutput) -> Self {
        let rate = record.sample_rate_hz().unwrap_or(f64::NAN);
        let samples = ((PERIODS_SHOWN * rate / frequency_hz).round() as usize).min(record.len());
        let from = record.len() - samples;
        Self {
            frequency_hz,
            time_s: (from..record.len()).map(|k| k as f64 / rate).collect(),
            u_v: record.u[from..].to_vec(),
            measured_um: record.y[from..].to_vec(),
            simulated_um: Vec::new(),
        }
    }
}
