use super::*;
use crate::record::Unit;
use proptest::prelude::*;

fn record(u: &[f64], y: &[f64], rate: Option<f64>) -> InputOutput {
    InputOutput {
        name: "made".into(),
        time: rate.map_or(TimeBase::Unknown, |sample_rate_hz| TimeBase::Uniform {
            start_s: 3.0,
            sample_rate_hz,
            jitter_samples: 0.0,
        }),
        u: u.to_vec(),
        y: y.to_vec(),
        rate: None,
        valid: None,
        input: "u".into(),
        output: "y".into(),
        u_unit: Unit::new("V"),
        y_unit: Unit::new("um"),
        source: None,
    }
}

const FIXED: Scoring = Scoring { skip_s: Some(0.0), offset: OffsetTreatment::Fixed };

#[test]
fn the_rmse_alone_is_that_of_the_scores() {
    let y: Vec<f64> = (0..300).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let simulated: Vec<f64> = y.iter().enumerate().map(|(k, y)| 0.97 * y + 1e-4 * k as f64 + 2.0).collect();
    let record = InputOutput::new("r", TimeBase::uniform(100.0), y.clone(), y).unwrap();
    for offset in [OffsetTreatment::Estimated, OffsetTreatment::Fixed] {
        let scoring = Scoring { skip_s: Some(0.25), offset };
        let scores = score(&record, &simulated, &scoring).unwrap();
        let own = SimulationRmse { rmse: scores.rmse, offset: scores.offset, samples: scores.samples };
        assert_eq!(rmse(&record, &simulated, &scoring).unwrap(), own);
    }
    let huge = vec![1e200; 300];
    assert!(matches!(
        rmse(&record, &huge, &Scoring { skip_s: None, offset: OffsetTreatment::Fixed }),
        Err(ScoreError::Overflow { metric: "rmse", .. })
    ));
}

#[test]
fn scores_of_four_samples_agree_with_the_sums_done_by_hand() {
    // y − ŷ = (0, 1, 0, −1); stroke 4; mean y = 2; ‖y − ȳ‖² = 4 + 0 + 4 + 0 = 8; Σ(y − min) = 0 + 2 + 4 + 2 =
    // 8.
    let s = score(&record(&[0.0, 1.0, 2.0, 1.0], &[0.0, 2.0, 4.0, 2.0], None), &[0.0, 1.0, 4.0, 3.0], &FIXED)
        .unwrap();
    assert_eq!((s.samples, s.skipped_samples, s.offset, s.offset_estimated), (4, 0, 0.0, false));
    assert_eq!(s.stroke, 4.0);
    assert_eq!(s.rmse, 0.5_f64.sqrt());
    assert_eq!(s.max_abs_error, 1.0);
    assert_eq!(s.rmse_percent_of_stroke, Some(100.0 * 0.5_f64.sqrt() / 4.0));
    assert_eq!(s.max_percent_of_stroke, Some(25.0));
    assert!((s.fit_percent.unwrap() - 50.0).abs() < 1e-13);
    assert!((s.rmse_over_std.unwrap() - 0.5).abs() < 1e-15);
    assert_eq!(s.relative_error, Some(0.25));
    assert_eq!((s.whiteness, s.input_correlation), (None, None), "too few samples for a residual test");
}

#[test]
fn the_estimated_offset_is_the_mean_residual_and_leaves_the_rest() {
    let rec = record(&[0.0, 1.0, 2.0, 1.0], &[10.0, 12.0, 14.0, 12.0], None);
    let s = score(&rec, &[0.0, 1.0, 4.0, 3.0], &Scoring::default()).unwrap();
    assert_eq!((s.offset, s.offset_estimated), (10.0, true));
    assert_eq!(s.rmse, 0.5_f64.sqrt());
}

