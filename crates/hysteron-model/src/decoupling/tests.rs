#![allow(clippy::unwrap_used)]

use super::*;
use crate::axes::{
    CoupledHammerstein, FeedbackStrain, HeldSimulation, LevelLaw, Path, ScheduledModes, StrainLaw, Streaming,
};
use crate::dynamics::{Dynamics, Scheme, SecondOrder};
use crate::hammerstein;
use crate::hysteresis::{BoucWen, Hysteresis};
use crate::invert::InverseOptions;
use crate::record::InterSample;
use hysteron_numeric::Complex64;
use std::f64::consts::TAU;

const RATE: f64 = 2000.0;

/// Three actuators, two or three axes, two steps a sample, modes that move with the level, hysteresis of
/// drive and stress in feedback.
fn device(outputs: usize) -> ScheduledModes {
    let modes = [(130.0, [1.0, 0.4, 0.2]), (250.0, [0.5, -0.9, 0.3]), (410.0, [0.3, 0.2, 1.0])];
    let (inputs, states, step_rate) = (3, 9, 2.0 * RATE);
    let mut d = ScheduledModes {
        inputs,
        outputs,
        modes: modes.len(),
        sample_rate_hz: RATE,
        steps: 2,
        level: LevelLaw { reference: 0.5, exponent: 1.0, lowest: 0.1, highest: 0.5, time_constant_s: 2.0 },
        transition: Vec::new(),
        transition_slopes: vec![0.0; states],
        input: vec![0.0; states * inputs],
        strain_input: vec![0.0; states * inputs],
        output: vec![0.0; outputs * states],
        output_slopes: vec![0.0; outputs * states],
        feedthrough: vec![0.0; outputs * inputs],
        feedthrough_slopes: vec![0.0; outputs * inputs],
        strain_feedthrough: vec![0.0; outputs * inputs],
        feedback: None,
    };
    for (k, (frequency, direction)) in modes.into_iter().enumerate() {
        let angle = TAU * frequency / step_rate;
        let pole = (Complex64::new(-0.03, 1.0) * angle).exp();
        let slope = pole * pole.ln() * -0.03;
        d.transition.extend([pole.re, pole.im]);
        (d.transition_slopes[2 * k], d.transition_slopes[2 * k + 1]) = (slope.re, slope.im);
        for (axis, share) in direction.into_iter().enumerate() {
            d.input[2 * k * inputs + axis] = angle * share;
            d.strain_input[2 * k * inputs + axis] = angle * share;
            if axis < outputs {
                d.output[axis * states + 2 * k + 1] = share;
            }
        }
    }
    let mut rows = vec![0.0; inputs * (states + inputs)];
    let mut stress = rows.clone();
    for axis in 0..inputs {
        d.transition.push(0.3);
        d.input[(6 + axis) * inputs + axis] = 0.7;
        d.strain_input[(6 + axis) * inputs + axis] = 0.7;
        if axis < outputs {
            d.output[axis * states + 6 + axis] = 1.5;
        }
        rows[axis * (states + inputs) + 6 + axis] = 1.0;
        stress[axis * (states + inputs) + 2 * axis + 1] = 0.2;
    }
    let law = |weight: f64| StrainLaw {
        coefficients: vec![0.01 * weight, -0.02 * weight, 0.1 * weight, 0.06 * weight],
        radii: vec![0.05, 0.2],
        slopes: vec![0.8, 0.5],
        variance: 0.1,
        reach: f64::INFINITY,
    };
    d.feedback = Some(FeedbackStrain {
        drive_rows: rows,
        stress_rows: stress,
        drive: law(1.0),
        stress: vec![law(0.3), law(0.2), law(-0.2)],
    });
    d.validate().unwrap();
    d
}

fn limits(count: usize, size: f64) -> Vec<Limits> {
    vec![Limits::range(-size, size); count]
}

/// Slow waves from rest, different on every axis.
fn waves(count: usize, samples: usize, size: f64, rate: f64) -> Vec<Vec<f64>> {
    let wave = |axis: usize, k: usize| {
        let t = k as f64 / rate;
        let grown = 1.0 - (-(t * 20.0).powi(3)).exp();
        size * grown * ((TAU * (3.0 + axis as f64) * t).sin() + 0.3 * (TAU * 11.0 * t + axis as f64).cos())
    };
    (0..count).map(|axis| (0..samples).map(|k| wave(axis, k)).collect()).collect()
}

