//! Reference for the fast passes: the sum of relaxations and resonances one step and one term at a time, with
//! the functions of the library.

use super::{Readout, StampedPlan, StampedResponse};
use crate::dynamics::{Creep, DynamicForm, Linearised, Modes, StampedWorkspace};
use hysteron_numeric::Complex64;

/// Coefficients of the response of 1/(s − p) after a time t from x, to the input u + u' t: x e^(pt) + u
/// first + u' second; then those of the derivative in p.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    decay: Complex64,
    first: Complex64,
    second: Complex64,
    first_tangent: Complex64,
    second_tangent: Complex64,
}

impl Stretch {
    fn new(pole: Complex64, time: f64) -> Self {
        let x = pole * time;
        let decay = x.exp();
        // φₖ(x) = Σ xʲ/(j + k)!, first = t φ₁, second = t² φ₂, and t dφₖ/dx in p.
        let [phi1, phi2, slope1, slope2] = if x.norm() < 0.5 {
            phi_series(x)
        } else {
            let phi1 = (decay - 1.0) / x;
            let phi2 = (phi1 - 1.0) / x;
            let slope1 = (decay - phi1) / x;
            [phi1, phi2, slope1, (slope1 - phi2) / x]
        };
        Self {
            decay,
            first: phi1 * time,
            second: phi2 * time * time,
            first_tangent: slope1 * time * time,
            second_tangent: slope2 * time * time * time,
        }
    }
}

/// φ₁, φ₂ and their derivatives for |x| < 0.5; truncation error below 0.5¹⁶/17!.
fn phi_series(x: Complex64) -> [Complex64; 4] {
    let mut sums = [Complex64::ZERO; 4];
    let mut power = Complex64::ONE;
    let mut factorial = 1.0;
    for j in 0..16 {
        factorial *= f64::from((j + 1).max(1));
        let (first, second) = (1.0 / factorial, 1.0 / (factorial * f64::from(j + 2)));
        sums[0] += power * first;
        sums[1] += power * second;
        // Of the next term, whose derivative has this power.
        let next = f64::from(j + 1) / f64::from(j + 2);
        sums[2] += power * (first * next);
        sums[3] += power * (second * f64::from(j + 1) / f64::from(j + 3));
        power *= x;
    }
    sums
}

/// States ξ, and x with ∂x/∂p, after a time along a line of the input.
#[derive(Clone)]
struct States {
    relaxations: Vec<f64>,
    resonances: Vec<(Complex64, Complex64)>,
}

impl States {
    fn after(&self, time: f64, rates: &[f64], poles: &[Complex64], input: f64, slope: f64) -> Self {
        let relaxed = self.relaxations.iter().zip(rates).map(|(state, rate)| {
            let gain = -(-rate * time).exp_m1();
            state + gain * (input - state) + (time - gain / rate) * slope
        });
        let resonant = self.resonances.iter().zip(poles).map(|(&(x, moved), &pole)| {
            let of = Stretch::new(pole, time);
            (
                of.decay * x + of.first * input + of.second * slope,
                of.decay * (moved + x * time) + of.first_tangent * input + of.second_tangent * slope,
            )
        });
        Self { relaxations: relaxed.collect(), resonances: resonant.collect() }
    }
}

fn output(plan: &StampedPlan, response: &StampedResponse, readout: &Readout, input: &[f64]) -> Vec<f64> {
    let (rates, poles, weights) = (&plan.fit.rates, &response.poles, &readout.resonances);
    let mut states = States {
        relaxations: vec![0.0; rates.len()],
        resonances: vec![(Complex64::ZERO, Complex64::ZERO); poles.len()],
    };
    let mut at = 0;
    let slope = |at: usize| match plan.knots_s.get(at + 1) {
        Some(next) if !plan.held => (input[at + 1] - input[at]) / (next - plan.knots_s[at]),
        _ => 0.0,
    };
    let each = response.places.iter().map(|place| {
        let Some((knot, since)) = *place else { return 0.0 };
        while at < knot {
            states =
                states.after(plan.knots_s[at + 1] - plan.knots_s[at], rates, poles, input[at], slope(at));
            at += 1;
        }
        let then = states.after(since, rates, poles, input[at], slope(at));
        let resonant = then.resonances.iter().zip(weights).map(|((x, moved), (r, m))| (x * r + moved * m).re);
        hysteron_numeric::dot(&then.relaxations, &readout.relaxations)
            + resonant.sum::<f64>()
            + readout.input * (input[at] + slope(at) * since)
            + readout.slope * slope(at)
    });
    each.collect()
}

