//! Promise: every family of hysteresis columns agrees with numbers worked out by hand, with another family where theory
//! makes them equal, and with a plain integration of its own equation.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron::hysteresis::{
    BoucWen, BrokenLine, ColumnKernel, ColumnModel, ColumnStart, Dahl, DeadZones, Duhem, GeneralisedPlays,
    HysteresisError, KrasnoselskiiPokrovskii, MaxwellSlip, ModifiedPrandtlIshlinskii, OneSidedPlays,
    PlayStart, Plays, PrandtlIshlinskii, Start,
};
use proptest::collection::vec;
use proptest::prelude::*;

const REST: ColumnStart = ColumnStart::Virgin { u: 0.0 };

fn simulate<K: ColumnKernel>(model: &ColumnModel<K>, u: &[f64], start: ColumnStart) -> Vec<f64> {
    let mut v = vec![0.0; u.len()];
    model.simulate(u, start, &mut v).unwrap();
    v
}

/// Column 0 of a kernel.
fn column<K: ColumnKernel>(kernel: &K, shape: &[f64], u: &[f64], start: ColumnStart) -> Vec<f64> {
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

#[test]
fn the_duhem_loop_by_hand() {
    // From rest y₀ = (1 − e^(−bu))/b; settled between ±A it is tanh(bA)/b at the top. y₁ = (u − 1/b)/b + c e^(−bu) going up
    // and its mirror image going down, so that c = A/(b sinh bA) and y₁ = (A coth(bA) − 1/b)/b at both ends.
    let (b, a) = (0.4_f64, 3.0);
    let y = column(&Duhem { degree: 0 }, &[b], &[1.0, 2.5], REST);
    for (y, u) in y.iter().zip([1.0, 2.5]) {
        assert!((y - (1.0 - (-b * u).exp()) / b).abs() < 1e-15);
    }
    let mut out = [0.0; 4];
    Duhem { degree: 1 }.simulate_every(&[b], 1, &[a, -a], ColumnStart::Periodic, &mut out).unwrap();
    let top = (b * a).tanh() / b;
    let ends = (a / (b * a).tanh() - 1.0 / b) / b;
    for (got, want) in out.iter().zip([top, -top, ends, ends]) {
        assert!((got - want).abs() < 1e-14, "{out:?} {want}");
    }
}

#[test]
fn a_slope_function_equal_to_the_derivative_leaves_no_hysteresis() {
    let f = vec![2.0, -0.25, 0.125];
    let g = [2.0, -0.5, 0.375];
    let model = Duhem::from_coleman_hodgdon(0.7, f.clone(), &g).unwrap();
    assert_eq!(model.weights.iter().map(|w| w.abs()).fold(0.0, f64::max), 0.0);
    let u = [3.0, -1.0, 2.0];
    assert_eq!(simulate(&model, &u, REST), u.map(|u| model.polynomial_at(u)));
    assert_eq!(model.slope_function(), g);
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn duhem_columns_solve_the_equation_of_coleman_and_hodgdon(
        rate in 0.05..1.5_f64, f in vec(-1.0..1.0_f64, 1..5), g in vec(-1.0..1.0_f64, 1..4),
        turns in vec(-5.0..5.0_f64, 1..6), rest in -2.0..2.0_f64,
    ) {
        let model = Duhem::from_coleman_hodgdon(rate, f.clone(), &g).unwrap();
        let v = simulate(&model, &turns, ColumnStart::Virgin { u: rest });
        let value = |c: &[f64], u: f64| c.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let f_at = |u: f64| u * value(&f, u);
        let (mut from, mut z) = (rest, f_at(rest));
        for (&to, v) in turns.iter().zip(&v) {
            let s = if to < from { -1.0 } else { 1.0 };
            z = integrate(from, z, to, |u, z| s * rate * (f_at(u) - z) + value(&g, u));
            from = to;
            // Runge–Kutta of order 4 with steps of 2.5e-3 V at most.
            prop_assert!((v - z).abs() < 1e-8 * (1.0 + z.abs()), "{v} {z}");
        }
    }

    #[test]
    fn dahl_with_exponent_one_is_bouc_wen_without_gamma(
        reach in 0.2..8.0_f64, stiffness in 0.1..4.0_f64, u in vec(-6.0..6.0_f64, 1..40), rest in -2.0..2.0_f64,
    ) {
        let dahl = Dahl::from_saturation(vec![2.0, 0.1], stiffness, stiffness * reach, 1.0).unwrap();
        let bouc_wen = BoucWen::new(vec![2.0, 0.1], stiffness, 1.0 / reach, 0.0, 1.0).unwrap();
        let mut want = vec![0.0; u.len()];
        bouc_wen.simulate(&u, Start::Rest { u: rest }, &mut want).unwrap();
        for (v, want) in simulate(&dahl, &u, ColumnStart::Virgin { u: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 2e-13, "{v} {want}");
        }
        bouc_wen.simulate(&u, Start::Periodic, &mut want).unwrap();
        for (v, want) in simulate(&dahl, &u, ColumnStart::Periodic).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-11, "{v} {want}");
        }
    }

    #[test]
    fn dahl_solves_its_own_equation(
        reach in 0.5..8.0_f64, exponent in 0.2..3.0_f64, turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let zeta = column(&Dahl, &[reach, exponent], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = if to < from { -1.0 } else { 1.0 };
            z = integrate(from, z, to, |_, z| (1.0 - s * z / reach).max(0.0).powf(exponent));
            from = to;
            // Where ζ saturates within the move (i < 1) the last step of Runge–Kutta meets a kink.
            let tolerance = if exponent < 1.0 { 2e-3 } else { 1e-9 };
            prop_assert!((zeta - z).abs() < tolerance, "{zeta} {z}");
            z = *zeta;
        }
    }
}

