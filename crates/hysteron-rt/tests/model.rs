//! Promise: a streaming model does what its blocks say, at a rate far above its poles too, in single
//! precision, and for ever.

#![allow(clippy::unwrap_used)] // Helpers outside the test functions; a failure is a failed test.

use hysteron_rt::{
    BoucWen, Compensated, Hysteresis, IncrementMemory, LANES, Linear, Model, ModelError, Operator, PlayBank,
    PolePair, Real, RealPoles, Sections, SectionsMemory,
};
use proptest::prelude::*;

/// Sections with poles from 0.1 rad/s to 5000 rad/s at 10 kHz, a resonance, two taps and a delay of three
/// samples.
struct Block<T> {
    taps: [T; 2],
    real: [RealPoles<T>; 2],
    pairs: [PolePair<T>; 1],
    real_memory: [Compensated<T, LANES>; 2],
    pair_memory: [Compensated<T, 2>; 1],
    delay: [T; 3],
}

const RATES: [f64; 7] = [0.1, 1.0, 10.0, 100.0, 500.0, 2000.0, 5000.0];
const SHARES: [f64; 7] = [0.2, -0.1, 0.15, 0.3, -0.2, 0.25, 0.1];
const RATE_HZ: f64 = 1e4;

/// 1 − e^(p h) of a pole p = −300 + 3000i, and its weight.
fn resonance() -> ([f64; 2], [f64; 2]) {
    let (re, im) = (-300.0 / RATE_HZ, 3000.0 / RATE_HZ);
    let size = libm::exp(re);
    ([1.0 - size * libm::cos(im), -size * libm::sin(im)], [0.35, -0.2])
}

impl<T: Real> Block<T> {
    fn new() -> Self {
        let of = |x: f64| T::of(x);
        let mut real = [RealPoles { gain: [of(0.0); LANES], weight: [of(0.0); LANES] }; 2];
        for (k, (rate, share)) in RATES.iter().zip(SHARES).enumerate() {
            real[k / LANES].gain[k % LANES] = of(-libm::expm1(-rate / RATE_HZ));
            real[k / LANES].weight[k % LANES] = of(share);
        }
        let (gain, weight) = resonance();
        let pairs = [PolePair { gain: gain.map(of), weight: weight.map(of) }];
        Block {
            taps: [of(0.02), of(-0.07)],
            real,
            pairs,
            real_memory: [Compensated::zero(); 2],
            pair_memory: [Compensated::zero(); 1],
            delay: [of(0.0); 3],
        }
    }

    fn rest_gain() -> f64 {
        0.02 - 0.07 + SHARES.iter().sum::<f64>() + 0.35
    }

    fn linear(&mut self) -> Linear<'_, T> {
        let sections = Sections {
            taps: &self.taps,
            real: &self.real,
            pairs: &self.pairs,
            rest_gain: T::of(Self::rest_gain()),
        };
        let memory = SectionsMemory {
            real: &mut self.real_memory,
            pairs: &mut self.pair_memory,
            delay: &mut self.delay,
        };
        Linear::new(sections, memory).unwrap()
    }
}

/// The block's answer to a step of 1 at sample 0, from the formula of each section: 1 − aᵏ behind two taps
/// and three samples.
fn step_response(k: i32) -> f64 {
    let k = k - 3;
    let (gain, weight) = resonance();
    let mut sum = 0.0;
    if k >= 0 {
        sum += 0.02;
    }
    if k >= 1 {
        sum += -0.07;
    }
    // Sections see the step from the second sample on, and have moved once by then.
    let moves = k - 1;
    if moves >= 1 {
        for (rate, share) in RATES.iter().zip(SHARES) {
            sum += share * -libm::expm1(-rate / RATE_HZ * f64::from(moves));
        }
        let (size, angle) =
            ((1.0 - gain[0]).hypot(gain[1]), libm::atan2(-gain[1], 1.0 - gain[0]) * f64::from(moves));
        let (fade, re, im) = (size.powi(moves), libm::cos(angle), libm::sin(angle));
        sum += weight[0] * (1.0 - fade * re) + weight[1] * fade * im;
    }
    sum
}

#[test]
fn the_step_response_is_that_of_its_sections() {
    let mut block = Block::<f64>::new();
    let mut linear = block.linear();
    for k in 0..20_000 {
        let y = linear.step(1.0);
        assert!((y - step_response(k)).abs() < 1e-12, "{k}: {y} {}", step_response(k));
    }
}

