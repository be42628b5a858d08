//! Scratch that passes from one problem to another.

use super::*;

const SHAPE: [(&str, f64, f64); 3] =
    [("threshold_1", 0.5, 0.5), ("threshold_2", 1.3, 1.3), ("threshold_3", 2.5, 2.5)];

/// Residuals and derivatives at `x`.
fn evaluated(problem: &JointProblem, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut ws = problem.workspace();
    let (mut r, mut jacobian) = (residuals(problem, x), vec![0.0; problem.residual_count() * x.len()]);
    assert!(problem.residuals(x, &mut ws, &mut r));
    assert_eq!(problem.jacobian(x, &mut ws, &mut jacobian), Derivative::Written);
    (r, jacobian)
}

/// Workspaces handed from one problem to another on the same records, with other dynamics, weights or a held
/// memory, and back: the residuals and derivatives are those of new workspaces to the bit.
#[test]
fn problems_on_the_same_records_share_workspaces() {
    let plain = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let creeping = DynamicForm { creep: Creep::Fractional, ..plain };
    let of = |form: DynamicForm, role: Role| {
        let records = records(Scheme::BandLimited, false, [REMEMBERING; 2], 1);
        of_family((three_plays(), &SHAPE, &[role; 3]), form, records, [true, true])
    };
    let numbers = [120.0, 0.4, 1.9, 0.9, 0.06, 0.2];
    let at = |form: DynamicForm| [&numbers[..form.parameter_count()], &[0.0034, 2.7431, 1.2]].concat();
    let spare = SpareWorkspaces::default();
    let [free, positive] = [Role::Projected, Role::OneSided(1.0)];
    for (form, role) in
        [(plain, free), (creeping, positive), (plain, positive), (creeping, free), (plain, free)]
    {
        let x = at(form);
        let [fresh, shared] = [of(form, role), of(form, role).sharing(&spare)];
        assert_eq!(evaluated(&shared, &x), evaluated(&fresh, &x));
        let [fresh, shared] = [&fresh, &shared].map(|problem| problem.holding_memory(&x).unwrap());
        let x = &x[..x.len() - 2];
        assert_eq!(evaluated(&shared, x), evaluated(&fresh, x));
    }
}

/// Outputs of the operators handed from a problem on reduced records to that on all samples, which both then go on
/// from to another memory: the residuals and derivatives are those of new problems to the bit.
#[test]
fn outputs_are_handed_to_the_problem_on_all_samples() {
    let of = |factor| {
        let records = records(Scheme::BandLimited, false, [REMEMBERING; 2], factor);
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        of_family((three_plays(), &SHAPE, &[Role::OneSided(1.0); 3]), form, records, [true, true])
    };
    let x = [120.0, 0.4, 1.9, 0.9, 0.0034, 2.7431, 1.2];
    let other = [110.0, 0.4, 1.9, 0.9, 0.0034, 2.1, 1.9];
    let (reduced, whole) = (of(4), of(1));
    let _ = evaluated(&reduced, &x);
    reduced.hand_outputs_to(&whole);
    for at in [x, x, other, x] {
        assert_eq!(evaluated(&whole, &at), evaluated(&of(1), &at));
        assert_eq!(evaluated(&reduced, &at), evaluated(&of(4), &at));
    }
}
