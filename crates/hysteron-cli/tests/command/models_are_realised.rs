//! `realise` turns a model file into sections, says what they reach, and refuses what it cannot do.

use hysteron_model::dynamics::{Dynamics, Scheme, Term, TransferFunction};
use hysteron_model::hammerstein::Model;
use hysteron_model::model_file::SignalUnits;
use serde_json::Value;

use crate::bench::{Bench, static_model};

fn stage(scheme: Scheme) -> Model {
    Model {
        dynamics: Dynamics::Fractional(TransferFunction::article_eq13()),
        scheme,
        delay_s: 2.3e-4,
        sample_rate_hz: Some(1e4),
        ..static_model()
    }
}

#[test]
fn the_sections_follow_the_transfer_function_to_the_accuracy_asked_for() {
    let bench = Bench::new();
    bench.write_model("stage.json", &stage(Scheme::Tustin), SignalUnits::default());
    let run = bench.run("realise stage.json --sample-rate 10000 --accuracy 1e-6 --json");
    assert_eq!((run.exit_code, run.stdout.trim_end().lines().count()), (0, 1), "{run:?}");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(number("frequency_error") <= 1e-6 && number("batch_difference_largest") <= 1e-6, "{found}");
    assert_eq!((found["delay_samples"].as_u64(), found["taps"].as_array().unwrap().len()), (Some(2), 2));
    assert!(number("nanoseconds_per_sample") > 0.0);
    // The gain at rest is what taps and weights add up to.
    let sections = found["sections"].as_array().unwrap();
    let pairs = sections.iter().filter(|s| s["kind"] == "pair").count();
    assert_eq!((pairs, sections.len() + pairs), (1, found["states"].as_u64().unwrap() as usize));
    let taps: f64 = found["taps"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap()).sum();
    let weights: f64 = sections.iter().map(|s| s["weight"][0].as_f64().unwrap()).sum();
    assert!((taps + weights - 5.2589 / 5.4955).abs() < 1e-12, "{found}");
    assert_eq!(found["rest_gain"].as_f64(), Some(5.2589e6 / 5.4955e6));
}

#[test]
fn the_table_is_for_people_too() {
    let bench = Bench::new();
    bench.write_model("stage.json", &stage(Scheme::BandLimited), SignalUnits::default());
    let run = bench.run("realise stage.json --sample-rate 10000");
    assert_eq!(run.exit_code, 0, "{run:?}");
    for part in [
        "pole pair",
        "real pole",
        "tap, 2 samples ago",
        "largest error of the response",
        "rest to 5000 Hz",
        " ns",
    ] {
        assert!(run.stdout.contains(part), "{part}: {}", run.stdout);
    }
    // A static model is one tap.
    let run = bench.run("realise model.json --sample-rate 10000 --json");
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((found["states"].as_u64(), found["taps"][0].as_f64()), (Some(0), Some(1.0)));
}

#[test]
fn creep_asks_for_a_lowest_frequency_and_a_scheme_for_its_rate() {
    let bench = Bench::new();
    // A fractional mode with 1.2 % of creep.
    let creep = TransferFunction::new(
        vec![Term::new(53_462.0, 0.0), Term::new(4.4551e6, 0.15)],
        vec![Term::new(4.4551e6, 0.15), Term::new(1945.3, 1.2), Term::new(1.0, 2.18)],
    );
    let creeping = Model { dynamics: Dynamics::Fractional(creep.unwrap()), ..stage(Scheme::Tustin) };
    bench.write_model("creep.json", &creeping, SignalUnits::default());
    let run = bench.run("realise creep.json --sample-rate 10000");
    assert_eq!((run.exit_code, run.stdout.as_str()), (1, ""), "{run:?}");
    assert!(
        run.stderr.contains("creeps for ever") && run.stderr.contains("try: give --lowest-frequency"),
        "{run:?}"
    );
    let run = bench.run("realise creep.json --sample-rate 10000 --lowest-frequency 0.01");
    assert_eq!(run.exit_code, 0, "{run:?}");
    assert!(run.stdout.contains("0.0100 Hz to 5000 Hz"), "{}", run.stdout);

    bench.write_model("old.json", &stage(Scheme::GrunwaldLetnikov), SignalUnits::default());
    let run = bench.run("realise old.json --sample-rate 5000");
    assert_eq!(run.exit_code, 1, "{run:?}");
    assert!(run.stderr.contains("belongs to 10000 Hz") && run.stderr.contains("--scheme tustin"), "{run:?}");
    let run = bench.run("realise old.json --sample-rate 10000 --lowest-frequency 1 --accuracy 1e-15");
    assert!(run.exit_code == 1 && run.stderr.contains("--accuracy"), "{run:?}");
}
