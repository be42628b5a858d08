//! Promise: on every branch the states follow their differential equation, in one move as in many, without
//! drift in single precision.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::branch::{Dahl, Duhem, JilesAtherton, NonSymmetricBoucWen, SongDerKiureghian};
use hysteron_rt::{Branch, Hysteresis, IncrementMemory, ModelError, Operator, Real};
use proptest::prelude::*;

const DAHL: [f64; 2] = [1.7, 1.4];
const RATE: f64 = 0.6;
const ZHU: [f64; 3] = [0.5, -0.2, 0.15];
const SONG: [f64; 6] = [0.5, 0.1, -0.08, 0.06, 0.05, -0.04];
const JILES: [f64; 4] = [1.5, 1.1, 0.3, 1.2];

#[derive(Clone, Copy, Debug)]
enum Kind {
    Dahl,
    Duhem,
    Zhu,
    Song,
    Jiles,
}

const KINDS: [Kind; 5] = [Kind::Dahl, Kind::Duhem, Kind::Zhu, Kind::Song, Kind::Jiles];

fn law<T: Real>(kind: Kind) -> Branch<T> {
    let of = |x: f64| T::of(x);
    match kind {
        Kind::Dahl => Dahl { reach: of(DAHL[0]), exponent: of(DAHL[1]) }.into(),
        Kind::Duhem => Duhem { rate: of(RATE) }.into(),
        Kind::Zhu => NonSymmetricBoucWen { beta: of(ZHU[0]), gamma: of(ZHU[1]), delta: of(ZHU[2]) }.into(),
        Kind::Song => song(SONG.map(of)),
        Kind::Jiles => JilesAtherton {
            anhysteretic: of(JILES[0]),
            pinning: of(JILES[1]),
            reversibility: of(JILES[2]),
            coupling: of(JILES[3]),
        }
        .into(),
    }
}

fn song<T: Real>([beta_1, beta_2, beta_3, beta_4, beta_5, beta_6]: [T; 6]) -> Branch<T> {
    SongDerKiureghian { beta_1, beta_2, beta_3, beta_4, beta_5, beta_6 }.into()
}

/// Weights in one type, and memory.
struct Parts<T> {
    weights: Vec<T>,
    memory: Vec<IncrementMemory<T>>,
}

impl<T: Real> Parts<T> {
    fn new(kind: Kind) -> Self {
        let weights: &[f64] = if matches!(kind, Kind::Duhem) { &[0.7, 0.05, -0.01] } else { &[0.7] };
        Self {
            weights: weights.iter().map(|&w| T::of(w)).collect(),
            memory: vec![IncrementMemory::new(T::of(0.0)); weights.len()],
        }
    }

    fn block(&mut self, kind: Kind) -> Hysteresis<'_, T> {
        let operator = Operator::Branch { law: law(kind), weights: &self.weights, memory: &mut self.memory };
        Hysteresis::new(&[], operator).unwrap()
    }
}

/// dy/du of the laws as they are written down; s = sign of the move, side = sign of u along it.
fn slopes(kind: Kind, y: [f64; 3], u: f64, [s, side]: [f64; 2]) -> [f64; 3] {
    let sign = |x: f64| {
        if x > 0.0 {
            1.0
        } else if x < 0.0 {
            -1.0
        } else {
            0.0
        }
    };
    let first = y[0];
    match kind {
        Kind::Dahl => [(1.0 - s * first / DAHL[0]).max(0.0).powf(DAHL[1]), 0.0, 0.0],
        Kind::Duhem => [1.0 - s * RATE * y[0], u - s * RATE * y[1], u * u - s * RATE * y[2]],
        Kind::Zhu => [1.0 - (ZHU[0] * s + ZHU[1] * sign(first)) * first + ZHU[2] * s * u, 0.0, 0.0],
        Kind::Song => {
            let [b1, b2, b3, b4, b5, b6] = SONG;
            let (of_y, of_u) = (sign(first), side);
            let sum = b1 * s * of_y + b2 * of_u * s + b3 * of_u * of_y + b4 * s + b5 * of_y + b6 * of_u;
            [1.0 - first.abs() * sum, 0.0, 0.0]
        }
        Kind::Jiles => unreachable!("its own test"),
    }
}

