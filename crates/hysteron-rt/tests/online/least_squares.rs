//! Recursive least squares against the normal equations.

use super::noise::Noise;
use hysteron_rt::{ParameterError, Real, Rls, RlsSettings, SampleError, Unexcited};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;

const NOISE: f64 = 0.05;
const DEVIATIONS: [f64; 3] = [0.1, 2.0, 10.0];
const START: [f64; 3] = [1.0, 0.0, -0.5];

fn settings(forgetting: f64, unexcited: Unexcited) -> RlsSettings<f64, 3> {
    RlsSettings { start: START, deviations: DEVIATIONS, noise: NOISE, forgetting, unexcited, bounds: None }
}

/// Samples of y = 1.07 a + 0.3 b − 2 c + noise.
fn samples(count: usize, seed: u64) -> Vec<([f64; 3], f64)> {
    let mut noise = Noise(seed);
    let one = |_| {
        let phi = [noise.normal(), noise.normal() - 0.5, 0.2 * noise.normal()];
        (phi, 1.07 * phi[0] + 0.3 * phi[1] - 2.0 * phi[2] + NOISE * noise.normal())
    };
    (0..count).map(one).collect()
}

/// Information matrix and vector H, Hθ, of weighted samples with the restored terms, summed up in one go.
fn batch(
    samples: &[([f64; 3], f64)],
    forgetting: f64,
    deviations: [f64; 3],
) -> (SMatrix<f64, 3, 3>, SVector<f64, 3>) {
    let last = samples.len() as i32;
    let mut h = SMatrix::zeros();
    let mut moment = SVector::zeros();
    for i in 0..3 {
        let mut share = forgetting.powi(last);
        for k in (i as i32..last).step_by(3) {
            share += 3.0 * (1.0 - forgetting) * forgetting.powi(last - 1 - k);
        }
        h[(i, i)] += share / deviations[i].powi(2);
        moment[i] += share / deviations[i].powi(2) * START[i];
    }
    for (k, (phi, y)) in samples.iter().enumerate() {
        let weight = forgetting.powi(last - 1 - k as i32) / NOISE.powi(2);
        let phi = SVector::from(*phi);
        h += weight * phi * phi.transpose();
        moment += weight * *y * phi;
    }
    (h, moment)
}

fn run<T: Real, const N: usize>(rls: &mut Rls<T, N>, samples: &[([T; N], T)]) {
    for (phi, y) in samples {
        rls.step(phi, *y).unwrap();
    }
}

fn assert_close(found: &[f64], want: &[f64], tolerance: f64) {
    for (found, want) in found.iter().zip(want) {
        assert!((found - want).abs() <= tolerance * want.abs().max(1.0), "{found} for {want}");
    }
}

#[test]
fn without_forgetting_it_is_batch_least_squares() {
    for unexcited in [Unexcited::Hold, Unexcited::Return] {
        let samples = samples(500, 1);
        let mut rls = Rls::new(settings(1.0, unexcited)).unwrap();
        run(&mut rls, &samples);
        let (h, moment) = batch(&samples, 1.0, DEVIATIONS);
        let p = h.try_inverse().unwrap();
        assert_close(rls.parameters(), (p * moment).as_slice(), 1e-10);
        for i in 0..3 {
            assert_close(&rls.covariance(i).unwrap(), p.column(i).as_slice(), 1e-10);
        }
        assert_eq!(rls.covariance(3), None);
        // 500 samples: the truth within four standard errors.
        for (i, truth) in [1.07, 0.3, -2.0].into_iter().enumerate() {
            assert!((rls.parameters()[i] - truth).abs() < 4.0 * p[(i, i)].sqrt());
        }
    }
}