fn held_outputs(model: &ScheduledModes, drive: &[Vec<f64>], rest: &[f64], level: f64) -> Vec<Vec<f64>> {
    let mut stream = Streaming::new(model, rest, level);
    let mut y = vec![0.0; model.outputs];
    stream.hold(rest, &mut y);
    let mut all = vec![Vec::new(); model.outputs];
    for k in 0..drive[0].len() {
        stream.hold(&drive.iter().map(|u| u[k]).collect::<Vec<_>>(), &mut y);
        all.iter_mut().zip(&y).for_each(|(list, y)| list.push(*y));
    }
    all
}

fn worst(a: &[Vec<f64>], b: &[Vec<f64>], range: std::ops::Range<usize>) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a[range.clone()].iter().zip(&b[range.clone()]));
    pairs.fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

#[test]
fn held_inputs_are_those_of_the_simulation_by_hold() {
    let model = device(3);
    let drive = waves(3, 120, 0.3, RATE);
    let streamed = held_outputs(&model, &drive, &drive.iter().map(|u| u[0]).collect::<Vec<_>>(), 0.2);
    let simulated = model.simulate_after(&drive, RATE, InterSample::Hold, 0.2).unwrap();
    // The stream has seen the first input once more.
    let shifted: Vec<Vec<f64>> = streamed.iter().map(|y| y[1..].to_vec()).collect();
    let tail: Vec<Vec<f64>> = simulated.iter().map(|y| y[1..].to_vec()).collect();
    assert!(worst(&shifted, &tail, 0..119) < 1e-4, "{}", worst(&shifted, &tail, 0..119));
}

/// The inverse of what the model does with a drive is that drive: to 1e-4 of its size, which the error at the
/// bandwidth of the inverse leaves, away from the end, where the future is not known.
#[test]
fn the_inverse_gives_back_the_drive_that_made_the_motion() {
    let model = device(3);
    let drive = waves(3, 600, 0.3, RATE);
    let y = held_outputs(&model.held_at(RATE).unwrap().model, &drive, &[0.0; 3], 0.3);
    let options = DecouplingOptions {
        level: Some(0.3),
        bandwidth_hz: Some(500.0),
        ..DecouplingOptions::within(limits(3, 2.0))
    };
    let found = decouple(&model, &y, RATE, &options).unwrap();
    let rest = found.rest.clone().unwrap();
    assert!(rest.iter().all(|u| u.abs() < 1e-6), "{rest:?}");
    let error = worst(&found.drive, &drive, 0..560);
    assert!(error < 1e-4 * 0.39, "{error}");
    assert_eq!((found.at_range, found.at_slew), (vec![0; 3], vec![0; 3]));
    assert!(found.rounds < 30, "{}", found.rounds);
}

#[test]
fn the_model_follows_its_inverse_and_limits_are_kept() {
    let model = device(3);
    let references = waves(3, 800, 0.5, RATE);
    let options =
        DecouplingOptions { bandwidth_hz: Some(300.0), ..DecouplingOptions::within(limits(3, 2.0)) };
    let found = decouple(&model, &references, RATE, &options).unwrap();
    let error = worst(&found.predicted, &references, 0..760);
    assert!(error < 1e-3 * 0.65, "{error}");
    let held = model.held_at(RATE).unwrap().model;
    let again = held_outputs(&held, &found.drive, &found.rest.clone().unwrap(), found.level);
    assert!(worst(&found.predicted, &again, 0..800) < 1e-12);
    // Tight limits on one actuator.
    let mut tight = limits(3, 2.0);
    tight[1] = Limits::range(-0.1, 0.12).slew(3.0);
    let held_back = DecouplingOptions { limits: tight, ..options };
    let found = decouple(&model, &references, RATE, &held_back).unwrap();
    assert!(found.drive[1].iter().all(|u| (-0.1..=0.12).contains(u)));
    assert!(found.drive[1].windows(2).all(|w| (w[1] - w[0]).abs() <= 3.0 / RATE * (1.0 + 1e-9)));
    assert!(found.at_range[1] > 0 && found.at_slew[1] > 0 && found.at_range[0] == 0);
}

