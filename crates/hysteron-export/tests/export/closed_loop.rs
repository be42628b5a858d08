//! Controllers with feedback and observer in C: without a warning, and the voltages of the library's own
//! simulation.

use hysteron_export::{ExportError, ExportRequest, Form, Means, Precision, export, write_folder};
use hysteron_model::model::{Capability, InverseRequest, Model};
use hysteron_model::model_file::{Interval, ModelFile, SignalUnits, ValidRange};
use hysteron_model::tracking::Controller;
use hysteron_numeric::Listener;

use crate::models::{self, RATE_HZ};
use crate::tools::{STRICT, c_compilers, run};

const EXPORTED: [Controller; 5] = [
    Controller::FeedforwardPi,
    Controller::FeedforwardFractionalPi,
    Controller::FeedforwardObserver,
    Controller::PredictedPi,
    Controller::PredictedObserver,
];

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
    let means = Means { compiler: "cc", listener: Listener::silent() };
    for name in ["stage", "plays", "preisach_density"] {
        let model = data(name);
        let body = model.hammerstein(Capability::Export).unwrap();
        for controller in EXPORTED {
            let files = export(body, &request(controller, Precision::F64, Form::C), means).unwrap().files;
            // The code of a controller is the same behind every family.
            let compilers = if name == "stage" { c_compilers() } else { vec!["cc"] };
            for compiler in compilers {
                let folder = place.path().join(format!("{name}_{}_{compiler}", controller.name()));
                write_folder(&folder, &files).unwrap();
                let mut sources: Vec<&str> = files
                    .iter()
                    .map(|file| file.name.as_str())
                    .filter(|file| {
                        file.ends_with(".c") && !file.contains("selftest") && !file.contains("loop")
                    })
                    .collect();
                sources.push("stage_controller_selftest.c");
                let sanitized = ["-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"];
                for (flags, program) in [(&["-O2"][..], "plain"), (&sanitized[..], "sanitized")] {
                    run(&folder, compiler, &[&STRICT[..], flags, &sources, &["-o", program, "-lm"]].concat());
                    let said = run(&folder, format!("./{program}"), &[]);
                    println!("{name} {} {compiler}: {}", controller.name(), said.lines().next().unwrap());
                    assert!(said.contains("PASSED: stage_controller"), "{said}");
                }
            }
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
    assert!(matches!(refused(pi(Precision::F32, Form::C)), ExportError::ControllerPrecision));
    assert!(matches!(refused(pi(Precision::F64, Form::Rust)), ExportError::ControllerForm));
    let alone = ExportRequest { inverse: None, ..pi(Precision::F64, Form::C) };
    assert!(matches!(refused(alone), ExportError::ControllerForm));
    let mut blind = request(Controller::PredictedPi, Precision::F64, Form::C);
    blind.inverse.as_mut().unwrap().predict_to_hz = None;
    assert!(matches!(refused(blind), ExportError::Prediction { .. }));
}
