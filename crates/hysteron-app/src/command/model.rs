//! The commands of what a model is for: scores, drives, controllers, source code.

use hysteron_identify::design::DesignOptions;
use hysteron_model::model::{DecouplingRequest, InverseRequest};
use hysteron_model::tracking::TrackOptions;
use hysteron_report::shell::word;

use super::{Arguments, Words, beside, ids, joined, read, text};
use crate::api::{
    Command, DecoupleRequest, DownloadQuery, FollowRequest, RecordEntry, Reference, ScoresRequest,
    TrackAxesRequest, TrackRequest,
};

/// `hysteron validate`.
pub(crate) fn validate(model: &str, records: &[RecordEntry], request: &ScoresRequest) -> Command {
    let words = Words::new("validate").word(model).words(ids(records));
    let words = words
        .maybe("--skip", request.skip_s)
        .when("--fixed-offset", request.fixed_offset)
        .when("--continued", request.continued)
        .when("--correct", request.correct)
        .maybe("--rate", request.rate.as_ref())
        .maybe("-o", request.save.as_ref());
    let arguments = Arguments::default()
        .plain(read(records))
        .value("skip", request.skip_s)
        .when("fixed_offset", request.fixed_offset)
        .when("continued", request.continued)
        .when("correct", request.correct);
    let python = format!("print(hy.load({}).scores({}))", text(model), arguments.done());
    beside(Command { shell: words.columns(records).done(), python }, records)
}

fn range_of(range: Option<[f64; 2]>) -> (Option<String>, Option<String>) {
    (range.map(|[low, high]| format!("{low}:{high}")), range.map(|[low, high]| format!("({low}, {high})")))
}

/// Flags and arguments of an inverse.
fn inverse(words: Words, arguments: Arguments, asked: &InverseRequest) -> (Words, Arguments) {
    let (range, limits) = range_of(asked.range);
    let words = words
        .maybe("--range", range)
        .maybe("--slew", asked.slew_per_s)
        .maybe("--bandwidth", asked.bandwidth_hz)
        .when("--periodic", asked.periodic)
        .maybe("--rest-voltage", asked.rest_voltage)
        .maybe("--virgin-voltage", asked.virgin_voltage)
        .maybe("--preview", asked.preview)
        .maybe("--predict-to", asked.predict_to_hz)
        .when("--correct", asked.correct);
    let arguments = arguments
        .value("limits", limits)
        .value("slew", asked.slew_per_s)
        .value("bandwidth", asked.bandwidth_hz)
        .when("periodic", asked.periodic)
        .value("rest", asked.rest_voltage)
        .value("virgin", asked.virgin_voltage)
        .value("preview", asked.preview)
        .value("predict_to", asked.predict_to_hz)
        .when("correct", asked.correct);
    (words, arguments)
}

/// `hysteron invert`.
pub(crate) fn invert(model: &str, request: &FollowRequest, reference: &str) -> Command {
    let file = request.save.as_deref().unwrap_or("drive.csv");
    let words = Words::new("invert").word(model).word(reference).with("-o", file);
    let words = words.maybe("--learn-from", request.learn_from.as_ref());
    let learned = request.learn_from.as_ref().map(|run| format!("hy.read({})", text(run)));
    let arguments =
        Arguments::default().plain(format!("hy.read({})", text(reference))).value("learn_from", learned);
    let (words, arguments) = inverse(words, arguments, &request.inverse);
    let command = Command {
        shell: words.done(),
        python: format!("drive = hy.load({}).invert({})", text(model), arguments.done()),
    };
    of_reference(command, &request.reference, reference, request.save.is_some())
}

