//! The C source on a Cortex-M4F and a Cortex-M7, run by a simulator: the self-test passes; instructions,
//! flash, RAM and stack are printed.

use std::path::Path;

use hysteron_export::{Precision, c_files, inverse_files, write_folder};
use hysteron_model::compensator::Prediction;

use crate::models::{self, PRECISIONS};
use crate::tools::{STRICT, choices, is_there, run, skipped};

const COMPILER: &str = "arm-none-eabi-gcc";
const SIMULATOR: &str = "qemu-system-arm";

struct Board {
    name: &'static str,
    machine: &'static str,
    flags: [&'static str; 4],
}

const BOARDS: [Board; 2] = [
    Board {
        name: "Cortex-M4F",
        machine: "mps2-an386",
        flags: ["-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"],
    },
    Board {
        name: "Cortex-M7",
        machine: "mps2-an500",
        flags: ["-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-d16", "-mfloat-abi=hard"],
    },
];

/// The C library with the simulator's input and output.
fn has_newlib(without: &str) -> bool {
    let found = run(Path::new("."), COMPILER, &["-print-file-name=rdimon.specs"]).contains('/');
    if !found {
        skipped("newlib for arm-none-eabi", without);
    }
    found
}

fn simulate(folder: &Path, board: &Board, program: &str) -> String {
    let arguments = [
        "-machine",
        board.machine,
        "-display",
        "none",
        "-monitor",
        "none",
        "-serial",
        "none",
        "-icount",
        "shift=0",
        "-semihosting-config",
        "enable=on,target=native",
        "-kernel",
        program,
    ];
    run(folder, SIMULATOR, &arguments)
}

#[test]
fn the_selftest_passes_on_the_microcontrollers() {
    let without = "the exported C was not tried on microcontrollers";
    if !is_there(COMPILER, without) || !is_there(SIMULATOR, without) || !has_newlib(without) {
        return;
    }
    let place = tempfile::tempdir().unwrap();
    for (k, (name, model)) in models::all().into_iter().enumerate() {
        if ![
            "stage",
            "quadratic",
            "power",
            "plays",
            "krasnoselskii_pokrovskii",
            "preisach_density",
            "duhem",
            "jiles_atherton",
        ]
        .contains(&name)
        {
            continue;
        }
        for precision in choices(&PRECISIONS, k) {
            let folder = place.path().join(format!("{name}_{}", precision.name()));
            let inverse = models::inverse(name, &model, precision, Prediction::Stays);
            write_folder(&folder, &c_files(&models::subject(name, &model, precision)).unwrap()).unwrap();
            write_folder(&folder, &inverse_files(&inverse).unwrap()).unwrap();
            let own = format!("{name}_inverse");
            for (file, text) in [
                ("mps2.ld", include_str!("arm/mps2.ld")),
                ("startup.c", include_str!("arm/startup.c")),
                ("count.c", &include_str!("arm/count.c").replace("MODEL", name).replace("SCALE", "1")),
                (
                    "count_inverse.c",
                    &include_str!("arm/count.c").replace("MODEL", &own).replace("SCALE", "0.3"),
                ),
            ] {
                std::fs::write(folder.join(file), text).unwrap();
            }
            for (board, (name, counter)) in
                BOARDS.iter().flat_map(|b| [(b, (name, "count.c")), (b, (own.as_str(), "count_inverse.c"))])
            {
                println!("{}", measure(&folder, board, name, precision, counter));
            }
        }
    }
}

fn measure(folder: &Path, board: &Board, name: &str, precision: Precision, counter: &str) -> String {
    let (source, test) = (format!("{name}.c"), format!("{name}_selftest.c"));
    let own = ["-O2", "-fstack-usage", "-c", &source, "-o", "model.o"];
    run(folder, COMPILER, &[&STRICT[..], &board.flags, &own].concat());
    for (main, program) in [(test.as_str(), "selftest.elf"), (counter, "count.elf")] {
        let sections = ["-std=c99", "-O2", "-ffunction-sections", "-Wl,--gc-sections"];
        let library = ["--specs=rdimon.specs", "-nostartfiles", "-T", "mps2.ld"];
        let files = ["startup.c", main, "model.o", "-lm", "-o", program];
        run(folder, COMPILER, &[&sections[..], &board.flags, &library, &files].concat());
    }
    let said = simulate(folder, board, "selftest.elf");
    assert!(said.contains(&format!("PASSED: {name}")), "{}: {said}", board.name);
    let counted = simulate(folder, board, "count.elf");
    let sizes = run(folder, "arm-none-eabi-size", &["model.o"]);
    let flash = sizes.lines().nth(1).and_then(|l| l.split_whitespace().next()).unwrap_or("?").to_owned();
    let usage = std::fs::read_to_string(folder.join("model.su")).unwrap();
    let stack = usage.lines().filter_map(|l| l.split('\t').nth(1)?.parse::<u32>().ok()).sum::<u32>();
    format!(
        "{} {name} {}: {}; flash {flash} bytes without <math.h>, stack {stack} bytes (all functions, without \
         <math.h>); {}",
        board.name,
        precision.name(),
        counted.trim(),
        said.lines().next().unwrap_or_default()
    )
}
