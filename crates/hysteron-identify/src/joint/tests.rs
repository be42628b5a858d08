//! The joint problem against slow oracles.

use super::super::layout::Role;
use super::drive::fine_drive;
use super::normalised::Normalised;
use super::parameter_layout::JointLayout;
use super::problem::{JointProblem, SpareWorkspaces};
use super::record::{Clock, Ingredients, JointRecord};
use hysteron_model::Start;
use hysteron_model::dynamics::{Creep, DynamicForm, Modes, Sampling, Scheme};
use hysteron_model::hysteresis::{HysteresisForm, RecordEnds};
use hysteron_model::record::InterSample;
use hysteron_optimize::{Bounds, Derivative, LeastSquaresProblem, Problem, Range, Stop};
use std::f64::consts::TAU;

mod workspaces;

/// At rest with an unknown memory, at the first voltage of whatever record.
const REMEMBERING: Start<()> = Start::Remembering { voltage_v: 0.0, memory: () };

/// Two records: a nested slow drive and a faster one, outputs that no model fits.
fn records(scheme: Scheme, transients: bool, before: [Start<()>; 2], factor: usize) -> Vec<JointRecord> {
    let drives: [Vec<f64>; 2] = [
        (0..600)
            .map(|k| {
                let t = k as f64 / 600.0;
                4.0 * (1.0 - 0.6 * t) * (1.0 - (TAU * 3.0 * t).cos()) + 0.3
            })
            .collect(),
        (0..480).map(|k| 5.0 + 4.0 * (TAU * (k as f64 / 480.0) * 6.0).sin()).collect(),
    ];
    drives
        .iter()
        .zip(before)
        .enumerate()
        .map(|(r, (drive, before))| {
            let samples = drive.len();
            let output: Vec<f64> = drive
                .iter()
                .enumerate()
                .map(|(k, u)| 2.0 * u - 0.4 * (u * 0.9).sin() + 0.2 * (k as f64 * 0.11).cos() + r as f64)
                .collect();
            let often = if factor == 1 { 37 } else { 400 };
            let weight: Vec<f64> =
                (0..samples).map(|k| if k % often == 5 { 0.0 } else { 1.0 + 0.5 * r as f64 }).collect();
            let ends = if before == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
            let (fine, thinning) = fine_drive(drive, (scheme, true), InterSample::Linear, ends).unwrap();
            JointRecord::new(
                Ingredients {
                    drive: fine.as_ref().unwrap_or(drive),
                    thinning,
                    factor,
                    every: 1,
                    output,
                    weighting: weight.into(),
                    before,
                    transients,
                    offset_is_held: false,
                    nuisance: vec![(0..samples).map(|k| k as f64).collect()],
                    cycles: 1,
                    degree: 3,
                    clock: Clock::Rate(1000.0),
                    scheme,
                    sampling: Sampling { reconstruction: InterSample::Linear, ..Sampling::of(scheme) },
                },
                &Stop::new(),
            )
            .unwrap()
        })
        .collect()
}

