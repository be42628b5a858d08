//! Flags that select a part of each record, shared by all commands that read records.

use clap::Args;
use hysteron_model::record::{Condition, Cut};

use crate::numbers::seconds;

/// Part of a record.
#[derive(Args, Clone, Debug)]
pub struct CutFlags {
    /// First time kept, in seconds or with a unit, e.g. 1.5s or 300ms
    #[arg(
        long, value_name = "TIME", value_parser = seconds, allow_hyphen_values = true,
        help_heading = "Part of the record",
    )]
    from: Option<f64>,

    /// Last time kept, in seconds or with a unit
    #[arg(
        long, value_name = "TIME", value_parser = seconds, allow_hyphen_values = true,
        help_heading = "Part of the record",
    )]
    to: Option<f64>,

    /// Keep samples where a column has this value, e.g. segment=2, segment=2..7 (both ends included),
    /// segment=2.. or, in a text column, segment=ramp; may be repeated: all must hold
    #[arg(
        long = "where", value_name = "COL=VALUE", value_parser = str::parse::<Condition>,
        help_heading = "Part of the record",
    )]
    conditions: Vec<Condition>,
}

impl CutFlags {
    /// The [`Cut`] that the flags describe.
    pub fn cut(&self) -> Cut {
        Cut { from_s: self.from, to_s: self.to, conditions: self.conditions.clone(), turns: None }
    }

    /// The flags as they are typed, each with its value.
    pub fn typed(&self) -> Vec<(&'static str, String)> {
        let ends = [("--from", self.from), ("--to", self.to)];
        let ends = ends.into_iter().filter_map(|(flag, end)| Some((flag, end?.to_string())));
        ends.chain(self.conditions.iter().map(|condition| ("--where", condition.to_string()))).collect()
    }
}
