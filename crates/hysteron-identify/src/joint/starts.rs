//! Starts of the search of a joint fit.
//!
//! A simulation costs a fraction of an iteration, so the starts are the best points of coarse grids. The loop
//! comes first, from the record in which the dynamics matter least, once for a device without memory and once
//! for one settled on loops like those of the record (sharp loops have a second optimum with a spurious
//! memory, to which poor dynamics lead). Then the dynamics, on all records with that loop held.

use super::super::IdentifyError;
use super::super::engine::{Engine, Search};
use super::super::layout::pick;
use super::super::options::Options;
use super::campaign::Rate;
use super::normalised::rough_fit;
use super::parameter_layout::DELAY;
use super::problem::{JointProblem, JointWorkspace};
use super::setup::{JointSetup, memory_name};
use hysteron_model::dynamics::{DynamicForm, Dynamics, Modes, ParameterKind};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::polynomial_name;
use hysteron_optimize::{self as optimize, Bounds, Problem, Stop};
use rayon::prelude::*;
use std::ops::Range;

/// Grid of the natural frequency, as places in its range.
const PLACES: [f64; 4] = [0.3, 0.5, 0.7, 0.9];
const CENTRE: f64 = PLACES[2];
const DAMPINGS: [f64; 3] = [0.03, 0.2, 1.0];
/// Orders of the damping term.
const ORDERS: [f64; 3] = [1.0, 0.6, 0.3];
/// Dynamics of each order that are compared with everything linear eliminated: the best for the loop as it is.
const COMPARED: usize = 3;
/// Costs that differ by more than this share belong to different optima.
const ANOTHER: f64 = 1e-3;
/// First samples that differ by less than this share of the range are the same voltage.
const SAME_VOLTAGE: f64 = 0.01;
/// Dynamics with little effect on a slow record.
const FAST: Motion = Motion { place: 0.9, damping: 0.2, order1: 1.0, measured: false };

/// A loop to start from.
#[derive(Clone, Debug)]
struct Shape {
    numbers: Vec<f64>,
    /// The device has settled on loops like those of the record.
    settled: bool,
}

/// A shape and its search vector.
type Placed = (Shape, Vec<f64>);

/// Dynamics to start from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Motion {
    place: f64,
    damping: f64,
    order1: f64,
    /// Near the resonances measured in the records, instead of a place in the range.
    measured: bool,
}

/// Loop fitted to the slowest record, in the search's own numbers.
#[derive(Clone, Debug)]
struct Loop {
    shape: Vec<f64>,
    /// Memory of the slowest record.
    memory: f64,
    /// Coefficients of u, u², … and weights.
    coefficients: Vec<f64>,
}

/// Starts of a search, and the evaluations spent on them.
#[derive(Debug, Default)]
pub(super) struct Starts {
    pub(super) points: Vec<Vec<f64>>,
    pub(super) evaluations: usize,
}

/// Candidate starts: loops of the slowest record and grid points of the dynamics, the best first.
pub(super) struct Places {
    loops: Vec<Loop>,
    motions: Vec<Motion>,
    /// Evaluations spent on finding the loops.
    pub(super) evaluations: usize,
}

impl Places {
    /// Dynamics, each with a loop. Loops alternate, so that starts that agree on an optimum come from
    /// different regions.
    fn pairs(&self) -> impl Iterator<Item = (&Loop, &Motion)> {
        self.loops.iter().cycle().zip(&self.motions)
    }
}

