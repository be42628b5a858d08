//! Variables of an FMU and its `modelDescription.xml`.

use hysteron::realise::{Coefficients, OperatorCoefficients};
use hysteron_rt::Real;

use super::FmiVersion;
use crate::subject::{Subject, one_line};

/// First value reference of a parameter.
const FIRST_PARAMETER: usize = 4;

/// A number that may be changed while the model runs.
#[derive(Clone, Debug)]
pub(super) struct Parameter {
    pub name: String,
    pub unit: String,
    pub start: f64,
    /// Where it is in the state of the source.
    pub member: String,
    pub description: &'static str,
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
    let mut all = vec![Parameter {
        name: "offset".into(),
        unit: per(0),
        start: coefficients.offset.into(),
        member: "offset".into(),
        description: "Constant of the displacement",
    }];
    for (k, &c) in coefficients.polynomial.iter().enumerate() {
        all.push(Parameter {
            name: format!("polynomial_{}", k + 1),
            unit: per(k + 1),
            start: c.into(),
            member: format!("parameters.polynomial[{k}]"),
            description: "Coefficient of a power of the voltage",
        });
    }
    match coefficients.operator {
        OperatorCoefficients::BoucWen(operators) => {
            for (k, p) in operators.iter().enumerate() {
                let n: f64 = p.n().into();
                let rate =
                    if n == 1.0 { format!("1/{input}") } else { format!("{output}^{}/{input}", 1.0 - n) };
                let description = "Number of the Bouc-Wen operator";
                for (name, value, unit) in [
                    ("alpha", p.alpha(), per(1)),
                    ("beta", p.beta(), rate.clone()),
                    ("gamma", p.gamma(), rate),
                ] {
                    all.push(Parameter {
                        name: format!("{name}_{}", k + 1),
                        unit,
                        start: value.into(),
                        member: format!("parameters.operators[{k}].{name}"),
                        description,
                    });
                }
            }
        }
        OperatorCoefficients::Plays { weights, .. } => {
            for (k, &w) in weights.iter().enumerate() {
                all.push(Parameter {
                    name: format!("weight_{}", k + 1),
                    unit: per(1),
                    start: w.into(),
                    member: format!("parameters.weight[{k}]"),
                    description: "Weight of a play",
                });
            }
        }
    }
    all
}

/// `case` lines that find a parameter in the state.
pub(super) fn cases(parameters: &[Parameter]) -> String {
    let line = |(k, p): (usize, &Parameter)| {
        format!("    case {}:\n        return &state->{};", k + FIRST_PARAMETER, p.member)
    };
    parameters.iter().enumerate().map(line).collect::<Vec<_>>().join("\n")
}

