use hysteron_rt::Limited;

use super::*;
use crate::hysteresis::{Columns, DriveGrid, DriveLimits, HysteresisError};
use crate::start::Start;

/// A drive with minor loops, on a grid finer by 2 where every other sample is read.
fn drive() -> Vec<f64> {
    (0..400)
        .map(|k| {
            let t = f64::from(k) * 0.05;
            4.0 + 3.0 * t.sin() + 1.7 * (2.3 * t + 0.4).sin()
        })
        .collect()
}

/// Seconds between samples of the drive.
const INTERVAL_S: f64 = 0.05;

fn every(factor: usize) -> DriveGrid<'static> {
    DriveGrid { factor, interval_s: Some(INTERVAL_S), paces: None }
}

/// Every family with a few elements, and the default one with another exponent.
fn forms() -> Vec<(HysteresisForm, Vec<f64>)> {
    let families = examples([-1.03, 9.21], 10.0, 1.0).unwrap();
    let power = (HysteresisForm::default(), vec![0.4, -0.1, 1.6]);
    families.into_iter().map(|family| (family.form(), family.shape())).chain([power]).collect()
}

/// A play by its definition: value, ∂/∂(threshold), ∂/∂(voltage at which it was virgin).
fn moved([value, by_threshold, by_virgin]: [f64; 3], threshold: f64, u: f64) -> [f64; 3] {
    if value < u - threshold {
        [u - threshold, -1.0, 0.0]
    } else if value > u + threshold {
        [u + threshold, 1.0, 0.0]
    } else {
        [value, by_threshold, by_virgin]
    }
}

#[test]
fn plays_and_their_derivatives_are_those_of_the_definition_to_the_last_bit() {
    let form = HysteresisForm::plays(3);
    let (shape, virgin, rest) = ([0.4, 1.3, 2.9], 3.4, 4.2);
    let origin = Start::Remembering { voltage_v: rest, memory: virgin };
    let columns = run(form, &shape, 2, origin, true);
    // With thresholds that are held, the derivatives end where the drive has moved a play.
    let (mut held, drive_v) = (Columns::default(), drive());
    form.run(&shape, every(2), &drive_v, origin, Some(&[false; 3]), &mut held).unwrap();
    assert_eq!(held.values, columns.values);
    assert!(held.partials.is_empty());
    for (whole, short) in columns.by_memory.iter().zip(&held.by_memory) {
        let (begin, rest) = whole.split_at(short.len());
        assert_eq!(begin, short);
        assert!(rest.iter().all(|x| *x == 0.0) && !rest.is_empty());
    }
    for (j, &threshold) in shape.iter().enumerate() {
        let mut play = moved([virgin, 0.0, 1.0], threshold, rest);
        assert_eq!([columns.rest[j], columns.partials[j].rest, columns.rest_by_memory[j]], play);
        for (k, u) in drive().into_iter().enumerate() {
            play = moved(play, threshold, u);
            if k % 2 == 0 {
                let (values, partials) = (&columns.values[j], &columns.partials[j].values);
                assert_eq!([values[k / 2], partials[k / 2], columns.by_memory[j][k / 2]], play);
            }
        }
    }
}

fn run(form: HysteresisForm, shape: &[f64], factor: usize, origin: Start<f64>, derivatives: bool) -> Columns {
    let mut out = Columns::default();
    let wanted = vec![true; shape.len()];
    form.run(shape, every(factor), &drive(), origin, derivatives.then_some(&wanted[..]), &mut out).unwrap();
    out
}

const ORIGINS: [Start<f64>; 3] =
    [Start::Rest { voltage_v: 2.0 }, Start::Remembering { voltage_v: 4.2, memory: 3.4 }, Start::PERIODIC];

#[test]
fn columns_add_up_to_the_operator() {
    for (form, shape) in forms() {
        for origin in ORIGINS {
            let weights: Vec<f64> = (1..=form.columns()).map(|j| 0.7 / j as f64).collect();
            let columns = run(form, &shape, 2, origin, false);
            let operator = form.operator(vec![1.0, 0.1], &weights, &shape).unwrap();
            let own = match origin {
                Start::Remembering { voltage_v: rest, memory } => {
                    Start::Remembering { voltage_v: rest, memory: form.own_memory(memory, &weights) }
                }
                other => other,
            };
            let u = drive();
            let mut v = vec![0.0; u.len() / 2];
            operator.simulate_every(every(2), &u, own, &mut v).unwrap();
            for (k, v) in v.iter().enumerate() {
                let sum: f64 = weights.iter().zip(&columns.values).map(|(w, h)| w * h[k]).sum();
                let u = u[2 * k];
                let expected = u + 0.1 * u * u + form.sign() * sum;
                assert!((v - expected).abs() < 1e-12 * expected.abs().max(1.0), "{form:?} {origin:?} {k}");
            }
            if let Start::Remembering { voltage_v: rest, memory } = origin {
                let sum: f64 = weights.iter().zip(&columns.rest).map(|(w, h)| w * h).sum();
                let at_rest = operator.at_rest(rest, Some(form.own_memory(memory, &weights)));
                let expected = rest + 0.1 * rest * rest + form.sign() * sum;
                assert!((at_rest - expected).abs() < 1e-12, "{form:?}");
            }
            let again = operator.form().operator(
                operator.polynomial().to_vec(),
                operator.weights(),
                &operator.shape(),
            );
            let mut same = vec![0.0; v.len()];
            again.unwrap().simulate_every(every(2), &u, own, &mut same).unwrap();
            assert!(v.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-12 * a.abs().max(1.0)));
        }
    }
}

