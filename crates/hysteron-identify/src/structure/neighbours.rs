//! Structures similar to an identified one, fitted to the same records and compared by training error.
//!
//! Cheaper than [`super::compare`], as nothing is held out: one fit per structure, started from the
//! identified one. A richer structure always lowers the training error; BIC penalises its parameters.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::super::Identification;
use super::super::campaign::{of_runs, runs, usable};
use super::super::defaults::resolved;
use super::super::engine::Engine;
use super::super::joint::JointMember;
use super::super::options::{CampaignRecord, Choice, DynamicsChoice, Options};
use super::candidate::{Block, Candidate};
use super::content::Content;
use super::errors::Training;
use super::fit::{Campaign, Named, NoFit};
use super::folds;
use crate::IdentifyError;
use crate::parameter::ParameterRole;
use crate::watch::{Event, Plan, Watch};
use hysteron_model::dynamics::{Creep, ParameterKind};
use hysteron_optimize::Settings;

/// Highest polynomial degree tried.
const HIGHEST_DEGREE: usize = 5;

/// Structures compared by their training errors.
#[derive(Clone, Debug)]
pub struct Neighbours {
    /// The identified structure, then the similar ones.
    pub entries: Vec<Neighbour>,
    /// Effective number of independent samples of the best fit's residuals, used in BIC.
    pub independent_samples: f64,
    /// Samples of all records.
    pub samples: usize,
}

/// One structure.
#[derive(Clone, Debug)]
pub struct Neighbour {
    /// The structure.
    pub candidate: Candidate,
    /// Number of parameters, without the records' offsets and initial memories.
    pub parameters: usize,
    /// RMSE over all records, each with its offset \[output unit\].
    pub rmse: f64,
    /// BIC, see [`super::Entry::bic`].
    pub bic: f64,
}

/// Fits structures similar to the one in `found`, which `options` identified from `campaign`: static,
/// integer-order and fractional dynamics, with and without creep, one polynomial degree more and less, n held
/// and free. Those that cannot be fitted are omitted.
///
/// # Errors
/// [`IdentifyError::CannotRank`] where the records cannot discriminate between structures; others where they
/// cannot be fitted jointly.
pub fn neighbours(
    campaign: &[CampaignRecord],
    options: &Options,
    found: &Identification,
    watch: &Watch<'_>,
) -> Result<Neighbours, IdentifyError> {
    let runs = if options.continued { Some(of_runs(campaign, &runs(campaign)?)) } else { None };
    let facts = usable(runs.as_deref().unwrap_or(campaign))?;
    let contents: Vec<Content> = facts.iter().map(Content::of).collect();
    folds::plan(&facts, &contents)?;
    let chosen = found.structure.family.as_ref().map(|selection| selection.applied(options));
    let options = &resolved(&facts, chosen.as_ref().unwrap_or(options));
    let options = &Options { algorithm: None, start: Some(found.model.clone()), ..options.clone() };
    let stop = watch.stop();
    let silent = Watch::silent().stopped_by(stop);
    let settings = Settings { seed: options.seed, ..Settings::default() };
    let mut engine = Engine::new(None, settings, &silent, Plan(&[]), None);
    let members =
        facts.iter().map(|f| JointMember::new(f, options, &mut engine)).collect::<Result<Vec<_>, _>>()?;
    let campaign = Campaign { facts: &facts, members: &members, options, stop };
    let near: Named = (found.bounds.iter().zip(&found.searches))
        .flat_map(|(bounds, search)| {
            bounds.ranges.iter().map(|r| r.name.clone()).zip(search.outcome.best.clone())
        })
        .collect();
    let candidates = candidates(identified(options, found));
    let (count, done) = (candidates.len() as f64, AtomicUsize::new(0));
    let fitted: Vec<Option<(Candidate, usize, Training)>> = candidates
        .into_par_iter()
        .map(|candidate| {
            let of = || -> Result<_, NoFit> {
                let fit = campaign.fit(candidate, &[&near])?;
                Ok((candidate, fit.parameters, campaign.training(&campaign.simulations(&fit)?)?))
            };
            let fit = of().ok();
            let fraction = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / count;
            if watch.tell(Event::new("other structures", fraction, None)).is_break() {
                stop.request();
            }
            fit
        })
        .collect();
    let fitted: Vec<_> = fitted.into_iter().flatten().collect();
    let closest = fitted.iter().map(|f| f.2).min_by(|a, b| a.mean_square.total_cmp(&b.mean_square));
    let information = closest.map_or(2.0, |t| t.information.max(2.0));
    let entries = fitted
        .into_iter()
        .map(|(candidate, parameters, training)| Neighbour {
            candidate,
            parameters,
            rmse: training.rmse,
            bic: training.bic(information, parameters),
        })
        .collect();
    Ok(Neighbours {
        entries,
        independent_samples: information,
        samples: facts.iter().map(|f| f.scored(0).len()).sum(),
    })
}

/// The structure that was identified.
fn identified(options: &Options, found: &Identification) -> Candidate {
    // Not the form of the model, which holds the many plays of a fitted density.
    let hysteresis = options.family();
    let has = |kind: ParameterKind| {
        found.parameters.iter().any(|p| matches!(p.role, ParameterRole::Dynamics(own) if own.kind == kind))
    };
    let block = match options.dynamics {
        DynamicsChoice::Auto if has(ParameterKind::HighestOrder(1)) => Block::of(DynamicsChoice::Fractional),
        DynamicsChoice::Auto if !has(ParameterKind::NaturalFrequency(1)) => {
            if has(ParameterKind::Lag) {
                Block::integer(1)
            } else {
                Block::NONE
            }
        }
        _ => Block::of_options(options),
    };
    Candidate {
        block,
        creep: found.structure.creep,
        degree: found.structure.degree,
        n_free: options.n == Choice::Auto && hysteresis.description().has_exponent(),
        hysteresis,
    }
}

/// `own`, then structures that differ in one respect, and the basic dynamics with and without creep.
fn candidates(own: Candidate) -> Vec<Candidate> {
    let mut list = vec![own];
    let mut add = |candidate: Candidate| {
        if !list.contains(&candidate) {
            list.push(candidate);
        }
    };
    let with = if own.creep == Creep::None { Creep::Fractional } else { own.creep };
    for block in [Block::NONE, Block::integer(2), Block::of(DynamicsChoice::Fractional), own.block] {
        for creep in [Creep::None, with] {
            // A static model with creep, and ARX with it, are rarely of interest.
            if creep == Creep::None || !(block == Block::NONE || block.takes_two_steps()) {
                add(Candidate { block, creep, ..own });
            }
        }
    }
    for degree in [own.degree.saturating_sub(1), own.degree + 1] {
        if (1..=HIGHEST_DEGREE).contains(&degree) {
            add(Candidate { degree, ..own });
        }
    }
    add(Candidate { n_free: !own.n_free, ..own });
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_neighbours_differ_in_one_respect_or_are_the_plain_dynamics() {
        let own: Candidate = "fractional+creep+degree2".parse().unwrap();
        let names: Vec<String> = candidates(own).iter().map(ToString::to_string).collect();
        assert_eq!(
            names,
            [
                "fractional+creep+degree2",
                "none+degree2",
                "integer2+degree2",
                "integer2+creep+degree2",
                "fractional+degree2",
                "fractional+creep+degree1",
                "fractional+creep",
                "fractional+creep+degree2+n-free"
            ]
        );
        let steep: Candidate = "none+degree5".parse().unwrap();
        assert!(candidates(steep).iter().all(|c| c.degree <= 5));
    }
}