#[test]
fn with_forgetting_it_is_weighted_batch_least_squares() {
    for (forgetting, count) in [(0.99, 1000), (0.9, 200), (0.999, 997), (0.5, 30)] {
        let samples = samples(count, 2);
        let mut rls = Rls::new(settings(forgetting, Unexcited::Return)).unwrap();
        run(&mut rls, &samples);
        let (h, moment) = batch(&samples, forgetting, DEVIATIONS);
        let p = h.try_inverse().unwrap();
        assert_close(rls.parameters(), (p * moment).as_slice(), 1e-10);
        for i in 0..3 {
            assert_close(&rls.covariance(i).unwrap(), p.column(i).as_slice(), 1e-10);
        }
        // Parameters that hold: the same but for restored information of a start that is known to 1e6 only.
        let deviations = [1e6; 3];
        let mut rls = Rls::new(RlsSettings { deviations, ..settings(forgetting, Unexcited::Hold) }).unwrap();
        run(&mut rls, &samples);
        let (h, moment) = batch(&samples, forgetting, deviations);
        assert_close(rls.parameters(), h.cholesky().unwrap().solve(&moment).as_slice(), 1e-10);
    }
}

#[test]
fn what_a_sample_is_off_by_has_the_deviation_stated() {
    // Over many devices drawn from the prior: the normalised residual of the k-th sample is standard normal.
    let (mut noise, devices) = (Noise(3), 4000);
    for length in [1, 2, 5] {
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..devices {
            let truth = [0, 1, 2].map(|i| START[i] + DEVIATIONS[i] * noise.normal());
            let mut rls = Rls::new(settings(1.0, Unexcited::Hold)).unwrap();
            let mut last = 0.0;
            for _ in 0..length {
                let phi = [noise.normal(), noise.normal(), noise.normal()];
                let y = (0..3).map(|i| phi[i] * truth[i]).sum::<f64>() + NOISE * noise.normal();
                last = rls.step(&phi, y).unwrap().normalised();
            }
            sum += last;
            squares += last * last;
        }
        // Four standard errors of mean and variance.
        let n = f64::from(devices);
        assert!((sum / n).abs() < 4.0 / n.sqrt(), "{}", sum / n);
        assert!((squares / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt(), "{}", squares / n);
    }
}

/// Ten million samples of one constant regressor, then a check that the estimator still learns.
fn long_rest<T: Real>(unexcited: Unexcited) {
    let phi = [1.0, 2.5, 0.5].map(T::of);
    let of = |x: f64| T::of(x);
    let mut rls = Rls::new(RlsSettings {
        start: START.map(of),
        deviations: DEVIATIONS.map(of),
        noise: of(NOISE),
        forgetting: of(0.99),
        unexcited,
        bounds: None,
    })
    .unwrap();
    let mut noise = Noise(4);
    let table: Vec<T> = (0..1024).map(|_| of(0.82 + NOISE * noise.normal())).collect();
    for k in 0..10_000_000_usize {
        rls.step(&phi, table[k % 1024]).unwrap();
    }
    // P ≤ λ¹⁻ᴺ diag(σ²), and 1e-3 for rounding.
    for i in 0..3 {
        let variance = rls.covariance(i).unwrap()[i];
        let bound = of(1.001 / 0.99_f64.powi(2) * DEVIATIONS[i].powi(2));
        assert!(variance > of(0.0) && variance <= bound, "{variance} above {bound}");
        // Nor has the estimate wandered: the constant output asks for a combined change of −0.07.
        assert!((rls.parameters()[i] - of(START[i])).abs() < of(1.0), "{}", rls.parameters()[i]);
    }
    assert!((rls.predict(&phi) - of(0.82)).abs() < of(0.05));
    for (phi, y) in samples(1000, 5) {
        rls.step(&phi.map(of), of(y)).unwrap();
    }
    for (found, truth) in rls.parameters().iter().zip([1.07, 0.3, -2.0]) {
        assert!((*found - of(truth)).abs() < of(0.2), "{found} for {truth}");
    }
}

#[test]
fn ten_million_samples_without_excitation_wind_nothing_up_in_single_precision() {
    long_rest::<f32>(Unexcited::Hold);
}

#[test]
fn an_unexcited_parameter_holds_or_returns() {
    let changed = [([0.0, 0.0, 1.0], -2.0)].repeat(50);
    let rest = [([1.0, 0.0, 0.0], 1.0)].repeat(5000);
    for (unexcited, want) in [(Unexcited::Hold, -2.0), (Unexcited::Return, -0.5)] {
        let mut rls = Rls::new(settings(0.99, unexcited)).unwrap();
        run(&mut rls, &changed);
        assert!((rls.parameters()[2] + 2.0).abs() < 1e-3);
        run(&mut rls, &rest);
        assert!((rls.parameters()[2] - want).abs() < 1e-3, "{}", rls.parameters()[2]);
    }
}

#[test]
fn forgetting_follows_a_change_and_one_that_is_reopened_follows_at_once() {
    let old = samples(1000, 6);
    let new: Vec<_> = old.iter().map(|(phi, y)| (*phi, y + 0.1 * phi[0])).collect();
    let gain = |rls: &Rls<f64, 3>| rls.parameters()[0];
    let mut never = Rls::new(settings(1.0, Unexcited::Hold)).unwrap();
    let mut slow = Rls::new(settings(0.99, Unexcited::Hold)).unwrap();
    run(&mut never, &old);
    run(&mut slow, &old);
    let mut reopened = slow;
    reopened.reopen();
    assert_eq!(reopened.parameters(), slow.parameters());
    run(&mut never, &new);
    run(&mut slow, &new);
    run(&mut reopened, &new[..20]);
    assert!((gain(&never) - 1.12).abs() < 0.01, "{}", gain(&never));
    assert!((gain(&slow) - 1.17).abs() < 0.02, "{}", gain(&slow));
    assert!((gain(&reopened) - 1.17).abs() < 0.05, "{}", gain(&reopened));
    let fresh = Rls::new(settings(0.99, Unexcited::Hold)).unwrap();
    reopened.reset();
    assert_eq!(reopened, fresh);
}

#[test]
fn a_bound_is_met_where_the_constrained_minimum_lies() {
    // The gain wants 1.07 and may not: the others must be what least squares with the gain at its bound
    // gives.
    let samples = samples(200, 7);
    let mut free = Rls::new(settings(1.0, Unexcited::Hold)).unwrap();
    run(&mut free, &samples[..199]);
    let any = (f64::NEG_INFINITY, f64::INFINITY);
    let bounded = RlsSettings { bounds: Some([(0.9, 1.02), any, any]), ..settings(1.0, Unexcited::Hold) };
    let mut rls = Rls::new(bounded).unwrap();
    // Up to the bound both are the same; past it the least move in the metric of P reaches the constrained
    // minimum.
    let mut last = rls;
    for (phi, y) in &samples {
        last = rls;
        rls.step(phi, *y).unwrap();
        if rls.parameters()[0] == 1.02 {
            break;
        }
    }
    assert_eq!(rls.parameters()[0], 1.02);
    let taken = samples.iter().position(|(phi, y)| {
        let mut next = last;
        next.step(phi, *y).is_ok() && next == rls
    });
    let (h, moment) = batch(&samples[..=taken.unwrap()], 1.0, DEVIATIONS);
    // Rows 1 and 2 of Hθ = moment with θ₀ given.
    let rest = h.fixed_view::<2, 2>(1, 1).into_owned();
    let right = moment.fixed_rows::<2>(1) - 1.02 * h.fixed_view::<2, 1>(1, 0);
    assert_close(&rls.parameters()[1..], (rest.try_inverse().unwrap() * right).as_slice(), 1e-10);
}

#[test]
fn what_cannot_be_is_refused_with_its_numbers() {
    let good = settings(0.99, Unexcited::Hold);
    let refused = |settings| Rls::new(settings).unwrap_err();
    let parameter = |error| matches!(error, ParameterError::Parameter { index: 1, .. });
    let number = |error| matches!(error, ParameterError::Number { .. });
    assert!(parameter(refused(RlsSettings { start: [1.0, f64::NAN, 0.0], ..good })));
    for deviation in [0.0, -1.0, f64::INFINITY, f64::NAN, 1e-200, 1e200] {
        assert!(parameter(refused(RlsSettings { deviations: [1.0, deviation, 1.0], ..good })));
    }
    for noise in [0.0, -1.0, f64::NAN, 1e-200, 1e200] {
        assert!(number(refused(RlsSettings { noise, ..good })));
    }
    for forgetting in [0.0, -0.5, 1.01, f64::NAN] {
        assert!(number(refused(RlsSettings { forgetting, ..good })));
    }
    for bound in [(0.1, 1.0), (1.0, -1.0), (f64::NAN, 1.0)] {
        let any = (f64::NEG_INFINITY, f64::INFINITY);
        assert!(parameter(refused(RlsSettings { bounds: Some([any, bound, any]), ..good })));
    }
    let mut rls = Rls::new(good).unwrap();
    let before = rls;
    assert_eq!(rls.step(&[1.0, f64::NAN, 0.0], 1.0), Err(SampleError::NotFinite));
    assert_eq!(rls.step(&[1.0, 0.0, 0.0], f64::INFINITY), Err(SampleError::NotFinite));
    assert_eq!(rls.step(&[1e200, 0.0, 0.0], 1.0), Err(SampleError::Overflow));
    assert_eq!(rls, before);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

    #[test]
    fn no_direction_ever_becomes_less_certain_than_stated(
        forgetting in 0.3..1.0_f64,
        seed in any::<u64>(),
        directions in prop::collection::vec(0..4_usize, 1..200),
        probe in prop::array::uniform3(-1.0..1.0_f64),
    ) {
        let mut noise = Noise(seed);
        let mut rls = Rls::new(settings(forgetting, Unexcited::Hold)).unwrap();
        for direction in directions {
            let mut phi = [0.0; 3];
            if let Some(entry) = phi.get_mut(direction) { *entry = 3.0 * noise.normal(); }
            rls.step(&phi, noise.normal()).unwrap();
            let bound: f64 = (0..3).map(|i| (DEVIATIONS[i] * probe[i]).powi(2)).sum();
            let found = rls.deviation(&probe).powi(2);
            prop_assert!(found <= bound / forgetting.powi(2) * (1.0 + 1e-12), "{found} above {bound}");
        }
    }

    #[test]
    fn any_numbers_give_finite_parameters_within_their_bounds_or_an_error(
        samples in prop::collection::vec(
            (prop::array::uniform3(prop::num::f32::ANY), prop::num::f32::ANY),
            1..30,
        ),
        forgetting in 0.1..=1.0_f32,
    ) {
        let bounds = [(0.5, 1.5), (-1.0, 1.0), (f32::NEG_INFINITY, 0.0)];
        let settings = RlsSettings {
            start: [1.0, 0.0, -0.5], deviations: [0.1, 2.0, 10.0], noise: 0.05, forgetting,
            unexcited: Unexcited::Return, bounds: Some(bounds),
        };
        let mut rls = Rls::new(settings).unwrap();
        for (phi, y) in &samples {
            let before = rls;
            match rls.step(phi, *y) {
                Ok(residual) => prop_assert!(residual.value.is_finite() && residual.deviation > 0.0),
                Err(_) => prop_assert_eq!(rls, before),
            }
            for (value, (low, high)) in rls.parameters().iter().zip(bounds) {
                prop_assert!(*value >= low && *value <= high);
            }
        }
    }

    #[test]
    fn single_precision_agrees_to_its_rounding(seed in any::<u64>(), forgetting in 0.9..1.0_f64) {
        let forgetting = f64::from(forgetting as f32);
        let mut wide = Rls::new(settings(forgetting, Unexcited::Hold)).unwrap();
        let mut single = Rls::new(RlsSettings {
            start: START.map(|x| x as f32), deviations: DEVIATIONS.map(|x| x as f32), noise: NOISE as f32,
            forgetting: forgetting as f32, unexcited: Unexcited::Hold, bounds: None,
        }).unwrap();
        for (phi, y) in samples(300, seed) {
            wide.step(&phi, y).unwrap();
            single.step(&phi.map(|x| x as f32), y as f32).unwrap();
        }
        for (wide, single) in wide.parameters().iter().zip(single.parameters()) {
            prop_assert!((wide - f64::from(*single)).abs() < 1e-3, "{wide} {single}");
        }
    }
}
