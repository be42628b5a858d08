//! A joint fit searched in normalised coefficients of its second-order factors.
//!
//! A second-order factor 1/(b₂ (s/ω₀)^α₂ + b₁ (s/ω₀)^α₁ + 1), b₂ = (ω₀/ω)^α₂, b₁ = 2ζ (ω₀/ω)^α₁, with ω₀ at
//! twice the fastest frequency of the drive. For a resonance beyond the band of the records the output is
//! nearly linear in b₂ and b₁, while natural frequency and damping compensate for each other and for the
//! orders along a curved valley. The optimum is the same, in fewer evaluations (`docs/theory/joint.md`). A factor
//! that starts within the band, or where an earlier fit in coefficients ended outside its ranges, keeps its
//! natural frequency and damping.

use super::super::engine::{Engine, Search, Show, rough};
use super::super::layout::Role;
use super::problem::{JointProblem, JointWorkspace};
use super::resolution::{COARSE, resolution, resolved};
use super::setup::NORMALISATION;
use hysteron_model::dynamics::{Modes, ParameterKind};
use hysteron_optimize::{
    Bounds, Derivative, Eliminated, LeastSquaresOptions, LeastSquaresProblem, OptimizeError, Problem, Range,
};

/// Fits are continued beyond [`COARSE`] if their cost exceeds the best by less than this many times that
/// share.
const CONTINUED: f64 = 100.0;
/// Least coefficient, at which the term is negligible.
const NOTHING: f64 = 1e-12;

/// Indices of the parameters of one second-order factor in the search vector.
#[derive(Clone, Copy, Debug)]
struct Factor {
    natural_frequency: usize,
    damping: usize,
    /// α₂ and α₁.
    orders: [Order; 2],
}

/// An order of a factor.
#[derive(Clone, Copy, Debug)]
enum Order {
    Searched(usize),
    Held(f64),
}

impl Order {
    fn value(self, x: &[f64]) -> f64 {
        match self {
            Self::Searched(index) => x[index],
            Self::Held(value) => value,
        }
    }
}

/// A joint fit with the coefficients b₂ and b₁ of its second-order factors instead of their natural
/// frequencies and dampings.
pub(super) struct Normalised<'p> {
    problem: &'p JointProblem,
    factors: Vec<Factor>,
    /// ω₀/2π.
    at_hz: f64,
    bounds: Bounds,
}

impl<'p> Normalised<'p> {
    /// For fits from these `starts`; `None` where no factor of the dynamics is searched, or its resonances are
    /// within the band.
    pub(super) fn new(problem: &'p JointProblem, starts: &[Vec<f64>]) -> Option<Self> {
        let (form, layout) = (problem.form(), problem.layout());
        let one_resonance = match form.modes {
            Modes::Fractional | Modes::FractionalFreeLowest | Modes::TwoFractional => true,
            Modes::Integer { order } => order <= 3,
            Modes::None | Modes::Resonances { .. } => false,
        };
        let order = |kind: ParameterKind, whole: f64| match layout.role(&form, kind) {
            Some(Role::Searched(index)) => Order::Searched(index),
            Some(Role::Fixed(value)) => Order::Held(value),
            _ => Order::Held(whole),
        };
        let factor = |mode: usize| {
            let highest = order(ParameterKind::HighestOrder(mode), 2.0);
            Some(Factor {
                natural_frequency: layout.place(&form, ParameterKind::NaturalFrequency(mode))?,
                damping: layout.place(&form, ParameterKind::Damping(mode))?,
                orders: [highest, order(ParameterKind::MiddleOrder(mode), 1.0)],
            })
        };
        let (at_hz, ranges) = (problem.normalisation_hz(), &problem.bounds().ranges);
        let is_beyond = |factor: &Factor, x: &Vec<f64>| NORMALISATION * x[factor.natural_frequency] > at_hz;
        let is_at_end = |factor: &Factor, x: &Vec<f64>| {
            [factor.natural_frequency, factor.damping].iter().any(|&index| ranges[index].is_end(x[index]))
        };
        let applies = |factor: &Factor| {
            starts.iter().all(|x| is_beyond(factor, x)) && !starts.iter().all(|x| is_at_end(factor, x))
        };
        let factors: Vec<Factor> = (1..=form.parameter_count()).filter_map(factor).filter(applies).collect();
        if !one_resonance || factors.is_empty() {
            return None;
        }
        let mut bounds = problem.bounds().clone();
        for factor in &factors {
            let [f, damping] = [&ranges[factor.natural_frequency], &ranges[factor.damping]];
            let largest = |order: Order| {
                let orders = match order {
                    Order::Searched(index) => [ranges[index].low, ranges[index].high],
                    Order::Held(value) => [value; 2],
                };
                orders.into_iter().map(|order| (at_hz / f.low).powf(order)).fold(1.0, f64::max)
            };
            let [most2, most1] = factor.orders.map(largest);
            let coefficient = |range: &Range, most: f64| Range::linear(&range.name, NOTHING, most);
            bounds.ranges[factor.natural_frequency] = coefficient(f, most2);
            bounds.ranges[factor.damping] = coefficient(damping, 2.0 * damping.high * most1);
        }
        // The response to a short lag is linear in it.
        if let Some(lag) = layout.place(&form, ParameterKind::Lag) {
            let Range { name, low, high, .. } = &ranges[lag];
            bounds.ranges[lag] = Range::linear(name, *low, *high);
        }
        Some(Self { problem, factors, at_hz, bounds })
    }