#[test]
fn skipped_seconds_and_invalid_samples_are_not_scored() {
    let mut rec = record(&[0.0; 10], &[50.0, 0.0, 1.0, 2.0, 3.0, 99.0, 4.0, 5.0, 6.0, 7.0], Some(10.0));
    let simulated = [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 5.0, 6.0, f64::NAN];
    rec.valid = Some((0..10).map(|k| k != 5 && k != 9).collect());
    let s = score(&rec, &simulated, &Scoring { skip_s: Some(0.1), ..FIXED }).unwrap();
    assert_eq!((s.samples, s.skipped_samples, s.stroke, s.rmse), (7, 3, 6.0, 0.0));
}

#[test]
fn skip_counts_whole_samples_for_every_rate_and_for_given_times() {
    let scored = |rec: &InputOutput, skip_s| {
        score(rec, &rec.y, &Scoring { skip_s: Some(skip_s), ..FIXED }).unwrap().samples
    };
    let y: Vec<f64> = (0..2000).map(f64::from).collect();
    for rate in [10.0, 200.0, 1000.0, 4096.0] {
        assert_eq!(
            scored(&record(&y, &y, Some(rate)), 0.1),
            2000 - (0.1_f64 * rate).ceil() as usize,
            "{rate}"
        );
    }
    let mut rec = record(&y[..4], &y[..4], None);
    rec.time = TimeBase::NonUniform { times_s: vec![5.0, 5.5, 5.7, 9.0] };
    assert_eq!(scored(&rec, 0.6), 2);
}

#[test]
fn a_constant_record_has_errors_but_no_ratios() {
    let y = [0.1; 300];
    let simulated: Vec<f64> = (0..300).map(|k| f64::from(k % 2)).collect();
    let s = score(&record(&y, &y, None), &simulated, &Scoring::default()).unwrap();
    assert_eq!(s.stroke, 0.0);
    assert!((s.rmse - 0.5).abs() < 1e-14 && (s.max_abs_error - 0.5).abs() < 1e-14);
    for ratio in
        [s.rmse_percent_of_stroke, s.max_percent_of_stroke, s.fit_percent, s.rmse_over_std, s.relative_error]
    {
        assert_eq!(ratio, None);
    }
    assert_eq!(s.loop_width_error_percent, None);
}

#[test]
fn every_refusal_names_its_numbers() {
    let rec = record(&[0.0, 1.0], &[0.0, 1.0], None);
    let refused =
        |rec: &InputOutput, simulated: &[f64], scoring| score(rec, simulated, &scoring).unwrap_err();
    assert_eq!(refused(&rec, &[0.0], FIXED), ScoreError::LengthMismatch { measured: 2, simulated: 1 });
    let skip = |skip_s| Scoring { skip_s: Some(skip_s), ..FIXED };
    assert_eq!(refused(&rec, &[0.0, 1.0], skip(1.0)), ScoreError::SkipNeedsTime { skip_s: 1.0 });
    assert_eq!(refused(&rec, &[0.0, 1.0], skip(-1.0)), ScoreError::InvalidSkip { skip_s: -1.0 });
    let timed = record(&[0.0, 1.0], &[0.0, 1.0], Some(1.0));
    assert_eq!(
        refused(&timed, &[0.0, 1.0], skip(1.0)),
        ScoreError::TooFewSamples { scored: 1, total: 2, masked: 0, need: 2 }
    );
    assert!(matches!(
        refused(&rec, &[0.0, f64::INFINITY], FIXED),
        ScoreError::NotFinite { signal: "the simulated output", index: 1, .. }
    ));
    let huge = record(&[0.0, 1.0], &[-1e200, 1e200], None);
    assert!(matches!(
        refused(&huge, &[0.0, 0.0], FIXED),
        ScoreError::Overflow { metric: "rmse", largest: 1e200 }
    ));
}

/// A triangle of `periods` periods of 40 samples between −1 and 1, starting upwards from 0.
fn triangle(periods: usize) -> Vec<f64> {
    (0..40 * periods + 1)
        .map(|k| match k % 40 {
            p @ 0..=10 => p as f64 / 10.0,
            p @ 11..=30 => 2.0 - p as f64 / 10.0,
            p => p as f64 / 10.0 - 4.0,
        })
        .collect()
}

