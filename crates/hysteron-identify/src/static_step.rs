//! Step 1 in practice: choice of start and degree, test for delay and lag, then the search.

use super::engine::{Engine, Search};
use super::layout::{BoxBuilder, Demands, Role};
use super::options::{Choice, DynamicsChoice, Options};
use super::shown::shown;
use super::static_problem::{StaticLayout, StaticProblem, StaticRecord, StaticSolution};
use super::uncertainty::correlation_time;
use super::{DegreeTried, IdentifyError, RecordFacts};
use hysteron_model::Start;
use hysteron_model::dynamics::{Dynamics, Scheme};
use hysteron_model::hammerstein::extend;
use hysteron_model::hysteresis::ArticleOperator;
use hysteron_model::model_file::polynomial_name;
use hysteron_optimize::{Bounds, LeastSquaresProblem, OptimizeError, Problem, Range};

/// Highest degree tried when the degree is chosen from the data: one loop cannot justify more.
pub(super) const HIGHEST_AUTOMATIC_DEGREE: usize = 5;
/// Evidence asked for one more degree: a fall of BIC by 10 ("very strong", Kass & Raftery 1995,
/// doi:10.1080/01621459.1995.10476572).
pub const BIC_FALL: f64 = 10.0;
/// An initial step above this share of the drive's range is a start from rest that excites the dynamics.
const JUMP: f64 = 0.02;
/// Longest delay and lag searched, as a share of the period (or of the record).
const LONGEST_SHIFT: f64 = 0.1;

/// Name under which the offset of every record can be held (`--fix offset=0`: the sensor's zero is right).
pub(super) const OFFSET: &str = "offset";

/// Result of the static step.
pub(super) struct StaticStep {
    pub(super) problem: StaticProblem,
    pub(super) layout: StaticLayout,
    pub(super) search: Search,
    pub(super) solution: StaticSolution,
    /// Start of each record.
    pub(super) starts: Vec<Start>,
    /// Delay and lag were searched in this step.
    pub(super) shift_searched: bool,
    /// Degrees tried: degree, RMSE \[µm\], BIC.
    pub(super) degrees: Vec<DegreeTried>,
    /// Samples left out at the start of each record because a static model cannot follow its start.
    pub(super) left_out: Vec<usize>,
}

/// Scales of the data that the search box is made from.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub(super) range_v: f64,
    pub(super) largest_v: f64,
    pub(super) slope: f64,
    shortest_period_s: f64,
    sample_period_s: Option<f64>,
}

pub(super) fn identify_static(
    records: &[&RecordFacts],
    options: &Options,
    dynamics_follow: bool,
    engine: &mut Engine<'_, '_>,
) -> Result<StaticStep, IdentifyError> {
    let scales = Scales::of(records);
    let starts: Vec<Start> =
        records.iter().map(|facts| choose_start(facts, options, engine)).collect::<Result<_, _>>()?;
    let jumps = records.iter().zip(&starts).any(|(facts, start)| jump_share(facts, start) > JUMP);
    let sampled = records.iter().all(|facts| facts.data.sample_rate_hz().is_some());
    let lag_wanted = match options.dynamics {
        DynamicsChoice::None => false,
        DynamicsChoice::Auto => options.delay_s == Choice::Auto,
        _ => true,
    };
    let shift = Shift {
        delay: sampled && jumps && !dynamics_follow && options.delay_s == Choice::Auto,
        lag: sampled && jumps && !dynamics_follow && lag_wanted,
    };
    let left_out: Vec<usize> =
        records.iter().zip(&starts).map(|(facts, start)| left_out(facts, start, shift)).collect();
    let prepared: Vec<StaticRecord> = records
        .iter()
        .zip(&starts)
        .zip(&left_out)
        .map(|((facts, start), &left_out)| {
            prepare(facts, start, left_out, options.demands.fixed(OFFSET), options.scheme())
        })
        .collect::<Result<_, _>>()?;
    let setup = Setup { records: &prepared, scales: &scales, options, shift };

    let mut degrees = Vec::new();
    let degree = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => choose_degree(&setup, records, engine, &mut degrees)?,
    };
    let elimination = options.algorithm.as_ref().is_none_or(|a| a.name() == "least-squares");
    let (problem, layout) = setup.problem(degree, elimination)?;
    let guesses = setup.guesses(&problem, &layout);
    let grown = |x: &[f64]| {
        let solution = problem.solve(x)?;
        shown(&solution.hysteresis, Dynamics::None, solution.delay_s, options, records.first()?)
    };
    let search = engine.search(&format!("static block, degree {degree}"), &problem, guesses, Some(&grown))?;
    let solution = problem
        .solve(&search.outcome.best)
        .ok_or(OptimizeError::NoFeasiblePoint { evaluations: search.outcome.evaluations })?;
    let shift_searched = shift.delay || shift.lag;
    Ok(StaticStep { problem, layout, search, solution, starts, shift_searched, degrees, left_out })
}

