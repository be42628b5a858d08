//! Promise: every family of hysteresis columns agrees with numbers worked out by hand, with another family where theory
//! makes them equal, and with a plain integration of its own equation.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

mod bouc_wen;
mod duhem_and_dahl;
mod generalised_plays;
mod jiles_atherton;
mod plays_and_stops;
mod preisach;
mod rate_dependent_plays;

use hysteron_model::Start;
use hysteron_model::hysteresis::{
    BoucWen, BrokenLine, ClassicalBoucWen, ColumnKernel, ColumnModel, Dahl, DeadZones, DensityLaw, Duhem,
    GeneralisedPlays, HysteresisError, JilesAtherton, KrasnoselskiiPokrovskii, MaxwellSlip,
    ModifiedPrandtlIshlinskii, NonSymmetricBoucWen, NormalisedBoucWen, OneSidedPlays, Plays,
    PrandtlIshlinskii, Preisach, PreisachDensity, RateDependentPrandtlIshlinskii, ReversalCurve,
    SongDerKiureghian, UnitShape,
};
use proptest::collection::vec;
use proptest::prelude::*;

const REST: Start<f64> = Start::Rest { voltage_v: 0.0 };

fn simulate<K: ColumnKernel>(model: &ColumnModel<K>, u: &[f64], start: Start<f64>) -> Vec<f64> {
    let mut v = vec![0.0; u.len()];
    model.simulate(u, start, &mut v).unwrap();
    v
}

/// Column 0 of a kernel.
fn column<K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], start: Start<f64>) -> Vec<f64> {
    let mut out = vec![0.0; kernel.columns() * u.len()];
    kernel.simulate_every(shape, 1, u, start, &mut out).unwrap();
    out.truncate(u.len());
    out
}

/// y after dy/du = f(u, y) from (from, y) to `to`: classical Runge–Kutta, 4000 steps.
fn integrate(from: f64, mut y: f64, to: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    let h = (to - from) / 4000.0;
    for k in 0..4000 {
        let u = from + h * f64::from(k);
        let a = f(u, y);
        let b = f(u + 0.5 * h, y + 0.5 * h * a);
        let c = f(u + 0.5 * h, y + 0.5 * h * b);
        let d = f(u + h, y + h * c);
        y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
    }
    y
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases) }
}

fn prandtl_ishlinskii() -> impl Strategy<Value = PrandtlIshlinskii> {
    (vec(-2.0..2.0_f64, 1..4), vec((0.05..1.5_f64, -1.0..2.0_f64), 1..8)).prop_map(|(polynomial, plays)| {
        let mut threshold = 0.0;
        let (thresholds, weights) = plays
            .into_iter()
            .map(|(gap, weight)| {
                threshold += gap;
                (threshold, weight)
            })
            .unzip();
        PrandtlIshlinskii::new(polynomial, thresholds, weights).unwrap()
    })
}

#[test]
fn column_errors_carry_the_numbers() {
    let shape = |name| move |e: HysteresisError| matches!(e, HysteresisError::ShapeParameter { name: n, .. } if n == name);
    assert!(shape("Duhem rate b")(
        ColumnModel::new(vec![1.0], Duhem { degree: 0 }, vec![-1.0], vec![1.0]).unwrap_err()
    ));
    assert!(shape("Dahl exponent")(
        ColumnModel::new(vec![1.0], Dahl, vec![1.0, f64::NAN], vec![1.0]).unwrap_err()
    ));
    let new = |shape: &[f64], weights: &[f64]| {
        ColumnModel::new(vec![1.0], Dahl, shape.to_vec(), weights.to_vec()).unwrap_err()
    };
    assert_eq!(new(&[1.0], &[1.0]), HysteresisError::ShapeCount { expected: 2, found: 1 });
    assert_eq!(new(&[1.0, 1.0], &[]), HysteresisError::WeightCount { columns: 1, weights: 0 });
    assert_eq!(
        new(&[1.0, 1.0], &[f64::INFINITY]),
        HysteresisError::ColumnWeight { index: 0, value: f64::INFINITY }
    );
    let model = ColumnModel::new(vec![1.0], Dahl, vec![1.0, 1.0], vec![1.0]).unwrap();
    let run = |u: &[f64], start, factor, out: usize| {
        model.simulate_every(factor, u, start, &mut vec![0.0; out]).unwrap_err()
    };
    assert_eq!(run(&[1.0], REST, 1, 2), HysteresisError::Lengths { expected: 1, found: 2 });
    assert_eq!(run(&[1.0], REST, 0, 1), HysteresisError::Factor);
    assert_eq!(run(&[1.0, f64::NAN], REST, 1, 2), HysteresisError::Drive { index: 1 });
    let nowhere = Start::Rest { voltage_v: f64::INFINITY };
    assert_eq!(run(&[1.0], nowhere, 1, 1), HysteresisError::Drive { index: 0 });
    let (mut v, mut none) = ([0.0], []);
    model.simulate(&[1.0], Start::PERIODIC, &mut v).unwrap();
    model.simulate(&[], Start::PERIODIC, &mut none).unwrap();
}
