//! What the band of a device outside the model class rests on, in words.

use hysteron_numeric::display::short;

use super::{ColumnGroup, MisfitError, MisfitPrediction};
use crate::{Finding, FindingKind};

/// Topic of these findings.
const TOPIC: &str = "band";

impl ColumnGroup {
    /// What the training records do not excite, where most of the prior's variance is in this group.
    pub fn unexcited_in_words(self) -> &'static str {
        match self {
            Self::Memory => "memory corners and levels",
            Self::Dynamics => "rates",
            Self::Creep => "durations",
            Self::Rate => "loops at such rates",
        }
    }

    /// The training record that would excite this group.
    pub fn missing_record(self) -> &'static str {
        match self {
            Self::Memory => "nested loops of at least four amplitudes over the whole range",
            Self::Dynamics => "a sweep up to the fastest motion of this drive",
            Self::Creep => "a slow record as long as this drive, with steps that are held",
            Self::Rate => "loops over the whole range at two or more rates",
        }
    }
}

impl MisfitPrediction {
    /// Share of the expected squared error from which a band counts as resting on other devices.
    pub const RESTS_ON_OTHERS: f64 = 0.5;

    /// A statement where the band rests on other devices rather than on the training records, with the record
    /// that would change that; `None` where these records carry it.
    pub fn finding(&self) -> Option<Finding> {
        let rests_on = |share: &str, because: &str, record: &str| {
            let text = format!(
                "{share} on other devices rather than on the training records, which {because}. {} would \
                 change that.",
                capitalised(record)
            );
            Some(Finding::new(FindingKind::Advice, TOPIC, text))
        };
        if self.unexcited > Self::RESTS_ON_OTHERS {
            let group = self.unexcited_group;
            let share =
                format!("{} % of the expected squared error rest", short((100.0 * self.unexcited).round()));
            let because = format!("do not excite the {} of this drive", group.unexcited_in_words());
            return rests_on(&share, &because, group.missing_record());
        }
        if self.one_amplitude {
            let because = "hold loops of one amplitude only";
            return rests_on(
                "The band of smaller loops rests",
                because,
                ColumnGroup::Memory.missing_record(),
            );
        }
        None
    }
}

impl MisfitError {
    /// A statement that the band assumes the model class, although the device is outside it.
    pub fn finding(&self) -> Finding {
        let text = format!(
            "The device is outside the model class, but {self}: the band assumes the class and is too narrow."
        );
        Finding::new(FindingKind::Warning, TOPIC, text)
    }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
