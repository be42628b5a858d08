//! Promise: plays between other sides stand where their sides push them, see the rate where they are told to,
//! and leave no trace of what is refused.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{BrokenLine, Hysteresis, ModelError, Operator, ParameterError, Real, SidedPlays, Sides};
use proptest::prelude::*;

const THRESHOLDS: [f64; 3] = [0.4, 1.1, 2.3];
const WEIGHTS: [f64; 3] = [0.5, -0.2, 0.3];
/// Of three lines: six pairs.
const PAIRS: [f64; 6] = [0.3, -0.1, 0.2, 0.25, 0.4, -0.15];
const SHARES: [f64; 3] = [0.4, 0.2, 0.1];
const CORNERS: [f64; 2] = [-1.0, 1.5];
const SLOPES: [f64; 3] = [0.7, 0.2, 0.9];

#[derive(Clone, Copy, Debug)]
enum Kind {
    Widening(f64),
    Below,
    Envelopes,
    Ramps,
    Line,
}

const KINDS: [Kind; 6] =
    [Kind::Widening(0.0), Kind::Widening(0.7), Kind::Below, Kind::Envelopes, Kind::Ramps, Kind::Line];

/// Numbers in one type, and the block on them.
struct Parts<T> {
    thresholds: Vec<T>,
    weights: Vec<T>,
    shares: Vec<T>,
    corners: Vec<T>,
    slopes: Vec<T>,
    states: Vec<T>,
}

fn all<T: Real>(numbers: &[f64]) -> Vec<T> {
    numbers.iter().map(|&x| T::of(x)).collect()
}

impl<T: Real> Parts<T> {
    fn new(kind: Kind) -> Self {
        let weights = if matches!(kind, Kind::Ramps) { all(&PAIRS) } else { all(&WEIGHTS) };
        Self {
            thresholds: all(&THRESHOLDS),
            states: vec![T::of(0.0); weights.len()],
            weights,
            shares: all(&SHARES),
            corners: all(&CORNERS),
            slopes: all(&SLOPES),
        }
    }

    fn block(&mut self, kind: Kind) -> Hysteresis<'_, T> {
        let of = |x: f64| T::of(x);
        let sides = match kind {
            Kind::Widening(widening) => Sides::Even { widening: of(widening) },
            Kind::Line => Sides::Even { widening: of(0.0) },
            Kind::Below => Sides::Below,
            Kind::Envelopes => Sides::Envelopes { right: [of(0.3), of(0.5)], left: [of(0.35), of(-0.4)] },
            Kind::Ramps => Sides::Ramps { steepness: of(1.6) },
        };
        let mut plays = SidedPlays::new(sides, &self.thresholds, &self.weights).unwrap();
        if matches!(kind, Kind::Line) {
            let line = BrokenLine::new(&self.shares, &self.corners, &self.slopes).unwrap();
            plays = plays.with_line(line).unwrap();
        }
        Hysteresis::new(&[], Operator::SidedPlays { plays, states: &mut self.states }).unwrap()
    }
}

/// The plays one by one from their definitions.
struct Oracle {
    kind: Kind,
    states: Vec<f64>,
    last: Option<f64>,
}

impl Oracle {
    fn virgin(kind: Kind, u: f64) -> Self {
        let states = match kind {
            Kind::Envelopes => vec![0.5 * (gamma(0.3, 0.5, u) + gamma(0.35, -0.4, u)); 3],
            Kind::Ramps => pairs().map(|(i, j)| rho(u - 0.5 * (THRESHOLDS[i] + THRESHOLDS[j]))).collect(),
            _ => vec![u; 3],
        };
        Self { kind, states, last: None }
    }

    fn step(&mut self, u: f64) -> f64 {
        let moved = self.last.map_or(0.0, |last| (u - last).abs());
        self.last = Some(u);
        let sides: Vec<(f64, f64)> = match self.kind {
            Kind::Widening(w) => THRESHOLDS.iter().map(|r| (u - r - w * moved, u + r + w * moved)).collect(),
            Kind::Line => THRESHOLDS.iter().map(|r| (u - r, u + r)).collect(),
            Kind::Below => THRESHOLDS.iter().map(|r| (u - r, u)).collect(),
            Kind::Envelopes => {
                THRESHOLDS.iter().map(|r| (gamma(0.3, 0.5, u) - r, gamma(0.35, -0.4, u) + r)).collect()
            }
            Kind::Ramps => pairs().map(|(i, j)| (rho(u - THRESHOLDS[i]), rho(u - THRESHOLDS[j]))).collect(),
        };
        for (state, (low, high)) in self.states.iter_mut().zip(sides) {
            *state = state.min(high).max(low);
        }
        let weights: &[f64] = if matches!(self.kind, Kind::Ramps) { &PAIRS } else { &WEIGHTS };
        let sum: f64 = weights.iter().zip(&self.states).map(|(w, f)| w * f).sum();
        if !matches!(self.kind, Kind::Line) {
            return sum;
        }
        let shares: f64 = SHARES.iter().sum();
        let h = (1.0 - shares) * u + SHARES.iter().zip(&self.states).map(|(g, f)| g * f).sum::<f64>();
        let [low, high] = CORNERS;
        sum + SLOPES[0] * (h - low).min(0.0)
            + SLOPES[1] * (h - low).clamp(0.0, high - low)
            + SLOPES[2] * (h - high).max(0.0)
    }
}

