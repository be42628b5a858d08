//! The Jiles–Atherton model, quasi-static.
//!
//! Sources: D. C. Jiles, D. L. Atherton, "Theory of ferromagnetic hysteresis", *J. Magn. Magn. Mater.* 61
//! (1986) 48–60, doi:10.1016/0304-8853(86)90066-1; the freezing of the irreversible part right after a turn
//! after J. H. B. Deane, *IEEE Trans. Magn.* 30 (1994) 2795–2801.

use hysteron_rt::{GAUSS_LEGENDRE, Scalar, branch, langevin, langevin_slope, rising_root};

use super::HysteresisError;
use super::columns::{ColumnKernel, finite, parameter, positive, simulate_with_sensitivities};
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
    /// Where Newton's method begins.
    field: S,
    irreversible: [S; 1],
}

/// Panels of a move at most.
const PANELS: usize = 10_000;

/// Gauss–Legendre points on \[0, 1\] with their weights for a tenth of a panel's full length; for that the
/// eight of the runtime.
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// The shape in numbers with or without derivatives.
#[derive(Clone, Copy)]
struct Shape<S> {
    a: S,
    k: S,
    c: S,
    alpha: S,
}

impl<S: Scalar<Real = f64>> Shape<S> {
    fn new(shape: &[S]) -> Self {
        let [a, k, c, alpha] = [0, 1, 2, 3].map(|index| parameter(shape, index));
        Self { a, k, c, alpha }
    }

    fn values(self) -> Shape<f64> {
        Shape { a: self.a.value(), k: self.k.value(), c: self.c.value(), alpha: self.alpha.value() }
    }

    fn anhysteretic(self, field: S) -> S {
        langevin(field / self.a)
    }

    fn magnetisation(self, field: S, irreversible: S) -> S {
        irreversible + self.c * (self.anhysteretic(field) - irreversible)
    }

    /// u that goes with h and p.
    fn voltage(self, field: S, irreversible: S) -> S {
        field - self.alpha * self.magnetisation(field, irreversible)
    }

    /// p after h has moved by `way` in the direction of `sign`, starting at `field`.
    fn relaxed(self, field: S, irreversible: S, sign: f64, way: S) -> S {
        let x = way / self.k;
        let points: &[(f64, f64)] =
            if way.value() <= 0.1 * self.a.value().min(self.k.value()) { &FOUR } else { &GAUSS_LEGENDRE };
        let mut sum = S::constant(0.0);
        for &(theta, weight) in points {
            let drawn = self.anhysteretic(field + way.scale(sign * theta));
            sum = sum + ((-x).scale(1.0 - theta)).exp() * drawn.scale(weight);
        }
        (-x).exp() * irreversible + x * sum
    }
}

impl Shape<f64> {
    /// du/dh at fixed p.
    fn frozen_slope(self, field: f64) -> f64 {
        1.0 - self.alpha * self.c * langevin_slope(field / self.a) / self.a
    }

    /// du/dh while p moves in the direction of `sign`.
    fn moving_slope(self, field: f64, irreversible: f64, sign: f64) -> f64 {
        let irreversible_slope = (self.anhysteretic(field) - irreversible) / (sign * self.k);
        self.frozen_slope(field) - self.alpha * (1.0 - self.c) * irreversible_slope
    }
}

/// h at the voltage u for a frozen p.
fn frozen_field<S: Scalar<Real = f64>>(shape: Shape<S>, u: S, irreversible: S, start: f64) -> S {
    let values = shape.values();
    let (at, p) = (u.value(), irreversible.value());
    let reach = values.alpha * 1.0_f64.max(p.abs()) * (1.0 + 1e-9) + f64::MIN_POSITIVE;
    let excess = |h: f64| (values.voltage(h, p) - at, values.frozen_slope(h));
    let root = rising_root(excess, at - reach, at + reach, start);
    refined(root, shape.voltage(S::constant(root), irreversible) - u, values.frozen_slope(root))
}

/// One Newton step from a root in plain numbers: the root with its derivatives.
fn refined<S: Scalar<Real = f64>>(root: f64, excess: S, slope: f64) -> S {
    (-(excess.scale(1.0 / slope))).shift(root)
}

impl ColumnKernel for JilesAtherton {
    type State<S: Scalar<Real = f64>> = JilesAthertonState<S>;

    simulate_with_sensitivities!(4);

