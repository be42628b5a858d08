use super::*;
use hysteron_model::dynamics::TransferFunction;
use hysteron_numeric::Complex64;

fn spaced(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| low * (high / low).powf(k as f64 / (count - 1) as f64)).collect()
}

#[test]
fn a_resonance_is_told_from_a_smooth_response() {
    let frequency_hz = spaced(1.0, 300.0, 80);
    let of = |g: &dyn Fn(f64) -> f64| {
        let values = frequency_hz.iter().map(|&f| Complex64::new(g(f), 0.0)).collect();
        has_resonance(&FrequencyResponse::new("g", frequency_hz.clone(), values).unwrap())
    };
    assert!(of(&|f| 1.0 + (-((f - 50.0) / 10.0).powi(2)).exp()));
    assert!(!of(&|f| f.powf(-0.05)));
    assert!(!of(&|f| 1.0 / (1.0 + f)));
    assert!(!of(&|f| f));
}

#[test]
fn the_structure_that_made_a_smooth_response_has_the_lowest_criterion_and_competitors_as_many_parameters() {
    let frequency_hz = spaced(1.0, 100.0, 40);
    // Deterministic errors of 1e-4, so that criteria are finite.
    let values = frequency_hz
        .iter()
        .enumerate()
        .map(|(k, f)| {
            let error = Complex64::from_polar(1e-4, (k * k) as f64);
            Complex64::from_polar(2.0 * f.powf(-0.04), -0.1) * (1.0 + error)
        })
        .collect();
    let response = FrequencyResponse::new("lossy", frequency_hz, values).unwrap();
    let found = compare(&response, Weighting::Relative, &Family::for_response(&response), None).unwrap();
    let names: Vec<&str> = found.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["power law", "fractional", "integer", "loss angle"]);
    let parameters: Vec<usize> = found.iter().map(|c| c.fit.parameters.len()).collect();
    assert_eq!(parameters, [2, 3, 3, 3]);
    let best = found.iter().min_by(|a, b| a.fit.aic.total_cmp(&b.fit.aic)).unwrap();
    assert_eq!(best.name, "loss angle");
    // −0.1 rad in all, of which the power law takes 0.04·90° = 3.6°.
    assert!(best.explanation.contains("constant phase of −3.60°"), "{}", best.explanation);
    assert!(
        best.explanation.contains("further constant phase of −2.13°, a loss angle"),
        "{}",
        best.explanation
    );
}

#[test]
fn the_number_of_modes_is_found() {
    let frequency_hz = spaced(20.0, 1500.0, 80);
    let mode = |f: f64, zeta: f64| {
        let omega = std::f64::consts::TAU * f;
        TransferFunction::new(
            vec![hysteron_model::dynamics::Term::new(omega * omega, 0.0)],
            vec![
                hysteron_model::dynamics::Term::new(omega * omega, 0.0),
                hysteron_model::dynamics::Term::new(2.0 * zeta * omega, 1.0),
                hysteron_model::dynamics::Term::new(1.0, 2.0),
            ],
        )
        .unwrap()
    };
    let parts: Vec<Vec<Complex64>> = [(120.0, 0.02), (400.0, 0.03), (900.0, 0.02)]
        .iter()
        .map(|&(f, zeta)| mode(f, zeta).frequency_response(&frequency_hz, 1e-4))
        .collect();
    let values = (0..frequency_hz.len())
        .map(|k| {
            let error = Complex64::from_polar(1e-3, (k * k) as f64 * 0.7);
            parts.iter().map(|p| p[k]).sum::<Complex64>() * (1.0 + error)
        })
        .collect();
    let response = FrequencyResponse::new("modes", frequency_hz, values).unwrap();
    let found = compare(&response, Weighting::Relative, &[Family::Modes], None).unwrap();
    assert_eq!(found[0].name, "3 modes");
    let fit = &found[1].fit;
    for (i, f) in [120.0, 400.0, 900.0].iter().enumerate() {
        let found = fit.value(&format!("mode{}_frequency", i + 1));
        assert!((found / f - 1.0).abs() < 1e-3, "{found}");
    }
    assert!(fit.relative_rms < 1.1e-3 && fit.value("exponent").abs() < 1e-3);
}

/// A structure that contains another never fits worse, noise or not.
#[test]
fn nested_structures_fit_in_order() {
    for seed in 0..4 {
        let frequency_hz: Vec<f64> = (0..160).map(|k| 10f64.powf(f64::from(k) / 50.0)).collect();
        let noise = |k: usize| {
            let turn = (k * k * (2 * seed + 7)) as f64 * 0.61;
            Complex64::new(turn.cos(), turn.sin()) * 0.05
        };
        let value = |(k, f): (usize, &f64)| {
            let mode = |f0: f64, damping: f64| {
                Complex64::ONE / Complex64::new(1.0 - (f / f0).powi(2), 2.0 * damping * f / f0)
            };
            (mode(310.0, 0.02) + mode(700.0, 0.01) * 0.3) * f.powf(-0.04) * (Complex64::ONE + noise(k))
        };
        let values = frequency_hz.iter().enumerate().map(value).collect();
        let response = FrequencyResponse::new("two modes", frequency_hz.clone(), values).unwrap();
        let found = compare(&response, Weighting::Relative, &[Family::Modes], None).unwrap();
        let squares: Vec<f64> = found.iter().map(|c| c.fit.square).collect();
        assert!(squares.windows(2).all(|two| two[1] <= two[0] * (1.0 + 1e-9)), "{seed}: {squares:?}");
    }
}
