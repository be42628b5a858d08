use super::*;
use crate::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use crate::hysteresis::Hysteresis;
use crate::record::InterSample;
use hysteron_numeric::normal::quantile;

fn model() -> Model {
    Model {
        hysteresis: Hysteresis::without_memory(vec![2.0]).unwrap(),
        dynamics: Dynamics::None,
        offset: 0.0,
        delay_s: 0.0,
        scheme: Scheme::Tustin,
        inter_sample: InterSample::Linear,
        sample_rate_hz: None,
    }
}

/// Any numbers of either sign.
fn number(k: usize) -> f64 {
    (12.989_8 * k as f64).sin()
}

fn misfit() -> MisfitModel {
    MisfitModel {
        basis: Basis { low_v: 0.0, high_v: 10.0, frequency_hz: 20.0 },
        noise: 0.02,
        explained: 0.5,
        mean: (0..COLUMNS).map(|j| 0.1 * number(j)).collect(),
        directions: (0..COLUMNS)
            .map(|k| (0..COLUMNS).map(|j| 0.05 * number(100 + k * COLUMNS + j)).collect())
            .collect(),
        information: (0..COLUMNS).map(|k| if k % 2 == 0 { 30.0 } else { 0.1 }).collect(),
        one_amplitude: false,
        left_out: None,
    }
}

fn drive(samples: usize) -> Vec<f64> {
    (0..samples).map(|k| 5.0 - 4.0 * (k as f64 * 0.013).cos() + 0.8 * (k as f64 * 0.171).sin()).collect()
}

#[test]
fn agrees_with_a_dense_product_with_the_covariance() {
    let (of, drive, start) = (misfit(), drive(700), Start::AsIdentified);
    let found = of.predict(&model(), &drive, Timing::Rate(500.0), &start).unwrap();
    let uniform = TimedRun { samples_v: &drive, timing: Timing::Rate(500.0), start: &start };
    let mut columns = of.basis.columns(&model(), &uniform, 1).unwrap();
    for column in &mut columns {
        let mean = column.iter().sum::<f64>() / column.len() as f64;
        column.iter_mut().for_each(|x| *x -= mean);
    }
    let covariance = |i: usize, j: usize| of.directions.iter().map(|f| f[i] * f[j]).sum::<f64>();
    for t in [0, 13, 311, 699] {
        let row: Vec<f64> = columns.iter().map(|c| c[t]).collect();
        let mean: f64 = row.iter().zip(&of.mean).map(|(x, b)| x * b).sum();
        let mut variance = 0.0;
        for i in 0..COLUMNS {
            for j in 0..COLUMNS {
                variance += row[i] * covariance(i, j) * row[j];
            }
        }
        assert!((found.discrepancy[t] - mean).abs() < 1e-12);
        assert!((found.std_dev[t] - variance.sqrt()).abs() < 1e-10 * variance.sqrt().max(1.0));
    }
    assert!(found.unexcited > 0.0 && found.unexcited < 1.0);
}

#[test]
fn the_half_width_holds_its_share_of_a_normal_distribution() {
    let level = 0.95;
    let ends = (quantile(level), quantile(0.5 + 0.5 * level));
    // Midpoint rule over the density.
    let share = |mean: f64, sd: f64, g: f64| {
        let steps = 200_000;
        let width = 2.0 * g / f64::from(steps);
        let density =
            |x: f64| (-0.5 * ((x - mean) / sd).powi(2)).exp() / (sd * (2.0 * std::f64::consts::PI).sqrt());
        (0..steps).map(|k| width * density(-g + (f64::from(k) + 0.5) * width)).sum::<f64>()
    };
    for (mean, sd) in [(0.0, 1.0), (0.3, 1.0), (-1.0, 2.0), (5.0, 1.0), (2.0, 0.5), (1.0, 0.3)] {
        let g = half_width(mean, sd, level, ends);
        assert!((share(mean, sd, g) - level).abs() < 1e-7, "{mean} {sd}: {g} holds {}", share(mean, sd, g));
    }
    assert_eq!(half_width(-2.0, 0.0, level, ends), 2.0);
}

#[test]
fn without_misfit_the_band_is_that_of_the_noise() {
    let none =
        MisfitModel { mean: vec![0.0; COLUMNS], directions: Vec::new(), information: Vec::new(), ..misfit() };
    let found = none.predict(&model(), &drive(100), Timing::Rate(500.0), &Start::AsIdentified).unwrap();
    assert!(
        found
            .half_width(0.95)
            .iter()
            .all(|h| (h / (prediction::WIDENING * 1.959_963_985 * 0.02) - 1.0).abs() < 1e-8)
    );
    assert_eq!(found.unexcited, 0.0);
}

