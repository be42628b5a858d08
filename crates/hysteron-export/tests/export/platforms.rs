//! The binaries of a unit for other platforms, loaded by a small master: the Windows one under wine, the
//! aarch64 one under QEMU, each with the displacements of the library.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use hysteron_export::{Golden, GoldenInverse, NamedFile, Platform, Precision, fmu_files, inverse_fmu_files};
use hysteron_model::compensator::{CompensatorParts, Prediction};
use hysteron_model::realise::RuntimeParts;

use crate::models::{self, PRECISIONS, RATE_HZ};
use crate::tools::{choices, is_there, run, skipped};

/// A platform here: its compiler, the program that runs its programs and the libraries for it.
struct Foreign {
    platform: Platform,
    runner: &'static [&'static str],
    folders: [&'static str; 2],
    library: &'static str,
    flags: &'static [&'static str],
}

fn platforms() -> [Foreign; 2] {
    [
        Foreign {
            platform: Platform::Windows,
            runner: &["wine"],
            folders: ["binaries/win64", "binaries/x86_64-windows"],
            library: "dll",
            flags: &["-static-libgcc"],
        },
        Foreign {
            platform: Platform::LinuxArm,
            runner: &["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"],
            folders: ["binaries/aarch64-linux"; 2],
            library: "so",
            flags: &["-ldl"],
        },
    ]
}

/// The token of a unit's description.
pub fn token(description: &str) -> String {
    let after = |key: &str| description.split_once(key).map(|(_, rest)| rest.split('"').next().unwrap());
    after("guid=\"").or_else(|| after("instantiationToken=\"")).unwrap().to_owned()
}

/// What the binary of `unit` puts out for these inputs.
fn of_binary(folder: &Path, unit: &NamedFile, version: usize, foreign: &Foreign, inputs: &[f64]) -> Vec<f64> {
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&unit.bytes)).unwrap();
    archive.extract(folder).unwrap();
    let description = std::fs::read_to_string(folder.join("modelDescription.xml")).unwrap();
    let libraries = folder.join(foreign.folders[version - 2]);
    let library = std::fs::read_dir(&libraries).unwrap().next().unwrap().unwrap().path();
    assert_eq!(library.extension().unwrap(), foreign.library);
    std::fs::write(folder.join("master.c"), include_str!("master.c")).unwrap();
    let (fmi, rate) = (format!("-DFMI={version}"), format!("-DRATE_HZ={RATE_HZ:e}"));
    let flags = ["-std=c99", "-D_GNU_SOURCE", &fmi, &rate, "master.c", "-o", "master.exe"];
    run(folder, foreign.platform.cross_compiler(), &[&flags[..], foreign.flags].concat());
    let mut child = Command::new(foreign.runner[0])
        .args(&foreign.runner[1..])
        .args(["./master.exe", library.strip_prefix(folder).unwrap().to_str().unwrap(), &token(&description)])
        .current_dir(folder)
        .env("WINEDEBUG", "-all")
        .env("WINEPREFIX", folder.parent().unwrap().join("wine"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let bytes: Vec<u8> = inputs.iter().flat_map(|x| x.to_le_bytes()).collect();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(&bytes));
    let output = child.wait_with_output().unwrap();
    let written = writer.join().unwrap();
    assert!(output.status.success() && written.is_ok(), "{:?}: {}", foreign.platform, output.status);
    output.stdout.chunks_exact(8).map(|x| f64::from_le_bytes(x.try_into().unwrap())).collect()
}

/// The platforms that can be compiled for and run here; says which not.
fn runnable() -> Vec<Foreign> {
    let here = |foreign: &Foreign| {
        let words = foreign.platform.words();
        is_there(foreign.platform.cross_compiler(), &format!("the units have no binary for {words}"))
            && is_there(foreign.runner[0], &format!("the binary for {words} was not run"))
    };
    platforms().into_iter().filter(here).collect()
}

#[test]
fn binaries_of_other_platforms_put_out_what_the_library_does() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) {
        return skipped("64-bit Linux on x86-64", "binaries of other platforms were not run");
    }
    let place = tempfile::tempdir().unwrap();
    for foreign in runnable() {
        for (name, model) in models::all() {
            if !["stage", "quadratic", "preisach_density"].contains(&name) {
                continue;
            }
            for precision in choices(&PRECISIONS, usize::from(name == "stage")) {
                let subject = models::subject(name, &model, precision);
                let golden = Golden::new(&subject).unwrap();
                let mut parts = RuntimeParts::<f64>::new(&subject.realisation).unwrap();
                let mut library = parts.model().unwrap();
                library.rest_at(golden.voltages[0]).unwrap();
                let wanted: Vec<f64> = golden.voltages.iter().map(|&u| library.step(u).unwrap()).collect();
                let units = fmu_files(&subject, "cc").unwrap();
                let worst =
                    judge(place.path(), &units, &foreign, &golden.voltages, &wanted, golden.tolerance);
                let (words, of) = (foreign.platform.words(), precision.name());
                println!("{words}, {name} {of}: {worst:.1e} um, allowed {:.1e}", golden.tolerance);
            }
        }
        let inverse = models::inverse("stage", &models::stage(), Precision::F64, Prediction::Stays);
        let golden = GoldenInverse::new(&inverse).unwrap();
        let mut parts =
            CompensatorParts::<f64>::new(&inverse.compensation, inverse.range_v, inverse.slew_v_per_s)
                .unwrap();
        let mut library = parts.compensator().unwrap();
        library.rest_at(0.0).unwrap();
        let wanted: Vec<f64> = golden.references.iter().map(|&r| library.step(r).voltage).collect();
        let units = inverse_fmu_files(&inverse, "cc").unwrap();
        let worst = judge(place.path(), &units, &foreign, &golden.references, &wanted, golden.tolerance);
        println!("{}, inverse: {worst:.1e} V, allowed {:.1e}", foreign.platform.words(), golden.tolerance);
    }
}

/// Largest difference of the binaries of both versions.
fn judge(
    place: &Path,
    units: &[NamedFile],
    foreign: &Foreign,
    inputs: &[f64],
    wanted: &[f64],
    tolerance: f64,
) -> f64 {
    let mut largest = 0.0_f64;
    for (version, unit) in (2..).zip(units) {
        let folder = place.join("unit");
        std::fs::create_dir_all(&folder).unwrap();
        let found = of_binary(&folder, unit, version, foreign, inputs);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(found.len(), wanted.len());
        let worst = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= tolerance, "{:?} {}: {worst:e} {tolerance:e}", foreign.platform, unit.name);
        largest = largest.max(worst);
    }
    largest
}
