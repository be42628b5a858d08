//! Derivatives against dual numbers, which follow the chain rule through the same scheme, and against
//! differences.

use hysteron_model::Start;
use hysteron_model::hysteresis::{InterSample, RecordEnds};
use hysteron_model::oscillator::{Drive, Oscillator, OscillatorState, PARTIALS, Response};
use hysteron_rt::{Dual, Scalar};

use crate::oracles::{BENCHMARK, multisine, relative, runge_kutta};

const RATE: f64 = 750.0;
const STEPS: usize = 8;

/// Oscillators and states to start from.
fn cases() -> Vec<(Oscillator, OscillatorState)> {
    let shapes =
        [(800.0, -1100.0, 1.0), (500.0, 300.0, 1.0), (14.0, 6.0, 2.0), (80.0, -30.0, 1.5), (20.0, 9.0, 1.8)];
    let states = [(0.0, 0.0, 0.0), (1e-3, -0.2, 30.0), (0.0, 0.1, -20.0)];
    let all = shapes.iter().flat_map(|&(beta, gamma, n)| {
        states.map(|(y, velocity, z)| {
            (Oscillator { beta, gamma, n, ..BENCHMARK }, OscillatorState { y, velocity, z })
        })
    });
    all.collect()
}

fn respond(p: &Oscillator, drive: &Drive, start: Start<OscillatorState>) -> Response {
    let mut out = Response::default();
    p.simulate_with_sensitivities(drive, start, &mut out).unwrap();
    out
}

#[test]
fn they_are_those_of_the_scheme() {
    let u = multisine(400, 4);
    let force = InterSample::BandLimited.upsample(&u, 2 * STEPS, RecordEnds::Open).unwrap();
    let drive = Drive::new(&u, RATE, InterSample::BandLimited, RecordEnds::Open, STEPS).unwrap();
    for (p, state) in cases() {
        let mut numbers = [Dual::<f64, PARTIALS>::constant(0.0); PARTIALS];
        let values = p.values().into_iter().chain([state.y, state.velocity, state.z]);
        for (j, (number, value)) in numbers.iter_mut().zip(values).enumerate() {
            *number = Dual::<f64, PARTIALS>::variable(value, j);
        }
        let oracle = runge_kutta(numbers, &force, STEPS, 1.0 / (RATE * STEPS as f64));
        let found = respond(&p, &drive, Start::from(state));
        let value: Vec<f64> = oracle.iter().map(|d| d.value).collect();
        assert!(relative(&found.y, &value) < 1e-12, "{p:?} {state:?}");
        for j in 0..PARTIALS {
            let column: Vec<f64> = oracle.iter().map(|d| d.partials[j]).collect();
            let error = relative(&found.partials[j], &column);
            assert!(error < 1e-10, "{p:?} {state:?}, number {j}: {error:e}");
        }
    }
}

#[test]
fn the_displacement_is_that_of_the_plain_simulation_to_the_last_bit() {
    let u = multisine(300, 5);
    for ends in [RecordEnds::Open, RecordEnds::Periodic] {
        let drive = Drive::new(&u, RATE, InterSample::BandLimited, ends, STEPS).unwrap();
        for (p, state) in cases() {
            let start = if ends == RecordEnds::Periodic { Start::PERIODIC } else { Start::from(state) };
            let mut y = vec![0.0; u.len()];
            p.simulate(&drive, start, &mut y).unwrap();
            assert_eq!(respond(&p, &drive, start).y, y, "{p:?}");
        }
    }
}

/// (f(x + h) − f(x − h))/2h with respect to parameter j, h a share of it.
fn difference(
    p: &Oscillator,
    drive: &Drive,
    start: Start<OscillatorState>,
    j: usize,
    share: f64,
) -> Vec<f64> {
    let side = |sign: f64| {
        let mut values = p.values();
        values[j] *= 1.0 + sign * share;
        let mut y = vec![0.0; drive.len()];
        Oscillator::from_values(values).simulate(drive, start, &mut y).unwrap();
        y
    };
    let width = 2.0 * share * p.values()[j];
    side(1.0).iter().zip(side(-1.0)).map(|(up, down)| (up - down) / width).collect()
}

#[test]
fn differences_agree_from_rest_and_in_the_steady_state() {
    let u = multisine(500, 6);
    for (start, ends) in [(Start::AsIdentified, RecordEnds::Open), (Start::PERIODIC, RecordEnds::Periodic)] {
        let drive = Drive::new(&u, RATE, InterSample::BandLimited, ends, STEPS).unwrap();
        for (p, _) in cases().into_iter().step_by(3) {
            let found = respond(&p, &drive, start);
            for (j, name) in Oscillator::NAMES.iter().enumerate() {
                // n = 1 is the end of its range.
                if *name == "n" && p.n == 1.0 {
                    continue;
                }
                let error = relative(&difference(&p, &drive, start, j, 1e-6), &found.partials[j]);
                // A difference crosses corners of the scheme; the steady state is one to 1e-10 over a step of
                // 1e-6.
                assert!(error < 2e-4, "{name} of {p:?} from {start:?}: {error:e}");
            }
        }
    }
}

#[test]
fn a_steady_state_does_not_depend_on_its_start() {
    let u = multisine(300, 7);
    let drive = Drive::new(&u, RATE, InterSample::BandLimited, RecordEnds::Periodic, STEPS).unwrap();
    let found = respond(&BENCHMARK, &drive, Start::PERIODIC);
    assert!(found.partials[7..].iter().flatten().all(|&p| p == 0.0));
}
