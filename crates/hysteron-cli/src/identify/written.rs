//! The model file of an identification.

use std::collections::BTreeMap;
use std::time::SystemTime;

use hysteron_identify::{
    CampaignRecord, Choice, DynamicsChoice, Identification, Initial, Method, Options, RecordFit, RecordRole,
};
use hysteron_model::dynamics::Creep;
use hysteron_model::hammerstein::Start;
use hysteron_model::model_file::{
    Interval, ModelFile, Normalisation, Provenance, Quantity, RecordEntry, RecordRole as RoleEntry,
    ScoreEntry, ScoreRole, SignalUnits, StartEntry, StartKind, ValidRange, timestamp,
};
use hysteron_model::record::InterSample;

/// The file: model, standard errors, range, how it was made, scores.
pub fn model_file(found: &Identification, campaign: &[CampaignRecord], options: &Options) -> ModelFile {
    let (input, output) = campaign
        .first()
        .map(|r| (r.data.u_unit.symbol().to_owned(), r.data.y_unit.symbol().to_owned()))
        .unwrap_or_default();
    let mut file = ModelFile::from_model(&found.model, SignalUnits { input: input.clone(), output });
    match &found.of_numbers {
        Some(known) => file.set_covariance(&known.names, &known.matrix),
        None => give_errors(&mut file, found),
    }
    if found.method == Method::Joint {
        file.normalisation = match options.dynamics {
            DynamicsChoice::FractionalFreeLowest => Normalisation::UnitGainAt1Hz,
            _ if creep(found) != Creep::None => Normalisation::Free,
            _ => Normalisation::UnitDcGain,
        };
    }
    if let Some(record) = found.records.first() {
        file.start = start(record, &input);
    }
    file.valid_range = Some(valid_range(found, &input));
    file.provenance = Some(provenance(found, options));
    file.scores = found
        .records
        .iter()
        .map(|r| ScoreEntry::new(&r.data.name, ScoreRole::Training, r.data.y_unit.symbol(), &r.scores))
        .collect();
    file
}

fn creep(found: &Identification) -> Creep {
    Creep::of_names(found.parameters.iter().map(|p| p.name.as_str()))
}

/// Standard errors of two steps, which know nothing of each other: there is no correlation between them.
fn give_errors(file: &mut ModelFile, found: &Identification) {
    for parameter in &found.parameters {
        let name = match parameter.name.as_str() {
            "b" => "numerator[0].coefficient",
            "c0" => "denominator[0].coefficient",
            "c1" => "denominator[1].coefficient",
            "order1" => "denominator[1].order",
            "order2" => "denominator[2].order",
            name => name,
        };
        let name = &coefficient(name).unwrap_or_else(|| name.to_owned());
        if let (Some(error), Some(number)) = (parameter.std_error, file.number_mut(name)) {
            number.std_error = Some(error);
        }
    }
}

/// Name in the file of a coefficient of a polynomial model: b2 is that of z⁻² or s² above, f1 and a0 are below.
fn coefficient(name: &str) -> Option<String> {
    let (list, place) = match name.split_at_checked(1)? {
        ("b", place) => ("numerator", place),
        ("f" | "a", place) => ("denominator", place),
        _ => return None,
    };
    let place: usize = place.parse().ok()?;
    Some(format!("{list}[{place}].coefficient"))
}

/// What the device did before the first record; a rest at that record's own first sample is each record's own.
fn start(record: &RecordFit, unit: &str) -> StartEntry {
    match record.start {
        Start::Settled { .. } => StartEntry { kind: StartKind::Settled, voltage: None },
        Start::AsIdentified => StartEntry::default(),
        Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. } => {
            let own = record.data.u.first() == Some(&voltage_v);
            let unit = if unit.is_empty() { "1" } else { unit };
            StartEntry { kind: StartKind::Rest, voltage: (!own).then(|| Quantity::new(voltage_v, unit)) }
        }
    }
}