impl JointSetup<'_> {
    /// Starts from grids alone, the model to start from first.
    pub(in super::super) fn guesses(&self, problem: &JointProblem) -> Result<Vec<Vec<f64>>, IdentifyError> {
        let mut guesses: Vec<Vec<f64>> =
            self.options.start.iter().map(|model| of_model(model, problem.bounds())).collect();
        let (slow, shapes) = self.slow(&self.fast(problem.bounds()), problem.degree())?;
        let Some((best, start)) = shapes.first() else { return Ok(guesses) };
        let other = shapes.iter().find(|(shape, _)| shape.settled != best.settled).map_or(best, |(s, _)| s);
        let point = |motion| self.point(problem.bounds(), best, motion);
        let motions = self.motions(problem, point, slow.linear_coefficients(start).as_deref());
        for (motion, shape) in motions.iter().zip([best, other].iter().cycle()) {
            guesses.push(self.point(problem.bounds(), shape, *motion));
        }
        Ok(guesses)
    }

    /// Loops fitted to the slowest record, and dynamics for them.
    pub(super) fn places(
        &self,
        problem: &JointProblem,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Places, IdentifyError> {
        let mut evaluations = 0;
        // After this evaluation a stop leaves a model.
        if let Some(numbers) = self.shapes().into_iter().next() {
            let start = self.point(problem.bounds(), &Shape { numbers, settled: false }, FAST);
            problem.cost(&start, &mut problem.workspace());
        }
        let loops = self.loops(problem, engine, &mut evaluations)?;
        let motions = self.motions_of(&loops, problem);
        Ok(Places { loops, motions, evaluations })
    }

    /// Dynamics of this form for the loops of places found with another one.
    pub(super) fn places_of_loops(&self, problem: &JointProblem, found: &Places) -> Places {
        let loops = found.loops.clone();
        let motions = self.motions_of(&loops, problem);
        Places { loops, motions, evaluations: 0 }
    }

    /// Dynamics for the first loop; none without a loop.
    fn motions_of(&self, loops: &[Loop], problem: &JointProblem) -> Vec<Motion> {
        let Some(first) = loops.first() else { return Vec::new() };
        let point = |motion| self.looping(problem.bounds(), first, motion);
        self.motions(problem, point, Some(&first.coefficients))
    }

    /// Starts at some of the places, the dynamics fitted to all records with the loop held; without those that
    /// cannot be simulated there.
    pub(super) fn fitted(
        &self,
        problem: &JointProblem,
        places: &Places,
        which: Range<usize>,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Starts, IdentifyError> {
        let mut starts = Starts::default();
        for (number, (found, motion)) in places.pairs().enumerate().take(which.end).skip(which.start) {
            if engine.stop().is_requested() {
                break;
            }
            let options = self.holding(found);
            let held = self.with(self.form, &options).problem(problem.degree(), Rate::Coarse)?;
            let mut point = self.looping(problem.bounds(), found, *motion);
            if held.bounds().dimension() > 0 {
                let start = self.looping(held.bounds(), found, *motion);
                let fit = rough_fit(engine, &format!("dynamics, start {}", number + 1), &held, vec![start]);
                let Some(fit) = engine.where_feasible(fit)? else { continue };
                starts.evaluations += fit.outcome.evaluations;
                let place = |name: &str| held.bounds().ranges.iter().position(|range| range.name == name);
                for (range, value) in problem.bounds().ranges.iter().zip(&mut point) {
                    *value = place(&range.name).map_or(*value, |at| fit.outcome.best[at]);
                }
            }
            starts.points.push(point);
        }
        Ok(starts)
    }

    /// Starts at some of the places themselves.
    pub(super) fn unfitted(
        &self,
        problem: &JointProblem,
        places: &Places,
        which: Range<usize>,
    ) -> Vec<Vec<f64>> {
        let starts = places.pairs().map(|(found, motion)| self.looping(problem.bounds(), found, *motion));
        starts.take(which.end).skip(which.start).collect()
    }

    fn slowest(&self) -> usize {
        let slowness = |index: &usize| self.members[*index].facts.highest_frequency_hz();
        (0..self.members.len()).min_by(|a, b| slowness(a).total_cmp(&slowness(b))).unwrap_or_default()
    }

    /// The options with the dynamics held where they have little effect on the slowest record: free ones
    /// would compensate for the loop.
    fn fast(&self, bounds: &Bounds) -> Options {
        let mut options = self.options.clone();
        let point = self.start(bounds, &[], FAST, |_| 0.0);
        let own = self.form.parameters();
        let held =
            bounds.ranges.iter().zip(point).filter(|(range, _)| own.iter().any(|p| p.name == range.name));
        options.demands.fixed.extend(held.map(|(range, value)| (range.name.clone(), value)));
        options
    }

    /// The problem of the slowest record alone, with `options`, and its starts in order of cost.
    fn slow(&self, options: &Options, degree: usize) -> Result<(JointProblem, Vec<Placed>), IdentifyError> {
        let setup = if self.members.len() == 1 {
            // Its records are those of the search.
            self.with(self.form, options)
        } else {
            let index = self.slowest();
            let members = self.members.get(index..=index).unwrap_or_default();
            JointSetup::new(members, self.form, options).stopped_by(&self.stop)
        };
        let problem = setup.problem(degree, Rate::Reduced)?;
        let lattice = self
            .shapes()
            .into_iter()
            .flat_map(|numbers| [false, true].map(|settled| Shape { numbers: numbers.clone(), settled }));
        let lattice: Vec<Shape> = lattice.collect();
        let point = |shape: &Shape| setup.point(problem.bounds(), shape, FAST);
        let cost = |shape: &Shape, ws: &mut _| problem.cost(&point(shape), ws);
        let ordered = by_cost(&problem, &lattice, cost, &self.stop);
        let starts = ordered.into_iter().map(|shape| (shape.clone(), point(&shape))).collect();
        Ok((problem, starts))
    }

    /// The loop that fits the slowest record best, and the best one of another optimum, if any; none after an
    /// early stop.
    fn loops(
        &self,
        whole: &JointProblem,
        engine: &mut Engine<'_, '_>,
        evaluations: &mut usize,
    ) -> Result<Vec<Loop>, IdentifyError> {
        if engine.is_stopped() {
            return Ok(Vec::new());
        }
        let options = self.fast(whole.bounds());
        let Some((problem, shapes)) = engine.unless_stopped(self.slow(&options, whole.degree()))? else {
            return Ok(Vec::new());
        };
        let found = |x: &[f64]| -> Option<Loop> {
            let candidate = problem.candidate(x)?;
            let coefficients = problem.linear_coefficients(x)?;
            Some(Loop { shape: candidate.shape, memory: *candidate.memory.first()?, coefficients })
        };
        if problem.bounds().dimension() == 0 {
            return Ok(found(&[]).into_iter().collect());
        }
        let of = |settled| shapes.iter().filter(move |(shape, _)| shape.settled == settled).take(2);
        let mut starts: Vec<Vec<f64>> = Vec::new();
        for (_, start) in of(false).chain(of(true)) {
            // Without a memory that is searched, those of both kinds are the same.
            if !starts.contains(start) {
                starts.push(start.clone());
            }
        }
        let fit = rough_fit(engine, "slowest record", &problem, starts);
        let Some(Search { outcome: mut fit, .. }) = engine.unless_stopped(fit)? else {
            return Ok(Vec::new());
        };
        *evaluations += fit.evaluations;
        fit.starts.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let other = fit.starts.iter().find(|start| start.cost > fit.cost * (1.0 + ANOTHER));
        Ok([Some(&fit.best), other.map(|start| &start.best)]
            .into_iter()
            .flatten()
            .filter_map(|x| found(x))
            .collect())
    }

    /// The options with this loop held.
    fn holding(&self, found: &Loop) -> Options {
        let mut options = self.options.clone();
        let names = self.hysteresis.shape_names();
        options.demands.bounded.retain(|(name, ..)| !names.contains(name));
        options.demands.fixed.extend(names.into_iter().zip(found.shape.iter().copied()));
        let memory = (0..self.members.len()).map(|record| (memory_name(record), self.memory(found, record)));
        options.demands.fixed.extend(memory);
        options
    }

    /// Memory of a record: that of the slowest one where both start from the same voltage.
    fn memory(&self, found: &Loop, record: usize) -> f64 {
        let first = |record: usize| self.members[record].facts.data.u[0];
        let apart = (first(record) - first(self.slowest())).abs();
        if apart <= SAME_VOLTAGE * self.scales.range_v {
            found.memory
        } else {
            self.first_memory(&found.shape, false, record)
        }
    }

    /// The best dynamics for a loop, then others of different order (of different frequency for integer
    /// orders). Where the `coefficients` of the loop are known, those with which it fits best are compared.
    fn motions(
        &self,
        problem: &JointProblem,
        point: impl Fn(Motion) -> Vec<f64> + Sync,
        coefficients: Option<&[f64]>,
    ) -> Vec<Motion> {
        if self.form.modes == Modes::None {
            return vec![FAST, FAST];
        }
        let orders = if problem.layout().place(&self.form, ParameterKind::MiddleOrder(1)).is_some() {
            &ORDERS[..]
        } else {
            &ORDERS[..1]
        };
        // Computed here, before candidates are tried on all threads.
        let kinds: &[bool] = if self.resonances().is_empty() { &[false] } else { &[false, true] };
        let lattice = orders.iter().flat_map(|&order1| {
            let of = move |&place: &f64| {
                let motion = move |damping| {
                    kinds.iter().map(move |&measured| Motion { place, damping, order1, measured })
                };
                DAMPINGS.into_iter().flat_map(motion)
            };
            PLACES.iter().flat_map(of)
        });
        let mut motions: Vec<Motion> = lattice.collect();
        let alike = |one: &Motion, other: &Motion| {
            let same = if orders.len() > 1 { other.order1 == one.order1 } else { other.place == one.place };
            same && other.measured == one.measured
        };
        if let Some(coefficients) = coefficients {
            let cost = |motion: &Motion, ws: &mut _| problem.cost_of_loop(&point(*motion), coefficients, ws);
            motions = first_of_each(by_cost(problem, &motions, cost, &self.stop), alike, COMPARED);
        }
        let cost = |motion: &Motion, ws: &mut _| problem.cost(&point(*motion), ws);
        first_of_each(by_cost(problem, &motions, cost, &self.stop), alike, 1)
    }

    /// The start with this loop and these dynamics.
    fn looping(&self, bounds: &Bounds, found: &Loop, motion: Motion) -> Vec<f64> {
        self.start(bounds, &found.shape, motion, |record| self.memory(found, record))
    }

    /// The start with this shape and these dynamics.
    fn point(&self, bounds: &Bounds, shape: &Shape, motion: Motion) -> Vec<f64> {
        let memory = |record| self.first_memory(&shape.numbers, shape.settled, record);
        self.start(bounds, &shape.numbers, motion, memory)
    }

    fn start(
        &self,
        bounds: &Bounds,
        numbers: &[f64],
        motion: Motion,
        memory: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        let parameters = self.form.parameters();
        let (shape_names, weight_names) = (self.hysteresis.shape_names(), self.hysteresis.weight_names());
        pick(bounds, |name| {
            if let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) {
                let range = bounds.ranges.iter().find(|range| range.name == name)?;
                return Some(self.first_value(parameter.kind, range, motion));
            }
            if let Some(index) = shape_names.iter().position(|own| own == name) {
                return numbers.get(index).copied();
            }
            if name == DELAY {
                return Some(0.0);
            }
            if weight_names.iter().any(|own| own == name) {
                return Some(0.3 * self.scales.slope / weight_names.len() as f64);
            }
            (0..self.members.len()).find(|&record| memory_name(record) == name).map(&memory)
        })
    }

    /// Start value of a parameter of the dynamics.
    fn first_value(&self, kind: ParameterKind, range: &optimize::Range, motion: Motion) -> f64 {
        let measured = |mode: usize| {
            let resonances = if motion.measured { self.resonances() } else { &[] };
            resonances.get(mode - 1)
        };
        match kind {
            // At the measured resonances for the centre place, else detuned from them.
            ParameterKind::NaturalFrequency(mode) => match measured(mode) {
                Some(found) => found.natural_frequency_hz * (1.0 + 0.25 * (motion.place - CENTRE)),
                None => range.from_unit(motion.place + (1.0 - motion.place) * (1.0 - 1.0 / mode as f64)),
            },
            ParameterKind::Damping(mode) => match measured(mode) {
                Some(found) => found.damping * (motion.damping / DAMPINGS[1]).sqrt(),
                None => motion.damping,
            },
            ParameterKind::Share(mode) => match measured(mode) {
                Some(found) => found.share,
                None if mode == 1 => 0.9,
                None => 0.0,
            },
            ParameterKind::HighestOrder(_) => 2.0,
            ParameterKind::MiddleOrder(_) => motion.order1,
            ParameterKind::LowestOrder => 0.02,
            ParameterKind::Lag => range.from_unit(1.0 - motion.place),
            ParameterKind::CreepSize => 0.05,
            ParameterKind::CreepOrder => 0.15,
            ParameterKind::CreepPerDecade => 0.02,
            ParameterKind::CreepStart => 0.1,
            ParameterKind::CreepShare(_) => 0.03,
            // Elements are spread over the range of times.
            ParameterKind::CreepTime(element) => {
                range.from_unit(element as f64 / (self.form.creep.elements() as f64 + 1.0))
            }
        }
    }
}

