//! Single precision: limits are rounded inwards, and a dry run says where the inverse departs.

use hysteron_export::{ExportError, Inverse, Precision, inverse_files, rust_files};
use hysteron_model::compensator::{Compensation, CompensatorOptions, CompensatorParts, Prediction};

use crate::models;

/// The number behind a word in a text.
fn behind(text: &str, word: &str) -> f64 {
    let rest = text.split_once(word).unwrap_or_else(|| panic!("{word}")).1.trim_start();
    let number = rest.trim_start_matches('(').split([' ', ')', ',', '\n', ']']).next().unwrap();
    number.trim_end_matches('f').parse().unwrap_or_else(|_| panic!("{word} {number}"))
}

#[test]
fn limits_of_single_precision_lie_within_those_given() {
    let model = models::stage();
    let subject = models::subject("stage", &model, Precision::F32);
    let options = CompensatorOptions::default();
    let law = Compensation::new(&model, models::RATE_HZ, &options).unwrap();
    let mut moved = [0; 3];
    for k in 0..40 {
        let (low, high) = (0.1 + 0.7 * f64::from(k), 90.1 + 0.1 * f64::from(k));
        let slew = 1e5 + 33.3 * f64::from(k);
        let step = slew / models::RATE_HZ;
        let inverse = Inverse::new(&subject, law.clone(), [low, high], slew).unwrap();
        let files = inverse_files(&inverse).unwrap();
        let header = String::from_utf8(files[0].bytes.clone()).unwrap();
        let crate_files = rust_files(&subject, Some(&inverse)).unwrap();
        let source = crate_files.iter().find(|f| f.name == "src/inverse.rs").unwrap();
        let source = String::from_utf8(source.bytes.clone()).unwrap();
        let limits = source.split_once("const LIMITS: [Real; 3] = [").unwrap().1;
        let of_crate: Vec<f64> =
            limits.split(']').next().unwrap().split(", ").map(|x| x.parse().unwrap()).collect();
        let found = ["_LOW", "_HIGH", "_STEP"]
            .map(|end| behind(&header, &format!("#define STAGE_INVERSE_VOLTAGE{end}")));
        for (found, of_crate) in found.iter().zip(&of_crate) {
            assert_eq!(*found as f32, *of_crate as f32);
        }
        // As numbers of the type.
        let [found_low, found_high, found_step] = found.map(|x| f64::from(x as f32));
        assert!(
            found_low >= low && found_high <= high && found_step <= step,
            "{found:?} {low} {high} {step}"
        );
        moved[0] += usize::from(f64::from(low as f32) < low);
        moved[1] += usize::from(f64::from(high as f32) > high);
        moved[2] += usize::from(f64::from(step as f32) > step);
        let mut parts = CompensatorParts::<f32>::new(&law, [low, high], slew).unwrap();
        let mut compensator = parts.compensator().unwrap();
        for (reference, end) in [(1e3_f32, found_high), (-1e3, found_low)] {
            (0..200).for_each(|_| {
                compensator.step(reference);
            });
            assert_eq!(f64::from(compensator.voltage()), end);
        }
    }
    println!("nearest would lie outside: {moved:?} of 40");
    assert!(moved.iter().all(|count| *count > 5), "{moved:?}");
}

#[test]
fn a_dry_run_of_single_precision_keeps_to_the_tolerance_of_its_vectors() {
    for (name, model) in models::invertible() {
        let inverse = models::inverse(name, &model, Precision::F32, Prediction::Stays);
        let (dry, bound) = (inverse.dry_run, inverse.rounding.bound);
        println!(
            "{name}: {:.1e} along vectors, {:.1e} thrown, {bound:.1e} stated",
            dry.along_vectors, dry.thrown
        );
        assert!(dry.along_vectors <= bound, "{name}");
        assert!(dry.along_vectors > 0.0, "{name}: nothing ran in single precision");
    }
}

/// Laws whose rounding errors add up, or that depart where they are thrown from limit to limit at 1e5 Hz: the
/// header says so and by how much, or nothing is exported.
#[test]
fn a_single_precision_inverse_that_departs_says_so_or_is_refused() {
    let (mut exported, mut drifting, mut thrown, mut refused) = (0, 0, 0, 0);
    for (name, model) in models::invertible() {
        for (rate, bandwidth_hz, slew) in
            [(1e4, Some(2e3), 2e5), (1e5, Some(3e2), f64::INFINITY), (1e5, Some(3e2), 2e6), (1e5, None, 2e6)]
        {
            let Ok(subject) = models::subject_at(name, &model, Precision::F32, rate) else { continue };
            let options = CompensatorOptions { bandwidth_hz, ..CompensatorOptions::default() };
            let Ok(law) = Compensation::new(&model, rate, &options) else { continue };
            let inverse = match Inverse::new(&subject, law, [0.0, 100.0], slew) {
                Ok(inverse) => inverse,
                Err(e) => {
                    println!("{name} at {rate} Hz {bandwidth_hz:?} {slew}: {e}");
                    refused += usize::from(matches!(e, ExportError::Departs { .. }));
                    continue;
                }
            };
            let dry = inverse.dry_run;
            println!(
                "{name} at {rate} Hz {bandwidth_hz:?} {slew}: {:.1e} thrown, {:.1e} along, {:.1e} explained",
                dry.thrown, dry.along_vectors, dry.explained
            );
            assert!(dry.along_vectors <= inverse.rounding.bound, "{name} at {rate} Hz");
            let files = inverse_files(&inverse).unwrap();
            let header = String::from_utf8(files[0].bytes.clone()).unwrap();
            assert_eq!(header.contains("Thrown from limit to limit"), dry.departs(), "{name} at {rate} Hz");
            assert_eq!(header.contains("In a dry run rounding errors"), dry.drifts(), "{name} at {rate} Hz");
            exported += 1;
            drifting += usize::from(dry.drifts());
            thrown += usize::from(dry.departs());
        }
    }
    println!(
        "{exported} exported, {drifting} drift, {thrown} depart where they are thrown, {refused} refused"
    );
    assert!(drifting > 0 && thrown > 0 && refused > 0);
}
