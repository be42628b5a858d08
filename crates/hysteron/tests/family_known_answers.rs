//! Promise: every family of hysteresis columns agrees with numbers worked out by hand, with another family where theory
//! makes them equal, and with a plain integration of its own equation.
#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron::hysteresis::{
    BoucWen, BrokenLine, ClassicalBoucWen, ColumnKernel, ColumnModel, ColumnStart, Dahl, DeadZones,
    DensityLaw, Duhem, GeneralisedPlays, HysteresisError, JilesAtherton, KrasnoselskiiPokrovskii,
    MaxwellSlip, ModifiedPrandtlIshlinskii, NonSymmetricBoucWen, NormalisedBoucWen, OneSidedPlays, PlayStart,
    Plays, PrandtlIshlinskii, Preisach, PreisachDensity, RateDependentPrandtlIshlinskii, ReversalCurve,
    SongDerKiureghian, Start, UnitShape,
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

#[test]
fn a_cell_of_relays_by_hand() {
    // Levels 0, 1, 2: column 1 is α in [1, 2], β in [0, 1]. Virgin at 1 V half of it is up.
    let plane = Preisach { levels: vec![0.0, 1.0, 2.0] };
    let cell = |u: &[f64]| {
        let mut out = vec![0.0; 3 * u.len()];
        plane.simulate_every(&[], 1, u, ColumnStart::Virgin { u: 1.0 }, &mut out).unwrap();
        out[u.len()..2 * u.len()].to_vec()
    };
    // Up to 1.5 V: all below that, and above it the triangle under the antidiagonal, 1/8.
    assert_eq!(cell(&[1.0, 1.5, 2.0]), [0.0, 2.0 * 0.625 - 1.0, 1.0]);
    // Down to 0.25 V from 1.5 V: what lies left of it, 1/4, and nothing else: the triangle had β < 0.5.
    // Of it, α + β < 2 with α up to 2 V − 0.25 V all, above that the triangle of 0.25 V: 0.25 − 1/32.
    assert_eq!(cell(&[1.5, 0.25])[1], 2.0 * (0.25 - 1.0 / 32.0) - 1.0);
    assert_eq!(cell(&[0.0, 2.0, 0.5]), [-1.0, 1.0, 0.0]);
    // The ramps of the diagonal.
    let mut out = [0.0; 6];
    plane.simulate_every(&[], 1, &[0.25, 1.75], REST, &mut out).unwrap();
    assert_eq!([&out[..2], &out[4..]], [[-0.5, 1.0], [-1.0, 0.5]]);
}

/// Turning points that count after a history that began in negative saturation: from `low` up, down, up …
fn staircase(low: f64, history: &[f64]) -> Vec<f64> {
    let mut e = vec![low];
    for &u in history {
        if let [.., before, last] = e[..]
            && (u - last) * (last - before) >= 0.0
        {
            e.pop();
        }
        if e.last() != Some(&u) {
            e.push(u);
        }
        while let [.., from, turn, u] = e[..]
            && e.len() > 3
            && (u - turn).abs() >= (turn - from).abs()
        {
            e.drain(e.len() - 3..e.len() - 1);
        }
    }
    e
}

