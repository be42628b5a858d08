//! The model at a point of a joint fit.

use super::super::IdentifyError;
use super::super::options::Options;
use super::super::static_step::OFFSET;
use super::campaign::JointMember;
use super::parameter_layout::JointSolution;
use super::problem::JointProblem;
use super::setup::JointSetup;
use hysteron_model::dynamics::{Creep, DynamicForm, Dynamics, Modes};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::{ModelFile, SignalUnits};

/// The model at a point of the search, without standard errors and scores.
pub(super) fn shown(
    problem: &JointProblem,
    x: &[f64],
    setup: &JointSetup<'_>,
) -> Option<hysteron_model::Model> {
    let solution = problem.solve(x)?;
    let law = assemble(&solution, &setup.form, setup.members, setup.options).ok()?;
    let first = &setup.members.first()?.facts.data;
    let units = SignalUnits::of(&first.u_unit, &first.y_unit);
    hysteron_model::Model::try_from(ModelFile::from_model(&law, units)).ok()
}

/// The model of a solution.
pub(in super::super) fn assemble(
    solution: &JointSolution,
    form: &DynamicForm,
    members: &[JointMember<'_>],
    options: &Options,
) -> Result<Model, IdentifyError> {
    let g = form.transfer_function(&solution.form)?;
    let dynamics = match form.modes {
        Modes::None if form.creep == Creep::None => Dynamics::None,
        Modes::None | Modes::Integer { .. } | Modes::Resonances { .. } if form.creep.has_whole_orders() => {
            Dynamics::Integer(g)
        }
        _ => Dynamics::Fractional(g),
    };
    let fastest = members.iter().map(|m| m.rate_hz).fold(0.0, f64::max);
    Ok(Model {
        hysteresis: solution.hysteresis.clone(),
        dynamics,
        offset: options.demands.fixed(OFFSET).unwrap_or(0.0),
        delay_s: solution.delay_s,
        scheme: options.scheme(),
        inter_sample: options.inter_sample(),
        sample_rate_hz: Some(fastest),
    })
}