    /// The search vector of the original problem from coefficients: f = f₀ b₂^(−1/α₂), ζ = ½ b₁ b₂^(−α₁/α₂).
    pub(super) fn own(&self, point: &[f64]) -> Vec<f64> {
        let mut x = point.to_vec();
        for Factor { natural_frequency, damping, orders } in &self.factors {
            let [order2, order1] = orders.map(|order| order.value(point));
            let [b2, b1] = [point[*natural_frequency], point[*damping]];
            x[*natural_frequency] = self.at_hz * b2.powf(-1.0 / order2);
            x[*damping] = 0.5 * b1 * b2.powf(-order1 / order2);
        }
        x
    }

    /// The coefficients from a search vector of the original problem.
    pub(super) fn coefficients(&self, x: &[f64]) -> Vec<f64> {
        let mut point = x.to_vec();
        for Factor { natural_frequency, damping, orders } in &self.factors {
            let [order2, order1] = orders.map(|order| order.value(x));
            let ratio = self.at_hz / x[*natural_frequency];
            point[*natural_frequency] = ratio.powf(order2);
            point[*damping] = 2.0 * x[*damping] * ratio.powf(order1);
        }
        point
    }

    /// The point within the original ranges nearest to `x`.
    fn nearest(&self, x: &[f64]) -> Vec<f64> {
        self.problem.bounds().ranges.iter().zip(x).map(|(range, x)| x.clamp(range.low, range.high)).collect()
    }

    /// True if `x` is within the original ranges.
    fn is_inside(&self, x: &[f64]) -> bool {
        self.problem.bounds().ranges.iter().zip(x).all(|(range, x)| (range.low..=range.high).contains(x))
    }
}

impl Problem for Normalised<'_> {
    type Workspace = JointWorkspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> JointWorkspace {
        self.problem.workspace()
    }

    fn cost(&self, point: &[f64], workspace: &mut JointWorkspace) -> f64 {
        self.problem.cost(&self.own(point), workspace)
    }

    fn identity(&self) -> String {
        format!("{} with coefficients at {:e} Hz", self.problem.identity(), self.at_hz)
    }
}

impl LeastSquaresProblem for Normalised<'_> {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn residuals(&self, point: &[f64], workspace: &mut JointWorkspace, out: &mut [f64]) -> bool {
        self.problem.residuals(&self.own(point), workspace, out)
    }

    fn jacobian(&self, point: &[f64], workspace: &mut JointWorkspace, out: &mut [f64]) -> Derivative {
        let x = self.own(point);
        let answer = self.problem.jacobian(&x, workspace, out);
        if answer == Derivative::Written {
            self.by_coefficients(point, &x, out);
        }
        answer
    }

    fn jacobian_with_eliminated<'w>(
        &self,
        point: &[f64],
        workspace: &'w mut JointWorkspace,
        out: &mut [f64],
    ) -> (Derivative, Eliminated<'w>) {
        let x = self.own(point);
        let answer = self.problem.jacobian_with_eliminated(&x, workspace, out);
        if answer.0 == Derivative::Written {
            self.by_coefficients(point, &x, out);
        }
        answer
    }
}

