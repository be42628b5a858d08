//! Derivatives and normal equations against slow, obvious ways.

use hysteron_optimize::Stop;
use nalgebra::{DMatrix, DVector};

use super::columns::{Freedom, Group};
use super::linearised::Linearised;
use super::normal::{cost, derivatives, information, normal_equations};
use super::quantities::{order, quantities};
use super::records::{Alike, RecordPeriod};
use super::ridge::Ridge;
use super::stress_scale;
use super::summary::ALL;
use super::uncertainty::with_standard_errors;
use hysteron_model::axes::{
    FeedbackStrain, LevelLaw, Mode, ScheduledModes, SteadyPeriod, StrainLaw, Trajectory, pole,
    simulate_steady,
};
use hysteron_numeric::{LANES, Lanes};

/// Numbers between −1 and 1 that look random.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn list(&mut self, count: usize, size: f64) -> Vec<f64> {
        (0..count).map(|_| size * self.next()).collect()
    }
}

/// Two inputs, three outputs, two modes, everything at work.
fn model() -> ScheduledModes {
    let mut numbers = Numbers(1);
    let (n, m, modes, rate, steps) = (2, 3, 2, 1000.0, 2);
    let states = 2 * modes + n;
    let mode = |frequency_hz, damping| pole(Mode { frequency_hz, damping }, rate * steps as f64);
    let poles = [mode(90.0, 0.05), mode(210.0, 0.04)];
    let law = |numbers: &mut Numbers| StrainLaw {
        coefficients: numbers.list(5, 0.1),
        radii: vec![0.1, 0.3, 0.8],
        slopes: vec![0.9, 0.6, 0.2],
        variance: 0.5,
        reach: f64::INFINITY,
    };
    ScheduledModes {
        inputs: n,
        outputs: m,
        modes,
        sample_rate_hz: rate,
        steps,
        level: LevelLaw { reference: 1.0, exponent: 1.0, lowest: 0.1, highest: 1.0, time_constant_s: 0.5 },
        transition: poles.iter().flat_map(|p| [p.re, p.im]).chain([0.6, 0.7]).collect(),
        transition_slopes: numbers.list(states, 0.01),
        input: numbers.list(states * n, 0.3),
        strain_input: numbers.list(states * n, 0.2),
        output: numbers.list(m * states, 1.0),
        output_slopes: numbers.list(m * states, 0.2),
        feedthrough: numbers.list(m * n, 1.0),
        feedthrough_slopes: numbers.list(m * n, 0.2),
        strain_feedthrough: numbers.list(m * n, 0.5),
        feedback: Some(FeedbackStrain {
            drive_rows: numbers.list(n * (states + n), 0.5),
            stress_rows: numbers.list(n * (states + n), 0.5),
            drive: law(&mut numbers),
            stress: vec![law(&mut numbers), law(&mut numbers)],
        }),
    }
}

/// A period of noise, its outputs noise as well.
fn piece(seed: u64, size: f64, model: &ScheduledModes) -> RecordPeriod {
    let samples = 200;
    let mut numbers = Numbers(seed);
    let fine = numbers.list(samples * model.steps * model.inputs, size);
    let period = SteadyPeriod {
        name: "noise".into(),
        sample_rate_hz: model.sample_rate_hz,
        inputs: model.inputs,
        outputs: model.outputs,
        u: fine.chunks_exact(model.inputs).step_by(model.steps).flatten().copied().collect(),
        y: numbers.list(samples * model.outputs, 1.0),
        offset: vec![0.0; model.outputs],
        averaged: 1,
        settling: 0,
        level: size / 3f64.sqrt(),
    };
    RecordPeriod { period, fine, level: 0, weight: 0.7 }
}

/// Column of every free parameter by central differences: outputs at every sample, interleaved.
fn differences(
    model: &ScheduledModes,
    freedom: &Freedom,
    s: f64,
    fine: &[f64],
    preroll: usize,
) -> Vec<Vec<f64>> {
    let step = 1e-6;
    let run = |k: usize, step: f64| {
        let mut moved = vec![0.0; freedom.columns.len()];
        moved[k] = step;
        simulate_steady(&freedom.moved(model, &moved), s, fine, preroll).unwrap()
    };
    (0..freedom.columns.len())
        .map(|k| run(k, step).iter().zip(run(k, -step)).map(|(a, b)| (a - b) / (2.0 * step)).collect())
        .collect()
}

