//! Controllers with feedback and observer in C, Rust and FMUs: without a warning, and the voltages of the
//! library's own simulation.

use std::fmt::Write;
use std::path::PathBuf;

use hysteron_export::{
    ClosedLoop, ExportError, ExportRequest, Exported, Form, GoldenLoop, Means, Precision, RUNTIME, Subject,
    controller_fmu_files, export, fmu_files, write_folder,
};
use hysteron_model::control::{Plant, Stage, StageError, StageRun, StageSample, play};
use hysteron_model::model::{Capability, InverseRequest, Model};
use hysteron_model::model_file::{Interval, ModelFile, SignalUnits, ValidRange};
use hysteron_model::realise::{RealiseOptions, RuntimeParts};
use hysteron_model::tracking::Controller;
use hysteron_numeric::Listener;

use crate::fmu::python;
use crate::models::{self, RATE_HZ};
use crate::tools::{STRICT, c_compilers, choices, pairs, run, workspace_of};

const EXPORTED: [Controller; 5] = ClosedLoop::EXPORTED;

/// A model of the tests as data.
fn data(name: &str) -> Model {
    let law = models::all().into_iter().find(|(own, _)| *own == name).unwrap().1;
    let mut file = ModelFile::from_model(&law, SignalUnits::default());
    let interval = |low, high, unit: &str| Interval { low, high, unit: unit.into() };
    file.valid_range = Some(ValidRange { input: interval(0.0, 100.0, "V"), frequency: None, rate: None });
    Model::try_from(file).unwrap()
}

fn request(controller: Controller, float: Precision, form: Form) -> ExportRequest {
    ExportRequest {
        float,
        sample_rate_hz: Some(RATE_HZ),
        inverse: Some(InverseRequest {
            slew_per_s: Some(2e5),
            predict_to_hz: controller.name().starts_with("predicted").then_some(200.0),
            ..InverseRequest::default()
        }),
        controller: Some(controller),
        ..ExportRequest::new(form, "stage")
    }
}

#[test]
fn controllers_in_c_are_the_library_s_own() {
    let place = tempfile::tempdir().unwrap();
    let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
    let all = pairs(&c_compilers(), &[&["-O2"][..], &sanitized[..]]);
    for (k, (name, controller, precision)) in cases().into_iter().enumerate() {
        let files = exported(name, controller, precision, Form::C).files;
        for (compiler, flags) in choices(&all, k) {
            let own = format!("{name}_{}_{compiler}_{}_{}", controller.name(), precision.name(), flags.len());
            let folder = place.path().join(&own);
            write_folder(&folder, &files).unwrap();
            let mut sources: Vec<&str> = files
                .iter()
                .map(|file| file.name.as_str())
                .filter(|file| file.ends_with(".c") && !file.contains("selftest") && !file.contains("loop"))
                .collect();
            sources.push("stage_controller_selftest.c");
            run(&folder, compiler, &[&STRICT[..], flags, &sources, &["-o", "selftest", "-lm"]].concat());
            let said = run(&folder, "./selftest", &[]);
            println!("{own} {}: {}", flags[0], said.lines().next().unwrap());
            assert!(said.contains("PASSED: stage_controller"), "{said}");
        }
    }
}

/// Models, controllers and number types.
fn cases() -> Vec<(&'static str, Controller, Precision)> {
    let mut all = Vec::new();
    for name in ["stage", "plays", "preisach_density"] {
        for controller in EXPORTED {
            all.extend([Precision::F64, Precision::F32].map(|precision| (name, controller, precision)));
        }
    }
    all
}

fn exported(name: &str, controller: Controller, float: Precision, form: Form) -> Exported {
    let means = Means { compiler: "cc", listener: Listener::silent() };
    let model = data(name);
    let body = model.hammerstein(Capability::Export).unwrap();
    export(body, &request(controller, float, form), means).unwrap()
}

/// The controller of an export.
fn closed(name: &str, controller: Controller, exported: &Exported) -> ClosedLoop {
    let model = data(name);
    let body = model.hammerstein(Capability::Export).unwrap();
    let subject = &exported.subject;
    let asked = request(controller, subject.precision, Form::C).inverse.unwrap();
    let realise = RealiseOptions { accuracy: subject.accuracy, lowest_frequency_hz: None };
    ClosedLoop::new(body, subject, controller, &asked, realise).unwrap()
}

