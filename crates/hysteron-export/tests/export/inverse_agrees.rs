//! The inverse in C and `hysteron_rt::Compensator` side by side; every voltage within range and slew,
//! whatever is handed in.

use hysteron_export::{GoldenInverse, Inverse, Precision, inverse_files, write_folder};
use hysteron_model::compensator::{CompensatorParts, Prediction};
use hysteron_rt::{Limited, Real};
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::c_agrees::{Answer, exchange};
use crate::models;
use crate::tools::{STRICT, c_compilers, choices, pairs, run};

#[derive(Clone, Copy, Debug)]
enum Call {
    Step(f64),
    RestAfter(f64, f64),
    MeasuredAtRest(f64),
}

/// A smooth reference, with steps beyond the range, holds and bad numbers in between.
fn calls(seed: u64, count: usize, largest: f64) -> Vec<Call> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut out = vec![Call::RestAfter(0.0, 50.0)];
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, largest, -largest];
    let (mut centre, mut phase) = (14.0_f64, 0.0_f64);
    while out.len() < count {
        match random.random_range(0..12) {
            0 => out.push(Call::Step(bad[random.random_range(0..5_usize)])),
            1 => out.push(Call::RestAfter(bad[random.random_range(0..3_usize)], 10.0)),
            2 => out.push(Call::MeasuredAtRest(bad[random.random_range(0..3_usize)])),
            3 => {
                let at: f64 = random.random_range(-20.0..120.0);
                out.push(Call::RestAfter(random.random_range(0.0..100.0), at));
                out.push(Call::MeasuredAtRest(0.3 * at));
            }
            4 => centre = random.random_range(-10.0..50.0),
            5 => out.extend(std::iter::repeat_n(Call::Step(centre), 30)),
            _ => {
                let (size, pace) = (random.random_range(0.0..12.0), random.random_range(0.001..0.3));
                out.extend((0..40).map(|_| {
                    phase += pace;
                    Call::Step(centre + size * phase.sin())
                }));
            }
        }
    }
    out
}

fn of_runtime<T: Real + Into<f64>>(inverse: &Inverse, calls: &[Call]) -> Vec<Answer> {
    let mut parts =
        CompensatorParts::<T>::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s).unwrap();
    let mut compensator = parts.compensator().unwrap();
    let mut u = 0.0;
    let answer = |call: &Call| {
        let status = match *call {
            Call::Step(reference) => {
                let drive = compensator.step(T::of(reference));
                u = drive.voltage.into();
                match drive.limited {
                    Limited::No => 0.0,
                    Limited::Range => 1.0,
                    Limited::Step => 2.0,
                    Limited::Reference => -1.0,
                    Limited::Overflow => -2.0,
                }
            }
            Call::RestAfter(virgin, voltage) => {
                if compensator.rest_after(T::of(virgin), T::of(voltage)).is_ok() { 0.0 } else { -1.0 }
            }
            Call::MeasuredAtRest(y) => {
                if compensator.measured_at_rest(T::of(y)).is_ok() {
                    0.0
                } else {
                    -1.0
                }
            }
        };
        (status, u)
    };
    calls.iter().map(answer).collect()
}

#[test]
fn the_inverse_is_the_runtime_s_and_keeps_to_its_limits() {
    let place = tempfile::tempdir().unwrap();
    let laws = [
        (Precision::F64, Prediction::Stays),
        (Precision::F32, Prediction::Band { highest_hz: 100.0, noise: 1e-3 }),
    ];
    let all = pairs(&laws, &c_compilers());
    for (k, (name, model)) in models::invertible().into_iter().enumerate() {
        for ((precision, prediction), compiler) in choices(&all, k) {
            let inverse = models::inverse(name, &model, precision, prediction);
            let tolerance = GoldenInverse::new(&inverse).unwrap().tolerance;
            let folder = place.path().join(format!("{name}_{}_{compiler}", precision.name()));
            write_folder(&folder, &inverse_files(&inverse).unwrap()).unwrap();
            let own = format!("{name}_inverse");
            let driver = include_str!("inverse_driver.c").replace("MODEL", &own);
            std::fs::write(folder.join("driver.c"), driver).unwrap();
            let (source, test, around) =
                (format!("{own}.c"), format!("{own}_selftest.c"), format!("{own}_loop.c"));
            let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
            for (flags, main, program) in [
                (&["-O2"][..], &test, "selftest"),
                (&sanitized[..], &test, "selftest_sanitized"),
                (&sanitized[..], &"driver.c".to_owned(), "driver"),
            ] {
                let mut arguments = [&STRICT[..], flags, &[&source, main, "-o", program]].concat();
                arguments.push("-lm");
                run(&folder, compiler, &arguments);
            }
            run(&folder, compiler, &[&STRICT[..], &["-c", &around]].concat());
            for program in ["./selftest", "./selftest_sanitized"] {
                let said = run(&folder, program, &[]);
                println!("{} {compiler}: {}", precision.name(), said.lines().next().unwrap());
                assert!(said.contains(&format!("PASSED: {own}")), "{said}");
            }
            let largest = if precision == Precision::F32 { f64::from(f32::MAX) } else { f64::MAX };
            let calls = calls(3, 60_000, largest);
            let rust = match precision {
                Precision::F32 => of_runtime::<f32>(&inverse, &calls),
                Precision::F64 => of_runtime::<f64>(&inverse, &calls),
            };
            let sent = calls.iter().map(|call| match *call {
                Call::Step(r) => [0.0, r, 0.0],
                Call::RestAfter(virgin, u) => [1.0, virgin, u],
                Call::MeasuredAtRest(y) => [2.0, y, 0.0],
            });
            let c = exchange(&folder.join("driver"), sent);
            assert_eq!(c.len(), calls.len());
            let [low, high] = inverse.range_v;
            let step = inverse.slew_v_per_s / inverse.compensation.sample_rate_hz;
            let (mut worst, mut limited, mut last) = (0.0_f64, 0, None);
            for (k, ((call, rust), c)) in calls.iter().zip(&rust).zip(&c).enumerate() {
                assert_eq!(c.0, rust.0, "{name} {k}: {call:?} {rust:?} {c:?}");
                worst = worst.max((c.1 - rust.1).abs());
                assert!(c.1 >= low && c.1 <= high, "{k}: {c:?}");
                match (call, last) {
                    (Call::Step(_), Some(before)) => {
                        let change: f64 = c.1 - before;
                        assert!(change.abs() <= step + 8.0 * precision.epsilon() * high, "{k}: {change}");
                        last = Some(c.1);
                    }
                    (Call::Step(_), None) => last = Some(c.1),
                    // At rest somewhere else.
                    (Call::RestAfter(..), _) => last = None,
                    _ => {}
                }
                limited += usize::from(c.0 != 0.0);
            }
            assert!(limited > 1000, "{limited}");
            println!(
                "{name} {} {compiler}: {worst:.1e} V, allowed {tolerance:.1e}; {limited} limited or \
                 refused",
                precision.name()
            );
            assert!(worst <= tolerance, "{name}: {worst:e}");
        }
    }
}