#[test]
fn every_derivative_is_that_of_central_differences() {
    let model = model();
    model.validate().unwrap();
    let piece = piece(7, 0.8, &model);
    let s = model.state_of(&piece.period);
    assert!(s < -0.3);
    let freedom = Freedom::new(&model, &ALL);
    let count = piece.fine.len() / model.inputs;
    let preroll = 6 * count;
    let expected = differences(&model, &freedom, s, &piece.fine, preroll);
    let trajectory = Trajectory::new(&model, s, &piece.fine, preroll, preroll).unwrap();
    let mut blocks: Vec<Vec<Lanes<f64>>> = Vec::new();
    derivatives(&model, &freedom, &trajectory, s, &Stop::new(), &mut blocks);
    let (samples, outputs) = (piece.period.samples(), model.outputs);
    for (column, expected) in freedom.columns.iter().zip(&expected) {
        let factor = if column.scheduled { s } else { 1.0 };
        let at = |sample: usize, output: usize| -> f64 {
            if column.base < freedom.dynamic {
                return factor * blocks[column.base / LANES][output * samples + sample][column.base % LANES];
            }
            let place = column.base - freedom.dynamic;
            if place / freedom.own.len() != output {
                return 0.0;
            }
            factor * trajectory.at_sample(sample, model.steps)[freedom.own[place % freedom.own.len()]]
        };
        let size = expected.iter().map(|d| d * d).sum::<f64>().sqrt();
        let off: f64 = (0..samples)
            .flat_map(|k| (0..outputs).map(move |m| (k, m)))
            .map(|(k, m)| (expected[k * outputs + m] - at(k, m)).powi(2))
            .sum();
        assert!(size > 1e-6, "{column:?} has no effect");
        assert!(off.sqrt() < 2e-6 * size, "{column:?}: {} of {size}", off.sqrt());
    }
}

#[test]
fn the_normal_equations_are_those_of_the_columns_and_lower_the_cost() {
    let model = model();
    let pieces = [piece(7, 0.8, &model), piece(8, 1.5, &model)];
    let all: Vec<&RecordPeriod> = pieces.iter().collect();
    let freedom = Freedom::new(&model, &ALL);
    let found = normal_equations(&model, &freedom, &all, &[1.0, 1.0], &Stop::new()).unwrap();
    let count = freedom.columns.len();
    let mut matrix = DMatrix::zeros(count, count);
    let mut gradient = DVector::zeros(count);
    for piece in &pieces {
        let s = model.state_of(&piece.period);
        let steps = piece.fine.len() / model.inputs;
        let mut columns = differences(&model, &freedom, s, &piece.fine, 4 * steps);
        for column in &mut columns {
            hysteron_model::axes::remove_means(column, model.outputs);
        }
        let y = simulate_steady(&model, s, &piece.fine, 4 * steps).unwrap();
        let mut e: Vec<f64> = piece.period.y.iter().zip(&y).map(|(a, b)| a - b).collect();
        hysteron_model::axes::remove_means(&mut e, model.outputs);
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..count {
            gradient[i] += piece.weight * dot(&columns[i], &e);
            for j in 0..count {
                matrix[(i, j)] += piece.weight * dot(&columns[i], &columns[j]);
            }
        }
    }
    // Derivatives begin ten e-folds of the open loop before the period, and feedback decays more slowly.
    let off = (&found.matrix - &matrix).norm() / matrix.norm();
    assert!(off < 5e-3, "{off}");
    let off = (&found.gradient - &gradient).norm() / gradient.norm();
    assert!(off < 5e-3, "{off}");
    // A short step along the gradient lowers the cost as it predicts: −2 ε |g|².
    let step = 1e-6 / gradient.norm();
    let moved = freedom.moved(&model, (&found.gradient * step).as_slice());
    let ones = [1.0; 2];
    let fall = cost(&model, &all, &ones) - cost(&moved, &all, &ones);
    assert!((fall / (2.0 * step * gradient.norm_squared()) - 1.0).abs() < 1e-3, "{fall}");
}

#[test]
fn the_normal_equations_are_the_same_bits_for_any_number_of_threads() {
    let model = model();
    let piece = piece(7, 0.8, &model);
    let freedom = Freedom::new(&model, &ALL);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| normal_equations(&model, &freedom, &[&piece], &[1.0], &Stop::new()).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.matrix, three.matrix);
    assert_eq!(one.gradient, three.gradient);
}

