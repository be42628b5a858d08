//! What a joint fit asks of each family of hysteresis operators: roles and ranges of its numbers, and where to start.

use std::f64::consts::TAU;

use super::super::layout::{BoxBuilder, Role};
use super::super::options::Choice;
use super::super::static_step::Scales;
use super::setup::JointSetup;
use hysteron_model::Start;
use hysteron_model::hysteresis::{FamilyForm, HysteresisForm};
use hysteron_model::record::range_of;
use hysteron_optimize::Range;

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
            HysteresisForm::Family(form) => self.columns(form, space),
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

    /// Roles of a family of columns: ranges that go with the span of the drives. The grid of a plane spans them.
    fn columns(&self, form: FamilyForm, space: &mut BoxBuilder<'_>) -> (Vec<Role>, Vec<Role>) {
        let demands = &self.options.demands;
        let Scales { range_v, largest_v, slope, .. } = self.scales;
        let (low, high) = self.span();
        let (lowest, highest) = self.grid(form);
        let weights = form.weight_numbers().into_iter().map(|(name, unit)| {
            // µm per unit of the column, whose size goes with its power of the drive.
            let most = 10.0 * slope.abs() * range_v.max(largest_v).powi(1 + unit.input);
            let range = Range::linear(&name, -most, most);
            if form.is_monotone() { space.one_sided(range, slope.signum()) } else { space.projected(range) }
        });
        let weights = weights.collect();
        let steepest = 20.0 / range_v;
        let straightest = LEAST_BEND / range_v;
        let numbers = form.shape_numbers().into_iter().enumerate();
        let shape = numbers.map(|(index, (name, _))| {
            let held = |value: f64| (value, None);
            let searched = |range: Range| (f64::NAN, Some(range));
            let (value, range) = match (form, name.as_str()) {
                (_, "low") => held(lowest),
                (_, "high") => held(highest),
                (FamilyForm::MaxwellSlip { .. }, _) => held(0.5 * range_v),
                (FamilyForm::OneSidedPlays { .. }, _) => held(range_v),
                (FamilyForm::KrasnoselskiiPokrovskii { lines }, _) => {
                    held((highest - lowest) / (lines.max(2) - 1) as f64)
                }
                (FamilyForm::SongDerKiureghian, _) if index > 0 => {
                    searched(Range::linear(&name, -steepest, steepest))
                }
                (_, name) if name.starts_with("gamma") || name == "delta" => {
                    searched(Range::linear(name, -steepest, steepest))
                }
                (_, name) if name.starts_with("beta") || name == "rate" => {
                    searched(Range::linear(name, straightest, steepest))
                }
                (FamilyForm::DeadZonePlays { .. }, "reach") => {
                    searched(Range::logarithmic(&name, 0.02 * range_v, 2.0 * range_v))
                }
                (_, "reach") => searched(Range::logarithmic(&name, 1.0 / steepest, 1.0 / straightest)),
                (FamilyForm::RateDependentPlays { .. }, "scale") => held(0.5 * range_v),
                // A play at the fastest drive is wider by λ times its rate.
                (_, "rate_gain") => searched(Range::linear(&name, 0.0, 1.0 / self.fastest_rate())),
                (_, "loop_share") => searched(Range::linear(&name, 0.0, 0.95)),
                (_, "exponent") => searched(Range::linear(&name, 0.2, 3.0)),
                (_, "rise_right" | "rise_left") => {
                    searched(Range::logarithmic(&name, 0.05 / range_v, 20.0 / range_v))
                }
                (_, "centre_right" | "centre_left") => {
                    searched(Range::linear(&name, low - range_v, high + range_v))
                }
                (_, "bias") => searched(Range::linear(&name, low - range_v, high + range_v)),
                (_, "half_width") => searched(Range::linear(&name, 0.0, range_v)),
                (_, "half_width_spread" | "bias_spread") => {
                    searched(Range::logarithmic(&name, 0.02 * range_v, 10.0 * range_v))
                }
                (_, "anhysteretic") => searched(Range::logarithmic(&name, 0.02 * range_v, 20.0 * range_v)),
                (_, "pinning") => searched(Range::logarithmic(&name, 0.005 * range_v, 5.0 * range_v)),
                (_, "reversibility") => searched(Range::linear(&name, 0.0, 0.95)),
                (_, "coupling") => searched(Range::linear(&name, 0.0, range_v)),
                _ => held(1.0),
            };
            match range {
                Some(range) => space.searched(range),
                None => Role::Fixed(demands.fixed(&name).unwrap_or(value)),
            }
        });
        let shape = shape.collect();
        (weights, shape)
    }

    /// Ends of what a family's grid covers: of a plane of relays all that a drive can switch. A device that was virgin where a record
    /// begins has relays that close on the first way up and open far below the lowest voltage only: a plane that ends at the
    /// voltages of the records leaves them out, and with them the first branch.
    fn grid(&self, form: FamilyForm) -> (f64, f64) {
        let (low, high) = self.span();
        let is_plane = matches!(
            form,
            FamilyForm::KrasnoselskiiPokrovskii { .. }
                | FamilyForm::Preisach { .. }
                | FamilyForm::PreisachDensity
        );
        let begins = self.members.iter().filter(|m| is_plane && m.before != Start::PERIODIC);
        let virgin = begins.filter_map(|member| match member.before {
            Start::Rest { voltage_v } => Some(voltage_v),
            _ => member.facts.data.u.first().copied(),
        });
        // Virgin at v, relays with α + β < 2v are closed: mirror images of the ends.
        virgin.fold((low, high), |(lowest, highest), v| {
            (lowest.min(2.0 * v - high), highest.max(2.0 * v - low))
        })
    }

    /// Lowest and highest voltage of all records.
    fn span(&self) -> (f64, f64) {
        let spans = self.members.iter().map(|member| range_of(&member.facts.data.u));
        spans.fold((f64::MAX, f64::MIN), |(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// Rate of the fastest drive at its mean, for a drive of half the range either side \[1/s\].
    fn fastest_rate(&self) -> f64 {
        TAU * self.fastest_hz
    }

    /// Shapes of a family of columns to start from.
    fn shapes_of(&self, form: FamilyForm) -> Vec<Vec<f64>> {
        let range_v = self.scales.range_v;
        let (low, high) = self.span();
        let (lowest, highest) = self.grid(form);
        let middle = 0.5 * (low + high);
        let bends = || SHARPNESSES.iter().map(|sharpness| sharpness / range_v);
        match form {
            FamilyForm::ParallelBoucWen { states } => bends()
                .map(|beta| (0..states).flat_map(|k| [beta * 4f64.powi(k as i32), 0.0]).collect())
                .collect(),
            FamilyForm::NonSymmetricBoucWen => {
                bends().flat_map(|beta| SKEWS.map(|skew| vec![beta, skew * beta, 0.0])).collect()
            }
            FamilyForm::SongDerKiureghian => bends()
                .flat_map(|beta| SKEWS.map(|skew| vec![beta, 0.0, skew * beta, 0.0, 0.0, 0.0]))
                .collect(),
            FamilyForm::Dahl => bends().map(|bend| vec![1.0 / bend, 1.0]).collect(),
            FamilyForm::Duhem { .. } => bends().map(|bend| vec![bend]).collect(),
            FamilyForm::MaxwellSlip { .. } => vec![vec![0.5 * range_v]],
            FamilyForm::OneSidedPlays { .. } => vec![vec![range_v]],
            FamilyForm::RateDependentPlays { .. } => {
                [0.0, 0.1, 0.4].map(|wider| vec![0.5 * range_v, wider / self.fastest_rate()]).into()
            }
            FamilyForm::DeadZonePlays { .. } => [0.1, 0.5]
                .iter()
                .flat_map(|share| [0.1, 0.5].map(|reach| vec![low, high, *share, reach * range_v]))
                .collect(),
            FamilyForm::GeneralisedPlays { .. } => {
                [0.3, 1.0, 3.0].map(|rise| vec![rise / range_v, middle, rise / range_v, middle]).into()
            }
            FamilyForm::KrasnoselskiiPokrovskii { lines } => {
                vec![vec![lowest, highest, (highest - lowest) / (lines.max(2) - 1) as f64]]
            }
            FamilyForm::Preisach { .. } => vec![vec![lowest, highest]],
            FamilyForm::PreisachDensity => [0.1, 0.3]
                .iter()
                .flat_map(|width| {
                    [0.3, 1.0]
                        .map(|spread| vec![lowest, highest, 0.0, width * range_v, middle, spread * range_v])
                })
                .collect(),
            FamilyForm::JilesAtherton => [0.1, 0.3, 1.0]
                .iter()
                .flat_map(|a| [0.05, 0.2].map(|k| vec![a * range_v, k * range_v, 0.1, 0.05 * a * range_v]))
                .collect(),
        }
    }

    /// Where the memory of a record is searched.
    pub(super) fn memory_range(&self, record: usize) -> (f64, f64) {
        match self.hysteresis {
            HysteresisForm::BoucWen => (-self.scales.range_v, self.scales.range_v),
            HysteresisForm::PrandtlIshlinskii { .. } | HysteresisForm::Family(_) => {
                // A device may have come from beyond the voltages of the record.
                let (low, high) = range_of(&self.members[record].facts.data.u);
                (low - self.scales.range_v, high + self.scales.range_v)
            }
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
            HysteresisForm::Family(form) => self.shapes_of(form),
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
            // At rest at the lower end of their range, plays that only lag behind a falling voltage remember what was below.
            (HysteresisForm::Family(FamilyForm::OneSidedPlays { .. }), _) if settled => {
                u[0] - 0.25 * self.scales.range_v
            }
            _ if settled => 0.5 * (low + high),
            _ => u[0],
        }
    }
}
