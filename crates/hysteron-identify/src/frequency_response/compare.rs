//! Candidate structures for a frequency response, fitted and compared.

use super::explain::explain;
use super::fit::{fit_beside, fit_containing};
use super::{Core, FrequencyResponse, ResponseFit, Structure, Weighting, fit_structure};
use crate::IdentifyError;

/// Most modes tried where their number is not given.
const MOST_MODES: usize = 10;
/// Consecutive numbers of modes not supported by the data after which the search ends.
const PATIENCE: usize = 3;
/// A maximum of the magnitude above the minima on both sides by this factor is a resonance.
const PROMINENCE: f64 = 1.3;
/// Phase change over the band \[°\] from which on a response has dynamics.
const TURN_DEG: f64 = 45.0;

/// A structure fitted for comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Short name, e.g. `loss angle`.
    pub name: String,
    /// The fit.
    pub fit: ResponseFit,
    /// Explanation of fit and residual, in plain words.
    pub explanation: String,
}

/// A family of structures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// K s^{−μ}.
    PowerLaw,
    /// A fractional lag; the form of article Eq. 13 with delay where the response has dynamics
    /// ([`has_dynamics`]).
    Fractional,
    /// Poles and zeros, as many parameters as [`Family::Fractional`].
    Integer,
    /// A power law with a loss angle.
    LossAngle,
    /// Resonances times a power law, with delay; without the power law; and with a loss angle.
    Modes,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Fractional, Self::Integer, Self::PowerLaw, Self::LossAngle, Self::Modes];

    /// Name to choose it by.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fractional => "fractional",
            Self::Integer => "integer",
            Self::PowerLaw => "power-law",
            Self::LossAngle => "loss-angle",
            Self::Modes => "modes",
        }
    }

    /// The structure in one line.
    pub fn summary(self) -> &'static str {
        match self {
            Self::Fractional => {
                "b/(s^α₂ + c₁ s^α₁ + c₀) with delay, or a fractional lag where the phase varies little"
            }
            Self::Integer => "Poles and zeros, as many parameters as the fractional one",
            Self::PowerLaw => "K s^−μ",
            Self::LossAngle => "K s^−μ with a constant extra phase, due to hysteresis",
            Self::Modes => "Resonances times a power law, with delay",
        }
    }

    /// Families to compare on this response: modes where it has a resonance, else those of a smooth response.
    pub fn for_response(response: &FrequencyResponse) -> Vec<Self> {
        if has_resonance(response) {
            vec![Self::PowerLaw, Self::Fractional, Self::Integer, Self::Modes]
        } else {
            vec![Self::PowerLaw, Self::Fractional, Self::Integer, Self::LossAngle]
        }
    }
}

/// True if the magnitude has a maximum inside the band, above both sides by a factor of 1.3.
pub fn has_resonance(response: &FrequencyResponse) -> bool {
    let magnitudes: Vec<f64> = response.values.iter().map(|g| g.norm()).collect();
    let lowest = |part: &[f64]| part.iter().copied().fold(f64::INFINITY, f64::min);
    (1..magnitudes.len().saturating_sub(1)).any(|i| {
        let (before, after) = magnitudes.split_at(i);
        let side = PROMINENCE * lowest(before).max(lowest(&after[1..]));
        magnitudes[i] > side
    })
}

/// True if there is more than creep and loss: a resonance, or a phase change above 45° over the band.
pub fn has_dynamics(response: &FrequencyResponse) -> bool {
    let phases = response.phase_deg();
    let low = phases.iter().copied().fold(f64::INFINITY, f64::min);
    let high = phases.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    has_resonance(response) || high - low > TURN_DEG
}

/// Fits the structures of the families in order. `modes`: their number; `None` adds modes as long as the data
/// support their parameters.
///
/// # Errors
/// Those of [`fit_structure`].
pub fn compare(
    response: &FrequencyResponse,
    weighting: Weighting,
    families: &[Family],
    modes: Option<usize>,
) -> Result<Vec<Candidate>, IdentifyError> {
    let mut candidates: Vec<Candidate> = Vec::new();
    let mut add = |name: String, fit: ResponseFit| {
        let explanation = explain(&fit, response);
        candidates.push(Candidate { name, fit, explanation });
    };
    let dynamic = has_dynamics(response);
    for family in families {
        let (name, structure) = match family {
            Family::PowerLaw => ("power law", Structure::POWER_LAW),
            Family::LossAngle => ("loss angle", Structure::LOSS_ANGLE),
            Family::Fractional if dynamic => {
                ("fractional", Structure::of(Core::FractionalOscillator).with_delay())
            }
            Family::Fractional => ("fractional", Structure::FRACTIONAL_LAG),
            Family::Integer if dynamic => {
                ("integer", Structure::of(Core::Rational { poles: 3, direct: false }))
            }
            Family::Integer => ("integer", Structure::LEAD_LAG),
            Family::Modes => {
                let base = Structure::of(Core::Modes { count: 1 }).with_delay();
                let best = modal(response, weighting, base.with_power_law(), modes)?;
                let count = best.structure.core_count() / 2;
                let plain = modal(response, weighting, base, Some(count))?;
                let best = fit_containing(response, weighting, (best, &plain))?;
                let lossy = base.with_power_law().with_loss_angle();
                let lossy = modal(response, weighting, lossy, Some(count))?;
                let lossy = fit_containing(response, weighting, (lossy, &best))?;
                let plural = if count == 1 { "mode" } else { "modes" };
                add(format!("{count} {plural}"), plain);
                add(format!("{count} {plural}, power law"), best);
                add(format!("{count} {plural}, power law, loss angle"), lossy);
                continue;
            }
        };
        let mut fit = fit_structure(response, &structure, weighting)?;
        if structure == Structure::LOSS_ANGLE {
            let contained = fit_structure(response, &Structure::POWER_LAW, weighting)?;
            fit = fit_containing(response, weighting, (fit, &contained))?;
        }
        add(name.to_owned(), fit);
    }
    Ok(candidates)
}

/// Modes one by one with the factors of `base`: `wanted` of them, or as many as the data support.
fn modal(
    response: &FrequencyResponse,
    weighting: Weighting,
    base: Structure,
    wanted: Option<usize>,
) -> Result<ResponseFit, IdentifyError> {
    let structure = |count| Structure { core: Core::Modes { count }, ..base };
    let mut last = fit_structure(response, &structure(1), weighting)?;
    let mut best = last.clone();
    let mut since = 0;
    for count in 2..=wanted.unwrap_or(MOST_MODES) {
        let next = structure(count);
        if wanted.is_none() && response.len() <= next.parameter_count() {
            break;
        }
        last = fit_beside(response, &next, weighting, Some(&last))?;
        if wanted.is_some() || supported(&last, &best) {
            best = last.clone();
            since = 0;
        } else if since + 1 == PATIENCE {
            break;
        } else {
            since += 1;
        }
    }
    Ok(best)
}

/// True if the data support the further parameters, by the criterion of Schwarz (1978,
/// doi:10.1214/aos/1176344136), n ln(Σ|w e|²/n) + k ln n, with n the effective number of independent
/// residuals among the 2N real ones.
fn supported(richer: &ResponseFit, simpler: &ResponseFit) -> bool {
    let independent = 2.0 * richer.points as f64 / richer.correlation;
    let more = richer.parameters.len() as f64 - simpler.parameters.len() as f64;
    independent * (simpler.square / richer.square).ln() > more * independent.ln()
}

#[cfg(test)]
mod tests;
