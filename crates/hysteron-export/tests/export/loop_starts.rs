//! The example loop takes a stage over wherever a power cycle left it: no step above the slew limit, and the
//! reference is met.

use hysteron_export::{Inverse, Precision, c_files, inverse_files, write_folder};
use hysteron_model::compensator::{Compensation, CompensatorOptions};

use crate::models::{self, RATE_HZ};
use crate::tools::{STRICT, c_compilers, run};

#[test]
fn the_loop_starts_after_a_power_cycle() {
    let Some(compiler) = c_compilers().first().copied() else { return };
    let place = tempfile::tempdir().unwrap();
    let model = models::stage();
    for precision in [Precision::F64, Precision::F32] {
        let subject = models::subject("stage", &model, precision);
        let compensation = Compensation::new(&model, RATE_HZ, &CompensatorOptions::default()).unwrap();
        // 2 V a sample.
        let inverse = Inverse::new(&subject, compensation, [0.0, 100.0], 2.0 * RATE_HZ).unwrap();
        let folder = place.path().join(precision.name());
        write_folder(&folder, &c_files(&subject).unwrap()).unwrap();
        write_folder(&folder, &inverse_files(&inverse).unwrap()).unwrap();
        let driver = include_str!("loop_driver.c").replace("MODEL", "stage");
        std::fs::write(folder.join("driver.c"), driver).unwrap();
        let sources = ["stage.c", "stage_inverse.c", "stage_inverse_loop.c", "driver.c", "-o", "loop", "-lm"];
        let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
        run(&folder, compiler, &[&STRICT[..], &sanitized, &sources].concat());
        // Tolerances [um]: what the hysteresis remembers is known where it came up without turning; else up
        // to twice the memory's largest, 1.33 um.
        for (peak, at, known, tolerance) in [
            ("6", "6", "1", 0.01),
            ("6", "6", "0", 0.5),
            ("60", "6", "1", 2.67),
            ("60", "6", "0", 2.67),
            // Put out beyond the limits.
            ("112", "112", "1", 2.67),
        ] {
            let said = run(&folder, "./loop", &[peak, at, known, "14", "40000"]);
            let numbers: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
            println!("{} from {peak} V by {at} V, known {known}: {said}", precision.name());
            let [step, displacement, alarms] = numbers[..] else { unreachable!() };
            assert!(step <= 2.0 + 64.0 * precision.epsilon(), "{said}");
            assert!((displacement - 14.0).abs() <= tolerance, "{peak} {at} {known}: {said}");
            assert!(alarms == 0.0, "{said}");
        }
    }
}