#[test]
fn derivatives_are_those_of_the_columns() {
    const STEP: f64 = 1e-6;
    for (form, shape) in forms() {
        for origin in ORIGINS {
            let columns = run(form, &shape, 2, origin, true);
            let plain = run(form, &shape, 2, origin, false);
            for (a, b) in columns.values.iter().flatten().zip(plain.values.iter().flatten()) {
                assert!((a - b).abs() < 1e-12 * a.abs().max(1.0), "{form:?} {origin:?}: {a} {b}");
            }
            for p in 0..shape.len() {
                let moved = |by: f64| {
                    let mut shape = shape.clone();
                    shape[p] += by;
                    run(form, &shape, 2, origin, false)
                };
                // The grid of a plane is structure.
                if ["low", "high"].contains(&form.shape_names()[p].as_str()) {
                    continue;
                }
                let n_at_its_end = form == HysteresisForm::default() && p == 2 && shape[p] == 1.0;
                if n_at_its_end {
                    continue;
                }
                let (up, down) = (moved(STEP), moved(-STEP));
                for j in 0..form.columns() {
                    let found = columns.partials.iter().find(|q| (q.shape, q.column) == (p, j));
                    let difference = |k: usize| (up.values[j][k] - down.values[j][k]) / (2.0 * STEP);
                    for k in 0..columns.values[j].len() {
                        let analytic = found.map_or(0.0, |q| q.values[k]);
                        assert!(
                            (analytic - difference(k)).abs() < 1e-6 * analytic.abs().max(1.0),
                            "{form:?} {origin:?} θ{p} column {j} sample {k}: {analytic} {}",
                            difference(k)
                        );
                    }
                    let rest = (up.rest[j] - down.rest[j]) / (2.0 * STEP);
                    assert!((found.map_or(0.0, |q| q.rest) - rest).abs() < 1e-6);
                }
            }
            if let Start::Remembering { voltage_v: rest, memory } = origin {
                let moved = |by| {
                    run(form, &shape, 2, Start::Remembering { voltage_v: rest, memory: memory + by }, false)
                };
                let (up, down) = (moved(STEP), moved(-STEP));
                for j in 0..form.columns() {
                    for k in 0..columns.values[j].len() {
                        let difference = (up.values[j][k] - down.values[j][k]) / (2.0 * STEP);
                        assert!(
                            (columns.by_memory[j].get(k).unwrap_or(&0.0) - difference).abs() < 1e-6,
                            "{form:?} column {j} sample {k}"
                        );
                    }
                    let at_rest = (up.rest[j] - down.rest[j]) / (2.0 * STEP);
                    assert!((columns.rest_by_memory[j] - at_rest).abs() < 1e-6);
                }
            }
        }
    }
}

/// Every family with numbers for which its branches rise.
fn rising() -> impl Iterator<Item = Hysteresis> {
    let power = HysteresisForm::default().operator(vec![6.0, 0.01], &[0.7], &[0.4, -0.1, 1.6]).unwrap();
    examples([-1.03, 9.21], 10.0, 6.0).unwrap().into_iter().chain([power])
}

const FREE: DriveLimits =
    DriveLimits { range: [-2.0, 10.0], step: f64::INFINITY, interval_s: Some(INTERVAL_S) };

#[test]
fn the_drive_that_gives_an_output_is_found_in_one_step() {
    for operator in rising() {
        let u = drive();
        for memory in [None, Some(operator.form().own_memory(3.4, operator.weights()))] {
            let rest = 4.2;
            let origin = match memory {
                None => Start::Rest { voltage_v: rest },
                Some(memory) => Start::Remembering { voltage_v: rest, memory },
            };
            let mut v = vec![0.0; u.len()];
            operator.simulate_every(every(1), &u, origin, &mut v).unwrap();
            let followed = operator.follow(&v, rest, memory, &FREE);
            let followed = followed.unwrap_or_else(|e| panic!("{operator:?}: {e}"));
            assert_eq!(followed.count(Limited::No), u.len(), "{operator:?}");
            for (k, ((found, u), (output, v))) in
                followed.drive.iter().zip(&u).zip(followed.output.iter().zip(&v)).enumerate()
            {
                assert!(
                    (output - v).abs() < 1e-13 * v.abs().max(1.0),
                    "{operator:?} sample {k}: {output} {v}"
                );
                assert!((found - u).abs() < 1e-9, "{operator:?} sample {k}: {found} {u}");
            }
        }
    }
}

