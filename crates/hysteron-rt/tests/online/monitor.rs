//! The monitor's run lengths: simulated, by the Markov chain of Brook and Evans, and as promised.

use super::noise::Noise;
use hysteron_rt::{FitMonitor, Misfit, MonitorSettings, ParameterError, SampleError};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

const RUN_LENGTH: f64 = 200.0;

fn monitor(shift: Option<f64>, spread: Option<f64>, run_length: f64) -> FitMonitor<f64> {
    FitMonitor::new(MonitorSettings { shift, spread, run_length, fewest: 1 }).unwrap()
}

/// Mean number of samples to the alarm, and its standard error, of residuals `mean` + `deviation`·N(0, 1).
fn simulated(monitor: FitMonitor<f64>, (mean, deviation): (f64, f64), runs: u32, seed: u64) -> (f64, f64) {
    let mut noise = Noise(seed);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..runs {
        let (mut monitor, mut length) = (monitor, 1.0);
        while monitor.step(mean + deviation * noise.normal()).unwrap().is_none() {
            length += 1.0;
        }
        sum += length;
        squares += length * length;
    }
    let mean = sum / f64::from(runs);
    (mean, ((squares / f64::from(runs) - mean * mean) / f64::from(runs)).sqrt())
}

/// Mean run length of S ← max(0, S + x), x of the distribution function `below`, from 0 to above h: a Markov
/// chain on m cells (D. Brook, D. A. Evans, *Biometrika* 59 (1972) 539–549, doi:10.1093/biomet/59.3.539), the
/// error in 1/m² removed.
fn by_markov_chain(below: impl Fn(f64) -> f64, h: f64) -> f64 {
    let chain = |m: usize| {
        // Cell j is centred on j·w, the first one cut at 0, the last one's upper edge is h.
        let w = 2.0 * h / (2 * m - 1) as f64;
        let edge = |i: usize, j: usize| below((j as f64 - i as f64 + 0.5) * w);
        let q = DMatrix::from_fn(m, m, |i, j| {
            if j == 0 { edge(i, 0) } else { edge(i, j) - below((j as f64 - i as f64 - 0.5) * w) }
        });
        (DMatrix::identity(m, m) - q).lu().solve(&DVector::from_element(m, 1.0)).unwrap()[0]
    };
    let (coarse, fine) = (chain(150), chain(300));
    fine + (fine - coarse) / 3.0
}

fn normal(x: f64) -> f64 {
    0.5 * libm::erfc(-x / 2.0_f64.sqrt())
}

/// Distribution of the increment of the shift's upper sum.
fn shift_increment(shift: f64, mean: f64) -> impl Fn(f64) -> f64 {
    move |x| normal(x / shift + 0.5 * shift - mean)
}

/// Distribution of the increment of the spread's sum.
fn spread_increment(ratio: f64, deviation: f64) -> impl Fn(f64) -> f64 {
    move |x| {
        let square = (x + ratio.ln()) / (0.5 * (1.0 - 1.0 / (ratio * ratio)));
        if square > 0.0 { libm::erf((square / 2.0).sqrt() / deviation) } else { 0.0 }
    }
}

fn assert_agrees(what: &str, (found, error): (f64, f64), want: f64, relative: f64) {
    println!("{what}: simulated {found:.1} ± {error:.1}, by the chain {want:.1}");
    assert!((found - want).abs() < 4.0 * error + relative * want, "{what}: {found} ± {error} for {want}");
}

#[test]
fn the_chain_gives_published_run_lengths() {
    // Two-sided sums with k = 1/2 (J. M. Lucas, R. B. Crosier, *Technometrics* 24 (1982) 199–205,
    // doi:10.1080/00401706.1982.10487759, and textbooks since). In log-likelihood ratios of δ = 1 sum and
    // threshold are the same.
    let sides = |mean: f64, h| {
        let side = |mean| 1.0 / by_markov_chain(shift_increment(1.0, mean), h);
        1.0 / (side(mean) + side(-mean))
    };
    for (h, mean, want, last_digit) in [
        (4.0, 0.0, 168.0, 1.0),
        (4.0, 0.5, 26.6, 0.1),
        (4.0, 1.0, 8.38, 0.01),
        (5.0, 0.0, 465.0, 1.0),
        (5.0, 0.5, 38.0, 0.1),
        (5.0, 1.0, 10.4, 0.1),
    ] {
        let found = sides(mean, h);
        assert!((found - want).abs() <= 0.51 * last_digit, "h {h}, mean {mean}: {found} for {want}");
    }
}

