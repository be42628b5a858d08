use super::*;

/// Reference implementation with the library's functions, one relaxation at a time.
fn oracle(rates: &[f64], states: &mut [f64], [from, slope, bend]: [f64; 3], length_s: f64) {
    for (state, rate) in states.iter_mut().zip(rates) {
        let gain = -(-rate * length_s).exp_m1();
        let x = rate * length_s;
        // x/3 − x²/12 + x³/60 − …
        let series =
            (1..40).fold((0.0, x / 3.0), |(sum, term), k| (sum + term, -term * x / f64::from(k + 3))).0;
        let of_bend = if x < 2.0 { series } else { 1.0 - 2.0 / x + 2.0 * gain / (x * x) };
        *state += gain * (from - *state) + (length_s - gain / rate) * slope;
        *state += bend * length_s * length_s * of_bend;
    }
}

const SLOWEST: f64 = 1e-4;

fn rates() -> Vec<f64> {
    (0..61).map(|k| SLOWEST * 2.0_f64.powf(0.5 * f64::from(k))).collect()
}

/// The second input is the first one, doubled and turned over.
fn inputs([from, slope, bend]: [f64; 3], length_s: f64) -> Parabolas {
    let mut inputs = Parabolas::default();
    inputs.reset(2);
    for (input, factor) in [1.0, -2.0].into_iter().enumerate() {
        inputs.from[0][input] = factor * from;
        inputs.slope[0][input] = factor * slope;
        inputs.bend[0][input] = factor * bend;
        inputs.to[0][input] = factor * (from + (slope + bend * length_s) * length_s);
    }
    inputs.straight = bend == 0.0;
    inputs.begin_at(&inputs.from.clone());
    inputs
}

/// The sums that are the state of one relaxation.
fn read(
    bank: &mut RelaxationBank,
    set: InstructionSet,
    inputs: &Parabolas,
    length_s: f64,
    which: usize,
) -> [f64; 2] {
    let mut weights = BankWeights::default();
    let one: Vec<f64> = (0..rates().len()).map(|k| f64::from(u8::from(k == which))).collect();
    weights.set(&one);
    let mut sums = [[0.0; ABREAST]];
    bank.read(set, inputs, length_s, &mut [weights], &mut sums);
    [sums[0][0], sums[0][1]]
}

#[test]
fn steps_of_any_length_and_every_instruction_set_meet_the_library_functions() {
    let rates = rates();
    let mut same: Option<Vec<f64>> = None;
    for set in InstructionSet::available() {
        let mut bank = RelaxationBank::default();
        bank.reset(SLOWEST, rates.len(), 2);
        let mut states = vec![0.0; rates.len()];
        let mut all = Vec::new();
        for k in 0..3000_i32 {
            let wave = (1.7 * f64::from(k)).sin();
            // Lengths over seven decades, some of them repeated.
            let length_s = 10_f64.powf(3.5 * (0.37 * f64::from(k - k % 3)).sin() - 3.0);
            let bend = f64::from(k % 2) * (0.4 - 0.2 * wave) / (length_s * length_s);
            let line = [wave, (0.1 * wave - 0.3) / length_s, bend];
            let both = inputs(line, length_s);
            bank.begin(&both);
            if k % 10 == 0 {
                let mut ahead = states.clone();
                oracle(&rates, &mut ahead, line, 0.3 * length_s);
                for (which, expected) in ahead.iter().enumerate() {
                    let [found, doubled] = read(&mut bank, set, &both, 0.3 * length_s, which);
                    assert!((found - expected).abs() < 1e-13, "{k} {which}: {found} {expected}");
                    assert_eq!(doubled, -2.0 * found);
                }
            }
            bank.advance(set, &both, length_s);
            oracle(&rates, &mut states, line, length_s);
            let end = inputs([both.to[0][0], 0.0, 0.0], 1.0);
            for (which, (expected, rate)) in states.iter().zip(&rates).enumerate() {
                let [found, doubled] = read(&mut bank, set, &end, 0.0, which);
                assert!((found - expected).abs() < 1e-13, "{k} {rate} {length_s:e}: {found} {expected}");
                assert_eq!(doubled, -2.0 * found);
            }
            all.extend_from_slice(bank.states.as_flattened());
        }
        assert!(same.as_ref().is_none_or(|same| *same == all), "{set:?} rounds differently");
        same = Some(all);
    }
}

#[test]
fn a_long_rest_leaves_no_subnormal_number_behind() {
    let mut bank = RelaxationBank::default();
    bank.reset(SLOWEST, rates().len(), 2);
    let [moving, still] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]].map(|line| inputs(line, 1.0));
    bank.advance(InstructionSet::detected(), &moving, 1.0);
    for _ in 0..5000 {
        bank.advance(InstructionSet::detected(), &still, 1.0);
    }
    assert!(bank.states.as_flattened().iter().all(|state| state.is_normal()), "{:?}", bank.states);
}

#[test]
fn gains_keep_their_digits_however_small() {
    let rates = rates();
    let mut bank = RelaxationBank::default();
    bank.reset(SLOWEST, rates.len(), 1);
    for k in 0..1600_i32 {
        let length_s = 10_f64.powf(-14.0 + 0.01 * f64::from(k));
        bank.step.set(&bank.rates, false, length_s);
        for (k, rate) in rates.iter().enumerate() {
            let (row, lane) = place(k, bank.rates.rows);
            let x = rate * length_s;
            let g = -(-x).exp_m1();
            let found = [bank.step.of_state[row][lane], bank.step.of_slope[row][lane]];
            for (found, expected) in found.into_iter().zip([g, g / x]) {
                assert!((found / expected - 1.0).abs() < 16.0 * f64::EPSILON, "{x:e}: {found:e}");
            }
        }
    }
}
