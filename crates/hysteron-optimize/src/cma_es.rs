//! Covariance matrix adaptation evolution strategy, Hansen and Ostermeier 2001,
//! doi:10.1162/106365601750190398, with the constants of Hansen's tutorial (arXiv:1604.00772), and restarts
//! with twice the population each (IPOP: Auger and Hansen 2005, doi:10.1109/CEC.2005.1554902).
//!
//! A generation draws λ candidates x = m + σ y, y ~ N(0, C), ranks them, and moves the mean m to the weighted
//! mean of the better half; the step σ and the covariance C follow from the path that the mean takes. With C
//! = B D² Bᵀ, y = B D z, z ~ N(0, I):
//!
//! - m ← m + σ ⟨y⟩, ⟨y⟩ = Σ wᵢ y₍ᵢ₎, wᵢ ∝ ln((λ + 1)/2) − ln i, i ≤ λ/2;
//! - p_σ ← (1 − c_σ) p_σ + √(c_σ (2 − c_σ) μ_eff) B ⟨z⟩,  σ ← σ exp(c_σ/d_σ (‖p_σ‖/E‖N(0, I)‖ − 1));
//! - p_c ← (1 − c_c) p_c + h_σ √(c_c (2 − c_c) μ_eff) ⟨y⟩;
//! - C ← (1 − c₁ (1 − (1 − h_σ) c_c (2 − c_c)) − c_μ) C + c₁ p_c p_cᵀ + c_μ Σ wᵢ y₍ᵢ₎ y₍ᵢ₎ᵀ.
//!
//! Bounds are handled by periodic reflection: space is the box mirrored repeatedly at its bounds, so that no
//! penalty weight has to be chosen and a minimum at a bound stays a minimum.

use nalgebra::{DMatrix, SymmetricEigen};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::OptimizeError;
use super::algorithm::{check_option, check_population};
use super::infinite_as_null;
use super::ledger::{Scratch, Search};
use super::stream::Stream;

/// Most doublings of the population.
const MOST_DOUBLINGS: usize = 10;
/// A run ends where the best costs of its last generations agree to this share.
const FLAT: f64 = 1e-12;
/// … or the distribution is narrower than this share of the box,
const NARROW: f64 = 1e-12;
/// … or wider than this many boxes,
const WIDE: f64 = 1e3;
/// … or its longest axis is that much longer than its shortest.
const LONGEST_AXIS: f64 = 1e7;

/// Options of the covariance matrix adaptation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CmaEsOptions {
    /// Candidates of a generation λ before the first restart, at least 4; `None`: 4 + ⌊3 ln D⌋ for D
    /// parameters.
    pub population: Option<usize>,
    /// First step σ as a share of the box, 0 < σ ≤ 1.
    pub step: f64,
}

impl Default for CmaEsOptions {
    /// λ = 4 + ⌊3 ln D⌋, σ = 0.3.
    fn default() -> Self {
        Self { population: None, step: 0.3 }
    }
}

impl CmaEsOptions {
    pub(super) fn validate(&self) -> Result<(), OptimizeError> {
        check_population(
            self.population.unwrap_or(4),
            4,
            "at least 4 candidates, of which the better half counts",
        )?;
        check_option("step", self.step, self.step > 0.0 && self.step <= 1.0, "0 < σ ≤ 1")
    }

    fn population(&self, dimension: usize, restarts: usize) -> usize {
        let first = self.population.unwrap_or(4 + (3.0 * (dimension as f64).ln()) as usize);
        first.saturating_mul(1 << restarts.min(MOST_DOUBLINGS))
    }

    /// Window of generations for detecting stagnation.
    fn window(&self, dimension: usize, restarts: usize) -> usize {
        10 + 30 * dimension / self.population(dimension, restarts)
    }
}

/// Sampling distribution of the candidates, and the evolution paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Distribution {
    restarts: usize,
    /// Generations since the last restart.
    age: usize,
    /// m, in the mirrored space.
    mean: Vec<f64>,
    /// σ.
    step: f64,
    /// C, row by row.
    covariance: Vec<f64>,
    /// p_σ.
    step_path: Vec<f64>,
    /// p_c.
    covariance_path: Vec<f64>,
    /// Best cost of each of the latest generations.
    #[serde(with = "infinite_as_null::many")]
    latest: Vec<f64>,
}

