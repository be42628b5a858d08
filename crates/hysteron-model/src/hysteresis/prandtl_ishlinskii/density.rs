//! A density of plays: many plays, their weights tied by a broken line over their half-widths.

use hysteron_rt::Scalar;

use super::super::columns::{ColumnKernel, simulate_with_sensitivities};
use super::super::family::{
    ColumnFamily, DriveSpan, Elements, FamilyDescription, MOST_ELEMENTS, NumberUnit, RuntimeOperator, Search,
    ShapeNumber, WHOLE_SHAPE,
};
use super::super::outputs::Columns;
use super::super::pass::Every;
use super::super::play_sums::PlaySums;
use super::super::plays::{PlayStates, check_thresholds};
use super::super::{DriveGrid, HysteresisError};
use super::PrandtlIshlinskii;
use crate::start::Start;

/// Columns of a density ρ(r) of plays that is a broken line over their half-widths, ρ(r) = Σⱼ ρⱼ hatⱼ(r) with
/// corners at knots 0 < R₁ < … < R_K, constant below R₁ and 0 above R_K:
///
/// Hⱼ = Σᵢ Tᵢⱼ F_rᵢ\[u\],  Tᵢⱼ = hatⱼ(rᵢ) Δᵢ / Σᵢ hatⱼ(rᵢ) Δᵢ \[V\],
///
/// over a bank of plays that divides every interval between knots equally, Δᵢ being half the distance of the
/// neighbours of rᵢ. The weight of column j is the sum of the weights of its plays. Without shape numbers.
///
/// Few unknowns, and loops without the corners of few plays.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::hysteresis) struct PlayDensity {
    knots: Vec<f64>,
    plays: PlaySums,
}

impl PlayDensity {
    pub(super) fn new(knots: &[f64]) -> Self {
        let parts = (MOST_ELEMENTS / knots.len().max(1)).max(1);
        let below = std::iter::once(0.0).chain(knots.iter().copied());
        let (mut thresholds, mut shares) = (Vec::new(), Vec::new());
        for (index, (low, &high)) in below.zip(knots).enumerate() {
            for part in 1..=parts {
                let at = part as f64 / parts as f64;
                thresholds.push(low + at * (high - low));
                shares.push(if index == 0 { [0.0, 1.0] } else { [1.0 - at, at] });
            }
        }
        let mut before = 0.0;
        for (i, shares) in shares.iter_mut().enumerate() {
            let after = thresholds.get(i + 1).unwrap_or(&thresholds[i]);
            shares.iter_mut().for_each(|share| *share *= 0.5 * (after - before));
            before = thresholds[i];
        }
        let mut plays = PlaySums { parts, thresholds, shares };
        let mut totals = vec![0.0; knots.len()];
        plays.sum::<f64>(&vec![1.0; plays.thresholds.len()], &mut totals);
        for (interval, shares) in plays.shares.chunks_exact_mut(parts).enumerate() {
            for [below, above] in shares {
                *below = interval.checked_sub(1).map_or(0.0, |column| *below / totals[column]);
                *above /= totals[interval];
            }
        }
        Self { knots: knots.to_vec(), plays }
    }

    /// Weights of the plays, from those of the columns.
    fn play_weights(&self, weights: &[f64]) -> Vec<f64> {
        let weight =
            |index: Option<usize>| index.and_then(|index| weights.get(index)).copied().unwrap_or(0.0);
        let of = |(interval, shares): (usize, &[[f64; 2]])| {
            let [below, above] = [weight(interval.checked_sub(1)), weight(Some(interval))];
            shares.iter().map(move |[a, b]| a * below + b * above).collect::<Vec<f64>>()
        };
        self.plays.shares.chunks_exact(self.plays.parts).enumerate().flat_map(of).collect()
    }
}

impl ColumnKernel for PlayDensity {
    type State<S: Scalar<Real = f64>> = PlayStates<S>;

    simulate_with_sensitivities!(0);

