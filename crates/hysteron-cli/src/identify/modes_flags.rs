//! Flags of scheduled modes.

use clap::Args;
use hysteron_identify::modes::Options;

use crate::numbers::{count, not_negative, positive, whole};

/// Options of scheduled modes.
#[derive(Args, Clone, Debug)]
pub struct ModesFlags {
    /// Initial number of pole pairs in the search for modes [default: as many as improve the fit of the
    /// response]
    #[arg(
        long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    modes: Option<usize>,

    /// Plays of each hysteresis operator; 0: polynomials alone [default: 6]
    #[arg(
        long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    plays: Option<usize>,

    /// Linear modes at each level, without hysteresis
    #[arg(long, help_heading = "Several axes")]
    linear: bool,

    /// Integration steps per sample, 1 to 8 [default: 2]
    #[arg(
        long, value_name = "N", value_parser = count::<usize>, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    steps: Option<usize>,

    /// Maximum iterations of the final search [default: 12]
    #[arg(
        long, value_name = "N", value_parser = whole::<usize>, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    iterations: Option<usize>,

    /// Exponent of the drive level in the scheduling of the modes [default: from the responses of three
    /// levels or more where they determine it, else 0.3]
    #[arg(
        long, value_name = "P", value_parser = positive, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    exponent: Option<f64>,

    /// Weight of the ridge that shrinks the change of the modes with the level towards one common relative
    /// shift [default: 0, none]
    #[arg(
        long, value_name = "WEIGHT", value_parser = not_negative, allow_hyphen_values = true,
        help_heading = "Several axes",
    )]
    ridge: Option<f64>,
}

impl ModesFlags {
    /// The first flag given, if one is.
    pub fn given(&self) -> Option<&'static str> {
        [
            ("--modes", self.modes.is_some()),
            ("--plays", self.plays.is_some()),
            ("--linear", self.linear),
            ("--steps", self.steps.is_some()),
            ("--iterations", self.iterations.is_some()),
            ("--exponent", self.exponent.is_some()),
            ("--ridge", self.ridge.is_some()),
        ]
        .into_iter()
        .find_map(|(flag, given)| given.then_some(flag))
    }

    pub fn options(&self, whole_records: bool, least_fit_percent: f64) -> Options {
        let defaults = Options::default();
        Options {
            modes: self.modes,
            plays: self.plays.unwrap_or(defaults.plays),
            hysteresis: !self.linear,
            steps: self.steps.unwrap_or(defaults.steps),
            iterations: self.iterations.unwrap_or(defaults.iterations),
            exponent: self.exponent,
            ridge: self.ridge.unwrap_or(defaults.ridge),
            whole_records,
            least_fit_percent,
            ..defaults
        }
    }
}
