//! Promise: a compensator inverts the model it runs on, keeps to its limits whatever it is fed, and starts
//! without a jump.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{
    BoucWen, Compensated, Compensator, Hysteresis, IncrementMemory, LANES, Law, Limited, Limits, Linear,
    Model, ModelError, Observer, Operator, PlayBank, Real, RealPoles, Sections, SectionsMemory,
};
use proptest::prelude::*;

/// Pole 0.8 behind one tap: y ← y + 0.2 (w − y), one sample late.
const G: f64 = 0.2;
const THRESHOLDS: [f64; 3] = [0.5, 1.5, 3.0];
const WEIGHTS: [f64; 3] = [0.3, 0.2, 0.1];
const OFFSET: f64 = 0.7;
const LIMITS: Limits<f64> = Limits { low: -2.0, high: 10.0, step: 0.5 };

/// Coefficients and memory in one number type.
struct Parts<T> {
    polynomial: [T; 3],
    bouc_wen: Vec<BoucWen<T>>,
    bouc_wen_memory: Vec<IncrementMemory<T>>,
    thresholds: [T; 3],
    weights: [T; 3],
    plays: [T; 3],
    taps: [T; 1],
    real: [RealPoles<T>; 1],
    memory: [Compensated<T, LANES>; 1],
    on_state: [[T; LANES]; 1],
    on_reference: [T; 1],
    ring: [T; 1],
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    None,
    BoucWen(f64),
    Plays,
}

const KINDS: [Kind; 5] =
    [Kind::None, Kind::BoucWen(1.0), Kind::BoucWen(2.0), Kind::BoucWen(1.4), Kind::Plays];

impl<T: Real> Parts<T> {
    fn new(kind: Kind) -> Self {
        let of = |x: f64| T::of(x);
        let lane = |x: f64| [of(x), of(0.0), of(0.0), of(0.0)];
        let bouc_wen = match kind {
            Kind::BoucWen(n) => vec![BoucWen::new(of(0.4), of(0.3), of(-0.1), of(n)).unwrap()],
            _ => Vec::new(),
        };
        Self {
            polynomial: [of(1.2), of(0.02), of(-0.001)],
            bouc_wen_memory: vec![IncrementMemory::new(of(0.0)); bouc_wen.len()],
            bouc_wen,
            thresholds: THRESHOLDS.map(of),
            weights: WEIGHTS.map(of),
            plays: [of(0.0); 3],
            taps: [of(0.0)],
            real: [RealPoles { gain: lane(G), weight: lane(1.0) }],
            memory: [Compensated::zero()],
            // w = (r − (1 − g)(x + g (v₁ − x)))/g, r one sample ahead: the exact inverse of the lag.
            on_state: [lane(-(1.0 - G) * (1.0 - G) / G)],
            on_reference: [of(1.0 / G)],
            ring: [of(0.0)],
        }
    }

    fn blocks(&mut self, kind: Kind) -> (Hysteresis<'_, T>, Linear<'_, T>, Law<'_, T>, &mut [T]) {
        let operator = match kind {
            Kind::None => Operator::None,
            Kind::BoucWen(_) => Operator::States { laws: &self.bouc_wen, memory: &mut self.bouc_wen_memory },
            Kind::Plays => Operator::Plays {
                bank: PlayBank::new(&self.thresholds, &self.weights).unwrap(),
                states: &mut self.plays,
            },
        };
        let sections = Sections { taps: &self.taps, real: &self.real, pairs: &[], rest_gain: T::of(1.0) };
        let memory = SectionsMemory { real: &mut self.memory, pairs: &mut [], delay: &mut [] };
        (
            Hysteresis::new(&self.polynomial, operator).unwrap(),
            Linear::new(sections, memory).unwrap(),
            Law { recent: &[], real: &self.on_state, pairs: &[], reference: &self.on_reference },
            &mut self.ring,
        )
    }

