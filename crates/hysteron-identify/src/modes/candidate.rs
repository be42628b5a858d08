//! Structures of scheduled modes by name: `linear`, `polynomial`, `plays6`, `modes8+plays6`.

use std::fmt;
use std::str::FromStr;

use super::Options;

/// Largest numbers in a name.
const MOST_MODES: usize = 100;
const MOST_PLAYS: usize = 32;

/// Hysteresis in feedback with the modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StrainChoice {
    /// None.
    Linear,
    /// Polynomials of strokes and stresses, without memory.
    Polynomial,
    /// Polynomials and this many plays.
    Plays(usize),
}

/// A structure of scheduled modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModesCandidate {
    /// Initial pole pairs; `None`: chosen by their fit of the response.
    pub modes: Option<usize>,
    /// The hysteresis.
    pub strain: StrainChoice,
}

impl ModesCandidate {
    /// Those compared by default: without hysteresis, without memory, with few plays and with the usual ones.
    pub const USUAL: [Self; 4] = {
        const fn of(strain: StrainChoice) -> ModesCandidate {
            ModesCandidate { modes: None, strain }
        }
        [
            of(StrainChoice::Linear),
            of(StrainChoice::Polynomial),
            of(StrainChoice::Plays(3)),
            of(StrainChoice::Plays(6)),
        ]
    };

    /// Options of its identification, else those of `options`.
    pub fn options(&self, options: &Options) -> Options {
        let (hysteresis, plays) = match self.strain {
            StrainChoice::Linear => (false, options.plays),
            StrainChoice::Polynomial => (true, 0),
            StrainChoice::Plays(plays) => (true, plays),
        };
        Options { modes: self.modes.or(options.modes), hysteresis, plays, ..options.clone() }
    }
}

impl fmt::Display for ModesCandidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(modes) = self.modes {
            write!(f, "modes{modes}+")?;
        }
        match self.strain {
            StrainChoice::Linear => f.write_str("linear"),
            StrainChoice::Polynomial => f.write_str("polynomial"),
            StrainChoice::Plays(plays) => write!(f, "plays{plays}"),
        }
    }
}

/// Text that names no structure of modes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{text}\" is no structure of several axes: [modesN+]linear, [modesN+]polynomial or [modesN+]playsN, \
     with 1 to {MOST_MODES} modes and 1 to {MOST_PLAYS} plays"
)]
pub struct UnknownModes {
    /// The text.
    pub text: String,
}

impl FromStr for ModesCandidate {
    type Err = UnknownModes;

    fn from_str(text: &str) -> Result<Self, UnknownModes> {
        let unknown = || UnknownModes { text: text.to_owned() };
        let number = |digits: &str, most: usize| {
            digits.parse().ok().filter(|n| (1..=most).contains(n)).ok_or_else(unknown)
        };
        let (modes, strain) = match text.split_once('+') {
            Some((modes, strain)) => {
                let digits = modes.strip_prefix("modes").ok_or_else(unknown)?;
                (Some(number(digits, MOST_MODES)?), strain)
            }
            None => (None, text),
        };
        let strain = match strain {
            "linear" => StrainChoice::Linear,
            "polynomial" => StrainChoice::Polynomial,
            other => {
                let digits = other.strip_prefix("plays").ok_or_else(unknown)?;
                StrainChoice::Plays(number(digits, MOST_PLAYS)?)
            }
        };
        Ok(Self { modes, strain })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for name in ["linear", "polynomial", "plays6", "modes8+plays3", "modes12+linear"] {
            let candidate: ModesCandidate = name.parse().unwrap();
            assert_eq!(candidate.to_string(), name);
        }
        for wrong in
            ["", "plays0", "plays33", "modes0+linear", "modes8", "modes8+", "order2", "modes8+modes8"]
        {
            assert!(wrong.parse::<ModesCandidate>().unwrap_err().to_string().contains(wrong));
        }
    }
}
