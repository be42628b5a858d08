//! Normal equations of the linearised fit, record by record.

use nalgebra::{DMatrix, DMatrixView, DVector};
use rayon::prelude::*;

use super::columns::Freedom;
use super::records::RecordPeriod;
use hysteron_model::axes::{ScheduledModes, Trajectory, simulate_steady};
use hysteron_numeric::{FeedbackTangent, InstructionSet, LANES, Lanes, TangentState};
use hysteron_optimize::Stop;

/// Blocks of columns multiplied at once.
const PANEL: usize = 4;
/// Preroll in e-folds of the slowest state, for the simulation and for the derivatives.
const FORGOTTEN: f64 = 20.0;
const FADED: f64 = 10.0;
/// Most periods of preroll while a fit runs.
const MOST_PREROLL: usize = 4;

/// Σ w JᵀJ and Σ w Jᵀe over the records, e = y − ŷ, all mean-free.
pub(super) struct NormalEquations {
    pub matrix: DMatrix<f64>,
    pub gradient: DVector<f64>,
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

/// Weighted sum of squares over the records; infinite where one cannot be simulated.
pub(super) fn cost(model: &ScheduledModes, pieces: &[&RecordPeriod]) -> f64 {
    let of = |piece: &&RecordPeriod| -> f64 {
        match residual(model, piece) {
            Some(e) => piece.weight * e.iter().map(|e| e * e).sum::<f64>(),
            None => f64::INFINITY,
        }
    };
    let costs: Vec<f64> = pieces.par_iter().map(of).collect();
    costs.iter().sum()
}

impl NormalEquations {
    fn zeros(count: usize) -> Self {
        Self { matrix: DMatrix::zeros(count, count), gradient: DVector::zeros(count) }
    }

    /// Adds those of one record's base columns, with this weight.
    fn add(&mut self, freedom: &Freedom, of_record: &Self, s: f64, weight: f64) {
        let factor = |scheduled: bool| if scheduled { s } else { 1.0 };
        for (j, b) in freedom.columns.iter().enumerate() {
            let weight = weight * factor(b.scheduled);
            for (i, a) in freedom.columns.iter().enumerate() {
                self.matrix[(i, j)] += weight * factor(a.scheduled) * of_record.matrix[(a.base, b.base)];
            }
            self.gradient[j] += weight * of_record.gradient[b.base];
        }
    }
}

/// The normal equations at the model; `None` where a record cannot be simulated, or after a stop.
pub(super) fn normal_equations(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    stop: &Stop,
) -> Option<NormalEquations> {
    let mut sum = NormalEquations::zeros(freedom.columns.len());
    for piece in pieces {
        let s = model.state_of(&piece.period);
        let products = Products::of_record(model, freedom, piece, s, stop)?;
        sum.add(freedom, &products.weighted(&vec![1.0; model.outputs]), s, piece.weight);
    }
    Some(sum)
}

/// The normal equations, and Σ w² Jᵀ diag(`variance`) J with the variances of the outputs of each record:
/// both sides of the covariance of the estimates. `None` as for [`normal_equations`].
pub(super) fn information(
    model: &ScheduledModes,
    freedom: &Freedom,
    pieces: &[&RecordPeriod],
    variances: &[Vec<f64>],
    stop: &Stop,
) -> Option<(NormalEquations, DMatrix<f64>)> {
    let count = freedom.columns.len();
    let (mut inner, mut outer) = (NormalEquations::zeros(count), NormalEquations::zeros(count));
    for (piece, variances) in pieces.iter().zip(variances) {
        let s = model.state_of(&piece.period);
        let products = Products::of_record(model, freedom, piece, s, stop)?;
        inner.add(freedom, &products.weighted(&vec![1.0; model.outputs]), s, piece.weight);
        outer.add(freedom, &products.weighted(variances), s, piece.weight.powi(2));
    }
    Some((inner, outer.matrix))
}

/// Products of the panels of one record, output by output.
struct Products {
    /// Output and the two panels of every product.
    pairs: Vec<(usize, usize, usize)>,
    products: Vec<DMatrix<f64>>,
    /// Panels of dynamic columns.
    dynamic_panels: usize,
    dynamic: usize,
    /// Columns of an output's own parameters.
    own: usize,
    /// Base columns of all outputs.
    base_columns: usize,
}

impl Products {
    fn of_record(
        model: &ScheduledModes,
        freedom: &Freedom,
        piece: &RecordPeriod,
        s: f64,
        stop: &Stop,
    ) -> Option<Self> {
        let (compared, faded) = preroll(model, s, piece.fine.len() / model.inputs);
        let trajectory = Trajectory::new(model, s, &piece.fine, compared, faded)?;
        let e = difference(piece, &trajectory.y);
        let blocks = derivatives(model, freedom, &trajectory, s, stop);
        let (outputs, samples) = (model.outputs, piece.period.samples());
        // Panels of each output: dynamic columns, then the columns of its own parameters and the residual.
        let dynamic: Vec<&[Vec<Lanes>]> = blocks.chunks(PANEL).collect();
        let panels: Vec<Vec<Panel>> = (0..outputs)
            .into_par_iter()
            .map(|m| {
                let mut panels: Vec<Panel> =
                    dynamic.iter().map(|b| Panel::of_blocks(b, m, samples)).collect();
                panels.push(Panel::of_signals(model, freedom, &trajectory, &e, m));
                panels
            })
            .collect();
        let pairs: Vec<(usize, usize, usize)> = (0..outputs)
            .flat_map(|m| {
                let count = panels[m].len();
                (0..count).flat_map(move |a| (a..count).map(move |b| (m, a, b)))
            })
            .collect();
        let products =
            pairs.par_iter().map(|&(m, a, b)| panels[m][a].transposed_times(&panels[m][b])).collect();
        let (dynamic_panels, dynamic, own) = (dynamic.len(), freedom.dynamic, freedom.own.len());
        let base_columns = freedom.base_columns(outputs);
        (!stop.is_requested()).then_some(Self { pairs, products, dynamic_panels, dynamic, own, base_columns })
    }

