//! Normal equations of the linearised fit, record by record.

use nalgebra::{DMatrix, DMatrixView, DVector, RealField};
use rayon::prelude::*;

use super::columns::Freedom;
use super::linearised::Linearised;
use super::records::RecordPeriod;
use hysteron_model::axes::{ScheduledModes, Trajectory, simulate_steady};
use hysteron_numeric::{InstructionSet, LANES, Lanes, TangentNumber};
use hysteron_optimize::Stop;

/// Columns multiplied with all that follow at once.
const PANEL: usize = 4 * LANES;
/// Samples copied at once.
const STRETCH: usize = 512;
/// Preroll in e-folds of the slowest state, for the simulation and for the derivatives.
const FORGOTTEN: f64 = 20.0;
const FADED: f64 = 10.0;
/// Most periods of preroll while a fit runs.
const MOST_PREROLL: usize = 4;

/// Σ w JᵀJ and Σ w Jᵀe over the records, e = y − ŷ, all mean-free.
pub(super) struct NormalEquations {
    pub matrix: DMatrix<f64>,
    pub gradient: DVector<f64>,
    /// Σ σ s of every actuator over the highest level: its stress times the signals (x, u) that its row weighs.
    pub stress: Vec<DVector<f64>>,
}

/// Preroll steps before the scored period, and those of them with derivatives.
fn preroll(model: &ScheduledModes, s: f64, count: usize) -> (usize, usize) {
    let most = MOST_PREROLL * count;
    let compared = model.settling_steps(s, FORGOTTEN).clamp(count.min(most), most);
    (compared, model.settling_steps(s, FADED).min(compared))
}

/// Mean-free residual of a record, interleaved; `None` where the simulation overflows.
pub(super) fn residual(model: &ScheduledModes, piece: &RecordPeriod) -> Option<Vec<f64>> {
    let s = model.state_of(&piece.period);
    let (compared, _) = preroll(model, s, piece.fine.len() / model.inputs);
    let y = simulate_steady(model, s, &piece.fine, compared)?;
    Some(difference(piece, &y))
}

fn difference(piece: &RecordPeriod, y: &[f64]) -> Vec<f64> {
    let mut e: Vec<f64> = piece.period.y.iter().zip(y).map(|(measured, y)| measured - y).collect();
    hysteron_model::axes::remove_means(&mut e, piece.period.outputs);
    e
}

/// Weighted sum of squares over the records, each by its share; infinite where one cannot be simulated.
pub(super) fn cost(model: &ScheduledModes, pieces: &[&RecordPeriod], shares: &[f64]) -> f64 {
    let counted: Vec<(&RecordPeriod, f64)> =
        pieces.iter().zip(shares).filter(|(_, share)| **share > 0.0).map(|(p, s)| (*p, *s)).collect();
    let of = |(piece, share): &(&RecordPeriod, f64)| -> f64 {
        match residual(model, piece) {
            Some(e) => share * piece.weight * e.iter().map(|e| e * e).sum::<f64>(),
            None => f64::INFINITY,
        }
    };
    let costs: Vec<f64> = counted.par_iter().map(of).collect();
    costs.iter().sum()
}

impl NormalEquations {
    fn zeros(count: usize) -> Self {
        Self { matrix: DMatrix::zeros(count, count), gradient: DVector::zeros(count), stress: Vec::new() }
    }
}

/// Adds the products of the base columns of a record, with this weight.
fn add_products(to: &mut DMatrix<f64>, freedom: &Freedom, of_record: &DMatrix<f64>, s: f64, weight: f64) {
    let factor = |scheduled: bool| if scheduled { s } else { 1.0 };
    for (j, b) in freedom.columns.iter().enumerate() {
        let weight = weight * factor(b.scheduled);
        for (i, a) in freedom.columns.iter().enumerate() {
            to[(i, j)] += weight * factor(a.scheduled) * of_record[(a.base, b.base)];
        }
    }
}