    fn shape_names(&self) -> &'static [&'static str] {
        &[]
    }

    fn check(&self, _: &[f64]) -> Result<(), HysteresisError> {
        check_thresholds(&self.knots)
    }

    fn columns(&self) -> usize {
        self.knots.len()
    }

    fn virgin<S: Scalar<Real = f64>>(&self, _: &[S], u: S) -> PlayStates<S> {
        PlayStates::at(self.plays.thresholds.len(), u)
    }

    fn advance<S: Scalar<Real = f64>>(
        &self,
        _: &[S],
        state: &mut PlayStates<S>,
        u: f64,
    ) -> Result<(), HysteresisError> {
        state.advance(self.plays.thresholds.iter().map(|&threshold| S::constant(threshold)), u);
        Ok(())
    }

    fn read<S: Scalar<Real = f64>>(&self, _: &[S], state: &PlayStates<S>, out: &mut [S]) {
        self.plays.sum(&state.plays, out);
    }
}

/// The density in which a fit searches the plays; its models are plays.
#[derive(Debug)]
pub(in crate::hysteresis) struct Density;

/// Knots at distances that grow, up to the largest half-width that the drives may move.
fn knots(count: usize, span: &DriveSpan) -> impl Iterator<Item = f64> {
    // A last column of one play must move.
    let is_one_play = count > MOST_ELEMENTS / 2;
    let reach = if is_one_play { span.reach * count as f64 / (count + 1) as f64 } else { span.reach };
    (1..=count).map(move |index| index as f64 / count as f64).map(move |x| reach * x * (0.35 + 0.65 * x))
}

impl FamilyDescription for Density {
    fn name(&self) -> &'static str {
        "density-of-plays"
    }

    fn summary(&self) -> &'static str {
        "Plays whose weights are a broken line over their half-widths"
    }

    fn equation(&self) -> &'static str {
        "sum of density_j H_j, H_j a mean of plays of half-widths around knot_j"
    }

    fn elements(&self) -> Option<Elements> {
        Some(Elements { usual: 12, most: MOST_ELEMENTS })
    }

    fn weight_name(&self, index: usize) -> String {
        format!("density_{}", index + 1)
    }

    fn weight_reach(&self) -> f64 {
        2.0
    }

    fn shape_numbers(&self, count: usize, span: &DriveSpan) -> Vec<ShapeNumber> {
        let of = |(r, index): (f64, usize)| {
            let (name, meaning) = (format!("knot_{index}"), "half-width at a corner of the density of plays");
            ShapeNumber::new(name, NumberUnit::INPUT, meaning, Search::Held(r))
        };
        knots(count, span).zip(1..).map(of).collect()
    }

    fn starts(&self, count: usize, span: &DriveSpan) -> Vec<Vec<f64>> {
        vec![knots(count, span).collect()]
    }

    fn example(&self, count: usize, span: &DriveSpan) -> Vec<f64> {
        knots(count, span).collect()
    }

    fn is_monotone(&self) -> bool {
        true
    }

    fn is_written_as_plays(&self) -> bool {
        true
    }

    fn as_plays(
        &self,
        _: usize,
        polynomial: &[f64],
        shape: &[f64],
        weights: &[f64],
    ) -> Option<PrandtlIshlinskii> {
        let density = PlayDensity::new(shape);
        let weights = density.play_weights(weights);
        Some(PrandtlIshlinskii {
            polynomial: polynomial.to_vec(),
            thresholds: density.plays.thresholds,
            weights,
        })
    }

    fn runtime(&self, _: usize, _: &mut [f64], shape: &[f64], weights: &[f64], _: f64) -> RuntimeOperator {
        let density = PlayDensity::new(shape);
        let weights = density.play_weights(weights);
        RuntimeOperator::Plays { thresholds: density.plays.thresholds, weights }
    }
}

impl ColumnFamily for Density {
    type Kernel = PlayDensity;

