//! Self-test of the inverse of $crate: hysteron export's golden vectors, and what happens with bad numbers.
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use $crate::Real;
use $crate::inverse::{self, Memory};

/// Voltage to rest at first \[$INPUT_UNIT\].
const REST: Real = $REST;
/// The first references last a sample each, those from here on so many: what they do has come out of the
/// preview and of slow states then.
const HELD_FROM: usize = $HELD_FROM;
const HOLD: usize = $HOLD;
/// References \[$OUTPUT_UNIT\], and the voltages \[$INPUT_UNIT\] at their ends that the library puts out in
/// double precision.
const REFERENCES: [Real; $SAMPLES] = [
$REFERENCES
];
const VOLTAGES: [Real; $SAMPLES] = [
$VOLTAGES
];
/// Largest difference allowed \[$INPUT_UNIT\]: $TOLERANCE_IN_WORDS.
const TOLERANCE: Real = $TOLERANCE;

#[test]
fn golden_vectors() {
    let mut memory = Memory::new().unwrap();
    let mut compensator = memory.compensator().unwrap();
    compensator.rest_at(REST).unwrap();
    let mut worst: Real = 0.0;
    for (k, (reference, wanted)) in REFERENCES.into_iter().zip(VOLTAGES).enumerate() {
        for _ in 1..if k < HELD_FROM { 1 } else { HOLD } {
            compensator.step(reference);
        }
        let voltage = compensator.step(reference).voltage;
        assert!(voltage.is_finite());
        worst = worst.max((voltage - wanted).abs());
    }
    println!("largest difference {worst:e}, allowed {TOLERANCE:e}");
    assert!(worst <= TOLERANCE, "{worst:e}");
}

#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut compensator, mut twin) = (memory.compensator().unwrap(), twin.compensator().unwrap());
    let (before, after) = REFERENCES.split_at(REFERENCES.len() / 2);
    for &reference in before {
        compensator.step(reference);
    }
    let mut bytes = inverse::save(&mut compensator).unwrap();
    for k in 0..bytes.len() {
        bytes[k] ^= 1;
        assert!(inverse::restore(&mut twin, &bytes).is_err());
        bytes[k] ^= 1;
    }
    inverse::restore(&mut twin, &bytes).unwrap();
    for &reference in after {
        let [own, other] = [&mut compensator, &mut twin].map(|one| one.step(reference).voltage.to_bits());
        assert_eq!(own, other);
    }
}

#[test]
fn whatever_is_handed_in_every_voltage_keeps_to_the_limits() {
    let mut memory = Memory::new().unwrap();
    let mut compensator = memory.compensator().unwrap();
    compensator.rest_at(REST).unwrap();
    let limits = compensator.limits();
    let bad = [Real::NAN, Real::INFINITY, Real::NEG_INFINITY, Real::MAX, Real::MIN];
    for (reference, bad) in REFERENCES.into_iter().zip(bad.into_iter().cycle()) {
        for reference in [reference, bad] {
            let voltage = compensator.step(reference).voltage;
            assert!(voltage >= limits.low && voltage <= limits.high, "{voltage}");
        }
    }
}
