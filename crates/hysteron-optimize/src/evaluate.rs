//! Evaluation of many candidates at once.

use super::points::Points;
use super::{Derivative, Eliminated, LeastSquaresProblem, OptimizeError, Problem, Stop};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Costs of points of the unit box.
pub(super) trait Evaluate {
    /// Costs of `points` in their order; non-finite ones are +∞.
    fn costs(&mut self, points: &Points, costs: &mut Vec<f64>);
}

/// Residuals of points of the unit box, and their analytic derivatives.
pub(super) trait EvaluateResiduals {
    fn residual_count(&self) -> usize;
    /// Residuals of all `points`, one column after the other, and a flag for each that could be simulated.
    fn residuals(&mut self, points: &Points, columns: &mut [f64], feasible: &mut Vec<bool>);
    /// The problem's own derivatives with respect to its parameters, and what it eliminates.
    fn jacobian(&mut self, point: &[f64], columns: &mut [f64]) -> (Derivative, Eliminated<'_>);
}

/// Parallel evaluator; each thread creates its workspace on first use and keeps it for the run, so that an
/// evaluation allocates nothing.
pub(super) struct Evaluator<'p, P: Problem> {
    problem: &'p P,
    pool: Option<rayon::ThreadPool>,
    slots: Vec<Slot<P::Workspace>>,
    refusal: Refusal,
}

/// Refuses evaluations after a stop, once there is a point to return.
struct Refusal {
    stop: Option<Stop>,
    found: AtomicBool,
}

impl Refusal {
    fn is_asked_for(&self) -> bool {
        self.stop.as_ref().is_some_and(Stop::is_requested)
    }

    fn is_due(&self) -> bool {
        self.is_asked_for() && self.found.load(Ordering::Relaxed)
    }

    /// Evaluates a point unless refused; repeats it where a stop may have interrupted the only point.
    fn evaluate(&self, mut feasible: impl FnMut() -> bool) -> bool {
        let before = self.is_asked_for();
        let mut done = !self.is_due() && feasible();
        if !done && !before && self.is_asked_for() && !self.is_due() {
            done = feasible();
        }
        if done {
            self.found.store(true, Ordering::Relaxed);
        }
        done
    }
}

/// Workspace and results of one evaluating thread.
struct Slot<W> {
    workspace: Option<W>,
    x: Vec<f64>,
    done: Vec<(usize, f64)>,
}

impl<'p, P: Problem> Evaluator<'p, P> {
    /// `threads`: size of a separate pool, or `None` for the current one.
    pub(super) fn new(
        problem: &'p P,
        threads: Option<usize>,
        stop: Option<Stop>,
    ) -> Result<Self, OptimizeError> {
        let pool = match threads {
            Some(threads) if threads > 1 => Some(
                rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .map_err(|e| OptimizeError::Threads { threads, reason: e.to_string() })?,
            ),
            _ => None,
        };
        let slots = (0..threads.unwrap_or_else(rayon::current_num_threads))
            .map(|_| Slot { workspace: None, x: vec![0.0; problem.bounds().dimension()], done: Vec::new() })
            .collect();
        let refusal = Refusal { stop, found: AtomicBool::new(false) };
        Ok(Self { problem, pool, slots, refusal })
    }

    /// Cost at one point, uncounted.
    pub(super) fn cost(&mut self, point: &[f64]) -> f64 {
        // The resumed run already has a point.
        self.refusal.found.store(true, Ordering::Relaxed);
        self.slots.first_mut().map_or(f64::INFINITY, |slot| slot.cost(self.problem, point))
    }
}

/// One thread's share of residual columns and feasibility flags.
type Columns<'a> = (&'a mut [f64], &'a mut [bool]);