    fn shape_names(&self) -> &'static [&'static str] {
        &["anhysteretic", "pinning", "reversibility", "coupling"]
    }

    fn check(&self, shape: &[f64]) -> Result<(), HysteresisError> {
        let Shape { a, k, c, alpha } = Shape::new(shape);
        positive("Jiles–Atherton a", a)?;
        positive("Jiles–Atherton k", k)?;
        finite("Jiles–Atherton coupling α", alpha)?;
        let out_of_range = |name, value, must| Err(HysteresisError::ShapeParameter { name, value, must });
        if !(0.0..=1.0).contains(&c) {
            return out_of_range("Jiles–Atherton c", c, "from 0 to 1");
        }
        if alpha < 0.0 || alpha >= 3.0 * a {
            return out_of_range("Jiles–Atherton coupling α", alpha, "at least 0 and less than 3a");
        }
        Ok(())
    }

    fn columns(&self) -> usize {
        1
    }

    fn virgin<S: Scalar<Real = f64>>(&self, shape: &[S], u: S) -> JilesAthertonState<S> {
        // With c = 1, m = m_an whatever p is.
        let shape = Shape { c: S::constant(1.0), ..Shape::new(shape) };
        let field = frozen_field(shape, u, S::constant(0.0), u.value());
        JilesAthertonState { u, field, irreversible: [shape.anhysteretic(field)] }
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        shape: &[S],
        state: &mut JilesAthertonState<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        let shape = Shape::new(shape);
        let values = shape.values();
        let target = S::constant(u);
        let sign = if u < state.u.value() { -1.0 } else { 1.0 };
        let [mut p] = state.irreversible;
        let mut field = frozen_field(shape, state.u, p, state.field.value());
        state.u = target;
        let behind = sign * (values.anhysteretic(field.value()) - p.value());
        if behind < 0.0 {
            // Frozen until m_an = p, where m = p as well.
            let at = p.value();
            let meets = |h: f64| (values.anhysteretic(h) - at, langevin_slope(h / values.a) / values.a);
            let frozen = frozen_field(shape, target, p, field.value());
            if sign * (values.anhysteretic(frozen.value()) - at) <= 0.0 {
                state.field = frozen;
                return Ok(());
            }
            let (low, high) = (field.value().min(frozen.value()), field.value().max(frozen.value()));
            let root = rising_root(meets, low, high, 0.5 * (low + high));
            field = refined(root, shape.anhysteretic(S::constant(root)) - p, meets(root).1);
        }
        let panel = values.a.min(values.k);
        // h moves at least as far as u.
        let far = (u - values.voltage(field.value(), p.value())).abs() > panel * PANELS as f64;
        for _ in 0..if far { 0 } else { PANELS } {
            let [from, at] = [field.value(), p.value()];
            // Voltage still to go after h has moved by `way`, and its slope.
            let gone = |way: f64| {
                let h = from + sign * way;
                let p = values.relaxed(from, at, sign, way);
                (sign * (values.voltage(h, p) - u), values.moving_slope(h, p, sign))
            };
            if gone(panel).0 < 0.0 {
                let way = S::constant(panel);
                p = shape.relaxed(field, p, sign, way);
                field = field + way.scale(sign);
                continue;
            }
            let guess = sign * (u - values.voltage(from, at)) / values.moving_slope(from, at, sign);
            let root = rising_root(gone, 0.0, panel, guess);
            let way = S::constant(root);
            let excess = shape.voltage(field + way.scale(sign), shape.relaxed(field, p, sign, way)) - target;
            let way = refined(root, excess.scale(sign), gone(root).1);
            state.irreversible = [shape.relaxed(field, p, sign, way)];
            state.field = field + way.scale(sign);
            return Ok(());
        }
        Err(HysteresisError::Overflow { index: 0 })
    }

    fn read<S: Scalar<Real = f64>>(&self, shape: &[S], state: &JilesAthertonState<S>, out: &mut [S]) {
        let [p] = state.irreversible;
        out.iter_mut().for_each(|out| *out = Shape::new(shape).magnetisation(state.field, p));
    }

    fn relaxing<S: Scalar<Real = f64>>(state: &mut JilesAthertonState<S>) -> &mut [S] {
        &mut state.irreversible
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn langevin_function_by_its_series_and_by_its_definition() {
        for k in -400..=400_i32 {
            let x = f64::from(k) / 100.0;
            let (value, slope) = (langevin(x), langevin_slope(x));
            if x.abs() <= 0.5 {
                // x/3 − x³/45 + 2x⁵/945 − x⁷/4725 + 2x⁹/93555 − 1382x¹¹/638512875 …, next term 4x¹³/18243225.
                let c = [
                    1.0 / 3.0,
                    -1.0 / 45.0,
                    2.0 / 945.0,
                    -1.0 / 4725.0,
                    2.0 / 93555.0,
                    -1382.0 / 638_512_875.0,
                ];
                let want = x * c.iter().rev().fold(0.0, |sum, c| sum * x * x + c);
                assert!((value - want).abs() < 3e-11, "{x}");
            } else {
                assert!((value - (1.0 / x.tanh() - 1.0 / x)).abs() < 2e-15, "{x}");
                let want = 1.0 / (x * x) - 1.0 / x.sinh().powi(2);
                assert!((slope - want).abs() < 1e-14, "{x}");
            }
        }
        assert_eq!((langevin(0.0), langevin_slope(0.0)), (0.0, 1.0 - 2.0 / 3.0));
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
        let [anhysteretic, pinning, reversibility, coupling] =
            [0, 1, 2, 3].map(|index| parameter(shape, index));
        let law = branch::JilesAtherton { anhysteretic, pinning, reversibility, coupling };
        RuntimeOperator::branch(law, weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = JilesAtherton;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> JilesAtherton {
        JilesAtherton
    }
}
