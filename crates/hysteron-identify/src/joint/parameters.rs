//! The parameters of a joint fit in the article's symbols, with their errors and intervals.

use super::super::layout::Role;
use super::super::parameter::{Equation13, Parameter, ParameterRole};
use super::intervals::{Interval, IntervalMethod};
use super::knowledge::Covariance;
use super::parameter_layout::{DELAY, JointSolution};
use super::problem::JointProblem;
use super::setup::memory_name;
use hysteron_model::dynamics::{Creep, DynamicForm, Dynamics, Modes};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::Place;
use hysteron_model::model_file::{polynomial_name, transfer_function_numbers};

/// Index of each parameter among the estimates, and its value where it is held.
struct Places {
    weights: Vec<(Option<usize>, f64)>,
    shape: Vec<(Option<usize>, f64)>,
}

impl Places {
    fn new(own: &Covariance, problem: &JointProblem, solution: &JointSolution) -> Self {
        let family = problem.hysteresis();
        let place = |name: String, held: f64| (own.names.iter().position(|n| *n == name), held);
        let of = |names: Vec<String>, held: &[f64]| {
            names.into_iter().zip(held).map(|(name, &held)| place(name, held)).collect()
        };
        // The weights of a density are not those of its plays; without an estimate they are 0.
        let own_weights = solution.hysteresis.weights();
        let is_own = solution.hysteresis.form() == family;
        let held = if is_own { own_weights.to_vec() } else { vec![0.0; family.weight_names().len()] };
        Self { weights: of(family.weight_names(), &held), shape: of(family.shape_names(), &solution.shape) }
    }

    fn weights_at(&self, values: &[f64]) -> Vec<f64> {
        self.weights.iter().map(|&(place, held)| place.map_or(held, |i| values[i])).collect()
    }

    fn shape_at(&self, values: &[f64]) -> Vec<f64> {
        self.shape.iter().map(|&(place, held)| place.map_or(held, |i| values[i])).collect()
    }
}

/// The covariance with β, γ for β', γ' and z(0) for ζ(0).
pub(super) fn in_article_symbols(
    own: &Covariance,
    problem: &JointProblem,
    solution: &JointSolution,
) -> Covariance {
    let family = problem.hysteresis();
    let places = Places::new(own, problem, solution);
    let place = |record| own.names.iter().position(|name| *name == memory_name(record));
    let memory: Vec<usize> = (0..problem.layout().memory.len()).filter_map(place).collect();
    own.transformed(own.names.clone(), |values| {
        let mut out = values.to_vec();
        let weights = places.weights_at(values);
        if let Ok(operator) = family.operator(vec![1.0], &weights, &places.shape_at(values)) {
            for (name, value) in operator.numbers() {
                if let Some(i) = own.names.iter().position(|own| *own == name) {
                    out[i] = value;
                }
            }
        }
        for &i in &memory {
            out[i] = family.own_memory(values[i], &weights);
        }
        out
    })
}

/// The covariance of the model's numbers, named as a model file names them.
pub(super) fn of_numbers(
    own: &Covariance,
    problem: &JointProblem,
    solution: &JointSolution,
    form: &DynamicForm,
) -> Option<Covariance> {
    let b = &solution.hysteresis;
    let family = problem.hysteresis();
    let hysteresis = (1..=b.polynomial().len()).map(|i| polynomial_name(i).into_owned());
    let (dynamics, _) = transfer_function_numbers(&form.transfer_function(&solution.form).ok()?);
    let names: Vec<String> = hysteresis
        .chain(b.numbers().into_iter().map(|(name, _)| name))
        .chain(dynamics.iter().cloned())
        .chain([DELAY.to_owned()])
        .collect();
    let count = names.len();
    let place = |name: &str| own.names.iter().position(|n| n == name);
    let coefficients: Vec<(Option<usize>, f64)> =
        b.polynomial().iter().enumerate().map(|(i, &c)| (place(&polynomial_name(i + 1)), c)).collect();
    let places = Places::new(own, problem, solution);
    let delay = place(DELAY);
    let form_places: Vec<Option<usize>> = form.parameters().iter().map(|p| place(p.name)).collect();
    let numbers = own.transformed(names, |values| {
        let at = |place: Option<usize>, held: f64| place.map_or(held, |i| values[i]);
        let polynomial = coefficients.iter().map(|&(place, held)| at(place, held)).collect();
        let p: Vec<f64> =
            form_places.iter().zip(&solution.form).map(|(place, &held)| at(*place, held)).collect();
        let block = family.operator(polynomial, &places.weights_at(values), &places.shape_at(values));
        let (Ok(block), Ok(g)) = (block, form.transfer_function(&p)) else { return vec![f64::NAN; count] };
        let mut out = block.polynomial().to_vec();
        out.extend(block.numbers().into_iter().map(|(_, value)| value));
        out.extend(transfer_function_numbers(&g).1);
        out.push(at(delay, solution.delay_s));
        // Equal orders merge into one term.
        if out.len() == count { out } else { vec![f64::NAN; count] }
    });
    numbers.matrix.iter().all(|c| c.is_finite()).then_some(numbers)
}