#[test]
fn dahl_by_hand() {
    // i = 0 is a stop: up to u_c, then back with slope 1.
    assert_eq!(column(&Dahl, &[1.0, 0.0], &[0.5, 3.0, 2.5, 0.0], REST), [0.5, 1.0, 0.5, -1.0]);
    // i = 2: x = 1/(1 + u/u_c), ζ = u_c u/(u_c + u).
    let zeta = column(&Dahl, &[2.0, 2.0], &[1.0, 4.0], REST);
    assert!((zeta[0] - 2.0 / 3.0).abs() < 1e-15 && (zeta[1] - 4.0 / 3.0).abs() < 1e-15, "{zeta:?}");
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
    let nowhere = ColumnStart::Virgin { u: f64::INFINITY };
    assert_eq!(run(&[1.0], nowhere, 1, 1), HysteresisError::Drive { index: 0 });
    let (mut v, mut none) = ([0.0], []);
    model.simulate(&[1.0], ColumnStart::Periodic, &mut v).unwrap();
    model.simulate(&[], ColumnStart::Periodic, &mut none).unwrap();
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
fn a_stop_by_hand() {
    let model =
        ColumnModel::new(vec![1.0], MaxwellSlip { thresholds: vec![1.0] }, vec![1.0], vec![-2.0]).unwrap();
    assert_eq!(simulate(&model, &[0.5, 3.0, 2.0, -1.0], REST), [-0.5, 1.0, 2.0, 1.0]);
    // Dahl's exponent 0.
    let stop = column(&MaxwellSlip { thresholds: vec![1.0] }, &[1.0], &[0.5, 3.0, 2.5, 0.0], REST);
    assert_eq!(stop, column(&Dahl, &[1.0, 0.0], &[0.5, 3.0, 2.5, 0.0], REST));
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn stops_are_plays_in_other_coordinates(
        plays in prandtl_ishlinskii(), u in vec(-6.0..6.0_f64, 1..40), rest in -2.0..2.0_f64,
    ) {
        let stops = ColumnModel::<MaxwellSlip>::from(&plays);
        stops.validate().unwrap();
        let mut states = vec![0.0; plays.weights.len()];
        let mut want = vec![0.0; u.len()];
        plays.simulate(&u, PlayStart::Rest { u: rest }, &mut states, &mut want).unwrap();
        for (v, want) in simulate(&stops, &u, ColumnStart::Virgin { u: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-12 * (1.0 + want.abs()), "{v} {want}");
        }
        plays.simulate(&u, PlayStart::Periodic, &mut states, &mut want).unwrap();
        for (v, want) in simulate(&stops, &u, ColumnStart::Periodic).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-12 * (1.0 + want.abs()), "{v} {want}");
        }
        let back = PrandtlIshlinskii::from(&stops);
        prop_assert_eq!(&back.thresholds, &plays.thresholds);
        prop_assert_eq!(&back.weights, &plays.weights);
        prop_assert!((back.polynomial[0] - plays.polynomial[0]).abs() < 1e-14);
        prop_assert_eq!(&back.polynomial[1..], &plays.polynomial[1..]);
    }

    #[test]
    fn columns_of_plays_are_the_plays_of_prandtl_ishlinskii(
        plays in prandtl_ishlinskii(), scale in 0.3..3.0_f64, u in vec(-6.0..6.0_f64, 1..40),
    ) {
        let PrandtlIshlinskii { polynomial, thresholds, weights } = plays;
        let scaled = thresholds.iter().map(|r| scale * r).collect();
        let model = PrandtlIshlinskii::new(polynomial.clone(), scaled, weights.clone()).unwrap();
        let columns = ColumnModel::new(polynomial, Plays { thresholds }, vec![scale], weights).unwrap();
        let mut want = vec![0.0; u.len()];
        model.simulate(&u, PlayStart::Rest { u: 1.0 }, &mut vec![0.0; model.weights.len()], &mut want).unwrap();
        for (v, want) in simulate(&columns, &u, ColumnStart::Virgin { u: 1.0 }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-12 * (1.0 + want.abs()), "{v} {want}");
        }
    }

    #[test]
    fn a_one_sided_play_is_a_play_of_half_the_width(
        width in 0.2..4.0_f64, u in vec(0.0..6.0_f64, 1..40),
    ) {
        // Once both have been taken along, they differ by r/2.
        let u: Vec<f64> = [-10.0, 10.0].into_iter().chain(u).collect();
        let one = column(&OneSidedPlays { thresholds: vec![width] }, &[1.0], &u, REST);
        let play = column(&Plays { thresholds: vec![0.5 * width] }, &[1.0], &u, REST);
        for (one, play) in one.iter().zip(&play) {
            prop_assert!((one - (play - 0.5 * width)).abs() < 1e-14);
        }
    }
}

