//! A kernel run into the columns of a fit.

use super::super::columns::{ColumnKernel, simulate};
use super::super::outputs::{Columns, look};
use super::super::pass::at_rest;
use super::super::{DriveGrid, HysteresisError};
use crate::start::Start;

/// The first `fixed` numbers of `shape` are the kernel's structure, which no derivative is taken of.
pub(super) fn run<K: ColumnKernel>(
    kernel: &K,
    (shape, fixed): (&[f64], usize),
    grid: DriveGrid<'_>,
    u: &[f64],
    start: Start<f64>,
    wanted: Option<&[bool]>,
    out: &mut Columns,
) -> Result<(), HysteresisError> {
    let factor = grid.factor;
    if factor == 0 {
        return Err(HysteresisError::Factor);
    }
    let own = shape.get(fixed..).unwrap_or_default();
    let count = kernel.columns();
    let samples = u.len().div_ceil(factor);
    let is_wanted = |index: usize| wanted.is_some_and(|wanted| wanted.get(index) == Some(&true));
    let pairs: Vec<(usize, usize)> = (fixed..shape.len())
        .filter(|&index| is_wanted(index))
        .flat_map(|index| (0..count).map(move |column| (index, column)))
        .collect();
    let free = matches!(start, Start::Remembering { .. });
    out.resize(count, samples, &pairs, wanted.is_some() && free)?;
    let mut all = std::mem::take(&mut out.scratch);
    let column = |values: &[f64], index: usize, to: &mut [f64]| {
        to.copy_from_slice(&values[index * samples..(index + 1) * samples]);
    };
    if wanted.is_some() && (free || !pairs.is_empty()) {
        all.stop.clone_from(&out.stop);
        kernel.simulate_with_sensitivities(own, grid, u, start, &mut all)?;
        for partial in &mut out.partials {
            look(out.stop.as_ref())?;
            let index = partial.shape - fixed;
            column(&all.d_shape[index], partial.column, &mut partial.values);
            partial.rest = all.d_shape_rest[index][partial.column];
        }
        for (index, values) in out.by_memory.iter_mut().enumerate() {
            look(out.stop.as_ref())?;
            column(&all.d_start, index, values);
        }
        out.rest.copy_from_slice(&all.rest);
        if free {
            out.rest_by_memory.copy_from_slice(&all.d_start_rest);
        }
    } else {
        all.columns.resize(samples * count, 0.0);
        simulate(kernel, own, grid, u, start, out.stop.as_ref(), &mut all.columns)?;
        match at_rest(start, u)? {
            Some((rest, None)) => kernel.read(own, &kernel.virgin(own, rest), &mut out.rest),
            Some((rest, Some(virgin))) => {
                let mut state = kernel.virgin(own, virgin);
                kernel.step(own, &mut state, rest, &mut out.rest)?;
            }
            None => {}
        }
    }
    for (index, values) in out.values.iter_mut().enumerate() {
        look(out.stop.as_ref())?;
        column(&all.columns, index, values);
    }
    out.scratch = all;
    Ok(())
}