/// Every tap and every sample of delay where it belongs: against the sum over all of the past.
#[test]
fn taps_and_delay_are_the_sum_over_the_past() {
    let taps = [0.3, -0.2, 0.17, 0.11, -0.07, 0.05, 0.031, -0.013];
    for count in 1..=taps.len() {
        let real = [RealPoles { gain: [0.1, 0.5, 1.0, 1.5], weight: [0.2, -0.3, 0.4, 0.1] }];
        let (mut states, mut delay) = ([Compensated::zero()], [0.0; 5]);
        let taps = &taps[..count];
        let sections = Sections { taps, real: &real, pairs: &[], rest_gain: 1.0 };
        let memory = SectionsMemory { real: &mut states, pairs: &mut [], delay: &mut delay };
        let mut linear = Linear::new(sections, memory).unwrap();
        let w: Vec<f64> = (0..200).map(|k| f64::from(k * k % 37) - 18.0).collect();
        for (k, &newest) in w.iter().enumerate() {
            let past = |j: usize| k.checked_sub(5 + j).map_or(0.0, |i| w[i]);
            let mut expected: f64 = taps.iter().enumerate().map(|(j, tap)| tap * past(j)).sum();
            for (g, weight) in real[0].gain.iter().zip(real[0].weight) {
                expected +=
                    (0..k).map(|j| weight * g * (1.0 - g).powi(j as i32) * past(count + j)).sum::<f64>();
            }
            let y = linear.step(newest);
            assert!((y - expected).abs() < 1e-12, "{count} taps, {k}: {y} {expected}");
        }
    }
}

/// Largest difference of the block in f32 to f64 over `samples` of a signal that single precision holds
/// exactly.
fn single_precision_error(samples: usize) -> f64 {
    let (mut double, mut single) = (Block::<f64>::new(), Block::<f32>::new());
    let (mut double, mut single) = (double.linear(), single.linear());
    let mut worst = 0.0_f64;
    for k in 0..samples {
        // Steps of ten seconds with a triangle on top, in 1/4096.
        let slow = if (k / 100_000) % 2 == 0 { 1.0 } else { 0.25 };
        let fast = f64::from((k % 512) as i32 - 256).abs() / 4096.0;
        let w = slow + fast;
        let difference = f64::from(single.step(w as f32)) - double.step(w);
        worst = worst.max(difference.abs());
    }
    worst
}

/// Single precision: 16 units of rounding, ε = 2⁻²³, of Σ |weights| of the range. (A plain recursion is 1e-3
/// to 1e-2 wrong.)
fn bound() -> f64 {
    let weights = 0.02 + 0.07 + SHARES.iter().map(|s| s.abs()).sum::<f64>() + 0.35_f64.hypot(0.2);
    16.0 * f64::from(f32::EPSILON) * weights * 1.0625
}

#[test]
fn single_precision_keeps_its_bound_where_a_plain_recursion_loses_three_digits() {
    let worst = single_precision_error(600_000);
    println!("single precision, poles from 0.1 rad/s at 10 kHz: {worst:.2e}, bound {:.2e}", bound());
    assert!(worst <= bound(), "{worst:e}");
    // The same slow pole as x ← a x + b w, after thirty of its time constants.
    let (a, b) = (libm::exp(-0.1 / RATE_HZ) as f32, -libm::expm1(-0.1 / RATE_HZ) as f32);
    let x = (0..3_000_000).fold(0.0_f32, |x, _| a * x + b);
    println!("plain recursion: {x} for 1");
    assert!((x - 1.0).abs() > 1e-3, "{x}");
}

#[test]
#[ignore = "1e8 samples: cargo test -p hysteron-rt --release --test model -- --ignored --nocapture"]
fn single_precision_does_not_drift_in_a_hundred_million_samples() {
    let worst = single_precision_error(100_000_000);
    println!("single precision over 1e8 samples: {worst:.2e}, bound {:.2e}", bound());
    assert!(worst <= bound(), "{worst:e}");
}

