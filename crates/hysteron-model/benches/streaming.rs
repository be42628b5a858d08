//! A realised model sample by sample, and a short memory beside it: one line of JSON per measurement.
//!
//! `cargo bench -p hysteron-model --bench streaming`. Nanoseconds a sample along a 1–100 Hz sweep at 10 kHz,
//! one thread, the least of many turns that all contestants take one after the other. Every model is article
//! Eq. 13 to 1e-5 of the range with a delay of 3.37 samples.
//!
//! - `n = 1`, `n = 2`, `n = 1.5`: Bouc–Wen, single and double precision; `means`: moves looked at half-way
//!   (scheme `band-limited`);
//! - `inverse`: the voltage for a reference known so many samples ahead;
//! - `plays`: twelve; `dynamics`: no hysteresis; `static`: no dynamics;
//! - `short memory`: Eq. 13 alone by Grünwald–Letnikov over the last 1000 samples, and its error against all
//!   of them.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts};
use hysteron_model::dynamics::{Dynamics, InterSample, Scheme, TransferFunction};
use hysteron_model::fractional::{grunwald_letnikov_weights, simulate_recursion};
use hysteron_model::hammerstein::Model;
use hysteron_model::hysteresis::{BoucWen, Hysteresis, PrandtlIshlinskii};
use hysteron_model::realise::{RealiseOptions, RuntimeParts, realise, sweep};
use hysteron_rt::Real;

/// One pass over the drive; its seconds.
type Pass = Box<dyn FnMut() -> f64>;

const FS: f64 = 10_000.0;
const SAMPLES: usize = 20_000;
const MEMORY: usize = 1000;

fn bouc_wen(n: f64) -> Hysteresis {
    Hysteresis::from(BoucWen::new(vec![2.0, 0.01, 1e-4], 0.5, 0.1, 0.02, n).unwrap())
}

fn model(hysteresis: Hysteresis, scheme: Scheme) -> Model {
    Model {
        hysteresis,
        dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
        offset: 0.0,
        delay_s: 3.37 / FS,
        scheme,
        inter_sample: InterSample::Linear,
        sample_rate_hz: Some(FS),
    }
}

/// One pass of the model over the drive, in a number type.
fn contestant<T: Real>(model: &Model, drive: &[f64]) -> Pass {
    let realised = realise(model, FS, &RealiseOptions::default()).unwrap();
    let mut parts = RuntimeParts::<T>::new(&realised).unwrap();
    let drive: Vec<T> = drive.iter().map(|&u| T::of(u)).collect();
    let mut out = vec![T::of(0.0); drive.len()];
    Box::new(move || {
        let mut model = parts.model().unwrap();
        let start = Instant::now();
        for (y, &u) in out.iter_mut().zip(&drive) {
            *y = model.step(u).unwrap();
        }
        black_box(&out);
        start.elapsed().as_secs_f64()
    })
}

/// One pass of the model's inverse over what the model does with the drive.
fn inverse<T: Real>(model: &Model, preview: usize, drive: &[f64]) -> Pass {
    let options = CompensatorOptions { preview: Some(preview), ..CompensatorOptions::default() };
    let law = Compensation::new(model, FS, &options).unwrap();
    let mut parts = CompensatorParts::<T>::new(&law, [-1.0, 11.0], f64::INFINITY).unwrap();
    let realised = realise(model, FS, &RealiseOptions::default()).unwrap();
    let mut forward = RuntimeParts::<f64>::new(&realised).unwrap();
    let mut forward = forward.model().unwrap();
    let reference: Vec<T> = drive.iter().map(|&u| T::of(forward.step(u).unwrap())).collect();
    let mut out = vec![T::of(0.0); reference.len()];
    Box::new(move || {
        let mut compensator = parts.compensator().unwrap();
        let start = Instant::now();
        for (u, &r) in out.iter_mut().zip(&reference) {
            *u = compensator.step(r).voltage;
        }
        black_box(&out);
        start.elapsed().as_secs_f64()
    })
}

/// x_k = (b v_k − Σ_{j=1…1000} W_j x_{k−j})/W₀, W_j = Σᵢ aᵢ h^−αᵢ w_j of the order αᵢ: both kernels merged,
/// the past kept twice so that the sum is one run.
struct ShortMemory {
    kernel: Vec<f64>,
    gain: f64,
    past: Vec<f64>,
    at: usize,
}

