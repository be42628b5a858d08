//! Text of a model file is data in every export, whatever it holds.

use std::path::PathBuf;

use hysteron_export::{
    Inverse, NamedFile, Precision, RUNTIME, Subject, c_files, fmu_files, inverse_files, inverse_fmu_files,
    matlab_files, matlab_inverse_files, rust_files, simulink_files, write_folder,
};
use hysteron_model::compensator::Prediction;
use hysteron_model::model_file::{ScoreEntry, ScoreRole};

use crate::models;
use crate::tools::{STRICT, c_compilers, is_there, run, workspace_of};

/// Input unit, output unit, title and name of a record.
const TEXTS: [[&str; 4]; 4] = [
    ["%n%s", "\"); system(\"x\"); (\"", "*/ #error out /*", "run%d.csv"],
    ["V\\", "??/", "a\\\n#error \\", "C:\\data\\*\\run???/"],
    ["]]>&<\">'", "µ\0\x1b[2J7\r\n\u{85}é", "]]> <!-- & \u{ffff}", "\u{2028}\n//! \n```\npanic!()\n```"],
    ["[x](y)", "`*_~|#", "https://a.b/[c] <d>", "-----\n    code\u{202e}"],
];

/// The stage with hostile texts, and its inverse.
fn stage(name: &str, [input, output, title, record]: [&str; 4], precision: Precision) -> (Subject, Inverse) {
    let model = models::stage();
    let change = |subject: &mut Subject| {
        subject.input_unit = input.into();
        subject.output_unit = output.into();
        subject.title = Some(title.into());
        subject.scores = vec![ScoreEntry {
            record: record.into(),
            role: ScoreRole::Training,
            unit: output.into(),
            samples: 100,
            skipped_samples: 0,
            offset: 0.0,
            rmse: 0.01,
            max_abs_error: 0.02,
            rmse_percent_of_stroke: None,
            max_percent_of_stroke: None,
            fit_percent: None,
            relative_error: None,
            loop_width_error_percent: None,
        }];
    };
    let mut subject = models::subject(name, &model, precision);
    let mut inverse = models::inverse(name, &model, precision, Prediction::Stays);
    change(&mut subject);
    change(&mut inverse.subject);
    (subject, inverse)
}

