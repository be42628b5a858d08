//! Reference for the fast passes: the sum of relaxations and resonances one step and one term at a time, with
//! the functions of the library.

use super::{KnotTimes, Readout, RelaxationFit, StampedPlan, StampedResponse};
use crate::dynamics::{Creep, DynamicForm, Linearised, Modes, StampedWorkspace};
use hysteron_numeric::Complex64;

/// Coefficients of the response of 1/(s − p) after a time t from x, to the input u + u' t + c t²: x e^(pt) +
/// u first + u' second + c third; then those of the derivative in p.
#[derive(Clone, Copy, Debug, Default)]
struct Stretch {
    decay: Complex64,
    of_input: [Complex64; 3],
    of_input_tangent: [Complex64; 3],
}

impl Stretch {
    fn new(pole: Complex64, time: f64) -> Self {
        let x = pole * time;
        let decay = x.exp();
        // φₖ(x) = Σ xʲ/(j + k)!, first = t φ₁, second = t² φ₂, third = 2 t³ φ₃, and t dφₖ/dx in p.
        let (phi, slopes) = if x.norm() < 0.5 {
            phi_series(x)
        } else {
            let (mut last, mut last_slope, mut factorial) = (decay, decay, 1.0);
            let mut each = [(Complex64::ZERO, Complex64::ZERO); 3];
            for (k, each) in (1..).zip(&mut each) {
                (last, last_slope) =
                    ((last - 1.0 / factorial) / x, (last_slope - (last - 1.0 / factorial) / x) / x);
                factorial *= f64::from(k);
                *each = (last, last_slope);
            }
            (each.map(|(phi, _)| phi), each.map(|(_, slope)| slope))
        };
        let powers = [time, time.powi(2), 2.0 * time.powi(3)];
        Self {
            decay,
            of_input: std::array::from_fn(|k| phi[k] * powers[k]),
            of_input_tangent: std::array::from_fn(|k| slopes[k] * powers[k] * time),
        }
    }

    fn respond(of: [Complex64; 3], parabola: [f64; 3]) -> Complex64 {
        of.into_iter().zip(parabola).map(|(of, input)| of * input).sum()
    }
}

/// φ₁, φ₂, φ₃ and their derivatives for |x| < 0.5; truncation error below 0.5¹⁶/17!.
fn phi_series(x: Complex64) -> ([Complex64; 3], [Complex64; 3]) {
    let (mut phi, mut slopes) = ([Complex64::ZERO; 3], [Complex64::ZERO; 3]);
    for (k, (phi, slope)) in (1..).zip(phi.iter_mut().zip(&mut slopes)) {
        let mut power = Complex64::ONE;
        for j in 0..16 {
            let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
            *phi += power / factorial(j + k);
            *slope += power * f64::from(j + 1) / factorial(j + 1 + k);
            power *= x;
        }
    }
    (phi, slopes)
}

/// States ξ, and x with ∂x/∂p, after a time along a parabola of the input.
#[derive(Clone)]
struct States {
    relaxations: Vec<f64>,
    resonances: Vec<(Complex64, Complex64)>,
}

impl States {
    fn after(&self, time: f64, rates: &[f64], poles: &[Complex64], parabola: [f64; 3]) -> Self {
        let relaxed = self.relaxations.iter().zip(rates).map(|(state, rate)| {
            // ξ = λ x with x' = u − λ x.
            let of = Stretch::new(Complex64::new(-rate, 0.0), time);
            (of.decay * state + Stretch::respond(of.of_input, parabola) * rate).re
        });
        let resonant = self.resonances.iter().zip(poles).map(|(&(x, moved), &pole)| {
            let of = Stretch::new(pole, time);
            (
                of.decay * x + Stretch::respond(of.of_input, parabola),
                of.decay * (moved + x * time) + Stretch::respond(of.of_input_tangent, parabola),
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
    // Through the ends, with the mean of the polygon.
    let parabola = |at: usize| {
        let knots = match plan.corners[at..] {
            [first, last, ..] if !plan.held => &input[first..=last],
            [first, ..] => return [input[first], 0.0, 0.0],
            [] => return [0.0; 3],
        };
        let (from, to) = (knots[0], knots[knots.len() - 1]);
        let length = plan.corners_s[at + 1] - plan.corners_s[at];
        let mean =
            knots.windows(2).map(|two| 0.5 * (two[0] + two[1])).sum::<f64>() / (knots.len() - 1) as f64;
        [from, (6.0 * mean - 4.0 * from - 2.0 * to) / length, 3.0 * (from + to - 2.0 * mean) / length.powi(2)]
    };
    let each = response.places.iter().map(|place| {
        let Some((knot, since)) = *place else { return 0.0 };
        while at < knot {
            states = states.after(plan.corners_s[at + 1] - plan.corners_s[at], rates, poles, parabola(at));
            at += 1;
        }
        let [from, slope, bend] = parabola(at);
        let then = states.after(since, rates, poles, [from, slope, bend]);
        let resonant = then.resonances.iter().zip(weights).map(|((x, moved), (r, m))| (x * r + moved * m).re);
        hysteron_numeric::dot(&then.relaxations, &readout.relaxations)
            + resonant.sum::<f64>()
            + readout.input * (from + (slope + bend * since) * since)
            + readout.slope * (slope + 2.0 * bend * since)
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
    let mut knots = KnotTimes::from(times_s.clone());
    if !held {
        // One to five equal parts a step.
        let (mut last, mut parts) = (times_s[0], 0);
        knots = KnotTimes { times_s: vec![last], arcs: Vec::new() };
        for time in &times_s[1..] {
            parts = parts % 5 + 1;
            let part = (time - last) / f64::from(parts);
            knots.times_s.extend((1..parts).map(|k| last + f64::from(k) * part));
            knots.times_s.push(*time);
            knots.arcs.push(knots.times_s.len() - 1);
            last = *time;
        }
    }
    let input: Vec<f64> = knots.times_s.iter().map(|t| (40.0 * t).sin() + 0.2 * (900.0 * t).sin()).collect();
    let plan = StampedPlan::new(knots, times_s, held).unwrap();
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

#[test]
fn creep_of_any_size_and_duration_is_a_sum_of_relaxations() {
    let form = DynamicForm { modes: Modes::None, creep: Creep::Fractional };
    for (duration_s, step_s) in [(1.0, 1e-4), (100.0, 1e-4), (1e3, 1e-4), (1e3, 1e-5)] {
        let fit = RelaxationFit::new(duration_s, step_s).unwrap();
        for gain in [1e-4, 1e-2, 0.1, 0.3, 1.0] {
            for order in [0.01, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6] {
                let tf = form.transfer_function(&[gain, order]).unwrap();
                let weights = fit.weights(&tf, None, &[]);
                assert!(weights.is_ok(), "{duration_s} {step_s} {gain} {order}: {weights:?}");
            }
        }
    }
}
