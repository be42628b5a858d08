//! Choice of the hysteresis family by held-out error.

use super::super::campaign::{of_runs, roles, runs, usable};
use super::super::defaults::{beside_wide_moves, resolved};
use super::super::options::{
    CampaignRecord, Choice, DynamicsChoice, FamilyChoice, Method, Options, RecordRole,
};
use super::super::{IdentifyError, Searches, Watch};
use super::candidate::{Block, Candidate, USUAL_DEGREE};
use super::content::Content;
use super::prospect::one_amplitude;
use super::{Comparison, Entry, Selection, compare_from, rank};
use hysteron_model::dynamics::Creep;
use hysteron_model::hysteresis::HysteresisForm;
use hysteron_numeric::number::significant;

/// Families compared and the one chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilySelection {
    /// Held-out error of each family, geometric mean over the folds \[output unit\]: these may differ by
    /// orders of magnitude in difficulty, and a family is compared fold by fold. `None` where a fit failed.
    /// Empty where families were not compared.
    pub errors: Vec<(HysteresisForm, Option<f64>)>,
    /// The family chosen: the one with fewest parameters among those whose logarithms of the error are within
    /// one standard error of the smallest ([`super::Ranking::preferred`]).
    pub chosen: HysteresisForm,
    /// Choice and reason, in plain words.
    pub verdict: String,
}

/// The family with the smallest held-out error, for [`FamilyChoice::Auto`]; all with the same dynamics, creep
/// and degree. The usual one where `options` leave no choice or the records cannot discriminate.
///
/// # Errors
/// [`IdentifyError`] of unusable records; [`IdentifyError::Stopped`].
pub(crate) fn choose(
    campaign: &[CampaignRecord],
    options: &Options,
    watch: &Watch<'_>,
    resume: Option<Searches>,
) -> Result<FamilySelection, IdentifyError> {
    let not_compared = |why: &str| FamilySelection::usual(options.family(), why);
    let families: Vec<HysteresisForm> =
        HysteresisForm::usual().into_iter().filter(|form| form.description().is_chosen_unasked()).collect();
    let is_of_a_family = |name: &str| {
        let has =
            |form: &HysteresisForm| form.weight_names().iter().chain(&form.shape_names()).any(|n| n == name);
        families.iter().any(has)
    };
    if options.method != Method::Joint || options.dynamics.takes_two_steps() {
        return Ok(not_compared("identification in two steps takes no other"));
    }
    if options.start.is_some() || options.n == Choice::Auto || options.demands.names().any(is_of_a_family) {
        return Ok(not_compared("a starting model, its exponent or its own numbers were asked for"));
    }
    let runs = if options.continued { Some(of_runs(campaign, &runs(campaign)?)) } else { None };
    let facts = usable(runs.as_deref().unwrap_or(campaign))?;
    if beside_wide_moves(&facts).is_some() {
        let usual = resolved(&facts, &Options { hysteresis: FamilyChoice::Usual, ..options.clone() });
        let why = "a record with time stamps has small oscillations beside wide moves";
        return Ok(FamilySelection::usual(usual.family(), why));
    }
    let contents: Vec<Content> = facts.iter().map(Content::of).collect();
    let is_dynamic = roles(runs.as_deref().unwrap_or(campaign), &facts).contains(&RecordRole::Dynamic);
    let base = structure(options, is_dynamic);
    let candidates: Vec<Candidate> =
        families.iter().map(|&hysteresis| Candidate { hysteresis, ..base }).collect();
    match compare_from(campaign, Selection::Given(&candidates), options, watch, resume) {
        Ok(_) if watch.is_stopped() => Err(IdentifyError::Stopped),
        Ok(found) => Ok(chosen(&found, &contents, &campaign[0].data.y_unit.to_string())
            .unwrap_or_else(|| not_compared("no fit could be made without a part of the records"))),
        Err(IdentifyError::CannotRank { because, .. }) => Ok(not_compared(&because)),
        Err(_) if watch.is_stopped() => Err(IdentifyError::Stopped),
        Err(error) => Err(error),
    }
}

/// Structure with which the families are compared.
fn structure(options: &Options, is_dynamic: bool) -> Candidate {
    let is_open = options.dynamics == DynamicsChoice::Auto;
    let block = if is_open && !is_dynamic { Block::NONE } else { Block::of_options(options) };
    let creep = match options.creep {
        Creep::None if is_open && is_dynamic => Creep::Fractional,
        given => given,
    };
    let degree = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => USUAL_DEGREE,
    };
    Candidate { creep, degree, ..Candidate::of(block) }
}

fn chosen(found: &Comparison, contents: &[Content], unit: &str) -> Option<FamilySelection> {
    let family = |index: usize| found.entries[index].candidate.hysteresis;
    let parameters: Vec<usize> = found.entries.iter().map(|entry| entry.parameters).collect();
    let logarithm = |error: &f64| error.max(f64::MIN_POSITIVE).ln();
    let logarithms = |entry: &Entry| Some(entry.complete()?.iter().map(logarithm).collect());
    let ranking = rank(&found.entries.iter().map(logarithms).collect::<Vec<_>>(), &parameters)?;
    let error = |index: usize| ranking.standings[index].map(|standing| standing.mean.exp());
    let errors = (0..found.entries.len()).map(|index| (family(index), error(index))).collect();
    let told = |index: usize| {
        let error = error(index).map_or("none".to_owned(), |error| significant(error, 3));
        format!("{} {error}{}{unit}", family(index).name(), if unit.is_empty() { "" } else { " " })
    };
    let others = ranking.order.iter().filter(|&&i| i != ranking.preferred);
    let others: Vec<String> = others.map(|&i| format!("; {}", told(i))).collect();
    let why = if ranking.best == ranking.preferred { "" } else { " (simplest within one standard error)" };
    let verdict = format!(
        "The hysteresis family is {}{why}, by held-out error over {} folds{}.{}",
        told(ranking.preferred),
        found.folds.len(),
        others.concat(),
        if one_amplitude(contents) {
            " All records have one amplitude: minor loops are held out by none of the folds."
        } else {
            ""
        }
    );
    Some(FamilySelection { errors, chosen: family(ranking.preferred), verdict })
}

impl FamilySelection {
    /// The usual family, where families were not compared.
    fn usual(family: HysteresisForm, why: &str) -> Self {
        let verdict = format!("The hysteresis family is the usual one, {}: {why}.", family.name());
        Self { errors: Vec::new(), chosen: family, verdict }
    }

    /// `options` with the chosen family; with the usual one they stay as they are, as it may bring dynamics of
    /// its own.
    pub(crate) fn applied(&self, options: &Options) -> Options {
        let hysteresis =
            if self.errors.is_empty() { FamilyChoice::Usual } else { FamilyChoice::Given(self.chosen) };
        Options { hysteresis, ..options.clone() }
    }
}