/// The normal equations at the model: Jᵀe of all records, JᵀJ of those with a share, each with its weight
/// times its share and in single precision. `None` where a record cannot be simulated, or after a stop.
pub(super) fn normal_equations(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    shares: &[f64],
    stop: &Stop,
) -> Option<NormalEquations> {
    let mut sum = NormalEquations::zeros(freedom.columns.len());
    (sum.gradient, sum.stress) = gradient(model, freedom, pieces, stop)?;
    let ones = vec![1.0; model.outputs];
    let mut room = Room::<f32>::default();
    let (chosen, weights): (Vec<&RecordPeriod>, Vec<f64>) = pieces
        .iter()
        .zip(shares)
        .filter(|(_, share)| **share > 0.0)
        .map(|(piece, share)| (*piece, share * piece.weight))
        .unzip();
    each_record(model, freedom, &chosen, (&mut room, stop), |k, s, products| {
        add_products(&mut sum.matrix, freedom, &products.weighted(&ones), s, weights[k]);
    })?;
    Some(sum)
}

/// The normal equations of all records, and Σ w² Jᵀ diag(`variance`) J with the variances of the outputs of
/// each: both sides of the covariance of the estimates. `None` as for [`normal_equations`].
pub(super) fn information(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    variances: &[Vec<f64>],
    stop: &Stop,
) -> Option<(NormalEquations, DMatrix<f64>)> {
    let count = freedom.columns.len();
    let mut inner = NormalEquations::zeros(count);
    (inner.gradient, inner.stress) = gradient(model, freedom, pieces, stop)?;
    let mut outer = DMatrix::zeros(count, count);
    let ones = vec![1.0; model.outputs];
    let mut room = Room::<f64>::default();
    each_record(model, freedom, pieces, (&mut room, stop), |k, s, products| {
        let weight = pieces[k].weight;
        add_products(&mut inner.matrix, freedom, &products.weighted(&ones), s, weight);
        if let Some(variances) = variances.get(k) {
            add_products(&mut outer, freedom, &products.weighted(variances), s, weight.powi(2));
        }
    })?;
    Some((inner, outer))
}

/// Σ w Jᵀe over the records by the adjoint recursion, and Σ σ s over those of the highest level; `None` where one
/// cannot be simulated, or after a stop.
fn gradient(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    stop: &Stop,
) -> Option<(DVector<f64>, Vec<DVector<f64>>)> {
    let highest = pieces.iter().map(|piece| piece.level).max();
    let of_record = |piece: &&RecordPeriod| {
        if stop.is_requested() {
            return None;
        }
        let s = model.state_of(&piece.period);
        let (compared, faded) = preroll(model, s, piece.fine.len() / model.inputs);
        let trajectory = Trajectory::new(model, s, &piece.fine, compared, faded)?;
        let e = difference(piece, &trajectory.y);
        let linearised = Linearised::<f64>::new(model, s, &trajectory);
        let mut base = linearised.system(model, &trajectory).gradient(&freedom.blocks, &e);
        base.truncate(freedom.dynamic);
        base.extend((0..model.outputs).flat_map(|m| own_gradient(model, freedom, &trajectory, &e, m)));
        let factor = |scheduled: bool| piece.weight * if scheduled { s } else { 1.0 };
        let column = |k: usize, _| base[freedom.columns[k].base] * factor(freedom.columns[k].scheduled);
        let samples = if Some(piece.level) == highest { piece.period.samples() } else { 0 };
        let stress = stress_moments(model, &trajectory, samples);
        Some((DVector::from_fn(freedom.columns.len(), column), stress))
    };
    let all: Vec<_> = pieces.par_iter().with_max_len(1).map(of_record).collect();
    let mut sums = all.into_iter();
    let (mut gradient, mut stress) = sums.next()??;
    for one in sums {
        let (of_record, stress_of_record) = one?;
        gradient += of_record;
        stress.iter_mut().zip(stress_of_record).for_each(|(sum, of)| *sum += of);
    }
    Some((gradient, stress))
}

