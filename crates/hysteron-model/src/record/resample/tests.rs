use super::*;
use std::f64::consts::TAU;

fn record(frequency: f64, rate: f64, n: usize) -> InputOutput {
    let u: Vec<f64> = (0..n).map(|k| (TAU * frequency * k as f64 / rate).sin()).collect();
    let y = u.iter().map(|u| 2.0 + u).collect();
    InputOutput::new("r", TimeBase::uniform(rate), u, y).unwrap()
}

#[test]
fn the_bessel_function_is_right() {
    // Abramowitz and Stegun, table 9.8 and 9.11: I0(1), I0(5).
    assert!((bessel_i0(1.0) - 1.266_065_877_752_008).abs() < 1e-14);
    assert!((bessel_i0(5.0) - 27.239_871_823_604_44).abs() < 1e-12);
}

#[test]
fn the_low_pass_passes_and_stops_what_it_says() {
    for (factor, reach) in [(2, 16), (5, 16), (16, 24)] {
        let kernel = low_pass(factor, reach);
        let half = (kernel.len() / 2) as f64;
        assert!((kernel.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        // Gain at a frequency in parts of the new rate.
        let gain = |frequency: f64| -> f64 {
            let step = TAU * frequency / factor as f64;
            kernel.iter().enumerate().map(|(k, h)| h * (step * (k as f64 - half)).cos()).sum()
        };
        let pass = 0.5 - 2.87 / reach as f64;
        for i in 0..=50 {
            let share = f64::from(i) / 50.0;
            let (passed, stopped) = (gain(share * pass), gain(0.5 + share * 0.5 * (factor - 1) as f64));
            assert!((passed - 1.0).abs() < 5e-5, "{factor} {reach} {share}: {passed}");
            assert!(stopped.abs() < 5e-5, "{factor} {reach} {share}: {stopped}");
        }
    }
}

#[test]
fn a_sine_in_the_passband_survives_up_and_down_to_1e_4() {
    let data = record(20.0, 100.0, 1000);
    for rate in [1000.0, 137.0, 60.0] {
        let new = data.resampled(rate).unwrap();
        assert_eq!(new.sample_rate_hz(), Some(rate));
        for (k, u) in new.u.iter().enumerate() {
            let t = k as f64 / rate;
            if (1.0..9.0).contains(&t) {
                assert!((u - (TAU * 20.0 * t).sin()).abs() < 1e-4, "{rate} Hz, {t} s");
            }
        }
    }
}

#[test]
fn what_the_new_rate_cannot_carry_is_removed_and_not_aliased() {
    let new = record(40.0, 100.0, 2000).resampled(50.0).unwrap();
    let middle = &new.u[100..900];
    assert!(
        middle.iter().all(|u| u.abs() < 1e-4),
        "{:?}",
        middle.iter().fold(0.0, |m: f64, u| m.max(u.abs()))
    );
    assert!(new.y[100..900].iter().all(|y| (y - 2.0).abs() < 1e-4));
}

#[test]
fn the_same_rate_returns_the_same_samples_and_decimation_keeps_the_duration() {
    let data = record(5.0, 100.0, 501);
    assert!(data.resampled(100.0).unwrap() == data);
    let tenth = data.decimated(5).unwrap();
    assert_eq!((tenth.len(), tenth.sample_rate_hz()), (101, Some(20.0)));
    assert!(matches!(data.decimated(0), Err(RecordError::BadSetting { .. })));
    assert!(matches!(data.resampled(0.1), Err(RecordError::TooShort { .. })));
    assert!(matches!(data.resampled(f64::INFINITY), Err(RecordError::BadSampleRate { .. })));
    assert!(matches!(data.resampled(1e12), Err(RecordError::BadSetting { .. })));
}

#[test]
fn non_uniform_samples_are_joined_by_lines() {
    let times = TimeBase::from_times("r", vec![0.0, 1.0, 1.0, 4.0]).unwrap();
    let mut data = InputOutput::new("r", times, vec![0.0, 2.0, 4.0, 10.0], vec![0.0; 4]).unwrap();
    data.valid = Some(vec![true, true, true, false]);
    let new = data.resampled(1.0).unwrap();
    assert_eq!(new.u[0], 0.0);
    assert!(new.u[2..].iter().zip([6.0, 8.0, 10.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{:?}", new.u);
    assert_eq!(new.valid, Some(vec![true, true, false, false, false]));
}

/// Two rates without a pause between them, then a pause.
fn segments() -> Record {
    let mut times = vec![0.0];
    for (steps, period) in [(2000, 0.001), (200, 0.01), (1, 1.0), (1000, 0.001)] {
        for _ in 0..steps {
            times.push(times.last().unwrap() + period);
        }
    }
    let slow: Vec<f64> = times.iter().map(|t| (TAU * 0.5 * t).sin()).collect();
    let fast: Vec<f64> = times.iter().map(|t| if *t < 2.0 { (TAU * 180.0 * t).sin() } else { 0.0 }).collect();
    let channels = vec![Channel::new("u", "V", slow), Channel::new("y", "um", fast)];
    Record::new("r", TimeBase::from_times("r", times).unwrap(), channels).unwrap()
}

#[test]
fn segments_of_different_rates_do_not_alias_and_a_gap_is_masked() {
    let record = segments();
    let gaps = record.time.gaps();
    assert_eq!(gaps.len(), 1);
    let new = record.resampled(50.0).unwrap();
    let valid = new.valid.as_ref().unwrap();
    let mut masked = 0;
    for (k, (slow, fast)) in new.channels[0].samples.iter().zip(&new.channels[1].samples).enumerate() {
        let t = new.time.time_s(k).unwrap();
        let in_gap = t > gaps[0].from_s + 1e-9 && t < gaps[0].to_s - 1e-9;
        assert_eq!(valid[k], !in_gap, "{t}");
        masked += usize::from(in_gap);
        if !in_gap && t > 0.7 && (t - 4.0).abs() > 0.7 && (t - 5.0).abs() > 0.7 && t < 5.3 {
            assert!((slow - (TAU * 0.5 * t).sin()).abs() < 2e-3, "{t}: {slow}");
        }
        // 180 Hz sampled at 50 Hz would be 20 Hz of full height.
        if (0.7..1.3).contains(&t) {
            assert!(fast.abs() < 2e-3, "{t}: {fast}");
        }
    }
    assert_eq!(masked, 49);
    // A segment resampled to a finer rate lies on straight lines.
    let fine = record.resampled(1000.0).unwrap();
    let (y, t) = (&fine.channels[0].samples, |k| fine.time.time_s(k).unwrap());
    assert!((y[2505] - 0.5 * (y[2500] + y[2510])).abs() < 1e-4, "{} {}", y[2505], t(2505));
}

#[test]
fn a_pause_between_two_pieces_of_one_rate_leaves_both_as_they_are() {
    let times: Vec<f64> = (0..400).map(|k| f64::from(k) * 0.01 + if k < 200 { 0.0 } else { 5.0 }).collect();
    let u: Vec<f64> = (0..400).map(|k| (0.1 * f64::from(k)).sin()).collect();
    let record =
        Record::new("r", TimeBase::from_times("r", times).unwrap(), vec![Channel::new("u", "V", u.clone())]);
    let new = record.unwrap().resampled(100.0).unwrap();
    for (k, x) in u.iter().enumerate() {
        let at = if k < 200 { k } else { k + 500 };
        let tolerance = if (40..160).contains(&(k % 200)) { 1e-4 } else { 0.05 };
        assert!((new.channels[0].samples[at] - x).abs() < tolerance, "{k}");
    }
    assert_eq!(new.valid.unwrap().iter().filter(|valid| !**valid).count(), 500);
}

#[test]
fn labels_are_held_and_a_stepped_drive_is_filtered() {
    let n = 1000;
    let step: Vec<f64> = (0..n).map(|k| (k / 500) as f64).collect();
    let wave = (0..n).map(|k| (0.05 * k as f64).sin()).collect();
    let channels = vec![
        Channel::new("u", "", step.clone()),
        Channel::new("y", "um", wave),
        Channel::new("segment", "", step),
    ];
    let new = Record::new("r", TimeBase::uniform(1000.0), channels).unwrap().resampled(100.0).unwrap();
    let of = |channel: usize| &new.channels[channel].samples;
    assert!((0..100).all(|k| of(2)[k] == (k / 50) as f64), "{:?}", of(2));
    assert!(of(0).iter().any(|u| *u < -0.01), "{:?}", of(0));
}

#[test]
fn a_record_keeps_all_its_columns_and_needs_times() {
    let record = Record {
        valid: Some(vec![true, false, true, true, true]),
        ..Record::new(
            "r",
            TimeBase::uniform(10.0),
            ["u", "y", "segment"].map(|name| Channel::new(name, "", vec![2.0; 5])).to_vec(),
        )
        .unwrap()
    };
    let new = record.resampled(20.0).unwrap();
    assert_eq!((new.channels.len(), new.len()), (3, 9));
    assert!(new.channels.iter().flat_map(|c| &c.samples).all(|x| (x - 2.0).abs() < 1e-12));
    let valid = new.valid.unwrap();
    assert_eq!(valid, [true, false, false, false, true, true, true, true, true]);
    assert_eq!(record.resampled(10.0).unwrap(), record);
    let without = Record { time: TimeBase::Unknown, ..record };
    assert!(matches!(without.resampled(10.0), Err(RecordError::NoTimes { .. })));
}