#[test]
fn a_generalised_play_by_hand() {
    // γ_r = tanh(u − 1), γ_l = tanh(u + 1), r = 0.2: between them from rest, which is 0.
    let play = column(
        &GeneralisedPlays { thresholds: vec![0.2] },
        &[1.0, 1.0, 1.0, -1.0],
        &[0.5, 2.0, 1.0, -1.0],
        REST,
    );
    let want = [0.0, 1.0_f64.tanh() - 0.2, 1.0_f64.tanh() - 0.2, 0.2];
    for (play, want) in play.iter().zip(want) {
        assert!((play - want).abs() < 1e-15, "{play} {want}");
    }
}

#[test]
fn a_kernel_of_krasnoselskii_and_pokrovskii_by_hand() {
    // Grid {−1, 1}, ramps of 2 V: column 1 is (−1, 1), up from 0 to 2 V, down from 0 to −2 V.
    let kernel = KrasnoselskiiPokrovskii { range: [-1.0, 1.0], lines: 2 };
    let u = [0.5, 1.5, 0.0, -1.25, -0.5, 0.25, 3.0];
    let mut out = [0.0; 21];
    kernel.simulate_every(&[2.0], 1, &u, REST, &mut out).unwrap();
    assert_eq!(out[7..14], [0.0, 0.5, 0.5, -0.25, -0.25, -0.25, 1.0]);
    // Equal ends: the ramp itself.
    assert_eq!(out[..7], u.map(|u: f64| (u + 1.0).clamp(-1.0, 1.0)));
    assert_eq!(out[14..], u.map(|u: f64| (u - 1.0).clamp(-1.0, 1.0)));
}