/// Σ σ s of every actuator over the samples of a record.
fn stress_moments(model: &ScheduledModes, trajectory: &Trajectory, samples: usize) -> Vec<DVector<f64>> {
    let width = model.states() + model.inputs;
    let rows = model.feedback.as_ref().map_or(&[][..], |feedback| &feedback.stress_rows);
    let of_row = |row: &[f64]| {
        let mut sum = DVector::zeros(width);
        for signals in (0..samples).map(|k| &trajectory.at_sample(k, model.steps)[..width]) {
            let sigma: f64 = row.iter().zip(signals).map(|(c, x)| c * x).sum();
            sum.iter_mut().zip(signals).for_each(|(sum, x)| *sum += sigma * x);
        }
        sum
    };
    rows.chunks_exact(width).map(of_row).collect()
}

/// Jᵀe of an output's own parameters.
fn own_gradient(
    model: &ScheduledModes,
    freedom: &Freedom,
    trajectory: &Trajectory,
    e: &[f64],
    output: usize,
) -> Vec<f64> {
    let mut sum = vec![0.0; freedom.own.len()];
    for (k, e) in e.iter().skip(output).step_by(model.outputs).enumerate() {
        let signals = trajectory.at_sample(k, model.steps);
        sum.iter_mut().zip(&freedom.own).for_each(|(sum, &signal)| *sum += e * signals[signal]);
    }
    sum
}

/// Products of the columns of every record in turn, with its place and S. While those of a record are
/// computed, the next is simulated. `None` where a record cannot be simulated, or after a stop.
fn each_record<T: TangentNumber>(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    (room, stop): (&mut Room<T>, &Stop),
    mut add: impl FnMut(usize, f64, &Products<T>),
) -> Option<()> {
    let simulated = |k: usize| {
        let piece = pieces.get(k)?;
        let s = model.state_of(&piece.period);
        let (compared, faded) = preroll(model, s, piece.fine.len() / model.inputs);
        Some((s, Trajectory::new(model, s, &piece.fine, compared, faded)?))
    };
    let mut current = simulated(0);
    for k in 0..pieces.len() {
        let (s, trajectory) = current?;
        let (products, next) = rayon::join(
            || Products::of_record(model, freedom, (&trajectory, s), room, stop),
            || simulated(k + 1),
        );
        add(k, s, &products?);
        current = next;
    }
    Some(())
}

/// Room for the columns of a record, used for one after the other.
#[derive(Default)]
struct Room<T> {
    blocks: Vec<Vec<Lanes<T>>>,
    /// Mean-free columns of each output, sample by sample.
    columns: Vec<Vec<T>>,
}

/// Products of the columns of one record, output by output: dynamic columns, padded to whole blocks, and those
/// of the output's own parameters.
struct Products<T> {
    /// Output, first column, and the product of the panel from there with all columns from there.
    products: Vec<(usize, usize, DMatrix<T>)>,
    /// Dynamic columns, without and with padding.
    dynamic: usize,
    padded: usize,
    /// Columns of an output's own parameters.
    own: usize,
    /// Base columns of all outputs.
    base_columns: usize,
}

impl<T: TangentNumber> Products<T> {
    fn of_record(
        model: &ScheduledModes,
        freedom: &Freedom,
        (trajectory, s): (&Trajectory, f64),
        room: &mut Room<T>,
        stop: &Stop,
    ) -> Option<Self> {
        let outputs = model.outputs;
        let samples = trajectory.y.len() / outputs;
        derivatives(model, freedom, trajectory, s, stop, &mut room.blocks);
        room.blocks.par_iter_mut().flat_map(|block| block.par_chunks_exact_mut(samples)).for_each(|column| {
            hysteron_model::axes::remove_means(column.as_flattened_mut(), LANES);
        });
        let (padded, own) = (room.blocks.len() * LANES, freedom.own.len());
        let width = padded + own;
        room.columns.resize_with(outputs, Vec::new);
        let of_own = own_columns(freedom, trajectory, (samples, model.steps));
        for (m, columns) in room.columns.iter_mut().enumerate() {
            columns.resize(width * samples, T::zero());
            let blocks = &room.blocks;
            columns.par_chunks_mut(width * STRETCH).enumerate().for_each(|(stretch, rows)| {
                for (row, k) in rows.chunks_exact_mut(width).zip(stretch * STRETCH..) {
                    for (to, block) in row.chunks_exact_mut(LANES).zip(blocks) {
                        to.copy_from_slice(&block[m * samples + k]);
                    }
                    row[padded..].copy_from_slice(&of_own[k * own..(k + 1) * own]);
                }
            });
        }
        let panels: Vec<(usize, usize)> =
            (0..width).step_by(PANEL).flat_map(|first| (0..outputs).map(move |m| (m, first))).collect();
        let columns = &room.columns;
        let product = |&(m, first): &(usize, usize)| {
            (m, first, panel_products(&columns[m], width, first, PANEL.min(width - first)))
        };
        let products = panels.par_iter().map(product).collect();
        let (dynamic, base_columns) = (freedom.dynamic, freedom.base_columns(outputs));
        (!stop.is_requested()).then_some(Self { products, dynamic, padded, own, base_columns })
    }

