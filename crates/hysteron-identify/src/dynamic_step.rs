//! Step 2 in practice: orders and coefficients of the dynamic block, driven by the hysteresis output, are
//! estimated jointly.

use super::dynamic_problem::{DynamicLayout, DynamicProblem, DynamicRecord, DynamicSolution};
use super::engine::{Engine, Search};
use super::layout::{BoxBuilder, Role, pick};
use super::options::{Choice, DynamicsChoice, Options};
use super::shown::shown;
use super::static_step::OFFSET;
use super::{IdentifyError, RecordFacts};
use hysteron_model::Start;
use hysteron_model::dynamics::delay::delay_in_place;
use hysteron_model::dynamics::{Dynamics, TransferFunction};
use hysteron_model::hammerstein::extend;
use hysteron_model::hysteresis::ArticleOperator;
use hysteron_optimize::{Bounds, OptimizeError, Problem, Range};

/// Longest delay searched: the larger of this number of samples and this share of the fastest period in the
/// data.
pub(super) const LONGEST_DELAY_SAMPLES: f64 = 5.0;
pub(super) const LONGEST_DELAY_PERIODS: f64 = 0.1;

/// Result of the dynamic step.
pub(super) struct DynamicStep {
    pub(super) problem: DynamicProblem,
    pub(super) layout: DynamicLayout,
    pub(super) search: Search,
    pub(super) solution: DynamicSolution,
}

/// Records with the output of the identified hysteresis block, ready for a dynamic fit.
pub(super) struct HysteresisOutput<'a> {
    facts: &'a RecordFacts,
    v: Vec<f64>,
    rest: f64,
    prologue: usize,
    rate_hz: f64,
}

pub(super) fn hysteresis_outputs<'a>(
    operator: &ArticleOperator,
    records: &[&'a RecordFacts],
    starts: &[Start],
) -> Result<Vec<HysteresisOutput<'a>>, IdentifyError> {
    records
        .iter()
        .zip(starts)
        .map(|(facts, start)| {
            let rate_hz = facts.require_sample_rate()?;
            let (extended, prologue, rest_voltage_v) = extend(start, &facts.data.u)?;
            let mut v = vec![0.0; extended.len()];
            operator.simulate(&extended, Start::Rest { voltage_v: rest_voltage_v }, &mut v)?;
            Ok(HysteresisOutput { facts, v, rest: operator.polynomial_at(rest_voltage_v), prologue, rate_hz })
        })
        .collect()
}

impl HysteresisOutput<'_> {
    /// v counted from rest and delayed, y, and the mask of the record.
    pub(super) fn counted_from_rest(&self, delay_s: f64) -> (Vec<f64>, Vec<f64>, Option<Vec<bool>>) {
        let mut v: Vec<f64> = self.v.iter().map(|v| v - self.rest).collect();
        delay_in_place(&mut v, delay_s * self.rate_hz, 0.0);
        let v = v.split_off(self.prologue);
        (v, self.facts.data.y.clone(), self.facts.data.valid.clone())
    }

    /// [`Self::counted_from_rest`] with the prologue prepended, marked as not valid.
    pub(super) fn with_what_ran_before(&self, delay_s: f64) -> (Vec<f64>, Vec<f64>, Vec<bool>) {
        let mut v: Vec<f64> = self.v.iter().map(|v| v - self.rest).collect();
        delay_in_place(&mut v, delay_s * self.rate_hz, 0.0);
        let data = &self.facts.data;
        let mut y = vec![data.y[0]; self.prologue];
        y.extend_from_slice(&data.y);
        let mut valid = vec![false; self.prologue];
        match &data.valid {
            Some(own) => valid.extend_from_slice(own),
            None => valid.resize(y.len(), true),
        }
        (v, y, valid)
    }

    pub(super) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }
}