/// Shape numbers with their ranges: held where there is one value only.
type Shape<'a> = &'a [(&'a str, f64, f64)];

const LOOP_SHAPE: [(&str, f64, f64); 2] = [("beta", 0.0, 3.0), ("gamma", -3.0, 3.0)];

fn problem(form: DynamicForm, n: Option<f64>, records: Vec<JointRecord>, memory: [bool; 2]) -> JointProblem {
    let n = n.map_or(("n", 1.0, 4.0), |n| ("n", n, n));
    let shape = [LOOP_SHAPE[0], LOOP_SHAPE[1], n];
    of_family((HysteresisForm::default(), &shape, &[Role::Projected]), form, records, memory)
}

fn of_family(
    (hysteresis, shape, weights): (HysteresisForm, Shape<'_>, &[Role]),
    form: DynamicForm,
    records: Vec<JointRecord>,
    memory: [bool; 2],
) -> JointProblem {
    let mut ranges: Vec<Range> = Vec::new();
    let mut searched = |name: &str, low: f64, high: f64| {
        ranges.push(Range::linear(name, low, high));
        Role::Searched(ranges.len() - 1)
    };
    let shape = shape.iter().map(
        |&(name, low, high)| {
            if low == high { Role::Fixed(low) } else { searched(name, low, high) }
        },
    );
    let shape = shape.collect();
    let form_roles = form
        .parameters()
        .iter()
        .map(|p| {
            let high = if p.name.starts_with("natural") { 1000.0 } else { 3.0 };
            searched(p.name, 1e-4, high)
        })
        .collect();
    let delay = searched("delay", 0.0, 0.05);
    let memory = memory
        .iter()
        .enumerate()
        .map(|(r, free)| if *free { searched(&format!("memory_{r}"), -5.0, 5.0) } else { Role::Fixed(0.0) })
        .collect();
    let layout = JointLayout {
        polynomial: vec![Role::Projected, Role::Projected],
        weights: weights.to_vec(),
        shape,
        form: form_roles,
        delay,
        memory,
    };
    let identity = format!("{hysteresis:?} {form:?} {layout:?}");
    JointProblem::new(records.into(), (hysteresis, form), layout, Bounds { ranges }, identity)
}

/// Sixth-order central difference of `f` at 0 with the step `h`.
fn difference(h: f64, f: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    let at = |k: f64| f(k * h);
    let (a, b, c) = ((at(1.0), at(-1.0)), (at(2.0), at(-2.0)), (at(3.0), at(-3.0)));
    (0..a.0.len())
        .map(|i| (45.0 * (a.0[i] - a.1[i]) - 9.0 * (b.0[i] - b.1[i]) + (c.0[i] - c.1[i])) / (60.0 * h))
        .collect()
}

fn residuals(problem: &JointProblem, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; problem.residual_count()];
    assert!(problem.residuals(x, &mut problem.workspace(), &mut out));
    out
}

/// With the weights as unknowns beside them, the derivatives are those of `jacobian` but for what lies in the
/// span of the columns; the weights and their columns are those of the elimination.
fn is_the_jacobian_beside_the_weights(
    problem: &JointProblem,
    x: &[f64],
    jacobian: &[f64],
    basis: &super::super::projection::Projection,
) {
    let mut beside = vec![0.0; jacobian.len()];
    let mut ws = problem.workspace();
    let (written, eliminated) = problem.jacobian_with_eliminated(x, &mut ws, &mut beside);
    assert_eq!(written, Derivative::Written);
    let count = problem.residual_count();
    for (found, expected) in beside.chunks_exact_mut(count).zip(jacobian.chunks_exact(count)) {
        basis.project(found);
        let size = expected.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-10 * size));
    }
    let one_sided = problem.layout().weights.iter().filter(|role| matches!(role, Role::OneSided(_))).count();
    assert_eq!(eliminated.coefficients.len(), one_sided);
    for (column, c) in eliminated.columns.chunks_exact(count).zip(eliminated.coefficients) {
        let mut rest = column.to_vec();
        basis.project(&mut rest);
        let share = hysteron_numeric::dot(&rest, &rest) / hysteron_numeric::dot(column, column);
        assert!((*c > 0.0) == (share < 1e-18), "{c} {share}");
    }
}

/// The response to the sum of all inputs is the sum of their responses, at any coefficients.
fn residuals_are_those_of_the_columns(problem: &JointProblem, x: &[f64], coefficients: &[f64]) {
    let other: Vec<f64> = coefficients.iter().zip(1..).map(|(c, j)| c * (1.0 + 0.1 * f64::from(j))).collect();
    let slow = problem.linearise_at(x, &other, &mut problem.workspace()).unwrap().residuals;
    let mut ws = problem.workspace();
    let fast = problem.residuals_at(x, &other, &mut ws);
    let size = slow.iter().fold(0.0f64, |m, r| m.max(r.abs()));
    assert!(size > 0.0 && fast.len() == slow.len());
    for (fast, slow) in fast.iter().zip(&slow) {
        assert!((fast - slow).abs() <= 1e-10 * size, "{fast} {slow} of {size}");
    }
}