    /// Base column of an output's column; `None` for padding.
    fn place(&self, m: usize, column: usize) -> Option<usize> {
        match column.checked_sub(self.padded) {
            None => (column < self.dynamic).then_some(column),
            Some(own) => Some(self.dynamic + m * self.own + own),
        }
    }

    /// JᵀJ of the base columns, with these weights of the outputs.
    fn weighted(&self, weights: &[f64]) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.base_columns, self.base_columns);
        for (m, first, product) in &self.products {
            let (m, weight) = (*m, weights[*m]);
            for j in 0..product.ncols() {
                let Some(column) = self.place(m, first + j) else { continue };
                for i in 0..product.nrows().min(j + 1) {
                    let Some(row) = self.place(m, first + i) else { continue };
                    let added = weight * product[(i, j)].into();
                    sum[(row, column)] += added;
                    if row != column {
                        sum[(column, row)] += added;
                    }
                }
            }
        }
        sum
    }
}

/// Derivatives of the outputs with respect to the dynamic columns, block by block: outputs · samples lanes
/// each; of no meaning after a stop.
pub(super) fn derivatives<T: TangentNumber>(
    model: &ScheduledModes,
    freedom: &Freedom,
    trajectory: &Trajectory,
    s: f64,
    stop: &Stop,
    blocks: &mut Vec<Vec<Lanes<T>>>,
) {
    let linearised = Linearised::new(model, s, trajectory);
    let system = linearised.system(model, trajectory);
    let set = InstructionSet::detected();
    blocks.resize_with(freedom.blocks.len(), Vec::new);
    blocks.par_iter_mut().zip(&freedom.blocks).for_each(|(out, forcing)| {
        out.resize(trajectory.y.len(), [T::zero(); LANES]);
        if !stop.is_requested() {
            system.run(set, forcing, out);
        }
    });
}

/// Mean-free columns of an output's own parameters, sample by sample: the same for all outputs.
fn own_columns<T: RealField + Copy>(
    freedom: &Freedom,
    trajectory: &Trajectory,
    (samples, steps): (usize, usize),
) -> Vec<T> {
    let mut rows = Vec::with_capacity(freedom.own.len() * samples);
    for k in 0..samples {
        let signals = trajectory.at_sample(k, steps);
        rows.extend(freedom.own.iter().map(|&signal| signals[signal]));
    }
    hysteron_model::axes::remove_means(&mut rows, freedom.own.len());
    rows.into_iter().map(nalgebra::convert::<f64, T>).collect()
}

/// Products of the `height` columns from `first` with all columns from there, of rows of `width` numbers.
fn panel_products<T: RealField + Copy>(rows: &[T], width: usize, first: usize, height: usize) -> DMatrix<T> {
    let (samples, rows) = (rows.len() / width, &rows[first..]);
    let left = DMatrixView::from_slice_with_strides(rows, height, samples, 1, width);
    let right = DMatrixView::from_slice_with_strides(rows, samples, width - first, width, 1);
    let mut product = DMatrix::zeros(height, width - first);
    product.gemm(T::one(), &left, &right, T::zero());
    product
}
