//! Contradictions between the printed numbers.

use super::ArticleError;
use super::printed::{self, EQ_13, TABLE_2, TABLE_3};
use super::static_block::StaticParameters;
use hysteron_model::Start;
use hysteron_model::dynamics::{Scheme, SimulationPlan, Term, TransferFunction};
use hysteron_model::hysteresis::BoucWen;
use hysteron_optimize::root_mean_square;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, SQRT_2, TAU};

/// Checks of the printed numbers against each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Contradictions {
    /// Table 2 followed by Eq. 13, driven over 0–10 V.
    pub behind_the_loop: Vec<BehindTheLoop>,
    /// Stroke of that loop \[µm\].
    pub stroke_um: f64,
    /// Mean displacement of that loop, counted from its lowest point \[µm\].
    pub mean_um: f64,
    /// Displacement of that loop at 5 V going up and coming down \[µm\].
    pub at_5_v_um: (f64, f64),
    /// Largest mean |y| that RE and RMSE of Table 2 allow \[µm\]: RE = mean|e| / mean|y| and mean|e| ≤ RMSE.
    pub mean_y_at_most_um: f64,
    /// Mean |y| for a Gaussian residual, mean|e| = √(2/π) RMSE \[µm\].
    pub mean_y_gaussian_um: f64,
    /// Mean |y| for a sinusoidal residual, mean|e| = (2√2/π) RMSE \[µm\].
    pub mean_y_sinusoidal_um: f64,
    /// Largest RMSE of the fractional model in Table 3 and its frequency \[µm, Hz\]; the abstract calls
    /// another one the largest.
    pub largest_fractional_rmse: (f64, f64),
    /// Parameters whose printed lower bound lies above the upper one, of five.
    pub inverted_bounds: usize,
}

/// Error of a static model on the plant of Table 2 followed by Eq. 13: implied and printed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BehindTheLoop {
    /// Frequency \[Hz\].
    pub frequency_hz: f64,
    /// RMSE of the block of Table 2 against the plant, each about its mean \[µm\].
    pub rmse_um: f64,
    /// That RMSE with the gain of the static model fitted to this frequency \[µm\].
    pub rmse_best_gain_um: f64,
    /// Printed RMSE of the classic Bouc–Wen model \[µm\].
    pub printed_um: f64,
}

/// Samples per period.
const SAMPLES: usize = 2000;

impl Contradictions {
    /// Computes them; takes a fraction of a second.
    ///
    /// # Errors
    /// Never with the printed numbers: [`ArticleError`] of a simulation.
    pub fn compute() -> Result<Self, ArticleError> {
        let block = StaticParameters::printed(&TABLE_2).block()?;
        let plant = printed_eq13()?;
        let mut behind_the_loop = Vec::new();
        for row in &TABLE_3 {
            // The initial hysteresis state decays by e^(−2 β 10 V) per period, the transient of G within 0.1
            // s.
            let periods = (0.1 * row.frequency_hz).ceil() as usize + 5;
            let v = loop_of_table_2(&block, periods)?;
            let rate = row.frequency_hz * SAMPLES as f64;
            let scheme = SimulationPlan::new(v.len(), rate, Scheme::Tustin, Start::ZERO)?;
            let mut y = vec![0.0; v.len()];
            scheme.simulate(&plant, &v, &mut scheme.workspace(), &mut y)?;
            let from = v.len() - SAMPLES;
            let (v, y) = (about_mean(&v[from..]), about_mean(&y[from..]));
            let gain = dot(&v, &y) / dot(&v, &v);
            let distance = |gain: f64| -> f64 {
                root_mean_square(&v.iter().zip(&y).map(|(v, y)| y - gain * v).collect::<Vec<f64>>())
            };
            behind_the_loop.push(BehindTheLoop {
                frequency_hz: row.frequency_hz,
                rmse_um: distance(1.0),
                rmse_best_gain_um: distance(gain),
                printed_um: row.classic.rmse_um,
            });
        }
        let v = loop_of_table_2(&block, 5)?;
        let last = &v[v.len() - SAMPLES..];
        let (low, high) =
            last.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &v| (l.min(v), h.max(v)));
        let ratio = TABLE_2.rmse / TABLE_2.re;
        let largest = TABLE_3.iter().max_by(|a, b| a.fractional.rmse_um.total_cmp(&b.fractional.rmse_um));
        let (lower, upper) = printed::SEARCH_BOX;
        Ok(Self {
            behind_the_loop,
            stroke_um: high - low,
            mean_um: last.iter().map(|v| v - low).sum::<f64>() / SAMPLES as f64,
            at_5_v_um: (last[SAMPLES / 4], last[3 * SAMPLES / 4]),
            mean_y_at_most_um: ratio,
            mean_y_gaussian_um: (2.0 / PI).sqrt() * ratio,
            mean_y_sinusoidal_um: 2.0 * SQRT_2 / PI * ratio,
            largest_fractional_rmse: largest
                .map_or((f64::NAN, f64::NAN), |r| (r.fractional.rmse_um, r.frequency_hz)),
            inverted_bounds: lower.iter().zip(&upper).filter(|(low, high)| low > high).count(),
        })
    }
}