/// Heun's method in small steps, one of which ends at u = 0.
fn integrate(kind: Kind, mut y: [f64; 3], from: f64, to: f64) -> [f64; 3] {
    const STEPS: u32 = 20_000;
    if from * to < 0.0 {
        let there = integrate(kind, y, from, 0.0);
        return integrate(kind, there, 0.0, to);
    }
    let h = (to - from) / f64::from(STEPS);
    let signs = [h.signum(), (from + to).signum()];
    for k in 0..STEPS {
        let u = from + h * f64::from(k);
        let first = slopes(kind, y, u, signs);
        let ahead = [0, 1, 2].map(|i: usize| y[i] + h * first[i]);
        let second = slopes(kind, ahead, u + h, signs);
        for i in 0..3 {
            y[i] += 0.5 * h * (first[i] + second[i]);
        }
    }
    y
}

#[test]
fn the_states_follow_their_equations() {
    for kind in [Kind::Dahl, Kind::Duhem, Kind::Zhu, Kind::Song] {
        let mut parts = Parts::<f64>::new(kind);
        let weights = parts.weights.clone();
        let mut block = parts.block(kind);
        block.rest_at(0.5);
        let (mut y, mut u, mut worst) = ([0.0; 3], 0.5, 0.0_f64);
        for to in [2.0, -1.0, 0.3, -4.0, -3.5, -3.9, 3.0, 2.9, 4.5, -0.2] {
            y = integrate(kind, y, u, to);
            u = to;
            let wanted: f64 = weights.iter().zip(y).map(|(w, y)| w * y).sum();
            worst = worst.max((block.step(to).unwrap() - wanted).abs());
        }
        // Where y changes sign within a step of 2e-4 V, an error of its square.
        println!("{kind:?}: {worst:.1e}");
        assert!(worst < 5e-8, "{kind:?}: {worst:e}");
    }
}

/// dp/dh in small steps of the field; the voltage follows from it.
#[test]
fn magnetisation_follows_its_equations() {
    let [a, k, c, alpha] = JILES;
    let anhysteretic = |h: f64| {
        let x: f64 = h / a;
        if x.abs() < 1e-4 { x / 3.0 } else { 1.0 / x.tanh() - 1.0 / x }
    };
    let mut parts = Parts::<f64>::new(Kind::Jiles);
    let mut block = parts.block(Kind::Jiles);
    let (mut h, mut p, mut worst) = (0.0_f64, 0.0_f64, 0.0_f64);
    block.rest_at(0.0);
    for to in [3.0, 1.0, 2.0, -4.0, -1.0, -5.0, 5.0, 4.0] {
        // Along the field to a place known beforehand; the voltage there is asked of the block.
        let step = (to - h) / 40_000.0;
        let s = f64::signum(step);
        for _ in 0..40_000 {
            let drawn = |h: f64, p: f64| (s * (anhysteretic(h) - p)).max(0.0) / k;
            let first = drawn(h, p);
            p += 0.5 * step * (first + drawn(h + step, p + step * first));
            h += step;
        }
        let m = p + c * (anhysteretic(h) - p);
        worst = worst.max((block.step(h - alpha * m).unwrap() - 0.7 * m).abs());
    }
    println!("{worst:.1e}");
    assert!(worst < 1e-8, "{worst:e}");
}

proptest! {
    #[test]
    fn one_move_is_many_and_looking_moves_nothing(
        kind in prop::sample::select(KINDS.to_vec()),
        rest in -3.0..3.0_f64,
        places in prop::collection::vec(-5.0..5.0_f64, 1..20),
        cuts in prop::collection::vec(0.01..0.99_f64, 20),
    ) {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let (mut whole, mut many) = (parts.block(kind), twin.block(kind));
        prop_assert_eq!(whole.rest_at(rest), many.rest_at(rest));
        for (to, cut) in places.into_iter().zip(cuts) {
            let middle = many.voltage() + cut * (to - many.voltage());
            many.step(middle).unwrap();
            let wanted = many.step(to).unwrap();
            let looked = whole.look(to);
            let got = whole.step(to).unwrap();
            prop_assert!((looked - got).abs() < 1e-14 * 20.0);
            prop_assert!((got - wanted).abs() < 2e-12, "{:?}: {} {}", kind, got, wanted);
        }
    }
}