#[test]
fn false_alarms_are_as_rare_as_theory_says_and_rarer_than_promised() {
    let runs = 3000;
    for shift in [0.5, 1.0] {
        let watch = monitor(Some(shift), None, RUN_LENGTH);
        let found = simulated(watch, (0.0, 1.0), runs, 1);
        // The two sides of a two-sided sum cannot both be raised when one alarms: rates add (W. D. Ewan, K.
        // W. Kemp 1960).
        let want = 0.5 * by_markov_chain(shift_increment(shift, 0.0), watch.threshold());
        assert_agrees(&format!("shift {shift}, no change"), found, want, 2e-3);
        assert!(want > RUN_LENGTH);
    }
    for ratio in [1.5, 2.0] {
        let watch = monitor(None, Some(ratio), RUN_LENGTH);
        let found = simulated(watch, (0.0, 1.0), runs, 2);
        // The density of r² is infinite at 0: the chain converges slower here.
        let want = by_markov_chain(spread_increment(ratio, 1.0), watch.threshold());
        assert_agrees(&format!("spread {ratio}, no change"), found, want, 1e-2);
        assert!(want > RUN_LENGTH);
    }
    let (found, error) = simulated(monitor(Some(0.5), Some(1.5), RUN_LENGTH), (0.0, 1.0), runs, 3);
    println!("both, no change: simulated {found:.1} ± {error:.1}, promised {RUN_LENGTH}");
    assert!(found - 4.0 * error > RUN_LENGTH);
}

#[test]
fn alarms_come_after_the_delay_that_theory_says() {
    for run_length in [1e3, 1e5] {
        let shift = monitor(Some(0.5), None, run_length);
        let want = by_markov_chain(shift_increment(0.5, 0.5), shift.threshold());
        assert_agrees("shift by 0.5", simulated(shift, (0.5, 1.0), 3000, 4), want, 2e-3);
        assert_agrees("shift by −0.5", simulated(shift, (-0.5, 1.0), 3000, 5), want, 2e-3);
        let stated = shift.delay(Misfit::Below).unwrap();
        assert!((want / stated - 1.0).abs() < 0.25, "{want} for {stated}");
        let spread = monitor(None, Some(1.5), run_length);
        let want = by_markov_chain(spread_increment(1.5, 1.5), spread.threshold());
        assert_agrees("spread by 1.5", simulated(spread, (0.0, 1.5), 3000, 6), want, 1e-2);
        let stated = spread.delay(Misfit::Spread).unwrap();
        assert!((want / stated - 1.0).abs() < 0.25, "{want} for {stated}");
        assert_eq!((shift.delay(Misfit::Spread), spread.delay(Misfit::Above)), (None, None));
    }
}

#[test]
fn sums_by_hand_and_what_they_say() {
    // δ = 1: increments ±r − 1/2. L = e⁴/2: h = 4.
    let mut watch = monitor(Some(1.0), None, 4.0_f64.exp() / 2.0);
    assert!((watch.threshold() - 4.0).abs() < 1e-14);
    assert_eq!(watch.step(2.5), Ok(None));
    assert_eq!(watch.sums(), &[2.0, 0.0, 0.0]);
    assert_eq!(watch.step(2.5), Ok(None));
    assert_eq!(watch.step(1.0), Ok(Some(Misfit::Above)));
    assert_eq!(watch.sums(), &[4.5, 0.0, 0.0]);
    // The alarm lasts until it fits again.
    assert_eq!(watch.step(0.25), Ok(Some(Misfit::Above)));
    assert_eq!(watch.step(0.0), Ok(None));
    watch.reset();
    assert_eq!(watch.sums(), &[0.0; 3]);
    assert_eq!(watch.step(-5.0), Ok(Some(Misfit::Below)));
    assert_eq!(watch.step(f64::NAN), Err(SampleError::NotFinite));
    assert_eq!(watch.sums(), &[0.0, watch.threshold() * (1.0 + 4.0 * f64::EPSILON), 0.0]);
}

