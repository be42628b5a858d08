//! Promise: each kind of creep follows a step as its equation says, with the stated error, and a joint fit
//! returns its parameters within three standard errors from simulated records.

#![allow(clippy::unwrap_used, clippy::panic)] // a test may fail

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, Identification, Options, RecordRole, Watch, identify,
};
use hysteron_model::Start;
use hysteron_model::dynamics::{
    Creep, DynamicForm, Dynamics, Modes, Scheme, Term, TransferFunction, stability,
};
use hysteron_model::hysteresis::BoucWen;
use hysteron_model::model_file::{Document, ModelFile, SignalUnits, read};
use hysteron_model::record::{ChannelChoice, InputOutput, TimeBase};
use hysteron_numeric::Complex64;
use hysteron_rig::{BoucWenFractional, CampaignPlan, Plant, PowerTerm, Role, Truth, run_campaign};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn creep(creep: Creep, p: &[f64]) -> TransferFunction {
    DynamicForm { modes: Modes::None, creep }.transfer_function(p).unwrap()
}

/// Weights and rates of C = 1 + Σ w λ/(s + λ), from the residues at the known poles.
fn relaxations(tf: &TransferFunction, rates: &[f64]) -> Vec<f64> {
    let at = |terms: &[Term], s: f64| terms.iter().rev().fold(0.0, |sum, term| sum * s + term.coefficient);
    let leading = tf.denominator.last().unwrap().coefficient;
    let weight = |(j, &rate): (usize, &f64)| {
        let others = rates.iter().enumerate().filter(|(i, _)| *i != j).map(|(_, other)| other - rate);
        at(&tf.numerator, -rate) / (leading * others.product::<f64>() * rate)
    };
    rates.iter().enumerate().map(weight).collect()
}

#[test]
fn logarithmic_creep_grows_by_the_same_amount_every_decade() {
    for (per_decade, start) in [(0.02, 0.1), (0.1, 1e-4), (-0.03, 12.0)] {
        let tf = creep(Creep::Logarithmic, &[per_decade, start]);
        assert!(stability(&tf).is_stable());
        assert_eq!(tf.poles().unwrap().len(), 14);
        assert_eq!((tf.numerator.len(), tf.denominator.len()), (15, 15));
        let rates: Vec<f64> = (-1..=12).map(|j| 10f64.powf(-0.5 * f64::from(j)) / start).collect();
        let weights = relaxations(&tf, &rates);
        let mut worst = [0.0f64; 2];
        for k in 0..=800 {
            let ratio = 10f64.powf(-3.0 + 0.01 * f64::from(k));
            let t = ratio * start;
            let step: f64 = weights.iter().zip(&rates).map(|(w, rate)| -w * (-rate * t).exp_m1()).sum();
            let error = (step - per_decade * (1.0 + ratio).log10()).abs() / per_decade.abs();
            let later = usize::from(ratio > 1e4);
            worst[later] = worst[later].max(error);
        }
        println!("largest error in γ: {:.2e} to 1e4 t₀, {:.2e} to 1e5 t₀", worst[0], worst[1]);
        assert!(worst[0] < 4e-4 && worst[1] < 1e-3, "{worst:?}");
    }
}

/// e^x E₁(x) on the right half-plane by Lentz's continued fraction, |x| not small.
fn scaled_exponential_integral(x: Complex64) -> Complex64 {
    let mut fraction = Complex64::ZERO;
    for k in (1..=2000).rev() {
        let k = f64::from(k);
        fraction = k / (1.0 + k / (x + fraction));
    }
    (x + fraction).inv()
}

#[test]
fn logarithmic_creep_has_the_transform_of_the_logarithm() {
    // E₁(1) = 0.21938393439552026 (Abramowitz and Stegun, Table 5.1).
    let one = scaled_exponential_integral(Complex64::ONE);
    assert!((one - 0.219_383_934_395_520_26 * std::f64::consts::E).norm() < 1e-12, "{one}");
    let (per_decade, start) = (0.05, 0.02);
    let tf = creep(Creep::Logarithmic, &[per_decade, start]);
    for ratio in [0.1, 0.5, 1.0, 3.0, 10.0, 100.0] {
        for s in [Complex64::new(ratio, 0.0), Complex64::new(0.0, ratio)] {
            let expected = 1.0 + scaled_exponential_integral(s) * per_decade / std::f64::consts::LN_10;
            let error = (tf.response_at(s / start) - expected).norm();
            assert!(error < 1e-3 * per_decade, "{s}: {:e}", error / per_decade);
        }
    }
}