/// Kaufman's Jacobian is P⊥ times the derivative of the residual, since what it leaves out lies in the span
/// of the columns. P⊥ itself is taken from the problem: the columns are read off its linearisation.
fn check(problem: &JointProblem, x: &[f64]) {
    let count = problem.residual_count();
    let mut jacobian = vec![0.0; count * x.len()];
    let written = problem.jacobian(x, &mut problem.workspace(), &mut jacobian);
    assert_eq!(written, Derivative::Written);
    let linearisation = problem.linearise(x).unwrap();
    let mut basis = super::super::projection::Projection::new(count, 2 + problem.layout().weights.len());
    for column in linearisation.linear.chunks_exact(count) {
        basis.push(|q| q.copy_from_slice(column));
    }
    is_the_jacobian_beside_the_weights(problem, x, &jacobian, &basis);
    residuals_are_those_of_the_columns(problem, x, &linearisation.coefficients);
    let gradient_of_cost = |j: usize, r: &[f64]| -> f64 {
        jacobian[j * count..(j + 1) * count].iter().zip(r).map(|(a, b)| a * b).sum()
    };
    let r = residuals(problem, x);
    for (j, range) in problem.bounds().ranges.iter().enumerate() {
        // Small in the hysteresis, for where ζ passes 0 at a sample the second derivative jumps; not too
        // small, for the transform's rounding grows along the record.
        let hysteretic =
            ["beta", "gamma", "n"].contains(&range.name.as_str()) || range.name.contains("memory");
        // A play that starts or stops to move between the steps has no difference there: short steps, and
        // what rounding leaves of them.
        let jumps = range.name.contains("threshold")
            || (range.name.contains("memory") && problem.hysteresis() != HysteresisForm::default());
        let h = match (jumps, hysteretic) {
            (true, _) => 2e-5,
            (_, true) => 2e-4,
            _ => 5e-3,
        } * x[j].abs().max(1e-3 * range.high);
        let tolerance = if jumps { 2e-6 } else { 1e-7 };
        let by_steps = difference(h, |d| {
            let mut at = x.to_vec();
            at[j] += d;
            residuals(problem, &at)
        });
        let mut projected = by_steps.clone();
        basis.project(&mut projected);
        // The residual also moves within the records' own local columns where these depend on the candidate;
        // both Jacobians are compared where the fit lives.
        let found = &jacobian[j * count..(j + 1) * count];
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let size = norm(&mut found.iter().copied());
        let off = norm(&mut found.iter().zip(&projected).map(|(a, b)| a - b));
        assert!(off <= tolerance * size, "{}: {off:e} of {size:e}", range.name);
        // The gradient of ½‖r‖² is exact.
        let gradient = gradient_of_cost(j, &r);
        let scalar: f64 = by_steps.iter().zip(&r).map(|(d, r)| d * r).sum();
        let scale = size * norm(&mut r.iter().copied());
        assert!((gradient - scalar).abs() <= tolerance * scale, "{}: {gradient} {scalar}", range.name);
    }
}

fn fractional() -> DynamicForm {
    DynamicForm { modes: Modes::Fractional, creep: Creep::None }
}

#[test]
fn jacobian_agrees_with_differences_under_every_scheme() {
    for scheme in [Scheme::Tustin, Scheme::BandLimited, Scheme::Bdf2, Scheme::GrunwaldLetnikov] {
        let before = [REMEMBERING, Start::Rest { voltage_v: 1.0 }];
        let problem = problem(fractional(), Some(1.0), records(scheme, false, before, 1), [true, false]);
        // A delay of 3.4 samples: differences stay on one line between samples under the linear rule.
        check(&problem, &[0.35, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9]);
    }
}