impl Normalised<'_> {
    /// Derivatives with respect to the point from those with respect to the original search vector `x`.
    fn by_coefficients(&self, point: &[f64], x: &[f64], out: &mut [f64]) {
        let count = self.residual_count();
        for factor in &self.factors {
            let [f, damping] = [x[factor.natural_frequency], x[factor.damping]];
            let [order2, order1] = factor.orders.map(|order| order.value(point));
            let b2 = point[factor.natural_frequency];
            let log = b2.ln() / order2;
            // Partial derivatives of f and ζ with respect to b₂, b₁, α₂, α₁.
            let by = [
                (factor.natural_frequency, -f / (order2 * b2), -damping * order1 / (order2 * b2)),
                (factor.damping, 0.0, 0.5 * b2.powf(-order1 / order2)),
            ];
            let of_orders = [
                (factor.orders[0], f * log / order2, damping * order1 * log / order2),
                (factor.orders[1], 0.0, -damping * log),
            ];
            let column = |index: usize| index * count..(index + 1) * count;
            let by_frequency = out[column(factor.natural_frequency)].to_vec();
            let by_damping = out[column(factor.damping)].to_vec();
            let combined = |into: &mut [f64], own: f64, [of_f, of_damping]: [f64; 2]| {
                for ((into, f), damping) in into.iter_mut().zip(&by_frequency).zip(&by_damping) {
                    *into = own * *into + of_f * f + of_damping * damping;
                }
            };
            for (index, of_f, of_damping) in by {
                combined(&mut out[column(index)], 0.0, [of_f, of_damping]);
            }
            for (order, of_f, of_damping) in of_orders {
                if let Order::Searched(index) = order {
                    combined(&mut out[column(index)], 1.0, [of_f, of_damping]);
                }
            }
        }
    }
}

/// Fits from the given starts, to where one step would lower the cost by less than shows in the records
/// ([`resolution`]).
pub(super) fn resolved_fit(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
    show: Show<'_>,
) -> Result<Search, OptimizeError> {
    let coarse = resolved(COARSE);
    let mut search = local_fits(engine, step, problem, starts, coarse, show)?;
    let wanted = resolution(problem, &search.outcome.best);
    if wanted >= COARSE || engine.is_stopped() || problem.bounds().dimension() == 0 {
        return Ok(search);
    }
    // The residuals of a better fit may be whiter, but no more than by a few times.
    let near = search.outcome.cost * (1.0 + CONTINUED * COARSE);
    let (near, rest): (Vec<_>, Vec<_>) =
        std::mem::take(&mut search.outcome.starts).into_iter().partition(|start| start.cost <= near);
    let starts = near.iter().map(|start| start.best.clone()).collect();
    let finer = local_fits(engine, step, problem, starts, resolved(wanted), show);
    let finer = engine.unless_stopped(finer)?;
    search.outcome.starts = rest;
    if finer.is_none() {
        search.outcome.starts.extend(near);
    }
    search.take_better(finer);
    Ok(search)
}

/// [`rough`] fits from the given starts.
pub(super) fn rough_fit(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
) -> Result<Search, OptimizeError> {
    local_fits(engine, step, problem, starts, rough(), None)
}

/// Local fits from the given starts, each with the memory of its start held.
fn kept_memory_fits(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
    options: LeastSquaresOptions,
    show: Show<'_>,
) -> Result<Search, OptimizeError> {
    let mut found: Option<Search> = None;
    let mut failed = OptimizeError::NoFeasiblePoint { evaluations: 0 };
    for start in starts {
        if found.is_some() && engine.is_stopped() {
            break;
        }
        let fit = fit_with_its_memory(engine, step, problem, start, options.clone(), show);
        match (&mut found, fit) {
            (Some(found), Ok(fit)) => found.take_better(Some(fit)),
            (none, Ok(fit)) => *none = Some(fit),
            (_, Err(error @ OptimizeError::NoFeasiblePoint { .. })) => failed = error,
            (Some(_), Err(_)) if engine.is_stopped() => break,
            (_, Err(error)) => return Err(error),
        }
    }
    found.ok_or(failed)
}

