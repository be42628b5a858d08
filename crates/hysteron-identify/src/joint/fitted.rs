//! The optimum of a joint fit on all samples, from the best point of its search.

use super::super::engine::{Engine, Search};
use super::super::options::Options;
use super::super::result::Reduction;
use super::super::{DegreeTried, IdentifyError};
use super::between::{self, InterSampleChoice};
use super::campaign::Rate;
use super::model::shown;
use super::normalised::{local_fits, resolved_fit};
use super::parameter_layout::DELAY;
use super::problem::JointProblem;
use super::resolution::{BEFORE_ALL, FINAL, information, resolution, resolved};
use super::search::Optimum;
use super::setup::JointSetup;
use hysteron_optimize::Problem;

pub(super) const REDUCED: &str = "reduced records";
pub(super) const ALL_SAMPLES: &str = "all samples";

/// The optimum of a joint fit.
pub(super) struct FittedOptimum<'a> {
    pub(super) setup: JointSetup<'a>,
    /// Problem of all samples; that of the search where a stop left no fit of them.
    pub(super) problem: JointProblem,
    pub(super) x: Vec<f64>,
    /// Problem of the thinned records, and its optimum.
    pub(super) thinned: Option<(JointProblem, Vec<f64>)>,
    pub(super) search: Search,
    pub(super) degree: usize,
    /// Degrees tried, with cost and BIC.
    pub(super) degrees: Vec<DegreeTried>,
    /// Choice of the inter-sample rule, where the records discriminate.
    pub(super) between: Option<InterSampleChoice>,
    pub(super) reduction: Option<Reduction>,
}

impl<'a> FittedOptimum<'a> {
    /// Fits all samples from the optimum of a search on `reduced` records, also under the inter-sample rules
    /// of `others`.
    pub(super) fn on_all_samples(
        optimum: Optimum<'a>,
        reduced: bool,
        others: &'a [Options],
        engine: &mut Engine<'_, '_>,
    ) -> Result<Self, IdentifyError> {
        let Optimum { mut setup, problem, mut search, degree, best, degrees } = optimum;
        let searched = if reduced { Rate::Reduced } else { Rate::Own };
        let best = if reduced { finely(&setup, (degree, best), engine)? } else { best };
        // A stop leaves no time for a problem that nobody asks anymore.
        let mut thinned = if reduced && !engine.is_stopped() {
            Some((setup.problem(degree, Rate::Reduced)?, best.clone()))
        } else {
            None
        };
        let Some((mut whole, mut x, mut cost)) = polished(&setup, (degree, best), searched, engine)? else {
            let (x, degree) = (search.outcome.best.clone(), problem.degree());
            let (between, reduction) = (None, None);
            return Ok(Self { setup, problem, x, thinned, search, degree, degrees, between, reduction });
        };
        let independent = information(&whole, &x);
        let own = (&whole, &x[..], cost);
        let (between, better) =
            between::compared(&setup, others, own, (degree, independent), engine)?.unzip();
        if let Some(better) = better.flatten() {
            setup = setup.anew(&others[better.index]);
            if reduced {
                let before = thinned.take().map_or_else(Vec::new, |(_, x)| x);
                if let Some(problem) = engine.unless_stopped(setup.problem(degree, Rate::Reduced))? {
                    let fit = resolved_fit(engine, ALL_SAMPLES, &problem, vec![better.x.clone()], None);
                    let fit = engine.unless_stopped(fit)?.map(|fit| fit.outcome.best);
                    thinned = Some((problem, fit.unwrap_or(before)));
                }
            }
            (whole, x, cost) = (better.problem, better.x, better.cost);
            let options = resolved(FINAL * resolution(&whole, &x));
            let fit = local_fits(engine, ALL_SAMPLES, &whole, vec![x.clone()], options, None);
            if let Some(fit) = engine.unless_stopped(fit)? {
                (x, cost) = (fit.outcome.best, fit.outcome.cost);
            }
        }
        (search.outcome.cost, search.outcome.best) = (cost, x.clone());
        let samples = setup.members.iter().map(|member| member.facts.data.len()).sum();
        let reduction = thinned.as_ref().map(|(thinned, _)| {
            let fitted = if setup.is_thinned() { whole.valid() } else { samples };
            Reduction { samples, searched: thinned.valid(), fitted, moved: 0.0 }
        });
        Ok(Self { setup, problem: whole, x, thinned, search, degree, degrees, between, reduction })
    }

    /// This optimum with the delay, 0, freed under the options `asked`: slow drive does not determine it, so
    /// that the model has none, but the standard errors allow for it. A stop from here on leaves this point.
    pub(super) fn with_free_delay(self, asked: &'a Options) -> Result<Self, IdentifyError> {
        let setup = self.setup.with(self.setup.form, asked);
        let freed = |rate: Rate, x: &[f64]| -> Result<(JointProblem, Vec<f64>), IdentifyError> {
            let problem = setup.problem(self.degree, rate)?;
            let place = problem.bounds().ranges.iter().position(|range| range.name == DELAY);
            let mut x = x.to_vec();
            x.insert(place.map_or(x.len(), |place| place.min(x.len())), 0.0);
            Ok((problem, x))
        };
        let (problem, x) = freed(Rate::Own, &self.x)?;
        if !problem.cost(&x, &mut problem.workspace()).is_finite() {
            return Ok(self);
        }
        let thinned = self.thinned.as_ref().map(|(_, x)| freed(Rate::Reduced, x)).transpose()?;
        Ok(Self { setup, problem, x, thinned, ..self })
    }
}

/// The optimum of the reduced records near `best`, more closely than that of all samples is found from it: a step
/// there costs several times more.
fn finely(
    setup: &JointSetup<'_>,
    (degree, best): (usize, Vec<f64>),
    engine: &mut Engine<'_, '_>,
) -> Result<Vec<f64>, IdentifyError> {
    if engine.is_stopped() {
        return Ok(best);
    }
    let problem = setup.problem(degree, Rate::Reduced)?;
    let options = resolved(BEFORE_ALL * resolution(&problem, &best));
    let fit = local_fits(engine, REDUCED, &problem, vec![best.clone()], options, None);
    Ok(engine.unless_stopped(fit)?.map_or(best, |fit| fit.outcome.best))
}

/// The problem of all samples, its optimum from the `best` point of the search, and the cost there; `None`
/// where a stop left none.
fn polished(
    setup: &JointSetup<'_>,
    (degree, best): (usize, Vec<f64>),
    searched: Rate,
    engine: &mut Engine<'_, '_>,
) -> Result<Option<(JointProblem, Vec<f64>, f64)>, IdentifyError> {
    if engine.is_stopped() {
        return Ok(None);
    }
    let Some(whole) = engine.unless_stopped(setup.problem(degree, Rate::Own))? else { return Ok(None) };
    // From reduced records the start is within 0.1 standard errors but for what they lack.
    let share = if searched == Rate::Own { FINAL } else { 1.0 };
    let before = setup.problem(degree, searched)?;
    let options = resolved(share * resolution(&before, &best));
    before.hand_outputs_to(&whole);
    let grown = |x: &[f64]| shown(&whole, x, setup);
    let polished = local_fits(engine, ALL_SAMPLES, &whole, vec![best], options, Some(&grown));
    let polished = engine.unless_stopped(polished)?.map(|search| search.outcome);
    Ok(polished.filter(|end| end.cost.is_finite()).map(|end| (whole, end.best, end.cost)))
}