impl ShortMemory {
    fn new(g: &TransferFunction) -> Self {
        let mut kernel = vec![0.0; MEMORY + 1];
        for term in &g.denominator {
            let scale = term.coefficient * FS.powf(term.order);
            let weights = grunwald_letnikov_weights(term.order, MEMORY + 1);
            kernel.iter_mut().zip(weights).for_each(|(k, w)| *k += scale * w);
        }
        let first = kernel.remove(0);
        // Oldest first, as the past lies.
        kernel.reverse();
        kernel.iter_mut().for_each(|k| *k /= first);
        Self { kernel, gain: g.numerator[0].coefficient / first, past: vec![0.0; 2 * MEMORY], at: 0 }
    }

    fn step(&mut self, v: f64) -> f64 {
        let window = &self.past[self.at..self.at + MEMORY];
        let x = self.gain * v - hysteron_numeric::dot(&self.kernel, window);
        self.past[self.at] = x;
        self.past[self.at + MEMORY] = x;
        self.at = (self.at + 1) % MEMORY;
        x
    }
}

fn short_memory(drive: &[f64]) -> Pass {
    let (drive, mut out) = (drive.to_vec(), vec![0.0; drive.len()]);
    Box::new(move || {
        let mut memory = ShortMemory::new(&TransferFunction::article_eq13());
        let start = Instant::now();
        for (y, &u) in out.iter_mut().zip(&drive) {
            *y = memory.step(u);
        }
        black_box(&out);
        start.elapsed().as_secs_f64()
    })
}

/// Largest difference of the short memory to the whole, over the largest output.
fn short_memory_error(drive: &[f64]) -> f64 {
    let g = TransferFunction::article_eq13();
    let exact =
        simulate_recursion(&g.numerator, &g.denominator, drive, FS, Scheme::GrunwaldLetnikov).unwrap();
    let mut memory = ShortMemory::new(&g);
    let largest = exact.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
    let error = drive.iter().zip(&exact).fold(0.0_f64, |m, (&u, y)| m.max((memory.step(u) - y).abs()));
    error / largest
}

fn main() {
    let full = std::env::args().any(|argument| argument == "--bench");
    let (samples, turns) = if full { (SAMPLES, 60) } else { (3_000, 1) };
    let drive = sweep((0.0, 10.0), (1.0, 100.0), FS, samples);
    let plays =
        PrandtlIshlinskii::new(vec![1.0], (1..=12).map(|k| 0.4 * f64::from(k)).collect(), vec![0.1; 12]);
    let nothing = Hysteresis::without_memory(vec![1.0]).unwrap();
    let of_n = |n, scheme| model(bouc_wen(n), scheme);
    let double = |model: &Model| contestant::<f64>(model, &drive);
    let single = |model: &Model| contestant::<f32>(model, &drive);
    let tustin = Scheme::Tustin;
    let still = Model { dynamics: Dynamics::None, delay_s: 0.0, ..of_n(1.0, tustin) };
    let plays = model(Hysteresis::from(plays.unwrap()), tustin);
    let mut contestants: Vec<(&str, Pass)> = vec![
        ("n = 1, f64", double(&of_n(1.0, tustin))),
        ("n = 1, f32", single(&of_n(1.0, tustin))),
        ("n = 1, means, f64", double(&of_n(1.0, Scheme::BandLimited))),
        ("n = 2, f64", double(&of_n(2.0, tustin))),
        ("n = 1.5, f64", double(&of_n(1.5, tustin))),
        ("n = 1.5, f32", single(&of_n(1.5, tustin))),
        ("12 plays, f64", double(&plays)),
        ("n = 1, inverse, 10 ahead, f64", inverse::<f64>(&of_n(1.0, tustin), 10, &drive)),
        ("n = 1, inverse, 10 ahead, f32", inverse::<f32>(&of_n(1.0, tustin), 10, &drive)),
        ("12 plays, inverse, 10 ahead, f64", inverse::<f64>(&plays, 10, &drive)),
        ("dynamics alone, f64", double(&model(nothing, tustin))),
        ("n = 1, static, f64", double(&still)),
        ("short memory of 1000, dynamics alone, f64", short_memory(&drive)),
    ];
    let mut least = vec![f64::INFINITY; contestants.len()];
    for _ in 0..turns {
        for ((_, run), least) in contestants.iter_mut().zip(&mut least) {
            *least = least.min(run());
        }
    }
    for ((what, _), seconds) in contestants.iter().zip(least) {
        let ns = seconds * 1e9 / samples as f64;
        println!("{{\"bench\":\"streaming\",\"what\":\"{what}\",\"ns_per_sample\":{ns:.2}}}");
    }
    println!("{{\"bench\":\"streaming\",\"short_memory_error\":{:.2e}}}", short_memory_error(&drive));
}