    fn compensator(&mut self, kind: Kind, limits: Limits<f64>) -> Compensator<'_, T> {
        let (hysteresis, dynamics, law, ring) = self.blocks(kind);
        let Limits { low, high, step } = limits;
        let limits = Limits { low: T::of(low), high: T::of(high), step: T::of(step) };
        Compensator::new(hysteresis, dynamics, law, ring, limits, T::of(OFFSET)).unwrap()
    }

    fn model(&mut self, kind: Kind) -> Model<'_, T> {
        let (hysteresis, dynamics, ..) = self.blocks(kind);
        Model::new(hysteresis, dynamics, T::of(OFFSET)).unwrap()
    }
}

/// Smooth, and slow enough for the limits.
fn motion(k: usize) -> f64 {
    let t = k as f64 * 0.01;
    5.0 + 2.5 * (0.9 * t).sin() + 1.5 * (2.3 * t).sin()
}

#[test]
fn the_model_follows_one_sample_later() {
    for kind in KINDS {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let mut compensator = parts.compensator(kind, LIMITS);
        let mut model = twin.model(kind);
        let rest = compensator.rest_after(0.0, 3.0).unwrap();
        assert_eq!(rest, model.rest_after(0.0, 3.0).unwrap());
        for k in 0..3000 {
            let wanted = if k < 200 { rest + (motion(k) - rest) * k as f64 / 200.0 } else { motion(k) };
            let drive = compensator.step(wanted);
            assert_eq!(drive.limited, Limited::No, "{kind:?} {k}");
            model.step(drive.voltage).unwrap();
        }
        // y one sample after the last voltage.
        let last = model.step(compensator.voltage()).unwrap();
        assert!((last - motion(2999)).abs() < 1e-12, "{kind:?}: {last} {}", motion(2999));
    }
}

#[test]
fn it_starts_and_starts_again_without_a_jump() {
    for kind in KINDS {
        let mut parts = Parts::<f64>::new(kind);
        let mut compensator = parts.compensator(kind, LIMITS);
        // Switched off in mid-stroke; the stage stands where the sensor says.
        for (voltage, displacement) in [(0.0, 12.0), (4.0, 3.3), (9.0, -1.0)] {
            compensator.rest_at(voltage).unwrap();
            compensator.measured_at_rest(displacement).unwrap();
            assert_eq!(compensator.displacement(), displacement);
            for _ in 0..50 {
                let drive = compensator.step(displacement);
                assert_eq!(drive.limited, Limited::No);
                assert!((drive.voltage - voltage).abs() < 1e-12, "{kind:?}: {}", drive.voltage);
            }
        }
        assert_eq!(compensator.rest_at(f64::NAN), Err(ModelError::NotFinite));
        assert!(compensator.measured_at_rest(f64::INFINITY).is_err());
        // Outside of the range it rests at its end.
        compensator.rest_at(1e3).unwrap();
        assert_eq!(compensator.voltage(), LIMITS.high);
    }
}

#[test]
fn a_start_does_not_depend_on_the_starts_before() {
    let mut parts = Parts::<f64>::new(Kind::Plays);
    let mut compensator = parts.compensator(Kind::Plays, LIMITS);
    for wild in [1e30, 1.7e308, -1.7e308] {
        compensator.rest_at(4.0).unwrap();
        let _ = compensator.measured_at_rest(wild);
        compensator.rest_at(4.0).unwrap();
        compensator.measured_at_rest(17.25).unwrap();
        let drive = compensator.step(17.25);
        assert!((drive.voltage - 4.0).abs() < 1e-12 && drive.limited == Limited::No, "{wild}: {drive:?}");
    }
}

#[test]
fn a_start_that_is_refused_does_not_move_the_drive() {
    // dz/du = 1 + |z|: out of the range of numbers within a thousand volts.
    let operators = [BoucWen::new(1.0, -1.0, 0.0, 1.0).unwrap()];
    let mut memory = [IncrementMemory::new(0.0)];
    let mut parts = Parts::<f64>::new(Kind::None);
    let (_, dynamics, law, ring) = parts.blocks(Kind::None);
    let operator = Operator::States { laws: &operators, memory: &mut memory };
    let limits = Limits { low: 0.0, high: 10.0, step: 0.5 };
    let hysteresis = Hysteresis::new(&[2.0], operator).unwrap();
    let mut compensator = Compensator::new(hysteresis, dynamics, law, ring, limits, 0.0).unwrap();
    compensator.rest_at(3.0).unwrap();
    assert_eq!(compensator.rest_after(1000.0, 3.0), Err(ModelError::Overflow));
    assert_eq!((compensator.voltage(), compensator.displacement()), (3.0, 6.0));
    let drive = compensator.step(6.0);
    assert!((drive.voltage - 3.0).abs() < 1e-12 && drive.limited == Limited::No, "{drive:?}");
    assert_eq!(compensator.rest_after(f64::NAN, 3.0), Err(ModelError::NotFinite));
}

