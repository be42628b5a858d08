//! Promise: a realisation does, sample by sample, what the batch simulation of its model does, to the
//! accuracy named.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_model::Start;
use hysteron_model::dynamics::{
    Arx, Creep, DynamicForm, Dynamics, InterSample, Modes, Scheme, Term, TransferFunction,
};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, HysteresisForm, examples};
use hysteron_model::realise::{
    Realisation, RealiseError, RealiseOptions, RuntimeParts, StreamParts, realise, sweep, verify,
};
use proptest::prelude::*;

const RATE_HZ: f64 = 1e4;

fn bouc_wen(n: f64) -> Hysteresis {
    Hysteresis::from(BoucWen::new(vec![2.0, 0.01], 0.5, 0.1, 0.02, n).unwrap())
}

/// v = u.
fn nothing() -> Hysteresis {
    Hysteresis::from(BoucWen::new(vec![1.0], 0.0, 0.0, 0.0, 1.0).unwrap())
}

fn model(dynamics: Dynamics, scheme: Scheme, delay_s: f64) -> Model {
    Model {
        hysteresis: bouc_wen(1.0),
        dynamics,
        offset: 1.5,
        delay_s,
        scheme,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(RATE_HZ),
    }
}

fn eq13() -> Dynamics {
    Dynamics::Fractional(TransferFunction::article_eq13())
}

fn to(accuracy: f64) -> RealiseOptions {
    RealiseOptions { accuracy, ..RealiseOptions::default() }
}

/// A 1–100 Hz sweep of full and of half amplitude.
fn drive() -> Vec<f64> {
    sweep((0.0, 10.0), (1.0, 100.0), RATE_HZ, 20_000)
}

fn largest_difference(realisation: &Realisation) -> f64 {
    verify(realisation, &drive()).unwrap().largest
}

#[test]
fn a_realisation_is_the_batch_simulation_to_the_named_accuracy() {
    for scheme in Scheme::ALL {
        for accuracy in [1e-4, 1e-5, 1e-6] {
            for delay_s in [0.0, 2e-4, 3.37e-4] {
                let realised = realise(&model(eq13(), scheme, delay_s), RATE_HZ, &to(accuracy)).unwrap();
                let (error, dynamics) = (largest_difference(&realised), &realised.dynamics);
                println!(
                    "{scheme} {accuracy:e}, delay {delay_s}: {} states, {} taps; response {:.1e}, sweep \
                     {error:.1e}",
                    dynamics.states(),
                    dynamics.taps.len(),
                    dynamics.frequency_error
                );
                assert!(
                    dynamics.frequency_error <= accuracy && error <= accuracy,
                    "{scheme} {accuracy:e} {error:e}"
                );
                assert!(dynamics.sections.iter().all(|s| s.is_stable()));
                assert!(dynamics.states() <= 26, "{} states", dynamics.states());
            }
        }
    }
}

#[test]
fn the_step_response_of_eq_13_has_its_sixteen_digit_values() {
    // A step is a held input: continuous poles answer it exactly, so what is seen is the accuracy of the
    // poles.
    let reference = [
        (10, 0.642_547_372_734_257_5),
        (50, 0.966_959_160_158_473_5),
        (100, 0.960_918_872_967_022_4),
        (500, 0.957_597_025_196_018_6),
        (1000, 0.957_256_393_028_622_2),
    ];
    let held = Model {
        hysteresis: nothing(),
        offset: 0.0,
        inter_sample: InterSample::Hold,
        ..model(eq13(), Scheme::BandLimited, 0.0)
    };
    for accuracy in [1e-4, 1e-5, 1e-6] {
        let realised = realise(&held, RATE_HZ, &to(accuracy)).unwrap();
        let mut parts = StreamParts::new(&realised).unwrap();
        let mut stream = parts.stream().unwrap();
        let response: Vec<f64> = (0..=1000).map(|_| stream.step(1.0).unwrap()).collect();
        for (k, expected) in reference {
            assert!((response[k] - expected).abs() < accuracy, "{accuracy:e}, sample {k}: {}", response[k]);
        }
    }
}