impl Distribution {
    /// A distribution around the best of the given starts, or around one uniformly drawn point.
    pub(super) fn new(options: &CmaEsOptions, search: &mut Search<'_>) -> Self {
        let (points, costs) = search.initial_population(search.settings.starts.len().max(1));
        let best = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b])).unwrap_or(0);
        Self::around(points.get(best).to_vec(), options, 0)
    }

    fn around(mean: Vec<f64>, options: &CmaEsOptions, restarts: usize) -> Self {
        let dimension = mean.len();
        Self {
            restarts,
            age: 0,
            step: options.step,
            covariance: DMatrix::identity(dimension, dimension).as_slice().to_vec(),
            step_path: vec![0.0; dimension],
            covariance_path: vec![0.0; dimension],
            latest: Vec::new(),
            mean,
        }
    }

    pub(super) fn is_consistent(&self, options: &CmaEsOptions, dimension: usize) -> bool {
        let vectors = [&self.mean, &self.step_path, &self.covariance_path];
        let symmetric =
            |c: &[f64]| (0..dimension).all(|i| (0..i).all(|j| c[i * dimension + j] == c[j * dimension + i]));
        self.latest.len() == self.age.min(options.window(dimension, self.restarts))
            && vectors.iter().all(|v| v.len() == dimension && v.iter().all(|x| x.is_finite()))
            && self.step > 0.0
            && self.step.is_finite()
            && self.covariance.len() == dimension * dimension
            && self.covariance.iter().all(|c| c.is_finite())
            && symmetric(&self.covariance)
    }

    /// True if the distribution has converged or degenerated; `ranked`: costs of its last candidates, best
    /// first.
    fn is_spent(&self, ranked: &[f64], axes: &[f64], window: usize) -> bool {
        let (best, worst) = (ranked[0], ranked[ranked.len() - 1]);
        let longest = axes.iter().copied().fold(0.0, f64::max);
        let shortest = axes.iter().copied().fold(f64::INFINITY, f64::min);
        let width = self.step * longest;
        let healthy = width > NARROW && width < WIDE && longest < LONGEST_AXIS * shortest;
        let highest = self.latest.iter().copied().fold(worst, f64::max);
        let flat = self.latest.len() >= window && highest - best <= FLAT * best.abs();
        !healthy || flat || best.is_infinite()
    }
}

/// The strategy's constants for λ candidates of a dimension.
struct Constants {
    /// wᵢ of the better half, Σ w = 1.
    weights: Vec<f64>,
    /// μ_eff = 1/Σ w².
    effective: f64,
    c_sigma: f64,
    d_sigma: f64,
    c_c: f64,
    c_1: f64,
    c_mu: f64,
    /// E‖N(0, I)‖.
    expected_length: f64,
}

impl Constants {
    fn new(population: usize, dimension: usize) -> Self {
        let n = dimension as f64;
        let mut weights: Vec<f64> =
            (1..=population / 2).map(|i| ((population as f64 + 1.0) / 2.0).ln() - (i as f64).ln()).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        let effective = 1.0 / weights.iter().map(|w| w * w).sum::<f64>();
        let c_sigma = (effective + 2.0) / (n + effective + 5.0);
        let d_sigma = 1.0 + 2.0 * (((effective - 1.0) / (n + 1.0)).sqrt() - 1.0).max(0.0) + c_sigma;
        let c_c = (4.0 + effective / n) / (n + 4.0 + 2.0 * effective / n);
        let c_1 = 2.0 / ((n + 1.3).powi(2) + effective);
        let c_mu =
            (2.0 * (effective - 2.0 + 1.0 / effective) / ((n + 2.0).powi(2) + effective)).min(1.0 - c_1);
        let expected_length = n.sqrt() * (1.0 - 1.0 / (4.0 * n) + 1.0 / (21.0 * n * n));
        Self { weights, effective, c_sigma, d_sigma, c_c, c_1, c_mu, expected_length }
    }
}