/// All parameters of the model by name, and the records' memory, with their standard errors.
pub(super) fn parameters(
    solution: &JointSolution,
    form: &DynamicForm,
    problem: &JointProblem,
    (covariance, of_numbers): (Option<&Covariance>, Option<&Covariance>),
    model: &Model,
) -> Vec<Parameter> {
    let of = |c: Option<&Covariance>, name: &str| {
        let c = c?;
        c.std_error(c.names.iter().position(|n| n == name)?)
    };
    let error = |name: &str| of(covariance, name);
    let b = &solution.hysteresis;
    let mut list: Vec<Parameter> = b
        .polynomial()
        .iter()
        .enumerate()
        .map(|(i, &c)| {
            let name = polynomial_name(i + 1);
            Parameter::new(ParameterRole::Polynomial(i + 1), &name, c, error(&name))
        })
        .collect();
    let layout = problem.layout();
    let mut push = |role, name: &str, value, fitted: Role, std_error| {
        let held = matches!(fitted, Role::Fixed(_));
        list.push(Parameter { held, ..Parameter::new(role, name, value, std_error) });
    };
    let family = problem.hysteresis();
    // The numbers of a model with more of them than the fit had follow from those of the fit.
    let follows = b.form() != family;
    for (number, (name, value)) in b.form().model_numbers().into_iter().zip(b.numbers()) {
        let role = ParameterRole::Hysteresis(number.place);
        if follows {
            let fitted = match number.place {
                Place::Shape(_) => Role::Fixed(value),
                Place::Weight(_) => Role::Projected,
            };
            push(role, &name, value, fitted, of(of_numbers, &name).filter(|error| *error > 0.0));
            continue;
        }
        let fitted = match number.place {
            Place::Shape(index) => layout.shape.get(index),
            Place::Weight(index) => layout.weights.get(index),
        };
        push(role, &name, value, fitted.copied().unwrap_or(Role::Projected), error(&name));
    }
    for ((parameter, &value), &role) in form.parameters().iter().zip(&solution.form).zip(&layout.form) {
        push(ParameterRole::Dynamics(*parameter), parameter.name, value, role, error(parameter.name));
    }
    push(ParameterRole::Delay, DELAY, solution.delay_s, layout.delay, error(DELAY));
    if let (Modes::Fractional, Creep::None, Dynamics::Fractional(g)) =
        (form.modes, form.creep, &model.dynamics)
    {
        // Eq. 13's own coefficients.
        for (which, name, number, value) in [
            (Equation13::Numerator, "b", "numerator[0].coefficient", g.numerator[0].coefficient),
            (Equation13::Constant, "c0", "denominator[0].coefficient", g.denominator[0].coefficient),
            (Equation13::Middle, "c1", "denominator[1].coefficient", g.denominator[1].coefficient),
        ] {
            let role = ParameterRole::Equation13(which);
            list.push(Parameter::new(role, name, value, of(of_numbers, number)));
        }
    }
    for (index, role) in problem.layout().memory.iter().enumerate() {
        if matches!(role, Role::Searched(_)) {
            let name = memory_name(index);
            let memory = family.own_memory(solution.memory[index], b.weights());
            list.push(Parameter::new(ParameterRole::Memory(index), &name, memory, error(&name)));
        }
    }
    list
}

/// 95 % intervals of all parameters with a standard error, from those in the fit's own symbols.
pub(super) fn give_intervals(
    parameters: &mut [Parameter],
    names: &[String],
    own: &[Option<Interval>],
    solution: &JointSolution,
) {
    let operator = &solution.hysteresis;
    let form = operator.form();
    let (searched, reported) = (operator.shape(), operator.own_shape());
    let scaled = form.description().remembers_output();
    let numbers = form.model_numbers();
    let falls_with_exponent =
        |place| numbers.iter().any(|number| number.place == place && number.unit.falls_with_exponent);
    for p in parameters {
        let Some(error) = p.std_error else { continue };
        let same = names.iter().position(|name| *name == p.name).and_then(|i| *own.get(i)?);
        let normal = |method| Interval::symmetric(p.value, error, method);
        p.interval = Some(match (p.role, same) {
            (ParameterRole::Equation13(_), _) if p.value > 0.0 => Interval::logarithmic(p.value, error),
            (ParameterRole::Hysteresis(place @ Place::Shape(index)), Some(i)) => {
                match (searched.get(index), reported.get(index)) {
                    // Shape numbers in the scale of the weights depend on these, too.
                    _ if operator.exponent() != 1.0 && falls_with_exponent(place) => {
                        normal(IntervalMethod::Unchecked)
                    }
                    (Some(searched), Some(reported)) if searched == reported => i,
                    (Some(searched), Some(reported)) if *searched == -reported => {
                        Interval { low: -i.high, high: -i.low, ..i }
                    }
                    _ => normal(IntervalMethod::Unchecked),
                }
            }
            (ParameterRole::Memory(_), Some(i)) if scaled => normal(i.method),
            (_, Some(interval)) => interval,
            (_, None) => normal(IntervalMethod::Unchecked),
        });
    }
}