/// Single precision: a dry run along the vectors of its self-test, whose figure the header states.
#[test]
fn a_single_precision_controller_states_its_accuracy() {
    for (name, controller, precision) in cases() {
        if precision == Precision::F64 {
            continue;
        }
        let exported = exported(name, controller, precision, Form::C);
        let closed = closed(name, controller, &exported);
        let (dry, bound) = (closed.dry_run, closed.rounding.bound);
        println!(
            "{name} {}: {:.1e} along vectors, {:.1e} explained, {:.1e} thrown, {bound:.1e} stated",
            controller.name(),
            dry.along_vectors,
            dry.explained,
            dry.thrown
        );
        assert!(dry.along_vectors > 0.0 && dry.along_vectors <= bound, "{name} {controller:?}");
        let header = exported.files.iter().find(|f| f.name == "stage_controller.h").unwrap();
        let header = String::from_utf8(header.bytes.clone()).unwrap();
        assert!(header.contains("Single precision may move the voltage by"), "{header}");
        assert_eq!(header.contains("Thrown from limit to limit"), dry.departs());
        assert_eq!(header.contains("In a dry run rounding errors"), dry.drifts());
    }
}

#[test]
fn controllers_in_rust_are_the_library_s_own() {
    let place = tempfile::tempdir().unwrap();
    let runtime = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../hysteron-rt").canonicalize().unwrap();
    let mut members = Vec::new();
    for (name, controller, precision) in [
        ("stage", Controller::FeedforwardFractionalPi, Precision::F64),
        ("stage", Controller::FeedforwardObserver, Precision::F32),
        ("plays", Controller::FeedforwardPi, Precision::F32),
        ("preisach_density", Controller::PredictedObserver, Precision::F64),
    ] {
        let mut files = exported(name, controller, precision, Form::Rust).files;
        files.retain(|file| !file.name.starts_with(RUNTIME));
        let own = format!("{name}_{}_{}", controller.name().replace('-', "_"), precision.name());
        for file in &mut files {
            let text = String::from_utf8(file.bytes.clone()).unwrap();
            // One workspace and one runtime, so that it is compiled once.
            let text = match file.name.as_str() {
                "Cargo.toml" => text
                    .replace("[workspace]", "")
                    .replace("name = \"stage\"", &format!("name = \"{own}\""))
                    .replace("path = \"runtime\"", &format!("path = {runtime:?}")),
                _ => text.replace("stage::", &format!("{own}::")),
            };
            file.bytes = text.into_bytes();
        }
        write_folder(&place.path().join(&own), &files).unwrap();
        members.push(format!("\"{own}\""));
    }
    std::fs::write(place.path().join("Cargo.toml"), workspace_of(&members)).unwrap();
    let lock = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../Cargo.lock");
    std::fs::copy(lock, place.path().join("Cargo.lock")).unwrap();
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exported-controllers");
    let target = target.to_str().unwrap();
    let tests = ["test", "--offline", "--workspace", "--target-dir", target, "--", "--show-output"];
    let said = run(place.path(), env!("CARGO"), &tests);
    said.lines().filter(|line| line.contains("largest difference")).for_each(|line| println!("{line}"));
    assert_eq!(said.matches("test golden_vectors ... ok").count(), 3 * members.len(), "{said}");
    let check = ["clippy", "--offline", "--workspace", "--target-dir", target, "--"];
    run(place.path(), env!("CARGO"), &[&check[..], &["-D", "warnings", "-W", "missing-docs"]].concat());
}

/// The exported model as a stage.
struct Exact<'a>(&'a Subject);

struct ExactRun {
    parts: RuntimeParts<f64>,
    /// Voltages so far.
    taken: Vec<f64>,
}

impl Stage for Exact<'_> {
    fn at_rest(&self, _: f64, rest_v: f64) -> Result<Box<dyn StageRun + '_>, StageError> {
        let parts = RuntimeParts::new(&self.0.realisation)?;
        Ok(Box::new(ExactRun { parts, taken: vec![rest_v] }))
    }
}

impl StageRun for ExactRun {
    /// From the beginning on: the model borrows its memory.
    fn step(&mut self, drive_v: f64) -> Result<StageSample, StageError> {
        let mut model = self.parts.model()?;
        let mut now = model.rest_at(self.taken[0])?;
        for voltage in &self.taken[1..] {
            now = model.step(*voltage)?;
        }
        self.taken.push(drive_v);
        Ok(StageSample { reading_um: now, true_um: now })
    }
}

