//! Takács' model: branches of hyperbolic tangents.
//!
//! Source: J. Takács, "A phenomenological mathematical model of hysteresis", *COMPEL* 20 (2001) 1002–1015,
//! doi:10.1108/EUM0000000005771.

use hysteron_rt::branch;

use super::columns::branch_kernel;
use super::family::{
    ColumnFamily, DriveSpan, FamilyDescription, NumberUnit, RuntimeOperator, Search, ShapeNumber,
};

/// Column y \[1\], from −1 to 1, whose branches are hyperbolic tangents: x = (u − centre)/width, s = sgn Δu,
/// a₀ = coercive/width,
///
/// y = s (1 − A) + A tanh(x − s a₀), A set by continuity at every reversal,
///
/// or dy/dx = (1 − s y) (1 + s tanh(x − s a₀)). Takács' loop between ±x_m is f₊ = tanh(x − a₀) + b₁ upwards
/// and f₋ = tanh(x + a₀) − b₁ downwards, b₁ = ½ (tanh(x_m + a₀) − tanh(x_m − a₀)), whose ends must be known
/// beforehand. Here a branch is given by the reversal that it began at and the saturation ±1 that lies ahead
/// of it. The steady loop between ±x_m has A = 1/(1 + b₁) and is Takács' over 1 + b₁; a saturated loop is
/// Takács'.
///
/// The weight is the saturation \[µm\]; the linear part of T(x) is the polynomial's. Shape: `centre`, `width`
/// and `coercive` \[V\]. A virgin device is at the limit of ever smaller loops. A move is exact at any
/// length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Takacs;

branch_kernel!(Takacs, 3);

/// The family.
#[derive(Debug)]
pub(super) struct Entry;

impl FamilyDescription for Entry {
    fn name(&self) -> &'static str {
        "takacs"
    }

    fn summary(&self) -> &'static str {
        "Takacs' T(x): branches of hyperbolic tangents"
    }

    fn equation(&self) -> &'static str {
        "weight_1 y, dy = (1 - s y) (1 + tanh((s (u - centre) - coercive)/width)) du/width"
    }

    fn weight_unit(&self, _: usize) -> NumberUnit {
        NumberUnit::OUTPUT
    }

    fn shape_numbers(&self, _: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let unit = NumberUnit::INPUT;
        let coercive = Search::Linear(0.0, 2.0 * span.stroke);
        vec![
            ShapeNumber::new("centre", unit, "middle of the loop", span.around()),
            ShapeNumber::new("width", unit, "voltage along which a branch rises", span.strokes(0.05, 20.0)),
            ShapeNumber::new("coercive", unit, "half of the loop's width at the middle", coercive),
        ]
    }

    fn starts(&self, _: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        let of = |width: f64| [0.05, 0.2, 0.6].map(|coercive| [width, coercive].map(|x| x * span.stroke));
        let all = [0.3, 1.0, 3.0].into_iter().flat_map(of);
        all.map(|[width, coercive]| vec![span.middle(), width, coercive]).collect()
    }

    fn example(&self, _: usize, span: &DriveSpan) -> Vec<f64> {
        vec![span.middle() - 0.07 * span.stroke, 0.43 * span.stroke, 0.11 * span.stroke]
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        RuntimeOperator::branch(branch::Takacs::of(shape), weights)
    }
}

impl ColumnFamily for Entry {
    type Kernel = Takacs;

    fn kernel(&self, _: usize, _: &[f64], _: f64) -> Takacs {
        Takacs
    }
}

#[cfg(test)]
mod tests {
    use super::super::columns::{ColumnKernel, ColumnSensitivities};
    use super::*;
    use crate::hysteresis::HysteresisError;
    use crate::start::Start;

    /// Centre 0.5 V, width 2 V: x = (u − 0.5)/2; a₀ = 0.3.
    const SHAPE: [f64; 3] = [0.5, 2.0, 0.6];
    const A0: f64 = 0.3;
    const REST: Start<f64> = Start::Rest { voltage_v: 0.5 };

    fn voltage(x: f64) -> f64 {
        0.5 + 2.0 * x
    }

    fn column(shape: &[f64], u: &[f64], start: Start<f64>) -> Vec<f64> {
        let mut out = vec![0.0; u.len()];
        Takacs.simulate_every(shape, 1, u, start, &mut out).unwrap();
        out
    }

    fn voltages(x: &[f64]) -> Vec<f64> {
        x.iter().map(|&x| voltage(x)).collect()
    }

    #[test]
    fn a_saturated_loop_is_that_of_takacs() {
        let up = [-30.0, 0.0, A0, 1.0, 30.0];
        let down = [0.0, -A0, -1.0];
        let y = column(&SHAPE, &voltages(&[&up[..], &down].concat()), REST);
        // f₊ passes 0 at the coercive voltage; the remanence is tanh a₀ = 0.291312612451591.
        assert!((y[1] + 0.291_312_612_451_591).abs() < 1e-14 && y[2].abs() < 1e-14, "{y:?}");
        assert!((y[3] - 0.7_f64.tanh()).abs() < 1e-14, "{y:?}");
        assert!((y[5] - 0.291_312_612_451_591).abs() < 1e-14 && y[6].abs() < 1e-14, "{y:?}");
        assert!((y[7] + 0.7_f64.tanh()).abs() < 1e-14, "{y:?}");
    }

