//! Invertibility of an operator: every move must raise its output with the drive.

use std::fmt;

use super::{DriveGrid, Hysteresis, HysteresisError};
use crate::record::{Timing, paces_on};
use crate::start::Start;
use hysteron_numeric::display::short;

/// Moves shorter than this share of the range of the drive do not determine a slope.
const SHORTEST_MOVE: f64 = 1e-6;

/// Verdict on whether the output rises with the drive on every branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Invertibility {
    /// On every branch of every history within the range, by an exact condition of the family.
    Everywhere,
    /// By the exact condition of the family some branch within the range falls or is flat.
    Nowhere {
        /// Voltage at which it does \[V\].
        at_v: f64,
    },
    /// The family has no such condition, or only a sufficient one that is not met; along the given drives
    /// every move raised the output.
    AlongDrives {
        /// Least slope of a move \[µm/V\].
        least_slope: f64,
    },
    /// A move along the given drives did not raise the output.
    FallsAlongDrives {
        /// Least slope of a move \[µm/V\].
        least_slope: f64,
    },
}

impl Invertibility {
    /// True if an inverse exists as far as is known.
    pub fn is_invertible(self) -> bool {
        matches!(self, Self::Everywhere | Self::AlongDrives { .. })
    }

    /// One word for a table.
    pub fn word(self) -> &'static str {
        match self {
            Self::Everywhere => "always",
            Self::AlongDrives { .. } => "on records",
            Self::Nowhere { .. } | Self::FallsAlongDrives { .. } => "no",
        }
    }
}

impl fmt::Display for Invertibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Everywhere => {
                write!(f, "every move raises the output with the drive, whatever came before")
            }
            Self::Nowhere { at_v } => {
                write!(f, "a branch does not rise with the drive at the input {}", short(*at_v))
            }
            Self::AlongDrives { least_slope } => {
                write!(
                    f,
                    "every move of the records raises the output, by {} times the input or more",
                    short(*least_slope)
                )
            }
            Self::FallsAlongDrives { least_slope } => {
                write!(f, "a move of the records does not raise the output: slope {}", short(*least_slope))
            }
        }
    }
}

/// Voltages \[V\] and when they are sampled.
pub type TimedDrive<'a> = (&'a [f64], Timing<'a>);

/// Least time from one sample to the next \[s\], where it is known.
fn least_interval_s(timing: Timing<'_>) -> Option<f64> {
    match timing {
        Timing::Unknown => None,
        Timing::Rate(sample_rate_hz) => Some(1.0 / sample_rate_hz),
        Timing::Stamps(times_s) => times_s.windows(2).map(|two| two[1] - two[0]).reduce(f64::min),
    }
}

impl Hysteresis {
    /// Invertibility of the operator over the voltages of `drives` \[V\]: by the exact condition of its
    /// family where that decides, else by the slopes of the moves along the drives, each from rest at its
    /// first sample.
    ///
    /// - Plays: l' + w₁ + … + w_k > 0 for every k ≥ 0, necessary and sufficient (P. Krejčí, K. Kuhnen 2001,
    ///   doi:10.1049/ip-cta:20010375).
    /// - Families that are plays in other coordinates: as plays.
    /// - Families with a condition of their own: see there.
    /// - Families whose columns all rise: weights ≥ 0 and l' > 0 are sufficient. Where plays widen with the
    ///   rate, by λ for 1 V/s, so is l' > Σ w (λ/T − 1) for λ > T, T the least time between samples: a move
    ///   then pushes a play back by λ/T − 1 for each volt.
    ///
    /// # Errors
    /// Those of [`Self::simulate`].
    pub fn invertibility(&self, drives: &[TimedDrive<'_>]) -> Result<Invertibility, HysteresisError> {
        self.validate()?;
        let [low, high] = drives
            .iter()
            .flat_map(|(drive, _)| *drive)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &u| [low.min(u), high.max(u)]);
        if !(low < high && (high - low).is_finite()) {
            return Err(HysteresisError::Range { low, high });
        }
        let least =
            |least: Option<f64>, (_, timing): &TimedDrive<'_>| Some(least?.min(least_interval_s(*timing)?));
        let interval_s = drives.iter().fold(Some(f64::INFINITY), least);
        match self.form().family().invertibility(self, [low, high], interval_s) {
            Some(answer) => Ok(answer),
            None => self.along(drives, SHORTEST_MOVE * (high - low)),
        }
    }

    fn along(&self, drives: &[TimedDrive<'_>], shortest: f64) -> Result<Invertibility, HysteresisError> {
        let mut least_slope = f64::INFINITY;
        for &(drive, timing) in drives {
            let Some(&rest) = drive.first() else { continue };
            let mut v = vec![0.0; drive.len()];
            let paces = match timing {
                Timing::Stamps(times_s) => Some(paces_on(times_s, drive)),
                Timing::Unknown | Timing::Rate(_) => None,
            };
            let grid = DriveGrid { paces: paces.as_deref(), ..DriveGrid::new(timing.sample_rate_hz(), 1, 1) };
            self.simulate_every(grid, drive, Start::Rest { voltage_v: rest }, &mut v)?;
            // Over moves longer than `shortest` only, so that noise on a held drive is no branch.
            let mut from = (rest, v.first().copied().unwrap_or(0.0));
            for (&u, &v) in drive.iter().zip(&v) {
                if (u - from.0).abs() > shortest {
                    least_slope = least_slope.min((v - from.1) / (u - from.0));
                    from = (u, v);
                }
            }
        }
        Ok(if least_slope > 0.0 {
            Invertibility::AlongDrives { least_slope }
        } else {
            Invertibility::FallsAlongDrives { least_slope }
        })
    }
}