/// The point `x`, found on records of a narrower band, as a start for `problem`, and the evaluations that this took.
/// Where the damping is the lightest of its range, the narrower band did not determine it: the one of [`DAMPINGS`]
/// with the least cost takes its place.
pub(super) fn on_wider_band(problem: &JointProblem, x: Vec<f64>, stop: &Stop) -> (Vec<f64>, usize) {
    let (form, ranges) = (problem.form(), &problem.bounds().ranges);
    let kinds = form.parameters().into_iter().map(|own| own.kind);
    let open: Vec<usize> = kinds
        .filter(|kind| matches!(kind, ParameterKind::Damping(_)))
        .filter_map(|kind| problem.layout().place(&form, kind))
        .filter(|&k| ranges[k].is_lower_end(x[k]))
        .collect();
    if open.is_empty() {
        return (x, 0);
    }
    let with = |damping: f64| {
        let mut other = x.clone();
        open.iter().for_each(|&k| other[k] = damping.clamp(ranges[k].low, ranges[k].high));
        other
    };
    let candidates: Vec<Vec<f64>> = std::iter::once(x.clone()).chain(DAMPINGS.map(with)).collect();
    let mut ordered = by_cost(problem, &candidates, |x, ws| problem.cost(x, ws), stop);
    (ordered.swap_remove(0), candidates.len())
}

