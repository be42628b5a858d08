//! A device of the class is found again from noisy records, and predicts a level between those it was
//! identified at.

use std::ops::ControlFlow;

use hysteron_identify::modes::{ModesIdentification, Options, identify};
use hysteron_identify::{Event, FindingKind, IdentifyError, Watch};
use hysteron_model::axes::{AxesRecord, ScheduledModes, SteadyPeriod};

use crate::device::{HIGH, LOW, MODES, device, linear_device, record, record_of};

/// Noise of the outputs, rms \[µm\].
const NOISE: f64 = 0.02;

fn fit(records: &[AxesRecord], options: &Options) -> Result<ModesIdentification, IdentifyError> {
    identify(records, options, &Watch::silent(), None)
}

fn training_of(device: &ScheduledModes) -> Vec<AxesRecord> {
    [(LOW, 1), (LOW, 2), (HIGH, 3), (HIGH, 4)]
        .map(|(level, seed)| record_of(device, level, seed, NOISE))
        .to_vec()
}

fn training() -> Vec<AxesRecord> {
    training_of(&device())
}

/// rms error on a record that no fit has seen, without noise, and rms of its output.
fn unseen(model: &ScheduledModes, level: f64, seed: u64) -> (f64, f64) {
    let steady = SteadyPeriod::find(&record(level, seed, 0.0), false).unwrap();
    let y = model.simulate_period(&steady.u).unwrap();
    let mut e: Vec<f64> = steady.y.iter().zip(&y).map(|(a, b)| a - b).collect();
    for o in 0..2 {
        let mean = e.iter().skip(o).step_by(2).sum::<f64>() / (e.len() / 2) as f64;
        e.iter_mut().skip(o).step_by(2).for_each(|e| *e -= mean);
    }
    ((e.iter().map(|e| e * e).sum::<f64>() / e.len() as f64).sqrt(), steady.output_rms())
}

#[test]
fn modes_and_their_shift_are_found_from_noisy_records() {
    let truth = linear_device();
    let options = Options { hysteresis: false, ..Options::default() };
    let found = fit(&training_of(&truth), &options).unwrap();
    assert_eq!(found.model.modes, MODES.len(), "as many as there are");
    let expected = |level: f64| truth.modes_at(truth.level.state(level));
    for ((found, low), high) in found.modes.iter().zip(expected(LOW)).zip(expected(HIGH)) {
        for (found, truth) in [(found.low, low), (found.high, high)] {
            println!("{found:?} {truth:?}");
            // Noise of 0.02 of 2 um rms over 4096 samples and 240 lines a half bandwidth: some 1e-5.
            assert!((found.frequency_hz / truth.frequency_hz - 1.0).abs() < 1e-4, "{found:?} {truth:?}");
            assert!((found.damping / truth.damping - 1.0).abs() < 0.01, "{found:?} {truth:?}");
        }
    }
    let influence = &found.influence[1].matrix;
    let slow = truth.linear_response(5.0, 0.0);
    for (found, truth) in influence.values.iter().zip(slow) {
        assert!((found - truth.re).abs() < 0.02, "{influence:?} {truth}");
    }
}

#[test]
fn hysteresis_in_feedback_is_found_and_a_level_between_predicted() {
    // The device follows the level itself, which two levels do not show.
    let options = Options { exponent: Some(1.0), ..Options::default() };
    let found = fit(&training(), &options).unwrap();
    let linear = fit(&training(), &Options { hysteresis: false, ..options }).unwrap();
    for (level, seed) in [(LOW, 11), (0.4, 12), (HIGH, 13)] {
        let (error, size) = unseen(&found.model, level, seed);
        let (without, _) = unseen(&linear.model, level, seed);
        println!("{level} V: {error:.5}, linear modes {without:.5}, of {size:.3} um");
        // The plays that are fitted are not those of the device: something is left.
        assert!(error < 0.5 * without && error < 0.04 * size, "{level} V: {error} {without} of {size}");
    }
}

#[test]
fn one_level_leaves_the_shift_out_and_says_so() {
    let records = [record(HIGH, 3, NOISE), record(HIGH, 4, NOISE)];
    let options = Options { plays: 2, iterations: 2, modes: Some(3), ..Options::default() };
    let found = fit(&records, &options).unwrap();
    assert!(
        found.model.transition_slopes.iter().chain(&found.model.output_slopes).all(|slope| *slope == 0.0)
    );
    let said =
        |f: &&hysteron_identify::Finding| f.kind == FindingKind::Advice && f.text.contains("one level");
    assert!(found.findings.iter().any(|f| said(&f)), "{:?}", found.findings);
}

#[test]
fn a_stopped_search_hands_out_the_best_so_far() {
    let options = Options { modes: Some(3), hysteresis: false, ..Options::default() };
    let mut told: Vec<(f64, bool)> = Vec::new();
    let watch = Watch::new(|event: &Event<'_>| {
        told.push((event.fraction, event.model().is_some()));
        if told.len() == 4 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let found = identify(&training(), &options, &watch, None).unwrap();
    drop(watch);
    assert!(found.interrupted && told.len() == 4);
    assert!(told.windows(2).all(|w| w[0].0 <= w[1].0), "{told:?}");
    assert!(told[3].1 && !told[0].1, "there is a model to be seen once there is a start: {told:?}");
    // What was stopped goes on to the same bits, from its text too; on other records it does not.
    let text = serde_json::to_string(&found.resume).unwrap();
    let resume = || Some(serde_json::from_str(&text).unwrap());
    let straight = fit(&training(), &options).unwrap();
    let resumed = identify(&training(), &options, &Watch::silent(), resume()).unwrap();
    assert!(!resumed.interrupted && found.model != straight.model);
    assert_eq!(resumed.model, straight.model);
    let others = identify(&training()[..1], &options, &Watch::silent(), resume());
    assert!(matches!(others, Err(IdentifyError::Resume)), "{others:?}");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let options = Options { modes: Some(3), plays: 2, iterations: 1, ..Options::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&training(), &options).unwrap().model)
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn records_that_do_not_belong_together_or_hold_nothing_are_refused() {
    let options = Options { modes: Some(3), ..Options::default() };
    let refuse = |records: &[AxesRecord]| fit(records, &options).unwrap_err().to_string();
    let good = record(HIGH, 3, NOISE);
    let mut fewer = good.clone();
    fewer.u.pop();
    assert!(refuse(&[good.clone(), fewer]).contains("differ in their number of inputs: 2 and 1"));
    let mut faster = good.clone();
    faster.sample_rate_hz *= 2.0;
    assert!(refuse(&[good.clone(), faster]).contains("sample rates"));
    let mut cut = good.clone();
    cut.u.iter_mut().chain(&mut cut.y).for_each(|x| x.truncate(3000));
    assert!(refuse(&[cut]).contains("do not repeat"));
    let mut still = good.clone();
    still.u.iter_mut().for_each(|u| u.fill(1.0));
    assert!(refuse(&[still]).contains("constant"));
    let mut together = good.clone();
    together.u[1] = together.u[0].clone();
    assert!(refuse(&[together]).contains("not independent"));
    let mut noise = good.clone();
    let mut random = crate::device::Random(77);
    noise.y.iter_mut().flatten().for_each(|y| *y = random.normal());
    let refused = refuse(&[noise]);
    assert!(refused.contains("do not describe") || refused.contains("no lightly damped mode"), "{refused}");
    assert!(refuse(&[]).contains("no record was given"));
    let wrong = Options { steps: 0, ..options.clone() };
    assert!(fit(&[good], &wrong).unwrap_err().to_string().contains("steps is 0"));
}
