//! Reduced records against whole ones that are filtered and thinned afterwards.

use super::super::drive::fine_drive;
use super::super::record::{Candidate, Clock, Direction, Ingredients, JointRecord};
use super::*;
use hysteron_model::Start;
use hysteron_model::dynamics::{Creep, DynamicForm, Linearised, Modes, Sampling, Scheme};
use hysteron_model::hysteresis::{HysteresisForm, RecordEnds};
use hysteron_model::record::InterSample;
use hysteron_optimize::Stop;
use proptest::prelude::*;
use std::f64::consts::TAU;

/// At rest with an unknown memory, at the first voltage of whatever record.
const REMEMBERING: Start<()> = Start::Remembering { voltage_v: 0.0, memory: () };

const RATE: f64 = 10_000.0;

fn record(drive: &[f64], rule: InterSample, before: Start<()>, factor: usize) -> JointRecord {
    let ends = if before == Start::PERIODIC { RecordEnds::Periodic } else { RecordEnds::Open };
    let (fine, thinning) = fine_drive(drive, (Scheme::BandLimited, true), rule, ends).unwrap();
    JointRecord::new(
        Ingredients {
            drive: fine.as_deref().unwrap_or(drive),
            thinning,
            factor,
            every: 1,
            output: vec![0.0; drive.len()],
            weighting: vec![1.0; drive.len()].into(),
            before,
            transients: false,
            // Nothing is taken off the columns then.
            offset_is_held: true,
            nuisance: Vec::new(),
            cycles: 1,
            degree: 2,
            clock: Clock::Rate(RATE),
            scheme: Scheme::BandLimited,
            sampling: Sampling { reconstruction: rule, ..Sampling::of(Scheme::BandLimited) },
        },
        &Stop::new(),
    )
    .unwrap()
}

/// Columns of u, u² and −ζ, then the derivatives of their sum in everything. What creeps has no steady state.
fn columns(record: &JointRecord, n: f64, creep: Creep) -> Vec<Vec<f64>> {
    let form = DynamicForm { modes: Modes::Fractional, creep };
    let mut dynamics = Linearised::default();
    form.linearise(&[320.0, 0.4, 1.95, 1.02, 0.05, 0.15][..form.parameter_count()], &mut dynamics).unwrap();
    let candidate = Candidate { shape: vec![0.4, 0.1, n], delay_s: 3.37e-4, memory: Vec::new() };
    let mut ws = record.workspace(form.parameter_count());
    record.take_columns(3, &mut ws);
    let wanted = Some(&[true, true, false][..]);
    assert!(record.respond(HysteresisForm::default(), &candidate, 0.7, &dynamics, wanted, &mut ws));
    let samples = record.samples();
    let mut all: Vec<Vec<f64>> = ws.columns.chunks_exact(samples).map(<[f64]>::to_vec).collect();
    record.combine(&[3.0, -0.1, 0.8], &mut ws);
    let dynamic = (0..=form.parameter_count()).map(Direction::Dynamics);
    for direction in [Direction::Shape(0), Direction::Shape(1), Direction::Memory].into_iter().chain(dynamic)
    {
        let mut out = vec![0.0; samples];
        record.differentiate(vec![(Some(direction), &mut out)], &[-0.8], &mut ws);
        assert!(direction == Direction::Memory || out.iter().any(|d| *d != 0.0), "{direction:?}");
        all.push(out);
    }
    all
}

