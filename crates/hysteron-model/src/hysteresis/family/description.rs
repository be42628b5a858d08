//! Description of a family beside the law of its moves.

use std::fmt;
use std::ops::Range;

use super::number::{DriveSpan, ModelNumber, NumberUnit, Place, ShapeNumber};
use super::runtime::RuntimeOperator;
use crate::hysteresis::{Admissibility, PlaySum};
use crate::record::Dependence;

/// Number of elements (plays, states, lines, …) of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Elements {
    /// Default.
    pub usual: usize,
    /// At most.
    pub most: usize,
}

/// Most elements of a family with one weight each.
pub(in crate::hysteresis) const MOST_ELEMENTS: usize = 60;
/// Most intervals of a plane, which has a weight for every pair.
pub(in crate::hysteresis) const MOST_OF_A_PLANE: usize = 16;

/// A family of hysteresis: v = Σ cᵢ uⁱ + Σⱼ wⱼ Hⱼ\[u; θ\], linear in its weights w, with a few shape numbers
/// θ.
///
/// `elements` is the number of plays, states, lines, …, for a family that has such a number; shapes and
/// weights are in the order of [`Self::shape_numbers`] and of the columns.
pub trait FamilyDescription: fmt::Debug + Sync {
    /// Name, as on the command line and in model files.
    fn name(&self) -> &'static str;

    /// The family in a line.
    fn summary(&self) -> &'static str;

    /// Its equations in plain characters, for comments of exported source and the schema of model files; s is
    /// the sign of the move.
    fn equation(&self) -> &'static str;

    /// The model in words, with this number of weights.
    fn title(&self, weights: usize) -> String {
        format!("Hysteresis of the family {} ({weights} weights)", self.name())
    }

    /// Its equations as a report prints them, with the `polynomial` in u.
    fn printed_equations(&self, polynomial: &str) -> Vec<String> {
        let equation = self.equation().replace("<-", "←").replace(" - ", " − ");
        vec![format!("v = {polynomial} + H   ({})", self.name()), format!("H: {equation}")]
    }

    /// Its number of elements; `None` where that is fixed.
    fn elements(&self) -> Option<Elements> {
        None
    }

    /// Number of columns H, and of weights.
    fn columns(&self, elements: usize) -> usize {
        if self.elements().is_some() { elements } else { 1 }
    }

    /// Name of weight `index`.
    fn weight_name(&self, index: usize) -> String {
        format!("weight_{}", index + 1)
    }

    /// Search bound of a weight in a fit, in slopes of the device times the size of its column.
    fn weight_reach(&self) -> f64 {
        10.0
    }

    /// Unit of weight `index`.
    fn weight_unit(&self, index: usize) -> NumberUnit {
        let _ = index;
        NumberUnit::SLOPE
    }

    /// The shape numbers θ; their ranges are those for drives that span `span`.
    fn shape_numbers(&self, elements: usize, span: &DriveSpan) -> Vec<ShapeNumber>;

    /// The numbers of a model beside its polynomial, in the order of a model file.
    fn model_numbers(&self, elements: usize) -> Vec<ModelNumber> {
        let shape = self.shape_numbers(elements, &DriveSpan::UNIT).into_iter().enumerate();
        let shape = shape.map(|(index, ShapeNumber { name, unit, .. })| ModelNumber {
            name,
            unit,
            place: Place::Shape(index),
        });
        let weights = (0..self.columns(elements)).map(|index| ModelNumber {
            name: self.weight_name(index),
            unit: self.weight_unit(index),
            place: Place::Weight(index),
        });
        shape.chain(weights).collect()
    }

    /// The sign s of a weighted column in v.
    fn sign(&self) -> f64 {
        1.0
    }

    /// The shape numbers of a model, from those of the columns.
    fn own_shape(&self, shape: &[f64], weights: &[f64]) -> Vec<f64> {
        let _ = weights;
        shape.to_vec()
    }

    /// The shape numbers of the columns, from those of a model.
    fn column_shape(&self, own_shape: &[f64], weights: &[f64]) -> Vec<f64> {
        let _ = weights;
        own_shape.to_vec()
    }

    /// The shape numbers of a model with `gain` times the output, its weights being `gain` times as large.
    fn scaled_shape(&self, own_shape: &[f64], gain: f64) -> Vec<f64> {
        let _ = gain;
        own_shape.to_vec()
    }

    /// Shapes for a fit to start from.
    fn starts(&self, elements: usize, span: &DriveSpan) -> Vec<Vec<f64>>;

    /// A generic shape within its ranges, for tests.
    fn example(&self, elements: usize, span: &DriveSpan) -> Vec<f64>;

    /// True if every column of a slow drive rises with u and falls with it, so that weights of one sign make
    /// a monotone model.
    fn is_monotone(&self) -> bool {
        false
    }

    /// Property of the drive that the memory depends on; where that is not the order of the samples alone,
    /// the time between them must be known.
    fn depends_on(&self) -> Dependence {
        Dependence::Order
    }

    /// True if it is a plane of relays, which must cover the range a virgin device needs.
    fn is_plane(&self) -> bool {
        false
    }

    /// True if it is compared by default: quick to fit, and unlike the other families compared.
    fn is_compared_unasked(&self) -> bool {
        false
    }

    /// True if it is among the families of which an identification chooses one by held-out error where it is
    /// asked to choose: between them they describe most stacks.
    fn is_chosen_unasked(&self) -> bool {
        false
    }