#[test]
fn a_drive_keeps_to_its_limits() {
    for operator in rising() {
        let mut v = vec![0.0; drive().len()];
        operator.simulate_every(every(1), &drive(), Start::Rest { voltage_v: 4.2 }, &mut v).unwrap();
        let limits = DriveLimits { range: [1.0, 6.5], step: 0.11, ..FREE };
        let followed = operator.follow(&v, 4.2, None, &limits).unwrap();
        for by in [Limited::Range, Limited::Step] {
            assert!(followed.count(by) > 0, "{operator:?} {by:?}");
        }
        let mut last = 4.2;
        for &u in &followed.drive {
            assert!((1.0..=6.5).contains(&u) && (u - last).abs() <= 0.11 * (1.0 + 1e-12));
            last = u;
        }
        let mut again = vec![0.0; v.len()];
        operator
            .simulate_every(every(1), &followed.drive, Start::Rest { voltage_v: 4.2 }, &mut again)
            .unwrap();
        for (a, b) in again.iter().zip(&followed.output) {
            assert!((a - b).abs() < 1e-12 * b.abs().max(1.0), "{operator:?}");
        }
    }
}

#[test]
fn what_falls_as_the_voltage_rises_is_not_inverted() {
    // Behind a turning point the slope is 0.5 − 0.7 (1 + (β' − γ') |ζ|) < 0.
    let operator = HysteresisForm::default().operator(vec![0.5], &[0.7], &[0.4, 0.1, 1.0]).unwrap();
    let refused = operator.follow(&[2.0, 3.0, 2.5, 2.0], 0.0, None, &FREE);
    assert!(matches!(refused, Err(HysteresisError::NotIncreasing { .. })), "{refused:?}");
    let operator = HysteresisForm::default().operator(vec![1.0], &[0.2], &[0.4, 0.1, 1.0]).unwrap();
    for (wanted, rest, limits) in [
        (f64::NAN, 0.0, FREE),
        (1.0, 11.0, FREE),
        (1.0, f64::NAN, FREE),
        (1.0, 0.0, DriveLimits { range: [1.0, 1.0], ..FREE }),
        (1.0, 0.0, DriveLimits { step: 0.0, ..FREE }),
        (1.0, 0.0, DriveLimits { step: f64::NAN, ..FREE }),
    ] {
        assert!(operator.follow(&[wanted], rest, None, &limits).is_err(), "{wanted} {rest} {limits:?}");
    }
}

#[test]
fn another_number_of_shape_numbers_is_refused() {
    let run =
        HysteresisForm::default().run(&[1.0], 1, &[0.0], Start::PERIODIC, None, &mut Columns::default());
    assert!(matches!(run, Err(HysteresisError::ShapeCount { expected: 3, found: 1 })));
}

#[test]
fn every_family_is_parsed_from_its_name_and_described() {
    for form in HysteresisForm::usual() {
        assert_eq!(form.name().parse(), Ok(form));
        assert!(!form.summary().is_empty());
    }
    let (misspelt, last) = ("plasticity", HysteresisForm::usual().pop().unwrap().name());
    let unknown = misspelt.parse::<HysteresisForm>().unwrap_err().to_string();
    assert!(unknown.contains("`plasticity`") && unknown.contains(last), "{unknown}");
}

#[test]
fn numbers_that_shape_a_loop_together_are_of_one_unit_and_name_each_other() {
    for form in HysteresisForm::usual() {
        let numbers = form.shape_numbers(&DriveSpan::UNIT);
        for index in 0..numbers.len() {
            let together = form.description().shapes_together_with(index);
            assert!(together.contains(&index) && together.end <= numbers.len(), "{form:?} {index}");
            for other in together.clone() {
                assert_eq!(numbers[other].unit, numbers[index].unit, "{form:?} {index}");
                assert_eq!(form.description().shapes_together_with(other), together);
            }
        }
    }
}

#[test]
fn elements_beyond_a_family_are_refused() {
    for form in HysteresisForm::usual() {
        match form.description().elements() {
            None => assert!(form.with_elements(1).is_err(), "{form:?}"),
            Some(Elements { usual, most }) => {
                assert_eq!(form.elements(), usual);
                assert_eq!(form.with_elements(most).unwrap().elements(), most);
                assert!(form.with_elements(0).is_err() && form.with_elements(most + 1).is_err(), "{form:?}");
            }
        }
    }
}

/// Without a start of its own at rest at the first sample, and settled on the whole drive alone.
#[test]
fn a_start_means_the_same_for_every_family() {
    let u = drive();
    let whole = u.len();
    for (form, shape) in forms() {
        let operator = form.operator(vec![1.0], &vec![0.1; form.columns()], &shape).unwrap();
        let run = |start| {
            let mut v = vec![0.0; whole];
            operator.simulate_every(every(1), &u, start, &mut v).map(|()| v)
        };
        let name = form.name();
        assert_eq!(run(Start::AsIdentified), run(Start::Rest { voltage_v: u[0] }), "{name}");
        assert_eq!(run(Start::settled(whole)), run(Start::PERIODIC), "{name}");
        let half = HysteresisError::Period { samples: whole, period_samples: whole / 2 };
        assert_eq!(run(Start::settled(whole / 2)), Err(half), "{name}");
    }
}