#[test]
fn silence_leaves_no_subnormal_number_behind() {
    fn run<T: Real>() {
        let mut block = Block::<T>::new();
        let mut linear = block.linear();
        for k in 0..400_000 {
            linear.step(T::of(if k < 1000 { 1.0 } else { 0.0 }));
        }
        let memory = linear.memory();
        assert!(!memory.real.iter().any(Compensated::has_subnormal), "{:?}", memory.real);
        assert!(!memory.pairs.iter().any(Compensated::has_subnormal), "{:?}", memory.pairs);
    }
    run::<f32>();
    run::<f64>();
}

#[test]
fn a_rest_is_a_rest_and_a_start_has_no_jump() {
    let mut block = Block::<f64>::new();
    let operators = [BoucWen::new(0.5, 0.11, 0.02, 1.0).unwrap()];
    let mut memory = [IncrementMemory::new(0.0)];
    let operator = Operator::States { laws: &operators, memory: &mut memory };
    let hysteresis = Hysteresis::new(&[2.0, 0.003], operator).unwrap();
    let mut model = Model::new(hysteresis, block.linear(), 1.5).unwrap();
    for u in [3.0, 8.0, 2.0, -4.0] {
        model.step(u).unwrap();
    }
    let at_rest = model.rest_at(6.0).unwrap();
    let gain = Block::<f64>::rest_gain();
    assert!((at_rest - (1.5 + gain * (12.0 + 0.003 * 36.0))).abs() < 1e-12);
    for _ in 0..100 {
        assert!((model.step(6.0).unwrap() - at_rest).abs() < 1e-12);
    }
    model.start_at(2.0, 17.25).unwrap();
    assert!((model.step(2.0).unwrap() - 17.25).abs() < 1e-12);
    let before = model.step(2.5).unwrap();
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(model.step(bad), Err(ModelError::NotFinite));
        assert!(matches!(model.start_at(1.0, bad), Err(ModelError::Start { .. })));
        assert_eq!(model.rest_at(bad), Err(ModelError::NotFinite));
    }
    // Behind five samples of delay and taps nothing has come through yet but the first voltage.
    assert!((model.step(2.5).unwrap() - before).abs() < 1e-12);
}

/// With means the offset is added, not multiplied: at the end of a run of equal voltages the displacement is that at
/// rest.
#[test]
fn means_leave_what_is_at_rest() {
    let mut block = Block::<f64>::new();
    let hysteresis = Hysteresis::new(&[0.8], Operator::None).unwrap();
    let mut model = Model::new(hysteresis, block.linear(), 3.5).unwrap().with_means().unwrap();
    let rest = model.rest_at(2.0).unwrap();
    assert!((rest - (3.5 + 1.6 * Block::<f64>::rest_gain())).abs() < 1e-12, "{rest}");
    for _ in 0..10 {
        assert!((model.step(2.0).unwrap() - rest).abs() < 1e-12);
    }
}

#[test]
fn half_way_is_where_two_half_moves_meet() {
    let operators = [1.0, 2.0].map(|n| BoucWen::new(0.5, 0.11, 0.02, n).unwrap());
    let (mut memory, mut oracle_memory) = ([IncrementMemory::new(0.0); 2], [IncrementMemory::new(0.0); 2]);
    let bouc_wen = |memory| Operator::States { laws: &operators, memory };
    let (thresholds, weights) = ([0.5, 1.5], [0.7, 0.2]);
    let bank = PlayBank::new(&thresholds, &weights).unwrap();
    let (mut states, mut oracle_states) = ([0.0; 2], [0.0; 2]);
    let pairs = [
        (bouc_wen(&mut memory), bouc_wen(&mut oracle_memory)),
        (Operator::Plays { bank, states: &mut states }, Operator::Plays { bank, states: &mut oracle_states }),
        (Operator::None, Operator::None),
    ];
    for (operator, oracle) in pairs {
        let mut whole = Hysteresis::new(&[1.0, 0.01], operator).unwrap();
        let mut halves = Hysteresis::new(&[1.0, 0.01], oracle).unwrap();
        for u in [0.3, 0.6, 0.1, -0.2, -0.15, 0.0] {
            let (middle, end) = whole.step_with_middle(u).unwrap();
            let expected = halves.step(0.5 * (halves.voltage() + u)).unwrap();
            assert!((middle - expected).abs() < 1e-13, "{middle} {expected}");
            assert!((end - halves.step(u).unwrap()).abs() < 1e-13);
        }
        assert_eq!(whole.step_with_middle(f64::NAN), Err(ModelError::NotFinite));
    }
}