#[test]
fn a_kelvin_voigt_chain_follows_a_step_by_its_relaxations() {
    let elements = [(0.05, 0.02), (0.03, 0.4), (0.01, 2.0)];
    let p: Vec<f64> = elements.iter().flat_map(|&(k, tau)| [k, tau]).collect();
    let tf = creep(Creep::KelvinVoigt { elements: 3 }, &p);
    assert!((tf.dc_gain() - 1.09).abs() < 1e-13 && (tf.high_frequency_gain() - 1.0).abs() < 1e-13);
    let y = tf.step_response(20_000, 10_000.0, Scheme::Tustin).unwrap();
    for sample in [100, 2000, 10_000, 19_999] {
        let t = sample as f64 / 1e4;
        let expected = 1.0 - elements.iter().map(|(k, tau)| k * (-t / tau).exp_m1()).sum::<f64>();
        // Second order: k (h/τ)²/12 · t/τ e^(−t/τ), at most 4e-8.
        assert!((y[sample] - expected).abs() < 2e-7, "{t}: {} {expected}", y[sample]);
    }
}

/// Parameters that are off by more than three standard errors.
fn off(found: &Identification, expected: &[(&str, f64)]) -> Vec<String> {
    let deviation = |&(name, value): &(&str, f64)| {
        let p = found.parameters.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no {name}"));
        let error = p.std_error.unwrap_or_else(|| panic!("{name} = {} has no error", p.value));
        // Known at all.
        assert!(error < 0.3 * value.abs(), "{name} = {} ± {error}", p.value);
        ((p.value - value).abs() > 3.0 * error).then(|| name.to_owned())
    };
    expected.iter().filter_map(deviation).collect()
}

/// The bench simulates poles and residues of its own.
#[test]
fn a_kelvin_voigt_chain_is_recovered_behind_a_resonance() {
    // (1 + k₁/(1 + τ₁ s) + k₂/(1 + τ₂ s)) ω²/(s² + 2ζω s + ω²), multiplied out by hand.
    let (k, tau) = ([0.06, 0.04], [0.03, 0.7]);
    let (omega, zeta) = (std::f64::consts::TAU * 310.0, 0.18);
    let above = [1.0 + k[0] + k[1], tau[0] + tau[1] + k[0] * tau[1] + k[1] * tau[0], tau[0] * tau[1]];
    let slow = [1.0, tau[0] + tau[1], tau[0] * tau[1]];
    let fast = [1.0, 2.0 * zeta / omega, 1.0 / (omega * omega)];
    let mut below = [0.0; 5];
    for (i, x) in slow.iter().enumerate() {
        fast.iter().enumerate().for_each(|(j, y)| below[i + j] += x * y);
    }
    let terms = |c: &[f64]| -> Vec<PowerTerm> {
        c.iter().enumerate().map(|(k, &coefficient)| PowerTerm { coefficient, order: k as f64 }).collect()
    };
    let mut truth = Truth {
        plant: Plant::BoucWenFractional(BoucWenFractional {
            polynomial: vec![3.2, -0.02],
            alpha: 1.1,
            beta: 0.35,
            gamma: 0.08,
            n: 1.0,
            numerator: terms(&above),
            denominator: terms(&below),
            delay_s: 2e-4,
        }),
        ..Truth::default()
    };
    truth.sensor.adc = None;
    let plan = CampaignPlan {
        sample_rate_hz: 5000.0,
        loop_periods: 4.0,
        sweep_s: 3.0,
        validation_hz: Vec::new(),
        tracking_s: 1.0,
        nested_amplitudes: vec![1.0, 0.5],
        ..CampaignPlan::default()
    };
    let campaign: Vec<CampaignRecord> = run_campaign(&truth, &plan, 3)
        .unwrap()
        .iter()
        .filter(|r| matches!(r.role, Role::QuasiStatic | Role::Sweep | Role::NestedLoops))
        .map(|r| CampaignRecord {
            data: r.run.record.input_output(&ChannelChoice::default()).unwrap(),
            role: None,
        })
        .collect();
    let options = Options {
        dynamics: DynamicsChoice::Integer,
        creep: Creep::KelvinVoigt { elements: 2 },
        degree: Choice::Given(2),
        ..Options::default()
    };
    let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
    let mut elements: Vec<[(String, f64); 2]> = (1..=2)
        .map(|i| {
            [format!("creep_{i}"), format!("creep_time_{i}")]
                .map(|name| (name.clone(), found.parameters.iter().find(|p| p.name == name).unwrap().value))
        })
        .collect();
    elements.sort_by(|a, b| a[1].1.total_cmp(&b[1].1));
    let mut expected = vec![("linear", 3.2), ("alpha", 1.1), ("natural_frequency", 310.0), ("damping", zeta)];
    for (element, (k, tau)) in elements.iter().zip(k.iter().zip(&tau)) {
        expected.extend([(element[0].0.as_str(), *k), (element[1].0.as_str(), *tau)]);
    }
    assert_eq!(off(&found, &expected), Vec::<String>::new());

    // The file holds what was found, with whole orders.
    let mut file = ModelFile::from_model(&found.model, SignalUnits::default());
    let known = found.of_numbers.as_ref().unwrap();
    file.set_covariance(&known.names, &known.matrix);
    let Document::Hammerstein(file) = read(file.to_json().unwrap().as_bytes()).unwrap() else { panic!() };
    let model = file.to_model().unwrap();
    assert!(matches!(&model.dynamics, Dynamics::Integer(g) if g.denominator.len() == 5));
    assert_eq!(model, found.model);
}

