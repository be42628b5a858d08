//! A drive below a threshold that moves nothing is named, and only that.
#![allow(clippy::unwrap_used)] // A failure is a failed test.

use hysteron_identify::{
    CampaignRecord, DynamicsChoice, Finding, FitRecords, IdentifyError, Options, Task, Watch,
};
use hysteron_model::Advice;
use hysteron_model::model_file::{Kind, Maker};
use hysteron_model::record::{DeadBand, InputOutput, TimeBase};
use std::f64::consts::TAU;

const RATE_HZ: f64 = 500.0;

/// Six loops at 1 Hz of amplitudes from 10 V down to 3.75 V, then a sweep of 8 V from 1 to 20 Hz.
fn drive() -> Vec<f64> {
    let loops = (0..3000).map(|k| {
        let t = f64::from(k) / RATE_HZ;
        10.0 * (1.0 - t.floor() / 8.0) * (TAU * t).sin()
    });
    let mut phase = 0.0_f64;
    let sweep = (0..2000).map(move |k| {
        phase += TAU * 20f64.powf(f64::from(k) / 2000.0) / RATE_HZ;
        8.0 * phase.sin()
    });
    loops.chain(sweep).collect()
}

/// Six plays of what counts of the drive, a lag of 10 ms and noise of ±5 nm.
fn device(band: Option<DeadBand>) -> InputOutput {
    let u = drive();
    let mut noise = noise();
    let (mut plays, mut x) = ([0.0_f64; 6], 0.0);
    let decay = (-1.0 / (RATE_HZ * 0.01)).exp();
    let y = u
        .iter()
        .map(|u| {
            let v = band.map_or(*u, |band| band.of(*u));
            for (play, r) in plays.iter_mut().zip([0.5, 1.0, 1.7, 2.5, 3.5, 5.0]) {
                *play = play.clamp(v - r, v + r);
            }
            x = decay * x + (1.0 - decay) * (v + 0.05 * plays.iter().sum::<f64>());
            x + 0.005 * noise()
        })
        .collect();
    InputOutput::new("device", TimeBase::uniform(RATE_HZ), u, y).unwrap()
}

/// Uniform noise from −1 to 1, by a linear congruence.
fn noise() -> impl FnMut() -> f64 {
    let mut state = 1u64;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A process of lags of 0.3 to 30 s, driven to 1 V and back once, with noise of ±5 nm.
fn process(band: Option<DeadBand>) -> InputOutput {
    let rate_hz = 20.0;
    let u: Vec<f64> = (0..1001)
        .map(|k| {
            let t = f64::from(k) / rate_hz;
            (t / 10.0).min(1.0).min(((25.0 - t) / 10.0).max(0.0))
        })
        .collect();
    let mut noise = noise();
    let lags_s = [0.3, 1.0, 3.0, 10.0, 30.0];
    let mut states = [0.0; 5];
    let y = u
        .iter()
        .map(|u| {
            let v = band.map_or(*u, |band| band.of(*u));
            for (x, lag_s) in states.iter_mut().zip(lags_s) {
                *x += (1.0 - f64::exp(-1.0 / (rate_hz * lag_s))) * (v - *x);
            }
            0.2 * states.iter().sum::<f64>() + 0.005 * noise()
        })
        .collect();
    InputOutput::new("process", TimeBase::uniform(rate_hz), u, y).unwrap()
}

fn fitted(data: InputOutput, least_fit_percent: f64) -> Result<Vec<Finding>, IdentifyError> {
    let options = Options { dynamics: DynamicsChoice::Integer, order: 1, ..Options::default() };
    fitted_with(data, Options { least_fit_percent, ..options })
}

fn fitted_with(data: InputOutput, options: Options) -> Result<Vec<Finding>, IdentifyError> {
    let records = FitRecords::Single(vec![CampaignRecord { data, role: None }]);
    let task = Task::Hammerstein(Box::new(options));
    let maker = Maker { program: "test".to_owned(), created: None, command: None };
    assert_eq!(task.kind(), Kind::Hammerstein);
    hysteron_identify::fit(&records, &task, &Watch::silent(), None, &maker).map(|fit| fit.findings)
}

fn named(findings: &[Finding]) -> Option<(f64, bool)> {
    findings.iter().find_map(|finding| match &finding.advice {
        Some(Advice::DeadBand { threshold, excess }) => Some((threshold.parse().unwrap(), *excess)),
        _ => None,
    })
}

#[test]
fn a_dead_band_is_named_beside_the_model() {
    for (band, is_excess) in [(DeadBand::Jump(2.0), false), (DeadBand::Excess(4.0), true)] {
        let findings = fitted(device(Some(band)), 75.0).unwrap();
        let (threshold, excess) = named(&findings).unwrap();
        assert!((threshold - band.threshold()).abs() < 0.02 * band.threshold(), "{band:?}: {threshold}");
        assert_eq!(excess, is_excess);
    }
}

#[test]
fn a_model_of_a_wide_dead_band_is_refused_by_its_name() {
    let data = device(Some(DeadBand::Jump(4.0)));
    let refused = fitted(data.clone(), 75.0).unwrap_err();
    let IdentifyError::DeadBand { threshold, excess: false, .. } = &refused else { panic!("{refused}") };
    assert!((threshold.parse::<f64>().unwrap() - 4.0).abs() < 0.08, "{refused}");
    // With the dead band the class describes it.
    let mut without = data.clone();
    DeadBand::Jump(4.0).apply(&mut without.u);
    assert_eq!(named(&fitted(without, 95.0).unwrap()), None);
    // Regardless of the fit the model is returned, and the dead band named.
    assert!(named(&fitted(data, 0.0).unwrap()).is_some());
}

#[test]
fn none_is_named_where_there_is_none() {
    assert_eq!(named(&fitted(device(None), 75.0).unwrap()), None);
    // Nor where the output has a part of its own, from which no model of the drive is better.
    let mut other = device(None);
    let of = |k: usize| 1.5 * (TAU * 2.7 * k as f64 / RATE_HZ).sin();
    other.y.iter_mut().enumerate().for_each(|(k, y)| *y += of(k));
    assert_eq!(named(&fitted(other, 0.0).unwrap()), None);
}

/// One move up and one down, which a regression of many columns follows with any drive.
#[test]
fn a_dead_band_is_named_from_one_move() {
    let refused = fitted_with(process(Some(DeadBand::Jump(0.25))), Options::default()).unwrap_err();
    let IdentifyError::DeadBand { threshold, excess: false, .. } = &refused else { panic!("{refused}") };
    assert!((threshold.parse::<f64>().unwrap() - 0.25).abs() < 0.01, "{refused}");
    let findings = fitted_with(process(None), Options { least_fit_percent: 0.0, ..Options::default() });
    assert_eq!(named(&findings.unwrap()), None);
}
