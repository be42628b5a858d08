//! Promise: a plane of relays puts out what its relays do, one by one, whatever came before; with little room
//! for turns it is nearly so.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{Hysteresis, ModelError, Operator, ParameterError, Plane, Real, Turn, Turns};
use proptest::prelude::*;

const INTERVALS: usize = 5;
/// Relays along each side of a cell. At voltages that are multiples of a relay's place they all switch or
/// none does.
const FINE: i32 = 8;
const LOW: f64 = -1.5;
const CELL: f64 = 0.75;

fn weight(row: usize, column: usize) -> f64 {
    0.1 + 0.3 * libm::sin((1 + 3 * row + 7 * column) as f64).abs()
}

/// Everett sums by counting.
fn sums() -> Vec<f64> {
    let mut out = Vec::new();
    for p in 1..=INTERVALS {
        for q in 0..p {
            let cells = (q..p).flat_map(|row| (q..=row).map(move |column| weight(row, column)));
            out.push(cells.sum());
        }
    }
    out
}

/// Relay by relay; −1 and 1, or 0 where the antidiagonal of the virgin state halves its place.
struct Relays {
    states: Vec<(i32, i32, f64)>,
    u: i32,
}

impl Relays {
    fn virgin(u: i32) -> Self {
        let last = INTERVALS as i32 * FINE;
        let pairs = (0..last).flat_map(|a| (0..a).map(move |b| (a, b)));
        let off_diagonal = pairs.filter(|(a, b)| a / FINE > b / FINE);
        // The middle of place (a, b) is at α = a + ½, β = b + ½.
        let states = off_diagonal.map(|(a, b)| (a, b, f64::from((2 * u - a - b - 1).signum())));
        Self { states: states.collect(), u }
    }

    fn step(&mut self, u: i32) -> f64 {
        self.u = u;
        for (a, b, state) in &mut self.states {
            if *a < u && u > *b {
                *state = 1.0;
            }
            if *b >= u {
                *state = -1.0;
            }
        }
        self.output()
    }

    fn output(&self) -> f64 {
        let place = |k: i32| (k / FINE) as usize;
        let share = 1.0 / f64::from(FINE * FINE);
        let off_diagonal: f64 =
            self.states.iter().map(|(a, b, state)| share * weight(place(*a), place(*b)) * state).sum();
        let ramp = |k: usize| {
            let passed = f64::from(self.u - k as i32 * FINE) / f64::from(FINE);
            weight(k, k) * (2.0 * passed.clamp(0.0, 1.0) - 1.0)
        };
        off_diagonal + (0..INTERVALS).map(ramp).sum::<f64>()
    }
}

fn voltage(k: i32) -> f64 {
    LOW + CELL * f64::from(k) / f64::from(FINE)
}

fn block<'a, T: Real>(everett: &'a [T], turns: &'a mut [Turn<T>], polynomial: &'a [T]) -> Hysteresis<'a, T> {
    let range = [T::of(LOW), T::of(LOW + CELL * INTERVALS as f64)];
    let plane = Plane::new(range, INTERVALS, everett).unwrap();
    Hysteresis::new(polynomial, Operator::Plane { plane, turns: Turns::new(turns) }).unwrap()
}

proptest! {
    #[test]
    fn it_is_its_relays(
        rest in -12..52_i32,
        places in prop::collection::vec(-12..52_i32, 1..60),
    ) {
        let everett = sums();
        let mut turns = [Turn::none(); 64];
        let mut block = block(&everett, &mut turns, &[]);
        let mut relays = Relays::virgin(rest);
        let single = everett.iter().map(|e| *e as f32).collect::<Vec<_>>();
        let mut turns32 = [Turn::none(); 64];
        let mut block32 = crate::block(&single, &mut turns32, &[]);
        let total = everett.iter().fold(0.0, |most: f64, e| most.max(*e));
        prop_assert!((block.rest_at(voltage(rest)) - relays.output()).abs() < 1e-13 * total);
        block32.rest_at(voltage(rest) as f32);
        for k in places {
            let (u, wanted) = (voltage(k), relays.step(k));
            let looked = block.look(u);
            let got = block.step(u).unwrap();
            prop_assert_eq!(looked, got);
            prop_assert!((got - wanted).abs() < 1e-13 * total, "{} {}", got, wanted);
            let got32 = f64::from(block32.step(u as f32).unwrap());
            prop_assert!(
                (got32 - wanted).abs() < 64.0 * f64::from(f32::EPSILON) * total,
                "{} {}",
                got32,
                wanted
            );
        }
    }

    /// Loops that close leave nothing behind, whatever the room.
    #[test]
    fn a_wide_loop_wipes_out_what_was_forgotten(
        places in prop::collection::vec(0..40_i32, 1..200),
        room in 4..12_usize,
    ) {
        let everett = sums();
        let (mut few, mut many) = (vec![Turn::none(); room], [Turn::none(); 256]);
        let (mut small, mut exact) = (block(&everett, &mut few, &[]), block(&everett, &mut many, &[]));
        let total = everett.iter().fold(0.0, |most: f64, e| most.max(*e));
        for k in places {
            small.step(voltage(k)).unwrap();
            exact.step(voltage(k)).unwrap();
        }
        for k in [50, -10, 20, 33, 12] {
            let (a, b) = (small.step(voltage(k)).unwrap(), exact.step(voltage(k)).unwrap());
            prop_assert!((a - b).abs() < 1e-13 * total, "{} {}", a, b);
        }
    }
}