    /// Base column of a panel's column; `None` for padding and for the residual.
    fn place(&self, m: usize, panel: usize, column: usize) -> Option<usize> {
        if panel < self.dynamic_panels {
            let column = panel * PANEL * LANES + column;
            (column < self.dynamic).then_some(column)
        } else {
            (column < self.own).then_some(self.dynamic + m * self.own + column)
        }
    }

    /// JᵀJ and Jᵀe of the base columns, with these weights of the outputs.
    fn weighted(&self, weights: &[f64]) -> NormalEquations {
        let mut sum = NormalEquations::zeros(self.base_columns);
        for (&(m, a, b), product) in self.pairs.iter().zip(&self.products) {
            let weight = weights[m];
            for j in 0..product.ncols() {
                for i in 0..product.nrows() {
                    let Some(row) = self.place(m, a, i) else { continue };
                    match self.place(m, b, j) {
                        Some(column) => {
                            sum.matrix[(row, column)] += weight * product[(i, j)];
                            if a != b {
                                sum.matrix[(column, row)] += weight * product[(i, j)];
                            }
                        }
                        None if b == self.dynamic_panels && j == self.own => {
                            sum.gradient[row] += weight * product[(i, j)];
                        }
                        None => {}
                    }
                }
            }
        }
        sum
    }
}

/// Derivatives of the outputs with respect to the dynamic columns, block by block: outputs · samples lanes
/// each; zeros after a stop.
pub(super) fn derivatives(
    model: &ScheduledModes,
    freedom: &Freedom,
    trajectory: &Trajectory,
    s: f64,
    stop: &Stop,
) -> Vec<Vec<Lanes>> {
    let at = model.at(s);
    let (n, x) = (model.inputs, model.states());
    let (mut channels, mut weights, mut plays) = (Vec::new(), Vec::new(), 0);
    if let Some(feedback) = &model.feedback {
        channels = [feedback.drive_rows.as_slice(), &feedback.stress_rows].concat();
        plays = feedback.drive.radii.len();
        let powers = feedback.drive.terms() - plays;
        for _ in 0..n {
            weights.extend_from_slice(&feedback.drive.coefficients[powers..]);
        }
        feedback.stress.iter().for_each(|law| weights.extend_from_slice(&law.coefficients[powers..]));
    }
    let system = FeedbackTangent {
        modes: model.modes,
        transition: &at.transition,
        channels: &channels,
        row: x + n,
        weights: &weights,
        plays,
        strain_input: &model.strain_input,
        strains: n,
        output: &at.output,
        strain_feedthrough: &model.strain_feedthrough,
        signals: &trajectory.signals,
        width: trajectory.width,
        slopes: &trajectory.slopes,
        moved: &trajectory.moved,
        before: trajectory.before,
        steps: model.steps,
    };
    let set = InstructionSet::detected();
    let run = |forcing: &Vec<_>| {
        let mut out = vec![[0.0; LANES]; trajectory.y.len()];
        if !stop.is_requested() {
            system.run(set, forcing, &mut TangentState::default(), &mut out);
        }
        out
    };
    freedom.blocks.par_iter().map(run).collect()
}

/// Mean-free columns, sample by sample.
struct Panel {
    rows: Vec<f64>,
    width: usize,
}

impl Panel {
    fn of_blocks(blocks: &[Vec<Lanes>], output: usize, samples: usize) -> Self {
        let width = blocks.len() * LANES;
        let mut rows = vec![0.0; width * samples];
        for (b, block) in blocks.iter().enumerate() {
            let lanes = &block[output * samples..(output + 1) * samples];
            for (row, lanes) in rows.chunks_exact_mut(width).zip(lanes) {
                row[b * LANES..(b + 1) * LANES].copy_from_slice(lanes);
            }
        }
        hysteron_model::axes::remove_means(&mut rows, width);
        Self { rows, width }
    }

    fn of_signals(
        model: &ScheduledModes,
        freedom: &Freedom,
        trajectory: &Trajectory,
        e: &[f64],
        output: usize,
    ) -> Self {
        let width = freedom.own.len() + 1;
        let samples = e.len() / model.outputs;
        let mut rows = Vec::with_capacity(width * samples);
        for k in 0..samples {
            let signals = trajectory.at_sample(k, model.steps);
            rows.extend(freedom.own.iter().map(|&signal| signals[signal]));
            rows.push(e[k * model.outputs + output]);
        }
        hysteron_model::axes::remove_means(&mut rows, width);
        Self { rows, width }
    }

    fn transposed_times(&self, other: &Self) -> DMatrix<f64> {
        let samples = self.rows.len() / self.width;
        let left = DMatrixView::from_slice_with_strides(&self.rows, self.width, samples, 1, self.width);
        let right = DMatrixView::from_slice_with_strides(&other.rows, samples, other.width, other.width, 1);
        let mut product = DMatrix::zeros(self.width, other.width);
        product.gemm(1.0, &left, &right, 0.0);
        product
    }
}
