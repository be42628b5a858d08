//! Simulation of article Eq. 13 on a 1–100 Hz sweep at 10 kHz: one line of JSON per measurement.
//!
//! `cargo bench -p hysteron-model --bench fractional_simulation`. Times are minima over repetitions, one
//! thread, plan and workspace reused. Run without `--bench` it does the smallest case once.
//!
//! - `simulate`: forward transform of the input, G, inverse transform;
//! - `candidate`: input transformed before, as a population search does;
//! - `response`, `linearise`: the frequency response of a fractional resonance with delay, and with its
//!   derivatives applied to three inputs, as a joint fit does; of drives that are band-limited, straight and
//!   held between their samples;
//! - `fft`: the inverse real FFT of the same length alone;
//! - `causal`, `recursion`: the O(N log² N) and O(N²) recursions, where they take a bearable time.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use hysteron_model::Start;
use std::hint::black_box;
use std::time::Instant;

use hysteron_model::dynamics::{
    Creep, DynamicForm, InterSample, Linearised, Modes, Sampling, Scheme, SimulationPlan, TransferFunction,
    stability,
};
use hysteron_model::fractional::{simulate_causal, simulate_recursion};
use hysteron_numeric::fft::RealFft;
use hysteron_numeric::{InstructionSet, accumulate_power};

const FS: f64 = 10_000.0;

fn sweep(samples: usize) -> Vec<f64> {
    let duration = samples as f64 / FS;
    let phase = |t: f64| std::f64::consts::TAU * (t + 49.5 * t * t / duration);
    (0..samples).map(|k| phase(k as f64 / FS).sin()).collect()
}

/// Shortest of `repetitions` runs \[ms\].
fn shortest_ms(repetitions: usize, mut work: impl FnMut()) -> f64 {
    let run = |_| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..repetitions).map(run).fold(f64::INFINITY, f64::min)
}

fn report(what: &str, samples: usize, transform: usize, ms: f64) {
    let ns = ms * 1e6 / samples as f64;
    println!(
        "{{\"bench\":\"fractional_simulation\",\"what\":\"{what}\",\"samples\":{samples},\
         \"transform\":{transform},\"ms\":{ms:.5},\"ns_per_sample\":{ns:.3}}}"
    );
}

fn simulation(samples: usize, repetitions: usize) {
    let tf = TransferFunction::article_eq13();
    let input = sweep(samples);
    let plan = SimulationPlan::new(samples, FS, Scheme::Tustin, Start::AsIdentified).unwrap();
    let mut workspace = plan.workspace();
    let mut output = vec![0.0; samples];
    let length = plan.transform_length();
    let ms = shortest_ms(repetitions, || {
        plan.simulate(black_box(&tf), &input, &mut workspace, &mut output).unwrap();
    });
    report("simulate", samples, length, ms);
    let spectrum = plan.transform(&input).unwrap();
    let ms = shortest_ms(repetitions, || {
        plan.simulate_spectrum(black_box(&tf), &spectrum, &mut workspace, &mut output).unwrap();
    });
    report("candidate", samples, length, ms);
    let fft = RealFft::new(length);
    let mut bins = fft.inverse.make_input_vec();
    let mut time = fft.inverse.make_output_vec();
    let mut scratch = fft.inverse.make_scratch_vec();
    let ms = shortest_ms(repetitions, || {
        fft.inverse.process_with_scratch(black_box(&mut bins), &mut time, &mut scratch).unwrap();
    });
    report("fft", samples, length, ms);
}

fn responses(samples: usize, repetitions: usize) {
    let form = DynamicForm { modes: Modes::Fractional, creep: Creep::None };
    let p = [373.0, 0.62, 1.94, 1.05];
    let tf = form.transfer_function(&p).unwrap();
    let mut linearised = Linearised::new();
    form.linearise(&p, &mut linearised).unwrap();
    let plan = SimulationPlan::new(samples, FS, Scheme::BandLimited, Start::ZERO).unwrap();
    let length = plan.transform_length();
    let input = plan.transform(&sweep(samples)).unwrap();
    let (mut workspace, mut output) = (plan.workspace(), vec![0.0; samples]);
    let mut response = plan.empty_response(p.len());
    for rule in [InterSample::BandLimited, InterSample::Linear, InterSample::Hold] {
        let sampling = Sampling { delay: InterSample::BandLimited, reconstruction: rule };
        let ms = shortest_ms(repetitions, || {
            plan.response(black_box(&tf), 1.3 / FS, sampling, &mut response).unwrap();
        });
        report(&format!("response {rule}"), samples, length, ms);
        let ms = shortest_ms(repetitions, || {
            plan.response(black_box(&tf), 1.3 / FS, sampling, &mut response).unwrap();
            for _ in 0..3 {
                plan.apply(&response, &input, &mut workspace, &mut output).unwrap();
            }
        });
        report(&format!("response and three inputs {rule}"), samples, length, ms);
        let ms = shortest_ms(repetitions, || {
            plan.response_with_tangents(black_box(&linearised), 1.3 / FS, sampling, &mut response).unwrap();
            for _ in 0..3 {
                plan.apply(&response, &input, &mut workspace, &mut output).unwrap();
                for which in 0..=p.len() {
                    plan.apply_tangent(&response, which, &input, &mut workspace, &mut output).unwrap();
                }
            }
        });
        report(&format!("linearise {rule}"), samples, length, ms);
    }
}

fn oracles(samples: usize, plain: bool) {
    let tf = TransferFunction::article_eq13();
    let input = sweep(samples);
    let run = |simulate: fn(&_, &_, &_, _, _) -> _| -> Result<Vec<f64>, _> {
        simulate(&tf.numerator[..], &tf.denominator[..], &input[..], FS, Scheme::GrunwaldLetnikov)
    };
    let ms = shortest_ms(3, || drop(black_box(run(simulate_causal).unwrap())));
    report("causal", samples, samples, ms);
    if plain {
        let ms = shortest_ms(1, || drop(black_box(run(simulate_recursion).unwrap())));
        report("recursion", samples, samples, ms);
    }
}

fn kernels(count: usize) {
    let log_abs: Vec<f64> = (0..count).map(|k| -5.0 + 15.0 * k as f64 / count as f64).collect();
    let angle: Vec<f64> = (0..count).map(|k| 1.5 * k as f64 / count as f64).collect();
    let (mut re, mut im) = (vec![0.0; count], vec![0.0; count]);
    for set in InstructionSet::available() {
        let ms = shortest_ms(50, || accumulate_power(set, 1e-9, 2.0384, &log_abs, &angle, &mut re, &mut im));
        report(&format!("power {set:?}"), count, count, ms);
    }
}

fn main() {
    if !std::env::args().any(|argument| argument == "--bench") {
        simulation(1_000, 1);
        return;
    }
    for (samples, repetitions) in
        [(1_000, 500), (10_000, 200), (100_000, 60), (1_000_000, 8), (10_000_000, 2)]
    {
        simulation(samples, repetitions);
    }
    for (samples, repetitions) in [(1_000, 500), (10_000, 200), (100_000, 30)] {
        responses(samples, repetitions);
    }
    let tf = TransferFunction::article_eq13();
    report(
        "stability verdict",
        1,
        1,
        shortest_ms(1000, || {
            black_box(stability(black_box(&tf)));
        }),
    );
    oracles(10_000, true);
    oracles(100_000, true);
    kernels(131_072);
}