#[test]
fn a_surplus_actuator_shares_the_motion() {
    let model = device(2);
    let references = waves(2, 500, 0.4, RATE);
    let options =
        DecouplingOptions { bandwidth_hz: Some(300.0), ..DecouplingOptions::within(limits(3, 2.0)) };
    let found = decouple(&model, &references, RATE, &options).unwrap();
    assert!(worst(&found.predicted, &references, 0..460) < 1e-3);
    assert!(found.drive[2].iter().any(|u| u.abs() > 0.01));
    let law = DecouplingLaw::new(&model, RATE, &LawOptions::default()).unwrap();
    let streamed = law.follow(&references, &limits(3, 2.0)).unwrap();
    let error = worst(&streamed.predicted, &references, 0..500);
    assert!(error < 5e-3, "{error}");
}

#[test]
fn sample_by_sample_it_is_causal_and_follows_as_the_known_reference_is() {
    let model = device(3);
    let references = waves(3, 500, 0.4, RATE);
    let law = DecouplingLaw::new(&model, RATE, &LawOptions::default()).unwrap();
    let found = law.follow(&references, &limits(3, 2.0)).unwrap();
    // After their end the references stay: a corner, which the last samples round.
    let error = worst(&found.predicted, &references, 0..450);
    assert!(error < 2e-3 * 0.5, "{error}, preview {}", law.preview);
    let options = LawOptions { preview: Some(30), ..LawOptions::default() };
    let law = DecouplingLaw::new(&model, RATE, &options).unwrap();
    assert_eq!(law.preview, 30);
    let found = law.follow(&references, &limits(3, 2.0)).unwrap();
    // The drive up to sample 200 does not know references beyond 230.
    let mut changed = references.clone();
    changed.iter_mut().for_each(|r| r[231..].iter_mut().for_each(|r| *r += 0.2));
    let other = law.follow(&changed, &limits(3, 2.0)).unwrap();
    for (a, b) in found.drive.iter().zip(&other.drive) {
        assert_eq!(a[..=200], b[..=200]);
        assert!(a[201] != b[201]);
    }
    // Limits hold, and the law recovers from them.
    let found = law.follow(&references, &limits(3, 0.15)).unwrap();
    assert!(found.drive.iter().flatten().all(|u| u.abs() <= 0.15));
    assert!(found.at_range.iter().sum::<usize>() > 0);
}

#[test]
fn at_rest_the_law_holds_its_references_exactly() {
    let law = DecouplingLaw::new(&device(3), RATE, &LawOptions::default()).unwrap();
    let constant = vec![vec![0.2; 400], vec![-0.1; 400], vec![0.05; 400]];
    let found = law.follow(&constant, &limits(3, 2.0)).unwrap();
    assert!(worst(&found.predicted, &constant, 0..400) < 1e-9);
}

#[test]
fn held_inputs_have_the_response_of_the_hold_at_every_rate() {
    let model = device(3);
    // At a lower rate images of the hold add what the model does above its band.
    for rate in [4000.0, 5000.0, 20_000.0, 1e5] {
        let held = model.held_at(rate).unwrap();
        assert!(held.error < 3e-3, "{rate}: {}", held.error);
        held.model.validate().unwrap();
        let linear = linear::LinearAxes::of(&held.model, 0.0);
        let largest = model.linear_response(0.0, 0.0).iter().fold(0.0, |most: f64, g| most.max(g.norm()));
        for share in [1e-3, 0.02, 0.1, 0.2] {
            let angle = TAU * share;
            let hold = (1.0 - Complex64::from_polar(1.0, -angle)) / Complex64::new(0.0, angle);
            let found = linear.transfer(Complex64::from_polar(1.0, angle));
            // Above the model's band there is nothing to hold to.
            if share * rate > 0.9 * 0.5 * RATE {
                continue;
            }
            for (found, own) in found.iter().zip(model.linear_response(share * rate, 0.0)) {
                let apart = (found - own * hold).norm();
                assert!(apart < 5e-3 * largest, "{rate} {share}: {apart} of {largest}");
            }
        }
    }
}