#[test]
fn fewer_wild_samples_than_stated_are_no_alarm() {
    let settings = MonitorSettings { shift: Some(0.5), spread: Some(1.5), run_length: 1e4, fewest: 3 };
    let mut watch = FitMonitor::new(settings).unwrap();
    assert_eq!(watch.step(1e200), Ok(None));
    assert_eq!(watch.step(-1e200), Ok(None));
    assert!(watch.step(1e3).unwrap().is_some());
}

#[test]
fn what_cannot_be_is_refused() {
    let good = MonitorSettings { shift: Some(0.5), spread: Some(1.5), run_length: 1e4, fewest: 1 };
    let refused = |settings| FitMonitor::new(settings).unwrap_err();
    assert_eq!(refused(MonitorSettings { shift: None, spread: None, ..good }), ParameterError::NoChange);
    for shift in [0.0, -1.0, f64::NAN, 1e200] {
        assert!(matches!(
            refused(MonitorSettings { shift: Some(shift), ..good }),
            ParameterError::Number { .. }
        ));
    }
    for spread in [1.0, 0.5, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            refused(MonitorSettings { spread: Some(spread), ..good }),
            ParameterError::Number { .. }
        ));
    }
    for run_length in [1.0, 0.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(MonitorSettings { run_length, ..good }), ParameterError::Number { .. }));
    }
    assert!(matches!(refused(MonitorSettings { fewest: 0, ..good }), ParameterError::Number { .. }));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn sums_are_those_of_the_definition_and_finite(
        residuals in prop::collection::vec(-6.0..6.0_f64, 1..60),
        shift in 0.1..3.0_f64,
        ratio in 1.1..4.0_f64,
    ) {
        let mut watch = monitor(Some(shift), Some(ratio), 1e9);
        for end in 1..=residuals.len() {
            watch.step(residuals[end - 1]).unwrap();
            // max over starts of the sum of log-likelihood ratios since: Page's other form.
            let best = |ratio: &dyn Fn(f64) -> f64| {
                (0..=end)
                    .map(|from| residuals[from..end].iter().map(|&r| ratio(r)).sum::<f64>())
                    .fold(0.0, f64::max)
            };
            let density =
                |r: f64, mean: f64, deviation: f64| -0.5 * ((r - mean) / deviation).powi(2) - deviation.ln();
            let ratio_to =
                |mean: f64, deviation: f64| best(&|r| density(r, mean, deviation) - density(r, 0.0, 1.0));
            let want = [ratio_to(shift, 1.0), ratio_to(-shift, 1.0), ratio_to(0.0, ratio)];
            let h = watch.threshold();
            if want.iter().any(|&w| w > h) {
                break;
            }
            for (found, want) in watch.sums().iter().zip(want) {
                prop_assert!((found - want).abs() < 1e-10, "{found} {want}");
            }
        }
    }

    #[test]
    fn any_residual_leaves_finite_sums(residuals in prop::collection::vec(prop::num::f32::ANY, 1..60)) {
        let settings =
            MonitorSettings { shift: Some(0.5_f32), spread: Some(2.0), run_length: 1e4, fewest: 2 };
        let mut watch = FitMonitor::new(settings).unwrap();
        for residual in residuals {
            prop_assert_eq!(watch.step(residual).is_err(), !residual.is_finite());
            prop_assert!(watch.sums().iter().all(|s| *s >= 0.0 && *s <= 2.0 * watch.threshold()));
            prop_assert_eq!(watch.alarm().is_some(), watch.sums().iter().any(|s| *s > watch.threshold()));
        }
    }
}
