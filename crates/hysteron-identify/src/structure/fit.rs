//! Fits of one candidate: to the whole campaign, and to the training data of a fold.

use super::super::engine::{Engine, rough};
use super::super::joint::{
    JointMember, JointProblem, JointSetup, Rate, assemble, fit_with_its_memory, form, local_fits,
    memory_name, nearer_with_its_memory, scheme,
};
use super::super::layout::Role;
use super::super::options::{CampaignRecord, Choice, Options};
use super::super::watch::Plan;
use super::super::{IdentifyError, RecordFacts, Watch, identify};
use super::candidate::Candidate;
use super::errors::left;
use super::folds::Fold;
use super::loose::without_what_is_loose;
use hysteron_model::Start;
use hysteron_model::dynamics::Dynamics;
use hysteron_model::hammerstein::Model;
use hysteron_optimize::{Algorithm, LeastSquaresOptions, OptimizeError, Problem, Settings, Stop};

/// Starts of rough fits to the whole campaign, and iterations of the best of these from there on; iterations
/// of a fit to the training data of a fold.
const POLISHED: usize = 3;
const ITERATIONS: usize = 30;
const FOLD_ITERATIONS: usize = 6;
/// Cost tolerance of these fits: structures differ by more.
const COST_TOLERANCE: f64 = 1e-4;
/// Rough fits agree if their costs are within this many times the lowest, and their starts at least this
/// share of a range apart.
const SAME: f64 = 1.005;
const APART: f64 = 0.05;
/// Named values of the searched parameters.
pub(super) type Named = Vec<(String, f64)>;

/// A candidate fitted to the whole campaign.
#[derive(Clone, Debug)]
pub(super) struct WholeFit {
    pub(super) model: Model,
    pub(super) starts: Vec<Start>,
    pub(super) parameters: usize,
    /// Values to start similar fits from; empty for a block that is identified in two steps.
    pub(super) named: Named,
}

/// A campaign ready for many fits.
pub(super) struct Campaign<'a> {
    pub(super) facts: &'a [RecordFacts],
    pub(super) members: &'a [JointMember<'a>],
    pub(super) options: &'a Options,
    /// Stops the current fit.
    pub(super) stop: &'a Stop,
}

/// A rough fit.
struct Rough {
    start: Vec<f64>,
    x: Vec<f64>,
    cost: f64,
}

impl Rough {
    /// True if this fit, from elsewhere, is as good as the `best`.
    fn agrees_with(&self, best: &Self, problem: &JointProblem) -> bool {
        let starts = self.start.iter().zip(&best.start);
        let mut apart = problem.bounds().ranges.iter().zip(starts);
        self.cost <= SAME * best.cost
            && apart.any(|(range, (a, b))| (range.to_unit(*a) - range.to_unit(*b)).abs() >= APART)
    }
}

/// Reason for a missing fit.
#[derive(Debug)]
pub(super) enum NoFit {
    /// It was asked to stop.
    Stopped,
    /// It failed, in words.
    Failed(String),
}

impl<E: Into<IdentifyError>> From<E> for NoFit {
    fn from(error: E) -> Self {
        Self::Failed(error.into().to_string())
    }
}