fn gamma(rise: f64, centre: f64, u: f64) -> f64 {
    libm::tanh(rise * (u - centre))
}

fn rho(x: f64) -> f64 {
    (1.6 * x).clamp(-1.0, 1.0)
}

fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..3).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

proptest! {
    #[test]
    fn they_are_what_their_definitions_say(
        kind in prop::sample::select(KINDS.to_vec()),
        rest in -4.0..4.0_f64,
        history in prop::collection::vec(-5.0..5.0_f64, 1..40),
    ) {
        let (mut parts, mut parts32) = (Parts::<f64>::new(kind), Parts::<f32>::new(kind));
        let (mut block, mut single) = (parts.block(kind), parts32.block(kind));
        let mut oracle = Oracle::virgin(kind, rest);
        let at_rest = block.rest_at(rest);
        single.rest_at(rest as f32);
        prop_assert!((at_rest - Oracle::virgin(kind, rest).step(rest)).abs() < 1e-14 * 8.0);
        for u in history {
            let wanted = oracle.step(u);
            let looked = block.look(u);
            let got = block.step(u).unwrap();
            prop_assert_eq!(looked, got);
            prop_assert!((got - wanted).abs() < 1e-14 * 8.0, "{:?}: {} {}", kind, got, wanted);
            let got32 = f64::from(single.step(u as f32).unwrap());
            prop_assert!(
                (got32 - wanted).abs() < 32.0 * f64::from(f32::EPSILON) * 5.0,
                "{:?}: {} {}",
                kind,
                got32,
                wanted
            );
        }
    }

    /// Half-way is where two half moves meet that share the sample.
    #[test]
    fn half_way_is_where_half_a_move_ends(
        kind in prop::sample::select(KINDS.to_vec()),
        history in prop::collection::vec(-5.0..5.0_f64, 1..20),
    ) {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let mut block = parts.block(kind);
        // The same rate over half of the move: twice the widening.
        let doubled = if let Kind::Widening(w) = kind { Kind::Widening(2.0 * w) } else { kind };
        let mut halves = twin.block(doubled);
        // A first move is without rate, whole or half.
        block.step(0.0).unwrap();
        halves.step(0.0).unwrap();
        for u in history {
            let (middle, end) = block.step_with_middle(u).unwrap();
            let half = halves.step(0.5 * halves.voltage() + 0.5 * u).unwrap();
            prop_assert!((middle - half).abs() < 1e-14 * 8.0, "{:?}: {} {}", kind, middle, half);
            prop_assert!((end - halves.step(u).unwrap()).abs() < 1e-14 * 8.0);
        }
    }

    /// A move is found back, for plays that a fast sample has left behind too.
    #[test]
    fn a_move_to_any_output_is_found(
        widening in 0.0..0.95_f64,
        history in prop::collection::vec(-5.0..5.0_f64, 1..12),
        to in -5.0..5.0_f64,
    ) {
        let (thresholds, weights, mut states) = (THRESHOLDS, [0.5, 0.2, 0.3], [0.0; 3]);
        let plays = SidedPlays::new(Sides::Even { widening }, &thresholds, &weights).unwrap();
        let mut block = Hysteresis::new(&[0.3], Operator::SidedPlays { plays, states: &mut states }).unwrap();
        let mut output = block.rest_at(0.0);
        for u in history {
            output = block.step(u).unwrap();
        }
        let target = block.look(to);
        let reached = block.reach(output, target, [-5.0, 5.0], 0.5);
        prop_assert!(!reached.missed);
        prop_assert!(
            (reached.output - target).abs() <= 1e-14 * (1.0 + target.abs()),
            "{:?} {}",
            reached,
            target
        );
        prop_assert!((reached.voltage - to).abs() <= 1e-13, "{:?} {}", reached, to);
    }
}

#[test]
fn what_is_refused_leaves_no_trace() {
    for kind in KINDS {
        let (mut parts, mut twin) = (Parts::<f64>::new(kind), Parts::<f64>::new(kind));
        let (mut block, mut twin) = (parts.block(kind), twin.block(kind));
        for u in [0.3, 4.0, -2.0, 1.0] {
            for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                assert_eq!(block.step(bad), Err(ModelError::NotFinite), "{kind:?}");
            }
            if !matches!(kind, Kind::Envelopes | Kind::Ramps) {
                assert_eq!(block.step(1e308), Err(ModelError::Overflow), "{kind:?}");
                assert_eq!(block.step(-1e308), Err(ModelError::Overflow), "{kind:?}");
            }
            assert_eq!(block.step(u), twin.step(u), "{kind:?}");
        }
    }
}