#[test]
fn jacobian_agrees_with_differences_for_other_exponents() {
    let before = [REMEMBERING, REMEMBERING];
    for (n, x_n) in [(Some(2.0), None), (Some(1.5), None), (None, Some(1.7))] {
        let problem = problem(
            DynamicForm { modes: Modes::Integer { order: 2 }, creep: Creep::None },
            n,
            records(Scheme::BandLimited, false, before, 1),
            [true, true],
        );
        let mut x = vec![0.35, 0.3];
        x.extend(x_n);
        x.extend([120.0, 0.4, 0.0034, 0.9, -0.8]);
        check(&problem, &x);
    }
}

fn three_plays() -> HysteresisForm {
    HysteresisForm::plays(3)
}

#[test]
fn jacobian_agrees_with_differences_for_plays() {
    let shape = [("threshold_1", 0.1, 0.9), ("threshold_2", 1.3, 1.3), ("threshold_3", 1.5, 4.0)];
    for (scheme, factor) in [(Scheme::BandLimited, 1), (Scheme::BandLimited, 4), (Scheme::Tustin, 1)] {
        let before = [REMEMBERING, Start::Rest { voltage_v: 1.0 }];
        let records = records(scheme, false, before, factor);
        let family = (three_plays(), &shape[..], &[Role::Projected; 3][..]);
        let problem = of_family(family, fractional(), records, [true, false]);
        check(&problem, &[0.313, 2.217, 120.0, 0.4, 1.9, 0.9, 0.0034, 2.7431]);
    }
}

/// The best of all sets of weights held at 0 that leaves the others with their sign.
#[test]
fn weights_of_one_sign_are_the_best_that_have_it() {
    let before = [Start::Rest { voltage_v: 0.3 }, Start::Rest { voltage_v: 5.0 }];
    let x = [120.0, 0.4, 1.9, 0.9, 0.0034];
    let mut held = 0;
    for thresholds in [[0.4, 1.3, 2.9], [0.1, 0.6, 3.7], [0.9, 2.0, 2.4]] {
        let names = ["threshold_1", "threshold_2", "threshold_3"];
        let shape: Vec<_> = names.iter().zip(thresholds).map(|(name, r)| (*name, r, r)).collect();
        let problem = |roles: [Role; 3]| {
            let records = records(Scheme::BandLimited, false, before, 1);
            of_family((three_plays(), &shape, &roles), fractional(), records, [false; 2])
        };
        let cost = |problem: &JointProblem| problem.cost(&x, &mut problem.workspace());
        let weights = |problem: &JointProblem| problem.solve(&x).unwrap().hysteresis.weights().to_vec();
        for sign in [1.0, -1.0] {
            let signed = problem([Role::OneSided(sign); 3]);
            check(&signed, &x);
            let found = weights(&signed);
            assert!(found.iter().all(|w| sign * w >= 0.0), "{found:?}");
            let used = found.iter().filter(|w| **w != 0.0).count();
            assert_eq!(signed.linearise(&x).unwrap().eliminated.len(), 2 + used);
            held += 3 - used;
            let sets = (0..8).map(|set| {
                problem([0, 1, 2].map(|j| if set >> j & 1 == 1 { Role::Projected } else { Role::Fixed(0.0) }))
            });
            let allowed = sets.filter(|problem| weights(problem).iter().all(|w| sign * w >= 0.0));
            let least = allowed.map(|problem| cost(&problem)).fold(f64::INFINITY, f64::min);
            assert!((cost(&signed) - least).abs() < 1e-12 * least, "{} {least}", cost(&signed));
        }
    }
    assert!((1..18).contains(&held), "{held}");
}

#[test]
fn jacobian_agrees_with_differences_for_reduced_records_and_creep() {
    let before = [REMEMBERING, REMEMBERING];
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::Fractional };
    let problem = problem(form, Some(1.0), records(Scheme::BandLimited, false, before, 4), [true, true]);
    let mut x = vec![0.35, 0.3, 40.0, 0.4, 1.9, 0.9];
    x.extend([0.06, 0.2, 0.0034, 0.9, -0.8]);
    check(&problem, &x);
}