#[test]
fn a_start_that_is_no_number_changes_nothing() {
    for kind in KINDS {
        let (mut parts, mut other) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let (mut compensator, mut twin) = (parts.compensator(kind, LIMITS), other.compensator(kind, LIMITS));
        for k in 0..200 {
            let wanted = motion(k);
            assert_eq!(compensator.step(wanted), twin.step(wanted), "{kind:?} {k}");
            assert_eq!(compensator.rest_after(3.0, f64::NAN), Err(ModelError::NotFinite));
            assert_eq!(compensator.rest_after(f64::INFINITY, 3.0), Err(ModelError::NotFinite));
        }
    }
}

#[test]
fn a_saved_compensator_goes_on_with_the_same_bits() {
    for kind in KINDS {
        let (mut parts, mut other) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let (mut compensator, mut twin) = (parts.compensator(kind, LIMITS), other.compensator(kind, LIMITS));
        compensator.rest_at(4.0).unwrap();
        compensator.measured_at_rest(motion(0)).unwrap();
        for k in 0..57 {
            compensator.step(motion(k));
        }
        let mut bytes = vec![0; compensator.saved_bytes()];
        compensator.save(7, &mut bytes).unwrap();
        twin.restore(7, &bytes).unwrap();
        assert_eq!(twin.displacement().to_bits(), compensator.displacement().to_bits());
        for k in 57..200 {
            let [own, restored] = [compensator.step(motion(k)), twin.step(motion(k))];
            assert_eq!(own, restored, "{kind:?} {k}");
        }
    }
}

#[test]
fn a_slew_below_the_resolution_of_the_voltage_is_refused() {
    let mut parts = Parts::<f32>::new(Kind::None);
    let (hysteresis, dynamics, law, ring) = parts.blocks(Kind::None);
    let limits = Limits { low: 0.0, high: 100.0, step: 3e-6 };
    let made = Compensator::new(hysteresis, dynamics, law, ring, limits, 0.0);
    assert_eq!(made.err(), Some(ModelError::Limits));
}

#[test]
fn the_gain_of_the_observer_does_not_cancel() {
    for (ratio, expected) in [
        (0.0, 0.0),
        (1e-3, 9.995_001_249_687_5e-4),
        (1.0, 0.618_033_988_749_895),
        (1e4, 0.99999999),
        (1e9, 1.0),
        (1e78, 1.0),
    ] {
        let gain = Observer::<f64>::gain_for(ratio);
        assert!((gain - expected).abs() < 1e-9 && gain <= 1.0, "{ratio}: {gain}");
        let single = Observer::<f32>::gain_for(ratio as f32);
        assert!((f64::from(single) - expected).abs() < 1e-6 && single <= 1.0, "{ratio}: {single}");
    }
}

#[test]
fn nothing_winds_up_at_a_limit() {
    for kind in KINDS {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let mut compensator = parts.compensator(kind, LIMITS);
        let mut model = twin.model(kind);
        compensator.rest_at(3.0).unwrap();
        model.rest_at(3.0).unwrap();
        let held = |k: usize| (500..1500).contains(&k);
        let mut touched = 0;
        for k in 0..2000 {
            let wanted = if held(k) { 50.0 } else { motion(k) };
            let drive = compensator.step(wanted);
            touched += usize::from(drive.limited == Limited::Range);
            let before = model.step(drive.voltage).unwrap();
            // Twenty samples of slew after the limit it follows again.
            if k > 1560 {
                assert!((before - motion(k - 1)).abs() < 1e-9, "{kind:?} {k}: {before} {}", motion(k - 1));
            }
        }
        assert!(touched > 900, "{touched}");
    }
}