/// Differences of a reduced record's columns from the whole one's, filtered and thinned, over the largest
/// value of each: where F reaches neither end, where it reaches the start, and where it reaches the end.
fn differences(drive: &[f64], rule: InterSample, before: Start<()>, factor: usize, n: f64) -> Vec<[f64; 3]> {
    let periodic = before == Start::PERIODIC;
    let reduction = Reduction::new(factor, drive.len(), periodic);
    let (whole, reduced) = (record(drive, rule, before, 1), record(drive, rule, before, factor));
    assert_eq!(reduced.valid, drive.len().div_ceil(factor));
    let (first, last) = (reduction.lead() + REACH, reduction.lead() + reduced.valid - REACH);
    let creep = if periodic { Creep::None } else { Creep::Fractional };
    let pairs = columns(&whole, n, creep).into_iter().zip(columns(&reduced, n, creep));
    pairs
        .filter(|(whole, _)| whole.iter().any(|x| *x != 0.0))
        .map(|(whole, found)| {
            let mut expected = vec![0.0; reduction.rows()];
            reduction.output(&whole, &mut expected);
            let largest = expected.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let mut off = [0.0f64; 3];
            for (row, (expected, found)) in expected.iter().zip(&found).enumerate() {
                let difference = (expected * reduced.weights()[row] - found).abs() / (factor as f64).sqrt();
                let place = match row {
                    _ if periodic => 0,
                    row if row < first => 1,
                    row => 2 * usize::from(row >= last),
                };
                off[place] = off[place].max(difference / largest);
            }
            off
        })
        .collect()
}

#[test]
fn a_reduced_record_is_the_whole_one_filtered_and_thinned() {
    // Nested loops of sixteen reduced samples a swing, between straight lines, steps and on a smooth curve.
    let drive: Vec<f64> = (0..4001)
        .map(|k| {
            let phase = TAU * f64::from(k) / 256.0;
            5.0 - (3.0 + 1.5 * (0.13 * phase).cos()) * phase.cos() - 0.5 * (1.7 * phase).cos()
        })
        .collect();
    for rule in InterSample::ALL {
        for n in [1.0, 2.0] {
            for (column, off) in differences(&drive, rule, REMEMBERING, 8, n).iter().enumerate() {
                // Derivatives hold more of what is fast. The whole record leaves out what a band-limited
                // response has before its cause; beyond the end inputs have a corner, which the output
                // between reduced samples is known without.
                let tolerance = [if column < 3 { 1e-6 } else { 1e-5 }, 1e-7, 2e-3];
                assert!(
                    off.iter().zip(tolerance).all(|(off, t)| *off < t),
                    "{rule:?} {n}, {column}: {off:?}"
                );
            }
        }
    }
}

#[test]
fn a_reduced_periodic_record_is_exact_up_to_its_ends() {
    let drive: Vec<f64> = (0..2560)
        .map(|k| {
            let phase = TAU * f64::from(k) / 256.0;
            5.0 - 4.0 * phase.cos() - 0.5 * (0.3 * phase).sin()
        })
        .collect();
    for rule in InterSample::ALL {
        for (column, off) in differences(&drive, rule, Start::PERIODIC, 8, 1.0).iter().enumerate() {
            assert!(off[0] < 2e-7, "{rule:?}, {column}: {off:?}");
        }
    }
}

#[test]
fn a_sample_counts_where_the_filter_sees_only_what_counts() {
    let samples = 1000;
    let mut weight = vec![0.5; samples];
    weight[600] = 0.0;
    let factor = 4;
    let half = (REACH * factor) as isize;
    let reduction = Reduction::new(factor, samples, false);
    for (row, found) in reduction.weights(&weight).iter().enumerate() {
        let place = (row as isize - REACH as isize) * factor as isize;
        let reached = |k: isize| (place - half..=place + half).contains(&k);
        let counts = (0..samples as isize).contains(&place) && !reached(600);
        assert_eq!(*found, if counts { 1.0 } else { 0.0 }, "{row}");
    }
}

