//! Promise: whether an operator can be inverted is decided by the exact condition of its family where there
//! is one, else along drives.
// Helpers outside the test functions; a failure is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use hysteron_model::hysteresis::{
    BoucWen, Hysteresis, HysteresisError, HysteresisForm, Invertibility, PrandtlIshlinskii,
};
use hysteron_model::record::Timing;

/// A family by its name, with so many elements where their number is not fixed.
fn named(name: &str, elements: usize) -> HysteresisForm {
    let form: HysteresisForm = name.parse().unwrap();
    if elements == 0 { form } else { form.with_elements(elements).unwrap() }
}

fn drive() -> Vec<f64> {
    (0..400).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.05).cos()).collect()
}

fn bouc_wen(linear: f64, alpha: f64) -> Hysteresis {
    Hysteresis::from(BoucWen::new(vec![linear], alpha, 0.6, 0.2, 1.0).unwrap())
}

#[test]
fn bouc_wen_by_its_bound_and_by_its_drive() {
    let drive = drive();
    let of = |model: Hysteresis| model.invertibility(&[(&drive, Timing::Unknown)]).unwrap();
    // 2β/(β + γ) = 1.5: a slope of 1.5 α is the limit. Just above it every history is safe.
    assert_eq!(of(bouc_wen(1.51, 1.0)), Invertibility::Everywhere);
    // Below it a loop that saturates falls behind its turn: dz/du there is 1.5 α.
    let Invertibility::FallsAlongDrives { least_slope } = of(bouc_wen(1.3, 1.0)) else { panic!() };
    assert!((-0.25..-0.1).contains(&least_slope), "{least_slope}");
    // A drive that does not saturate does not find the fall.
    let short: Vec<f64> = drive.iter().map(|u| 0.02 * u).collect();
    let on_short = bouc_wen(1.3, 1.0).invertibility(&[(&short, Timing::Unknown)]).unwrap();
    assert!(matches!(on_short, Invertibility::AlongDrives { .. }), "{on_short}");
    // α < 0 adds to the slope.
    assert_eq!(of(bouc_wen(0.1, -1.0)), Invertibility::Everywhere);
}

#[test]
fn plays_by_the_partial_sums_of_their_weights() {
    let drive = drive();
    let of = |weights: Vec<f64>| {
        let model = PrandtlIshlinskii::new(vec![1.0], vec![0.5, 1.5], weights).unwrap();
        Hysteresis::from(model).invertibility(&[(&drive, Timing::Unknown)]).unwrap()
    };
    assert_eq!(of(vec![-0.5, -0.4]), Invertibility::Everywhere);
    assert!(matches!(of(vec![-0.5, -0.6]), Invertibility::Nowhere { .. }));
}

#[test]
fn other_families_by_sign_or_by_their_drive() {
    let drive = drive();
    let of = |form: HysteresisForm, shape: &[f64], weight: f64| {
        let weights = vec![weight; form.columns()];
        let model = form.operator(vec![1.0], &weights, shape).unwrap();
        model.invertibility(&[(&drive, Timing::Unknown)]).unwrap()
    };
    let plays = named("one-sided-plays", 3);
    assert_eq!(of(plays, &[5.3], 0.2), Invertibility::Everywhere);
    assert!(matches!(of(plays, &[5.3], -0.1), Invertibility::AlongDrives { .. }));
    assert!(matches!(of(named("dahl", 0), &[1.7, 1.4], 0.2), Invertibility::AlongDrives { .. }));
    assert!(matches!(of(named("dahl", 0), &[1.7, 1.4], -2.0), Invertibility::FallsAlongDrives { .. }));
}

#[test]
fn slip_is_decided_as_plays_are() {
    let drive = drive();
    let of = |linear: f64| {
        let form = named("maxwell-slip", 2);
        let model = form.operator(vec![linear], &[0.5, 0.4], &[3.0]).unwrap();
        model.invertibility(&[(&drive, Timing::Unknown)]).unwrap()
    };
    // Stiffnesses of both signs, whose partial sums 1.1, 1.2, 1.0 stay above 0.
    let mixed = named("maxwell-slip", 2).operator(vec![1.0], &[-0.1, 0.2], &[3.0]).unwrap();
    assert_eq!(mixed.invertibility(&[(&drive, Timing::Unknown)]).unwrap(), Invertibility::Everywhere);
    // Stiffnesses 0.5 and 0.4 that give way: l' + 0.9 at a turn, l' once all slip.
    assert_eq!(of(0.1), Invertibility::Everywhere);
    assert!(matches!(of(-0.1), Invertibility::Nowhere { .. }));
}

#[test]
fn plays_that_a_sample_widens_by_more_than_its_move_need_a_steeper_line() {
    let drive = drive();
    let of = |linear: f64, rate_gain: f64| {
        let form = named("rate-dependent-plays", 2);
        let model = form.operator(vec![linear], &[0.3, 0.2], &[3.0, rate_gain]).unwrap();
        model.invertibility(&[(&drive, Timing::Rate(1e3))]).unwrap()
    };
    assert_eq!(of(0.1, 9e-4), Invertibility::Everywhere);
    // λ/T = 1.4: 0.5 · 0.4 back.
    assert_eq!(of(0.21, 1.4e-3), Invertibility::Everywhere);
    assert_ne!(of(0.19, 1.4e-3), Invertibility::Everywhere);
}

#[test]
fn a_drive_that_does_not_move_decides_nothing() {
    let constant = [2.0; 5];
    let error = bouc_wen(1.0, 0.5).invertibility(&[(&constant, Timing::Unknown)]);
    assert!(matches!(error, Err(HysteresisError::Range { .. })));
}
