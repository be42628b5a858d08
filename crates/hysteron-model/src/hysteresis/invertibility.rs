//! Whether an operator can be inverted: whether every move raises its output with the drive.

use std::fmt;

use super::{
    Admissibility, BoucWen, DriveGrid, Family, FamilyForm, Hysteresis, HysteresisError, PrandtlIshlinskii,
    polynomial,
};
use crate::record::{Timing, rates_on};
use crate::start::Start;
use hysteron_numeric::display::short;

/// Moves shorter than this share of the range of the drive say nothing about a slope.
const SHORTEST_MOVE: f64 = 1e-6;

/// Whether the output rises with the drive on every branch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Invertibility {
    /// On every branch of every history within the range, by an exact condition of the family.
    Everywhere,
    /// By the exact condition of the family some branch within the range falls or stands.
    Nowhere {
        /// Voltage at which it does \[V\].
        at_v: f64,
    },
    /// The family has no such condition, or one that is met by no more than the drives at hand need; along these every move raised the
    /// output.
    AlongDrives {
        /// Least slope of a move \[µm/V\].
        least_slope: f64,
    },
    /// A move along the drives at hand did not raise the output.
    FallsAlongDrives {
        /// Least slope of a move \[µm/V\].
        least_slope: f64,
    },
}

impl Invertibility {
    /// Whether an inverse exists as far as is known.
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
    /// Whether the operator can be inverted over the voltages of `drives` \[V\]: by the exact condition of its family where that decides,
    /// else by the slopes of the moves along the drives, each from rest at its first sample.
    ///
    /// - Bouc–Wen in the bounded class: dζ/du lies between 0 and max(1, 2β'/(β' + γ')), so that l' above α times that (above 0 for α < 0)
    ///   is enough. Where it is not met only a saturated loop need fall, and the drives decide.
    /// - Plays: l' + w₁ + … + w_k > 0 for every k ≥ 0, enough and needed (P. Krejčí, K. Kuhnen 2001, doi:10.1049/ip-cta:20010375).
    /// - Maxwell slip: as plays.
    /// - Families whose columns all rise: weights ≥ 0 and l' > 0 are enough. Where plays widen with the rate, by λ for 1 V/s, so is l' > Σ w (λ/T − 1) for
    ///   λ > T, T the least time between samples: a move then pushes a play back by λ/T − 1 for each volt.
    ///
    /// # Errors
    /// As [`Self::simulate`].
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
        match self.by_condition([low, high], interval_s) {
            Some(answer) => Ok(answer),
            None => self.along(drives, SHORTEST_MOVE * (high - low)),
        }
    }

    fn by_condition(&self, range: [f64; 2], interval_s: Option<f64>) -> Option<Invertibility> {
        match self {
            Self::BoucWen(model) => bouc_wen(model, range),
            Self::PrandtlIshlinskii(model) => plays(model, range),
            Self::Family(model) => match model.form {
                FamilyForm::MaxwellSlip { .. } => plays(&slip_as_plays(model), range),
                _ => rising(model, range, interval_s).then_some(Invertibility::Everywhere),
            },
        }
    }

    fn along(&self, drives: &[TimedDrive<'_>], shortest: f64) -> Result<Invertibility, HysteresisError> {
        let mut least_slope = f64::INFINITY;
        for &(drive, timing) in drives {
            let Some(&rest) = drive.first() else { continue };
            let mut v = vec![0.0; drive.len()];
            let rates = match timing {
                Timing::Stamps(times_s) => Some(rates_on(times_s, drive)),
                Timing::Unknown | Timing::Rate(_) => None,
            };
            let grid = DriveGrid { rates: rates.as_deref(), ..DriveGrid::new(timing.sample_rate_hz(), 1, 1) };
            self.simulate_every(grid, drive, Start::Rest { voltage_v: rest }, &mut v)?;
            // From turn to turn of what moves at all, so that noise on a held drive is no branch.
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

fn bouc_wen(model: &BoucWen, range: [f64; 2]) -> Option<Invertibility> {
    let Admissibility::Bounded { .. } = model.admissibility() else { return None };
    let shape = model.unit_shape();
    let steepest = (2.0 * shape.beta / (shape.beta + shape.gamma)).max(1.0);
    let needed = if model.alpha > 0.0 { model.alpha * steepest } else { 0.0 };
    match polynomial::not_steeper(&model.polynomial, needed, range) {
        None => Some(Invertibility::Everywhere),
        Some(_) => None,
    }
}

fn plays(model: &PrandtlIshlinskii, range: [f64; 2]) -> Option<Invertibility> {
    match model.step_inverse(range) {
        Ok(_) => Some(Invertibility::Everywhere),
        Err(HysteresisError::NotSteep { u, .. }) => Some(Invertibility::Nowhere { at_v: u }),
        Err(_) => None,
    }
}

/// A stop is the voltage without its play.
fn slip_as_plays(model: &Family) -> PrandtlIshlinskii {
    let mut polynomial = model.polynomial.clone();
    if let Some(linear) = polynomial.first_mut() {
        *linear += model.weights.iter().sum::<f64>();
    }
    PrandtlIshlinskii {
        polynomial,
        thresholds: model.form.thresholds(&model.shape),
        weights: model.weights.iter().map(|k| -k).collect(),
    }
}

fn rising(model: &Family, range: [f64; 2], interval_s: Option<f64>) -> bool {
    let pushed_back = match (model.form, &model.shape[..], interval_s) {
        (FamilyForm::RateDependentPlays { .. }, [_, rate_gain], Some(interval_s)) => {
            model.weights.iter().sum::<f64>() * (rate_gain / interval_s - 1.0).max(0.0)
        }
        _ if model.form.depends_on_rate() => return false,
        _ => 0.0,
    };
    model.form.is_monotone()
        && model.weights.iter().all(|w| *w >= 0.0)
        && polynomial::not_steeper(&model.polynomial, pushed_back, range).is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive() -> Vec<f64> {
        (0..400).map(|k| 5.0 - 5.0 * (f64::from(k) * 0.05).cos()).collect()
    }

    fn bouc_wen(linear: f64, alpha: f64) -> Hysteresis {
        Hysteresis::BoucWen(BoucWen::new(vec![linear], alpha, 0.6, 0.2, 1.0).unwrap())
    }

    #[test]
    fn bouc_wen_by_its_bound_and_by_its_drive() {
        let drive = drive();
        let of = |model: Hysteresis| model.invertibility(&[(&drive, Timing::Unknown)]).unwrap();
        // 2β/(β + γ) = 1.5: a slope of 1.5 α is the limit. Just above it every history is safe.
        assert_eq!(of(bouc_wen(1.51, 1.0)), Invertibility::Everywhere);
        // Below it a loop that saturates falls behind its turn: dz/du there is 1.5 α.
        let Invertibility::FallsAlongDrives { least_slope } = of(bouc_wen(1.3, 1.0)) else { panic!() };
        assert!((-0.25..-0.1).contains(&least_slope), "{least_slope}");
        // A drive that does not saturate does not find the fall.
        let short: Vec<f64> = drive.iter().map(|u| 0.02 * u).collect();
        let on_short = bouc_wen(1.3, 1.0).invertibility(&[(&short, Timing::Unknown)]).unwrap();
        assert!(matches!(on_short, Invertibility::AlongDrives { .. }), "{on_short}");
        // α < 0 adds to the slope.
        assert_eq!(of(bouc_wen(0.1, -1.0)), Invertibility::Everywhere);
    }

    #[test]
    fn plays_by_the_partial_sums_of_their_weights() {
        let drive = drive();
        let of = |weights: Vec<f64>| {
            let model = PrandtlIshlinskii::new(vec![1.0], vec![0.5, 1.5], weights).unwrap();
            Hysteresis::PrandtlIshlinskii(model).invertibility(&[(&drive, Timing::Unknown)]).unwrap()
        };
        assert_eq!(of(vec![-0.5, -0.4]), Invertibility::Everywhere);
        assert!(matches!(of(vec![-0.5, -0.6]), Invertibility::Nowhere { .. }));
    }

    #[test]
    fn other_families_by_sign_or_by_their_drive() {
        let drive = drive();
        let of = |form: FamilyForm, shape: &[f64], weight: f64| {
            let weights = vec![weight; form.columns()];
            let model = Family::new(vec![1.0], form, shape.to_vec(), weights).unwrap();
            Hysteresis::Family(model).invertibility(&[(&drive, Timing::Unknown)]).unwrap()
        };
        let plays = FamilyForm::OneSidedPlays { plays: 3 };
        assert_eq!(of(plays, &[5.3], 0.2), Invertibility::Everywhere);
        assert!(matches!(of(plays, &[5.3], -0.1), Invertibility::AlongDrives { .. }));
        assert!(matches!(of(FamilyForm::Dahl, &[1.7, 1.4], 0.2), Invertibility::AlongDrives { .. }));
        assert!(matches!(of(FamilyForm::Dahl, &[1.7, 1.4], -2.0), Invertibility::FallsAlongDrives { .. }));
    }

    #[test]
    fn slip_is_decided_as_plays_are() {
        let drive = drive();
        let of = |linear: f64| {
            let form = FamilyForm::MaxwellSlip { elements: 2 };
            let model = Family::new(vec![linear], form, vec![3.0], vec![0.5, 0.4]).unwrap();
            Hysteresis::Family(model).invertibility(&[(&drive, Timing::Unknown)]).unwrap()
        };
        // Stiffnesses 0.5 and 0.4 that give way: l' + 0.9 at a turn, l' once all slip.
        assert_eq!(of(0.1), Invertibility::Everywhere);
        assert!(matches!(of(-0.1), Invertibility::Nowhere { .. }));
    }

    #[test]
    fn plays_that_a_sample_widens_by_more_than_its_move_need_a_steeper_line() {
        let drive = drive();
        let of = |linear: f64, rate_gain: f64| {
            let form = FamilyForm::RateDependentPlays { plays: 2 };
            let model = Family::new(vec![linear], form, vec![3.0, rate_gain], vec![0.3, 0.2]).unwrap();
            Hysteresis::Family(model).invertibility(&[(&drive, Timing::Rate(1e3))]).unwrap()
        };
        assert_eq!(of(0.1, 9e-4), Invertibility::Everywhere);
        // λ/T = 1.4: 0.5 · 0.4 back.
        assert_eq!(of(0.21, 1.4e-3), Invertibility::Everywhere);
        assert_ne!(of(0.19, 1.4e-3), Invertibility::Everywhere);
    }

    #[test]
    fn a_drive_that_does_not_move_decides_nothing() {
        let constant = [2.0; 5];
        let error = bouc_wen(1.0, 0.5).invertibility(&[(&constant, Timing::Unknown)]);
        assert!(matches!(error, Err(HysteresisError::Range { .. })));
    }
}