#[test]
fn long_moves_of_magnetisation_keep_their_stated_error() {
    let (mut parts, mut twin) = (Parts::<f64>::new(Kind::Jiles), Parts::<f64>::new(Kind::Jiles));
    let (mut whole, mut many) = (parts.block(Kind::Jiles), twin.block(Kind::Jiles));
    let mut worst = [0.0_f64; 3];
    for to in [20.0, -12.0, 25.0, 200.0, -150.0, 0.0, 1500.0, 0.0] {
        let from = whole.voltage();
        let wanted =
            (1..=4000).map(|k| many.step(from + (to - from) * f64::from(k) / 4000.0).unwrap()).last();
        let difference = (whole.step(to).unwrap() - wanted.unwrap()).abs();
        let size = f64::abs(to - from);
        let class = if size < 33.0 {
            0
        } else if size < 400.0 {
            1
        } else {
            2
        };
        worst[class] = worst[class].max(difference);
    }
    println!("moves of up to 30 k, 320 k and 1400 k: {worst:?}");
    assert!(worst[0] < 1e-12 && worst[1] < 5e-11 && worst[2] < 2e-2, "{worst:?}");
}

#[test]
fn what_is_refused_leaves_no_trace() {
    for kind in KINDS {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let memory = |parts: &mut Parts<f64>| std::mem::take(&mut parts.memory);
        let (mut own, mut other) = (memory(&mut parts), memory(&mut twin));
        let operator = Operator::Branch { law: law(kind), weights: &parts.weights, memory: &mut own };
        let mut tried = Hysteresis::new(&[0.5], operator).unwrap();
        let operator = Operator::Branch { law: law(kind), weights: &twin.weights, memory: &mut other };
        let mut twin = Hysteresis::new(&[0.5], operator).unwrap();
        for u in [0.3, 4.0, -2.0, 1.0, 0.0] {
            for (bad, error) in [
                (f64::NAN, ModelError::NotFinite),
                (f64::INFINITY, ModelError::NotFinite),
                (1e308, ModelError::Overflow),
                (-1e308, ModelError::Overflow),
            ] {
                assert_eq!(tried.step(bad), Err(error), "{kind:?}");
            }
            assert_eq!(tried.step(u), twin.step(u), "{kind:?}");
        }
    }
}

/// Single precision follows double along small steps as along large ones.
#[test]
fn single_precision_does_not_drift() {
    for kind in KINDS {
        let (mut parts, mut parts32) = (Parts::<f64>::new(kind), Parts::<f32>::new(kind));
        let (mut double, mut single) = (parts.block(kind), parts32.block(kind));
        double.rest_at(0.0);
        single.rest_at(0.0);
        let mut worst = 0.0_f64;
        // 2¹⁶ samples a ramp of 4 V: moves of 2⁻¹⁴ V, of which 2⁻¹⁶ of a state is left.
        for k in 0..(5 << 16) {
            let ramp = f64::from(k & 0xffff) / f64::from(1 << 14);
            let u = if (k >> 16) & 1 == 0 { ramp } else { 4.0 - ramp };
            let difference = f64::from(single.step(u as f32).unwrap()) - double.step(u).unwrap();
            worst = worst.max(difference.abs());
        }
        println!("{kind:?}: single precision {worst:.1e}");
        assert!(worst < 32.0 * f64::from(f32::EPSILON), "{kind:?}: {worst:e}");
    }
}

#[test]
fn laws_that_are_none_are_refused() {
    let refused = |law: Branch<f64>, weights: &[f64]| {
        let mut memory = vec![IncrementMemory::new(0.0); weights.len()];
        let operator = Operator::Branch { law, weights, memory: &mut memory };
        Hysteresis::new(&[1.0], operator).err() == Some(ModelError::Coefficient)
    };
    for kind in KINDS {
        assert!(!refused(law(kind), &[1.0]));
        assert!(refused(law(kind), &[f64::NAN]));
        assert!(matches!(kind, Kind::Duhem) || refused(law(kind), &[1.0, 1.0]));
    }
    assert!(refused(Duhem { rate: 1.0 }.into(), &[1.0; 11]));
    let jiles =
        |coupling| JilesAtherton { anhysteretic: 1.0, pinning: 1.0, reversibility: 0.2, coupling }.into();
    for law in [
        Dahl { reach: 0.0, exponent: 1.0 }.into(),
        Dahl { reach: 1.0, exponent: -0.1 }.into(),
        Duhem { rate: f64::INFINITY }.into(),
        NonSymmetricBoucWen { beta: 0.1, gamma: 0.2, delta: 0.0 }.into(),
        song([f64::NAN; 6]),
        jiles(3.0),
        jiles(-0.1),
    ] {
        assert!(refused(law, &[1.0]), "{law:?}");
    }
}