#[test]
fn a_long_drive_is_averaged_and_taken_back_to_every_sample() {
    let (of, drive, start) = (misfit(), drive(70_001), Start::AsIdentified);
    let found = of.predict(&model(), &drive, Timing::Rate(20_000.0), &start).unwrap();
    assert_eq!((found.discrepancy.len(), found.std_dev.len()), (70_001, 70_001));
    let uniform = TimedRun { samples_v: &drive, timing: Timing::Rate(20_000.0), start: &start };
    let columns = of.basis.columns(&model(), &uniform, 1).unwrap();
    let means: Vec<f64> = columns.iter().map(|c| c.iter().sum::<f64>() / c.len() as f64).collect();
    let at = |t: usize| -> f64 {
        columns.iter().zip(&means).zip(&of.mean).map(|((c, mean), b)| b * (c[t] - mean)).sum()
    };
    let exact: Vec<f64> = (0..drive.len()).step_by(9973).map(at).collect();
    let largest = found.discrepancy.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    for (place, exact) in exact.iter().enumerate() {
        assert!((found.discrepancy[place * 9973] - exact).abs() < 0.01 * largest, "{place}");
    }
}

#[test]
fn a_gain_scales_what_is_not_proportional_to_the_output_already() {
    let scaled = misfit().scaled(2.0);
    let (old, dynamics) = (misfit(), GROUPS[0].1);
    assert_eq!((scaled.mean[0], scaled.mean[dynamics]), (2.0 * old.mean[0], old.mean[dynamics]));
    assert_eq!(scaled.directions[3][COLUMNS - 1], 2.0 * old.directions[3][COLUMNS - 1]);
    assert_eq!(scaled.noise, 2.0 * old.noise);
    // The prediction of a device with twice the gain is twice that of the other.
    let (drive, start) = (drive(300), Start::AsIdentified);
    let mut doubled = model();
    doubled.hysteresis = Hysteresis::without_memory(vec![4.0]).unwrap();
    let of = |misfit: &MisfitModel, model: &Model| {
        misfit.predict(model, &drive, Timing::Rate(500.0), &start).unwrap()
    };
    let (one, two) = (of(&old, &model()), of(&scaled, &doubled));
    assert!(one.discrepancy.iter().zip(&two.discrepancy).all(|(a, b)| (2.0 * a - b).abs() < 1e-12));
    assert!(one.std_dev.iter().zip(&two.std_dev).all(|(a, b)| (2.0 * a - b).abs() < 1e-12));
}

#[test]
fn a_band_that_rests_on_other_devices_says_so_and_names_the_record() {
    let predicted = |of: &MisfitModel| {
        of.predict(&model(), &drive(300), Timing::Rate(500.0), &Start::AsIdentified).unwrap()
    };
    let informed = MisfitModel { information: vec![30.0; COLUMNS], ..misfit() };
    assert_eq!(predicted(&informed).finding(), None);
    let one = predicted(&MisfitModel { one_amplitude: true, ..informed.clone() }).finding().unwrap();
    assert!(one.text.contains("one amplitude") && one.text.contains("ested loops"), "{}", one.text);
    let none =
        MisfitModel { information: vec![0.1; COLUMNS], noise: 1e-3, mean: vec![0.0; COLUMNS], ..informed };
    let text = predicted(&none).finding().unwrap().text;
    assert!(text.starts_with("100 % of the expected squared error rest on other devices"), "{text}");
}

/// Lines between samples: what stands between them may be left out.
#[test]
fn stamps_of_any_spacing_give_the_columns_of_the_common_grid() {
    let rate_hz = 1000.0;
    // A straight line over every four samples.
    let corner = |k: usize| 5.0 - 4.0 * (k as f64 * 0.02).cos() + 0.8 * (k as f64 * 0.07).sin();
    let fine: Vec<f64> = (0..2001)
        .map(|k| {
            let share = (k % 4) as f64 / 4.0;
            (1.0 - share) * corner(k / 4) + share * corner(k / 4 + 1)
        })
        .collect();
    let kept: Vec<usize> = (0..fine.len()).filter(|k| k % 4 == 0 || k % 7 == 0).collect();
    let times_s: Vec<f64> = kept.iter().map(|k| *k as f64 / rate_hz).collect();
    let samples_v: Vec<f64> = kept.iter().map(|k| fine[*k]).collect();
    // Lags of 20 ms and more are resolved by steps of up to 4 ms.
    let (basis, start) = (Basis { frequency_hz: 2.0, ..misfit().basis }, Start::AsIdentified);
    let even = TimedRun { samples_v: &fine, timing: Timing::Rate(rate_hz), start: &start };
    let uneven = TimedRun { samples_v: &samples_v, timing: Timing::Stamps(&times_s), start: &start };
    let term = |coefficient, order| Term { coefficient, order };
    let lag = TransferFunction::new(vec![term(1.0, 0.0)], vec![term(1.0, 0.0), term(0.01, 1.0)]).unwrap();
    let dynamic =
        Model { dynamics: Dynamics::Integer(lag), delay_s: 4e-3, scheme: Scheme::BandLimited, ..model() };
    for model in [Model { delay_s: 4e-3, ..model() }, dynamic] {
        let expected = basis.columns(&model, &even, 1).unwrap();
        let found = basis.columns(&model, &uneven, 1).unwrap();
        for (which, (expected, found)) in expected.iter().zip(&found).enumerate() {
            let size = expected.iter().fold(f64::MIN_POSITIVE, |size, x| size.max(x.abs()));
            let off =
                kept.iter().zip(found).map(|(k, found)| (found - expected[*k]).abs()).fold(0.0, f64::max);
            assert!(off < 0.02 * size, "column {which}: {off:.1e} of {size:.1e}");
        }
    }
}
