//! Self-test of the controller of $crate: the voltages of hysteron's own simulation for its references and
//! readings, and what happens with bad numbers. Written by hysteron export.
#![allow(clippy::excessive_precision, clippy::unreadable_literal)]

use hysteron_rt::{Controller, Limited};
use $crate::Real;
use $crate::controller::{self, Memory, PREVIEW};

/// Voltage to rest at first \[$INPUT_UNIT\], and what is read there \[$OUTPUT_UNIT\].
const REST: Real = $REST;
const MEASURED: Real = $MEASURED;
/// References \[$OUTPUT_UNIT\]; the voltages \[$INPUT_UNIT\] of the library, and what was read of a simulated
/// stage when they had gone out.
const REFERENCES: [Real; $SAMPLES] = [
$REFERENCES
];
const VOLTAGES: [Real; $SAMPLES] = [
$VOLTAGES
];
const READINGS: [Real; $SAMPLES] = [
$READINGS
];
/// Largest difference allowed \[$INPUT_UNIT\]: $TOLERANCE_IN_WORDS.
const TOLERANCE: Real = $TOLERANCE;
/// Constant of the displacement \[$OUTPUT_UNIT\].
const OFFSET: Real = $OFFSET;

fn ahead(k: usize) -> Real {
    REFERENCES[k.min(REFERENCES.len() - 1)]
}

/// At rest where the vectors begin, and knowing as much of them as is previewed, on a stage that moves `gain`
/// times as far.
fn begin(controller: &mut Controller<'_, Real>, gain: Real) {
    controller.rest_after(REST, REST, OFFSET + gain * (MEASURED - OFFSET)).unwrap();
    for k in 0..PREVIEW {
        assert!(controller.know(OFFSET + gain * (ahead(k) - OFFSET)));
    }
}

#[test]
fn golden_vectors() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut controller, mut twin) = (memory.controller().unwrap(), twin.controller().unwrap());
    begin(&mut controller, 1.0);
    let mut worst: Real = 0.0;
    for (k, (wanted, reading)) in VOLTAGES.into_iter().zip(READINGS).enumerate() {
        let drive = controller.step(ahead(k + PREVIEW));
        assert!(drive.voltage.is_finite() && drive.limited != Limited::Reference);
        assert!(controller.measured(reading));
        worst = worst.max((drive.voltage - wanted).abs());
        if k > VOLTAGES.len() / 2 {
            assert_eq!(twin.step(ahead(k + PREVIEW)).voltage.to_bits(), drive.voltage.to_bits());
            twin.measured(reading);
        } else if k == VOLTAGES.len() / 2 {
            // A saved state goes on with the same bits, damaged bytes are refused.
            let mut bytes = controller::save(&mut controller).unwrap();
            for k in 0..bytes.len() {
                bytes[k] ^= 1;
                assert!(controller::restore(&mut twin, &bytes).is_err());
                bytes[k] ^= 1;
            }
            controller::restore(&mut twin, &bytes).unwrap();
        }
    }
    println!("largest difference {worst:e}, allowed {TOLERANCE:e}");
    assert!(worst <= TOLERANCE, "{worst:e}");
}

#[test]
fn trims_scale_what_is_followed_and_read() {
    let (mut memory, mut twin) = (Memory::new().unwrap(), Memory::new().unwrap());
    let (mut controller, mut twin) = (memory.controller().unwrap(), twin.controller().unwrap());
    begin(&mut controller, 1.0);
    assert!(twin.trim(0.0, OFFSET).is_err());
    twin.trim(2.0, OFFSET).unwrap();
    begin(&mut twin, 2.0);
    for (k, reading) in READINGS.into_iter().enumerate() {
        let reference = ahead(k + PREVIEW);
        let own = controller.step(reference).voltage;
        let other = twin.step(OFFSET + 2.0 * (reference - OFFSET)).voltage;
        assert!((own - other).abs() <= 2.0 * TOLERANCE, "{k}: {own:e} {other:e}");
        controller.measured(reading);
        twin.measured(OFFSET + 2.0 * (reading - OFFSET));
    }
}

#[test]
fn whatever_is_handed_in_every_voltage_keeps_to_the_limits() {
    let mut memory = Memory::new().unwrap();
    let mut controller = memory.controller().unwrap();
    begin(&mut controller, 1.0);
    let limits = controller.limits();
    let bad = [Real::NAN, Real::INFINITY, Real::NEG_INFINITY, Real::MAX, Real::MIN];
    for (k, (reference, reading)) in REFERENCES.into_iter().zip(READINGS).enumerate() {
        let voltage = controller.step(if k % 7 == 0 { bad[k / 7 % 5] } else { reference }).voltage;
        assert!(voltage >= limits.low && voltage <= limits.high, "{voltage}");
        let reading = if k % 11 == 0 { bad[k / 11 % 5] } else { reading };
        controller.measured(reading);
    }
}