    const FIXED: usize = WHOLE_SHAPE;

    fn kernel(&self, _: usize, shape: &[f64], _: f64) -> PlayDensity {
        PlayDensity::new(shape)
    }

    fn run_columns(
        &self,
        (_, knots, _): (usize, &[f64], f64),
        grid: DriveGrid<'_>,
        u: &[f64],
        start: Start<f64>,
        wanted: Option<&[bool]>,
        out: &mut Columns,
    ) -> Result<(), HysteresisError> {
        Every::new(grid.factor)?;
        out.resize_with_memory(knots.len(), u.len().div_ceil(grid.factor), &[])?;
        PlayDensity::new(knots).plays.run(grid.factor, u, start, wanted.is_some(), out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::HysteresisForm;
    use crate::hysteresis::play_sums::STRETCH;
    use crate::record::range_of;
    use proptest::prelude::*;

    const SPAN: DriveSpan = DriveSpan { stroke: 10.0, ends: [0.0, 10.0], reach: 10.0, ..DriveSpan::UNIT };

    fn drive() -> impl Strategy<Value = Vec<f64>> {
        proptest::collection::vec(0.0..10.0_f64, 2..3 * STRETCH)
    }

    fn start() -> impl Strategy<Value = Start<f64>> {
        let memory = (0.0..10.0_f64, 0.0..10.0_f64);
        prop_oneof![
            memory.prop_map(|(voltage_v, memory)| Start::Remembering { voltage_v, memory }),
            (0.0..10.0_f64).prop_map(|voltage_v| Start::Rest { voltage_v }),
            Just(Start::PERIODIC),
        ]
    }

    fn columns(count: usize, u: &[f64], start: Start<f64>, factor: usize, derivatives: bool) -> Columns {
        let form = HysteresisForm::plays(count).searched();
        let wanted: &[bool] = &[];
        let mut out = Columns::default();
        form.run(&form.example(&SPAN), factor, u, start, derivatives.then_some(wanted), &mut out).unwrap();
        out
    }

    proptest! {
        /// The pass in plain numbers against the operators one move at a time, in numbers with derivatives.
        #[test]
        fn columns_are_those_of_the_operators(
            u in drive(), start in start(), count in 1..20_usize, factor in 1..3_usize,
        ) {
            let kernel = PlayDensity::new(&knots(count, &SPAN).collect::<Vec<_>>());
            let mut exact = crate::hysteresis::ColumnSensitivities::default();
            kernel.simulate_with_sensitivities(&[], factor, &u, start, &mut exact).unwrap();
            let out = columns(count, &u, start, factor, true);
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-12;
            for j in 0..count {
                let [of_value, of_slope] = [out.standing[j], out.standing_by_memory[j]];
                prop_assert!(out.values[j].iter().zip(&exact.columns[j]).all(|(a, b)| close(a + of_value, *b)));
                prop_assert!(close(out.rest[j] + of_value, exact.rest[j]));
                if let Start::Remembering { .. } = start {
                    let at = |of: &[f64], k: usize| of.get(k).copied().unwrap_or(0.0);
                    for k in 0..out.values[j].len() {
                        let [a, b] = [at(&out.by_memory[j], k) + of_slope, at(&exact.d_start[j], k)];
                        prop_assert!(close(a, b), "{a} {b}");
                    }
                    prop_assert!(close(out.rest_by_memory[j] + of_slope, exact.d_start_rest[j]));
                }
            }
        }

        /// A run that keeps what does not depend on the memory is a run anew.
        #[test]
        fn another_memory_changes_what_depends_on_it(
            u in drive(), memories in [0.0..10.0_f64, 0.0..10.0_f64], count in 1..20_usize, factor in 1..3_usize,
        ) {
            let form = HysteresisForm::plays(count).searched();
            let [first, start] = memories.map(|memory| Start::Remembering { voltage_v: u[0], memory });
            let mut out = columns(count, &u, first, factor, true);
            let wanted: &[bool] = &[];
            let shape = form.example(&SPAN);
            let before = out.values.clone();
            form.run_again(&shape, factor, &u, start, Some(wanted), &mut out).unwrap();
            let anew = columns(count, &u, start, factor, true);
            for ((values, before), &changed) in out.values.iter().zip(&before).zip(&out.changed) {
                prop_assert_eq!(&values[changed..], &before[changed..]);
            }
            let samples = u.len().div_ceil(factor);
            prop_assert!(out.changed.len() == count && anew.changed == vec![samples; count]);
            prop_assert_eq!((out.values, out.by_memory), (anew.values, anew.by_memory));
            prop_assert_eq!(out.course, anew.course);
            prop_assert_eq!((out.rest, out.rest_by_memory), (anew.rest, anew.rest_by_memory));
            prop_assert_eq!((out.standing, out.standing_by_memory), (anew.standing, anew.standing_by_memory));
        }

        /// Its models are plays with the same output.
        #[test]
        fn models_are_the_same_plays(
            u in drive(), start in start(), weights in proptest::collection::vec(0.0..1.0_f64, 1..20),
        ) {
            let form = HysteresisForm::plays(weights.len()).searched();
            let model = form.operator(vec![0.7, 0.02], &weights, &form.example(&SPAN)).unwrap();
            prop_assert_eq!(model.form().name(), "prandtl-ishlinskii");
            let mut v = vec![0.0; u.len()];
            model.simulate(&u, start, &mut v).unwrap();
            let columns = columns(weights.len(), &u, start, 1, false);
            for (k, (v, u)) in v.iter().zip(&u).enumerate() {
                let values = columns.values.iter().zip(&columns.standing).map(|(column, rest)| column[k] + rest);
                let sum: f64 = weights.iter().zip(values).map(|(w, value)| w * value).sum();
                prop_assert!((v - (0.7 * u + 0.02 * u * u + sum)).abs() <= 1e-11);
            }
        }
    }

    #[test]
    fn every_column_moves() {
        let u: Vec<f64> = (0..200).map(|k| 5.0 - 5.0 * (0.1 * f64::from(k)).cos()).collect();
        for count in [1, 12, 30, 31, 60] {
            let out = columns(count, &u, Start::Rest { voltage_v: 0.0 }, 1, false);
            for column in &out.values {
                let (low, high) = range_of(column);
                assert!(high - low > 0.05, "{count} columns: {low} to {high}");
            }
        }
    }

    #[test]
    fn a_density_of_equal_weights_by_hand() {
        // Two knots at 1 and 3 V, 30 plays in each interval: ρ = 1/1.95 and 0 … from the second column alone,
        // whose hat rises from 1 to 3 V.
        let density = PlayDensity::new(&[1.0, 3.0]);
        assert_eq!(density.plays.thresholds.len(), 60);
        assert!(
            (density.plays.thresholds[29] - 1.0).abs() < 1e-15
                && (density.plays.thresholds[59] - 3.0).abs() < 1e-15
        );
        let mut sums = [0.0_f64; 2];
        density.plays.sum(&[1.0; 60], &mut sums);
        assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-14));
        // From 0 to 4 V, a play r stands at 4 − r: the mean of the second hat, r = 1 + 2x with density 2x, is
        // 4 − 7/3 to the square of the distance of the plays.
        let plays: Vec<f64> = density.plays.thresholds.iter().map(|r| 4.0 - r).collect();
        density.plays.sum(&plays, &mut sums);
        assert!((sums[1] - (4.0 - 7.0 / 3.0)).abs() < 2e-3, "{sums:?}");
        // The weights of the plays are a broken line over r.
        let weights = density.play_weights(&[0.0, 1.0]);
        assert!((weights[44] / weights[37] - 15.0 / 8.0).abs() < 1e-12);
        assert!(weights[..29].iter().all(|w| *w == 0.0));
    }
}
