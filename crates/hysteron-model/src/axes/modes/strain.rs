//! Strain of an actuator: polynomial and plays of its drive or stress.

use super::{finite_list, positive};
use crate::axes::AxesError;

/// Powers before the plays.
#[doc(hidden)]
pub const POWERS: usize = 2;

/// f(z) = c₂ (z² − s²) + c₃ (z³ − 3 s² z) + Σ_j c_j (P_j\[z\] − γ_j z), a z beyond ±reach taken to be there.
#[derive(Clone, Debug, PartialEq)]
pub struct StrainLaw {
    /// c₂ \[1/V\], c₃ \[1/V²\], then one weight per play.
    pub coefficients: Vec<f64>,
    /// Radii of the plays \[V\], above 0.
    pub radii: Vec<f64>,
    /// γ_j, the mean slope removed from each play.
    pub slopes: Vec<f64>,
    /// s² \[V²\].
    pub variance: f64,
    /// Largest |z| that the law is evaluated at \[V\]; infinite: everywhere. Beyond the records a cubic law can
    /// feed a resonance more than its damping takes; strains that are bounded cannot throw out stable modes.
    pub reach: f64,
}

/// The hysteresis of all actuators.
#[derive(Clone, Debug, PartialEq)]
pub struct FeedbackStrain {
    /// v_i as rows of (x, u), one an actuator \[V\].
    pub drive_rows: Vec<f64>,
    /// σ_i as rows of (x, u), one an actuator \[V\].
    pub stress_rows: Vec<f64>,
    /// f, of v, shared by the actuators.
    pub drive: StrainLaw,
    /// f_i, of σ, one an actuator.
    pub stress: Vec<StrainLaw>,
}

impl StrainLaw {
    /// Terms of the sum.
    pub fn terms(&self) -> usize {
        POWERS + self.radii.len()
    }

    /// Moves the plays to z and writes the terms of the sum; returns f(z), its slope while no play moves, and
    /// a bit mask of the plays that moved.
    pub(super) fn step(&self, z: f64, plays: &mut [f64], terms: &mut [f64]) -> (f64, f64, u32) {
        let within = z.clamp(-self.reach, self.reach);
        let stays = within != z;
        let z = within;
        let s2 = self.variance;
        let [square, cube, rest @ ..] = terms else { return (0.0, 0.0, 0) };
        *square = z * z - s2;
        *cube = z * z * z - 3.0 * s2 * z;
        let [c2, c3, weights @ ..] = self.coefficients.as_slice() else { return (0.0, 0.0, 0) };
        let mut value = c2 * *square + c3 * *cube;
        let mut slope = 2.0 * c2 * z + 3.0 * c3 * (z * z - s2);
        let mut moved = 0;
        let laws = weights.iter().zip(&self.radii).zip(&self.slopes);
        for (j, (((weight, radius), gamma), (play, term))) in laws.zip(plays.iter_mut().zip(rest)).enumerate()
        {
            if z - radius > *play {
                *play = z - radius;
                moved |= 1 << j;
            } else if z + radius < *play {
                *play = z + radius;
                moved |= 1 << j;
            }
            *term = *play - gamma * z;
            value += weight * *term;
            slope -= weight * gamma;
        }
        (value, if stays { 0.0 } else { slope }, moved)
    }

    fn validate(&self) -> Result<(), AxesError> {
        if self.radii.len() > 32 {
            return Err(AxesError::Length { what: "radii", expected: 32, found: self.radii.len() });
        }
        finite_list("radii", &self.radii, self.radii.len())?;
        finite_list("coefficients", &self.coefficients, self.terms())?;
        finite_list("slopes", &self.slopes, self.radii.len())?;
        positive("variance", self.variance)?;
        if self.reach.is_nan() || self.reach <= 0.0 {
            let expected = "a number above 0";
            return Err(AxesError::Value { what: "reach", value: self.reach, expected });
        }
        self.radii.iter().try_for_each(|r| positive("radii", *r))
    }
}

impl FeedbackStrain {
    /// Largest number of plays of a law.
    pub(super) fn plays(&self) -> usize {
        self.drive.radii.len() + self.stress.iter().map(|s| s.radii.len()).max().unwrap_or(0)
    }

    pub(super) fn validate(&self, inputs: usize, states: usize) -> Result<(), AxesError> {
        let row = states + inputs;
        finite_list("drive_rows", &self.drive_rows, inputs * row)?;
        finite_list("stress_rows", &self.stress_rows, inputs * row)?;
        if self.stress.len() != inputs {
            return Err(AxesError::Length { what: "stress", expected: inputs, found: self.stress.len() });
        }
        self.drive.validate().map_err(|e| e.within("drive"))?;
        let plays = self.drive.radii.len();
        let of_stress = |law: &StrainLaw| match law.radii.len() {
            found if found != plays => Err(AxesError::Length { what: "radii", expected: plays, found }),
            _ => law.validate(),
        };
        let mut laws = self.stress.iter().enumerate();
        laws.try_for_each(|(n, law)| of_stress(law).map_err(|e| e.within(&format!("stress[{n}]"))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_law_is_its_polynomial_and_its_plays_by_hand() {
        let law = StrainLaw {
            coefficients: vec![0.5, 0.1, 2.0],
            radii: vec![1.0],
            slopes: vec![0.25],
            variance: 0.2,
            reach: 4.0,
        };
        let (mut plays, mut terms) = ([0.0], [0.0; 3]);
        // z = 3: play 2, moved; 0.5 (9 − 0.2) + 0.1 (27 − 1.8) + 2 (2 − 0.75).
        let (value, slope, moved) = law.step(3.0, &mut plays, &mut terms);
        assert!((value - 9.42).abs() < 1e-14, "{value}");
        assert!((slope - (3.0 + 0.3 * 8.8 - 0.5)).abs() < 1e-14, "{slope}");
        assert_eq!((plays[0], moved), (2.0, 1));
        // Back to 1.5: within the play.
        let (_, _, moved) = law.step(1.5, &mut plays, &mut terms);
        assert_eq!((plays[0], moved, terms[2]), (2.0, 0, 2.0 - 0.375));
        // Beyond the reach it is as at its end.
        let (mut far, mut end) = (plays, plays);
        let (of_far, slope, _) = law.step(9.0, &mut far, &mut terms);
        let (of_end, _, _) = law.step(4.0, &mut end, &mut terms);
        assert_eq!((of_far, slope, far), (of_end, 0.0, end));
        let (_, _, _) = law.step(1.5, &mut plays, &mut terms);
        // Down to 0: z + r = 1 < 2.
        let (_, _, moved) = law.step(0.0, &mut plays, &mut terms);
        assert_eq!((plays[0], moved), (1.0, 1));
    }
}
