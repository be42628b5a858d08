//! `hysteron identify` and `hysteron compare`.

use hysteron_identify::{Choice, DynamicsChoice, FamilyChoice, Options, RecordRole, Task};
use hysteron_model::dynamics::Creep;
use hysteron_model::model_file::Kind;
use hysteron_model::record::InterSample;
use hysteron_optimize::Algorithm;

use super::{Arguments, Words, beside, ids, read, text};
use crate::api::{Command, RecordEntry, Role, kind_for};

/// Role of a record in the fit, as a person gave it.
fn role(record: &RecordEntry) -> Option<RecordRole> {
    match record.settings.role {
        Role::QuasiStatic => Some(RecordRole::QuasiStatic),
        Role::Dynamic => Some(RecordRole::Dynamic),
        _ => None,
    }
}

/// `hysteron identify` of these records to the model `model`.
pub(crate) fn identify(
    records: &[RecordEntry],
    task: &Task,
    model: &str,
    start: Option<&str>,
    (inputs, outputs): (&[String], &[String]),
    report: Option<&str>,
) -> Command {
    let mut words = Words::new("identify");
    for record in records {
        words = match role(record) {
            None => words.word(&record.id),
            Some(RecordRole::QuasiStatic) => words.with("--static", &record.id),
            Some(RecordRole::Dynamic) => words.with("--dynamic", &record.id),
        };
    }
    words = words.with("-o", model).maybe("--start", start).maybe("--report", report);
    let (words, kind, arguments) = match task {
        Task::Hammerstein(options) => {
            // Without the flag the command takes the kind that the records call for.
            let unusual = kind_for(records) != Kind::Hammerstein;
            let words = words.maybe("--structure", unusual.then_some(Kind::Hammerstein.name()));
            (hammerstein(words, options), "Hammerstein", python(Arguments::default(), options))
        }
        Task::Oscillator(_) => (words.with("--structure", "oscillator"), "Oscillator", Arguments::default()),
        Task::Force(_) => {
            let rate = records.first().and_then(|record| record.settings.rate.as_ref());
            let words = words.with("--structure", "force").maybe("--rate", rate);
            (words, "Force", Arguments::default())
        }
        Task::Modes(_) => (axes(words, inputs, outputs), "Modes", of_axes(inputs, outputs)),
        Task::Branches(_) => {
            let words = axes(words, inputs, outputs).with("--structure", "hammerstein");
            (words, "Branches", of_axes(inputs, outputs))
        }
    };
    let from = start.map_or_else(String::new, |start| format!(", start=hy.load({})", text(start)));
    let fitted = format!("hy.{kind}({}).fit({}{from})", arguments.done(), read(records));
    let mut python = format!("{fitted}.model_.save({})", text(model));
    if matches!(task, Task::Force(_)) && records.iter().any(|record| record.settings.rate.is_some()) {
        python += "  # the measured rate is left out";
    }
    beside(Command { shell: words.columns(records).done(), python }, records)
}

fn axes(words: Words, inputs: &[String], outputs: &[String]) -> Words {
    words.with("--inputs", inputs.join(",")).with("--outputs", outputs.join(","))
}

fn of_axes(inputs: &[String], outputs: &[String]) -> Arguments {
    let list = |names: &[String]| {
        let names: Vec<String> = names.iter().map(|name| text(name)).collect();
        format!("[{}]", names.join(", "))
    };
    Arguments::default().value("inputs", Some(list(inputs))).value("outputs", Some(list(outputs)))
}

/// Each option that is not the default: name of its flag, and value.
fn changed(options: &Options) -> Vec<(&'static str, String)> {
    let usual = Options::default();
    let mut found = Vec::new();
    if options.hysteresis != usual.hysteresis {
        found.push(("hysteresis", options.hysteresis.name().to_owned()));
        if let FamilyChoice::Given(form) = options.hysteresis
            && form.description().elements().is_some()
        {
            found.push(("elements", form.elements().to_string()));
        }
    }
    if options.dynamics != usual.dynamics {
        found.push(("dynamics", options.dynamics.name().to_owned()));
        if matches!(options.dynamics, DynamicsChoice::Integer | DynamicsChoice::Modes) {
            found.push(("order", options.order.to_string()));
        }
    }
    if options.creep != usual.creep {
        found.push(("creep", options.creep.name().to_owned()));
        if let Creep::KelvinVoigt { elements } = options.creep {
            found.push(("creep-elements", elements.to_string()));
        }
    }
    if options.method != usual.method {
        found.push(("method", options.method.name().to_owned()));
    }
    if options.initial != usual.initial {
        found.push(("initial", options.initial.name().to_owned()));
    }
    if let Some(algorithm) = &options.algorithm {
        found.push(("optimizer", algorithm.name().to_owned()));
        found.extend(population(algorithm).map(|count| ("population", count.to_string())));
    }
    if options.generations != usual.generations {
        found.push(("generations", options.generations.to_string()));
    }
    if options.seed != usual.seed {
        found.push(("seed", options.seed.to_string()));
    }
    found.extend(options.threads.map(|threads| ("threads", threads.to_string())));
    if let Choice::Given(degree) = options.degree {
        found.push(("degree", degree.to_string()));
    }
    if options.n != usual.n {
        found.push(("n", chosen(options.n, "free")));
    }
    if let Choice::Given(delay) = options.delay_s {
        found.push(("delay", delay.to_string()));
    }
    if let Choice::Given(scheme) = options.scheme {
        found.push(("scheme", scheme.name().to_owned()));
    }
    if let Choice::Given(rule) = options.inter_sample {
        found.push(("inter-sample", InterSample::name(rule).to_owned()));
    }
    if options.least_fit_percent != usual.least_fit_percent {
        found.push(("least-fit", options.least_fit_percent.to_string()));
    }
    found
}

