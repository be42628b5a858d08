//! What a joint fit asks of each family of hysteresis operators: roles and ranges of its numbers, and where to start.

use super::super::layout::{BoxBuilder, Role};
use super::super::options::Choice;
use super::super::static_step::Scales;
use super::setup::JointSetup;
use crate::hysteresis::HysteresisForm;
use crate::optimize::Range;
use crate::record::range_of;

/// Least bend β' (range of the drive)ⁿ of a loop that is searched for.
const LEAST_BEND: f64 = 1e-3;
/// Ranges of the drive in which ζ relaxes once, to start from: (β')^(1/n) times the range.
const SHARPNESSES: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
/// γ'/β' to start from.
const SKEWS: [f64; 3] = [-0.7, 0.0, 0.7];
/// Exponent to start from where it is searched.
const EXPONENT: f64 = 1.2;

impl JointSetup<'_> {
    /// Roles of weights and shape numbers.
    pub(super) fn family(&self, space: &mut BoxBuilder<'_>) -> (Vec<Role>, Vec<Role>) {
        match self.hysteresis {
            HysteresisForm::BoucWen => self.bouc_wen(space),
            HysteresisForm::PrandtlIshlinskii { plays } => self.plays(plays, space),
        }
    }

    fn bouc_wen(&self, space: &mut BoxBuilder<'_>) -> (Vec<Role>, Vec<Role>) {
        let Scales { range_v, slope, .. } = self.scales;
        let demands = &self.options.demands;
        let alpha = space.projected(Range::linear("alpha", -2.0 * slope.abs(), 2.0 * slope.abs()));
        // Nothing shapes a hysteretic part that is not there.
        let hysteretic = demands.fixed("alpha") != Some(0.0);
        let held = |name: &str, value: f64| Role::Fixed(demands.fixed(name).unwrap_or(value));
        let n = match self.options.n {
            Choice::Given(n) if demands.bounded("n").is_none() => held("n", n),
            _ if !hysteretic => held("n", 1.0),
            _ => space.searched(Range::linear("n", 1.0, 4.0)),
        };
        // ζ saturates at (β' + γ')^(−1/n) V: with 20 / range the loop is a pure offset switch.
        let steepest = 20.0 / range_v;
        // With much less β' a loop is a parabola of size α β': α grows as β' falls, and nothing else changes.
        let straightest = 1.0 / range_v;
        let (low, high) = match n {
            Role::Fixed(n) => (straightest.powf(n), steepest.powf(n)),
            _ => (straightest.min(straightest.powi(4)), steepest.max(steepest.powi(4))),
        };
        let low = LEAST_BEND * low;
        let (beta, gamma) = if hysteretic {
            (
                space.searched(Range::linear("beta", low, high)),
                space.searched(Range::linear("gamma", -high, high)),
            )
        } else {
            (held("beta", 0.0), held("gamma", 0.0))
        };
        (vec![alpha], vec![beta, gamma, n])
    }

    /// Thresholds at equal distances up to half the range, beyond which no loop moves a play; weights of the sign of the
    /// slope.
    fn plays(&self, plays: usize, space: &mut BoxBuilder<'_>) -> (Vec<Role>, Vec<Role>) {
        let Scales { range_v, slope, .. } = self.scales;
        let demands = &self.options.demands;
        let weights = self.hysteresis.weight_names().into_iter().map(|name| {
            let most = 2.0 * slope.abs();
            space.one_sided(Range::linear(&name, -most, most), slope.signum())
        });
        let weights = weights.collect();
        let distance = 0.5 * range_v / (plays + 1) as f64;
        let thresholds = self.hysteresis.shape_names().into_iter().zip(1..).map(|(name, index)| {
            let grid = f64::from(index) * distance;
            match demands.bounded(&name) {
                Some(_) => space.searched(Range::linear(&name, 0.5 * grid, 2.0 * grid)),
                None => Role::Fixed(demands.fixed(&name).unwrap_or(grid)),
            }
        });
        let thresholds = thresholds.collect();
        (weights, thresholds)
    }

    /// Where the memory of a record is searched.
    pub(super) fn memory_range(&self, record: usize) -> (f64, f64) {
        match self.hysteresis {
            HysteresisForm::BoucWen => (-self.scales.range_v, self.scales.range_v),
            HysteresisForm::PrandtlIshlinskii { .. } => range_of(&self.members[record].facts.data.u),
        }
    }

    /// Shapes to start from.
    pub(super) fn shapes(&self) -> Vec<Vec<f64>> {
        match self.hysteresis {
            HysteresisForm::BoucWen => {
                let n = match self.options.n {
                    Choice::Given(n) => self.options.demands.fixed("n").unwrap_or(n),
                    Choice::Auto => EXPONENT,
                };
                let shape = |sharpness: f64, skew: f64| {
                    let beta = (sharpness / self.scales.range_v).powf(n);
                    vec![beta, skew * beta, n]
                };
                SHARPNESSES.iter().flat_map(|&s| SKEWS.map(|skew| shape(s, skew))).collect()
            }
            HysteresisForm::PrandtlIshlinskii { plays } => {
                let distance = 0.5 * self.scales.range_v / (plays + 1) as f64;
                vec![(1..=plays).map(|index| index as f64 * distance).collect()]
            }
        }
    }

    /// Memory to start a record from: fresh at its first sample, or `settled` on loops like those of the record.
    pub(super) fn first_memory(&self, shape: &[f64], settled: bool, record: usize) -> f64 {
        let u = &self.members[record].facts.data.u;
        let (low, high) = range_of(u);
        match (self.hysteresis, shape) {
            (HysteresisForm::BoucWen, &[beta, gamma, n]) if settled => {
                // Where a loop over the whole range turns, ζ is at most here.
                let saturated = (beta + gamma).powf(-1.0 / n).min(self.scales.range_v);
                saturated * (2.0 * (u[0] - low) / (high - low) - 1.0)
            }
            (HysteresisForm::BoucWen, _) => 0.0,
            (HysteresisForm::PrandtlIshlinskii { .. }, _) if settled => 0.5 * (low + high),
            (HysteresisForm::PrandtlIshlinskii { .. }, _) => u[0],
        }
    }
}