/// v after exact logarithmic creep at the samples, v joined by straight lines and 0 before: a piece of slope
/// m adds m ∫ log₁₀(1 + x/t₀) dx.
fn after_logarithmic_creep(v: &[f64], rate_hz: f64, per_decade: f64, start: f64) -> Vec<f64> {
    let integral: Vec<f64> = (0..=v.len())
        .map(|k| {
            let x = k as f64 / rate_hz / start;
            start * ((1.0 + x) * x.ln_1p() - x) / std::f64::consts::LN_10
        })
        .collect();
    let slope: Vec<f64> = v.windows(2).map(|pair| (pair[1] - pair[0]) * rate_hz).collect();
    (0..v.len())
        .map(|k| {
            let crept: f64 = (0..k).map(|j| slope[j] * (integral[k - j] - integral[k - j - 1])).sum();
            v[k] + per_decade * crept
        })
        .collect()
}

#[test]
fn logarithmic_creep_is_recovered_from_its_own_equation() {
    let operator = BoucWen { polynomial: vec![2.8, 0.03], alpha: 0.9, beta: 0.4, gamma: 0.1, n: 1.0 };
    let (per_decade, start, rate_hz) = (0.03, 0.02, 500.0);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut record = |u: &dyn Fn(f64) -> f64, seconds: f64, role| {
        let u: Vec<f64> = (0..(seconds * rate_hz) as usize).map(|k| u(k as f64 / rate_hz)).collect();
        let mut v = vec![0.0; u.len()];
        operator.simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
        // A sum of twelve has variance 1.
        let mut noise = || (0..12).map(|_| random.random_range(-0.5..0.5)).sum::<f64>() * NOISE_UM;
        let y = after_logarithmic_creep(&v, rate_hz, per_decade, start);
        let y = y.into_iter().map(|y| y + 7.0 + noise()).collect();
        let data = InputOutput::new("log creep", TimeBase::uniform(rate_hz), u, y).unwrap();
        CampaignRecord { data, role: Some(role) }
    };
    let loops = |t: f64| 4.0 * (1.0 - 0.08 * t) * (1.0 - (std::f64::consts::TAU * 0.5 * t).cos());
    // Ramps of 40 ms to levels that are held for 3 s.
    let levels = |t: f64| {
        let (step, since) = ((t / 3.0).floor(), t % 3.0);
        let level = |k: f64| [0.0, 6.0, 2.0, 8.0, 4.0, 9.0][(k.max(0.0) as usize).min(5)];
        let part = (since / 0.04).min(1.0);
        level(step) + (level(step + 1.0) - level(step)) * part
    };
    let fast = |t: f64| 3.0 * (1.0 - (std::f64::consts::TAU * (2.0 * t + 3.0 * t * t)).cos());
    let campaign = [
        record(&loops, 8.0, RecordRole::QuasiStatic),
        record(&levels, 15.0, RecordRole::Dynamic),
        record(&fast, 6.0, RecordRole::Dynamic),
    ];
    let options = Options {
        dynamics: DynamicsChoice::None,
        creep: Creep::Logarithmic,
        degree: Choice::Given(2),
        delay_s: Choice::Given(0.0),
        scheme: Choice::Given(Scheme::Tustin),
        ..Options::default()
    };
    let found = identify(&campaign, &options, &Watch::silent(), None).unwrap();
    let expected = [
        ("linear", 2.8),
        ("quadratic", 0.03),
        ("alpha", 0.9),
        ("beta", 0.4),
        ("creep_per_decade", per_decade),
        ("creep_start", start),
    ];
    assert_eq!(off(&found, &expected), Vec::<String>::new());
    for fit in &found.records {
        assert!(fit.scores.rmse < 1.05 * NOISE_UM, "{}", fit.scores.rmse);
    }
}

/// Standard deviation of the noise of the records with logarithmic creep.
const NOISE_UM: f64 = 0.005;