fn chosen(choice: Choice<f64>, otherwise: &str) -> String {
    match choice {
        Choice::Given(value) => value.to_string(),
        Choice::Auto => otherwise.to_owned(),
    }
}

fn population(algorithm: &Algorithm) -> Option<usize> {
    match algorithm {
        Algorithm::DeAbc(options) => Some(options.population),
        Algorithm::Abc(options) => Some(options.population),
        Algorithm::De(options) => Some(options.population),
        Algorithm::Pso(options) => Some(options.population),
        Algorithm::CmaEs(options) => options.population,
        Algorithm::LeastSquares(options) => Some(options.starts),
    }
}

fn hammerstein(words: Words, options: &Options) -> Words {
    let words =
        changed(options).iter().fold(words, |words, (name, value)| words.with(&format!("--{name}"), value));
    let mut words = words.when("--continued", options.continued).when("--drift", options.drift);
    for (name, value) in &options.demands.fixed {
        words = words.with("--fix", format!("{name}={value}"));
    }
    for (name, low, high) in &options.demands.bounded {
        words = words.with("--bound", format!("{name}={low}:{high}"));
    }
    words
}

fn python(arguments: Arguments, options: &Options) -> Arguments {
    let arguments = changed(options).into_iter().fold(arguments, |arguments, (name, value)| {
        let value = if value.parse::<f64>().is_ok() { value } else { text(&value) };
        arguments.value(&name.replace('-', "_"), Some(value))
    });
    let pairs = options.demands.fixed.iter().map(|(name, value)| format!("{}: {value}", text(name)));
    let fixed: Vec<String> = pairs.collect();
    let bounded = options.demands.bounded.iter();
    let bounds: Vec<String> =
        bounded.map(|(name, low, high)| format!("{}: ({low}, {high})", text(name))).collect();
    let dictionary = |pairs: Vec<String>| (!pairs.is_empty()).then(|| format!("{{{}}}", pairs.join(", ")));
    arguments
        .when("continued", options.continued)
        .when("drift", options.drift)
        .value("fixed", dictionary(fixed))
        .value("bounds", dictionary(bounds))
}

/// `hysteron compare`.
pub(crate) fn compare(
    records: &[RecordEntry],
    candidates: &[String],
    quick: bool,
    time_limit_s: Option<f64>,
    continued: bool,
    report: Option<&str>,
) -> Command {
    let named = (!candidates.is_empty()).then(|| candidates.join(","));
    let words = Words::new("compare").words(ids(records)).maybe("--candidates", named);
    let words = words.when("--quick", quick).maybe("--time-limit", time_limit_s);
    let words = words.when("--continued", continued).maybe("--report", report);
    let list: Vec<String> = candidates.iter().map(|name| text(name)).collect();
    let arguments = Arguments::default()
        .plain(read(records))
        .value("candidates", (!list.is_empty()).then(|| format!("[{}]", list.join(", "))))
        .when("quick", quick)
        .value("time_limit", time_limit_s)
        .when("continued", continued);
    let python = format!("print(hy.compare({}))", arguments.done());
    beside(Command { shell: words.columns(records).done(), python }, records)
}

/// `hysteron compare` of several axes.
pub(crate) fn compare_axes(
    records: &[RecordEntry],
    candidates: &[String],
    (inputs, outputs): (&[String], &[String]),
    report: Option<&str>,
) -> Command {
    let named = (!candidates.is_empty()).then(|| candidates.join(","));
    let words = axes(Words::new("compare").words(ids(records)), inputs, outputs);
    let words = words.maybe("--candidates", named).maybe("--report", report);
    let list: Vec<String> = candidates.iter().map(|name| text(name)).collect();
    let arguments = Arguments::default()
        .plain(read(records))
        .plain(of_axes(inputs, outputs).done())
        .value("candidates", (!list.is_empty()).then(|| format!("[{}]", list.join(", "))));
    let python = format!("print(hy.compare_axes({}))", arguments.done());
    beside(Command { shell: words.columns(records).done(), python }, records)
}