/// Largest difference of the fast pass, as a share of the largest output, over the output and all its
/// derivatives.
fn worst(form: DynamicForm, p: &[f64], delay_s: f64, held: bool) -> f64 {
    // Two rates, a gap, and steps that all differ.
    let mut times_s: Vec<f64> = (0..150_i32).map(|k| 1e-4 * f64::from(k)).collect();
    times_s.extend((0..100_i32).map(|k| 0.3 + 7e-4 * f64::from(k)));
    times_s.extend((0..400_i32).map(|k| 0.5 + 2e-4 * (f64::from(k) + 0.45 * (1.3 * f64::from(k * k)).sin())));
    let input: Vec<f64> = times_s.iter().map(|t| (40.0 * t).sin() + 0.2 * (900.0 * t).sin()).collect();
    let plan = StampedPlan::new(times_s.clone(), times_s, held).unwrap();
    let mut linearised = Linearised::new();
    form.linearise(p, &mut linearised).unwrap();
    let mut response = plan.empty_response();
    plan.response(&linearised.transfer_function, Some(&linearised), delay_s, &mut response).unwrap();
    let (mut workspace, mut found) = (StampedWorkspace::default(), vec![0.0; plan.samples()]);
    let mut together = vec![vec![0.0; plan.samples()]; response.tangents.len()];
    let mut wanted: Vec<(usize, &mut [f64])> =
        together.iter_mut().map(Vec::as_mut_slice).enumerate().collect();
    plan.apply_tangents(&response, &mut wanted, &input, &mut workspace).unwrap();
    let mut worst: f64 = 0.0;
    for which in 0..=response.tangents.len() {
        let readout = match which.checked_sub(1) {
            None => {
                // Beside others, in more than one row.
                let scaled: Vec<Vec<f64>> =
                    (0..11_i32).map(|k| input.iter().map(|u| u * 2_f64.powi(k)).collect()).collect();
                let inputs: Vec<&[f64]> = scaled.iter().map(Vec::as_slice).collect();
                let mut all = vec![vec![0.0; plan.samples()]; inputs.len()];
                let mut outputs: Vec<&mut [f64]> = all.iter_mut().map(Vec::as_mut_slice).collect();
                plan.apply_each(&response, &inputs, &mut workspace, &mut outputs).unwrap();
                plan.apply(&response, &input, &mut workspace, &mut found).unwrap();
                for (output, k) in all.iter().zip(0..) {
                    assert!(output.iter().zip(&found).all(|(y, one)| *y == one * 2_f64.powi(k)));
                }
                &response.value
            }
            Some(which) => {
                plan.apply_tangent(&response, which, &input, &mut workspace, &mut found).unwrap();
                assert_eq!(found, together[which]);
                &response.tangents[which]
            }
        };
        let expected = output(&plan, &response, readout, &input);
        let largest = expected.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
        let error = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        worst = worst.max(error / largest);
    }
    worst
}

#[test]
fn the_fast_pass_is_the_sum_term_by_term() {
    let forms: [(Modes, Creep, &[f64]); 6] = [
        (Modes::None, Creep::Fractional, &[0.08, 0.12]),
        (Modes::Integer { order: 1 }, Creep::None, &[4e-4]),
        (Modes::Integer { order: 3 }, Creep::Logarithmic, &[320.0, 0.02, 4e-4, 0.05, 0.004]),
        (
            Modes::Integer { order: 2 },
            Creep::KelvinVoigt { elements: 2 },
            &[320.0, 0.62, 0.08, 0.01, 0.05, 0.09],
        ),
        (Modes::Fractional, Creep::Fractional, &[320.0, 0.62, 1.94, 1.05, 0.08, 0.12]),
        (Modes::TwoFractional, Creep::None, &[320.0, 0.62, 1.94, 1.05, 710.0, 0.21, 1.87, 0.93, 0.7]),
    ];
    for (modes, creep, p) in forms {
        for (delay_s, held) in [(0.0, false), (3.7e-4, false), (3.7e-4, true)] {
            let worst = worst(DynamicForm { modes, creep }, p, delay_s, held);
            println!("{modes:?} {creep:?} delay {delay_s} held {held}: {worst:.1e}");
            assert!(worst < 2e-12, "{modes:?} {creep:?}: {worst:e}");
        }
    }
}
