//! The commands of operations that answer with tables and sentences.

use hysteron_identify::online::FollowMethod;

use super::{Arguments, Words, beside, ids, joined, read, text};
use crate::api::{
    AdaptOptions, BandOf, Command, PrepareOptions, RealiseOptions, RecalibrateOptions, RecordEntry,
    ResponseFitRequest, SimulateOptions,
};

/// A list of texts in Python; `None` where it is empty.
fn list(texts: &[String]) -> Option<String> {
    let texts: Vec<String> = texts.iter().map(|one| text(one)).collect();
    (!texts.is_empty()).then(|| format!("[{}]", texts.join(", ")))
}

/// `hysteron prepare`.
pub(crate) fn prepare(records: &[RecordEntry], options: &PrepareOptions, save: &str) -> Command {
    let mut words = Words::new("prepare").words(ids(records)).with("-o", save);
    for (flag, values) in [("--rename", &options.rename), ("--where", &options.conditions)] {
        words = values.iter().fold(words, |words, value| words.with(flag, value));
    }
    words = words.maybe("--drop", joined(&options.drop)).maybe("--turns", options.turns.as_ref());
    let first = records.first().map(|record| record.settings.clone()).unwrap_or_default();
    words = words
        .maybe("--time", first.time.as_ref())
        .maybe("--input", first.input.as_ref().filter(|_| options.turns.is_some()))
        .maybe("--sample-rate", first.sample_rate_hz)
        .maybe("--from", first.from_s)
        .maybe("--to", first.to_s);
    for scale in options.scales.iter().chain(&first.scales) {
        words = words.with("--scale", scale);
    }
    let words = words
        .maybe("--remove-mean", joined(&options.remove_mean))
        .maybe("--detrend", joined(&options.detrend))
        .maybe("--rate", options.sample_rate_hz);
    let rename: Vec<String> = options
        .rename
        .iter()
        .filter_map(|pair| pair.split_once('='))
        .map(|(old, new)| format!("{}: {}", text(old), text(new)))
        .collect();
    let paths: Vec<String> = ids(records).map(text).collect();
    let reading = Arguments::default()
        .plain(format!("[{}]", paths.join(", ")))
        .text("time", first.time.as_ref())
        .value("fs", first.sample_rate_hz)
        .value("start", first.from_s)
        .value("stop", first.to_s)
        .value("where", list(&options.conditions))
        .text("turns", options.turns.as_ref())
        .value("rename", (!rename.is_empty()).then(|| format!("{{{}}}", rename.join(", "))))
        .value("drop", list(&options.drop));
    let scales: Vec<String> = options.scales.iter().chain(&first.scales).cloned().collect();
    let arguments = Arguments::default()
        .plain(format!("hy.read({})", reading.done()))
        .value("scale", list(&scales))
        .value("remove_mean", list(&options.remove_mean))
        .value("detrend", list(&options.detrend))
        .value("fs", options.sample_rate_hz);
    let python = format!("hy.prepare({}).save({})", arguments.done(), text(save));
    beside(Command { shell: words.done(), python }, records)
}

/// `hysteron simulate`.
pub(crate) fn simulate(
    (model, is_force): (&str, bool),
    records: &[RecordEntry],
    options: &SimulateOptions,
    save: &str,
) -> Command {
    let band = match options.band {
        BandOf::None => None,
        BandOf::Model => Some("model"),
        BandOf::Measurement => Some("measurement"),
    };
    let words = Words::new("simulate").word(model).words(ids(records)).with("-o", save);
    let words = words
        .when("--continued", records.len() > 1)
        .maybe("--band", band)
        .when("--correct", options.correct)
        .maybe("--rest-voltage", options.rest_voltage);
    let first = records.first().map(|record| record.settings.clone()).unwrap_or_default();
    let rate = options.rate.as_ref().or(first.rate.as_ref().filter(|_| is_force));
    let words = words.maybe("--rate", rate);
    let shell = words
        .maybe("--time", first.time)
        .maybe("--input", first.input)
        .maybe("--dead-band", first.dead_band)
        .maybe("--dead-zone", first.dead_zone)
        .done();
    let of = match options.band {
        BandOf::Measurement => Some("\"measurement\""),
        _ => None,
    };
    let arguments = Arguments::default()
        .plain(format!("{}[0]", read(records)))
        .value("band", band.map(|_| "0.95"))
        .value("band_of", of)
        .when("correct", options.correct)
        .value("rest", options.rest_voltage);
    let python = format!("print(hy.load({}).simulate({}))", text(model), arguments.done());
    beside(Command { shell, python }, records)
}