/// Samples at the start of a record without information on the static block: a rest before the drive moves
/// (with unknown hysteresis memory), and a jump that only a model with lag can follow.
fn left_out(facts: &RecordFacts, start: &Start, shift: Shift) -> usize {
    let rest = facts.samples_at_rest();
    let jumps = if rest > 0 { facts.jumps_after_rest(JUMP) } else { jump_share(facts, start) > JUMP };
    if jumps && !shift.lag { rest + facts.settling_samples() } else { rest }
}

#[derive(Clone, Copy)]
pub(super) struct Shift {
    pub(super) delay: bool,
    pub(super) lag: bool,
}

/// Everything that a static problem of any degree is made from.
pub(super) struct Setup<'a> {
    pub(super) records: &'a [StaticRecord],
    pub(super) scales: &'a Scales,
    pub(super) options: &'a Options,
    pub(super) shift: Shift,
}

impl Scales {
    pub(super) fn of(records: &[&RecordFacts]) -> Self {
        let fold = |f: fn(f64, f64) -> f64, start: f64, pick: fn(&RecordFacts) -> &[f64]| {
            records.iter().flat_map(|r| pick(r).iter().copied()).fold(start, f)
        };
        let (low, high) =
            (fold(f64::min, f64::INFINITY, |r| &r.data.u), fold(f64::max, f64::NEG_INFINITY, |r| &r.data.u));
        let stroke = records.iter().map(|r| r.stroke()).fold(0.0, f64::max);
        let range_v = high - low;
        Self {
            range_v,
            largest_v: high.abs().max(low.abs()),
            slope: stroke / range_v,
            shortest_period_s: records.iter().map(|r| r.period_s()).fold(f64::INFINITY, f64::min),
            sample_period_s: records
                .iter()
                .filter_map(|r| r.data.sample_rate_hz())
                .map(f64::recip)
                .reduce(f64::max),
        }
    }
}

/// Share of the drive's range by which the first sample lies off the rest voltage.
pub(super) fn jump_share(facts: &RecordFacts, start: &Start) -> f64 {
    match *start {
        Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => {
            (facts.data.u[0] - voltage_v).abs() / facts.range_v()
        }
        Start::Settled { .. } | Start::AsIdentified => 0.0,
    }
}