#[test]
fn the_gradient_backwards_is_that_of_the_derivatives_forwards() {
    let model = model();
    let piece = piece(7, 0.8, &model);
    let s = model.state_of(&piece.period);
    let freedom = Freedom::new(&model, &ALL);
    let count = piece.fine.len() / model.inputs;
    let trajectory = Trajectory::new(&model, s, &piece.fine, 4 * count, count).unwrap();
    let mut blocks: Vec<Vec<Lanes<f64>>> = Vec::new();
    derivatives(&model, &freedom, &trajectory, s, &Stop::new(), &mut blocks);
    let weights = &piece.period.y;
    let linearised = Linearised::<f64>::new(&model, s, &trajectory);
    let found = linearised.system(&model, &trajectory).gradient(&freedom.blocks, weights);
    let (samples, outputs) = (piece.period.samples(), model.outputs);
    let places = || (0..samples).flat_map(|k| (0..outputs).map(move |m| (k, m)));
    for column in 0..freedom.dynamic {
        let at = |(k, m): (usize, usize)| blocks[column / LANES][m * samples + k][column % LANES];
        let expected: f64 = places().map(|(k, m)| weights[k * outputs + m] * at((k, m))).sum();
        let size: f64 = places().map(|place| at(place).powi(2)).sum::<f64>().sqrt();
        assert!((found[column] - expected).abs() < 1e-11 * size, "{column}: {} {expected}", found[column]);
    }
}

#[test]
fn products_in_single_precision_are_those_in_double() {
    let model = model();
    let pieces = [piece(7, 0.8, &model), piece(8, 1.5, &model)];
    let all: Vec<&RecordPeriod> = pieces.iter().collect();
    let freedom = Freedom::new(&model, &ALL);
    let single = normal_equations(&model, &freedom, &all, &[1.0, 1.0], &Stop::new()).unwrap();
    let (double, _) = information(&model, &freedom, &all, &[], &Stop::new()).unwrap();
    assert_eq!(single.gradient, double.gradient);
    let scale = |k: usize| double.matrix[(k, k)].sqrt();
    for i in 0..single.matrix.nrows() {
        for j in 0..single.matrix.ncols() {
            let off = (single.matrix[(i, j)] - double.matrix[(i, j)]) / (scale(i) * scale(j));
            // A hundred roundings.
            assert!(off.abs() < 100.0 * f64::from(f32::EPSILON), "{i} {j}: {off}");
        }
    }
}

#[test]
fn the_scale_of_a_stress_is_held_and_nothing_else() {
    let model = model();
    let top = RecordPeriod { level: 1, ..piece(8, 1.5, &model) };
    let pieces = [piece(7, 0.8, &model), top];
    let all: Vec<&RecordPeriod> = pieces.iter().collect();
    let freedom = Freedom::new(&model, &ALL);
    let (mut equations, _) = information(&model, &freedom, &all, &[], &Stop::new()).unwrap();
    let matrix = equations.matrix.clone();
    stress_scale::hold(&mut equations, &freedom, &model);
    let added = equations.matrix - &matrix;
    let (_, columns) = freedom.places(&model).into_iter().find(|(group, _)| *group == Group::Stress).unwrap();
    let (stress, width) = (&model.feedback.as_ref().unwrap().stress_rows, columns.len() / model.inputs);
    let mut expected = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    for actuator in 0..model.inputs {
        let row = &stress[actuator * width..(actuator + 1) * width];
        let mut of_rows = vec![0.0; width];
        for piece in &pieces[1..] {
            let s = model.state_of(&piece.period);
            let trajectory =
                Trajectory::new(&model, s, &piece.fine, 4 * piece.fine.len() / model.inputs, 0).unwrap();
            for signals in trajectory.signals.chunks_exact(trajectory.width).step_by(model.steps) {
                let sigma: f64 = row.iter().zip(signals).map(|(c, x)| c * x).sum();
                of_rows.iter_mut().zip(signals).for_each(|(sum, x)| *sum += sigma * x);
            }
        }
        let mut direction = DVector::zeros(matrix.nrows());
        direction.rows_mut(columns.start + actuator * width, width).copy_from_slice(&of_rows);
        direction.normalize_mut();
        let information = (direction.transpose() * &matrix * &direction)[(0, 0)];
        assert!(information > 0.0);
        expected += information * &direction * direction.transpose();
    }
    assert!((&added - &expected).norm() < 1e-6 * expected.norm(), "{}", (&added - &expected).norm());
}

