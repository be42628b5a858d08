//! Choice of the inter-sample rule of the drive, where the records discriminate.

use super::super::engine::Engine;
use super::super::options::{Choice, Options, RecordRole};
use super::super::parameter::ParameterRole;
use super::super::result::{Identification, RecordFit};
use super::super::{Finding, FindingKind, IdentifyError};
use super::campaign::Rate;
use super::normalised::resolved_fit;
use super::problem::JointProblem;
use super::setup::JointSetup;
use crate::findings::say;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::record::InterSample;
use hysteron_numeric::display::short_to;
use hysteron_optimize::LeastSquaresProblem;

/// Samples per cycle of the fastest drive from which on the rules are equivalent: (ω Δt)²/12 is 3e-4 of the
/// drive.
const FINE: f64 = 100.0;
/// Twice the logarithm of a likelihood ratio from which on the evidence is very strong (Kass and Raftery
/// 1995, doi:10.1080/01621459.1995.10476572).
const VERY_STRONG: f64 = 10.0;

/// Largest excess of the delay if the drive is held between its samples and the fit takes straight lines, in
/// samples: with dynamics half a sample, and what the corners of the staircase add (1 to 2 % of a sample from
/// 50 samples a cycle on, `hysteron-study rates`); without, a held drive is read at the sample before.
const EXCESS_IF_HELD: f64 = 0.53;
const EXCESS_IF_HELD_STATIC: f64 = 1.0;

/// Choice of the inter-sample rule.
#[derive(Clone, Debug, PartialEq)]
pub struct InterSampleChoice {
    /// The rule taken.
    pub rule: InterSample,
    /// 2 ln of the likelihood ratio of the best-fitting rule to each of the others, for the independent
    /// samples.
    pub over: Vec<(InterSample, f64)>,
    /// The best-fitting rule, chosen where the evidence is very strong.
    pub closest: InterSample,
}

impl InterSampleChoice {
    /// Evidence over the next best rule.
    pub fn evidence(&self) -> f64 {
        self.over.iter().map(|(_, evidence)| *evidence).fold(f64::INFINITY, f64::min)
    }

    /// True if the records discriminate between the rules.
    pub fn is_told(&self) -> bool {
        self.evidence() > VERY_STRONG
    }

    /// Whether the records exclude this rule.
    fn excludes(&self, rule: InterSample) -> bool {
        self.over.iter().any(|&(other, evidence)| other == rule && evidence > VERY_STRONG)
    }

    /// Adds the finding on the rule chosen and the evidence for it. `excess_s`: that of [`excess_if_held`].
    pub(in super::super) fn say(&self, findings: &mut Vec<Finding>, excess_s: Option<f64>) {
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
            let text = format!(
                "Between its samples the drive is {}, as determined by the records ({evidence}).",
                self.rule
            );
            say(findings, FindingKind::Verdict, "between samples", text);
        } else {
            let text = format!(
                "The records do not determine the inter-sample behaviour of the drive ({evidence}): {} is \
                 assumed. A delay depends on it by up to half a sample{}.",
                self.rule,
                if excess_s.is_some() { ", which its interval covers" } else { "" }
            );
            say(findings, FindingKind::Advice, "between samples", text);
        }
    }
}

/// Largest excess of the delay \[s\] if the drive is held between its samples. `None` where that is excluded:
/// by the options, which give the rule, by the records, which determine it or have non-uniform stamps, or by
/// the scheme, which uses the samples alone; and where the delay has no interval.
pub(in super::super) fn excess_if_held(options: &Options, found: &Identification) -> Option<f64> {
    let choice = found.structure.between.as_ref();
    let is_open = options.inter_sample == Choice::Auto
        && found.model.scheme == Scheme::BandLimited
        && choice.is_none_or(|choice| !choice.excludes(InterSample::Hold));
    found.parameters.iter().find(|p| p.role == ParameterRole::Delay)?.interval.filter(|_| is_open)?;
    let is_dynamic = |fit: &&RecordFit| fit.role == RecordRole::Dynamic;
    let any = found.records.iter().any(|fit| is_dynamic(&fit));
    let showing = found.records.iter().filter(|fit| is_dynamic(fit) || !any);
    let rates = showing.map(|fit| fit.data.sample_rate_hz()).collect::<Option<Vec<f64>>>()?;
    let samples = if found.model.dynamics == Dynamics::None { EXCESS_IF_HELD_STATIC } else { EXCESS_IF_HELD };
    let slowest_hz = rates.into_iter().fold(f64::INFINITY, f64::min);
    Some(samples / slowest_hz)
}

/// Extends the interval of the delay to that under a held drive.
pub(super) fn admit_held_drive(options: &Options, found: &mut Identification) {
    let Some(excess_s) = excess_if_held(options, found) else { return };
    let delay = found.parameters.iter_mut().find(|p| p.role == ParameterRole::Delay);
    if let Some(interval) = delay.and_then(|p| p.interval.as_mut()) {
        interval.low = (interval.low - excess_s).max(interval.low.min(0.0));
    }
}

/// A fit under one of the other rules.
pub(super) struct Better {
    /// Index of its options.
    pub(super) index: usize,
    pub(super) problem: JointProblem,
    pub(super) x: Vec<f64>,
    pub(super) cost: f64,
}

/// The options under the other rules; none where the rule is given, or the records cannot discriminate
/// because of fine or non-uniform sampling.
pub(super) fn others(setup: &JointSetup<'_>, options: &Options) -> Vec<Options> {
    if options.inter_sample != Choice::Auto || !setup.samples_coarsely(FINE) {
        return Vec::new();
    }
    let own = options.inter_sample();
    let other = |rule: InterSample| Options { inter_sample: Choice::Given(rule), ..options.clone() };
    InterSample::ALL.into_iter().filter(|rule| *rule != own).map(other).collect()
}

/// Compares the fit `x` of the whole records with fits under the `others`, each started from `x`: the choice,
/// and the better fit. `independent`: effective number of samples of the residuals. `None` where the fit was
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
        let problem = setup.anew(options).problem(degree, Rate::Own);
        let Some(problem) = engine.unless_stopped(problem)? else { return Ok(None) };
        let fit = resolved_fit(engine, &format!("between samples: {rule}"), &problem, vec![x.to_vec()], None);
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