#[test]
fn a_disturbance_is_taken_off_at_once() {
    let kind = Kind::BoucWen(1.0);
    let mut parts = Parts::<f64>::new(kind);
    let mut compensator = parts.compensator(kind, Limits { step: 10.0, ..LIMITS });
    let rest = compensator.rest_at(3.0).unwrap();
    compensator.step_against(rest, 0.25);
    compensator.step_against(rest, 0.25);
    // The model's displacement one sample later: what the stage shows is 0.25 above.
    assert!((compensator.displacement() - (rest - 0.25)).abs() < 1e-12);
    let steady = compensator.step_against(rest, f64::NAN);
    assert!(steady.voltage.is_finite());
}

/// Largest difference of the drive in single precision, in volts.
fn single_precision_error(kind: Kind, samples: usize) -> f64 {
    let (mut double, mut single) = (Parts::<f64>::new(kind), Parts::<f32>::new(kind));
    let (mut double, mut single) = (double.compensator(kind, LIMITS), single.compensator(kind, LIMITS));
    double.rest_at(3.0).unwrap();
    single.rest_at(3.0).unwrap();
    let mut worst = 0.0_f64;
    for k in 0..samples {
        let r = motion(k) as f32;
        let (a, b) = (double.step(f64::from(r)), single.step(r));
        worst = worst.max((a.voltage - f64::from(b.voltage)).abs());
    }
    worst
}

#[test]
fn single_precision_does_not_drift() {
    for kind in KINDS {
        // The law multiplies by 2/g at most, plays and polynomial hold 10 V and 15 µm: a few units of
        // rounding of those, over the least slope.
        let bound = 16.0 * f64::from(f32::EPSILON) * 15.0 * 2.0 / G / 0.8;
        let (short, long) = (single_precision_error(kind, 20_000), single_precision_error(kind, 400_000));
        println!("{kind:?}: {short:.2e} V over 2e4 samples, {long:.2e} V over 4e5, bound {bound:.2e} V");
        assert!(long < bound, "{kind:?}: {long:e} {bound:e}");
    }
}

#[test]
fn an_observer_finds_what_the_model_does_not_know() {
    let kind = Kind::Plays;
    let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
    let mut stage = twin.model(kind);
    let gain = Observer::gain_for(0.05);
    // g = (√(q² + 4q) − q)/2 is the root of g² = q (1 − g).
    assert!((gain * gain - 0.0025 * (1.0 - gain)).abs() < 1e-15);
    let mut observer = Observer::new(parts.model(kind), gain).unwrap();
    let at_rest = stage.rest_after(0.0, 3.0).unwrap();
    observer.rest_after(0.0, 3.0, at_rest + 0.5).unwrap();
    let mut observed = observer.step(3.0, at_rest + 0.5).unwrap();
    assert!((observed.disturbance - 0.5).abs() < 1e-12);
    for k in 0..400 {
        let u = 3.0 + (k as f64 * 0.1).sin();
        let own = stage.step(u).unwrap();
        let measured = if k % 50 == 7 { f64::NAN } else { own + 0.8 };
        observed = observer.step(u, measured).unwrap();
        assert!(observed.displacement.is_finite());
    }
    assert!((observed.disturbance - 0.8).abs() < 1e-6, "{observed:?}");
    assert!(observer.step(f64::NAN, 1.0).is_err());
    for gain in [0.0, 1.5, f64::NAN] {
        let mut parts = Parts::<f64>::new(kind);
        assert!(Observer::new(parts.model(kind), gain).is_err());
    }
}

fn kind() -> impl Strategy<Value = Kind> {
    prop_oneof![
        Just(Kind::None),
        (1.0..3.0_f64).prop_map(Kind::BoucWen),
        Just(Kind::BoucWen(1.0)),
        Just(Kind::BoucWen(2.0)),
        Just(Kind::Plays)
    ]
}