impl Campaign<'_> {
    /// Fits the whole campaign, from data-driven starts and from the fits of other candidates.
    pub(super) fn fit(&self, candidate: Candidate, others: &[&Named]) -> Result<WholeFit, NoFit> {
        let options = self.candidate_options(candidate, self.members);
        if candidate.block.takes_two_steps() {
            return self.fit_in_two_steps(&options);
        }
        let setup = JointSetup::new(self.members, form(&options), &options).stopped_by(self.stop);
        let problem = setup.problem(candidate.degree, Rate::Reduced)?;
        let coarse = setup.problem(candidate.degree, Rate::Coarse)?;
        let guesses = setup.guesses(&coarse)?;
        let base = guesses.first().cloned().unwrap_or_default();
        let mut starts: Vec<Vec<f64>> = others.iter().map(|named| overlay(&problem, &base, named)).collect();
        starts.extend(guesses);
        let mut ws = coarse.workspace();
        let mut ordered: Vec<(f64, Vec<f64>)> =
            starts.into_iter().map(|x| (coarse.cost(&x, &mut ws), x)).collect();
        ordered.sort_by(|a, b| a.0.total_cmp(&b.0));
        ordered.dedup_by(|a, b| a.1 == b.1);
        let starts = ordered.into_iter().take(POLISHED).map(|(_, x)| x).collect();
        let x = self.minimise((&problem, &coarse), starts)?;
        let (model, starts) = self.solved(&problem, &x, &setup, self.members)?;
        let parameters = parameter_count(&problem, candidate.degree);
        let named = names(&problem).zip(x).collect();
        Ok(WholeFit { model, starts, parameters, named })
    }

    /// A fit of the candidate to all but the data of a fold: the model, and the starts of its records.
    pub(super) fn without(
        &self,
        candidate: Candidate,
        whole: &WholeFit,
        fold: &Fold,
    ) -> Result<(Model, Vec<(usize, Start)>), NoFit> {
        if candidate.block.takes_two_steps() {
            self.two_steps_without(candidate, fold)
        } else {
            self.joint_without(candidate, whole, fold)
        }
    }

    /// The joint fit of the candidate as a problem.
    #[cfg(test)]
    pub(super) fn problem(&self, candidate: Candidate) -> Result<JointProblem, NoFit> {
        let options = self.candidate_options(candidate, self.members);
        Ok(JointSetup::new(self.members, form(&options), &options)
            .problem(candidate.degree, Rate::Reduced)?)
    }

    fn candidate_options(&self, candidate: Candidate, members: &[JointMember<'_>]) -> Options {
        let options = candidate.options(self.options);
        Options { scheme: Choice::Given(scheme(&options, members)), ..options }
    }

    /// Rough fits of the coarse records from the starts until two agree; the best is continued.
    fn minimise(
        &self,
        (problem, coarse): (&JointProblem, &JointProblem),
        starts: Vec<Vec<f64>>,
    ) -> Result<Vec<f64>, NoFit> {
        let mut found: Vec<Rough> = Vec::new();
        let mut failed = None;
        for start in starts {
            match self.rough_fit(coarse, start) {
                Ok(fit) => found.push(fit),
                Err(NoFit::Stopped) => return Err(NoFit::Stopped),
                // It cannot be simulated; others can.
                Err(why) => failed = Some(why),
            }
            found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            if let [best, others @ ..] = &found[..]
                && others.iter().any(|other| other.agrees_with(best, coarse))
            {
                break;
            }
        }
        match (found.into_iter().next(), failed) {
            (Some(best), _) => self.continued(problem, best.x, ITERATIONS),
            (None, Some(why)) => Err(why),
            (None, None) => Err(OptimizeError::NoFeasiblePoint { evaluations: 0 }.into()),
        }
    }

    fn rough_fit(&self, problem: &JointProblem, start: Vec<f64>) -> Result<Rough, NoFit> {
        let watch = Watch::silent().stopped_by(self.stop);
        let mut engine = self.engine(&watch);
        let fit = fit_with_its_memory(&mut engine, "rough", problem, start.clone(), rough(), None);
        match engine.unless_stopped(fit)? {
            Some(fit) if !engine.is_stopped() => {
                Ok(Rough { start, x: fit.outcome.best, cost: fit.outcome.cost })
            }
            _ => Err(NoFit::Stopped),
        }
    }

    fn continued(&self, problem: &JointProblem, x: Vec<f64>, iterations: usize) -> Result<Vec<f64>, NoFit> {
        let watch = Watch::silent().stopped_by(self.stop);
        let mut engine = self.engine(&watch);
        let options =
            LeastSquaresOptions { iterations, cost_tolerance: COST_TOLERANCE, ..Default::default() };
        let x = nearer_with_its_memory(&mut engine, "continued", problem, x, options.clone(), None)?;
        let fit = local_fits(&mut engine, "continued", problem, vec![x], options, None);
        match engine.unless_stopped(fit)? {
            Some(fit) if !engine.is_stopped() => Ok(fit.outcome.best),
            _ => Err(NoFit::Stopped),
        }
    }

    fn engine<'a, 'w>(&self, watch: &'a Watch<'w>) -> Engine<'a, 'w> {
        let settings = Settings { seed: self.options.seed, ..Settings::default() };
        Engine::new(None, settings, watch, Plan(&[]), None)
    }

    /// The model at `x` and the start of every member's record.
    fn solved(
        &self,
        problem: &JointProblem,
        x: &[f64],
        setup: &JointSetup<'_>,
        members: &[JointMember<'_>],
    ) -> Result<(Model, Vec<Start>), NoFit> {
        let solution = problem.solve(x).ok_or(OptimizeError::NoFeasiblePoint { evaluations: 0 })?;
        let model = assemble(&solution, &setup.form, members, setup.options)?;
        let start = |(m, &memory): (&JointMember<'_>, &f64)| m.start(&solution.hysteresis, memory);
        let starts = members.iter().zip(&solution.memory).map(start).collect();
        Ok((model, starts))
    }

    /// Joint fit to the training data of a fold; the starts of its records.
    fn joint_without(
        &self,
        candidate: Candidate,
        whole: &WholeFit,
        fold: &Fold,
    ) -> Result<(Model, Vec<(usize, Start)>), NoFit> {
        let rest = self.rest(fold);
        let masked: Vec<RecordFacts> = rest.iter().map(|(_, facts)| facts.clone()).collect();
        let members: Vec<JointMember<'_>> = rest
            .iter()
            .zip(&masked)
            .map(|((record, _), facts)| self.members[*record].masked(facts))
            .collect();
        let options = self.candidate_options(candidate, &members);
        let setup = JointSetup::new(&members, form(&options), &options).stopped_by(self.stop);
        let problem = setup.problem(candidate.degree, Rate::Reduced)?;
        // The memory of a record is named by its index in the campaign.
        let renamed: Named = whole
            .named
            .iter()
            .filter_map(|(name, value)| {
                let place = (0..self.members.len()).find(|&r| *name == memory_name(r));
                let Some(old) = place else { return Some((name.clone(), *value)) };
                let new = rest.iter().position(|(record, _)| *record == old)?;
                Some((memory_name(new), *value))
            })
            .collect();
        let middle: Vec<f64> = problem.bounds().ranges.iter().map(|r| r.from_unit(0.5)).collect();
        let optimum = overlay(&problem, &middle, &renamed);
        let known = problem.cost(&optimum, &mut problem.workspace());
        let start = without_what_is_loose(&problem, &optimum);
        let x = match self.continued(&problem, start, FOLD_ITERATIONS) {
            Err(NoFit::Stopped) => return Err(NoFit::Stopped),
            Ok(x) if problem.cost(&x, &mut problem.workspace()) <= known => x,
            // It ended in another optimum, or the start cannot be simulated.
            _ => self.continued(&problem, optimum, FOLD_ITERATIONS)?,
        };
        let (model, starts) = self.solved(&problem, &x, &setup, &members)?;
        Ok((model, rest.iter().map(|(record, _)| *record).zip(starts).collect()))
    }

    fn fit_in_two_steps(&self, options: &Options) -> Result<WholeFit, NoFit> {
        let campaign: Vec<CampaignRecord> =
            self.facts.iter().map(|f| CampaignRecord { data: f.data.clone(), role: None }).collect();
        let (model, starts) = self.identified(&campaign, options)?;
        let nonzero = |b: &[f64]| b.iter().filter(|b| **b != 0.0).count();
        let blocks = match &model.dynamics {
            Dynamics::Arx(arx) => arx.a.len() + nonzero(&arx.b),
            Dynamics::Integer(g) => g.numerator.len() + g.denominator.len() - 1,
            _ => return Err(NoFit::Failed("the records hold no dynamics for such a block".into())),
        };
        let degree = match options.degree {
            Choice::Given(degree) => degree,
            Choice::Auto => 0,
        };
        // l[u], then α, β, γ and the delay.
        let parameters = degree + 4 + usize::from(options.n == Choice::Auto) + blocks;
        Ok(WholeFit { parameters, model, starts, named: Vec::new() })
    }

    fn two_steps_without(
        &self,
        candidate: Candidate,
        fold: &Fold,
    ) -> Result<(Model, Vec<(usize, Start)>), NoFit> {
        let rest = self.rest(fold);
        let campaign: Vec<CampaignRecord> =
            rest.iter().map(|(_, f)| CampaignRecord { data: f.data.clone(), role: None }).collect();
        let options = candidate.options(self.options);
        let (model, starts) = self.identified(&campaign, &options)?;
        if model.dynamics == Dynamics::None {
            return Err(NoFit::Failed("without it no record holds dynamics for such a block".into()));
        }
        Ok((model, rest.iter().map(|(record, _)| *record).zip(starts).collect()))
    }

    /// Two-step identification.
    fn identified(
        &self,
        campaign: &[CampaignRecord],
        options: &Options,
    ) -> Result<(Model, Vec<Start>), NoFit> {
        if self.stop.is_requested() {
            return Err(NoFit::Stopped);
        }
        let algorithm =
            Algorithm::LeastSquares(LeastSquaresOptions { starts: POLISHED, ..Default::default() });
        let options =
            Options { algorithm: Some(algorithm), least_fit_percent: f64::NEG_INFINITY, ..options.clone() };
        let found = identify(campaign, &options, &Watch::silent().stopped_by(self.stop), None)?;
        if found.cancelled {
            return Err(NoFit::Stopped);
        }
        Ok((found.model, found.records.iter().map(|r| r.start).collect()))
    }

    /// Training records of a fold: held-out records omitted, held-out parts masked.
    fn rest(&self, fold: &Fold) -> Vec<(usize, RecordFacts)> {
        let mut rest = Vec::new();
        for (record, facts) in self.facts.iter().enumerate() {
            match fold.held.iter().find(|(held, _)| *held == record) {
                Some(_) if fold.whole => {}
                Some((_, ranges)) => {
                    let data = left(&facts.data, ranges, true);
                    rest.push((record, RecordFacts { data, ..facts.clone() }));
                }
                None => rest.push((record, facts.clone())),
            }
        }
        rest
    }
}

fn names(problem: &JointProblem) -> impl Iterator<Item = String> + '_ {
    problem.bounds().ranges.iter().map(|r| r.name.clone())
}

/// `base` with the named values where the problem has such a parameter.
fn overlay(problem: &JointProblem, base: &[f64], named: &Named) -> Vec<f64> {
    let ranges = &problem.bounds().ranges;
    ranges
        .iter()
        .zip(base)
        .map(|(range, &b)| {
            let value = named.iter().find(|(name, _)| *name == range.name).map_or(b, |(_, value)| *value);
            value.clamp(range.low, range.high)
        })
        .collect()
}

/// Number of parameters of the model, without those of the records' initial states.
fn parameter_count(problem: &JointProblem, degree: usize) -> usize {
    let layout = problem.layout();
    let own = layout.memory.iter().filter(|role| matches!(role, Role::Searched(_))).count();
    let eliminated = layout.linear().filter(|role| role.is_eliminated()).count();
    debug_assert_eq!(layout.polynomial.len(), degree);
    problem.bounds().dimension() - own + eliminated
}
