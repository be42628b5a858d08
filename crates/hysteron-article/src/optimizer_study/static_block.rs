//! The article's static problem: the improved Bouc–Wen model from a 1 Hz loop.

use super::noise::add_noise;
use crate::ArticleError;
use hysteron_model::Start;
use hysteron_model::hysteresis::{BoucWen, bouc_wen::UnitShape};
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, Range, root_mean_square};
use std::f64::consts::TAU;

const SAMPLES: usize = 2000;
const SAMPLE_RATE_HZ: f64 = 1000.0;
const NOISE_UM: f64 = 0.012;

/// Fit of (quadratic, linear, α, β, γ), n = 1, to two periods of u = 5 − 5 cos 2πt V at 1 kHz (2000 samples),
/// from rest at 0 V; truth is the article's Table 2, with normal noise of 0.012 µm.
#[derive(Clone, Debug)]
pub struct StaticBlock {
    bounds: Bounds,
    u: Vec<f64>,
    y: Vec<f64>,
}

impl StaticBlock {
    /// The problem in one sentence.
    pub const DESCRIPTION: &'static str = "u = 5 - 5 cos 2 pi t V, two periods at 1 kHz (2000 samples), \
        article Table 2 as truth with n = 1, normal noise of 0.012 um; quadratic, linear, alpha, beta, gamma \
        sought at once";

    /// Article Table 2 in the order of the parameters: quadratic \[µm/V²\], linear, α \[µm/V\], β, γ \[1/V\].
    pub const TRUTH: [f64; 5] = [0.0031, 2.0, -1.2039, 0.1111, 0.0024];

    /// The problem with a noise realisation.
    ///
    /// # Errors
    /// [`ArticleError::Hysteresis`] never occurs: the truth is admissible.
    pub fn new(noise_seed: u64) -> Result<Self, ArticleError> {
        let u: Vec<f64> = (0..SAMPLES).map(|k| 5.0 - 5.0 * (TAU * k as f64 / SAMPLE_RATE_HZ).cos()).collect();
        let mut y = vec![0.0; SAMPLES];
        let [quadratic, linear, alpha, beta, gamma] = Self::TRUTH;
        BoucWen::new(vec![linear, quadratic], alpha, beta, gamma, 1.0)?.simulate(
            &u,
            Start::Rest { voltage_v: 0.0 },
            &mut y,
        )?;
        add_noise(&mut y, NOISE_UM, noise_seed);
        let ranges = vec![
            Range::linear("quadratic", 0.0, 1.0),
            Range::linear("linear", 0.0, 4.0),
            Range::linear("alpha", -2.0, 0.0),
            Range::linear("beta", 0.0, 1.0),
            Range::linear("gamma", -1.0, 1.0),
        ];
        Ok(Self { bounds: Bounds { ranges }, u, y })
    }

    /// Standard deviation of the noise \[µm\].
    pub const fn noise_um() -> f64 {
        NOISE_UM
    }
}

impl Problem for StaticBlock {
    type Workspace = Vec<f64>;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Vec<f64> {
        vec![0.0; SAMPLES]
    }

    fn cost(&self, x: &[f64], workspace: &mut Vec<f64>) -> f64 {
        if self.residuals(x, &mut Vec::new(), workspace) {
            root_mean_square(workspace)
        } else {
            f64::INFINITY
        }
    }

    fn identity(&self) -> String {
        "optimiser study, static block".to_owned()
    }
}

impl LeastSquaresProblem for StaticBlock {
    fn residual_count(&self) -> usize {
        SAMPLES
    }

    /// v − y with v = l\[u\] − α ζ, ζ of the unit-α form: for n = 1, β' = β and γ' = sign(α) γ.
    fn residuals(&self, x: &[f64], _: &mut Vec<f64>, out: &mut [f64]) -> bool {
        let &[quadratic, linear, alpha, beta, gamma] = x else { return false };
        let gamma = if alpha < 0.0 { -gamma } else { gamma };
        let shape = UnitShape { beta, gamma, n: 1.0 };
        if shape.simulate_every(1, &self.u, Start::Rest { voltage_v: 0.0 }, out).is_err() {
            return false;
        }
        for ((r, u), y) in out.iter_mut().zip(&self.u).zip(&self.y) {
            *r = (quadratic * u + linear) * u - alpha * *r - y;
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn residuals_at_the_truth_are_the_noise() {
        let problem = StaticBlock::new(3).unwrap();
        let cost = problem.cost(&StaticBlock::TRUTH, &mut problem.workspace());
        // Standard deviation of the estimate: 0.012/√4000.
        assert!((cost - 0.012).abs() < 4.0 * 1.9e-4, "{cost}");
    }

    #[test]
    fn residuals_are_those_of_the_article_model_for_either_sign_of_alpha() {
        let problem = StaticBlock::new(3).unwrap();
        for [alpha, gamma] in [[-0.7, 0.2], [-0.7, -0.2], [0.0, 0.1]] {
            let model = BoucWen::new(vec![1.5, 0.02], alpha, 0.3, gamma, 1.0).unwrap();
            let (mut v, mut r) = (vec![0.0; SAMPLES], vec![0.0; SAMPLES]);
            model.simulate(&problem.u, Start::Rest { voltage_v: 0.0 }, &mut v).unwrap();
            assert!(problem.residuals(&[0.02, 1.5, alpha, 0.3, gamma], &mut Vec::new(), &mut r));
            let error =
                v.iter().zip(&problem.y).zip(&r).map(|((v, y), r)| (v - y - r).abs()).fold(0.0, f64::max);
            assert!(error < 1e-12, "{error}");
        }
    }
}
