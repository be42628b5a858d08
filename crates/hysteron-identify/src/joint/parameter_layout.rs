//! The parameters of a joint fit: which are searched, held or eliminated, and their values.

use super::super::layout::Role;
use hysteron_model::dynamics::{DynamicForm, ParameterKind};
use hysteron_model::hysteresis::{Hysteresis, HysteresisForm};
use hysteron_model::model_file::polynomial_name;

/// The delay's name among the parameters.
pub(super) const DELAY: &str = "delay";

/// Roles of the parameters of a joint fit.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct JointLayout {
    /// Coefficients of u, u², …
    pub(in super::super) polynomial: Vec<Role>,
    /// Weights of the hysteresis.
    pub(in super::super) weights: Vec<Role>,
    /// Its shape numbers: β' and γ' of the unit-α form, n.
    pub(in super::super) shape: Vec<Role>,
    /// Parameters of the dynamics, in the order of [`DynamicForm::parameters`].
    pub(in super::super) form: Vec<Role>,
    pub(in super::super) delay: Role,
    /// Memory of each record; `Fixed(0)` where it is known.
    pub(in super::super) memory: Vec<Role>,
}

impl JointLayout {
    /// Parameters the output is linear in: coefficients of u, u², …, then weights.
    pub(in super::super) fn linear(&self) -> impl Iterator<Item = &Role> {
        self.polynomial.iter().chain(&self.weights)
    }

    /// Role of a parameter of the dynamics, where the family `form` has it.
    pub(super) fn role(&self, form: &DynamicForm, kind: ParameterKind) -> Option<Role> {
        let place = form.parameters().iter().position(|parameter| parameter.kind == kind)?;
        self.form.get(place).copied()
    }

    /// Index of a parameter of the dynamics in the search vector, if searched.
    pub(super) fn place(&self, form: &DynamicForm, kind: ParameterKind) -> Option<usize> {
        self.role(form, kind).and_then(Role::index)
    }

    /// Name of a linear parameter.
    pub(in super::super) fn linear_name(&self, index: usize, form: HysteresisForm) -> String {
        match index.checked_sub(self.polynomial.len()) {
            None => polynomial_name(index + 1).into_owned(),
            Some(weight) => form.weight_names().swap_remove(weight),
        }
    }
}

/// Values of all parameters of a joint fit.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct JointSolution {
    pub(in super::super) hysteresis: Hysteresis,
    /// Shape numbers as they are searched.
    pub(in super::super) shape: Vec<f64>,
    pub(in super::super) form: Vec<f64>,
    pub(in super::super) delay_s: f64,
    /// Memory of each record \[V\], as it is searched.
    pub(in super::super) memory: Vec<f64>,
}