/// Chooses the start that explains the record best: at rest at u(0), at rest at 0 V, or settled on the
/// repeating drive.
pub(super) fn choose_start(
    facts: &RecordFacts,
    options: &Options,
    engine: &mut Engine<'_, '_>,
) -> Result<Start, IdentifyError> {
    let scales = &Scales::of(&[facts]);
    let first = facts.data.u[0];
    let mut candidates = vec![Start::Rest { voltage_v: first }];
    if first.abs() > JUMP * facts.range_v() {
        candidates.push(Start::Rest { voltage_v: 0.0 });
    }
    if let Some(period_samples) = facts.period_samples() {
        candidates.push(Start::settled(period_samples));
    }
    let mut best = (f64::INFINITY, candidates[0]);
    for (index, &start) in candidates.iter().enumerate() {
        if candidates.len() == 1 {
            break;
        }
        let sampled = facts.data.sample_rate_hz().is_some();
        let shift = Shift { delay: sampled, lag: sampled };
        let records = [prepare(facts, &start, 0, None, options.scheme())?.thinned(thinning(facts))];
        let free = Options {
            degree: Choice::Auto,
            n: Choice::Given(1.0),
            demands: Demands::default(),
            delay_s: Choice::Auto,
            start: None,
            ..options.clone()
        };
        let setup = Setup { records: &records, scales, options: &free, shift };
        let (problem, layout) = setup.problem(3, true)?;
        let guesses = setup.guesses(&problem, &layout);
        let name = format!("start of {}, {index}", facts.data.name);
        match engine.quick_fit(&name, &problem, guesses) {
            Ok(search) if search.outcome.cost < best.0 => best = (search.outcome.cost, start),
            // A start that cannot be simulated is discarded.
            Ok(_) | Err(OptimizeError::NoFeasiblePoint { .. }) => {}
            Err(other) => return Err(other.into()),
        }
    }
    Ok(best.1)
}

/// Thinning factor for comparing starts: at least 4000 samples in the record and 100 in a swing, and a
/// divisor of the period.
fn thinning(facts: &RecordFacts) -> usize {
    let most = (facts.data.u.len() / 4000).min(facts.shortest_swing / 100).max(1);
    let period = facts.period_samples().unwrap_or(0);
    (1..=most).rev().find(|&factor| period.is_multiple_of(factor)).unwrap_or(1)
}

pub(super) fn prepare(
    facts: &RecordFacts,
    start: &Start,
    left_out: usize,
    held_offset: Option<f64>,
    scheme: Scheme,
) -> Result<StaticRecord, IdentifyError> {
    let (extended, prologue, rest_voltage_v) = extend(start, &facts.data.u)?;
    Ok(StaticRecord {
        input: extended.into_owned(),
        prologue,
        rest_voltage_v,
        output: facts.data.y.iter().map(|y| y - held_offset.unwrap_or(0.0)).collect(),
        scored: facts.scored(left_out),
        sample_rate_hz: facts.data.sample_rate_hz(),
        scheme,
        creep: held_offset.is_none() && facts.whole_periods() >= 3,
        held_offset,
    })
}

