//! Force of a damper against a prescribed displacement: hysteresis of the displacement beside terms of its
//! rate.
//!
//! F = F₀ + H\[x\] + c v + Σⱼ dⱼ sⱼ,  ρⱼ ṡⱼ = v − νⱼ artanh sⱼ,  v = ẋ.
//!
//! H\[x\] is a hysteresis block, with the stiffness as its linear coefficient; c v a viscous force; dⱼ sⱼ a
//! force that saturates with the rate. Its dashpot, dⱼ tanh(v/νⱼ), is in series with a spring that yields
//! over the displacement ρⱼ: a Maxwell element, whose loop over the rate is that of a compliant damper. Two
//! limits: s = tanh(v/ν) for ρ → 0 (Kwok et al. 2006, doi:10.1016/j.sna.2006.03.015); for ν → 0 the stop of
//! half-width ρ, which knows no rate.
//!
//! * [`ForceModel`]: the parameters, and the force over a record ([`ForceModel::simulate`]).
//! * [`rate_of`]: the rate of a sampled displacement; [`with_rate`] takes a measured one.
//!
//! Identified by `hysteron_identify::force`. Equations, sources and limits: `docs/theory/force.md`.

mod error;
mod rate;
mod saturation;
mod simulate;

pub use error::ForceModelError;
pub use rate::{rate_of, with_rate};
pub use saturation::Saturation;
pub use simulate::Motion;

use crate::hysteresis::{Hysteresis, polynomial_name};

/// Force against a prescribed displacement, F = F₀ + H\[x\] + c v + Σⱼ dⱼ sⱼ.
///
/// Units: those of the record, x in µm and F in N, say; then c in N s/µm, and so on.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceModel {
    /// Constant force F₀ \[N\]: preload, or offset of the sensor.
    pub offset: f64,
    /// Force that follows the displacement, H\[x\] \[N\]: stiffness (its linear coefficient) and hysteresis.
    pub hysteresis: Hysteresis,
    /// Viscous coefficient c \[N s/µm\].
    pub viscous: f64,
    /// Forces that saturate with the rate.
    pub saturating: Vec<Saturation>,
    /// Time over which the rate of a displacement is averaged where the record has no rate \[s\]; at least
    /// from the sample before to the one after.
    pub rate_window_s: f64,
}

impl ForceModel {
    /// Checks that every number is finite and in its range.
    ///
    /// # Errors
    /// [`ForceModelError`], the first found.
    pub fn validate(&self) -> Result<(), ForceModelError> {
        self.hysteresis.validate()?;
        let check = |name: &'static str, value: f64, allowed: bool, expected: &'static str| {
            if allowed && value.is_finite() {
                return Ok(());
            }
            Err(ForceModelError::Parameter { name, value, expected })
        };
        check("offset", self.offset, true, "a finite number")?;
        check("viscous", self.viscous, true, "a finite number")?;
        check(
            "rate_window_s",
            self.rate_window_s,
            self.rate_window_s >= 0.0,
            "a number that is not negative",
        )?;
        self.saturating.iter().try_for_each(|s| {
            check("saturating force", s.force, true, "a finite number")?;
            check("saturating rate", s.rate, s.rate > 0.0, "a finite number above 0")?;
            check("saturating reach", s.reach, s.reach >= 0.0, "a number that is not negative")
        })
    }

    /// True if a term depends on the rate.
    pub fn needs_rate(&self) -> bool {
        self.viscous != 0.0 || !self.saturating.is_empty()
    }

    /// Names and values of its numbers: the offset, the coefficients of the displacement (`linear` is the
    /// stiffness), those of the hysteresis family, the viscous coefficient, and those of each saturating
    /// force, from the second on with its index.
    pub fn numbers(&self) -> Vec<(String, f64)> {
        let polynomial = self.hysteresis.polynomial().iter().enumerate();
        let polynomial = polynomial.map(|(i, &value)| (polynomial_name(i + 1).into_owned(), value));
        let mut numbers = vec![("offset".to_owned(), self.offset)];
        numbers.extend(polynomial);
        numbers.extend(self.hysteresis.numbers());
        numbers.push(("viscous".to_owned(), self.viscous));
        for (index, saturation) in self.saturating.iter().enumerate() {
            let of = |kind: &str| Saturation::name(kind, index);
            numbers.extend([
                (of("force"), saturation.force),
                (of("rate"), saturation.rate),
                (of("reach"), saturation.reach),
            ]);
        }
        numbers
    }

    /// The number of this name ([`Self::numbers`]).
    pub fn number_mut(&mut self, name: &str) -> Option<&mut f64> {
        match name {
            "offset" => return Some(&mut self.offset),
            "viscous" => return Some(&mut self.viscous),
            _ => {}
        }
        for (index, saturation) in self.saturating.iter_mut().enumerate() {
            let numbers = [
                ("force", &mut saturation.force),
                ("rate", &mut saturation.rate),
                ("reach", &mut saturation.reach),
            ];
            for (kind, number) in numbers {
                if Saturation::name(kind, index) == name {
                    return Some(number);
                }
            }
        }
        let degree = self.hysteresis.polynomial().len();
        match (0..degree).find(|i| polynomial_name(i + 1) == name) {
            Some(index) => self.hysteresis.polynomial_mut().get_mut(index),
            None => self.hysteresis.number_mut(name),
        }
    }
}

#[cfg(test)]
mod tests;
