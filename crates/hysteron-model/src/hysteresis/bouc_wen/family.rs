//! Bouc–Wen as a family: one column ζ, the weight α, the sign −1. A model has the article's β and γ, its
//! columns those of the unit-α form, β' and γ'.

use std::ops::Range;

use super::{Admissibility, BoucWen, BoucWenState, UnitShape, run};
use crate::hysteresis::family::{
    ColumnOperators, DriveSpan, FamilyDescription, ModelNumber, Mover, NumberUnit, Place, RuntimeOperator,
    SKEWS, Search, ShapeNumber,
};
use crate::hysteresis::follow::{DriveLimits, Followed, along};
use crate::hysteresis::outputs::Columns;
use crate::hysteresis::{DriveGrid, Hysteresis, HysteresisError, HysteresisForm, Invertibility, polynomial};
use crate::start::Start;
use hysteron_numeric::Meter;

/// Index of n among the shape numbers.
const N: usize = 2;

/// The family.
#[derive(Debug)]
pub(in crate::hysteresis) struct Entry;

impl HysteresisForm {
    /// The Bouc–Wen model.
    pub fn bouc_wen() -> Self {
        Self::of(&Entry, 0)
    }
}

impl From<BoucWen> for Hysteresis {
    fn from(BoucWen { polynomial, alpha, beta, gamma, n }: BoucWen) -> Self {
        Self::unchecked(polynomial, HysteresisForm::bouc_wen(), vec![beta, gamma, n], vec![alpha])
    }
}

impl BoucWen {
    /// The operator, where it is of this family.
    pub fn of(hysteresis: &Hysteresis) -> Option<Self> {
        let is_own = hysteresis.form() == HysteresisForm::bouc_wen();
        let own = || numbers(hysteresis.polynomial(), hysteresis.own_shape(), hysteresis.weights());
        is_own.then(own).flatten()
    }
}

fn numbers(polynomial: &[f64], own_shape: &[f64], weights: &[f64]) -> Option<BoucWen> {
    match (own_shape, weights) {
        (&[beta, gamma, n], &[alpha]) => {
            Some(BoucWen { polynomial: polynomial.to_vec(), alpha, beta, gamma, n })
        }
        _ => None,
    }
}

/// The shape with β and γ times |α| to a power of n, and γ times the sign of α.
fn in_other_scale(shape: &[f64], weights: &[f64], power: impl Fn(f64) -> f64) -> Vec<f64> {
    match (shape, weights) {
        (&[beta, gamma, n], &[alpha]) => {
            let UnitShape { beta, gamma, n } = UnitShape { beta, gamma, n }.scaled(alpha, power(n));
            vec![beta, gamma, n]
        }
        _ => shape.to_vec(),
    }
}

fn unit_shape(shape: &[f64]) -> Result<UnitShape, HysteresisError> {
    match *shape {
        [beta, gamma, n] => Ok(UnitShape { beta, gamma, n }),
        _ => Err(HysteresisError::ShapeCount { expected: 3, found: shape.len() }),
    }
}