impl Setup<'_> {
    /// The problem of this polynomial degree; `eliminate`: linear parameters are projected out.
    pub(super) fn problem(
        &self,
        degree: usize,
        eliminate: bool,
    ) -> Result<(StaticProblem, StaticLayout), IdentifyError> {
        let Scales { range_v, largest_v, slope, .. } = *self.scales;
        let demands = &self.options.demands;
        let mut space = BoxBuilder::new(demands);
        let linear = |name: &str, low: f64, high: f64| Range::linear(name, low, high);
        // The loop's half width is about α/β: with β over 20 / range the loop is a pure offset switch.
        let steepest = 20.0 / range_v;
        // Shape parameters demanded in the article's symbols need a known α.
        let demanded = ["beta", "gamma"].iter().any(|n| demands.names().any(|d| d == *n));
        let mut polynomial = Vec::with_capacity(degree);
        for power in 1..=degree {
            let unit = slope.abs() / largest_v.powi(power as i32 - 1);
            let (low, high) = if power == 1 {
                (slope.min(0.0) * 3.0 - slope.abs(), slope.max(0.0) * 3.0 + slope.abs())
            } else {
                (-2.0 * unit, 2.0 * unit)
            };
            let range = linear(&polynomial_name(power), low, high);
            polynomial.push(if eliminate { space.projected(range) } else { space.searched(range) });
        }
        let range = linear("alpha", -2.0 * slope.abs(), 2.0 * slope.abs());
        let alpha = if eliminate && !demanded { space.projected(range) } else { space.searched(range) };
        let n = match self.options.n {
            Choice::Given(n) if demands.bounded("n").is_none() => {
                Role::Fixed(demands.fixed("n").unwrap_or(n))
            }
            _ => space.searched(linear("n", 1.0, 4.0)),
        };
        // In the unit-α form β' has the dimension 1/V^n; in the article's symbols β = β' |α|^(1−n).
        let exponent = n.value(&[]).unwrap_or(1.0);
        let scale =
            if alpha == Role::Projected { steepest } else { steepest * slope.abs().powf(1.0 - exponent) };
        let beta = space.searched(linear("beta", 0.0, scale));
        let gamma = space.searched(linear("gamma", -scale, scale));
        let longest = LONGEST_SHIFT * self.scales.shortest_period_s;
        let shortest = self.scales.sample_period_s.unwrap_or(0.0);
        let delay = match (self.shift.delay, self.options.delay_s) {
            (true, _) => space.searched(linear("delay", 0.0, longest.max(10.0 * shortest))),
            (false, Choice::Given(delay)) => Role::Fixed(delay),
            (false, Choice::Auto) => Role::Fixed(demands.fixed("delay").unwrap_or(0.0)),
        };
        let lag = if self.shift.lag {
            space.searched(Range::logarithmic("lag", 0.02 * shortest, longest.max(20.0 * shortest)))
        } else {
            Role::Fixed(0.0)
        };
        let layout = StaticLayout { polynomial, alpha, beta, gamma, n, delay, lag };
        let identity = format!("static {degree} {layout:?} {:x}", fingerprint(self.records));
        Ok((StaticProblem::new(self.records.to_vec(), layout.clone(), space.finish(), identity), layout))
    }

    /// Data-driven starts: loops of moderate width, and the model to start from.
    fn guesses(&self, problem: &StaticProblem, layout: &StaticLayout) -> Vec<Vec<f64>> {
        let bounds = problem.bounds();
        let middle = |range: &Range| range.from_unit(0.5);
        let mut guesses = Vec::new();
        if let Some(model) = &self.options.start
            && let Some(b) = ArticleOperator::of(&model.hysteresis)
        {
            let unit = b.unit_shape();
            let (beta, gamma) =
                if layout.alpha == Role::Projected { (unit.beta, unit.gamma) } else { (b.beta, b.gamma) };
            guesses.push(
                bounds
                    .ranges
                    .iter()
                    .map(|range| match range.name.as_str() {
                        "alpha" => b.alpha,
                        "beta" => beta,
                        "gamma" => gamma,
                        "n" => b.n,
                        "delay" => model.delay_s,
                        name => (1..=b.polynomial.len())
                            .find(|&i| polynomial_name(i) == name)
                            .map_or_else(|| middle(range), |i| b.polynomial[i - 1]),
                    })
                    .collect(),
            );
        }
        for width in [1.0, 3.0] {
            guesses.push(
                bounds
                    .ranges
                    .iter()
                    .map(|range| match range.name.as_str() {
                        "linear" => self.scales.slope,
                        "alpha" => 0.3 * self.scales.slope,
                        "beta" => width * range.high / 20.0,
                        "gamma" => 0.2 * width * range.high / 20.0,
                        "n" => 1.2,
                        "delay" => self.scales.sample_period_s.unwrap_or(0.0).min(range.high),
                        _ => middle(range),
                    })
                    .collect(),
            );
        }
        guesses
    }
}