#[test]
fn a_broken_line_by_hand() {
    let line = BrokenLine { linear: 1.0, thresholds: vec![-1.0, 2.0], weights: vec![1.0, -0.5] };
    for (x, y) in [(-3.0, -5.0), (-1.0, -1.0), (0.5, 0.5), (2.0, 2.0), (4.0, 3.0)] {
        assert_eq!(line.at(x), y);
    }
    let inverse = line.inverse().unwrap();
    assert_eq!(inverse, BrokenLine { linear: 1.0, thresholds: vec![-1.0, 2.0], weights: vec![-0.5, 1.0] });
    let falling = BrokenLine { weights: vec![1.0, -1.5], ..line };
    assert_eq!(falling.inverse(), Err(HysteresisError::PartialSlope { plays: 1, slope: -0.5 }));
    assert_eq!(column(&DeadZones { thresholds: vec![1.0] }, &[], &[0.5, 3.0, -2.0], REST), [0.0, 2.0, 0.0]);
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn generalised_plays_between_equal_envelopes_are_plays_of_the_envelope(
        rise in 0.05..0.5_f64, centre in -1.0..1.0_f64, weights in vec(-1.0..1.0_f64, 3),
        u in vec(-6.0..6.0_f64, 1..40), rest in -2.0..2.0_f64,
    ) {
        let thresholds = vec![0.1, 0.25, 0.6];
        let gamma = |u: f64| (rise * (u - centre)).tanh();
        let kernel = GeneralisedPlays { thresholds: thresholds.clone() };
        let model =
            ColumnModel::new(vec![0.0], kernel, vec![rise, centre, rise, centre], weights.clone()).unwrap();
        let plays = PrandtlIshlinskii::new(vec![0.0], thresholds, weights).unwrap();
        let through: Vec<f64> = u.iter().map(|&u| gamma(u)).collect();
        let mut want = vec![0.0; u.len()];
        plays.simulate(&through, PlayStart::Rest { u: gamma(rest) }, &mut [0.0; 3], &mut want).unwrap();
        for (v, want) in simulate(&model, &u, ColumnStart::Virgin { u: rest }).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-14, "{v} {want}");
        }
    }

    #[test]
    fn the_inverse_of_generalised_plays_gives_the_output_back(
        right in (0.1..0.3_f64, 0.0..0.5_f64), left in (0.1..0.3_f64, -0.5..0.0_f64),
        weights in vec(0.05..1.0_f64, 4), shares in vec(-0.9..0.9_f64, 1..30),
    ) {
        let kernel = GeneralisedPlays { thresholds: vec![0.25, 0.35, 0.4, 0.6] };
        let shape = vec![right.0, right.1, left.0, left.1];
        // Within reach of every play: Σ w (1 − r) less something.
        let top: f64 = kernel.thresholds.iter().zip(&weights).map(|(r, w)| w * (1.0 - r)).sum();
        let model = ColumnModel::new(vec![0.0], kernel, shape.clone(), weights.clone()).unwrap();
        let mut state = model.kernel.virgin(&shape, 0.0);
        let mut row = [0.0; 4];
        for share in shares {
            let v = share * top;
            let u = model.inverse_step(&state, v).unwrap();
            model.kernel.step(&shape, &mut state, u, &mut row).unwrap();
            let got: f64 = row.iter().zip(&weights).map(|(f, w)| f * w).sum();
            prop_assert!((got - v).abs() < 1e-13, "{got} {v}");
        }
        let beyond = model.inverse_step(&state, 2.0 * top);
        let refused = matches!(beyond, Err(HysteresisError::OutOfReach { .. }));
        prop_assert!(refused, "{beyond:?}");
    }

    #[test]
    fn kernels_within_their_ramps_are_plays(u in vec(-6.0..6.0_f64, 1..40)) {
        // Ramps of 40 V: ξ = (2/a) (F_r − (p₁ + p₂)/2), r = (p₂ − p₁)/2.
        let kernel = KrasnoselskiiPokrovskii { range: [-3.0, 3.0], lines: 4 };
        let mut out = vec![0.0; 10 * u.len()];
        kernel.simulate_every(&[40.0], 1, &u, REST, &mut out).unwrap();
        for i in 0..4 {
            for j in 0..i {
                let (low, high) = (kernel.line(j), kernel.line(i));
                let play = column(&Plays { thresholds: vec![0.5 * (high - low)] }, &[1.0], &u, REST);
                let at = (i * (i + 1) / 2 + j) * u.len();
                for (xi, play) in out[at..at + u.len()].iter().zip(&play) {
                    prop_assert!((xi - (play - 0.5 * (low + high)) / 20.0).abs() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn the_modified_operator_and_its_inverse_undo_each_other(
        weights in vec(0.0..1.0_f64, 3), line in vec(-0.2..1.0_f64, 4), u in vec(-6.0..6.0_f64, 1..40),
    ) {
        let plays = PrandtlIshlinskii::new(vec![0.5], vec![0.5, 1.0, 2.5], weights).unwrap();
        let line = BrokenLine { linear: 0.8, thresholds: vec![-3.0, -0.5, 1.0, 2.0], weights: line };
        let model = ModifiedPrandtlIshlinskii::new(plays, line).unwrap();
        let start = PlayStart::Rest { u: 0.0 };
        let (mut v, mut back) = (vec![0.0; u.len()], vec![0.0; u.len()]);
        model.simulate_every(1, &u, start, &mut [0.0; 3], &mut v).unwrap();
        model.inverse().unwrap().simulate(&v, start, &mut [0.0; 3], &mut back).unwrap();
        for (u, back) in u.iter().zip(&back) {
            prop_assert!((u - back).abs() < 1e-12, "{u} {back}");
        }
    }
}