#[test]
fn jacobian_agrees_with_differences_on_periodic_records() {
    // Whole periods: 480 samples are 6 periods; the first record is left out.
    let before = [REMEMBERING, Start::PERIODIC];
    for factor in [1, 3] {
        let records = records(Scheme::BandLimited, false, before, factor);
        let problem = problem(fractional(), Some(1.0), records, [true, false]);
        check(&problem, &[0.35, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9]);
    }
}

#[test]
fn a_stopped_problem_knows_its_best_point_and_evaluates_no_other() {
    let stop = Stop::new();
    let records = records(Scheme::BandLimited, false, [REMEMBERING, Start::PERIODIC], 1);
    let problem = problem(fractional(), Some(1.0), records, [true, false]).stopped_by(&stop);
    let x = [0.35, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9];
    let other = [0.3, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9];
    let (r, solution) = (residuals(&problem, &x), problem.solve(&x));
    stop.request();
    assert_eq!(problem.best(), Some(x.to_vec()));
    assert_eq!((residuals(&problem, &x), problem.solve(&x)), (r, solution));
    let mut out = vec![0.0; problem.residual_count()];
    assert!(!problem.residuals(&other, &mut problem.workspace(), &mut out));
    assert!(problem.linearise(&x).is_none());
}

/// A stop may come between a trial and its acceptance: the search then ends at the point before it.
#[test]
fn a_stopped_problem_is_solved_at_its_best_point() {
    let stop = Stop::new();
    let records = records(Scheme::BandLimited, false, [REMEMBERING, Start::PERIODIC], 1);
    let problem = problem(fractional(), Some(1.0), records, [true, false]).stopped_by(&stop);
    let points =
        [[0.35, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9], [0.3, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9]];
    let costs = points.map(|x| problem.cost(&x, &mut problem.workspace()));
    let better = if costs[0] < costs[1] { points[0] } else { points[1] };
    let solution = problem.solve(&better);
    assert!(costs[0] != costs[1] && solution.is_some());
    stop.request();
    for x in points {
        assert_eq!(problem.solve(&x), solution);
    }
}

#[test]
fn a_stopped_problem_knows_its_best_point_with_its_modes_in_order() {
    let stop = Stop::new();
    let records = records(Scheme::BandLimited, false, [REMEMBERING, Start::PERIODIC], 1);
    let form = DynamicForm { modes: Modes::Integer { order: 4 }, creep: Creep::None };
    let problem = problem(form, Some(1.0), records, [true, false]).stopped_by(&stop);
    let x = [0.35, 0.3, 220.0, 0.4, 120.0, 0.7, 0.0034, 0.9];
    let found = residuals(&problem, &x);
    let ordered = problem.in_order(x.to_vec());
    assert_eq!(ordered, [0.35, 0.3, 120.0, 0.7, 220.0, 0.4, 0.0034, 0.9]);
    let size = found.iter().fold(0.0, |largest: f64, r| largest.max(r.abs()));
    for (again, found) in residuals(&problem, &ordered).iter().zip(&found) {
        assert!((again - found).abs() < 1e-10 * size, "{again} {found}");
    }
    stop.request();
    assert_eq!(problem.best().as_ref(), Some(&ordered));
    assert_eq!(residuals(&problem, &ordered), found);
    assert!(problem.solve(&ordered).is_some());
}