fn xml(text: &str) -> String {
    one_line(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
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

fn units(subject: &Subject, parameters: &[Parameter]) -> String {
    let mut names: Vec<&str> = vec!["s", &subject.input_unit, &subject.output_unit];
    names.extend(parameters.iter().map(|p| p.unit.as_str()));
    names.sort_unstable();
    names.dedup();
    let unit = |name: &&str| format!("    <Unit name=\"{}\">{}</Unit>\n", xml(name), base_unit(name));
    format!("  <UnitDefinitions>\n{}  </UnitDefinitions>\n", names.iter().map(unit).collect::<String>())
}

/// The whole `modelDescription.xml`.
pub(super) fn description(
    subject: &Subject,
    parameters: &[Parameter],
    version: FmiVersion,
    token: &str,
) -> String {
    let name = &subject.name;
    let rate = subject.realisation.sample_rate_hz;
    let (low, high) = subject.voltages();
    let (input, output) = (xml(&subject.input_unit), xml(&subject.output_unit));
    let about = xml(&subject
        .description()
        .iter()
        .filter(|l| !l.is_empty())
        .map(|l| l.trim())
        .collect::<Vec<_>>()
        .join(" "));
    let range =
        if subject.range.is_some() { format!(" Identified from {low} to {high}.") } else { String::new() };
    let tool = format!("hysteron export {}", env!("CARGO_PKG_VERSION"));
    let period = 1.0 / rate;
    let in_words = "Status of the last sample: 0 done, 1 voltage outside of the range identified, -1 voltage not finite, -2 out of all reason";
    match version {
        FmiVersion::Two => {
            let real = |name: &str,
                        reference: usize,
                        attributes: &str,
                        about: &str,
                        unit: &str,
                        start: Option<f64>| {
                let start = start.map(|s| format!(" start=\"{s:?}\"")).unwrap_or_default();
                format!(
                    "    <ScalarVariable name=\"{name}\" valueReference=\"{reference}\" {attributes} description=\"{about}\"><Real \
                     unit=\"{unit}\"{start}/></ScalarVariable>\n"
                )
            };
            let mut variables = real(
                "voltage",
                1,
                r#"causality="input" variability="continuous""#,
                &format!("Voltage.{range}"),
                &input,
                Some(0.0),
            );
            variables += &real(
                "displacement",
                2,
                r#"causality="output" variability="continuous" initial="calculated""#,
                "Displacement after the last sample",
                &output,
                None,
            );
            variables += &format!(
                "    <ScalarVariable name=\"status\" valueReference=\"3\" causality=\"output\" variability=\"discrete\" initial=\"calculated\" description=\"{in_words}\"><Integer/></ScalarVariable>\n"
            );
            for (k, p) in parameters.iter().enumerate() {
                variables += &real(
                    &p.name,
                    k + FIRST_PARAMETER,
                    r#"causality="parameter" variability="tunable" initial="exact""#,
                    p.description,
                    &xml(&p.unit),
                    Some(p.start),
                );
            }
            format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"2.0\" modelName=\"{name}\" guid=\"{token}\" \
                 description=\"{about}\" generationTool=\"{tool}\" variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n  \
                 <CoSimulation modelIdentifier=\"{name}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" \
                 canSerializeFMUstate=\"true\" needsExecutionTool=\"false\">\n    <SourceFiles>\n      <File name=\"{name}.c\"/>\n      <File \
                 name=\"fmi2.c\"/>\n    </SourceFiles>\n  </CoSimulation>\n{}  <DefaultExperiment startTime=\"0\" stopTime=\"1\" stepSize=\"{period:e}\"/>\n  \
                 <ModelVariables>\n{variables}  </ModelVariables>\n  <ModelStructure>\n    <Outputs>\n      <Unknown index=\"2\"/>\n      <Unknown index=\"3\"/>\n    \
                 </Outputs>\n    <InitialUnknowns>\n      <Unknown index=\"2\"/>\n      <Unknown index=\"3\"/>\n    </InitialUnknowns>\n  </ModelStructure>\n</fmiModelDescription>\n",
                units(subject, parameters)
            )
        }
        FmiVersion::Three => {
            let real = |name: &str,
                        reference: usize,
                        attributes: &str,
                        about: &str,
                        unit: &str,
                        start: Option<f64>| {
                let start = start.map(|s| format!(" start=\"{s:?}\"")).unwrap_or_default();
                format!(
                    "    <Float64 name=\"{name}\" valueReference=\"{reference}\" {attributes} description=\"{about}\" unit=\"{unit}\"{start}/>\n"
                )
            };
            let mut variables = real(
                "time",
                0,
                r#"causality="independent" variability="continuous""#,
                "Simulation time",
                "s",
                None,
            );
            variables += &real(
                "voltage",
                1,
                r#"causality="input" variability="continuous""#,
                &format!("Voltage.{range}"),
                &input,
                Some(0.0),
            );
            variables += &real(
                "displacement",
                2,
                r#"causality="output" variability="continuous" initial="calculated""#,
                "Displacement after the last sample",
                &output,
                None,
            );
            variables += &format!(
                "    <Int32 name=\"status\" valueReference=\"3\" causality=\"output\" variability=\"discrete\" initial=\"calculated\" description=\"{in_words}\"/>\n"
            );
            for (k, p) in parameters.iter().enumerate() {
                variables += &real(
                    &p.name,
                    k + FIRST_PARAMETER,
                    r#"causality="parameter" variability="tunable" initial="exact""#,
                    p.description,
                    &xml(&p.unit),
                    Some(p.start),
                );
            }
            format!(
                "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" \
                 instantiationToken=\"{token}\" description=\"{about}\" generationTool=\"{tool}\" variableNamingConvention=\"flat\">\n  \
                 <CoSimulation modelIdentifier=\"{name}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"true\" \
                 canSerializeFMUState=\"true\" fixedInternalStepSize=\"{period:e}\"/>\n{}  <DefaultExperiment startTime=\"0\" stopTime=\"1\" \
                 stepSize=\"{period:e}\"/>\n  <ModelVariables>\n{variables}  </ModelVariables>\n  <ModelStructure>\n    <Output valueReference=\"2\"/>\n    <Output \
                 valueReference=\"3\"/>\n    <InitialUnknown valueReference=\"2\"/>\n    <InitialUnknown valueReference=\"3\"/>\n  </ModelStructure>\n</fmiModelDescription>\n",
                units(subject, parameters)
            )
        }
    }
}

/// `buildDescription.xml` of FMI 3.0: how the sources are compiled.
pub(super) fn build_description(name: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  <BuildConfiguration modelIdentifier=\"{name}\">\n    \
         <SourceFileSet language=\"C99\">\n      <SourceFile name=\"{name}.c\"/>\n      <SourceFile name=\"fmi3.c\"/>\n    </SourceFileSet>\n    <Library \
         name=\"m\" external=\"true\"/>\n  </BuildConfiguration>\n</fmiBuildDescription>\n"
    )
}