fn valid_range(found: &Identification, unit: &str) -> ValidRange {
    let mut input = (f64::INFINITY, f64::NEG_INFINITY);
    let mut rate: f64 = 0.0;
    let mut timed = false;
    for record in &found.records {
        for &u in &record.data.u {
            input = (input.0.min(u), input.1.max(u));
        }
        if let Some(fs) = record.data.sample_rate_hz() {
            timed = true;
            rate = record.data.u.windows(2).map(|w| (w[1] - w[0]).abs() * fs).fold(rate, f64::max);
        }
    }
    let interval = |low, high, unit: &str| Interval { low, high, unit: unit.to_owned() };
    let per_second = if unit.is_empty() { "1/s".to_owned() } else { format!("{unit}/s") };
    ValidRange {
        input: interval(input.0, input.1, if unit.is_empty() { "1" } else { unit }),
        frequency: found.excited_hz.map(|(low, high)| interval(low, high, "Hz")),
        rate: timed.then(|| interval(0.0, rate, &per_second)),
    }
}

fn provenance(found: &Identification, options: &Options) -> Provenance {
    let choice = |text: Option<String>| text.unwrap_or_else(|| "auto".into());
    let given = |c: Choice<f64>| match c {
        Choice::Given(x) => Some(x.to_string()),
        Choice::Auto => None,
    };
    let degree = found.structure.degree;
    let degree_text =
        if options.degree == Choice::Auto { format!("{degree} (auto)") } else { degree.to_string() };
    let algorithm = options.algorithm.as_ref().map_or("auto (least-squares)", |a| a.name());
    let mut named = BTreeMap::from([
        (
            "method".to_owned(),
            match found.method {
                Method::Joint => "joint".to_owned(),
                Method::TwoStep => "two-step".to_owned(),
            },
        ),
        ("optimizer".to_owned(), algorithm.to_owned()),
        ("degree".to_owned(), degree_text),
        ("n".to_owned(), choice(given(options.n)).replace("auto", "free")),
        ("delay".to_owned(), choice(given(options.delay_s))),
        ("scheme".to_owned(), found.model.scheme.name().to_owned()),
        ("inter-sample".to_owned(), inter_sample(found.model.inter_sample).to_owned()),
    ]);
    if options.dynamics.takes_two_steps() {
        named.insert("dynamics".into(), options.dynamics.name().into());
    }
    if found.method == Method::Joint {
        named.insert("initial".into(), initial(options.initial).into());
        named.insert("creep".into(), creep(found).name().into());
        named.insert("drift".into(), if options.drift { "yes".into() } else { "no".into() });
    }
    if options.algorithm.as_ref().is_some_and(|a| a.name() != "least-squares") {
        named.insert("generations".into(), options.generations.to_string());
    }
    for (name, value) in &options.demands.fixed {
        named.insert(format!("fix {name}"), value.to_string());
    }
    for (name, low, high) in &options.demands.bounded {
        named.insert(format!("bound {name}"), format!("{low}:{high}"));
    }
    Provenance {
        program: concat!("hysteron ", env!("CARGO_PKG_VERSION")).to_owned(),
        created: Some(timestamp(SystemTime::now())),
        records: found
            .records
            .iter()
            .map(|r| RecordEntry {
                path: r.data.source.as_ref().map_or(r.data.name.clone(), |s| s.path.clone()),
                sha256: r.data.source.as_ref().map(|s| s.sha256.clone()),
                samples: r.data.u.len() as u64,
                role: match r.role {
                    RecordRole::QuasiStatic => RoleEntry::Static,
                    RecordRole::Dynamic => RoleEntry::Dynamic,
                },
            })
            .collect(),
        options: named,
        seed: Some(options.seed),
        command: Some(command_line()),
    }
}

fn inter_sample(rule: InterSample) -> &'static str {
    match rule {
        InterSample::Hold => "hold",
        InterSample::Linear => "linear",
        InterSample::BandLimited => "band-limited",
    }
}

fn initial(initial: Initial) -> &'static str {
    match initial {
        Initial::Auto => "auto",
        Initial::Rest => "rest",
        Initial::Periodic => "periodic",
        Initial::Zero => "zero",
        Initial::Free => "free",
    }
}

/// The command as typed, quoted for a shell.
pub fn command_line() -> String {
    let quote = |word: String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
        if !word.is_empty() && word.chars().all(plain) {
            word
        } else {
            format!("'{}'", word.replace('\'', r"'\''"))
        }
    };
    let words = std::env::args_os().skip(1).map(|word| quote(word.to_string_lossy().into_owned()));
    std::iter::once("hysteron".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}
