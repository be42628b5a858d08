//! Remedies of the library in flags of the command.

use hysteron_model::advice::ColumnRole;
use hysteron_model::{Advice, Finding};

/// Flags that choose the columns of a record with one input and one output.
pub const INPUT_AND_OUTPUT: &str = "--input and --output";

/// The flags that follow an advice.
pub fn in_flags(advice: &Advice) -> String {
    in_flags_of_columns(advice, INPUT_AND_OUTPUT)
}

/// [`in_flags`] where columns are chosen with other flags.
pub fn in_flags_of_columns(advice: &Advice, choose_columns: &str) -> String {
    match advice {
        Advice::ChooseColumn { role, example } => {
            let column = example.as_deref().unwrap_or(match role {
                ColumnRole::Scaled => "COL=FACTOR",
                ColumnRole::Condition => "COL=VALUE",
                ColumnRole::Renamed => "OLD=NEW",
                _ => "COL",
            });
            format!("{} {column}", flag_of(*role))
        }
        Advice::ChooseColumns => choose_columns.to_owned(),
        Advice::ChooseResponse { divisor: false } => "--response NAME".to_owned(),
        Advice::ChooseResponse { divisor: true } => "--over NAME".to_owned(),
        Advice::ScaleColumn { column } => format!("--scale {column}=2.5um/V"),
        Advice::GiveSampleRate => "--sample-rate HZ".to_owned(),
        Advice::Resample => {
            "hysteron prepare RECORD --rate HZ -o OUT.csv, or --sample-rate HZ where there is no time or it \
             is badly written"
                .to_owned()
        }
        Advice::ContinueRun => "--continued".to_owned(),
        Advice::CutOtherwise => "another --from, --to, --where or --turns".to_owned(),
        Advice::GiveStart { at_voltage: true } => "--rest-voltage or --settled say otherwise".to_owned(),
        Advice::GiveStart { at_voltage: false } => "--settled says otherwise".to_owned(),
        Advice::ScoreAll => "--skip 0 scores them".to_owned(),
        Advice::GivePeriod => "--period S".to_owned(),
        Advice::NameDynamicRecord => "--dynamic FILE".to_owned(),
        Advice::DriveRange => "--range LOW:HIGH".to_owned(),
        Advice::DriveRate => "--slew PER_SECOND".to_owned(),
        Advice::CorrectDrive => "--correct".to_owned(),
        Advice::CreepThatEnds => "hysteron identify … --creep kelvin-voigt".to_owned(),
        Advice::NarrowBand => "--band LOW:HIGH".to_owned(),
        Advice::OtherHysteresis => "--hysteresis FAMILY".to_owned(),
        Advice::OtherKind { kind } => format!("--structure {kind}"),
        Advice::DeadBand { threshold, excess: false } => format!("--dead-band {threshold}"),
        Advice::DeadBand { threshold, excess: true } => format!("--dead-zone {threshold}"),
        Advice::SeveralAxes { inputs, outputs } => {
            format!("--inputs {} --outputs {}", inputs.join(","), outputs.join(","))
        }
        Advice::FitJointly => "leave --method and --dynamics arx (oe, bj, srivc) out".to_owned(),
        Advice::NoDynamics => {
            "--dynamics none, hysteron prepare RECORD --rate HZ -o OUT.csv, or --sample-rate HZ".to_owned()
        }
        Advice::Widen { parameter } => format!("--bound {parameter}=LOW:HIGH"),
        Advice::Hold { parameter } => format!("--fix {}=VALUE", parameter.as_deref().unwrap_or("NAME")),
        Advice::SearchLonger => "--generations N, or leave --optimizer out".to_owned(),
        Advice::GiveLowestFrequency => "--lowest-frequency HZ".to_owned(),
        Advice::GiveExponent => "--exponent P".to_owned(),
    }
}

fn flag_of(role: ColumnRole) -> &'static str {
    match role {
        ColumnRole::Input => "--input",
        ColumnRole::Output => "--output",
        ColumnRole::Reference => "--reference",
        ColumnRole::Time => "--time",
        ColumnRole::Inputs => "--inputs",
        ColumnRole::Scaled => "--scale",
        ColumnRole::Condition => "--where",
        ColumnRole::Detrended => "--detrend or --remove-mean",
        ColumnRole::Renamed => "--rename",
        ColumnRole::LeftOut => "--drop",
    }
}

/// A finding's statement, with the flags that follow its advice.
pub fn text(finding: &Finding) -> String {
    with_flags(&finding.text, finding.advice.as_ref())
}

/// A statement, with the flags that follow its advice.
pub fn with_flags(text: &str, advice: Option<&Advice>) -> String {
    match advice {
        Some(advice) => format!("{text} ({})", in_flags(advice)),
        None => text.to_owned(),
    }
}
