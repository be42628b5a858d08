//! Self-test of $name: hysteron export's golden vectors, and what happens with bad numbers.
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use $crate::$PLACE;

/// Samples that a vector lasts.
const HOLD: usize = $HOLD;
/// What goes in, and what the library puts out at the end of each.
const GIVEN: [[$float; $N_GIVEN]; $VECTORS] = [
$GIVEN
];
const WANTED: [[$float; $N_FOUND]; $VECTORS] = [
$WANTED
];
/// Largest difference allowed: $ALLOWED.
const TOLERANCE: $float = $TOLERANCE;

#[test]
fn golden_vectors() {
    let mut one = $type::new();
    let mut worst = 0.0_$float;
    for (given, wanted) in GIVEN.into_iter().zip(WANTED) {
        for _ in 1..HOLD {
            one.step(given);
        }
        for (found, wanted) in one.step(given).into_iter().zip(wanted) {
            assert!(found.is_finite());
            worst = worst.max((found - wanted).abs());
        }
    }
    println!("largest difference {worst:e}, allowed {TOLERANCE:e}");
    assert!(worst <= TOLERANCE, "{worst:e}");
}

#[test]
fn a_saved_state_goes_on_with_the_same_bits() {
    let (mut one, mut twin) = ($type::new(), $type::new());
    let (before, after) = GIVEN.split_at(GIVEN.len() / 2);
    for &given in before {
        one.step(given);
    }
    let mut bytes = one.save();
    for k in (0..bytes.len()).step_by(7) {
        bytes[k] ^= 1;
        assert!(twin.restore(&bytes).is_err());
        bytes[k] ^= 1;
    }
    twin.restore(&bytes).unwrap();
    for &given in after {
        assert_eq!(one.step(given).map($float::to_bits), twin.step(given).map($float::to_bits));
    }
}

#[test]
fn bad_numbers_are_not_used() {
    let mut one = $type::new();
    for (k, given) in GIVEN.into_iter().enumerate() {
        let bad = [$float::NAN, $float::INFINITY, $float::NEG_INFINITY][k % 3];
        let found = one.step(if k % 7 == 3 { [bad; $N_GIVEN] } else { given });
        assert!(found.iter().all(|x| x.is_finite()));
    }
}