/// One generation.
pub(super) fn generation(
    options: &CmaEsOptions,
    distribution: &mut Distribution,
    search: &mut Search<'_>,
    scratch: &mut Scratch,
) {
    let dimension = search.dimension();
    let population = options.population(dimension, distribution.restarts);
    let eigen = SymmetricEigen::new(DMatrix::from_row_slice(dimension, dimension, &distribution.covariance));
    let axes: Vec<f64> = eigen.eigenvalues.iter().map(|&l| l.max(0.0).sqrt()).collect();
    let basis = &eigen.eigenvectors;

    scratch.clear();
    let mut z = DMatrix::zeros(dimension, population);
    let mut y = DMatrix::zeros(dimension, population);
    for k in 0..population {
        normal(&mut search.stream(), z.column_mut(k).as_mut_slice());
        let scaled = z.column(k).component_mul(&nalgebra::DVector::from_column_slice(&axes));
        y.set_column(k, &(basis * scaled));
        let candidate = scratch.candidates.push(&distribution.mean);
        candidate.iter_mut().zip(&y.column(k)).for_each(|(x, y)| *x = mirrored(*x + distribution.step * y));
    }
    search.evaluate(&mut scratch.candidates, &mut scratch.costs);
    if scratch.costs.len() < population {
        // The budget is spent.
        return;
    }
    scratch.owners.extend(0..population);
    scratch.owners.sort_by(|&a, &b| scratch.costs[a].total_cmp(&scratch.costs[b]));
    let constants = Constants::new(population, dimension);
    distribution.adapt(&constants, &scratch.owners, &y, &(basis * &z));
    scratch.weights.clear();
    scratch.weights.extend(scratch.owners.iter().map(|&k| scratch.costs[k]));
    let window = options.window(dimension, distribution.restarts);
    if distribution.latest.len() == window {
        distribution.latest.remove(0);
    }
    distribution.latest.push(scratch.weights[0]);
    if distribution.is_spent(&scratch.weights, &axes, window) {
        let mut random = search.stream();
        let mean = (0..dimension).map(|_| random.unit()).collect();
        *distribution = Distribution::around(mean, options, distribution.restarts + 1);
    }
}

impl Distribution {
    /// Moves mean, step and covariance after a generation; `ranking`: candidates, best first; `y` and `bz` =
    /// B z hold a candidate a column.
    fn adapt(&mut self, constants: &Constants, ranking: &[usize], y: &DMatrix<f64>, bz: &DMatrix<f64>) {
        let Constants { weights, effective, c_sigma, d_sigma, c_c, c_1, c_mu, expected_length } = constants;
        let dimension = self.mean.len();
        let better: Vec<(f64, usize)> = weights.iter().copied().zip(ranking.iter().copied()).collect();
        let weighted = |of: &DMatrix<f64>, j: usize| better.iter().map(|&(w, k)| w * of[(j, k)]).sum::<f64>();
        self.age += 1;
        let pull = (c_sigma * (2.0 - c_sigma) * effective).sqrt();
        for j in 0..dimension {
            self.mean[j] += self.step * weighted(y, j);
            self.step_path[j] = (1.0 - c_sigma) * self.step_path[j] + pull * weighted(bz, j);
        }
        let length = self.step_path.iter().map(|p| p * p).sum::<f64>().sqrt();
        // Corrects for a path that has not reached its stationary length.
        let stationary = (1.0 - (1.0 - c_sigma).powi(2 * self.age.min(100_000) as i32)).sqrt();
        let steady = length / stationary < (1.4 + 2.0 / (dimension as f64 + 1.0)) * expected_length;
        let (pull, loss) =
            if steady { ((c_c * (2.0 - c_c) * effective).sqrt(), 0.0) } else { (0.0, c_c * (2.0 - c_c)) };
        for j in 0..dimension {
            self.covariance_path[j] = (1.0 - c_c) * self.covariance_path[j] + pull * weighted(y, j);
        }
        let keep = 1.0 - c_1 * (1.0 - loss) - c_mu;
        for i in 0..dimension {
            for j in 0..=i {
                let spread: f64 = better.iter().map(|&(w, k)| w * y[(i, k)] * y[(j, k)]).sum();
                let path = self.covariance_path[i] * self.covariance_path[j];
                let c = keep * self.covariance[i * dimension + j] + c_1 * path + c_mu * spread;
                self.covariance[i * dimension + j] = c;
                self.covariance[j * dimension + i] = c;
            }
        }
        self.step *= (c_sigma / d_sigma * (length / expected_length - 1.0)).min(1.0).exp();
    }
}

/// Reflects the coordinate `t` of the mirrored space into [0, 1].
fn mirrored(t: f64) -> f64 {
    let t = t.rem_euclid(2.0);
    if t > 1.0 { (2.0 - t).max(0.0) } else { t }
}