/// `hysteron invert` of a model of several axes.
pub(crate) fn decouple(model: &str, request: &DecoupleRequest, file: &str) -> Command {
    let asked = &request.options;
    let words = Words::new("invert").word(model).word(&request.references).with("-o", file);
    let words = decoupled(words, asked)
        .maybe("--level", asked.level)
        .when("--periodic", asked.periodic)
        .maybe("--preview", asked.preview);
    let limits: Vec<String> = asked.ranges.iter().map(|[low, high]| format!("({low}, {high})")).collect();
    let arguments = Arguments::default()
        .plain(format!("hy.read({})", text(&request.references)))
        .value("limits", joined(&limits).map(|limits| format!("[{limits}]")))
        .value("slew", asked.slews_per_s.first())
        .value("bandwidth", asked.bandwidth_hz)
        .value("preview", asked.preview)
        .value("level", asked.level)
        .when("periodic", asked.periodic);
    let python = format!("drives = hy.load({}).decouple({})", text(model), arguments.done());
    Command { shell: words.done(), python }
}

/// `hysteron track` of a model of several axes.
pub(crate) fn track_axes(model: &str, request: &TrackAxesRequest, file: &str) -> Command {
    let asked = &request.options;
    let limits = DecouplingRequest {
        ranges: asked.ranges.clone(),
        slews_per_s: asked.slews_per_s.clone(),
        bandwidth_hz: asked.bandwidth_hz,
        ..DecouplingRequest::default()
    };
    let words = Words::new("track").word(model).word(&request.references).with("-o", file);
    let words = decoupled(words, &limits)
        .maybe("--preview", asked.preview)
        .maybe("--skip", asked.skip_s)
        .maybe("--seed", (asked.seed != 0).then_some(asked.seed));
    Command { shell: words.done(), python: "# in the shell alone".to_owned() }
}

/// Flags of the limits of several actuators.
fn decoupled(words: Words, asked: &DecouplingRequest) -> Words {
    let ranges: Vec<String> = asked.ranges.iter().map(|[low, high]| format!("{low}:{high}")).collect();
    let slews: Vec<String> = asked.slews_per_s.iter().map(f64::to_string).collect();
    words
        .maybe("--range", joined(&ranges))
        .maybe("--slew", joined(&slews))
        .maybe("--bandwidth", asked.bandwidth_hz)
}

/// `hysteron track`.
pub(crate) fn track(model: &str, request: &TrackRequest, reference: &str) -> Command {
    let (options, usual) = (&request.options, TrackOptions::default());
    let (range, limits) = range_of(options.range);
    let slew = Some(options.slew_per_s).filter(|slew| slew.is_finite());
    let [gain, phase] =
        [(options.margins.gain, usual.margins.gain), (options.margins.phase_deg, usual.margins.phase_deg)]
            .map(|(given, usual)| (given != usual).then_some(given));
    let names: Vec<&str> = options.controllers.iter().map(|controller| controller.name()).collect();
    let words = Words::new("track").word(model).word(reference).maybe("-o", request.save.as_ref());
    let words = names.iter().fold(words, |words, name| words.with("--controller", name));
    let words = words
        .maybe("--plant", request.on_model.then_some("model"))
        .maybe("--seed", Some(request.seed).filter(|seed| *seed != 0))
        .maybe("--range", range)
        .maybe("--slew", slew)
        .maybe("--bandwidth", options.bandwidth_hz)
        .maybe("--preview", options.preview)
        .maybe("--predict-to", options.predict_to_hz)
        .maybe("--virgin-voltage", options.virgin_v)
        .maybe("--gain-margin", gain)
        .maybe("--phase-margin", phase)
        .maybe("--lowest-frequency", options.realise.lowest_frequency_hz)
        .maybe("--skip", options.skip_s)
        .maybe("--sines", range_of(options.sines_hz).0);
    let quoted: Vec<String> = names.iter().map(|name| text(name)).collect();
    let arguments = Arguments::default()
        .plain(format!("hy.read({})", text(reference)))
        .value("controllers", (!quoted.is_empty()).then(|| format!("[{}]", quoted.join(", "))))
        .value("plant", request.on_model.then_some("\"model\""))
        .value("seed", Some(request.seed).filter(|seed| *seed != 0))
        .value("limits", limits)
        .value("slew", slew)
        .value("bandwidth", options.bandwidth_hz)
        .value("preview", options.preview)
        .value("predict_to", options.predict_to_hz);
    let command = Command {
        shell: words.done(),
        python: format!("print(hy.load({}).track({}))", text(model), arguments.done()),
    };
    of_reference(command, &request.reference, reference, request.save.is_some())
}