#[test]
fn a_move_out_of_range_leaves_the_operators_where_they_were() {
    let operators = [1.0, 2.0, 1.5].map(|n| BoucWen::new(0.5, 0.11, 0.02, n).unwrap());
    let (mut memory, mut untouched) = ([IncrementMemory::new(0.0); 3], [IncrementMemory::new(0.0); 3]);
    let mut tried =
        Hysteresis::new(&[1.0], Operator::States { laws: &operators, memory: &mut memory }).unwrap();
    let operator = Operator::States { laws: &operators, memory: &mut untouched };
    let mut oracle = Hysteresis::new(&[1.0], operator).unwrap();
    for u in [0.3, 1.1, 0.4, 0.9] {
        assert_eq!(tried.step(u), oracle.step(u));
        for far in [1e200, -1e200] {
            assert_eq!(tried.step(far), Err(ModelError::Overflow));
        }
        assert_eq!(tried.voltage(), u);
    }
    assert_eq!(memory, untouched);
}

/// A reading out of all reason is forgotten at the next start.
#[test]
fn a_start_does_not_depend_on_the_starts_before() {
    let sections = || Sections { taps: &[1.0], real: &[], pairs: &[], rest_gain: 1.0 };
    let memory = || SectionsMemory { real: &mut [], pairs: &mut [], delay: &mut [] };
    let hysteresis = Hysteresis::new(&[2.0], Operator::None).unwrap();
    let mut model = Model::new(hysteresis, Linear::new(sections(), memory()).unwrap(), 5.0).unwrap();
    for wild in [1e30, -1e30, 1.7e308, -1.7e308] {
        let _ = model.start_at(1.0, wild);
        model.start_at(1.0, 17.25).unwrap();
        assert_eq!(model.step(1.0), Ok(17.25));
    }
}

#[test]
fn memory_that_does_not_fit_is_refused() {
    let block = Block::<f64>::new();
    let sections = Sections { taps: &block.taps, real: &block.real, pairs: &[], rest_gain: 1.0 };
    let none = || SectionsMemory { real: &mut [], pairs: &mut [], delay: &mut [] };
    assert_eq!(Linear::new(sections, none()).err(), Some(ModelError::Memory { expected: 2, found: 0 }));
    let without = Sections { taps: &[], real: &[], ..sections };
    assert_eq!(Linear::new(without, none()).err(), Some(ModelError::Taps { found: 0 }));
    let infinite = Sections { taps: &[f64::NAN], real: &[], ..sections };
    assert_eq!(Linear::new(infinite, none()).err(), Some(ModelError::Coefficient));
    let operators = [BoucWen::new(0.5, 0.11, 0.02, 1.0).unwrap()];
    let operator = Operator::States { laws: &operators, memory: &mut [] };
    assert!(matches!(Hysteresis::new(&[1.0], operator), Err(ModelError::Memory { expected: 1, found: 0 })));
}

#[test]
fn plays_go_as_their_bank_does() {
    let (thresholds, weights) = ([0.5, 1.5], [0.7, 0.2]);
    let bank = PlayBank::new(&thresholds, &weights).unwrap();
    let mut states = [0.0; 2];
    let mut hysteresis = Hysteresis::new(&[1.0], Operator::Plays { bank, states: &mut states }).unwrap();
    let mut oracle = [0.0; 2];
    for u in [0.3, 2.0, 1.1, -3.0, 0.4] {
        assert_eq!(hysteresis.step(u), Ok(u + bank.step(&mut oracle, u).unwrap()));
    }
    // Virgin at 4 V every play stands there.
    assert_eq!(hysteresis.rest_at(4.0), 4.0 + 0.9 * 4.0);
}

proptest! {
    /// z + increment is the exact move for n = 1 and 2, through 0 and beyond saturation.
    #[test]
    fn increments_are_exact_where_there_is_a_closed_form(
        n in prop::sample::select(vec![1.0, 2.0]),
        alpha in -2.0..2.0_f64, beta in 0.05..1.0_f64, share in -0.9..0.9_f64,
        z in -3.0..3.0_f64, du in -8.0..8.0_f64,
    ) {
        let operator = BoucWen::new(alpha, beta, share * beta, n).unwrap();
        let exact = operator.advance(z, du).unwrap();
        let got = z + operator.increment(z, du);
        prop_assert!((got - exact).abs() < 1e-13 * (1.0 + z.abs() + exact.abs()), "{got} {exact}");
    }
}