proptest! {
    #[test]
    fn a_move_to_any_output_is_found(
        kind in kind(),
        history in prop::collection::vec(-2.0..10.0_f64, 1..12),
        to in -2.0..10.0_f64,
        guess in prop_oneof![0.01..100.0_f64, Just(f64::NAN), Just(0.0)],
    ) {
        let mut parts = Parts::<f64>::new(kind);
        let (mut block, ..) = parts.blocks(kind);
        let mut output = block.rest_at(0.0);
        // The parts of an output are as large as the largest one on the way: their sums are rounded by a
        // share of that.
        let mut largest = 1.0_f64;
        for u in history {
            output = block.step(u).unwrap();
            largest = largest.max(output.abs());
        }
        let target = block.look(to);
        largest = largest.max(target.abs());
        let reached = block.reach(output, target, [-2.0, 10.0], guess);
        prop_assert!(!reached.missed);
        prop_assert!((reached.output - target).abs() <= 4e-15 * (1.0 + largest), "{reached:?} {target}");
        prop_assert!((block.look(reached.voltage) - target).abs() <= 4e-15 * (1.0 + largest), "{reached:?}");
        // Bouc–Wen in saturation can fall behind a turn, and two voltages have the same output.
        let falls = matches!(kind, Kind::BoucWen(_)) && block.look(to + 1e-6) < target;
        prop_assert!(falls || (reached.voltage - to).abs() <= 1e-13, "{reached:?} {to}");
        let beyond = block.reach(output, 1e3, [-2.0, 10.0], guess);
        prop_assert!(beyond.missed && beyond.voltage == 10.0);
    }

    #[test]
    fn whatever_it_is_fed_the_drive_keeps_to_its_limits(
        kind in kind(),
        fed in prop::collection::vec(
            prop_oneof![
                -1e3..1e3_f64,
                0.0..12.0_f64,
                Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY), Just(f64::MAX), Just(1e-310)
            ],
            1..200
        ),
        step in 1e-3..20.0_f64,
    ) {
        let mut parts = Parts::<f64>::new(kind);
        let mut compensator = parts.compensator(kind, Limits { step, ..LIMITS });
        compensator.rest_at(4.0).unwrap();
        let mut last = compensator.voltage();
        for (k, r) in fed.iter().enumerate() {
            let disturbance = fed[fed.len() - 1 - k];
            let drive =
                if k % 2 == 0 { compensator.step(*r) } else { compensator.step_against(*r, disturbance) };
            prop_assert!((LIMITS.low..=LIMITS.high).contains(&drive.voltage));
            prop_assert!((drive.voltage - last).abs() <= step * (1.0 + 1e-12));
            if !r.is_finite() {
                prop_assert_eq!(drive.limited, Limited::Reference);
            }
            prop_assert!(compensator.displacement().is_finite());
            last = drive.voltage;
        }
        // And it has survived.
        for _ in 0..30_000 {
            compensator.step(5.0);
        }
        prop_assert!((compensator.displacement() - 5.0).abs() < 1e-9, "{}", compensator.displacement());
    }
}

#[test]
fn parts_that_do_not_fit_are_refused() {
    let kind = Kind::None;
    let mut parts = Parts::<f64>::new(kind);
    let limits = |low, high, step| Limits { low, high, step };
    for limits in [
        limits(1.0, 1.0, 1.0),
        limits(0.0, f64::INFINITY, 1.0),
        limits(0.0, f64::NAN, 1.0),
        limits(0.0, 1.0, 0.0),
        limits(0.0, 1.0, f64::NAN),
    ] {
        let (hysteresis, dynamics, law, ring) = parts.blocks(kind);
        let refused = Compensator::new(hysteresis, dynamics, law, ring, limits, 0.0);
        assert!(matches!(refused, Err(ModelError::Limits)), "{limits:?}");
    }
    let (hysteresis, dynamics, law, _) = parts.blocks(kind);
    let refused = Compensator::new(hysteresis, dynamics, law, &mut [], LIMITS, 0.0);
    assert!(matches!(refused, Err(ModelError::Memory { .. })));
    let (hysteresis, dynamics, law, ring) = parts.blocks(kind);
    let refused = Compensator::new(hysteresis, dynamics, law, ring, LIMITS, f64::NAN);
    assert!(matches!(refused, Err(ModelError::Coefficient)));
}