#[test]
fn envelopes_that_cross_leave_no_place() {
    // γ_r − γ_l is largest at 0, 2 tanh 1 = 1.52: more than twice the narrowest.
    let (thresholds, weights, mut states) = ([0.5, 1.0], [1.0, 1.0], [0.0; 2]);
    let sides = Sides::Envelopes { right: [1.0, -1.0], left: [1.0, 1.0] };
    let plays = SidedPlays::new(sides, &thresholds, &weights).unwrap();
    let mut block = Hysteresis::new(&[], Operator::SidedPlays { plays, states: &mut states }).unwrap();
    block.rest_at(5.0);
    let before = block.step(4.0).unwrap();
    assert_eq!(block.step(0.0), Err(ModelError::Overflow));
    assert_eq!((block.look(4.0), block.voltage()), (before, 4.0));
}

/// The end of the voltages allowed has no place to stand, the target has.
#[test]
fn a_target_before_the_place_where_envelopes_cross_is_reached() {
    let (thresholds, weights) = ([0.05, 0.2], [20.0, 10.0]);
    let plays =
        SidedPlays::new(Sides::Envelopes { right: [1.0, 0.0], left: [0.4, 0.0] }, &thresholds, &weights)
            .unwrap();
    let mut states = [0.0; 2];
    let operator = Operator::SidedPlays { plays, states: &mut states };
    let mut block = Hysteresis::new(&[1.0], operator).unwrap();
    // Nor is there one to rest.
    assert_eq!(block.rest_after(1.0, 1.0), Err(ModelError::Overflow));
    block.rest_after(-0.3, -0.3).unwrap();
    let output = block.step(-0.75).unwrap();
    let target = block.look(-0.5);
    assert!(target > output && !block.look(0.5).is_finite());
    for slope in [1.0, 20.0, 1e-3] {
        let reached = block.reach(output, target, [-2.0, 0.5], slope);
        assert!(!reached.missed && (reached.output - target).abs() < 1e-12, "{slope}: {reached:?}");
        // Beyond the last place it ends there.
        let last = block.reach(output, 1e3, [-2.0, 0.5], slope);
        assert!(
            last.missed && last.output.is_finite() && last.voltage > -0.5 && last.voltage < 0.5,
            "{last:?}"
        );
    }
}

#[test]
fn single_precision_does_not_drift() {
    for kind in KINDS {
        let (mut parts, mut parts32) = (Parts::<f64>::new(kind), Parts::<f32>::new(kind));
        let (mut block, mut single) = (parts.block(kind), parts32.block(kind));
        let mut worst = 0.0_f64;
        for k in 0..400_000 {
            let t = f64::from(k) * 1e-3;
            let u = (3.0 * libm::sin(t) + 1.5 * libm::sin(7.3 * t)) as f32;
            let difference = f64::from(single.step(u).unwrap()) - block.step(f64::from(u)).unwrap();
            worst = worst.max(difference.abs());
        }
        println!("{kind:?}: {worst:.1e} over 4e5 samples");
        assert!(worst < 32.0 * f64::from(f32::EPSILON) * 5.0, "{kind:?}: {worst:e}");
    }
}

#[test]
fn numbers_that_do_not_fit_are_refused() {
    let even = Sides::Even { widening: 0.0 };
    let refused =
        |sides, thresholds: &[f64], weights: &[f64]| SidedPlays::new(sides, thresholds, weights).err();
    let lengths = |thresholds, weights| Some(ParameterError::Lengths { thresholds, weights });
    assert_eq!(refused(even, &[1.0], &[1.0, 2.0]), lengths(1, 2));
    assert_eq!(refused(Sides::Ramps { steepness: 1.0 }, &[0.0, 1.0], &[1.0]), lengths(3, 1));
    assert!(matches!(refused(even, &[0.0], &[1.0]), Some(ParameterError::Threshold { index: 0, .. })));
    assert!(refused(Sides::Ramps { steepness: 1.0 }, &[-1.0], &[1.0]).is_none());
    let envelopes = |rise, centre| Sides::Envelopes { right: [rise, centre], left: [1.0, 0.0] };
    assert!(refused(envelopes(1.0, 0.0), &[0.0], &[1.0]).is_none());
    for sides in [
        Sides::Even { widening: -1.0 },
        Sides::Even { widening: f64::NAN },
        Sides::Ramps { steepness: 0.0 },
        envelopes(0.0, 0.0),
        envelopes(1.0, f64::INFINITY),
    ] {
        assert_eq!(refused(sides, &[1.0], &[1.0]), Some(ParameterError::Sides), "{sides:?}");
    }
    assert!(matches!(refused(even, &[1.0], &[f64::NAN]), Some(ParameterError::Weight { index: 0, .. })));
    assert!(BrokenLine::new(&[0.1], &[1.0], &[1.0]).is_err());
    assert!(BrokenLine::new(&[0.1], &[1.0, 1.0], &[1.0; 3]).is_err());
    let line = BrokenLine::new(&[0.1], &[1.0], &[1.0, 2.0]).unwrap();
    assert!(SidedPlays::new(even, &[1.0, 2.0], &[1.0, 1.0]).unwrap().with_line(line).is_err());
}
