//! Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers.
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use $name::{Memory, Real};

/// The first voltages last a sample each, those from here on so many: what they do has come out of the delay
/// and of slow states then.
const HELD_FROM: usize = $HELD_FROM;
const HOLD: usize = $HOLD;
/// Voltages \[$INPUT_UNIT\], and the displacements \[$OUTPUT_UNIT\] at their ends that the library puts out
/// in double precision.
const VOLTAGES: [Real; $SAMPLES] = [
$VOLTAGES
];
const DISPLACEMENTS: [Real; $SAMPLES] = [
$DISPLACEMENTS
];
/// Largest difference allowed \[$OUTPUT_UNIT\]: $TOLERANCE_IN_WORDS.
const TOLERANCE: Real = $TOLERANCE;

#[test]
fn golden_vectors() {
    let mut memory = Memory::new().unwrap();
    let mut model = memory.model().unwrap();
    model.rest_at(VOLTAGES[0]).unwrap();
    let mut worst: Real = 0.0;
    for (k, (u, wanted)) in VOLTAGES.into_iter().zip(DISPLACEMENTS).enumerate() {
        for _ in 1..if k < HELD_FROM { 1 } else { HOLD } {
            model.step(u).unwrap();
        }
        let y = model.step(u).unwrap();
        assert!(y.is_finite());
        worst = worst.max((y - wanted).abs());
    }
    println!("largest difference {worst:e}, allowed {TOLERANCE:e}");
    assert!(worst <= TOLERANCE, "{worst:e}");
}

#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut model, mut twin) = (memory.model().unwrap(), twin.model().unwrap());
    let (before, after) = VOLTAGES.split_at(VOLTAGES.len() / 2);
    for &u in before {
        model.step(u).unwrap();
    }
    let mut bytes = $name::save(&mut model).unwrap();
    for k in 0..bytes.len() {
        bytes[k] ^= 1;
        assert!($name::restore(&mut twin, &bytes).is_err());
        bytes[k] ^= 1;
    }
    assert!($name::restore(&mut twin, &bytes[1..]).is_err());
    $name::restore(&mut twin, &bytes).unwrap();
    for &u in after {
        assert_eq!(model.step(u).unwrap().to_bits(), twin.step(u).unwrap().to_bits());
    }
}

#[test]
fn bad_numbers_are_refused_and_leave_no_trace() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut model, mut twin) = (memory.model().unwrap(), twin.model().unwrap());
    for u in VOLTAGES {
        assert_eq!(model.step(u), twin.step(u));
        for bad in [Real::NAN, Real::INFINITY, Real::NEG_INFINITY] {
            assert!(
                model.step(bad).is_err() && model.rest_at(bad).is_err() && model.start_at(u, bad).is_err()
            );
        }
    }
}
