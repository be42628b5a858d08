//! Thinned long records against all of their samples.

use super::super::super::watch::Plan;
use super::super::knowledge::knowledge;
use super::super::normalised::local_fits;
use super::super::resolution::{FINAL, resolution, resolved};
use super::super::setup::{JointSetup, form};
use super::*;
use crate::DynamicsChoice;
use crate::Watch;
use hysteron_model::dynamics::{Dynamics, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::ArticleOperator;
use hysteron_model::record::{InputOutput, TimeBase};
use hysteron_optimize::Settings;
use proptest::prelude::*;
use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 200_000.0;

/// A sweep from 2 to 20 Hz on a device of the class, with noise of 0.02 % of its stroke: simulated.
fn long() -> InputOutput {
    let omega = TAU * 90.0;
    let term = |coefficient, order| Term { coefficient, order };
    let device = Model {
        hysteresis: ArticleOperator::new(vec![3.0, -0.08], 0.9, 0.9, 0.3, 1.0).unwrap().into(),
        dynamics: Dynamics::Fractional(TransferFunction {
            numerator: vec![term(omega * omega, 0.0)],
            denominator: vec![term(omega * omega, 0.0), term(0.6 * omega, 1.0), term(1.0, 2.0)],
        }),
        offset: 0.0,
        delay_s: 3e-4,
        scheme: Scheme::BandLimited,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    };
    let phase = |t: f64| TAU * (2.0 * t + 4.5 * t * t);
    let u: Vec<f64> = (0..410_000).map(|k| 5.0 - 5.0 * phase(f64::from(k) / RATE_HZ).cos()).collect();
    let time = TimeBase::Uniform { start_s: 0.0, sample_rate_hz: RATE_HZ, jitter_samples: 0.0 };
    let mut y = device.simulate(&u, &time, &Start::Rest { voltage_v: 0.0 }).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    // Twelve equally distributed numbers have the variance 1.
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    y.iter_mut().for_each(|y| *y += 0.005 * ((0..12).map(|_| unit()).sum::<f64>() - 6.0));
    InputOutput::new("simulated", time, u, y).unwrap()
}

#[test]
fn the_fit_of_a_long_record_is_that_of_all_its_samples() {
    let facts = RecordFacts::new(long());
    let options = Options { dynamics: DynamicsChoice::Fractional, ..Options::default() };
    let watch = Watch::silent();
    let mut engine = Engine::new(None, Settings::default(), &watch, Plan(&[]), None);
    let thinned = JointMember::new(&facts, &options, &mut engine).unwrap();
    let Thin { factor, every } = thinned.thin[Rate::Own as usize];
    assert!(factor >= 4 && every >= 2, "{factor} {every}");
    let [coarse, reduced, _] = thinned.thin;
    let whole = [JointMember { thin: [coarse, reduced, Thin::NOT], ..thinned }];
    let thinned = [JointMember { ..thinned }];
    let options = Options { scheme: Choice::Given(Scheme::BandLimited), ..options };
    let [thinned, whole] =
        [&thinned, &whole].map(|members| JointSetup::new(members, form(&options), &options));
    let problem = |setup: &JointSetup<'_>| setup.problem(2, Rate::Own).unwrap();
    let start = thinned.guesses(&thinned.problem(2, Rate::Reduced).unwrap()).unwrap().remove(0);
    let (thinned, whole) = (problem(&thinned), problem(&whole));
    let mut fitted = |problem, start: Vec<f64>| {
        let near = local_fits(&mut engine, "near", problem, vec![start], resolved(1e-8), None).unwrap();
        let options = resolved(FINAL * resolution(problem, &near.outcome.best));
        local_fits(&mut engine, "end", problem, vec![near.outcome.best], options, None).unwrap().outcome.best
    };
    let at = fitted(&thinned, start);
    let of = |problem, at: &[f64]| knowledge(problem, at).unwrap().covariance;
    let [thinned, whole] = [of(&thinned, &at), of(&whole, &fitted(&whole, at.clone()))];
    for (j, name) in whole.names.iter().enumerate() {
        let (Some(own), Some(error)) = (thinned.std_error(j), whole.std_error(j)) else { panic!("{name}") };
        let moved = (thinned.values[j] - whole.values[j]) / error;
        println!("{name}: {moved:.3} standard errors, {:.3} of the standard error", own / error);
        assert!(moved.abs() < 0.3, "{name} moved by {moved} standard errors");
        assert!((own / error - 1.0).abs() < 0.1, "{name}: {own} against {error}");
    }
}

proptest! {
    #[test]
    fn what_the_drive_takes_divides_the_factor(most in 1..4000_usize, allowed in 0..4000_usize) {
        for before in [Start::PERIODIC, Start::AsIdentified] {
            let Thin { factor, every } = taking(most, before, |every| every <= allowed);
            prop_assert!(factor.is_multiple_of(every) && factor <= most && every <= allowed.max(1));
            // A periodic record must be a multiple of the factor given.
            prop_assert!(before != Start::PERIODIC || factor == most);
        }
    }
}

#[test]
fn a_drive_with_corners_is_not_straight_between_few_samples() {
    let of = |u: Vec<f64>| {
        let time = TimeBase::Uniform { start_s: 0.0, sample_rate_hz: 1e3, jitter_samples: 0.0 };
        RecordFacts::new(InputOutput::new("simulated", time, u.clone(), u).unwrap())
    };
    let triangle = of((0..=4000).map(|k: i32| f64::from((k % 1000 - 500).abs())).collect());
    assert!(is_straight(&triangle, 50, 1e-12) && is_straight(&triangle, 500, 1e-12));
    assert!(!is_straight(&triangle, 300, 1e-3));
    let step = of((0..4000).map(|k| f64::from(u8::from(k > 2000))).collect());
    assert!(!is_straight(&step, 2, 0.4));
    // Behind the last sample taken.
    let late = of((0..4000).map(|k| if k == 3999 { 2.0 } else { f64::from(k % 2) }).collect());
    assert!(!is_straight(&late, 3998, 0.4) && is_straight(&late, 1, 0.0));
}