#[test]
fn held_inputs_come_to_the_rest_of_the_model_at_every_rate() {
    let model = device(3);
    let u = [0.7, -0.4, 0.5];
    let mut stream = Streaming::new(&model, &u, 0.5);
    let mut own = vec![0.0; 3];
    stream.hold(&u, &mut own);
    for rate in [1000.0, 2000.0, 2700.0, 4000.0, 20_000.0, 1e6] {
        let mut simulation = HeldSimulation::new(model.held_at(rate).unwrap().model, 0.0);
        simulation.rest_at(&u);
        let largest = own.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        let apart = simulation.output().iter().zip(&own).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f64::max) / largest;
        // The plays keep how far the motion overshot.
        assert!(apart < 1e-4, "{rate}: {apart}");
    }
}

#[test]
fn another_rate_is_refitted_and_a_slow_one_refused() {
    let model = device(3);
    // Held voltages come to rest, at any rate.
    for rate in [2300.0, 2700.0, 3100.0, 3900.0, 4400.0, 5000.0, 7300.0, 20_000.0] {
        let mut simulation = HeldSimulation::new(model.held_at(rate).unwrap().model, 0.0);
        simulation.apply(&[0.7, -0.4, 0.5]);
        (0..(2.0 * rate) as usize).for_each(|_| {
            simulation.advance();
            simulation.apply(&[0.7, -0.4, 0.5]);
        });
        let rest = simulation.output().to_vec();
        simulation.advance();
        let moved = simulation.apply(&[0.7, -0.4, 0.5]).iter().zip(&rest).map(|(a, b)| (a - b).abs());
        assert!(moved.fold(0.0, f64::max) < 1e-9, "{rate}");
    }
    assert!(matches!(model.held_at(50.0), Err(crate::axes::AxesError::Rate { lowest_hz: 62.5, .. })));
    // The drive at ten times the rate moves the model of the other rate along the same references.
    let references = waves(3, 4000, 0.4, 10.0 * RATE);
    let law = LawOptions { bandwidth_hz: Some(200.0), ..LawOptions::default() };
    let law = DecouplingLaw::new(&model, 10.0 * RATE, &law).unwrap();
    let found = law.follow(&references, &limits(3, 2.0)).unwrap();
    let thinned: Vec<Vec<f64>> =
        found.drive.iter().map(|u| u.iter().step_by(10).copied().collect()).collect();
    let y = model.simulate_after(&thinned, RATE, InterSample::Linear, 0.5).unwrap();
    let wanted: Vec<Vec<f64>> = references.iter().map(|r| r.iter().step_by(10).copied().collect()).collect();
    let error = worst(&y, &wanted, 20..400);
    assert!(error < 5e-3, "{error}");
}

#[test]
fn a_law_far_above_the_rate_of_the_model_follows_as_far_as_the_model_goes() {
    let model = device(3);
    for rate in [1e4, 3e4, 1e5, 3e5, 1e6, 1e7] {
        let law = DecouplingLaw::new(&model, rate, &LawOptions::default()).unwrap();
        assert!(law.held.error < if rate > 5e5 { 0.05 } else { 3e-3 }, "{rate}: {}", law.held.error);
        assert_eq!(law.bandwidth_hz, 0.05 * rate.min(model.step_rate_hz()));
        let found = law.follow(&waves(3, 3000, 0.4, rate), &limits(3, 2.0));
        // The slowest mode settles in more samples than are simulated to find the rest.
        let Ok(found) = found else {
            assert!(rate > 1e6, "{rate}");
            continue;
        };
        assert!(found.predicted.iter().flatten().all(|y| y.abs() < 10.0), "{rate}");
        assert!(found.drive.iter().flatten().all(|u| u.abs() <= 2.0), "{rate}");
    }
    // A drive that leaves the range of numbers is that before.
    let limit = Limits { low: -1.0, high: 1.0, slew_v_per_s: f64::INFINITY };
    assert_eq!(limited(f64::NAN, 0.5, &limit, RATE).0, 0.5);
}

fn actuator(alpha: f64, beta: f64, gamma: f64) -> BoucWen {
    BoucWen { polynomial: vec![1.0], alpha, beta, gamma, n: 1.0 }
}