fn dynamic_records(
    outputs: &[HysteresisOutput<'_>],
    options: &Options,
) -> Result<Vec<DynamicRecord>, IdentifyError> {
    outputs
        .iter()
        .map(|o| {
            let scored = o.facts.scored(0);
            let held = options.demands.fixed(OFFSET);
            let y = o.facts.data.y.iter().map(|y| y - held.unwrap_or(0.0)).collect();
            Ok(DynamicRecord::new(
                &o.v,
                o.rest,
                o.prologue,
                y,
                scored,
                o.rate_hz,
                options.scheme(),
                options.inter_sample(),
                held.is_some(),
            )?)
        })
        .collect()
}

/// The block of a transfer function of the orders asked for.
pub(super) fn order(g: TransferFunction, options: &Options) -> Dynamics {
    match options.dynamics {
        DynamicsChoice::Integer => Dynamics::Integer(g),
        _ => Dynamics::Fractional(g),
    }
}

/// Identifies Eq. 13's structure; `integer` holds the orders at 2 and 1.
pub(super) fn identify_dynamic(
    outputs: &[HysteresisOutput<'_>],
    options: &Options,
    integer: bool,
    hysteresis: &ArticleOperator,
    engine: &mut Engine<'_, '_>,
) -> Result<DynamicStep, IdentifyError> {
    let fastest_hz = outputs.iter().map(|o| o.facts.highest_frequency_hz()).fold(0.0, f64::max);
    let rate_hz = outputs.iter().map(|o| o.rate_hz).fold(f64::INFINITY, f64::min);
    let eliminate = options.algorithm.as_ref().is_none_or(|a| a.name() == "least-squares");
    let mut space = BoxBuilder::new(&options.demands);
    // The flank of a resonance determines it even well above the fastest drive.
    let frequency = Range::logarithmic(
        "natural_frequency",
        (0.5 * fastest_hz).min(0.05 * rate_hz),
        (20.0 * fastest_hz).min(0.45 * rate_hz),
    );
    let gain = Range::linear("gain", 0.5, 1.5);
    let layout = DynamicLayout {
        gain: if eliminate { space.projected(gain) } else { space.searched(gain) },
        natural_frequency_hz: space.searched(frequency),
        damping: space.searched(Range::logarithmic("damping", 0.005, 20.0)),
        high_order: if integer {
            Role::Fixed(2.0)
        } else {
            space.searched(Range::linear("order2", 1.2, 2.6))
        },
        low_order: if integer {
            Role::Fixed(1.0)
        } else {
            space.searched(Range::linear("order1", 0.02, 1.6))
        },
        delay: match options.delay_s {
            Choice::Given(delay) => Role::Fixed(delay),
            Choice::Auto => {
                let longest = (LONGEST_DELAY_SAMPLES / rate_hz).max(LONGEST_DELAY_PERIODS / fastest_hz);
                space.searched(Range::linear("delay", 0.0, longest))
            }
        },
    };
    let bounds = space.finish();
    let guesses = guesses(&bounds, options);
    let kind = if integer { "integer" } else { "fractional" };
    let values = outputs.iter().flat_map(|o| o.v.iter().chain(&o.facts.data.y).map(|x| x.to_bits()));
    let identity = format!("{kind} {layout:?} {:x}", super::fingerprint(values));
    let problem = DynamicProblem::new(dynamic_records(outputs, options)?, layout.clone(), bounds, identity);
    let grown = |x: &[f64]| {
        let solution = problem.solve(x)?;
        let dynamics = order(solution.transfer_function(), options);
        shown(hysteresis, dynamics, solution.delay_s, options, outputs.first()?.facts)
    };
    let step = format!("dynamic block, {kind} order");
    let search = engine.search(&step, &problem, guesses, Some(&grown))?;
    let evaluations = search.outcome.evaluations;
    let solution =
        problem.solve(&search.outcome.best).ok_or(OptimizeError::NoFeasiblePoint { evaluations })?;
    Ok(DynamicStep { problem, layout, search, solution })
}

/// Starts: two resonances well above the drive, a heavily damped one near it, and the model to start from.
fn guesses(bounds: &Bounds, options: &Options) -> Vec<Vec<f64>> {
    let mut guesses = Vec::new();
    if let Some(model) = &options.start
        && let Dynamics::Fractional(g) | Dynamics::Integer(g) = &model.dynamics
        && let Ok(form) = g.second_order()
    {
        guesses.push(pick(bounds, |name| match name {
            "gain" => Some(form.gain),
            "natural_frequency" => Some(form.natural_frequency_hz),
            "damping" => Some(form.damping),
            "order2" => Some(form.alpha2),
            "order1" => Some(form.alpha1),
            "delay" => Some(model.delay_s),
            _ => None,
        }));
    }
    for (place, damping, order1) in [(0.7, 0.3, 1.0), (0.7, 0.1, 0.3), (0.4, 0.7, 1.0)] {
        guesses.push(pick(bounds, |name| match name {
            "gain" => Some(1.0),
            "natural_frequency" => {
                bounds.ranges.iter().find(|r| r.name == "natural_frequency").map(|r| r.from_unit(place))
            }
            "damping" => Some(damping),
            "order2" => Some(2.0),
            "order1" => Some(order1),
            "delay" => Some(0.0),
            _ => None,
        }));
    }
    guesses
}

/// This step's problem with every free parameter searched, at the solution: for standard errors.
pub(super) fn all_searched(
    step: &DynamicStep,
    outputs: &[HysteresisOutput<'_>],
    options: &Options,
) -> Result<(DynamicProblem, Vec<f64>), IdentifyError> {
    let DynamicSolution { form, delay_s } = &step.solution;
    let (mut x, mut ranges) = (Vec::new(), Vec::new());
    let mut role = |name: &str, was: Role, value: f64| match was {
        Role::Fixed(value) => Role::Fixed(value),
        _ => {
            x.push(value);
            let width = value.abs().max(1e-6);
            ranges.push(Range::linear(name, value - width, value + width));
            Role::Searched(x.len() - 1)
        }
    };
    let layout = DynamicLayout {
        gain: role("gain", step.layout.gain, form.gain),
        natural_frequency_hz: role(
            "natural_frequency",
            step.layout.natural_frequency_hz,
            form.natural_frequency_hz,
        ),
        damping: role("damping", step.layout.damping, form.damping),
        high_order: role("order2", step.layout.high_order, form.alpha2),
        low_order: role("order1", step.layout.low_order, form.alpha1),
        delay: role("delay", step.layout.delay, *delay_s),
    };
    let records = dynamic_records(outputs, options)?;
    Ok((DynamicProblem::new(records, layout, Bounds { ranges }, String::new()), x))
}

/// The transfer function at the search vector `x` of [`all_searched`], for the delta method.
pub(super) fn transfer_function_at(problem: &DynamicProblem, x: &[f64]) -> Option<TransferFunction> {
    problem.candidate(x)?.form.to_transfer_function().ok()
}

impl DynamicStep {
    /// Bounds searched, for the report.
    pub(super) fn bounds(&self) -> &Bounds {
        self.problem.bounds()
    }
}
