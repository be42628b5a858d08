//! The Jiles–Atherton model, quasi-static.
//!
//! Sources: D. C. Jiles, D. L. Atherton, "Theory of ferromagnetic hysteresis", *J. Magn. Magn. Mater.* 61
//! (1986) 48–60, doi:10.1016/0304-8853(86)90066-1; the freezing of the irreversible part right after a turn
//! after J. H. B. Deane, *IEEE Trans. Magn.* 30 (1994) 2795–2801.

use hysteron_rt::Scalar;
use hysteron_rt::branch::{self, BranchLaw};

use super::HysteresisError;
use super::columns::{ColumnKernel, simulate_with_sensitivities};
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, Search, ShapeNumber,
};

/// Column m, the magnetisation (polarisation) relative to saturation:
///
/// h = u + α m,  m_an = L(h/a),  L(x) = coth x − 1/x,  m = p + c (m_an − p),
/// dp/dh = (m_an − p)/(δ k) where δ (m_an − p) > 0, otherwise 0,  δ = sign Δu.
///
/// Linear in M_s, its weight \[µm\]. Shape: `anhysteretic` a > 0 \[V\], `pinning` k > 0 \[V\],
/// `reversibility` 0 ≤ c ≤ 1, `coupling` 0 ≤ α < 3a \[V\] (the α of the literature times M_s). The
/// irreversible part p is frozen after a turn until h has come back to its anhysteretic value: without that
/// the susceptibility would be negative there. With it, e = |m_an − p| obeys e' ≤ 1/(3a) − e/k on every
/// branch and starts at 0, so that dp/dh ≤ 1/(3a): for α < 3a the susceptibility dm/du is between 0 and 1/(3a
/// − α), and no branch folds.
///
/// In the effective field h the equation for p is linear (Coleman–Hodgdon with f = L(h/a)): it is solved by
/// its integral, with Gauss points in panels no longer than a or k, and h by Newton's method. Every move is
/// exact to about 1e-13, whatever its length up to 10 000 panels. Virgin at u: on the anhysteretic curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JilesAtherton;

/// Present voltage, effective field, and the irreversible part p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JilesAthertonState<S> {
    u: S,
    /// Initial value of Newton's method.
    field: S,
    irreversible: [S; 1],
}

/// Panels of a move at most.
const PANELS: u16 = 10_000;

impl ColumnKernel for JilesAtherton {
    type State<S: Scalar<Real = f64>> = JilesAthertonState<S>;

    simulate_with_sensitivities!(4);

    fn shape_names(&self) -> &'static [&'static str] {
        branch::JilesAtherton::<f64>::NUMBERS
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        Ok(branch::JilesAtherton::of(shape).check()?)
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> JilesAthertonState<S> {
        let law = branch::JilesAtherton::of(shape);
        let p = law.virgin(u);
        // On the anhysteretic curve m = p.
        JilesAthertonState { u, field: u + law.coupling * p, irreversible: [p] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut JilesAthertonState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let law = branch::JilesAtherton::of(shape);
        let (from, to) = (state.u, S::constant(u));
        let shortest = law.anhysteretic.value().min(law.pinning.value());
        if (u - from.value()).abs() > shortest * f64::from(PANELS) {
            return Err(HysteresisError::Overflow { index: 0 });
        }
        let [p] = state.irreversible;
        let field = law.field(from, p, state.field.value());
        let moved = law.magnetise(p, field, (from, to), PANELS);
        let (increment, field) = moved.ok_or(HysteresisError::Overflow { index: 0 })?;
        *state = JilesAthertonState { u: to, field, irreversible: [p + increment] };
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, shape: &[S], state: &JilesAthertonState<S>, out: &mut [S]) {
        let [p] = state.irreversible;
        let m = branch::JilesAtherton::of(shape).magnetisation(state.field, p);
        out.iter_mut().for_each(|out| *out = m);
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut JilesAthertonState<S>) -> &mut [S] {
        &mut state.irreversible
    }
}

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "jiles-atherton"
    }

    fn summary(&self) -> &'static str {
        "Jiles' and Atherton's magnetisation"
    }

    fn equation(&self) -> &'static str {
        "weight_1 m, m = p + reversibility (m_an - p), m_an = coth(h/anhysteretic) - anhysteretic/h, h = u + \
         coupling m, dp/dh = s (m_an - p)/pinning where that is positive, else 0"
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let (field, share) = (NumberUnit::INPUT, Search::Linear(0.0, 0.95));
        let coupling = Search::Linear(0.0, span.stroke);
        vec![
            ShapeNumber::new(
                "anhysteretic",
                field,
                "width of the anhysteretic curve",
                span.strokes(0.02, 20.0),
            ),
            ShapeNumber::new("pinning", field, "strength of the pinning", span.strokes(0.005, 5.0)),
            ShapeNumber::new("reversibility", NumberUnit::NONE, "share that follows reversibly", share),
            ShapeNumber::new("coupling", field, "feedback of the magnetisation on the field", coupling),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let of = |a: f64| [0.05, 0.2].map(|k| [a, k, 0.1, 0.05 * a]);
        let scaled =
            |[a, k, c, alpha]: [f64; 4]| vec![a * span.stroke, k * span.stroke, c, alpha * span.stroke];
        [0.1, 0.3, 1.0].into_iter().flat_map(of).map(scaled).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![0.23 * span.stroke, 0.07 * span.stroke, 0.12, 0.09 * span.stroke]
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::JilesAtherton::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = JilesAtherton;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> JilesAtherton {
        JilesAtherton
    }
}