/// A unit as a self-test prints it.
fn printed(unit: &str) -> String {
    unit.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

#[test]
fn the_c_source_compiles_and_prints_the_text() {
    let place = tempfile::tempdir().unwrap();
    for compiler in c_compilers() {
        for (k, texts) in TEXTS.into_iter().enumerate() {
            let (subject, inverse) = stage("stage", texts, Precision::F32);
            let folder = place.path().join(format!("{compiler}_{k}"));
            write_folder(&folder, &c_files(&subject).unwrap()).unwrap();
            write_folder(&folder, &inverse_files(&inverse).unwrap()).unwrap();
            for (name, unit) in [("stage", texts[1]), ("stage_inverse", texts[0])] {
                let (source, test) = (format!("{name}.c"), format!("{name}_selftest.c"));
                let files = ["-Wformat=2", &source, &test, "-o", "selftest", "-lm"];
                run(&folder, compiler, &[&STRICT[..], &files[..]].concat());
                let said = run(&folder, "./selftest", &[]);
                let unit = printed(unit);
                assert!(said.contains(&format!(" {unit}, allowed ")), "{unit}: {said}");
                assert!(said.contains(&format!("PASSED: {name}")), "{said}");
            }
            // In the S-function too the text is in comments alone.
            let plain = c_files(&subject).unwrap();
            let block = simulink_files(&subject).unwrap().pop().unwrap();
            let text = String::from_utf8(block.bytes).unwrap();
            assert_eq!(plain.len(), 3);
            assert!(text.is_ascii() && text.matches("#include").count() == 5, "{text}");
            let loop_ = ["-Wformat=2", "-c", "stage_inverse_loop.c", "-o", "loop.o"];
            run(&folder, compiler, &[&STRICT[..], &loop_[..]].concat());
        }
    }
}

#[test]
fn the_rust_crate_is_checked_and_documented_without_a_warning() {
    let place = tempfile::tempdir().unwrap();
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let runtime = workspace.join("crates/hysteron-rt");
    let mut members = Vec::new();
    for (k, texts) in TEXTS.into_iter().enumerate() {
        let name = format!("stage_{k}");
        let (subject, inverse) = stage(&name, texts, Precision::F32);
        let mut files = rust_files(&subject, Some(&inverse)).unwrap();
        files.retain(|file| !file.name.starts_with(RUNTIME));
        let manifest = files.iter_mut().find(|f| f.name == "Cargo.toml").unwrap();
        let text = String::from_utf8(manifest.bytes.clone()).unwrap();
        let shared = format!("path = {runtime:?}");
        manifest.bytes = text.replace("[workspace]", "").replace("path = \"runtime\"", &shared).into_bytes();
        write_folder(&place.path().join(&name), &files).unwrap();
        members.push(format!("\"{name}\""));
    }
    std::fs::write(place.path().join("Cargo.toml"), workspace_of(&members)).unwrap();
    let lock = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    std::fs::copy(lock, place.path().join("Cargo.lock")).unwrap();
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("hostile-crates");
    let common = ["--offline", "--workspace", "--target-dir", target.to_str().unwrap()];
    let strict = ["--all-targets", "--", "-D", "warnings"];
    run(place.path(), env!("CARGO"), &[&["clippy"], &common[..], &strict[..]].concat());
    let strict = ["--no-deps", "--config", "build.rustdocflags=[\"-D\", \"warnings\"]"];
    run(place.path(), env!("CARGO"), &[&["doc"], &common[..], &strict[..]].concat());
    // No text became code: the one example of each file is its own.
    let sources = members.iter().map(|name| place.path().join(name.trim_matches('"')).join("src"));
    for source in sources.flat_map(|src| [src.join("lib.rs"), src.join("inverse.rs")]) {
        let text = std::fs::read_to_string(&source).unwrap();
        assert_eq!(text.matches("```").count(), 2, "{}", source.display());
    }
}

/// `modelDescription.xml` of an archive, whose files are stored as they are.
fn description(archive: &NamedFile) -> String {
    let text = String::from_utf8_lossy(&archive.bytes);
    let end = "</fmiModelDescription>";
    let (from, to) = (text.find("<?xml").unwrap(), text.find(end).unwrap() + end.len());
    text[from..to].to_owned()
}

#[test]
fn the_description_of_an_fmu_is_read_back() {
    let Some(compiler) = c_compilers().first().copied() else { return };
    for texts in TEXTS {
        let (subject, inverse) = stage("stage", texts, Precision::F32);
        let forward =
            fmu_files(&subject, compiler).unwrap().into_iter().map(|f| (f, "voltage", "displacement"));
        let backward =
            inverse_fmu_files(&inverse, compiler).unwrap().into_iter().map(|f| (f, "voltage", "reference"));
        for (file, input, output) in forward.chain(backward) {
            let text = description(&file);
            let parsed = roxmltree::Document::parse(&text).unwrap();
            let units: Vec<&str> = parsed
                .descendants()
                .filter(|node| node.has_tag_name("Unit"))
                .map(|node| node.attribute("name").unwrap())
                .collect();
            for (variable, unit) in [(input, texts[0]), (output, texts[1])] {
                let node =
                    parsed.descendants().find(|node| node.attribute("name") == Some(variable)).unwrap();
                let of = node.descendants().find_map(|node| node.attribute("unit")).unwrap();
                assert_eq!(of, printed(unit), "{}", file.name);
                assert_eq!(units.iter().filter(|name| **name == of).count(), 1, "{}: {units:?}", file.name);
            }
            let about = parsed.root_element().attribute("description").unwrap();
            let title = printed(texts[2]).replace('\u{ffff}', "?");
            assert!(about.contains(&title), "{title}: {about}");
        }
    }
}

#[test]
fn octave_runs_the_functions_and_hands_the_text_back() {
    if !is_there("octave-cli", "the exported MATLAB functions were not run with hostile text") {
        return;
    }
    for texts in TEXTS {
        let place = tempfile::tempdir().unwrap();
        let (subject, inverse) = stage("stage", texts, Precision::F64);
        write_folder(place.path(), &matlab_files(&subject).unwrap()).unwrap();
        write_folder(place.path(), &matlab_inverse_files(&inverse).unwrap()).unwrap();
        std::fs::write(
            place.path().join("texts.m"),
            "for f = {@stage_parameters, @stage_inverse_parameters}\n  p = f{1}();\n  \
             for t = {p.input_unit, p.output_unit, p.title}\n    fprintf('%s\\n', t{1});\n  end\nend\n\
             assert(abs(stage(1) - stage(1)) == 0); assert(isfinite(stage_inverse(20)));\n",
        )
        .unwrap();
        let said = run(place.path(), "octave-cli", &["--norc", "--quiet", "--no-history", "texts.m"]);
        let of_one = [texts[0], texts[1], texts[2]].map(printed).join("\n");
        assert_eq!(said, format!("{of_one}\n{of_one}\n"));
    }
}