/// The streaming operator of a model for z.
fn operator(model: &Hysteresis) -> Result<hysteron_rt::BoucWen<f64>, HysteresisError> {
    let UnitShape { beta, gamma, n } = unit_shape(model.own_shape())?;
    let alpha = model.weights().first().copied().unwrap_or(f64::NAN);
    Ok(hysteron_rt::BoucWen::new(alpha, beta, gamma, n)?)
}

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "bouc-wen"
    }

    fn summary(&self) -> &'static str {
        "Polynomial less one relaxing state: few parameters"
    }

    fn equation(&self) -> &'static str {
        "-z, dz/du = alpha - beta s z |z|^(n-1) - gamma |z|^n"
    }

    fn title(&self, _: usize) -> String {
        "Improved Bouc–Wen hysteresis".into()
    }

    fn printed_equations(&self, polynomial: &str) -> Vec<String> {
        let state = "ż = α u̇ − β |u̇| z |z|ⁿ⁻¹ − γ u̇ |z|ⁿ   (Eq. 1)";
        vec![format!("v = {polynomial} − z"), state.to_owned()]
    }

    fn sign(&self) -> f64 {
        -1.0
    }

    fn weight_name(&self, _: usize) -> String {
        "alpha".into()
    }

    fn weight_reach(&self) -> f64 {
        2.0
    }

    /// β', γ' and n of the unit form.
    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let (n, unit) = (span.exponent, NumberUnit::PER_INPUT);
        // ζ saturates at (β' + γ')^(−1/n) V: sharper, the loop is a pure offset switch. With much less β' a
        // loop is a parabola of size α β': α grows as β' falls, and nothing else changes.
        let (sharpest, bluntest) = (span.sharpest(), 1.0 / span.stroke);
        let [low, high] = if span.holds_exponent {
            [bluntest.powf(n), sharpest.powf(n)]
        } else {
            [bluntest.min(bluntest.powi(4)), sharpest.max(sharpest.powi(4))]
        };
        let [beta, gamma] = if span.is_straight {
            [Search::Held(0.0); 2]
        } else {
            [Search::Linear(1e-3 * low, high), Search::Linear(-high, high)]
        };
        let exponent = match (span.is_straight, span.holds_exponent) {
            (true, false) => Search::Held(1.0),
            (_, true) => Search::Held(n),
            (false, false) => Search::Linear(1.0, 4.0),
        };
        vec![
            ShapeNumber::new("beta", unit, "shape of the loop", beta),
            ShapeNumber::new("gamma", unit, "asymmetry between loading and unloading", gamma),
            ShapeNumber::new("n", NumberUnit::NONE, "smoothness of the transition", exponent),
        ]
    }

    /// α, and the article's β, γ and n, the unit of β and γ being µm¹⁻ⁿ/V.
    fn model_numbers(&self, _: usize) -> Vec<ModelNumber> {
        let shape = NumberUnit::PER_INPUT_OF_EXPONENT;
        [
            ("alpha", NumberUnit::SLOPE, Place::Weight(0)),
            ("beta", shape, Place::Shape(0)),
            ("gamma", shape, Place::Shape(1)),
            ("n", NumberUnit::NONE, Place::Shape(N)),
        ]
        .map(|(name, unit, place)| ModelNumber { name: name.into(), unit, place })
        .into()
    }

    /// β = β'|α|¹⁻ⁿ, γ = sign(α) γ'|α|¹⁻ⁿ.
    fn own_shape(&self, shape: &[f64], weights: &[f64]) -> Vec<f64> {
        in_other_scale(shape, weights, |n| 1.0 - n)
    }

    /// β' = β|α|ⁿ⁻¹, γ' = sign(α) γ|α|ⁿ⁻¹.
    fn column_shape(&self, own_shape: &[f64], weights: &[f64]) -> Vec<f64> {
        in_other_scale(own_shape, weights, |n| n - 1.0)
    }

    /// With z = g Z: ż = g α u̇ − g¹⁻ⁿ (β |u̇| z |z|ⁿ⁻¹ + γ u̇ |z|ⁿ).
    fn scaled_shape(&self, own_shape: &[f64], gain: f64) -> Vec<f64> {
        match *own_shape {
            [beta, gamma, n] => {
                let size = gain.powf(1.0 - n);
                vec![size * beta, size * gamma, n]
            }
            _ => own_shape.to_vec(),
        }
    }

    fn has_exponent(&self) -> bool {
        true
    }

    fn small_loops_drift(&self) -> bool {
        true
    }

    fn undetermined_by_one_loop(&self) -> &'static str {
        "β and γ are distinguished only by the virgin curve, polynomial degree and exponent n only by the \
         shape of one loop"
    }

    fn boundedness(&self, own_shape: &[f64], weights: &[f64]) -> Option<Admissibility> {
        Some(numbers(&[], own_shape, weights)?.admissibility())
    }

    fn share_of_saturation(&self, own_shape: &[f64], weights: &[f64], range_v: f64) -> Option<f64> {
        let model = numbers(&[], own_shape, weights).filter(|model| model.alpha != 0.0)?;
        let shape = model.unit_shape();
        Some((shape.beta + shape.gamma.abs()) * range_v.powf(shape.n))
    }

    fn remembers_output(&self) -> bool {
        true
    }

    /// z(0) = α ζ(0).
    fn own_memory(&self, memory: f64, weights: &[f64]) -> f64 {
        memory * weights.first().copied().unwrap_or(0.0)
    }

    fn memory_of_columns(&self, memory: f64, weights: &[f64]) -> f64 {
        match *weights {
            [alpha] if alpha != 0.0 => memory / alpha,
            _ => 0.0,
        }
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let n = span.exponent;
        let of = |bend: f64| SKEWS.map(|skew| vec![bend.powf(n), skew * bend.powf(n), n]);
        span.bends().into_iter().flat_map(of).collect()
    }

    fn shapes_together_with(&self, index: usize) -> Range<usize> {
        if index < N { 0..N } else { index..index + 1 }
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![4.0 / span.stroke, 1.0 / span.stroke, 1.0]
    }

    fn is_compared_unasked(&self) -> bool {
        true
    }

    fn is_chosen_unasked(&self) -> bool {
        true
    }

    /// Range of ζ up to saturation.
    fn memory_range(&self, _: [f64; 2], stroke: f64) -> [f64; 2] {
        [-stroke, stroke]
    }

    fn first_memory(
        &self,
        shape: &[f64],
        first: f64,
        [low, high]: [f64; 2],
        stroke: f64,
        settled: bool,
    ) -> f64 {
        match *shape {
            [beta, gamma, n] if settled => {
                // Largest ζ at the turning points of a loop over the whole range.
                let saturated = (beta + gamma).powf(-1.0 / n).min(stroke);
                saturated * (2.0 * (first - low) / (high - low) - 1.0)
            }
            _ => 0.0,
        }
    }

    fn runtime(
        &self,
        _: usize,
        _: &mut [f64],
        own_shape: &[f64],
        weights: &[f64],
        _: f64,
    ) -> RuntimeOperator {
        let state = match (own_shape, weights) {
            (&[beta, gamma, n], &[alpha]) => [alpha, beta, gamma, n],
            _ => [f64::NAN; 4],
        };
        RuntimeOperator::states(vec![state])
    }
}