#[test]
fn a_decay_longer_than_the_room_is_followed_closely() {
    let everett = sums();
    let (mut few, mut many) = ([Turn::none(); 64], [Turn::none(); 1024]);
    let (mut small, mut exact) = (block(&everett, &mut few, &[]), block(&everett, &mut many, &[]));
    let total = everett.iter().fold(0.0, |most: f64, e| most.max(*e));
    let mut worst = 0.0_f64;
    // 300 cycles inwards, then outwards again through all that was.
    for k in (0..600).chain((0..600).rev()) {
        let size = 1.8 * (1.0 - f64::from(k) / 600.0);
        let u = 0.3 + if k % 2 == 0 { size } else { -size };
        worst = worst.max((small.step(u).unwrap() - exact.step(u).unwrap()).abs());
    }
    println!("64 turns for 600: {:.1e} of the range", worst / total);
    assert!(worst < 2e-3 * total, "{worst:e}");
    assert!(worst > 0.0);
}

#[test]
fn bad_numbers_leave_no_trace() {
    let everett = sums();
    let (mut turns, mut others) = ([Turn::none(); 8], [Turn::none(); 8]);
    let mut tried = block(&everett, &mut turns, &[0.5]);
    let mut twin = block(&everett, &mut others, &[0.5]);
    for k in [3, 30, 12, 25, 18, 22, 40, 0] {
        for (bad, error) in [
            (f64::NAN, ModelError::NotFinite),
            (f64::INFINITY, ModelError::NotFinite),
            (1e308, ModelError::Overflow),
            (-1e308, ModelError::Overflow),
        ] {
            assert_eq!(tried.step(bad), Err(error));
        }
        assert_eq!(tried.step(voltage(k)), twin.step(voltage(k)));
    }
}

#[test]
fn single_precision_does_not_drift() {
    let everett = sums();
    let single: Vec<f32> = everett.iter().map(|e| *e as f32).collect();
    let (mut turns, mut turns32) = ([Turn::none(); 64], [Turn::none(); 64]);
    let mut double = block(&everett, &mut turns, &[]);
    let mut float = block(&single, &mut turns32, &[]);
    let total = everett.iter().fold(0.0, |most: f64, e| most.max(*e));
    let mut worst = 0.0_f64;
    for k in 0..1_000_000 {
        let t = f64::from(k) * 1e-3;
        let u = (0.4 + 1.2 * libm::sin(t) + 0.5 * libm::sin(7.3 * t)) as f32;
        let difference = f64::from(float.step(u).unwrap()) - double.step(f64::from(u)).unwrap();
        worst = worst.max(difference.abs());
    }
    println!("single precision over 1e6 samples: {worst:.1e} of {total:.1}");
    assert!(worst < 64.0 * f64::from(f32::EPSILON) * total, "{worst:e}");
}

#[test]
fn planes_that_are_none_are_refused() {
    assert_eq!(Plane::new([0.0, 1.0], 2, &[1.0, 1.0]), Err(ParameterError::Sums { expected: 3, found: 2 }));
    assert_eq!(Plane::new([0.0, 1.0], 1, &[f64::NAN]), Err(ParameterError::Sum));
    for range in [[1.0, 1.0], [0.0, f64::INFINITY], [f64::NAN, 1.0]] {
        assert_eq!(Plane::new(range, 1, &[1.0]), Err(ParameterError::Range));
    }
    assert!(matches!(
        Plane::<f64>::new([0.0, 1.0], 0, &[]),
        Err(ParameterError::Range | ParameterError::Sums { .. })
    ));
    let plane = Plane::new([0.0, 1.0], 1, &[1.0]).unwrap();
    let mut turns = [Turn::none(); 3];
    let operator = Operator::Plane { plane, turns: Turns::new(&mut turns) };
    assert!(matches!(Hysteresis::new(&[1.0], operator), Err(ModelError::Memory { expected: 4, found: 3 })));
}