/// The candidates in order of cost; last those that cannot be simulated or were not tried before a stop.
fn by_cost<T: Clone + Send + Sync>(
    problem: &JointProblem,
    candidates: &[T],
    cost: impl Fn(&T, &mut JointWorkspace) -> f64 + Sync,
    stop: &Stop,
) -> Vec<T> {
    let share = candidates.len().div_ceil(rayon::current_num_threads()).max(1);
    let shares = candidates.par_chunks(share).flat_map_iter(|share| {
        let mut ws = problem.workspace();
        let cost = &cost;
        share.iter().map(move |candidate| {
            let cost = if stop.is_requested() { f64::INFINITY } else { cost(candidate, &mut ws) };
            (cost, candidate.clone())
        })
    });
    let mut costs: Vec<(f64, T)> = shares.collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    costs.into_iter().map(|(_, candidate)| candidate).collect()
}

/// The first `count` of those that are alike, in the order given.
fn first_of_each<T: Copy>(ordered: Vec<T>, alike: impl Fn(&T, &T) -> bool, count: usize) -> Vec<T> {
    let mut picked: Vec<T> = Vec::new();
    for candidate in ordered {
        if picked.iter().filter(|other| alike(&candidate, other)).count() < count {
            picked.push(candidate);
        }
    }
    picked
}

