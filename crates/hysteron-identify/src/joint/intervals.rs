//! 95 % intervals of the parameters of a joint fit: by the standard error where the sum of squares is
//! quadratic, by profile likelihood where it is not.

use super::super::layout::Role;
use super::super::normal::NORMAL_975;
use super::knowledge::{Covariance, Knowledge};
use super::problem::{JointProblem, JointWorkspace};
use super::profile::{Fit, Optimum, Profiled};
use super::record::JointRecord;
use hysteron_optimize::Stop;
use hysteron_optimize::{LeastSquaresProblem, Problem};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Standard errors along the tangent of the valley at which z is checked, and its relative departure above
/// which a profile is computed.
const LOOK_AT: f64 = 2.0;
const DEPARTURE: f64 = 0.1;
/// Budget, in residuals differentiated with respect to one parameter: about a second. A count instead of a
/// time makes the result the same on every machine.
const WORK: usize = 20_000_000;
/// Cost of a simulation and of a typical profile, in linearisations.
const SIMULATION: f64 = 0.4;
const PROFILE: f64 = 12.0;
/// Least and largest number of linearisations for one end of an interval.
const STEPS: [f64; 2] = [18.0, 60.0];
/// Cost of a residual of a record on time stamps over that of a uniform one, simulated by FFT.
const ON_STAMPS: usize = 4;
/// Samples of the drive for a residual whose simulation is part of its cost, and samples beyond them that cost as
/// much as one residual differentiated with respect to one parameter.
const OF_DRIVE: usize = 8;
const BEYOND: usize = 2;

/// A 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interval {
    /// Lower end, in the parameter's unit.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Method that gave it.
    pub method: IntervalMethod,
}

/// Method that gave an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalMethod {
    /// 1.96 standard errors to each side; the fit is linear enough in this parameter (checked at two standard
    /// errors).
    Quadratic,
    /// Profile likelihood: the sum of squares is not quadratic in this parameter.
    Profile,
    /// 1.96 standard errors of the logarithm, for a positive coefficient that depends on others as a power.
    Logarithmic,
    /// 1.96 standard errors to each side, not checked: the record is too long, or the profile has no end.
    Unchecked,
}

impl IntervalMethod {
    /// `quadratic`, `profile`, `logarithmic` or `unchecked`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quadratic => "quadratic",
            Self::Profile => "profile",
            Self::Logarithmic => "logarithmic",
            Self::Unchecked => "unchecked",
        }
    }
}

impl Interval {
    pub(in super::super) fn symmetric(value: f64, std_error: f64, method: IntervalMethod) -> Self {
        Self { low: value - NORMAL_975 * std_error, high: value + NORMAL_975 * std_error, method }
    }

    /// Interval of a positive value on a logarithmic scale.
    pub(in super::super) fn logarithmic(value: f64, std_error: f64) -> Self {
        let factor = (NORMAL_975 * std_error / value).exp();
        Self { low: value / factor, high: value * factor, method: IntervalMethod::Logarithmic }
    }
}

