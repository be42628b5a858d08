//! Variables of an FMU and its `modelDescription.xml`.

use std::collections::BTreeMap;

use hysteron_model::realise::Coefficients;
use hysteron_rt::{Real, StateLaw};

use super::FmiVersion;
use super::axes_unit::AxesUnit;
use crate::closed_loop::ClosedLoop;
use crate::escape::xml;
use crate::inverse::Inverse;
use crate::operator::OperatorNumbers;
use crate::subject::Subject;

/// First value reference of a parameter.
const FIRST_PARAMETER: usize = 6;

/// A number that may be changed while the model runs.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: String,
    pub unit: String,
    pub start: f64,
    /// Its member of the state in the source.
    pub member: String,
    pub description: String,
}

/// Tunable parameters of a model.
pub(super) fn parameters<T: Real + Into<f64>>(
    subject: &Subject,
    coefficients: &Coefficients<'_, T>,
) -> Vec<Parameter> {
    let (input, output) = (&subject.input_unit, &subject.output_unit);
    let per = |power: usize| match power {
        0 => output.clone(),
        1 => format!("{output}/{input}"),
        _ => format!("{output}/{input}^{power}"),
    };
    let mut all = trims(subject, coefficients.offset.into()).to_vec();
    for (k, &c) in coefficients.polynomial.iter().enumerate() {
        all.push(Parameter {
            name: format!("polynomial_{}", k + 1),
            unit: per(k + 1),
            start: c.into(),
            member: format!("parameters.polynomial[{k}]"),
            description: "Coefficient of a power of the voltage".into(),
        });
    }
    let numbers = OperatorNumbers::new(coefficients.operator);
    if let Some((parameters, units)) = &numbers.states {
        let [names @ .., _] = StateLaw::<T>::PARAMETERS;
        for (k, own) in parameters.iter().enumerate() {
            let [values @ .., n] = *own;
            for ((name, value), unit) in names.into_iter().zip(values).zip(units) {
                all.push(Parameter {
                    name: format!("{name}_{}", k + 1),
                    unit: unit.of_exponent(n.into(), input, output),
                    start: value.into(),
                    member: format!("parameters.state_laws[{k}].{name}"),
                    description: "Parameter of a state of the hysteresis".into(),
                });
            }
        }
    }
    let form = subject.realisation.model.hysteresis.form().description();
    if let Some((what, weights)) = numbers.weights {
        all.extend(weights.into_iter().enumerate().map(|(k, weight)| Parameter {
            name: format!("weight_{}", k + 1),
            unit: form.weight_unit(k).of(input, output),
            start: weight.into(),
            member: format!("parameters.weight[{k}]"),
            description: format!("Weight of a {what}"),
        }));
    }
    all
}

/// The trims, which every unit of one axis has.
fn trims(subject: &Subject, offset: f64) -> [Parameter; 2] {
    [
        Parameter {
            name: "offset".into(),
            unit: subject.output_unit.clone(),
            start: offset,
            member: "trims.offset".into(),
            description: "Constant of the displacement".into(),
        },
        Parameter {
            name: "gain".into(),
            unit: "1".into(),
            start: 1.0,
            member: "trims.gain".into(),
            description: "Factor of what the model gives; not 0".into(),
        },
    ]
}

/// `case` lines that find a parameter in the state.
pub(super) fn cases(parameters: &[Parameter]) -> String {
    let line = |(k, p): (usize, &Parameter)| {
        format!("    case {}:\n        return &state->{};", k + FIRST_PARAMETER, p.member)
    };
    parameters.iter().enumerate().map(line).collect::<Vec<_>>().join("\n")
}

