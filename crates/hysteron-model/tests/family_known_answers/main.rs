//! Promise: every family of hysteresis columns agrees with numbers worked out by hand, with another family
//! where theory makes them equal, and with a plain integration of its own equation.
// Helpers outside the test functions; a failure is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

mod activated_plays;
mod bouc_wen;
mod duhem_and_dahl;
mod generalised_plays;
mod jiles_atherton;
mod plays_and_stops;
mod preisach;
mod rate_dependent_plays;

use hysteron_model::Start;
use hysteron_model::hysteresis::{
    BoucWen, ColumnKernel, Dahl, DensityLaw, Duhem, GeneralisedPlays, Hysteresis, HysteresisError,
    HysteresisForm, JilesAtherton, KrasnoselskiiPokrovskii, MaxwellSlip, NonSymmetricBoucWen, OneSidedPlays,
    PrandtlIshlinskii, Preisach, PreisachDensity, RateDependentPlays, SongDerKiureghian, UnitShape,
};
use proptest::collection::vec;
use proptest::prelude::*;

const REST: Start<f64> = Start::Rest { voltage_v: 0.0 };

/// v = Σ polynomial\[i−1\] uⁱ + Σ weightsⱼ Hⱼ\[u; shape\].
#[derive(Clone, Debug)]
struct ColumnModel<K> {
    polynomial: Vec<f64>,
    kernel: K,
    shape: Vec<f64>,
    weights: Vec<f64>,
}

fn simulate<K: ColumnKernel>(model: &ColumnModel<K>, u: &[f64], start: Start<f64>) -> Vec<f64> {
    let ColumnModel { polynomial, kernel, shape, weights } = model;
    let mut columns = vec![0.0; kernel.columns() * u.len()];
    kernel.simulate_every(shape, 1, u, start, &mut columns).unwrap();
    let line = |u: f64| polynomial.iter().rev().fold(0.0, |sum, c| (sum + c) * u);
    let memory =
        |k: usize| weights.iter().enumerate().map(|(j, w)| w * columns[j * u.len() + k]).sum::<f64>();
    u.iter().enumerate().map(|(k, &u)| line(u) + memory(k)).collect()
}

/// Where a play of half-width r stands, from rest at 0.
fn play(r: f64, u: &[f64]) -> Vec<f64> {
    let step = |state: &mut f64, u: &f64| {
        *state = state.clamp(u - r, u + r);
        Some(*state)
    };
    u.iter().scan(0.0, step).collect()
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
    use HysteresisError::ShapeParameter;
    let shape = |name| move |e: HysteresisError| matches!(e, ShapeParameter { name: n, .. } if n == name);
    assert!(shape("Duhem rate b")(Duhem { degree: 0 }.check(&[-1.0]).unwrap_err()));
    assert!(shape("Dahl exponent")(Dahl.check(&[1.0, f64::NAN]).unwrap_err()));
    let dahl: HysteresisForm = "dahl".parse().unwrap();
    let new = |shape: &[f64], weights: &[f64]| dahl.operator(vec![1.0], weights, shape);
    let refused = |shape: &[f64], weights: &[f64]| new(shape, weights).unwrap_err();
    assert_eq!(refused(&[1.0], &[1.0]), HysteresisError::ShapeCount { expected: 2, found: 1 });
    assert_eq!(refused(&[1.0, 1.0], &[]), HysteresisError::WeightCount { columns: 1, weights: 0 });
    assert_eq!(
        refused(&[1.0, 1.0], &[f64::INFINITY]),
        HysteresisError::ColumnWeight { index: 0, value: f64::INFINITY }
    );
    let model = new(&[1.0, 1.0], &[1.0]).unwrap();
    let run = |model: &Hysteresis, u: &[f64], start, factor: usize, out: usize| {
        model.simulate_every(factor, u, start, &mut vec![0.0; out])
    };
    let refused = |u: &[f64], start, factor, out| run(&model, u, start, factor, out).unwrap_err();
    assert_eq!(refused(&[1.0], REST, 1, 2), HysteresisError::Lengths { expected: 1, found: 2 });
    assert_eq!(refused(&[1.0], REST, 0, 1), HysteresisError::Factor);
    assert_eq!(refused(&[1.0, f64::NAN], REST, 1, 2), HysteresisError::Drive { index: 1 });
    let nowhere = Start::Rest { voltage_v: f64::INFINITY };
    assert_eq!(refused(&[1.0], nowhere, 1, 1), HysteresisError::Drive { index: 0 });
    run(&model, &[1.0], Start::PERIODIC, 1, 1).unwrap();
    run(&model, &[], Start::PERIODIC, 1, 0).unwrap();
}