/// Intervals of all parameters with a standard error in `whole`, in its order and symbols (unit-α). The
/// curvature of the sum of squares is that of `problem`, which may be reduced, at its own optimum `known`.
/// Intervals cut short by `stop` stay unchecked.
pub(in super::super) fn intervals(
    problem: &JointProblem,
    known: &Knowledge,
    whole: &Covariance,
    stop: &Stop,
) -> Vec<Option<Interval>> {
    let errors: Vec<Option<f64>> = (0..whole.values.len()).map(|j| whole.std_error(j)).collect();
    let unchecked = |(error, &value): (&Option<f64>, &f64)| {
        error.map(|error| Interval::symmetric(value, error, IntervalMethod::Unchecked))
    };
    let mut found: Vec<Option<Interval>> = errors.iter().zip(&whole.values).map(unchecked).collect();
    // Weights at zero are not parameters: where thinned and whole records differ in these, the profiles do
    // not carry over.
    if known.covariance.names != whole.names {
        return found;
    }
    let at = &known.covariance.values;
    // Parameters at a bound may leave it.
    let free: Vec<usize> = (0..at.len()).filter(|&j| known.covariance.matrix[(j, j)] > 0.0).collect();
    let square = known.linearisation.residuals.iter().map(|r| r * r).sum();
    let optimum = Optimum { at, square, free: &free };
    let directions: Vec<Vec<f64>> = (0..at.len())
        .map(|j| known.white.column(j).iter().map(|c| c / known.white[(j, j)]).collect())
        .collect();
    let profiled = |j: usize| {
        let std_error = known.covariance.std_error(j)?;
        let ratio = known.covariance.matrix[(j, j)] / known.white[(j, j)];
        let unit = known.variance * ratio;
        (unit > 0.0).then_some(Profiled { parameter: j, std_error, unit, direction: &directions[j] })
    };
    let whole_fit =
        || WholeProblem { problem, eliminated: &known.linearisation.eliminated, ws: problem.workspace() };
    let a_row = if problem.records().iter().any(JointRecord::is_on_stamps) { ON_STAMPS } else { 1 };
    let drive: usize = problem.records().iter().map(JointRecord::drive_samples).sum();
    let beyond = drive.saturating_sub(OF_DRIVE * problem.residual_count()) / BEYOND;
    let linearisation = problem.residual_count() * at.len() * a_row + beyond;
    let left = WORK as f64 / linearisation.max(1) as f64;
    let mut curved: Vec<(f64, usize)> = Vec::new();
    let mut looked_at: Vec<(usize, Profiled<'_>)> =
        (0..at.len()).filter_map(|j| found[j].and(profiled(j)).map(|profiled| (j, profiled))).collect();
    looked_at.truncate((left / (2.0 * SIMULATION)) as usize);
    let left = left - 2.0 * SIMULATION * looked_at.len() as f64;
    let a_thread = looked_at.len().div_ceil(rayon::current_num_threads()).max(1);
    let departures: Vec<f64> = looked_at
        .par_chunks(a_thread)
        .flat_map_iter(|some| {
            let mut fit = whole_fit();
            let departure = |(_, profiled): &(usize, Profiled<'_>)| {
                if stop.is_requested() {
                    return [f64::INFINITY; 2];
                }
                [-LOOK_AT, LOOK_AT]
                    .map(|steps| (profiled.along_valley(&mut fit, &optimum, steps) / steps - 1.0).abs())
            };
            some.iter().map(departure).map(|sides| sides[0].max(sides[1])).collect::<Vec<f64>>()
        })
        .collect();
    for (&(j, _), departure) in looked_at.iter().zip(departures) {
        if departure > DEPARTURE {
            curved.push((departure, j));
        } else if let Some(found) = &mut found[j] {
            found.method = IntervalMethod::Quadratic;
        }
    }
    // The most nonlinear first, within the budget.
    curved.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    curved.truncate((left / PROFILE) as usize);
    if stop.is_requested() {
        return found;
    }
    let [least, most] = STEPS;
    let steps = (0.5 * left / curved.len().max(1) as f64).clamp(least, most) as usize;
    let profiles: Vec<Option<Interval>> = curved
        .par_iter()
        .map(|&(_, j)| {
            let (profiled, error) = (profiled(j)?, errors[j]?);
            let end = |side| profiled.end(&mut whole_fit(), &optimum, (side, NORMAL_975), steps);
            let (low, high) = rayon::join(|| end(-1.0), || end(1.0));
            // Transferred from optimum and errors of the reduced records to those of all samples.
            let moved = |end: f64| whole.values[j] + (end - at[j]) * error / profiled.std_error;
            Some(Interval { low: moved(low?), high: moved(high?), method: IntervalMethod::Profile })
        })
        .collect();
    for (&(_, j), profile) in curved.iter().zip(profiles) {
        found[j] = profile.or(found[j]);
    }
    found
}

/// A joint problem in all of its parameters: the eliminated coefficients, then the searched numbers.
struct WholeProblem<'a> {
    problem: &'a JointProblem,
    eliminated: &'a [usize],
    ws: JointWorkspace,
}

impl WholeProblem<'_> {
    /// Search vector, and all coefficients of u, u², … and α.
    fn split<'p>(&self, p: &'p [f64]) -> (&'p [f64], Vec<f64>) {
        let (eliminated, x) = p.split_at(self.eliminated.len());
        let layout = self.problem.layout();
        let mut next = eliminated.iter();
        let coefficients = layout
            .linear()
            .map(|role: &Role| role.value(x).or_else(|| next.next().copied()).unwrap_or(0.0))
            .collect();
        (x, coefficients)
    }
}

