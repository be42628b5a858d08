//! Output-error problem of the final search.

use super::coordinates::{COUNT, Coordinates};
use super::preparation::PreparedRecord;
use hysteron_model::Start;
use hysteron_model::oscillator::{Drive, Oscillator, OscillatorState, Response};
use hysteron_optimize::{Bounds, Derivative, LeastSquaresProblem, Problem, Range, root_mean_square};

/// Output-error problem over the free coordinates, then y, ẏ and z at the first sample of every record with a
/// free start.
#[derive(Debug)]
pub(super) struct OutputError<'a> {
    pieces: &'a [PreparedRecord],
    drives: &'a [Drive],
    /// Values of held coordinates; the others are searched.
    held: [Option<f64>; COUNT],
    pub searched: Vec<usize>,
    pub size: f64,
    bounds: Bounds,
}

/// Buffers of one evaluation.
#[derive(Debug, Default)]
pub(super) struct Workspace {
    response: Response,
    residual: Vec<f64>,
}

/// Search range of a free start, as a multiple of the largest motion.
const FREE_START: f64 = 3.0;

impl<'a> OutputError<'a> {
    pub(super) fn new(
        (pieces, drives): (&'a [PreparedRecord], &'a [Drive]),
        held: [Option<f64>; COUNT],
        ranges: &[Range; COUNT],
        size: f64,
        linear: [f64; 3],
    ) -> Self {
        let searched: Vec<usize> = (0..COUNT).filter(|&j| held[j].is_none()).collect();
        let mut all: Vec<Range> = searched.iter().map(|&j| ranges[j].clone()).collect();
        let [mass, _, stiffness] = linear;
        for (number, piece) in pieces.iter().enumerate().filter(|(_, p)| p.start_is_free()) {
            let largest =
                FREE_START * piece.y.iter().map(|y| (y - mean(&piece.y)).abs()).fold(size, f64::max);
            let units = [("y", 1.0), ("velocity", (stiffness / mass).sqrt()), ("z", stiffness)];
            all.extend(units.map(|(name, unit)| {
                Range::linear(
                    &format!("{name} at the start of record {}", number + 1),
                    -largest * unit,
                    largest * unit,
                )
            }));
        }
        Self { pieces, drives, held, searched, size, bounds: Bounds { ranges: all } }
    }

    /// The search vector of a start: free states at the measured displacement, at rest and without memory.
    pub(super) fn start(&self, coordinates: &Coordinates) -> Vec<f64> {
        let mut x: Vec<f64> = self.searched.iter().map(|&j| coordinates.0[j]).collect();
        for piece in self.pieces.iter().filter(|p| p.start_is_free()) {
            x.extend([piece.y.first().copied().unwrap_or(0.0) - mean(&piece.y), 0.0, 0.0]);
        }
        x
    }

    pub(super) fn coordinates(&self, x: &[f64]) -> Coordinates {
        let mut all = self.held.map(|held| held.unwrap_or(0.0));
        for (&j, &value) in self.searched.iter().zip(x) {
            all[j] = value;
        }
        Coordinates(all)
    }

    pub(super) fn oscillator(&self, x: &[f64]) -> Oscillator {
        self.coordinates(x).oscillator(self.size)
    }

    /// Start of every record, and the index of its free state in the search vector.
    pub(super) fn starts(&self, x: &[f64]) -> Vec<(Start<OscillatorState>, Option<usize>)> {
        let mut next = self.searched.len();
        let mut free = || {
            let at = next;
            next += 3;
            at
        };
        let start = |piece: &PreparedRecord| match piece.start {
            Start::AsIdentified | Start::Rest { .. } => (Start::AsIdentified, None),
            Start::Settled { .. } => (Start::PERIODIC, None),
            Start::Remembering { .. } => {
                let at = free();
                let value = |i: usize| x.get(at + i).copied().unwrap_or(0.0);
                let state = OscillatorState { y: value(0), velocity: value(1), z: value(2) };
                (state.into(), Some(at))
            }
        };
        self.pieces.iter().map(start).collect()
    }
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Subtracts the mean over the scored samples from `x`; sets the others to 0.
fn centre(x: &mut [f64], scored: &[bool]) {
    let (sum, count) =
        x.iter().zip(scored).filter(|(_, s)| **s).fold((0.0, 0usize), |(a, n), (x, _)| (a + x, n + 1));
    let mean = sum / count.max(1) as f64;
    x.iter_mut().zip(scored).for_each(|(x, &scored)| *x = if scored { *x - mean } else { 0.0 });
}

impl Problem for OutputError<'_> {
    type Workspace = Workspace;

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) -> Workspace {
        Workspace { response: Response::default(), residual: vec![0.0; self.residual_count()] }
    }

    fn cost(&self, x: &[f64], workspace: &mut Workspace) -> f64 {
        let mut residual = std::mem::take(&mut workspace.residual);
        let cost = if self.residuals(x, workspace, &mut residual) {
            root_mean_square(&residual)
        } else {
            f64::INFINITY
        };
        workspace.residual = residual;
        cost
    }
}

impl LeastSquaresProblem for OutputError<'_> {
    fn residual_count(&self) -> usize {
        self.pieces.iter().map(|piece| piece.y.len()).sum()
    }

    fn residuals(&self, x: &[f64], _: &mut Workspace, out: &mut [f64]) -> bool {
        let oscillator = self.oscillator(x);
        let mut rest = out;
        for ((piece, drive), (start, _)) in self.pieces.iter().zip(self.drives).zip(self.starts(x)) {
            let Some((own, behind)) = rest.split_at_mut_checked(piece.y.len()) else { return false };
            rest = behind;
            if oscillator.simulate(drive, start, own).is_err() {
                return false;
            }
            own.iter_mut().zip(&piece.y).for_each(|(r, y)| *r -= y);
            centre(own, &piece.scored);
        }
        true
    }

    fn jacobian(&self, x: &[f64], workspace: &mut Workspace, out: &mut [f64]) -> Derivative {
        let coordinates = self.coordinates(x);
        let (oscillator, of_coordinates) =
            (coordinates.oscillator(self.size), coordinates.derivatives(self.size));
        let count = self.residual_count();
        out.fill(0.0);
        let mut first = 0;
        for ((piece, drive), (start, free)) in self.pieces.iter().zip(self.drives).zip(self.starts(x)) {
            let response = &mut workspace.response;
            if oscillator.simulate_with_sensitivities(drive, start, response).is_err() {
                return Derivative::Infeasible;
            }
            let rows = first..first + piece.y.len();
            first = rows.end;
            for (column, &j) in out.chunks_mut(count).zip(&self.searched) {
                let Some(own) = column.get_mut(rows.clone()) else { return Derivative::Infeasible };
                for (i, partial) in response.partials.iter().take(COUNT).enumerate() {
                    let factor = of_coordinates[(i, j)];
                    if factor != 0.0 {
                        own.iter_mut().zip(partial).for_each(|(d, p)| *d += factor * p);
                    }
                }
                centre(own, &piece.scored);
            }
            for (column, partial) in out
                .chunks_mut(count)
                .skip(free.unwrap_or(usize::MAX))
                .zip(response.partials.iter().skip(COUNT))
            {
                let Some(own) = column.get_mut(rows.clone()) else { return Derivative::Infeasible };
                own.copy_from_slice(partial);
                centre(own, &piece.scored);
            }
        }
        Derivative::Written
    }
}