/// `<BaseUnit …>` for the units of piezo stages; nothing for others, which are names alone.
fn base_unit(unit: &str) -> String {
    let (factor, exponents) = match unit {
        "V" => (1.0, r#"kg="1" m="2" s="-3" A="-1""#),
        "mV" => (1e-3, r#"kg="1" m="2" s="-3" A="-1""#),
        "kV" => (1e3, r#"kg="1" m="2" s="-3" A="-1""#),
        "A" => (1.0, r#"A="1""#),
        "m" => (1.0, r#"m="1""#),
        "mm" => (1e-3, r#"m="1""#),
        "um" => (1e-6, r#"m="1""#),
        "nm" => (1e-9, r#"m="1""#),
        "rad" => (1.0, r#"rad="1""#),
        "mrad" => (1e-3, r#"rad="1""#),
        "urad" => (1e-6, r#"rad="1""#),
        "um/V" => (1e-6, r#"kg="-1" m="-1" s="3" A="1""#),
        "s" => (1.0, r#"s="1""#),
        _ => return String::new(),
    };
    format!("<BaseUnit {exponents} factor=\"{factor:e}\"/>")
}

fn units(own: [&str; 2], parameters: &[Parameter]) -> String {
    let mut names: Vec<&str> = vec!["s", own[0], own[1]];
    names.extend(parameters.iter().map(|p| p.unit.as_str()));
    // Different texts may be the same name in XML, which must be defined once.
    let names: BTreeMap<String, &str> = names.into_iter().map(|name| (xml(name), name)).collect();
    let unit = |(xml, name)| format!("    <Unit name=\"{xml}\">{}</Unit>\n", base_unit(name));
    format!("  <UnitDefinitions>\n{}  </UnitDefinitions>\n", names.into_iter().map(unit).collect::<String>())
}

/// A variable that is no tunable parameter.
pub(super) struct Variable {
    pub name: String,
    pub reference: usize,
    /// Causality, variability and initial, as attributes of either version.
    pub attributes: &'static str,
    pub about: String,
    /// None: a whole number.
    pub unit: Option<String>,
    pub start: Option<f64>,
}

pub(super) const INPUT: &str = r#"causality="input" variability="continuous""#;
pub(super) const OUTPUT: &str = r#"causality="output" variability="continuous" initial="calculated""#;
pub(super) const WHOLE_OUTPUT: &str = r#"causality="output" variability="discrete" initial="calculated""#;
pub(super) const FIXED: &str = r#"causality="parameter" variability="fixed" initial="exact""#;
const TUNABLE: &str = r#"causality="parameter" variability="tunable" initial="exact""#;

/// Input and output variables, in the order of the file.
fn signals(subject: &Subject, inverse: Option<&Inverse>) -> Vec<Variable> {
    let variable = |name: &str, reference, attributes, about: &str, unit: Option<&str>, start| Variable {
        name: name.to_owned(),
        reference,
        attributes,
        about: about.to_owned(),
        unit: unit.map(xml),
        start,
    };
    let (input, output) = (Some(subject.input_unit.as_str()), Some(subject.output_unit.as_str()));
    let range =
        subject.range.as_ref().map(|r| format!(" Identified from {} to {}.", r.input.low, r.input.high));
    let Some(inverse) = inverse else {
        let about = format!("Voltage.{}", range.unwrap_or_default());
        let status = "Status of the last sample: 0 done, 1 voltage outside of the range identified, -1 \
                      voltage not finite, -2 out of all reason";
        return vec![
            variable("voltage", 1, INPUT, &about, input, Some(0.0)),
            variable("displacement", 2, OUTPUT, "Displacement after the last sample", output, None),
            variable("status", 3, WHOLE_OUTPUT, status, None, None),
        ];
    };
    let about = format!("Reference, {} samples ahead", inverse.compensation.preview);
    let status = "Status of the last sample: 0 followed, 1 limited by the range, 2 by the slew rate, -1 \
                  reference not finite, -2 out of all reason";
    let [low, high] = inverse.range_v;
    vec![
        variable("reference", 1, INPUT, &about, output, Some(subject.realisation.model.offset)),
        variable("voltage", 2, OUTPUT, &format!("Voltage for the next period, {low} to {high}"), input, None),
        variable("status", 3, WHOLE_OUTPUT, status, None, None),
        variable("displacement", 4, OUTPUT, "Displacement of the model", output, None),
        variable(
            "rest_voltage",
            5,
            FIXED,
            "Voltage that the stage rests at before",
            input,
            Some(0.0_f64.clamp(low, high)),
        ),
    ]
}

/// What the description of a unit is made of.
pub(super) struct Described {
    pub name: String,
    about: String,
    period: f64,
    units: String,
    signals: Vec<Variable>,
    parameters: Vec<Parameter>,
}

impl Described {
    /// A model of one axis, or its inverse.
    pub(super) fn one(subject: &Subject, inverse: Option<&Inverse>, parameters: &[Parameter]) -> Self {
        Self {
            name: subject.name.clone(),
            about: on_a_line(&inverse.map_or_else(|| subject.description(), Inverse::description)),
            period: 1.0 / subject.realisation.sample_rate_hz,
            units: units([&subject.input_unit, &subject.output_unit], parameters),
            signals: signals(subject, inverse),
            parameters: parameters.to_vec(),
        }
    }

    /// A controller.
    pub(super) fn controller(closed: &ClosedLoop) -> Self {
        let subject = &closed.inverse.subject;
        let offset = subject.precision.round(subject.realisation.model.offset);
        let parameters = trims(subject, offset).to_vec();
        let mut signals = signals(subject, Some(&closed.inverse));
        for signal in &mut signals {
            if signal.name == "reference" {
                signal.about = format!("Reference, {} samples ahead of the reading", closed.preview() + 1);
            } else if signal.name == "status" {
                signal.about = signal.about.replace("reference not", "reference or reading not");
            }
        }
        signals.push(Variable {
            name: "reading".into(),
            reference: FIRST_PARAMETER + parameters.len(),
            attributes: INPUT,
            about: "Displacement read of the stage".into(),
            unit: Some(xml(&subject.output_unit)),
            start: Some(offset),
        });
        Self {
            name: closed.name.clone(),
            about: on_a_line(&closed.description()),
            period: 1.0 / subject.realisation.sample_rate_hz,
            units: units([&subject.input_unit, &subject.output_unit], &parameters),
            signals,
            parameters,
        }
    }

    /// A model of several axes, or its inverse.
    pub(super) fn several(unit: &AxesUnit) -> Self {
        Self {
            name: unit.name.clone(),
            about: on_a_line(&unit.description),
            period: 1.0 / unit.sample_rate_hz,
            units: units(unit.units.each_ref().map(String::as_str), &[]),
            signals: unit.signals(),
            parameters: Vec::new(),
        }
    }
}

/// Text of a description.
fn on_a_line(lines: &[String]) -> String {
    xml(&lines.iter().map(|l| l.trim()).filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" "))
}

/// The whole `modelDescription.xml`.
pub(super) fn description(
    described: &Described,
    version: FmiVersion,
    token: &str,
    sources: &[String],
) -> String {
    let Described { name, about, period, units, signals: all, parameters } = described;
    let tool = format!("hysteron export {}", env!("CARGO_PKG_VERSION"));
    let outputs: Vec<usize> =
        (1..).zip(all).filter(|(_, v)| v.attributes.contains("output")).map(|(k, _)| k).collect();
    let references: Vec<usize> = outputs.iter().filter_map(|k| Some(all.get(k - 1)?.reference)).collect();
    let lines_of =
        |list: &[usize], line: &dyn Fn(usize) -> String| list.iter().map(|&k| line(k)).collect::<String>();
    let tuned = parameters.iter().enumerate().map(|(k, p)| (p, k + FIRST_PARAMETER));
    let start = |x: Option<f64>| x.map(|s| format!(" start=\"{s:?}\"")).unwrap_or_default();
    let experiment =
        format!("  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"{period:e}\"/>\n");
    match version {
        FmiVersion::Two => {
            let line = |name: &str, reference: usize, attributes: &str, about: &str, kind: &str| {
                format!(
                    "    <ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {attributes} \
                     description=\"{about}\">{kind}</ScalarVariable>\n"
                )
            };
            let real = |unit: &str, from: Option<f64>| format!("<Real unit=\"{unit}\"{}/>", start(from));
            let mut variables = String::new();
            for v in all {
                let kind =
                    v.unit.as_ref().map_or_else(|| "<Integer/>".to_owned(), |unit| real(unit, v.start));
                variables += &line(&v.name, v.reference, v.attributes, &v.about, &kind);
            }
            for (p, reference) in tuned {
                variables +=
                    &line(&p.name, reference, TUNABLE, &p.description, &real(&xml(&p.unit), Some(p.start)));
            }
            let files = source_lines("      <File", sources);
            let unknowns = lines_of(&outputs, &|k| format!("      <Unknown index=\"{k}\"/>\n"));
            format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" \
                 modelName=\"{name}\" guid=\"{token}\" \
                 description=\"{about}\" generationTool=\"{tool}\" variableNamingConvention=\"flat\" \
                 numberOfEventIndicators=\"0\">\n  \
                 <CoSimulation modelIdentifier=\"{name}\" canHandleVariableCommunicationStepSize=\"true\" \
                 canGetAndSetFMUstate=\"true\" \
                 canSerializeFMUstate=\"true\" needsExecutionTool=\"false\">\n    <SourceFiles>\n{files}    </SourceFiles>\n  </CoSimulation>\n{units}{experiment}  \
                 <ModelVariables>\n{variables}  </ModelVariables>\n  \
                 <ModelStructure>\n    <Outputs>\n{unknowns}    </Outputs>\n    \
                 <InitialUnknowns>\n{unknowns}    </InitialUnknowns>\n  \
                 </ModelStructure>\n</fmiModelDescription>\n"
            )
        }
        FmiVersion::Three => {
            let line =
                |kind: &str, name: &str, reference: usize, attributes: &str, about: &str, rest: &str| {
                    format!(
                        "    <{kind} name=\"{name}\" valueReference=\"{reference}\" {attributes} \
                     description=\"{about}\"{rest}/>\n"
                    )
                };
            let real = |unit: &str, from: Option<f64>| format!(" unit=\"{unit}\"{}", start(from));
            let time = r#"causality="independent" variability="continuous""#;
            let mut variables = line("Float64", "time", 0, time, "Simulation time", &real("s", None));
            for v in all {
                let (kind, rest) = v
                    .unit
                    .as_ref()
                    .map_or_else(|| ("Int32", String::new()), |unit| ("Float64", real(unit, v.start)));
                variables += &line(kind, &v.name, v.reference, v.attributes, &v.about, &rest);
            }
            for (p, reference) in tuned {
                variables += &line(
                    "Float64",
                    &p.name,
                    reference,
                    TUNABLE,
                    &p.description,
                    &real(&xml(&p.unit), Some(p.start)),
                );
            }
            let list =
                |tag: &str| lines_of(&references, &|r| format!("    <{tag} valueReference=\"{r}\"/>\n"));
            let (results, unknowns) = (list("Output"), list("InitialUnknown"));
            format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" \
                 modelName=\"{name}\" \
                 instantiationToken=\"{token}\" description=\"{about}\" generationTool=\"{tool}\" \
                 variableNamingConvention=\"flat\">\n  \
                 <CoSimulation modelIdentifier=\"{name}\" canHandleVariableCommunicationStepSize=\"true\" \
                 canGetAndSetFMUState=\"true\" \
                 canSerializeFMUState=\"true\" fixedInternalStepSize=\"{period:e}\"/>\n{units}{experiment}  \
                 <ModelVariables>\n{variables}  \
                 </ModelVariables>\n  <ModelStructure>\n{results}{unknowns}  \
                 </ModelStructure>\n</fmiModelDescription>\n"
            )
        }
    }
}

/// `buildDescription.xml` of FMI 3.0: how the sources are compiled.
pub(super) fn build_description(name: &str, sources: &[String]) -> String {
    let files = source_lines("      <SourceFile", sources);
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
         <BuildConfiguration modelIdentifier=\"{name}\">\n    \
         <SourceFileSet language=\"C99\">\n{files}    </SourceFileSet>\n    <Library \
         name=\"m\" external=\"true\"/>\n  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
}

/// An element for every source that is compiled.
fn source_lines(opening: &str, sources: &[String]) -> String {
    sources.iter().map(|file| format!("{opening} name=\"{file}\"/>\n")).collect()
}
