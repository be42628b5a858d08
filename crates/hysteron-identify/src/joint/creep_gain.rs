//! Evidence for a creep factor.

use super::super::engine::Search;
use super::super::static_step::BIC_FALL;
use super::problem::JointProblem;
use super::resolution::information;
use hysteron_optimize::Problem;

/// Evidence for creep beyond doubt, relative to very strong evidence, and the least ratio of the costs.
const EVIDENT: f64 = 4.0;
const EVIDENT_RATIO: f64 = 1.5;

/// Evidence for a creep factor: the fall of −2 ln of the likelihood, the BIC penalty of its parameters, and
/// the ratio of the cost without it to that with it.
pub(super) struct Gain {
    likelihood: f64,
    price: f64,
    ratio: f64,
    /// Fall of −2 ln of the likelihood by a factor e of the cost.
    of_ratio: f64,
}

impl Gain {
    /// Gain from the cost of a fit without creep to that of a fit with it.
    pub(super) fn new(
        (plain, cost): (&JointProblem, f64),
        (creeping, found): (&JointProblem, &Search),
    ) -> Self {
        let information = information(creeping, &found.outcome.best);
        let ratio = cost / found.outcome.cost;
        let parameters = creeping.bounds().dimension() - plain.bounds().dimension();
        let price = parameters as f64 * information.ln();
        let of_ratio = 2.0 * information;
        Self { likelihood: of_ratio * ratio.ln(), price, ratio, of_ratio }
    }

    /// True if the evidence for creep is very strong.
    pub(super) fn is_strong(&self) -> bool {
        self.likelihood > BIC_FALL + self.price
    }

    /// True if creep is beyond doubt although the fit without it is not converged: on records with creep such
    /// fits converge slowly.
    pub(super) fn is_evident(&self) -> bool {
        self.ratio > EVIDENT_RATIO && self.is_overwhelming()
    }

    /// True if creep is beyond doubt where the fit without it is converged.
    pub(super) fn is_overwhelming(&self) -> bool {
        self.likelihood > EVIDENT * (BIC_FALL + self.price)
    }
}

/// Cost of a fit without creep above which the one with creep that is `found` is preferred beyond doubt.
pub(super) fn beaten(plain: &JointProblem, (creeping, found): (&JointProblem, &Search)) -> f64 {
    let equal = Gain::new((plain, found.outcome.cost), (creeping, found));
    let wanted = EVIDENT * (BIC_FALL + equal.price);
    found.outcome.cost * (wanted / equal.of_ratio).exp()
}