/// For other n: the stated error of a move, and no move leaves the saturation.
#[test]
fn increments_of_other_exponents_keep_their_stated_error() {
    // Saturation 1 at 1 V: α = 1, β + γ = 1.
    let worst = |betas: &[f64], move_v: f64, places: &dyn Fn(f64) -> bool| {
        let mut worst = 0.0_f64;
        for (n, beta) in
            [1.2, 1.5, 1.8, 2.5, 3.0].into_iter().flat_map(|n| betas.iter().map(move |b| (n, *b)))
        {
            let operator = BoucWen::new(1.0, beta, 1.0 - beta, n).unwrap();
            for k in -200..=200_i32 {
                let place = f64::from(k) / 200.0;
                for du in [move_v, -move_v].into_iter().filter(|_| places(place)) {
                    let exact = operator.advance(place, du).unwrap();
                    worst = worst.max((place + operator.increment(place, du) - exact).abs());
                }
            }
        }
        worst
    };
    let long = [0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0];
    let moves = [0.003, 0.03].into_iter().chain(long);
    for (name, betas, away_stated, anywhere_stated) in [
        ("gamma >= 0", &[0.5, 2.0 / 3.0, 1.0][..], [1e-10, 1e-6, 1e-3], [2e-7, 2e-5, 1.2e-3]),
        ("gamma < 0", &[1.5, 3.0], [1e-8, 5e-5, 1e-3], [2e-7, 5e-5, 4e-3]),
    ] {
        for (k, move_v) in moves.clone().enumerate() {
            let k = k.min(2);
            // Away from z = 0 all the way.
            let away = worst(betas, move_v, &|z| z.abs() > 0.1 + move_v);
            let anywhere = worst(betas, move_v, &|_| true);
            println!("{name}, move {move_v}: {away:.1e} away from z = 0, {anywhere:.1e} anywhere");
            assert!(
                away < away_stated[k] && anywhere < anywhere_stated[k],
                "{name} {move_v}: {away:e} {anywhere:e}"
            );
        }
    }
    for (n, beta) in [(1.2, 0.75), (1.5, 0.75), (3.0, 0.75), (1.2, 3.0), (3.0, 3.0)] {
        let operator = BoucWen::new(1.0, beta, 1.0 - beta, n).unwrap();
        for place in [-1.0, -0.3, 0.0, 0.9] {
            for du in [-1e3, -60.0, -30.0, 30.0, 60.0, 1e3] {
                let end = place + operator.increment(place, du);
                assert!((end - f64::signum(du)).abs() < 1e-9, "n {n}, {du} from {place}: {end}");
            }
        }
    }
}

/// Single precision follows double along small steps as along large ones.
#[test]
fn hysteresis_in_single_precision_follows_double_at_any_rate() {
    for n in [1.0, 1.5, 2.0] {
        let (alpha, beta, gamma) = (0.5, 0.25, 0.125);
        let operators = [BoucWen::new(alpha, beta, gamma, n).unwrap()];
        let operators32 = [BoucWen::new(alpha as f32, beta as f32, gamma as f32, n as f32).unwrap()];
        let (mut memory, mut memory32) = ([IncrementMemory::new(0.0)], [IncrementMemory::new(0.0)]);
        let operator = Operator::States { laws: &operators, memory: &mut memory };
        let operator32 = Operator::States { laws: &operators32, memory: &mut memory32 };
        let mut double = Hysteresis::new(&[], operator).unwrap();
        let mut single = Hysteresis::new(&[], operator32).unwrap();
        // 2¹⁶ samples a ramp of 4 V: moves of 2⁻¹⁴ V, of which 2⁻¹⁶ of z is left.
        let mut worst = 0.0_f64;
        for k in 0..(5 << 16) {
            let ramp = f64::from(k & 0xffff) / f64::from(1 << 14);
            let u = if (k >> 16) & 1 == 0 { ramp } else { 4.0 - ramp };
            let difference = f64::from(single.step(u as f32).unwrap()) - double.step(u).unwrap();
            worst = worst.max(difference.abs());
        }
        println!("n {n}: single precision {worst:.1e}");
        assert!(worst < 8.0 * f64::from(f32::EPSILON), "n {n}: {worst:e}");
    }
}