    #[test]
    fn a_steady_loop_is_that_of_takacs_over_its_end() {
        for end in [0.2, 0.8, 1.7] {
            let b1 = 0.5 * (f64::tanh(end + A0) - f64::tanh(end - A0));
            let places: Vec<f64> = (-10..10).map(|k| end * f64::from(k) / 10.0).collect();
            let back = places.iter().map(|x| -x);
            let x: Vec<f64> = places.iter().copied().chain(back).collect();
            let y = column(&SHAPE, &voltages(&x), Start::PERIODIC);
            for (k, (&x, y)) in x.iter().zip(y).enumerate() {
                // The first sample still belongs to the way down.
                let up = k > 0 && k <= 20;
                let wanted = if up { (x - A0).tanh() + b1 } else { (x + A0).tanh() - b1 } / (1.0 + b1);
                assert!((y - wanted).abs() < 1e-12, "end {end}, x {x}: {y} {wanted}");
            }
        }
    }

    #[test]
    fn dying_loops_end_where_a_virgin_device_stands() {
        for u in [-3.0, 0.1, 0.5, 2.0] {
            let loops = (0..40_000_u32).map(|k| {
                let size = 8.0 * f64::exp(-5e-4 * f64::from(k));
                if k % 2 == 0 { u + size } else { u - size }
            });
            let y = column(&SHAPE, &loops.chain([u]).collect::<Vec<_>>(), REST);
            let virgin = column(&SHAPE, &[u], Start::Rest { voltage_v: u });
            assert!((y[40_000] - virgin[0]).abs() < 1e-4, "{u}: {} {}", y[40_000], virgin[0]);
        }
        // Without hysteresis it is the hyperbolic tangent.
        let y = column(&[0.5, 2.0, 0.0], &[voltage(0.4)], Start::Rest { voltage_v: voltage(0.4) });
        assert!((y[0] - 0.4_f64.tanh()).abs() < 1e-15);
    }

    #[test]
    fn only_turning_points_count_and_branches_rise_within_saturation() {
        let turns = [3.0, -1.0, 0.4, -2.5, -2.4, 6.0, 1.0, 5.0, -9.0];
        let coarse = column(&SHAPE, &turns, REST);
        let mut last = 0.5;
        let mut fine = Vec::new();
        for &turn in &turns {
            fine.extend((1..=50).map(|k| last + (turn - last) * f64::from(k) / 50.0));
            last = turn;
        }
        let dense = column(&SHAPE, &fine, REST);
        for (k, wanted) in coarse.iter().enumerate() {
            assert!((dense[50 * k + 49] - wanted).abs() < 1e-13, "turn {k}");
        }
        for (u, y) in fine.windows(2).zip(dense.windows(2)) {
            assert!((u[1] - u[0]) * (y[1] - y[0]) > 0.0 && y[1].abs() < 1.0, "{u:?} {y:?}");
        }
        // Odd about the centre.
        let mirrored: Vec<f64> = turns.iter().map(|u| 1.0 - u).collect();
        for (y, mirror) in coarse.iter().zip(column(&SHAPE, &mirrored, REST)) {
            assert!((y + mirror).abs() < 1e-14);
        }
    }

    #[test]
    fn a_biased_loop_comes_to_rest() {
        let y = column(&SHAPE, &[2.0, 0.0].repeat(60), Start::Rest { voltage_v: -4.0 });
        assert!((y[119] - y[117]).abs() < 1e-13 && (y[3] - y[1]).abs() > 1e-3, "{y:?}");
    }

    #[test]
    fn derivatives_are_differences() {
        let u = [2.0, -1.0, 0.7, 3.0, -2.0, 0.4];
        for start in [Start::Rest { voltage_v: 1.0 }, Start::PERIODIC] {
            let mut out = ColumnSensitivities::default();
            Takacs.simulate_with_sensitivities(&SHAPE, 1, &u, start, &mut out).unwrap();
            for (index, derivatives) in out.d_shape.iter().enumerate() {
                let at = |by: f64| {
                    let mut shape = SHAPE;
                    shape[index] += by;
                    column(&shape, &u, start)
                };
                let (above, below) = (at(1e-5), at(-1e-5));
                for (k, derivative) in derivatives[0].iter().enumerate() {
                    let difference = (above[k] - below[k]) / 2e-5;
                    assert!((derivative - difference).abs() < 1e-8, "{index} {k}: {derivative} {difference}");
                }
            }
        }
    }

    #[test]
    fn shapes_that_are_none_are_refused() {
        for (index, bad) in [(0, f64::NAN), (1, 0.0), (1, f64::INFINITY), (2, -0.1), (2, f64::NAN)] {
            let mut shape = SHAPE;
            shape[index] = bad;
            let error = Takacs.check(&shape);
            assert!(matches!(error, Err(HysteresisError::ShapeParameter { .. })), "{shape:?} {error:?}");
        }
        assert!(Takacs.check(&SHAPE).is_ok());
    }
}