#[test]
fn whole_orders_multiple_poles_arx_and_delay_alone_are_realised() {
    let tf = |numerator: &[f64], denominator: &[f64]| {
        let terms = |c: &[f64]| c.iter().enumerate().map(|(k, &c)| Term::new(c, k as f64)).collect();
        TransferFunction::new(terms(numerator), terms(denominator)).unwrap()
    };
    let pair = DynamicForm { modes: Modes::Integer { order: 4 }, creep: Creep::None };
    let creeping = |creep, own: &[f64]| {
        let form = DynamicForm { modes: Modes::Integer { order: 2 }, creep };
        Dynamics::Integer(form.transfer_function(&[&[300.0, 0.3], own].concat()).unwrap())
    };
    let cases = [
        creeping(Creep::KelvinVoigt { elements: 2 }, &[0.03, 0.02, 0.02, 3.0]),
        creeping(Creep::Logarithmic, &[0.02, 0.1]),
        // (1 + s/500)² : the search counts the pole once.
        Dynamics::Integer(tf(&[1.0], &[1.0, 2.0 / 500.0, 1.0 / 250_000.0])),
        Dynamics::Integer(tf(&[1.0, 0.01], &[1.0, 0.02])),
        Dynamics::Integer(pair.transfer_function(&[150.0, 0.02, 700.0, 0.3]).unwrap()),
        Dynamics::Integer(tf(&[3.0], &[2.0])),
        Dynamics::None,
        Dynamics::Arx(Arx { a: vec![-1.6, 0.68], b: vec![0.0, 0.0, 0.05, 0.03] }),
        // A double pole at 0.9, more of b than of a.
        Dynamics::Arx(Arx { a: vec![-1.8, 0.81], b: vec![0.01, 0.002, -0.001, 0.003] }),
        Dynamics::Arx(Arx { a: vec![], b: vec![0.5, 0.3, 0.2] }),
    ];
    for (case, dynamics) in cases.into_iter().enumerate() {
        // A direct path shows what a polygon holds above half the sample rate, which the batch simulation
        // leaves out.
        let direct = matches!(&dynamics, Dynamics::Integer(g) if g.high_frequency_gain() != 0.0);
        let schemes = if direct { &[Scheme::Tustin][..] } else { &[Scheme::Tustin, Scheme::BandLimited] };
        for &scheme in schemes {
            for delay_s in [0.0, 4.5e-4] {
                let realised = realise(&model(dynamics.clone(), scheme, delay_s), RATE_HZ, &to(1e-5));
                let realised = realised.unwrap_or_else(|e| panic!("case {case}, {scheme}, {delay_s}: {e}"));
                let error = largest_difference(&realised);
                assert!(error < 1e-5, "case {case}, {scheme}, delay {delay_s}: {error:e}");
            }
        }
    }
}

#[test]
fn creep_is_realised_down_to_the_frequency_named() {
    let form = |creep| DynamicForm { modes: Modes::Fractional, creep };
    let creeps = form(Creep::Fractional).transfer_function(&[300.0, 0.6, 2.03, 1.05, 0.012, 0.15]).unwrap();
    // A lag, whose pole lies on the branch cut of the creep.
    let lag = DynamicForm { modes: Modes::Integer { order: 1 }, creep: Creep::Fractional };
    let lag = lag.transfer_function(&[1e-3, 0.01, 0.2]).unwrap();
    // A finite gain at rest that is not reached in the age of the device.
    let slow = form(Creep::None).transfer_function(&[421.0, 0.125, 1.286, 0.063]).unwrap();
    for (g, scheme) in [
        (&creeps, Scheme::Tustin),
        (&creeps, Scheme::BandLimited),
        (&lag, Scheme::Tustin),
        (&slow, Scheme::BandLimited),
    ] {
        let creeping = model(Dynamics::Fractional(g.clone()), scheme, 1.3e-4);
        assert!(matches!(realise(&creeping, RATE_HZ, &to(1e-5)), Err(RealiseError::LowestFrequency)));
        let options = RealiseOptions { lowest_frequency_hz: Some(0.02), ..to(1e-5) };
        let realised = realise(&creeping, RATE_HZ, &options).unwrap();
        let error = largest_difference(&realised);
        println!("{g}, {scheme}: {} states, sweep {error:.1e}", realised.dynamics.states());
        // Two seconds of a band that begins at fifty.
        assert!(error < 2e-5, "{scheme}: {error:e}");
        assert_eq!(realised.dynamics.band_hz.0, 0.02);
    }
}

