//! Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers.
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use $name::{Memory, Real};

/// Voltages \[$INPUT_UNIT\], and the displacements \[$OUTPUT_UNIT\] that the library puts out for them in double precision.
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
    for (u, wanted) in VOLTAGES.into_iter().zip(DISPLACEMENTS) {
        let y = model.step(u).unwrap();
        assert!(y.is_finite());
        worst = worst.max((y - wanted).abs());
    }
    println!("largest difference {worst:e}, allowed {TOLERANCE:e}");
    assert!(worst <= TOLERANCE, "{worst:e}");
}

#[test]
fn bad_numbers_are_refused_and_leave_no_trace() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut model, mut twin) = (memory.model().unwrap(), twin.model().unwrap());
    for u in VOLTAGES {
        assert_eq!(model.step(u), twin.step(u));
        for bad in [Real::NAN, Real::INFINITY, Real::NEG_INFINITY] {
            assert!(model.step(bad).is_err() && model.rest_at(bad).is_err() && model.start_at(u, bad).is_err());
        }
    }
}
