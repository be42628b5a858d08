//! Simulation against answers known in closed form and against tiny steps.

use hysteron_model::Start;
use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::oscillator::{Drive, Oscillator, OscillatorState, SimulationError};

use crate::oracles::{BENCHMARK, multisine, relative, tiny_steps};

const RATE: f64 = 750.0;

fn simulate(
    p: &Oscillator,
    u: &[f64],
    rule: InterSample,
    steps: usize,
    start: Start<OscillatorState>,
) -> Vec<f64> {
    let ends = if start == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
    let drive = Drive::new(u, RATE, rule, ends, steps).unwrap();
    let mut y = vec![0.0; u.len()];
    p.simulate(&drive, start, &mut y).unwrap();
    y
}

/// y of m ÿ + c ẏ + k y = 1 from rest: 1 − e^(−ζω₀t) (cos ω_d t + ζω₀/ω_d sin ω_d t), over k.
fn step_response(m: f64, c: f64, k: f64, t: f64) -> f64 {
    let decay = 0.5 * c / m;
    let frequency = (k / m - decay * decay).sqrt();
    (1.0 - (-decay * t).exp() * ((frequency * t).cos() + decay / frequency * (frequency * t).sin())) / k
}

#[test]
fn without_loop_it_is_the_linear_oscillator() {
    // β = γ = 0: z = α y, stiffness k + α. Fourth order: (0.0298 rad)⁴/120 a step at ten steps a sample.
    let linear = Oscillator { beta: 0.0, gamma: 0.0, ..BENCHMARK };
    let u = vec![30.0; 600];
    for n in [1.0, 1.7, 2.0] {
        let y = simulate(
            &Oscillator { n, ..linear },
            &u,
            InterSample::Linear,
            linear.steps(RATE),
            Start::AsIdentified,
        );
        let exact: Vec<f64> =
            (0..u.len()).map(|k| 30.0 * step_response(2.0, 10.0, 1e5, k as f64 / RATE)).collect();
        let error = relative(&y, &exact);
        assert!(error < 2e-6, "n = {n}: {error:e}");
    }
}

#[test]
fn a_known_state_swings_freely_as_the_formula_says() {
    let linear = Oscillator { alpha: 0.0, beta: 0.0, gamma: 0.0, stiffness: 1e5, ..BENCHMARK };
    // From y₀ at rest: y₀ times what a step of force leaves of itself.
    let start = Start::from(OscillatorState { y: 1e-3, velocity: 0.0, z: 0.0 });
    let y = simulate(&linear, &[0.0; 600], InterSample::Linear, 10, start);
    let exact: Vec<f64> =
        (0..600).map(|k| 1e-3 * (1.0 - 1e5 * step_response(2.0, 10.0, 1e5, k as f64 / RATE))).collect();
    assert!(relative(&y, &exact) < 2e-6, "{:e}", relative(&y, &exact));
}

#[test]
fn it_agrees_with_tiny_steps_and_its_error_is_of_second_order() {
    let u = multisine(600, 1);
    for (beta, gamma, n) in [(800.0, -1100.0, 1.0), (500.0, 300.0, 1.0), (14.0, 6.0, 2.0), (80.0, -30.0, 1.5)]
    {
        let p = Oscillator { beta, gamma, n, ..BENCHMARK };
        let oracle = tiny_steps(&p, &u, RATE, InterSample::BandLimited, 400);
        let error = |steps: usize| {
            relative(&simulate(&p, &u, InterSample::BandLimited, steps, Start::AsIdentified), &oracle)
        };
        let (chosen, fine) = (error(p.steps(RATE)), error(8 * p.steps(RATE)));
        println!(
            "β {beta}, γ {gamma}, n {n}: {chosen:.2e} at {} steps, {fine:.2e} at 8 times",
            p.steps(RATE)
        );
        assert!(chosen < 1.5e-4, "{chosen:e}");
        // 64 times smaller, were the corners hit alike every time.
        assert!(fine < chosen / 16.0, "{chosen:e} {fine:e}");
    }
}

#[test]
fn a_held_force_jumps_at_its_samples() {
    // One held sample of a force is an impulse: two steps of force, one sample apart.
    let linear = Oscillator { beta: 0.0, gamma: 0.0, ..BENCHMARK };
    let mut u = vec![0.0; 200];
    u[3] = 20.0;
    let y = simulate(&linear, &u, InterSample::Hold, 10, Start::AsIdentified);
    let response = |k: usize| if k == 0 { 0.0 } else { step_response(2.0, 10.0, 1e5, k as f64 / RATE) };
    let exact: Vec<f64> = (0..200usize)
        .map(|k| 20.0 * (response(k.saturating_sub(3)) - response(k.saturating_sub(4))))
        .collect();
    assert!(relative(&y, &exact) < 1e-5, "{:e}", relative(&y, &exact));
}