/// Eq. 13 as printed.
fn printed_eq13() -> Result<TransferFunction, ArticleError> {
    let term = Term::new;
    Ok(TransferFunction::new(
        vec![term(EQ_13.b, 0.0)],
        vec![term(EQ_13.c0, 0.0), term(EQ_13.c1, EQ_13.alpha1), term(1.0, EQ_13.alpha2)],
    )?)
}

/// Displacement of the block of Table 2 for a drive 5 − 5 cos, 0–10 V, from rest.
fn loop_of_table_2(block: &BoucWen, periods: usize) -> Result<Vec<f64>, ArticleError> {
    let u: Vec<f64> =
        (0..periods * SAMPLES).map(|k| 5.0 - 5.0 * (TAU * k as f64 / SAMPLES as f64).cos()).collect();
    let mut v = vec![0.0; u.len()];
    block.simulate(&u, Start::Rest { voltage_v: 0.0 }, &mut v)?;
    Ok(v)
}

fn about_mean(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter().map(|x| x - mean).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 0.65 / 1.07 / 2.65 / 5.5 µm for a 31 µm loop; at 5 V 11.59 µm going up, 8.61 going down (computed
    /// independently with numpy: explicit steps of the closed form, and the convolution quadrature).
    #[test]
    fn printed_numbers_contradict_each_other_as_computed_independently() {
        let c = Contradictions::compute().unwrap();
        for (found, expected) in c.behind_the_loop.iter().zip([0.65, 1.07, 2.65, 5.5]) {
            assert!((found.rmse_um / expected - 1.0).abs() < 0.01, "{found:?}");
            assert!(found.rmse_best_gain_um < found.rmse_um && found.rmse_um > 4.0 * found.printed_um);
        }
        assert!((c.stroke_um - 31.3).abs() < 0.05, "{}", c.stroke_um);
        // Those values are of the third period, before the initial state has decayed.
        let third = loop_of_table_2(&StaticParameters::printed(&TABLE_2).block().unwrap(), 3).unwrap();
        let (up, down) = (third[2 * SAMPLES + SAMPLES / 4], third[2 * SAMPLES + 3 * SAMPLES / 4]);
        assert!((up - 11.59).abs() < 0.005 && (down - 8.61).abs() < 0.005, "{up} {down}");
        assert!(
            (c.at_5_v_um.0 - up).abs() < 0.05 && (c.at_5_v_um.1 - down).abs() < 0.05,
            "{:?}",
            c.at_5_v_um
        );
        assert!(c.mean_y_gaussian_um < 0.5 && c.mean_y_sinusoidal_um > 0.5 && c.mean_y_at_most_um < 0.58);
        assert!(c.mean_um > 20.0 * c.mean_y_at_most_um);
        assert_eq!(c.largest_fractional_rmse, (0.0264, 10.0));
        assert_eq!(c.inverted_bounds, 5);
    }
}