impl ColumnOperators for Entry {
    fn check(&self, _: usize, shape: &[f64]) -> Result<(), HysteresisError> {
        unit_shape(shape)?.operator().map(|_| ())
    }

    fn run(
        &self,
        (_, shape, _): (usize, &[f64], f64),
        DriveGrid { factor, .. }: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        let unit = unit_shape(shape)?;
        let samples =
            if factor == 0 { return Err(HysteresisError::Factor) } else { u.len().div_ceil(factor) };
        match wanted {
            None => {
                out.resize(1, samples, &[], false)?;
                unit.simulate_every(factor, u, start, &mut out.values[0])?;
            }
            Some(wanted) => {
                // β' and γ' come at no cost.
                let exponent = wanted.get(N) == Some(&true);
                let pairs = [(0, 0), (1, 0), (N, 0)];
                out.resize(1, samples, &pairs[..if exponent { 3 } else { 2 }], true)?;
                let Columns { values, partials, by_memory, sensitivities, .. } = &mut *out;
                unit.simulate_with_sensitivities(factor, u, start, exponent, sensitivities)?;
                std::mem::swap(&mut values[0], &mut sensitivities.zeta);
                std::mem::swap(&mut by_memory[0], &mut sensitivities.d_start);
                let own = [&mut sensitivities.d_beta, &mut sensitivities.d_gamma, &mut sensitivities.d_n];
                partials.iter_mut().zip(own).for_each(|(to, from)| std::mem::swap(&mut to.values, from));
            }
        }
        if let Start::Remembering { memory, .. } = start {
            out.rest[0] = memory;
            out.rest_by_memory[0] = 1.0;
        }
        Ok(())
    }

