//! Operations that each kind of model supports.

use std::fmt;

use crate::model_file::Kind;

/// Operation that a kind of model may support.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Capability {
    /// The output for a drive.
    Simulation,
    /// Scores on a record.
    Scores,
    /// Scores on consecutive records of one run.
    Runs,
    /// A band around the output, from the standard errors of the parameters.
    Bands,
    /// Correction by the predicted misfit.
    Correction,
    /// Running sample by sample at a controller's rate.
    Realisation,
    /// The drive that tracks a reference.
    Inversion,
    /// A control loop around the inverse.
    Tracking,
    /// Source code and FMUs.
    Export,
    /// A new gain and delay from a short record.
    Recalibration,
    /// Online adaptation to a device.
    Adaptation,
    /// Design of the next experiment.
    Design,
    /// Initial model of a fit of the same kind.
    StartOfFit,
}

impl Capability {
    /// Every one.
    pub const ALL: [Self; 13] = [
        Self::Simulation,
        Self::Scores,
        Self::Runs,
        Self::Bands,
        Self::Correction,
        Self::Realisation,
        Self::Inversion,
        Self::Tracking,
        Self::Export,
        Self::Recalibration,
        Self::Adaptation,
        Self::Design,
        Self::StartOfFit,
    ];

    /// Name of the operation, as the subject of a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Scores => "scoring",
            Self::Runs => "scoring of a run in parts",
            Self::Bands => "a band around the output",
            Self::Correction => "correction by the predicted misfit",
            Self::Realisation => "realisation",
            Self::Inversion => "inversion",
            Self::Tracking => "closed-loop control",
            Self::Export => "export",
            Self::Recalibration => "recalibration",
            Self::Adaptation => "adaptation",
            Self::Design => "design of the next drive",
            Self::StartOfFit => "the start of a fit",
        }
    }

    /// True if models of this kind support it.
    pub fn of(self, kind: Kind) -> bool {
        match (kind, self) {
            (Kind::Hammerstein, _)
            | (_, Self::Simulation | Self::Scores)
            | (Kind::Oscillator, Self::StartOfFit)
            | (Kind::Modes | Kind::Branches, Self::Inversion)
            | (Kind::Modes, Self::Tracking | Self::Export) => true,
            (Kind::Oscillator | Kind::Force | Kind::Modes | Kind::Branches, _) => false,
        }
    }
}

impl fmt::Display for Capability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A kind of model does not support this: by its nature, which is the reason, or not yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{wanted} is not supported for a model of the kind \"{kind}\"{}", self.because())]
pub struct Unsupported {
    /// The kind of the model.
    pub kind: Kind,
    /// The operation requested.
    pub wanted: Capability,
}

impl Unsupported {
    /// `Ok` where the kind supports it.
    ///
    /// # Errors
    /// [`Unsupported`] where it does not.
    pub fn check(kind: Kind, wanted: Capability) -> Result<(), Self> {
        if wanted.of(kind) { Ok(()) } else { Err(Self { kind, wanted }) }
    }

    /// The reason, where it lies in the kind of model.
    pub fn reason(&self) -> Option<&'static str> {
        use Capability::{Adaptation, Export, Inversion, Realisation, Recalibration, Tracking};
        match (self.kind, self.wanted) {
            (Kind::Oscillator, Realisation | Export) => Some(
                "its hysteresis is in feedback with the mass, so that it has no poles to realise: it is \
                 integrated in steps that follow its stiffness",
            ),
            (Kind::Oscillator, Inversion | Tracking) => Some(
                "the force for a motion takes the acceleration, two derivatives of the reference, and the \
                 hysteresis of the displacement: the inverse of a voltage does not apply",
            ),
            (Kind::Force, Inversion | Tracking | Realisation | Export) => {
                Some("its input is a motion, not a drive")
            }
            (Kind::Modes, Realisation) => {
                Some("its modes run at the controller's rate as they are: export writes them")
            }
            (Kind::Oscillator, Recalibration | Adaptation) => {
                Some("it has no gain and delay behind its hysteresis that could be corrected")
            }
            _ => None,
        }
    }

    fn because(&self) -> String {
        self.reason().map_or_else(|| " yet".to_owned(), |reason| format!(": {reason}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_the_reason_where_it_lies_in_the_kind() {
        let words = |kind, wanted| Unsupported { kind, wanted }.to_string();
        let oscillator = words(Kind::Oscillator, Capability::Export);
        assert!(oscillator.starts_with("export is not supported for a model of the kind \"oscillator\": "));
        assert!(words(Kind::Oscillator, Capability::Inversion).contains("acceleration"));
        assert!(words(Kind::Branches, Capability::Export).ends_with("\"branches\" yet"));
        for kind in Kind::ALL {
            for wanted in Capability::ALL {
                assert_eq!(Unsupported::check(kind, wanted).is_ok(), wanted.of(kind));
            }
        }
    }
}