#[test]
fn records_take_turns_where_each_drives_all_inputs() {
    let model = model();
    let of_level = |seed: u64, level: usize| RecordPeriod { level, ..piece(seed, 1.0, &model) };
    let pieces = [of_level(1, 0), of_level(2, 0), of_level(3, 1)];
    let all: Vec<&RecordPeriod> = pieces.iter().collect();
    let alike = Alike::new(&all, 10_000);
    assert_eq!(alike.shares(0), [2.0, 0.0, 1.0]);
    assert_eq!(alike.shares(1), [0.0, 2.0, 1.0]);
    assert_eq!(Alike::new(&all, 100).shares(0), [1.0, 1.0, 1.0], "all are soon multiplied");
    // One input at a time: no record can stand for the other.
    let mut pieces = pieces;
    for (still, piece) in pieces.iter_mut().take(2).enumerate() {
        piece.period.u.iter_mut().skip(still).step_by(2).for_each(|u| *u = 0.0);
    }
    let all: Vec<&RecordPeriod> = pieces.iter().collect();
    assert_eq!(Alike::new(&all, 10_000).shares(0), [1.0, 1.0, 1.0]);
}

/// Records of the model itself with white noise of this rms.
fn noisy(model: &ScheduledModes, seed: u64, noise: f64) -> Vec<RecordPeriod> {
    let mut numbers = Numbers(seed);
    let measured = |(number, size): (u64, f64)| {
        let mut piece = piece(20 + number, size, model);
        let s = model.state_of(&piece.period);
        let y = simulate_steady(model, s, &piece.fine, 4 * piece.fine.len() / model.inputs).unwrap();
        // Uniform between −√3 and √3: variance 1.
        piece.period.y = y.iter().map(|y| y + noise * 3f64.sqrt() * numbers.next()).collect();
        hysteron_model::axes::remove_means(&mut piece.period.y, model.outputs);
        piece
    };
    [(1, 0.4), (2, 0.4), (3, 1.5), (4, 1.5)].into_iter().map(measured).collect()
}

/// The model fitted to records of itself with noise, by two Gauss–Newton steps from the truth.
fn refitted(truth: &ScheduledModes, pieces: &[&RecordPeriod]) -> ScheduledModes {
    let mut model = truth.clone();
    let freedom = Freedom::new(truth, &ALL);
    for _ in 0..2 {
        let (equations, _) = information(&model, &freedom, pieces, &[], &Stop::new()).unwrap();
        let mut matrix = equations.matrix;
        // Undetermined scales of the states stay.
        (0..matrix.nrows()).for_each(|k| matrix[(k, k)] *= 1.0 + 1e-9);
        let step = matrix.cholesky().unwrap().solve(&equations.gradient);
        model = freedom.moved(&model, step.as_slice());
    }
    model
}

#[test]
fn standard_errors_are_the_scatter_over_forty_noise_seeds() {
    let truth = model();
    let order = order(&truth);
    const SEEDS: u64 = 40;
    let mut runs: Vec<Vec<f64>> = Vec::new();
    let mut errors: Vec<Vec<f64>> = Vec::new();
    for seed in 0..SEEDS {
        let pieces = noisy(&truth, 100 + seed, 1e-3);
        let all: Vec<&RecordPeriod> = pieces.iter().collect();
        let fitted = refitted(&truth, &all);
        runs.push(quantities(&fitted, &order).iter().map(|q| q.value).collect());
        let found = with_standard_errors(&fitted, (&ALL, 0.0), &all, &Stop::new());
        errors.push(found.iter().map(|q| q.std_error.unwrap()).collect());
    }
    let mut ratios = Vec::new();
    for (q, quantity) in quantities(&truth, &order).iter().enumerate() {
        let mean = |of: &dyn Fn(usize) -> f64| (0..runs.len()).map(of).sum::<f64>() / SEEDS as f64;
        let centre = mean(&|r| runs[r][q]);
        let scatter = (mean(&|r| (runs[r][q] - centre).powi(2)) * SEEDS as f64 / (SEEDS - 1) as f64).sqrt();
        let predicted = mean(&|r| errors[r][q].powi(2)).sqrt();
        println!(
            "{:?} {:?}: {} ± {predicted}, scatter {scatter}",
            quantity.part, quantity.name, quantity.value
        );
        ratios.push(predicted / scatter);
        assert!((centre - quantity.value).abs() < 4.0 * scatter / (SEEDS as f64).sqrt() + 0.5 * scatter);
    }
    // The scatter of 40 seeds is itself known to 11 %: 3.3 of these for the worst of some 60 quantities.
    assert!(ratios.iter().all(|r| (0.7..1.5).contains(r)), "{ratios:?}");
    ratios.sort_by(f64::total_cmp);
    let median = ratios[ratios.len() / 2];
    println!("median of {} ratios {median}", ratios.len());
    assert!((median - 1.0).abs() < 0.1, "{median}");
}