/// A command whose reference was drawn or generated, with a note where its file is not there yet.
fn of_reference(mut command: Command, from: &Reference, file: &str, saved: bool) -> Command {
    if !saved && !matches!(from, Reference::Record { .. }) {
        let note = format!("  # the download writes {}", word(file));
        command.shell += &note;
        command.python += &note;
    }
    command
}

/// `hysteron design`.
pub(crate) fn design(model: &str, options: &DesignOptions, file: &str) -> Command {
    let (range, limits) = range_of(options.range);
    let seed = Some(options.seed).filter(|seed| *seed != 0);
    let words = Words::new("design").word(model).with("--for", options.purpose.name());
    let shell = words
        .with("--time", format!("{}s", options.time_s))
        .maybe("--range", range)
        .maybe("--slew", options.slew_per_s)
        .maybe("--rate", options.sample_rate_hz)
        .maybe("--highest", options.highest_hz)
        .maybe("--noise", options.noise)
        .maybe("--resonance", options.resonance_hz)
        .maybe("--seed", seed)
        .with("-o", file)
        .done();
    let arguments = Arguments::default()
        .plain(format!("hy.load({})", text(model)))
        .plain(text(options.purpose.name()))
        .value("time", Some(options.time_s))
        .value("limits", limits)
        .value("slew", options.slew_per_s)
        .value("fs", options.sample_rate_hz)
        .value("highest", options.highest_hz)
        .value("noise", options.noise)
        .value("resonance", options.resonance_hz)
        .value("seed", seed);
    Command { shell, python: format!("hy.design({}).drive.save({})", arguments.done(), text(file)) }
}

/// `hysteron export`.
pub(crate) fn export(model: &str, name: &str, query: &DownloadQuery) -> Command {
    let Some(source) = query.form.source() else { return Command::default() };
    let (form, single) = (source.name(), query.single && source.has_single_precision());
    let words = Words::new("export").word(model).with("--to", form).with("-o", name);
    let words = if single { words.with("--float", "f32") } else { words };
    let words = words
        .maybe("--sample-rate", query.sample_rate_hz)
        .maybe("--name", query.name.as_ref())
        .maybe("--accuracy", query.accuracy)
        .maybe("--lowest-frequency", query.lowest_frequency_hz)
        .when("--inverse", query.inverse);
    let arguments = Arguments::default()
        .plain(text(name))
        .plain(text(form))
        .value("fs", query.sample_rate_hz)
        .text("name", Some(&name.to_owned()))
        .value("float_type", single.then_some("\"f32\""))
        .value("accuracy", query.accuracy)
        .value("lowest_frequency", query.lowest_frequency_hz)
        .when("inverse", query.inverse);
    let asked = if query.inverse { query.inverse_request() } else { InverseRequest::default() };
    let several: Vec<String> = query.ranges.iter().map(|[low, high]| format!("{low}:{high}")).collect();
    let pairs: Vec<String> = query.ranges.iter().map(|[low, high]| format!("({low}, {high})")).collect();
    let (words, arguments) = inverse(words, arguments, &asked);
    let controller = query.controller.map(|controller| controller.name());
    let words = words
        .maybe("--range", joined(&several))
        .maybe("--level", query.level)
        .maybe("--controller", controller);
    let arguments = arguments
        .value("limits", joined(&pairs).map(|pairs| format!("[{pairs}]")))
        .value("level", query.level)
        .text("controller", controller.map(str::to_owned).as_ref());
    Command { shell: words.done(), python: format!("hy.load({}).export({})", text(model), arguments.done()) }
}