/// A local fit with the memory held where this spares rerunning the operators, else with all free.
pub(in super::super) fn fit_with_its_memory(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    start: Vec<f64>,
    options: LeastSquaresOptions,
    show: Show<'_>,
) -> Result<Search, OptimizeError> {
    let Some(held) = problem.holding_memory(&start) else {
        return local_fits(engine, step, problem, vec![start], options, show);
    };
    let (searched, memory) = start.split_at(held.bounds().dimension());
    let whole = |x: &[f64]| [x, memory].concat();
    let shown = |x: &[f64]| show.and_then(|show| show(&whole(x)));
    let grown: Show<'_> = if show.is_some() { Some(&shown) } else { None };
    let mut fit = local_fits(engine, step, &held, vec![searched.to_vec()], options, grown)?;
    let outcome = &mut fit.outcome;
    outcome.best = whole(&outcome.best);
    outcome.starts.iter_mut().for_each(|start| start.best = whole(&start.best));
    Ok(fit)
}

/// A start nearer to the optimum, by a fit with the memory held where this spares rerunning the operators; else
/// `start`. The memory hardly moves, and another one costs as much as all else.
pub(in super::super) fn nearer_with_its_memory(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    start: Vec<f64>,
    options: LeastSquaresOptions,
    show: Show<'_>,
) -> Result<Vec<f64>, OptimizeError> {
    if problem.holding_memory(&start).is_none() {
        return Ok(start);
    }
    let held = fit_with_its_memory(engine, step, problem, start.clone(), options, show);
    Ok(engine.where_feasible(held)?.map_or(start, |fit| fit.outcome.best))
}

/// Local fits from the given starts, in normalised coefficients where these apply. If the best ends outside
/// the ranges of natural frequency and damping, all are refitted within, from their nearest points there; from
/// the starts where none of these can be simulated.
pub(in super::super) fn local_fits(
    engine: &mut Engine<'_, '_>,
    step: &str,
    problem: &JointProblem,
    starts: Vec<Vec<f64>>,
    options: LeastSquaresOptions,
    show: Show<'_>,
) -> Result<Search, OptimizeError> {
    let holds_memory = |start: &Vec<f64>| problem.holding_memory(start).is_some();
    if problem.keeps_memory() && starts.first().is_some_and(holds_memory) {
        return kept_memory_fits(engine, step, problem, starts, options, show);
    }
    let Some(normalised) = Normalised::new(problem, &starts) else {
        return engine.local_fits(step, problem, starts, options, show);
    };
    let coefficients = starts.iter().map(|x| normalised.coefficients(x)).collect();
    let shown = |point: &[f64]| show.and_then(|show| show(&normalised.own(point)));
    let grown: Show<'_> = if show.is_some() { Some(&shown) } else { None };
    let mut search = engine.local_fits(step, &normalised, coefficients, options.clone(), grown)?;
    let outcome = &mut search.outcome;
    outcome.best = normalised.own(&outcome.best);
    outcome.starts.iter_mut().for_each(|start| start.best = normalised.own(&start.best));
    if normalised.is_inside(&search.outcome.best) || engine.is_stopped() {
        return Ok(search);
    }
    let nearest = search.outcome.starts.iter().map(|start| normalised.nearest(&start.best)).collect();
    let within = format!("{step}, within its ranges");
    let fit = engine.local_fits(&within, problem, nearest, options.clone(), show);
    let mut inside = match fit {
        // No nearest point can be simulated.
        Err(OptimizeError::NoFeasiblePoint { .. }) => {
            engine.local_fits(&within, problem, starts, options, show)?
        }
        fit => fit?,
    };
    inside.outcome.evaluations += search.outcome.evaluations;
    inside.outcome.generations += search.outcome.generations;
    Ok(Search { step: step.to_owned(), ..inside })
}
