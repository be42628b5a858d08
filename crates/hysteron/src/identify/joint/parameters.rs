//! The parameters of a joint fit in the article's symbols, with their errors and intervals.

use super::super::layout::Role;
use super::super::result::Parameter;
use super::intervals::{Interval, IntervalMethod};
use super::knowledge::Covariance;
use super::problem::{JointProblem, JointSolution};
use super::setup::memory_name;
use crate::dynamics::{DynamicForm, Dynamics, Modes};
use crate::hammerstein::Model;
use crate::hysteresis::{BoucWen, UnitShape};
use crate::model_file::{polynomial_name, transfer_function_numbers};

/// The covariance with β, γ for β', γ' and z(0) for ζ(0).
pub(super) fn in_article_symbols(own: &Covariance, problem: &JointProblem) -> Covariance {
    let place = |name: &str| own.names.iter().position(|n| n == name);
    let (alpha, beta, gamma, n) = (place("alpha"), place("beta"), place("gamma"), place("n"));
    let layout = problem.layout();
    let held = |role: Role| if let Role::Fixed(value) = role { value } else { 0.0 };
    let memory: Vec<usize> = own
        .names
        .iter()
        .enumerate()
        .filter(|(_, name)| name.starts_with("memory_"))
        .map(|(index, _)| index)
        .collect();
    own.transformed(own.names.clone(), |values| {
        let mut out = values.to_vec();
        let at = |index: Option<usize>, role: Role| index.map_or(held(role), |i| values[i]);
        let a = at(alpha, layout.alpha);
        let shape =
            UnitShape { beta: at(beta, layout.beta), gamma: at(gamma, layout.gamma), n: at(n, layout.n) };
        if let Ok(model) = BoucWen::from_unit(vec![1.0], a, shape) {
            if let Some(i) = beta {
                out[i] = model.beta;
            }
            if let Some(i) = gamma {
                out[i] = model.gamma;
            }
        }
        for &i in &memory {
            out[i] = a * values[i];
        }
        out
    })
}

/// The covariance of the model's numbers, named as a model file names them.
pub(super) fn of_numbers(
    own: &Covariance,
    solution: &JointSolution,
    form: &DynamicForm,
) -> Option<Covariance> {
    let b = &solution.hysteresis;
    let hysteresis = (1..=b.polynomial.len()).map(|i| polynomial_name(i).into_owned());
    let (dynamics, _) = transfer_function_numbers(&form.transfer_function(&solution.form).ok()?);
    let names: Vec<String> = hysteresis
        .chain(["alpha", "beta", "gamma", "n"].map(String::from))
        .chain(dynamics.iter().cloned())
        .chain(["delay".to_owned()])
        .collect();
    let count = names.len();
    let place = |name: &str| own.names.iter().position(|n| n == name);
    let coefficients: Vec<(Option<usize>, f64)> =
        b.polynomial.iter().enumerate().map(|(i, &c)| (place(&polynomial_name(i + 1)), c)).collect();
    let [alpha, beta, gamma, n, delay] = ["alpha", "beta", "gamma", "n", "delay"].map(place);
    let form_places: Vec<Option<usize>> = form.parameters().iter().map(|p| place(p.name)).collect();
    let numbers = own.transformed(names, |values| {
        let at = |place: Option<usize>, held: f64| place.map_or(held, |i| values[i]);
        let polynomial = coefficients.iter().map(|&(place, held)| at(place, held)).collect();
        let shape = UnitShape {
            beta: at(beta, solution.shape.beta),
            gamma: at(gamma, solution.shape.gamma),
            n: at(n, solution.shape.n),
        };
        let p: Vec<f64> =
            form_places.iter().zip(&solution.form).map(|(place, &held)| at(*place, held)).collect();
        let block = BoucWen::from_unit(polynomial, at(alpha, b.alpha), shape);
        let (Ok(block), Ok(g)) = (block, form.transfer_function(&p)) else { return vec![f64::NAN; count] };
        let mut out = block.polynomial;
        out.extend([block.alpha, block.beta, block.gamma, block.n]);
        out.extend(transfer_function_numbers(&g).1);
        out.push(at(delay, solution.delay_s));
        // Orders that pass each other merge into one term.
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
        .polynomial
        .iter()
        .enumerate()
        .map(|(i, &c)| {
            let name = polynomial_name(i + 1);
            Parameter::new("hysteresis", &name, c, error(&name))
        })
        .collect();
    let layout = problem.layout();
    let mut push = |block, name: &str, value, role: Role| {
        let held = matches!(role, Role::Fixed(_));
        list.push(Parameter { held, ..Parameter::new(block, name, value, error(name)) });
    };
    push("hysteresis", "alpha", b.alpha, layout.alpha);
    push("hysteresis", "beta", b.beta, layout.beta);
    push("hysteresis", "gamma", b.gamma, layout.gamma);
    push("hysteresis", "n", b.n, layout.n);
    for ((parameter, &value), &role) in form.parameters().iter().zip(&solution.form).zip(&layout.form) {
        push("dynamics", parameter.name, value, role);
    }
    push("dynamics", "delay", solution.delay_s, layout.delay);
    if let (Modes::Fractional, false, Dynamics::Fractional(g)) = (&form.modes, form.creep, &model.dynamics) {
        // Eq. 13's own coefficients.
        for (name, number, value) in [
            ("b", "numerator[0].coefficient", g.numerator[0].coefficient),
            ("c0", "denominator[0].coefficient", g.denominator[0].coefficient),
            ("c1", "denominator[1].coefficient", g.denominator[1].coefficient),
        ] {
            list.push(Parameter::new("dynamics", name, value, of(of_numbers, number)));
        }
    }
    for (index, role) in problem.layout().memory.iter().enumerate() {
        if matches!(role, Role::Searched(_)) {
            let name = memory_name(index);
            list.push(Parameter::new("start", &name, b.alpha * solution.memory[index], error(&name)));
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
    for p in parameters {
        let Some(error) = p.std_error else { continue };
        let same = names.iter().position(|name| *name == p.name).and_then(|i| *own.get(i)?);
        p.interval = Some(match (p.name.as_str(), same) {
            ("b" | "c0" | "c1", _) if p.value > 0.0 => Interval::logarithmic(p.value, error),
            // For n = 1, β = β' and γ = ±γ'; otherwise they also depend on α.
            ("beta" | "gamma", Some(i)) if solution.shape.n == 1.0 => {
                let unit = if p.name == "beta" { solution.shape.beta } else { solution.shape.gamma };
                let (a, b) = if unit * p.value < 0.0 { (-i.high, -i.low) } else { (i.low, i.high) };
                Interval { low: a, high: b, ..i }
            }
            ("beta" | "gamma", _) => Interval::symmetric(p.value, error, IntervalMethod::Unchecked),
            // z(0) = α ζ(0).
            (name, Some(i)) if name.starts_with("memory_") => Interval::symmetric(p.value, error, i.method),
            (_, Some(interval)) => interval,
            (_, None) => Interval::symmetric(p.value, error, IntervalMethod::Unchecked),
        });
    }
}