/// Degree by BIC over the independent samples: repeats of one loop are not new data.
fn choose_degree(
    setup: &Setup<'_>,
    records: &[&RecordFacts],
    engine: &mut Engine<'_, '_>,
    tried: &mut Vec<DegreeTried>,
) -> Result<usize, IdentifyError> {
    let demanded = (1..=super::HIGHEST_DEGREE)
        .filter(|&d| setup.options.demands.names().any(|n| n == polynomial_name(d)))
        .max()
        .unwrap_or(1);
    let mut fits = Vec::new();
    let mut time: f64 = 1.0;
    for degree in 1..=HIGHEST_AUTOMATIC_DEGREE.max(demanded) {
        let (problem, layout) = setup.problem(degree, true)?;
        let guesses = setup.guesses(&problem, &layout);
        let search = engine.quick_fit(&format!("degree {degree}"), &problem, guesses)?;
        let mut residual = vec![0.0; problem.residual_count()];
        problem.residuals(&search.outcome.best, &mut problem.workspace(), &mut residual);
        time = correlation_time(&residual);
        let admissible =
            problem.solve(&search.outcome.best).is_some_and(|s| s.hysteresis.admissibility().is_bounded());
        fits.push((degree, search.outcome.cost, problem.bounds().dimension() + degree + 1, admissible));
    }
    let samples: usize = setup.records.iter().map(|r| r.scored.len()).sum();
    let distinct: usize = records
        .iter()
        .zip(setup.records)
        .map(|(facts, record)| facts.period_samples().unwrap_or(usize::MAX).min(record.scored.len()))
        .sum();
    // `time` is the correlation time of the richest fit, whose residual is the least structured.
    let information = (samples as f64 / time).min(distinct as f64).max(2.0);
    let bic = |cost: f64, parameters: usize| {
        information * (cost * cost).max(f64::MIN_POSITIVE).ln() + parameters as f64 * information.ln()
    };
    let mut chosen: Option<(usize, f64, bool)> = None;
    for &(degree, cost, parameters, admissible) in &fits {
        let score = bic(cost, parameters);
        tried.push(DegreeTried {
            degree,
            rmse: cost,
            bic: score,
            is_demanded: degree <= demanded && demanded > 1,
            is_bounded: admissible,
        });
        let better = match chosen {
            None => true,
            Some((_, best, was_admissible)) => score < best - BIC_FALL && (admissible || !was_admissible),
        };
        if better || degree <= demanded {
            chosen = Some((degree, score, admissible));
        }
    }
    Ok(chosen.map_or(demanded, |(degree, ..)| degree))
}

/// FNV-1a over the bits of the records: detects a checkpoint of other data.
fn fingerprint(records: &[StaticRecord]) -> u64 {
    let values = records.iter().flat_map(|r| {
        r.input.iter().chain(&r.output).map(|x| x.to_bits()).chain(r.scored.iter().map(|&k| k as u64))
    });
    super::fingerprint(values)
}

/// This step's problem with every free parameter searched in the article's symbols, at `solution`: for
/// standard errors.
pub(super) fn in_article_symbols(
    step: &StaticStep,
    records: &[&RecordFacts],
    options: &Options,
) -> Result<(StaticProblem, Vec<f64>), IdentifyError> {
    let demands = &options.demands;
    let StaticSolution { hysteresis: b, delay_s, lag_s, .. } = &step.solution;
    let mut x = Vec::new();
    let mut ranges = Vec::new();
    let mut role = |name: &str, was: Role, value: f64| match was {
        Role::Fixed(value) => Role::Fixed(value),
        _ if demands.fixed(name).is_some() => Role::Fixed(value),
        _ => {
            x.push(value);
            let width = value.abs().max(1e-3);
            ranges.push(Range::linear(name, value - width, value + width));
            Role::Searched(x.len() - 1)
        }
    };
    let layout = StaticLayout {
        polynomial: b
            .polynomial
            .iter()
            .enumerate()
            .map(|(i, &c)| role(&polynomial_name(i + 1), step.layout.polynomial[i], c))
            .collect(),
        alpha: role("alpha", step.layout.alpha, b.alpha),
        beta: role("beta", step.layout.beta, b.beta),
        gamma: role("gamma", step.layout.gamma, b.gamma),
        n: role("n", step.layout.n, b.n),
        delay: role("delay", step.layout.delay, *delay_s),
        lag: role("lag", step.layout.lag, *lag_s),
    };
    let prepared = records
        .iter()
        .zip(&step.starts)
        .zip(&step.left_out)
        .map(|((facts, start), &left_out)| {
            prepare(facts, start, left_out, demands.fixed(OFFSET), options.scheme())
        })
        .collect::<Result<_, _>>()?;
    Ok((StaticProblem::new(prepared, layout, Bounds { ranges }, String::new()), x))
}