/// A start from a model's parameters.
fn of_model(model: &Model, bounds: &Bounds) -> Vec<f64> {
    let hysteresis = &model.hysteresis;
    let family = hysteresis.form();
    let names = family.weight_names().into_iter().chain(family.shape_names());
    let own: Vec<(String, f64)> =
        names.zip(hysteresis.weights().iter().copied().chain(hysteresis.shape())).collect();
    let form = match &model.dynamics {
        Dynamics::Fractional(g) | Dynamics::Integer(g) => g.second_order().ok(),
        Dynamics::None | Dynamics::Arx(_) => None,
    };
    let polynomial = hysteresis.polynomial();
    pick(bounds, |name| match DynamicForm::parameter_named(name).map(|parameter| parameter.kind) {
        Some(ParameterKind::NaturalFrequency(1)) => form.map(|f| f.natural_frequency_hz),
        Some(ParameterKind::Damping(1)) => form.map(|f| f.damping),
        Some(ParameterKind::HighestOrder(1)) => form.map(|f| f.alpha2),
        Some(ParameterKind::MiddleOrder(1)) => form.map(|f| f.alpha1),
        Some(_) => None,
        None if name == DELAY => Some(model.delay_s),
        None => match own.iter().find(|(own, _)| own == name) {
            Some((_, value)) => Some(*value),
            None => (1..=polynomial.len()).find(|&i| polynomial_name(i) == name).map(|i| polynomial[i - 1]),
        },
    })
}