impl<W> Slot<W> {
    fn cost<P: Problem<Workspace = W>>(&mut self, problem: &P, point: &[f64]) -> f64 {
        problem.bounds().from_unit(point, &mut self.x);
        let workspace = self.workspace.get_or_insert_with(|| problem.workspace());
        let cost = problem.cost(&self.x, workspace);
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    fn residuals<P>(&mut self, problem: &P, point: &[f64], out: &mut [f64]) -> bool
    where
        P: LeastSquaresProblem<Workspace = W>,
    {
        problem.bounds().from_unit(point, &mut self.x);
        let workspace = self.workspace.get_or_insert_with(|| problem.workspace());
        problem.residuals(&self.x, workspace, out) && out.iter().all(|r| r.is_finite())
    }
}

impl<P: Problem> Evaluate for Evaluator<'_, P> {
    fn costs(&mut self, points: &Points, costs: &mut Vec<f64>) {
        let (problem, count, refusal) = (self.problem, points.len(), &self.refusal);
        costs.clear();
        costs.resize(count, f64::INFINITY);
        let next = AtomicUsize::new(0);
        let work = |slot: &mut Slot<P::Workspace>| {
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                if i >= count {
                    break;
                }
                let mut cost = f64::INFINITY;
                refusal.evaluate(|| {
                    cost = slot.cost(problem, points.get(i));
                    cost.is_finite()
                });
                slot.done.push((i, cost));
            }
        };
        match &self.pool {
            _ if self.slots.len() <= 1 || count <= 1 => self.slots.iter_mut().take(1).for_each(work),
            Some(pool) => pool.install(|| self.slots.par_iter_mut().for_each(work)),
            None => self.slots.par_iter_mut().for_each(work),
        }
        for (i, cost) in self.slots.iter_mut().flat_map(|slot| slot.done.drain(..)) {
            costs[i] = cost;
        }
    }
}

impl<P: LeastSquaresProblem> EvaluateResiduals for Evaluator<'_, P> {
    fn residual_count(&self) -> usize {
        self.problem.residual_count()
    }

    fn residuals(&mut self, points: &Points, columns: &mut [f64], feasible: &mut Vec<bool>) {
        let (problem, count, refusal) = (self.problem, points.len(), &self.refusal);
        feasible.clear();
        feasible.resize(count, false);
        let length = problem.residual_count();
        let share = count.div_ceil(self.slots.len().max(1)).max(1);
        let work = |((first, slot), (columns, feasible)): ((usize, &mut Slot<_>), Columns<'_>)| {
            for ((i, column), feasible) in (first * share..).zip(columns.chunks_mut(length)).zip(feasible) {
                *feasible = refusal.evaluate(|| slot.residuals(problem, points.get(i), column));
            }
        };
        let (slots, block) = (&mut self.slots, share * length);
        if slots.len() <= 1 || count <= 1 {
            let slots = slots.iter_mut().enumerate();
            slots.zip(columns.chunks_mut(block).zip(feasible.chunks_mut(share))).for_each(work);
            return;
        }
        let slots = slots.par_iter_mut().enumerate();
        let jobs = slots.zip(columns.par_chunks_mut(block).zip(feasible.par_chunks_mut(share)));
        match &self.pool {
            Some(pool) => pool.install(|| jobs.for_each(work)),
            None => jobs.for_each(work),
        }
    }

    fn jacobian(&mut self, point: &[f64], columns: &mut [f64]) -> (Derivative, Eliminated<'_>) {
        let infeasible = (Derivative::Infeasible, Eliminated::default());
        if self.refusal.is_due() {
            return infeasible;
        }
        let Some(slot) = self.slots.first_mut() else { return infeasible };
        self.problem.bounds().from_unit(point, &mut slot.x);
        let workspace = slot.workspace.get_or_insert_with(|| self.problem.workspace());
        match self.problem.jacobian_with_eliminated(&slot.x, workspace, columns) {
            (Derivative::Written, _) if columns.iter().any(|d| !d.is_finite()) => infeasible,
            found => found,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;
    use std::time::{Duration, Instant};

    use super::super::test_problems::{Cost, cube};
    use super::*;

    static BEGUN: AtomicUsize = AtomicUsize::new(0);

    /// 0 where the other one begins while this one waits.
    fn waiting(_: &[f64]) -> f64 {
        BEGUN.fetch_add(1, Ordering::SeqCst);
        let end = Instant::now() + Duration::from_secs(20);
        while BEGUN.load(Ordering::SeqCst) < 2 {
            if Instant::now() > end {
                return 1.0;
            }
            std::thread::yield_now();
        }
        0.0
    }

    #[test]
    fn two_threads_compute_at_the_same_time() {
        let problem = Cost { bounds: cube(1, 0.0, 1.0), cost: waiting };
        let mut points = Points::new(1);
        points.push(&[0.25]);
        points.push(&[0.75]);
        let mut costs = Vec::new();
        Evaluator::new(&problem, Some(2), None).unwrap().costs(&points, &mut costs);
        assert_eq!(costs, [0.0, 0.0]);
    }
}