fn weighted_plane() -> impl Strategy<Value = ColumnModel<Preisach>> {
    vec((0.5..2.0_f64, -5.0..-3.0_f64), 2..7).prop_flat_map(|gaps| {
        let mut at = gaps[0].1;
        let above = gaps.iter().map(|(gap, _)| {
            at += gap;
            at
        });
        let levels: Vec<f64> = std::iter::once(gaps[0].1).chain(above).collect();
        let n = levels.len() - 1;
        vec(-0.2..1.0_f64, n * (n + 1) / 2).prop_map(move |weights| {
            ColumnModel::new(vec![0.0], Preisach { levels: levels.clone() }, Vec::new(), weights).unwrap()
        })
    })
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn relays_switched_one_by_one_give_the_cells(turns in vec(0..=6_i32, 1..40)) {
        // Levels and turning points at whole voltages: a cell is a relay at half voltages.
        let plane = Preisach::regular([0.0, 6.0], 7);
        let u: Vec<f64> = [-1].iter().chain(&turns).map(|&u| f64::from(u)).collect();
        let mut out = vec![0.0; 21 * u.len()];
        plane.simulate_every(&[], 1, &u, ColumnStart::Virgin { u: 0.0 }, &mut out).unwrap();
        for i in 0..6 {
            for j in 0..i {
                let (alpha, beta) = (i as f64 + 0.5, j as f64 + 0.5);
                let mut relay = -1.0;
                for (k, &u) in u.iter().enumerate() {
                    relay = if u > alpha { 1.0 } else if u < beta { -1.0 } else { relay };
                    prop_assert_eq!(out[(i * (i + 1) / 2 + j) * out.len() / 21 + k], relay);
                }
            }
        }
    }

    #[test]
    fn the_output_is_a_sum_of_everett_functions(model in weighted_plane(), history in vec(-6.0..6.0_f64, 1..40)) {
        let u: Vec<f64> = std::iter::once(-20.0).chain(history.iter().copied()).collect();
        let v = simulate(&model, &u, REST);
        let total: f64 = model.weights.iter().sum();
        for (k, v) in v.iter().enumerate().skip(1) {
            let turns = staircase(-20.0, &history[..k]);
            let branches = turns.windows(2).map(|pair| {
                let [from, to] = [pair[0], pair[1]];
                if to > from { 2.0 * model.everett(to, from) } else { -2.0 * model.everett(from, to) }
            });
            let want = -total + branches.sum::<f64>();
            prop_assert!((v - want).abs() < 1e-12, "{v} {want} {turns:?}");
        }
    }

    #[test]
    fn virgin_is_what_a_slowly_decaying_voltage_leaves(
        model in weighted_plane(), rest in -3.0..1.0_f64, turns in vec(-6.0..6.0_f64, 1..8),
    ) {
        let decay = (0..24_000).map(|k| {
            let amplitude = 12.0 - 5e-4 * f64::from(k);
            if k % 2 == 0 { rest + amplitude } else { rest - amplitude }
        });
        let count = 24_000;
        let u: Vec<f64> = decay.chain(turns.iter().copied()).collect();
        let from_virgin = simulate(&model, &turns, ColumnStart::Virgin { u: rest });
        // Steps of 5e-4 V beside intervals of at least 0.5 V, up to 21 cells.
        for (v, want) in simulate(&model, &u, REST)[count..].iter().zip(&from_virgin) {
            prop_assert!((v - want).abs() < 2e-2, "{v} {want}");
        }
    }

    #[test]
    fn reversal_curves_give_the_plane_back(model in weighted_plane()) {
        let levels = model.kernel.levels.clone();
        let curves: Vec<ReversalCurve> = (1..levels.len())
            .map(|p| {
                // Down through the levels, with points between them.
                let mut voltages_v: Vec<f64> = (0..=4 * p).map(|k| {
                    let (q, share) = (k / 4, (k % 4) as f64 / 4.0);
                    if k % 4 == 0 { levels[q] } else { levels[q] + share * (levels[q + 1] - levels[q]) }
                }).collect();
                voltages_v.reverse();
                let drive = [&[-20.0], &voltages_v[..]].concat();
                let displacements_um = simulate(&model, &drive, REST)[1..].iter().map(|v| v + 7.0).collect();
                ReversalCurve { voltages_v, displacements_um }
            })
            .collect();
        let again = Preisach::from_reversal_curves(levels, &curves).unwrap();
        for (w, want) in again.weights.iter().zip(&model.weights) {
            prop_assert!((w - want).abs() < 1e-12, "{w} {want}");
        }
    }

    #[test]
    fn reversal_curves_of_another_operator_are_reproduced_at_the_levels(
        plays in prandtl_ishlinskii(), turns in vec(0..=8_usize, 1..30),
    ) {
        // Any operator with return-point memory and congruent loops is a Preisach operator.
        let levels = Preisach::regular([-4.0, 4.0], 9).levels;
        let run = |u: &[f64]| {
            let mut v = vec![0.0; u.len()];
            plays.simulate(u, PlayStart::Rest { u: 0.0 }, &mut vec![0.0; plays.weights.len()], &mut v).unwrap();
            v
        };
        let curves: Vec<ReversalCurve> = (1..9)
            .map(|p| {
                let voltages_v: Vec<f64> = (0..=p).rev().map(|q| levels[q]).collect();
                let displacements_um = run(&[&[-100.0, 100.0, -4.0], &voltages_v[..]].concat())[3..].to_vec();
                ReversalCurve { voltages_v, displacements_um }
            })
            .collect();
        let model = Preisach::from_reversal_curves(levels.clone(), &curves).unwrap();
        // The limiting loop of the plane is closed at its ends; that of plays is where they have turned.
        let before = [-100.0, 100.0, -4.0];
        let u: Vec<f64> = before.into_iter().chain(turns.into_iter().map(|at| levels[at])).collect();
        let (want, got) = (run(&u)[2..].to_vec(), simulate(&model, &u, REST)[2..].to_vec());
        for (got_k, want_k) in got.iter().zip(&want) {
            prop_assert!(((got_k - got[0]) - (want_k - want[0])).abs() < 1e-11, "{got:?} {want:?}");
        }
    }

    #[test]
    fn a_gaussian_density_of_equal_spreads_is_a_product_of_normal_distributions(
        half_width in 0.5..1.5_f64, spread in 0.7..1.5_f64, bias in -0.5..0.5_f64,
    ) {
        let kernel = PreisachDensity { plane: Preisach::regular([-4.0, 4.0], 17), law: DensityLaw::Gaussian };
        let weights = kernel.weights(&[half_width, spread, bias, spread]);
        // α and β are independent with means m₀ ± h₀ and spread √2 σ.
        let share = |mean: f64, low: f64| {
            let z = |x: f64| libm::erf((x - mean) / (2.0 * spread));
            z(low + 0.5) - z(low)
        };
        let line = |index: usize| -4.0 + 0.5 * index as f64;
        let want = |i: usize, j: usize| {
            share(bias + half_width, line(i)) * share(bias - half_width, line(j))
        };
        let reference = weights[10 * 11 / 2 + 5] / want(10, 5);
        for i in 0..16 {
            for j in 0..i {
                let (got, want) = (weights[i * (i + 1) / 2 + j], reference * want(i, j));
                prop_assert!((got - want).abs() < 1e-9 * reference, "{i} {j}: {got} {want}");
            }
        }
        prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}

proptest! {
    #![proptest_config(config(30))]

    #[test]
    fn jiles_atherton_solves_its_own_equations(
        a in 0.5..3.0_f64, k in 0.3..3.0_f64, c in 0.0..1.0_f64, part in 0.0..0.8_f64,
        turns in vec(-6.0..6.0_f64, 1..6),
    ) {
        let alpha = part * 3.0 * a;
        let m = column(&JilesAtherton, &[a, k, c, alpha], &turns, REST);
        let l = |x: f64| if x.abs() < 1e-3 { x / 3.0 - x.powi(3) / 45.0 } else { 1.0 / x.tanh() - 1.0 / x };
        let slope = |x: f64| {
            if x.abs() < 1e-3 { 1.0 / 3.0 - x * x / 15.0 } else { 1.0 / (x * x) - 1.0 / x.sinh().powi(2) }
        };
        // (p, m) over u, from the anhysteretic curve at 0.
        let (mut from, mut p, mut field) = (0.0, 0.0, 0.0);
        for (&to, got) in turns.iter().zip(&m) {
            let s = if to < from { -1.0 } else { 1.0 };
            let rates = |h: f64, p: f64| {
                let away = l(h / a) - p;
                let p_h = if s * away > 0.0 { away / (s * k) } else { 0.0 };
                let m_h = (1.0 - c) * p_h + c * slope(h / a) / a;
                (1.0 / (1.0 - alpha * m_h), p_h / (1.0 - alpha * m_h))
            };
            let step = (to - from) / 20_000.0;
            for _ in 0..20_000 {
                let one = rates(field, p);
                let two = rates(field + 0.5 * step * one.0, p + 0.5 * step * one.1);
                let three = rates(field + 0.5 * step * two.0, p + 0.5 * step * two.1);
                let four = rates(field + step * three.0, p + step * three.1);
                field += step / 6.0 * (one.0 + 2.0 * two.0 + 2.0 * three.0 + four.0);
                p += step / 6.0 * (one.1 + 2.0 * two.1 + 2.0 * three.1 + four.1);
            }
            from = to;
            let want = p + c * (l(field / a) - p);
            // The step across the end of the freezing meets a kink of the rate.
            prop_assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
    }

    #[test]
    fn jiles_atherton_of_small_fields_is_duhem(k in 0.3..3.0_f64, u in vec(-6.0..6.0_f64, 1..10)) {
        // L(x) = x/3 (1 − x²/15 …) with x ≤ 6e-4; from rest at 0 and never turning before its anhysteretic value.
        let tops: Vec<f64> = u.iter().enumerate().map(|(k, u)| if k % 2 == 0 { 6.0 + u } else { -6.0 + u }).collect();
        let a = 1e4;
        let m = column(&JilesAtherton, &[a, k, 0.0, 0.0], &tops, REST);
        let duhem = Duhem::from_coleman_hodgdon(1.0 / k, vec![1.0], &[]).unwrap();
        let v = simulate(&duhem, &tops, REST);
        // Before its first turn; from there on the freezing of p sets them apart.
        prop_assert!((3.0 * a * m[0] - v[0]).abs() < 1e-6, "{} {}", 3.0 * a * m[0], v[0]);
    }

    #[test]
    fn six_coefficients_solve_their_own_equation(
        first in 0.6..1.5_f64, others in prop::array::uniform5(-0.1..0.1_f64), n in 1.0..3.0_f64,
        turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let [a, b, c, d, e] = others;
        let zeta = column(&SongDerKiureghian { n }, &[first, a, b, c, d, e], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            // Split where u passes 0: x is its sign.
            let legs = if from * to < 0.0 { vec![(from, 0.0), (0.0, to)] } else { vec![(from, to)] };
            for (from, to) in legs {
                let x = f64::signum(from + to);
                z = integrate(from, z, to, |_, z| {
                    let w = z.signum();
                    1.0 - z.abs().powf(n) * (first * s * w + a * x * s + b * x * w + c * s + d * w + e * x)
                });
            }
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn the_delta_term_solves_its_own_equation(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, delta in -0.5..0.5_f64, turns in vec(-5.0..5.0_f64, 1..6),
    ) {
        let zeta = column(&NonSymmetricBoucWen, &[beta, part * beta, delta], &turns, REST);
        let (mut from, mut z) = (0.0, 0.0);
        for (&to, zeta) in turns.iter().zip(&zeta) {
            let s = f64::signum(to - from);
            z = integrate(from, z, to, |u, z| 1.0 - (beta * s + part * beta * z.signum()) * z + delta * s * u);
            from = to;
            // The second derivative jumps where ζ passes 0.
            prop_assert!((zeta - z).abs() < 1e-5, "{zeta} {z}");
        }
    }

    #[test]
    fn asymmetric_operators_without_asymmetry_are_bouc_wen(
        beta in 0.2..1.5_f64, part in -0.9..0.9_f64, n in prop_oneof![Just(1.0), Just(2.0), 1.0..3.0_f64],
        u in vec(-6.0..6.0_f64, 1..30), rest in -2.0..2.0_f64,
    ) {
        let gamma = part * beta;
        let run = |beta: f64, gamma: f64, n: f64, u: &[f64], rest: f64| {
            let mut zeta = vec![0.0; u.len()];
            UnitShape { beta, gamma, n }.simulate_every(1, u, Start::Rest { u: rest }, &mut zeta).unwrap();
            zeta
        };
        let start = ColumnStart::Virgin { u: rest };
        let symmetric = column(&NonSymmetricBoucWen, &[beta, gamma, 0.0], &u, start);
        let song = SongDerKiureghian { n };
        let first = column(&song, &[beta, 0.0, 0.0, 0.0, 0.0, 0.0], &u, start);
        let wanted = run(beta, gamma, 1.0, &u, rest).into_iter().zip(run(beta, 0.0, n, &u, rest));
        for ((symmetric, first), (want, want_first)) in symmetric.iter().zip(&first).zip(wanted) {
            prop_assert!((symmetric - want).abs() < 1e-12, "{symmetric} {want}");
            prop_assert!((first - want_first).abs() < 1e-12, "{first} {want_first}");
        }
        // Growing loops about 0, on which ζ never has the sign against u and its direction at once.
        let loops: Vec<f64> = (1..12).map(|k| if k % 2 == 0 { -0.5 } else { 0.5 } * f64::from(k)).collect();
        let three = column(&song, &[beta + gamma, -gamma, gamma, 0.0, 0.0, 0.0], &loops, REST);
        for (zeta, want) in three.iter().zip(run(beta, gamma, n, &loops, 0.0)) {
            prop_assert!((zeta - want).abs() < 1e-12, "{zeta} {want}");
        }
    }

    #[test]
    fn forms_of_bouc_wen_go_there_and_back(
        alpha in prop_oneof![-4.0..-0.1_f64, 0.1..4.0_f64], sum in 0.1..2.0_f64, sigma in 0.5..1.5_f64, n in 1.0..3.0_f64,
        a in prop_oneof![-4.0..-0.1_f64, 0.1..4.0_f64], turns in vec(-5.0..5.0_f64, 1..5),
    ) {
        let shape = UnitShape { beta: sum * sigma, gamma: sum * (1.0 - sigma), n };
        let model = BoucWen::from_unit(vec![2.0, 0.1], alpha, shape).unwrap();
        let close = |x: f64, y: f64| (x - y).abs() <= 1e-13 * (1.0 + x.abs());
        let normalised = NormalisedBoucWen::of(&model).unwrap();
        let classical = ClassicalBoucWen::of(&model, a).unwrap();
        for back in [normalised.bouc_wen().unwrap(), classical.bouc_wen().unwrap()] {
            prop_assert!(close(back.alpha, model.alpha) && close(back.beta, model.beta));
            prop_assert!(close(back.gamma, model.gamma) && back.n == n && back.polynomial == model.polynomial);
        }
        prop_assert!(close(normalised.sigma, sigma) && normalised.rho > 0.0);
        // The equations as they are printed, integrated.
        let mut v = vec![0.0; turns.len()];
        model.simulate(&turns, Start::Rest { u: 0.0 }, &mut v).unwrap();
        let (mut from, mut w, mut z) = (0.0, 0.0_f64, 0.0_f64);
        for (&to, v) in turns.iter().zip(&v) {
            let s = f64::signum(to - from);
            let NormalisedBoucWen { rho, sigma, kappa_w, .. } = normalised;
            w = integrate(from, w, to, |_, w| {
                rho * (1.0 - sigma * s * w * w.abs().powf(n - 1.0) + (sigma - 1.0) * w.abs().powf(n))
            });
            let ClassicalBoucWen { a, beta, gamma, kappa, .. } = classical;
            z = integrate(from, z, to, |_, z| {
                a - beta * s * z * z.abs().powf(n - 1.0) - gamma * z.abs().powf(n)
            });
            from = to;
            let line = model.polynomial_at(to);
            prop_assert!((line + kappa_w * w - v).abs() < 1e-5 && (line + kappa * z - v).abs() < 1e-5);
        }
    }
}

#[test]
fn bouc_wen_forms_by_hand() {
    // ρ = 2, σ = ¾, n = 1: β' = 1.5, γ' = 0.5; κ_w = −3: α = 6.
    let normalised =
        NormalisedBoucWen { polynomial: vec![1.0], kappa_w: -3.0, rho: 2.0, sigma: 0.75, n: 1.0 };
    assert_eq!(normalised.bouc_wen().unwrap(), BoucWen::new(vec![1.0], 6.0, 1.5, 0.5, 1.0).unwrap());
    let classical =
        ClassicalBoucWen { polynomial: vec![1.0], kappa: 2.0, a: 3.0, beta: 1.0, gamma: 0.5, n: 1.0 };
    assert_eq!(classical.bouc_wen().unwrap(), BoucWen::new(vec![1.0], -6.0, 1.0, -0.5, 1.0).unwrap());
    let hardening = BoucWen::new(vec![1.0], 1.0, -1.0, 0.5, 1.0).unwrap();
    assert!(matches!(NormalisedBoucWen::of(&hardening), Err(HysteresisError::ShapeParameter { .. })));
    assert!(matches!(ClassicalBoucWen::of(&hardening, 0.0), Err(HysteresisError::ShapeParameter { .. })));
}

#[test]
fn jiles_atherton_that_is_all_reversible_is_anhysteretic() {
    // c = 1: m = L(h/a), h = u + αm, on every branch.
    let u = [3.0, -1.0, 0.5, -4.0];
    let m = column(&JilesAtherton, &[1.0, 0.7, 1.0, 1.5], &u, REST);
    for (u, m) in u.iter().zip(&m) {
        let x = u + 1.5 * m;
        assert!((1.0 / x.tanh() - 1.0 / x - m).abs() < 1e-14, "{u} {m}");
    }
}

fn rate_dependent(
    model: &RateDependentPrandtlIshlinskii,
    u: &[f64],
    rate_hz: f64,
    start: PlayStart,
) -> Vec<f64> {
    let mut v = vec![0.0; u.len()];
    model.simulate_every(1, u, rate_hz, start, &mut vec![0.0; model.weights.len()], &mut v).unwrap();
    v
}

#[test]
fn a_play_that_widens_with_the_rate_by_hand() {
    // r = 1 V, λ = 0.1 s; at 10 Hz a step of 1 V is 10 V/s and the half-width 2 V. Standing still it is 1 V again.
    let model = RateDependentPrandtlIshlinskii::new(vec![1.0], vec![1.0], vec![1.0], 0.1).unwrap();
    let u = [0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.5];
    let v = rate_dependent(&model, &u, 10.0, PlayStart::Rest { u: 0.0 });
    assert_eq!(v, [0.0, 1.0, 2.0, 4.0, 6.0, 7.0, 6.5]);
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn rate_dependent_plays_of_a_constant_rate_are_wider_plays(
        plays in prandtl_ishlinskii(), gain in 0.0..0.5_f64, step in 0.01..0.2_f64,
    ) {
        // A triangle between ±10 V or so in steps of one size, at 5 Hz.
        let top = (10.0 / step).round() as i32;
        let u: Vec<f64> = (-top..top).chain((1 - top..=top).rev()).map(|k| f64::from(k) * step).collect();
        let PrandtlIshlinskii { polynomial, thresholds, weights } = plays;
        let model = RateDependentPrandtlIshlinskii::new(
            polynomial.clone(), thresholds.clone(), weights.clone(), gain,
        ).unwrap();
        let wider = thresholds.iter().map(|r| r + gain * step * 5.0).collect();
        let plain = PrandtlIshlinskii::new(polynomial, wider, weights).unwrap();
        let mut want = vec![0.0; u.len()];
        plain.simulate(&u, PlayStart::Periodic, &mut vec![0.0; plain.weights.len()], &mut want).unwrap();
        for (v, want) in rate_dependent(&model, &u, 5.0, PlayStart::Periodic).iter().zip(&want) {
            prop_assert!((v - want).abs() < 1e-10 * (1.0 + want.abs()), "{v} {want}");
        }
    }

    #[test]
    fn rate_dependent_plays_close_their_period_and_a_slower_drive_has_a_narrower_loop(
        plays in prandtl_ishlinskii(), u in vec(-6.0..6.0_f64, 2..30), gain in 0.0..0.5_f64,
    ) {
        let PrandtlIshlinskii { polynomial, thresholds, weights } = plays;
        let model = RateDependentPrandtlIshlinskii::new(polynomial, thresholds, weights, gain).unwrap();
        let twice: Vec<f64> = u.iter().chain(&u).copied().collect();
        let once = rate_dependent(&model, &u, 3.0, PlayStart::Periodic);
        let both = rate_dependent(&model, &twice, 3.0, PlayStart::Periodic);
        prop_assert_eq!(&both[..u.len()], &once[..]);
        prop_assert_eq!(&both[u.len()..], &once[..]);
        // One play, a sine: the width at 0 V grows with the rate.
        let one = RateDependentPrandtlIshlinskii::new(vec![1.0], vec![0.5], vec![1.0], 0.01).unwrap();
        let sine: Vec<f64> = (0..1000).map(|k| 5.0 * (std::f64::consts::TAU * f64::from(k) / 1000.0).sin()).collect();
        let width = |rate_hz: f64| {
            let v = rate_dependent(&one, &sine, rate_hz, PlayStart::Periodic);
            v[500] - v[0]
        };
        // 2 (r + λ 2π f A) at f = 1 and 2 Hz, the rate that of the chord.
        prop_assert!((width(1000.0) - 2.0 * (0.5 + 0.01 * 31.415_9)).abs() < 1e-4);
        prop_assert!((width(2000.0) - 2.0 * (0.5 + 0.02 * 31.415_9)).abs() < 1e-4);
    }
}
