//! The model file of an identification.

use std::collections::BTreeMap;

use hysteron_model::Start;
use hysteron_model::dynamics::Creep;
use hysteron_model::model_file::{
    Maker, MisfitEntry, ModelFile, Normalisation, Provenance, RecordEntry, RecordRole as RoleEntry,
    ScoreEntry, ScoreRole, SignalUnits, ValidRange,
};

use crate::misfit::Misfit;
use crate::{Choice, DynamicsChoice, Identification, Method, Options, RecordFit, RecordRole};

impl Identification {
    /// Model file: parameters with standard errors, range of validity, provenance with these `options`,
    /// scores.
    pub fn model_file(&self, options: &Options, maker: &Maker) -> ModelFile {
        self.written(options, maker).0
    }

    /// The model file, and the misfit that it holds; `None` where the file has no covariance, without which
    /// there is no band.
    pub(crate) fn written(&self, options: &Options, maker: &Maker) -> (ModelFile, Option<Misfit>) {
        let mut file = model_file(self, options, maker);
        let misfit = file.correlation.is_some().then(|| self.misfit());
        if let Some(Misfit::Outside(misfit)) = &misfit {
            file.misfit = Some(MisfitEntry::from(&**misfit));
        }
        (file, misfit)
    }
}

fn model_file(found: &Identification, options: &Options, maker: &Maker) -> ModelFile {
    let first = found.records.first().map(|r| &r.data);
    let units = first.map_or_else(SignalUnits::default, |d| SignalUnits::of(&d.u_unit, &d.y_unit));
    let input = units.input.clone();
    let mut file = ModelFile::from_model(&found.model, units);
    match &found.of_numbers {
        Some(known) => file.set_covariance(&known.names, &known.of_determined()),
        None => give_errors(&mut file, found),
    }
    if found.method == Method::Joint {
        file.normalisation = match options.dynamics {
            DynamicsChoice::FractionalFreeLowest => Normalisation::UnitGainAt1Hz,
            _ if found.structure.creep != Creep::None => Normalisation::Free,
            _ => Normalisation::UnitDcGain,
        };
    }
    if let Some(record) = found.records.first() {
        file.set_start(start(record));
    }
    file.valid_range = Some(valid_range(found, &input));
    file.provenance = Some(provenance(found, options, maker));
    file.scores = found
        .records
        .iter()
        .map(|r| ScoreEntry::new(&r.data.name, ScoreRole::Training, r.data.y_unit.symbol(), &r.scores))
        .collect();
    file
}

/// Writes the standard errors of the two steps, which give no correlation between them.
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

/// Name in the file of a coefficient of a polynomial model: b2 is that of z⁻² or s² above, f1 and a0 are
/// below.
fn coefficient(name: &str) -> Option<String> {
    let (list, place) = match name.split_at_checked(1)? {
        ("b", place) => ("numerator", place),
        ("f" | "a", place) => ("denominator", place),
        _ => return None,
    };
    let place: usize = place.parse().ok()?;
    Some(format!("{list}[{place}].coefficient"))
}

/// State of the device before the first record; a rest at its first sample applies to each record separately.
fn start(record: &RecordFit) -> Start {
    match record.start {
        Start::Rest { voltage_v } | Start::Remembering { voltage_v, .. }
            if record.data.u.first() == Some(&voltage_v) =>
        {
            Start::AsIdentified
        }
        other => other,
    }
}

fn valid_range(found: &Identification, unit: &str) -> ValidRange {
    let inputs = found.records.iter().flat_map(|r| &r.data.u);
    let range = ValidRange::of_inputs(inputs, unit, found.excited_hz);
    let rates = found.records.iter().filter_map(|r| {
        let fs = r.data.sample_rate_hz()?;
        Some(r.data.u.windows(2).map(|w| (w[1] - w[0]).abs() * fs).fold(0.0, f64::max))
    });
    match rates.reduce(f64::max) {
        Some(largest) => range.with_rate(largest),
        None => range,
    }
}

fn provenance(found: &Identification, options: &Options, maker: &Maker) -> Provenance {
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
        ("inter-sample".to_owned(), found.model.inter_sample.name().to_owned()),
    ]);
    if options.dynamics.takes_two_steps() {
        named.insert("dynamics".into(), options.dynamics.in_words().into());
    }
    if found.method == Method::Joint {
        named.insert("initial".into(), options.initial.name().into());
        named.insert("creep".into(), found.structure.creep.name().into());
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
    let entry = |r: &RecordFit| {
        let role = match r.role {
            RecordRole::QuasiStatic => RoleEntry::Static,
            RecordRole::Dynamic => RoleEntry::Dynamic,
        };
        RecordEntry::of(&r.data, role)
    };
    Provenance::new(maker, found.records.iter().map(entry).collect(), named, Some(options.seed))
}