    fn mover(&self, _: usize, shape: &[f64], _: f64, u: f64) -> Result<Box<dyn Mover>, HysteresisError> {
        let operator = unit_shape(shape)?.operator()?;
        Ok(Box::new(MovingState { operator, state: BoucWenState { u, z: 0.0 } }))
    }

    fn add_hysteresis(
        &self,
        model: &Hysteresis,
        _: f64,
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        out: &mut [f64],
    ) -> Result<(), HysteresisError> {
        run(&operator(model)?, grid.factor, u, start, out, |z, v| *v -= z).map(|_| ())
    }

    fn follow(
        &self,
        model: &Hysteresis,
        _: f64,
        wanted: &[f64],
        (rest, memory): (f64, Option<f64>),
        limits: (&DriveLimits, &Meter<'_>),
    ) -> Result<Followed, HysteresisError> {
        let operator = operator(model)?;
        let start = BoucWenState { u: rest, z: memory.unwrap_or(0.0) };
        along(start, rest, wanted, limits, |state, u| {
            let z = operator.step(state, u).map_err(|cause| HysteresisError::RunsAway { index: 0, cause })?;
            Ok(model.polynomial_at(u) - z)
        })
    }

    fn at_rest(&self, model: &Hysteresis, rest: f64, memory: Option<f64>) -> f64 {
        model.polynomial_at(rest) - memory.unwrap_or(0.0)
    }

    fn memory_of_move(&self, model: &Hysteresis, virgin: f64, rest: f64) -> Result<f64, HysteresisError> {
        let mut state = BoucWenState { u: virgin, z: 0.0 };
        let moved = operator(model)?.step(&mut state, rest);
        moved.map_err(|cause| HysteresisError::RunsAway { index: 0, cause })
    }

    /// Between the saturations ±|α| (β' + γ')^(−1/n); ±|α| times the span of the drive where z does not
    /// saturate.
    fn memory_range_of_model(&self, model: &Hysteresis, low: f64, high: f64) -> Option<(f64, f64)> {
        let model = BoucWen::of(model)?;
        let reach = match model.admissibility() {
            Admissibility::Bounded { saturation_v } | Admissibility::BoundedFromRest { saturation_v, .. } => {
                saturation_v
            }
            _ => high - low,
        };
        let limit = model.alpha.abs() * reach;
        (limit > 0.0 && limit.is_finite()).then_some((-limit, limit))
    }

    /// In the bounded class dζ/du lies between 0 and max(1, 2β'/(β' + γ')), so that l' above α times that
    /// (above 0 for α < 0) is sufficient. Where it is not met only a saturated loop need fall, and the drives
    /// decide.
    fn invertibility(&self, model: &Hysteresis, range: [f64; 2], _: Option<f64>) -> Option<Invertibility> {
        let model = BoucWen::of(model)?;
        let Admissibility::Bounded { .. } = model.admissibility() else { return None };
        let shape = model.unit_shape();
        let steepest = (2.0 * shape.beta / (shape.beta + shape.gamma)).max(1.0);
        let needed = if model.alpha > 0.0 { model.alpha * steepest } else { 0.0 };
        match polynomial::not_steeper(&model.polynomial, needed, range) {
            None => Some(Invertibility::Everywhere),
            Some(_) => None,
        }
    }
}

/// ζ with its state.
#[derive(Clone, Debug)]
struct MovingState {
    operator: hysteron_rt::BoucWen<f64>,
    state: BoucWenState,
}

impl Mover for MovingState {
    fn step(&mut self, u: f64, row: &mut [f64]) -> Result<(), HysteresisError> {
        let zeta = self.operator.step(&mut self.state, u);
        row[0] = zeta.map_err(|cause| HysteresisError::RunsAway { index: 0, cause })?;
        Ok(())
    }

    fn rest_at(&mut self, u: f64, row: &mut [f64]) {
        self.state = BoucWenState { u, z: 0.0 };
        row[0] = 0.0;
    }

    fn twin(&self) -> Box<dyn Mover> {
        Box::new(self.clone())
    }
}