/// The relaxations of creep beside fractional modes are poles on the branch cut, most of them far below the
/// band.
#[test]
fn logarithmic_creep_beside_fractional_modes_is_realised() {
    for (creep_start_s, scheme) in
        [(0.01, Scheme::Tustin), (20.0, Scheme::BandLimited), (0.3, Scheme::BandLimited)]
    {
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::Logarithmic };
        let g = form.transfer_function(&[320.0, 0.62, 1.94, 1.05, 0.02, creep_start_s]).unwrap();
        let creeping = model(Dynamics::Fractional(g.clone()), scheme, 1.3e-4);
        let options = RealiseOptions { lowest_frequency_hz: Some(0.02), ..to(1e-5) };
        let realised = realise(&creeping, RATE_HZ, &options).unwrap();
        let error = largest_difference(&realised);
        println!(
            "start {creep_start_s} s, {scheme}: {} states, sweep {error:.1e}",
            realised.dynamics.states()
        );
        assert!(error < 2e-5, "{creep_start_s} s, {scheme}: {error:e}");
        // Against the transfer function itself, below all that the sweep held.
        for f in [0.02, 0.1, 0.5] {
            let s = hysteron_numeric::Complex64::new(0.0, std::f64::consts::TAU * f);
            let error = realised.dynamics.response(f, RATE_HZ) - g.response_at(s) * (-s * 1.3e-4).exp();
            assert!(error.norm() < 1.1e-5 * realised.dynamics.reference_gain, "{f} Hz: {error}");
        }
    }
}

#[test]
fn every_family_streams_as_it_is_simulated() {
    let power = [bouc_wen(1.0), bouc_wen(2.0)];
    let families = examples([-1.03, 11.21], 5e4, 1.0).unwrap().into_iter().chain(power);
    for hysteresis in families {
        // Static, the stream is the operator.
        let plain = Model { hysteresis, ..model(Dynamics::None, Scheme::Tustin, 0.0) };
        let realised = realise(&plain, RATE_HZ, &to(1e-5)).unwrap();
        let error = largest_difference(&realised);
        assert!(error < 1e-12, "{:?}: {error:e}", plain.hysteresis);
        // And in front of dynamics that see the means of its moves.
        let realised =
            realise(&Model { dynamics: eq13(), scheme: Scheme::BandLimited, ..plain }, RATE_HZ, &to(1e-5))
                .unwrap();
        let slow = sweep((0.0, 10.0), (1.0, 30.0), RATE_HZ, 20_000);
        let error = verify(&realised, &slow).unwrap().largest;
        assert!(error < 1.1e-5, "{:?}: {error:e}", realised.model.hysteresis);
    }
}

#[test]
fn other_exponents_stream_within_their_stated_error() {
    for n in [1.3, 1.7, 2.6] {
        let plain = Model { hysteresis: bouc_wen(n), ..model(Dynamics::None, Scheme::Tustin, 0.0) };
        let error = largest_difference(&realise(&plain, RATE_HZ, &to(1e-5)).unwrap());
        println!("n {n}: {error:.1e} of the range");
        assert!(error < 1e-5, "n {n}: {error:e}");
    }
}

#[test]
fn single_precision_is_within_thirty_two_roundings_of_double() {
    let realised = realise(&model(eq13(), Scheme::Tustin, 3.37e-4), RATE_HZ, &to(1e-6)).unwrap();
    let mut double = RuntimeParts::<f64>::new(&realised).unwrap();
    let mut single = RuntimeParts::<f32>::new(&realised).unwrap();
    let (mut double, mut single) = (double.model().unwrap(), single.model().unwrap());
    double.rest_at(0.0).unwrap();
    single.rest_at(0.0).unwrap();
    let (mut worst, mut low, mut high) = (0.0_f64, f64::MAX, f64::MIN);
    for _ in 0..10 {
        for u in drive() {
            // What both can hold.
            let u = u as f32;
            let (y, y32) = (double.step(f64::from(u)).unwrap(), single.step(u).unwrap());
            worst = worst.max((y - f64::from(y32)).abs());
            (low, high) = (low.min(y), high.max(y));
        }
    }
    let share = worst / (high - low);
    println!("single precision: {share:.1e} of the range");
    assert!(share < 32.0 * f64::from(f32::EPSILON), "{share:e}");
}