#[test]
fn a_diagonal_model_has_the_inverses_of_its_axes() {
    let path = |gain, natural_frequency_hz| Path { gain, natural_frequency_hz, damping: 0.1, delay_s: 1e-3 };
    let stage = CoupledHammerstein {
        actuators: vec![actuator(0.25, 0.9, 0.2), actuator(0.32, 0.6, -0.15)],
        paths: vec![path(1.4, 170.0), path(0.0, 95.0), path(0.0, 82.0), path(1.1, 260.0)],
        offsets: vec![3.0, -2.0],
        sample_rate_hz: RATE,
    };
    let references: Vec<Vec<f64>> = waves(2, 400, 0.8, RATE)
        .into_iter()
        .zip([3.2, -2.1])
        .map(|(r, o)| r.into_iter().map(|r| r + o).collect())
        .collect();
    let found =
        decouple_branches(&stage, &references, RATE, &DecouplingOptions::within(limits(2, 5.0))).unwrap();
    for (axis, reference) in references.iter().enumerate() {
        let path = stage.paths[3 * axis];
        let pair = SecondOrder {
            gain: path.gain,
            natural_frequency_hz: path.natural_frequency_hz,
            damping: path.damping,
            alpha2: 2.0,
            alpha1: 1.0,
            alpha0: 0.0,
        };
        let single = hammerstein::Model {
            hysteresis: Hysteresis::from(stage.actuators[axis].clone()),
            dynamics: Dynamics::Integer(pair.to_transfer_function().unwrap()),
            offset: stage.offsets[axis],
            delay_s: path.delay_s,
            scheme: Scheme::Tustin,
            inter_sample: InterSample::Linear,
            sample_rate_hz: None,
        };
        let alone = single.invert(reference, RATE, &InverseOptions::within([-5.0, 5.0])).unwrap();
        let both = [found.drive[axis].clone(), found.predicted[axis].clone()];
        assert!(worst(&both, &[alone.drive, alone.predicted], 0..400) < 1e-9);
    }
}

#[test]
fn coupled_branches_follow_and_the_simulation_agrees() {
    let path = |gain, natural_frequency_hz| Path { gain, natural_frequency_hz, damping: 0.1, delay_s: 5e-4 };
    let stage = CoupledHammerstein {
        actuators: vec![actuator(0.25, 0.9, 0.2), actuator(0.32, 0.6, -0.15)],
        paths: vec![path(1.4, 170.0), path(-0.3, 95.0), path(0.2, 82.0), path(1.1, 260.0)],
        offsets: vec![0.0; 2],
        sample_rate_hz: RATE,
    };
    let references = waves(2, 600, 0.8, RATE);
    let options = DecouplingOptions { bandwidth_hz: Some(60.0), ..DecouplingOptions::within(limits(2, 5.0)) };
    let found = decouple_branches(&stage, &references, RATE, &options).unwrap();
    assert!(worst(&found.predicted, &references, 0..550) < 1e-3);
    // The simulation joins the samples of the drive by lines, half a sample earlier than held ones.
    let half: Vec<Vec<f64>> = found
        .drive
        .iter()
        .map(|u| u.iter().scan(u[0], |last, u| Some(0.5 * (std::mem::replace(last, *u) + u))).collect())
        .collect();
    let y = stage.simulate(&half, RATE, None).unwrap();
    let error = worst(&y, &references, 0..550);
    assert!(error < 0.02, "{error}");
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let model = device(3);
    let options = DecouplingOptions::within(limits(3, 1.0));
    let references = waves(3, 100, 0.2, RATE);
    let refuse = |references: &[Vec<f64>], options: &DecouplingOptions| {
        decouple(&model, references, RATE, options).unwrap_err()
    };
    assert!(matches!(
        refuse(&references[..2], &options),
        DecouplingError::References { outputs: 3, references: 2 }
    ));
    let few = DecouplingOptions::within(limits(2, 1.0));
    assert!(matches!(refuse(&references, &few), DecouplingError::Limits { inputs: 3, limits: 2 }));
    let mut far = references.clone();
    far[0].iter_mut().for_each(|r| *r += 100.0);
    assert!(matches!(refuse(&far, &options), DecouplingError::Begins { .. }));
    let mut bad = references.clone();
    bad[2][7] = f64::NAN;
    assert!(matches!(refuse(&bad, &options), DecouplingError::NotFinite { axis: 3, index: 7 }));
    let wide = LawOptions { bandwidth_hz: Some(RATE), ..LawOptions::default() };
    assert!(matches!(DecouplingLaw::new(&model, RATE, &wide), Err(DecouplingError::Option { .. })));
}