impl Fit for WholeProblem<'_> {
    fn linearise(&mut self, p: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        let (x, coefficients) = self.split(p);
        let linearisation = self.problem.linearise_at(x, &coefficients, &mut self.ws)?;
        let mut columns = linearisation.linear;
        columns.extend(linearisation.searched);
        Some((linearisation.residuals, columns))
    }

    fn square(&mut self, p: &[f64]) -> Option<f64> {
        let (x, coefficients) = self.split(p);
        let residuals = self.problem.residuals_at(x, &coefficients, &mut self.ws);
        let square: f64 = residuals.iter().map(|r| r * r).sum();
        (!residuals.is_empty() && square.is_finite()).then_some(square)
    }

    fn range(&self, parameter: usize) -> (f64, f64) {
        match parameter.checked_sub(self.eliminated.len()).and_then(|j| self.problem.bounds().ranges.get(j)) {
            Some(range) => (range.low, range.high),
            None => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::drive::Thinning;
    use super::super::knowledge::knowledge;
    use super::super::parameter_layout::JointLayout;
    use super::super::record::{Clock, Ingredients};
    use super::*;
    use hysteron_model::Start;
    use hysteron_model::dynamics::{Creep, DynamicForm, Modes, Sampling, Scheme};
    use hysteron_model::hysteresis::HysteresisForm;
    use hysteron_optimize::{Bounds, Stop};
    use rand::Rng;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    #[test]
    fn of_a_gain_is_that_of_a_straight_line() {
        // y = 3 + 2 u + white noise.
        let drive: Vec<f64> = (0..800).map(|k| 5.0 + 4.0 * (f64::from(k) * 0.037).sin()).collect();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let output: Vec<f64> = drive
            .iter()
            .map(|u| 3.0 + 2.0 * u + (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64)
            .collect();
        let record = JointRecord::new(
            Ingredients {
                drive: &drive,
                thinning: Thinning::Pick(1),
                factor: 1,
                every: 1,
                output: output.clone(),
                weighting: vec![1.0; drive.len()].into(),
                before: Start::Remembering { voltage_v: drive[0], memory: () },
                transients: false,
                offset_is_held: false,
                nuisance: Vec::new(),
                cycles: 1,
                degree: 1,
                clock: Clock::Rate(1000.0),
                scheme: Scheme::Tustin,
                sampling: Sampling::of(Scheme::Tustin),
            },
            &Stop::new(),
        )
        .unwrap();
        let layout = JointLayout {
            polynomial: vec![Role::Projected],
            weights: vec![Role::Fixed(0.0)],
            shape: [0.5, 0.1, 1.0].map(Role::Fixed).into(),
            form: Vec::new(),
            delay: Role::Fixed(0.0),
            memory: vec![Role::Fixed(0.0)],
        };
        let form = DynamicForm { modes: Modes::None, creep: Creep::None };
        let problem = JointProblem::new(
            vec![record].into(),
            (HysteresisForm::default(), form),
            layout,
            Bounds { ranges: Vec::new() },
            String::new(),
        );
        let known = knowledge(&problem, &[]).unwrap();

        // By the textbook.
        let n = drive.len() as f64;
        let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
        let (u0, y0) = (mean(&drive), mean(&output));
        let square: f64 = drive.iter().map(|u| (u - u0).powi(2)).sum();
        let slope = drive.iter().zip(&output).map(|(u, y)| (u - u0) * (y - y0)).sum::<f64>() / square;
        let left: f64 = drive.iter().zip(&output).map(|(u, y)| (y - y0 - slope * (u - u0)).powi(2)).sum();
        let variance = left / (n - 2.0) / square;
        assert!((known.white[(0, 0)] / variance - 1.0).abs() < 1e-9);
        // For white noise the two errors agree within chance.
        let error = known.covariance.std_error(0).unwrap();
        assert!((error / variance.sqrt() - 1.0).abs() < 0.15, "{error} {}", variance.sqrt());

        let [Some(interval)] = intervals(&problem, &known, &known.covariance, &Stop::new())[..] else {
            panic!()
        };
        assert_eq!(interval.method, IntervalMethod::Quadratic);
        assert!((interval.high - (slope + 1.96 * error)).abs() < 1e-4 * error);
        assert!((interval.low - (slope - 1.96 * error)).abs() < 1e-4 * error);
        assert!(interval.low < 2.0 && 2.0 < interval.high);
    }

    #[test]
    fn of_a_coefficient_that_must_be_positive_is_symmetric_in_its_logarithm() {
        let interval = Interval::logarithmic(100.0, 10.0);
        assert!((interval.low * interval.high - 1e4).abs() < 1e-9);
        assert!((interval.high / 100.0 - (0.196f64).exp()).abs() < 1e-4);
    }
}