#[test]
fn loop_opening_is_positive_for_a_lagging_output_and_in_output_units() {
    let u = triangle(3);
    let rising = |k: usize| !(10..30).contains(&(k % 40));
    let y: Vec<f64> = (0..u.len()).map(|k| 5.0 * u[k] + if rising(k) { -0.7 } else { 0.7 }).collect();
    let all = vec![true; u.len()];
    assert!((loop_opening(&u, &y, &all).unwrap() - 1.4).abs() < 1e-12);
    let leading: Vec<f64> = (0..u.len()).map(|k| 5.0 * u[k] + if rising(k) { 0.7 } else { -0.7 }).collect();
    assert!((loop_opening(&u, &leading, &all).unwrap() + 1.4).abs() < 1e-12);
    let none = vec![false; u.len()];
    assert_eq!(loop_opening(&u, &y, &none), None);
    assert_eq!(loop_opening(&u[..11], &y[..11], &all[..11]), None, "only one way through the middle");
}

#[test]
fn loop_opening_ignores_dither_about_the_middle_and_masked_passages() {
    let u = triangle(2);
    let rising = |k: usize| !(10..30).contains(&(k % 40));
    let y: Vec<f64> = (0..u.len()).map(|k| 5.0 * u[k] + if rising(k) { -0.7 } else { 0.7 }).collect();
    let mut dithered = u.clone();
    for (k, d) in [(19, 0.006), (20, -0.004), (21, 0.003), (39, 0.006), (40, -0.004), (41, 0.003)] {
        dithered[k] = d;
    }
    let along = |u: &[f64]| -> Vec<f64> {
        u.iter().enumerate().map(|(k, u)| 5.0 * u + if rising(k) { -0.7 } else { 0.7 }).collect()
    };
    let all = vec![true; u.len()];
    // Every passage dithers five times about the middle; the output stays on its branch.
    assert!((loop_opening(&dithered, &along(&dithered), &all).unwrap() - 1.4).abs() < 1e-12);
    let mut spoiled = y.clone();
    spoiled[20] = 1e6;
    let masked: Vec<bool> = (0..u.len()).map(|k| k != 20).collect();
    assert!((loop_opening(&u, &spoiled, &masked).unwrap() - 1.4).abs() < 1e-12);
}

#[test]
fn loop_width_error_is_simulated_minus_measured_in_percent_of_stroke() {
    let u = triangle(3);
    let rising = |k: usize| !(10..30).contains(&(k % 40));
    let with = |half: f64| -> Vec<f64> {
        (0..u.len()).map(|k| 4.3 * u[k] + if rising(k) { -half } else { half }).collect()
    };
    let (measured, simulated) = (with(0.7), with(0.2));
    let s = score(&record(&u, &measured, None), &simulated, &Scoring::default()).unwrap();
    // Openings 1.4 and 0.4; the stroke is from 4.3 − 0.7 … to be read off the samples themselves.
    assert!((s.loop_width_error_percent.unwrap() + 100.0 / s.stroke).abs() < 1e-9);
}

/// Reproducible white noise in (−½, ½).
fn noise(count: usize) -> Vec<f64> {
    let mut state = 12345_u64;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        })
        .collect()
}

#[test]
fn white_noise_passes_the_whiteness_test_and_a_sine_does_not() {
    let e = noise(20_000);
    let all = vec![true; e.len()];
    let white = residual_whiteness(&e, &all).unwrap().test();
    assert_eq!((white.lags, white.bound), (25, 2.575_829_303_548_901 / 20_000_f64.sqrt()));
    assert!(white.outside <= 1, "{white:?}");
    let sine: Vec<f64> = (0..2000).map(|k| (k as f64 * 0.1).sin()).collect();
    let coloured = residual_whiteness(&sine, &all[..2000]).unwrap().test();
    assert!(coloured.outside >= 23 && coloured.largest_lag == 1, "{coloured:?}");
    assert!((coloured.largest - 0.1_f64.cos()).abs() < 1e-2);
}