/// Independent normal numbers (Box and Muller 1958, doi:10.1214/aoms/1177706645).
fn normal(random: &mut Stream, out: &mut [f64]) {
    for pair in out.chunks_mut(2) {
        // 1 − [0, 1) is never 0.
        let radius = (-2.0 * (1.0 - random.unit()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * random.unit()).sin_cos();
        pair.iter_mut().zip([radius * cos, radius * sin]).for_each(|(o, x)| *o = x);
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_problems::{Cost, cube};
    use super::super::{Algorithm, Settings, Unobserved, minimize_cost};
    use super::*;

    #[test]
    fn constants_are_those_of_the_tutorial() {
        // Table 1 of arXiv:1604.00772 by hand for n = 10, λ = 10: μ = 5, μ_eff = 3.1672992814.
        let c = Constants::new(10, 10);
        assert!((c.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        assert!((c.effective - 3.167_299_281).abs() < 1e-8, "{}", c.effective);
        assert!((c.c_sigma - 5.167_299_281 / 18.167_299_281).abs() < 1e-9);
        assert!((c.c_1 - 2.0 / (11.3f64.powi(2) + 3.167_299_281)).abs() < 1e-9);
        assert!((c.expected_length - 3.084_746).abs() < 1e-4, "{}", c.expected_length);
    }

    /// In the first generation p_σ has the length √(c_σ (2 − c_σ) μ_eff) ‖Σ w z‖, its stationary length that share of
    /// √(1 − (1 − c_σ)²): beyond (1.4 + 2/(n + 1)) E‖N(0, I)‖ the covariance path stands still.
    #[test]
    fn covariance_path_stands_still_after_a_long_first_step() {
        let constants = Constants::new(6, 2);
        let longest = (1.4 + 2.0 / 3.0) * constants.expected_length / constants.effective.sqrt();
        for (share, stands_still) in [(0.95, false), (1.05, true)] {
            let mut distribution = Distribution::around(vec![0.5; 2], &CmaEsOptions::default(), 0);
            let bz = DMatrix::from_fn(2, 6, |row, _| if row == 0 { share * longest } else { 0.0 });
            distribution.adapt(&constants, &[0, 1, 2, 3, 4, 5], &bz, &bz);
            assert_eq!(distribution.covariance_path == [0.0, 0.0], stands_still, "{share}");
        }
    }

    #[test]
    fn space_is_the_box_mirrored_at_its_walls() {
        for (t, place) in [(0.25, 0.25), (1.25, 0.75), (-0.25, 0.25), (2.25, 0.25), (-1.5, 0.5), (3.0, 1.0)] {
            assert!((mirrored(t) - place).abs() < 1e-15, "{t}");
        }
        assert!((0.0..=1.0).contains(&mirrored(-1e-300)));
    }

    #[test]
    fn minimum_in_a_corner_of_the_box_is_reached() {
        let corner = Cost { bounds: cube(5, 0.0, 1.0), cost: |x: &[f64]| x.iter().map(|x| x + x * x).sum() };
        let algorithm = Algorithm::CmaEs(CmaEsOptions::default());
        let outcome = minimize_cost(
            &corner,
            &algorithm,
            &Settings { generations: 300, ..Settings::default() },
            &mut Unobserved,
            None,
        )
        .unwrap();
        assert!(outcome.cost < 1e-6, "{}", outcome.cost);
    }

    /// Rotational invariance: a rotated ellipsoid of axes 1 : 10⁶ is solved like a sphere, with a tenth of
    /// the others' evaluations.
    #[test]
    fn turned_ellipsoid_is_no_harder_than_its_condition() {
        let n = 6;
        let cost = move |x: &[f64]| {
            // Householder reflection of v = (1, 2, …, n).
            let v: Vec<f64> = (1..=n).map(f64::from).collect();
            let vv: f64 = v.iter().map(|v| v * v).sum();
            let vx: f64 = v.iter().zip(x).map(|(v, x)| v * (x - 0.3)).sum();
            x.iter()
                .zip(&v)
                .enumerate()
                .map(|(j, (x, v))| {
                    let turned = (x - 0.3) - 2.0 * v * vx / vv;
                    1e6f64.powf(j as f64 / f64::from(n - 1)) * turned * turned
                })
                .sum()
        };
        let problem = Cost { bounds: cube(6, 0.0, 1.0), cost };
        for seed in 1..=5 {
            let settings = Settings {
                seed,
                generations: 2000,
                target: Some(1e-9),
                budget: Some(6000),
                ..Settings::default()
            };
            let algorithm = Algorithm::CmaEs(CmaEsOptions::default());
            let outcome = minimize_cost(&problem, &algorithm, &settings, &mut Unobserved, None).unwrap();
            assert!(outcome.cost <= 1e-9, "{seed}: {:e}", outcome.cost);
        }
    }
}
