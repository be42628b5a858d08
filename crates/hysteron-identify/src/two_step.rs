//! The article's two-step identification (§4.3): (1) hysteresis block from the quasi-static records, (2) its
//! output drives the dynamic block, identified on the dynamic records, orders and coefficients at once.

use super::campaign::{excited, has_second_step, of_role};
use super::dynamic_step::{self, DynamicStep, HysteresisOutput};
use super::engine::{Engine, Search};
use super::linear_step::LinearStep;
use super::options::{Choice, DynamicsChoice, Method, Options, RecordRole};
use super::parameter::{Equation13, Parameter, ParameterRole};
use super::result::{Correlation, Identification, RecordFit, StructureChoice};
use super::sines::SineResponse;
use super::static_step::{self, OFFSET, StaticStep};
use super::uncertainty::{correlation, covariance, standard_error};
use super::watch::Plan;
use super::{Covariance, IdentifyError, RecordFacts, findings};
use super::{Finding, FindingKind};
use hysteron_model::Start;
use hysteron_model::dynamics::Creep;
use hysteron_model::dynamics::arx::{ArxRecord, ArxSearch, OrderCriterion, select_orders};
use hysteron_model::dynamics::{Arx, DynamicForm, Dynamics, Modes, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{ArticleOperator, Hysteresis};
use hysteron_model::model_file::polynomial_name;
use hysteron_model::validate::{Scoring, score};
use hysteron_optimize::{Bounds, Problem};

/// Stages of the article's two steps.
pub(super) const PLAN: Plan =
    Plan(&[("start of", 0.05), ("degree", 0.10), ("static block", 0.40), ("dynamic block", 0.45)]);

/// Identifies one block after the other. A campaign of quasi-static records alone has no second step.
pub(super) fn identify(
    facts: &[RecordFacts],
    roles: &[RecordRole],
    options: &Options,
    mut engine: Engine<'_, '_>,
) -> Result<Identification, IdentifyError> {
    let dynamic = of_role(facts, roles, RecordRole::Dynamic);
    let quasi_static = of_role(facts, roles, RecordRole::QuasiStatic);
    let static_records = if quasi_static.is_empty() { dynamic.clone() } else { quasi_static };
    let follow = has_second_step(roles, options);
    check_demands(options, follow)?;
    let step1 = static_step::identify_static(&static_records, options, follow, &mut engine)?;
    let mut dynamic_starts = Vec::new();
    for facts in &dynamic {
        dynamic_starts.push(static_step::choose_start(facts, options, &mut engine)?);
    }
    // Only the second step needs one sample rate for all records.
    let outputs = if follow {
        dynamic_step::hysteresis_outputs(&step1.solution.hysteresis, &dynamic, &dynamic_starts)?
    } else {
        Vec::new()
    };
    let step2 = match (follow, options.dynamics) {
        (false, DynamicsChoice::None | DynamicsChoice::Auto) => Step2::None,
        (false, wanted) if step1.solution.lag_s > 0.0 && wanted == DynamicsChoice::Integer => Step2::None,
        (false, wanted) => {
            return Err(IdentifyError::NoDynamicInformation {
                wanted: wanted.name(),
                because:
                    "the campaign holds quasi-static records only; add a sweep or sines well above their \
                          frequency, or name the record that is one"
                        .into(),
            });
        }
        (true, DynamicsChoice::Arx) => Step2::Arx(fit_arx(&outputs, step1.solution.delay_s)?),
        (true, wanted) if wanted.takes_two_steps() => {
            Step2::Linear(Box::new(LinearStep::fit(&outputs, step1.solution.delay_s, options)?))
        }
        (true, DynamicsChoice::Integer) => {
            Step2::integer_order(&outputs, options, true, &step1.solution.hysteresis, &mut engine)?
        }
        (true, _) => Step2::integer_order(&outputs, options, false, &step1.solution.hysteresis, &mut engine)?,
    };

    let mut model = assemble(&step1, &step2, &static_records, &dynamic, options);
    if options.demands.fixed(OFFSET).is_none() {
        settle_offset(&mut model, &step1, static_records[0])?;
    }
    let EstimatedParameters { parameters, correlations, of_numbers } =
        parameters(&step1, &step2, &static_records, &outputs, options)?;
    let mut fits = Vec::new();
    for (facts, role) in facts.iter().zip(roles) {
        let start = start_of(facts, &static_records, &step1, &dynamic, &dynamic_starts);
        let simulated = model.simulate_at_own_rate(&facts.data.u, &facts.data.time, &start)?;
        let left_out =
            static_records.iter().position(|s| std::ptr::eq(*s, facts)).map_or(0, |i| step1.left_out[i]);
        let scores = score(&facts.data.without_first(left_out), &simulated, &Scoring::default())?;
        fits.push(RecordFit {
            sines: SineResponse::of_record(&facts.data, &simulated),
            data: facts.data.clone(),
            role: if follow || *role == RecordRole::QuasiStatic { *role } else { RecordRole::QuasiStatic },
            start,
            scores,
            simulated,
            band: None,
        });
    }
    if !engine.cancelled {
        findings::require_fit(&fits, facts, options)?;
    }
    let structure = StructureChoice {
        smoothing: None,
        between: None,
        family: None,
        degrees: step1.degrees.clone(),
        degree: step1.solution.hysteresis.polynomial.len(),
        creep: Creep::None,
        delay_and_lag_from_start: step1.shift_searched,
        creeps: step1.solution.creeps.clone(),
        left_out: step1.left_out.clone(),
    };
    let cancelled = engine.cancelled;
    let resume = engine.searches();
    let bounds: Vec<Bounds> =
        std::iter::once(step1.problem.bounds().clone()).chain(step2.bounds().cloned()).collect();
    let verdict = match &step2 {
        Step2::Linear(step) => Some(step.verdict.clone()),
        _ => None,
    };
    let mut searches = vec![step1.search];
    searches.extend(step2.into_search());
    let mut identification = Identification {
        method: Method::TwoStep,
        model,
        parameters,
        correlations,
        searches,
        bounds,
        records: fits,
        runs: Vec::new(),
        structure,
        covariance: None,
        of_numbers,
        output_uncertainty: None,
        reduction: None,
        findings: Vec::new(),
        treatment: Vec::new(),
        excited_hz: excited(facts),
        cancelled,
        resume,
    };
    findings::write(facts, options, &mut identification);
    let said = |text| Finding::new(FindingKind::Verdict, "dynamic block", text);
    identification.findings.extend(verdict.map(said));
    Ok(identification)
}

enum Step2 {
    None,
    Order(Box<DynamicStep>),
    Arx(Arx),
    Linear(Box<LinearStep>),
}

impl Step2 {
    fn integer_order(
        outputs: &[HysteresisOutput<'_>],
        options: &Options,
        integer: bool,
        hysteresis: &ArticleOperator,
        engine: &mut Engine<'_, '_>,
    ) -> Result<Self, IdentifyError> {
        let step = dynamic_step::identify_dynamic(outputs, options, integer, hysteresis, engine)?;
        Ok(Self::Order(Box::new(step)))
    }

    fn bounds(&self) -> Option<&Bounds> {
        match self {
            Self::Order(step) => Some(step.bounds()),
            _ => None,
        }
    }

    fn into_search(self) -> Option<Search> {
        match self {
            Self::Order(step) => Some(step.search),
            _ => None,
        }
    }
}

/// Rejects demands that this fit cannot meet.
fn check_demands(options: &Options, dynamics: bool) -> Result<(), IdentifyError> {
    let highest = match options.degree {
        Choice::Given(degree) => degree,
        Choice::Auto => super::HIGHEST_DEGREE,
    };
    let polynomial: Vec<_> = (1..=highest).map(polynomial_name).collect();
    let mut known: Vec<&str> = polynomial.iter().map(AsRef::as_ref).collect();
    known.extend(["alpha", "beta", "gamma", "n", OFFSET]);
    if options.delay_s == Choice::Auto && !options.dynamics.takes_two_steps() {
        known.push("delay");
    }
    match (dynamics, options.dynamics) {
        (false, DynamicsChoice::Auto | DynamicsChoice::Integer) if options.delay_s == Choice::Auto => {
            known.push("lag")
        }
        (true, DynamicsChoice::Integer) => known.extend(["gain", "natural_frequency", "damping"]),
        (true, DynamicsChoice::Auto | DynamicsChoice::Fractional) => {
            known.extend(["gain", "natural_frequency", "damping", "order2", "order1"]);
        }
        _ => {}
    }
    options.demands.check(&known)?;
    super::check_common_demands(options)
}

fn start_of(
    facts: &RecordFacts,
    static_records: &[&RecordFacts],
    step1: &StaticStep,
    dynamic: &[&RecordFacts],
    dynamic_starts: &[Start],
) -> Start {
    let same = |other: &&RecordFacts| std::ptr::eq(*other, facts);
    let in_dynamic = dynamic.iter().position(same).and_then(|i| dynamic_starts.get(i));
    let in_static = static_records.iter().position(same).and_then(|i| step1.starts.get(i));
    *in_dynamic.or(in_static).unwrap_or(&Start::Rest { voltage_v: facts.data.u[0] })
}

fn assemble(
    step1: &StaticStep,
    step2: &Step2,
    static_records: &[&RecordFacts],
    dynamic: &[&RecordFacts],
    options: &Options,
) -> Model {
    let solution = &step1.solution;
    let lag = |lag_s: f64| TransferFunction {
        numerator: vec![Term { coefficient: 1.0, order: 0.0 }],
        denominator: vec![Term { coefficient: 1.0, order: 0.0 }, Term { coefficient: lag_s, order: 1.0 }],
    };
    let (dynamics, delay_s) = match step2 {
        Step2::None if solution.lag_s > 0.0 => (Dynamics::Integer(lag(solution.lag_s)), solution.delay_s),
        Step2::None => (Dynamics::None, solution.delay_s),
        Step2::Arx(arx) => (Dynamics::Arx(arx.clone()), solution.delay_s),
        Step2::Linear(step) => (step.dynamics.clone(), solution.delay_s + step.delay_s),
        Step2::Order(step) => {
            (dynamic_step::order(step.solution.transfer_function(), options), step.solution.delay_s)
        }
    };
    let rate = |records: &[&RecordFacts]| records.first().and_then(|f| f.data.sample_rate_hz());
    Model {
        hysteresis: Hysteresis::from(solution.hysteresis.clone()),
        dynamics,
        offset: solution.offsets.first().copied().unwrap_or(0.0),
        delay_s,
        scheme: match (step2, options.scheme) {
            (Step2::Linear(step), Choice::Auto) => step.scheme(),
            _ => options.scheme(),
        },
        inter_sample: options.inter_sample(),
        sample_rate_hz: if matches!(step2, Step2::None) { rate(static_records) } else { rate(dynamic) },
    }
}

/// Sets the offset to the best one for the whole first record: where creep was fitted, the fit's offset is
/// that at the start.
fn settle_offset(model: &mut Model, step1: &StaticStep, first: &RecordFacts) -> Result<(), IdentifyError> {
    let simulated = model.simulate_at_own_rate(&first.data.u, &first.data.time, &step1.starts[0])?;
    let fitted = first.data.without_first(step1.left_out[0]);
    model.offset += score(&fitted, &simulated, &Scoring::default())?.offset;
    Ok(())
}

/// ARX from hysteresis output to displacement, on all dynamic records, orders by simulated error.
fn fit_arx(outputs: &[HysteresisOutput<'_>], delay_s: f64) -> Result<Arx, IdentifyError> {
    let signals: Vec<_> = outputs.iter().map(|output| output.counted_from_rest(delay_s)).collect();
    let records: Vec<ArxRecord<'_>> = signals
        .iter()
        .map(|(input, output, valid)| ArxRecord { input, output, valid: valid.as_deref() })
        .collect();
    let search = ArxSearch { max_na: 3, max_nb: 3, max_nk: 5, criterion: OrderCriterion::SimulatedError };
    let candidates = select_orders(&records, &search)?;
    let best =
        candidates.into_iter().find(|c| c.stable).ok_or_else(|| IdentifyError::NoDynamicInformation {
            wanted: "ARX",
            because: "every ARX model that fits the records is unstable".into(),
        })?;
    Ok(best.fit.model)
}

/// Parameters with their uncertainty.
struct EstimatedParameters {
    /// Every parameter with its standard error.
    parameters: Vec<Parameter>,
    /// Correlations of those of each step.
    correlations: Vec<Correlation>,
    /// Covariance of the model's numbers, where there was no second step.
    of_numbers: Option<Covariance>,
}

fn parameters(
    step1: &StaticStep,
    step2: &Step2,
    static_records: &[&RecordFacts],
    outputs: &[HysteresisOutput<'_>],
    options: &Options,
) -> Result<EstimatedParameters, IdentifyError> {
    let (problem, x) = static_step::in_article_symbols(step1, static_records, options)?;
    // Under slow drive a lag cannot be distinguished from loop width: the model omits it, but the standard
    // errors allow for it.
    let no_lag = matches!(step2, Step2::None) && !step1.shift_searched && options.delay_s == Choice::Auto;
    let left_out = if no_lag { problem.along_a_lag(&x) } else { None };
    let covariance1 = covariance(&problem, &x, left_out.as_deref());
    let names: Vec<&str> = problem.bounds().ranges.iter().map(|r| r.name.as_str()).collect();
    let error1 = |name: &str| {
        let index = names.iter().position(|n| *n == name)?;
        covariance1.as_ref().map(|c| c[(index, index)].sqrt())
    };
    let mut searched: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let mut correlations: Vec<Correlation> =
        covariance1.iter().map(|c| correlation(&step1.search.step, searched.clone(), c)).collect();
    let b = &step1.solution.hysteresis;
    let mut list: Vec<Parameter> = b
        .polynomial
        .iter()
        .enumerate()
        .map(|(i, &c)| {
            let name = polynomial_name(i + 1);
            Parameter::new(ParameterRole::Polynomial(i + 1), &name, c, error1(&name))
        })
        .collect();
    let block = Hysteresis::from(b.clone());
    for (number, (name, value)) in block.form().model_numbers().into_iter().zip(block.numbers()) {
        let role = ParameterRole::Hysteresis(number.place);
        list.push(Parameter::new(role, &name, value, error1(&name)));
    }
    match step2 {
        Step2::Order(step) => {
            let (problem, x) = dynamic_step::all_searched(step, outputs, options)?;
            let covariance2 = covariance(&problem, &x, None);
            let error2 =
                |f: &dyn Fn(&[f64]) -> f64| covariance2.as_ref().and_then(|c| standard_error(c, &x, f));
            let form = step.solution.form;
            let names: Vec<String> = problem.bounds().ranges.iter().map(|r| r.name.clone()).collect();
            let of_form = [form.natural_frequency_hz, form.damping, form.alpha2, form.alpha1];
            let eq13 = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
            let of_form = eq13
                .parameters()
                .into_iter()
                .zip(of_form)
                .map(|(p, value)| (ParameterRole::Dynamics(p), p.name, value));
            for (role, name, value) in [(ParameterRole::Gain, "gain", form.gain)]
                .into_iter()
                .chain(of_form)
                .chain([(ParameterRole::Delay, "delay", step.solution.delay_s)])
            {
                let index = names.iter().position(|n| n == name);
                let error = index.and_then(|i| covariance2.as_ref().map(|c| c[(i, i)].sqrt()));
                list.push(Parameter::new(role, name, value, error));
            }
            let coefficients = |g: &TransferFunction| {
                [g.numerator[0].coefficient, g.denominator[0].coefficient, g.denominator[1].coefficient]
            };
            let values = coefficients(&step.solution.transfer_function());
            let equation =
                [(Equation13::Numerator, "b"), (Equation13::Constant, "c0"), (Equation13::Middle, "c1")];
            for (i, (which, name)) in equation.into_iter().enumerate() {
                let at = |x: &[f64]| {
                    dynamic_step::transfer_function_at(&problem, x).map_or(f64::NAN, |g| coefficients(&g)[i])
                };
                list.push(Parameter::new(ParameterRole::Equation13(which), name, values[i], error2(&at)));
            }
            correlations.extend(covariance2.iter().map(|c| correlation(&step.search.step, names.clone(), c)));
            searched.extend(names);
            searched.extend(["b", "c0", "c1"].map(str::to_owned));
        }
        Step2::None if step1.solution.lag_s > 0.0 => {
            let one_pole = DynamicForm { modes: Modes::Integer { order: 1 }, creep: Creep::None };
            for lag in one_pole.parameters() {
                let role = ParameterRole::Dynamics(lag);
                list.push(Parameter::new(role, lag.name, step1.solution.lag_s, error1(lag.name)));
            }
            let (value, error) = (step1.solution.delay_s, error1("delay"));
            list.push(Parameter::new(ParameterRole::Delay, "delay", value, error));
        }
        Step2::None => {
            let given = matches!(options.delay_s, Choice::Given(_));
            let error = if given { None } else { error1("delay") };
            list.push(Parameter::new(ParameterRole::Delay, "delay", step1.solution.delay_s, error));
        }
        Step2::Arx(_) => {}
        Step2::Linear(step) => {
            searched.extend(step.parameters.iter().map(|p| p.name.clone()));
            correlations.extend(step.correlation.clone());
            list.extend(step.parameters.iter().cloned());
        }
    }
    for parameter in &mut list {
        parameter.held = !searched.contains(&parameter.name);
    }
    let of_numbers = covariance1.filter(|_| matches!(step2, Step2::None)).map(|matrix| Covariance {
        // The model file holds the lag as the denominator 1 + T s.
        names: names
            .iter()
            .map(|&n| if n == "lag" { "denominator[1].coefficient" } else { n }.into())
            .collect(),
        condition_number: correlations.first().map_or(f64::NAN, |c| c.condition_number),
        undetermined: vec![false; x.len()],
        values: x,
        matrix,
    });
    Ok(EstimatedParameters { parameters: list, correlations, of_numbers })
}