#[test]
fn a_residual_that_is_the_input_three_samples_late_correlates_at_lag_three() {
    let u = noise(5_000);
    let e: Vec<f64> = (0..u.len()).map(|k| if k >= 3 { -0.2 * u[k - 3] } else { 0.0 }).collect();
    let all = vec![true; u.len()];
    let found = residual_input_correlation(&e, &u, &all).unwrap().test();
    assert_eq!((found.lags, found.largest_lag), (51, 3));
    assert!(found.largest < -0.99);
    let reversed: Vec<f64> = (0..u.len()).map(|k| u.get(k + 2).copied().unwrap_or(0.0)).collect();
    assert_eq!(residual_input_correlation(&reversed, &u, &all).unwrap().test().largest_lag, -2);
    assert_eq!(residual_input_correlation(&vec![0.0; u.len()], &u, &all), None);
}

#[test]
fn definitions_name_every_score_once() {
    let keys: Vec<&str> = definitions().iter().map(|d| d.key).collect();
    let mut unique = keys.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), keys.len());
    let shown = format!("{:?}", score(&record(&[0.0, 1.0], &[0.0, 1.0], None), &[0.0, 1.0], &FIXED).unwrap());
    for key in keys {
        assert!(shown.contains(&format!("{key}:")), "{key} is not a field of Scores");
    }
}

proptest! {
    /// For any finite numbers, scores are finite, ordered as they must be, and no panic happens.
    #[test]
    fn scores_are_finite_and_ordered(
        samples in prop::collection::vec(
            (-1e3..1e3_f64, -1e3..1e3_f64, -1e3..1e3_f64, any::<bool>()),
            0..120,
        ),
        skip_s in 0.0..2.0_f64,
        estimated in any::<bool>(),
    ) {
        let column = |f: fn(&(f64, f64, f64, bool)) -> f64| samples.iter().map(f).collect::<Vec<_>>();
        let mut rec = record(&column(|s| s.0), &column(|s| s.1), Some(100.0));
        rec.valid = Some(samples.iter().map(|s| s.3).collect());
        let offset = if estimated { OffsetTreatment::Estimated } else { OffsetTreatment::Fixed };
        if let Ok(s) = score(&rec, &column(|s| s.2), &Scoring { skip_s: Some(skip_s), offset }) {
            prop_assert_eq!(s.samples + s.skipped_samples, samples.len());
            prop_assert!(s.rmse <= s.max_abs_error * (1.0 + 1e-12));
            for x in [s.rmse_percent_of_stroke, s.fit_percent, s.relative_error, s.loop_width_error_percent]
                .into_iter()
                .flatten()
            {
                prop_assert!(x.is_finite());
            }
            for t in [s.whiteness, s.input_correlation].into_iter().flatten() {
                prop_assert!(t.largest.abs() <= 1.0 + 1e-12);
            }
        }
    }

    /// A shift of the record changes the estimated offset and nothing else.
    #[test]
    fn estimated_offset_absorbs_any_shift(
        samples in prop::collection::vec((-1e2..1e2_f64, -1e2..1e2_f64), 2..60), shift in -1e3..1e3_f64,
    ) {
        let u: Vec<f64> = samples.iter().map(|s| s.0).collect();
        let simulated: Vec<f64> = samples.iter().map(|s| s.1).collect();
        let shifted: Vec<f64> = u.iter().map(|y| y + shift).collect();
        let a = score(&record(&u, &u, None), &simulated, &Scoring::default()).unwrap();
        let b = score(&record(&u, &shifted, None), &simulated, &Scoring::default()).unwrap();
        prop_assert!((b.offset - a.offset - shift).abs() < 1e-9);
        prop_assert!((b.rmse - a.rmse).abs() < 1e-9 * (1.0 + a.rmse));
    }
}