/// `hysteron recalibrate`.
pub(crate) fn recalibrate(
    model: &str,
    records: &[RecordEntry],
    options: &RecalibrateOptions,
    save: &str,
) -> Command {
    let least = (options.least_fit_percent != RecalibrateOptions::default().least_fit_percent)
        .then_some(options.least_fit_percent);
    let words = Words::new("recalibrate").word(model).words(ids(records)).with("-o", save);
    let shell =
        words.when("--continued", options.continued).maybe("--least-fit", least).columns(records).done();
    let arguments = Arguments::default()
        .plain(read(records))
        .when("continued", options.continued)
        .value("least_fit", least);
    let python =
        format!("hy.load({}).recalibrate({})[0].save({})", text(model), arguments.done(), text(save));
    beside(Command { shell, python }, records)
}

/// `hysteron adapt`.
pub(crate) fn adapt(
    model: &str,
    records: &[RecordEntry],
    options: &AdaptOptions,
    save: Option<&str>,
) -> Command {
    let (method, memory, step) = match options.method {
        FollowMethod::LeastSquares { memory_s } => (None, memory_s, None),
        FollowMethod::Gradient { step } => (Some("nlms"), None, Some(step)),
    };
    let usual = AdaptOptions::default();
    let run_length = (options.run_length != usual.run_length).then_some(options.run_length);
    let terms = Some(&options.terms).filter(|terms| **terms != usual.terms);
    let words = Words::new("adapt").word(model).words(ids(records)).maybe("-o", save);
    let shell = words
        .maybe("--terms", terms.map(|terms| terms.join(",")))
        .maybe("--method", method)
        .maybe("--memory", memory)
        .maybe("--step", step)
        .maybe("--noise", options.noise)
        .maybe("--every", options.every)
        .maybe("--run-length", run_length)
        .when("--reopen", options.reopen)
        .columns(records)
        .done();
    let arguments = Arguments::default()
        .plain(format!("{}[0]", read(records)))
        .value("terms", terms.and_then(|terms| list(terms)))
        .value("method", method.map(text))
        .value("memory", memory)
        .value("step", step)
        .value("noise", options.noise)
        .value("every", options.every)
        .value("run_length", run_length)
        .when("reopen", options.reopen);
    let adapted = format!("hy.load({}).adapt({})", text(model), arguments.done());
    let python = match save {
        Some(save) => format!("{adapted}[0].save({})", text(save)),
        None => format!("print({adapted}[1])"),
    };
    beside(Command { shell, python }, records)
}

/// `hysteron realise`.
pub(crate) fn realise(model: &str, sample_rate_hz: f64, options: &RealiseOptions) -> Command {
    let accuracy = (options.accuracy != RealiseOptions::default().accuracy).then_some(options.accuracy);
    let words = Words::new("realise").word(model).with("--sample-rate", sample_rate_hz);
    let words = words.maybe("--accuracy", accuracy);
    let arguments = Arguments::default()
        .plain(sample_rate_hz.to_string())
        .value("accuracy", accuracy)
        .value("lowest_frequency", options.lowest_frequency_hz);
    Command {
        shell: words.maybe("--lowest-frequency", options.lowest_frequency_hz).done(),
        python: format!("print(hy.load({}).realise({}))", text(model), arguments.done()),
    }
}

/// `hysteron frequency-response`.
pub(crate) fn frequency_response(request: &ResponseFitRequest) -> Command {
    let options = &request.options;
    let band = match (options.low_hz, options.high_hz) {
        (None, None) => None,
        (low, high) => Some((low.unwrap_or(0.0), high.unwrap_or(1e9))),
    };
    let words = Words::new("frequency-response").words(request.files.iter().map(String::as_str));
    let words = options.structures.iter().fold(words, |words, name| words.with("--structure", name));
    let shell = words
        .maybe("--modes", options.modes)
        .maybe("--band", band.map(|(low, high)| format!("{low}:{high}")))
        .maybe("--response", options.response.as_ref())
        .maybe("--over", options.over.as_ref())
        .maybe("--unit", options.unit.as_ref())
        .maybe("--period", options.period_s)
        .maybe("--settling", options.settling_periods)
        .maybe("-o", request.save.as_ref())
        .maybe("--report", request.report.as_ref())
        .done();
    let source = match request.files.as_slice() {
        [one] => text(one),
        files => format!("hy.read({})", list(files).unwrap_or_default()),
    };
    let arguments = Arguments::default()
        .plain(source)
        .value("structures", list(&options.structures))
        .value("modes", options.modes)
        .value("band", band.map(|(low, high)| format!("({low}, {high})")))
        .value("period", options.period_s)
        .value("settling", options.settling_periods)
        .text("response", options.response.as_ref())
        .text("over", options.over.as_ref());
    Command { shell, python: format!("print(hy.frequency_response({}))", arguments.done()) }
}