    /// True if an exponent n among its shape numbers is held unless a fit is asked for it.
    fn has_exponent(&self) -> bool {
        false
    }

    /// True if small loops between turning points of the drive do not close.
    fn small_loops_drift(&self) -> bool {
        false
    }

    /// Clause naming the numbers that loops of one amplitude do not determine.
    fn undetermined_by_one_loop(&self) -> &'static str {
        "the polynomial is distinguished from the hysteretic part only by the shape of one loop"
    }

    /// Indices of the shape numbers that shape the branches of a loop only together with this one (β + γ and
    /// β − γ, say), so that 0 is a legitimate value of each.
    fn shapes_together_with(&self, index: usize) -> Range<usize> {
        index..index + 1
    }

    /// Whether the output is bounded for every drive, where that depends on the numbers of a model.
    fn boundedness(&self, own_shape: &[f64], weights: &[f64]) -> Option<Admissibility> {
        let _ = (own_shape, weights);
        None
    }

    /// Size of a loop of this `range_v` over that at which it saturates, where the shape of a much smaller
    /// one is not determined.
    fn share_of_saturation(&self, own_shape: &[f64], weights: &[f64], range_v: f64) -> Option<f64> {
        let _ = (own_shape, weights, range_v);
        None
    }

    /// True if the memory of a model is an output \[µm\], false if it is the voltage \[V\] at which the
    /// device was virgin before it moved monotonically to rest.
    fn remembers_output(&self) -> bool {
        false
    }

    /// A record's memory in a model's own scale, from that of the columns.
    fn own_memory(&self, memory: f64, weights: &[f64]) -> f64 {
        let _ = weights;
        memory
    }

    /// A record's memory in the scale of the columns, from a model's own.
    fn memory_of_columns(&self, memory: f64, weights: &[f64]) -> f64 {
        let _ = weights;
        memory
    }

    /// Search range for the memory of a record that spans `ends`, in the scale of the columns.
    fn memory_range(&self, [low, high]: [f64; 2], stroke: f64) -> [f64; 2] {
        // A device may have come from beyond the voltages of the record.
        [low - stroke, high + stroke]
    }

    /// Initial estimate of the memory of a record: that of a device that is virgin at its `first` voltage, or
    /// `settled` on loops like those of the record, which spans `ends`.
    fn first_memory(
        &self,
        shape: &[f64],
        first: f64,
        [low, high]: [f64; 2],
        stroke: f64,
        settled: bool,
    ) -> f64 {
        let _ = (shape, stroke);
        if settled { 0.5 * (low + high) } else { first }
    }

    /// Pairs of neighbouring weights of a smooth density in two dimensions.
    fn neighbours(&self, elements: usize) -> Vec<(usize, usize)> {
        let _ = elements;
        Vec::new()
    }

    /// Pairs of neighbouring weights of a smooth density in a row; the last may have the neighbour `None`, of
    /// weight 0.
    fn chain(&self, elements: usize) -> Vec<(usize, Option<usize>)> {
        let _ = elements;
        Vec::new()
    }

    /// By how much a move may push the output back for each volt, in the output's unit per volt, where every
    /// weight is at least 0 and samples are `interval_s` apart or more; `None` where that is not known.
    fn pushes_back(&self, shape: &[f64], weights: &[f64], interval_s: Option<f64>) -> Option<f64> {
        let _ = (shape, weights, interval_s);
        Some(0.0)
    }

    /// True if its models are the equivalent plays: a family for fits alone.
    fn is_written_as_plays(&self) -> bool {
        false
    }

    /// The equivalent polynomial and plays, where they exist.
    fn as_plays(
        &self,
        elements: usize,
        polynomial: &[f64],
        shape: &[f64],
        weights: &[f64],
    ) -> Option<PlaySum> {
        let _ = (elements, polynomial, shape, weights);
        None
    }

    /// The operator of the runtime at this sample rate, from the numbers of a model; its polynomial part is
    /// added to the `polynomial` of the model.
    fn runtime(
        &self,
        elements: usize,
        polynomial: &mut [f64],
        shape: &[f64],
        weights: &[f64],
        sample_rate_hz: f64,
    ) -> RuntimeOperator;
}

/// Neighbours in a row of weights from `from` to below `to`.
pub(in crate::hysteresis) fn in_a_row(
    from: usize,
    to: usize,
) -> impl Iterator<Item = (usize, Option<usize>)> {
    (from + 1..to).map(|i| (i - 1, Some(i)))
}

/// Neighbours of the cells (i, j), j ≤ i < n, of a plane. Those on the diagonal, which are without
/// hysteresis, are neighbours of one another alone.
pub(in crate::hysteresis) fn on_a_plane(n: usize) -> Vec<(usize, usize)> {
    let at = |i: usize, j: usize| i * (i + 1) / 2 + j;
    let beside = |i: usize, j: usize| {
        let next = match i == j {
            true => [(i + 1, j + 1), (n, n)],
            false => [(i + 1, j), if j + 1 < i { (i, j + 1) } else { (n, n) }],
        };
        next.into_iter().filter(|(i, _)| *i < n).map(move |(k, l)| (at(i, j), at(k, l)))
    };
    (0..n).flat_map(|i| (0..=i).flat_map(move |j| beside(i, j).collect::<Vec<_>>())).collect()
}