/// Along the vectors, and in a loop with the model's own unit.
#[test]
fn fmpy_judges_the_controllers() {
    let Some(python) = python() else { return };
    for (name, controller, precision) in [
        ("stage", Controller::FeedforwardFractionalPi, Precision::F64),
        ("stage", Controller::PredictedObserver, Precision::F64),
        ("plays", Controller::FeedforwardPi, Precision::F32),
    ] {
        let exported = exported(name, controller, precision, Form::C);
        let closed = closed(name, controller, &exported);
        let mut units = controller_fmu_files(&closed, "cc").unwrap();
        units.extend(fmu_files(&exported.subject, "cc").unwrap());
        let golden = GoldenLoop::new(&closed).unwrap();
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        write_folder(&folder, &units).unwrap();
        std::fs::write(folder.join("fmu.py"), include_str!("fmu_controller.py")).unwrap();
        let mut rows = String::new();
        for ((r, u), y) in golden.references.iter().zip(&golden.voltages).zip(&golden.readings) {
            writeln!(rows, "{r:?},{u:?},{y:?}").unwrap();
        }
        std::fs::write(folder.join("record.csv"), rows).unwrap();
        let [low, high] = closed.inverse.range_v;
        let preview = closed.inverse.compensation.preview as f64;
        let numbers = [RATE_HZ, golden.tolerance, golden.rest_v, golden.measured, low, high, preview]
            .map(|x| format!("{x:?}"));
        let played =
            play(&closed.made, &golden.references, Plant::Stage(&Exact(&exported.subject)), None).unwrap();
        let pairs = golden.references.iter().zip(&played.drive);
        let rows: String = pairs.map(|(r, u)| format!("{r:?},{u:?}\n")).collect();
        std::fs::write(folder.join("loop.csv"), rows).unwrap();
        for version in [2, 3] {
            let unit = format!("stage_controller_fmi{version}.fmu");
            let mut arguments = vec!["fmu.py", &unit, "record.csv"];
            arguments.extend(numbers.iter().map(String::as_str));
            let said = run(&folder, &python, &arguments);
            let last = said.lines().last().unwrap_or_default();
            println!("{name} {} {}: {last}", controller.name(), precision.name());
            assert!(said.contains(": valid;"), "{said}");
        }
    }
}

#[test]
fn the_selftest_of_a_controller_can_fail() {
    let place = tempfile::tempdir().unwrap();
    let means = Means { compiler: "cc", listener: Listener::silent() };
    let model = data("stage");
    let body = model.hammerstein(Capability::Export).unwrap();
    for (controller, number) in [
        (Controller::FeedforwardPi, "PROPORTIONAL * error"),
        (Controller::FeedforwardPi, "INTEGRAL * error"),
        (Controller::FeedforwardObserver, "OBSERVER_GAIN * left"),
        (Controller::FeedforwardFractionalPi, "state->sum + remembered"),
    ] {
        let mut files = export(body, &request(controller, Precision::F64, Form::C), means).unwrap().files;
        let source = files.iter_mut().find(|f| f.name == "stage_controller.c").unwrap();
        let text = String::from_utf8(source.bytes.clone()).unwrap();
        assert!(text.contains(number), "{number}");
        source.bytes = text.replace(number, &format!("(1.0 + 1e-7) * ({number})")).into_bytes();
        let folder = place.path().join(format!("{}_{}", controller.name(), number.len()));
        write_folder(&folder, &files).unwrap();
        let sources: Vec<&str> = files
            .iter()
            .map(|file| file.name.as_str())
            .filter(|file| {
                file.ends_with(".c") && !file.contains("inverse_selftest") && !file.contains("loop")
            })
            .filter(|file| *file != "stage_selftest.c")
            .collect();
        run(&folder, "cc", &[&["-std=c99", "-O1"], &sources[..], &["-o", "selftest", "-lm"]].concat());
        let output = std::process::Command::new(folder.join("selftest")).output().unwrap();
        assert!(!output.status.success(), "{number}: {}", String::from_utf8_lossy(&output.stdout));
    }
}

#[test]
fn controllers_that_are_not_exported_say_why() {
    let means = Means { compiler: "cc", listener: Listener::silent() };
    let model = data("stage");
    let body = model.hammerstein(Capability::Export).unwrap();
    for controller in Controller::ALL {
        let outcome = export(body, &request(controller, Precision::F64, Form::C), means);
        match outcome {
            Ok(_) => assert!(EXPORTED.contains(&controller), "{controller:?}"),
            Err(e) => {
                assert!(matches!(e, ExportError::Controller { .. }), "{controller:?}: {e}");
                assert!(e.to_string().contains("feedforward-observer"), "{e}");
                assert!(!EXPORTED.contains(&controller), "{controller:?}: {e}");
            }
        }
    }
    let refused = |request: ExportRequest| export(body, &request, means).unwrap_err();
    let pi = |float, form| request(Controller::FeedforwardPi, float, form);
    for form in [Form::Matlab, Form::Simulink] {
        assert!(matches!(refused(pi(Precision::F64, form)), ExportError::ControllerForm { .. }));
    }
    let alone = ExportRequest { inverse: None, ..pi(Precision::F64, Form::C) };
    assert!(matches!(refused(alone), ExportError::ControllerAlone));
    let mut blind = request(Controller::PredictedPi, Precision::F64, Form::C);
    blind.inverse.as_mut().unwrap().predict_to_hz = None;
    assert!(matches!(refused(blind), ExportError::Prediction { .. }));
}
