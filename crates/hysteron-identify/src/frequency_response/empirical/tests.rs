use hysteron_model::Start;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use hysteron_model::dynamics::{Scheme, SimulationPlan, TransferFunction};
use hysteron_model::record::{Channel, Record, TimeBase};
use hysteron_rig::excitation::{Excitation, ExcitationSpec, Lines, Phases, Waveform};

const RATE: f64 = 2000.0;

fn drive(lines: Lines, seed: u64, periods: u32) -> Excitation {
    let waveform = Waveform::Multisine {
        low_hz: 2.0,
        high_hz: 200.0,
        period_s: 0.5,
        periods,
        lines,
        phases: Phases::Random,
    };
    ExcitationSpec { seed, ..ExcitationSpec::new(RATE, -5.0, 5.0, waveform) }.generate().unwrap()
}

fn record(u: Vec<f64>, y: Vec<f64>) -> InputOutput {
    let channels = vec![Channel::new("u", "V", u), Channel::new("y", "um", y)];
    let record = Record::new("run", TimeBase::uniform(RATE), channels).unwrap();
    record.input_output(&Default::default()).unwrap()
}

fn noise(random: &mut Xoshiro256PlusPlus) -> f64 {
    let (a, b): (f64, f64) = (random.random(), random.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Steady-state response of the article's stage, exact at every line.
fn answer(u: &[f64]) -> Vec<f64> {
    let plan = SimulationPlan::new(u.len(), RATE, Scheme::BandLimited, Start::PERIODIC).unwrap();
    let mut y = vec![0.0; u.len()];
    plan.simulate(&TransferFunction::article_eq13(), u, &mut plan.workspace(), &mut y).unwrap();
    y
}

#[test]
fn the_response_of_a_known_system_is_free_of_leakage() {
    for lines in [Lines::Full, Lines::OddWithDetection { group: 4 }] {
        let excitation = drive(lines, 3, 4);
        let u = excitation.samples_v.clone();
        let found = empirical_response(&[record(u.clone(), answer(&u))], &Default::default()).unwrap();
        assert_eq!((found.period_samples, found.realisations, found.periods[0]), (1000, 1, 4));
        assert_eq!(found.response.frequency_hz.len(), excitation.excited_hz.len());
        assert_eq!(found.response.unit, "um_per_V");
        let exact = TransferFunction::article_eq13().frequency_response(&excitation.excited_hz, 0.0);
        for ((f, g), (f0, g0)) in found
            .response
            .frequency_hz
            .iter()
            .zip(&found.response.values)
            .zip(excitation.excited_hz.iter().zip(&exact))
        {
            assert!((f - f0).abs() < 1e-9 && (g / g0 - 1.0).norm() < 1e-10, "{f} Hz: {g} {g0}");
        }
        let in_band = |list: &[f64]| {
            let (low, high) = found.response.range_hz();
            list.iter().copied().filter(|f| (low..=high).contains(f)).collect::<Vec<_>>()
        };
        assert_eq!(found.odd_detection.frequency_hz, in_band(&excitation.odd_detection_hz));
        assert_eq!(found.even_detection.frequency_hz, in_band(&excitation.even_detection_hz));
        assert!(
            found.odd_detection.amplitude.iter().chain(&found.even_detection.amplitude).all(|a| *a < 1e-12)
        );
    }
}

#[test]
fn noise_variance_is_that_of_the_noise_added() {
    let (sigma, periods) = (0.01, 40);
    let u = drive(Lines::Full, 1, periods).samples_v;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let y = answer(&u).iter().map(|y| y + sigma * noise(&mut random)).collect();
    let found = empirical_response(
        &[record(u, y)],
        &EmpiricalOptions { settling_periods: Some(0), ..Default::default() },
    )
    .unwrap();
    // A line 2/N Σ y e^… of white noise has variance 4σ²/N, its mean over P periods 1/P of that.
    let line = 4.0 * sigma * sigma / (1000.0 * f64::from(periods));
    let input = realised_amplitude(&found);
    let noise_std = found.noise_std.unwrap();
    let mean: f64 = noise_std.iter().map(|s| s * s).sum::<f64>() / noise_std.len() as f64;
    // 99 lines of 39 degrees of freedom each, two numbers a line: standard error 1/√(99·39) = 1.6 %.
    assert!((mean * input * input / line - 1.0).abs() < 0.05, "{} {}", mean * input * input, line);
    // And the errors agree with the estimated uncertainty: |error|²/σ² averages one over the lines, ± 1/√99.
    let exact = TransferFunction::article_eq13().frequency_response(&found.response.frequency_hz, 0.0);
    let values = found.response.values.iter().zip(&exact);
    let share: f64 = values.zip(&noise_std).map(|((g, g0), s)| ((g - g0).norm() / s).powi(2)).sum::<f64>()
        / exact.len() as f64;
    assert!((share - 1.0).abs() < 0.35, "{share}");
}

/// Amplitude of every line of the drive, from its variance.
fn realised_amplitude(found: &EmpiricalResponse) -> f64 {
    let u = drive(Lines::Full, 1, 1).samples_v;
    let mean = u.iter().sum::<f64>() / u.len() as f64;
    let power = u.iter().map(|u| (u - mean).powi(2)).sum::<f64>() / u.len() as f64;
    (2.0 * power / found.response.len() as f64).sqrt()
}

#[test]
fn distortion_is_told_from_noise_and_odd_from_even() {
    // y = u + c₂ u² + c₃ u³ without memory, five realisations, with and without noise.
    let run = |c2: f64, c3: f64, sigma: f64| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
        let records: Vec<InputOutput> = (0..5)
            .map(|seed| {
                // The detection lines must be those of the first realisation: only the phases differ.
                let base = drive(Lines::Odd, seed, 4).samples_v;
                let y = base
                    .iter()
                    .map(|u| u + c2 * u * u + c3 * u.powi(3) + sigma * noise(&mut random))
                    .collect();
                record(base, y)
            })
            .collect();
        let options = EmpiricalOptions { settling_periods: Some(0), ..Default::default() };
        empirical_response(&records, &options).unwrap()
    };
    let rms = |list: &[f64]| (list.iter().map(|x| x * x).sum::<f64>() / list.len() as f64).sqrt();
    let linear = run(0.0, 0.0, 1e-3);
    let (distortion, noise_std) = (linear.distortion_std.unwrap(), linear.noise_std.unwrap());
    assert!(rms(&distortion) < 3.0 * 5f64.sqrt() * rms(&noise_std));
    let even = run(0.02, 0.0, 1e-3);
    assert!(rms(&even.even_detection.amplitude) > 20.0 * rms(&even.even_detection.noise));
    // An even nonlinearity does not affect the odd lines of an odd multisine.
    assert!(rms(&even.distortion_std.unwrap()) < 3.0 * 5f64.sqrt() * rms(&even.noise_std.unwrap()));
    let odd = run(0.0, 0.004, 1e-3);
    assert!(rms(&odd.even_detection.amplitude) < 2.0 * rms(&odd.even_detection.noise));
    let (total, noise_std) = (odd.response.std_dev.unwrap(), odd.noise_std.unwrap());
    assert!(rms(&odd.distortion_std.unwrap()) > 5.0 * rms(&noise_std) && rms(&total) > 2.0 * rms(&noise_std));
}

#[test]
fn records_that_do_not_fit_are_refused_with_the_reason() {
    let u = drive(Lines::Full, 3, 4).samples_v;
    let good = record(u.clone(), answer(&u));
    let refused = |records: &[InputOutput], options: &EmpiricalOptions, part: &str| {
        let message = empirical_response(records, options).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    };
    let default = EmpiricalOptions::default();
    refused(&[], &default, "no record");
    let fractional = EmpiricalOptions { period_s: Some(0.50021), ..default };
    refused(std::slice::from_ref(&good), &fractional, "not a whole number");
    let all = EmpiricalOptions { settling_periods: Some(4), ..default };
    refused(std::slice::from_ref(&good), &all, "none is left");
    refused(
        &[good.without_first(3)],
        &EmpiricalOptions { settling_periods: Some(0), ..default },
        "marked invalid",
    );
    let mut timeless = good.clone();
    timeless.time = TimeBase::Unknown;
    refused(&[timeless], &default, "no uniform sample rate");
    let odd = drive(Lines::Odd, 3, 4).samples_v;
    refused(&[good, record(odd.clone(), answer(&odd))], &default, "phases alone");
}