#[test]
fn gradient_is_exact_with_transients() {
    let before = [REMEMBERING, REMEMBERING];
    let records = records(Scheme::Tustin, true, before, 1);
    let problem = problem(fractional(), Some(1.0), records, [true, true]);
    let x = [0.35, 0.3, 120.0, 0.4, 1.9, 0.9, 0.0034, 0.9, -0.8];
    let count = problem.residual_count();
    let mut jacobian = vec![0.0; count * x.len()];
    assert_eq!(problem.jacobian(&x, &mut problem.workspace(), &mut jacobian), Derivative::Written);
    let coefficients = problem.linearise(&x).unwrap().coefficients;
    residuals_are_those_of_the_columns(&problem, &x, &coefficients);
    let r = residuals(&problem, &x);
    for (j, range) in problem.bounds().ranges.iter().enumerate() {
        let h = 2e-3 * x[j].abs();
        let cost = |d: f64| {
            let mut at = x.to_vec();
            at[j] += d;
            vec![residuals(&problem, &at).iter().map(|r| 0.5 * r * r).sum::<f64>()]
        };
        let by_steps = difference(h, cost)[0];
        let column = &jacobian[j * count..(j + 1) * count];
        let gradient: f64 = column.iter().zip(&r).map(|(d, r)| d * r).sum();
        let scale: f64 = column.iter().zip(&r).map(|(d, r)| (d * r).abs()).sum();
        assert!((gradient - by_steps).abs() <= 1e-7 * scale, "{}: {gradient} {by_steps}", range.name);
    }
}

/// In coefficients at a frequency inside the data a fit has the same points, costs and, by the chain rule,
/// derivatives; with the memory held it has those of the others.
#[test]
fn coefficients_and_a_held_memory_are_the_same_fit() {
    let before = [REMEMBERING, Start::Rest { voltage_v: 1.0 }];
    let shape = [("threshold_1", 0.5, 0.5), ("threshold_2", 1.3, 1.3), ("threshold_3", 2.5, 2.5)];
    let creeping = DynamicForm { modes: Modes::Fractional, creep: Creep::Fractional };
    let whole = DynamicForm { modes: Modes::Integer { order: 3 }, creep: Creep::None };
    let two = DynamicForm { modes: Modes::TwoFractional, creep: Creep::None };
    for (form, numbers) in [
        (creeping, &[120.0, 0.4, 1.9, 0.9, 0.06, 0.2][..]),
        (whole, &[120.0, 0.4, 0.002]),
        (two, &[120.0, 0.4, 1.9, 0.9, 310.0, 0.2, 2.1, 1.1, 0.7]),
    ] {
        let records = records(Scheme::BandLimited, false, before, 1);
        let family = (three_plays(), &shape[..], &[Role::Projected; 3][..]);
        let problem = of_family(family, form, records, [true, false]).normalised_at(40.0);
        let x = [numbers, &[0.0034, 2.7431]].concat();
        let normalised = Normalised::new(&problem, std::slice::from_ref(&x)).unwrap();
        let point = normalised.coefficients(&x);
        assert!(point.iter().zip(&x).any(|(a, b)| a != b));
        for (back, x) in normalised.own(&point).iter().zip(&x) {
            assert!((back - x).abs() < 1e-12 * x.abs(), "{back} {x}");
        }
        let count = problem.residual_count();
        let mut jacobian = vec![0.0; count * point.len()];
        let written = normalised.jacobian(&point, &mut normalised.workspace(), &mut jacobian);
        assert_eq!(written, Derivative::Written);
        // Numbers of the dynamics alone: the others are those of the problem, which are tested.
        for (j, column) in jacobian.chunks_exact(count).take(numbers.len()).enumerate() {
            let along = |d: f64| {
                let mut at = point.clone();
                at[j] += d;
                let mut r = vec![0.0; count];
                assert!(normalised.residuals(&at, &mut normalised.workspace(), &mut r));
                vec![r.iter().map(|r| 0.5 * r * r).sum::<f64>()]
            };
            let by_steps = difference(2e-3 * point[j], along)[0];
            let r = residuals(&problem, &x);
            let gradient: f64 = column.iter().zip(&r).map(|(d, r)| d * r).sum();
            let scale: f64 = column.iter().zip(&r).map(|(d, r)| (d * r).abs()).sum();
            assert!((gradient - by_steps).abs() <= 1e-7 * scale, "{j}: {gradient} {by_steps} of {scale}");
        }
        let held = problem.holding_memory(&x).unwrap();
        let same = residuals(&held, &x[..x.len() - 1]);
        assert_eq!(same, residuals(&problem, &x));
    }
}