#[test]
fn what_cannot_be_realised_is_refused() {
    let stage = model(eq13(), Scheme::Tustin, 0.0);
    for rate in [0.0, -1.0, f64::NAN] {
        assert!(matches!(realise(&stage, rate, &to(1e-5)), Err(RealiseError::Option { .. })));
    }
    for accuracy in [0.0, 1.0, f64::NAN] {
        assert!(matches!(realise(&stage, RATE_HZ, &to(accuracy)), Err(RealiseError::Option { .. })));
    }
    let too_close = RealiseOptions { lowest_frequency_hz: Some(1.0), ..to(1e-14) };
    assert!(matches!(realise(&stage, RATE_HZ, &too_close), Err(RealiseError::Accuracy { .. })));
    let grunwald = model(eq13(), Scheme::GrunwaldLetnikov, 0.0);
    assert!(matches!(realise(&grunwald, 5e3, &to(1e-5)), Err(RealiseError::SampleRate { .. })));
    let arx = |a: f64| model(Dynamics::Arx(Arx { a: vec![a], b: vec![1.0] }), Scheme::Tustin, 0.0);
    assert!(matches!(realise(&arx(-0.5), 5e3, &to(1e-5)), Err(RealiseError::SampleRate { .. })));
    assert!(matches!(realise(&arx(-1.5), RATE_HZ, &to(1e-5)), Err(RealiseError::Unstable { .. })));
    let growing =
        TransferFunction::new(vec![Term::new(1.0, 0.0)], vec![Term::new(-1.0, 0.0), Term::new(1.0, 1.0)]);
    let growing = model(Dynamics::Integer(growing.unwrap()), Scheme::Tustin, 0.0);
    assert!(matches!(realise(&growing, RATE_HZ, &to(1e-5)), Err(RealiseError::Unstable { poles: 1 })));
    let late = model(Dynamics::None, Scheme::Tustin, 1e4);
    assert!(matches!(realise(&late, RATE_HZ, &to(1e-5)), Err(RealiseError::Delay { .. })));
    let options = RealiseOptions { lowest_frequency_hz: Some(-1.0), ..to(1e-5) };
    assert!(matches!(realise(&stage, RATE_HZ, &options), Err(RealiseError::Option { .. })));
    let dahl = "dahl".parse::<HysteresisForm>().unwrap().operator(vec![1.0], &[0.5], &[1.7, 1.4]).unwrap();
    let dahl = Model { hysteresis: dahl, ..stage };
    let realised = realise(&dahl, RATE_HZ, &to(1e-4)).unwrap();
    let mut parts = StreamParts::new(&realised).unwrap();
    let mut stream = parts.stream().unwrap();
    assert!(stream.step(f64::NAN).is_err() && stream.rest_at(f64::INFINITY).is_err());
}

#[test]
fn a_stream_begins_where_the_batch_simulation_does() {
    let stage = model(eq13(), Scheme::Tustin, 1.5e-4);
    let realised = realise(&stage, RATE_HZ, &to(1e-6)).unwrap();
    let mut parts = StreamParts::new(&realised).unwrap();
    let mut stream = parts.stream().unwrap();
    // From rest at 3 V the first move is one of 2 V within a sample.
    let at_rest = stream.rest_at(3.0).unwrap();
    let u: Vec<f64> = (0..2000).map(|k| 5.0 + (f64::from(k) * 0.01).sin()).collect();
    let batch = stage.simulate(&u, Some(RATE_HZ), &Start::Rest { voltage_v: 3.0 }).unwrap();
    assert!((at_rest - batch[0]).abs() < 1e-9, "two samples pass before the move is seen");
    for (u, expected) in u.iter().zip(&batch) {
        let y = stream.step(*u).unwrap();
        assert!((y - expected).abs() < 1e-5, "{y} {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever the fractional mode, the response is met at frequencies that the fit has not seen.
    #[test]
    fn the_response_holds_between_the_points_of_the_fit(
        f0 in 20.0..2000.0_f64,
        damping in 0.02..2.0_f64,
        alpha2 in 1.5..2.2_f64,
        share in 0.45..0.7_f64,
        scheme in prop::sample::select(Scheme::ALL.to_vec()),
        places in prop::collection::vec(0.0..1.0_f64, 40),
    ) {
        let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
        let g = form.transfer_function(&[f0, damping, alpha2, share * alpha2]).unwrap();
        let stage = model(Dynamics::Fractional(g.clone()), scheme, 0.0);
        let realised = match realise(&stage, RATE_HZ, &to(1e-5)) {
            Err(RealiseError::Unstable { .. }) => return Ok(()),
            realised => realised.unwrap(),
        };
        prop_assert!(realised.dynamics.sections.iter().all(|s| s.is_stable()));
        prop_assume!(scheme != Scheme::BandLimited);
        for place in places {
            let f = 1e-4 * (0.499 * RATE_HZ / 1e-4).powf(place);
            let theta = std::f64::consts::TAU * f / RATE_HZ;
            let (log, angle) = scheme.log_delta(0.0, theta);
            let s = hysteron_numeric::Complex64::from_polar(log.exp() * RATE_HZ, angle);
            let error = (realised.dynamics.response(f, RATE_HZ) - g.response_at(s)).norm();
            prop_assert!(error < 1.2e-5, "{scheme} {g} at {f} Hz: {error:e}");
        }
    }
}