#[test]
fn quantities_do_not_depend_on_the_scale_of_a_state() {
    let model = model();
    let mut scaled = model.clone();
    let (n, x) = (model.inputs, model.states());
    // The first mode, turned by 0.7 rad and scaled by 3: q' = c q.
    let c = hysteron_numeric::Complex64::from_polar(3.0, 0.7);
    let turn = |re: f64, im: f64| hysteron_numeric::Complex64::new(re, im) * c;
    for list in [&mut scaled.input, &mut scaled.strain_input] {
        for i in 0..n {
            let b = turn(list[i], list[n + i]);
            (list[i], list[n + i]) = (b.re, b.im);
        }
    }
    // y = a Re q + b Im q = Re((a − ib) q).
    for list in [&mut scaled.output, &mut scaled.output_slopes] {
        for row in list.chunks_exact_mut(x) {
            let a = hysteron_numeric::Complex64::new(row[0], -row[1]) / c;
            (row[0], row[1]) = (a.re, -a.im);
        }
    }
    let order = order(&model);
    for (a, b) in quantities(&model, &order).iter().zip(quantities(&scaled, &order)) {
        assert!((a.value - b.value).abs() < 1e-10 * a.value.abs().max(1e-3), "{a:?} {b:?}");
    }
    // Gains at rest are those of the linear response, and the modes, lags and feedthrough add up to them.
    let gain = model.linear_response(0.0, model.level.state(model.level.highest));
    let of = |name, part| {
        let all = quantities(&model, &order);
        all.iter().find(|q| q.name == name && q.part == part).unwrap().value
    };
    let found = of(super::QuantityName::GainHigh, super::Part::Path(1, 2));
    assert!((found - gain[2 * n + 1].re).abs() < 1e-12, "{found} {}", gain[2 * n + 1]);
}

#[test]
fn the_ridge_leaves_a_common_shift_free_and_its_derivatives_are_those_of_its_value() {
    let base = model();
    let freedom = Freedom::new(&base, &ALL);
    let count = freedom.columns.len();
    let matrix = DMatrix::from_diagonal(&DVector::from_fn(count, |k, _| 1.0 + (k % 7) as f64));
    let ridge = Ridge::new(&freedom, &base, &matrix, 0.3);
    // All frequencies up by 3 %, all gains by 5 %.
    let mut common = base.clone();
    for (slope, p) in
        common.transition_slopes.chunks_exact_mut(2).zip(base.transition.chunks_exact(2)).take(2)
    {
        let p = hysteron_numeric::Complex64::new(p[0], p[1]);
        let shift = p * p.ln() * 0.03;
        (slope[0], slope[1]) = (shift.re, shift.im);
    }
    for k in 2 * base.modes..base.states() {
        common.transition_slopes[k] = 0.03 * base.transition[k] * base.transition[k].ln();
    }
    common.output_slopes = base.output.iter().map(|c| 0.05 * c).collect();
    common.feedthrough_slopes = base.feedthrough.iter().map(|d| 0.05 * d).collect();
    let (free, values) = (ridge.of(&freedom.values(&common)), freedom.values(&base));
    assert!(free.abs() < 1e-12 && ridge.of(&values) > 0.1, "{free} {}", ridge.of(&values));
    let (mut second, mut descent) = (DMatrix::zeros(count, count), DVector::zeros(count));
    ridge.add(&mut second, &mut descent, &values);
    for k in 0..count {
        let at = |h: f64| {
            let mut moved = values.clone();
            moved[k] += h;
            ridge.of(&moved)
        };
        // R is quadratic: its central differences are exact.
        let slope = 0.5 * (at(0.1) - at(-0.1)) / 0.1;
        let curvature = (at(0.1) + at(-0.1) - 2.0 * at(0.0)) / 0.01;
        assert!((slope + 2.0 * descent[k]).abs() < 1e-9, "{k}: {slope} {}", descent[k]);
        assert!((curvature - 2.0 * second[(k, k)]).abs() < 1e-9, "{k}");
    }
}