proptest! {
    #[test]
    fn what_is_slow_goes_through(
        factor in 2usize..20, frequency in 0.0..0.32f64, phase in 0.0..TAU, periods in 3usize..30,
    ) {
        let wave = |t: f64| (TAU * frequency * t + phase).sin();
        let samples = factor * (5 * REACH) + 3;
        let x: Vec<f64> = (0..samples).map(|k| wave(k as f64 / factor as f64)).collect();
        let reduction = Reduction::new(factor, samples, false);
        let mut out = vec![0.0; reduction.rows()];
        reduction.output(&x, &mut out);
        for (k, out) in out.iter().enumerate().take(4 * REACH).skip(2 * REACH) {
            prop_assert!((out - wave(k as f64 - REACH as f64)).abs() < 5e-5);
        }
        // And around the end of a periodic one.
        let samples = factor * 100;
        let wave = |k: usize| (TAU * periods as f64 * k as f64 / samples as f64 + phase).sin();
        let x: Vec<f64> = (0..samples).map(wave).collect();
        let mut out = vec![0.0; 100];
        Reduction::new(factor, samples, true).output(&x, &mut out);
        for (k, out) in out.iter().enumerate() {
            prop_assert!((out - wave(k * factor)).abs() < 5e-5);
        }
    }
}

proptest! {
    /// Samples from the given one on do not change the leading reduced samples, which the samples of the
    /// beginning alone give.
    #[test]
    fn the_beginning_of_a_record_is_reduced_like_the_whole(
        samples in 100..3000_usize, factor in 2..12_usize, share in 0.0..1.2_f64,
    ) {
        let reduction = Reduction::new(factor, samples, false);
        let changed = ((share * samples as f64) as usize).clamp(1, samples);
        let x: Vec<f64> = (0..samples).map(|k| (0.01 * k as f64).sin() + 1e-4 * k as f64).collect();
        let reduced = |x: &[f64], rows: usize| {
            let mut out = vec![0.0; rows];
            reduction.input(x, 0.3, &mut out);
            out
        };
        let whole = reduced(&x, reduction.rows());
        let (rows, needed) = reduction.beginning(changed);
        prop_assert_eq!(&reduced(&x[..needed], rows)[..], &whole[..rows]);
        let mut other = x.clone();
        other[..changed].iter_mut().for_each(|x| *x += 1.0);
        prop_assert_eq!(&reduced(&other, reduction.rows())[rows..], &whole[rows..]);
    }
}

#[test]
fn a_reduced_column_at_the_samples_is_what_it_was_made_of() {
    let slow = |k: usize| 3.0 + 1e-3 * k as f64 + (TAU * k as f64 / 900.0).sin();
    for (samples, periodic) in [(4001, false), (3600, true)] {
        let reduction = Reduction::new(8, samples, periodic);
        let whole: Vec<f64> =
            (0..samples).map(|k| slow(k) - if periodic { 1e-3 * k as f64 } else { 0.0 }).collect();
        let mut reduced = vec![0.0; reduction.rows()];
        reduction.output(&whole, &mut reduced);
        let again = reduction.at_samples(&reduced);
        let ends = if periodic { 0 } else { 8 * REACH };
        assert_eq!(again.len(), samples);
        for k in ends..samples - ends {
            assert!((again[k] - whole[k]).abs() < 1e-3, "{periodic}, {k}: {} {}", again[k], whole[k]);
        }
        assert!(again.iter().all(|x| (1.9..9.0).contains(x)));
    }
}

/// That of white noise, by a long series of it: what is left of the band is about 0.8 of it.
#[test]
fn white_noise_is_known_after_reduction() {
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    for factor in [2, 5, 12] {
        let noise: Vec<f64> = (0..factor * 40_000).map(|_| uniform()).collect();
        let reduction = Reduction::new(factor, noise.len(), false);
        let mut reduced = vec![0.0; reduction.rows()];
        reduction.output(&noise, &mut reduced);
        let products: Vec<f64> = (0..4)
            .map(|lag| reduced[100..39_000].iter().zip(&reduced[100 + lag..]).map(|(a, b)| a * b).sum())
            .collect();
        let expected = positive_sum(&products);
        let time = reduction.correlation_time_of_white();
        assert!((time - expected).abs() < 0.05 && (1.3..1.7).contains(&time), "{factor}: {time} {expected}");
    }
}
