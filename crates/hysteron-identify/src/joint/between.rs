//! Choice of the rule of the drive between samples, where the records tell.

use super::super::engine::Engine;
use super::super::options::{Choice, Options};
use super::super::result::Parameter;
use super::super::{Finding, FindingKind, IdentifyError, RecordFacts};
use super::normalised::quick_fit;
use super::parameter_layout::DELAY;
use super::problem::JointProblem;
use super::setup::JointSetup;
use crate::findings::say;
use hysteron_model::dynamics::Scheme;
use hysteron_model::record::InterSample;
use hysteron_numeric::display::short_to;
use hysteron_optimize::LeastSquaresProblem;

/// Fewest samples a cycle of the fastest drive for which the rules are one: (ω Δt)²/12 is 3e-4 of the drive
/// there.
const FINE: f64 = 100.0;
/// Twice the logarithm of a likelihood ratio from which on the evidence is very strong (Kass and Raftery
/// 1995, doi:10.1080/01621459.1995.10476572).
const VERY_STRONG: f64 = 10.0;

/// Largest excess of the delay if the drive is held between its samples and the fit takes straight lines, in
/// samples: half a sample, and what the corners of the staircase add (1 to 2 % of a sample from 50 samples a
/// cycle on, `hysteron-study rates`).
const EXCESS_IF_HELD: f64 = 0.53;

/// Choice of the rule between samples.
#[derive(Clone, Debug, PartialEq)]
pub struct InterSampleChoice {
    /// The rule taken.
    pub rule: InterSample,
    /// 2 ln of the likelihood ratio of the closest rule over each of the others, over the independent
    /// samples.
    pub over: Vec<(InterSample, f64)>,
    /// The closest rule, which is taken where the evidence is very strong.
    pub closest: InterSample,
}

impl InterSampleChoice {
    /// Evidence over the next best rule.
    pub fn evidence(&self) -> f64 {
        self.over.iter().map(|(_, evidence)| *evidence).fold(f64::INFINITY, f64::min)
    }

    /// Whether the records tell.
    pub fn is_told(&self) -> bool {
        self.evidence() > VERY_STRONG
    }

    /// Whether the records exclude this rule.
    fn excludes(&self, rule: InterSample) -> bool {
        self.over.iter().any(|&(other, evidence)| other == rule && evidence > VERY_STRONG)
    }

    /// Adds the finding on the rule chosen and the evidence for it.
    pub(in super::super) fn say(&self, findings: &mut Vec<Finding>) {
        let others: Vec<String> = self
            .over
            .iter()
            .map(|(rule, evidence)| format!("{} over {rule}", short_to(*evidence, 2)))
            .collect();
        let evidence = format!(
            "2 ln of the likelihood ratio of {}: {}; 10 is very strong",
            self.closest,
            others.join(", ")
        );
        if self.is_told() {
            let text =
                format!("Between its samples the drive is {}, as the records tell ({evidence}).", self.rule);
            say(findings, FindingKind::Verdict, "between samples", text);
        } else {
            let text = format!(
                "The records do not tell what the drive does between its samples ({evidence}): {} is \
                 assumed. A delay depends on it by up to half a sample{}.",
                self.rule,
                if self.excludes(InterSample::Hold) { "" } else { ", which its interval covers" }
            );
            say(findings, FindingKind::Advice, "between samples", text);
        }
    }
}

/// Sampling interval of the fastest record \[s\], where a held drive is not excluded: by the options, which
/// give the rule, by the records, which determine it or have non-uniform stamps, or by the scheme, which uses
/// the samples alone.
pub(in super::super) fn interval_if_held(
    facts: &[RecordFacts],
    options: &Options,
    choice: Option<&InterSampleChoice>,
    scheme: Scheme,
) -> Option<f64> {
    let is_open = options.inter_sample == Choice::Auto
        && scheme == Scheme::BandLimited
        && choice.is_none_or(|choice| !choice.excludes(InterSample::Hold));
    let rates = facts.iter().map(|f| f.data.sample_rate_hz()).collect::<Option<Vec<f64>>>()?;
    let interval_s = 1.0 / rates.into_iter().fold(0.0, f64::max);
    (is_open && interval_s.is_finite()).then_some(interval_s)
}

/// Extends the interval of the delay to that under a held drive.
pub(super) fn admit_held_drive(parameters: &mut [Parameter], interval_s: f64) {
    let delay = parameters.iter_mut().find(|p| p.name == DELAY);
    if let Some(interval) = delay.and_then(|p| p.interval.as_mut()) {
        interval.low = (interval.low - EXCESS_IF_HELD * interval_s).max(interval.low.min(0.0));
    }
}

/// A fit under one of the other rules.
pub(super) struct Better {
    /// Its options' place.
    pub(super) index: usize,
    pub(super) problem: JointProblem,
    pub(super) x: Vec<f64>,
    pub(super) cost: f64,
}

/// The options under the other rules; none where the rule is given, or the records cannot tell because they
/// are sampled finely or on uneven stamps.
pub(super) fn others(setup: &JointSetup<'_>, options: &Options) -> Vec<Options> {
    if options.inter_sample != Choice::Auto || !setup.samples_coarsely(FINE) {
        return Vec::new();
    }
    let own = options.inter_sample();
    let other = |rule: InterSample| Options { inter_sample: Choice::Given(rule), ..options.clone() };
    InterSample::ALL.into_iter().filter(|rule| *rule != own).map(other).collect()
}

/// The fit `x` of the whole records compared with those under the `others`, each from there: what the records
/// tell, and the better fit. `independent`: samples that the residuals are worth. `None` where the fit was
/// stopped.
pub(super) fn compared<'a>(
    setup: &JointSetup<'a>,
    others: &'a [Options],
    (problem, x, cost): (&JointProblem, &[f64], f64),
    (degree, independent): (usize, f64),
    engine: &mut Engine<'_, '_>,
) -> Result<Option<(InterSampleChoice, Option<Better>)>, IdentifyError> {
    if others.is_empty() || problem.residual_count() == 0 {
        return Ok(None);
    }
    let own = setup.options().inter_sample();
    let mut costs = vec![(own, cost)];
    let mut best: Option<Better> = None;
    for (index, options) in others.iter().enumerate() {
        let rule = options.inter_sample();
        let problem = setup.anew(options).problem(degree, false)?;
        let fit = quick_fit(engine, &format!("between samples: {rule}"), &problem, vec![x.to_vec()]);
        let Some(fit) = engine.unless_stopped(fit)?.filter(|_| !engine.is_stopped()) else { return Ok(None) };
        costs.push((rule, fit.outcome.cost));
        if fit.outcome.cost < best.as_ref().map_or(cost, |best| best.cost) {
            best = Some(Better { index, problem, x: fit.outcome.best, cost: fit.outcome.cost });
        }
    }
    let least = costs.iter().map(|(_, cost)| *cost).fold(f64::INFINITY, f64::min);
    let closest = costs.iter().find(|(_, cost)| *cost == least).map_or(own, |(rule, _)| *rule);
    let evidence = |cost: f64| 2.0 * independent * (cost / least).ln();
    let over = costs.iter().filter(|(rule, _)| *rule != closest).map(|&(rule, cost)| (rule, evidence(cost)));
    let mut choice = InterSampleChoice { rule: own, over: over.collect(), closest };
    if !choice.is_told() {
        return Ok(Some((choice, None)));
    }
    choice.rule = closest;
    Ok(Some((choice, best)))
}