#[test]
fn a_periodic_start_is_what_repetition_settles_to() {
    let u = multisine(500, 2);
    let steady = simulate(&BENCHMARK, &u, InterSample::BandLimited, 10, Start::PERIODIC);
    // 40 periods of 0.67 s; what a rest leaves decays by more than e^(−2.5 · 0.67) a period.
    let fine = InterSample::BandLimited.upsample(&u, 20, RecordEnds::Periodic).unwrap();
    let drive = Drive::new(&fine.repeat(40), 20.0 * RATE, InterSample::Linear, RecordEnds::Open, 1).unwrap();
    let mut long = vec![0.0; drive.len()];
    BENCHMARK.simulate(&drive, Start::AsIdentified, &mut long).unwrap();
    let last: Vec<f64> = long.iter().skip(39 * fine.len()).step_by(20).copied().collect();
    let error = relative(&steady, &last);
    // Steps half as long, and a force in straight lines between 20 points a sample.
    assert!(error < 3e-4, "{error:e}");
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    let drive = |u: &[f64], ends| Drive::new(u, RATE, InterSample::Linear, ends, 4);
    assert_eq!(drive(&[1.0], RecordEnds::Open), Err(SimulationError::TooShort { samples: 1 }));
    assert!(matches!(
        drive(&[0.0, f64::NAN], RecordEnds::Open),
        Err(SimulationError::Force { index: 1, .. })
    ));
    let rate = Drive::new(&[0.0; 4], 0.0, InterSample::Linear, RecordEnds::Open, 4);
    assert_eq!(rate, Err(SimulationError::BadSampleRate { value: 0.0 }));
    let steps = Drive::new(&[0.0; 4], RATE, InterSample::Linear, RecordEnds::Open, 0);
    assert_eq!(steps, Err(SimulationError::Steps));
    let open = drive(&[1.0; 8], RecordEnds::Open).unwrap();
    let run = |p: Oscillator, start, samples| p.simulate(&open, start, &mut vec![0.0; samples]).unwrap_err();
    assert_eq!(run(BENCHMARK, Start::AsIdentified, 7), SimulationError::Lengths { expected: 8, found: 7 });
    assert_eq!(run(BENCHMARK, Start::PERIODIC, 8), SimulationError::NotPeriodic);
    let other = SimulationError::Period { samples: 8, period_samples: 4 };
    assert_eq!(run(BENCHMARK, Start::settled(4), 8), other);
    let nowhere = Start::from(OscillatorState { y: f64::INFINITY, ..OscillatorState::default() });
    assert!(matches!(run(BENCHMARK, nowhere, 8), SimulationError::State { .. }));
    for (name, bad) in [
        ("mass", Oscillator { mass: 0.0, ..BENCHMARK }),
        ("n", Oscillator { n: 0.5, ..BENCHMARK }),
        ("gamma", Oscillator { gamma: f64::NAN, ..BENCHMARK }),
    ] {
        assert!(matches!(run(bad, Start::AsIdentified, 8),
            SimulationError::Parameter { name: n, .. } if n == name));
    }
    // Hardening of higher order, pushed far: z is infinite after a finite way.
    let hardening = Oscillator { beta: 0.0, gamma: -10.0, n: 2.0, ..BENCHMARK };
    let far = drive(&[1e4; 400], RecordEnds::Open).unwrap();
    let error = hardening.simulate(&far, Start::AsIdentified, &mut [0.0; 400]).unwrap_err();
    assert!(matches!(error, SimulationError::RunsAway { index } if index > 1), "{error}");
    // Bounded by its parameters, but pushed so hard that its hysteresis changes faster than the steps follow.
    let hard = drive(&[1e12, -1e12].repeat(200), RecordEnds::Open).unwrap();
    let bounded = Oscillator { gamma: 0.25 * BENCHMARK.beta, ..BENCHMARK };
    let error = bounded.simulate(&hard, Start::AsIdentified, &mut [0.0; 400]).unwrap_err();
    assert!(matches!(error, SimulationError::TooFast { .. }), "{error}");
    // Without any damping nothing settles.
    let ideal = Oscillator { damping: 0.0, alpha: 0.0, beta: 0.0, gamma: 0.0, ..BENCHMARK };
    let repeats = drive(&multisine(50, 3), RecordEnds::Periodic).unwrap();
    let error = ideal.simulate(&repeats, Start::PERIODIC, &mut [0.0; 50]).unwrap_err();
    assert!(matches!(error, SimulationError::NotSettled { .. }), "{error}");
}
